/// Arcs of circles and lines: the model of ArcGeometry on top of CircleKernel.
///
/// Identity is combinatorial here too. Two curves that share a form are two of the three curves
/// {i = j}, {i = k}, {j = k} of a triple, and all three meet in the same points: each triple is
/// intersected once, and its points are known to lie on its curves, and how the curves turn there, without
/// arithmetic. Points that prove equal for another reason (pencils, lattices) are remembered as equal.
#pragma once

#include <array>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "../sweep/arc_geometry.hpp"
#include "circle_kernel.hpp"

namespace vcell {

class CircleArcs {
public:
    using Point = PointId;
    struct Arc {
        enum class Shape : std::uint8_t { Line, Vertical, Lower, Upper };

        FormPair curve;  ///< directed from left to right: f < g above the arc (left of a vertical one)
        PointId left, right;
        Shape shape = Shape::Line;    ///< Lower and Upper: on that half of a circle
        std::array<double, 4> box{};  ///< {x0, x1, y0, y1} contains the arc
    };

    /// The kernel must outlive this object and must not be reset meanwhile. Points may be made by either.
    explicit CircleArcs(CircleKernel& kernel) : kernel_(kernel) {}

    /// The point where the curves meet with that turn from c to d (Zero: where they touch), if any; the same
    /// point for every two curves of a triple. `near` as in CircleKernel. None for one and the same curve.
    std::optional<PointId> crossing(FormPair c, FormPair d, Sign orientation, const Eigen::Vector2d& near);
    /// Leftmost and rightmost point of a circle. Pre: c is a circle of positive radius.
    std::array<PointId, 2> x_extremes(FormPair c);

    /// Appends the x-monotone arcs, one to three, of the arc that runs from p to q along the direction of c.
    /// Pre: p and q are different points of c; on a line, q comes after p.
    void cut_arc(FormPair c, PointId p, PointId q, std::vector<Arc>& out);
    /// Appends the lower and the upper half of a circle. Pre: c is a circle of positive radius.
    void cut_circle(FormPair c, std::vector<Arc>& out);

    // --- ArcGeometry. ------------------------------------------------------------------------------

    Sign compare_xy(PointId p, PointId q);
    Sign compare_y_at_x(PointId p, const Arc& a);
    Sign compare_y_right_of(const Arc& a, const Arc& b, PointId p);
    PointId left(const Arc& a) const { return a.left; }
    PointId right(const Arc& a) const { return a.right; }
    bool is_vertical(const Arc& a) const { return a.shape == Arc::Shape::Vertical; }
    void intersect(const Arc& a, const Arc& b, ArcIntersections<PointId, Arc>& out);
    std::pair<Arc, Arc> split(const Arc& a, PointId p) const;

    CircleKernel& kernel() { return kernel_; }

private:
    /// How two curves meet: `points` by the turn of the canonical curves of the key, {positive, negative},
    /// or the one point where they touch.
    struct Meeting {
        enum class Kind : std::uint8_t { Apart, Crossing, Touching, SameCurve } kind = Kind::Apart;
        std::array<PointId, 2> points;
    };
    /// Three forms a < b < c for the curves {a = b}, {a = c}, then none; or two disjoint pairs a < b, c < d.
    struct Key {
        std::array<FormId, 4> forms;
        friend bool operator==(const Key&, const Key&) = default;
    };
    struct KeyHash {
        std::size_t operator()(const Key& key) const;
    };
    /// The key of two curves, and whether the turn from one to the other is that of the key's curves
    /// (Positive) or the opposite.
    struct Canonical {
        Key key;
        Sign sign;
    };
    static bool same_forms(FormPair c, FormPair d) { return c == d || c == d.reversed(); }
    static Canonical canonical(FormPair c, FormPair d);

    /// A point of one of the key's curves, and another one that may or may not hold it.
    struct Incidence {
        PointId point;
        FormPair curve;
    };
    const Meeting& meeting(const Key& key, const Eigen::Vector2d& near, std::optional<Incidence> asked);
    Arc make_arc(FormPair rightward, PointId left, PointId right, Arc::Shape shape) const;
    bool lies_on(const Arc& a, PointId p);
    void intersect_same_curve(const Arc& a, const Arc& b, ArcIntersections<PointId, Arc>& out);
    bool known_equal(PointId p, PointId q) const;
    bool known_on(PointId p, FormPair c) const;
    Sign sign_at(PointId p, FormPair c);
    Sign turn_at(PointId p, FormPair c, FormPair d);
    PointId representative(PointId p);
    Arc sub_arc(const Arc& a, PointId left, PointId right) const;

    CircleKernel& kernel_;
    std::unordered_map<Key, Meeting, KeyHash> meetings_;
    std::unordered_map<std::uint64_t, std::array<PointId, 2>> extremes_;  // by the two forms
    IdVector<PointId, PointId> equal_to_;  // disjoint sets of points known to be equal
};

static_assert(ArcGeometry<CircleArcs>);

}  // namespace vcell
