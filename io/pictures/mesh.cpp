#include "mesh.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include "../solids/joined_parts.hpp"
#include "../solids/shell.hpp"
#include "folds.hpp"
#include "known_mesh.hpp"
#include "line_sampling.hpp"
#include "lone_points.hpp"
#include "mesh_shape.hpp"
#include "polygons.hpp"

namespace vcell {

namespace {

// What of a face lies along no edge: seams, which show how far one reaches that has next to no edges, and
// tips.
void extend_by_seams(Eigen::AlignedBox3d& box, const CellFace& face) {
    constexpr int pieces = 16;
    for (const TrimmedPatch& patch : face.patches)
        for (const auto& loop : patch.loops)
            for (const TrimCurve& c : loop)
                for (int i = 0; i <= pieces && !c.edge; ++i) {
                    const double begin = c.curve.domain_begin(), end = c.curve.domain_end();
                    const Vec2 uv = c.curve.evaluate(begin + (end - begin) * i / pieces);
                    box.extend(patch.surface.evaluate(uv.x(), uv.y()));
                }
}

// A chord is no longer than that part of what its edge or face measures itself, which may be far below the
// cell's; but no shorter than the rounding of its coordinates, beneath which halving finds nothing straight.
Chords chords_of(const Shell& shell, double most, double of_own) {
    Chords chords{most, std::vector<double>(shell.edges.size(), most),
                  std::vector<double>(shell.faces.size(), most)};
    if (std::isinf(of_own)) return chords;
    const auto within = [&](const Eigen::AlignedBox3d& box) {
        constexpr double rounding = 0x1p-44;
        const double size = box.min().cwiseAbs().cwiseMax(box.max().cwiseAbs()).maxCoeff();
        return std::min(most, std::max(of_own * box.diagonal().norm(), rounding * size));
    };
    std::vector<Eigen::AlignedBox3d> boxes(shell.edges.size());
    for (std::size_t e = 0; e < shell.edges.size(); ++e) {
        const RationalCurve3& curve = shell.edges[e].curve;
        constexpr int pieces = 4;
        for (int i = 0; i <= pieces; ++i)
            boxes[e].extend(curve.evaluate(curve.domain_begin() +
                                           (curve.domain_end() - curve.domain_begin()) * i / pieces));
        chords.of_edges[e] = within(boxes[e]);
    }
    for (std::size_t f = 0; f < shell.faces.size(); ++f) {
        Eigen::AlignedBox3d box;
        for (const TrimCurve& c : shell.faces[f].trims())
            if (c.edge) box.extend(boxes[*c.edge]);
        extend_by_seams(box, shell.faces[f]);
        if (!box.isEmpty()) chords.of_faces[f] = within(box);
    }
    return chords;
}

// A triangle with a side that is one point has no extent.
bool is_side_at_tip(const Triangle& v, const std::vector<std::uint32_t>& point) {
    return point[v[0]] == point[v[1]] || point[v[1]] == point[v[2]] || point[v[2]] == point[v[0]];
}

class Tessellator {
public:
    /// mesh() throws TooFine when it has more than `most_triangles`, and if `keeps_chord` where 4096 pieces
    /// of a line are not enough.
    Tessellator(const Shell& shell, const Cell& cell, const KnownMesh& known, const Chords& chords,
                bool keeps_chord, std::size_t most_triangles)
        : shell_(shell),
          cell_(cell),
          known_(known),
          chords_(chords),
          most_triangles_(most_triangles),
          lines_(shell, cell, known, chords, keeps_chord, most_triangles) {}

    CellMesh mesh() {
        std::vector<Vec3> points = lines_.sample();
        const std::size_t count = points.size();
        draw(std::move(points));
        if (folded_ > 0) halve_lines_at_folds(count);
        separate_sides(mesh_, drawn_);
        check_size();
        mesh_.chord = chords_.most;
        return std::move(mesh_);
    }

private:
    void draw(std::vector<Vec3> points) {
        mesh_ = {};
        mesh_.points = std::move(points);
        drawn_.clear();
        folded_ = 0;
        at_folds_.clear();
        for (std::uint32_t f = 0; f < shell_.faces.size(); ++f) {
            const std::size_t begin = mesh_.triangles.size();
            if (const auto* face = known_.face(f))
                add_known_face(*face);
            else
                for (const TrimmedPatch& patch : shell_.faces[f].patches) {
                    const std::size_t before = mesh_.triangles.size();
                    drawn_.push_back({before,
                                      before,
                                      &patch.surface,
                                      {},
                                      static_cast<std::uint32_t>(mesh_.normals.size()),
                                      known_.taken_of(f)});
                    add_patch(patch, chords_.of_faces[f]);
                    drawn_.back().end = mesh_.triangles.size();
                    check_size();
                }
            add_group(f, begin);
        }
        for (std::size_t e = 0; e < cell_.edges.size(); ++e)
            mesh_.edge_lines.push_back(lines_.points_along(e));
    }
    // Where triangles at a line are turned over, its pieces are longer than the surface is straight beside
    // it: these are halved, and of what was drawn meanwhile the mesh stays that has least of them.
    // Where folds are few so are the points that unfold them; a sliver that is thinner than any chord takes
    // them without end.
    void halve_lines_at_folds(std::size_t count) {
        constexpr int most_rounds = 8;
        constexpr std::size_t most_growth = 4;
        CellMesh best = mesh_;
        auto drawn_of_best = drawn_;
        double least = folded_;
        try {
            for (int i = 0; i < most_rounds && folded_ > 0; ++i) {
                std::optional<std::vector<Vec3>> points = lines_.sample_halving(at_folds_);
                if (!points || points->size() > most_growth * count) break;
                draw(*std::move(points));
                if (!(folded_ < least)) continue;
                best = mesh_;
                drawn_of_best = drawn_;
                least = folded_;
            }
        } catch (const TooFine&) {
            // The best so far was not.
        }
        mesh_ = std::move(best);
        drawn_ = std::move(drawn_of_best);
    }
    // What closes the shell comes after the cell's faces: walls and ends together, the base in the end.
    void add_group(std::uint32_t f, std::size_t begin) {
        using Kind = CellMesh::Group::Kind;
        const Kind kind = f < cell_.faces.size()                 ? Kind::Face
                          : shell_.faces[f].site == Site::base() ? Kind::Base
                                                                 : Kind::Walls;
        if (kind != Kind::Face && !mesh_.groups.empty() && mesh_.groups.back().kind == kind)
            mesh_.groups.back().end = mesh_.triangles.size();
        else
            mesh_.groups.push_back({kind, kind == Kind::Face ? f : UINT32_MAX, begin, mesh_.triangles.size(),
                                    shell_.faces[f].site});
    }

    void check_size() const {
        if (mesh_.triangles.size() > most_triangles_) throw TooFine();
    }

    void add_known_face(const KnownMesh::Face& face) {
        const auto before = static_cast<std::uint32_t>(mesh_.normals.size());
        mesh_.triangles.insert(mesh_.triangles.end(), face.triangles.begin(), face.triangles.end());
        mesh_.normals.insert(mesh_.normals.end(), face.normals.begin(), face.normals.end());
        for (const Triangle& n : face.corner_normals)
            mesh_.corner_normals.push_back({before + n[0], before + n[1], before + n[2]});
    }

    std::uint32_t add_point(const Vec3& p) {
        mesh_.points.push_back(p);
        return static_cast<std::uint32_t>(mesh_.points.size() - 1);
    }

    std::vector<Vec3> places_of(const std::vector<std::uint32_t>& points) const {
        std::vector<Vec3> places;
        for (const std::uint32_t p : points) places.push_back(mesh_.points[p]);
        return places;
    }

    // How far points of the polygons may be off the patch: by the errors of their lines, and rounding.
    double doubt_at(const std::vector<std::vector<LoopPoint>>& loops) const {
        double error = 0, size = 0;
        for (const auto& loop : loops)
            for (const LoopPoint& p : loop) {
                if (p.line < shell_.edges.size()) error = std::max(error, shell_.edges[p.line].error);
                size = std::max(size, mesh_.points[p.point].cwiseAbs().maxCoeff());
            }
        constexpr double rounding = 0x1p-44;
        return 2 * error + rounding * size;
    }
    // The sides at these points, counted loop by loop, are too long.
    void keep_folds(const std::vector<std::vector<LoopPoint>>& loops,
                    const std::vector<std::uint32_t>& points) {
        for (std::size_t i : points) {
            auto loop = loops.begin();
            for (; i >= loop->size(); ++loop) i -= loop->size();
            for (const LoopPoint& p : {(*loop)[i], (*loop)[(i + loop->size() - 1) % loop->size()]})
                at_folds_.push_back({p.line, p.piece});
        }
    }

    void add_patch(const TrimmedPatch& patch, double chord) {
        const RationalPatch& s = patch.surface;
        const std::vector<std::vector<LoopPoint>> loops = lines_.polygons(patch);
        if (loops.empty()) return;
        std::vector<std::vector<Vec2>> uv;
        std::vector<std::uint32_t> point;
        for (const auto& loop : loops) {
            uv.emplace_back();
            for (const LoopPoint& p : loop) {
                uv.back().push_back(p.uv);
                point.push_back(p.point);
            }
        }
        // Each point inside makes two triangles: when this bound ends it, there are more than are left.
        const std::size_t left = most_triangles_ - std::min(most_triangles_, mesh_.triangles.size());
        const Eigen::Matrix2d rounded = rounding_map(s, uv), back = rounded.inverse();
        for (auto& loop : uv)
            for (Vec2& p : loop) p = rounded * p;
        Triangulation t = triangulate(
            uv, [&](const Vec2& a, const Vec2& b) { return deviation(s, back * a, back * b) > chord; },
            point.size() + left / 2 + 1);
        for (Vec2& p : t.points) p = back * p;
        const PlacedPoints placed = place_without_folds(s, places_of(point), doubt_at(loops), t);
        folded_ += placed.folded;
        keep_folds(loops, placed.at_folds);
        const auto first_normal = static_cast<std::uint32_t>(mesh_.normals.size());
        const bool has_tip = std::ranges::any_of(
            patch.loops, [](const auto& loop) { return std::ranges::any_of(loop, &TrimCurve::is_tip); });
        for (std::size_t i = point.size(); i < placed.places.size(); ++i)
            point.push_back(add_point(placed.places[i]));
        mesh_.normals.insert(mesh_.normals.end(), placed.normals.begin(), placed.normals.end());
        for (const Triangle& v : t.triangles) {
            if (has_tip && is_side_at_tip(v, point)) continue;
            mesh_.triangles.push_back({point[v[0]], point[v[1]], point[v[2]]});
            mesh_.corner_normals.push_back({first_normal + v[0], first_normal + v[1], first_normal + v[2]});
        }
        drawn_.back().parameters = std::move(t.points);
    }

    const Shell& shell_;
    const Cell& cell_;
    const KnownMesh& known_;
    const Chords& chords_;
    std::size_t most_triangles_;
    LineSampling lines_;
    CellMesh mesh_;
    std::vector<DrawnPatch> drawn_;
    double folded_ = 0;                          // the area of triangles turned over
    std::vector<LineSampling::Piece> at_folds_;  // of lines at these
};

/// Meshes of one cell with one chord or another.
class Attempts {
public:
    Attempts(const Cell& cell, const MeshOptions& options, const KnownMesh& known)
        : cell_(cell),
          options_(options),
          known_(known),
          shell_(options.closed ? closed_shell(cell) : Shell{cell.vertices, cell.edges, cell.faces, 0}),
          diagonal_(cell_diagonal(cell)) {}

    double coarsest() const { return diagonal_; }
    double default_chord() const { return 1e-3 * diagonal_; }
    double wanted() const { return options_.chord.value_or(default_chord()); }

    // The mesh that has no triangles for a chord's sake.
    CellMesh coarsest_mesh(double chord) const {
        CellMesh result = mesh(chord, SIZE_MAX);
        if (options_.most_triangles && result.triangles.size() > *options_.most_triangles)
            throw TooManyTriangles(*options_.most_triangles, result.triangles.size());
        return result;
    }
    // Throws TooFine. At chords of pictures' size lines may stop being halved where their parameter stands
    // all but still.
    CellMesh mesh(double chord, std::size_t most_triangles) const {
        return Tessellator(shell_, cell_, known_, chords_of(shell_, chord, options_.most_of_own),
                           chord < 0.5 * default_chord(), most_triangles)
            .mesh();
    }
    std::optional<CellMesh> mesh_if_it_fits(double chord) const {
        try {
            return mesh(chord, options_.most_triangles.value_or(MeshOptions::usually_most));
        } catch (const TooFine&) {
            return std::nullopt;
        }
    }

private:
    const Cell& cell_;
    const MeshOptions& options_;
    const KnownMesh& known_;
    const Shell shell_;
    const double diagonal_;
};

}  // namespace

TooManyTriangles::TooManyTriangles(std::size_t most, std::size_t there_are)
    : std::invalid_argument(
          fmt::format("the coarsest mesh has {} triangles, not {} at most", there_are, most)) {}

double cell_diagonal(const Cell& cell) {
    Eigen::AlignedBox3d box;
    for (const CellVertex& v : cell.vertices) box.extend(v.point);
    for (const CellEdge& e : cell.edges) {
        constexpr int pieces = 16;
        const double begin = e.curve.domain_begin(), end = e.curve.domain_end();
        // An edge lies among its control points.
        const auto is_inside = [&](const Eigen::Vector4d& p) { return box.contains(p.head<3>()); };
        if (std::ranges::all_of(e.curve.points, is_inside)) continue;
        for (int i = 0; i <= pieces; ++i) box.extend(e.curve.evaluate(begin + (end - begin) * i / pieces));
    }
    for (const CellFace& face : cell.faces) extend_by_seams(box, face);
    // Edges over the rim show how far a plane's region or a cylinder's stretch goes.
    if (const auto* sphere = std::get_if<Sphere>(&cell.scene.base)) {
        box.extend(sphere->center - Vec3::Constant(sphere->radius));
        box.extend(sphere->center + Vec3::Constant(sphere->radius));
    }
    return box.isEmpty() ? 0 : box.diagonal().norm();
}

CellMesh tessellate(const Cell& cell, const MeshOptions& options) {
    if (cell.parts.empty()) return tessellate(cell, options, {});
    const JoinedParts joined = joined_parts(cell);
    CellMesh mesh = tessellate(joined.cell, options, {});
    for (std::size_t e = 0; e < mesh.edge_lines.size(); ++e)
        if (joined.is_joint[e]) mesh.edge_lines[e].clear();
    drop_lone_points(mesh);
    return mesh;
}

CellMesh tessellate(const Cell& cell, const MeshOptions& options, const KnownMesh& known) {
    const Attempts attempts(cell, options, known);
    const double wanted = attempts.wanted();
    if (auto mesh = attempts.mesh_if_it_fits(wanted)) return std::move(*mesh);
    // A mesh of the default chord is small, so the finest one that is not too fine is looked for from there
    // on.
    double chord = std::max(wanted, attempts.default_chord());
    std::optional<CellMesh> best = attempts.mesh_if_it_fits(chord);
    while (!best && chord <= attempts.coarsest()) best = attempts.mesh_if_it_fits(chord *= chord_step);
    if (!best) return attempts.coarsest_mesh(chord);
    for (;;) {
        chord = best->chord / chord_step;
        std::optional<CellMesh> finer = chord > wanted ? attempts.mesh_if_it_fits(chord) : std::nullopt;
        if (!finer) return std::move(*best);
        best = std::move(finer);
    }
}

CellMesh tessellate_with_chord(const Cell& cell, const MeshOptions& options, const KnownMesh& known) {
    const Attempts attempts(cell, options, known);
    return attempts.mesh(attempts.wanted(), options.most_triangles.value());
}

}  // namespace vcell
