#include "mixed_arc.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <span>

#include "../../primitives/bases/canonical.hpp"
#include "../../primitives/bisectors/height_conics.hpp"
#include "../diagram/chart_arc.hpp"
#include "based_diagram.hpp"
#include "conic_error.hpp"
#include "conic_trim.hpp"
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

// a_z (the plane's k + nz rho - n.(p, 0)) + (rho + p_z) n.a: kappa but for a positive factor and the sign of
// a_z. Times the square of the form's unit.
Exact apex_offset(const ExactCylinder& f, const SectionPlane& s) {
    return f.az * (f.unit * s.k + s.nz * f.rho - s.nx * f.px - s.ny * f.py) +
           (f.rho + f.pz) * (s.nx * f.ax + s.ny * f.ay);
}

// A section that does not pass through the apex, of a cylinder whose axis lies so to the base.
CurveKind section_kind(ExactCylinder f, AxisToBase axis, const SectionPlane& s) {
    if (axis == AxisToBase::Parallel) f.az = Exact();
    if (axis == AxisToBase::Upright) f.ax = f.ay = Exact();
    const Exact norm = f.ax * f.ax + f.ay * f.ay + f.az * f.az;
    const Exact ex = s.nz * f.ax - s.nx * f.az, ey = s.nz * f.ay - s.ny * f.az;
    switch ((ex * ex + ey * ey - s.nz * s.nz * norm).sign()) {
        case Sign::Positive: return CurveKind::Hyperbola;
        case Sign::Zero: return CurveKind::Parabola;
        case Sign::Negative: break;
    }
    // About the apex the cone is x^2 + y^2 = (d.X)^2: a circle where that form is a multiple of the metric on
    // the plane's directions (nz, 0, -nx) and (0, nz, -ny).
    const Exact zz = s.nz * s.nz;
    const Exact m11 = norm * zz - ex * ex, m12 = -(ex * ey), m22 = norm * zz - ey * ey;
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

// What the trims beside a face are in: the parameters of a cylinder's patch, or those of the chart.
struct PlaneParameters {
    const CylinderFrame* frame;  // null: the chart

    Vector2d operator()(const Vector4d& X) const {
        return frame != nullptr ? frame->parameters(X.head<2>()) : Vector2d(X.head<2>());
    }
};

std::array<Vec2, 2> line_trim(const PlaneParameters& parameters, const Vector4d& from, const Vector4d& to) {
    return {parameters(from), parameters(to)};
}

ConicTrim conic_trim(const PlaneParameters& parameters, const ConicSpan& span) {
    if (parameters.frame != nullptr) return cubic_trim(parameters.frame->coordinates(), 1, span);
    const auto chart = [](const Vector4d& X, double w) { return Vector3d(X.x(), X.y(), w); };
    return {2, {chart(span.from, 1), chart(span.middle, span.weight), chart(span.to, 1)}};
}

// The conic in which a plane cuts a cylinder's bisector, by the coordinates of one face's patch.
class Section {
public:
    Section(const CylinderForm& form, const CylinderFrame& frame, const SectionPlane& plane)
        : frame_(frame),
          normal_(nearest(plane.nx), nearest(plane.ny), nearest(plane.nz)),
          k_(nearest(plane.k)) {
        const ExactCylinder exact = exact_cylinder(form);
        const Exact offset = apex_offset(exact, plane);
        through_apex_ = offset.sign() == Sign::Zero;
        const double axis = Vector3d(form.ax, form.ay, form.az).stableNorm();
        const double s0 = frame.height()(frame.origin()).s, unit = nearest(exact.unit);
        const double kappa = (form.az < 0 ? -1 : 1) * nearest(offset) / (unit * unit * axis * s0);
        const double B = normal_.z() * frame.z2() - frame.turned(normal_.head<2>()).x() * frame.eps() / 4;
        bend_ = 0.5 * B / kappa;
    }

    bool through_apex() const { return through_apex_; }

    // The arc between two of its points: M / kappa and -N / kappa = u M / kappa have the Bezier coefficients
    // m and n, and m is 1 / mu at the ends. The middle control point is that of the polynomials of
    // cylinder_patch.hpp over mu, with v^2 as its blossom. Pre: it is no ruling.
    ConicSpan between(const Vector4d& a, const Vector4d& b) const {
        const CylinderFrame& f = frame_;
        const Vector2d from = f.parameters(a.head<2>()), to = f.parameters(b.head<2>());
        const double m0 = 1 / f.mu(from.x()), m2 = 1 / f.mu(to.x());
        const double dv = to.y() - from.y(), bend = bend_ * dv * dv, v = 0.5 * (from.y() + to.y()),
                     vv = from.y() * to.y();
        const double m = 0.5 * (m0 + m2) - f.eps() * bend, n = 0.5 * (from.x() * m0 + to.x() * m2) + bend;
        const Vector2d p = m * f.origin() + f.turned_back({n - f.eps() * vv / 4, v});
        const double z = f.f0() + f.height().rho() * f.eps() * n + f.z1() * v + f.z2() * vv,
                     scale = 1 / std::sqrt(m0 * m2);
        return {a, scale * Vector4d(p.x(), p.y(), z, z), b, scale * m};
    }

    // How far spans are from it: around the cylinder, whose axis is the y axis then.
    double distance(std::span<const ConicSpan> spans) const {
        const Vector3d &c = frame_.height().point(), &d = frame_.height().axis();
        const double rho = frame_.height().rho(), norm = normal_.norm();
        const Eigen::Matrix3d turn =
            Eigen::Quaterniond::FromTwoVectors(d, Vector3d::UnitY()).toRotationMatrix();
        double far = c.norm() + frame_.height().reach() + rho;
        const auto moved = [&](const Vector4d& X, double w) -> Vector4d {
            far = std::max(far, X.norm() / w);
            Vector4d result;
            result << turn * (X.head<3>() - w * c), X.w() + w * rho;
            return result;
        };
        std::vector<ConicSpan> around;
        for (const ConicSpan& s : spans)
            around.push_back({moved(s.from, 1), moved(s.middle, s.weight), moved(s.to, 1), s.weight});
        DistancePlane base{{0, 0, 0, -std::sqrt(0.5)}, -std::sqrt(0.5) * (rho + c.z()), 0},
            plane{Vector4d::Zero(), (k_ - normal_.dot(c)) / norm, 1};
        base.normal.head<3>() = std::sqrt(0.5) * turn.col(2);
        plane.normal.head<3>() = turn * normal_ / norm;
        return conic_distance(around, {base, plane}, around_axis, 32 * u * far);
    }

private:
    const CylinderFrame& frame_;
    Vector3d normal_;
    double k_;
    double bend_;  // of a span with v1 - v0 = 1
    bool through_apex_;
};

}  // namespace

MixedArcs::MixedArcs(const PlaneBaseProblem& problem, const MinimizationDiagram& diagram,
                     const FaceLoops& loops, double tolerance, unsigned threads)
    : diagram_(diagram) {
    if (diagram.cylinders.empty()) return;
    add_frames(problem, loops);
    points_.reserve(diagram.vertices.size());
    for (const MinimizationDiagram::Vertex& v : diagram.vertices)
        points_.push_back({v.point.x(), v.point.y(), v.height, v.height});
    kinds_.resize(diagram.edges.size(), CurveKind::Spline);
    errors_.resize(diagram.edges.size());
    curves_.emplace(diagram_, kinds_, points_, true);
    std::vector<EdgeId> splines;
    for (const EdgeId e : diagram.edges.ids())
        if (contains(e) && !add_section(problem, e)) splines.push_back(e);
    add_splines(problem, splines, tolerance, threads);
}

// About the mean of points around each face, which lies in the region with them.
void MixedArcs::add_frames(const PlaneBaseProblem& problem, const FaceLoops& loops) {
    frames_.resize(diagram_.dcel.face_count());
    for (const FaceId face : diagram_.face_forms.ids()) {
        const FormId form = diagram_.face_forms[face];
        if (!form.valid() || diagram_.is_circular(form)) continue;
        Vector2d sum = Vector2d::Zero();
        double count = 0;
        const auto add = [&](const Vector2d& p) {
            sum += p;
            ++count;
        };
        loops.around(loops[face].front(), [&](EdgeId e, bool reversed) {
            const VertexId v = reversed ? diagram_.end(e) : diagram_.start(e);
            if (v.valid()) add(diagram_.vertices[v].point);
            for (const auto& piece : diagram_.pieces(e)) add(piece.end);
        });
        frames_[face] = CylinderFrame(problem.family.cylinder(form), sum / count);
    }
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
    const CylinderHeight& height = frames_[diagram_.face(e, side)].height();
    std::array<bool, 2> leaves{};
    const auto visit = [&](const Vector2d& p, double error) {
        const CylinderHeight::Jet jet = height(p);
        const double doubt = height.slope_bound(jet, error) * error +
                             32 * u * ((p - height.point().head<2>()).norm() + jet.value);
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
    if (!plane || !curves_->has_ends(e)) return false;
    const unsigned side = frame_beside(e, 0) != nullptr ? 0 : 1;
    const FormId f = diagram_.form_beside(e, side);
    const Section section(problem.family.cylinder(f), *frame_beside(e, side), *plane);
    if (section.through_apex()) {
        // A ruling of the cone, and of the other one too.
        kinds_[e] = CurveKind::Line;
        set_error(e, 0, section_trims_error(e, end_error(e)));
        return true;
    }
    kinds_[e] = section_kind(exact_cylinder(problem.family.cylinder(f)),
                             problem.axes[f.value - problem.family.forms.size()], *plane);
    curves_->set_conics(e, [&](std::vector<ConicSpan>& spans) {
        radial::add_even(section.between(curves_->from(e), curves_->to(e)), spans);
    });
    const double off = section.distance(curves_->conics(e));
    set_error(e, off, section_trims_error(e, off));
    return true;
}

// How far the patches' points at the trims of a line or conic are from it, which may be `off` the arc. Seen
// from above a height turns an error by no more than its slope.
double MixedArcs::section_trims_error(EdgeId e, double off) const {
    double most = 0;
    for (const unsigned side : {0u, 1u}) {
        if (side == 1 && diagram_.edges[e].on_rim()) continue;
        if (const CylinderFrame* frame = frame_beside(e, side)) {
            const PlaneParameters parameters{frame};
            if (curves_->is_line(e)) {
                const Vector4d &from = curves_->from(e), &to = curves_->to(e);
                const auto [a, b] = line_trim(parameters, from, to);
                const Vector3d p(a.x(), a.y(), 1), q(b.x(), b.y(), 1);
                most = std::max(most, trim_distance(*frame, {from, 0.5 * (from + to), to, 1},
                                                    {3, {p, (2 * p + q) / 3, (p + 2 * q) / 3, q}}));
            }
            for (const ConicSpan& span : curves_->conics(e))
                most = std::max(most, trim_distance(*frame, span, conic_trim(parameters, span)));
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

// That of the cylinder's face on a side, if there is one.
const CylinderFrame* MixedArcs::frame_beside(EdgeId e, unsigned side) const {
    if (side == 1 && diagram_.edges[e].on_rim()) return nullptr;
    return diagram_.is_circular(diagram_.form_beside(e, side)) ? nullptr : &frames_[diagram_.face(e, side)];
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
    const CylinderFrame& frame = frames_[diagram_.face(e, side)];
    return {Cylinder{{form.px, form.py, form.pz}, {form.ax, form.ay, form.az}, form.rho},
            false,
            {{.patch = frame.coordinates()}}};
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
    const PlaneParameters parameters{frame_beside(e, reversed ? 1 : 0)};
    vcell::set_trim(*curves_, parameters, {e, reversed, 0, curves_->size(e)}, curve);
    if (!curves_->has_ends(e)) return;
    curve.points.front().head<2>() = parameters(reversed ? curves_->to(e) : curves_->from(e));
    curve.points.back().head<2>() = parameters(reversed ? curves_->from(e) : curves_->to(e));
}

}  // namespace vcell
