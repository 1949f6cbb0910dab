#include "entries.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace vcell::check {
namespace {

class Entries : public Room {
public:
    Entries(const Subject& subject, std::span<const EdgeBound> edges, const CheckOptions& options,
            Certificate& certificate)
        : Room(subject, options, certificate), edge_bounds_(edges) {}

    void run() {
        bool is_proved = true;
        for (std::uint32_t s = 0; s < 6 && is_proved; ++s)
            if (geometry_.lets_in(Site::box_side(s))) is_proved = judge(s) && are_single();
        if (is_proved) certificate_.prove(where());
    }

private:
    /// A part of a side, along its two axes, and what of the objects may have the least excess somewhere in
    /// it.
    struct Part {
        Vec2 lo, hi;
        std::vector<Condition> conditions;
    };

    std::string where() const { return subject_.path("entries"); }

    /// How far an edge's curve is from the true one, as far as that is proved, or stated.
    double error(std::size_t edge) const { return std::min(edge_bounds_[edge].distance, full_error(edge)); }

    bool judge(std::uint32_t side) {
        side_ = Site::box_side(side);
        const auto along = static_cast<Eigen::Index>(side / 2);
        across_ = {(along + 1) % 3, (along + 2) % 3};
        bound_ = (side % 2 == 0 ? scene_.box.min : scene_.box.max)[along];
        find_edges();
        Part whole{{scene_.box.min[across_[0]], scene_.box.min[across_[1]]},
                   {scene_.box.max[across_[0]], scene_.box.max[across_[1]]},
                   {}};
        whole_lo_ = whole.lo;
        whole_hi_ = whole.hi;
        for (std::uint32_t i = 0; i < scene_.objects.size(); ++i)
            if (scene_.competes(i))
                space().for_conditions(Site::object(i),
                                       [&](const Condition& c) { whole.conditions.push_back(c); });
        conditions_ = whole.conditions;
        std::vector<Part> parts{std::move(whole)};
        const std::size_t most = std::size_t{64} << std::clamp(options_.effort, 0, 20);
        for (std::size_t count = 0; !parts.empty(); ++count) {
            Part part = std::move(parts.back());
            parts.pop_back();
            if (is_told(part)) continue;
            if (count > most) {
                const Vec3 p = at(0.5 * (part.lo + part.hi));
                certificate_.leave_open(where(),
                                        fmt::format("rays that come in through {} around ({}, {}, {}) may be "
                                                    "missing",
                                                    title(side_), p.x(), p.y(), p.z()),
                                        HUGE_VAL);
                return false;
            }
            const Eigen::Index axis = part.hi.x() - part.lo.x() >= part.hi.y() - part.lo.y() ? 0 : 1;
            Part other = part;
            part.hi[axis] = other.lo[axis] = 0.5 * part.lo[axis] + 0.5 * part.hi[axis];
            parts.push_back(std::move(part));
            parts.push_back(std::move(other));
        }
        return true;
    }

    /// Edges of faces on this side that run inside it: with an object on their other side.
    void find_edges() {
        edges_.clear();
        for (std::size_t e = 0; e < uses_.size(); ++e) {
            const auto is_here = [&](const Subject::Use& use) {
                return cell_.faces[use.face].site == side_ && subject_.is_entered(use.face);
            };
            const auto is_elsewhere = [&](const Subject::Use& use) {
                return cell_.faces[use.face].site.is_object();
            };
            if (std::ranges::any_of(uses_[e], is_here) && std::ranges::any_of(uses_[e], is_elsewhere))
                edges_.push_back(e);
        }
    }

    Vec3 at(const Vec2& q) const {
        Vec3 p = Vec3::Constant(bound_);
        p[across_[0]] = q.x();
        p[across_[1]] = q.y();
        return p;
    }
    Vec2 in_side(const Vec3& p) const { return {p[across_[0]], p[across_[1]]}; }

    bool is_told(Part& part) const {
        const Vector<Interval> box = box_over(part.lo, part.hi);
        std::vector<Vector<Interval>> inwards;
        if (geometry_.is_plane()) {
            const Interval height = space().clearance(box);
            if (height.upper() <= rounding()) return true;
            if (height.lower() <= rounding()) inwards.push_back(space().up(box));
        }
        for (std::uint32_t end = 0; geometry_.is_cylinder() && end < 2; ++end) {
            const Interval room = space().inside_end(end, box);
            if (room.upper() < 0) return true;
            if (room.lower() <= 0) inwards.push_back(space().gradient({Site::end(end)}, box));
        }
        double least = HUGE_VAL;
        std::vector<Interval> excesses;
        for (const Condition& c : part.conditions) {
            excesses.push_back(space().excess(c, box));
            if (excesses.back().upper() <= tie_width(c.site)) return true;
            least = std::min(least, excesses.back().upper());
        }
        std::size_t kept = 0;
        for (std::size_t i = 0; i < excesses.size(); ++i)
            if (excesses[i].lower() <= least) part.conditions[kept++] = part.conditions[i];
        part.conditions.resize(kept);
        return is_covered(part) || has_no_maximum(part, box, inwards) || hangs_together(part);
    }
    Vector<Interval> box_over(const Vec2& lo, const Vec2& hi) const {
        Vector<Interval> box = to_vector<Interval>(Vec3::Constant(bound_));
        for (const Eigen::Index k : {0, 1})
            box[static_cast<std::size_t>(across_[static_cast<std::size_t>(k)])] = {lo[k], hi[k]};
        return box;
    }

    /// Is there a part in F, a little beside it, and f > 0 all the way there? F ends where f = 0, and W is
    /// convex. Next to an edge nothing else tells that a part is in F, where f has no maximum: it is as good
    /// as constant on a ray away from a twin of the base.
    bool hangs_together(const Part& part) const {
        constexpr double farther = 4;
        constexpr int most_steps = 6;
        double step = 2 * std::max(rounding(), kNearEdge * (whole_hi_ - whole_lo_).maxCoeff());
        for (const std::size_t e : edges_)
            if (may_meet(e, part)) step = std::max(step, 2 * error(e));
        if (!((part.hi - part.lo).maxCoeff() < step)) return false;
        for (int k = 0; k < most_steps; ++k, step *= farther)
            for (const Vec2& d : {Vec2(1, 0), Vec2(-1, 0), Vec2(0, 1), Vec2(0, -1), Vec2(1, 1), Vec2(-1, 1),
                                  Vec2(1, -1), Vec2(-1, -1)}) {
                const Part beside{part.lo + step * d, part.hi + step * d, {}};
                const Vec2 lo = part.lo.cwiseMin(beside.lo), hi = part.hi.cwiseMax(beside.hi);
                if (is_in_front(beside) && is_covered(beside) && is_positive_over(box_over(lo, hi)))
                    return true;
            }
        return false;
    }
    /// Is a part in W?
    bool is_in_front(const Part& part) const {
        if ((part.lo.array() < whole_lo_.array()).any() || (part.hi.array() > whole_hi_.array()).any())
            return false;
        const Vector<Interval> box = box_over(part.lo, part.hi);
        if (geometry_.is_plane()) return space().clearance(box).lower() > rounding();
        return space().inside_end(0, box).lower() > 0 && space().inside_end(1, box).lower() > 0;
    }
    bool is_positive_over(const Vector<Interval>& box) const {
        return std::ranges::all_of(conditions_,
                                   [&](const Condition& c) { return space().excess(c, box).lower() > 0; });
    }

    // --- In F -----------------------------------------------------------------------------------------

    /// May an edge, as far as it is known, run through a part?
    bool may_meet(std::size_t e, const Part& part) const {
        constexpr int halvings = 32;
        return std::ranges::any_of(edge_pieces_[e], [&](const auto& piece) {
            return may_meet(piece, error(e) + rounding(), part, halvings);
        });
    }
    bool may_meet(const Bezier<3>& piece, double error, const Part& part, int depth) const {
        Vec2 lo = Vec2::Constant(HUGE_VAL), hi = -lo;
        for (std::size_t i = 0; i < piece.points.size(); ++i) {
            lo = lo.cwiseMin(in_side(piece.control(i)));
            hi = hi.cwiseMax(in_side(piece.control(i)));
        }
        const Vec2 off = Vec2::Constant(error);
        if (((lo - off).array() > part.hi.array()).any() || ((hi + off).array() < part.lo.array()).any())
            return false;
        // Pieces a good deal smaller than the part tell no more.
        if (depth == 0 || ((hi - lo).array() < 0.25 * (part.hi - part.lo).array()).all()) return true;
        return std::ranges::any_of(piece.halves(),
                                   [&](const auto& half) { return may_meet(half, error, part, depth - 1); });
    }
    bool is_covered(const Part& part) const {
        if (std::ranges::any_of(edges_, [&](std::size_t e) { return may_meet(e, part); })) return false;
        const std::optional<Vec2> middle = middle_in_front(part);
        if (!middle) return false;
        const Vec3 p = at(*middle);
        for (const Patch& patch : patches_) {
            if (cell_.faces[patch.face].site != side_ || !subject_.is_entered(patch.face)) continue;
            const auto uv = place_on(patch, p);
            if (uv && inside(patch, *uv, rounding()).value_or(false)) return true;
        }
        return false;
    }

    /// How far in front of a base plane, or inside an end of a tube's part.
    double room_of(std::uint32_t bound, const Vec2& q) const {
        const Vec3 p = at(q);
        return geometry_.is_plane() ? height(p) - rounding() : geometry_.excess(Site::end(bound), p, 0);
    }

    /// A point of the part in W: amid the corners of what lies there, if anything does.
    std::optional<Vec2> middle_in_front(const Part& part) const {
        std::vector<Vec2> corners{part.lo, Vec2(part.hi.x(), part.lo.y()), part.hi,
                                  Vec2(part.lo.x(), part.hi.y())};
        const std::uint32_t bounds = geometry_.is_plane() ? 1 : 2;
        for (std::uint32_t bound = 0; bound < bounds; ++bound) {
            std::vector<Vec2> kept;
            for (std::size_t k = 0; k < corners.size(); ++k) {
                const Vec2 &p = corners[k], &q = corners[(k + 1) % corners.size()];
                const double a = room_of(bound, p), b = room_of(bound, q);
                if (a > 0) kept.push_back(p);
                if ((a > 0) != (b > 0)) kept.push_back(p + a / (a - b) * (q - p));
            }
            corners = std::move(kept);
        }
        Vec2 sum = Vec2::Zero();
        for (const Vec2& q : corners) sum += q / static_cast<double>(corners.size());
        for (std::uint32_t bound = 0; bound < bounds; ++bound)
            if (corners.empty() || !(room_of(bound, sum) > 0)) return std::nullopt;
        return sum;
    }

    /// Where a point of the side is on a patch, which is bilinear in a parallelogram: a plane's.
    static std::optional<Vec2> place_on(const Patch& patch, const Vec3& p) {
        Vec2 uv = 0.5 * (patch.lo + patch.hi);
        for (int step = 0; step < 8; ++step) {
            const SurfacePoint s = lift(patch, uv);
            Eigen::Matrix<double, 3, 2> slopes;
            slopes << s.pu, s.pv;
            const Eigen::Matrix2d square = slopes.transpose() * slopes;
            const Vec2 move = square.inverse() * (slopes.transpose() * (p - s.p));
            if (!move.allFinite()) return std::nullopt;
            uv += move;
        }
        return uv;
    }

    // --- Nothing twice ----------------------------------------------------------------------------------

    bool are_single() {
        std::vector<const Patch*> here;
        for (const Patch& patch : patches_)
            if (cell_.faces[patch.face].site == side_ && subject_.is_entered(patch.face))
                here.push_back(&patch);
        return std::ranges::all_of(here, [&](const Patch* patch) { return is_single(*patch, here); });
    }

    /// Points inside a patch are looked for beside its curves, ever nearer to them.
    bool is_single(const Patch& patch, const std::vector<const Patch*>& here) {
        constexpr int most_halvings = 20;
        for (int k = 3; k <= most_halvings; ++k)
            for (const auto& loop : patch.loops)
                for (const Trim& trim : loop)
                    for (const Bezier<2>& piece : trim.pieces) {
                        const auto [q, way] = piece.evaluate(0.5 * piece.begin + 0.5 * piece.end);
                        const Vec2 aside(-way.y(), way.x());
                        const Vec2 uv = q + std::ldexp(1.0, -k) * (piece.end - piece.begin) * aside;
                        if (!inside(patch, uv, rounding()).value_or(false)) continue;
                        const std::optional<std::size_t> other = other_face(patch, uv, here);
                        if (!other) continue;
                        if (*other == patch.face) return true;
                        note(where(), fmt::format("faces {} and {} overlap", patch.face, *other));
                        return false;
                    }
        if (is_thin(patch)) return true;
        certificate_.leave_open(where(), fmt::format("no point is found inside face {}", patch.face),
                                HUGE_VAL);
        return false;
    }
    /// Has the patch's face no more area than its edges may be off by? Twice that says no more than they do.
    bool is_thin(const Patch& patch) const {
        double off = rounding(), length = 0;
        for (const auto& loop : patch.loops)
            for (const Trim& trim : loop) {
                if (!trim.curve->edge) return false;
                off = std::max(off, error(*trim.curve->edge));
                length += cell_.edges[*trim.curve->edge].length;
            }
        return cell_.faces[patch.face].area <= 2 * off * length;
    }
    /// Another face that the point lies in; the patch's own if it is in none. None: it is too near to the
    /// boundary of one.
    std::optional<std::size_t> other_face(const Patch& patch, const Vec2& uv,
                                          const std::vector<const Patch*>& here) const {
        const Vec3 p = lift(patch, uv).p;
        for (const Patch* other : here) {
            if (other == &patch) continue;
            const auto place = place_on(*other, p);
            const auto is_inside = place ? inside(*other, *place, rounding()) : std::nullopt;
            if (!is_inside) return std::nullopt;
            if (*is_inside) return other->face;
        }
        return patch.face;
    }

    // --- No maximum -------------------------------------------------------------------------------------

    /// `inwards`: into W across its bounds that may meet the part.
    bool has_no_maximum(const Part& part, const Vector<Interval>& box,
                        const std::vector<Vector<Interval>>& inwards) const {
        std::vector<std::array<Interval, 2>> grow;  // along the side, in rows: all that must
        const auto add = [&](const Vector<Interval>& g) {
            grow.push_back(
                {g[static_cast<std::size_t>(across_[0])], g[static_cast<std::size_t>(across_[1])]});
        };
        for (const Vector<Interval>& way : inwards) add(way);
        for (const Condition& c : part.conditions) add(space().gradient(c, box));
        std::vector<Vec2> ways;
        for (const auto& g : grow) ways.push_back(Vec2(g[0].mid(), g[1].mid()).normalized());
        const auto leads_out = [&](const Vec2& d) {
            for (const Eigen::Index k : {0, 1})
                if ((d[k] < 0 && part.lo[k] <= whole_lo_[k]) || (d[k] > 0 && part.hi[k] >= whole_hi_[k]))
                    return true;
            return false;
        };
        const auto serves = [&](const Vec2& d) {
            return d.allFinite() && !leads_out(d) && std::ranges::all_of(grow, [&](const auto& g) {
                       return (d.x() * g[0] + d.y() * g[1]).lower() > 0;
                   });
        };
        if (grow.empty()) return false;
        const std::size_t n = std::min<std::size_t>(ways.size(), 8);
        for (std::size_t i = 0; i < n; ++i)
            for (std::size_t j = 0; j <= i; ++j)
                if (serves((ways[i] + ways[j]).normalized())) return true;
        for (const Vec2& d : {Vec2(1, 0), Vec2(-1, 0), Vec2(0, 1), Vec2(0, -1)})
            if (serves(d)) return true;
        return false;
    }

    Site side_;
    std::vector<Condition> conditions_;   // of all objects
    std::array<Eigen::Index, 2> across_;  // its axes
    double bound_ = 0;                    // its coordinate along the third
    Vec2 whole_lo_, whole_hi_;
    std::vector<std::size_t> edges_;
    std::span<const EdgeBound> edge_bounds_;
};

}  // namespace

void certify_entries(const Subject& subject, std::span<const EdgeBound> edges, const CheckOptions& options,
                     Certificate& certificate) {
    if (subject.cell.is_complete) Entries(subject, edges, options, certificate).run();
}

}  // namespace vcell::check
