// What areas and volumes change by where an edge leaves its place, by differences.
#include <doctest/doctest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>
#include <vector>

#include "../../envelope/measures/radial_integrals.hpp"
#include "../../primitives/bases/radial_base.hpp"
#include "../test_support.hpp"

namespace vcell::measure_slopes_test {

using namespace vcell::testing;
using radial_integrals::RoundFace;
using radial_integrals::Share;

namespace {

// The factors of (1 - z^2) d phi along a ring of the bisector at the distance t from the base's centre.
Share ring_factors(const RoundFace& face, double t) {
    const double z = (face.k / t - face.e0) / face.e1, across = std::sqrt(1 - z * z);
    const Vec3 side = face.axis.unitOrthogonal(), u = z * face.axis + across * side,
               du = face.axis.cross(side);
    const Share share = face.share({{u.x(), u.y(), u.z()}, {du.x(), du.y(), du.z()}, 0, 1});
    return {share.volume / across, share.area / across};
}

// A ring at (t, z) moved by a length in its half-plane, for its own length: `by_t` what the factor changes by
// with t, `mean` what a closed bisector has by solid angle.
double change(double factor, double by_t, double mean, double t, double z) {
    return std::hypot(std::sqrt(1 - z * z) * by_t, (2 * z * factor + mean) / t) / t;
}

struct Largest {
    double volume = 0, area = 0;  // parts of the slopes
};

std::vector<RoundFace> random_faces(std::mt19937_64& rng) {
    std::uniform_real_distribution<double> uniform(0, 1);
    const double size = std::pow(2, 6 * uniform(rng) - 3), radius = 1 + size * uniform(rng),
                 gap = std::pow(10, -6 * uniform(rng));
    Scene scene;
    scene.base = Sphere{Vec3::Zero(), 1};
    scene.objects = {Sphere{{0, 0, 1 + gap}, 0}, Sphere{{0, 0, 1 + radius + gap}, radius},
                     Sphere{{0, 0, 2 + gap}, 1}, Plane{{0, 0, 1 + gap}, {0, 0, 1}},
                     HollowSphere{{0, 0, gap * uniform(rng)}, 1 + gap + size * uniform(rng)}};
    scene.box = {Vec3::Constant(-20), Vec3::Constant(20)};
    const RadialBaseProblem problem = radial_base_problem(scene);
    std::vector<RoundFace> faces;
    for (const FormId form : problem.objects.ids()) {
        faces.emplace_back(problem, form);
        if (!faces.back().is_ellipsoid()) continue;
        faces.push_back(faces.back());
        faces.back().shape = RoundFace::Shape::Closed;
    }
    return faces;
}

}  // namespace

TEST_CASE("measure slopes: areas and volumes change no more across an edge than they say") {
    std::mt19937_64 rng(test_seed());
    std::uniform_real_distribution<double> uniform(0, 1);
    std::map<RoundFace::Shape, Largest> largest;
    for (int i = 0; i < 400; ++i)
        for (const RoundFace& face : random_faces(rng)) {
            const bool is_bounded = face.is_closed() || face.is_ellipsoid();
            const double most = is_bounded ? face.d2 : 20, t = face.d1 + (most - face.d1) * uniform(rng),
                         step = 1e-5 * std::min(t - face.d1, most - t);
            if (!(step > 1e-9 * t)) continue;
            const Share at = ring_factors(face, t), less = ring_factors(face, t - step),
                        more = ring_factors(face, t + step),
                        mean = face.is_closed() ? face.mean() : Share{0, 0};
            const double z = (face.k / t - face.e0) / face.e1;
            const double volume =
                             change(at.volume, (more.volume - less.volume) / (2 * step), mean.volume, t, z),
                         area = change(at.area, (more.area - less.area) / (2 * step), mean.area, t, z);
            CAPTURE(static_cast<int>(face.shape));
            CAPTURE(t);
            CHECK(volume <= face.volume_slope(t, t) * (1 + 1e-6));
            CHECK(area <= face.area_slope(t, t) * (1 + 1e-6));
            Largest& parts = largest[face.shape];
            parts.volume = std::max(parts.volume, volume / face.volume_slope(t, t));
            parts.area = std::max(parts.area, area / face.area_slope(t, t));
        }
    CHECK(largest.size() == 5);
    for (const auto& [shape, parts] : largest) {  // they are no looser than need be
        CAPTURE(static_cast<int>(shape));
        CHECK(parts.volume > 0.3);
        CHECK(parts.area > 0.3);
    }
}

}  // namespace vcell::measure_slopes_test
