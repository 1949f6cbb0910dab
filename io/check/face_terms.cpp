#include "face_terms.hpp"

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

/// Below 1/4 by the series 1 + x^2 / 3 + x^4 / 5 + ..., of which the rest is less than 2^-58: terms are positive, and
/// Horner's rule is off by less than 2^-48 of their sum.
Approximate artanh_ratio(const Approximate& x) {
    if (abs(x).greatest() < 0.25) {
        constexpr int terms = 14;
        const Approximate square_of_x = square(x);
        Approximate sum = 1.0 / (2 * terms - 1);
        for (int k = terms - 2; k >= 0; --k) sum = sum * square_of_x + 1.0 / (2 * k + 1);
        return sum;
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

}  // namespace vcell::check
