#include "tip_sectors.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "../../core/errors.hpp"
#include "../../primitives/fit/arc_equations.hpp"
#include "../../primitives/objects/message.hpp"
#include "radial_patch.hpp"

namespace vcell::radial {

namespace {

using std::numbers::pi;

double turn_between(double from, double to) { return std::remainder(to - from, 2 * pi); }

// Does the face reach over the direction in which the line beyond the base's axis lies? By as much as some
// faces are off.
bool reaches(const CylinderTurns& turns, const CylinderTurns::Extent& extent, const Vec3& direction) {
    const double off = std::abs(turn_between(extent.middle(), turns.angle(direction)));
    return extent.is_closed || off <= 0.5 * extent.width() + 0x1p-10;
}

// How far from the half plane of the lines the face keeps on the plane between them.
double angle_kept(const RadialDiagram& of, FormId form, const TipLine& line, const ObjectAxis& axis,
                  const CylinderTurns::Extent& extent) {
    const auto equation =
        space_fit::site_equation(of.problem.chart, of.problem.objects[form], false, Vec3::Zero());
    const Vec3 normal = Vec3::UnitY().cross(line.beyond->inwards);
    double least = pi;
    for (const double y : {extent.lowest, extent.highest})
        for (const Vec3& n : {normal, Vec3(-normal)}) {
            const Vec3 foot(0, y, 0), p = foot + equation.distance_along(foot, n) * n;
            least = std::min(least, std::abs(turn_between(axis.angle_of(line.across), axis.angle(p))));
        }
    return least;
}

}  // namespace

std::vector<SectorRange> tip_sectors(const RadialDiagram& of, FormId form, const BisectorTip& tip,
                                     const ObjectAxis& axis, const CylinderTurns& turns,
                                     const CylinderTurns::Extent& extent) {
    // Of a sector with two patches, in radians; the widest as a part of the half that holds it.
    constexpr double narrowest = 0x1p-20, widest = 0.25;
    const std::array<TipLine, 2> lines = tip_lines(of.problem, form, tip);
    const double first = axis.angle_of(-lines[0].across),
                 start = first + 0.5 * turn_between(first, axis.angle_of(-lines[1].across));
    std::vector<SectorRange> sectors;
    for (const int half : {0, 1}) {
        const double from = start + half * pi, to = from + pi;
        // One of both is in this half.
        const auto in_half = std::ranges::min_element(lines, {}, [&](const TipLine& line) {
            return std::abs(turn_between(0.5 * (from + to), axis.angle_of(line.across)));
        });
        if (!in_half->beyond || !reaches(turns, extent, in_half->beyond->normal)) {
            sectors.push_back({from, to});
            continue;
        }
        const double at = 0.5 * (from + to) + turn_between(0.5 * (from + to), axis.angle_of(in_half->across)),
                     kept = angle_kept(of, form, *in_half, axis, extent),
                     off = std::min({0.5 * kept, widest * (at - from), widest * (to - at)});
        if (!(off > narrowest))
            throw UndecidedError("object " + to_string(of.main_site(form)) +
                                 ": its face reaches around the base next to where that ends at it, and has "
                                 "measures, but no patches");
        sectors.push_back({from, at - off, true});
        sectors.push_back({at - off, at + off, false, in_half->beyond->inwards});
        sectors.push_back({at + off, to, true});
    }
    return sectors;
}

}  // namespace vcell::radial
