#include "check.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <boost/math/quadrature/gauss_kronrod.hpp>
#include <cfloat>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>
#include <random>
#include <span>
#include <type_traits>
#include <utility>

#include "../core/errors.hpp"
#include "../core/exact.hpp"

namespace vcell {
namespace {

/// Relative to the size of the coordinates: a few hundred operations, each rounding once, lie between the
/// scene and any number of the cell.
constexpr double kRounding = 512 * 0x1p-53;
/// Relative; what a quadrature of the cell's author may have left in a length, which states no error.
constexpr double kLengthError = 1e-10;
/// Relative to a face's extent in (u, v): base points this close to its boundary are not asked about.
constexpr double kNearEdge = 1e-9;
/// Higher degrees than this are no curve or patch of a cell, and would make evaluation unstable.
constexpr int kMaxDegree = 31;

// --- Distances --------------------------------------------------------------------------------------

double distance(const Plane& o, const Vec3& p) {
    return std::abs(o.normal.dot(p - o.point)) / o.normal.norm();
}
double distance(const Sphere& o, const Vec3& p) { return (p - o.center).norm() - o.radius; }
double distance(const Cylinder& o, const Vec3& p) {
    return o.axis.cross(p - o.point).norm() / o.axis.norm() - o.radius;
}
double distance(const Object& o, const Vec3& p) {
    return std::visit([&](const auto& x) { return distance(x, p); }, o);
}

/// Size of the numbers that enter the distance, for its rounding.
double magnitude(const Plane& o) { return o.point.norm(); }
double magnitude(const Sphere& o) { return o.center.norm() + o.radius; }
double magnitude(const Cylinder& o) { return o.point.norm() + o.radius; }

// --- Curves and patches -----------------------------------------------------------------------------

/// One polynomial piece of a rational curve, homogeneous: points are (w x, w).
template <int Dim>
struct Bezier {
    using Point = Eigen::Matrix<double, Dim, 1>;
    using Homogeneous = Eigen::Matrix<double, Dim + 1, 1>;

    double begin = 0, end = 1;
    std::vector<Homogeneous> points;

    int degree() const { return static_cast<int>(points.size()) - 1; }
    Point control(std::size_t i) const { return points[i].template head<Dim>() / points[i][Dim]; }
    double weight(std::size_t i) const { return points[i][Dim]; }

    /// Position and derivative with respect to the curve's parameter at t.
    std::array<Point, 2> evaluate(double t) const {
        std::array<Homogeneous, kMaxDegree + 1> b;
        std::ranges::copy(points, b.begin());
        const double s = (t - begin) / (end - begin);
        for (int level = degree(); level > 1; --level)
            for (int i = 0; i < level; ++i) b[i] = (1 - s) * b[i] + s * b[i + 1];
        const Homogeneous h = (1 - s) * b[0] + s * b[1];
        const Homogeneous dh = (b[1] - b[0]) * (degree() / (end - begin));
        const Point p = h.template head<Dim>() / h[Dim];
        return {p, (dh.template head<Dim>() - dh[Dim] * p) / h[Dim]};
    }

    std::array<Bezier, 2> halves() const {
        std::array<Bezier, 2> h{*this, *this};
        h[0].end = h[1].begin = 0.5 * (begin + end);
        std::vector<Homogeneous> b = points;
        for (int i = 0; i <= degree(); ++i) {
            h[0].points[i] = b[0];
            h[1].points[degree() - i] = b[degree() - i];
            for (int j = 0; j < degree() - i; ++j) b[j] = 0.5 * (b[j] + b[j + 1]);
        }
        return h;
    }
};

/// The pieces of a curve between its distinct knots: control point j of the piece on [a, b] is the blossom
/// at (a, ..., a, b, ..., b) with j times b.
template <int Dim>
std::vector<Bezier<Dim>> pieces(const RationalCurve<Dim>& c) {
    using Homogeneous = typename Bezier<Dim>::Homogeneous;
    const int d = c.degree;
    std::vector<Bezier<Dim>> result;
    for (int k = d; k + d + 1 < static_cast<int>(c.knots.size()); ++k) {
        const double a = c.knots[k], b = c.knots[k + 1];
        if (!(a < b)) continue;
        Bezier<Dim> piece{a, b, {}};
        for (int j = 0; j <= d; ++j) {
            std::vector<Homogeneous> level;
            for (int i = k - d; i <= k; ++i) {
                Homogeneous h = c.points[i];
                h.template head<Dim>() *= h[Dim];
                level.push_back(h);
            }
            for (int r = 1; r <= d; ++r) {
                const double t = r <= j ? b : a;
                for (int i = d; i >= r; --i) {
                    const int knot = k - d + i;
                    const double s = (t - c.knots[knot]) / (c.knots[knot + d - r + 1] - c.knots[knot]);
                    level[i] = (1 - s) * level[i - 1] + s * level[i];
                }
            }
            piece.points.push_back(level[d]);
        }
        result.push_back(std::move(piece));
    }
    return result;
}

template <int Dim>
typename Bezier<Dim>::Point evaluate(const std::vector<Bezier<Dim>>& curve, double t) {
    for (const auto& piece : curve)
        if (t <= piece.end) return piece.evaluate(t)[0];
    return curve.back().evaluate(t)[0];
}

struct SurfacePoint {
    Vec3 p, pu, pv;
};

/// Bernstein polynomials of degree d at s and their derivatives.
struct Bernstein {
    Bernstein(int d, double s) {
        value[0] = 1;
        for (int n = 1; n <= d; ++n) {
            if (n == d)
                for (int i = 0; i <= d; ++i)
                    slope[i] = d * ((i > 0 ? value[i - 1] : 0) - (i < d ? value[i] : 0));
            value[n] = s * value[n - 1];
            for (int i = n - 1; i > 0; --i) value[i] = (1 - s) * value[i] + s * value[i - 1];
            value[0] *= 1 - s;
        }
    }
    std::array<double, kMaxDegree + 1> value, slope;
};

SurfacePoint evaluate(const RationalPatch& s, double u, double v) {
    const double du = s.domain_u[1] - s.domain_u[0], dv = s.domain_v[1] - s.domain_v[0];
    const Bernstein bu(s.degree_u, (u - s.domain_u[0]) / du), bv(s.degree_v, (v - s.domain_v[0]) / dv);
    Eigen::Vector4d h = Eigen::Vector4d::Zero(), hu = h, hv = h;
    for (int i = 0; i <= s.degree_u; ++i)
        for (int j = 0; j <= s.degree_v; ++j) {
            Eigen::Vector4d c = s.points[i * (s.degree_v + 1) + j];
            c.head<3>() *= c[3];
            h += bu.value[i] * bv.value[j] * c;
            hu += bu.slope[i] * bv.value[j] / du * c;
            hv += bu.value[i] * bv.slope[j] / dv * c;
        }
    const Vec3 p = h.head<3>() / h[3];
    return {p, (hu.head<3>() - hu[3] * p) / h[3], (hv.head<3>() - hv[3] * p) / h[3]};
}

/// Angle that the curve sweeps as seen from q; none when q is within `near` of it. Where q is outside the
/// box of the control points, curve and chord turn by the same angle, less than pi.
std::optional<double> swept(const Bezier<2>& c, const Vec2& q, double near) {
    Vec2 lo = c.control(0), hi = lo;
    for (std::size_t i = 1; i < c.points.size(); ++i) {
        lo = lo.cwiseMin(c.control(i));
        hi = hi.cwiseMax(c.control(i));
    }
    const bool outside = (q.array() < lo.array()).any() || (q.array() > hi.array()).any();
    if (outside) {
        const Vec2 a = c.control(0) - q, b = c.control(c.points.size() - 1) - q;
        if (std::min(a.norm(), b.norm()) < near) return std::nullopt;
        return std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
    }
    // A box that rounding keeps from shrinking holds q for ever: q lies on the curve as far as doubles tell.
    const double least = std::max(near, 4 * DBL_EPSILON * std::max(lo.cwiseAbs().maxCoeff(), hi.cwiseAbs().maxCoeff()));
    if (!((hi - lo).maxCoeff() > least)) return std::nullopt;
    const auto halves = c.halves();
    const auto a = swept(halves[0], q, near), b = swept(halves[1], q, near);
    if (!a || !b) return std::nullopt;
    return *a + *b;
}

// --- Quadrature -------------------------------------------------------------------------------------

template <class V>
struct Integral {
    V value, error;
};

/// Adaptive Gauss-Kronrod (7, 15); parts are halved until the two rules agree to 1e-10, or to `floor`,
/// below which there is only rounding. The error is their difference, which overestimates.
template <class F, class V = std::invoke_result_t<F, double>>
Integral<V> integrate(const F& f, double a, double b, const V& floor, int depth = 12) {
    using Kronrod = boost::math::quadrature::gauss_kronrod<double, 15>;
    using Gauss = boost::math::quadrature::gauss<double, 7>;
    const double middle = 0.5 * (a + b), half = 0.5 * (b - a);
    const V centre = f(middle);
    V fine = Kronrod::weights()[0] * centre, coarse = Gauss::weights()[0] * centre;
    V size = Kronrod::weights()[0] * centre.abs();
    for (std::size_t i = 1; i < Kronrod::abscissa().size(); ++i) {
        const double x = half * Kronrod::abscissa()[i];
        const V left = f(middle - x), right = f(middle + x);
        fine += Kronrod::weights()[i] * (left + right);
        size += Kronrod::weights()[i] * (left.abs() + right.abs());
        if (i % 2 == 0) coarse += Gauss::weights()[i / 2] * (left + right);
    }
    const V error = (fine - coarse).abs();
    if (depth == 0 || (error <= 1e-10 * size || std::abs(half) * error <= floor).all())
        return {half * fine, std::abs(half) * error};
    const auto l = integrate(f, a, middle, floor, depth - 1), r = integrate(f, middle, b, floor, depth - 1);
    return {l.value + r.value, l.error + r.error};
}

using Scalar = Eigen::Array<double, 1, 1>;
using Triple = Eigen::Array3d;  // volume, area, base area

// --- The judge --------------------------------------------------------------------------------------

std::string vertex_path(std::size_t i) { return fmt::format("vertices[{}]", i); }
std::string edge_path(std::size_t i) { return fmt::format("edges[{}]", i); }
std::string face_path(std::size_t i) { return fmt::format("faces[{}]", i); }
std::string patch_path(std::size_t f, std::size_t p) { return fmt::format("faces[{}].patches[{}]", f, p); }
std::string loop_path(std::size_t f, std::size_t p, std::size_t l) {
    return fmt::format("faces[{}].patches[{}].loops[{}]", f, p, l);
}

std::string title(const Site& s) { return s.is_object() ? "object " + to_string(s) : to_string(s); }

bool contains(const std::vector<Site>& sites, const Site& s) {
    return std::ranges::find(sites, s) != sites.end();
}

class Judge {
public:
    Judge(const Cell& cell, const CheckOptions& options)
        : cell_(cell), scene_(cell.scene), options_(options) {
        const auto* plane = std::get_if<Plane>(&scene_.base);
        if (!plane)
            throw InputError(InputError::Kind::Unsupported, InputError::no_object, "scene.base",
                             "only the cells of planes can be checked");
        origin_ = plane->point;
        normal_ = plane->normal.normalized();
        e1_ = normal_.unitOrthogonal();
        e2_ = normal_.cross(e1_);
        scale_ =
            std::max({scene_.box.min.norm(), scene_.box.max.norm(), origin_.norm()}) + scene_.box.diagonal();
        for (std::uint32_t i = 0; i < scene_.objects.size(); ++i) {
            const Object& o = scene_.objects[i];
            const double size = std::visit([](const auto& x) { return magnitude(x); }, o);
            object_rounding_.push_back(kRounding * (scale_ + size));
            if (const auto* sphere = std::get_if<Sphere>(&o))
                spheres_.add(i, *sphere, object_rounding_.back());
            else
                others_.push_back(i);
        }
    }

    std::vector<Finding> run() {
        check_vertex_structure();
        check_edge_structure();
        check_face_structure();
        if (!findings_.empty()) return std::move(findings_);  // what follows evaluates all of it
        prepare();
        check_uses();
        check_labels();
        check_loops();
        check_seams();
        check_euler();
        check_vertices();
        check_edges();
        check_faces();
        check_samples();
        check_integrals();
        check_clearances();
        check_neighbors();
        check_report();
        return std::move(findings_);
    }

private:
    void note(std::string where, std::string what) {
        findings_.push_back({std::move(where), std::move(what)});
    }

    // --- Base, box and objects ----------------------------------------------------------------------

    double rounding() const { return kRounding * scale_; }
    double height(const Vec3& p) const { return normal_.dot(p - origin_); }
    Vec3 foot(const Vec3& p) const { return p - height(p) * normal_; }
    Vec2 chart(const Vec3& p) const { return {e1_.dot(p - origin_), e2_.dot(p - origin_)}; }
    Vec3 from_chart(const Vec2& q) const { return origin_ + q.x() * e1_ + q.y() * e2_; }

    /// How far p lies inside a side of the box.
    double inside_side(std::uint32_t side, const Vec3& p) const {
        const int axis = static_cast<int>(side / 2);
        return side % 2 ? scene_.box.max[axis] - p[axis] : p[axis] - scene_.box.min[axis];
    }
    double inside_box(const Vec3& p) const {
        double d = inside_side(0, p);
        for (std::uint32_t s = 1; s < 6; ++s) d = std::min(d, inside_side(s, p));
        return d;
    }
    double site_rounding(const Site& s) const {
        return s.is_object() ? object_rounding_[s.index] : rounding();
    }

    /// How much farther than r the site is from p: 0 where it bounds the cell at clearance r.
    double excess(const Site& s, const Vec3& p, double r) const {
        return s.is_object() ? distance(scene_.objects[s.index], p) - r : inside_side(s.index, p);
    }

    /// Some object closer to p than r, by more than slack and rounding. The one loop over all objects for
    /// every point that is judged: blocks of spheres by squared distances first, which vectorise.
    std::optional<std::uint32_t> nearer(const Vec3& p, double r, double slack) const {
        const double reach = r - slack;
        constexpr std::size_t kBlock = 256;
        for (std::size_t begin = 0; begin < spheres_.object.size(); begin += kBlock) {
            const std::size_t end = std::min(begin + kBlock, spheres_.object.size());
            int hits = 0;
            for (std::size_t i = begin; i < end; ++i) {
                const double dx = p.x() - spheres_.x[i], dy = p.y() - spheres_.y[i],
                             dz = p.z() - spheres_.z[i];
                const double limit = std::max(0.0, reach + spheres_.reduced_radius[i]);
                hits += dx * dx + dy * dy + dz * dz < limit * limit;
            }
            for (std::size_t i = begin; hits > 0 && i < end; ++i)
                if (is_nearer(spheres_.object[i], p, reach)) return spheres_.object[i];
        }
        for (const std::uint32_t i : others_)
            if (is_nearer(i, p, reach)) return i;
        return std::nullopt;
    }
    bool is_nearer(std::uint32_t i, const Vec3& p, double reach) const {
        return distance(scene_.objects[i], p) < reach - object_rounding_[i];
    }

    /// What contradicts that p, stated with an error, bounds the cell by the given sites; nothing if fine.
    std::optional<std::string> contradiction(const Vec3& p, double error, std::span<const Site> sites) const {
        const double r = height(p);
        for (const Site& s : sites) {
            const double e = excess(s, p, r);
            // Moving p by `error` changes both distances by that much.
            if (std::abs(e) > 2 * error + site_rounding(s))
                return fmt::format("{} is {:.3g} {} than the base", title(s), std::abs(e),
                                   e > 0 ? "farther" : "nearer");
        }
        if (r < -error - rounding()) return fmt::format("lies {:.3g} below the base", -r);
        if (const double out = -inside_box(p); out > error + rounding())
            return fmt::format("lies {:.3g} outside the box", out);
        if (const auto i = nearer(p, r, 2 * error))
            return fmt::format("object {} is {:.3g} nearer than the base", *i,
                               r - distance(scene_.objects[*i], p));
        return std::nullopt;
    }

    /// Clearance of the cell above a base point, by brute force: where the ray leaves the box, shortened by
    /// bisection at each object met before. d_i - t never grows along the ray, so its sign decides.
    double brute_height(const Vec3& f) const {
        double t = HUGE_VAL;
        for (std::uint32_t s = 0; s < 6; ++s) {
            const int axis = static_cast<int>(s / 2);
            const double speed = s % 2 ? normal_[axis] : -normal_[axis];
            if (speed > 0) t = std::min(t, std::max(0.0, inside_side(s, f)) / speed);
        }
        for (const Object& o : scene_.objects) {
            if (distance(o, f + t * normal_) >= t) continue;
            double lo = 0, hi = t;
            for (double m = 0.5 * hi; lo < m && m < hi; m = 0.5 * (lo + hi))
                (distance(o, f + m * normal_) < m ? hi : lo) = m;
            t = hi;
        }
        return t;
    }

    /// The base region: a large square about the box's shadow, cut by the six sides.
    std::vector<Vec2> region() const {
        const Vec2 c = chart(0.5 * (scene_.box.min + scene_.box.max));
        const double m = scene_.box.diagonal();
        std::vector<Vec2> polygon{c + Vec2(-m, -m), c + Vec2(m, -m), c + Vec2(m, m), c + Vec2(-m, m)};
        for (std::uint32_t s = 0; s < 6; ++s) {
            std::vector<Vec2> kept;
            for (std::size_t i = 0; i < polygon.size(); ++i) {
                const Vec2 &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
                const double dp = inside_side(s, from_chart(p)), dq = inside_side(s, from_chart(q));
                if (dp >= 0) kept.push_back(p);
                if ((dp >= 0) != (dq >= 0)) kept.push_back(p + dp / (dp - dq) * (q - p));
            }
            polygon = std::move(kept);
        }
        return polygon;
    }

    // --- Structure ----------------------------------------------------------------------------------

    bool exists(const Site& s) const {
        return s.kind == Site::Kind::Object ? s.index < scene_.objects.size()
                                            : s.kind == Site::Kind::BoxSide && s.index < 6;
    }
    void check_sites_exist(const std::string& where, std::span<const Site> sites) {
        for (const Site& s : sites)
            if (!exists(s))
                note(where, fmt::format("names {}, which is no object or side of the box", to_string(s)));
    }
    void check_amount(const std::string& where, double v) {
        if (!(v >= 0) || std::isinf(v)) note(where, fmt::format("is {}, must be finite and not negative", v));
    }

    template <int Dim>
    void check_curve(const std::string& where, const RationalCurve<Dim>& c) {
        if (c.degree < 1 || c.degree > kMaxDegree) return note(where, fmt::format("degree {}", c.degree));
        const std::size_t d = c.degree, n = c.points.size();
        if (n < d + 1) return note(where, fmt::format("{} control points for degree {}", n, d));
        if (c.knots.size() != n + d + 1)
            return note(where,
                        fmt::format("{} knots for {} control points of degree {}", c.knots.size(), n, d));
        for (const double k : c.knots)
            if (!std::isfinite(k)) return note(where, "a knot is not finite");
        if (!std::ranges::is_sorted(c.knots)) return note(where, "knots decrease");
        if (c.knots[0] != c.knots[d] || c.knots[n] != c.knots[n + d] || !(c.knots[d] < c.knots[n]))
            return note(where, "knot vector is not clamped");
        for (std::size_t i = 1; i < n; ++i)
            if (c.knots[i] == c.knots[i + d])
                return note(where, "an inner knot occurs more often than the degree");
        check_control_points<Dim>(where, c.points);
    }
    template <int Dim>
    void check_control_points(const std::string& where,
                              std::span<const Eigen::Matrix<double, Dim + 1, 1>> points) {
        for (const auto& p : points) {
            if (!p.allFinite()) return note(where, "a control point is not finite");
            if (!(p[Dim] > 0)) return note(where, fmt::format("weight {}, must be positive", p[Dim]));
        }
    }

    void check_vertex_structure() {
        for (std::size_t i = 0; i < cell_.vertices.size(); ++i) {
            const CellVertex& v = cell_.vertices[i];
            if (!v.point.allFinite()) note(vertex_path(i) + ".point", "is not finite");
            if (!std::isfinite(v.radius)) note(vertex_path(i) + ".radius", "is not finite");
            check_amount(vertex_path(i) + ".error", v.error);
            check_sites_exist(vertex_path(i) + ".sites", v.sites);
            if (std::ranges::adjacent_find(v.sites, std::greater_equal()) != v.sites.end())
                note(vertex_path(i) + ".sites", "are not ascending, each once");
        }
    }

    void check_edge_structure() {
        for (std::size_t i = 0; i < cell_.edges.size(); ++i) {
            const CellEdge& e = cell_.edges[i];
            check_sites_exist(edge_path(i) + ".sites", e.sites);
            check_sites_exist(edge_path(i) + ".extra_sites", e.extra_sites);
            if (e.vertices.size() != 0 && e.vertices.size() != 2)
                note(edge_path(i) + ".vertices",
                     fmt::format("are {}, must be two or none", e.vertices.size()));
            for (const std::uint32_t v : e.vertices)
                if (v >= cell_.vertices.size())
                    note(edge_path(i) + ".vertices", fmt::format("no vertex {}", v));
            check_amount(edge_path(i) + ".error", e.error);
            check_amount(edge_path(i) + ".length", e.length);
            check_curve<3>(edge_path(i) + ".curve", e.curve);
        }
    }

    void check_face_structure() {
        for (std::size_t f = 0; f < cell_.faces.size(); ++f) {
            const CellFace& face = cell_.faces[f];
            check_sites_exist(face_path(f) + ".site", std::span(&face.site, 1));
            check_sites_exist(face_path(f) + ".extra_sites", face.extra_sites);
            check_amount(face_path(f) + ".area", face.area);
            if (face.patches.empty()) note(face_path(f) + ".patches", "are none");
            for (std::size_t p = 0; p < face.patches.size(); ++p) check_patch_structure(f, p);
        }
    }

    void check_patch_structure(std::size_t f, std::size_t p) {
        const std::string where = patch_path(f, p);
        const TrimmedPatch& patch = cell_.faces[f].patches[p];
        const RationalPatch& s = patch.surface;
        for (const int degree : {s.degree_u, s.degree_v})
            if (degree < 1 || degree > kMaxDegree) return note(where, fmt::format("degree {}", degree));
        if (s.points.size() != static_cast<std::size_t>((s.degree_u + 1) * (s.degree_v + 1)))
            return note(where, fmt::format("{} control points for degrees {} and {}", s.points.size(),
                                           s.degree_u, s.degree_v));
        for (const auto& domain : {s.domain_u, s.domain_v})
            if (!(domain[0] < domain[1]) || !std::isfinite(domain[1] - domain[0]))
                note(where, "empty domain");
        check_control_points<3>(where, s.points);
        if (patch.loops.empty()) note(where + ".loops", "are none");
        for (std::size_t l = 0; l < patch.loops.size(); ++l) {
            if (patch.loops[l].empty()) note(loop_path(f, p, l), "is empty");
            for (std::size_t t = 0; t < patch.loops[l].size(); ++t) {
                const TrimCurve& trim = patch.loops[l][t];
                const std::string at = fmt::format("{}[{}]", loop_path(f, p, l), t);
                if (trim.edge.has_value() == trim.seam.has_value()) note(at, "must name an edge or a seam");
                if (trim.edge && *trim.edge >= cell_.edges.size())
                    note(at, fmt::format("no edge {}", *trim.edge));
                check_curve<2>(at + ".curve", trim.curve);
            }
        }
    }

    // --- Preparation: pieces of all curves, uses of all edges ------------------------------------------

    struct Trim {
        const TrimCurve* curve;
        std::vector<Bezier<2>> pieces;
        double begin() const { return pieces.front().begin; }
        double end() const { return pieces.back().end; }
    };
    struct Patch {
        std::size_t face, index;
        const RationalPatch* surface;
        std::vector<std::vector<Trim>> loops;
        Vec2 lo, hi;            // of the trimmed region, in (u, v)
        Vec2 foot_lo, foot_hi;  // of its feet, in the chart
        double control_size;    // largest coordinate of a control point
    };
    struct Use {
        std::size_t face;
        bool reversed;
    };

    void prepare() {
        for (const CellEdge& e : cell_.edges) edge_pieces_.push_back(pieces(e.curve));
        uses_.resize(cell_.edges.size());
        rim_side_.resize(cell_.edges.size());
        for (std::size_t f = 0; f < cell_.faces.size(); ++f)
            for (std::size_t p = 0; p < cell_.faces[f].patches.size(); ++p) prepare_patch(f, p);
    }

    void prepare_patch(std::size_t f, std::size_t p) {
        const TrimmedPatch& trimmed = cell_.faces[f].patches[p];
        const Vec2 infinite = Vec2::Constant(HUGE_VAL);
        Patch patch{f, p, &trimmed.surface, {}, infinite, -infinite, infinite, -infinite, scale_};
        for (const auto& c : trimmed.surface.points)
            patch.control_size = std::max(patch.control_size, c.head<3>().cwiseAbs().maxCoeff());
        for (const auto& loop : trimmed.loops) {
            auto& trims = patch.loops.emplace_back();
            for (const TrimCurve& trim : loop) {
                trims.push_back({&trim, pieces(trim.curve)});
                for (const auto& piece : trims.back().pieces)
                    for (std::size_t i = 0; i < piece.points.size(); ++i) {
                        patch.lo = patch.lo.cwiseMin(piece.control(i));
                        patch.hi = patch.hi.cwiseMax(piece.control(i));
                    }
                if (!trim.edge) {  // a seam may bulge anywhere: no bounds
                    patch.foot_lo = -infinite;
                    patch.foot_hi = infinite;
                    continue;
                }
                uses_[*trim.edge].push_back({f, trim.reversed});
                for (const auto& piece : edge_pieces_[*trim.edge])
                    for (std::size_t i = 0; i < piece.points.size(); ++i) {
                        const Vec2 q = chart(piece.control(i));
                        patch.foot_lo = patch.foot_lo.cwiseMin(q);
                        patch.foot_hi = patch.foot_hi.cwiseMax(q);
                    }
            }
        }
        patches_.push_back(std::move(patch));
    }

    /// Rounding of a surface point: that of its control points, and of (u, v) times the slopes.
    static double surface_rounding(const Patch& patch, const SurfacePoint& s, const Vec2& uv) {
        return kRounding *
               (patch.control_size + s.pu.norm() * std::abs(uv.x()) + s.pv.norm() * std::abs(uv.y()));
    }
    static SurfacePoint lift(const Patch& patch, const Vec2& uv) {
        return evaluate(*patch.surface, uv.x(), uv.y());
    }

    // --- Topology -----------------------------------------------------------------------------------

    void check_uses() {
        for (std::size_t e = 0; e < uses_.size(); ++e) {
            const auto& uses = uses_[e];
            const auto& sites = cell_.edges[e].sites;
            if (uses.empty()) note(edge_path(e), "no face uses it");
            if (uses.size() > 2) note(edge_path(e), fmt::format("used {} times", uses.size()));
            if (uses.size() == 2 && uses[0].reversed == uses[1].reversed)
                note(edge_path(e), fmt::format("used twice in the same sense, by faces {} and {}",
                                               uses[0].face, uses[1].face));
            if (uses.size() != 1) continue;
            const Site& outer = sites[!uses[0].reversed];
            if (outer.kind == Site::Kind::BoxSide && over_rim(e, outer.index))
                rim_side_[e] = outer.index;
            else
                note(edge_path(e),
                     fmt::format("used by face {} only, and not over the rim of the base region",
                                 uses[0].face));
        }
        check_sides();
    }

    /// Faces carry the sites that their edges name. Of an edge and a face that disagree, the one is to
    /// blame that disagrees with its other neighbours as well.
    void check_sides() {
        const auto differs = [&](std::size_t e, const Use& use) {
            return cell_.faces[use.face].site != cell_.edges[e].sites[use.reversed];
        };
        std::vector<int> wrong(cell_.faces.size()), all(cell_.faces.size());
        for (std::size_t e = 0; e < uses_.size(); ++e)
            for (const Use& use : uses_[e]) {
                ++all[use.face];
                wrong[use.face] += differs(e, use);
            }
        for (std::size_t e = 0; e < uses_.size(); ++e)
            for (const Use& use : uses_[e]) {
                if (!differs(e, use)) continue;
                const bool both = uses_[e].size() == 2 && differs(e, uses_[e][0]) && differs(e, uses_[e][1]);
                const Site &face = cell_.faces[use.face].site, &edge = cell_.edges[e].sites[use.reversed];
                if (!both && 2 * wrong[use.face] > all[use.face])
                    note(face_path(use.face) + ".site",
                         fmt::format("is {}, on that side of edge {} is {}", title(face), e, title(edge)));
                else
                    note(edge_path(e) + ".sites",
                         fmt::format("{} is {}, face {} there belongs to {}", use.reversed ? "right" : "left",
                                     title(edge), use.face, title(face)));
            }
    }

    bool over_rim(std::size_t e, std::uint32_t side) const {
        return std::ranges::all_of(edge_pieces_[e], [&](const auto& piece) {
            for (const double s : {0.0, 0.25, 0.5, 0.75, 1.0}) {
                const Vec3 p = piece.evaluate(piece.begin + s * (piece.end - piece.begin))[0];
                if (std::abs(inside_side(side, foot(p))) > full_error(e) + rounding()) return false;
            }
            return true;
        });
    }

    /// The labels of a vertex contain those of its edges; vertices are there for a reason.
    void check_labels() {
        std::vector<std::vector<std::size_t>> around(cell_.vertices.size());
        for (std::size_t e = 0; e < cell_.edges.size(); ++e) {
            const CellEdge& edge = cell_.edges[e];
            for (const std::uint32_t v : edge.vertices) {
                around[v].push_back(e);
                for (const auto& sites :
                     {std::vector<Site>(edge.sites.begin(), edge.sites.end()), edge.extra_sites})
                    for (const Site& s : sites)
                        if (!contains(cell_.vertices[v].sites, s))
                            note(vertex_path(v) + ".sites", fmt::format("lack {} of edge {}", title(s), e));
            }
        }
        for (std::size_t v = 0; v < around.size(); ++v) {
            if (cell_.vertices[v].sites.size() < 2) note(vertex_path(v) + ".sites", "are fewer than two");
            if (around[v].size() != 2 || around[v][0] == around[v][1]) continue;
            if (label(around[v][0]) == label(around[v][1]) &&
                label(around[v][0]).size() == cell_.vertices[v].sites.size())
                note(vertex_path(v),
                     fmt::format("splits edges {} and {}, which are one", around[v][0], around[v][1]));
        }
    }
    std::vector<Site> label(std::size_t e) const {
        std::vector<Site> sites = cell_.edges[e].extra_sites;
        sites.insert(sites.end(), cell_.edges[e].sites.begin(), cell_.edges[e].sites.end());
        std::ranges::sort(sites);
        sites.erase(std::unique(sites.begin(), sites.end()), sites.end());
        return sites;
    }

    void check_loops() {
        for (const Patch& patch : patches_)
            for (std::size_t l = 0; l < patch.loops.size(); ++l) {
                const std::string where = loop_path(patch.face, patch.index, l);
                check_head_to_tail(patch, patch.loops[l], where);
                double area = 0;
                for (const Trim& trim : patch.loops[l])
                    for (const auto& piece : trim.pieces)
                        area += integrate(
                                    [&](double t) {
                                        const auto [q, d] = piece.evaluate(t);
                                        const Vec2 r = q - patch.lo;
                                        return Scalar(0.5 * (r.x() * d.y() - r.y() * d.x()));
                                    },
                                    piece.begin, piece.end, Scalar(kRounding * (patch.hi - patch.lo).prod()))
                                    .value[0];
                if (l == 0 && !(area > 0)) note(where, "the outer loop does not run counter-clockwise");
                if (l > 0 && !(area < 0)) note(where, "a hole does not run clockwise");
            }
    }

    std::optional<std::uint32_t> end_vertex(const Trim& trim, bool at_end) const {
        if (!trim.curve->edge) return std::nullopt;
        const auto& ends = cell_.edges[*trim.curve->edge].vertices;
        if (ends.empty()) return std::nullopt;
        return ends[at_end != trim.curve->reversed];
    }

    void check_head_to_tail(const Patch& patch, const std::vector<Trim>& loop, const std::string& where) {
        for (std::size_t i = 0; i < loop.size(); ++i) {
            const Trim &trim = loop[i], &next = loop[(i + 1) % loop.size()];
            const auto head = end_vertex(trim, true), tail = end_vertex(next, false);
            if (trim.curve->edge && next.curve->edge && head != tail)
                return note(where,
                            fmt::format("curve {} does not end at the vertex where the next one starts", i));
            const Vec2 a = evaluate(trim.pieces, trim.end()), b = evaluate(next.pieces, next.begin());
            const SurfacePoint s = lift(patch, a);
            const double gap = (lift(patch, b).p - s.p).norm();
            const double errors =
                edge_error(trim) + edge_error(next) + (head ? 2 * cell_.vertices[*head].error : 0);
            if (gap > errors + surface_rounding(patch, s, a))
                return note(where, fmt::format("gap of {:.3g} after curve {}", gap, i));
        }
    }
    double edge_error(const Trim& trim) const {
        return trim.curve->edge ? cell_.edges[*trim.curve->edge].error : scene_tolerance();
    }
    double scene_tolerance() const { return scene_.tolerance.value_or(1e-7 * scene_.box.diagonal()); }

    void check_seams() {
        struct End {
            const Patch* patch;
            const Trim* trim;
            std::string where;
        };
        std::map<std::uint32_t, std::vector<End>> seams;
        for (const Patch& patch : patches_)
            for (std::size_t l = 0; l < patch.loops.size(); ++l)
                for (std::size_t t = 0; t < patch.loops[l].size(); ++t)
                    if (const Trim& trim = patch.loops[l][t]; trim.curve->seam)
                        seams[*trim.curve->seam].push_back(
                            {&patch, &trim, fmt::format("{}[{}]", loop_path(patch.face, patch.index, l), t)});
        for (const auto& [number, ends] : seams) {
            if (ends.size() != 2) {
                note(ends[0].where, fmt::format("seam {} occurs {} times", number, ends.size()));
                continue;
            }
            const auto at = [](const End& e, double s) {
                return lift(*e.patch,
                            evaluate(e.trim->pieces, e.trim->begin() + s * (e.trim->end() - e.trim->begin())))
                    .p;
            };
            for (const double s : {0.0, 0.5, 1.0})
                if ((at(ends[0], s) - at(ends[1], 1 - s)).norm() > scene_tolerance()) {
                    note(ends[0].where,
                         fmt::format("seam {} does not run back on {}", number, ends[1].where));
                    break;
                }
        }
    }

    /// V - E + F = 1 + C over the base region's subdivision, with its outside as a face and one vertex
    /// granted to each closed edge; and as many boundary loops as components.
    void check_euler() {
        std::vector<std::size_t> parent(cell_.vertices.size());
        std::iota(parent.begin(), parent.end(), std::size_t{0});
        const auto root = [&](std::size_t v) {
            while (parent[v] != v) v = parent[v] = parent[parent[v]];
            return v;
        };
        std::vector<bool> has_edges(parent.size());
        long closed = 0;
        for (const CellEdge& e : cell_.edges) {
            if (e.vertices.empty()) {
                ++closed;
                continue;
            }
            parent[root(e.vertices[0])] = root(e.vertices[1]);
            has_edges[e.vertices[0]] = has_edges[e.vertices[1]] = true;
        }
        long components = closed, isolated = 0, holes = 0;
        for (std::size_t v = 0; v < parent.size(); ++v) {
            components += parent[v] == v;
            isolated += !has_edges[v];
        }
        const long v = static_cast<long>(parent.size()) + closed, e = static_cast<long>(cell_.edges.size());
        const long f = static_cast<long>(cell_.faces.size()) + 1;
        if (v - e + f != 1 + components)
            note("faces",
                 fmt::format(
                     "Euler's relation: V {} - E {} + F {} (with the outside, and a vertex for each of "
                     "{} closed edges) is {}, C = {} components ask for {}",
                     v, e, f, closed, v - e + f, components, 1 + components));
        if (std::ranges::any_of(cell_.faces, [](const CellFace& face) { return face.patches.size() > 1; }))
            return;
        for (const Patch& patch : patches_) holes += static_cast<long>(patch.loops.size()) - 1;
        if (holes != components - isolated - 1)
            note("faces", fmt::format("{} holes, {} components of edges ask for {}", holes,
                                      components - isolated, components - isolated - 1));
    }

    // --- Geometry -----------------------------------------------------------------------------------

    void check_vertices() {
        for (std::size_t i = 0; i < cell_.vertices.size(); ++i) {
            const CellVertex& v = cell_.vertices[i];
            if (std::abs(height(v.point) - v.radius) > v.error + rounding())
                note(vertex_path(i) + ".radius",
                     fmt::format("is {}, the base is {} away", v.radius, height(v.point)));
            std::vector<Site> attained;
            for (const Site& s : v.sites) {
                const bool over_side =
                    !s.is_object() && std::abs(inside_side(s.index, foot(v.point))) <= v.error + rounding();
                if (!over_side) attained.push_back(s);
            }
            if (const auto what = contradiction(v.point, v.error, attained)) note(vertex_path(i), *what);
        }
    }

    void check_edges() {
        for (std::size_t i = 0; i < cell_.edges.size(); ++i) {
            check_edge_ends(i);
            check_edge_points(i);
            check_kind(i);
            check_length(i);
        }
    }

    void check_edge_ends(std::size_t i) {
        const CellEdge& e = cell_.edges[i];
        const auto& curve = edge_pieces_[i];
        const std::array ends{curve.front().evaluate(curve.front().begin)[0],
                              curve.back().evaluate(curve.back().end)[0]};
        if (e.vertices.empty()) {
            if (const double gap = (ends[0] - ends[1]).norm(); gap > 2 * e.error + rounding())
                note(edge_path(i) + ".curve", fmt::format("is closed, but its ends are {:.3g} apart", gap));
            return;
        }
        for (int k = 0; k < 2; ++k) {
            const CellVertex& v = cell_.vertices[e.vertices[k]];
            if (const double gap = (ends[k] - v.point).norm(); gap > e.error + v.error + rounding())
                note(edge_path(i) + ".vertices", fmt::format("the curve {} {:.3g} away from vertex {}",
                                                             k ? "ends" : "starts", gap, e.vertices[k]));
        }
    }

    /// Of an edge, that of its end vertices included: the curve runs through them.
    double full_error(std::size_t i) const {
        double at_ends = 0;
        for (const std::uint32_t v : cell_.edges[i].vertices)
            at_ends = std::max(at_ends, cell_.vertices[v].error);
        return cell_.edges[i].error + at_ends;
    }

    void check_edge_points(std::size_t i) {
        const double error = full_error(i);
        std::vector<Site> attained = label(i);
        if (rim_side_[i]) std::erase(attained, Site::box_side(*rim_side_[i]));
        constexpr int kSteps = 8;  // per piece
        for (const auto& piece : edge_pieces_[i])
            for (int k = 0; k < kSteps; ++k) {
                const Vec3 p =
                    piece.evaluate(piece.begin + (k + 0.5) / kSteps * (piece.end - piece.begin))[0];
                if (const auto what = contradiction(p, error, attained))
                    return note(edge_path(i) + ".curve", *what);
            }
    }

    /// The kind must be one that the two sites can have, and fit the control points. Between a kind and its
    /// limit (a flat ellipse and a parabola) rounding leaves the control points undecided.
    void check_kind(std::size_t i) {
        const CurveKind kind = cell_.edges[i].kind;
        const std::string where = edge_path(i) + ".kind";
        if (const auto kinds = possible_kinds(i);
            !kinds.empty() && std::ranges::find(kinds, kind) == kinds.end())
            return note(where, fmt::format("is {}, the sites meet in another kind ({})", to_string(kind),
                                           to_string(kinds[0])));
        for (const auto& piece : edge_pieces_[i])
            if (!fits(kind, piece, full_error(i)))
                return note(where, fmt::format("is {}, the control points disagree", to_string(kind)));
    }

    bool is_linear(const Site& s) const {
        return !s.is_object() || std::holds_alternative<Plane>(scene_.objects[s.index]);
    }
    const Sphere* as_sphere(const Site& s) const {
        return s.is_object() ? std::get_if<Sphere>(&scene_.objects[s.index]) : nullptr;
    }

    /// [HE, Lemmas 1-3] over a plane: planes and box sides have linear heights, spheres paraboloids about
    /// the base's normal. Empty: no opinion. Where only exact arithmetic on the canonical scene could tell
    /// a kind from its limit, both.
    std::vector<CurveKind> possible_kinds(std::size_t i) const {
        using enum CurveKind;
        const auto& sites = cell_.edges[i].sites;
        if (rim_side_[i]) {
            const Site& owner = sites[uses_[i][0].reversed];
            return is_linear(owner)   ? std::vector{Line}
                   : as_sphere(owner) ? std::vector{Parabola}
                                      : std::vector<CurveKind>{};
        }
        if (is_linear(sites[0]) && is_linear(sites[1])) return {Line};
        const Sphere *a = as_sphere(sites[0]), *b = as_sphere(sites[1]);
        if ((!a && !is_linear(sites[0])) || (!b && !is_linear(sites[1]))) return {};
        int axis = 0;
        normal_.cwiseAbs().maxCoeff(&axis);
        const int x = (axis + 1) % 3, y = (axis + 2) % 3;
        const bool aligned = normal_[x] == 0 && normal_[y] == 0;
        if (!a || !b) {
            if (!aligned) return {Ellipse, Circle};
            const Site& linear = a ? sites[1] : sites[0];
            const bool horizontal = linear.is_object()
                                        ? std::get<Plane>(scene_.objects[linear.index]).normal[x] == 0 &&
                                              std::get<Plane>(scene_.objects[linear.index]).normal[y] == 0
                                        : static_cast<int>(linear.index / 2) == axis;
            return {horizontal ? Circle : Ellipse};
        }
        // Equal sums of height and radius: the paraboloids are congruent and meet over a line.
        const double za = a->center[axis] - origin_[axis], zb = b->center[axis] - origin_[axis];
        if (!aligned || Exact(a->center[axis]) - Exact(origin_[axis]) != Exact(za) ||
            Exact(b->center[axis]) - Exact(origin_[axis]) != Exact(zb))
            return {Parabola, Ellipse, Circle};
        const Exact up(normal_[axis] > 0 ? 1.0 : -1.0);
        if (up * Exact(za) + Exact(a->radius) == up * Exact(zb) + Exact(b->radius)) return {Parabola};
        return {a->center[x] == b->center[x] && a->center[y] == b->center[y] ? Circle : Ellipse};
    }

    /// Can a piece with these control points be of that kind, up to rounding? [Farin02, 12.4]: w1^2 / (w0 w2)
    /// is below, at or above 1 for an ellipse, a parabola, a hyperbola; for a circle the legs are equal and
    /// its root is the cosine of their angle with the chord.
    bool fits(CurveKind kind, const Bezier<3>& piece, double error) const {
        const Vec3 a = piece.control(0), b = piece.control(piece.points.size() - 1), m = piece.control(1);
        if (kind == CurveKind::Spline) return true;
        if (kind == CurveKind::Line) {
            const Vec3 chord = b - a;
            for (std::size_t k = 1; k + 1 < piece.points.size(); ++k)
                if ((piece.control(k) - a).cross(chord).norm() > (rounding() + error) * chord.norm())
                    return false;
            return true;
        }
        if (piece.degree() != 2) return false;
        const double k = piece.weight(1) * piece.weight(1) / (piece.weight(0) * piece.weight(2));
        const double left = (m - a).norm(), right = (b - m).norm(), cosine = 0.5 * (b - a).norm() / left;
        switch (kind) {
            case CurveKind::Parabola:
                return std::abs(k - 1) < kRounding;
            case CurveKind::Hyperbola:
                return k > 1 - kRounding;
            case CurveKind::Circle:
                return std::abs(left - right) <= rounding() &&
                       std::abs(k - cosine * cosine) <= kRounding * (1 + scale_ / left);
            default:
                return k < 1 + kRounding;
        }
    }

    void check_length(std::size_t i) {
        double length = 0, error = 0;
        for (const auto& piece : edge_pieces_[i]) {
            const auto part = integrate([&](double t) { return Scalar(piece.evaluate(t)[1].norm()); },
                                        piece.begin, piece.end, Scalar(rounding()));
            length += part.value[0];
            error += part.error[0];
        }
        const double stated = cell_.edges[i].length;
        if (std::abs(stated - length) > error + kLengthError * length + 2 * full_error(i) + rounding())
            note(edge_path(i) + ".length", fmt::format("is {}, the curve is {} long", stated, length));
    }

    void check_faces() {
        for (std::size_t f = 0; f < cell_.faces.size(); ++f)
            if (const std::string name = bisector_name(cell_.faces[f].site); cell_.faces[f].bisector != name)
                note(face_path(f) + ".bisector",
                     fmt::format("is \"{}\", of a plane and {} it is \"{}\"", cell_.faces[f].bisector,
                                 title(cell_.faces[f].site), name));
        for (const Patch& patch : patches_) {
            check_patch_points(patch);
            for (std::size_t l = 0; l < patch.loops.size(); ++l)
                for (std::size_t t = 0; t < patch.loops[l].size(); ++t)
                    if (patch.loops[l][t].curve->edge)
                        check_trim(patch, patch.loops[l][t],
                                   fmt::format("{}[{}]", loop_path(patch.face, patch.index, l), t));
        }
    }

    std::string bisector_name(const Site& s) const {
        if (!s.is_object()) return "box";
        const Object& o = scene_.objects[s.index];
        if (std::holds_alternative<Plane>(o)) return "plane";
        if (std::holds_alternative<Sphere>(o)) return "paraboloid";
        // The points whose distance from a line equals that from the plane shifted by the radius.
        const bool parallel = std::abs(normal_.dot(std::get<Cylinder>(o).axis.normalized())) <= kRounding;
        return parallel ? "parabolic cylinder" : "elliptic cone";
    }

    /// Is uv inside the loops? None: too near to them.
    std::optional<bool> inside(const Patch& patch, const Vec2& uv) const {
        if ((uv.array() < patch.lo.array()).any() || (uv.array() > patch.hi.array()).any()) return false;
        const double near = kNearEdge * (patch.hi - patch.lo).maxCoeff();
        double total = 0;
        for (const auto& loop : patch.loops)
            for (const Trim& trim : loop)
                for (const auto& piece : trim.pieces) {
                    const auto angle = swept(piece, uv, near);
                    if (!angle) return std::nullopt;
                    total += *angle;
                }
        return std::lround(total / (2 * std::numbers::pi)) == 1;
    }

    void check_patch_points(const Patch& patch) {
        const std::string where = patch_path(patch.face, patch.index);
        constexpr int kTries = 64, kEnough = 12;
        int found = 0;
        for (int k = 1; k <= kTries && found < kEnough; ++k) {
            // Points of the additive recurrence with the golden ratio's plane analogue: even coverage.
            const Vec2 s(std::fmod(0.7548776662466927 * k, 1.0), std::fmod(0.5698402909980532 * k, 1.0));
            const Vec2 uv = patch.lo + s.cwiseProduct(patch.hi - patch.lo);
            if (!inside(patch, uv).value_or(false)) continue;
            ++found;
            const SurfacePoint x = lift(patch, uv);
            if (normal_.dot(x.pu.cross(x.pv)) <= 0) return note(where, "du x dv points towards the base");
            const Site& site = cell_.faces[patch.face].site;
            std::vector<Site> sites = cell_.faces[patch.face].extra_sites;
            sites.insert(sites.begin(), site);
            if (const auto what = contradiction(x.p, surface_rounding(patch, x, uv), sites))
                return note(where, *what);
        }
    }

    void check_trim(const Patch& patch, const Trim& trim, const std::string& where) {
        const std::size_t e = *trim.curve->edge;
        const auto& curve = edge_pieces_[e];
        const double begin = curve.front().begin, end = curve.back().end;
        constexpr int kSteps = 12;
        for (int k = 0; k <= kSteps; ++k) {
            const double s = static_cast<double>(k) / kSteps;
            const Vec2 uv = evaluate(trim.pieces, trim.begin() + s * (trim.end() - trim.begin()));
            const SurfacePoint x = lift(patch, uv);
            const Vec3 p = evaluate(curve, begin + (trim.curve->reversed ? 1 - s : s) * (end - begin));
            if (const double gap = (x.p - p).norm(); gap > 2 * full_error(e) + surface_rounding(patch, x, uv))
                return note(
                    where,
                    fmt::format("lifts to a curve {:.3g} away from edge {} at the same parameter", gap, e));
        }
    }

    // --- Completeness -------------------------------------------------------------------------------

    /// The (u, v) whose surface point stands over chart point q: Newton, exact in one step where the patch
    /// is the graph over its own parameters.
    std::optional<Vec2> parameters(const Patch& patch, const Vec2& q) const {
        Vec2 uv = 0.5 * (patch.lo + patch.hi);
        for (int k = 0; k < 50; ++k) {
            const SurfacePoint x = lift(patch, uv);
            Eigen::Matrix2d jacobian;
            jacobian << e1_.dot(x.pu), e1_.dot(x.pv), e2_.dot(x.pu), e2_.dot(x.pv);
            const Vec2 step = jacobian.inverse() * (q - chart(x.p));
            if (!step.allFinite()) return std::nullopt;
            uv += step;
            if (step.norm() <= kNearEdge * 1e-2 * (patch.hi - patch.lo).norm()) return uv;
        }
        return std::nullopt;
    }

    void check_samples() {
        const std::vector<Vec2> polygon = region();
        if (polygon.size() < 3) return note("scene.box", "misses the base plane");
        Vec2 lo = polygon[0], hi = polygon[0];
        for (const Vec2& p : polygon) {
            lo = lo.cwiseMin(p);
            hi = hi.cwiseMax(p);
        }
        std::mt19937_64 rng(options_.seed);
        std::uniform_real_distribution<double> unit(0, 1);
        const std::uint32_t tries = 20 * options_.samples;  // the polygon may be a sliver of its bounds
        for (std::uint32_t k = 0, asked = 0; k < tries && asked < options_.samples; ++k) {
            const Vec2 q = lo + Vec2(unit(rng), unit(rng)).cwiseProduct(hi - lo);
            if (!within(polygon, q, kNearEdge * scene_.box.diagonal())) continue;
            ++asked;
            if (!check_sample(q)) return;
        }
    }

    /// Is q inside a convex counter-clockwise polygon, at least `margin` from each side?
    static bool within(const std::vector<Vec2>& polygon, const Vec2& q, double margin) {
        for (std::size_t i = 0; i < polygon.size(); ++i) {
            const Vec2 d = polygon[(i + 1) % polygon.size()] - polygon[i], r = q - polygon[i];
            if (d.x() * r.y() - d.y() * r.x() < margin * d.norm()) return false;
        }
        return true;
    }

    /// False after a finding that would only repeat itself.
    bool check_sample(const Vec2& q) {
        std::vector<const Patch*> found;
        SurfacePoint surface{};
        Vec2 uv;
        for (const Patch& patch : patches_) {
            if ((q.array() < patch.foot_lo.array()).any() || (q.array() > patch.foot_hi.array()).any())
                continue;
            const auto at = parameters(patch, q);
            if (!at) continue;
            const auto in = inside(patch, *at);
            if (!in) return true;
            if (!*in) continue;
            found.push_back(&patch);
            uv = *at;
            surface = lift(patch, uv);
        }
        const Vec3 f = from_chart(q);
        const double t = brute_height(f);
        const Vec3 top = f + t * normal_;
        const std::string point = fmt::format("base point ({}, {}, {})", f.x(), f.y(), f.z());
        if (found.empty()) {
            note("faces", fmt::format("{}, owned by {}, lies under no face", point, title(owner(top, t))));
            return false;
        }
        if (found.size() > 1) {
            note(face_path(found[1]->face), fmt::format("{} lies under face {} too", point, found[0]->face));
            return false;
        }
        const Site& site = cell_.faces[found[0]->face].site;
        const double slack = surface_rounding(*found[0], surface, uv);
        if (std::abs(excess(site, top, t)) > slack + site_rounding(site)) {
            note(face_path(found[0]->face),
                 fmt::format("{} belongs to {}, not to {}", point, title(owner(top, t)), title(site)));
            return true;
        }
        if (const auto what = contradiction(surface.p, slack, std::span(&site, 1)))
            note(patch_path(found[0]->face, found[0]->index), *what);
        return true;
    }

    /// Who bounds the cell at p, above a base point at clearance r.
    Site owner(const Vec3& p, double r) const {
        Site best = Site::box_side(0);
        double least = HUGE_VAL;
        for (std::uint32_t s = 0; s < 6; ++s)
            if (inside_side(s, p) < least && (s % 2 ? normal_[s / 2] : -normal_[s / 2]) > 0) {
                best = Site::box_side(s);
                least = inside_side(s, p);
            }
        for (std::uint32_t i = 0; i < scene_.objects.size(); ++i)
            if (const double e = distance(scene_.objects[i], p) - r; e < least) {
                best = Site::object(i);
                least = e;
            }
        return best;
    }

    // --- Measures -----------------------------------------------------------------------------------

    /// Volume below, area of and base area below a trimmed patch. Green's theorem: the integral over the
    /// region is that of I(u, v) dv along the loops, I the integral of the density from a fixed u.
    Integral<Triple> integrate_patch(const Patch& patch) const {
        const double u0 = 0.5 * (patch.lo.x() + patch.hi.x());
        const auto density = [&](double u, double v) {
            const SurfacePoint s = lift(patch, {u, v});
            const Vec3 across = s.pu.cross(s.pv);
            const double shadow = normal_.dot(across);
            return Triple(height(s.p) * shadow, across.norm(), shadow);
        };
        const Vec2 extent = patch.hi - patch.lo;
        Triple most = Triple::Zero();
        for (const double s : {0.0, 0.5, 1.0})
            for (const double t : {0.0, 0.5, 1.0})
                most = most.max(density(patch.lo.x() + s * extent.x(), patch.lo.y() + t * extent.y()).abs());
        // Parameters are rounded at their size, which for a thin patch far out is more than rounding of the
        // integral.
        const Vec2 size = patch.lo.cwiseAbs().cwiseMax(patch.hi.cwiseAbs());
        const Triple inner_floor = kRounding * size.x() * most;
        const Triple floor = kRounding * (size.x() * extent.y() + size.y() * extent.x()) * most;
        Integral<Triple> total{Triple::Zero(), Triple::Zero()};
        for (const auto& loop : patch.loops)
            for (const Trim& trim : loop)
                for (const auto& piece : trim.pieces) {
                    Triple inner_error = Triple::Zero();
                    const auto part = integrate(
                        [&](double t) -> Triple {
                            const auto [q, d] = piece.evaluate(t);
                            if (d.y() == 0) return Triple::Zero();
                            const auto inner = integrate([&](double u) { return density(u, q.y()); }, u0,
                                                         q.x(), inner_floor);
                            inner_error = inner_error.max(inner.error * std::abs(d.y()));
                            return inner.value * d.y();
                        },
                        piece.begin, piece.end, floor);
                    total.value += part.value;
                    total.error += part.error + floor + inner_error * (piece.end - piece.begin);
                }
        return total;
    }

    void compare(const std::string& where, double stated, double found, double tolerance) {
        if (!(std::abs(stated - found) <= tolerance))
            note(where,
                 fmt::format("is {}, integration gives {} (tolerance {:.3g})", stated, found, tolerance));
    }

    /// Between a piece of a rim edge and the base.
    double wall_area(const Bezier<3>& piece) const {
        const auto density = [&](double t) {
            const auto [p, d] = piece.evaluate(t);
            return Scalar(height(p) * (d - normal_.dot(d) * normal_).norm());
        };
        const Scalar floor(rounding() * scene_.box.diagonal());
        return integrate(density, piece.begin, piece.end, floor).value[0];
    }

    void check_integrals() {
        const Measures& m = cell_.measures;
        check_amount("measures.volume_error", m.volume_error);
        check_amount("measures.area_error", m.area_error);
        double volume = 0, area = 0, box_area = 0, shadow = 0;
        double edge_errors = 0;  // area between the stated and the true edges
        for (std::size_t e = 0; e < cell_.edges.size(); ++e)
            edge_errors += cell_.edges[e].length * full_error(e);
        Triple error = Triple::Zero();
        std::vector<double> face_areas(cell_.faces.size()), face_errors(cell_.faces.size());
        for (const Patch& patch : patches_) {
            const auto part = integrate_patch(patch);
            volume += part.value[0];
            shadow += part.value[2];
            face_areas[patch.face] += part.value[1];
            face_errors[patch.face] += part.error[1];
            (cell_.faces[patch.face].site.is_object() ? area : box_area) += part.value[1];
            error += part.error;
        }
        const double length_rounding = rounding(), area_rounding = length_rounding * scene_.box.diagonal();
        const double slack = m.area_error + area_rounding + 2 * edge_errors;
        for (std::size_t f = 0; f < cell_.faces.size(); ++f)
            compare(face_path(f) + ".area", cell_.faces[f].area, face_areas[f], slack + face_errors[f]);
        compare("measures.area", m.area, area, slack + error[1]);
        // The walls of the cell stand over the rim, on the box.
        bool touches =
            std::ranges::any_of(cell_.faces, [](const CellFace& f) { return !f.site.is_object(); });
        for (std::size_t e = 0; e < edge_pieces_.size(); ++e) {
            if (!rim_side_[e]) continue;
            touches = true;
            for (const auto& piece : edge_pieces_[e]) box_area += wall_area(piece);
        }
        compare("measures.box_area", m.box_area, box_area, slack + error[1] + kLengthError * box_area);
        if (m.touches_box != touches)
            note("measures.touches_box", fmt::format("is {}, must be {}", m.touches_box, touches));
        compare("measures.volume", m.volume, volume,
                m.volume_error + error[0] + (area_rounding + 2 * edge_errors) * scene_.box.diagonal());

        double polygon_area = 0;
        const std::vector<Vec2> polygon = region();
        for (std::size_t i = 0; i < polygon.size(); ++i) {
            const Vec2 p = polygon[i] - polygon[0], q = polygon[(i + 1) % polygon.size()] - polygon[0];
            polygon_area += 0.5 * (p.x() * q.y() - p.y() * q.x());
        }
        compare("measures.base_area", m.base_area, polygon_area, area_rounding);
        if (std::abs(shadow - polygon_area) > area_rounding + error[2] + 2 * edge_errors)
            note("faces",
                 fmt::format("stand over an area of {}, the base region has {}", shadow, polygon_area));
        if (m.body_volume != 0)
            note("measures.body_volume", fmt::format("is {}, a plane has none", m.body_volume));
    }

    /// Least and greatest height on the vertices, along the edges and, for the least, at a stationary point
    /// within a face: over a plane base every bisector is a convex height.
    void check_clearances() {
        double least = HUGE_VAL, greatest = -HUGE_VAL, error = rounding();
        const auto meet = [&](double h) {
            least = std::min(least, h);
            greatest = std::max(greatest, h);
        };
        for (const CellVertex& v : cell_.vertices) {
            meet(height(v.point));
            error = std::max(error, rounding() + v.error);
        }
        for (std::size_t e = 0; e < edge_pieces_.size(); ++e) {
            error = std::max(error, rounding() + full_error(e));
            for (const auto& piece : edge_pieces_[e])
                for (const double sign : {-1.0, 1.0}) meet(sign * lowest_along(piece, sign));
        }
        for (const Patch& patch : patches_)
            if (const auto h = stationary_height(patch)) meet(*h);
        const Measures& m = cell_.measures;
        if (!(std::abs(m.min_clearance - least) <= error))
            note("measures.min_clearance",
                 fmt::format("is {}, the least found is {}", m.min_clearance, least));
        if (!(std::abs(m.max_clearance - greatest) <= error))
            note("measures.max_clearance",
                 fmt::format("is {}, the greatest found is {}", m.max_clearance, greatest));
    }

    /// Minimum of sign * height along a piece: the best of a few samples, refined by golden section.
    double lowest_along(const Bezier<3>& piece, double sign) const {
        constexpr int kSteps = 16;
        const auto value = [&](double s) {
            return sign * height(piece.evaluate(piece.begin + s * (piece.end - piece.begin))[0]);
        };
        int best = 0;
        for (int k = 1; k <= kSteps; ++k)
            if (value(k / double(kSteps)) < value(best / double(kSteps))) best = k;
        double lo = std::max(0, best - 1) / double(kSteps), hi = std::min(kSteps, best + 1) / double(kSteps);
        double lowest = value(best / double(kSteps));
        constexpr double kGolden = 1 / std::numbers::phi;
        // The value is flat to second order, so half the digits of the place give all of the value.
        while (hi - lo > 1e-8) {
            const double a = hi - kGolden * (hi - lo), b = lo + kGolden * (hi - lo);
            const double fa = value(a), fb = value(b);
            lowest = std::min({lowest, fa, fb});
            (fa < fb ? hi : lo) = fa < fb ? b : a;
        }
        return lowest;
    }

    /// The height where it is stationary, if inside the loops. Newton with differences of the gradient.
    std::optional<double> stationary_height(const Patch& patch) const {
        const Vec2 extent = patch.hi - patch.lo;
        const auto gradient = [&](const Vec2& uv) {
            const SurfacePoint s = lift(patch, uv);
            return Vec2(normal_.dot(s.pu), normal_.dot(s.pv));
        };
        Vec2 uv = 0.5 * (patch.lo + patch.hi);
        for (int k = 0; k < 20; ++k) {
            Eigen::Matrix2d hessian;
            for (int i = 0; i < 2; ++i) {
                const Vec2 h = Vec2::Unit(i) * (0.25 * extent[i]);
                hessian.col(i) = (gradient(uv + h) - gradient(uv - h)) / (0.5 * extent[i]);
            }
            const Vec2 step = hessian.inverse() * gradient(uv);
            if (!step.allFinite()) return std::nullopt;
            uv -= step;
            if ((uv.array() < patch.lo.array()).any() || (uv.array() > patch.hi.array()).any())
                return std::nullopt;
            if (step.norm() <= 1e-10 * extent.norm()) break;
        }
        // On the boundary itself the edges tell.
        if (!inside(patch, uv).value_or(false)) return std::nullopt;
        return height(lift(patch, uv).p);
    }

    void check_neighbors() {
        std::map<std::uint32_t, double> owned;
        for (const CellFace& f : cell_.faces)
            if (f.site.is_object()) owned[f.site.index] += f.area;
        std::map<std::uint32_t, int> listed;
        for (std::size_t i = 0; i < cell_.neighbors.size(); ++i) {
            const std::uint32_t object = cell_.neighbors[i];
            const std::string where = fmt::format("neighbors[{}]", i);
            if (!owned.contains(object))
                note(where, fmt::format("object {} owns no face", object));
            else if (listed[object]++)
                note(where, fmt::format("object {} is listed twice", object));
            else if (i > 0 && owned.contains(cell_.neighbors[i - 1]) &&
                     owned[cell_.neighbors[i - 1]] <
                         owned[object] - 2 * cell_.measures.area_error - kRounding * owned[object])
                note(where, fmt::format("object {} owns more area than the one before it", object));
        }
        for (const auto& [object, area] : owned)
            if (!listed.contains(object))
                note("neighbors", fmt::format("lack object {}, which owns a face", object));
    }

    void check_report() {
        check_amount("report.seconds.bisectors", cell_.report.seconds_bisectors);
        check_amount("report.seconds.envelope", cell_.report.seconds_envelope);
        check_amount("report.seconds.patches", cell_.report.seconds_patches);
    }

    const Cell& cell_;
    const Scene& scene_;
    CheckOptions options_;
    Vec3 origin_, normal_, e1_, e2_;
    double scale_ = 0;
    std::vector<double> object_rounding_;
    struct Spheres {
        std::vector<double> x, y, z, reduced_radius;  // the radius less rounding
        std::vector<std::uint32_t> object;
        void add(std::uint32_t i, const Sphere& s, double rounding) {
            x.push_back(s.center.x());
            y.push_back(s.center.y());
            z.push_back(s.center.z());
            reduced_radius.push_back(s.radius - rounding);
            object.push_back(i);
        }
    } spheres_;
    std::vector<std::uint32_t> others_;  // objects that are no spheres
    std::vector<std::vector<Bezier<3>>> edge_pieces_;
    std::vector<std::vector<Use>> uses_;                  // by edge
    std::vector<std::optional<std::uint32_t>> rim_side_;  // by edge: the side it runs over
    std::vector<Patch> patches_;
    std::vector<Finding> findings_;
};

}  // namespace

std::vector<Finding> check_cell(const Cell& cell, const CheckOptions& options) {
    return Judge(cell, options).run();
}

}  // namespace vcell
