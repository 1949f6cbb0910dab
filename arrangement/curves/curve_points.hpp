/// The points of an arrangement of curves, and what is known of them: boxes, exact coordinates where there
/// are any, the branches of curves on which they lie, and which of them are one.
///
/// Identity is combinatorial first. Points that have been found to be equal have one representative, which
/// lies on all branches of both. Signs climb the ladder: double intervals, exact numbers, 320-bit intervals;
/// what these cannot tell is assumed to be equal and counted.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "../../core/ids.hpp"
#include "../../core/numbers/wide.hpp"
#include "../../core/partition.hpp"
#include "exact_points.hpp"

namespace vcell {

struct CurvePointTag {
    static constexpr char letter = 'p';
};
struct BranchTag {
    static constexpr char letter = 'b';
};
using CurvePointId = Id<CurvePointTag>;
using BranchId = Id<BranchTag>;

/// Sign of p - q where the intervals do not overlap, or are one and the same point.
template <class T>
std::optional<Sign> compare_intervals(const T& p, const T& q) {
    if (p.lower() > q.upper()) return Sign::Positive;
    if (p.upper() < q.lower()) return Sign::Negative;
    if (p.lower() == p.upper() && q.lower() == p.lower() && q.upper() == p.lower()) return Sign::Zero;
    return std::nullopt;
}

class CurvePoints {
public:
    using Point = CurvePointId;
    struct Data {
        Interval x, y;
        std::function<std::pair<Wide, Wide>()> refine;
        std::shared_ptr<const OneRootPoint> exact = nullptr;  ///< or none
        std::vector<BranchId> on = {};                        ///< branches known to hold the point
    };

    /// The branches are told one after the other, before the points on them.
    void add_branch(bool is_vertical);

    Point add(Data data);
    Point add(OneRootPoint p);
    /// The one point that is given by these coordinates.
    Point add(double x, double y);
    const Data& operator[](Point p) const { return points_[p].data; }
    /// Changes what is known of p. Pre: it was not united with another point.
    void replace(Point p, Data data) { points_[p] = {std::move(data), {}}; }
    /// A box of 320-bit numbers around it.
    std::pair<Wide, Wide> fine_box(Point p);

    Point representative(Point p) const { return {equal_to_.find(p.value)}; }
    void note_on(Point p, BranchId b);
    bool is_known_on(Point p, BranchId b) const;
    /// Some of these may have been united since.
    const std::vector<Point>& on(BranchId b) const { return points_on_[b]; }

    Sign compare_x(Point p, Point q);
    Sign compare_xy(Point p, Point q);

    /// Counts a coincidence that is taken for granted somewhere in a box.
    void assume(const Interval& x, const Interval& y);
    Decisions& decisions() { return decisions_; }
    const Decisions& decisions() const { return decisions_; }
    /// The middles of those boxes, in the order of the decisions.
    const std::vector<Eigen::Vector2d>& assumed_at() const { return assumed_at_; }

private:
    struct Entry {
        Data data;
        std::optional<std::pair<Wide, Wide>> fine;
    };
    struct Comparison {
        Sign sign;
        bool assumed = false;
    };
    Comparison compare_coordinate(Point p, Point q, int axis);
    void unite(Point p, Point q);

    mutable Partition equal_to_, equal_x_;
    IdVector<CurvePointId, Entry> points_;
    std::map<std::pair<double, double>, Point> given_;
    IdVector<BranchId, std::vector<Point>> points_on_;  // the reverse of Data::on
    IdVector<BranchId, char> is_vertical_;
    Decisions decisions_;
    std::vector<Eigen::Vector2d> assumed_at_;
};

}  // namespace vcell
