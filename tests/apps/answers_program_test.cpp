// What the vcell program answers about a cell, from outside: measures, moments, points, digits.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <tuple>

#include "test_support.hpp"
#include "workplace.hpp"

using nlohmann::json;

TEST_CASE("program: measure --complete measures what is nearest to a ball outside the box, too") {
    Workplace w;
    w.write("balls.xyzr", "-2 0 0 0.25\n0.5 0.5 0.25 0.125\n");
    double sum = 0;
    for (const char* base : {"0", "1"}) {
        const Outcome o =
            w.run(std::string("measure balls.xyzr --complete --box -1 -1 -1 1 1 1 --base ") + base);
        CHECK(o.status == 0);
        CHECK(o.out.starts_with("volume\tvolume_error\tarea\tarea_error\tneighbors\testimated\n"));
        sum += std::stod(o.out.substr(o.out.find('\n') + 1));
    }
    CHECK(std::abs(sum - 8) < 1e-9);
    CHECK(w.run("measure balls.xyzr --box -1 -1 -1 1 1 1 --base 0").err.find("beyond side box:-x") !=
          std::string::npos);
}

TEST_CASE("program: query answers point by point") {
    Workplace w;
    // One sphere over the middle: z = (x^2 + y^2 + 15/16) / (5/2). Two equal ones: a tie half-way.
    const char* one = R"({"vcell":1,"base":{"plane":{"point":[0,0,0],"normal":[0,0,1]}},
        "objects":[{"sphere":{"center":[0,0,1],"radius":0.25}}],"box":{"min":[-1,-1,0],"max":[1,1,2]}})";
    w.write("one.json", one);
    w.write("points.txt",
            "0 0 0.375 # on the boundary\n0 0 0.376\n\n0 0 0\n0 0 -0.001\n1 1 1\n1.001 0 0.1\n0.5 0 0.1\n");
    const Outcome o = w.run("query one.json points.txt");
    CHECK(o.status == 0);
    CHECK(
        o.out ==
        "0 0.375 true\n0 0.375 false\n0 0.375 true\n0 0.375 false\n0 1.175 true\n- - false\n0 0.475 true\n");
    CHECK(w.run("query one.json", "0 0 0").out == "0 0.375 true\n");
    CHECK(w.run("query - points.txt", one).out == o.out);
    const char* two = R"({"vcell":1,"base":{"plane":{"point":[0,0,0],"normal":[0,0,1]}},
        "objects":[{"sphere":{"center":[0.5,0,1],"radius":0.25}},{"sphere":{"center":[-0.5,0,1],"radius":0.25}}],
        "box":{"min":[-1,-1,0],"max":[1,1,0.5]}})";
    w.write("two.json", two);
    const std::string answers = w.run("query two.json", "0 0.1 0\n-1e-9 0.1 0\n0 1 0\n").out;
    CHECK(answers.find("0 0.479") == 0);
    CHECK(answers.find("\n1 0.478999") != std::string::npos);
    CHECK(answers.find("\nbox:+z 0.5 true") != std::string::npos);
    // A rod along x, z = (y^2 + 15/16) / (5/2), and one whose axis is |(9/5 - 4/5 z, 1)| away from (1, 1, z).
    w.write("rods.json", R"({"vcell":1,"base":{"plane":{"point":[0,0,0],"normal":[0,0,1]}},
        "objects":[{"cylinder":{"point":[0,0,1],"axis":[1,0,0],"radius":0.25}},
                   {"cylinder":{"point":[4,0,0],"axis":[-4,0,3],"radius":1}}],"box":{"min":[-1,-1,0],"max":[1,1,2]}})");
    CHECK(w.run("query rods.json", "0 0 0.375\n0 0 0.3750001\n-1 1 0.774\n").out ==
          "0 0.375 true\n0 0.375 false\n0 0.775 true\n");
    const std::string leaning = w.run("query rods.json", "1 1 0.634257\n1 1 0.634258\n").out;
    CHECK(leaning.find("1 0.634257") == 0);
    CHECK(leaning.find(" true\n1 0.634257") != std::string::npos);
    CHECK(leaning.ends_with(" false\n"));
}

TEST_CASE("program: query answers over curved bases") {
    Workplace w;
    // Equal balls: their bisector is the plane x = 3.
    w.write("ball.json", R"({"vcell":1,"base":{"sphere":{"center":[1,2,3],"radius":1}},
        "objects":[{"sphere":{"center":[5,2,3],"radius":1}}],"box":{"min":[-3,-2,-1],"max":[5,6,7]}})");
    CHECK(w.run("query ball.json", "3 2 3\n3.0001 2 3\n1 2 3\n1 2 6.75\n1 2 8\n1.5 2 3\n").out ==
          "0 1 true\n0 1 false\n- - true\nbox:+z 3 true\nbox:+z 3 false\n0 1 true\n");
    // The ball at x = 2 takes its half of the base's body.
    w.write("overlap.json", R"({"vcell":1,"base":{"sphere":{"center":[0,0,0],"radius":2}},
        "objects":[{"sphere":{"center":[2,0,0],"radius":2}}],"box":{"min":[-8,-8,-8],"max":[8,8,8]}})");
    CHECK(w.run("query overlap.json", "0.75 0.5 0\n1.25 0.5 0\n").out.find("0 -0.79") == 0);
    CHECK(w.run("query overlap.json", "0.75 0.5 0\n").out.ends_with(" true\n"));
    CHECK(w.run("query overlap.json", "1.25 0.5 0\n").out.ends_with(" false\n"));
    w.write("tube.json", R"({"vcell":1,"base":{"cylinder":{"point":[0,0,0],"axis":[0,0,2],"radius":1}},
        "objects":[{"cylinder":{"point":[4,0,0],"axis":[0,0,1],"radius":1}},
                   {"cylinder":{"point":[0,4,0],"axis":[3,0,0],"radius":1}}],
        "box":{"min":[-10,-10,-10],"max":[10,10,10]}})");
    // The chart is turned about the axis: directions are rounded, clearances in their last digits too.
    std::istringstream answers(
        w.run("query tube.json", "1.999 0 5\n2.001 0 5\n0 -2 0\n0 -10.5 0\n0 1.999 0\n0 2.001 0\n").out);
    for (const auto& [site, clearance, inside] :
         {std::tuple("0", 1, "true"), std::tuple("0", 1, "false"), std::tuple("box:-y", 9, "true"),
          std::tuple("box:-y", 9, "false"), std::tuple("1", 1, "true"), std::tuple("1", 1, "false")}) {
        std::string owner, answer;
        double height = 0;
        answers >> owner >> height >> answer;
        CHECK(owner == site);
        CHECK(height == doctest::Approx(clearance).epsilon(1e-14));
        CHECK(answer == inside);
    }
    CHECK(w.run("query tube.json", "0 0 5\n0 0 11\n").out == "- - true\n- - false\n");
}

TEST_CASE("program: query names a bad line") {
    Workplace w;
    const std::string scene = example("three_spheres.json");
    w.write("points.txt", "0 0 0\n0 0\n");
    CHECK(w.run("query " + scene + " points.txt").status == 2);
    CHECK(w.run("query " + scene + " points.txt").err ==
          "vcell: points.txt: line 2: must be x y z, has 2 numbers\n");
    CHECK(w.run("query " + scene, "0 0 x").err == "vcell: points: line 1: 'x' is not a number\n");
    CHECK(w.run("query " + scene, "0 0 nan").err ==
          "vcell: points: line 1: must be a finite number, is nan\n");
    CHECK(w.run("query " + scene, "").out.empty());
}

TEST_CASE("program: measure prints a header and a line") {
    Workplace w;
    std::istringstream lines(w.run("measure " + example("three_spheres.json")).out);
    std::string header, values, more;
    REQUIRE(std::getline(lines, header));
    REQUIRE(std::getline(lines, values));
    CHECK_FALSE(std::getline(lines, more));
    CHECK(std::count(header.begin(), header.end(), '\t') == std::count(values.begin(), values.end(), '\t'));
    CHECK(header.find("volume\tvolume_error\tbody_volume\tarea\t") == 0);
    const json cell = json::parse(w.run("compute " + example("three_spheres.json") + " -o -").out);
    CHECK(std::stod(values) == cell.at("measures").at("volume").get<double>());
    CHECK(values.ends_with("\t0"));
    // Around a tube errors are estimates.
    CHECK(w.run("measure " + example("figure10.json")).out.ends_with("\t1\n"));
}

TEST_CASE("program: moments and level curves are there where they are asked for") {
    const Workplace w;
    const std::string scene = example("three_spheres.json");
    const json with = json::parse(w.run("compute " + scene + " --moments -o -").out),
               without = json::parse(w.run("compute " + scene + " -o -").out);
    CHECK_FALSE(without.at("measures").contains("moments"));
    const json& moments = with.at("measures").at("moments");
    std::istringstream table(w.run("measure " + scene + " --moments -").out);
    std::string line, columns;
    for (int k = 0; k < 3; ++k) std::getline(table, columns);
    REQUIRE(columns.starts_with("x\ty\tz\tcentroid_error\t"));
    std::getline(table, line);
    CHECK(std::stod(line) == moments.at("centroid")[0].get<double>());
    CHECK(w.run("check -", with.dump()).status == 0);

    const std::string picture = w.run("compute " + scene + " --format svg --contours 6 -o -").out;
    CHECK(picture.find("class=\"contour\"") != std::string::npos);
    CHECK(w.run("compute " + scene + " --format svg -o -").out.find("contour") == std::string::npos);
    CHECK(w.run("compute " + scene + " --format svg --contours 0 -o -").status == 1);
}

TEST_CASE("program: places of the least and the greatest clearance are there where they are asked for") {
    const Workplace w;
    const std::string scene = example("three_spheres.json");
    const json with = json::parse(w.run("compute " + scene + " --clearances -o -").out).at("measures");
    CHECK_FALSE(
        json::parse(w.run("compute " + scene + " -o -").out).at("measures").contains("min_clearance_place"));
    std::istringstream table(w.run("measure " + scene + " --clearances -").out);
    std::string line;
    for (int k = 0; k < 3; ++k) std::getline(table, line);
    REQUIRE(
        line.starts_with("extreme\tclearance\tclearance_error\tx\ty\tz\terror\tvertex\tedge\tface\tsites\t"));
    for (const auto& [extreme, key] :
         {std::pair("least", "min_clearance"), std::pair("greatest", "max_clearance")}) {
        const json& place = with.at(std::string(key) + "_place");
        CHECK(place.at("clearance").get<double>() ==
              doctest::Approx(with.at(key).get<double>()).epsilon(1e-12));
        CHECK(place.contains("vertex") + place.contains("edge") + place.contains("face") == 1);
        std::string name;
        double clearance = 0, error = 0, x = 0;
        table >> name >> clearance >> error >> x;
        std::getline(table, line);
        CHECK(name == extreme);
        CHECK(clearance == place.at("clearance").get<double>());
        CHECK(error == place.at("clearance_error").get<double>());
        CHECK(x == place.at("point")[0].get<double>());
    }
    CHECK(w.run("check -", w.run("compute " + scene + " --clearances -o -").out).status == 0);
}

TEST_CASE("program: refine prints vertices to the digits asked for") {
    const Workplace w;
    // A point among points: the vertex (3/2, 3/2, 3/2), sqrt(27/4) away.
    w.write("points.xyzr", "0 0 0 0\n3 0 0 0\n0 3 0 0\n0 0 3 0\n");
    const std::string cell = w.run("compute points.xyzr --base 0 --box -9 -9 -9 9 9 9 -o -").out;
    const Outcome o = w.run("refine - --bits 110", cell);
    CHECK(o.status == 0);
    CHECK(o.out.find("vertex\tsites\tx\ty\tz\tclearance\ttie_width\n") == 0);
    CHECK(o.out.find("\t1.50000000000000000000000000000000\t1.50000000000000000000000000000000\t"
                     "1.50000000000000000000000000000000\t2.59807621135331594029116951225881\t0\n") !=
          std::string::npos);
    CHECK(w.run("refine - --vertex 99", cell).status == 1);
    CHECK(w.run("refine - --bits 300", cell).status == 1);
}
