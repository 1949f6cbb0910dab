// Prints docs/tables.md: which surfaces and curves separate planes, spheres and cylinders, by asking
// bisector() and trisector() about one example of every row, and how long cells of two objects took.
//
// Usage: tables bench/results/radial.csv (as bench/record_radial.py wrote it)

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include <vcell/primitives/primitives.hpp>

namespace {

using vcell::Cylinder;
using vcell::Object;
using vcell::Plane;
using vcell::Sphere;

const Plane ground{{0, 0, 0}, {0, 0, 1}};
const Plane roof{{0, 0, 5}, {0, 0, 1}};
const Plane gable{{0, 0, 8}, {0, 3, 4}};
const Sphere ball{{0.25, 0.5, 3}, 1};
const Sphere marble{{-1, 1, 2}, 0.25};
const Cylinder pipe{{0, 0, 3}, {2, 2, 1}, 0.5};
const Cylinder level{{0, 0, 3}, {3, 4, 0}, 0.5};
const Cylinder upright{{7, 2, 0}, {0, 0, 1}, 0.5};
const Cylinder x_rod{{0, 0, 0}, {1, 0, 0}, 0.5};
const Cylinder y_rod{{0, 0, 0}, {0, 1, 0}, 0.5};
const Cylinder z_rod{{0, 0, 0}, {0, 0, 1}, 0.5};

const char* name(const Object& o) {
    static constexpr const char* names[] = {"plane", "sphere", "cylinder"};
    return names[o.index()];
}

struct Pair {
    const char* position;
    Object base, a;
    const char* paper;
};

struct Triple {
    const char* position;
    Object base, a, b;
    const char* paper;
};

// What [HE] says of a row, or of its general case: see the text above the tables.
constexpr const char* special = "";
constexpr const char* quadric = "quadric";
constexpr const char* quartic = "degree 4";
constexpr const char* planes = "line";
constexpr const char* lemma_1 = "conic (Lemma 1)";
constexpr const char* lemma_2 = "conic (Lemma 2)";
constexpr const char* lemma_3 = "conic (Lemma 3)";
constexpr const char* lemma_4 = "conic (Lemma 4)";
constexpr const char* no_conic = "no conic";

std::vector<Pair> pairs() {
    return {
        {"general", ground, gable, quadric},
        {"parallel", ground, roof, special},
        {"general", ground, ball, quadric},
        {"general", ground, pipe, "quadric: elliptic cone"},
        {"axis along the plane", ground, level, special},
        {"axis across the plane", ground, upright, special},
        {"line in the plane", ground, Cylinder{{1, 2, 0}, {1, 1, 0}, 0}, special},
        {"general", ball, marble, quadric},
        {"equal radii", Sphere{{0, 0, 0}, 1}, Sphere{{1, 2, 3}, 1}, special},
        {"one inside the other", Sphere{{0, 0, 0}, 3}, Sphere{{1, 0, 1}, 0.5}, special},
        {"concentric", Sphere{{0, 0, 0}, 3}, Sphere{{0, 0, 0}, 0.5}, special},
        {"general", marble, Cylinder{{0, 0, 5}, {1, 2, 1}, 0.5}, quartic},
        {"equal radii", Sphere{{-1, 1, 2}, 0.5}, Cylinder{{0, 0, 5}, {1, 2, 1}, 0.5}, special},
        {"point on a line", Sphere{{0, 0, 5}, 0}, Cylinder{{0, 0, 5}, {1, 2, 1}, 0}, special},
        {"general", pipe, Cylinder{{0, 0, 6}, {1, 2, 1}, 1}, quartic},
        {"equal radii", pipe, Cylinder{{0, 0, 6}, {1, 2, 1}, 0.5}, special},
        {"equal radii, crossing axes", pipe, Cylinder{{0, 0, 3}, {1, 2, 1}, 0.5}, special},
        {"parallel axes", pipe, Cylinder{{0, 0, 6}, {-2, -2, -1}, 1}, special},
        {"parallel axes, equal radii", pipe, Cylinder{{0, 0, 6}, {2, 2, 1}, 0.5}, special},
        {"one inside the other", pipe, Cylinder{{0, 0.5, 3}, {2, 2, 1}, 2}, special},
        {"coaxial", pipe, Cylinder{{0, 0, 3}, {2, 2, 1}, 2}, special},
    };
}

std::vector<Triple> triples() {
    const Cylinder crossing{{0, 0, 3}, {6, 3, -2}, 0.5}, skew{{0, 1, 5}, {1, 2, 1}, 0.25};
    return {
        {"general", ground, gable, Plane{{0, 0, 9}, {1, 2, 2}}, planes},
        {"general", ground, gable, ball, lemma_3},
        {"parallel planes", ground, roof, ball, special},
        {"general", ground, gable, pipe, lemma_4},
        {"axis along the planes", ground, roof, level, special},
        {"axis across the planes", ground, roof, upright, special},
        {"general", ground, ball, marble, lemma_2},
        {"equal radii, equal heights", ground, Sphere{{-1, 0, 2}, 0.5}, Sphere{{1, 0, 2}, 0.5}, special},
        {"general", ground, marble, pipe, no_conic},
        {"upright cylinder, centre on its axis", ground, Sphere{{7, 2, 3}, 1}, upright, special},
        {"general", ground, pipe, skew, no_conic},
        {"parallel axes", ground, pipe, Cylinder{{0, 3, 6}, {4, 4, 2}, 1}, special},
        {"parallel axes along the plane", ground, level, Cylinder{{2, 0, 3}, {-6, -8, 0}, 0.25}, special},
        {"equal radii, crossing axes", ground, pipe, crossing, special},
        {"equal radii, crossing axes along the plane", ground, level, Cylinder{{0, 0, 3}, {0, 1, 0}, 0.5},
         special},
        {"equal radii, crossing axes, irrational planes", ground, level, Cylinder{{0, 0, 3}, {1, 1, 0}, 0.5},
         special},
        {"general", marble, ball, Sphere{{3, 0, 0}, 0.5}, lemma_1},
        {"equal radii", Sphere{{-1, 0, 2}, 0.5}, Sphere{{1, 0, 2}, 0.5}, Sphere{{0, 3, 2}, 0.5}, special},
        {"general", marble, ball, Cylinder{{0, 0, 6}, {1, 2, 1}, 0.5}, no_conic},
        {"points and a line", Sphere{{-1, 1, 2}, 0}, Sphere{{1, 0, 3}, 0}, Cylinder{{0, 0, 6}, {1, 2, 1}, 0},
         special},
        {"general", marble, pipe, skew, no_conic},
        {"parallel axes", marble, pipe, Cylinder{{0, 3, 6}, {4, 4, 2}, 1}, special},
        {"equal radii, crossing axes", Sphere{{1, 2, 3}, 0.5}, x_rod, y_rod, special},
        {"general", Cylinder{{0, 5, 0}, {1, 0, 3}, 0.75}, pipe, skew, no_conic},
        {"parallel axes", x_rod, Cylinder{{0, 3, 0}, {2, 0, 0}, 1}, Cylinder{{0, 0, 4}, {-1, 0, 0}, 0.25},
         special},
        {"equal radii, crossing axes", x_rod, y_rod, z_rod, special},
    };
}

// One base over each pair of objects, all in general position.
std::vector<Object> bases() {
    return {ground, Sphere{{0, 0, -3}, 0.75}, Cylinder{{0, 0, -6}, {2, 1, 2}, 0.75}};
}

std::vector<std::array<Object, 2>> object_pairs() {
    const Plane slope{{0, 0, 9}, {1, 2, 2}};
    const Cylinder skew{{0, 1, 5}, {1, 2, 1}, 0.25};
    return {{gable, slope}, {gable, ball}, {gable, pipe}, {ball, marble}, {marble, pipe}, {pipe, skew}};
}

// "parabola × 2", "ellipse and hyperbola"; "none".
std::string listed(const vcell::Trisector& curve) {
    std::map<std::string, int> counts;
    for (const auto& c : curve.components)
        ++counts[c.kind == vcell::TrisectorKind::Spline ? "curve of degree " + std::to_string(c.degree)
                                                        : std::string(to_string(c.kind))];
    std::string text;
    for (const auto& [kind, count] : counts) {
        if (!text.empty()) text += " and ";
        text += kind;
        if (count > 1) text += " × " + std::to_string(count);
    }
    return text.empty() ? "none" : text;
}

bool is_exact(const vcell::Trisector& curve) {
    return std::ranges::none_of(curve.components,
                                [](const auto& c) { return c.kind == vcell::TrisectorKind::Spline; });
}

std::string written(const vcell::Trisector& curve) {
    if (is_exact(curve)) return "exact";
    return curve.splits_irrationally ? "spline; splits, but not over the rationals" : "spline";
}

}  // namespace

// The column `seconds` of a CSV file without quotes, by its first column.
std::map<std::string, double> read_seconds(const char* file) {
    const auto fields = [](const std::string& line) {
        std::vector<std::string> out;
        std::istringstream in(line);
        for (std::string field; std::getline(in, field, ',');) out.push_back(field);
        return out;
    };
    std::ifstream in(file);
    std::string line;
    std::getline(in, line);
    const std::vector<std::string> names = fields(line);
    const auto column = static_cast<std::size_t>(std::ranges::find(names, "seconds") - names.begin());
    std::map<std::string, double> seconds;
    while (std::getline(in, line)) {
        const std::vector<std::string> row = fields(line);
        if (row.size() > column) seconds[row[0]] = std::stod(row[column]);
    }
    return seconds;
}

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fputs("usage: tables RADIAL_CSV\n", stderr);
        return 1;
    }
    const std::map<std::string, double> seconds = read_seconds(argv[1]);
    std::puts(
        "# Bisectors and trisectors\n\n"
        "Made by a program from what `bisector()` and `trisector()` answer; do not edit, run\n"
        "`build/release/examples/tables bench/results/radial.csv > docs/tables.md`. A test compares the "
        "two.\n\n"
        "[HE] is the paper of [references.md](references.md). Its tables are about general position, so its "
        "column "
        "is\n"
        "empty for special ones: of the six bisectors four are quadrics and those of a cylinder with a "
        "sphere or a\n"
        "cylinder have degree 4 (Table 1); of the ten trisectors five are conics or lines: of three planes, "
        "of three\n"
        "spheres (Lemma 1), of a plane and two spheres (Lemma 2), of two planes and a sphere (Lemma 3), of "
        "two "
        "planes\n"
        "and a cylinder (Lemma 4); the other five are none and are approximated there (Table 2).\n\n"
        "## Bisectors [HE, Table 1]\n\n"
        "Degree: of the implicit polynomial. Patch: degrees of the rational patch in its two parameters.\n\n"
        "| objects | position | surface | degree | patch | [HE] |\n"
        "|---|---|---|--:|--:|---|");
    for (const Pair& row : pairs()) {
        const vcell::Bisector b = vcell::bisector(row.base, row.a);
        std::printf("| %s – %s | %s | %s | %d | %d × %d | %s |\n", name(row.base), name(row.a), row.position,
                    std::string(to_string(b.kind)).c_str(), b.degree(), b.patch_degree[0], b.patch_degree[1],
                    row.paper);
    }
    std::puts(
        "\nA quartic over two cylinders with skew or crossing axes is parametrised by both half angles, one "
        "of a\n"
        "sphere and a cylinder by the half angle and the length along the axis.\n\n"
        "## Trisectors [HE, Table 2]\n\n"
        "The first object is the base; a base plane has its cell on one side, an object plane has two sides "
        "over it, and\n"
        "both count. Degree: the sum over all components, virtual branches included. Lines and conics are "
        "written\n"
        "exactly, as rational curves of degree 1 and 2; splines are fitted with a certified bound. So are, in the "
        "cell of a ball,\n"
        "all edges beside cylinders, and in that of a cylinder all edges beside balls and beside cylinders not "
        "along it, whatever\n"
        "special position makes them conics.\n\n"
        "`trisector(base, a, b, box, tolerance)` gives the curves within a box: every connected part, proved to be one "
        "and to be\n"
        "all. Splines are of degree 5, by the fit that the edges of cells come from. The five rows that are no conics, each\n"
        "within 1e-4 in a box of 6 x 6 x 5, drawn by `build/release/examples/trisectors`:\n\n"
        "![Five trisectors in a box with their objects](pictures/trisectors.svg)\n\n"
        "| objects | position | curve | degree | written | [HE] |\n"
        "|---|---|---|--:|---|---|");
    for (const Triple& row : triples()) {
        const vcell::Trisector curve = vcell::trisector(row.base, row.a, row.b);
        std::printf("| %s – %s – %s | %s | %s | %d | %s | %s |\n", name(row.base), name(row.a), name(row.b),
                    row.position, listed(curve).c_str(), curve.degree(), written(curve).c_str(), row.paper);
    }
    std::puts(
        "\n## Every base and pair of objects\n\n"
        "In general position. Degrees: of the bisectors of the base with the first and the second object, "
        "and of the\n"
        "trisector. Exact: lines and conics; certified: splines with a bound on their distance from the "
        "curve.\n"
        "Time: from scene to cell with patches and measures, of a base with two such objects in a box; medians "
        "of 20\n"
        "random scenes (scenes `pair/...` of [bench/results/radial.csv](../bench/results/radial.csv), by "
        "`bench/record_radial.py`).\n\n"
        "| base | objects | bisectors | trisector | | ms |\n"
        "|---|---|---|--:|---|--:|");
    for (const Object& base : bases())
        for (const auto& [a, b] : object_pairs()) {
            const vcell::Trisector curve = vcell::trisector(base, a, b);
            const std::string scene = std::string("pair/") + name(base) + "/" + name(a) + "-" + name(b);
            std::printf("| %s | %s – %s | %d, %d | %d | %s | %.2g |\n", name(base), name(a), name(b),
                        vcell::bisector(base, a).degree(), vcell::bisector(base, b).degree(), curve.degree(),
                        is_exact(curve) ? "exact" : "certified", 1e3 * seconds.at(scene));
        }
}
