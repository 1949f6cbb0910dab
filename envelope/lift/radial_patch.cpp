#include "radial_patch.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "joined_spans.hpp"
#include "radial_patch_terms.hpp"

namespace vcell {

namespace {

using namespace radial_patch_terms;

// Of a cylinder over a cylinder base: v is taken to be nearly constant on lines of the surface where
// the axes' distance squared, less delta^2, is less than this part of the squared distance of the axis beside
// the face. There S_v is 1 / singular times as long as elsewhere at most.
constexpr double singular = 1.0 / 64;
// And out of reach of a face beyond this many times the distance of the axis beside it.
constexpr double far = 64;

// Control points are means by weights: some ten operations each, coefficients within a few u.
constexpr double rounding_each = 16 * std::numeric_limits<double>::epsilon();

}  // namespace

RadialPatch::RadialPatch(const RadialBaseProblem& problem, FormId form, const Vec3& middle, double y,
                         bool wide) {
    coefficients_.fill(Vector4d::Zero());
    const Object& object = problem.objects[form];
    if (is_vessel(object) && !problem.chart.is_sphere()) {
        set_in_vessel(problem, form, middle, y);
        return;
    }
    if (const auto* plane = std::get_if<Plane>(&object)) {
        // Away from the base.
        Vec3 normal = plane->normal.normalized();
        if (normal.dot(plane->point - Vec3(0, y, 0)) < 0) normal = -normal;
        const double offset = normal.dot(plane->point);
        if (is_wall(problem, form))
            set_plane(plane->point, normal);
        else if (problem.chart.is_sphere())
            set_paraboloid(offset, normal, problem.chart.radius);
        else
            set_about_base(middle, across_y(normal), 1, {offset + problem.chart.radius, -normal.y(), 0});
    } else if (const auto* sphere = std::get_if<Sphere>(&object)) {
        const Vec3& c = sphere->center;
        const double delta = sphere->radius - problem.chart.radius, near = across_y(c).norm();
        if (!problem.chart.is_sphere())
            set_about_base(middle, 2 * across_y(c), 2 * delta,
                           {(near - delta) * (near + delta) + c.y() * c.y(), -2 * c.y(), 1});
        else if (delta == 0)
            set_plane(0.5 * c, c.normalized());
        else
            set_stereographic(c, delta, ball_power(problem, form), middle, wide);
    } else if (const auto* ball = std::get_if<HollowSphere>(&object)) {
        set_in_sphere(ball->center, ball->radius + problem.chart.radius, ball_power(problem, form), middle);
    } else if (const auto* tube = std::get_if<HollowCylinder>(&object)) {
        set_about_object(tube->axis, tube->point, tube->radius + problem.chart.radius, &middle);
    } else if (const auto* cone = std::get_if<HollowCone>(&object)) {
        set_in_cone(*cone, problem.chart.radius, middle);
    } else {
        const auto& cylinder = std::get<Cylinder>(object);
        if (problem.chart.is_sphere())
            set_about_object(cylinder.axis, cylinder.point, cylinder.radius - problem.chart.radius);
        else
            set_about_axes(problem, cylinder, middle, y, wide);
    }
}

void RadialPatch::set_axes(Kind kind, const Vec3& x, const Vec3& y, const Vec3& origin) {
    kind_ = kind;
    axes_ = {x, y, x.cross(y)};
    origin_ = origin;
    if (kind == Kind::Planar)
        coordinates_ = {PatchCoordinate::linear(x, origin), PatchCoordinate::linear(y, origin)};
    if (kind == Kind::Stereographic)
        coordinates_ = {PatchCoordinate::half_angle(origin, axes_[2], x, 0),
                        PatchCoordinate::half_angle(origin, axes_[2], y, 0)};
}

void RadialPatch::set_coordinates(const PatchCoordinate& u) {
    coordinates_[0] = u;
    coordinates_[1].numerator << along_, along_across_, along_start_;
}

void RadialPatch::add(const Polynomial& f, const Polynomial& g, const Vector4d& h) {
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) coefficients_[3 * i + j] += f[i] * g[j] * h;
}

void RadialPatch::add_direction(double power, const Vec3& z) {
    const Vector4d pole = 0.5 * power * vector(z);
    add(1, 0, power * vector(axes_[0]));
    add(0, 1, power * vector(axes_[1]));
    add(0, 0, pole);
    add(2, 0, -pole);
    add(0, 2, -pole);
}

void RadialPatch::set_plane(const Vec3& point, const Vec3& normal) {
    const Vec3 x = normal.unitOrthogonal(), origin = point.dot(normal) * normal;
    set_axes(Kind::Planar, x, normal.cross(x), origin);
    add(0, 0, vector(origin) + weight);
    add(1, 0, vector(axes_[0]));
    add(0, 1, vector(axes_[1]));
}

// With h the distance from the plane: |S| = R0 + h and |S|^2 = (d - h)^2 + u^2 + v^2.
void RadialPatch::set_paraboloid(double distance, const Vec3& normal, double radius) {
    set_plane(distance * normal, normal);
    degree_ = {2, 2};
    const double before = 0.5 / (radius + distance);
    const Vector4d back = -vector(normal);
    add(0, 0, 0.5 * (distance - radius) * back);
    add(2, 0, before * back);
    add(0, 2, before * back);
}

void RadialPatch::set_stereographic(const Vec3& c, double delta, double power, const Vec3& middle,
                                    bool wide) {
    degree_ = {2, 2};
    const double length = c.norm();
    const Vec3 z = c / length;
    if (wide) return set_confocal(z, length, delta, power, middle);
    const Vec3 x = across(z, middle);
    set_axes(Kind::Stereographic, x, z.cross(x), Vec3::Zero());
    const double sum = delta < 0 ? power / (length - delta) : length + delta, difference = power / sum;
    add(0, 0, sum * weight);
    add(2, 0, -difference * weight);
    add(0, 2, -difference * weight);
    add_direction(power, axes_[2]);
}

// The directions at infinity make the angle acos(-delta / |c|) with c; that on the other side of `middle` is
// -axes_[2]. (u, v) is (|p| + axes_[2].p, axes_[1].p), which is counter-clockwise with axes_[1] = axes_[0] x
// axes_[2].
void RadialPatch::set_confocal(const Vec3& z, double length, double delta, double power, const Vec3& middle) {
    const Vec3 x = across(z, middle);
    const double cosine = -delta / length, sine = std::sqrt(power) / length;
    const Vec3 opposite = sine * x - cosine * z, across_it = sine * z + cosine * x;
    kind_ = Kind::Confocal;
    axes_ = {across_it, across_it.cross(opposite), opposite};
    origin_ = Vec3::Zero();
    coordinates_[0].numerator << opposite, 1, 0;
    coordinates_[1] = PatchCoordinate::linear(axes_[1], origin_);
    const double a = 0.5 * std::sqrt(power), b = 0.5 * delta / a;
    add(1, 0, a * vector(axes_[0]));
    add(2, 0, -b * vector(axes_[0]));
    add(1, 1, vector(axes_[1]));
    add(0, 0, -0.5 * a * a * vector(opposite));
    add(1, 0, a * b * vector(opposite));
    add(2, 0, 0.5 * (1 - b) * (1 + b) * vector(opposite));
    add(0, 2, -0.5 * vector(opposite));
    add(1, 0, weight);
}

// S = c + v d + r n / W with |S| = r - delta, or with |S| = delta - r from within a vessel: then all of it is
// negated, and the base lies on the other side.
void RadialPatch::set_about_object(const Vec3& axis, const Vec3& point, double delta, const Vec3* middle) {
    degree_ = {2, 2};
    is_in_tube_ = middle != nullptr;
    const double side = is_in_tube_ ? -1 : 1;
    const Vec3 d = axis.normalized(), c = point - point.dot(d) * d,
               x = is_in_tube_ ? across(d, *middle) : Vec3(-c.normalized());
    // d leaves the cell's inside on the left, or on the right.
    set_axes(Kind::AboutObject, x, -side * d.cross(x), c);
    along_ = d;
    set_coordinates(is_in_tube_ ? PatchCoordinate::hollow_half_angle(c, x, axes_[1], delta)
                                : PatchCoordinate::half_angle(c, x, axes_[1], delta));
    const double length = c.norm(), squared = side * (length - delta) * (length + delta);
    const double cx = is_in_tube_ ? c.dot(x) : -length, cy = is_in_tube_ ? c.dot(axes_[1]) : 0;
    const Polynomial w{-side * (cx + delta), -side * 2 * cy, side * (cx - delta)},
        half{0.5 * squared, 0, side * 0.5};
    add(w, one, vector(c) + weight);
    add(w, linear, vector(d));
    add(angle_cos, half, vector(axes_[0]));
    add(angle_sin, half, vector(axes_[1]));
}

// t = C(y) W / w with w = b.n + b0 W, y counted from `start`.
void RadialPatch::set_about_base(const Vec3& middle, const Vec3& b, double b0, const Polynomial& C,
                                 double start) {
    degree_ = {2, C[2] == 0 ? 1 : 2};
    const Vec3 x = across(Vec3::UnitY(), middle);
    set_axes(Kind::AboutBase, x, Vec3::UnitY().cross(x), Vec3::Zero());
    along_ = Vec3::UnitY();
    along_start_ = -start;
    set_coordinates(PatchCoordinate::half_angle(origin_, x, axes_[1], 0));
    const Polynomial w{b0 + b.dot(axes_[0]), 2 * b.dot(axes_[1]), b0 - b.dot(axes_[0])};
    add(w, one, weight);
    add(w, {start, 1, 0}, vector(Vec3::UnitY()));
    add(angle_cos, C, vector(axes_[0]));
    add(angle_sin, C, vector(axes_[1]));
}

void RadialPatch::set_about_axes(const RadialBaseProblem& problem, const Cylinder& cylinder,
                                 const Vec3& middle, double y, bool wide) {
    const double delta = cylinder.radius - problem.chart.radius;
    Vec3 d = cylinder.axis.normalized();
    const Vec3 a = cylinder.point + d * d.dot(Vec3(0, y, 0) - cylinder.point), near = across_y(a);
    const double sine = across_y(d).norm();
    if (sine == 0) {
        if (delta == 0) return set_plane(0.5 * near, near.normalized());
        return set_about_base(middle, 2 * near, 2 * delta, {near.squaredNorm() - delta * delta, 0, 0});
    }
    // Which sign of d? Where the lines v = const lie on the surface, or nearly, it has to be right for this
    // half of the base. Otherwise the one in which 1 + d_y is larger.
    const Vec3 d_across = across_y(d) / sine;
    const double apart = near.cross(d_across).norm();
    const double crossing = a.y() - near.dot(d_across) / sine * d.y(), side = y < crossing ? -1 : 1;
    const double beyond = sine * (y - crossing);
    const bool is_near = (apart - delta) * (apart + delta) < singular * beyond * beyond;
    // With 1 + |d_y| the lines leave the base's axis by that much over sine for each length along it, from
    // where C vanishes. Next to parallel axes they are out of reach; and the other sign of d would leave
    // little of the digits of v.
    const double nearest = std::clamp(crossing, problem.stretch[0], problem.stretch[1]),
                 zero = std::sqrt(std::max(0.0, (delta - apart) * (delta + apart))) / sine;
    const bool is_far =
        (std::abs(nearest - crossing) - zero) * (1 + std::abs(d.y())) > far * sine * std::abs(beyond);
    const bool is_planar = delta == 0 && meets_base_axis(cylinder);
    const bool is_singular = is_planar || ((wide || is_near) && !is_far);
    if (is_singular ? side * d.dot(middle) < 0 : d.y() < 0) d = -d;
    if (is_singular) half_ = side * across_y(d);
    if (is_planar) {
        const double fall = d.y() > 0 ? -sine * sine / (1 + d.y()) : d.y() - 1;
        return set_plane(Vec3(0, crossing, 0), (side * Vec3(d.x(), fall, d.z())).normalized());
    }

    degree_ = {2, 2};
    const Vec3 x = across(Vec3::UnitY(), middle);
    set_axes(Kind::AboutBase, x, Vec3::UnitY().cross(x), Vec3::Zero());
    const double scale = d.y() > 0 ? 1 / (1 + d.y()) : (1 - d.y()) / (sine * sine);
    along_ = scale * (d + Vec3::UnitY());
    along_start_ = -along_.dot(a);
    set_coordinates(PatchCoordinate::half_angle(origin_, x, axes_[1], 0));
    // w = q.n + delta W, t = C W / (2 w) and y w = (start + v) w - C n.d' / (2 (1 + d_y)).
    const double start = a.y() + scale * a.dot(across_y(d));
    const Polynomial half_C{0.5 * (near.norm() - delta) * (near.norm() + delta), near.dot(d),
                            0.5 * sine * sine};
    const auto normal_times = [&](const Vec3& p) -> Polynomial {
        const double along_x = p.dot(axes_[0]);
        return {along_x, 2 * p.dot(axes_[1]), -along_x};
    };
    Polynomial w = normal_times(near);
    w[0] += delta;
    w[2] += delta;
    const Polynomial turn = normal_times(d);
    const Vector4d y_axis = vector(Vec3::UnitY());
    add(w, one, weight);
    add(turn, linear, weight);
    add(w, {start, 1, 0}, y_axis);
    add(turn, {0, start, 1}, y_axis);
    add(turn, half_C, -scale * y_axis);
    add(angle_cos, half_C, vector(axes_[0]));
    add(angle_sin, half_C, vector(axes_[1]));
}

namespace {

// Blossoms: x -> (x + x') / 2, x^2 -> x x'.
template <int n>
Polynomial blossom(const std::array<double, 2>& range, int i) {
    const double a = range[n == 1 ? i : i > 1], b = range[n == 1 ? i : i > 0];
    return {1, 0.5 * a + 0.5 * b, a * b};
}

// RadialPatch::for_each_control() of degrees m and n, or of a total degree. Coefficients beyond are zero.
template <int m, int n, bool is_total, class Use>
void for_each_control_of(const RadialPatch& from, const std::array<double, 2>& u,
                         const std::array<double, 2>& v, Use& use) {
    std::array<Polynomial, m + 1> f;
    for (int i = 0; i <= m; ++i) f[i] = blossom<m>(u, i);
    for (int j = 0; j <= n; ++j) {
        const Polynomial g = blossom<n>(v, j);
        std::array<Vector4d, m + 1> row, size_of_row;
        for (int k = 0; k <= m; ++k) {
            row[k] = from.coefficient(k, 0);
            size_of_row[k] = row[k].cwiseAbs();
            for (int l = 1; l <= (is_total ? n - k : n); ++l) {
                const Vector4d term = g[l] * from.coefficient(k, l);
                row[k] += term;
                size_of_row[k] += term.cwiseAbs();
            }
        }
        for (int i = 0; i <= m; ++i) {
            Vector4d h = row[0], size = size_of_row[0];
            for (int k = 1; k <= m; ++k) {
                h += f[i][k] * row[k];
                size += std::abs(f[i][k]) * size_of_row[k];
            }
            if (!use(i * (n + 1) + j, h, size)) return;
        }
    }
}

}  // namespace

template <class Use>
void RadialPatch::for_each_control(const std::array<double, 2>& u, const std::array<double, 2>& v,
                                   Use use) const {
    if (degree_[0] == 1) return for_each_control_of<1, 1, true>(*this, u, v, use);
    if (degree_[1] == 1) return for_each_control_of<2, 1, false>(*this, u, v, use);
    if (kind_ == Kind::Planar || kind_ == Kind::Stereographic || kind_ == Kind::Confocal)
        return for_each_control_of<2, 2, true>(*this, u, v, use);
    for_each_control_of<2, 2, false>(*this, u, v, use);
}

namespace {

// Control points (P, w) with the sums of their terms' absolute values.
struct ControlNet {
    int m, n;
    std::vector<Vector4d> h, size;

    // The net of the same surface with both degrees one more, which may bring its weights above 0.
    ControlNet raised() const {
        ControlNet r{m + 1, n + 1, {}, {}};
        const auto along_v = [this](const std::vector<Vector4d>& c, int i, int j) -> Vector4d {
            const double share = static_cast<double>(j) / (n + 1);
            Vector4d sum = Vector4d::Zero();
            if (j > 0) sum += share * c[i * (n + 1) + j - 1];
            if (j <= n) sum += (1 - share) * c[i * (n + 1) + j];
            return sum;
        };
        for (int i = 0; i <= m + 1; ++i)
            for (int j = 0; j <= n + 1; ++j) {
                const double share = static_cast<double>(i) / (m + 1);
                for (const auto& [from, to] : {std::pair(&h, &r.h), std::pair(&size, &r.size)}) {
                    Vector4d sum = Vector4d::Zero();
                    if (i > 0) sum += share * along_v(*from, i - 1, j);
                    if (i <= m) sum += (1 - share) * along_v(*from, i, j);
                    to->push_back(sum);
                }
            }
        return r;
    }
    bool is_positive() const {
        return std::ranges::all_of(h, [](const Vector4d& p) { return p.w() > 0; });
    }
};

// A spheroid's weights are positive all over, but those of its control points over a wide rectangle in higher
// degrees only: of degree n they are above that of the middle of 1 + u^2 + v^2 less (u^2 + v^2) / (n - 1).
// Those of bisectors with tubes and cones seen from within are positive all around, and need it where faces
// reach far around. CAD programs read degrees up to 25.
constexpr int most_raised = 24;
// Raising takes four roundings each time, and there are 22 at most.
constexpr double rounding_of_raised = 7 * rounding_each;

}  // namespace

std::optional<RationalPatch> RadialPatch::raised_patch(const std::array<double, 2>& u,
                                                       const std::array<double, 2>& v, const BaseFrame& frame,
                                                       double& rounding) const {
    ControlNet net{degree_[0], degree_[1], {}, {}};
    const auto count = static_cast<std::size_t>((degree_[0] + 1) * (degree_[1] + 1));
    net.h.resize(count);
    net.size.resize(count);
    for_each_control(u, v, [&](int k, const Vector4d& h, const Vector4d& size) {
        net.h[k] = h;
        net.size[k] = size;
        return true;
    });
    while (!net.is_positive()) {
        if (net.m == most_raised) return std::nullopt;
        net = net.raised();
    }
    std::optional<RationalPatch> surface(RationalPatch{net.m, net.n, u, v, {}});
    double of_points = 0, of_weights = 0, far = 0;
    for (std::size_t k = 0; k < net.h.size(); ++k) {
        const Vector4d &h = net.h[k], &size = net.size[k];
        const Vec3 p = h.head<3>() / h.w(), world = frame.to_world(p);
        surface->points.push_back({world.x(), world.y(), world.z(), h.w() / net.h[0].w()});
        of_points = std::max(of_points, (size[0] + size[1] + size[2]) / h.w());
        of_weights = std::max(of_weights, size[3] / h.w());
        far = std::max(far, p.cwiseAbs().sum());
    }
    rounding = rounding_of_raised * (of_points + far * of_weights + frame.origin.norm());
    return surface;
}

std::optional<RationalPatch> RadialPatch::patch(const std::array<double, 2>& u,
                                                const std::array<double, 2>& v, const BaseFrame& frame,
                                                double& rounding) const {
    std::optional<RationalPatch> surface(RationalPatch{degree_[0], degree_[1], u, v, {}});
    surface->points.resize(static_cast<std::size_t>((degree_[0] + 1) * (degree_[1] + 1)));
    // The largest sums of the terms' absolute values over the weight: of a point's coordinates, and of its
    // weight.
    double scale = 1, of_points = 0, of_weights = 0, far = 0;
    bool is_positive = true;
    for_each_control(u, v, [&](int k, const Vector4d& h, const Vector4d& size) {
        is_positive = h.w() > 0;
        if (!is_positive) return false;
        const double over_w = 1 / h.w();
        if (k == 0) scale = over_w;
        const Vec3 p = h.head<3>() / h.w(), world = frame.to_world(p);
        surface->points[k] = {world.x(), world.y(), world.z(), scale * h.w()};
        of_points = std::max(of_points, (size[0] + size[1] + size[2]) * over_w);
        of_weights = std::max(of_weights, size[3] * over_w);
        far = std::max(far, std::abs(p[0]) + std::abs(p[1]) + std::abs(p[2]));
        return true;
    });
    rounding = rounding_each * (of_points + far * of_weights + frame.origin.norm());
    if (!is_positive) surface.reset();
    if (!is_positive && has_raised()) return raised_patch(u, v, frame, rounding);
    return surface;
}

bool RadialPatch::has_positive_net(const std::array<double, 2>& u, const std::array<double, 2>& v) const {
    bool is_positive = true;
    for_each_control(u, v, [&](int, const Vector4d& h, const Vector4d&) {
        is_positive = h.w() > 0;
        return is_positive;
    });
    return is_positive;
}

// Control points P_ij that are off by a_ij, and weights by r_ij of themselves, turn S = sum B_ij w_ij P_ij /
// sum B_ij w_ij off by no more than sum B_ij w_ij (a_ij + r_ij |P_ij - S|) / sum B_ij w_ij. In terms of h and
// size, with |S| <= sum B_ij |h_ij| / sum B_ij w_ij, these are quotients of functions in Bernstein form with
// coefficients that are not negative: over a part of the rectangle each is no more than the greatest quotient
// of the coefficients there.
double RadialPatch::rounding_along(const RationalCurve2& curve, const std::array<double, 2>& u,
                                   const std::array<double, 2>& v, const BaseFrame& frame,
                                   double enough) const {
    if (is_closed() || (has_raised() && !has_positive_net(u, v))) {
        double rounding = 0;
        patch(u, v, frame, rounding);
        return rounding;
    }
    // Each control point's sums of terms for points and weights, |h| and w.
    std::array<Vector4d, 9> net;
    for_each_control(u, v, [&](int k, const Vector4d& h, const Vector4d& size) {
        const double length = h.head<3>().cwiseAbs().sum();
        net[k] << size.head<3>().sum() + length / h.w() * size.w(), size.w(), length, h.w();
        return true;
    });
    const auto [m, n] = degree_;
    const std::array domains{u, v};
    using Rectangle = std::array<Range, 2>;  // each side from 0 to 1
    const auto over = [&](const Rectangle& part) {
        // The blossom of the three or two coefficients c(0), ... in one variable.
        const auto blossom = [](int degree, const Range& range, int i, const auto& c) -> Vector4d {
            if (degree == 1) return (1 - range[i]) * c(0) + range[i] * c(1);
            const double a = range[i > 1], b = range[i > 0];
            return (1 - a) * (1 - b) * c(0) + ((1 - a) * b + a * (1 - b)) * c(1) + a * b * c(2);
        };
        double of_points = 0, of_weights = 0, far = 0;
        for (int i = 0; i <= m; ++i)
            for (int j = 0; j <= n; ++j) {
                const auto row = [&](int k) {
                    return blossom(n, part[1], j, [&](int l) { return net[k * (n + 1) + l]; });
                };
                const Vector4d sum = blossom(m, part[0], i, row);
                of_points = std::max(of_points, sum[0] / sum[3]);
                of_weights = std::max(of_weights, sum[1] / sum[3]);
                far = std::max(far, sum[2] / sum[3]);
            }
        return rounding_each * (of_points + far * of_weights + frame.origin.norm());
    };
    // Around the first `count` of the control points (u w, v w, w). Those of other weights tell nothing.
    using Piece = std::array<Eigen::Vector3d, 6>;
    const auto part_around = [&](const Piece& piece, int count) {
        Rectangle part{{{0, 1}, {0, 1}}};
        for (int k = 0; k < count; ++k)
            if (!(piece[k].z() > 0)) return part;
        for (int axis = 0; axis < 2; ++axis) {
            const auto [first, last] = domains[axis];
            Range range = empty_range;
            for (int k = 0; k < count; ++k) {
                const double x = (piece[k][axis] / piece[k].z() - first) / (last - first);
                range = {std::min(range[0], x), std::max(range[1], x)};
            }
            const double off = 8 * std::numeric_limits<double>::epsilon() *
                               std::max(std::abs(first), std::abs(last)) / (last - first);
            part[axis] = {std::clamp(range[0] - off, 0.0, 1.0), std::clamp(range[1] + off, 0.0, 1.0)};
        }
        return part;
    };
    constexpr int most_halvings = 20;
    const int degree = curve.degree;
    const auto along = [&](const auto& self, Piece piece, int halvings) -> double {
        const double bound = over(part_around(piece, degree + 1));
        const bool is_worth_while = bound > enough && bound > 2 * over(part_around(piece, 1));
        if (!is_worth_while || halvings == most_halvings) return bound;
        Piece left;
        for (int level = 0; level <= degree; ++level) {
            left[level] = piece[0];
            for (int k = 0; k < degree - level; ++k) piece[k] = 0.5 * (piece[k] + piece[k + 1]);
        }
        return std::max(self(self, left, halvings + 1), self(self, piece, halvings + 1));
    };
    double most = 0;
    for (std::size_t first = 0; first + 1 < curve.points.size(); first += degree) {
        Piece piece;
        for (int k = 0; k <= degree; ++k) {
            const Eigen::Vector3d& p = curve.points[first + k];
            piece[k] << p.head<2>() * p.z(), p.z();
        }
        most = std::max(most, along(along, piece, 0));
    }
    return most;
}

}  // namespace vcell
