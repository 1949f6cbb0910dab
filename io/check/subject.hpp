/// The cell under judgement, taken apart: Bézier pieces of all curves, the faces on either side of each edge.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "../../envelope/cell.hpp"
#include "certificate.hpp"
#include "curves.hpp"
#include "patches.hpp"
#include "scene.hpp"
#include "site_tree.hpp"
#include "space.hpp"

namespace vcell::check {

/// Relative to an edge's parameters: trimming curves that share a place of it were rounded on their way
/// there.
inline constexpr double kPlaceRounding = 1e-12;

struct Subject {
    /// `part`: of a complete cell around a tube, for which `geometry` was made; otherwise all is one. Pre:
    /// the structure holds. Keeps references.
    Subject(const Cell& cell, const SceneGeometry& geometry, Certificate& certificate,
            const TubePart* part = nullptr);

    /// One side of an edge: the face there, which may take several patches to run all along it.
    struct Use {
        std::size_t face;
        bool reversed;
        double begin, end;  // of the edge's parameters
    };

    /// The scene's, or the default; no less than rounding of coordinates.
    double tolerance() const;
    /// Of an edge, that of its end vertices included: the curve runs through them.
    double full_error(std::size_t e) const;
    /// Is it a face of a complete cell through which rays come into the box?
    bool is_entered(std::size_t face) const {
        return cell.is_complete && geometry.lets_in(cell.faces[face].site);
    }
    /// All sites of an edge, ascending.
    std::vector<Site> label(std::size_t e) const;

    /// An element of the part, as the certificate names it: "tiling", or "parts[2].tiling".
    std::string path(const char* what) const;

    const Cell& cell;
    const SceneGeometry& geometry;
    const TubePart* part;
    /// Numbers of the cell's elements that are judged here, ascending. Lists by edge have all of its edges.
    std::vector<std::uint32_t> vertices, edges, faces;
    Space<Interval> space;
    SiteTree tree;
    std::vector<std::vector<Bezier<3>>> edge_pieces;
    std::vector<std::vector<Use>> uses;    ///< by edge
    std::vector<std::optional<Site>> rim;  ///< by edge: what it runs over the rim towards
    std::vector<Patch> patches;

private:
    void prepare_patch(std::size_t f, std::size_t p, Certificate& certificate);
    void join_uses(std::size_t e, Certificate& certificate);
    Use use(std::size_t face, const TrimCurve& trim) const;
    bool over_rim(std::size_t e, const Site& site) const;
    bool is_on_base(std::size_t e) const;
};

}  // namespace vcell::check
