/// A minimization diagram under construction, small and changed in place.
///
/// Its faces are compared with a challenger (the paper's comparison of two surfaces over an overlay face,
/// [HE, section 2.1]). A diagram that consists of one face needs no overlay, so forms can be inserted one at
/// a time: all faces are compared, or, where forms come in the order of K, those that a walk leads to. The
/// general merge takes the overlay of two diagrams and a challenger for each of its faces.
#pragma once

#include "work_walk.hpp"

namespace vcell {

class WorkDiagram : public WorkWalk {
public:
    explicit WorkDiagram(CircleKernel& kernel) : WorkWalk(kernel) {}

    /// One face labelled `site` in the convex polygon of these lines (counter-clockwise, positive inside).
    /// Pre: the lines are forms of the kernel; consecutive ones meet in the polygon's corners.
    void start(std::span<const FormId> lines, FormId site) {
        clear();
        WorkMesh::start(lines, site);
    }

    /// Becomes the diagram of the forms of both, by overlay. Pre: neither is this one; both have this
    /// one's kernel, the same polygon, and no form in common.
    void merge(const WorkDiagram& defender, const WorkDiagram& challenger);

private:
    void unite_ties();
};

}  // namespace vcell
