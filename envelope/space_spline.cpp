#include "space_spline.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "../core/interval.hpp"
#include "bernstein.hpp"

namespace vcell {

namespace {

using Eigen::Matrix4d;
using Eigen::Vector4d;
using std::numbers::pi;
using std::numbers::sqrt2;

using Linear = PatchCoordinate::Linear;
using Piece = MinimizationDiagram::ArcPiece;
using Points = Eigen::Matrix<double, 8, 6>;  // as in SpaceSpan

constexpr double u = std::numeric_limits<double>::epsilon() / 2;
constexpr double infinity = std::numeric_limits<double>::infinity();

// Rounding of a residual or gradient, in units of u times the magnitudes that enter it: some thirty
// operations, and coefficients within a few u.
constexpr double rounding = 64 * u;

double square(double a) { return a * a; }

Bernstein<5> row(const Points& points, int i) {
    return Bernstein<5>::from([&](int k) { return points(i, k); });
}

template <class T>
T dot(const Vec3& a, const std::array<T, 3>& b) {
    return a.x() * b[0] + a.y() * b[1] + a.z() * b[2];
}

// G(X) and its derivatives, of a round object (the base too) or of something plane.
class Equation {
public:
    // `near`: as for cylinders in cylinder_patch.hpp.
    static Equation round(const Vec3& point, const Vec3& axis, double rho, double base_radius,
                          const Vec3& near) {
        Equation e;
        e.is_round_ = true;
        e.delta_ = rho - base_radius;
        e.point_ = point;
        e.reach_ = point.norm() + rho + base_radius;
        if (axis != Vec3::Zero()) {
            e.axis_ = axis.normalized();
            e.point_ += e.axis_.dot(near - point) * e.axis_;
            e.reach_ += (near - point).norm() + e.point_.norm();
        }
        return e;
    }
    // The distance along `gradient` (unit) from a point, plus R0 - t unless a wall.
    static Equation plane(const Vec3& point, const Vec3& gradient, double base_radius, bool is_wall) {
        Equation e;
        e.point_ = point;
        e.axis_ = gradient;
        e.kappa_ = is_wall ? 0 : 1;
        e.delta_ = -e.kappa_ * base_radius;
        e.reach_ = point.norm() + base_radius;
        return e;
    }

    double operator()(const Vector4d& X) const {
        const Vec3 m = X.head<3>() - point_;
        return (is_round_ ? across(m).norm() : axis_.dot(m)) - (kappa_ * X[3] + delta_);
    }
    // The lengths that enter G at X.
    double size(const Vector4d& X) const { return X.head<3>().norm() + std::abs(X[3]) + reach_; }

    // (g, -kappa)
    Vector4d gradient(const Vector4d& X) const {
        Vector4d result;
        result << (is_round_ ? across(X.head<3>() - point_).normalized() : axis_), -kappa_;
        return result;
    }
    // How far the gradient may be from its computed value at X, within a radius.
    double variation(const Vector4d& X, double radius) const {
        if (!is_round_) return rounding;
        const double d = across(X.head<3>() - point_).norm(), s = radius / d;
        if (!(s < 1)) return infinity;
        return sqrt2 * s / std::sqrt(1 + std::sqrt(1 - s * s)) + rounding * (1 + size(X) / d);
    }
    // Of |Hess G| within a radius of X, less than what makes variation() infinite.
    double curvature_bound(const Vector4d& X, double radius) const {
        return is_round_ ? 1 / (across(X.head<3>() - point_).norm() - radius) : 0;
    }
    // The second derivative in the direction T.
    double second(const Vector4d& X, const Vector4d& T) const {
        if (!is_round_) return 0;
        const Vec3 m = across(X.head<3>() - point_), v = across(T.head<3>());
        const double d = m.norm();
        return (v.squaredNorm() - square(m.dot(v) / d)) / d;
    }

    // Bound of |G|.
    double residual(const Vector4d& X) const { return std::abs((*this)(X)) + rounding * size(X); }
    // Step 1 of the certificate: |G| along a span; infinite if it cannot tell.
    double residual(const Points& points) const {
        const Bernstein<5> x = row(points, 0) - point_.x(), y = row(points, 1) - point_.y(),
                           z = row(points, 2) - point_.z(), t = kappa_ * row(points, 3) + delta_;
        const Bernstein<5> along = axis_.x() * x + axis_.y() * y + axis_.z() * z;
        const double m = x.largest() + y.largest() + z.largest(), largest_t = t.largest();
        if (!is_round_) return (along - t).largest() + rounding * (m + largest_t + reach_);
        const double size = (m + largest_t) * (m + largest_t + reach_);
        const double Q = (x * x + y * y + z * z - along * along - t * t).largest() + rounding * size;
        // d^2 = t^2 + Q
        const double least = t.smallest_coefficient(), below = least * least - Q;
        return least > 0 && below > 0 ? Q / (least + std::sqrt(below)) : infinity;
    }

    // t where the ray from f = (0, y, 0) along the unit normal w meets G = 0, by the quadratic of
    // core/radial_form.hpp; whatever it yields where the ray does not.
    template <class T>
    T distance_along(const T& y, const std::array<T, 3>& w) const {
        using std::sqrt;
        std::array<T, 3> m{T(-point_.x()), y - T(point_.y()), T(-point_.z())};
        if (!is_round_) return (dot(axis_, m) - T(delta_)) / (T(kappa_) - dot(axis_, w));
        const T along = dot(axis_, m), alpha = dot(axis_, w), delta(delta_);
        const T mw = m[0] * w[0] + m[1] * w[1] + m[2] * w[2];
        const T C = square_of(m[0]) + square_of(m[1]) + square_of(m[2]) - square_of(along) - square_of(delta);
        const T beta = along * alpha + delta - mw;
        return C / (beta + sqrt(square_of(beta) + square_of(alpha) * C));
    }

private:
    template <class T>
    static T square_of(const T& a) {
        return a * a;
    }
    Vec3 across(const Vec3& m) const { return m - axis_.dot(m) * axis_; }

    bool is_round_ = false;
    double kappa_ = 1;
    double delta_ = 0;
    double reach_ = 0;
    Vec3 point_ = Vec3::Zero(), axis_ = Vec3::Zero();  // plane: axis_ is g
};

// `foot`: near the curve, on the base's axis.
Equation equation(const RadialBaseProblem& problem, const SpaceSite& site, const Vec3& foot) {
    const double R0 = problem.radius;
    if (const Sphere* s = std::get_if<Sphere>(&site.object))
        return Equation::round(s->center, Vec3::Zero(), s->radius, R0, foot);
    if (const Cylinder* c = std::get_if<Cylinder>(&site.object))
        return Equation::round(c->point, c->axis, c->radius, R0, foot);
    const Plane& plane = std::get<Plane>(site.object);
    const Vec3 n = plane.normal.normalized();
    const bool inward = !site.is_wall && n.dot(foot - plane.point) > 0;
    return Equation::plane(plane.point, inward ? n : Vec3(-n), R0, site.is_wall);
}

Equation base_equation(const RadialBaseProblem& problem, const Vec3& foot) {
    const Vec3 axis = problem.is_sphere ? Vec3::Zero().eval() : Vec3::UnitY().eval();
    return Equation::round(Vec3::Zero(), axis, problem.radius, problem.radius, foot);
}

Vector4d with_distance(const RadialBaseProblem& problem, const Vec3& p) {
    Vector4d X;
    X << p, problem.is_sphere ? p.norm() : std::hypot(p.x(), p.z());
    return X;
}

// Step 2: the distance of a solution from a point with residuals e, as far as the ball allows.
struct Solver {
    Matrix4d inverse;
    std::array<double, 4> columns;
    double q;

    // `variations`: of the rows.
    Solver(const Matrix4d& M, const std::array<double, 4>& variations) : inverse(M.inverse()) {
        q = (Matrix4d::Identity() - inverse * M).norm();
        for (int i = 0; i < 4; ++i) {
            columns[i] = inverse.col(i).norm();
            q += columns[i] * (variations[i] + rounding);
        }
    }
    bool is_regular() const { return q < 1; }
    double distance(const std::array<double, 4>& e) const {
        double sum = 0;
        for (int i = 0; i < 4; ++i) sum += columns[i] * e[i];
        return sum / (1 - q);
    }
};

// Of RadialBaseProblem::normal() over a box; back: the second half of the cylinder.
std::array<Interval, 3> normals(const RadialBaseProblem& problem, const Interval& x, const Interval& y,
                                bool back) {
    const Interval a = back ? x - Interval(2) : x;
    const Interval squares = problem.is_sphere ? square(a) + square(y) : square(a), W = 1 + squares;
    const std::array<Interval, 3> n{2 * a / W, problem.is_sphere ? 2 * y / W : Interval(0),
                                    (1 - squares) / W};
    std::array<Interval, 3> u;
    for (int i = 0; i < 3; ++i) {
        const Interval sum = dot<Interval>(problem.chart.row(i), n);
        u[i] = Interval::ball(0, rounding) + (back ? -sum : sum);
    }
    return u;
}

// What the certificate finds.
struct Tube {
    double curve = 0, trims = 0;  // errors
    double start = 0, end = 0;    // distances of the ends from the curve
    double link = 0;              // points of the curve so close to an end are on the same arc
    double q = 0;                 // the largest of step 2

    bool is_proved() const { return curve < infinity && trims < infinity; }
    // Will the next span join, if it is about as good?
    bool is_joint() const { return 4 * end <= link; }
    static Tube failed(double q = 0) { return {infinity, infinity, infinity, infinity, 0, q}; }
};

bool joins(const Tube& a, const Tube& b) { return a.end <= b.link || b.start <= a.link; }

class Fitter {
public:
    Fitter(const RadialBaseProblem& problem, const SpaceArc& arc, double tolerance,
           std::vector<SpaceSpan>& spans)
        : problem_(problem), arc_(arc), tolerance_(tolerance), spans_(spans) {
        const Plane* rim = arc.pieces.empty() ? &std::get<Plane>(arc.sites[1].object) : nullptr;
        const double y = problem.is_sphere ? 0
                         : arc.start       ? arc.start->point.y()
                         : rim             ? rim->point.y()
                                           : arc.pieces.back().end.y();
        const Vec3 foot(0, y, 0);
        equations_[0] = base_equation(problem, foot);
        for (int i = 0; i < 2; ++i) equations_[i + 1] = equation(problem, arc.sites[i], foot);
    }

    SpaceFitError run() {
        const double start_error = arc_.start ? sqrt2 * arc_.start->error : 0;
        const double end_error = arc_.end ? sqrt2 * arc_.end->error : 0;
        slack_ = std::max(start_error, end_error);
        // No edge is known better than its ends.
        tolerance_ = std::max(tolerance_, 4 * slack_);
        const bool on_rim = arc_.pieces.empty();
        if (on_rim)
            place_rim_nodes();
        else
            place_nodes();
        last_ = Tube{0, 0, 0, start_error, 0};
        const bool is_loop = !arc_.end || arc_.end->point == arc_.start->point;
        nodes_.front().is_terminal = is_loop;
        nodes_.back().is_terminal = true;
        terminal_ = nodes_.back().X;
        if (arc_.end) final_ = Tube{0, 0, end_error, 0, 0};
        if (!arc_.start && !on_rim) last_->end = start_deviation();
        fit(0, nodes_.size() - 1);
        return error_;
    }

private:
    // Between two nodes given: what a singular end needs, and what no proof in reach may cost.
    static constexpr int deepest = 40, most_halvings = 256;
    static constexpr int deepest_proof = 4;  // halvings of a span for its certificate

    // A point of the arc with derivatives along it, per length of p.
    struct Node {
        Vector4d X, T, second;
        bool is_terminal = false;  // the end of the edge
    };
    using Patches = std::array<const PatchCoordinates*, 2>;

    struct Fit {
        Points points = Points::Zero();
        Tube tube = Tube::failed();
        bool is_chord = false;
        std::array<std::uint32_t, 2> part{};
        Patches patches{};           // of those parts
        std::optional<Linear> seam;  // crossed

        double error() const { return std::max(tube.curve, tube.trims); }
    };
    struct Frame {
        std::array<Vector4d, 3> gradients;
        Vector4d T;  // null vector in the edge's direction; |T| = 1

        Matrix4d matrix() const {
            Matrix4d M;
            M << gradients[0].transpose(), gradients[1].transpose(), gradients[2].transpose(), T.transpose();
            return M;
        }
    };

    Frame frame(const Vector4d& X) const {
        Frame f;
        for (int i = 0; i < 3; ++i) f.gradients[i] = equations_[i].gradient(X);
        const Vec3 g = f.gradients[0].head<3>();
        const auto relative = [&](const Vector4d& a) -> Vec3 { return a.head<3>() + a[3] * g; };
        const Vec3 p = relative(f.gradients[1]).cross(relative(f.gradients[2]));
        f.T << p, g.dot(p);
        f.T.normalize();
        return f;
    }

    Node node(const Vector4d& X) const {
        const Frame f = frame(X);
        const Vector4d T = f.T / f.T.head<3>().norm();
        Vector4d bend = Vector4d::Zero();
        for (int i = 0; i < 3; ++i) bend[i] = -equations_[i].second(X, T);
        return {X, T, f.matrix().inverse() * bend};
    }

    // Newton's method across the curve (or for its point where `seam` vanishes), to the level of rounding.
    std::optional<Node> find(Vector4d X, const Linear* seam = nullptr) const {
        constexpr int enough = 12;
        for (int i = 0; i < enough; ++i) {
            Vector4d G = Vector4d::Zero();
            double size = 0;
            for (int k = 0; k < 3; ++k) {
                G[k] = equations_[k](X);
                size = std::max(size, equations_[k].size(X));
            }
            Matrix4d M = frame(X).matrix();
            if (seam) {
                M.row(3) = seam->head<4>().normalized();
                G[3] = at(*seam, X) / seam->head<4>().norm();
            }
            const Matrix4d inverse = M.inverse();
            const Vector4d step = inverse * G;
            X -= step;
            if (step.norm() <= 16 * u * size * (1 + inverse.leftCols<3>().norm())) return node(X);
        }
        return std::nullopt;
    }

    // The point over a chart point, by the heights of both sides.
    Vector4d lifted(const Vec2& q) const { return over(problem_.is_sphere ? 0 : q.y(), problem_.normal(q)); }
    Vector4d over(double y, const Vec3& w) const {
        const std::array<double, 3> direction{w.x(), w.y(), w.z()};
        double t = equations_[1].distance_along(y, direction);
        if (!arc_.pieces.empty()) t = 0.5 * (t + equations_[2].distance_along(y, direction));
        Vector4d X;
        X << t * w + Vec3(0, y, 0), t;
        return X;
    }

    Node inner_node(const Piece& piece) const {
        const Vector4d X = lifted(piece.end);
        const auto found = find(X);
        return found ? *found : node(X);
    }

    void place_nodes() {
        nodes_.push_back(arc_.start ? node(with_distance(problem_, arc_.start->point))
                                    : inner_node(arc_.pieces.back()));
        for (const Piece& piece : arc_.pieces.first(arc_.pieces.size() - 1))
            nodes_.push_back(inner_node(piece));
        nodes_.push_back(arc_.end ? node(with_distance(problem_, arc_.end->point)) : nodes_.front());
    }

    // Around a cylinder: with growing angle on the lower end, the region lying on the left.
    void place_rim_nodes() {
        constexpr double widest = pi / 3;
        const Plane& end = std::get<Plane>(arc_.sites[1].object);
        const double sign = end.normal.y() < 0 ? 1 : -1, y = end.point.y();
        const auto angle = [](const SpaceEnd& e) { return std::atan2(e.point.x(), e.point.z()); };
        const double first = arc_.start ? angle(*arc_.start) : 0;
        double turn = 2 * pi;
        if (arc_.end && arc_.end->point != arc_.start->point) {
            turn = std::fmod(sign * (angle(*arc_.end) - first), 2 * pi);
            if (turn < 0) turn += 2 * pi;
        }
        const int n = std::max(1, static_cast<int>(std::ceil(turn / widest)));
        for (int i = 0; i <= n; ++i) {
            const double a = first + sign * turn * i / n;
            if (i == 0 && arc_.start)
                nodes_.push_back(node(with_distance(problem_, arc_.start->point)));
            else if (i == n)
                nodes_.push_back(arc_.end ? node(with_distance(problem_, arc_.end->point)) : nodes_.front());
            else
                nodes_.push_back(node(over(y, Vec3(std::sin(a), 0, std::cos(a)))));
        }
    }

    // Encloses the points (p, t) over a piece of the arc: corners of a box.
    std::array<Vector4d, 2> enclosure(const std::array<double, 4>& box) const {
        const Interval x(box[0], box[1]), y(box[2], box[3]);
        const auto part = [&](const Interval& range, bool back) {
            const auto w = normals(problem_, range, y, back);
            const Interval f = problem_.is_sphere ? Interval(0) : y;
            const Interval a = equations_[1].distance_along(f, w), b = equations_[2].distance_along(f, w);
            const double low = std::max({a.lower(), b.lower(), 0.0}), high = std::min(a.upper(), b.upper());
            const Interval t(std::min(low, high), std::max(low, high));
            const std::array<Interval, 4> X{t * w[0], t * w[1] + f, t * w[2], t};
            std::array<Vector4d, 2> corners;
            for (int i = 0; i < 4; ++i) {
                corners[0][i] = X[i].lower();
                corners[1][i] = X[i].upper();
            }
            return corners;
        };
        if (problem_.is_sphere || box[1] <= 1) return part(x, false);
        if (box[0] >= 1) return part(x, true);
        const auto front = part({box[0], 1}, false), back = part({1, box[1]}, true);
        return {front[0].cwiseMin(back[0]), front[1].cwiseMax(back[1])};
    }

    // How far the first node of a closed edge may be from a point of the edge.
    double start_deviation() const {
        const Piece& piece = arc_.pieces.back();
        const double e = piece.error;
        const auto box =
            enclosure({piece.end.x() - e, piece.end.x() + e, piece.end.y() - e, piece.end.y() + e});
        const Vector4d& X = nodes_.front().X;
        return (X - box[0]).cwiseAbs().cwiseMax((X - box[1]).cwiseAbs()).norm();
    }

    void fit(std::size_t first, std::size_t last) {
        const Node &from = nodes_[first], &to = nodes_[last];
        if (last == first + 1) {
            int halvings = most_halvings;
            return fit(from, to, first < arc_.pieces.size() ? &arc_.pieces[first] : nullptr, deepest,
                       halvings);
        }
        if (accept(smooth(from, to), from, to)) return;
        const std::size_t half = first + (last - first) / 2;
        fit(first, half);
        fit(half, last);
    }

    void fit(const Node& from, const Node& to, const Piece* piece, int deeper, int& halvings) {
        const Fit spline = smooth(from, to);
        if (accept(spline, from, to)) return;
        const Fit straight = chord(from, to, piece);
        if (accept(straight, from, to)) return;
        const bool is_lost = std::isinf(error_.curve) || std::isinf(error_.trims);
        if (deeper > 0 && halvings > 0 && !is_lost) {
            if (const auto middle = half_way(from, to, piece, spline)) {
                --halvings;
                fit(from, *middle, piece, deeper - 1, halvings);
                fit(*middle, to, piece, deeper - 1, halvings);
                return;
            }
        }
        append(spline.error() < straight.error() ? spline : straight);
    }

    bool accept(Fit fit, const Node& from, const Node& to) {
        if (!(fit.error() <= tolerance_)) return false;
        if (!fit.is_chord) {
            if (last_ && !joins(*last_, fit.tube)) return false;
            if (&to != &nodes_.back() && !fit.tube.is_joint()) return false;
            if (&to == &nodes_.back()) {
                const std::optional<Tube>& next = final_ ? final_ : first_;
                if (next && !joins(fit.tube, *next)) return false;
            }
            if (&from == &nodes_.front()) first_ = fit.tube;
        }
        append(fit);
        return true;
    }
    void append(const Fit& fit) {
        error_.curve = std::max(error_.curve, fit.tube.curve);
        error_.trims = std::max(error_.trims, fit.tube.trims);
        if (fit.is_chord)
            last_.reset();
        else
            last_ = fit.tube;
        spans_.push_back({fit.points, fit.part});
    }

    std::optional<Node> half_way(const Node& from, const Node& to, const Piece* piece,
                                 const Fit& spline) const {
        if (spline.seam)
            if (const auto crossing = sign_change(spline.points, *spline.seam))
                if (const auto found = find(*crossing, &*spline.seam); found && is_between(from, *found, to))
                    return found;
        if (spline.seam || spline.tube.is_proved())
            if (const auto found = find(middle(spline.points)); found && is_between(from, *found, to))
                return found;
        if (!piece) {
            Vec3 w = from.X.head<3>() / from.X[3] + to.X.head<3>() / to.X[3];
            w.y() = 0;
            return node(over(from.X.y(), w.normalized()));
        }
        const auto on_line =
            meet(0.5 * (chart_point(from, *piece) + chart_point(to, *piece)), piece->direction);
        return find(on_line ? lifted(*on_line) : Vector4d(0.5 * (from.X + to.X)));
    }

    // Of spans whose chord goes with the arc.
    static bool is_between(const Node& from, const Node& n, const Node& to) {
        const Vec3 chord = (to.X - from.X).head<3>();
        const double along = chord.dot((n.X - from.X).head<3>());
        return along > 0 && along < chord.squaredNorm();
    }

    // Where a linear function vanishes on a span, if it is seen to change its sign.
    std::optional<Vector4d> sign_change(const Points& points, const Linear& f) const {
        constexpr int parts = 8, halvings = 20;  // find() does the rest
        const double near = seam_width(points, f);
        for (int i = 0; i < parts; ++i) {
            double low = static_cast<double>(i) / parts, high = static_cast<double>(i + 1) / parts;
            const double a = at(f, point(points, low)), b = at(f, point(points, high));
            if (!(std::min(a, b) < -near && std::max(a, b) > near)) continue;
            for (int k = 0; k < halvings; ++k) {
                const double half = 0.5 * (low + high);
                ((at(f, point(points, half)) > 0) == (a > 0) ? low : high) = half;
            }
            return point(points, low);
        }
        return std::nullopt;
    }

    // In the chart, as continued to the piece.
    Vec2 chart_point(const Node& n, const Piece& piece) const {
        const Vec3 foot(0, problem_.is_sphere ? 0 : n.X.y(), 0);
        Vec2 q = problem_.chart_point((n.X.head<3>() - foot) / n.X[3], n.X.y());
        if (problem_.is_sphere) return q;
        const double middle = 0.5 * (piece.box[0] + piece.box[1]);
        if (q.x() - middle > 2) q.x() -= 4;
        if (middle - q.x() > 2) q.x() += 4;
        return q;
    }

    // Newton's method for equal heights, along a line of the chart.
    std::optional<Vec2> meet(Vec2 q, const Vec2& direction) const {
        constexpr int enough = 20;
        constexpr double near = 1e-4;  // find() does the rest
        for (int i = 0; i < enough; ++i) {
            const Vec3 w = problem_.normal(q), turning = normal_derivative(q, direction);
            const std::array<double, 3> normal{w.x(), w.y(), w.z()};
            const double y = problem_.is_sphere ? 0 : q.y(), dy = problem_.is_sphere ? 0 : direction.y();
            std::array<double, 2> t, slope;
            for (int k = 0; k < 2; ++k) {
                const Equation& G = equations_[k + 1];
                t[k] = G.distance_along(y, normal);
                Vector4d X;
                X << t[k] * w + Vec3(0, y, 0), t[k];
                // 0 = dG = (g.w - kappa) dt + g.(t dw + dy e_y)
                const Vector4d g = G.gradient(X);
                slope[k] = g.head<3>().dot(t[k] * turning + Vec3(0, dy, 0)) / (-g[3] - g.head<3>().dot(w));
            }
            const double step = (t[0] - t[1]) / (slope[0] - slope[1]);
            if (!std::isfinite(step)) return std::nullopt;
            q -= step * direction;
            if (std::abs(t[0] - t[1]) <= near * (t[0] + t[1])) return q;
        }
        return std::nullopt;
    }
    Vec3 normal_derivative(const Vec2& q, const Vec2& d) const {
        if (!problem_.is_sphere) {
            const bool back = q.x() > 1;
            const double a = back ? q.x() - 2 : q.x(), W = 1 + a * a;
            return (back ? -2 : 2) * d.x() / (W * W) * (problem_.chart * Vec3(1 - a * a, 0, -2 * a));
        }
        const double W = 1 + q.squaredNorm(), dW = 2 * q.dot(d);
        const Vec3 n(2 * q.x(), 2 * q.y(), 1 - q.squaredNorm());
        return problem_.chart * (Vec3(2 * d.x(), 2 * d.y(), -dW) / W - n * (dW / (W * W)));
    }

    // Value, first and second derivative in the span's parameter.
    using Jet = Eigen::Matrix<double, 4, 3>;

    static Eigen::RowVector3d jet(const PatchCoordinate& c, const Jet& X) {
        const Vector4d n = c.numerator.head<4>(), d = c.divisor.head<4>();
        const double value = c(X.col(0)), divisor = d.dot(X.col(0)) + c.divisor[4];
        const double first = (n - value * d).dot(X.col(1)) / divisor;
        return {value, first, ((n - value * d).dot(X.col(2)) - 2 * first * d.dot(X.col(1))) / divisor};
    }

    // The quintic with the given ends.
    template <class T>
    static auto quintic(const T& a, const T& b) {
        Eigen::Matrix<double, T::RowsAtCompileTime, 6> p;
        p << a.col(0), a.col(0) + a.col(1) / 5, a.col(0) + 2 * a.col(1) / 5 + a.col(2) / 20,
            b.col(0) - 2 * b.col(1) / 5 + b.col(2) / 20, b.col(0) - b.col(1) / 5, b.col(0);
        return p;
    }
    static Vector4d point(const Points& p, double s) {
        Eigen::Matrix<double, 4, 6> q = p.topRows<4>();
        for (int n = 5; n > 0; --n)
            for (int k = 0; k < n; ++k) q.col(k) += s * (q.col(k + 1) - q.col(k));
        return q.col(0);
    }
    static Vector4d middle(const Points& p) { return point(p, 0.5); }

    // Chooses the parts and puts the trims below the curve; not if it leaves a part.
    void trim(const std::array<Jet, 2>& ends, Fit& fit) const {
        const Vector4d X = middle(fit.points);
        for (int side = 0; side < 2; ++side) {
            const std::vector<SpacePart>& parts = arc_.sites[side].parts;
            if (parts.empty()) continue;
            const auto outside = [&](const SpacePart& part) {
                const PatchCoordinate& c = part.patch[0];
                if (!(at(c.divisor, X) > 0)) return infinity;
                return std::max(part.u[0] - c(X), c(X) - part.u[1]);
            };
            const auto best = std::ranges::min_element(parts, {}, outside);
            fit.part[side] = static_cast<std::uint32_t>(best - parts.begin());
            fit.patches[side] = &best->patch;
            fit.seam = crossed_seam(*best, fit.points);
            if (fit.seam) return;
            for (int i = 0; i < 2; ++i)
                fit.points.row(4 + 2 * side + i) =
                    quintic(jet(best->patch[i], ends[0]), jet(best->patch[i], ends[1]));
        }
    }
    // The linear function of X that vanishes where u is at an end of its range, if the span crosses that.
    std::optional<Linear> crossed_seam(const SpacePart& part, const Points& points) const {
        for (int k = 0; k < 2; ++k) {
            if (!std::isfinite(part.u[k])) continue;
            const Linear f = part.patch[0].numerator - part.u[k] * part.patch[0].divisor;
            const auto values = (f.head<4>().transpose() * points.topRows<4>()).array() + f[4];
            const double outermost = k == 0 ? values.minCoeff() : -values.maxCoeff();
            if (outermost < -seam_width(points, f)) return f;
        }
        return std::nullopt;
    }
    // Ends so near to a seam count as on it: spans that are cut off closer to a node could not be proved.
    double seam_width(const Points& points, const Linear& f) const {
        return std::min(0x1p-32 * magnitude(points, f), 0.25 * tolerance_);
    }
    static double at(const Linear& f, const Vector4d& X) { return f.head<4>().dot(X) + f[4]; }

    // With the coordinate x along the chord and s = e.T:
    //     dX/dx = T / s,   d^2X/dx^2 = (X'' - (e.X'') T / s) / s^2.
    Fit smooth(const Node& from, const Node& to) const {
        constexpr double flattest = 0.45;
        Fit fit;
        const Vec3 chord = to.X.head<3>() - from.X.head<3>();
        const double length = chord.norm();
        if (!(length > 0)) return fit;
        std::array<Jet, 2> ends;
        for (int i = 0; i < 2; ++i) {
            const Node& n = i == 0 ? from : to;
            const Vec3 e = chord / length;
            const double s = e.dot(n.T.head<3>());
            if (!(s >= flattest)) return fit;
            ends[i] << n.X, length / s * n.T,
                square(length / s) * (n.second - e.dot(n.second.head<3>()) / s * n.T);
        }
        fit.points.topRows<4>() = quintic(ends[0], ends[1]);
        // What is far off is not worth a certificate.
        constexpr double hopeless = 16;
        for (const Equation& G : equations_)
            if (!(G.residual(fit.points) <= hopeless * tolerance_)) return fit;
        trim(ends, fit);
        if (fit.seam) return fit;
        fit.tube = certify(fit.points, fit.patches, from.is_terminal, to.is_terminal, deepest_proof);
        return fit;
    }

    Fit chord(const Node& from, const Node& to, const Piece* piece) const {
        Fit fit;
        fit.is_chord = true;
        if (!piece) return fit;
        const auto box = enclosure(piece->box);
        const Vector4d low = box[0].cwiseMin(from.X).cwiseMin(to.X),
                       high = box[1].cwiseMax(from.X).cwiseMax(to.X);
        std::array<Jet, 2> ends;
        ends[0] << from.X, to.X - from.X, Vector4d::Zero();
        ends[1] << to.X, to.X - from.X, Vector4d::Zero();
        fit.points.topRows<4>() = quintic(ends[0], ends[1]);
        trim(ends, fit);
        fit.tube = Tube{(high - low).norm(), 0, 0, 0, 0, 0};
        add_trims(fit.points, fit.patches, Ball(fit.points, slack_), residuals(fit.points), fit.tube);
        return fit;
    }

    // D around a span, and the room in it beside the span.
    struct Ball {
        Vector4d center;
        double radius, room;

        Ball(const Points& points, double slack) {
            const Vector4d low = points.topRows<4>().rowwise().minCoeff(),
                           high = points.topRows<4>().rowwise().maxCoeff();
            center = 0.5 * (low + high);
            const double half = 0.5 * (high - low).norm();
            room = 0.25 * half + 16 * slack + rounding * center.norm();
            radius = half + room;
        }
    };

    Tube certify(const Points& points, const Patches& patches, bool from_terminal, bool to_terminal,
                 int halvings) const {
        const Tube whole = tube(points, patches, from_terminal, to_terminal);
        // q falls like the ball's radius, if it is finite.
        const bool hopeless = std::isfinite(whole.q) && whole.q > std::ldexp(1, halvings);
        if (whole.is_proved() || halvings == 0 || hopeless) return whole;
        // De Casteljau at 1/2.
        Points first, second, work = points;
        for (int k = 0; k <= 5; ++k) {
            first.col(k) = work.col(0);
            second.col(5 - k) = work.col(5 - k);
            for (int i = 0; i < 5 - k; ++i) work.col(i) = 0.5 * (work.col(i) + work.col(i + 1));
        }
        const Tube a = certify(first, patches, from_terminal, false, halvings - 1);
        if (!a.is_proved()) return Tube::failed();
        const Tube b = certify(second, patches, false, to_terminal, halvings - 1);
        if (!b.is_proved() || !joins(a, b)) return Tube::failed();
        return {std::max(a.curve, b.curve),
                std::max(a.trims, b.trims),
                a.start,
                b.end,
                std::min(a.link, b.link),
                0};
    }

    // Steps 1 to 5 in one ball.
    Tube tube(const Points& points, const Patches& patches, bool from_terminal, bool to_terminal) const {
        const Ball ball(points, slack_);
        const Frame f = frame(ball.center);
        std::array<double, 4> variations{};
        for (int i = 0; i < 3; ++i) variations[i] = equations_[i].variation(ball.center, ball.radius);
        const Solver solver(f.matrix(), variations);
        if (!solver.is_regular()) return Tube::failed(solver.q);
        for (int k = 0; k < 5; ++k)
            if (!(f.T.dot(points.col(k + 1).head<4>() - points.col(k).head<4>()) > 0)) return Tube::failed();
        const auto e = residuals(points);
        const double distance = solver.distance({e[0], e[1], e[2], 0});
        if (!(distance <= ball.room)) return Tube::failed();
        const Vector4d start = points.col(0).head<4>(), end = points.col(5).head<4>();
        const double slack = slack_ + rounding * ball.center.norm();
        const bool holds_end = (ball.center - terminal_).norm() <= ball.radius + slack &&
                               f.T.dot(terminal_ - start) >= -slack && f.T.dot(terminal_ - end) <= slack;
        if (holds_end && !from_terminal && !to_terminal) return Tube::failed();
        // The slice through an end's point meets the curve next to it; the edge may end that much earlier.
        const double beyond = solver.distance({0, 0, 0, slack_});
        Tube tube{
            distance + beyond, 0, solver.distance(residuals_at(start)), solver.distance(residuals_at(end)), 0,
            solver.q};
        // Step 4: a third of the room each for a, the value at the end and the curvature.
        if (std::max(tube.start, tube.end) <= ball.room / 3) {
            std::array<double, 4> curvatures{};
            for (int i = 0; i < 3; ++i)
                curvatures[i] = equations_[i].curvature_bound(ball.center, ball.radius) / 8;
            tube.link = std::min(ball.room / 3, std::sqrt(ball.room / 3 / solver.distance(curvatures)));
        }
        add_trims(points, patches, ball, e, tube);
        return tube;
    }

    // Step 1, for all three equations.
    std::array<double, 3> residuals(const Points& points) const {
        return {equations_[0].residual(points), equations_[1].residual(points),
                equations_[2].residual(points)};
    }
    std::array<double, 4> residuals_at(const Vector4d& X) const {
        std::array<double, 4> e{};
        for (int i = 0; i < 3; ++i) e[i] = equations_[i].residual(X);
        return e;
    }

    // Step 5; `residuals` as above.
    void add_trims(const Points& points, const Patches& patches, const Ball& ball,
                   const std::array<double, 3>& residuals, Tube& tube) const {
        for (int side = 0; side < 2; ++side)
            if (patches[side])
                tube.trims =
                    std::max(tube.trims, trim_error(side, points, *patches[side], ball, residuals, tube.q));
    }
    double trim_error(int side, const Points& points, const PatchCoordinates& coordinates, const Ball& ball,
                      const std::array<double, 3>& residuals, double& largest_q) const {
        const std::array<int, 2> surface{0, side + 1};
        Matrix4d M;
        std::array<double, 4> variations, e;
        std::array<double, 2> scale;
        for (int i = 0; i < 2; ++i) {
            const Equation& G = equations_[surface[i]];
            M.row(i) = G.gradient(ball.center);
            variations[i] = G.variation(ball.center, ball.radius);
            e[i] = residuals[surface[i]];
            const PatchCoordinate& c = coordinates[i];
            const auto value = points.row(4 + 2 * side + i);
            const double low = value.minCoeff(), high = value.maxCoeff(), middle = 0.5 * (low + high);
            const Vector4d n = c.numerator.head<4>(), d = c.divisor.head<4>(), gradient = n - middle * d;
            scale[i] = gradient.norm();
            M.row(2 + i) = gradient / scale[i];
            variations[2 + i] = 0.5 * (high - low) * d.norm() / scale[i];
        }
        const Solver solver(M, variations);
        largest_q = std::max(largest_q, solver.q);
        if (!solver.is_regular()) return infinity;
        for (int i = 0; i < 2; ++i) {
            const PatchCoordinate& c = coordinates[i];
            const Bernstein<5> v = row(points, 4 + 2 * side + i), divisor = linear(points, c.divisor);
            const double divisor_size = magnitude(points, c.divisor);
            if (!(divisor.smallest_coefficient() >
                  ball.room * c.divisor.head<4>().norm() + rounding * divisor_size))
                return infinity;
            const double size = magnitude(points, c.numerator) + divisor_size * v.largest();
            e[2 + i] = ((raised<10>(linear(points, c.numerator)) - v * divisor).largest() + rounding * size) /
                       scale[i];
        }
        const double distance = solver.distance(e);
        return distance <= ball.room ? distance : infinity;
    }
    static Bernstein<5> linear(const Points& points, const Linear& f) {
        return f[0] * row(points, 0) + f[1] * row(points, 1) + f[2] * row(points, 2) + f[3] * row(points, 3) +
               f[4];
    }
    static double magnitude(const Points& points, const Linear& f) {
        return f.head<4>().cwiseAbs().dot(points.topRows<4>().cwiseAbs().rowwise().maxCoeff()) +
               std::abs(f[4]);
    }

    const RadialBaseProblem& problem_;
    const SpaceArc& arc_;
    double tolerance_;
    std::vector<SpaceSpan>& spans_;
    std::array<Equation, 3> equations_;  // base, left, right
    std::vector<Node> nodes_;            // the ends of the pieces
    Vector4d terminal_;                  // where the edge ends
    double slack_ = 0;                   // of the vertices
    std::optional<Tube> last_;           // the span before, the start at first; none: vouched for by a piece
    std::optional<Tube> first_, final_;  // the first span; the end
    SpaceFitError error_;
};

}  // namespace

PatchCoordinate PatchCoordinate::linear(const Vec3& direction, const Vec3& origin) {
    PatchCoordinate c;
    c.numerator << direction, 0, -direction.dot(origin);
    return c;
}

PatchCoordinate PatchCoordinate::half_angle(const Vec3& point, const Vec3& zero, const Vec3& quarter,
                                            double delta) {
    PatchCoordinate c;
    c.numerator << quarter, 0, -quarter.dot(point);
    c.divisor << zero, 1, delta - zero.dot(point);
    return c;
}

// Within D, the ball of twice the bound, the solution is unique by step 2, and the point is one.
std::optional<SpaceEnd> settle_point(const RadialBaseProblem& problem, const std::array<SpaceSite, 3>& sites,
                                     const SpaceEnd& near) {
    const Vec3 foot(0, problem.is_sphere ? 0 : near.point.y(), 0);
    const std::array equations{base_equation(problem, foot), equation(problem, sites[0], foot),
                               equation(problem, sites[1], foot), equation(problem, sites[2], foot)};
    const Vector4d center = with_distance(problem, near.point);
    const double radius = 2 * sqrt2 * near.error;
    Matrix4d M;
    std::array<double, 4> variations, e;
    for (int i = 0; i < 4; ++i) {
        M.row(i) = equations[i].gradient(center);
        variations[i] = equations[i].variation(center, radius);
    }
    const Solver solver(M, variations);
    if (!solver.is_regular()) return std::nullopt;
    Vector4d X = center;
    constexpr int steps = 3;  // of q each
    for (int k = 0; k < steps; ++k) {
        Vector4d G;
        for (int i = 0; i < 4; ++i) G[i] = equations[i](X);
        X -= solver.inverse * G;
    }
    for (int i = 0; i < 4; ++i) e[i] = equations[i].residual(X);
    const double error = solver.distance(e);
    if (!(error < near.error && (X - center).norm() + error <= radius)) return std::nullopt;
    return SpaceEnd{X.head<3>(), error};
}

SpaceFitError fit_space_spline(const RadialBaseProblem& problem, const SpaceArc& arc, double tolerance,
                               std::vector<SpaceSpan>& spans) {
    return Fitter(problem, arc, tolerance, spans).run();
}

}  // namespace vcell
