#include "complete_measures.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <utility>

#include "../core/errors.hpp"
#include "../core/platform.hpp"
#include "../primitives/bases/canonical.hpp"
#include "../primitives/bases/cylinder_base.hpp"
#include "../primitives/bases/sphere_base.hpp"
#include "../primitives/objects/decided_scene.hpp"
#include "axis_parts.hpp"
#include "base_diagram.hpp"
#include "lift/lift.hpp"
#include "object_distance.hpp"
#include "voronoi_cell.hpp"

namespace vcell {

namespace {

// Rays of planes and balls start this far from a side's plane at least, as a part of the box's diagonal. What
// is left out counts in full.
constexpr double least_room = AxisParts::least_rooms.front();

// How much steeper the area of a face beside the plane with this normal is than its width across the plane:
// by the angle between the two in a place of both, less 1. Where they all but touch, as much as about a
// circle of the box's size next to its tangent.
double steepness(const Object& base, const Object& object, const Vec3& normal, const Vec3& place,
                 double diagonal) {
    constexpr double step = 0x1p-20, most = 0x1p16;
    Vec3 gradient;
    for (int k = 0; k < 3; ++k) {
        const Vec3 off = step * diagonal * Vec3::Unit(k), before = place - off, after = place + off;
        gradient[k] = (distance_from(base, after) - distance_from(object, after)) -
                      (distance_from(base, before) - distance_from(object, before));
    }
    const double sine = gradient.normalized().cross(normal).norm();
    return std::min(most, 1 / sine) - 1;
}

constexpr int sign_of(unsigned subset) { return std::popcount(subset) % 2 == 0 ? 1 : -1; }

// Measures added and taken away.
class Sum {
public:
    Sum() = default;
    /// Slabs along sides of the box may be left out.
    explicit Sum(const Scene& scene) : scene_(&scene) {}

    /// `alone`: the sides of the box that the cell is beyond, one bit each; it ends in their planes.
    void add(const Cell& cell, unsigned alone) {
        const int sign = sign_of(alone);
        add_slanting(cell);
        add_crossings(cell, alone, -sign);
        if (!std::isfinite(cell.measures.volume + cell.measures.volume_error + cell.measures.area +
                           cell.measures.area_error))
            throw UndecidedError("the cell's measures: no bound on their error");
        add(volume_, sign * cell.measures.volume, cell.measures.volume_error);
        for (const CellFace& face : cell.faces) {
            add_area(face.site, sign, face);
            for (const Site site : face.extra_sites) add_area(site, sign, face);
            if (face.site.is_object()) add(area_, sign * face.area, face.area_error);
            if (face.site.kind == Site::Kind::Cap) add(exposed_, sign * face.area, face.area_error);
        }
        is_estimated_ = is_estimated_ || cell.measures.is_estimated;
        assumed_ += cell.report.decisions.assumed;
    }
    // Slabs of the box that no term contains. What faces they hold is not known: those that do not run along
    // a slab have about its circumference times its width, and more where they slant.
    void leave_out(const AxisParts::LeftOut& what, double diagonal) {
        if (what.width == 0 && what.volume == 0 && what.area == 0) return;
        volume_.error += what.width * 0.25 * std::numbers::pi * diagonal * diagonal + what.volume;
        const double area = what.width * (std::numbers::pi * diagonal + slanting_) + what.area;
        area_.error += area;
        exposed_.error += area;
        left_out_ += area;
        is_estimated_ = true;
    }
    CompleteMeasures result(double unit) const {
        CompleteMeasures m;
        const double square = unit * unit;
        m.volume = unit * square * std::max(0.0, volume_.value);
        m.volume_error = unit * square * volume_.bound();
        m.area = square * std::max(0.0, area_.value);
        m.area_error = square * area_.bound();
        m.exposed_area = square * std::max(0.0, exposed_.value);
        m.exposed_error = square * exposed_.bound();
        m.is_estimated = is_estimated_;
        m.assumed = assumed_;
        // What is left out can only add to a share.
        for (const auto& [object, share] : shares_)
            if (share.is_neighbor())
                m.neighbors.push_back({object, square * std::max(0.0, share.area.value),
                                       square * (share.area.bound() + left_out_)});
        std::ranges::stable_sort(m.neighbors, std::ranges::greater(), &CompleteMeasures::Neighbor::area);
        return m;
    }

private:
    // The length of edges on sides of the box, times by how much faces there are steeper.
    void add_slanting(const Cell& cell) {
        if (scene_ == nullptr) return;
        for (const CellEdge& e : cell.edges)
            for (const int i : {0, 1}) {
                const Site &object = e.sites[i], &side = e.sites[1 - i];
                if (!object.is_object() || side.kind != Site::Kind::BoxSide) continue;
                double most = 0;
                constexpr int parts = 4;
                for (int k = 0; k <= parts; ++k)
                    most = std::max(
                        most, steepness(scene_->base, scene_->objects[scene_->place(object.index)],
                                        Vec3::Unit(side.index / 2),
                                        e.curve.evaluate(std::lerp(e.curve.domain_begin(),
                                                                   e.curve.domain_end(), 1.0 * k / parts)),
                                        scene_->box.diagonal()));
                if (e.length > 0) slanting_ += most * e.length;
            }
    }

    struct Term {
        double value = 0, error = 0, size = 0;
        std::size_t terms = 0;

        double bound() const {
            return error + std::numeric_limits<double>::epsilon() * static_cast<double>(terms) * size;
        }
    };
    // A face that is smaller than its bound may be seen all the same: nothing of it is taken away, or on a
    // side of the box that rays come in through it has an edge.
    struct Share {
        Term area;
        std::array<Term, 6> edges;
        bool is_taken_away = false;

        bool is_neighbor() const {
            const auto is_there = [](const Term& term) { return term.value > term.bound(); };
            return !is_taken_away || is_there(area) || std::ranges::any_of(edges, is_there);
        }
    };
    // Edges between faces and the planes of sides in which a cell beyond them ends: what all cells have of
    // them together is what the box has.
    void add_crossings(const Cell& cell, unsigned alone, int sign) {
        for (const CellEdge& e : cell.edges)
            for (const int i : {0, 1}) {
                const Site &object = e.sites[i], &side = e.sites[1 - i];
                if (!object.is_object() || side.kind != Site::Kind::BoxSide) continue;
                const unsigned opposite = side.index ^ 1U;
                if ((alone >> opposite & 1U) == 0 || !(e.length > 0)) continue;
                add(shares_[object.index].edges[opposite], sign * e.length, e.length_error);
            }
    }
    static void add(Term& term, double value, double error) {
        term.value += value;
        term.error += error;
        term.size += std::abs(value);
        ++term.terms;
    }
    void add_area(const Site& site, int sign, const CellFace& face) {
        if (!site.is_object()) return;
        Share& share = shares_[site.index];
        add(share.area, sign * face.area, face.area_error);
        share.is_taken_away = share.is_taken_away || sign < 0;
    }

    const Scene* scene_ = nullptr;
    double slanting_ = 0, left_out_ = 0;  // area in slabs
    Term volume_, area_, exposed_;
    std::map<std::uint32_t, Share> shares_;
    bool is_estimated_ = false;
    std::uint64_t assumed_ = 0;
};

Vec3 corner_of(const Box& box, unsigned corner) {
    const auto coordinate = [&](unsigned axis) {
        return ((corner & 1u << axis) != 0 ? box.max : box.min)[axis];
    };
    return {coordinate(0), coordinate(1), coordinate(2)};
}

// ---- Planes -----------------------------------------------------------------------------------------

// How far before the box, along each axis, base points lie whose rays come into it, and more than the
// rounding of that; 0 where none do. Feet are linear in the points of the box before the plane, and feet of
// points on it are in the box: its corners tell.
std::array<double, 3> steps_before(const Box& box, const Plane& base) {
    const double rounding = 0x1p-48 * (base.point.norm() + box.min.norm() + box.max.norm()),
                 least = least_room * box.diagonal() + rounding;
    const Vec3 n = base.normal.stableNormalized();
    std::array<double, 3> steps{0, 0, 0};
    for (unsigned corner = 0; corner < 8; ++corner) {
        const Vec3 p = corner_of(box, corner);
        const double height = n.dot(p - base.point) + rounding;
        if (height < 0) continue;
        for (int axis = 0; axis < 3; ++axis) {
            if (base.normal[axis] == 0) continue;
            const double foot = p[axis] - n[axis] * height,
                         step = n[axis] > 0 ? box.min[axis] - foot : foot - box.max[axis];
            if (step > -least) steps[axis] = std::max(steps[axis], step + 2 * least);
        }
    }
    return steps;
}

CompleteMeasures of_plane(Scene scene, const Plane& base) {
    const Box box = scene.box;
    scene.tolerance = scene.fit_tolerance();
    const std::array<double, 3> steps = steps_before(box, base);
    Sum sum;
    for (unsigned before = 0; before < 8; ++before) {
        scene.box = box;
        bool is_asked = true;
        unsigned alone = 0;
        for (unsigned axis = 0; axis < 3; ++axis) {
            const bool is_alone = (before & 1u << axis) != 0;
            is_asked = is_asked && (!is_alone || steps[axis] > 0);
            if (is_alone) alone |= 1U << (2 * axis + (base.normal[axis] > 0 ? 0 : 1));
            if (base.normal[axis] > 0) {
                if (is_alone) scene.box.max[axis] = box.min[axis];
                scene.box.min[axis] = box.min[axis] - steps[axis];
            } else {
                if (is_alone) scene.box.min[axis] = box.max[axis];
                scene.box.max[axis] = box.max[axis] + steps[axis];
            }
        }
        if (!is_asked) continue;
        try {
            sum.add(voronoi_cell(scene), alone);
        } catch (const InputError& e) {
            if (e.kind != InputError::Kind::EmptyBox) throw;
        }
    }
    return sum.result(1);
}

// ---- Balls and tubes --------------------------------------------------------------------------------

// How points from which rays start lie to the sides of the box.
struct BoxSides {
    Box box;                     // the sides that they all but lie on moved outwards
    std::array<bool, 6> beyond;  // on the outer side of this one
    double moved = 0;            // by how much at most
};

// room(S): the box, with what is beyond the sides in S instead and with that and the box for the others that
// rays start beyond. They start within `around`.
Box room(const BoxSides& sides, unsigned subset, const Box& around) {
    Box room = sides.box;
    const double space = 0.25 * sides.box.diagonal();
    for (unsigned s = 0; s < 6; ++s) {
        if (!sides.beyond[s]) continue;
        const unsigned axis = s / 2;
        const bool is_alone = (subset & 1u << s) != 0;
        if (s % 2 == 0) {
            if (is_alone) room.max[axis] = sides.box.min[axis];
            room.min[axis] = around.min[axis] - space;
        } else {
            if (is_alone) room.min[axis] = sides.box.max[axis];
            room.max[axis] = around.max[axis] + space;
        }
    }
    return room;
}

Cell lift(const RadialBaseProblem& problem, const DecidedScene& decided) {
    const double tolerance = decided.scene.fit_tolerance();
    const MinimizationDiagram diagram = diagram_of(problem, {});
    // Trims on a cap may be fitted, and widen the bounds; some faces in vessels have no patches around a
    // cylinder.
    const bool is_bare = decided.scene.probe || (problem.family.forms.empty() && may_have_tips(problem));
    LiftedCell lifted = is_bare ? lift_without_patches(problem, diagram, tolerance, true)
                                : lift_all_around(problem, diagram, tolerance, true);
    if (decided.scene.probe) name_cap(lifted.cell, decided.cap(), *decided.scene.probe);
    return std::move(lifted.cell);
}

template <class Problem>  // make_problem(room) of these rays
void add_rooms(Sum& sum, const BoxSides& sides, const Box& around, const DecidedScene& decided,
               Problem make_problem) {
    unsigned beyond = 0;
    for (unsigned s = 0; s < 6; ++s)
        if (sides.beyond[s]) beyond |= 1u << s;
    for (unsigned subset = 0; subset < 64; ++subset) {
        if ((subset & ~beyond) != 0) continue;
        sum.add(lift(make_problem(room(sides, subset, around)), decided), subset);
    }
}

CompleteMeasures of_sphere(const DecidedScene& decided, const Sphere& base) {
    const Scene& scene = decided.scene;
    const double least = least_room * scene.box.diagonal();
    BoxSides sides{scene.box, {}};
    for (unsigned s = 0; s < 6; ++s) {
        double& bound = (s % 2 == 0 ? sides.box.min : sides.box.max)[s / 2];
        const double sign = s % 2 == 0 ? -1 : 1, center = base.center[s / 2];
        sides.beyond[s] = sign * (center - bound) > least;
        if (sides.beyond[s] || sign * (bound - center) > least) continue;
        bound = center + sign * least;
        sides.moved += 2 * least;
    }
    Sum sum(scene);
    add_rooms(sum, sides, {base.center, base.center}, decided, [&](const Box& room) {
        Scene part = scene;
        part.box = room;
        return sphere_base_problem(part, base, decided.unit);
    });
    sum.leave_out({sides.moved}, scene.box.diagonal());
    return sum.result(decided.unit);
}

class AroundCylinder {
public:
    AroundCylinder(const DecidedScene& decided, const Cylinder& base)
        : decided_(decided),
          scene_(decided.scene),
          base_(base),
          unit_(decided.unit),
          diagonal_(scene_.box.diagonal()),
          least_(least_room * diagonal_),
          frame_(cylinder_frame(scene_, base_)),
          box_(scene_.box),
          sum_(scene_) {}

    CompleteMeasures operator()() {
        move_sides(AxisParts::range(box_, frame_));
        const AxisParts axis(scene_, base_, box_, frame_);
        for (const std::array<double, 2>& part : axis.parts()) add(axis, part);
        sum_.leave_out(left_out_, diagonal_);
        return sum_.result(unit_);
    }

private:
    // BoxSides that the axis runs along so closely that less is left out if they move out of its way than if
    // the axis is cut where it crosses them.
    void move_sides(const std::array<double, 2>& range) {
        for (const BoxSide& side : canonical_box(box_, frame_)) {
            const double slope = std::abs(side.m.y()), low = side.k - side.m.y() * range[0],
                         high = side.k - side.m.y() * range[1];
            if (AxisParts::is_across(side) || std::min(low, high) > least_ || std::max(low, high) < -least_)
                continue;
            if (slope * std::max(std::abs(low), std::abs(high)) > least_) continue;
            const double step = least_ - std::min(low, high);
            double& bound = (side.index % 2 == 0 ? box_.min : box_.max)[side.index / 2];
            bound += side.index % 2 == 0 ? -step : step;
            left_out_.width += step;
        }
    }

    void add(const AxisParts& axis, const std::array<double, 2>& part) {
        left_out_ += axis.on_clear_stretch(
            part, [&](const std::array<bool, 6>& beyond, const std::array<double, 2>& stretch) {
                Sum sum = sum_;
                add(sum, beyond, stretch);
                sum_ = std::move(sum);
            });
    }

    void add(Sum& sum, const std::array<bool, 6>& beyond, const std::array<double, 2>& stretch) const {
        const BoxSides sides{box_, beyond};
        const Vec3 p = frame_.to_world({0, stretch[0], 0}), q = frame_.to_world({0, stretch[1], 0});
        add_rooms(sum, sides, {p.cwiseMin(q), p.cwiseMax(q)}, decided_, [&](const Box& room) {
            const CylinderPart part{room, stretch, {}};
            return cylinder_base_problem(scene_, base_, unit_, &part);
        });
    }

    const DecidedScene& decided_;
    const Scene& scene_;
    const Cylinder& base_;
    const double unit_, diagonal_, least_;
    const BaseFrame frame_;
    Box box_;
    AxisParts::LeftOut left_out_;
    Sum sum_;
};

// Pre: validate(scene) has passed, but for a probe that may be 0.
CompleteMeasures measures_of(const Scene& scene) {
    if (const auto* plane = std::get_if<Plane>(&scene.base)) return of_plane(scene, *plane);
    const DecidedScene decided = decide(scene);
    if (const auto* sphere = std::get_if<Sphere>(&decided.scene.base)) return of_sphere(decided, *sphere);
    return AroundCylinder(decided, std::get<Cylinder>(decided.scene.base))();
}

}  // namespace

CompleteMeasures complete_measures(const Scene& scene) {
    return in_ieee_arithmetic("complete_measures()", [&] {
        validate(scene);
        return measures_of(scene);
    });
}

CompleteMeasures complete_body_measures(Scene scene) {
    return in_ieee_arithmetic("complete_body_measures()", [&] {
        validate(scene);
        scene.probe = 0;
        return measures_of(scene);
    });
}

}  // namespace vcell
