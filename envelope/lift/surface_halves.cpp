#include "surface_halves.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <variant>

#include "cylinder_turns.hpp"
#include "joined_spans.hpp"

namespace vcell::radial {

namespace {

using Eigen::Vector4d;

// How far from the middle a plane may be, as a part of the semiaxis: the degrees are 6 at most then. What is
// farther out a patch about the opposite pole holds as well.
constexpr double farthest = 0.4;

// The heights at which an edge begins, ends and turns back. Before it is fitted its pieces tell a spline's.
template <class Use>
void turning_points(const RadialDiagram& of, const RadialCurves& curves, EdgeId e, const LongAxis& axis,
                    Use&& use) {
    const auto along = [&](const Vector4d& p) { return axis.height(p.head<3>()); };
    if (curves.has_ends(e)) {
        use(along(curves.from(e)));
        use(along(curves.to(e)));
    }
    if (curves.is_line(e)) return;
    Range range = empty_range;
    const auto extend_to = [&](double height) {
        range = {std::min(range[0], height), std::max(range[1], height)};
    };
    if (!curves.is_spline(e))
        for (const ConicSpan& s : curves.conics(e))
            extend(range, along(s.from), along(s.middle / s.weight), along(s.to), s.weight);
    else if (curves.splines(e).empty())
        for (const auto& piece : of.diagram.pieces(e))
            extend_to(axis.height_towards(of.problem.chart.normal(piece.end)));
    else
        for (const SpaceSpan& s : curves.splines(e))
            for (int k = 0; k < 6; ++k) extend_to(along(s.points.col(k).head<4>()));
    use(range[0]);
    use(range[1]);
}

}  // namespace

LongAxis::LongAxis(const RadialBaseProblem& problem, FormId form) {
    const auto& vessel = std::get<HollowSphere>(problem.objects[form]);
    const double foci = vessel.center.norm(), sum = vessel.radius + problem.chart.radius;
    center = 0.5 * vessel.center;
    pole = foci > 0 ? Vec3(-vessel.center / foci) : Vec3(Vec3::UnitZ());
    length = 0.5 * sum;
    reach = std::sqrt((sum + foci) / (sum - foci));
}

// The square of its radius over that in the middle is that of (1 - height) / (1 + height).
double LongAxis::height_towards(const Vec3& u) const {
    const double along = pole.dot(u), far = (1 + along) * reach * reach, near = 1 - along;
    return (far - near) / (far + near);
}

SurfaceHalves::SurfaceHalves(const RadialDiagram& of, const FaceLoops& loops, const RadialCurves& curves,
                             FaceId face, std::size_t attempt)
    : axis_(of.problem, of.diagram.face_forms[face]) {
    std::vector<double> heights{-farthest, farthest};
    loops.around(face, [&](EdgeId e, bool) {
        turning_points(of, curves, e, axis_, [&](double height) {
            if (std::abs(height) < farthest) heights.push_back(height);
        });
    });
    std::ranges::sort(heights);
    std::vector<Range> gaps;
    for (std::size_t i = 1; i < heights.size(); ++i) gaps.push_back({heights[i - 1], heights[i]});
    std::ranges::stable_sort(gaps, std::greater(), [](const Range& gap) { return gap[1] - gap[0]; });
    const Range& gap = gaps[attempt % gaps.size()];
    height_ = std::lerp(gap[0], gap[1], off_middle);
    const FormId form = of.diagram.face_forms[face];
    patches_ = {RadialPatch(of.problem, form, axis_.pole, 0), RadialPatch(of.problem, form, -axis_.pole, 0)};
}

SpacePart SurfaceHalves::part(std::uint32_t half) const {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    const double before = height_ * axis_.length;
    return {.patch = patches_[half].coordinates(),
            .across = PatchCoordinate::linear(axis_.pole, axis_.center),
            .range = half == 0 ? Range{before, infinity} : Range{-infinity, before},
            .surface = &patches_[half]};
}

// A root of a (1 - s)^2 + 2 b (1 - s) s + c s^2 is a positive root x = s / (1 - s) of a + 2 b x + c x^2. Next
// to an end it is the end.
std::optional<double> SurfaceHalves::crossing(const ConicSpan& span) const {
    constexpr double near = 0x1p-32;
    const auto above = [&](const Vector4d& p, double weight) {
        return axis_.pole.dot(p.head<3>() - weight * axis_.center) - weight * height_ * axis_.length;
    };
    const double a = above(span.from, 1), b = above(span.middle, span.weight), c = above(span.to, 1),
                 square = b * b - a * c, h = -(b + std::copysign(std::sqrt(square), b));
    std::optional<double> first;
    for (const double x : {h / c, a / h})
        if (x > near && x < 1 / near && !(first && *first < x)) first = x;
    if (first) *first /= 1 + *first;
    return first;
}

void SurfaceHalves::add_divided(const ConicSpan& span, std::vector<ConicSpan>& spans) const {
    constexpr int most = 2;  // a plane crosses a conic no more often
    ConicSpan rest = span;
    for (int i = 0; i < most; ++i)
        if (const auto place = crossing(rest)) {
            const auto [before, after] = rest.parts(*place);
            spans.push_back(before);
            rest = after;
        }
    spans.push_back(rest);
}

// Both halves see the point in one direction, each in axes of its own.
Vec2 SurfaceHalves::at(double angle, std::uint32_t half) const {
    const auto &first = patches_[0].axes(), &own = patches_[half].axes();
    const Vec3 u = std::cos(angle) * first[0] + std::sin(angle) * first[1];
    return radius(half) * Vec2(u.dot(own[0]), u.dot(own[1]));
}

}  // namespace vcell::radial
