/// What every test program shares.
#pragma once

#include <cstdint>
#include <string>

namespace vcell {

/// The seed of all random input: the environment's VCELL_TEST_SEED, or a fixed number. Printed when
/// a test case fails, so that the run can be repeated.
std::uint64_t test_seed();

/// How many times as much the random tests do: the environment's VCELL_TEST_ROUNDS, or 1. The preset `slow`
/// asks for more.
int rounds();
/// How many scenes an oracle that takes long is asked: n for each round, a third as many in the quick suite.
inline int long_rounds(int n) { return rounds() > 1 ? n * rounds() : (n + 2) / 3; }

/// The path of tests/data/<name>. Throws std::runtime_error when the file is missing or empty: a
/// regression scene that has got lost must not pass.
std::string test_data(const std::string& name);

}  // namespace vcell
