#include "spline_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "../../core/curves/scaled_bernstein.hpp"
#include "../diagram/chart_arc.hpp"

namespace vcell {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double u = std::numeric_limits<double>::epsilon() / 2;

// Rounding of a residual or gradient, in units of u times the magnitudes that enter it: some twenty
// operations, and coefficients within 4u.
constexpr double rounding = 32 * u;

// A height with its derivatives; the Hessian is bend bend^T + round I.
struct HeightJet2 {
    double value;
    Vector2d gradient, bend;
    double round;
    double gradient_error;  // rounding

    double hessian(const Vector2d& a, const Vector2d& b) const {
        return bend.dot(a) * bend.dot(b) + round * a.dot(b);
    }
};

template <int N>
struct Homogeneous {
    Bernstein<N> X, Y, Z, W;
};

class Side {
public:
    explicit Side(const ArcSide& side) : side_(side) {}

    const CylinderFrame* cylinder() const { return side_.cylinder; }

    HeightJet2 operator()(const Vector2d& p) const {
        if (side_.circular) {
            const CircularForm& f = *side_.circular;
            const Vector2d g = gradient(f, p);
            const double size =
                (2 * f.k * (p - Vector2d(f.cx, f.cy)).norm() + std::abs(f.a) + std::abs(f.b)) / f.w;
            return {f(p.x(), p.y()), g, Vector2d::Zero(), 2 * f.k / f.w, rounding * size};
        }
        const CylinderHeight& f = side_.cylinder->height();
        const CylinderHeight::Jet jet = f(p);
        const Vector2d across(-jet.v.y(), jet.v.x());
        const double size =
            (p - f.point().head<2>()).norm() + std::abs(f.point().z()) + jet.value + f.reach();
        return {jet.value, jet.gradient, across / (jet.s * std::sqrt(jet.s)), 0, rounding * size / jet.s};
    }

    // Of |Hess| within `radius` of a point with the given jet.
    double curvature_bound(const HeightJet2& at, double radius) const {
        if (side_.circular) return at.round;
        return side_.cylinder->height().curvature_bound(1 / at.bend.squaredNorm(), radius);
    }

    // How far the gradient may be from that of `at`, the jet at p, within `room` of the hull of the points. A
    // cylinder's is (V / s - d) / d_z: it turns with V = V(p) + d_z (q - p) alone, by no more than d_z a / (s
    // + d_z l) from p to q, a and l being the parts of q - p across and along V(p). So it is no farther away
    // than a / (s + d_z l): next to nothing along the axis, however sharply the height bends across.
    template <std::size_t N>
    double variation(const HeightJet2& at, const Vector2d& p, const std::array<Vector2d, N>& points,
                     double room) const {
        double reach = 0, across = 0, behind = 0;
        const Vector2d bend = side_.circular ? at.bend : Vector2d(at.bend.normalized()),
                       along(bend.y(), -bend.x());
        for (const Vector2d& q : points) {
            reach = std::max(reach, (q - p).norm());
            across = std::max(across, std::abs(bend.dot(q - p)));
            behind = std::max(behind, -along.dot(q - p));
        }
        reach += room;
        if (side_.circular) return at.gradient_error + at.round * reach;
        const double s = 1 / at.bend.squaredNorm(), doubt = at.gradient_error;
        const double least =
            s * (1 - doubt) - side_.cylinder->height().axis().z() * (behind + doubt * reach + room);
        return least > 0 ? doubt + (across + doubt * reach + room) / least
                         : std::numeric_limits<double>::infinity();
    }

    // Step 1 of the certificate: |z - f(p)| along a span; infinite if it cannot tell.
    double height_error(const Bernstein<5>& x, const Bernstein<5>& y, const Bernstein<5>& z) const {
        if (side_.circular) {
            const CircularForm& f = *side_.circular;
            const Bernstein<5> linear = f.a * x + f.b * y + (-f.w) * z + f.e;
            const double linear_size =
                std::abs(f.a) * x.largest() + std::abs(f.b) * y.largest() + f.w * z.largest() + std::abs(f.e);
            if (f.k == 0) return (linear.largest() + rounding * linear_size) / f.w;
            const Bernstein<5> dx = x - f.cx, dy = y - f.cy;
            const double size = f.k * (square(dx.largest()) + square(dy.largest())) + linear_size;
            return ((f.k * (dx * dx + dy * dy) + raised<10>(linear)).largest() + rounding * size) / f.w;
        }
        // About the axis's point c, with t the axial coordinate and k = rho + c_z,
        //     C - 2 beta z - d_z^2 z^2 = m_x^2 + m_y^2 - t^2 - k (2 z + rho - c_z),
        // and (beta + d_z^2 z) = k + d_z t =: b is s on the bisector. The residual Q is (f - z)(s + b), and
        // s^2 = b^2 + d_z^2 Q.
        const CylinderHeight& f = side_.cylinder->height();
        const Eigen::Vector3d &c = f.point(), &d = f.axis();
        const double k = f.rho() + c.z();
        const Bernstein<5> mx = x - c.x(), my = y - c.y(), mz = z - c.z();
        const Bernstein<5> t = d.x() * mx + d.y() * my + d.z() * mz;
        const Bernstein<5> linear = k * (2 * z + (f.rho() - c.z()));
        const double distance = mx.largest() + my.largest() + std::abs(c.z()) + f.rho() + z.largest();
        const double size = square(mx.largest()) + square(my.largest()) + square(t.largest()) +
                            linear.largest() + distance * f.reach();
        const double Q = (mx * mx + my * my - t * t - raised<10>(linear)).largest() + rounding * size;
        const double b = (d.z() * t + k).smallest_coefficient();
        const double below = b * b - d.z() * d.z() * Q;
        return b > 0 && below > 0 ? Q / (b + std::sqrt(below)) : std::numeric_limits<double>::infinity();
    }

    // The same of a rational curve (X, Y, Z) / W: everything times W^2.
    template <int N>
    double height_error(const Homogeneous<N>& P) const {
        const double least = P.W.smallest_coefficient(), most = P.W.largest();
        if (!(least > 0)) return std::numeric_limits<double>::infinity();
        if (side_.circular) {
            const CircularForm& f = *side_.circular;
            const Bernstein<N> dx = P.X - f.cx * P.W, dy = P.Y - f.cy * P.W;
            const Bernstein<N> linear = f.a * P.X + f.b * P.Y + (-f.w) * P.Z + f.e * P.W;
            const double size = f.k * (square(dx.largest()) + square(dy.largest())) +
                                most * (std::abs(f.a) * P.X.largest() + std::abs(f.b) * P.Y.largest() +
                                        f.w * P.Z.largest() + std::abs(f.e) * most);
            return ((f.k * (dx * dx + dy * dy) + linear * P.W).largest() + rounding * size) /
                   (f.w * square(least));
        }
        const CylinderHeight& f = side_.cylinder->height();
        const Eigen::Vector3d &c = f.point(), &d = f.axis();
        const double k = f.rho() + c.z();
        const Bernstein<N> mx = P.X - c.x() * P.W, my = P.Y - c.y() * P.W, mz = P.Z - c.z() * P.W;
        const Bernstein<N> t = d.x() * mx + d.y() * my + d.z() * mz;
        const Bernstein<N> linear = k * (2 * P.Z + (f.rho() - c.z()) * P.W);
        const double distance =
            mx.largest() + my.largest() + (std::abs(c.z()) + f.rho()) * most + P.Z.largest();
        const double size = square(mx.largest()) + square(my.largest()) + square(t.largest()) +
                            linear.largest() * most + distance * f.reach() * most;
        const double Q =
            ((mx * mx + my * my - t * t - linear * P.W).largest() + rounding * size) / square(least);
        const Bernstein<N> lower = d.z() * t + k * P.W;
        double b = std::numeric_limits<double>::infinity();
        for (int i = 0; i <= N; ++i) b = std::min(b, lower.coefficient(i) / P.W.coefficient(i));
        const double below = b * b - d.z() * d.z() * Q;
        return b > 0 && below > 0 ? Q / (b + std::sqrt(below)) : std::numeric_limits<double>::infinity();
    }

private:
    static double square(double a) { return a * a; }

    ArcSide side_;
};

class Fitter {
public:
    Fitter(const std::array<ArcSide, 2>& sides, double tolerance, std::vector<MixedSpan>& spans)
        : sides_{Side(sides[0]), Side(sides[1])}, tolerance_(tolerance), spans_(spans) {}

    FitError run(const ArcEnd* start, const ArcEnd* end,
                 std::span<const MinimizationDiagram::ArcPiece> pieces) {
        halvings_left_ = most_halvings + most_of_piece * static_cast<int>(pieces.size());
        nodes_.reserve(pieces.size() + 1);
        nodes_.push_back(start ? node(start->point, start->height) : inner_node(pieces.back()));
        for (const Piece& piece : pieces.first(pieces.size() - 1)) nodes_.push_back(inner_node(piece));
        nodes_.push_back(end ? node(end->point, end->height) : nodes_.front());
        fit(pieces, 0);
        return error_;
    }

private:
    using Piece = MinimizationDiagram::ArcPiece;
    static constexpr int deepest = 24;  // halvings of one piece
    // Of all of an arc: what a singular end needs several times over, and some for each piece.
    static constexpr int most_halvings = 256, most_of_piece = 16;

    // A point of the arc and what the fit needs of the heights there.
    struct Node {
        Vector2d p;
        double z;
        std::array<HeightJet2, 2> jets;

        Vector2d slope() const { return jets[0].gradient - jets[1].gradient; }
    };
    Node node(const Vector2d& p, std::optional<double> z = std::nullopt) const {
        Node n{p, 0, {sides_[0](p), sides_[1](p)}};
        n.z = z.value_or(0.5 * (n.jets[0].value + n.jets[1].value));
        return n;
    }

    double difference(const Node& n) const { return n.jets[0].value - n.jets[1].value; }

    // Newton's method along a line, to the level of rounding. Where that is higher than of the numbers at
    // hand, as of cylinders given by a point far along their axis, steps end to shrink before; the
    // certificate judges the span.
    std::optional<Node> find(Vector2d p, const Vector2d& direction) const {
        constexpr int enough = 12;
        constexpr double small = 0x1p-36;  // of the size
        double last = std::numeric_limits<double>::infinity();
        for (int i = 0; i < enough; ++i) {
            const Node n = node(p);
            const double slope = direction.dot(n.slope()), step = difference(n) / slope,
                         length = std::abs(step);
            const double heights = std::abs(n.jets[0].value) + std::abs(n.jets[1].value);
            const double size = p.norm() + heights / std::abs(slope);
            if (length <= 16 * u * size || (length <= small * size && 2 * length >= last)) return n;
            p -= step * direction;
            last = length;
        }
        return std::nullopt;
    }

    Node inner_node(const Piece& piece) const {
        const auto found = find(piece.end, piece.direction);
        return found && (found->p - piece.end).norm() <= 2 * piece.error + 8 * u * piece.end.norm()
                   ? *found
                   : node(piece.end);
    }

    // Is the derivative of the difference along d positive all along a segment?
    bool increases(const Vector2d& a, const Vector2d& b, const Vector2d& d, int halvings = 5) const {
        const Vector2d middle = 0.5 * (a + b);
        const double radius = 0.5 * (b - a).norm();
        const Node n = node(middle);
        if (d.dot(n.slope()) > variation(n, radius)) return true;
        return halvings > 0 && increases(a, middle, d, halvings - 1) && increases(middle, b, d, halvings - 1);
    }

    // How far the gradient of the difference may be from its computed value at n, within a radius.
    double variation(const Node& n, double radius) const {
        double sum = 0;
        for (int i = 0; i < 2; ++i)
            sum += n.jets[i].gradient_error + radius * sides_[i].curvature_bound(n.jets[i], radius);
        return sum;
    }

    // A fitted span with what the certificate finds; infinite errors where it fails.
    struct Fit {
        MixedSpan span;
        FitError error;
        Vector2d slope = Vector2d::Zero();  // in the middle
    };

    // Pieces from nodes_[first] on: in one span where that will do, else in two groups.
    void fit(std::span<const Piece> pieces, std::size_t first) {
        if (pieces.size() == 1) return fit(nodes_[first], nodes_[first + 1], pieces.front(), deepest);
        if (accept(hermite(nodes_[first], nodes_[first + pieces.size()], pieces))) return;
        const std::size_t half = pieces.size() / 2;
        fit(pieces.first(half), first);
        fit(pieces.subspan(half), first + half);
    }

    void fit(const Node& from, const Node& to, const Piece& piece, int halvings) {
        const Fit smooth = hermite(from, to, {&piece, 1});
        if (accept(smooth)) return;
        // Arc and chord lie in the piece's box: where that is small enough the chord will do.
        const Fit chord = straight(from, to, piece);
        if (accept(chord)) return;
        if (halvings > 0 && halvings_left_ > 0 && !is_blurred(from, to)) {
            std::optional<Node> middle;
            if (std::isfinite(smooth.error.chart)) {
                const auto& p = smooth.span.points;  // B(1/2) = sum of binomials / 32
                const Eigen::Vector4d at = (p[0] + 5 * p[1] + 10 * p[2] + 10 * p[3] + 5 * p[4] + p[5]) / 32;
                middle = find(at.head<2>(), smooth.slope.normalized());
            } else {
                const Vector2d at = 0.5 * (from.p + to.p);
                middle = find(at, piece.direction);
                if (middle && !increases(at, middle->p, piece.direction)) middle.reset();
            }
            if (middle) {
                --halvings_left_;
                fit(from, *middle, piece, halvings - 1);
                fit(*middle, to, piece, halvings - 1);
                return;
            }
        }
        const Fit& better = smooth.error.space < chord.error.space ? smooth : chord;
        append(better);
    }

    // Next to a point in which the gradients agree, rounding of the heights may move the arc by more than the
    // room that a span has beside it, which shrinks with each halving: then none of its parts can be proved.
    bool is_blurred(const Node& from, const Node& to) const {
        const auto blur = [&](const Node& n) {
            double error = 0;
            for (const Side& side : sides_)
                error += side.height_error(constant(n.p.x()), constant(n.p.y()), constant(n.z));
            return error / n.slope().norm();
        };
        const double room = 0.25 * (to.p - from.p).norm() + 8 * u * from.p.norm();
        return std::min(blur(from), blur(to)) > room;
    }
    static Bernstein<5> constant(double value) {
        return Bernstein<5>::from([value](int) { return value; });
    }

    bool accept(const Fit& f) {
        if (!(f.error.space <= tolerance_)) return false;
        append(f);
        return true;
    }
    // An arc is no better than its worst span: what is as good will do from here on. So an arc of which no
    // part can be proved costs one descent.
    void append(const Fit& f) {
        error_.chart = std::max(error_.chart, f.error.chart);
        error_.space = std::max(error_.space, f.error.space);
        tolerance_ = std::max(tolerance_, error_.space);
        spans_.push_back(f.span);
    }

    // Position, first and second derivative in the span's parameter at an end, for all curves of the span.
    struct EndJet {
        std::array<Vector2d, 3> p;
        std::array<double, 3> z;
        std::array<std::array<Vector2d, 3>, 2> uv;
    };

    EndJet end_jet(const Node& n, const Vector2d& p1, const Vector2d& p2) const {
        EndJet jet{{n.p, p1, p2}, {n.z, 0, 0}, {}};
        for (int i = 0; i < 2; ++i) {
            const HeightJet2& f = n.jets[i];
            jet.z[1] += 0.5 * f.gradient.dot(p1);
            jet.z[2] += 0.5 * (f.hessian(p1, p1) + f.gradient.dot(p2));
            if (const CylinderFrame* frame = sides_[i].cylinder()) jet.uv[i] = frame->parameters(n.p, p1, p2);
        }
        return jet;
    }

    // Bezier points of the quintic with the given ends.
    template <class T>
    static std::array<T, 6> quintic(const std::array<T, 3>& a, const std::array<T, 3>& b) {
        return {a[0],
                a[0] + a[1] / 5,
                a[0] + 2 * a[1] / 5 + a[2] / 20,
                b[0] - 2 * b[1] / 5 + b[2] / 20,
                b[0] - b[1] / 5,
                b[0]};
    }

    MixedSpan span_between(const EndJet& a, const EndJet& b) const {
        MixedSpan span;
        span.degree = 5;
        const auto p = quintic(a.p, b.p);
        const auto z = quintic(a.z, b.z);
        for (int k = 0; k <= 5; ++k) span.points[k] = {p[k].x(), p[k].y(), z[k], 1};
        for (int i = 0; i < 2; ++i) {
            if (!sides_[i].cylinder()) continue;
            const auto uv = quintic(a.uv[i], b.uv[i]);
            span.trims[i].degree = 5;
            for (int k = 0; k <= 5; ++k) span.trims[i].points[k] = {uv[k].x(), uv[k].y(), 1};
        }
        return span;
    }

    // With h over the chord (e along it, m to its left) and D = f - g:
    //     h' = -D_e / D_m,   h'' = -Hess D (e + h' m, e + h' m) / D_m.
    Fit hermite(const Node& from, const Node& to, std::span<const Piece> pieces) const {
        constexpr double steepest = 2;
        const double length = (to.p - from.p).norm();
        const Vector2d e = (to.p - from.p) / length, m(-e.y(), e.x());
        Fit fit;
        fit.error.chart = fit.error.space = std::numeric_limits<double>::infinity();
        std::array<EndJet, 2> ends;
        for (int i = 0; i < 2; ++i) {
            const Node& n = i == 0 ? from : to;
            const Vector2d slope = n.slope();
            const double across = slope.dot(m), h1 = -slope.dot(e) / across;
            // left - right falls to the left of the edge.
            if (!(across < 0 && std::abs(h1) <= steepest)) return fit;
            const Vector2d tangent = e + h1 * m;
            const double h2 =
                -(n.jets[0].hessian(tangent, tangent) - n.jets[1].hessian(tangent, tangent)) / across;
            ends[i] = end_jet(n, length * tangent, length * length * h2 * m);
        }
        fit.span = span_between(ends[0], ends[1]);
        certify(fit, pieces);
        return fit;
    }

    Fit straight(const Node& from, const Node& to, const Piece& piece) const {
        std::array<EndJet, 2> ends{end_jet(from, Vector2d::Zero(), Vector2d::Zero()),
                                   end_jet(to, Vector2d::Zero(), Vector2d::Zero())};
        const auto join = [](auto& a, auto& b) { a[1] = b[1] = b[0] - a[0]; };
        join(ends[0].p, ends[1].p);
        join(ends[0].z, ends[1].z);
        for (int i = 0; i < 2; ++i) join(ends[0].uv[i], ends[1].uv[i]);
        Fit fit;
        fit.span = span_between(ends[0], ends[1]);
        const double diameter = std::hypot(piece.box[1] - piece.box[0], piece.box[3] - piece.box[2]);
        fit.error.chart = diameter + piece.error;
        const Node middle = node(0.5 * (from.p + to.p));
        fit.error.space = space_error(fit.span, middle, fit.error.chart, fit.error.chart);
        return fit;
    }

    // Steps 1 to 4.
    void certify(Fit& fit, std::span<const Piece> pieces) const {
        const auto& p = fit.span.points;
        Eigen::Array2d low = p[0].head<2>(), high = low;
        for (int k = 1; k <= 5; ++k) {
            low = low.min(p[k].head<2>().array());
            high = high.max(p[k].head<2>().array());
        }
        const Node middle = node(0.5 * (low + high).matrix());
        // Room for the arc beside the span: what it may at most be away.
        const double half = 0.5 * (high - low).matrix().norm(), room = 0.25 * half + 8 * u * middle.p.norm();
        const bool single = pieces.size() == 1;
        const double radius = single ? half + room : std::max(half + room, reach(middle.p, pieces));
        const double change = variation(middle, radius);
        const Vector2d difference = middle.slope();
        const double slope = difference.norm() - change;
        if (!(slope > 0 && (!single || pieces.front().direction.dot(difference) > change))) return;
        const auto [x, y, z] = coordinates(fit.span);
        const double distance = (sides_[0].height_error(x, y, z) + sides_[1].height_error(x, y, z)) / slope;
        if (!(distance <= room)) return;
        fit.slope = difference;
        fit.error.chart = distance;
        fit.error.space = space_error(fit.span, middle, distance, radius);
    }

    // The radius of the disk around p that contains the boxes of the pieces.
    static double reach(const Vector2d& p, std::span<const Piece> pieces) {
        double squared = 0;
        for (const Piece& piece : pieces) {
            const double dx = std::max(p.x() - piece.box[0], piece.box[1] - p.x());
            const double dy = std::max(p.y() - piece.box[2], piece.box[3] - p.y());
            squared = std::max(squared, dx * dx + dy * dy);
        }
        return std::sqrt(squared);
    }

    static std::array<Bernstein<5>, 3> coordinates(const MixedSpan& span) {
        std::array<Bernstein<5>, 3> result;
        for (int i = 0; i < 3; ++i) result[i] = Bernstein<5>::from([&](int k) { return span.points[k][i]; });
        return result;
    }

    // From the distance in the chart to that in space, of the curve and of the lifted trims.
    double space_error(const MixedSpan& span, const Node& middle, double distance, double radius) const {
        const auto [x, y, z] = coordinates(span);
        double worst = 0, arc_height = std::numeric_limits<double>::infinity();
        for (int i = 0; i < 2; ++i) {
            const double error = sides_[i].height_error(x, y, z);
            const double slope =
                middle.jets[i].gradient.norm() + radius * sides_[i].curvature_bound(middle.jets[i], radius);
            arc_height = std::min(arc_height, error + slope * distance);
            const double trim = trim_deviation(i, span, x, y);
            worst = std::max(worst, std::hypot(trim, error + slope * trim));
        }
        return std::max(worst, std::hypot(distance, arc_height));
    }

    // |chart point of the patch at (u, v)(t) - p(t)|, about the frame's origin.
    double trim_deviation(int side, const MixedSpan& span, const Bernstein<5>& x,
                          const Bernstein<5>& y) const {
        const CylinderFrame* frame = sides_[side].cylinder();
        if (!frame) return 0;
        const auto& points = span.trims[side].points;
        const auto U = Bernstein<5>::from([&](int k) { return points[k].x(); });
        const auto V = Bernstein<5>::from([&](int k) { return points[k].y(); });
        const double eps = frame->eps();
        const Vector2d ex = frame->turned({1, 0}), ey = frame->turned({0, 1}),
                       o = frame->turned(frame->origin());
        const Bernstein<5> along = ex.x() * x + ey.x() * y - o.x(), across = ex.y() * x + ey.y() * y - o.y();
        const Bernstein<10> turned = (eps * U + 1) * V;
        const double size =
            U.largest() + turned.largest() * (1 + eps * V.largest()) + x.largest() + y.largest();
        const double first = (raised<15>(U - along) - (0.25 * eps) * (turned * V)).largest();
        const double second = (turned - raised<10>(across)).largest();
        return std::hypot(first, second) + rounding * size;
    }

    const std::array<Side, 2> sides_;
    double tolerance_;
    std::vector<MixedSpan>& spans_;
    std::vector<Node> nodes_;  // the ends of the pieces
    int halvings_left_ = 0;
    FitError error_;
};

// The certificate of conic_error().
class ConicError {
public:
    using Points = std::array<Eigen::Vector4d, 3>;  // homogeneous
    using Trim = std::array<Vector3d, 4>;

    ConicError(const std::array<ArcSide, 2>& sides, const SectionSurface& plane)
        : sides_(sides), plane_(plane) {}

    void add(const Points& points, const std::array<Trim, 2>& trims) {
        Part part{points, trims};
        part.balance();
        bound_ = bound_ + refined(part, bound(part), deepest);
    }
    FitError error() const {
        return {bound_.proved.chart + 4 * bound_.rest.chart, bound_.proved.space + 4 * bound_.rest.space};
    }

private:
    struct Part {
        Points points;
        std::array<Trim, 2> trims;

        // The curves keep their places but get parameters that make the weights at the ends alike: halves are
        // then as long.
        void balance() {
            const double factor = std::sqrt(points[0].w() / points[2].w());
            if (!(factor > 4) && !(factor < 0.25)) return;
            const auto scale = [factor](auto& controls) {
                double power = 1;
                for (std::size_t k = 1; k < controls.size(); ++k) controls[k] *= power *= factor;
            };
            scale(points);
            for (Trim& trim : trims) scale(trim);
        }
        double length() const {
            double sum = 0;
            for (int i = 1; i < 3; ++i)
                sum += (points[i].head<3>() / points[i].w() - points[i - 1].head<3>() / points[i - 1].w())
                           .norm();
            return sum;
        }
    };
    // What is proved of some parts, and the length of the others.
    struct Bound {
        FitError proved, rest;

        bool is_proved() const { return rest.space == 0; }
        friend Bound operator+(const Bound& a, const Bound& b) {
            return {{std::max(a.proved.chart, b.proved.chart), std::max(a.proved.space, b.proved.space)},
                    {a.rest.chart + b.rest.chart, a.rest.space + b.rest.space}};
        }
    };
    static constexpr int deepest = 40, most_halvings = 400;
    static constexpr double sharp = 0x1p-36;  // of a part's length: no reader asks for more

    Bound bound(const Part& part) const {
        if (const auto whole = whole_error(part.points, part.trims)) return {*whole, {}};
        const double length = part.length();
        return {{}, {length, length}};
    }

    // Slopes and weights vary along a part, and what is proved of all of it at once may be far too much:
    // parts are halved until there is a proof, and on while that gains a factor of four.
    Bound refined(const Part& part, const Bound& whole, int depth) {
        // What could only be sharper leaves alone what is needed for proofs.
        int& halvings = whole.is_proved() ? sharpenings_ : halvings_;
        if (depth == 0 || halvings == 0) return whole;
        if (whole.is_proved() && whole.proved.space <= sharp * part.length()) return whole;
        --halvings;
        std::array<Part, 2> half;
        divide(part.points, half[0].points, half[1].points);
        for (int side = 0; side < 2; ++side)
            divide(part.trims[side], half[0].trims[side], half[1].trims[side]);
        for (Part& h : half) h.balance();
        const std::array<Bound, 2> of_half{bound(half[0]), bound(half[1])};
        if (whole.is_proved()) {
            const Bound both = of_half[0] + of_half[1];
            if (!both.is_proved() || both.proved.space > 0.25 * whole.proved.space) return whole;
        }
        return refined(half[0], of_half[0], depth - 1) + refined(half[1], of_half[1], depth - 1);
    }

    template <class Control>
    static void divide(const Control& points, Control& first, Control& second) {
        Control work = points;
        const std::size_t n = points.size() - 1;
        for (std::size_t k = 0; k <= n; ++k) {
            first[k] = work[0];
            second[n - k] = work[n - k];
            for (std::size_t i = 0; i < n - k; ++i) work[i] = 0.5 * (work[i] + work[i + 1]);
        }
    }

    bool has_height(int side) const { return sides_[side].circular || sides_[side].cylinder; }

    std::optional<FitError> whole_error(const Points& points, const std::array<Trim, 2>& trims) const {
        std::array<Vector2d, 3> chart;
        Eigen::Array2d low = points[0].head<2>() / points[0].w(), high = low;
        for (int k = 0; k < 3; ++k) {
            chart[k] = points[k].head<2>() / points[k].w();
            low = low.min(chart[k].array());
            high = high.max(chart[k].array());
        }
        const Vector2d middle = 0.5 * (low + high).matrix();
        const auto row = [&](int i) { return Bernstein<2>::from([&](int k) { return points[k][i]; }); };
        const Homogeneous<2> P{row(0), row(1), row(2), row(3)};
        // The first cylinder's height, less that of the plane.
        const int first = sides_[0].cylinder ? 0 : 1;
        std::array<double, 2> error{}, trim{};
        std::array<std::optional<HeightJet2>, 2> jets;
        for (const int i : {0, 1}) {
            if (!has_height(i)) continue;
            const Side side(sides_[i]);
            jets[i] = side(middle);
            error[i] = side.height_error(P);
            if (sides_[i].cylinder) trim[i] = trim_deviation(*sides_[i].cylinder, P, trims[i]);
        }
        FitError result;
        const auto* wall = std::get_if<WallLine>(&plane_);
        double residual = 0, least = 0;
        if (wall != nullptr) {
            const double norm = std::hypot(wall->a, wall->b), most = P.W.largest();
            const double size = std::abs(wall->a) * P.X.largest() + std::abs(wall->b) * P.Y.largest() +
                                std::abs(wall->c) * most;
            result.chart = ((wall->a * P.X + wall->b * P.Y + wall->c * P.W).largest() + rounding * size) /
                           (norm * P.W.smallest_coefficient());
        } else {
            const Side graph(ArcSide{&std::get<CircularForm>(plane_), nullptr});
            const HeightJet2 jet = graph(middle);
            residual = error[first] + graph.height_error(P);
            least = (jets[first]->gradient - jet.gradient).norm() - jet.gradient_error;
            result.chart = 2 * residual / least;
        }
        // What is compared is to be within this of the part, if gradients change by half of what they are.
        const double room = std::max({result.chart, trim[0], trim[1]}) + 64 * u * middle.norm();
        const double half = 0.5 * (high - low).matrix().norm();
        if (!(room <= 0.25 * half + 64 * u * middle.norm())) return std::nullopt;
        std::array<double, 2> change{};
        for (const int i : {0, 1})
            if (has_height(i)) change[i] = Side(sides_[i]).variation(*jets[i], middle, chart, room);
        if (wall == nullptr) {
            if (!(least > 2 * change[first])) return std::nullopt;
            result.chart = residual / (least - change[first]);
        }
        double arc_height = std::numeric_limits<double>::infinity(), worst = 0;
        for (const int i : {0, 1}) {
            if (!has_height(i)) continue;
            const double slope = jets[i]->gradient.norm() + change[i];
            arc_height = std::min(arc_height, error[i] + slope * result.chart);
            worst = std::max(worst, std::hypot(trim[i], error[i] + slope * trim[i]));
        }
        result.space = std::max(worst, std::hypot(result.chart, arc_height));
        if (!std::isfinite(result.space)) return std::nullopt;
        return result;
    }

    // As for the splines, everything times powers of the weights.
    static double trim_deviation(const CylinderFrame& frame, const Homogeneous<2>& P, const Trim& points) {
        const auto row = [&](int i) { return Bernstein<3>::from([&](int k) { return points[k][i]; }); };
        const Bernstein<3> U = row(0), V = row(1), D = row(2);
        const double eps = frame.eps(), least = D.smallest_coefficient(),
                     least_w = P.W.smallest_coefficient();
        if (!(least > 0 && least_w > 0)) return std::numeric_limits<double>::infinity();
        const Vector2d ex = frame.turned({1, 0}), ey = frame.turned({0, 1}), o = frame.turned(frame.origin());
        const Bernstein<2> along = ex.x() * P.X + ey.x() * P.Y - o.x() * P.W,
                           across = ex.y() * P.X + ey.y() * P.Y - o.y() * P.W;
        const Bernstein<6> turned = (eps * U + D) * V, D2 = square(D);
        const double uneven = D.largest() / least * (P.W.largest() / least_w);
        const double u_size = U.largest() / least, v_size = V.largest() / least,
                     turned_size = (1 + eps * u_size) * v_size;
        const double size = u_size + turned_size * (1 + eps * v_size) +
                            (P.X.largest() + P.Y.largest()) / least_w + frame.origin().norm();
        const double scale = least_w * least * least;
        const double first =
            ((U * D2 * P.W - along * (D2 * D)) - (0.25 * eps) * (turned * V * P.W)).largest() /
            (scale * least);
        const double second = (turned * P.W - across * D2).largest() / scale;
        return std::hypot(first, second) + rounding * uneven * uneven * uneven * size;
    }

    const std::array<ArcSide, 2> sides_;
    const SectionSurface& plane_;
    Bound bound_;
    int halvings_ = most_halvings, sharpenings_ = most_halvings;
};

}  // namespace

FitError conic_error(const std::array<ArcSide, 2>& sides, const SectionSurface& plane,
                     std::span<const MixedSpan> spans) {
    ConicError error(sides, plane);
    for (const MixedSpan& span : spans) {
        const auto homogeneous = [&](int k) {
            const Eigen::Vector4d& p = span.points[k];
            return Eigen::Vector4d(p.w() * p.x(), p.w() * p.y(), p.w() * p.z(), p.w());
        };
        ConicError::Points points{homogeneous(0), homogeneous(1), homogeneous(span.degree)};
        if (span.degree == 1) points[1] = 0.5 * (points[0] + points[2]);
        std::array<ConicError::Trim, 2> trims;
        for (const int side : {0, 1}) {
            const MixedSpan::Trim& trim = span.trims[side];
            const auto at = [&](int k) {
                const Vector3d& q = trim.points[k];
                return Vector3d(q.z() * q.x(), q.z() * q.y(), q.z());
            };
            ConicError::Trim& t = trims[side];
            t = {at(0), at(1), at(2), at(3)};
            if (trim.degree == 1) t = {at(0), (2 * at(0) + at(1)) / 3, (at(0) + 2 * at(1)) / 3, at(1)};
            if (trim.degree == 2) t = {at(0), (at(0) + 2 * at(1)) / 3, (2 * at(1) + at(2)) / 3, at(2)};
        }
        error.add(points, trims);
    }
    return error.error();
}

FitError fit_spline(const std::array<ArcSide, 2>& sides, const ArcEnd* start, const ArcEnd* end,
                    std::span<const MinimizationDiagram::ArcPiece> pieces, double tolerance,
                    std::vector<MixedSpan>& spans) {
    return Fitter(sides, tolerance, spans).run(start, end, pieces);
}

}  // namespace vcell
