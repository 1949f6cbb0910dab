/// The axis of a base tube, cut where it crosses the planes of the box's sides: between them it is on the
/// same side of each. It ends where it is as far beyond a vessel's wall as the tube is wide: rays from beyond
/// own nothing.
#pragma once

#include <array>
#include <limits>
#include <vector>

#include "../core/errors.hpp"
#include "../primitives/bases/canonical.hpp"

namespace vcell {

class AxisParts {
public:
    /// Rays start this far from a side's plane at least, as a part of the box's diagonal. Nearer to it edges
    /// are so small beside their distance from the origin that few digits are left to prove their curves;
    /// where those are too few all the same, the next one is taken.
    static constexpr std::array<double, 3> least_rooms{0x1p-32, 0x1p-26, 0x1p-20};

    /// Where the axis is less far beyond the walls of all vessels than the base's radius, or so little more
    /// that doubles may not tell: beyond these heights rays own nothing. Infinite where there is no such
    /// place.
    struct Within {
        std::array<double, 2> ends{-std::numeric_limits<double>::infinity(),
                                   std::numeric_limits<double>::infinity()};
        /// The way along the axis is no more than so many times as long as what the distance from a wall
        /// changes by.
        std::array<double, 2> slants{};
    };
    /// Between two heights; from >= to if there is none.
    static Within within_vessels(const Scene& scene, const Cylinder& base, const BaseFrame& frame,
                                 const std::array<double, 2>& range);

    /// In the frame of a base along y.
    AxisParts(const Box& box, const BaseFrame& frame, const Within& within);

    /// Is a side across the axis, so that rays never reach it?
    static bool is_across(const BoxSide& side) { return side.m.x() == 0 && side.m.z() == 0; }
    /// Where planes across the axis meet the box, and a little more, so that it does not end with an edge of
    /// the box along which two sides tie; but no more where it ends with a side.
    static std::array<double, 2> range(const Box& box, const BaseFrame& frame);

    /// The parts of the range, heights along the axis, ascending.
    const std::vector<std::array<double, 2>>& parts() const { return parts_; }
    /// Calls use(sides of the box that the part is beyond, stretch) for what of a part keeps clear of the
    /// planes at its ends, with more room where that leaves too few digits. Returns the length left out.
    template <class Use>
    double on_clear_stretch(const std::array<double, 2>& part, double diagonal, Use&& use) const {
        for (const double least : least_rooms) {
            const std::array<double, 2> stretch = clear_of_planes(part, least * diagonal);
            if (!(stretch[0] < stretch[1])) break;
            try {
                use(beyond(part), stretch);
                return (part[1] - stretch[1]) + (stretch[0] - part[0]);
            } catch (const UndecidedError&) {
                if (least == least_rooms.back() || stretch == part) throw;
            }
        }
        return part[1] - part[0];
    }

private:
    // What of a part keeps so far clear of the planes at its ends; empty if from >= to.
    std::array<double, 2> clear_of_planes(const std::array<double, 2>& part, double room) const;
    std::array<bool, 6> beyond(const std::array<double, 2>& part) const;

    // A part of the axis ends where it crosses a side's plane, or where the box or a vessel does. The way
    // along the axis is so many times as long as its distance from the plane.
    struct End {
        double y, slant;
    };

    std::array<BoxSide, 6> sides_;
    std::vector<End> ends_;
    std::vector<std::array<double, 2>> parts_;
};

}  // namespace vcell
