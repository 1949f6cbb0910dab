/// STEP (ISO 10303-21, AP214) of a cell, or of all cells of a diagram: closed solids for CAD.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <memory>

#include "../../envelope/voronoi_diagram.hpp"
#include "../pictures/diagram_pictures.hpp"

namespace vcell {

namespace step {
class File;
}

/// A MANIFOLD_SOLID_BREP for each connected part, most often one, the base's own body included: what closes
/// the cell (closed_shell()) are planar faces. Each other ADVANCED_FACE is a patch of a face, named after its
/// site, in its colour, on the rational Bezier surface of the patch, written as a B-spline with inner knots
/// (with_knots()) by which other programs find its integrals; each edge a rational B-spline curve in space
/// with its curves in the parameters of both surfaces, cut where seams end. Tips of hollow tubes' and cones'
/// bisectors are corners of caps (with_tip_caps()). Nothing else is approximated
/// again: curves and surfaces are the cell's, and the file's uncertainty is 1.2 times the largest of what
/// edges state as their error and vertices and seams are off by (at least 1e-7). An edge no longer than that
/// is left out, and its ends are one vertex; in a cell below 0.1 one no longer than a millionth of it. Units
/// are those of the scene if they are m, cm, mm, um or nm, otherwise they are taken for mm. No time is in the
/// file: the same cell makes the same bytes. Parts of a tube's complete cell are one solid where
/// joined_parts() joins them: a face goes on beyond such an end as another ADVANCED_FACE, and its edges there
/// have curves in its parameters that are fitted anew where both parts run through them unalike.
void write_step(std::ostream& out, const Cell& cell);

/// The cells of a diagram in one STEP file, one after the other as they are computed (DiagramOptions::visit;
/// DiagramOptions::complete closes those of planes and tubes in the box): solids as write_step() has them,
/// each by itself, "cell 7 (name)" in one colour. Neighbours are bounded by one surface, which each has as
/// its own cell does, within the errors that both state. Faces are named after what is beyond, images as
/// "3(0,-1,0)". The uncertainty is that of the solid that is off most.
class DiagramStep {
public:
    DiagramStep(std::ostream& out, const DiagramScene& scene);
    ~DiagramStep();
    DiagramStep(const DiagramStep&) = delete;
    DiagramStep& operator=(const DiagramStep&) = delete;

    /// Throws as solid_of(); then nothing of the cell is written.
    void add(std::uint32_t object, const Cell& cell);
    void finish();

private:
    const std::unique_ptr<step::File> file_;
    CellColours colours_;
};

}  // namespace vcell
