// The vcell program from outside: arguments, files, streams, exit statuses.
#include <doctest/doctest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "test_support.hpp"
#include "workplace.hpp"

using nlohmann::json;

namespace {

using Names = std::vector<std::string>;

}  // namespace

TEST_CASE("program: help and version") {
    Workplace w;
    for (const char* arguments :
         {"--help", "compute --help", "query --help", "measure --help", "check --help", "refine --help"}) {
        const Outcome o = w.run(arguments);
        CHECK(o.status == 0);
        CHECK(o.err.empty());
        CHECK(o.out.find("Usage:") != o.out.npos);
    }
    CHECK(w.run("--help").out.find("vcell compute examples/scenes/figure8.json -o cell.json") !=
          std::string::npos);
    CHECK(w.run("--version").out.find("vcell ") == 0);
}

TEST_CASE("program: wrong usage is status 1") {
    Workplace w;
    CHECK(w.run("compile s.json").err ==
          "vcell: there is no command \"compile\"; \"vcell --help\" tells which there are\n");
    w.write("s.json", contents(example("three_spheres.json")));
    for (const char* arguments : {"",
                                  "compile s.json",
                                  "compute",
                                  "compute s.json",
                                  "compute s.json -o",
                                  "compute s.json -o a.txt",
                                  "compute s.json -o a",
                                  "compute s.json -o a.svg -o a.svg",
                                  "compute s.json -o a.obj -o - --format tiff",
                                  "compute s.json -o a.obj --chord 0",
                                  "diagram s.json -o a.obj --chord 0%",
                                  "diagram s.json -o a.obj --chord 0.1",
                                  "compute s.json -o a.obj --chord -1",
                                  "compute s.json -o /nowhere/a.json",
                                  "compute s.json -o .",
                                  "compute s.json --base-plane 1 2 3 -o a.json",
                                  "query",
                                  "query - -",
                                  "query -",
                                  "compute s.json --surprise -o a.json",
                                  "compute s.json --threads x -o a.json",
                                  "check",
                                  "measure",
                                  "compute s.json --base 1 --base-plane 0 0 0 0 0 1 -o a.json"}) {
        CAPTURE(arguments);
        const Outcome o = w.run(arguments);
        CHECK(o.status == 1);
        CHECK_FALSE(o.err.empty());
        CHECK(o.out.empty());
    }
    CHECK(w.files() == Names{"s.json"});
}

TEST_CASE("program: several outputs from one computation") {
    Workplace w;
    const Outcome o =
        w.run("compute " + example("six_spheres.json") + " -o a.json -o b.SVG -o c.obj --solid");
    CHECK(o.status == 0);
    CHECK(o.out.empty());
    CHECK(o.err.empty());
    CHECK(w.files() == Names{"a.json", "b.SVG", "c.mtl", "c.obj"});
    CHECK(json::parse(w.read("a.json")).at("faces").size() == 6);
    CHECK(w.read("b.SVG").find("<svg") == 0);
    CHECK(w.read("c.obj").find("mtllib c.mtl\n") != std::string::npos);
    CHECK(w.read("c.obj").find("\ng walls\n") != std::string::npos);
    CHECK(w.run("check a.json").status == 0);
    CHECK(w.run("check a.json").out.find("ok: 6 faces") == 0);
}

TEST_CASE("program: standard input and output") {
    Workplace w;
    const std::string scene = contents(example("three_spheres.json"));
    const Outcome computed = w.run("compute - -o -", scene);
    CHECK(computed.status == 0);
    CHECK(json::parse(computed.out).at("vertices").size() == 8);
    const Outcome checked = w.run("check -", computed.out);
    CHECK(checked.status == 0);
    CHECK(checked.out.starts_with("ok: 3 faces, 10 edges, 8 vertices; the boundary is within "));
    CHECK(w.run("compute - -o - --format svg", scene).out.find("<svg") == 0);
    CHECK(w.run("compute - -o - --format obj", scene).out.find("mtl") == std::string::npos);
    CHECK(w.files().empty());
    json to_stream = json::parse(w.run("compute - -o - -o a.json", scene).out);
    json to_file = json::parse(w.read("a.json"));
    to_stream["report"].erase("seconds");
    to_file["report"].erase("seconds");
    CHECK(to_stream == to_file);
    CHECK(w.files() == Names{"a.json"});
    json on_threads = json::parse(w.run("compute - -o - --threads 3", scene).out);
    on_threads["report"].erase("seconds");
    CHECK(on_threads == to_file);
}

TEST_CASE("program: an output that exists is replaced whole or not at all") {
    Workplace w;
    w.write("a.json", "old");
    CHECK(w.run("compute - -o a.json -o b.svg", "{}").status == 2);
    CHECK(w.read("a.json") == "old");
    CHECK(w.files() == Names{"a.json"});
    CHECK(w.run("compute " + example("three_spheres.json") + " -o a.json").status == 0);
    CHECK(json::accept(w.read("a.json")));
}

TEST_CASE("program: bad scenes are status 2, named, and leave nothing") {
    Workplace w;
    json scene = json::parse(contents(example("three_spheres.json")));
    const auto complaint = [&](const json& s) {
        const Outcome o = w.run("compute - -o a.json -o a.svg -o a.obj", s.dump());
        CHECK(o.status == 2);
        CHECK(o.out.empty());
        CHECK(w.files().empty());
        return o.err;
    };
    json bad = scene;
    bad["objects"][1]["sphere"]["radius"] = -1;
    CHECK(complaint(bad) == "vcell: objects[1].sphere.radius: must be >= 0, is -1\n");
    bad = scene;
    bad["objects"][2]["sphere"].erase("center");
    CHECK(complaint(bad) == "vcell: objects[2].sphere.center: missing\n");
    bad = scene;
    bad["objects"][0]["sphere"]["centre"] = 1;
    CHECK(complaint(bad) == "vcell: objects[0].sphere.centre: unknown key, known are center, radius\n");
    bad = scene;
    bad["objects"][0] = {{"cylinder", {{"point", {0, 0, 0}}, {"axis", {1, 0, 0}}, {"radius", 0.1}}}};
    CHECK(complaint(bad).find("vcell: objects[0].cylinder: cuts the base region at (") == 0);
    bad = scene;
    bad["objects"][1]["sphere"]["center"][2] = 0;
    CHECK(complaint(bad).find("vcell: objects[1].sphere: cuts the base region at (") == 0);
    bad = scene;
    bad["base"] = {{"sphere", {{"center", {0, 0, 0}}, {"radius", 0.5}}}};
    CHECK(complaint(bad) ==
          "vcell: box: does not contain the base sphere's centre (base.sphere): it lies on side box:-z\n");
    bad = scene;
    bad["box"]["max"][2] = -1;
    CHECK(complaint(bad).find("vcell: box.min[2]: must be < ") == 0);
    for (const char* command : {"measure missing.json", "compute missing.json -o a.json",
                                "query missing.json", "check missing.json"}) {
        const Outcome o = w.run(command);
        CHECK(o.status == 2);
        CHECK(o.err == "vcell: cannot read missing.json: No such file or directory\n");
    }
    CHECK(w.files().empty());
}

TEST_CASE("program: plain balls") {
    Workplace w;
    w.write("balls.xyzr", "# x y z r\n0.5 0.5 1 0.25\n-0.5 -0.5 1 0.125\n");
    const Outcome o = w.run("compute balls.xyzr --base-plane 0 0 0 0 0 1 --box -1 -1 -1 1 1 2 -o -");
    CHECK(o.status == 0);
    const json cell = json::parse(o.out);
    CHECK(cell.at("faces").size() == 2);
    CHECK(cell.at("scene").at("box").at("min") == json{-1, -1, -1});
    CHECK(w.run("measure balls.xyzr --base-plane 0 0 0 0 0 1").status == 0);
    CHECK(w.run("measure balls.xyzr").err ==
          "vcell: --base: missing, and so is --base-plane: a file of balls does not say what its base is\n");
    CHECK(w.run("measure balls.xyzr --base 7").status == 2);
    const std::string mark = "\xEF\xBB\xBF";
    w.write("marked.xyzr", mark + w.read("balls.xyzr"));
    CHECK(w.run("measure marked.xyzr --base 0").out == w.run("measure balls.xyzr --base 0").out);
    CHECK(w.run("query marked.xyzr --base 0", mark + "0 0 0\n").status == 0);
    CHECK(w.run("measure " + example("three_spheres.json") + " --base 0").status == 2);
}

TEST_CASE("program: balls keep their numbers in the file, whichever is the base") {
    Workplace w;
    w.write("row.xyzr", "0 0 0 1\n4 0 0 1\n8 0 0 1\n4 0 4 1\n4 0 4 1\n");
    for (const auto& [base, neighbors] :
         {std::pair("0", json{1, 3, 4}), std::pair("1", json{0, 2, 3, 4}), std::pair("2", json{1, 3, 4})}) {
        CAPTURE(base);
        const Outcome o =
            w.run("compute row.xyzr --box -2 -2 -2 10 2 6 -o cell.json --base " + std::string(base));
        CHECK(o.status == 0);
        const json cell = json::parse(w.read("cell.json"));
        json listed = cell.at("neighbors");
        std::sort(listed.begin(), listed.end());
        CHECK(listed == neighbors);
        CHECK(cell.at("scene").at("base_object") == std::atoi(base));
        CHECK(cell.at("scene").at("objects").size() == 5);
        // Every face's site is the ball that the file has in that line.
        std::vector<std::array<double, 3>> centers{{0, 0, 0}, {4, 0, 0}, {8, 0, 0}, {4, 0, 4}, {4, 0, 4}};
        const auto& b = centers[static_cast<std::size_t>(std::atoi(base))];
        for (const json& v : cell.at("vertices"))
            for (const json& site : v.at("sites")) {
                if (!site.is_number()) continue;
                const auto& c = centers[site.get<std::size_t>()];
                double to_base = 0, to_site = 0;
                for (std::size_t k = 0; k < 3; ++k) {
                    const double x = v.at("point").at(k);
                    to_base += (x - b[k]) * (x - b[k]);
                    to_site += (x - c[k]) * (x - c[k]);
                }
                CHECK(std::sqrt(to_site) == doctest::Approx(std::sqrt(to_base)).epsilon(1e-12));
            }
        CHECK(w.run("check cell.json").status == 0);
    }
    CHECK(w.run("query row.xyzr --base 1", "2.5 0 0\n5.5 0 0\n4 0 1.5\n").out ==
          "0 1 true\n2 1 true\n3 1 true\n");
    // Merged duplicates are both neighbours, and the warning has their numbers.
    CHECK(w.run("measure row.xyzr --base 1").err.find("object 3 and object 4") != std::string::npos);
    // The cell is a scene's, too: what it has under "scene" gives the same cell.
    w.write("scene.json", json::parse(w.read("cell.json")).at("scene").dump());
    CHECK(json::parse(w.run("compute scene.json -o -").out).at("faces") ==
          json::parse(w.read("cell.json")).at("faces"));
}

TEST_CASE("program: messages name the file that they are about") {
    Workplace w;
    json scene = json::parse(contents(example("three_spheres.json")));
    scene["objects"][1]["sphere"]["radius"] = -1;
    w.write("bad.json", scene.dump());
    for (const char* command : {"compute bad.json -o a.json", "measure bad.json", "query bad.json"})
        CHECK(w.run(command).err == "vcell: bad.json: objects[1].sphere.radius: must be >= 0, is -1\n");
    scene["objects"][1]["sphere"]["radius"] = 0.25;
    scene["objects"][1]["sphere"]["center"][2] = 0;
    w.write("cuts.json", scene.dump());
    for (const char* command : {"compute cuts.json -o a.json", "measure cuts.json", "query cuts.json"})
        CHECK(w.run(command).err.find("vcell: cuts.json: objects[1].sphere: cuts the base region at (") == 0);
    w.write("balls.xyzr", "0 0 0 1\n0 0 O 1\n");
    CHECK(w.run("measure balls.xyzr --base 0").err == "vcell: balls.xyzr: line 2: 'O' is not a number\n");
    w.write("cell.json", "{\"vcell\": 1}");
    CHECK(w.run("check cell.json").err == "vcell: cell.json: scene: missing\n");
}

TEST_CASE("program: mistakes are said in one line") {
    Workplace w;
    w.write("balls.xyzr", "0 0 0 1\n4 0 0 1\n");
    w.write("atoms.pdb", "HEADER    PLANT PROTEIN\nATOM      1  N   THR A   1      17.047  14.099   3.6x5\n");
    const std::string scene = example("three_spheres.json");
    CHECK(w.run("compute " + scene + " -o cell.json").status == 0);
    for (const auto& [arguments, status, message] :
         {std::tuple<std::string, int, std::string>{
              "measure balls.xyzr --base -1", 1,
              "--base: must be the number of a ball, counted from 0, is -1"},
          {"measure balls.xyzr --base 1.5", 1,
           "--base: must be the number of a ball, counted from 0, is 1.5"},
          {"measure balls.xyzr --base 2", 2, "--base: must be less than the number of balls, 2, is 2"},
          {"compute " + scene + " -o a.obj --chord abc", 1,
           "--chord: must be a length above 0 or a percentage"},
          {"compute " + scene + " -o a.obj --chord -1%", 1,
           "--chord: must be a length above 0 or a percentage"},
          {"compute " + scene + " -o a.obj --triangles 0", 1, "--triangles: must be a number from 1"},
          {"measure balls.xyzr --base 0 --box 0 0 0 1 1 x", 1, "--box: must be a finite number, is x"},
          {"measure balls.xyzr --base 0 --box 0 0 0 1 -1 1", 1, "--box: Y0 must be < Y1 = -1, is 0"},
          {"diagram balls.xyzr --probe 0", 1,
           "--probe: must be > 0, is 0; \"vcell diagram --help\" tells more"},
          {"diagram balls.xyzr -o all.vtu --cut z=0", 1,
           "--cut: is the plane of an .svg, and no --output is one"},
          {"check " + scene, 2, scene + ": this is a scene, not a cell"},
          {"measure cell.json", 2, "cell.json: this is a cell, not a scene"},
          {"measure atoms.pdb --base 0", 2, "atoms.pdb: line 2: '3.6x5' is not a number"},
          {"measure balls.xyzr", 2, "--base: missing, and so is --base-plane"},
          {"", 1, ""}}) {
        CAPTURE(arguments);
        const Outcome o = w.run(arguments);
        CHECK(o.status == status);
        CHECK(o.out.empty());
        CHECK(o.err.find("vcell: " + message) == 0);
        CHECK(std::count(o.err.begin(), o.err.end(), '\n') == 1);
    }
}

TEST_CASE("program: meshes are as fine as the cell is large, and end at a number of triangles") {
    Workplace w;
    const auto triangles = [&](const std::string& options) {
        const Outcome o = w.run("compute scene.json -o a.obj " + options);
        CHECK(o.status == 0);
        const std::string mesh = w.read("a.obj");
        std::size_t count = 0;
        for (std::size_t at = 0; (at = mesh.find("\nf ", at)) != mesh.npos; ++at) ++count;
        return std::pair(count, o.err);
    };
    // The same cell in a box a million times as large: the ball is closed in by six others.
    json scene = json::parse(contents(example("figure8.json")));
    w.write("scene.json", scene.dump());
    const auto [fine, nothing] = triangles("");
    CHECK(nothing.empty());
    for (int k = 0; k < 3; ++k) {
        scene["box"]["min"][k] = -4e6;
        scene["box"]["max"][k] = 4e6;
    }
    w.write("scene.json", scene.dump());
    // The chart is another, and so are the triangles.
    CHECK(static_cast<double>(triangles("").first) ==
          doctest::Approx(static_cast<double>(fine)).epsilon(0.05));
    CHECK(triangles("--chord 0.01%").first > 2 * fine);
    const auto [coarse, warning] = triangles("--chord 1e-300 --triangles 2000");
    CHECK(coarse <= 2000);
    CHECK(coarse > 500);
    CHECK(warning.find("vcell: warning: a chord of 1e-300 is too fine for 2000 triangles (--triangles)") ==
          0);
    // Fewer than edges alone ask for: nothing is written.
    const Outcome none = w.run("compute scene.json -o none.obj --triangles 1");
    CHECK(none.status == 1);
    CHECK(none.err.starts_with("vcell: --triangles: the coarsest mesh has "));
    CHECK(w.read("none.obj").empty());
}

TEST_CASE("program: check names the damage, status 4") {
    Workplace w;
    json cell = json::parse(w.run("compute " + example("six_spheres.json") + " -o -").out);
    cell["vertices"][3]["radius"] = cell["vertices"][3]["radius"].get<double>() + 0.01;
    const Outcome o = w.run("check -", cell.dump());
    CHECK(o.status == 4);
    CHECK(o.out.find("vertices[3]") != o.out.npos);
    cell["edges"][2]["vertices"][0] = 1000;
    CHECK(w.run("check -", cell.dump()).status == 4);
    cell["edges"][2].erase("kind");
    CHECK(w.run("check -", cell.dump()).status == 2);
    CHECK(w.run("check -", cell.dump()).err == "vcell: edges[2].kind: missing\n");
}

TEST_CASE("program: warnings go to standard error") {
    Workplace w;
    json scene = json::parse(contents(example("three_spheres.json")));
    scene["objects"].push_back(scene["objects"][0]);
    const Outcome o = w.run("compute - -o a.json", scene.dump());
    CHECK(o.status == 0);
    CHECK(o.err.find("vcell: warning: object 0 (O1) and object 3 (O1)") == 0);
    CHECK(json::parse(w.read("a.json")).at("report").at("warnings").size() == 1);
}

TEST_CASE("program: a device that is full is an error") {
    if (!fs::is_character_file("/dev/full")) return;
    Workplace w;
    const std::string scene = example("three_spheres.json");
    for (const std::string& command : {"compute " + scene + " -o - -o a.svg", "measure " + scene}) {
        const int status = std::system(("cd '" + w.path("").string() + "' && '" VCELL_PROGRAM "' " + command +
                                        " > /dev/full 2> /dev/null")
                                           .c_str());
        REQUIRE(WIFEXITED(status));
        CHECK(WEXITSTATUS(status) == 1);
    }
    CHECK(w.files().empty());
}

TEST_CASE("program: stopped while it waits for its scene, it leaves nothing") {
    for (const int signal : {SIGTERM, SIGKILL}) {
        Workplace w;
        int pipe_ends[2];
        REQUIRE(::pipe(pipe_ends) == 0);
        const pid_t child = ::fork();
        REQUIRE(child >= 0);
        if (child == 0) {
            ::dup2(pipe_ends[0], 0);
            ::close(pipe_ends[1]);
            if (::chdir(w.path("").c_str()) != 0) ::_exit(9);
            ::execl(VCELL_PROGRAM, VCELL_PROGRAM, "compute", "-", "-o", "a.json",
                    static_cast<char*>(nullptr));
            ::_exit(9);
        }
        ::close(pipe_ends[0]);
        // An open file of its folder, nameless, shows that the program is up; it then waits for its scene.
        const fs::path descriptors = "/proc/" + std::to_string(child) + "/fd";
        const auto is_up = [&] {
            std::error_code gone;
            for (const auto& entry : fs::directory_iterator(descriptors, gone))
                if (fs::read_symlink(entry.path(), gone).string().find(w.path("").string()) == 0) return true;
            return false;
        };
        bool up = false;
        for (int i = 0; i < 1000 && !(up = is_up()); ++i) ::usleep(10'000);
        CHECK(up);
        REQUIRE(::kill(child, signal) == 0);
        int status = 0;
        REQUIRE(::waitpid(child, &status, 0) == child);
        ::close(pipe_ends[1]);
        CHECK(WIFSIGNALED(status));
        CHECK(w.files().empty());
    }
}

TEST_CASE("program: hostile scenes end soon, with status 2 and without output") {
    Workplace w;
    std::mt19937_64 rng(vcell::test_seed());
    std::string noise(10'000'000, '\0');
    for (char& c : noise) c = static_cast<char>(rng());
    for (const std::string& text :
         {noise, std::string(100'000, '['), std::string(100'000, '{'), std::string(), std::string("null"),
          std::string(10'000'000, '7'), R"({"vcell":1,"objects":)" + std::string(100'000, '[')}) {
        CHECK(w.run("compute - -o a.json -o a.svg -o a.obj", text).status == 2);
        CHECK(w.run("check -", text).status == 2);
        CHECK(w.files().empty());
    }
}

TEST_CASE("program: mutated scenes give a cell that checks, or status 2") {
    Workplace w;
    std::mt19937_64 rng(vcell::test_seed());
    const std::string scene = contents(example("three_spheres.json"));
    for (int i = 0; i < 40 * vcell::rounds(); ++i) {
        std::string text = scene;
        for (auto n = 1 + rng() % 2; n-- > 0;) {
            const std::size_t at = rng() % text.size();
            if (rng() % 3 == 0)
                text.erase(at, 1);
            else
                text[at] = "0123456789.-e,"[rng() % 14];
        }
        CAPTURE(text);
        const Outcome o = w.run("compute - -o a.json", text);
        CHECK((o.status == 0 || o.status == 2));
        if (o.status == 0) {
            CHECK(w.run("check a.json").status == 0);
            fs::remove(w.path("a.json"));
        }
        CHECK(w.files().empty());
    }
}

TEST_CASE("program: draw makes the same picture of a scene and of its cell, and refuses what is no picture") {
    const Workplace work;
    const std::string scene = example("figure8.json");
    const Outcome drawn = work.run("draw " + scene + " -o scene.png --size 64");
    if (drawn.err.find("libpng-dev") != std::string::npos) {
        MESSAGE("skipped: the program was built without libpng");
        return;
    }
    REQUIRE(drawn.status == 0);
    const std::string picture = work.read("scene.png");
    CHECK(picture.starts_with("\x89PNG\r\n\x1a\n"));
    CHECK(picture.substr(16, 8) == std::string("\0\0\0\x40\0\0\0\x40", 8));  // width and height
    REQUIRE(work.run("compute " + scene + " -o cell.json").status == 0);
    REQUIRE(work.run("draw cell.json -o cell.png --size 64 --view -60,25").status == 0);
    CHECK(work.read("cell.png") == picture);
    CHECK(work.run("draw - -o - --size 64", work.read("cell.json")).out == picture);
    for (const char* other : {"--no-objects", "--view 30,25", "--clip 0 0 0 1 0 0"}) {
        CAPTURE(other);
        REQUIRE(work.run("draw cell.json -o other.png --size 64 " + std::string(other)).status == 0);
        CHECK(work.read("other.png") != picture);
    }
    for (const char* wrong :
         {"-o cell.gif", "", "-o cell.png --view 1", "-o cell.png --view 0,91",
          "-o cell.png --clip 0 0 0 1 0", "-o cell.png --clip 0 0 0 0 0 0", "-o cell.png --size 0"})
        CHECK(work.run(std::string("draw cell.json ") + wrong).status == 1);
    CHECK(work.run("draw - -o cell.png", "{\"vcell\": 1, \"scene\": {}}").status == 2);
}
