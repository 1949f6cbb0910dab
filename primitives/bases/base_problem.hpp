/// A scene in canonical position, over any base: what the envelope is made from.
///
/// Canonical position and the heights over it are those of plane_base.hpp and radial_base.hpp.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "../forms/form_family.hpp"
#include "../objects/objects.hpp"
#include "../objects/site.hpp"

namespace vcell {

/// A rigid motion between world and canonical coordinates: canonical = R (world - origin), rounded. Forms are
/// those of an exact motion: for axis-parallel normals R is a signed permutation and the origin the base's
/// point on that axis, or near a box that is far from the scene's origin; in general R is a rotation with
/// rational entries (exact_motion.hpp) and the origin a point of the base near the box. Objects are to each
/// other exactly what they are in the scene. What is rounded, and counted in BaseProblem::moved: the
/// sides of the box, to doubles in canonical coordinates, and unless the normal's length is a double the base
/// itself, which turns by a few 2^-53 (planes parallel to it turn with it).
struct BaseFrame {
    Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
    Vec3 origin = Vec3::Zero();

    bool is_axis_parallel() const { return (rotation.array() == 0).count() == 6; }
    Vec3 to_canonical(const Vec3& world) const;
    Vec3 to_world(const Vec3& canonical) const;
};

/// A side of the base region: which side of the box cuts the base plane there.
struct RegionSide {
    double a, b, c;  ///< a x + b y + c >= 0 inside, canonical coordinates
    Site site;
};

/// The sites of each form, ascending; of nearly every form just one.
class FormSites {
public:
    void reserve(std::size_t forms) {
        sites_.reserve(forms);
        begins_.reserve(forms + 1);
    }
    /// The next form.
    FormId add(Site site) {
        sites_.push_back(site);
        begins_.push_back(static_cast<std::uint32_t>(sites_.size()));
        return {static_cast<std::uint32_t>(size() - 1)};
    }
    /// Another site of a form. It is listed after settle() only.
    void join(FormId form, Site site) { joined_.emplace_back(form, site); }
    void settle();

    std::span<const Site> operator[](FormId f) const {
        return {sites_.data() + begins_[f.value], sites_.data() + begins_[f.value + 1]};
    }
    std::size_t size() const { return begins_.size() - 1; }
    /// Pre: settled.
    bool has_shared_forms() const { return sites_.size() > size(); }
    IdVector<FormId, Site>::IdRange ids() const { return {static_cast<std::uint32_t>(size())}; }

private:
    std::vector<Site> sites_;
    std::vector<std::uint32_t> begins_{0};
    std::vector<std::pair<FormId, Site>> joined_;
};

/// Bounds on how far things have moved that are decided about, lengths.
struct SceneMoves {
    /// Anything of the scene within the box: the base and the sides of the box with the motion, planes by the
    /// rounding of |n|, which scales distances from them.
    double all = 0;
    /// Planes against each other, and balls and tubes: by the rounding of |n| alone, unless planes turn with
    /// a plane base.
    double apart = 0;
    /// What gives way to two others where it ties with them: where it is the nearest, but for that, distances
    /// from these differ by no more from those from the base.
    double ties = 0;
};

/// Bounds that hold for both.
inline SceneMoves most(const SceneMoves& a, const SceneMoves& b) {
    return {std::max(a.all, b.all), std::max(a.apart, b.apart), std::max(a.ties, b.ties)};
}

/// What is asked of a scene over every base; all numbers in the scene's unit of length.
struct BaseProblem {
    BaseFrame frame;
    BaseChart chart;
    /// Plane: a convex polygon, counter-clockwise. Cylinder: the rectangle of the chart; sides 0 and 2 are
    /// its ends, the others its seam. Sphere: none.
    std::vector<RegionSide> region;
    FormFamily family;
    /// Several of a form where objects coincide as seen from the base (duplicates, a plane whose bisector is
    /// the box side). Hidden objects have none: at best they tie with what hides them.
    FormSites sites;
    double unit = 1;  ///< of the scene's lengths, for messages
    SceneMoves moves;
    std::vector<std::string> warnings;  ///< merged duplicates; objects behind the base, or hidden
};

}  // namespace vcell
