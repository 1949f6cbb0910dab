#include "edges.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "../pictures/trims.hpp"
#include "judged_edge.hpp"

namespace vcell::check {
namespace {

class Edges : public Room {
public:
    Edges(const Subject& subject, const CheckOptions& options, Certificate& certificate,
          std::vector<EdgeBound>& bounds)
        : Room(subject, options, certificate), bounds_(bounds) {}

    void run() {
        for (const std::uint32_t i : subject_.edges) judge(i);
    }

private:
    void judge(std::size_t i) {
        const CellEdge& e = cell_.edges[i];
        if (e.sites[0] == e.sites[1] && !rim_[i])
            return certificate_.refute(edge_path(i) + ".sites",
                                       fmt::format("are {} twice", title(e.sites[0])));
        if (!check_ends(i)) return;
        edge_.number = i;
        edge_.path = edge_path(i);
        edge_.error = full_error(i);
        auto& conditions = edge_.conditions;
        conditions.clear();
        const bool is_on_wall = rim_[i] && rim_[i]->is_object();
        const RationalCurve3& curve = e.curve;
        const Vec3 middle = curve.evaluate(0.5 * (curve.domain_begin() + curve.domain_end()));
        for (const Site& s : label(i)) {
            conditions.push_back(space().condition_at(s, middle));
            conditions.back().at_rim = geometry_.is_plane() && !is_on_wall && rim_[i] == s;
        }
        // A side of the box may lean out of its own rim: it meets the boundary there. A vessel's wall meets
        // the base.
        if (e.sites[0] == e.sites[1]) conditions.push_back({is_on_wall ? Site::base() : e.sites[0]});
        const auto is_first = [&](const Condition& c) {
            return contains(e.sites, c.site) || c.site == Site::base();
        };
        std::ranges::stable_partition(conditions, is_first);
        edge_.middle_planes.reset();
        if (conditions[0].site.is_object() && conditions[1].site.is_object())
            edge_.middle_planes = middle_planes(scene_.objects[conditions[0].site.index],
                                                scene_.objects[conditions[1].site.index]);

        const Vec3 origin = e.curve.points.front().head<3>();
        edge_.parts.clear();
        const auto add = [&](const BezierPiece<3>& span) {
            edge_.parts.push_back(edge_.part(Net(span, origin), 0, space()));
        };
        if (const auto span = only_span<3>(e.curve, origin))
            add(*span);
        else
            std::ranges::for_each(spans<3>(e.curve, origin), add);
        const auto bound = certify_on_arc(edge_, subject_, options_, certificate_);
        if (!bound) return;
        const auto nearer = certify_no_rivals(edge_, bound->distance, subject_, options_, certificate_);
        if (!nearer) return;
        if (e.error > most_stated(bound->distance, bound->rounded) && e.error > times_ends * ends_error(e) &&
            e.error > most_stated(trims_off(i)))
            return certificate_.refute(edge_.path + ".error",
                                       fmt::format("is {:.3g}, the curve is within {:.3g} of the true one",
                                                   e.error, bound->distance),
                                       e.error);
        bounds_[i] = *bound;
        prove(edge_.path, std::max(bound->distance, *nearer));
    }

    bool check_ends(std::size_t i) {
        const CellEdge& e = cell_.edges[i];
        const auto &first = edge_pieces_[i].front(), &last = edge_pieces_[i].back();
        const std::array ends{first.control(0), last.control(last.points.size() - 1)};
        if (e.vertices.empty()) {
            const double gap = (ends[0] - ends[1]).norm();
            if (gap <= 2 * e.error + rounding()) return true;
            certificate_.refute(edge_path(i) + ".curve",
                                fmt::format("is closed, but its ends are {:.3g} apart", gap), gap);
            return false;
        }
        for (int k = 0; k < 2; ++k) {
            const CellVertex& v = cell_.vertices[e.vertices[k]];
            const double gap = (ends[k] - v.point).norm();
            if (gap <= e.error + v.error + rounding()) continue;
            certificate_.refute(edge_path(i) + ".vertices",
                                fmt::format("the curve {} {:.3g} away from vertex {}", k ? "ends" : "starts",
                                            gap, e.vertices[k]),
                                gap);
            return false;
        }
        return true;
    }

    /// The true arc ends in the true vertices, wherever within their errors these are: so many times that is
    /// granted to an edge.
    static constexpr double times_ends = 4;
    double ends_error(const CellEdge& e) const {
        double most = 0;
        for (const std::uint32_t v : e.vertices) most = std::max(most, cell_.vertices[v].error);
        return most;
    }

    /// How far trims are seen to be off their edge: its error is said to be theirs, too.
    double trims_off(std::size_t i) const {
        constexpr int places = 16;
        double most = 0;
        for (const Patch& patch : patches_)
            for (const auto& loop : patch.loops)
                for (const Trim& trim : loop) {
                    if (trim.curve->edge != i) continue;
                    for (int k = 0; k <= places; ++k) {
                        const double t = trim.begin() + (trim.end() - trim.begin()) * k / places;
                        const Vec3 on_edge =
                            evaluate(edge_pieces_[i], edge_parameter(*trim.curve, cell_.edges[i].curve, t));
                        most = std::max(most, (lift(patch, evaluate(trim.pieces, t)).p - on_edge).norm());
                    }
                }
        return most;
    }

    std::vector<EdgeBound>& bounds_;
    JudgedEdge edge_;
};

}  // namespace

void certify_edges(const Subject& subject, const CheckOptions& options, Certificate& certificate,
                   std::vector<EdgeBound>& bounds) {
    Edges(subject, options, certificate, bounds).run();
}

}  // namespace vcell::check
