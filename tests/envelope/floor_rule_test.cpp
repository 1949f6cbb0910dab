// What FloorRule leaves out of straight lines over a stretch, against what shows at points of it.
#include <doctest/doctest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "../../envelope/proofs/floor_rule.hpp"
#include "../test_support.hpp"

namespace vcell::floor_rule_test {

namespace {

// A height over [0, 1], and the values that it has there.
struct Item {
    FormId form;
    double at_0 = 0, at_1 = 0;
    Interval range;

    double at(double s) const { return at_0 + s * (at_1 - at_0); }
};

bool is_above(const Item& a, const Item& b) { return a.at_0 > b.at_0 && a.at_1 > b.at_1; }

struct Heights {
    FormFamily family;
    EnvelopeOptions options;
    std::vector<Item> items;
};

Heights random_heights(std::mt19937_64& rng, std::size_t count) {
    // Floors from far below to far above the others.
    std::uniform_real_distribution<double> value(0, 1), level(-1.2, 1.2), share(0, 1);
    const double floors = share(rng), step = level(rng);
    Heights h;
    h.options.is_below_floor = share(rng) < 0.5;
    for (std::uint32_t i = 0; i < count; ++i) {
        h.family.forms.push_back({});
        const bool is_of_floor = share(rng) < floors;
        if (is_of_floor) h.options.floor.push_back(FormId{i});
        const double up = is_of_floor ? step : 0;
        Item item{FormId{i}, value(rng) + up, value(rng) + up, {}};
        item.range = {std::min(item.at_0, item.at_1), std::max(item.at_0, item.at_1)};
        h.items.push_back(item);
    }
    return h;
}

// By the definition in floor_rule.hpp.
FormId shown(const std::vector<Item>& items, const FloorRule& rule, bool is_below, double s) {
    const Item *least = nullptr, *greatest = nullptr;
    for (const Item& i : items)
        if (rule.is_of_floor(i.form)) {
            if (greatest == nullptr || i.at(s) > greatest->at(s)) greatest = &i;
        } else if (least == nullptr || i.at(s) < least->at(s)) {
            least = &i;
        }
    if (least == nullptr || greatest == nullptr) return (least == nullptr ? greatest : least)->form;
    const bool is_floor_higher = greatest->at(s) > least->at(s);
    return (is_floor_higher != is_below ? greatest : least)->form;
}

}  // namespace

TEST_CASE("floor rule: what is left out shows nowhere, and hides nothing") {
    std::mt19937_64 rng(test_seed());
    std::size_t left_out = 0, all = 0;
    for (int k = 0; k < 400 * rounds(); ++k) {
        const Heights h = random_heights(rng, 2 + static_cast<std::size_t>(k % 40));
        const FloorRule rule(h.family, h.options);
        const auto form = [](const Item& i) { return i.form; };
        const auto range = [](const Item& i) { return i.range; };
        std::vector<Item> in_range = h.items, by_best = h.items, in_pairs = h.items;
        rule.drop_out_of_range(in_range, form);
        rule.drop_hidden(by_best, form, range, is_above);
        rule.drop_hidden(in_pairs, form, is_above);
        all += h.items.size();
        left_out += h.items.size() - by_best.size();
        CHECK(by_best.size() <= in_range.size());
        for (int j = 0; j <= 16; ++j) {
            const double s = j / 16.0;
            const bool is_below = h.options.is_below_floor;
            const FormId truth = shown(h.items, rule, is_below, s);
            for (const std::vector<Item>& left : {in_range, by_best, in_pairs}) {
                REQUIRE(!left.empty());
                CHECK(shown(left, rule, is_below, s) == truth);
            }
        }
    }
    CHECK(2 * left_out > all);
}

}  // namespace vcell::floor_rule_test
