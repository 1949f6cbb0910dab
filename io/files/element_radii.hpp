/// Radii of van der Waals of the elements, in ångström.
#pragma once

#include <optional>
#include <string_view>

namespace vcell {

/// The radius of an element by its symbol, in any case ("Fe", "FE"; "D" is hydrogen): that of [Bondi64], and
/// of elements that have none there that of [Alvarez13]; none for what is no element and for elements that
/// have none in either.
std::optional<double> element_radius(std::string_view symbol);

}  // namespace vcell
