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
        Interval wide(0.0);
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
            wide += Interval(std::max(0.0, slab.upper()));
            if (k < result_.parts.size()) from = along(result_.parts[k].ends[1]);
        }
        const double together = wide.upper();
        // Thicker ones may hold what matters.
        constexpr double thin = 0x1p-14;
        if (!(together <= thin * box.diagonal()))
            return certificate_.leave_open(
                "parts",
                fmt::format("leave out slabs that are {:.3g} wide together, of which nothing is told",
                            together),
                together);
        result_.width = together;
        result_.left_out = (wide * section()).upper();
        const Vec3 size = box.max - box.min;
        const double share = result_.left_out / size.prod();
        certificate_.prove(
            "parts", together,
            fmt::format("slabs between them are left out: together {:.3g} wide, at most {:.3g} of "
                        "the box, of which nothing is told",
                        together, share));
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
        const Interval pi(std::numbers::pi, std::nextafter(std::numbers::pi, 4));
        double least = (pi * 0.25 * (square(x) + square(y) + square(z))).upper() * (1 + 0x1p-50);
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
