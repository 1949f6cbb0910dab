/// The fit of trisectors that are no conics: quintic spans with a certified distance from the true arc.
///
/// The unknowns are X = (p, t): a point and its distance t from the base's centre or axis, or from a base
/// plane. An arc lies where three equations G(X) = 0 hold, that of the base and those of its two sites (R0 =
/// 0 for a base plane):
///
///     sphere (c, rho), cylinder       G = |p - c| (distance from the axis) - (t + delta),   delta = rho - R0
///     base sphere, cylinder           the same with delta = 0, about its centre (its axis)
///     base plane                      G = its distance - t
///     sphere over a base plane        its paraboloid, which is quadratic in (x, y) and linear in t
///     plane                           G = its distance + R0 - t
///     wall                            G = the distance to a side of the box, to an end of the stretch, over
///     a
///                                     base plane to the bisector of any plane
///
/// The gradients are (g, -1), g the unit vector from the foot point, and (g, 0) for walls. Seen along the arc
/// the left site is nearest on the left, so the arc runs along (g_left - g) x (g_right - g), g = grad of the
/// base's distance (walls: g_wall instead of the difference).
///
/// Where cylinders of one radius have crossing axes, left and right depend on each other over the crossing,
/// and the trisector has a node. Each of its curves lies in a plane between the axes; the plane's equation
/// may then stand for that of the right site, except for the trim. Where the sites are two balls or two tubes
/// that are all but alike, the difference of their equations does: its gradient, which tells where the arc
/// is, is as small as the objects are apart, and changes by as little. Where a site is all but the base, the
/// difference of these two stands for that of the site, for the trim as well.
///
/// Both ends of a span lie on the arc. First and second derivative at both ends, by the length of the curve
/// (p, t), follow from the equations and make a quintic that errs by the sixth power of the span. Steps of
/// Newton's method take it to the arc at four places in between, chosen so that the quintic through all six
/// errs by a small part of that (quintic_nodes.hpp). What follows the curve in the same parameter, an edge's
/// trims, has its values at the same six places. A span that is not good enough is divided at points of the
/// arc, found by Newton's method, into as many parts as the sixth power asks for.
///
/// *The certificate.* Let P(s) = (p, t)(s) be the fitted span.
///
/// 1. Residuals. d^2 - (t + delta)^2 along the span is a polynomial of degree 10 (planes and walls: G, of
///    degree 5) that all but vanishes at those six places: that bounds it closely. Divided by d + t + delta
///    it bounds |G(P(s))| <= e.
/// 2. Place. Take four equations F(X) = 0, a convex D around the span (what is within some room of the hull
///    of its control points), M the Jacobian in its middle. Within r of a point at distance d from a centre
///    or axis the unit vector from there turns by asin(r / d) at most; that bounds the rows of F' - M, and so
///    the solver's q in D (core/solver/newton/root_distance.hpp). Let q < 1. Then F is one-to-one in D; and a
///    solution lies within x of P, which it tells, if D contains the ball of this radius.
/// 3. The curve. F = (G, N . (X - P(s))) with N the unit null vector of the gradients in the middle. So in D
///    the curve G = 0 is a graph over N, and meets the slice across N through each P(s) within x. Since
///    N . P(s) increases, these points make up the curve's arc between the slices of P(0) and P(1), in the
///    arc's direction.
/// 4. Which arc. Let A be a point of the curve within a of P(0), and c_i bound the curvature of G_i, 1 / d in
///    D. On the way from P(0) to A |G_i| <= |G_i(P(0))| + c_i a^2 / 8; so the slices in between meet the
///    curve, too, as near as step 2 says. If that is in D, A lies on the graph of step 3. So consecutive
///    spans follow one arc, which starts at the given start and in its direction; and it reaches the given
///    end with the last span only: no other span's D holds the end between its slices. So it is the arc.
///    Of the guide only guesses are taken, and for closed arcs that one point is near the arc.
/// 5. Trims: envelope/lift/space_trims.hpp.
///
/// A span too long for one D, or for a small q, is halved for the proof. Where an arc ends in a point with
/// dependent gradients (objects that touch, nodes) or passes one closely (axes that cross but for rounding)
/// spans of the tolerance's length cannot be proved so: they are chords, as good as the guide encloses that
/// part of the arc. All of it in double: residuals and gradients carry bounds of their rounding.
///
/// Whose arc it is tells the fit by a *guide*: the pieces of the minimization diagram
/// (envelope/lift/space_guide.hpp).
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "fit_error.hpp"
#include "tube_proof.hpp"

namespace vcell::space_fit {

// Opposite corners of a box of points (p, t).
using SpaceBox = std::array<Vector4d, 2>;

// Where an arc starts or ends; where a closed one is cut, the error bounds the distance from a point of it.
struct ArcEnd {
    Node node;
    double error;  // bounds the distance of (p, t) from the true one
};

// The ends of a span that no tube proves, and what tells how closely it may be enclosed.
struct Chord {
    const Node &from, &to;
    bool is_all;          // the arc is not divided
    const Vector4d& end;  // of the arc
    double slack;         // of its ends
};

// Of spans whose chord goes with the arc.
inline bool is_between(const Node& from, const Node& n, const Node& to) {
    const Vec3 chord = (to.X - from.X).head<3>();
    const double along = chord.dot((n.X - from.X).head<3>());
    return along > 0 && along < chord.squaredNorm();
}

// Value, first and second derivative in a span's parameter.
using SpanJet = Eigen::Matrix<double, 4, 3>;

// Makes the span's curve the quintic with the given ends.
inline void set_quintic(Points& points, const SpanJet& a, const SpanJet& b) {
    auto p = points.topRows<4>();
    p << a.col(0), a.col(0) + a.col(1) / 5, a.col(0) + 2 * a.col(1) / 5 + a.col(2) / 20,
        b.col(0) - 2 * b.col(1) / 5 + b.col(2) / 20, b.col(0) - b.col(1) / 5, b.col(0);
}

inline Vec3 middle(const Points& points) { return point(points, 0.5).head<3>(); }

// At constant speed: with X' = length T and X'' = length^2 K at both ends, K the curvature vector, a
// quintic has
//     X'(1/2) = 15/8 (X1 - X0) - 7/16 (X0' + X1') + 1/32 (X1'' - X0''),
// and the speed there is to be `length`, too: that determines it to the order of the quintic's own error.
inline double length_between(const Node& from, const Node& to) {
    const Vector4d chord = to.X - from.X, T = from.T + to.T, K = to.second - from.second;
    double length = chord.norm();
    constexpr int steps = 3;  // of Newton's method
    for (int i = 0; i < steps; ++i) {
        const Vector4d velocity = 1.875 * chord - 0.4375 * length * T + square(length) / 32 * K;
        const double speed = velocity.norm();
        const double slope = velocity.dot(length / 16 * K - 0.4375 * T) / speed - 1;
        length -= (speed - length) / slope;
    }
    return length;
}

// The node where a piece ends, from about there.
inline Node piece_end(const ArcEquations& equations, const Vector4d& X) {
    const auto found = equations.find(X);
    Node result = found ? *found : equations.node(X);
    result.ends_piece = true;
    return result;
}

// Fits an arc. What `Guide` knows of it:
//
//     Piece                            a part of the arc
//     Span, span(points, trims)        what is kept of a span
//     Vector4d end_of(piece)           about the arc's point where the piece ends
//     bool holds(piece, X, slack)      may this point of the two sites' bisector be the piece's, to the
//     slack? Trims, place_trims(points, tolerance)
//                                      puts what follows the curve below it; crosses_seam(): the span must be
//                                      divided first
//     prove_trims(proof, points, trims, polynomials, residuals)
//                                      the TrimsError of TubeProof::certify()
//     optional<Node> half_way(from, to, piece, points, trims, tolerance)
//                                      a point of the arc between two nodes on a piece (null: where the arc
//                                      has none), or where the span crosses a seam
//     optional<SpaceBox> enclosure(chord, piece, effort)
//                                      holds the arc between a chord's ends
template <class Guide>
class SplineFit {
    using Piece = typename Guide::Piece;
    using Span = typename Guide::Span;
    using Trims = typename Guide::Trims;

public:
    // foot: near the curve. end: none where the arc is closed. Appends to `spans`.
    SplineFit(const Guide& guide, const ArcEquations& equations, const Vec3& foot, double tolerance,
              const ArcEnd& start, const std::optional<ArcEnd>& end, std::vector<Span>& spans,
              FitEffort& effort)
        : guide_(guide),
          equations_(equations),
          foot_(foot),
          slack_(end ? std::max(start.error, end->error) : 0),
          // No arc is known better than its ends.
          tolerance_(std::max(tolerance, 4 * slack_)),
          start_(start.node),
          end_(end ? end->node : start.node),
          proof_(equations, tolerance_, slack_, end_.X),
          spans_(spans),
          effort_(effort),
          last_(Tube{0, 0, 0, start.error, 0}) {
        start_.is_terminal = !end || end_.X == start_.X;
        end_.is_terminal = true;
        if (end) final_ = Tube{0, 0, end->error, 0, 0};
    }

    // Follows all of the pieces.
    void fit_all(std::span<const Piece> pieces) {
        int halvings = most_halvings * static_cast<int>(pieces.size());
        fit(start_, end_, pieces, deepest, halvings);
    }
    // Fits an arc without pieces by way of some of its points.
    void fit_by_way_of(const std::vector<Node>& inner) {
        for (std::size_t i = 0; i <= inner.size(); ++i) {
            int halvings = most_halvings_without_pieces;
            fit(i == 0 ? start_ : inner[i - 1], i == inner.size() ? end_ : inner[i], {}, deepest, halvings);
        }
    }
    const SpaceFitError& error() const { return error_; }

private:
    // What a singular end needs, and what no proof in reach may cost (per piece).
    static constexpr int deepest = 40, most_halvings = 256;
    static constexpr int most_halvings_without_pieces =
        4096;                                // no pieces get shorter where both sites are nearly as one
    static constexpr int deepest_proof = 4;  // halvings of a span for its certificate

    struct Fit {
        Points points = Points::Zero();
        Tube tube = Tube::failed();
        bool is_chord = false;
        Trims trims;
        double expected = infinity;  // error, but for q; finite if this is near the arc

        double error() const { return tube.error(); }
        bool is_near() const { return expected < infinity; }
    };

    // Along these pieces, if there are any. A span that is not good enough is divided; several pieces of
    // which nothing is proved yet where one of them ends. `before`: the trims' error of the span that this
    // one is a part of.
    void fit(const Node& from, const Node& to, std::span<const Piece> pieces, int deeper, int& halvings,
             double before = infinity) {
        if (effort_.spans > 0) --effort_.spans;
        const Fit spline = smooth(from, to, tolerance_);
        // What division does not make smaller is rounding, of the scene, too.
        constexpr double no_less = 0.8, most_blurred = 16;
        const double error = spline.tube.trims;
        const bool is_floor =
            before < infinity && error > no_less * before && error <= most_blurred * tolerance_;
        if (accept(spline, to, is_floor)) return;
        const double length = (to.X - from.X).norm();
        const bool is_short = length <= tolerance_, divides = deeper > 0 && halvings > 0 && !is_lost();
        // Parts of what rounding blurs are no better than it, and their ends cannot be told from the edge's.
        const bool is_all = from.X == start_.X && to.X == end_.X;
        const bool is_chord = is_short && divides && (is_all || is_blurred(equations_, from.X, length));
        if (spline.is_near() && !spline.trims.crosses_seam() && divides && !is_chord) {
            const std::vector<Node> inner = divide(from, to, spline, pieces);
            for (std::size_t i = 0; i < inner.size(); ++i) {
                const Node &start = i == 0 ? from : inner[i - 1], &end = inner[i];
                const std::size_t first = ends_before(end.X, to.X - from.X, pieces);
                --halvings;
                fit(start, end, pieces.first(std::min(first + 1, pieces.size())), deeper - 1, halvings,
                    error);
                pieces = pieces.subspan(first);
            }
            if (!inner.empty()) return fit(inner.back(), to, pieces, deeper - 1, halvings, error);
        }
        if (pieces.size() > 1) {
            const std::size_t half = pieces.size() / 2;
            const Node end = inner_node(pieces[half - 1]);
            fit(from, end, pieces.first(half), deeper, halvings);
            fit(end, to, pieces.subspan(half), deeper, halvings);
            return;
        }
        const Piece* piece = pieces.empty() ? nullptr : &pieces.front();
        // Both ends are in the enclosure that vouches for a chord.
        if (is_short && accept(chord(from, to, piece), to)) return;
        if (divides) {
            const auto middle = guide_.half_way(from, to, piece, spline.points, spline.trims, tolerance_);
            const bool is_on_piece = middle && (!piece || guide_.holds(*piece, middle->X, tolerance_));
            if (is_on_piece && !(is_short && is_blurred(equations_, middle->X, length))) {
                --halvings;
                fit(from, *middle, pieces, deeper - 1, halvings, error);
                fit(*middle, to, pieces, deeper - 1, halvings, error);
                return;
            }
        }
        const Fit best = smooth(from, to, infinity), straight = chord(from, to, piece);
        const bool is_straight = (piece || straight.tube.is_proved()) && !(best.error() < straight.error());
        append(is_straight ? straight : best);
    }

    bool is_lost() const {
        return std::isinf(error_.curve) || std::isinf(error_.trims) || effort_.spans == 0;
    }

    // Points of the arc between parts that will do, as errors fall with the sixth power of the length. Next
    // to a hairpin Newton's method may find its other strand, which the pieces do not hold, or which runs
    // back.
    std::vector<Node> divide(const Node& from, const Node& to, const Fit& spline,
                             std::span<const Piece> pieces) const {
        constexpr double most_parts = 4, reserve = 1.5;
        const int parts = static_cast<int>(std::clamp(
            std::ceil(std::pow(reserve * spline.expected / tolerance_, 1.0 / 6)), 2.0, most_parts));
        std::vector<Node> inner;
        const Node* last = &from;
        for (int k = 1; k < parts; ++k) {
            const auto found = equations_.find(point(spline.points, static_cast<double>(k) / parts));
            if (!found || !is_between(*last, *found, to) || !may_hold(pieces, *found) ||
                !((to.X - from.X).dot(found->T) > 0))
                return {};
            inner.push_back(*found);
            last = &inner.back();
        }
        return inner;
    }

    bool may_hold(std::span<const Piece> pieces, const Node& n) const {
        return pieces.empty() ||
               std::ranges::any_of(pieces, [&](const Piece& p) { return guide_.holds(p, n.X, tolerance_); });
    }

    // How many of the pieces end before a point as seen along the chord, all but the last one at most.
    std::size_t ends_before(const Vector4d& X, const Vector4d& chord, std::span<const Piece> pieces) const {
        const auto is_before = [&](const Piece& p) { return chord.dot(guide_.end_of(p) - X) < 0; };
        std::size_t n = 0;
        while (n + 1 < pieces.size() && is_before(pieces[n])) ++n;
        return n;
    }

    bool accept(const Fit& fit, const Node& to, bool is_floor = false) {
        if (!fit.tube.is_within(tolerance_) && !(is_floor && fit.tube.curve <= tolerance_)) return false;
        if (!fit.is_chord) {
            if (last_ && !joins(*last_, fit.tube)) return false;
            const bool is_end = to.X == end_.X && to.is_terminal;
            if (!is_end && !fit.tube.is_joint()) return false;
            if (is_end) {
                const std::optional<Tube>& next = final_ ? final_ : first_;
                if (next && !joins(fit.tube, *next)) return false;
            }
            if (spans_.size() == first_span_) first_ = fit.tube;
        }
        append(fit);
        return true;
    }
    void append(const Fit& fit) {
        if (!fit.tube.is_proved() && !error_.unproved) error_.unproved = middle(fit.points);
        if (fit.tube.error() > std::max(error_.curve, error_.trims)) error_.worst = middle(fit.points);
        error_.curve = std::max(error_.curve, fit.tube.curve);
        error_.trims = std::max(error_.trims, fit.tube.trims);
        if (fit.is_chord)
            last_.reset();
        else
            last_ = fit.tube;
        spans_.push_back(guide_.span(fit.points, fit.trims));
    }

    // Takes a span from Hermite's data at the ends to the arc at the inner nodes, by a step of Newton's
    // method each, or two where residuals are not small. Not if they are larger than `most`. How far along a
    // needle a point is its patch tells by how wide the needle is there: that wants them all.
    bool interpolate(Points& points, double most, double small) const {
        const int most_steps = equations_.has_needle ? 4 : 2;
        if (equations_.has_needle) small = 0;
        const QuinticNodes& nodes = QuinticNodes::get();
        Eigen::Matrix<double, 4, 6> at_nodes = points.topRows<4>() * nodes.values;
        double largest = infinity;
        for (int step = 0; step < most_steps && largest > small; ++step) {
            std::array<Vector4d, 6> G;
            largest = 0;
            for (int k = 1; k < 5; ++k) {
                G[k] = Vector4d::Zero();
                for (int i = 0; i < 3; ++i) G[k][i] = equations_[i](at_nodes.col(k));
                largest = std::max(largest, G[k].cwiseAbs().maxCoeff());
            }
            if (!(largest <= most)) return false;
            for (int k = 1; k < 5; ++k)
                at_nodes.col(k) -= equations_.frame(at_nodes.col(k)).matrix().inverse() * G[k];
        }
        points.block<4, 4>(0, 1) = at_nodes * nodes.coefficients.middleCols<4>(1);
        return true;
    }

    // Certified if it may err by no more than `most`: in the certificate each |B_i| is 1 / sqrt(2) at least.
    // Others that come near the arc tell where to divide it, and by their residuals into how many parts.
    Fit smooth(const Node& from, const Node& to, double most) const {
        constexpr double flattest = 0.45;
        Fit fit;
        const Vec3 chord = to.X.head<3>() - from.X.head<3>();
        for (const Node& n : {from, to})
            if (!(chord.dot(n.T.head<3>()) > flattest * chord.norm() * n.T.head<3>().norm())) return fit;
        const double length = length_between(from, to);
        if (!(length > 0)) return fit;
        std::array<SpanJet, 2> ends;
        ends[0] << from.X, length * from.T, square(length) * from.second;
        ends[1] << to.X, length * to.T, square(length) * to.second;
        set_quintic(fit.points, ends[0], ends[1]);
        constexpr double near = 4096, small = 32, least_share = 0.7;
        if (!interpolate(fit.points, near * most, small * most)) return fit;
        const SpanPolynomials span(fit.points, foot_);
        const Residuals residuals = proof_.residuals(span);
        const double largest = std::ranges::max(residuals.curve);
        constexpr double usual_share = 6;  // of errors, of trims mostly, but for q
        fit.expected = usual_share * largest;
        if (!(least_share * largest <= most)) return fit;
        fit.trims = guide_.place_trims(fit.points, tolerance_);
        if (fit.trims.crosses_seam()) return fit;
        const auto trims_error = guide_.prove_trims(proof_, fit.points, fit.trims, span, residuals);
        fit.tube = proof_.certify(fit.points, residuals, most, {from.is_terminal, to.is_terminal},
                                  deepest_proof, trims_error);
        if (fit.tube.is_proved())
            fit.expected = fit.error() * (1 - fit.tube.q);  // parts have a smaller q
        else if (fit.tube.curve == infinity)
            fit.expected = infinity;
        return fit;
    }

    Fit chord(const Node& from, const Node& to, const Piece* piece) const {
        Fit fit;
        fit.is_chord = true;
        const bool is_all = from.X == start_.X && to.X == end_.X;
        std::array<SpanJet, 2> ends;
        ends[0] << from.X, to.X - from.X, Vector4d::Zero();
        ends[1] << to.X, to.X - from.X, Vector4d::Zero();
        set_quintic(fit.points, ends[0], ends[1]);
        const auto box = guide_.enclosure(Chord{from, to, is_all, end_.X, slack_}, piece, effort_);
        if (!box) return fit;
        const Vector4d low = (*box)[0].cwiseMin(from.X).cwiseMin(to.X),
                       high = (*box)[1].cwiseMax(from.X).cwiseMax(to.X);
        fit.trims = guide_.place_trims(fit.points, tolerance_);
        fit.tube = Tube{(high - low).norm(), 0, 0, 0, 0, 0};
        const SpanPolynomials span(fit.points, foot_);
        const Residuals residuals = proof_.residuals(span);
        const auto trims_error = guide_.prove_trims(proof_, fit.points, fit.trims, span, residuals);
        // The trims of a very short chord err by more than its own room: by what rounding makes it, times the
        // condition.
        constexpr double wider = 16;
        for (Neighbourhood D(fit.points, slack_, tolerance_);; D.set_room(wider * D.room)) {
            fit.tube.trims = trims_error(fit.points, proof_.local(fit.points, D), fit.tube);
            // The room and the tolerance are infinite where an end is not known at all: wider ones would go
            // on.
            if (std::isfinite(fit.tube.trims) || !(wider * D.room <= tolerance_) || std::isinf(D.room))
                return fit;
        }
    }

    Node inner_node(const Piece& piece) const { return piece_end(equations_, guide_.end_of(piece)); }

    const Guide& guide_;
    const ArcEquations& equations_;
    Vec3 foot_;
    double slack_;  // of the ends
    double tolerance_;
    Node start_, end_;
    TubeProof proof_;
    std::vector<Span>& spans_;
    FitEffort& effort_;
    std::size_t first_span_ = spans_.size();
    std::optional<Tube> last_;           // the span before, the start at first; none: vouched for by a piece
    std::optional<Tube> first_, final_;  // the first span; the end
    SpaceFitError error_;
};

}  // namespace vcell::space_fit
