/// A brute-force judge of minimization diagrams with cylinders. It shares no code with lower_envelope() but
/// the types. Heights come from their definition: the clearance r at which the point (x, y, r) is r away from
/// the object, solved for in long double, and in 100 digits where that does not tell.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "mixed_arc_oracle.hpp"

namespace vcell::mixed {

struct Options {
    int samples = 400;                  ///< points of the region whose owner is compared
    std::size_t brute_force_forms = 8;  ///< up to this many forms all triples are tried for missing vertices
};

class Judge : public ArcOracle {
public:
    using ArcOracle::ArcOracle;

    std::vector<std::string> check(std::mt19937_64& rng, const Options& options) {
        check_structure();
        if (!complaints_.empty()) return complaints_;  // what follows walks the structure
        for (const VertexId v : d_.vertices.ids()) check_vertex(v);
        check_corners();
        if (!complaints_.empty()) return complaints_;  // what follows builds on the refined vertices
        for (const EdgeId e : d_.edges.ids()) trace_edge(e, rng);
        if (!complaints_.empty()) return complaints_;
        check_samples(rng, options.samples);
        check_rim();
        if (solids_.size() <= options.brute_force_forms) check_missing_vertices();
        return complaints_;
    }

private:
    // --- Faces

    /// Signed crossings of the ray from q to the right; none when q is too near to say.
    std::optional<int> crossings(const Segment& s, const Point<Fast>& q) const {
        const auto [y0, y1] = std::minmax(s.from.y, s.to.y);
        if (q.y < y0 - s.band || q.y > y1 + s.band || q.x > std::max(s.from.x, s.to.x) + s.band) return 0;
        const Fast dx = s.to.x - s.from.x, dy = s.to.y - s.from.y, length = std::hypot(dx, dy);
        const Fast t =
            length > 0
                ? std::clamp<Fast>(((q.x - s.from.x) * dx + (q.y - s.from.y) * dy) / (length * length), 0, 1)
                : 0;
        if (apart(q, {s.from.x + t * dx, s.from.y + t * dy}) <= s.band) {
            const auto m = length > kFinest * size_ ? middle(s) : std::nullopt;
            if (!m) return std::nullopt;
            Segment a = s, b = s;
            a.to = b.from = *m;
            for (Segment* half : {&a, &b}) {
                if (d_.edges[{s.edge}].on_rim()) return std::nullopt;
                const auto n = middle(*half);
                if (!n) return std::nullopt;
                half->band = band(*half, *n);
            }
            const auto first = crossings(a, q), second = crossings(b, q);
            if (!first || !second) return std::nullopt;
            return *first + *second;
        }
        const bool from_below = s.from.y <= q.y, to_below = s.to.y <= q.y;
        if (from_below == to_below) return 0;
        const bool left_of =
            (dx * (q.y - s.from.y) - dy * (q.x - s.from.x) > 0) == (dy > 0);  // q is left of the chord
        return left_of ? (dy > 0 ? 1 : -1) : 0;
    }

    /// The faces whose boundary winds around q once.
    std::optional<std::vector<FaceId>> faces_around(const Point<Fast>& q) const {
        std::vector<int> winding(dcel_.face_count());
        for (const Segment& s : segments_) {
            const auto c = crossings(s, q);
            if (!c) return std::nullopt;
            if (*c == 0) continue;
            const HalfEdgeId h = Dcel::half_edge({s.edge});
            winding[dcel_.face(h).value] += *c;
            winding[dcel_.face(Dcel::twin(h)).value] -= *c;
        }
        std::vector<FaceId> found;
        for (std::uint32_t f = 1; f < winding.size(); ++f)
            if (winding[f] != 0) found.push_back({f});
        for (const FaceId f : found)
            if (winding[f.value] != 1) return std::vector<FaceId>{};
        return found;
    }

    bool check_sample(const Point<Fast>& q) {
        if (!in_region(q, 1e-12L * size_)) return false;
        const auto found = faces_around(q);
        if (!found) return false;
        const std::string where = "point " + place(q);
        if (found->size() != 1) {
            complain(where + ": lies in the faces " + name(*found));
            return true;
        }
        const FormId owner = d_.face_forms[found->front()];
        auto truth = minimal(q);
        if (truth.size() > 1) truth = minimal(Point<Real>{Real(q.x), Real(q.y)});
        if (std::ranges::find(truth, owner) == truth.end() && assumed_width(q, 0) == 0)
            complain(where + ": in " + to_string(found->front()) + " of " + to_string(owner) +
                     ", lowest is " + name(truth));
        return true;
    }

    /// Points all over the region, as many close to vertices, where small faces meet, and where each form
    /// does best.
    void check_samples(std::mt19937_64& rng, int samples) {
        std::uniform_real_distribution<double> unit(-1, 1);
        int asked = 0;
        for (int i = 0; i < samples; ++i) {
            Point<Fast> q{low_.x + (high_.x - low_.x) * (unit(rng) + 1) / 2,
                          low_.y + (high_.y - low_.y) * (unit(rng) + 1) / 2};
            if (i % 2 && d_.vertices.size()) {
                const Point<Fast>& v = at_[rng() % at_.size()];
                const Fast reach = size_ * std::pow(10.0, -4 + 3 * unit(rng));
                q = {v.x + unit(rng) * reach, v.y + unit(rng) * reach};
            }
            asked += check_sample(q);
        }
        if (samples >= 100 && asked < samples / 10) complain("samples: nearly all lie on edges");
        const std::size_t n = std::min<std::size_t>(solids_.size(), 40);
        for (std::size_t f = 0; f < n; ++f) check_sample(best_place(f, rng));
    }

    /// Where form f is farthest below the others, or least above them: a search by shrinking steps.
    Point<Fast> best_place(std::size_t f, std::mt19937_64& rng) const {
        std::uniform_real_distribution<double> unit(-1, 1);
        const auto excess = [&](const Point<Fast>& p) {
            Fast others = HUGE_VALL;
            for (std::size_t i = 0; i < solids_.size(); ++i)
                if (i != f) others = std::min(others, height<Fast>(solids_[i], p.x, p.y).v);
            return height<Fast>(solids_[f], p.x, p.y).v - others;
        };
        Point<Fast> best{(low_.x + high_.x) / 2, (low_.y + high_.y) / 2};
        Fast least = excess(best), step = size_ / 2;
        for (int i = 0; i < 80; ++i, step *= 0.9L) {
            const Point<Fast> p{best.x + step * unit(rng), best.y + step * unit(rng)};
            if (!in_region(p, 0)) continue;
            if (const Fast e = excess(p); e < least) {
                least = e;
                best = p;
            }
        }
        return best;
    }

    // --- Completeness

    /// Along each side the owner at sampled points is the rim edge's.
    void check_rim() {
        const std::size_t n = corners_.size();
        for (std::size_t side = 0; side < n; ++side) {
            const Point<Fast>&p = corners_[side], &q = corners_[(side + 1) % n];
            for (int k = 0; k < 64; ++k) {
                const Fast t = (k + 0.4142L) / 64;
                const Point<Fast> at{p.x + t * (q.x - p.x), p.y + t * (q.y - p.y)};
                const auto truth = minimal(at);
                bool known = truth.size() > 1;  // too close to a change
                for (const Segment& s : segments_) {
                    if (known || d_.edges[{s.edge}].side != side) continue;
                    const Fast along =
                        (at.x - s.from.x) * (s.to.x - s.from.x) + (at.y - s.from.y) * (s.to.y - s.from.y);
                    if (along < 0 || along > apart(s.from, s.to) * apart(s.from, s.to)) continue;
                    known = true;
                    if (d_.edges[{s.edge}].left != truth[0])
                        complain("side " + std::to_string(side) + " at " + place(at) + ": labelled " +
                                 to_string(d_.edges[{s.edge}].left) + ", lowest is " + name(truth));
                }
                if (!known) complain("side " + std::to_string(side) + " at " + place(at) + ": no rim edge");
            }
        }
    }

    /// Wherever three forms are found to meet and are lowest, there is a vertex.
    void check_missing_vertices() {
        const std::size_t n = solids_.size();
        const auto jet = [&](std::size_t i, const Point<Fast>& p) {
            return height<Fast>(solids_[i], p.x, p.y);
        };
        for (std::size_t i = 0; i < n; ++i)
            for (std::size_t j = i + 1; j < n; ++j)
                for (std::size_t k = j + 1; k < n; ++k)
                    for (int start = 0; start < 16; ++start) {
                        Point<Fast> p{low_.x + (high_.x - low_.x) * (start % 4 + 0.5L) / 4,
                                      low_.y + (high_.y - low_.y) * (start / 4 + 0.5L) / 4};
                        Fast step = HUGE_VALL;
                        for (int it = 0; it < 30 && step > 1e-16L * size_ && in_region(p, -size_); ++it) {
                            const Height<Fast> a = jet(i, p), b = jet(j, p), c = jet(k, p);
                            const Fast ux = a.gx - b.gx, uy = a.gy - b.gy, vx = a.gx - c.gx, vy = a.gy - c.gy,
                                       det = ux * vy - uy * vx;
                            const Fast dx = (uy * (a.v - c.v) - vy * (a.v - b.v)) / det,
                                       dy = (vx * (a.v - b.v) - ux * (a.v - c.v)) / det;
                            p = {p.x + dx, p.y + dy};
                            step = std::isfinite(dx + dy) ? std::abs(dx) + std::abs(dy) : HUGE_VALL;
                            if (step == HUGE_VALL) break;
                        }
                        if (!(step <= 1e-15L * size_) || !in_region(p, 1e-10L * size_)) continue;
                        const auto truth = minimal(p);
                        const auto lowest = [&](std::size_t f) {
                            return std::ranges::find(truth, FormId{static_cast<std::uint32_t>(f)}) !=
                                   truth.end();
                        };
                        if (!lowest(i) || !lowest(j) || !lowest(k)) continue;
                        if (std::ranges::none_of(
                                at_, [&](const Point<Fast>& v) { return apart(v, p) <= 1e-7L * size_; }))
                            complain("no vertex at " + place(p) + ", where the minimum is attained by " +
                                     name(truth));
                    }
    }
};

/// Everything that brute force has to say against a diagram; empty: nothing. Checks in order: the dcel's
/// invariants and the labels' inclusions; each vertex (refined from its label; all and only the labelled
/// forms are lowest; place and height within their bounds); the pieces of each edge, and the forms along it;
/// the face of sampled points, the rim's labels; for few forms, that no vertex is missing. A failed stage
/// ends the judgement.
inline std::vector<std::string> check_diagram(const Scene& scene, const MinimizationDiagram& diagram,
                                              std::mt19937_64& rng, const Options& options = {}) {
    return Judge(scene, diagram).check(rng, options);
}

}  // namespace vcell::mixed
