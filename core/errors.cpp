#include "errors.hpp"

#include <utility>

namespace vcell {

InputError::InputError(Kind kind, std::uint32_t object, std::string path, const std::string& what)
    : std::invalid_argument(path.empty() ? what : path + ": " + what),
      kind(kind),
      object(object),
      path(std::move(path)) {}

}  // namespace vcell
