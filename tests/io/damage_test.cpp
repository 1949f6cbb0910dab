/// certify() on good cells that were damaged: every damage is objected to, and where it is. And on cells that
/// look strange and are right.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <span>
#include <stdexcept>

#include "../../envelope/voronoi_cell.hpp"
#include "../../io/check/check.hpp"
#include "../../io/files/scene_file.hpp"
#include "../test_support.hpp"
#include "damages.hpp"
#include "listing.hpp"

namespace vcell {

using namespace damages;

namespace {

struct Damage {
    std::string cell;   ///< the good one
    std::string what;   ///< is done to it
    std::string where;  ///< must be refuted, or a part of it; '#' stands for the number that make returns
    std::function<std::size_t(Cell&)> make;
};

bool names(const std::string& place, const std::string& where) {
    if (!place.starts_with(where)) return false;
    const char after = place.size() > where.size() ? place[where.size()] : '.';
    return after == '.' || after == '[';
}

/// Objected to, and refuted at that place.
void expect_refuted(const Damage& damage) {
    CAPTURE(damage.cell);
    CAPTURE(damage.what);
    Cell bad = good(damage.cell);
    const std::size_t number = damage.make(bad);
    std::string where = damage.where;
    if (const auto hash = where.find('#'); hash != std::string::npos)
        where.replace(hash, 1, std::to_string(number));
    const Certificate certificate = certify(bad);
    CHECK_FALSE(certificate.holds());
    const bool refuted = std::ranges::any_of(certificate.elements, [&](const Element& e) {
        return e.verdict == Verdict::refuted && names(e.where, where);
    });
    CHECK_MESSAGE(refuted, "expected ", where, ", found\n", listing(certificate));
}

void expect_proved(const Cell& cell) {
    const Certificate certificate = certify(cell);
    CHECK_MESSAGE(certificate.holds(), listing(certificate));
}

void raise_all_errors(Cell& c, double error) {
    for (CellVertex& v : c.vertices) v.error = error;
    for (CellEdge& e : c.edges) e.error = error;
    c.measures.volume_error = c.measures.area_error = error;
}

}  // namespace

TEST_CASE("damage: the good cells are proved") {
    for (const std::string name : {"balls", "lattice", "needle", "tube lattice", "hexagonal tubes", "atom",
                                   "tubes over a plane", "tubes around a tube", "around a cylinder"}) {
        CAPTURE(name);
        expect_proved(good(name));
    }
}

TEST_CASE("damage: errors that promise nothing hide nothing") {
    const auto stretched = [](Cell& c) {
        raise_all_errors(c, 1e6);
        for (CellFace& f : c.faces)
            for (TrimmedPatch& p : f.patches) scale(p.surface, 1.25);
        c.measures.volume = 12345;
        return std::size_t{0};
    };
    std::vector<Damage> damages;
    for (const char* cell : {"balls", "atom", "tubes over a plane", "tubes around a tube"}) {
        damages.push_back(
            {cell, "every error 1e6, patches stretched, volume 12345", "measures.volume", stretched});
        damages.push_back(
            {cell, "every error 1e6, patches stretched, volume 12345", "faces[0].patches[0]", stretched});
        damages.push_back({cell, "every error 1e6", "vertices[0]", [](Cell& c) {
                               raise_all_errors(c, 1e6);
                               return std::size_t{0};
                           }});
        damages.push_back({cell, "one edge's error 1e6, all areas doubled", "faces[#].area", [](Cell& c) {
                               c.edges[inner_edge(c)].error = 1e6;
                               for (CellFace& f : c.faces) f.area *= 2;
                               c.measures.area *= 2;
                               c.measures.box_area *= 2;
                               return std::size_t{owned_face(c)};
                           }});
        damages.push_back({cell, "one edge's error 1e6", "edges[#]", [](Cell& c) {
                               c.edges[inner_edge(c)].error = 1e6;
                               return std::size_t{inner_edge(c)};
                           }});
        damages.push_back({cell, "volume x 3, volume_error 1e9", "measures.volume", [](Cell& c) {
                               c.measures.volume *= 3;
                               c.measures.volume_error = 1e9;
                               return std::size_t{0};
                           }});
        damages.push_back({cell, "area x 3, area_error 1e9", "measures.area", [](Cell& c) {
                               c.measures.area *= 3;
                               c.measures.area_error = 1e9;
                               return std::size_t{0};
                           }});
    }
    for (const Damage& d : damages) expect_refuted(d);
}

TEST_CASE("damage: errors of 0 where there are some") {
    std::vector<Damage> damages;
    for (const char* cell : {"balls", "atom", "tubes over a plane", "tubes around a tube"}) {
        damages.push_back({cell, "a vertex error of 0", "vertices[#]", [](Cell& c) {
                               c.vertices[inner_vertex(c)].error = 0;
                               return std::size_t{inner_vertex(c)};
                           }});
        damages.push_back({cell, "a volume error of 0", "measures.volume", [](Cell& c) {
                               c.measures.volume_error = 0;
                               return std::size_t{0};
                           }});
        damages.push_back({cell, "an area error of 0", "measures.area", [](Cell& c) {
                               c.measures.area_error = 0;
                               return std::size_t{0};
                           }});
    }
    for (const char* cell : {"tubes over a plane", "tubes around a tube"})
        damages.push_back({cell, "a fitted edge's error of 0", "edges[#]", [](Cell& c) {
                               c.edges[spline(c)].error = 0;
                               return std::size_t{spline(c)};
                           }});
    for (const Damage& d : damages) expect_refuted(d);
}

TEST_CASE("damage: a face is missing, and all else agrees") {
    for (const std::string name : {"balls", "atom", "tubes over a plane", "tubes around a tube"})
        for (const double area : {0.02, 1e-3, 1e-5, 1e-8}) {
            CAPTURE(name);
            CAPTURE(area);
            const Cell& cell = good(name);
            const Site& owner = cell.vertices[farthest_vertex(cell)].sites[0];
            const std::uint32_t f =
                first(cell.faces, [&](const CellFace& face) { return face.site == owner; });
            const Certificate certificate = certify(
                missing_face(cell, inside_of(cell.faces[f]), std::span(&cell.faces[f].site, 1), area));
            CHECK_FALSE(certificate.holds());
            const bool refuted = std::ranges::any_of(certificate.elements, [&](const Element& e) {
                return e.verdict == Verdict::refuted && names(e.where, "faces[" + std::to_string(f) + "]");
            });
            CHECK_MESSAGE(refuted, listing(certificate));
        }
    // At a vertex three faces have a corner too much.
    for (const std::string name : {"balls", "atom"})
        for (const double area : {1e-3, 1e-8}) {
            CAPTURE(name);
            CAPTURE(area);
            const Cell& cell = good(name);
            const std::uint32_t v = farthest_vertex(cell);
            const Certificate certificate =
                certify(missing_face(cell, cell.vertices[v].point, cell.vertices[v].sites, area));
            CHECK_FALSE(certificate.holds());
            const bool refuted = std::ranges::any_of(certificate.elements, [&](const Element& e) {
                return e.verdict == Verdict::refuted && names(e.where, "vertices[" + std::to_string(v) + "]");
            });
            CHECK_MESSAGE(refuted, listing(certificate));
        }
}

TEST_CASE("damage: the structure says what is not there") {
    const auto erase_face = [](Cell& c) {
        c.faces.erase(c.faces.begin() + owned_face(c));
        return std::size_t{0};
    };
    const auto isolate = [](Cell& c) {
        const CellEdge& e = c.edges[inner_edge(c)];
        CellVertex v;
        v.point = e.curve.evaluate(0.5 * (e.curve.domain_begin() + e.curve.domain_end()));
        const auto* plane = std::get_if<Plane>(&c.scene.base);
        const auto* sphere = std::get_if<Sphere>(&c.scene.base);
        const auto* tube = std::get_if<Cylinder>(&c.scene.base);
        if (plane) v.radius = plane->normal.normalized().dot(v.point - plane->point);
        if (sphere) v.radius = (v.point - sphere->center).norm() - sphere->radius;
        if (tube) v.radius = tube->axis.normalized().cross(v.point - tube->point).norm() - tube->radius;
        v.sites = {e.sites[0], e.sites[1]};
        std::ranges::sort(v.sites);
        v.error = std::max(c.vertices[0].error, e.error);
        c.vertices.push_back(v);
        return c.vertices.size() - 1;
    };
    const std::vector<Damage> damages{
        {"lattice", "a vertex of four sites split by an edge of length zero", "edges[#]",
         [](Cell& c) {
             split_vertex(c, first(c.vertices,
                                   [](const CellVertex& v) { return is_inner(v) && v.sites.size() == 4; }));
             return c.edges.size() - 1;
         }},
        {"balls", "a face cut by an edge between it and itself", "edges[#]",
         [](Cell& c) {
             cut_face(c, first(c.faces, [](const CellFace& f) {
                          return f.site.is_object() && f.patches[0].loops[0].size() >= 4;
                      }));
             return c.edges.size() - 1;
         }},
        {"balls", "an isolated vertex on an edge", "vertices[#]", isolate},
        {"atom", "an isolated vertex on an edge", "vertices[#]", isolate},
        {"tubes around a tube", "an isolated vertex on an edge", "vertices[#]", isolate},
        {"balls", "a face forgotten", "edges", erase_face},
        {"atom", "a face forgotten", "edges", erase_face},
        {"around a cylinder", "a face forgotten", "edges", erase_face},
        {"lattice", "a vertex of four sites lists three", "vertices[#]",
         [](Cell& c) {
             const auto v = first(c.vertices, [](const CellVertex& x) { return x.sites.size() == 4; });
             c.vertices[v].sites.pop_back();
             return std::size_t{v};
         }},
        {"hexagonal tubes", "warnings removed", "report",
         [](Cell& c) {
             REQUIRE(c.report.decisions.assumed > 0);
             c.report.warnings.clear();
             return std::size_t{0};
         }},
        {"hexagonal tubes", "coincidences that nobody assumed", "report",
         [](Cell& c) {
             c.report.decisions.assumed = 0;
             return std::size_t{0};
         }},
        {"balls", "an edge's sites exchanged", "edges[#]",
         [](Cell& c) {
             const auto e = inner_edge(c);
             std::swap(c.edges[e].sites[0], c.edges[e].sites[1]);
             return std::size_t{e};
         }},
        {"tubes around a tube", "a face given to another site", "faces[#].site",
         [](Cell& c) {
             const auto f = owned_face(c);
             c.faces[f].site = Site::object((c.faces[f].site.index + 1) %
                                            static_cast<std::uint32_t>(c.scene.objects.size()));
             return std::size_t{f};
         }},
        {"around a cylinder", "a seam that leads nowhere", "faces",
         [](Cell& c) {
             seam(c).seam = 1000;
             return std::size_t{0};
         }},
        {"around a cylinder", "a seam that bends on one side", "faces",
         [](Cell& c) {
             auto& points = seam(c).curve.points;
             points[points.size() / 2].x() += 1e-3;
             return std::size_t{0};
         }},
        {"atom", "neighbours in another order", "neighbors",
         [](Cell& c) {
             std::swap(c.neighbors.front(), c.neighbors.back());
             return std::size_t{0};
         }},
        {"atom", "a neighbour forgotten", "neighbors",
         [](Cell& c) {
             c.neighbors.pop_back();
             return std::size_t{0};
         }},
        {"balls", "the box not touched", "measures.touches_box",
         [](Cell& c) {
             c.measures.touches_box = false;
             return std::size_t{0};
         }},
        {"atom", "a loop run the other way", "faces[#].patches[0].loops[0]",
         [](Cell& c) {
             const auto f = owned_face(c);
             auto& loop = c.faces[f].patches[0].loops[0];
             std::ranges::reverse(loop);
             return std::size_t{f};
         }},
    };
    for (const Damage& d : damages) expect_refuted(d);
}

// A site that ties all along an edge as far as doubles tell may yet be farther: open, not refuted.
TEST_CASE("damage: extra sites of an edge removed") {
    Cell cell = good("tube lattice");
    const auto e = first(cell.edges, [](const CellEdge& edge) { return !edge.extra_sites.empty(); });
    cell.edges[e].extra_sites.clear();
    const Certificate certificate = certify(cell);
    CHECK_FALSE(certificate.holds());
    CHECK(std::ranges::any_of(certificate.elements, [&](const Element& x) {
        return x.verdict != Verdict::proved && names(x.where, "edges[" + std::to_string(e) + "]");
    }));
}

TEST_CASE("damage: points, curves and patches moved") {
    std::vector<Damage> damages{
        {"needle", "a vertex of nearly parallel bisectors moved along its bad direction", "vertices[#]",
         [](Cell& c) {
             const auto v = inner_vertex(c);
             c.vertices[v].point += 30 * c.vertices[v].error * bad_direction(c, v);
             return std::size_t{v};
         }},
        {"twin planes", "a vertex of planes 1e-14 apart moved along both", "vertices[#]",
         [](Cell& c) {
             const auto v = first(c.vertices, [](const CellVertex& vertex) {
                 return vertex.sites.size() == 3 && vertex.sites[0] == Site::object(1) &&
                        vertex.sites[1] == Site::object(3) && !vertex.sites[2].is_object();
             });
             Vec3& p = c.vertices[v].point;
             const Vec3 bisector = gradient(c.scene.objects[1], p) - gradient(c.scene.base, p);
             p += 1e-3 * bisector.cross(Vec3::Unit(c.vertices[v].sites[2].index / 2)).normalized();
             return std::size_t{v};
         }},
        {"atom", "a patch for another ball", "faces[#].patches[0]",
         [](Cell& c) {
             const auto f = owned_face(c);
             scale(c.faces[f].patches[0].surface, 1 + 1e-8);
             return std::size_t{f};
         }},
        {"around a cylinder", "a rim moved along the axis", "edges[#]", [](Cell& c) {
             const auto e = first(c.edges, [](const CellEdge& edge) {
                 return edge.sites[0].kind == Site::Kind::End || edge.sites[1].kind == Site::Kind::End;
             });
             const Vec3 along = std::get<Cylinder>(c.scene.base).axis.normalized();
             for (auto& p : c.edges[e].curve.points) p.head<3>() += 1e-5 * along;
             return std::size_t{e};
         }}};
    for (const char* cell : {"balls", "atom", "tubes over a plane", "tubes around a tube"}) {
        damages.push_back({cell, "a vertex moved", "vertices[#]", [](Cell& c) {
                               const auto v = inner_vertex(c);
                               c.vertices[v].point.x() += 1e-7;
                               return std::size_t{v};
                           }});
        damages.push_back({cell, "a vertex without sites", "vertices[#].sites", [](Cell& c) {
                               c.vertices[inner_vertex(c)].sites.clear();
                               return std::size_t{inner_vertex(c)};
                           }});
        damages.push_back({cell, "a vertex without one of its sites", "vertices[#]", [](Cell& c) {
                               const auto v = inner_vertex(c);
                               c.vertices[v].sites.pop_back();
                               return std::size_t{v};
                           }});
        damages.push_back({cell, "a wrong clearance", "vertices[#]", [](Cell& c) {
                               const auto v = inner_vertex(c);
                               c.vertices[v].radius += 1e-8;
                               return std::size_t{v};
                           }});
        damages.push_back({cell, "an edge's control point moved", "edges[#]", [](Cell& c) {
                               const auto e = inner_edge(c);
                               auto& points = c.edges[e].curve.points;
                               points[points.size() / 2].x() += 1e-4;
                               return std::size_t{e};
                           }});
        damages.push_back({cell, "a trimming curve moved", "faces[#]", [](Cell& c) {
                               const auto f = owned_face(c);
                               auto& points = c.faces[f].patches[0].loops[0][0].curve.points;
                               points[points.size() / 2].x() += 1e-4;
                               return std::size_t{f};
                           }});
        damages.push_back({cell, "a patch's control point moved", "faces[#]", [](Cell& c) {
                               const auto f = owned_face(c);
                               auto& points = c.faces[f].patches[0].surface.points;
                               points[points.size() / 2].head<3>() *= 1 + 1e-4;
                               return std::size_t{f};
                           }});
    }
    for (const char* cell : {"tubes over a plane", "tubes around a tube"}) {
        damages.push_back({cell, "a spline with a bump between sample points", "edges[#]", [](Cell& c) {
                               const auto e = spline(c);
                               bump<3>(c.edges[e].curve, Vec3(1e-4, 1e-4, 1e-4));
                               return std::size_t{e};
                           }});
        damages.push_back(
            {cell, "a trimming curve with a bump between sample points", "faces[#]", [](Cell& c) {
                 const auto e = spline(c);
                 std::size_t face = 0;
                 TrimCurve* found = nullptr;
                 for_each_trim(c, [&](std::size_t f, TrimCurve& trim) {
                     if (found || trim.edge != e) return;
                     found = &trim;
                     face = f;
                 });
                 bump<2>(found->curve, Vec2(1e-4, 1e-4));
                 return face;
             }});
    }
    for (const Damage& d : damages) expect_refuted(d);
}

TEST_CASE("damage: measures that are not the cell's") {
    std::vector<Damage> damages;
    const auto add = [&](const char* cell, const char* what, const char* where, auto change) {
        damages.push_back({cell, what, where, [change](Cell& c) {
                               change(c);
                               return std::size_t{owned_face(c)};
                           }});
    };
    for (const char* cell : {"balls", "atom", "tubes over a plane", "tubes around a tube"}) {
        add(cell, "a volume off by ten times its error and 1e-9", "measures.volume",
            [](Cell& c) { c.measures.volume += 10 * c.measures.volume_error + 1e-9; });
        add(cell, "an area off by ten times its error and 1e-8 of it", "measures.area",
            [](Cell& c) { c.measures.area -= 10 * c.measures.area_error + 1e-8 * c.measures.area; });
        add(cell, "a face's area off", "faces[#].area",
            [](Cell& c) { c.faces[owned_face(c)].area *= 1 + 1e-3; });
        add(cell, "an edge's length off", "edges",
            [](Cell& c) { c.edges[inner_edge(c)].length *= 1 + 1e-4; });
        add(cell, "a wrong base area", "measures.base_area",
            [](Cell& c) { c.measures.base_area *= 1 + 1e-9; });
        add(cell, "a wrong box area", "measures.box_area", [](Cell& c) { c.measures.box_area += 1e-2; });
        add(cell, "a wrong body", "measures.body_volume", [](Cell& c) { c.measures.body_volume += 1e-9; });
        add(cell, "a least clearance too large", "measures.min_clearance",
            [](Cell& c) { c.measures.min_clearance += 1e-5; });
        add(cell, "a least clearance too small", "measures.min_clearance",
            [](Cell& c) { c.measures.min_clearance -= 1e-5; });
        add(cell, "a greatest clearance too large", "measures.max_clearance",
            [](Cell& c) { c.measures.max_clearance += 1e-5; });
        add(cell, "no volume", "measures.volume", [](Cell& c) { c.measures.volume = not_measured; });
    }
    for (const Damage& d : damages) expect_refuted(d);
}

TEST_CASE("damage: right cells are not accused") {
    SUBCASE("tubes that stand on the plane: their cones are circular") {
        expect_proved(voronoi_cell(
            over_the_plane({Cylinder{{2.6, 0.2, 0}, {0, 0, 1}, 0.25}, Sphere{{-1, 0.5, 0.8}, 0.2}})));
    }
    SUBCASE("units so small or large that areas leave the doubles' middle") {
        for (const double unit : {1e-40, 0x1p-100, 0x1p100}) {
            CAPTURE(unit);
            Scene scene = balls();
            for (Object& o : scene.objects) {
                if (auto* s = std::get_if<Sphere>(&o)) *s = {unit * s->center, unit * s->radius};
                if (auto* p = std::get_if<Plane>(&o)) p->point *= unit;
            }
            scene.box = {unit * scene.box.min, unit * scene.box.max};
            expect_proved(voronoi_cell(scene));
        }
    }
    SUBCASE("tiny faces") {
        for (const double area : {1e-4, 1e-8, 1e-11}) {
            CAPTURE(area);
            const Cell& cell = good("balls");
            const Cell lacking = missing_face(cell, inside_of(cell.faces[owned_face(cell)]),
                                              std::span(&cell.faces[owned_face(cell)].site, 1), area);
            expect_proved(voronoi_cell(lacking.scene));
        }
    }
    SUBCASE("no objects") {
        expect_proved(voronoi_cell(over_the_plane({})));
        Scene scene;
        scene.box = {{-2, -1, -1}, {1, 2, 3}};
        for (const Object& base :
             {Object(Sphere{{0.1, 0.2, 0.3}, 0.5}), Object(Cylinder{{0, 0, 0}, {0, 0.3, 1}, 0.25})}) {
            scene.base = base;
            expect_proved(voronoi_cell(scene));
        }
    }
    SUBCASE("closed edges") { expect_proved(voronoi_cell(example("island"))); }
}

}  // namespace vcell
