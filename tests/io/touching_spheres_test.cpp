/// What touching spheres bound along edges and on patches of computed cells, against distances in long
/// doubles.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>

#include "../../envelope/voronoi_cell.hpp"
#include "../../io/check/touching_spheres.hpp"
#include "../test_support.hpp"
#include "random_scenes.hpp"

namespace vcell::check {
namespace {

using Real = long double;
using Point = Eigen::Matrix<Real, 3, 1>;

/// A point of a net, of which rounding of its control points is no part.
Point point(const Net& net, Real s, Real t) {
    const int m = net.degree_s(), n = net.degree_t();
    const auto bernstein = [](int degree, int i, Real x) {
        auto product = static_cast<Real>(binomial(degree, i));
        for (int k = 0; k < degree; ++k) product *= k < i ? x : 1 - x;
        return product;
    };
    Eigen::Matrix<Real, 4, 1> sum = Eigen::Matrix<Real, 4, 1>::Zero();
    for (int i = 0; i <= m; ++i)
        for (int j = 0; j <= n; ++j)
            for (int k = 0; k < 4; ++k)
                sum[k] += bernstein(m, i, s) * bernstein(n, j, t) * static_cast<Real>(net.at(i, j)[k].mid());
    return net.origin().cast<Real>() + sum.head<3>() / sum[3];
}

Real distance(const Object& object, const Point& p) {
    if (const auto* ball = std::get_if<Sphere>(&object))
        return (p - ball->center.cast<Real>()).norm() - static_cast<Real>(ball->radius);
    const auto& plane = std::get<Plane>(object);
    return std::abs(plane.normal.cast<Real>().normalized().dot(p - plane.point.cast<Real>()));
}
Point gradient(const Object& object, const Point& p) {
    if (const auto* ball = std::get_if<Sphere>(&object)) return (p - ball->center.cast<Real>()).normalized();
    const auto& plane = std::get<Plane>(object);
    const Point n = plane.normal.cast<Real>().normalized();
    return n.dot(p - plane.point.cast<Real>()) < 0 ? Point(-n) : n;
}

/// The least singular value of the matrix with rows g and h.
Real least_singular_value(const Point& g, const Point& h) {
    const Real a = g.squaredNorm(), b = h.squaredNorm(), c = g.dot(h);
    const Real greatest = 0.5L * (a + b) + std::sqrt(0.25L * (a - b) * (a - b) + c * c);
    return std::sqrt(std::max(0.0L, (a * b - c * c) / greatest));
}

/// How often bounds were there, and how good they were.
struct Tally {
    int excesses = 0, narrow = 0, farther = 0, slopes = 0, beside = 0, sharp = 0;
};

constexpr Real rounding = 1e-17L, rounding_of_slopes = 1e-12L;

class Judge {
public:
    Judge(const Scene& scene, std::mt19937_64& rng, Tally& tally) : scene_(scene), rng_(rng), tally_(tally) {}

    void judge(const Net& net, const TouchingSpheres& spheres, std::span<const Site> own) {
        std::vector<Point> points;
        for (int i = 0; i <= samples; ++i)
            for (int j = 0; j <= (net.degree_t() > 0 ? samples : 0); ++j)
                points.push_back(point(net, Real(i) / samples, Real(j) / samples));
        for (const Point& p : points) {
            const Real t = distance(scene_.base, p);
            CHECK(spheres.clearance().lower() <= t + rounding);
            CHECK(spheres.clearance().upper() >= t - rounding);
        }
        for (std::uint32_t k = 0; k < scene_.objects.size(); ++k) judge_object(spheres, points, k, own);
        if (own.size() == 2) judge_slopes(spheres, points, own[0], own[1]);
    }

private:
    static constexpr int samples = 16;

    Point near(const Point& p, double margin) {
        std::normal_distribution<double> normal;
        return p + Vec3(margin * Vec3(normal(rng_), normal(rng_), normal(rng_)).normalized()).cast<Real>();
    }
    Real excess(std::uint32_t k, const Point& p) const {
        return distance(scene_.objects[k], p) - distance(scene_.base, p);
    }

    void judge_object(const TouchingSpheres& spheres, std::span<const Point> points, std::uint32_t k,
                      std::span<const Site> own) {
        const Site site = Site::object(k);
        const auto known = spheres.excess({site});
        const auto least = spheres.least(site);
        Real lowest = HUGE_VALL, highest = -HUGE_VALL;
        for (const Point& p : points) {
            const Real e = excess(k, p);
            lowest = std::min(lowest, e);
            highest = std::max(highest, e);
            if (!least) continue;
            const auto* ball = std::get_if<Sphere>(&scene_.objects[k]);
            const Real f =
                ball ? e * (e + 2 * (distance(scene_.base, p) + static_cast<Real>(ball->radius))) : e;
            CHECK(*least <= f + rounding);
        }
        if (known) {
            ++tally_.excesses;
            CHECK(known->lower() <= lowest + rounding);
            CHECK(known->upper() >= highest - rounding);
            const bool is_own = std::ranges::find(own, site) != own.end();
            tally_.narrow += is_own && known->upper() - known->lower() < 1e-12;
        }
        constexpr double margin = 0.02;
        if (spheres.is_farther(site, margin)) {
            ++tally_.farther;
            for (const Point& p : points) CHECK(excess(k, near(p, margin)) >= 0);
        }
    }

    void judge_slopes(const TouchingSpheres& spheres, std::span<const Point> points, const Site& a,
                      const Site& b) {
        constexpr double margin = 1e-3, size = 1e-9;
        const auto slopes = spheres.slopes(a, b, size, margin);
        const auto growth = spheres.growth(a.is_object() ? a : b, size, margin);
        if (!slopes || !growth) return;
        const bool is_beside = !a.is_object() || !b.is_object();
        ++(is_beside ? tally_.beside : tally_.slopes);
        Real least = HUGE_VALL;
        for (const Point& on : points) {
            const Point p = near(on, margin);
            const Point g = gradient_of_excess(a, p), h = gradient_of_excess(b, p);
            least = std::min(least, least_singular_value(g, h));
            CHECK(slopes->both <= least_singular_value(g, h) + rounding_of_slopes);
            CHECK(slopes->growth <= 0.5L * std::min(g.squaredNorm(), h.squaredNorm()) + rounding_of_slopes);
            CHECK(*growth <= 0.5L * (a.is_object() ? g : h).squaredNorm() + rounding_of_slopes);
        }
        tally_.sharp += slopes->both > 0.5L * least;
    }
    Point gradient_of_excess(const Site& site, const Point& p) const {
        if (site.is_object()) return gradient(scene_.objects[site.index], p) - gradient(scene_.base, p);
        Point inwards = Point::Zero();
        inwards[site.index / 2] = site.index % 2 ? -1 : 1;
        return inwards;
    }

    const Scene& scene_;
    std::mt19937_64& rng_;
    Tally& tally_;
};

}  // namespace

TEST_CASE("touching spheres: bound clearances, excesses and slopes along edges and on patches") {
    std::mt19937_64 rng(test_seed());
    for (const bool over_plane : {false, true}) {
        CAPTURE(over_plane);
        Tally edges, patches;
        for (int k = 0; k < 12; ++k) {
            const Cell cell =
                voronoi_cell(over_plane ? scene_over_plane(rng, 10, 2) : scene_about_ball(rng, 10, 2));
            const Space<Interval> space(cell.scene);
            for (const CellEdge& e : cell.edges) {
                // Sides of the box upright on a base plane are rims of its region.
                const auto counts = [&](const Site& s) {
                    return s.is_object() || (s.kind == Site::Kind::BoxSide && (!over_plane || s.index == 5));
                };
                if (!counts(e.sites[0]) || !counts(e.sites[1])) continue;
                if (!e.sites[0].is_object() && !e.sites[1].is_object()) continue;
                const Vec3 origin = e.curve.points.front().head<3>();
                for (const auto& span : spans<3>(e.curve, origin)) {
                    const Net net(span, origin);
                    auto spheres = TouchingSpheres::along(net, space);
                    if (!spheres) continue;
                    for (const Site& s : e.sites)
                        if (spheres->refer_to(s)) break;
                    Judge(cell.scene, rng, edges).judge(net, *spheres, e.sites);
                }
            }
            for (const CellFace& face : cell.faces)
                for (const TrimmedPatch& patch : face.patches) {
                    if (!face.site.is_object()) continue;
                    const Net net(patch.surface, patch.surface.points[0].head<3>());
                    auto spheres = TouchingSpheres::on(net, face.site, space);
                    if (!spheres) continue;
                    spheres->refer_to(face.site);
                    Judge(cell.scene, rng, patches).judge(net, *spheres, std::span(&face.site, 1));
                }
        }
        CHECK(edges.excesses > 500);
        CHECK(edges.narrow > 100);
        CHECK(edges.farther > 300);
        CHECK(edges.slopes > 50);
        if (!over_plane) CHECK(edges.beside > 5);
        CHECK(2 * edges.sharp > edges.slopes + edges.beside);
        CHECK(patches.excesses > 50);
        CHECK(patches.narrow > 20);
        CHECK(patches.farther > 10);
    }
}

}  // namespace vcell::check
