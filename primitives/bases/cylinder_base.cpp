#include "cylinder_base.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "../forms/axial_ties.hpp"
#include "../objects/message.hpp"
#include "cylinder_entries.hpp"
#include "cylinder_forms.hpp"
#include "given_axis.hpp"
#include "given_equations.hpp"
#include "radial_objects.hpp"

namespace vcell {

namespace {

using cylinder_entries::Entry;
using cylinder_entries::with_equal_ones;
using cylinder_forms::CylinderForms;
using cylinder_forms::CylinderFrame;
using cylinder_forms::GivenAxis;
using cylinder_forms::Side;
using Kind = InputError::Kind;

// These are sought among what is no floor: beside one, too, what is nowhere the least of the others does not
// show.
template <class Sites>
void add_passing_ties(const Sites& sites, RadialBaseProblem& problem) {
    const std::span<const RadialForm> forms = problem.family.radial;
    for (const PassingTie& tie : find_passing_ties(forms.first(forms.size() - problem.floor.size()))) {
        for (const std::array<double, 2>& x : tie.ranges)
            problem.family.hidden.push_back({FormId{tie.form}, x, {-infinity, infinity}});
        for (const Site site : sites[FormId{tie.form}])
            problem.generator_ties.push_back({site, FormId{tie.before}, FormId{tie.after}, true});
    }
}

// In box diagonals, some times the rounding of coordinates.
constexpr double tie_rounding = 0x1p-50;
// Places in a box that repeats were moved to a grid (voronoi_diagram.hpp).
constexpr double grid_rounding = 0x1p-42;

class CylinderProblem {
public:
    CylinderProblem(const Scene& scene, const Cylinder& base, double unit, const CylinderPart* part)
        : scene_(scene),
          base_(base),
          unit_(unit),
          walls_(part != nullptr ? part->walls : scene.box),
          sides_(part != nullptr ? part->sides : std::array<CylinderPart::Wall, 6>{}),
          frame_(scene, base),
          given_{frame_, base},
          forms_{frame_, base.radius},
          motion_(frame_.rounded()),
          stretch_(part != nullptr ? part->stretch : stretch()),
          objects_(scene) {}

    RadialBaseProblem build() {
        for (std::uint32_t i = 0; i < scene_.objects.size(); ++i)
            if (scene_.competes(i))
                std::visit([&](const auto& object) { add(i, object); }, scene_.objects[i]);
        objects_.drop_hidden_and_equal(mirrored());
        return make_problem();
    }

private:
    static constexpr const char* contains_section = "contains a cross section of the base";

    Side side(std::uint32_t s) const {
        const WorldSide side(walls_, s);
        return {Site::box_side(s), frame_.turned(ExactVector(side.normal())), side.distance(frame_.origin)};
    }

    // Where R |(n.x, n.z)| + n.y y <= norm distance for all sides that the axis runs into, R = R0 or the
    // least radius of such a circle.
    std::array<double, 2> stretch() {
        std::array<double, 2> range{-infinity, infinity};
        for (std::uint32_t s = 0; s < 6; ++s) {
            const Side side = this->side(s);
            const Sign ahead = side.normal.y.sign();
            if (ahead == Sign::Zero) {
                const Sign room = side.distance.sign();
                if (room != Sign::Positive)
                    fail_empty("contains nothing of the base cylinder's axis (base.cylinder): it lies " +
                               std::string(room == Sign::Zero ? "on" : "beyond") + " side " +
                               to_string(side.site));
                if (nearest(side.distance) < smallest_coefficient)
                    throw InputError(Kind::OutOfRange, InputError::no_object, "box",
                                     "side " + to_string(side.site) +
                                         " is so close to the base cylinder's axis (base.cylinder) that its "
                                         "height leaves the range of doubles");
                continue;
            }
            Interval end;
            if (side.is_across_axis()) {
                end = ahead == Sign::Positive ? side.distance.enclosure() : -side.distance.enclosure();
            } else {
                const double radius = end_radius(base_, scene_.box);
                const Exact across2 = Exact(radius) * radius * side.across2();
                end = ((frame_.norm * side.distance).enclosure() - sqrt(across2.enclosure())) /
                      side.normal.y.enclosure();
            }
            const bool is_last = ahead == Sign::Positive;
            const double y = is_last ? end.lower() : end.upper();
            if (is_last ? y >= range[1] : y <= range[0]) continue;
            range[is_last] = y;
            const bool is_early = !side.is_across_axis() && base_.radius < end_radius(base_, scene_.box);
            early_ends_[is_last] = is_early ? std::optional(side.site) : std::nullopt;
        }
        if (!(range[0] < range[1])) fail_empty("contains no stretch of the base cylinder (base.cylinder)");
        return range;
    }

    // The base beyond the sides along its axis.
    std::vector<std::pair<CylinderForm, Site>> mirrored() const {
        std::vector<std::pair<CylinderForm, Site>> images;
        for (std::uint32_t s = 0; s < 6; ++s) {
            const Side side = this->side(s);
            if (!side.is_along_axis() || sides_[s] != CylinderPart::Wall::Inside) continue;
            const WorldSide world(walls_, s);
            Vec3 p = base_.point;
            p[world.axis] = 2 * world.bound - p[world.axis];
            // An image that is not given by doubles is no object's equal.
            if (Exact(p[world.axis]) + base_.point[world.axis] != 2.0 * Exact(world.bound)) continue;
            images.push_back({world_form(Cylinder{p, frame_.axis, base_.radius}), side.site});
        }
        return images;
    }

    void add(std::uint32_t i, const Sphere& sphere) {
        const Vec3& c = sphere.center;
        const Ball ball{c.x(), c.y(), c.z(), sphere.radius};
        const RadialForm f = forms_.form(ball);
        if (!is_positive(f.c) || given_.is_touched_by(ball, stretch_))
            objects_.fail(Kind::TouchesBase, i,
                          ball.rho >= base_.radius ? contains_section : "lies in the base");
        // B / W is largest in the ball's direction: the distance of its centre from the axis, plus delta.
        const Exact across2 = f.b[0] * f.b[0] + f.b[2] * f.b[2];
        if (f.b0.sign() != Sign::Positive && (across2 - f.b0 * f.b0).sign() != Sign::Positive)
            objects_.leave_out_unmet(i);
        else
            objects_.balls.add(ball, i);
    }

    // Clear of the solid cylinder over the stretch: of the circles at both ends, on one side.
    void add(std::uint32_t i, const Plane& plane) {
        HalfSpace h(plane.point, plane.normal);
        const Exact at_origin = frame_.norm * h(ExactVector(frame_.origin));
        const ExactVector n = frame_.turned(ExactVector(h.n));
        const auto value = [&](double y) { return at_origin + y * n.y; };  // times norm
        const Sign side = value(stretch_[0]).sign();
        const Exact reach2 = Exact(base_.radius) * base_.radius * (n.x * n.x + n.z * n.z);
        for (const double y : stretch_) {
            const Exact v = value(y);
            const Sign clearance =
                v.sign() * side == Sign::Negative ? Sign::Negative : (v * v - reach2).sign();
            if (clearance == Sign::Positive) continue;
            const Vec3 normal = static_cast<int>(side) * frame_.rounded(n);
            const double across = std::hypot(normal.x(), normal.z());
            const Vec3 toward =
                across > 0 ? Vec3(-base_.radius / across * Vec3(normal.x(), 0, normal.z())) : Vec3::Zero();
            objects_.fail(Kind::TouchesBase, i,
                          std::string(cuts_or_touches(clearance)) + " the base at " +
                              to_text(unit_ * motion_.to_world(Vec3(0, y, 0) + toward)));
        }
        objects_.planes.add(side == Sign::Negative ? -h : h, i);
    }

    void add(std::uint32_t i, const Cylinder& cylinder) {
        const CylinderForm f = world_form(cylinder);
        if (const auto y = frame_.crossing(base_, cylinder)) {
            for (const Side& wall : walls_of_crossing(i, cylinder, *y))
                if (!is_positive(forms_.form(wall).c)) objects_.fail(Kind::TouchesBase, i, contains_section);
            objects_.cylinders.add(f, i);
            return;
        }
        const RadialForm height = forms_.form(f);
        const auto pierces = [&] {
            return cylinder.radius < base_.radius && CylinderForms::has_two_roots(height.c);
        };
        if (!(is_positive(height.c) || pierces()) || given_.is_touched_by(cylinder, stretch_)) {
            const bool same =
                cylinder.radius == base_.radius &&
                std::ranges::all_of(height.c, [](const auto& c) { return c.sign() == Sign::Zero; });
            objects_.fail(Kind::TouchesBase, i,
                          same                              ? "is the base itself"
                          : cylinder.radius >= base_.radius ? contains_section
                                                            : "lies in the base, or touches it from within");
        }
        objects_.cylinders.add(f, i);
    }
    void add(std::uint32_t i, const HollowSphere& vessel) {
        refuse_beyond(i, is_positive(forms_.form(vessel).c));
        objects_.hollow_balls.add(vessel, i);
    }
    void add(std::uint32_t i, const HollowCylinder& vessel) {
        const CylinderForm f = world_form(vessel);
        refuse_beyond(i, is_positive(forms_.hollow_form(f).c));
        objects_.hollow_cylinders.add(f, i);
    }
    // What is within a cone and its radius is convex: the ends of the stretch stand for all of it.
    void add(std::uint32_t i, const HollowCone& vessel) {
        const ConeForm f(vessel);
        const RadialForm height = forms_.hollow_form(f);
        refuse_beyond(i, is_positive(height.c) && is_within(f, stretch_[0]) && is_within(f, stretch_[1]));
        objects_.hollow_cones.add(f, i);
    }
    void refuse_beyond(std::uint32_t i, bool is_within) const {
        if (is_within) return;
        objects_.fail(Kind::TouchesBase, i,
                      "has a cross section of the base beyond its wall, between " +
                          to_text(unit_ * motion_.to_world(Vec3(0, stretch_[0], 0))) + " and " +
                          to_text(unit_ * motion_.to_world(Vec3(0, stretch_[1], 0))) +
                          ": a box that ends before would leave it out");
    }
    // P of cone_form.hpp, where y is.
    bool is_within(const ConeForm& f, double y) const {
        const Exact along = dot(ExactVector(frame_.origin) - f.apex, f.a) + f.g * base_.radius;
        return (frame_.norm * along + y * frame_.turned(f.a).y).sign() == Sign::Positive;
    }
    std::array<Side, 2> walls_of_crossing(std::uint32_t i, const Cylinder& tube, double y) const {
        return forms_.walls_of_crossing(objects_.site(i), base_, tube, y < stretch_[0]);
    }
    bool is_positive(const std::array<Exact, 3>& c) const { return CylinderForms::is_positive(c, stretch_); }

    template <class Tube>
    Tube canonical_tube(const Tube& tube, const CylinderForm& f) const {
        return {motion_.to_canonical(tube.point),
                forms_.is_along_base(f) ? Vec3::UnitY().eval()
                                        : frame_.rounded(frame_.turned(CylinderForms::direction(f))),
                tube.radius};
    }

    std::vector<Entry> all_entries() const {
        std::vector<Entry> entries;
        std::vector<std::array<Exact, 6>> rays;  // of rational heights, and whose they are
        std::vector<std::size_t> ray_entries;
        const auto add = [&](Site site, const Object& canonical, const RadialForm& f) {
            // With balls, and in them, C is quadratic in y and no other rational height's is.
            if (!f.has_root() && !std::holds_alternative<Sphere>(canonical) &&
                !std::holds_alternative<HollowSphere>(canonical)) {
                rays.push_back({f.c[0], f.c[1], f.c[2], f.b0, f.b[0], f.b[2]});
                ray_entries.push_back(entries.size());
            }
            entries.push_back({{site}, canonical, f});
        };
        for (std::uint32_t i = 0; i < scene_.objects.size(); ++i) {
            if (!objects_.is_kept(i)) continue;
            const Site site = objects_.site(i);
            if (const auto* sphere = std::get_if<Sphere>(&scene_.objects[i])) {
                add(site, Sphere{motion_.to_canonical(sphere->center), sphere->radius},
                    forms_.form(objects_.balls.of(i)));
            } else if (const auto* plane = std::get_if<Plane>(&scene_.objects[i])) {
                add(site, Plane{motion_.to_canonical(plane->point), motion_.rotation * plane->normal},
                    forms_.form(objects_.planes.of(i)));
            } else if (const auto* cylinder = std::get_if<Cylinder>(&scene_.objects[i])) {
                const CylinderForm& f = objects_.cylinders.of(i);
                const auto y = frame_.crossing(base_, *cylinder);
                if (!y) {
                    add(site, canonical_tube(*cylinder, f), forms_.form(f));
                    continue;
                }
                for (const Side& wall : walls_of_crossing(i, *cylinder, *y)) {
                    add(site, Plane{{0, *y, 0}, frame_.rounded(wall.normal).normalized()}, forms_.form(wall));
                    entries.back().sites =
                        with_equal_ones(entries.back().sites, objects_, scene_.objects.size());
                    entries.back().is_of_crossing = true;
                }
            } else if (const auto* ball = std::get_if<HollowSphere>(&scene_.objects[i])) {
                add(site, HollowSphere{motion_.to_canonical(ball->center), ball->radius}, forms_.form(*ball));
            } else if (const auto* tube = std::get_if<HollowCylinder>(&scene_.objects[i])) {
                const CylinderForm& f = objects_.hollow_cylinders.of(i);
                add(site, canonical_tube(*tube, f), forms_.hollow_form(f));
            } else {
                HollowCone cone = std::get<HollowCone>(scene_.objects[i]);
                const ConeForm& f = objects_.hollow_cones.of(i);
                cone.apex = motion_.to_canonical(cone.apex);
                cone.axis = forms_.is_along_base(f.axis)
                                ? Vec3((forms_.points_along(f.axis) ? 1.0 : -1.0) * Vec3::UnitY())
                                : frame_.rounded(frame_.turned(f.axis));
                add(site, cone, forms_.hollow_form(f));
            }
        }
        // A side may touch the bisector of what holds the side's mirror image of the base, of a plane along
        // the axis before that or of a vessel along it, all along a line.
        std::vector<RadialForm> walls;
        for (const Entry& e : entries)
            if (CylinderForms::is_same_along_axis(e.form)) walls.push_back(e.form);
        for (const BoxSide& canonical : canonical_box(walls_, motion_)) {
            const Side side = this->side(canonical.index);
            if (side.is_across_axis() || sides_[canonical.index] != CylinderPart::Wall::Inside) continue;
            const RadialForm f = forms_.form(side);
            if (!side.is_along_axis() || std::ranges::none_of(walls, [&](const RadialForm& wall) {
                    return CylinderForms::is_nowhere_nearer(f, wall);
                }))
                add(side.site, Plane{canonical.k * canonical.m, canonical.m}, f);
        }
        for (const BoxSide& canonical : canonical_box(walls_, motion_)) {
            if (sides_[canonical.index] != CylinderPart::Wall::Beyond) continue;
            const Side side = -this->side(canonical.index);
            if (!side.is_across_axis()) {
                add(side.site, Plane{canonical.k * canonical.m, -canonical.m}, forms_.form(side));
                entries.back().is_of_floor = true;
            }
        }
        // What is equally near everywhere is the first one's.
        const std::vector<std::uint32_t> first = first_equal(rays);
        std::vector<bool> is_merged(entries.size(), false);
        for (std::size_t k = 0; k < rays.size(); ++k) {
            if (first[k] == k) continue;
            if (entries[ray_entries[k]].is_of_floor)
                throw InputError(Kind::Unsupported, InputError::no_object, "box",
                                 "all along side " + to_string(entries[ray_entries[k]].sites.front()) +
                                     ", through which the base's rays come in, " +
                                     competitor_title(scene_, entries[ray_entries[first[k]]].sites.front()) +
                                     " is as far as the base");
            Entry &kept = entries[ray_entries[first[k]]], &other = entries[ray_entries[k]];
            kept.sites.insert(kept.sites.end(), other.sites.begin(), other.sites.end());
            is_merged[ray_entries[k]] = true;
        }
        std::size_t kept = 0;
        for (std::size_t i = 0; i < entries.size(); ++i) {
            if (is_merged[i]) continue;
            if (kept < i) entries[kept] = std::move(entries[i]);
            ++kept;
        }
        entries.erase(entries.begin() + static_cast<std::ptrdiff_t>(kept), entries.end());
        return entries;
    }

    // Every place is within 2 reach (> sqrt(3) reach) of the origin.
    double reach() const {
        return std::max((scene_.box.min - frame_.origin).cwiseAbs().maxCoeff(),
                        (scene_.box.max - frame_.origin).cwiseAbs().maxCoeff());
    }
    double moved() const { return std::max(2 * reach() * frame_.turn, moved_apart()); }
    double moved_apart() const {
        double moved = moved_by_lengths(scene_);
        for (std::uint32_t i = 0; i < scene_.objects.size(); ++i)
            if (const auto* tube = std::get_if<Cylinder>(&scene_.objects[i]); tube && objects_.is_kept(i))
                moved = std::max(moved, 2 * reach() * given_.crossing_turn(*tube));
        return moved;
    }

    RadialBaseProblem make_problem() {
        RadialBaseProblem problem;
        problem.given_base = base_;
        FoundForms found(scene_);
        std::vector<Entry> entries = all_entries();
        std::vector<RadialForm> forms;
        for (const Entry& e : entries) {
            if (e.is_of_floor) break;  // the last ones, which compete with none of the others
            const Site site = e.sites.front();
            const auto place = site.is_object() ? static_cast<std::uint32_t>(scene_.place(site.index)) : 0;
            if (site.is_object() && !e.form.has_root() && std::holds_alternative<Cylinder>(e.canonical)) {
                const CylinderForm& tube = objects_.cylinders.of(place);
                forms.push_back(forms_.linear_image(tube, Exact(tube.rho) - base_.radius));
            } else if (!e.form.has_root() && std::holds_alternative<HollowCylinder>(e.canonical)) {
                const CylinderForm& tube = objects_.hollow_cylinders.of(place);
                forms.push_back(CylinderForms::turned_signs(
                    forms_.linear_image(tube, -(Exact(tube.rho) + base_.radius))));
            } else {
                forms.push_back(e.form);
            }
        }
        const std::vector<AxialTie> ties = find_axial_ties(forms);
        // In a turned scene places are rounded: what that hides counts as motion, and the rest as an
        // assumption.
        const double most_rounded = frame_.turn > 0 ? tie_rounding * scene_.box.diagonal() : 0;
        double rounded = 0;
        for (const AxialTie& tie : ties) {
            entries[tie.middle].is_kept = false;
            if (tie.move <= most_rounded) rounded = std::max(rounded, tie.move);
        }
        // Walls are half-way between directions that are rounded themselves.
        const double most_of_walls =
            (scene_.images.empty() ? tie_rounding : grid_rounding) * scene_.box.diagonal();
        std::vector<WallTie> ties_of_walls = wall_ties(entries, 2 * reach(), most_of_walls);
        double gives_way = drop_middle(ties_of_walls, entries);
        gives_way += drop_mirrored(scene_, base_, most_of_walls, entries, ties_of_walls);
        for (Entry& e : entries) {
            if (!e.is_kept) continue;
            e.id = FormId{static_cast<std::uint32_t>(found.sites.size())};
            const Site own = e.sites.front();
            if (e.is_of_crossing)
                found.add_one_of(own, e.canonical);
            else
                found.add(own, e.canonical);
            problem.given.push_back(own.is_object() ? scene_.objects[scene_.place(own.index)] : e.canonical);
            for (const Site site : std::span(e.sites).subspan(1)) found.join(site, e.id);
            if (e.is_of_floor) problem.floor.push_back(e.id);
            problem.family.radial.push_back(CylinderForms::turned(e.form));
            // As long as no turn has moved the base between it and the tube.
            if (e.is_of_crossing && frame_.turn == 0)
                problem.family.tubes_of_walls.push_back(
                    {e.id, CylinderForms::turned(forms_.form(
                               objects_.cylinders.of(static_cast<std::uint32_t>(scene_.place(own.index)))))});
        }
        const Eigen::Matrix3d turn = CylinderForms::chart() / CylinderForms::turn_norm;
        if (frame_.turn > 0)
            problem.family.given =
                given_equations(base_, {turn.transpose() * motion_.rotation, motion_.origin},
                                given_forms(entries, problem, walls_));
        add_ties(ties, most_rounded, entries, objects_, scene_.objects.size(), problem);
        add_ties(ties_of_walls, entries, objects_, scene_.objects.size(), problem);
        found.add_twins(objects_);
        add_passing_ties(found.sites, problem);
        problem.frame = motion_;
        problem.unit = unit_;
        problem.moves = {moved(), moved_apart(), rounded + gives_way};
        problem.stretch = stretch_;
        problem.region = {{0, 1, -stretch_[0], Site::end(0)},
                          {-1, 0, 3, {}},
                          {0, -1, stretch_[1], Site::end(1)},
                          {1, 0, 1, {}}};
        problem.chart = {BaseShape::Cylinder, base_.radius, turn};
        problem.family.chart = problem.chart;
        for (const std::optional<Site>& site : early_ends_)
            if (site)
                problem.warnings.push_back("base: ends " + to_text(unit_ * end_radius(base_, scene_.box)) +
                                           " from side " + to_string(*site) +
                                           ", which it runs into obliquely: its clearance falls to 0 there");
        objects_.warn(found.sites, problem.warnings);
        problem.sites = std::move(found.sites);
        problem.objects = std::move(found.objects);
        return problem;
    }

    const Scene& scene_;
    const Cylinder& base_;
    const double unit_;
    const Box walls_;  // the scene's box, or what takes its place
    const std::array<CylinderPart::Wall, 6> sides_;
    const CylinderFrame frame_;
    const GivenAxis given_;
    const CylinderForms forms_;
    const BaseFrame motion_;                         // rounded
    std::array<std::optional<Site>, 2> early_ends_;  // sides before which the stretch ends by end_radius()
    const std::array<double, 2> stretch_;
    RadialObjects objects_;
};

}  // namespace

double end_radius(const Cylinder& base, const Box& box) {
    constexpr double least = 0x1p-26;  // of the box's diagonal
    return std::max(base.radius, least * box.diagonal());
}

bool cross_equally(const Cylinder& a, const Cylinder& b) {
    return CylinderFrame::may_cross_equally(a, b) && cylinder_forms::AxesCrossing(a, b).is_one();
}

std::vector<TubeCrossing> crossing_tubes(const Scene& scene, const Cylinder& base) {
    std::optional<CylinderFrame> frame;
    std::vector<TubeCrossing> found;
    for (std::uint32_t i = 0; i < scene.objects.size(); ++i) {
        const auto* tube = std::get_if<Cylinder>(&scene.objects[i]);
        if (!tube || !scene.competes(i) || !cross_equally(base, *tube)) continue;
        if (!frame) frame.emplace(scene, base);
        found.push_back({i, *frame->crossing(base, *tube)});
    }
    return found;
}

std::optional<Cylinder> base_tube(const Scene& scene) {
    const auto* base = std::get_if<Cylinder>(&scene.base);
    return base != nullptr ? std::optional(*base) : std::nullopt;
}

bool is_oblique(const Scene& scene, const Cylinder& base) {
    return (CylinderFrame(scene, base).axis.array() != 0).count() > 1;
}

BaseFrame cylinder_frame(const Scene& scene, const Cylinder& base) {
    return CylinderFrame(scene, base).rounded();
}

RadialBaseProblem cylinder_base_problem(const Scene& scene, const Cylinder& base, double unit,
                                        const CylinderPart* part) {
    return CylinderProblem(scene, base, unit, part).build();
}

}  // namespace vcell
