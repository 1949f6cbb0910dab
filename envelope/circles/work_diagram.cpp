#include "work_diagram.hpp"

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

#include "../../core/errors.hpp"

namespace vcell {

namespace {

// Relative to the sum of all terms, some twenty roundings.
constexpr double rounding_margin = 1e-12;

// Slopes across a chord are divided by its length, which is known from above alone (CircleKernel::ArcBounds).
constexpr double slope_margin = 1e-5;

// Centre and half sides of a box, the sides rounded up.
std::array<double, 4> middle(const std::array<double, 4>& box) {
    const double x = 0.5 * box[0] + 0.5 * box[1], y = 0.5 * box[2] + 0.5 * box[3];
    return {x, y, Interval::up(std::max(box[1] - x, x - box[0])),
            Interval::up(std::max(box[3] - y, y - box[2]))};
}

}  // namespace

// --- Elements ----------------------------------------------------------------------------------------

WorkDiagram::Index WorkDiagram::add_vertex(PointId p, FormId lowest) {
    Index v;
    if (free_vertices_.empty()) {
        v = static_cast<Index>(vertices_.size());
        vertices_.emplace_back();
    } else {
        v = free_vertices_.back();
        free_vertices_.pop_back();
        vertices_[v] = Vertex{};
    }
    vertices_[v].point = p;
    set_height(vertices_[v], lowest);
    ++live_vertices_;
    return v;
}

void WorkDiagram::set_height(Vertex& v, FormId lowest) const {
    const auto [height, error] = kernel_.height(lowest, v.point);
    v.height = height;
    v.height_error = error;
}

WorkDiagram::Index WorkDiagram::add_edge(FormPair curve, Index from, Index to, bool rim) {
    Index e;
    if (free_edges_.empty()) {
        e = static_cast<Index>(edges_.size());
        edges_.emplace_back();
        half_edges_.resize(half_edges_.size() + 2);
    } else {
        e = free_edges_.back();
        free_edges_.pop_back();
        edges_[e] = Edge{};
    }
    edges_[e].curve = curve;
    edges_[e].rim = rim;
    half_edges_[2 * e] = {none, none, from, none, {}};
    half_edges_[2 * e + 1] = {none, none, to, none, {}};
    ++live_edges_;
    return e;
}

WorkDiagram::Index WorkDiagram::add_face(FormId site) {
    Index f;
    if (free_faces_.empty()) {
        f = static_cast<Index>(faces_.size());
        faces_.emplace_back();
        boxes_.resize(faces_.size());
    } else {
        f = free_faces_.back();
        free_faces_.pop_back();
        Face& face = faces_[f];
        face.inner.clear();
        face.isolated.clear();
        face.alive = true;
    }
    faces_[f].site = site;
    faces_[f].outer = none;
    faces_[f].box = {infinity, -infinity, infinity, -infinity};
    return f;
}

void WorkDiagram::set_bounds(Index e) {
    const Index from = half_edges_[2 * e].origin, to = half_edges_[2 * e + 1].origin;
    if (from == none)
        edges_[e].bounds = {kernel_.circle_box(edges_[e].curve), infinity, infinity};
    else
        edges_[e].bounds = kernel_.arc_bounds(edges_[e].curve, vertices_[from].point, vertices_[to].point);
}

// Takes the edge out of the rotations at its ends; a vertex that keeps no edge goes with it.
void WorkDiagram::kill_edge(Index e) {
    const Index h = 2 * e, t = h + 1;
    if (half_edges_[h].origin == none) {
        --live_vertices_;
    } else {
        for (const Index g : {h, t}) {
            const Index v = half_edges_[g].origin, after = detach(g);
            if (after == none && merging_ && vertices_[v].ties != none &&
                ties_[vertices_[v].ties].size() > 1) {
                // An isolated point of one diagram that lay on an edge of the other.
                vertices_[v].out = none;
                isolated_.push_back(v);
                --live_vertices_;
            } else if (after == none) {
                remove_vertex(v);
                --live_vertices_;
            } else {
                vertices_[v].out = after;
            }
        }
    }
    edges_[e].alive = false;
    free_edges_.push_back(e);
    --live_edges_;
}

// e keeps the part before p, the new edge takes the part after it. A closed edge becomes a loop at p and
// no edge is added. Returns the vertex.
WorkDiagram::Index WorkDiagram::split_edge(Index e, PointId p, FormId lowest) {
    const Index v = add_vertex(p, lowest);
    if (half_edges_[2 * e].origin == none) {
        --live_vertices_;  // the closed edge's own
        half_edges_[2 * e].origin = half_edges_[2 * e + 1].origin = v;
        vertices_[v].out = 2 * e;
        return v;
    }
    const Index h = 2 * e, t = h + 1, end = half_edges_[t].origin;
    const Index n = 2 * add_edge(edges_[e].curve, v, end, edges_[e].rim);
    split(h, v, n);
    vertices_[v].out = n;
    if (vertices_[end].out == t) vertices_[end].out = n + 1;
    edges_[n >> 1].ties = copy_ties(edges_[e].ties);
    edges_[n >> 1].challenger_ties = edges_[e].challenger_ties;
    edges_[n >> 1].stamp = edges_[e].stamp;
    return v;
}

void WorkDiagram::remove_vertex(Index v) {
    vertices_[v].alive = false;
    free_vertices_.push_back(v);
}

// Lets h run on over its successor, and drops the vertex between them.
void WorkDiagram::join_with_next(Index h) {
    const Index n = next(h), v = half_edges_[n].origin, end = target(n);
    join(h);
    if (vertices_[end].out == twin(n)) vertices_[end].out = twin(h);
    remove_vertex(v);
    --live_vertices_;
    edges_[n >> 1].alive = false;
    free_edges_.push_back(n >> 1);
    --live_edges_;
    set_bounds(h >> 1);
}

void WorkDiagram::add_ties(Index& list, std::initializer_list<FormId> present, FormId tied) {
    if (list == none) {
        list = static_cast<Index>(ties_.size());
        ties_.emplace_back();
    }
    std::vector<FormId>& forms = ties_[list];
    for (const FormId f : present)
        if (f.valid() && std::ranges::find(forms, f) == forms.end()) forms.push_back(f);
    if (std::ranges::find(forms, tied) == forms.end()) forms.push_back(tied);
}

WorkDiagram::Index WorkDiagram::copy_ties(Index list) {
    if (list == none) return none;
    ties_.push_back(std::vector<FormId>(ties_[list]));
    return static_cast<Index>(ties_.size() - 1);
}

void WorkDiagram::clear() {
    vertices_.clear();
    half_edges_.clear();
    edges_.clear();
    faces_.clear();
    boxes_.clear();
    ties_.clear();
    free_vertices_.clear();
    free_edges_.clear();
    free_faces_.clear();
    live_vertices_ = live_edges_ = live_cycles_ = 0;
    stamp_ = 0;
    merging_ = false;
}

void WorkDiagram::start(std::span<const FormId> lines, FormId site) {
    clear();
    live_cycles_ = 2;
    const auto n = static_cast<Index>(lines.size());
    const auto side = [&](Index i) { return FormPair{CircleKernel::zero_form(), lines[i % n]}; };
    for (Index i = 0; i < n; ++i) {
        const auto corner = kernel_.intersection(side(i + n - 1), side(i), Sign::Positive, {0, 0});
        if (!corner)
            throw InternalError("the region's sides " + std::to_string(i) + " and its neighbour do not meet");
        add_vertex(*corner, site);
    }
    add_face({});
    const Index f = add_face(site);
    for (Index i = 0; i < n; ++i) {
        const Index e = add_edge(side(i), i, (i + 1) % n, true);
        half_edges_[2 * e].label = site;
        half_edges_[2 * e].face = f;
        half_edges_[2 * e + 1].face = outside;
        vertices_[i].out = 2 * e;
        set_bounds(e);
        grow(faces_[f].box, edges_[e].bounds.box);
    }
    for (Index i = 0; i < n; ++i) {
        link(2 * i, 2 * ((i + 1) % n));
        link(2 * ((i + 1) % n) + 1, 2 * i + 1);
    }
    faces_[f].outer = 0;
    faces_[outside].inner.push_back(1);
    set_box(f);
    require_soundness();
}

// In builds with asserts: of what every change leaves.
void WorkDiagram::require_soundness() const {
#ifndef NDEBUG
    if (const auto defect = find_defect([&](Index e) { return edges_[e].alive; }))
        throw InternalError("a diagram of circular forms: " + *defect);
    for (Index h = 0; h < half_edges_.size(); ++h)
        if (edges_[h >> 1].alive && half_edges_[h].face != outside &&
            half_edges_[h].label != faces_[half_edges_[h].face].site)
            throw InternalError("half-edge h" + std::to_string(h) + " has another label than its face");
#endif
}

// Pre: the boundary of the face is complete.
void WorkDiagram::set_box(Index face) {
    const Face& f = faces_[face];
    const auto [x, y, rx, ry] = middle(f.box);
    boxes_.set(face, kernel_.form(f.site), x, y, rx, ry);
}

// --- One merge -----------------------------------------------------------------------------------------

void WorkDiagram::insert(FormId challenger) {
    duels_.clear();
    const CircleKernel::Form form = kernel_.form(challenger);
    inserts_greater_ = is_floor(challenger);
    const auto add = [&](Index f) {
        duels_.push_back({f, challenger, boxes_.slope_bound(f, form, kernel_.form(faces_[f].site))});
    };
    if (inserts_greater_) {
        for (Index f = 1; f < faces_.size(); ++f)
            if (faces_[f].alive) add(f);
    } else {
        boxes_.challenge(form, add);
    }
    if (!duels_.empty()) resolve();
    inserts_greater_ = false;
}

// Signs are those of challenger - defender: negative where the challenger wins. First every boundary is
// cut where the sign changes; then arcs are inserted face by face; then labels decide which edges stay.
void WorkDiagram::resolve() {
    ++stamp_;
    touched_.clear();
    isolated_.clear();
    for (Duel& d : duels_) decide_boundary(d);
    if (merging_) unite_ties();
    const long components_before = component_count();
    bool plain = true;  // no changed face has holes or isolated vertices
    for (Duel& d : duels_) {
        divide_face(d);
        if (!d.changed) continue;
        const Face& f = faces_[d.face];
        live_cycles_ -= 1 + static_cast<long>(f.inner.size());
        plain = plain && f.inner.empty() && f.isolated.empty();
    }
    if (touched_.empty()) return;
    remove_inner_edges();

    for (const Duel& d : duels_) {
        if (!d.changed) continue;
        Face& f = faces_[d.face];
        for (const Index v : f.isolated) {
            Vertex& vertex = vertices_[v];
            const bool stays = merging_ ? vertex.ties != none && ties_[vertex.ties].size() > 1
                                        : vertex.stamp != stamp_ || vertex.sign != Sign::Negative;
            if (stays) {
                isolated_.push_back(v);
            } else {
                remove_vertex(v);
            }
        }
        f.alive = false;
        boxes_.remove(d.face);
        f.isolated.clear();
        free_faces_.push_back(d.face);
    }
    rebuild_faces();
    const long components = component_count();
    if (isolated_.empty() && (components == 1 || (plain && components == components_before))) {
        for (const Index c : cycles_) {
            const Index f = add_face(half_edges_[c].label);
            Face& face = faces_[f];
            face.outer = c;
            for_cycle(c, [&](Index h) {
                half_edges_[h].face = f;
                grow(face.box, edges_[h >> 1].bounds.box);
            });
            set_box(f);
        }
    } else {
        nest_cycles();
    }
    require_soundness();
}

void WorkDiagram::decide_boundary(Duel& d) {
    const Face& f = faces_[d.face];
    const FormPair rival = rivals(d.challenger, f.site);
    const double Kb = kernel_.form(rival.f).K, Ka = kernel_.form(rival.g).K;
    const double K = std::abs(Kb - Ka) + rounding_margin * (std::abs(Kb) + std::abs(Ka));
    for_boundary(f, [&](Index h) {
        const Index v = half_edges_[h].origin;
        if (v != none && vertex_sign(v, rival) != Sign::Positive) d.met = true;
    });
    for (const Index v : f.isolated) vertex_sign(v, rival);
    for_boundary(f, [&](Index h) {
        Edge& edge = edges_[h >> 1];
        if (edge.stamp != stamp_) {
            edge.stamp = stamp_;
            const Index from = half_edges_[h].origin;
            if (from != none && steadily_keeps_sign(edge, vertices_[from], vertices_[target(h)], d, K))
                edge.sign = vertices_[from].sign;
            else
                d.met = decide_edge(h >> 1, rival) || d.met;
        }
        d.met = d.met || edges_[h >> 1].sign != Sign::Positive;
    });
}

Sign WorkDiagram::vertex_sign(Index v, FormPair rival) {
    Vertex& vertex = vertices_[v];
    if (vertex.stamp == stamp_) return vertex.sign;
    vertex.stamp = stamp_;
    const KernelPoint& p = kernel_.point(vertex.point);
    const FormId challenger = challenger_of(rival);
    const CircleKernel::BoxForm b =
        CircleKernel::box_form(kernel_.form(challenger), p.x, p.y, p.error, p.error);
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
bool WorkDiagram::steadily_keeps_sign(const Edge& edge, const Vertex& v, const Vertex& w, const Duel& d,
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
bool WorkDiagram::keeps_sign(Index e, FormPair rival, Sign common) const {
    const Vertex &v = vertices_[half_edges_[2 * e].origin], &w = vertices_[half_edges_[2 * e + 1].origin];
    const double m = v.margin, n = w.margin;
    if (!(m > 0 && n > 0)) return false;  // a slower rung told the sign
    const CircleKernel::Form &b = kernel_.form(rival.f), &a = kernel_.form(rival.g);
    const KernelPoint &p = kernel_.point(v.point), &q = kernel_.point(w.point);
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

// The roots of challenger - defender on the edge. On the whole curve c there are at most two, and they turn
// opposite ways: crossing from minus to plus along c is a positive turn c x rival. So a change of sign
// between the ends names its root; equal signs leave none or both; an end that is a root names the other.
// Returns whether the edge has been cut.
bool WorkDiagram::decide_edge(Index e, FormPair rival) {
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
                return cut_edge(e, rival, {&cut, 1}, kernel_.sign_beside_touching(p, c, rival));
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
    const auto near = [&] {
        return Eigen::Vector2d(0.5 * (at(from).x + at(to).x), 0.5 * (at(from).y + at(to).y));
    };
    const auto root = [&](Sign turn) {
        const auto r = kernel_.intersection(c, rival, turn, near());
        if (!r) throw InternalError("no root of a sign change on edge e" + std::to_string(e));
        return Cut{*r, false};
    };
    if (s != Sign::Zero && t != Sign::Zero) {
        if (s != t) {
            const Cut cut = root(t);
            return cut_edge(e, rival, {&cut, 1}, s);
        }
        edge.sign = s;
        if (keeps_sign(e, rival, s)) return false;
        const auto [x, y, rx, ry] = middle(edge.bounds.box);
        const CircleKernel::BoxForm b = CircleKernel::box_form(kernel_.form(rival.f), x, y, rx, ry);
        const CircleKernel::BoxForm a = CircleKernel::box_form(kernel_.form(rival.g), x, y, rx, ry);
        if (s == Sign::Positive ? CircleKernel::certainly_above(b, a, rx, ry)
                                : CircleKernel::certainly_above(a, b, rx, ry))
            return false;
        // Two lines cross once, and then the signs at the ends would differ.
        if (edge.rim && kernel_.curvature_sign(rival) == Sign::Zero) return false;
        auto first = kernel_.certain_intersection(c, rival, -s, near());
        if (!first) {
            switch (kernel_.intersection_sign(c, rival, near())) {
                case Sign::Negative: return false;
                case Sign::Zero: {
                    const Cut cut{kernel_.touching_point(c, rival), true};
                    return kernel_.strictly_between(c, p, q, cut.point) && cut_edge(e, rival, {&cut, 1}, s);
                }
                case Sign::Positive:
                    if (kernel_.curvature_sign(c) == Sign::Zero &&
                        kernel_.curvature_sign(rival) == Sign::Zero)
                        return false;
                    first = root(-s).point;
            }
        }
        if (!kernel_.strictly_between(c, p, q, *first)) return false;
        const Cut cuts[] = {{*first, false}, root(s)};
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
        edge.sign = kernel_.sign_beside_touching(s == Sign::Zero ? p : q, c, rival);
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
bool WorkDiagram::cut_edge(Index e, FormPair rival, std::span<const Cut> cuts, Sign before) {
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
