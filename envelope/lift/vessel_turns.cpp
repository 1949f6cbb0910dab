#include "vessel_turns.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "../../primitives/fit/arc_equations.hpp"
#include "../../primitives/objects/message.hpp"
#include "../room_at.hpp"

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
        loops.follow(ccb, [&](const Vec2& q, bool is_begin, bool is_vertex) {
            if (!is_begin) return loop.go_to(q);
            loop.start_at(q);
            if (is_vertex) of_vertices_.push_back(loop.angle(q));
        });
        if (!loop.is_closed() && (is_closed_ || !(loop.to() - loop.from() > width()))) continue;
        from_ = loop.from();
        to_ = loop.to();
        is_closed_ = loop.is_closed();
    }
}

// ---- Tips ---------------------------------------------------------------------------------------------

// Which form is the nearest at a tip distances tell; which of its faces is there, if there are several, their
// loops.
FaceTips::FaceTips(const RadialDiagram& of, const FaceLoops& loops) {
    const auto refuse = [&](FormId form, const VesselTip& tip) {
        throw UndecidedError("object " + to_string(of.main_site(form)) +
                             ": an edge of its face may run through the tip of its bisector at " +
                             to_text(Vec3(of.problem.unit * of.problem.frame.to_world(tip.point()))));
    };
    std::map<FormId, std::vector<FaceId>> faces;
    for (const FaceId face : of.diagram.face_forms.ids())
        if (const FormId form = of.diagram.face_forms[face]; form.valid()) faces[form].push_back(face);
    for (const auto& [form, all] : faces)
        for (const VesselTip& tip : vessel_tips(of.problem, form)) {
            const std::optional<bool> shows = shows_at(of.problem, form, tip.point(), tip.reach);
            if (!shows) refuse(form, tip);
            if (!*shows) continue;
            std::vector<FaceId> held = all;
            if (all.size() > 1)
                std::erase_if(held, [&](FaceId face) { return !holds(of, loops, face, tip); });
            if (held.size() != 1) refuse(form, tip);
            tips_[held.front()].push_back(tip);
        }
}

// How often the loops, each with the face on its left, go round a point of the chart: once more around one of
// the face than around the pole. From one point of the diagram to the next the straight way goes round as
// often as the arc unless their cell holds the point.
bool FaceTips::holds(const RadialDiagram& of, const FaceLoops& loops, FaceId face,
                     const VesselTip& tip) const {
    const bool has_pole = face == Dcel::unbounded_face();
    const Vec2 place = of.problem.chart.chart_point(tip.u, tip.y);
    if (!place.allFinite()) return has_pole;
    double turn = 0;
    for (const CcbId ccb : loops[face]) {
        std::optional<Vec2> last;
        const auto go_to = [&](const Vec2& q) {
            const Vec2 next = q - place;
            if (last) turn += std::atan2(last->x() * next.y() - last->y() * next.x(), last->dot(next));
            last = next;
        };
        loops.follow(ccb, [&](const Vec2& q, bool is_begin, bool) {
            if (!is_begin || !last) go_to(q);
        });
    }
    return std::lround(turn / (2 * std::numbers::pi)) + (has_pole ? 1 : 0) == 1;
}

}  // namespace vcell::radial
