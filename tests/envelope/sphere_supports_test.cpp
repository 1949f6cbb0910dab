// Supporting planes over boxes of a sphere's chart against the heights at points of the boxes.
#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "../../envelope/sphere/sphere_supports.hpp"
#include "../../primitives/forms/heights.hpp"
#include "../test_support.hpp"

namespace vcell::sphere_supports_test {
namespace {

constexpr double slop = 1e-12;  // of heights in [-10, 10]: what rounding may do to a sample

struct Samples {
    std::mt19937_64 rng{test_seed()};

    double number(double lo, double hi) { return std::uniform_real_distribution(lo, hi)(rng); }

    // Two circular forms, then two cylinders' with C > 0.
    FormFamily family() {
        FormFamily out;
        out.chart = BaseShape::Sphere;
        for (const double k : {-1.0, 1.0})
            out.forms.push_back({k, 0, 0, number(-2, 2), number(-2, 2), number(-2, 2), number(0.5, 2)});
        for (int i = 0; i < 2; ++i) {
            RadialForm f;
            f.c[0] = Exact(number(0.5, 2));
            f.b0 = Exact(number(-0.5, 0.5));
            for (int k = 0; k < 3; ++k) {
                f.b[k] = Exact(number(-1, 1));
                f.a[k] = Exact(number(-1, 1));
            }
            out.radial.push_back(f);
        }
        return out;
    }
    // Of any size, and anywhere in the chart.
    std::array<double, 4> box() {
        const double width = std::exp2(number(-12, 2)), x = number(-3, 3), y = number(-3, 3);
        return {x, x + number(0.1, 1) * width, y, y + number(0.1, 1) * width};
    }
    std::array<double, 2> point(const std::array<double, 4>& box) {
        return {number(box[0], box[1]), number(box[2], box[3])};
    }
};

TEST_CASE("sphere supports: heights and gradients lie where they say") {
    Samples samples;
    int above = 0;
    for (int round = 0; round < 300; ++round) {
        const FormFamily family = samples.family();
        const Heights heights(family);
        const SphereSupports supports(family);
        const auto box = samples.box();
        const NormalBox normals(box[0], box[1], box[2], box[3]);
        for (std::uint32_t i = 0; i < family.size(); ++i)
            for (std::uint32_t j = 0; j < family.size(); ++j) {
                const FormId f{i}, g{j};
                const Support a = supports.over(f, normals), b = supports.over(g, normals);
                const bool is_above = normals.is_above(a, b);
                above += is_above;
                const auto gradient = normals.gradient(a, b);
                for (int k = 0; k < 20; ++k) {
                    const auto [x, y] = samples.point(box);
                    const auto p = heights.jet(f, Interval(x), Interval(y)),
                               q = heights.jet(g, Interval(x), Interval(y));
                    CAPTURE(round);
                    CAPTURE(i);
                    CAPTURE(j);
                    const double W = 1 + x * x + y * y, n[] = {2 * x / W, 2 * y / W, 2 / W - 1};
                    double plane = a.plane.s;
                    for (int c = 0; c < 3; ++c) plane += a.plane.p[c] * n[c];
                    CHECK(plane <= -p.v.lower() + slop);
                    CHECK(plane + a.excess >= -p.v.upper() - slop);
                    if (is_above) CHECK(p.v.upper() > q.v.lower());
                    CHECK(gradient[0].lower() <= (p.gx - q.gx).upper());
                    CHECK(gradient[0].upper() >= (p.gx - q.gx).lower());
                    CHECK(gradient[1].lower() <= (p.gy - q.gy).upper());
                    CHECK(gradient[1].upper() >= (p.gy - q.gy).lower());
                    const PointNormal at(x, y);
                    const auto jet = supports.jet(f, at);
                    const Interval value = Interval::ball(supports.value(f, at), supports.value_error(f, at));
                    CHECK(value.lower() <= p.v.upper());
                    CHECK(value.upper() >= p.v.lower());
                    CHECK(value.radius() < slop);
                    CHECK(jet[0] == doctest::Approx(p.v.mid()).epsilon(slop));
                    CHECK(jet[1] == doctest::Approx(p.gx.mid()).epsilon(1e3 * slop));
                    CHECK(jet[2] == doctest::Approx(p.gy.mid()).epsilon(1e3 * slop));
                }
            }
    }
    CHECK(above > 300);
}

TEST_CASE("sphere supports: small boxes tell forms apart") {
    Samples samples;
    const FormFamily family = samples.family();
    const Heights heights(family);
    const SphereSupports supports(family);
    int apart = 0;
    for (int round = 0; round < 300; ++round) {
        const auto [x, y] = samples.point({-2, 2, -2, 2});
        const FormId f{round % 2u}, g{2 + round % 2u};
        const Interval difference =
            heights.value(f, Interval(x), Interval(y)) - heights.value(g, Interval(x), Interval(y));
        if (!(difference.magnitude() > 1e-4)) continue;
        ++apart;
        constexpr double width = 1e-6;
        const NormalBox box(x, x + width, y, y + width);
        const Support a = supports.over(f, box), b = supports.over(g, box);
        CHECK(box.is_above(a, b) == (difference.lower() > 0));
        CHECK(box.is_above(b, a) == (difference.upper() < 0));
    }
    CHECK(apart > 250);
}

// Along a line in a direction in which the difference grows wherever it is zero its sign changes once at
// most.
TEST_CASE("divided box: lines in a direction of growth meet a trisector once") {
    Samples samples;
    int grows = 0, crossings = 0;
    for (int round = 0; round < 1000; ++round) {
        FormFamily family = samples.family();
        const auto box = samples.box();
        const std::array forms{FormId{0}, FormId{2}};
        const auto [mx, my] = samples.point(box);
        // They tie somewhere in the box.
        const auto difference = [&, x = mx, y = my] {
            const SphereSupports supports(family);
            const PointNormal n(x, y);
            const auto f = supports.jet(forms[0], n), g = supports.jet(forms[1], n);
            return std::array{f[0] - g[0], f[1] - g[1], f[2] - g[2]};
        };
        CircularForm& form = family.forms[forms[0]];
        form.e -= form.w * (1 + mx * mx + my * my) * difference()[0];
        const Heights heights(family);
        const SphereSupports supports(family);
        const DividedBox parts(supports, box, forms);
        const auto gradient = difference();
        const Eigen::Vector2d d = Eigen::Vector2d(gradient[1], gradient[2]).normalized();
        if (!parts.grows_along(0, 1, d)) continue;
        ++grows;
        for (int line = 0; line < 10; ++line) {
            const auto [px, py] = samples.point(box);
            bool was_below = false, was_above = false;
            constexpr int steps = 200;
            const double reach = box[1] - box[0] + box[3] - box[2];
            for (int k = -steps; k <= steps; ++k) {
                const double x = px + k * reach / steps * d.x(), y = py + k * reach / steps * d.y();
                if (x < box[0] || x > box[1] || y < box[2] || y > box[3]) continue;
                const auto sign = (heights.value(forms[0], Interval(x), Interval(y)) -
                                   heights.value(forms[1], Interval(x), Interval(y)))
                                      .sign();
                CAPTURE(round);
                if (sign == Sign::Positive) was_above = true;
                if (sign == Sign::Negative) {
                    was_below = true;
                    CHECK_FALSE(was_above);
                }
            }
            crossings += was_below && was_above;
        }
    }
    CHECK(grows > 200);
    CHECK(crossings > 200);
}

// Points of the trisector on chords of the box; a third form hides some of them.
TEST_CASE("divided box: a difference grows as said where two forms are equal and lowest") {
    Samples samples;
    int visible = 0, hidden = 0;
    for (int round = 0; round < 4000; ++round) {
        FormFamily family = samples.family();
        const auto box = samples.box();
        const auto [mx, my] = samples.point(box);
        const std::array forms{FormId{0}, FormId{2}, FormId{3}};
        CircularForm& form = family.forms[forms[0]];
        {
            const SphereSupports supports(family);
            const PointNormal n(mx, my);
            form.e -= form.w * (1 + mx * mx + my * my) *
                      (supports.value(forms[0], n) - supports.value(forms[1], n));
        }
        const SphereSupports supports(family);
        const auto difference = [&](const Eigen::Vector2d& p) {
            const PointNormal n(p.x(), p.y());
            const auto f = supports.jet(forms[0], n), g = supports.jet(forms[1], n);
            return std::array{f[0] - g[0], f[1] - g[1], f[2] - g[2]};
        };
        const auto gradient = difference({mx, my});
        const Eigen::Vector2d d = Eigen::Vector2d(gradient[1], gradient[2]).normalized();
        const DividedBox parts(supports, box, forms);
        if (!parts.grows_along(0, 1, d)) continue;
        const bool is_partial = !parts.grows_throughout(0, 1, d);
        for (int chord = 0; chord < 10; ++chord) {
            const auto [px, py] = samples.point(box);
            const auto [qx, qy] = samples.point(box);
            Eigen::Vector2d p(px, py), q(qx, qy);
            if ((difference(p)[0] > 0) == (difference(q)[0] > 0)) continue;
            const bool falls = difference(p)[0] > 0;
            for (int i = 0; i < 60; ++i) {
                const Eigen::Vector2d half = 0.5 * (p + q);
                ((difference(half)[0] > 0) == falls ? p : q) = half;
            }
            const PointNormal n(p.x(), p.y());
            if (supports.value(forms[2], n) < supports.value(forms[0], n)) {
                hidden += is_partial;
                continue;
            }
            ++visible;
            const auto at_zero = difference(p);
            CAPTURE(round);
            CHECK(d.x() * at_zero[1] + d.y() * at_zero[2] > -slop);
        }
    }
    CHECK(visible > 800);
    CHECK(hidden > 5);
}

// Two circular forms and a cylinder's that tie in a point of the box.
TEST_CASE("divided box: what holds all common points of three forms holds one") {
    Samples samples;
    int small = 0;
    for (int round = 0; round < 300; ++round) {
        FormFamily family = samples.family();
        const auto box = samples.box();
        const auto [x, y] = samples.point(box);
        const std::array forms{FormId{0}, FormId{1}, FormId{2}};
        const double tied = SphereSupports(family).value(forms[2], PointNormal(x, y));
        for (const FormId f : {forms[0], forms[1]}) {
            CircularForm& form = family.forms[f];
            form.e -=
                form.w * (1 + x * x + y * y) * (SphereSupports(family).value(f, PointNormal(x, y)) - tied);
        }
        const SphereSupports supports(family);
        const DividedBox parts(supports, box, forms);
        const auto part = parts.meeting(0, 1, 2);
        REQUIRE(part);
        const auto& [x0, x1, y0, y1] = *part;
        CHECK((x0 <= x && x <= x1 && y0 <= y && y <= y1));
        CHECK(parts.meeting(2, 0, 1) == part);
        small += x1 - x0 < 0.6 * (box[1] - box[0]) && y1 - y0 < 0.6 * (box[3] - box[2]);
    }
    CHECK(small > 100);
}

}  // namespace
}  // namespace vcell::sphere_supports_test
