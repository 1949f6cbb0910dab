/// The excess of sites (space.hpp) all over a curve or a patch.
///
/// With homogeneous coordinates every squared distance is a polynomial, and so are the equations of all
/// bisectors: where a curve lies on one, the equation's coefficients vanish up to rounding, and the bound is
/// as small as that without any subdivision.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "nets.hpp"
#include "space.hpp"

namespace vcell::check {

class ExcessAlong {
public:
    /// Keeps references.
    ExcessAlong(const Space<Interval>& space, const Net& net);

    /// Encloses the excess everywhere on the net.
    Interval excess(const Condition& condition) const;
    /// The square of the distance from what a ball or tube is about less that from what the base is about,
    /// all over the net: it is 0 where the excess is. None but of a twin of the base, of its radius.
    std::optional<Interval> squares_of_twin(std::uint32_t object) const;
    /// The excess of c less that of d, of two objects of one kind: as small as they are apart.
    std::optional<Interval> excess_difference(const Condition& c, const Condition& d) const;

private:
    using Surface = check::Surface<Interval>;

    Vector<MidRad> way(const Surface& s) const;
    Form signed_distance(const Surface& plane) const;
    Form squared_distance(const Surface& round) const;
    Interval object_excess(const Surface& object) const;
    std::optional<Interval> difference_of_planes(const Condition& c, const Condition& d) const;
    Form squared_difference(const Surface& first, const Surface& second,
                            const std::optional<std::array<Vector<Interval>, 2>>& axes) const;
    std::optional<Interval> difference_of_cones(const Condition& c, const Condition& d) const;
    std::optional<Interval> difference_of_round(const Condition& c, const Condition& d) const;
    std::optional<Interval> excess_of_twin(std::uint32_t object) const;
    std::optional<Interval> squares_of(std::uint32_t twin) const;
    Interval above_plane(const Surface& object) const;
    Interval of_plane(const Surface& object) const;
    Interval of_round(const Surface& object) const;
    Interval in_vessel(const Surface& object) const;
    Interval in_cone(const Surface& object) const;

    const Space<Interval>& space_;
    const Net& net_;
    Vector<Form> position_;  // about the net's origin
    Form weight_;
    Interval w_;
    // Of the base: the signed distance times the weight from a plane, the squared distance from a centre or
    // an axis times the squared weight.
    Form base_;
    Interval clearance_;
};

}  // namespace vcell::check
