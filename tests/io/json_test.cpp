#include <doctest/doctest.h>

#include <bit>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>

#include "../../core/errors.hpp"
#include "../../io/files/json_reader.hpp"
#include "../../io/files/json_writer.hpp"
#include "../../io/files/text.hpp"
#include "test_support.hpp"

using namespace vcell;

namespace {

/// The error of reading one value from the text; "accepted" for none.
template <class F>
std::string complaint(std::string_view text, F read) {
    try {
        JsonReader in(text);
        read(in);
        in.end();
    } catch (const InputError& error) {
        return error.what();
    }
    return "accepted";
}

std::string number_complaint(std::string_view text) {
    return complaint(text, [](JsonReader& in) { in.number(); });
}
std::string string_complaint(std::string_view text) {
    return complaint(text, [](JsonReader& in) { in.string(); });
}

}  // namespace

TEST_CASE("json: numbers follow the grammar and nothing else") {
    for (const char* good :
         {"0", "-0", "1", "-12.5e+3", "1E-7", "1e-999", "123456789012345678901234567890", " \t\n7\r "})
        CHECK_MESSAGE(number_complaint(good) == "accepted", good);
    for (const char* bad : {"01", "1.", ".5", "+1", "-", "1e", "1e+", "0x10", "1 2", "- 1", "", "nan", "1,"})
        CHECK_MESSAGE(number_complaint(bad) != "accepted", bad);
    CHECK(number_complaint("1e999") == "must be a finite number, 1e999 is out of range");
    CHECK(number_complaint("-1e999") == "must be a finite number, -1e999 is out of range");
    for (const char* word : {"NaN", "Infinity", "-Infinity"})
        CHECK(number_complaint(word) == "must be a finite number");
    CHECK(number_complaint("\"1\"") == "must be a number, is a string");
    CHECK(number_complaint("null") == "must be a number, is null");
    CHECK(number_complaint("[1]") == "must be a number, is an array");
}

TEST_CASE("json: every double reads back as itself") {
    std::mt19937_64 rng(test_seed());
    for (int i = 0; i < 100'000; ++i) {
        const double x = i == 0 ? std::numeric_limits<double>::denorm_min() : std::bit_cast<double>(rng());
        if (!std::isfinite(x)) continue;
        std::ostringstream out;
        JsonWriter writer(out);
        writer.value(x);
        writer.finish();
        const std::string text = out.str();
        JsonReader reader(text);
        CAPTURE(text);
        REQUIRE(std::bit_cast<std::uint64_t>(reader.number()) == std::bit_cast<std::uint64_t>(x));
    }
}

TEST_CASE("json: a number that is not finite is never written") {
    std::ostringstream out;
    JsonWriter writer(out);
    CHECK_THROWS_AS(writer.value(std::nan("")), InternalError);
    CHECK_THROWS_AS(writer.value(INFINITY), InternalError);
}

TEST_CASE("json: integers") {
    const auto complain = [](std::string_view text) {
        return complaint(text, [](JsonReader& in) { in.unsigned_integer(10); });
    };
    CHECK(complain("10") == "accepted");
    CHECK(complain("11") == "must be at most 10, is 11");
    CHECK(complain("99999999999999999999999") == "must be at most 10, is 99999999999999999999999");
    CHECK(complain("-1") == "must be a non-negative integer, is -1");
    CHECK(complain("1.5") == "must be a non-negative integer, is 1.5");
    CHECK(complain("1e0") == "must be a non-negative integer, is 1e0");
}

TEST_CASE("json: strings agree with another reader") {
    for (const char* text :
         {R"("")", R"("plain")", R"("\"\\\/\b\f\n\r\t")", R"("\u0041\u00e9\u20ac\ud83d\ude00\u0000x")",
          "\"\xC3\xA9 \xE2\x82\xAC \xF0\x9F\x98\x80\""}) {
        CAPTURE(text);
        JsonReader reader(text);
        CHECK(reader.string() == nlohmann::json::parse(text).get<std::string>());
    }
}

TEST_CASE("json: broken strings are refused") {
    for (const std::string text :
         {"\"", "\"a", "\"\\", "\"\\x\"", "\"\\u12\"", "\"\\u12g4\"", "\"\\u+123\"", "\"\\ud800\"",
          "\"\\ud800\\u0041\"", "\"\\udc00\"", "\"a\nb\"", "\"\x80\"", "\"\xC0\x80\"", "\"\xE0\x80\x80\"",
          "\"\xED\xA0\x80\"", "\"\xF4\x90\x80\x80\"", "\"\xC3\"", "\"\xF0\x9F\x98\""}) {
        CAPTURE(text);
        CHECK(string_complaint(text) != "accepted");
        CHECK_FALSE(nlohmann::json::accept(text));
    }
}

TEST_CASE("json: what is written, another reader understands") {
    const std::string nasty =
        "quote \" backslash \\ newline \n bell \a nul " + std::string(1, '\0') + " \xF0\x9F\x98\x80";
    std::ostringstream out;
    JsonWriter writer(out);
    writer.object([&] {
        writer.key("text").value(nasty);
        writer.key("list").lines(std::vector<int>{1, 2}, [&](int i) { writer.value(i); });
        writer.key("empty").lines(std::vector<int>{}, [&](int i) { writer.value(i); });
        writer.key("flag").value(true);
        writer.key("nothing").null();
    });
    writer.finish();
    const auto read = nlohmann::json::parse(out.str());
    CHECK(read.at("text") == nasty);
    CHECK(read.at("list") == nlohmann::json{1, 2});
    CHECK(read.at("empty").empty());
    CHECK(read.at("flag") == true);
    CHECK(read.at("nothing").is_null());
}

TEST_CASE("json: errors name path, line and column") {
    const auto complain = [](std::string_view text) {
        return complaint(text, [](JsonReader& in) {
            in.object(required_member("list", [&] { in.array([&](std::size_t) { in.number(); }); }),
                      optional_member("flag", [&] { in.boolean(); }));
        });
    };
    CHECK(complain(R"({"list": [1, 2]})") == "accepted");
    CHECK(complain("\xEF\xBB\xBF{\"list\": []}") == "accepted");
    CHECK(complain(R"({"list": [1, true]})") == "list[1]: must be a number, is true");
    CHECK(complain(R"({"list": [], "list": []})") == "list: given twice");
    CHECK(complain(R"({"lists": []})") == "lists: unknown key, known are list, flag");
    CHECK(complain(R"({"l\u0069st": [1]})") == "accepted");
    CHECK(complain(R"({"": []})") == "\"\": unknown key, known are list, flag");
    CHECK(complain(R"({"flag": true})") == "list: missing");
    CHECK(complain(R"([])") == "must be an object, is an array");
    CHECK(complain("{\n \"list\": [1;2]}") == "list: line 2, column 12: expected ',' or ']', found ';2]}'");
    CHECK(complain("{\n\n \xC3\xA9}") ==
          "line 3, column 2: expected a key in double quotes, found '\xC3\xA9}'");
    CHECK(complain("{\"list\": [") == "list[0]: line 1, column 11: expected a number, the text ends");
    CHECK(complain("{\"list\": []} x") == "line 1, column 14: expected the end of the text, found 'x'");
    CHECK(complain(std::string("{\"list\": []}\0", 13)) ==
          "line 1, column 13: expected the end of the text, found '?'");
    CHECK(complain("{\"list\": [],}") == "line 1, column 13: expected a key in double quotes, found '}'");
    CHECK(complain("{\"list\": [1,]}") == "list[1]: line 1, column 13: expected a number, found ']}'");
    CHECK(complain("{\"flag\": tru}") == "flag: line 1, column 10: expected true, found 'tru}'");
    CHECK(complain("{\"a\x1b[31m\": 1}") ==
          "line 1, column 4: control character in a string, found '?[31m\": '");
    CHECK(complain("{\"" + std::string(1000, 'k') + "\": 1}") ==
          std::string(40, 'k') + "...: unknown key, known are list, flag");
}

TEST_CASE("text: UTF-8 and messages") {
    CHECK(utf8_length("a") == 1);
    CHECK(utf8_length("\xE2\x82\xAC") == 3);
    CHECK(utf8_length("") == 0);
    CHECK(printable("a\nb\x7F\xFFz") == "a?b??z");
    CHECK(printable(std::string(41, 'x')) == std::string(40, 'x') + "...");
    CHECK(*to_double("1e400") == INFINITY);
    CHECK(*to_double("-1e-400") == 0);
    CHECK_FALSE(to_double("1x"));
    CHECK_FALSE(to_double(""));
}
