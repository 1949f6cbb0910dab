// Patches of bisectors with tips over a cylinder base, about the axis of the object.
#include <cmath>
#include <variant>

#include "../../primitives/bases/axial_terms.hpp"
#include "radial_patch.hpp"
#include "radial_patch_terms.hpp"

namespace vcell {

using namespace radial_patch_terms;

namespace {

// The letters of radial_patch.hpp.
struct Wall {
    Vec3 axis;
    double S = 0, K = 1;

    explicit Wall(const Object& object) {
        if (const auto* cone = std::get_if<HollowCone>(&object)) {
            axis = cone->axis.stableNormalized();
            S = cone->sine();
            K = cone->cosine();
            return;
        }
        const auto* vessel = std::get_if<HollowCylinder>(&object);
        if (vessel == nullptr) K = -1;
        axis = (vessel != nullptr ? vessel->axis : std::get<Cylinder>(object).axis).stableNormalized();
    }
};

// The weight in a tip, which is there in the direction u from the base's axis b: constant + e.along, where
// |along| is the constant but for rounding.
struct WeightAtTip {
    double constant;
    Vec3 along;
};
WeightAtTip weight_at_tip(const Wall& wall, const BisectorTip& tip, const Vec3& b) {
    const auto& [a, S, K] = wall;
    // 1 - a.b, without cancellation.
    const double less = 0.5 * (a - b).squaredNorm(), ua = tip.u.dot(a);
    return {(1 - K) + K * less - S * ua, (less - (1 - K)) * tip.u + (ua - S) * b};
}

}  // namespace

std::array<TipLine, 2> tip_lines(const RadialBaseProblem& problem, FormId form, const BisectorTip& tip) {
    const Wall wall(problem.objects[form]);
    const auto& [a, S, K] = wall;
    std::array<TipLine, 2> both;
    for (const int i : {0, 1}) {
        const Vec3 b = i == 0 ? Vec3(Vec3::UnitY()) : Vec3(-Vec3::UnitY());
        const Vec3 along = weight_at_tip(wall, tip, b).along, e = (a * a.dot(along) - along).normalized();
        TipLine& line = both[i] = {e, {}};
        // In the half plane of e: n falls by one, the distance from the wall and that from the base's axis,
        // where l, and y as much, grow by rise.
        const Vec3 g = K * a + S * e, n = S * a - K * e;
        const double bn = b.dot(n), rise = -2 * bn / (g - b).squaredNorm();
        if (!((rise * g - n).dot(e) > 0)) continue;
        line.beyond = {
            {across_y(bn * g).normalized(), across_y(n - 2 * bn / (g + b).squaredNorm() * g).normalized()}};
    }
    return both;
}

RadialPatch RadialPatch::around_tip(const RadialBaseProblem& problem, FormId form, const BisectorTip& tip,
                                    const Vec3& middle, bool is_beyond) {
    const Object& object = problem.objects[form];
    const Wall wall(object);
    const auto& [a, S, K] = wall;
    const auto [up, down] = tip_lines(problem, form, tip);
    const bool is_up = (up.across.dot(middle) < down.across.dot(middle)) != is_beyond;
    const Vec3 b = is_up ? Vec3(Vec3::UnitY()) : Vec3(-Vec3::UnitY()), o = tip.point(),
               x = radial_patch_terms::across(a, middle);
    RadialPatch patch;
    patch.set_degree(2, 2, Terms::Product);
    patch.set_axes(Kind::AboutObject, x, is_vessel(object) ? a.cross(x) : x.cross(a), o);
    const Vec3& y = patch.axes_[1];
    // v in a unit that makes it about a length, of a mean over all directions, which grows along the face as
    // it does in a vessel.
    const double unit = std::copysign(std::sqrt((K * a - b).squaredNorm() + S * S), K);
    patch.along_ = (K * a - b) / unit;
    patch.along_start_ = -patch.along_.dot(o);
    patch.along_across_ = S / unit;
    patch.set_coordinates(K < 0 ? PatchCoordinate::half_angle(o, x, y, -tip.reach)
                                : PatchCoordinate::hollow_half_angle(o, x, y, tip.reach, a, S, K));
    const Vec3 along = a / K - b;
    patch.coordinates_[1].numerator << along / unit, -S / (K * unit),
        (S / K * tip.reach - along.dot(o)) / unit;

    const auto times_direction = [&](const Vec3& p) -> Polynomial {
        const double along_x = p.dot(x);
        return {along_x, 2 * p.dot(y), -along_x};
    };
    const WeightAtTip at_tip = weight_at_tip(wall, tip, b);
    const double c = a.dot(b), per_reach = unit / tip.reach, half = 0.5 * unit * per_reach;
    const Polynomial turn = times_direction(b), across{0, unit * (S - tip.u.dot(a)), -half * (K + c)};
    const Vector4d from = vector(o) + weight, along_a = vector(a);
    patch.add(angle_weight, {at_tip.constant, -S * c * per_reach, 0}, from);
    patch.add(times_direction(at_tip.along), one, from);
    patch.add(turn, {0, K * per_reach, 0}, from);
    patch.add(angle_cos, across, vector(x));
    patch.add(angle_sin, across, vector(y));
    patch.add(angle_weight, {0, K * unit, S * half}, along_a);
    patch.add(times_direction(tip.u), {0, unit, 0}, along_a);
    patch.add(turn, {0, 0, half}, along_a);
    return patch;
}

}  // namespace vcell
