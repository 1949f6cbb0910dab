#include "faces.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "bisector_names.hpp"
#include "judged_patch.hpp"
#include "trim_curves.hpp"

namespace vcell::check {
namespace {

class Faces : public Room {
public:
    Faces(const Subject& subject, std::span<const EdgeBound> edges, const CheckOptions& options,
          Certificate& certificate)
        : Room(subject, options, certificate), edge_bounds_(edges) {}

    void run() {
        for (const std::uint32_t f : subject_.faces) check_name(f);
        for (const Patch& patch : patches_) judge(patch);
    }

private:
    void check_name(std::size_t f) {
        const CellFace& face = cell_.faces[f];
        const auto names = bisector_names(scene_, face.site, geometry_.scale());
        if (std::ranges::find(names, face.bisector) == names.end())
            note(face_path(f) + ".bisector", fmt::format("is \"{}\", of the base and {} it is \"{}\"",
                                                         face.bisector, title(face.site), names[0]));
    }

    void judge(const Patch& patch) {
        const CellFace& face = cell_.faces[patch.face];
        const Vec3 center = lift(patch, 0.5 * (patch.lo + patch.hi)).p;
        JudgedPatch judged{patch,
                           patch_path(patch.face, patch.index),
                           {space().condition_at(face.site, center)},
                           {net_over(*patch.surface, patch.lo, patch.hi, center), patch.lo, patch.hi, {}},
                           {},
                           {},
                           std::max(tie_width(face.site), kRounding * patch.control_size)};
        for (const Site& s : face.extra_sites) judged.own.push_back(space().condition_at(s, center));
        for (const auto& loop : patch.loops)
            for (const Trim& trim : loop) {
                if (trim.curve->edge) judged.stated = std::max(judged.stated, full_error(*trim.curve->edge));
                if (trim.curve->is_tip() && face.site.is_object())
                    judged.tips = tips_of(space(), scene_.objects[face.site.index]);
            }
        // Nothing is stated of a patch without an edge: what rounding leaves of it is told by what is proved.
        constexpr double of_rounding = 16;
        if (judged.stated == 0) judged.stated = of_rounding * judged.width;
        // What is more is refuted at the edge. Towards a tip rounding is divided by less and less.
        judged.stated = std::min(judged.stated, most_stated(0));
        if (!judged.tips.empty()) judged.stated = std::max(judged.stated, scene_tolerance());
        judged.spheres = TouchingSpheres::on(judged.whole.net, face.site, space());
        if (judged.spheres) judged.spheres->refer_to(face.site);

        const auto boundary = check_boundary(patch, judged.whole.net);
        const auto distance = certify_on_bisector(judged, boundary, subject_, options_, certificate_);
        if (!distance) return;
        if (!certify_no_rivals(judged, std::max(judged.width, *distance), subject_, options_, certificate_) ||
            !boundary)
            return;
        prove(std::move(judged.where), std::max(*distance, *boundary));
    }

    /// How far points between the trimming curves and the true arcs are from the true boundary; none where a
    /// curve or its edge is not proved. The excess of the site across the edge may be negative there, but no
    /// more than on the trimming curve, and it grows towards the base.
    std::optional<double> check_boundary(const Patch& patch, const Net& net) {
        double most = 0, widest = 0;
        bool proved = true;
        for (std::size_t l = 0; l < patch.loops.size(); ++l)
            for (std::size_t t = 0; t < patch.loops[l].size(); ++t) {
                const Trim& trim = patch.loops[l][t];
                if (!trim.curve->edge) continue;
                const TrimPlace place{l, t};
                const EdgeBound& edge = edge_bounds_[*trim.curve->edge];
                const double gap = certify_trim(patch, net, place, subject_, options_, certificate_,
                                                std::max(widest, 0.25 * edge.excess));
                widest = std::max(widest, gap);
                proved = proved && gap < HUGE_VAL && edge.growth > 0;
                most = std::max({most, gap, (edge.excess + 2 * gap) / edge.growth});
            }
        // Both are in the box.
        return proved ? std::optional(std::min(most, scene_.box.diagonal())) : std::nullopt;
    }

    std::span<const EdgeBound> edge_bounds_;
};

}  // namespace

void certify_faces(const Subject& subject, std::span<const EdgeBound> edges, const CheckOptions& options,
                   Certificate& certificate) {
    Faces(subject, edges, options, certificate).run();
}

}  // namespace vcell::check
