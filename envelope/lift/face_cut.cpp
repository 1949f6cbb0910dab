#include "face_cut.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

#include "joined_spans.hpp"

namespace vcell {

namespace {

using Eigen::Vector3d;

Vec2 start(const BoundaryRun& r) { return r.trim.curve.points.front().head<2>(); }
Vec2 end(const BoundaryRun& r) { return r.trim.curve.points.back().head<2>(); }

// Where the boundary crosses a seam.
struct Crossing {
    double place;      // along the seam, ascending with what is before it on the left
    bool is_outwards;  // of what is before the seam
    std::uint32_t from, to;
};

// What is in place i is before seam i + 1, and beyond seam i.
class SectorSides {
public:
    explicit SectorSides(std::span<const CutSector> sectors) : sectors_(sectors) {
        for (const CutSector& s : sectors) {
            if (s.place >= sharing_.size()) sharing_.resize(s.place + 1, none);
            sharing_[s.place] = sharing_[s.place] == none ? alone : shared;
        }
    }

    std::size_t count() const { return sharing_.size(); }
    // Heights are compared in the sector before the seam; where that has not its place for itself, in the one
    // beyond.
    std::pair<std::size_t, Crossing> crossing(const BoundaryRun& run, const BoundaryRun& next) const {
        const bool is_outwards = end(run).x() > 0;
        const std::uint32_t before = sectors_[(is_outwards ? run : next).within].place;
        const bool in_run = is_outwards == (sharing_[before] == alone);
        return {(before + 1) % count(), {in_run ? end(run).y() : start(next).y(), is_outwards, 0, 0}};
    }
    bool settle(std::vector<Crossing>&) const { return true; }
    RationalCurve2 seam(const Crossing&, const Crossing&, bool is_before, const BoundaryRun& from,
                        const BoundaryRun& to) const {
        const double reach = sectors_[from.within].reach, u = is_before ? reach : -reach;
        RationalCurve2 curve;
        begin_joined(curve, 1, 1);
        curve.points = {{u, end(from).y(), 1}, {u, start(to).y(), 1}};
        return curve;
    }

private:
    enum Sharing : char { none, alone, shared };

    std::span<const CutSector> sectors_;
    std::vector<Sharing> sharing_;
};

// The first half is before the circle.
class CircleSides {
public:
    explicit CircleSides(const CirclePoint& at) : at_(at) {}

    static constexpr double whole = 2 * std::numbers::pi;

    std::size_t count() const { return 1; }
    std::pair<std::size_t, Crossing> crossing(const BoundaryRun& run, const BoundaryRun& next) const {
        const bool is_outwards = run.within == 0;
        const Vec2 p = is_outwards ? end(run) : start(next);
        return {0, {std::atan2(p.y(), p.x()), is_outwards, 0, 0}};
    }
    // The face is between one crossing outwards and the next one inwards.
    bool settle(std::vector<Crossing>& all) const {
        constexpr double near = 0x1p-32;
        if (all.empty()) return true;
        if (!all.front().is_outwards) {
            std::ranges::rotate(all, all.begin() + 1);
            all.back().place += whole;
        }
        for (std::size_t i = 0; i < all.size(); ++i) {
            const double next = i + 1 < all.size() ? all[i + 1].place : all.front().place + whole;
            if (!(next - all[i].place > near)) return false;
        }
        return true;
    }
    RationalCurve2 seam(const Crossing& low, const Crossing& high, bool is_before, const BoundaryRun& from,
                        const BoundaryRun& to) const {
        RationalCurve2 curve = arc(low.place, high.place, is_before);
        curve.points.front().head<2>() = end(from);
        curve.points.back().head<2>() = start(to);
        return curve;
    }
    RationalCurve2 circle(bool is_before) const {
        RationalCurve2 curve = arc(0, whole, is_before);
        curve.points.back() = curve.points.front();
        return curve;
    }

private:
    // In quarters of the circle at most; both halves' run against each other in one parameter.
    RationalCurve2 arc(double from, double to, bool is_before) const {
        constexpr double widest = whole / 4 * (1 + 0x1p-20);
        const auto count = static_cast<std::size_t>(std::ceil((to - from) / widest));
        const double step = (to - from) / static_cast<double>(2 * count), weight = std::cos(step);
        RationalCurve2 curve;
        begin_joined(curve, 2, count);
        for (std::size_t k = 0; k <= 2 * count; ++k) {
            const double w = k % 2 == 0 ? 1 : weight;
            const Vec2 p = at_(from + step * static_cast<double>(k), is_before ? 0 : 1) / w;
            curve.points.push_back({p.x(), p.y(), w});
        }
        if (!is_before) std::ranges::reverse(curve.points);
        return curve;
    }

    const CirclePoint& at_;
};

template <class Sides>
class Cutter {
public:
    Cutter(const std::vector<std::vector<BoundaryRun>>& loops, const Sides& sides, std::uint32_t& seams)
        : sides_(sides), seams_(seams), crossings_(sides.count()) {
        for (const auto& loop : loops) add_loop(loop);
        for (std::vector<Crossing>& crossings : crossings_) is_closed_ = is_closed_ && add_seams(crossings);
        if constexpr (requires { sides.circle(true); })
            if (crossings_[0].empty()) add_circle(loops);
    }

    std::optional<std::vector<CutPart>> parts() {
        if (!is_closed_) return std::nullopt;
        std::vector<std::vector<TrimCurve>> holes;
        std::vector<std::uint32_t> within_holes;
        std::vector<CutPart> result;
        std::vector<bool> is_done(runs_.size());
        for (std::uint32_t first = 0; first < runs_.size(); ++first) {
            if (is_done[first]) continue;
            const std::uint32_t within = runs_[first].within;
            std::vector<TrimCurve> loop;
            for (std::uint32_t i = first; !is_done[i]; i = next_[i]) {
                is_done[i] = true;
                loop.push_back(std::move(runs_[i].trim));
            }
            if (signed_area(loop) > 0) {
                result.push_back({within, {}});
                result.back().loops.push_back(std::move(loop));
            } else {
                holes.push_back(std::move(loop));
                within_holes.push_back(within);
            }
        }
        for (std::size_t i = 0; i < holes.size(); ++i) {
            const Vec2 inside = holes[i].front().curve.evaluate(holes[i].front().curve.domain_begin());
            const auto owner = std::ranges::find_if(result, [&](const CutPart& part) {
                return part.within == within_holes[i] && goes_round(part.loops.front(), inside);
            });
            if (owner == result.end()) return std::nullopt;
            owner->loops.push_back(std::move(holes[i]));
        }
        return result;
    }

private:
    void add_loop(const std::vector<BoundaryRun>& loop) {
        const auto first = static_cast<std::uint32_t>(runs_.size());
        for (std::uint32_t i = 0; i < loop.size(); ++i) {
            const std::uint32_t at = first + i,
                                to = first + (i + 1) % static_cast<std::uint32_t>(loop.size());
            const BoundaryRun &run = loop[i], &following = loop[(i + 1) % loop.size()];
            runs_.push_back(run);
            next_.push_back(to);
            if (run.within == following.within) continue;
            auto [side, crossing] = sides_.crossing(run, following);
            crossing.from = at;
            crossing.to = to;
            crossings_[side].push_back(crossing);
        }
    }

    // The face lies beyond a crossing outwards and before one inwards: else they do not enclose it.
    bool add_seams(std::vector<Crossing>& crossings) {
        std::ranges::sort(crossings, {}, &Crossing::place);
        if (!sides_.settle(crossings)) return false;
        for (std::size_t i = 0; i < crossings.size(); i += 2) {
            if (i + 1 == crossings.size() || !crossings[i].is_outwards || crossings[i + 1].is_outwards)
                return false;
            const Crossing &low = crossings[i], &high = crossings[i + 1];
            add_seam(low.from, high.to, sides_.seam(low, high, true, runs_[low.from], runs_[high.to]));
            add_seam(high.from, low.to, sides_.seam(low, high, false, runs_[high.from], runs_[low.to]));
            ++seams_;
        }
        return true;
    }

    void add_seam(std::uint32_t from, std::uint32_t to, RationalCurve2 curve) {
        next_[from] = static_cast<std::uint32_t>(runs_.size());
        next_.push_back(to);
        runs_.push_back({{{}, seams_, false, std::move(curve)}, runs_[from].within});
    }

    // Nothing crosses the circle: it is a seam unless the face is all on one side of it.
    void add_circle(const std::vector<std::vector<BoundaryRun>>& loops) {
        const auto encloses = [](const std::vector<BoundaryRun>& loop) {
            std::vector<TrimCurve> trims;
            for (const BoundaryRun& run : loop) trims.push_back(run.trim);
            return signed_area(trims) > 0;
        };
        if (std::ranges::any_of(loops, encloses)) return;
        for (const bool is_before : {true, false}) {
            next_.push_back(static_cast<std::uint32_t>(runs_.size()));
            runs_.push_back({{{}, seams_, false, sides_.circle(is_before)}, is_before ? 0u : 1u});
        }
        ++seams_;
    }

    // Calls use(point) along a loop, finely enough for its shape: of curved Bezier pieces at their quarters.
    template <class Use>
    static void walk(const std::vector<TrimCurve>& loop, Use use) {
        for (const TrimCurve& trim : loop) {
            const auto degree = static_cast<std::size_t>(trim.curve.degree);
            const auto& points = trim.curve.points;
            for (std::size_t first = 0; first + 1 < points.size(); first += degree) {
                use(points[first].head<2>());
                if (degree == 1) continue;
                for (const std::array<double, 6>& share : quarters(degree)) {
                    Vector3d sum = Vector3d::Zero();
                    for (std::size_t i = 0; i <= degree; ++i) {
                        const Vector3d& p = points[first + i];
                        sum += share[i] * p.z() * Vector3d(p.x(), p.y(), 1);
                    }
                    use(sum.head<2>() / sum.z());
                }
            }
        }
    }
    // Bernstein's polynomials of a degree up to 5 at the inner quarters of [0, 1].
    static const std::array<std::array<double, 6>, 3>& quarters(std::size_t degree) {
        static const auto all = [] {
            std::array<std::array<std::array<double, 6>, 3>, 6> values{};
            for (std::size_t k = 0; k < 3; ++k) {
                const double t = 0.25 * static_cast<double>(k + 1);
                values[0][k][0] = 1;
                for (std::size_t n = 1; n < values.size(); ++n)
                    for (std::size_t i = 0; i <= n; ++i)
                        values[n][k][i] =
                            (1 - t) * values[n - 1][k][i] + (i > 0 ? t * values[n - 1][k][i - 1] : 0);
            }
            return values;
        }();
        return all[degree];
    }

    static double signed_area(const std::vector<TrimCurve>& loop) {
        const Vec2 origin = loop.front().curve.points.front().head<2>();
        Vec2 last = Vec2::Zero();
        double sum = 0;
        walk(loop, [&](const Vec2& point) {
            const Vec2 p = point - origin;
            sum += last.x() * p.y() - last.y() * p.x();
            last = p;
        });
        return sum;
    }

    static bool goes_round(const std::vector<TrimCurve>& loop, const Vec2& inside) {
        std::vector<Vec2> polygon;
        walk(loop, [&](const Vec2& p) { polygon.push_back(p - inside); });
        bool odd = false;
        Vec2 last = polygon.back();
        for (const Vec2& p : polygon) {
            if ((last.y() > 0) != (p.y() > 0) &&
                (last.x() * p.y() - last.y() * p.x() > 0) == (p.y() > last.y()))
                odd = !odd;
            last = p;
        }
        return odd;
    }

    const Sides& sides_;
    std::uint32_t& seams_;
    std::vector<BoundaryRun> runs_;
    std::vector<std::uint32_t> next_;
    std::vector<std::vector<Crossing>> crossings_;  // of each side
    bool is_closed_ = true;
};

}  // namespace

std::optional<std::vector<CutPart>> cut_face(const std::vector<std::vector<BoundaryRun>>& loops,
                                             std::span<const CutSector> sectors, std::uint32_t& seams) {
    return Cutter(loops, SectorSides(sectors), seams).parts();
}

std::optional<std::vector<CutPart>> halve_face(const std::vector<std::vector<BoundaryRun>>& loops,
                                               const CirclePoint& at, std::uint32_t& seams) {
    return Cutter(loops, CircleSides(at), seams).parts();
}

std::array<std::array<double, 2>, 2> curve_bounds(const RationalCurve2& curve) {
    std::array<Range, 2> box{empty_range, empty_range};
    const std::span<const Vector3d> p = curve.points;
    if (curve.degree == 1) {
        for (const Vector3d& q : p)
            for (int i = 0; i < 2; ++i) box[i] = {std::min(box[i][0], q[i]), std::max(box[i][1], q[i])};
        return box;
    }
    for (std::size_t first = 0; first + 1 < p.size(); first += curve.degree) {
        if (curve.degree == 2) {
            const double weight = p[first + 1][2] / std::sqrt(p[first][2] * p[first + 2][2]);
            for (int i = 0; i < 2; ++i) extend(box[i], p[first][i], p[first + 1][i], p[first + 2][i], weight);
            continue;
        }
        for (int i = 0; i < 2; ++i) {
            std::array<double, 6> row;
            for (int k = 0; k <= curve.degree; ++k) row[k] = p[first + k][i];
            if (curve.degree == 3) {
                const std::array weights{p[first][2], p[first + 1][2], p[first + 2][2], p[first + 3][2]};
                extend_by_rational(box[i], {row.data(), weights.size()}, weights);
                continue;
            }
            const std::span<const double> coefficients(row.data(),
                                                       static_cast<std::size_t>(curve.degree) + 1);
            // Numbers that are none end no division; no patch holds them, nor are they proved.
            if (!std::ranges::all_of(coefficients, [](double x) { return std::isfinite(x); })) {
                box[i] = {-HUGE_VAL, HUGE_VAL};
                continue;
            }
            extend_by_polynomial(box[i], coefficients);
        }
    }
    return box;
}

}  // namespace vcell
