/// The texts that pages are made of, from the files in page/ and three.js; cmake/vcell_page.cmake turns them
/// into a source file at build time.
#pragma once

#include <string_view>

namespace vcell::page_parts {

extern const std::string_view three;  ///< three.js as a script that defines THREE; empty if it was not found
extern const std::string_view style;  ///< CSS
extern const std::string_view
    body;  ///< HTML, in which <!--title-->, <!--summary--> and <!--diagram--> stand for what differs
extern const std::string_view script;

}  // namespace vcell::page_parts
