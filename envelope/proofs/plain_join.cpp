#include "plain_join.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vcell {

bool PlainJoin::is_plain() const {
    const std::vector<Spread>& r = work_.rivals;
    const std::size_t n = r.size();
    // Triples first: three forms are often equal in two points, which takes less to see than all directions.
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = i + 1; j < n; ++j)
            for (std::size_t k = j + 1; k < n; ++k)
                if (!work_.turn(r[i], r[j], r[k]) && !work_.is_hidden(r[i], r[j], r[k]) &&
                    !work_.is_apart(r[i], r[j], r[k]))
                    return false;
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = i + 1; j < n; ++j)
            if (!work_.direction(r[i], r[j])) return false;
    return true;
}

// Arcs of a plain piece. Without a change, two or three competitors leave no room for any: an arc's ends lie
// on the rim or in the one point where all three are equal, and that one needs three ends on the rim.
bool PlainJoin::join() {
    const auto& changes = work_.changes;
    const std::size_t n = work_.rivals.size();
    if (!work_.knots.empty()) {
        std::vector<RimKnot> knots;
        for (const std::uint32_t v : work_.knots) {
            auto knot = forms_around_knot(v);
            if (!knot) return false;
            knots.push_back(*std::move(knot));
        }
        return join_all(knots);
    }
    if (n <= 3) {
        if (changes.empty()) return true;
        if (work_.matched_pair()) {
            work_.join(changes[0], changes[1]);
            return true;
        }
        if (n == 3 && changes.size() == 3) {
            const std::array forms{changes[0].before, changes[1].before, changes[2].before};
            MixedPiece::Vertex v;
            if (!PieceVertices(all_, work_).locate(forms, v)) return false;
            work_.join_all_to(v);
            return true;
        }
    }
    return join_all({});
}

// Between the two sides the lowest forms follow each other as their gradients do on their convex hull, from
// the label of one side to that of the other: so they do, too, where an arc leaves along a side. If both are
// one form, it is lowest along two directions and all between them; only where these are opposite may one
// other form be equal along both: their trisector touches the side, and passes through the piece if the other
// form falls faster towards the inside. Of two forms of which the greater one shows likewise.
std::optional<PlainJoin::RimKnot> PlainJoin::forms_around_knot(std::uint32_t v) {
    const auto [arriving, leaving] = work_.sides_at(v);
    const std::size_t rim = work_.piece.rim.size();
    const FormId first = work_.piece.rim[v].label, last = work_.piece.rim[(v + rim - 1) % rim].label;
    RimKnot knot{v, work_.piece.vertices[v].ties, {first}};
    if (!work_.rule.spares(knot.ties) && knot.ties.size() != 2) return std::nullopt;
    SmallVector<const Spread*, usual_rivals> ties;
    for (const FormId f : knot.ties) {
        const Spread* s = work_.find(f);
        if (!s) return std::nullopt;
        ties.push_back(s);
    }
    const auto find = [&](FormId f) { return std::ranges::find(ties, f, &Spread::form); };
    if (find(first) == ties.end() || find(last) == ties.end()) return std::nullopt;
    if (first == last) {
        if (arriving != leaving) return knot;
        if (ties.size() != 2) return std::nullopt;
        const Spread *lowest = *find(first), *other = ties[0] == lowest ? ties[1] : ties[0];
        const auto [gx, gy] = work_.gradient(*other, *lowest);
        const auto inward = (Interval(leaving->a) * gx + Interval(leaving->b) * gy).sign();
        if (!inward || *inward == Sign::Zero) return std::nullopt;
        const bool shows_greater = work_.rule.shows_greater(other->form, lowest->form);
        if (*inward == (shows_greater ? Sign::Positive : Sign::Negative))
            knot.around = {first, other->form, first};
        return knot;
    }
    while (knot.around.back() != last) {
        const auto next = work_.next_on_hull(ties, **find(knot.around.back()));
        if (!next || knot.around.size() >= ties.size()) return std::nullopt;
        knot.around.push_back(next->form);
    }
    return knot;
}

// A stretch of a trisector of three forms ends on the rim or in the one point where all are equal, where
// one stretch of each ends. So that point is inside if every two change on the rim an odd number of times,
// and not if they do so an even number of times. Pre: there are no other forms.
bool PlainJoin::leave_one_end(const std::array<FormId, 3>& forms) const {
    return std::ranges::count_if(work_.changes,
                                 [&](const RimChange& c) {
                                     return (c.before == forms[0] && c.after == forms[1]) ||
                                            (c.before == forms[1] && c.after == forms[0]);
                                 }) %
               2 ==
           1;
}

// Every visible stretch of a trisector is a graph over the line across its direction. If it has two ends, at
// the rim's changes and at the vertices, it is one stretch; if it has more, all of the trisector is to be a
// graph, along which stretches begin and end in turn. Around a vertex the forms follow each other
// counter-clockwise as their gradients do on their convex hull, since the lowest one in a direction has the
// gradient farthest against it.
bool PlainJoin::join_all(std::span<const RimKnot> knots) {
    const std::vector<Spread>& r = work_.rivals;
    const std::size_t n = r.size(), rim = work_.piece.vertices.size();
    struct Inner {
        MixedPiece::Vertex vertex;
        std::vector<const Spread*> hull;  // rivals, counter-clockwise
        std::vector<FormId> forms;
    };
    std::vector<Inner> inner;
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = i + 1; j < n; ++j)
            for (std::size_t k = j + 1; k < n; ++k) {
                const std::array forms{r[i].form, r[j].form, r[k].form};
                const auto meet = [&](const std::vector<FormId>& there) {
                    return std::ranges::all_of(
                        forms, [&](FormId f) { return std::ranges::find(there, f) != there.end(); });
                };
                if (std::ranges::any_of(inner, meet, &Inner::forms) ||
                    std::ranges::any_of(knots, meet, &RimKnot::ties))
                    continue;
                if (work_.turn(r[i], r[j], r[k]) == Sign::Zero || work_.is_hidden(r[i], r[j], r[k])) continue;
                Inner v;
                Inside inside = Inside::No;
                if (n > 3 || !knots.empty())
                    inside = PieceVertices(all_, work_).find(forms, v.vertex);
                else if (leave_one_end(forms))
                    inside =
                        PieceVertices(all_, work_).locate(forms, v.vertex) ? Inside::Yes : Inside::Unknown;
                if (inside == Inside::Unknown) return false;
                if (inside == Inside::No) continue;
                v.forms.assign(forms.begin(), forms.end());
                std::vector<const Spread*> present{&r[i], &r[j], &r[k]};
                if (!rule_.spares(work_.forms())) {
                    const auto is_visible = shows_beside_floor(v.vertex, forms);
                    if (!is_visible) return false;
                    if (!*is_visible) continue;
                    std::optional<Sign> turn = work_.turn(r[i], r[j], r[k]);
                    if (!turn) return false;
                    if (rule_.turns_round(forms[0], forms[1], forms[2])) turn = -*turn;
                    if (turn == Sign::Negative) std::swap(present[1], present[2]);
                    v.hull = present;
                    inner.push_back(std::move(v));
                    continue;
                }
                bool visible = true;
                for (std::size_t l = 0; l < n && visible; ++l) {
                    if (l == i || l == j || l == k) continue;
                    const auto s = points_.sign_at_vertex(v.vertex, forms, r[l].form);
                    if (!s) return false;
                    visible = *s != Sign::Negative;
                    if (*s != Sign::Zero) continue;
                    v.forms.push_back(r[l].form);
                    present.push_back(&r[l]);
                }
                if (!visible) continue;
                if (v.forms.size() > 3) {
                    v.vertex.ties = v.forms;
                    if (!points_.settle_tie(v.vertex, forms))
                        all_.assume(v.vertex.point, std::ldexp(extent_, assumed_exponent), v.forms);
                }
                const Spread* a = *std::ranges::find_if(
                    present, [&](const Spread* p) { return work_.next_on_hull(present, *p) != nullptr; });
                do {
                    v.hull.push_back(a);
                    a = work_.next_on_hull(present, *a);
                } while (a != v.hull.front());
                inner.push_back(std::move(v));
            }
    for (const Inner& v : inner) {
        work_.piece.vertices.push_back(v.vertex);
        work_.piece.leaving.emplace_back();
        work_.triples.push_back({v.forms[0], v.forms[1], v.forms[2]});
    }

    std::vector<RimChange> ends;
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = i + 1; j < n; ++j) {
            ends.clear();
            const auto add = [&](const RimChange& c) {
                if ((c.before == r[i].form && c.after == r[j].form) ||
                    (c.before == r[j].form && c.after == r[i].form))
                    ends.push_back(c);
            };
            for (const RimChange& c : work_.changes)
                if (std::ranges::find(knots, c.vertex, &RimKnot::vertex) == knots.end()) add(c);
            for (const RimKnot& knot : knots)
                for (std::size_t k = 0; k + 1 < knot.around.size(); ++k)
                    add({knot.vertex, knot.around[k + 1], knot.around[k]});
            for (std::size_t v = 0; v < inner.size(); ++v) {
                const std::vector<const Spread*>& hull = inner[v].hull;
                for (std::size_t k = 0; k < hull.size(); ++k)
                    add({static_cast<std::uint32_t>(rim + v), hull[(k + 1) % hull.size()]->form,
                         hull[k]->form});
            }
            if (ends.empty()) continue;
            const Vector2d direction = *work_.direction(r[i], r[j]);
            if (ends.size() > 2 && !work_.crosses_once(r[i], r[j], direction)) return false;
            if (!join_pair(direction, r[i].form, r[j].form, ends)) return false;
        }
    // Around a vertex each arc has another form on its right.
    const auto sort_around = [&](std::size_t v, const auto& around, auto form) {
        MixedPiece::HalfEdges& leaving = work_.piece.leaving[v];
        MixedPiece::HalfEdges sorted;
        for (const auto& right : around)
            for (const std::uint32_t h : leaving) {
                const MixedPiece::Arc& a = work_.piece.arcs[h >> 1];
                if ((h & 1u ? a.left : a.right) == form(right)) sorted.push_back(h);
            }
        leaving = std::move(sorted);
    };
    for (std::size_t v = 0; v < inner.size(); ++v)
        sort_around(rim + v, inner[v].hull, [](const Spread* s) { return s->form; });
    for (const RimKnot& knot : knots)
        sort_around(knot.vertex, std::span(knot.around).first(knot.around.size() - 1),
                    [](FormId f) { return f; });
    return true;
}

// Does a vertex of three forms show? None if it is not told, or another one ties with them.
std::optional<bool> PlainJoin::shows_beside_floor(const MixedPiece::Vertex& v,
                                                  const std::array<FormId, 3>& three) {
    std::vector<FormId> others = work_.forms();
    std::erase_if(others, [&](FormId f) { return std::ranges::find(three, f) != three.end(); });
    std::vector<Sign> signs;
    for (const FormId f : others) {
        const auto s = points_.sign_at_vertex(v, three, f);
        if (!s || *s == Sign::Zero) return std::nullopt;
        signs.push_back(*s);
    }
    return rule_.shows_vertex(three, others,
                              [&](FormId f) { return signs[std::ranges::find(others, f) - others.begin()]; });
}

// Along e the direction in which f - g grows points to the left: there g is lower. Vertices that doubles do
// not separate are compared with many digits.
bool PlainJoin::join_pair(const Vector2d& direction, FormId f, FormId g, std::vector<RimChange>& ends) {
    if (ends.size() % 2 != 0) return false;
    const Vector2d e(direction.y(), -direction.x());
    const std::size_t rim = work_.piece.rim.size();
    bool separated = true;
    const auto precedes = [&](const RimChange& a, const RimChange& b) {
        if (a.vertex == b.vertex)
            return a.before == f && b.before == g;  // touching the rim: one stretch ends, one begins
        const MixedPiece::Vertex &v = work_.piece.vertices[a.vertex], &w = work_.piece.vertices[b.vertex];
        const double gap = e.dot(w.point - v.point);
        if (std::abs(gap) >
            2 * (v.error + w.error) + 8 * std::numeric_limits<double>::epsilon() * v.point.norm())
            return gap > 0;
        if (a.vertex >= rim && b.vertex >= rim) {
            const auto p = points_.sharp_vertex(v, work_.triples[a.vertex - rim]),
                       q = points_.sharp_vertex(w, work_.triples[b.vertex - rim]);
            if (p && q) {
                const auto s = (Wide(e.x()) * ((*q)[0] - (*p)[0]) + Wide(e.y()) * ((*q)[1] - (*p)[1])).sign();
                ++decisions_.by_multiprecision;
                if (s) return *s == Sign::Positive;
            }
        }
        separated = false;
        return gap > 0;
    };
    // Few, and the order may turn out undecided: sorted by hand.
    for (std::size_t i = 1; i < ends.size(); ++i)
        for (std::size_t k = i; k > 0 && precedes(ends[k], ends[k - 1]); --k) std::swap(ends[k], ends[k - 1]);
    if (!separated) return false;
    for (std::size_t k = 0; k < ends.size(); ++k)
        if (ends[k].before != (k % 2 == 0 ? g : f)) return false;
    for (std::size_t k = 0; k < ends.size(); k += 2) work_.join(ends[k], ends[k + 1]);
    return true;
}

}  // namespace vcell
