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
#include "../object_distance.hpp"
#include "cap_angle.hpp"
#include "radial_integrals.hpp"

namespace vcell {

namespace {

using Eigen::Vector4d;

using roundoff::u;
constexpr std::uint32_t no_face = UINT32_MAX;

// The face of the cap that it is, or none.
const radial_integrals::RoundFace* as_cap(const RadialFace& face) {
    const auto* round = std::get_if<radial_integrals::RoundFace>(&face);
    return round != nullptr && round->is_cap() ? round : nullptr;
}

// How a face looks from a direction: one of the cap has of a curve what is between that and its chord.
RadialFace seen_from(const Vec3& direction, RadialFace face) {
    if (as_cap(face) != nullptr) std::get<radial_integrals::RoundFace>(face).axis = direction;
    return face;
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
        for (const EdgeId e : diagram_.edges.ids()) measure_edge(e);
        add_caps();
        Measures& m = cell_.measures;
        add_poles();
        for (std::size_t i = 0; i < areas_.size(); ++i) {
            // A face thinner than the spacing of doubles may come out below zero by its rounding.
            const double area = std::max(0.0, areas_[i].value());
            cell_.faces[i].area = area;
            cell_.faces[i].area_error = areas_[i].bound();
            const Site site = cell_.faces[i].site;
            if (site.kind != Site::Kind::Cap)
                (site.is_object() ? area_ : box_area_).add(area, areas_[i].bound());
            m.is_estimated = m.is_estimated || cell_.faces[i].is_estimated;
        }
        const double radius = problem_.chart.radius, pi = std::numbers::pi;
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

    // Where a face's edges start; and over a cylinder their distances from the axis.
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
                if (cell_.edges[e.value].curve.points.empty()) continue;
                const Vec3 p =
                    problem_.frame.to_canonical(cell_.edges[e.value].curve.points.front().head<3>());
                for (const unsigned side : {0u, 1u})
                    reaches[diagram_.dcel.face(Dcel::half_edge(e, side)).value].add(p);
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
            if (is_vessel(problem_.objects[form]) && problem_.family.forms.empty()) add_farthest(form);
            const double least = least_distance(faces_.back()),
                         error = 8 * u * (least + problem_.chart.radius + reach(problem_.objects[form]));
            if (problem_.floor.empty() || !std::isfinite(least)) {
                add_distance(least, least, error);
                continue;
            }
            // But over a floor it counts only where the cell is there.
            const Vec3 place = nearest_place(problem_.objects[form], least);
            const double room = room_at(form, place, least - problem_.chart.radius),
                         unsure = 64 * (error + u * place.norm());
            if (room > unsure)
                add_distance(least, least, error);
            else if (room >= -unsure)
                least_[0] = std::min(least_[0], least - error);
        }
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

    // Around a cylinder the bisector with a vessel is farthest from the base's axis where the rays from that
    // and from the wall meet head on: nothing later on has the place unless an edge runs through it.
    void add_farthest(FormId form) {
        for (const Vec3& p : places_head_on(problem_.objects[form])) {
            const double t = std::hypot(p.x(), p.z()),
                         error = 16 * u * (t + p.norm() + reach(problem_.objects[form])),
                         room = p.y() < problem_.stretch[0] || p.y() > problem_.stretch[1]
                                    ? -infinity
                                    : room_at(form, p, t - problem_.chart.radius);
            if (room > 4 * error)
                add_distance(t, t, error);
            else if (room >= -4 * error)
                greatest_[1] = std::max(greatest_[1], t + error);
        }
    }
    // Over a generator of a tube along the base, or all around it, they are many, or edges have them, too.
    std::vector<Vec3> places_head_on(const Object& vessel) const {
        const double R0 = problem_.chart.radius;
        if (const auto* ball = std::get_if<HollowSphere>(&vessel)) {
            const Vec3 c = ball->center, across(c.x(), 0, c.z());
            const double off = across.norm(), t = 0.5 * (ball->radius + R0 + off);
            const Vec3 u = off > 0 ? Vec3(across / off) : Vec3::UnitX().eval();
            return {Vec3(0, c.y(), 0) + t * u};
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
            const Vec3 e = cosine * toward + side * std::sqrt(1 - cosine * cosine) * aside,
                       out = K * e - S * w, beside = w.cross(e);
            const Vec3 direction = Vec3(out.x(), 0, out.z()).normalized();
            const double y = point.dot(beside) / beside.y();
            const Vec3 from(0, y, 0);
            const double own = tube != nullptr ? tube->radius : 0,
                         t = 0.5 * (own - out.dot(from - point) + R0);
            const Vec3 p = from + t * direction;
            if (std::isfinite(y) && (p - point).dot(e) > 0) places.push_back(p);
        }
        return places;
    }

    // How far a point of a form's bisector is inside the sides of the box, those of the floor among them, and
    // by how much other objects are farther than the base, at the clearance given: whichever is less.
    double room_at(FormId own, const Vec3& p, double clearance) const {
        double room = std::numeric_limits<double>::infinity();
        for (const FormId f : problem_.objects.ids()) {
            if (f == own) continue;
            const Object& object = problem_.objects[f];
            if (problem_.sites[f].front().is_object()) {
                room = std::min(room, distance_from(object, p) - clearance);
                continue;
            }
            const double beyond = signed_distance_from(object, p);
            room = std::min(room,
                            std::ranges::find(problem_.floor, f) != problem_.floor.end() ? beyond : -beyond);
        }
        return room;
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
                for (const auto& [face, other, sign] :
                     {std::tuple(left, right, 1.0), std::tuple(right, left, -1.0)})
                    bound_cap(face, other, span, sign);
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
        const bool has_left = left != no_face, has_both = has_left && right != no_face;
        const std::array beside{has_left ? left : right, has_both ? right : no_face};
        const auto is_cap = [&](std::uint32_t f) { return f != no_face && as_cap(faces_[f]) != nullptr; };
        if (!is_cap(left) && !is_cap(right))
            return add_span(span, is_conic, problem_.chart, faces_[beside[0]],
                            has_both ? &faces_[right] : nullptr, sum);
        const Vec3 from = span.front().head<3>().normalized(), to = span.back().head<3>().normalized();
        const RadialFace first = seen_from(from, faces_[beside[0]]),
                         other = seen_from(from, faces_[has_both ? right : beside[0]]);
        RadialIntegrals part;
        add_span(span, is_conic, problem_.chart, first, has_both ? &other : nullptr, part);
        for (std::size_t k = 0; k < 2; ++k) {
            if (!is_cap(beside[k])) continue;
            const double radius = as_cap(faces_[beside[k]])->d1, square = radius * radius;
            const Integral area = std::exchange(part.sides[k], {}).area;
            caps_[beside[k]].add(from, to, area.value / square, area.error / square * (1 + 4 * u),
                                 has_left && k == 0 ? 1 : -1);
        }
        sum += part;
    }
    // A conic that a face of the cap, if it is one, has on its left, or right (sign = -1).
    void bound_cap(std::uint32_t face, std::uint32_t other, std::span<const Vector4d> span, double sign) {
        const auto* cap = as_cap(faces_[face]);
        if (cap == nullptr) return;
        const auto& circle = std::get<radial_integrals::RoundFace>(faces_[other]);
        caps_[face].add(span[0].head<3>().normalized(), span[2].head<3>().normalized(), circle.axis,
                        circle.cosine_at(cap->d1), sign);
    }
    void add_caps() {
        for (std::uint32_t f = 0; f < faces_.size(); ++f) {
            const auto* cap = as_cap(faces_[f]);
            if (cap == nullptr) continue;
            const CapAngle::Value omega = caps_[f].value();
            const double square = cap->d1 * cap->d1, third = cap->d1 / 3;
            // The radius is known to a rounding, and so are products.
            const double error = omega.error + 8 * u * omega.angle;
            areas_[f].add(square * omega.angle, square * error);
            volume_.add(third * square * omega.angle, third * square * error);
        }
    }

    // The bisector with a hollow sphere is closed. Along the edges of a face that has the farthest point of
    // it the area comes out less than nothing by what is not the face's; where rounding leaves it open which
    // it is, both are enclosed.
    void add_poles() {
        for (std::uint32_t f = 0; f < faces_.size(); ++f) {
            const auto* round = std::get_if<radial_integrals::RoundFace>(&faces_[f]);
            if (round == nullptr || round->shape != radial_integrals::RoundFace::Shape::Ellipsoid) continue;
            const double area = areas_[f].value(), error = areas_[f].bound();
            const bool has_edges = error > 0;
            if (has_edges && area > error) continue;
            const radial_integrals::Share whole = round->whole();
            // Some ten roundings each.
            const bool is_told = !has_edges || area < -error;
            const double share = is_told ? 1 : 0.5, unsure = is_told ? 32 * u : 0.5;
            areas_[f].add(share * whole.area, unsure * whole.area);
            volume_.add(share * whole.volume, unsure * whole.volume);
            if (is_told) add_distance(round->d2, round->d2, 8 * u * round->d2);
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
    std::map<std::uint32_t, CapAngle> caps_;  // of the faces that are of the cap
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
