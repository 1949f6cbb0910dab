/// Integrands (shadows.hpp) along conics, multiplied out into polynomials of degree two beforehand.
///
/// With n the homogeneous coordinates of a conic and w its weight, both of degree two in s, so are n' w - n
/// w' and n x n'. From a centre, |n| is a polynomial q of degree two where two bisectors of balls and planes
/// meet: on each of them the distance is linear in the point. Then the integrands are quotients of a few
/// polynomials whose coefficients have had their cancellations, and bounds over discs stay small where those
/// of sums of products would hold a pole.
#pragma once

#include <optional>
#include <variant>

#include "quadrature.hpp"
#include "shadows.hpp"

namespace vcell::check {

/// c0 + c1 s + c2 s^2.
struct Quadratic {
    std::array<MidRad, 3> c;
    double error = 0;  ///< from -1 to 1, what it stands for is no farther from it

    template <class T>
    T at(const T& s) const {
        const T value = (T(c[2]) * s + T(c[1])) * s + T(c[0]);
        if constexpr (std::is_same_v<T, Traced>)
            return Traced(value.range() + Disc(0, error), value.error() + error);
        else if constexpr (std::is_same_v<T, MidRad>)
            return value + MidRad::ball(0, error);
        else
            return value;
    }

    friend Quadratic operator+(const Quadratic& a, const Quadratic& b) {
        return {{a.c[0] + b.c[0], a.c[1] + b.c[1], a.c[2] + b.c[2]}, (a.error + b.error) * (1 + 0x1p-50)};
    }
    friend Quadratic operator*(const MidRad& k, const Quadratic& a) {
        return {{k * a.c[0], k * a.c[1], k * a.c[2]}, k.magnitude() * a.error * (1 + 0x1p-50)};
    }
    friend Quadratic operator-(const Quadratic& a, const Quadratic& b) { return a + MidRad(-1.0) * b; }
};

/// A span of degree two, or one.
class Conic {
public:
    /// Pre: the span's degree is one or two.
    Conic(const Span& span, bool about_sphere);

    /// The integrand of a face over the conic; none: it takes another form. Keeps a reference.
    struct Linear {
        Quadratic turn, rise;
        const LinearHeight* height;
    };
    struct Parabolic {
        Quadratic turn, x, y;
        const Paraboloid* height;
    };
    struct Round {
        Quadratic turn, around, near, sum;
        const Revolved* form;
        std::optional<std::array<Quadratic, 2>> from_start =
            std::nullopt;  ///< turn, around, where it has one
    };
    /// Along a line |n|^2 is of degree two.
    struct RoundAlongLine {
        Quadratic turn, along;
        const Revolved* form;
    };
    using Integrand = std::variant<Linear, Parabolic, Round, RoundAlongLine>;
    std::optional<Integrand> integrand(const Shadow& shadow) const;

    template <class T>
    struct Place {
        T squared_weight, weight, size;
        T speed;
    };
    template <class T>
    Place<T> at(const T& s) const {
        const T w = weight_.at(s), w2 = square(w);
        T sum(0.0);
        for (const Quadratic& v : velocity_) sum = sum + square(v.at(s));
        return {w2, w,
                size_           ? size_->at(s)
                : squared_size_ ? sqrt(squared_size_->at(s))
                                : T(0.0),
                sqrt(sum) / w2};
    }

    /// Has the speed a root of what may be zero in the disc? Surely not where it is false.
    bool is_speed_singular(const Disc& s) const {
        Disc sum = 0.0;
        for (const Quadratic& v : velocity_) sum = sum + square(v.at(s));
        return !(sum.center() > sum.radius());
    }

private:
    Triad<Quadratic> position_, velocity_, moment_;  ///< relative to the origin
    Triad<MidRad> origin_;
    Quadratic weight_;
    std::optional<Quadratic> size_, squared_size_;  ///< from a centre
};

/// A span of degree one about a sphere, beside flat faces: these have the triangle between its ends and the
/// foot of their axis there, and nothing takes a rule.
class Segment {
public:
    explicit Segment(const Span& span);

    MidRad length() const;
    /// Volume, area and shadow. None: the face is not flat, or the segment not all on its side of the centre.
    std::optional<std::array<MidRad, 3>> beside(const Shadow& shadow) const;

private:
    std::array<Triad<MidRad>, 2> relative_, ends_;  ///< homogeneous, about the span's origin and the centre
    std::array<MidRad, 2> weights_, sizes_;
    Triad<MidRad> moment_;  ///< the product of both ends
    MidRad product_;        ///< the inner one
};

/// Volume, area and shadow, per ds.
template <class T>
std::array<T, 3> densities(const Conic::Integrand& integrand, const T& s, const Conic::Place<T>& p);

}  // namespace vcell::check
