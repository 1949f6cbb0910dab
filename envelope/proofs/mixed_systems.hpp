// The equations whose roots pieces ask for: three heights that are equal, two that have equal gradients.
#pragma once

#include <optional>
#include <utility>

#include "../../core/solver/newton/newton.hpp"
#include "mixed_terms.hpp"

namespace vcell {

template <class T, class Linearise>
auto model_of(Linearise linearise) {
    return LinearisedModel<T, 2, Linearise>(std::move(linearise));
}

inline const IntervalBox<2> everywhere{Interval::whole(), Interval::whole()};

struct ProvedRoot {
    Eigen::Vector2d point;
    double error;
};

inline ProvedRoot about(const IntervalBox<2>& box) {
    return {{box[0].mid(), box[1].mid()}, reach(box[0], box[1])};
}

/// Newton's method is not followed out of `within`.
template <class Model>
std::optional<ProvedRoot> root_near(const Model& model, const Eigen::Vector2d& start,
                                    const IntervalBox<2>& within = everywhere) {
    const auto box = prove_near<Interval, 2>(model, {Interval(start.x()), Interval(start.y())}, within);
    return box ? std::optional(about(*box)) : std::nullopt;
}

// a = b = c.
template <class T>
LocalModel<T, 2> equal_heights(const Heights& heights, const std::array<FormId, 3>& forms,
                               const std::array<T, 2>& p) {
    // A difference of twins is to be one of the two.
    if (heights.are_twins(forms[1], forms[2]) && !heights.are_twins(forms[0], forms[1]))
        return equal_heights(heights, {forms[1], forms[2], forms[0]}, p);
    const HeightJet<T> b = heights.difference(forms[0], forms[1], p[0], p[1]),
                       c = heights.difference(forms[0], forms[2], p[0], p[1]);
    return {{b.v, c.v}, {{{b.gx, b.gy}, {c.gx, c.gy}}}};
}

// The same in doubles; over a point derivatives are rounded only.
inline LocalModel<Interval, 2> equal_heights(const SphereSupports& supports,
                                             const std::array<FormId, 3>& forms, const IntervalBox<2>& p) {
    LocalModel<Interval, 2> s;
    if (is_point(p[0]) && is_point(p[1])) {
        const PointNormal n(p[0].mid(), p[1].mid());
        const auto a = supports.jet(forms[0], n);
        for (const int i : {0, 1}) {
            const auto b = supports.jet(forms[i + 1], n);
            s.value[i] = Interval::ball(
                a[0] - b[0], supports.value_error(forms[0], n) + supports.value_error(forms[i + 1], n));
            s.jacobian[i] = {Interval(a[1] - b[1]), Interval(a[2] - b[2])};
        }
        return s;
    }
    s.value.fill(Interval::whole());
    const NormalBox box(p[0].lower(), p[0].upper(), p[1].lower(), p[1].upper());
    const Support a = supports.over(forms[0], box);
    for (const int i : {0, 1}) s.jacobian[i] = box.gradient(a, supports.over(forms[i + 1], box));
    return s;
}

// grad f = grad g.
inline LocalModel<Interval, 2> equal_gradients(const Heights& heights, FormId f, FormId g,
                                               const IntervalBox<2>& p) {
    const HeightJet<Interval> d = heights.difference(f, g, p[0], p[1]);
    const HeightCurvature<Interval> c = heights.curvature_difference(f, g, p[0], p[1]);
    return {{d.gx, d.gy}, {{{c.xx, c.xy}, {c.xy, c.yy}}}};
}

// The same with many digits, and derivatives in doubles: to approach a root, not to prove it.
inline LocalModel<Wide, 2> equal_gradients(const Heights& heights, FormId f, FormId g, const WideBox<2>& p) {
    const HeightJet<Wide> a = heights.jet(f, p[0], p[1]), b = heights.jet(g, p[0], p[1]);
    const auto rough = equal_gradients(
        heights, f, g, IntervalBox<2>{Interval(p[0].approximation()), Interval(p[1].approximation())});
    LocalModel<Wide, 2> local{{a.gx - b.gx, a.gy - b.gy}, {}};
    for (const int r : {0, 1})
        for (const int c : {0, 1}) local.jacobian[r][c] = Wide(rough.jacobian[r][c].mid());
    return local;
}

inline auto equal_gradients(const Heights& heights, FormId f, FormId g) {
    return model_of<Interval>(
        [&heights, f, g](const IntervalBox<2>& p) { return equal_gradients(heights, f, g, p); });
}

}  // namespace vcell
