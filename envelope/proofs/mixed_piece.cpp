#include "mixed_piece.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "../../core/errors.hpp"
#include "mixed_work.hpp"

namespace vcell {

std::optional<MixedPiece> MixedAnalysis::resolve(const PieceBoundary& boundary) {
    Work work{{boundary},
              normals_ ? &*normals_ : nullptr,
              normals_ ? &*supports_ : nullptr,
              heights_,
              rule_,
              decisions_,
              parts_,
              spreads_};
    double x0 = infinity, x1 = -infinity, y0 = infinity, y1 = -infinity;
    for (const IntervalPoint& c : boundary.corners) {
        x0 = std::min(x0, c[0].lower());
        x1 = std::max(x1, c[0].upper());
        y0 = std::min(y0, c[1].lower());
        y1 = std::max(y1, c[1].upper());
    }
    work.piece.box = {x0, x1, y0, y1};
    work.width = std::max(x1 - x0, y1 - y0);
    work.extent = extent_at({x0, x1}, {y0, y1});
    work.is_small = std::min(x1 - x0, y1 - y0) <= tie_width * work.extent;

    MixedPiece& piece = work.piece;
    const std::size_t sides = boundary.sides.size();
    std::size_t rim = sides;
    for (const SideLabels& l : boundary.labels) rim += l.transitions.size();
    piece.vertices.reserve(rim + 1);
    piece.leaving.reserve(rim + 1);
    piece.rim.reserve(rim);
    work.changes.reserve(rim);
    const auto add_rim = [&](const Vector2d& p, double error, FormId before, FormId after,
                             std::span<const FormId> ties) {
        const auto v = static_cast<std::uint32_t>(piece.vertices.size());
        piece.vertices.push_back({p, error, after, {ties.begin(), ties.end()}});
        if (ties.size() > (before == after ? 1 : 2)) work.knots.push_back(v);
        if (before != after) work.changes.push_back({v, before, after});
    };
    for (std::size_t i = 0; i < sides; ++i) {
        const SideLabels& labels = boundary.labels[i];
        const IntervalPoint& c = boundary.corners[i];
        const FormId before = boundary.labels[(i + sides - 1) % sides].last();
        if (before != labels.first && boundary.corner_ties[i].size() < 2)
            throw InternalError("labels differ around a corner of a piece");
        add_rim({c[0].mid(), c[1].mid()}, reach(c[0], c[1]), before, labels.first, boundary.corner_ties[i]);
        piece.rim.push_back({boundary.sides[i].id, labels.first});
        for (const RimTransition& t : labels.transitions) {
            add_rim(t.point, t.error, t.before, t.after, t.ties);
            piece.rim.push_back({boundary.sides[i].id, t.after});
        }
    }
    piece.leaving.resize(piece.vertices.size());

    const bool at_floor = work.width <= floor_width * work.extent;
    cull_from_rim(work);
    // Of more than three most triples meet where others are lower: that takes second derivatives to know.
    const bool is_crowded = !normals_ && work.rivals.size() > 3;
    bool plain = !is_crowded && is_plain(work);
    if (!plain) {
        // The difference of a circular form and one other is in mean value form already.
        const auto has_root = [&](const Spread& s) { return !heights_.family().is_circular(s.form); };
        const bool bends = !normals_ || std::ranges::count_if(work.rivals, has_root) > 1;
        if (bends) {
            bend(work.piece.box, work.rivals);
            work.directions.clear();
            cull_by_curvature(work);
            cull_from_rim(work);
        }
        if (work.width < sharp_width * work.extent) cull_sharply(work);
        plain = bends && is_plain(work);
    }
    remaining_ = work.forms();
    const bool near_tie =
        !plain && work.rivals.size() > 1 && work.width <= tie_width * tie_extent_at({x0, x1}, {y0, y1});
    if (!plain && !near_tie && !at_floor) return std::nullopt;
    ++decisions_.by_interval;

    const std::size_t assumed_before = assumptions_.size();
    const bool joined =
        (plain && join_changes(work)) || (near_tie && (join_at_tie(work) || join_at_saddle(work) ||
                                                       join_at_pinch(work) || join_without_touching(work)));
    if (!joined) {
        // What was assumed on the way will be asked again.
        decisions_.assumed -= assumptions_.size() - assumed_before;
        assumptions_.erase(assumptions_.begin() + static_cast<std::ptrdiff_t>(assumed_before),
                           assumptions_.end());
        if (!at_floor) return std::nullopt;
        join_at_center(work);
    }
    return std::move(work.piece);
}

// Without the forms that are lowest nowhere in the piece but for touching the trisector of two others in a
// vertex, or in a lens on it.
bool MixedAnalysis::join_without_touching(Work& work) {
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
    work.clear_inside();
    if (work.rivals.size() < 3 || !work.knots.empty() || !rule_.spares(work.forms())) return false;
    std::vector<Touch> touches;
    // An arc that is touched inside meets the rim, or it does in a smaller piece: of all pairs those are
    // enough that change there.
    std::vector<std::array<FormId, 2>> pairs;
    for (const Change& c : work.changes) {
        const std::array pair{std::min(c.before, c.after), std::max(c.before, c.after)};
        if (std::ranges::find(pairs, pair) == pairs.end()) pairs.push_back(pair);
    }
    const auto stays_above = [&](FormId h) {
        for (const auto& [f, g] : pairs) {
            const auto touching = find_touching(heights_, h, f, g, work.piece.box);
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
                    return settle_sharply(v, {f, g, h});
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
                    work.where(lens.x, lens.y) == Inside::Yes) {
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
                is_tie ? exact_touch(forms, forms, touching->at, work.piece.box) : std::nullopt;
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
            }
            touches.push_back(std::move(t));
            return true;
        }
        return false;
    };
    const std::size_t before = work.rivals.size();
    for (std::size_t i = 0; i < work.rivals.size() && work.rivals.size() > 2;)
        if (const FormId h = work.rivals[i].form; !work.is_on_rim(h) && stays_above(h))
            work.rivals.erase(work.rivals.begin() + static_cast<std::ptrdiff_t>(i));
        else
            ++i;
    if (work.rivals.size() == before) return false;
    work.directions.clear();
    work.is_divided = false;
    if (!(is_plain(work) && join_changes(work)) && !join_at_tie(work)) return false;
    for (const Touch& t : touches) {
        const Vector2d& p = t.vertex.point;
        const double r = t.vertex.error;
        const Inside inside = work.where(p, r);
        if (inside == Inside::No) continue;
        if (inside == Inside::Unknown) return false;
        if (const auto v = work.inner_vertex_near(p, r)) {
            if (!touch_in_vertex(work, *v, t.vertex.ties, t.at)) return false;
            continue;
        }
        // Nor where another form is lower.
        const Interval x = Interval::ball(p.x(), r), y = Interval::ball(p.y(), r);
        bool is_hidden = false;
        for (const Spread& other : work.rivals) {
            if (other.form == t.f || other.form == t.g) continue;
            const auto sign = heights_.value_difference(other.form, t.f, x, y).sign();
            if (!sign) return false;
            is_hidden = is_hidden || *sign == Sign::Negative;
        }
        if (is_hidden) continue;
        if (!work.divide(t.f, t.g, t.vertex)) return false;
        if (!t.decided) assume(p, r, t.vertex.ties);
    }
    for (const Lens& l : lenses) {
        bool is_hidden = false;
        for (const Spread& other : work.rivals) {
            if (other.form == l.f || other.form == l.g) continue;
            const auto sign = heights_.value_difference(other.form, l.f, l.x, l.y).sign();
            if (!sign) return false;
            is_hidden = is_hidden || *sign == Sign::Negative;
        }
        if (!is_hidden && !work.insert_lens(l.h, l.f, l.g, l.ends, l.across)) return false;
    }
    return true;
}

// A form that touches the trisector of two others may do so where further forms tie with these: it is one of
// the vertex, and has no face there.
bool MixedAnalysis::touch_in_vertex(Work& work, std::uint32_t vertex, std::span<const FormId> touching,
                                    const std::array<Wide, 2>& at) {
    MixedPiece::Vertex& v = work.piece.vertices[vertex];
    std::vector<FormId> ties = v.ties.empty() ? work.forms_around(vertex) : v.ties;
    for (const FormId f : touching)
        if (std::ranges::find(ties, f) == ties.end()) ties.push_back(f);
    const Wide height = heights_.value(ties[0], at[0], at[1]);
    for (const FormId f : ties)
        if (!agree(heights_.value(f, at[0], at[1]), height, height)) return false;
    decisions_.by_multiprecision += ties.size() - 1;
    v.ties = std::move(ties);
    if (const auto exact = exact_touch(touching, v.ties, at, work.piece.box)) {
        const auto& [x, y] = *exact;
        v.point = {x.mid(), y.mid()};
        v.error = reach(x, y);
    } else {
        assume(v.point, std::ldexp(extent_, assumed_exponent / 2), v.ties);
    }
    return true;
}

bool MixedAnalysis::is_plain(const Work& work) const {
    const std::vector<Spread>& r = work.rivals;
    const std::size_t n = r.size();
    // Triples first: three forms are often equal in two points, which takes less to see than all directions.
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = i + 1; j < n; ++j)
            for (std::size_t k = j + 1; k < n; ++k)
                if (!work.turn(r[i], r[j], r[k]) && !work.is_hidden(r[i], r[j], r[k]) &&
                    !work.is_apart(r[i], r[j], r[k]))
                    return false;
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = i + 1; j < n; ++j)
            if (!work.direction(r[i], r[j])) return false;
    return true;
}

// Arcs of a plain piece. Without a change, two or three competitors leave no room for any: an arc's ends lie
// on the rim or in the one point where all three are equal, and that one needs three ends on the rim.
bool MixedAnalysis::join_changes(Work& work) {
    const auto& changes = work.changes;
    const std::size_t n = work.rivals.size();
    if (!work.knots.empty()) {
        std::vector<Knot> knots;
        for (const std::uint32_t v : work.knots) {
            auto knot = forms_around_knot(work, v);
            if (!knot) return false;
            knots.push_back(*std::move(knot));
        }
        return join_all(work, knots);
    }
    if (n <= 3) {
        if (changes.empty()) return true;
        if (work.matched_pair()) {
            work.join(changes[0], changes[1]);
            return true;
        }
        if (n == 3 && changes.size() == 3) {
            const std::array forms{changes[0].before, changes[1].before, changes[2].before};
            MixedPiece::Vertex v;
            if (!locate_vertex(work, forms, v)) return false;
            work.join_all_to(v);
            return true;
        }
    }
    return join_all(work, {});
}

// Is an error of a place next to nothing, also where the place is lifted, which takes it times the steepest
// slope?
bool MixedAnalysis::is_well_known(const Vector2d& p, double error, std::span<const FormId> forms,
                                  double extent) const {
    constexpr double enough = 0x1p-33;
    double slope = 0;
    if (!supports_)
        for (const FormId f : forms) {
            const auto [height, gx, gy] = heights_.near(f, p.x(), p.y());
            slope = std::max(slope, std::hypot(gx, gy));
        }
    return error * (1 + slope) <= enough * extent;
}

// The point inside in which three forms are equal, which is known to exist.
bool MixedAnalysis::locate_vertex(const Work& work, const std::array<FormId, 3>& forms,
                                  MixedPiece::Vertex& v) {
    v = {work.middle(), 0, forms[0], {}};
    const auto root = root_near(model_of<Interval>([&](const IntervalBox<2>& p) {
                                    return work.supports ? equal_heights(*work.supports, forms, p)
                                                         : equal_heights(heights_, forms, p);
                                }),
                                work.middle());
    if (root) {
        v.point = root->point;
        v.error = root->error;
    }
    const auto& box = work.piece.box;
    const auto is_inside = [&] {
        return v.point.x() + v.error >= box[0] && v.point.x() - v.error <= box[1] &&
               v.point.y() + v.error >= box[2] && v.point.y() - v.error <= box[3];
    };
    // Where the three all but touch, doubles tell them badly apart. Along tubes that are all but parallel
    // pieces are narrow across only.
    constexpr double well_told = 0x1p-40;
    const MixedPiece::Vertex rough = v;
    const bool is_found = root && is_inside(),
               is_narrow = std::min(box[1] - box[0], box[3] - box[2]) <= node_width * work.extent;
    const bool is_sharp =
        (is_found ? v.error > well_told * work.extent || !is_well_known(v.point, v.error, forms, work.extent)
                  : is_narrow) &&
        settle_sharply(v, forms) && is_inside();
    if (!is_sharp) v = rough;
    if (is_sharp || is_found) ++(is_sharp ? decisions_.by_multiprecision : decisions_.by_interval);
    return is_sharp || is_found;
}

// Between the two sides the lowest forms follow each other as their gradients do on their convex hull, from
// the label of one side to that of the other: so they do, too, where an arc leaves along a side. If both are
// one form, it is lowest along two directions and all between them; only where these are opposite may one
// other form be equal along both: their trisector touches the side, and passes through the piece if the other
// form falls faster towards the inside.
std::optional<MixedAnalysis::Knot> MixedAnalysis::forms_around_knot(const Work& work, std::uint32_t v) {
    const auto [arriving, leaving] = work.sides_at(v);
    const std::size_t rim = work.piece.rim.size();
    const FormId first = work.piece.rim[v].label, last = work.piece.rim[(v + rim - 1) % rim].label;
    Knot knot{v, work.piece.vertices[v].ties, {first}};
    if (!work.rule.spares(knot.ties)) return std::nullopt;
    SmallVector<const Spread*, usual_rivals> ties;
    for (const FormId f : knot.ties) {
        const Spread* s = work.find(f);
        if (!s) return std::nullopt;
        ties.push_back(s);
    }
    const auto find = [&](FormId f) { return std::ranges::find(ties, f, &Spread::form); };
    if (find(first) == ties.end() || find(last) == ties.end()) return std::nullopt;
    if (first == last) {
        if (arriving != leaving) return knot;
        if (ties.size() != 2) return std::nullopt;
        const Spread *lowest = *find(first), *other = ties[0] == lowest ? ties[1] : ties[0];
        const auto [gx, gy] = work.gradient(*other, *lowest);
        const auto inward = (Interval(leaving->a) * gx + Interval(leaving->b) * gy).sign();
        if (!inward || *inward == Sign::Zero) return std::nullopt;
        if (*inward == Sign::Negative) knot.around = {first, other->form, first};
        return knot;
    }
    while (knot.around.back() != last) {
        const auto next = work.next_on_hull(ties, **find(knot.around.back()));
        if (!next || knot.around.size() >= ties.size()) return std::nullopt;
        knot.around.push_back(next->form);
    }
    return knot;
}

// Of three forms each stretch of a trisector ends on the rim or in the one point where all are equal, where
// one stretch of each ends. So that point is inside if every two change on the rim an odd number of times,
// and not if they do so an even number of times. Pre: there are no other forms.
bool MixedAnalysis::leave_one_end(const Work& work, const std::array<FormId, 3>& forms) {
    return std::ranges::count_if(work.changes,
                                 [&](const Change& c) {
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
bool MixedAnalysis::join_all(Work& work, std::span<const Knot> knots) {
    const std::vector<Spread>& r = work.rivals;
    const std::size_t n = r.size(), rim = work.piece.vertices.size();
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
                    std::ranges::any_of(knots, meet, &Knot::ties))
                    continue;
                if (work.turn(r[i], r[j], r[k]) == Sign::Zero || work.is_hidden(r[i], r[j], r[k])) continue;
                Inner v;
                Inside inside = Inside::No;
                if (n > 3 || !knots.empty())
                    inside = find_vertex(work, forms, v.vertex);
                else if (leave_one_end(work, forms))
                    inside = locate_vertex(work, forms, v.vertex) ? Inside::Yes : Inside::Unknown;
                if (inside == Inside::Unknown) return false;
                if (inside == Inside::No) continue;
                v.forms.assign(forms.begin(), forms.end());
                std::vector<const Spread*> present{&r[i], &r[j], &r[k]};
                if (!rule_.spares(work.forms())) {
                    const auto is_visible = shows_beside_floor(work, v.vertex, forms);
                    if (!is_visible) return false;
                    if (!*is_visible) continue;
                    std::optional<Sign> turn = work.turn(r[i], r[j], r[k]);
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
                    const auto s = sign_at_vertex(v.vertex, forms, r[l].form);
                    if (!s) return false;
                    visible = *s != Sign::Negative;
                    if (*s != Sign::Zero) continue;
                    v.forms.push_back(r[l].form);
                    present.push_back(&r[l]);
                }
                if (!visible) continue;
                if (v.forms.size() > 3) {
                    v.vertex.ties = v.forms;
                    if (!settle_tie(v.vertex, forms))
                        assume(v.vertex.point, std::ldexp(extent_, assumed_exponent), v.forms);
                }
                const Spread* a = *std::ranges::find_if(
                    present, [&](const Spread* p) { return work.next_on_hull(present, *p) != nullptr; });
                do {
                    v.hull.push_back(a);
                    a = work.next_on_hull(present, *a);
                } while (a != v.hull.front());
                inner.push_back(std::move(v));
            }
    for (const Inner& v : inner) {
        work.piece.vertices.push_back(v.vertex);
        work.piece.leaving.emplace_back();
        work.triples.push_back({v.forms[0], v.forms[1], v.forms[2]});
    }

    std::vector<Change> ends;
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = i + 1; j < n; ++j) {
            ends.clear();
            const auto add = [&](const Change& c) {
                if ((c.before == r[i].form && c.after == r[j].form) ||
                    (c.before == r[j].form && c.after == r[i].form))
                    ends.push_back(c);
            };
            for (const Change& c : work.changes)
                if (std::ranges::find(knots, c.vertex, &Knot::vertex) == knots.end()) add(c);
            for (const Knot& knot : knots)
                for (std::size_t k = 0; k + 1 < knot.around.size(); ++k)
                    add({knot.vertex, knot.around[k + 1], knot.around[k]});
            for (std::size_t v = 0; v < inner.size(); ++v) {
                const std::vector<const Spread*>& hull = inner[v].hull;
                for (std::size_t k = 0; k < hull.size(); ++k)
                    add({static_cast<std::uint32_t>(rim + v), hull[(k + 1) % hull.size()]->form,
                         hull[k]->form});
            }
            if (ends.empty()) continue;
            const Vector2d direction = *work.direction(r[i], r[j]);
            if (ends.size() > 2 && !work.crosses_once(r[i], r[j], direction)) return false;
            if (!join_pair(work, direction, r[i].form, r[j].form, ends)) return false;
        }
    // Around a vertex each arc has another form on its right.
    const auto sort_around = [&](std::size_t v, const auto& around, auto form) {
        MixedPiece::HalfEdges& leaving = work.piece.leaving[v];
        MixedPiece::HalfEdges sorted;
        for (const auto& right : around)
            for (const std::uint32_t h : leaving) {
                const MixedPiece::Arc& a = work.piece.arcs[h >> 1];
                if ((h & 1u ? a.left : a.right) == form(right)) sorted.push_back(h);
            }
        leaving = std::move(sorted);
    };
    for (std::size_t v = 0; v < inner.size(); ++v)
        sort_around(rim + v, inner[v].hull, [](const Spread* s) { return s->form; });
    for (const Knot& knot : knots)
        sort_around(knot.vertex, std::span(knot.around).first(knot.around.size() - 1),
                    [](FormId f) { return f; });
    return true;
}

// Does a vertex of three forms show? None if it is not told, or another one ties with them.
std::optional<bool> MixedAnalysis::shows_beside_floor(const Work& work, const MixedPiece::Vertex& v,
                                                      const std::array<FormId, 3>& three) {
    std::vector<FormId> others = work.forms();
    std::erase_if(others, [&](FormId f) { return std::ranges::find(three, f) != three.end(); });
    std::vector<Sign> signs;
    for (const FormId f : others) {
        const auto s = sign_at_vertex(v, three, f);
        if (!s || *s == Sign::Zero) return std::nullopt;
        signs.push_back(*s);
    }
    return rule_.shows_vertex(three, others,
                              [&](FormId f) { return signs[std::ranges::find(others, f) - others.begin()]; });
}

// Along e the direction in which f - g grows points to the left: there g is lower. Vertices that doubles do
// not separate are compared with many digits.
bool MixedAnalysis::join_pair(Work& work, const Vector2d& direction, FormId f, FormId g,
                              std::vector<Change>& ends) {
    if (ends.size() % 2 != 0) return false;
    const Vector2d e(direction.y(), -direction.x());
    const std::size_t rim = work.piece.rim.size();
    bool separated = true;
    const auto precedes = [&](const Change& a, const Change& b) {
        if (a.vertex == b.vertex)
            return a.before == f && b.before == g;  // touching the rim: one stretch ends, one begins
        const MixedPiece::Vertex &v = work.piece.vertices[a.vertex], &w = work.piece.vertices[b.vertex];
        const double gap = e.dot(w.point - v.point);
        if (std::abs(gap) >
            2 * (v.error + w.error) + 8 * std::numeric_limits<double>::epsilon() * v.point.norm())
            return gap > 0;
        if (a.vertex >= rim && b.vertex >= rim) {
            const auto p = sharp_vertex(v, work.triples[a.vertex - rim]),
                       q = sharp_vertex(w, work.triples[b.vertex - rim]);
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
    for (std::size_t k = 0; k < ends.size(); k += 2) work.join(ends[k], ends[k + 1]);
    return true;
}

}  // namespace vcell
