#include "measures.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "quadrature.hpp"

namespace vcell {

namespace {

using Eigen::Vector2d;

constexpr double u = std::numeric_limits<double>::epsilon() / 2;

// Rounding of one boundary term, in units of u times its magnitude: some thirty operations from a form's
// coefficients (4u each) to the term, doubled.
constexpr double term_rounding = 128 * u;

// A sum with Neumaier's compensation, so that a million faces cost no digits, and a bound on the error of
// what was added.
struct BoundedSum {
    double sum = 0, compensation = 0, error = 0;

    void add(double term, double term_error = 0) {
        const double t = sum + term;
        compensation += std::abs(sum) >= std::abs(term) ? (sum - t) + term : (term - t) + sum;
        sum = t;
        error += term_error;
    }
    double value() const { return sum + compensation; }
    double bound() const { return error + 4 * u * std::abs(value()); }
};

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
        const double square = f.k * (o - Vector2d(f.cx, f.cy)).squaredNorm();
        f0_error = 16 * u * (square + std::abs(f.a * o.x()) + std::abs(f.b * o.y()) + std::abs(f.e)) / f.w;
    }
    double factor(const Vector2d& q) const { return c * q.squaredNorm() / 4 + g.dot(q) / 3 + f0 / 2; }
    // Bound on |factor| for |q| <= r.
    double factor_bound(double r) const { return c * r * r / 4 + g.norm() * r / 3 + std::abs(f0) / 2; }
};

// One span's share of a face's volume and of its area in the chart.
void add_span(const LocalHeight& f, const ArcSpan& span, BoundedSum& volume, BoundedSum& chart_area) {
    const Vector2d q0 = span.from - f.o, d = span.chord();
    const double length = span.length();
    double reach = std::max(q0.norm(), (span.to - f.o).norm());
    if (span.half_angle == 0) {
        // q x dq is constant on a segment; its factor is quadratic: the mean of |q|^2 is
        // |q0|^2 + q0.d + |d|^2 / 3, of q it is q0 + d / 2.
        const double turn = cross(q0, d);
        const double mean_square = q0.squaredNorm() + q0.dot(d) + d.squaredNorm() / 3;
        const double mean_factor = f.c * mean_square / 4 + f.g.dot(q0 + 0.5 * d) / 3 + f.f0 / 2;
        volume.add(mean_factor * turn, reach * length * (term_rounding * f.factor_bound(reach) + f.f0_error));
        chart_area.add(0.5 * turn, term_rounding * reach * length);
        return;
    }
    double v = 0, a = 0;
    quadrature::visit_nodes(span, [&](const Vector2d& p, const Vector2d& step) {
        const Vector2d q = p - f.o;
        const double turn = cross(q, step);
        v += f.factor(q) * turn;
        a += turn;
    });
    reach += 0.5 * length;
    // The integrand is entire. On the ellipse of quadrature.hpp the arc's complex angle stays below
    // 2.4 * 0.8 < 2, so |q| <= reach + (sinh 2 + cosh 2 - 1) half lengths and the step is at most
    // (sinh 2 + cosh 2) half lengths.
    const double complex_reach = reach + 3.2 * length;
    const double truncation = quadrature::truncation * 2 * complex_reach * 3.7 * length;
    volume.add(v, reach * length * (term_rounding * f.factor_bound(reach) + f.f0_error) +
                      truncation * f.factor_bound(complex_reach));
    chart_area.add(0.5 * a, term_rounding * reach * length + truncation);
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
    const auto reach = [&](const ArcSpan& part) {
        const Vector2d q = part.half_way() - center, t = part.chord().normalized();
        const double kappa = std::abs(part.curvature());
        const double a = 1.1 * (1 + std::abs(cross(t, q)) * kappa), b = 1.18 * std::abs(q.dot(t));
        const double room = q.squaredNorm() + 0.25 * w * w;
        const double radius = room / (b + std::sqrt(b * b + a * room));
        return kappa > 0 ? std::min(radius, 1 / kappa) : radius;
    };
    quadrature::visit_parts(span, reach, [&](const ArcSpan& part) {
        double sum = 0;
        quadrature::visit_nodes(part, [&](const Vector2d& p, const Vector2d& step) {
            const Vector2d q = p - center;
            const double s = 4 * q.squaredNorm() / (w * w);
            sum += (s * s + 3 * s + 3) / (3 * ((1 + s) * std::sqrt(1 + s) + 1)) * cross(q, step);
        });
        const double length = part.length(), distance = (part.half_way() - center).norm();
        const double m = 1 + 4 * distance * distance / (w * w);
        const double divisor = 3 * std::max(0.7, 0.04 * m * std::sqrt(0.04 * m) - 1);
        // |q| grows by at most 1.8 * 2.4 half lengths on the ellipse, the step is at most 2.8 half lengths.
        const double truncation = quadrature::truncation * 2 * (4 * m * m + 2 * m + 1) / divisor *
                                  (distance + 2.2 * length) * 1.4 * length;
        const double far = distance + 0.5 * length;
        area.add(sum, term_rounding * std::sqrt(1 + 4 * far * far / (w * w)) * far * length + truncation);
    });
}

// ---- Lengths ----------------------------------------------------------------------------------------

// Length of the lifted span: integral of sqrt(1 + f'^2) along the arc. f' is G.T with the gradient G of the
// linear function that f agrees with on the circle; in complex arc length sigma it moves by at most
// 1.73 |G| kappa |sigma| for |sigma| <= 1 / kappa, and sqrt(1 + f'^2) is analytic while that is below
// sqrt(1 + f'(middle)^2), the distance of +-i. G kappa has the components f'(middle) kappa along the
// tangent and f'' = 2 k / w + kappa grad f.N across it, also in the limit of a line.
double space_length(const CircularForm& f, const ArcSpan& span) {
    const auto reach = [&](const ArcSpan& part) {
        const Vector2d t = part.chord().normalized(), n(-t.y(), t.x());
        const Vector2d g = gradient(f, part.half_way());
        const double kappa = part.curvature(), slope = g.dot(t);
        const double bend = std::hypot(slope * kappa, 2 * f.k / f.w + kappa * g.dot(n));
        const double radius = std::sqrt(1 + slope * slope) / (1.73 * bend);
        return kappa != 0 ? std::min(radius, 1 / std::abs(kappa)) : radius;
    };
    double length = 0;
    quadrature::visit_parts(span, reach, [&](const ArcSpan& part) {
        quadrature::visit_nodes(part, [&](const Vector2d& p, const Vector2d& step) {
            const double rise = gradient(f, p).dot(step);
            length += std::sqrt(step.squaredNorm() + rise * rise);
        });
    });
    return length;
}

// Simpson's rule is exact for the quadratic height along a side of the region.
double wall_area(const CircularForm& f, const ArcSpan& segment) {
    const Vector2d &p = segment.from, &q = segment.to, m = segment.half_way();
    return segment.length() * (f(p.x(), p.y()) + 4 * f(m.x(), m.y()) + f(q.x(), q.y())) / 6;
}

// ---- Clearances -------------------------------------------------------------------------------------

// The smallest value of f over the closed region. For a sphere that is the value at the region's point
// nearest to the centre, for a linear form the smallest at a corner.
double region_minimum(const CircularForm& f, const PlaneBaseProblem& problem) {
    const auto& corners = problem.corners;
    double best = std::numeric_limits<double>::infinity();
    const Vector2d c(f.cx, f.cy);
    bool inside = f.k != 0;
    for (std::size_t i = 0; i < corners.size(); ++i) {
        Vector2d p = corners[i];
        if (f.k != 0) {
            const RegionSide& side = problem.region[i];
            if (side.a * c.x() + side.b * c.y() + side.c < 0) inside = false;
            const Vector2d along = corners[(i + 1) % corners.size()] - p;
            p += std::clamp((c - p).dot(along) / along.squaredNorm(), 0.0, 1.0) * along;
        }
        best = std::min(best, f(p.x(), p.y()));
    }
    return inside ? f.e / f.w : best;
}

// ---- All of them ------------------------------------------------------------------------------------

class Measurer {
public:
    Measurer(const PlaneBaseProblem& problem, const MinimizationDiagram& diagram, const ChartArcs& arcs,
             Cell& cell)
        : problem_(problem), diagram_(diagram), arcs_(arcs), cell_(cell) {}

    void run() {
        for (const EdgeId e : diagram_.edges.ids()) measure_edge(e);
        for (std::uint32_t i = 0; i < cell_.faces.size(); ++i) measure_face(FaceId{i + 1}, cell_.faces[i]);
        Measures& m = cell_.measures;
        m.volume = volume_.value();
        m.volume_error = volume_.bound();
        m.area = area_.value();
        m.area_error = area_.bound();
        m.box_area = box_area_.value();
        m.base_area = region_area(problem_.region);
        // The base region is cut out by the box, so the cell always ends at its sides.
        m.touches_box = true;
        m.min_clearance = min_clearance_;
        rank_neighbors();
    }

private:
    double slope_bound(const CircularForm& f, const ArcSpan& span) const {
        // The gradient is affine and the arc lies in the triangle of its control points.
        return std::max(
            {gradient(f, span.from).norm(), gradient(f, span.middle()).norm(), gradient(f, span.to).norm()});
    }

    void measure_edge(EdgeId e) {
        const MinimizationDiagram::Edge& edge = diagram_.edges[e];
        const bool right_linear = !edge.on_rim() && diagram_.forms[edge.right].k == 0;
        const CircularForm& f = diagram_.forms[right_linear ? edge.right : edge.left];
        double length = 0;
        for (const ArcSpan& span : arcs_.spans(e)) {
            length += space_length(f, span);
            if (edge.on_rim()) box_area_.add(wall_area(f, span));
            add_position_error(edge, span, arcs_.error(e));
        }
        cell_.edges[e.value].length = length;
    }

    // What a boundary that is off by `error` changes: a strip of twice the span's length times the error.
    // Between two faces the heights agree on the true edge, so the volume in the strip is of second order.
    void add_position_error(const MinimizationDiagram::Edge& edge, const ArcSpan& span, double error) {
        const double strip = 2 * span.length() * error;
        const auto add_area_error = [&](FormId form, double slope) {
            if (problem_.sites[form].front().is_object()) area_.add(0, strip * std::hypot(1, slope));
        };
        const CircularForm& f = diagram_.forms[edge.left];
        const double slope_f = slope_bound(f, span);
        add_area_error(edge.left, slope_f);
        if (edge.on_rim()) {
            volume_.add(0, strip * std::max(f(span.from.x(), span.from.y()), f(span.to.x(), span.to.y())));
            return;
        }
        const double slope_g = slope_bound(diagram_.forms[edge.right], span);
        add_area_error(edge.right, slope_g);
        volume_.add(0, strip * error * (slope_f + slope_g));
    }

    void measure_face(FaceId id, CellFace& face) {
        const CircularForm& f = diagram_.forms[diagram_.face_forms[id]];
        const RationalPatch& surface = face.patches.front().surface;
        const Vector2d origin(0.5 * surface.domain_u[0] + 0.5 * surface.domain_u[1],
                              0.5 * surface.domain_v[0] + 0.5 * surface.domain_v[1]);
        const LocalHeight height(f, origin);
        BoundedSum volume, chart_area, curved_area;
        const auto add_loop = [&](CcbId ccb) {
            const HalfEdgeId start = diagram_.dcel.start(ccb);
            HalfEdgeId h = start;
            do {
                const bool forward = h == Dcel::half_edge(Dcel::edge(h));
                for (const ArcSpan& s : arcs_.spans(Dcel::edge(h))) {
                    const ArcSpan span = forward ? s : s.reversed();
                    add_span(height, span, volume, chart_area);
                    if (f.k != 0) add_paraboloid_span({f.cx, f.cy}, f.w, span, curved_area);
                }
                h = diagram_.dcel.next(h);
            } while (h != start);
        };
        add_loop(diagram_.dcel.outer_ccb(id));
        for (const CcbId inner : diagram_.dcel.inner_ccbs(id)) add_loop(inner);

        const double stretch = std::hypot(1, f.a / f.w, f.b / f.w);
        // A face thinner than the spacing of doubles may come out below zero by its rounding.
        face.area = std::max(0.0, f.k != 0 ? curved_area.value() : stretch * chart_area.value());
        const double error = f.k != 0 ? curved_area.bound() : stretch * chart_area.bound();
        volume_.add(volume.value(), volume.bound());
        if (face.site.is_object())
            area_.add(face.area, error);
        else
            box_area_.add(face.area);
        min_clearance_ = std::min(min_clearance_, region_minimum(f, problem_));
    }

    void rank_neighbors() {
        struct Share {
            std::uint32_t object;
            double area;
        };
        std::vector<Share> shares;
        for (const CellFace& face : cell_.faces)
            if (face.site.is_object()) shares.push_back({face.site.index, face.area});
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
        std::stable_sort(shares.begin(), shares.end(),
                         [](const Share& a, const Share& b) { return a.area > b.area; });
        for (const Share& share : shares) cell_.neighbors.push_back(share.object);
    }

    const PlaneBaseProblem& problem_;
    const MinimizationDiagram& diagram_;
    const ChartArcs& arcs_;
    Cell& cell_;
    BoundedSum volume_, area_, box_area_;
    // min over the region of min_i f_i = min_i of the minimum of f_i over the region, and the minimum belongs
    // to a form that owns a face: no face needs to be searched for its apex.
    double min_clearance_ = std::numeric_limits<double>::infinity();
};

}  // namespace

void measure(const PlaneBaseProblem& problem, const MinimizationDiagram& diagram, const ChartArcs& arcs,
             Cell& cell) {
    Measurer(problem, diagram, arcs, cell).run();
}

}  // namespace vcell
