#include "canonical.hpp"

#include <bit>
#include <cmath>
#include <variant>

#include "../../core/errors.hpp"
#include "../objects/exact_space.hpp"

namespace vcell {

std::array<BoxSide, 6> canonical_box(const Box& box, const BaseFrame& frame) {
    std::array<BoxSide, 6> sides;
    for (std::uint32_t s = 0; s < 6; ++s) {
        const Eigen::Index axis = s / 2;
        const Vec3 m = frame.rotation.col(axis);
        if (s % 2 == 0)
            sides[s] = {-m, frame.origin[axis] - box.min[axis], s};
        else
            sides[s] = {m, box.max[axis] - frame.origin[axis], s};
    }
    return sides;
}

// By what part |n| and its length as it is kept differ, twice.
static double excess_of_length(const ExactVector& n) {
    const Exact square = dot(n, n), length = length_of(n), excess = length * length - square;
    return std::abs(nearest(excess)) / nearest(square);
}

// With the length L as it is kept distances from the plane are |n| / L times as long.
double moved_by_length(const Plane& plane, const Box& box) {
    const Vec3 normal = scaled_axis(plane.normal);
    const ExactVector n(normal);
    const double part = excess_of_length(n);
    if (part == 0) return 0;
    const double farthest =
        (box.max - box.min).norm() +
        std::abs(normal.dot(0.5 * box.min + 0.5 * box.max - plane.point)) / nearest(length_of(n));
    return part * farthest;
}

// The sine of half a cone's angle is told with its axis' length: where that is off by a part the wall turns
// by this times the tangent, about the apex.
static double moved_by_length(const HollowCone& cone, const Box& box) {
    const ExactVector axis(scaled_axis(cone.axis));
    return excess_of_length(axis) * cone.sine() / cone.cosine() *
           ((box.max - box.min).norm() + (0.5 * box.min + 0.5 * box.max - cone.apex).norm());
}

double moved_by_lengths(const Scene& scene) {
    double moved = 0;
    for (const Object& object : scene.objects) {
        if (const auto* plane = std::get_if<Plane>(&object))
            moved = std::max(moved, moved_by_length(*plane, scene.box));
        if (const auto* cone = std::get_if<HollowCone>(&object))
            moved = std::max(moved, moved_by_length(*cone, scene.box));
    }
    return moved;
}

Vec3 scaled_axis(const Vec3& axis) {
    int exponent = 0;
    std::frexp(axis.cwiseAbs().maxCoeff(), &exponent);
    return axis.unaryExpr([&](double x) { return std::ldexp(x, -exponent); });
}

// Open addressing [Knuth98, section 6.4].
std::vector<std::uint32_t> first_equal(std::span<const Ball> balls) {
    constexpr std::uint32_t none = UINT32_MAX;
    std::vector<std::uint32_t> table(std::bit_ceil(2 * balls.size() + 1), none), first(balls.size());
    const std::size_t mask = table.size() - 1;
    for (std::uint32_t i = 0; i < balls.size(); ++i) {
        std::uint64_t hash = 0;
        for (const double x : {balls[i].cx, balls[i].cy, balls[i].cz, balls[i].rho}) {
            // x + 0 makes -0 hash like 0. The rest is a multiply-xorshift mixing step.
            hash = (hash ^ std::bit_cast<std::uint64_t>(x + 0.0)) * 0x9e3779b97f4a7c15u;
            hash ^= hash >> 32;
        }
        std::size_t slot = hash & mask;
        while (table[slot] != none && !(balls[table[slot]] == balls[i])) slot = (slot + 1) & mask;
        if (table[slot] == none) table[slot] = i;
        first[i] = table[slot];
    }
    return first;
}

int compare_rays(std::span<const Exact> p, std::span<const Exact> q) {
    for (std::size_t i = 0; i < p.size(); ++i) {
        const Sign sp = p[i].sign(), sq = q[i].sign();
        if (sp != sq) return sp < sq ? -1 : 1;
        if (sp == Sign::Zero) continue;
        for (std::size_t j = i + 1; j < p.size(); ++j) {
            const Sign s = (p[j] * q[i] - q[j] * p[i]).sign() * sp;
            if (s != Sign::Zero) return static_cast<int>(s);
        }
        return 0;
    }
    return 0;
}

void fail_empty(const std::string& what) {
    throw InputError(InputError::Kind::EmptyBox, InputError::no_object, "box", what);
}

std::string listed(const std::vector<std::string>& items) {
    constexpr std::size_t named = 8;
    std::string text;
    for (std::size_t i = 0; i < std::min(named, items.size()); ++i) text += (i > 0 ? ", " : "") + items[i];
    if (items.size() > named) text += " and " + std::to_string(items.size() - named) + " more";
    return text;
}

}  // namespace vcell
