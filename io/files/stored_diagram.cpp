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

[[noreturn]] void fail_unsupported(const std::string& path, const char* what) {
    throw InputError(Kind::Unsupported, InputError::no_object, path, what);
}

bool is_ball(const Object& object) { return std::holds_alternative<Sphere>(object); }

void require_balls(const DiagramScene& scene) {
    if (scene.probe) fail_unsupported("probe", "is of no diagram that is written as a file");
    if (!scene.objects.empty() && std::ranges::none_of(scene.objects, is_ball))
        fail_unsupported("objects", "are no balls: only the cells of balls are written as files");
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
        optional_member("tolerance", [&] { scene.tolerance = in.number(); }));
    return scene;
}

void write_scene(JsonWriter& out, const DiagramScene& scene, double moved) {
    out.object([&] {
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
            out.key("moved").value(moved);
        }
        out.key("units").value(scene.units);
        if (scene.tolerance) out.key("tolerance").value(*scene.tolerance);
    });
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

DiagramWriter::DiagramWriter(std::ostream& out, const DiagramScene& scene) : out_(out), writer_(out) {
    require_balls(scene);
    whole::validate_diagram(scene);
    DiagramScene decided = scene;
    const double moved = whole::snap_to_grid(decided);
    writer_.begin_object();
    writer_.key("vcell").value(format_version);
    write_scene(writer_.line_key("diagram"), decided, moved);
    writer_.line_key("cells");
    writer_.begin_array();
}

void DiagramWriter::add(std::uint32_t object, const Cell& cell) {
    write_cell_of_diagram(writer_, object, cell);
}

void DiagramWriter::finish() {
    writer_.end_array();
    writer_.end_object();
    writer_.finish();
    out_ << '\n';
}

std::optional<StoredDiagram> parse_diagram(std::string_view text) {
    StoredDiagram diagram;
    bool is_diagram = false;
    JsonReader in(text);
    try {
        in.object(required_member("vcell", [&] { read_format_version(in); }),
                  required_member("diagram",
                                  [&] {
                                      is_diagram = true;
                                      diagram.scene = read_scene(in, diagram.moved);
                                  }),
                  required_member("cells", [&] {
                      in.array([&](std::size_t i) {
                          diagram.cells.push_back(read_cell_of_diagram(in));
                          if (i > 0 && diagram.cells[i - 1].first >= diagram.cells[i].first)
                              in.fail(Kind::OutOfRange, "must be of a later object than the cell before");
                      });
                  }));
    } catch (const InputError&) {
        if (is_diagram) throw;
        return std::nullopt;
    }
    in.end();
    require_balls(diagram.scene);
    whole::validate_diagram(diagram.scene);
    require_images(diagram);
    const std::size_t count = diagram.scene.objects.size();
    for (const auto& [object, cell] : diagram.cells)
        if (object >= count || !is_ball(diagram.scene.objects[object]))
            throw InputError(Kind::OutOfRange, InputError::no_object, "cells", "has a cell of no ball");
    return diagram;
}

}  // namespace vcell
