#include <doctest/doctest.h>

#include <boost/multiprecision/cpp_int.hpp>
#include <map>
#include <numeric>
#include <random>
#include <set>

#include "check_arrangement.hpp"
#include "polyline_geometry.hpp"
#include "segment_geometry.hpp"
#include "test_support.hpp"
#include "vcell/arrangement/sweep/sweep.hpp"

namespace vcell::sweep_test {
using Segment = SegmentGeometry::Arc;
using Point = SegmentGeometry::Point;

namespace {

Counts counts(const Dcel& d) { return {d.vertex_count(), d.edge_count(), component_count(d)}; }

/// The counts by comparing all pairs in rational numbers, without sweep or Dcel.
Counts brute_force(const std::vector<Segment>& segments, const std::vector<Point>& points) {
    using Rational = boost::multiprecision::cpp_rational;
    using Place = std::pair<Rational, Rational>;
    const auto place = [](const Point& p) { return Place(Rational(p.x, p.w), Rational(p.y, p.w)); };
    const auto cross = [](const Place& o, const Place& a, const Place& b) -> Rational {
        return (a.first - o.first) * (b.second - o.second) - (a.second - o.second) * (b.first - o.first);
    };
    std::set<Place> vertices;
    for (const Point& p : points) vertices.insert(place(p));
    for (const Segment& s : segments) {
        vertices.insert(place(s.left));
        vertices.insert(place(s.right));
        for (const Segment& t : segments) {
            const Place a = place(s.left), b = place(s.right), c = place(t.left), d = place(t.right);
            const Rational from = cross(a, b, c), to = cross(a, b, d);
            if (from == to) continue;
            const Rational u = from / (from - to);
            if (u < 0 || u > 1) continue;
            const Place p(c.first + u * (d.first - c.first), c.second + u * (d.second - c.second));
            if (a <= p && p <= b) vertices.insert(p);
        }
    }
    std::map<Place, std::uint32_t> number;
    for (const Place& p : vertices) number.emplace(p, number.size());
    std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
    for (const Segment& s : segments) {
        const Place a = place(s.left), b = place(s.right);
        std::uint32_t previous = number.at(a);
        for (const auto& [p, i] : number) {
            if (a < p && p <= b && cross(a, b, p) == 0) {
                edges.emplace(previous, i);
                previous = i;
            }
        }
    }
    std::vector<std::uint32_t> part(number.size());
    std::iota(part.begin(), part.end(), 0u);
    long components = static_cast<long>(number.size());
    const auto root = [&](std::uint32_t i) {
        while (part[i] != i) i = part[i];
        return i;
    };
    for (const auto& [a, b] : edges) {
        if (root(a) == root(b)) continue;
        part[root(a)] = root(b);
        --components;
    }
    return {number.size(), edges.size(), components};
}

class Grid {
public:
    Grid(std::uint64_t seed, int size) : rng_(seed), coordinate_(0, size) {}
    Point point() { return {coordinate_(rng_), coordinate_(rng_), 1}; }
    /// A point between the grid's.
    Point fine_point() {
        const int w = std::uniform_int_distribution(1, 4)(rng_);
        std::uniform_int_distribution c(-w, w * (coordinate_.max() + 1));
        return {c(rng_), c(rng_), w};
    }
    Segment segment() {
        for (;;) {
            const Point p = point(), q = point();
            if (p.x != q.x || p.y != q.y) return SegmentGeometry::segment(p.x, p.y, q.x, q.y);
        }
    }

private:
    std::mt19937_64 rng_;
    std::uniform_int_distribution<int> coordinate_;
};

void check(const std::vector<Segment>& segments, const std::vector<Point>& points = {}) {
    SegmentGeometry g;
    const auto a = arrange<SegmentGeometry>(g, segments, points);
    REQUIRE(arrangement_defect(g, a) == "");
    REQUIRE(counts(a.dcel) == brute_force(segments, points));
    Grid grid(test_seed(), 12);
    std::vector<Point> queries(a.points.begin(), a.points.end());
    for (int i = 0; i < 50; ++i) queries.push_back(i % 2 ? grid.point() : grid.fine_point());
    check_location(g, a, queries);
}

std::vector<Segment> transposed(std::vector<Segment> segments) {
    for (Segment& s : segments) s = SegmentGeometry::segment(s.left.y, s.left.x, s.right.y, s.right.x);
    return segments;
}

}  // namespace

TEST_CASE("sweep: random segments on small grids agree with brute force") {
    std::mt19937_64 rng(test_seed());
    for (const int size : {1, 2, 3, 5, 12}) {
        for (int round = 0; round < 60; ++round) {
            CAPTURE(size);
            CAPTURE(round);
            Grid grid(rng(), size);
            std::vector<Segment> segments;
            std::vector<Point> points;
            const int n = std::uniform_int_distribution(0, 14)(rng);
            for (int i = 0; i < n; ++i) segments.push_back(grid.segment());
            for (int i = 0; i < n / 3; ++i) points.push_back(i % 2 ? grid.point() : grid.fine_point());
            check(segments, points);
        }
    }
}

TEST_CASE("sweep: degenerate families agree with brute force") {
    const auto segment = SegmentGeometry::segment;
    SUBCASE("nothing") { check({}); }
    SUBCASE("points only, one twice") { check({}, {{1, 1, 1}, {2, 2, 2}, {0, 5, 1}}); }
    SUBCASE("one segment, its ends and a point inside it") {
        check({segment(0, 0, 4, 2)}, {{0, 0, 1}, {2, 1, 1}, {4, 2, 1}});
    }
    SUBCASE("a grid of lines") {
        std::vector<Segment> lines;
        for (int i = 0; i <= 6; ++i) {
            lines.push_back(segment(i, 0, i, 6));
            lines.push_back(segment(0, i, 6, i));
        }
        check(lines);
    }
    SUBCASE("a star: all directions through one point, some ending there") {
        std::vector<Segment> lines;
        for (int i = -4; i <= 4; ++i) {
            lines.push_back(segment(6 - 4, 6 - i, 6 + 4, 6 + i));
            lines.push_back(segment(6 - i, 6 - 4, 6 + i, 6 + 4));
            lines.push_back(segment(6, 6, 6 + 5, 6 + i));
        }
        check(lines);
    }
    SUBCASE("many overlaps on one line, sloped and vertical") {
        std::vector<Segment> lines;
        for (int i = 0; i < 6; ++i) {
            for (int j = i + 1; j <= 6; j += 2) lines.push_back(segment(i, i, j, j));
        }
        lines.push_back(segment(0, 6, 6, 0));
        lines.push_back(segment(1, 5, 4, 2));
        check(lines);
        std::vector<Segment> vertical;
        for (const Segment& s : lines) {
            vertical.push_back(s);
            vertical.push_back(segment(3, s.left.x, 3, s.right.x));
        }
        check(vertical);
        check(transposed(vertical));
    }
    SUBCASE("verticals that touch ends and insides") {
        check({segment(2, 0, 2, 6), segment(0, 0, 2, 0), segment(2, 3, 5, 3), segment(0, 6, 2, 6),
               segment(0, 2, 4, 2), segment(2, 6, 2, 8), segment(2, 7, 4, 9)},
              {{2, 1, 1}, {2, 9, 1}});
    }
    SUBCASE("nested squares: faces inside faces") {
        std::vector<Segment> squares;
        for (int i = 0; i < 4; ++i) {
            const int a = i, b = 12 - i;
            squares.insert(squares.end(), {segment(a, a, b, a), segment(b, a, b, b), segment(a, b, b, b),
                                           segment(a, a, a, b)});
        }
        check(squares, {{6, 6, 1}, {1, 2, 4}, {20, 20, 1}});
    }
}

TEST_CASE("sweep: chains that cross and overlap many times have the faces of their segments") {
    SegmentGeometry flat;
    PolylineGeometry g;
    std::mt19937_64 rng(test_seed());
    for (int round = 0; round < 150; ++round) {
        CAPTURE(round);
        const int height = 1 + round % 4;  // low grids make overlaps that begin and end inside chains
        std::uniform_int_distribution x(0, 12), y(0, height);
        std::vector<PolylineGeometry::Arc> chains;
        std::vector<Segment> segments;
        for (int i = 0; i < 5; ++i) {
            std::set<int> xs;
            for (int j = 0; j < 9; ++j) xs.insert(x(rng));
            PolylineGeometry::Arc chain;
            int from = -1, at = y(rng);
            for (const int to : xs) {
                const int next = y(rng);
                if (from >= 0) chain.push_back(SegmentGeometry::segment(from, at, to, next));
                from = to;
                at = next;
            }
            segments.insert(segments.end(), chain.begin(), chain.end());
            chains.push_back(chain);
        }
        chains.push_back({SegmentGeometry::segment(6, 0, 6, height)});
        segments.push_back(chains.back().front());

        const auto a = arrange<PolylineGeometry>(g, chains);
        REQUIRE(arrangement_defect(g, a) == "");
        const auto b = arrange<SegmentGeometry>(flat, segments);
        REQUIRE(a.dcel.face_count() == b.dcel.face_count());
        REQUIRE(component_count(a.dcel) == component_count(b.dcel));
        std::vector<Point> queries(b.points.begin(), b.points.end());
        Grid grid(rng(), 12);
        for (int i = 0; i < 20; ++i) queries.push_back(grid.fine_point());
        check_location(g, a, queries);

        const std::vector half(chains.begin() + 3, chains.end());
        chains.resize(3);
        const auto both =
            overlay(g, arrange<PolylineGeometry>(g, chains), arrange<PolylineGeometry>(g, half));
        REQUIRE(arrangement_defect(g, both) == "");
        REQUIRE(both.dcel.face_count() == a.dcel.face_count());
    }
}

TEST_CASE("sweep: elements name the input they come from") {
    SegmentGeometry g;
    const auto segment = SegmentGeometry::segment;
    SweepInput<SegmentGeometry> input;
    input.add_arc(g, segment(0, 0, 6, 0));   // 0, points 0 and 1
    input.add_arc(g, segment(2, 0, 4, 0));   // 1, points 2 and 3: overlaps 0
    input.add_arc(g, segment(3, -2, 3, 2));  // 2, points 4 and 5: crosses both
    input.points.push_back({3, 0, 1});       // 6: at the crossing
    const auto swept = sweep(g, input);
    REQUIRE(arrangement_defect(g, swept.arrangement) == "");
    const auto set = [](std::span<const std::uint32_t> s) {
        return std::set<std::uint32_t>(s.begin(), s.end());
    };
    using Set = std::set<std::uint32_t>;
    // Vertices: (0,0) (2,0) (3,-2) (3,0) (3,2) (4,0) (6,0).
    REQUIRE(swept.vertex_points.size() == 7);
    CHECK(set(swept.vertex_points[0]) == Set{0});
    CHECK(set(swept.vertex_points[1]) == Set{2});
    CHECK(set(swept.vertex_arcs[1]) == Set{0});
    CHECK(set(swept.vertex_points[3]) == Set{6});
    CHECK(set(swept.vertex_arcs[3]) == Set{0, 1, 2});
    CHECK(set(swept.vertex_points[5]) == Set{3});
    CHECK(set(swept.vertex_arcs[5]) == Set{0});
    // Edges by left vertex: (0,0)-(2,0), (2,0)-(3,0), (3,-2)-(3,0), (3,0)-(4,0), (3,0)-(3,2), (4,0)-(6,0).
    REQUIRE(swept.edge_arcs.size() == 6);
    CHECK(set(swept.edge_arcs[0]) == Set{0});
    CHECK(set(swept.edge_arcs[1]) == Set{0, 1});
    CHECK(set(swept.edge_arcs[2]) == Set{2});
    CHECK(set(swept.edge_arcs[3]) == Set{0, 1});
    CHECK(set(swept.edge_arcs[4]) == Set{2});
    CHECK(set(swept.edge_arcs[5]) == Set{0});
}

TEST_CASE("sweep: inserting arcs one by one gives what sweeping over all gives") {
    SegmentGeometry g;
    for (int round = 0; round < 30; ++round) {
        Grid grid(test_seed() + static_cast<std::uint64_t>(round), 5);
        std::vector<Segment> segments;
        Arrangement<SegmentGeometry> grown;
        for (int i = 0; i < 10; ++i) {
            segments.push_back(grid.segment());
            grown = insert(g, grown, segments.back());
            REQUIRE(arrangement_defect(g, grown) == "");
            REQUIRE(same_topology(grown.dcel, arrange<SegmentGeometry>(g, segments).dcel));
        }
    }
}

TEST_CASE("sweep: answers that contradict each other are reported") {
    // Denies that the middle one of five lines through a point meets the others.
    struct Liar : SegmentGeometry {
        void intersect(const Arc& a, const Arc& b, ArcIntersections<Point, Arc>& out) const {
            if (a.dy != 0 && b.dy != 0) SegmentGeometry::intersect(a, b, out);
        }
    };
    Liar g;
    std::vector<Segment> lines;
    for (int i = -2; i <= 2; ++i) lines.push_back(SegmentGeometry::segment(0, 4 - i, 8, 4 + i));
    CHECK_THROWS_AS(arrange<Liar>(g, lines), InternalError);
}

TEST_CASE("sweep: a pair of arcs is intersected once at most") {
    struct Counting : SegmentGeometry {
        std::set<std::pair<std::int64_t, std::int64_t>> seen;
        std::size_t calls = 0;
        void intersect(const Arc& a, const Arc& b, ArcIntersections<Point, Arc>& out) {
            ++calls;
            seen.insert(std::minmax(a.c, b.c));  // the lines of this test have different constants
            SegmentGeometry::intersect(a, b, out);
        }
    };
    Counting g;
    std::vector<Segment> lines;
    for (int i = 0; i < 20; ++i)
        lines.push_back(SegmentGeometry::segment(0, 7 * i * i + 1, 100, 2000 - 130 * i));
    arrange<Counting>(g, lines);
    CHECK(g.calls == g.seen.size());
    CHECK(g.calls >= 190);  // all pairs cross
}

}  // namespace vcell::sweep_test
