// Curves of edges between objects around a sphere or a cylinder, before faces have patches: these may be of
// any shape.
#include "lift.hpp"

#include <algorithm>
#include <vector>

#include "edge_fits.hpp"
#include "edge_lift.hpp"
#include "face_loops.hpp"
#include "face_patches.hpp"

namespace vcell {

namespace {

class CurveLift : public EdgeLift {
public:
    CurveLift(const RadialDiagram& of, double tolerance)
        : EdgeLift(of),
          loops_(of.diagram),
          patches_(of, loops_, curves_, false),
          fits_(of, patches_, curves_, tolerance) {
        std::vector<EdgeId> to_fit;
        for (const EdgeId e : of_.diagram.edges.ids())
            if (is_wanted(e) && fits_.is_asked_for(e)) to_fit.push_back(e);
        fits_.grant(to_fit.size());
        for (const EdgeId e : to_fit) fits_.fit(e);
        if (fits_.refine())
            for (const EdgeId e : to_fit) fits_.fit(e);
        for (const EdgeId e : to_fit) fits_.require_proof(e);
    }

    LiftedEdgeErrors set_curve(EdgeId e, double ends, RationalCurve3& curve) {
        if (!is_wanted(e)) return {0, 0};
        return EdgeLift::set_curve(e, ends, curve);
    }

private:
    bool is_wanted(EdgeId e) const {
        return std::ranges::count_if(of_.diagram.label(e),
                                     [&](FormId f) { return of_.main_site(f).is_object(); }) >= 2;
    }

    FaceLoops loops_;
    radial::FacePatches patches_;
    radial::EdgeFits fits_;
};

}  // namespace

LiftedCell lift_curves_between_objects(const RadialBaseProblem& problem, const MinimizationDiagram& diagram,
                                       double tolerance) {
    CurveLift lift({problem, diagram}, tolerance);
    return CellAssembly(lift)(false);
}

}  // namespace vcell
