/// Which forms compete over a box, and how their heights vary in it.
#pragma once

#include "competition.hpp"

namespace vcell {

/// A form over a box: a support, or value at the middle, gradient and values all over it.
struct Spread {
    FormId form;
    Support support;
    Interval v, gx, gy, range;
    /// Gradient at the middle, second derivatives all over the box, and the box less its middle.
    struct Bend {
        HeightJet<Interval> middle;
        HeightCurvature<Interval> curvature;
        Interval dx, dy;
    };
    std::optional<Bend> bend;
};

/// The gradient of a - b over the box, of which `over` is known, made narrower by second derivatives. Pre:
/// both are bent.
std::array<Interval, 2> bent_gradient(const std::array<Interval, 2>& over, const Spread& a, const Spread& b);

class BoxRivals : CompetitionArgument {
public:
    explicit BoxRivals(Competition& all) : CompetitionArgument(all) {}

    /// The candidates that may be lowest, with a floor show, somewhere in the rectangle.
    std::vector<FormId> cull(const std::array<double, 4>& box, std::span<const FormId> candidates);

    /// How many times more the differences of what the last cull() left, about a box of these sides, change
    /// along x than along y. None where their gradients are not bounded.
    std::optional<double> steepness_across(double along_x, double along_y) const;
    /// Are they few, and do they change many times as much along x as along y, or the other way round? None
    /// if not. Pre: the base is a cylinder.
    std::optional<bool> asks_for_strips(const std::array<double, 4>& box) const;

    /// What the last cull() left; fewer as more is known.
    std::vector<Spread>& spreads() { return spreads_; }
    /// Over the box of the last cull(), if supports compare there; else null.
    const NormalBox* normals() const { return normals_ ? &*normals_ : nullptr; }
    /// Finds second derivatives.
    void bend(const std::array<double, 4>& box);

private:
    bool is_above_twin(FormId f, FormId g, const Interval& X, const Interval& Y) const;
    std::vector<Spread> lowest_spreads(const std::array<double, 4>& box,
                                       std::span<const FormId> candidates) const;

    std::vector<Spread> spreads_;
    std::optional<NormalBox> normals_;
};

}  // namespace vcell
