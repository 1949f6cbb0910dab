#include "conforming_meshes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "../../envelope/whole/cell_finder.hpp"
#include "known_mesh.hpp"
#include "lone_points.hpp"
#include "shared_finder.hpp"

namespace vcell {

namespace shared {

namespace {

constexpr std::uint32_t unplaced = UINT32_MAX;
constexpr double joined_most = 0x1p-16;  // of the box's diagonal, far less than a chord

/// Draws one cell with what is known of it, and keeps what others may have.
class Fitter : Finder {
public:
    /// mesh() throws TooFine for more than `most_triangles`; without a bound the cell's chord grows where it
    /// is far too fine.
    Fitter(Store& store, std::uint32_t object, const Cell& cell, const WholeElements& whole, double chord,
           std::optional<std::size_t> most_triangles)
        : Finder(store, object, cell, whole), keeps_chord_(most_triangles.has_value()) {
        constexpr double times_of_own = 2.5;
        if (most_triangles) options_.most_triangles = *most_triangles;
        options_.chord = chord * cell_diagonal(cell);
        options_.closed = true;
        options_.most_of_own = times_of_own * chord;
    }

    CellMesh mesh() {
        for (std::size_t e = 0; e < lines_.size(); ++e) find_line(e);
        for (std::size_t f = 0; f < faces_.size(); ++f) find_face(f);
        CellMesh mesh = drawn();
        // A cell that touches images of itself has edges and faces that are images of others of its own: what
        // it has drawn it takes over like what others have.
        if (keep_lines(mesh)) mesh = drawn();
        if (keep_faces(mesh)) mesh = drawn();
        for (std::size_t f = 0; f < faces_.size(); ++f) {
            const NetworkSite beyond = beyond_face(f);
            if (!faces_[f].first && beyond.site.is_object() && store_.has_come(beyond.site.index))
                ++store_.drawn_again;
        }
        for (CellMesh::Group& group : mesh.groups)
            if (group.kind == CellMesh::Group::Kind::Face) group.site = site_of(group.site).site;
        return mesh;
    }

private:
    using Places = std::unordered_map<std::pair<SharedId, Image>, std::uint32_t, HashPlace>;

    // ---- What others may have

    // Lines that were drawn are kept for others, but for those that are images of ones that were kept: was
    // there any?
    bool keep_lines(const CellMesh& mesh) {
        bool has_found = false;
        for (std::size_t e = 0; e < lines_.size(); ++e) {
            if (lines_[e]) continue;
            if (store_.is_periodic() && find_line(e)) {
                has_found = true;
                continue;
            }
            const WholeEdge& edge = whole_.edges[e];
            MeetingSites sites = meeting(edge);
            if (!is_shared(sites)) continue;
            CellLine& line = lines_[e].emplace(CellLine{store_.new_id(), unmoved, false, {}});
            for (const WholeEdge::Piece& piece : edge.pieces) {
                std::vector<std::uint32_t> points = mesh.edge_lines[piece.edge];
                if (piece.reversed) std::ranges::reverse(points);
                for (std::size_t k = line.points.empty() ? 0 : 1; k < points.size(); ++k)
                    line.points.push_back(point_of(mesh, points[k]));
            }
            const bool is_closed = !edge.vertices;
            auto shared =
                std::make_shared<SharedLine>(SharedLine{line.id, line.points, whole_.point(edge, 0.5),
                                                        std::move(sites), is_closed, whole_.error(edge)});
            if (is_closed) {
                store_.add(shared);
                continue;
            }
            const CellPoint &from = *vertices_[(*edge.vertices)[0]], &to = *vertices_[(*edge.vertices)[1]];
            store_.add_line((from.point.id <= to.point.id ? from : to).vertex, std::move(shared));
        }
        return has_found;
    }

    // As keep_lines().
    bool keep_faces(const CellMesh& mesh) {
        bool has_found = false;
        for (std::size_t f = 0; f < faces_.size(); ++f) {
            if (faces_[f].first) continue;
            const NetworkSite beyond = beyond_face(f);
            if (!beyond.site.is_object()) continue;
            if (beyond.site == own_.site && find_face(f)) {
                has_found = true;
                continue;
            }
            if (store_.has_come(beyond.site.index) && beyond.site != own_.site) continue;
            if (!store_.may_come(beyond.site.index)) continue;
            auto border_lines = border(f);
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
            for (const CellMesh::Group& group : mesh.groups) {
                if (group.kind != CellMesh::Group::Kind::Face || whole_.whole_face(group.face) != f) continue;
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
            }
            face->across = sides_across(face->triangles, face->points.size());
            store_.add(face);
            if (beyond.site == own_.site) faces_[f] = {face, std::nullopt};
        }
        return has_found;
    }

    // SharedFace::across.
    static std::vector<MeshSide> sides_across(const std::vector<Triangle>& triangles,
                                              std::size_t point_count) {
        std::vector<MeshSide> sides;
        for (const Triangle& t : triangles)
            for (std::size_t k = 0; k < 3; ++k) {
                const auto [p, q] = std::minmax(t[k], t[(k + 1) % 3]);
                sides.push_back({p, q});
            }
        std::ranges::sort(sides);
        std::vector<bool> is_of_line(point_count, false);
        std::vector<MeshSide> inside;
        for (std::size_t i = 0; i < sides.size(); ++i)
            if (i + 1 < sides.size() && sides[i + 1] == sides[i])
                inside.push_back(sides[i++]);
            else
                is_of_line[sides[i][0]] = is_of_line[sides[i][1]] = true;
        std::erase_if(inside, [&](const MeshSide& s) { return !is_of_line[s[0]] || !is_of_line[s[1]]; });
        return inside;
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
        Places places;
        const auto place_of = [&](const SharedPoint& p) {
            const auto [at, is_new] =
                places.try_emplace(p.key(), static_cast<std::uint32_t>(known.points.size()));
            if (is_new) {
                known.points.push_back(store_.place(p));
                points_.push_back(p);
            }
            return at->second;
        };
        for (const auto& p : vertices_) known.vertices.push_back(p ? place_of(p->point) : unplaced);
        known.lines.resize(cell_.edges.size());
        for (std::size_t e = 0; e < lines_.size(); ++e) {
            if (!lines_[e]) continue;
            std::vector<std::uint32_t> line;
            for (const SharedPoint& p : lines_[e]->points) line.push_back(place_of(p));
            whole_.divide(whole_.edges[e], line, known);
        }
        for (std::size_t v = 0; v < vertices_.size(); ++v) {
            if (known.vertices[v] != unplaced) continue;
            known.vertices[v] = static_cast<std::uint32_t>(known.points.size());
            known.points.push_back(cell_.vertices[v].point);
            points_.emplace_back();
        }
        known.faces.resize(cell_.faces.size());
        for (std::size_t f = 0; f < faces_.size(); ++f)
            if (const auto& [face, by] = faces_[f]; face)
                for (const std::uint32_t piece : whole_.faces[f])
                    known.faces[piece] = piece == whole_.faces[f].front() ? known_face(*face, by, place_of)
                                                                          : KnownMesh::Face();
        find_taken(known, places);
        find_breaks(known);
        return keeps_chord_ ? tessellate_with_chord(cell_, options_, known)
                            : tessellate(cell_, options_, known);
    }

    // The cell beyond a face takes over others, too, which have points in common with it: two sides that join
    // the same of these, one in each face, would be one side of that cell's mesh.
    void find_taken(KnownMesh& known, const Places& places) const {
        known.taken.resize(cell_.faces.size());
        for (std::size_t f = 0; f < faces_.size(); ++f) {
            const NetworkSite beyond = beyond_face(f);
            if (faces_[f].first || !beyond.site.is_object()) continue;
            const auto list = store_.faces.find(beyond.site.index);
            if (list == store_.faces.end()) continue;
            std::vector<MeshSide> taken;
            for (const std::shared_ptr<SharedFace>& face : list->second) {
                if (face->owner == own_.site.index) continue;  // as drawn before: it is drawn so again
                const Image by = sum(beyond.image, opposite(face->beyond.image));
                for (const MeshSide& side : face->across) {
                    const auto from = places.find(face->points[side[0]].at(by).key()),
                               to = places.find(face->points[side[1]].at(by).key());
                    if (from == places.end() || to == places.end()) continue;
                    const auto [p, q] = std::minmax(from->second, to->second);
                    taken.push_back({p, q});
                }
            }
            std::ranges::sort(taken);
            for (const std::uint32_t piece : whole_.faces[f]) known.taken[piece] = taken;
        }
    }

    // Cells of tubes whose parts end in other cells' edges have points there.
    void find_breaks(KnownMesh& known) const {
        if (!store_.has_part_ends()) return;
        known.breaks.resize(cell_.edges.size());
        for (std::size_t e = 0; e < cell_.edges.size(); ++e) {
            if (!known.lines[e].empty()) continue;
            for (const Site& site : cell_.edges[e].sites)
                if (const Site beyond = site_of(site).site; beyond.is_object() && beyond != own_.site)
                    for (const Plane& end : store_.part_ends(beyond.index))
                        add_crossings(cell_.edges[e].curve, end, known.breaks[e]);
        }
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

    MeshOptions options_;
    const bool keeps_chord_;
    std::vector<std::optional<SharedPoint>> points_;  // of the mesh
};

CellMesh draw(Store& store, std::uint32_t object, const Cell& cell, double chord,
              std::optional<std::size_t> most_triangles) {
    store.begin(object);
    const auto mesh = [&](const Cell& of, const WholeElements& whole) {
        return Fitter(store, object, of, whole, chord, most_triangles).mesh();
    };
    CellMesh result;
    if (cell.parts.empty()) {
        result = mesh(cell, WholeElements(cell));
    } else {
        const JoinedParts joined = joined_parts(cell, joined_most);
        result = mesh(joined.cell, WholeElements(joined));
        drop_lone_points(result);
    }
    store.has_drawn(object);
    return result;
}

}  // namespace

}  // namespace shared

namespace {

// number(i) is what the diagram calls the scene's object i; the box's lattice is asked for where it repeats.
template <class Number, class LatticeOf>
std::unique_ptr<shared::Store> store_of(const DiagramScene& scene, std::size_t objects, const Number& number,
                                        const LatticeOf& lattice_of) {
    std::optional<whole::Lattice> lattice;
    if (scene.is_periodic()) lattice.emplace(lattice_of());
    std::unordered_map<std::uint32_t, std::vector<Plane>> ends;
    for (std::uint32_t i = 0; i < scene.objects.size(); ++i)
        if (auto planes = part_ends(scene.objects[i], scene.box); !planes.empty())
            ends[number(i)] = std::move(planes);
    return std::make_unique<shared::Store>(std::move(lattice), std::move(ends), objects);
}

}  // namespace

// ---- All cells in a row

ConformingMeshes::ConformingMeshes(const DiagramScene& scene, double chord)
    : store_(store_of(
          scene, scene.objects.size(), [](std::uint32_t i) { return i; },
          [&] { return whole::DecidedDiagram(scene).balls().lattice(); })),
      chord_(chord) {}
ConformingMeshes::~ConformingMeshes() = default;

CellMesh ConformingMeshes::draw(std::uint32_t object, const Cell& cell,
                                std::optional<std::size_t> most_triangles) {
    for (; passed_ < object; ++passed_) store_->forget(passed_);
    return shared::draw(*store_, object, cell, chord_, most_triangles);
}

CellMesh ConformingMeshes::add(std::uint32_t object, const Cell& cell) {
    return draw(object, cell, std::nullopt);
}

std::optional<CellMesh> ConformingMeshes::add_within(std::uint32_t object, const Cell& cell,
                                                     std::size_t most_triangles) {
    try {
        return draw(object, cell, most_triangles);
    } catch (const TooFine&) {
        return std::nullopt;
    }
}

std::size_t ConformingMeshes::drawn_again() const { return store_->drawn_again; }

// ---- Cells here and there

ScatteredMeshes::ScatteredMeshes(const whole::DecidedDiagram& decided, std::size_t objects, double chord)
    : store_(store_of(
          decided.scene(), objects, [&](std::uint32_t i) { return decided.number(i); },
          [&] { return decided.balls().lattice(); })),
      chord_(chord) {
    store_->note_additions();
}
ScatteredMeshes::~ScatteredMeshes() = default;

std::vector<CellMesh> ScatteredMeshes::add(std::uint32_t object, std::span<const Cell> cells) {
    std::vector<CellMesh> meshes;
    for (const Cell& cell : cells)
        meshes.push_back(shared::draw(*store_, object, cell, chord_, std::nullopt));
    store_->forget(object);
    return meshes;
}

shared::Additions ScatteredMeshes::take_additions() { return store_->take_additions(); }

void ScatteredMeshes::learn(const shared::Additions& additions) {
    store_->learn(additions);
    store_->forget(additions.object);
}

std::vector<std::uint32_t> objects_met(const Cell& cell) {
    std::vector<std::uint32_t> objects;
    const auto add = [&](const auto& sites) {
        for (const Site& s : sites)
            if (const Site met = shared::site_of(cell, s).site; met.is_object()) objects.push_back(met.index);
    };
    for (const CellVertex& v : cell.vertices) add(v.sites);
    for (const CellEdge& e : cell.edges) {
        add(e.sites);
        add(e.extra_sites);
    }
    for (const CellFace& f : cell.faces) add(std::array{f.site});
    std::ranges::sort(objects);
    objects.erase(std::ranges::unique(objects).begin(), objects.end());
    return objects;
}

}  // namespace vcell
