/// Integrals along circular arcs and segments, by the rules of core/quadrature/quadrature.hpp.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>

#include "../../core/quadrature/quadrature.hpp"
#include "../diagram/chart_arc.hpp"

namespace vcell::quadrature {

/// A span with what its integrals ask for again and again.
struct Part {
    ArcSpan span;
    Eigen::Vector2d chord = span.chord(), half_way = span.half_way();
    double chord_length = chord.norm();
    Eigen::Vector2d tangent = chord_length > 0 ? Eigen::Vector2d(chord / chord_length) : chord;  // half way
    double sine = std::sin(span.half_angle), length = chord_length, curvature = 0;

    explicit Part(const ArcSpan& s) : span(s) {
        if (span.half_angle == 0) return;
        length *= span.half_angle / sine;
        curvature = 2 * sine / chord_length;
    }
};

/// sin a and 1 - cos a of the angles from an arc's middle to its nodes, |a| <= 0.8, to a few roundings: what
/// their Taylor series leave out, less than z^9 / 19! and 2 z^9 / 20! of z = a^2 <= 0.64, is below 2^-58 of
/// them.
template <int n>
struct NodeAngles {
    std::array<double, n / 2> sine, versine;

    explicit NodeAngles(double half_angle) {
        const RuleOf<n>& r = rule<n>();
        for (int i = 0; i < n / 2; ++i) {
            const double a = half_angle * r.x[i], z = a * a;
            double s = 0, v = 0;
            for (int k = 8; k >= 0; --k) {
                s = 1 - z * s * (1.0 / ((2 * k + 2) * (2 * k + 3)));
                v = 1 - z * v * (1.0 / ((2 * k + 3) * (2 * k + 4)));
            }
            sine[i] = a * s;
            versine[i] = 0.5 * z * v;
        }
    }
};

/// Calls visit(point, step) at the nodes of one span: the sum of g(point) . step approximates the line
/// integral of g. With m the middle of the arc, d the chord and d' the chord turned left, the point at
/// angle a from the middle is m + (sin a d + (1 - cos a) d') / (2 sin half_angle).
template <int n, class Visit>
void visit_nodes_of_rule(const Part& part, Visit&& visit) {
    const RuleOf<n>& r = rule<n>();
    const Eigen::Vector2d &middle = part.half_way, &d = part.chord, left(-d.y(), d.x());
    const double half_angle = part.span.half_angle;
    if (half_angle == 0) {
        for (int i = 0; i < n / 2; ++i) {
            const Eigen::Vector2d step = 0.5 * r.weight[i] * d, offset = 0.5 * r.x[i] * d;
            visit(Eigen::Vector2d(middle - offset), step);
            visit(Eigen::Vector2d(middle + offset), step);
        }
        return;
    }
    const double scale = 1 / (2 * part.sine);
    const NodeAngles<n> angles(half_angle);
    for (int i = 0; i < n / 2; ++i) {
        const double sine = angles.sine[i], versine = angles.versine[i];
        const double w = scale * half_angle * r.weight[i];
        const Eigen::Vector2d across = scale * versine * left, along = scale * sine * d;
        const Eigen::Vector2d step_along = w * (1 - versine) * d, step_across = w * sine * left;
        visit(Eigen::Vector2d(middle + across - along), Eigen::Vector2d(step_along - step_across));
        visit(Eigen::Vector2d(middle + across + along), Eigen::Vector2d(step_along + step_across));
    }
}

/// A rule that was taken errs by at most `truncation` times what bounds the integrand on the ellipse of
/// quadrature.hpp about a part that is so many times longer.
struct Taken {
    double times, truncation;
};

/// Takes the rule with the fewest nodes that a part's room allows, which may be lengthened about its middle
/// up to `room` times, as far as its half angle stays within 0.8 as others' do.
template <class Visit>
Taken visit_nodes(const Part& part, double room, const ShortRules& rules, Visit&& visit) {
    constexpr double largest_half_angle = 0.8;
    if (part.span.half_angle != 0) room = std::min(room, largest_half_angle / std::abs(part.span.half_angle));
    if (room >= rules.six) {
        visit_nodes_of_rule<6>(part, visit);
        return {rules.six, rules.truncation};
    }
    if (room >= rules.eight) {
        visit_nodes_of_rule<8>(part, visit);
        return {rules.eight, rules.truncation};
    }
    if (room >= rules.ten) {
        visit_nodes_of_rule<10>(part, visit);
        return {rules.ten, rules.truncation};
    }
    visit_nodes_of_rule<points>(part, visit);
    return {1, truncation};
}

/// Halves the span until reach(part) >= 2.5 half lengths, then calls visit_part(part, room): how many times
/// longer it could be, 1 or more.
/// reach: a lower bound on the radius (in arc length, about the middle) of analyticity. A singularity on the
/// span itself (an object that all but touches the base there) ends the halving at parts that are 2^-52 of
/// the span: their room is below 1, and the rule's truncation has no bound. The same where a budget of
/// halvings is spent, as by numbers that are none.
template <class Reach, class VisitPart>
void visit_parts(const ArcSpan& span, const Reach& reach, VisitPart&& visit_part, int halvings, int& budget) {
    const Part part(span);
    const double required = 0.5 * part.length * required_reach, known = reach(part);
    const double room = required <= known ? std::max(1.0, known / required) : 0;
    if (room == 0 && halvings > 0 && budget > 0) {
        --budget;
        for (const ArcSpan& half : span.halves()) visit_parts(half, reach, visit_part, halvings - 1, budget);
        return;
    }
    visit_part(part, room);
}
template <class Reach, class VisitPart>
void visit_parts(const ArcSpan& span, const Reach& reach, VisitPart&& visit_part) {
    int budget = most_halvings;
    visit_parts(span, reach, visit_part, 52, budget);
}

}  // namespace vcell::quadrature
