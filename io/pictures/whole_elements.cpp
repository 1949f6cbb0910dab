#include "whole_elements.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <utility>

namespace vcell {

namespace {

template <class Visit>
void for_each_edge_of(const CellFace& face, Visit&& visit) {
    for (const TrimCurve& c : face.trims())
        if (c.edge) visit(*c.edge);
}

}  // namespace

WholeElements::WholeElements(const Cell& cell) : is_vertex(cell.vertices.size(), true), cell_(cell) {
    for (std::uint32_t e = 0; e < cell.edges.size(); ++e) {
        const auto& ends = cell.edges[e].vertices;
        WholeEdge& whole = edges.emplace_back(WholeEdge{{{e, false}}, std::nullopt});
        if (!ends.empty()) whole.vertices = {ends[0], ends[1]};
        whole_of_.push_back(WholeEdge::Piece{e, false});
    }
    for (std::uint32_t f = 0; f < cell.faces.size(); ++f) {
        faces.push_back({f});
        whole_face_.push_back(f);
    }
}

WholeElements::WholeElements(const JoinedParts& joined)
    : is_vertex(joined.cell.vertices.size(), false),
      cell_(joined.cell),
      whole_of_(joined.cell.edges.size()),
      whole_face_(joined.cell.faces.size()) {
    const Cell& cell = joined.cell;
    // Faces beyond joints.
    std::vector<std::uint32_t> leader(cell.faces.size()), first_face(cell.edges.size(), UINT32_MAX);
    std::iota(leader.begin(), leader.end(), 0u);
    const auto find = [&](std::uint32_t f) {
        while (leader[f] != f) f = leader[f] = leader[leader[f]];
        return f;
    };
    for (std::uint32_t f = 0; f < cell.faces.size(); ++f)
        for_each_edge_of(cell.faces[f], [&](std::uint32_t e) {
            if (first_face[e] == UINT32_MAX)
                first_face[e] = f;
            else if (joined.is_joint[e]) {
                const std::uint32_t a = find(f), b = find(first_face[e]);
                leader[std::max(a, b)] = std::min(a, b);
            }
        });
    std::vector<std::uint32_t> number(cell.faces.size());
    for (std::uint32_t f = 0; f < cell.faces.size(); ++f) {
        if (find(f) == f) {
            number[f] = static_cast<std::uint32_t>(faces.size());
            faces.emplace_back();
        }
        whole_face_[f] = number[find(f)];
        faces[whole_face_[f]].push_back(f);
    }
    // Edges that end in a vertex that they pass.
    std::vector<std::array<WholeEdge::Piece, 2>> at(cell.vertices.size());
    std::vector<std::size_t> count(cell.vertices.size(), 0);
    const auto is_whole = [&](std::uint32_t e) { return first_face[e] != UINT32_MAX && !joined.is_joint[e]; };
    for (std::uint32_t e = 0; e < cell.edges.size(); ++e) {
        if (!is_whole(e)) continue;
        const auto& ends = cell.edges[e].vertices;
        for (std::size_t k = 0; k < ends.size(); ++k)
            if (joined.is_passed[ends[k]])
                at[ends[k]][count[ends[k]]++] = {e, k == 1};  // away from the vertex
            else
                is_vertex[ends[k]] = true;
    }
    const auto start_of = [&](const WholeEdge::Piece& p) { return cell.edges[p.edge].vertices[p.reversed]; };
    const auto end_of = [&](const WholeEdge::Piece& p) { return cell.edges[p.edge].vertices[!p.reversed]; };
    const auto add = [&](WholeEdge::Piece piece) {
        WholeEdge whole;
        const std::uint32_t first = piece.edge;
        for (;;) {
            whole_of_[piece.edge] = {static_cast<std::uint32_t>(edges.size()), piece.reversed};
            whole.pieces.push_back(piece);
            if (cell.edges[piece.edge].vertices.empty()) break;
            const std::uint32_t v = end_of(piece);
            if (!joined.is_passed[v]) {
                whole.vertices = {start_of(whole.pieces.front()), v};
                break;
            }
            // An edge that goes around, from its only vertex, comes twice.
            piece = at[v][0].edge == piece.edge ? at[v][1] : at[v][0];
            if (piece.edge == first) break;
        }
        edges.push_back(std::move(whole));
    };
    // Those that end somewhere, and then those that go around.
    for (const bool goes_around : {false, true})
        for (std::uint32_t e = 0; e < cell.edges.size(); ++e) {
            if (!is_whole(e) || whole_of_[e]) continue;
            const auto& ends = cell.edges[e].vertices;
            if (ends.empty() || goes_around)
                add({e, false});
            else if (!joined.is_passed[ends[0]])
                add({e, false});
            else if (!joined.is_passed[ends[1]])
                add({e, true});
        }
}

Vec3 WholeElements::point(const WholeEdge& e, double part) const {
    const double place = part * static_cast<double>(e.pieces.size());
    const std::size_t k = std::min(static_cast<std::size_t>(place), e.pieces.size() - 1);
    const RationalCurve3& curve = cell_.edges[e.pieces[k].edge].curve;
    double s = place - static_cast<double>(k);
    if (e.pieces[k].reversed) s = 1 - s;
    return curve.evaluate((1 - s) * curve.domain_begin() + s * curve.domain_end());
}

double WholeElements::distance(const WholeEdge& e, const Vec3& p, double enough) const {
    double least = std::numeric_limits<double>::infinity();
    for (const WholeEdge::Piece& piece : e.pieces)
        if (least > enough)
            least = std::min(least, distance_from_curve(cell_.edges[piece.edge].curve, p, enough));
    return least;
}

double WholeElements::error(const WholeEdge& e) const {
    double most = 0;
    for (const WholeEdge::Piece& piece : e.pieces) {
        const CellEdge& edge = cell_.edges[piece.edge];
        most = std::max(most, edge.error);
        for (const std::uint32_t v : edge.vertices)
            if (!is_vertex[v]) most = std::max(most, cell_.vertices[v].error);
    }
    return most;
}

void WholeElements::divide(const WholeEdge& edge, const std::vector<std::uint32_t>& line,
                           KnownMesh& known) const {
    std::size_t from = 0;
    for (std::size_t k = 0; k < edge.pieces.size(); ++k) {
        const auto& [e, is_reversed] = edge.pieces[k];
        const auto& ends = cell_.edges[e].vertices;
        std::size_t to = line.size() - 1;
        if (k + 1 < edge.pieces.size()) {
            const Vec3& joint = cell_.vertices[ends[is_reversed ? 0 : 1]].point;
            to = static_cast<std::size_t>(
                std::ranges::min_element(
                    line.begin() + static_cast<std::ptrdiff_t>(from), line.end(), {},
                    [&](std::uint32_t p) { return (known.points[p] - joint).squaredNorm(); }) -
                line.begin());
        }
        std::vector<std::uint32_t>& piece = known.lines[e];
        piece.assign(line.begin() + static_cast<std::ptrdiff_t>(from),
                     line.begin() + static_cast<std::ptrdiff_t>(to + 1));
        if (piece.size() == 1) piece.push_back(piece.front());
        if (is_reversed) std::ranges::reverse(piece);
        if (!ends.empty()) {
            known.vertices[ends[0]] = piece.front();
            known.vertices[ends[1]] = piece.back();
        }
        from = to;
    }
}

}  // namespace vcell
