#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include "test_support.hpp"

#include <doctest/doctest.h>

#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <stdexcept>

namespace vcell {

std::uint64_t test_seed() {
    const char* given = std::getenv("VCELL_TEST_SEED");
    return given ? std::stoull(given) : 20'090'217;
}

int rounds() {
    const char* given = std::getenv("VCELL_TEST_ROUNDS");
    return given ? std::stoi(given) : 1;
}

std::string test_data(const std::string& name) {
    const std::filesystem::path path = std::filesystem::path(VCELL_TEST_DATA) / name;
    if (!std::filesystem::is_regular_file(path)) throw std::runtime_error("no test data " + path.string());
    if (std::filesystem::file_size(path) == 0) throw std::runtime_error("empty test data " + path.string());
    return path.string();
}

namespace {

/// Names the seed of a failed test case, and fails a run whose filter selects nothing: ctest passes
/// each case by name, and a name that no longer matches must not look like success.
struct SeedReporter : doctest::IReporter {
    explicit SeedReporter(const doctest::ContextOptions& options) : out(*options.cout) {}

    void test_case_end(const doctest::CurrentTestCaseStats& stats) override {
        if (!stats.testCaseSuccess) out << "seed: VCELL_TEST_SEED=" << test_seed() << std::endl;
    }
    void test_run_end(const doctest::TestRunStats& stats) override {
        if (stats.numTestCasesPassingFilters > 0) return;
        out << "no test case selected" << std::endl;
        std::exit(EXIT_FAILURE);
    }

    void report_query(const doctest::QueryData&) override {}
    void test_run_start() override {}
    void test_case_start(const doctest::TestCaseData&) override {}
    void test_case_reenter(const doctest::TestCaseData&) override {}
    void test_case_exception(const doctest::TestCaseException&) override {}
    void subcase_start(const doctest::SubcaseSignature&) override {}
    void subcase_end() override {}
    void log_assert(const doctest::AssertData&) override {}
    void log_message(const doctest::MessageData&) override {}
    void test_case_skipped(const doctest::TestCaseData&) override {}

    std::ostream& out;
};

REGISTER_LISTENER("seed", 1, SeedReporter);

}  // namespace
}  // namespace vcell
