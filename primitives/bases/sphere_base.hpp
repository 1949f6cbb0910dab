/// Sphere bases: the scene in canonical position. See radial_base.hpp.
#pragma once

#include <array>
#include <memory>
#include <optional>

#include "radial_base.hpp"

namespace vcell {

/// radial_base_problem() of a scene whose base is this sphere.
RadialBaseProblem sphere_base_problem(const Scene& scene, const Sphere& base, double unit);

/// The problem of a ball among balls in a box, which takes more of them. Throws as radial_base_problem().
class GrowingSphereProblem {
public:
    /// Pre: validate(scene) would pass; the base is a sphere, and so are all objects.
    GrowingSphereProblem(const Scene& scene, double unit);

    const RadialBaseProblem& problem() const { return problem_; }
    /// A ball competes, too. False where its form is no common one or may be one of the others': the problem
    /// is as before. The chart's pole is where it was. Pre: neither ball holds the other, nor are any two
    /// equal.
    bool add(const Sphere& ball, Site site);
    /// The sign of a form less three others in a point in which these tie, at values of that sign, not Zero.
    /// Exact; none where numbers of a fixed width are not enough for it.
    std::optional<Sign> tie_sign(FormId form, const std::array<FormId, 3>& tied, Sign value) const;
    /// Do three forms tie all along a circle? Exact; none likewise. Pre: no two of them are equal.
    std::optional<bool> tie_along(const std::array<FormId, 3>& forms) const;

private:
    struct Growth;

    RadialBaseProblem problem_;
    std::shared_ptr<Growth> growth_;
};

}  // namespace vcell
