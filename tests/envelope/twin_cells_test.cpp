// Cells among objects that all but coincide, 1e-13 to 1e-4 apart, over all three bases: the edges between
// twins are where both are as far away, to a part of the distance between them, and the cell is that without
// one of the two but for as much.
#include <doctest/doctest.h>

#include <cmath>
#include <random>
#include <string>

#include "../../core/errors.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "../../envelope/voronoi_diagram.hpp"
#include "../primitives/radial_base_checks.hpp"
#include "test_support.hpp"

namespace vcell::twin_cells_test {

namespace {

class TwinCells {
public:
    double number(double lo, double hi) { return std::uniform_real_distribution(lo, hi)(rng_); }
    Vec3 vector() { return {number(-1, 1), number(-1, 1), number(-1, 1)}; }
    Vec3 direction() { return vector().normalized(); }

    // Base and twins are of each kind by turns: the twins are objects 0 and 1, and another tube is there.
    Scene scene(int round, double apart) {
        Scene s;
        s.box = {Vec3::Constant(-3), Vec3::Constant(3)};
        const int base = round % 3, kind = round / 3 % 3;
        if (base == 0) s.base = Plane{Vec3::Zero(), Vec3(0, 0, 1)};
        if (base == 1) s.base = Sphere{Vec3::Zero(), 0.3};
        if (base == 2) s.base = Cylinder{Vec3::Zero(), Vec3(0, 0, 1), 0.3};
        const auto across = [&] {
            const double angle = number(0, 6.28);
            return Vec3(std::cos(angle), std::sin(angle), 0);
        };
        const Vec3 out = base == 0   ? Vec3(0, 0, 1)
                         : base == 1 ? direction()
                                     : across(),
                   p = number(1, 1.8) * out, moved = p + apart * direction();
        if (kind == 0) {
            s.objects = {Sphere{p, 0.2}, Sphere{moved, 0.2 + apart * number(-1, 1)}};
        } else if (kind == 1) {
            const Vec3 n = (out + 0.2 * vector()).normalized();
            s.objects = {Plane{p, n}, Plane{moved, n + apart * direction()}};
        } else {
            const Vec3 axis = out.cross(direction()).normalized() + 0.1 * vector();
            s.objects = {Cylinder{p, axis, 0.1}, Cylinder{moved, -0.7 * (axis + apart * direction()), 0.1}};
        }
        s.objects.push_back(
            Cylinder{-2 * out + (base == 0 ? Vec3(0, 0, 4.5) : Vec3::Zero()), out.cross(direction()), 0.1});
        return s;
    }

private:
    std::mt19937_64 rng_{test_seed()};
};

}  // namespace

TEST_CASE("twins: edges between them are as far from both, to a part of what they are apart") {
    TwinCells twins;
    int asked = 0, decided = 0, edges = 0;
    for (int round = 0; round < 36 * rounds(); ++round) {
        // The length of a plane's normal is rounded, so that planes move against each other.
        const bool are_planes = round / 3 % 3 == 1;
        const double apart = std::pow(10, twins.number(are_planes ? -11 : -13, -4));
        Scene scene = twins.scene(round, apart);
        CAPTURE(round);
        CAPTURE(apart);
        ++asked;
        Cell cell;
        try {
            cell = voronoi_cell(scene);
        } catch (const UndecidedError&) {
            continue;
        } catch (const InputError&) {  // the third one may cut others
            --asked;
            continue;
        }
        ++decided;
        for (const CellEdge& e : cell.edges) {
            if (e.sites[0] != Site::object(0) && e.sites[0] != Site::object(1)) continue;
            if (e.sites[1] != Site::object(0) && e.sites[1] != Site::object(1)) continue;
            ++edges;
            CHECK(e.error < 1e-3);
            for (int i = 0; i <= 16; ++i) {
                const Vec3 p =
                    e.curve.evaluate(std::lerp(e.curve.domain_begin(), e.curve.domain_end(), i / 16.0));
                const auto gap = radial_base::distance(scene.objects[0], radial_base::real(p)) -
                                 radial_base::distance(scene.objects[1], radial_base::real(p));
                CHECK(std::abs(gap.convert_to<double>()) <= (0.02 * e.error + 1e-3) * apart);
            }
        }
        Scene single = scene;
        single.objects.erase(single.objects.begin() + 1);
        const Cell without = voronoi_cell(single);
        const double errors = cell.measures.volume_error + without.measures.volume_error,
                     shrunk = without.measures.volume - cell.measures.volume;
        CHECK(shrunk >= -errors);
        CHECK(shrunk <= 1000 * apart + errors);
    }
    CHECK(decided >= 0.8 * asked);
    CHECK(edges >= decided / 3);
}

TEST_CASE("twins: the cells of two that all but coincide are together that of one of them") {
    TwinCells twins;
    int asked = 0, decided = 0;
    for (int round = 0; round < 24 * rounds(); ++round) {
        const double apart = std::pow(10, twins.number(-9, -4));
        CAPTURE(round);
        CAPTURE(apart);
        DiagramScene scene;
        scene.box = {Vec3::Constant(-2), Vec3::Constant(2)};
        const Vec3 center = 0.3 * twins.vector(), way = apart * twins.direction(), axis = twins.direction();
        const double radius = round % 2 * 0.2;
        const bool are_balls = round % 4 < 2;
        const auto add = [&](const Vec3& p) {
            if (are_balls)
                scene.objects.emplace_back(Sphere{p, radius});
            else
                scene.objects.emplace_back(Cylinder{p, axis, radius});
        };
        add(center);
        const Vec3 across = axis.cross(twins.direction()).normalized(), up = axis.cross(across);
        scene.objects.emplace_back(Cylinder{center + across, up + 0.3 * twins.vector(), 0.1});
        scene.objects.emplace_back(Sphere{center - 1.1 * across + 0.3 * twins.vector(), 0.15});
        scene.objects.emplace_back(Sphere{center + 1.2 * up + 0.3 * twins.vector(), 0});
        const DiagramCell alone = voronoi_diagram(scene).cells.front();
        add(center + way);
        const VoronoiDiagram both = voronoi_diagram(scene);
        const DiagramCell &first = both.cells.front(), &second = both.cells.back();
        ++asked;
        if (alone.state != DiagramCell::State::Computed || first.state != DiagramCell::State::Computed ||
            second.state != DiagramCell::State::Computed)
            continue;
        ++decided;
        // What the second one takes of its neighbours' is no wider than they are apart.
        const double gained = apart * alone.area,
                     error = alone.volume_error + first.volume_error + second.volume_error;
        CHECK(std::abs(first.volume + second.volume - alone.volume) <= gained + error);
        // What rounding moves tubes by counts in parts of what they are apart.
        CHECK(error <= 1e-5 + 1e-10 / apart);
    }
    MESSAGE(decided, " of ", asked);
    CHECK(decided >= 0.85 * asked);
}

}  // namespace vcell::twin_cells_test
