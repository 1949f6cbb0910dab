// The ladder of circle_kernel against 200-digit arithmetic, on points and forms one unit in the last place
// from degeneracy.
#include <doctest/doctest.h>

#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>
#include <random>

#include "../../arrangement/circles/circle_kernel.hpp"
#include "../../arrangement/circles/curve_order.hpp"
#include "../../arrangement/circles/point_star.hpp"
#include "../test_support.hpp"

namespace vcell::circle_kernel_test {

namespace {

using Real =
    boost::multiprecision::number<boost::multiprecision::cpp_bin_float<200>, boost::multiprecision::et_off>;

struct Ball {
    double x, y, z, r;
};

struct Forms {
    std::vector<Ball> balls;
    CircularFamily family;

    explicit Forms(std::vector<Ball> list) : balls(std::move(list)) {
        for (const Ball& b : balls)
            family.forms.push_back({1, b.x, b.y, 0, 0, (b.z - b.r) * (b.z + b.r), 2 * (b.z + b.r)});
        family.exact = [this](FormId f) {
            const Ball& b = balls[f.value];
            const Exact x(b.x), y(b.y), z(b.z), r(b.r), two(2.0);
            return ExactForm{Exact(1.0), -(two * x), -(two * y), x * x + y * y + z * z - r * r,
                             two * (z + r)};
        };
    }
    Forms(const Forms&) = delete;

    Real value(std::uint32_t i, const Real& x, const Real& y) const {
        const Ball& b = balls[i];
        const Real dx = x - b.x, dy = y - b.y, z = b.z, r = b.r;
        return (dx * dx + dy * dy + z * z - r * r) / (2 * (z + r));
    }
    // Gradient and quadratic coefficient of i - j at a point.
    std::array<Real, 3> slope(std::uint32_t i, std::uint32_t j, const Real& x, const Real& y) const {
        const Real wi = Real(balls[i].z) + balls[i].r, wj = Real(balls[j].z) + balls[j].r;
        return {(x - balls[i].x) / wi - (x - balls[j].x) / wj, (y - balls[i].y) / wi - (y - balls[j].y) / wj,
                1 / (2 * wi) - 1 / (2 * wj)};
    }
    // The point from its double place by Newton's method; the crossings asked for here are transversal.
    std::array<Real, 2> refine(const KernelPoint& p) const {
        Real x = p.x, y = p.y;
        const auto id = [&](FormId f) { return f.value - 1; };  // the kernel numbers forms after zero
        for (int i = 0; i < 9; ++i) {
            const Real f = value(id(p.first.f), x, y) - value(id(p.first.g), x, y);
            const Real g = value(id(p.second.f), x, y) - value(id(p.second.g), x, y);
            const auto a = slope(id(p.first.f), id(p.first.g), x, y),
                       b = slope(id(p.second.f), id(p.second.g), x, y);
            const Real det = a[0] * b[1] - a[1] * b[0];
            x -= (b[1] * f - a[1] * g) / det;
            y -= (a[0] * g - b[0] * f) / det;
        }
        return {x, y};
    }
};

Sign sign_of_real(const Real& v) {
    if (abs(v) < Real("1e-150")) return Sign::Zero;
    return v > 0 ? Sign::Positive : Sign::Negative;
}

double nudge(std::mt19937_64& rng, double v) {
    switch (std::uniform_int_distribution(0, 4)(rng)) {
        case 0: return std::nextafter(v, 1e9);
        case 1: return std::nextafter(v, -1e9);
        default: return v;
    }
}

// Balls on a small lattice, most of equal size, moved by at most one unit in the last place: four of them
// often meet in one point, or miss it by a hair.
std::vector<Ball> lattice(std::mt19937_64& rng) {
    std::vector<Ball> balls;
    for (int i = 1; i <= 3; ++i)
        for (int j = 1; j <= 3; ++j)
            balls.push_back({nudge(rng, i), nudge(rng, j), nudge(rng, 1.0), rng() % 3 ? 0.25 : 0.5});
    return balls;
}

struct Case {
    Forms forms;
    CircleKernel kernel;
    std::vector<FormId> ids;

    explicit Case(std::vector<Ball> balls) : forms(std::move(balls)) {
        kernel.reset(&forms.family);
        for (const FormId f : forms.family.forms.ids()) ids.push_back(kernel.add_form(f));
    }
};

}  // namespace

TEST_CASE("circle_kernel: points lie where 200 digits put them, within their error") {
    std::mt19937_64 rng(test_seed());
    int found = 0;
    for (int round = 0; round < 300; ++round) {
        Case c(lattice(rng));
        const std::size_t a = rng() % 9, b = rng() % 9, d = rng() % 9;
        if (a == b || a == d || b == d) continue;
        const FormPair first{c.ids[a], c.ids[b]}, second{c.ids[a], c.ids[d]};
        if (c.kernel.same_curve(first, second)) continue;
        for (const Sign s : {Sign::Positive, Sign::Negative}) {
            const auto p = c.kernel.intersection(first, second, s, {2, 2});
            if (!p) continue;
            const KernelPoint& q = c.kernel.point(*p);
            const auto [x, y] = c.forms.refine(q);
            CHECK(hypot(x - q.x, y - q.y) <= q.error);
            const auto g = c.forms.slope(a, b, x, y), h = c.forms.slope(a, d, x, y);
            CHECK(sign_of_real(g[0] * h[1] - g[1] * h[0]) == s);
            ++found;
        }
    }
    CHECK(found > 100);
}

TEST_CASE("circle_kernel: signs, turns and orders agree with 200 digits one ulp from degeneracy") {
    std::mt19937_64 rng(test_seed());
    Decisions total;
    int zeros = 0;
    for (int round = 0; round < long_rounds(400); ++round) {
        Case c(lattice(rng));
        std::vector<std::pair<PointId, std::array<Real, 2>>> points;
        std::vector<std::array<std::size_t, 3>> triples;
        for (int k = 0; k < 4; ++k) {
            const std::size_t a = rng() % 9, b = rng() % 9, d = rng() % 9;
            if (a == b || a == d || b == d) continue;
            const FormPair first{c.ids[a], c.ids[b]}, second{c.ids[a], c.ids[d]};
            if (c.kernel.same_curve(first, second)) continue;
            for (const Sign s : {Sign::Positive, Sign::Negative})
                if (const auto p = c.kernel.intersection(first, second, s, {2, 2})) {
                    points.emplace_back(*p, c.forms.refine(c.kernel.point(*p)));
                    triples.push_back({a, b, d});
                }
        }
        for (std::size_t i = 0; i < points.size(); ++i) {
            const auto& [p, at] = points[i];
            const auto& [x, y] = at;
            const std::size_t a = triples[i][0], b = triples[i][1];
            for (std::size_t k = 0; k < 9; ++k) {
                if (k == a) continue;
                const Real size =
                    1 + x * x + y * y;  // of the terms: nearly straight curves may meet far away
                const Sign want = sign_of_real((c.forms.value(k, x, y) - c.forms.value(a, x, y)) / size);
                CHECK(c.kernel.sign_at(p, c.ids[k], c.ids[a]) == want);
                zeros += want == Sign::Zero;
                if (want != Sign::Zero || k == b) continue;
                const auto g = c.forms.slope(a, b, x, y), h = c.forms.slope(a, k, x, y);
                CHECK(c.kernel.turn_at(p, {c.ids[a], c.ids[b]}, {c.ids[a], c.ids[k]}) ==
                      sign_of_real(g[0] * h[1] - g[1] * h[0]));
            }
            for (const auto& [q, place] : points) {
                CHECK(c.kernel.compare_x(p, q) == sign_of_real(x - place[0]));
                CHECK(c.kernel.compare_y(p, q) == sign_of_real(y - place[1]));
            }
        }
        total += c.kernel.decisions();
    }
    // Each rung has had its say.
    CHECK(total.by_double > 0);
    CHECK(total.by_exact > 0);
    CHECK(zeros > 1000);
}

TEST_CASE("circle_kernel: order along a curve is that of the angles around its centre") {
    std::mt19937_64 rng(test_seed());
    int circles = 0;
    for (int round = 0; round < 100 * rounds(); ++round) {
        Case c(lattice(rng));
        const std::size_t a = rng() % 9, b = rng() % 9;
        if (a == b) continue;
        const FormPair curve{c.ids[a], c.ids[b]};
        const auto K = c.forms.slope(a, b, 0, 0);
        if (abs(K[2]) < Real("1e-3")) continue;
        ++circles;
        const Real cx = -K[0] / (2 * K[2]), cy = -K[1] / (2 * K[2]);
        std::vector<std::pair<PointId, Real>> on;  // with the angle in the curve's direction
        for (std::size_t k = 0; k < 9; ++k) {
            if (k == a || k == b || c.kernel.same_curve(curve, {c.ids[a], c.ids[k]})) continue;
            for (const Sign s : {Sign::Positive, Sign::Negative})
                if (const auto p = c.kernel.intersection(curve, {c.ids[a], c.ids[k]}, s, {2, 2})) {
                    const auto [x, y] = c.forms.refine(c.kernel.point(*p));
                    const Real angle = atan2(y - cy, x - cx);
                    on.emplace_back(*p, K[2] > 0 ? angle : Real(-angle));
                }
        }
        const Real turn = 2 * boost::math::constants::pi<Real>();
        const auto from = [&](const Real& start, const Real& t) {
            Real d = t - start;
            while (d < 0) d += turn;
            return Real(turn - d) < Real("1e-150") ? Real(0) : d;
        };
        for (const auto& [p, tp] : on)
            for (const auto& [q, tq] : on)
                for (const auto& [r, tr] : on) {
                    const Real to_q = from(tp, tq), to_r = from(tp, tr);
                    if (p != q && to_q < Real("1e-150")) continue;  // one place under two names
                    const Real end = p == q ? turn : to_q;
                    const bool want = to_r > Real("1e-150") && to_r < end - Real("1e-150");
                    CHECK(CurveOrder(c.kernel, curve).strictly_between(p, q, r) == want);
                }
    }
    CHECK(circles > 16 * rounds());
}

TEST_CASE("circle_kernel: bounds over rectangles and arcs hold at sampled points") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(0, 1);
    for (int round = 0; round < 500; ++round) {
        Case c(lattice(rng));
        const FormId f = c.ids[rng() % 9], g = c.ids[rng() % 9];
        const double x0 = 4 * unit(rng), y0 = 4 * unit(rng), x1 = x0 + unit(rng), y1 = y0 + unit(rng);
        const double low = c.kernel.lower_bound(f, g, x0, x1, y0, y1);
        const double x = 0.5 * (x0 + x1), y = 0.5 * (y0 + y1), rx = 0.5 * (x1 - x0) * (1 + 1e-15),
                     ry = 0.5 * (y1 - y0) * (1 + 1e-15);
        const bool above = BoxForm::certainly_above(c.kernel.form(f).over_box(x, y, rx, ry),
                                                    c.kernel.form(g).over_box(x, y, rx, ry), rx, ry);
        for (int k = 0; k < 20; ++k) {
            const Real px = x0 + unit(rng) * (x1 - x0), py = y0 + unit(rng) * (y1 - y0);
            const Real d = c.forms.value(f.value - 1, px, py) - c.forms.value(g.value - 1, px, py);
            CHECK(d >= low);
            if (above) CHECK(d > 0);
        }
    }
}

TEST_CASE("circle_kernel: points of one upright or level line share a coordinate, without exact numbers") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> unit(0, 1);
    int shared = 0, apart = 0;
    for (int round = 0; round < 300; ++round) {
        Case c(lattice(rng));
        const bool upright = rng() % 2;
        const double at = 0.5 + 3 * unit(rng);
        const auto line = [&](double place) {
            const FormId f = upright ? c.kernel.add_line(1, 0, -place) : c.kernel.add_line(0, 1, -place);
            return FormPair{CircleKernel::zero_form(), f};
        };
        const FormPair one = line(at), other = line(std::nextafter(at, 9));
        std::vector<PointId> on_one, on_other;
        for (int k = 0; k < 6; ++k) {
            const std::size_t a = rng() % 9, b = rng() % 9;
            if (a == b) continue;
            const FormPair curve{c.ids[a], c.ids[b]};
            for (const Sign s : {Sign::Positive, Sign::Negative}) {
                if (const auto p = c.kernel.intersection(one, curve, s, {2, 2})) on_one.push_back(*p);
                if (const auto p = c.kernel.intersection(curve, one.reversed(), s, {2, 2}))
                    on_one.push_back(*p);
                if (const auto p = c.kernel.intersection(other, curve, s, {2, 2})) on_other.push_back(*p);
            }
        }
        const auto compare = [&](PointId p, PointId q) {
            return upright ? c.kernel.compare_x(p, q) : c.kernel.compare_y(p, q);
        };
        const auto exact_before = c.kernel.decisions().by_exact;
        for (const PointId p : on_one)
            for (const PointId q : on_one) {
                CHECK(compare(p, q) == Sign::Zero);
                shared += p != q;
            }
        CHECK(c.kernel.decisions().by_exact == exact_before);
        for (const PointId p : on_one)
            for (const PointId q : on_other) {
                CHECK(compare(p, q) == Sign::Negative);
                ++apart;
            }
    }
    CHECK(shared > 1000);
    CHECK(apart > 1000);
}

// Forms |p|^2 / w + 2 m t.p: all vanish at the origin, where the curves of any two have gradients along t.
// The curves {0 = 1} and {0 = 2} are one where (1 / w - 1 / w_0) / (m - m_0) is the same for both.
TEST_CASE("circle_kernel: curves with one tangent agree with 200 digits one ulp from being the same") {
    std::mt19937_64 rng(test_seed());
    Decisions total;
    int same = 0, nearly = 0;
    for (int round = 0; round < 2000; ++round) {
        const double directions[][2] = {{1, 0}, {-1, 0}, {0, 1}, {1, 1}, {1, -2}};
        const double multiples[] = {-4, -2, -1, 0, 1, 2, 4};
        const auto& t = directions[rng() % 5];
        std::array<double, 4> m{}, w{};
        for (double& v : m) v = multiples[rng() % 7];
        for (double& v : w) v = static_cast<double>(1 + rng() % 8);
        if (m[0] == m[1] || m[0] == m[2] || m[3] == 0) continue;
        const double degenerate = 1 / w[0] + (m[2] - m[0]) / (m[1] - m[0]) * (1 / w[1] - 1 / w[0]);
        if (degenerate > 0.01) w[2] = nudge(rng, 1 / degenerate);
        // The last form's gradient is across t, so that its curve names the origin.
        std::array<Eigen::Vector2d, 4> slope;
        for (int i = 0; i < 3; ++i) slope[i] = m[i] * Eigen::Vector2d(t[0], t[1]);
        slope[3] = slope[0] + m[3] * Eigen::Vector2d(-t[1], t[0]);

        CircularFamily family;
        for (int i = 0; i < 4; ++i) {
            const Eigen::Vector2d center = -w[i] * slope[i];
            family.forms.push_back({1, center.x(), center.y(), 0, 0, -center.squaredNorm(), w[i]});
        }
        family.exact = [&](FormId f) {
            const Eigen::Vector2d s = slope[f.value];
            const Exact two_w = Exact(2.0) * Exact(w[f.value]);
            return ExactForm{Exact(1.0), two_w * Exact(s.x()), two_w * Exact(s.y()), Exact(),
                             Exact(w[f.value])};
        };
        CircleKernel kernel;
        kernel.reset(&family);
        std::array<FormId, 4> id;
        for (std::uint32_t i = 0; i < 4; ++i) id[i] = kernel.add_form({i});

        const FormPair c{id[0], id[1]}, d{id[0], id[2]}, across{id[0], id[3]};
        const Eigen::Vector2d g = slope[0] - slope[1], h = slope[0] - slope[2], n = slope[0] - slope[3];
        const Sign turn = sign_of(g.x() * n.y() - g.y() * n.x());
        const PointId origin = *kernel.intersection(c, across, turn, {0.37, -0.21});
        const auto curvature = [&](int i) { return 1 / Real(w[0]) - 1 / Real(w[i]); };
        const Real bend = curvature(2) * g.squaredNorm() - curvature(1) * g.dot(h);  // of d more than of c

        kernel.decisions() = {};
        CHECK(kernel.turn_at(origin, c, d) == Sign::Zero);
        CHECK(PointStar(kernel, origin).same_direction(c, d) == (g.dot(h) > 0));
        CHECK(PointStar(kernel, origin).sign_beside_touching(c, d) == sign_of_real(bend));
        CHECK(kernel.same_curve(c, d) == (sign_of_real(bend) == Sign::Zero));
        same += sign_of_real(bend) == Sign::Zero;
        nearly += sign_of_real(bend) != Sign::Zero && abs(bend) < Real("1e-14");
        if (t[1] == 0) {
            // Both run straight up or down. The same way, the sector is nearly a whole turn unless d bends
            // left of c; opposite ways, it turns left from a curve that runs up, where its gradient points
            // right.
            const bool left = g.dot(h) > 0 ? sign_of_real(bend) != Sign::Positive : g.x() > 0;
            CHECK(PointStar(kernel, origin).sector_contains_left(c, d) == left);
        }
        total += kernel.decisions();
    }
    CHECK(same > 100);
    CHECK(nearly > 100);
    // Each rung has had its say.
    CHECK(total.by_double > 0);
    CHECK(total.by_interval > 0);
    CHECK(total.by_exact > 0);
}

}  // namespace vcell::circle_kernel_test
