#include "platform.hpp"

#include <string>

#ifdef __SSE2__
#include <xmmintrin.h>
#endif

namespace vcell {

void require_ieee_arithmetic(const char* who) {
#ifdef __SSE2__
    // Both bits of the rounding mode, "flush to zero" and "denormals are zero". Arithmetic with subnormal
    // numbers takes as long as a hundred other operations; a root may take less.
    constexpr unsigned modes = 0x6000 | 0x8000 | 0x0040;
    if ((_mm_getcsr() & modes) == 0) return;
#endif
    // No compiler may compute these itself.
    volatile double one = 1, small = 0x1p-60, least_normal = DBL_MIN, least = 0x1p-1074, half = 0.5;
    // Upwards 1 + small is more than 1, downwards and towards zero 1 - small is less.
    if (one + small != 1 || one - small != 1 || -one - small != -1)
        throw EnvironmentError(
            std::string(who) +
            ": this thread does not round to nearest; call std::fesetround(FE_TONEAREST) first "
            "(a library that switches rounding has not switched it back)");
    // As results, and as operands.
    if (least_normal * half == 0 || least / least_normal == 0)
        throw EnvironmentError(
            std::string(who) +
            ": this thread takes subnormal numbers for zero; call "
            "_MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_OFF) and "
            "_MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_OFF) first, and link nothing with "
            "-ffast-math, which sets both when a program starts");
}

}  // namespace vcell
