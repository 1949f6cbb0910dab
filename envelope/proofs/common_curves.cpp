#include "common_curves.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <optional>

#include "../../core/small_vector.hpp"
#include "mixed_terms.hpp"

namespace vcell {

namespace {

using Eigen::Vector2d;

// Differences that grow by less than this part of the heights within the surroundings of a box are left to
// others: what a turn of the base leaves of a tie would move their zeros by some of the box.
constexpr double least_growth = 0x1p-40;

// More forms have too many triples; fewer are left in smaller boxes.
constexpr std::size_t most_compared = 8;

// Are linear functions next to being equal along one line? Most are not, and that takes least to see.
bool share_line(const PlaneJet& f, const PlaneJet& g, const PlaneJet& h, double width) {
    constexpr double parallel = 0.25;
    const Vector2d a = f.g - g.g, b = h.g - g.g;
    const double size = a.norm() * b.norm(), turn = a.x() * b.y() - a.y() * b.x();
    if (!(std::abs(turn) <= parallel * size)) return false;
    const double side = std::copysign(1, a.dot(b));
    return std::abs((f.v - g.v) / a.norm() - side * (h.v - g.v) / b.norm()) <= width;
}

bool is_any(const std::array<std::optional<SpaceTie::Implied>, 3>& implied) {
    return std::ranges::any_of(implied, [](const auto& i) { return i.has_value(); });
}

}  // namespace

std::vector<FormId> CommonCurves::hidden(std::span<const FormId> forms, const Interval& x,
                                         const Interval& y) {
    std::vector<FormId> out;
    if (forms.size() > most_compared) return out;
    SmallVector<PlaneJet, most_compared> middle;
    for (const FormId f : forms) middle.push_back(near(f, {x.mid(), y.mid()}));
    const double width = std::max(x.width(), y.width());
    const auto is_out = [&](FormId f) { return std::ranges::find(out, f) != out.end(); };
    for (std::size_t i = 0; i < forms.size(); ++i)
        for (std::size_t j = i + 1; j < forms.size(); ++j)
            for (std::size_t k = j + 1; k < forms.size(); ++k) {
                Triple three{forms[i], forms[j], forms[k]};
                if (!share_line(middle[i], middle[j], middle[k], width)) continue;
                if (std::ranges::any_of(three, is_out)) continue;
                std::ranges::sort(three);
                if (!rule_.spares(three) && forms.size() > three.size()) continue;
                if (const auto found = order(three, x, y))
                    for (const FormId f : shown_nowhere(*found)) out.push_back(f);
            }
    return out;
}

std::vector<FormId> CommonCurves::shown_nowhere(const Order& three) const {
    if (rule_.spares(three)) return {three[1]};
    const auto place = [&](FormId f) { return std::ranges::find(three, f) - three.begin(); };
    const auto shows = [&](std::span<const FormId> of, bool is_after) {
        const auto compare = [&](FormId f, FormId g) {
            return (place(f) < place(g)) == is_after ? Sign::Positive : Sign::Negative;
        };
        return rule_.exactly_showing(of, compare).front();
    };
    const std::array both{shows(three, false), shows(three, true)};
    // Without the third one of the two might show where it would not have.
    if (both[0] != both[1] && (shows(both, false) != both[0] || shows(both, true) != both[1])) return {};
    std::vector<FormId> others;
    for (const FormId f : three)
        if (std::ranges::find(both, f) == both.end()) others.push_back(f);
    return others;
}

bool CommonCurves::may_tie(Triple forms, const Interval& x, const Interval& y) {
    std::ranges::sort(forms);
    return is_near(forms, x, y) && is_any(implied(forms));
}

std::vector<CommonCurves::Triple> CommonCurves::found() const {
    std::vector<Triple> all;
    for (const auto& [forms, implied] : implied_)
        if (is_any(implied)) all.push_back(forms);
    return all;
}

// Distances from tips are out of place here: their product all but vanishes next to one, and turns its sign
// beyond.
HeightJet<Interval> CommonCurves::jet(FormId f, const Interval& x, const Interval& y) const {
    return heights_.family().tips.any() ? heights_.plain_jet(f, x, y) : heights_.jet(f, x, y);
}

PlaneJet CommonCurves::near(FormId f, const Vector2d& p) const {
    const auto [v, gx, gy] = heights_.near(f, p.x(), p.y());
    return {v, {gx, gy}};
}

// In doubles: does the third tie where the first two do next to the box, but for what rounding and the last
// of Newton's steps leave?
bool CommonCurves::is_near(const Triple& forms, const Interval& x, const Interval& y) const {
    constexpr double small = 0x1p-30;
    constexpr int most_steps = 4;
    const double reach = 2 * std::max(x.width(), y.width());
    const Vector2d middle(x.mid(), y.mid());
    Vector2d p = middle;
    for (int i = 0;; ++i) {
        const PlaneJet f = near(forms[0], p), g = near(forms[1], p);
        if (i == most_steps) {
            const double h = near(forms[2], p).v;
            return std::abs(h - g.v) <= small * std::abs(h);
        }
        const Vector2d slope = f.g - g.g;
        p -= (f.v - g.v) / slope.squaredNorm() * slope;
        if (!p.allFinite() || (p - middle).norm() > reach) return false;
    }
}

const CommonCurves::Implied& CommonCurves::implied(const Triple& forms) {
    const auto [known, is_new] = implied_.try_emplace(forms);
    Implied& result = known->second;
    if (!is_new) return result;
    const FormFamily& family = heights_.family();
    std::array<space_quadrics::Quadric, 3> equations;
    for (std::size_t i = 0; i < forms.size(); ++i) {
        if (!family.given) {
            equations[i] = space_quadrics::equation(family, forms[i]);
        } else if (auto given = family.given->of(forms[i])) {
            equations[i] = *std::move(given);
        } else {
            return result;
        }
    }
    const space_quadrics::Quadric base =
        family.given ? family.given->base : space_quadrics::base_equation(family);
    for (std::size_t i = 0; i < forms.size(); ++i)
        result[i] =
            SpaceTie(family, {base, equations[(i + 1) % 3], equations[(i + 2) % 3]}).implied(equations[i]);
    return result;
}

// Is a linear form of X zero nowhere over the box, where heights are in this range?
bool CommonCurves::is_off(const space_quadrics::Linear& linear, const Interval& x, const Interval& y,
                          const Interval& height) const {
    const auto X = space_quadrics::places(heights_.family(), x, y, height);
    Interval sum;
    for (std::size_t k = 0; k < X.size(); ++k) sum = sum + linear[k].enclosure() * X[k];
    const auto sign = sum.sign();
    return sign && *sign != Sign::Zero;
}

// A box in the first half of a chart that goes around, whose surroundings reach into the second one, in the
// coordinates that this goes on in. The tangents of half the angle from the middles of both are -1 to each
// other.
std::optional<Interval> CommonCurves::in_one_half(const Interval& x, double margin) const {
    const Chart& chart = heights_.family().chart;
    if (chart.is_back(x.upper()) || !chart.is_back(x.upper() + margin)) return x;
    if (!(x.lower() > 0)) return std::nullopt;
    const Interval from = Interval(2.0) - Interval(1.0) / Interval(x.lower());
    return Interval(from.lower(), std::nextafter(*chart.smooth_seam(), infinity));
}

std::optional<CommonCurves::Order> CommonCurves::order(const Triple& forms, const Interval& x,
                                                       const Interval& y) {
    if (const auto known = implied_.find(forms); known != implied_.end() && !is_any(known->second))
        return std::nullopt;
    if (!is_near(forms, x, y)) return std::nullopt;
    // Wide enough for lines along any d through the box to the curve, if that crosses the box.
    const double margin = 2 * std::max(x.width(), y.width());
    const auto half = in_one_half(x, margin);
    if (!half) return std::nullopt;
    const Interval X(half->lower() - margin, half->upper() + margin),
        Y(y.lower() - margin, y.upper() + margin);
    const Sign met = heights_.family().compared_over().sign_of_met();
    double size = 0;
    for (const FormId f : forms) {
        const Interval height = jet(f, X, Y).v;
        if (height.sign() != met || !heights_.family().has_one_root(f, Y)) return std::nullopt;
        size = std::max(size, height.magnitude());
    }

    const auto pair = [](std::size_t i) { return std::array{(i + 1) % 3, (i + 2) % 3}; };
    std::array<std::array<Interval, 2>, 3> gradients;
    Vector2d d = Vector2d::Zero();
    for (std::size_t i = 0; i < 3; ++i) {
        const auto [j, k] = pair(i);
        gradients[i] = heights_.family().tips.any()
                           ? heights_.plain_gradient_difference(forms[j], forms[k], X, Y)
                           : heights_.gradient_difference(forms[j], forms[k], X, Y);
        const Vector2d g(gradients[i][0].mid(), gradients[i][1].mid());
        if (g.norm() > d.norm()) d = g;
    }
    d.normalize();
    if (!d.allFinite()) return std::nullopt;
    std::array<Interval, 3> slopes;
    std::array<int, 3> behind{};  // how many of the others grow more
    for (std::size_t i = 0; i < 3; ++i) {
        slopes[i] = derivative(d, gradients[i]);
        const auto sign = slopes[i].sign();
        if (!sign || *sign == Sign::Zero) return std::nullopt;
        if (least_magnitude(slopes[i]) * margin < least_growth * size) return std::nullopt;
        const auto [j, k] = pair(i);
        ++behind[*sign == Sign::Positive ? k : j];
    }
    const Implied& which = implied(forms);
    constexpr double within = 31.0 / 32;  // leaves room for rounding, d's and this product's
    const auto meets_on_all_lines = [&](std::size_t i) {
        const auto [j, k] = pair(i);
        const Interval mx(half->mid()), my(y.mid());
        const Interval difference = jet(forms[j], mx, my).v - jet(forms[k], mx, my).v +
                                    gradients[i][0] * (*half - mx) + gradients[i][1] * (y - my);
        return difference.magnitude() <= least_magnitude(slopes[i]) * within * margin;
    };
    for (std::size_t i = 0; i < 3; ++i) {
        if (!which[i] || !meets_on_all_lines(i)) continue;
        if (which[i]->beside && !is_off(*which[i]->beside, X, Y, jet(forms[pair(i)[0]], X, Y).v)) continue;
        Order result;
        for (std::size_t k = 0; k < 3; ++k) result[static_cast<std::size_t>(behind[k])] = forms[k];
        return result;
    }
    return std::nullopt;
}

}  // namespace vcell
