// Where all rivals of a small piece tie.
#pragma once

#include "piece_argument.hpp"
#include "tie_fan.hpp"

namespace vcell {

// A point in which all rivals tie.
struct Apex {
    Vector2d point;
    double error;
    std::optional<std::uint32_t> rim;  // the vertex of the rim that it is
    std::vector<std::vector<TiedDifference>> differences;
    std::vector<TiedBetween> between;
    double noise;  // nearer than this they tie only up to noise
    bool decided;  // that all tie: by exact arithmetic, or when the rim was labelled
};

class ApexFinder : PieceArgument {
public:
    ApexFinder(Competition& all, PieceWork& work) : PieceArgument(all, work) {}

    std::optional<Apex> find();
    // Three rivals that are certainly equal in no more than one point of the piece.
    std::optional<std::array<FormId, 3>> triple_in_one_point() const;

private:
    std::optional<Apex> find_in_line(Apex apex);
    std::optional<Apex> find_touching_in_noise(Apex apex,
                                               std::span<const std::array<std::size_t, 2>> touching,
                                               std::span<const HeightJet<Wide>> jets) const;
    bool can_be_told(const Apex& apex) const;
    void find_between(Apex& apex, int exponent);
    // at: about the apex, with many digits.
    bool is_tie_in_space(const Apex& apex, std::span<const std::array<std::size_t, 2>> touching,
                         const std::array<Wide, 2>& at) const;
    bool is_tie_of_planes(const Apex& apex) const;
};

}  // namespace vcell
