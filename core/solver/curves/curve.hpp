/// Curves: all solutions of N equations in N + 1 unknowns within a box.
///
///     const CurveSystem<1> circle([](const auto& x) {
///         return std::array{square(x[0]) + square(x[1]) - 4.0};
///     });
///     const CurveSet<2> curves = solve_curves<1>(circle, {Interval(-3, 3), Interval(-3, 3)});
///     // one closed component, a chain of tubes; nothing undecided
///
/// The box is subdivided until in each part either an equation excludes zero, or the Jacobian without the
/// column of some coordinate, the *axis*, is regular over a neighbourhood of the part. There f(., t) is
/// injective for every value t of the axis: the solutions form graphs over it, and no loop fits in. The axis
/// is then cut into slices; in each, interval Newton with the axis as a parameter [Neumaier90, sec. 5.1]
/// proves that exactly one solution exists for every t, a *tube*, or that none does. Neighbourhoods overlap,
/// so the end of a chain of tubes, enclosed to rounding, lies in the neighbourhood of the part where the
/// curve goes on, and injectivity there says which tube it is on. So nothing is joined because it is close,
/// nothing is left out, and what cannot be proved is returned as a cluster.
#pragma once

#include <cstdint>
#include <vector>

#include "../systems/curve_system.hpp"

namespace vcell {

struct CurveOptions {
    /// Parts narrower than this fraction of the box in every direction are not divided further.
    double min_width = 0x1p-30;
    /// Bound on the parts looked at, and on the slices divided; the remaining ones become undecided.
    std::size_t max_parts = 200'000;
};

/// For every t between `begin` and `end` the neighbourhood holds exactly one solution with x[axis] = t; it
/// lies within the enclosure. The curve runs from begin to end, which may be the larger one.
template <int D>
struct Tube {
    int axis = 0;
    double begin = 0, end = 0;
    IntervalBox<D> enclosure;
    IntervalBox<D> neighbourhood;

    Interval parameter() const { return begin < end ? Interval(begin, end) : Interval(end, begin); }
};

/// Where an open component ends.
struct CurveEnd {
    enum class Kind {
        Face,     ///< transversally through the face 2 i (lower) or 2 i + 1 (upper) of direction i
        Cluster,  ///< in a cluster
    };
    Kind kind = Kind::Face;
    std::size_t index = 0;  ///< of the face or the cluster
};

/// A connected piece of the solution set, cut at clusters.
template <int D>
struct CurveComponent {
    bool closed = false;
    std::array<CurveEnd, 2> ends;  ///< of an open one: where the first tube begins and the last ends
    std::vector<Tube<D>> tubes;
    /// Certified points, one more than tubes: tube i leads from joints[i] to joints[i + 1]. Each box holds
    /// exactly one point of the curve with the tube's parameter; the last of a closed one is the first again.
    std::vector<IntervalBox<D>> joints;
};

/// A box in which nothing is proved: around a singular point, where the curve touches a face or meets two of
/// them at once, or what a budget left over.
template <int D>
struct CurveCluster {
    IntervalBox<D> box;
    std::vector<std::array<std::size_t, 2>> branches;  ///< (component, which end) that lead in
};

template <int D>
struct CurveSet {
    std::vector<CurveComponent<D>> components;
    std::vector<CurveCluster<D>> undecided;
    std::size_t parts = 0;  ///< looked at during the subdivision

    bool complete() const { return undecided.empty(); }
};

/// All curves of f = 0 in the box. Every solution in the box lies in a tube or in a cluster; different
/// components have no point in common outside the clusters. f is evaluated slightly outside the box too. Pre:
/// the box is bounded and of positive width in every direction. N = 1, 2, 3.
template <int N>
CurveSet<N + 1> solve_curves(const CurveSystem<N>& f, const IntervalBox<N + 1>& box,
                             const CurveOptions& options = {});

/// The tube's point with x[axis] = t, enclosed as tightly as double intervals allow.
/// Pre: tube of a result for f; t in tube.parameter().
template <int N>
IntervalBox<N + 1> point_at(const CurveSystem<N>& f, const Tube<N + 1>& tube, double t);

/// The same in multiprecision: every side narrower than 2^-bits of the tube's neighbourhood, as far as
/// Wide allows.
template <int N>
WideBox<N + 1> point_at(const CurveSystem<N>& f, const Tube<N + 1>& tube, const Wide& t, int bits);

}  // namespace vcell
