#include "pieces.hpp"

namespace vcell {

// Over a cylinder y is measured by its distance from a tip: as that shrinks, so does what there is along
// the axis.
struct PieceCutter::AxialLengths {
    const AxialTips& tips;
    double scale;  // of y about the middle of the region

    double at(double y) const {
        double length = tips.any() ? 0 : y;
        if (const auto& tip = tips[AxialEnd::Low]) length += scale * std::log(y - *tip);
        if (const auto& tip = tips[AxialEnd::High]) length -= scale * std::log(*tip - y);
        return length;
    }
    double inverse(double length) const {
        if (!tips.any()) return length;
        const auto &low = tips[AxialEnd::Low], &high = tips[AxialEnd::High];
        const double ratio = std::exp(length / scale);
        if (!high) return *low + ratio;
        if (!low) return *high - 1 / ratio;
        return *high - (*high - *low) / (1 + ratio);
    }
};

std::optional<PieceCut> PieceCutter::cut_at(const RegionPiece& piece, double shift,
                                            std::optional<bool> upright) const {
    const Rectangle& r = piece.rect;
    PieceCut cut;
    cut.beyond.reserve(piece.corners.size());
    double lo = 0, hi = 0;
    const auto choose = [&](const auto& along_x, const auto& along_y) {
        cut.upright =
            upright.value_or(along_x.at(r.x1) - along_x.at(r.x0) >= along_y.at(r.y1) - along_y.at(r.y0));
        lo = cut.upright ? r.x0 : r.y0;
        hi = cut.upright ? r.x1 : r.y1;
        const auto divide = [&](const auto& along) {
            const double start = along.at(lo);
            return along.inverse(start + (split_ratio + shift) * (along.at(hi) - start));
        };
        cut.at = cut.upright ? divide(along_x) : divide(along_y);
    };
    if (tips_.any())
        choose(ChartLength{}, AxialLengths{tips_, tips_.reach / (tips_.y[0] && tips_.y[1] ? 4 : 2)});
    else
        choose(chart_.lengths(r.y0, r.y1), chart_.lengths(r.x0, r.x1));
    bool clear = cut.at > lo && cut.at < hi;
    for (const IntervalPoint& corner : piece.corners) {
        const Interval& c = corner[cut.upright ? 0 : 1];
        clear = clear && !c.contains(cut.at);
        cut.beyond.push_back(c.lower() > cut.at);
    }
    return clear ? std::optional(std::move(cut)) : std::nullopt;
}

std::pair<RegionPiece, RegionPiece> PieceCutter::halves(const RegionPiece& piece, const PieceCut& cut,
                                                        std::uint32_t seam) {
    const std::size_t n = piece.sides.size();
    PieceSide side = cut.side(), opposite = cut.opposite();
    side.id = opposite.id = seam;
    Sides first, second;
    for (std::size_t i = 0; i < n; ++i) {
        const bool from = cut.beyond[i], to = cut.beyond[(i + 1) % n];
        if (!from || !to) first.push_back(piece.sides[i]);
        if (from || to) second.push_back(piece.sides[i]);
        if (!from && to) first.push_back(opposite);
        if (from && !to) second.push_back(side);
    }
    return {make_piece(std::move(first)), make_piece(std::move(second))};
}

std::optional<PieceCutter::LabelledHalves> PieceCutter::labelled_halves(const LabelledPiece& part,
                                                                        const PieceCut& cut) {
    const RegionPiece& piece = part.piece;
    const std::size_t n = piece.sides.size();
    LabelledHalves halves;
    for (LabelledPiece* half : {&halves.first, &halves.second}) {
        half->piece.sides.reserve(n + 1);
        half->labels.reserve(n + 1);
        half->corner_ties.reserve(n + 1);
    }
    const auto push = [](LabelledPiece& to, const PieceSide& side, SideLabels labels,
                         std::vector<FormId> ties) {
        to.piece.sides.push_back(side);
        to.labels.push_back(std::move(labels));
        to.corner_ties.push_back(std::move(ties));
    };
    for (std::size_t i = 0; i < n; ++i) {
        const bool from = cut.beyond[i], to = cut.beyond[(i + 1) % n];
        const SideLabels& labels = part.labels[i];
        if (from == to) {
            push(from ? halves.second : halves.first, piece.sides[i], labels, part.corner_ties[i]);
            continue;
        }
        SideLabels before{labels.first, {}}, after;
        for (const RimTransition& t : labels.transitions) {
            const double s = t.point[cut.upright ? 0 : 1];
            if (!(std::abs(s - cut.at) > t.error)) return std::nullopt;
            ((s > cut.at) == from ? before : after).transitions.push_back(t);
        }
        after.first = before.last();
        LabelledPiece &start = from ? halves.second : halves.first,
                      &end = from ? halves.first : halves.second;
        push(start, piece.sides[i], before, part.corner_ties[i]);
        (from ? halves.seam_in_second : halves.seam_in_first) = start.labels.size();
        (from ? halves.at_returning : halves.at_leaving) = before.last();
        push(start, from ? cut.side() : cut.opposite(), {}, {});
        push(end, piece.sides[i], after, {});
    }
    halves.first.piece = make_piece(std::move(halves.first.piece.sides));
    halves.second.piece = make_piece(std::move(halves.second.piece.sides));
    return halves;
}

}  // namespace vcell
