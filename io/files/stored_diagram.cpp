#include "stored_diagram.hpp"

#include <ostream>
#include <variant>

#include "../../core/errors.hpp"
#include "cell_json.hpp"
#include "scene_json.hpp"

namespace vcell {

namespace {

using Kind = InputError::Kind;

[[noreturn]] void fail_unsupported(const std::string& path, const char* what) {
    throw InputError(Kind::Unsupported, InputError::no_object, path, what);
}

void require_balls(const DiagramScene& scene) {
    if (scene.is_periodic()) fail_unsupported("periodic", "is of no diagram that is written as a file");
    if (scene.probe) fail_unsupported("probe", "is of no diagram that is written as a file");
    if (scene.objects.empty()) fail_unsupported("objects", "must not be empty");
    for (std::size_t i = 0; i < scene.objects.size(); ++i)
        if (!std::holds_alternative<Sphere>(scene.objects[i]))
            fail_unsupported("objects[" + std::to_string(i) + "]",
                             "is no ball: only diagrams of balls are written as files");
}

DiagramScene read_scene(JsonReader& in) {
    DiagramScene scene;
    in.object(required_member("objects", [&] { read_objects(in, scene.objects, scene.names); }),
              required_member("box", [&] { scene.box = read_box(in); }),
              optional_member("units", [&] { scene.units = in.string(); }),
              optional_member("tolerance", [&] { scene.tolerance = in.number(); }));
    return scene;
}

// Any ball's scene: what is wrong with one is wrong with all.
void validate_as_scene(const DiagramScene& diagram) {
    Scene scene;
    scene.base = diagram.objects.front();
    scene.objects = diagram.objects;
    scene.box = diagram.box;
    scene.tolerance = diagram.tolerance;
    validate(scene);
}

}  // namespace

DiagramWriter::DiagramWriter(std::ostream& out, const DiagramScene& scene) : out_(out), writer_(out) {
    require_balls(scene);
    writer_.begin_object();
    writer_.key("vcell").value(format_version);
    writer_.line_key("diagram").object([&] {
        writer_.line_key("objects").array([&] {
            for (std::size_t i = 0; i < scene.objects.size(); ++i) {
                const auto& ball = std::get<Sphere>(scene.objects[i]);
                writer_.object([&] {
                    writer_.line_key("sphere").object([&] {
                        writer_.key("center").value(ball.center);
                        writer_.key("radius").value(ball.radius);
                    });
                    if (i < scene.names.size() && !scene.names[i].empty())
                        writer_.key("name").value(scene.names[i]);
                });
            }
        });
        writer_.line_key("box").object([&] {
            writer_.key("min").value(scene.box.min);
            writer_.key("max").value(scene.box.max);
        });
        writer_.key("units").value(scene.units);
        if (scene.tolerance) writer_.key("tolerance").value(*scene.tolerance);
    });
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
                                      diagram.scene = read_scene(in);
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
    validate_as_scene(diagram.scene);
    const std::size_t count = diagram.scene.objects.size();
    for (const auto& [object, cell] : diagram.cells)
        if (object >= count)
            throw InputError(Kind::OutOfRange, InputError::no_object, "cells", "has a cell of no object");
    return diagram;
}

}  // namespace vcell
