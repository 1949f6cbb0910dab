#include "space_spline.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "space_chart.hpp"
#include "space_equation.hpp"
#include "space_guide.hpp"
#include "space_trims.hpp"
#include "space_tube.hpp"

namespace vcell {

namespace {

using namespace space_fit;
using std::numbers::pi;

class Fitter {
public:
    Fitter(const SpaceChart& chart, const SpaceArc& arc, double tolerance, std::vector<SpaceSpan>& spans,
           FitEffort& effort)
        : chart_(chart),
          arc_(arc),
          tolerance_(tolerance),
          spans_(spans),
          effort_(effort),
          foot_(arc.start            ? chart.foot_below(arc.start->point)
                : arc.pieces.empty() ? chart.foot_below(std::get<Plane>(arc.sites[1].object).point)
                                     : chart.foot(arc.pieces.back().end)) {
        auto& equations = equations_.equations;
        equations[0] = chart.base_equation(foot_);
        for (int i = 0; i < 2; ++i) equations[i + 1] = chart.equation(arc.sites[i], foot_);
        if (arc.sites_cross) take_plane();
        if (!equations_.is_replaced() && !arc.pieces.empty() &&
            Equation::are_alike(equations_[1], equations_[2], first_point()))
            take_difference();
    }

    SpaceFitError run() {
        const double start_error = arc_.start ? sqrt2 * arc_.start->error : 0;
        const double end_error = arc_.end ? sqrt2 * arc_.end->error : 0;
        slack_ = std::max(start_error, end_error);
        // No edge is known better than its ends.
        tolerance_ = std::max(tolerance_, 4 * slack_);
        const bool on_rim = arc_.pieces.empty();
        start_ = arc_.start ? node(chart_.with_distance(arc_.start->point))
                 : on_rim   ? rim_node(0)
                            : inner_node(arc_.pieces.back());
        end_ = arc_.end ? node(chart_.with_distance(arc_.end->point)) : start_;
        last_ = Tube{0, 0, 0, start_error, 0};
        start_.is_terminal = !arc_.end || arc_.end->point == arc_.start->point;
        end_.is_terminal = true;
        if (arc_.end) final_ = Tube{0, 0, end_error, 0, 0};
        if (!arc_.start && !on_rim) last_->end = start_deviation();
        proof_.emplace(equations_, tolerance_, slack_, end_.X);
        if (on_rim) {
            fit_rim();
        } else {
            int halvings = most_halvings * static_cast<int>(arc_.pieces.size());
            fit(start_, end_, arc_.pieces, deepest, halvings);
        }
        return error_;
    }

private:
    // What a singular end needs, and what no proof in reach may cost (per piece).
    static constexpr int deepest = 40, most_halvings = 256;
    static constexpr int most_rim_halvings =
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
    // Where cylinders of one radius cross, their equations depend on each other in the points over both axes.
    // An arc lies in one of the planes between the axes, whose equation takes the place of the right one's.
    // Which plane, and on which side of it the right one is nearer, an inner point of the arc tells.
    void take_plane() {
        const auto inner = inner_point();
        if (!inner) return;
        const auto &f = std::get<Cylinder>(arc_.sites[0].object),
                   &g = std::get<Cylinder>(arc_.sites[1].object);
        const Vec3 a = f.axis.normalized(), b = g.axis.normalized(), normal = a.cross(b);
        const Vec3 center = f.point + (g.point - f.point).cross(b).dot(normal) / normal.squaredNorm() * a;
        const std::array<Vec3, 2> sums{a - b, a + b};
        const double least = std::min(sums[0].norm(), sums[1].norm());
        const std::array<Vec3, 2> normals{sums[0].normalized(), sums[1].normalized()};
        const Vec3 p = inner->head<3>() - center;
        const Vec3& n = normals[std::abs(normals[1].dot(p)) < std::abs(normals[0].dot(p))];
        const double side =
            n.dot((equations_[2].gradient(*inner) - equations_[1].gradient(*inner)).head<3>());
        auto& equations = equations_.equations;
        equations_.right = 3;
        equations[3] = equations[2];
        equations[2] = Equation::between(center, side > 0 ? n : Vec3(-n), rounding / (least * least));
    }
    // Where objects are all but alike their equations depend on each other so nearly that each alone would be
    // told from the other on the shortest of spans only.
    void take_difference() {
        auto& equations = equations_.equations;
        equations_.right = 3;
        equations[3] = equations[2];
        equations[2] = Equation::difference(equations[1], equations[3]);
    }
    Vector4d first_point() const {
        return arc_.start ? chart_.with_distance(arc_.start->point) : guide_.lifted(arc_.pieces.back().end);
    }
    // Of those that the pieces tell the one farthest from the ends.
    std::optional<Vector4d> inner_point() const {
        if (!arc_.start || !arc_.end) return std::nullopt;
        const Vector4d from = chart_.with_distance(arc_.start->point),
                       to = chart_.with_distance(arc_.end->point);
        std::optional<Vector4d> best;
        double farthest = 0;
        const auto offer = [&](const Vector4d& X) {
            const double distance = std::min((X - from).norm(), (X - to).norm());
            if (distance > farthest) best = X;
            farthest = std::max(farthest, distance);
        };
        for (const Piece& piece : arc_.pieces.first(arc_.pieces.size() - 1)) offer(guide_.lifted(piece.end));
        if (arc_.pieces.size() == 1) {
            const Piece& piece = arc_.pieces.front();
            if (const auto q = guide_.meet(
                    0.5 * (guide_.chart_point(from, piece) + guide_.chart_point(to, piece)), piece))
                offer(guide_.lifted(*q));
        }
        return best;
    }

    Node node(const Vector4d& X) const {
        const Frame f = equations_.frame(X);
        Vector4d bend = Vector4d::Zero();
        for (int i = 0; i < 3; ++i) bend[i] = -equations_[i].second(X, f.T);
        return {X, f.T, f.matrix().inverse() * bend};
    }

    // Newton's method across the curve (or for its point where `seam` vanishes), to the level of rounding.
    std::optional<Node> find(Vector4d X, const Linear* seam = nullptr) const {
        constexpr int enough = 12;
        for (int i = 0; i < enough; ++i) {
            Vector4d G = Vector4d::Zero();
            double size = 0;
            for (int k = 0; k < 3; ++k) {
                G[k] = equations_[k](X);
                size = std::max(size, equations_[k].size(X));
            }
            Matrix4d M = equations_.frame(X).matrix();
            if (seam) {
                M.row(3) = seam->head<4>().normalized();
                G[3] = at(*seam, X) / seam->head<4>().norm();
            }
            const Matrix4d inverse = M.inverse();
            const Vector4d step = inverse * G;
            X -= step;
            if (step.norm() <= 16 * u * size * (1 + inverse.leftCols<3>().norm())) return node(X);
        }
        return std::nullopt;
    }

    Node inner_node(const Piece& piece) const {
        const Vector4d X = guide_.lifted(piece.end);
        const auto found = find(X);
        Node result = found ? *found : node(X);
        result.ends_piece = true;
        return result;
    }

    // Around a cylinder: with growing angle on the lower end, the region lying on the left.
    Node rim_node(double angle) const {
        const double y = std::get<Plane>(arc_.sites[1].object).point.y();
        return node(guide_.over(Vec3(0, y, 0), Vec3(std::sin(angle), 0, std::cos(angle))));
    }
    void fit_rim() {
        constexpr double widest = pi / 3;
        const double sign = std::get<Plane>(arc_.sites[1].object).normal.y() < 0 ? 1 : -1;
        const auto angle = [](const SpaceEnd& e) { return std::atan2(e.point.x(), e.point.z()); };
        const double first = arc_.start ? angle(*arc_.start) : 0;
        double turn = arc_.turn > 0 ? arc_.turn : 2 * pi;
        if (!(arc_.turn > 0) && arc_.end && arc_.end->point != arc_.start->point) {
            turn = std::fmod(sign * (angle(*arc_.end) - first), 2 * pi);
            if (turn < 0) turn += 2 * pi;
        }
        const int n = std::max(1, static_cast<int>(std::ceil(turn / widest)));
        Node from = start_;
        for (int i = 1; i <= n; ++i) {
            int halvings = most_rim_halvings;
            const Node to = i == n ? end_ : rim_node(first + sign * turn * i / n);
            fit(from, to, {}, deepest, halvings);
            from = to;
        }
    }

    // How far the first node of a closed edge may be from a point of the edge.
    double start_deviation() const {
        const Piece& piece = arc_.pieces.back();
        const double e = piece.error;
        const auto box =
            guide_.enclosure({piece.end.x() - e, piece.end.x() + e, piece.end.y() - e, piece.end.y() + e});
        const Vector4d& X = start_.X;
        return (X - box[0]).cwiseAbs().cwiseMax((X - box[1]).cwiseAbs()).norm();
    }

    // Along these pieces, or the rim. A span that is not good enough is divided; several pieces of which
    // nothing is proved yet where one of them ends.
    // `before`: the trims' error of the span that this one is a part of.
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
        const bool is_chord = is_short && divides && (is_all || is_blurred(from, length));
        if (spline.is_near() && !spline.trims.seam && divides && !is_chord) {
            const std::vector<Node> inner = divide(from, to, spline);
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
            const auto middle = half_way(from, to, piece, spline);
            if (middle && !(is_short && is_blurred(*middle, length))) {
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

    // Does rounding blur the arc so much that no span of this length, or a shorter one, can be proved?
    bool is_blurred(const Node& n, double length) const {
        const Solver solver(equations_.frame(n.X).matrix(), {});
        std::array<double, 4> e{};
        for (int i = 0; i < 3; ++i) e[i] = rounding * equations_[i].size(n.X);
        return !(solver.is_regular() && 64 * solver.distance(e) <= length);
    }
    bool is_lost() const {
        return std::isinf(error_.curve) || std::isinf(error_.trims) || effort_.spans == 0;
    }

    // Points of the arc between parts that will do, as errors fall with the sixth power of the length.
    std::vector<Node> divide(const Node& from, const Node& to, const Fit& spline) const {
        constexpr double most_parts = 4, reserve = 1.5;
        const int parts = static_cast<int>(std::clamp(
            std::ceil(std::pow(reserve * spline.expected / tolerance_, 1.0 / 6)), 2.0, most_parts));
        std::vector<Node> inner;
        const Node* last = &from;
        for (int k = 1; k < parts; ++k) {
            const auto found = find(point(spline.points, static_cast<double>(k) / parts));
            if (!found || !is_between(*last, *found, to)) return {};
            inner.push_back(*found);
            last = &inner.back();
        }
        return inner;
    }

    // How many of the pieces end before a point as seen along the chord, all but the last one at most.
    std::size_t ends_before(const Vector4d& X, const Vector4d& chord, std::span<const Piece> pieces) const {
        const auto is_before = [&](const Piece& p) { return chord.dot(guide_.lifted(p.end) - X) < 0; };
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
        if (!fit.tube.is_proved() && !error_.unproved) error_.unproved = point(fit.points, 0.5).head<3>();
        if (fit.tube.error() > std::max(error_.curve, error_.trims))
            error_.worst = point(fit.points, 0.5).head<3>();
        error_.curve = std::max(error_.curve, fit.tube.curve);
        error_.trims = std::max(error_.trims, fit.tube.trims);
        if (fit.is_chord)
            last_.reset();
        else
            last_ = fit.tube;
        spans_.push_back({fit.points, fit.trims.part});
    }

    std::optional<Node> half_way(const Node& from, const Node& to, const Piece* piece,
                                 const Fit& spline) const {
        if (spline.trims.seam)
            if (const auto crossing = sign_change(spline.points, *spline.trims.seam, tolerance_))
                if (const auto found = find(*crossing, &*spline.trims.seam);
                    found && is_between(from, *found, to))
                    return found;
        if (spline.trims.seam)
            if (const auto found = find(middle(spline.points)); found && is_between(from, *found, to))
                return found;
        if (!piece) {
            Vec3 w = from.X.head<3>() / from.X[3] + to.X.head<3>() / to.X[3];
            w.y() = 0;
            return node(guide_.over(Vec3(0, from.X.y(), 0), w.normalized()));
        }
        const auto on_line = guide_.meet(
            0.5 * (guide_.chart_point(from.X, *piece) + guide_.chart_point(to.X, *piece)), *piece);
        return find(on_line ? guide_.lifted(*on_line) : Vector4d(0.5 * (from.X + to.X)));
    }

    // Of spans whose chord goes with the arc.
    static bool is_between(const Node& from, const Node& n, const Node& to) {
        const Vec3 chord = (to.X - from.X).head<3>();
        const double along = chord.dot((n.X - from.X).head<3>());
        return along > 0 && along < chord.squaredNorm();
    }

    // Value, first and second derivative in the span's parameter.
    using Jet = Eigen::Matrix<double, 4, 3>;

    // The quintic with the given ends.
    static Eigen::Matrix<double, 4, 6> quintic(const Jet& a, const Jet& b) {
        Eigen::Matrix<double, 4, 6> p;
        p << a.col(0), a.col(0) + a.col(1) / 5, a.col(0) + 2 * a.col(1) / 5 + a.col(2) / 20,
            b.col(0) - 2 * b.col(1) / 5 + b.col(2) / 20, b.col(0) - b.col(1) / 5, b.col(0);
        return p;
    }
    static Vector4d middle(const Points& p) { return point(p, 0.5); }

    // At constant speed: with X' = length T and X'' = length^2 K at both ends, K the curvature vector, a
    // quintic has
    //     X'(1/2) = 15/8 (X1 - X0) - 7/16 (X0' + X1') + 1/32 (X1'' - X0''),
    // and the speed there is to be `length`, too: that determines it to the order of the quintic's own error.
    static double length_between(const Node& from, const Node& to) {
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

    // Takes a span from Hermite's data at the ends to the arc at the inner nodes, by a step of Newton's
    // method each, or two where residuals are not small. Not if they are larger than `most`.
    bool interpolate(Points& points, double most, double small) const {
        constexpr int most_steps = 2;
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
        std::array<Jet, 2> ends;
        ends[0] << from.X, length * from.T, square(length) * from.second;
        ends[1] << to.X, length * to.T, square(length) * to.second;
        fit.points.topRows<4>() = quintic(ends[0], ends[1]);
        constexpr double near = 4096, small = 32, least_share = 0.7;
        if (!interpolate(fit.points, near * most, small * most)) return fit;
        const SpanPolynomials span(fit.points, foot_);
        Residuals residuals = proof_->curve_residuals(span);
        const double largest = std::ranges::max(residuals.curve);
        constexpr double usual_share = 6;  // of errors, of trims mostly, but for q
        fit.expected = usual_share * largest;
        if (!(least_share * largest <= most)) return fit;
        fit.trims = place_trims(arc_, tolerance_, fit.points);
        if (fit.trims.seam) return fit;
        TubeProof::add_trims(fit.points, fit.trims.patches, span, residuals);
        fit.tube = proof_->certify(fit.points, fit.trims.patches, residuals, most,
                                   {from.is_terminal, to.is_terminal}, deepest_proof);
        if (fit.tube.is_proved())
            fit.expected = fit.error() * (1 - fit.tube.q);  // parts have a smaller q
        else if (fit.tube.curve == infinity)
            fit.expected = infinity;
        return fit;
    }

    Fit chord(const Node& from, const Node& to, const Piece* piece) const {
        Fit fit;
        fit.is_chord = true;
        auto box = piece ? guide_.enclosure(piece->box) : guide_.rim_enclosure(from, to, slack_);
        // Elsewhere the diagram is not needed, and not relied on.
        const double length = (to.X - from.X).norm();
        const bool is_all = from.X == start_.X && to.X == end_.X;
        if (!piece) {
            // Whole edges only: parts may end where the edge does, as far as is known.
            if (!is_all) return fit;
        } else if (is_all || is_blurred(from, length) || is_blurred(to, length)) {
            const auto tight = guide_.enclosure(guide_.box_between(from, to, *piece, slack_, effort_.cells));
            // As in step 4, nothing but the last span reaches the edge's end.
            const bool holds_end =
                (end_.X - tight[0]).minCoeff() >= -slack_ && (tight[1] - end_.X).minCoeff() >= -slack_;
            if (!holds_end || from.is_terminal || to.is_terminal) box = tight;
        }
        const Vector4d low = box[0].cwiseMin(from.X).cwiseMin(to.X),
                       high = box[1].cwiseMax(from.X).cwiseMax(to.X);
        std::array<Jet, 2> ends;
        ends[0] << from.X, to.X - from.X, Vector4d::Zero();
        ends[1] << to.X, to.X - from.X, Vector4d::Zero();
        fit.points.topRows<4>() = quintic(ends[0], ends[1]);
        fit.trims = place_trims(arc_, tolerance_, fit.points);
        fit.tube = Tube{(high - low).norm(), 0, 0, 0, 0, 0};
        const SpanPolynomials span(fit.points, foot_);
        Residuals residuals = proof_->curve_residuals(span);
        TubeProof::add_trims(fit.points, fit.trims.patches, span, residuals);
        // The trims of a very short chord err by more than its own room: by what rounding makes it, times the
        // condition.
        constexpr double wider = 16;
        for (Neighbourhood D(fit.points, slack_, tolerance_);; D.widen(wider)) {
            fit.tube.trims = proof_->trims_error(fit.points, fit.trims.patches, D, residuals, fit.tube);
            if (std::isfinite(fit.tube.trims) || !(wider * D.room <= tolerance_)) return fit;
        }
    }

    const SpaceChart& chart_;
    const SpaceArc& arc_;
    double tolerance_;
    std::vector<SpaceSpan>& spans_;
    FitEffort& effort_;
    Vec3 foot_;  // near the curve
    ArcEquations equations_;
    ArcGuide guide_{chart_, arc_, equations_};
    std::optional<TubeProof> proof_;  // once tolerance, slack and end are known
    Node start_, end_;                // of the edge
    std::size_t first_span_ = spans_.size();
    double slack_ = 0;                   // of the vertices
    std::optional<Tube> last_;           // the span before, the start at first; none: vouched for by a piece
    std::optional<Tube> first_, final_;  // the first span; the end
    SpaceFitError error_;
};

}  // namespace

// Within a ball of twice the bound the solution is unique by step 2, and the point is one.
std::optional<SpaceEnd> settle_point(const RadialBaseProblem& problem, const std::array<SpaceSite, 3>& sites,
                                     const SpaceEnd& near) {
    const SpaceChart chart(problem);
    const Vec3 foot = chart.foot_below(near.point);
    const std::array equations{chart.base_equation(foot), chart.equation(sites[0], foot),
                               chart.equation(sites[1], foot), chart.equation(sites[2], foot)};
    const Vector4d center = chart.with_distance(near.point);
    const double radius = 2 * sqrt2 * near.error;
    Matrix4d M;
    std::array<double, 4> variations, e;
    for (int i = 0; i < 4; ++i) {
        M.row(i) = equations[i].gradient(center);
        variations[i] = equations[i].variation(center, radius);
    }
    const Solver solver(M, variations);
    if (!solver.is_regular()) return std::nullopt;
    Vector4d X = center;
    constexpr int steps = 3;  // of q each
    for (int k = 0; k < steps; ++k) {
        Vector4d G;
        for (int i = 0; i < 4; ++i) G[i] = equations[i](X);
        X -= solver.inverse * G;
    }
    for (int i = 0; i < 4; ++i) e[i] = equations[i].residual(X);
    const double error = solver.distance(e);
    if (!(error < near.error && (X - center).norm() + error <= radius)) return std::nullopt;
    return SpaceEnd{X.head<3>(), error};
}

SpaceFitError fit_space_spline(const RadialBaseProblem& problem, const SpaceArc& arc, double tolerance,
                               std::vector<SpaceSpan>& spans, FitEffort& effort) {
    const SpaceChart chart(problem);
    return Fitter(chart, arc, tolerance, spans, effort).run();
}

SpaceFitError fit_spline_over_plane(const SpaceArc& arc, double tolerance, std::vector<SpaceSpan>& spans,
                                    FitEffort& effort) {
    return Fitter(SpaceChart(), arc, tolerance, spans, effort).run();
}

}  // namespace vcell
