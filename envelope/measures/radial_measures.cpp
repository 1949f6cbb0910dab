#include "measures.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <tuple>
#include <utility>
#include <vector>

#include "../../core/quadrature/bounded_sum.hpp"
#include "../lift/face_loops.hpp"
#include "../lift/vessel_turns.hpp"
#include "../room_at.hpp"
#include "radial_integrals.hpp"
#include "solid_angle.hpp"

namespace vcell {

namespace {

using Eigen::Vector4d;

using roundoff::u;
using std::numbers::pi;
constexpr std::uint32_t no_face = UINT32_MAX;

// The face of a closed bisector that it is, or none.
const radial_integrals::RoundFace* as_closed(const RadialFace& face) {
    const auto* round = std::get_if<radial_integrals::RoundFace>(&face);
    return round != nullptr && round->is_closed() ? round : nullptr;
}

// Where rays from a base's centre or axis and from a vessel's wall meet head on. Over a generator of a tube
// along the base, or all around it, they are many, or edges have them, too. Pre: over a ball, a hollow
// sphere.
std::vector<Vec3> places_head_on(const Object& vessel, const BaseChart& chart) {
    const double R0 = chart.radius;
    if (const auto* ball = std::get_if<HollowSphere>(&vessel)) {
        const Vec3 foot = chart.foot_below(ball->center), away = ball->center - foot;
        const double off = away.norm(), t = 0.5 * (ball->radius + R0 + off);
        const Vec3 u = off > 0 ? Vec3(away / off) : Vec3::UnitX().eval();
        return {foot + t * u};
    }
    const auto* cone = std::get_if<HollowCone>(&vessel);
    const auto* tube = std::get_if<HollowCylinder>(&vessel);
    const Vec3 w = (cone != nullptr ? cone->axis : tube->axis).stableNormalized(),
               point = cone != nullptr ? cone->apex : tube->point;
    const double S = cone != nullptr ? cone->sine() : 0, K = cone != nullptr ? cone->cosine() : 1,
                 across = std::hypot(w.x(), w.z()), cosine = across > 0 ? S * w.y() / (K * across) : 2;
    if (!(std::abs(cosine) < 1)) return {};
    // The wall's generator beside the place is along w and e from the axis; the plane that touches there
    // is along the base.
    std::vector<Vec3> places;
    const Vec3 toward = (Vec3::UnitY() - w.y() * w) / across, aside = w.cross(toward);
    for (const double side : {-1.0, 1.0}) {
        const Vec3 e = cosine * toward + side * std::sqrt(1 - cosine * cosine) * aside, out = K * e - S * w,
                   beside = w.cross(e);
        const Vec3 direction = Vec3(out.x(), 0, out.z()).normalized();
        const double y = point.dot(beside) / beside.y();
        const Vec3 from(0, y, 0);
        const double own = tube != nullptr ? tube->radius : 0, t = 0.5 * (own - out.dot(from - point) + R0);
        const Vec3 p = from + t * direction;
        if (std::isfinite(y) && (p - point).dot(e) > 0) places.push_back(p);
    }
    return places;
}

class RadialMeasurer {
public:
    RadialMeasurer(const RadialBaseProblem& problem, const MinimizationDiagram& diagram,
                   const IdVector<EdgeId, double>& positions, Cell& cell)
        : problem_(problem),
          diagram_(diagram),
          positions_(positions),
          cell_(cell),
          areas_(cell.faces.size()) {}

    void run() {
        add_faces();
        choose_integrals();
        for (const EdgeId e : diagram_.edges.ids()) measure_edge(e);
        add_solid_angles();
        add_poles();
        add_tips();
        Measures& m = cell_.measures;
        for (std::size_t i = 0; i < areas_.size(); ++i) {
            // A face thinner than the spacing of doubles may come out below zero by its rounding.
            const double area = std::max(0.0, areas_[i].value());
            cell_.faces[i].area = area;
            cell_.faces[i].area_error = areas_[i].bound();
            (cell_.faces[i].site.is_object() ? area_ : box_area_).add(area, areas_[i].bound());
            m.is_estimated = m.is_estimated || cell_.faces[i].is_estimated;
        }
        const double radius = problem_.chart.radius;
        if (problem_.chart.is_sphere()) {
            m.base_area = 4 * pi * radius * radius;
            m.body_volume = m.base_area * radius / 3;
            m.base_area_error = 8 * u * m.base_area;
            m.body_volume_error = 8 * u * m.body_volume;
        } else {
            const double length = problem_.stretch[1] - problem_.stretch[0];
            // The ends carry a few roundings of the motion.
            const double relative = 8 * u *
                                    (1 + (std::abs(problem_.stretch[0]) + std::abs(problem_.stretch[1]) +
                                          problem_.frame.origin.norm()) /
                                             length);
            m.base_area = 2 * pi * radius * length;
            m.body_volume = pi * radius * radius * length;
            m.base_area_error = relative * m.base_area;
            m.body_volume_error = relative * m.body_volume;
            box_area_.add(-2 * pi * radius * radius, 32 * u * radius * radius);
        }
        m.volume = volume_.value();
        m.volume_error = volume_.bound();
        m.area = area_.value();
        m.area_error = area_.bound();
        m.box_area = box_area_.value();
        m.box_area_error = box_area_.bound();
        m.min_clearance = distance_[0] - radius;
        m.max_clearance = distance_[1] - radius;
        m.min_clearance_error = std::max(least_[1] - distance_[0], distance_[0] - least_[0]);
        m.max_clearance_error = std::max(greatest_[1] - distance_[1], distance_[1] - greatest_[0]);
        // A cylinder's stretch ends at the box.
        m.touches_box = !problem_.region.empty() || std::ranges::any_of(cell_.faces, [](const CellFace& f) {
            return f.site.kind == Site::Kind::BoxSide;
        });
        rank_neighbors(cell_);
    }

private:
    bool is_smooth(EdgeId e) const {
        return diagram_.is_circular(diagram_.edges[e].left) && cell_.edges[e.value].kind != CurveKind::Spline;
    }

    // Where a face's edges are; and over a cylinder their distances from the axis.
    struct Reach {
        Vec3 least = Vec3::Constant(std::numeric_limits<double>::infinity()), most = -least;
        double nearest = std::numeric_limits<double>::infinity(), farthest = 0;
        Vec3 at_nearest = Vec3::Zero();

        void add(const Vec3& p) {
            least = least.cwiseMin(p);
            most = most.cwiseMax(p);
            const double distance = std::hypot(p.x(), p.z());
            farthest = std::max(farthest, distance);
            if (!(distance < nearest)) return;
            nearest = distance;
            at_nearest = p;
        }
        // The face's integrals along the axis start between its ends; or in a tip, where rounding turns
        // points about the axis by most, and which then counts for nothing.
        radial_integrals::Around around() const {
            constexpr double tip_part = 0x1p-10;  // a matter of digits: integrals from any height are right
            const double height =
                nearest < tip_part * farthest ? at_nearest.y() : 0.5 * (least.y() + most.y());
            return {{at_nearest.x(), height, at_nearest.z()}, (most - least).norm()};
        }
    };

    void add_faces() {
        // Around a sphere only tubes ask for it.
        const bool are_asked = !problem_.family.is_all_circular();
        std::vector<Reach> reaches(are_asked ? diagram_.dcel.face_count() : 0);
        if (are_asked)
            for (const EdgeId e : diagram_.edges.ids()) {
                // The ends of spans: a face of two edges has no more than two vertices, which may be next to
                // each other.
                const RationalCurve3& curve = cell_.edges[e.value].curve;
                for (std::size_t i = 0; i < curve.points.size(); i += curve.degree) {
                    const Vec3 p = problem_.frame.to_canonical(curve.points[i].head<3>());
                    for (const unsigned side : {0u, 1u})
                        reaches[diagram_.dcel.face(Dcel::half_edge(e, side)).value].add(p);
                }
            }
        cell_faces_.resize(diagram_.dcel.face_count(), no_face);
        faces_.reserve(cell_.faces.size());
        for (const FaceId f : diagram_.face_forms.ids()) {
            const FormId form = diagram_.face_forms[f];
            if (!form.valid()) continue;
            cell_faces_[f.value] = static_cast<std::uint32_t>(faces_.size());
            faces_.push_back(make_radial_face(
                problem_, form, are_asked ? reaches[f.value].around() : radial_integrals::Around()));
            // The least of all forms' least distances is that of one which is nearest there. Elsewhere
            // the smallest distance is on an edge.
            if (is_vessel(problem_.objects[form])) add_farthest(form);
            const double least = least_distance(faces_.back()),
                         error = 8 * u * (least + problem_.chart.radius + reach(problem_.objects[form]));
            if (problem_.floor.empty() || !std::isfinite(least)) {
                add_distance(least, least, error);
                continue;
            }
            // But over a floor it counts only where the cell is there.
            const Vec3 place = nearest_place(problem_.objects[form], least);
            const double room = room_at(problem_, form, place, least - problem_.chart.radius),
                         unsure = 64 * (error + u * place.norm());
            if (room > unsure)
                add_distance(least, least, error);
            else if (room >= -unsure)
                least_[0] = std::min(least_[0], least - error);
        }
    }

    // Faces of ellipsoids get the integrals that suit their edges.
    void choose_integrals() {
        std::map<std::uint32_t, std::array<double, 2>> distances;
        for (std::uint32_t f = 0; f < faces_.size(); ++f)
            if (const auto* round = std::get_if<radial_integrals::RoundFace>(&faces_[f]);
                round != nullptr && round->is_ellipsoid())
                distances[f] = {std::numeric_limits<double>::infinity(), 0};
        if (distances.empty()) return;
        for (const EdgeId e : diagram_.edges.ids()) {
            const int degree = set_points(e);
            for (const unsigned side : {0u, 1u}) {
                const auto distance = distances.find(face(e, side));
                if (distance == distances.end()) continue;
                auto& [least, most] = distance->second;
                for (std::size_t i = 0; i < points_.size(); i += degree) {
                    const double t = points_[i].head<3>().norm();
                    least = std::min(least, t);
                    most = std::max(most, t);
                }
            }
        }
        for (const auto& [f, distance] : distances)
            std::get<radial_integrals::RoundFace>(faces_[f]).choose_integrals(distance);
    }

    // Where the bisector with a ball, or a tube that is not along the base's axis, is nearest to that, at the
    // distance `least`: towards the ball's centre, or the tube's axis.
    static Vec3 nearest_place(const Object& object, double least) {
        Vec3 q = Vec3::Zero();
        if (const auto* ball = std::get_if<Sphere>(&object)) {
            q = ball->center;
        } else {
            const auto& tube = std::get<Cylinder>(object);
            const Vec3 d = tube.axis.normalized();
            q = tube.point - (tube.point.x() * d.x() + tube.point.z() * d.z()) / (1 - d.y() * d.y()) * d;
        }
        const double away = std::hypot(q.x(), q.z());
        return {q.x() / away * least, q.y(), q.z() / away * least};
    }

    // The bisector with a vessel is farthest from the base's centre or axis where the rays from that and from
    // the wall meet head on: nothing later on has the place unless an edge runs through it.
    void add_farthest(FormId form) {
        for (const Vec3& p : farthest_places(form)) {
            const double t = problem_.chart.distance(p),
                         error = 16 * u * (t + p.norm() + reach(problem_.objects[form])),
                         height = problem_.chart.along(p.y()),
                         room = height < problem_.stretch[0] || height > problem_.stretch[1]
                                    ? -infinity
                                    : room_at(problem_, form, p, t - problem_.chart.radius);
            if (room > 4 * error)
                add_distance(t, t, error);
            else if (room >= -4 * error)
                greatest_[1] = std::max(greatest_[1], t + error);
        }
    }
    // Over a generator of a tube along the base, or all around it, they are many, or edges have them, too. At
    // a tip the bisector has no tangent plane; around a ball only those are far from it in a tube or cone.
    std::vector<Vec3> farthest_places(FormId form) const {
        const Object& vessel = problem_.objects[form];
        std::vector<Vec3> places;
        if (problem_.family.forms.empty() || std::holds_alternative<HollowSphere>(vessel))
            places = places_head_on(vessel, problem_.chart);
        for (const VesselTip& tip : vessel_tips(problem_, form)) places.push_back(tip.point());
        return places;
    }
    std::uint32_t face(EdgeId e, unsigned side) const {
        return cell_faces_[diagram_.dcel.face(Dcel::half_edge(e, side)).value];
    }

    // Those of the edge's curve, which is of the degree returned.
    int set_points(EdgeId e) {
        points_.clear();
        const RationalCurve3& curve = cell_.edges[e.value].curve;
        for (const Vector4d& p : curve.points) {
            const Vec3 canonical = problem_.frame.to_canonical(p.head<3>());
            points_.push_back({canonical.x(), canonical.y(), canonical.z(), p.w()});
        }
        return curve.degree;
    }

    void measure_edge(EdgeId e) {
        CellEdge& edge = cell_.edges[e.value];
        if (face(e, 0) == no_face && face(e, 1) == no_face) return;
        const int degree = set_points(e);
        const std::uint32_t left = face(e, 0), right = face(e, 1);
        RadialIntegrals sum;
        for (std::size_t i = 0; i + degree < points_.size(); i += degree) {
            const std::span<const Vector4d> span(points_.data() + i, degree + 1);
            if (!is_smooth(e)) {
                add_span_beside(left, right, span, edge.kind != CurveKind::Spline, sum);
            } else if (degree == 1) {
                add_segment(span[0].head<3>(), span[1].head<3>(), faces_[left], faces_[right], sum);
            } else {
                std::array<Vector4d, 3> p;
                for (int k : {0, 1, 2}) p[k] << span[k].w() * span[k].head<3>(), span[k].w();
                add_conic(p, faces_[left], faces_[right], sum);
                add_arcs(left, p, 1);
                add_arcs(right, p, -1);
            }
        }
        edge.length = sum.length.value;
        edge.length_error = sum.length.error + length_sensitivity * positions_[e];
        add_distance(sum.distance[0], sum.distance[1],
                     positions_[e] + 8 * u * (sum.distance[1] + problem_.chart.radius));
        if (!is_smooth(e)) {
            edge.is_estimated = edge.kind == CurveKind::Spline;
            for (const std::uint32_t f : {left, right})
                if (f != no_face) cell_.faces[f].is_estimated = true;
        }
        if (left != no_face) add_side(left, sum.sides[0], 1);
        if (right != no_face) {
            add_side(right, sum.sides[left != no_face ? 1 : 0], -1);
        } else if (diagram_.edges[e].on_rim()) {
            // The rim at the lower end runs about the axis counter-clockwise.
            box_area_.add(std::abs(sum.end_area.value), sum.end_area.error);
        }
        add_position_error(positions_[e], left, right, sum, is_smooth(e));
        // What lies under the face ends there, with a wall as high as the distance.
        if (!diagram_.edges[e].on_rim() && (left == no_face || right == no_face))
            volume_.add(0, (2 * sum.length.value + 4 * positions_[e]) * (positions_[e] + sum.gap.from_curve) *
                               sum.distance[1]);
    }

    // A span of any curve between two faces, of which one may not be there.
    void add_span_beside(std::uint32_t left, std::uint32_t right, std::span<const Vector4d> span,
                         bool is_conic, RadialIntegrals& sum) {
        const bool has_both = left != no_face && right != no_face;
        add_span(span, is_conic, problem_.chart, faces_[left != no_face ? left : right],
                 has_both ? &faces_[right] : nullptr, sum);
        for (const auto& [face, sign] : {std::pair(left, 1.0), std::pair(right, -1.0)}) {
            if (face == no_face || as_closed(faces_[face]) == nullptr) continue;
            const Integral above = angle_above_chord(span, is_conic, problem_.chart);
            angles_[face].add(span.front().head<3>().normalized(), span.back().head<3>().normalized(),
                              above.value, above.error, sign);
        }
    }
    // A conic beside a face, on its left or right (sign = -1): seen from the base's centre a circle, of which
    // the span is less than all.
    void add_arcs(std::uint32_t face, const std::array<Vector4d, 3>& p, double sign) {
        if (as_closed(faces_[face]) == nullptr) return;
        const Vec3 from = p[0].head<3>().normalized(), to = p[2].head<3>().normalized(),
                   middle = (p[0] + 2 * p[1] + p[2]).head<3>().normalized(),
                   normal = (middle - from).cross(to - middle).normalized();
        const double height = normal.dot(middle);
        angles_[face].add(from, middle, normal, height, sign);
        angles_[face].add(middle, to, normal, height, sign);
    }
    void add_solid_angles() {
        for (std::uint32_t f = 0; f < faces_.size(); ++f) {
            const auto* closed = as_closed(faces_[f]);
            if (closed == nullptr) continue;
            const SolidAngle::Value omega = angles_[f].value();
            const radial_integrals::Share mean = closed->mean();
            // Means are known to some ten roundings.
            const double error = omega.error + 32 * u * omega.angle;
            areas_[f].add(mean.area * omega.angle, mean.area * error);
            volume_.add(mean.volume * omega.angle, mean.volume * error);
        }
    }

    // Along the edges of a face that has an ellipsoid's far pole the area comes out less than nothing by what
    // is not the face's; where rounding leaves it open which it is, both are enclosed.
    void add_poles() {
        for (std::uint32_t f = 0; f < faces_.size(); ++f) {
            const auto* round = std::get_if<radial_integrals::RoundFace>(&faces_[f]);
            if (round == nullptr || !round->is_ellipsoid()) continue;
            const double area = areas_[f].value(), error = areas_[f].bound();
            if (area > error) continue;
            const radial_integrals::Share mean = round->mean();
            // Some ten roundings each.
            const bool is_told = area < -error;
            const double angle = is_told ? 4 * pi : 2 * pi, unsure = is_told ? 128 * u * pi : 2 * pi;
            areas_[f].add(angle * mean.area, unsure * mean.area);
            volume_.add(angle * mean.volume, unsure * mean.volume);
        }
    }

    // Around a sphere: what a face has around tips of the bisector within it. There the bisector is farthest.
    void add_tips() {
        const auto tip_face = [&](std::uint32_t f, auto&& use) {
            if (const auto* tube = std::get_if<radial_integrals::TubeFace>(&faces_[f])) use(*tube);
            if (const auto* cone = std::get_if<radial_integrals::ConeFace>(&faces_[f])) use(*cone);
        };
        bool may_have = false;
        for (std::uint32_t f = 0; f < faces_.size(); ++f) tip_face(f, [&](const auto&) { may_have = true; });
        if (!may_have) return;
        const RadialDiagram of{problem_, diagram_};
        const FaceLoops loops(diagram_);
        const radial::FaceTips tips(of, loops);
        for (const FaceId face : diagram_.face_forms.ids())
            for (const VesselTip& tip : tips[face]) {
                const std::uint32_t f = cell_faces_[face.value];
                tip_face(f, [&](const auto& surface) {
                    const radial_integrals::Share share = surface.until_tip(tip);
                    areas_[f].add(share.area, share.area_rest);
                    volume_.add(share.volume, share.volume_rest);
                });
                cell_.faces[f].is_estimated = true;
                add_distance(tip.reach, tip.reach,
                             32 * u * (tip.reach + reach(problem_.objects[diagram_.face_forms[face]])));
            }
    }

    // Of the point that an axis or a plane runs through: projections of it are rounded. A ball's power is
    // not.
    static double reach(const Object& object) {
        if (const auto* plane = std::get_if<Plane>(&object)) return plane->point.norm();
        if (const auto* vessel = std::get_if<HollowCylinder>(&object)) return vessel->point.norm();
        if (const auto* vessel = std::get_if<HollowCone>(&object)) return vessel->apex.norm();
        const auto* cylinder = std::get_if<Cylinder>(&object);
        return cylinder != nullptr ? cylinder->point.norm() : 0;
    }

    // A range of distances, known within an error.
    void add_distance(double low, double high, double error) {
        if (!std::isfinite(low)) return;
        distance_ = {std::min(distance_[0], low), std::max(distance_[1], high)};
        least_ = {std::min(least_[0], low - error), std::min(least_[1], low + error)};
        greatest_ = {std::max(greatest_[0], high - error), std::max(greatest_[1], high + error)};
    }

    void add_side(std::uint32_t face, const RadialIntegrals::Side& side, double sign) {
        volume_.add(sign * side.volume.value, side.volume.error);
        areas_[face].add(sign * side.area.value, side.area.error);
    }

    // What an edge that is off by `error` changes: strips of its length, which may itself be off by as much
    // at either end. Of a conic the integrand's own derivative across the strip counts; elsewhere the gap
    // between the two bisectors, which closes towards the true edge. Both doubled, and to first order.
    void add_position_error(double error, std::uint32_t left, std::uint32_t right, const RadialIntegrals& sum,
                            bool is_smooth) {
        const double length = 2 * sum.length.value + 4 * error;
        if (is_smooth) {
            for (const std::uint32_t side : {left, right}) {
                const auto& round = std::get<radial_integrals::RoundFace>(faces_[side]);
                const double near = std::max(0.0, sum.distance[0] - error), far = sum.distance[1] + error;
                volume_.add(0, length * error * round.volume_slope(near, far));
            }
        } else {
            volume_.add(0, length * (error + sum.gap.from_curve) * sum.gap.apart);
        }
        for (const std::uint32_t side : {left, right})
            if (side != no_face) areas_[side].add(0, length * (error + sum.gap.from_curve));
    }

    const RadialBaseProblem& problem_;
    const MinimizationDiagram& diagram_;
    const IdVector<EdgeId, double>& positions_;
    Cell& cell_;
    std::vector<RadialFace> faces_;          // of the cell
    std::vector<std::uint32_t> cell_faces_;  // of each face of the diagram
    std::vector<BoundedSum> areas_;
    std::map<std::uint32_t, SolidAngle> angles_;  // of the faces of closed bisectors
    BoundedSum volume_, area_, box_area_;
    std::vector<Vector4d> points_;  // of one edge, canonical
    std::array<double, 2> distance_{std::numeric_limits<double>::infinity(), 0};
    std::array<double, 2> least_{distance_[0], distance_[0]}, greatest_{0, 0};  // bounds of both
};

}  // namespace

void measure_all_around(const RadialBaseProblem& problem, const MinimizationDiagram& diagram,
                        const IdVector<EdgeId, double>& positions, Cell& cell) {
    RadialMeasurer(problem, diagram, positions, cell).run();
}

}  // namespace vcell
