#include "object_turns.hpp"

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
    LoopTurn(const RadialDiagram& of, const ObjectAxis& axis, FormId form)
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
        const BaseChart& chart = of_.problem.chart;
        return axis_.angle(chart.point(q, equation_.distance_along(chart.foot(q), chart.normal(q))));
    }

    double from() const { return from_; }
    double to() const { return to_; }
    bool is_closed() const { return std::abs(angle_ - begin_) > std::numbers::pi; }

private:
    const RadialDiagram& of_;
    const ObjectAxis& axis_;
    const space_fit::Equation equation_;
    std::optional<Vec2> place_;
    double from_ = 0, to_ = 0, begin_ = 0, angle_ = 0;
};

}  // namespace

ObjectAxis::ObjectAxis(const Object& vessel) {
    Vec3 axis;
    if (const auto* tube = std::get_if<HollowCylinder>(&vessel)) {
        axis = tube->axis;
        point = tube->point;
    } else if (const auto* cone = std::get_if<HollowCone>(&vessel)) {
        axis = cone->axis;
        point = cone->apex;
    } else {
        axis = std::get<Cylinder>(vessel).axis;
        point = std::get<Cylinder>(vessel).point;
    }
    axis = axis.stableNormalized();
    x = axis.unitOrthogonal();
    y = is_vessel(vessel) ? axis.cross(x) : x.cross(axis);
}

ObjectTurns::ObjectTurns(const RadialDiagram& of, const FaceLoops& loops, const ObjectAxis& axis,
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
    const auto refuse = [&](FormId form, const BisectorTip& tip) {
        throw UndecidedError("object " + to_string(of.main_site(form)) +
                             ": an edge of its face may run through the tip of its bisector at " +
                             to_text(Vec3(of.problem.unit * of.problem.frame.to_world(tip.point()))));
    };
    std::map<FormId, std::vector<FaceId>> faces;
    for (const FaceId face : of.diagram.face_forms.ids())
        if (const FormId form = of.diagram.face_forms[face]; form.valid()) faces[form].push_back(face);
    for (const auto& [form, all] : faces)
        for (const BisectorTip& tip : bisector_tips(of.problem, form)) {
            // Along a cylinder they may lie beyond the ends.
            if (!(tip.y > of.problem.stretch[0] && tip.y < of.problem.stretch[1])) continue;
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

// How often the loops, each with the face on its left, cross the line from a point of the chart upwards, to
// the left: once more than to the right around one of the face, but for the pole. From one point of the
// diagram to the next the straight way does so as often as the arc unless their cell holds the point. Where
// it does, the arc meets each line along `direction` once, and that through the point where the face's form
// is no longer the lower one.
bool FaceTips::holds(const RadialDiagram& of, const FaceLoops& loops, FaceId face,
                     const BisectorTip& tip) const {
    const MinimizationDiagram& diagram = of.diagram;
    const bool has_pole = face == Dcel::unbounded_face();  // around a cylinder that is none with a form
    const Vec2 place = of.problem.chart.chart_point(tip.u, tip.y);
    if (!place.allFinite()) return has_pole;
    const auto turned = [](const Vec2& from, const Vec2& to) {
        return std::atan2(from.x() * to.y() - from.y() * to.x(), from.dot(to));
    };
    // Around a cylinder x = -1 and x = 3 are the same line.
    const auto wrapped = [&](const Vec2& way) {
        return Vec2(std::remainder(way.x(), of.problem.chart.circumference()), way.y());
    };
    double crossings = has_pole ? 1 : 0;
    loops.around(face, [&](EdgeId e, bool reversed) {
        const auto pieces = diagram.pieces(e);
        const auto end_of = [&](VertexId v, const Vec2& otherwise) {
            return v.valid() ? diagram.vertices[v].point : otherwise;
        };
        const bool is_left = diagram.edges[e].left == diagram.face_forms[face];
        const auto pass = [&](const Vec2& start, const Vec2& end, const std::optional<Vec2>& beyond) {
            const Vec2 from = wrapped(start - place), to = from + wrapped(end - start);
            const double angle = turned(Vec2::UnitY(), from),
                         sweep = beyond ? turned(*beyond, to) - turned(*beyond, from) : turned(from, to);
            constexpr double whole = 2 * std::numbers::pi;
            const double leftwards = std::floor((angle + sweep) / whole) - std::floor(angle / whole);
            crossings += reversed ? -leftwards : leftwards;
        };
        if (pieces.empty()) {
            pass(diagram.vertices[diagram.start(e)].point, diagram.vertices[diagram.end(e)].point,
                 std::nullopt);
            return;
        }
        Vec2 from = end_of(diagram.start(e), pieces.back().end);
        for (const auto& piece : pieces) {
            const Vec2 to = &piece == &pieces.back() ? end_of(diagram.end(e), piece.end) : piece.end;
            const auto& [x0, x1, y0, y1] = piece.box;
            std::optional<Vec2> beyond;
            if (place.x() >= x0 && place.x() <= x1 && place.y() >= y0 && place.y() <= y1)
                beyond = is_left ? piece.direction : Vec2(-piece.direction);
            pass(from, to, beyond);
            from = to;
        }
    });
    return crossings == 1;
}

}  // namespace vcell::radial
