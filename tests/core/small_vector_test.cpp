#include <doctest/doctest.h>

#include <cstddef>
#include <random>
#include <utility>
#include <vector>

#include "../../core/small_vector.hpp"
#include "../test_support.hpp"

namespace vcell::small_vector_test {

TEST_CASE("SmallVector: does as std::vector does, inside and outside") {
    using Small = SmallVector<int, 3>;
    std::mt19937_64 rng(vcell::test_seed());
    const auto below = [&](std::size_t n) { return static_cast<std::size_t>(rng() % n); };
    Small small;
    std::vector<int> large;
    for (int i = 0; i < 20'000; ++i) {
        const auto at = static_cast<std::ptrdiff_t>(below(large.size() + 1));
        switch (rng() % 8) {
            case 0:
                small.push_back(i);
                large.push_back(i);
                break;
            case 1:
                if (!large.empty()) {
                    small.push_back(small.front());
                    large.push_back(int{large.front()});
                }
                break;
            case 2: {
                const std::size_t count = below(4);
                const auto place = small.insert(small.begin() + at, count, i);
                CHECK(place == small.begin() + at);
                large.insert(large.begin() + at, count, i);
                break;
            }
            case 3: {
                const std::vector<int> more{i, i + 1, i + 2};
                small.insert(small.begin() + at, more.begin(), more.end());
                large.insert(large.begin() + at, more.begin(), more.end());
                break;
            }
            case 4:
                small.erase(small.begin() + at, small.end());
                large.erase(large.begin() + at, large.end());
                break;
            case 5: {
                const std::size_t size = below(6);
                small.resize(size);
                large.resize(size);
                break;
            }
            case 6: {
                Small moved(std::move(small));
                CHECK(small.empty());
                small = std::move(moved);
                break;
            }
            default: {
                const Small copy(small);
                small.clear();
                small = copy;
                CHECK(small == copy);
            }
        }
        REQUIRE(std::vector<int>(small.begin(), small.end()) == large);
        REQUIRE(small.capacity() >= small.size());
    }
}

TEST_CASE("SmallVector: short sequences lie inside, long ones change hands when moved") {
    SmallVector<double, 2> a{1, 2};
    const auto is_inside = [](const SmallVector<double, 2>& v) {
        const auto* p = reinterpret_cast<const std::byte*>(v.data());
        const auto* begin = reinterpret_cast<const std::byte*>(&v);
        return p >= begin && p < begin + sizeof(v);
    };
    CHECK(is_inside(a));
    a.push_back(3);
    CHECK_FALSE(is_inside(a));
    const double* const data = a.data();
    const SmallVector<double, 2> b(std::move(a));
    CHECK(b.data() == data);
    CHECK(b == SmallVector<double, 2>{1, 2, 3});
    CHECK(is_inside(a));
}

}  // namespace vcell::small_vector_test
