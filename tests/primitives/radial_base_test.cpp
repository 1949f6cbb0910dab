// Heights around spheres and cylinders are where base and object are equally far; charts are rotations,
// exactly.
#include "../../primitives/bases/radial_base.hpp"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "../../primitives/charts/sphere_chart.hpp"
#include "../../primitives/forms/exact_heights.hpp"
#include "../test_support.hpp"
#include "radial_base_checks.hpp"

namespace vcell::radial_base_test {
using namespace vcell::radial_base;

TEST_CASE("radial base: over spheres, heights are where base and object are equally far") {
    Random r;
    for (int round = 0; round < long_rounds(300); ++round) {
        const double scale = r.pick({1e-6, 1, 1e6}), far = r.pick({0, 1, 1000});
        const Sphere base{far * scale * r.vector(), scale * r.pick({0, 0.3, 1})};
        const double reach = std::max(base.radius, 0.5 * scale);
        std::vector<Object> objects;
        for (int i = 0; i < 6; ++i) objects.push_back(random_object(r, base.center, reach, i % 3));
        const RadialBaseProblem problem = problem_of(scene_of(base, objects, 4 * scale));
        CAPTURE(scale);
        CAPTURE(far);
        REQUIRE(problem.chart.is_sphere());
        CHECK(problem.chart.radius == base.radius);
        CHECK(problem.frame.to_canonical(base.center).isZero());
        for (std::uint32_t i = 0; i < objects.size(); ++i) {
            const FormId f = form_of(problem, Site::object(i));
            if (!f.valid()) continue;  // a ball in a cylinder
            CHECK(problem.family.is_circular(f) == !std::holds_alternative<Cylinder>(objects[i]));
            for (int k = 0; k < 4; ++k) {
                const Vec2 p = problem.chart.chart_point(r.direction(), 0);
                const Real q = nearness(problem.family, f, p);
                // The chart's matrix and the normal are rounded: that turns the ray by 1e-15.
                check_height(real(base.center), real(problem.chart.normal(p)), base.radius, objects[i], q,
                             scale, 1e-13);
                if (problem.family.is_circular(f)) {
                    const double rounded = problem.family.forms[f](p.x(), p.y());
                    const double t = problem.chart.distance_of(p, rounded);
                    if (q > 0) CHECK(abs(1 / Real(t) - q) <= 1e-14 * (abs(q) + 1 / Real(reach)));
                }
            }
        }
        for (std::uint32_t s = 0; s < 6; ++s) {
            const FormId f = form_of(problem, Site::box_side(s));
            REQUIRE(f.valid());
            const Vec2 p = problem.chart.chart_point(r.direction(), 0);
            const Real q = nearness(problem.family, f, p), side = Real(4 * scale);
            const double m = problem.chart.normal(p)[s / 2] * (s % 2 == 0 ? -1 : 1);
            CHECK(abs(q * side - m) < 1e-12);
        }
    }
}

TEST_CASE("radial base: over cylinders, heights are where base and object are equally far") {
    Random r;
    for (int round = 0; round < long_rounds(300); ++round) {
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
            CHECK(error.kind == InputError::Kind::TouchesBase);
            continue;
        }
        CAPTURE(scale);
        CAPTURE(far);
        REQUIRE(!problem.chart.is_sphere());
        for (const FormId f : problem.sites.ids())
            for (int k = 0; k < 4; ++k) {
                const double mix = 0.5 + 0.5 * r.unit();
                const Vec2 p(1 + 2 * r.unit(), problem.stretch[0] * mix + problem.stretch[1] * (1 - mix));
                const Real q = nearness(problem.family, f, p);
                const Site site = problem.sites[f].front();
                const Vec3 w = problem.chart.normal(p);
                CHECK(w.norm() == doctest::Approx(1).epsilon(1e-15));
                if (!site.is_object()) {
                    // In world coordinates the point at distance t lies on the side.
                    if (q * 100 * scale < 1) continue;
                    const double t = (1 / q).convert_to<double>();
                    const Vec3 world = problem.frame.to_world(problem.chart.point(p, t));
                    const double side = base.point[site.index / 2] + (site.index % 2 == 0 ? -2 : 2) * scale;
                    CHECK(std::abs(world[site.index / 2] - side) < 1e-12 * (t + scale * (1 + far)));
                    continue;
                }
                check_height({0, p.y(), 0}, real(w), base.radius, problem.objects[f], q, scale, 1e-13);
                // The canonical object is the world's, up to one rounding of the frame.
                const Vec3 at = problem.chart.point(p, 2 * reach);
                const Real canonical = distance(problem.objects[f], real(at)),
                           world = distance(objects[site.index], real(problem.frame.to_world(at)));
                CHECK(abs(canonical - world) < 1e-12 * scale * (1 + far));
            }
    }
}

TEST_CASE("radial base: over a sphere, double forms are within 4u of the exact ones") {
    Random r;
    for (int round = 0; round < long_rounds(300); ++round) {
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

// Tubes with twins 1e-8 off, and a line that all but touches the base: beside it heights are steep, and
// between twins they differ by little, wherever the pole is.
TEST_CASE("chart: twins of tubes and what all but touches the base leave room for a pole") {
    Random r;
    const auto tube = [](const Vec3& foot, const Vec3& axis, double delta) {
        return Nearness::Cylindrical{foot, axis, delta, foot.squaredNorm() - delta * delta};
    };
    for (int round = 0; round < 100; ++round) {
        Nearness n;
        for (int i = 0; i < 3; ++i) {
            const Vec3 foot = (2 + r.unit()) * r.direction(), axis = foot.cross(r.direction()).normalized();
            n.cylindrical.push_back(tube(foot, axis, 0.25));
            const Vec3 moved = foot + 1e-8 * r.direction();
            n.cylindrical.push_back(tube(moved - axis * axis.dot(moved), axis, 0.25));
        }
        if (round % 2 == 0) {
            const Vec3 out = r.direction();
            n.cylindrical.push_back(tube((1 + 0x1p-40) * out, out.cross(r.direction()).normalized(), -1));
        }
        const auto rotation = chart_rotation(n);
        REQUIRE(rotation);
        const Vec3 pole = -rotation->matrix.col(2) / rotation->norm;
        const auto nearest = [&](const Vec3& direction) {
            std::size_t owner = 0;
            for (std::size_t i = 0; i < n.cylindrical.size(); ++i)
                if (nearness_of(n.cylindrical[i], direction) > nearness_of(n.cylindrical[owner], direction))
                    owner = i;
            return owner;
        };
        for (int k = 0; k < 20; ++k)
            CHECK(nearest((pole + 1e-6 * r.direction()).normalized()) == nearest(pole));
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
        CHECK((sphere.chart.normal(sphere.chart.chart_point(v, 0)) - v).norm() < 8 * u);
        const Vec3 w = Vec3(v.x(), 0, v.z()).normalized();
        const Vec2 p = tube.chart.chart_point(w, v.y());
        CHECK(p.y() == v.y());
        CHECK(p.x() >= -1);
        CHECK(p.x() < 3);
        CHECK((tube.chart.normal(p) - w).norm() < 8 * u);
    }
    const Eigen::Matrix3d& m = tube.chart.turn;
    CHECK((m * m.transpose() - Eigen::Matrix3d::Identity()).norm() < 4 * u);
    CHECK(m.row(1) == Vec3::UnitY().transpose());
    CHECK(tube.chart.normal({0, 0}).isApprox(m * Vec3(0, 0, 1)));
    CHECK(tube.chart.normal({1, 0}).isApprox(m * Vec3(1, 0, 0)));
    CHECK(tube.chart.normal({std::nextafter(1, 2), 0}).isApprox(m * Vec3(1, 0, 0)));
    CHECK(tube.chart.normal({2, 0}).isApprox(m * Vec3(0, 0, -1)));
    CHECK(tube.chart.normal({3, 0}).isApprox(tube.chart.normal({-1, 0})));
    for (const double nearly : {-1e-300, -1e-17, 0.0, 1e-17}) {
        const double x = tube.chart.chart_point(m * Vec3(-1, 0, nearly), 0).x();
        CHECK(x >= -1);
        CHECK(x < 3);
    }
    // Near the pole and far beyond any square of it.
    CHECK(sphere.chart.normal({1e200, -1e200}).norm() == doctest::Approx(1).epsilon(1e-15));
}

TEST_CASE("radial base: exact heights depend on a place alone, not on its denominator") {
    Random r;
    int compared = 0, zero = 0;
    for (int round = 0; round < long_rounds(60); ++round) {
        const Sphere ball{Vec3::Zero(), 0.3};
        const Cylinder tube{Vec3::Zero(), {0, 0, 1}, 0.3};
        const Object base = round % 2 == 0 ? Object(ball) : Object(tube);
        std::vector<Object> objects;
        for (int i = 0; i < 4; ++i) objects.push_back(random_round_beside(r, tube, i));
        const RadialBaseProblem problem = problem_of(scene_of(base, objects, 4));
        const FormFamily& family = problem.family;
        for (std::uint32_t f = 0; f < family.size(); ++f)
            for (std::uint32_t g = 0; g < family.size(); ++g) {
                const double x = 1 + 2 * r.unit(), y = r.unit(), w = r.pick({3, 5, 0.75, 1024});
                const Exact over(w);
                const Sign at = compare_exactly(family, FormId{f}, FormId{g}, {x, y});
                CHECK(compare_exactly(family, FormId{f}, FormId{g},
                                      {over * Exact(x), over * Exact(y), over}) == at);
                ++compared;
                zero += at == Sign::Zero;
            }
    }
    CHECK(compared > 1000);
    CHECK(zero < compared / 2);
}

}  // namespace vcell::radial_base_test
