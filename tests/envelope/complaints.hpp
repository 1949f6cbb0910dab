/// What the tests that judge diagrams by brute force share.
#pragma once

#include <string>
#include <vector>

namespace vcell {

/// A line for each.
inline std::string join(const std::vector<std::string>& lines) {
    std::string s;
    for (const auto& l : lines) s += l + "\n";
    return s;
}

/// Collects what a judge finds, up to what anyone reads.
class Complaints {
protected:
    void complain(const std::string& what) {
        if (complaints_.size() < enough) complaints_.push_back(what);
    }
    /// "{f1 f2}" for ids.
    template <class Ids>
    static std::string name(const Ids& ids) {
        std::string s = "{";
        for (const auto& id : ids) s += (s.size() > 1 ? " " : "") + to_string(id);
        return s + "}";
    }

    std::vector<std::string> complaints_;

private:
    static constexpr std::size_t enough = 20;
};

}  // namespace vcell
