#include "chart_arc.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <numbers>
#include <unordered_map>

#include "../../arrangement/circles/circle_kernel.hpp"
#include "../../arrangement/circles/curve_order.hpp"
#include "../../core/errors.hpp"
#include "../../primitives/objects/message.hpp"
#include "settled_vertices.hpp"

namespace vcell {

namespace {

using Eigen::Vector2d;

using roundoff::u;

// Spans turn by 1.6 rad at most: a full circle takes four, weights stay above 0.69.
constexpr double largest_turn = 1.6;

// Chord directions and tangents that may be off by more than this (radians) do not tell an arc that is
// next to nothing from one that is all but the full circle.
constexpr double largest_doubt = 0.1;

Vector2d turned(const Vector2d& p, double angle) {
    const double c = std::cos(angle), s = std::sin(angle);
    return {c * p.x() - s * p.y(), s * p.x() + c * p.y()};
}

// The direction of the gradient of f - g at p with a bound on its rounding error, relative to its length.
struct Gradient {
    Vector2d value;
    double doubt;
};

// The exact difference is taken of forms so much alike that this many digits are lost.
constexpr double largest_loss = 0x1p-32;

Gradient gradient_of_difference(const FormFamily& family, FormId f, FormId g, const Vector2d& p) {
    const Vector2d df = gradient(family.forms[f], p), dg = gradient(family.forms[g], p);
    const Vector2d d = df - dg;
    // Each component carries the 4u of its form's coefficients and a few roundings of its own.
    const double doubt = 16 * u * (df.norm() + dg.norm()) / d.norm();
    if (doubt < largest_loss) return {d, doubt};
    return {settled_gradient(family, f, g, p), 4 * u};
}

}  // namespace

// Makes the arcs of one task's edges, ascending.
class ChartArcs::Maker {
public:
    Maker(const FormFamily& family, const MinimizationDiagram& diagram, ChartArcs& arcs, Part& part)
        : family_(family),
          diagram_(diagram),
          spans_(part.spans),
          errors_(arcs.errors_),
          is_line_(arcs.is_line_),
          decisions_(part.decisions) {}

    void add_edge(EdgeId e);

private:
    struct Circle {
        Vector2d center;
        double radius;
    };

    void add_line(EdgeId e);
    void add_full_circle(EdgeId e, double turn, const Circle& circle);
    void add_circular_arc(EdgeId e, double turn);
    void add_around_center(EdgeId e, const Circle& circle, double angle);
    // The exact form's terms in |p|^2: a form has several edges, and making it exact is dear.
    struct Curvature {
        Exact K, W;
    };
    const Curvature& exact_curvature(FormId f);
    Sign curvature_sign(FormId f, FormId g);
    Circle circle(FormId f, FormId g) const;
    double exact_turn(EdgeId e, double turn);
    FormId circular_successor(EdgeId e, VertexId v) const;
    bool is_lower_along(EdgeId e, FormId third) const;
    bool ends_at_circular(EdgeId e) const;
    bool is_taken_beyond(EdgeId e, const Circle& circle, double turn, double off);
    bool is_major_arc(EdgeId e, const Circle& circle);

    const FormFamily& family_;
    const MinimizationDiagram& diagram_;
    std::vector<ArcSpan>& spans_;
    IdVector<EdgeId, double>& errors_;
    IdVector<EdgeId, std::uint8_t>& is_line_;
    Decisions& decisions_;
    std::unordered_map<std::uint32_t, Curvature> curvatures_;  // of forms for which doubles did not do
};

// visit(begin, end, add) calls add(e) for those edges begin <= e < end that have arcs, ascending.
template <class Visit>
void ChartArcs::make(const FormFamily& family, const MinimizationDiagram& diagram, unsigned threads,
                     const Visit& visit) {
    const std::size_t count = diagram.edges.size();
    parts_.resize(range_count(count));
    errors_ = IdVector<EdgeId, double>(count, 0.0);
    is_line_ = IdVector<EdgeId, std::uint8_t>(count, 1);
    for_ranges(count, threads, [&](std::size_t begin, std::size_t end, std::size_t task) {
        Part& part = parts_[task];
        part.ends.reserve(end - begin + 1);
        Maker maker(family, diagram, *this, part);
        const auto pass_to = [&](std::size_t edge) {
            part.ends.resize(edge - begin + 1, static_cast<std::uint32_t>(part.spans.size()));
        };
        visit(static_cast<std::uint32_t>(begin), static_cast<std::uint32_t>(end), [&](EdgeId e) {
            pass_to(e.value);
            maker.add_edge(e);
        });
        pass_to(end);
    });
    for (const Part& part : parts_) decisions_ += part.decisions;
}

ChartArcs::ChartArcs(const FormFamily& family, const MinimizationDiagram& diagram, unsigned threads) {
    make(family, diagram, threads, [](std::uint32_t begin, std::uint32_t end, const auto& add) {
        for (std::uint32_t e = begin; e < end; ++e) add(EdgeId{e});
    });
}

ChartArcs::ChartArcs(const FormFamily& family, const MinimizationDiagram& diagram,
                     std::span<const EdgeId> edges) {
    make(family, diagram, 1, [&](std::uint32_t begin, std::uint32_t end, const auto& add) {
        for (auto e = std::ranges::lower_bound(edges, EdgeId{begin}); e != edges.end() && e->value < end; ++e)
            add(*e);
    });
}

void ChartArcs::Maker::add_edge(EdgeId e) {
    const MinimizationDiagram::Edge& edge = diagram_.edges[e];
    if (!diagram_.is_circular(edge.left) || (!edge.on_rim() && !diagram_.is_circular(edge.right))) return;
    if (edge.on_rim()) return add_line(e);
    const Sign sign = curvature_sign(edge.left, edge.right);
    if (sign == Sign::Zero) return add_line(e);
    is_line_[e] = false;
    // left - right = K |p|^2 + ... is negative left of the edge: inside the circle where K > 0.
    const double turn = static_cast<int>(sign);
    const VertexId from = diagram_.dcel.origin(Dcel::half_edge(e)),
                   to = diagram_.dcel.target(Dcel::half_edge(e));
    if (from == to)
        add_full_circle(e, turn, circle(edge.left, edge.right));
    else
        add_circular_arc(e, turn);
}

void ChartArcs::Maker::add_line(EdgeId e) {
    const MinimizationDiagram::Vertex& p = diagram_.vertices[diagram_.dcel.origin(Dcel::half_edge(e))];
    const MinimizationDiagram::Vertex& q = diagram_.vertices[diagram_.dcel.target(Dcel::half_edge(e))];
    spans_.push_back({p.point, q.point, 0});
    errors_[e] = std::max(p.error, q.error);
}

void ChartArcs::Maker::add_full_circle(EdgeId e, double turn, const Circle& c) {
    const VertexId v = diagram_.dcel.origin(Dcel::half_edge(e));
    if (v.valid()) {
        add_around_center(e, c, 2 * std::numbers::pi * turn);
        return;
    }
    // Quarters that begin on the axes: their control points are the corners and sides of a square.
    const Vector2d x(c.radius, 0), y(0, turn * c.radius);
    const double quarter = turn * std::numbers::pi / 4;
    spans_.push_back({c.center + x, c.center + y, quarter});
    spans_.push_back({c.center + y, c.center - x, quarter});
    spans_.push_back({c.center - x, c.center - y, quarter});
    spans_.push_back({c.center - y, c.center + x, quarter});
    errors_[e] = 4 * u * (c.center.norm() + c.radius);
}

// From the edge's start about the centre by `angle`, the last span ending at the edge's end.
void ChartArcs::Maker::add_around_center(EdgeId e, const Circle& c, double angle) {
    const MinimizationDiagram::Vertex& start = diagram_.vertices[diagram_.dcel.origin(Dcel::half_edge(e))];
    const MinimizationDiagram::Vertex& end = diagram_.vertices[diagram_.dcel.target(Dcel::half_edge(e))];
    const int count = std::max(1, static_cast<int>(std::ceil(std::abs(angle) / largest_turn)));
    const Vector2d spoke = (start.point - c.center).normalized() * c.radius;
    Vector2d from = start.point;
    for (int i = 1; i <= count; ++i) {
        const Vector2d to = i == count ? end.point : Vector2d(c.center + turned(spoke, angle * i / count));
        spans_.push_back({from, to, 0.5 * angle / count});
        from = to;
    }
    errors_[e] = 2 * (start.error + end.error) + 16 * u * (c.center.norm() + c.radius);
}

// The chord makes the same angle (half of what the arc turns by) with the tangents at both ends. Both
// angles come from the forms at the end points alone, so nothing grows with the radius.
void ChartArcs::Maker::add_circular_arc(EdgeId e, double turn) {
    const MinimizationDiagram::Edge& edge = diagram_.edges[e];
    const MinimizationDiagram::Vertex& p = diagram_.vertices[diagram_.dcel.origin(Dcel::half_edge(e))];
    const MinimizationDiagram::Vertex& q = diagram_.vertices[diagram_.dcel.target(Dcel::half_edge(e))];
    const Gradient at_p = gradient_of_difference(family_, edge.left, edge.right, p.point),
                   at_q = gradient_of_difference(family_, edge.left, edge.right, q.point);
    const Vector2d chord = q.point - p.point;
    // left - right grows to the right of the edge.
    const Vector2d tp(-at_p.value.y(), at_p.value.x()), tq(-at_q.value.y(), at_q.value.x());
    const double half_p = std::atan2(turn * cross(tp, chord), tp.dot(chord));
    const double half_q = std::atan2(turn * cross(chord, tq), chord.dot(tq));
    const double radius = chord.norm() / (2 * std::abs(std::sin(half_p)));
    double doubt = (p.error + q.error) * (1 / chord.norm() + 1 / radius) + std::max(at_p.doubt, at_q.doubt);
    double half;
    if (doubt < largest_doubt) {
        // Rounding may turn an angle near 0 or pi to the other side of it, no more.
        const auto settled = [](double angle) {
            return angle >= 0 ? angle : angle > -1.0 ? 0.0 : std::numbers::pi;
        };
        half = 0.5 * (settled(half_p) + settled(half_q));
    } else {
        half = 0.5 * exact_turn(e, turn);
        doubt = 16 * u;
    }
    if (2 * half > largest_turn) {
        if (std::sin(half) < 0.5) return add_around_center(e, circle(edge.left, edge.right), 2 * half * turn);
        // Seen from the centre, left of the chord where the arc turns left by less than a half turn, it is 2
        // half wide.
        const double to_center = 0.5 * turn / std::tan(half);
        const Vector2d center = 0.5 * (p.point + q.point) + to_center * Vector2d(-chord.y(), chord.x());
        add_around_center(e, {center, 0.5 * chord.norm() / std::sin(half)}, 2 * half * turn);
        // The centre moves by no more than chord / (2 sin^2) times the angle.
        errors_[e] += 4 * chord.norm() * doubt;
        return;
    }
    spans_.push_back({p.point, q.point, half * turn});
    // The end points' own errors, the tangents' (at most half a chord times their angle), rounding.
    errors_[e] = p.error + q.error + chord.norm() * doubt + 4 * u * (p.point.norm() + q.point.norm());
}

// By how much the edge's arc turns, from the exact circle: for end points that are hardly further apart than
// their errors, and for forms so much alike that the gradient of their difference is lost in rounding.
double ChartArcs::Maker::exact_turn(EdgeId e, double turn) {
    const MinimizationDiagram::Edge& edge = diagram_.edges[e];
    const MinimizationDiagram::Vertex& p = diagram_.vertices[diagram_.dcel.origin(Dcel::half_edge(e))];
    const MinimizationDiagram::Vertex& q = diagram_.vertices[diagram_.dcel.target(Dcel::half_edge(e))];
    const Circle c = circle(edge.left, edge.right);
    const Vector2d from = p.point - c.center, to = q.point - c.center;
    const double chord = (q.point - p.point).norm(), area = turn * cross(from, to);
    if (chord > 0.5 * c.radius) {
        const double angle = std::atan2(area, from.dot(to));
        return angle >= 0 ? angle : angle + 2 * std::numbers::pi;
    }
    // The area is at least 0.96 times the radius and the chord: more than what the ends are off, times the
    // radius.
    const double off = 2 * (p.error + q.error) + 16 * u * (c.center.norm() + c.radius);
    const bool is_major = ends_at_circular(e) ? is_major_arc(e, c)
                          : chord > off       ? area < 0
                                              : !is_taken_beyond(e, c, turn, off);
    const double minor = 2 * std::asin(0.5 * chord / c.radius);
    return is_major ? 2 * std::numbers::pi - minor : minor;
}

// Sign of K in f - g = K |p|^2 + ...; open where both have a quadratic part: K = k_f/w_f - k_g/w_g.
Sign ChartArcs::Maker::curvature_sign(FormId f, FormId g) {
    const CircularForm &F = diagram_.forms[f], &G = diagram_.forms[g];
    if (F.k == 0 || G.k == 0) return sign_of(F.k - G.k);
    const double difference = F.k * G.w - G.k * F.w;
    if (std::abs(difference) > 16 * u * (std::abs(F.k) * G.w + std::abs(G.k) * F.w)) {
        ++decisions_.by_double;
        return sign_of(difference);
    }
    ++decisions_.by_exact;
    const Curvature &a = exact_curvature(f), &b = exact_curvature(g);
    return (a.K * b.W - b.K * a.W).sign();
}

// A form is next to several others: it is made exact once.
const ChartArcs::Maker::Curvature& ChartArcs::Maker::exact_curvature(FormId f) {
    if (const auto known = curvatures_.find(f.value); known != curvatures_.end()) return known->second;
    const ExactForm form = family_.exact(f);
    return curvatures_.emplace(f.value, Curvature{form.K, form.W}).first->second;
}

// f - g = (K |p|^2 + A x + B y + C) / ..., exact up to the last step.
ChartArcs::Maker::Circle ChartArcs::Maker::circle(FormId f, FormId g) const {
    const ExactForm F = family_.exact(f), G = family_.exact(g);
    const Exact K = F.K * G.W - G.K * F.W, A = F.A * G.W - G.A * F.W, B = F.B * G.W - G.B * F.W,
                C = F.C * G.W - G.C * F.W;
    const Interval k = K.enclosure();
    const Interval r = sqrt((A * A + B * B - 4.0 * K * C).enclosure()) / (2.0 * k);
    return {{-0.5 * (A.enclosure() / k).mid(), -0.5 * (B.enclosure() / k).mid()}, std::abs(r.mid())};
}

// What takes over at an end: a circular form, if there is one.
FormId ChartArcs::Maker::circular_successor(EdgeId e, VertexId v) const {
    const std::span<const FormId> along = diagram_.label(e);
    for (const FormId f : diagram_.label(v))
        if (diagram_.is_circular(f) && std::find(along.begin(), along.end(), f) == along.end()) return f;
    return {};
}

// Is a form that takes over at an end the lower one along the edge? With a floor the greater of its forms
// shows, and of it and the rest the greater one or the lesser.
bool ChartArcs::Maker::is_lower_along(EdgeId e, FormId third) const {
    if (diagram_.floor.empty()) return false;
    const bool l = diagram_.is_of_floor(diagram_.edges[e].left),
               r = diagram_.is_of_floor(diagram_.edges[e].right);
    if (l != r) return diagram_.is_of_floor(third);
    if (l == diagram_.is_of_floor(third)) return l;
    return !diagram_.is_below_floor;
}

bool ChartArcs::Maker::ends_at_circular(EdgeId e) const {
    const auto is_known = [&](VertexId v) {
        return circular_successor(e, v).valid() || !diagram_.sides(v).empty();
    };
    return is_known(diagram_.dcel.origin(Dcel::half_edge(e))) &&
           is_known(diagram_.dcel.target(Dcel::half_edge(e)));
}

// Where the ends are within `off` of each other the longer arc is all but the whole circle, and nothing is
// lower anywhere on it but between them.
bool ChartArcs::Maker::is_taken_beyond(EdgeId e, const Circle& c, double turn, double off) {
    const FormId along = diagram_.edges[e].left;
    const auto height = [&](FormId form, const Interval& x, const Interval& y) {
        const ExactForm f = family_.exact(form);
        return (f.K.enclosure() * (square(x) + square(y)) + f.A.enclosure() * x + f.B.enclosure() * y +
                f.C.enclosure()) /
               f.W.enclosure();
    };
    const std::array ends{diagram_.dcel.origin(Dcel::half_edge(e)), diagram_.dcel.target(Dcel::half_edge(e))};
    for (const int end : {0, 1}) {
        const FormId third = circular_successor(e, ends[end]);
        if (!third.valid()) continue;
        const Vector2d spoke = diagram_.vertices[ends[end]].point - c.center;
        for (const double angle : {0x1p-2, 0x1p-6, 0x1p-10, 0x1p-14}) {
            if (angle * c.radius <= 4 * off) break;
            const Vector2d p = c.center + turned(spoke, (end == 0 ? -turn : turn) * angle);
            const Interval x = Interval::ball(p.x(), off), y = Interval::ball(p.y(), off);
            ++decisions_.by_interval;
            if ((height(third, x, y) - height(along, x, y)).upper() < 0) return true;
        }
    }
    const Vector2d& p = diagram_.vertices[ends[0]].point;
    throw UndecidedError("an edge's ends are not told apart around (" + to_text(p.x()) + ", " +
                         to_text(p.y()) + ") in the chart");
}

// Of the two arcs between the end points, is the edge the longer one? Decided by the exact order of four
// points on the circle. Pre: the chord is at most half the radius, circular forms or sides take over at both
// ends. The longer arc holds the circle's leftmost or rightmost point, or both; the shorter one neither, or
// one that is next to the end points.
bool ChartArcs::Maker::is_major_arc(EdgeId e, const Circle& c) {
    const MinimizationDiagram::Edge& edge = diagram_.edges[e];
    CircleKernel kernel;
    kernel.reset(&family_);
    const FormPair curve{kernel.add_form(edge.left), kernel.add_form(edge.right)};
    // Something takes over at an end: a third form or a side of the region. The difference decreases
    // along the edge at its start and grows at its end, which names one of the two crossings; or the other
    // way round where what takes over is lower along the edge.
    const auto end_point = [&](VertexId v, Sign orientation) {
        FormPair other;
        if (const FormId third = circular_successor(e, v); third.valid()) {
            other = {curve.f, kernel.add_form(third)};
            if (is_lower_along(e, third)) orientation = -orientation;
        } else {
            const ConvexRegion::Side& side = diagram_.region.sides[diagram_.sides(v).front()];
            other = {CircleKernel::zero_form(), kernel.add_line(side.a, side.b, side.c)};
        }
        const Vector2d& near = diagram_.vertices[v].point;
        const auto crossing = kernel.intersection(curve, other, orientation, near);
        return crossing ? *crossing : kernel.touching_point(curve, other);
    };
    const VertexId from = diagram_.dcel.origin(Dcel::half_edge(e)),
                   to = diagram_.dcel.target(Dcel::half_edge(e));
    const PointId p = end_point(from, Sign::Negative), q = end_point(to, Sign::Positive);
    const PointId left = kernel.leftmost_point(curve), right = kernel.rightmost_point(curve);
    const bool holds_left = CurveOrder(kernel, curve).strictly_between(p, q, left);
    const bool holds_right = CurveOrder(kernel, curve).strictly_between(p, q, right);
    decisions_ += kernel.decisions();
    if (holds_left == holds_right) return holds_left;
    // The end points are together on one half of the circle: does the edge hold the far extreme?
    const bool ends_left = diagram_.vertices[from].point.x() < c.center.x();
    return ends_left == holds_right;
}

}  // namespace vcell
