#include "cone_form.hpp"

#include <cmath>

namespace vcell {

// A power of two that brings the slant to [1/2, 1) is exact, as their quotient is all that counts.
ConeForm::ConeForm(const HollowCone& cone) : apex(cone.apex) {
    int exponent = 0;
    std::frexp(cone.slant, &exponent);
    axis = ExactVector(scaled_axis(cone.axis));
    rim = Exact(cone.radius).scaled(-exponent);
    slant = Exact(cone.slant).scaled(-exponent);
    a = rim * axis;
    g = slant * length_of(axis);
    N = dot(a, a);
}

ConeForm::Room ConeForm::room(const ExactVector& center, const Exact& rho) const {
    const ExactVector D = center - apex;
    const Exact along = dot(D, a), part = g * along + N * rho;
    return {along + g * rho, part * part - N * (g * g - N) * (dot(D, D) - rho * rho)};
}

bool is_beside(const ConeForm& cone, const Ball& ball) {
    return !cone.room(ExactVector(Vec3(ball.cx, ball.cy, ball.cz)), ball.rho).is_more();
}

// Along the tube's axis p + s b the distance from the wall is a linear function less the cosine times that
// from the cone's axis: h - cos sqrt(e^2 + (s - s0)^2 b'^2), b' across the axis. It is bounded above where
// cos b' is no less than the slope of h, and greatest
//
//     h(s0) - e sqrt(cos^2 - (slope / b')^2),
//
// at most. T = N b'^2, U = -T s0, and Q / N is the squared distance of p from the cone's axis.
bool is_beside(const ConeForm& cone, const CylinderForm& tube) {
    const ExactVector b(Vec3(tube.ax, tube.ay, tube.az)),
        D = ExactVector(Vec3(tube.px, tube.py, tube.pz)) - cone.apex;
    const Exact &g = cone.g, &N = cone.N, along = dot(D, cone.a), rise = dot(b, cone.a),
                T = N * dot(b, b) - rise * rise, U = N * dot(D, b) - along * rise,
                Q = N * dot(D, D) - along * along, bound = (g * g - N) * T - N * rise * rise;
    if (T.sign() != Sign::Positive || bound.sign() == Sign::Negative) return false;
    const Exact X = along * T - U * rise + g * T * tube.rho;
    return X.sign() != Sign::Positive || (X * X * N - (Q * T - U * U) * bound).sign() != Sign::Positive;
}

bool contains(const ConeForm& cone, const Vec3& center, double rho) {
    return cone.room(ExactVector(center), -Exact(rho)).is_no_less();
}

// Both distances are least over the planes that touch the walls, and these have the same normals n where
// angles and axes agree: n.(p - apex) grows by n.(apex - inner.apex) then, which is no less than nothing
// where the inner apex is within. Otherwise a normal of the outer cone is no mean of the inner one's: it
// comes to less somewhere, behind the inner apex, where base bodies may reach.
bool contains(const ConeForm& outer, const ConeForm& inner) {
    return (outer.rim * inner.slant - inner.rim * outer.slant).sign() == Sign::Zero &&
           cross(outer.axis, inner.axis).is_zero() && dot(outer.axis, inner.axis).sign() == Sign::Positive &&
           outer.room(inner.apex, Exact()).is_no_less();
}

// The apex does, and the normal leans from the axis by no more than what the half angle leaves of a right
// one.
bool is_beyond(const ExactVector& n, const Exact& d, const ConeForm& cone) {
    if ((dot(n, cone.apex) + d).sign() == Sign::Negative) return false;
    const Exact along = cone.g * dot(n, cone.a);
    return along.sign() == Sign::Positive &&
           (along * along - cone.N * cone.N * dot(n, n)).sign() != Sign::Negative;
}

}  // namespace vcell
