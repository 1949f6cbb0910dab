#include "face_trims.hpp"

#include <algorithm>
#include <array>
#include <span>

#include "conic_trim.hpp"
#include "joined_spans.hpp"

namespace vcell::radial {

std::vector<std::vector<TrimCurve>> FaceTrims::loops(FaceId face) const {
    std::vector<std::vector<TrimCurve>> result;
    result.reserve(loops_[face].size());
    for (const CcbId ccb : loops_[face]) {
        std::vector<TrimCurve>& loop = result.emplace_back();
        loop.reserve(loops_.length(ccb));
        loops_.around(ccb,
                      [&](EdgeId e, bool reversed) { set(patches_[face], e, reversed, append_new(loop)); });
    }
    return result;
}

std::vector<std::vector<BoundaryRun>> FaceTrims::runs(FaceId face) const {
    std::vector<std::vector<BoundaryRun>> result;
    const auto patch = [&](std::uint32_t sector) -> const RadialPatch& {
        return patches_.sectors(face)[sector].patch;
    };
    for (const CcbId ccb : loops_[face]) {
        std::vector<BoundaryRun>& loop = result.emplace_back();
        loops_.around(ccb, [&](EdgeId e, bool reversed) {
            const std::size_t n = curves_.size(e);
            const auto sector = [&](std::size_t i) { return sector_of(face, e, reversed, i); };
            for (std::size_t first = 0, last; first < n; first = last) {
                const std::uint32_t in = sector(first);
                last = first + 1;
                while (last < n && sector(last) == in) ++last;
                loop.push_back({{e.value, {}, reversed, {}}, in});
                set_part(patch(in), {e, reversed, first, last}, loop.back().trim.curve);
            }
        });
    }
    return result;
}

std::uint32_t FaceTrims::sector_of(FaceId face, EdgeId e, bool reversed, std::size_t span) const {
    if (curves_.is_line(e)) {
        const Eigen::Vector4d &from = curves_.from(e), &to = curves_.to(e);
        return patches_.sector_of(face, 0.5 * (from + to).head<3>(), (from.y() < to.y()) != reversed);
    }
    const std::size_t k = reversed ? curves_.size(e) - 1 - span : span;
    if (curves_.is_spline(e)) return curves_.splines(e)[k].part[reversed];
    const ConicSpan& s = curves_.conics(e)[k];
    return patches_.sector_of(face, (s.from + 2 * s.middle + s.to).head<3>() / (2 + 2 * s.weight),
                              (s.from.y() < s.to.y()) != reversed);
}

void FaceTrims::set(const RadialPatch& patch, EdgeId e, bool reversed, TrimCurve& trim) const {
    trim.edge = e.value;
    trim.reversed = reversed;
    if (curves_.is_line(e)) return set_line(patch, e, reversed, trim.curve);
    set_part(patch, {e, reversed, 0, curves_.size(e)}, trim.curve);
}

void FaceTrims::set_part(const RadialPatch& patch, const Part& part, RationalCurve2& curve) const {
    if (curves_.is_line(part.e)) return set_line(patch, part.e, part.reversed, curve);
    if (curves_.is_spline(part.e)) return set_spline(part, curve);
    set_conic(patch, part, curve);
}

void FaceTrims::set_line(const RadialPatch& patch, EdgeId e, bool reversed, RationalCurve2& curve) const {
    begin_joined(curve, 1, 1);
    for (const Eigen::Vector4d* x : {&curves_.from(e), &curves_.to(e)}) {
        const Vec2 p = patch.parameters(Vec3(x->head<3>()));
        curve.points.push_back({p.x(), p.y(), 1});
    }
    // The line lies over one generator, whose direction a point near the axis tells badly.
    if (patch.kind() == RadialPatch::Kind::AboutBase) {
        const bool ends_farther = curves_.to(e).w() > curves_.from(e).w();
        curve.points[ends_farther ? 0 : 1].x() = curve.points[ends_farther ? 1 : 0].x();
    }
    if (reversed) std::reverse(curve.points.begin(), curve.points.end());
}

void FaceTrims::set_spline(const Part& part, RationalCurve2& curve) const {
    const std::vector<SpaceSpan>& spans = curves_.splines(part.e);
    const std::size_t n = spans.size();
    begin_joined(curve, 5, n, part.first, part.last);
    for (std::size_t i = part.first; i < part.last; ++i) {
        const auto& points = spans[part.reversed ? n - 1 - i : i].points;
        for (int k = i == part.first ? 0 : 1; k < 6; ++k) {
            const int at = part.reversed ? 5 - k : k;
            curve.points.push_back({points(4 + 2 * part.reversed, at), points(5 + 2 * part.reversed, at), 1});
        }
    }
}

// Joined spans share their end's weight.
void FaceTrims::set_conic(const RadialPatch& patch, const Part& part, RationalCurve2& curve) const {
    const std::span<const ConicSpan> spans = curves_.conics(part.e);
    const auto [e, reversed, first, last] = part;
    const bool is_axial = patch.kind() == RadialPatch::Kind::AboutBase;
    begin_joined(curve, is_axial ? 3 : 2, spans.size(), first, last);
    double scale = 1;
    // A span's first point is the last one's; only its weight is new.
    const auto add = [&](std::span<const Eigen::Vector3d> points) {
        scale = (curve.points.empty() ? 1 : curve.points.back().z()) / points.front().z();
        for (const Eigen::Vector3d& p : points.subspan(curve.points.empty() ? 0 : 1))
            curve.points.push_back({p.x() / p.z(), p.y() / p.z(), scale * p.z()});
    };
    for (const ConicSpan& piece : spans.subspan(reversed ? spans.size() - last : first, last - first)) {
        if (is_axial) {
            add(axial_trim(patch, piece));
        } else {
            const TrimSpan span(patch, piece);
            add(std::array{span.from, span.middle, span.to});
        }
    }
    // The knots are uniform: only the order changes.
    if (reversed) std::reverse(curve.points.begin(), curve.points.end());
}

}  // namespace vcell::radial
