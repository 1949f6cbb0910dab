#include <doctest/doctest.h>

#include <concepts>
#include <vector>

#include "vcell/core/ids.hpp"

namespace vcell::ids_test {

namespace {
struct AppleTag {
    static constexpr char letter = 'a';
};
struct PearTag {
    static constexpr char letter = 'p';
};
using Apple = Id<AppleTag>;
using Pear = Id<PearTag>;
}  // namespace

TEST_CASE("Id: ids of different tags do not compare or convert") {
    static_assert(std::equality_comparable<Apple>);
    static_assert(!std::equality_comparable_with<Apple, Pear>);
    static_assert(!std::convertible_to<Apple, Pear>);
    CHECK(Apple{1} < Apple{2});
    CHECK(Apple{3} == Apple{3});
}

TEST_CASE("Id: default is none, and prints as such") {
    CHECK_FALSE(Apple{}.valid());
    CHECK(to_string(Apple{}) == "none");
    CHECK(Apple{0}.valid());
    CHECK(to_string(Apple{0}) == "a0");
    CHECK(to_string(Pear{4'000'000'000u}) == "p4000000000");
}

TEST_CASE("IdVector: push_back returns the id that finds the element") {
    IdVector<Apple, int> v;
    CHECK(v.empty());
    for (int i = 0; i < 100; ++i) {
        const Apple id = v.push_back(10 * i);
        CHECK(id.value == static_cast<std::uint32_t>(i));
        CHECK(v[id] == 10 * i);
    }
    v[Apple{7}] = -1;
    CHECK(v[Apple{7}] == -1);
    CHECK(v[Apple{6}] == 60);
    CHECK(v.size() == 100);
}

TEST_CASE("IdVector: ids() visits every element once, in order") {
    const IdVector<Pear, int> v{5, 6, 7};
    std::vector<int> seen;
    for (const Pear id : v.ids()) seen.push_back(v[id]);
    CHECK(seen == std::vector{5, 6, 7});
    for (const Pear id : IdVector<Pear, int>().ids()) FAIL("visited ", to_string(id));
}

TEST_CASE("IdVector: resize fills with the given value and keeps the rest") {
    IdVector<Apple, int> v(2, 3);
    v.resize(4, 9);
    CHECK(v[Apple{1}] == 3);
    CHECK(v[Apple{3}] == 9);
    v.clear();
    CHECK(v.empty());
}

}  // namespace vcell::ids_test
