/// The ways a call can fail: bad input (the user's), an undecided question, and a broken invariant (ours).
#pragma once

#include "platform.hpp"

#include <cstdint>
#include <stdexcept>
#include <string>

namespace vcell {

/// Input that cannot be used. `path` names the offender as the scene file does
/// ("objects[3].sphere.radius"), `object` as the caller numbered it (no_object for base and box).
struct InputError : std::invalid_argument {
    enum class Kind {
        Syntax,  ///< not JSON, not "x y z r"
        UnknownKey,
        MissingKey,
        WrongType,
        NotFinite,
        NegativeRadius,
        ZeroAxis,  ///< zero normal or axis
        EmptyBox,
        Unsupported,  ///< legal in the format, not computed by this version
        TouchesBase,  ///< an object cuts or touches the base region
        OutOfRange,   ///< magnitudes whose products leave the double range
    };
    static constexpr std::uint32_t no_object = UINT32_MAX;

    /// Composes the message "path: what".
    InputError(Kind kind, std::uint32_t object, std::string path, const std::string& what);

    Kind kind;
    std::uint32_t object;
    std::string path;
};

/// A question about legal input that the digits at hand cannot decide; the message names the place.
struct UndecidedError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// A broken invariant: a bug in vcell, never the user's fault. Names the element.
struct InternalError : std::logic_error {
    using std::logic_error::logic_error;
};

}  // namespace vcell
