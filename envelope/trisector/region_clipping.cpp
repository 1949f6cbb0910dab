#include "region_clipping.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "../../core/errors.hpp"
#include "../../primitives/bases/feet.hpp"
#include "../../primitives/bisectors/vertex_roots.hpp"
#include "../object_distance.hpp"

namespace vcell {

namespace {

// A side of the region, p[axis] = bound; or, as that of axis 3, where all three surfaces meet.
struct CuttingSide {
    int number;  // as TrisectorCurve::ends counts
    int axis;
    double bound;

    bool is_contact() const { return axis == 3; }
    std::string name() const {
        return is_contact() ? "the solids' surfaces"
                            : "side " + to_string(Site::box_side(static_cast<std::uint32_t>(number))) +
                                  " of its region";
    }
};

// Where the trisector crosses such a side.
struct Crossing {
    int side;
    Vec3 point;
    double error;
};

class Crossings {
public:
    Crossings(const Solids& solids, const Box& region) : region_(region) {
        const Vec3 middle = 0.5 * (region.min + region.max);
        for (std::size_t i = 0; i < solids.size(); ++i) sites_[i] = vertex_site(solids[i], beside(solids[i]));
        farthest_ = (middle - foot_of(solids[0], middle)).norm() + region.diagonal();
    }

    // All on this side; proved to be that many.
    void add(const CuttingSide& side, std::vector<Crossing>& out) const {
        const VertexSystem system{{sites_[0], sites_[1], sites_[2], BoxSideSite{side.axis, side.bound}}};
        IntervalBox<4> box;
        constexpr double part = 0x1p-10;
        for (int k = 0; k < 3; ++k) box[k] = Interval(region_.min[k], region_.max[k]);
        if (side.is_contact()) {
            const double room = part * region_.diagonal();
            box[3] = Interval(std::max(-room, std::min(system.least_clearance(), 0.0)), room);
        } else {
            const double room = part * (region_.max - region_.min)[side.axis];
            box[side.axis] = Interval(side.bound - room, side.bound + room);
            box[3] = Interval(0.0, std::max(farthest_, room));
        }
        const Solutions<4> found = solve(system, box);
        const auto place = [](const IntervalBox<4>& at) {
            return Vec3(at[0].mid(), at[1].mid(), at[2].mid());
        };
        for (const Undecided<4>& cluster : found.undecided)
            fail_trisector("touches " + side.name() + ", or runs along there,", place(cluster.hull));
        for (const Root<4>& root : found.unique) {
            if (root.on_boundary)
                fail_trisector("runs through an edge of its region on " + side.name(), place(root.box));
            double width = 0;
            for (int k = 0; k < 3; ++k) width += root.box[k].width();
            out.push_back({side.number, place(root.box), width});
        }
    }

private:
    Box region_;
    std::array<VertexSite, 3> sites_;
    double farthest_;  // no point of the region is farther from the first solid's foot
};

// The parameter of a curve's point nearest to p: of the best of samples' neighbourhood. Where that is an end,
// a closed curve goes on at the other one.
double nearest_parameter(const RationalCurve3& curve, const Vec3& p) {
    constexpr int samples = 16, halvings = 60;  // of each span
    std::vector<double> at;
    for (std::size_t k = 0; k + 1 < curve.knots.size(); ++k)
        for (int i = 0; curve.knots[k] < curve.knots[k + 1] && i < samples; ++i)
            at.push_back(std::lerp(curve.knots[k], curve.knots[k + 1], i / double(samples)));
    at.push_back(curve.domain_end());
    const auto square_distance = [&](double t) { return (curve.evaluate(t) - p).squaredNorm(); };
    const auto refined = [&](std::size_t best) {
        double low = at[best == 0 ? 0 : best - 1], high = at[std::min(best + 1, at.size() - 1)];
        for (int i = 0; i < halvings; ++i) {
            const double middle = std::midpoint(low, high);
            const auto [at_middle, along] = curve.evaluate_with_derivative(middle);
            (along.dot(p - at_middle) > 0 ? low : high) = middle;
        }
        return std::midpoint(low, high);
    };
    const auto best =
        static_cast<std::size_t>(std::ranges::min_element(at, {}, square_distance) - at.begin());
    const double found = refined(best);
    if (best != 0 && best + 1 != at.size()) return found;
    const double other = refined(at.size() - 1 - best);
    return square_distance(other) < square_distance(found) ? other : found;
}

class RegionClipping {
public:
    RegionClipping(const SolidCurves& all, const Box& region) : all_(all), region_(region) {
        for (int i = 0; i < 6; ++i)
            if (!all.is_cut_already[i])
                sides_.push_back({i, i / 2, (i % 2 == 1 ? region.max : region.min)[i / 2]});
        if (all.may_go_within) sides_.push_back({-1, 3, 0});
        cuts_.resize(all.curves.size());
    }

    std::vector<std::vector<CurvePart>> run() {
        const Crossings crossings(all_.solids, region_);
        std::vector<Crossing> found;
        for (const CuttingSide& side : sides_) crossings.add(side, found);
        for (const Crossing& c : found) assign(c);
        std::vector<std::vector<CurvePart>> parts;
        for (std::size_t i = 0; i < all_.curves.size(); ++i) parts.push_back(parts_of(i));
        return parts;
    }

private:
    struct Cut {
        double at;
        int side;
        double off;
    };

    std::vector<CurvePart> parts_of(std::size_t i) {
        const UncutCurve& curve = all_.curves[i];
        std::vector<Cut>& cuts = cuts_[i];
        std::ranges::sort(cuts, {}, &Cut::at);
        std::vector<Cut> stops{{curve.curve.domain_begin(), curve.ends[0], 0}};
        stops.insert(stops.end(), cuts.begin(), cuts.end());
        stops.push_back({curve.curve.domain_end(), curve.ends[1], 0});
        std::vector<CurvePart> inside;
        for (std::size_t k = 0; k + 1 < stops.size(); ++k) {
            const Cut &from = stops[k], &to = stops[k + 1];
            if (is_inside(curve, from.at, to.at))
                inside.push_back({from.at, to.at, {from.side, to.side}, std::max(from.off, to.off)});
        }
        return inside;
    }

    // The crossing lies on the curve that is as near as errors allow, if that is one.
    void assign(const Crossing& c) {
        std::optional<std::size_t> on;
        Cut cut{};
        for (std::size_t i = 0; i < all_.curves.size(); ++i) {
            const UncutCurve& curve = all_.curves[i];
            const double t = nearest_parameter(curve.curve, c.point);
            const double off = (curve.curve.evaluate(t) - c.point).norm() + c.error;
            if (!(off <= 2 * (curve.error + c.error) + 0x1p-44 * c.point.norm())) continue;
            if (on)
                fail_trisector("passes a side of its region where two of its curves are one to its error",
                               c.point);
            on = i;
            cut = {t, c.side, off};
        }
        if (!on) throw InternalError("a crossing of the trisector with a side of its region is on no edge");
        const auto at = [&](const Cut& other) { return all_.curves[*on].curve.evaluate(other.at); };
        for (const Cut& other : cuts_[*on])
            if ((at(other) - at(cut)).norm() <= 4 * (other.off + cut.off))
                fail_trisector("crosses a side of its region in places that are one to its error", c.point);
        cuts_[*on].push_back(cut);
    }

    // What is positive within a side. From a point of the trisector all solids are as far.
    double inwards(const CuttingSide& side, const Vec3& p) const {
        if (!side.is_contact())
            return side.number % 2 == 1 ? side.bound - p[side.axis] : p[side.axis] - side.bound;
        double least = HUGE_VAL;
        for (const Object& solid : all_.solids) least = std::min(least, signed_distance_from(solid, p));
        return least;
    }

    // Between two cuts the curve crosses no side; its point farthest from all of them tells which side it is
    // on.
    bool is_inside(const UncutCurve& curve, double from, double to) const {
        if (sides_.empty()) return true;
        constexpr int samples = 64;
        double most = 0;
        for (int i = 0; i <= samples; ++i) {
            const Vec3 p = curve.curve.evaluate(std::lerp(from, to, i / double(samples)));
            double least = HUGE_VAL;
            for (const CuttingSide& side : sides_) least = std::min(least, inwards(side, p));
            if (std::abs(least) > std::abs(most)) most = least;
        }
        if (!(std::abs(most) > curve.error))
            fail_trisector("runs along a side of its region", curve.curve.evaluate(std::midpoint(from, to)));
        return most > 0;
    }

    const SolidCurves& all_;
    Box region_;
    std::vector<CuttingSide> sides_;
    std::vector<std::vector<Cut>> cuts_;
};

}  // namespace

std::vector<std::vector<CurvePart>> parts_within(const SolidCurves& all, const Box& region) {
    return RegionClipping(all, region).run();
}

}  // namespace vcell
