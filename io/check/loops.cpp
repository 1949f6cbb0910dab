#include "loops.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "../pictures/trims.hpp"
#include "room.hpp"

namespace vcell::check {
namespace {

class Loops : public Room {
public:
    using Room::Room;

    void run() {
        for (const Patch& patch : patches_)
            for (std::size_t l = 0; l < patch.loops.size(); ++l) {
                const auto where = [&] { return loop_path(patch.face, patch.index, l); };
                begins_.clear();
                for (const Trim& trim : patch.loops[l]) {
                    const Vec2 uv = trim.pieces.front().control(0);
                    begins_.push_back(lift(patch, uv.cwiseMax(patch.lo).cwiseMin(patch.hi)));
                }
                check_head_to_tail(patch, patch.loops[l], where);
                if (is_as_small_as_rounding(patch)) continue;
                const int turn = orientation(patch, patch.loops[l]);
                if (l == 0 && turn < 0) note(where(), "the outer loop does not run counter-clockwise");
                if (l > 0 && turn > 0) note(where(), "a hole does not run clockwise");
                if (l > 0 && is_outside(patch, patch.loops[l]))
                    note(where(), "a hole outside the outer loop");
            }
        check_cycles();
    }

private:
    /// The sign of a loop's area: that of the polygon through points of it, if it is larger than what lies
    /// between the chords and the curves, of which each stays in the hull of its control points, and than a
    /// band along the loop as wide as rounding of these points and the errors of their edges. 0: the parts
    /// are too small to tell.
    int orientation(const Patch& patch, const std::vector<Trim>& loop) const {
        double off = kPlaceRounding * patch.lo.cwiseAbs().cwiseMax(patch.hi.cwiseAbs()).maxCoeff();
        for (std::size_t i = 0; i < loop.size(); ++i)
            off = std::max(off, loop[i].error * parameters_per_length(begins_[i]).maxCoeff());
        const Vec2 origin = loop.front().pieces.front().control(0);
        struct Polygon {
            double area = 0, between = 0, length = 0;

            void add(const Bezier<2>& part, const Vec2& origin) {
                const std::size_t last = part.points.size() - 1;
                const Vec2 p = part.control(0) - origin, q = part.control(last) - origin, chord = q - p;
                area += p.x() * q.y() - p.y() * q.x();
                length += chord.norm();
                // A hull's area is at most that of the rectangle along the chord and its ends' offsets.
                double above = 0, below = 0, before = 0, after = chord.squaredNorm();
                for (std::size_t i = 1; i < last; ++i) {
                    const Vec2 m = part.control(i) - origin - p;
                    const double aside = chord.x() * m.y() - chord.y() * m.x(), along = chord.dot(m);
                    above = std::max(above, aside);
                    below = std::min(below, aside);
                    before = std::min(before, along);
                    after = std::max(after, along);
                }
                if (above > below)
                    between += 2 * (above - below) *
                               (chord.squaredNorm() > 0 ? (after - before) / chord.squaredNorm() : HUGE_VAL);
            }
        };
        const auto sign_of = [&](const Polygon& polygon) {
            const double rest = polygon.between + 2 * off * polygon.length;
            return polygon.area > rest ? 1 : polygon.area < -rest ? -1 : 0;
        };
        Polygon whole;
        for (const Trim& trim : loop)
            for (const auto& part : trim.pieces) whole.add(part, origin);
        if (const int sign = sign_of(whole)) return sign;
        std::vector<Bezier<2>> parts, halves;
        constexpr int most_halvings = 7;
        for (int k = 0; k < most_halvings; ++k) {
            halves.clear();
            Polygon finer;
            const auto halve = [&](const Bezier<2>& part) {
                for (auto& half : part.halves()) {
                    finer.add(half, origin);
                    halves.push_back(std::move(half));
                }
            };
            if (k == 0) {
                halves.reserve(2 * loop.size());
                for (const Trim& trim : loop) std::ranges::for_each(trim.pieces, halve);
            } else {
                halves.reserve(2 * parts.size());
                std::ranges::for_each(parts, halve);
            }
            if (const int sign = sign_of(finer)) return sign;
            parts.swap(halves);
        }
        return 0;
    }
    static bool is_outside(const Patch& patch, const std::vector<Trim>& hole) {
        const Vec2 q = hole.front().pieces.front().control(0), near = kPlaceRounding * (patch.hi - patch.lo);
        double turn = 0;
        for (const Trim& trim : patch.loops[0])
            for (const auto& piece : trim.pieces) {
                const auto angle = swept(piece, q, near);
                if (!angle) return false;  // where loops touch, edges are judged
                turn += *angle;
            }
        return turn < std::numbers::pi;
    }
    /// All around a face its edges are closed, whatever seams cut them: at each vertex as many come as go.
    void check_cycles() {
        struct End {
            std::size_t face;
            std::uint32_t vertex;
            int step;
        };
        std::vector<End> ends;
        ends.reserve(4 * subject_.edges.size());
        for (const std::uint32_t e : subject_.edges) {
            const auto& vertices = cell_.edges[e].vertices;
            if (vertices.empty() || vertices[0] == vertices[1]) continue;
            for (const auto& use : uses_[e])
                for (const int end : {0, 1})
                    ends.push_back({use.face, vertices[static_cast<std::size_t>(end)],
                                    (end == 1) == use.reversed ? -1 : 1});
        }
        const auto key = [](const End& end) { return std::pair(end.face, end.vertex); };
        std::ranges::sort(ends, {}, key);
        for (std::size_t first = 0, next = 0; first < ends.size(); first = next) {
            int sum = 0;
            for (; next < ends.size() && key(ends[next]) == key(ends[first]); ++next) sum += ends[next].step;
            if (sum != 0)
                note(face_path(ends[first].face),
                     fmt::format("its edges are not closed at vertex {}", ends[first].vertex));
        }
    }
    // Of faces between objects that all but meet: which way their loops run is not in the numbers.
    static bool is_as_small_as_rounding(const Patch& patch) {
        const Eigen::Array2d place = patch.lo.cwiseAbs().cwiseMax(patch.hi.cwiseAbs());
        return ((patch.hi - patch.lo).array() <= kPlaceRounding * place).any();
    }
    std::optional<std::uint32_t> end_vertex(const Trim& trim, bool at_end) const {
        if (!trim.curve->edge) return std::nullopt;
        const CellEdge& edge = cell_.edges[*trim.curve->edge];
        if (edge.vertices.empty()) return std::nullopt;
        const double t = edge_parameter(*trim.curve, edge.curve, at_end ? trim.end() : trim.begin());
        const double near = kPlaceRounding * (edge.curve.domain_end() - edge.curve.domain_begin());
        if (std::abs(t - edge.curve.domain_begin()) <= near) return edge.vertices[0];
        if (std::abs(t - edge.curve.domain_end()) <= near) return edge.vertices[1];
        return std::nullopt;
    }
    template <class Where>
    void check_head_to_tail(const Patch& patch, const std::vector<Trim>& loop, const Where& where) {
        for (std::size_t i = 0; i < loop.size(); ++i) {
            const Trim &trim = loop[i], &next = loop[(i + 1) % loop.size()];
            const auto head = end_vertex(trim, true), tail = end_vertex(next, false);
            if (trim.curve->edge && next.curve->edge && head != tail)
                return note(where(),
                            fmt::format("curve {} does not end at the vertex where the next one starts", i));
            const Vec2 a = evaluate(trim.pieces, trim.end()), b = evaluate(next.pieces, next.begin());
            if (a == b) continue;
            const SurfacePoint s = lift(patch, a);
            const double gap = (begins_[(i + 1) % loop.size()].p - s.p).norm();
            const double errors = trim.error + next.error + (head ? 2 * cell_.vertices[*head].error : 0);
            if (gap > errors + surface_rounding(patch, s, a))
                return note(where(), fmt::format("gap of {:.3g} after curve {}", gap, i));
        }
    }

    std::vector<SurfacePoint> begins_;  // where the curves of the loop under judgement start
};

}  // namespace

void certify_loops(const Subject& subject, const CheckOptions& options, Certificate& certificate) {
    Loops(subject, options, certificate).run();
}

}  // namespace vcell::check
