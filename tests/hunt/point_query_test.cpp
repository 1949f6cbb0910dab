// Points asked about one by one, against distances by hand.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <optional>
#include <random>
#include <string>

#include "../../core/errors.hpp"
#include "../../envelope/diagram/minimization_diagram.hpp"
#include "../../envelope/point_query.hpp"
#include "../../envelope/recursion/form_locator.hpp"
#include "../../primitives/bases/plane_base.hpp"
#include "../../primitives/bases/radial_base.hpp"
#include "../../primitives/objects/decided_scene.hpp"
#include "../primitives/reference.hpp"
#include "families.hpp"
#include "test_support.hpp"

namespace vcell::point_query_test {
using namespace vcell::hunt;

namespace {

// How far p is from the nearest object that competes; negative in the solid of one, where no point is in the
// cell. The box clips cells, p lies in it.
double least_distance(const Scene& scene, const Vec3& p) {
    double least = scene.box.diagonal();
    for (std::size_t i = 0; i < scene.objects.size(); ++i)
        if (scene.competes(i)) least = std::min(least, distance(scene.objects[i], p));
    return least;
}

}  // namespace

TEST_CASE("point query: inside is nearer to the base than to all else, over every base") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> part(0, 1);
    int judged = 0, inside = 0, outside = 0, undecided = 0;
    for (const char* name : {"balls", "mix", "tubes", "integers", "lattice", "bundle", "beads", "crossings",
                             "pierced", "vessels", "silos", "nested"})
        for (const BaseKind base : base_kinds)
            for (int round = 0; round < 2 * rounds(); ++round) {
                const auto family = std::ranges::find(families(), std::string(name), &Family::name);
                const Scene scene = family->make(rng, base);
                CAPTURE(std::string(name));
                CAPTURE(to_string(base));
                std::optional<PointQuery> query;
                try {
                    query.emplace(scene);
                } catch (const UndecidedError&) {
                    ++undecided;
                    continue;
                } catch (const InputError&) {
                    CHECK_FALSE(is_legal(scene));
                    continue;
                }
                const double size = scene.box.diagonal();
                for (int k = 0; k < 40; ++k) {
                    const Vec3 p =
                        scene.box.min +
                        Vec3(part(rng), part(rng), part(rng)).cwiseProduct(scene.box.max - scene.box.min);
                    const auto answer = (*query)(p);
                    if (!answer) continue;
                    const bool behind =
                        std::holds_alternative<Plane>(scene.base) &&
                        std::get<Plane>(scene.base).normal.dot(p - std::get<Plane>(scene.base).point) < 0;
                    const double nearest = least_distance(scene, p), own = distance(scene.base, p),
                                 slack = nearest - own;
                    // What a base's body holds belongs to the cell unless something else reaches in.
                    if (std::abs(slack) < 1e-9 * size || behind || nearest < 0 || own < 0) continue;
                    ++judged;
                    ++(slack > 0 ? inside : outside);
                    CHECK(answer->inside == (slack > 0));
                }
            }
    CHECK(judged > 500);
    CHECK(inside > 50);
    CHECK(outside > 50);
    CHECK(undecided <= rounds());  // nested walls may be as near in every direction
}

TEST_CASE("form locator: the form that comparing all of them finds, ties included") {
    std::mt19937_64 rng(test_seed());
    const auto compare = [&](const FormFamily& family, const std::array<double, 4>& box,
                             const auto& is_outside) {
        std::vector<FormId> all(family.size());
        for (std::uint32_t i = 0; i < all.size(); ++i) all[i] = FormId{i};
        FormLocator locator(family, all, box);
        std::uniform_real_distribution<double> x(box[0], box[1]), y(box[2], box[3]);
        int compared = 0;
        for (int k = 0; k < 60; ++k) {
            double px = x(rng), py = y(rng);
            // Places where the forms of small-integer scenes tie.
            if (k % 3 == 0) px = std::clamp(std::round(8 * px) / 8, box[0], box[1]);
            if (k % 3 == 0) py = std::clamp(std::round(8 * py) / 8, box[2], box[3]);
            if (is_outside(px, py)) continue;
            ++compared;
            CHECK(locator.lowest(px, py) == lowest_form(family, px, py));
        }
        return compared;
    };
    int compared = 0;
    for (const Family& family : families())
        for (const BaseKind base : base_kinds) {
            const Scene scene = family.make(rng, base);
            if (!is_legal(scene)) continue;
            CAPTURE(family.name);
            CAPTURE(to_string(base));
            const DecidedScene decided = decide(scene);
            try {
                if (std::holds_alternative<Plane>(scene.base)) {
                    const PlaneBaseProblem problem = plane_base_problem(decided.scene, decided.unit);
                    std::array<double, 4> box{HUGE_VAL, -HUGE_VAL, HUGE_VAL, -HUGE_VAL};
                    for (const Eigen::Vector2d& c : problem.corners)
                        box = {std::min(box[0], c.x()), std::max(box[1], c.x()), std::min(box[2], c.y()),
                               std::max(box[3], c.y())};
                    compared += compare(problem.family, box, [&](double x, double y) {
                        return std::ranges::any_of(problem.region, [&](const RegionSide& s) {
                            return !((s.a * Interval(x) + s.b * Interval(y) + Interval(s.c)).lower() > 0);
                        });
                    });
                } else {
                    const RadialBaseProblem problem = radial_base_problem(decided.scene, decided.unit);
                    const std::array<double, 4> box =
                        problem.chart.is_sphere()
                            ? std::array<double, 4>{-20, 20, -20, 20}
                            : std::array<double, 4>{-1, 3, problem.stretch[0], problem.stretch[1]};
                    compared += compare(problem.family, box, [](double, double) { return false; });
                }
            } catch (const UndecidedError&) {
            }
        }
    CHECK(compared > 2000);
}

}  // namespace vcell::point_query_test
