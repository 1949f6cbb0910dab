#include "mixed_arc.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "../../core/numbers/exact.hpp"
#include "../../primitives/bisectors/height_conics.hpp"
#include "based_diagram.hpp"

namespace vcell {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

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

// The plane as far as doubles tell it.
SectionSurface surface(const SectionPlane& s) {
    const auto rounded = [](const Exact& x) { return x.enclosure().mid(); };
    if (s.nz.sign() == Sign::Zero) return WallLine{rounded(s.nx), rounded(s.ny), -rounded(s.k)};
    const double turn = s.nz.sign() == Sign::Positive ? 1 : -1;
    CircularForm f;
    f.a = -turn * rounded(s.nx);
    f.b = -turn * rounded(s.ny);
    f.e = turn * rounded(s.k);
    f.w = turn * rounded(s.nz);
    return f;
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
// Where the form's centre is rounded, its linear terms tell what is left of it. The bisector of everything
// else is a plane that bounds the cell.
SpaceSite space_site(const CircularForm& f) {
    if (f.k == 0) {
        const Vector3d n(-f.a, -f.b, f.w);
        const double norm = n.stableNorm();
        return {Plane{f.e / norm * (n / norm), n / norm}, true, {}};
    }
    const Vector2d c(f.cx, f.cy), rest(0.5 * f.a, 0.5 * f.b);
    const double width = 0.5 * f.w, behind = (f.e + 2 * c.dot(rest) - rest.squaredNorm()) / width;
    const Vector2d center = c - rest;
    return {Sphere{{center.x(), center.y(), 0.5 * (width + behind)}, 0.5 * (width - behind)}, false, {}};
}

// The joined Bezier pieces of one degree: control(span, k) gives the k-th point of a piece.
template <class Curve, class Control>
void join(std::span<const MixedSpan> spans, int degree, Control control, Curve& curve) {
    begin_joined(curve, degree, spans.size());
    curve.points.push_back(control(spans.front(), 0));
    for (const MixedSpan& span : spans)
        for (int k = 1; k <= degree; ++k) curve.points.push_back(control(span, k));
}

// The conic in which a plane cuts a cylinder's bisector, in the coordinates of one face's patch.
class Section {
public:
    Section(const CylinderForm& form, const CylinderFrame& frame, const SectionPlane& plane)
        : frame_(&frame) {
        const ExactCylinder exact = exact_cylinder(form);
        const Exact offset = apex_offset(exact, plane);
        through_apex_ = offset.sign() == Sign::Zero;
        const Vector2d n = frame.turned({plane.nx.enclosure().mid(), plane.ny.enclosure().mid()});
        const double axis = Vector3d(form.ax, form.ay, form.az).stableNorm();
        const double s0 = frame.height()(frame.origin()).s;
        const double unit = exact.unit.enclosure().mid();
        const double kappa = (form.az < 0 ? -1 : 1) * offset.enclosure().mid() / (unit * unit * axis * s0);
        const double B = plane.nz.enclosure().mid() * frame.z2() - n.x() * frame.eps() / 4;
        bend_ = 0.5 * B / kappa;
    }

    const CylinderFrame& frame() const { return *frame_; }
    bool through_apex() const { return through_apex_; }

    // A span between two points given by their (u, v): M / kappa has the Bezier coefficients m[0 .. 2], and
    // -N / kappa = u M / kappa has n[0 .. 2]; at the ends M / kappa is 1 / mu.
    struct Quadratics {
        std::array<double, 3> m, n;
        Vector2d from, to;
    };
    Quadratics between(const Vector2d& from, const Vector2d& to) const {
        const double m0 = 1 / frame_->mu(from.x()), m1 = 1 / frame_->mu(to.x());
        const double n0 = from.x() * m0, n1 = to.x() * m1, dv = to.y() - from.y(), bend = bend_ * dv * dv;
        return {{m0, 0.5 * (m0 + m1) - frame_->eps() * bend, m1}, {n0, 0.5 * (n0 + n1) + bend, n1}, from, to};
    }

    // Its trim, in a parameter in which weights are multiplied by growth^k: of degree 2 where mu = 1, else 3.
    MixedSpan::Trim trim(const Quadratics& q, double growth) const {
        const auto& [m, n, from, to] = q;
        const double v0 = from.y(), v1 = to.y();
        MixedSpan::Trim trim;
        if (frame_->eps() == 0) {
            trim.degree = 2;
            trim.points[1] = {n[1], 0.5 * (v0 + v1), growth};
        } else {
            trim.degree = 3;
            const double w1 = (m[0] + 2 * m[1]) / 3, w2 = (2 * m[1] + m[2]) / 3;
            trim.points[1] = {(n[0] + 2 * n[1]) / 3 / w1, (v1 * m[0] + 2 * v0 * m[1]) / 3 / w1, w1 * growth};
            trim.points[2] = {(2 * n[1] + n[2]) / 3 / w2, (2 * v1 * m[1] + v0 * m[2]) / 3 / w2,
                              w2 * growth * growth};
        }
        trim.points[0] = {from.x(), v0, m[0]};
        trim.points[trim.degree] = {to.x(), v1, m[2] * std::pow(growth, trim.degree)};
        return trim;
    }

    // Chart point and height where (u, v) is given times M / kappa: the polynomials of cylinder_patch.hpp
    // over mu, with v^2 as its blossom.
    Vector3d point(double m, double n, double v, double vv) const {
        const CylinderFrame& f = *frame_;
        const Vector2d p = f.origin() + f.turned_back({n - f.eps() * vv / 4, v}) / m;
        return {p.x(), p.y(), (f.f0() + f.height().rho() * f.eps() * n + f.z1() * v + f.z2() * vv) / m};
    }

private:
    const CylinderFrame* frame_;
    double bend_;  // of a span with v1 - v0 = 1
    bool through_apex_;
};

// The spans of an arc on a section. Where cylinders lie on both sides the conic is parametrised by the first
// one's v; the other one's is a projective function of it, which scales weights.
class SectionSpans {
public:
    SectionSpans(const std::array<std::optional<Section>, 2>& sections, std::vector<MixedSpan>& out)
        : sections_(sections), first_(sections[0] ? 0 : 1), out_(out) {}

    void add(const Vector3d& a, const Vector3d& b, int halvings = 10) {
        // The middle weight is kept within these multiples of the outer ones' mean: beyond them the parameter
        // runs too unevenly for what integrates along it.
        constexpr double smallest_shoulder = 0.5, largest_shoulder = 4;
        const Section& section = *sections_[first_];
        if (section.through_apex()) return add_line(a, b);
        const Section::Quadratics q = between(section, a, b);
        const double shoulder = q.m[1] / std::sqrt(q.m[0] * q.m[2]);
        if (!(shoulder >= smallest_shoulder && shoulder <= largest_shoulder) && halvings > 0) {
            // Where the weights of the ends count alike.
            const double t = 1 / (1 + std::sqrt(q.m[2] / q.m[0])), s = 1 - t;
            const auto at = [&](const std::array<double, 3>& c) {
                return s * s * c[0] + 2 * s * t * c[1] + t * t * c[2];
            };
            const double v = s * q.from.y() + t * q.to.y();
            const Vector3d middle = section.point(at(q.m), at(q.n), v, v * v);
            add(a, middle, halvings - 1);
            add(middle, b, halvings - 1);
            return;
        }
        const double v = 0.5 * (q.from.y() + q.to.y()), vv = q.from.y() * q.to.y();
        MixedSpan span;
        span.degree = 2;
        span.points[0] << a, q.m[0];
        span.points[1] << section.point(q.m[1], q.n[1], v, vv), q.m[1];
        span.points[2] << b, q.m[2];
        span.trims[first_] = section.trim(q, 1);
        if (first_ == 0 && sections_[1]) {
            const Section::Quadratics r = between(*sections_[1], a, b);
            span.trims[1] = sections_[1]->trim(r, std::sqrt(q.m[2] * r.m[0] / (q.m[0] * r.m[2])));
        }
        out_.push_back(span);
    }

private:
    static Section::Quadratics between(const Section& s, const Vector3d& a, const Vector3d& b) {
        return s.between(s.frame().parameters(a.head<2>()), s.frame().parameters(b.head<2>()));
    }

    // A ruling of the cone, and of the other one too.
    void add_line(const Vector3d& a, const Vector3d& b) {
        MixedSpan span;
        span.degree = 1;
        span.points[0] << a, 1;
        span.points[1] << b, 1;
        for (int side = 0; side < 2; ++side) {
            if (!sections_[side]) continue;
            const Section::Quadratics q = between(*sections_[side], a, b);
            span.trims[side].degree = 1;
            span.trims[side].points[0] << q.from, 1;
            span.trims[side].points[1] << q.to, 1;
        }
        out_.push_back(span);
    }

    const std::array<std::optional<Section>, 2>& sections_;
    const int first_;
    std::vector<MixedSpan>& out_;
};

}  // namespace

MixedArcs::MixedArcs(const PlaneBaseProblem& problem, const MinimizationDiagram& diagram, double tolerance)
    : diagram_(diagram) {
    if (diagram.cylinders.empty()) return;
    add_frames(problem);
    arcs_.resize(diagram.edges.size());
    offsets_.reserve(diagram.edges.size() + 1);
    offsets_.push_back(0);
    for (const EdgeId e : diagram.edges.ids()) {
        add_edge(problem, e, tolerance);
        offsets_.push_back(static_cast<std::uint32_t>(spans_.size()));
    }
}

// About the mean of points around each face, which lies in the region with them.
void MixedArcs::add_frames(const PlaneBaseProblem& problem) {
    const Dcel& dcel = diagram_.dcel;
    frames_.resize(dcel.face_count());
    for (std::uint32_t i = 1; i < dcel.face_count(); ++i) {
        const FormId form = diagram_.face_forms[FaceId{i}];
        if (diagram_.is_circular(form)) continue;
        Vector2d sum = Vector2d::Zero();
        double count = 0;
        const auto add = [&](const Vector2d& p) {
            sum += p;
            ++count;
        };
        const HalfEdgeId start = dcel.start(dcel.outer_ccb(FaceId{i}));
        HalfEdgeId h = start;
        do {
            if (const VertexId v = dcel.origin(h); v.valid()) add(diagram_.vertices[v].point);
            for (const auto& piece : diagram_.pieces(Dcel::edge(h))) add(piece.end);
            h = dcel.next(h);
        } while (h != start);
        frames_[FaceId{i}] = CylinderFrame(problem.family.cylinder(form), sum / count);
    }
}

void MixedArcs::add_edge(const PlaneBaseProblem& problem, EdgeId e, double tolerance) {
    const MinimizationDiagram::Edge& edge = diagram_.edges[e];
    if (diagram_.is_circular(edge.left) && (edge.on_rim() || diagram_.is_circular(edge.right))) return;
    if (!add_section(problem, e)) add_spline(problem, e, tolerance);
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
    const VertexId start = diagram_.start(e);
    if (!plane || !start.valid()) return false;
    const MinimizationDiagram::Edge& edge = diagram_.edges[e];
    std::array<std::optional<Section>, 2> sections;
    FormId form;
    for (const int side : {1, 0}) {
        const FormId f = diagram_.form_beside(e, static_cast<unsigned>(side));
        if ((side == 1 && edge.on_rim()) || diagram_.is_circular(f)) continue;
        form = f;
        const FaceId face = diagram_.face(e, static_cast<unsigned>(side));
        sections[side] = Section(problem.family.cylinder(form), frames_[face], *plane);
    }
    const MinimizationDiagram::Vertex& from = diagram_.vertices[start];
    const MinimizationDiagram::Vertex& to = diagram_.vertices[diagram_.end(e)];
    Arc& arc = arcs_[e];
    arc.kind = sections[sections[0] ? 0 : 1]->through_apex()
                   ? CurveKind::Line
                   : section_kind(exact_cylinder(problem.family.cylinder(form)),
                                  problem.axes[form.value - problem.family.forms.size()], *plane);
    const std::size_t first = spans_.size();
    SectionSpans(sections, spans_)
        .add({from.point.x(), from.point.y(), from.height}, {to.point.x(), to.point.y(), to.height});
    const std::array sides{arc_side(e, diagram_.form_beside(e, 0), 0),
                           edge.on_rim() ? ArcSide{} : arc_side(e, diagram_.form_beside(e, 1), 1)};
    arc.error = conic_error(sides, surface(*plane), std::span(spans_).subspan(first));
    add_end_errors(e);
    return true;
}

ArcSide MixedArcs::arc_side(EdgeId e, FormId f, unsigned side) const {
    if (diagram_.is_circular(f)) return {&diagram_.forms[f], nullptr};
    return {nullptr, &frames_[diagram_.face(e, side)]};
}

// The true arc ends in the true vertices, up to which the curve that was compared may be continued.
void MixedArcs::add_end_errors(EdgeId e) {
    FitError end;
    for (const VertexId v : {diagram_.start(e), diagram_.end(e)}) {
        if (!v.valid()) continue;
        const MinimizationDiagram::Vertex& at = diagram_.vertices[v];
        end.chart = std::max(end.chart, at.error);
        end.space = std::max(end.space, std::hypot(at.error, at.height_error));
    }
    arcs_[e].error.chart += 2 * end.chart;
    arcs_[e].error.space += 2 * end.space;
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

void MixedArcs::add_spline(const PlaneBaseProblem& problem, EdgeId e, double tolerance) {
    const MinimizationDiagram::Edge& edge = diagram_.edges[e];
    const auto end = [&](VertexId v) -> std::optional<SpaceEnd> {
        if (!v.valid()) return std::nullopt;
        const MinimizationDiagram::Vertex& at = diagram_.vertices[v];
        return SpaceEnd{{at.point.x(), at.point.y(), at.height}, std::hypot(at.error, at.height_error)};
    };
    const std::array sides{diagram_.side_of(e, 0), diagram_.side_of(e, 1)};  // of the left and right forms
    const SpaceArc arc{{space_site_beside(problem, e, edge.left, sides[0]),
                        space_site_beside(problem, e, edge.right, sides[1])},
                       end(diagram_.start(e)),
                       end(diagram_.end(e)),
                       diagram_.pieces(e),
                       0,
                       false,
                       twin_quadric(problem.family, edge.right, edge.left)};
    constexpr std::size_t most_of_edge = 500;
    effort_.spans += most_of_edge;
    std::vector<SpaceSpan> fitted;
    const SpaceFitError error = fit_space_spline(BaseChart(), arc, tolerance, fitted, effort_);
    if (error.unproved)
        throw PlaneDiagram{problem, diagram_}.unproved(e, "no curve is proved to be the one between them",
                                                       problem.frame.to_world(*error.unproved));
    const std::size_t first = spans_.size();
    for (const SpaceSpan& from : fitted) {
        MixedSpan span;
        span.degree = 5;
        for (int k = 0; k <= 5; ++k) span.points[k] << from.points.col(k).head<3>(), 1;
        for (const int i : {0, 1}) {
            if (diagram_.is_circular(i == 0 ? edge.left : edge.right)) continue;
            auto& trim = span.trims[sides[i]];
            trim.degree = 5;
            for (int k = 0; k <= 5; ++k) trim.points[k] << from.points.col(k).segment<2>(4 + 2 * i), 1;
        }
        spans_.push_back(span);
    }
    // Trims of a face begin where others end, which are conics: their ends are computed alike, to the digit.
    for (const unsigned side : {0u, 1u}) {
        if (!arc.start || diagram_.is_circular(diagram_.form_beside(e, side))) continue;
        const CylinderFrame& frame = frames_[diagram_.face(e, side)];
        spans_[first].trims[side].points[0] << frame.parameters(arc.start->point.head<2>()), 1;
        spans_.back().trims[side].points[5] << frame.parameters(arc.end->point.head<2>()), 1;
    }
    arcs_[e].error = {error.curve, std::max(error.curve, error.trims)};
    add_end_errors(e);
}

void MixedArcs::set_curve(EdgeId e, const BaseFrame& frame, RationalCurve3& curve, Range& heights) const {
    for (const MixedSpan& s : spans(e)) {
        std::array<double, MixedSpan::largest_degree + 1> z;
        for (int k = 0; k <= s.degree; ++k) z[k] = s.points[k].z();
        if (s.degree == 2)
            extend(heights, z[0], z[1], z[2], s.points[1].w() / std::sqrt(s.points[0].w() * s.points[2].w()));
        else
            extend_by_polynomial(heights, {z.data(), static_cast<std::size_t>(s.degree) + 1});
    }
    const auto in_world = [&](const MixedSpan& s, int k) {
        const Vec3 world = frame.to_world(s.points[k].head<3>());
        return Eigen::Vector4d(world.x(), world.y(), world.z(), s.points[k].w());
    };
    join(spans(e), spans(e).front().degree, in_world, curve);
}

void MixedArcs::set_trim(EdgeId e, bool reversed, RationalCurve2& curve) const {
    const auto in_chart = [](const MixedSpan& s, int k) {
        const Eigen::Vector4d& p = s.points[k];
        return Vector3d(p.x(), p.y(), p.w());
    };
    const auto in_patch = [&](const MixedSpan& s, int k) { return s.trims[reversed].points[k]; };
    if (const int degree = spans(e).front().trims[reversed].degree; degree > 0)
        join(spans(e), degree, in_patch, curve);
    else
        join(spans(e), spans(e).front().degree, in_chart, curve);
    if (reversed) std::reverse(curve.points.begin(), curve.points.end());
}

}  // namespace vcell
