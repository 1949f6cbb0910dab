#include "piece_culling.hpp"

#include <algorithm>
#include <cmath>

namespace vcell {

void PieceCulling::by_curvature() {
    const std::size_t before = work_.rivals.size();
    rule_.drop_hidden(
        work_.rivals, [](const Spread& s) { return s.form; },
        [&](const Spread& a, const Spread& b) {
            // What is not positive in the middle is not so all over it.
            if (!(a.bend->middle.v.lower() > b.bend->middle.v.upper()) && !heights_.are_twins(a.form, b.form))
                return false;
            const HeightDifference d = work_.difference(a, b);
            return d.value(d.dx, d.dy).lower() > 0;
        });
    decisions_.by_interval += before - work_.rivals.size();
    if (work_.rivals.size() < before) work_.is_divided = false;
}

// Is g - f certainly positive all over the piece? Asked where its gradient may vanish: about that place it
// changes least.
bool PieceCulling::stays_above(const Spread& g, const Spread& f) const {
    const HeightDifference d = work_.difference(g, f);
    const auto& box = work_.piece.box;
    const auto [offset, value] = d.stationary();
    if (!(value > 0) || !offset.allFinite()) return false;
    const Vector2d m = work_.middle();
    const double x = std::clamp(m.x() + offset.x(), box[0], box[1]),
                 y = std::clamp(m.y() + offset.y(), box[2], box[3]);
    const HeightJet<Interval> at = heights_.difference(g.form, f.form, Interval(x), Interval(y));
    const Interval dx = Interval(box[0], box[1]) - Interval(x), dy = Interval(box[2], box[3]) - Interval(y);
    Interval range = at.v + at.gx * dx + at.gy * dy;
    // A convex function lies above its tangent planes.
    if (!d.is_convex())
        range = range + 0.5 * (d.curvature.xx * square(dx) + 2.0 * (d.curvature.xy * dx * dy) +
                               d.curvature.yy * square(dy));
    return range.lower() > 0;
}

// Let g be lowest nowhere on the rim. Inside it is lowest nowhere, too,
//
//   * if its differences to all forms that are lowest on the rim grow in one direction all over the piece:
//   their
//     maximum is how far g lies above the lowest of these; it grows in that direction from where the line
//     meets the rim, and it is not negative there;
//   * if one form f is lowest all along the rim, and g - f is concave along some direction: on each line of
//   that
//     it is not negative at the ends, so positive between them;
//   * if it lies above one of them all over the piece;
//   * if g ties in no point with two others, and all differences grow in some direction or are concave along
//     one. For around a component of where g is lowest alone there would be one other form f, equal to g
//     there; of what that curve encloses g - f would be least inside, and negative.
//
// What ties with others in a vertex of the rim is left for the faces around that.
void PieceCulling::from_rim() {
    const auto ties_on_rim = [&](FormId f) {
        return std::ranges::any_of(work_.knots, [&](std::uint32_t v) {
            const std::vector<FormId>& ties = work_.piece.vertices[v].ties;
            return std::ranges::find(ties, f) != ties.end();
        });
    };
    // Beside a floor what is lowest need not show.
    if (!rule_.spares(work_.forms())) return;
    const std::size_t before = work_.rivals.size();
    SmallVector<FormId, usual_rivals> rim;
    for (const Spread& s : work_.rivals)
        if (work_.is_on_rim(s.form)) rim.push_back(s.form);
    if (rim.size() == before || rim.size() == 0) return;
    const auto is_above = [&](const Spread& g) {
        SmallVector<PieceWork::Gradient, usual_rivals> gradients;
        for (const FormId f : rim) gradients.push_back(work_.gradient(g, *work_.find(f)));
        if (PieceWork::grow_together({gradients.begin(), gradients.size()})) return true;
        if (!g.bend) return false;
        if (rim.size() == 1 && !work_.supports && work_.direction(g, *work_.find(rim[0]))) return true;
        const auto is_concave = [&](const Spread& s) {
            return work_.difference(g, s).is_concave_somewhere();
        };
        if (rim.size() == 1 && is_concave(*work_.find(rim[0]))) return true;
        if (std::ranges::any_of(rim, [&](FormId f) { return stays_above(g, *work_.find(f)); })) return true;
        if (rim.size() == 1 || work_.supports || work_.rivals.size() > most_divided) return false;
        const std::vector<Spread>& r = work_.rivals;
        for (const Spread& s : r)
            if (&s != &g && !work_.direction(g, s) && !is_concave(s)) return false;
        for (std::size_t i = 0; i < r.size(); ++i)
            for (std::size_t j = i + 1; j < r.size(); ++j)
                if (&r[i] != &g && &r[j] != &g && work_.turn(g, r[i], r[j]) != Sign::Zero) return false;
        return true;
    };
    for (std::size_t i = 0; i < work_.rivals.size();)
        if (const Spread& g = work_.rivals[i];
            !work_.is_on_rim(g.form) && !ties_on_rim(g.form) && is_above(g))
            work_.rivals.erase(work_.rivals.begin() + static_cast<std::ptrdiff_t>(i));
        else
            ++i;
    decisions_.by_interval += before - work_.rivals.size();
    if (work_.rivals.size() < before) work_.is_divided = false;
}

void PieceCulling::sharply() {
    struct Item {
        const Spread* spread;
        Wide v;
    };
    const auto& box = work_.piece.box;
    const Vector2d m = work_.middle();
    const Interval rx(Interval::up(std::max(box[1] - m.x(), m.x() - box[0]))),
        ry(Interval::up(std::max(box[3] - m.y(), m.y() - box[2])));
    std::vector<Item> items;
    for (const Spread& s : work_.rivals)
        items.push_back({&s, heights_.value(s.form, Wide(m.x()), Wide(m.y()))});
    const auto certainly_above = [&](const Item& a, const Item& b) {
        const auto [gx, gy] = work_.gradient(*a.spread, *b.spread);
        return ((a.v - b.v).enclosure() - gx.magnitude() * rx - gy.magnitude() * ry).lower() > 0;
    };
    rule_.drop_hidden(
        items, [](const Item& i) { return i.spread->form; }, certainly_above);
    decisions_.by_multiprecision += work_.rivals.size() - items.size();
    std::vector<Spread> kept;
    for (const Item& i : items) kept.push_back(*i.spread);
    work_.rivals = std::move(kept);
}

}  // namespace vcell
