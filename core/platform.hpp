/// What vcell needs of compiler and processor. Every header of ours reaches this one.
///
/// Bounds, intervals and compensated sums are proofs about IEEE 754 doubles, rounded to nearest one operation
/// at a time, with subnormal numbers. Options that let a compiler do otherwise, and a thread that runs in
/// another mode, would make them lie; so compiling stops here, and voronoi_cell() and the solver throw
/// EnvironmentError.
#pragma once

// Before C++20 nothing that follows would compile: a file that does not exist is the one message.
#if (defined(_MSVC_LANG) && _MSVC_LANG < 202002L) || (!defined(_MSVC_LANG) && __cplusplus < 201709L)
#include "vcell needs C++20: compile with -std=c++20"
#endif

#include <cfloat>
#include <limits>
#include <stdexcept>

#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__) ||             \
    defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__) || defined(__NO_SIGNED_ZEROS__) || \
    defined(_M_FP_FAST)
#error \
    "vcell proves by IEEE 754 arithmetic: compile without -ffast-math (-Ofast, /fp:fast) and what it implies"
#elif FLT_EVAL_METHOD < 0 || FLT_EVAL_METHOD == 2
#error \
    "vcell proves by IEEE 754 arithmetic: doubles must be rounded to doubles; on 32-bit x86 compile with -msse2 -mfpmath=sse"
#else
static_assert(std::numeric_limits<double>::is_iec559 && std::numeric_limits<double>::digits == 53,
              "vcell proves by IEEE 754 arithmetic: double must be its binary64");
#endif

namespace vcell {

namespace roundoff {

/// The unit roundoff of doubles, 2^-53: an operation's result is off by at most u of itself where nothing
/// underflows.
inline constexpr double u = std::numeric_limits<double>::epsilon() / 2;

}  // namespace roundoff

inline constexpr double infinity = std::numeric_limits<double>::infinity();

/// The calling thread's floating-point unit is not in the mode that proofs need.
struct EnvironmentError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// Throws EnvironmentError, with what to do, unless this thread rounds to nearest and has subnormal numbers.
/// Takes some nanoseconds. `who` begins the message: "voronoi_cell()".
void require_ieee_arithmetic(const char* who);

/// Asks here and where a call of ours ends: something that it calls back may have switched modes.
template <class Call>
auto in_ieee_arithmetic(const char* who, Call&& call) {
    require_ieee_arithmetic(who);
    auto result = call();
    require_ieee_arithmetic(who);
    return result;
}

}  // namespace vcell
