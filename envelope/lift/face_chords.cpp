#include "face_chords.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "joined_spans.hpp"
#include "trim_bounds.hpp"

namespace vcell::radial {

namespace {

// From the middle of the base's stretch, as good as any foot for doubles.
space_fit::Equation site_of(const RadialDiagram& of, FaceId face) {
    const FormId form = of.diagram.face_forms[face];
    const Vec3 foot(0, 0.5 * (of.problem.stretch[0] + of.problem.stretch[1]), 0);
    return space_fit::site_equation(of.problem.chart, of.problem.objects[form], is_wall(of.problem, form),
                                    foot);
}

}  // namespace

FaceChords::FaceChords(const RadialDiagram& of, const FaceLoops& loops, const FacePatches& patches,
                       const RadialCurves& curves, FaceId face)
    : of_(of), patches_(patches), face_(face), site_(site_of(of, face)) {
    for (const CcbId ccb : loops[face]) {
        std::vector<Vec3>& loop = points_.emplace_back();
        loops.around(ccb, [&](EdgeId e, bool reversed) { add_edge(e, reversed, curves, loop); });
    }
}

// The point where the next edge begins is left out.
void FaceChords::add_edge(EdgeId e, bool reversed, const RadialCurves& curves,
                          std::vector<Vec3>& loop) const {
    const MinimizationDiagram& diagram = of_.diagram;
    if (curves.is_spline(e) && !curves.splines(e).empty()) {
        constexpr int points_of_span = 4;
        const std::vector<SpaceSpan>& spans = curves.splines(e);
        for (std::size_t i = 0; i < spans.size(); ++i)
            for (int k = 0; k < points_of_span; ++k) {
                const double t = static_cast<double>(reversed ? points_of_span - k : k) / points_of_span;
                const auto& points = spans[reversed ? spans.size() - 1 - i : i].points;
                loop.emplace_back(space_fit::point(points, t).head<3>());
            }
        return;
    }
    if (diagram.edges[e].on_rim()) {
        constexpr double widest = 0x1p-3;
        const auto [from, turn] = patches_.turns().along(e);
        const Vec3 foot(0, of_.problem.stretch[diagram.edges[e].side == 0 ? 0 : 1], 0);
        const int count = std::max(1, static_cast<int>(std::ceil(std::abs(turn) / widest)));
        for (int i = 0; i < count; ++i) {
            const double part = static_cast<double>(reversed ? count - i : i) / count;
            loop.push_back(lifted(foot, patches_.turns().direction(from + part * turn)));
        }
        return;
    }
    const BaseChart& chart = of_.problem.chart;
    const auto add = [&](const Vec2& place) {
        loop.push_back(lifted(chart.foot(place), chart.normal(place)));
    };
    const auto pieces = diagram.pieces(e);
    const VertexId start = reversed ? diagram.end(e) : diagram.start(e);
    add(start.valid() ? diagram.vertices[start].point : pieces.back().end);
    for (std::size_t i = 0; i + 1 < pieces.size(); ++i) add(pieces[reversed ? pieces.size() - 2 - i : i].end);
}

Vec3 FaceChords::lifted(const Vec3& foot, const Vec3& normal) const {
    return foot + site_.distance_along(foot, normal) * normal;
}

std::vector<bool> FaceChords::too_wide() const {
    constexpr double narrow = 0x1p-3;
    const std::span<const Sector> sectors = patches_.sectors(face_);
    if (sectors.empty()) {
        Rectangle box = no_rectangle;
        for (const std::vector<Vec3>& loop : points_)
            for (const Vec3& p : loop) {
                const Vec2 q = patches_[face_].parameters(p);
                extend_by_rectangle(box, {{{q.x(), q.x()}, {q.y(), q.y()}}});
            }
        double rounding;
        return {!patches_[face_].patch(box[0], box[1], of_.problem.frame, rounding)};
    }
    std::vector<bool> result(sectors.size(), false);
    const std::optional<Runs> boundary = runs();
    if (!boundary) return result;
    std::uint32_t seams = 0;
    const auto parts = cut_face(*boundary, patches_.cut_sectors(face_), seams);
    if (!parts) return result;
    for (const CutPart& part : *parts) {
        const Sector& sector = sectors[part.within];
        if (sector.width() > narrow && !holds(sector.patch, part.loops.front())) result[part.within] = true;
    }
    return result;
}

bool FaceChords::holds(const RadialPatch& patch, const std::vector<TrimCurve>& loop) const {
    const Rectangle box = loop_domain(loop);
    double rounding;
    return patch.patch(box[0], box[1], of_.problem.frame, rounding).has_value();
}

// Straight from point to point. Where two points lie in two sectors a run ends in the side between these
// where the line to the point beyond meets it.
std::optional<FaceChords::Runs> FaceChords::runs() const {
    const std::span<const Sector> sectors = patches_.sectors(face_);
    const auto count = static_cast<std::uint32_t>(patches_.places(face_).size());
    struct Place {
        std::uint32_t within;
        Vec2 at;
    };
    Runs result;
    for (const std::vector<Vec3>& loop : points_) {
        const std::size_t n = loop.size();
        std::vector<Place> places;
        for (std::size_t i = 0; i < n; ++i) {
            // Most of them follow others in their sector.
            if (!places.empty()) {
                const std::uint32_t before = places.back().within;
                const Vec2 at = sectors[before].patch.parameters(loop[i]);
                if (std::abs(at.x()) < sectors[before].reach()) {
                    places.push_back({before, at});
                    continue;
                }
            }
            const std::uint32_t within =
                patches_.part_of(face_, loop[i], loop[i].y() < loop[(i + 1) % n].y());
            places.push_back({within, sectors[within].patch.parameters(loop[i])});
        }
        // Starts with a run, if there are several.
        std::size_t first = 0;
        while (first < n && places[first].within == places[(first + n - 1) % n].within) ++first;
        std::vector<BoundaryRun>& runs = result.emplace_back();
        for (std::size_t i = 0; i < n;) {
            const std::uint32_t within = places[(first + i) % n].within;
            std::vector<Eigen::Vector3d> points;
            const auto add = [&](double u, double v) { points.push_back({u, v, 1}); };
            const auto side = [&](const Place& from, const Place& to) -> std::optional<bool> {
                const std::uint32_t start = sectors[from.within].place, end = sectors[to.within].place;
                const bool is_next = end == (start + 1) % count, is_last = start == (end + 1) % count;
                if (is_next && is_last)
                    return from.at.x() > 0 && to.at.x() < 0   ? std::optional(true)
                           : from.at.x() < 0 && to.at.x() > 0 ? std::optional(false)
                                                              : std::nullopt;
                return is_next ? std::optional(true) : is_last ? std::optional(false) : std::nullopt;
            };
            const Sector& sector = sectors[within];
            const auto add_on_side = [&](const Vec2& at, const Vec3& beyond, bool is_last) {
                const double u = is_last ? sector.reach() : -sector.reach();
                const Vec2 to = sector.patch.parameters(beyond);
                const double part = (u - at.x()) / (to.x() - at.x());
                add(u, part >= 0 && part <= 1 ? std::lerp(at.y(), to.y(), part) : at.y());
            };
            if (first < n) {
                const std::size_t begin = (first + i) % n, before = (begin + n - 1) % n;
                const auto comes_over = side(places[before], places[begin]);
                if (!comes_over) return std::nullopt;
                add_on_side(places[begin].at, loop[before], !*comes_over);
            }
            for (; i < n && places[(first + i) % n].within == within; ++i) {
                const Vec2& at = places[(first + i) % n].at;
                add(at.x(), at.y());
            }
            if (first < n) {
                const std::size_t beyond = (first + i) % n, end = (beyond + n - 1) % n;
                const auto leaves_over = side(places[end], places[beyond]);
                if (!leaves_over) return std::nullopt;
                add_on_side(places[end].at, loop[beyond], *leaves_over);
            } else {
                points.push_back(points.front());
            }
            BoundaryRun& run = runs.emplace_back(BoundaryRun{{}, within});
            begin_joined(run.trim.curve, 1, points.size() - 1);
            for (const Eigen::Vector3d& p : points) run.trim.curve.points.push_back(p);
        }
    }
    return result;
}

}  // namespace vcell::radial
