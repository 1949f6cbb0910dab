#include "patchwork.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <unordered_map>
#include <utility>

#include "../core/errors.hpp"

namespace vcell {

namespace {

// How often a link is halved to see whether it reaches as far left as another component.
constexpr int most_halvings = 24;

void sort_unique(std::vector<FormId>& forms) {
    std::ranges::sort(forms);
    forms.erase(std::ranges::unique(forms).begin(), forms.end());
}

}  // namespace

// Room for what n forms usually leave, seams included: growing by copies costs more than address space.
Patchwork::Patchwork(const FormFamily& family, const ConvexRegion& region) : family_(family), region_(region) {
    const std::size_t n = family.forms.size() + 16;
    vertices_.reserve(4 * n);
    edges_.reserve(6 * n);
    half_edges_.reserve(12 * n);
    faces_.reserve(2 * n);
}

Patchwork::Index Patchwork::add(const WorkDiagram& piece, std::span<const PieceSide> line_sides) {
    const CircleKernel& kernel = piece.kernel();
    const auto operand = [&](FormId f) {
        Operand o;
        o.form = kernel.family_id(f);
        if (!o.form.valid() && f != CircleKernel::zero_form()) o.line = line_sides[f.value - 1].id;
        return o;
    };
    const auto copy_ties = [&](Index list) {
        if (list == none) return none;
        std::vector<FormId> forms;
        for (const FormId f : piece.ties()[list]) forms.push_back(kernel.family_id(f));
        sort_unique(forms);
        ties_.push_back(std::move(forms));
        return static_cast<Index>(ties_.size() - 1);
    };

    // Faces first: their numbers shift by a constant once the dead ones are skipped.
    std::vector<Index>& face_map = face_map_;
    face_map.assign(piece.faces().size(), none);
    for (Index f = 1; f < piece.faces().size(); ++f) {
        if (!piece.faces()[f].alive) continue;
        face_map[f] = static_cast<Index>(faces_.size());
        faces_.push_back({kernel.family_id(piece.faces()[f].site), face_map[f]});
    }
    std::vector<Index>& vertex_map = vertex_map_;
    vertex_map.assign(piece.vertices().size(), none);
    for (Index v = 0; v < piece.vertices().size(); ++v) {
        const WorkDiagram::Vertex& from = piece.vertices()[v];
        if (!from.alive) continue;
        const KernelPoint& p = kernel.point(from.point);
        vertex_map[v] = static_cast<Index>(vertices_.size());
        Vertex& to = vertices_.emplace_back();
        to.x = p.x;
        to.y = p.y;
        to.error = p.error;
        to.curves = {operand(p.first.f), operand(p.first.g), operand(p.second.f), operand(p.second.g)};
        to.orientation = p.orientation;
        to.ties = copy_ties(from.ties);
        // Some face at the vertex: its form attains the minimum here.
        Index face = from.isolated_in;
        if (from.out != none) {
            Index h = from.out;
            while (piece.half_edges()[h].face == WorkDiagram::outside) h = piece.half_edges()[h].prev ^ 1u;
            face = piece.half_edges()[h].face;
        } else {
            to.isolated_in = face_map[face];
            isolated_.push_back(vertex_map[v]);
        }
        const auto [height, height_error] = kernel.height(piece.faces()[face].site, from.point);
        to.height = height;
        to.height_error = height_error;
    }
    std::vector<Index>& edge_map = edge_map_;
    edge_map.assign(piece.edges().size(), none);
    Index count = static_cast<Index>(edges_.size());
    for (Index e = 0; e < piece.edges().size(); ++e)
        if (piece.edges()[e].alive) edge_map[e] = count++;
    const auto map_half_edge = [&](Index h) { return 2 * edge_map[h >> 1] | (h & 1u); };
    Index handle = none;
    for (Index e = 0; e < piece.edges().size(); ++e) {
        const WorkDiagram::Edge& from = piece.edges()[e];
        if (!from.alive) continue;
        Edge& to = edges_.emplace_back();
        to.left = kernel.family_id(piece.half_edges()[2 * e].label);
        if (from.rim)
            to.side = line_sides[from.curve.g.value - 1].id;
        else
            to.right = kernel.family_id(piece.half_edges()[2 * e + 1].label);
        to.ties = copy_ties(from.ties);
        for (const Index h : {2 * e, 2 * e + 1}) {
            const WorkDiagram::HalfEdge& half = piece.half_edges()[h];
            const Index origin = half.origin == none ? none : vertex_map[half.origin];
            half_edges_.push_back({map_half_edge(half.next), map_half_edge(half.prev), origin, face_map[half.face]});
            if (origin != none) vertices_[origin].out = map_half_edge(h);
            if (half.face == WorkDiagram::outside) handle = map_half_edge(h);
        }
    }
    return handle;
}

// Around a vertex, counter-clockwise, its outgoing half-edges follow each other as the piece lists them; each
// one's twin turns into the one before.
Patchwork::Index Patchwork::add(const MixedPiece& piece, const Heights& heights) {
    const auto first_vertex = static_cast<Index>(vertices_.size());
    const auto first_edge = static_cast<Index>(edges_.size());
    const auto rim = static_cast<Index>(piece.rim.size());
    for (const MixedPiece::Vertex& from : piece.vertices) {
        Vertex& to = vertices_.emplace_back();
        to.x = from.point.x();
        to.y = from.point.y();
        to.error = from.error;
        to.orientation = Sign::Zero;
        if (!from.ties.empty()) {
            std::vector<FormId> forms = from.ties;
            sort_unique(forms);
            to.ties = static_cast<Index>(ties_.size());
            ties_.push_back(std::move(forms));
        }
        const Interval height =
            heights.jet(from.lowest, Interval::ball(to.x, to.error), Interval::ball(to.y, to.error)).v;
        to.height = height.mid();
        to.height_error = Interval::up(std::max(height.upper() - to.height, to.height - height.lower()));
    }
    std::vector<std::vector<Index>> around(piece.vertices.size());
    for (Index i = 0; i < rim; ++i) {
        Edge& e = edges_.emplace_back();
        e.left = piece.rim[i].label;
        e.side = piece.rim[i].side;
        const Index next = (i + 1) % rim;
        half_edges_.push_back({none, none, first_vertex + i, none});
        half_edges_.push_back({none, none, first_vertex + next, none});
        around[i].push_back(2 * (first_edge + i));
    }
    for (const MixedPiece::Arc& a : piece.arcs) {
        Edge& e = edges_.emplace_back();
        e.left = a.left;
        e.right = a.right;
        if (!family_.is_circular(a.left) || !family_.is_circular(a.right)) {
            const MixedPiece::Vertex &p = piece.vertices[a.from], &q = piece.vertices[a.to];
            e.links = static_cast<Index>(links_.size());
            links_.push_back({{p.point, q.point, p.error, q.error, a.direction, piece.box}});
        }
        half_edges_.push_back({none, none, first_vertex + a.from, none});
        half_edges_.push_back({none, none, first_vertex + a.to, none});
    }
    for (Index v = 0; v < around.size(); ++v)
        for (const std::uint32_t h : piece.leaving[v]) around[v].push_back(2 * (first_edge + rim) + h);
    for (Index i = 0; i < rim; ++i) around[i].push_back(2 * (first_edge + (i + rim - 1) % rim) + 1);
    for (Index v = 0; v < around.size(); ++v) {
        const std::vector<Index>& out = around[v];
        vertices_[first_vertex + v].out = out.front();
        for (std::size_t k = 0; k < out.size(); ++k) link(twin(out[k]), out[(k + out.size() - 1) % out.size()]);
    }
    for (Index h = 2 * first_edge; h < half_edges_.size(); ++h) {
        const bool outside = h < 2 * (first_edge + rim) && (h & 1u);
        if (outside || half_edges_[h].face != none) continue;
        const auto f = static_cast<Index>(faces_.size());
        faces_.push_back({left_of(h), f});
        for (Index g = h; half_edges_[g].face == none; g = half_edges_[g].next) {
            if (left_of(g) != faces_[f].site) throw InternalError("labels differ around a face of a piece");
            half_edges_[g].face = f;
        }
    }
    return 2 * first_edge + 1;
}

// The links of `edge` become those of both edges, `other` before or after it.
void Patchwork::join_links(Index edge, Index other, bool other_first, bool reverse_other) {
    if (edges_[edge].links == none) return;
    std::vector<Link>&mine = links_[edges_[edge].links], &theirs = links_[edges_[other].links];
    if (reverse_other) {
        std::ranges::reverse(theirs);
        for (Link& l : theirs) l = l.reversed();
    }
    if (other_first) mine.swap(theirs);
    mine.insert(mine.end(), theirs.begin(), theirs.end());
    theirs = {};
}

Patchwork::Index Patchwork::find(Index f) {
    while (faces_[f].parent != f) f = faces_[f].parent = faces_[faces_[f].parent].parent;
    return f;
}

void Patchwork::merge_faces(Index f, Index g) {
    f = find(f);
    g = find(g);
    if (faces_[f].site != faces_[g].site) throw InternalError("labels differ across a seam at face f" + std::to_string(f));
    faces_[std::max(f, g)].parent = std::min(f, g);
}

// The half-edges along the seam, in their order on the outer boundary.
std::vector<Patchwork::Index> Patchwork::side_chain(Index outer, std::uint32_t seam) const {
    const auto on_seam = [&](Index h) { return edges_[h >> 1].side == seam; };
    Index h = outer;
    while (on_seam(h)) h = half_edges_[h].prev;
    const Index stop = h;
    do {
        h = half_edges_[h].next;
        if (h == stop) throw InternalError("a piece does not reach its seam");
    } while (!on_seam(h));
    std::vector<Index> chain;
    for (; on_seam(h); h = half_edges_[h].next) chain.push_back(h);
    return chain;
}

// Turn the seam upright, the first piece on its left. On the outside the first piece's chain runs down,
// the second's up. At a vertex of the seam let a_1, ..., a_p be the first piece's half-edges that leave it,
// counter-clockwise from the seam's upper half, and b_1, ..., b_q the second's from the lower half. Their
// rotation in the union is a_1 .. a_p b_1 .. b_q: only the turns a_p -> b_1 and b_q -> a_1 are new.
Patchwork::Index Patchwork::glue(Index piece, Index other, std::uint32_t seam) {
    const std::vector<Index> down = side_chain(piece, seam), up = side_chain(other, seam);
    const std::size_t k = down.size();
    if (up.size() != k) throw InternalError("a seam has " + std::to_string(k) + " edges on one side and " +
                                            std::to_string(up.size()) + " on the other");
    const auto first = [&](std::size_t j) { return twin(down[j]); };          // runs up on the left
    const auto second = [&](std::size_t j) { return twin(up[k - 1 - j]); };   // runs down on the right
    for (std::size_t j = 0; j < k; ++j) merge_faces(half_edges_[first(j)].face, half_edges_[second(j)].face);

    const Index top_before = half_edges_[down[0]].prev, top_after = half_edges_[up[k - 1]].next;
    const Index bottom_before = half_edges_[up[0]].prev, bottom_after = half_edges_[down[k - 1]].next;
    struct Junction {
        Index kept, other, outgoing, face;
    };
    std::vector<Junction> junctions;
    junctions.reserve(k + 1);
    for (std::size_t j = 0; j <= k; ++j) {
        Junction v{j < k ? half_edges_[down[j]].origin : target(down[k - 1]),
                   j < k ? target(up[k - 1 - j]) : half_edges_[up[0]].origin, none, half_edges_[first(j < k ? j : k - 1)].face};
        // Below: the first piece's last half-edge a_p, and the one that arrives along b_1; above: b_q, a_1.
        const Index a_last = j < k ? half_edges_[first(j)].next : none;
        const Index b_first = j < k ? half_edges_[second(j)].prev : none;
        const Index a_first = j > 0 ? half_edges_[first(j - 1)].prev : none;
        const Index b_last = j > 0 ? half_edges_[second(j - 1)].next : none;
        const bool no_a = j > 0 && j < k && a_last == first(j - 1), no_b = j > 0 && j < k && b_last == second(j);
        if (j == 0) {
            link(b_first, a_last);
            v.outgoing = a_last;
        } else if (j == k) {
            link(a_first, b_last);
            v.outgoing = b_last;
        } else if (no_a && !no_b) {
            link(b_first, b_last);
            v.outgoing = b_last;
        } else if (no_b && !no_a) {
            link(a_first, a_last);
            v.outgoing = a_last;
        } else if (!no_a) {
            link(b_first, a_last);
            link(a_first, b_last);
            v.outgoing = a_last;
        }
        junctions.push_back(v);
    }
    link(top_before, top_after);
    link(bottom_before, bottom_after);
    for (std::size_t j = 0; j < k; ++j) edges_[down[j] >> 1].alive = edges_[up[j] >> 1].alive = false;
    for (const Junction& v : junctions) unite_vertices(v.kept, v.other, v.outgoing, v.face);
    for (const Junction& v : junctions) smooth(v.kept);
    for (const Index h : {top_before, top_after, bottom_before, bottom_after})
        if (edges_[h >> 1].alive) return h;
    throw InternalError("a glued piece has no outer edge");
}

void Patchwork::unite_vertices(Index kept, Index other, Index outgoing, Index face) {
    vertices_[other].alive = false;
    Vertex& v = vertices_[kept];
    v.out = outgoing;
    if (vertices_[other].ties != none) {
        if (v.ties == none) {
            v.ties = vertices_[other].ties;
        } else {
            std::vector<FormId>& forms = ties_[v.ties];
            forms.insert(forms.end(), ties_[vertices_[other].ties].begin(), ties_[vertices_[other].ties].end());
            sort_unique(forms);
        }
    }
    if (outgoing == none) {
        // Nothing crosses or touches the seam here but, perhaps, a form that ties at this one point.
        if (v.ties == none || ties_[v.ties].size() < 2) {
            v.alive = false;
        } else {
            v.isolated_in = face;
            isolated_.push_back(kept);
        }
        return;
    }
    Index h = outgoing;
    do {
        half_edges_[h].origin = kept;
        h = twin(half_edges_[h].prev);
    } while (h != outgoing);
}

std::vector<FormId> Patchwork::label_of_edge(Index e) const {
    std::vector<FormId> forms;
    if (edges_[e].ties != none) forms = ties_[edges_[e].ties];
    for (const FormId f : {edges_[e].left, edges_[e].right})
        if (f.valid()) forms.push_back(f);
    sort_unique(forms);
    return forms;
}

// Removes v if it only continues one arc: two edges of one curve and one label, and nothing else that
// attains the minimum at v.
void Patchwork::smooth(Index v) {
    if (!vertices_[v].alive || vertices_[v].out == none) return;
    const Index h = vertices_[v].out, g = twin(half_edges_[h].prev);
    if (g == h || twin(half_edges_[g].prev) != h) return;
    const Index e = h >> 1, f = g >> 1;
    if (edges_[e].side != edges_[f].side || left_of(h) != left_of(twin(g)) || left_of(twin(h)) != left_of(g)) return;
    if (vertices_[v].ties != none || edges_[e].ties != none || edges_[f].ties != none) {
        const std::vector<FormId> label = label_of_edge(e);
        if (label != label_of_edge(f)) return;
        if (vertices_[v].ties != none && !std::ranges::includes(label, ties_[vertices_[v].ties])) return;
    }
    vertices_[v].alive = false;
    if (e == f) {  // the last vertex of a closed curve
        half_edges_[h].origin = half_edges_[g].origin = none;
        return;
    }
    const Index start = target(g);
    // The joined edge runs along h from `start`: half-edge 2e is h, or h's twin.
    join_links(e, f, (h & 1u) == 0, (h & 1u) == (g & 1u));
    half_edges_[h].origin = start;
    link(half_edges_[twin(g)].prev, h);
    link(twin(h), half_edges_[g].next);
    if (vertices_[start].out == twin(g)) vertices_[start].out = h;
    edges_[f].alive = false;
}

// The component that reaches farthest left: of a face's components, its outer one.
std::size_t Patchwork::leftmost(std::span<const Index> components) const {
    CircleKernel kernel;
    kernel.reset(&family_);
    std::unordered_map<std::uint32_t, FormId> local_forms, local_lines;
    const auto local = [&](const Operand& o) {
        if (o.form.valid()) {
            const auto [it, is_new] = local_forms.try_emplace(o.form.value);
            if (is_new) it->second = kernel.add_form(o.form);
            return it->second;
        }
        if (o.line == UINT32_MAX) return CircleKernel::zero_form();
        const auto [it, is_new] = local_lines.try_emplace(o.line);
        const ConvexRegion::Side& s = o.line & seam_bit ? seams_[o.line & ~seam_bit] : region_.sides[o.line];
        if (is_new) it->second = kernel.add_line(s.a, s.b, s.c);
        return it->second;
    };
    std::unordered_map<Index, PointId> points;
    const auto point = [&](Index v) {
        const auto [it, is_new] = points.try_emplace(v);
        if (is_new) {
            const Vertex& from = vertices_[v];
            const FormPair first{local(from.curves[0]), local(from.curves[1])};
            const FormPair second{local(from.curves[2]), local(from.curves[3])};
            if (first == second)
                it->second = from.orientation == Sign::Negative ? kernel.leftmost_point(first) : kernel.rightmost_point(first);
            else if (from.orientation == Sign::Zero)
                it->second = kernel.touching_point(first, second);
            else
                it->second = kernel.intersection(first, second, from.orientation, {from.x, from.y}).value();
        }
        return it->second;
    };

    std::size_t best = 0;
    PointId leftmost_point;
    for (std::size_t i = 0; i < components.size(); ++i) {
        const auto consider = [&](PointId p) {
            if (leftmost_point.valid() && kernel.compare_xy(p, leftmost_point) != Sign::Negative) return;
            leftmost_point = p;
            best = i;
        };
        Index h = components[i];
        do {
            const Index from = half_edges_[h].origin;
            if (from != none) consider(point(from));
            const Edge& edge = edges_[h >> 1];
            if (edge.right.valid()) {
                const FormPair c{local({left_of(h)}), local({left_of(twin(h))})};
                if (kernel.curvature_sign(c) != Sign::Zero) {
                    const PointId extreme = kernel.leftmost_point(c);
                    if (from == none || kernel.strictly_between(c, point(from), point(target(h)), extreme)) consider(extreme);
                }
            }
            h = half_edges_[h].next;
        } while (h != components[i]);
    }
    return best;
}

// Of a face's boundary components, its outer one.
std::size_t Patchwork::outermost(std::span<const Index> components) const {
    if (family_.cylinders.empty()) return leftmost(components);
    const Heights heights(family_);
    // The one with the leftmost known point; no other may reach as far.
    std::vector<double> known;
    for (const Index c : components) known.push_back(left_end(c, heights, -HUGE_VAL)[1]);
    const std::size_t best = std::ranges::min_element(known) - known.begin();
    bool certain = true;
    for (std::size_t i = 0; i < components.size() && certain; ++i)
        certain = i == best || left_end(components[i], heights, known[best])[0] > known[best];
    if (certain) return best;
    throw UndecidedError("which of a face's boundaries is the outer one");
}

// Encloses the x of the component's leftmost point, looking closer as long as it might lie left of `target`.
std::array<double, 2> Patchwork::left_end(Index component, const Heights& heights, double target) const {
    std::array<double, 2> end{HUGE_VAL, HUGE_VAL};
    const auto consider = [&](double lower, double upper) {
        end = {std::min(end[0], lower), std::min(end[1], upper)};
    };
    Index h = component;
    do {
        if (const Index v = half_edges_[h].origin; v != none)
            consider(Interval::down(vertices_[v].x - vertices_[v].error), Interval::up(vertices_[v].x + vertices_[v].error));
        const Edge& e = edges_[h >> 1];
        if (e.links != none) {
            for (const Link& l : links_[e.links])
                consider(left_bound(l, e.left, e.right, heights, target, most_halvings), Interval::up(l.to.x() + l.to_error));
        } else if (e.right.valid()) {
            const Interval left = left_end_of_circle(h);
            consider(left.lower(), half_edges_[h].origin == none ? left.upper() : HUGE_VAL);
        }
        h = half_edges_[h].next;
    } while (h != component);
    return end;
}

// A lower bound for x on the link. Along u across `direction` the arc's offset w in that direction changes by
// at most sigma |du|: between two of its points at distance U it keeps within sigma U / 2 of their rectangle.
double Patchwork::left_bound(const Link& link, FormId left, FormId right, const Heights& heights, double target, int halvings) {
    const Eigen::Vector2d d = link.direction, across(-d.y(), d.x());
    const double lower = std::min(link.from.x() - link.from_error, link.to.x() - link.to_error);
    const Interval U = Interval(std::abs((link.to - link.from).dot(across))) * Interval(1 + 1e-15) +
                       Interval(link.from_error) + Interval(link.to_error);
    const std::array<double, 4> box = {
        std::max(link.box[0], lower - U.upper() - (link.to - link.from).norm()), link.box[1], link.box[2], link.box[3]};
    const auto [gx, gy] = heights.gradient_difference(left, right, {box[0], box[1]}, {box[2], box[3]});
    const Interval along = Interval(d.x()) * gx + Interval(d.y()) * gy,
                   beside = Interval(across.x()) * gx + Interval(across.y()) * gy;
    if (!(along.lower() > 0)) return link.box[0];
    const double bound = Interval::down(lower - ((Interval(beside.magnitude()) / Interval(along.lower())) * U).upper());
    if (halvings == 0 || std::max(bound, link.box[0]) > target) return std::max(bound, link.box[0]);
    // Half-way across, the arc's point by the false position that certainly brackets it.
    const Eigen::Vector2d middle = 0.5 * (link.from + link.to);
    double w = 0, step = HUGE_VAL;
    const auto difference = [&](double offset) {
        const Eigen::Vector2d p = middle + offset * d;
        const HeightJet<Interval> f = heights.jet(left, Interval(p.x()), Interval(p.y())),
                                  g = heights.jet(right, Interval(p.x()), Interval(p.y()));
        return std::pair(f.v - g.v, Interval(d.x()) * (f.gx - g.gx) + Interval(d.y()) * (f.gy - g.gy));
    };
    for (int i = 0; i < 20; ++i) {
        const auto [v, slope] = difference(w);
        const double move = v.mid() / slope.mid();
        if (!(std::abs(move) < 0.5 * step)) break;
        w -= move;
        step = std::abs(move);
    }
    const double error = (Interval(difference(w).first.magnitude()) / Interval(along.lower())).upper() +
                         4 * std::numeric_limits<double>::epsilon() * middle.norm();
    const Eigen::Vector2d p = middle + w * d;
    const Link first{link.from, p, link.from_error, error, d, link.box}, second{p, link.to, error, link.to_error, d, link.box};
    return std::max(bound, std::min(left_bound(first, left, right, heights, target, halvings - 1),
                                    left_bound(second, left, right, heights, target, halvings - 1)));
}

// Encloses the least x along an edge between two circular forms, its ends excepted.
Interval Patchwork::left_end_of_circle(Index h) const {
    const auto ball = [](double v) { return Interval::ball(v, 2 * std::numeric_limits<double>::epsilon() * std::abs(v)); };
    const CircularForm &f = family_.forms[left_of(h)], &g = family_.forms[left_of(twin(h))];
    const Interval wf = ball(f.w), wg = ball(g.w);
    // f - g = K |p|^2 - 2 (K c) p + ...
    const Interval K = Interval(f.k) / wf - Interval(g.k) / wg;
    const auto center = [&](double cf, double af, double cg, double ag) {
        const Interval gradient = (Interval(2.0) * Interval(f.k) * Interval(cf) - ball(af)) / wf -
                                  (Interval(2.0) * Interval(g.k) * Interval(cg) - ball(ag)) / wg;
        return gradient / (Interval(2.0) * K);
    };
    const Index from = half_edges_[h].origin, to = target(h);
    if (!K.sign() || *K.sign() == Sign::Zero) {  // nearly straight: far less than its chord away from it
        const Vertex &p = vertices_[from], &q = vertices_[to];
        const double chord = std::hypot(p.x - q.x, p.y - q.y) + p.error + q.error;
        return {std::min(p.x - p.error, q.x - q.error) - chord, std::min(p.x + p.error, q.x + q.error)};
    }
    const Interval cx = center(f.cx, f.a, g.cx, g.a), cy = center(f.cy, f.b, g.cy, g.b);
    if (from == none) {  // r^2 = c^2 - C / K
        const auto constant = [&](const CircularForm& form, Interval w) {
            return (Interval(form.k) * (square(Interval(form.cx)) + square(Interval(form.cy))) + ball(form.e)) / w;
        };
        const Interval r2 = square(cx) + square(cy) - (constant(f, wf) - constant(g, wg)) / K;
        return cx - sqrt(Interval(std::max(0.0, r2.lower()), std::max(0.0, r2.upper())));
    }
    // Counter-clockwise the arc passes the leftmost point when it comes from the upper half and ends in the lower
    // one, or returns to the half it started from. Where doubles cannot tell, it may.
    const Vertex &p = vertices_[*K.sign() == Sign::Positive ? from : to], &q = vertices_[*K.sign() == Sign::Positive ? to : from];
    const Interval px = Interval::ball(p.x, p.error), py = Interval::ball(p.y, p.error), qx = Interval::ball(q.x, q.error),
                   qy = Interval::ball(q.y, q.error);
    const auto sp = (py - cy).sign(), sq = (qy - cy).sign(), dx = (qx - px).sign();
    const bool passes_by = sp && sq && dx &&
                           ((*sp == Sign::Negative && *sq == Sign::Positive) || (*sp == *sq && *dx == -*sp));
    const Interval ends(std::min(px.lower(), qx.lower()), std::min(px.upper(), qx.upper()));
    if (passes_by) return ends;
    return {(cx - sqrt(square(px - cx) + square(py - cy))).lower(), ends.upper()};
}

MinimizationDiagram Patchwork::finish() {
    MinimizationDiagram out;
    out.region = region_;
    out.forms = family_.forms;
    out.cylinders = family_.cylinders;

    std::vector<Index> vertex_map(vertices_.size(), none), edge_map(edges_.size(), none), face_map(faces_.size(), none);
    const auto alive_edges = static_cast<std::size_t>(std::ranges::count_if(edges_, &Edge::alive));
    const auto alive_vertices = static_cast<std::size_t>(std::ranges::count_if(vertices_, &Vertex::alive));
    out.dcel.reserve(alive_vertices, alive_edges, faces_.size() + 1);
    out.vertices.reserve(alive_vertices);
    out.edges.reserve(alive_edges);
    out.face_forms.push_back({});
    for (Index v = 0; v < vertices_.size(); ++v) {
        if (!vertices_[v].alive) continue;
        vertex_map[v] = out.dcel.add_vertex().value;
        const Vertex& from = vertices_[v];
        out.vertices.push_back({{from.x, from.y}, from.error, from.height, from.height_error});
    }
    for (Index e = 0; e < edges_.size(); ++e) {
        if (!edges_[e].alive) continue;
        const Index from = half_edges_[2 * e].origin, to = half_edges_[2 * e + 1].origin;
        edge_map[e] = out.dcel.add_edge(from == none ? VertexId{} : VertexId{vertex_map[from]},
                                        to == none ? VertexId{} : VertexId{vertex_map[to]}).value;
        out.edges.push_back({edges_[e].left, edges_[e].right, edges_[e].side});
        if (family_.cylinders.empty()) continue;
        out.piece_offsets_.push_back(static_cast<std::uint32_t>(out.pieces_.size()));
        if (edges_[e].links == none) continue;
        for (const Link& l : links_[edges_[e].links]) out.pieces_.push_back({l.to, l.to_error, l.direction, l.box});
    }
    if (!family_.cylinders.empty()) out.piece_offsets_.push_back(static_cast<std::uint32_t>(out.pieces_.size()));
    const auto half_edge = [&](Index h) { return HalfEdgeId{2 * edge_map[h >> 1] | (h & 1u)}; };
    for (Index h = 0; h < half_edges_.size(); ++h)
        if (edges_[h >> 1].alive) out.dcel.link(half_edge(h), half_edge(half_edges_[h].next));

    // Boundary components by face, as linked lists; only a face with several needs to know which one is outer.
    std::vector<bool> seen(half_edges_.size());
    std::vector<Index> first_start(faces_.size(), none), next_start;
    std::vector<Index> component_start;
    std::vector<Index> outside;
    for (Index h = 0; h < half_edges_.size(); ++h) {
        if (!edges_[h >> 1].alive || seen[h]) continue;
        for (Index g = h; !seen[g]; g = half_edges_[g].next) seen[g] = true;
        if (half_edges_[h].face == none) {
            outside.push_back(h);
            continue;
        }
        Index& first = first_start[find(half_edges_[h].face)];
        next_start.push_back(first);
        first = static_cast<Index>(component_start.size());
        component_start.push_back(h);
    }
    for (const Index h : outside) out.dcel.add_inner_ccb(Dcel::unbounded_face(), half_edge(h));
    std::vector<Index> starts;
    for (Index f = 0; f < faces_.size(); ++f) {
        if (first_start[f] == none) continue;
        starts.clear();
        for (Index c = first_start[f]; c != none; c = next_start[c]) starts.push_back(component_start[c]);
        const FaceId id = out.dcel.add_face();
        face_map[f] = id.value;
        out.face_forms.push_back(faces_[f].site);
        const std::size_t outer = starts.size() == 1 ? 0 : outermost(starts);
        out.dcel.add_outer_ccb(id, half_edge(starts[outer]));
        for (std::size_t j = 0; j < starts.size(); ++j)
            if (j != outer) out.dcel.add_inner_ccb(id, half_edge(starts[j]));
    }
    for (const Index v : isolated_)
        if (vertices_[v].alive)
            out.dcel.add_isolated_vertex(FaceId{face_map[find(vertices_[v].isolated_in)]}, VertexId{vertex_map[v]});

    // Labels: the faces around, and whatever else ties.
    std::vector<FormId> label;
    std::vector<std::uint32_t> sides;
    out.vertex_offsets_.push_back(0);
    out.side_offsets_.push_back(0);
    for (Index v = 0; v < vertices_.size(); ++v) {
        if (!vertices_[v].alive) continue;
        label.clear();
        sides.clear();
        if (vertices_[v].ties != none) label = ties_[vertices_[v].ties];
        if (const Index start = vertices_[v].out; start != none) {
            Index h = start;
            do {
                if (left_of(h).valid()) label.push_back(left_of(h));
                if (edges_[h >> 1].side != UINT32_MAX) sides.push_back(edges_[h >> 1].side);
                h = twin(half_edges_[h].prev);
            } while (h != start);
        }
        sort_unique(label);
        std::ranges::sort(sides);
        sides.erase(std::ranges::unique(sides).begin(), sides.end());
        out.vertex_labels_.insert(out.vertex_labels_.end(), label.begin(), label.end());
        out.vertex_sides_.insert(out.vertex_sides_.end(), sides.begin(), sides.end());
        out.vertex_offsets_.push_back(static_cast<std::uint32_t>(out.vertex_labels_.size()));
        out.side_offsets_.push_back(static_cast<std::uint32_t>(out.vertex_sides_.size()));
    }
    out.edge_offsets_.push_back(0);
    for (Index e = 0; e < edges_.size(); ++e) {
        if (!edges_[e].alive) continue;
        label.clear();
        if (edges_[e].ties != none) label = ties_[edges_[e].ties];
        for (const FormId f : {edges_[e].left, edges_[e].right})
            if (f.valid()) label.push_back(f);
        sort_unique(label);
        out.edge_labels_.insert(out.edge_labels_.end(), label.begin(), label.end());
        out.edge_offsets_.push_back(static_cast<std::uint32_t>(out.edge_labels_.size()));
    }
    return out;
}

}  // namespace vcell
