#include "measures.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include "../../core/quadrature/bounded_sum.hpp"
#include "../../core/small_vector.hpp"
#include "../../core/threads.hpp"
#include "../lift/face_loops.hpp"
#include "../lift/object_turns.hpp"
#include "../room_at.hpp"
#include "radial_distances.hpp"
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

class RadialMeasurer {
public:
    RadialMeasurer(const RadialBaseProblem& problem, const MinimizationDiagram& diagram,
                   const IdVector<EdgeId, double>& positions, Cell& cell)
        : problem_(problem),
          diagram_(diagram),
          positions_(positions),
          cell_(cell),
          areas_(cell.faces.size()) {}

    // Edges leave what they add task by task, in the same order whatever threads do what.
    void run(unsigned threads) {
        add_faces();
        choose_integrals();
        const std::size_t edges = diagram_.edges.size();
        in_order(
            range_count(edges), threads,
            [&](std::size_t task) {
                Sums sums;
                const std::size_t begin = task * elements_of_task;
                for (auto e = EdgeId{static_cast<std::uint32_t>(begin)};
                     e.value < std::min(edges, begin + elements_of_task); ++e.value)
                    measure_edge(e, sums);
                return sums;
            },
            [&](std::size_t, const Sums& sums) { add(sums); });
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
        distances_.set_clearances(radius, m);
        // A cylinder's stretch ends at the box.
        m.touches_box = !problem_.region.empty() || std::ranges::any_of(cell_.faces, [](const CellFace& f) {
            return f.site.kind == Site::Kind::BoxSide;
        });
        rank_neighbors(cell_);
    }

private:
    // What a task's edges add to the cell and to its faces.
    struct Sums {
        struct Area {
            std::uint32_t face;
            double value, error;
        };

        BoundedSum volume, box_area;
        RadialDistances distances;
        std::vector<Area> areas;
        std::vector<std::uint32_t> estimated;  // faces
    };
    void add(const Sums& sums) {
        volume_.add(sums.volume);
        box_area_.add(sums.box_area);
        distances_.add(sums.distances);
        for (const auto& [face, value, error] : sums.areas) areas_[face].add(value, error);
        for (const std::uint32_t face : sums.estimated) cell_.faces[face].is_estimated = true;
    }

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
            distances_.add_bisector(problem_, form, least_distance(faces_.back()));
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
        Points points;
        for (const EdgeId e : diagram_.edges.ids()) {
            const int degree = set_points(e, points);
            for (const unsigned side : {0u, 1u}) {
                const auto distance = distances.find(face(e, side));
                if (distance == distances.end()) continue;
                auto& [least, most] = distance->second;
                for (std::size_t i = 0; i < points.size(); i += degree) {
                    const double t = points[i].head<3>().norm();
                    least = std::min(least, t);
                    most = std::max(most, t);
                }
            }
        }
        for (const auto& [f, distance] : distances)
            std::get<radial_integrals::RoundFace>(faces_[f]).choose_integrals(distance);
    }

    std::uint32_t face(EdgeId e, unsigned side) const {
        return cell_faces_[diagram_.dcel.face(Dcel::half_edge(e, side)).value];
    }

    using Points = SmallVector<Vector4d, 8>;
    // Those of the edge's curve, canonical, which is of the degree returned.
    int set_points(EdgeId e, Points& points) const {
        points.clear();
        const RationalCurve3& curve = cell_.edges[e.value].curve;
        for (const Vector4d& p : curve.points) {
            const Vec3 canonical = problem_.frame.to_canonical(p.head<3>());
            points.push_back({canonical.x(), canonical.y(), canonical.z(), p.w()});
        }
        return curve.degree;
    }

    void measure_edge(EdgeId e, Sums& sums) {
        CellEdge& edge = cell_.edges[e.value];
        const std::uint32_t left = face(e, 0), right = face(e, 1);
        if (left == no_face && right == no_face) return;
        Points points;
        const int degree = set_points(e, points);
        const RadialFace& first = faces_[left != no_face ? left : right];
        const RadialFace* const second = left != no_face && right != no_face ? &faces_[right] : nullptr;
        RadialIntegrals sum;
        for (std::size_t i = 0; i + degree < points.size(); i += degree) {
            const std::span<const Vector4d> span(points.data() + i, degree + 1);
            if (!is_smooth(e))
                add_span(span, edge.kind != CurveKind::Spline, problem_.chart, first, second, sum);
            else if (degree == 1)
                add_segment(span[0].head<3>(), span[1].head<3>(), first, *second, sum);
            else
                add_conic(weighted(span), first, *second, sum);
        }
        edge.length = sum.length.value;
        edge.length_error = sum.length.error + length_sensitivity * positions_[e];
        sums.distances.add(sum.distance[0], sum.distance[1],
                           positions_[e] + 8 * u * (sum.distance[1] + problem_.chart.radius));
        if (!is_smooth(e)) {
            edge.is_estimated = edge.kind == CurveKind::Spline;
            for (const std::uint32_t f : {left, right})
                if (f != no_face) sums.estimated.push_back(f);
        }
        if (left != no_face) add_side(left, sum.sides[0], 1, sums);
        if (right != no_face) {
            add_side(right, sum.sides[left != no_face ? 1 : 0], -1, sums);
        } else if (diagram_.edges[e].on_rim()) {
            // The rim at the lower end runs about the axis counter-clockwise.
            sums.box_area.add(std::abs(sum.end_area.value), sum.end_area.error);
        }
        add_position_error(positions_[e], left, right, sum, is_smooth(e), sums);
        // What lies under the face ends there, with a wall as high as the distance.
        if (!diagram_.edges[e].on_rim() && (left == no_face || right == no_face))
            sums.volume.add(0, (2 * sum.length.value + 4 * positions_[e]) *
                                   (positions_[e] + sum.gap.from_curve) * sum.distance[1]);
    }
    // The control points of a conic's span, times their weights.
    static std::array<Vector4d, 3> weighted(std::span<const Vector4d> span) {
        std::array<Vector4d, 3> p;
        for (int k : {0, 1, 2}) p[k] << span[k].w() * span[k].head<3>(), span[k].w();
        return p;
    }

    // An edge beside a face of a closed bisector, on its left or right (sign = -1). Seen from the base's
    // centre a conic is a circle, of which a span is less than all.
    void add_angles(EdgeId e, double sign, SolidAngle& angle) const {
        Points points;
        const int degree = set_points(e, points);
        const bool is_conic = cell_.edges[e.value].kind != CurveKind::Spline;
        for (std::size_t i = 0; i + degree < points.size(); i += degree) {
            const std::span<const Vector4d> span(points.data() + i, degree + 1);
            const Vec3 from = span.front().head<3>().normalized(), to = span.back().head<3>().normalized();
            if (!is_smooth(e)) {
                const Integral above = angle_above_chord(span, is_conic, problem_.chart);
                angle.add(from, to, above.value, above.error, sign);
            } else if (degree == 2) {
                const std::array<Vector4d, 3> p = weighted(span);
                const Vec3 middle = (p[0] + 2 * p[1] + p[2]).head<3>().normalized(),
                           normal = (middle - from).cross(to - middle).normalized();
                const double height = normal.dot(middle);
                angle.add(from, middle, normal, height, sign);
                angle.add(middle, to, normal, height, sign);
            }
        }
    }
    void add_solid_angles() {
        std::map<std::uint32_t, SolidAngle> angles;
        for (std::uint32_t f = 0; f < faces_.size(); ++f)
            if (as_closed(faces_[f]) != nullptr) angles[f];
        if (angles.empty()) return;
        for (const EdgeId e : diagram_.edges.ids())
            for (const unsigned side : {0u, 1u})
                if (const auto angle = angles.find(face(e, side)); angle != angles.end())
                    add_angles(e, side == 0 ? 1 : -1, angle->second);
        // The chart's unbounded face is around its pole.
        const std::uint32_t at_pole = cell_faces_[Dcel::unbounded_face().value];
        for (const auto& [f, angle] : angles) {
            const auto* closed = as_closed(faces_[f]);
            const SolidAngle::Value omega = angle.value(SolidAngle::Place{-Vec3::UnitZ(), f == at_pole});
            const radial_integrals::Share mean = closed->mean();
            // Means are known to some ten roundings.
            const double error = omega.error + 32 * u * omega.angle;
            areas_[f].add(mean.area * omega.angle, mean.area * error);
            volume_.add(mean.volume * omega.angle, mean.volume * error);
        }
    }

    // Along the edges of a face that has an ellipsoid's far pole the area comes out less than nothing by what
    // is not the face's. Where rounding leaves it open which it is, distances tell whether the pole shows at
    // all, and if they do not, or another face may have it, both are enclosed.
    void add_poles() {
        for (const FaceId face : diagram_.face_forms.ids()) {
            const std::uint32_t f = cell_faces_[face.value];
            if (f == no_face) continue;
            const auto* round = std::get_if<radial_integrals::RoundFace>(&faces_[f]);
            if (round == nullptr || !round->is_ellipsoid()) continue;
            const double area = areas_[f].value(), error = areas_[f].bound();
            if (area > error) continue;
            bool is_told = area < -error;
            if (!is_told) {
                const FormId form = diagram_.face_forms[face];
                const std::optional<bool> shows =
                    shows_at(problem_, form, -round->d2 * round->axis, round->d2);
                if (shows == false) continue;
                is_told = shows == true && std::ranges::count(diagram_.face_forms, form) == 1;
            }
            const radial_integrals::Share mean = round->mean();
            // Some ten roundings each.
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
            for (const BisectorTip& tip : tips[face]) {
                const std::uint32_t f = cell_faces_[face.value];
                tip_face(f, [&](const auto& surface) {
                    const radial_integrals::Share share = surface.until_tip(tip);
                    areas_[f].add(share.area, share.area_rest);
                    volume_.add(share.volume, share.volume_rest);
                });
                cell_.faces[f].is_estimated = true;
                distances_.add_tip(tip, problem_.objects[diagram_.face_forms[face]]);
            }
    }

    static void add_side(std::uint32_t face, const RadialIntegrals::Side& side, double sign, Sums& sums) {
        sums.volume.add(sign * side.volume.value, side.volume.error);
        sums.areas.push_back({face, sign * side.area.value, side.area.error});
    }

    // What an edge that is off by `error` changes: strips of its length, which may itself be off by as much
    // at either end. Of a conic the integrands' own derivatives across the strip count, which rays
    // that graze the bisector make large; elsewhere the gap between the two bisectors, which closes towards
    // the true edge. Both doubled, and to first order.
    void add_position_error(double error, std::uint32_t left, std::uint32_t right, const RadialIntegrals& sum,
                            bool is_smooth, Sums& sums) const {
        const double length = 2 * sum.length.value + 4 * error;
        if (is_smooth) {
            for (const std::uint32_t side : {left, right}) {
                const auto& round = std::get<radial_integrals::RoundFace>(faces_[side]);
                const double near = std::max(0.0, sum.distance[0] - error), far = sum.distance[1] + error;
                sums.volume.add(0, length * error * round.volume_slope(near, far));
                sums.areas.push_back({side, 0, length * error * round.area_slope(near, far)});
            }
        } else {
            sums.volume.add(0, length * (error + sum.gap.from_curve) * sum.gap.apart);
            for (const std::uint32_t side : {left, right})
                if (side != no_face) sums.areas.push_back({side, 0, length * (error + sum.gap.from_curve)});
        }
    }

    const RadialBaseProblem& problem_;
    const MinimizationDiagram& diagram_;
    const IdVector<EdgeId, double>& positions_;
    Cell& cell_;
    std::vector<RadialFace> faces_;          // of the cell
    std::vector<std::uint32_t> cell_faces_;  // of each face of the diagram
    std::vector<BoundedSum> areas_;
    BoundedSum volume_, area_, box_area_;
    RadialDistances distances_;
};

}  // namespace

void measure_all_around(const RadialBaseProblem& problem, const MinimizationDiagram& diagram,
                        const IdVector<EdgeId, double>& positions, Cell& cell, unsigned threads) {
    RadialMeasurer(problem, diagram, positions, cell).run(threads);
}

}  // namespace vcell
