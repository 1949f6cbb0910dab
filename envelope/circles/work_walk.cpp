#include "work_walk.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "../../core/small_vector.hpp"

namespace vcell {

// Let c have no less K than the forms f of the diagram. Each difference c - f is convex then, and so is the
// greatest of them, c less the lower envelope. What c wins and where it ties, together, is a convex set of
// the polygon, hence connected: all faces that it meets are reached from any of its points across edges on
// which c wins or ties. A vertex of it is sought downhill, in doubles, which prove nothing; that a vertex is
// in it is a certified sign. Where c is higher at the end of the way, one inequality may prove it to be
// higher everywhere: for weights l >= 0 that add up to 1, and m >= 0,
//
//     c - min f >= sum l_f (c - f) - sum m_L L      all over the polygon {L >= 0},
//
// a quadratic function, which at the end of a way down is as good as constant if the weights are those of its
// gradients' combination of least length. Where neither is so all faces are looked at.

namespace {

// A face that so many parts have been taken from gets a new box: the old one is larger, and does for a time.
constexpr WorkMesh::Index most_cuts = 3;
// Where one form in so many is sought in all faces, their boxes are kept up.
constexpr std::size_t walks_of_scan = 16;
// More holes of a face are better in several pieces.
constexpr std::size_t most_holes = 16;

}  // namespace

void WorkWalk::clear() {
    WorkFaces::clear();
    scans_ = 0;
    is_holey_ = false;
}

WorkWalk::Index WorkWalk::insert_most_curved(FormId challenger, Index from) {
    duels_.clear();
    inserts_greater_ = false;
    bites_.clear();
    if (++walks_ > walks_of_scan * scans_) are_boxes_current_ = false;
    begin();
    Index end = walk(challenger, from);
    if (vertices_[end].sign != Sign::Positive) {
        if (cut_in(challenger, end)) return half_edges_[2 * new_edges_.front()].origin;
        challenge_from(challenger, end);
    } else {
        if (is_above_diagram(challenger, end)) return end;
        // It wins between vertices, or not at all.
        reached_.clear();
        const KernelForm form = kernel_.form(challenger);
        ++scans_;
        visits_ += faces_.size() / (are_boxes_current_ ? 4 : 1);
        if (!are_boxes_current_) renew_boxes();
        boxes_.challenge(form, [&](Index f) { duels_.push_back({f, challenger, slope_bound(f, form)}); });
        for (Duel& d : duels_) decide_boundary(d);
    }
    if (std::ranges::any_of(duels_, [&](const Duel& d) { return faces_[d.face].inner.size() > most_holes; }))
        is_holey_ = true;
    if (!duels_.empty()) divide_faces();
    return end;
}

// Goes downhill, in doubles, from vertex to vertex along edges, across faces where no edge leads down, until
// challenger - defender is not positive or nothing around is less.
WorkWalk::Index WorkWalk::walk(FormId challenger, Index from) {
    const KernelForm form = kernel_.form(challenger);
    const auto difference = [&](Index v) {
        const Vertex& at = vertices_[v];
        const double dx = at.x - form.cx, dy = at.y - form.cy;
        return (form.k * (dx * dx + dy * dy) + (form.a * at.x + form.b * at.y + form.e)) * form.iw -
               at.height;
    };
    Index v = from, best = from;
    double least = difference(v);
    const auto look_at = [&](Index w) {
        ++visits_;
        if (w == none) return;
        const double height = difference(w);
        if (!(height < least)) return;
        least = height;
        best = w;
    };
    while (least > 0) {
        for_leaving(vertices_[v].out, [&](Index h) { look_at(target(h)); });
        if (best == v)
            for_leaving(vertices_[v].out, [&](Index h) {
                const Index face = half_edges_[h].face;
                if (face == outside || faces_[face].stamp == stamp_) return;
                faces_[face].stamp = stamp_;
                faces_[face].challenged = false;
                for_boundary(faces_[face], [&](Index g) { look_at(half_edges_[g].origin); });
            });
        if (best == v) break;
        v = best;
    }
    Index within = vertices_[v].out;
    while (half_edges_[within].face == outside) within = next_around_origin(within);
    vertex_sign(v, {challenger, half_edges_[within].label});
    return v;
}

// Pre: the challenger wins or ties at v.
void WorkWalk::challenge_from(FormId challenger, Index v) {
    const KernelForm form = kernel_.form(challenger);
    const auto add = [&](Index face) {
        Face& f = faces_[face];
        if (face == outside || (f.stamp == stamp_ && f.challenged)) return;
        f.stamp = stamp_;
        f.challenged = true;
        duels_.push_back({face, challenger, slope_bound(face, form)});
    };
    for_leaving(vertices_[v].out, [&](Index h) { add(half_edges_[h].face); });
    for (std::size_t i = 0; i < duels_.size(); ++i) {
        reached_.clear();
        decide_boundary(duels_[i]);
        for (const Index face : reached_) add(face);
    }
}

// Takes a disc out of the faces around v, each of which has one part left or none: the common case, in which
// the challenger ties with no vertex. What lies outside the polygon has a part taken wherever the challenger
// comes to the rim, which goes on there along the polygon's sides. In other cases nothing is changed.
bool WorkWalk::cut_in(FormId challenger, Index v) {
    bites_.clear();
    const bool is_common = find_bites(challenger, v);
    for (const Bite& b : bites_) faces_[b.face].challenged = false;
    if (!is_common) return false;

    for (const Bite& b : bites_) {
        if (b.leaving == none) continue;
        const Index e = b.leaving >> 1, to = half_edges_[2 * e + 1].origin;
        const FormId site = b.face == outside ? half_edges_[twin(b.leaving)].label : faces_[b.face].site;
        edges_[e].cut = add_vertex(change_of_sign(e, {challenger, site}, vertices_[to].sign).point, site);
    }
    for (const Bite& b : bites_) take_out(b);

    const Index own = add_face(challenger);
    ++live_cycles_;
    new_edges_.clear();
    for (const Bite& b : bites_)
        if (b.leaving != none) add_sides(b, challenger, own);
    for (const Index e : new_edges_) link(2 * e, vertices_[half_edges_[2 * e + 1].origin].out);
    faces_[own].outer = 2 * new_edges_.front();
    for (const Index e : new_edges_) set_bounds(e);
    for (const Bite& b : bites_)
        if (b.leaving != none) edges_[b.leaving >> 1].is_shorter = true;
    const auto renew_box = [&](Index face) {
        Face& f = faces_[face];
        f.cuts = 0;
        f.box = {HUGE_VAL, -HUGE_VAL, HUGE_VAL, -HUGE_VAL};
        for_cycle(f.outer, [&](Index h) { grow(f.box, edges_[h >> 1].bounds.box); });
        set_box(face);
    };
    for (const Bite& b : bites_)
        if (b.leaving != none && b.face != outside && ++faces_[b.face].cuts == most_cuts) renew_box(b.face);
    renew_box(own);
    require_soundness(walks_);
    return true;
}

// Takes out the part of a face's boundary that goes, and the face with it where all of it goes.
void WorkWalk::take_out(const Bite& b) {
    const Index last = b.leaving == none ? faces_[b.face].outer : b.returning;
    Index h = b.leaving == none ? last : next(b.leaving);
    const auto take_vertex = [&](Index w) {
        if (!vertices_[w].alive || vertices_[w].is_corner) return;
        remove_vertex(w);
        --live_vertices_;
    };
    take_vertex(half_edges_[last].origin);
    for (bool is_first = b.leaving == none; is_first || h != last; h = next(h), is_first = false) {
        take_vertex(half_edges_[h].origin);
        if (!edges_[h >> 1].alive) continue;
        remove_edge(h >> 1);
    }
    if (b.leaving != none) return;
    remove_face(b.face);
    --live_cycles_;
}

// Adds the part of a face's boundary along the challenger's own face.
void WorkWalk::add_sides(const Bite& b, FormId challenger, Index own) {
    const bool is_rim = b.face == outside;
    const FormId site = is_rim ? FormId() : faces_[b.face].site;
    const Index start = edges_[b.returning >> 1].cut, end = edges_[b.leaving >> 1].cut;
    FormPair curve = is_rim ? edges_[b.leaving >> 1].curve : FormPair{challenger, site};
    Index last = b.leaving, reached = end;
    const auto add_side = [&](Index from) {
        const Index e = add_edge(curve, from, reached, is_rim);
        half_edges_[2 * e].label = challenger;
        half_edges_[2 * e].face = own;
        half_edges_[2 * e + 1].label = site;
        half_edges_[2 * e + 1].face = b.face;
        link(last, 2 * e + 1);
        vertices_[from].out = 2 * e;
        new_edges_.push_back(e);
        last = 2 * e + 1;
        reached = from;
    };
    half_edges_[twin(b.leaving)].origin = end;
    half_edges_[b.returning].origin = start;
    for (const Corner& c : std::span(corners_).subspan(b.first_corner, b.corners)) {
        vertices_[c.vertex].ties = none;
        set_height(vertices_[c.vertex], challenger);
        add_side(c.vertex);
        curve = c.after;
    }
    add_side(start);
    link(last, b.returning);
    (is_rim ? faces_[outside].inner.front() : faces_[b.face].outer) = last;
}

// Finds the faces where the challenger wins; false where that is no common case.
bool WorkWalk::find_bites(FormId challenger, Index v) {
    const KernelForm& form = kernel_.form(challenger);
    const auto add = [&](Index face) {
        Face& f = faces_[face];
        if (f.stamp == stamp_ && f.challenged) return;
        f.stamp = stamp_;
        f.challenged = true;
        bites_.push_back({face, none, none, 0, 0});
    };
    corners_.clear();
    for_leaving(vertices_[v].out, [&](Index h) {
        if (half_edges_[h].face != outside) add(half_edges_[h].face);
    });
    for (std::size_t i = 0; i < bites_.size(); ++i) {
        const Index face = bites_[i].face;
        const Face& f = faces_[face];
        if (!f.inner.empty() || !f.isolated.empty()) return false;
        const FormPair rival{challenger, f.site};
        const Duel d{face, challenger, slope_bound(face, form)};
        const double K = steepening(rival);
        Index leaving = none, returning = none, h = f.outer, from = half_edges_[h].origin;
        if (from == none) return false;
        Sign s = vertex_sign(from, rival);
        do {
            ++visits_;
            const Index after = next(h), to = half_edges_[after].origin;
            const Sign t = vertex_sign(to, rival);
            if (t == Sign::Zero) return false;
            Edge& edge = edges_[h >> 1];
            if (s != t) {
                Index& crossing = s == Sign::Positive ? leaving : returning;
                if (crossing != none || edge.ties != none) return false;
                crossing = h;
            } else if (edge.stamp != stamp_) {
                const Vertex &p = vertices_[from], &q = vertices_[to];
                if (!steadily_keeps_sign(edge, p, q, d, K)) {
                    const bool is_shorter = edge.is_shorter;
                    if (is_shorter) set_bounds(h >> 1);
                    if (!(is_shorter && steadily_keeps_sign(edge, p, q, d, K)) &&
                        !surely_keeps_sign(h >> 1, rival, s) && first_root(h >> 1, rival, s))
                        return false;
                }
                edge.stamp = stamp_;
                edge.sign = s;
            }
            if ((t == Sign::Negative || s == Sign::Negative) && !edge.rim) add(half_edges_[twin(h)].face);
            s = t;
            from = to;
            h = after;
        } while (h != f.outer);
        if ((leaving == none) != (returning == none)) return false;
        bites_[i].leaving = leaving;
        bites_[i].returning = returning;
    }
    const std::size_t faces = bites_.size();
    bool is_cut = false;
    for (std::size_t i = 0; i < faces; ++i) {
        const Index returning = bites_[i].returning;
        is_cut = is_cut || returning != none;
        if (returning == none || !edges_[returning >> 1].rim) continue;
        Bite b{outside, twin(returning), none, corners_.size(), 0};
        Index h = b.leaving;
        while (vertices_[target(h)].sign == Sign::Negative && vertices_[target(h)].stamp == stamp_) {
            const Index n = next(h);
            if (vertices_[target(h)].is_corner) {
                corners_.push_back({target(h), edges_[n >> 1].curve});
                ++b.corners;
            }
            h = n;
        }
        b.returning = h;
        bites_.push_back(b);
    }
    return is_cut;
}

// Is a challenger that is higher at v than the diagram proved to be so everywhere?
bool WorkWalk::is_above_diagram(FormId challenger, Index v) const {
    constexpr std::size_t most_terms = 8;
    struct Term {
        FormJet jet;
        bool is_form;  // otherwise -L of a side of the polygon
    };
    const double x = vertices_[v].x, y = vertices_[v].y;
    const FormJet c = kernel_.form(challenger).jet(x, y);
    const auto less = [&](const FormJet& f, FormId g) { return f - kernel_.form(g).jet(x, y); };
    SmallVector<Term, most_terms> terms;
    for_leaving(vertices_[v].out, [&](Index h) {
        if (terms.size() + 2 > most_terms) return;
        if (half_edges_[h].face != outside) terms.push_back({less(c, half_edges_[h].label), true});
        const Edge& edge = edges_[h >> 1];
        if (edge.rim) terms.push_back({less(kernel_.form(edge.curve.f).jet(x, y), edge.curve.g), false});
    });

    std::array<double, most_terms> weights{}, best{};
    double least = HUGE_VAL;
    const auto consider = [&](std::initializer_list<std::size_t> which) {
        double gx = 0, gy = 0, sum = 0;
        for (const std::size_t i : which) {
            gx += weights[i] * terms[i].jet.gx;
            gy += weights[i] * terms[i].jet.gy;
            sum += terms[i].is_form ? weights[i] : 0;
        }
        const double square = (gx * gx + gy * gy) / (sum * sum);
        if (!(sum > 0) || !(square < least)) return;
        least = square;
        best = {};
        for (const std::size_t i : which) best[i] = weights[i];
    };
    const auto dot = [&](std::size_t i, std::size_t j) {
        return terms[i].jet.gx * terms[j].jet.gx + terms[i].jet.gy * terms[j].jet.gy;
    };
    const auto cross = [&](std::size_t i, std::size_t j) {
        return terms[i].jet.gx * terms[j].jet.gy - terms[i].jet.gy * terms[j].jet.gx;
    };
    for (std::size_t i = 0; i < terms.size(); ++i) {
        if (!terms[i].is_form) continue;
        weights[i] = 1;
        consider({i});
        for (std::size_t j = 0; j < terms.size(); ++j) {
            const double towards = -dot(i, j), square = dot(j, j);
            if (!terms[j].is_form) {
                weights[i] = 1;
                weights[j] = std::max(0.0, towards / square);
                consider({i, j});
            } else if (j > i) {
                const double own = dot(i, i);
                weights[j] = std::clamp((own + towards) / (own + 2 * towards + square), 0.0, 1.0);
                weights[i] = 1 - weights[j];
                consider({i, j});
            }
            for (std::size_t k = j + 1; k < terms.size(); ++k) {
                if (j == i || k == i) continue;
                const double a = cross(j, k), b = cross(k, i), d = cross(i, j);
                if (!(a > 0 && b > 0 && d > 0) && !(a < 0 && b < 0 && d < 0)) continue;
                weights[i] = std::abs(a);
                weights[j] = std::abs(b);
                weights[k] = std::abs(d);
                consider({i, j, k});
            }
        }
    }

    FormJet sum{};
    for (std::size_t i = 0; i < terms.size(); ++i) {
        const double weight = best[i];
        if (weight == 0) continue;
        const FormJet& j = terms[i].jet;
        sum.v += weight * j.v;
        sum.gx += weight * j.gx;
        sum.gy += weight * j.gy;
        sum.K += weight * j.K;
        // Products and sums of at most three terms are within 4 roundings of these.
        constexpr double rounding = 8 * roundoff::u;
        sum.ev += weight * (j.ev + rounding * std::abs(j.v));
        sum.eg += weight * (j.eg + rounding * std::max(std::abs(j.gx), std::abs(j.gy)));
        sum.eK += weight * (j.eK + rounding * std::abs(j.K));
    }
    sum.ev *= 1 + 64 * roundoff::u;
    sum.eg *= 1 + 64 * roundoff::u;
    sum.eK *= 1 + 64 * roundoff::u;
    const double rx = Interval::up(std::max(box_[1] - x, x - box_[0])),
                 ry = Interval::up(std::max(box_[3] - y, y - box_[2]));
    return sum.lower_bound(rx, ry) > 0;
}

}  // namespace vcell
