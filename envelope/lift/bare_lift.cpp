// Around a sphere, and in a vessel, edges are found before the patches are, and measures take nothing else.
#include "lift.hpp"

#include <algorithm>

#include "../measures/measures.hpp"
#include "edge_lift.hpp"

namespace vcell {

namespace {

class BareLift : public EdgeLift {
public:
    BareLift(const RadialDiagram& of, unsigned threads) : EdgeLift(of, threads), threads_(threads) {}

    void measure(const IdVector<EdgeId, double>& positions, Cell& cell) const {
        measure_all_around(of_.problem, of_.diagram, positions, cell, threads_);
    }

private:
    const unsigned threads_;
};

}  // namespace

LiftedCell lift_without_patches(const RadialBaseProblem& problem, const MinimizationDiagram& diagram,
                                double tolerance, bool with_measures, unsigned threads) {
    // Over a cylinder no form is circular; around a sphere the box has sides that are.
    if (problem.family.forms.empty() && std::ranges::none_of(problem.objects, is_vessel))
        return lift_all_around(problem, diagram, tolerance, with_measures, threads);
    if (!problem.family.is_all_circular())
        return lift_curves_all_around(problem, diagram, tolerance, with_measures, threads);
    BareLift lift({problem, diagram}, threads);
    return CellAssembly(lift, threads)(with_measures);
}

}  // namespace vcell
