/// The lines of a cell's mesh: its edges, and seams and tips of its patches, each sampled once for all faces
/// that it bounds, so finely that chords are kept and no two sides of a face cross.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "../../core/errors.hpp"
#include "../solids/shell.hpp"
#include "known_mesh.hpp"
#include "mesh_shape.hpp"
#include "polygons.hpp"
#include "sampled_line.hpp"
#include "trims.hpp"

namespace vcell {

/// By how much triangles may be off: nothing by more than `most`.
struct Chords {
    double most;
    std::vector<double> of_edges, of_faces;  // of the shell
};

class LineSampling {
public:
    /// Throws TooFine when there are more than `most_points`, and if `keeps_chord` where 4096 pieces of a
    /// line are not enough. Keeps references.
    LineSampling(const Shell& shell, const Cell& cell, const KnownMesh& known, const Chords& chords,
                 bool keeps_chord, std::size_t most_points)
        : shell_(shell),
          cell_(cell),
          known_(known),
          chords_(chords),
          keeps_chord_(keeps_chord),
          most_points_(most_points),
          lines_(shell.edges.size()) {
        for (std::size_t e = 0; e < shell.edges.size(); ++e) {
            const RationalCurve3& curve = shell.edges[e].curve;
            if (e < known.breaks.size()) lines_[e].breaks = known.breaks[e];
            lines_[e].breaks.insert(lines_[e].breaks.end(), {curve.domain_begin(), curve.domain_end()});
            lines_[e].chord = chords.of_edges[e];
        }
        for_each_curve([&](const TrimCurve& c, const RationalPatch& s, double chord, bool is_loop) {
            if (c.is_tip()) {
                tips_.emplace(&c, static_cast<std::uint32_t>(lines_.size()));
                lines_.push_back({{}, {c.curve.domain_begin(), c.curve.domain_end()}, around_tip, chord});
                return;
            }
            if (c.seam) {
                const auto [at, is_new] =
                    seams_.try_emplace(*c.seam, static_cast<std::uint32_t>(lines_.size()));
                if (is_new)
                    lines_.push_back({{},
                                      {c.curve.domain_begin(), c.curve.domain_end()},
                                      is_loop ? least_around : 1,
                                      chord});
            }
            Line& line = lines_[line_of(c)];
            line.uses.push_back({&c, &s, chord});
            for (const double t : {c.curve.domain_begin(), c.curve.domain_end()})
                line.breaks.push_back(line_parameter(c, t));
        });
        for (Line& line : lines_) settle_breaks(line.breaks);
    }

    /// A piece of a line as it was sampled.
    using Piece = std::pair<std::uint32_t, std::uint32_t>;

    /// The mesh's points along all lines.
    std::vector<Vec3> sample() {
        set_first_pieces();
        sampled_.resize(lines_.size());
        for (std::size_t e = 0; e < shell_.edges.size(); ++e)
            if (is_known(e)) sample_known_line(e);
        sample_lines();
        // Chords of a coarse polyline may cross those of its neighbour where the true arcs do not.
        constexpr int rounds = 8;
        for (int i = 0; i < rounds && refine_crossing_lines(); ++i) sample_lines();
        return std::move(points_);
    }
    /// Samples once more, with these pieces halved, as far as they are not known. None if no piece was.
    std::optional<std::vector<Vec3>> sample_halving(std::vector<Piece> pieces) {
        std::erase_if(pieces, [&](const Piece& p) { return is_known(p.first) || is_tip(p.first); });
        if (pieces.empty()) return std::nullopt;
        // The last ones of a line first, so that the numbers of the others stay.
        std::ranges::sort(pieces, std::greater());
        pieces.erase(std::ranges::unique(pieces).begin(), pieces.end());
        for (const auto& [line, piece] : pieces) {
            std::vector<double>& t = sampled_[line].parameters;
            t.insert(t.begin() + piece + 1, 0.5 * (t[piece] + t[piece + 1]));
        }
        sample_lines();
        return std::move(points_);
    }
    /// A shell's edge as a polyline of these points.
    const std::vector<std::uint32_t>& points_along(std::size_t edge) const {
        return is_known(edge) ? known_.lines[edge] : sampled_[edge].points;
    }
    /// The patch's loops, as far as they enclose anything.
    std::vector<std::vector<LoopPoint>> polygons(const TrimmedPatch& patch) const {
        std::vector<std::vector<LoopPoint>> result;
        for (const auto& loop : patch.loops) {
            result.push_back(polygon(loop));
            // Two straight edges between the same ends enclose nothing.
            if (result.back().size() < 3) result.pop_back();
        }
        return result;
    }

private:
    /// A trimming curve, its patch, and the face's chord.
    struct Use {
        const TrimCurve* curve;
        const RationalPatch* patch;
        double chord;
    };
    /// A cell edge (those come first), a seam, or what of a patch's boundary is one point, a tip.
    struct Line {
        std::vector<Use> uses;
        std::vector<double> breaks;  // where trimming curves begin and end: points of every polyline
        std::size_t pieces = 1;      // between its ends, before halving
        double chord = 0;
    };

    // Pieces that a loop has at least: enough for a polygon, whatever the chord.
    static constexpr std::size_t least_around = 8;
    // Into so many parts each of a tip's sides is divided in the parameters.
    static constexpr std::size_t around_tip = 4;

    bool is_tip(std::size_t line) const { return line >= shell_.edges.size() && lines_[line].uses.empty(); }
    bool is_known(std::size_t line) const {
        return line < known_.lines.size() && !known_.lines[line].empty();
    }
    // The feet of what closes the cell come after all that is known.
    std::uint32_t point_of(std::uint32_t vertex) const {
        const std::size_t own = cell_.vertices.size();
        if (vertex < own) return known_.vertices.empty() ? vertex : known_.vertices[vertex];
        return known_.points.empty() ? vertex
                                     : static_cast<std::uint32_t>(known_.points.size() + (vertex - own));
    }

    template <class F>
    void for_each_curve(F f) const {
        for (std::size_t i = 0; i < shell_.faces.size(); ++i)
            if (!known_.face(i))
                for (const TrimmedPatch& patch : shell_.faces[i].patches)
                    for (const auto& loop : patch.loops)
                        for (const TrimCurve& c : loop)
                            f(c, patch.surface, chords_.of_faces[i], loop.size() == 1);
    }
    std::uint32_t line_of(const TrimCurve& c) const {
        return c.edge ? *c.edge : c.seam ? seams_.at(*c.seam) : tips_.at(&c);
    }
    // The line's parameter at t of a trimming curve along it, and the other way round. Along a seam the two
    // run against each other, whatever their domains.
    double line_parameter(const TrimCurve& c, double t) const { return carried_over(c, t, true); }
    double trim_parameter(const TrimCurve& c, double t) const { return carried_over(c, t, false); }
    double carried_over(const TrimCurve& c, double t, bool to_line) const {
        if (c.is_tip()) return t;
        if (c.edge) return edge_parameter(c, shell_.edges[*c.edge].curve, t);  // its own inverse
        const TrimCurve& first = *seam_leader(c);
        if (&first == &c) return t;
        return to_line ? mirrored(c.curve, first.curve, t) : mirrored(first.curve, c.curve, t);
    }
    const TrimCurve* seam_leader(const TrimCurve& c) const {
        const Line& line = lines_[seams_.at(*c.seam)];
        return line.uses.empty() ? &c : line.uses.front().curve;
    }
    // A curved edge has a point of its own beside its ends, whatever the chord, where another one may join
    // the same two vertices: in this cell, or in one that has it from here. There the ends have more sites in
    // common than an edge between them.
    void set_first_pieces() {
        std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> joining;
        const auto ends = [](const CellEdge& e) { return std::minmax(e.vertices[0], e.vertices[1]); };
        for (const CellEdge& e : shell_.edges)
            if (!e.vertices.empty()) ++joining[ends(e)];
        for (std::size_t i = 0; i < shell_.edges.size(); ++i) {
            const CellEdge& e = shell_.edges[i];
            const bool is_loop = e.vertices.empty() || e.vertices[0] == e.vertices[1];
            const bool is_alone = is_loop || (joining[ends(e)] == 1 && !have_more_sites(e));
            lines_[i].pieces = is_loop ? least_around : is_alone || e.kind == CurveKind::Line ? 1 : 2;
        }
    }
    bool have_more_sites(const CellEdge& e) const {
        const auto &from = shell_.vertices[e.vertices[0]].sites, &to = shell_.vertices[e.vertices[1]].sites;
        const auto common =
            std::ranges::count_if(from, [&](const Site& s) { return std::ranges::find(to, s) != to.end(); });
        return static_cast<std::size_t>(common) > e.sites.size();
    }
    // Whether the stretch [from, to] of a line needs a point between: for the curve itself, and for the
    // patches on both sides, whose inner sides could not be shorter than those on the boundary, and which
    // have nothing of the face beyond the line.
    bool too_coarse(std::size_t line, double from, double to) const {
        if (line < shell_.edges.size()) {
            const RationalCurve3& curve = shell_.edges[line].curve;
            if (deviation(curve, from, to) > lines_[line].chord) return true;
        }
        for (const Use& use : lines_[line].uses) {
            const RationalCurve2& curve = use.curve->curve;
            const double a = trim_parameter(*use.curve, from), b = trim_parameter(*use.curve, to);
            if (std::max(a, b) <= curve.domain_begin() || std::min(a, b) >= curve.domain_end()) continue;
            const Vec2 from_uv = curve.evaluate(a), to_uv = curve.evaluate(b);
            if (deviation(*use.patch, from_uv, to_uv) > use.chord ||
                strays(*use.patch, from_uv, to_uv, use.chord))
                return true;
            // A seam may go all around and come back to next to where it began.
            if (use.curve->seam && strays(*use.patch, curve, a, b, use.chord)) return true;
        }
        return false;
    }
    // Does the stretch of a seam need a point between for the strips beside it?
    bool leaves_strips(std::size_t line, double from, double to) const {
        return std::ranges::any_of(lines_[line].uses, [&](const Use& use) {
            return use.curve->seam &&
                   leaves_strip(*use.patch, use.curve->curve, trim_parameter(*use.curve, from),
                                trim_parameter(*use.curve, to));
        });
    }
    // Parameters of a line: pieces of equal length between its breaks, halved while they are too coarse.
    std::vector<double> parameters(std::size_t line) const {
        const std::vector<double>& breaks = lines_[line].breaks;
        std::vector<double> result{breaks.front()};
        const auto add = [&](auto& self, double from, double to, int depth) -> void {
            constexpr int deepest = 12;
            // A curve that bends both ways may be on its chord half way.
            const auto is_too_coarse = [&] {
                const double middle = 0.5 * (from + to);
                return too_coarse(line, from, to) ||
                       (depth == 0 && (too_coarse(line, from, middle) || too_coarse(line, middle, to)));
            };
            if (((depth < deepest || keeps_chord_) && is_too_coarse()) ||
                (depth < deepest && leaves_strips(line, from, to))) {
                if (depth == deepest) throw TooFine();
                const double middle = 0.5 * (from + to);
                self(self, from, middle, depth + 1);
                self(self, middle, to, depth + 1);
            } else {
                result.push_back(to);
            }
        };
        const std::size_t pieces = lines_[line].pieces;
        for (std::size_t k = 0; k + 1 < breaks.size(); ++k) {
            const double begin = breaks[k], end = breaks[k + 1];
            const auto at = [&](std::size_t i) {
                return i == pieces
                           ? end
                           : begin + (end - begin) * static_cast<double>(i) / static_cast<double>(pieces);
            };
            for (std::size_t i = 0; i < pieces; ++i) add(add, at(i), at(i + 1), 0);
        }
        return result;
    }
    void sample_known_line(std::size_t e) {
        SampledLine& s = sampled_[e];
        s.points = known_.lines[e];
        if (lines_[e].uses.empty()) return;
        std::vector<Vec3> points;
        for (const std::uint32_t p : s.points) points.push_back(known_.points[p]);
        const CellEdge& edge = shell_.edges[e];
        s.parameters = parameters_along(edge.curve, points);
        if (edge.vertices.empty()) s.closing_parameter = nearest_parameter(edge.curve, points.front());
        break_up(s, lines_[e].breaks);
    }
    // Mesh points: the cell's vertices and what else is known, then the inner points of each edge and of each
    // seam.
    void sample_lines() {
        points_ = known_.points;
        for (std::size_t v = known_.points.empty() ? 0 : cell_.vertices.size(); v < shell_.vertices.size();
             ++v)
            points_.push_back(shell_.vertices[v].point);
        for (std::size_t i = 0; i < lines_.size(); ++i) {
            // An edge that parts that are joined have left over has no face.
            const bool is_left_over = i < shell_.edges.size() && lines_[i].uses.empty();
            if (is_known(i) || is_left_over) continue;
            if (sampled_[i].parameters.empty()) sampled_[i].parameters = parameters(i);
            sampled_[i].points.clear();
            if (i < shell_.edges.size()) sample_edge(i);
            // Each point of the edges belongs to a triangle of its own.
            if (points_.size() > most_points_) throw TooFine();
        }
        for (std::size_t f = 0; f < shell_.faces.size(); ++f)
            if (!known_.face(f)) {
                sample_tips(shell_.faces[f]);
                for (const TrimmedPatch& patch : shell_.faces[f].patches)
                    for (const auto& loop : patch.loops)
                        for (std::size_t i = 0; i < loop.size(); ++i) sample_seam(loop, i, patch.surface);
            }
    }
    // A face has two tips at most, below which it lies in the parameters and above which: all patches share
    // each.
    void sample_tips(const CellFace& face) {
        constexpr std::uint32_t none = UINT32_MAX;
        std::array<std::uint32_t, 2> points{none, none};
        for (const TrimmedPatch& patch : face.patches)
            for (const auto& loop : patch.loops)
                for (const TrimCurve& c : loop) {
                    if (!c.is_tip()) continue;
                    const Vec2 from = c.curve.evaluate(c.curve.domain_begin()),
                               to = c.curve.evaluate(c.curve.domain_end());
                    std::uint32_t& point = points[to.x() > from.x()];
                    if (point == none) point = add_point(patch.surface.evaluate(from.x(), from.y()));
                    SampledLine& s = sampled_[line_of(c)];
                    s.points.assign(s.parameters.size(), point);
                }
    }
    void sample_edge(std::size_t i) {
        const CellEdge& e = shell_.edges[i];
        SampledLine& s = sampled_[i];
        for (const double t : s.parameters) {
            const bool at_begin = t == s.parameters.front(), at_end = t == s.parameters.back();
            if (at_begin && !e.vertices.empty())
                s.points.push_back(point_of(e.vertices[0]));
            else if (at_end)
                s.points.push_back(e.vertices.empty() ? s.points.front() : point_of(e.vertices[1]));
            else
                s.points.push_back(add_point(e.curve.evaluate(t)));
        }
    }
    // A seam runs from edge to edge, or from or to a tip, and shares their points, or alone around a face
    // that has no edge there.
    void sample_seam(const std::vector<TrimCurve>& loop, std::size_t i, const RationalPatch& surface) {
        const TrimCurve& c = loop[i];
        if (!c.seam || seam_leader(c) != &c) return;
        const bool is_loop = loop.size() == 1;
        const TrimCurve &before = loop[(i + loop.size() - 1) % loop.size()],
                        &after = loop[(i + 1) % loop.size()];
        if (!is_loop && (before.seam || after.seam)) throw InternalError("tessellate: seams that meet");
        SampledLine& s = sampled_[line_of(c)];
        const auto add = [&](double t) {
            const Vec2 uv = c.curve.evaluate(t);
            s.points.push_back(add_point(surface.evaluate(uv.x(), uv.y())));
        };
        if (is_loop)
            add(s.parameters.front());
        else
            s.points.push_back(polyline(before).back().point);
        for (std::size_t k = 1; k + 1 < s.parameters.size(); ++k) add(s.parameters[k]);
        s.points.push_back(is_loop ? s.points.front() : polyline(after).front().point);
    }
    // The points of a trimming curve, both ends among them.
    std::vector<LoopPoint> polyline(const TrimCurve& c) const {
        const std::uint32_t line = line_of(c);
        const SampledLine& s = sampled_[line];
        const double a = line_parameter(c, c.curve.domain_begin()),
                     b = line_parameter(c, c.curve.domain_end());
        const double slack = break_rounding * (s.parameters.back() - s.parameters.front());
        const bool is_whole = std::max(a, b) - std::min(a, b) == s.parameters.back() - s.parameters.front();
        std::vector<LoopPoint> result;
        for (std::size_t i = 0; i < s.points.size(); ++i) {
            double t = s.parameters[i];
            if (t < std::min(a, b) - slack || t > std::max(a, b) + slack) continue;
            if (is_whole && s.closing_parameter && (i == 0 || i + 1 == s.points.size()))
                t = *s.closing_parameter;
            const std::size_t piece = a > b ? i - 1 : i;
            result.push_back({s.points[i], c.curve.evaluate(trim_parameter(c, t)), line,
                              static_cast<std::uint32_t>(piece)});
        }
        if (a > b) std::reverse(result.begin(), result.end());
        return result;
    }
    // A trimming loop as a polygon. Of points of a known line that stand for several breaks it has one; a tip
    // is one point in several places of the parameters.
    std::vector<LoopPoint> polygon(const std::vector<TrimCurve>& loop) const {
        std::vector<LoopPoint> result;
        for (const TrimCurve& c : loop) {
            const std::vector<LoopPoint> points = polyline(c);
            for (std::size_t i = 0; i + 1 < points.size(); ++i)
                if (c.is_tip() || points[i].point != points[i + 1].point) result.push_back(points[i]);
        }
        return result;
    }
    // Doubles the pieces of lines whose polylines cross in some face. True if there were any.
    bool refine_crossing_lines() {
        std::vector<bool> coarse(lines_.size(), false);
        for (std::size_t f = 0; f < shell_.faces.size(); ++f)
            if (!known_.face(f))
                for (const TrimmedPatch& patch : shell_.faces[f].patches)
                    for (const std::uint32_t line : crossing_lines(polygons(patch))) coarse[line] = true;
        bool any = false;
        for (std::size_t e = 0; e < coarse.size(); ++e)
            if (coarse[e] && !is_known(e)) {
                // Where halving made some pieces shorter, all become so.
                const std::size_t stretches = lines_[e].breaks.size() - 1;
                lines_[e].pieces = std::max(2 * lines_[e].pieces, sampled_[e].points.size() / stretches);
                sampled_[e].parameters.clear();
                any = true;
            }
        return any;
    }
    std::uint32_t add_point(const Vec3& p) {
        points_.push_back(p);
        return static_cast<std::uint32_t>(points_.size() - 1);
    }
    const Shell& shell_;
    const Cell& cell_;
    const KnownMesh& known_;
    const Chords& chords_;
    bool keeps_chord_;
    std::size_t most_points_;
    std::vector<Line> lines_;                                 // edges, then seams and tips
    std::unordered_map<std::uint32_t, std::uint32_t> seams_;  // number -> line
    std::unordered_map<const TrimCurve*, std::uint32_t> tips_;
    std::vector<SampledLine> sampled_;
    std::vector<Vec3> points_;
};

}  // namespace vcell
