#include "conforming_meshes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "../../envelope/whole/cell_finder.hpp"
#include "../../envelope/whole/void_network.hpp"
#include "known_mesh.hpp"

namespace vcell {

namespace {

using Image = std::array<std::int16_t, 3>;
using SharedId = std::uint64_t;
using MeetingSites = std::vector<NetworkSite>;  // ascending, the cell's own object among them
constexpr Image unmoved{0, 0, 0};

Image sum(const Image& a, const Image& b) {
    Image result;
    for (std::size_t k = 0; k < 3; ++k) result[k] = static_cast<std::int16_t>(a[k] + b[k]);
    return result;
}
Image opposite(const Image& a) {
    Image result;
    for (std::size_t k = 0; k < 3; ++k) result[k] = static_cast<std::int16_t>(-a[k]);
    return result;
}
NetworkSite moved(NetworkSite site, const Image& by) {
    if (site.site.is_object()) site.image = sum(site.image, by);
    return site;
}

/// A point of several meshes, by its number and by how many edges of the box it is moved: so it has one place
/// in each, however it came there.
struct SharedPoint {
    SharedId id;
    Image image;
    Vec3 unmoved_place;

    SharedPoint at(const Image& by) const { return {id, sum(image, by), unmoved_place}; }
    std::pair<SharedId, Image> key() const { return {id, image}; }
};

/// What is stored lies as seen from the cell that drew it; its own object is there at image 0, 0, 0.
struct SharedLine {
    SharedId id;
    std::vector<SharedPoint> points;  // of a closed one the first comes again in the end
    MeetingSites sites;
    bool is_closed;
    double error;
};

struct SharedVertex {
    SharedPoint point;
    MeetingSites sites;  // all that cells so far have listed
    double error;
    bool is_touching;
    std::vector<std::shared_ptr<SharedLine>> lines;  // that end here and in a vertex of no lower number
};

/// One of the lines around a face, and which way the face's loops run along it.
struct BorderLine {
    SharedId line;
    Image image;
    bool is_reversed;

    friend auto operator<=>(const BorderLine&, const BorderLine&) = default;
};

struct SharedFace {
    std::uint32_t owner;
    NetworkSite beyond;
    std::vector<BorderLine> border;  // ascending
    std::vector<SharedPoint> points;
    std::vector<Triangle> triangles;  // into points
    std::vector<Vec3> normals;
    std::vector<Triangle> corner_normals;
};

/// A stored thing in the list of one of its objects, which is there at that image.
struct ListedLine {
    std::shared_ptr<SharedLine> what;
    Image image;
};
/// With what tells most vertices apart, so that they need not be looked up.
struct ListedVertex {
    std::shared_ptr<SharedVertex> what;
    Image image;
    Vec3 place;    // unmoved
    double error;  // infinite where it bounds nothing

    ListedVertex(std::shared_ptr<SharedVertex> vertex, const Image& in)
        : what(std::move(vertex)),
          image(in),
          place(what->point.unmoved_place),
          error(what->is_touching ? std::numeric_limits<double>::infinity() : what->error) {}
};
template <class T>
using Lists = std::unordered_map<std::uint32_t, std::vector<T>>;

struct HashPlace {
    std::size_t operator()(const std::pair<SharedId, Image>& place) const {
        const auto& [x, y, z] = place.second;
        return static_cast<std::size_t>(place.first * 27) + static_cast<std::size_t>(9 * x + 3 * y + z);
    }
};

std::size_t common_sites(const MeetingSites& stored, const Image& by, const MeetingSites& own) {
    return static_cast<std::size_t>(std::ranges::count_if(
        stored, [&](const NetworkSite& s) { return std::ranges::binary_search(own, moved(s, by)); }));
}

/// A vertex of the cell that is being drawn: which stored one it is.
struct CellPoint {
    SharedPoint point;
    std::shared_ptr<SharedVertex> vertex;
};

/// A line of that cell.
struct CellLine {
    SharedId id;
    Image image;
    bool is_reversed;                 // the stored line runs against the edge
    std::vector<SharedPoint> points;  // from the edge's start to its end
};

}  // namespace

// ---- What is kept ------------------------------------------------------------------------------------

class ConformingMeshes::Store {
public:
    explicit Store(const DiagramScene& scene) : has_come_(scene.objects.size(), false) {
        if (scene.is_periodic()) decided_.emplace(scene);
    }

    bool is_periodic() const { return decided_.has_value(); }
    Vec3 place(const Vec3& unmoved_place, const Image& by) const {
        if (by == unmoved) return unmoved_place;
        return unmoved_place + decided_->balls().lattice().shift(by);
    }
    Vec3 place(const SharedPoint& p) const { return place(p.unmoved_place, p.image); }

    SharedPoint new_point(const Vec3& place) { return {next_++, unmoved, place}; }
    SharedId new_id() { return next_++; }

    /// Cells of lower objects come no more.
    void pass_to(std::uint32_t object) {
        for (; passed_ < object; ++passed_) {
            vertices.erase(passed_);
            closed_lines.erase(passed_);
            faces.erase(passed_);
        }
    }
    void has_drawn(std::uint32_t object) { has_come_[object] = true; }
    bool has_come(std::uint32_t object) const { return has_come_[object]; }
    bool may_come(std::uint32_t object) const { return object >= passed_; }

    /// Under each of its objects whose cells may come.
    template <class T, class Shared>
    void list(Lists<T>& lists, const std::shared_ptr<Shared>& what) {
        for (const NetworkSite& s : what->sites)
            if (s.site.is_object() && may_come(s.site.index)) lists[s.site.index].push_back(T{what, s.image});
    }

    Lists<ListedVertex> vertices;
    Lists<ListedLine> closed_lines;
    std::unordered_map<std::uint32_t, std::vector<std::shared_ptr<SharedFace>>>
        faces;  // by the object beyond
    std::size_t drawn_again = 0;

private:
    std::optional<whole::DecidedDiagram> decided_;  // where the box repeats
    std::vector<bool> has_come_;
    std::uint32_t passed_ = 0;
    SharedId next_ = 0;
};

// ---- One cell ----------------------------------------------------------------------------------------

class ConformingMeshes::Fitter {
public:
    Fitter(Store& store, std::uint32_t object, const Cell& cell)
        : store_(store),
          own_{Site::object(object), unmoved},
          cell_(cell),
          lines_(cell.edges.size()),
          faces_(cell.faces.size()) {
        constexpr double of_cell = 0.002, of_own = 0.005;
        options_.chord = of_cell * cell_diagonal(cell);
        options_.closed = true;
        options_.most_of_own = of_own;
    }

    CellMesh mesh() {
        for (const CellVertex& v : cell_.vertices) find_or_add(v);
        for (std::size_t e = 0; e < cell_.edges.size(); ++e) find_line(e);
        for (std::size_t f = 0; f < cell_.faces.size(); ++f) find_face(f);
        CellMesh mesh = drawn();
        // A cell that touches images of itself has edges and faces that are images of others of its own: what
        // it has drawn it takes over like what others have.
        if (keep_lines(mesh)) mesh = drawn();
        if (keep_faces(mesh)) mesh = drawn();
        for (std::size_t f = 0; f < cell_.faces.size(); ++f) {
            const NetworkSite beyond = site_of(cell_.faces[f].site);
            if (!faces_[f].first && beyond.site.is_object() && store_.has_come(beyond.site.index))
                ++store_.drawn_again;
        }
        for (CellMesh::Group& group : mesh.groups)
            if (group.kind == CellMesh::Group::Kind::Face) group.site = site_of(group.site).site;
        return mesh;
    }

private:
    // ---- Sites

    // Where a tube ends at a side of the box, other cells have that.
    NetworkSite site_of(const Site& site) const {
        return site_in_diagram(cell_, side_at_end(cell_.scene, site));
    }
    template <class Sites>
    MeetingSites meeting(const Sites& sites) {
        MeetingSites result{own_};
        for (const Site& s : sites) result.push_back(site_of(s));
        std::ranges::sort(result);
        return result;
    }
    MeetingSites meeting(const CellEdge& e) {
        std::vector<Site> sites(e.sites.begin(), e.sites.end());
        sites.insert(sites.end(), e.extra_sites.begin(), e.extra_sites.end());
        MeetingSites result = meeting(sites);
        result.erase(std::ranges::unique(result).begin(), result.end());
        return result;
    }
    // Do other cells have it, too?
    bool is_shared(const MeetingSites& sites) const {
        return std::ranges::any_of(sites,
                                   [&](const NetworkSite& s) { return s.site.is_object() && s != own_; });
    }
    // What is stored with one of the sites, and by how much it is to be moved.
    template <class T, class Visit>
    void for_stored(const Lists<T>& lists, const MeetingSites& sites, Visit&& visit) const {
        for (const NetworkSite& s : sites) {
            if (!s.site.is_object()) continue;
            const auto list = lists.find(s.site.index);
            if (list == lists.end()) continue;
            for (const T& listed : list->second) visit(listed, sum(s.image, opposite(listed.image)));
        }
    }

    // ---- Vertices

    // Three sites have no more than two points in common, or a curve.
    static constexpr std::size_t tell_vertex = 3, tell_edge = 2;

    // A place that two cells have; touching vertices may lie anywhere along their bisectors.
    static bool are_apart(const CellVertex& own, const ListedVertex& listed, const Vec3& place) {
        const double rounding = 16 * std::numeric_limits<double>::epsilon() *
                                (own.point.cwiseAbs().sum() + place.cwiseAbs().sum());
        return !own.is_touching && (own.point - place).norm() > own.error + listed.error + rounding;
    }

    struct VertexMatch {
        std::size_t common = 0;
        double square = 0;
        std::shared_ptr<SharedVertex> vertex;
        Image by{0, 0, 0};
    };

    void try_vertex(const CellVertex& v, const MeetingSites& sites, const ListedVertex& listed,
                    const Image& by, VertexMatch& best) const {
        const Vec3 place = store_.place(listed.place, by);
        if (are_apart(v, listed, place)) return;
        const SharedVertex& stored = *listed.what;
        const SharedPoint point = stored.point.at(by);
        const std::size_t common = common_sites(stored.sites, by, sites);
        const bool is_same = common == sites.size() && common == stored.sites.size();
        if (common < tell_vertex || ((v.is_touching || stored.is_touching) && !is_same)) return;
        const double square = (place - v.point).squaredNorm();
        if (best.vertex && std::pair(best.common, -best.square) >= std::pair(common, -square)) return;
        if (std::ranges::any_of(vertices_, [&](const CellPoint& p) { return p.point.key() == point.key(); }))
            return;
        best = {common, square, listed.what, by};
    }

    void find_or_add(const CellVertex& v) {
        const MeetingSites sites = meeting(v.sites);
        VertexMatch best;
        const auto try_it = [&](const ListedVertex& listed, const Image& by) {
            try_vertex(v, sites, listed, by, best);
        };
        // Cells that list this one, too, have what is listed there.
        for_stored(store_.vertices, {own_}, try_it);
        if (!best.vertex || best.common < sites.size()) for_stored(store_.vertices, sites, try_it);
        if (!best.vertex) {
            const auto vertex = std::make_shared<SharedVertex>(
                SharedVertex{store_.new_point(v.point), sites, v.error, v.is_touching, {}});
            vertices_.push_back({vertex->point, vertex});
            if (is_shared(sites)) store_.list(store_.vertices, vertex);
            return;
        }
        vertices_.push_back({best.vertex->point.at(best.by), best.vertex});
        // What other cells had left out, as it owns nothing there.
        for (const NetworkSite& s : sites) {
            const NetworkSite there = moved(s, opposite(best.by));
            if (std::ranges::binary_search(best.vertex->sites, there)) continue;
            best.vertex->sites.insert(std::ranges::upper_bound(best.vertex->sites, there), there);
            if (there.site.is_object() && store_.may_come(there.site.index))
                store_.vertices[there.site.index].push_back({best.vertex, there.image});
        }
    }

    // ---- Edges

    struct LineMatch {
        double distance = std::numeric_limits<double>::infinity();
        std::shared_ptr<SharedLine> line;
        Image by{0, 0, 0};
    };

    // Two arcs of one curve may have the same ends: a point of the line tells which one it is.
    void try_line(const CellEdge& edge, const std::shared_ptr<SharedLine>& line, const Image& by,
                  LineMatch& best) const {
        if ((line == best.line && by == best.by) || is_taken(line->id, by)) return;
        constexpr double slack = 4, rounding = 0x1p-40;
        const Vec3 inner = inner_point(*line, by);
        const double allowed =
            slack * (edge.error + line->error) +
            rounding * (edge.curve.points.front().head<3>().cwiseAbs().sum() + inner.cwiseAbs().sum());
        const double distance = distance_from_curve(edge.curve, inner, allowed);
        if (distance <= allowed && distance < best.distance) best = {distance, line, by};
    }

    bool find_line(std::size_t e) {
        const CellEdge& edge = cell_.edges[e];
        LineMatch best;
        if (edge.vertices.empty()) {
            const MeetingSites sites = meeting(edge);
            for_stored(store_.closed_lines, sites, [&](const ListedLine& listed, const Image& by) {
                const MeetingSites& theirs = listed.what->sites;
                if (theirs.size() == sites.size() && common_sites(theirs, by, sites) == sites.size())
                    try_line(edge, listed.what, by, best);
            });
        } else {
            const CellPoint *from = &vertices_[edge.vertices[0]], *to = &vertices_[edge.vertices[1]];
            if (to->point.id < from->point.id) std::swap(from, to);
            std::optional<MeetingSites> sites;
            for (const auto& line : from->vertex->lines)
                for (const bool is_turned : {false, true}) {
                    const SharedPoint &begin = is_turned ? line->points.back() : line->points.front(),
                                      &end = is_turned ? line->points.front() : line->points.back();
                    if (begin.id != from->point.id || end.id != to->point.id) continue;
                    const Image by = sum(from->point.image, opposite(begin.image));
                    if (sum(end.image, by) != to->point.image) continue;
                    if (!sites) sites = meeting(edge);
                    if (common_sites(line->sites, by, *sites) >= tell_edge) try_line(edge, line, by, best);
                }
        }
        if (best.line) lines_[e] = as_line_of(edge, *best.line, best.by);
        return best.line != nullptr;
    }

    bool is_taken(SharedId line, const Image& image) const {
        return std::ranges::any_of(lines_,
                                   [&](const auto& l) { return l && l->id == line && l->image == image; });
    }

    Vec3 inner_point(const SharedLine& line, const Image& by) const {
        const auto at = [&](std::size_t i) { return store_.place(line.points[i].at(by)); };
        return line.points.size() == 2 ? Vec3(0.5 * (at(0) + at(1))) : at(line.points.size() / 2);
    }

    CellLine as_line_of(const CellEdge& edge, const SharedLine& line, const Image& by) const {
        CellLine result{line.id, by, false, {}};
        for (const SharedPoint& p : line.points) result.points.push_back(p.at(by));
        std::vector<SharedPoint>& points = result.points;
        const bool has_ends = !line.is_closed && points.front().key() != points.back().key();
        if (line.is_closed) {
            // It begins where this cell's curve begins.
            points.pop_back();
            const Vec3 begin = edge.curve.evaluate(edge.curve.domain_begin());
            const auto first = std::ranges::min_element(
                points, {}, [&](const SharedPoint& p) { return (store_.place(p) - begin).squaredNorm(); });
            std::ranges::rotate(points, first);
            points.push_back(points.front());
        }
        result.is_reversed = has_ends ? points.front().key() != vertices_[edge.vertices[0]].point.key()
                                      : runs_against(edge.curve, points);
        if (result.is_reversed) std::ranges::reverse(points);
        return result;
    }

    // A line that runs with the curve has two points of it in the curve's order.
    bool runs_against(const RationalCurve3& curve, const std::vector<SharedPoint>& points) const {
        const auto place_of = [&](double part) {
            const Vec3 p = curve.evaluate((1 - part) * curve.domain_begin() + part * curve.domain_end());
            return std::ranges::min_element(
                points, {}, [&](const SharedPoint& q) { return (store_.place(q) - p).squaredNorm(); });
        };
        constexpr double first = 0.375, second = 0.625;  // apart from the ends, which are one point
        return place_of(first) > place_of(second);
    }

    // Lines that were drawn are kept for others, but for those that are images of ones that were kept: was
    // there any?
    bool keep_lines(const CellMesh& mesh) {
        bool has_found = false;
        for (std::size_t e = 0; e < cell_.edges.size(); ++e) {
            if (lines_[e]) continue;
            if (store_.is_periodic() && find_line(e)) {
                has_found = true;
                continue;
            }
            const CellEdge& edge = cell_.edges[e];
            MeetingSites sites = meeting(edge);
            if (!is_shared(sites)) continue;
            CellLine& line = lines_[e].emplace(CellLine{store_.new_id(), unmoved, false, {}});
            for (const std::uint32_t p : mesh.edge_lines[e]) line.points.push_back(point_of(mesh, p));
            const bool is_closed = edge.vertices.empty();
            auto shared = std::make_shared<SharedLine>(
                SharedLine{line.id, line.points, std::move(sites), is_closed, edge.error});
            if (is_closed) {
                store_.list(store_.closed_lines, shared);
                continue;
            }
            const CellPoint &from = vertices_[edge.vertices[0]], &to = vertices_[edge.vertices[1]];
            (from.point.id <= to.point.id ? from : to).vertex->lines.push_back(std::move(shared));
        }
        return has_found;
    }

    // ---- Faces

    // None where one of its edges is not shared.
    std::optional<std::vector<BorderLine>> border(const CellFace& face) const {
        std::vector<BorderLine> result;
        for (const TrimmedPatch& patch : face.patches)
            for (const auto& loop : patch.loops)
                for (const TrimCurve& c : loop) {
                    if (!c.edge) continue;
                    const auto& line = lines_[*c.edge];
                    if (!line) return std::nullopt;
                    result.push_back({line->id, line->image, line->is_reversed != c.reversed});
                }
        std::ranges::sort(result);
        result.erase(std::ranges::unique(result).begin(), result.end());
        return result;
    }

    bool find_face(std::size_t f) {
        const NetworkSite& beyond = site_of(cell_.faces[f].site);
        const auto list = store_.faces.find(own_.site.index);
        if (!beyond.site.is_object() || list == store_.faces.end()) return false;
        const auto own = border(cell_.faces[f]);
        if (!own) return false;
        for (const std::shared_ptr<SharedFace>& face : list->second) {
            if (face->owner != beyond.site.index || moved(face->beyond, beyond.image) != own_) continue;
            std::vector<BorderLine> theirs = face->border;
            for (BorderLine& line : theirs)
                line = {line.line, sum(line.image, beyond.image), !line.is_reversed};
            std::ranges::sort(theirs);
            if (theirs != *own) continue;
            faces_[f] = {face, beyond.image};
            return true;
        }
        return false;
    }

    // As keep_lines().
    bool keep_faces(const CellMesh& mesh) {
        bool has_found = false;
        for (const CellMesh::Group& group : mesh.groups) {
            if (group.kind != CellMesh::Group::Kind::Face || faces_[group.face].first) continue;
            const NetworkSite& beyond = site_of(cell_.faces[group.face].site);
            if (!beyond.site.is_object()) continue;
            if (beyond.site == own_.site && find_face(group.face)) {
                has_found = true;
                continue;
            }
            if (store_.has_come(beyond.site.index) && beyond.site != own_.site) continue;
            if (!store_.may_come(beyond.site.index)) continue;
            auto border_lines = border(cell_.faces[group.face]);
            if (!border_lines) continue;
            const auto face = std::make_shared<SharedFace>();
            face->owner = own_.site.index;
            face->beyond = beyond;
            face->border = *std::move(border_lines);
            std::unordered_map<std::uint32_t, std::uint32_t> points, normals;
            const auto place_in = [](auto& places, std::uint32_t i, auto& all, auto&& make) {
                const auto [at, is_new] = places.try_emplace(i, static_cast<std::uint32_t>(all.size()));
                if (is_new) all.push_back(make());
                return at->second;
            };
            for (std::size_t t = group.begin; t < group.end; ++t) {
                Triangle corners, directions;
                for (std::size_t k = 0; k < 3; ++k) {
                    const std::uint32_t p = mesh.triangles[t][k], n = mesh.corner_normals[t][k];
                    corners[k] = place_in(points, p, face->points, [&] { return point_of(mesh, p); });
                    directions[k] = place_in(normals, n, face->normals, [&] { return mesh.normals[n]; });
                }
                face->triangles.push_back(corners);
                face->corner_normals.push_back(directions);
            }
            store_.faces[beyond.site.index].push_back(face);
            if (beyond.site == own_.site) faces_[group.face] = {face, std::nullopt};
        }
        return has_found;
    }

    // ---- The mesh with what is known

    // What a point of the mesh is: one that was known, or a new one.
    SharedPoint point_of(const CellMesh& mesh, std::uint32_t p) {
        points_.resize(std::max(points_.size(), mesh.points.size()));
        if (!points_[p]) points_[p] = store_.new_point(mesh.points[p]);
        return *points_[p];
    }

    CellMesh drawn() {
        KnownMesh known;
        points_.clear();
        std::unordered_map<std::pair<SharedId, Image>, std::uint32_t, HashPlace> places;
        const auto place_of = [&](const SharedPoint& p) {
            const auto [at, is_new] =
                places.try_emplace(p.key(), static_cast<std::uint32_t>(known.points.size()));
            if (is_new) {
                known.points.push_back(store_.place(p));
                points_.push_back(p);
            }
            return at->second;
        };
        for (const CellPoint& p : vertices_) place_of(p.point);
        known.lines.resize(lines_.size());
        for (std::size_t e = 0; e < lines_.size(); ++e)
            if (lines_[e])
                for (const SharedPoint& p : lines_[e]->points) known.lines[e].push_back(place_of(p));
        known.faces.resize(faces_.size());
        for (std::size_t f = 0; f < faces_.size(); ++f)
            if (faces_[f].first) known.faces[f] = known_face(*faces_[f].first, faces_[f].second, place_of);
        return tessellate(cell_, options_, known);
    }

    // Seen from the other side, or of none, the cell's own.
    template <class PlaceOf>
    static KnownMesh::Face known_face(const SharedFace& face, const std::optional<Image>& by,
                                      PlaceOf&& place_of) {
        KnownMesh::Face result;
        std::vector<std::uint32_t> places;
        for (const SharedPoint& p : face.points) places.push_back(place_of(p.at(by.value_or(unmoved))));
        const auto turned = [&](const Triangle& t) { return by ? Triangle{t[0], t[2], t[1]} : t; };
        for (const Triangle& t : face.triangles)
            result.triangles.push_back(turned({places[t[0]], places[t[1]], places[t[2]]}));
        for (const Triangle& t : face.corner_normals) result.corner_normals.push_back(turned(t));
        for (const Vec3& n : face.normals) result.normals.push_back(by ? Vec3(-n) : n);
        return result;
    }

    Store& store_;
    const NetworkSite own_;
    const Cell& cell_;
    MeshOptions options_;
    std::vector<CellPoint> vertices_;
    std::vector<std::optional<CellLine>> lines_;
    // A stored face, and by how much it is moved and turned around; none: it is as it was drawn.
    std::vector<std::pair<std::shared_ptr<SharedFace>, std::optional<Image>>> faces_;
    std::vector<std::optional<SharedPoint>> points_;  // of the mesh
};

ConformingMeshes::ConformingMeshes(const DiagramScene& scene) : store_(std::make_unique<Store>(scene)) {}
ConformingMeshes::~ConformingMeshes() = default;

CellMesh ConformingMeshes::add(std::uint32_t object, const Cell& cell) {
    store_->pass_to(object);
    CellMesh mesh = Fitter(*store_, object, cell).mesh();
    store_->has_drawn(object);
    return mesh;
}

std::size_t ConformingMeshes::drawn_again() const { return store_->drawn_again; }

}  // namespace vcell
