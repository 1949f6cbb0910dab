/// Scenes around a sphere or a cylinder as distance functions: who is nearest at a base point, along its
/// normal. Shares no code with the engine but the types, the frame and the chart.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>
#include "../../envelope/diagram/minimization_diagram.hpp"
#include "../../primitives/bases/radial_base.hpp"

namespace vcell::radial {

using Fast = long double;
using Vector = Eigen::Matrix<Fast, 3, 1>;
using Complex = std::complex<Fast>;

/// A scene in canonical position, as distance functions.
class Surroundings {
public:
    Surroundings(const Scene& scene, const RadialBaseProblem& problem) : problem_(problem) {
        turn_ = problem.frame.rotation.cast<Fast>();
        origin_ = problem.frame.origin.cast<Fast>();
        for (std::size_t i = 0; i < scene.objects.size(); ++i)
            add(Site::object(static_cast<std::uint32_t>(i)), scene.objects[i]);
        for (std::uint32_t side = 0; side < 6; ++side) {
            Vec3 normal = Vec3::Zero();
            normal[side / 2] = side % 2 == 0 ? -1 : 1;
            add(Site::box_side(side), Plane{side % 2 == 0 ? scene.box.min : scene.box.max, normal});
        }
        size_ = scene.box.diagonal();
        const Fast far = std::max(scene.box.min.cwiseAbs().maxCoeff(), scene.box.max.cwiseAbs().maxCoeff());
        // Over a cylinder coordinates are rounded when they are turned into the frame.
        tolerance_ =
            64 * std::numeric_limits<double>::epsilon() * (size_ + (problem.chart.is_sphere() ? 0 : far));
        form_.assign(items_.size(), FormId{});
        for (const FormId f : problem.sites.ids())
            for (const Site site : problem.sites[f]) form_[number(site)] = f;
    }

    std::size_t size() const { return items_.size(); }
    Fast scene_size() const { return size_; }
    Fast tolerance() const { return tolerance_; }
    FormId form(std::size_t item) const { return form_[item]; }
    /// Some item of a form.
    std::size_t item(FormId f) const { return number(problem_.sites[f].front()); }
    std::string name(std::size_t item) const { return to_string(items_[item].site); }

    Vector normal(Fast x, Fast y) const {
        Vector n;
        if (problem_.chart.is_sphere()) {
            const Fast s = x * x + y * y;
            n = Vector(2 * x, 2 * y, 1 - s) / (1 + s);
        } else {
            const Fast a = x > 1 ? x - 2 : x, sign = x > 1 ? -1 : 1;
            n = sign * Vector(2 * a, 0, 1 - a * a) / (1 + a * a);
        }
        return (problem_.chart.turn.cast<Fast>() * n).normalized();
    }

    /// d - r at the distance t from the centre or axis (of a side of the box what has its sign), and the
    /// derivative. Convex, and falls along the ray.
    std::pair<Fast, Fast> excess(std::size_t item, const Vector& foot, const Vector& u, Fast t) const {
        const Item& o = items_[item];
        const Vector p = foot + t * u - o.point;
        if (o.site.kind == Site::Kind::BoxSide) return {-o.axis.dot(p), -o.axis.dot(u)};
        const Fast r = t - static_cast<Fast>(problem_.chart.radius);
        if (o.kind == Item::Wall) {
            const Fast d = o.axis.dot(p);
            return {std::abs(d) - r, (d < 0 ? -1 : 1) * o.axis.dot(u) - 1};
        }
        const Vector away = o.kind == Item::Ball ? p : Vector(p - o.axis.dot(p) * o.axis);
        const Fast d = away.norm();
        return {d - o.rho - r, away.dot(u) / d - 1};
    }

    /// The distance at which the item is met along the ray, infinite beyond `most`: Newton's method ascends
    /// to the zero of a convex function from its left.
    Fast distance(std::size_t item, const Vector& foot, const Vector& u, Fast most) const {
        Fast t = 0;
        for (int i = 0; i < 200; ++i) {
            const auto [value, slope] = excess(item, foot, u, t);
            if (!(slope < 0)) return std::numeric_limits<Fast>::infinity();
            const Fast step = -value / slope;
            t += step;
            if (t > most) return std::numeric_limits<Fast>::infinity();
            if (i > 0 && step <= 2 * std::numeric_limits<Fast>::epsilon() * t) break;
        }
        return t;
    }
    Fast distance(std::size_t item, Fast x, Fast y) const {
        return distance(item, foot(y), normal(x, y), 4 * size_);
    }
    Vector foot(Fast y) const { return {0, problem_.chart.is_sphere() ? 0 : y, 0}; }

    /// The nearest item, and by how much it is nearer than the nearest that has another form.
    struct Nearest {
        std::size_t item;
        Fast distance, lead;
    };
    Nearest nearest(Fast x, Fast y) const {
        const Vector f = foot(y), u = normal(x, y);
        Nearest best{0, std::numeric_limits<Fast>::infinity(), 0};
        const auto search = [&](Nearest& at, auto admitted) {
            for (std::size_t i = 0; i < size(); ++i) {
                const Fast most = std::min(at.distance, 4 * size_);
                if (!admitted(i) || excess(i, f, u, most).first > 0) continue;
                const Fast t = distance(i, f, u, 4 * size_);
                if (t < at.distance) at = {i, t, 0};
            }
        };
        search(best, [](std::size_t) { return true; });
        Nearest second{0, std::numeric_limits<Fast>::infinity(), 0};
        search(second, [&](std::size_t i) {
            return i != best.item && !(form_[i].valid() && form_[i] == form_[best.item]);
        });
        best.lead = second.distance - best.distance;
        // A solid that hides another one may tie with it: the one with a form stands for both.
        if (!form_[best.item].valid() && best.lead <= tolerance_) best.item = second.item;
        return best;
    }

    /// {h, h0} with 1 / t of `f` less 1 / t of `g` a positive multiple of h . u + h0, over a sphere; without
    /// cylinders.
    std::pair<Vector, Fast> plane_of(std::size_t f, std::size_t g) const {
        const auto [a, a0, ac] = reciprocal(f);
        const auto [b, b0, bc] = reciprocal(g);
        return {a * bc - b * ac, a0 * bc - b0 * ac};
    }

private:
    struct Item {
        enum { Ball, Wall, Rod } kind;
        Site site;
        Vector point, axis = Vector::Zero();  // unit; of a side of the box outward
        Fast rho = 0;
    };

    // 1 / t = (b . u + b0) / c over a sphere base, c > 0: |t u - p|^2 = (t - R0 + rho)^2 solved for 1 / t,
    // and so on.
    std::tuple<Vector, Fast, Fast> reciprocal(std::size_t i) const {
        const Item& o = items_[i];
        const Fast R0 = problem_.chart.radius;
        if (o.site.kind == Site::Kind::BoxSide) return {o.axis, 0, o.axis.dot(o.point)};
        if (o.kind == Item::Ball) {
            const Fast d = o.rho - R0;
            return {2 * o.point, 2 * d, o.point.squaredNorm() - d * d};
        }
        const Fast D = -o.axis.dot(o.point), s = D < 0 ? -1 : 1;
        return {-s * o.axis, 1, s * D + R0};
    }

    void add(Site site, const Object& object) {
        Item item{Item::Ball, site, {}};
        const auto place = [&](const Vec3& p) -> Vector { return turn_ * (p.cast<Fast>() - origin_); };
        if (const auto* s = std::get_if<Sphere>(&object)) {
            item.point = place(s->center);
            item.rho = s->radius;
        } else if (const auto* p = std::get_if<Plane>(&object)) {
            item.kind = Item::Wall;
            item.point = place(p->point);
            item.axis = (turn_ * p->normal.cast<Fast>()).normalized();
        } else {
            const auto& c = std::get<Cylinder>(object);
            item.kind = Item::Rod;
            item.point = place(c.point);
            item.axis = (turn_ * c.axis.cast<Fast>()).normalized();
            item.rho = c.radius;
        }
        items_.push_back(item);
    }
    std::size_t number(Site site) const {
        return site.is_object() ? site.index : items_.size() - 6 + site.index;
    }

    const RadialBaseProblem& problem_;
    Eigen::Matrix<Fast, 3, 3> turn_;
    Vector origin_;
    std::vector<Item> items_;
    std::vector<FormId> form_;
    Fast size_ = 0, tolerance_ = 0;
};

}  // namespace vcell::radial
