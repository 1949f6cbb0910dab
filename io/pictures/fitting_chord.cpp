#include "fitting_chord.hpp"

#include <algorithm>
#include <optional>

namespace vcell {

std::vector<double> growing_chords(double chord) {
    // A curved face takes more triangles with a finer one than anyone may ask for.
    constexpr double least_grown = 0x1p-32;
    std::vector<double> chords{chord};
    while (chords.back() < 1) chords.push_back(std::clamp(chord_step * chords.back(), least_grown, 1.0));
    return chords;
}

FittingChord::FittingChord(const DiagramScene& scene, std::span<const double> chords,
                           std::size_t most_triangles)
    : most_triangles_(most_triangles) {
    for (const double chord : chords)
        levels_.push_back({chord, 0, std::make_unique<ConformingMeshes>(scene, chord)});
}

bool FittingChord::add(std::uint32_t object, const Cell& cell) {
    for (Level& level : levels_) {
        if (!level.meshes) continue;
        const std::size_t left = level.chord < 1 ? most_triangles_ - level.triangles : SIZE_MAX;
        if (const std::optional<CellMesh> mesh = level.meshes->add_within(object, cell, left))
            level.triangles += mesh->triangles.size();
        else
            level.meshes.reset();
    }
    while (levels_.size() > 1 && !levels_.front().meshes) levels_.erase(levels_.begin());
    return levels_.front().meshes != nullptr;
}

}  // namespace vcell
