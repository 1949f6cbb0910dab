#include "../../primitives/bases/radial_base.hpp"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "../../core/errors.hpp"
#include "../../primitives/bases/nested_balls.hpp"
#include "../../primitives/charts/sphere_chart.hpp"
#include "test_support.hpp"

using namespace vcell;
using Kind = InputError::Kind;
using Real = boost::multiprecision::cpp_bin_float_100;

namespace {

constexpr double u = std::numeric_limits<double>::epsilon() / 2;

using RealVector = std::array<Real, 3>;

Real real(const Exact& v) {
    Real sum = 0;
    for (Exact rest = v; rest.sign() != Sign::Zero;) {
        const double part = rest.enclosure().mid();
        sum += part;
        rest -= part;
    }
    return sum;
}

RealVector real(const Vec3& p) { return {p.x(), p.y(), p.z()}; }
Real dot(const RealVector& p, const RealVector& q) { return p[0] * q[0] + p[1] * q[1] + p[2] * q[2]; }
RealVector along(const RealVector& p, const Real& t, const RealVector& d) {
    return {p[0] + t * d[0], p[1] + t * d[1], p[2] + t * d[2]};
}

// Signed for balls and cylinders (negative inside), as the additively weighted diagram wants it.
Real distance(const Object& object, const RealVector& p) {
    if (const auto* sphere = std::get_if<Sphere>(&object)) {
        const RealVector m = along(p, -1, real(sphere->center));
        return sqrt(dot(m, m)) - sphere->radius;
    }
    if (const auto* plane = std::get_if<Plane>(&object)) {
        const RealVector n = real(plane->normal);
        return abs(dot(n, along(p, -1, real(plane->point)))) / sqrt(dot(n, n));
    }
    const auto& cylinder = std::get<Cylinder>(object);
    const RealVector a = real(cylinder.axis), m = along(p, -1, real(cylinder.point));
    const Real s = dot(m, a);
    return sqrt(abs(dot(m, m) - s * s / dot(a, a))) - cylinder.radius;
}

Scene scene_of(const Object& base, std::vector<Object> objects, double half = 10) {
    Scene scene;
    scene.base = base;
    scene.objects = std::move(objects);
    Vec3 middle = Vec3::Zero();
    if (const auto* sphere = std::get_if<Sphere>(&base)) middle = sphere->center;
    if (const auto* cylinder = std::get_if<Cylinder>(&base)) middle = cylinder->point;
    scene.box = {middle - Vec3::Constant(half), middle + Vec3::Constant(half)};
    return scene;
}

RadialBaseProblem problem_of(const Scene& scene) {
    validate(scene);
    return radial_base_problem(scene);
}

InputError error_of(const Scene& scene) {
    try {
        problem_of(scene);
    } catch (const InputError& error) {
        return error;
    }
    FAIL("the scene was accepted");
    std::abort();
}

// 1 / distance by the exact coefficients at a chart point, and by the doubles of circular forms.
Real nearness(const FormFamily& family, FormId f, const Vec2& p) {
    const bool stereographic = family.chart == RadialChart::Stereographic;
    const bool front = stereographic || p.x() <= 1;
    const Real x = front ? p.x() : p.x() - 2, y = p.y();
    const Real r2 = x * x + (stereographic ? Real(y * y) : Real(0)), W = 1 + r2;
    if (family.is_circular(f)) {
        const ExactForm e = family.exact(f);
        return -(real(e.K) * r2 + real(e.A) * x + real(e.B) * y + real(e.C)) / real(e.W) / W;
    }
    const Real sign = front ? 1 : -1;
    const RealVector n{sign * 2 * x, stereographic ? Real(2 * y) : Real(0), sign * (1 - r2)};
    const RadialForm& q = family.radial_form(f);
    const Real A = dot({real(q.a[0]), real(q.a[1]), real(q.a[2])}, n);
    Real B = real(q.b0) * W + dot({real(q.b[0]), real(q.b[1]), real(q.b[2])}, n);
    Real C = real(q.c[0]);
    if (!stereographic) {
        B += y * real(q.slope) * A;
        C += y * (real(q.c[1]) + y * real(q.c[2]));
    }
    REQUIRE(C > 0);
    return (B + sqrt(B * B + A * A * C)) / C / W;
}

std::vector<Site> sites_of(const RadialBaseProblem& problem, FormId f) {
    return {problem.sites[f].begin(), problem.sites[f].end()};
}

// The form whose sites include this one.
FormId form_of(const RadialBaseProblem& problem, Site site) {
    for (const FormId f : problem.sites.ids())
        if (std::ranges::find(problem.sites[f], site) != problem.sites[f].end()) return f;
    return {};
}

// The signed distance to the object falls behind t - R0 exactly where the form says, on the ray along
// `normal` from `origin`.
void check_height(const RealVector& origin, const RealVector& normal, double radius, const Object& object,
                  const Real& q, double scale, double tolerance) {
    const auto ahead = [&](const Real& t) {
        return Real(distance(object, along(origin, t, normal)) - (t - radius));
    };
    const Real far = 1e9 * scale;
    if (q * far < 1) {
        CHECK(ahead(far * (1 - Real(tolerance))) > -tolerance * far);
        return;
    }
    // A far point moves by t^2 / scale times what its direction does.
    const Real t = 1 / q, slack = tolerance * (scale + t + t * t / scale);
    const Real noise = tolerance * (scale + t);
    CHECK(ahead(t - slack) >= -noise);
    CHECK(ahead(t + slack) <= noise);
}

struct Random {
    std::mt19937_64 rng{test_seed()};
    double unit() { return std::uniform_real_distribution(-1.0, 1.0)(rng); }
    Vec3 vector() { return {unit(), unit(), unit()}; }
    Vec3 direction() {
        for (;;)
            if (const Vec3 v = vector(); v.norm() > 0.1 && v.norm() < 1) return v.normalized();
    }
    double pick(std::initializer_list<double> values) { return values.begin()[rng() % values.size()]; }
};

// A ball, a plane or a cylinder that stays clear of |p - center| < reach, or overlaps it a little.
Object random_object(Random& r, const Vec3& center, double reach, int kind) {
    const Vec3 d = r.direction();
    const double far = reach * (1.2 + std::abs(r.unit()));
    if (kind == 0) return Sphere{center + far * d, 0.5 * reach * std::abs(r.unit())};
    if (kind == 1) return Plane{center + far * d, r.pick({-3, 0.01, 1}) * d};
    return Cylinder{center + far * d, 7 * d.cross(r.direction()), 0.5 * reach * std::abs(r.unit())};
}

}  // namespace

TEST_CASE("radial base: over spheres, heights are where base and object are equally far") {
    Random r;
    for (int round = 0; round < 300; ++round) {
        const double scale = r.pick({1e-6, 1, 1e6}), far = r.pick({0, 1, 1000});
        const Sphere base{far * scale * r.vector(), scale * r.pick({0, 0.3, 1})};
        const double reach = std::max(base.radius, 0.5 * scale);
        std::vector<Object> objects;
        for (int i = 0; i < 6; ++i) objects.push_back(random_object(r, base.center, reach, i % 3));
        const RadialBaseProblem problem = problem_of(scene_of(base, objects, 4 * scale));
        CAPTURE(scale);
        CAPTURE(far);
        REQUIRE(problem.is_sphere);
        CHECK(problem.radius == base.radius);
        CHECK(problem.frame.to_canonical(base.center).isZero());
        for (std::uint32_t i = 0; i < objects.size(); ++i) {
            const FormId f = form_of(problem, Site::object(i));
            if (!f.valid()) continue;  // a ball in a cylinder
            CHECK(problem.family.is_circular(f) == !std::holds_alternative<Cylinder>(objects[i]));
            for (int k = 0; k < 4; ++k) {
                const Vec2 p = problem.chart_point(r.direction(), 0);
                const Real q = nearness(problem.family, f, p);
                // The chart's matrix and the normal are rounded: that turns the ray by 1e-15.
                check_height(real(base.center), real(problem.normal(p)), base.radius, objects[i], q, scale,
                             1e-13);
                if (problem.family.is_circular(f)) {
                    const double rounded = problem.family.forms[f](p.x(), p.y());
                    const double t = problem.distance(p, rounded);
                    if (q > 0) CHECK(abs(1 / Real(t) - q) <= 1e-14 * (abs(q) + 1 / Real(reach)));
                }
            }
        }
        for (std::uint32_t s = 0; s < 6; ++s) {
            const FormId f = form_of(problem, Site::box_side(s));
            REQUIRE(f.valid());
            const Vec2 p = problem.chart_point(r.direction(), 0);
            const Real q = nearness(problem.family, f, p), side = Real(4 * scale);
            const double m = problem.normal(p)[s / 2] * (s % 2 == 0 ? -1 : 1);
            CHECK(abs(q * side - m) < 1e-12);
        }
    }
}

TEST_CASE("radial base: over cylinders, heights are where base and object are equally far") {
    Random r;
    for (int round = 0; round < 300; ++round) {
        const double scale = r.pick({1e-6, 1, 1e6}), far = r.pick({0, 1, 1000});
        const bool oblique = round % 2 == 0;
        const Vec3 axis = oblique ? Vec3(r.direction()) : Vec3(r.pick({-2, 3}) * Vec3::Unit(round % 3));
        const Cylinder base{far * scale * r.vector(), axis, scale * r.pick({0, 0.1, 0.3})};
        const double reach = std::max(base.radius, 0.2 * scale);
        std::vector<Object> objects;
        for (int i = 0; i < 6; ++i) {
            const Vec3 center = base.point + scale * r.unit() * base.axis.normalized();
            Object object = random_object(r, center, reach, i % 3);
            // Clear of the whole stretch: planes along the axis, cylinders too far to come back to it.
            if (auto* plane = std::get_if<Plane>(&object)) {
                plane->normal -= base.axis * base.axis.dot(plane->normal) / base.axis.squaredNorm();
                plane->point = base.point + 2 * reach * plane->normal.normalized();
                plane->normal += 0.02 * r.unit() * plane->normal.norm() * base.axis.normalized();
            }
            objects.push_back(object);
        }
        RadialBaseProblem problem;
        try {
            problem = problem_of(scene_of(base, objects, 2 * scale));
        } catch (const InputError& error) {
            CHECK(error.kind == Kind::TouchesBase);
            continue;
        }
        CAPTURE(scale);
        CAPTURE(far);
        REQUIRE(!problem.is_sphere);
        for (const FormId f : problem.sites.ids())
            for (int k = 0; k < 4; ++k) {
                const double mix = 0.5 + 0.5 * r.unit();
                const Vec2 p(1 + 2 * r.unit(), problem.stretch[0] * mix + problem.stretch[1] * (1 - mix));
                const Real q = nearness(problem.family, f, p);
                const Site site = problem.sites[f].front();
                const Vec3 w = problem.normal(p);
                CHECK(w.norm() == doctest::Approx(1).epsilon(1e-15));
                if (!site.is_object()) {
                    // In world coordinates the point at distance t lies on the side.
                    if (q * 100 * scale < 1) continue;
                    const double t = (1 / q).convert_to<double>();
                    const Vec3 world = problem.frame.to_world(problem.point(p, t));
                    const double side = base.point[site.index / 2] + (site.index % 2 == 0 ? -2 : 2) * scale;
                    CHECK(std::abs(world[site.index / 2] - side) < 1e-12 * (t + scale * (1 + far)));
                    continue;
                }
                check_height({0, p.y(), 0}, real(w), base.radius, problem.objects[f], q, scale, 1e-13);
                // The canonical object is the world's, up to one rounding of the frame.
                const Vec3 at = problem.point(p, 2 * reach);
                const Real canonical = distance(problem.objects[f], real(at)),
                           world = distance(objects[site.index], real(problem.frame.to_world(at)));
                CHECK(abs(canonical - world) < 1e-12 * scale * (1 + far));
            }
    }
}

TEST_CASE("radial base: over a sphere, double forms are within 4u of the exact ones") {
    Random r;
    for (int round = 0; round < 300; ++round) {
        // Far from the origin every difference is inexact; a tiny gap makes C and K cancel.
        const Vec3 center = r.pick({0, 1, 1e3}) * r.vector();
        const double radius = r.pick({0, 1, 1.7}),
                     tiny = std::ldexp(r.unit(), -static_cast<int>(r.rng() % 50));
        std::vector<Object> objects;
        for (int i = 0; i < 8; ++i) {
            const Vec3 d = r.direction();
            const double rho = std::abs(r.unit());
            objects.push_back(Sphere{center + (radius + rho + 1e-12 + std::abs(tiny)) * d, rho});
            objects.push_back(Sphere{center + Vec3(2, tiny, -tiny * r.unit()), radius});
            objects.push_back(Plane{center + (radius + 1e-9) * d + d.cross(r.vector()), d});
        }
        RadialBaseProblem problem;
        problem = problem_of(scene_of(Sphere{center, radius}, objects, radius + std::abs(tiny) + 1e-9));
        for (const FormId f : problem.family.forms.ids()) {
            const CircularForm& form = problem.family.forms[f];
            const ExactForm exact = problem.family.exact(f);
            const Real K = real(exact.K), scale = K == 0 ? Real(1) : Real(abs(K));
            CHECK(Real(form.k) * scale == K);
            CHECK(form.cx == 0);
            CHECK(form.cy == 0);
            const std::array<std::pair<double, Real>, 4> fields = {{{form.a, real(exact.A) / scale},
                                                                    {form.b, real(exact.B) / scale},
                                                                    {form.e, real(exact.C) / scale},
                                                                    {form.w, real(exact.W) / scale}}};
            for (const auto& [rounded, value] : fields) CHECK(abs(rounded - value) <= 4 * u * abs(value));
        }
    }
}

TEST_CASE("chart: integer rotations are rotations exactly, about the pole where one object is nearest") {
    Random r;
    for (int round = 0; round < 400; ++round) {
        Nearness n;
        const int count = 1 + static_cast<int>(r.rng() % 40);
        for (int i = 0; i < count; ++i)
            n.linear.push_back({r.direction() * (1 + 0.5 * r.unit()), 0.3 * r.unit()});
        if (round % 4 == 0) n.linear = {{Vec3::Unit(round / 4 % 3) * (round % 8 ? -1 : 1), 0}};
        if (round % 5 == 0) {
            const Vec3 foot = 3 * r.direction();
            n.cylindrical.push_back({foot, foot.cross(r.direction()).normalized(), 0.2, 9 - 0.04});
        }
        const auto rotation = chart_rotation(n);
        REQUIRE(rotation);
        // Entries of 51 bits at most: squares are checked in exact numbers.
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) {
                Exact sum;
                for (int k = 0; k < 3; ++k) sum += Exact(rotation->matrix(k, i)) * rotation->matrix(k, j);
                CHECK(sum == (i == j ? Exact(rotation->norm) * rotation->norm : Exact()));
                CHECK(rotation->matrix(i, j) == std::round(rotation->matrix(i, j)));
            }
        CHECK(rotation->matrix.determinant() > 0);
        // One object is nearest in a small disk around the pole.
        const Vec3 pole = -rotation->matrix.col(2) / rotation->norm;
        const auto nearest = [&](const Vec3& direction) {
            double best = -1e300;
            std::size_t owner = 0, index = 0;
            const auto consider = [&](double q) {
                if (q > best) {
                    best = q;
                    owner = index;
                }
                ++index;
            };
            for (const auto& f : n.linear) consider(f.p.dot(direction) + f.s);
            for (const auto& f : n.cylindrical) {
                const double beta = f.foot.dot(direction) + f.delta, alpha = f.axis.dot(direction);
                consider((beta + std::sqrt(beta * beta + f.C * alpha * alpha)) / f.C);
            }
            return owner;
        };
        for (int k = 0; k < 20; ++k)
            CHECK(nearest((pole + 0.005 * r.direction()).normalized()) == nearest(pole));
    }
}

TEST_CASE("chart: two objects as near in one direction leave room for a pole elsewhere") {
    // A ball and a plane that touch each other at their common nearest point, and crossing cylinders.
    for (const std::vector<Object>& objects :
         {std::vector<Object>{Sphere{{3, 0, 0}, 1}, Plane{{2, 0, 0}, {1, 0, 0}}},
          std::vector<Object>{Cylinder{{3, 0, 0}, {0, 1, 1}, 1}, Cylinder{{3, 0, 0}, {0, 1, -1}, 1}},
          std::vector<Object>{Cylinder{{3, 0, 0}, {0, 1, 1}, 1}, Sphere{{3, 0, 0}, 1.0625}}}) {
        const RadialBaseProblem problem = problem_of(scene_of(Sphere{{0, 0, 0}, 1}, objects));
        std::vector<FormId> owners;
        for (int k = 0; k < 64; ++k) {
            const double angle = 2 * std::numbers::pi * k / 64;
            FormId owner{};
            Real best = -1;
            for (const FormId f : problem.sites.ids()) {
                const Real q = nearness(problem.family, f, 5000 * Vec2(std::cos(angle), std::sin(angle)));
                if (q <= best) continue;
                best = q;
                owner = f;
            }
            owners.push_back(owner);
        }
        CHECK(std::ranges::count(owners, owners.front()) == 64);
    }
}

TEST_CASE("radial base: chart points and normals are each other's inverse") {
    Random r;
    const RadialBaseProblem sphere = problem_of(scene_of(Sphere{{1, 2, 3}, 1}, {Sphere{{4, 3, 5}, 1}}));
    const RadialBaseProblem tube =
        problem_of(scene_of(Cylinder{{1, 2, 3}, {1, 2, 2}, 1}, {Sphere{{4, 3, 5}, 1}}));
    for (int i = 0; i < 500; ++i) {
        const Vec3 v = r.direction();
        CHECK((sphere.normal(sphere.chart_point(v, 0)) - v).norm() < 8 * u);
        const Vec3 w = Vec3(v.x(), 0, v.z()).normalized();
        const Vec2 p = tube.chart_point(w, v.y());
        CHECK(p.y() == v.y());
        CHECK(p.x() >= -1);
        CHECK(p.x() < 3);
        CHECK((tube.normal(p) - w).norm() < 8 * u);
    }
    const Eigen::Matrix3d& m = tube.chart;
    CHECK((m * m.transpose() - Eigen::Matrix3d::Identity()).norm() < 4 * u);
    CHECK(m.row(1) == Vec3::UnitY().transpose());
    CHECK(tube.normal({0, 0}).isApprox(m * Vec3(0, 0, 1)));
    CHECK(tube.normal({1, 0}).isApprox(m * Vec3(1, 0, 0)));
    CHECK(tube.normal({std::nextafter(1, 2), 0}).isApprox(m * Vec3(1, 0, 0)));
    CHECK(tube.normal({2, 0}).isApprox(m * Vec3(0, 0, -1)));
    CHECK(tube.normal({3, 0}).isApprox(tube.normal({-1, 0})));
    for (const double nearly : {-1e-300, -1e-17, 0.0, 1e-17}) {
        const double x = tube.chart_point(m * Vec3(-1, 0, nearly), 0).x();
        CHECK(x >= -1);
        CHECK(x < 3);
    }
    // Near the pole and far beyond any square of it.
    CHECK(sphere.normal({1e200, -1e200}).norm() == doctest::Approx(1).epsilon(1e-15));
}

TEST_CASE("radial base: the frame of a cylinder") {
    for (int axis = 0; axis < 3; ++axis)
        for (const double sign : {-1.0, 1.0}) {
            Scene scene = scene_of(Cylinder{{0.5, 0.25, 0.125}, 3 * sign * Vec3::Unit(axis), 1}, {});
            scene.box.max[axis] += 4;
            const RadialBaseProblem problem = problem_of(scene);
            const Eigen::Matrix3d& m = problem.frame.rotation;
            CHECK(m.determinant() == 1);
            CHECK(m.row(1) == sign * Vec3::Unit(axis).transpose());
            CHECK(m.cwiseAbs().sum() == 3);
            // The box's centre is the origin along the axis, and the stretch ends on the box.
            CHECK(problem.stretch == std::array{-12.0, 12.0});
            CHECK(problem.sites.size() == 4);
        }
    Random r;
    for (int i = 0; i < 200; ++i) {
        const Vec3 axis = r.direction() * 5;
        const Cylinder base{0.1 * r.vector(), axis, 0.25 * std::abs(r.unit())};
        const Scene scene = scene_of(base, {}, 1);
        const RadialBaseProblem problem = problem_of(scene);
        const Eigen::Matrix3d& m = problem.frame.rotation;
        CHECK((m * m.transpose() - Eigen::Matrix3d::Identity()).norm() < 8 * u);
        CHECK((m * axis.normalized() - Vec3::UnitY()).norm() < 8 * u);
        CHECK(!problem.frame.is_axis_parallel());
        // The end circles lie in the box and touch it.
        for (const double y : problem.stretch) {
            double excess = -1;
            for (int k = 0; k < 360; ++k) {
                const double angle = k * std::numbers::pi / 180;
                const Vec3 p = problem.frame.to_world(
                    Vec3(base.radius * std::sin(angle), y, base.radius * std::cos(angle)));
                excess = std::max({excess, (scene.box.min - p).maxCoeff(), (p - scene.box.max).maxCoeff()});
            }
            CHECK(excess < 8 * u);
            CHECK(excess > -1e-4);
        }
    }
}

TEST_CASE("radial base: objects that touch, contain or lie in the base are errors") {
    const Vec3 o(1, 2, 3);
    const Sphere ball{o, 2};
    const auto at = [&](double x, double y, double z) -> Vec3 { return o + Vec3(x, y, z); };
    const auto check = [](const Object& base, const Object& object, const std::string& text) {
        const InputError error = error_of(scene_of(base, {Sphere{{5, 5, -3}, 0.5}, object}));
        CHECK(error.kind == Kind::TouchesBase);
        CHECK(error.object == 1);
        CAPTURE(error.what());
        CHECK(std::string(error.what()).find(text) != std::string::npos);
    };
    check(ball, Sphere{at(0, 0, 0), 2}, "is the base itself");
    check(ball, Sphere{at(0, 0, 1), 1}, "lies in the base");  // touches from within
    check(ball, Sphere{at(0, 0, 1), 0.5}, "lies in the base");
    check(ball, Sphere{at(0, 0, 1), 3}, "contains the base");  // touches from outside
    check(ball, Sphere{at(0, 0, 1), 4}, "contains the base");
    check(ball, Plane{at(0, 0, 2), {0, 0, 5}}, "touches the base at (1, 2, 5)");
    check(ball, Plane{at(1, 0, 1), {0, 0, 5}}, "cuts the base at (1, 2, 4)");
    check(ball, Plane{at(0, 0, 0), {1, 2, 5}}, "cuts the base");
    check(ball, Cylinder{at(0, 1, 0), {1, 0, 0}, 3}, "contains the base");
    check(ball, Cylinder{at(0, 1, 0), {1, 0, 0}, 0.5}, "runs through the base");
    check(Sphere{o, 0}, Sphere{at(1, 0, 0), 1}, "contains the base");
    check(Sphere{o, 0}, Plane{at(1, 0, 0), {0, 1, 0}}, "touches the base");

    const Cylinder tube{o, {0, 0, 2}, 2};
    check(tube, Sphere{at(1, 0, 0), 3.5}, "contains a cross section");
    check(tube, Sphere{at(0, 0, 12), 4}, "contains a cross section");
    check(tube, Sphere{at(1, 0, 3), 1}, "lies in the base");
    check(tube, Plane{at(0, 0, 0), {0, 0, 1}}, "cuts the base");
    check(tube, Plane{at(2, 0, 0), {-3, 0, 0}}, "touches the base");
    check(tube, Plane{at(0, 0, 10), {0, 0, 1}}, "touches the base");
    check(tube, Plane{at(0, 0, 11), {1, 0, 1}}, "cuts the base");
    check(tube, Cylinder{at(0, 0, 5), {0, 0, -1}, 1}, "lies in the base");
    check(tube, Cylinder{at(0, 0, 5), {0, 0, -1}, 3}, "contains a cross section");
    check(tube, Cylinder{at(0, 0, 5), {1, 0, 0}, 1}, "lies in the base, or runs through it");
    check(tube, Cylinder{at(3, 0, 5), {0, 0, 1}, 5}, "contains a cross section");
    // About a point of an axis whose length is no double.
    check(Cylinder{o, {1, 0, 1}, 0.5}, Sphere{at(2, 0, 2), 0.5}, "contains a cross section");
    check(Cylinder{o, {1, 1, 0}, 0.5}, Sphere{at(-1.5, -1.5, 0), 0.5}, "contains a cross section");
    // A ball in line with the axis beyond the box is not seen: no error.
    const RadialBaseProblem problem = problem_of(scene_of(tube, {Sphere{at(0, 0, 14), 1}}));
    CHECK(!form_of(problem, Site::object(0)).valid());
    REQUIRE(problem.warnings.size() == 1);
    CHECK(problem.warnings[0].find("object 0: out of sight") == 0);
    // Just clear, and just overlapping the surface without containing the base, are fine.
    const double step = 8 * u;
    problem_of(scene_of(ball, {Sphere{at(0, 0, 1), 1 + step}, Plane{at(0, 0, 2 + step), {0, 0, 5}}}));
    problem_of(
        scene_of(tube, {Plane{at(2 + step, 0, 0), {-3, 0, 0}}, Plane{at(0, 0, 10 + 2 * step), {0, 0, 1}}}));
}

TEST_CASE("radial base: the base must lie in the box") {
    const auto fails = [](const Scene& scene) {
        const InputError error = error_of(scene);
        CHECK(error.kind == Kind::EmptyBox);
        CHECK(error.path == "box");
    };
    Scene scene = scene_of(Sphere{{0.1, 0.2, 0.3}, 2}, {});
    scene.box.max.z() = 2.3;
    fails(scene);  // 0.3 + 2 > 2.3, as the doubles are
    scene = scene_of(Sphere{{0.25, 0.25, 0.25}, 2}, {});
    scene.box.max.y() = 2.25;
    CHECK(problem_of(scene).sites.size() == 6);  // touching it from within is fine
    std::get<Sphere>(scene.base) = {{0, 2.25, 0}, 0};
    fails(scene);
    scene = scene_of(Cylinder{{0, 0, 0}, {0, 1, 0}, 2}, {});
    scene.box.max.x() = 2;
    CHECK(problem_of(scene).stretch == std::array{-10.0, 10.0});
    scene.box.max.x() = std::nextafter(2.0, 1.0);
    fails(scene);
    scene.base = Cylinder{{2, 0, 0}, {0, 1, 0}, 0};
    scene.box.max.x() = 2;
    fails(scene);
    scene.base = Cylinder{{-9, -9, -9}, {1, -1, 0}, 2};  // cuts a corner
    fails(scene);
}

TEST_CASE("radial base: objects in others are hidden, equal ones merged") {
    const Sphere ball{{1, 1, 1}, 1};
    const RadialBaseProblem problem =
        problem_of(scene_of(ball, {Sphere{{5, 1, 1}, 1.5},                 // 0
                                   Sphere{{5.5, 1, 1}, 1},                 // 1 touches 0 from within
                                   Sphere{{5, 1, 1}, 1.5},                 // 2 equals 0
                                   Sphere{{5.5000001, 1, 1}, 1},           // 3 is not in 0
                                   Cylinder{{1, 6, 1}, {1, 0, 0}, 1},      // 4
                                   Cylinder{{-9, 6, 1}, {-3, 0, 0}, 1},    // 5 equals 4
                                   Cylinder{{0, 6.5, 1}, {2, 0, 0}, 0.5},  // 6 touches 4 from within
                                   Sphere{{2, 6, 1}, 1},                   // 7 fills a stretch of 4
                                   Plane{{1, 1, -6}, {0, 0, 1}},           // 8
                                   Plane{{9, 9, -6}, {0, 0, -7}},          // 9 equals 8
                                   Cylinder{{3, 3, -7}, {1, 1, 0}, 1},     // 10 touches 8 from behind
                                   Sphere{{5.5, 1, 1}, 1}}));              // 11 equals 1
    std::vector<std::vector<Site>> groups;
    for (const FormId f : problem.sites.ids()) groups.push_back(sites_of(problem, f));
    const auto group = [](std::initializer_list<std::uint32_t> objects) {
        std::vector<Site> sites;
        for (const std::uint32_t i : objects) sites.push_back(Site::object(i));
        return sites;
    };
    REQUIRE(groups.size() == 4 + 6);
    CHECK(groups[0] == group({0, 2}));
    CHECK(groups[1] == group({3}));
    CHECK(groups[2] == group({8, 9}));
    CHECK(groups[3] == std::vector{Site::box_side(0)});
    CHECK(groups[9] == group({4, 5}));
    REQUIRE(problem.warnings.size() == 4);
    CHECK(problem.warnings[0] ==
          "object 1 in object 0, object 6 in object 4, object 7 in object 4, object 10 beyond object 8, "
          "object 11 in "
          "object 0: hidden, never nearest to any point of the cell");
    CHECK(problem.warnings[1] == "object 0 and object 2: the same distance from the base everywhere, merged");
    CHECK(std::get<Sphere>(problem.objects[FormId{0}]).center == Vec3(4, 0, 0));
}

TEST_CASE("radial base: what a side of the box mirrors to the base has the side's height") {
    // The side +x is 10 away from the base.
    Scene scene =
        scene_of(Sphere{{1, 1, 1}, 2}, {Sphere{{21, 1, 1}, 2}, Sphere{{21, 1, 1}, 1}, Sphere{{1, 1, 22}, 2}});
    RadialBaseProblem problem = problem_of(scene);
    CHECK(sites_of(problem, FormId{0}) == std::vector{Site::object(0), Site::box_side(1)});
    CHECK(problem.sites.size() == 2 + 5);  // object 1 lies in object 0
    CHECK(sites_of(problem, FormId{1}) == std::vector{Site::object(2)});

    scene = scene_of(
        Cylinder{{1, 1, 1}, {0, 0, 1}, 2},
        {Cylinder{{21, 1, -8}, {0, 0, -3}, 2}, Sphere{{21, 1, 4}, 2}, Cylinder{{1, 20, 7}, {0, 0, 2}, 1},
         Plane{{-19, 0, 0}, {1, 0, 0}}, Cylinder{{1, -19.5, 0}, {0, 0, 1}, 1}});
    problem = problem_of(scene);
    CHECK(sites_of(problem, FormId{0}) == std::vector{Site::object(0), Site::box_side(1)});
    CHECK(form_of(problem, Site::object(1)) == FormId{});  // in object 0
    CHECK(form_of(problem, Site::object(2)) == form_of(problem, Site::object(2)));
    CHECK(form_of(problem, Site::object(4)) == FormId{});  // in the image beyond -y
    CHECK(problem.warnings.front().find("object 4 beyond side box:-y") != std::string::npos);
}

TEST_CASE("radial base: a huge ball that has a rounded plane's very height is merged with it") {
    // |n| = sqrt(3) is rounded down to l. A ball (c, delta) with 2 c / C = -n / D and 2 delta / C = l / D,
    // that is C = |c|^2 - delta^2 = 4 D^2 / (3 - l^2), is as near as the plane everywhere.
    const double l = std::sqrt(3.0), D = (Exact(3.0) - Exact(l) * l).enclosure().mid();
    REQUIRE(Exact(D) == Exact(3.0) - Exact(l) * l);
    // Scaled by 2^52: c = -2 n, delta = 2 l, D = 3 - l^2, about 3e-16.
    const double scale = 0x1p50;
    const Scene scene = scene_of(Sphere{{0, 0, 0}, 0}, {Plane{{D * scale, 0, 0}, {-1, -1, -1}},
                                                        Sphere{2 * scale * Vec3::Ones(), 2 * scale * l},
                                                        Plane{{-1, 0, 0}, {1, 0, 0}}});
    const RadialBaseProblem problem = problem_of(scene);
    CHECK(sites_of(problem, FormId{0}) == std::vector{Site::object(0), Site::object(1)});
    CHECK(problem.sites.size() == 2 + 6);
}

TEST_CASE("radial base: cylinders of one radius that cross are told from those that all but cross") {
    const Vec3 c(3, 4, -2), a(1, 2, -1), b(2, -1, 3);
    const auto cross = [&](const Object& base, const Object& first, const Object& second) {
        const RadialBaseProblem problem = problem_of(scene_of(base, {first, second}));
        const FormId f = form_of(problem, Site::object(0)), g = form_of(problem, Site::object(1));
        CHECK(problem.cross_equally(f, g) == problem.cross_equally(g, f));
        return problem.cross_equally(f, g);
    };
    for (const Object& base :
         {Object(Sphere{{0.1, 0.2, 0.3}, 0.5}), Object(Cylinder{{0.125, 0.25, 0}, {0, 0, 1}, 0.5}),
          Object(Cylinder{{0.125, 0, 0.25}, {0, 1, 0}, 0.5}),
          Object(Cylinder{{0.1, 0.2, 0.3}, {0, -0.3, 1}, 0.5}),
          Object(Cylinder{{0, 0.1, 0}, {0.2, 1, 0.1}, 0.5})}) {
        CAPTURE(base.index());
        CHECK(cross(base, Cylinder{c + 2 * a, a, 0.25}, Cylinder{c - b, -2 * b, 0.25}));
        const Vec3 up = std::ldexp(1.0, -44) * Vec3::UnitX();
        CHECK_FALSE(cross(base, Cylinder{c + 2 * a, a, 0.25}, Cylinder{c - b + up, b, 0.25}));
        CHECK_FALSE(cross(base, Cylinder{c + 2 * a, a, 0.25}, Cylinder{c - b, b, 0.25 + 0x1p-50}));
        CHECK_FALSE(cross(base, Cylinder{c + 2 * a, a, 0.25}, Cylinder{c + Vec3(0, 1, 0), a, 0.25}));
        CHECK_FALSE(cross(base, Cylinder{c + 2 * a, a, 0.25}, Sphere{c + Vec3(0, 1, 0), 0.25}));
    }
}

TEST_CASE("radial base: a tilted cylinder leaves alone what objects are to each other") {
    // Integers, whatever direction they are measured in: touching from within, equal, parallel, mirrored.
    for (const Vec3& axis : {Vec3(1, 1, 0), Vec3(-3, 2, 0), Vec3(4, -3, 0), Vec3(-1, -7, 0)}) {
        CAPTURE(axis.transpose());
        const Vec3 c = 2 * Vec3(-axis.y(), axis.x(), 3), p(0.1, 0.2, 0);
        const Scene scene =
            scene_of(Cylinder{p, axis, 0.5}, {Sphere{c, 1},                        // 0
                                              Sphere{c + Vec3(0, 0, 0.75), 0.25},  // 1 touches 0 from within
                                              Cylinder{-c, Vec3(3, 1, 2), 1},      // 2
                                              Cylinder{-c - Vec3(3, 1, 2), -Vec3(6, 2, 4), 1},  // 3 equals 2
                                              Cylinder{Vec3(5, 5, 5), axis, 0.25},              // 4
                                              Cylinder{p + Vec3(0, 0, 20), -2 * axis, 0.5}});   // 5 mirrored
        const RadialBaseProblem problem = problem_of(scene);
        const auto form = [&](std::uint32_t i) { return form_of(problem, Site::object(i)); };
        CHECK(form(1) == FormId{});
        CHECK(form(2) == form(3));
        CHECK(problem.family.radial_form(form(2)).has_root());
        CHECK(!problem.family.radial_form(form(4)).has_root());
        CHECK(std::get<Cylinder>(problem.objects[form(4)]).axis == Vec3::UnitY());
        CHECK(form(5) == form_of(problem, Site::box_side(5)));
    }
}

TEST_CASE("radial base: where balls overlap the base its clearance is negative") {
    const Sphere base{{0, 0, 0}, 2}, other{{3, 0, 0}, 2};
    const RadialBaseProblem problem = problem_of(scene_of(base, {other}));
    // C = 9, Q = 2 c.u / C.
    const Vec2 p = problem.chart_point({0.96, 0.28, 0}, 0);
    const double t = problem.distance(p, problem.family.forms[FormId{0}](p.x(), p.y()));
    CHECK(t == doctest::Approx(1.5625).epsilon(1e-14));
    CHECK(t - problem.radius == doctest::Approx(-0.4375).epsilon(1e-14));
    const RadialBaseProblem tube = problem_of(scene_of(Cylinder{{0, 0, 0}, {0, 1, 0}, 2}, {other}));
    const Real q = nearness(tube.family, FormId{0}, tube.chart_point(tube.frame.rotation * Vec3(1, 0, 0), 0));
    CHECK((1 / q).convert_to<double>() == doctest::Approx(1.5).epsilon(1e-14));
}

TEST_CASE("nested balls: as comparing all pairs exactly tells") {
    Random r;
    for (int round = 0; round < 60; ++round) {
        std::vector<Ball> balls;
        const int count = 1 + static_cast<int>(r.rng() % 400);
        const double scale = r.pick({1e-30, 1, 1e30});
        // Radii of all sizes make many pairs; alike, they leave few that could be nested.
        const bool alike = round % 3 == 0;
        for (int i = 0; i < count; ++i) {
            // Multiples of 1/4: many touch from within; one ulp more or less decides.
            const auto grid = [&] { return scale * std::round(16 * r.unit()) / 4; };
            const double rho = alike ? scale * r.pick({2, 2.25}) : std::abs(grid());
            Ball ball{grid(), grid(), alike || round % 2 ? 0 : grid(), rho};
            if (r.rng() % 4 == 0) ball.rho = std::nextafter(ball.rho, r.pick({0, 1e60}));
            balls.push_back(i > 0 && r.rng() % 16 == 0 ? balls[r.rng() % balls.size()] : ball);
        }
        const auto lies_in = [](const Ball& in, const Ball& out) {
            const Exact x = Exact(in.cx) - out.cx, y = Exact(in.cy) - out.cy, z = Exact(in.cz) - out.cz,
                        gap = Exact(out.rho) - in.rho;
            return gap.sign() == Sign::Positive &&
                   (gap * gap - x * x - y * y - z * z).sign() != Sign::Negative;
        };
        const BallNesting found = ball_nesting(balls);
        int nested = 0;
        for (std::size_t i = 0; i < balls.size(); ++i) {
            std::uint32_t first = UINT32_MAX, enclosing = UINT32_MAX;
            for (std::uint32_t k = 0; k < balls.size(); ++k) {
                if (first == UINT32_MAX && balls[k] == balls[i]) first = k;
                if (lies_in(balls[i], balls[k]) &&
                    (enclosing == UINT32_MAX || balls[k].rho > balls[enclosing].rho))
                    enclosing = k;
            }
            nested += enclosing != UINT32_MAX;
            CHECK(found.first_equal[i] == first);
            CHECK(found.enclosing[i] == enclosing);
        }
        if (count > 100) CHECK(nested > 0);
    }
    CHECK(ball_nesting({}).first_equal.empty());
}
