/// The Voronoi cell of a scene's base as users receive it: vertices, space curves, trimmed patches.
/// World coordinates and the scene's unit of length throughout. The layout is that of the cell file.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "../core/bspline.hpp"
#include "../core/sign.hpp"
#include "../primitives/scene.hpp"
#include "../primitives/site.hpp"

namespace vcell {

enum class CurveKind : std::uint8_t { Line, Circle, Ellipse, Parabola, Hyperbola, Spline };
std::string to_string(CurveKind kind);  ///< "line", "circle", ...

/// A point of the cell's boundary that is equally far from the base and from every one of `sites`.
/// Vertices on a box side, or over the rim of the base region, list that side among the sites.
struct CellVertex {
    Vec3 point;
    double radius = 0;           ///< clearance
    SmallVector<Site, 4> sites;  ///< all that attain it, ascending; the base is not listed
    double error = 0;            ///< bound on the distance of `point` from the true vertex
};

/// A trisector arc, maximal between vertices, or an arc of a box side or of the region's rim.
struct CellEdge {
    std::array<Site, 2> sites;               ///< left and right of the edge, seen against the base normal
    std::vector<Site> extra_sites;           ///< further sites that attain the minimum all along it
    SmallVector<std::uint32_t, 2> vertices;  ///< {start, end}, or empty for a closed edge without vertex
    CurveKind kind = CurveKind::Line;
    /// Bound on the distance from the true arc; 0: exact up to rounding. It bounds |S(c(t)) - C(t)| too, for
    /// the trimming curves c of this edge, the surfaces S they lie on and this space curve C.
    double error = 0;
    double length = 0;
    RationalCurve3 curve;
};

/// One directed curve of a trimming loop, in (u, v), parametrised like the edge's space curve
/// (reversed: the edge's space curve runs the other way, t -> domain_begin + domain_end - t).
struct TrimCurve {
    std::optional<std::uint32_t> edge;  ///< none: a seam piece
    std::optional<std::uint32_t> seam;  ///< shared with the patch on the other side of a chart boundary
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
    double area = 0;
    std::vector<TrimmedPatch> patches;
};

struct Measures {
    double volume = 0, volume_error = 0;          ///< whole cell inside the box, the base's own body included
    double body_volume = 0;                       ///< the base body's share
    double area = 0, area_error = 0;              ///< cell boundary without its box sides
    double box_area = 0;                          ///< the box sides' part
    double base_area = 0;                         ///< the base region
    double min_clearance = 0, max_clearance = 0;  ///< over the faces, box sides included
    bool touches_box = false;                     ///< over a plane base always: its region ends at the box
};

struct Report {
    Decisions decisions;
    double seconds_bisectors = 0, seconds_envelope = 0, seconds_patches = 0;
    std::vector<std::string> warnings;
};

struct Cell {
    Scene scene;
    std::vector<CellVertex> vertices;
    std::vector<CellEdge> edges;
    std::vector<CellFace> faces;
    std::vector<std::uint32_t> neighbors;  ///< objects that own a face, by decreasing area
    Measures measures;
    Report report;
};

}  // namespace vcell
