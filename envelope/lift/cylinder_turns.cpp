#include "cylinder_turns.hpp"

#include <algorithm>
#include <limits>
#include <vector>

namespace vcell::radial {

namespace {

// Between the ends of a piece, which may be half a turn apart: its box tells to which side.
double turn_along(const MinimizationDiagram::ArcPiece& piece, double from, double to) {
    const double middle = chart_angle(0.5 * (piece.box[0] + piece.box[1]));
    const auto from_middle = [&](double angle) {
        return std::remainder(angle - middle, 2 * std::numbers::pi);
    };
    return from_middle(to) - from_middle(from);
}

struct Mean {
    double sum = 0;
    int count = 0;
    double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;

    void add(double x) {
        sum += x;
        ++count;
        lowest = std::min(lowest, x);
        highest = std::max(highest, x);
    }
    double operator()() const { return sum / std::max(count, 1); }
};

// What a loop covers, followed from point to point.
class LoopExtent {
public:
    explicit LoopExtent(Mean& y) : y_(y) {}

    bool is_empty() const { return is_empty_; }
    void go_to(const Vec2& p) {
        const double next = chart_angle(p.x());
        if (is_empty_)
            begin_ = extent_.from = extent_.to = angle_ = next;
        else
            angle_ += std::remainder(next - angle_, 2 * std::numbers::pi);
        reach(p.y());
    }
    void go_along(const MinimizationDiagram::ArcPiece& piece, const Vec2& p) {
        angle_ += turn_along(piece, angle_, chart_angle(p.x()));
        reach(p.y());
    }
    // At one height.
    void turn_by(double turn, double y) {
        angle_ += turn;
        reach(y);
    }
    CylinderTurns::Extent extent() const {
        CylinderTurns::Extent result = extent_;
        result.is_closed = std::abs(angle_ - begin_) > std::numbers::pi;
        return result;
    }

private:
    void reach(double y) {
        is_empty_ = false;
        extent_.from = std::min(extent_.from, angle_);
        extent_.to = std::max(extent_.to, angle_);
        y_.add(y);
    }

    Mean& y_;
    CylinderTurns::Extent extent_;
    double begin_ = 0, angle_ = 0;
    bool is_empty_ = true;
};

// The lower rim goes with the angle, the upper one against it.
double rim_sign(const MinimizationDiagram::Edge& rim) { return rim.side == 0 ? 1 : -1; }

}  // namespace

CylinderTurns::Extent CylinderTurns::extent(FaceId face) const {
    Extent widest;
    Mean y;
    const auto point = [&](VertexId v) { return diagram_.vertices[v].point; };
    for (const CcbId ccb : loops_[face]) {
        LoopExtent loop(y);
        loops_.around(ccb, [&](EdgeId e, bool reversed) {
            const VertexId from = reversed ? diagram_.end(e) : diagram_.start(e),
                           to = reversed ? diagram_.start(e) : diagram_.end(e);
            const auto pieces = diagram_.pieces(e);
            if (loop.is_empty() && from.valid())
                loop.go_to(point(from));
            else if (loop.is_empty() && !pieces.empty())
                loop.go_to(pieces.back().end);
            if (const auto& edge = diagram_.edges[e]; edge.on_rim()) {
                const double sign = rim_sign(edge);
                loop.turn_by(sign * rim_turn(from, to, sign), problem_.stretch[edge.side == 0 ? 0 : 1]);
                return;
            }
            const std::size_t count = pieces.size();
            for (std::size_t i = 0; i < count; ++i) {
                const bool is_last = i + 1 == count;
                const Vec2 end = pieces[reversed && !is_last ? count - 2 - i : reversed ? count - 1 : i].end;
                loop.go_along(pieces[reversed ? count - 1 - i : i], is_last && to.valid() ? point(to) : end);
            }
            if (count == 0) loop.go_to(point(to));
        });
        const Extent found = loop.extent();
        if (found.is_closed || (!widest.is_closed && !(found.width() < widest.width()))) widest = found;
    }
    widest.y = y();
    widest.lowest = y.lowest;
    widest.highest = y.highest;
    return widest;
}

// By how much the angle changes, in the direction of the sign, from one vertex of a rim to the next, once
// around at most: so little, maybe, that only their coordinates tell it from a whole turn.
double CylinderTurns::rim_turn(VertexId from, VertexId to, double sign) const {
    constexpr double whole = 2 * std::numbers::pi;
    if (from == to) return whole;
    const double x = diagram_.vertices[from].point.x(), end = diagram_.vertices[to].point.x();
    const double turn = sign * (chart_angle(end) - chart_angle(x));
    if (turn == 0 && sign * (end - x) > 0) return std::numeric_limits<double>::min();
    return turn > 0 ? turn : turn + whole;
}

double CylinderTurns::mean_height(FaceId face, double from, double to) const {
    std::array<double, 2> sum{}, count{};
    const auto add = [&](const Vec2& p) {
        const double off = chart_angle(p.x()) - 0.5 * (from + to);
        const bool is_over = std::abs(std::remainder(off, 2 * std::numbers::pi)) <= 0.5 * (to - from);
        sum[is_over] += p.y();
        ++count[is_over];
    };
    loops_.around(face, [&](EdgeId e, bool) {
        if (const VertexId start = diagram_.start(e); start.valid()) add(diagram_.vertices[start].point);
        for (const auto& piece : diagram_.pieces(e)) add(piece.end);
    });
    if (count[1] > 0) return sum[1] / count[1];
    return count[0] > 0 ? sum[0] / count[0] : 0.5 * (problem_.stretch[0] + problem_.stretch[1]);
}

std::vector<double> CylinderTurns::of_vertices(FaceId face) const {
    std::vector<double> angles;
    loops_.around(face, [&](EdgeId e, bool) {
        if (const VertexId start = diagram_.start(e); start.valid())
            angles.push_back(chart_angle(diagram_.vertices[start].point.x()));
    });
    return angles;
}

double clear_angle(std::vector<double> angles, std::size_t count) {
    const double width = 2 * std::numbers::pi / static_cast<double>(count);
    if (angles.empty()) return off_middle;
    for (double& angle : angles) angle -= width * std::floor(angle / width);
    std::ranges::sort(angles);
    angles.push_back(angles.front() + width);
    std::size_t widest = 0;
    for (std::size_t i = 0; i + 1 < angles.size(); ++i)
        if (angles[i + 1] - angles[i] > angles[widest + 1] - angles[widest]) widest = i;
    return std::lerp(angles[widest], angles[widest + 1], off_middle);
}

std::array<double, 2> CylinderTurns::along(EdgeId e) const {
    constexpr double whole = 2 * std::numbers::pi;
    const MinimizationDiagram::Edge& edge = diagram_.edges[e];
    const VertexId start = diagram_.start(e), end = diagram_.end(e);
    const auto pieces = diagram_.pieces(e);
    const auto angle_at = [&](VertexId v) { return chart_angle(diagram_.vertices[v].point.x()); };
    if (edge.on_rim()) {
        const double sign = rim_sign(edge);
        if (!start.valid()) return {0, sign * whole};
        return {angle_at(start), sign * rim_turn(start, end, sign)};
    }
    const double from = start.valid() ? angle_at(start) : chart_angle(pieces.back().end.x());
    double turn = 0, last = from;
    for (std::size_t i = 0; i < pieces.size(); ++i) {
        const bool is_end = i + 1 == pieces.size() && end.valid();
        const double next = is_end ? angle_at(end) : chart_angle(pieces[i].end.x());
        turn += turn_along(pieces[i], last, next);
        last = next;
    }
    return {from, turn};
}

}  // namespace vcell::radial
