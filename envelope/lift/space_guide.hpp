/// Where an edge runs, as far as the diagram tells: guesses for the fit (primitives/fit/spline_fit.hpp), and
/// enclosures for its chords.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>

#include "../../primitives/charts/chart.hpp"
#include "../../primitives/fit/spline_fit.hpp"
#include "space_arc.hpp"

namespace vcell::space_fit {

using Vector3i = std::array<Interval, 3>;
using Piece = MinimizationDiagram::ArcPiece;

// A part of the strip between two lines of the chart in a piece's direction: points s n + t d, d the
// direction and n across it on its left, as far as they are in a box.
struct StripPart {
    Vec2 direction;
    Interval across, along;  // s, t
    std::array<double, 4> box;

    // Encloses a function's value over the part, of which the box is one, by the mean value theorem: from its
    // value in a point of the box and its gradient over it.
    Interval mean_value(const Interval& value, const std::array<Interval, 2>& gradient, const Vec2& at) const;
};

class ArcGuide {
public:
    ArcGuide(const BaseChart& chart, const SpaceArc& arc, const ArcEquations& equations)
        : chart_(chart), arc_(arc), equations_(equations) {}

    // The point over a chart point, by the side whose bisector the ray meets more steeply.
    Vector4d lifted(const Vec2& q) const { return over(chart_.foot(q), chart_.normal(q)); }
    Vector4d over(const Vec3& foot, const Vec3& normal) const {
        const Vector4d left = met(0, foot, normal);
        if (arc_.pieces.empty()) return left;
        const Vector4d right = met(1, foot, normal);
        const auto slope = [&](int k, const Vector4d& X) {
            const Vector4d g = equations_.sites[k].gradient(X);
            return std::abs(g[3] + g.head<3>().dot(normal));
        };
        return slope(0, left) < slope(1, right) ? right : left;
    }
    // In the chart, as continued to the piece.
    Vec2 chart_point(const Vector4d& X, const Piece& piece) const {
        return chart_.continued(chart_.chart_point(X), piece.box);
    }

    // Equal heights along a line of the chart in the piece's direction, as one of them falls against the
    // other there.
    std::optional<Vec2> meet(const Vec2& q, const Piece& piece) const;

    // Encloses the points (p, t) over a part of the arc, in a box of the chart.
    SpaceBox enclosure(const std::array<double, 4>& box) const;
    SpaceBox enclosure(const StripPart& strip) const;
    // Encloses them over the lesser arc of a rim between two nodes: a rim has no pieces.
    SpaceBox rim_enclosure(const Node& from, const Node& to, double slack) const;

    // Encloses the part of a piece between two nodes: lines of the chart in the piece's direction bound a
    // strip, and from both ends of the strip what is certainly off the arc is cut off. slack: of the nodes.
    // `cells`: of the chart that may still be looked at.
    SpaceBox enclosure_between(const Node& from, const Node& to, const Piece& piece, double slack,
                               std::size_t& cells) const;

private:
    // Over a part of the chart, with what rounding changes about each site's distance.
    struct Rays {
        Vector3i foot, normal;
        std::array<Interval, 2> distances, doubts;
    };
    Rays rays(const Chart::Part& part) const;
    // Over coordinates that are Intervals or Jets of them.
    template <class T>
    std::array<T, 3> normal(const T& x, const T& y, bool is_back) const {
        return chart_.normal(x, y, is_back, T(Interval::ball(0, rounding)));
    }
    template <class T>
    T distance_along(int k, const T& x, const T& y, bool is_back) const;
    // Where the point over a part may be, by the distance of one site: nearer than rays() tell it where that
    // changes fast along the strip, but slowly across it.
    std::array<Interval, 4> over(const StripPart& strip, bool is_back, int k, const Interval& doubt) const;
    bool is_off_arc(const StripPart& strip, bool is_back) const;
    bool is_off_arc(const StripPart& strip) const;
    Vector4d met(int k, const Vec3& foot, const Vec3& normal) const;
    std::optional<Vec2> bisect(const Vec2& q, const Piece& piece) const;
    std::optional<Vec2> approach(Vec2 q, const Vec2& direction) const;

    const BaseChart& chart_;
    const SpaceArc& arc_;
    const ArcEquations& equations_;
};

}  // namespace vcell::space_fit
