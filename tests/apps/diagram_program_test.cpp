// vcell diagram from outside.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "workplace.hpp"

namespace {

/// Lines of words between tabs.
std::vector<std::vector<std::string>> table(const std::string& text) {
    std::vector<std::vector<std::string>> rows;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) {
        std::istringstream words(line);
        rows.emplace_back();
        for (std::string word; std::getline(words, word, '\t');) rows.back().push_back(word);
    }
    return rows;
}

constexpr const char* four_balls =
    "0 0 0 0.5 A one\n"
    "2 0 0 0.5 B one\n"
    "0 2 0 0.25 C two\n"
    "0.1 0 0 0.25 D  # in the first\n";

}  // namespace

TEST_CASE("program: diagram writes tables of cells, contacts and groups") {
    const Workplace work;
    work.write("balls.txt", four_balls);
    const Outcome done = work.run(
        "diagram balls.txt --box -2 -2 -2 4 4 2 --cells cells.tsv --contacts contacts.tsv --groups groups.tsv");
    CAPTURE(done.err);
    REQUIRE(done.status == 0);
    const auto summary = table(done.out), cells = table(work.read("cells.tsv")),
               contacts = table(work.read("contacts.tsv")), groups = table(work.read("groups.tsv"));
    REQUIRE(summary.size() == 2);
    CHECK(summary[1][0] == "3");
    CHECK(summary[1][1] == "1");
    CHECK(std::abs(std::stod(summary[1][3]) - 144) <= std::stod(summary[1][4]));
    REQUIRE(cells.size() == 5);
    double sum = 0;
    for (std::size_t i = 1; i < cells.size(); ++i) {
        REQUIRE(cells[i].size() == cells[0].size());
        sum += std::stod(cells[i][4]);
    }
    CHECK(sum == doctest::Approx(144));
    CHECK(cells[1][1] == "A");
    CHECK(cells[4][3] == "empty");
    CHECK(cells[4].back() == "lies in object 0");
    bool are_neighbors = false;
    for (const auto& row : contacts) are_neighbors = are_neighbors || (row[0] == "0" && row[1] == "1");
    CHECK(are_neighbors);
    // Objects without a group are groups of their own.
    REQUIRE(groups.size() == 4);
    CHECK(groups[1][0] == "one");
    CHECK(groups[1][1] == "2");
    CHECK(groups[1].back() == "two");
    CHECK(groups[1][7] == "0");  // without a probe nothing is exposed
    CHECK(std::stod(groups[1][3]) == doctest::Approx(std::stod(cells[1][4]) + std::stod(cells[2][4])));
}

TEST_CASE("program: diagram tells the porosity of balls and of fibres where it is asked to") {
    const Workplace work;
    work.write("balls.txt", four_balls);
    const Outcome done = work.run("diagram balls.txt --box -2 -2 -2 4 4 2 --bodies --cells cells.tsv");
    REQUIRE(done.status == 0);
    const auto summary = table(done.out), cells = table(work.read("cells.tsv"));
    const double ball = 4 * std::numbers::pi / 3 / 8, all = 2 * ball + ball / 8;  // one is in another one
    REQUIRE(summary[0].size() == 10);
    CHECK(summary[0].back() == "porosity");
    CHECK(std::stod(summary[1][7]) == doctest::Approx(all).epsilon(1e-12));
    CHECK(std::stod(summary[1][9]) == doctest::Approx(1 - all / 144).epsilon(1e-12));
    const auto column = std::ranges::find(cells[0], "body_volume") - cells[0].begin();
    REQUIRE(column < static_cast<std::ptrdiff_t>(cells[0].size()));
    CHECK(std::stod(cells[1][column]) == doctest::Approx(ball).epsilon(1e-12));
    CHECK(cells[4][column] == "-");
    work.run("diagram balls.txt --box -2 -2 -2 4 4 2 --cells plain.tsv");
    CHECK(table(work.read("plain.tsv"))[1][column] == "-");

    work.write("fibres.json", R"({"vcell": 1, "box": {"min": [0, 0, 0], "max": [4, 4, 4]}, "objects": [
        {"cylinder": {"point": [2, 1, 1], "axis": [1, 0, 0], "radius": 0.5}},
        {"cylinder": {"point": [2, 3, 3], "axis": [0, 0, 2], "radius": 0.25}}]})");
    const Outcome fibres = work.run("diagram fibres.json --bodies");
    CAPTURE(fibres.err);
    REQUIRE(fibres.status == 0);
    CHECK(std::stod(table(fibres.out)[1][9]) ==
          doctest::Approx(1 - std::numbers::pi * (0.25 + 0.0625) / 16).epsilon(1e-12));
}

TEST_CASE("program: diagram writes moments, which add up to those of the box") {
    const Workplace work;
    work.write("balls.txt", four_balls);
    const Outcome done =
        work.run("diagram balls.txt --box -2 -2 -2 4 4 2 --cells cells.tsv --moments moments.tsv");
    CAPTURE(done.err);
    REQUIRE(done.status == 0);
    const auto cells = table(work.read("cells.tsv")), moments = table(work.read("moments.tsv"));
    REQUIRE(moments.size() == 4);  // one object has no cell
    CHECK(moments[1][1] == "A");
    CHECK(moments[3][2] == "two");
    const std::vector<double> middle{1, 1, 0}, size{6, 6, 4};
    for (std::size_t axis = 0; axis < 3; ++axis) {
        double first = 0, second = 0, error = 0;
        for (std::size_t i = 1; i < moments.size(); ++i) {
            REQUIRE(moments[i].size() == moments[0].size());
            const double volume = std::stod(cells[i][4]),
                         away = std::stod(moments[i][3 + axis]) - middle[axis];
            first += volume * away;
            second += std::stod(moments[i][7 + axis]) + volume * away * away;
            error += volume * std::stod(moments[i][6]);
        }
        CHECK(std::abs(first) <= error + 1e-9);
        CHECK(second == doctest::Approx(144 * size[axis] * size[axis] / 12));
    }
    // A cell's own program says the same of it.
    work.write("plain.txt", "0 0 0 0.5\n2 0 0 0.5\n0 2 0 0.25\n0.1 0 0 0.25\n");
    const auto alone = table(work.run("measure plain.txt --base 1 --box -2 -2 -2 4 4 2 --moments m.tsv").out);
    CHECK(alone.size() == 2);
    const auto line = table(work.read("m.tsv"));
    REQUIRE(line.size() == 2);
    for (std::size_t k = 0; k < 3; ++k)
        CHECK(std::stod(line[1][k]) == doctest::Approx(std::stod(moments[2][3 + k])));
}

TEST_CASE("program: diagram of a box that repeats, from JSON and from options") {
    const Workplace work;
    work.write("scene.json",
               R"({"vcell": 1, "objects": [{"sphere": {"center": [0, 0, 0], "radius": 0.1}},
                                           {"sphere": {"center": [0.5, 0.5, 0.5], "radius": 0.1}}],
                   "box": {"min": [0, 0, 0], "max": [1, 1, 1]}, "periodic": [true, true, true]})");
    work.write("balls.txt", "0 0 0 0.1\n0.5 0.5 0.5 0.1\n");
    const Outcome from_json = work.run("diagram scene.json --contacts -"),
                  from_text = work.run("diagram balls.txt --box 0 0 0 1 1 1 --periodic xyz --contacts -");
    REQUIRE(from_json.status == 0);
    CHECK(from_json.out == from_text.out);
    // Of each ball 8 faces with the other one's images, and 3 pairs with its own.
    CHECK(table(from_json.out).size() == 1 + 8 + 3 + 3);
    CHECK(work.run("diagram scene.json --threads 2 --contacts -").out == from_json.out);
}

TEST_CASE("program: numbers may begin with their point") {
    const Workplace work;
    work.write("balls.txt", "0 0 0 0.5\n1.5 0 0 0.3\n");
    const Outcome short_ones = work.run("diagram balls.txt --box -.75 -1 -.5 3 3 .75");
    CHECK(short_ones.status == 0);
    CHECK(short_ones.out == work.run("diagram balls.txt --box -0.75 -1 -0.5 3 3 0.75").out);
    CHECK(work.run("diagram balls.txt -.x").status == 1);
}

TEST_CASE("program: a diagram's file is checked as a cell's is") {
    const Workplace work;
    work.write("balls.txt", "0 0 0 0.5\n1.5 0 0 0.3\n0.2 1 0.4 0.2\n0 0 0.1 0.1\n");
    REQUIRE(work.run("diagram balls.txt -o all.json --cells cells.tsv").status == 0);
    const Outcome checked = work.run("check all.json");
    CAPTURE(checked.out);
    CHECK(checked.status == 0);
    CHECK(checked.out.starts_with("ok: 3 cells that fill their box; the boundary is within "));
    CHECK(work.run("check all.json --json --threads 1").out ==
          work.run("check all.json --json --threads 3").out);
    std::string text = work.read("all.json");
    const std::size_t radius = text.find("0.3");
    REQUIRE(radius != text.npos);
    text.replace(radius, 3, "0.4");
    const Outcome damaged = work.run("check -", text);
    CHECK(damaged.status == 4);
    CHECK(damaged.out.find("cells[") != std::string::npos);
    REQUIRE(work.run("diagram balls.txt --probe 1 -o all.json").status == 0);
    const Outcome with_probe = work.run("check all.json");
    CHECK(with_probe.status == 0);
    CHECK(with_probe.out.starts_with("ok: 3 cells up to a probe's distance; the boundary is within "));
}

TEST_CASE("program: files of boxes that repeat, and of balls in a vessel, are checked, too") {
    const Workplace work;
    work.write("balls.txt", "0 0 0 0.5\n1.5 0 0 0.3\n0.2 1 0.4 0.2\n");
    REQUIRE(
        work.run("diagram balls.txt --box 0 0 0 3 3 3 --periodic xyz --tilt 0.5 0 -0.5 -o all.json").status ==
        0);
    const Outcome checked = work.run("check all.json");
    CAPTURE(checked.out);
    CHECK(checked.status == 0);
    CHECK(checked.out.starts_with("ok: 3 cells that fill their box; the boundary is within "));
    std::string text = work.read("all.json");
    const std::size_t image = text.find("\"1(-1,0,0)\"");
    REQUIRE(image != text.npos);
    text.replace(image, 11, "\"1(-1,0,1)\"");
    CHECK(work.run("check -", text).status == 4);

    REQUIRE(work.run("diagram " VCELL_EXAMPLE_SCENES "/vessel.json -o vessel.out.json").status == 0);
    const Outcome vessel = work.run("check vessel.out.json");
    CAPTURE(vessel.out);
    CHECK(vessel.status == 0);
    CHECK(vessel.out.starts_with("ok: 4 cells among other objects; the boundary is within "));
}

TEST_CASE("program: files of planes and tubes among balls are checked, too") {
    const Workplace work;
    work.write("scene.json", R"({"vcell": 1, "box": {"min": [0, 0, 0], "max": [8, 8, 8]}, "objects": [
        {"cylinder": {"point": [2, 2, 6], "axis": [1, 2, 0.5], "radius": 0.5}},
        {"sphere": {"center": [5, 3, 5], "radius": 1}},
        {"plane": {"point": [4, 4, 2], "normal": [0.1, -0.05, -1]}}]})");
    REQUIRE(work.run("diagram scene.json -o all.json").status == 0);
    const Outcome checked = work.run("check all.json");
    CAPTURE(checked.out);
    CHECK(checked.status == 0);
    CHECK(checked.out.starts_with("ok: 4 cells that fill their box; the boundary is within "));
    std::string text = work.read("all.json");
    const std::size_t side = text.find(R"("side":"-")");
    REQUIRE(side != text.npos);
    text.erase(side, 11);
    CHECK(work.run("check -", text).status == 2);
}

TEST_CASE("program: diagram reads molecules and dumps") {
    const Workplace work;
    const std::string data = VCELL_TEST_DATA "/";
    const Outcome pdb =
                      work.run("diagram " + data + "crambin_head.pdb --cells cells.tsv --groups groups.tsv"),
                  cif = work.run("diagram - --cells -", contents(data + "crambin_head.cif"));
    CAPTURE(pdb.err);
    REQUIRE(pdb.status == 0);
    CHECK(cif.out == work.read("cells.tsv"));
    const auto cells = table(cif.out), residues = table(work.read("groups.tsv"));
    REQUIRE(cells.size() == 27);
    CHECK(cells[1][1] == "A:THR1:N");
    REQUIRE(residues.size() == 5);
    CHECK(residues[4][0] == "A:CYS4");
    const Outcome chains = work.run("diagram " + data + "crambin_head.pdb --group chain --groups -");
    CHECK(table(chains.out).size() == 2);
    // A body-centred lattice: two balls of types 1 and 2 in a cube, the second one's cell the smaller.
    work.write("last.dump",
               "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS pp pp pp\n0 2\n0 2\n0 2\n"
               "ITEM: ATOMS id type xs ys zs\n1 1 0 0 0\n2 2 0.5 0.5 0.5\n");
    const Outcome dump = work.run("diagram last.dump --radius 1=0.5 --radius 2=0.25 --cells - --frame 0");
    CAPTURE(dump.err);
    REQUIRE(dump.status == 0);
    const auto lattice = table(dump.out);
    CHECK(std::stod(lattice[1][4]) + std::stod(lattice[2][4]) == doctest::Approx(8));
    CHECK(std::stod(lattice[1][4]) > std::stod(lattice[2][4]));
    const Outcome unknown = work.run("diagram last.dump");
    CHECK(unknown.status == 2);
    CHECK(unknown.err.find("last.dump: line 10: there is no radius of '1' in the table") !=
          std::string::npos);
    const Outcome one = work.run("measure " + data + "crambin_head.pdb --base 3");
    CHECK(one.status == 0);
    CHECK(work.run("diagram last.dump --radius 1").status == 1);
    CHECK(work.run("diagram last.dump --radius 1=0.5 --radius 2=0.5 --no-water").status == 2);
}

TEST_CASE("program: diagram writes the void network") {
    const Workplace work;
    work.write("cubic.txt", "0 0 0 0.25\n");
    const Outcome done = work.run("diagram cubic.txt --box 0 0 0 2 2 2 --periodic xyz --network -");
    CAPTURE(done.err);
    REQUIRE(done.status == 0);
    const auto rows = table(done.out);
    REQUIRE(rows.size() == 7 + 1 + 2 + 1 + 4);
    CHECK(rows[0] == std::vector<std::string>{"sphere", "diameter", "error"});
    CHECK(rows[1][0] == "Di");
    CHECK(std::abs(std::stod(rows[1][1]) - (2 * std::sqrt(3.0) - 0.5)) <= std::stod(rows[1][2]));
    CHECK(rows[2][0] == "Df");
    CHECK(std::abs(std::stod(rows[2][1]) - (2 * std::sqrt(2.0) - 0.5)) <= std::stod(rows[2][2]));
    CHECK(rows[7].empty());
    CHECK(rows[9].size() == rows[8].size());
    CHECK(rows[9].back() == "0 0(0,0,1) 0(0,1,0) 0(0,1,1) 0(1,0,0) 0(1,0,1) 0(1,1,0) 0(1,1,1)");
    for (std::size_t i = 12; i < rows.size(); ++i) CHECK(rows[i].size() == rows[11].size());
    CHECK(work.run("diagram cubic.txt --box 0 0 0 2 2 2 --periodic xyz --network - --threads 2").out ==
          done.out);
    work.write(
        "tubes.json",
        R"({"vcell": 1, "objects": [{"cylinder": {"point": [0.25, 0.25, 0], "axis": [0, 0, 1], "radius": 0.2}}],
                  "box": {"min": [0, 0, 0], "max": [1, 1, 1]}, "periodic": [true, true, true]})");
    const auto of_tubes = table(work.run("diagram tubes.json --network -").out);
    REQUIRE(of_tubes.size() == 7 + 1 + 1 + 1 + 2 + 1 + 3);
    CHECK(std::abs(std::stod(of_tubes[2][1]) - (std::sqrt(2.0) - 0.4)) <= std::stod(of_tubes[2][2]));
    CHECK(of_tubes[13][0] == "passage");
    const Outcome probe = work.run("diagram tubes.json --probe 0.1 --network n.tsv");
    CHECK(probe.status == 2);
    CHECK(probe.err.find("probe: ends cells before their vertices") != std::string::npos);
    CHECK(!fs::exists(work.path("n.tsv")));
}

TEST_CASE("program: diagram says what is wrong") {
    const Workplace work;
    work.write("balls.txt", four_balls);
    work.write("bad.txt", "0 0 0\n");
    work.write("plane.json",
               R"({"vcell": 1, "objects": [{"plane": {"point": [0, 0, 0], "normal": [1, 0, 1]}}],
                                "box": {"min": [-1, -1, -1], "max": [1, 1, 1]}, "periodic": [true, false, false]})");
    CHECK(work.run("diagram").status == 1);
    CHECK(work.run("diagram balls.txt --periodic w").status == 1);
    CHECK(work.run("diagram balls.txt --threads x").status == 1);
    CHECK(work.run("diagram balls.txt --cells a --contacts a").status == 1);
    const Outcome bad = work.run("diagram bad.txt");
    CHECK(bad.status == 2);
    CHECK(bad.err.find("bad.txt: line 1: must be x y z r [name [group]], has 3 of the 4 numbers") !=
          std::string::npos);
    // Room about the balls would repeat with them.
    const Outcome boxless = work.run("diagram balls.txt --periodic xyz");
    CHECK(boxless.status == 2);
    CHECK(boxless.err.find("--box: missing: balls do not tell the box that repeats") != std::string::npos);
    const Outcome plane = work.run("diagram plane.json");
    CHECK(plane.status == 2);
    CHECK(plane.err.find("objects[0].plane: is not where it was") != std::string::npos);
    // Of two objects that cut each other neither has a cell; the third one has.
    work.write("cut.json", R"({"vcell": 1, "objects": [{"plane": {"point": [0, 0, 0], "normal": [0, 0, 1]}},
                                                       {"sphere": {"center": [0, 0, 0.1], "radius": 0.2}},
                                                       {"sphere": {"center": [0, 0, 0.7], "radius": 0.1}}],
                              "box": {"min": [-1, -1, -1], "max": [1, 1, 1]}})");
    const Outcome cut = work.run("diagram cut.json --cells -");
    CHECK(cut.status == 3);
    const auto cells = table(cut.out);
    REQUIRE(cells.size() == 4);
    CHECK(cells[1][3] == "refused");
    CHECK(cells[2][3] == "refused");
    CHECK(cells[3][3] == "computed");
    // Ten objects are named where many have no cells.
    const auto on_plane = [](int balls) {
        std::string text = R"({"vcell": 1, "box": {"min": [-1, -1, -1], "max": [1, 1, 1]}, "objects": [
                               {"plane": {"point": [0, 0, 0], "normal": [0, 0, 1]}})";
        for (int i = 0; i < balls; ++i)
            text += R"(, {"sphere": {"center": [0, )" + std::to_string(0.125 * i - 0.75) +
                    R"(, 0.0625], "radius": 0.0625}})";
        return text + "]}";
    };
    work.write("many.json", on_plane(11));
    const Outcome many = work.run("diagram many.json");
    CHECK(many.status == 3);
    CHECK(std::count(many.err.begin(), many.err.end(), '\n') == 11);
    CHECK(many.err.find("12 objects have no cells, ") != std::string::npos);
    // The bodies' volume is told all the same.
    work.write("few.json", on_plane(2));
    const Outcome few = work.run("diagram few.json --bodies");
    CHECK(few.status == 3);
    CHECK(std::count(few.err.begin(), few.err.end(), '\n') == 3);
    CHECK(table(few.out)[1][0] == "0");
}

TEST_CASE("program: diagram with a probe tells the accessible surface and the contacts within its reach") {
    const Workplace work;
    // Grown by the probe the first two meet in a circle of radius sqrt(3); the third is out of reach.
    work.write("balls.txt", "0 0 0 1 A pair\n2 0 0 1 B pair\n9 0 0 1 C\n");
    const Outcome done =
        work.run("diagram balls.txt --probe 1 --cells cells.tsv --contacts contacts.tsv --groups groups.tsv");
    CAPTURE(done.err);
    REQUIRE(done.status == 0);
    const auto cells = table(work.read("cells.tsv")), contacts = table(work.read("contacts.tsv"));
    REQUIRE(cells.size() == 4);
    const auto exposed = [&](std::size_t i) {
        const auto column = std::ranges::find(cells[0], "exposed_area") - cells[0].begin();
        return std::stod(cells[i][static_cast<std::size_t>(column)]);
    };
    constexpr double pi = std::numbers::pi;
    CHECK(exposed(1) == doctest::Approx(12 * pi));
    CHECK(exposed(3) == doctest::Approx(16 * pi));
    // Both of a group have caps, none of them within it.
    const auto groups = table(work.read("groups.tsv"));
    REQUIRE(groups.size() == 3);
    REQUIRE(groups[0][7] == "exposed_area");
    REQUIRE(groups[0][8] == "exposed_error");
    CHECK(std::abs(std::stod(groups[1][7]) - 24 * pi) <= std::stod(groups[1][8]));
    CHECK(std::stod(groups[1][8]) < 1e-9);
    CHECK(std::stod(groups[1][5]) == 0);
    CHECK(std::stod(groups[2][7]) == doctest::Approx(16 * pi));
    REQUIRE(contacts.size() == 2);
    CHECK(std::stod(contacts[1][6]) == doctest::Approx(3 * pi));
    CHECK(work.run("diagram balls.txt --probe 0").status == 1);
    // The cap has patches: the third cell is all of a ball of radius 2.
    REQUIRE(work.run("diagram balls.txt --probe 1 --moments moments.tsv -o all.obj").status == 0);
    CHECK(work.read("all.obj").find("cap") != std::string::npos);
    const auto moments = table(work.read("moments.tsv"));
    REQUIRE(moments.size() == 4);
    CHECK(std::stod(moments[3][3]) == doctest::Approx(9));
    const auto xx = std::ranges::find(moments[0], "xx") - moments[0].begin();
    CHECK(std::stod(moments[3][static_cast<std::size_t>(xx)]) == doctest::Approx(4 * pi / 15 * 32));
}

TEST_CASE("program: diagram draws a cut and a mesh of all cells") {
    const Workplace work;
    work.write("balls.txt", four_balls);
    REQUIRE(work.run("diagram balls.txt -o all.obj -o cut.svg --cut z=-0.25").status == 0);
    CHECK(work.read("all.obj").find("o cell_2_C\n") != std::string::npos);
    CHECK(work.read("all.obj").find("mtllib all.mtl\n") != std::string::npos);
    CHECK(work.read("all.mtl").find("newmtl c0\n") != std::string::npos);
    // All cells together have a bound on their triangles.
    const auto triangles = [&] {
        const std::string mesh = work.read("all.obj");
        std::size_t count = 0;
        for (std::size_t at = 0; (at = mesh.find("\nf ", at)) != mesh.npos; ++at) ++count;
        return count;
    };
    const std::size_t all = triangles();
    const Outcome fits = work.run("diagram balls.txt -o all.obj --triangles " + std::to_string(all));
    CHECK(fits.status == 0);
    CHECK(fits.err.empty());
    CHECK(triangles() == all);
    const Outcome less = work.run("diagram balls.txt -o all.obj --triangles " + std::to_string(all - 1));
    CHECK(less.status == 0);
    CHECK(less.err == "vcell: warning: a chord of 0.2% is too fine for " + std::to_string(all - 1) +
                          " triangles (--triangles) or 4096 pieces of an edge: the mesh has " +
                          std::to_string(triangles()) + " triangles with one of 0.8%\n");
    CHECK(triangles() < all);
    // Fewer than edges alone ask for: nothing is written.
    const std::size_t before = triangles();
    const Outcome none = work.run("diagram balls.txt -o all.obj --triangles 10");
    CHECK(none.status == 1);
    CHECK(none.err.starts_with("vcell: --triangles: the coarsest mesh has "));
    CHECK(none.err.ends_with(" triangles, not 10 at most\n"));
    CHECK(triangles() == before);
    CHECK(work.run("diagram balls.txt --triangles 0").status == 1);
    CHECK(work.read("cut.svg").find("z = -0.25") != std::string::npos);
    REQUIRE(work.run("diagram balls.txt -o all.VTU -o all.ply -o all.stl").status == 0);
    CHECK(work.read("all.VTU").find("Name=\"neighbor\"") != std::string::npos);
    CHECK(work.read("all.ply").starts_with("ply\n"));
    for (const char* wrong :
         {"-o cut.svg", "-o cut.png", "-o cut.svg --cut w=1", "-o cut.svg --cut z=", "-o a.obj -o a.obj"})
        CHECK(work.run(std::string("diagram balls.txt ") + wrong).status == 1);
}
