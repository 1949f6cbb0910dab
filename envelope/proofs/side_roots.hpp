/// Where two forms are equal along a side: the one root of their difference between two places.
#pragma once

#include "competition.hpp"
#include "side_line.hpp"

namespace vcell {

class SideRoots : CompetitionArgument {
public:
    explicit SideRoots(Competition& all) : CompetitionArgument(all) {}

    /// The one root of the two forms' difference between s0 and s1, where its slope is `least_slope` at
    /// least.
    RimTransition locate(const SideLine& line, double s0, double s1, FormId before, FormId after,
                         double least_slope);

private:
    struct Guess {
        double s, slope;
    };
    RimTransition locate_rise(const SideLine& line, double s0, double s1, FormId before, FormId after,
                              double least_slope);
    Guess approximate_root(const SideLine& line, double s0, double s1, FormId before, FormId after) const;
};

}  // namespace vcell
