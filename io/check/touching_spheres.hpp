/// Spheres about the points of a curve or a patch that touch the base, and what is left between them and
/// other balls and planes: Laguerre's geometry of oriented spheres.
///
/// With p the center and t the radius of such a sphere, and s = |p - c| the distance from a ball's center,
/// the ball's excess is e = s - (t + rho), and
///     F(p, t) = |p - c|^2 - (t + rho)^2 = e (s + t + rho)
/// has its sign. The difference of two such F is linear in (p, t): where one is known, of the base or of the
/// ball that owns the curve, so are all others, by as many coefficients as there are control points, if t is
/// rational with the curve's weights. Over a base plane it is linear in p. Beside a base ball it is linear in
/// p on every bisector with a ball of another radius or with a plane, and a quotient of polynomials along the
/// conics in which two bisectors meet.
#pragma once

#include <optional>

#include "nets.hpp"
#include "space.hpp"
#include "sphere_net.hpp"
#include "tangential.hpp"

namespace vcell::check {

class TouchingSpheres {
public:
    /// Along a span of an edge. None: clearances are no such quotient there, or it cannot be told. Keeps a
    /// reference to the space's scene.
    static std::optional<TouchingSpheres> along(const Net& curve, const Space<Interval>& space);
    /// On a patch of a site's bisector.
    static std::optional<TouchingSpheres> on(const Net& patch, const Site& own, const Space<Interval>& space);

    /// On a patch of the bisector of a base ball and a ball of another radius, inside loops that stay within
    /// `reach` of the base's center: known of it are the upper end of the clearance and growth(). Where the
    /// patch runs far beyond its loops, on() may know nothing.
    struct Inside;
    static std::optional<Inside> inside(const Net& patch, const Site& own, const Space<Interval>& space,
                                        double reach);

    /// Of all points.
    const Interval& clearance() const { return clearance_; }

    /// Do coefficients tell little of the clearances? A patch that is strongly bent, or runs far beyond its
    /// loops, is better told of in parts.
    bool is_bent() const { return is_bent_; }

    /// Takes the ball, if it is one, for the one of which others differ: over a base plane nothing is known
    /// of balls before. False: it is none.
    bool refer_to(const Site& ball);

    /// Bounds the excess all over the curve. None: of a tube, or it cannot be told.
    std::optional<Interval> excess(const Condition& c) const;
    /// A lower bound of F of a ball, or of a plane's excess, above which both are positive.
    std::optional<double> least(const Site& object) const;

    /// Is an object farther than the base within `margin` of the curve, too?
    bool is_farther(const Site& object, double margin) const;
    /// Of two balls, one that owns the patch: can the other's excess be negative and least within `margin` of
    /// it (least.hpp)? Surely not where its center is behind the patch, as seen from the own one and from the
    /// base.
    bool may_be_least(const Sphere& own, const Sphere& rival, double margin) const;

    /// Bounds, in the points within `margin` of those where two sites' excesses are below `size`, the least
    /// singular value of the derivative of both, and half the squared gradient of either. Sides of the box
    /// are sites here, rims are none.
    std::optional<Slopes> slopes(const Site& a, const Site& b, double size, double margin) const;
    /// The same of one.
    std::optional<double> growth(const Site& a, double size, double margin) const;

private:
    using Linear = SphereNet::Linear;
    /// A segment as seen from a ball's center, and how far off the distance from it is.
    struct Line {
        Vec3 way, across;             ///< its direction, and that from the center to it
        std::array<double, 2> sines;  ///< of the angles between `across` and the ends
        Vec3 direction(double sine) const;
    };
    TouchingSpheres(const SphereNet& net, const Space<Interval>& space) : space_(&space), net_(net) {}
    bool set_height();
    bool set_distance_at_three_places();
    bool set_distance_along_line();
    bool set_distance_within(const Interval& clearance);
    void refer_to_base();
    bool set_distance_by_square();
    bool finish(SphereNet::LeastSum sum);
    Oriented base() const;
    std::optional<Oriented> element(const Site& site) const;
    std::optional<Linear> plane_excess(const Site& plane) const;
    double least_of(const Linear& f) const;

    const Space<Interval>* space_;
    SphereNet net_;
    std::optional<Line> line_;  // along a line about a sphere
    bool is_bent_ = false;
    Interval clearance_;
    Vec3 reference_center_;  // F of the reference is within reference_error_ of 0
    double reference_radius_ = 0, reference_error_ = 0;
    bool has_reference_ = false;
};

struct TouchingSpheres::Inside {
    TouchingSpheres spheres;
    double excess;  ///< of the own site, at most
};

}  // namespace vcell::check
