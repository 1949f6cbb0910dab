#include "conics.hpp"

#include <algorithm>
#include <cmath>

#include "face_terms.hpp"

namespace vcell::check {

namespace {

/// a b' - b a'.
Quadratic turn_of(const Quadratic& a, const Quadratic& b) {
    return {{a.c[0] * b.c[1] - a.c[1] * b.c[0], 2.0 * (a.c[0] * b.c[2] - a.c[2] * b.c[0]),
             a.c[1] * b.c[2] - a.c[2] * b.c[1]}};
}

Quadratic weighted_sum(const Triad<MidRad>& a, const Triad<Quadratic>& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// The polynomial that agrees with |n| at three places. The square tells how well it does everywhere:
/// ||n| - q| <= |n^2 - q^2| / q.
std::optional<Quadratic> size_of(const Triad<Quadratic>& n) {
    std::array<double, 3> at{};
    for (int k = 0; k < 3; ++k) {
        double sum = 0;
        for (const Quadratic& x : n) {
            const double s = k - 1, value = (x.c[2].mid() * s + x.c[1].mid()) * s + x.c[0].mid();
            sum += value * value;
        }
        at[static_cast<std::size_t>(k)] = std::sqrt(sum);
    }
    const double linear = 0.5 * (at[2] - at[0]), rest = 0.5 * (at[2] + at[0]) - at[1];
    Quadratic q{{at[1], linear, rest}};
    // A parabola is least at an end or at its vertex.
    double least = std::min(at[0], at[2]);
    if (rest > 0 && std::abs(linear) < 2 * rest)
        least = std::min(least, at[1] - linear * linear / (4 * rest));
    least -= 0x1p-50 * (at[1] + std::abs(linear) + std::abs(rest));
    double off = 0;
    for (int k = 0; k <= 4; ++k) {
        MidRad sum = 0.0;
        for (int i = std::max(0, k - 2); 2 * i <= k; ++i) {
            const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(k - i);
            MidRad product =
                n[0].c[a] * n[0].c[b] + n[1].c[a] * n[1].c[b] + n[2].c[a] * n[2].c[b] - q.c[a] * q.c[b];
            if (a < b) product = 2.0 * product;
            sum += product;
        }
        off += sum.magnitude();
    }
    constexpr double enough = 0x1p-40;
    q.error = off / least * (1 + 0x1p-48);
    if (!(least > 0) || !(q.error <= enough * least)) return std::nullopt;
    return q;
}

}  // namespace

Conic::Conic(const Span& span, bool about_sphere) {
    const auto coordinate = [&](std::size_t i) {
        return Quadratic{{span.coefficients[0][i], span.coefficients[1][i],
                          span.degree() == 2 ? span.coefficients[2][i] : MidRad(0.0)}};
    };
    weight_ = coordinate(3);
    for (std::size_t i = 0; i < 3; ++i) {
        position_[i] = coordinate(i);
        origin_[i] = span.origin[i];
        velocity_[i] = turn_of(weight_, position_[i]);
    }
    for (std::size_t i = 0; i < 3; ++i) moment_[i] = turn_of(position_[(i + 1) % 3], position_[(i + 2) % 3]);
    if (!about_sphere) return;
    // Not relative: n + o w, whose moment is n x n' + o x (n' w - n w').
    Triad<Quadratic> moment;
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
        moment[i] = moment_[i] + origin_[j] * velocity_[k] - origin_[k] * velocity_[j];
    }
    moment_ = moment;
    for (std::size_t i = 0; i < 3; ++i) position_[i] = position_[i] + origin_[i] * weight_;
    if (span.degree() == 2) {
        size_ = size_of(position_);
        return;
    }
    squared_size_.emplace();
    for (const Quadratic& x : position_)
        *squared_size_ =
            *squared_size_ + Quadratic{{square(x.c[0]), 2.0 * (x.c[0] * x.c[1]), square(x.c[1])}};
}

std::optional<Conic::Integrand> Conic::integrand(const Shadow& shadow) const {
    if (const auto* r = std::get_if<Revolved>(&shadow)) {
        if (squared_size_ && r->start) return std::nullopt;
        if (squared_size_)
            return RoundAlongLine{weighted_sum(r->axis, moment_), weighted_sum(r->axis, position_), r};
        if (!size_) return std::nullopt;
        const Quadratic along = weighted_sum(r->axis, position_), near = r->A * along + r->B * *size_;
        Round round{weighted_sum(r->axis, moment_), *size_ + along, near, r->b1 * *size_ + near, r};
        if (r->start)
            round.from_start = {weighted_sum(*r->start, moment_),
                                *size_ + weighted_sum(*r->start, position_)};
        return round;
    }
    // About a point of the plane: x dy - y dx, and coordinates.
    const auto turn = [&](const MidRad& x, const MidRad& y) {
        return moment_[2] + y * velocity_[0] - x * velocity_[1];
    };
    if (const auto* h = std::get_if<LinearHeight>(&shadow)) {
        const MidRad x = h->apex[0] - origin_[0], y = h->apex[1] - origin_[1];
        const Quadratic rise =
            h->gradient[0] * (position_[0] - x * weight_) + h->gradient[1] * (position_[1] - y * weight_);
        return Linear{turn(x, y), rise, h};
    }
    if (const auto* h = std::get_if<Paraboloid>(&shadow)) {
        const MidRad x = h->axis[0] - origin_[0], y = h->axis[1] - origin_[1];
        return Parabolic{turn(x, y), position_[0] - x * weight_, position_[1] - y * weight_, h};
    }
    return std::nullopt;
}

Segment::Segment(const Span& span) {
    const auto& [middle, slope] = std::array{span.coefficients[0], span.coefficients[1]};
    for (const std::size_t k : {0, 1}) {
        const auto at = [&](std::size_t i) { return k == 0 ? middle[i] - slope[i] : middle[i] + slope[i]; };
        weights_[k] = at(3);
        for (std::size_t i = 0; i < 3; ++i) {
            relative_[k][i] = at(i);
            ends_[k][i] = relative_[k][i] + span.origin[i] * weights_[k];
        }
        sizes_[k] = sqrt(square(ends_[k][0]) + square(ends_[k][1]) + square(ends_[k][2]));
    }
    // (p v + o v) x (q w) with q w = p' w + o w: p x p' + o x (p' v - p w), where what is large has
    // cancelled.
    const auto& [p, q] = relative_;
    Triad<MidRad> way;
    for (std::size_t i = 0; i < 3; ++i) way[i] = q[i] * weights_[0] - p[i] * weights_[1];
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
        moment_[i] = (p[j] * q[k] - p[k] * q[j]) + (span.origin[j] * way[k] - span.origin[k] * way[j]);
        product_ += ends_[0][i] * ends_[1][i];
    }
}

MidRad Segment::length() const {
    MidRad sum = 0.0;
    for (std::size_t i = 0; i < 3; ++i)
        sum += square(relative_[1][i] * weights_[0] - relative_[0][i] * weights_[1]);
    return sqrt(sum) / (weights_[0] * weights_[1]);
}

// Seen from the centre the segment lies on a great circle, and the face in the plane where z t = K / A: with
// both ends p and q at heights x and y over the centre's plane across the axis a, the triangle has the area
// (K / A)^2 det(a, p, q) / (2 x y) and the solid angle [VanOosterom83]
//     2 arctan(det(a, p, q) / (|p| |q| + x |q| + y |p| + p q)).
std::optional<std::array<MidRad, 3>> Segment::beside(const Shadow& shadow) const {
    const auto* form = std::get_if<Revolved>(&shadow);
    if (!form || form->is_paraboloid || form->B.magnitude() != 0) return std::nullopt;
    const auto inner = [&](const Triad<MidRad>& v) {
        return form->axis[0] * v[0] + form->axis[1] * v[1] + form->axis[2] * v[2];
    };
    const MidRad x = inner(ends_[0]), y = inner(ends_[1]), determinant = inner(moment_);
    if (!(x.lower() > 0) || !(y.lower() > 0)) return std::nullopt;
    const MidRad share = determinant / (x * y) / form->A;
    const MidRad sum = sizes_[0] * sizes_[1] + x * sizes_[1] + y * sizes_[0] + product_;
    // The angle of a point that is off by less than its distance from the origin is off by less than the
    // quotient of that by what is left of the distance; arctan itself by three units in its last place, as
    // glibc's manual states.
    const double off = (determinant.radius() + sum.radius()) * (1 + 0x1p-50),
                 reach = std::hypot(determinant.mid(), sum.mid()) * (1 - 0x1p-50) - off;
    if (!(reach > 0) || !(sum.lower() > 0)) return std::nullopt;
    const double angle = std::atan2(determinant.mid(), sum.mid());
    const MidRad shadow_of_face =
        2.0 * MidRad::ball(angle, (off / reach) * (1 + 0x1p-50) + 0x1p-50 * std::abs(angle));
    return std::array{form->volume * share, 0.5 * (form->K2 / form->A * share), shadow_of_face};
}

namespace {

template <class T>
std::array<T, 3> values(const Conic::Linear& f, const T& s, const Conic::Place<T>& p) {
    const T turn = f.turn.at(s) / p.squared_weight, shadow = 0.5 * turn;
    return {(f.rise.at(s) / p.weight * T(third) + T(f.height->half_at_apex)) * turn,
            shadow * T(f.height->steepness), shadow};
}

template <class T>
std::array<T, 3> values(const Conic::Parabolic& f, const T& s, const Conic::Place<T>& p) {
    const T turn = f.turn.at(s) / p.squared_weight;
    const T s2 = (square(f.x.at(s)) + square(f.y.at(s))) / p.squared_weight;
    const Densities<T> d = below_paraboloid(*f.height, turn, s2);
    return {d.volume, d.area, d.shadow};
}

// The cosine z of the angle to the axis is (a n) / q, and so b = (A a n + B q) / q.
template <class T>
std::array<T, 3> round_values(const Revolved& form, const T& size, const T& determinant, const T& around,
                              const T& near, const T& sum) {
    const T turn = determinant / around, shadow = turn / size;
    const T volume = T(form.volume) * sum / square(near) * turn;
    return {volume, T(form.K2) * revolved_area(form, near / size) * shadow, shadow};
}
template <class T>
std::array<T, 3> values(const Conic::Round& f, const T& s, const Conic::Place<T>& p) {
    auto values = round_values(*f.form, p.size, f.turn.at(s), f.around.at(s), f.near.at(s), f.sum.at(s));
    if (const auto& start = f.from_start) values[2] = (*start)[0].at(s) / ((*start)[1].at(s) * p.size);
    return values;
}
template <class T>
std::array<T, 3> values(const Conic::RoundAlongLine& f, const T& s, const Conic::Place<T>& p) {
    const T along = f.along.at(s), near = f.form->A * along + f.form->B * p.size;
    return round_values(*f.form, p.size, f.turn.at(s), p.size + along, near, f.form->b1 * p.size + near);
}

}  // namespace

template <class T>
std::array<T, 3> densities(const Conic::Integrand& integrand, const T& s, const Conic::Place<T>& p) {
    return std::visit([&](const auto& f) { return values(f, s, p); }, integrand);
}

template std::array<MidRad, 3> densities(const Conic::Integrand&, const MidRad&, const Conic::Place<MidRad>&);
template std::array<Traced, 3> densities(const Conic::Integrand&, const Traced&, const Conic::Place<Traced>&);
template std::array<Approximate, 3> densities(const Conic::Integrand&, const Approximate&,
                                              const Conic::Place<Approximate>&);

}  // namespace vcell::check
