#include "radial_lift.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "../../core/errors.hpp"
#include "../../primitives/forms/axial_ties.hpp"
#include "../../primitives/objects/exact_space.hpp"
#include "../../primitives/objects/message.hpp"
#include "../diagram/chart_arc.hpp"
#include "../measures/measures.hpp"
#include "../measures/radial_measures.hpp"
#include "axial_conic.hpp"
#include "conic_error.hpp"
#include "conic_span.hpp"
#include "face_cut.hpp"
#include "joined_spans.hpp"
#include "radial_patch.hpp"
#include "space_spline.hpp"

namespace vcell {

namespace {

using Eigen::Vector2d;
using Eigen::Vector4d;

constexpr double u = std::numeric_limits<double>::epsilon() / 2;

// Middle weights of conics, in space and in both faces' parameters, against the geometric mean of those at
// the ends: from here on control points stay close to their curves. An arc of a circle of 145 degrees has it.
constexpr double least_weight = 0.3;

// A trim's control points (u w, v w, w).
struct TrimSpan {
    Eigen::Vector3d from, middle, to;

    // The parameters are quotients of linear functions of (p, t).
    TrimSpan(const RadialPatch& patch, const ConicSpan& s) {
        const RadialPatch::Projection& map = patch.projection();
        from = map(s.from, 1);
        middle = map(s.middle, s.weight);
        to = map(s.to, 1);
        if (patch.kind() == RadialPatch::Kind::Stereographic) settle_weights(patch.axes()[2], s);
        if (patch.kind() == RadialPatch::Kind::Confocal) settle_parameters(patch, s);
    }
    double weight() const { return middle.z() / std::sqrt(from.z() * to.z()); }

private:
    // The weight is t + z with z along the patch's third axis, which cancels near the pole. But a curve on
    // the cone x^2 + y^2 + z^2 = t^2 has x0^2 + y0^2 = (t0 + z0) (t0 - z0) at its ends, and the middle
    // control point on the tangents there: x0 x1 + y0 y1 = ((t0 + z0) (t1 - z1) + (t0 - z0) (t1 + z1)) / 2.
    void settle_weights(const Vec3& axis, const ConicSpan& s) {
        const auto other = [&](const Vector4d& x) { return x.w() - axis.dot(x.head<3>()); };
        const double from_other = other(s.from), to_other = other(s.to);
        if (from.z() >= from_other && to.z() >= to_other) return;
        if (from.z() < from_other) from.z() = from.head<2>().squaredNorm() / from_other;
        if (to.z() < to_other) to.z() = to.head<2>().squaredNorm() / to_other;
        const bool at_start = from_other > to_other;
        const Eigen::Vector3d& end = at_start ? from : to;
        middle.z() = (2 * end.head<2>().dot(middle.head<2>()) - end.z() * other(s.middle)) /
                     (at_start ? from_other : to_other);
    }
    // The same of u = t + z, which is a weight's numerator there.
    void settle_parameters(const RadialPatch& patch, const ConicSpan& s) {
        const auto& [x, y, z] = patch.axes();
        const auto across = [&](const Vector4d& p) {
            return Vector2d(x.dot(p.head<3>()), y.dot(p.head<3>()));
        };
        const auto other = [&](const Vector4d& p) { return p.w() - z.dot(p.head<3>()); };
        const double from_other = other(s.from), to_other = other(s.to);
        if (from.x() >= from_other && to.x() >= to_other) return;
        if (from.x() < from_other) from.x() = across(s.from).squaredNorm() / from_other;
        if (to.x() < to_other) to.x() = across(s.to).squaredNorm() / to_other;
        const bool at_start = from_other > to_other;
        const Vector4d& end = at_start ? s.from : s.to;
        middle.x() = (2 * across(end).dot(across(s.middle)) - (at_start ? from : to).x() * other(s.middle)) /
                     (at_start ? from_other : to_other);
    }
};

// ---- Kinds of conics --------------------------------------------------------------------------------

// A circular form over a sphere base, seen from the centre: where it is met at the distance t in p,
// b.p + b0 t = k (t Q = W, times a positive factor). `square` is b.b - b0^2.
template <class Vector, class T>
struct Functional {
    Vector b;
    T b0, square, k;
};

bool is_wall(const RadialBaseProblem& problem, FormId f) { return !problem.sites[f].front().is_object(); }

// Away from the base.
Plane facing(const Plane& plane) {
    return {plane.point, plane.normal.dot(plane.point) < 0 ? Vec3(-plane.normal) : plane.normal};
}

Functional<Vec3, double> functional(const RadialBaseProblem& problem, FormId f) {
    if (const auto* sphere = std::get_if<Sphere>(&problem.objects[f])) {
        const double square = ball_power(problem, f);
        return {sphere->center, sphere->radius - problem.radius, square, 0.5 * square};
    }
    const Plane plane = facing(std::get<Plane>(problem.objects[f]));
    const double k = plane.normal.dot(plane.point), length = plane.normal.norm();
    if (is_wall(problem, f)) return {plane.normal, 0, length * length, k};
    return {plane.normal, length, 0, k + problem.radius * length};
}

Functional<ExactVector, Exact> exact_functional(const RadialBaseProblem& problem, FormId f) {
    if (const auto* sphere = std::get_if<Sphere>(&problem.objects[f])) {
        const ExactVector c(sphere->center);
        const Exact delta = Exact(sphere->radius) - Exact(problem.radius), square = dot(c, c) - delta * delta;
        return {c, delta, square, square.scaled(-1)};
    }
    const Plane plane = facing(std::get<Plane>(problem.objects[f]));
    const ExactVector n(plane.normal);
    const Exact k = dot(n, ExactVector(plane.point)), square = dot(n, n);
    if (is_wall(problem, f)) return {n, 0.0, square, k};
    const Exact length(rounded_sqrt(square));
    return {n, length, 0.0, k + length * Exact(problem.radius)};
}

// The plane in which a sphere's and a plane's or two such heights agree, and what it cuts from the bisector.
// In homogeneous coordinates the cone |n| = W lifts to the curve by p = n / Q; the plane {Q_f = Q_g} of its
// points meets infinity, Q_f = 0, in a line, and that line meets the cone in two points, in one, or in none
// as the Gram determinant of (b_f, b0_f) and (b_g, b0_g) in the cone's metric is positive, zero or negative.
class ConicKind {
public:
    using Approximate = Functional<Vec3, double>;

    ConicKind(const RadialBaseProblem& problem, Decisions& decisions)
        : problem_(problem), decisions_(decisions) {}

    // p and q: the forms' functionals.
    CurveKind operator()(FormId f, FormId g, const Approximate& p, const Approximate& q) {
        // b0 = 0: the bisector is a plane.
        if (is_flat(problem_, f) && is_flat(problem_, g)) return CurveKind::Line;
        // The plane lies across the axis of both bisectors, which are surfaces of revolution.
        if (are_parallel(f, g, p.b, q.b)) return CurveKind::Circle;
        const Sign sign = gram_sign(f, g, p, q);
        return sign == Sign::Positive   ? CurveKind::Hyperbola
               : sign == Sign::Negative ? CurveKind::Ellipse
                                        : CurveKind::Parabola;
    }

private:
    bool are_parallel(FormId f, FormId g, const Vec3& p, const Vec3& q) {
        if (p.cross(q).cwiseAbs().maxCoeff() > 4 * u * p.norm() * q.norm()) {
            ++decisions_.by_double;
            return false;
        }
        ++decisions_.by_exact;
        return cross(exact_functional(problem_, f).b, exact_functional(problem_, g).b).is_zero();
    }

    Sign gram_sign(FormId f, FormId g, const Approximate& p, const Approximate& q) {
        const double inner = p.b.dot(q.b) - p.b0 * q.b0;
        const double determinant = p.square * q.square - inner * inner;
        // No term of `inner` or of a square exceeds the product of these lengths; each carries four roundings
        // or fewer, as does its sum, and the determinant as many again.
        const double scale = (p.b.squaredNorm() + p.b0 * p.b0) * (q.b.squaredNorm() + q.b0 * q.b0);
        if (std::abs(determinant) > 64 * u * scale) {
            ++decisions_.by_double;
            return sign_of(determinant);
        }
        ++decisions_.by_exact;
        const auto P = exact_functional(problem_, f), R = exact_functional(problem_, g);
        const Exact exact_inner = dot(P.b, R.b) - P.b0 * R.b0;
        return (P.square * R.square - exact_inner * exact_inner).sign();
    }

    const RadialBaseProblem& problem_;
    Decisions& decisions_;
};

// ---- Points on bisectors ----------------------------------------------------------------------------

// Where a bisector runs out to infinity, a point's direction tells its distance badly, and rounding in the
// chart moves curves off their bisectors by far more than rounding in space. So points (p, t) are moved to
// where their functionals say, by the least that does.
class Hyperplane {
public:
    Hyperplane(const RadialBaseProblem& problem, FormId f) : functional_(vcell::functional(problem, f)) {
        const auto& [b, b0, square, k] = functional_;
        const double scale = 1 / std::sqrt(b.squaredNorm() + b0 * b0);
        plane_.normal << scale * b, scale * b0;
        plane_.k = scale * k;
        plane_.power = scale * scale * square;
    }
    const Functional<Vec3, double>& functional() const { return functional_; }
    const DistancePlane& plane() const { return plane_; }
    const Vector4d& normal() const { return plane_.normal; }
    // Of a homogeneous point of that weight.
    double residual(const Vector4d& x, double weight) const {
        return plane_.normal.dot(x) - weight * plane_.k;
    }
    double weight(const Vector4d& x) const { return plane_.normal.dot(x) / plane_.k; }
    // Of u, with 1 / t = gradient.u + a constant.
    Vec3 gradient() const { return plane_.normal.head<3>() / plane_.k; }
    double steepness() const { return 1 / std::abs(plane_.k); }

private:
    Functional<Vec3, double> functional_;
    DistancePlane plane_;
};

// To the common points of both. Where they are all but parallel, to those of the first.
Vector4d moved(const Vector4d& x, double weight, const std::array<const Hyperplane*, 2>& planes) {
    const auto& [p, q] = planes;
    const double a = p->residual(x, weight), b = q->residual(x, weight), inner = p->normal().dot(q->normal());
    // The step only brings a control point nearer, its error is bounded afterwards: of planes within 2^-15
    // (of a radian) of each other the second would move it along both by rounding.
    constexpr double least_sine2 = 0x1p-30;
    const double determinant = 1 - inner * inner;
    if (determinant < least_sine2) return x - a * p->normal();
    return x - ((a - inner * b) * p->normal() + (b - inner * a) * q->normal()) / determinant;
}

// To the common points of both and to the cone |p| = t, so that a conic's control point lies on its sites.
Vector4d moved_on_cone(const Vector4d& x, const std::array<const Hyperplane*, 2>& planes) {
    const Vector4d y = moved(x, 1, planes);
    // On along the line in both hyperplanes that changes |p| - t most.
    const double length = y.head<3>().norm();
    const Vector4d slope(y.x() / length, y.y() / length, y.z() / length, -1);
    const Vector4d along = moved(slope, 0, planes);
    const double change = slope.dot(along);
    // Output accuracy: of a smaller change (a squared sine) of |p| - t the step would be rounding, divided by
    // it.
    constexpr double least_change = 0x1p-30;
    return change > least_change ? Vector4d(y - (length - y.w()) / change * along) : y;
}

// To three hyperplanes and the cone: a step of Newton's method. May fail with numbers that are not finite.
Vector4d moved_to_meet(const Vector4d& x, const std::array<const Hyperplane*, 3>& planes) {
    Eigen::Matrix4d rows;
    Vector4d residual;
    for (int i = 0; i < 3; ++i) {
        rows.row(i) = planes[i]->normal();
        residual[i] = planes[i]->residual(x, 1);
    }
    const double length = x.head<3>().norm();
    rows.row(3) << x.head<3>().transpose() / length, -1;
    residual[3] = length - x.w();
    return x - rows.inverse() * residual;
}

// ---- The lift ---------------------------------------------------------------------------------------

class RadialLifter {
public:
    RadialLifter(const RadialBaseProblem& problem, const MinimizationDiagram& diagram, double tolerance)
        : problem_(problem), diagram_(diagram), tolerance_(tolerance), origin_(problem.frame.origin.norm()) {
        if (problem_.is_sphere) hyperplanes_ = decltype(hyperplanes_)(problem_.objects.size());
    }

    LiftedCell lift(bool with_measures) {
        add_vertices();
        add_kinds();
        add_arcs();
        add_faces();
        add_patches();
        add_surfaces();
        halve_for_trims();
        add_edges();
        if (with_measures)
            measure(problem_, diagram_, positions_, cell_);
        else
            rank_neighbors(cell_);
        cell_.report.decisions = diagram_.decisions;
        cell_.report.decisions += decisions_;
        return {std::move(cell_), std::move(positions_)};
    }

private:
    static constexpr Range no_range = empty_range;
    using Rectangle = std::array<Range, 2>;

    Site main_site(FormId f) const { return problem_.sites[f].front(); }
    // The rims of a cylinder's chart are sides 0 and 2.
    static Site end_site(std::uint32_t side) { return Site::end(side == 0 ? 0 : 1); }
    VertexId start(EdgeId e) const { return diagram_.dcel.origin(Dcel::half_edge(e)); }
    VertexId end(EdgeId e) const { return diagram_.dcel.target(Dcel::half_edge(e)); }
    bool is_line(EdgeId e) const { return kinds_[e] == CurveKind::Line; }
    bool is_spline(EdgeId e) const { return kinds_[e] == CurveKind::Spline; }
    std::span<const ConicSpan> spans(EdgeId e) const {
        return {conics_.data() + slices_[e].first, conics_.data() + slices_[e].last};
    }

    // At a chart distance of e from p, W = 1 + |p|^2 (half angles: 1 + x^2) differs by at most dW = (2 |p| +
    // e) e, the unit normal by 2 e / sqrt(W W') [the stereographic chord], and t = W / -f by the factors of W
    // and of f.
    double vertex_error(const MinimizationDiagram::Vertex& v, double t) const {
        const double e = v.error, x = v.point.x();
        const double reach = problem_.is_sphere ? v.point.norm() : std::abs(x > 1 ? x - 2 : x);
        const double W = 1 + reach * reach, dW = (2 * reach + e) * e;
        const double turn = 2 * e / std::sqrt(W * std::max(1.0, W - dW)), along = problem_.is_sphere ? 0 : e;
        const double room = -v.height - v.height_error;
        const double stretch =
            room > 0 ? (dW / W * -v.height + v.height_error) / room : std::numeric_limits<double>::infinity();
        // Normal, point, motion back: a handful of roundings each.
        return t * (turn + stretch) + along + 16 * u * (t + std::abs(v.point.y()) + origin_);
    }

    Vector4d with_distance(const Vec3& p) const {
        return {p.x(), p.y(), p.z(), problem_.is_sphere ? p.norm() : std::hypot(p.x(), p.z())};
    }

    const Hyperplane& hyperplane(FormId f) {
        const std::optional<Hyperplane>& plane = hyperplanes_[f];
        return plane ? *plane : make_hyperplane(f);
    }
    [[gnu::noinline]] const Hyperplane& make_hyperplane(FormId f) {
        return hyperplanes_[f].emplace(problem_, f);
    }

    // As met by the first three of its sites and ends.
    std::optional<SpaceEnd> settled(VertexId v, const SpaceEnd& near) const {
        std::array<SpaceSite, 3> sites;
        std::size_t count = 0;
        for (const std::uint32_t side : diagram_.sides(v)) sites[count++] = end_wall(side);
        for (const FormId f : diagram_.label(v))
            if (count < sites.size()) sites[count++] = {problem_.objects[f], is_wall(problem_, f), {}};
        return count == sites.size() ? settle_point(problem_, sites, near) : std::nullopt;
    }
    SpaceSite end_wall(std::uint32_t side) const {
        const bool is_upper = side != 0;
        return {Plane{{0, problem_.stretch[is_upper], 0}, {0, is_upper ? 1.0 : -1.0, 0}}, true, {}};
    }

    // (p, t) of a vertex and a bound on its distance from the true one.
    Vector4d vertex_point(VertexId v, double& error) {
        const MinimizationDiagram::Vertex& from = diagram_.vertices[v];
        const double t = problem_.distance(from.point, from.height);
        const Vec3 p = problem_.point(from.point, t);
        const Vector4d x(p.x(), p.y(), p.z(), t);
        error = vertex_error(from, t);
        if (error <= 64 * u * (t + origin_)) return x;
        const std::span<const FormId> forms = diagram_.label(v);
        const auto is_circular = [&](FormId f) { return diagram_.is_circular(f); };
        if (!problem_.is_sphere || !std::ranges::all_of(forms.first(3), is_circular)) {
            const auto end = settled(v, {p, error});
            if (!end) return x;
            error = end->error + 16 * u * (t + std::abs(p.y()) + origin_);
            return with_distance(end->point);
        }
        const Vector4d moved =
            moved_to_meet(x, {&hyperplane(forms[0]), &hyperplane(forms[1]), &hyperplane(forms[2])});
        const double move = (moved - x).norm();
        if (!(move <= error)) return x;
        error += move;
        return moved;
    }

    void add_vertices() {
        cell_.vertices.reserve(diagram_.vertices.size());
        points_.reserve(diagram_.vertices.size());
        for (const VertexId v : diagram_.vertices.ids()) {
            CellVertex& vertex = append_new(cell_.vertices);
            const Vector4d x = vertex_point(v, vertex.error);
            points_.push_back(x);
            vertex.point = problem_.frame.to_world(x.head<3>());
            vertex.radius = x.w() - problem_.radius;
            for (const FormId f : diagram_.label(v))
                for (const Site site : problem_.sites[f]) vertex.sites.push_back(site);
            for (const std::uint32_t side : diagram_.sides(v)) vertex.sites.push_back(end_site(side));
            sort_unique(vertex.sites);
        }
    }

    void add_kinds() {
        ConicKind kind(problem_, decisions_);
        kinds_.reserve(diagram_.edges.size());
        for (const MinimizationDiagram::Edge& e : diagram_.edges) {
            const bool is_conic =
                diagram_.is_circular(e.left) && !e.on_rim() && diagram_.is_circular(e.right);
            const auto functional = [&](FormId f) -> const auto& { return hyperplane(f).functional(); };
            kinds_.push_back(is_conic ? kind(e.left, e.right, functional(e.left), functional(e.right))
                             : problem_.is_sphere ? CurveKind::Spline
                                                  : kind_over_cylinder(e));
        }
        if (!problem_.family.is_all_circular()) {
            splines_.resize(diagram_.edges.size());
            errors_.resize(diagram_.edges.size());
        }
    }

    CurveKind kind_over_cylinder(const MinimizationDiagram::Edge& e) const {
        if (is_line(e)) return CurveKind::Line;
        const auto equations = axial_equations(e);
        if (!equations) return CurveKind::Spline;
        const auto& [f, g] = *equations;
        return kind_of(f, g);
    }
    double axial_size() const { return std::max(-problem_.stretch[0], problem_.stretch[1]); }
    std::optional<std::array<AxialEquation, 2>> axial_equations(const MinimizationDiagram::Edge& e) const {
        const auto of_form = [&](FormId f) {
            auto equation = axial_equation(problem_.family.radial_form(f));
            if (equation)
                equation->is_plane =
                    !is_wall(problem_, f) && std::holds_alternative<Plane>(problem_.objects[f]);
            return equation;
        };
        const auto left = of_form(e.left);
        const auto right = e.on_rim() ? axial_equation(problem_.stretch[e.side != 0]) : of_form(e.right);
        if (!left || !right) return std::nullopt;
        return std::array{*left, *right};
    }
    // Of two planes, of bisectors that are parallel to the axis, and of such as have a point of it in common.
    bool is_line(const MinimizationDiagram::Edge& e) const {
        if (e.on_rim()) return is_flat(problem_, e.left);
        if ((is_flat(problem_, e.left) && is_flat(problem_, e.right)) ||
            (is_along_axis(e.left) && is_along_axis(e.right)))
            return true;
        const auto equations = axial_equations(e);
        return equations && is_pair_of_lines((*equations)[0], (*equations)[1], axial_size());
    }
    bool is_along_axis(FormId f) const {
        const RadialForm& form = problem_.family.radial_form(f);
        return form.c[1].sign() == Sign::Zero && form.c[2].sign() == Sign::Zero && !form.has_root();
    }

    // ---- Arcs ----

    // (n, W) of a chart point with |p|^2 = L in homogeneous coordinates (p, L, w).
    Vector4d lifted(const Vector2d& p, double L, double w) const {
        const Vec3 n = problem_.chart * Vec3(2 * p.x(), 2 * p.y(), w - L);
        return {n.x(), n.y(), n.z(), w + L};
    }

    // The height is linear in (p, L, w), too: its negative.
    static double root(const CircularForm& f, const Vector2d& p, double L, double w) {
        return -(f.k * L + f.a * p.x() + f.b * p.y() + f.e * w) / f.w;
    }

    // On a circle |p|^2 is a linear function of p plus a constant, on a line it is quadratic. Either way its
    // polar form, half the derivative along the tangent in the arc's ends, is the coefficient of the middle
    // control point m: p0.(2 m - p0) = p2.(2 m - p2).
    void add_arcs() {
        conics_.reserve(2 * diagram_.edges.size());
        slices_.resize(diagram_.edges.size());
        std::vector<EdgeId> in_chart;
        for (const EdgeId e : diagram_.edges.ids()) {
            if (is_line(e) || is_spline(e) || !problem_.is_sphere) continue;
            const std::array planes{&hyperplane(diagram_.edges[e].left),
                                    &hyperplane(diagram_.edges[e].right)};
            const auto first = static_cast<std::uint32_t>(conics_.size());
            if (problem_.is_sphere && add_arc_on_sphere(e, planes))
                slices_[e] = {first, static_cast<std::uint32_t>(conics_.size())};
            else
                in_chart.push_back(e);
        }
        if (in_chart.empty()) return;
        const ChartArcs arcs(problem_.family, diagram_, in_chart);
        decisions_ += arcs.decisions();
        for (const EdgeId e : in_chart) {
            slices_[e].first = static_cast<std::uint32_t>(conics_.size());
            add_chart_arc(e, arcs.spans(e));
            slices_[e].last = static_cast<std::uint32_t>(conics_.size());
        }
    }

    void add_chart_arc(EdgeId e, std::span<const ArcSpan> arcs) {
        // The form that is evaluated with less cancellation.
        const auto magnitude = [](const CircularForm& f) {
            return (std::abs(f.k) + std::abs(f.a) + std::abs(f.b) + std::abs(f.e)) / f.w;
        };
        const CircularForm *f = &diagram_.forms[diagram_.edges[e].left],
                           *g = &diagram_.forms[diagram_.edges[e].right];
        if (magnitude(*g) < magnitude(*f)) std::swap(f, g);
        const std::array planes{&hyperplane(diagram_.edges[e].left), &hyperplane(diagram_.edges[e].right)};
        const auto end_point = [&](const Vector2d& p) -> Vector4d {
            const double L = p.squaredNorm();
            return moved_on_cone(lifted(p, L, 1) / root(*f, p, L, 1), planes);
        };
        Vector4d from = start(e).valid() ? points_[start(e)] : end_point(arcs.front().from);
        const Vector4d last = end(e).valid() ? points_[end(e)] : from;
        for (std::size_t i = 0; i < arcs.size(); ++i) {
            const ArcSpan& arc = arcs[i];
            const Vector4d to = i + 1 == arcs.size() ? last : end_point(arc.to);
            const double w = arc.weight();
            const Vector2d m = arc.middle();
            const double L = 0.5 * w * (arc.from.dot(2 * m - arc.from) + arc.to.dot(2 * m - arc.to));
            // W / t = Q: that the weights at the ends become 1.
            const double scale =
                std::sqrt(from.w() / (1 + arc.from.squaredNorm()) * to.w() / (1 + arc.to.squaredNorm()));
            const double weight = scale * root(*f, w * m, L, w);
            add_halves({from, moved(scale * lifted(w * m, L, w), weight, planes), to, weight}, {}, conics_);
            from = to;
        }
    }

    // Between two vertices, from directions alone. Not where rounding could take a short arc for all but a
    // full circle.
    bool add_arc_on_sphere(EdgeId e, const std::array<const Hyperplane*, 2>& planes) {
        if (!start(e).valid() || start(e) == end(e)) return false;
        const Vec3 normal = planes[0]->gradient() - planes[1]->gradient();
        const double length = normal.norm(),
                     size = planes[0]->gradient().norm() + planes[1]->gradient().norm();
        const Vector4d &from = points_[start(e)], &to = points_[end(e)];
        const Vec3 u = from.head<3>() / from.w(), v = to.head<3>() / to.w();
        const double radius2 = 1 - std::pow(normal.dot(u) / length, 2);
        // Output accuracy: of normals, radii (of the unit sphere) and arcs (of their circle) that are smaller
        // parts rounding would be a part of a thousand times the last digits; heights tell such arcs better.
        constexpr double least_normal = 0x1p-10, least_radius2 = 0x1p-10, least_chord2 = 0x1p-20;
        if (!(length > least_normal * size && radius2 > least_radius2 &&
              (v - u).squaredNorm() > least_chord2 * radius2))
            return false;
        add_arc_about(normal / length, from, to, planes);
        return true;
    }

    // The part of the cone over the circle's arc counter-clockwise about the unit normal, as seen from
    // outside. With the half turn a that the arc makes about the circle's centre, the control points over its
    // ends and over the point where the tangents there meet have weights t0, sqrt(t0 t1) cos a and t1 in (u,
    // 1).
    void add_arc_about(const Vec3& normal, const Vector4d& from, const Vector4d& to,
                       const std::array<const Hyperplane*, 2>& planes) {
        const Vec3 u = from.head<3>() / from.w(), v = to.head<3>() / to.w(), chord = v - u;
        const Vec3 center = normal.dot(u) * normal, middle = 0.5 * (u + v) - center;
        const double half2 = 0.25 * chord.squaredNorm(), depth2 = middle.squaredNorm(),
                     radius2 = half2 + depth2;
        const Hyperplane& plane = *planes[planes[0]->steepness() < planes[1]->steepness() ? 0 : 1];
        const Vec3 right = chord.cross(normal);
        if (middle.dot(right) > 0 && depth2 > 0.5 * radius2) {
            const double w = std::sqrt(from.w() * to.w() * depth2 / radius2);
            Vector4d apex;
            apex << w * (0.5 * (u + v) + half2 / depth2 * middle), w;
            const double weight = plane.weight(apex);
            add_halves({from, moved(apex, weight, planes), to, weight}, {}, conics_);
            return;
        }
        Vector4d half_way;
        half_way << center + std::sqrt(radius2) * right.normalized(), 1;
        half_way = moved_on_cone(half_way / plane.weight(half_way), planes);
        add_arc_about(normal, from, half_way, planes);
        add_arc_about(normal, half_way, to, planes);
    }

    // Appends a span, halved until its weights in space and in the given parameters are large enough. Numbers
    // that are none are not halved.
    static void add_halves(const ConicSpan& span, std::span<const RadialPatch* const> patches,
                           std::vector<ConicSpan>& spans, int halvings = 40) {
        const auto is_small = [&](const RadialPatch* patch) {
            return TrimSpan(*patch, span).weight() < least_weight;
        };
        if (halvings > 0 && (span.weight < least_weight || std::ranges::any_of(patches, is_small))) {
            for (const ConicSpan& half : span.halves()) add_halves(half, patches, spans, halvings - 1);
            return;
        }
        spans.push_back(span);
    }

    // The same of one whose points may lie at distances of all sizes from the axis: large weights or unequal
    // legs crowd them.
    void add_even(const ConicSpan& span, int halvings = 40) {
        constexpr double greatest_weight = 4, most_unequal = 16;
        const auto leg = [&](const Vector4d& end) {
            return (span.middle / span.weight - end).head<3>().norm();
        };
        const double from = leg(span.from), to = leg(span.to);
        const bool is_uneven =
            span.weight > greatest_weight || std::max(from, to) > most_unequal * std::min(from, to);
        if (!is_uneven || halvings == 0) return add_halves(span, {}, conics_);
        for (const ConicSpan& half : span.halves()) add_even(half, halvings - 1);
    }

    // ---- Faces and patches ----

    void add_faces() {
        cell_.faces.reserve(diagram_.face_forms.size());
        cell_faces_.resize(diagram_.face_forms.size());
        for (const FaceId id : diagram_.face_forms.ids()) {
            const FormId form = diagram_.face_forms[id];
            if (!form.valid()) continue;
            cell_faces_[id] = static_cast<std::uint32_t>(cell_.faces.size());
            CellFace& face = append_new(cell_.faces);
            face.site = main_site(form);
            face.extra_sites.assign(problem_.sites[form].begin() + 1, problem_.sites[form].end());
            face.bisector = bisector_name(problem_, form);
        }
    }

    // Calls use(edge, reversed) around a component.
    template <class Use>
    void around(CcbId ccb, Use use) const {
        const HalfEdgeId start = diagram_.dcel.start(ccb);
        HalfEdgeId h = start;
        do {
            use(Dcel::edge(h), h != Dcel::half_edge(Dcel::edge(h)));
            h = diagram_.dcel.next(h);
        } while (h != start);
    }

    // Halved until the weights are large enough.
    static void extend_by_span(Rectangle& box, const RadialPatch& patch, const ConicSpan& span,
                               int halvings = 40) {
        const TrimSpan trim(patch, span);
        const double weight = trim.weight();
        if (weight < least_weight && halvings > 0) {
            for (const ConicSpan& half : span.halves()) extend_by_span(box, patch, half, halvings - 1);
            return;
        }
        for (int i = 0; i < 2; ++i)
            extend(box[i], trim.from[i] / trim.from.z(), trim.middle[i] / trim.middle.z(),
                   trim.to[i] / trim.to.z(), weight);
    }

    // Bezier coefficients of u or v on the left of a spline's span or, reversed, on its right.
    static std::array<double, 6> trim_row(const SpaceSpan& span, bool reversed, int coordinate) {
        std::array<double, 6> row;
        for (int k = 0; k < 6; ++k) row[k] = span.points(4 + 2 * reversed + coordinate, k);
        return row;
    }

    static void extend_by_rectangle(Rectangle& box, const Rectangle& other) {
        for (int i = 0; i < 2; ++i)
            box[i] = {std::min(box[i][0], other[i][0]), std::max(box[i][1], other[i][1])};
    }

    void extend_by_trim(Rectangle& box, const RadialPatch& patch, const TrimCurve& trim) {
        const auto& p = trim.curve.points;
        if (trim.curve.degree != 2) return extend_by_rectangle(box, curve_bounds(trim.curve));
        for (std::size_t i = 0; i + 2 < p.size(); i += 2) {
            const double weight = p[i + 1].z() / std::sqrt(p[i].z() * p[i + 2].z());
            if (!(weight >= least_weight)) {
                bent_.push_back(EdgeId{*trim.edge});
                for (const ConicSpan& span : spans(EdgeId{*trim.edge})) extend_by_span(box, patch, span);
                return;
            }
            for (int k = 0; k < 2; ++k) extend(box[k], p[i][k], p[i + 1][k], p[i + 2][k], weight);
        }
    }

    // The rectangle of a face's trims. Of the loops' the largest is the outer one's, which contains the
    // others and comes first from here on.
    Rectangle face_bounds(FaceId face) {
        std::vector<std::vector<TrimCurve>>& loops = trimmed(face).loops;
        Rectangle outer{no_range, no_range};
        const auto extent = [](const Rectangle& r) { return r[0][1] - r[0][0] + (r[1][1] - r[1][0]); };
        for (std::size_t i = 0; i < loops.size(); ++i) {
            Rectangle box{no_range, no_range};
            for (const TrimCurve& trim : loops[i]) extend_by_trim(box, patches_[face], trim);
            if (i > 0 && !(extent(box) > extent(outer))) continue;
            outer = box;
            std::swap(loops[0], loops[i]);
            std::swap(loops_[face][0], loops_[face][i]);
        }
        widen(outer);
        return outer;
    }

    // A face thinner than the spacing of doubles still needs a domain that has two ends.
    static void widen(Rectangle& box) {
        for (Range& range : box)
            if (range[0] == range[1])
                range[1] = std::nextafter(range[1], std::numeric_limits<double>::infinity());
    }

    // Somewhere in the face, or among its loops: a unit normal.
    Vec3 middle(FaceId face) const {
        Vec3 sum = Vec3::Zero();
        for (const CcbId ccb : loops_[face])
            around(ccb, [&](EdgeId e, bool) {
                for (const ConicSpan& s : spans(e)) sum += s.from.head<3>() / s.from.w();
                if (start(e).valid()) sum += points_[start(e)].head<3>() / points_[start(e)].w();
                for (const auto& piece : diagram_.pieces(e)) sum += problem_.normal(piece.end);
            });
        return sum.isZero(0) ? Vec3::UnitZ() : sum.normalized();
    }

    void add_patches() {
        const std::size_t count = diagram_.dcel.face_count();
        loops_.resize(count);
        roundings_.resize(count, 0);
        is_flat_.resize(problem_.objects.size());
        patches_.reserve(count);
        for (const FaceId face : diagram_.face_forms.ids()) {
            const FormId form = diagram_.face_forms[face];
            if (!form.valid()) {
                patches_.push_back({});
                continue;
            }
            is_flat_[form] = is_flat(problem_, form);
            const std::vector<CcbId>& inner = diagram_.dcel.inner_ccbs(face);
            loops_[face].assign(inner.begin(), inner.end());
            if (const CcbId outer = diagram_.dcel.outer_ccb(face); outer.valid())
                loops_[face].push_back(outer);
            if (problem_.is_sphere) {
                patches_.push_back(RadialPatch(problem_, form, middle(face), 0));
            } else {
                patches_.push_back({});
                add_cylinder_patch(face);
            }
        }
    }

    // A spline's trims are fitted to the patches, and whether a patch holds its face is known from the trims.
    void add_surfaces() {
        std::vector<FaceId> all;
        all.reserve(patches_.size());
        for (const FaceId face : diagram_.face_forms.ids())
            if (diagram_.face_forms[face].valid()) all.push_back(face);
        std::vector<EdgeId> to_fit;
        for (const EdgeId e : diagram_.edges.ids())
            if (depends_on_patches(e)) to_fit.push_back(e);
        effort_.spans += 500 * to_fit.size();
        if (problem_.is_sphere && !to_fit.empty())
            for (const FaceId face : all)
                if (!holds_vertices(face)) change_patch(face);
        for (std::vector<FaceId> to_make = all, again; !to_make.empty(); std::swap(to_make, again)) {
            for (const EdgeId e : to_fit) fit(e);
            if (to_make.size() == all.size() && is_coarse())
                for (const EdgeId e : to_fit) fit(e);
            to_fit.clear();
            seams_ = 0;
            again.clear();
            for (const FaceId face : to_make) {
                if (add_surface(face)) continue;
                change_patch(face);
                again.push_back(face);
                for (const CcbId ccb : loops_[face])
                    around(ccb, [&](EdgeId e, bool) {
                        if (depends_on_patches(e)) to_fit.push_back(e);
                    });
            }
            sort_unique(to_fit);
            if (problem_.is_sphere) {
                for (const EdgeId e : to_fit)
                    for (const unsigned side : {0u, 1u})
                        again.push_back(diagram_.dcel.face(Dcel::half_edge(e, side)));
                sort_unique(again);
            } else if (!again.empty()) {
                again = all;  // seams are numbered through
            }
        }
        for (const EdgeId e : diagram_.edges.ids()) require_proof(e);
        for (const FaceId face : diagram_.face_forms.ids())
            if (is_cut(face)) cell_.faces[cell_faces_[face]].patches = std::move(sectors_[face].parts);
    }

    // The box says little of how far the cell reaches, which may be less than the tolerance: curves have to
    // be four digits finer than that. What the curves themselves say of it serves, coarse as they are.
    bool is_coarse() {
        double reach = 0;
        for (const Vector4d& p : points_) reach = std::max(reach, p.w());
        for (const ConicSpan& s : conics_) reach = std::max(reach, s.from.w());
        for (const std::vector<SpaceSpan>& spans : splines_)
            for (const SpaceSpan& s : spans) reach = std::max(reach, s.points.row(3).maxCoeff());
        const double fine = 1e-4 * reach;
        if (!(fine < tolerance_ && fine > 0)) return false;
        tolerance_ = fine;
        return true;
    }

    // Beyond this a bound says as good as nothing.
    double most_error() const { return 256 * tolerance_; }
    // A spline that is not proved to follow its arc is none.
    void require_proof(EdgeId e) const {
        if (!is_spline(e) || errors_[e].curve + errors_[e].trims <= most_error()) return;
        throw unproved(e, "no curve is proved to be the one between them",
                       problem_.frame.to_world(errors_[e].unproved.value_or(errors_[e].worst)));
    }
    UndecidedError unproved(EdgeId e, const char* what, const Vec3& place) const {
        const MinimizationDiagram::Edge& edge = diagram_.edges[e];
        const Site left = main_site(edge.left),
                   right = edge.on_rim() ? end_site(edge.side) : main_site(edge.right);
        return UndecidedError("objects " + to_string(left) + ", " + to_string(right) + ": " + what +
                              " around " + to_text(Vec3(problem_.unit * place)));
    }
    void require_proofs(FaceId face) const {
        for (const CcbId ccb : loops_[face]) around(ccb, [&](EdgeId e, bool) { require_proof(e); });
    }
    UndecidedError undecided(FaceId face) const {
        return UndecidedError("object " + to_string(main_site(diagram_.face_forms[face])) +
                              ": no patches hold its face in the direction " +
                              to_text(Vec3(problem_.frame.rotation.transpose() * middle(face))));
    }

    // Splines for their trims, conics over a cylinder for the sectors that they run through.
    bool depends_on_patches(EdgeId e) const { return is_spline(e) || (!problem_.is_sphere && !is_line(e)); }

    // Of a face that is not cut.
    TrimmedPatch& trimmed(FaceId face) {
        std::vector<TrimmedPatch>& patches = cell_.faces[cell_faces_[face]].patches;
        if (patches.empty()) append_new(patches);
        return patches.front();
    }

    // Trims for a patch that does not even do that are not worth fitting.
    bool holds_vertices(FaceId face) const {
        Rectangle box{no_range, no_range};
        for (const CcbId ccb : loops_[face])
            around(ccb, [&](EdgeId e, bool) {
                if (!start(e).valid()) return;
                const Vec2 p = patches_[face].parameters(Vec3(points_[start(e)].head<3>()));
                extend_by_rectangle(box, {{{p.x(), p.x()}, {p.y(), p.y()}}});
            });
        double rounding;
        return box[0][0] > box[0][1] || patches_[face].patch(box[0], box[1], problem_.frame, rounding);
    }

    std::vector<std::vector<TrimCurve>> trims(FaceId face) const {
        std::vector<std::vector<TrimCurve>> loops;
        loops.reserve(loops_[face].size());
        for (const CcbId ccb : loops_[face]) {
            std::vector<TrimCurve>& loop = loops.emplace_back();
            std::size_t length = 0;
            around(ccb, [&](EdgeId, bool) { ++length; });
            loop.reserve(length);
            around(ccb,
                   [&](EdgeId e, bool reversed) { set_trim(patches_[face], e, reversed, append_new(loop)); });
        }
        return loops;
    }

    bool add_surface(FaceId face) {
        if (is_cut(face)) return add_cut_surfaces(face);
        if (lacks_digits(face)) return false;
        trimmed(face).loops = trims(face);
        const auto [box_u, box_v] = face_bounds(face);
        std::optional<RationalPatch> surface =
            patches_[face].patch(box_u, box_v, problem_.frame, roundings_[face]);
        if (surface && roundings_[face] > enough_digits())
            roundings_[face] = rounding_along(patches_[face], {box_u, box_v}, trimmed(face).loops);
        if (surface) trimmed(face).surface = std::move(*surface);
        return surface.has_value();
    }

    // Seen from the base's centre points of a needle have nearly one direction: what its patch makes of trims
    // in doubles may be anything.
    bool lacks_digits(FaceId face) const {
        if (patches_[face].kind() != RadialPatch::Kind::Stereographic) return false;
        const auto is_lost = [&](EdgeId e) {
            return is_spline(e) && !(errors_[e].curve + errors_[e].trims <= 2 * tolerance_);
        };
        bool lacks = false;
        for (const CcbId ccb : loops_[face])
            around(ccb, [&](EdgeId e, bool) { lacks = lacks || is_lost(e); });
        return lacks;
    }

    // Patches that are rounded by less need no closer look.
    double enough_digits() const { return tolerance_ / 16; }
    double rounding_along(const RadialPatch& patch, const Rectangle& box,
                          const std::vector<std::vector<TrimCurve>>& loops) const {
        double most = 0;
        for (const std::vector<TrimCurve>& loop : loops)
            for (const TrimCurve& trim : loop)
                if (trim.edge)
                    most = std::max(most, patch.rounding_along(trim.curve, box[0], box[1], problem_.frame,
                                                               enough_digits()));
        return most;
    }

    // After a patch with a weight that is not positive.
    void change_patch(FaceId face) {
        if (!problem_.is_sphere) return cut_finer(face);
        if (!wide_.empty() && wide_[face]) {
            require_proofs(face);
            throw undecided(face);
        }
        wide_.resize(patches_.size());
        wide_[face] = true;
        patches_[face] = RadialPatch(problem_, diagram_.face_forms[face], middle(face), 0, true);
    }

    // ---- Faces over a cylinder ----

    // The part of the base between two angles of the chart, with a patch of its own.
    struct Sector {
        double from, to;
        RadialPatch patch;

        double reach() const { return std::tan(0.25 * (to - from)); }
    };
    // The sectors of a face, once around; whole faces have none.
    struct Sectors {
        std::vector<Sector> sectors;
        std::vector<TrimmedPatch> parts;
        std::vector<bool> is_too_wide;  // of each sector
        int failed_cuts = 0;
    };
    // A face that turns further than this has several patches.
    static constexpr double widest_patch = 4;
    static constexpr double narrowest_sector = 0x1p-10;
    static constexpr int most_failed_cuts = 3;
    // Where symmetric input has no points in which an edge touches a generator: a seam there would run along
    // the edge as far as doubles tell.
    static constexpr double off_middle = 0.48643;

    bool is_cut(FaceId face) const { return !sectors_.empty() && !sectors_[face].sectors.empty(); }

    static double chart_angle(double x) {
        return x > 1 ? std::numbers::pi + 2 * std::atan(x - 2) : 2 * std::atan(x);
    }
    Vec3 direction(double angle) const { return problem_.chart * Vec3(std::sin(angle), 0, std::cos(angle)); }

    // What a face covers: angles in the chart, continuously, and the mean height of its boundary.
    struct Extent {
        double from = 0, to = 0, y = 0;
        bool is_closed = false;  // all around
    };

    Extent extent(FaceId face) const {
        Extent widest;
        double sum_y = 0;
        int points = 0;
        for (const CcbId ccb : loops_[face]) {
            Extent loop;
            double angle = 0;
            bool is_first = true;
            const auto go_to = [&](const Vec2& p) {
                const double next = chart_angle(p.x());
                const double turn = next - angle, whole = 2 * std::numbers::pi;
                angle = is_first ? next : angle + std::remainder(turn, whole);
                if (is_first) loop.from = loop.to = angle;
                is_first = false;
                loop.from = std::min(loop.from, angle);
                loop.to = std::max(loop.to, angle);
                sum_y += p.y();
                ++points;
            };
            const auto point = [&](VertexId v) { return diagram_.vertices[v].point; };
            double begin = 0;
            around(ccb, [&](EdgeId e, bool reversed) {
                const VertexId from = reversed ? end(e) : start(e), to = reversed ? start(e) : end(e);
                const auto pieces = diagram_.pieces(e);
                if (is_first) {
                    if (from.valid())
                        go_to(point(from));
                    else if (!pieces.empty())
                        go_to(pieces.back().end);
                    begin = angle;
                }
                if (const auto& edge = diagram_.edges[e]; edge.on_rim()) {
                    // The lower rim goes with the angle, the upper one against it, once around at most.
                    const double sign = edge.side == 0 ? 1 : -1;
                    angle += sign * rim_turn(from, to, sign);
                    is_first = false;
                    loop.from = std::min(loop.from, angle);
                    loop.to = std::max(loop.to, angle);
                    sum_y += problem_.stretch[edge.side == 0 ? 0 : 1];
                    ++points;
                    return;
                }
                for (std::size_t i = 0; i + 1 < pieces.size(); ++i)
                    go_to(pieces[reversed ? pieces.size() - 2 - i : i].end);
                go_to(to.valid() ? point(to) : Vec2(pieces.back().end));
            });
            loop.is_closed = std::abs(angle - begin) > std::numbers::pi;
            if (loop.is_closed || (!widest.is_closed && !(loop.to - loop.from < widest.to - widest.from)))
                widest = loop;
        }
        widest.y = sum_y / std::max(points, 1);
        return widest;
    }

    // By how much the angle changes, in the direction of the sign, from one vertex of a rim to the next: so
    // little, maybe, that only their coordinates tell it from a whole turn.
    double rim_turn(VertexId from, VertexId to, double sign) const {
        constexpr double whole = 2 * std::numbers::pi;
        if (from == to) return whole;
        const double x = diagram_.vertices[from].point.x(), end = diagram_.vertices[to].point.x();
        const double turn = sign * (chart_angle(end) - chart_angle(x));
        if (turn == 0 && sign * (end - x) > 0) return std::numeric_limits<double>::min();
        return turn > 0 ? turn : turn + whole;
    }

    void add_cylinder_patch(FaceId face) {
        sectors_.resize(patches_.size());
        const Extent e = extent(face);
        const double middle = 0.5 * (e.from + e.to);
        patches_[face] = RadialPatch(problem_, diagram_.face_forms[face], direction(middle), e.y);
        if (patches_[face].kind() == RadialPatch::Kind::Planar) return;
        if (patches_[face].half()) {
            const double off = std::abs(std::remainder(middle - half_angle(face), 2 * std::numbers::pi));
            if (e.is_closed || off + 0.5 * (e.to - e.from) > 0.5 * std::numbers::pi * (1 + 0x1p-20))
                cut(face);
        } else if (e.is_closed || e.to - e.from > widest_patch) {
            cut(face);
        }
    }

    // The middle of the half that a face's patch is for.
    double half_angle(FaceId face) const {
        const Vec3 axis = problem_.chart.transpose() * *patches_[face].half();
        return std::atan2(axis.x(), axis.z());
    }

    // Into two halves: those that patches are for, if they are for a half.
    void cut(FaceId face) {
        constexpr double pi = std::numbers::pi;
        const double start = patches_[face].half() ? half_angle(face) - 0.5 * pi : clear_angle(face, 2);
        for (const double from : {start, start + pi})
            sectors_[face].sectors.push_back(sector(face, from, from + pi));
    }

    Sector sector(FaceId face, double from, double to) const {
        const Vec3 middle = direction(0.5 * (from + to));
        const double y = mean_height(face, from, to);
        return {
            from, to,
            RadialPatch(problem_, diagram_.face_forms[face], middle, y, patches_[face].half().has_value())};
    }

    // Of the points of a face's boundary over a sector; of all of them where there are none.
    double mean_height(FaceId face, double from, double to) const {
        std::array<double, 2> sum{}, count{};
        const auto add = [&](const Vec2& p) {
            const double off = chart_angle(p.x()) - 0.5 * (from + to);
            const bool is_over = std::abs(std::remainder(off, 2 * std::numbers::pi)) <= 0.5 * (to - from);
            sum[is_over] += p.y();
            ++count[is_over];
        };
        for (const CcbId ccb : loops_[face])
            around(ccb, [&](EdgeId e, bool) {
                if (start(e).valid()) add(diagram_.vertices[start(e)].point);
                for (const auto& piece : diagram_.pieces(e)) add(piece.end);
            });
        if (count[1] > 0) return sum[1] / count[1];
        return count[0] > 0 ? sum[0] / count[0] : 0.5 * (problem_.stretch[0] + problem_.stretch[1]);
    }

    // After patches whose weights are not positive all over a face's rectangle. Narrower sectors have smaller
    // ones; and patches that are for a half each keep away from what lies at infinity.
    void cut_finer(FaceId face) {
        Sectors& all = sectors_[face];
        if (!is_cut(face)) {
            const Extent e = extent(face);
            const Vec3 middle = direction(0.5 * (e.from + e.to));
            patches_[face] = RadialPatch(problem_, diagram_.face_forms[face], middle, e.y, true);
            return cut(face);
        }
        std::vector<Sector> finer;
        for (std::size_t i = 0; i < all.sectors.size(); ++i) {
            const auto& [from, to, patch] = all.sectors[i];
            if (!all.is_too_wide[i]) {
                finer.push_back(all.sectors[i]);
                continue;
            }
            if (to - from < narrowest_sector) throw undecided(face);
            const double inside = std::lerp(from, to, off_middle);
            finer.push_back(sector(face, from, inside));
            finer.push_back(sector(face, inside, to));
        }
        all.sectors = std::move(finer);
    }

    // Where the sides of `count` sectors keep furthest from the face's vertices.
    double clear_angle(FaceId face, std::size_t count) const {
        const double width = 2 * std::numbers::pi / static_cast<double>(count);
        std::vector<double> angles;
        for (const CcbId ccb : loops_[face])
            around(ccb, [&](EdgeId e, bool) {
                if (!start(e).valid()) return;
                const double angle = chart_angle(diagram_.vertices[start(e)].point.x());
                angles.push_back(angle - width * std::floor(angle / width));
            });
        if (angles.empty()) return off_middle;
        std::ranges::sort(angles);
        angles.push_back(angles.front() + width);
        std::size_t widest = 0;
        for (std::size_t i = 0; i + 1 < angles.size(); ++i)
            if (angles[i + 1] - angles[i] > angles[widest + 1] - angles[widest]) widest = i;
        return std::lerp(angles[widest], angles[widest + 1], off_middle);
    }

    // Through the angles of the chart over its start, over where it leaves a sector, and over its end.
    void add_axial_conic(EdgeId e) {
        const auto equations = axial_equations(diagram_.edges[e]);
        const AxialConic conic(problem_, (*equations)[0], (*equations)[1]);
        const std::vector<double> angles = angles_along(e);
        const auto first = static_cast<std::uint32_t>(conics_.size());
        Vector4d from = start(e).valid() ? points_[start(e)] : conic.at(direction(angles.front()));
        const Vector4d last = end(e).valid() ? points_[end(e)] : from;
        for (std::size_t i = 1; i < angles.size(); ++i) {
            const Vector4d to = i + 1 == angles.size() ? last : conic.at(direction(angles[i]));
            add_even(conic.between(from, to));
            from = to;
        }
        slices_[e] = {first, static_cast<std::uint32_t>(conics_.size())};
    }

    // Monotonic, as the conic has one point over every angle. An end so near to a seam counts as on it.
    std::vector<double> angles_along(EdgeId e) const {
        constexpr double pi = std::numbers::pi, widest = pi / 3, near = 0x1p-32;
        const auto [from, turn] = turn_along(e);
        std::vector<double> parts;
        const auto count = static_cast<int>(std::ceil(std::abs(turn) / widest));
        for (int i = 1; i < count; ++i) parts.push_back(std::abs(turn) * i / count);
        for (const unsigned side : {0u, 1u}) {
            const FaceId face = diagram_.dcel.face(Dcel::half_edge(e, side));
            if (!diagram_.face_forms[face].valid() || !is_cut(face)) continue;
            for (const Sector& s : sectors_[face].sectors) {
                double part = std::fmod(turn < 0 ? from - s.from : s.from - from, 2 * pi);
                if (part < 0) part += 2 * pi;
                if (part > near && part < std::abs(turn) - near) parts.push_back(part);
            }
        }
        sort_unique(parts);
        std::vector<double> angles{from};
        for (const double part : parts) angles.push_back(from + std::copysign(part, turn));
        angles.push_back(from + turn);
        return angles;
    }

    // The angle over an edge's start, and by how much it changes.
    std::array<double, 2> turn_along(EdgeId e) const {
        constexpr double whole = 2 * std::numbers::pi;
        const MinimizationDiagram::Edge& edge = diagram_.edges[e];
        const auto pieces = diagram_.pieces(e);
        const auto angle = [&](VertexId v) { return chart_angle(diagram_.vertices[v].point.x()); };
        if (edge.on_rim()) {  // with the angle on the lower end, against it on the upper one
            const double sign = edge.side == 0 ? 1 : -1;
            if (!start(e).valid()) return {0, sign * whole};
            return {angle(start(e)), sign * rim_turn(start(e), end(e), sign)};
        }
        const double from = start(e).valid() ? angle(start(e)) : chart_angle(pieces.back().end.x());
        double turn = 0, last = from;
        for (std::size_t i = 0; i < pieces.size(); ++i) {
            const bool is_end = i + 1 == pieces.size() && end(e).valid();
            const double next = is_end ? angle(end(e)) : chart_angle(pieces[i].end.x());
            turn += std::remainder(next - last, whole);
            last = next;
        }
        return {from, turn};
    }

    // The face's loops as runs of spans within one sector.
    std::vector<std::vector<BoundaryRun>> boundary_runs(FaceId face) const {
        std::vector<std::vector<BoundaryRun>> loops;
        for (const CcbId ccb : loops_[face]) {
            std::vector<BoundaryRun>& loop = loops.emplace_back();
            around(ccb, [&](EdgeId e, bool reversed) {
                if (is_line(e)) {
                    const Vec3 p = 0.5 * (points_[start(e)] + points_[end(e)]).head<3>();
                    const bool rises = points_[start(e)].y() < points_[end(e)].y();
                    const std::uint32_t sector = sector_of(face, p, rises != reversed);
                    const RadialPatch& patch = sectors_[face].sectors[sector].patch;
                    loop.push_back({{}, sector});
                    set_trim(patch, e, reversed, loop.back().trim);
                    return;
                }
                const std::size_t n = is_spline(e) ? splines_[e].size() : spans(e).size();
                const auto sector = [&](std::size_t i) {
                    const std::size_t k = reversed ? n - 1 - i : i;
                    if (is_spline(e)) return splines_[e][k].part[reversed];
                    const ConicSpan& s = spans(e)[k];
                    return sector_of(face, (s.from + 2 * s.middle + s.to).head<3>() / (2 + 2 * s.weight),
                                     (s.from.y() < s.to.y()) != reversed);
                };
                for (std::size_t first = 0, last; first < n; first = last) {
                    last = first + 1;
                    while (last < n && sector(last) == sector(first)) ++last;
                    loop.push_back({{e.value, {}, reversed, {}}, sector(first)});
                    RationalCurve2& curve = loop.back().trim.curve;
                    if (is_spline(e))
                        set_spline_trim(e, reversed, first, last, curve);
                    else
                        set_conic_trim(sectors_[face].sectors[sector(first)].patch, e, reversed, first, last,
                                       curve);
                }
            });
        }
        return loops;
    }

    // Of a point of its boundary, which rises there with the face on its left or falls.
    std::uint32_t sector_of(FaceId face, const Vec3& p, bool rises) const {
        const std::vector<Sector>& all = sectors_[face].sectors;
        const double inwards = rises ? -seam_inwards : seam_inwards;
        const auto outside = [&](const Sector& s) {
            return std::abs(s.patch.parameters(p).x() + inwards) - s.reach();
        };
        return static_cast<std::uint32_t>(std::ranges::min_element(all, {}, outside) - all.begin());
    }

    bool add_cut_surfaces(FaceId face) {
        Sectors& all = sectors_[face];
        std::vector<double> reaches;
        for (const Sector& s : all.sectors) reaches.push_back(s.reach());
        all.parts.clear();
        roundings_[face] = 0;
        all.is_too_wide.assign(all.sectors.size(), false);
        const std::uint32_t first_seam = seams_;
        std::optional<std::vector<CutPart>> parts = cut_face(boundary_runs(face), reaches, seams_);
        if (!parts) {  // elsewhere the seams may be clear of its edges
            require_proofs(face);
            if (++all.failed_cuts > most_failed_cuts) throw undecided(face);
            all.is_too_wide.assign(all.sectors.size(), true);
            return false;
        }
        match_seams(all, *parts, first_seam);
        for (CutPart& part : *parts) {
            Rectangle box{no_range, no_range};
            for (const TrimCurve& trim : part.loops.front())
                extend_by_rectangle(box, curve_bounds(trim.curve));
            widen(box);
            const RadialPatch& patch = all.sectors[part.sector].patch;
            double rounding = 0;
            auto surface = patch.patch(box[0], box[1], problem_.frame, rounding);
            if (!surface) {
                all.is_too_wide[part.sector] = true;
                continue;
            }
            if (rounding > enough_digits()) rounding = rounding_along(patch, box, part.loops);
            roundings_[face] = std::max(roundings_[face], rounding);
            all.parts.push_back({std::move(*surface), std::move(part.loops)});
        }
        return std::ranges::find(all.is_too_wide, true) == all.is_too_wide.end();
    }

    // A generator's conic has v as a rational parameter for either sign of d, so where the signs differ on
    // the two sides of a seam one v is a quotient of linear functions of the other: a straight piece with a
    // weight.
    void match_seams(const Sectors& all, std::vector<CutPart>& parts, std::uint32_t first_seam) const {
        struct Side {
            RationalCurve2* curve = nullptr;
            const RadialPatch* patch = nullptr;
        };
        std::vector<std::array<Side, 2>> sides(seams_ - first_seam);  // u > 0, u < 0
        for (CutPart& part : parts)
            for (std::vector<TrimCurve>& loop : part.loops)
                for (TrimCurve& trim : loop)
                    if (trim.seam)
                        sides[*trim.seam - first_seam][trim.curve.points[0].x() < 0] = {
                            &trim.curve, &all.sectors[part.sector].patch};
        for (const auto& [left, right] : sides) {
            if (left.patch->along() == right.patch->along()) continue;
            const Vec2 half_way = 0.5 * (left.curve->points[0] + left.curve->points[1]).head<2>();
            const double v = right.patch->parameters((*left.patch)(half_way)).y();
            auto& points = right.curve->points;
            points[1].z() = (v - points[0].y()) / (points[1].y() - v);
        }
    }

    // ---- Edges that are no conics ----

    static PatchCoordinates coordinates(const RadialPatch& patch, double delta) {
        using Kind = RadialPatch::Kind;
        const auto& [x, y, z] = patch.axes();
        if (patch.kind() == Kind::Planar)
            return {PatchCoordinate::linear(x, patch.origin()), PatchCoordinate::linear(y, patch.origin())};
        if (patch.kind() == Kind::Confocal) {
            PatchCoordinate focal;
            focal.numerator << z, 1, 0;
            return {focal, PatchCoordinate::linear(y, patch.origin())};
        }
        if (patch.kind() == Kind::Stereographic)
            return {PatchCoordinate::half_angle(patch.origin(), z, x, 0),
                    PatchCoordinate::half_angle(patch.origin(), z, y, 0)};
        PatchCoordinate along;
        along.numerator << patch.along(), 0, patch.along_start();
        const double reach = patch.kind() == Kind::AboutObject ? delta : 0;
        return {PatchCoordinate::half_angle(patch.origin(), x, y, reach), along};
    }

    SpaceSite space_site(HalfEdgeId h, FormId form) const {
        const FaceId face = diagram_.dcel.face(h);
        const Object& object = problem_.objects[form];
        const auto* cylinder = std::get_if<Cylinder>(&object);
        const double delta = cylinder != nullptr ? cylinder->radius - problem_.radius : 0;
        SpaceSite site{object, !main_site(form).is_object(), {}};
        if (!is_cut(face)) {
            site.parts.push_back({.patch = coordinates(patches_[face], delta), .surface = &patches_[face]});
            return site;
        }
        for (const Sector& s : sectors_[face].sectors)
            site.parts.push_back({coordinates(s.patch, delta), {-s.reach(), s.reach()}, &s.patch});
        return site;
    }

    std::optional<SpaceEnd> space_end(VertexId v) const {
        if (!v.valid()) return std::nullopt;
        return SpaceEnd{points_[v].head<3>(), cell_.vertices[v.value].error};
    }

    void fit(EdgeId e) {
        if (!is_spline(e)) return add_axial_conic(e);
        const MinimizationDiagram::Edge& edge = diagram_.edges[e];
        SpaceArc arc{{space_site(Dcel::half_edge(e), edge.left), {}},
                     space_end(start(e)),
                     space_end(end(e)),
                     diagram_.pieces(e)};
        if (edge.on_rim()) {
            arc.sites[1] = end_wall(edge.side);
            arc.turn = std::abs(turn_along(e)[1]);
        } else {
            arc.sites[1] = space_site(Dcel::half_edge(e, 1), edge.right);
            arc.sites_cross = problem_.cross_equally(edge.left, edge.right);
        }
        splines_[e].clear();
        errors_[e] = fit_space_spline(problem_, arc, tolerance_, splines_[e], effort_);
    }

    void halve_for_trims() {
        sort_unique(bent_);
        std::vector<ConicSpan> halved;
        for (const EdgeId e : bent_) {
            halved.clear();
            for (const ConicSpan& span : spans(e))
                add_halves(span, std::array{&left_patch(e), &right_patch(e)}, halved);
            const auto first = static_cast<std::uint32_t>(conics_.size());
            conics_.insert(conics_.end(), halved.begin(), halved.end());
            slices_[e] = {first, static_cast<std::uint32_t>(conics_.size())};
            for (const unsigned side : {0u, 1u}) {
                const FaceId face = diagram_.dcel.face(Dcel::half_edge(e, side));
                for (std::vector<TrimCurve>& loop : trimmed(face).loops)
                    for (TrimCurve& trim : loop)
                        if (trim.edge == e.value) set_trim(patches_[face], e, trim.reversed, trim);
            }
        }
    }

    const RadialPatch& left_patch(EdgeId e) const { return patches_[diagram_.dcel.face(Dcel::half_edge(e))]; }
    const RadialPatch& right_patch(EdgeId e) const {
        return patches_[diagram_.dcel.face(Dcel::half_edge(e, 1))];
    }

    // ---- Output ----

    void add_edges() {
        cell_.edges.reserve(diagram_.edges.size());
        positions_.reserve(diagram_.edges.size());
        for (const EdgeId e : diagram_.edges.ids()) {
            const MinimizationDiagram::Edge& from = diagram_.edges[e];
            CellEdge& edge = append_new(cell_.edges);
            edge.sites = {main_site(from.left), from.on_rim() ? end_site(from.side) : main_site(from.right)};
            for (const FormId f : diagram_.label(e))
                for (const Site site : problem_.sites[f])
                    if (site != edge.sites[0] && site != edge.sites[1]) edge.extra_sites.push_back(site);
            sort_unique(edge.extra_sites);
            if (is_line(e) && !from.on_rim()) add_generator_ties(e, edge);
            if (start(e).valid()) edge.vertices = {start(e).value, end(e).value};
            edge.kind = kinds_[e];
            set_space_curve(e, edge.curve);
            set_error(e, edge);
        }
    }

    // The true edge ends in the true vertices, up to which the curve that was compared may be continued:
    // their errors count twice. The trims are compared with the space curve on patches as computed, whose
    // control points are rounded; and all of it is moved back, as for vertices.
    void set_error(EdgeId e, CellEdge& edge) {
        double square = origin_ * origin_, end_error = 0;
        for (const Vector4d& p : edge.curve.points) square = std::max(square, p.head<3>().squaredNorm());
        const double far = std::sqrt(square);
        for (const std::uint32_t v : edge.vertices) end_error = std::max(end_error, cell_.vertices[v].error);
        const double rounding = 16 * u * (far + origin_);
        double off, trims;
        if (is_spline(e)) {
            off = errors_[e].curve + end_error;
            trims = errors_[e].trims;
        } else {
            std::optional<std::array<DistancePlane, 2>> planes;
            if (!is_line(e)) planes = distance_planes(e);
            off = planes ? curve_error(e, *planes) + 2 * end_error : end_error;
            trims = trims_error(e, off + 4 * rounding, planes);
        }
        // Nothing of the cell is farther away than its box, which holds the base.
        const double most = 4 * far;
        double of_patches = 0;
        for (const unsigned side : {0u, 1u})
            of_patches = std::max(of_patches, roundings_[diagram_.dcel.face(Dcel::half_edge(e, side))]);
        if (of_patches > most_error())
            throw unproved(e, "rounding leaves few digits of their faces",
                           edge.curve.points.front().head<3>());
        positions_.push_back(std::min(most, off + rounding));
        edge.error = std::min(most, std::max(off, trims) + of_patches + rounding);
    }

    std::array<DistancePlane, 2> distance_planes(EdgeId e) {
        const MinimizationDiagram::Edge& edge = diagram_.edges[e];
        if (problem_.is_sphere) return {hyperplane(edge.left).plane(), hyperplane(edge.right).plane()};
        const auto equations = axial_equations(edge);
        return AxialConic(problem_, (*equations)[0], (*equations)[1]).planes();
    }
    double curve_error(EdgeId e, const std::array<DistancePlane, 2>& planes) const {
        // The difference of forms that are nearly alike has all its digits, and tells the edge.
        constexpr double nearly_alike = 1 - 0x1p-33;
        if (!problem_.is_sphere || !(std::abs(planes[0].normal.dot(planes[1].normal)) > nearly_alike))
            return conic_distance(spans(e), planes, problem_.is_sphere);
        const DistancePlane difference = difference_plane(diagram_.edges[e].left, diagram_.edges[e].right);
        return conic_distance(spans(e), {planes[0], difference}, problem_.is_sphere);
    }

    // In the chart -1 / t is (K (1 - z) + A x + B y + C (1 + z)) / 2 W at the unit normal (x, y, z). So
    // A x + B y + (C - K) z + (C + K) t = -2 W at the points (p, t), and two of these leave a plane through
    // 0.
    DistancePlane difference_plane(FormId f, FormId g) const {
        const ExactForm F = problem_.family.exact(f), G = problem_.family.exact(g);
        const Exact A = F.A * G.W - G.A * F.W, B = F.B * G.W - G.B * F.W, C = F.C * G.W - G.C * F.W,
                    K = F.K * G.W - G.K * F.W;
        const std::array n{A, B, C - K, C + K};
        long size = std::numeric_limits<long>::min();
        for (const Exact& x : n)
            if (x.sign() != Sign::Zero) size = std::max(size, x.exponent());
        const auto scaled = [size](const Exact& x, long power) {
            return x.scaled(-power * size).enclosure().mid();
        };
        Vector4d normal(scaled(n[0], 1), scaled(n[1], 1), scaled(n[2], 1), scaled(n[3], 1));
        const double length = normal.norm();
        normal.head<3>() = (problem_.chart * normal.head<3>()).eval();
        return {normal / length, 0, scaled(A * A + B * B - Exact(4.0) * C * K, 2) / (length * length)};
    }

    // How far the trims of a line or conic are from it; off: what its points may be off the bisectors. The
    // edge's planes are found where there are none yet.
    double trims_error(EdgeId e, double off, std::optional<std::array<DistancePlane, 2>>& planes) {
        const MinimizationDiagram::Edge& edge = diagram_.edges[e];
        double most = off;
        if (is_line(e) && (problem_.is_sphere || !axial_equations(edge))) return most;
        std::vector<ConicSpan> segment;
        std::span<const ConicSpan> along = spans(e);
        if (is_line(e)) {
            // The rays' slopes are those of one generator, best told far from the axis.
            const Vector4d &from = points_[start(e)], &to = points_[end(e)];
            const Vector4d& far = from.w() > to.w() ? from : to;
            segment.push_back({far, far, far, 1});
            along = segment;
        }
        for (const unsigned side : {0u, 1u}) {
            if (side == 1 && edge.on_rim()) continue;
            const FormId form = side == 0 ? edge.left : edge.right;
            if (is_flat_[form]) continue;
            if (!planes) planes = distance_planes(e);
            // Rays that graze the bisector tell little of where a point of it is.
            constexpr double grazing = 64;
            const double gain = ray_gain(along, (*planes)[side], problem_.is_sphere);
            double trim = (1 + gain) * off;
            if (gain > grazing && problem_.is_sphere) trim = std::min(trim, trim_distance_of(e, side, along));
            most = std::max(most, trim);
        }
        return most;
    }
    double trim_distance_of(EdgeId e, unsigned side, std::span<const ConicSpan> along) const {
        const RadialPatch& patch = patches_[diagram_.dcel.face(Dcel::half_edge(e, side))];
        double most = 0;
        for (const ConicSpan& span : along) {
            const TrimSpan trim(patch, span);
            most = std::max(most, trim_distance(patch, span, {trim.from, trim.middle, trim.to}));
        }
        return most;
    }

    // Two forms change places over one generator as the angle grows, and back over the other they have in
    // common.
    void add_generator_ties(EdgeId e, CellEdge& edge) {
        const Vector4d &from = points_[start(e)], &to = points_[end(e)];
        const bool is_upward = from.y() < to.y();
        const FormId left = diagram_.edges[e].left, right = diagram_.edges[e].right;
        bool is_decided = true;
        for (const RadialBaseProblem::GeneratorTie& tie : problem_.generator_ties) {
            if (tie.before != (is_upward ? left : right) || tie.after != (is_upward ? right : left)) continue;
            is_decided = is_decided && tie.is_decided;
            edge.extra_sites.push_back(tie.site);
            for (const VertexId v : {start(e), end(e)}) {
                auto& sites = cell_.vertices[v.value].sites;
                sites.push_back(tie.site);
                sort_unique(sites);
            }
        }
        sort_unique(edge.extra_sites);
        if (is_decided) return;
        ++decisions_.assumed;
        std::string sites = to_string(edge.sites[0]) + ", " + to_string(edge.sites[1]);
        for (const Site site : edge.extra_sites) sites += ", " + to_string(site);
        const Vector4d middle = 0.5 * (from + to);
        cell_.report.warnings.push_back("objects " + sites + ": taken to meet in one line through " +
                                        to_text(problem_.unit * problem_.frame.to_world(middle.head<3>())) +
                                        ", not told apart within " +
                                        to_text(problem_.unit * narrow_tie * middle.w()));
    }

    void set_space_curve(EdgeId e, RationalCurve3& curve) const {
        const int degree = is_line(e) ? 1 : is_spline(e) ? 5 : 2;
        const std::size_t count = is_line(e) ? 1 : is_spline(e) ? splines_[e].size() : spans(e).size();
        begin_joined(curve, degree, count);
        const auto add = [&](const Vec3& p, double w) {
            const Vec3 world = problem_.frame.to_world(p);
            curve.points.push_back({world.x(), world.y(), world.z(), w});
        };
        if (is_line(e)) {
            for (const VertexId v : {start(e), end(e)}) add(points_[v].head<3>(), 1);
        } else if (is_spline(e)) {
            for (const SpaceSpan& span : splines_[e])
                for (int k = curve.points.empty() ? 0 : 1; k < 6; ++k) add(span.points.col(k).head<3>(), 1);
        } else {
            add(spans(e).front().from.head<3>(), 1);
            for (const ConicSpan& span : spans(e)) {
                add(span.middle.head<3>() / span.weight, span.weight);
                add(span.to.head<3>(), 1);
            }
        }
    }

    // Of n spans those from `first` to before `last`, on the knots of the whole.
    static void begin_part(RationalCurve2& curve, int degree, std::size_t n, std::size_t first,
                           std::size_t last) {
        begin_joined(curve, degree, n);
        if (last - first == n) return;
        curve.knots.erase(curve.knots.begin() + degree * last + degree + 2, curve.knots.end());
        curve.knots.erase(curve.knots.begin(), curve.knots.begin() + degree * first);
        curve.knots.front() = curve.knots[1];
        curve.knots.back() = curve.knots[curve.knots.size() - 2];
    }

    // Of the spans first ... last - 1, counted in the direction of the loop.
    void set_spline_trim(EdgeId e, bool reversed, std::size_t first, std::size_t last,
                         RationalCurve2& curve) const {
        const std::vector<SpaceSpan>& spans = splines_[e];
        const std::size_t n = spans.size();
        begin_part(curve, 5, n, first, last);
        for (std::size_t i = first; i < last; ++i) {
            const SpaceSpan& span = spans[reversed ? n - 1 - i : i];
            const auto x = trim_row(span, reversed, 0), y = trim_row(span, reversed, 1);
            for (int k = i == first ? 0 : 1; k < 6; ++k) {
                const int at = reversed ? 5 - k : k;
                curve.points.push_back({x[at], y[at], 1});
            }
        }
    }

    // The trim of an edge in the direction of its loop. Joined spans share their end's weight.
    void set_trim(const RadialPatch& patch, EdgeId e, bool reversed, TrimCurve& trim) const {
        trim.edge = e.value;
        trim.reversed = reversed;
        RationalCurve2& curve = trim.curve;
        if (is_spline(e)) return set_spline_trim(e, reversed, 0, splines_[e].size(), curve);
        if (!is_line(e)) return set_conic_trim(patch, e, reversed, 0, spans(e).size(), curve);
        begin_joined(curve, 1, 1);
        for (const VertexId v : {start(e), end(e)}) {
            const Vec2 p = patch.parameters(Vec3(points_[v].head<3>()));
            curve.points.push_back({p.x(), p.y(), 1});
        }
        // Over one generator: a point near the axis tells its direction badly.
        if (patch.kind() == RadialPatch::Kind::AboutBase) {
            const bool ends_farther = points_[end(e)].w() > points_[start(e)].w();
            curve.points[ends_farther ? 0 : 1].x() = curve.points[ends_farther ? 1 : 0].x();
        }
        if (reversed) std::reverse(curve.points.begin(), curve.points.end());
    }
    // As set_spline_trim().
    void set_conic_trim(const RadialPatch& patch, EdgeId e, bool reversed, std::size_t first,
                        std::size_t last, RationalCurve2& curve) const {
        const std::size_t n = spans(e).size();
        const bool is_axial = patch.kind() == RadialPatch::Kind::AboutBase;
        begin_part(curve, is_axial ? 3 : 2, n, first, last);
        double scale = 1;
        // Of the first point after others only the weight is new.
        const auto add = [&](std::span<const Eigen::Vector3d> points) {
            scale = (curve.points.empty() ? 1 : curve.points.back().z()) / points.front().z();
            for (const Eigen::Vector3d& p : points.subspan(curve.points.empty() ? 0 : 1))
                curve.points.push_back({p.x() / p.z(), p.y() / p.z(), scale * p.z()});
        };
        for (const ConicSpan& piece :
             reversed ? spans(e).subspan(n - last, last - first) : spans(e).subspan(first, last - first)) {
            if (is_axial) {
                add(axial_trim(patch, piece));
            } else {
                const TrimSpan span(patch, piece);
                add(std::array{span.from, span.middle, span.to});
            }
        }
        // The knots are uniform: only the order changes.
        if (reversed) std::reverse(curve.points.begin(), curve.points.end());
    }

    const RadialBaseProblem& problem_;
    const MinimizationDiagram& diagram_;
    double tolerance_;
    const double origin_;  // how far the frame's is from the world's
    Decisions decisions_;
    Cell cell_;
    IdVector<VertexId, Vector4d> points_;                      // (p, t)
    IdVector<FormId, std::optional<Hyperplane>> hyperplanes_;  // of forms that were asked for
    IdVector<EdgeId, CurveKind> kinds_;
    std::vector<ConicSpan> conics_;
    struct Slice {
        std::uint32_t first = 0, last = 0;
    };
    IdVector<EdgeId, Slice> slices_;  // of conics_
    std::vector<EdgeId> bent_;        // of conics_, where a trim turned so far that a weight was too small
    IdVector<EdgeId, std::vector<SpaceSpan>> splines_;
    IdVector<EdgeId, SpaceFitError> errors_;
    IdVector<EdgeId, double> positions_;  // bounds on the distance of space curves from the true ones
    IdVector<FaceId, std::uint32_t> cell_faces_;
    IdVector<FaceId, SmallVector<CcbId, 2>> loops_;  // the outer one first
    IdVector<FaceId, RadialPatch> patches_;
    IdVector<FaceId, double> roundings_;  // of their control points
    IdVector<FormId, char> is_flat_;      // of forms with a face: is the bisector a plane?
    IdVector<FaceId, bool> wide_;         // Confocal
    IdVector<FaceId, Sectors> sectors_;
    FitEffort effort_;
    std::uint32_t seams_ = 0;
};

}  // namespace

LiftedCell lift(const RadialBaseProblem& problem, const MinimizationDiagram& diagram, double tolerance,
                bool with_measures) {
    return RadialLifter(problem, diagram, tolerance).lift(with_measures);
}

}  // namespace vcell
