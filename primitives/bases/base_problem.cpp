#include "base_problem.hpp"

#include <algorithm>
#include <numeric>

namespace vcell {

Vec3 BaseFrame::to_canonical(const Vec3& world) const { return rotation * (world - origin); }
Vec3 BaseFrame::to_world(const Vec3& canonical) const { return rotation.transpose() * canonical + origin; }

void FormSites::settle() {
    if (joined_.empty()) return;
    for (const FormId f : ids())
        for (const Site site : (*this)[f]) joined_.emplace_back(f, site);
    std::ranges::sort(joined_);
    sites_.clear();
    begins_.assign(begins_.size(), 0);
    for (const auto& [form, site] : joined_) {
        sites_.push_back(site);
        ++begins_[form.value + 1];
    }
    std::partial_sum(begins_.begin(), begins_.end(), begins_.begin());
    joined_.clear();
}

}  // namespace vcell
