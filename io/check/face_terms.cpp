#include "face_terms.hpp"

#include <algorithm>
#include <cmath>

namespace vcell::check {

MidRad artanh_ratio(const MidRad& x) {
    const MidRad square_of_x = square(x);
    const double most = square_of_x.magnitude();
    if (most < 0.0625) {
        static const std::array<MidRad, 14> terms = [] {
            std::array<MidRad, 14> t;
            for (std::size_t k = 0; k < t.size(); ++k)
                t[k] = MidRad(1.0) / MidRad(static_cast<double>(2 * k + 1));
            return t;
        }();
        const std::size_t count = most < 0x1p-16 ? 4 : most < 0x1p-8 ? 7 : terms.size();
        MidRad sum = terms[count - 1];
        for (std::size_t k = count - 1; k-- > 0;) sum = sum * square_of_x + terms[k];
        // The terms that are left out: less than a geometric series, which begins below 2^-56.
        sum += MidRad::ball(0, 0x1p-55 / static_cast<double>(2 * count + 1));
        return sum;
    }
    const Interval y = square(x.enclosure());
    if (!(y.upper() < 1)) return MidRad::whole();
    // glibc's manual states errors of up to 3 units in the last place.
    const double lo = std::sqrt(y.lower()), hi = std::sqrt(y.upper());
    const Interval a(lo * (1 - 0x1p-50), lo * (1 + 0x1p-50)), b(hi * (1 - 0x1p-50), hi * (1 + 0x1p-50));
    const auto value = [](double t) { return Interval::ball(std::atanh(t), 0x1p-50 * std::atanh(t)); };
    if (!(b.upper() < 1)) return MidRad::whole();
    // It grows with |x|.
    const Interval least = value(a.lower()) / Interval(a.lower()),
                   greatest = value(b.upper()) / Interval(b.upper());
    return Interval(std::max(1.0, least.lower()), greatest.upper());
}

// It falls with |x|. glibc's manual states errors of up to a unit in the last place.
MidRad arctan_ratio(const MidRad& square_of_x) {
    const Interval y = square_of_x.enclosure();
    const double lo = std::sqrt(std::max(0.0, y.lower())) * (1 - 0x1p-50),
                 hi = std::sqrt(std::max(0.0, y.upper())) * (1 + 0x1p-50);
    if (!(hi < HUGE_VAL)) return Interval(0.0, 1.0);
    // The quotient loses digits for small x, and the series 1 - x^2 / 3 + ... does not.
    constexpr double small = 0x1p-13;
    const auto ratio = [](double x) {
        return x < small ? Interval(1 - x * x / 3) + Interval::ball(0, 0x1p-50)
                         : Interval::ball(std::atan(x), 0x1p-50 * std::atan(x)) / Interval(x);
    };
    return Interval(ratio(hi).lower(), std::min(1.0, ratio(lo).upper()));
}
Approximate arctan_ratio(const Approximate& square_of_x) {
    return Approximate::of([&](std::size_t k) {
        const double x = std::sqrt(std::max(0.0, square_of_x[k]));
        return x < 0x1p-13 ? 1 - square_of_x[k] / 3 : std::atan(x) / x;
    });
}

namespace {

/// 1 + x^2 / 3 + x^4 / 5 + ... of so many terms.
template <int Terms>
Approximate artanh_series(const Approximate& square_of_x) {
    Approximate sum = 1.0 / (2 * Terms - 1);
    for (int k = Terms - 2; k >= 0; --k) sum = sum * square_of_x + 1.0 / (2 * k + 1);
    return sum;
}

}  // namespace

/// Below 1/4 by the series, of which the rest is less than 2^-58. By Horner's rule the k-th term, which is
/// below 16^-k / (2 k + 1), goes through 2 k + 2 roundings: all of them are less than four of the sum.
///
/// Beyond, with r = sqrt(1 - x^2), artanh(x) = 2 artanh(y) for y = x / (1 + r). Below 3/4, 1 - x^2 is off by
/// less than 2.5 roundings, r by 2.3 and 1 + r by two, y by three and with it artanh(y) / y by one: each of
/// two steps at most adds seven roundings.
Approximate artanh_ratio(const Approximate& x) {
    const double most = abs(x).greatest();
    if (most < 0x1p-8) return artanh_series<4>(square(x));
    if (most < 0.0625) return artanh_series<8>(square(x));
    if (most < 0.25) return artanh_series<14>(square(x));
    if (most < 0.75) {
        const Approximate sum = 1.0 + sqrt(1.0 - square(x));
        return 2.0 / sum * artanh_ratio(x / sum);
    }
    return Approximate::of([&](std::size_t k) {
        return std::abs(x[k]) < 0x1p-13 ? 1 + x[k] * x[k] / 3 : std::atanh(x[k]) / x[k];
    });
}
/// In |x| <= m the series 1 + x^2 / 3 + x^4 / 5 + ... is no farther from 1 than m^2 / (3 (1 - m^2)), and its
/// derivative below 1 / (1 - m^2). Below 2^-13 its third term is less than 2^-54.
Traced artanh_ratio(const Traced& x) {
    const double most = x.magnitude() + x.error();
    if (!(most < 1 - 0x1p-20)) return Traced::whole();
    const double rest = 1 - most * most, reach = (most * most / (3 * rest)) * (1 + 0x1p-30);
    return {Disc(1, reach), (x.error() / rest) * (1 + 0x1p-30) + 0x1p-48 * (1 + reach)};
}

namespace {

/// A positive number's bounds, and how far its computed value may be off, relative to it.
struct Computed {
    double least, most, error;
};

}  // namespace

// To first order in relative errors, of which each is below 2^-12 and no term has more than sixteen factors:
// what that leaves out is less than a hundredth, and so is what the bounds themselves lose to rounding. B
// counts relative to its largest magnitude, and terms that may cancel by their magnitudes.
double error_of_antiderivative(const Revolved& r, const Disc& range, double error) {
    constexpr double u = 0x1p-53, up = 1 + 0x1p-40, down = 1 - 0x1p-40, first_order = 1.02,
                     most_relative = 0x1p-12;
    const double reach = (range.radius() + error) * up, low = (range.center() - reach) * down,
                 high = (range.center() + reach) * up;
    const double b1 = r.b1.mid(), B = r.B.mid(), E = r.E.mid(), beta = r.B.magnitude();
    if (!(low > 0) || !(b1 > 0) || !(r.is_paraboloid || E > 0)) return HUGE_VAL;
    const double off_b = error / low, off_1 = r.b1.radius() / b1 * up,
                 off_B = beta > 0 ? r.B.radius() / beta : 0, off_place = std::max(off_b, off_1);
    const double product = low * b1;
    if (r.is_paraboloid) {
        const double relative = off_B + 6 * off_place + 32 * u;
        if (!(relative < most_relative)) return HUGE_VAL;
        const double root = std::sqrt(product), value = std::sqrt(2 * beta) *
                                                        (high + b1 + std::sqrt(high * b1)) /
                                                        ((std::sqrt(low) + std::sqrt(b1)) * root * product);
        return relative * value * first_order;
    }
    const double off_E = r.E.radius() / E;
    // sqrt(E + 2 B b) between two b.
    const auto root = [&](double from, double to, double off) -> Computed {
        const double size = E + 2 * beta * to,
                     lost = r.E.radius() + 2 * to * (beta * off + r.B.radius()) + 6 * u * size,
                     first = E + 2 * B * from, last = E + 2 * B * to;
        const double least = std::min(first, last) - lost, most = std::max(first, last) + lost;
        if (!(least > 0)) return {0, HUGE_VAL, HUGE_VAL};
        return {std::sqrt(least), std::sqrt(most), 0.51 * lost / least + 2 * u};
    };
    const Computed s = root(low, high, off_b), s1 = root(b1 * down, b1 * up, off_1);
    const double off_sum = std::max(s.error, s1.error) + u, sum = s.least + s1.least;
    if (!(off_sum < most_relative) || !(off_place < most_relative)) return HUGE_VAL;

    const double a = s.most * (high + b1), c = 2 * beta * high * high / sum, squared = 2 * product * product;
    const double first = (a + c) / squared;
    double total = (a * (s.error + off_place + 3 * u) + c * (off_B + 2 * off_b + off_sum + 5 * u)) / squared +
                   first * (2 * (off_b + off_1) + 6 * u);
    if (r.B.magnitude() == 0) return total * first_order;

    const double d = 2 * beta * high / sum, half = beta / (2 * E * product), second = half * (s.most + d);
    total += half * (s.most * s.error + d * (off_B + off_b + off_sum + 4 * u)) +
             second * (off_B + off_E + off_b + off_1 + 8 * u);

    // The ratio's denominator is linear in b.
    const auto denominator = [&](double b) { return E * (b + b1) + 2 * B * b * b1; };
    const double even = E * (high + b1), odd = 2 * beta * high * b1;
    const double lost = even * (off_E + off_place + 4 * u) + odd * (off_B + off_b + off_1 + 5 * u);
    const double least = std::min(denominator(low), denominator(high)) - 2 * lost;
    if (!(least > 0)) return HUGE_VAL;
    const double ratio = (s.most * s1.most + E) / (sum * least),
                 off_ratio = std::max(s.error + s1.error + u, off_E) + off_sum + lost / least + 4 * u;
    const double apart = std::max(std::abs(b1 - low), std::abs(high - b1)) + r.b1.radius(),
                 size = std::sqrt(E) * ratio;
    const double x_error = size * (error + r.b1.radius() + apart * (off_E + off_ratio + 6 * u)) * first_order;
    const double x = size * apart * up + x_error;
    if (!(off_ratio < most_relative) || !(off_E < most_relative) || !(off_B < most_relative) ||
        !(x < 1 - 0x1p-20))
        return HUGE_VAL;
    const double rest = 1 - x * x, artanh = 1 + x * x / (3 * rest);
    const double factor = beta * beta / E * ratio, third = factor * artanh;
    total += third * (2 * off_B + off_E + off_ratio + 0x1p-48 + 8 * u) + factor * x_error / rest;
    return (total + 3 * u * (first + second + third)) * first_order;
}

}  // namespace vcell::check
