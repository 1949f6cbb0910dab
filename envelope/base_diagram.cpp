#include "base_diagram.hpp"

#include "diagram/settled_vertices.hpp"

namespace vcell {

MinimizationDiagram envelope_over(const FormFamily& family, std::span<const RegionSide> region,
                                  const EnvelopeOptions& options) {
    if (family.chart.is_cylinder())
        return lower_envelope_on_cylinder(family, -region[0].c, region[2].c, options);
    ConvexRegion polygon;
    for (const RegionSide& side : region) polygon.sides.push_back({side.a, side.b, side.c});
    MinimizationDiagram diagram = family.chart.is_sphere() ? lower_envelope_on_sphere(family, options)
                                                           : lower_envelope(family, polygon, options);
    settle_vertices(family, diagram);
    return diagram;
}

}  // namespace vcell
