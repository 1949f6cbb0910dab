/// Culling of circular forms in groups against all of them, looked at one by one.
#include <doctest/doctest.h>

#include <algorithm>
#include <random>

#include "../../envelope/recursion/competing_forms.hpp"
#include "../test_support.hpp"
#include "form_scenes.hpp"

namespace vcell::competing_forms_test {
namespace {

using Item = CompetingForms::Item;

enum class Kind { Even, Clustered, Far, Lattice, Wide, Deep, Flat, Any, Huge };

// Paraboloids over [0, 100]^2, at places and of widths that make groups of all sorts.
CircularFamily random_family(std::mt19937_64& rng, Kind kind, std::size_t n) {
    const auto pick = [&](double low, double high) {
        return std::uniform_real_distribution<double>(low, high)(rng);
    };
    CircularFamily family;
    for (std::size_t i = 0; i < n; ++i) {
        CircularForm f;
        f.k = 1;
        f.cx = pick(0, 100);
        f.cy = pick(0, 100);
        f.e = pick(-2, 2);
        f.w = pick(0.5, 3);
        if (kind == Kind::Clustered) {
            f.cx = 50 + std::ldexp(f.cx - 50, -static_cast<int>(i % 40));
            f.cy = 50 + std::ldexp(f.cy - 50, -static_cast<int>(i % 40));
        } else if (kind == Kind::Far) {
            f.cx = std::ldexp(f.cx - 50, static_cast<int>(i % 60));
            f.e = std::ldexp(f.e, static_cast<int>(i % 90) - 30);
        } else if (kind == Kind::Lattice) {
            f.cx = std::floor(f.cx);
            f.cy = std::floor(f.cy);
            f.e = 1;
            f.w = 2;
        } else if (kind == Kind::Wide) {  // one of twenty is lowest far from its place
            f.w = i % 20 == 0 ? pick(5, 10) : pick(0.05, 0.1);
        } else if (kind == Kind::Deep) {
            f.e = i % 20 == 0 ? pick(-500, -300) : f.e;
        } else if (kind == Kind::Flat) {  // lines' and planes' among them
            f.cx = f.cy = 0;
            f.k = i % 3 == 0 ? 0 : pick(0, 1e-3);
            f.a = pick(-1, 1);
            f.b = pick(-1, 1);
        } else if (kind == Kind::Any) {
            f.k = pick(-1, 1);
            f.w = std::exp(pick(-20, 20));
        } else if (kind == Kind::Huge) {  // nothing of them is finite but their values
            f.cx = f.cy = 0;
            f.k = std::ldexp(pick(0, 1), -static_cast<int>(i % 3) * 500);
            f.a = pick(-1, 1);
            f.w = std::ldexp(f.w, static_cast<int>(i % 5) * 200 - 400);
        }
        family.forms.push_back(f);
    }
    return family;
}

std::vector<FormId> all_ids(std::size_t n) {
    std::vector<FormId> ids;
    for (std::uint32_t i = 0; i < n; ++i) ids.push_back(FormId{i});
    return ids;
}

std::vector<FormId> ids_in(const CompetingForms& forms, std::span<const Item> items) {
    std::vector<FormId> ids;
    for (const Item item : items) forms.for_forms(item, [&](Item form) { ids.push_back(forms.id(form)); });
    std::ranges::sort(ids);
    return ids;
}

// The lowest form, by values that tell it for certain; none if two are too near to each other for that.
FormId certainly_lowest(const CircularFamily& family, double x, double y) {
    FormId best;
    long double least = HUGE_VALL, second = HUGE_VALL, scale = 0;
    for (std::uint32_t i = 0; i < family.forms.size(); ++i) {
        const CircularForm& f = family.forms[FormId{i}];
        const long double dx = static_cast<long double>(x) - f.cx, dy = static_cast<long double>(y) - f.cy;
        const long double square = f.k * (dx * dx + dy * dy), a = f.a * x, b = f.b * y;
        const long double v = (square + a + b + f.e) / f.w;
        second = std::min(second, std::max(v, least));
        if (v >= least) continue;
        least = v;
        best = FormId{i};
        scale =
            (std::abs(square) + std::abs(a) + std::abs(b) + std::abs(static_cast<long double>(f.e))) / f.w;
    }
    return second - least > 1e-17L * scale ? best : FormId{};
}

}  // namespace

TEST_CASE("competing forms: items hold every form once") {
    std::mt19937_64 rng(test_seed());
    for (const std::size_t n : {0, 1, 5, 2048, 2049, 2050, 4097, 5000})
        for (const Kind kind : {Kind::Even, Kind::Flat, Kind::Any, Kind::Huge}) {
            CAPTURE(n);
            const CompetingForms forms(random_family(rng, kind, n), all_ids(n));
            CHECK(ids_in(forms, forms.all()) == all_ids(n));
            CHECK(forms.count(forms.all()) == n);
            if (n > 2048 && kind == Kind::Even) CHECK(forms.all().size() == 1);
        }
}

TEST_CASE("competing forms: what is lowest somewhere is kept, and little else") {
    std::mt19937_64 rng(test_seed() + 1);
    const auto pick = [&](double low, double high) {
        return std::uniform_real_distribution<double>(low, high)(rng);
    };
    long asked = 0;
    for (int round = 0; round < 2 * rounds(); ++round)
        for (const Kind kind : {Kind::Even, Kind::Clustered, Kind::Far, Kind::Lattice, Kind::Wide, Kind::Deep,
                                Kind::Flat, Kind::Any, Kind::Huge}) {
            CAPTURE(static_cast<int>(kind));
            const std::size_t n = 1500 + rng() % 2000;
            const CircularFamily family = random_family(rng, kind, n);
            const CompetingForms forms(family, all_ids(n));
            CompetingForms::Culling cull(forms);
            std::vector<Item> items(forms.all().begin(), forms.all().end()), kept;
            Rectangle r{-3, 103, -3, 103};
            for (int depth = 0; depth < 14; ++depth) {
                const std::size_t few = 1 + rng() % 200;
                cull(r, items, few, kept);
                const std::vector<FormId> ids = ids_in(forms, kept), before = ids_in(forms, items);
                CHECK(std::ranges::includes(before, ids));
                CHECK(std::ranges::adjacent_find(ids) == ids.end());
                if (ids.size() <= few)
                    CHECK(std::ranges::none_of(kept, [&](Item item) { return forms.is_group(item); }));
                for (int i = 0; i < 10; ++i)
                    if (const FormId lowest = certainly_lowest(family, pick(r.x0, r.x1), pick(r.y0, r.y1));
                        lowest.valid()) {
                        ++asked;
                        CHECK(std::ranges::binary_search(ids, lowest));
                    }
                items = kept;
                (depth % 2 ? (rng() % 2 ? r.x0 : r.x1) : (rng() % 2 ? r.y0 : r.y1)) =
                    depth % 2 ? 0.5 * (r.x0 + r.x1) : 0.5 * (r.y0 + r.y1);
            }
            // A hundredth of the region: beside forms that lie evenly few are left.
            if (kind == Kind::Even) CHECK(forms.count(items) < 100);
        }
    CHECK(asked > 1000);
}

}  // namespace vcell::competing_forms_test
