/// A brute-force judge of minimization diagrams over sphere and cylinder bases. It shares no code with the
/// engine but the types, the frame and the chart: whoever is nearest at a base point is found from the
/// distance functions along its normal, and which face holds the point by winding numbers of traced edges.
///
/// A chart of the base in the complex plane serves for winding: over a sphere the stereographic chart itself,
/// over a cylinder exp(i theta - y), with y scaled. Moving along a closed curve, arg((z - p) / (z - q)) turns
/// by 2 pi for each time that the curve has p rather than q on its left.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <map>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include "radial_structure_oracle.hpp"

namespace vcell::radial {

struct Options {
    int samples = rounds() > 1 ? 150 : 50;  ///< pairs of base points whose faces are compared
};

class Judge : public StructureOracle {
public:
    using StructureOracle::StructureOracle;

    /// What is wrong; empty if nothing was found.
    std::vector<std::string> check(std::mt19937_64& rng, const Options& options = {}) {
        check_structure();
        if (!complaints_.empty()) return complaints_;  // what follows walks the structure
        for (const VertexId v : d_.vertices.ids()) check_vertex(v);
        for (const EdgeId e : d_.edges.ids()) trace(e);
        if (!complaints_.empty()) return complaints_;  // what follows builds on the traces
        for (int i = 0; i < options.samples; ++i) check_faces(sample(rng), sample(rng));
        return complaints_;
    }

private:
    // A point of an edge: chart coordinates, and the arc's parameter (circles: the angle; pieces: their
    // number).
    struct Node {
        Fast x, y, s;
        Complex z;
    };
    struct Circle {  // on the sphere: u = offset + cos(s) e1 + sin(s) e2
        Vector offset, e1, e2;
    };
    struct Trace {
        std::vector<Node> nodes;
        std::optional<Circle> circle;
    };

    // --- Charts

    Complex chart(Fast x, Fast y) const {
        if (is_over_sphere()) return {x, y};
        const Fast theta = x > 1 ? std::numbers::pi_v<Fast> + 2 * std::atan(x - 2) : 2 * std::atan(x);
        const auto [y0, y1] = problem_.stretch;
        const Fast scaled = 4 * (y - (static_cast<Fast>(y0) + y1) / 2) / (static_cast<Fast>(y1) - y0);
        return std::polar(std::exp(-scaled), theta);
    }

    Node node(Fast x, Fast y, Fast s) const { return {x, y, s, chart(x, y)}; }
    Node on_circle(const Circle& c, Fast s) const {
        const Vector u = c.offset + std::cos(s) * c.e1 + std::sin(s) * c.e2;
        const Vector n = problem_.chart.turn.transpose().cast<Fast>() * u;
        return node(n.x() / (1 + n.z()), n.y() / (1 + n.z()), s);
    }

    std::array<Fast, 2> sample(std::mt19937_64& rng) const {
        const auto uniform = [&](double a, double b) { return std::uniform_real_distribution(a, b)(rng); };
        if (!is_over_sphere()) return {uniform(-1, 3), uniform(problem_.stretch[0], problem_.stretch[1])};
        const Fast z = uniform(-1, 1), angle = uniform(0, 2 * std::numbers::pi),
                   rho = std::sqrt((1 - z) / (1 + z));
        return {rho * std::cos(angle), rho * std::sin(angle)};
    }

    // --- Edges

    void trace(EdgeId e) {
        traces_.emplace_back();
        const auto& edge = d_.edges[e];
        if (edge.on_rim())
            trace_rim(e);
        else if (d_.is_circular(edge.left) && d_.is_circular(edge.right))
            trace_circle(e);
        else
            trace_pieces(e);
        const auto& nodes = traces_.back().nodes;
        if (!complaints_.empty()) return;
        // Who is nearest changes along an edge only at vertices; it is asked half-way between nodes.
        const std::size_t step = std::max<std::size_t>(1, nodes.size() / 8);
        for (std::size_t i = 0; i + 1 < nodes.size() && !edge.on_rim(); i += step) {
            const std::optional<Node> m = between(e, nodes[i], nodes[i + 1]);
            if (m) check_edge_point(e, *m);
        }
    }

    void check_edge_point(EdgeId e, const Node& m) {
        const Surroundings::Nearest best = around_.nearest(m.x, m.y);
        for (const FormId f : d_.label(e)) {
            const Fast t = around_.distance(around_.item(f), m.x, m.y);
            const Fast rounding = 16 * around_.tolerance() * (1 + best.distance / around_.scene_size());
            if (!(t - best.distance <= rounding))
                complain(to_string(e) + " " + place(m.x, m.y) + ": " + to_string(f) + " is not nearest, " +
                         around_.name(best.item) + " is");
        }
    }

    void trace_rim(EdgeId e) {
        const auto& edge = d_.edges[e];
        const VertexId from = dcel_.origin(Dcel::half_edge(e)), to = dcel_.target(Dcel::half_edge(e));
        const Fast y = problem_.stretch[edge.side == 0 ? 0 : 1];
        const Fast a = from.valid() ? d_.vertices[from].point.x() : -1;
        Fast b = to.valid() && to != from ? d_.vertices[to].point.x() : a;
        // The region lies on the left: above the lower rim, which runs towards larger x.
        if (edge.side == 0 && b <= a) b += 4;
        if (edge.side != 0 && b >= a) b -= 4;
        constexpr int steps = 64;
        for (int i = 0; i <= steps; ++i) {
            Fast x = a + (b - a) * i / steps;
            if (x >= 3) x -= 4;
            if (x < -1) x += 4;
            traces_.back().nodes.push_back(node(x, y, 0));
        }
    }

    void trace_circle(EdgeId e) {
        const auto& edge = d_.edges[e];
        const auto [h, h0] = around_.plane_of(around_.item(edge.left), around_.item(edge.right));
        const Vector axis = h.normalized(), offset = -h0 / h.norm() * axis;
        const Fast square = 1 - offset.squaredNorm();
        if (!(square > 0)) return complain(to_string(e) + ": its forms tie nowhere");
        const VertexId from = dcel_.origin(Dcel::half_edge(e)), to = dcel_.target(Dcel::half_edge(e));
        const auto unit = [&](VertexId v) {
            return around_.normal(d_.vertices[v].point.x(), d_.vertices[v].point.y());
        };
        Vector e1 = from.valid() ? Vector(unit(from) - offset) : axis.unitOrthogonal();
        e1 = (e1 - e1.dot(axis) * axis).normalized();
        const Vector e2 = axis.cross(e1);  // the left form is nearer on the axis' side: its left
        Fast end = 2 * std::numbers::pi_v<Fast>;
        if (to != from) {
            end = std::atan2(unit(to).dot(e2), unit(to).dot(e1));
            if (end < 0) end += 2 * std::numbers::pi_v<Fast>;
        }
        Trace& t = traces_.back();
        t.circle = Circle{offset, std::sqrt(square) * e1, std::sqrt(square) * e2};
        constexpr int steps = 16;
        for (int i = 0; i <= steps; ++i) t.nodes.push_back(on_circle(*t.circle, end * i / steps));
    }

    void trace_pieces(EdgeId e) {
        const auto pieces = d_.pieces(e);
        if (pieces.empty()) return complain(to_string(e) + ": an arc without pieces");
        const VertexId from = dcel_.origin(Dcel::half_edge(e)), to = dcel_.target(Dcel::half_edge(e));
        Eigen::Vector2d start = from.valid() ? d_.vertices[from].point : pieces.back().end;
        if (to.valid() && (pieces.back().end - d_.vertices[to].point).norm() >
                              2 * (pieces.back().error + d_.vertices[to].error) + 1e-12)
            complain(to_string(e) + ": does not end at its vertex");
        for (std::size_t i = 0; i < pieces.size(); ++i) {
            const auto& piece = pieces[i];
            Eigen::Vector2d a = start, b = piece.end;
            if (!is_over_sphere()) {  // both ends beside the box of the piece
                const double middle = (piece.box[0] + piece.box[1]) / 2;
                for (Eigen::Vector2d* p : {&a, &b}) {
                    while (p->x() - middle > 2) p->x() -= 4;
                    while (p->x() - middle < -2) p->x() += 4;
                }
            }
            for (const Eigen::Vector2d& p : {a, b})
                if (p.x() < piece.box[0] - 1e-9 || p.x() > piece.box[1] + 1e-9 ||
                    p.y() < piece.box[2] - 1e-9 || p.y() > piece.box[3] + 1e-9)
                    complain(to_string(e) + ": a piece leaves its box");
            const Node first = node(a.x(), a.y(), static_cast<Fast>(i)),
                       last = node(b.x(), b.y(), static_cast<Fast>(i));
            traces_.back().nodes.push_back(first);
            if (complaints_.empty()) refine(e, first, last, 5);
            traces_.back().nodes.push_back(last);
            start = piece.end;
        }
    }

    /// Nodes between a and b until the arc is flat.
    void refine(EdgeId e, const Node& a, const Node& b, int depth) {
        if (depth == 0) return;
        const std::optional<Node> m = between(e, a, b);
        if (!m) return;
        const Fast chord = std::hypot(b.x - a.x, b.y - a.y);
        if (std::hypot(m->x - (a.x + b.x) / 2, m->y - (a.y + b.y) / 2) < Fast(0.02) * chord) return;
        refine(e, a, *m, depth - 1);
        traces_.back().nodes.push_back(*m);
        refine(e, *m, b, depth - 1);
    }

    /// A point of edge e between two neighbouring nodes; none where they are as close as rounding.
    std::optional<Node> between(EdgeId e, const Node& a, const Node& b) {
        const Trace& t = traces_[e.value];
        if (t.circle) return on_circle(*t.circle, (a.s + b.s) / 2);
        if (d_.edges[e].on_rim()) {
            Fast x = (a.x + b.x) / 2;
            if (std::abs(a.x - b.x) > 2) x += x < 1 ? 2 : -2;
            return node(x, a.y, 0);
        }
        if (a.s != b.s) return std::nullopt;  // the end of a piece and the start of the next
        const auto& piece = d_.pieces(e)[static_cast<std::size_t>(a.s)];
        const Fast chord = std::hypot(b.x - a.x, b.y - a.y);
        if (chord < 1e-11L * (1 + std::hypot(a.x, a.y))) return std::nullopt;
        const std::size_t left = around_.item(d_.edges[e].left), right = around_.item(d_.edges[e].right);
        const Fast mx = (a.x + b.x) / 2, my = (a.y + b.y) / 2, dx = piece.direction.x(),
                   dy = piece.direction.y();
        // Positive where the left form is the nearer one; q, as many are never met.
        const auto lead = [&](Fast k) {
            return 1 / around_.distance(left, wrapped(mx + k * dx), my + k * dy) -
                   1 / around_.distance(right, wrapped(mx + k * dx), my + k * dy);
        };
        // How far the box of the piece reaches: its sides are measured in different units.
        const Fast sign = lead(0) > 0 ? 1 : -1;
        Fast reach = HUGE_VALL;
        for (const auto& [from, d, lower, upper] : {std::tuple{mx, sign * dx, piece.box[0], piece.box[1]},
                                                    std::tuple{my, sign * dy, piece.box[2], piece.box[3]}})
            if (d != 0) reach = std::min(reach, ((d > 0 ? upper : lower) - from) / d);
        reach *= 1 + 1e-9L;  // ends may lie on the box
        // The height of left less that of right grows along the direction.
        Fast low = 0, high = 0, &end = sign > 0 ? high : low;
        for (end = sign * reach / 1024; std::abs(end) < reach && sign * lead(end) > 0;) end *= 2;
        if (sign * lead(end) > 0) {
            complain(to_string(e) + " " + place(mx, my) + ": its forms do not tie beside it");
            return std::nullopt;
        }
        while (true) {
            const Fast middle = (low + high) / 2;
            if (!(low < middle && middle < high) || high - low < 1e-17L * reach)
                return node(mx + middle * dx, my + middle * dy, a.s);
            (lead(middle) > 0 ? low : high) = middle;
        }
    }

    Fast wrapped(Fast x) const { return is_over_sphere() ? x : x >= 3 ? x - 4 : x < -1 ? x + 4 : x; }

    // --- Faces

    void check_faces(const std::array<Fast, 2>& p, const std::array<Fast, 2>& q) {
        const Surroundings::Nearest at_p = around_.nearest(p[0], p[1]), at_q = around_.nearest(q[0], q[1]);
        for (const auto& [point, at] : {std::pair{p, at_p}, {q, at_q}})
            if (!around_.form(at.item).valid() && at.lead > around_.tolerance())
                return complain(place(point[0], point[1]) + ": " + around_.name(at.item) +
                                " is nearest, but has no form");
        const Complex zp = chart(p[0], p[1]), zq = chart(q[0], q[1]);
        IdVector<FaceId, Fast> turns;
        for (std::size_t i = 0; i < dcel_.face_count(); ++i) turns.push_back(0);
        for (const EdgeId e : d_.edges.ids()) {
            const std::optional<Fast> angle = turn(e, zp, zq);
            if (!angle) return;  // a point next to an edge
            turns[dcel_.face(Dcel::half_edge(e))] += *angle;
            turns[dcel_.face(Dcel::half_edge(e, 1))] -= *angle;
        }
        std::vector<FaceId> of_p, of_q;
        for (const FaceId f : turns.ids()) {
            const Fast times = turns[f] / (2 * std::numbers::pi_v<Fast>);
            if (std::abs(times) < 0.01L) continue;
            if (std::abs(times - 1) < 0.01L)
                of_p.push_back(f);
            else if (std::abs(times + 1) < 0.01L)
                of_q.push_back(f);
            else
                return complain(to_string(f) + ": winds " + text(times) + " times around " +
                                place(p[0], p[1]) + " and not " + place(q[0], q[1]));
        }
        const FormId nearest_p = around_.form(at_p.item), nearest_q = around_.form(at_q.item);
        if (of_p.empty() && of_q.empty()) {
            if (nearest_p != nearest_q)
                complain("nothing parts " + place(p[0], p[1]) + " of " + to_string(nearest_p) + " from " +
                         place(q[0], q[1]) + " of " + to_string(nearest_q));
        } else if (of_p.size() != 1 || of_q.size() != 1) {
            complain("faces " + name(of_p) + " and not " + name(of_q) + " hold " + place(p[0], p[1]));
        } else {
            if (d_.face_forms[of_p[0]] != nearest_p)
                complain(place(p[0], p[1]) + " of " + to_string(nearest_p) + " lies in " +
                         to_string(of_p[0]));
            if (d_.face_forms[of_q[0]] != nearest_q)
                complain(place(q[0], q[1]) + " of " + to_string(nearest_q) + " lies in " +
                         to_string(of_q[0]));
        }
    }

    /// How far (z - p) / (z - q) turns along an edge; none where p or q is too close to it.
    std::optional<Fast> turn(EdgeId e, const Complex& p, const Complex& q) {
        const auto& nodes = traces_[e.value].nodes;
        const auto image = [&](const Node& n) { return (n.z - p) / (n.z - q); };
        Fast sum = 0;
        for (std::size_t i = 0; i + 1 < nodes.size(); ++i) {
            const std::optional<Fast> part = turn(e, nodes[i], nodes[i + 1], image, 20);
            if (!part) return std::nullopt;
            sum += *part;
        }
        return sum;
    }

    // Nodes as far apart as this from p and q have their arc beside them: arcs bend by little between nodes.
    template <class Image>
    std::optional<Fast> turn(EdgeId e, const Node& a, const Node& b, const Image& image, int depth) {
        const Complex za = image(a), zb = image(b);
        if (std::abs(zb - za) < Fast(0.3) * std::min(std::abs(za), std::abs(zb))) return std::arg(zb / za);
        const std::optional<Node> m = between(e, a, b);
        if (!m || depth == 0) return std::nullopt;
        const std::optional<Fast> first = turn(e, a, *m, image, depth - 1),
                                  second = turn(e, *m, b, image, depth - 1);
        if (!first || !second) return std::nullopt;
        return *first + *second;
    }

    std::vector<Trace> traces_;
};

}  // namespace vcell::radial
