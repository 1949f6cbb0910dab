/// A progress bar on standard error.
#pragma once

#include <chrono>

namespace vcell {

/// Shows itself when the work has taken a second, standard error being a terminal; gone when
/// destroyed, so that what follows stands on a clean line.
class ProgressBar {
public:
    ProgressBar();
    ~ProgressBar();
    ProgressBar(const ProgressBar&) = delete;
    ProgressBar& operator=(const ProgressBar&) = delete;

    /// `fraction` of the stage is done, in [0, 1].
    void show(const char* stage, double fraction);

private:
    using Clock = std::chrono::steady_clock;
    bool terminal_;
    bool shown_ = false;
    Clock::time_point next_;  // earliest time of the next drawing
};

}  // namespace vcell
