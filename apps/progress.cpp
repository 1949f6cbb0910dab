#include "progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <string>

namespace vcell {

using namespace std::chrono_literals;

ProgressBar::ProgressBar() : terminal_(::isatty(STDERR_FILENO) == 1), next_(Clock::now() + 1s) {}

ProgressBar::~ProgressBar() {
    if (shown_) fmt::print(stderr, "\r\x1b[K");  // to the line's start, erase it
}

void ProgressBar::show(const char* stage, double fraction) {
    if (!terminal_ || Clock::now() < next_) return;
    next_ = Clock::now() + 100ms;
    shown_ = true;
    constexpr int width = 40;
    const double done = std::clamp(fraction, 0.0, 1.0);
    const auto filled = static_cast<std::size_t>(width * done);
    fmt::print(stderr, "\r\x1b[K{:<12} [{:<{}}] {:3.0f} %", stage, std::string(filled, '#'), width,
               100 * done);
    std::fflush(stderr);
}

}  // namespace vcell
