// Around a sphere, and in a vessel, edges are found before the patches are, and measures take nothing else.
#include "lift.hpp"

#include "edge_lift.hpp"

namespace vcell {

LiftedCell lift_without_patches(const RadialBaseProblem& problem, const MinimizationDiagram& diagram,
                                double tolerance, bool with_measures, unsigned threads) {
    // Over a cylinder no form is circular; around a sphere the box has sides that are.
    if (problem.family.forms.empty() && !may_have_tips(problem))
        return lift_all_around(problem, diagram, tolerance, with_measures, threads);
    if (!problem.family.is_all_circular())
        return lift_curves_all_around(problem, diagram, tolerance, with_measures, threads);
    EdgeLift lift({problem, diagram}, threads);
    return CellAssembly(lift, threads)(with_measures);
}

}  // namespace vcell
