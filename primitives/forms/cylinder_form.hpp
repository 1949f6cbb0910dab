/// The height of a cylinder's bisector over a plane base, and of a hollow cone's.
///
/// Base z = 0, cell on z > 0. The point (x, y, r) is as far from the base as from the cylinder of radius
/// rho about the line p + s a when, with m = (x, y, 0) - p,
///
///     C - 2 beta r - A r^2 = 0,   C    = |a|^2 (|m|^2 - rho^2) - (m . a)^2,
///                                 beta = |a|^2 (rho + p_z) + (m . a) a_z,
///                                 A    = a_z^2
///
/// ([HE, Table 1, plane-cylinder] for an axis of any length: everything stays polynomial in the input).
/// C > 0 outside the cylinder's trace on the base, and there the height is the one positive root
///
///     r = C / (beta + sqrt(beta^2 + A C)).
///
/// The bisector is an elliptic cone; a parabolic cylinder when the axis is parallel to the base (A = 0).
///
/// A hollow cylinder, seen from within, has the radius below 0: rho = -R. Over the trace C < 0, and its wall
/// is met at the smaller root
///
///     r = C / (beta - sqrt(beta^2 + A C)),
///
/// which is R - the distance from the axis, 0 on the trace's rim and negative beyond. The bisector is the
/// lower nappe of a cone with its tip on the axis, where the root beta^2 + A C = 0.
///
/// A hollow cone has its apex in p, and rho = 0. With S its half angle's sine times |a|, a point q is
/// (S (q - p) . a - sqrt(M) |(q - p) x a|) / |a|^2 away from the wall, M = |a|^2 - S^2, and that is r at the
/// smaller root, too, of
///
///     C = M |m|^2 - (m . a)^2,   beta = M p_z + lambda (m . a),   A = lambda^2,   lambda = a_z - S.
///
/// So tubes have S = 0, and for all of them, as either rho or S is 0,
///
///     C = M |m|^2 - |a|^2 rho^2 - (m . a)^2,   beta = |a|^2 rho + M p_z + lambda (m . a),
///     beta^2 + A C = M |V|^2,                  V = lambda (x - p_x, y - p_y) + (rho + p_z) (a_x, a_y).
///
/// lambda = 0 where a line of the wall is parallel to the base. The height of the tip is then infinite; else
/// it is -rho - S p_z / lambda, which no base point in the wall sees where it is below 0.
#pragma once

#include <array>
#include <cmath>
#include <memory>

#include "../../core/numbers/exact.hpp"

namespace vcell {

/// A cylinder's numbers in canonical coordinates; the axis need not be unit.
template <class T>
struct CylinderNumbers {
    T px, py, pz;  ///< a point of the axis; the apex of a cone
    T ax, ay, az;  ///< its direction; of a cone into it
    T rho;         ///< below 0: seen from within
    T sine;        ///< S
    T steep;       ///< lambda
};

/// A cylinder whose numbers are all multiplied by `unit` > 0, so that they are exact.
struct ExactCylinder : CylinderNumbers<Exact> {
    Exact unit;
};

/// The cylinder in canonical coordinates. The doubles are the exact definition, or within 4u of it: where the
/// scene was turned, which doubles do not survive, they stand for `exact`.
struct CylinderForm {
    double px = 0, py = 0, pz = 0;  ///< a point of the axis; the apex of a cone
    double ax = 0, ay = 0, az = 0;  ///< its direction
    double rho = 0;
    double sine = 0;                                       ///< S; above 0: a hollow cone
    double steep_of_cone = 0;                              ///< lambda, rounded once
    std::shared_ptr<const ExactCylinder> exact = nullptr;  ///< none: the doubles are exact; cones have one

    bool is_cone() const { return sine > 0; }
    double steep() const { return is_cone() ? steep_of_cone : az; }
    bool is_hollow() const { return rho < 0 || is_cone(); }
};

/// The form's doubles in another number type.
template <class T>
CylinderNumbers<T> numbers_of(const CylinderForm& f) {
    return {T(f.px), T(f.py), T(f.pz), T(f.ax), T(f.ay), T(f.az), T(f.rho), T(f.sine), T(f.steep())};
}

inline ExactCylinder exact_cylinder(const CylinderForm& f) {
    return f.exact ? *f.exact : ExactCylinder{numbers_of<Exact>(f), 1.0};
}

/// Converts an exact cylinder to another number type that has a division.
template <class T, class Convert>
CylinderNumbers<T> converted(const ExactCylinder& f, Convert&& convert) {
    const T unit = convert(f.unit);
    const auto over_unit = [&](const Exact& v) {
        return v.sign() == Sign::Zero ? T(0.0) : convert(v) / unit;
    };
    return {over_unit(f.px), over_unit(f.py),  over_unit(f.pz),   over_unit(f.ax),   over_unit(f.ay),
            over_unit(f.az), over_unit(f.rho), over_unit(f.sine), over_unit(f.steep)};
}

/// C and beta at (x, y), in any number type that the cylinder's numbers convert to. Of an exact cylinder
/// lengths, x and y among them, are times its unit, and so is the axis.
template <class Form, class T>
std::array<T, 2> cylinder_terms(const Form& f, const T& x, const T& y) {
    const T ax(f.ax), ay(f.ay), az(f.az), pz(f.pz), rho(f.rho), sine(f.sine);
    const T mx = x - T(f.px), my = y - T(f.py);
    const T norm = ax * ax + ay * ay + az * az, M = norm - sine * sine;
    const T along = mx * ax + my * ay - pz * az;
    return {M * (mx * mx + my * my + pz * pz) - norm * rho * rho - along * along,
            norm * rho + M * pz + along * (az - sine)};
}

/// The height at (x, y) by the form's doubles. Pre: C > 0 there, or it is hollow.
/// Both forms of the root are written without cancellation.
template <class T>
T cylinder_height(const CylinderForm& f, const T& x, const T& y) {
    using std::sqrt;
    const auto [C, beta] = cylinder_terms(f, x, y);
    const T steep(f.steep()), A = steep * steep;
    const T root = sqrt(beta * beta + A * C);
    if (f.is_hollow()) return beta > T(0) ? -(root + beta) / A : C / (beta - root);
    return beta < T(0) ? (root - beta) / A : C / (root + beta);
}

}  // namespace vcell
