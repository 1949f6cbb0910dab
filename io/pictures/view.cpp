#include "view.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <unordered_map>
#include <utility>
#include <variant>

#include "site_style.hpp"
#include "solids.hpp"

namespace vcell {

namespace {

// How much of what lies behind each is hidden.
constexpr float of_face = 0.6F, of_side = 0.12F, of_base = 1, of_object = 0.42F, of_flat_object = 0.2F,
                of_vessel = 0.12F;
constexpr std::string_view grey = "#cccccc", dark = "#222222";

Colour colour_of(std::string_view name) {
    Colour colour{};
    std::ranges::transform(channels(name), colour.begin(), [](int c) { return static_cast<float>(c) / 255; });
    return colour;
}

struct Shape {
    std::vector<CornerTriangle> triangles;
    Colour colour;
    float opacity;
};

/// Right, down, and towards the viewer: rows.
Eigen::Matrix3d frame(const ViewOptions& options) {
    const double degree = std::numbers::pi / 180, a = degree * options.azimuth,
                 e = degree * options.elevation;
    Eigen::Matrix3d rows;
    rows.row(0) = Vec3(-std::sin(a), std::cos(a), 0);
    rows.row(1) = Vec3(std::cos(a) * std::sin(e), std::sin(a) * std::sin(e), -std::cos(e));
    rows.row(2) = Vec3(std::cos(a) * std::cos(e), std::sin(a) * std::cos(e), std::sin(e));
    return rows;
}

class View {
public:
    View(const Cell& cell, const CellMesh& mesh, const ViewOptions& options)
        : cell_(cell),
          mesh_(mesh),
          options_(options),
          frame_(frame(options)),
          colours_(object_colours(cell)) {
        for (const CellMesh::Group& group : mesh.groups) add_group(group);
        add_lines();
        if (!options.has_objects) return;
        add_object(cell.scene.base, colour_of(grey), of_base);
        for (std::size_t i = 0; i < cell.scene.objects.size(); ++i)
            if (cell.scene.competes(i)) {
                const Object& object = cell.scene.objects[i];
                add_object(object, object_colour(cell.scene.number(i)),
                           is_vessel(object)                       ? of_vessel
                           : std::holds_alternative<Plane>(object) ? of_flat_object
                                                                   : of_object);
            }
    }

    Image image() const {
        constexpr std::size_t samples = 2;
        const std::size_t pixels = samples * options_.size;
        Vec3 low = Vec3::Constant(INFINITY), high = -low;
        for (const Shape& shape : shapes_)
            for (const CornerTriangle& triangle : shape.triangles)
                for (const Corner& c : triangle) {
                    const Vec3 p = frame_ * c.point;
                    low = low.cwiseMin(p);
                    high = high.cwiseMax(p);
                }
        constexpr double filled = 0.94;  // of the picture
        const auto side = static_cast<double>(pixels);
        const double scale = filled * side / std::max((high - low).head<2>().maxCoeff(), 1e-300);
        const Vec3 middle = 0.5 * (low + high), center(0.5 * (side - 1), 0.5 * (side - 1), 0);
        const auto place = [&](const Vec3& p) -> Vec3 { return center + scale * (frame_ * p - middle); };
        // From both sides alike: what is translucent shows its inside.
        const Vec3 light = Vec3(-0.4, -0.5, 1).normalized();
        const auto shade = [&](const Vec3& normal) {
            return 0.55 + 0.45 * std::abs(light.dot((frame_ * normal).stableNormalized()));
        };

        Raster raster(pixels, pixels);
        for (const Shape& shape : shapes_)
            for (const auto& [a, b, c] : shape.triangles)
                raster.triangle({place(a.point), place(b.point), place(c.point)},
                                {shade(a.normal), shade(b.normal), shade(c.normal)}, shape.colour,
                                shape.opacity);
        constexpr double half_width = 0.7 * samples, nearer = 0.004;
        for (const auto& [a, b] : lines_)
            raster.line(place(a), place(b), half_width, nearer * side, colour_of(dark));
        return raster.image(samples);
    }

private:
    Colour object_colour(std::uint32_t object) const {
        const auto known = colours_.find(object);
        return colour_of(known == colours_.end() ? grey : palette()[known->second]);
    }

    void add_group(const CellMesh::Group& group) {
        std::vector<CornerTriangle> triangles;
        for (std::size_t t = group.begin; t < group.end; ++t) {
            const Triangle &p = mesh_.triangles[t], &n = mesh_.corner_normals[t];
            CornerTriangle& triangle = triangles.emplace_back();
            for (std::size_t k = 0; k < 3; ++k) triangle[k] = {mesh_.points[p[k]], mesh_.normals[n[k]]};
        }
        const bool is_face = group.kind == CellMesh::Group::Kind::Face;
        const Site site = is_face ? cell_.faces[group.face].site : Site::base();
        shapes_.push_back({clipped(triangles, options_.clips),
                           site.is_object() ? object_colour(site.index) : colour_of(grey),
                           site.is_object() ? of_face : of_side});
    }

    void add_lines() {
        for (const auto& line : mesh_.edge_lines)
            for (std::size_t i = 1; i < line.size(); ++i)
                add_line(mesh_.points[line[i - 1]], mesh_.points[line[i]]);
    }
    void add_line(Vec3 a, Vec3 b) {
        for (const Plane& plane : options_.clips) {
            const double v = plane.normal.dot(a - plane.point), w = plane.normal.dot(b - plane.point);
            if (v < 0 && w < 0) return;
            const Vec3 between = v == w ? a : Vec3(a + v / (v - w) * (b - a));
            if (v < 0) a = between;
            if (w < 0) b = between;
        }
        lines_.emplace_back(a, b);
    }

    void add_object(const Object& object, const Colour& colour, float opacity) {
        shapes_.push_back({surface_of(object, cell_.scene.box), colour, opacity});
    }

    const Cell& cell_;
    const CellMesh& mesh_;
    const ViewOptions& options_;
    Eigen::Matrix3d frame_;
    std::unordered_map<std::uint32_t, std::size_t> colours_;
    std::vector<Shape> shapes_;
    std::vector<std::pair<Vec3, Vec3>> lines_;
};

}  // namespace

Image draw_view(const Cell& cell, const CellMesh& mesh, const ViewOptions& options) {
    return View(cell, mesh, options).image();
}

}  // namespace vcell
