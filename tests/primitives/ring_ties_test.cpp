// Ties all along rings around a cylinder, against quadratics of small integers compared one by one.
#include <doctest/doctest.h>

#include <algorithm>
#include <numeric>
#include <random>
#include <vector>

#include "../../primitives/forms/ring_ties.hpp"
#include "../test_support.hpp"

namespace vcell::ring_ties_test {

// k (x, z, w) and a C whose values are k times those of h: what is nearest has the least h.
RadialForm form(int k, std::array<int, 3> direction, std::array<double, 3> h) {
    RadialForm f{};
    for (int i = 0; i < 3; ++i) f.c[i] = k * h[i];
    f.b = {Exact(k * direction[0]), Exact(), Exact(k * direction[1])};
    f.b0 = k * direction[2];
    return f;
}

// Places are multiples of an eighth, so that doubles are exact.
double at(const std::array<double, 3>& h, double y) { return h[0] + y * (h[1] + y * h[2]); }

TEST_CASE("ring ties: of balls in a row the middle one gives way, up to where it is nearest again") {
    const std::vector<RadialForm> forms{form(1, {1, 0, 0}, {2, 2, 1}), form(2, {1, 0, 0}, {2, 0, 0.5}),
                                        form(1, {1, 0, 0}, {2, -2, 1})};
    const auto ties = find_ring_ties(forms, -3, 3);
    REQUIRE(ties.size() == 1);
    CHECK(ties[0].form == 1);
    CHECK(ties[0].before == 0);
    CHECK(ties[0].after == 2);
    CHECK(ties[0].y.contains(0));
    CHECK_FALSE(ties[0].end);
    CHECK_FALSE(ties[0].elsewhere);
    CHECK(ties[0].from > -4);
    CHECK(ties[0].to < 4);
    CHECK(ties[0].from < -4 + 1e-12);
    CHECK(ties[0].to > 4 - 1e-12);
    // One of them in another plane, or on the other side of the axis.
    for (const std::array<int, 3> direction : {std::array{1, 1, 0}, {-1, 0, 0}, {1, 0, 1}}) {
        std::vector<RadialForm> others = forms;
        others[2] = form(1, direction, {2, -2, 1});
        CHECK(find_ring_ties(others, -3, 3).empty());
    }
    // The middle one an ulp farther, or nearer.
    for (const double h : {std::nextafter(2.0, 3.0), std::nextafter(2.0, 1.0)}) {
        std::vector<RadialForm> others = forms;
        others[1] = form(2, {1, 0, 0}, {h, 0, 0.5});
        CHECK(find_ring_ties(others, -3, 3).empty());
    }
}

TEST_CASE("ring ties: a ring of no fraction, and one that touches") {
    // All are equal where y^2 = 2.
    const std::vector<RadialForm> forms{form(3, {0, 2, 1}, {2, 0, 1}), form(1, {0, 2, 1}, {3, 0, 0.5}),
                                        form(2, {0, 2, 1}, {4, 0, 0})};
    const auto ties = find_ring_ties(forms, -3, 3);
    REQUIRE(ties.size() == 2);
    for (const RingTie& tie : ties) {
        CHECK(tie.form == 1);
        CHECK(tie.before == (tie.y.mid() > 0 ? 0 : 2));
        CHECK(tie.after == (tie.y.mid() > 0 ? 2 : 0));
        CHECK(tie.y.width() < 1e-14);
        CHECK(square(tie.y).contains(2));
        REQUIRE(tie.elsewhere);
        CHECK(tie.elsewhere->contains(-tie.y.mid()));
    }
    const auto touching =
        find_ring_ties(std::vector{form(1, {1, 2, 0}, {1, 0, 0.5}), form(1, {1, 2, 0}, {2, -2, 1.5})}, -3, 3);
    REQUIRE(touching.size() == 1);
    CHECK(touching[0].form == 1);
    CHECK(touching[0].before == 0);
    CHECK(touching[0].after == 0);
    CHECK(touching[0].y.contains(1));
    CHECK(touching[0].from < -3);
    CHECK(touching[0].to > 3);
}

TEST_CASE("ring ties: random rows, each place compared with all others") {
    std::mt19937_64 rng(test_seed());
    const auto number = [&](int low, int high) { return std::uniform_int_distribution(low, high)(rng); };
    constexpr double y0 = -4, y1 = 4, step = 0.125;
    std::size_t inner = 0, at_ends = 0;
    for (int round = 0; round < 300 * rounds(); ++round) {
        struct Item {
            int row;
            std::array<double, 3> h;
        };
        const std::array<std::array<int, 3>, 2> rows{
            {{number(1, 3), number(-3, 3), number(-2, 2)}, {0, 1, 5}}};
        std::vector<Item> items;
        std::vector<RadialForm> forms;
        for (int i = number(2, 7); i > 0; --i) {
            Item item{number(0, 3) == 0, {}};
            const int place = number(-3, 3);
            const double curvature = 0.5 * number(0, 3);
            // Above zero, as all C are.
            item.h = {curvature * place * place + number(1, 6), -2 * curvature * place, curvature};
            const auto is_same = [&](const Item& o) { return o.row == item.row && o.h == item.h; };
            if (std::ranges::any_of(items, is_same)) continue;
            items.push_back(item);
            forms.push_back(form(number(1, 3), rows[item.row], item.h));
        }
        const auto ties = find_ring_ties(forms, y0, y1);
        CAPTURE(round);
        for (const RingTie& tie : ties) {
            const Item &middle = items[tie.form], &before = items[tie.before], &after = items[tie.after];
            CHECK(middle.row == before.row);
            CHECK(middle.row == after.row);
            CHECK(tie.form != tie.before);
            CHECK(tie.form != tie.after);
            for (double y = y0; y <= y1; y += step) {
                const double least = std::min(at(before.h, y), at(after.h, y));
                if (y >= tie.from && y <= tie.to) CHECK(at(middle.h, y) >= least);
                if (tie.y.contains(y)) CHECK(at(middle.h, y) == least);
            }
            CHECK(tie.from < tie.y.upper());
            CHECK(tie.to > tie.y.lower());
        }
        // Where three tie, or two at an end, all but the nearest on both sides are known to.
        for (double y = y0; y <= y1; y += step)
            for (const int row : {0, 1}) {
                std::vector<std::uint32_t> here;
                for (std::uint32_t i = 0; i < items.size(); ++i)
                    if (items[i].row == row) {
                        if (!here.empty() && at(items[i].h, y) < at(items[here[0]].h, y)) here.clear();
                        if (here.empty() || at(items[i].h, y) == at(items[here[0]].h, y)) here.push_back(i);
                    }
                constexpr double beside = 0x1p-20;
                const auto nearest_at = [&](double place) {
                    return *std::ranges::min_element(here, {},
                                                     [&](std::uint32_t i) { return at(items[i].h, place); });
                };
                if (here.size() < 2) continue;
                const bool is_end = y == y0 || y == y1;
                const std::uint32_t before = nearest_at(y == y0 ? y + beside : y - beside),
                                    after = nearest_at(y == y1 ? y - beside : y + beside);
                for (const std::uint32_t i : here) {
                    const bool is_known = std::ranges::any_of(ties, [&](const RingTie& tie) {
                        return tie.form == i && tie.before == before && tie.after == after &&
                               tie.y.contains(y) && tie.end.has_value() == is_end;
                    });
                    CHECK(is_known == (i != before && i != after));
                    (is_end ? at_ends : inner) += is_known;
                }
            }
    }
    CHECK(inner > 20);
    CHECK(at_ends > 5);
}

}  // namespace vcell::ring_ties_test
