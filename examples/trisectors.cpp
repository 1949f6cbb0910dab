// Draws docs/pictures/trisectors.svg: the five kinds of trisectors that are no conics [HE, Table 2], each
// with its three objects in a box.
//
// Usage: trisectors (writes to standard output)
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include <vcell/vcell.hpp>

namespace {

using vcell::Box;
using vcell::Cylinder;
using vcell::Object;
using vcell::Plane;
using vcell::Sphere;
using vcell::Vec3;

const Box box{{-3, -3, 0}, {3, 3, 5}};
constexpr double tolerance = 1e-4, scale = 26, panel = 236;

const Plane ground{{0, 0, 0}, {0, 0, 1}};
const Sphere ball{{1, 1, 3}, 0.9}, marble{{-1.2, 0, 1.5}, 0.5};
const Cylinder across{{0, -1, 1.6}, {1, 0.1, 0.05}, 0.4}, away{{1.2, 0, 3}, {0, 1, 0.2}, 0.3},
    upright{{-1, 1.2, 2}, {0.1, 0.1, 1}, 0.5};

struct Row {
    const char* name;
    Object base, a, b;
};

// Seen from the front, a little from the right and from above.
const Vec3 right = Vec3(0.9, 0.43, 0).normalized(), view = Vec3(0.4, -0.83, 0.4).normalized(),
           along = (view - view.dot(right) * right).normalized(), up = along.cross(right);

Eigen::Vector2d seen(const Vec3& p, double left) {
    const Vec3 q = p - 0.5 * (box.min + box.max);
    return {left + 0.5 * panel + scale * q.dot(right), 110 - scale * q.dot(up)};
}

void polyline(const std::vector<Vec3>& points, double left, const char* style) {
    std::printf("<polyline fill=\"none\" %s points=\"", style);
    for (const Vec3& p : points) {
        const auto s = seen(p, left);
        std::printf("%.1f,%.1f ", s.x(), s.y());
    }
    std::printf("\"/>\n");
}

Vec3 corner(int i) {
    return {i & 1 ? box.max.x() : box.min.x(), i & 2 ? box.max.y() : box.min.y(),
            i & 4 ? box.max.z() : box.min.z()};
}

void draw(const Object& object, double left, const char* colour) {
    if (const auto* sphere = std::get_if<Sphere>(&object)) {
        const auto c = seen(sphere->center, left);
        std::printf("<circle cx=\"%.1f\" cy=\"%.1f\" r=\"%.1f\" fill=\"%s\" fill-opacity=\"0.35\"/>\n", c.x(),
                    c.y(), scale * sphere->radius, colour);
    } else if (const auto* c = std::get_if<Cylinder>(&object)) {
        // Where its axis is in the box.
        double from = -HUGE_VAL, to = HUGE_VAL;
        for (int k = 0; k < 3; ++k) {
            const double s = (box.min[k] - c->point[k]) / c->axis[k],
                         t = (box.max[k] - c->point[k]) / c->axis[k];
            if (c->axis[k] == 0) continue;
            from = std::max(from, std::min(s, t));
            to = std::min(to, std::max(s, t));
        }
        if (!(from < to)) return;
        char style[120];
        std::snprintf(style, sizeof style, "stroke=\"%s\" stroke-opacity=\"0.35\" stroke-width=\"%.1f\"",
                      colour, 2 * scale * std::max(c->radius, 0.02));
        polyline({c->point + from * c->axis, c->point + to * c->axis}, left, style);
    } else {
        std::printf("<polygon fill=\"%s\" fill-opacity=\"0.25\" points=\"", colour);
        for (const int i : {0, 1, 3, 2}) {
            const auto s = seen(corner(i), left);
            std::printf("%.1f,%.1f ", s.x(), s.y());
        }
        std::printf("\"/>\n");
    }
}

void draw(const Row& row, double left) {
    for (int i = 0; i < 8; ++i)
        for (const int bit : {1, 2, 4})
            if (!(i & bit))
                polyline({corner(i), corner(i | bit)}, left, "stroke=\"#bbb\" stroke-width=\"0.6\"");
    draw(row.base, left, "#345");
    draw(row.a, left, "#27c");
    draw(row.b, left, "#2a4");
    const std::vector<vcell::TrisectorCurve> found = trisector(row.base, row.a, row.b, box, tolerance);
    double error = 0;
    std::size_t spans = 0;
    for (const vcell::TrisectorCurve& curve : found) {
        error = std::max(error, curve.error);
        for (const vcell::RationalCurve3& arc : curve.arcs) {
            std::vector<Vec3> points;
            for (std::size_t k = 0; k + 1 < arc.knots.size(); ++k) {
                if (!(arc.knots[k] < arc.knots[k + 1])) continue;
                ++spans;
                for (int i = 0; i <= 12; ++i)
                    points.push_back(arc.evaluate(std::lerp(arc.knots[k], arc.knots[k + 1], i / 12.0)));
            }
            polyline(points, left, "stroke=\"#c22\" stroke-width=\"1.6\"");
        }
    }
    std::printf("<text x=\"%.0f\" y=\"228\" text-anchor=\"middle\">%s</text>\n", left + 0.5 * panel,
                row.name);
    std::printf(
        "<text x=\"%.0f\" y=\"243\" text-anchor=\"middle\" fill=\"#666\">%zu curve%s, %zu spans, "
        "within %.1e</text>\n",
        left + 0.5 * panel, found.size(), found.size() == 1 ? "" : "s", spans, error);
}

}  // namespace

int main() {
    const std::array<Row, 5> rows{{{"plane, sphere, cylinder", ground, ball, across},
                                   {"plane, cylinder, cylinder", ground, across, away},
                                   {"sphere, sphere, cylinder", marble, ball, across},
                                   {"sphere, cylinder, cylinder", ball, across, upright},
                                   {"cylinder, cylinder, cylinder", upright, across, away}}};
    std::printf(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%.0f\" height=\"252\" "
        "font-family=\"sans-serif\" font-size=\"11\">\n<rect width=\"100%%\" height=\"100%%\" "
        "fill=\"#fff\"/>\n",
        panel * rows.size());
    for (std::size_t i = 0; i < rows.size(); ++i) draw(rows[i], panel * static_cast<double>(i));
    std::printf("</svg>\n");
}
