/// Scenes of whole diagrams, and the tables that are made of them.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <iosfwd>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "../../envelope/voronoi_diagram.hpp"
#include "ball_file.hpp"

namespace vcell {

/// What a scene file may leave open.
struct DiagramSceneOptions {
    /// Of files of balls, in place of what they say; default: as TextSceneOptions::box.
    std::optional<Box> box;
    std::optional<std::array<bool, 3>> periodic;
    std::optional<std::array<double, 3>> tilt;
    std::optional<double> probe;
    BallFileOptions files;
};

/// JSON, text or a file of another program (ball_file.hpp), by what it begins with. JSON has the keys of a
/// scene; "base" may be missing, and is an object like the others otherwise, the last one (unless it is among
/// them, "base_object"); objects may have a "group", and the box may repeat: "periodic": [true, true, false],
/// "tilt": [xy, xz, yz]; cells may end: "probe": 1.4. A line of text is `x y z r [name [group]]`. Throws
/// InputError with the path or line of what is wrong; objects are validated by voronoi_diagram().
DiagramScene parse_diagram_scene(std::string_view text, const DiagramSceneOptions& options = {});

/// parse_diagram_scene of a file, of standard input for "-". Throws ReadError, InputError.
DiagramScene read_diagram_scene(const std::string& path, const DiagramSceneOptions& options = {});

// Tables: a header, then a line each, separated by tabs; numbers with the digits that read back to the same
// doubles;
// `-` where there is none. Errors are bounds, estimates where the column `estimated` says 1.

/// object name group state volume volume_error area area_error exposed_area exposed_error neighbors
/// min_clearance max_clearance touches_box estimated candidates body_volume body_error reason
void write_cell_table(std::ostream& out, const DiagramScene& scene, const VoronoiDiagram& diagram);

/// first second image name1 name2 faces area area_error distance nx ny nz: the distance of the surfaces, and
/// between balls the unit vector from the first centre to the second. A pair of neighbours has one line;
/// second is a side of the box or an object of no lower number, moved by `image` edges of the box ("0,0,0").
void write_contact_table(std::ostream& out, const DiagramScene& scene, const ContactTable& table);

// The same in parts.

/// The header of a table of moments: object name group, and the columns of a cell's (cell_tables.hpp).
void write_moment_header(std::ostream& out);
/// The line of an object's cell.
void write_moment_row(std::ostream& out, const DiagramScene& scene, std::uint32_t object,
                      const Moments& moments);

void write_cell_header(std::ostream& out);
/// Of the cells of the objects first, first + 1, ...; names and groups of the scene are those of these
/// objects.
void write_cell_rows(std::ostream& out, const DiagramScene& scene, std::span<const DiagramCell> cells,
                     std::uint32_t first);
void write_contact_header(std::ostream& out);
/// Objects and names of the scene are where place(number) says.
void write_contact_rows(std::ostream& out, const DiagramScene& scene,
                        const std::function<std::size_t(std::uint32_t)>& place,
                        std::span<const Contact> contacts);

/// group cells undecided volume volume_error area area_error exposed_area exposed_error neighbors: the cells
/// of a group as one, its area being what it shares with other groups (set Voronoi cells), its exposed area
/// that of all of its cells, as no cell begins where one ends at a probe; neighbors, other groups, separated
/// by commas. Objects without a group are groups of their own, named by their numbers.
void write_group_table(std::ostream& out, const DiagramScene& scene, const VoronoiDiagram& diagram,
                       const ContactTable& table);

/// first second contacts area area_error: what each pair of groups shares, by how many pairs of objects.
/// Groups are called as in the table above, and come in the order of their first contacts.
void write_group_contacts(std::ostream& out, const DiagramScene& scene, const ContactTable& table);

}  // namespace vcell
