// Differences of twins, as their coefficients tell them, against 320 bits: all three bases, twins of every
// kind, vessels included, 1e-14 to 1e-3 apart.
#include <doctest/doctest.h>

#include <cmath>
#include <optional>
#include <random>

#include "../../core/errors.hpp"
#include "../../primitives/bases/plane_base.hpp"
#include "../../primitives/bases/radial_base.hpp"
#include "../../primitives/forms/heights.hpp"
#include "../test_support.hpp"

namespace vcell::twins_test {
namespace {

class TwinScenes {
public:
    double number(double lo, double hi) { return std::uniform_real_distribution(lo, hi)(rng_); }
    Vec3 vector() { return {number(-1, 1), number(-1, 1), number(-1, 1)}; }
    Vec3 direction() { return vector().normalized(); }

    // An object outside the base and the same a little moved; tubes turned, too, and their axes of another
    // length.
    std::array<Object, 2> twins(int kind, double apart) {
        const Vec3 out = direction(), p = number(1.5, 3) * out + Vec3(0, 0, 3);
        const double r = number(0, 1) < 0.3 ? 0 : number(0.05, 0.4);
        const Vec3 moved = p + apart * direction();
        if (kind == 0) return {Sphere{p, r}, Sphere{moved, r + apart * number(0, 1)}};
        if (kind == 1) {
            const Vec3 n = (p + vector()).normalized();
            return {Plane{p, n}, Plane{moved, n + apart * direction()}};
        }
        const Vec3 axis = axis_or(p.cross(vector()).normalized() + 0.2 * vector());
        return {Cylinder{p, axis, r}, Cylinder{moved, number(-2, 2) * (axis + apart * direction()), r}};
    }
    // A vessel about the base and the same a little moved, tubes and cones turned, too.
    std::array<Object, 2> vessels(int kind, double apart) {
        const Vec3 p = number(0, 1) * direction(), moved = p + apart * direction(),
                   axis = axis_or(direction()), turned = number(0.5, 2) * (axis + apart * direction());
        const double r = number(3, 5), other = r + apart * number(-1, 1);
        if (kind == 0) return {HollowSphere{p, r}, HollowSphere{moved, other}};
        if (kind == 1) return {HollowCylinder{p, axis, r}, HollowCylinder{moved, turned, other}};
        const Vec3 down = number(4, 6) * axis;
        return {HollowCone{p - down, axis, r, 5.5}, HollowCone{moved - down, turned, other, 5.5}};
    }
    Object base(int kind) {
        along_ = kind == 0 ? Vec3(1, 0, 0) : Vec3(0, 0, 0);
        if (kind == 0) return Plane{Vec3::Zero(), Vec3(0, 0, 1)};
        if (kind == 1) return Sphere{Vec3::Zero(), 0.3};
        along_ = number(0, 1) < 0.5 ? Vec3(0, 1, 0) : direction();
        return Cylinder{Vec3::Zero(), along_, 0.3};
    }
    Interval about(double x, double width) { return number(0, 3) < 1 ? Interval(x) : Interval(x, x + width); }
    double member(const Interval& x) {
        return std::clamp(x.lower() + number(-0.2, 1.2) * (x.upper() - x.lower()), x.lower(), x.upper());
    }

private:
    // Now and then along the base.
    Vec3 axis_or(const Vec3& other) { return number(0, 1) < 0.3 && !along_.isZero() ? along_ : other; }

    std::mt19937_64 rng_{test_seed()};
    Vec3 along_ = Vec3::Zero();
};

bool holds(const Interval& range, const Interval& value) {
    return range.lower() <= value.upper() && value.lower() <= range.upper();
}

TEST_CASE("twins: differences hold those in 320 bits, and are known to a part of themselves") {
    TwinScenes scenes;
    int sharp = 0, asked = 0;
    std::array<int, 6> told{};
    for (int round = 0; round < 800 * rounds(); ++round) {
        const int base = round % 3, kind = round / 3 % 6;
        // Coefficients of these scenes differ by less than ten times that: all are twins.
        const double apart = std::pow(10, scenes.number(-14, -4)),
                     width = std::pow(10, scenes.number(-6, -1));
        Scene scene;
        scene.base = scenes.base(base);
        const auto [f, g] = kind < 3 ? scenes.twins(kind, apart) : scenes.vessels(kind - 3, apart);
        // A tube makes the plane's family a mixed one.
        scene.objects = {f, g, Cylinder{Vec3(1, 5, 4), Vec3(0.3, 0.1, 1), 0.2}};
        scene.box = {Vec3::Constant(-8), Vec3::Constant(8)};
        // What lies in each other or in the base is refused.
        std::optional<BaseProblem> made;
        try {
            made =
                base == 0 ? BaseProblem(plane_base_problem(scene)) : BaseProblem(radial_base_problem(scene));
        } catch (const InputError&) {
            continue;
        }
        const BaseProblem& problem = *made;
        std::vector<FormId> forms;
        for (const FormId id : problem.sites.ids())
            if (problem.sites[id].front() == Site::object(0) || problem.sites[id].front() == Site::object(1))
                forms.push_back(id);
        if (forms.size() != 2) continue;
        const Heights heights(problem.family);
        CAPTURE(base);
        CAPTURE(kind);
        CAPTURE(apart);
        CHECK(heights.are_twins(forms[0], forms[1]));
        const Interval x = scenes.about(scenes.number(-1, base == 2 ? 3 : 1), width),
                       y = scenes.about(scenes.number(-1, 1), width);
        const auto d = heights.twin_difference(forms[0], forms[1], x, y),
                   back = heights.twin_difference(forms[1], forms[0], x, y);
        REQUIRE(d);
        if (!std::isfinite(d->v.magnitude())) continue;
        ++told[static_cast<std::size_t>(kind)];
        CHECK(back->v.lower() == -d->v.upper());
        const double h = std::ldexp(1.0, -60);
        for (int k = 0; k < 3; ++k) {
            const double px = scenes.member(x), py = scenes.member(y);
            const HeightJet<Wide> at = heights.difference(forms[0], forms[1], Wide(px), Wide(py));
            CHECK(holds(d->v, at.v.enclosure()));
            CHECK(holds(d->x, at.gx.enclosure()));
            CHECK(holds(d->y, at.gy.enclosure()));
            // Second derivatives against quotients of first ones, within the box but for h.
            const HeightJet<Wide> right =
                                      heights.difference(forms[0], forms[1], Wide(px) + Wide(h), Wide(py)),
                                  above =
                                      heights.difference(forms[0], forms[1], Wide(px), Wide(py) + Wide(h));
            const auto quotient = [&](const Wide& p, const Wide& q) {
                const double v = ((p - q) / Wide(h)).approximation();
                return Interval::ball(v, 1e-9 * std::abs(v) + 1e-12 * apart);
            };
            CHECK(holds(d->xx, quotient(right.gx, at.gx)));
            CHECK(holds(d->xy, quotient(right.gy, at.gy)));
            CHECK(holds(d->yy, quotient(above.gy, at.gy)));
        }
        const auto middle =
            *heights.twin_difference(forms[0], forms[1], Interval(x.mid()), Interval(y.mid()));
        const double size = middle.v.magnitude() + middle.x.magnitude() + middle.y.magnitude();
        ++asked;
        if (middle.v.radius() + middle.x.radius() + middle.y.radius() <= 0x1p-36 * size) ++sharp;
    }
    CHECK(std::ranges::min(told) > 15);
    CHECK(10 * sharp > 9 * asked);
}

}  // namespace
}  // namespace vcell::twins_test
