#include <doctest/doctest.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <random>

#include "../../core/errors.hpp"
#include "../../io/check/check.hpp"
#include "../../io/files/cell_file.hpp"
#include "../../io/files/scene_file.hpp"
#include "sample_cells.hpp"
#include "test_support.hpp"

using namespace vcell;
using nlohmann::json;

namespace {

const std::string scene = R"({"vcell":1,"base":{"plane":{"point":[0,0,0],"normal":[0,0,1]}},"objects":[
{"sphere":{"center":[0.2,0.1,0.9],"radius":0.25},"name":"O1 \u00e9"},
{"cylinder":{"point":[0,0,1.4],"axis":[1,0.3,0],"radius":0.1}},
{"plane":{"point":[0,0,2],"normal":[0.1,0,-1]}}],
"box":{"min":[-1,-1,0],"max":[1,1,2]},"units":"mm","tolerance":1e-7})";

/// A few bytes changed, removed, doubled or cut off.
std::string damaged_bytes(std::string text, std::mt19937_64& rng) {
    for (auto n = 1 + rng() % 3; n-- > 0 && !text.empty();) {
        const std::size_t at = rng() % text.size();
        switch (rng() % 5) {
            case 0: text[at] = static_cast<char>(rng()); break;
            case 1: text.erase(at, 1 + rng() % 20); break;
            case 2: text.insert(at, text.substr(rng() % text.size(), rng() % 40)); break;
            case 3: text[at] = "0123456789eE+-.{}[]\",:\\u"[rng() % 24]; break;
            default:
                if (rng() % 10 == 0) text.resize(at);
        }
    }
    return text;
}

json strange_value(std::mt19937_64& rng) {
    switch (rng() % 14) {
        case 0: return 1e308;
        case 1: return -1e308;
        case 2: return 5e-324;
        case 3: return -1;
        case 4: return 0;
        case 5: return UINT64_MAX;
        case 6: return INT64_MIN;
        case 7: return nullptr;
        case 8: return true;
        case 9: return "NaN";
        case 10: return json::array({json::array({1, 2, 3})});
        case 11: return json::object({{"sphere", 1}});
        case 12: return std::string(1000, 'x');
        default: return json::array();
    }
}

/// A random value of the tree replaced, or a random key removed.
void damage_value(json& value, std::mt19937_64& rng) {
    if (value.is_structured() && !value.empty() && rng() % 8 != 0) {
        auto it = value.begin();
        std::advance(it, static_cast<std::ptrdiff_t>(rng() % value.size()));
        if (rng() % 12 == 0)
            value.erase(it);
        else
            damage_value(*it, rng);
    } else {
        value = strange_value(rng);
    }
}

/// The readers may refuse with InputError and nothing else.
void read_scene_text(const std::string& text) {
    CAPTURE(text);
    try {
        parse_scene(text);
    } catch (const InputError&) {
    }
}
void read_and_check_cell(const std::string& text) {
    CAPTURE(text);
    try {
        check_cell(parse_cell(text));
    } catch (const InputError&) {
    }
}

double seconds(const auto& work) {
    const auto begin = std::chrono::steady_clock::now();
    work();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

}  // namespace

TEST_CASE("fuzz: scenes with damaged bytes") {
    std::mt19937_64 rng(test_seed());
    for (int i = 0; i < long_rounds(100'000); ++i) read_scene_text(damaged_bytes(scene, rng));
}

TEST_CASE("fuzz: scenes with damaged values") {
    std::mt19937_64 rng(test_seed());
    const json valid = json::parse(scene);
    for (int i = 0; i < 20'000; ++i) {
        json damaged = valid;
        damage_value(damaged, rng);
        read_scene_text(damaged.dump());
    }
}

TEST_CASE("fuzz: every truncation of a scene is refused") {
    for (std::size_t n = 0; n < scene.size(); ++n) CHECK(scene_complaint(scene.substr(0, n)) != "accepted");
}

TEST_CASE("fuzz: what this reader takes for JSON, another does too") {
    std::mt19937_64 rng(test_seed());
    int accepted = 0;
    for (int i = 0; i < long_rounds(100'000); ++i) {
        const std::string text = damaged_bytes(scene, rng);
        if (scene_complaint(text) != "accepted") continue;
        ++accepted;
        CAPTURE(text);
        CHECK(json::accept(text));
    }
    CHECK(accepted > long_rounds(1000));
}

TEST_CASE("fuzz: plain balls with damaged bytes") {
    std::mt19937_64 rng(test_seed());
    TextSceneOptions options;
    options.base_plane = Plane{};
    for (int i = 0; i < 50'000; ++i) {
        const std::string text =
            damaged_bytes("# x y z r\n0.5 -1e3 2.25 .125\n1 2 3 4\r\n\n+7 8 9 0 # end\n", rng);
        CAPTURE(text);
        try {
            parse_scene(text, options);
        } catch (const InputError&) {
        }
    }
}

TEST_CASE("fuzz: damaged cells are refused or judged") {
    std::mt19937_64 rng(test_seed());
    for (const Cell& cell : {paraboloid_cell(), island_cell()}) {
        const std::string text = cell_text(cell);
        const json valid = json::parse(text);
        for (int i = 0; i < long_rounds(500); ++i) {
            read_and_check_cell(damaged_bytes(text, rng));
            json damaged = valid;
            damage_value(damaged, rng);
            read_and_check_cell(damaged.dump());
        }
    }
}

TEST_CASE("fuzz: deep nesting does not reach the stack") {
    constexpr int depth = 100'000;
    std::string objects;
    for (int i = 0; i < depth; ++i) objects += "{\"objects\":";
    for (const std::string& text :
         {std::string(depth, '['), std::string(depth, '{'), objects,
          "{\"vcell\":1,\"objects\":" + std::string(depth, '['), "{\"scene\":" + objects}) {
        CHECK(scene_complaint(text) != "accepted");
        CHECK(cell_complaint(text) != "accepted");
    }
}

TEST_CASE("fuzz: megabytes of garbage fail at once") {
    std::mt19937_64 rng(test_seed());
    const std::size_t size = rounds() > 1 ? 10'000'000 : 2'500'000;
    std::string noise(size, '\0');
    for (char& c : noise) c = static_cast<char>(rng());
    const std::string prefix = R"({"vcell":1,"objects":[{"name":")";
    for (const std::string& text :
         {noise, std::string(size, ' '), std::string(size, '\n'), std::string(size, '0'),
          "-" + std::string(size, '9'), "1e" + std::string(size, '9'), "\"" + std::string(size, 'x'),
          prefix + std::string(size, 'x'), "{\"" + std::string(size, 'x') + "\":1}",
          "{\"vcell\":" + std::string(size, '7'), "{\"vcell\":0." + std::string(size, '3') + "}"}) {
        // A debug build with sanitizers on a busy machine has to pass too.
        CHECK(seconds([&] { CHECK(scene_complaint(text) != "accepted"); }) < 5);
        CHECK(seconds([&] { CHECK(cell_complaint(text) != "accepted"); }) < 5);
    }
}
