// The cells of all atoms of a molecule against tangent spheres found by brute force, and against Voronota
// where that program is installed.
#include <doctest/doctest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <memory>
#include <sstream>
#include <vector>

#include "../../envelope/diagram/minimization_diagram.hpp"
#include "../../primitives/bases/radial_base.hpp"
#include "../test_support.hpp"
#include "molecule.hpp"

namespace vcell::molecules_test {
namespace {

using Quadruple = std::array<std::uint32_t, 4>;
using Long = long double;
using LongVector = Eigen::Matrix<Long, 3, 1>;

struct TangentSphere {
    LongVector center;
    Long radius;
};

/// A quadruple of balls has up to two tangent spheres.
using Tangent = std::map<Quadruple, std::vector<TangentSphere>>;

std::vector<Sphere> scaled(std::vector<Sphere> balls, double factor) {
    for (Sphere& b : balls) b = {factor * b.center, factor * b.radius};
    return balls;
}

/// Far larger than the molecule: no tangent sphere of four atoms is cut off.
Box box_around(const std::vector<Sphere>& balls) {
    Box box{balls[0].center, balls[0].center};
    for (const Sphere& b : balls) {
        box.min = box.min.cwiseMin(b.center);
        box.max = box.max.cwiseMax(b.center);
    }
    const Vec3 margin = Vec3::Constant(1000 * box.diagonal());
    return {box.min - margin, box.max + margin};
}

/// The vertices of all atoms' cells that four atoms share, each from the cell of its first atom.
struct Cells {
    Tangent vertices;
    std::map<Quadruple, std::size_t> times;  ///< how often cells have the vertices: once for each atom
    unsigned long assumed = 0;
    std::size_t degenerate = 0;  ///< vertices of more than four atoms
};

Cells cells_of(const std::vector<Sphere>& balls) {
    Cells cells;
    const Box box = box_around(balls);
    for (std::uint32_t i = 0; i < balls.size(); ++i) {
        Scene scene;
        scene.base = balls[i];
        scene.box = box;
        std::vector<std::uint32_t> number;
        for (std::uint32_t j = 0; j < balls.size(); ++j) {
            if (j == i) continue;
            scene.objects.push_back(balls[j]);
            number.push_back(j);
        }
        const RadialBaseProblem problem = radial_base_problem(scene);
        const MinimizationDiagram diagram = lower_envelope_on_sphere(problem.family);
        REQUIRE_FALSE(diagram.dcel.find_defect());
        cells.assumed += diagram.decisions.assumed;
        for (const VertexId v : diagram.vertices.ids()) {
            std::vector<std::uint32_t> atoms{i};
            bool on_box = false;
            for (const FormId f : diagram.label(v))
                for (const Site site : problem.sites[f]) {
                    if (site.is_object())
                        atoms.push_back(number[site.index]);
                    else
                        on_box = true;
                }
            if (on_box) continue;
            if (atoms.size() > 4) {
                ++cells.degenerate;
                continue;
            }
            REQUIRE(atoms.size() == 4);
            std::ranges::sort(atoms);
            const Quadruple q{atoms[0], atoms[1], atoms[2], atoms[3]};
            ++cells.times[q];
            if (atoms[0] != i) continue;
            const MinimizationDiagram::Vertex& at = diagram.vertices[v];
            const double t = problem.chart.distance_of(at.point, at.height);
            const Vec3 p = problem.frame.to_world(problem.chart.point(at.point, t));
            cells.vertices[q].push_back({p.cast<Long>(), t - static_cast<Long>(balls[i].radius)});
        }
    }
    return cells;
}

/// The spheres tangent to four balls from outside (inside them where the radius is negative): differences of
/// |c - c_i|^2 = (r + r_i)^2 are linear, c = a + r b, and one quadratic equation is left.
std::vector<TangentSphere> tangent_spheres(const std::array<Sphere, 4>& s) {
    using LongMatrix = Eigen::Matrix<Long, 3, 3>;
    const LongVector c0 = s[0].center.cast<Long>();
    const Long r0 = s[0].radius;
    LongMatrix m;
    LongVector constant, linear;
    for (int i = 0; i < 3; ++i) {
        const LongVector c = s[i + 1].center.cast<Long>() - c0;
        const Long r = s[i + 1].radius;
        m.row(i) = 2 * c.transpose();
        constant[i] = c.squaredNorm() - r * r + r0 * r0;
        linear[i] = 2 * (r0 - r);
    }
    const Eigen::FullPivLU<LongMatrix> lu(m);
    if (!lu.isInvertible()) return {};
    const LongVector a = lu.solve(constant), b = lu.solve(linear);
    // |a + r b|^2 = (r + r0)^2
    const Long A = b.squaredNorm() - 1, B = a.dot(b) - r0, C = a.squaredNorm() - r0 * r0;
    const Long D = B * B - A * C;
    if (D < 0) return {};
    const Long k = -(B + std::copysign(std::sqrt(D), B));
    std::vector<TangentSphere> found;
    for (const Long r : {C / k, k / A}) {
        if (!std::isfinite(r)) continue;
        if (std::ranges::all_of(s,
                                [&](const Sphere& ball) { return r + static_cast<Long>(ball.radius) > 0; }))
            found.push_back({c0 + a + r * b, r});
    }
    return found;
}

/// Does no ball reach into the sphere by more than rounding?
bool is_empty(const TangentSphere& t, const std::vector<Sphere>& balls) {
    const Long rounding = 1e-12L * (t.center.norm() + std::abs(t.radius));
    return std::ranges::all_of(balls, [&](const Sphere& b) {
        return (b.center.cast<Long>() - t.center).norm() - static_cast<Long>(b.radius) >= t.radius - rounding;
    });
}

/// All quadruples' empty tangent spheres.
Tangent by_brute_force(const std::vector<Sphere>& balls) {
    Tangent all;
    const auto n = static_cast<std::uint32_t>(balls.size());
    for (std::uint32_t i = 0; i < n; ++i)
        for (std::uint32_t j = i + 1; j < n; ++j)
            for (std::uint32_t k = j + 1; k < n; ++k)
                for (std::uint32_t l = k + 1; l < n; ++l)
                    for (const TangentSphere& t : tangent_spheres({balls[i], balls[j], balls[k], balls[l]}))
                        if (is_empty(t, balls)) all[{i, j, k, l}].push_back(t);
    return all;
}

/// The same quadruples with as many spheres each, and the same spheres to 1e-9 of the molecule's unit or, far
/// from it, of their size.
void check_same(const Tangent& found, const Tangent& expected, double unit) {
    CHECK(found.size() == expected.size());
    for (const auto& [quadruple, spheres] : expected) {
        CAPTURE(quadruple[0]);
        CAPTURE(quadruple[1]);
        CAPTURE(quadruple[2]);
        CAPTURE(quadruple[3]);
        const auto at = found.find(quadruple);
        REQUIRE(at != found.end());
        CHECK(at->second.size() == spheres.size());
        for (const TangentSphere& s : spheres) {
            Long least = HUGE_VALL;
            for (const TangentSphere& t : at->second)
                least =
                    std::min(least, std::max((s.center - t.center).norm(), std::abs(s.radius - t.radius)));
            CHECK(static_cast<double>(least) <= 1e-9 * (unit + static_cast<double>(std::abs(s.radius))));
        }
    }
}

std::vector<Quadruple> quadruples(const Tangent& tangent) {
    std::vector<Quadruple> all;
    for (const auto& [quadruple, spheres] : tangent) all.insert(all.end(), spheres.size(), quadruple);
    return all;
}

TEST_CASE("molecule: the cells of a fragment have the vertices that trying all quadruples finds") {
    std::vector<Sphere> balls = molecule("1CRN.xyzr");
    for (const std::size_t first : {0u, 150u}) {
        const std::vector<Sphere> fragment(balls.begin() + first, balls.begin() + first + 48);
        const Cells cells = cells_of(fragment);
        CHECK(cells.assumed == 0);
        CHECK(cells.degenerate == 0);
        check_same(cells.vertices, by_brute_force(fragment), 1);
    }
}

TEST_CASE("molecule: the cells of all atoms of crambin agree with each other, at every scale") {
    const std::vector<Sphere> balls = molecule("1CRN.xyzr");
    REQUIRE(balls.size() == 327);
    std::vector<Quadruple> unscaled;
    for (const double factor : {1.0, 1e-4, 1e4}) {
        CAPTURE(factor);
        const std::vector<Sphere> atoms = scaled(balls, factor);
        const Cells cells = cells_of(atoms);
        CHECK(cells.assumed == 0);
        CHECK(cells.degenerate == 0);
        CHECK(cells.times.size() == cells.vertices.size());
        for (const auto& [quadruple, spheres] : cells.vertices) {
            CHECK(cells.times.at(quadruple) == 4 * spheres.size());
            for (const TangentSphere& t : spheres) CHECK(is_empty(t, atoms));
        }
        const std::vector<Quadruple> found = quadruples(cells.vertices);
        if (factor == 1) unscaled = found;
        CHECK(found == unscaled);
    }
    CHECK(unscaled.size() == 1996);  // as many as Voronota 1.22 finds
}

/// What `voronota calculate-vertices` says.
Tangent by_voronota(const std::string& program, const std::string& file) {
    const std::string command = "'" + program + "' calculate-vertices < '" + file + "'";
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> pipe(popen(command.c_str(), "r"), pclose);
    REQUIRE(pipe);
    Tangent all;
    Quadruple q;
    double x, y, z, r;
    while (std::fscanf(pipe.get(), "%u %u %u %u %lf %lf %lf %lf", &q[0], &q[1], &q[2], &q[3], &x, &y, &z,
                       &r) == 8) {
        std::ranges::sort(q);
        all[q].push_back({LongVector(x, y, z), r});
    }
    return all;
}

TEST_CASE("molecule: the cells of all atoms of crambin have Voronota's vertices" *
          doctest::skip(std::string(VCELL_VORONOTA).empty())) {
    const Tangent theirs = by_voronota(VCELL_VORONOTA, test_data("1CRN.xyzr"));
    REQUIRE(theirs.size() > 1000);
    check_same(cells_of(molecule("1CRN.xyzr")).vertices, theirs, 1);
}

}  // namespace
}  // namespace vcell::molecules_test
