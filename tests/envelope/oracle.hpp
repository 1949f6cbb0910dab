/// A brute-force judge of minimization diagrams. It shares no code with lower_envelope() but the types:
/// rational arithmetic for ties, 100 digits for vertices and arcs, winding numbers for point location.
///
/// All work is done in local coordinates, relative to the middle of the region: a shifted scene is judged
/// as sharply as a centred one.
#pragma once

#include <algorithm>
#include <array>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <boost/multiprecision/cpp_int.hpp>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <random>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "../../envelope/diagram/minimization_diagram.hpp"

namespace vcell::oracle {

using Rational = boost::multiprecision::cpp_rational;
using Real =
    boost::multiprecision::number<boost::multiprecision::cpp_bin_float<100>, boost::multiprecision::et_off>;

inline Rational to_rational(Exact v) {
    Rational sum = 0;
    while (v.sign() != Sign::Zero) {  // each step takes the leading 53 bits away
        const double head = v.enclosure().lower();
        if (head == 0) throw std::range_error("oracle: coefficient below the double range");
        sum += Rational(head);
        v -= Exact(head);
    }
    return sum;
}
inline Real to_real(const Rational& q) { return Real(numerator(q)) / Real(denominator(q)); }
template <class T>
T to(const Rational& q) {
    if constexpr (std::is_same_v<T, Rational>)
        return q;
    else if constexpr (std::is_same_v<T, Real>)
        return to_real(q);
    else
        return to_real(q).template convert_to<T>();
}

template <class T>
struct Point {
    T x, y;
};

/// K (x^2 + y^2) + A x + B y + C: a circle or a line, and the numerator of a form.
template <class T>
struct Quadric {
    T K, A, B, C;

    T operator()(const Point<T>& p) const { return K * (p.x * p.x + p.y * p.y) + A * p.x + B * p.y + C; }
    Point<T> gradient(const Point<T>& p) const { return {2 * K * p.x + A, 2 * K * p.y + B}; }
    Quadric operator-() const { return {-K, -A, -B, -C}; }
    template <class S>
    Quadric<S> as() const {
        return {to<S>(K), to<S>(A), to<S>(B), to<S>(C)};
    }
};

/// A form: quadric over W > 0.
template <class T>
struct Form {
    Quadric<T> n;
    T W;

    T operator()(const Point<T>& p) const { return n(p) / W; }
};

/// The zero set of f - g, negative where f is lower.
inline Quadric<Rational> difference(const Form<Rational>& f, const Form<Rational>& g) {
    return {f.n.K * g.W - g.n.K * f.W, f.n.A * g.W - g.n.A * f.W, f.n.B * g.W - g.n.B * f.W,
            f.n.C * g.W - g.n.C * f.W};
}

/// The points common to two curves: none when they are disjoint, concentric or the same.
inline std::vector<Point<Real>> intersect(const Quadric<Rational>& g, const Quadric<Rational>& h) {
    const Quadric<Rational>& circle = g.K != 0 ? g : h;
    // The member of their pencil without a square term, exact: a common line.
    const Quadric<Rational> line{0, h.K * g.A - g.K * h.A, h.K * g.B - g.K * h.B, h.K * g.C - g.K * h.C};
    if (circle.K == 0) {
        const Rational det = g.A * h.B - g.B * h.A;
        if (det == 0) return {};
        return {{to_real((g.B * h.C - h.B * g.C) / det), to_real((h.A * g.C - g.A * h.C) / det)}};
    }
    if (line.A == 0 && line.B == 0) return {};
    // Foot of the centre on the line, plus and minus the half chord along it; all but the root rational.
    const Rational cx = -circle.A / (2 * circle.K), cy = -circle.B / (2 * circle.K);
    const Rational nn = line.A * line.A + line.B * line.B;
    const Rational s = (line.A * cx + line.B * cy + line.C) / nn;
    const Rational fx = cx - s * line.A, fy = cy - s * line.B;
    const Rational half2 = (cx * cx + cy * cy - circle.C / circle.K - s * s * nn) / nn;
    if (half2 < 0) return {};
    const Real x = to_real(fx), y = to_real(fy), a = to_real(line.A), b = to_real(line.B);
    if (half2 == 0) return {{x, y}};
    const Real t = sqrt(to_real(half2));
    return {{x - t * b, y + t * a}, {x + t * b, y - t * a}};
}

/// The only point of a circle of radius 0.
inline std::optional<Point<Real>> point_circle(const Quadric<Rational>& g) {
    if (g.K == 0 || g.A * g.A + g.B * g.B != 4 * g.K * g.C) return std::nullopt;
    return Point<Real>{to_real(-g.A / (2 * g.K)), to_real(-g.B / (2 * g.K))};
}

struct OracleOptions {
    int samples = 1000;                  ///< points of the region whose owner is compared
    std::size_t brute_force_forms = 16;  ///< up to this many forms all triples are tried for missing vertices
};

class DiagramOracle {
public:
    DiagramOracle(const MinimizationDiagram& diagram, const FormFamily& family)
        : d_(diagram), family_(family), dcel_(diagram.dcel) {
        find_origin();
        for (const FormId f : family.forms.ids()) {
            const ExactForm e = family.exact(f);
            const Form<Rational> q{
                localise({to_rational(e.K), to_rational(e.A), to_rational(e.B), to_rational(e.C)}),
                to_rational(e.W)};
            forms_.push_back(q);
            real_forms_.push_back({q.n.as<Real>(), to_real(q.W)});
            fast_forms_.push_back({q.n.as<long double>(), to<long double>(q.W)});
        }
    }

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
    using Fast = long double;

    // Values closer than this, relative to their size, are equal: 100 digits resolve 1e-95, and distinct
    // algebraic numbers of these degrees over doubles of moderate range stay well apart of 1e-60.
    static inline const Real kTie{"1e-60"};
    // Sampled points this close to an edge, relative to the region's size, are not asked about.
    static constexpr Fast kSkip = 1e-9L;
    static constexpr std::size_t kEnough = 20;  // complaints

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

    void complain(const std::string& what) {
        if (complaints_.size() < kEnough) complaints_.push_back(what);
    }

    // --- Set-up ---------------------------------------------------------------------------------

    void find_origin() {
        const std::size_t n = d_.region.sides.size();
        if (n < 3) throw std::invalid_argument("oracle: a region has at least three sides");
        Bounds box;
        for (std::size_t i = 0; i < n; ++i) {
            const auto& s = d_.region.sides[i];
            const auto& t = d_.region.sides[(i + 1) % n];
            const Fast det = Fast(s.a) * t.b - Fast(s.b) * t.a;
            const Fast x = (Fast(s.b) * t.c - Fast(t.b) * s.c) / det;
            const Fast y = (Fast(t.a) * s.c - Fast(s.a) * t.c) / det;
            box.x0 = std::min(box.x0, x), box.x1 = std::max(box.x1, x);
            box.y0 = std::min(box.y0, y), box.y1 = std::max(box.y1, y);
        }
        origin_ = {static_cast<double>((box.x0 + box.x1) / 2), static_cast<double>((box.y0 + box.y1) / 2)};
        half_ = {(box.x1 - box.x0) / 2, (box.y1 - box.y0) / 2};
        size_ = std::max(half_.x, half_.y);
        for (const auto& s : d_.region.sides)
            sides_.push_back(localise({0, Rational(s.a), Rational(s.b), Rational(s.c)}));
    }

    Quadric<Rational> localise(const Quadric<Rational>& g) const {
        const Rational x(origin_.x), y(origin_.y);
        return {g.K, g.A + 2 * g.K * x, g.B + 2 * g.K * y, g.C + g.A * x + g.B * y + g.K * (x * x + y * y)};
    }

    // --- Brute force ----------------------------------------------------------------------------

    /// All forms that attain the minimum at p, ascending. T is Real or Rational; exact for the latter.
    template <class T>
    std::vector<FormId> minimal(const Point<T>& p, const std::vector<Form<T>>& forms) const {
        Point<Fast> q;
        if constexpr (std::is_same_v<T, Rational>)
            q = {to<Fast>(p.x), to<Fast>(p.y)};
        else
            q = {p.x.template convert_to<Fast>(), p.y.template convert_to<Fast>()};
        // long double rules out all that is higher by more than its rounding.
        std::vector<Fast> low(forms.size());
        Fast lowest_upper = HUGE_VALL;
        for (std::size_t i = 0; i < forms.size(); ++i) {
            const Form<Fast>& f = fast_forms_[i];
            const Fast size = std::abs(f.n.K) * (q.x * q.x + q.y * q.y) + std::abs(f.n.A * q.x) +
                              std::abs(f.n.B * q.y) + std::abs(f.n.C);
            const Fast value = f(q);
            Fast error = 16 * std::numeric_limits<Fast>::epsilon() * size / f.W;
            // Next to the origin all terms of a form may be as small as the error of a refined p.
            if constexpr (std::is_same_v<T, Real>)
                error += kTie.template convert_to<Fast>() * (1 + std::abs(value));
            low[i] = value - error;
            lowest_upper = std::min(lowest_upper, value + error);
        }
        std::vector<FormId> result;
        std::optional<T> best;
        for (std::size_t i = 0; i < forms.size(); ++i) {
            if (low[i] > lowest_upper) continue;
            const T value = forms[i](p);
            T slack = 0;
            if constexpr (std::is_same_v<T, Real>) slack = kTie * (1 + abs(value));
            if (best && value > *best + slack) continue;
            if (best && value < *best - slack) result.clear();
            if (!best || value < *best) best = value;
            result.push_back({static_cast<std::uint32_t>(i)});
        }
        return result;
    }

    bool inside(const Point<Real>& p) const {
        return std::ranges::all_of(sides_, [&](const auto& s) {
            const Quadric<Real> g = s.template as<Real>();
            return g(p) >= -kTie * (abs(g.A) + abs(g.B)) * size_;
        });
    }
    bool on_side(const Point<Real>& p, std::size_t side) const {
        const Quadric<Real> g = sides_[side].as<Real>();
        return abs(g(p)) <= kTie * (abs(g.A) + abs(g.B)) * size_;
    }

    // --- Structure and labels -------------------------------------------------------------------

    template <class Ids>
    static std::string name(const Ids& ids) {
        std::string s = "{";
        for (const auto& id : ids) s += (s.size() > 1 ? " " : "") + to_string(id);
        return s + "}";
    }
    template <class Ids>
    static bool ascending(const Ids& ids) {
        return std::ranges::adjacent_find(ids, [](auto a, auto b) { return !(a < b); }) == ids.end();
    }

    void check_structure() {
        if (const auto defect = dcel_.find_defect()) return complain("dcel: " + defect->what);
        if (d_.vertices.size() != dcel_.vertex_count() || d_.edges.size() != dcel_.edge_count() ||
            d_.face_forms.size() != dcel_.face_count() || d_.forms.size() != family_.forms.size())
            return complain("sizes: the diagram's arrays do not match its dcel");
        if (d_.vertex_offsets_.size() != d_.vertices.size() + 1 ||
            d_.side_offsets_.size() != d_.vertices.size() + 1 ||
            d_.edge_offsets_.size() != d_.edges.size() + 1)
            return complain("sizes: label offsets do not match");
        if (d_.face_forms[Dcel::unbounded_face()].valid()) complain("f0: the unbounded face has a label");
        for (const FaceId f : d_.face_forms.ids()) {
            if (f == Dcel::unbounded_face()) continue;
            const FormId form = d_.face_forms[f];
            if (form.valid() ? form.value >= forms_.size() : !forms_.empty())
                complain(to_string(f) + ": label " + to_string(form));
        }
        for (const VertexId v : d_.vertices.ids()) {
            if (!ascending(d_.label(v))) complain(to_string(v) + ": label not ascending");
            for (const FormId f : d_.label(v))
                if (f.value >= forms_.size()) complain(to_string(v) + ": label out of range");
            for (const std::uint32_t s : d_.sides(v))
                if (s >= sides_.size()) complain(to_string(v) + ": side out of range");
            const FaceId around = dcel_.isolated_in(v);
            if (around.valid()) check_label_part(to_string(v), d_.label(v), d_.label(around));
        }
        for (const EdgeId e : d_.edges.ids()) check_edge_structure(e);
        if (complaints_.empty())
            for (const VertexId v : d_.vertices.ids()) check_maximal(v);
    }

    template <class Label, class Part>
    void check_label_part(const std::string& where, const Label& label, const Part& part) {
        for (const auto& id : part)
            if (std::ranges::find(label, id) == label.end())
                complain(where + ": label " + name(label) + " lacks its neighbour's " + to_string(id));
    }

    void check_edge_structure(EdgeId e) {
        const auto& edge = d_.edges[e];
        const HalfEdgeId h = Dcel::half_edge(e);
        const FaceId left = dcel_.face(h), right = dcel_.face(Dcel::twin(h));
        const std::string where = to_string(e);
        if (!ascending(d_.label(e))) complain(where + ": label not ascending");
        if (edge.left != d_.face_forms[left]) complain(where + ": left is not the form of the left face");
        if (edge.on_rim()) {
            if (edge.side >= sides_.size()) complain(where + ": side out of range");
            if (edge.right.valid()) complain(where + ": on the rim with a form on the right");
            if (right != Dcel::unbounded_face()) complain(where + ": on the rim, but not of the region");
        } else {
            if (edge.right != d_.face_forms[right])
                complain(where + ": right is not the form of the right face");
            if (edge.left == edge.right) complain(where + ": the same form on both sides");
            if (left == Dcel::unbounded_face() || right == Dcel::unbounded_face())
                complain(where + ": borders the unbounded face, but is not on the rim");
        }
        check_label_part(where, d_.label(e), d_.label(left));
        check_label_part(where, d_.label(e), d_.label(right));
        for (const VertexId v : {dcel_.origin(h), dcel_.target(h)}) {
            if (!v.valid()) continue;
            check_label_part(to_string(v), d_.label(v), d_.label(e));
            if (edge.on_rim() && std::ranges::find(d_.sides(v), edge.side) == d_.sides(v).end())
                complain(to_string(v) + ": ends a rim edge of side " + std::to_string(edge.side) +
                         " without lying on it");
        }
    }

    /// A vertex of degree two between like edges has no business there.
    void check_maximal(VertexId v) {
        const HalfEdgeId h = dcel_.outgoing(v);
        if (!h.valid()) {
            if (d_.label(v).size() < 2) complain(to_string(v) + ": isolated without a tie");
            return;
        }
        const HalfEdgeId g = dcel_.next_around_origin(h);
        if (g == h || dcel_.next_around_origin(g) != h) return;
        const auto &a = d_.edges[Dcel::edge(h)], &b = d_.edges[Dcel::edge(g)];
        const auto la = d_.label(Dcel::edge(h)), lv = d_.label(v);
        const bool alike = a.side == b.side && std::minmax(a.left, a.right) == std::minmax(b.left, b.right) &&
                           std::ranges::equal(la, d_.label(Dcel::edge(g)));
        if (alike && std::ranges::equal(la, lv) && Dcel::edge(h) != Dcel::edge(g))
            complain(to_string(v) + ": joins two edges that are one");
    }

    // --- Vertices -------------------------------------------------------------------------------

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
        for (std::size_t i = 0; i < curves.size(); ++i) {
            const Point<Fast> g = curves[i].as<Fast>().gradient(q);
            for (std::size_t j = 0; j < i; ++j) {
                const Point<Fast> h = curves[j].as<Fast>().gradient(q);
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

    // --- Arcs -----------------------------------------------------------------------------------

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

    // --- Faces ----------------------------------------------------------------------------------

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
            const bool in_region = std::ranges::all_of(sides_, [&](const auto& s) {
                const auto g = s.template as<Fast>();
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

    // --- Completeness ---------------------------------------------------------------------------

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

    const MinimizationDiagram& d_;
    const FormFamily& family_;
    const Dcel& dcel_;
    Point<double> origin_{};
    Point<Fast> half_{};
    Fast size_ = 0;
    std::vector<Quadric<Rational>> sides_;
    std::vector<Form<Rational>> forms_;
    std::vector<Form<Real>> real_forms_;
    std::vector<Form<Fast>> fast_forms_;
    std::vector<Point<Real>> refined_;      // by vertex
    std::vector<std::vector<Piece>> arcs_;  // by edge, along half-edge 2e
    std::vector<Bounds> bounds_;            // by face
    std::vector<std::string> complaints_;
};

/// Everything that brute force has to say against a diagram; empty: nothing. Checks in order: the dcel's
/// invariants and the labels' inclusions; each vertex (refined from its label; all and only the labelled
/// forms are lowest; place and height within their bounds); each arc at three points; the face of sampled
/// points; for few forms, that no vertex is missing. A failed stage ends the judgement.
inline std::vector<std::string> check_diagram(const MinimizationDiagram& diagram, const FormFamily& family,
                                              std::mt19937_64& rng, const OracleOptions& options = {}) {
    return DiagramOracle(diagram, family).check(rng, options);
}

/// Renames the parts of a diagram, for comparison with that of a transformed scene.
struct Renaming {
    std::vector<std::uint32_t> form;  ///< new number of each form
    std::vector<std::uint32_t> side;  ///< new number of each side of the region
    bool mirrored = false;            ///< left becomes right
};

/// The combinatorial diagram in a normal form: equal strings exactly for equal diagrams with equal labels.
/// Lists vertices (label, sides, faces in cyclic order), edges (label, sides' forms, end labels) and faces
/// (form, boundary components as cycles of neighbours, isolated vertices), each sorted.
inline std::vector<std::string> canonical(const MinimizationDiagram& d, const Renaming& r) {
    const Dcel& dcel = d.dcel;
    const auto form = [&](FormId f) {
        return f.valid() ? std::to_string(r.form[f.value]) : std::string("-");
    };
    const auto forms = [&](std::span<const FormId> label) {
        std::set<std::uint32_t> sorted;
        for (const FormId f : label) sorted.insert(r.form[f.value]);
        std::string s = "{";
        for (const std::uint32_t f : sorted) s += std::to_string(f) + " ";
        return s + "}";
    };
    const auto vertex = [&](VertexId v) {
        if (!v.valid()) return std::string("closed");
        std::set<std::uint32_t> sides;
        for (const std::uint32_t s : d.sides(v)) sides.insert(r.side[s]);
        std::string s = forms(d.label(v)) + "[";
        for (const std::uint32_t i : sides) s += std::to_string(i) + " ";
        return s + "]";
    };
    const auto cycle = [&](std::vector<std::string> parts) {
        if (r.mirrored) std::ranges::reverse(parts);
        std::string best;
        for (std::size_t i = 0; i < parts.size(); ++i) {
            std::ranges::rotate(parts, parts.begin() + 1);
            std::string s;
            for (const auto& p : parts) s += p + ",";
            if (best.empty() || s < best) best = s;
        }
        return "(" + best + ")";
    };
    const auto component = [&](CcbId c) {
        std::vector<std::string> parts;
        HalfEdgeId h = dcel.start(c);
        do {
            parts.push_back(form(d.face_forms[dcel.face(Dcel::twin(h))]));
            h = dcel.next(h);
        } while (h != dcel.start(c));
        return cycle(parts);
    };
    std::vector<std::string> result;
    for (const VertexId v : d.vertices.ids()) {
        std::vector<std::string> around;
        if (const HalfEdgeId first = dcel.outgoing(v); first.valid()) {
            HalfEdgeId h = first;
            do {
                around.push_back(form(d.face_forms[dcel.face(h)]));
                h = dcel.next_around_origin(h);
            } while (h != first);
        }
        result.push_back("vertex " + vertex(v) + cycle(around));
    }
    for (const EdgeId e : d.edges.ids()) {
        const auto& edge = d.edges[e];
        const HalfEdgeId h = Dcel::half_edge(e);
        // Seen from its smaller side; turned round, or mirrored, an edge starts where it ended. Without
        // labels, a rim edge keeps the region on its left in the mirror too.
        std::array<std::string, 2> sides{form(edge.left), form(edge.right)};
        std::array<std::string, 2> ends{vertex(dcel.origin(h)), vertex(dcel.target(h))};
        if (r.mirrored) std::swap(sides[0], sides[1]);
        if (sides[1] < sides[0] || (r.mirrored && sides[0] == sides[1])) {
            std::swap(sides[0], sides[1]);
            std::swap(ends[0], ends[1]);
        }
        result.push_back("edge " + forms(d.label(e)) + sides[0] + "|" + sides[1] + " " + ends[0] + "->" +
                         ends[1] + (edge.on_rim() ? " side " + std::to_string(r.side[edge.side]) : ""));
    }
    for (const FaceId f : d.face_forms.ids()) {
        std::vector<std::string> parts;
        for (const CcbId c : dcel.inner_ccbs(f)) parts.push_back("hole" + component(c));
        for (const VertexId v : dcel.isolated_vertices(f)) parts.push_back("isolated" + vertex(v));
        std::ranges::sort(parts);
        std::string s = "face " + form(d.face_forms[f]);
        if (dcel.outer_ccb(f).valid()) s += component(dcel.outer_ccb(f));
        for (const auto& p : parts) s += " " + p;
        result.push_back(s);
    }
    std::ranges::sort(result);
    return result;
}

}  // namespace vcell::oracle
