// Fits on several threads come to what they come to one after the other, whatever is left of what they may
// cost.
#include "../../envelope/lift/fit_all.hpp"

#include <doctest/doctest.h>

#include <random>
#include <vector>

#include "../test_support.hpp"

using namespace vcell;

namespace {

// What a fit that wants so much gets, as fits do: one at a time, and nothing once there is none.
struct Outcome {
    std::size_t spans = 0, cells = 0;
    bool is_cut_short = false;

    friend bool operator==(const Outcome&, const Outcome&) = default;
};

std::size_t take(std::size_t wanted, std::size_t& left) {
    const std::size_t taken = std::min(wanted, left);
    left -= taken;
    return taken;
}

struct Fits {
    std::vector<Outcome> outcomes;
    FitEffort left;
};

Fits fitted(const std::vector<FitEffort>& wanted, FitEffort left, unsigned threads) {
    Fits fits{std::vector<Outcome>(wanted.size()), left};
    fit_all(wanted.size(), fits.left, threads, [&](std::size_t i, FitEffort& effort) {
        Outcome& outcome = fits.outcomes[i] = {};
        outcome.spans = take(wanted[i].spans, effort.spans);
        outcome.cells = take(wanted[i].cells, effort.cells);
        outcome.is_cut_short = effort.spans == 0 || effort.cells == 0;
    });
    return fits;
}

}  // namespace

TEST_CASE("fit_all: fits that share an effort come out as one after the other") {
    std::mt19937_64 rng(test_seed());
    std::size_t short_of_spans = 0, hard = 0;
    for (int round = 0; round < 50 * rounds(); ++round) {
        std::uniform_int_distribution<std::size_t> many(0, 40), usual(0, 60), much(0, 3000), all(0, 12000);
        std::vector<FitEffort> wanted(many(rng));
        for (FitEffort& w : wanted) {
            const bool is_hard = usual(rng) < 6;
            hard += is_hard;
            w = {is_hard ? much(rng) : usual(rng), is_hard ? 4 * much(rng) : usual(rng)};
        }
        const FitEffort left{all(rng), 4 * all(rng)};
        const Fits alone = fitted(wanted, left, 1);
        for (const unsigned threads : {2u, 3u}) {
            const Fits together = fitted(wanted, left, threads);
            CHECK(together.outcomes == alone.outcomes);
            CHECK(together.left.spans == alone.left.spans);
            CHECK(together.left.cells == alone.left.cells);
        }
        for (const Outcome& o : alone.outcomes) short_of_spans += o.is_cut_short;
    }
    CHECK(short_of_spans > 0);
    CHECK(hard > 0);
}
