#include "touch_join.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "given_tie.hpp"
#include "plain_join.hpp"
#include "tie_join.hpp"

namespace vcell {

// This leaves out the forms that are lowest nowhere in the piece but for touching the trisector of two others
// in a vertex, or in a lens on it.
bool TouchJoin::join() {
    struct Touch {
        MixedPiece::Vertex vertex;
        FormId f, g;
        bool decided;
        std::array<Wide, 2> at;
    };
    struct Lens {
        std::array<MixedPiece::Vertex, 2> ends;
        FormId h, f, g;
        Vector2d across;
        Interval x, y;  // around its face
    };
    std::vector<Lens> lenses;
    work_.clear_inside();
    if (work_.rivals.size() < 3 || !work_.knots.empty() || !rule_.spares(work_.forms())) return false;
    std::vector<Touch> touches;
    // An arc that is touched inside meets the rim, or it does in a smaller piece: of all pairs those are
    // enough that change there.
    std::vector<std::array<FormId, 2>> pairs;
    for (const RimChange& c : work_.changes) {
        const std::array pair{std::min(c.before, c.after), std::max(c.before, c.after)};
        if (std::ranges::find(pairs, pair) == pairs.end()) pairs.push_back(pair);
    }
    const auto stays_above = [&](FormId h) {
        for (const auto& [f, g] : pairs) {
            const auto touching = find_touching(heights_, h, f, g, work_.piece.box);
            if (!touching) continue;
            const int exponent = touching->gap.magnitude_exponent() - touching->height.magnitude_exponent();
            const bool is_tie = exponent < assumed_exponent,
                       is_above = touching->gap.sign() == Sign::Positive;
            const bool is_narrow =
                exponent < narrow_exponent && touching->width <= std::ldexp(extent_, narrow_exponent / 2);
            if (touching->lens) {
                const auto& [ends, thickness] = *touching->lens;
                const Vector2d& across = touching->across;
                Lens lens{{}, h, f, g, across, {}, {}};
                const auto settle = [&](int k) {
                    MixedPiece::Vertex& v = lens.ends[k];
                    v = {ends[k], 0, f, {}};
                    return points_.settle_sharply(v, {f, g, h});
                };
                const double reach = Interval::up(touching->width + thickness);
                lens.x = Interval::ball(touching->place.x(), reach);
                lens.y = Interval::ball(touching->place.y(), reach);
                const Vector2d along(-across.y(), across.x());
                const auto is_beyond = [&](const Vector2d& p, const Vector2d& q, double error) {
                    return along.dot(q - p) >
                           64 * (error + std::numeric_limits<double>::epsilon() * p.norm());
                };
                // Doubles hold no face that is thinner than their spacing.
                const bool is_thin =
                    thickness < std::numeric_limits<double>::epsilon() * touching->place.norm();
                if (!is_thin && settle(0) && settle(1) &&
                    is_beyond(lens.ends[0].point, touching->place, lens.ends[0].error) &&
                    is_beyond(touching->place, lens.ends[1].point, lens.ends[1].error) &&
                    work_.where(lens.x, lens.y) == Inside::Yes) {
                    ++decisions_.by_multiprecision;
                    lenses.push_back(std::move(lens));
                    return true;
                }
            }
            if (!is_above && !is_narrow) return false;
            ++decisions_.by_multiprecision;
            if (!is_tie && is_above) return true;
            const std::array forms{f, g, h};
            const auto exact =
                is_tie ? points_.exact_touch(forms, forms, touching->at, work_.piece.box) : std::nullopt;
            Touch t{{touching->place,
                     std::max(touching->width, std::ldexp(extent_, assumed_exponent / 2)),
                     f,
                     {f, g, h}},
                    f,
                    g,
                    exact.has_value(),
                    touching->at};
            if (exact) {
                const auto& [x, y] = *exact;
                t.vertex.point = {x.mid(), y.mid()};
                t.vertex.error = reach(x, y);
            } else {
                t.decided =
                    GivenTie(all_, work_, {t.vertex.point, t.vertex.error, t.vertex.ties, {}, {forms}})
                        .is_exact();
            }
            touches.push_back(std::move(t));
            return true;
        }
        return false;
    };
    const std::size_t before = work_.rivals.size();
    for (std::size_t i = 0; i < work_.rivals.size() && work_.rivals.size() > 2;)
        if (const FormId h = work_.rivals[i].form; !work_.is_on_rim(h) && stays_above(h))
            work_.rivals.erase(work_.rivals.begin() + static_cast<std::ptrdiff_t>(i));
        else
            ++i;
    if (work_.rivals.size() == before) return false;
    work_.directions.clear();
    work_.is_divided = false;
    PlainJoin plain(all_, work_);
    if (!(plain.is_plain() && plain.join()) && !TieJoin(all_, work_).join()) return false;
    for (const Touch& t : touches) {
        const Vector2d& p = t.vertex.point;
        const double r = t.vertex.error;
        const Inside inside = work_.where(p, r);
        if (inside == Inside::No) continue;
        if (inside == Inside::Unknown) return false;
        if (const auto v = work_.inner_vertex_near(p, r)) {
            if (!touch_in_vertex(*v, t.vertex.ties, t.at)) return false;
            continue;
        }
        // Nor where another form is lower.
        const Interval x = Interval::ball(p.x(), r), y = Interval::ball(p.y(), r);
        bool is_hidden = false;
        for (const Spread& other : work_.rivals) {
            if (other.form == t.f || other.form == t.g) continue;
            const auto sign = heights_.value_difference(other.form, t.f, x, y).sign();
            if (!sign) return false;
            is_hidden = is_hidden || *sign == Sign::Negative;
        }
        if (is_hidden) continue;
        if (!work_.divide(t.f, t.g, t.vertex)) return false;
        if (!t.decided) all_.assume(p, r, t.vertex.ties);
    }
    for (const Lens& l : lenses) {
        bool is_hidden = false;
        for (const Spread& other : work_.rivals) {
            if (other.form == l.f || other.form == l.g) continue;
            const auto sign = heights_.value_difference(other.form, l.f, l.x, l.y).sign();
            if (!sign) return false;
            is_hidden = is_hidden || *sign == Sign::Negative;
        }
        if (!is_hidden && !work_.insert_lens(l.h, l.f, l.g, l.ends, l.across)) return false;
    }
    return true;
}

// A form that touches the trisector of two others may do so where further forms tie with these: it is one of
// the vertex, and has no face there.
bool TouchJoin::touch_in_vertex(std::uint32_t vertex, std::span<const FormId> touching,
                                const std::array<Wide, 2>& at) {
    MixedPiece::Vertex& v = work_.piece.vertices[vertex];
    std::vector<FormId> ties = v.ties.empty() ? work_.forms_around(vertex) : v.ties;
    for (const FormId f : touching)
        if (std::ranges::find(ties, f) == ties.end()) ties.push_back(f);
    const Wide height = heights_.value(ties[0], at[0], at[1]);
    for (const FormId f : ties)
        if (!agree(heights_.value(f, at[0], at[1]), height, height)) return false;
    decisions_.by_multiprecision += ties.size() - 1;
    v.ties = std::move(ties);
    if (const auto exact = points_.exact_touch(touching, v.ties, at, work_.piece.box)) {
        const auto& [x, y] = *exact;
        v.point = {x.mid(), y.mid()};
        v.error = reach(x, y);
    } else {
        all_.assume(v.point, std::ldexp(extent_, assumed_exponent / 2), v.ties);
    }
    return true;
}

}  // namespace vcell
