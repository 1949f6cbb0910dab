#include "body_volume.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <queue>
#include <utility>
#include <variant>
#include <vector>

#include "../../core/errors.hpp"
#include "../../core/quadrature/quadrature.hpp"
#include "../../primitives/bases/canonical.hpp"
#include "../../primitives/objects/exact_space.hpp"
#include "../complete_measures.hpp"
#include "../object_distance.hpp"
#include "complete_cells.hpp"

namespace vcell::whole {

namespace {

constexpr double double_epsilon = std::numeric_limits<double>::epsilon();

// ---- A tube in the box ------------------------------------------------------------------------------

// Integrals of 1, x and y over a part of a disc about 0.
struct DiscMoments {
    double area = 0;
    Vec2 first = Vec2::Zero();
    double size = 0;  // of the area's terms, however they cancel
};

// Adds those over the part of the triangle (0, p, q) in the disc, less than nothing if it runs clockwise.
// From where the side enters the disc to where it leaves it that is a triangle; before and after, a sector.
void add_triangle(const Vec2& p, const Vec2& q, double radius, DiscMoments& sum) {
    const Vec2 d = q - p;
    const double square = d.squaredNorm();
    if (!(square > 0)) return;
    const double along = -p.dot(d) / square, cross = p.x() * d.y() - p.y() * d.x(),
                 half2 = (radius * radius - cross * cross / square) / square;
    const double half = half2 > 0 ? std::sqrt(half2) : 0, in = std::clamp(along - half, 0.0, 1.0),
                 out = std::clamp(along + half, 0.0, 1.0);
    const auto sector = [&](const Vec2& a, const Vec2& b) {
        const double turn = std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
        const Vec2 u = a.normalized(), v = b.normalized();
        sum.area += 0.5 * radius * radius * turn;
        sum.first += radius * radius * radius / 3 * Vec2(v.y() - u.y(), u.x() - v.x());
        sum.size += 0.5 * radius * radius * std::abs(turn);
    };
    const Vec2 a = p + in * d, b = p + out * d;
    if (in > 0) sector(p, a);
    if (out < 1) sector(b, q);
    if (!(out > in)) return;
    const double area = 0.5 * (a.x() * b.y() - a.y() * b.x());
    sum.area += area;
    sum.first += area / 3 * (a + b);
    sum.size += std::abs(area);
}

// The sides of a box as polygons: counter-clockwise seen from outside.
std::array<Vec3, 4> corners_of(const Box& box, unsigned side) {
    const unsigned k = side / 2, i = (k + 1) % 3, j = (k + 2) % 3;
    const bool is_upper = side % 2 == 1;
    std::array<Vec3, 4> corners;
    for (unsigned c = 0; c < 4; ++c) {
        Vec3& p = corners[is_upper ? c : 3 - c];
        p[k] = (is_upper ? box.max : box.min)[k];
        p[i] = (c == 1 || c == 2 ? box.max : box.min)[i];
        p[j] = (c >= 2 ? box.max : box.min)[j];
    }
    return corners;
}

}  // namespace

// Seen along the axis every line of the tube has in the box what lies between the side through which it
// leaves and that through which it comes in: the volume is the sum over the sides of the integral of their
// heights, which are linear, over what the tube has of them as seen along the axis, where it comes in less
// than nothing. Sides along the axis are seen as segments.
BodyVolume tube_in_box(const Cylinder& tube, const Box& box) {
    constexpr double least_lean = 0x1p-30;
    Vec3 axis = tube.axis.stableNormalized();
    const double radius = tube.radius, diagonal = box.diagonal();
    BodyVolume result;
    for (double& a : axis)
        if (a != 0 && std::abs(a) < least_lean) {
            result.error += std::abs(a) * diagonal * 2 * std::numbers::pi * radius * diagonal;
            a = 0;
        }
    axis.normalize();
    Eigen::Index longest = 0;
    axis.cwiseAbs().maxCoeff(&longest);
    const Vec3 x = axis.cross(Vec3::Unit((longest + 1) % 3)).normalized(), y = axis.cross(x);
    const Vec3 center = 0.5 * box.min + 0.5 * box.max,
               origin = tube.point + axis.dot(center - tube.point) * axis;
    double size = 0;
    for (unsigned side = 0; side < 6; ++side) {
        const double lean = axis[side / 2];
        if (lean == 0) continue;
        const std::array<Vec3, 4> corners = corners_of(box, side);
        DiscMoments sum;
        for (int c = 0; c < 4; ++c) {
            const Vec3 p = corners[c] - origin, q = corners[(c + 1) % 4] - origin;
            add_triangle({x.dot(p), y.dot(p)}, {x.dot(q), y.dot(q)}, radius, sum);
        }
        // height = (bound - origin - (x, y) . p) / lean along the axis.
        const double offset = (corners[0] - origin)[side / 2] / lean;
        const Vec2 slope = Vec2(x[side / 2], y[side / 2]) / lean;
        result.volume += offset * sum.area - slope.dot(sum.first);
        size += (std::abs(offset) + slope.norm() * radius) * sum.size;
    }
    const double place = tube.point.norm() + box.min.norm() + box.max.norm();
    result.error +=
        2 * double_epsilon * (16 * size + 8 * place * 2 * std::numbers::pi * radius * (diagonal + radius));
    result.volume = std::max(0.0, result.volume);
    return result;
}

namespace {

// ---- What others take of a ball or a tube -----------------------------------------------------------

// A ray from the axis or the centre, at distance t from there at from + t direction.
struct BodyRay {
    Vec3 from, direction;
};

// The object with an axis of length 1.
Object with_unit_axis(Object object) {
    std::visit(
        [](auto& o) {
            if constexpr (requires { o.axis; }) o.axis = o.axis.stableNormalized();
        },
        object);
    return object;
}

// How far along a ray an object, its axis of length 1, is as near as the base's surface, where that is before
// `radius`: at distance t its distance is t - radius. (The quadratics of primitives/forms/radial_form.hpp.)
double nearest_along(const Object& object, const BodyRay& ray, double radius) {
    constexpr double never = std::numeric_limits<double>::infinity();
    // A^2 t^2 + 2 B t = C. Where C > 0 the object is farther than the base in the ray's beginning, and one
    // root is positive. Where C <= 0 a solid that is larger than the base by delta is nearer all along; a
    // smaller one is within the base there, and comes out of it at the larger root, if it does at all.
    const auto first = [&](double C, double B, double A2, double delta) {
        if (!(C > 0) && delta >= 0) return 0.0;
        const double root = std::sqrt(std::max(0.0, B * B + A2 * C));
        const double t = C > 0 && B >= 0 ? C / (B + root) : (root - B) / A2;
        return t > 0 ? t : never;  // no number without a root: never, too
    };
    if (const auto* ball = std::get_if<Sphere>(&object)) {
        const Vec3 m = ray.from - ball->center;
        const double delta = ball->radius - radius;
        return first(m.squaredNorm() - delta * delta, delta - m.dot(ray.direction), 0, delta);
    }
    if (const auto* tube = std::get_if<Cylinder>(&object)) {
        const Vec3 &a = tube->axis, m = (ray.from - tube->point).cross(a);
        const double delta = tube->radius - radius, along = ray.direction.dot(a);
        return first(m.squaredNorm() - delta * delta, delta - m.dot(ray.direction.cross(a)), along * along,
                     delta);
    }
    if (const auto* vessel = std::get_if<HollowSphere>(&object)) {
        const Vec3 m = ray.from - vessel->center;
        const double reach = vessel->radius + radius;
        return first(reach * reach - m.squaredNorm(), reach + m.dot(ray.direction), 0, reach);
    }
    if (const auto* vessel = std::get_if<HollowCylinder>(&object)) {
        const Vec3 &a = vessel->axis, m = (ray.from - vessel->point).cross(a);
        const double reach = vessel->radius + radius, along = ray.direction.dot(a);
        return first(reach * reach - m.squaredNorm(), reach + m.dot(ray.direction.cross(a)), -along * along,
                     reach);
    }
    if (const auto* vessel = std::get_if<HollowCone>(&object)) {
        // Behind the apex C > 0 is that of the wall's other half.
        const Vec3 &w = vessel->axis, m = ray.from - vessel->apex, across = m - m.dot(w) * w;
        const double sine = vessel->sine(), cosine = vessel->cosine(), along = ray.direction.dot(w),
                     reach = sine * m.dot(w) + radius, out = cosine * across.norm();
        if (!(reach > 0)) return 0;
        return first((reach - out) * (reach + out),
                     reach * (1 - sine * along) + cosine * cosine * across.dot(ray.direction),
                     -(along - sine) * (along - sine), reach);
    }
    return never;
}

// The volume of a ball or a tube in a box that is nearer to others: over the rays, in coordinates (v, w), w
// the angle about the axis, or about z, and v the height along it, of a ball the cosine from z.
class LostVolume {
public:
    LostVolume(const Object& body, const Box& box, const std::vector<Object>& others) : box_(box) {
        std::ranges::transform(others, std::back_inserter(others_), with_unit_axis);
        if (const auto* ball = std::get_if<Sphere>(&body)) {
            origin_ = ball->center;
            radius_ = ball->radius;
            range_ = {-1, 1};
            power_ = 3;
        } else {
            const auto& tube = std::get<Cylinder>(body);
            origin_ = tube.point;
            radius_ = tube.radius;
            axis_ = tube.axis.stableNormalized();
            double low = std::numeric_limits<double>::infinity(), high = -low;
            for (unsigned corner = 0; corner < 8; ++corner) {
                Vec3 p;
                for (int k = 0; k < 3; ++k) p[k] = ((corner >> k & 1) != 0 ? box.max : box.min)[k];
                const double v = axis_.dot(p - origin_);
                low = std::min(low, v);
                high = std::max(high, v);
            }
            range_ = {low, high};
            power_ = 2;
        }
        Eigen::Index longest = 0;
        axis_.cwiseAbs().maxCoeff(&longest);
        x_ = axis_.cross(Vec3::Unit((longest + 1) % 3)).normalized();
        y_ = axis_.cross(x_);
    }

    BodyVolume operator()() {
        Part whole{range_, {-std::numbers::pi, std::numbers::pi}, {}};
        for (const Object& o : others_) whole.near.push_back(&o);
        find_parts(std::move(whole), 0);
        // The worst is halved, the longer way, until the error is as small a part as wanted, or the budget is
        // spent.
        std::priority_queue<Part> parts(parts_.begin(), parts_.end());
        double error = 0, volume = 0;
        for (const Part& p : parts_) {
            error += p.error;
            volume += p.volume;
        }
        for (int halvings = 0; halvings < most_halvings && error > wanted * volume && !parts.empty();
             ++halvings) {
            const Part worst = parts.top();
            parts.pop();
            error -= worst.error;
            volume -= worst.volume;
            for (Part& half : halves(worst, worst.is_along)) {
                Part p = measured(std::move(half));
                error += p.error;
                volume += p.volume;
                parts.push(std::move(p));
            }
        }
        // Anew, without the rounding of what was taken away.
        error = volume = 0;
        for (; !parts.empty(); parts.pop()) {
            error += parts.top().error;
            volume += parts.top().volume;
        }
        constexpr double rounding = 1e-13;  // of some thousands of terms
        return {volume, 2 * error + rounding * volume, true};
    }

private:
    static constexpr double wanted = 1e-7;
    static constexpr int most_halvings = 4000;
    struct Part {
        std::array<double, 2> v, w;
        // The others that may overlap the part of the surface: none else overlaps anything of what is under
        // it.
        std::vector<const Object*> near;
        double volume = 0, error = 0;
        bool is_along = true;  // the way that is to be halved

        friend bool operator<(const Part& a, const Part& b) { return a.error < b.error; }
    };
    BodyRay ray(double v, double w) const {
        const Vec3 across = std::cos(w) * x_ + std::sin(w) * y_;
        if (power_ == 2) return {origin_ + v * axis_, across};
        return {origin_, v * axis_ + std::sqrt(std::max(0.0, 1 - v * v)) * across};
    }

    void find_parts(Part part, int depth) {
        constexpr int deepest = 9, least_depth = 3;
        drop_the_far(part);
        if (part.near.empty()) return;
        if (depth >= least_depth && (depth >= deepest || reach(part) < 0.125 * radius_)) {
            parts_.push_back(measured(std::move(part)));
            return;
        }
        // The longer way is halved; long tubes are cut into pieces first.
        const bool is_long = power_ == 2 && along(part) > radius_;
        for (Part& half : halves(part, along(part) > around(part)))
            find_parts(std::move(half), is_long ? depth : depth + 1);
    }
    // No point of a part of the surface is farther than that from its middle, along and around the axis.
    double along(const Part& part) const {
        return power_ == 2 ? 0.5 * (part.v[1] - part.v[0]) : radius_ * cap_extent(part.v);
    }
    double around(const Part& part) const { return 0.5 * radius_ * (part.w[1] - part.w[0]); }
    double reach(const Part& part) const { return along(part) + around(part); }
    void drop_the_far(Part& part) const {
        const BodyRay middle = ray(0.5 * (part.v[0] + part.v[1]), 0.5 * (part.w[0] + part.w[1]));
        const Vec3 p = middle.from + radius_ * middle.direction;
        const double near = reach(part) * (1 + 0x1p-20);
        std::erase_if(part.near, [&](const Object* o) { return distance_from(*o, p) > near; });
    }
    static double cap_extent(const std::array<double, 2>& v) {
        const double middle = std::acos(std::clamp(0.5 * (v[0] + v[1]), -1.0, 1.0));
        return std::max(std::abs(std::acos(std::clamp(v[0], -1.0, 1.0)) - middle),
                        std::abs(std::acos(std::clamp(v[1], -1.0, 1.0)) - middle));
    }

    static std::array<Part, 2> halves(const Part& p, bool is_along) {
        std::array<Part, 2> half{Part{p.v, p.w, p.near}, Part{p.v, p.w, p.near}};
        const std::array<double, 2>& way = is_along ? p.v : p.w;
        (is_along ? half[0].v : half[0].w)[1] = (is_along ? half[1].v : half[1].w)[0] =
            0.5 * (way[0] + way[1]);
        return half;
    }

    Part measured(Part part) const {
        drop_the_far(part);
        if (part.near.empty()) return part;
        const Integral whole = integral<6, 6>(part);
        part.volume = whole.volume;
        part.error = std::abs(part.volume - integral<4, 4>(part).volume);
        // The way of which fewer points change more; where they tell nothing the longer one.
        const double by_v = std::abs(part.volume - integral<4, 6>(part).volume),
                     by_w = std::abs(part.volume - integral<6, 4>(part).volume);
        part.is_along = by_v != by_w ? by_v > by_w : along(part) > around(part);
        // Beside the points of the rule an object may overlap a margin of a 29th of the part, half as deep,
        // or another one than elsewhere may be what ends the rays.
        constexpr double margin = 0.034;
        if (part.volume == 0 || !whole.is_smooth || !is_smooth_to_corners(part, whole.first))
            part.error += 0.5 * margin * margin * reach(part) * std::pow(radius_, power_ - 1) *
                          (part.v[1] - part.v[0]) * (part.w[1] - part.w[0]);
        return part;
    }

    // What a ray loses, and what it comes in through, what it leaves through and what is nearer: where all of
    // these are the same, what rays lose changes smoothly.
    struct Loss {
        double volume = 0;
        bool is_any = false;
        std::array<int, 2> sides{-1, -1};  // axes of the box's sides: none, in its middle or on the surface
        const Object* other = nullptr;     // none: nearer all along

        bool is_alike(const Loss& o) const {
            return is_any == o.is_any && sides == o.sides && other == o.other;
        }
    };
    struct Integral {
        double volume = 0;
        Loss first;
        bool is_smooth = true;  // as far as its points tell
    };
    template <int n, int m>
    Integral integral(const Part& part) const {
        static constexpr quadrature::RuleOf<n> rule_v = quadrature::make_rule<n>();
        static constexpr quadrature::RuleOf<m> rule_w = quadrature::make_rule<m>();
        const double mv = 0.5 * (part.v[0] + part.v[1]), hv = 0.5 * (part.v[1] - part.v[0]),
                     mw = 0.5 * (part.w[0] + part.w[1]), hw = 0.5 * (part.w[1] - part.w[0]);
        Integral sum;
        bool is_first = true;
        for (int i = 0; i < n / 2; ++i)
            for (int j = 0; j < m / 2; ++j)
                for (const double a : {-1.0, 1.0})
                    for (const double b : {-1.0, 1.0}) {
                        const Loss loss =
                            lost(ray(mv + a * hv * rule_v.x[i], mw + b * hw * rule_w.x[j]), part.near);
                        sum.volume += rule_v.weight[i] * rule_w.weight[j] * loss.volume;
                        if (is_first) sum.first = loss;
                        sum.is_smooth = sum.is_smooth && loss.is_alike(sum.first);
                        is_first = false;
                    }
        sum.volume *= hv * hw;
        return sum;
    }
    bool is_smooth_to_corners(const Part& part, const Loss& inside) const {
        for (const double v : part.v)
            for (const double w : part.w)
                if (!lost(ray(v, w), part.near).is_alike(inside)) return false;
        return true;
    }

    // Between where a ray comes into the box and where it leaves it or the body, what is beyond the nearest
    // other object is lost.
    Loss lost(const BodyRay& ray, const std::vector<const Object*>& near) const {
        Loss loss;
        double in = 0, out = radius_;
        for (int k = 0; k < 3; ++k) {
            const double d = ray.direction[k], low = box_.min[k] - ray.from[k],
                         high = box_.max[k] - ray.from[k];
            if (d == 0) {
                if (low > 0 || high < 0) return {};
                continue;
            }
            const double from = std::min(low / d, high / d), to = std::max(low / d, high / d);
            if (from > in) {
                in = from;
                loss.sides[0] = k;
            }
            if (to < out) {
                out = to;
                loss.sides[1] = k;
            }
        }
        if (!(in < out)) return {};
        double end = out;
        for (const Object* o : near)
            if (const double t = nearest_along(*o, ray, radius_); t < end) {
                end = t;
                loss.other = o;
            }
        if (loss.other == nullptr) return {};
        loss.is_any = true;
        if (end > in) {
            loss.sides[0] = -1;
        } else {
            end = in;
            loss.other = nullptr;
        }
        loss.volume = power_ == 2 ? 0.5 * (out - end) * (out + end)
                                  : (out - end) * (out * out + out * end + end * end) / 3;
        return loss;
    }

    const Box& box_;
    std::vector<Object> others_;
    Vec3 origin_, axis_ = Vec3::UnitZ(), x_, y_;
    double radius_ = 0;
    int power_ = 2;  // of t in the volume under the rays
    std::array<double, 2> range_{};
    std::vector<Part> parts_;
};

// ---- The two together -------------------------------------------------------------------------------

bool bodies_overlap(const Sphere& a, const Sphere& b) {
    const Vec3 way = b.center - a.center;
    const double reach = a.radius + b.radius, distance = way.norm();
    constexpr double rounding = 0x1p-46;
    const double doubt = rounding * (reach + a.center.cwiseAbs().sum() + b.center.cwiseAbs().sum());
    if (std::abs(distance - reach) > doubt) return distance < reach;
    const ExactVector d = ExactVector(b.center) - ExactVector(a.center);
    const Exact sum = Exact(a.radius) + b.radius;
    return (dot(d, d) - sum * sum).sign() == Sign::Negative;
}

// Sides that a ball does not cut are moved out of its way: touching ones would be ties.
Box room_of(const Sphere& ball, const Box& box, bool& is_cut) {
    Box room = box;
    is_cut = false;
    for (int k = 0; k < 3; ++k) {
        const Exact center(ball.center[k]), radius(ball.radius);
        if ((center - Exact(box.min[k]) - radius).sign() != Sign::Negative)
            room.min[k] = ball.center[k] - 2 * ball.radius;
        else
            is_cut = true;
        if ((Exact(box.max[k]) - center - radius).sign() != Sign::Negative)
            room.max[k] = ball.center[k] + 2 * ball.radius;
        else
            is_cut = true;
    }
    return room;
}

BodyVolume ball_in_cell(const DecidedDiagram& decided, std::uint32_t object) {
    const Sphere& ball = decided.ball(object);
    const Box box = decided.room(ball);
    Scene scene;
    scene.base = ball;
    decided.balls().within(ball.center, ball.radius * (1 + 0x1p-40),
                           [&](const Sphere& other, std::uint32_t place, const Image& image) {
                               if (place == object && image == Image{0, 0, 0}) return;
                               if (bodies_overlap(ball, other)) scene.objects.emplace_back(other);
                           });
    std::vector<Object> others;
    for (const DecidedDiagram::Other& other : decided.others())
        other.images.near(ball.center, ball.radius * (1 + 0x1p-40), [&](const Object& o, const Image&) {
            if (!std::holds_alternative<Plane>(o) && distance_from(o, ball.center) < ball.radius)
                others.push_back(o);
        });
    bool is_cut = false;
    scene.box = room_of(ball, box, is_cut);
    scene.tolerance = decided.scene().tolerance;
    if (!is_cut && scene.objects.empty() && others.empty()) {
        const double volume = 4 * std::numbers::pi / 3 * ball.radius * ball.radius * ball.radius;
        return {volume, 8 * double_epsilon * volume, false};
    }
    const auto among = [](const Scene& s) {
        const CompleteMeasures m = complete_body_measures(s);
        return BodyVolume{m.volume, m.volume_error, m.is_estimated};
    };
    if (others.empty()) try {
            return among(scene);
        } catch (const UndecidedError&) {
        }
    others.insert(others.end(), scene.objects.begin(), scene.objects.end());
    scene.objects.clear();
    const BodyVolume whole = among(scene), lost = LostVolume(ball, box, std::move(others))();
    return {std::max(0.0, whole.volume - lost.volume), whole.error + lost.error, true};
}

BodyVolume tube_in_cell(const DecidedDiagram& decided, std::uint32_t object) {
    const Scene scene = scenes_among_all(decided, object).front();
    const auto& tube = std::get<Cylinder>(decided.scene().objects[object]);
    const Box& box = scene.box;
    BodyVolume body = tube_in_box(tube, box);
    const Vec3 axis = tube.axis.stableNormalized();
    std::vector<Object> others;
    for (const Object& o : scene.objects) {
        double distance = is_vessel(o) ? 0 : std::numeric_limits<double>::infinity();
        if (const auto* ball = std::get_if<Sphere>(&o)) {
            distance = (ball->center - tube.point).cross(axis).norm() - ball->radius;
        } else if (const auto* other = std::get_if<Cylinder>(&o)) {
            const Vec3 a = other->axis.stableNormalized(), normal = axis.cross(a),
                       way = other->point - tube.point;
            const double sine = normal.norm();
            // Rounding leaves the distance of axes some 2^-52 of the box over the sine of their angle. Where
            // that is more than a 2^-32 the tube is looked at, which costs time and changes no volume.
            constexpr double well_told = 0x1p-20;
            // All but parallel axes come no nearer to each other in the box than they are apart in one place,
            // less what they lean on the way there.
            const double farthest = 0.5 * box.diagonal() + (other->point - 0.5 * (box.min + box.max)).norm(),
                         apart = way.cross(axis).norm() - farthest * sine;
            distance =
                (sine > well_told ? std::abs(way.dot(normal)) / sine : std::max(0.0, apart)) - other->radius;
        }
        if (distance < tube.radius) others.push_back(o);
    }
    if (others.empty()) return body;
    const BodyVolume lost = LostVolume(tube, box, std::move(others))();
    return {std::max(0.0, body.volume - lost.volume), body.error + lost.error, lost.volume > 0};
}

}  // namespace

BodyVolume body_volume(const DecidedDiagram& decided, std::uint32_t object) {
    const Object& o = decided.scene().objects[object];
    if (const auto* ball = std::get_if<Sphere>(&o))
        return ball->radius > 0 ? ball_in_cell(decided, object) : BodyVolume();
    if (const auto* tube = std::get_if<Cylinder>(&o))
        return tube->radius > 0 ? tube_in_cell(decided, object) : BodyVolume();
    return {};
}

}  // namespace vcell::whole
