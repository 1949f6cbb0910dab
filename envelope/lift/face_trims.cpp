#include "face_trims.hpp"

#include "conic_trim.hpp"
#include "joined_spans.hpp"

namespace vcell::radial {

std::vector<std::vector<TrimCurve>> FaceTrims::loops(FaceId face) const {
    return loops_.trims(face, [&](EdgeId e, bool reversed, RationalCurve2& curve) {
        set(patches_[face], e, reversed, curve);
    });
}

std::vector<std::vector<BoundaryRun>> FaceTrims::runs(FaceId face) const {
    std::vector<std::vector<BoundaryRun>> result;
    for (const CcbId ccb : loops_[face]) {
        std::vector<BoundaryRun>& loop = result.emplace_back();
        loops_.around(ccb, [&](EdgeId e, bool reversed) {
            const std::size_t n = curves_.size(e);
            const auto part = [&](std::size_t i) { return part_of(face, e, reversed, i); };
            for (std::size_t first = 0, last; first < n; first = last) {
                const std::uint32_t in = part(first);
                last = first + 1;
                while (last < n && part(last) == in) ++last;
                loop.push_back({{e.value, {}, reversed, {}}, in});
                set_trim(curves_, patches_.part(face, in), {e, reversed, first, last},
                         loop.back().trim.curve);
            }
        });
    }
    return result;
}

// v is one and the same all along. The face lies above it with u to the right, or below it with u to the
// left: between a vessel's tips, and beyond those of a tube that pierces the base. All sectors next to the
// tip come together there.
std::vector<std::vector<BoundaryRun>> FaceTrims::all_runs(FaceId face) const {
    std::vector<std::vector<BoundaryRun>> result = runs(face);
    const auto sectors = patches_.sectors(face);
    const auto places = static_cast<std::uint32_t>(patches_.places(face).size());
    for (const BisectorTip& tip : patches_.tips(face)) {
        const bool is_below = tip.is_far == patches_.is_in_vessel(face);
        std::vector<BoundaryRun>& loop = result.emplace_back();
        for (std::uint32_t i = 0; i < places; ++i) {
            std::uint32_t at = is_below ? places - 1 - i : i;
            if (!sectors[at].holds(tip.point())) at = sectors[at].other;
            const double v = sectors[at].patch.parameters(tip.point()).y(),
                         u = is_below ? -sectors[at].reach() : sectors[at].reach();
            BoundaryRun& run = loop.emplace_back(BoundaryRun{{}, at});
            begin_joined(run.trim.curve, 1, 1);
            run.trim.curve.points = {{-u, v, 1}, {u, v, 1}};
        }
    }
    return result;
}

std::uint32_t FaceTrims::part_of(FaceId face, EdgeId e, bool reversed, std::size_t span) const {
    if (curves_.is_line(e)) {
        const Eigen::Vector4d &from = curves_.from(e), &to = curves_.to(e);
        return patches_.part_of(face, 0.5 * (from + to).head<3>(), (from.y() < to.y()) != reversed);
    }
    const std::size_t k = reversed ? curves_.size(e) - 1 - span : span;
    if (curves_.is_spline(e)) return curves_.splines(e)[k].part[reversed];
    const ConicSpan& s = curves_.conics(e)[k];
    return patches_.part_of(face, s.half_way(), (s.from.y() < s.to.y()) != reversed);
}

void FaceTrims::set(const RadialPatch& patch, EdgeId e, bool reversed, RationalCurve2& curve) const {
    set_trim(curves_, patch, {e, reversed, 0, curves_.size(e)}, curve);
}

}  // namespace vcell::radial
