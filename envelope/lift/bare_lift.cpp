// Around a sphere, and in a vessel, edges are found before the patches are, and measures take nothing else.
#include "lift.hpp"

#include <algorithm>

#include "../measures/measures.hpp"
#include "edge_lift.hpp"

namespace vcell {

namespace {

class BareLift : public EdgeLift {
public:
    explicit BareLift(const RadialDiagram& of) : EdgeLift(of) {}

    void measure(const IdVector<EdgeId, double>& positions, Cell& cell) const {
        measure_all_around(of_.problem, of_.diagram, positions, cell);
    }
};

}  // namespace

LiftedCell lift_without_patches(const RadialBaseProblem& problem, const MinimizationDiagram& diagram,
                                double tolerance, bool with_measures) {
    // Over a cylinder no form is circular; around a sphere the box has sides that are.
    if (problem.family.forms.empty() && std::ranges::none_of(problem.objects, is_vessel))
        return lift_all_around(problem, diagram, tolerance, with_measures);
    if (!problem.family.is_all_circular())
        return lift_curves_all_around(problem, diagram, tolerance, with_measures);
    BareLift lift({problem, diagram});
    return CellAssembly(lift)(with_measures);
}

}  // namespace vcell
