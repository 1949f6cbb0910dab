/// Where forms change along a side closer than stretches of it can be told apart: the order of their
/// crossings, and the one point in which all of them tie.
#pragma once

#include "common_points.hpp"
#include "side_line.hpp"

namespace vcell {

class SideCrossings : CompetitionArgument {
public:
    explicit SideCrossings(Competition& all) : CompetitionArgument(all), points_(all) {}

    /// The changes between s0, where l0 is lowest, and s1, where l1 is.
    std::optional<std::vector<RimTransition>> order(const SideLine& line, double s0, FormId l0, double s1,
                                                    FormId l1, std::span<const FormId> forms);
    /// The one change, with what ties there.
    std::optional<RimTransition> find_tie(const SideLine& line, double s0, FormId l0, double s1, FormId l1,
                                          std::span<const FormId> forms);

private:
    CommonPoints points_;
};

}  // namespace vcell
