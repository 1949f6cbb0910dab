#include "hidden_objects.hpp"

#include <algorithm>
#include <limits>
#include <tuple>
#include <utility>
#include <variant>

#include "../../primitives/bases/cone_form.hpp"
#include "../../primitives/bases/nested_balls.hpp"
#include "../../primitives/bases/solids.hpp"
#include "../../primitives/bases/world_objects.hpp"
#include "../../primitives/objects/exact_space.hpp"
#include "../object_distance.hpp"
#include "other_images.hpp"

namespace vcell::whole {

namespace {

constexpr Image unmoved{0, 0, 0};

// What lies beyond a vessel's wall, or touches it from there, is nowhere nearer than the wall.
bool is_beyond_wall(const Object& object, const Sphere& ball) {
    if (const auto* vessel = std::get_if<HollowSphere>(&object)) {
        const ExactVector way = ExactVector(ball.center) - ExactVector(vessel->center);
        const Exact reach = Exact(vessel->radius) + ball.radius;
        return (dot(way, way) - reach * reach).sign() != Sign::Negative;
    }
    if (const auto* vessel = std::get_if<HollowCylinder>(&object)) {
        const Vec3& c = ball.center;
        return is_beside(world_form(*vessel), c.x(), c.y(), c.z(), ball.radius);
    }
    if (const auto* vessel = std::get_if<HollowCone>(&object))
        return !(least_distance(object, ball) + 2 * ball.radius > 0) &&
               is_beside(ConeForm(*vessel),
                         Ball{ball.center.x(), ball.center.y(), ball.center.z(), ball.radius});
    return false;
}

bool is_beyond_wall(const Object& object, const Cylinder& tube) {
    if (const auto* vessel = std::get_if<HollowSphere>(&object)) {
        const Vec3& c = vessel->center;
        return is_beside(world_form(tube), c.x(), c.y(), c.z(), vessel->radius);
    }
    if (const auto* vessel = std::get_if<HollowCylinder>(&object))
        return is_beside(world_form(*vessel), world_form(tube));
    const auto* vessel = std::get_if<HollowCone>(&object);
    return vessel != nullptr && is_beside(ConeForm(*vessel), world_form(tube));
}

bool is_beyond_wall(const Object& object, const Plane& plane) {
    const ExactVector n(plane.normal);
    if (const auto* tube = std::get_if<HollowCylinder>(&object)) {
        const Exact d = -dot(n, ExactVector(plane.point));
        return is_beyond({n.x, n.y, n.z, d}, world_form(*tube)) ||
               is_beyond({-n.x, -n.y, -n.z, -d}, world_form(*tube));
    }
    const auto* vessel = std::get_if<HollowSphere>(&object);
    if (vessel == nullptr) return false;
    const Exact height = dot(n, ExactVector(vessel->center) - ExactVector(plane.point)),
                reach = Exact(vessel->radius);
    return (height * height - reach * reach * dot(n, n)).sign() != Sign::Negative;
}

// Vessels are walls themselves.
bool is_beyond_wall(const Object&, const auto&) { return false; }

bool lies_on(const Plane& plane, const Vec3& p) {
    return !(least_distance(plane, Sphere{p, 0}) > 0) &&
           dot(ExactVector(plane.normal), ExactVector(p) - ExactVector(plane.point)).sign() == Sign::Zero;
}

// What is in a solid, or in a plane, is nowhere nearer than that.
bool lies_in(const Object& holder, const Sphere& ball) {
    const Vec3& c = ball.center;
    if (const auto* tube = std::get_if<Cylinder>(&holder))
        return tube->radius >= ball.radius && least_distance(holder, Sphere{c, 0}) <= -ball.radius &&
               contains(world_form(*tube), c.x(), c.y(), c.z(), ball.radius);
    const auto* plane = std::get_if<Plane>(&holder);
    return plane != nullptr && ball.radius == 0 && lies_on(*plane, c);
}
bool lies_in(const Object& holder, const Cylinder& tube) {
    if (const auto* outer = std::get_if<Cylinder>(&holder))
        return contains(world_form(*outer), world_form(tube));
    const auto* plane = std::get_if<Plane>(&holder);
    return plane != nullptr && tube.radius == 0 && lies_on(*plane, tube.point) &&
           dot(ExactVector(plane->normal), ExactVector(tube.axis)).sign() == Sign::Zero;
}
bool lies_in(const Object& holder, const Plane& plane) {
    const auto* other = std::get_if<Plane>(&holder);
    return other != nullptr && lies_on(*other, plane.point) &&
           cross(ExactVector(other->normal), ExactVector(plane.normal)).is_zero();
}
bool lies_in(const Object&, const auto&) { return false; }  // a vessel

std::string numbered(const std::vector<std::uint32_t>& numbers, std::uint32_t i) {
    return "object " + std::to_string(numbers.empty() ? i : numbers[i]);
}

struct Other {
    std::uint32_t number;  // its place
    OtherImages images;
};

std::vector<Other> no_balls(const DiagramScene& scene, const Lattice& lattice) {
    std::vector<Other> others;
    for (std::uint32_t i = 0; i < scene.objects.size(); ++i)
        if (!std::holds_alternative<Sphere>(scene.objects[i]))
            others.push_back({i, OtherImages(lattice, scene.objects[i])});
    return others;
}

// Why an object has no cell among others that are no balls.
std::string hidden_among(const DiagramScene& scene, const std::vector<std::uint32_t>& numbers,
                         const std::vector<Other>& others, std::uint32_t i) {
    return std::visit(
        [&](const auto& object) -> std::string {
            for (const Other& x : others)
                if (is_beyond_wall(x.images.object(), object))
                    return "lies beyond the wall of " + numbered(numbers, x.number);
            // What holds the object holds this, too.
            const Vec3& place = place_of(scene.objects[i]);
            const double rounding = 0x1p-40 * place.cwiseAbs().sum() + std::numeric_limits<double>::min();
            std::string reason;
            for (const Other& x : others) {
                if (x.number == i) continue;
                x.images.near(place, rounding, [&](const Object& image, const Image&) {
                    if (!reason.empty() || !lies_in(image, object)) return;
                    const bool is_equal = std::visit(
                        [&](const auto& holder) { return lies_in(scene.objects[i], holder); }, image);
                    if (!is_equal)
                        reason = "lies in " + numbered(numbers, x.number);
                    else if (x.number < i)
                        reason = "equals " + numbered(numbers, x.number);
                });
                if (!reason.empty()) return reason;
            }
            return {};
        },
        scene.objects[i]);
}

}  // namespace

void hide_others(const DiagramScene& scene, const Lattice& lattice, const std::vector<std::uint32_t>& numbers,
                 std::vector<std::string>& hidden) {
    const std::vector<Other> others = no_balls(scene, lattice);
    for (const Other& x : others)
        if (hidden[x.number].empty()) hidden[x.number] = hidden_among(scene, numbers, others, x.number);
}

double depth_in_holder(const Sphere& ball) {
    // More than that of a point in the origin, too.
    return -ball.radius + 0x1p-40 * (ball.radius + ball.center.cwiseAbs().sum()) +
           std::numeric_limits<double>::min();
}

std::vector<std::string> find_hidden(const DiagramScene& scene, const std::vector<std::uint32_t>& numbers,
                                     const ImageTree& balls) {
    std::vector<std::string> hidden(scene.objects.size());
    const Lattice& lattice = balls.lattice();
    hide_others(scene, lattice, numbers, hidden);
    const std::vector<Other> others = no_balls(scene, lattice);
    std::vector<std::tuple<std::uint32_t, Image, Ball>> holders;
    std::vector<Ball> around;
    const auto ball_of = [](const Sphere& s) {
        return Ball{s.center.x(), s.center.y(), s.center.z(), s.radius};
    };
    for (const BallTree::Entry& self : balls.tree().entries()) {
        const auto& s = std::get<Sphere>(scene.objects[self.number]);
        hidden[self.number] = hidden_among(scene, numbers, others, self.number);
        if (!hidden[self.number].empty()) continue;
        holders.clear();
        balls.within(s.center, depth_in_holder(s),
                     [&](const Sphere& ball, std::uint32_t number, const Image& image) {
                         if (ball.radius < s.radius || (number == self.number && image == unmoved)) return;
                         holders.emplace_back(number, image, ball_of(ball));
                     });
        if (holders.empty()) continue;
        std::ranges::sort(holders, [](const auto& a, const auto& b) {
            return std::tie(std::get<0>(a), std::get<1>(a)) < std::tie(std::get<0>(b), std::get<1>(b));
        });
        around.assign(1, ball_of(s));
        for (const auto& [number, image, ball] : holders) around.push_back(ball);
        const BallNesting nesting = ball_nesting(around);
        if (const std::uint32_t in = nesting.enclosing[0]; in != UINT32_MAX) {
            hidden[self.number] = "lies in " + numbered(numbers, std::get<0>(holders[in - 1]));
            continue;
        }
        std::pair<std::uint32_t, Image> first{self.number, unmoved};
        for (std::size_t k = 1; k < around.size(); ++k)
            if (nesting.first_equal[k] == 0)
                first = std::min(first, {std::get<0>(holders[k - 1]), std::get<1>(holders[k - 1])});
        if (first != std::pair(self.number, unmoved))
            hidden[self.number] = "equals " + numbered(numbers, first.first);
    }
    return hidden;
}

}  // namespace vcell::whole
