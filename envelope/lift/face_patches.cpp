#include "face_patches.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <optional>
#include <ranges>
#include <utility>
#include <variant>

#include "../../core/errors.hpp"
#include "../../core/threads.hpp"
#include "../../primitives/bases/axial_terms.hpp"
#include "../object_distance.hpp"
#include "sectors_around.hpp"
#include "trim_bounds.hpp"

namespace vcell::radial {

namespace {

// A face that turns further than this has several patches.
constexpr double widest_patch = 4;
constexpr double narrowest_sector = 0x1p-10;

using std::numbers::pi;

// On both sides of a tip, which the face may hold or others hide.
std::optional<BisectorTip> tip_beside(const RadialBaseProblem& problem, FormId form,
                                      const CylinderTurns& turns, const CylinderTurns::Extent& e) {
    for (const BisectorTip& tip : bisector_tips(problem, form)) {
        if (!(tip.y > e.lowest && tip.y < e.highest)) continue;
        const double off = std::abs(std::remainder(e.middle() - turns.angle(tip.u), 2 * pi));
        if (e.is_closed || off <= 0.5 * e.width()) return tip;
    }
    return std::nullopt;
}

// Strips lie along lines of the bisector, x = const. Where x is small the face may reach far along y and the
// other way round, and a rectangle that holds both reaches far beyond: strips grow in powers of two from the
// line in both axes' plane on, next to which the graph is no higher than the face. Nothing crosses the outer
// sides. No strips where the graph reaches no farther; none at all where digits do not tell it.
std::optional<std::vector<SectorRange>> strips_of(const SkewAxes& axes, const RadialPatch& patch,
                                                  const std::vector<std::vector<Vec3>>& points) {
    constexpr double too_far = 16;  // of the face's size
    double x = 0, y = 0, z = 0;
    for (const std::vector<Vec3>& loop : points)
        for (const Vec3& p : loop) {
            const Vec2 at = patch.parameters(p);
            x = std::max(x, std::abs(axes.x0 + at.x()));
            y = std::max(y, std::abs(axes.y0 + at.y()));
            z = std::max(z, std::abs(axes.x.cross(axes.y).dot(p - axes.origin)));
        }
    // Output accuracy, in parts of the face: a graph that rounding moves by so much tells nothing.
    constexpr double rounding = 0x1p-48, too_much = 0x1p-10;
    if (axes.steep * std::max(x, y) * rounding > too_much) return std::nullopt;
    const double size = x + y + z;
    std::vector<SectorRange> strips;
    if (!(axes.steep * x * y > too_far * size)) return strips;
    std::vector<double> sides;
    for (double side = size / (axes.steep * y);; side *= 2) {
        sides.push_back(side);
        sides.push_back(-side);
        if (side > 2 * x) break;
    }
    std::ranges::sort(sides);
    for (std::size_t i = 0; i + 1 < sides.size(); ++i)
        strips.push_back({sides[i] - axes.x0, sides[i + 1] - axes.x0});
    return strips;
}

}  // namespace

FacePatches::FacePatches(const RadialDiagram& of, const FaceLoops& loops, const RadialCurves& curves,
                         unsigned threads, bool has_patches)
    : problem_(of.problem),
      diagram_(of.diagram),
      loops_(loops),
      curves_(curves),
      turns_(of, loops),
      has_patches_(has_patches),
      is_flat_(problem_.objects.size()) {
    const std::size_t count = diagram_.dcel.face_count();
    sectors_.resize(count);
    if (!has_patches_) return;
    patches_.resize(count);
    for (const FormId form : problem_.floor) is_flat_[form] = true;
    if (!problem_.floor.empty())
        for (const EdgeId e : diagram_.edges.ids())
            for (const FormId form : {diagram_.edges[e].left, diagram_.edges[e].right})
                if (form.valid() && !of.is_bare(e)) is_flat_[form] = vcell::is_flat(problem_, form);
    for (const FormId form : diagram_.face_forms)
        if (form.valid()) is_flat_[form] = vcell::is_flat(problem_, form);
    if (!problem_.chart.is_sphere()) {
        for (const FaceId face : diagram_.face_forms.ids())
            if (diagram_.face_forms[face].valid()) add_around_cylinder(face);
        return;
    }
    for_ranges(count, threads, [&](std::size_t begin, std::size_t end) {
        for (auto face = FaceId{static_cast<std::uint32_t>(begin)}; face.value < end; ++face.value)
            if (const FormId form = diagram_.face_forms[face]; form.valid() && !may_reach_around(face))
                patches_[face] = RadialPatch(problem_, form, middle(face), 0);
    });
    for (const FaceId face : diagram_.face_forms.ids()) {
        if (!diagram_.face_forms[face].valid() || !may_reach_around(face)) continue;
        if (std::holds_alternative<HollowSphere>(object(face)))
            add_in_sphere(face);
        else
            add_about_object(face);
    }
}

bool FacePatches::may_reach_around(FaceId face) const {
    return is_vessel(object(face)) || pierces_base(problem_, diagram_.face_forms[face]);
}

Vec3 FacePatches::middle(FaceId face) const {
    Vec3 sum = Vec3::Zero();
    loops_.around(face, [&](EdgeId e, bool) {
        for (const ConicSpan& s : curves_.conics(e)) sum += s.from.head<3>() / s.from.w();
        if (curves_.has_ends(e)) sum += curves_.from(e).head<3>() / curves_.from(e).w();
        for (const auto& piece : diagram_.pieces(e)) sum += problem_.chart.normal(piece.end);
    });
    return sum.isZero(0) ? Vec3::UnitZ() : sum.normalized();
}

// A face of an ellipsoid may reach all around the base. The direction of a stereographic patch that it lacks
// is one in which another form is nearest.
std::vector<Vec3> FacePatches::poles(FaceId face) const {
    const FormId form = diagram_.face_forms[face];
    std::vector<Vec3> all{middle(face)};
    if (const Vec3& center = std::get<HollowSphere>(problem_.objects[form]).center; !center.isZero(0))
        all.push_back(-center.normalized());
    loops_.around(face, [&](EdgeId e, bool reversed) {
        const FaceId beyond = diagram_.face(e, reversed ? 0 : 1);
        if (diagram_.face_forms[beyond].valid()) all.push_back(-middle(beyond));
    });
    for (int axis = 0; axis < 3; ++axis)
        for (const double side : {-1.0, 1.0}) all.push_back(side * Vec3::Unit(axis));
    // A shadow of a tube is narrow: one of a ball leaves more room around the pole.
    std::vector<Vec3> clear;
    for (const bool asks_tubes : {false, true}) {
        if (!clear.empty()) break;
        std::ranges::copy_if(all, std::back_inserter(clear),
                             [&](const Vec3& p) { return is_owned_by_others(form, -p, asks_tubes); });
    }
    return clear;
}

// About the pole from which the face is the smallest, which takes the lowest degree: the face's middle, as
// far as its edges' ends tell that, may be next to where it ends.
void FacePatches::add_in_sphere(FaceId face) {
    halvings_.emplace(face, 0);
    double smallest = infinity;
    for (const Vec3& pole : poles(face)) {
        const RadialPatch patch(problem_, diagram_.face_forms[face], pole, 0);
        double size = 0;
        const auto extend_by = [&](const Vec3& p) {
            size = std::max(size, patch.parameters(p).cwiseAbs().maxCoeff());
        };
        loops_.around(face, [&](EdgeId e, bool) {
            for (const ConicSpan& s : curves_.conics(e)) {
                extend_by(s.from.head<3>() / s.from.w());
                extend_by((s.from + 2 * s.middle + s.to).head<3>());
            }
            if (curves_.has_ends(e)) extend_by(curves_.from(e).head<3>());
            for (const auto& piece : diagram_.pieces(e)) extend_by(problem_.chart.normal(piece.end));
        });
        if (!(size < smallest)) continue;
        smallest = size;
        patches_[face] = patch;
    }
    if (smallest == infinity) halve(face);
}

// False where it was halved in several ways before.
bool FacePatches::halve(FaceId face) {
    constexpr std::size_t most = 4;
    std::size_t& attempt = halvings_[face];
    if (attempt == most) return false;
    halves_.insert_or_assign(face, SurfaceHalves({problem_, diagram_}, loops_, curves_, face, attempt++));
    return true;
}

// By a margin, so that doubles can tell.
bool FacePatches::is_owned_by_others(FormId form, const Vec3& direction, bool asks_tubes) const {
    constexpr double part = 0x1p-10, margin = 1 + part;
    const Vec3 n = problem_.chart.turn.transpose() * direction;
    // 1 / t, as in SphereSupports.
    const auto nearness = [&](const CircularForm& f) {
        return -0.5 / f.w * (f.a * n.x() + f.b * n.y() + (f.e - f.k) * n.z() + (f.e + f.k));
    };
    const double own = nearness(problem_.family.forms[form]);
    if (std::ranges::any_of(problem_.family.forms,
                            [&](const CircularForm& f) { return nearness(f) > margin * own; }))
        return true;
    if (!asks_tubes) return false;
    const double t = 1 / own, most = t - problem_.chart.radius - part * t;
    for (const FormId f : problem_.objects.ids())
        if (!problem_.family.is_circular(f) && distance_from(problem_.objects[f], t * direction) < most)
            return true;
    return false;
}

bool FacePatches::change(FaceId face, const std::vector<bool>& is_too_wide) {
    if (can_be_halved(face)) return halve(face);
    // Strips are given up where seams do not divide the face: the whole graph holds it.
    if (is_cut(face) && skew_axes_.erase(face) > 0) {
        sectors_[face].clear();
        return true;
    }
    if (is_cut(face)) return narrow(face, is_too_wide);
    if (object_axes_.contains(face) || !problem_.chart.is_sphere()) {
        change_and_cut(face);
        return true;
    }
    wide_.resize(patches_.size());
    if (wide_[face]) return false;
    wide_[face] = true;
    patches_[face] = RadialPatch(problem_, diagram_.face_forms[face], middle(face), 0, true);
    return true;
}

SpaceSite FacePatches::site(EdgeId e, unsigned side) const {
    const FaceId face = diagram_.face(e, side);
    const FormId form = diagram_.form_beside(e, side);
    const Object& object = problem_.objects[form];
    SpaceSite site{object, is_wall(problem_, form), {}};
    site.power = power_of_ball(problem_, form);
    if (!has_patches_ || !diagram_.face_forms[face].valid()) return site;
    if (!is_cut(face)) {
        site.parts.push_back({.patch = patches_[face].coordinates(), .surface = &patches_[face]});
        return site;
    }
    if (const SurfaceHalves* two = halves(face)) {
        site.parts = {two->part(0), two->part(1)};
        return site;
    }
    for (const Sector& s : sectors_[face]) {
        const PatchCoordinates& at = s.patch.coordinates();
        site.parts.push_back({at, at[0], {-s.reach(), s.reach()}, &s.patch, s.range.inwards, s.other});
    }
    for (const Sector& s : places(face)) site.starts.push_back(s.from());
    return site;
}

// ---- Around a vessel's axis -------------------------------------------------------------------------

// Around a hollow tube's or cone's axis, of which the face's boundary keeps clear. A patch is about the
// middle of the angles that the face covers; one that holds a tip of the bisector has all of them there.
void FacePatches::add_about_object(FaceId face) {
    const FormId form = diagram_.face_forms[face];
    if (!tips_) tips_.emplace(RadialDiagram{problem_, diagram_}, loops_);
    const ObjectAxis& axis = object_axes_.emplace(face, problem_.objects[form]).first->second;
    const ObjectTurns turns({problem_, diagram_}, loops_, axis, face);
    patches_[face] = RadialPatch(problem_, form, axis.direction(turns.middle()), 0);
    if (turns.is_closed() || turns.width() > widest_patch || !tips(face).empty()) cut(face);
}

// ---- Around a cylinder ------------------------------------------------------------------------------

RadialPatch FacePatches::patch_around(FaceId face, const CylinderTurns::Extent& e, bool wide) const {
    return RadialPatch(problem_, diagram_.face_forms[face], turns_.direction(e.middle()), e.y, wide);
}

void FacePatches::add_around_cylinder(FaceId face) {
    const CylinderTurns::Extent e = turns_.extent(face);
    if (const auto tip = tip_beside(problem_, diagram_.face_forms[face], turns_, e))
        return add_around_tip(face, *tip);
    if (const auto axes = SkewAxes::of(problem_, diagram_.face_forms[face], e.y)) {
        skew_axes_.emplace(face, *axes);
        patches_[face] = RadialPatch(*axes);
        return;
    }
    const RadialPatch& patch = patches_[face] = patch_around(face, e, false);
    if (patch.kind() == RadialPatch::Kind::Planar) return;
    if (patch.half()) {
        const double off = std::abs(std::remainder(e.middle() - turns_.angle(*patch.half()), 2 * pi));
        if (e.is_closed || off + 0.5 * e.width() > 0.5 * pi * (1 + 0x1p-20)) cut(face);
    } else if (e.is_closed || e.width() > widest_patch) {
        cut(face);
    }
}

// No parameters about the base are good on both lines through a tip (radial_patch.hpp). About the object's
// axis there are some for either half of its directions. A face that holds both tips takes those about one:
// in the other one v is the same all around, too.
void FacePatches::add_around_tip(FaceId face, const BisectorTip& beside) {
    const FormId form = diagram_.face_forms[face];
    if (!tips_) tips_.emplace(RadialDiagram{problem_, diagram_}, loops_);
    const std::span<const BisectorTip> held = tips(face);
    const BisectorTip& tip = tips_beside_.emplace(face, held.empty() ? beside : held.front()).first->second;
    const ObjectAxis& axis = object_axes_.emplace(face, object(face)).first->second;
    patches_[face] = RadialPatch::around_tip(problem_, form, tip, axis.x);
    cut(face);
}

// ---- Sectors ----------------------------------------------------------------------------------------

// Around a cylinder into two halves: those that patches are for, if they are for a half. About a vessel's
// axis over a sphere into three parts: where the base is centred on it the weight in the middle of a half is
// none.
void FacePatches::cut(FaceId face) {
    const std::optional<Vec3>& half = patches_[face].half();
    const auto axis = object_axes_.find(face);
    const RadialDiagram of{problem_, diagram_};
    if (const auto tip = tips_beside_.find(face); tip != tips_beside_.end())
        return set_sectors(face, tip_sectors(of, diagram_.face_forms[face], tip->second, axis->second, turns_,
                                             turns_.extent(face)));
    const bool is_about_base = axis == object_axes_.end();
    const std::size_t count = is_about_base ? 2 : 3;
    const auto vertices = [&] {
        return is_about_base ? turns_.of_vertices(face)
                             : ObjectTurns(of, loops_, axis->second, face).of_vertices();
    };
    const double start = half ? turns_.angle(*half) - 0.5 * pi : clear_angle(vertices(), count),
                 width = 2 * pi / static_cast<double>(count);
    std::vector<SectorRange> all;
    for (std::size_t i = 0; i < count; ++i) {
        const double from = start + width * static_cast<double>(i);
        all.push_back({from, from + width});
    }
    set_sectors(face, all);
}

void FacePatches::suit_graph(FaceId face, const std::vector<std::vector<Vec3>>& points) {
    const auto found = skew_axes_.find(face);
    if (found == skew_axes_.end() || is_cut(face)) return;
    const std::optional<std::vector<SectorRange>> strips = strips_of(found->second, patches_[face], points);
    if (strips)
        set_sectors(face, *strips);
    else
        change_and_cut(face);
}

void FacePatches::set_sectors(FaceId face, std::span<const SectorRange> all) {
    std::vector<Sector> sectors, others;
    for (const SectorRange& range : all) {
        const auto place = static_cast<std::uint32_t>(sectors.size());
        Sector& first = sectors.emplace_back(range, patch_of(face, range), place);
        if (range.inwards.isZero(0)) continue;
        first.other = static_cast<std::uint32_t>(all.size() + others.size());
        const SectorRange beyond{range.from, range.to, !range.is_beyond, -range.inwards};
        others.emplace_back(beyond, patch_of(face, beyond), place);
    }
    sectors.insert(sectors.end(), others.begin(), others.end());
    sectors_[face] = std::move(sectors);
}

RadialPatch FacePatches::patch_of(FaceId face, const SectorRange& range) const {
    const auto& [from, to, is_beyond, inwards] = range;
    const FormId form = diagram_.face_forms[face];
    if (const auto axes = skew_axes_.find(face); axes != skew_axes_.end())
        return RadialPatch(axes->second.moved(0.5 * (from + to)));
    if (const auto axis = object_axes_.find(face); axis != object_axes_.end()) {
        const Vec3 middle = axis->second.direction(0.5 * (from + to));
        if (const auto tip = tips_beside_.find(face); tip != tips_beside_.end())
            return RadialPatch::around_tip(problem_, form, tip->second, middle, is_beyond);
        return RadialPatch(problem_, form, middle, 0);
    }
    const Vec3 middle = turns_.direction(0.5 * (from + to));
    const double y = turns_.mean_height(face, from, to);
    return RadialPatch(problem_, form, middle, y, patches_[face].half().has_value());
}

// Patches that are for a half each keep away from what lies at infinity.
void FacePatches::change_and_cut(FaceId face) {
    skew_axes_.erase(face);
    if (!object_axes_.contains(face)) patches_[face] = patch_around(face, turns_.extent(face), true);
    cut(face);
}

// Narrower sectors have smaller rectangles.
bool FacePatches::narrow(FaceId face, const std::vector<bool>& is_too_wide) {
    std::vector<SectorRange> finer;
    for (const Sector& s : places(face)) {
        const bool is_wide = is_too_wide[s.place] || (s.other > 0 && is_too_wide[s.other]);
        if (!is_wide) {
            finer.push_back(s.range);
            continue;
        }
        if (s.width() < narrowest_sector) return false;
        SectorRange first = s.range, second = s.range;
        first.to = second.from = std::lerp(s.range.from, s.range.to, off_middle);
        finer.insert(finer.end(), {first, second});
    }
    set_sectors(face, finer);
    return true;
}

std::uint32_t FacePatches::part_of(FaceId face, const Vec3& p, bool rises) const {
    if (const SurfaceHalves* two = halves(face)) return two->half_of(p);
    const double inwards = rises ? -seam_inwards : seam_inwards;
    const std::vector<Sector>& all = sectors_[face];
    const double u = all.front().patch.parameters(p).x();
    const bool are_strips = all.front().patch.kind() == RadialPatch::Kind::Graph;
    const std::uint32_t at = sector_around(
        places(face) | std::views::transform(&Sector::from), are_strips ? 0.5 * u : std::atan(u),
        [&](std::size_t i) { return std::abs(all[i].patch.parameters(p).x() + inwards) - all[i].reach(); });
    return all[at].holds(p) ? at : all[at].other;
}

}  // namespace vcell::radial
