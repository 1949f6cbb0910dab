/// How coarse the meshes of a diagram's cells have to be to have no more than so many triangles.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "conforming_meshes.hpp"

namespace vcell {

/// A chord, a part of cells' diagonals, and what it grows to by chord_step where it is too fine, up to a
/// whole diagonal, with which only cells' edges ask for triangles.
std::vector<double> growing_chords(double chord);

/// The first of some chords with which all cells together have no more triangles than a bound, found before
/// any mesh is kept: each cell is drawn with all of them, and a chord with which there are too many is given
/// up, but for one of a whole diagonal: how many triangles cells' edges ask for is counted to the end.
class FittingChord {
public:
    /// Pre: there are chords, all > 0. Throws as ConformingMeshes().
    FittingChord(const DiagramScene& scene, std::span<const double> chords, std::size_t most_triangles);

    /// Counts a cell's triangles; cells come as ConformingMeshes::add() wants them. False where all chords
    /// have been given up.
    bool add(std::uint32_t object, const Cell& cell);

    /// After the last cell: the chord that fits, or the last one.
    double chord() const { return levels_.front().chord; }
    /// How many there are with that chord, unless it has been given up.
    std::size_t triangles() const { return levels_.front().triangles; }

private:
    struct Level {
        double chord;
        std::size_t triangles;
        std::unique_ptr<ConformingMeshes> meshes;  // null: given up
    };
    std::size_t most_triangles_;
    std::vector<Level> levels_;  // the first one has not been given up, or is the last one
};

}  // namespace vcell
