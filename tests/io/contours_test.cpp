// Level curves of the clearance: where they are, where they end, and in pictures.
#include "../../io/pictures/contours.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>

#include "../../envelope/point_query.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "../../io/pictures/labels.hpp"
#include "../../io/pictures/mesh.hpp"
#include "../../io/pictures/svg.hpp"
#include "damages.hpp"
#include "sample_cells.hpp"

namespace vcell {

using namespace damages;

namespace {

std::string picture(const Cell& cell, std::size_t levels) {
    std::ostringstream out;
    write_svg(out, cell, {levels});
    return out.str();
}

std::size_t count(const std::string& text, const std::string& part) {
    std::size_t n = 0;
    for (std::size_t at = 0; (at = text.find(part, at)) != text.npos; ++at) ++n;
    return n;
}

}  // namespace

TEST_CASE("contours: levels are round, within the range, and no more than asked for") {
    Cell cell;
    for (const auto& [least, most] :
         {std::array{0.1, 0.87}, std::array{-3.0, 5.0}, std::array{1e-9, 2e-9}, std::array{1e6, 1e6 + 70}}) {
        cell.measures.min_clearance = least;
        cell.measures.max_clearance = most;
        for (const std::size_t count : {1, 2, 5, 10, 50}) {
            CAPTURE(least);
            CAPTURE(count);
            const auto levels = round_levels(cell, count);
            CHECK(levels.size() <= count);
            if (count > 2) CHECK(3 * levels.size() >= count);
            for (const double level : levels) CHECK((least < level && level < most));
            for (std::size_t k = 2; k < levels.size(); ++k)
                CHECK(levels[k] - levels[k - 1] == doctest::Approx(levels[1] - levels[0]));
            if (levels.size() < 2) continue;
            const double step = levels[1] - levels[0],
                         digit = step / std::pow(10, std::floor(std::log10(1.0001 * step)));
            CHECK(std::min({std::abs(digit - 1), std::abs(digit - 2), std::abs(digit - 5)}) < 1e-6);
        }
    }
    CHECK(round_levels(cell, 0).empty());
    cell.measures.max_clearance = cell.measures.min_clearance;
    CHECK(round_levels(cell, 5).empty());
}

TEST_CASE("contours: every point has its clearance, and its face's owner") {
    for (const char* name : {"balls", "atom", "tubes over a plane", "tubes around a tube"}) {
        CAPTURE(name);
        const Cell& cell = good(name);
        const auto levels = round_levels(cell, 6);
        REQUIRE_FALSE(levels.empty());
        const auto lines = contours(cell, levels);
        CHECK(lines.size() >= levels.size());
        PointQuery query(cell.scene);
        const double size = cell_diagonal(cell);
        std::size_t wrong = 0, points = 0;
        for (const Contour& line : lines)
            for (std::size_t k = 0; k < line.points.size(); k += 3) {
                const auto answer = query(line.points[k]);
                if (!answer) continue;  // beside the rim, by its rounding
                ++points;
                CHECK(std::abs(answer->clearance - levels[line.level]) <= 2e-4 * size);
                // Next to an edge the other face's owner may be told.
                wrong += answer->site != cell.faces[line.face].site;
            }
        CHECK(points > 50);
        CHECK(wrong <= points / 20);
        // Chords follow the curve.
        for (const Contour& line : lines)
            for (std::size_t k = 1; k < line.points.size(); ++k)
                if (const auto answer = query(0.5 * (line.points[k - 1] + line.points[k])))
                    CHECK(std::abs(answer->clearance - levels[line.level]) <= 1e-3 * size);
    }
}

TEST_CASE("contours: where an edge crosses a level its faces' curves end, both at one place") {
    for (const char* name : {"balls", "atom", "tubes around a tube"}) {
        CAPTURE(name);
        const Cell& cell = good(name);
        const auto levels = round_levels(cell, 5);
        const auto lines = contours(cell, levels);
        const double size = cell_diagonal(cell);
        std::size_t crossings = 0;
        for (const CellEdge& e : cell.edges) {
            if (e.vertices.size() != 2 || !is_inner_edge(e)) continue;
            double a = cell.vertices[e.vertices[0]].radius, b = cell.vertices[e.vertices[1]].radius;
            for (std::size_t level = 0; level < levels.size(); ++level) {
                if ((a < levels[level]) == (b < levels[level])) continue;
                // Its ends are on either side, so it has a point at that clearance.
                PointQuery query(cell.scene);
                double from = e.curve.domain_begin(), to = e.curve.domain_end();
                for (int k = 0; k < 40; ++k) {
                    const double middle = 0.5 * (from + to);
                    const auto answer = query(e.curve.evaluate(middle));
                    REQUIRE(answer);
                    ((answer->clearance < levels[level]) == (a < levels[level]) ? from : to) = middle;
                }
                const Vec3 p = e.curve.evaluate(from);
                ++crossings;
                for (const Site& site : e.sites)
                    CHECK(std::ranges::any_of(lines, [&](const Contour& line) {
                        return line.level == level && cell.faces[line.face].site == site &&
                               std::min((line.points.front() - p).norm(), (line.points.back() - p).norm()) <
                                   2e-3 * size;
                    }));
            }
        }
        CHECK(crossings > 2);
    }
}

TEST_CASE("contours: circles are arcs, and lines straight, in pictures over a plane") {
    // Under a ball r^2 = w h - e, all within the square at h < 0.775; levels 0.6 and 0.8, ... .
    const Cell ball = voronoi_cell(paraboloid_cell().scene);
    const auto levels = round_levels(ball, 4);
    REQUIRE(levels.size() >= 2);
    const std::string svg = picture(ball, 4);
    CHECK(count(svg, "class=\"contour\"") == levels.size());
    for (const double h : levels) {
        if (h > 0.77) continue;
        const double r = std::sqrt(2.5 * h - 15.0 / 16);
        std::ostringstream arc;
        arc.precision(6);
        arc << "A" << r;
        CHECK_MESSAGE(svg.find(arc.str()) != std::string::npos, arc.str());
    }
    const std::size_t from = svg.find("class=\"contour\""), to = svg.find('>', from);
    CHECK(svg.substr(from, to - from).find('L') == std::string::npos);
    CHECK(svg.find("clearance, every ") != std::string::npos);
    CHECK(count(svg, "class=\"words label level\"") > 0);
    // Under a plane that leans.
    const Cell flat = voronoi_cell(over_the_plane({Plane{{0, 0, 1}, {0.25, 0, -1}}}));
    const std::string lines = picture(flat, 5);
    const std::size_t path = lines.find(" d=\"", lines.find("class=\"contour\"")) + 4;
    CHECK(count(lines.substr(path, lines.find('"', path) - path), "L") == 1);
    // Not asked for: not there, and nothing of them.
    CHECK(picture(ball, 0).find("contour") == std::string::npos);
    CHECK(picture(ball, 0).find("clearance, every") == std::string::npos);
}

TEST_CASE("contours: unfolded around balls and tubes") {
    for (const char* name : {"atom", "tubes around a tube"}) {
        CAPTURE(name);
        const Cell& cell = good(name);
        const std::string svg = picture(cell, 5);
        CHECK(count(svg, "class=\"contour\"") == round_levels(cell, 5).size());
        CHECK(svg.find(" d=\"\"") == std::string::npos);
    }
}

TEST_CASE("labels: words on a line lie along it, and none upon others") {
    const std::vector<Vec2> line{{0, 0}, {10, 10}};
    const auto place = place_on_line(line, 2);
    REQUIRE(place);
    CHECK((place->at - Vec2(5, 5)).norm() < 1e-12);
    CHECK(place->degrees == doctest::Approx(45));
    const std::vector<Vec2> back{{10, 10}, {0, 0}};
    CHECK(place_on_line(back, 2)->degrees == doctest::Approx(45));
    CHECK_FALSE(place_on_line(line, 10));
    const std::vector<Vec2> bent{{0, 0}, {5, 0}, {5, 0.1}, {0, 0.1}};
    CHECK_FALSE(place_on_line(bent, 2));
    TakenRoom room;
    CHECK(room.take({0, 0}, {4, 1}));
    CHECK_FALSE(room.take({1, 0}, {4, 1}));
    CHECK(room.take({0, 8}, {4, 1}));
}

}  // namespace vcell
