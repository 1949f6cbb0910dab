#include "piece_vertices.hpp"

#include <algorithm>
#include <cmath>

namespace vcell {

std::array<FormId, 3> PieceVertices::told_apart(const std::array<FormId, 3>& forms) const {
    const auto [a, b, c] =
        work_.told_apart(*work_.find(forms[0]), *work_.find(forms[1]), *work_.find(forms[2]));
    return {a->form, b->form, c->form};
}

bool PieceVertices::locate(const std::array<FormId, 3>& three, MixedPiece::Vertex& v) {
    const std::array<FormId, 3> forms = told_apart(three);
    v = {work_.middle(), 0, forms[0], {}};
    const auto root = root_near(model_of<Interval>([&](const IntervalBox<2>& p) {
                                    return work_.supports ? equal_heights(*work_.supports, forms, p)
                                                          : equal_heights(heights_, forms, p);
                                }),
                                work_.middle());
    if (root) {
        v.point = root->point;
        v.error = root->error;
    }
    const auto& box = work_.piece.box;
    const auto is_inside = [&] {
        return v.point.x() + v.error >= box[0] && v.point.x() - v.error <= box[1] &&
               v.point.y() + v.error >= box[2] && v.point.y() - v.error <= box[3];
    };
    // Where the three all but touch, doubles tell them badly apart. Along tubes that are all but parallel
    // pieces are narrow across only.
    constexpr double well_told = 0x1p-40;
    const MixedPiece::Vertex rough = v;
    const bool is_found = root && is_inside(),
               is_narrow = std::min(box[1] - box[0], box[3] - box[2]) <= node_width * work_.extent;
    const bool is_sharp = (is_found ? v.error > well_told * work_.extent ||
                                          !all_.is_well_known(v.point, v.error, forms, work_.extent)
                                    : is_narrow) &&
                          points_.settle_sharply(v, forms) && is_inside();
    if (!is_sharp) v = rough;
    if (is_sharp || is_found) ++(is_sharp ? decisions_.by_multiprecision : decisions_.by_interval);
    return is_sharp || is_found;
}

// Contracts a box a little larger than the piece, or the part of it where all three meet, to the root, if
// there is one.
Inside PieceVertices::find(const std::array<FormId, 3>& three, MixedPiece::Vertex& out) {
    if (work_.known_apart(three)) return Inside::No;
    const std::array<FormId, 3> forms = told_apart(three);
    std::array<double, 4> box = work_.piece.box;
    const bool by_supports = work_.supports && work_.rivals.size() <= most_divided;
    if (by_supports) {
        const auto place = [&](FormId f) { return work_.place(*work_.find(f)); };
        const auto part = work_.divided().meeting(place(forms[0]), place(forms[1]), place(forms[2]));
        if (!part) return Inside::No;
        box = *part;
    }
    const Spread &a = *work_.find(forms[0]), &b = *work_.find(forms[1]), &c = *work_.find(forms[2]);
    if (!by_supports && a.bend && b.bend && c.bend) {
        const auto offsets = common_zeros(work_.difference(b, a), work_.difference(c, a));
        if (!offsets) return Inside::No;
        for (const int i : {0, 1}) {
            const Interval part = Interval(work_.middle()[i]) + (*offsets)[i];
            box[2 * i] = std::max(box[2 * i], part.lower());
            box[2 * i + 1] = std::min(box[2 * i + 1], part.upper());
        }
    }
    const auto system = model_of<Interval>([&](const IntervalBox<2>& p) {
        return by_supports ? equal_heights(*work_.supports, forms, p) : equal_heights(heights_, forms, p);
    });
    const double dx = 0.25 * (box[1] - box[0]), dy = 0.25 * (box[3] - box[2]);
    const auto found = contract<Interval, 2>(
        system, {Interval(box[0] - dx, box[1] + dx), Interval(box[2] - dy, box[3] + dy)});
    if (found.empty) return Inside::No;
    IntervalBox<2> root = found.box;
    // Exactly one: so it is what is proved more closely in a part of the box.
    if (found.unique)
        if (const auto closer = prove_near<Interval, 2>(
                system, {Interval(root[0].mid()), Interval(root[1].mid())}, everywhere);
            closer && is_subset(*closer, root))
            root = *closer;
    const auto [X, Y] = root;
    const Inside inside = work_.where(X, Y);
    if (inside == Inside::No) return inside;
    if (inside == Inside::Unknown || !found.unique) return Inside::Unknown;
    const MixedPiece::Vertex rough{{X.mid(), Y.mid()}, reach(X, Y), forms[0], {}};
    out = rough;
    const bool is_sharp =
        !all_.is_well_known(rough.point, rough.error, forms, work_.extent) &&
        points_.settle_sharply(out, forms) &&
        is_subset<Interval, 2>(
            {Interval::ball(out.point.x(), out.error), Interval::ball(out.point.y(), out.error)}, root);
    if (!is_sharp) out = rough;
    ++(is_sharp ? decisions_.by_multiprecision : decisions_.by_interval);
    return Inside::Yes;
}

}  // namespace vcell
