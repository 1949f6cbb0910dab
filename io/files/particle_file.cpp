// Particles of XYZ files and LAMMPS dumps.
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "ball_file.hpp"
#include "ball_lines.hpp"

namespace vcell {

namespace {

// ---- XYZ --------------------------------------------------------------------------------------------

struct Key {
    std::string name, value;
};

// key=value pairs of an extended XYZ file's second line, perhaps with blanks around the sign; values with
// blanks are in quotes or braces. A word without '=' is a key that is true.
std::vector<Key> keys_of(std::string_view line, std::size_t number) {
    std::vector<Key> keys;
    for (std::size_t at = 0;;) {
        at = std::min(line.find_first_not_of(" \t", at), line.size());
        if (at == line.size()) return keys;
        const std::size_t end = std::min(line.find_first_of(" \t=", at), line.size());
        Key key{std::string(line.substr(at, end - at)), "T"};
        at = std::min(line.find_first_not_of(" \t", end), line.size());
        if (at < line.size() && line[at] == '=') {
            at = std::min(line.find_first_not_of(" \t", at + 1), line.size());
            const char open = at < line.size() ? line[at] : ' ';
            const char close = open == '{' ? '}' : open;
            if (open == '"' || open == '\'' || open == '{') {
                const std::size_t ending = line.find(close, at + 1);
                if (ending == line.npos)
                    fail_line(number, fmt::format("the value of {} has no end", printable(key.name)));
                key.value = line.substr(at + 1, ending - at - 1);
                at = ending + 1;
            } else {
                const std::size_t ending = std::min(line.find_first_of(" \t", at), line.size());
                key.value = line.substr(at, ending - at);
                at = ending;
            }
        }
        keys.push_back(std::move(key));
    }
}

std::vector<double> numbers_of(const Key& key, std::size_t count, std::size_t line) {
    std::vector<double> numbers;
    for (const std::string_view word : words_of(key.value)) numbers.push_back(parse_number(word, line));
    if (numbers.size() != count)
        fail_line(line, fmt::format("{} must have {} numbers, has {}", key.name, count, numbers.size()));
    return numbers;
}

// Where the columns of a line of atoms are, of how many.
struct XyzColumns {
    std::size_t count = 4, species = 0, place = 1;
    std::optional<std::size_t> radius, name;
    std::string form = "species x y z";
};

XyzColumns xyz_columns(const Key& properties, std::size_t line) {
    std::vector<std::string> parts(1);
    for (const char c : properties.value) {
        if (c == ':')
            parts.emplace_back();
        else
            parts.back().push_back(c);
    }
    const auto fail = [&](const std::string& what) { fail_line(line, "Properties: " + what); };
    if (parts.size() % 3 != 0) fail("must be name:type:count and so on");
    XyzColumns columns{0, SIZE_MAX, SIZE_MAX, {}, {}, properties.value};
    for (std::size_t i = 0; i < parts.size(); i += 3) {
        const std::string& name = parts[i];
        const std::size_t count = parse_count(parts[i + 2], line, "a number of columns"), at = columns.count;
        for (std::size_t k = 0; k < i; k += 3)
            if (parts[k] == name) fail(fmt::format("{} is there twice", printable(name)));
        const auto must_have = [&](std::size_t expected, const char* type) {
            if (count != expected || parts[i + 1] != type)
                fail(fmt::format("{} must be {}:{}", printable(name), type, expected));
        };
        if (name == "species" || name == "element") {
            must_have(1, "S");
            columns.species = at;
        } else if (name == "pos") {
            must_have(3, "R");
            columns.place = at;
        } else if (name == "radius" || name == "Radius") {
            must_have(1, "R");
            columns.radius = at;
        } else if (name == "id") {
            if (count != 1) fail("id must be one column");
            columns.name = at;
        }
        columns.count += count;
    }
    if (columns.place == SIZE_MAX) fail("pos is missing");
    if (columns.species == SIZE_MAX && !columns.radius) fail("there is neither a radius nor a species");
    return columns;
}

// Turns the lattice so that its first vector is along x and its second one in the plane of x and y, as
// DiagramScene::tilt has them. Vectors that are so already stay as they are, to the bit.
struct Turned {
    Eigen::Matrix3d edges;              // columns
    std::optional<Eigen::Matrix3d> by;  // none: nothing turns
};

Turned turned(const Eigen::Matrix3d& lattice, std::size_t line) {
    if (!(lattice.determinant() > 0))
        fail_line(line, "Lattice: its vectors must be right-handed and span a volume");
    const bool is_upper = lattice(1, 0) == 0 && lattice(2, 0) == 0 && lattice(2, 1) == 0;
    if (is_upper && lattice(0, 0) > 0 && lattice(1, 1) > 0) return {lattice, std::nullopt};
    Eigen::Matrix3d axes;
    axes.col(0) = lattice.col(0).normalized();
    axes.col(2) = lattice.col(0).cross(lattice.col(1)).normalized();
    axes.col(1) = axes.col(2).cross(axes.col(0));
    Eigen::Matrix3d edges = axes.transpose() * lattice;
    edges(1, 0) = edges(2, 0) = edges(2, 1) = 0;
    return {edges, axes.transpose()};
}

bool is_true(std::string_view word, std::size_t line) {
    for (const std::string_view yes : {"T", "True", "true", "1"})
        if (word == yes) return true;
    for (const std::string_view no : {"F", "False", "false", "0"})
        if (word == no) return false;
    fail_line(line, fmt::format("pbc: must be T or F three times, has '{}'", printable(word)));
}

struct XyzFrame {
    XyzColumns columns;
    Vec3 origin = Vec3::Zero();
    std::optional<Eigen::Matrix3d> turn;
};

// Does a line give this key a value?
bool assigns(std::string_view line, std::string_view key) {
    for (std::size_t at = 0; (at = line.find(key, at)) != line.npos;) {
        at += key.size();
        const std::size_t sign = line.find_first_not_of(" \t", at);
        if (sign != line.npos && line[sign] == '=') return true;
    }
    return false;
}

XyzFrame xyz_frame(std::string_view comment, std::size_t line, BallFile& file) {
    XyzFrame frame;
    // Any text may stand in the second line of a plain XYZ file.
    if (!assigns(comment, "Lattice") && !assigns(comment, "Properties")) return frame;
    std::optional<Eigen::Matrix3d> lattice;
    std::optional<std::array<bool, 3>> periodic;
    for (const Key& key : keys_of(comment, line)) {
        if (key.name == "Lattice") {
            const std::vector<double> v = numbers_of(key, 9, line);
            lattice = Eigen::Map<const Eigen::Matrix3d>(v.data());
        } else if (key.name == "Origin") {
            const std::vector<double> v = numbers_of(key, 3, line);
            frame.origin = Vec3(v[0], v[1], v[2]);
        } else if (key.name == "pbc") {
            const std::vector<std::string_view> words = words_of(key.value);
            if (words.size() != 3) fail_line(line, "pbc: must be T or F three times");
            periodic = {is_true(words[0], line), is_true(words[1], line), is_true(words[2], line)};
        } else if (key.name == "Properties") {
            frame.columns = xyz_columns(key, line);
        }
    }
    if (!lattice) {
        if (periodic && *periodic != std::array{false, false, false})
            fail_line(line, "pbc: a box that repeats needs a Lattice");
        return frame;
    }
    const Turned box = turned(*lattice, line);
    frame.turn = box.by;
    const Vec3 low = box.by ? Vec3(*box.by * frame.origin) : frame.origin;
    file.box = Box{low, low + Vec3(box.edges.diagonal())};
    file.periodic = periodic.value_or(std::array{true, true, true});
    file.tilt = {box.edges(0, 1), box.edges(0, 2), box.edges(1, 2)};
    return frame;
}

// ---- LAMMPS -----------------------------------------------------------------------------------------

std::string_view item(std::string_view line, std::string_view title) {
    constexpr std::string_view mark = "ITEM: ";
    if (!line.starts_with(mark) || !line.substr(mark.size()).starts_with(title)) return {};
    return line.substr(mark.size() + title.size()).empty() ? std::string_view(" ")
                                                           : line.substr(mark.size() + title.size());
}

// BOX BOUNDS with flags of the sides and, of leaning boxes, the corners of the box around the box.
void read_bounds(std::string_view flags, Lines& lines, BallFile& file) {
    std::vector<std::string_view> words = words_of(flags);
    const std::size_t line = lines.number();
    const bool leans = words.size() >= 3 && words[0] == "xy" && words[1] == "xz" && words[2] == "yz";
    if (leans) words.erase(words.begin(), words.begin() + 3);
    if (!words.empty() && words.size() != 3)
        fail_line(line,
                  fmt::format("BOX BOUNDS must be followed by [xy xz yz] and a flag of each axis, is by '{}'",
                              printable(flags)));
    for (std::size_t k = 0; k < words.size(); ++k) {
        if (words[k].size() != 2 || words[k].find_first_not_of("pfsm") != std::string_view::npos)
            fail_line(line, fmt::format("'{}' is no flag of an axis", printable(words[k])));
        file.periodic[k] = words[k] == "pp";
    }
    std::array<std::array<double, 3>, 3> rows{};
    const std::size_t count = leans ? 3 : 2;
    for (auto& row : rows) {
        const std::vector<std::string_view> numbers = words_of(lines.expect("a side of the box"));
        if (numbers.size() != count)
            fail_line(lines.number(), fmt::format("must have {} numbers, has {}", count, numbers.size()));
        for (std::size_t k = 0; k < count; ++k) row[k] = parse_number(numbers[k], lines.number());
    }
    const double xy = rows[0][2], xz = rows[1][2], yz = rows[2][2];
    file.tilt = {xy, xz, yz};
    file.box =
        Box{{rows[0][0] - std::min({0.0, xy, xz, xy + xz}), rows[1][0] - std::min(0.0, yz), rows[2][0]},
            {rows[0][1] - std::max({0.0, xy, xz, xy + xz}), rows[1][1] - std::max(0.0, yz), rows[2][1]}};
}

struct DumpColumns {
    std::vector<std::string_view> names;
    std::array<std::size_t, 3> place{};
    bool is_scaled = false;
    std::optional<std::size_t> radius, diameter, element, type, id, molecule;
};

DumpColumns dump_columns(std::string_view list, std::size_t line) {
    DumpColumns columns;
    columns.names = words_of(list);
    const auto find = [&](const std::string& name) -> std::optional<std::size_t> {
        const auto at = std::ranges::find(columns.names, name);
        if (at == columns.names.end()) return std::nullopt;
        return static_cast<std::size_t>(at - columns.names.begin());
    };
    bool has_place = false;
    for (const std::string ending : {"", "u", "s", "su"}) {
        const auto x = find("x" + ending), y = find("y" + ending), z = find("z" + ending);
        if (has_place || !x || !y || !z) continue;
        has_place = true;
        columns.place = {*x, *y, *z};
        columns.is_scaled = ending.starts_with('s');
    }
    if (!has_place) fail_line(line, "among the columns must be x y z, xu yu zu, xs ys zs or xsu ysu zsu");
    columns.radius = find("radius");
    columns.diameter = find("diameter");
    columns.element = find("element");
    columns.type = find("type");
    columns.id = find("id");
    columns.molecule = find("mol");
    if (!columns.radius && !columns.diameter && !columns.element && !columns.type)
        fail_line(line, "among the columns must be radius, diameter, element or type");
    return columns;
}

void read_dump_atoms(const DumpColumns& columns, std::size_t count, Lines& lines,
                     const BallFileOptions& options, BallFile& file) {
    Eigen::Matrix3d edges = Eigen::Matrix3d::Zero();
    edges.diagonal() = file.box->max - file.box->min;
    edges(0, 1) = file.tilt[0];
    edges(0, 2) = file.tilt[1];
    edges(1, 2) = file.tilt[2];
    for (std::size_t i = 0; i < count; ++i) {
        const std::vector<std::string_view> words = words_of(lines.expect("an atom"));
        const std::size_t line = lines.number();
        if (words.size() != columns.names.size())
            fail_line(line, fmt::format("must have {} columns, has {}", columns.names.size(), words.size()));
        Sphere ball;
        for (int k = 0; k < 3; ++k)
            ball.center[k] = parse_number(words[columns.place[static_cast<std::size_t>(k)]], line);
        if (columns.is_scaled) ball.center = file.box->min + edges * ball.center;
        if (columns.radius)
            ball.radius = parse_radius(words[*columns.radius], line);
        else if (columns.diameter)
            ball.radius = 0.5 * parse_radius(words[*columns.diameter], line);
        else
            ball.radius = radius_of(words[columns.element ? *columns.element : *columns.type], options, line);
        file.balls.push_back(ball);
        if (columns.id) file.names.emplace_back(words[*columns.id]);
        if (columns.molecule) file.groups.emplace_back(words[*columns.molecule]);
    }
}

}  // namespace

namespace {

// Behind the atoms of the frame that is read only empty lines and what begins another frame may be. Anything
// else is an atom more than the file counts, or is not understood.
void expect_frame_end(Lines& lines, std::size_t count, bool (*begins_frame)(std::string_view)) {
    while (!lines.at_end()) {
        const std::string_view line = lines.next();
        if (words_of(line).empty()) continue;
        if (!begins_frame(line))
            fail_line(
                lines.number(),
                fmt::format("must begin another frame, as all {} atoms of this one are before it, is '{}'",
                            count, printable(line)));
        return;
    }
}

}  // namespace

BallFile parse_xyz(std::string_view text, const BallFileOptions& options) {
    const std::size_t wanted = options.frame.value_or(0);
    Lines lines(text);
    for (std::size_t at = 0;; ++at) {
        if (lines.at_end()) fail_frame(at, wanted);
        std::string_view first = lines.next();
        const std::string_view word = next_word(first);
        if (word.empty()) {  // empty lines may follow the last frame
            --at;
            continue;
        }
        if (!next_word(first).empty()) fail_line(lines.number(), "must be a number of atoms alone");
        const std::size_t count = parse_count(word, lines.number());
        const std::string_view comment = lines.expect("the second line");
        if (at < wanted) {
            for (std::size_t i = 0; i < count; ++i) lines.expect("an atom");
            continue;
        }
        BallFile file;
        const XyzFrame frame = xyz_frame(comment, lines.number(), file);
        const XyzColumns& columns = frame.columns;
        for (std::size_t i = 0; i < count; ++i) {
            const std::vector<std::string_view> words = words_of(lines.expect("an atom"));
            const std::size_t line = lines.number();
            if (words.size() != columns.count)
                fail_line(line, fmt::format("must be {}, has {} words instead of {}", columns.form,
                                            words.size(), columns.count));
            Sphere ball;
            for (std::size_t k = 0; k < 3; ++k)
                ball.center[static_cast<Eigen::Index>(k)] = parse_number(words[columns.place + k], line);
            if (frame.turn) ball.center = *frame.turn * ball.center;
            ball.radius = columns.radius ? parse_radius(words[*columns.radius], line)
                                         : radius_of(words[columns.species], options, line);
            file.balls.push_back(ball);
            if (columns.name)
                file.names.emplace_back(words[*columns.name]);
            else if (columns.species != SIZE_MAX)
                file.names.emplace_back(words[columns.species]);
        }
        expect_frame_end(lines, count, [](std::string_view begin) {
            const std::string_view number = next_word(begin);
            return number.find_first_not_of("0123456789") == number.npos && next_word(begin).empty();
        });
        return file;
    }
}

BallFile parse_lammps_dump(std::string_view text, const BallFileOptions& options) {
    const std::size_t wanted = options.frame.value_or(0);
    Lines lines(text);
    BallFile file;
    std::optional<std::size_t> count;
    std::size_t frames = 0;
    while (!lines.at_end()) {
        const std::string_view line = lines.next();
        if (!item(line, "TIMESTEP").empty()) {
            std::string_view timestep = lines.expect("the timestep");
            parse_count(next_word(timestep), lines.number(), "a timestep");
            ++frames;
            count.reset();
            file = {};
        } else if (frames == 0) {
            fail_line(lines.number(), "a dump begins with ITEM: TIMESTEP");
        } else if (!item(line, "UNITS").empty() || !item(line, "TIME").empty()) {
            lines.expect("a value");
        } else if (!item(line, "NUMBER OF ATOMS").empty()) {
            std::string_view number = lines.expect("the number of atoms");
            count = parse_count(next_word(number), lines.number());
        } else if (const std::string_view flags = item(line, "BOX BOUNDS"); !flags.empty()) {
            read_bounds(flags, lines, file);
        } else if (const std::string_view list = item(line, "ATOMS"); !list.empty()) {
            if (!count || !file.box)
                fail_line(lines.number(), "atoms come after their number and the BOX BOUNDS");
            if (frames - 1 == wanted) {
                read_dump_atoms(dump_columns(list, lines.number()), *count, lines, options, file);
                expect_frame_end(lines, *count,
                                 [](std::string_view begin) { return begin.starts_with("ITEM:"); });
                return file;
            }
            for (std::size_t i = 0; i < *count; ++i) lines.expect("an atom");
        } else if (!words_of(line).empty()) {
            fail_line(lines.number(), fmt::format("'{}' is no item of a dump", printable(line)));
        }
    }
    if (frames > wanted) fail_line(lines.number() + 1, "ITEM: ATOMS is missing");
    fail_frame(frames, wanted);
}

}  // namespace vcell
