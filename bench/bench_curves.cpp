// The time to find, prove and fit a trisector, one thread: all of its curves in the box [-10, 10]^3, over
// random triples of the five kinds that are no conics [HE, Table 2], whether or not they cut each other:
//
//   psc, pcc    a plane; a sphere and a cylinder, two cylinders
//   ssc, scc    a sphere; likewise
//   ccc         three cylinders
//
// fitted at 1e-4 and at 1e-7 of the box's diagonal.
//
// Usage: bench_curves [triples, default 100]
//
// One CSV row per family and tolerance: medians over the triples that have a trisector in the box. Times are
// CPU time, the best of three runs of each triple. Every result is checked: sampled points of the splines are
// equally far from all three objects to within the certified error. A failure is the exit status 1.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "../core/errors.hpp"
#include "../envelope/trisector/trisector_curves.hpp"
#include "median.hpp"

namespace vcell::bench {
namespace {

const Box box{{-10, -10, -10}, {10, 10, 10}};

double distance(const Object& object, const Vec3& p) {
    if (const auto* s = std::get_if<Sphere>(&object)) return (p - s->center).norm() - s->radius;
    if (const auto* c = std::get_if<Cylinder>(&object))
        return (p - c->point).cross(c->axis.normalized()).norm() - c->radius;
    const Plane& plane = std::get<Plane>(object);
    return std::abs(plane.normal.normalized().dot(p - plane.point));
}

class Objects {
public:
    Object next(char kind) {
        const double radius = number(0.3, 2);
        if (kind == 's') return Sphere{vector(8), radius};
        if (kind == 'c') return Cylinder{vector(8), vector(1), radius};
        return Plane{vector(8), vector(1)};
    }

private:
    double number(double low, double high) { return std::uniform_real_distribution(low, high)(rng_); }
    Vec3 vector(double most) {
        const double x = number(-most, most), y = number(-most, most), z = number(-most, most);
        return {x, y, z};
    }
    std::mt19937_64 rng_{20090217};
};

double seconds() { return double(std::clock()) / CLOCKS_PER_SEC; }

struct Row {
    std::vector<double> time, curves, spans;
};

// Measures one triple; false: a wrong result. No trisector, or none that is told: no entry.
bool measure(const std::vector<Object>& o, double tolerance, Row& row) {
    double time = HUGE_VAL;
    std::vector<TrisectorCurve> found;
    try {
        for (int repetition = 0; repetition < 3; ++repetition) {
            const double start = seconds();
            found = trisector(o[0], o[1], o[2], box, tolerance);
            time = std::min(time, seconds() - start);
        }
    } catch (const UndecidedError&) {
        return true;
    }
    std::size_t spans = 0;
    for (const TrisectorCurve& curve : found)
        for (const RationalCurve3& spline : curve.arcs) {
            spans += spline.points.size() / 5;
            for (int i = 0; i <= 100; ++i) {
                const Vec3 p =
                    spline.evaluate(std::lerp(spline.domain_begin(), spline.domain_end(), i / 100.0));
                for (const int k : {1, 2})
                    if (!(std::abs(distance(o[k], p) - distance(o[0], p)) <= 2 * curve.error + 1e-12))
                        return false;
            }
        }
    if (found.empty()) return true;
    row.time.push_back(time);
    row.curves.push_back(double(found.size()));
    row.spans.push_back(double(spans));
    return true;
}

int run(std::size_t triples) {
    constexpr double tolerances[] = {1e-4, 1e-7};
    int status = 0;
    std::printf("family,triples,tolerance_of_diagonal,seconds,curves,spans\n");
    for (const std::string_view family : {"psc", "pcc", "ssc", "scc", "ccc"})
        for (const double tolerance : tolerances) {
            Objects random;
            Row row;
            while (row.time.size() < triples) {
                std::vector<Object> objects;
                for (const char kind : family) objects.push_back(random.next(kind));
                if (!measure(objects, tolerance * box.diagonal(), row)) {
                    std::fprintf(stderr, "wrong result after %zu triples\n", row.time.size());
                    status = 1;
                }
            }
            std::printf("%s,%zu,%g,%.3g,%g,%g\n", std::string(family).c_str(), row.time.size(), tolerance,
                        median(row.time), median(row.curves), median(row.spans));
        }
    return status;
}

}  // namespace
}  // namespace vcell::bench

int main(int argc, char** argv) {
    return vcell::bench::run(argc > 1 ? std::strtoul(argv[1], nullptr, 10) : 100);
}
