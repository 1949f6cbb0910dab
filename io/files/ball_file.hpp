/// Files of balls that other programs write: PDB, mmCIF, XYZ and extended XYZ, LAMMPS dumps.
///
/// Nothing is passed over that is not known to be of no account: what is not understood is named by its line.
#pragma once

#include <array>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "../../primitives/objects/objects.hpp"
#include "../../primitives/objects/scene.hpp"

namespace vcell {

/// What a file of balls leaves open; docs/files.md, "Files of other programs".
struct BallFileOptions {
    enum class Group { Residue, Chain };

    /// Of a file with several models, frames or timesteps the one to read, counted from 0; default: the
    /// first.
    std::optional<std::size_t> frame;
    /// Radii by element, species or type, in place of the table's. Where a file gives radii itself it is
    /// right.
    std::map<std::string, double> radii;
    // PDB and mmCIF
    bool has_hydrogens = false;  ///< hydrogens are read, too
    bool leaves_water = false;   ///< water is not read
    bool leaves_hetero = false;  ///< HETATM atoms, water among them, are not read
    std::optional<Group> group;  ///< what DiagramScene::groups say; default: Residue
};

/// Balls, and what their file says of the box around them.
struct BallFile {
    std::vector<Sphere> balls;
    std::vector<std::string> names, groups;  ///< empty, or one for each ball
    std::optional<Box> box;
    std::array<bool, 3> periodic{false, false, false};
    std::array<double, 3> tilt{0, 0, 0};  ///< as DiagramScene::tilt
    std::string units;                    ///< empty: the file does not say
};

/// The balls of a text in one of the formats, by what it begins with; none where it is in no such format.
/// Throws InputError with the line of what is wrong, and with an option's name for options that the format
/// has no use for.
std::optional<BallFile> parse_ball_file(std::string_view text, const BallFileOptions& options = {});

// The formats one by one. Pre: the text is meant to be in it. Errors as above.

/// Atoms of a PDB entry: ATOM and HETATM records of one model, by columns. Of atoms at several alternate
/// locations the first of their residue's.
BallFile parse_pdb(std::string_view text, const BallFileOptions& options = {});
/// The same of the category atom_site of an mmCIF file's first data block.
BallFile parse_mmcif(std::string_view text, const BallFileOptions& options = {});
/// XYZ, with the keys Lattice, Origin, pbc and Properties of its extended form in the second line.
BallFile parse_xyz(std::string_view text, const BallFileOptions& options = {});
/// A text dump of LAMMPS.
BallFile parse_lammps_dump(std::string_view text, const BallFileOptions& options = {});

}  // namespace vcell
