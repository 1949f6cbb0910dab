/// The inside of a cone in numbers that are exact, and how it lies about other solids, by exact signs.
///
/// With a along the axis and |a| / g the sine of half its angle, N = |a|^2 and D the way from the apex, a
/// point is D.a / g - cos |D across a| away from the wall, as far as from the nearest of all planes that
/// touch it: the cone is what lies within all of these. That is at least -rho where
///
///     P = D.a + g rho >= 0   and   C = (g D.a + N rho)^2 - N (g^2 - N) (|D|^2 - rho^2) >= 0,
///
/// as C is N (P^2 - (g^2 - N) |D across a|^2). Beyond the apex, where P < 0, the other half of the cone has
/// C >= 0 as well, and counts for nothing.
#pragma once

#include "../forms/cylinder_form.hpp"
#include "../objects/exact_space.hpp"
#include "canonical.hpp"

namespace vcell {

struct ConeForm {
    ExactVector apex, a;
    Exact g, N;
    ExactVector axis;  ///< a = rim axis and g = slant |axis|, rim and slant being in the ratio of a cone's
    Exact rim, slant;

    /// |axis| is told by two doubles, as |n| of planes is.
    explicit ConeForm(const HollowCone& cone);

    /// P and C of a ball's centre and radius.
    struct Room {
        Exact P, C;

        /// Is the distance more, or no less, than -rho?
        bool is_more() const { return P.sign() == Sign::Positive && C.sign() == Sign::Positive; }
        bool is_no_less() const { return P.sign() != Sign::Negative && C.sign() != Sign::Negative; }
    };
    Room room(const ExactVector& center, const Exact& rho) const;
};

/// Is the closed ball clear of what is within the cone, or does it touch that from outside?
bool is_beside(const ConeForm& cone, const Ball& ball);
bool is_beside(const ConeForm& cone, const CylinderForm& tube);

/// Is the ball part of what is within the cone? Then no point is farther from the ball's own wall, seen from
/// within, than from the cone's.
bool contains(const ConeForm& cone, const Vec3& center, double rho);
/// Is the inner wall at every point as near as the outer one or nearer, beyond both, too? That takes more
/// than that the inside of the inner cone is part of that of the outer one. Both ways: the same cone.
bool contains(const ConeForm& outer, const ConeForm& inner);

/// Does what is within the cone lie in the closed half-space n.p + d >= 0?
bool is_beyond(const ExactVector& n, const Exact& d, const ConeForm& cone);

}  // namespace vcell
