#include "arc_measures.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "half_rules.hpp"

namespace vcell {

namespace arc_measures {

using Eigen::Vector3d;
using radial_integrals::RoundFace;
using roundoff::u;
using span_integrals::term_rounding;

// Aimed at for the truncation of one span, as a part of the integrand's size, as along conics
// (round_integrals.cpp). What is reported is the bound that is reached.
constexpr double aim = 0x1p-40;
// Nothing that the integrands divide by or take the root of changes by more than this part over a disk.
constexpr double tame_part = 0.75;
constexpr double widest_disk = 16;  // radius; the span is [-1, 1]
constexpr int most_halvings = 24;
constexpr std::uint32_t no_face = UINT32_MAX;

static double squared(double x) { return x * x; }

// A quadratic on [-1, 1], from its control points.
template <class T>
struct Powers {
    T c0, c1, c2;

    Powers(const T& first, const T& middle, const T& last)
        : c0(0.25 * (first + 2 * middle + last)),
          c1(0.5 * (last - first)),
          c2(0.25 * (first - 2 * middle + last)) {}
    // A half: that up to 0 or that from 0 on.
    Powers half(double sign) const {
        Powers h = *this;
        h.c0 = c0 + (0.5 * sign) * c1 + 0.25 * c2;
        h.c1 = 0.5 * c1 + (0.5 * sign) * c2;
        h.c2 = 0.25 * c2;
        return h;
    }
    T first() const { return c0 - c1 + c2; }
    T middle() const { return c0 - c2; }  // the control point
    T last() const { return c0 + c1 + c2; }
};

using Quadratic = Powers<double>;

template <class T>
static T value(const Quadratic& q, const T& s) {
    return q.c0 + s * (q.c1 + s * q.c2);
}
// How far it is from its value at 0 for |s| <= r.
static double deviation(const Quadratic& q, double r) { return r * (std::abs(q.c1) + r * std::abs(q.c2)); }

using Values = HalfRule::Values;

// p = U / Q is met at the distance t = W / Q.
struct Span {
    Powers<Vector3d> U;
    Quadratic W, Q;

    Span half(double sign) const { return {U.half(sign), W.half(sign), Q.half(sign)}; }
};

struct MeasuredFace {
    RoundFace round;
    Vector3d axis;  // turned
    FaceMeasures* sum;

    bool is_flat() const { return round.shape == RoundFace::Shape::Flat; }
};

// A face beside an arc: the arc runs counter-clockwise around it, or clockwise (-1).
struct Side {
    const MeasuredFace* face;
    double sign;
};

class SpanMeasurer {
public:
    // The curve is within `off` of the true one.
    SpanMeasurer(std::span<const Side> sides, double direction_error, double reciprocal_error)
        : sides_(sides), direction_error_(direction_error), reciprocal_error_(reciprocal_error) {
        for (const Side& side : sides)
            if (!side.face->is_flat()) least_ = std::max({least_, 0.0, -side.face->round.delta});
    }

    bool add(const Span& span, int halvings) {
        const double middle_t = span.W.c0 / span.Q.c0;
        if (!(span.Q.c0 > 0)) return false;
        const Quadratic turned = changes(span, middle_t);
        const double r = disk(span, turned, middle_t - least_);
        const Vector3d moment0 = span.U.c0.cross(span.U.c1), moment1 = 2 * span.U.c0.cross(span.U.c2),
                       moment2 = span.U.c1.cross(span.U.c2);
        const double m0 = moment0.norm(), m1 = moment1.norm(), m2 = moment2.norm(), of_span = m0 + m1 + m2;
        const double rho = r + std::sqrt(r * r - 1), shrink = 1 / squared(rho),
                     least = span.Q.c0 - deviation(span.Q, r);
        const double moment = (m0 + r * (m1 + r * m2)) / squared(least),
                     needed = aim * of_span / squared(span.Q.c0);
        double truncated = 64.0 / 15 / (1 - shrink) * squared(squared(shrink));
        int points = 4;
        for (; points < HalfRule::most_points && !(truncated * moment <= needed); points += 2)
            truncated *= squared(shrink);
        // NaN where there is no disk.
        if (!(truncated * moment <= needed)) {
            if (halvings == 0) return false;
            return add(span.half(-1), halvings - 1) && add(span.half(1), halvings - 1);
        }
        const double turn = deviation(turned, r) / least, near = middle_t - turn, far = middle_t + turn;
        // The control polygon is no shorter than the curve.
        const double w0 = span.Q.first(), w1 = span.Q.middle(), w2 = span.Q.last();
        const Vector3d corner = span.U.middle() / w1;
        const double length = (corner - span.U.first() / w0).norm() + (span.U.last() / w2 - corner).norm();
        const double t = std::max({span.W.first() / w0, span.W.middle() / w1, span.W.last() / w2});
        const double off = 1.1 * t * (direction_error_ + t * reciprocal_error_);
        // The reciprocal's error changes a height by this part of it at most: `off` bounds it to first order,
        // with a tenth for the rest. Beyond that the face is left to the engine.
        constexpr double most_relative_error = 0x1p-10;
        if (!(w0 > 0 && w1 > 0 && w2 > 0 && t * reciprocal_error_ < most_relative_error)) return false;
        const double strip = (2 * length + 4 * off) * off;
        const double error =
            truncated * moment + 2 * term_rounding * of_span / squared(std::min({w0, w1, w2}));
        std::array<Quadratic, 2> along{Quadratic(0, 0, 0), Quadratic(0, 0, 0)};
        for (std::size_t k = 0; k < sides_.size(); ++k) {
            const Vector3d& axis = sides_[k].face->axis;
            along[k].c0 = axis.dot(moment0);
            along[k].c1 = axis.dot(moment1);
            along[k].c2 = axis.dot(moment2);
        }
        add_values(HalfRule::of(points), span, along);
        for (const Side& side : sides_) add_errors(side, near, far, error, strip);
        return true;
    }

private:
    static Quadratic changes(const Span& span, double middle_t) {
        Quadratic turned(0, 0, 0);
        turned.c1 = span.W.c1 - middle_t * span.Q.c1;
        turned.c2 = span.W.c2 - middle_t * span.Q.c2;
        return turned;
    }
    // The radius of a disk on which Q keeps from 0 and t from what is `room` below it.
    static double disk(const Span& span, const Quadratic& turned, double room) {
        const auto reach = [](double linear, double quadratic, double bound) {
            return 2 * bound / (linear + std::sqrt(squared(linear) + 4 * quadratic * bound));
        };
        const double w1 = std::abs(span.Q.c1), w2 = std::abs(span.Q.c2);
        const double r = std::min(widest_disk, reach(w1, w2, tame_part * span.Q.c0));
        if (room == infinity) return r;
        room *= tame_part;
        return std::min(
            r, reach(std::abs(turned.c1) + room * w1, std::abs(turned.c2) + room * w2, room * span.Q.c0));
    }

    void add_values(const HalfRule& rule, const Span& span, const std::array<Quadratic, 2>& along) {
        std::array<Values, 2> moment, area, volume;
        for (std::size_t k = 0; k < sides_.size(); ++k) moment[k] = area[k] = volume[k] = Values::Zero();
        for (std::size_t first = 0; first < rule.x.size(); first += HalfRule::pairs_at_once) {
            const auto [s, rule_weight] = rule.group(first);
            const Values over = 1 / value(span.Q, s), weight = rule_weight * over.square(),
                         t = value(span.W, s) * over;
            for (std::size_t k = 0; k < sides_.size(); ++k) {
                const Values element = weight * value(along[k], s);
                moment[k] += element;
                if (sides_[k].face->is_flat()) continue;
                const RoundFace::Factors<Values> f = sides_[k].face->round.factors(t);
                area[k] += element * f.area;
                volume[k] += element * f.volume;
            }
        }
        for (std::size_t k = 0; k < sides_.size(); ++k) {
            const auto& [face, sign] = sides_[k];
            const double all = sign * moment[k].sum();
            face->sum->both.value += face->round.c / 6 * all;
            face->sum->area.value += face->is_flat() ? 0.5 * all : sign * area[k].sum();
            face->sum->volume.value += face->is_flat() ? face->round.d1 / 6 * all : sign * volume[k].sum();
        }
    }

    static void add_errors(const Side& side, double near, double far, double error, double strip) {
        const RoundFace& f = side.face->round;
        FaceMeasures& sum = *side.face->sum;
        double of_area = 0.5, of_volume = f.d1 / 6;
        if (!side.face->is_flat()) {
            const double scale = f.c / (near + f.d2);
            of_volume = scale / 12 * (far + f.d1);
            of_area = scale * std::sqrt(far * (far + std::abs(f.delta))) / (2 * f.root);
        }
        sum.area.error += of_area * error + strip * f.area_slope(near, far);
        sum.volume.error += of_volume * error + strip * f.volume_slope(near, far);
        sum.both.error += f.c / 6 * (error + 2 * strip);
    }

    const std::span<const Side> sides_;
    const double direction_error_, reciprocal_error_;
    double least_ = -infinity;  // t is greater, where bisectors are not flat
};

class ArcMeasurer {
public:
    ArcMeasurer(const RadialBaseProblem& problem, const DiscArcs& arcs, const std::vector<char>& is_asked,
                ArcMeasures& measures)
        : arcs_(arcs), measures_(measures) {
        measures = {};
        measures.faces.resize(arcs.faces.size());
        place_.assign(arcs.forms.size(), no_face);
        is_flat_.assign(arcs.forms.size(), 0);
        faces_.reserve(arcs.faces.size());
        const Eigen::Matrix3d back = problem.chart.turn.transpose();
        for (std::size_t i = 0; i < arcs.faces.size(); ++i) {
            const FormId form = arcs.faces[i];
            const RoundFace round(problem, form);
            // The least of all forms' least distances is that of one which is nearest there.
            measures.least = std::min(measures.least, round.d1);
            is_flat_[form.value] = round.shape == RoundFace::Shape::Flat ? 1 : 0;
            if (is_asked[i] == 0) continue;
            place_[form.value] = static_cast<std::uint32_t>(faces_.size());
            faces_.push_back({round, back * round.axis, &measures.faces[i]});
        }
    }

    bool run() {
        return std::ranges::all_of(arcs_.arcs, [&](const DiscArcs::Arc& a) { return add(a); });
    }

private:
    // On one circle: a part of an arc.
    struct Circle {
        const DiscArcs::Arc* arc;
        Vector3d center;
        double error;  // of the normal's direction and the offset, in lengths
    };

    const MeasuredFace* face(FormId form) const {
        const std::uint32_t place = place_[form.value];
        return place != no_face ? &faces_[place] : nullptr;
    }

    bool add(const DiscArcs::Arc& arc) {
        const discs::Linear &f = arcs_.forms[arc.left.value], &g = arcs_.forms[arc.right.value];
        form_ = f.error < g.error ? &f : &g;
        rounding_ = 8 * u * (form_->slope + std::abs(form_->e)) + form_->error;
        sides_.clear();
        if (const MeasuredFace* left = face(arc.left)) sides_.push_back({left, 1});
        if (const MeasuredFace* right = face(arc.right)) sides_.push_back({right, -1});
        const Circle circle{&arc, arc.offset / arc.square * arc.normal, arc.error / arc.length};
        const DiscArcs::Vertex &p = arcs_.vertices[arc.from], &q = arcs_.vertices[arc.to];
        add_place(p.p, p.error);
        add_place(q.p, q.error);
        return add(circle, p.p, q.p, p.error + q.error, 8);
    }
    void add_place(const Vector3d& p, double error) { add_distance(-(*form_)(p), error); }
    // A reciprocal of a distance, from a direction within an error.
    void add_distance(double q, double error) {
        const double t = q > 0 ? 1 / q : infinity;
        measures_.most = std::max(measures_.most, t);
        measures_.most_error =
            std::max(measures_.most_error, 1.1 * t * t * (form_->slope * error + rounding_));
    }

    // With m the middle of the chord, seen from the circle's centre, and h half the chord the tangents meet
    // in (p + q) / 2 + h^2 m / |m|^2; for arcs of up to a quarter of a turn g = h / |m| <= 1. The ends'
    // errors together are s, the centre's is 2 e: that of m is d = s / 2 + 2 e. An inversion m -> m / |m|^2
    // changes it by |d| / |m|^2, and h^2 is off by h s, so the point is off by s / 2 + g^2 d + g s; the
    // weight, |m| over the radius, is off by a part of less than (d + s) / |m|, which moves the arc by no
    // more than half as much of h^2 / |m|, the point's height over the chord: g^2 (d + s) / 2.
    bool add(const Circle& circle, const Vector3d& p, const Vector3d& q, double ends, int halvings) {
        const Vector3d chord = q - p, middle = 0.5 * (p + q) - circle.center;
        const double half2 = 0.25 * chord.squaredNorm(), depth2 = middle.squaredNorm(),
                     radius2 = half2 + depth2;
        const DiscArcs::Arc& arc = *circle.arc;
        const bool is_plain = depth2 > half2 && (arc.is_short || middle.dot(chord.cross(arc.normal)) > 0);
        if (!is_plain) {
            if (halvings == 0) return false;
            const Vector3d half_way =
                circle.center + std::sqrt(radius2) * chord.cross(arc.normal).normalized();
            const double more = ends + (4 + 2 / std::sqrt(radius2)) * circle.error + 16 * u;
            add_place(half_way, more);
            return add(circle, p, half_way, ends + more, halvings - 1) &&
                   add(circle, half_way, q, ends + more, halvings - 1);
        }
        const double slant2 = half2 / depth2, slant = std::sqrt(slant2);
        const double off = 1.1 * (ends + slant * ends + slant2 * (1.25 * ends + 3 * circle.error)) + 16 * u;
        add_extreme(circle, p, q, std::sqrt(radius2), off);
        if (sides_.empty()) return true;
        const double kappa = std::sqrt(depth2 / radius2);
        const Vector3d apex = kappa * (0.5 * (p + q) + slant2 * middle);
        const discs::Linear& f = *form_;
        const double first = -f(p), last = -f(q), between = -(f.b.dot(apex) + kappa * f.e);
        const double doubt = f.slope * off + rounding_;
        constexpr double most_doubt = 0x1p-30;
        if (!(off < most_doubt && doubt < most_doubt * std::min(first, last))) return false;
        const double beside = arc.extent < infinity ? arc.extent : 0, off_here = off + beside,
                     doubt_here = doubt + f.slope * beside;
        // Between flat bisectors it is a segment.
        if (is_flat_[arc.left.value] != 0 && is_flat_[arc.right.value] != 0) {
            add_segment(p / first, q / last, off_here, doubt_here);
            return true;
        }
        return SpanMeasurer({sides_.begin(), sides_.end()}, off_here, doubt_here)
            .add({Powers<Vector3d>(p, apex, q), Quadratic(1, kappa, 1), Quadratic(first, between, last)},
                 most_halvings);
    }

    // Inside the arc 1 / t = -f may have its least value, where it first falls and then rises.
    void add_extreme(const Circle& circle, const Vector3d& p, const Vector3d& q, double radius, double off) {
        const Vector3d falling = form_->b.cross(circle.arc->normal);  // times the direction: the slope of f
        if (!(falling.dot(p) > 0 && falling.dot(q) < 0)) return;
        const double least = -(*form_)(circle.center) - radius * falling.norm() / circle.arc->length;
        // The centre is off by 2 e, the radius by about e over it.
        add_distance(least, off + 4 * (1 + 1 / radius) * circle.error);
    }

    void add_segment(const Vector3d& from, const Vector3d& to, double direction_error,
                     double reciprocal_error) {
        const Vector3d along = to - from, moment = from.cross(along);
        const double length = along.norm(), t = std::max(from.norm(), to.norm()),
                     off = 1.1 * t * (direction_error + t * reciprocal_error),
                     strip = (2 * length + 4 * off) * off, size = term_rounding * t * length;
        for (const auto& [face, sign] : sides_) {
            const double value = sign * face->axis.dot(moment), error = size + 2 * strip;
            face->sum->area += {0.5 * value, 0.5 * error};
            face->sum->volume += {face->round.d1 / 6 * value, face->round.d1 / 6 * error};
            face->sum->both += {face->round.c / 6 * value, face->round.c / 6 * error};
        }
    }

    const DiscArcs& arcs_;
    ArcMeasures& measures_;
    std::vector<MeasuredFace> faces_;   // that are asked about
    std::vector<std::uint32_t> place_;  // of forms, among those
    std::vector<char> is_flat_;         // of forms that have a face
    // The arc at hand has these: the form that is told best, what its error and rounding change about values
    // of it, and the faces.
    const discs::Linear* form_ = nullptr;
    double rounding_ = 0;
    SmallVector<Side, 2> sides_;
};

}  // namespace arc_measures

bool measure_arcs(const RadialBaseProblem& problem, const DiscArcs& arcs, const std::vector<char>& is_asked,
                  ArcMeasures& measures) {
    return arc_measures::ArcMeasurer(problem, arcs, is_asked, measures).run();
}

}  // namespace vcell
