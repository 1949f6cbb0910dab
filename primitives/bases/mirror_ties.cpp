#include "mirror_ties.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "../forms/axial_ties.hpp"
#include "../objects/exact_space.hpp"
#include "canonical.hpp"

namespace vcell {

namespace {

constexpr double rounding = 0x1p-40;  // of coordinates, where doubles only find what exact numbers judge

Vec3 rounded(const ExactVector& v) { return {nearest(v.x), nearest(v.y), nearest(v.z)}; }

// What a way has across a direction, times the square of that.
ExactVector across(const ExactVector& way, const ExactVector& direction) {
    return dot(direction, direction) * way - dot(direction, way) * direction;
}

// The mirror between the base and a tube along it: V = D w, with w the way between the axes.
struct Mirror {
    ExactVector a, V;
    Exact D, square;

    Mirror(const Cylinder& base, const Cylinder& tube) : a(base.point) {
        const ExactVector d(scaled_axis(base.axis));
        D = dot(d, d);
        V = across(ExactVector(tube.point) - a, d);
        square = dot(V, V);
    }
    // Twice how far a point is behind it, times D |V|.
    Exact behind(const ExactVector& p) const { return Exact(2) * (D * dot(p - a, V)) - square; }

    // What x is off the image of y, times D V^2; none where y is not on the base's side.
    std::optional<ExactVector> off(const ExactVector& y, const ExactVector& x) const {
        const Exact h = behind(y);
        if (h.sign() != Sign::Negative) return std::nullopt;
        return square * D * (x - y) + h * V;
    }

    std::optional<double> move(const Sphere& y, const Sphere& x) const {
        if (y.radius != x.radius) return std::nullopt;
        const auto o = off(ExactVector(y.center), ExactVector(x.center));
        return o ? std::optional(length(*o, square * D)) : std::nullopt;
    }
    std::optional<double> move(const Cylinder& y, const Cylinder& x) const {
        const ExactVector e(scaled_axis(y.axis));
        if (y.radius != x.radius || dot(e, V).sign() != Sign::Zero ||
            !cross(e, ExactVector(scaled_axis(x.axis))).is_zero())
            return std::nullopt;
        const auto o = off(ExactVector(y.point), ExactVector(x.point));
        return o ? std::optional(length(across(*o, e), square * D * dot(e, e))) : std::nullopt;
    }
    std::optional<double> move(const Object& y, const Object& x) const {
        if (const auto* a_ball = std::get_if<Sphere>(&y), *other = std::get_if<Sphere>(&x); a_ball && other)
            return move(*a_ball, *other);
        if (const auto* a_tube = std::get_if<Cylinder>(&y), *other = std::get_if<Cylinder>(&x);
            a_tube && other)
            return move(*a_tube, *other);
        return std::nullopt;
    }

private:
    static double length(const ExactVector& v, const Exact& scale) {
        return v.is_zero() ? 0 : (1 + rounding) * rounded(v).norm() / nearest(scale);
    }
};

// A place that an object has by itself: of a tube the foot of the origin on its axis. None: it takes no part.
std::optional<Vec3> place_of_mirrored(const Object* object) {
    if (object == nullptr) return std::nullopt;
    if (const auto* ball = std::get_if<Sphere>(object)) return ball->center;
    const auto* tube = std::get_if<Cylinder>(object);
    if (tube == nullptr) return std::nullopt;
    const Vec3 along = tube->axis.stableNormalized();
    return Vec3(tube->point - along.dot(tube->point) * along);
}

// Keeps the ties, exact ones first, by which nothing is hidden by what it hides: each of two twins may be all
// but the image of a twin of the base in the mirror of the other.
std::vector<MirrorTie> without_cycles(std::vector<MirrorTie> ties) {
    std::ranges::stable_sort(ties, {}, &MirrorTie::off);
    std::map<std::uint32_t, std::vector<std::uint32_t>> hidden_by;
    const auto depends = [&](std::uint32_t object, std::uint32_t on) {
        std::vector<std::uint32_t> open{object};
        std::set<std::uint32_t> seen;
        while (!open.empty()) {
            const std::uint32_t next = open.back();
            open.pop_back();
            if (next == on) return true;
            const auto by = hidden_by.find(next);
            if (by == hidden_by.end() || !seen.insert(next).second) continue;
            open.insert(open.end(), by->second.begin(), by->second.end());
        }
        return false;
    };
    std::erase_if(ties, [&](const MirrorTie& tie) {
        if (depends(tie.mirrored, tie.hidden) || depends(tie.mirror, tie.hidden)) return true;
        auto& by = hidden_by[tie.hidden];
        by.insert(by.end(), {tie.mirrored, tie.mirror});
        return false;
    });
    return ties;
}

}  // namespace

std::vector<MirrorTie> find_mirror_ties(const Cylinder& base, std::span<const Object* const> objects,
                                        double most) {
    struct Place {
        double key;
        std::uint32_t object;
    };
    // In the order of what they are along some direction: images are found by it.
    const Vec3 direction = Vec3(1, 0.618, 0.382).normalized(), axis = base.axis.stableNormalized();
    std::vector<Place> places;
    std::vector<std::uint32_t> mirrors;
    double size = base.point.norm();
    for (std::uint32_t i = 0; i < objects.size(); ++i) {
        const auto place = place_of_mirrored(objects[i]);
        if (!place) continue;
        places.push_back({direction.dot(*place), i});
        size = std::max(size, place->norm());
        const auto* tube = std::get_if<Cylinder>(objects[i]);
        if (tube == nullptr || tube->radius != base.radius) continue;
        size = std::max(size, tube->point.norm());
        if (cross(ExactVector(scaled_axis(tube->axis)), ExactVector(scaled_axis(base.axis))).is_zero())
            mirrors.push_back(i);
    }
    constexpr std::size_t most_mirrors = 64;
    if (mirrors.size() > most_mirrors) return {};
    std::ranges::sort(places, {}, &Place::key);

    // How far a tube is from being the base's twin.
    const auto off_base = [&](const Object& mirrored) {
        const auto* tube = std::get_if<Cylinder>(&mirrored);
        if (tube == nullptr) return size;
        const Vec3 way = tube->point - base.point;
        return way.cross(axis).norm() + size * tube->axis.stableNormalized().cross(axis).norm();
    };
    std::vector<MirrorTie> ties;
    const double slack = most + rounding * size;
    for (const std::uint32_t t : mirrors) {
        const auto& tube = std::get<Cylinder>(*objects[t]);
        const Vec3 apart = tube.point - base.point, w = apart - axis.dot(apart) * axis;
        std::optional<Mirror> exact;
        for (const Place& y : places) {
            if (y.object == t) continue;
            const Object& mirrored = *objects[y.object];
            const auto* as_tube = std::get_if<Cylinder>(&mirrored);
            const Vec3 point = as_tube != nullptr ? as_tube->point : std::get<Sphere>(mirrored).center;
            const double radius = as_tube != nullptr ? as_tube->radius : std::get<Sphere>(mirrored).radius;
            const double behind = 2 * w.dot(point - base.point) - w.squaredNorm();
            if (!(behind < 0)) continue;
            // Twice the way to the mirror, and of a tube's image the foot again.
            Vec3 image = point - behind / w.squaredNorm() * w;
            if (as_tube != nullptr) {
                const Vec3 along = as_tube->axis.stableNormalized();
                if (std::abs(along.dot(w)) > rounding * w.norm()) continue;
                image -= along.dot(image) * along;
            }
            const double key = direction.dot(image), behind_it = std::abs(behind) / w.norm();
            const double least =
                std::min(most, narrow_place * std::min({w.norm(), behind_it, off_base(mirrored)}));
            // Squares of distances from X' and Y differ by |X' - Y| / |w| of what those from T and the base
            // do; next to M the base is |w| / 2 away.
            const double per_move = (1 + rounding) * std::max(1.0, (w.norm() + 2 * radius) / behind_it);
            for (auto x = std::ranges::lower_bound(places, key - slack, {}, &Place::key);
                 x != places.end() && x->key <= key + slack; ++x) {
                if (x->object == t || x->object == y.object ||
                    (*place_of_mirrored(objects[x->object]) - image).norm() > slack)
                    continue;
                if (!exact) exact.emplace(base, tube);
                if (const auto move = exact->move(mirrored, *objects[x->object]); move && *move <= least)
                    ties.push_back({x->object, y.object, t, *move * per_move});
            }
        }
    }
    return without_cycles(std::move(ties));
}

}  // namespace vcell
