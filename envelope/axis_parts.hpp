/// The axis of a base tube, cut where it crosses the planes of the box's sides, and where tubes of its radius
/// cross it: between these places it is on the same side of each side, and of both planes between the tube
/// and each of those. It ends where it is as far beyond a vessel's wall as the tube is wide, and what of it
/// is as deep in a ball or another tube is left out: rays from there own nothing, as distances from the axis
/// grow at least as fast as those from the other object.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "../core/errors.hpp"
#include "../primitives/bases/canonical.hpp"
#include "../primitives/forms/radial_form.hpp"
#include "../primitives/objects/scene.hpp"

namespace vcell {

class AxisParts {
public:
    /// Rays start this far from a side's plane at least, as a part of the box's diagonal. Nearer to it edges
    /// are so small beside their distance from the origin that few digits are left to prove their curves;
    /// where those are too few all the same, the next one is taken.
    static constexpr std::array<double, 3> least_rooms{0x1p-32, 0x1p-26, 0x1p-20};

    /// Next to what holds the base the cell is a needle, of which little is left out: rays start this far
    /// from there at least, likewise, and where that is too near as many times as far as the root of the
    /// above is.
    static constexpr double beside_needle = 0x1p-16;

    /// In the frame of a base along y. Pre: the scene is one as decided.
    AxisParts(const Scene& scene, const Cylinder& base, const Box& box, const BaseFrame& frame);

    /// Is a side across the axis, so that rays never reach it?
    static bool is_across(const BoxSide& side) { return side.m.x() == 0 && side.m.z() == 0; }
    /// Where planes across the axis meet the box, and a little more, so that it does not end with an edge of
    /// the box along which two sides tie; but no more where it ends with a side.
    static std::array<double, 2> range(const Box& box, const BaseFrame& frame);

    /// The parts of the range, heights along the axis, ascending.
    const std::vector<std::array<double, 2>>& parts() const { return parts_; }
    /// Does an object hold cross sections of the base?
    bool are_any_held() const { return !held_.empty(); }
    /// Do the axes of tubes of the base's radius cross its own in the range? It is cut there, too.
    bool are_any_crossed() const { return !crossings_.empty(); }

    /// What of a part is not looked at.
    struct LeftOut {
        double width = 0;   ///< of slabs across the axis, with all that the box has of them
        double volume = 0;  ///< at most; of needles
        double area = 0;    ///< about as much, likewise

        LeftOut& operator+=(const LeftOut& o) {
            width += o.width;
            volume += o.volume;
            area += o.area;
            return *this;
        }
    };
    /// Calls use(sides of the box that the part is beyond, stretch) for what of a part keeps clear of the
    /// planes at its ends, with more room where that leaves too few digits; then it keeps clear of the box's
    /// ends, too, as two sides tie with an object all along an edge there that a plane across the axis meets
    /// the box in. Returns what is left out.
    template <class Use>
    LeftOut on_clear_stretch(const std::array<double, 2>& part, Use&& use) const {
        for (const double least : least_rooms) {
            const double room = least * diagonal_;
            std::array<double, 2> stretch = clear_of_planes(part, least);
            if (least != least_rooms.front()) stretch = within_box(stretch, room);
            if (!(stretch[0] < stretch[1])) break;
            try {
                use(beyond(part), stretch);
                LeftOut sum = left_out_before(part, stretch, AxialEnd::Low);
                return sum += left_out_before(part, stretch, AxialEnd::High);
            } catch (const UndecidedError&) {
                if (least == least_rooms.back() || stretch == part) throw;
            }
        }
        const std::array<double, 2> held = within_box(part, 0);
        return {std::max(0.0, held[1] - held[0])};
    }

private:
    // Where the axis is less far beyond the walls of all vessels than the base's radius, or so little more
    // that doubles may not tell: beyond these heights rays own nothing. Infinite where there is no such
    // place.
    struct Within {
        std::array<double, 2> ends{-std::numeric_limits<double>::infinity(),
                                   std::numeric_limits<double>::infinity()};
        // The way along the axis is no more than so many times as long as what the distance from a wall
        // changes by.
        std::array<double, 2> slants{};
    };
    static Within within_vessels(const Scene& scene, const Cylinder& base, const BaseFrame& frame,
                                 const std::array<double, 2>& range);

    // A ball or tube that holds cross sections of the base: the squared distance of the axis from its centre
    // or axis is apart^2 + lean^2 (y - foot)^2, and its radius is the base's and `deep`.
    struct Holder {
        double foot, apart, lean, deep;

        // Where less than `room` is missing for cross sections to be held.
        std::array<double, 2> reach(double room) const {
            const double half =
                std::sqrt(std::max(0.0, (deep + room - apart) * (deep + room + apart))) / lean;
            return {foot - half, foot + half};
        }
        // Output accuracy: beside one that has less the bounds on what is left out would be of no use.
        static constexpr double least_rest = 0x1p-8;
        // The cell's sections by planes across the axis next to what is held are within ellipses with a focus
        // on the axis. This is 1 less the square of their eccentricity where lean |y - foot| is `off`.
        double rest(double off) const {
            const double across2 = apart * apart + (1 - lean) * (1 + lean) * off * off;
            return 1 - across2 / (deep * deep);
        }
        // What the cell has next to what is held, as far as `beyond` from there.
        LeftOut needle(double beyond) const;
    };
    static std::vector<Holder> holders(const Scene& scene, const Cylinder& base, const BaseFrame& frame);
    void leave_out(const std::array<double, 2>& held);
    void end_at_crossings(const Scene& scene, const Cylinder& base, const BaseFrame& frame);
    LeftOut left_out_before(const std::array<double, 2>& part, const std::array<double, 2>& stretch,
                            AxialEnd end) const;

    // What of a part keeps so far clear of the planes at its ends, in parts of the diagonal, and somewhat
    // farther of holders; empty if from >= to.
    std::array<double, 2> clear_of_planes(const std::array<double, 2>& part, double least) const;
    // What of a part is so far from where the box ends with an edge or a corner.
    std::array<double, 2> within_box(const std::array<double, 2>& part, double room) const {
        return {std::max(part[0], box_ends_[0] + room), std::min(part[1], box_ends_[1] - room)};
    }
    std::array<bool, 6> beyond(const std::array<double, 2>& part) const;

    // A part of the axis ends where it crosses a side's plane or both between crossing axes, or where the box
    // or a vessel does. The way along the axis is so many times as long as its distance from the plane.
    struct End {
        double y, slant;
    };

    double diagonal_;
    std::array<BoxSide, 6> sides_;
    std::array<double, 2> box_ends_;  // infinite where it ends with a side
    std::vector<End> ends_;
    std::vector<End> crossings_;  // of them
    std::vector<Holder> held_;
    std::vector<std::array<double, 2>> parts_;
};

}  // namespace vcell
