/// How far curves and surfaces are from the sides of triangles, and which parameters make triangles round.
#pragma once

#include <vector>

#include "../../core/curves/bspline.hpp"
#include "../../primitives/objects/objects.hpp"

namespace vcell {

/// How far a curve, `at` 0 <= s <= 1, stays away from the segment between its ends, measured at its middle.
/// How fast it is run through is no deviation; but where it is run through so unevenly that its middle is
/// near an end, its quarters tell, too.
double deviation(const RationalCurve3& curve, double from, double to);

/// How far the patch rises over the side from a to b, straight in space, measured at the middle of its
/// parameters along the normal there: how the side lies on the surface makes no difference to that. Where the
/// middle is far from that of the side, the quarters tell, too.
double deviation(const RationalPatch& s, const Vec2& a, const Vec2& b);

/// Does the patch's image of the side from a to b, straight in parameters, leave the segment between its ends
/// by more than `chord` and by more than an eighth of its length? Along a face's boundary it must not,
/// however it lies on the surface: what is beyond is not the face's.
bool strays(const RationalPatch& s, const Vec2& a, const Vec2& b, double chord);
/// Does the image of a curve of parameters leave the segment between its ends so far?
bool strays(const RationalPatch& s, const RationalCurve2& curve, double from, double to, double chord);

/// A face that is folded sharply has patches that are strips between seams, which are sides of their
/// parameters' rectangles and may be far nearer to each other than a chord. Does the image of a piece of a
/// seam leave the segment between its ends by more than half the way to the other side, so that segments on
/// both sides may cross? Three places tell.
bool leaves_strip(const RationalPatch& s, const RationalCurve2& seam, double from, double to);

/// Between two parameters of a line that `place` tells in space, the one that is about as far from both ends
/// there, however unevenly the line is run through.
template <class Place>
double middle_in_space(double from, double to, const Place& place) {
    const Vec3 begin = place(from), end = place(to);
    constexpr int halvings = 12;
    for (int i = 0; i < halvings; ++i) {
        const double middle = 0.5 * (from + to);
        const Vec3 p = place(middle);
        ((p - begin).squaredNorm() < (p - end).squaredNorm() ? from : to) = middle;
    }
    return 0.5 * (from + to);
}

/// Parameters turned and stretched so that triangles that are round in them are about as round in space: a
/// linear map whose square is the patch's metric, each place's of determinant 1, in the mean of these places.
/// The identity where that is not worth the rounding.
Eigen::Matrix2d rounding_map(const RationalPatch& s, const std::vector<std::vector<Vec2>>& loops);

}  // namespace vcell
