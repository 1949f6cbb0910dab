#include "moments.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <type_traits>
#include <utility>
#include <vector>

#include "../../core/errors.hpp"
#include "../../core/quadrature/bounded_sum.hpp"
#include "../../envelope/measures/span_integrals.hpp"
#include "lowered_net.hpp"
#include "shell.hpp"

namespace vcell {

namespace {

using Eigen::Vector2d;
using Eigen::Vector4d;
using span_integrals::PowerSpan;
using span_integrals::SpanPoint;
using span_integrals::term_rounding;

constexpr double unit_roundoff = std::numeric_limits<double>::epsilon() / 2;

/// Volume; x, y, z; xx, yy, zz, yz, zx, xy.
constexpr std::size_t terms = 10;
constexpr std::array<std::array<int, 2>, 6> pairs{{{0, 0}, {1, 1}, {2, 2}, {1, 2}, {2, 0}, {0, 1}}};
/// What the flux of q times a term's coordinates is divided by.
constexpr double divisor(std::size_t term) { return term == 0 ? 3 : term < 4 ? 4 : 5; }

/// Coordinates from about the cell's middle, in a unit about its size. The unit is a power of two.
struct Frame {
    Vec3 origin;
    double unit;

    Vec3 operator()(const Vec3& p) const { return (p - origin) / unit; }
};

// ---- Bezier forms -------------------------------------------------------------------------------------

using Row = std::vector<Vector4d>;

Row homogeneous(const SmallVector<Vector4d, 9>& points, const Frame& frame) {
    Row row;
    for (const Vector4d& p : points) {
        Vector4d h;
        h << p.w() * frame(p.head<3>()), p.w();
        row.push_back(h);
    }
    return row;
}

/// The control points of a polynomial over [0, 1] for its part over [a, b]: its blossoms there.
Row restricted(const Row& points, double a, double b) {
    const std::size_t degree = points.size() - 1;
    Row result;
    for (std::size_t k = 0; k <= degree; ++k) {
        Row level = points;
        for (std::size_t r = 1; r <= degree; ++r) {
            const double t = r <= k ? b : a;
            for (std::size_t i = 0; i + r <= degree; ++i) level[i] = (1 - t) * level[i] + t * level[i + 1];
        }
        result.push_back(level[0]);
    }
    return result;
}

/// Coefficients of the powers of x, -1 <= x <= 1.
Row powers(Row b) {
    // De Casteljau at the middle leaves the right half's points, whose differences times binomials they are.
    const std::size_t degree = b.size() - 1;
    for (std::size_t level = 1; level <= degree; ++level)
        for (std::size_t k = 0; k + level <= degree; ++k) b[k] = 0.5 * (b[k] + b[k + 1]);
    Row a;
    double binomial = 1;
    for (std::size_t k = 0; k <= degree; ++k) {
        a.push_back(binomial * b[0]);
        for (std::size_t i = 0; i + k < degree; ++i) b[i] = b[i + 1] - b[i];
        binomial *= static_cast<double>(degree - k) / static_cast<double>(k + 1);
    }
    return a;
}

/// The Bezier pieces of a trim between its knots, homogeneous: (w u, w v, 0, w).
std::vector<Row> pieces(const RationalCurve2& c) {
    const auto d = static_cast<std::size_t>(c.degree);
    std::vector<Row> result;
    for (std::size_t k = d; k + d + 1 < c.knots.size(); ++k) {
        const double a = c.knots[k], b = c.knots[k + 1];
        if (!(a < b)) continue;
        Row piece;
        for (std::size_t j = 0; j <= d; ++j) {
            Row level;
            for (std::size_t i = k - d; i <= k; ++i) {
                const Eigen::Vector3d& p = c.points[i];
                level.emplace_back(p[0] * p[2], p[1] * p[2], 0, p[2]);
            }
            for (std::size_t r = 1; r <= d; ++r)
                for (std::size_t i = d; i >= r; --i) {
                    const double from = c.knots[k - d + i], to = c.knots[k + i + 1 - r];
                    const double t = r <= j ? b : a, s = (t - from) / (to - from);
                    level[i] = (1 - s) * level[i - 1] + s * level[i];
                }
            piece.push_back(level[d]);
        }
        result.push_back(std::move(piece));
    }
    return result;
}

// ---- One patch ------------------------------------------------------------------------------------------

/// Of a trim's span: where faces are so thin or bent that these are not enough, errors say so.
constexpr int most_halvings = 1000;

/// What a trim adds: the antiderivative in x of the flux, from x = 0 on, times dy. (x, y) are (u, v), so that
/// the trims lie in [-1, 1]^2.
///
/// With S = N / W, S.(S_x x S_y) = N.(N_x x N_y) / W^3: what the derivatives of W add is along N.
class FluxAlong {
public:
    static constexpr std::size_t most_degree = 8;

    FluxAlong(const RationalPatch& surface, const Vector2d& middle, const Vector2d& half, const Frame& frame)
        : m_(static_cast<std::size_t>(surface.degree_u)), n_(static_cast<std::size_t>(surface.degree_v)) {
        const auto ends = [&](int axis, const std::array<double, 2>& domain) {
            const double width = domain[1] - domain[0];
            return std::array{(middle[axis] - half[axis] - domain[0]) / width,
                              (middle[axis] + half[axis] - domain[0]) / width};
        };
        const auto [u0, u1] = ends(0, surface.domain_u);
        const auto [v0, v1] = ends(1, surface.domain_v);
        Row all = homogeneous(surface.points, frame);
        for (const Vector4d& p : surface.points) reach_ = std::max(reach_, p.head<3>().cwiseAbs().maxCoeff());
        reach_ /= frame.unit;
        if (std::max(m_, n_) > most_degree) {
            // Control points of little weight lie far away, and move the surface by their weight's share.
            reach_ = 0;
            for (const Vector4d& h : all) reach_ = std::max(reach_, h.head<3>().cwiseAbs().maxCoeff());
            LoweredNet lowered = lowered_net(all, m_, n_);
            // The surface is within the cell's size, and off by its weight's error times that, too.
            blur_ += 4 * lowered.lost / rounding_of_points();
            is_weighted_ = true;
            all = std::move(lowered.net);
            m_ = n_ = 2;
        }
        std::vector<Row> columns;  // over [-1, 1]^2, one for each j
        for (std::size_t j = 0; j <= n_; ++j) {
            Row column;
            for (std::size_t i = 0; i <= m_; ++i) column.push_back(all[i * (n_ + 1) + j]);
            columns.push_back(restricted(column, u0, u1));
        }
        std::vector<Row> rows;
        for (std::size_t i = 0; i <= m_; ++i) {
            Row row;
            for (std::size_t j = 0; j <= n_; ++j) row.push_back(columns[j][i]);
            rows.push_back(restricted(row, v0, v1));
        }
        make_even(rows);
        for (std::size_t i = 0; i <= m_; ++i) rows[i] = powers(rows[i]);
        constexpr std::size_t most_exact = 6;  // rules have polynomials of degree 31, and these have 5 m - 1
        is_polynomial_ = m_ <= most_exact;
        for (std::size_t j = 0; j <= n_; ++j) {
            Row column;
            for (std::size_t i = 0; i <= m_; ++i) column.push_back(rows[i][j]);
            column = powers(column);
            for (std::size_t i = 0; i <= m_; ++i) c_[i][j] = column[i];
        }
        const double rounding = 16 * unit_roundoff * std::abs(c_[0][0][3]);
        for (std::size_t i = 0; i <= m_; ++i)
            for (std::size_t j = 0; j <= n_; ++j) {
                if (i + j == 0) continue;
                double& weight = c_[i][j][3];
                if (std::abs(weight) <= rounding) weight = 0;  // equal weights
                is_polynomial_ = is_polynomial_ && weight == 0;
            }
        find_parts();
    }

    template <class T>
    std::array<T, terms> operator()(const SpanPoint<T>& place) const {
        const SpanPoint<T> p = evened(place);
        const Slice<T> slice(*this, p.y);
        std::array<T, terms> sum;
        sum.fill(T(0.0));
        const auto& rule = quadrature::rule();
        for (const Part& part : parts_) {
            const T middle = p.x * T(part.middle), half = p.x * T(part.half);
            std::array<T, terms> within;
            within.fill(T(0.0));
            for (std::size_t k = 0; k < rule.x.size(); ++k)
                for (const double x : {-rule.x[k], rule.x[k]}) {
                    const std::array<T, terms> f = slice.flux(middle + T(x) * half);
                    for (std::size_t i = 0; i < terms; ++i) within[i] = within[i] + T(rule.weight[k]) * f[i];
                }
            for (std::size_t i = 0; i < terms; ++i) sum[i] = sum[i] + half * within[i];
        }
        for (T& s : sum) s = s * p.y1;
        if constexpr (!std::is_same_v<T, double>) add_inner_bounds(p, slice, sum);
        return sum;
    }

    std::array<double, terms> sizes(const SpanPoint<double>& place) const {
        const SpanPoint<double> p = evened(place);
        const Slice<double> slice(*this, p.y);
        std::array<double, terms> sum{};
        // Places are rounded, and with them where the integral along x ends and how far apart these are: one
        // after the other, and both at once, which is the product of what both are off.
        const double off = unit_roundoff * place_, noise = off / term_rounding,
                     way = std::abs(p.x1) + std::abs(p.y1),
                     size = std::abs(p.x) * (std::abs(p.y1) + noise * way) +
                            noise * (std::abs(p.y1) + off * way);
        constexpr int samples = 4;
        for (int k = 0; k <= samples; ++k) {
            const std::array<double, terms> f = slice.size(p.x * k / samples);
            for (std::size_t i = 0; i < terms; ++i) sum[i] = std::max(sum[i], f[i]);
        }
        for (double& s : sum) s *= size;
        return sum;
    }

    /// Of the trims' (u, v), in these coordinates.
    void set_place(double size) { place_ = size; }

private:
    double rounding_of_points() const { return 4 * unit_roundoff * reach_; }

    using Column = std::array<Vector4d, most_degree + 1>;
    /// Of the way from 0 to x, as parts of it.
    struct Part {
        double middle, half;
    };
    static constexpr double ellipse = 2.4;  // quadrature.hpp

    /// The patch at one y, as polynomials in x.
    template <class T>
    struct Slice {
        std::array<std::array<T, 4>, most_degree + 1> p;   // homogeneous
        std::array<std::array<T, 3>, most_degree + 1> py;  // derivatives by y
        const FluxAlong& of;

        Slice(const FluxAlong& flux, const T& y) : of(flux) {
            for (std::size_t i = 0; i <= of.m_; ++i)
                for (std::size_t c = 0; c < 4; ++c) {
                    T value(coefficient(i, of.n_, c)), slope(0.0);
                    for (std::size_t j = of.n_; j-- > 0;) {
                        slope = slope * y + value;
                        value = value * y + T(coefficient(i, j, c));
                    }
                    p[i][c] = value;
                    if (c < 3) py[i][c] = slope;
                }
        }
        double coefficient(std::size_t i, std::size_t j, std::size_t c) const {
            return of.c_[i][j][static_cast<Eigen::Index>(c)];
        }
        T weight(const T& x) const {
            T w = p[of.m_][3];
            for (std::size_t i = of.m_; i-- > 0;) w = w * x + p[i][3];
            return w;
        }
        std::array<T, terms> flux(const T& x) const {
            std::array<T, 3> at, along, across;
            for (std::size_t c = 0; c < 3; ++c) {
                at[c] = p[of.m_][c];
                across[c] = py[of.m_][c];
                along[c] = T(0.0);
                for (std::size_t i = of.m_; i-- > 0;) {
                    along[c] = along[c] * x + at[c];
                    at[c] = at[c] * x + p[i][c];
                    across[c] = across[c] * x + py[i][c];
                }
            }
            const T w = of.is_polynomial_ ? p[0][3] : weight(x);
            const T r = T(1.0) / w;
            for (T& a : at) a = a * r;
            const T volume = (at[0] * (along[1] * across[2] - along[2] * across[1]) +
                              at[1] * (along[2] * across[0] - along[0] * across[2]) +
                              at[2] * (along[0] * across[1] - along[1] * across[0])) *
                             (r * r);
            std::array<T, terms> f;
            f[0] = T(1 / divisor(0)) * volume;
            for (std::size_t c = 0; c < 3; ++c) f[1 + c] = T(1 / divisor(1)) * (at[c] * volume);
            for (std::size_t k = 0; k < pairs.size(); ++k)
                f[4 + k] = T(1 / divisor(4)) * (at[static_cast<std::size_t>(pairs[k][0])] *
                                                (at[static_cast<std::size_t>(pairs[k][1])] * volume));
            return f;
        }
        /// Bounds the absolute values of what flux() adds up, and of what it is off by because points are
        /// rounded in the user's coordinates.
        std::array<double, terms> size(const T& x) const {
            double at = 0, along = 0, across = 0, power = 1, slope = 1;
            const auto length = [](const auto& v) { return std::hypot(v[0], v[1], v[2]); };
            for (std::size_t i = 0; i <= of.m_; ++i) {
                at += power * length(p[i]);
                across += power * length(py[i]);
                if (i > 0) along += static_cast<double>(i) * slope * length(p[i]);
                if (i > 0) slope = power;
                power *= std::abs(x);
            }
            const double w = std::abs(weight(x)), r = 1 / w;
            // Control points come in rounded to the size of coordinates, and that goes into each factor.
            const double noise = of.rounding_of_points() * (of.is_weighted_ ? r : 1) / term_rounding;
            const double place = at * r, area = along * across * r * r,
                         rough = (place + noise) * area + place * noise * (along + across) * r;
            std::array<double, terms> f{};
            f[0] = of.blur_ * rough;
            for (std::size_t c = 0; c < 3; ++c) f[1 + c] = of.blur_ * (place + noise) * rough;
            for (std::size_t k = 0; k < pairs.size(); ++k)
                f[4 + k] = of.blur_ * (place + noise) * (place + noise) * rough;
            return f;
        }
    };

    /// Weights that grow or fall throughout have a zero next to the end where they are least. With w_i e^i in
    /// the place of w_i the patch is the same, at s / (e + (1 - e) s) in the place of s, 0 <= s <= 1: so that
    /// weights are as large at both ends.
    void make_even(std::vector<Row>& rows) {
        const auto weight = [&](std::size_t i, std::size_t j) { return rows[i][j][3]; };
        std::array<double, 2> low{0, 0}, high{0, 0};
        for (std::size_t i = 0; i <= m_; ++i) {
            low[1] += weight(i, 0);
            high[1] += weight(i, n_);
        }
        for (std::size_t j = 0; j <= n_; ++j) {
            low[0] += weight(0, j);
            high[0] += weight(m_, j);
        }
        constexpr double same = 1e-3;
        for (const std::size_t k : {0, 1}) {
            const double factor = std::pow(low[k] / high[k], 1 / static_cast<double>(k == 0 ? m_ : n_));
            if (low[k] > 0 && high[k] > 0 && std::abs(factor - 1) > same) even_[k] = factor;
        }
        std::array<double, 2> power{1, 1};
        for (std::size_t i = 0; i <= m_; ++i, power[0] *= even_[0]) {
            power[1] = 1;
            for (std::size_t j = 0; j <= n_; ++j, power[1] *= even_[1]) rows[i][j] *= power[0] * power[1];
        }
    }
    template <class T>
    SpanPoint<T> evened(const SpanPoint<T>& p) const {
        SpanPoint<T> result = p;
        const auto move = [](double e, T& x, T& x1) {
            if (e == 1) return;
            const T twice = T(1.0) + x, r = T(1.0) / (T(2 * e) + T(1 - e) * twice);
            x = T(2.0) * twice * r - T(1.0);
            x1 = T(4 * e) * (x1 * (r * r));
        };
        move(even_[0], result.x, result.x1);
        move(even_[1], result.y, result.y1);
        return result;
    }

    /// The integral along x is truncated, too: by no more than a rule's bound times the flux about a part.
    /// Its disc grows by as much as makes the outer rule's bound one of both.
    template <class T>
    void add_inner_bounds(const SpanPoint<T>& p, const Slice<T>& slice, std::array<T, terms>& sum) const {
        if (is_polynomial_) return;  // of a degree that the rule has exactly
        for (const Part& part : parts_) {
            const T middle = p.x * T(part.middle), half = p.x * T(part.half);
            const std::array<T, terms> f = slice.flux(middle + ComplexBall(0.0, ellipse) * half);
            const double factor = 2 * half.magnitude() * p.y1.magnitude();
            for (std::size_t i = 0; i < terms; ++i) sum[i].radius += f[i].magnitude() * factor;
        }
    }

    /// Integrals along x in parts about which the weight does not vanish: the more of them, the nearer its
    /// zeros.
    void find_parts() {
        parts_.clear();
        if (is_polynomial_)
            parts_.push_back({0.5, 0.5});
        else
            add_parts({0.5, 0.5}, 0);
    }
    void add_parts(const Part& part, int depth) {
        constexpr int deepest = 16;
        if (depth == deepest || is_clear(part)) return parts_.push_back(part);
        const double quarter = 0.5 * part.half;
        add_parts({part.middle - quarter, quarter}, depth + 1);
        add_parts({part.middle + quarter, quarter}, depth + 1);
    }
    /// At places of y, on the way to x = -1 and to x = 1.
    bool is_clear(const Part& part) const {
        constexpr int samples = 16;
        for (int k = -samples; k <= samples; ++k) {
            const Slice<ComplexBall> slice(*this, static_cast<double>(k) / samples);
            for (const double end : {-1.0, 1.0}) {
                const ComplexBall w = slice.weight(ComplexBall(end * part.middle, ellipse * part.half));
                if (!(std::abs(w.center) > 1.25 * w.radius)) return false;
            }
        }
        return true;
    }

    std::size_t m_, n_;
    std::array<Column, most_degree + 1> c_;  // of x^i y^j
    double reach_ = 0;                       // of coordinates
    double blur_ = 1;                        // by how much points are off, over their rounding
    double place_ = 0;
    std::array<double, 2> even_{1, 1};
    bool is_weighted_ = false;  // reach_ is that of homogeneous coordinates
    bool is_polynomial_ = false;
    std::vector<Part> parts_;
};

// ---- The cell -------------------------------------------------------------------------------------------

class Summer {
public:
    explicit Summer(const Cell& cell)
        : cell_(cell),
          made_(cell.closing ? Closing{} : closing_of(cell)),
          closing_(cell.closing ? *cell.closing : made_) {
        for_each_edge([&](const CellEdge& e, double) {
            for (const Vector4d& p : e.curve.points) bounds_.extend(p.head<3>());
        });
        if (bounds_.isEmpty())
            for (const CellFace& face : cell.faces)
                for (const TrimmedPatch& patch : face.patches)
                    for (const Vector4d& p : patch.surface.points) bounds_.extend(p.head<3>());
        if (bounds_.isEmpty()) throw InternalError("moments_of: the cell has no patches");
        int exponent = 0;
        std::frexp(bounds_.diagonal().norm(), &exponent);
        frame_ = {bounds_.center(), std::ldexp(1.0, exponent - 1)};
    }

    Moments moments() {
        for (const auto* faces : {&cell_.faces, &closing_.faces})
            for (const CellFace& face : *faces)
                for (const TrimmedPatch& patch : face.patches) add(patch);
        for_each_edge([&](const CellEdge& e, double error) { add_strips(e, error); });
        return result();
    }

private:
    /// With the bound on how far trims that run along it may be from the true arc.
    template <class Visit>
    void for_each_edge(const Visit& visit) const {
        const std::size_t own = cell_.vertices.size();
        for (const auto* edges : {&cell_.edges, &closing_.edges})
            for (const CellEdge& e : *edges) {
                double error = 2 * e.error;
                for (const std::uint32_t v : e.vertices)
                    error =
                        std::max(error, 2 * e.error +
                                            (v < own ? cell_.vertices[v] : closing_.vertices[v - own]).error);
                visit(e, error);
            }
    }

    void add(const TrimmedPatch& trimmed) {
        const RationalPatch& surface = trimmed.surface;
        std::vector<std::vector<Row>> loops;
        Vector2d lo = Vector2d::Constant(std::numeric_limits<double>::infinity()), hi = -lo;
        double size = 0;
        for (const auto& loop : trimmed.loops) {
            loops.emplace_back();
            for (const TrimCurve& trim : loop) {
                if (trim.curve.degree > PowerSpan::largest_degree)
                    throw InternalError("moments_of: a trim's degree is above 5");
                for (Row& piece : pieces(trim.curve)) {
                    for (const Vector4d& p : piece) {
                        const Vector2d uv = p.head<2>() / p[3];
                        lo = lo.cwiseMin(uv);
                        hi = hi.cwiseMax(uv);
                        size = std::max(size, uv.cwiseAbs().maxCoeff());
                    }
                    loops.back().push_back(std::move(piece));
                }
            }
        }
        // Control points may lie far beyond the domain, the curves do not.
        lo = lo.cwiseMax(Vector2d(surface.domain_u[0], surface.domain_v[0]));
        hi = hi.cwiseMin(Vector2d(surface.domain_u[1], surface.domain_v[1]));
        const Vector2d middle = 0.5 * (lo + hi), half = 0.5 * (hi - lo);
        if (!(half.minCoeff() > 0)) return;  // no wider than a rounding
        FluxAlong flux(surface, middle, half, frame_);
        flux.set_place(size / half.minCoeff());
        for (const auto& loop : loops) add_loop(flux, loop, middle, half);
    }

    void add_loop(const FluxAlong& flux, const std::vector<Row>& loop, const Vector2d& middle,
                  const Vector2d& half) {
        std::vector<std::vector<Vector4d>> spans;
        for (const Row& piece : loop) {
            auto& span = spans.emplace_back();
            for (const Vector4d& p : piece) {
                const Vector2d uv = (p.head<2>() / p[3] - middle).cwiseQuotient(half);
                span.emplace_back(uv[0], uv[1], 0, p[3]);
            }
        }
        for (std::size_t k = 0; k < spans.size(); ++k) {
            std::array<Integral, terms> along{};
            const PowerSpan span(spans[k]);
            int budget = most_halvings;
            span_integrals::integrate(span, flux, along, 40, budget);
            for (std::size_t i = 0; i < terms; ++i) sums_[i].add(along[i].value, along[i].error);
            // A loop's curves meet but for rounding: what lies beside the gap between two is not integrated.
            const Vector4d &end = spans[k].back(), &next = spans[(k + 1) % spans.size()].front();
            const SpanPoint<double> gap{
                end[0], end[1], 0, std::abs(next[0] - end[0]), std::abs(next[1] - end[1]), 0};
            const std::array<double, terms> missing = flux.sizes(gap);
            for (std::size_t i = 0; i < terms; ++i) sums_[i].add(0, missing[i]);
        }
    }

    /// On either side a strip of twice the edge's length and as wide as its trims may be off, and the discs
    /// about its ends.
    void add_strips(const CellEdge& e, double error) {
        double length = 0, far = 0;
        for (std::size_t k = 0; k < e.curve.points.size(); ++k) {
            const Vec3 p = e.curve.points[k].head<3>();
            if (k > 0) length += (p - e.curve.points[k - 1].head<3>()).norm();
            far = std::max(far, frame_(p).norm());
        }
        const double off = error / frame_.unit;
        far += off;
        const double strips = 2 * 2 * (length / frame_.unit + 2 * off) * off;
        for (std::size_t i = 0; i < terms; ++i) {
            const double power = i == 0 ? far : i < 4 ? far * far : far * far * far;
            sums_[i].add(0, strips * power / divisor(i));
        }
    }

    /// About the frame's origin first. Of M the covariances V C = M_ij - M_i M_j / V.
    Moments result() const {
        double volume = sums_[0].value(), of_volume = sums_[0].bound();
        const double unit = frame_.unit, cube = unit * unit * unit;
        const Measures& m = cell_.measures;
        if (m.volume_error / cube < of_volume && !m.is_estimated) {
            volume = m.volume / cube;
            of_volume = m.volume_error / cube;
        }
        Moments result;
        const double least = volume - of_volume;
        if (!(least > 0)) {  // nothing is known
            result.centroid = bounds_.center();
            result.centroid_error = bounds_.diagonal().norm();
            result.second.setZero();
            result.second_error = cube * unit * unit * (volume + of_volume) * 4;
            return result;
        }
        Vec3 first, first_error;
        for (int c = 0; c < 3; ++c) {
            first[c] = sums_[static_cast<std::size_t>(1 + c)].value() / volume;
            first_error[c] = sums_[static_cast<std::size_t>(1 + c)].bound();
        }
        const double away = first.norm(), of_first = first_error.norm() + away * of_volume;
        constexpr double rounding = 16 * unit_roundoff;
        result.centroid = frame_.origin + unit * first;
        result.centroid_error =
            unit * (of_first / least) + rounding * (result.centroid.norm() + frame_.origin.norm());
        double error = 0;
        for (std::size_t k = 0; k < pairs.size(); ++k) {
            const auto [i, j] = pairs[k];
            const double value = sums_[4 + k].value(), shift = volume * first[i] * first[j];
            result.second(i, j) = result.second(j, i) = cube * unit * unit * (value - shift);
            error = std::max(error, sums_[4 + k].bound() + 2 * away * first_error.norm() * (volume / least) +
                                        away * away * of_volume * (volume / least) +
                                        first_error.squaredNorm() / least +
                                        rounding * (std::abs(value) + std::abs(shift)));
        }
        result.second_error = cube * unit * unit * error;
        return result;
    }

    const Cell& cell_;
    const Closing made_;
    const Closing& closing_;
    Eigen::AlignedBox3d bounds_;
    Frame frame_{Vec3::Zero(), 1};
    std::array<BoundedSum, terms> sums_;
};

}  // namespace

Moments moments_of(const Cell& cell) { return Summer(cell).moments(); }

}  // namespace vcell
