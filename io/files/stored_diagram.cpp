#include "stored_diagram.hpp"

#include <algorithm>
#include <array>
#include <ostream>
#include <string>
#include <variant>

#include "../../core/errors.hpp"
#include "../../envelope/whole/cell_finder.hpp"
#include "cell_json.hpp"
#include "scene_json.hpp"

namespace vcell {

namespace {

using Kind = InputError::Kind;

// Whose cell it is, as a base: of a plane, turned to the side that the cell is on.
Object base_of(const Object& object, std::optional<bool> side) {
    const auto* plane = std::get_if<Plane>(&object);
    if (plane == nullptr || side != false) return object;
    return Plane{plane->point, -plane->normal};
}

DiagramScene read_scene(JsonReader& in, double& moved) {
    DiagramScene scene;
    in.object(
        required_member("objects", [&] { read_objects(in, scene.objects, scene.names); }),
        required_member("box", [&] { scene.box = read_box(in); }),
        optional_member("periodic",
                        [&] { in.array_of(3, [&](std::size_t i) { scene.periodic[i] = in.boolean(); }); }),
        optional_member("tilt", [&] { in.array_of(3, [&](std::size_t i) { scene.tilt[i] = in.number(); }); }),
        optional_member("moved", [&] { moved = in.number(); }),
        optional_member("units", [&] { scene.units = in.string(); }),
        optional_member("tolerance", [&] { scene.tolerance = in.number(); }),
        optional_member("probe", [&] { scene.probe = in.number(); }));
    return scene;
}

void write_members(JsonWriter& out, const DiagramScene& scene, std::optional<double> moved) {
    std::size_t i = 0;
    out.line_key("objects").lines(scene.objects, [&](const Object& object) {
        write_object(out, object, i < scene.names.size() ? scene.names[i] : std::string());
        ++i;
    });
    out.line_key("box").object([&] {
        out.key("min").value(scene.box.min);
        out.key("max").value(scene.box.max);
    });
    if (scene.is_periodic()) {
        out.key("periodic").value(scene.periodic);
        if (scene.tilt != std::array{0.0, 0.0, 0.0}) out.key("tilt").value(scene.tilt);
        if (moved) out.key("moved").value(*moved);
    }
    out.key("units").value(scene.units);
    if (scene.tolerance) out.key("tolerance").value(*scene.tolerance);
    if (scene.probe) out.key("probe").value(*scene.probe);
}

// Sites are images along axes along which the box repeats.
void require_images(const StoredDiagram& diagram) {
    for (std::size_t i = 0; i < diagram.cells.size(); ++i)
        for (const ObjectImage& object : diagram.cells[i].second.scene.images)
            for (std::size_t k = 0; k < 3; ++k)
                if (object.image[k] != 0 && !diagram.scene.periodic[k])
                    throw InputError(Kind::OutOfRange, InputError::no_object,
                                     "cells[" + std::to_string(i) + "]",
                                     "names " + to_string(object) +
                                         ", an image along an axis along which the box does not repeat");
}

}  // namespace

DiagramWriter::DiagramWriter(std::ostream& out, const DiagramScene& scene)
    : out_(out),
      writer_(out),
      objects_(scene.objects),
      repeats_(scene.is_periodic()),
      is_added_(scene.objects.size(), false) {
    whole::validate_diagram(scene);
    DiagramScene decided = scene;
    const double moved = whole::snap_to_grid(decided);
    writer_.begin_object();
    writer_.key("vcell").value(format_version);
    writer_.line_key("diagram").object([&] { write_members(writer_, decided, moved); });
    writer_.line_key("cells");
    writer_.begin_array();
}

void DiagramWriter::add(std::uint32_t object, const Cell& cell) {
    is_added_[object] = true;
    std::optional<bool> side;
    if (std::holds_alternative<Plane>(objects_[object])) side = cell.scene.base == objects_[object];
    std::optional<Box> box;
    if (repeats_ && !std::holds_alternative<Sphere>(objects_[object])) box = cell.scene.box;
    write_cell_of_diagram(writer_, object, side, box, cell);
}

void DiagramWriter::finish(const VoronoiDiagram& diagram) {
    writer_.end_array();
    std::vector<StoredDiagram::Lacking> lacking;
    for (std::uint32_t i = 0; i < diagram.cells.size(); ++i) {
        const DiagramCell& cell = diagram.cells[i];
        if (cell.state == DiagramCell::State::Undecided || cell.state == DiagramCell::State::Refused)
            lacking.push_back({i, cell.reason});
        else if (cell.state == DiagramCell::State::Computed && !is_added_[i])
            lacking.push_back({i, "is measured, but has no faces"});
    }
    if (!lacking.empty())
        writer_.line_key("lacking").lines(lacking, [&](const StoredDiagram::Lacking& l) {
            writer_.object([&] {
                writer_.key("object").value(l.object);
                writer_.key("reason").value(l.reason);
            });
        });
    writer_.end_object();
    writer_.finish();
    out_ << '\n';
}

void write_diagram_scene(std::ostream& out, const DiagramScene& scene) {
    JsonWriter writer(out);
    writer.object([&] {
        writer.key("vcell").value(format_version);
        write_members(writer, scene, std::nullopt);
    });
    writer.finish();
    out << '\n';
}

std::optional<StoredDiagram> parse_diagram(std::string_view text) {
    StoredDiagram diagram;
    std::vector<std::optional<bool>> sides;
    std::vector<std::optional<Box>> boxes;
    bool is_diagram = false;
    JsonReader in(text);
    try {
        in.object(
            required_member("vcell", [&] { read_format_version(in); }),
            required_member("diagram",
                            [&] {
                                is_diagram = true;
                                diagram.scene = read_scene(in, diagram.moved);
                            }),
            required_member(
                "cells",
                [&] {
                    in.array([&](std::size_t i) {
                        CellOfDiagram read = read_cell_of_diagram(in);
                        if (i > 0 && !(diagram.cells.back().first < read.object ||
                                       (diagram.cells.back().first == read.object && sides.back() == true &&
                                        read.side == false)))
                            in.fail(
                                Kind::OutOfRange,
                                "must be of a later object than the cell before, or on a plane's other side");
                        diagram.cells.emplace_back(read.object, std::move(read.cell));
                        sides.push_back(read.side);
                        boxes.push_back(read.box);
                    });
                }),
            optional_member("lacking", [&] {
                in.array([&](std::size_t i) {
                    StoredDiagram::Lacking read{};
                    in.object(required_member("object",
                                              [&] {
                                                  read.object = static_cast<std::uint32_t>(
                                                      in.unsigned_integer(UINT32_MAX));
                                              }),
                              required_member("reason", [&] { read.reason = in.string(); }));
                    if (i > 0 && !(diagram.lacking.back().object < read.object))
                        in.fail(Kind::OutOfRange, "must be of a later object than the one before");
                    diagram.lacking.push_back(std::move(read));
                });
            }));
    } catch (const InputError&) {
        if (is_diagram) throw;
        return std::nullopt;
    }
    in.end();
    whole::validate_diagram(diagram.scene);
    require_images(diagram);
    const auto fail = [](const char* what) {
        throw InputError(Kind::OutOfRange, InputError::no_object, "cells", what);
    };
    if (!diagram.lacking.empty() && diagram.lacking.back().object >= diagram.scene.objects.size())
        throw InputError(Kind::OutOfRange, InputError::no_object, "lacking", "names what is no object");
    for (std::size_t i = 0; i < sides.size(); ++i) {
        auto& [object, cell] = diagram.cells[i];
        if (object >= diagram.scene.objects.size() || is_vessel(diagram.scene.objects[object]))
            fail("has a cell of no ball, plane or tube");
        const Object& whose = diagram.scene.objects[object];
        if (std::holds_alternative<Plane>(whose) != sides[i].has_value())
            fail("has a cell of a plane without its side, or one with a side of what is none");
        if (boxes[i] && (!diagram.scene.is_periodic() || std::holds_alternative<Sphere>(whose)))
            fail("has a box of a ball, or of what is in a box that does not repeat");
        cell.scene.box = boxes[i].value_or(diagram.scene.box);
        cell.scene.base = base_of(whose, sides[i]);
        cell.scene.probe = diagram.scene.probe;
    }
    return diagram;
}

}  // namespace vcell
