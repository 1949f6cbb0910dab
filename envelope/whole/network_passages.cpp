// Objects that are parallel along a move which leaves the box as it is have a bisector that is the same after
// this move. At s across it, from where it is narrowest, the clearance between tubes R and r whose axes are D
// apart, and between a tube R and a plane that is D from its axis, is
//
//     (D/2) (1 + 4 s^2 / (D^2 - (R - r)^2))^(1/2) - (R + r)/2,    (D^2 + s^2 - R^2) / (2 (D + R)),
//
// and grows with |s|. So no way from one border of a face to another one is narrower than where these come
// nearest to s = 0, as all of the face lies between them; and none is wider than where that which comes less
// far on one side of the line comes farthest. Where borders lie on the two sides both are half the gap.
#include "network_passages.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <limits>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "../../core/errors.hpp"
#include "../object_distance.hpp"
#include "windings.hpp"

namespace vcell::whole {

namespace {

// Moves that leave both of two tubes or planes as they are; none of vessels and balls.
std::vector<Image> common_periods(const DecidedDiagram& decided, std::uint32_t a, std::uint32_t b) {
    const std::vector<Object>& objects = decided.scene().objects;
    for (const std::uint32_t i : {a, b})
        if (is_vessel(objects[i]) || decided.is_ball(i) || decided.periods(i).empty()) return {};
    const auto of = [&](std::uint32_t i) {
        return std::vector<Image>(decided.periods(i).begin(), decided.periods(i).end());
    };
    const bool is_tube = std::holds_alternative<Cylinder>(objects[a]);
    if (!std::holds_alternative<Cylinder>(objects[b])) return of(a);
    if (!is_tube) return of(b);
    const Image first = decided.periods(a)[0], second = decided.periods(b)[0];
    return first == second || plus(first, second) == here ? of(a) : std::vector<Image>();
}

// Clearance across the bisector of two parallel objects.
class Profile {
public:
    /// Pre: a tube comes first, if there is one.
    Profile(const Object& a, const Object& b) : foot_(place_of(a)) {
        const auto enclosed = [&](double length) {
            return Interval::ball(length, 16 * std::numeric_limits<double>::epsilon() *
                                              (place_of(a).cwiseAbs().sum() + place_of(b).cwiseAbs().sum()));
        };
        const auto *tube = std::get_if<Cylinder>(&a), *other = std::get_if<Cylinder>(&b);
        if (tube == nullptr) {
            distance_ = enclosed(distance_from(a, place_of(b)));
            return;
        }
        radius_ = tube->radius;
        const Vec3 axis = tube->axis.stableNormalized();
        if (other == nullptr) {
            distance_ = enclosed(distance_from(b, foot_));
            across_ = axis.cross(std::get<Plane>(b).normal.stableNormalized());
            return;
        }
        other_radius_ = other->radius;
        const Vec3 way = axis.cross(other->point - foot_);
        distance_ = enclosed(way.norm());
        across_ = way.normalized();
    }

    /// The least s of an arc, and the greatest.
    Extremes across(const RationalCurve3& curve, double error) const {
        if (!across_) return {Interval(0.0), Interval(0.0)};
        return height_along(foot_, *across_, curve, error);
    }

    Interval clearance(const Interval& s) const {
        const Interval half(0.5);
        if (!radius_) return half * distance_;
        const Interval radius(*radius_);
        if (!other_radius_)
            return half * (square(distance_) + square(s) - square(radius)) / (distance_ + radius);
        const Interval other(*other_radius_), excess = square(distance_) - square(radius - other);
        if (!(excess.lower() > 0)) return half * (distance_ - radius - other);
        return half * (distance_ * sqrt(Interval(1.0) + Interval(4.0) * square(s) / excess) - radius - other);
    }

private:
    Vec3 foot_;
    std::optional<Vec3> across_;                   // none between planes
    std::optional<double> radius_, other_radius_;  // of the tubes among the two
    Interval distance_{0.0};
};

// The edges around a face that vertices join.
struct Border {
    std::uint32_t edge = UINT32_MAX;          // the first of them
    Image image{0, 0, 0};                     // as seen from the face's first object
    Offset first{0, 0, 0};                    // where whoever stands for the border is then
    Image winding{0, 0, 0};                   // by which it comes again; none: it is a hole's
    double low = infinity, high = -infinity;  // of s
};

Interval widest_way(const Profile& profile, const Border& a, const Border& b) {
    const auto clearance = [&](double s) { return profile.clearance(Interval(std::max(0.0, s))); };
    const double nearest = std::max(std::min(a.low, b.low), -std::max(a.high, b.high)),
                 above = std::min(a.high, b.high), below = std::min(-a.low, -b.low);
    return {clearance(nearest).lower(), std::max(clearance(above).upper(), clearance(below).upper())};
}

}  // namespace

bool NetworkPassages::owns_face(std::uint32_t object, const NetworkSite& other) const {
    const NetworkSite self{Site::object(object), here};
    return other != self && other.site.is_object() &&
           !common_periods(names_.decided(), object, other.site.index).empty() &&
           names_.seen_from_owner(self < other ? NetworkSites{self, other} : NetworkSites{other, self})
                   .owner == self;
}

bool NetworkPassages::is_border(std::uint32_t object, const NetworkSites& sites) const {
    return std::ranges::any_of(sites, [&](const NetworkSite& s) { return owns_face(object, s); });
}

void NetworkPassages::add(std::uint32_t object, const Cell& cell, const FollowedArcs& followed) {
    if (followed.arcs.empty()) return;
    const NetworkSite self{Site::object(object), here};
    for (const CellFace& face : cell.faces) {
        const NetworkSite other = names_.site_in(cell, face.site);
        if (!owns_face(object, other)) continue;
        std::set<std::uint32_t> arcs;
        for (const TrimCurve& trim : face.trims())
            if (trim.edge)
                if (const auto arc = followed.of_edge.find(*trim.edge); arc != followed.of_edge.end())
                    arcs.insert(arc->second);
        // Tubes own their faces with planes.
        const Profile profile(names_.object(self), names_.object(other));
        Face& own = faces_.emplace_back();
        own.sites = self < other ? NetworkSites{self, other} : NetworkSites{other, self};
        for (const JoinedArcs& joined : followed.edges)
            for (std::size_t k = 0; k < joined.arcs.size(); ++k) {
                if (!arcs.contains(joined.arcs[k])) continue;
                const CutArc& arc = followed.arcs[joined.arcs[k]];
                const CellEdge& edge = *arc.edge;
                own.arcs.push_back({joined.vertices ? std::optional((*joined.vertices)[0]) : std::nullopt,
                                    minus(here, joined.images[k]), arc.sites,
                                    edge.curve.evaluate(edge.curve.domain_begin()), edge.error,
                                    profile.across(edge.curve, edge.error)});
            }
    }
}

// The place that an arc leads to, as seen from the face's owner; none where it is closed in itself.
std::optional<NetworkPlace> NetworkPassages::place_at(const BorderArc& arc,
                                                      const VoidNetwork& network) const {
    if (arc.sight) {
        const NetworkVertices::Sight& sight = vertices_.sight(*arc.sight);
        return NetworkPlace{sight.vertex, plus(sight.by, arc.image)};
    }
    const std::optional<NetworkEdges::Line> line = edges_.line_through(arc.sites, arc.point, arc.error);
    if (!line) return std::nullopt;
    return NetworkPlace{static_cast<std::uint32_t>(network.vertices.size()) + line->edge, line->image};
}

// Those of all parts of the bisector of one pair of parallel objects.
class NetworkPassages::OfPair {
public:
    /// The edges around the parts, and where the pair's first object is as an edge sees it.
    using Edges = std::vector<std::pair<std::uint32_t, Image>>;

    OfPair(const NetworkPassages& all, const VoidNetwork& network, const NetworkSites& sites,
           const Edges& edges)
        : all_(all),
          network_(network),
          sites_(sites),
          periods_(common_periods(all.names_.decided(), sites[0].site.index, sites[1].site.index)) {
        struct Ends {
            std::array<std::uint32_t, 2> numbers;
            Offset from, way;
            std::uint32_t edge;
            Image image;
        };
        std::vector<Ends> ways;
        for (const auto& [e, object] : edges) {
            const NetworkEdge& edge = network.edges[e];
            if (!edge.vertices && !edge.winds()) continue;
            const auto line = static_cast<std::uint32_t>(network.vertices.size()) + e;
            const auto [first, second] = edge.vertices.value_or(std::array{line, line});
            const Image image = minus(here, object);
            const NetworkPlace from{first, image}, to{second, plus(edge.image, image)};
            const std::array<std::uint32_t, 2> numbers{number(from), number(to)};
            ways.push_back({numbers, moves(from), moves(to) - moves(from), e, image});
        }
        windings_.emplace(numbers_.size());
        borders_.resize(numbers_.size());
        std::vector<std::pair<std::uint32_t, Offset>> closed;
        for (const Ends& ends : ways)
            if (const Offset way = windings_->join(ends.numbers[0], ends.numbers[1], ends.way); winds(way))
                closed.emplace_back(ends.numbers[0], way);
        for (const auto& [i, way] : closed) border(i).winding = image_of(way);
        for (const Ends& ends : ways) {
            Border& b = border(ends.numbers[0]);
            if (b.edge != UINT32_MAX) continue;
            b.edge = ends.edge;
            b.image = ends.image;
            b.first = place_of_border({ends.numbers[0], ends.from});
        }
    }

    /// Borders that wind, of one part. Others are holes in it.
    void add(const Face& part) {
        // With the image of its first edge.
        std::set<std::pair<std::uint32_t, Image>> around;
        for (const BorderArc& arc : part.arcs) {
            const std::optional<NetworkPlace> place = all_.place_at(arc, network_);
            if (!place) continue;
            const auto known = numbers_.find({place->number, representative(place->image, periods_)});
            if (known == numbers_.end())
                throw UndecidedError("void network: cells do not agree about the face between objects " +
                                     names_of(sites_));
            Border& b = border(known->second);
            if (b.winding == here) continue;
            b.low = std::min(b.low, arc.across.least.lower());
            b.high = std::max(b.high, arc.across.greatest.upper());
            const Image by = image_of(place_of_border({known->second, moves(*place)}) - b.first);
            around.emplace(windings_->find(known->second).first,
                           plus(b.image, representative(by, {&b.winding, 1})));
        }
        for (auto one = around.begin(); one != around.end(); ++one)
            for (auto other = std::next(one); other != around.end(); ++other)
                ways_.insert(
                    {one->first, other->first,
                     representative(minus(other->second, one->second), {&borders_[one->first].winding, 1})});
    }

    void append_to(std::vector<NetworkPassage>& passages) const {
        const Object a = all_.names_.object(sites_[0]), b = all_.names_.object(sites_[1]);
        const bool is_tube_first = std::holds_alternative<Cylinder>(a);
        const Profile profile(is_tube_first ? a : b, is_tube_first ? b : a);
        for (const auto& [one, other, image] : ways_) {
            const Border &first = borders_[one], &second = borders_[other];
            const Interval clearance = widest_way(profile, first, second);
            passages.push_back({{first.edge, second.edge},
                                image,
                                all_.names_.seen_from(sites_, first.image),
                                clearance.mid(),
                                clearance.radius()});
        }
    }

private:
    // Places that a common move leads to each other have one number: they are so many moves apart.
    std::uint32_t number(const NetworkPlace& place) {
        return numbers_
            .try_emplace({place.number, representative(place.image, periods_)},
                         static_cast<std::uint32_t>(numbers_.size()))
            .first->second;
    }
    Offset moves(const NetworkPlace& place) const {
        return offset(minus(place.image, representative(place.image, periods_)));
    }
    // Where whoever stands for a place's border is if the place is moved so far.
    Offset place_of_border(const std::pair<std::uint32_t, Offset>& place) {
        return place.second - windings_->find(place.first).second;
    }
    static Image image_of(const Offset& way) {
        return {static_cast<std::int16_t>(way[0]), static_cast<std::int16_t>(way[1]),
                static_cast<std::int16_t>(way[2])};
    }
    Border& border(std::uint32_t number) { return borders_[windings_->find(number).first]; }

    const NetworkPassages& all_;
    const VoidNetwork& network_;
    const NetworkSites& sites_;
    const std::vector<Image> periods_;
    std::map<NetworkPlace, std::uint32_t> numbers_;
    std::optional<Windings> windings_;
    std::vector<Border> borders_;  // of whoever stands for a set
    // Between two borders of a part, and the image of the second one's first edge as seen from the first's.
    std::set<std::tuple<std::uint32_t, std::uint32_t, Image>> ways_;
};

void NetworkPassages::find(VoidNetwork& network) const {
    if (faces_.empty()) return;
    std::map<NetworkSites, OfPair::Edges> edges;
    for (std::uint32_t e = 0; e < network.edges.size(); ++e) {
        const NetworkSites& sites = network.edges[e].sites;
        for (std::size_t b = 1; b < sites.size(); ++b)
            for (std::size_t a = 0; a < b; ++a) {
                if (common_periods(names_.decided(), sites[a].site.index, sites[b].site.index).empty())
                    continue;
                const SiteNames::Owned pair = names_.seen_from_owner({sites[a], sites[b]});
                edges[pair.sites].emplace_back(e, pair.owner.image);
            }
    }
    std::map<NetworkSites, OfPair> passages;
    for (const Face& part : faces_)
        passages.try_emplace(part.sites, *this, network, part.sites, edges[part.sites])
            .first->second.add(part);
    for (const auto& [sites, found] : passages) found.append_to(network.passages);
    std::ranges::sort(network.passages, {},
                      [](const NetworkPassage& p) { return std::tie(p.edges, p.image); });
}

}  // namespace vcell::whole
