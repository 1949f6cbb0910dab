#include "root_by_tips.hpp"

#include <algorithm>

namespace vcell {

namespace {

template <class T>
T root_of(const T& squared) {
    return squared.upper() > 0 ? sqrt(squared) : T(0.0, 0.0);
}

}  // namespace

template <class T>
RootByTips<T>::RootByTips(const std::array<T, 3>& c, const T& b0, const T& slope, const std::array<T, 3>& b,
                          const std::array<T, 3>& a, bool is_hollow, std::optional<double> around) {
    const T sign(is_hollow ? 1.0 : -1.0), zero(0.0);
    std::array<T, 3> w = a;
    for (int i = 0; i < 3; ++i) m_[0][i] = sign * b[i];
    m_[1] = {zero, zero, zero};
    if (around) {
        const T minus_sign = -sign, of_y = minus_sign / T(*around);
        w[1] = of_y * slope;
        m_[0][1] = 0.5 * of_y * c[1];
        m_[1] = {sign * slope * a[0], of_y * c[2], sign * slope * a[2]};
    }
    minus_delta_ = sign * b0;
    square_ = square(w[0]) + square(w[1]) + square(w[2]);
    for (int i = 0; i < 3; ++i) {
        const T share = minus_delta_ * w[i] / square_;
        for (int k = 0; k < 3; ++k) of_u_[i][k] = -(share * a[k]);
        of_u_[i][i] += minus_delta_;
    }
    for (const int i : {0, 1})
        g_[i] = {w[1] * m_[i][2] - w[2] * m_[i][1], w[2] * m_[i][0] - w[0] * m_[i][2],
                 w[0] * m_[i][1] - w[1] * m_[i][0]};
}

template <class T>
T RootByTips<T>::operator()(const RadialNormals<T>& n, const T& B, const T& A2) const {
    const T &y = n.y(), &middle = n.middle_y(), along2 = A2 / square_;
    std::array<T, 3> at_middle;
    for (int i = 0; i < 3; ++i) at_middle[i] = g_[0][i] + middle * g_[1][i];
    const T G2 =
        square(n.template along<0>(at_middle).v + (y - middle) * n.template along<0>(g_[1]).v) / square_;
    T N2(0.0);
    for (int i = 0; i < 3; ++i) N2 += square(n.template along<0>(of_u_[i]).v + m_[0][i] + y * m_[1][i]);
    const T by_length = root_of(N2 - G2), rest = T(1.0) - along2;
    // Both forms are right; which one is sharper changes where the ray has this square of its sine to the
    // axis, and next to the axis itself the other form tells nothing.
    constexpr double least_sine2 = 0.125;
    if (!(rest.lower() > least_sine2)) return by_length;
    const T by_parts = root_of((square(B - minus_delta_ * along2) + along2 * G2) / rest);
    return {std::max(by_length.lower(), by_parts.lower()), std::min(by_length.upper(), by_parts.upper())};
}

template class RootByTips<Interval>;
template class RootByTips<Wide>;

}  // namespace vcell
