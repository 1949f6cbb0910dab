// Curves of edges around a sphere or a cylinder, before faces have patches: these may be of any shape.
#include "lift.hpp"

#include <algorithm>
#include <vector>

#include "edge_fits.hpp"
#include "edge_lift.hpp"
#include "face_loops.hpp"
#include "face_patches.hpp"

namespace vcell {

namespace {

enum class Wanted { All, BetweenObjects };

class CurveLift : public EdgeLift {
public:
    CurveLift(const RadialDiagram& of, double tolerance, Wanted wanted, unsigned threads)
        : EdgeLift(of, threads),
          wanted_(wanted),
          loops_(of.diagram),
          patches_(of, loops_, curves_, threads, false),
          fits_(of, patches_, curves_, tolerance, threads) {
        std::vector<EdgeId> to_fit;
        for (const EdgeId e : of_.diagram.edges.ids())
            if (is_wanted(e) && fits_.is_asked_for(e)) to_fit.push_back(e);
        fits_.grant(to_fit.size());
        fits_.fit(to_fit);
        if (fits_.refine()) fits_.fit(to_fit);
        for (const EdgeId e : to_fit) fits_.require_proof(e);
    }

    LiftedEdgeErrors set_curve(EdgeId e, double ends, RationalCurve3& curve) const {
        if (!is_wanted(e)) return {0, 0};
        return EdgeLift::set_curve(e, ends, curve);
    }

private:
    bool is_wanted(EdgeId e) const {
        if (wanted_ == Wanted::All) return true;
        return std::ranges::count_if(of_.diagram.label(e),
                                     [&](FormId f) { return of_.main_site(f).is_object(); }) >= 2;
    }

    const Wanted wanted_;
    FaceLoops loops_;
    radial::FacePatches patches_;
    radial::EdgeFits fits_;
};

}  // namespace

LiftedCell lift_curves_between_objects(const RadialBaseProblem& problem, const MinimizationDiagram& diagram,
                                       double tolerance) {
    CurveLift lift({problem, diagram}, tolerance, Wanted::BetweenObjects, 1);
    return CellAssembly(lift)(false);
}

LiftedCell lift_curves_all_around(const RadialBaseProblem& problem, const MinimizationDiagram& diagram,
                                  double tolerance, bool with_measures, unsigned threads) {
    CurveLift lift({problem, diagram}, tolerance, Wanted::All, threads);
    return CellAssembly(lift, threads)(with_measures);
}

}  // namespace vcell
