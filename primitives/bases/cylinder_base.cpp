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
#include "../objects/exact_motion.hpp"
#include "../objects/message.hpp"
#include "radial_objects.hpp"

namespace vcell {

namespace {

using Kind = InputError::Kind;

// canonical = rotation . (world - origin) / norm. What objects are to each other stays exact; the base's axis
// turns by a few 2^-53 to become the y axis, or not at all where its length is a double.
struct CylinderFrame {
    Vec3 along;  // scaled: what becomes the y axis, but for rounding
    Vec3 axis;   // the same, noise rounded to zero
    Vec3 origin;
    ExactRotation rotation;
    const Exact& norm;
    double turn;  // of the base's axis

    CylinderFrame(const Scene& scene, const Cylinder& base)
        : along(direction(scene, base)),
          axis(without_noise(along)),
          origin(base.point),
          rotation(axis, 1),
          norm(rotation.norm),
          turn(rotation.turn(scaled_axis(base.axis), 1)) {
        const Box& box = scene.box;
        const Vec3 center = 0.5 * box.min + 0.5 * box.max;
        Eigen::Index k = 0;
        axis.cwiseAbs().maxCoeff(&k);
        if ((axis.array() != 0).count() == 1) {
            origin[k] = center[k];
        } else {
            // In the base's point no rounding leaves the axis.
            const Vec3 unit = axis.normalized();
            const double away = unit.dot(center - base.point);
            if (std::abs(away) > box.diagonal()) origin += away * unit;
        }
    }
    CylinderFrame(const CylinderFrame&) = delete;
    CylinderFrame& operator=(const CylinderFrame&) = delete;

    // A rotation in doubles, from a quaternion that is nearly a half turn, say.
    static constexpr double bundle_rounding = 0x1p-48;
    // The tubes of a bundle about the base that was turned in doubles have one direction and lean towards the
    // base by its rounding: where three of them tie along a line, strips would be as narrow. As the base
    // turns anyhow it turns to the first direction that three of these have in common, unless there are tubes
    // along it. Fewer lean as they do.
    static Vec3 direction(const Scene& scene, const Cylinder& base) {
        const Vec3 own = scaled_axis(base.axis), axis = without_noise(own);
        if (ExactRotation(axis, 1).turn(own, 1) == 0) return own;
        constexpr int fewest = 3;
        std::vector<std::pair<Vec3, int>> leaning;  // directions, and how many tubes have them
        for (std::uint32_t i = 0; i < scene.objects.size(); ++i) {
            const auto* tube = std::get_if<Cylinder>(&scene.objects[i]);
            if (tube == nullptr || !scene.competes(i)) continue;
            const ExactVector d(scaled_axis(tube->axis)), across = cross(d, ExactVector(own));
            if (across.is_zero()) return own;
            const double sine = Vec3(nearest(across.x), nearest(across.y), nearest(across.z)).norm() /
                                (scaled_axis(tube->axis).norm() * own.norm());
            if (!(sine < bundle_rounding)) continue;
            const auto same = std::ranges::find_if(
                leaning, [&](const auto& known) { return cross(d, ExactVector(known.first)).is_zero(); });
            if (same == leaning.end())
                leaning.emplace_back(scaled_axis(tube->axis), 1);
            else
                ++same->second;
        }
        const auto bundle =
            std::ranges::find_if(leaning, [](const auto& known) { return known.second >= fewest; });
        if (bundle == leaning.end()) return own;
        // A tube's axis points to either side, that of the base to end:+.
        return bundle->first.dot(own) < 0 ? Vec3(-bundle->first) : bundle->first;
    }
    // A cosine of pi/2 in a direction that was turned in doubles is no lean: the base would end on sides of
    // the box that it runs along. The base turns with its frame anyhow, by about as much, and `turn` counts
    // it.
    static Vec3 without_noise(Vec3 axis) {
        const double size = axis.cwiseAbs().maxCoeff();
        for (double& component : axis)
            if (std::abs(component) < frame_rounding * size) component = 0;
        return axis;
    }

    // norm times the rotation of p.
    ExactVector turned(const ExactVector& p) const { return rotation(p); }
    ExactVector from_origin(const Vec3& p) const { return ExactVector(p) - ExactVector(origin); }

    // Of what turned() returns.
    Vec3 rounded(const ExactVector& p) const { return rotation.rounded(p); }
    BaseFrame rounded() const {
        BaseFrame frame;
        frame.rotation = rotation.rounded();
        frame.origin = origin;
        return frame;
    }
};

class CylinderProblem {
public:
    CylinderProblem(const Scene& scene, const Cylinder& base, double unit, const CylinderPart* part)
        : scene_(scene),
          base_(base),
          unit_(unit),
          walls_(part != nullptr ? part->walls : scene.box),
          sides_(part != nullptr ? part->sides : std::array<CylinderPart::Wall, 6>{}),
          frame_(scene, base),
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
    // In box diagonals, some times the rounding of coordinates.
    static constexpr double tie_rounding = 0x1p-50;

    // A side of the box from the origin of the frame: normal.p <= norm distance.
    struct Side {
        Site site;
        ExactVector normal;  // turned
        Exact distance;

        Exact across2() const { return normal.x * normal.x + normal.z * normal.z; }
        bool is_along_axis() const { return normal.y.sign() == Sign::Zero; }
        Side operator-() const { return {site, {-normal.x, -normal.y, -normal.z}, -distance}; }
        bool is_across_axis() const { return normal.x.sign() == Sign::Zero && normal.z.sign() == Sign::Zero; }
    };
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
            images.push_back({cylinder_form({p, frame_.axis, base_.radius}), side.site});
        }
        return images;
    }

    void add(std::uint32_t i, const Sphere& sphere) {
        const Vec3& c = sphere.center;
        const Ball ball{c.x(), c.y(), c.z(), sphere.radius};
        const RadialForm f = form(ball);
        if (!is_positive(f.c) || touched_before_turn(ball))
            objects_.fail(
                Kind::TouchesBase, i,
                ball.rho >= base_.radius ? "contains a cross section of the base" : "lies in the base");
        // B / W is largest in the ball's direction: the distance of its centre from the axis, plus delta.
        const Exact across2 = f.b[0] * f.b[0] + f.b[2] * f.b[2];
        if (f.b0.sign() != Sign::Positive && (across2 - f.b0 * f.b0).sign() != Sign::Positive)
            objects_.leave_out_unmet(i);
        else
            objects_.balls.add(ball, i);
    }

    // Is C = 0 or less about the base as it is given? A ball about a point of its axis would come off that as
    // the base turns, by so little that nothing near it could be told.
    bool touched_before_turn(const Ball& ball) const {
        if (frame_.turn == 0) return false;
        const Vec3 center(ball.cx, ball.cy, ball.cz);
        const ExactVector d(scaled_axis(base_.axis)), c = ExactVector(center) - ExactVector(base_.point),
                                                      across = cross(c, d);
        const Exact delta = Exact(ball.rho) - base_.radius, y = frame_.turned(frame_.from_origin(center)).y;
        return (dot(across, across) - delta * delta * dot(d, d)).sign() != Sign::Positive &&
               y >= frame_.norm * stretch_[0] && y <= frame_.norm * stretch_[1];
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
        const CylinderForm f = cylinder_form(cylinder);
        if (!is_positive(form(f).c))
            objects_.fail(
                Kind::TouchesBase, i,
                cylinder.radius >= base_.radius
                    ? "contains a cross section of the base"
                    : "lies in the base, or runs through it so near to its axis that base and cylinder "
                      "have no bisector all around");
        objects_.cylinders.add(f, i);
    }
    template <class Vessel>
    void add(std::uint32_t i, const Vessel&) {
        objects_.fail(Kind::Unsupported, i,
                      "is a vessel, which bounds the cells of balls alone: the base is a cylinder");
    }
    static CylinderForm cylinder_form(const Cylinder& cylinder) {
        const Vec3 a = scaled_axis(cylinder.axis), &p = cylinder.point;
        return {p.x(), p.y(), p.z(), a.x(), a.y(), a.z(), cylinder.radius};
    }

    // Is c0 + c1 y + c2 y^2, convex, positive all over the stretch?
    bool is_positive(const std::array<Exact, 3>& c) const {
        for (const double y : stretch_)
            if ((c[0] + y * (c[1] + y * c[2])).sign() != Sign::Positive) return false;
        const Exact slope0 = c[1] + 2.0 * Exact(stretch_[0]) * c[2],
                    slope1 = c[1] + 2.0 * Exact(stretch_[1]) * c[2];
        if (slope0.sign() != Sign::Negative || slope1.sign() != Sign::Positive) return true;
        return (4.0 * c[0] * c[2] - c[1] * c[1]).sign() == Sign::Positive;
    }

    // The forms of the header, by powers of `norm` free of denominators. Of balls times norm:
    RadialForm form(const Ball& ball) const {
        const ExactVector c = frame_.from_origin({ball.cx, ball.cy, ball.cz}), p = frame_.turned(c);
        const Exact delta = Exact(ball.rho) - base_.radius;
        return {{frame_.norm * (dot(c, c) - delta * delta), -2.0 * p.y, frame_.norm},
                frame_.norm * delta,
                Exact(),
                {p.x, Exact(), p.z},
                {}};
    }
    // Times 2 norm:
    RadialForm form(const HalfSpace& h) const {
        const ExactVector n = frame_.turned(ExactVector(h.n));
        const Exact value = h(ExactVector(frame_.origin)) + Exact(base_.radius) * h.length;
        return {{2.0 * frame_.norm * value, 2.0 * n.y, Exact()},
                frame_.norm * h.length,
                Exact(),
                {-n.x, Exact(), -n.z},
                {}};
    }
    RadialForm form(const Side& side) const {
        const ExactVector& n = side.normal;
        return {{2.0 * frame_.norm * side.distance, -2.0 * n.y, Exact()},
                Exact(),
                Exact(),
                {n.x, Exact(), n.z},
                {}};
    }
    // Times norm^2, as A is times norm.
    RadialForm form(const CylinderForm& f) const {
        const ExactVector p = frame_.from_origin({f.px, f.py, f.pz}), a = direction(f);
        const Exact length2 = dot(a, a), along = dot(p, a), delta = Exact(f.rho) - base_.radius;
        const ExactVector axis = frame_.turned(a), near = frame_.turned(length2 * p - along * a);
        if (is_along_base(f)) return along_base(near, frame_.norm * length2, delta);
        const Exact &n = frame_.norm, n2 = n * n;
        const ExactVector b = n * near;
        return {{n2 * (length2 * (dot(p, p) - delta * delta) - along * along), -2.0 * b.y,
                 n2 * length2 - axis.y * axis.y},
                n2 * length2 * delta,
                axis.y,
                {b.x, Exact(), b.z},
                {axis.x, Exact(), axis.z}};
    }
    // About the line through near / scale along y, as with an axis (0, scale, 0).
    static RadialForm along_base(const ExactVector& near, const Exact& scale, const Exact& delta) {
        const Exact square = scale * scale;
        return {{near.x * near.x + near.z * near.z - square * delta * delta, Exact(), Exact()},
                square * delta,
                scale,
                {scale * near.x, Exact(), scale * near.z},
                {}};
    }
    // The same but for the turn of the axis, which all but keeps lengths: F of find_axial_ties() is a linear
    // image of what it is in the world. Pre: along the base.
    RadialForm linear_image(const CylinderForm& f) const {
        const ExactVector p = frame_.from_origin({f.px, f.py, f.pz}), a = direction(f);
        const Exact length2 = dot(a, a), along = dot(p, a), delta = Exact(f.rho) - base_.radius;
        const ExactVector b = frame_.turned(length2 * p - along * a);
        const Exact& n = frame_.norm;
        return {{n * (length2 * (dot(p, p) - delta * delta) - along * along), Exact(), Exact()},
                n * length2 * delta,
                Exact(),
                {b.x, Exact(), b.z},
                {}};
    }
    static ExactVector direction(const CylinderForm& f) { return ExactVector(Vec3(f.ax, f.ay, f.az)); }

    // Parallel to what the base's axis turns to, before or after rounding.
    bool is_along_base(const CylinderForm& f) const {
        const ExactVector a = direction(f), image = frame_.turned(a);
        return (image.x.sign() == Sign::Zero && image.z.sign() == Sign::Zero) ||
               cross(a, ExactVector(frame_.along)).is_zero();
    }

    // The chart is turned about the axis, u = chart n / W, by an angle that no input favours: a symmetric
    // scene's trisectors would run along the seams of the chart. Its half angle has the tangent turn_sine /
    // turn_cosine.
    static constexpr double turn_sine = 773, turn_cosine = 2048;
    static constexpr double turn_norm = turn_cosine * turn_cosine + turn_sine * turn_sine;

    // turn_norm times the rotation.
    static Eigen::Matrix3d chart() {
        const double c = turn_cosine * turn_cosine - turn_sine * turn_sine, s = 2 * turn_cosine * turn_sine;
        Eigen::Matrix3d m;
        m << c, 0, s, 0, turn_norm, 0, -s, 0, c;
        return m;
    }

    // The form in the turned chart, its equation times turn_norm^2 to be free of denominators.
    static RadialForm turned(const RadialForm& f) {
        const Eigen::Matrix3d m = chart();
        const Exact norm = turn_norm;
        const auto turn = [&](const std::array<Exact, 3>& v) {
            return std::array<Exact, 3>{m(0, 0) * v[0] + m(2, 0) * v[2], Exact(),
                                        m(0, 2) * v[0] + m(2, 2) * v[2]};
        };
        RadialForm out{f.c, norm * norm * f.b0, norm * f.slope, turn(f.b), turn(f.a)};
        for (Exact& c : out.c) c = norm * norm * c;
        for (Exact& b : out.b) b = norm * b;
        return out;
    }

    // A form and whose it is.
    struct Entry {
        std::vector<Site> sites;
        Object canonical;
        RadialForm form;
        bool is_kept = true;
        bool is_of_floor = false;
        FormId id{};
    };
    std::vector<Entry> all_entries() const {
        std::vector<Entry> entries;
        std::vector<std::array<Exact, 6>> rays;  // of rational heights, and whose they are
        std::vector<std::size_t> ray_entries;
        const auto add = [&](Site site, const Object& canonical, const RadialForm& f) {
            // With balls C is quadratic in y and no other rational height's is.
            if (!f.has_root() && !std::holds_alternative<Sphere>(canonical)) {
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
                    form(objects_.balls.of(i)));
            } else if (const auto* plane = std::get_if<Plane>(&scene_.objects[i])) {
                add(site, Plane{motion_.to_canonical(plane->point), motion_.rotation * plane->normal},
                    form(objects_.planes.of(i)));
            } else {
                const auto& cylinder = std::get<Cylinder>(scene_.objects[i]);
                const CylinderForm& f = objects_.cylinders.of(i);
                const ExactVector axis = frame_.turned(direction(f));
                add(site,
                    Cylinder{motion_.to_canonical(cylinder.point),
                             is_along_base(f) ? Vec3::UnitY().eval() : frame_.rounded(axis), cylinder.radius},
                    form(f));
            }
        }
        for (const BoxSide& canonical : canonical_box(walls_, motion_)) {
            const Side side = this->side(canonical.index);
            if (!side.is_across_axis() && sides_[canonical.index] == CylinderPart::Wall::Inside)
                add(side.site, Plane{canonical.k * canonical.m, canonical.m}, form(side));
        }
        for (const BoxSide& canonical : canonical_box(walls_, motion_)) {
            if (sides_[canonical.index] != CylinderPart::Wall::Beyond) continue;
            const Side side = -this->side(canonical.index);
            if (!side.is_across_axis()) {
                add(side.site, Plane{canonical.k * canonical.m, -canonical.m}, form(side));
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
            kept.sites.push_back(other.sites.front());
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
    double moved() const {
        const double reach = std::max((scene_.box.min - frame_.origin).cwiseAbs().maxCoeff(),
                                      (scene_.box.max - frame_.origin).cwiseAbs().maxCoeff());
        return std::max(2 * reach * frame_.turn, moved_by_lengths(scene_));
    }

    RadialBaseProblem make_problem() {
        RadialBaseProblem problem;
        FoundForms found(scene_);
        std::vector<Entry> entries = all_entries();
        std::vector<RadialForm> forms;
        for (const Entry& e : entries) {
            if (e.is_of_floor) break;  // the last ones, which compete with none of the others
            const Site site = e.sites.front();
            const bool is_tube = site.is_object() && std::holds_alternative<Cylinder>(e.canonical);
            forms.push_back(is_tube && !e.form.has_root()
                                ? linear_image(objects_.cylinders.of(
                                      static_cast<std::uint32_t>(scene_.place(site.index))))
                                : e.form);
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
        for (Entry& e : entries) {
            if (!e.is_kept) continue;
            e.id = FormId{static_cast<std::uint32_t>(found.sites.size())};
            found.add(e.sites.front(), e.canonical);
            for (const Site site : std::span(e.sites).subspan(1)) found.join(site, e.id);
            if (e.is_of_floor) problem.floor.push_back(e.id);
            problem.family.radial.push_back(turned(e.form));
        }
        for (const AxialTie& tie : ties)
            for (const Site site : entries[tie.middle].sites)
                problem.generator_ties.push_back(
                    {site, entries[tie.before].id, entries[tie.after].id, tie.move <= most_rounded});
        found.add_twins(objects_);
        problem.frame = motion_;
        problem.unit = unit_;
        problem.moved = moved() + rounded;
        problem.moved_apart = moved_by_lengths(scene_);
        problem.stretch = stretch_;
        problem.region = {{0, 1, -stretch_[0], Site::end(0)},
                          {-1, 0, 3, {}},
                          {0, -1, stretch_[1], Site::end(1)},
                          {1, 0, 1, {}}};
        problem.chart = {BaseShape::Cylinder, base_.radius, chart() / turn_norm};
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

std::optional<Cylinder> oblique_tube(const Scene& scene) {
    const auto* base = std::get_if<Cylinder>(&scene.base);
    if (base == nullptr || (CylinderFrame(scene, *base).axis.array() != 0).count() == 1) return std::nullopt;
    return *base;
}

BaseFrame cylinder_frame(const Scene& scene, const Cylinder& base) {
    return CylinderFrame(scene, base).rounded();
}

RadialBaseProblem cylinder_base_problem(const Scene& scene, const Cylinder& base, double unit,
                                        const CylinderPart* part) {
    return CylinderProblem(scene, base, unit, part).build();
}

}  // namespace vcell
