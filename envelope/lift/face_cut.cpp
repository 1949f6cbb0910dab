#include "face_cut.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "joined_spans.hpp"

namespace vcell {

namespace {

using Eigen::Vector3d;

struct Crossing {
    double v;
    bool rightwards;  // out of the sector on the side's left
    std::uint32_t from, to;
};

class Cutter {
public:
    Cutter(const std::vector<std::vector<BoundaryRun>>& loops, std::span<const double> reaches,
           std::uint32_t& seams)
        : reaches_(reaches), seams_(seams), sides_(reaches.size()) {
        for (const auto& loop : loops) add_loop(loop);
        for (std::vector<Crossing>& crossings : sides_) is_closed_ = is_closed_ && add_seams(crossings);
    }

    std::optional<std::vector<CutPart>> parts() {
        if (!is_closed_) return std::nullopt;
        std::vector<std::vector<TrimCurve>> holes;
        std::vector<std::uint32_t> hole_sectors;
        std::vector<CutPart> result;
        std::vector<bool> is_done(runs_.size());
        for (std::uint32_t first = 0; first < runs_.size(); ++first) {
            if (is_done[first]) continue;
            const std::uint32_t sector = runs_[first].sector;
            std::vector<TrimCurve> loop;
            for (std::uint32_t i = first; !is_done[i]; i = next_[i]) {
                is_done[i] = true;
                loop.push_back(std::move(runs_[i].trim));
            }
            if (signed_area(loop) > 0) {
                result.push_back({sector, {}});
                result.back().loops.push_back(std::move(loop));
            } else {
                holes.push_back(std::move(loop));
                hole_sectors.push_back(sector);
            }
        }
        for (std::size_t i = 0; i < holes.size(); ++i) {
            const Vec2 inside = holes[i].front().curve.evaluate(holes[i].front().curve.domain_begin());
            const auto owner = std::ranges::find_if(result, [&](const CutPart& part) {
                return part.sector == hole_sectors[i] && goes_round(part.loops.front(), inside);
            });
            if (owner == result.end()) return std::nullopt;
            owner->loops.push_back(std::move(holes[i]));
        }
        return result;
    }

private:
    static Vec2 start(const BoundaryRun& r) { return r.trim.curve.points.front().head<2>(); }
    static Vec2 end(const BoundaryRun& r) { return r.trim.curve.points.back().head<2>(); }

    void add_loop(const std::vector<BoundaryRun>& loop) {
        const auto first = static_cast<std::uint32_t>(runs_.size());
        for (std::uint32_t i = 0; i < loop.size(); ++i) {
            const std::uint32_t at = first + i,
                                to = first + (i + 1) % static_cast<std::uint32_t>(loop.size());
            const BoundaryRun &run = loop[i], &following = loop[(i + 1) % loop.size()];
            runs_.push_back(run);
            next_.push_back(to);
            if (run.sector == following.sector) continue;
            // Side i lies between sectors i - 1 and i; heights are compared in the sector on its left.
            if (end(run).x() > 0)
                sides_[(run.sector + 1) % sides_.size()].push_back({end(run).y(), true, at, to});
            else
                sides_[run.sector].push_back({start(following).y(), false, at, to});
        }
    }

    // The face lies above a curve that runs to the right and below one that runs to the left: else they do
    // not enclose it.
    bool add_seams(std::vector<Crossing>& crossings) {
        std::ranges::sort(crossings, {}, &Crossing::v);
        for (std::size_t i = 0; i < crossings.size(); i += 2) {
            if (i + 1 == crossings.size() || !crossings[i].rightwards || crossings[i + 1].rightwards)
                return false;
            const Crossing &low = crossings[i], &high = crossings[i + 1];
            add_seam(low.from, high.to, 1);
            add_seam(high.from, low.to, -1);
            ++seams_;
        }
        return true;
    }

    void add_seam(std::uint32_t from, std::uint32_t to, double side) {
        const double u = side * reaches_[runs_[from].sector];
        RationalCurve2 curve;
        begin_joined(curve, 1, 1);
        curve.points = {{u, end(runs_[from]).y(), 1}, {u, start(runs_[to]).y(), 1}};
        next_[from] = static_cast<std::uint32_t>(runs_.size());
        next_.push_back(to);
        runs_.push_back({{{}, seams_, false, std::move(curve)}, runs_[from].sector});
    }

    // Calls use(point) along a loop, finely enough for its shape.
    template <class Use>
    static void walk(const std::vector<TrimCurve>& loop, Use use) {
        for (const TrimCurve& trim : loop) {
            const RationalCurve2& c = trim.curve;
            const std::size_t steps = c.degree == 1 ? 1 : 4 * (c.points.size() / c.degree);
            for (std::size_t k = 0; k < steps; ++k)
                use(c.evaluate(std::lerp(c.domain_begin(), c.domain_end(),
                                         static_cast<double>(k) / static_cast<double>(steps))));
        }
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

    const std::span<const double> reaches_;
    std::uint32_t& seams_;
    std::vector<BoundaryRun> runs_;
    std::vector<std::uint32_t> next_;
    std::vector<std::vector<Crossing>> sides_;
    bool is_closed_ = true;
};

}  // namespace

std::optional<std::vector<CutPart>> cut_face(const std::vector<std::vector<BoundaryRun>>& loops,
                                             std::span<const double> reaches, std::uint32_t& seams) {
    return Cutter(loops, reaches, seams).parts();
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
