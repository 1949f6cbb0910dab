#include "site.hpp"

namespace vcell {

std::string to_string(Site site) {
    static constexpr const char* sides[] = {"box:-x", "box:+x", "box:-y", "box:+y", "box:-z", "box:+z"};
    switch (site.kind) {
        case Site::Kind::Object:
            return site.index == Site::number_of_cap ? "cap" : std::to_string(site.index);
        case Site::Kind::BoxSide: return sides[site.index];
        case Site::Kind::End: return site.index == 0 ? "end:-" : "end:+";
        case Site::Kind::Cap: return "cap";
        case Site::Kind::Base: break;
    }
    return "base";
}

}  // namespace vcell
