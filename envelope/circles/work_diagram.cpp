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

constexpr double infinity = std::numeric_limits<double>::infinity();

// Centre and half sides of a box, the sides rounded up.
std::array<double, 4> middle(const std::array<double, 4>& box) {
    const double x = 0.5 * box[0] + 0.5 * box[1], y = 0.5 * box[2] + 0.5 * box[3];
    return {x, y, Interval::up(std::max(box[1] - x, x - box[0])),
            Interval::up(std::max(box[3] - y, y - box[2]))};
}

void grow(std::array<double, 4>& box, const std::array<double, 4>& by) {
    box = {std::min(box[0], by[0]), std::max(box[1], by[1]), std::min(box[2], by[2]),
           std::max(box[3], by[3])};
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
            const Index v = half_edges_[g].origin, before = half_edges_[g].prev,
                        after = half_edges_[twin(g)].next;
            if (after == g && merging_ && vertices_[v].ties != none && ties_[vertices_[v].ties].size() > 1) {
                // An isolated point of one diagram that lay on an edge of the other.
                vertices_[v].out = none;
                isolated_.push_back(v);
                --live_vertices_;
            } else if (after == g) {
                vertices_[v].alive = false;
                free_vertices_.push_back(v);
                --live_vertices_;
            } else {
                vertices_[v].out = after;
                link(before, after);
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
    half_edges_[n].label = half_edges_[h].label;
    half_edges_[n].face = half_edges_[h].face;
    half_edges_[n + 1].label = half_edges_[t].label;
    half_edges_[n + 1].face = half_edges_[t].face;
    const Index after = half_edges_[h].next, before = half_edges_[t].prev;
    half_edges_[t].origin = v;
    link(n, after);
    link(h, n);
    link(before, n + 1);
    link(n + 1, t);
    vertices_[v].out = n;
    if (vertices_[end].out == t) vertices_[end].out = n + 1;
    edges_[n >> 1].ties = copy_ties(edges_[e].ties);
    edges_[n >> 1].challenger_ties = edges_[e].challenger_ties;
    edges_[n >> 1].stamp = edges_[e].stamp;
    return v;
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
    set_center(faces_[f]);
}

void WorkDiagram::set_center(Face& f) const {
    const auto [x, y, rx, ry] = middle(f.box);
    f.x = x;
    f.y = y;
    f.rx = rx;
    f.ry = ry;
    f.place = CircleKernel::place(kernel_.form(f.site), f.x, f.y, f.rx, f.ry);
}

// --- One merge -----------------------------------------------------------------------------------------

void WorkDiagram::insert(FormId challenger) {
    duels_.clear();
    const CircleKernel::Form form = kernel_.form(challenger);
    for (Index f = 1; f < faces_.size(); ++f) {
        const Face& face = faces_[f];
        if (!face.alive) continue;
        if (!CircleKernel::certainly_above(form, face.place, face.x, face.y, face.rx, face.ry))
            duels_.push_back({f, challenger});
    }
    if (!duels_.empty()) resolve();
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
                vertex.alive = false;
                free_vertices_.push_back(v);
            }
        }
        f.alive = false;
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
            set_center(face);
        }
    } else {
        nest_cycles();
    }
}

void WorkDiagram::decide_boundary(Duel& d) {
    const Face& f = faces_[d.face];
    const FormPair rival{d.challenger, f.site};
    for_boundary(f, [&](Index h) {
        const Index v = half_edges_[h].origin;
        if (v != none && vertex_sign(v, rival) != Sign::Positive) d.met = true;
    });
    for (const Index v : f.isolated) vertex_sign(v, rival);
    for_boundary(f, [&](Index h) {
        Edge& edge = edges_[h >> 1];
        if (edge.stamp != stamp_) {
            edge.stamp = stamp_;
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
    const CircleKernel::Place b = CircleKernel::place(kernel_.form(rival.f), p.x, p.y, p.error, p.error);
    vertex.slope_x = b.gx;
    vertex.slope_y = b.gy;
    const double difference = b.v - vertex.height;
    // b.top - b.v: its change over the point's uncertainty.
    vertex.margin =
        std::abs(difference) - 1.01 * (b.top - b.v + vertex.height_error) - 64 * DBL_EPSILON * b.scale;
    if (vertex.margin > 0) {
        ++kernel_.decisions().by_double;
        vertex.sign = sign_of(difference);
        return vertex.sign;
    }
    vertex.sign = kernel_.sign_at(vertex.point, rival.f, rival.g);
    if (vertex.sign == Sign::Zero) {
        Index h = vertex.out;
        if (h == none) {
            add_ties(vertex.ties, {}, rival.f);
            return vertex.sign;
        }
        do {
            add_ties(vertex.ties, {half_edges_[h].label}, rival.f);
            h = twin(half_edges_[h].prev);
        } while (h != vertex.out);
    }
    return vertex.sign;
}

// Do the values at the ends alone prove that challenger - defender keeps their common sign along the edge?
// Let g = F of the rivals, m the smaller |g| of the two ends, l the chord and s the sagitta. On the chord g
// is a parabola of second derivative 2 K, so |g| >= m - |K| l^2 / 4; the arc leaves it by s, and g changes on
// the way by at most |grad g| s + |K| s^2, where |grad g| <= |grad g(end)| + 2 |K| l.
bool WorkDiagram::keeps_sign(Index e, FormPair rival) const {
    const Vertex &v = vertices_[half_edges_[2 * e].origin], &w = vertices_[half_edges_[2 * e + 1].origin];
    const CircleKernel::Form &b = kernel_.form(rival.f), &a = kernel_.form(rival.g);
    const KernelPoint& p = kernel_.point(v.point);
    const double l = edges_[e].bounds.chord, s = edges_[e].bounds.sagitta;
    const double ax = (2 * a.k * (p.x - a.cx) + a.a) * a.iw, ay = (2 * a.k * (p.y - a.cy) + a.b) * a.iw;
    double bx = v.slope_x, by = v.slope_y;
    if (merging_) {  // they may be another challenger's
        bx = (2 * b.k * (p.x - b.cx) + b.a) * b.iw;
        by = (2 * b.k * (p.y - b.cy) + b.b) * b.iw;
    }
    const double slope =
        std::abs(bx - ax) + std::abs(by - ay) +
        1e-12 * (std::abs(bx) + std::abs(ax) + std::abs(by) + std::abs(ay) +
                 (b.K * (std::abs(p.x) + std::abs(p.y)) + a.K * (std::abs(p.x) + std::abs(p.y))));
    const double K = std::abs(b.K - a.K) + 1e-12 * (std::abs(b.K) + std::abs(a.K));
    return std::min(v.margin, w.margin) > (K * (0.25 * l * l + 2 * l * s + s * s) + slope * s) * (1 + 1e-9);
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
            add_ties(edge.ties, {half_edges_[2 * e].label, half_edges_[2 * e + 1].label}, rival.f);
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
    const Eigen::Vector2d near =
        0.5 * (Eigen::Vector2d(at(from).x, at(from).y) + Eigen::Vector2d(at(to).x, at(to).y));
    const auto root = [&](Sign turn) {
        const auto r = kernel_.intersection(c, rival, turn, near);
        if (!r) throw InternalError("no root of a sign change on edge e" + std::to_string(e));
        return Cut{*r, false};
    };
    if (s != Sign::Zero && t != Sign::Zero) {
        if (s != t) {
            const Cut cut = root(t);
            return cut_edge(e, rival, {&cut, 1}, s);
        }
        edge.sign = s;
        if (keeps_sign(e, rival)) return false;
        const auto [x, y, rx, ry] = middle(edge.bounds.box);
        const CircleKernel::Place b = CircleKernel::place(kernel_.form(rival.f), x, y, rx, ry);
        const CircleKernel::Place a = CircleKernel::place(kernel_.form(rival.g), x, y, rx, ry);
        if (s == Sign::Positive ? CircleKernel::certainly_above(b, a, rx, ry)
                                : CircleKernel::certainly_above(a, b, rx, ry))
            return false;
        // Two lines cross once, and then the signs at the ends would differ.
        if (edge.rim && kernel_.curvature_sign(rival) == Sign::Zero) return false;
        auto first = kernel_.certain_intersection(c, rival, -s, near);
        if (!first) {
            switch (kernel_.intersection_sign(c, rival, near)) {
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
        add_ties(edge.ties, {half_edges_[2 * e].label, half_edges_[2 * e + 1].label}, rival.f);
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
        const Index v = split_edge(e, cut.point, rival.g);
        vertices_[v].stamp = stamp_;
        vertices_[v].sign = Sign::Zero;
        const FormId left = half_edges_[2 * e].label, right = half_edges_[2 * e + 1].label;
        if (edges_[e].ties != none) vertices_[v].ties = copy_ties(edges_[e].ties);
        if (cut.touching || vertices_[v].ties != none) add_ties(vertices_[v].ties, {left, right}, rival.f);
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

// --- Arcs inside a face -------------------------------------------------------------------------------

void WorkDiagram::divide_face(Duel& d) {
    if (!d.met && !merging_) {
        insert_island(d, Sign::Positive);
        return;
    }
    const Face& f = faces_[d.face];
    const FormPair rival{d.challenger, f.site};
    bool positive = false, negative = false, root = false;
    const std::size_t first_touched = touched_.size();
    for_boundary(f, [&](Index h) {
        touched_.push_back(h);
        const Sign s = edges_[h >> 1].sign;
        positive = positive || s == Sign::Positive;
        negative = negative || s == Sign::Negative;
        const Index v = half_edges_[h].origin;
        root = root || s == Sign::Zero || (v != none && vertices_[v].sign == Sign::Zero);
    });
    const std::size_t boundary_end = touched_.size();
    branches_.clear();
    if (root) {
        find_branches(f.outer, rival);
        for (const Index h : f.inner) find_branches(h, rival);
    }
    d.changed = negative || !branches_.empty();
    if (!positive && !negative)  // bounded by the trisector alone
        d.changed = winner(f.outer, d) == d.challenger;
    d.changed = d.changed || merging_;
    if (!d.changed) {
        touched_.resize(first_touched);
        return;
    }
    for (std::size_t i = first_touched; i < boundary_end; ++i)
        half_edges_[touched_[i]].label = winner(touched_[i], d);
    if (root) {
        insert_arcs(rival);
        thread_isolated(d.face, boundary_end);
    } else {
        insert_island(d, edges_[f.outer >> 1].sign);
    }
}

// Who wins beside half-edge h of the face, on its left.
FormId WorkDiagram::winner(Index h, const Duel& d) {
    const FormId site = faces_[d.face].site;
    switch (edges_[h >> 1].sign) {
        case Sign::Negative: return d.challenger;
        case Sign::Positive: return site;
        case Sign::Zero: break;
    }
    const FormPair c = directed(h), rival{d.challenger, site};
    const Index v = half_edges_[h].origin;
    const bool along = v == none ? kernel_.curvature_sign(c) == kernel_.curvature_sign(rival)
                                 : kernel_.same_direction(vertices_[v].point, c, rival);
    return along ? d.challenger : site;
}

// At a root vertex the boundary arrives by h and leaves by next(h); the face fills the sector that runs
// counter-clockwise from the leaving half-edge back to the arriving one. If the signs on the two differ,
// exactly one of the trisector's two branches lies in the sector, and the sign left of it is that of h.
// Otherwise none or both do, or an edge itself is one: ask for each branch.
void WorkDiagram::find_branches(Index cycle, FormPair rival) {
    for_cycle(cycle, [&](Index h) {
        const Index v = target(h);
        if (v == none || vertices_[v].sign != Sign::Zero) return;
        const Index n = half_edges_[h].next;
        const Sign in = edges_[h >> 1].sign, out = edges_[n >> 1].sign;
        if (in != Sign::Zero && out != Sign::Zero && in != out) {
            branches_.push_back({h, v, in == Sign::Negative});
            return;
        }
        // A trisector that is a single point has no branches.
        if (kernel_.radius_sign(rival) == Sign::Zero) return;
        const PointId p = vertices_[v].point;
        const FormPair from = directed(n), to = directed(twin(h));
        const bool leaves = kernel_.branch_in_sector(p, from, rival, to);
        const bool arrives = kernel_.branch_in_sector(p, from, rival.reversed(), to);
        // Counter-clockwise from n: beside a winning edge the challenger's region ends first.
        const bool start_first = out == Sign::Positive;
        if (leaves && start_first) branches_.push_back({h, v, true});
        if (arrives) branches_.push_back({h, v, false});
        if (leaves && !start_first) branches_.push_back({h, v, true});
    });
}

// Each start is joined with the first end that the trisector meets from there.
void WorkDiagram::insert_arcs(FormPair rival) {
    if (branches_.empty()) return;
    const auto starts = std::ranges::count_if(branches_, &Branch::start);
    if (2 * starts != static_cast<std::ptrdiff_t>(branches_.size()))
        throw InternalError("a trisector enters a face " + std::to_string(starts) + " times and leaves it " +
                            std::to_string(static_cast<std::ptrdiff_t>(branches_.size()) - starts) +
                            " times");
    const bool several = starts > 1;
    const bool line = several && kernel_.curvature_sign(rival) == Sign::Zero;
    for (Branch& s : branches_) {
        if (!s.start) continue;
        const PointId p = vertices_[s.vertex].point;
        Branch* first = nullptr;
        for (Branch& t : branches_) {
            if (t.start) continue;
            const PointId q = vertices_[t.vertex].point;
            if (line && !kernel_.precedes_on_line(rival, p, q)) continue;
            if (!first || kernel_.strictly_between(rival, p, vertices_[first->vertex].point, q)) first = &t;
        }
        if (!first || first->half_edge != none) throw InternalError("a trisector's arc has no end");
        const Index e = add_edge(rival, s.vertex, first->vertex, false);
        edges_[e].stamp = stamp_;
        half_edges_[2 * e].label = rival.f;
        half_edges_[2 * e + 1].label = rival.g;
        s.half_edge = 2 * e;
        first->half_edge = 2 * e + 1;
        set_bounds(e);
        touched_.push_back(2 * e);
        touched_.push_back(2 * e + 1);
    }
    // Branches of one corner follow each other counter-clockwise from the leaving boundary edge: arriving
    // along one turns into the one before.
    for (std::size_t i = 0; i < branches_.size();) {
        const Index corner = branches_[i].corner;
        Index leaving = half_edges_[corner].next;
        for (; i < branches_.size() && branches_[i].corner == corner; ++i) {
            link(twin(branches_[i].half_edge), leaving);
            leaving = branches_[i].half_edge;
        }
        link(corner, leaving);
    }
}

// The trisector does not meet the face's boundary. It may still be a circle inside, around some of the holes
// or none: then the loser of the outer boundary wins inside the circle, or touches in a single point.
void WorkDiagram::insert_island(Duel& d, Sign boundary) {
    const Face& f = faces_[d.face];
    const FormPair rival{d.challenger, f.site};
    if (kernel_.curvature_sign(rival) != boundary || kernel_.circle_leaves_box(rival, f.box)) return;
    const Sign radius = kernel_.radius_sign(rival);
    if (radius == Sign::Negative) return;
    if (radius == Sign::Zero &&
        std::ranges::any_of(f.isolated, [&](Index v) { return vertices_[v].sign == Sign::Zero; }))
        return;  // the point is known already
    const PointId p = radius == Sign::Zero ? kernel_.center_point(rival) : kernel_.leftmost_point(rival);
    if (!face_contains(f, p)) return;
    if (radius == Sign::Zero) {
        const Index v = add_vertex(p, f.site);
        --live_vertices_;
        add_ties(vertices_[v].ties, {f.site}, d.challenger);
        vertices_[v].stamp = stamp_;
        vertices_[v].isolated_in = d.face;
        faces_[d.face].isolated.push_back(v);
        return;
    }
    const Index e = add_edge(rival, none, none, false);
    ++live_vertices_;
    link(2 * e, 2 * e);
    link(2 * e + 1, 2 * e + 1);
    half_edges_[2 * e].label = rival.f;
    half_edges_[2 * e + 1].label = rival.g;
    set_bounds(e);
    if (!d.met && !merging_ && f.inner.empty() && f.isolated.empty()) {
        // The common case at once: a new face in a hole of the old one.
        live_cycles_ += 2;
        const Index inside = add_face(d.challenger);
        faces_[inside].outer = 2 * e;
        faces_[inside].box = edges_[e].bounds.box;
        set_center(faces_[inside]);
        half_edges_[2 * e].face = inside;
        half_edges_[2 * e + 1].face = d.face;
        faces_[d.face].inner.push_back(2 * e + 1);
        return;
    }
    if (!d.changed) {
        d.changed = true;
        for_boundary(f, [&](Index h) { touched_.push_back(h); });
    }
    const std::size_t first_new = touched_.size();
    touched_.push_back(2 * e);
    touched_.push_back(2 * e + 1);
    thread_isolated(d.face, first_new);
}

// Isolated vertices of the face through which the trisector runs become vertices of its new edges, those of
// touched_ from first_new on.
void WorkDiagram::thread_isolated(Index face, std::size_t first_new) {
    std::erase_if(faces_[face].isolated, [&](Index v) {
        if (vertices_[v].stamp != stamp_ || vertices_[v].sign != Sign::Zero) return false;
        const PointId p = vertices_[v].point;
        for (std::size_t i = first_new; i < touched_.size(); i += 2) {
            const Index e = touched_[i] >> 1, from = half_edges_[2 * e].origin,
                        to = half_edges_[2 * e + 1].origin;
            if (from != none &&
                !kernel_.strictly_between(edges_[e].curve, vertices_[from].point, vertices_[to].point, p))
                continue;
            const Index w = split_edge(e, p, half_edges_[2 * e].label), n = vertices_[w].out >> 1;
            vertices_[w].ties = vertices_[v].ties;
            vertices_[w].stamp = stamp_;
            set_bounds(e);
            if (n != e) {
                set_bounds(n);
                touched_.push_back(2 * n);
                touched_.push_back(2 * n + 1);
            }
            vertices_[v].alive = false;
            free_vertices_.push_back(v);
            return true;
        }
        return false;
    });
}

void WorkDiagram::remove_inner_edges() {
    for (const Index h : touched_) {
        const Index e = h >> 1;
        if (edges_[e].alive && half_edges_[2 * e].label == half_edges_[2 * e + 1].label) kill_edge(e);
    }
    if (merging_) {
        for (Index v = 0; v < vertices_.size(); ++v) smooth(v);
        return;
    }
    // On the rim, where no edge goes, vertices between equal labels do.
    for (const Index h : touched_) {
        const Index e = h >> 1;
        if (!edges_[e].alive || !edges_[e].rim || edges_[e].stamp != stamp_) continue;
        if (edges_[e].sign == Sign::Negative) edges_[e].ties = none;
        while (vertices_[target(h)].sign == Sign::Negative) {
            if (edges_[half_edges_[h].next >> 1].curve == edges_[e].curve) {
                join_rim_edges(h);
                continue;
            }
            Vertex& corner = vertices_[target(h)];
            corner.ties = none;
            set_height(corner, half_edges_[h].label);
            break;
        }
    }
}

// Lets rim half-edge h run on over its successor, and drops the vertex between them.
void WorkDiagram::join_rim_edges(Index h) {
    const Index n = half_edges_[h].next, v = half_edges_[n].origin, end = target(n);
    half_edges_[twin(h)].origin = end;
    link(h, half_edges_[n].next);
    link(half_edges_[twin(n)].prev, twin(h));
    if (vertices_[end].out == twin(n)) vertices_[end].out = twin(h);
    vertices_[v].alive = false;
    free_vertices_.push_back(v);
    --live_vertices_;
    edges_[n >> 1].alive = false;
    free_edges_.push_back(n >> 1);
    --live_edges_;
    set_bounds(h >> 1);
}

// Collects the new boundary components of all changed faces into cycles_.
void WorkDiagram::rebuild_faces() {
    cycles_.clear();
    for (const Index h : touched_) {
        if (!edges_[h >> 1].alive) continue;
        half_edges_[h].face = none;
        Edge& edge = edges_[h >> 1];
        // The edge may separate others than before, tied all along it.
        if (!edge.rim) edge.curve = {half_edges_[h & ~1u].label, half_edges_[h | 1u].label};
    }
    for (const Index h : touched_) {
        if (!edges_[h >> 1].alive || half_edges_[h].face != none) continue;
        cycles_.push_back(h);
        for_cycle(h, [&](Index g) { half_edges_[g].face = outside; });
    }
    live_cycles_ += static_cast<long>(cycles_.size());
}

// --- Islands ---------------------------------------------------------------------------------------------

// Finds which of the new components bound faces from outside, and in which face each of the others, and
// each isolated vertex, lies.
void WorkDiagram::nest_cycles() {
    std::vector<Index> outer, inner;
    for (const Index c : cycles_) (is_outer_cycle(c) ? outer : inner).push_back(c);
    for (const Index c : outer) {
        const Index f = add_face(half_edges_[c].label);
        faces_[f].outer = c;
        for_cycle(c, [&](Index h) {
            half_edges_[h].face = f;
            grow(faces_[f].box, edges_[h >> 1].bounds.box);
        });
        set_center(faces_[f]);
    }
    const auto face_around = [&](PointId p, FormId label) {
        // Faces inside an island may pass through p as well: they carry another label, or touch at p only.
        const auto candidate = [&](Index c) {
            if (label.valid() && half_edges_[c].label != label) return false;
            bool through = false;
            for_cycle(c, [&](Index h) {
                through =
                    through || (half_edges_[h].origin != none && vertices_[half_edges_[h].origin].point == p);
            });
            return !through && cycle_contains(c, p);
        };
        Index best = none;
        for (const Index c : outer)
            if (candidate(c) && (best == none || cycle_contains(best, point_on(c)))) best = c;
        if (best == none) throw InternalError("an island lies in no face");
        return half_edges_[best].face;
    };
    for (const Index c : inner) {
        const Index f = face_around(point_on(c), half_edges_[c].label);
        faces_[f].inner.push_back(c);
        for_cycle(c, [&](Index h) { half_edges_[h].face = f; });
    }
    for (const Index v : isolated_) {
        Vertex& vertex = vertices_[v];
        const Index f = face_around(vertex.point, {});
        vertex.isolated_in = f;
        faces_[f].isolated.push_back(v);
    }
}

PointId WorkDiagram::point_on(Index cycle) {
    const Index v = half_edges_[cycle].origin;
    return v != none ? vertices_[v].point : kernel_.leftmost_point(directed(cycle));
}

// The face lies right of the cycle's leftmost point if the cycle bounds it from outside, left of it if it
// is an island in it.
bool WorkDiagram::is_outer_cycle(Index cycle) {
    if (half_edges_[cycle].origin == none) return kernel_.curvature_sign(directed(cycle)) == Sign::Positive;
    PointId leftmost;
    bool on_arc = false, outer = false;
    double right_of_some = infinity;  // some point of the cycle lies left of here
    for_cycle(cycle, [&](Index h) {
        const KernelPoint& p = at(half_edges_[h].origin);
        right_of_some = std::min(right_of_some, Interval::up(p.x + p.error));
    });
    for_cycle(cycle, [&](Index h) {
        if (edges_[h >> 1].bounds.box[0] > right_of_some) return;
        const Index v = half_edges_[h].origin, w = target(h);
        const PointId p = vertices_[v].point;
        if (!leftmost.valid() || (p != leftmost && kernel_.compare_xy(p, leftmost) == Sign::Negative)) {
            leftmost = p;
            on_arc = false;
        }
        const FormPair c = directed(h);
        const Sign K = kernel_.curvature_sign(c);
        if (K == Sign::Zero) return;
        const PointId extreme = kernel_.leftmost_point(c);
        if (!kernel_.strictly_between(c, p, vertices_[w].point, extreme)) return;
        if (kernel_.compare_xy(extreme, leftmost) == Sign::Negative) {
            leftmost = extreme;
            on_arc = true;
            outer = K == Sign::Positive;
        }
    });
    if (on_arc) return outer;
    // At a vertex: inner if a corner's sector contains the direction to the left. All edges leave to the
    // right (or straight up), so a sector does unless it turns left from its first edge to its last.
    bool inner = false;
    for_cycle(cycle, [&](Index h) {
        if (vertices_[target(h)].point != leftmost) return;
        inner =
            inner || kernel_.sector_contains_left(leftmost, directed(half_edges_[h].next), directed(twin(h)));
    });
    return !inner;
}

bool WorkDiagram::cycle_contains(Index cycle, PointId p) {
    int crossings = 0;
    for_cycle(cycle, [&](Index h) { crossings += crossings_above(h >> 1, p); });
    return crossings % 2 == 1;
}

bool WorkDiagram::face_contains(const Face& f, PointId p) {
    int crossings = 0;
    for_boundary(f, [&](Index h) { crossings += crossings_above(h >> 1, p); });
    return crossings % 2 == 1;
}

// How often the open vertical ray upwards from p crosses the edge; p does not lie on it. An x-monotone
// piece counts its left end and not its right one.
int WorkDiagram::crossings_above(Index e, PointId p) {
    const KernelPoint& at_p = kernel_.point(p);
    const std::array<double, 4>& box = edges_[e].bounds.box;
    if (box[1] < at_p.x - at_p.error || box[0] > at_p.x + at_p.error || box[3] < at_p.y - at_p.error)
        return 0;
    const FormPair c = edges_[e].curve;
    const Index from = half_edges_[2 * e].origin, to = half_edges_[2 * e + 1].origin;
    const auto left_of_or_at = [&](PointId q) { return kernel_.compare_x(q, p) != Sign::Positive; };
    const Sign K = kernel_.curvature_sign(c);
    if (K == Sign::Zero) {
        const PointId a = vertices_[from].point, b = vertices_[to].point;
        if (left_of_or_at(a) == left_of_or_at(b)) return 0;
        // Above the line {F = 0}, F = A x + B y + C, F has the sign of B; B has that of -dx along it.
        const Sign B = left_of_or_at(a) ? Sign::Negative : Sign::Positive;
        return kernel_.sign_at(p, c.f, c.g) == -B ? 1 : 0;
    }
    const Sign side = kernel_.side_of_center(p, c), distance = K * kernel_.sign_at(p, c.f, c.g);
    // Is p below the lower half (below the upper half) of the circle, where they have p's x?
    const bool below_lower = distance == Sign::Positive && side == Sign::Negative;
    const bool below_upper = distance == Sign::Negative || side == Sign::Negative ||
                             (distance == Sign::Zero && side != Sign::Positive);
    const PointId left = kernel_.leftmost_point(c), right = kernel_.rightmost_point(c);
    int count = 0;
    const auto piece = [&](PointId a, PointId b, bool upper) {
        if (left_of_or_at(a) != left_of_or_at(b) && (upper ? below_upper : below_lower)) ++count;
    };
    if (from == none) {
        piece(left, right, false);
        piece(right, left, true);
        return count;
    }
    // Counter-clockwise from a to b.
    PointId a = vertices_[from].point, b = vertices_[to].point;
    FormPair ccw = c;
    if (K == Sign::Negative) {
        std::swap(a, b);
        ccw = c.reversed();
    }
    const bool has_left = kernel_.strictly_between(ccw, a, b, left),
               has_right = kernel_.strictly_between(ccw, a, b, right);
    if (has_left && has_right) {
        const bool left_first = kernel_.strictly_between(ccw, a, right, left);
        if (left_first) {
            piece(a, left, true);
            piece(left, right, false);
            piece(right, b, true);
        } else {
            piece(a, right, false);
            piece(right, left, true);
            piece(left, b, false);
        }
    } else if (has_left) {
        piece(a, left, true);
        piece(left, b, false);
    } else if (has_right) {
        piece(a, right, false);
        piece(right, b, true);
    } else {
        // Within one half: the lower one is run to the right, the upper one to the left.
        piece(a, b, kernel_.compare_x(a, b) == Sign::Positive);
    }
    return count;
}

}  // namespace vcell
