#include "joined_parts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <tuple>
#include <utility>

#include "../pictures/sampled_line.hpp"
#include "../pictures/trims.hpp"
#include "trim_fit.hpp"

namespace vcell {

namespace {

/// A trim along an edge where a part ends.
struct PlacedTrim {
    std::size_t face, patch, loop, trim;
};

/// A side of the section with which a part ends, in the sense in which the section runs around the axis, seen
/// from one and the same end of it for both parts.
struct SectionSide {
    std::uint32_t edge;
    bool reversed;  // runs against its edge's curve
    Site site;
    std::vector<PlacedTrim> trims;
};
using SectionLoop = std::vector<SectionSide>;  // a single one may have no vertex

class Joiner {
public:
    Joiner(const Cell& cell, double most)
        : joined_{cell, std::vector<bool>(cell.edges.size(), false),
                  std::vector<bool>(cell.vertices.size(), false)},
          most_(most * cell.scene.box.diagonal()) {
        for (std::uint32_t v = 0; v < cell.vertices.size(); ++v) leader_.push_back(v);
    }

    JoinedParts operator()() {
        std::vector<CellPart> parts;
        std::swap(parts, cell().parts);
        // The first part begins, and the last one ends, with nothing beyond.
        std::size_t first = 0, middle = 0;
        for (std::size_t k = 0; k <= parts.size(); ++k) {
            const std::size_t last = middle + (k < parts.size() ? parts[k].faces : 0);
            join(section({first, middle}, 1), section({middle, last}, 0));
            first = middle;
            middle = last;
        }
        drop_trims();
        lead_vertices();
        find_passed();
        return std::move(joined_);
    }

private:
    Cell& cell() { return joined_.cell; }
    CellEdge& edge(std::uint32_t e) { return joined_.cell.edges[e]; }
    TrimCurve& trim(const PlacedTrim& at) {
        return cell().faces[at.face].patches[at.patch].loops[at.loop][at.trim];
    }

    std::uint32_t find(std::uint32_t v) const {
        while (leader_[v] != v) v = leader_[v];
        return v;
    }
    std::uint32_t start(const SectionSide& side) { return edge(side.edge).vertices[side.reversed ? 1 : 0]; }
    std::uint32_t end(const SectionSide& side) { return edge(side.edge).vertices[side.reversed ? 0 : 1]; }

    // ---- Sections

    // The loops of the edges at one end of a part. Faces of the first part have the end on one side, those of
    // the second one on the other, and so the second ones are turned round.
    std::vector<SectionLoop> section(const std::array<std::size_t, 2>& faces, std::uint32_t at) {
        const Site end_site{Site::Kind::End, at};
        std::map<std::uint32_t, SectionSide> sides;
        for (std::size_t f = faces[0]; f < faces[1]; ++f)
            for (std::size_t p = 0; p < cell().faces[f].patches.size(); ++p) {
                const auto& loops = cell().faces[f].patches[p].loops;
                for (std::size_t l = 0; l < loops.size(); ++l)
                    for (std::size_t t = 0; t < loops[l].size(); ++t) {
                        const TrimCurve& c = loops[l][t];
                        if (!c.edge ||
                            std::ranges::find(edge(*c.edge).sites, end_site) == edge(*c.edge).sites.end())
                            continue;
                        SectionSide& side = sides[*c.edge];
                        side.edge = *c.edge;
                        side.reversed = c.reversed != (at == 0);
                        side.site = cell().faces[f].site;
                        side.trims.push_back({f, p, l, t});
                    }
            }
        return loops_of(sides);
    }

    std::vector<SectionLoop> loops_of(const std::map<std::uint32_t, SectionSide>& sides) {
        std::vector<SectionLoop> loops;
        std::map<std::uint32_t, const SectionSide*> by_start;
        for (const auto& [e, side] : sides)
            if (edge(e).vertices.empty())
                loops.push_back({side});
            else if (!by_start.emplace(start(side), &side).second)
                return {};
        while (!by_start.empty()) {
            SectionLoop& loop = loops.emplace_back();
            for (auto next = by_start.begin(); next != by_start.end();) {
                loop.push_back(*next->second);
                by_start.erase(next);
                next = by_start.find(end(loop.back()));
            }
            if (end(loop.back()) != start(loop.front())) return {};
        }
        return loops;
    }

    // ---- Joining

    /// Two sides of sections that run along each other, and become one edge.
    struct Pair {
        SectionSide first, second;
    };

    void join(std::vector<SectionLoop> before, std::vector<SectionLoop> after) {
        std::vector<Pair> pairs;
        std::vector<SectionSide> dropped;
        match(before, after, pairs);
        // What has no counterpart may have one without sides that the slab is wider than, or be no wider
        // itself.
        for (std::vector<SectionLoop>* loops : {&before, &after}) {
            for (SectionLoop& loop : *loops) drop_short_sides(loop, dropped);
            std::erase_if(*loops, [](const SectionLoop& loop) { return loop.empty(); });
            std::erase_if(*loops, [&](const SectionLoop& loop) { return fold(loop, pairs); });
        }
        match(before, after, pairs);
        if (!before.empty() || !after.empty()) return;
        std::vector<std::pair<PlacedTrim, TrimCurve>> trims;
        std::vector<PlacedTrim> points;
        std::vector<double> errors;
        for (const Pair& pair : pairs) {
            const std::optional<double> error = carry(pair, trims, points);
            if (!error) return;
            errors.push_back(*error);
        }
        for (const auto& [place, curve] : trims) trim(place) = curve;
        dropped_.insert(dropped_.end(), points.begin(), points.end());
        for (std::size_t i = 0; i < pairs.size(); ++i) {
            const auto& [first, second] = pairs[i];
            CellEdge& e = edge(first.edge);
            e.error = errors[i];
            for (Site& s : e.sites)
                if (s.kind == Site::Kind::End) s = second.site;
            joined_.is_joint[first.edge] = first.site == second.site;
            if (e.vertices.empty()) continue;
            unite(start(first), start(second));
            unite(end(first), end(second));
        }
        for (const SectionSide& side : dropped) {
            unite(start(side), end(side));
            for (const PlacedTrim& place : side.trims) dropped_.push_back(place);
        }
    }

    void unite(std::uint32_t a, std::uint32_t b) {
        a = find(a);
        b = find(b);
        leader_[std::max(a, b)] = std::min(a, b);
    }

    // Takes loops out of both that have the same sides at the same places.
    void match(std::vector<SectionLoop>& before, std::vector<SectionLoop>& after, std::vector<Pair>& pairs) {
        std::erase_if(before, [&](const SectionLoop& loop) {
            std::optional<std::size_t> best;
            double least = most_;
            for (std::size_t i = 0; i < after.size(); ++i) {
                const double off = rotate_to(loop, after[i]);
                if (!(off < least)) continue;
                least = off;
                best = i;
            }
            if (!best) return false;
            for (std::size_t i = 0; i < loop.size(); ++i) pairs.push_back({loop[i], after[*best][i]});
            after.erase(after.begin() + static_cast<std::ptrdiff_t>(*best));
            return true;
        });
    }

    // Turns `other` so that its sides are those of `loop`, one by one, and as near to them as can be: how far
    // vertices are from each other then, infinite where sides are not the same.
    double rotate_to(const SectionLoop& loop, SectionLoop& other) {
        if (loop.size() != other.size()) return infinite;
        double least = infinite;
        std::size_t best = 0;
        for (std::size_t by = 0; by < other.size(); ++by) {
            double most = 0;
            for (std::size_t i = 0; i < loop.size() && most < least; ++i)
                most = std::max(most, apart(loop[i], other[(i + by) % other.size()]));
            if (!(most < least)) continue;
            least = most;
            best = by;
        }
        std::ranges::rotate(other, other.begin() + static_cast<std::ptrdiff_t>(best));
        return least;
    }

    double apart(const SectionSide& a, const SectionSide& b) {
        if (a.site != b.site || edge(a.edge).vertices.size() != edge(b.edge).vertices.size()) return infinite;
        if (edge(a.edge).vertices.empty()) return 0;
        return distance(start(a), start(b));
    }
    double distance(std::uint32_t a, std::uint32_t b) {
        return (cell().vertices[a].point - cell().vertices[b].point).norm();
    }

    void drop_short_sides(SectionLoop& loop, std::vector<SectionSide>& dropped) {
        std::erase_if(loop, [&](const SectionSide& side) {
            const CellEdge& e = edge(side.edge);
            if (e.vertices.empty()) return false;
            const Vec3& from = cell().vertices[start(side)].point;
            if (!std::ranges::all_of(e.curve.points, [&](const Eigen::Vector4d& p) {
                    return (p.head<3>() - from).norm() < most_;
                }))
                return false;
            dropped.push_back(side);
            return true;
        });
    }

    // Two long sides that run back and forth are one edge, between the faces on both.
    bool fold(const SectionLoop& loop, std::vector<Pair>& pairs) {
        if (loop.size() != 2) return false;
        SectionSide back = loop[1];
        back.reversed = !back.reversed;
        const RationalCurve3& curve = edge(back.edge).curve;
        for (const double part : {0.25, 0.5, 0.75}) {
            const RationalCurve3& other = edge(loop[0].edge).curve;
            const Vec3 p = other.evaluate((1 - part) * other.domain_begin() + part * other.domain_end());
            if (!((curve.evaluate(nearest_on(curve, p)) - p).norm() < most_)) return false;
        }
        pairs.push_back({loop[0], std::move(back)});
        return true;
    }

    // ---- Trims

    // The second side's trims as trims along the first one's edge, those that are nothing but a point, and
    // how far trims are from the edge, or its error if that is more; none where that is too far.
    std::optional<double> carry(const Pair& pair, std::vector<std::pair<PlacedTrim, TrimCurve>>& trims,
                                std::vector<PlacedTrim>& points) {
        // Where both edges run through their curves alike they are the same trims, over domains of the first
        // edge's.
        EndMap ends = ends_along(pair, false);
        double error = std::max(edge(pair.first.edge).error, edge(pair.second.edge).error);
        const RationalCurve3& curve = edge(pair.first.edge).curve;
        const bool is_alike = std::ranges::all_of(pair.second.trims, [&](const PlacedTrim& place) {
            const auto [from, to] = ends_of(trim(place), pair, ends);
            return from == to || distance_along(curve, carried(trim(place), pair, from, to),
                                                surface(place)) <= std::max(error, enough_ * most_);
        });
        if (!is_alike) ends = ends_along(pair, true);
        for (const PlacedTrim& place : pair.second.trims) {
            const auto [from, to] = ends_of(trim(place), pair, ends);
            // Where a seam cuts the edge in its end.
            if (from == to) {
                if (!is_at(trim(place), surface(place), curve.evaluate(from))) return std::nullopt;
                points.push_back(place);
                continue;
            }
            TrimCurve c = carried(trim(place), pair, from, to);
            double off = distance_along(curve, c, surface(place));
            if (off > std::max(error, enough_ * most_)) {
                TrimCurve fit = fitted_trim(trim(place), surface(place), curve, from, to, enough_ * most_);
                fit.edge = pair.first.edge;
                const double off_fit = distance_along(curve, fit, surface(place));
                if (off_fit < off && runs_beside(fit, trim(place))) {
                    off = off_fit;
                    c = std::move(fit);
                }
            }
            error = std::max(error, off);
            if (!(off < most_)) return std::nullopt;
            trims.emplace_back(place, std::move(c));
        }
        return error;
    }

    // Is all of a trim at that place, by its ends and its middle?
    bool is_at(const TrimCurve& c, const RationalPatch& surface, const Vec3& place) const {
        const double begin = c.curve.domain_begin(), end = c.curve.domain_end();
        const auto is_near = [&](double t) {
            const Vec2 uv = c.curve.evaluate(t);
            return (surface.evaluate(uv.x(), uv.y()) - place).norm() < most_;
        };
        return is_near(begin) && is_near(0.5 * (begin + end)) && is_near(end);
    }

    const RationalPatch& surface(const PlacedTrim& place) {
        return cell().faces[place.face].patches[place.patch].surface;
    }

    // ---- Ends of trims

    /// Where trims along the second edge end, ascending in its parameters, and where that is on the first
    /// one: those that end where others begin have one place there, too, or the loops would not close.
    struct EndMap {
        std::vector<double> there, here;
    };

    EndMap ends_along(const Pair& pair, bool by_distance) {
        const RationalCurve3 &curve = edge(pair.first.edge).curve, &other = edge(pair.second.edge).curve;
        EndMap ends;
        std::vector<double>& there = ends.there;
        there = {other.domain_begin(), other.domain_end()};
        for (const PlacedTrim& place : pair.second.trims)
            for (const double t : {trim(place).curve.domain_begin(), trim(place).curve.domain_end()})
                there.push_back(edge_parameter(trim(place), other, t));
        settle_breaks(there);
        // Ends of the edge are ends of the other one; where a seam cuts it, it is the nearest point.
        const bool is_along = pair.first.reversed == pair.second.reversed;
        for (const double t : there) {
            if (t == there.front() || t == there.back()) {
                ends.here.push_back((t == there.front()) == is_along ? curve.domain_begin()
                                                                     : curve.domain_end());
                continue;
            }
            const double s = (t - other.domain_begin()) / (other.domain_end() - other.domain_begin()),
                         part = is_along ? s : 1 - s;
            ends.here.push_back(break_near(
                pair.first, by_distance ? nearest_on(curve, other.evaluate(t))
                                        : (1 - part) * curve.domain_begin() + part * curve.domain_end()));
        }
        // Places that change their order are one.
        for (std::size_t i = 1; i < ends.here.size(); ++i)
            ends.here[i] = is_along ? std::max(ends.here[i - 1], ends.here[i])
                                    : std::min(ends.here[i - 1], ends.here[i]);
        return ends;
    }

    // A trim's first and last place on the first edge.
    std::array<double, 2> ends_of(const TrimCurve& c, const Pair& pair, const EndMap& ends) {
        const RationalCurve3& other = edge(pair.second.edge).curve;
        const auto at = [&](double t) {
            const double there = edge_parameter(c, other, t);
            const auto next = std::ranges::lower_bound(ends.there, there);
            auto i = static_cast<std::size_t>(next - ends.there.begin());
            if (i == ends.there.size() || (i > 0 && there - ends.there[i - 1] < ends.there[i] - there)) --i;
            return ends.here[i];
        };
        return {at(c.curve.domain_begin()), at(c.curve.domain_end())};
    }

    TrimCurve carried(TrimCurve c, const Pair& pair, double from, double to) {
        c.edge = pair.first.edge;
        return over_range(std::move(c), edge(pair.first.edge).curve, from, to);
    }

    // A place where the first part's trims along an edge end, if it is as near as roundings and slabs are.
    double break_near(const SectionSide& side, double t) {
        const RationalCurve3& curve = edge(side.edge).curve;
        double least = 0x1p-24 * (curve.domain_end() - curve.domain_begin()), result = t;
        for (const PlacedTrim& place : side.trims) {
            const TrimCurve& c = trim(place);
            for (const double at : {edge_parameter(c, curve, c.curve.domain_begin()),
                                    edge_parameter(c, curve, c.curve.domain_end())})
                if (std::abs(at - t) < least) {
                    least = std::abs(at - t);
                    result = at;
                }
        }
        return result;
    }

    // ---- Elements

    void drop_trims() {
        const auto order = [](const PlacedTrim& p) { return std::tie(p.face, p.patch, p.loop, p.trim); };
        std::ranges::sort(dropped_, std::greater<>(), order);
        for (const PlacedTrim& p : dropped_) {
            auto& loops = cell().faces[p.face].patches[p.patch].loops;
            loops[p.loop].erase(loops[p.loop].begin() + static_cast<std::ptrdiff_t>(p.trim));
            if (loops[p.loop].empty()) loops.erase(loops.begin() + static_cast<std::ptrdiff_t>(p.loop));
        }
    }

    void lead_vertices() {
        std::vector<bool> is_led(leader_.size(), false);
        for (std::uint32_t v = 0; v < leader_.size(); ++v)
            if (find(v) != v) is_led[v] = is_led[find(v)] = true;
        for (std::uint32_t v = 0; v < leader_.size(); ++v) {
            if (!is_led[v]) continue;
            CellVertex& own = cell().vertices[v];
            own.sites.erase(std::remove_if(own.sites.begin(), own.sites.end(),
                                           [](const Site& s) { return s.kind == Site::Kind::End; }),
                            own.sites.end());
            if (find(v) == v) continue;
            CellVertex& lead = cell().vertices[find(v)];
            for (const Site& site : own.sites)
                if (std::ranges::find(lead.sites, site) == lead.sites.end()) lead.sites.push_back(site);
            std::ranges::sort(lead.sites);
            // What is in the slab is about as far from its sides as they are from each other.
            constexpr double room = 4;
            lead.error = std::max(lead.error, own.error + room * (lead.point - own.point).norm());
        }
        for (CellEdge& e : cell().edges)
            for (std::uint32_t& v : e.vertices) v = find(v);
    }

    void find_passed() {
        std::vector<std::uint32_t> ends(cell().vertices.size(), 0);
        std::vector<bool> has_joint(cell().vertices.size(), false);
        std::vector<bool> is_used(cell().edges.size(), false);
        for (const CellFace& face : cell().faces)
            for (const TrimCurve& c : face.trims())
                if (c.edge) is_used[*c.edge] = true;
        for (std::uint32_t e = 0; e < is_used.size(); ++e)
            for (const std::uint32_t v : edge(e).vertices)
                if (joined_.is_joint[e])
                    has_joint[v] = true;
                else if (is_used[e])
                    ++ends[v];
        for (std::size_t v = 0; v < ends.size(); ++v) joined_.is_passed[v] = has_joint[v] && ends[v] == 2;
    }

    static constexpr double infinite = std::numeric_limits<double>::infinity();
    static constexpr double enough_ = 0x1p-8;  // of what is allowed: what is not worth a fit
    JoinedParts joined_;
    const double most_;
    std::vector<std::uint32_t> leader_;  // of vertices: where two of them are one, the lower number
    std::vector<PlacedTrim> dropped_;
};

}  // namespace

JoinedParts joined_parts(const Cell& cell, double most) { return Joiner(cell, most)(); }

}  // namespace vcell
