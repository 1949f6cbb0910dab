#include "monotone_graph.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <type_traits>

namespace vcell {

using detail::signed_by;

namespace {

template <class T>
T lower_end(const T& t) {
    return T(t.lower(), t.lower());
}
template <class T>
T upper_end(const T& t) {
    return T(t.upper(), t.upper());
}
template <class T>
bool is_point(const T& t) {
    return t.lower() == t.upper();
}
/// The members that are not negative. Pre: there are some, up to rounding.
template <class T>
T non_negative(const T& t) {
    if (t.lower() >= 0) return t;
    return t.upper() > 0 ? hull(T(0.0), upper_end(t)) : T(0.0);
}

template <class T>
T hull_of(const std::vector<T>& values) {
    T all = values.front();
    for (const T& v : values) all = hull(all, v);
    return all;
}

template <class T>
std::vector<T> convert(const std::vector<Exact>& values) {
    std::vector<T> converted;
    for (const Exact& e : values) converted.push_back(enclosure_of<T>(e));
    return converted;
}

}  // namespace

// --- Circles and lines. --------------------------------------------------------------------------------

namespace {

// k v^2 + b v + (k u^2 + a u + e') = 0 with (u, v) = p - c and e' = e + a cx + b cy.
template <class T>
T root_of_discriminant(const CircularForm& f, const T& u) {
    const T k(f.k), a(f.a), b(f.b);
    const T constant = T(f.e) + a * T(f.cx) + b * T(f.cy);
    const T discriminant = square(b) - T(4.0) * k * (k * square(u) + a * u + constant);
    return discriminant.upper() < 0 ? T(0.0) : sqrt(discriminant);
}

}  // namespace

template <class T>
T CircularGraph::y(const T& x) const {
    const CircularForm& f = form;
    if (half == Sign::Zero) return -(T(f.a) * x + T(f.e)) / T(f.b);
    const T root = root_of_discriminant(f, T(x - T(f.cx)));
    return T(f.cy) + (signed_by(half, root) - T(f.b)) / (T(2.0) * T(f.k));
}

template <class T>
Direction<T> CircularGraph::direction(const T& x) const {
    const CircularForm& f = form;
    if (half == Sign::Zero) return f.b > 0 ? Direction<T>{T(f.b), T(-f.a)} : Direction<T>{T(-f.b), T(f.a)};
    const T u = x - T(f.cx);
    return {root_of_discriminant(f, u), signed_by(-half, T(T(2.0) * T(f.k) * u + T(f.a)))};
}

// --- Rational Bezier curves. ---------------------------------------------------------------------------

namespace {

template <class T>
T enclose_root(const std::vector<Exact>& polynomial, const SignChange& where) {
    const std::vector<T> c = convert<T>(polynomial);
    std::vector<T> derivative;
    for (std::size_t i = 0; i + 1 < c.size(); ++i) derivative.push_back(c[i + 1] - c[i]);
    const T bracket = hull(enclosure_of<T>(where.lower), enclosure_of<T>(where.upper));
    return enclose_zero(
        bracket, [&](const T& t) { return signed_by(where.after, bernstein_value<T>(c, t)); },
        [&](const T& t) {
            const T slope = hull_of(bernstein_restricted<T>(derivative, lower_end(t), upper_end(t)));
            return signed_by(where.after, T(T(static_cast<double>(derivative.size())) * slope));
        });
}

}  // namespace

BernsteinRoot::BernsteinRoot(std::shared_ptr<const std::vector<Exact>> polynomial, SignChange where)
    : polynomial_(std::move(polynomial)),
      where_(std::move(where)),
      rough_(enclose_root<Interval>(*polynomial_, where_)) {}

template <class T>
T BernsteinRoot::enclosure() const {
    if constexpr (std::is_same_v<T, Interval>) {
        return rough_;
    } else {
        if (!fine_) fine_ = enclose_root<T>(*polynomial_, where_);
        return *fine_;
    }
}

RationalBezier::RationalBezier(std::vector<Eigen::Vector3d> points) : points_(std::move(points)) {
    assert(points_.size() >= 2);
    std::array<std::vector<Exact>, 3> c;  // x, y, w
    for (const auto& p : points_) {
        const Exact w(p[2]);
        c[0].push_back(w * Exact(p[0]));
        c[1].push_back(w * Exact(p[1]));
        c[2].push_back(w);
    }
    // (X / W)' = (X' W - X W') / W^2.
    std::array<std::shared_ptr<const std::vector<Exact>>, 2> d;
    const std::vector<Exact> dw = bernstein_derivative(c[2]);
    for (int i = 0; i < 2; ++i) {
        std::vector<Exact> numerator = bernstein_scaled_product(bernstein_derivative(c[i]), c[2]);
        const std::vector<Exact> second = bernstein_scaled_product(c[i], dw);
        for (std::size_t k = 0; k < numerator.size(); ++k) numerator[k] -= second[k];
        d[i] = std::make_shared<const std::vector<Exact>>(std::move(numerator));
    }
    rough_ = {convert<Interval>(c[0]), convert<Interval>(c[1]), convert<Interval>(c[2]),
              convert<Interval>(*d[0]), convert<Interval>(*d[1])};
    fine_ = {convert<Wide>(c[0]), convert<Wide>(c[1]), convert<Wide>(c[2]), convert<Wide>(*d[0]),
             convert<Wide>(*d[1])};
    // Turns closer than 2^-200 of the domain are a coincidence like any other below that width.
    constexpr int depth = 200;
    for (const SignChange& change : bernstein_sign_changes(*d[0], depth)) turns_.emplace_back(d[0], change);
    for (const Exact& e : *d[0]) {
        if (e.sign() == Sign::Zero) continue;
        starts_rightward_ = e.sign() == Sign::Positive;
        break;
    }
}

template <class T>
const RationalBezier::Coefficients<T>& RationalBezier::coefficients() const {
    if constexpr (std::is_same_v<T, Interval>) {
        return rough_;
    } else {
        return fine_;
    }
}

template <class T>
std::pair<T, T> RationalBezier::at(const T& t) const {
    // The curve lies in the hull of its control points over t: weights stay positive.
    const auto& c = coefficients<T>();
    const T from = lower_end(t), to = upper_end(t);
    std::vector<T> x, y;
    for (std::size_t k = 0; k < points_.size(); ++k) {
        const T w = bernstein_blossom<T>(c.w, from, to, k);
        x.push_back(bernstein_blossom<T>(c.x, from, to, k) / w);
        y.push_back(bernstein_blossom<T>(c.y, from, to, k) / w);
    }
    return {hull_of(x), hull_of(y)};
}

template <class T>
T BezierGraph::parameter(const T& x) const {
    if (!is_point(x)) return hull(parameter(lower_end(x)), parameter(upper_end(x)));
    const Sign rising = rightward ? Sign::Positive : Sign::Negative;
    const auto& c = curve->coefficients<T>();
    std::vector<T> f, derivative;  // of W(t) (x(t) - x), and its derivative up to the degree
    for (std::size_t i = 0; i < c.x.size(); ++i) f.push_back(signed_by(rising, T(c.x[i] - x * c.w[i])));
    for (std::size_t i = 0; i + 1 < f.size(); ++i) derivative.push_back(f[i + 1] - f[i]);
    const T from = first.enclosure<T>(), to = last.enclosure<T>();
    return enclose_zero(
        hull(from, to),
        [&](const T& t) {
            if (t.lower() < from.upper() || t.upper() > to.lower()) return T::whole();
            return bernstein_value<T>(f, t);
        },
        [&](const T& t) {
            return T(static_cast<double>(derivative.size())) *
                   hull_of(bernstein_restricted<T>(derivative, lower_end(t), upper_end(t)));
        });
}

template <class T>
T BezierGraph::y(const T& x) const {
    return curve->at(parameter(x)).second;
}

template <class T>
Direction<T> BezierGraph::direction(const T& x) const {
    const T t = parameter(x);
    const auto& c = curve->coefficients<T>();
    const Sign sign = rightward ? Sign::Positive : Sign::Negative;
    const T from = lower_end(t), to = upper_end(t);
    return {non_negative(signed_by(sign, hull_of(bernstein_restricted<T>(c.dx, from, to)))),
            signed_by(sign, hull_of(bernstein_restricted<T>(c.dy, from, to)))};
}

// --- Traced curves. ------------------------------------------------------------------------------------

template <class T>
T TracedGraph::y_in(const Cell& cell, const T& x) const {
    T bracket(cell.y);
    // The lower rung's answer is the start of the higher one's.
    if constexpr (!std::is_same_v<T, Interval>) bracket = T(y_in(cell, x.enclosure()));
    std::optional<T> above_only, below_only;  // no sign is asked for beyond the ends of a steep cell
    if (cell.rising != Sign::Zero) {
        const bool rises = cell.rising == Sign::Positive;
        above_only = (rises ? cell.left : cell.right)->template coordinate<T>(1);
        below_only = (rises ? cell.right : cell.left)->template coordinate<T>(1);
        bracket = clamped(bracket, T(above_only->lower(), below_only->upper()));
    }
    const T strip = T(cell.y0) + T(cell.slope) * (x - T(cell.x0)) + T(-cell.band, cell.band);
    return enclose_zero(
        clamped(bracket, strip),
        [&](const T& y) {
            if ((above_only && y.lower() < above_only->upper()) ||
                (below_only && y.upper() > below_only->lower()))
                return T::whole();
            return signed_by(cell.above, g->value(x, y));
        },
        [&](const T& y) { return signed_by(cell.above, g->jet(x, y).gradient[1]); });
}

namespace {

/// The range of x of a cell. That of doubles overlaps those of its neighbours where they meet at no double.
template <class T>
T range_of(const TracedGraph::Cell& cell) {
    if constexpr (std::is_same_v<T, Interval>) {
        return {cell.x0, cell.x1};
    } else {
        return hull(cell.left->coordinate<T>(0), cell.right->coordinate<T>(0));
    }
}

// Calls visit(cell, part of x in the cell) for all cells that x meets; for the nearest one when it meets
// none.
template <class T, class Visit>
void visit_cells(const std::vector<TracedGraph::Cell>& cells, const T& x, const Visit& visit) {
    auto cell = std::partition_point(cells.begin(), cells.end() - 1,
                                     [&](const TracedGraph::Cell& c) { return c.x1 < x.lower(); });
    for (bool met = false;; ++cell) {
        const T range = range_of<T>(*cell);
        const bool beyond = x.upper() < range.lower(), meets = !beyond && x.lower() <= range.upper();
        const bool last = beyond || cell + 1 == cells.end() || x.upper() < (cell + 1)->x0;
        if (meets || (last && !met)) visit(*cell, clamped(range, x));
        met = met || meets;
        if (last) return;
    }
}

}  // namespace

template <class T>
T TracedGraph::y(const T& x) const {
    std::optional<T> all;
    visit_cells(cells, x, [&](const Cell& cell, const T& part) {
        const T y = y_in(cell, part);
        all = all ? hull(*all, y) : y;
    });
    return *all;
}

template <class T>
Direction<T> TracedGraph::direction(const T& x) const {
    std::optional<Direction<T>> all;
    visit_cells(cells, x, [&](const Cell& cell, const T& part) {
        const auto gradient = g->jet(part, y_in(cell, part)).gradient;
        const Direction<T> d{non_negative(signed_by(cell.above, gradient[1])),
                             signed_by(-cell.above, gradient[0])};
        all = all ? Direction<T>{hull(all->dx, d.dx), hull(all->dy, d.dy)} : d;
    });
    return *all;
}

Interval TracedGraph::rough_y(const Interval& x) const {
    std::optional<Interval> all;
    visit_cells(cells, x, [&](const Cell& cell, const Interval& part) {
        const Interval strip = Interval(cell.y0) + Interval(cell.slope) * (part - Interval(cell.x0)) +
                               Interval(-cell.band, cell.band);
        const Interval y = clamped(cell.y, strip);
        all = all ? hull(*all, y) : y;
    });
    return *all;
}

bool TracedGraph::holds_alone(Interval x, Interval y) const {
    // Cells take away the part of the box that they cover, one after another.
    auto cell =
        std::partition_point(cells.begin(), cells.end(), [&](const Cell& c) { return c.x1 < x.lower(); });
    for (; cell != cells.end() && cell->x0 <= x.upper(); ++cell) {
        const Interval& bx = cell->box_x;
        Interval by = cell->y;
        if (cell->rising != Sign::Zero) {
            // Beyond a turn there is another branch.
            const Interval left = cell->left->coordinate<Interval>(1);
            const Interval right = cell->right->coordinate<Interval>(1);
            const bool rises = cell->rising == Sign::Positive;
            by = {(rises ? left : right).upper(), (rises ? right : left).lower()};
            if (by.lower() > by.upper()) continue;
        }
        const bool within_x = bx.lower() <= x.lower() && x.upper() <= bx.upper();
        const bool within_y = by.lower() <= y.lower() && y.upper() <= by.upper();
        if (within_x && within_y) return true;
        if (within_y && bx.lower() <= x.lower() && x.lower() <= bx.upper())
            x = Interval(bx.upper(), x.upper());
        if (within_x && by.lower() <= y.lower() && y.lower() <= by.upper())
            y = Interval(by.upper(), y.upper());
        if (within_x && by.lower() <= y.upper() && y.upper() <= by.upper())
            y = Interval(y.lower(), by.lower());
    }
    return false;
}

#define VCELL_INSTANTIATE(T)                                        \
    template T BernsteinRoot::enclosure() const;                    \
    template T CircularGraph::y(const T&) const;                    \
    template Direction<T> CircularGraph::direction(const T&) const; \
    template std::pair<T, T> RationalBezier::at(const T&) const;    \
    template T BezierGraph::y(const T&) const;                      \
    template Direction<T> BezierGraph::direction(const T&) const;   \
    template T TracedGraph::y(const T&) const;                      \
    template Direction<T> TracedGraph::direction(const T&) const;
VCELL_INSTANTIATE(Interval)
VCELL_INSTANTIATE(Wide)
#undef VCELL_INSTANTIATE

}  // namespace vcell
