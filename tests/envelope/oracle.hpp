/// A brute-force judge of minimization diagrams. It shares no code with lower_envelope() but the types:
/// rational arithmetic for ties, 100 digits for vertices and arcs, winding numbers for point location.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "structure_oracle.hpp"

namespace vcell::oracle {

struct OracleOptions {
    int samples = rounds() > 1 ? 1000 : 400;  ///< points of the region whose owner is compared
    std::size_t brute_force_forms = 16;  ///< up to this many forms all triples are tried for missing vertices
};

class DiagramOracle : StructureOracle {
public:
    using StructureOracle::StructureOracle;

    std::vector<std::string> check(std::mt19937_64& rng, const OracleOptions& options) {
        check_structure();
        if (!complaints_.empty()) return complaints_;  // what follows walks the structure
        for (const VertexId v : d_.vertices.ids()) check_vertex(v);
        if (!complaints_.empty()) return complaints_;  // what follows builds on the refined vertices
        check_corners();
        for (const EdgeId e : d_.edges.ids()) check_edge(e);
        if (!complaints_.empty()) return complaints_;
        build_faces();
        check_samples(rng, options.samples);
        check_missing_vertices(options.brute_force_forms);
        return complaints_;
    }

private:
    struct Piece {  // of an arc, turning by a right angle at most
        Point<Fast> from, to;
        Quadric<Fast> curve;  // relative to `from`, which it passes through: C = 0
    };
    struct Bounds {
        Fast x0 = HUGE_VALL, y0 = HUGE_VALL, x1 = -HUGE_VALL, y1 = -HUGE_VALL;
        void add(const Piece& p, Fast margin) {
            // A piece leaves its chord by less than a quarter of the chord.
            margin += 0.25L * std::hypot(p.to.x - p.from.x, p.to.y - p.from.y);
            for (const Point<Fast>& q : {p.from, p.to}) {
                x0 = std::min(x0, q.x - margin), x1 = std::max(x1, q.x + margin);
                y0 = std::min(y0, q.y - margin), y1 = std::max(y1, q.y + margin);
            }
        }
        bool contains(const Point<Fast>& q) const { return x0 <= q.x && q.x <= x1 && y0 <= q.y && q.y <= y1; }
    };

    // --- Vertices

    Point<Real> local(const Eigen::Vector2d& p) const {
        return {Real(p.x()) - Real(origin_.x), Real(p.y()) - Real(origin_.y)};
    }

    /// The vertex in 100 digits, from its label and sides alone: of all pairs of curves through it the one
    /// that crosses at the widest angle, of its points the one nearest to the stated place.
    std::optional<Point<Real>> refine(VertexId v) const {
        const Point<Real> near = local(d_.vertices[v].point);
        const Point<Fast> q{near.x.convert_to<Fast>(), near.y.convert_to<Fast>()};
        std::vector<Quadric<Rational>> curves;
        for (const std::uint32_t s : d_.sides(v)) curves.push_back(sides_[s]);
        const auto label = d_.label(v);
        for (std::size_t i = 0; i < label.size(); ++i)
            for (std::size_t j = 0; j < i; ++j)
                curves.push_back(difference(forms_[label[i].value], forms_[label[j].value]));
        struct Pair {
            Fast angle;
            std::size_t i, j;
        };
        std::vector<Pair> pairs;
        std::vector<Point<Fast>> gradients;
        for (const Quadric<Rational>& c : curves) gradients.push_back(c.as<Fast>().gradient(q));
        for (std::size_t i = 0; i < curves.size(); ++i) {
            const Point<Fast>& g = gradients[i];
            for (std::size_t j = 0; j < i; ++j) {
                const Point<Fast>& h = gradients[j];
                const Fast norm = std::hypot(g.x, g.y) * std::hypot(h.x, h.y);
                pairs.push_back({norm > 0 ? std::abs(g.x * h.y - g.y * h.x) / norm : 0, i, j});
            }
        }
        std::ranges::sort(pairs, std::greater(), &Pair::angle);
        const auto distance = [&](const Point<Real>& p) { return abs(p.x - near.x) + abs(p.y - near.y); };
        for (const Pair& p : pairs) {
            const auto points = intersect(curves[p.i], curves[p.j]);
            if (!points.empty()) return *std::ranges::min_element(points, {}, distance);
        }
        for (const auto& g : curves)
            if (const auto p = point_circle(g)) return p;
        return std::nullopt;
    }

    void check_vertex(VertexId v) {
        const std::string where = to_string(v);
        const auto p = refine(v);
        refined_.push_back(p.value_or(Point<Real>{0, 0}));
        if (!p) return complain(where + ": its label " + name(d_.label(v)) + " determines no point");
        const auto& stated = d_.vertices[v];
        const Point<Real> q = local(stated.point);
        if (!(hypot(p->x - q.x, p->y - q.y) <= Real(stated.error)))
            complain(where + ": stated " +
                     std::to_string(static_cast<double>(hypot(p->x - q.x, p->y - q.y))) +
                     " away from the true vertex");
        if (stated.error > 1e-3 * static_cast<double>(size_)) complain(where + ": useless error bound");
        if (!inside(*p)) complain(where + ": outside the region");
        for (std::size_t s = 0; s < sides_.size(); ++s) {
            const auto listed = d_.sides(v);
            if (on_side(*p, s) != (std::ranges::find(listed, s) != listed.end()))
                complain(where + ": wrong about side " + std::to_string(s));
        }
        if (forms_.empty()) return;
        const auto truth = minimal(*p, real_forms_);
        if (!std::ranges::equal(truth, d_.label(v)))
            return complain(where + ": label " + name(d_.label(v)) + ", the minimum is attained by " +
                            name(truth));
        const Real height = real_forms_[truth[0].value](*p);
        if (!(abs(height - Real(stated.height)) <= Real(stated.height_error)))
            complain(where + ": height differs by more than its bound");
    }

    void check_corners() {
        const std::size_t n = sides_.size();
        for (std::size_t i = 0; i < n; ++i) {
            const auto at_corner = [&](VertexId v) {
                const auto s = d_.sides(v);
                return std::ranges::find(s, i) != s.end() && std::ranges::find(s, (i + 1) % n) != s.end();
            };
            int count = 0;
            for (const VertexId v : d_.vertices.ids()) count += at_corner(v);
            if (count != 1)
                complain("corner " + std::to_string(i) + ": is " + std::to_string(count) + " vertices");
        }
    }

    // --- Arcs

    /// The curve of an edge, negative on its left: a circle run counter-clockwise has K > 0.
    Quadric<Rational> curve(EdgeId e) const {
        const auto& edge = d_.edges[e];
        return edge.on_rim() ? -sides_[edge.side]
                             : difference(forms_[edge.left.value], forms_[edge.right.value]);
    }

    /// The middle of the arc from p to q. Pre: both on g; equal: the whole circle.
    static Point<Real> middle(const Point<Real>& p, const Point<Real>& q, const Quadric<Real>& g) {
        if (g.K == 0) return {(p.x + q.x) / 2, (p.y + q.y) / 2};
        const Point<Real> c{-g.A / (2 * g.K), -g.B / (2 * g.K)};
        const Point<Real> d{q.x - p.x, q.y - p.y};
        const Real chord = hypot(d.x, d.y), r = hypot(p.x - c.x, p.y - c.y);
        if (chord == 0) return {2 * c.x - p.x, 2 * c.y - p.y};
        // The arc bulges to the right of its chord when counter-clockwise; it is the smaller one of
        // the two when the centre lies on the other side.
        const int turn = g.K > 0 ? 1 : -1;
        const Real half = chord / 2, square = r * r - half * half;
        // A half circle leaves only rounding under the root, which would be half as precise.
        const Real h = square > kTie * r * r ? Real(sqrt(square)) : Real(0);
        const bool small = turn * (d.x * (c.y - p.y) - d.y * (c.x - p.x)) >= 0;
        const Real bulge = turn * (small ? Real(half * half / (r + h)) : Real(r + h)) / chord;
        return {(p.x + q.x) / 2 + bulge * d.y, (p.y + q.y) / 2 - bulge * d.x};
    }

    struct Ends {
        Point<Real> from, to;
    };

    std::optional<Ends> ends(EdgeId e, const Quadric<Real>& g) const {
        const HalfEdgeId h = Dcel::half_edge(e);
        if (dcel_.origin(h).valid())
            return Ends{refined_[dcel_.origin(h).value], refined_[dcel_.target(h).value]};
        if (g.K == 0) return std::nullopt;
        const Point<Real> c{-g.A / (2 * g.K), -g.B / (2 * g.K)};
        const Real r2 = c.x * c.x + c.y * c.y - g.C / g.K;
        if (r2 <= 0) return std::nullopt;
        const Point<Real> start{c.x + sqrt(r2), c.y};
        return Ends{start, start};
    }

    void check_edge(EdgeId e) {
        const std::string where = to_string(e);
        arcs_.emplace_back();
        if (forms_.empty() && !d_.edges[e].on_rim()) return complain(where + ": inner edge without forms");
        const Quadric<Real> g = curve(e).as<Real>();
        const auto range = ends(e, g);
        if (!range) return complain(where + ": closed, but its curve is no circle");
        const Point<Real>& p = range->from;
        const Point<Real>& q = range->to;
        if (g.K == 0 && (q.x - p.x) * -g.B + (q.y - p.y) * g.A <= 0)
            return complain(where + ": runs against its line's direction");
        const Point<Real> m = middle(p, q, g), first = middle(p, m, g), last = middle(m, q, g);
        for (const Point<Real>& x : {m, first, last}) {
            if (!inside(x)) complain(where + ": leaves the region");
            if (forms_.empty()) continue;
            const auto truth = minimal(x, real_forms_);
            if (!std::ranges::equal(truth, d_.label(e)))
                return complain(where + ": label " + name(d_.label(e)) + ", the minimum is attained by " +
                                name(truth));
        }
        const std::array<Point<Real>, 5> at{p, first, m, last, q};
        for (int i = 0; i < 4; ++i) {
            const Point<Real> grad = g.gradient(at[i]);
            const auto fast = [](const Real& v) { return v.convert_to<Fast>(); };
            arcs_.back().push_back({{fast(at[i].x), fast(at[i].y)},
                                    {fast(at[i + 1].x), fast(at[i + 1].y)},
                                    {fast(g.K), fast(grad.x), fast(grad.y), 0}});
        }
    }

    // --- Faces

    template <class Visit>
    void for_each_half_edge(FaceId f, const Visit& visit) const {
        std::vector<CcbId> ccbs = dcel_.inner_ccbs(f);
        if (dcel_.outer_ccb(f).valid()) ccbs.push_back(dcel_.outer_ccb(f));
        for (const CcbId c : ccbs) {
            HalfEdgeId h = dcel_.start(c);
            do {
                visit(h);
                h = dcel_.next(h);
            } while (h != dcel_.start(c));
        }
    }

    void build_faces() {
        bounds_.assign(dcel_.face_count(), {});
        for (std::uint32_t f = 1; f < dcel_.face_count(); ++f)
            for_each_half_edge({f}, [&](HalfEdgeId h) {
                for (const Piece& p : arcs_[Dcel::edge(h).value]) bounds_[f].add(p, 0);
            });
    }

    /// Angle that a piece sweeps as seen from q; none when q is too near to say.
    std::optional<Fast> swept(const Piece& piece, const Point<Fast>& q) const {
        const Point<Fast> a{piece.from.x - q.x, piece.from.y - q.y}, b{piece.to.x - q.x, piece.to.y - q.y};
        const Point<Fast> local{-a.x, -a.y}, grad = piece.curve.gradient(local);
        const Fast value = piece.curve(local), margin = kSkip * size_;
        Bounds box;
        box.add(piece, margin);
        const bool near = box.contains(q);
        if (near && std::abs(value) <= margin * std::hypot(grad.x, grad.y)) return std::nullopt;
        if (std::hypot(a.x, a.y) <= margin || std::hypot(b.x, b.y) <= margin) return std::nullopt;
        const Fast cross = a.x * b.y - a.y * b.x;
        Fast angle = std::atan2(cross, a.x * b.x + a.y * b.y);
        // Between chord and arc the arc passes on the other side of q.
        const Fast turn = 2 * std::numbers::pi_v<Fast>;
        if (near && value < 0 && piece.curve.K > 0 && cross < 0) angle += turn;
        if (near && value > 0 && piece.curve.K < 0 && cross > 0) angle -= turn;
        return angle;
    }

    /// Does f contain q? None: too near to its boundary.
    std::optional<bool> contains(FaceId f, const Point<Fast>& q) const {
        Fast total = 0;
        bool near = false;
        for_each_half_edge(f, [&](HalfEdgeId h) {
            for (const Piece& p : arcs_[Dcel::edge(h).value])
                if (const auto angle = swept(p, q))
                    total += (h.value & 1) ? -*angle : *angle;
                else
                    near = true;
        });
        if (near) return std::nullopt;
        return std::lround(total / (2 * std::numbers::pi_v<Fast>)) == 1;
    }

    /// Points all over the region, and as many close to vertices, where small faces meet.
    void check_samples(std::mt19937_64& rng, int samples) {
        std::uniform_real_distribution<double> unit(-1, 1);
        std::vector<Quadric<Fast>> sides;
        for (const Quadric<Rational>& s : sides_) sides.push_back(s.as<Fast>());
        int asked = 0;
        for (int i = 0; i < samples; ++i) {
            double x = origin_.x + unit(rng) * static_cast<double>(half_.x);
            double y = origin_.y + unit(rng) * static_cast<double>(half_.y);
            if (i % 2 && d_.vertices.size()) {
                const auto& v = d_.vertices[{static_cast<std::uint32_t>(rng() % d_.vertices.size())}];
                const double reach = static_cast<double>(size_) * std::pow(10.0, -3.5 + 2.5 * unit(rng));
                x = v.point.x() + unit(rng) * reach;
                y = v.point.y() + unit(rng) * reach;
            }
            const Point<Fast> q{Fast(x) - origin_.x, Fast(y) - origin_.y};
            const bool in_region = std::ranges::all_of(sides, [&](const Quadric<Fast>& g) {
                return g(q) > kSkip * size_ * (std::abs(g.A) + std::abs(g.B));
            });
            asked += in_region && check_sample(x, y, q);
        }
        if (samples >= 100 && asked < samples / 10) complain("samples: nearly all lie on edges");
    }

    bool check_sample(double x, double y, const Point<Fast>& q) {
        const std::string where = "point (" + std::to_string(x) + ", " + std::to_string(y) + ")";
        std::vector<FaceId> found;
        for (std::uint32_t f = 1; f < dcel_.face_count(); ++f) {
            if (!bounds_[f].contains(q)) continue;
            const auto in = contains({f}, q);
            if (!in) return false;
            if (*in) found.push_back({f});
        }
        if (found.size() != 1) {
            complain(where + ": lies in the faces " + name(found));
            return true;
        }
        if (forms_.empty()) return true;
        const auto truth = minimal(
            Point<Rational>{Rational(x) - Rational(origin_.x), Rational(y) - Rational(origin_.y)}, forms_);
        const FormId owner = d_.face_forms[found[0]];
        if (std::ranges::find(truth, owner) == truth.end())
            complain(where + ": in " + to_string(found[0]) + " of " + to_string(owner) + ", lowest is " +
                     name(truth));
        if (lowest_form(family_, x, y) != truth[0])
            complain(where + ": lowest_form disagrees with " + name(truth));
        return true;
    }

    // --- Completeness

    /// There must be a vertex at p, a common point of the forms `tied`, when they attain the minimum.
    void expect_vertex(const Point<Real>& p, std::initializer_list<std::uint32_t> tied) {
        if (!inside(p)) return;
        const auto truth = minimal(p, real_forms_);
        for (const std::uint32_t f : tied)
            if (std::ranges::find(truth, FormId{f}) == truth.end()) return;
        const bool there = std::ranges::any_of(
            refined_, [&](const Point<Real>& v) { return abs(v.x - p.x) + abs(v.y - p.y) <= kTie * size_; });
        if (!there) complain("no vertex at a point where the minimum is attained by " + name(truth));
    }

    void check_missing_vertices(std::size_t limit) {
        const auto n = static_cast<std::uint32_t>(forms_.size());
        if (n > limit) return;
        for (std::uint32_t i = 0; i < n; ++i)
            for (std::uint32_t j = 0; j < i; ++j) {
                const auto g = difference(forms_[i], forms_[j]);
                if (const auto p = point_circle(g)) expect_vertex(*p, {i, j});
                for (const auto& s : sides_)
                    for (const auto& p : intersect(g, s)) expect_vertex(p, {i, j});
                for (std::uint32_t k = 0; k < j; ++k)
                    for (const auto& p : intersect(g, difference(forms_[i], forms_[k])))
                        expect_vertex(p, {i, j, k});
            }
    }

    std::vector<Point<Real>> refined_;      // by vertex
    std::vector<std::vector<Piece>> arcs_;  // by edge, along half-edge 2e
    std::vector<Bounds> bounds_;            // by face
};

/// Everything that brute force has to say against a diagram; empty: nothing. Checks in order: the dcel's
/// invariants and the labels' inclusions; each vertex (refined from its label; all and only the labelled
/// forms are lowest; place and height within their bounds); each arc at three points; the face of sampled
/// points; for few forms, that no vertex is missing. A failed stage ends the judgement.
inline std::vector<std::string> check_diagram(const MinimizationDiagram& diagram, const FormFamily& family,
                                              std::mt19937_64& rng, const OracleOptions& options = {}) {
    return DiagramOracle(diagram, family).check(rng, options);
}

}  // namespace vcell::oracle
