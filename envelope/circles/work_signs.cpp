#include "work_signs.hpp"

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <string>

#include "../../arrangement/circles/curve_order.hpp"
#include "../../arrangement/circles/point_star.hpp"
#include "../../core/errors.hpp"

namespace vcell {

namespace {

// Relative to the sum of all terms, some twenty roundings.
constexpr double rounding_margin = 1e-12;

// Slopes across a chord are divided by its length, which is known from above alone (CircleKernel::ArcBounds).
constexpr double slope_margin = 1e-5;

}  // namespace

void WorkSigns::clear() {
    WorkMesh::clear();
    stamp_ = 0;
    merging_ = false;
    visits_ = walks_ = 0;
}

void WorkSigns::decide_boundary(Duel& d) {
    const Face& f = faces_[d.face];
    const FormPair rival = rivals(d.challenger, f.site);
    const double K = steepening(rival);
    for_boundary(f, [&](Index h) {
        visits_ += 4;
        const Index v = half_edges_[h].origin;
        if (v != none && vertex_sign(v, rival) != Sign::Positive) d.met = true;
    });
    for (const Index v : f.isolated) vertex_sign(v, rival);
    for_boundary(f, [&](Index h) {
        Edge& edge = edges_[h >> 1];
        if (edge.stamp != stamp_) {
            edge.stamp = stamp_;
            const Index from = half_edges_[h].origin, to = target(h);
            bool is_cut = false;
            if (from != none && steadily_keeps_sign(edge, vertices_[from], vertices_[to], d, K))
                edge.sign = vertices_[from].sign;
            else
                is_cut = decide_edge(h >> 1, rival);
            d.met = d.met || is_cut;
            const auto is_reached = [&] {
                return is_cut || edges_[h >> 1].sign != Sign::Positive ||
                       (from != none &&
                        (vertices_[from].sign != Sign::Positive || vertices_[to].sign != Sign::Positive));
            };
            if (walks_ > 0 && is_reached()) reached_.push_back(half_edges_[twin(h)].face);
        } else if (walks_ > 0 && edge.sign != Sign::Positive) {
            reached_.push_back(half_edges_[twin(h)].face);
        }
        d.met = d.met || edges_[h >> 1].sign != Sign::Positive;
    });
}

// Upper bound of |K| of challenger - defender.
double WorkSigns::steepening(FormPair rival) const {
    const double Kb = kernel_.form(rival.f).K, Ka = kernel_.form(rival.g).K;
    return std::abs(Kb - Ka) + rounding_margin * (std::abs(Kb) + std::abs(Ka));
}

Sign WorkSigns::find_vertex_sign(Index v, FormPair rival) {
    Vertex& vertex = vertices_[v];
    vertex.stamp = stamp_;
    const FormId challenger = challenger_of(rival);
    const BoxForm b = kernel_.form(challenger).over_box(vertex.x, vertex.y, vertex.error, vertex.error);
    vertex.slope_x = b.gx;
    vertex.slope_y = b.gy;
    const double difference = b.v - vertex.height;
    // b.top - b.v: its change over the point's uncertainty.
    vertex.margin =
        std::abs(difference) - 1.01 * (b.top - b.v + vertex.height_error) - 64 * DBL_EPSILON * b.scale;
    if (vertex.margin > 0) {
        ++kernel_.decisions().by_double;
        vertex.sign = inserts_greater_ ? -sign_of(difference) : sign_of(difference);
        return vertex.sign;
    }
    vertex.sign = kernel_.sign_at(vertex.point, rival.f, rival.g);
    if (vertex.sign == Sign::Zero) {
        if (vertex.out == none)
            add_ties(vertex.ties, {}, challenger);
        else
            for_leaving(vertex.out,
                        [&](Index h) { add_ties(vertex.ties, {half_edges_[h].label}, challenger); });
    }
    return vertex.sign;
}

// Do the values at the ends and the steepest slope all over the face prove that challenger - defender keeps a
// sign along the edge? On the chord it is a parabola of second derivative 2 K, which falls below the lesser
// end by K l^2 / 4 at most; from there to the arc it changes by at most the slope times the sagitta.
bool WorkSigns::steadily_keeps_sign(const Edge& edge, const Vertex& v, const Vertex& w, const Duel& d,
                                    double K) const {
    const double l = edge.bounds.chord, s = edge.bounds.sagitta;
    return v.sign == w.sign && std::min(v.margin, w.margin) > (0.25 * K * l * l + d.slope * s) * (1 + 1e-9);
}

// Do the values at the ends alone prove that challenger - defender keeps their common sign along the edge?
// Let g be it times that sign, F of the rivals, m and n lower bounds of g at the two ends, l the chord and s
// the sagitta. On the chord g >= (1 - t) m + t n - k t (1 - t), where k = K l^2 if that is positive and 0
// otherwise: a parabola whose minimum is in an end if |m - n| >= k, and (k - |m - n|)^2 / 4k below the lesser
// end if not. The arc is less than half a circle, so all of it stands on the chord: from there to it g
// changes by at most |g'| s + |K| s^2, g' being the slope across the chord, which is the same all along it.
bool WorkSigns::keeps_sign(Index e, FormPair rival, Sign common) const {
    const Vertex &v = vertices_[half_edges_[2 * e].origin], &w = vertices_[half_edges_[2 * e + 1].origin];
    const double m = v.margin, n = w.margin;
    if (!(m > 0 && n > 0)) return false;  // a slower rung told the sign
    const KernelForm &b = kernel_.form(rival.f), &a = kernel_.form(rival.g);
    const Vertex &p = v, &q = w;
    const double l = edges_[e].bounds.chord, s = edges_[e].bounds.sagitta;
    const double ax = (2 * a.k * (p.x - a.cx) + a.a) * a.iw, ay = (2 * a.k * (p.y - a.cy) + a.b) * a.iw;
    double bx = v.slope_x, by = v.slope_y;
    if (merging_ || inserts_greater_) {  // they may be another challenger's, or those of rival.g
        bx = (2 * b.k * (p.x - b.cx) + b.a) * b.iw;
        by = (2 * b.k * (p.y - b.cy) + b.b) * b.iw;
    }
    // The ends are known to 1e-8 of the chord, and the chord's direction with them.
    const double K = b.K - a.K, K_error = rounding_margin * (std::abs(b.K) + std::abs(a.K));
    const double gx = bx - ax, gy = by - ay, size = std::abs(K) + K_error;
    const double slope =
        std::abs(gx * (q.y - p.y) - gy * (q.x - p.x)) +
        l * (1e-7 * (std::abs(gx) + std::abs(gy) + size * l) +
             rounding_margin * (std::abs(bx) + std::abs(ax) + std::abs(by) + std::abs(ay) +
                                std::abs(b.K) * (std::abs(p.x - b.cx) + std::abs(p.y - b.cy)) +
                                std::abs(a.K) * (std::abs(p.x - a.cx) + std::abs(p.y - a.cy))));
    const double off_chord = (slope / l + size * s) * s * (1 + slope_margin);
    const double k = ((common == Sign::Positive ? K : -K) + K_error) * l * l, difference = std::abs(m - n);
    const double left = std::min(m, n) * (1 - 1e-9) - off_chord;
    if (!(k > difference)) return left > 0;
    const double dip = k - difference;
    return 4 * k * left > dip * dip * (1 + 1e-9);
}

// Is that, or the values all over a box around the edge, a proof?
bool WorkSigns::surely_keeps_sign(Index e, FormPair rival, Sign common) {
    if (edges_[e].is_shorter) set_bounds(e);
    if (keeps_sign(e, rival, common)) return true;
    const auto [x, y, rx, ry] = box_middle(edges_[e].bounds.box);
    const BoxForm b = kernel_.form(rival.f).over_box(x, y, rx, ry);
    const BoxForm a = kernel_.form(rival.g).over_box(x, y, rx, ry);
    return common == Sign::Positive ? BoxForm::certainly_above(b, a, rx, ry)
                                    : BoxForm::certainly_above(a, b, rx, ry);
}

// The first root of challenger - defender on an edge at whose ends that has one sign: there is another one
// behind it, unless it touches there.
std::optional<WorkSigns::Cut> WorkSigns::first_root(Index e, FormPair rival, Sign common) {
    const Edge& edge = edges_[e];
    const FormPair c = edge.curve;
    // Two lines cross once, and then the signs at the ends would differ.
    if (edge.rim && kernel_.curvature_sign(rival) == Sign::Zero) return std::nullopt;
    const PointId p = vertices_[half_edges_[2 * e].origin].point,
                  q = vertices_[half_edges_[2 * e + 1].origin].point;
    auto first = kernel_.certain_intersection(c, rival, -common, chord_middle(e));
    if (!first) {
        switch (kernel_.intersection_sign(c, rival, chord_middle(e))) {
            case Sign::Negative: return std::nullopt;
            case Sign::Zero: {
                const Cut cut{kernel_.touching_point(c, rival), true};
                if (CurveOrder(kernel_, c).strictly_between(p, q, cut.point)) return cut;
                return std::nullopt;
            }
            case Sign::Positive:
                if (kernel_.curvature_sign(c) == Sign::Zero && kernel_.curvature_sign(rival) == Sign::Zero)
                    return std::nullopt;
                first = change_of_sign(e, rival, -common).point;
        }
    }
    if (!CurveOrder(kernel_, c).strictly_between(p, q, *first)) return std::nullopt;
    return Cut{*first, false};
}

// The root of challenger - defender on the edge that its curve's turn names.
WorkSigns::Cut WorkSigns::change_of_sign(Index e, FormPair rival, Sign turn) {
    const auto root = kernel_.intersection(edges_[e].curve, rival, turn, chord_middle(e));
    if (!root) throw InternalError("no root of a sign change on edge e" + std::to_string(e));
    return {*root, false};
}

// The roots of challenger - defender on the edge. On the whole curve c there are at most two, and they turn
// opposite ways: crossing from minus to plus along c is a positive turn c x rival. So a change of sign
// between the ends names its root; equal signs leave none or both; an end that is a root names the other.
// Returns whether the edge has been cut.
bool WorkSigns::decide_edge(Index e, FormPair rival) {
    Edge& edge = edges_[e];
    const FormPair c = edge.curve;
    const Index from = half_edges_[2 * e].origin, to = half_edges_[2 * e + 1].origin;

    if (from == none) {
        const std::array<double, 4>& b = edge.bounds.box;
        if (kernel_.lower_bound(rival.f, rival.g, b[0], b[1], b[2], b[3]) > 0) {
            edge.sign = Sign::Positive;
            return false;
        }
        if (kernel_.lower_bound(rival.g, rival.f, b[0], b[1], b[2], b[3]) > 0) {
            edge.sign = Sign::Negative;
            return false;
        }
        // The bottom of the circle is as good a place near it as any.
        const Eigen::Vector2d near =
            std::isfinite(b[2]) ? Eigen::Vector2d(0.5 * b[0] + 0.5 * b[1], b[2]) : Eigen::Vector2d(0, 0);
        if (kernel_.same_curve(c, rival)) {
            edge.sign = Sign::Zero;
            add_ties(edge.ties, {half_edges_[2 * e].label, half_edges_[2 * e + 1].label},
                     challenger_of(rival));
            return false;
        }
        switch (kernel_.intersection_sign(c, rival, near)) {
            case Sign::Negative:
                edge.sign = kernel_.sign_at(kernel_.leftmost_point(c), rival.f, rival.g);
                return false;
            case Sign::Zero: {
                const PointId p = kernel_.touching_point(c, rival);
                const Cut cut{p, true};
                return cut_edge(e, rival, {&cut, 1}, PointStar(kernel_, p).sign_beside_touching(c, rival));
            }
            case Sign::Positive: {
                const Cut cuts[] = {{*kernel_.intersection(c, rival, Sign::Positive, near), false},
                                    {*kernel_.intersection(c, rival, Sign::Negative, near), false}};
                return cut_edge(e, rival, cuts, Sign::Negative);
            }
        }
    }

    const Sign s = vertices_[from].sign, t = vertices_[to].sign;
    const PointId p = vertices_[from].point, q = vertices_[to].point;
    const auto root = [&](Sign turn) { return change_of_sign(e, rival, turn); };
    if (s != Sign::Zero && t != Sign::Zero) {
        if (s != t) {
            const Cut cut = root(t);
            return cut_edge(e, rival, {&cut, 1}, s);
        }
        edge.sign = s;
        if (surely_keeps_sign(e, rival, s)) return false;
        const auto first = first_root(e, rival, s);
        if (!first) return false;
        if (first->touching) return cut_edge(e, rival, {&*first, 1}, s);
        const Cut cuts[] = {*first, root(s)};
        return cut_edge(e, rival, cuts, s);
    }

    // An end is a root. Its turn tells the sign beside it, and whether the other root must lie on the edge.
    if (s == Sign::Zero && t == Sign::Zero && kernel_.same_curve(c, rival)) {
        edge.sign = Sign::Zero;
        add_ties(edge.ties, {half_edges_[2 * e].label, half_edges_[2 * e + 1].label}, challenger_of(rival));
        return false;
    }
    const Sign turn = kernel_.turn_at(s == Sign::Zero ? p : q, c, rival);
    if (turn == Sign::Zero) {
        edge.sign = PointStar(kernel_, s == Sign::Zero ? p : q).sign_beside_touching(c, rival);
    } else if (s == Sign::Zero && t == Sign::Zero && from != to) {
        edge.sign = turn;
    } else if (s == Sign::Zero) {  // also the loop at one vertex: the sign returns to its other side
        edge.sign = turn;
        if (from == to || t != turn) {
            const Cut cut = root(-turn);
            return cut_edge(e, rival, {&cut, 1}, turn);
        }
    } else {
        edge.sign = s;
        if (s == turn) {
            const Cut cut = root(-turn);
            return cut_edge(e, rival, {&cut, 1}, s);
        }
    }
    return false;
}

// Splits e at the cuts, in order along its curve. Parts that a single challenger takes over are as good as
// gone. The sign before the first is given; it changes at every cut that is no touching.
bool WorkSigns::cut_edge(Index e, FormPair rival, std::span<const Cut> cuts, Sign before) {
    const auto stays = [&](Index part) {
        return merging_ || edges_[part].rim || edges_[part].sign != Sign::Negative;
    };
    Sign sign = before;
    const bool closed = half_edges_[2 * e].origin == none;
    for (std::size_t i = 0; i < cuts.size(); ++i) {
        const Cut& cut = cuts[i];
        const Index v = split_edge(e, cut.point, defender_of(rival));
        vertices_[v].stamp = stamp_;
        vertices_[v].sign = Sign::Zero;
        const FormId left = half_edges_[2 * e].label, right = half_edges_[2 * e + 1].label;
        if (edges_[e].ties != none) vertices_[v].ties = copy_ties(edges_[e].ties);
        if (cut.touching || vertices_[v].ties != none)
            add_ties(vertices_[v].ties, {left, right}, challenger_of(rival));
        if (closed && i == 0) {
            // The loop starts after the first cut; a second one ends it.
            if (!cut.touching) sign = -sign;
            edges_[e].sign = sign;
            continue;
        }
        edges_[e].sign = sign;
        if (stays(e)) set_bounds(e);
        if (!cut.touching) sign = -sign;
        e = half_edges_[2 * e].next >> 1;
        edges_[e].sign = sign;
    }
    if (stays(e)) set_bounds(e);
    return true;
}

}  // namespace vcell
