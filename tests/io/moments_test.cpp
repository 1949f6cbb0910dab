// Centroids and second moments: against closed forms, random points, and themselves after motions.
#include "../../io/solids/moments.hpp"

#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <string>
#include <variant>

#include "../../envelope/point_query.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "../../io/check/check.hpp"
#include "../../io/files/cell_file.hpp"
#include "../../io/pictures/mesh.hpp"
#include "../../io/solids/shell.hpp"
#include "../test_support.hpp"
#include "damages.hpp"
#include "listing.hpp"
#include "sample_cells.hpp"

namespace vcell {

using namespace damages;

namespace {

using Eigen::Matrix3d;

struct Expected {
    double volume;
    Vec3 centroid;
    Matrix3d second;  // about the centroid
};

Expected of_box(const Vec3& from, const Vec3& to) {
    const Vec3 size = to - from;
    const double volume = size.prod();
    return {volume, 0.5 * (from + to), Matrix3d((volume / 12 * size.cwiseProduct(size)).asDiagonal())};
}

/// Within the errors stated, and these are no larger than that.
void check_moments(const Moments& m, const Expected& e, double relative_error) {
    const double size = std::cbrt(e.volume);
    CHECK((m.centroid - e.centroid).norm() <= m.centroid_error + 1e-15 * e.centroid.norm());
    CHECK((m.second - e.second).cwiseAbs().maxCoeff() <= m.second_error + 1e-15 * e.second.norm());
    CHECK(m.centroid_error <= relative_error * size);
    CHECK(m.second_error <= relative_error * e.volume * size * size);
}

/// Every one of them, by tetrahedra from the origin over the cell's triangles.
Expected of_mesh(const CellMesh& mesh) {
    double volume = 0;
    Vec3 first = Vec3::Zero();
    Matrix3d second = Matrix3d::Zero();
    const Vec3 o = mesh.points[0];
    for (const auto& t : mesh.triangles) {
        std::array<Vec3, 3> p;
        for (std::size_t k = 0; k < 3; ++k) p[k] = mesh.points[t[k]] - o;
        const double v = p[0].dot(p[1].cross(p[2])) / 6;
        const Vec3 sum = p[0] + p[1] + p[2];
        volume += v;
        first += v / 4 * sum;
        second += v / 20 * (sum * sum.transpose());
        for (const Vec3& x : p) second += v / 20 * (x * x.transpose());
    }
    const Vec3 c = first / volume;
    return {volume, o + c, second - volume * c * c.transpose()};
}

Scene moved(Scene scene, const Vec3& by, double scale) {
    const auto move = [&](Object& object) {
        std::visit(
            [&]<class T>(T& o) {
                if constexpr (requires { o.center; })
                    o.center = scale * o.center + by;
                else if constexpr (requires { o.apex; })
                    o.apex = scale * o.apex + by;
                else
                    o.point = scale * o.point + by;
                if constexpr (requires { o.radius; }) o.radius *= scale;
                if constexpr (requires { o.slant; }) o.slant *= scale;
            },
            object);
    };
    move(scene.base);
    for (Object& o : scene.objects) move(o);
    scene.box = {scale * scene.box.min + by, scale * scene.box.max + by};
    return scene;
}

}  // namespace

TEST_CASE("moments: boxes") {
    for (const double unit : {0x1p-60, 1.0, 0x1p60}) {
        CAPTURE(unit);
        Scene scene;
        scene.box = {unit * Vec3(-1, 0.5, 0), unit * Vec3(3, 2, 2.5)};
        scene.base = Plane{Vec3::Zero(), Vec3::UnitZ()};
        check_moments(moments_of(voronoi_cell(scene)), of_box(scene.box.min, scene.box.max), 1e-10);
        scene.base = Sphere{unit * Vec3(1, 1, 1), 0.25 * unit};
        check_moments(moments_of(voronoi_cell(scene)), of_box(scene.box.min, scene.box.max), 1e-10);
        scene.base = Cylinder{unit * Vec3(1, 1, 1), Vec3::UnitY(), 0.25 * unit};
        check_moments(moments_of(voronoi_cell(scene)), of_box(scene.box.min, scene.box.max), 1e-10);
    }
}

TEST_CASE("moments: of boxes a millionth thick errors are those of their numbers") {
    // The sides have parameters a million times as large as they are high.
    for (const double height : {0x1p-10, 0x1p-20}) {
        CAPTURE(height);
        Scene scene;
        scene.base = Sphere{Vec3::Zero(), 0.25 * height};
        scene.objects = {Sphere{Vec3::UnitX(), 0.25 * height}};
        scene.box = {Vec3(-1, -0.75, -height), Vec3(1, 1, height)};
        const Moments m = moments_of(voronoi_cell(scene));
        const Expected e = of_box(scene.box.min, Vec3(0.5, 1, height));
        CHECK((m.centroid - e.centroid).norm() <= m.centroid_error);
        CHECK((m.second - e.second).cwiseAbs().maxCoeff() <= m.second_error);
        const double most = 1e-9 / height;
        CHECK(m.centroid_error < most);
        CHECK(m.second_error < most * e.volume);
    }
}

TEST_CASE("moments: under a paraboloid, between two balls") {
    // z = (r^2 + e) / w over the square [-1, 1]^2.
    const Cell under = voronoi_cell(paraboloid_cell().scene);
    constexpr double e = 15.0 / 16, w = 2.5;
    const double volume = 4 * (2.0 / 3 + e) / w;
    // The means over the square: r^2 is 2/3, r^4 = x^4 + y^4 + 2 x^2 y^2 is 2/5 + 2/9, x^2 r^2 is 1/5 + 1/9.
    const double mean2 = 2.0 / 3, mean4 = 2.0 / 5 + 2.0 / 9, square_x = 1.0 / 5 + 1.0 / 9;
    // r^6 = x^6 + y^6 + 3 x^4 y^2 + 3 x^2 y^4.
    const double mean6 = 2.0 / 7 + 2.0 / 5;
    const double z = 4 * (mean4 + 2 * e * mean2 + e * e) / (2 * w * w) / volume;
    const double xx = 4 * (square_x + e / 3) / w;
    const double zz = 4 * (mean6 + 3 * e * mean4 + 3 * e * e * mean2 + e * e * e) / (3 * w * w * w);
    check_moments(moments_of(under),
                  {volume, {0, 0, z}, Matrix3d(Vec3(xx, xx, zz - volume * z * z).asDiagonal())}, 1e-10);

    // Half of a box: flat between equal balls.
    Scene scene;
    scene.base = Sphere{{0, 0, 0}, 0.25};
    scene.objects = {Sphere{{1, 0, 0}, 0.25}};
    scene.box = {Vec3::Constant(-2), Vec3::Constant(2)};
    check_moments(moments_of(voronoi_cell(scene)), of_box({-2, -2, -2}, {0.5, 2, 2}), 1e-10);
}

TEST_CASE("moments: a ball about a ball in a vessel, cut by the box") {
    // As far from the ball as from the sphere's inside about the same centre: a ball of the mean radius.
    Scene scene;
    scene.base = Sphere{{0.25, -0.5, 0.75}, 0.25};
    scene.objects = {HollowSphere{{0.25, -0.5, 0.75}, 1.25}};
    scene.box = {Vec3::Constant(-4), Vec3::Constant(4)};
    // A cap of it: cut by the box in the middle.
    scene.box.min.z() = 0.75 - 0.375;
    const double R = 0.75, pi = std::numbers::pi, h = 0.375;
    // From -h to R along z: areas pi (R^2 - z^2).
    const auto integral = [&](int power) {
        const auto at = [&](double z) {
            return pi * (R * R * std::pow(z, power + 1) / (power + 1) - std::pow(z, power + 3) / (power + 3));
        };
        return at(R) - at(-h);
    };
    const auto fourth = [&](double z) {
        return pi / 4 * (std::pow(R, 4) * z - 2 * R * R * z * z * z / 3 + std::pow(z, 5) / 5);
    };
    const double volume = integral(0), z = integral(1) / volume, xx = fourth(R) - fourth(-h);
    const Cell cell = voronoi_cell(scene);
    CHECK(cell.measures.volume == doctest::Approx(volume).epsilon(1e-12));
    check_moments(moments_of(cell),
                  {volume, Vec3(0.25, -0.5, 0.75 + z),
                   Matrix3d(Vec3(xx, xx, integral(2) - volume * z * z).asDiagonal())},
                  1e-9);
}

TEST_CASE("moments: a ball's cap of which another ball leaves next to all") {
    // What is nearer to it is beyond a plane at h. The cap reaches so far around that it has two patches.
    Scene scene;
    scene.base = Sphere{{0, 0, 0}, 1};
    scene.probe = 1;
    scene.box = {Vec3::Constant(-4), Vec3::Constant(4)};
    for (const double h : {1.0, 1.5, 1.65}) {
        CAPTURE(h);
        scene.objects = {Sphere{{2 * h, 0, 0}, 1}};
        const Cell cell = voronoi_cell(scene);
        std::size_t most = 0;
        for (const CellFace& f : cell.faces) most = std::max(most, f.patches.size());
        CHECK(most == 2);
        // The cell is made of discs of radius sqrt(a - x^2) from -2 to h.
        const double a = 4, from = -2;
        const auto between = [&](const auto& integral) { return integral(h) - integral(from); };
        const double pi = std::numbers::pi;
        const double volume = pi * between([&](double x) { return a * x - x * x * x / 3; }),
                     first = pi * between([&](double x) { return a * x * x / 2 - x * x * x * x / 4; }),
                     along = pi * between([&](double x) { return a * x * x * x / 3 - std::pow(x, 5) / 5; }),
                     across = pi / 4 * between([&](double x) {
                                  return a * a * x - 2 * a * x * x * x / 3 + std::pow(x, 5) / 5;
                              });
        const double middle = first / volume;
        check_moments(
            moments_of(cell),
            {volume, Vec3(middle, 0, 0), Matrix3d(Vec3(along - first * middle, across, across).asDiagonal())},
            h > 1.25 ? 2e-7 : 1e-9);
    }
}

TEST_CASE("moments: against closed meshes and random points of cells of every kind") {
    std::mt19937_64 rng(test_seed());
    for (const char* name : {"balls", "lattice", "atom", "tube lattice", "tubes over a plane",
                             "tubes around a tube", "around a cylinder"}) {
        CAPTURE(name);
        const Cell& cell = good(name);
        const Moments m = moments_of(cell);
        const double size = std::cbrt(cell.measures.volume);
        CHECK(m.centroid_error <= 1e-4 * size);
        CHECK(m.second_error <= 1e-4 * std::pow(size, 5));
        MeshOptions options;
        options.closed = true;
        options.chord = 1e-3 * cell_diagonal(cell);
        const CellMesh mesh = tessellate(cell, options);
        const Expected by_mesh = of_mesh(mesh);
        CHECK(by_mesh.volume == doctest::Approx(cell.measures.volume).epsilon(0.01));
        CHECK((by_mesh.centroid - m.centroid).norm() <= 2e-3 * cell_diagonal(cell));
        CHECK((by_mesh.second - m.second).norm() <= 0.02 * m.second.norm());
        // Points of the box that the cell has: their mean, within five of its standard deviations.
        PointQuery query(cell.scene);
        const Box& box = cell.scene.box;
        std::uniform_real_distribution<double> unit(0, 1);
        Vec3 sum = Vec3::Zero();
        Matrix3d squares = Matrix3d::Zero();
        int inside = 0;
        Eigen::AlignedBox3d about;
        for (const Vec3& p : mesh.points) about.extend(p);
        const Vec3 margin = 0.01 * about.diagonal(), lo = about.min() - margin, hi = about.max() + margin;
        const Vec3 from = lo.cwiseMax(box.min), to = hi.cwiseMin(box.max);
        for (int k = 0; k < 10'000; ++k) {
            const Vec3 p = from + (to - from).cwiseProduct(Vec3(unit(rng), unit(rng), unit(rng)));
            const auto answer = query(p);
            if (!answer || !answer->inside) continue;
            ++inside;
            sum += p - m.centroid;
            squares += (p - m.centroid) * (p - m.centroid).transpose();
        }
        REQUIRE(inside > 200);
        const Matrix3d covariance = m.second / cell.measures.volume;
        for (int i = 0; i < 3; ++i)
            CHECK(std::abs(sum[i] / inside) <= 5 * std::sqrt(covariance(i, i) / inside));
        CHECK((squares / inside - covariance).norm() <= 0.2 * covariance.norm());
    }
}

TEST_CASE("moments: move with the scene, scale by powers, and are those of the file") {
    for (const char* name : {"balls", "atom", "tubes around a tube"}) {
        CAPTURE(name);
        const Cell& cell = good(name);
        const Moments m = moments_of(cell);
        const Vec3 by(16, -32, 8);
        const Moments there = moments_of(voronoi_cell(moved(cell.scene, by, 2)));
        CHECK((there.centroid - (2 * m.centroid + by)).norm() <= there.centroid_error + 2 * m.centroid_error);
        CHECK((there.second - 32 * m.second).cwiseAbs().maxCoeff() <=
              there.second_error + 32 * m.second_error);
        // A tighter look than both errors allow.
        CHECK((there.centroid - (2 * m.centroid + by)).norm() <= 1e-8 * cell_diagonal(cell));

        Cell with = cell;
        with.moments = m;
        const Cell read = parse_cell(cell_text(with));
        REQUIRE(read.moments);
        CHECK(read.moments->centroid == m.centroid);
        CHECK(read.moments->second == m.second);
        CHECK(read.moments->second_error == m.second_error);
        CHECK(moments_of(read).centroid == m.centroid);
        CHECK_FALSE(parse_cell(cell_text(cell)).moments);
    }
}

TEST_CASE("moments: cells that share a box have what the box has") {
    // Two cells, one of a ball and one of the other, are the box.
    Scene scene;
    scene.base = Sphere{{-0.5, 0.25, 0}, 0.5};
    scene.objects = {Sphere{{1, 0, 0.25}, 0.125}};
    scene.box = {Vec3::Constant(-2), Vec3::Constant(2)};
    Scene other = scene;
    std::swap(std::get<Sphere>(other.base), std::get<Sphere>(other.objects[0]));
    const Cell a = voronoi_cell(scene), b = voronoi_cell(other);
    const Moments m = moments_of(a), n = moments_of(b);
    const double v = a.measures.volume, w = b.measures.volume;
    CHECK((v * m.centroid + w * n.centroid).norm() <= v * m.centroid_error + w * n.centroid_error + 1e-10);
    const Matrix3d whole = m.second + n.second + v * m.centroid * m.centroid.transpose() +
                           w * n.centroid * n.centroid.transpose();
    CHECK((whole - of_box(scene.box.min, scene.box.max).second).norm() <= 1e-9);
}

TEST_CASE("moments: the check does not pass wrong ones") {
    for (const char* name : {"balls", "atom", "tubes over a plane", "tubes around a tube"}) {
        CAPTURE(name);
        Cell cell = parse_cell(cell_text(good(name)));
        cell.moments = moments_of(cell);
        const Certificate right = certify(cell);
        CHECK_MESSAGE(right.holds(), listing(right));
        const double size = cell_diagonal(cell);
        const auto expect = [&](const char* where, const auto& damage) {
            Cell bad = cell;
            damage(*bad.moments);
            const Certificate certificate = certify(bad);
            CHECK_MESSAGE(std::ranges::any_of(certificate.elements,
                                              [&](const Element& e) {
                                                  return e.verdict != Verdict::proved &&
                                                         e.where.starts_with(where);
                                              }),
                          where, listing(certificate));
        };
        expect("measures.moments.centroid", [&](Moments& m) { m.centroid.y() += 1e-3 * size; });
        expect("measures.moments.second", [&](Moments& m) { m.second(1, 1) += 1e-2 * m.second.trace(); });
        expect("measures.moments", [&](Moments& m) { m.second(0, 1) += 1e-2 * m.second.trace(); });
        expect("measures.moments.centroid_error", [&](Moments& m) { m.centroid_error = 1e6 * size; });
        expect("measures.moments", [&](Moments& m) { m.second_error = not_measured; });
    }
}

}  // namespace vcell
