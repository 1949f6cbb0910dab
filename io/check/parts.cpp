#include "parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "paths.hpp"

namespace vcell::check {
namespace {

constexpr std::uint32_t nobody = UINT32_MAX;

std::string part_path(std::size_t k) { return detail::with_index("parts", k); }

class Parts {
public:
    Parts(const Cell& cell, const SceneGeometry& geometry, Certificate& certificate)
        : cell_(cell), geometry_(geometry), certificate_(certificate), space_(cell.scene) {}

    std::optional<TubeParts> run() {
        if (cell_.parts.empty()) {
            certificate_.leave_open("parts", "are not told: a complete cell around a tube comes in some",
                                    HUGE_VAL);
            return std::nullopt;
        }
        const std::size_t before = certificate_.count(Verdict::refuted) + certificate_.count(Verdict::open);
        result_.parts.resize(cell_.parts.size());
        share_out();
        for (std::size_t k = 0; k < cell_.parts.size(); ++k) judge(k);
        if (certificate_.count(Verdict::refuted) + certificate_.count(Verdict::open) == before) judge_slabs();
        if (certificate_.count(Verdict::refuted) + certificate_.count(Verdict::open) != before)
            return std::nullopt;
        return std::move(result_);
    }

private:
    // --- Whose elements are whose. -----------------------------------------------------------------------

    void share_out() {
        std::size_t face = 0;
        for (std::size_t k = 0; k < cell_.parts.size(); ++k)
            for (std::uint32_t n = 0; n < cell_.parts[k].faces && face < cell_.faces.size(); ++n)
                result_.parts[k].faces.push_back(static_cast<std::uint32_t>(face++));
        std::size_t named = 0;
        for (const CellPart& part : cell_.parts) named += part.faces;
        if (named != cell_.faces.size())
            return certificate_.refute(
                "parts", fmt::format("have {} faces, the cell has {}", named, cell_.faces.size()));
        std::vector<std::uint32_t> edges(cell_.edges.size(), nobody), vertices(cell_.vertices.size(), nobody);
        const auto take = [&](std::uint32_t& owner, std::uint32_t part, const std::string& path) {
            if (owner != nobody && owner != part)
                certificate_.refute(path, fmt::format("is one of part {} and of part {}", owner, part));
            owner = part;
        };
        for (std::uint32_t k = 0; k < result_.parts.size(); ++k)
            for (const std::uint32_t f : result_.parts[k].faces)
                for (const TrimCurve& trim : cell_.faces[f].trims())
                    if (trim.edge) take(edges[*trim.edge], k, edge_path(*trim.edge));
        for (std::uint32_t e = 0; e < edges.size(); ++e) {
            if (edges[e] == nobody) edges[e] = 0;
            result_.parts[edges[e]].edges.push_back(e);
            for (const std::uint32_t v : cell_.edges[e].vertices) take(vertices[v], edges[e], vertex_path(v));
        }
        for (std::uint32_t v = 0; v < vertices.size(); ++v)
            result_.parts[vertices[v] == nobody ? 0 : vertices[v]].vertices.push_back(v);
    }

    // --- Where they are. ---------------------------------------------------------------------------------

    void judge(std::size_t k) {
        TubePart& part = result_.parts[k];
        part.number = static_cast<std::uint32_t>(k);
        part.ends = cell_.parts[k].ends;
        const std::string where = part_path(k);
        for (const Vec3& end : part.ends) {
            if (!end.allFinite()) return certificate_.refute(where + ".ends", "are not finite");
            const double away = geometry_.height(end) - geometry_.least_height();
            if (!(away <= geometry_.rounding()))
                return certificate_.refute(where + ".ends",
                                           fmt::format("are {:.3g} away from the axis", away), away);
        }
        const Interval length = along(part.ends[1]) - along(part.ends[0]);
        if (length.upper() <= 0) return certificate_.refute(where + ".ends", "are not ascending");
        if (!(length.lower() > 0))
            return certificate_.leave_open(where + ".ends", "are too near to each other", length.upper());
        // The axis is no farther from the ends as the file has them.
        const double off = std::max(from_axis(part.ends[0]), from_axis(part.ends[1])) * (1 + 0x1p-50);
        for (std::uint32_t s = 0; s < 6; ++s) {
            const double first = inside(s, part.ends[0]), last = inside(s, part.ends[1]);
            if (is_across(s)) {
                // Where they are on the axis is rounded, however near to it they are.
                if (std::min(first, last) < -(off + geometry_.rounding()))
                    certificate_.refute(where + ".ends",
                                        fmt::format("are beyond {}", title(Site::box_side(s))));
                continue;
            }
            if ((first < -off && last > off) || (first > off && last < -off))
                return certificate_.refute(where + ".ends", fmt::format("the axis crosses {} between them",
                                                                        title(Site::box_side(s))));
            if (std::min(std::abs(first), std::abs(last)) <= off)
                return certificate_.leave_open(where + ".ends",
                                               fmt::format("are too near to {}", title(Site::box_side(s))),
                                               std::min(std::abs(first), std::abs(last)));
            part.is_beyond[s] = first < 0;
        }
        certificate_.prove(where);
    }
    /// Exact but for one rounding.
    double inside(std::uint32_t side, const Vec3& p) const {
        const auto axis = static_cast<Eigen::Index>(side / 2);
        return side % 2 != 0 ? cell_.scene.box.max[axis] - p[axis] : p[axis] - cell_.scene.box.min[axis];
    }
    /// Does the axis run straight into the side? Rays never do.
    bool is_across(std::uint32_t side) const {
        const Vec3& axis = std::get<Cylinder>(cell_.scene.base).axis;
        return (axis.array() != 0).count() == 1 && axis[static_cast<Eigen::Index>(side / 2)] != 0;
    }
    double from_axis(const Vec3& p) const {
        const Vector<Interval> across =
            cross(space_.base().direction, to_vector<Interval>(p) - space_.base().point);
        return sqrt(square(across)).upper();
    }
    Interval along(const Vec3& p) const {
        return dot(space_.base().direction, to_vector<Interval>(p) - space_.base().point);
    }

    // --- What lies between them. -------------------------------------------------------------------------

    void judge_slabs() {
        const Box& box = cell_.scene.box;
        double lowest = HUGE_VAL, highest = -HUGE_VAL;
        for (unsigned corner = 0; corner < 8; ++corner) {
            Vec3 p;
            for (unsigned axis = 0; axis < 3; ++axis)
                p[axis] = ((corner & 1u << axis) != 0 ? box.max : box.min)[axis];
            const Interval y = along(p);
            lowest = std::min(lowest, y.lower());
            highest = std::max(highest, y.upper());
        }
        cut_by_vessels(lowest, highest);
        double together = 0;
        Interval volume(0.0);
        Interval from(lowest);
        for (std::size_t k = 0; k <= result_.parts.size(); ++k) {
            const Interval to =
                k < result_.parts.size() ? along(result_.parts[k].ends[0]) : Interval(highest);
            const Interval slab = to - from;
            const bool is_between = k > 0 && k < result_.parts.size();
            if (is_between && slab.upper() < 0)
                return certificate_.refute(part_path(k), "begins before the one before it ends",
                                           -slab.upper());
            if (is_between && !(slab.lower() > 0))
                return certificate_.leave_open(part_path(k), "may begin before the one before it ends",
                                               slab.upper());
            for (const auto& [low, high] : left_out(from, to)) {
                constexpr int sections = 16;  // in which less is enclosed
                double last = low;
                for (int i = 1; i <= sections; ++i) {
                    const double next = i == sections ? high : low + (high - low) / sections * i;
                    const Owned owned = owned_by_base({last, next});
                    together += owned.width * (1 + 0x1p-50);
                    volume += Interval(owned.volume);
                    last = next;
                }
            }
            if (k < result_.parts.size()) from = along(result_.parts[k].ends[1]);
        }
        // Thicker ones may hold what matters.
        constexpr double thin = 0x1p-14;
        if (!(together <= thin * box.diagonal()))
            return certificate_.leave_open(
                "parts",
                fmt::format("leave out slabs that are {:.3g} wide together, of which nothing is told",
                            together),
                together);
        result_.width = together;
        result_.left_out = volume.upper();
        result_.area = steepness() * box.diagonal() * together;
        const Vec3 size = box.max - box.min;
        const double share = result_.left_out / size.prod();
        certificate_.prove(
            "parts", together,
            fmt::format("slabs between them are left out: together {:.3g} wide, at most {:.3g} of "
                        "the box, of which nothing is told",
                        together, share));
    }

    /// What lies between these two places along the axis but for what others hold.
    std::vector<std::array<double, 2>> left_out(const Interval& from, const Interval& to) const {
        std::vector<std::array<double, 2>> held, rest;
        for (std::uint32_t i = 0; i < cell_.scene.objects.size(); ++i)
            if (may_hold(i))
                if (const auto stretch = held_by(i, from.upper(), to.lower())) held.push_back(*stretch);
        std::ranges::sort(held);
        double last = from.lower();
        for (const auto& [low, high] : held) {
            if (low > last) rest.push_back({last, low});
            last = std::max(last, high);
        }
        if (to.upper() > last) rest.push_back({last, to.upper()});
        return rest;
    }
    bool may_hold(std::uint32_t object) const {
        const Object& o = cell_.scene.objects[object];
        return cell_.scene.competes(object) &&
               (std::holds_alternative<Sphere>(o) || std::holds_alternative<Cylinder>(o)) &&
               space_.object(object).radius.lower() >= space_.base().radius.upper();
    }

    /// A bound on the volume that the base owns beside a stretch of its axis, and a slab that wide beside
    /// which faces are about as large at most.
    struct Owned {
        double volume, width;
    };
    Owned owned_by_base(const std::array<double, 2>& stretch) const {
        const Interval width = Interval(stretch[1]) - Interval(stretch[0]);
        Owned least{(width * section()).upper(), width.upper()};
        for (std::uint32_t i = 0; i < cell_.scene.objects.size(); ++i) {
            if (!may_hold(i)) continue;
            const auto owned = owned_beside(i, stretch);
            if (!owned) continue;
            least.volume = std::min(least.volume, owned->volume);
            least.width = std::min(least.width, owned->width);
        }
        return least;
    }

    /// With m the way from the object's centre or axis, deep its radius less the base's, and u across the
    /// base's axis: at the distance t from this a point is nearest to the base only where |m + t u| >= t +
    /// deep, m + t u taken across the object's axis, which implies
    ///
    ///     2 t (deep - m.u) <= |m|^2 - deep^2:
    ///
    /// an ellipse with one focus on the axis, as long as m.u < deep for all u.
    std::optional<Owned> owned_beside(std::uint32_t object, const std::array<double, 2>& stretch) const {
        const Surface<Interval> other = space_.object(object);
        const Interval deep = other.radius - space_.base().radius, y(stretch[0], stretch[1]);
        if (!(deep.lower() > 0)) return std::nullopt;
        const auto across = [](const Vector<Interval>& v, const Vector<Interval>& axis) {
            return v - dot(v, axis) * axis;
        };
        Vector<Interval> m = space_.base().point + y * space_.base().direction - other.point;
        if (other.kind == Surface<Interval>::Kind::cylinder) m = across(m, other.direction);
        const Interval eccentricity2 = square(across(m, space_.base().direction)) / square(deep),
                       rest = 1.0 - Interval(eccentricity2.upper());
        if (!(rest.lower() > 0)) return std::nullopt;
        const Interval power(std::max(0.0, (square(m) - square(deep)).upper())),
            parameter = power / (2.0 * deep), width = Interval(stretch[1]) - Interval(stretch[0]),
            most = 2.0 * parameter / rest;
        return Owned{(width * pi() * square(parameter) / (rest * sqrt(rest))).upper(),
                     (pi() * most * (width + most) / (2.0 * cell_.scene.box.diagonal())).upper()};
    }

    /// About how much area a slab may have of faces or of sides, for its width and the box's diagonal. A face
    /// that goes once around the box has half as much; planes that lie nearly across the axis, sides and
    /// those between axes that cross it, the more.
    double steepness() const {
        double faces = 8, sides = 0;
        const auto& base = std::get<Cylinder>(cell_.scene.base);
        const Vec3 d = base.axis.stableNormalized();
        for (std::uint32_t s = 0; s < 6; ++s)
            if (!is_across(s)) sides += 2 / d.cross(Vec3::Unit(s / 2)).norm();
        for (const Object& object : cell_.scene.objects) {
            const auto* tube = std::get_if<Cylinder>(&object);
            if (!tube || !cross_equally(base, *tube)) continue;
            const Vec3 e = tube->axis.stableNormalized();
            faces = std::max(faces, 16 / std::min((e - d).norm(), (e + d).norm()));
        }
        return std::max(faces, sides);
    }

    static Interval pi() { return {std::numbers::pi, std::nextafter(std::numbers::pi, 4)}; }

    /// What of this stretch of the axis is as deep in a ball or tube as the base is wide: points beside it
    /// are no nearer to the base. Distances along a line are convex: between two such places all are.
    std::optional<std::array<double, 2>> held_by(std::uint32_t object, double from, double to) const {
        const Surface<Interval> other = space_.object(object);
        const auto depth = [&](double y) {
            const Vector<Interval> p = space_.base().point + Interval(y) * space_.base().direction;
            return other.distance(p) + space_.base().radius;
        };
        const auto is_held = [&](double y) { return depth(y).upper() < 0; };
        constexpr int thirds = 100;
        double low = from, high = to;
        for (int k = 0; k < thirds && !is_held(0.5 * (low + high)); ++k) {
            const double a = low + (high - low) / 3, b = high - (high - low) / 3;
            if (depth(a).mid() < depth(b).mid())
                high = b;
            else
                low = a;
        }
        const double inside = 0.5 * (low + high);
        if (!(from < to) || !is_held(inside)) return std::nullopt;
        std::array<double, 2> stretch{from, to};
        for (double& end : stretch) {
            if (is_held(end)) continue;
            double in = inside, out = end;
            for (double middle = 0.5 * (in + out); middle != in && middle != out; middle = 0.5 * (in + out))
                (is_held(middle) ? in : out) = middle;
            end = in;
        }
        return stretch;
    }

    /// Beyond where the axis is as far from a vessel's wall as the base is wide, on the other side, nothing
    /// is nearest to the base. Its distance from the wall is concave: once it is less it is ever less.
    void cut_by_vessels(double& lowest, double& highest) const {
        const Scene& scene = cell_.scene;
        for (std::uint32_t i = 0; i < scene.objects.size(); ++i) {
            if (!is_vessel(scene.objects[i]) || !scene.competes(i)) continue;
            const Surface<Interval> vessel = space_.object(i);
            const auto is_out = [&](double y) {
                const Vector<Interval> p = space_.base().point + Interval(y) * space_.base().direction;
                return (vessel.distance(p) + space_.base().radius).upper() < 0;
            };
            const auto cut = [&](const Vec3& end, double& last) {
                double in = along(end).mid(), out = last;
                const Vector<Interval> p = to_vector<Interval>(end);
                if (!((vessel.distance(p) + space_.base().radius).lower() > 0) || !is_out(out)) return;
                for (double middle = 0.5 * (in + out); middle != in && middle != out;
                     middle = 0.5 * (in + out))
                    (is_out(middle) ? out : in) = middle;
                last = out;
            };
            cut(cell_.parts.front().ends[0], lowest);
            cut(cell_.parts.back().ends[1], highest);
        }
    }

    /// A bound on the area of the box's sections across the axis: of what has the box's diagonal for its
    /// diameter, and of what casts no more than a side of the box as its shadow along each axis.
    Interval section() const {
        const Vector<Interval> size =
            to_vector<Interval>(cell_.scene.box.max) - to_vector<Interval>(cell_.scene.box.min);
        const auto& [x, y, z] = size;
        double least = (pi() * 0.25 * (square(x) + square(y) + square(z))).upper() * (1 + 0x1p-50);
        const std::array<Interval, 3> shadows{y * z, z * x, x * y};
        for (std::size_t k = 0; k < 3; ++k) {
            const Interval lean = magnitude(space_.base().direction[k]);
            if (lean.lower() > 0) least = std::min(least, (shadows[k] / lean).upper() * (1 + 0x1p-50));
        }
        return Interval(least);
    }

    const Cell& cell_;
    const SceneGeometry& geometry_;
    Certificate& certificate_;
    const Space<Interval> space_;
    TubeParts result_;
};

}  // namespace

std::optional<TubeParts> certify_parts(const Cell& cell, const SceneGeometry& geometry,
                                       Certificate& certificate) {
    return Parts(cell, geometry, certificate).run();
}

}  // namespace vcell::check
