#include "vessel_turns.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <numbers>
#include <optional>
#include <variant>

#include "../../primitives/fit/arc_equations.hpp"

namespace vcell::radial {

namespace {

// A loop's angles. Between two points of the chart in one cell of the diagram the arc may turn as it likes,
// but so does the straight way through the cell, as long as the axis does not come out of it.
class LoopTurn {
public:
    LoopTurn(const RadialDiagram& of, const VesselAxis& axis, FormId form)
        : of_(of),
          axis_(axis),
          equation_(
              space_fit::site_equation(of.problem.chart, of.problem.objects[form], false, Vec3::Zero())) {}

    void start_at(const Vec2& q) {
        if (place_) return;
        place_ = q;
        from_ = to_ = begin_ = angle_ = angle(q);
    }
    void go_to(const Vec2& q) {
        constexpr int steps = 8;
        const Vec2 start = *place_;
        for (int k = 1; k <= steps; ++k) {
            const double next = angle(start + (q - start) * k / steps);
            angle_ += std::remainder(next - angle_, 2 * std::numbers::pi);
            from_ = std::min(from_, angle_);
            to_ = std::max(to_, angle_);
        }
        place_ = q;
    }
    double angle(const Vec2& q) const {
        const Vec3 u = of_.problem.chart.normal(q);
        return axis_.angle(equation_.distance_along(Vec3::Zero(), u) * u);
    }

    double from() const { return from_; }
    double to() const { return to_; }
    bool is_closed() const { return std::abs(angle_ - begin_) > std::numbers::pi; }

private:
    const RadialDiagram& of_;
    const VesselAxis& axis_;
    const space_fit::Equation equation_;
    std::optional<Vec2> place_;
    double from_ = 0, to_ = 0, begin_ = 0, angle_ = 0;
};

}  // namespace

VesselAxis::VesselAxis(const Object& vessel) {
    const auto* tube = std::get_if<HollowCylinder>(&vessel);
    const Vec3 axis = (tube != nullptr ? tube->axis : std::get<HollowCone>(vessel).axis).stableNormalized();
    point = tube != nullptr ? tube->point : std::get<HollowCone>(vessel).apex;
    x = axis.unitOrthogonal();
    y = axis.cross(x);
}

VesselTurns::VesselTurns(const RadialDiagram& of, const FaceLoops& loops, const VesselAxis& axis,
                         FaceId face) {
    const MinimizationDiagram& diagram = of.diagram;
    for (const CcbId ccb : loops[face]) {
        LoopTurn loop(of, axis, diagram.face_forms[face]);
        loops.around(ccb, [&](EdgeId e, bool reversed) {
            const VertexId from = reversed ? diagram.end(e) : diagram.start(e),
                           to = reversed ? diagram.start(e) : diagram.end(e);
            const auto pieces = diagram.pieces(e);
            const std::size_t count = pieces.size();
            loop.start_at(from.valid() ? diagram.vertices[from].point : pieces.back().end);
            if (from.valid()) of_vertices_.push_back(loop.angle(diagram.vertices[from].point));
            for (std::size_t i = 0; i + 1 < count; ++i) loop.go_to(pieces[reversed ? count - 2 - i : i].end);
            loop.go_to(to.valid() ? diagram.vertices[to].point : pieces.back().end);
        });
        if (!loop.is_closed() && (is_closed_ || !(loop.to() - loop.from() > width()))) continue;
        from_ = loop.from();
        to_ = loop.to();
        is_closed_ = loop.is_closed();
    }
}

}  // namespace vcell::radial
