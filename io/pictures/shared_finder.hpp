/// Which of what other cells have drawn is one cell's, too.
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "shared_elements.hpp"
#include "whole_elements.hpp"

namespace vcell::shared {

// Where a tube ends at a side of the box, other cells have that.
inline NetworkSite site_of(const Cell& cell, const Site& site) {
    return site_in_diagram(cell, side_at_end(cell.scene, site));
}

class Finder {
protected:
    /// `whole` is the cell's. Vertices that are not stored are added; lines and faces are not looked for yet.
    Finder(Store& store, std::uint32_t object, const Cell& cell, const WholeElements& whole)
        : store_(store),
          own_{Site::object(object), unmoved},
          cell_(cell),
          whole_(whole),
          vertices_(cell.vertices.size()),
          lines_(whole.edges.size()),
          faces_(whole.faces.size()) {
        // Vertices may lie nearer to each other than their errors and have three sites in common: those with
        // all of a stored one's sites take it before others may, which have to have left out some, or to have
        // more.
        const auto for_open = [&](auto&& place) {
            for (std::size_t v = 0; v < vertices_.size(); ++v)
                if (whole_.is_vertex[v] && !vertices_[v]) vertices_[v] = place(cell_.vertices[v]);
        };
        for_open([&](const CellVertex& v) { return found(v, Match::AllSites); });
        for_open([&](const CellVertex& v) { return found(v, Match::SomeSites); });
        // One that is added may have images among the cell's own.
        for_open([&](const CellVertex& v) {
            std::optional<CellPoint> image = found(v, Match::AllSites);
            if (!image) image = found(v, Match::SomeSites);
            return image ? image : added(v);
        });
    }

    // ---- Sites

    NetworkSite site_of(const Site& site) const { return shared::site_of(cell_, site); }
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
    MeetingSites meeting(const WholeEdge& e) { return meeting(cell_.edges[e.pieces.front().edge]); }
    NetworkSite beyond_face(std::size_t f) const {
        return site_of(cell_.faces[whole_.faces[f].front()].site);
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
            if (!s.site.is_object() || !store_.may_come(s.site.index)) continue;
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

    enum class Match { AllSites, SomeSites };
    struct VertexMatch {
        std::size_t common = 0;
        double square = 0;
        std::shared_ptr<SharedVertex> vertex;
        Image by{0, 0, 0};
    };

    void try_vertex(const CellVertex& v, const MeetingSites& sites, const ListedVertex& listed,
                    const Image& by, Match match, VertexMatch& best) const {
        const Vec3 place = store_.place(listed.place, by);
        if (are_apart(v, listed, place)) return;
        const SharedVertex& stored = *listed.what;
        const SharedPoint point = stored.point.at(by);
        const std::size_t common = common_sites(stored.sites, by, sites);
        const bool is_same = common == sites.size() && common == stored.sites.size();
        const bool is_told = common >= tell_vertex && common == std::min(sites.size(), stored.sites.size()) &&
                             !v.is_touching && !stored.is_touching;
        if (!is_same && (match == Match::AllSites || !is_told)) return;
        const double square = (place - v.point).squaredNorm();
        if (best.vertex && std::pair(best.common, -best.square) >= std::pair(common, -square)) return;
        if (std::ranges::any_of(vertices_, [&](const auto& p) { return p && p->point.key() == point.key(); }))
            return;
        best = {common, square, listed.what, by};
    }

    std::optional<CellPoint> found(const CellVertex& v, Match match) {
        const MeetingSites sites = meeting(v.sites);
        VertexMatch best;
        const auto try_it = [&](const ListedVertex& listed, const Image& by) {
            try_vertex(v, sites, listed, by, match, best);
        };
        // Cells that list this one, too, have what is listed there.
        for_stored(store_.vertices, {own_}, try_it);
        if (!best.vertex || best.common < sites.size()) for_stored(store_.vertices, sites, try_it);
        if (!best.vertex) return std::nullopt;
        // What other cells had left out, as it owns nothing there.
        for (const NetworkSite& s : sites) {
            const NetworkSite there = moved(s, opposite(best.by));
            if (!std::ranges::binary_search(best.vertex->sites, there)) store_.add_site(best.vertex, there);
        }
        return CellPoint{best.vertex->point.at(best.by), best.vertex};
    }
    CellPoint added(const CellVertex& v) {
        const MeetingSites sites = meeting(v.sites);
        const auto vertex = std::make_shared<SharedVertex>(
            SharedVertex{store_.new_point(v.point), sites, v.error, v.is_touching, {}});
        if (is_shared(sites)) store_.add(vertex);
        return {vertex->point, vertex};
    }

    // ---- Edges

    struct LineMatch {
        double distance = std::numeric_limits<double>::infinity();
        std::shared_ptr<SharedLine> line;
        Image by{0, 0, 0};
    };

    // Two arcs of one curve may have the same ends: a point of the curve tells which one it is.
    void try_line(const WholeEdge& edge, const std::shared_ptr<SharedLine>& line, const Image& by,
                  LineMatch& best) const {
        if ((line == best.line && by == best.by) || is_taken(line->id, by)) return;
        constexpr double slack = 4, rounding = 0x1p-40;
        const Vec3 inner = store_.place(line->inner, by);
        const double allowed = slack * (whole_.error(edge) + line->error) +
                               rounding * (whole_.point(edge, 0).cwiseAbs().sum() + inner.cwiseAbs().sum());
        const double distance = whole_.distance(edge, inner, allowed);
        if (distance <= allowed && distance < best.distance) best = {distance, line, by};
    }

    bool find_line(std::size_t e) {
        const WholeEdge& edge = whole_.edges[e];
        LineMatch best;
        if (!edge.vertices) {
            const MeetingSites sites = meeting(edge);
            for_stored(store_.closed_lines, sites, [&](const ListedLine& listed, const Image& by) {
                const MeetingSites& theirs = listed.what->sites;
                if (theirs.size() == sites.size() && common_sites(theirs, by, sites) == sites.size())
                    try_line(edge, listed.what, by, best);
            });
        } else {
            const auto& ends = *edge.vertices;
            const CellPoint *from = &*vertices_[ends[0]], *to = &*vertices_[ends[1]];
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

    CellLine as_line_of(const WholeEdge& edge, const SharedLine& line, const Image& by) const {
        CellLine result{line.id, by, false, {}};
        for (const SharedPoint& p : line.points) result.points.push_back(p.at(by));
        std::vector<SharedPoint>& points = result.points;
        const bool has_ends = !line.is_closed && points.front().key() != points.back().key();
        if (line.is_closed) {
            // It begins where this cell's curve begins.
            points.pop_back();
            const Vec3 begin = whole_.point(edge, 0);
            const auto first = std::ranges::min_element(
                points, {}, [&](const SharedPoint& p) { return (store_.place(p) - begin).squaredNorm(); });
            std::ranges::rotate(points, first);
            points.push_back(points.front());
        }
        result.is_reversed = has_ends ? points.front().key() != vertices_[(*edge.vertices)[0]]->point.key()
                                      : runs_against(edge, points);
        if (result.is_reversed) std::ranges::reverse(points);
        return result;
    }

    // A line that runs with the curve has two points of it in the curve's order.
    bool runs_against(const WholeEdge& edge, const std::vector<SharedPoint>& points) const {
        const auto place_of = [&](double part) {
            const Vec3 p = whole_.point(edge, part);
            return std::ranges::min_element(
                points, {}, [&](const SharedPoint& q) { return (store_.place(q) - p).squaredNorm(); });
        };
        constexpr double first = 0.375, second = 0.625;  // apart from the ends, which are one point
        return place_of(first) > place_of(second);
    }

    // ---- Faces

    // None where one of its edges is not shared.
    std::optional<std::vector<BorderLine>> border(std::size_t f) const {
        std::vector<BorderLine> result;
        for (const std::uint32_t face : whole_.faces[f])
            for (const TrimCurve& c : cell_.faces[face].trims()) {
                if (!c.edge || !whole_.whole_of(*c.edge)) continue;
                const WholeEdge::Piece& whole = *whole_.whole_of(*c.edge);
                const auto& line = lines_[whole.edge];
                if (!line) return std::nullopt;
                result.push_back(
                    {line->id, line->image, (line->is_reversed != c.reversed) != whole.reversed});
            }
        std::ranges::sort(result);
        result.erase(std::ranges::unique(result).begin(), result.end());
        return result;
    }

    bool find_face(std::size_t f) {
        const NetworkSite beyond = beyond_face(f);
        const auto list = store_.faces.find(own_.site.index);
        if (!beyond.site.is_object() || list == store_.faces.end()) return false;
        const auto own = border(f);
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

    Store& store_;
    const NetworkSite own_;
    const Cell& cell_;
    const WholeElements& whole_;
    std::vector<std::optional<CellPoint>> vertices_;  // none where an edge goes on beyond a joint
    std::vector<std::optional<CellLine>> lines_;      // of whole edges, as faces_ of whole faces
    // A stored face, and by how much it is moved and turned around; none: it is as it was drawn.
    std::vector<std::pair<std::shared_ptr<SharedFace>, std::optional<Image>>> faces_;
};

}  // namespace vcell::shared
