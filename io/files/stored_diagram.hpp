/// Diagrams as files: the objects, and the cells of balls, and of planes and tubes so far as they are
/// complete (DiagramOptions::complete), with their elements (docs/files.md, "Scenes of whole diagrams").
#pragma once

#include <iosfwd>
#include <optional>
#include <string_view>
#include <vector>

#include "../check/check_diagram.hpp"
#include "json_writer.hpp"

namespace vcell {

/// Writes the file as its cells are computed: add() is made for DiagramOptions::visit.
class DiagramWriter {
public:
    /// Throws as voronoi_diagram(). What repeats is written as it was decided about: moved to its binary
    /// grid.
    DiagramWriter(std::ostream& out, const DiagramScene& scene);

    /// Adds an object's cell. A plane has two: the one to which its normal points comes first.
    void add(std::uint32_t object, const Cell& cell);
    /// Ends with what the diagram has no cells of: objects whose cells were refused, undecided, or not added.
    void finish(const VoronoiDiagram& diagram);

private:
    std::ostream& out_;
    JsonWriter writer_;
    std::vector<Object> objects_;
    bool repeats_;
    std::vector<bool> is_added_;
};

/// The scene alone, as read_diagram_scene() reads it; groups are left out.
void write_diagram_scene(std::ostream& out, const DiagramScene& scene);

/// None if the text is no diagram. Throws InputError with the JSON path of the first offender.
std::optional<StoredDiagram> parse_diagram(std::string_view text);

}  // namespace vcell
