#include "command.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <optional>
#include <string_view>

#include "../io/files/text.hpp"

namespace vcell {

void warn(const std::string& text) { fmt::print(stderr, "vcell: warning: {}\n", text); }

Status report_assumed(std::uint64_t assumed) {
    if (assumed == 0) return done;
    warn(fmt::format("{} coincidences could not be decided and were taken for granted", assumed));
    return undecided;
}

std::string number_complaint(const std::string& text) {
    const std::optional<double> value =
        to_double(std::string_view(text).substr(text.starts_with('+') ? 1 : 0));
    return value && std::isfinite(*value) ? ""
                                          : fmt::format("must be a finite number, is {}", printable(text));
}

std::string count_complaint(const std::string& text) {
    const bool digits = !text.empty() && text.find_first_not_of("0123456789") == text.npos;
    return digits && text.size() < 10 && std::stoul(text) > 0
               ? ""
               : fmt::format("must be a number from 1 to 999999999, is {}", printable(text));
}

}  // namespace vcell
