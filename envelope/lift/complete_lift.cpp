#include "complete_lift.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "../../core/curves/reversed_curve.hpp"
#include "../../core/errors.hpp"
#include "../../core/numbers/small_systems.hpp"
#include "../../primitives/objects/message.hpp"
#include "../measures/measures.hpp"

namespace vcell {

namespace {

constexpr std::uint32_t no_number = UINT32_MAX;

// Is the edge one of D's boundary?
bool is_shared(const MinimizationDiagram& d, EdgeId e) {
    const MinimizationDiagram::Edge& edge = d.edges[e];
    return !edge.on_rim() && d.is_of_floor(edge.left) != d.is_of_floor(edge.right);
}

// Vertices and edges of D's boundary below the floor, and which of those above they are.
template <class Problem>
class Matching {
public:
    Matching(const Problem& problem, const MinimizationDiagram& above, const MinimizationDiagram& below)
        : problem_(problem),
          above_(above),
          below_(below),
          vertices(below.vertices.size(), no_number),
          edges(below.edges.size(), no_number) {
        match_vertices();
        match_edges();
    }

private:
    using Name = std::pair<std::vector<FormId>, std::vector<std::uint32_t>>;

    static Name name(const MinimizationDiagram& d, VertexId v) {
        const auto label = d.label(v);
        const auto sides = d.sides(v);
        return {{label.begin(), label.end()}, {sides.begin(), sides.end()}};
    }
    static std::vector<VertexId> shared_vertices(const MinimizationDiagram& d) {
        std::vector<VertexId> all;
        for (const EdgeId e : d.edges.ids())
            if (is_shared(d, e))
                for (const VertexId v : {d.start(e), d.end(e)})
                    if (v.valid()) all.push_back(v);
        std::ranges::sort(all);
        all.erase(std::ranges::unique(all).begin(), all.end());
        return all;
    }

    void match_vertices() {
        std::map<Name, std::vector<VertexId>> named;
        for (const VertexId v : shared_vertices(above_)) named[name(above_, v)].push_back(v);
        for (const VertexId v : shared_vertices(below_)) {
            const MinimizationDiagram::Vertex& at = below_.vertices[v];
            std::vector<VertexId> near;
            for (const VertexId w : named[name(below_, v)]) {
                const MinimizationDiagram::Vertex& other = above_.vertices[w];
                const double rounding = 0x1p-48 * (at.point.norm() + other.point.norm());
                Eigen::Vector2d between = at.point - other.point;
                between.x() = std::remainder(between.x(), problem_.chart.circumference());
                if (between.norm() <= at.error + other.error + rounding) near.push_back(w);
            }
            if (near.size() != 1) fail(at);
            vertices[v.value] = near.front().value;
        }
    }

    // The pair of forms, the lower one on the left first, and where an edge starts and ends.
    using Key = std::tuple<FormId, FormId, std::uint32_t, std::uint32_t>;
    using Ends = std::pair<std::uint32_t, std::uint32_t>;

    void match_edges() {
        std::map<Key, std::uint32_t> named;
        // Where three forms tie all along an edge, as two sides of the box and the base do where an edge of
        // the box lies on the base, the two diagrams may have different pairs of them there.
        std::map<Ends, std::vector<std::uint32_t>> between;
        for (const EdgeId e : above_.edges.ids()) {
            if (!is_shared(above_, e)) continue;
            const MinimizationDiagram::Edge& edge = above_.edges[e];
            const std::uint32_t start = above_.start(e).value, end = above_.end(e).value;
            named[{edge.left, edge.right, start, end}] = e.value;
            named[{edge.right, edge.left, end, start}] = e.value;
            for (const Ends& ends : {Ends{start, end}, Ends{end, start}}) between[ends].push_back(e.value);
        }
        const auto above = [&](VertexId v) { return v.valid() ? vertices[v.value] : no_number; };
        for (const EdgeId e : below_.edges.ids()) {
            if (!is_shared(below_, e)) continue;
            const MinimizationDiagram::Edge& edge = below_.edges[e];
            const Ends ends{above(below_.start(e)), above(below_.end(e))};
            const auto found = named.find({edge.left, edge.right, ends.first, ends.second});
            if (found != named.end()) {
                edges[e.value] = found->second;
                continue;
            }
            const std::vector<std::uint32_t>& others = between[ends];
            if (ends.first == no_number || ends.first == ends.second || others.size() != 1 ||
                !share_forms(below_.start(e), edge, above_.edges[EdgeId{others.front()}]))
                throw InternalError("an edge of the floor is none of the roof's: e" +
                                    std::to_string(e.value));
            edges[e.value] = others.front();
        }
    }

    // Do all forms of both edges tie in the vertex below?
    bool share_forms(VertexId v, const MinimizationDiagram::Edge& one,
                     const MinimizationDiagram::Edge& other) const {
        const auto label = below_.label(v);
        return std::ranges::all_of(std::array{one.left, one.right, other.left, other.right},
                                   [&](FormId f) { return std::ranges::find(label, f) != label.end(); });
    }

    [[noreturn]] void fail(const MinimizationDiagram::Vertex& at) const {
        const Vec3 place = problem_.frame.to_world(problem_.chart.base_point(at.point));
        throw UndecidedError("vertices where rays come into the box are not told apart around " +
                             to_text(Vec3(problem_.unit * place)));
    }

    const Problem& problem_;
    const MinimizationDiagram &above_, &below_;

public:
    std::vector<std::uint32_t> vertices, edges;
};

// u for v and v for u.
void mirror(RationalCurve2& curve) {
    for (auto& p : curve.points) std::swap(p[0], p[1]);
}
void mirror(RationalPatch& s) {
    RationalPatch from = s;
    std::swap(s.degree_u, s.degree_v);
    std::swap(s.domain_u, s.domain_v);
    for (int i = 0; i <= s.degree_u; ++i)
        for (int j = 0; j <= s.degree_v; ++j) s.points[i * (s.degree_v + 1) + j] = from.point(j, i);
}

// A curve in the plane of a patch in the patch's parameters, on the same knots and weights.
RationalCurve2 image_on(const RationalPatch& plane, const RationalCurve3& curve) {
    const Vec3 origin = plane.point(0, 0).head<3>();
    Eigen::Matrix<double, 3, 2> sides;
    sides << plane.point(1, 0).head<3>() - origin, plane.point(0, 1).head<3>() - origin;
    RationalCurve2 image;
    image.degree = curve.degree;
    image.knots = curve.knots;
    for (const Eigen::Vector4d& p : curve.points) {
        const Eigen::Vector2d part = nearest_solution(sides, p.head<3>() - origin);
        image.points.push_back({plane.domain_u[0] + part.x() * (plane.domain_u[1] - plane.domain_u[0]),
                                plane.domain_v[0] + part.y() * (plane.domain_v[1] - plane.domain_v[0]),
                                p.w()});
    }
    return image;
}

template <class Problem>
class Joint {
public:
    Joint(const Problem& problem, const MinimizationDiagram& above, const MinimizationDiagram& below,
          const Matching<Problem>& matching, LiftedCell roof, LiftedCell floor)
        : problem_(problem),
          above_(above),
          below_(below),
          matching_(matching),
          roof_(std::move(roof)),
          floor_(std::move(floor)),
          vertices_{std::vector<std::uint32_t>(roof_.cell.vertices.size(), no_number),
                    std::vector<std::uint32_t>(floor_.cell.vertices.size(), no_number)},
          edges_{std::vector<std::uint32_t>(roof_.cell.edges.size(), no_number),
                 std::vector<std::uint32_t>(floor_.cell.edges.size(), no_number)} {}

    LiftedCell operator()(bool with_measures) {
        result_.cell.report = std::move(roof_.cell.report);
        result_.cell.report.decisions += floor_.cell.report.decisions;
        keep_edges(above_, roof_, 0);
        keep_edges(below_, floor_, 1);
        // Trims of the floor along shared edges are those of the faces that the diagram above has beside
        // them, which lie on the same sides of the box.
        trims_.resize(result_.cell.edges.size());
        keep_faces(above_, roof_.cell, 0);
        keep_faces(below_, floor_.cell, 1);
        if (with_measures) add_measures();
        rank_neighbors(result_.cell);
        return std::move(result_);
    }

private:
    static constexpr bool is_over_plane = std::is_same_v<Problem, PlaneBaseProblem>;

    bool shows(const MinimizationDiagram& d, FaceId f) const {
        return d.face_forms[f].valid() && problem_.shows(d.face_forms[f], d.is_below_floor);
    }

    std::uint32_t keep_vertex(const LiftedCell& from, unsigned part, std::uint32_t v) {
        const std::uint32_t above = part == 1 ? matching_.vertices[v] : no_number;
        std::uint32_t& number = above != no_number ? vertices_[0][above] : vertices_[part][v];
        if (number == no_number) {
            number = static_cast<std::uint32_t>(result_.cell.vertices.size());
            CellVertex& vertex = result_.cell.vertices.emplace_back(
                above != no_number ? roof_.cell.vertices[above] : from.cell.vertices[v]);
            // The base is no site of its own cell.
            const auto rest = std::remove(vertex.sites.begin(), vertex.sites.end(), Site::base());
            vertex.sites.resize(static_cast<std::size_t>(rest - vertex.sites.begin()));
        }
        return number;
    }

    void keep_edges(const MinimizationDiagram& d, LiftedCell& from, unsigned part) {
        for (const EdgeId e : d.edges.ids()) {
            const std::array shown{shows(d, d.face(e, 0)), shows(d, d.face(e, 1))};
            if (!shown[0] && !shown[1]) continue;
            if (const std::uint32_t above = part == 1 ? matching_.edges[e.value] : no_number;
                above != no_number) {
                edges_[1][e.value] = edges_[0][above];
                continue;
            }
            edges_[part][e.value] = static_cast<std::uint32_t>(result_.cell.edges.size());
            is_right_of_.push_back(!shown[0]);
            CellEdge& edge = result_.cell.edges.emplace_back(std::move(from.cell.edges[e.value]));
            result_.positions.push_back(from.positions[e]);
            for (std::uint32_t& v : edge.vertices) v = keep_vertex(from, part, v);
            // Along the base's region in the box its side is on both sides.
            for (const unsigned side : {0u, 1u})
                if (edge.sites[side] == Site::base()) edge.sites[side] = edge.sites[1 - side];
            std::erase(edge.extra_sites, Site::base());
            if (part == 0) continue;
            std::reverse(edge.vertices.begin(), edge.vertices.end());
            edge.curve = reversed(std::move(edge.curve));
        }
    }

    void keep_faces(const MinimizationDiagram& d, Cell& from, unsigned part) {
        std::size_t next = 0;
        for (const FaceId id : d.face_forms.ids()) {
            // Over a cylinder faces that do not show are not lifted.
            if (!d.face_forms[id].valid() || (!is_over_plane && !shows(d, id))) continue;
            const std::size_t i = next++;
            if (!shows(d, id)) {
                if (part == 0) note_trims(d, from.faces[i]);
                continue;
            }
            CellFace& face = result_.cell.faces.emplace_back(std::move(from.faces[i]));
            for (TrimmedPatch& patch : face.patches) {
                if (part == 1) mirror(patch.surface);
                for (auto& loop : patch.loops) {
                    for (TrimCurve& trim : loop)
                        part == 0 ? number_trim(trim) : turn_trim(d, patch.surface, trim);
                    if (part == 1) std::reverse(loop.begin(), loop.end());
                }
            }
        }
    }

    void number_trim(TrimCurve& trim) {
        if (trim.edge) trim.edge = edges_[0][*trim.edge];
    }

    // The floor's trims are made of those of the roof's faces, of this one, too, though the cell has it not.
    void note_trims(const MinimizationDiagram& d, CellFace& face) {
        for (TrimmedPatch& patch : face.patches)
            for (auto& loop : patch.loops)
                for (TrimCurve& trim : loop) {
                    if (!is_shared(d, EdgeId{*trim.edge})) continue;
                    TrimCurve& noted = trims_[edges_[0][*trim.edge]];
                    noted = std::move(trim);
                    noted.edge = edges_[0][*noted.edge];
                    mirror(noted.curve);
                }
    }

    void turn_trim(const MinimizationDiagram& d, const RationalPatch& surface, TrimCurve& trim) {
        const EdgeId e{*trim.edge};
        const std::uint32_t number = edges_[1][e.value];
        if (is_shared(d, e) && trims_[number].edge) {
            trim = std::move(trims_[number]);
        } else if (is_shared(d, e)) {
            // Another one than the roof's, and turned: its error has room for the rounding of the image.
            CellEdge& edge = result_.cell.edges[number];
            trim = {number, std::nullopt, !is_right_of_[number], image_on(surface, edge.curve)};
            if (trim.reversed) trim.curve = reversed(std::move(trim.curve));
            double size = 0;
            for (const Eigen::Vector4d& p : edge.curve.points) size = std::max(size, p.head<3>().norm());
            edge.error += 0x1p-48 * size;
        } else {
            trim.edge = number;
            trim.curve = reversed(std::move(trim.curve));
            mirror(trim.curve);
        }
    }

    // The floor begins on the base, next to its region in the box: its faces go down to clearance 0.
    void add_measures() {
        const Measures &roof = roof_.cell.measures, &floor = floor_.cell.measures;
        Measures& m = result_.cell.measures = roof;
        m.volume = roof.volume - floor.volume;
        m.volume_error = roof.volume_error + floor.volume_error + 0x1p-52 * (roof.volume + floor.volume);
        m.is_estimated = roof.is_estimated || floor.is_estimated;
        if constexpr (!is_over_plane)
            return add_measures_of_part();
        else if (problem_.has_curved_rim)
            set_region_in_vessels();
        m.box_area = roof.box_area + floor.box_area;
        m.box_area_error = roof.box_area_error + floor.box_area_error +
                           0x1p-52 * (std::abs(roof.box_area) + std::abs(floor.box_area));
        m.min_clearance = m.min_clearance_error = 0;
    }

    // What walls leave of the base region may keep clear of the box.
    void set_region_in_vessels() {
        Measures& m = result_.cell.measures;
        m.base_area = floor_.cell.measures.base_area;
        m.base_area_error = floor_.cell.measures.base_area_error;
        m.touches_box = std::ranges::any_of(result_.cell.edges, [](const CellEdge& e) {
            return std::ranges::any_of(e.sites, [](Site s) { return s.kind == Site::Kind::BoxSide; });
        });
    }

    // Measures are those of the faces alone: a tube's body and ends are added by the caller, who knows its
    // parts.
    void add_measures_of_part() {
        Measures& m = result_.cell.measures;
        m.area = m.area_error = m.box_area = m.box_area_error = 0;
        for (const CellFace& f : result_.cell.faces) {
            (f.site.is_object() ? m.area : m.box_area) += f.area;
            (f.site.is_object() ? m.area_error : m.box_area_error) += f.area_error + 0x1p-52 * f.area;
        }
        m.extend_clearances(floor_.cell.measures);
        m.body_volume = m.body_volume_error = m.base_area = m.base_area_error = 0;
    }

    const Problem& problem_;
    const MinimizationDiagram &above_, &below_;
    const Matching<Problem>& matching_;
    LiftedCell roof_, floor_, result_;
    std::array<std::vector<std::uint32_t>, 2> vertices_, edges_;  // their numbers in the result
    std::vector<bool> is_right_of_;                               // the roof's or floor's face, by edge
    std::vector<TrimCurve> trims_;                                // of the floor, by edge
};

}  // namespace

namespace {

template <class Problem>
LiftedCell joint_of(const Problem& problem, const MinimizationDiagram& above, MinimizationDiagram below,
                    bool with_measures, const auto& lift) {
    const Matching<Problem> matching(problem, above, below);
    for (const VertexId v : below.vertices.ids())
        if (matching.vertices[v.value] != no_number)
            below.vertices[v] = above.vertices[VertexId{matching.vertices[v.value]}];
    LiftedCell roof = lift(above), floor = lift(below);
    return Joint<Problem>(problem, above, below, matching, std::move(roof), std::move(floor))(with_measures);
}

}  // namespace

LiftedCell lift_complete(const PlaneBaseProblem& problem, const MinimizationDiagram& above,
                         MinimizationDiagram below, double tolerance, bool with_measures, unsigned threads) {
    return joint_of(problem, above, std::move(below), with_measures, [&](const MinimizationDiagram& d) {
        return lift_over_region(problem, d, tolerance, with_measures, threads);
    });
}

LiftedCell lift_complete_part(const RadialBaseProblem& problem, const MinimizationDiagram& above,
                              MinimizationDiagram below, double tolerance, bool with_measures) {
    return joint_of(problem, above, std::move(below), with_measures, [&](const MinimizationDiagram& d) {
        return lift_all_around(problem, d, tolerance, with_measures);
    });
}

}  // namespace vcell
