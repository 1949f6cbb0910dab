/// Trimming curves: lifted to their patch they run along their edges at the same parameters.
#pragma once

#include "nets.hpp"
#include "room.hpp"

namespace vcell::check {

struct TrimPlace {
    std::size_t loop, curve;
};

/// How far the lifted curve is from its edge at most, where that is within what the edge's error allows;
/// otherwise the certificate says what is wrong, and the bound is infinite. `net`: the patch over the
/// rectangle of its loops. What is less than `negligible` need not be told better.
double certify_trim(const Patch& patch, const Net& net, const TrimPlace& place, const Subject& subject,
                    const CheckOptions& options, Certificate& certificate, double negligible = 0);

}  // namespace vcell::check
