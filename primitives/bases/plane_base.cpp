#include "plane_base.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <variant>

#include "../../core/errors.hpp"
#include "../../core/numbers/compensated.hpp"
#include "../../core/numbers/exact.hpp"
#include "../objects/decided_scene.hpp"
#include "../objects/exact_motion.hpp"
#include "../objects/exact_space.hpp"
#include "../objects/message.hpp"
#include "canonical.hpp"
#include "plane_forms.hpp"
#include "plane_frame.hpp"
#include "plane_region.hpp"
#include "solids.hpp"
#include "world_objects.hpp"

namespace vcell {

namespace {

using Kind = InputError::Kind;

// The square of an axis' slope against the base is a coefficient of the height.
constexpr double smallest_slope = 1e-125;
// A part of a ball's size and distance: of balls nearer to the base than that, contact is asked exactly.
constexpr double near_contact = 0x1p-40;

// A ball in the world, a hollow one with its radius below 0, or what is exact.
using FormSource = std::variant<Ball, std::shared_ptr<const ExactForm>>;

Vec3 center_of_ball(const Ball& ball) { return {ball.cx, ball.cy, ball.cz}; }

// A ball of the world in canonical coordinates.
ExactBall placed_ball(const PlaneFrame& frame, const Ball& ball) {
    if (frame.keeps(center_of_ball(ball)))
        return {ExactVector(frame.to_canonical(center_of_ball(ball))), ball.rho, 1.0};
    return {frame.place(center_of_ball(ball)), frame.norm() * ball.rho, frame.norm()};
}
bool is_hollow_ball(const Ball& ball) { return ball.rho < 0; }
Ball rounded_ball(const PlaneFrame& frame, const Ball& ball) {
    const Vec3 c = frame.to_canonical(center_of_ball(ball));
    return {c.x(), c.y(), c.z(), ball.rho};
}

// The height of a ball of the world.
ExactForm exact_form(const PlaneFrame& frame, const Ball& ball) {
    const ExactForm form = exact_ball_form(placed_ball(frame, ball));
    return is_hollow_ball(ball) ? -form : form;
}
CircularForm rounded_form(const PlaneFrame& frame, const Ball& ball) {
    const CircularForm form = frame.keeps(center_of_ball(ball)) ? ball_form(rounded_ball(frame, ball))
                                                                : ball_form(placed_ball(frame, ball));
    return is_hollow_ball(ball) ? -form : form;
}

// Are two forms those of balls whose centres lie on one normal of the base?
bool are_on_one_normal(const FormSource& f, const FormSource& g, const Vec3& normal) {
    const auto *p = std::get_if<Ball>(&f), *q = std::get_if<Ball>(&g);
    if (p == nullptr || q == nullptr) return false;
    return cross(ExactVector(center_of_ball(*p)) - ExactVector(center_of_ball(*q)), ExactVector(normal))
        .is_zero();
}

AxisToBase axis_to_base(const Object& object, const Vec3& of_base) {
    const ExactVector normal(of_base);
    const auto lean = [&](const Vec3& of_object, bool is_parallel) {
        return is_parallel                                       ? AxisToBase::Parallel
               : cross(ExactVector(of_object), normal).is_zero() ? AxisToBase::Upright
                                                                 : AxisToBase::Oblique;
    };
    if (const auto* cone = std::get_if<HollowCone>(&object)) {
        // A line of the wall is at right angles to the normal where n.a / (|n| |a|) is the sine |a| / g.
        const ConeForm form(*cone);
        const Exact rise = form.g * dot(form.a, normal);
        return lean(cone->axis,
                    rise.sign() == Sign::Positive && rise * rise == form.N * form.N * dot(normal, normal));
    }
    const auto* hollow = std::get_if<HollowCylinder>(&object);
    const Vec3& axis = hollow != nullptr ? hollow->axis : std::get<Cylinder>(object).axis;
    return lean(axis, dot(ExactVector(axis), normal).sign() == Sign::Zero);
}

// Where a plane with signs at the region's corners, that are not all of one kind, touches or cuts one of its
// sides.
Eigen::Vector2d place_of_contact(const HalfSpaceOverBase& h, const std::vector<ExactPoint>& corners,
                                 const std::vector<Sign>& signs) {
    const auto zero = std::ranges::find(signs, Sign::Zero);
    if (zero != signs.end()) return corners[zero - signs.begin()].rounded();
    const std::size_t k = std::ranges::adjacent_find(signs, std::not_equal_to<>()) - signs.begin();
    const Eigen::Vector2d from = corners[k].rounded(), to = corners[k + 1].rounded();
    const Eigen::Vector2d n(nearest(h.n.x), nearest(h.n.y));
    const double g0 = n.dot(from) + nearest(h.d), g1 = n.dot(to) + nearest(h.d);
    return from + std::clamp(g0 / (g0 - g1), 0.0, 1.0) * (to - from);
}

// Where the base is the floor sides of the box that lean out over it must not bound the region, along which
// they and the base would be one function. No solid tube may be met in what comes to it.
std::vector<RegionSide> region_in_vessels(const std::vector<RegionSide>& sides,
                                          const std::array<BoxSide, 6>& box, double diagonal,
                                          std::span<const CylinderTrace> solids) {
    for (const double part : {0x1p-10, 0x1p-20, 0x1p-30}) {
        std::vector<RegionSide> wide = widened(sides, box, part * diagonal);
        const BaseRegion region(wide);
        if (std::ranges::all_of(solids, [&](const CylinderTrace& trace) {
                return region.lowest(trace, smallest_coefficient) == Sign::Positive;
            }))
            return wide;
    }
    return sides;
}

// ---- The problem ------------------------------------------------------------------------------------

class ProblemBuilder {
public:
    ProblemBuilder(const Scene& scene, const Plane& base, double unit, bool has_floor)
        : scene_(scene),
          has_floor_(has_floor),
          base_(base),
          frame_(std::make_shared<PlaneFrame>(base, scene.box)),
          box_(frame_->box()),
          sides_(has_floor ? ray_region(base, scene.box, box_, frame_->motion())
                           : base_region(base, scene.box, box_)),
          region_(sides_),
          unit_(unit),
          objects_(scene),
          sources_(std::make_shared<IdVector<FormId, FormSource>>()) {}

    PlaneBaseProblem build() {
        for (std::uint32_t i = 0; i < scene_.objects.size(); ++i) {
            if (!scene_.competes(i)) continue;
            std::visit([&](const auto& object) { add(i, object); }, scene_.objects[i]);
        }
        if (objects_.cylinders.size() > 0) drop_hidden();
        objects_.drop_wider_tubes_and_cones();
        objects_.drop_beyond_tubes_and_cones();
        make_forms();
        add_cylinders();
        sites_.settle();
        PlaneBaseProblem problem;
        problem.frame = frame_->motion();
        problem.unit = unit_;
        const double by_lengths = moved_by_lengths(scene_);
        problem.moves.all = std::max(frame_->moved(), by_lengths);
        problem.moves.apart = planes_turn_ ? problem.moves.all : by_lengths;
        problem.region = sides_;
        if (is_cut_by_vessel_ && !has_floor_) {
            std::vector<CylinderTrace> solids;
            objects_.for_kept(objects_.cylinders, [&](const CylinderForm&, std::uint32_t i) {
                solids.push_back(trace_on_base(form_of(i)));
            });
            problem.region = region_in_vessels(sides_, box_, scene_.box.diagonal(), solids);
        }
        if (!floor_.empty())
            problem.region_in_box = has_floor_ ? base_region(base_, scene_.box, box_) : sides_;
        problem.has_curved_rim = is_cut_by_vessel_;
        for (const ExactPoint& corner : region_corners(problem.region))
            problem.corners.push_back(corner.rounded());
        for (std::size_t i = 0; i < sides_.size() && floor_.empty(); ++i)
            problem.corner_sites.push_back(sides_through(
                base_, scene_.box, sides_[(i + sides_.size() - 1) % sides_.size()].site, sides_[i].site));
        problem.floor = std::move(floor_);
        problem.family.forms = std::move(forms_);
        for (const FormId side : hidden_sides_) problem.family.hide(side);
        for (const std::uint32_t i : tubes_) {
            if (!objects_.is_kept(i)) continue;
            problem.family.cylinders.push_back(form_of(i));
            problem.axes.push_back(axis_to_base(scene_.objects[i], base_.normal));
        }
        problem.on_one_normal = [sources = sources_, normal = base_.normal](FormId f, FormId g) {
            return are_on_one_normal((*sources)[f], (*sources)[g], normal);
        };
        problem.family.exact = [sources = sources_, frame = frame_](FormId f) -> ExactForm {
            const FormSource& source = (*sources)[f];
            if (const auto* ball = std::get_if<Ball>(&source)) return exact_form(*frame, *ball);
            return *std::get<std::shared_ptr<const ExactForm>>(source);
        };
        objects_.warn(sites_, "behind the base", problem.warnings);
        problem.sites = std::move(sites_);
        return problem;
    }

private:
    [[noreturn]] void fail_touching(std::uint32_t object, Sign depth, const Eigen::Vector2d& place) const {
        const Vec3 world = frame_->motion().to_world({place.x(), place.y(), 0});
        objects_.fail(Kind::TouchesBase, object,
                      std::string(depth == Sign::Positive ? "cuts" : "touches") + " the base region at " +
                          to_text(unit_ * world));
    }

    void add(std::uint32_t i, const Sphere& sphere) {
        const Ball world{sphere.center.x(), sphere.center.y(), sphere.center.z(), sphere.radius};
        const bool is_kept = frame_->keeps(sphere.center);
        const Ball ball = rounded_ball(*frame_, world);
        // A base that has turned by rounding may part from what touches it in the scene.
        const double size = std::hypot(ball.cx, ball.cy, ball.cz) + ball.rho;
        if (!frame_->is_exact() && std::abs(ball.cz) <= ball.rho + near_contact * size) {
            const ExactVector n(base_.normal);
            const Exact square = dot(n, n),
                        height = dot(n, ExactVector(sphere.center) - ExactVector(base_.point));
            const Exact power = square * Exact(sphere.radius) * sphere.radius - height * height;
            if (power.sign() != Sign::Negative) {
                const ExactBall exact = placed_ball(*frame_, world);
                const Sign depth = region_.reach({square * exact.c.x, square * exact.c.y, square * exact.d},
                                                 power * square * exact.d * exact.d);
                if (depth != Sign::Negative)
                    fail_touching(i, depth, region_.nearest_point({ball.cx, ball.cy}));
            }
        }
        if (!is_kept || (!(ball.cz > ball.rho) && !(ball.cz < -ball.rho))) {
            const ExactBall exact = placed_ball(*frame_, world);
            if (exact.behind().sign() != Sign::Positive && exact.width().sign() != Sign::Negative) {
                // The sphere meets the base plane in a disk of squared radius (rho - cz)(rho + cz) >= 0.
                const Sign depth =
                    region_.reach({exact.c.x, exact.c.y, exact.d}, -(exact.behind() * exact.width()));
                if (depth != Sign::Negative)
                    fail_touching(i, depth, region_.nearest_point({ball.cx, ball.cy}));
            }
            if (exact.width().sign() != Sign::Positive) return objects_.leave_out_unmet(i);
        } else if (!(ball.cz > -ball.rho)) {
            return objects_.leave_out_unmet(i);
        }
        objects_.balls.add(world, i);
    }

    // The wall is reached above the base points within its disk on the base, of squared radius (R - cz)(R +
    // cz): there the height is positive, on the rim 0, and less beyond it.
    void add(std::uint32_t i, const HollowSphere& vessel) {
        const Ball world{vessel.center.x(), vessel.center.y(), vessel.center.z(), -vessel.radius};
        const ExactBall exact = placed_ball(*frame_, world);
        const ExactPoint c{exact.c.x, exact.c.y, exact.d};
        const Exact power = -(exact.behind() * exact.width());
        if (power.sign() != Sign::Positive || region_.reach(c, power) != Sign::Positive)
            fail_empty("holds none of the base plane within the wall of " + object_path(scene_, i));
        is_cut_by_vessel_ = is_cut_by_vessel_ || !region_.lies_in_disk(c, power);
        vessels_.add(world, i);
    }

    void add(std::uint32_t i, const Plane& plane) {
        HalfSpace world(plane.point, plane.normal);
        HalfSpaceOverBase h{frame_->turned(plane.normal), {}, frame_->norm() * world.length};
        // A plane parallel to the base stays parallel to it.
        const bool is_level = cross(ExactVector(plane.normal), ExactVector(base_.normal)).is_zero();
        if (is_level && !frame_->is_exact()) {
            planes_turn_ = true;
            const bool up = h.n.z.sign() == Sign::Positive;
            h.n = {Exact(), Exact(), up ? h.length : -h.length};
        }
        // n.p + d = 0 in p's canonical place, which is that of the plane's point.
        const ExactVector p = frame_->place(plane.point);
        h.d = -dot(h.n, p);
        h.n = frame_->norm() * h.n;
        h.length = frame_->norm() * h.length;
        // Linear over the region: the corners tell.
        const auto& corners = region_.corners();
        std::vector<Sign> signs;
        for (const ExactPoint& c : corners) signs.push_back((h.n.x * c.x + h.n.y * c.y + h.d * c.d).sign());
        // A base that has turned by rounding may part from what touches it in the scene.
        for (std::size_t c = 0; c < corners.size() && !frame_->is_exact() && !has_floor_; ++c) {
            if (side_of(plane, world_corners()[c]) != signs[c]) signs[c] = Sign::Zero;
        }
        const auto differs = std::adjacent_find(signs.begin(), signs.end(), std::not_equal_to<>());
        const auto zero = std::find(signs.begin(), signs.end(), Sign::Zero);
        if (differs != signs.end() || zero != signs.end()) {
            const bool cuts = std::count(signs.begin(), signs.end(), Sign::Positive) > 0 &&
                              std::count(signs.begin(), signs.end(), Sign::Negative) > 0;
            fail_touching(i, cuts ? Sign::Positive : Sign::Zero, place_of_contact(h, corners, signs));
        }
        if (signs.front() == Sign::Negative) {
            world = -world;
            h = {Exact(-1.0) * h.n, -h.d, h.length};
        }
        objects_.planes.add(world, i);
        placed_planes_.push_back(h);
    }

    const std::vector<WorldPoint>& world_corners() {
        if (world_corners_.empty())
            for (std::size_t i = 0; i < sides_.size(); ++i)
                world_corners_.push_back(world_corner(
                    base_, scene_.box, sides_[(i + sides_.size() - 1) % sides_.size()].site, sides_[i].site));
        return world_corners_;
    }

    CylinderForm form_of(std::uint32_t tube) const { return placed_form(*frame_, scene_.objects[tube]); }

    void add(std::uint32_t i, const Cylinder& cylinder) {
        const CylinderForm form = form_of(i);
        const CylinderTrace trace = trace_on_base(form);
        Sign clear = region_.lowest(trace, Exact());
        // A base that has turned by rounding may part from what touches it in the scene.
        if (!frame_->is_exact() && !has_floor_)
            clear = std::min(clear, lowest_in_world(cylinder, base_, scene_.box, world_corners()));
        if (clear != Sign::Positive) fail_touching(i, -clear, region_.lowest_point(trace));
        const bool is_level = dot(ExactVector(cylinder.axis), ExactVector(base_.normal)).sign() == Sign::Zero;
        const ExactCylinder exact = exact_cylinder(form);
        if (is_level && (exact.pz + exact.rho).sign() != Sign::Positive) return objects_.leave_out_unmet(i);
        if (region_.lowest(trace, smallest_coefficient) == Sign::Negative)
            objects_.fail(Kind::OutOfRange, i,
                          "is so close to the base that its height leaves the range of doubles");
        add_tube(form, i);
        objects_.cylinders.add(world_form(cylinder), i);
    }
    void add_tube(const CylinderForm& form, std::uint32_t object) {
        if (const double steep = form.steep(); steep != 0 && std::abs(steep) < smallest_slope)
            objects_.fail(Kind::OutOfRange, object,
                          "is so nearly parallel to the base that its height leaves the range of doubles");
        tubes_.push_back(object);
    }

    // The wall is reached above the base points in the tube: within its trace, an ellipse, or a strip where
    // the axis is parallel to the base. Of equal tubes the first stands for all, and others hide wider ones.
    void add(std::uint32_t i, const HollowCylinder& vessel) {
        const CylinderForm form = form_of(i);
        const CylinderTrace trace = trace_on_base(form);
        if (region_.lowest(trace, Exact()) != Sign::Negative)
            fail_empty("holds none of the base plane within the wall of " + object_path(scene_, i));
        is_cut_by_vessel_ = is_cut_by_vessel_ || !region_.lies_within(trace);
        add_tube(form, i);
        objects_.hollow_cylinders.add(world_form(vessel), i);
    }
    // The trace of a cone is a conic of any kind.
    void add(std::uint32_t i, const HollowCone& vessel) {
        const CylinderForm form = form_of(i);
        const CylinderTrace trace = trace_on_base(form);
        if (!region_.meets_cone(trace))
            fail_empty("holds none of the base plane within the wall of " + object_path(scene_, i));
        is_cut_by_vessel_ = is_cut_by_vessel_ || !region_.lies_in_cone(trace);
        add_tube(form, i);
        objects_.hollow_cones.add(ConeForm(vessel), i);
    }

    void drop_hidden() {
        std::vector<LinearForm> walls = objects_.half_spaces();
        std::vector<Site> of_walls;
        for (const std::uint32_t plane : objects_.planes.objects) of_walls.push_back(objects_.site(plane));
        for (const BoxSide& side : box_) {
            if (!(side.m.z() > 0)) continue;
            walls.push_back(half_way_to_image(base_, WorldSide(scene_.box, side.index)));
            of_walls.push_back(Site::box_side(side.index));
        }
        objects_.drop_hidden_by_cylinders(walls, of_walls, {});
    }

    CircularForm rounded(const LinearForm& exact, Site site) const {
        for (const Exact& x : exact) check_range(nearest(x), x.sign() == Sign::Zero, site);
        CircularForm f;
        f.a = nearest(exact[0]);
        f.b = nearest(exact[1]);
        f.e = nearest(exact[2]);
        f.w = nearest(exact[3]);
        return f;
    }

    // Pre: is_zero says whether the coefficient that x rounds is exactly zero.
    void check_range(double x, bool is_zero, Site site) const {
        if (is_zero || std::abs(x) >= smallest_coefficient) return;
        const std::string what =
            "is so close to the base, or so nearly parallel to it, that its height leaves the range of "
            "doubles";
        if (site.is_object())
            objects_.fail(Kind::OutOfRange, static_cast<std::uint32_t>(scene_.place(site.index)), what);
        throw InputError(Kind::OutOfRange, InputError::no_object, "box",
                         "side " + to_string(site) + " " + what);
    }

    // One form for every distinct height, in the order of their first sites: objects, then box sides.
    void make_forms() {
        const auto& balls = objects_.balls;
        const auto& planes = objects_.planes;
        const std::vector<std::uint32_t> first_ball = first_equal(balls.items);
        // Planes that are multiples of each other are one plane, though their |n| may be told differently.
        const std::vector<std::uint32_t> first_plane = first_equal(objects_.half_spaces());
        std::vector<LinearForm> plane_forms;
        std::vector<LinearForm> linear;
        std::vector<Site> linear_sites;
        for (std::size_t i = 0; i < planes.size(); ++i) {
            const LinearForm form =
                first_plane[i] < i ? plane_forms[first_plane[i]] : plane_form(placed_planes_[i]);
            plane_forms.push_back(form);
            if (!objects_.is_kept(planes.objects[i])) continue;
            if (form[3].sign() != Sign::Positive) {
                objects_.leave_out_unmet(planes.objects[i]);
                continue;
            }
            linear.push_back(form);
            linear_sites.push_back(objects_.site(planes.objects[i]));
        }
        for (const BoxSide& side : box_) {
            if (!(side.m.z() > 0)) continue;
            linear.push_back({-side.m.x(), -side.m.y(), side.k, side.m.z()});
            linear_sites.push_back(Site::box_side(side.index));
        }
        const std::vector<std::uint32_t> first_linear = first_equal(linear);

        std::vector<FormId> ball_forms(balls.size()), linear_forms(linear.size());
        forms_.reserve(balls.size() + linear.size());
        sites_.reserve(balls.size() + linear.size() + objects_.cylinders.size());
        std::vector<FormId> vessel_forms(vessels_.size());
        const std::vector<std::uint32_t> first_vessel = first_equal(vessels_.items);
        const auto add_round = [&](const WorldObjects::Listed<Ball>& listed, const auto& first, auto& forms,
                                   std::size_t i) {
            if (!objects_.is_kept(listed.objects[i])) return;
            const Site own = objects_.site(listed.objects[i]);
            if (first[i] < i)
                sites_.join(forms[i] = forms[first[i]], own);
            else
                forms[i] = add_ball_form(listed.items[i], own);
        };
        const auto add_linear = [&](std::size_t i) {
            if (first_linear[i] < i) {
                linear_forms[i] = linear_forms[first_linear[i]];
                sites_.join(linear_forms[i], linear_sites[i]);
                return;
            }
            linear_forms[i] = forms_.push_back(rounded(linear[i], linear_sites[i]));
            const auto& [a, b, c, w] = linear[i];
            sources_->push_back(std::make_shared<const ExactForm>(ExactForm{Exact(), a, b, c, w}));
            sites_.add(linear_sites[i]);
            // A side of the box is as far as the base's image across it.
            const Site site = linear_sites[i];
            if (!site.is_object() &&
                objects_.has_beyond_wall(half_way_to_image(base_, WorldSide(scene_.box, site.index))))
                hidden_sides_.push_back(linear_forms[i]);
        };
        std::size_t ball = 0, vessel = 0;
        const auto add_balls_before = [&](Site end) {
            while (ball < balls.size() && objects_.site(balls.objects[ball]) < end)
                add_round(balls, first_ball, ball_forms, ball++);
        };
        // The last of them is a side of the box: there is one that rays leave through.
        for (std::size_t i = 0; i < linear.size(); ++i) {
            for (; vessel < vessels_.size(); ++vessel) {
                const Site own = objects_.site(vessels_.objects[vessel]);
                if (!(own < linear_sites[i])) break;
                add_balls_before(own);
                add_round(vessels_, first_vessel, vessel_forms, vessel);
            }
            add_balls_before(linear_sites[i]);
            add_linear(i);
        }
        if (has_floor_ || is_cut_by_vessel_) add_floor(linear, linear_sites);
    }

    FormId add_ball_form(const Ball& ball, Site site) {
        const CircularForm f = rounded_form(*frame_, ball);
        const bool is_on_base = frame_->keeps(center_of_ball(ball))
                                    ? std::abs(rounded_ball(*frame_, ball).cz) == std::abs(ball.rho)
                                    : f.e == 0;
        check_range(f.e, is_on_base, site);
        check_range(f.w, false, site);
        sources_->push_back(ball);
        sites_.add(site);
        return forms_.push_back(f);
    }

    // The base, and with a region for them the sides through which rays come in.
    void add_floor(const std::vector<LinearForm>& others, const std::vector<Site>& sites) {
        const auto add = [&](const LinearForm& form, Site site) {
            for (std::size_t i = 0; i < others.size(); ++i)
                if (compare_rays(form, others[i]) == 0)
                    objects_.fail(Kind::Unsupported, static_cast<std::uint32_t>(scene_.place(sites[i].index)),
                                  "is as far as the base all along side " + to_string(site) +
                                      " of the box, through which the base's rays come in");
            floor_.push_back(forms_.push_back(rounded(form, site)));
            const auto& [a, b, c, w] = form;
            sources_->push_back(std::make_shared<const ExactForm>(ExactForm{Exact(), a, b, c, w}));
            sites_.add(site);
        };
        add({Exact(), Exact(), Exact(), Exact(1.0)}, Site::base());
        if (!has_floor_) return;
        for (const BoxSide& side : box_)
            if (side.m.z() < 0 && (side.m.x() != 0 || side.m.y() != 0))
                add({side.m.x(), side.m.y(), -side.k, -side.m.z()}, Site::box_side(side.index));
    }

    // Cylinders come after the circular forms, the floor among them, in the order of their objects.
    void add_cylinders() {
        std::map<std::uint32_t, FormId> forms;
        for (const std::uint32_t object : tubes_) {
            const std::uint32_t owner = objects_.owner(object);
            if (owner == object)
                forms[object] = sites_.add(objects_.site(object));
            else if (owner != WorldObjects::none)
                sites_.join(forms[owner], objects_.site(object));
        }
    }

    const Scene& scene_;
    const bool has_floor_;
    const Plane& base_;
    const std::shared_ptr<const PlaneFrame> frame_;
    const std::array<BoxSide, 6>& box_;
    const std::vector<RegionSide> sides_;
    std::vector<WorldPoint> world_corners_;  // of the region, once a cylinder asks for them
    const BaseRegion region_;
    const double unit_;

    WorldObjects objects_;                          // planes with the region on the positive side
    std::vector<HalfSpaceOverBase> placed_planes_;  // in canonical coordinates
    WorldObjects::Listed<Ball> vessels_;            // hollow
    std::vector<std::uint32_t> tubes_;              // and hollow cones, ascending
    bool is_cut_by_vessel_ = false;                 // the base region
    bool planes_turn_ = false;                      // with the base

    IdVector<FormId, CircularForm> forms_;
    FormSites sites_;
    std::vector<FormId> floor_, hidden_sides_;
    std::shared_ptr<IdVector<FormId, FormSource>> sources_;
};

}  // namespace

PlaneBaseProblem plane_base_problem(const Scene& scene, double unit) {
    const auto* base = std::get_if<Plane>(&scene.base);
    if (base == nullptr)
        throw InputError(Kind::Unsupported, InputError::no_object,
                         std::holds_alternative<Sphere>(scene.base) ? "base.sphere" : "base.cylinder",
                         "only planes are bases in this version");
    check_base_cuts_box(*base, scene.box);
    return ProblemBuilder(scene, *base, unit, false).build();
}

bool lets_rays_in(const Scene& scene, std::uint32_t side) {
    const auto* base = std::get_if<Plane>(&scene.base);
    if (base == nullptr) return false;
    const double along = base->normal[side / 2];
    return side % 2 == 0 ? along > 0 : along < 0;
}

bool may_be_completed(const Scene& scene) { return std::holds_alternative<Plane>(scene.base); }

std::optional<PlaneBaseProblem> complete_plane_base_problem(const Scene& scene, double unit) {
    if (!may_be_completed(scene)) return std::nullopt;
    const Plane& base = std::get<Plane>(scene.base);
    check_base_cuts_box(base, scene.box);
    const PlaneFrame frame(base, scene.box);
    if (!has_rays_from_outside(base, scene.box, frame.box())) return std::nullopt;
    return ProblemBuilder(scene, base, unit, true).build();
}

std::array<double, 4> PlaneBaseProblem::chart_box() const {
    std::array<double, 4> box{HUGE_VAL, -HUGE_VAL, HUGE_VAL, -HUGE_VAL};
    for (const Eigen::Vector2d& c : corners)
        box = {std::min(box[0], c.x()), std::max(box[1], c.x()), std::min(box[2], c.y()),
               std::max(box[3], c.y())};
    return box;
}

double region_area(const std::vector<RegionSide>& region) {
    // A fan of triangles from corner 0, all of positive area: no cancellation between terms, and each
    // numerator is exact.
    const std::vector<ExactPoint> p = region_corners(region);
    Interval twice(0.0);
    for (std::size_t i = 1; i + 1 < p.size(); ++i) {
        const Exact ux = p[i].x * p[0].d - p[0].x * p[i].d, uy = p[i].y * p[0].d - p[0].y * p[i].d;
        const Exact vx = p[i + 1].x * p[0].d - p[0].x * p[i + 1].d,
                    vy = p[i + 1].y * p[0].d - p[0].y * p[i + 1].d;
        twice += (ux * vy - uy * vx).enclosure() / (p[0].d * p[0].d * p[i].d * p[i + 1].d).enclosure();
    }
    return 0.5 * twice.mid();
}

}  // namespace vcell
