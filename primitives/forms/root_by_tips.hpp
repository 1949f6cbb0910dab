/// The root of a tube's height next to tips of its bisector.
#pragma once

#include <array>
#include <optional>

#include "radial_normals.hpp"

namespace vcell {

/// The root R of tubes next to tips of their bisectors, where B^2 and A^2 C all but cancel. With w the tube's
/// axis, m the way from it to the foot, across it, U = u - (u.w) w what of u is across it, delta as
/// radial_base.hpp has it, and lengths such that w is unit,
///
///     N = m - delta U,   G = w.(m x u),
///     R^2 = |N|^2 - G^2 = ((N.U)^2 + (u.w)^2 G^2) / (1 - (u.w)^2):
///
/// all of these are linear in u and along a base cylinder's axis, but N.U, and N and G vanish in tips alone.
template <class T>
class RootByTips {
public:
    RootByTips() = default;
    /// The numbers of a form that has a root, and is no cone's. `around`: over a cylinder, the unit of y.
    RootByTips(const std::array<T, 3>& c, const T& b0, const T& slope, const std::array<T, 3>& b,
               const std::array<T, 3>& a, bool is_hollow, std::optional<double> around);

    /// Over the normals, of which these are |B| and A^2.
    T operator()(const RadialNormals<T>& n, const T& B, const T& A2) const;

private:
    std::array<std::array<T, 3>, 2> m_, g_;  ///< along the base's axis: at 0, and what they grow by
    std::array<std::array<T, 3>, 3> of_u_;
    T minus_delta_, square_;
};

extern template class RootByTips<Interval>;
extern template class RootByTips<Wide>;

}  // namespace vcell
