/// How near the bisectors around a base come to its centre or axis, and how far from it they reach.
#pragma once

#include <array>
#include <limits>

#include "../../primitives/bases/axial_terms.hpp"
#include "../../primitives/bases/radial_base.hpp"
#include "../cell.hpp"

namespace vcell {

class RadialDistances {
public:
    /// A range that edges or points of the cell have, known within an error.
    void add(double low, double high, double error);
    void add(const RadialDistances& other);
    /// Where a form's bisector is nearest and farthest, if the cell is there; `least`: its least distance.
    void add_bisector(const RadialBaseProblem& problem, FormId form, double least);
    /// A tip of the bisector with an object, within its face.
    void add_tip(const BisectorTip& tip, const Object& object);

    /// The clearances that a base of that radius has, with their errors.
    void set_clearances(double radius, Measures& measures) const;

private:
    void add_nearest(const RadialBaseProblem& problem, FormId form, double least);
    void add_farthest(const RadialBaseProblem& problem, FormId form);

    std::array<double, 2> known_{std::numeric_limits<double>::infinity(), 0};
    std::array<double, 2> least_{known_[0], known_[0]}, greatest_{0, 0};  // bounds of both
};

}  // namespace vcell
