#include "monotone_graph.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <type_traits>

#include "../core/errors.hpp"

namespace vcell {

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
template <class T>
T signed_by(Sign s, const T& t) {
    return s == Sign::Negative ? -t : t;
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

namespace {

// The x in box_x with g(x, y) = 0. Pre: g_x has no zero over box_x * y.
template <class T>
T solve_x(const DefiningFunction& g, Sign g_x, const Interval& box_x, const T& y) {
    return enclose_zero(
        T(box_x), [&](const T& x) { return signed_by(g_x, g.value(x, y)); },
        [&](const T& x) { return signed_by(g_x, g.jet(x, y).gradient[0]); });
}

// (d/dy) g_y(h(y), y) along the curve x = h(y): h' = -g_y / g_x.
template <class T>
T turning(const Jet2<T>& j) {
    const T g_x = j.gradient[0].value, g_y = j.gradient[1].value;
    return j.gradient[1].gradient[1] - j.gradient[1].gradient[0] * g_y / g_x;
}

}  // namespace

TracedTurn::TracedTurn(std::shared_ptr<const DefiningFunction> g, Interval box_x, Interval box_y)
    : g_(std::move(g)), box_x_(box_x), box_y_(box_y), rough_(compute<Interval>()) {}

TracedTurn::TracedTurn(std::shared_ptr<const DefiningFunction> g, Interval box_x, double y)
    : TracedTurn(std::move(g), box_x, Interval(y)) {}

template <class T>
std::pair<T, T> TracedTurn::compute() const {
    const Sign g_x = g_->jet(box_x_, box_y_).gradient[0].sign().value();
    const auto x_at = [&](const T& y) { return solve_x(*g_, g_x, box_x_, y); };
    if (is_point(box_y_)) return {x_at(T(box_y_)), T(box_y_)};
    const Sign rising = turning(g_->second_jet(box_x_, box_y_)).sign().value();
    const T y = enclose_zero(
        T(box_y_), [&](const T& m) { return signed_by(rising, g_->jet(x_at(m), m).gradient[1]); },
        [&](const T& m) { return signed_by(rising, turning(g_->second_jet(x_at(m), m))); });
    return {x_at(y), y};
}

template <class T>
std::pair<T, T> TracedTurn::enclosure() const {
    if constexpr (std::is_same_v<T, Interval>) {
        return rough_;
    } else {
        if (!fine_) fine_ = compute<T>();
        return *fine_;
    }
}

template <class T>
T TracedGraph::y_in(const Cell& cell, const T& x) const {
    T bracket(cell.y);
    // The lower rung's answer is the start of the higher one's.
    if constexpr (!std::is_same_v<T, Interval>) bracket = T(y_in(cell, x.enclosure()));
    std::optional<T> above_only, below_only;  // no sign is asked for beyond a turn
    if (cell.lower_end) above_only = cell.lower_end->enclosure<T>().second;
    if (cell.upper_end) below_only = cell.upper_end->enclosure<T>().second;
    if (above_only) bracket = clamped(bracket, T(above_only->lower(), T(cell.y).upper()));
    if (below_only) bracket = clamped(bracket, T(T(cell.y).lower(), below_only->upper()));
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

// Calls visit(cell, part of x in the cell) for all cells that x meets; for the nearest one when it meets
// none.
template <class T, class Visit>
void visit_cells(const std::vector<TracedGraph::Cell>& cells, const T& x, const Visit& visit) {
    auto cell = std::partition_point(cells.begin(), cells.end() - 1,
                                     [&](const TracedGraph::Cell& c) { return c.x1 < x.lower(); });
    do {
        visit(*cell, clamped(T(cell->x0, cell->x1), x));
        ++cell;
    } while (cell != cells.end() && cell->x0 <= x.upper());
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

bool TracedGraph::holds_alone(const Interval& x, const Interval& y) const {
    if (x.lower() < cells.front().x0 || x.upper() > cells.back().x1) return false;
    bool alone = true;
    visit_cells(cells, x, [&](const Cell& cell, const Interval&) {
        alone = alone && cell.y.lower() < y.lower() && y.upper() < cell.y.upper();
    });
    return alone;
}

namespace {

/// Cuts a traced curve: pieces of the spline are halved until over the box around each piece's band either
/// g_y has no zero (the piece is flat), or g_x has none and the curve turns at most once (steep).
class TraceCutter {
public:
    explicit TraceCutter(const TracedCurve& curve) : curve_(curve), g_(*curve.g) {}

    std::vector<TracedPiece> run() {
        const RationalCurve2& s = curve_.spline;
        for (std::size_t i = 0; i + 1 < s.knots.size(); ++i) {
            if (s.knots[i] < s.knots[i + 1]) add(pieces_, s.knots[i], s.knots[i + 1], 0);
        }
        closed_ = s.points.front().head<2>() == s.points.back().head<2>();
        join_small_pieces();
        if (closed_) {
            // Start where nothing needs to be joined.
            const auto advance = [&](const Piece& p) {
                return p.steep ? 0 : std::abs(x_at(p.to) - x_at(p.from));
            };
            const auto start =
                std::max_element(pieces_.begin(), pieces_.end(),
                                 [&](const Piece& p, const Piece& q) { return advance(p) < advance(q); });
            if (start->steep) fail();
            std::rotate(pieces_.begin(), start, pieces_.end());
        }
        join_steep_pieces();
        join_uncertain_pieces();
        place_junctions();
        return assemble();
    }

private:
    static constexpr std::size_t max_pieces = std::size_t{1} << 16;  // a hopeless curve doubles them in vain
    static constexpr int max_depth = 40;  // halvings of a knot span; boxes then hardly differ from the band's

    struct Piece {
        double from, to;  // parameters
        int depth;
        Interval x, y;  // around the band
        bool steep = false;
    };
    /// Between two neighbouring pieces, or at a free end: a place known to be on the curve. On x, or (a free
    /// end of a steep piece) on y.
    struct Junction {
        Interval x, y;
        std::shared_ptr<const TracedTurn> on_y;
    };
    /// A cell in the direction of the curve, and the turn at its end.
    struct Step {
        TracedGraph::Cell cell;
        bool rightward;
        std::shared_ptr<const TracedTurn> turn;
    };

    struct Line {
        double x0, y0, slope;
        Interval at(const Interval& x) const { return Interval(y0) + Interval(slope) * (x - Interval(x0)); }
    };

    [[noreturn]] static void fail() {
        throw InputError(InputError::Kind::Unsupported, InputError::no_object, "curve",
                         "the band is too wide to tell how the curve runs in it");
    }

    /// The control points over [from, to] within one knot span, by the blossom of the homogeneous spline.
    std::vector<std::array<Interval, 2>> control_points(double from, double to) const {
        const RationalCurve2& s = curve_.spline;
        const auto n = static_cast<std::size_t>(s.degree);
        // The span [knots[j], knots[j + 1]) that holds `from`.
        const auto j = static_cast<std::size_t>(std::upper_bound(s.knots.begin(), s.knots.end(), from) -
                                                s.knots.begin() - 1);
        std::vector<std::array<Interval, 2>> result;
        for (std::size_t k = 0; k <= n; ++k) {
            std::vector<std::array<Interval, 3>> d;
            for (std::size_t i = j - n; i <= j; ++i) {
                const auto& p = s.points[i];
                d.push_back(
                    {Interval(p[0]) * Interval(p[2]), Interval(p[1]) * Interval(p[2]), Interval(p[2])});
            }
            for (std::size_t r = 1; r <= n; ++r) {
                const Interval u(r <= k ? to : from);
                for (std::size_t i = n; i >= r; --i) {
                    const Interval t0(s.knots[j - n + i]), t1(s.knots[j + 1 + i - r]);
                    const Interval a = (u - t0) / (t1 - t0);
                    for (int axis = 0; axis < 3; ++axis)
                        d[i][axis] = (Interval(1.0) - a) * d[i - 1][axis] + a * d[i][axis];
                }
            }
            result.push_back({d[n][0] / d[n][2], d[n][1] / d[n][2]});
        }
        return result;
    }

    void add(std::vector<Piece>& out, double from, double to, int depth) const {
        const auto points = control_points(from, to);
        Piece piece{from, to, depth, points[0][0], points[0][1]};
        for (const auto& p : points) {
            piece.x = hull(piece.x, p[0]);
            piece.y = hull(piece.y, p[1]);
        }
        const Interval band(-curve_.band, curve_.band);
        piece.x += band;
        piece.y += band;
        if (!has_sign(g_.jet(piece.x, piece.y).gradient[1])) {
            piece.steep = true;
            if (!turns_at_most_once(piece.x, piece.y)) return halve(out, piece);
        }
        out.push_back(piece);
    }
    void halve(std::vector<Piece>& out, const Piece& piece) const {
        // A box around less than half a band's width of spline hardly shrinks any more.
        const double size = std::max(piece.x.upper() - piece.x.lower(), piece.y.upper() - piece.y.lower());
        if (piece.depth == max_depth || size < 2.5 * curve_.band || pieces_.size() > max_pieces) fail();
        const double middle = std::midpoint(piece.from, piece.to);
        add(out, piece.from, middle, piece.depth + 1);
        add(out, middle, piece.to, piece.depth + 1);
    }
    static bool has_sign(const Interval& i) { return i.lower() > 0 || i.upper() < 0; }
    bool turns_at_most_once(const Interval& x, const Interval& y) const {
        return has_sign(g_.jet(x, y).gradient[0]) && has_sign(turning(g_.second_jet(x, y)));
    }

    /// Rows of steep pieces become one steep piece, or are halved until some of them are flat.
    void join_steep_pieces() {
        std::vector<Piece> joined;
        for (std::size_t i = 0; i < pieces_.size();) {
            std::size_t end = i + 1;
            Piece row = pieces_[i];
            if (row.steep) {
                for (; end < pieces_.size() && pieces_[end].steep; ++end) {
                    row.x = hull(row.x, pieces_[end].x);
                    row.y = hull(row.y, pieces_[end].y);
                }
                row.to = pieces_[end - 1].to;
            }
            if (end > i + 1 && !turns_at_most_once(row.x, row.y)) {
                std::vector<Piece> finer;
                for (std::size_t k = i; k < end; ++k) halve(finer, pieces_[k]);
                pieces_.erase(pieces_.begin() + static_cast<std::ptrdiff_t>(i),
                              pieces_.begin() + static_cast<std::ptrdiff_t>(end));
                pieces_.insert(pieces_.begin() + static_cast<std::ptrdiff_t>(i), finer.begin(), finer.end());
                continue;
            }
            joined.push_back(row);
            i = end;
        }
        pieces_ = std::move(joined);
    }

    /// Will the curve advance in x along a flat piece as the spline does, although it may be off by the band,
    /// and stay within a box?
    bool is_certain(const Piece& p) const {
        return std::abs(x_at(p.to) - x_at(p.from)) > 2.5 * curve_.band && heights(p);
    }
    void erase(std::size_t i) { pieces_.erase(pieces_.begin() + static_cast<std::ptrdiff_t>(i)); }

    /// Flat pieces hardly longer than the band is wide tell nothing: joins them.
    void join_small_pieces() {
        const double size = 12 * curve_.band;
        for (std::size_t i = 1; i < pieces_.size();) {
            const Piece &p = pieces_[i - 1], &q = pieces_[i];
            const Interval x = hull(p.x, q.x), y = hull(p.y, q.y);
            const bool small = std::max(x.upper() - x.lower(), y.upper() - y.lower()) <= size;
            if (small && !p.steep && !q.steep && join(pieces_[i - 1], pieces_[i], false)) {
                erase(i);
            } else {
                ++i;
            }
        }
    }
    /// Joins uncertain flat pieces with steep neighbours first, and then with flat ones.
    void join_uncertain_pieces() {
        for (std::size_t i = 0; i < pieces_.size(); ++i) {
            if (!pieces_[i].steep) continue;
            while (i > 0 && !pieces_[i - 1].steep && !is_certain(pieces_[i - 1]) &&
                   join(pieces_[i - 1], pieces_[i], true))
                erase(i--);
            while (i + 1 < pieces_.size() && !pieces_[i + 1].steep && !is_certain(pieces_[i + 1]) &&
                   join(pieces_[i], pieces_[i + 1], true))
                erase(i + 1);
            if (i > 0 && pieces_[i - 1].steep) {
                if (!join(pieces_[i - 1], pieces_[i], true)) fail();
                erase(i--);
            }
        }
        for (std::size_t i = 0; i < pieces_.size();) {
            if (pieces_[i].steep || is_certain(pieces_[i])) {
                ++i;
            } else if (i > 0 && !pieces_[i - 1].steep && join(pieces_[i - 1], pieces_[i], false)) {
                erase(i--);
            } else if (i + 1 < pieces_.size() && !pieces_[i + 1].steep &&
                       join(pieces_[i], pieces_[i + 1], false)) {
                erase(i + 1);
            } else {
                fail();
            }
        }
        for (Piece& p : pieces_) {
            if (!p.steep) p.y = heights(p).value();
        }
    }
    double x_at(double parameter) const { return curve_.spline.evaluate(parameter).x(); }
    Interval x_range(const Piece& p) const {
        const auto [lo, hi] = std::minmax({x_at(p.from), x_at(p.to)});
        return {lo, hi};
    }
    /// An interval of y around a flat piece, without zeros of g_y, along whose ends g has opposite signs: so
    /// the curve runs from one cut to the other between them, once. Where the curve is steep it gets to the
    /// cuts further up or down than the spline.
    std::optional<Interval> heights(const Piece& p) const {
        const Interval x = x_range(p);
        Interval y = p.y;
        constexpr int max_steps = 12;
        for (int step = 0; step < max_steps; ++step) {
            const auto above = g_.jet(p.x, y).gradient[1].sign();
            if (!above || *above == Sign::Zero) return std::nullopt;
            const bool low = has_sign_along({x.lower(), y.lower(), 0}, x, -*above);
            const bool high = has_sign_along({x.lower(), y.upper(), 0}, x, *above);
            if (low && high) return y;
            const double more = 2 * curve_.band;
            y = Interval(low ? y.lower() : y.lower() - more, high ? y.upper() : y.upper() + more);
        }
        return std::nullopt;
    }
    /// Is g shown to have the sign all along the line over x? By its mean value form on up to 2^6 parts.
    bool has_sign_along(const Line& line, const Interval& x, Sign sign, int depth = 6) const {
        const Interval middle(x.mid());
        const Interval at_middle = g_.value(middle, line.at(middle));
        if (at_middle.sign() != sign) return false;
        const auto gradient = g_.jet(x, line.at(x)).gradient;
        const Interval along = gradient[0] + Interval(line.slope) * gradient[1];
        if ((at_middle + along * (x - middle)).sign() == sign) return true;
        return depth > 0 && has_sign_along(line, {x.lower(), x.mid()}, sign, depth - 1) &&
               has_sign_along(line, {x.mid(), x.upper()}, sign, depth - 1);
    }
    /// Makes p reach to the end of q if that is one piece of the wanted kind.
    bool join(Piece& p, const Piece& q, bool steep) const {
        const Interval x = hull(p.x, q.x), y = hull(p.y, q.y);
        if (steep ? !turns_at_most_once(x, y) : !has_sign(g_.jet(x, y).gradient[1])) return false;
        p = {p.from, q.to, p.depth, x, y, steep};
        return true;
    }

    // junctions_[i] is where piece i begins, the last one where the last piece ends.
    void place_junctions() {
        for (std::size_t i = 0; i <= pieces_.size(); ++i) {
            const bool first = i == 0, last = i == pieces_.size();
            if (last && closed_) {
                junctions_.push_back(junctions_.front());
                break;
            }
            const Piece& before = first ? (closed_ ? pieces_.back() : pieces_.front()) : pieces_[i - 1];
            const Piece& after = last ? pieces_.back() : pieces_[i];
            const Eigen::Vector2d p = curve_.spline.evaluate(last ? before.to : after.from);
            if (!before.steep) {
                junctions_.push_back(on_x(before, p.x()));
            } else if (!after.steep) {
                junctions_.push_back(on_x(after, p.x()));
            } else {
                const auto end = std::make_shared<const TracedTurn>(curve_.g, after.x, p.y());
                const auto [x, y] = end->enclosure<Interval>();
                junctions_.push_back({x, y, end});
            }
        }
    }
    Junction on_x(const Piece& flat, double x) const {
        const Sign above = g_.jet(flat.x, flat.y).gradient[1].sign().value();
        const auto side = [&](double y) { return g_.value(Interval(x), Interval(y)).sign(); };
        if (side(flat.y.lower()) != -above || side(flat.y.upper()) != above) fail();
        const TracedGraph graph{
            curve_.g,
            {{x, x, flat.y, above, nullptr, nullptr, flat.y.mid(), 0, flat.y.upper() - flat.y.lower()}}};
        return {Interval(x), graph.y(Interval(x)), nullptr};
    }

    std::vector<TracedPiece> assemble() {
        std::vector<Step> steps;
        for (std::size_t i = 0; i < pieces_.size(); ++i)
            add_steps(steps, pieces_[i], junctions_[i], junctions_[i + 1]);
        std::optional<TracedEnd> first_end;
        if (closed_) {
            const auto turn =
                std::find_if(steps.begin(), steps.end(), [](const Step& s) { return s.turn != nullptr; });
            if (turn == steps.end()) fail();
            const TracedEnd end = turn->turn;
            std::rotate(steps.begin(), turn + 1, steps.end());
            first_end = end;
        } else {
            first_end = end_at(junctions_.front());
        }
        std::vector<TracedPiece> result;
        TracedEnd from = *first_end;
        for (std::size_t i = 0; i < steps.size();) {
            TracedPiece piece;
            piece.graph.g = curve_.g;
            const bool rightward = steps[i].rightward;
            TracedEnd to = end_at(junctions_.back());
            for (bool go_on = true; go_on && i < steps.size(); ++i) {
                if (steps[i].rightward != rightward) fail();
                piece.graph.cells.push_back(steps[i].cell);
                if (steps[i].turn) {
                    to = steps[i].turn;
                    go_on = false;
                }
            }
            if (!rightward) std::reverse(piece.graph.cells.begin(), piece.graph.cells.end());
            piece.left = rightward ? from : to;
            piece.right = rightward ? to : from;
            from = to;
            result.push_back(std::move(piece));
        }
        return result;
    }
    static TracedEnd end_at(const Junction& j) {
        if (j.on_y) return j.on_y;
        return j.x.lower();
    }

    void add_steps(std::vector<Step>& steps, const Piece& piece, const Junction& from,
                   const Junction& to) const {
        if (!piece.steep) {
            const Sign above = g_.jet(piece.x, piece.y).gradient[1].sign().value();
            steps.push_back(step(piece.y, above, from, to));
            set_band(steps.back().cell, piece);
            return;
        }
        const auto g_y = [&](const Junction& j) {
            const auto sign = g_.jet(j.x, j.y).gradient[1].sign();
            if (!sign || *sign == Sign::Zero) fail();
            return *sign;
        };
        const Sign before = g_y(from), after = g_y(to);
        const Interval y = hull(from.y, to.y);
        // The cuts may lie beyond the piece's own box.
        if (!turns_at_most_once(piece.x, hull(y, piece.y))) fail();
        if (before == after) {
            steps.push_back(step(y, before, from, to));
            return;
        }
        const auto turn = std::make_shared<const TracedTurn>(curve_.g, piece.x, y);
        const auto [turn_x, turn_y] = turn->enclosure<Interval>();
        const Junction at_turn{turn_x, turn_y, turn};
        steps.push_back(step(hull(from.y, turn_y), before, from, at_turn));
        steps.back().turn = turn;
        steps.push_back(step(hull(turn_y, to.y), after, at_turn, to));
    }
    /// The cell from one place to another; without a band narrower than `y`.
    Step step(const Interval& y, Sign above, const Junction& from, const Junction& to) const {
        Step s{{std::min(from.x.lower(), to.x.lower()), std::max(from.x.upper(), to.x.upper()), y, above,
                nullptr, nullptr, y.mid(), 0, y.upper() - y.lower()},
               from.x.upper() < to.x.lower(),
               nullptr};
        if (!s.rightward && !(to.x.upper() < from.x.lower())) fail();
        for (const auto& [here, other] : {std::pair(from, to), std::pair(to, from)}) {
            if (!here.on_y) continue;
            if (here.y.upper() < other.y.lower()) {
                s.cell.lower_end = here.on_y;
            } else if (other.y.upper() < here.y.lower()) {
                s.cell.upper_end = here.on_y;
            } else {
                fail();
            }
        }
        return s;
    }

    // A band about the piece's chord, as the spline suggests, shown by the signs of g along its rims.
    void set_band(TracedGraph::Cell& cell, const Piece& piece) const {
        const Eigen::Vector2d a = curve_.spline.evaluate(piece.from), b = curve_.spline.evaluate(piece.to);
        const Eigen::Vector2d middle = curve_.spline.evaluate(std::midpoint(piece.from, piece.to));
        const double slope = (b.y() - a.y()) / (b.x() - a.x());
        const double y0 = a.y() + slope * (cell.x0 - a.x());
        double band = 1.5 * std::abs(middle.y() - y0 - slope * (middle.x() - cell.x0)) +
                      2 * curve_.band * (1 + std::abs(slope));
        constexpr int max_doublings = 3;
        for (int i = 0; i <= max_doublings; ++i, band *= 2) {
            const Interval x(cell.x0, cell.x1);
            if (!has_sign_along({cell.x0, y0 - band, slope}, x, -cell.above) ||
                !has_sign_along({cell.x0, y0 + band, slope}, x, cell.above))
                continue;
            cell.y0 = y0;
            cell.slope = slope;
            cell.band = band * (1 + 0x1p-40);  // the rims' heights are rounded
            return;
        }
    }

    const TracedCurve& curve_;
    const DefiningFunction& g_;
    bool closed_ = false;
    std::vector<Piece> pieces_;
    std::vector<Junction> junctions_;
};

}  // namespace

std::vector<TracedPiece> cut_traced_curve(const TracedCurve& curve) { return TraceCutter(curve).run(); }

#define VCELL_INSTANTIATE(T)                                        \
    template T BernsteinRoot::enclosure() const;                    \
    template std::pair<T, T> TracedTurn::enclosure() const;         \
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
