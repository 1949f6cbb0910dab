/// Which patches the faces over a sphere or a cylinder base have. Around a cylinder a face may turn further
/// than a patch does: then the base is divided into sectors by generators, and each has a patch of its own.
/// So may a face of a hollow tube or cone over a sphere around the vessel's axis, or hold a tip of the
/// bisector there, and is divided about that, as are all over a cylinder next to a tip. A face of a hollow
/// sphere that leaves others little of all around has two halves (surface_halves.hpp). A face of a cylinder
/// of the base's radius, whose patch is a graph, may have strips.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "based_diagram.hpp"
#include "cylinder_turns.hpp"
#include "face_cut.hpp"
#include "face_loops.hpp"
#include "object_turns.hpp"
#include "radial_curves.hpp"
#include "radial_patch.hpp"
#include "space_arc.hpp"
#include "surface_halves.hpp"
#include "tip_sectors.hpp"

namespace vcell::radial {

/// What lies between two angles of the chart around a cylinder, or about a vessel's axis over a sphere, with
/// a patch of its own. A strip of a graph lies between two lengths.
class Sector {
public:
    Sector(const SectorRange& its, const RadialPatch& of, std::uint32_t at)
        : range(its),
          patch(of),
          place(at),
          reach_(of.kind() == RadialPatch::Kind::Graph ? 0.5 * width() : std::tan(0.25 * width())) {}

    SectorRange range;
    RadialPatch patch;
    std::uint32_t place;      ///< once around, or among strips
    std::uint32_t other = 0;  ///< the other one, which comes after those that are first at their places

    double from() const { return range.from; }
    double width() const { return range.to - range.from; }
    /// Is a point in it that lies between its sides? Where two are at one place one of them holds it.
    bool holds(const Vec3& p) const { return !(range.inwards.dot(p) < 0); }
    /// u at its end, and -u at its start.
    double reach() const { return reach_; }

private:
    double reach_;
};

class FacePatches {
public:
    /// Without patches curves are fitted for their own sake: what they are told of has no trims.
    FacePatches(const RadialDiagram& of, const FaceLoops& loops, const RadialCurves& curves, unsigned threads,
                bool has_patches = true);

    /// The patch of a face that is not cut.
    const RadialPatch& operator[](FaceId face) const { return patches_[face]; }
    bool is_cut(FaceId face) const { return !sectors_[face].empty() || halves(face) != nullptr; }
    const CylinderTurns& turns() const { return turns_; }
    bool has_cuts() const {
        return !halves_.empty() || std::ranges::any_of(sectors_, [](const auto& s) { return !s.empty(); });
    }
    /// The sectors of a face that is cut about an axis: once around, then those that share a place with one
    /// of these.
    std::span<const Sector> sectors(FaceId face) const { return sectors_[face]; }
    /// The first one at each place.
    std::span<const Sector> places(FaceId face) const {
        const std::span<const Sector> all = sectors_[face];
        return all.first(all.size() -
                         std::ranges::count_if(all, [](const Sector& s) { return s.other > 0; }));
    }
    std::vector<CutSector> cut_sectors(FaceId face) const {
        std::vector<CutSector> all;
        for (const Sector& s : sectors_[face]) all.push_back({s.reach(), s.place});
        return all;
    }
    /// Is it a face of an ellipsoid around the base?
    bool can_be_halved(FaceId face) const { return halvings_.contains(face); }
    /// The halves of a face that is cut across an axis; of others null.
    const SurfaceHalves* halves(FaceId face) const {
        const auto found = halves_.find(face);
        return found == halves_.end() ? nullptr : &found->second;
    }
    /// The patch of a sector or half of a face that is cut, and how many there are.
    const RadialPatch& part(FaceId face, std::uint32_t i) const {
        const SurfaceHalves* two = halves(face);
        return two != nullptr ? two->patch(i) : sectors_[face][i].patch;
    }
    std::size_t part_count(FaceId face) const { return halves(face) != nullptr ? 2 : sectors_[face].size(); }
    /// The tips that lie inside a face that has patches about its object's axis.
    std::span<const BisectorTip> tips(FaceId face) const {
        return tips_ ? (*tips_)[face] : std::span<const BisectorTip>();
    }
    bool is_in_vessel(FaceId face) const { return is_vessel(object(face)); }
    /// The part in which a point of a face's boundary lies, which rises there with the face on its left or
    /// falls.
    std::uint32_t part_of(FaceId face, const Vec3& p, bool rises) const;
    /// The patch around a point of a face, on or off its boundary. Pre: the face has no sectors.
    const RadialPatch& patch_at(FaceId face, const Vec3& p) const {
        const SurfaceHalves* two = halves(face);
        return two != nullptr ? two->patch(two->half_of(p)) : patches_[face];
    }

    /// Gives a face other patches, as a weight is not positive or its seams do not divide it: narrower ones
    /// in the sectors that are too wide, other halves, or one instead of strips, if it is cut. False where
    /// there are none.
    bool change(FaceId face, const std::vector<bool>& is_too_wide);

    /// Cuts a face whose patch is a graph and reaches far beyond it into strips, given some of its points, or
    /// gives it sectors if digits do not tell the graph. A face that change() has put together again stays
    /// whole.
    void suit_graph(FaceId face, const std::vector<std::vector<Vec3>>& points);

    /// Is the bisector a plane? Pre: the form has a face.
    bool is_flat(FormId form) const { return is_flat_[form]; }
    /// A unit normal somewhere in the face, or among its loops.
    Vec3 middle(FaceId face) const;
    /// What a fit is told of an edge's left (side 0) or right, where there is a form.
    SpaceSite site(EdgeId e, unsigned side) const;

private:
    const Object& object(FaceId face) const { return problem_.objects[diagram_.face_forms[face]]; }
    /// May it reach around its object, or come to its axis in a tip?
    bool may_reach_around(FaceId face) const;
    std::vector<Vec3> poles(FaceId face) const;
    void add_in_sphere(FaceId face);
    bool halve(FaceId face);
    bool is_owned_by_others(FormId form, const Vec3& direction, bool asks_tubes) const;
    RadialPatch patch_around(FaceId face, const CylinderTurns::Extent& e, bool wide) const;
    void add_about_object(FaceId face);
    void add_around_cylinder(FaceId face);
    void add_around_tip(FaceId face, const BisectorTip& beside);
    void cut(FaceId face);
    RadialPatch patch_of(FaceId face, const SectorRange& range) const;
    void set_sectors(FaceId face, std::span<const SectorRange> all);
    void change_and_cut(FaceId face);
    bool narrow(FaceId face, const std::vector<bool>& is_too_wide);

    const RadialBaseProblem& problem_;
    const MinimizationDiagram& diagram_;
    const FaceLoops& loops_;
    const RadialCurves& curves_;
    const CylinderTurns turns_;
    const bool has_patches_;
    IdVector<FaceId, RadialPatch> patches_;
    IdVector<FaceId, std::vector<Sector>> sectors_;
    std::map<FaceId, SurfaceHalves> halves_;    // over a sphere, of hollow spheres' faces
    std::map<FaceId, std::size_t> halvings_;    // how often they were looked for, of those that may have some
    std::map<FaceId, SkewAxes> skew_axes_;      // around a cylinder, of graphs that may be cut
    std::map<FaceId, ObjectAxis> object_axes_;  // of faces that have patches about their object's axis
    std::map<FaceId, BisectorTip> tips_beside_;  // over a cylinder, next to which such a face is
    std::optional<FaceTips> tips_;               // where there are such faces
    IdVector<FaceId, bool> wide_;                // over a sphere: has the patch been changed?
    IdVector<FormId, char> is_flat_;
};

}  // namespace vcell::radial
