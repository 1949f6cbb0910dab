/// The Voronoi cell of a scene's base as users receive it: vertices, space curves, trimmed patches.
/// World coordinates and the scene's unit of length throughout. The layout is that of the cell file.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <ranges>
#include <string>
#include <vector>

#include "../core/curves/bspline.hpp"
#include "../core/numbers/sign.hpp"
#include "../primitives/objects/scene.hpp"
#include "../primitives/objects/site.hpp"

namespace vcell {

/// What a length, an area or a measure is that was not asked for (CellOptions::measure).
constexpr double not_measured = std::numeric_limits<double>::quiet_NaN();

enum class CurveKind : std::uint8_t { Line, Circle, Ellipse, Parabola, Hyperbola, Spline };
std::string to_string(CurveKind kind);  ///< "line", "circle", ...

/// A point of the cell's boundary that is equally far from the base and from every one of `sites`.
/// Vertices on a box side, or over the rim of the base region, list that side among the sites.
struct CellVertex {
    Vec3 point;
    double radius = 0;           ///< clearance
    SmallVector<Site, 4> sites;  ///< all that attain it, ascending; the base is not listed
    double error = 0;            ///< bound on the distance of `point` from the true vertex
    /// No three bisectors are proved to cross in it. Then `error` bounds by how much its sites' distances
    /// differ from the base's, halved; its place along touching bisectors is not bounded.
    bool is_touching = false;
};

/// A trisector arc, maximal between vertices, or an arc of a box side or of the region's rim. Where a
/// vessel's wall is a base plane's rim, that is on both sides of the edge.
struct CellEdge {
    std::array<Site, 2> sites;               ///< left and right of the edge, seen against the base normal
    std::vector<Site> extra_sites;           ///< further sites that attain the minimum all along it
    SmallVector<std::uint32_t, 2> vertices;  ///< {start, end}, or empty for a closed edge without vertex
    CurveKind kind = CurveKind::Line;
    /// Bound on the distance from the true arc, rounding included. It bounds |S(c(t)) - C(t)| too, for
    /// the trimming curves c of this edge, the surfaces S they lie on and this space curve C.
    double error = 0;
    double length = not_measured, length_error = not_measured;  ///< of the true arc
    bool is_estimated = false;                                  ///< length_error, otherwise a proven bound
    RationalCurve3 curve;
};

/// One directed curve of a trimming loop, in (u, v), parametrised like the edge's space curve
/// (reversed: the edge's space curve runs the other way, t -> domain_begin + domain_end - t).
struct TrimCurve {
    std::optional<std::uint32_t> edge;  ///< none: a seam piece, or a tip
    std::optional<std::uint32_t> seam;  ///< shared with the patch on the other side of a chart boundary
    /// All of it is one point of the surface: a tip of the bisector with a hollow tube or cone, on its axis.
    bool is_tip() const { return !edge && !seam; }
    bool reversed = false;
    RationalCurve2 curve;
};

struct TrimmedPatch {
    RationalPatch surface;
    std::vector<std::vector<TrimCurve>> loops;  ///< outer first (counter-clockwise), then holes (clockwise)
};

/// A connected region of the base with one nearest site, lifted to the cell's boundary.
struct CellFace {
    Site site;
    std::vector<Site> extra_sites;  ///< further sites that attain the minimum all over it
    std::string bisector;           ///< "paraboloid", "plane", "box", ...
    double area = not_measured, area_error = not_measured;
    std::vector<TrimmedPatch> patches;
    bool is_estimated = false;  ///< area_error, otherwise a proven bound

    /// The trims of all loops of all patches: what asks for each of them alike needs no nest of loops.
    auto trims() const {
        return patches | std::views::transform(&TrimmedPatch::loops) | std::views::join | std::views::join;
    }
};

/// All not_measured, and touches_box false, where measures were not asked for. Each `..._error` bounds the
/// distance of its measure from that of the true cell, unless it is estimated.
struct Measures {
    // The whole cell inside the box with the base's body, and all of that body.
    double volume = not_measured, volume_error = not_measured;
    double body_volume = not_measured, body_volume_error = not_measured;
    // The cell's boundary without its box sides and cap, its box sides, and the base region.
    double area = not_measured, area_error = not_measured;
    double box_area = not_measured, box_area_error = not_measured;
    double base_area = not_measured, base_area_error = not_measured;
    // Over the faces, box sides included.
    double min_clearance = not_measured, min_clearance_error = not_measured;
    double max_clearance = not_measured, max_clearance_error = not_measured;
    bool touches_box = false;   ///< over a plane base always: its region ends at the box
    bool is_estimated = false;  ///< the errors of volume, area and box_area, otherwise proven bounds

    /// To those of more faces.
    void extend_clearances(const Measures& other) {
        if (!(min_clearance <= other.min_clearance)) {
            min_clearance = other.min_clearance;
            min_clearance_error = other.min_clearance_error;
        }
        if (!(max_clearance >= other.max_clearance)) {
            max_clearance = other.max_clearance;
            max_clearance_error = other.max_clearance_error;
        }
    }
};

/// First and second moments of a cell's volume, the base's body included.
struct Moments {
    Vec3 centroid = Vec3::Constant(not_measured);
    double centroid_error = not_measured;  ///< bound on the distance from the true one
    /// The integral of (p - centroid)(p - centroid)^T over the volume, symmetric: length^5. Divided by the
    /// volume it is the covariance of a random point of the cell; its trace less itself is the tensor of
    /// inertia at density 1.
    Eigen::Matrix3d second = Eigen::Matrix3d::Constant(not_measured);
    double second_error = not_measured;  ///< bound on the error of each entry
};

/// A place where a cell's clearance is least, or greatest. There may be others.
struct ClearancePlace {
    Vec3 point = Vec3::Constant(not_measured);
    double error = not_measured;      ///< bound on the distance of `point` from the true boundary
    double clearance = not_measured;  ///< of `point`
    /// Bound on how far `clearance` is from the true cell's least, or greatest.
    double clearance_error = not_measured;
    std::vector<Site> sites;  ///< all that attain it: those of the element that holds the place
    /// That element: one of the three. A face that shares its site with others is not told from them.
    std::optional<std::uint32_t> vertex, edge, face;
};

/// None where none is proved.
struct ClearancePlaces {
    std::optional<ClearancePlace> least, greatest;
};

struct Report {
    Decisions decisions;
    /// How the diagram came about: forms inserted into diagrams (of pieces of the base's chart, or of discs),
    /// pairs of diagrams merged by overlay, pieces that certified subdivision came down to.
    std::uint64_t insertions = 0, merges = 0, pieces = 0;
    double seconds_bisectors = 0, seconds_envelope = 0, seconds_patches = 0;
    /// A bound on the distance that anything of the scene within the box has moved before it was decided
    /// about: all else is exact about that. Vertices are as far from those of the scene as that takes them.
    double moved = 0;
    std::vector<std::string> warnings;
};

/// What closes a cell's faces to the boundary of a solid, the base's own body included: walls, the base's
/// region, ends (io/solids/shell.hpp says which). Numbers go on from those of the cell's own elements;
/// lengths and areas are not_measured.
struct Closing {
    std::vector<CellVertex> vertices;
    std::vector<CellEdge> edges;
    std::vector<CellFace> faces;
};

/// What a complete cell around a tube has between two planes across the base's axis: a surface that is closed
/// but for ends in these planes. Nothing is said of what lies between parts (complete_tube.hpp).
struct CellPart {
    std::array<Vec3, 2> ends;  ///< where the axis meets the planes, "-" and "+", to a few roundings
    std::uint32_t faces = 0;   ///< how many of the cell's, in order, are the part's; none: nothing is in it
};

struct Cell {
    Scene scene;
    std::vector<CellVertex> vertices;
    std::vector<CellEdge> edges;
    std::vector<CellFace> faces;
    std::vector<std::uint32_t> neighbors;  ///< objects that own a face, alone or not, by decreasing area
    Measures measures;
    Report report;
    /// Are the faces all of the boundary, sides of the box through which rays come in included
    /// (CellOptions::complete)? Around a tube they come in parts, each with ends (complete_tube.hpp).
    /// Otherwise they stand over what the box holds of the base.
    bool is_complete = false;
    std::vector<CellPart> parts;  ///< of a complete cell around a tube, ascending along its axis
    /// As the cell's file has it. Cells that are computed have none: closing_of() makes it of their faces.
    std::optional<Closing> closing = std::nullopt;
    /// As asked for, and as the cell's file has them: moments_of() makes them (io/solids/moments.hpp).
    std::optional<Moments> moments = std::nullopt;
    /// Likewise: clearance_places() finds them (measures/clearance_places.hpp).
    std::optional<ClearancePlaces> clearance_places = std::nullopt;
};

/// Calls visit(site) for each site that an element of a cell names, or a place of its clearance, as often as
/// one does.
template <class AnyCell, class Visit>
void for_each_site(AnyCell& cell, Visit&& visit) {
    for (auto& v : cell.vertices)
        for (auto& s : v.sites) visit(s);
    for (auto& e : cell.edges) {
        for (auto& s : e.sites) visit(s);
        for (auto& s : e.extra_sites) visit(s);
    }
    for (auto& f : cell.faces) {
        visit(f.site);
        for (auto& s : f.extra_sites) visit(s);
    }
    if (!cell.clearance_places) return;
    for (auto* place : {&cell.clearance_places->least, &cell.clearance_places->greatest})
        if (*place)
            for (auto& s : (*place)->sites) visit(s);
}

/// Is it a face through which a base plane's rays come into a complete cell? Others stand over the base,
/// these are seen against its normals' sense. (Around a tube rays may come in through one part of a side and
/// leave through another one.)
bool is_entered(const Cell& cell, const CellFace& face);

/// What has been computed with the cap as an object of that site names it Site::cap(): the measures' area is
/// without it, and it is no neighbour. `probe` is in the cell's unit.
void name_cap(Cell& cell, Site cap, double probe);
/// The other way round: the cap is the last of the scene's objects, which has no probe. Pre: it has one.
Cell with_cap_as_object(Cell cell);

/// The sites of a cell that is one of a whole diagram's (Scene::numbers, Scene::images) name objects by their
/// places in its scene from here on, so that the cell stands for itself.
void number_by_places(Cell& cell);

/// All lengths, areas and volumes of the cell but its scene, in a unit `factor` times as small, exact for a
/// power of two; the parameters of its patches times `of_parameters`. Pre: no `closing`, no
/// `moments`, no `clearance_places`.
void scale(Cell& cell, double factor, double of_parameters, unsigned threads = 1);

}  // namespace vcell
