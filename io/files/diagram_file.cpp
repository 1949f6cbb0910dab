#include "diagram_file.hpp"

#include <fmt/format.h>
#include <fmt/ostream.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <ostream>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "../../core/errors.hpp"
#include "cell_tables.hpp"
#include "files.hpp"
#include "scene_json.hpp"
#include "text.hpp"

namespace vcell {

namespace {

// ---- Scenes -----------------------------------------------------------------------------------------

void pad(std::vector<std::string>& texts, std::size_t count) {
    if (!texts.empty()) texts.resize(count);
}

/// What repeats is told by a file's box or the user's: room about the balls would repeat with them.
Box box_of(const std::optional<Box>& told, std::span<const Sphere> balls,
           const DiagramSceneOptions& options) {
    if (told) return *told;
    if (options.periodic && std::ranges::find(*options.periodic, true) != options.periodic->end())
        throw InputError(InputError::Kind::MissingKey, InputError::no_object, "--box",
                         "missing: balls do not tell the box that repeats");
    return default_box(balls, std::nullopt);
}

DiagramScene parse_text(std::string_view text, const DiagramSceneOptions& options) {
    DiagramScene scene;
    std::vector<Sphere> balls;
    read_ball_lines(text, "x y z r [name [group]]", 2,
                    [&](const Sphere& ball, std::span<const std::string_view> words) {
                        const std::array<std::vector<std::string>*, 2> texts{&scene.names, &scene.groups};
                        for (std::size_t k = 0; k < words.size(); ++k) {
                            texts[k]->resize(balls.size());
                            texts[k]->emplace_back(words[k]);
                        }
                        balls.push_back(ball);
                    });
    pad(scene.names, balls.size());
    pad(scene.groups, balls.size());
    scene.box = box_of(options.box, balls, options);
    scene.objects.assign(balls.begin(), balls.end());
    return scene;
}

DiagramScene scene_of(BallFile file, const DiagramSceneOptions& options) {
    DiagramScene scene;
    scene.names = std::move(file.names);
    scene.groups = std::move(file.groups);
    scene.periodic = file.periodic;
    scene.tilt = file.tilt;
    if (!file.units.empty()) scene.units = file.units;
    scene.box = box_of(options.box ? options.box : file.box, file.balls, options);
    scene.objects.assign(file.balls.begin(), file.balls.end());
    return scene;
}

DiagramScene parse_json(std::string_view text) {
    JsonReader in(text);
    DiagramScene scene;
    std::optional<Object> base;
    std::string base_name, base_group;
    std::optional<std::uint32_t> base_object;
    in.object(
        required_member("vcell", [&] { read_format_version(in); }),
        optional_member("base", [&] { base = read_object(in, base_name, &base_group); }),
        required_member("objects", [&] { read_objects(in, scene.objects, scene.names, &scene.groups); }),
        optional_member(
            "base_object",
            [&] { base_object = static_cast<std::uint32_t>(in.unsigned_integer(UINT32_MAX - 1)); }),
        required_member("box", [&] { scene.box = read_box(in); }),
        optional_member("periodic",
                        [&] { in.array_of(3, [&](std::size_t i) { scene.periodic[i] = in.boolean(); }); }),
        optional_member("tilt", [&] { in.array_of(3, [&](std::size_t i) { scene.tilt[i] = in.number(); }); }),
        optional_member("probe", [&] { scene.probe = in.number(); }),
        optional_member("units", [&] { scene.units = in.string(); }),
        optional_member("tolerance", [&] { scene.tolerance = in.number(); }));
    in.end();
    if (base_object) {
        const auto fail = [](const std::string& what) {
            throw InputError(InputError::Kind::OutOfRange, InputError::no_object, "base_object", what);
        };
        if (*base_object >= scene.objects.size())
            fail(fmt::format("must be less than the number of objects, {}, is {}", scene.objects.size(),
                             *base_object));
        if (base && scene.objects[*base_object] != *base)
            fail(fmt::format("objects[{}] is not the base", *base_object));
    } else if (base) {
        const auto append = [&](std::vector<std::string>& texts, std::string last) {
            if (texts.empty() && last.empty()) return;
            texts.resize(scene.objects.size());
            texts.push_back(std::move(last));
        };
        append(scene.names, std::move(base_name));
        append(scene.groups, std::move(base_group));
        scene.objects.push_back(*std::move(base));
    }
    return scene;
}

// ---- Tables -----------------------------------------------------------------------------------------

const char* word(DiagramCell::State state) {
    switch (state) {
        case DiagramCell::State::Computed: return "computed";
        case DiagramCell::State::Empty: return "empty";
        case DiagramCell::State::Undecided: return "undecided";
        case DiagramCell::State::Wall: return "wall";
        case DiagramCell::State::Refused: return "refused";
    }
    return "";
}

// Fit for a column: without what separates them.
std::string column(const std::vector<std::string>& texts, std::size_t i) {
    if (i >= texts.size() || texts[i].empty()) return "-";
    std::string text = texts[i];
    std::ranges::replace_if(
        text, [](char c) { return c == '\t' || c == '\n' || c == '\r'; }, ' ');
    return text;
}

std::string number(double x) { return std::isfinite(x) ? fmt::format("{}", x) : "-"; }

// The names of the groups, by which they are told apart: an object without a group is one of its own, called
// by its number, or, where a group has that name, by `object` and its number.
class GroupNames {
public:
    explicit GroupNames(const DiagramScene& scene) : scene_(scene) {
        for (std::size_t i = 0; i < scene.groups.size(); ++i) names_.insert(column(scene.groups, i));
    }
    std::string operator[](std::uint32_t i) const {
        std::string group = column(scene_.groups, i);
        if (group != "-") return group;
        group = std::to_string(i);
        return names_.contains(group) ? "object " + group : group;
    }

private:
    const DiagramScene& scene_;
    std::set<std::string> names_;
};

}  // namespace

DiagramScene parse_diagram_scene(std::string_view text, const DiagramSceneOptions& options) {
    text = without_byte_order_mark(text);
    DiagramScene scene;
    if (std::optional<BallFile> file = parse_ball_file(text, options.files)) {
        scene = scene_of(*std::move(file), options);
    } else if (is_plain_text(text)) {
        scene = parse_text(text, options);
    } else {
        refuse_foreign_format(text);
        if (options.box)
            throw InputError(InputError::Kind::Unsupported, InputError::no_object, "--box",
                             "is for files of balls, this scene is JSON");
        scene = parse_json(text);
    }
    if (options.periodic) scene.periodic = *options.periodic;
    if (options.tilt) scene.tilt = *options.tilt;
    if (options.probe) scene.probe = options.probe;
    return scene;
}

DiagramScene read_diagram_scene(const std::string& path, const DiagramSceneOptions& options) {
    return parse_diagram_scene(read_file(path), options);
}

void write_cell_header(std::ostream& out) {
    out << "object\tname\tgroup\tstate\tvolume\tvolume_error\tarea\tarea_error\texposed_area\texposed_error\tneighbors\tmin_clearance\t"
           "max_clearance\ttouches_box\testimated\tcandidates\tbody_volume\tbody_error\treason\n";
}

void write_cell_rows(std::ostream& out, const DiagramScene& scene, std::span<const DiagramCell> cells,
                     std::uint32_t first) {
    for (std::size_t i = 0; i < cells.size(); ++i) {
        const DiagramCell& c = cells[i];
        const bool is_computed = c.state == DiagramCell::State::Computed;
        const auto neighbors = std::ranges::count_if(
            c.contacts, [](const CellContact& contact) { return contact.site.is_object(); });
        fmt::print(out, "{}\t{}\t{}\t{}", first + i, column(scene.names, i), column(scene.groups, i),
                   word(c.state));
        if (is_computed) {
            fmt::print(out, "\t{}\t{}\t{}\t{}\t{}\t{}\t{}\t{}\t{}\t{:d}\t{:d}\t{}\t{}\t{}\t-\n", c.volume,
                       c.volume_error, c.area, c.area_error, c.exposed_area, c.exposed_error, neighbors,
                       number(c.min_clearance), number(c.max_clearance), c.touches_box,
                       c.is_estimated || c.body_estimated, c.candidates, number(c.body_volume),
                       number(c.body_error));
        } else {
            const char* nothing = c.state == DiagramCell::State::Empty ? "0" : "-";
            fmt::print(out, "\t{0}\t-\t{0}\t-\t{0}\t-\t{0}\t-\t-\t-\t-\t-\t{1}\t{2}\t{3}\n", nothing,
                       number(c.body_volume), number(c.body_error), printable(c.reason));
        }
    }
}

void write_cell_table(std::ostream& out, const DiagramScene& scene, const VoronoiDiagram& diagram) {
    write_cell_header(out);
    write_cell_rows(out, scene, diagram.cells, 0);
}

void write_moment_header(std::ostream& out) { fmt::print(out, "object\tname\tgroup\t{}\n", moment_columns); }

void write_moment_row(std::ostream& out, const DiagramScene& scene, std::uint32_t object,
                      const Moments& moments) {
    fmt::print(out, "{}\t{}\t{}\t", object, column(scene.names, object), column(scene.groups, object));
    write_moment_line(out, moments);
}

void write_contact_header(std::ostream& out) {
    out << "first\tsecond\timage\tname1\tname2\tfaces\tarea\tarea_error\tdistance\tnx\tny\tnz\n";
}

void write_contact_rows(std::ostream& out, const DiagramScene& scene,
                        const std::function<std::size_t(std::uint32_t)>& place,
                        std::span<const Contact> contacts) {
    const Eigen::Matrix3d edges = scene.edges();
    for (const Contact& c : contacts) {
        const bool is_object = c.second.is_object();
        const std::size_t first = place(c.first), second = is_object ? place(c.second.index) : 0;
        fmt::print(out, "{}\t{}\t{},{},{}\t{}\t{}\t{}\t{}\t{}", c.first, to_string(c.second), c.image[0],
                   c.image[1], c.image[2], column(scene.names, first),
                   is_object ? column(scene.names, second) : "-",
                   c.faces != 0 ? std::to_string(c.faces) : "-", c.area, c.area_error);
        const auto* a = std::get_if<Sphere>(&scene.objects[first]);
        const auto* b = is_object ? std::get_if<Sphere>(&scene.objects[second]) : nullptr;
        if (a == nullptr || b == nullptr) {
            out << "\t-\t-\t-\t-\n";
            continue;
        }
        const Vec3 between = b->center + edges * Vec3(c.image[0], c.image[1], c.image[2]) - a->center;
        const Vec3 n = between.stableNormalized();
        fmt::print(out, "\t{}\t{}\t{}\t{}\n", between.norm() - a->radius - b->radius, n.x(), n.y(), n.z());
    }
}

void write_contact_table(std::ostream& out, const DiagramScene& scene, const ContactTable& table) {
    write_contact_header(out);
    write_contact_rows(
        out, scene, [](std::uint32_t number) { return number; }, table.contacts);
}

void write_group_table(std::ostream& out, const DiagramScene& scene, const VoronoiDiagram& diagram,
                       const ContactTable& table) {
    struct Group {
        std::size_t cells = 0, undecided = 0;
        double volume = 0, volume_error = 0, area = 0, area_error = 0, exposed = 0, exposed_error = 0;
        std::set<std::string> neighbors;
    };
    const GroupNames names(scene);
    std::map<std::string, Group> groups;
    std::vector<std::string> order;
    for (std::uint32_t i = 0; i < diagram.cells.size(); ++i) {
        const auto [at, is_new] = groups.try_emplace(names[i]);
        if (is_new) order.push_back(at->first);
        Group& group = at->second;
        const DiagramCell& cell = diagram.cells[i];
        if (cell.state == DiagramCell::State::Empty || cell.state == DiagramCell::State::Wall) continue;
        if (cell.state != DiagramCell::State::Computed) {
            ++group.undecided;
            continue;
        }
        ++group.cells;
        group.volume += cell.volume;
        group.volume_error += cell.volume_error;
        // Beyond a cap nothing is as near as the probe is wide, and no cell of the group goes on there.
        group.exposed += cell.exposed_area;
        group.exposed_error += cell.exposed_error;
    }
    for (const Contact& c : table.contacts) {
        if (!c.second.is_object()) continue;
        const std::string a = names[c.first], b = names[c.second.index];
        if (a == b) continue;
        for (const auto& [self, other] : {std::pair(&a, &b), std::pair(&b, &a)}) {
            Group& group = groups[*self];
            group.area += c.area;
            group.area_error += c.area_error;
            group.neighbors.insert(*other);
        }
    }
    out << "group\tcells\tundecided\tvolume\tvolume_error\tarea\tarea_error\texposed_area\texposed_error\t"
           "neighbors\n";
    for (const std::string& name : order) {
        const Group& g = groups[name];
        fmt::print(out, "{}\t{}\t{}\t{}\t{}\t{}\t{}\t{}\t{}\t{}\n", name, g.cells, g.undecided, g.volume,
                   g.volume_error, g.area, g.area_error, g.exposed, g.exposed_error,
                   g.neighbors.empty() ? "-" : fmt::format("{}", fmt::join(g.neighbors, ",")));
    }
}

void write_group_contacts(std::ostream& out, const DiagramScene& scene, const ContactTable& table) {
    struct Shared {
        std::string first, second;
        std::size_t contacts = 0;
        double area = 0, area_error = 0;
    };
    const GroupNames names(scene);
    std::vector<Shared> all;
    std::map<std::pair<std::string, std::string>, std::size_t> places;
    for (const Contact& c : table.contacts) {
        if (!c.second.is_object()) continue;
        const std::string a = names[c.first], b = names[c.second.index];
        if (a == b) continue;
        const auto [at, is_new] = places.try_emplace(std::minmax(a, b), all.size());
        if (is_new) all.push_back({a, b});
        Shared& shared = all[at->second];
        ++shared.contacts;
        shared.area += c.area;
        shared.area_error += c.area_error;
    }
    out << "first\tsecond\tcontacts\tarea\tarea_error\n";
    for (const Shared& s : all)
        fmt::print(out, "{}\t{}\t{}\t{}\t{}\n", s.first, s.second, s.contacts, s.area, s.area_error);
}

}  // namespace vcell
