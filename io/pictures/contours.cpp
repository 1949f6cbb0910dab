#include "contours.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>
#include <variant>

#include "../../primitives/objects/decided_scene.hpp"
#include "mesh.hpp"

namespace vcell {

namespace {

/// A signed distance and the direction in which it grows.
struct Nearness {
    double distance;
    Vec3 gradient;
};

Nearness from_axis(const Vec3& across, double radius, bool is_hollow) {
    const double length = across.norm();
    const Vec3 out = length > 0 ? Vec3(across / length) : Vec3::Zero();
    return is_hollow ? Nearness{radius - length, -out} : Nearness{length - radius, out};
}
Vec3 across(const Vec3& from, const Vec3& axis) {
    const Vec3 unit = axis.stableNormalized();
    return from - unit.dot(from) * unit;
}

/// A plane's distance has the sign of the side that the point is on.
Nearness near(const Plane& o, const Vec3& p) {
    const Vec3 unit = o.normal.stableNormalized();
    return {unit.dot(p - o.point), unit};
}
Nearness near(const Sphere& o, const Vec3& p) { return from_axis(p - o.center, o.radius, false); }
Nearness near(const HollowSphere& o, const Vec3& p) { return from_axis(p - o.center, o.radius, true); }
Nearness near(const Cylinder& o, const Vec3& p) {
    return from_axis(across(p - o.point, o.axis), o.radius, false);
}
Nearness near(const HollowCylinder& o, const Vec3& p) {
    return from_axis(across(p - o.point, o.axis), o.radius, true);
}
Nearness near(const HollowCone& o, const Vec3& p) {
    const Vec3 unit = o.axis.stableNormalized(), from = p - o.apex, out = across(from, o.axis);
    const Nearness around = from_axis(out, 0, true);
    return {o.sine() * unit.dot(from) + o.cosine() * around.distance,
            o.sine() * unit + o.cosine() * around.gradient};
}
Nearness near(const Object& object, const Vec3& p) {
    return std::visit([&](const auto& o) { return near(o, p); }, object);
}

/// The surface that a face lies on: where its excess is 0.
class Bisector {
public:
    Bisector(const Cell& cell, Site site) : scene_(cell.scene), site_(site) {
        if (site.is_object()) object_ = scene_.objects[site.index];
        if (site.kind == Site::Kind::Cap) object_ = cap_of(scene_.base, *scene_.probe);
    }

    Nearness base(const Vec3& p) const { return near(scene_.base, p); }

    /// What the site is farther away than the base, or a side of the box than p.
    Nearness excess(const Vec3& p) const {
        if (!object_) return side(p);
        Nearness other = near(*object_, p);
        if (other.distance < 0 && std::holds_alternative<Plane>(*object_))
            other = {-other.distance, -other.gradient};
        const Nearness own = base(p);
        return {other.distance - own.distance, other.gradient - own.gradient};
    }

    /// The point above the same base point that is on the bisector: excess never grows along a ray. `from` is
    /// near it.
    Vec3 lifted(const Vec3& from) const {
        const Vec3 up = base(from).gradient;
        Vec3 p = from;
        constexpr int most = 20;
        for (int k = 0; k < most; ++k) {
            const Nearness e = excess(p);
            const double slope = e.gradient.dot(up);
            if (!(slope < -least_slope)) break;
            const double step = -e.distance / slope;
            p += step * up;
            if (std::abs(step) <= enough * scene_.box.diagonal()) break;
        }
        return p;
    }

    /// The nearest point at that clearance, by Newton's method from near it; none where the level curve's
    /// place is not determined.
    std::optional<Vec3> at_level(const Vec3& from, double level) const {
        Vec3 p = from;
        constexpr int most = 20;
        for (int k = 0; k < most; ++k) {
            const Nearness own = base(p), e = excess(p);
            const Vec3 &a = own.gradient, &b = e.gradient;
            const double aa = a.squaredNorm(), ab = a.dot(b), bb = b.squaredNorm(), sine = aa * bb - ab * ab;
            if (!(sine > least_slope * aa * bb)) return std::nullopt;
            const double f = own.distance - level, g = e.distance;
            const Vec3 step = ((bb * f - ab * g) * a + (aa * g - ab * f) * b) / sine;
            p -= step;
            if (step.norm() <= enough * scene_.box.diagonal()) return p;
        }
        return std::nullopt;
    }

private:
    static constexpr double least_slope = 1e-9, enough = 1e-13;

    Nearness side(const Vec3& p) const {
        const auto axis = static_cast<Eigen::Index>(site_.index / 2);
        const Vec3 unit = Vec3::Unit(axis);
        return site_.index % 2 == 0 ? Nearness{p[axis] - scene_.box.min[axis], unit}
                                    : Nearness{scene_.box.max[axis] - p[axis], -unit};
    }

    const Scene& scene_;
    Site site_;
    std::optional<Object> object_;  // the cap among them
};

/// The level curves within one face: those of the clearance over triangles, moved to where they belong.
class FaceContours {
public:
    FaceContours(const Cell& cell, std::uint32_t face, double size)
        : bisector_(cell, cell.faces[face].site), face_(face), longest_(size / 80), tolerance_(1e-4 * size) {}

    /// Triangles have no side longer than that in the end, and those of a side agree about it.
    void add(const std::array<Vec3, 3>& corners) {
        std::array<std::uint32_t, 3> t;
        for (std::size_t k = 0; k < 3; ++k) t[k] = number(corners[k]);
        divide(t, 0);
    }

    void trace(std::size_t level, double clearance, std::vector<Contour>& found) {
        find_segments(clearance);
        chain(level, clearance, found);
    }

private:
    using Triangle = std::array<std::uint32_t, 3>;
    using Side = std::pair<std::uint32_t, std::uint32_t>;

    static Side side(std::uint32_t a, std::uint32_t b) { return {std::min(a, b), std::max(a, b)}; }

    std::uint32_t number(const Vec3& p) {
        const std::array<double, 3> key{p.x(), p.y(), p.z()};
        const auto [at, is_new] = numbers_.try_emplace(key, static_cast<std::uint32_t>(points_.size()));
        if (is_new) {
            points_.push_back(p);
            clearances_.push_back(bisector_.base(bisector_.lifted(p)).distance);
        }
        return at->second;
    }

    void divide(const Triangle& t, int depth) {
        constexpr int deepest = 12;
        const auto is_long = [&](std::uint32_t a, std::uint32_t b) {
            return (points_[a] - points_[b]).norm() > longest_;
        };
        std::array<std::optional<std::uint32_t>, 3> middle;  // of the sides from corner k on
        int count = 0;
        for (std::size_t k = 0; k < 3 && depth < deepest; ++k) {
            const std::uint32_t a = t[k], b = t[(k + 1) % 3];
            if (!is_long(a, b)) continue;
            const auto [from, to] = side(a, b);
            middle[k] = number(0.5 * (points_[from] + points_[to]));
            ++count;
        }
        if (count == 0) {
            triangles_.push_back(t);
            return;
        }
        // Corners that two halved sides meet in are cut off; what is left is a fan about the next middle.
        std::vector<std::uint32_t> rest;
        for (std::size_t k = 0; k < 3; ++k) {
            const auto before = middle[(k + 2) % 3], after = middle[k];
            if (before && after)
                divide({*before, t[k], *after}, depth + 1);
            else
                rest.push_back(t[k]);
            if (after) rest.push_back(*after);
        }
        for (std::size_t k = 0; k < rest.size(); ++k)
            if (std::ranges::find(middle, std::optional(rest[k])) != middle.end()) {
                std::ranges::rotate(rest, rest.begin() + static_cast<std::ptrdiff_t>(k));
                break;
            }
        for (std::size_t k = 1; k + 1 < rest.size(); ++k) divide({rest[0], rest[k], rest[k + 1]}, depth + 1);
    }

    void find_segments(double clearance) {
        next_.clear();
        for (const Triangle& t : triangles_) {
            std::array<std::optional<Side>, 2> ends;  // where the level comes in, and leaves
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t a = t[k], b = t[(k + 1) % 3];
                const bool is_above = clearances_[a] >= clearance;
                if (is_above != (clearances_[b] >= clearance)) ends[is_above ? 0 : 1] = side(a, b);
            }
            if (ends[0] && ends[1]) next_.emplace(*ends[0], *ends[1]);
        }
    }

    Vec3 place(const Side& s, double clearance) const {
        const double a = clearances_[s.first], b = clearances_[s.second], t = (clearance - a) / (b - a);
        return moved((1 - t) * points_[s.first] + t * points_[s.second], clearance);
    }
    /// Where Newton's method leads away from the triangles the point stays in them.
    Vec3 moved(const Vec3& p, double clearance) const {
        const auto q = bisector_.at_level(p, clearance);
        return q && (*q - p).norm() <= longest_ ? *q : p;
    }

    void chain(std::size_t level, double clearance, std::vector<Contour>& found) {
        std::map<Side, bool> is_reached;
        for (const auto& [from, to] : next_) is_reached[to] = true;
        std::vector<Side> starts;
        for (const auto& [from, to] : next_)
            if (!is_reached.contains(from)) starts.push_back(from);
        const auto follow = [&](const Side& first) {
            Contour contour{level, face_, {place(first, clearance)}};
            for (auto step = next_.extract(first); step; step = next_.extract(step.mapped())) {
                const Vec3 to =
                    step.mapped() == first ? contour.points.front() : place(step.mapped(), clearance);
                refine(clearance, to, 0, contour.points);
            }
            if (contour.points.size() > 1) found.push_back(std::move(contour));
        };
        for (const Side& start : starts) follow(start);
        while (!next_.empty()) follow(Side(next_.begin()->first));
    }

    void refine(double clearance, const Vec3& to, int depth, std::vector<Vec3>& points) const {
        constexpr int deepest = 6;
        const Vec3 from = points.back(), middle = 0.5 * (from + to);
        if (from == to) return;
        const Vec3 there = moved(middle, clearance);
        if (depth == deepest || (there - middle).norm() <= tolerance_) {
            points.push_back(to);
            return;
        }
        refine(clearance, there, depth + 1, points);
        refine(clearance, to, depth + 1, points);
    }

    const Bisector bisector_;
    const std::uint32_t face_;
    const double longest_, tolerance_;
    std::map<std::array<double, 3>, std::uint32_t> numbers_;
    std::vector<Vec3> points_;
    std::vector<double> clearances_;
    std::vector<Triangle> triangles_;
    std::map<Side, Side>
        next_;  // of sides of triangles that the level crosses, the lesser clearance on its left
};

}  // namespace

std::vector<double> round_levels(const Cell& cell, std::size_t count) {
    const double least = cell.measures.min_clearance, most = cell.measures.max_clearance,
                 range = most - least;
    std::vector<double> levels;
    if (count == 0 || !(range > 0) || !std::isfinite(range)) return levels;
    const auto between = [&](double step) {
        levels.clear();
        for (double k = std::floor(least / step) + 1; k * step < most && levels.size() <= count; ++k)
            levels.push_back(k * step);
        return levels.size() <= count;
    };
    const double power = std::pow(10, std::floor(std::log10(range / static_cast<double>(count))) - 1);
    for (double decade = power;; decade *= 10)
        for (const double digit : {1.0, 2.0, 5.0})
            if (between(digit * decade)) return levels;
}

std::vector<Contour> contours(const Cell& cell, std::span<const double> levels) {
    std::vector<Contour> found;
    if (levels.empty()) return found;
    const double size = cell_diagonal(cell);
    MeshOptions options;
    options.chord = 5e-5 * size;
    const CellMesh mesh = tessellate(cell, options);
    for (const CellMesh::Group& group : mesh.groups) {
        if (group.kind != CellMesh::Group::Kind::Face || is_entered(cell, cell.faces[group.face])) continue;
        FaceContours face(cell, group.face, size);
        for (std::size_t t = group.begin; t < group.end; ++t) {
            const auto& corners = mesh.triangles[t];
            face.add({mesh.points[corners[0]], mesh.points[corners[1]], mesh.points[corners[2]]});
        }
        for (std::size_t level = 0; level < levels.size(); ++level) face.trace(level, levels[level], found);
    }
    return found;
}

}  // namespace vcell
