#include <doctest/doctest.h>

#include <random>

#include "check_arrangement.hpp"
#include "segment_geometry.hpp"
#include "test_support.hpp"
#include "vcell/arrangement/sweep/overlay.hpp"

namespace vcell::overlay_test {
using Geometry = SegmentGeometry;
using Point = Geometry::Point;

namespace {

/// Keeps what it is told.
struct Origins {
    IdVector<VertexId, std::array<Feature, 2>> vertices;
    IdVector<EdgeId, std::array<Feature, 2>> edges;
    IdVector<FaceId, std::array<FaceId, 2>> faces;

    void vertex(VertexId v, Feature a, Feature b) {
        REQUIRE(v.value == vertices.size());
        vertices.push_back({a, b});
    }
    void edge(EdgeId e, Feature a, Feature b) {
        REQUIRE(e.value == edges.size());
        edges.push_back({a, b});
    }
    void face(FaceId f, FaceId a, FaceId b) {
        REQUIRE(f.value == faces.size());
        faces.push_back({a, b});
    }
};

struct Random {
    std::mt19937_64 rng;
    int size;

    int coordinate() { return std::uniform_int_distribution(0, size)(rng); }
    Arrangement<Geometry> arrangement(int n) {
        Geometry g;
        std::vector<Geometry::Arc> segments;
        std::vector<Point> points;
        while (static_cast<int>(segments.size()) < n) {
            const int x0 = coordinate(), y0 = coordinate(), x1 = coordinate(), y1 = coordinate();
            if (x0 != x1 || y0 != y1) segments.push_back(Geometry::segment(x0, y0, x1, y1));
        }
        // A closed polygon makes islands and faces with holes likely.
        const int x = coordinate(), y = coordinate(), s = 1 + coordinate();
        segments.insert(segments.end(),
                        {Geometry::segment(x, y, x + s, y), Geometry::segment(x + s, y, x + s, y + s),
                         Geometry::segment(x, y + s, x + s, y + s), Geometry::segment(x, y, x, y + s)});
        for (int i = 0; i < n / 4; ++i) points.push_back({coordinate(), coordinate(), 1});
        return arrange<Geometry>(g, segments, points);
    }
    Point point() {
        const int w = 7;  // most such points lie on no edge
        std::uniform_int_distribution c(-w, w * 2 * (size + 1));
        return {c(rng), c(rng), w};
    }
};

}  // namespace

TEST_CASE("overlay: elements name the elements of the inputs that hold them") {
    Geometry g;
    Random random{std::mt19937_64(test_seed()), 6};
    for (int round = 0; round < 60; ++round) {
        CAPTURE(round);
        const auto a = random.arrangement(round % 8), b = random.arrangement(round / 8);
        Origins origins;
        const auto c = overlay(g, a, b, origins);
        REQUIRE(arrangement_defect(g, c) == "");
        REQUIRE(origins.vertices.size() == c.dcel.vertex_count());
        REQUIRE(origins.edges.size() == c.dcel.edge_count());
        REQUIRE(origins.faces.size() == c.dcel.face_count());

        std::vector<Point> points(c.points.begin(), c.points.end());
        for (int i = 0; i < 60; ++i) points.push_back(random.point());
        // Points inside edges: where the median between the ends of a segment is.
        for (const auto& arc : c.arcs) {
            const auto &l = arc.left, &r = arc.right;
            const Point middle{l.x * r.w + r.x * l.w, l.y * r.w + r.y * l.w, 2 * l.w * r.w};
            REQUIRE(std::max({std::abs(middle.x), std::abs(middle.y), middle.w}) < std::int64_t{1} << 40);
            points.push_back(middle);
        }
        for (const Point& p : points) {
            const Feature in_a = locate_by_walk(g, a, p), in_b = locate_by_walk(g, b, p);
            const std::array expected{in_a, in_b};
            const Feature in_c = locate_by_walk(g, c, p);
            if (const auto* v = std::get_if<VertexId>(&in_c)) REQUIRE(origins.vertices[*v] == expected);
            if (const auto* e = std::get_if<EdgeId>(&in_c)) REQUIRE(origins.edges[*e] == expected);
            if (const auto* f = std::get_if<FaceId>(&in_c)) {
                const std::array<Feature, 2> faces{origins.faces[*f][0], origins.faces[*f][1]};
                REQUIRE(faces == expected);
            }
        }
    }
}

TEST_CASE("overlay: commutes, up to swapping the origins") {
    Geometry g;
    Random random{std::mt19937_64(test_seed() + 1), 5};
    for (int round = 0; round < 40; ++round) {
        const auto a = random.arrangement(6), b = random.arrangement(6);
        Origins ab, ba;
        REQUIRE(same_topology(overlay(g, a, b, ab).dcel, overlay(g, b, a, ba).dcel));
        const auto swapped = [](const auto& list, const auto& other) {
            for (const auto id : list.ids()) {
                if (list[id][0] != other[id][1] || list[id][1] != other[id][0]) return false;
            }
            return true;
        };
        CHECK(swapped(ab.vertices, ba.vertices));
        CHECK(swapped(ab.edges, ba.edges));
        CHECK(swapped(ab.faces, ba.faces));
    }
}

TEST_CASE("overlay: with itself, and with nothing, is itself") {
    Geometry g;
    Random random{std::mt19937_64(test_seed() + 2), 5};
    for (int round = 0; round < 40; ++round) {
        const auto a = random.arrangement(8);
        Origins twice;
        REQUIRE(same_topology(overlay(g, a, a, twice).dcel, a.dcel));
        for (const VertexId v : twice.vertices.ids())
            REQUIRE(twice.vertices[v] == std::array<Feature, 2>{v, v});
        for (const EdgeId e : twice.edges.ids()) REQUIRE(twice.edges[e] == std::array<Feature, 2>{e, e});
        for (const FaceId f : twice.faces.ids()) REQUIRE(twice.faces[f] == std::array{f, f});
        REQUIRE(same_topology(overlay(g, a, Arrangement<Geometry>()).dcel, a.dcel));
        REQUIRE(same_topology(overlay(g, Arrangement<Geometry>(), a).dcel, a.dcel));
    }
}

TEST_CASE("overlay: is associative") {
    Geometry g;
    Random random{std::mt19937_64(test_seed() + 3), 5};
    for (int round = 0; round < 40; ++round) {
        const auto a = random.arrangement(4), b = random.arrangement(4), c = random.arrangement(4);
        REQUIRE(same_topology(overlay(g, overlay(g, a, b), c).dcel, overlay(g, a, overlay(g, b, c)).dcel));
    }
}

TEST_CASE("overlay: an island inside a face lies in that face of the other input") {
    Geometry g;
    const auto square = [&](int a, int b) {
        const std::vector segments{Geometry::segment(a, a, b, a), Geometry::segment(b, a, b, b),
                                   Geometry::segment(a, b, b, b), Geometry::segment(a, a, a, b)};
        return arrange<Geometry>(g, segments);
    };
    const auto outer = square(0, 9), inner = square(3, 6);
    Origins origins;
    const auto both = overlay(g, outer, inner, origins);
    REQUIRE(both.dcel.face_count() == 3);
    using Pair = std::array<FaceId, 2>;
    CHECK(origins.faces[FaceId{0}] == Pair{FaceId{0}, FaceId{0}});
    CHECK(origins.faces[FaceId{1}] == Pair{FaceId{1}, FaceId{0}});
    CHECK(origins.faces[FaceId{2}] == Pair{FaceId{1}, FaceId{1}});
    CHECK(both.dcel.inner_ccbs(FaceId{1}).size() == 1);
}

}  // namespace vcell::overlay_test
