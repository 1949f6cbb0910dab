// Ties of what was given where the base was turned: forms are a little beside it there, and tie no more.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "piece_argument.hpp"
#include "space_tie.hpp"

namespace vcell {

// A place of the piece in which forms tie but for noise.
struct NoisyTie {
    Vector2d point;
    double error;  // within which it is one of what was given
    std::vector<FormId> forms;
    std::vector<std::array<FormId, 2>> touching{};  // their gradients agree
    std::vector<std::array<FormId, 3>> in_line{};   // these are on one line
};

class GivenTie : PieceArgument {
public:
    GivenTie(Competition& all, PieceWork& work, const NoisyTie& tie);

    // Do the forms tie there exactly, as they were given, and touch as the tie has them? three: some of them
    // that are equal in one point of the piece, if there are such.
    bool is_exact(const std::optional<std::array<FormId, 3>>& three = {}) const;

private:
    using Quadric = space_quadrics::Quadric;
    const Quadric& equation(FormId f) const;
    bool follow_from(const std::array<FormId, 3>& three) const;
    bool is_at(const SpacePoint& p) const;
    bool touch_at(const SpacePoint& p) const;

    struct Given {
        FormId form;
        Quadric equation;
    };
    const NoisyTie tie_;
    std::vector<Given> given_;  // fewer than the forms where one has no equation, or nothing was turned
};

}  // namespace vcell
