#include "space_spline.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "../../core/curves/quintic_nodes.hpp"
#include "../../core/curves/scaled_bernstein.hpp"
#include "../../core/numbers/interval.hpp"

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

Bernstein<5> row(const Points& points, int i, double origin = 0) {
    return Bernstein<5>::from([&](int k) { return points(i, k) - origin; });
}

template <class T>
T dot(const Vec3& a, const std::array<T, 3>& b) {
    return a.x() * b[0] + a.y() * b[1] + a.z() * b[2];
}

// A span's coordinates (p - foot, t) as polynomials, and |p - foot|^2 - t^2, which all round objects share.
struct SpanPolynomials {
    Vec3 foot;
    std::array<Bernstein<5>, 4> X;
    Bernstein<10> square;
    std::array<double, 4> largest;

    SpanPolynomials(const Points& points, const Vec3& origin)
        : foot(origin),
          X{row(points, 0, foot.x()), row(points, 1, foot.y()), row(points, 2, foot.z()), row(points, 3)},
          square(vcell::square(X[0]) + vcell::square(X[1]) + vcell::square(X[2]) - vcell::square(X[3])) {
        for (int i = 0; i < 4; ++i) largest[i] = X[i].largest();
    }

    // f.(p - foot, t) + c
    Bernstein<5> linear(const Vec3& f, double along_t, double c) const {
        return f.x() * X[0] + f.y() * X[1] + f.z() * X[2] + along_t * X[3] + c;
    }
    Bernstein<5> operator()(const Linear& f) const {
        return linear(f.head<3>(), f[3], f[4] + f.head<3>().dot(foot));
    }
    // Bounds the terms of a linear function.
    double size(const Linear& f) const {
        double sum = std::abs(f[4]) + std::abs(f[3]) * largest[3];
        for (int i = 0; i < 3; ++i) sum += std::abs(f[i]) * (largest[i] + std::abs(foot[i]));
        return sum;
    }
    double size() const { return largest[0] + largest[1] + largest[2] + largest[3]; }
};

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
        e.reach_ = point.norm() + (near - point).norm() + rho + base_radius;
        if (axis != Vec3::Zero()) {
            e.axis_ = axis.normalized();
            e.point_ += e.axis_.dot(near - point) * e.axis_;
            e.reach_ += e.point_.norm();
        }
        return e;
    }
    // One of the planes where two lines that cross in `center` are equally near. blur: bound on what rounding
    // changed about `normal`, and about the center in lengths of what enters G.
    static Equation between(const Vec3& center, const Vec3& normal, double blur) {
        Equation e = plane(center, normal, 0, true);
        e.blur_ = blur;
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
    // How far what is within `room` of the hull of the points is from X, across the axis.
    double reach(const Vector4d& X, const Points& points, double room) const {
        if (!is_round_) return 0;
        double squared = 0;
        for (int k = 0; k < points.cols(); ++k)
            squared = std::max(squared, across(points.col(k).head<3>() - X.head<3>()).squaredNorm());
        return std::sqrt(squared) + room;
    }
    // How far the gradient may be from its computed value at X, within a reach.
    double variation(const Vector4d& X, double reach) const {
        if (!is_round_) return rounding + blur_;
        const double d = across(X.head<3>() - point_).norm(), s = reach / d;
        if (!(s < 1)) return infinity;
        return sqrt2 * s / std::sqrt(1 + std::sqrt(1 - s * s)) + rounding * (1 + size(X) / d);
    }
    // Of |Hess G| within a reach that is less than what makes variation() infinite.
    double curvature_bound(const Vector4d& X, double reach) const {
        return is_round_ ? 1 / (across(X.head<3>() - point_).norm() - reach) : 0;
    }
    // The second derivative in the direction T.
    double second(const Vector4d& X, const Vector4d& T) const {
        if (!is_round_) return 0;
        const Vec3 m = across(X.head<3>() - point_), v = across(T.head<3>());
        const double d = m.norm();
        return (v.squaredNorm() - square(m.dot(v) / d)) / d;
    }

    // Bound of |G|.
    double residual(const Vector4d& X) const { return std::abs((*this)(X)) + (rounding + blur_) * size(X); }
    // Step 1 of the certificate: |G| along a span; infinite if it cannot tell. With m = point - foot
    //     d^2 - (t + delta)^2 = square - 2 m.(p - foot) - 2 delta t + |m|^2 - delta^2  (- (axis.(p -
    //     point))^2).
    double residual(const SpanPolynomials& span) const {
        const Vec3 m = point_ - span.foot;
        const double size = span.size() + reach_, offset = axis_.dot(m);
        if (!is_round_)
            return span.linear(axis_, -kappa_, -(offset + delta_)).largest() +
                   (rounding + blur_) * (size + span.foot.norm());
        Bernstein<10> Q =
            span.square + raised<10>(span.linear(-2 * m, -2 * delta_, m.squaredNorm() - square(delta_)));
        if (axis_ != Vec3::Zero()) Q = Q - square(span.linear(axis_, 0, -offset));
        const double bound = QuinticNodes::get().largest(Q) + rounding * square(size);
        // d^2 = (t + delta)^2 + Q
        const double least = span.X[3].smallest_coefficient() + delta_, below = least * least - bound;
        return least > 0 && below > 0 ? bound / (least + std::sqrt(below)) : infinity;
    }

    // t where the ray from f = (0, y, 0) along the unit normal w meets G = 0, by the quadratic of
    // primitives/forms/radial_form.hpp; whatever it yields where the ray does not.
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
    double blur_ = 0;
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
    double blur = 0;              // of the trims' error, what bounds rounding

    // Parts would be no better where rounding is what counts.
    bool is_within(double tolerance) const {
        return curve <= tolerance && trims <= std::max(tolerance, 4 * blur);
    }
    double error() const { return std::max(curve, trims); }
    bool is_proved() const { return error() < infinity; }
    // Will the next span join, if it is about as good?
    bool is_joint() const { return 4 * end <= link; }
    static Tube failed(double q = 0) { return {infinity, infinity, infinity, infinity, 0, q}; }
};

bool joins(const Tube& a, const Tube& b) { return a.end <= b.link || b.start <= a.link; }

class Fitter {
public:
    Fitter(const RadialBaseProblem& problem, const SpaceArc& arc, double tolerance,
           std::vector<SpaceSpan>& spans, FitEffort& effort)
        : problem_(problem), arc_(arc), tolerance_(tolerance), spans_(spans), effort_(effort) {
        const Plane* rim = arc.pieces.empty() ? &std::get<Plane>(arc.sites[1].object) : nullptr;
        const double y = problem.is_sphere ? 0
                         : arc.start       ? arc.start->point.y()
                         : rim             ? rim->point.y()
                                           : arc.pieces.back().end.y();
        foot_ = Vec3(0, y, 0);
        equations_[0] = base_equation(problem, foot_);
        for (int i = 0; i < 2; ++i) equations_[i + 1] = equation(problem, arc.sites[i], foot_);
        if (arc.sites_cross) take_plane();
    }

    SpaceFitError run() {
        const double start_error = arc_.start ? sqrt2 * arc_.start->error : 0;
        const double end_error = arc_.end ? sqrt2 * arc_.end->error : 0;
        slack_ = std::max(start_error, end_error);
        // No edge is known better than its ends.
        tolerance_ = std::max(tolerance_, 4 * slack_);
        const bool on_rim = arc_.pieces.empty();
        start_ = arc_.start ? node(with_distance(problem_, arc_.start->point))
                 : on_rim   ? rim_node(0)
                            : inner_node(arc_.pieces.back());
        end_ = arc_.end ? node(with_distance(problem_, arc_.end->point)) : start_;
        last_ = Tube{0, 0, 0, start_error, 0};
        start_.is_terminal = !arc_.end || arc_.end->point == arc_.start->point;
        end_.is_terminal = true;
        if (arc_.end) final_ = Tube{0, 0, end_error, 0, 0};
        if (!arc_.start && !on_rim) last_->end = start_deviation();
        if (on_rim) {
            fit_rim();
        } else {
            int halvings = most_halvings * static_cast<int>(arc_.pieces.size());
            fit(start_, end_, arc_.pieces, deepest, halvings);
        }
        return error_;
    }

private:
    // What a singular end needs, and what no proof in reach may cost (per piece).
    static constexpr int deepest = 40, most_halvings = 256;
    static constexpr int most_rim_halvings =
        4096;                                // no pieces get shorter where both sites are nearly as one
    static constexpr int deepest_proof = 4;  // halvings of a span for its certificate

    // A point of the arc with derivatives along it, by the length of the curve (p, t).
    struct Node {
        Vector4d X, T, second;
        bool is_terminal = false;  // the end of the edge
        bool ends_piece = false;   // of the diagram, or all but does
    };
    using Patches = std::array<const SpacePart*, 2>;

    struct Fit {
        Points points = Points::Zero();
        Tube tube = Tube::failed();
        bool is_chord = false;
        std::array<std::uint32_t, 2> part{};
        Patches patches{};           // of those parts
        std::optional<Linear> seam;  // crossed
        double expected = infinity;  // error, but for q; finite if this is near the arc

        double error() const { return tube.error(); }
        bool is_near() const { return expected < infinity; }
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

    // Where cylinders of one radius cross, their equations depend on each other in the points over both axes.
    // An arc lies in one of the planes between the axes, whose equation takes the place of the right one's.
    // Which plane, and on which side of it the right one is nearer, an inner point of the arc tells.
    void take_plane() {
        const auto inner = inner_point();
        if (!inner) return;
        const auto &f = std::get<Cylinder>(arc_.sites[0].object),
                   &g = std::get<Cylinder>(arc_.sites[1].object);
        const Vec3 a = f.axis.normalized(), b = g.axis.normalized(), normal = a.cross(b);
        const Vec3 center = f.point + (g.point - f.point).cross(b).dot(normal) / normal.squaredNorm() * a;
        const std::array<Vec3, 2> sums{a - b, a + b};
        const double least = std::min(sums[0].norm(), sums[1].norm());
        const std::array<Vec3, 2> normals{sums[0].normalized(), sums[1].normalized()};
        const Vec3 p = inner->head<3>() - center;
        const Vec3& n = normals[std::abs(normals[1].dot(p)) < std::abs(normals[0].dot(p))];
        const double side =
            n.dot((equations_[2].gradient(*inner) - equations_[1].gradient(*inner)).head<3>());
        right_ = 3;
        equations_[right_] = equations_[2];
        equations_[2] = Equation::between(center, side > 0 ? n : Vec3(-n), rounding / (least * least));
    }
    // Of those that the pieces tell the one farthest from the ends.
    std::optional<Vector4d> inner_point() const {
        if (!arc_.start || !arc_.end) return std::nullopt;
        const Vector4d from = with_distance(problem_, arc_.start->point),
                       to = with_distance(problem_, arc_.end->point);
        std::optional<Vector4d> best;
        double farthest = 0;
        const auto offer = [&](const Vector4d& X) {
            const double distance = std::min((X - from).norm(), (X - to).norm());
            if (distance > farthest) best = X;
            farthest = std::max(farthest, distance);
        };
        for (const Piece& piece : arc_.pieces.first(arc_.pieces.size() - 1)) offer(lifted(piece.end));
        if (arc_.pieces.size() == 1) {
            const Piece& piece = arc_.pieces.front();
            if (const auto q = meet(0.5 * (chart_point(from, piece) + chart_point(to, piece)), piece))
                offer(lifted(*q));
        }
        return best;
    }

    Node node(const Vector4d& X) const {
        const Frame f = frame(X);
        Vector4d bend = Vector4d::Zero();
        for (int i = 0; i < 3; ++i) bend[i] = -equations_[i].second(X, f.T);
        return {X, f.T, f.matrix().inverse() * bend};
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
        if (!arc_.pieces.empty()) t = 0.5 * (t + equations_[right_].distance_along(y, direction));
        Vector4d X;
        X << t * w + Vec3(0, y, 0), t;
        return X;
    }

    Node inner_node(const Piece& piece) const {
        const Vector4d X = lifted(piece.end);
        const auto found = find(X);
        Node result = found ? *found : node(X);
        result.ends_piece = true;
        return result;
    }

    // Around a cylinder: with growing angle on the lower end, the region lying on the left.
    Node rim_node(double angle) const {
        const double y = std::get<Plane>(arc_.sites[1].object).point.y();
        return node(over(y, Vec3(std::sin(angle), 0, std::cos(angle))));
    }
    void fit_rim() {
        constexpr double widest = pi / 3;
        const double sign = std::get<Plane>(arc_.sites[1].object).normal.y() < 0 ? 1 : -1;
        const auto angle = [](const SpaceEnd& e) { return std::atan2(e.point.x(), e.point.z()); };
        const double first = arc_.start ? angle(*arc_.start) : 0;
        double turn = arc_.turn > 0 ? arc_.turn : 2 * pi;
        if (!(arc_.turn > 0) && arc_.end && arc_.end->point != arc_.start->point) {
            turn = std::fmod(sign * (angle(*arc_.end) - first), 2 * pi);
            if (turn < 0) turn += 2 * pi;
        }
        const int n = std::max(1, static_cast<int>(std::ceil(turn / widest)));
        Node from = start_;
        for (int i = 1; i <= n; ++i) {
            int halvings = most_rim_halvings;
            const Node to = i == n ? end_ : rim_node(first + sign * turn * i / n);
            fit(from, to, {}, deepest, halvings);
            from = to;
        }
    }

    // Calls f(x, y, back) for the halves of the cylinder in which the box {x0, x1, y0, y1} lies, or for all
    // of it.
    template <class F>
    void for_halves(const std::array<double, 4>& box, F&& f) const {
        const Interval y(box[2], box[3]);
        const bool is_whole = problem_.is_sphere || box[1] <= 1;
        if (is_whole || box[0] < 1) f(Interval(box[0], is_whole ? box[1] : 1), y, false);
        if (!is_whole) f(Interval(std::max(box[0], 1.0), box[1]), y, true);
    }
    // t of both sites.
    std::array<Interval, 2> distances(const Interval& y, const std::array<Interval, 3>& normal) const {
        const Interval f = problem_.is_sphere ? Interval(0) : y;
        return {equations_[1].distance_along(f, normal), equations_[right_].distance_along(f, normal)};
    }

    // Encloses the points (p, t) over a part of the arc: corners of a box.
    std::array<Vector4d, 2> enclosure(const std::array<double, 4>& box) const {
        std::array<Vector4d, 2> corners{Vector4d::Constant(infinity), Vector4d::Constant(-infinity)};
        for_halves(box, [&](const Interval& x, const Interval& y, bool back) {
            const auto w = normals(problem_, x, y, back);
            const auto [a, b] = distances(y, w);
            const double low = std::max({a.lower(), b.lower(), 0.0}), high = std::min(a.upper(), b.upper());
            const Interval t(std::min(low, high), std::max(low, high));
            const Interval f = problem_.is_sphere ? Interval(0) : y;
            const std::array<Interval, 4> X{t * w[0], t * w[1] + f, t * w[2], t};
            for (int i = 0; i < 4; ++i) {
                corners[0][i] = std::min(corners[0][i], X[i].lower());
                corners[1][i] = std::max(corners[1][i], X[i].upper());
            }
        });
        return corners;
    }

    // Encloses (p, t) over the lesser arc of a rim between two nodes: a rim has no pieces to enclose.
    std::array<Vector4d, 2> rim_enclosure(const Node& from, const Node& to) const {
        const double y = std::get<Plane>(arc_.sites[1].object).point.y();
        const Vec3 v = from.X.head<3>() / from.X[3], w = to.X.head<3>() / to.X[3];
        // Where the ends may be, and how far the circle is from its chord.
        const double room = sqrt2 * slack_ / std::min(from.X[3], to.X[3]) + rounding + (v - w).squaredNorm();
        const auto over = [&](int i) {
            return Interval(std::min(v[i], w[i]), std::max(v[i], w[i])) + Interval::ball(0, room);
        };
        const std::array<Interval, 3> normal{over(0), Interval(0), over(2)};
        const Interval t = equations_[1].distance_along(Interval(y), normal);
        const std::array<Interval, 4> X{t * normal[0], Interval(y), t * normal[2], t};
        std::array<Vector4d, 2> corners;
        for (int i = 0; i < 4; ++i) {
            corners[0][i] = X[i].lower();
            corners[1][i] = X[i].upper();
        }
        return corners;
    }

    // Are the distances of both sites certainly different all over the box?
    bool is_off_arc(const std::array<double, 4>& box) const {
        bool is_off = true;
        for_halves(box, [&](const Interval& x, const Interval& y, bool back) {
            const auto [a, b] = distances(y, normals(problem_, x, y, back));
            is_off = is_off && (a.upper() < b.lower() || b.upper() < a.lower());
        });
        return is_off;
    }

    // Encloses the part of a piece between two nodes, in the chart: lines in the piece's direction bound a
    // strip, and from both ends of the strip what is certainly off the arc is cut off.
    std::array<double, 4> box_between(const Node& from, const Node& to, const Piece& piece) const {
        const Vec2 &d = piece.direction, n(-d.y(), d.x());
        const std::array ends{chart_point(from.X, piece), chart_point(to.X, piece)};
        double left = infinity, right = -infinity;
        const auto hold = [&](const Vec2& q, double error) {
            left = std::min(left, n.dot(q) - error);
            right = std::max(right, n.dot(q) + error);
        };
        for (const int k : {0, 1}) {
            const Node& node = k == 0 ? from : to;
            const Vec2& q = ends[k];
            hold(q, (slack_ / std::min(node.X[3], 1.0) + rounding) * (1 + q.squaredNorm()));
            if (!node.ends_piece) continue;
            // The true end of the piece is near the node.
            const bool opens_edge = &piece == &arc_.pieces.front();
            const Piece& before = opens_edge ? arc_.pieces.back() : *(&piece - 1);
            const Vec2 first = continued(before.end, piece);
            const bool is_first = !(opens_edge && arc_.start) && (first - q).norm() < (piece.end - q).norm();
            hold(is_first ? first : piece.end, is_first ? before.error : piece.error);
        }
        const auto part = [&](double a, double b) {
            const Interval s(left, right), t(std::min(a, b), std::max(a, b));
            const Interval x = s * n.x() + t * d.x(), y = s * n.y() + t * d.y();
            return std::array{std::max(piece.box[0], x.lower()), std::min(piece.box[1], x.upper()),
                              std::max(piece.box[2], y.lower()), std::min(piece.box[3], y.upper())};
        };
        // From where on, between a and b, there may be an arc.
        int cells = 0;
        const auto cut = [&](const auto& self, double a, double b) -> double {
            constexpr int most_cells = 1000;
            if (effort_.cells > 0) --effort_.cells;
            const double middle = 0.5 * (a + b);
            if (const auto box = part(a, b); box[0] > box[1] || box[2] > box[3] || is_off_arc(box)) return b;
            if (++cells > most_cells || effort_.cells == 0 || !(std::abs(b - a) > right - left) ||
                middle == a || middle == b)
                return a;
            const double first = self(self, a, middle);
            return first == middle ? self(self, middle, b) : first;
        };
        const double center = 0.5 * d.dot(ends[0] + ends[1]);
        double reach = 0;
        for (const double x : {piece.box[0], piece.box[1]})
            for (const double y : {piece.box[2], piece.box[3]})
                reach = std::max(reach, std::abs(d.dot(Vec2(x, y)) - center));
        const double low = cut(cut, center - reach, center);
        cells = 0;
        const double high = cut(cut, center + reach, center);
        return low < high ? part(low, high) : piece.box;
    }

    // How far the first node of a closed edge may be from a point of the edge.
    double start_deviation() const {
        const Piece& piece = arc_.pieces.back();
        const double e = piece.error;
        const auto box =
            enclosure({piece.end.x() - e, piece.end.x() + e, piece.end.y() - e, piece.end.y() + e});
        const Vector4d& X = start_.X;
        return (X - box[0]).cwiseAbs().cwiseMax((X - box[1]).cwiseAbs()).norm();
    }

    // Along these pieces, or the rim. A span that is not good enough is divided; several pieces of which
    // nothing is proved yet where one of them ends.
    // `before`: the trims' error of the span that this one is a part of.
    void fit(const Node& from, const Node& to, std::span<const Piece> pieces, int deeper, int& halvings,
             double before = infinity) {
        if (effort_.spans > 0) --effort_.spans;
        const Fit spline = smooth(from, to, tolerance_);
        // What division does not make smaller is rounding, of the scene, too.
        constexpr double no_less = 0.8, most_blurred = 16;
        const double error = spline.tube.trims;
        const bool is_floor =
            before < infinity && error > no_less * before && error <= most_blurred * tolerance_;
        if (accept(spline, to, is_floor)) return;
        const double length = (to.X - from.X).norm();
        const bool is_short = length <= tolerance_, divides = deeper > 0 && halvings > 0 && !is_lost();
        // Parts of what rounding blurs are no better than it, and their ends cannot be told from the edge's.
        const bool is_all = from.X == start_.X && to.X == end_.X;
        const bool is_chord = is_short && divides && (is_all || is_blurred(from, length));
        if (spline.is_near() && !spline.seam && divides && !is_chord) {
            const std::vector<Node> inner = divide(from, to, spline);
            for (std::size_t i = 0; i < inner.size(); ++i) {
                const Node &start = i == 0 ? from : inner[i - 1], &end = inner[i];
                const std::size_t first = ends_before(end.X, to.X - from.X, pieces);
                --halvings;
                fit(start, end, pieces.first(std::min(first + 1, pieces.size())), deeper - 1, halvings,
                    error);
                pieces = pieces.subspan(first);
            }
            if (!inner.empty()) return fit(inner.back(), to, pieces, deeper - 1, halvings, error);
        }
        if (pieces.size() > 1) {
            const std::size_t half = pieces.size() / 2;
            const Node end = inner_node(pieces[half - 1]);
            fit(from, end, pieces.first(half), deeper, halvings);
            fit(end, to, pieces.subspan(half), deeper, halvings);
            return;
        }
        const Piece* piece = pieces.empty() ? nullptr : &pieces.front();
        // Both ends are in the enclosure that vouches for a chord.
        if (is_short && accept(chord(from, to, piece), to)) return;
        if (divides) {
            const auto middle = half_way(from, to, piece, spline);
            if (middle && !(is_short && is_blurred(*middle, length))) {
                --halvings;
                fit(from, *middle, pieces, deeper - 1, halvings, error);
                fit(*middle, to, pieces, deeper - 1, halvings, error);
                return;
            }
        }
        const Fit best = smooth(from, to, infinity), straight = chord(from, to, piece);
        const bool is_straight = (piece || straight.tube.is_proved()) && !(best.error() < straight.error());
        append(is_straight ? straight : best);
    }

    // Does rounding blur the arc so much that no span of this length, or a shorter one, can be proved?
    bool is_blurred(const Node& n, double length) const {
        const Solver solver(frame(n.X).matrix(), {});
        std::array<double, 4> e{};
        for (int i = 0; i < 3; ++i) e[i] = rounding * equations_[i].size(n.X);
        return !(solver.is_regular() && 64 * solver.distance(e) <= length);
    }
    bool is_lost() const {
        return std::isinf(error_.curve) || std::isinf(error_.trims) || effort_.spans == 0;
    }

    // Points of the arc between parts that will do, as errors fall with the sixth power of the length.
    std::vector<Node> divide(const Node& from, const Node& to, const Fit& spline) const {
        constexpr double most_parts = 4, reserve = 1.5;
        const int parts = static_cast<int>(std::clamp(
            std::ceil(std::pow(reserve * spline.expected / tolerance_, 1.0 / 6)), 2.0, most_parts));
        std::vector<Node> inner;
        const Node* last = &from;
        for (int k = 1; k < parts; ++k) {
            const auto found = find(point(spline.points, static_cast<double>(k) / parts));
            if (!found || !is_between(*last, *found, to)) return {};
            inner.push_back(*found);
            last = &inner.back();
        }
        return inner;
    }

    // How many of the pieces end before a point as seen along the chord, all but the last one at most.
    std::size_t ends_before(const Vector4d& X, const Vector4d& chord, std::span<const Piece> pieces) const {
        const auto is_before = [&](const Piece& p) { return chord.dot(lifted(p.end) - X) < 0; };
        std::size_t n = 0;
        while (n + 1 < pieces.size() && is_before(pieces[n])) ++n;
        return n;
    }

    bool accept(const Fit& fit, const Node& to, bool is_floor = false) {
        if (!fit.tube.is_within(tolerance_) && !(is_floor && fit.tube.curve <= tolerance_)) return false;
        if (!fit.is_chord) {
            if (last_ && !joins(*last_, fit.tube)) return false;
            const bool is_end = to.X == end_.X && to.is_terminal;
            if (!is_end && !fit.tube.is_joint()) return false;
            if (is_end) {
                const std::optional<Tube>& next = final_ ? final_ : first_;
                if (next && !joins(fit.tube, *next)) return false;
            }
            if (spans_.size() == first_span_) first_ = fit.tube;
        }
        append(fit);
        return true;
    }
    void append(const Fit& fit) {
        if (!fit.tube.is_proved() && !error_.unproved) error_.unproved = point(fit.points, 0.5).head<3>();
        if (fit.tube.error() > std::max(error_.curve, error_.trims))
            error_.worst = point(fit.points, 0.5).head<3>();
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
        if (spline.seam)
            if (const auto found = find(middle(spline.points)); found && is_between(from, *found, to))
                return found;
        if (!piece) {
            Vec3 w = from.X.head<3>() / from.X[3] + to.X.head<3>() / to.X[3];
            w.y() = 0;
            return node(over(from.X.y(), w.normalized()));
        }
        const auto on_line = meet(0.5 * (chart_point(from.X, *piece) + chart_point(to.X, *piece)), *piece);
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
    Vec2 chart_point(const Vector4d& X, const Piece& piece) const {
        const Vec3 foot(0, problem_.is_sphere ? 0 : X.y(), 0);
        return continued(problem_.chart_point((X.head<3>() - foot) / X[3], X.y()), piece);
    }
    Vec2 continued(Vec2 q, const Piece& piece) const {
        if (problem_.is_sphere) return q;
        const double middle = 0.5 * (piece.box[0] + piece.box[1]);
        if (q.x() - middle > 2) q.x() -= 4;
        if (middle - q.x() > 2) q.x() += 4;
        return q;
    }

    // Equal heights along a line of the chart in the piece's direction, as one of them falls against the
    // other there.
    std::optional<Vec2> meet(const Vec2& q, const Piece& piece) const {
        const auto found = approach(q, piece.direction);
        return found && holds(piece.box, *found) ? found : bisect(q, piece);
    }
    static bool holds(const std::array<double, 4>& box, const Vec2& q) {
        return q.x() >= box[0] && q.x() <= box[1] && q.y() >= box[2] && q.y() <= box[3];
    }
    // Between the sides of the piece's box: the line may meet the two again beyond them.
    std::optional<Vec2> bisect(const Vec2& q, const Piece& piece) const {
        constexpr int halvings = 60;
        const Vec2& d = piece.direction;
        double low = -infinity, high = infinity;
        for (const int i : {0, 1}) {
            const double a = (piece.box[2 * i] - q[i]) / d[i], b = (piece.box[2 * i + 1] - q[i]) / d[i];
            if (d[i] == 0) continue;
            low = std::max(low, std::min(a, b));
            high = std::min(high, std::max(a, b));
        }
        const auto is_left_nearer = [&](double s) {
            const Vec2 p = q + s * d;
            const Vec3 w = problem_.normal(p);
            const std::array<double, 3> normal{w.x(), w.y(), w.z()};
            const double y = problem_.is_sphere ? 0 : p.y();
            // Negative or infinite distances are those of rays that do not get there.
            return 1 / equations_[1].distance_along(y, normal) >
                   1 / equations_[right_].distance_along(y, normal);
        };
        if (!(low < high) || !is_left_nearer(low) || is_left_nearer(high)) return std::nullopt;
        for (int i = 0; i < halvings; ++i) {
            const double middle = 0.5 * (low + high);
            (is_left_nearer(middle) ? low : high) = middle;
        }
        return q + low * d;
    }
    // Newton's method, as near as find() needs it.
    std::optional<Vec2> approach(Vec2 q, const Vec2& direction) const {
        constexpr int enough = 20;
        constexpr double near = 1e-4;  // find() does the rest
        for (int i = 0; i < enough; ++i) {
            const Vec3 w = problem_.normal(q), turning = normal_derivative(q, direction);
            const std::array<double, 3> normal{w.x(), w.y(), w.z()};
            const double y = problem_.is_sphere ? 0 : q.y(), dy = problem_.is_sphere ? 0 : direction.y();
            std::array<double, 2> t, slope;
            for (int k = 0; k < 2; ++k) {
                const Equation& G = equations_[k == 0 ? 1 : right_];
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

    // The quintic with the given ends.
    static Eigen::Matrix<double, 4, 6> quintic(const Jet& a, const Jet& b) {
        Eigen::Matrix<double, 4, 6> p;
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
    void trim(Fit& fit) const {
        const Vector4d X = middle(fit.points);
        const QuinticNodes& nodes = QuinticNodes::get();
        const Eigen::Matrix<double, 4, 6> at_nodes = fit.points.topRows<4>() * nodes.values;
        for (int side = 0; side < 2; ++side) {
            const std::vector<SpacePart>& parts = arc_.sites[side].parts;
            if (parts.empty()) continue;
            const bool rises = (fit.points(1, 0) < fit.points(1, 5)) == (side == 0);
            const auto outside = [&](const SpacePart& part) {
                const PatchCoordinate& c = part.patch[0];
                if (!(at(c.divisor, X) > 0)) return infinity;
                const double u = c(X) + (rises ? -seam_inwards : seam_inwards);
                return std::max(part.u[0] - u, u - part.u[1]);
            };
            auto best = std::ranges::min_element(parts, {}, outside);
            fit.seam = crossed_seam(*best, fit.points);
            if (fit.seam && outside(*best) > -2 * seam_inwards) {
                // Just beside a seam the part may not be the one that the span leaves the seam for.
                const auto holds = [&](const SpacePart& part) {
                    return outside(part) <= 2 * seam_inwards && !crossed_seam(part, fit.points);
                };
                if (const auto other = std::ranges::find_if(parts, holds); other != parts.end()) {
                    best = other;
                    fit.seam.reset();
                }
            }
            fit.part[side] = static_cast<std::uint32_t>(best - parts.begin());
            fit.patches[side] = &*best;
            if (fit.seam) return;
            // The sum of a needle's distances that is its first coordinate cancels.
            const bool is_needle = best->surface && best->surface->kind() == RadialPatch::Kind::Confocal;
            Eigen::Matrix<double, 2, 6> at;
            for (int k = 0; k < 6; ++k)
                at.col(k) = is_needle
                                ? best->surface->parameters(Vec3(at_nodes.col(k).head<3>()))
                                : Vec2(best->patch[0](at_nodes.col(k)), best->patch[1](at_nodes.col(k)));
            auto rows = fit.points.middleRows<2>(4 + 2 * side);
            rows = at * nodes.coefficients;
            rows.col(0) = at.col(0);
            rows.col(5) = at.col(5);
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
    static double magnitude(const Points& points, const Linear& f) {
        return f.head<4>().cwiseAbs().dot(points.topRows<4>().cwiseAbs().rowwise().maxCoeff()) +
               std::abs(f[4]);
    }
    static double at(const Linear& f, const Vector4d& X) { return f.head<4>().dot(X) + f[4]; }

    // At constant speed: with X' = length T and X'' = length^2 K at both ends, K the curvature vector, a
    // quintic has
    //     X'(1/2) = 15/8 (X1 - X0) - 7/16 (X0' + X1') + 1/32 (X1'' - X0''),
    // and the speed there is to be `length`, too: that determines it to the order of the quintic's own error.
    static double length_between(const Node& from, const Node& to) {
        const Vector4d chord = to.X - from.X, T = from.T + to.T, K = to.second - from.second;
        double length = chord.norm();
        constexpr int steps = 3;  // of Newton's method
        for (int i = 0; i < steps; ++i) {
            const Vector4d velocity = 1.875 * chord - 0.4375 * length * T + square(length) / 32 * K;
            const double speed = velocity.norm();
            const double slope = velocity.dot(length / 16 * K - 0.4375 * T) / speed - 1;
            length -= (speed - length) / slope;
        }
        return length;
    }

    // Takes a span from Hermite's data at the ends to the arc at the inner nodes, by a step of Newton's
    // method each, or two where residuals are not small. Not if they are larger than `most`.
    bool interpolate(Points& points, double most, double small) const {
        constexpr int most_steps = 2;
        const QuinticNodes& nodes = QuinticNodes::get();
        Eigen::Matrix<double, 4, 6> at_nodes = points.topRows<4>() * nodes.values;
        double largest = infinity;
        for (int step = 0; step < most_steps && largest > small; ++step) {
            std::array<Vector4d, 6> G;
            largest = 0;
            for (int k = 1; k < 5; ++k) {
                G[k] = Vector4d::Zero();
                for (int i = 0; i < 3; ++i) G[k][i] = equations_[i](at_nodes.col(k));
                largest = std::max(largest, G[k].cwiseAbs().maxCoeff());
            }
            if (!(largest <= most)) return false;
            for (int k = 1; k < 5; ++k) at_nodes.col(k) -= frame(at_nodes.col(k)).matrix().inverse() * G[k];
        }
        points.block<4, 4>(0, 1) = at_nodes * nodes.coefficients.middleCols<4>(1);
        return true;
    }

    // Certified if it may err by no more than `most`: in the certificate each |B_i| is 1 / sqrt(2) at least.
    // Others that come near the arc tell where to divide it, and by their residuals into how many parts.
    Fit smooth(const Node& from, const Node& to, double most) const {
        constexpr double flattest = 0.45;
        Fit fit;
        const Vec3 chord = to.X.head<3>() - from.X.head<3>();
        for (const Node& n : {from, to})
            if (!(chord.dot(n.T.head<3>()) > flattest * chord.norm() * n.T.head<3>().norm())) return fit;
        const double length = length_between(from, to);
        if (!(length > 0)) return fit;
        std::array<Jet, 2> ends;
        ends[0] << from.X, length * from.T, square(length) * from.second;
        ends[1] << to.X, length * to.T, square(length) * to.second;
        fit.points.topRows<4>() = quintic(ends[0], ends[1]);
        constexpr double near = 4096, small = 32, least_share = 0.7;
        if (!interpolate(fit.points, near * most, small * most)) return fit;
        const SpanPolynomials span(fit.points, foot_);
        Residuals residuals = curve_residuals(span);
        const double largest = std::ranges::max(residuals.curve);
        constexpr double usual_share = 6;  // of errors, of trims mostly, but for q
        fit.expected = usual_share * largest;
        if (!(least_share * largest <= most)) return fit;
        trim(fit);
        if (fit.seam) return fit;
        add_trims(fit, span, residuals);
        fit.tube = certify(fit.points, fit.patches, residuals, most, from.is_terminal, to.is_terminal,
                           deepest_proof);
        if (fit.tube.is_proved())
            fit.expected = fit.error() * (1 - fit.tube.q);  // parts have a smaller q
        else if (fit.tube.curve == infinity)
            fit.expected = infinity;
        return fit;
    }

    Fit chord(const Node& from, const Node& to, const Piece* piece) const {
        Fit fit;
        fit.is_chord = true;
        auto box = piece ? enclosure(piece->box) : rim_enclosure(from, to);
        // Elsewhere the diagram is not needed, and not relied on.
        const double length = (to.X - from.X).norm();
        const bool is_all = from.X == start_.X && to.X == end_.X;
        if (!piece) {
            // Whole edges only: parts may end where the edge does, as far as is known.
            if (!is_all) return fit;
        } else if (is_all || is_blurred(from, length) || is_blurred(to, length)) {
            const auto tight = enclosure(box_between(from, to, *piece));
            // As in step 4, nothing but the last span reaches the edge's end.
            const bool holds_end =
                (end_.X - tight[0]).minCoeff() >= -slack_ && (tight[1] - end_.X).minCoeff() >= -slack_;
            if (!holds_end || from.is_terminal || to.is_terminal) box = tight;
        }
        const Vector4d low = box[0].cwiseMin(from.X).cwiseMin(to.X),
                       high = box[1].cwiseMax(from.X).cwiseMax(to.X);
        std::array<Jet, 2> ends;
        ends[0] << from.X, to.X - from.X, Vector4d::Zero();
        ends[1] << to.X, to.X - from.X, Vector4d::Zero();
        fit.points.topRows<4>() = quintic(ends[0], ends[1]);
        trim(fit);
        fit.tube = Tube{(high - low).norm(), 0, 0, 0, 0, 0};
        const SpanPolynomials span(fit.points, foot_);
        Residuals residuals = curve_residuals(span);
        add_trims(fit, span, residuals);
        // The trims of a very short edge err by more than its own room: by what rounding makes it, times the
        // condition.
        constexpr double wider = 16;
        for (Neighbourhood D(fit.points, slack_, tolerance_);; D.widen(wider)) {
            fit.tube.trims = trims_error(fit.points, fit.patches, D, frame(D.center), range(fit.points, D),
                                         residuals, fit.tube);
            if (std::isfinite(fit.tube.trims) || !is_all || !(wider * D.room <= tolerance_)) return fit;
        }
    }

    // D: what is within `room` of the hull of a span's points, and so within `radius` of its middle.
    struct Neighbourhood {
        Vector4d center;
        double radius, room;

        // The room is what a bound of the distance may come to before it is too much; q grows with it.
        Neighbourhood(const Points& points, double slack, double tolerance) {
            const auto X = points.topRows<4>();
            center = 0.5 * (X.rowwise().minCoeff() + X.rowwise().maxCoeff());
            const double half = std::sqrt((X.colwise() - center).colwise().squaredNorm().maxCoeff());
            room = std::min(0.25 * half, std::max(4 * tolerance, 0.03 * half)) + 16 * slack +
                   rounding * center.norm();
            radius = half + room;
        }
        void widen(double factor) {
            radius += (factor - 1) * room;
            room *= factor;
        }
    };

    // Step 1: of the three equations, and of the trims in those of step 5, n - u d, with the divisors' least
    // values.
    struct Residuals {
        std::array<double, 3> curve;
        double right;  // of the right site's equation, where a plane's is in its place
        struct Trim {
            std::array<double, 2> residual, divisor;
        };
        std::array<Trim, 2> trims;
    };

    // In parts where one D does not prove it, or not an error of `most` though quarters should: q falls like
    // the size of D, if it is finite, and with it 1 / (1 - q).
    Tube certify(const Points& points, const Patches& patches, const Residuals& residuals, double most,
                 bool from_terminal, bool to_terminal, int halvings) const {
        const Tube whole = tube(points, patches, residuals, from_terminal, to_terminal);
        const double error = whole.error();
        const bool hopeless =
            whole.is_proved() ? whole.is_within(most) || error * (1 - whole.q) > most * (1 - 0.25 * whole.q)
                              : std::isfinite(whole.q) && whole.q > std::ldexp(1, halvings);
        if (halvings == 0 || hopeless) return whole;
        // De Casteljau at 1/2.
        Points first, second, work = points;
        for (int k = 0; k <= 5; ++k) {
            first.col(k) = work.col(0);
            second.col(5 - k) = work.col(5 - k);
            for (int i = 0; i < 5 - k; ++i) work.col(i) = 0.5 * (work.col(i) + work.col(i + 1));
        }
        const Tube a = certify(first, patches, residuals, most, from_terminal, false, halvings - 1);
        if (!a.is_proved() || !a.is_within(most)) return whole;
        const Tube b = certify(second, patches, residuals, most, false, to_terminal, halvings - 1);
        if (!b.is_proved() || !joins(a, b)) return whole;
        return {
            std::max(a.curve, b.curve), std::max(a.trims, b.trims), a.start, b.end, std::min(a.link, b.link),
            std::max(a.q, b.q),         std::max(a.blur, b.blur)};
    }

    // Steps 2 to 5 in one D.
    Tube tube(const Points& points, const Patches& patches, const Residuals& residuals, bool from_terminal,
              bool to_terminal) const {
        const Neighbourhood D(points, slack_, tolerance_);
        const Frame f = frame(D.center);
        const Range r = range(points, D);
        const Solver solver(f.matrix(), r.variations);
        if (!solver.is_regular()) return Tube::failed(solver.q);
        for (int k = 0; k < 5; ++k)
            if (!(f.T.dot(points.col(k + 1).head<4>() - points.col(k).head<4>()) > 0)) return Tube::failed();
        const auto& e = residuals.curve;
        const double distance = solver.distance({e[0], e[1], e[2], 0});
        if (!(distance <= D.room)) return Tube::failed();
        const Vector4d start = points.col(0).head<4>(), end = points.col(5).head<4>();
        const double slack = slack_ + rounding * D.center.norm();
        const bool holds_end = (D.center - end_.X).norm() <= D.radius + slack &&
                               f.T.dot(end_.X - start) >= -slack && f.T.dot(end_.X - end) <= slack;
        if (holds_end && !from_terminal && !to_terminal) return Tube::failed();
        // The slice through an end's point meets the curve next to it; the edge may end that much earlier.
        const double beyond = solver.distance({0, 0, 0, slack_});
        Tube tube{
            distance + beyond, 0, solver.distance(residuals_at(start)), solver.distance(residuals_at(end)), 0,
            solver.q};
        // Step 4: a third of the room each for a, the value at the end and the curvature.
        if (std::max(tube.start, tube.end) <= D.room / 3) {
            std::array<double, 4> curvatures{};
            for (int i = 0; i < 3; ++i)
                curvatures[i] = equations_[i].curvature_bound(D.center, r.reach[i]) / 8;
            tube.link = std::min(D.room / 3, std::sqrt(D.room / 3 / solver.distance(curvatures)));
        }
        tube.trims = trims_error(points, patches, D, f, r, residuals, tube);
        return tube;
    }

    // Of the three equations over D.
    struct Range {
        std::array<double, 3> reach;
        std::array<double, 4> variations{};
    };
    Range range(const Points& points, const Neighbourhood& D) const {
        Range r;
        for (int i = 0; i < 3; ++i) {
            r.reach[i] = equations_[i].reach(D.center, points, D.room);
            r.variations[i] = equations_[i].variation(D.center, r.reach[i]);
        }
        return r;
    }
    Residuals curve_residuals(const SpanPolynomials& span) const {
        return {{equations_[0].residual(span), equations_[1].residual(span), equations_[2].residual(span)},
                right_ > 2 ? equations_[right_].residual(span) : 0,
                {}};
    }
    std::array<double, 4> residuals_at(const Vector4d& X) const {
        std::array<double, 4> e{};
        for (int i = 0; i < 3; ++i) e[i] = equations_[i].residual(X);
        return e;
    }

    static void add_trims(const Fit& fit, const SpanPolynomials& span, Residuals& residuals) {
        for (int side = 0; side < 2; ++side) {
            if (!fit.patches[side]) continue;
            for (int i = 0; i < 2; ++i) {
                const PatchCoordinate& c = fit.patches[side]->patch[i];
                const Bernstein<5> v = row(fit.points, 4 + 2 * side + i), numerator = span(c.numerator);
                const double divisor_size = span.size(c.divisor);
                double residual = 0, least = 0;
                if (c.divisor.head<4>().isZero()) {
                    residual = (numerator - c.divisor[4] * v).largest();
                    least = c.divisor[4];
                } else {
                    const Bernstein<5> divisor = span(c.divisor);
                    residual = QuinticNodes::get().largest(raised<10>(numerator) - v * divisor);
                    least = divisor.smallest_coefficient();
                }
                residuals.trims[side].residual[i] =
                    residual + rounding * (span.size(c.numerator) + divisor_size * v.largest());
                residuals.trims[side].divisor[i] = least - rounding * divisor_size;
            }
        }
    }

    // Step 5. Adds to q and blur.
    double trims_error(const Points& points, const Patches& patches, const Neighbourhood& D,
                       const Frame& frame, const Range& over, const Residuals& residuals, Tube& tube) const {
        double most = 0;
        for (int side = 0; side < 2 && most < infinity; ++side) {
            if (!patches[side]) continue;
            double error = trim_error(side, points, patches[side]->patch, D, frame, over, residuals, tube.q);
            if (tube.curve <= tolerance_ && !(error <= tolerance_) && patches[side]->surface)
                error = std::min(error, distance_on(*patches[side]->surface, points, side, tube.blur));
            most = std::max(most, error);
        }
        return most;
    }
    // Bounds the distance of the patch's points at the trim from the curve's; `largest_blur` grows to
    // rounding's part.
    static double distance_on(const RadialPatch& patch, const Points& points, int side,
                              double& largest_blur) {
        const Bernstein<5> u = row(points, 4 + 2 * side), v = row(points, 5 + 2 * side);
        const Bernstein<10> uu = square(u), vv = square(v);
        const double largest_u = u.largest(), largest_v = v.largest();
        const auto polynomial = [&](int k) {
            const auto in_v = [&](int i) {
                const auto c = [&](int j) { return patch.coefficient(i, j)[k]; };
                return raised<10>(c(1) * v + c(0)) + c(2) * vv;
            };
            return raised<20>(in_v(0)) + raised<20>(u * in_v(1)) + uu * in_v(2);
        };
        // Bounds the terms.
        const auto size = [&](int k) {
            double sum = 0;
            for (int i = 2; i >= 0; --i) {
                double in_v = 0;
                for (int j = 2; j >= 0; --j) in_v = in_v * largest_v + std::abs(patch.coefficient(i, j)[k]);
                sum = sum * largest_u + in_v;
            }
            return sum;
        };
        constexpr double blur = 2 * rounding;  // more terms than elsewhere
        const Bernstein<20> w = polynomial(3);
        const double least = w.smallest_coefficient() - blur * size(3);
        if (!(least > 0)) return infinity;
        double squared = 0, blurred = 0;
        for (int k = 0; k < 3; ++k) {
            const Bernstein<5> p = row(points, k);
            const double rounded = blur * (size(k) + p.largest() * size(3));
            squared += square((raised<25>(polynomial(k)) - p * w).largest() + rounded);
            blurred += square(rounded);
        }
        largest_blur = std::max(largest_blur, std::sqrt(blurred) / least);
        return std::sqrt(squared) / least;
    }
    double trim_error(int side, const Points& points, const PatchCoordinates& coordinates,
                      const Neighbourhood& D, const Frame& frame, const Range& over,
                      const Residuals& residuals, double& largest_q) const {
        const Residuals::Trim& trim = residuals.trims[side];
        Matrix4d M;
        M.row(0) = frame.gradients[0];
        M.row(1) = frame.gradients[side + 1];
        std::array<double, 4> variations{over.variations[0], over.variations[side + 1]},
            e{residuals.curve[0], residuals.curve[side + 1]};
        if (side == 1 && right_ > 2) {
            const Equation& right = equations_[right_];
            M.row(1) = right.gradient(D.center);
            variations[1] = right.variation(D.center, right.reach(D.center, points, D.room));
            e[1] = residuals.right;
        }
        for (int i = 0; i < 2; ++i) {
            const PatchCoordinate& c = coordinates[i];
            const auto value = points.row(4 + 2 * side + i);
            const double low = value.minCoeff(), high = value.maxCoeff(), middle = 0.5 * (low + high);
            const Vector4d n = c.numerator.head<4>(), d = c.divisor.head<4>(), gradient = n - middle * d;
            const double scale = gradient.norm(), across = d.norm();
            if (!(trim.divisor[i] > D.room * across)) return infinity;
            M.row(2 + i) = gradient / scale;
            variations[2 + i] = 0.5 * (high - low) * across / scale;
            e[2 + i] = trim.residual[i] / scale;
        }
        const Solver solver(M, variations);
        largest_q = std::max(largest_q, solver.q);
        if (!solver.is_regular()) return infinity;
        const double distance = solver.distance(e);
        return distance <= D.room ? distance : infinity;
    }

    const RadialBaseProblem& problem_;
    const SpaceArc& arc_;
    double tolerance_;
    std::vector<SpaceSpan>& spans_;
    FitEffort& effort_;
    std::array<Equation, 4> equations_;  // base, left and right; of the curve the first three
    int right_ = 2;                      // where the right site's is
    Vec3 foot_;                          // near the curve, on the base's axis
    Node start_, end_;                   // of the edge
    std::size_t first_span_ = spans_.size();
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

// Within a ball of twice the bound the solution is unique by step 2, and the point is one.
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
                               std::vector<SpaceSpan>& spans, FitEffort& effort) {
    return Fitter(problem, arc, tolerance, spans, effort).run();
}

}  // namespace vcell
