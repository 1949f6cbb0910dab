/// Heights over boxes of a sphere's chart, compared through linear functions of the unit normal u.
///
/// q = -f, the reciprocal of the distance from the centre (radial_height.hpp), is p.u + s for circular forms,
/// and for cylinders, with A, B, C of primitives/forms/radial_form.hpp,
///
///     q = B' + |w|,   w = (B', A'),   B' = B / (C W),   A' = A / (sqrt(C) W),
///
/// both linear in u. For every unit vector e it is at least B' + e.w, with equality where w is along e: the
/// graph has supporting planes all over. (Of hollow cylinders q = B' + sqrt(B'^2 - A'^2), and the planes lie
/// above: for every hyperbolic turn e it is at most B' + (e_1 B' - e_2 A'). Of cylinders that pierce the
/// base, where C < 0 and A' = A / (sqrt(-C) W), q = B' - sqrt(B'^2 - A'^2), and they lie below.) The
/// difference of two of them is a circular form, whose sign over a box of the chart is known but for
/// rounding. The remainder is of second order in the box's size.
///
/// Everything is computed in doubles with bounds for their rounding. Near points where forms tie it is theirs
/// that counts: there interval arithmetic on the heights themselves sees more.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "../../core/numbers/interval.hpp"
#include "../../core/small_vector.hpp"
#include "../../primitives/forms/form_family.hpp"

namespace vcell {

/// p.u + s
struct NormalFunction {
    std::array<double, 3> p;
    double s;
};

/// Over a box: plane <= q <= plane + excess, and the chart derivatives of q and of the plane differ by less
/// than `bend`.
struct Support {
    NormalFunction plane;
    double excess;
    std::array<double, 2> bend;
    double rounding;  ///< bounds that of the plane's values
};

/// The unit normal over a point of the chart, and its chart derivatives, rounded.
struct PointNormal {
    PointNormal() = default;
    PointNormal(double x, double y);

    std::array<double, 3> u, ux, uy;
};

/// A box of the chart and the unit normals over it.
class NormalBox {
public:
    NormalBox() = default;
    NormalBox(double x0, double x1, double y0, double y1);

    /// q at the middle, in double.
    double middle(const Support& a) const { return value(a.plane); }
    /// Is a met certainly later than b (f_a > f_b) all over the box?
    bool is_above(const Support& a, const Support& b) const;
    /// May a and b be equal somewhere in the box? Only the one that is met later in the middle can be so all
    /// over it.
    bool meet(const Support& a, const Support& b) const {
        return middle(a) < middle(b) ? !is_above(a, b) : !is_above(b, a);
    }
    /// Encloses the gradient of f_a - f_b.
    std::array<Interval, 2> gradient(const Support& a, const Support& b) const;
    /// The derivative of f_a - f_b in a unit vector: at the middle, and how much it may change over the box.
    struct Growth {
        double middle, change;
    };
    Growth growth(const Support& a, const Support& b, const Eigen::Vector2d& direction) const;

private:
    friend class SphereSupports;

    static double dot(const NormalFunction& f, const std::array<double, 3>& v) {
        return f.p[0] * v[0] + f.p[1] * v[1] + f.p[2] * v[2];
    }
    static double bound(const NormalFunction& f, const std::array<double, 3>& v) {
        return std::abs(f.p[0]) * v[0] + std::abs(f.p[1]) * v[1] + std::abs(f.p[2]) * v[2];
    }
    double value(const NormalFunction& f) const { return dot(f, middle_.u) + f.s; }
    // Of a function, along x and y: absolute values at the middle, and how much they may change over the box.
    struct Slopes {
        std::array<double, 2> middle, change;

        double steepest(int i) const { return middle[i] + change[i]; }
    };
    Slopes slopes(const NormalFunction& f) const;
    // How much a function differs from its value at the middle; on the way changes of slopes count half.
    double variation(const Slopes& s) const {
        return (s.middle[0] + 0.5 * s.change[0]) * rx_ + (s.middle[1] + 0.5 * s.change[1]) * ry_;
    }

    double x0_, x1_, y0_, y1_, rx_, ry_;
    PointNormal middle_;
    std::array<double, 3> ux_range_, uy_range_;  // what they differ by over the box
    double m_;                                   // bounds 2 / W
};

class SphereSupports {
public:
    /// Pre: all radial forms are in the stereographic chart.
    explicit SphereSupports(const FormFamily& family);

    /// The plane touches where the box has its middle.
    Support over(FormId f, const NormalBox& box) const;
    /// That of a circular form, over every box; null for cylinders.
    const Support* everywhere(FormId f) const { return is_circular(f) ? &circular_[f.value] : nullptr; }
    /// f and its chart derivatives at a point, rounded.
    std::array<double, 3> jet(FormId f, const PointNormal& n) const;
    /// The value alone; it errs by value_error(f, n) at most.
    double value(FormId f, const PointNormal& n) const;
    double value_error(FormId f, const PointNormal& n) const {
        if (is_circular(f)) return circular_[f.value].rounding;
        return cylinder(f).tip_side != 0 ? error_by_tips(cylinder(f), n) : cylinder(f).rounding;
    }

private:
    struct Cylinder {
        NormalFunction b, a;
        double rounding;
        /// The sign of the root in q = B' +- sqrt(B'^2 - A'^2) where the bisector has tips; 0: q = B' + |w|.
        int tip_side = 0;
    };
    bool is_circular(FormId f) const { return f.value < circular_.size(); }
    static Support over(const Cylinder& with_tips, const NormalBox& box);
    static double error_by_tips(const Cylinder& with_tips, const PointNormal& n);
    const Cylinder& cylinder(FormId f) const { return cylinders_[f.value - circular_.size()]; }

    std::vector<Support> circular_;
    std::vector<Cylinder> cylinders_;
};

/// A box of the chart in parts, for statements about the points of it in which some of its forms are equal
/// and lowest of all: quarters, and quarters of those in which it is not clear yet.
class DividedBox {
public:
    static constexpr std::size_t most_forms = 8;

    /// `box`: {x0, x1, y0, y1}. `supports` and `forms` must outlive this object. Pre: most_forms at most.
    DividedBox(const SphereSupports& supports, const std::array<double, 4>& box,
               std::span<const FormId> forms);

    /// Another box and other forms, in the same memory.
    void start(const std::array<double, 4>& box, std::span<const FormId> forms);

    /// Does f - g certainly grow in the unit vector `direction` wherever f = g are lowest? Forms are named by
    /// their place here.
    bool grows_along(std::size_t f, std::size_t g, const Eigen::Vector2d& direction) const;
    /// The same wherever f = g.
    bool grows_throughout(std::size_t f, std::size_t g, const Eigen::Vector2d& direction) const;
    using Box = std::array<double, 4>;
    /// A box that holds all points where f = g = h are lowest; none if there are none.
    const std::optional<Box>& meeting(std::size_t f, std::size_t g, std::size_t h) const;
    /// The sign of (grad g - grad f) x (grad h - grad f) all over a box that holds all points where f = g = h
    /// are lowest; any sign if there are none.
    std::optional<Sign> turn(std::size_t f, std::size_t g, std::size_t h) const;

private:
    // More of them find more pieces plain, and take longer where one is not.
    static constexpr int levels = 5, coarse_levels = 3;  // the second: of boxes that may do

    using Part = std::uint32_t;
    using Pairs = std::uint64_t;  // a set of them
    struct Quartering {
        Box box;
        Pairs lowest;    // those that may be equal and lowest here; at first, in the part around it
        Part first = 0;  // of four parts; 0: not made yet
        bool is_compared = false;
    };

    // A symmetric matrix of bits.
    static Pairs pair(std::size_t f, std::size_t g) {
        return Pairs{1} << (most_forms * f + g) | Pairs{1} << (most_forms * g + f);
    }
    static Pairs pairs_of(std::size_t f) { return ((Pairs{1} << most_forms) - 1) << (most_forms * f); }
    Pairs lowest(Part part) const;
    Part quarter(Part part) const;
    const Support& support(std::size_t f, Part part) const;
    enum class Where { Equal, Lowest };
    bool grows_along(std::size_t f, std::size_t g, const Eigen::Vector2d& direction, Where where, Part part,
                     int level) const;
    void enclose_meeting(Pairs pairs, Part part, int levels_left, Box& hull) const;
    struct Meeting;
    Meeting& find_meeting(std::size_t f, std::size_t g, std::size_t h) const;
    void refine(Meeting& m) const;

    const SphereSupports& all_;
    std::span<const FormId> forms_;
    // What has been asked for; part 0 is the whole.
    mutable std::vector<Quartering> parts_;
    mutable std::vector<NormalBox> normals_;
    mutable std::vector<std::optional<Support>> supports_;
    struct Meeting {
        std::array<std::size_t, 3> forms;
        int levels = 0;
        std::optional<Box> box{};
    };
    mutable SmallVector<Meeting, 4> meetings_;
};

}  // namespace vcell
