/// What the steps of solve_curves() hand to each other: parts of the domain, the regular ones among them,
/// slices of their curves, and runs of slices.
#pragma once

#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "../newton/curve_newton.hpp"
#include "curve.hpp"

namespace vcell::curve {

// Boxes and slices are cut off the middle, so that curves of symmetric systems do not run along the cuts.
inline constexpr double cut = 0.47;
// The neighbourhood of a part reaches beyond it by this fraction of its widest side. It decides how far
// neighbours overlap, that is, how fine the slices near a part's sides become, and nothing else.
inline constexpr double margin = 0.0625;

inline double length(const Interval& i) { return i.upper() - i.lower(); }

template <int N>
struct CurveWork {
    static constexpr int D = N + 1;
    static constexpr std::size_t none = SIZE_MAX;
    using Box = IntervalBox<D>;

    // A regular part.
    struct Leaf {
        Box part;           // contracted: holds all solutions of its part of the domain
        Box neighbourhood;  // f is injective in it for every value of the axis
        int axis;
        int direction;  // of the axis along the orientation of the curve: 1 or -1
        std::size_t first_run = 0, last_run = 0;
    };
    struct Part {
        Box box;
        Box neighbourhoods;  // hull of those of the leaves below
        std::size_t first_child = 0;
        int children = 0;
        std::size_t leaf = none;
        bool occupied = false;  // has it leaves below?
    };
    // One solution for every parameter.
    struct Slice {
        double begin, end;
        Box enclosure;
    };
    // Where a run stops.
    struct Stop {
        enum Kind { Open, Face, Undecided } kind = Open;
        std::size_t index = 0;  // of the face or the undecided box
        Box point = {};         // of a face
    };
    // Adjoining slices of a leaf, upwards.
    struct Run {
        std::size_t leaf;
        std::size_t first, last;  // slices [first, last)
        double begin, end;
        Stop low, high;
        std::size_t component = none;
    };

    CurveWork(const CurveSystem<N>& f, const Box& domain, const CurveOptions& options)
        : f(f), domain(domain), options(options) {
        for (int i = 0; i < D; ++i) {
            unit[i] = length(domain[i]);
            assert(unit[i] > 0 && std::isfinite(unit[i]));
        }
    }

    const CurveSystem<N>& f;
    const Box domain;
    const CurveOptions options;
    std::array<double, D> unit;

    std::vector<Part> parts;
    std::vector<Leaf> leaves;
    std::vector<Slice> slices;
    std::vector<Run> runs;
    std::vector<Box> undecided;
};

/// The curve's point in a slice at a parameter.
template <int N>
IntervalBox<N + 1> point_of(const CurveSystem<N>& f, const typename CurveWork<N>::Leaf& leaf,
                            const typename CurveWork<N>::Slice& slice, double t) {
    return narrowed(f, slice.enclosure, leaf.axis, Interval(t));
}

}  // namespace vcell::curve
