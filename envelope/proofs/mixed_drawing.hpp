// A piece as it is drawn: its rim with the changes of label there, and arcs and vertices that are put inside.
// What is right to draw others decide (mixed_work.hpp).
#pragma once

#include <algorithm>
#include <limits>

#include "mixed_systems.hpp"

namespace vcell {

using Eigen::Vector2d;

// Does a place that is known up to errors lie in the piece?
enum class Inside { No, Yes, Unknown };

// A change of label, where a trisector leaves the rim: inward `before` lies on its left.
struct RimChange {
    std::uint32_t vertex;
    FormId before, after;
};

struct PieceDrawing {
    const PieceBoundary& boundary;
    MixedPiece piece{};
    SmallVector<RimChange, 8> changes{};
    std::vector<std::uint32_t> knots{};  // vertices of the rim in which more forms meet than change there

    Vector2d middle() const {
        return {Interval(piece.box[0], piece.box[1]).mid(), Interval(piece.box[2], piece.box[3]).mid()};
    }
    // The box with as much about it: what lies in the piece is found from its middle without going farther.
    IntervalBox<2> around() const {
        const auto widened = [](double a, double b) {
            return Interval(a, b) + Interval(-1, 1) * (Interval(b) - a);
        };
        return {widened(piece.box[0], piece.box[1]), widened(piece.box[2], piece.box[3])};
    }
    Inside where(const Interval& x, const Interval& y) const {
        bool inside = true;
        for (const PieceSide& side : boundary.sides) {
            const auto sign = (Interval(side.a) * x + Interval(side.b) * y + Interval(side.c)).sign();
            if (sign == Sign::Negative) return Inside::No;
            inside = inside && sign == Sign::Positive;
        }
        return inside ? Inside::Yes : Inside::Unknown;
    }
    // The box about a disk tells where all of the disk is.
    Inside where(const Vector2d& p, double radius) const {
        return where(Interval::ball(p.x(), radius), Interval::ball(p.y(), radius));
    }
    // The sides that arrive at and leave a vertex of the rim.
    std::array<const PieceSide*, 2> sides_at(std::uint32_t v) const {
        const auto side = [&](std::size_t edge) {
            return &*std::ranges::find(boundary.sides, piece.rim[edge].side, &PieceSide::id);
        };
        return {side((v + piece.rim.size() - 1) % piece.rim.size()), side(v)};
    }
    bool is_on_rim(FormId f) const {
        return std::ranges::find(piece.rim, f, &MixedPiece::RimEdge::label) != piece.rim.end();
    }
    // Right-hand of the chord between the places where two forms, and no others, change on the rim.
    std::optional<Vector2d> across_ends(FormId left, FormId right) const {
        std::optional<Vector2d> start, end;
        for (const RimChange& c : changes) {
            const bool starts = c.before == left && c.after == right;
            if (!starts && !(c.before == right && c.after == left)) continue;
            std::optional<Vector2d>& p = starts ? start : end;
            if (p) return std::nullopt;
            p = piece.vertices[c.vertex].point;
        }
        if (!start || !end) return std::nullopt;
        const Vector2d chord = *end - *start;
        return Vector2d(chord.y(), -chord.x()).normalized();
    }
    bool matched_pair() const {
        return changes.size() == 2 && changes[0].before == changes[1].after &&
               changes[0].after == changes[1].before;
    }
    // The changes counter-clockwise from a vertex of the rim on, without its own.
    SmallVector<RimChange, 8> changes_after(std::uint32_t v) const {
        SmallVector<RimChange, 8> all;
        for (const RimChange& c : changes)
            if (c.vertex > v) all.push_back(c);
        for (const RimChange& c : changes)
            if (c.vertex < v) all.push_back(c);
        return all;
    }
    void clear_inside() {
        piece.arcs.clear();
        piece.vertices.resize(piece.rim.size());
        piece.leaving.assign(piece.rim.size(), {});
    }
    // A vertex inside, not on the rim, which the disk may hold as far as errors tell.
    std::optional<std::uint32_t> inner_vertex_near(const Vector2d& p, double radius) const {
        for (std::size_t v = piece.rim.size(); v < piece.vertices.size(); ++v) {
            const double apart = (piece.vertices[v].point - p).norm();
            const double doubt =
                radius + piece.vertices[v].error + 8 * std::numeric_limits<double>::epsilon() * p.norm();
            if (!(apart > 2 * doubt)) return static_cast<std::uint32_t>(v);
        }
        return std::nullopt;
    }
    // The forms of the faces around an inner vertex.
    std::vector<FormId> forms_around(std::uint32_t v) const {
        std::vector<FormId> forms;
        for (const std::uint32_t h : piece.leaving[v])
            forms.push_back(h & 1u ? piece.arcs[h >> 1].left : piece.arcs[h >> 1].right);
        return forms;
    }
    // Puts a vertex on the arc of two forms, if they have one arc.
    bool divide(FormId f, FormId g, const MixedPiece::Vertex& vertex) {
        const auto is_theirs = [&](const MixedPiece::Arc& a) {
            return (a.left == f && a.right == g) || (a.left == g && a.right == f);
        };
        const auto first = std::ranges::find_if(piece.arcs, is_theirs);
        if (first == piece.arcs.end() ||
            std::find_if(first + 1, piece.arcs.end(), is_theirs) != piece.arcs.end())
            return false;
        const auto near = static_cast<std::uint32_t>(first - piece.arcs.begin()),
                   far = static_cast<std::uint32_t>(piece.arcs.size()),
                   v = static_cast<std::uint32_t>(piece.vertices.size());
        MixedPiece::Arc rest = *first;
        rest.from = v;
        first->to = v;
        std::ranges::replace(piece.leaving[rest.to], 2 * near + 1, 2 * far + 1);
        piece.arcs.push_back(std::move(rest));
        piece.vertices.push_back(vertex);
        piece.leaving.push_back({2 * near + 1, 2 * far});
        return true;
    }
    // Puts a face of h on the arc of two forms, if they have one arc, between two vertices: given in the
    // arc's order where f is on its left.
    bool insert_lens(FormId h, FormId f, FormId g, std::array<MixedPiece::Vertex, 2> ends,
                     const Vector2d& across) {
        if (!divide(f, g, ends[0])) return false;
        const auto far = static_cast<std::uint32_t>(piece.arcs.size() - 1),
                   near = static_cast<std::uint32_t>(
                       std::ranges::find(piece.arcs, piece.arcs[far].from, &MixedPiece::Arc::to) -
                       piece.arcs.begin());
        auto v = static_cast<std::uint32_t>(piece.vertices.size() - 1), w = v + 1;
        const bool is_reversed = piece.arcs[far].left != f;
        if (is_reversed) piece.vertices.back() = ends[1];
        piece.vertices.push_back(ends[is_reversed ? 0 : 1]);
        piece.arcs[far].from = w;
        const FormId left = piece.arcs[far].left, right = piece.arcs[far].right;
        const Vector2d along = is_reversed ? Vector2d(-across) : across;
        const std::uint32_t upper = far + 1, lower = far + 2;
        piece.arcs.push_back({v, w, left, h, along, {}});
        piece.arcs.push_back({v, w, h, right, along, {}});
        piece.leaving[v] = {2 * near + 1, 2 * lower, 2 * upper};
        piece.leaving.push_back({2 * far, 2 * upper + 1, 2 * lower + 1});
        return true;
    }
};

}  // namespace vcell
