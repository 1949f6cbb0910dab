#include "vertex_refinement.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <variant>
#include <vector>

#include "../core/solver/newton/newton.hpp"
#include "../primitives/bases/cylinder_base.hpp"
#include "../primitives/bisectors/vertex_system.hpp"
#include "../primitives/objects/decided_scene.hpp"

namespace vcell {

namespace {

using Eigen::Vector4d;

// The gradient of the distance from an object, less that of the clearance, in the unknowns of VertexSystem;
// or of the distance from what bounds the cell. Zero where there is none.
Vector4d with_clearance(const Vec3& g, double clearance) { return {g.x(), g.y(), g.z(), clearance}; }
Vec3 vector(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }

Vector4d gradient(const PlaneSite& s, const Vec3&) {
    return with_clearance(vector(s.normal).stableNormalized(), -1);
}
Vector4d gradient(const SphereSite& s, const Vec3& p) {
    const double side = s.radius < 0 ? -1 : 1;
    return with_clearance(side * (p - vector(s.center)).stableNormalized(), -1);
}
Vector4d gradient(const CylinderSite& s, const Vec3& p) {
    const Vec3 d = vector(s.direction).stableNormalized(), m = p - vector(s.point);
    const double side = s.radius < 0 ? -1 : 1;
    return with_clearance(side * (m - m.dot(d) * d).stableNormalized(), -1);
}
Vector4d gradient(const ConeSite& s, const Vec3& p) {
    const Vec3 d = vector(s.direction).stableNormalized(), m = p - vector(s.apex);
    const double sine = s.radius / s.slant, cosine = std::sqrt((1 - sine) * (1 + sine));
    return with_clearance(sine * d - cosine * (m - m.dot(d) * d).stableNormalized(), -1);
}
Vector4d gradient(const BoxSideSite& s, const Vec3&) { return Vector4d::Unit(s.axis); }
Vector4d gradient(const RimSite& s, const Vec3&) {
    return with_clearance(Vec3::Unit(s.side.axis), -vector(s.base.normal).stableNormalized()[s.side.axis]);
}
Vector4d gradient(const EndSite& s, const Vec3&) {
    return with_clearance(vector(s.tube.direction).stableNormalized(), 0);
}

// By how much a point's distance from an object exceeds its clearance, or how far the point is from what
// bounds the cell; X = (p, r).
Wide excess(const VertexSite& site, const std::array<Wide, 4>& X) {
    if (const auto* side = std::get_if<BoxSideSite>(&site)) return X[side->axis] - Wide(side->bound);
    const VertexSystem system{{site, BoxSideSite{0, 0}, BoxSideSite{1, 0}, BoxSideSite{2, 0}}};
    const QuadraticForms<4, Wide> f = system.forms<Wide>();
    const Wide value = QuadraticModel<Wide, 4>(f).at(X, Offsets<Wide, 4>(X)).value[0];
    const Wide scale = -f.quadratic[f.pair(3, 3)][0];
    if (scale.upper() == 0)
        return value / sqrt(square(f.linear[0][0]) + square(f.linear[1][0]) + square(f.linear[2][0]));
    // As a function of the clearance the form is value + slope e - scale e^2, and 0 where it is the distance:
    // the lesser of both roots.
    Wide slope = f.linear[3][0] - Wide(2.0) * scale * X[3];
    for (int i = 0; i < 3; ++i) slope += f.quadratic[f.pair(i, 3)][0] * X[i];
    const Wide root = sqrt(square(slope) + Wide(4.0) * scale * value);
    return Wide(-2.0) * value / (slope.upper() < 0 ? slope - root : slope + root);
}

// A site of a vertex with its equation.
struct Candidate {
    Site site;
    VertexSite equation;
};

class Refinement {
public:
    Refinement(const Cell& cell, const CellVertex& vertex)
        : scene_(cell.scene), vertex_(vertex), is_complete_(cell.is_complete) {}

    std::optional<RefinedVertex> run(int bits) const {
        const std::vector<Candidate> candidates = equations();
        const VertexSite base = equation(scene_.base);
        const auto chosen = crossing(base, candidates);
        if (!chosen) return std::nullopt;
        const auto& [a, b, c] = *chosen;
        const VertexSystem system{
            {base, candidates[a].equation, candidates[b].equation, candidates[c].equation}};
        const Contraction<Wide, 4> root =
            contract<Wide, 4>(QuadraticModel<Wide, 4>(system.forms<Wide>()), surroundings());
        if (root.empty || !root.unique) return std::nullopt;

        RefinedVertex refined{{candidates[a].site, candidates[b].site, candidates[c].site}, root.box, 0};
        double radius = 0;
        for (const Wide& side : root.box) radius = std::max(radius, approximate_width(side));
        if (!(radius <= std::ldexp(scene_.box.diagonal(), -bits)) || !may_be_within_error(root.box))
            return std::nullopt;
        std::array<Wide, 4> middle;
        for (int i = 0; i < 4; ++i) middle[i] = root.box[i].mid();
        for (std::size_t i = 0; i < candidates.size(); ++i)
            if (i != a && i != b && i != c)
                refined.tie_width = std::max(
                    refined.tie_width, Offsets<Wide, 4>::magnitude(excess(candidates[i].equation, middle)));
        // An excess changes by no more than the point moves, sqrt(3) radii, and its clearance.
        if (refined.tie_width > 0) refined.tie_width += 4 * radius;
        return refined;
    }

private:
    VertexSite equation(const Object& object) const { return vertex_site(object, vertex_.point); }

    // Of all the vertex's sites. Over a plane base a side of the box is the rim of the region where rays from
    // there enter the box, unless the cell is complete, and elsewhere what rays run into; where they leave at
    // once it is both.
    std::vector<Candidate> equations() const {
        std::vector<Candidate> all, rims;
        for (const Site& site : vertex_.sites) {
            if (site.kind == Site::Kind::Object) {
                all.push_back({site, equation(scene_.objects[scene_.place(site.index)])});
            } else if (site.kind == Site::Kind::Cap) {
                // As an object it would be rounded.
                constexpr int clearance = 3;
                all.push_back({site, BoxSideSite{clearance, *scene_.probe}});
            } else if (site.kind == Site::Kind::End) {
                all.push_back({site, end(site.index == 1)});
            } else if (site.kind == Site::Kind::BoxSide) {
                const BoxSideSite side = box_side(site.index);
                const auto* base = std::get_if<Plane>(&scene_.base);
                const double leaning =
                    base == nullptr ? 0 : (site.index % 2 == 1 ? 1 : -1) * base->normal[side.axis];
                const bool is_rim = leaning < 0 && !is_complete_;
                if (!is_rim) all.push_back({site, side});
                if (leaning != 0)
                    (is_rim ? all : rims).push_back({site, RimSite{vertex_site(*base, vertex_.point), side}});
            }
        }
        if (all.size() < 3) all.insert(all.end(), rims.begin(), rims.end());
        return all;
    }
    BoxSideSite box_side(std::uint32_t side) const {
        const int axis = static_cast<int>(side / 2);
        return {axis, (side % 2 == 1 ? scene_.box.max : scene_.box.min)[axis]};
    }

    // Where the stretch of a base tube ends first, of all sides that its circles run into.
    EndSite end(bool is_last) const {
        const auto& base = std::get<Cylinder>(scene_.base);
        CylinderSite tube = vertex_site(base, vertex_.point);
        tube.radius = end_radius(base, scene_.box);
        const Vec3 d = base.axis.stableNormalized();
        EndSite first{tube, {0, 0}, true};
        double least = std::numeric_limits<double>::infinity();
        for (std::uint32_t s = 0; s < 6; ++s) {
            const EndSite side{tube, box_side(s), s % 2 == 1};
            const double outwards = side.from_below ? 1 : -1,
                         ahead = (is_last ? outwards : -outwards) * d[side.side.axis];
            if (!(ahead > 0)) continue;
            const double across = std::hypot(d[(side.side.axis + 1) % 3], d[(side.side.axis + 2) % 3]),
                         way = (outwards * (side.side.bound - base.point[side.side.axis]) -
                                tube.radius * across) /
                               ahead;
            if (way < least) first = side, least = way;
        }
        return first;
    }

    // Three whose gradients with the base's are far from dependent: each the one that reaches farthest out of
    // the span of those before. None if no three do.
    std::optional<std::array<std::size_t, 3>> crossing(const VertexSite& base,
                                                       const std::vector<Candidate>& candidates) const {
        const auto gradient_of = [&](const VertexSite& site) {
            return std::visit([&](const auto& s) { return gradient(s, vertex_.point); }, site);
        };
        std::vector<Vector4d> rest;
        for (const Candidate& c : candidates) rest.push_back(gradient_of(c.equation));
        Vector4d direction = gradient_of(base).stableNormalized();
        std::array<std::size_t, 3> chosen;
        for (std::size_t& k : chosen) {
            for (Vector4d& g : rest) g -= g.dot(direction) * direction;
            const auto farthest =
                std::ranges::max_element(rest, {}, [](const Vector4d& g) { return g.norm(); });
            if (farthest == rest.end() || !(farthest->norm() > 0)) return std::nullopt;
            k = static_cast<std::size_t>(farthest - rest.begin());
            direction = farthest->normalized();
            farthest->setZero();
        }
        return chosen;
    }

    // The ball of the stated error with room for a root on its rim, and for the rounding of the clearance.
    std::array<Wide, 4> surroundings() const {
        const double reach = 2 * vertex_.error + 0x1p-50 * (vertex_.point.norm() + std::abs(vertex_.radius));
        std::array<Wide, 4> box;
        for (int i = 0; i < 3; ++i) box[i] = Wide::ball(Wide(vertex_.point[i]), reach);
        box[3] = Wide::ball(Wide(vertex_.radius), reach);
        return box;
    }
    bool may_be_within_error(const std::array<Wide, 4>& box) const {
        Wide square_distance(0.0);
        for (int i = 0; i < 3; ++i) square_distance += square(box[i] - Wide(vertex_.point[i]));
        return square_distance.lower() <= square(Wide(vertex_.error)).upper();
    }

    const Scene& scene_;
    const CellVertex& vertex_;
    const bool is_complete_;
};

}  // namespace

std::optional<RefinedVertex> refine(const Cell& cell, std::size_t vertex, int bits) {
    const CellVertex& v = cell.vertices[vertex];
    if (v.is_touching) return std::nullopt;
    return Refinement(cell, v).run(bits);
}

}  // namespace vcell
