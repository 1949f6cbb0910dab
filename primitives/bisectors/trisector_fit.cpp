#include "trisector_fit.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "../fit/spline_fit.hpp"

namespace vcell {

namespace {

using namespace space_fit;

constexpr int unknowns = 4;  // x, y, z, r
using Component = CurveComponent<unknowns>;
using CurveTube = vcell::Tube<unknowns>;  // of the solver; one of the fit is about a span
using Place = IntervalBox<unknowns>;

// The three objects where they are: the equations of the fit with them, and (p, t) instead of (p, r).
class Sites {
public:
    Sites(const std::array<const Object*, 3>& objects, const std::array<int, 3>& sides)
        : objects_(objects), sides_(sides) {
        if (const auto* s = std::get_if<Sphere>(objects[0])) radius_ = s->radius;
        if (const auto* c = std::get_if<Cylinder>(objects[0])) radius_ = c->radius;
    }

    // r is t - R0; of a base that lies around the others or that they see from within, R0 - t.
    double t(double r) const { return radius_ + sides_[0] * r; }
    double r(double t) const { return sides_[0] * (t - radius_); }
    // That of dr / dt.
    int sense() const { return sides_[0]; }

    Vector4d middle(const Place& place) const {
        return {place[0].mid(), place[1].mid(), place[2].mid(), t(place[3].mid())};
    }
    SpaceBox enclosure(const Place& place) const {
        const Interval t = Interval(radius_) + Interval(sides_[0]) * place[3];
        return {Vector4d(place[0].lower(), place[1].lower(), place[2].lower(), t.lower()),
                Vector4d(place[0].upper(), place[1].upper(), place[2].upper(), t.upper())};
    }

    Vec3 foot_below(const Vec3& p) const {
        if (const auto* s = std::get_if<Sphere>(objects_[0])) return s->center;
        if (const auto* c = std::get_if<Cylinder>(objects_[0])) {
            const Vec3 axis = c->axis.normalized();
            return c->point + axis.dot(p - c->point) * axis;
        }
        const Plane& plane = std::get<Plane>(*objects_[0]);
        const Vec3 n = plane.normal.normalized();
        return p - n.dot(p - plane.point) * n;
    }

    ArcEquations equations(const Vec3& foot) const {
        ArcEquations result;
        for (int i = 0; i < 3; ++i) result.equations[i] = equation(i, foot);
        return result;
    }

private:
    Equation equation(int i, const Vec3& near) const {
        // Of the base: its distance is t.
        const double radius = i == 0 ? 0 : radius_;
        const double kappa = i == 0 ? 1 : sides_[0] * sides_[i];
        if (const auto* s = std::get_if<Sphere>(objects_[i]))
            return Equation::round(s->center, Vec3::Zero(), i == 0 ? 0 : s->radius, radius, near, kappa);
        if (const auto* c = std::get_if<Cylinder>(objects_[i]))
            return Equation::round(c->point, c->axis, i == 0 ? 0 : c->radius, radius, near, kappa);
        const Plane& plane = std::get<Plane>(*objects_[i]);
        return Equation::plane(plane.point, sides_[i] * plane.normal.normalized(), radius,
                               i == 0 ? 1 : sides_[0]);
    }

    std::array<const Object*, 3> objects_;
    std::array<int, 3> sides_;
    double radius_ = 0;
};

// The tubes first, ..., last - 1 of a component.
struct TubeRange {
    std::size_t first, last;
};

// Where a component runs, as its tubes tell.
class TubeGuide {
public:
    using Piece = std::size_t;  // the tube's number
    struct Trims {
        static constexpr bool crosses_seam() { return false; }
    };
    using Span = Points;

    TubeGuide(const Sites& sites, const ArcEquations& equations, const CurveSystem<3>& f,
              const Component& component)
        : sites_(sites), equations_(equations), f_(f), component_(component) {}

    static Points span(const Points& points, const Trims&) { return points; }
    Vector4d end_of(const Piece& piece) const { return sites_.middle(component_.joints[piece + 1]); }
    bool holds(const Piece& piece, const Vector4d& X, double slack) const {
        const CurveTube& tube = component_.tubes[piece];
        return std::abs(parameter(tube, X) - tube.parameter().mid()) <= tube.parameter().radius() + slack;
    }
    static Trims place_trims(const Points&, double) { return {}; }
    static auto prove_trims(const TubeProof&, const Points&, const Trims&, const SpanPolynomials&,
                            const Residuals&) {
        return [](const Points&, const LocalEquations&, const space_fit::Tube&) { return 0.0; };
    }

    std::optional<Node> half_way(const Node& from, const Node& to, const Piece* piece, const Points&,
                                 const Trims&, double) const {
        const auto found = equations_.find(sites_.middle(half_way(from, to, *piece)));
        return found && is_between(from, *found, to) ? found : equations_.find(0.5 * (from.X + to.X));
    }

    // Chords where no proof reaches, at clusters, are not the fit's (ComponentFit).
    static std::optional<SpaceBox> enclosure(const Chord&, const Piece*, FitEffort&) { return std::nullopt; }

private:
    Place half_way(const Node& from, const Node& to, const Piece& piece) const {
        const CurveTube& tube = component_.tubes[piece];
        const Interval range = tube.parameter();
        const auto within = [&](const Vector4d& X) {
            return std::clamp(parameter(tube, X), range.lower(), range.upper());
        };
        return point_at<3>(f_, tube, std::midpoint(within(from.X), within(to.X)));
    }
    double parameter(const CurveTube& tube, const Vector4d& X) const {
        return tube.axis < 3 ? X[tube.axis] : sites_.r(X[3]);
    }

    const Sites& sites_;
    const ArcEquations& equations_;
    const CurveSystem<3>& f_;
    const Component& component_;
};

// Has the derivative of an unknown along the curve, by the tangent T at X, certainly the sign that it seems
// to have? M takes the true tangent to what the rows may be off, but for its share c of T: so it is c T to
// within q (step 2 of spline_fit.hpp), and c is at least 1 - q.
bool is_certain(const ArcEquations& equations, const ArcEnd& at, int unknown) {
    const Frame frame = equations.frame(at.node.X);
    std::array<double, 4> variations{};
    for (int i = 0; i < 3; ++i) variations[i] = equations[i].variation(at.node.X, at.error);
    const Solver solver(frame.matrix(), variations);
    return 2 * solver.q < std::min(1.0, std::abs(frame.T[unknown]));
}

RationalCurve3 joined(const std::vector<Points>& spans) {
    RationalCurve3 curve;
    curve.degree = 5;
    double t = 0;
    curve.knots.assign(6, t);
    curve.points.push_back(spans.front().col(0).head<3>().homogeneous());
    for (const Points& span : spans) {
        for (int k = 1; k < 6; ++k) {
            curve.points.push_back(span.col(k).head<3>().homogeneous());
            t += (span.col(k) - span.col(k - 1)).head<3>().norm();
        }
        curve.knots.insert(curve.knots.end(), 5, t);
    }
    curve.knots.push_back(t);
    return curve;
}

class ComponentFit {
public:
    ComponentFit(const Sites& sites, const CurveSystem<3>& f, const Component& component, double tolerance)
        : sites_(sites), f_(f), component_(component), tolerance_(tolerance) {}

    // What rounding blurs is not proved to less: there a greater tolerance does better.
    TrisectorSpline run() {
        constexpr int looser = 8, most_attempts = 8;
        for (int attempt = 1;; ++attempt, tolerance_ *= looser) {
            spans_.clear();
            error_ = 0;
            fit();
            if (error_ < infinity || attempt == most_attempts) return {joined(spans_), error_};
        }
    }

private:
    // Towards a cluster proved parts get ever shorter: chords follow the curve there as far as they may.
    void fit() {
        const std::size_t n = component_.tubes.size();
        TubeRange inner{0, n};
        const auto joints = [&](std::size_t k) { return component_.joints[k]; };
        while (ends_in_cluster(0) && inner.first < n &&
               chord_error({0, inner.first + 1}, joints) <= tolerance_)
            ++inner.first;
        while (ends_in_cluster(1) && inner.last > inner.first &&
               chord_error({inner.last - 1, n}, joints) <= tolerance_)
            --inner.last;
        if (inner.first > 0) add_chord({0, inner.first});
        if (inner.first < inner.last) add_spline(inner);
        if (inner.last < n) add_chord({inner.last, n});
    }

    bool ends_in_cluster(int end) const {
        return !component_.closed && component_.ends[end].kind == CurveEnd::Kind::Cluster;
    }

    // How far the curve is from the chord below some tubes. Its projection covers the chord: no point of that
    // is farther from the curve.
    template <class Joint>
    double chord_error(const TubeRange& range, const Joint& joint) const {
        const SpaceBox ends[] = {sites_.enclosure(joint(range.first)), sites_.enclosure(joint(range.last))};
        const Vector4d from = 0.5 * (ends[0][0] + ends[0][1]), chord = 0.5 * (ends[1][0] + ends[1][1]) - from;
        double most = std::max((ends[0][1] - ends[0][0]).norm(), (ends[1][1] - ends[1][0]).norm());
        for (std::size_t k = range.first; k < range.last; ++k) {
            const SpaceBox box = sites_.enclosure(component_.tubes[k].enclosure);
            const Vector4d m = 0.5 * (box[0] + box[1]) - from;
            const double s = chord.isZero(0) ? 0 : std::clamp(m.dot(chord) / chord.squaredNorm(), 0.0, 1.0);
            most = std::max(most, (m - s * chord).norm() + 0.5 * (box[1] - box[0]).norm());
        }
        return most * (1 + rounding) + rounding * (from.norm() + chord.norm());
    }

    // Towards a cluster doubles tell joints ever less well than a fit needs that is to start there.
    Place joint(std::size_t k) const {
        const std::size_t n = component_.tubes.size();
        const bool is_face = (k == 0 && !ends_in_cluster(0)) || (k == n && !ends_in_cluster(1));
        if (is_face || !(ends_in_cluster(0) || ends_in_cluster(1))) return component_.joints[k];
        constexpr int bits = 80;  // of the tube's neighbourhood
        const CurveTube& tube = component_.tubes[std::min(k, n - 1)];
        const WideBox<unknowns> at = point_at<3>(f_, tube, Wide(k < n ? tube.begin : tube.end), bits);
        return {at[0].enclosure(), at[1].enclosure(), at[2].enclosure(), at[3].enclosure()};
    }

    void add_chord(const TubeRange& range) {
        const Vector4d from = sites_.middle(joint(range.first)), to = sites_.middle(joint(range.last));
        Points points = Points::Zero();
        for (int k = 0; k < 6; ++k) points.col(k).head<4>() = from + k / 5.0 * (to - from);
        spans_.push_back(points);
        error_ = std::max(error_, chord_error(range, [&](std::size_t k) { return joint(k); }));
    }

    void add_spline(const TubeRange& range) {
        const Place first = joint(range.first), last = joint(range.last);
        const Vec3 foot = sites_.foot_below(sites_.middle(first).head<3>());
        ArcEquations equations = sites_.equations(foot);
        const auto end_at = [&](const Place& place) {
            const SpaceBox box = sites_.enclosure(place);
            const Vector4d X = sites_.middle(place);
            const double error = (X - box[0]).cwiseAbs().cwiseMax((X - box[1]).cwiseAbs()).norm();
            return ArcEnd{equations.node(X), error};
        };
        const CurveTube& tube = component_.tubes[range.first];
        const double along = end_at(first).node.T[tube.axis] * (tube.axis < 3 ? 1 : sites_.sense());
        if ((along > 0) != (tube.begin < tube.end)) std::swap(equations.equations[1], equations.equations[2]);
        equations.tell_apart(sites_.middle(first));
        const ArcEnd start = end_at(first);
        std::optional<ArcEnd> end;
        if (!component_.closed) end = end_at(last);

        const TubeGuide guide(sites_, equations, f_, component_);
        std::vector<std::size_t> pieces(range.last - range.first);
        std::iota(pieces.begin(), pieces.end(), range.first);
        FitEffort effort;
        SplineFit<TubeGuide> fit(guide, equations, foot, tolerance_, start, end, spans_, effort);
        fit.fit_all(pieces);
        const bool is_proved =
            fit.is_proved() && (component_.closed || is_certain(equations, start, tube.axis));
        error_ = std::max(error_, is_proved ? fit.error().curve : infinity);
    }

    const Sites& sites_;
    const CurveSystem<3>& f_;
    const Component& component_;
    double tolerance_;
    std::vector<Points> spans_;
    double error_ = 0;
};

}  // namespace

TrisectorSpline fit_trisector(const std::array<const Object*, 3>& objects, const std::array<int, 3>& sides,
                              const CurveSystem<3>& f, const Component& component, double tolerance) {
    const Sites sites(objects, sides);
    return ComponentFit(sites, f, component, tolerance).run();
}

}  // namespace vcell
