/// Points in which three forms or more are equal, with many digits and exactly: where they are, and what else
/// is equal there.
#pragma once

#include <optional>
#include <span>

#include "competition.hpp"
#include "mixed_piece.hpp"
#include "space_tie.hpp"

namespace vcell {

class CommonPoints : CompetitionArgument {
public:
    explicit CommonPoints(Competition& all) : CompetitionArgument(all) {}

    std::optional<std::array<Wide, 2>> sharp_critical_point(FormId f, FormId g,
                                                            const Eigen::Vector2d& start) const;
    std::optional<std::array<Wide, 2>> sharp_vertex(const MixedPiece::Vertex& v,
                                                    const std::array<FormId, 3>& forms, int exponent = -240);
    bool settle_sharply(MixedPiece::Vertex& v, const std::array<FormId, 3>& forms);
    std::optional<RationalPoint> exact_tie(std::span<const FormId> forms, const Wide& x, const Wide& y);
    std::optional<SpacePoint> exact_tie_in_space(std::span<const FormId> forms,
                                                 const std::array<Wide, 2>& at) const;
    bool settle_tie(MixedPiece::Vertex& v, const std::array<FormId, 3>& forms);
    std::optional<IntervalPoint> exact_touch(std::span<const FormId> touching, std::span<const FormId> ties,
                                             const std::array<Wide, 2>& at, const std::array<double, 4>& box);
    std::optional<Sign> sign_at_vertex(const MixedPiece::Vertex& v, std::array<FormId, 3> forms,
                                       FormId other);
    std::optional<double> ties_in_noise(const MixedPiece::Vertex& v, const std::array<FormId, 3>& forms,
                                        FormId other);
};

}  // namespace vcell
