#include "measures.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "../../core/quadrature/bounded_sum.hpp"
#include "../../core/threads.hpp"
#include "../lift/cylinder_patch.hpp"
#include "arc_quadrature.hpp"
#include "mixed_integrals.hpp"

namespace vcell {

namespace {

using Eigen::Vector2d;

using roundoff::u;

// Rounding of one boundary term, in units of u times its magnitude: some thirty operations from a form's
// coefficients (4u each) to the term, doubled.
constexpr double boundary_rounding = 128 * u;

// The magnitudes that enter a height and its gradient at computed points (few roundings of their own, of the
// boundary_rounding allowed): an object's centre is exact.
double height_size(const CircularForm& f, const Vector2d& p) {
    const double d = (p - Vector2d(f.cx, f.cy)).norm();
    return (std::abs(f.k) * d * (d + p.norm() / 16) + std::abs(f.a * p.x()) + std::abs(f.b * p.y()) +
            std::abs(f.e)) /
           f.w;
}
double gradient_size(const CircularForm& f, const quadrature::Part& part) {
    const Vector2d c(f.cx, f.cy), &p = part.span.from, &q = part.span.to;
    const double far = std::sqrt(std::max(p.squaredNorm(), q.squaredNorm())) + part.length;
    const double d = std::sqrt(std::max((p - c).squaredNorm(), (q - c).squaredNorm())) + part.length;
    return (2 * std::abs(f.k) * (d + far / 16) + std::abs(f.a) + std::abs(f.b)) / f.w;
}

// ---- Integrals over a face by Green's theorem -------------------------------------------------------

// A height f = f0 + g.q + c |q|^2 about the point o, q = p - o, for a face around o.
//
// div(|q|^2 q) = 4 |q|^2, div((g.q) q) = 3 g.q and div(q) = 2, so the field
// (c |q|^2 / 4 + g.q / 3 + f0 / 2) q has the divergence f and
//     integral of f over the face = boundary integral of (c |q|^2 / 4 + g.q / 3 + f0 / 2) q x dq.
// With o inside the face's bounding rectangle no term is larger than the face's size demands.
struct LocalHeight {
    Vector2d o;
    double f0, c, f0_error;
    Vector2d g;

    LocalHeight(const CircularForm& f, const Vector2d& origin)
        : o(origin), f0(f(o.x(), o.y())), c(f.k / f.w), g(gradient(f, o)) {
        const double square = std::abs(f.k) * (o - Vector2d(f.cx, f.cy)).squaredNorm();
        f0_error = 16 * u * (square + std::abs(f.a * o.x()) + std::abs(f.b * o.y()) + std::abs(f.e)) / f.w;
    }
    double factor(const Vector2d& q) const { return c * q.squaredNorm() / 4 + g.dot(q) / 3 + f0 / 2; }
    // Bound on |factor| for |q| <= r.
    double factor_bound(double r) const {
        return std::abs(c) * r * r / 4 + g.norm() * r / 3 + std::abs(f0) / 2;
    }
};

// One span's share of a face's volume and of its area in the chart.
void add_span(const LocalHeight& f, const ArcSpan& span, BoundedSum& volume, BoundedSum& chart_area) {
    const Vector2d q0 = span.from - f.o;
    double reach = std::max(q0.norm(), (span.to - f.o).norm());
    if (span.half_angle == 0) {
        const Vector2d d = span.chord();
        const double length = d.norm();
        // q x dq is constant on a segment; its factor is quadratic: the mean of |q|^2 is
        // |q0|^2 + q0.d + |d|^2 / 3, of q it is q0 + d / 2.
        const double turn = cross(q0, d);
        const double mean_square = q0.squaredNorm() + q0.dot(d) + d.squaredNorm() / 3;
        const double mean_factor = f.c * mean_square / 4 + f.g.dot(q0 + 0.5 * d) / 3 + f.f0 / 2;
        volume.add(mean_factor * turn,
                   reach * length * (boundary_rounding * f.factor_bound(reach) + f.f0_error));
        chart_area.add(0.5 * turn, boundary_rounding * reach * length);
        return;
    }
    const quadrature::Part part(span);
    const double length = part.length;
    double v = 0, a = 0;
    constexpr double any = std::numeric_limits<double>::infinity();
    const auto [times, missing] = quadrature::visit_nodes(part, any, quadrature::tight_rules,
                                                          [&](const Vector2d& p, const Vector2d& step) {
                                                              const Vector2d q = p - f.o;
                                                              const double turn = cross(q, step);
                                                              v += f.factor(q) * turn;
                                                              a += turn;
                                                          });
    reach += 0.5 * length;
    // The integrand is entire. On the ellipse of quadrature.hpp the arc's complex angle stays below
    // 2.4 * 0.8 < 2, so |q| <= reach + (sinh 2 + cosh 2 - 1) half lengths and the step is at most
    // (sinh 2 + cosh 2) half lengths.
    const double complex_reach = reach + 3.2 * times * length;
    const double truncation = missing * 2 * complex_reach * 3.7 * times * length;
    volume.add(v, reach * length * (boundary_rounding * f.factor_bound(reach) + f.f0_error) +
                      truncation * f.factor_bound(complex_reach));
    chart_area.add(0.5 * a, boundary_rounding * reach * length + truncation);
}

// One span's share of the area of z = |p - c|^2 / w + const over a face.
//
// About c, with s = 4 |q|^2 / w^2 and rho = |q|, the surface element is sqrt(1 + s) rho d rho d phi. Its
// radial integral from 0 is (w^2 / 12) ((1 + s)^(3/2) - 1), and d phi = q x dq / |q|^2, so
//     area = boundary integral of F(s) q x dq,
//     F(s) = ((1 + s)^(3/2) - 1) / (3 s) = (s^2 + 3 s + 3) / (3 ((1 + s)^(3/2) + 1)),
// the last form being free of cancellation and regular at the apex.
//
// F is analytic where 1 + s stays off the negative axis. About a part's middle, with arc length sigma,
// tangent T, normal N and curvature kappa, |q|^2 changes by at most
// 2.36 |q.T| |sigma| + 1.1 (1 + |q.N| kappa) |sigma|^2 for complex |sigma| <= 1 / kappa (from
// |sin z| <= 1.18 |z|, |1 - cos z| <= 0.55 |z|^2). `radius` is where that reaches |q|^2 + w^2 / 4. On the
// ellipse, within 2.4/2.5 of the radius, 1 + s therefore differs from its value m in the middle by at most
// 0.96 m: |1 + s| lies between 0.04 m and 2 m, its argument within a right angle, and |(1 + s)^(3/2) + 1| is
// at least 1/sqrt(2) and at least (0.04 m)^(3/2) - 1.
void add_paraboloid_span(const Vector2d& center, double w, const ArcSpan& span, BoundedSum& area) {
    const auto reach = [&](const quadrature::Part& part) {
        const Vector2d q = part.half_way - center, t = part.tangent;
        const double kappa = std::abs(part.curvature);
        const double a = 1.1 * (1 + std::abs(cross(t, q)) * kappa), b = 1.18 * std::abs(q.dot(t));
        const double room = q.squaredNorm() + 0.25 * w * w;
        const double radius = room / (b + std::sqrt(b * b + a * room));
        return kappa > 0 ? std::min(radius, 1 / kappa) : radius;
    };
    quadrature::visit_parts(span, reach, [&](const quadrature::Part& part, double room) {
        double sum = 0;
        const auto [times, missing] = quadrature::visit_nodes(
            part, room, quadrature::short_rules, [&](const Vector2d& p, const Vector2d& step) {
                const Vector2d q = p - center;
                const double s = 4 * q.squaredNorm() / (w * w);
                sum += (s * s + 3 * s + 3) / (3 * ((1 + s) * std::sqrt(1 + s) + 1)) * cross(q, step);
            });
        const double length = part.length, distance = (part.half_way - center).norm();
        const double m = 1 + 4 * distance * distance / (w * w);
        const double divisor = 3 * std::max(0.7, 0.04 * m * std::sqrt(0.04 * m) - 1);
        // |q| grows by at most 1.8 * 2.4 half lengths on the ellipse, the step is at most 2.8 half lengths,
        // of a part as many times longer as the rule asks for.
        const double truncation = missing * 2 * (4 * m * m + 2 * m + 1) / divisor *
                                  (distance + 2.2 * times * length) * 1.4 * times * length;
        const double far = distance + 0.5 * length;
        const double size = std::sqrt(1 + 4 * far * far / (w * w)) * far * length;
        area.add(sum, boundary_rounding * size + (room > 0 ? truncation : 2 * size));
    });
}

// ---- Lengths ----------------------------------------------------------------------------------------

// Length of the lifted span: integral of sqrt(1 + f'^2) along the arc. f' is G.T with the gradient G of the
// linear function that f agrees with on the circle; in complex arc length sigma it moves by at most
// 1.73 |G| kappa |sigma| for |sigma| <= 1 / kappa, and sqrt(1 + f'^2) is analytic while that is below
// sqrt(1 + f'(middle)^2), the distance of +-i. G kappa has the components f'(middle) kappa along the
// tangent and f'' = 2 k / w + kappa grad f.N across it, also in the limit of a line.
//
// On the ellipse of quadrature.hpp, within 2.4/2.5 of that radius, f' differs from f'(middle) by less than
// sqrt(1 + f'(middle)^2) =: S, so |f' +- i| < 2 S and |sqrt(1 + f'^2)| < 2 S.
void add_space_length(const CircularForm& f, const ArcSpan& span, BoundedSum& length) {
    const auto reach = [&](const quadrature::Part& part) {
        const Vector2d t = part.tangent, n(-t.y(), t.x());
        const Vector2d g = gradient(f, part.half_way);
        const double kappa = part.curvature, slope = g.dot(t);
        const double bend = std::hypot(slope * kappa, 2 * f.k / f.w + kappa * g.dot(n));
        const double radius = std::sqrt(1 + slope * slope) / (1.73 * bend);
        return kappa != 0 ? std::min(radius, 1 / std::abs(kappa)) : radius;
    };
    quadrature::visit_parts(span, reach, [&](const quadrature::Part& part, double room) {
        double sum = 0;
        const auto [times, missing] = quadrature::visit_nodes(
            part, room, quadrature::short_rules, [&](const Vector2d& p, const Vector2d& step) {
                const double rise = gradient(f, p).dot(step);
                sum += std::sqrt(step.squaredNorm() + rise * rise);
            });
        const double slope = gradient(f, part.half_way).dot(part.tangent);
        const double rounding = boundary_rounding * gradient_size(f, part) * part.length;
        const double truncation =
            room > 0 ? missing * 4 * std::sqrt(1 + slope * slope) * times * part.length : 2 * sum;
        length.add(sum, boundary_rounding * sum + rounding + truncation);
    });
}

// Simpson's rule is exact for the quadratic height along a side of the region.
void add_wall(const CircularForm& f, const ArcSpan& segment, BoundedSum& area) {
    const Vector2d &p = segment.from, &q = segment.to, m = segment.half_way();
    const double length = segment.length();
    double size = 0;
    for (const Vector2d& at : {p, q, m}) size = std::max(size, height_size(f, at));
    area.add(length * (f(p.x(), p.y()) + 4 * f(m.x(), m.y()) + f(q.x(), q.y())) / 6,
             boundary_rounding * length * size);
}

// ---- Clearances -------------------------------------------------------------------------------------

// f = (K s - d.V) / lambda^2 - H, or its stable form, of what point() and p are rounded to.
double height_error(const CylinderHeight& f, const CylinderHeight::Jet& jet, const Vector2d& p) {
    const double reach = f.reach() + p.norm() + std::abs(jet.value) + f.rho();
    return boundary_rounding / 4 * reach * (1 + jet.gradient.norm());
}

// The least of heights that are known within bounds.
struct Least {
    double value = std::numeric_limits<double>::infinity(), lower = value, upper = value;

    void add(double v, double error) {
        lower = std::min(lower, std::max(0.0, v - error));
        if (!(v + error < upper)) return;
        upper = v + error;
        value = std::max(0.0, v);
    }
    void add(const Least& other) {
        lower = std::min(lower, other.lower);
        if (!(other.upper < upper)) return;
        upper = other.upper;
        value = other.value;
    }
    double error() const { return std::max(value - lower, upper - value); }
};

// The smallest value of f over the closed region. For a sphere that is the value at the region's point
// nearest to the centre, for a linear form and a hollow sphere, whose height is concave, the smallest at a
// corner. Corners carry a few roundings.
void add_region_minimum(const CircularForm& f, const PlaneBaseProblem& problem, Least& least) {
    const auto& corners = problem.corners;
    const Vector2d c(f.cx, f.cy);
    bool inside = f.k > 0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        Vector2d p = corners[i];
        if (f.k > 0) {
            const RegionSide& side = problem.region[i];
            if (side.a * c.x() + side.b * c.y() + side.c < 0) inside = false;
            const Vector2d along = corners[(i + 1) % corners.size()] - p;
            p += std::clamp((c - p).dot(along) / along.squaredNorm(), 0.0, 1.0) * along;
        }
        least.add(f(p.x(), p.y()), boundary_rounding * height_size(f, p));
    }
    if (inside) least.add(f.e / f.w, boundary_rounding * std::abs(f.e) / f.w);
}

// The same for a cylinder. Its height grows along the rays from A (cylinder_patch.hpp), or is constant along
// the axis: it is smallest on the region's rim. It is convex: on a side, smallest where its slope changes
// sign, and nowhere smaller than what its tangents say. A hollow one's is concave, and smallest at a corner.
void add_region_minimum(const CylinderHeight& f, const PlaneBaseProblem& problem, Least& least) {
    const auto& corners = problem.corners;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const Vector2d p = corners[i], along = corners[(i + 1) % corners.size()] - p;
        double low = 0, high = f.side() > 0 ? 1 : 0;
        // A quarter of the digits each time would be enough for Newton's method; the flat bottom needs half
        // of them.
        constexpr int halvings = 30;
        for (int k = 0; k < halvings; ++k) {
            const double t = 0.5 * (low + high);
            (f(p + t * along).gradient.dot(along) > 0 ? high : low) = t;
        }
        for (const double t : {low, high}) {
            const Vector2d at = p + t * along;
            const auto jet = f(at);
            const double slope = std::abs(jet.gradient.dot(along));
            least.add(jet.value, 2 * (high - low) * slope + height_error(f, jet, at));
        }
    }
}

// ---- All of them ------------------------------------------------------------------------------------

class Measurer {
public:
    Measurer(const PlaneBaseProblem& problem, const MinimizationDiagram& diagram, const ChartArcs& arcs,
             const MixedArcs& mixed, const FaceLoops& loops, Cell& cell)
        : problem_(problem),
          diagram_(diagram),
          arcs_(arcs),
          mixed_(mixed),
          loops_(loops),
          cell_(cell),
          strips_(diagram.edges.size(), {0, 0}) {}

    // Faces take what their edges leave, and all of it is added up task by task: in the same order whatever
    // threads do what.
    void run(unsigned threads) {
        const std::size_t edges = diagram_.edges.size(), faces = cell_.faces.size();
        std::vector<Sums> of_edges(range_count(edges)), of_faces(range_count(faces));
        for_ranges(edges, threads, [&](std::size_t begin, std::size_t end, std::size_t task) {
            for (auto e = static_cast<std::uint32_t>(begin); e < end; ++e)
                measure_edge(EdgeId{e}, of_edges[task]);
        });
        for_ranges(faces, threads, [&](std::size_t begin, std::size_t end, std::size_t task) {
            for (auto i = static_cast<std::uint32_t>(begin); i < end; ++i)
                measure_face(FaceId{i + 1}, cell_.faces[i], of_faces[task]);
        });
        Sums all;
        for (const Sums& sums : of_edges) all.add(sums);
        for (const Sums& sums : of_faces) all.add(sums);
        Measures& m = cell_.measures;
        m.volume = all.volume.value();
        m.volume_error = all.volume.bound();
        m.area = all.area.value();
        m.area_error = all.area.bound();
        m.box_area = all.box_area.value();
        m.box_area_error = all.box_area.bound();
        m.body_volume = m.body_volume_error = 0;
        m.base_area = region_area(problem_.floor.empty() ? problem_.region : problem_.region_in_box);
        m.base_area_error = 0x1p-49 * m.base_area;
        if (problem_.has_curved_rim && diagram_.is_below_floor) set_base_area();
        // The base region is cut out by the box, so the cell always ends at its sides.
        m.touches_box = true;
        if (problem_.floor.empty()) {
            m.min_clearance = all.min_clearance.value;
            m.min_clearance_error = all.min_clearance.error();
        }
        rank_neighbors(cell_);
    }

private:
    // What a task's elements add to the measures of the cell.
    struct Sums {
        BoundedSum volume, area, box_area;
        // min over the region of min_i f_i = min_i of the minimum of f_i over the region, and the minimum
        // belongs to a form that owns a face: no face needs to be searched for its apex.
        Least min_clearance;

        void add(const Sums& other) {
            volume.add(other.volume.value(), other.volume.bound());
            area.add(other.area.value(), other.area.bound());
            box_area.add(other.box_area.value(), other.box_area.bound());
            min_clearance.add(other.min_clearance);
        }
    };

    // Below the floor the base has its face where its rays begin and are in the cell.
    void set_base_area() {
        BoundedSum area;
        for (std::uint32_t i = 0; i < cell_.faces.size(); ++i)
            if (diagram_.face_forms[FaceId{i + 1}] == problem_.floor.front())
                area.add(cell_.faces[i].area, cell_.faces[i].area_error);
        cell_.measures.base_area = area.value();
        cell_.measures.base_area_error = area.bound();
    }

    double slope_bound(const CircularForm& f, const ArcSpan& span) const {
        // The gradient is affine and the arc lies in the triangle of its control points.
        return std::max(
            {gradient(f, span.from).norm(), gradient(f, span.middle()).norm(), gradient(f, span.to).norm()});
    }

    // An upper bound of the slope of the height on one side of a span with a cylinder on a side.
    double slope_bound(EdgeId e, unsigned side, ControlPoints span) const {
        const FormId form = diagram_.form_beside(e, side);
        double slope = 0;
        if (diagram_.is_circular(form)) {
            for (const Eigen::Vector4d& p : span)
                slope = std::max(slope, gradient(diagram_.forms[form], p.head<2>()).norm());
            return slope;
        }
        // The gradient (K V / s - d) / lambda is longest where V / s, which is nowhere between the control
        // points beyond all of theirs, is farthest from d: at one of them, unless it turns through -d between
        // them.
        const CylinderHeight& f = mixed_.frame(diagram_.dcel.face(Dcel::half_edge(e, side))).height();
        const Vector2d d = f.axis().head<2>();
        bool is_ahead = true, is_left = true, is_right = true;
        for (const Eigen::Vector4d& p : span) {
            const CylinderHeight::Jet jet = f(p.head<2>());
            const double across = cross(d, jet.v);
            is_ahead = is_ahead && d.dot(jet.v) > 0;
            is_left = is_left && across > 0;
            is_right = is_right && across < 0;
            slope = std::max(slope, jet.gradient.norm());
        }
        if (is_ahead || is_left || is_right) return slope;
        for (std::size_t k = 0; k + 1 < span.size(); ++k) {
            const Vector2d p = span[k].head<2>(), q = span[k + 1].head<2>();
            slope = std::max(slope, f.slope_bound(f(0.5 * (p + q)), 0.5 * (q - p).norm()));
        }
        return slope;
    }

    // Calls visit(span) with the control points of each span beside a cylinder, in the direction of half-edge
    // 2e.
    template <class Visit>
    void for_mixed_spans(EdgeId e, Visit&& visit) const {
        if (!mixed_.contains(e)) return;
        std::vector<Eigen::Vector4d> points;
        mixed_.curves().for_controls(e, [&](const Vec3& p, double w) {
            points.push_back({p.x(), p.y(), p.z(), w});
        });
        const auto degree = static_cast<std::size_t>(mixed_.curves().degree(e));
        for (std::size_t i = 0; i + degree < points.size(); i += degree)
            visit(ControlPoints(points).subspan(i, degree + 1));
    }

    void measure_mixed_edge(EdgeId e, Sums& sums) {
        const MinimizationDiagram::Edge& edge = diagram_.edges[e];
        BoundedSum length;
        for_mixed_spans(e, [&](ControlPoints span) {
            add(length, space_length(span));
            if (edge.on_rim() && shows(e, 0)) {
                const Integral wall = wall_area(span);
                sums.box_area.add(diagram_.is_below_floor ? -wall.value : wall.value, wall.error);
            }
            double polygon = 0, height = 0;
            for (std::size_t k = 0; k < span.size(); ++k) {
                if (k > 0) polygon += (span[k] - span[k - 1]).head<2>().norm();
                height = std::max(height, std::abs(span[k].z()));
            }
            const auto slope = [&](unsigned side) { return slope_bound(e, side, span); };
            add_position_error(e, polygon, mixed_.error(e).curve, height, slope, sums);
        });
        // Splines may wind about the true arc, for all that is proved.
        cell_.edges[e.value].is_estimated = mixed_.kind(e) == CurveKind::Spline;
        set_length(cell_.edges[e.value], length);
    }

    void measure_edge(EdgeId e, Sums& sums) {
        if (mixed_.contains(e)) return measure_mixed_edge(e, sums);
        const MinimizationDiagram::Edge& edge = diagram_.edges[e];
        const bool right_linear = !edge.on_rim() && diagram_.forms[edge.right].k == 0;
        const CircularForm& f = diagram_.forms[right_linear ? edge.right : edge.left];
        BoundedSum length;
        for (const ArcSpan& span : arcs_.spans(e)) {
            add_space_length(f, span, length);
            if (edge.on_rim() && shows(e, 0)) {
                BoundedSum wall;
                add_wall(f, span, wall);
                sums.box_area.add(diagram_.is_below_floor ? -wall.value() : wall.value(), wall.bound());
            }
            add_position_error(e, span, arcs_.error(e), sums);
        }
        set_length(cell_.edges[e.value], length);
    }

    static void add(BoundedSum& sum, const Integral& part) { sum.add(part.value, part.error); }

    void add_position_error(EdgeId e, const ArcSpan& span, double error, Sums& sums) {
        const MinimizationDiagram::Edge& edge = diagram_.edges[e];
        const CircularForm& f = diagram_.forms[edge.left];
        const double height = std::max(f(span.from.x(), span.from.y()), f(span.to.x(), span.to.y()));
        const auto slope = [&](unsigned side) {
            return slope_bound(diagram_.forms[diagram_.face_forms[diagram_.face(e, side)]], span);
        };
        add_position_error(e, span.length(), error, height, slope, sums);
    }

    // What a boundary that is off by `error` changes: a strip of twice the span's length times the error, and
    // the disks about its ends. Between two faces the heights agree on the true edge, so the volume in the
    // strip is of second order. slope(side) bounds the slope of the height on the left (0) or right.
    template <class Slope>
    void add_position_error(EdgeId e, double length, double error, double height, const Slope& slope,
                            Sums& sums) {
        const MinimizationDiagram::Edge& edge = diagram_.edges[e];
        const double strip = 2 * (length + 2 * error) * error;
        const double left = slope(0);
        strips_[e][0] += strip * std::hypot(1, left);
        if (edge.on_rim()) {
            if (!shows(e, 0)) return;
            sums.volume.add(0, strip * height);
            sums.box_area.add(0, 2 * error * height + length * error * left);
            return;
        }
        const double right = slope(1);
        strips_[e][1] += strip * std::hypot(1, right);
        if (shows(e, 0) == shows(e, 1))
            sums.volume.add(0, strip * error * (left + right));
        else
            sums.volume.add(0, strip * (std::abs(height) + error * (left + right)));
    }

    // Does the cell have the face on that side of the edge?
    bool shows(EdgeId e, unsigned side) const {
        const FormId form = diagram_.face_forms[diagram_.face(e, side)];
        return form.valid() && problem_.shows(form, diagram_.is_below_floor);
    }

    void measure_face(FaceId id, CellFace& face, Sums& sums) const {
        const FormId form = diagram_.face_forms[id];
        if (!problem_.lifts(form, diagram_.is_below_floor)) return;
        if (diagram_.is_circular(form))
            measure_circular_face(id, diagram_.forms[form], face, sums);
        else
            measure_cylinder_face(id, face, sums);
    }

    void measure_circular_face(FaceId id, const CircularForm& f, CellFace& face, Sums& sums) const {
        const RationalPatch& surface = face.patches.front().surface;
        const Vector2d origin(0.5 * surface.domain_u[0] + 0.5 * surface.domain_u[1],
                              0.5 * surface.domain_v[0] + 0.5 * surface.domain_v[1]);
        const LocalHeight height(f, origin);
        BoundedSum volume, chart_area, curved_area;
        loops_.around(id, [&](EdgeId e, bool reversed) {
            for (const ArcSpan& s : arcs_.spans(e)) {
                const ArcSpan span = reversed ? s.reversed() : s;
                add_span(height, span, volume, chart_area);
                if (f.k != 0) add_paraboloid_span({f.cx, f.cy}, f.w, span, curved_area);
            }
            const double sign = reversed ? -1 : 1;
            for_mixed_spans(e, [&](ControlPoints span) {
                const FaceIntegrals part = face_integrals(f, origin, span);
                volume.add(sign * part.volume.value, part.volume.error);
                chart_area.add(sign * part.chart_area.value, part.chart_area.error);
                if (f.k != 0) curved_area.add(sign * part.area.value, part.area.error);
            });
        });
        const double stretch = std::hypot(1, f.a / f.w, f.b / f.w);
        if (f.k != 0)
            set_face(id, face, volume, curved_area.value(), curved_area.bound(), sums);
        else
            set_face(id, face, volume, stretch * chart_area.value(), stretch * chart_area.bound(), sums);
        if (problem_.floor.empty()) add_region_minimum(f, problem_, sums.min_clearance);
    }

    void measure_cylinder_face(FaceId id, CellFace& face, Sums& sums) const {
        const CylinderFrame& frame = mixed_.frame(id);
        double extent = 0;
        loops_.around(id, [&](EdgeId e, bool) {
            for_mixed_spans(e, [&](ControlPoints span) {
                for (const Eigen::Vector4d& p : span)
                    extent = std::max(extent, (p.head<2>() - frame.origin()).norm());
            });
        });
        BoundedSum volume, area;
        loops_.around(id, [&](EdgeId e, bool reversed) {
            const double sign = reversed ? -1 : 1;
            for_mixed_spans(e, [&](ControlPoints span) {
                const FaceIntegrals part = face_integrals(frame, extent, span);
                volume.add(sign * part.volume.value, part.volume.error);
                area.add(sign * part.area.value, part.area.error);
            });
        });
        set_face(id, face, volume, area.value(), area.bound(), sums);
        if (problem_.floor.empty()) add_region_minimum(frame.height(), problem_, sums.min_clearance);
    }

    void set_face(FaceId id, CellFace& face, const BoundedSum& volume, double area, double area_bound,
                  Sums& sums) const {
        BoundedSum total;
        total.add(area, area_bound);
        loops_.around(id, [&](EdgeId e, bool reversed) { total.add(0, strips_[e][reversed ? 1 : 0]); });
        // A face thinner than the spacing of doubles may come out below zero by its rounding.
        face.area = std::max(0.0, total.value());
        face.area_error = total.bound();
        if (!problem_.shows(diagram_.face_forms[id], diagram_.is_below_floor)) return;
        sums.volume.add(volume.value(), volume.bound());
        (face.site.is_object() ? sums.area : sums.box_area).add(face.area, face.area_error);
    }

    static void set_length(CellEdge& edge, const BoundedSum& length) {
        edge.length = length.value();
        edge.length_error = length.bound() + length_sensitivity * edge.error;
    }

    const PlaneBaseProblem& problem_;
    const MinimizationDiagram& diagram_;
    const ChartArcs& arcs_;
    const MixedArcs& mixed_;
    const FaceLoops& loops_;
    Cell& cell_;
    // What edges off their places change about the areas of the faces on their left and right.
    IdVector<EdgeId, std::array<double, 2>> strips_;
};

}  // namespace

void rank_neighbors(Cell& cell) {
    struct Share {
        std::uint32_t object;
        double area;
    };
    std::vector<Share> shares;
    shares.reserve(cell.faces.size());
    for (const CellFace& face : cell.faces) {
        if (face.site.is_object()) shares.push_back({face.site.index, face.area});
        for (const Site site : face.extra_sites)
            if (site.is_object()) shares.push_back({site.index, face.area});
    }
    std::sort(shares.begin(), shares.end(),
              [](const Share& a, const Share& b) { return a.object < b.object; });
    std::size_t objects = 0;
    for (const Share& share : shares) {
        if (objects > 0 && shares[objects - 1].object == share.object)
            shares[objects - 1].area += share.area;
        else
            shares[objects++] = share;
    }
    shares.resize(objects);
    // Areas that were not measured are all the same.
    std::sort(shares.begin(), shares.end(), [](const Share& a, const Share& b) {
        if (a.area > b.area || b.area > a.area) return a.area > b.area;
        return a.object < b.object;
    });
    cell.neighbors.reserve(shares.size());
    for (const Share& share : shares) cell.neighbors.push_back(share.object);
}

void measure_over_region(const PlaneBaseProblem& problem, const MinimizationDiagram& diagram,
                         const ChartArcs& arcs, const MixedArcs& mixed, const FaceLoops& loops, Cell& cell,
                         unsigned threads) {
    Measurer(problem, diagram, arcs, mixed, loops, cell).run(threads);
}

}  // namespace vcell
