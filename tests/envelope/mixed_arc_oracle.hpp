/// Vertices and arcs of diagrams with cylinders against brute force: vertices refined in 100 digits, arcs
/// traced by halving and compared with the forms along them.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "mixed_structure_oracle.hpp"

namespace vcell::mixed {

class VertexOracle : public StructureOracle {
public:
    using StructureOracle::StructureOracle;

protected:
    /// A function that vanishes at a vertex: the difference of two forms, or a side.
    struct Curve {
        std::size_t f, g;  // forms; of a side: the side and SIZE_MAX
    };

    std::array<Real, 3> value(const Curve& c, const Point<Real>& p) const {
        if (c.g == SIZE_MAX) {
            const auto& s = region_.sides[c.f];
            return {Real(s.a) * p.x + Real(s.b) * p.y + Real(s.c), Real(s.a), Real(s.b)};
        }
        const Point<Fast> q = fast(p);
        const auto jet = [&](std::size_t i) {
            return height<Real>(solids_[i], p.x, p.y, Real(height<Fast>(solids_[i], q.x, q.y).v));
        };
        const Height<Real> a = jet(c.f), b = jet(c.g);
        return {a.v - b.v, a.gx - b.gx, a.gy - b.gy};
    }

    static Real sine(const std::array<Real, 3>& u, const std::array<Real, 3>& v) {
        const Real norm = oracle::root((u[1] * u[1] + u[2] * u[2]) * (v[1] * v[1] + v[2] * v[2]));
        return norm > 0 ? Real(abs(u[1] * v[2] - u[2] * v[1]) / norm) : Real(0);
    }

    template <class System>
    std::optional<Point<Real>> newton(Point<Real> p, System&& system) const {
        const Real enough = Real(size_) * Real("1e-85");
        for (int i = 0; i < 40; ++i) {
            const auto [u, v] = system(p);
            const Real det = u[1] * v[2] - u[2] * v[1];
            if (det == 0) return std::nullopt;
            const Real dx = (u[2] * v[0] - v[2] * u[0]) / det, dy = (v[1] * u[0] - u[1] * v[0]) / det;
            if (abs(dx) + abs(dy) > Real(size_)) return std::nullopt;
            p = {p.x + dx, p.y + dy};
            if (abs(dx) + abs(dy) <= enough) return p;
        }
        return std::nullopt;
    }

    /// The vertex in 100 digits, from its label and sides alone: where the two of its curves meet that cross
    /// at the widest angle; if all touch, where two have one direction, or the gradient of a difference (its
    /// slope along a side) vanishes.
    std::optional<Point<Real>> refine(VertexId v) const {
        const Point<Real> start{Real(d_.vertices[v].point.x()), Real(d_.vertices[v].point.y())};
        std::vector<Curve> curves;
        for (const std::uint32_t s : d_.sides(v)) curves.push_back({s, SIZE_MAX});
        const auto label = d_.label(v);
        for (std::size_t i = 0; i < label.size(); ++i)
            for (std::size_t j = 0; j < i; ++j) curves.push_back({label[i].value, label[j].value});
        Real widest = 0;
        std::optional<std::pair<Curve, Curve>> best;
        std::vector<std::array<Real, 3>> values;
        for (const Curve& c : curves) values.push_back(value(c, start));
        for (std::size_t i = 0; i < curves.size(); ++i)
            for (std::size_t j = 0; j < i; ++j)
                if (const Real s = sine(values[i], values[j]); s > widest) {
                    widest = s;
                    best = {curves[i], curves[j]};
                }
        if (best)  // fails, by far too slow, if these touch but for the error of the start
            if (const auto p = newton(start, [&](const Point<Real>& q) {
                    return std::pair(value(best->first, q), value(best->second, q));
                }))
                return p;
        std::optional<Curve> difference;  // of the smallest gradient
        Real least = 0;
        for (std::size_t i = 0; i < curves.size(); ++i) {
            const Real norm = values[i][1] * values[i][1] + values[i][2] * values[i][2];
            if (curves[i].g == SIZE_MAX || (difference && norm >= least)) continue;
            difference = curves[i];
            least = norm;
        }
        if (!difference) return std::nullopt;
        const Real h = Real(size_) * Real("1e-30");
        if (d_.sides(v).empty() && label.size() > 2 && least > Real("1e-20"))
            return newton(start, [&](const Point<Real>& p) {
                const auto turn = [&](const Point<Real>& q) {
                    const auto a = value(curves[0], q), b = value(curves[1], q);
                    return Real(a[1] * b[2] - a[2] * b[1]);
                };
                const Real at = turn(p);
                return std::pair(value(curves[0], p), std::array{at, Real((turn({p.x + h, p.y}) - at) / h),
                                                                 Real((turn({p.x, p.y + h}) - at) / h)});
            });
        if (d_.sides(v).empty())
            return newton(start, [&](const Point<Real>& p) {
                const auto at = value(*difference, p), x = value(*difference, {p.x + h, p.y}),
                           y = value(*difference, {p.x, p.y + h});
                return std::pair(std::array{at[1], Real((x[1] - at[1]) / h), Real((y[1] - at[1]) / h)},
                                 std::array{at[2], Real((x[2] - at[2]) / h), Real((y[2] - at[2]) / h)});
            });
        const auto& s = region_.sides[d_.sides(v)[0]];
        return newton(start, [&](const Point<Real>& p) {
            const auto slope = [&](const Point<Real>& q) {
                const auto at = value(*difference, q);
                return Real(at[1] * Real(s.b) - at[2] * Real(s.a));
            };
            const Real at = slope(p);
            return std::pair(value(Curve{d_.sides(v)[0], SIZE_MAX}, p),
                             std::array{at, Real((slope({p.x + h, p.y}) - at) / h),
                                        Real((slope({p.x, p.y + h}) - at) / h)});
        });
    }

    /// How coarsely a point near p may have been taken for a vertex.
    Fast assumed_width(const Point<Fast>& p, Fast error) const {
        Fast width = 0;
        for (const Assumption& a : d_.assumptions)
            if (apart(p, {a.place.x(), a.place.y()}) <= error + 2 * a.width)
                width = std::max<Fast>(width, a.width);
        return width;
    }

    void check_vertex(VertexId v) {
        const std::string where =
            to_string(v) + " at " + place({d_.vertices[v].point.x(), d_.vertices[v].point.y()});
        const auto& stated = d_.vertices[v];
        const Point<Fast> near{stated.point.x(), stated.point.y()};
        at_.push_back(near);
        if (!(stated.error <= 1e-3 * size_)) return complain(where + ": useless error bound");
        const Fast width = assumed_width(near, stated.error);
        if (width > 1e-30L * size_) return check_assumed_vertex(v, where, width);
        const auto p = refine(v);
        if (!p) return complain(where + ": its label " + name(d_.label(v)) + " determines no point");
        at_.back() = fast(*p);
        const Real dx = p->x - Real(stated.point.x()), dy = p->y - Real(stated.point.y());
        if (!(sqrt(dx * dx + dy * dy) <= Real(stated.error)))
            complain(where + ": stated " + text(apart(fast(*p), near) / stated.error) +
                     " times its bound away from the true vertex");
        for (std::uint32_t i = 0; i < region_.sides.size(); ++i) {
            const Real s = value(Curve{i, SIZE_MAX}, *p)[0],
                       tie = kTie * Real(size_) *
                             (abs(Real(region_.sides[i].a)) + abs(Real(region_.sides[i].b)));
            if (s < -tie) complain(where + ": outside the region");
            const auto listed = d_.sides(v);
            if ((abs(s) <= tie) != (std::ranges::find(listed, i) != listed.end()))
                complain(where + ": wrong about side " + std::to_string(i));
        }
        const auto truth = minimal(*p);
        if (!std::ranges::equal(truth, d_.label(v)))
            return complain(where + ": label " + name(d_.label(v)) + ", the minimum is attained by " +
                            name(truth));
        const Real h = height<Real>(solids_[truth[0].value], p->x, p->y).v;
        if (!(abs(h - Real(stated.height)) <= Real(stated.height_error)))
            complain(where + ": height off by " +
                     text((abs(h - Real(stated.height)) / Real(stated.height_error)).convert_to<Fast>()) +
                     " times its bound");
    }

    // Its forms are as low as any other, to the width of what was assumed.
    void check_assumed_vertex(VertexId v, const std::string& where, Fast width) {
        const Point<Fast>& p = at_.back();
        const Fast reach = width + d_.vertices[v].error;
        const auto jet = [&](std::size_t i) { return height<Fast>(solids_[i], p.x, p.y); };
        Fast top = HUGE_VALL;
        for (std::size_t i = 0; i < solids_.size(); ++i) {
            const Height<Fast> h = jet(i);
            top = std::min(top, h.v + 2 * reach * (std::abs(h.gx) + std::abs(h.gy)) + rounding(i, p, h));
        }
        for (const FormId f : d_.label(v)) {
            const Height<Fast> h = jet(f.value);
            if (h.v - 2 * reach * (std::abs(h.gx) + std::abs(h.gy)) - rounding(f.value, p, h) > top)
                complain(where + ": " + to_string(f) + " is higher than others");
        }
    }

    void check_corners() {
        const std::size_t n = region_.sides.size();
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

    std::vector<Point<Fast>> at_;  // by vertex, refined
};

class ArcOracle : public VertexOracle {
public:
    using VertexOracle::VertexOracle;

protected:
    // Chords are halved until they keep apart from the sampled point, but no shorter than this part of the
    // region.
    static constexpr Fast kFinest = 1e-11L;

    // A stretch of an arc, and how far it is from its chord.
    struct Segment {
        Point<Fast> from, to;
        Fast band = 0;
        std::uint32_t edge = 0;
        std::int32_t piece = -1;  // -1: of a circle or the rim
    };

    std::array<Fast, 3> difference(const MinimizationDiagram::Edge& e, const Point<Fast>& p) const {
        const Height<Fast> a = height<Fast>(solids_[e.left.value], p.x, p.y),
                           b = height<Fast>(solids_[e.right.value], p.x, p.y);
        return {a.v - b.v, a.gx - b.gx, a.gy - b.gy};
    }

    Fast difference_error(const MinimizationDiagram::Edge& e, const Point<Fast>& p) const {
        Fast sum = 0;
        for (const FormId f : {e.left, e.right})
            sum += rounding(f.value, p, height<Fast>(solids_[f.value], p.x, p.y));
        return sum;
    }

    /// The arc's point on the line through p along the piece's direction: a sign change within `reach`,
    /// closed in on.
    std::optional<Point<Fast>> onto_arc(EdgeId e, std::size_t piece, const Point<Fast>& p, Fast reach) const {
        const auto& edge = d_.edges[e];
        const auto& d = d_.pieces(e)[piece].direction;
        const auto at = [&](Fast w) { return Point<Fast>{p.x + w * d.x(), p.y + w * d.y()}; };
        Fast lo = 0, hi = 0;
        const auto start = difference(edge, p);
        const Fast slope = start[1] * d.x() + start[2] * d.y();
        Fast grow = slope > 0 ? std::abs(start[0] / slope) * 2 + 1e-17L * size_ : 1e-6L * reach;
        for (; grow <= 64 * reach; grow *= 4) {
            (start[0] > 0 ? lo : hi) = start[0] > 0 ? -grow : grow;
            if (difference(edge, at(lo))[0] <= 0 && difference(edge, at(hi))[0] >= 0) break;
        }
        if (grow > 64 * reach) return std::nullopt;
        for (int i = 0; i < 80; ++i) {
            Fast m = (lo + hi) / 2;
            const auto v = difference(edge, at(i % 2 ? m : lo));
            const Fast s = v[1] * d.x() + v[2] * d.y();
            if (i % 2 == 0 && s > 0) m = std::clamp(lo - v[0] / s, lo, hi);  // Newton's step, then bisection
            const Fast value = difference(edge, at(m))[0];
            if (value == 0 || hi - lo <= 1e-19L * size_) return at(m);
            (value < 0 ? lo : hi) = m;
        }
        const Fast m = (lo + hi) / 2;
        const auto v = difference(edge, at(m));
        const Fast s = v[1] * d.x() + v[2] * d.y();
        return at(s > 0 ? std::clamp(m - v[0] / s, lo, hi) : m);
    }

    /// The point of the arc above the middle of a segment's chord.
    std::optional<Point<Fast>> middle(const Segment& s) const {
        const Point<Fast> m{(s.from.x + s.to.x) / 2, (s.from.y + s.to.y) / 2};
        const MinimizationDiagram::Edge& edge = d_.edges[{s.edge}];
        if (edge.on_rim()) return m;
        const Fast chord = apart(s.from, s.to);
        if (s.piece >= 0) return chord > 1e-16L * size_ ? onto_arc({s.edge}, s.piece, m, chord) : m;
        // A circle of curvature k leaves its chord by h^2 k / (1 + sqrt(1 - h^2 k^2)), to the right when
        // counter-clockwise.
        const Fast k = curvature(edge), h = chord / 2;
        const Fast bulge = h * h * k / (1 + std::sqrt(std::max<Fast>(0, 1 - h * h * k * k))) /
                           std::max(chord, std::numeric_limits<Fast>::min());
        return Point<Fast>{m.x + bulge * (s.to.y - s.from.y), m.y - bulge * (s.to.x - s.from.x)};
    }

    struct Circle {
        Real K, A, B, C;  // K (x^2 + y^2) + A x + B y + C, negative on the left
    };

    Circle circle(const MinimizationDiagram::Edge& e) const {
        const auto terms = [&](FormId f) {
            if (const Wall* w = std::get_if<Wall>(&solids_[f.value]))
                return std::array<Real, 5>{0, w->a, w->b, w->e, w->w};
            const Ball& b = std::get<Ball>(solids_[f.value]);
            const Real x(b.x), y(b.y), z(b.z), rho(b.rho);
            return std::array<Real, 5>{1, -2 * x, -2 * y, x * x + y * y + z * z - rho * rho, 2 * (z + rho)};
        };
        const auto f = terms(e.left), g = terms(e.right);
        const auto minus = [&](int i) { return Real(f[i] / f[4] - g[i] / g[4]); };
        return {minus(0), minus(1), minus(2), minus(3)};
    }

    Fast curvature(const MinimizationDiagram::Edge& e) const {
        const auto [K, A, B, C] = circle(e);
        return Real(2 * K / sqrt(A * A + B * B - 4 * K * C)).convert_to<Fast>();
    }

    void add_segment(Segment s, int halvings) {
        const auto m = middle(s);
        if (!m && near_point(s)) {
            s.band = 2 * apart(s.from, s.to);
            segments_.push_back(s);
            return;
        }
        if (!m)
            return complain(to_string(EdgeId{s.edge}) + ": no point of its curve beside the chord from " +
                            place(s.from) + " to " + place(s.to));
        Segment a = s, b = s;
        a.to = b.from = *m;
        if (halvings > 0) {
            add_segment(a, halvings - 1);
            add_segment(b, halvings - 1);
            return;
        }
        s.band = band(s, *m);
        segments_.push_back(s);
    }

    // Of a piece that was taken for a point nothing but its ends is known.
    bool near_point(const Segment& s) const {
        return s.piece >= 0 && assumed_width(s.from, apart(s.from, s.to)) > 0;
    }

    Fast band(const Segment& s, const Point<Fast>& m) const {
        Fast most = apart(m, {(s.from.x + s.to.x) / 2, (s.from.y + s.to.y) / 2});
        if (s.piece >= 0)
            for (const auto& [p, q] : {std::pair(s.from, m), std::pair(m, s.to)}) {
                Segment half = s;
                half.from = p;
                half.to = q;
                if (const auto n = middle(half))
                    most = std::max(most, apart(*n, {(p.x + q.x) / 2, (p.y + q.y) / 2}));
            }
        return 2 * most + 1e-15L * size_;
    }

    void trace_edge(EdgeId e, std::mt19937_64& rng) {
        const auto& edge = d_.edges[e];
        const std::string where =
            to_string(e) + " between " + to_string(edge.left) + " and " + to_string(edge.right);
        const VertexId from = dcel_.origin(Dcel::half_edge(e)), to = dcel_.target(Dcel::half_edge(e));
        const std::size_t first = segments_.size();
        if (edge.on_rim()) {
            if (!from.valid()) return complain(where + ": closed, on the rim");
            const auto& s = region_.sides[edge.side];
            const Point<Fast>&p = at_[from.value], &q = at_[to.value];
            if ((q.x - p.x) * s.b - (q.y - p.y) * s.a <= 0) complain(where + ": runs against its side");
            segments_.push_back({p, q, 1e-15L * size_, e.value, -1});
        } else if (d_.pieces(e).empty()) {
            trace_circle(e, where, from, to);
        } else {
            trace_pieces(e, where, from, to, rng);
        }
        for (std::size_t i = first; i < segments_.size(); ++i) check_on_edge(e, where, segments_[i].to);
        const Segment middle_one =
            segments_.size() > first ? segments_[first + (segments_.size() - first) / 2] : Segment{};
        if (segments_.size() > first && middle(middle_one)) check_on_edge(e, where, *middle(middle_one));
    }

    void trace_circle(EdgeId e, const std::string& where, VertexId from, VertexId to) {
        const auto [K, A, B, C] = circle(d_.edges[e]);
        Segment s{{}, {}, 0, e.value, -1};
        const Real r2 = K == 0 ? Real(-1) : Real((A * A + B * B) / (4 * K * K) - C / K);
        if (!from.valid()) {
            if (r2 <= 0) return complain(where + ": closed, but its curve is no circle");
            const Real x = -A / (2 * K), y = -B / (2 * K), r = sqrt(r2);
            const int turn = K > 0 ? 1 : -1;
            const std::array<Point<Real>, 4> at{
                Point<Real>{x + r, y}, {x, y + turn * r}, {x - r, y}, {x, y - turn * r}};
            for (int i = 0; i < 4; ++i) {
                s.from = fast(at[i]);
                s.to = fast(at[(i + 1) % 4]);
                add_segment(s, 2);
            }
            return;
        }
        s.from = at_[from.value];
        s.to = at_[to.value];
        if (K != 0 && r2 > 0) {
            // More than half a turn: cut opposite the chord's middle.
            const Fast cx = Real(-A / (2 * K)).convert_to<Fast>(), cy = Real(-B / (2 * K)).convert_to<Fast>(),
                       r = Real(sqrt(r2)).convert_to<Fast>();
            const Fast side =
                ((s.to.x - s.from.x) * (cy - s.from.y) - (s.to.y - s.from.y) * (cx - s.from.x)) *
                (K > 0 ? 1 : -1);
            if (side < 0 || from == to) {
                const Fast chord = apart(s.from, s.to), turn = K > 0 ? 1 : -1;
                const Point<Fast> out = chord > 0 ? Point<Fast>{turn * (s.to.y - s.from.y) / chord,
                                                                -turn * (s.to.x - s.from.x) / chord}
                                                  : Point<Fast>{(cx - s.from.x) / r, (cy - s.from.y) / r};
                Segment half = s;
                half.to = {cx + r * out.x, cy + r * out.y};
                s.from = half.to;
                add_segment(half, 4);
                add_segment(s, 4);
                return;
            }
        }
        add_segment(s, 3);
    }

    void trace_pieces(EdgeId e, const std::string& where, VertexId from, VertexId to, std::mt19937_64& rng) {
        const auto& edge = d_.edges[e];
        const auto pieces = d_.pieces(e);
        Eigen::Vector2d start = from.valid() ? d_.vertices[from].point : pieces.back().end;
        double start_error = from.valid() ? d_.vertices[from].error : pieces.back().error;
        if (to.valid() && !((pieces.back().end - d_.vertices[to].point).norm() <=
                            pieces.back().error + d_.vertices[to].error))
            complain(where + ": its last piece does not end at its target");
        Point<Fast> p = from.valid() ? at_[from.value] : Point<Fast>{start.x(), start.y()};
        std::optional<Point<Fast>> closing;
        std::uniform_real_distribution<double> unit(0, 1);
        for (std::size_t i = 0; i < pieces.size(); ++i) {
            const auto& piece = pieces[i];
            const auto& [x0, x1, y0, y1] = piece.box;
            if (!(std::abs(piece.direction.norm() - 1) < 1e-14))
                complain(where + ": a direction is not of unit length");
            for (const auto& [q, error] : {std::pair(start, start_error), std::pair(piece.end, piece.error)})
                if (q.x() < x0 - error || q.x() > x1 + error || q.y() < y0 - error || q.y() > y1 + error)
                    complain(where + ": a piece ends outside of its box");
            // Around a node, and where a point was assumed, the direction is only that across the chord.
            const Fast width = std::max(x1 - x0, y1 - y0);
            if (width > 0x1p-22L * size_)
                for (int k = 0; k < 4; ++k) {
                    const Point<Fast> q{x0 + (x1 - x0) * unit(rng), y0 + (y1 - y0) * unit(rng)};
                    if (!in_region(q, 0)) continue;
                    const auto v = difference(edge, q);
                    if (!(v[1] * piece.direction.x() + v[2] * piece.direction.y() > 0))
                        complain(where + ": the difference does not grow along a piece's direction at " +
                                 place(q));
                }
            // The end, moved onto the curve.
            Point<Fast> q{piece.end.x(), piece.end.y()};
            const auto v = difference(edge, q);
            const Fast slope = std::hypot(v[1], v[2]);
            const bool last = i + 1 == pieces.size();
            if (slope > 1e-6L && width > 0x1p-22L * size_ &&
                std::abs(v[0]) > slope * piece.error * 1.01L + difference_error(edge, q))
                complain(where + ": a piece ends " + text(std::abs(v[0]) / slope / piece.error) +
                         " times its bound away from the curve");
            if (last && to.valid())
                q = at_[to.value];
            else if (last && closing)
                q = *closing;
            else if (const auto on = onto_arc(e, i, q, std::max<Fast>(piece.error, 1e-15L * size_)))
                q = *on;
            if (i == 0 && !from.valid()) {
                if (const auto on = onto_arc(e, 0, p, std::max<Fast>(start_error, 1e-15L * size_))) p = *on;
                closing = p;
                if (last) q = p;
            }
            add_segment({p, q, 0, e.value, static_cast<std::int32_t>(i)}, 0);
            p = q;
            start = piece.end;
            start_error = piece.error;
        }
    }

    // Both sides' forms agree, and none is lower, as far as long double tells.
    void check_on_edge(EdgeId e, const std::string& where, const Point<Fast>& p) {
        const Fast width = assumed_width(p, 1e-12L * size_);
        const auto& edge = d_.edges[e];
        if (!in_region(p, -1e-14L * size_ - width)) complain(where + ": leaves the region at " + place(p));
        Fast top = HUGE_VALL;
        std::vector<Fast> low(solids_.size());
        for (std::size_t i = 0; i < solids_.size(); ++i) {
            const Height<Fast> h = height<Fast>(solids_[i], p.x, p.y);
            const Fast slack =
                4 * rounding(i, p, h) + (2 * width + 1e-18L * size_) * (std::abs(h.gx) + std::abs(h.gy));
            low[i] = h.v - slack;
            top = std::min(top, h.v + slack);
        }
        for (const FormId f : d_.label(e))
            if (f.valid() && low[f.value] > top)
                complain(where + ": another form is lower than " + to_string(f) + " at " + place(p));
        if (edge.on_rim()) return;
        const auto v = difference(edge, p);
        if (width == 0 &&
            std::abs(v[0]) > 8 * difference_error(edge, p) + 1e-17L * size_ * std::hypot(v[1], v[2]))
            complain(where + ": its forms differ at " + place(p));
    }

    std::vector<Segment> segments_;  // of all edges, along half-edge 2e
};

}  // namespace vcell::mixed
