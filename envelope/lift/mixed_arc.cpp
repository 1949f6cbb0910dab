#include "mixed_arc.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "../../core/errors.hpp"
#include "../../primitives/bases/canonical.hpp"
#include "../../primitives/bisectors/height_conics.hpp"
#include "../../primitives/objects/message.hpp"
#include "../diagram/chart_arc.hpp"
#include "based_diagram.hpp"
#include "conic_error.hpp"
#include "conic_trim.hpp"
#include "cylinder_turns.hpp"
#include "edge_trims.hpp"
#include "fit_all.hpp"

namespace vcell {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector4d;

using roundoff::u;

// W z = A x + B y + C.
SectionPlane graph(const ExactForm& f) { return {-f.A, -f.B, f.W, f.C}; }
SectionPlane wall(const RegionSide& side) { return {side.a, side.b, 0.0, -side.c}; }

// lambda (the plane's k + nz H - n.(p, 0)) + (rho + p_z) n.a: kappa but for a positive factor and the sign of
// lambda. Times the square of the form's unit.
Exact apex_offset(const ExactCylinder& f, const SectionPlane& s) {
    return f.steep * (f.unit * s.k + s.nz * f.rho - s.nx * f.px - s.ny * f.py) + s.nz * f.sine * f.pz +
           (f.rho + f.pz) * (s.nx * f.ax + s.ny * f.ay);
}

// Does a plane run along an axis that is parallel to the base, or whose cone has a line on its wall that is?
// Lines on the bisector are along the axis, too. What rounding leaves of lambda when the base turns does not
// count: the base itself does.
bool is_along(const SectionPlane& s, const CylinderForm& form) {
    return (s.nx * Exact(form.ax) + s.ny * Exact(form.ay) + s.nz * Exact(form.sine)).sign() == Sign::Zero;
}

// A section that does not pass through the apex, of a cylinder whose axis lies so to the base.
CurveKind section_kind(ExactCylinder f, AxisToBase axis, const SectionPlane& s) {
    if (axis == AxisToBase::Parallel) {
        f.az = f.sine;
        f.steep = Exact();
    }
    if (axis == AxisToBase::Upright) f.ax = f.ay = Exact();
    const Exact M = f.ax * f.ax + f.ay * f.ay + f.az * f.az - f.sine * f.sine;
    const Exact ex = s.nz * f.ax - s.nx * f.steep, ey = s.nz * f.ay - s.ny * f.steep;
    switch ((ex * ex + ey * ey - s.nz * s.nz * M).sign()) {
        case Sign::Positive: return CurveKind::Hyperbola;
        case Sign::Zero: return CurveKind::Parabola;
        case Sign::Negative: break;
    }
    // About the apex the cone is K^2 (x^2 + y^2) = (d.X)^2: a circle where that form is a multiple of the
    // metric on the plane's directions (nz, 0, -nx) and (0, nz, -ny).
    const Exact zz = s.nz * s.nz;
    const Exact m11 = M * zz - ex * ex, m12 = -(ex * ey), m22 = M * zz - ey * ey;
    const Exact g11 = zz + s.nx * s.nx, g12 = s.nx * s.ny, g22 = zz + s.ny * s.ny;
    return m11 * g22 == m22 * g11 && m11 * g12 == m12 * g11 ? CurveKind::Circle : CurveKind::Ellipse;
}

// Over a plane base a ball is (c, rho) with C = |(x, y) - c|^2 + (c_z - rho) (c_z + rho), w = 2 (c_z + rho).
// Where the form's centre is rounded, its linear terms tell what is left of it. A hollow sphere is such a
// ball of a radius below 0, with C and w negated. The bisector of everything else is a plane that bounds the
// cell.
SpaceSite space_site(const CircularForm& f) {
    if (f.k == 0) {
        const Vector3d n(-f.a, -f.b, f.w);
        const double norm = n.stableNorm();
        return {Plane{f.e / norm * (n / norm), n / norm}, true, {}};
    }
    if (f.k < 0) {
        const auto [center, radius] = std::get<Sphere>(space_site(-f).object);
        return {HollowSphere{center, -radius}, false, {}};
    }
    const Vector2d c(f.cx, f.cy), rest(0.5 * f.a, 0.5 * f.b);
    const double width = 0.5 * f.w, behind = (f.e + 2 * c.dot(rest) - rest.squaredNorm()) / width;
    const Vector2d center = c - rest;
    return {Sphere{{center.x(), center.y(), 0.5 * (width + behind)}, 0.5 * (width - behind)}, false, {}};
}

// What the trims beside a face are in: the parameters of a cylinder's patch, or those of the chart. In a
// sector they are turned by a quarter, the angle first, as faces are cut there.
struct PlaneParameters {
    const CylinderFrame* frame;  // null: the chart
    bool in_sector = false;

    Vector2d operator()(const Vector4d& X) const {
        if (frame == nullptr) return X.head<2>();
        const Vector2d p = frame->parameters(X.head<2>());
        return in_sector ? Vector2d(p.y(), -p.x()) : p;
    }
};

std::array<Vec2, 2> line_trim(const PlaneParameters& parameters, const Vector4d& from, const Vector4d& to) {
    return {parameters(from), parameters(to)};
}

ConicTrim conic_trim(const PlaneParameters& parameters, const ConicSpan& span) {
    if (parameters.frame != nullptr) {
        ConicTrim trim = cubic_trim(parameters.frame->coordinates(), 1, span);
        if (parameters.in_sector)
            for (Vector3d& p : trim.points) p = {p.y(), -p.x(), p.z()};
        return trim;
    }
    const auto chart = [](const Vector4d& X, double w) { return Vector3d(X.x(), X.y(), w); };
    return {2, {chart(span.from, 1), chart(span.middle, span.weight), chart(span.to, 1)}};
}

// What a hollow cylinder and a plane are reflected to in the base, where the solid one has the patch.
ExactCylinder reflected(ExactCylinder f) {
    for (Exact* number : {&f.pz, &f.az, &f.rho, &f.sine, &f.steep}) *number = -*number;
    return f;
}

// The conic in which a plane cuts a cylinder's bisector, by the coordinates of one face's patch.
class Section {
public:
    Section(const CylinderForm& form, const CylinderFrame& frame, SectionPlane plane) : frame_(frame) {
        ExactCylinder exact = exact_cylinder(form);
        if (form.is_hollow()) {
            exact = reflected(exact);
            plane.nz = -plane.nz;
        }
        normal_ = {nearest(plane.nx), nearest(plane.ny), nearest(plane.nz)};
        k_ = nearest(plane.k);
        const Exact offset = apex_offset(exact, plane);
        through_apex_ = offset.sign() == Sign::Zero;
        const double axis = Vector3d(form.ax, form.ay, form.az).stableNorm();
        const double s0 = frame.height()(frame.origin()).s, unit = nearest(exact.unit);
        kappa_ =
            (exact.steep.sign() == Sign::Negative ? -1 : 1) * nearest(offset) / (unit * unit * axis * s0);
        B_ = normal_.z() * frame.z2() - frame.turned(normal_.head<2>()).x() * frame.eps() / 4;
    }

    bool through_apex() const { return through_apex_; }

    // Its point over the ray from A at an angle. Pre: A is none at infinity.
    Vector4d at(double angle) const {
        const CylinderFrame& f = frame_;
        const double v =
            2 / f.eps() * std::tan(0.5 * (angle - std::atan2(f.direction().y(), f.direction().x())));
        const double k0 = k_ - normal_.head<2>().dot(f.origin()),
                     N = normal_.z() * f.f0() - k0 +
                         (f.turned(normal_.head<2>()).y() + normal_.z() * f.z1() + B_ * v) * v,
                     u = -N / (f.eps() * N + kappa_), mu = f.mu(u);
        const Vector2d p = f.origin() + f.turned_back({u - mu * f.eps() * v * v / 4, mu * v});
        const double z = f.height().side() * (f.f0() + f.rise() * u + mu * (f.z1() + f.z2() * v) * v);
        return {p.x(), p.y(), z, z};
    }

    // The arc between two of its points: M / kappa and -N / kappa = u M / kappa have the Bezier coefficients
    // m and n, and m is 1 / mu at the ends. The middle control point is that of the polynomials of
    // cylinder_patch.hpp over mu, with v^2 as its blossom. Pre: it is no ruling.
    ConicSpan between(const Vector4d& a, const Vector4d& b) const {
        const CylinderFrame& f = frame_;
        const Vector2d from = f.parameters(a.head<2>()), to = f.parameters(b.head<2>());
        const double m0 = 1 / f.mu(from.x()), m2 = 1 / f.mu(to.x());
        const double dv = to.y() - from.y(), bend = 0.5 * B_ / kappa_ * dv * dv,
                     v = 0.5 * (from.y() + to.y()), vv = from.y() * to.y();
        const double m = 0.5 * (m0 + m2) - f.eps() * bend, n = 0.5 * (from.x() * m0 + to.x() * m2) + bend;
        const Vector2d p = m * f.origin() + f.turned_back({n - f.eps() * vv / 4, v});
        const double z = f.height().side() * (f.f0() + f.fall() * n + f.z1() * v + f.z2() * vv),
                     scale = 1 / std::sqrt(m0 * m2);
        return {a, scale * Vector4d(p.x(), p.y(), z, z), b, scale * m};
    }

    // How far spans are from it: around the cylinder, whose axis is the y axis then.
    double distance(std::span<const ConicSpan> spans) const {
        const Vector3d &c = frame_.height().point(), &d = frame_.height().axis();
        const double rho = frame_.height().rho(), norm = normal_.norm(), S = frame_.height().sine(),
                     K = frame_.height().cosine();
        // Eigen's FromTwoVectors has an SVD for opposite ones, which takes five seconds to compile.
        const Vector3d across = d.unitOrthogonal();
        Eigen::Matrix3d turn;
        turn << across.transpose(), d.transpose(), across.cross(d).transpose();
        const double side = frame_.height().side();
        double far = c.norm() + frame_.height().reach() + rho;
        const auto moved = [&](const Vector4d& X, double w) -> Vector4d {
            far = std::max(far, X.norm() / w);
            Vector4d result;
            result << turn * (Vector3d(X.x(), X.y(), side * X.z()) - w * c), 0;
            result.w() = w * rho + (side * X.w() - S * result.y()) / K;
            return result;
        };
        std::vector<ConicSpan> around;
        for (const ConicSpan& s : spans)
            around.push_back({moved(s.from, 1), moved(s.middle, s.weight), moved(s.to, 1), s.weight});
        const double half_square = 1 - S * d.z(), scale = std::sqrt(0.5 / half_square);
        DistancePlane base{Vector4d::Zero(), -scale * (rho + c.z()),
                           -S * frame_.height().steep() / half_square},
            plane{Vector4d::Zero(), (k_ - normal_.dot(c)) / norm, 1};
        base.normal << scale * (turn.col(2) - S * Vector3d::UnitY()), -scale * K;
        plane.normal.head<3>() = turn * normal_ / norm;
        return conic_distance(around, {base, plane}, around_axis, 32 * u * far);
    }

private:
    const CylinderFrame& frame_;
    Vector3d normal_;
    double k_;
    double kappa_, B_;  // half their quotient is the bend of a span with v1 - v0 = 1
    bool through_apex_;
};

}  // namespace

MixedArcs::MixedArcs(const PlaneBaseProblem& problem, const MinimizationDiagram& diagram,
                     const FaceLoops& loops, double tolerance, unsigned threads)
    : diagram_(diagram) {
    if (diagram.cylinders.empty()) return;
    sectors_.emplace(PlaneDiagram{problem, diagram}, loops);
    points_.reserve(diagram.vertices.size());
    for (const MinimizationDiagram::Vertex& v : diagram.vertices)
        points_.push_back({v.point.x(), v.point.y(), v.height, v.height});
    kinds_.resize(diagram.edges.size(), CurveKind::Spline);
    errors_.resize(diagram.edges.size());
    curves_.emplace(diagram_, kinds_, points_, true);
    if (!problem.floor.empty())
        for (const EdgeId e : diagram.edges.ids())
            is_lifted_.push_back(std::ranges::any_of(std::array{0u, 1u}, [&](unsigned side) {
                const FormId form = diagram.face_forms[diagram.face(e, side)];
                return form.valid() && problem.lifts(form, diagram.is_below_floor);
            }));
    std::vector<EdgeId> splines;
    for (const EdgeId e : diagram.edges.ids())
        if (contains(e) && is_lifted(e) && !add_section(problem, e)) splines.push_back(e);
    add_splines(problem, splines, tolerance, threads);
    std::uint32_t seams = 0;
    for (const FaceId face : diagram.face_forms.ids())
        if (sectors_->is_cut(face) && problem.shows(diagram.face_forms[face], diagram.is_below_floor))
            cut(problem, loops, face, seams);
}

// The plane that the arc of an edge lies in, if there is one with rational coefficients.
//
// Where height_planes() finds two, f = g is contained in their union. Where the gradient of f - g does not
// vanish along an edge, it is an analytic curve and lies in one of them: not in that in which one of its
// points certainly is not. An edge that leaves both runs through a point where they cross, and so the
// gradient vanishes there.
std::optional<SectionPlane> MixedArcs::plane_of(const PlaneBaseProblem& problem, EdgeId e) const {
    const MinimizationDiagram::Edge& edge = diagram_.edges[e];
    if (edge.on_rim()) return wall(problem.region[edge.side]);
    for (const FormId f : {edge.left, edge.right})
        if (diagram_.is_circular(f) && diagram_.forms[f].k == 0) return graph(problem.family.exact(f));
    const auto planes = height_planes(problem.family, edge.left, edge.right);
    if (planes.empty()) return std::nullopt;
    const auto section = [&](std::size_t i) -> SectionPlane {
        return {planes[i][0], planes[i][1], planes[i][2], -planes[i][3]};
    };
    if (planes.size() == 1) return section(0);
    const unsigned side = diagram_.is_circular(diagram_.form_beside(e, 0)) ? 1 : 0;
    const CylinderHeight& height = sectors_->frame(diagram_.face(e, side)).height();
    std::array<bool, 2> leaves{};
    const auto visit = [&](const Vector2d& p, double error) {
        const CylinderHeight::Jet jet = height(p);
        const double doubt = height.slope_bound(jet, error) * error +
                             32 * u * ((p - height.point().head<2>()).norm() + std::abs(jet.value));
        for (const std::size_t i : {0, 1}) {
            const auto& [a, b, c, d] = planes[i];
            const Interval residual = a.enclosure() * Interval::ball(p.x(), error) +
                                      b.enclosure() * Interval::ball(p.y(), error) +
                                      c.enclosure() * Interval::ball(jet.value, doubt) + d.enclosure();
            leaves[i] = leaves[i] || !residual.contains(0);
        }
    };
    if (const VertexId start = diagram_.start(e); start.valid())
        visit(diagram_.vertices[start].point, diagram_.vertices[start].error);
    for (const MinimizationDiagram::ArcPiece& piece : diagram_.pieces(e)) visit(piece.end, piece.error);
    if (leaves[0] == leaves[1]) return std::nullopt;
    return section(leaves[0] ? 1 : 0);
}

bool MixedArcs::add_section(const PlaneBaseProblem& problem, EdgeId e) {
    const std::optional<SectionPlane> plane = plane_of(problem, e);
    if (!plane) return false;
    const unsigned side = is_beside_cylinder(e, 0) ? 0 : 1;
    const FaceId face = diagram_.face(e, side);
    const FormId f = diagram_.form_beside(e, side);
    const CylinderForm& form = problem.family.cylinder(f);
    const Section whole(form, sectors_->frame(face), *plane);
    const AxisToBase axis = problem.axes[f.value - problem.family.forms.size()];
    if (whole.through_apex() || (axis == AxisToBase::Parallel && is_along(*plane, form))) {
        if (!curves_->has_ends(e)) return false;
        // A ruling of the cone, and of the other one too.
        kinds_[e] = CurveKind::Line;
        set_error(e, 0, section_trims_error(e, end_error(e)));
        return true;
    }
    const std::vector<Vector4d> points = points_along(problem, e, *plane);
    if (points.empty()) return false;
    kinds_[e] = section_kind(exact_cylinder(form), axis, *plane);
    curves_->set_conics(e, [&](std::vector<ConicSpan>& spans) {
        for (std::size_t i = 0; i + 1 < points.size(); ++i) {
            const Vector4d &from = points[i], &to = points[i + 1];
            const CylinderFrame& frame = sectors_->frame_between(face, from.head<2>(), to.head<2>());
            const bool is_whole = &frame == &sectors_->frame(face);
            radial::add_even((is_whole ? whole : Section(form, frame, *plane)).between(from, to), spans);
        }
    });
    const double off = whole.distance(curves_->conics(e));
    set_error(e, off, section_trims_error(e, off));
    return true;
}

// The ends of a section, and between them where it leaves a sector; of one that is closed, which goes round
// A, one of these is both ends. None where there are none. A section has one point over every ray from A: its
// focus.
std::vector<Vector4d> MixedArcs::points_along(const PlaneBaseProblem& problem, EdgeId e,
                                              const SectionPlane& plane) const {
    constexpr double near = 0x1p-32;  // an end so near to a seam counts as on it
    struct Crossing {
        double part;
        Vector4d point;
    };
    std::vector<Crossing> crossings;
    std::optional<Vector2d> focus;
    std::array<double, 2> along{};
    const bool is_closed = !curves_->has_ends(e);
    for (const unsigned side : {0u, 1u}) {
        if (!is_beside_cylinder(e, side) || !sectors_->is_cut(diagram_.face(e, side))) continue;
        const FaceId face = diagram_.face(e, side);
        const CylinderForm& form = problem.family.cylinder(diagram_.form_beside(e, side));
        const Vector2d A = sectors_->frame(face).height().focus();
        const auto around = sectors_->along(e, A);
        if (!focus) {
            focus = A;
            along = around;
        }
        for (const CylinderSector& s : (*sectors_)[face]) {
            const double part = radial::turned_until(s.from, around[0], around[1]);
            if (!is_closed && !(part > near && part < std::abs(around[1]) - near)) continue;
            const Vector4d X = Section(form, s.frame, plane).at(s.from);
            const Vector2d q = X.head<2>() - *focus;
            crossings.push_back({radial::turned_until(std::atan2(q.y(), q.x()), along[0], along[1]), X});
        }
    }
    if (is_closed && crossings.empty()) return {};
    std::ranges::sort(crossings, {}, &Crossing::part);
    std::vector<Vector4d> points;
    if (!is_closed) points.push_back(curves_->from(e));
    for (const Crossing& c : crossings) points.push_back(c.point);
    points.push_back(is_closed ? points.front() : curves_->to(e));
    return points;
}

// How far the patches' points at the trims of a line or conic are from it, which may be `off` the arc. Seen
// from above a height turns an error by no more than its slope.
double MixedArcs::section_trims_error(EdgeId e, double off) const {
    double most = 0;
    for (const unsigned side : {0u, 1u}) {
        if (side == 1 && diagram_.edges[e].on_rim()) continue;
        if (is_beside_cylinder(e, side)) {
            const FaceId face = diagram_.face(e, side);
            if (curves_->is_line(e)) {
                const Vector4d &from = curves_->from(e), &to = curves_->to(e);
                const CylinderFrame& frame = sectors_->frame_between(face, from.head<2>(), to.head<2>());
                const auto [a, b] = line_trim({&frame}, from, to);
                const Vector3d p(a.x(), a.y(), 1), q(b.x(), b.y(), 1);
                most = std::max(most, trim_distance(frame, {from, 0.5 * (from + to), to, 1},
                                                    {3, {p, (2 * p + q) / 3, (p + 2 * q) / 3, q}}));
            }
            for (const ConicSpan& span : curves_->conics(e)) {
                const CylinderFrame& frame =
                    sectors_->frame_between(face, span.from.head<2>(), span.to.head<2>());
                most = std::max(most, trim_distance(frame, span, conic_trim({&frame}, span)));
            }
            continue;
        }
        const CircularForm& f = diagram_.forms[diagram_.form_beside(e, side)];
        double slope = 0;
        curves_->for_controls(e, [&](const Vec3& p, double) {
            slope = std::max(slope, gradient(f, p.head<2>()).norm() + 2 * std::abs(f.k) / f.w * off);
        });
        most = std::max(most, (1 + slope) * off);
    }
    return most;
}

// Is there a cylinder's face on a side?
bool MixedArcs::is_beside_cylinder(EdgeId e, unsigned side) const {
    return !(side == 1 && diagram_.edges[e].on_rim()) && !diagram_.is_circular(diagram_.form_beside(e, side));
}

// The true arc ends in the true vertices, up to which the curve that was compared may be continued.
void MixedArcs::set_error(EdgeId e, double curve, double trims) {
    const double ends = end_error(e);
    errors_[e] = {curve + 2 * ends, std::max(curve, trims) + 2 * ends};
}

double MixedArcs::vertex_error(VertexId v) const {
    return std::hypot(diagram_.vertices[v].error, diagram_.vertices[v].height_error);
}
double MixedArcs::end_error(EdgeId e) const {
    if (!curves_->has_ends(e)) return 0;
    return std::max(vertex_error(diagram_.start(e)), vertex_error(diagram_.end(e)));
}

SpaceSite MixedArcs::space_site_beside(const PlaneBaseProblem& problem, EdgeId e, FormId f,
                                       unsigned side) const {
    if (diagram_.is_circular(f)) {
        // The trim is the curve's projection.
        SpaceSite site = space_site(diagram_.forms[f]);
        site.parts.push_back({.patch = {PatchCoordinate::linear(Vector3d::UnitX(), Vector3d::Zero()),
                                        PatchCoordinate::linear(Vector3d::UnitY(), Vector3d::Zero())}});
        return site;
    }
    const CylinderForm& form = problem.family.cylinder(f);
    const FaceId face = diagram_.face(e, side);
    const Vec3 point(form.px, form.py, form.pz), axis(form.ax, form.ay, form.az);
    SpaceSite site{form.is_cone()     ? Object(HollowCone{point, axis, form.sine, axis.stableNorm()})
                   : form.is_hollow() ? Object(HollowCylinder{point, axis, -form.rho})
                                      : Object(Cylinder{point, axis, form.rho}),
                   false,
                   {}};
    if (!sectors_->is_cut(face)) site.parts.push_back({.patch = sectors_->frame(face).coordinates()});
    for (const CylinderSector& s : (*sectors_)[face]) {
        const PatchCoordinates c = s.frame.coordinates();
        PatchCoordinate inwards = c[0];
        inwards.numerator = -inwards.numerator;
        site.parts.push_back({.patch = {c[1], inwards}, .across = c[1], .range = {-s.reach(), s.reach()}});
    }
    return site;
}

void MixedArcs::add_splines(const PlaneBaseProblem& problem, const std::vector<EdgeId>& edges,
                            double tolerance, unsigned threads) {
    constexpr std::size_t most_of_edge = 500;
    FitEffort effort;
    effort.spans += most_of_edge * edges.size();
    fit_all(edges.size(), effort, threads,
            [&](std::size_t i, FitEffort& own) { fit_spline(problem, edges[i], tolerance, own); });
    for (const EdgeId e : edges) {
        const SpaceFitError& error = curves_->fit_error(e);
        if (error.unproved)
            throw PlaneDiagram{problem, diagram_}.unproved(e, "no curve is proved to be the one between them",
                                                           problem.frame.to_world(*error.unproved));
        set_error(e, error.curve, error.trims);
    }
}

void MixedArcs::fit_spline(const PlaneBaseProblem& problem, EdgeId e, double tolerance, FitEffort& effort) {
    const MinimizationDiagram::Edge& edge = diagram_.edges[e];
    const auto end = [&](VertexId v) -> std::optional<SpaceEnd> {
        if (!v.valid()) return std::nullopt;
        return SpaceEnd{points_[v].head<3>(), vertex_error(v)};
    };
    const std::array sides{diagram_.side_of(e, 0), diagram_.side_of(e, 1)};  // of the left and right forms
    const SpaceArc arc{{space_site_beside(problem, e, edge.left, sides[0]),
                        space_site_beside(problem, e, edge.right, sides[1])},
                       end(diagram_.start(e)),
                       end(diagram_.end(e)),
                       diagram_.pieces(e),
                       0,
                       false,
                       twin_quadric(problem.family, edge.right, edge.left),
                       sides[0] == 1};
    curves_->set_spline(e, [&](std::vector<SpaceSpan>& spans) {
        return fit_space_spline(BaseChart(), arc, tolerance, spans, effort);
    });
}

void MixedArcs::set_curve(EdgeId e, const BaseFrame& frame, RationalCurve3& curve, Range& heights) const {
    curves_->to_world(e, frame, curve);
    if (curves_->is_line(e)) {
        for (const Vector4d* X : {&curves_->from(e), &curves_->to(e)})
            heights = {std::min(heights[0], X->z()), std::max(heights[1], X->z())};
    } else if (curves_->is_spline(e)) {
        for (const SpaceSpan& span : curves_->splines(e)) {
            std::array<double, 6> z;
            for (int k = 0; k < 6; ++k) z[k] = span.points(2, k);
            extend_by_polynomial(heights, z);
        }
    } else {
        for (const ConicSpan& s : curves_->conics(e))
            extend(heights, s.from.z(), s.middle.z() / s.weight, s.to.z(), s.weight);
    }
}

// Trims of a face begin where others end, which may be those of other curves: ends are computed alike, to the
// digit.
void MixedArcs::set_trim(EdgeId e, bool reversed, RationalCurve2& curve) const {
    const unsigned side = reversed ? 1 : 0;
    const PlaneParameters parameters{is_beside_cylinder(e, side) ? &sectors_->frame(diagram_.face(e, side))
                                                                 : nullptr};
    set_part(parameters, {e, reversed, 0, curves_->size(e)}, curve);
}

template <class Parameters>
void MixedArcs::set_part(const Parameters& parameters, const EdgePart& part, RationalCurve2& curve) const {
    const auto [e, reversed, first, last] = part;
    vcell::set_trim(*curves_, parameters, part, curve);
    if (!curves_->has_ends(e)) return;
    if (first == 0) curve.points.front().head<2>() = parameters(reversed ? curves_->to(e) : curves_->from(e));
    if (last == curves_->size(e))
        curve.points.back().head<2>() = parameters(reversed ? curves_->from(e) : curves_->to(e));
}

// ---- Faces in sectors -------------------------------------------------------------------------------

std::uint32_t MixedArcs::sector_of(FaceId face, EdgeId e, bool reversed, std::size_t span) const {
    const std::size_t k = reversed ? curves_->size(e) - 1 - span : span;
    if (curves_->is_spline(e)) return curves_->splines(e)[k].part[reversed];
    const auto in_direction = [&](const Vector4d& from, const Vector4d& to) {
        return reversed ? sectors_->between(face, to.head<2>(), from.head<2>())
                        : sectors_->between(face, from.head<2>(), to.head<2>());
    };
    if (curves_->is_line(e)) return in_direction(curves_->from(e), curves_->to(e));
    const ConicSpan& s = curves_->conics(e)[k];
    return in_direction(s.from, s.to);
}

// The boundary in runs of spans within one sector each. Where the face holds the tip, all sectors come
// together there: lines along which the second parameter is one and the same, the face below them.
std::vector<std::vector<BoundaryRun>> MixedArcs::runs(const FaceLoops& loops, FaceId face) const {
    std::vector<std::vector<BoundaryRun>> result;
    const std::span<const CylinderSector> sectors = (*sectors_)[face];
    for (const CcbId ccb : loops[face]) {
        std::vector<BoundaryRun>& loop = result.emplace_back();
        loops.around(ccb, [&](EdgeId e, bool reversed) {
            const std::size_t n = curves_->size(e);
            for (std::size_t first = 0, last; first < n; first = last) {
                const std::uint32_t within = sector_of(face, e, reversed, first);
                last = first + 1;
                while (last < n && sector_of(face, e, reversed, last) == within) ++last;
                loop.push_back({{e.value, {}, reversed, {}}, within});
                set_part(PlaneParameters{&sectors[within].frame, true}, {e, reversed, first, last},
                         loop.back().trim.curve);
            }
        });
    }
    if (!sectors_->holds_tip(face)) return result;
    std::vector<BoundaryRun>& loop = result.emplace_back();
    for (std::size_t i = sectors.size(); i-- > 0;) {
        const double reach = sectors[i].reach(), at_tip = 1 / sectors[i].frame.eps();
        BoundaryRun& run = loop.emplace_back(BoundaryRun{{}, static_cast<std::uint32_t>(i)});
        begin_joined(run.trim.curve, 1, 1);
        run.trim.curve.points = {{reach, at_tip, 1}, {-reach, at_tip, 1}};
    }
    return result;
}

void MixedArcs::cut(const PlaneBaseProblem& problem, const FaceLoops& loops, FaceId face,
                    std::uint32_t& seams) {
    std::vector<CutSector> sectors;
    for (const CylinderSector& s : (*sectors_)[face])
        sectors.push_back({s.reach(), static_cast<std::uint32_t>(sectors.size())});
    std::optional<std::vector<CutPart>> parts = cut_face(runs(loops, face), sectors, seams);
    if (!parts)
        throw UndecidedError("object " +
                             to_string(PlaneDiagram{problem, diagram_}.main_site(diagram_.face_forms[face])) +
                             ": its face is not told from its parts around the tip of its bisector");
    for (CutPart& part : *parts)
        for (std::vector<TrimCurve>& loop : part.loops)
            for (TrimCurve& trim : loop)
                for (Vector3d& p : trim.curve.points) p = {-p.y(), p.x(), p.z()};
    cut_[face] = std::move(*parts);
}

}  // namespace vcell
