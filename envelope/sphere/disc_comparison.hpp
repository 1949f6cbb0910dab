/// How one more form, the challenger, compares with the vertices, edges and faces of a diagram of discs.
///
/// Signs at vertices are told in doubles, and by the kernel of circles, exactly, where these cannot tell. The
/// edges that such vertices leave may be too short to have a direction in doubles: they lie in a ball about
/// their ends. What vertices say goes on from there:
/// - A short arc lies in the triangle of its ends and the point where its tangents there meet, and the
///   difference c - f from the form of an edge's face is linear: signs in the three corners tell that c wins
///   nowhere on it.
/// - A face f within a hemisphere lies above the convex hull of its boundary, seen along the axis to the
///   pole. So where c loses on the boundary and c - f does not fall towards the pole, c loses in the face,
///   too. The pole is where f is lowest, and a form that others have beaten is mostly flatter than f.
#pragma once

#include <algorithm>
#include <cmath>

#include "disc_geometry.hpp"

namespace vcell::discs {

class DiscComparison : protected DiscGeometry {
protected:
    using DiscGeometry::DiscGeometry;

    // Does the challenger win or lose all of a face whose boundary it does not cross? It does unless the
    // circle where both tie lies within the face.
    bool is_within(const Linear& form, Index face) {
        const Linear& rival = forms_[face];
        ++decisions_.by_double;
        const bool is_lost = is_taken(vertices_[half_edges_[faces_[face].start].origin]);
        const Vector3d gradient = form.b - rival.b;
        const double slope = gradient.norm(), offset = form.e - rival.e, side = is_lost ? 1 : -1;
        return side * offset + slope < -(form.error + rival.error) ||
               is_outside(face, side / slope * gradient);
    }
    // The form is beaten on the face's boundary: is it certainly in the face, too?
    bool is_beaten_in(const Linear& form, Index face) {
        return (grows_to_pole(form, forms_[face]) && is_in_hemisphere(face)) || is_within(form, face);
    }
    // Compares form and diagram at the vertex. False where a form that is not the family's is too near.
    bool decide(Vertex& v, const Linear& form) {
        v.stamp = stamp_;
        ++decisions_.by_double;
        if (v.is_below(form)) return true;
        v.taken = stamp_;
        return v.is_above(form) || decide_exactly(v, form);
    }
    [[gnu::noinline]] bool decide_exactly(Vertex& v, const Linear& form) {
        --decisions_.by_double;
        const auto challenger = static_cast<Index>(&form - forms_.data());
        const auto sign = exact_sign(v, challenger);
        if (sign != Sign::Negative) v.taken = 0;
        if (sign == Sign::Zero) {
            add_tie(v.ties, challenger);
            if (is_point_asked_) {
                ties_[v.ties].point = point_;
                ties_[v.ties].generation = generation_;
            }
        }
        return sign.has_value();
    }
    // Does the challenger tie along the edge, and so on its whole circle? Then that is kept with the edge.
    [[gnu::noinline]] bool ties_along(Index e, const Linear& form) {
        const auto challenger = static_cast<Index>(&form - forms_.data());
        if (are_on_one_circle(left(2 * e), right(2 * e), challenger) != true) return false;
        add_tie(edges_[e].ties, challenger);
        return true;
    }
    // Without a tree all vertices have been compared.
    bool is_decided(Vertex& v, const Linear& form) {
        return !vertex_tree_ || v.stamp == stamp_ || decide(v, form);
    }
    bool is_taken(const Vertex& v) const { return v.taken == stamp_; }
    // Challenger - rival has one sign in both ends of the edge: has it that in the apex, and so in the whole
    // triangle about the arc?
    static bool is_beside(const Edge& edge, bool is_taken, const Linear& form) {
        return is_taken ? edge.apex.is_above(form) : edge.apex.is_below(form);
    }
    enum class Middle { Same, Differs, Unknown };
    // Challenger - rival has one sign in both ends of an edge: does it have the other one in between? Then
    // middle_ is where it has most of it.
    Middle look_between(Index e, bool is_taken, const Linear& form) {
        ++decisions_.by_double;
        const Edge& edge = edges_[e];
        const Vertex &p = vertices_[half_edges_[2 * e].origin], &q = vertices_[half_edges_[2 * e + 1].origin];
        const Linear& rival = forms_[left(2 * e)];
        const Vector3d gradient = form.b - rival.b;
        const double sign = is_taken ? -1 : 1, offset = form.e - rival.e, error = form.error + rival.error,
                     slope = gradient.norm(), end_error = std::max(p.error, q.error);
        // All around the circle it is a sinusoid plus a constant.
        const double length = edge.length, along = gradient.dot(edge.normal) / edge.square;
        const double at_center = along * edge.offset + offset;
        const Vector3d across = gradient - along * edge.normal;
        const double radius2 = 1 - edge.offset * edge.offset / edge.square;
        if (!(radius2 > least_square) || !is_well_known(edge)) return Middle::Unknown;
        const double steepness = across.norm(), radius = std::sqrt(radius2);
        // The centre's value moves by 2 e of the slope, the circle's highest by R's 32 e more.
        const double doubt = 4 * error + slope * (64 * edge.error / length + slack);
        const double extreme = sign * at_center - steepness * radius;
        if (extreme > doubt) return Middle::Same;
        // Less steep along the circle, a form has its extreme anywhere on it, for doubles.
        constexpr double least_steepness = 0x1p-20;
        if (!(extreme < -doubt) || !(steepness > least_steepness * slope)) return Middle::Unknown;
        const Vector3d center = edge.offset / edge.square * edge.normal;
        middle_ = center - sign * radius / steepness * across;
        // n.(a x b) for two points seen from the centre: each end is off by its error, the centre counts
        // across n only, e times |a - b| <= 2, and n itself by dn R^2.
        const double turn_doubt =
            length * (2 * end_error + slack) + 4 * edge.error + length * radius * doubt / steepness;
        const auto turn = [&](const Vector3d& a, const Vector3d& b) {
            const double value = edge.normal.dot(a.cross(b));
            return std::abs(value) > turn_doubt ? sign_of(value) : Sign::Zero;
        };
        // The sign of the ends' turn tells an arc of less than half a turn from the rest of the circle.
        const Sign size = turn(p.p - center, q.p - center);
        if (size == Sign::Zero) return Middle::Unknown;
        const Sign after_start = size * turn(p.p - center, middle_ - center),
                   before_end = size * turn(middle_ - center, q.p - center);
        if (after_start == Sign::Negative || before_end == Sign::Negative)
            return size == Sign::Positive ? Middle::Same : Middle::Differs;
        if (after_start == Sign::Zero || before_end == Sign::Zero) return Middle::Unknown;
        return size == Sign::Positive ? Middle::Differs : Middle::Same;
    }

    Index stamp_ = 0;  // the challenger's
    Vector3d middle_;  // as look_between() found it
};

}  // namespace vcell::discs
