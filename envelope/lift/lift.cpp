#include "lift.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "../../primitives/forms/heights.hpp"
#include "../measures/measures.hpp"
#include "based_diagram.hpp"
#include "cell_assembly.hpp"
#include "circular_edges.hpp"
#include "face_loops.hpp"
#include "mixed_arc.hpp"
#include "trim_bounds.hpp"

namespace vcell {

namespace {

using roundoff::u;

// Rounding of a patch's control points, in the magnitudes that enter them: some ten operations, and
// coefficients within 4 u.
constexpr double patch_rounding = 32 * u;

// A patch and a bound on how far rounding turns it off.
struct RoundedPatch {
    RationalPatch surface;
    double rounding = 0;
};

// The height as a Bezier patch on [u0,u1] x [v0,v1]: blossoms. In one variable (u - c)^2 has the coefficients
// (u0-c)^2, (u0-c)(u1-c), (u1-c)^2, and u itself u0, (u0+u1)/2, u1.
RoundedPatch height_patch(const CircularForm& f, const Rectangle& box, const BaseFrame& frame) {
    RationalPatch surface;
    const int n = f.k != 0 ? 2 : 1;
    surface.degree_u = surface.degree_v = n;
    surface.domain_u = box[0];
    surface.domain_v = box[1];
    const auto blossom = [n](const Range& r, int i, double c) { return (r[i == n] - c) * (r[i > 0] - c); };
    const auto abscissa = [n](const Range& r, int i) {
        return i == 0 ? r[0] : i == n ? r[1] : 0.5 * r[0] + 0.5 * r[1];
    };
    double size = 0;
    for (int i = 0; i <= n; ++i) {
        for (int j = 0; j <= n; ++j) {
            const double x = abscissa(box[0], i), y = abscissa(box[1], j);
            const double quadratic =
                f.k == 0 ? 0 : f.k * (blossom(box[0], i, f.cx) + blossom(box[1], j, f.cy));
            const double z = (quadratic + f.a * x + f.b * y + f.e) / f.w;
            const double terms = std::abs(quadratic) + std::abs(f.a * x) + std::abs(f.b * y) + std::abs(f.e);
            size = std::max(size, terms / f.w + std::abs(x) + std::abs(y));
            const Vec3 world = frame.to_world({x, y, z});
            surface.points.push_back({world.x(), world.y(), world.z(), 1});
        }
    }
    return {std::move(surface), patch_rounding * (size + frame.origin.norm())};
}

RoundedPatch height_patch(const CylinderFrame& f, const Rectangle& box, const BaseFrame& frame) {
    RationalPatch surface = f.patch(box[0], box[1], frame);
    double size = 0;
    for (const Eigen::Vector4d& p : surface.points) size = std::max(size, p.head<3>().norm());
    return {std::move(surface), patch_rounding * (size + f.height().reach() + frame.origin.norm())};
}

// The largest clearance: of the boundary as written, and bounds of the true one's. Every height is convex,
// and over a face largest on the face's boundary, but that of a vessel, which has its top. A point of the
// boundary as written is within `error` of one of the true boundary, and the other way round.
class Highest {
public:
    void add(double height, double error) {
        const std::array<double, 3> of_part{height, height - error, height + error};
        for (int i = 0; i < 3; ++i) highest_[i] = std::max(highest_[i], of_part[i]);
    }
    // A height that the boundary attains, or nearly, if it `is_there`, and perhaps if that is not known.
    void add_top(double height, double error, std::optional<bool> is_there) {
        if (is_there == true) return add(height, error);
        if (!is_there) highest_[2] = std::max(highest_[2], height + error);
    }
    void set(Measures& measures) const {
        const auto [height, least, most] = highest_;
        measures.max_clearance = height;
        measures.max_clearance_error = std::max(height - least, most - height) + 16 * u * height;
    }
    void add(const Highest& other) {
        for (int i = 0; i < 3; ++i) highest_[i] = std::max(highest_[i], other.highest_[i]);
    }

private:
    std::array<double, 3> highest_{};
};

class PlaneLift {
public:
    static constexpr bool is_shareable = true;

    PlaneLift(const PlaneDiagram& of, double tolerance, unsigned threads)
        : of_(of),
          problem_(of.problem),
          diagram_(of.diagram),
          threads_(threads),
          circular_(of, threads),
          loops_(of.diagram, true),
          mixed_(of.problem, of.diagram, loops_, tolerance, threads),
          origin_(of.problem.frame.origin.norm()),
          roundings_(of.diagram.dcel.face_count(), 0),
          highest_(range_count(of.diagram.edges.size())) {}

    const PlaneDiagram& of() const { return of_; }
    const Decisions& decisions() const { return circular_.arcs().decisions(); }

    LiftedVertex vertex(VertexId v) const {
        const MinimizationDiagram::Vertex& from = diagram_.vertices[v];
        const Vec3 point(from.point.x(), from.point.y(), from.height);
        return {point, std::max(0.0, from.height),
                std::hypot(from.error, from.height_error) + motion_back(point.norm())};
    }

    // At a corner of the region all sides of the box that run through it.
    void add_rim_sites(VertexId v, SmallVector<Site, 4>& sites) const {
        of_.add_rim_sites(v, sites);
        const std::span<const std::uint32_t> sides = diagram_.sides(v);
        if (sides.size() < 2 || problem_.corner_sites.empty()) return;
        const bool is_second = sides[1] == (sides[0] + 1) % problem_.region.size();
        const auto& through = problem_.corner_sites[is_second ? sides[1] : sides[0]];
        sites.insert(sites.end(), through.begin(), through.end());
    }

    // The cone over a cylinder is circular when its axis is: a quadric K^2 (x^2 + y^2) = (d.X)^2 has the
    // eigenvalue K^2, and no other one is that unless d is upright.
    const char* bisector(FormId form) const {
        if (!of_.main_site(form).is_object()) return "box";
        if (diagram_.is_circular(form)) return diagram_.forms[form].k != 0 ? "paraboloid" : "plane";
        switch (problem_.axes[form.value - problem_.family.forms.size()]) {
            case AxisToBase::Parallel: return "parabolic cylinder";
            case AxisToBase::Upright: return "circular cone";
            case AxisToBase::Oblique: break;
        }
        return "elliptic cone";
    }

    void set_patches(FaceId face, std::vector<TrimmedPatch>& patches) {
        if (!problem_.lifts(diagram_.face_forms[face], diagram_.is_below_floor)) return;
        for (const CutPart& part : mixed_.parts(face)) {
            TrimmedPatch& patch = append_new(patches);
            patch.loops = part.loops;
            RoundedPatch rounded = height_patch(mixed_.sectors()[face][part.within].frame,
                                                loop_domain(patch.loops.front()), problem_.frame);
            patch.surface = std::move(rounded.surface);
            roundings_[face] = std::max(roundings_[face], rounded.rounding);
        }
        if (!patches.empty()) return;
        TrimmedPatch& patch = append_new(patches);
        patch.loops = loops_.trims(face, [&](EdgeId e, bool reversed, RationalCurve2& curve) {
            if (mixed_.contains(e))
                mixed_.set_trim(e, reversed, curve);
            else
                circular_.set_trim(e, reversed, curve);
        });
        const FormId form = diagram_.face_forms[face];
        const Rectangle domain = loop_domain(patch.loops.front());
        RoundedPatch rounded = diagram_.is_circular(form)
                                   ? height_patch(diagram_.forms[form], domain, problem_.frame)
                                   : height_patch(mixed_.frame(face), domain, problem_.frame);
        patch.surface = std::move(rounded.surface);
        roundings_[face] = rounded.rounding;
    }

    CurveKind kind(EdgeId e) const { return mixed_.contains(e) ? mixed_.kind(e) : circular_.kind(e); }

    LiftedEdgeErrors set_curve(EdgeId e, double, RationalCurve3& curve) {
        Range heights = empty_range;
        MixedArcs::Error error;
        if (!mixed_.is_lifted(e)) return {0, 0};
        if (mixed_.contains(e)) {
            mixed_.set_curve(e, problem_.frame, curve, heights);
            error = mixed_.error(e);
        } else {
            circular_.set_curve(e, curve, heights);
            error.curve = error.edge = circular_.error(e);
        }
        double square = 0;
        for (const Eigen::Vector4d& p : curve.points) square = std::max(square, p.head<3>().squaredNorm());
        const double rounding = motion_back(std::sqrt(square));
        if (shows(e)) highest_[task_of(e.value)].add(heights[1], error.curve + rounding);
        // The patches belong to what the edge's error bounds.
        double edge = error.edge + rounding;
        for (const unsigned side : {0u, 1u}) edge += roundings_[diagram_.face(e, side)];
        return {error.curve + rounding, edge};
    }

    void finish(const Cell& cell) {
        std::vector<bool> is_shown(cell.vertices.size(), problem_.floor.empty());
        if (!problem_.floor.empty())
            for (const EdgeId e : diagram_.edges.ids())
                for (const VertexId v : {diagram_.start(e), diagram_.end(e)})
                    if (v.valid() && shows(e)) is_shown[v.value] = true;
        for (const VertexId v : diagram_.vertices.ids())
            if (is_shown[v.value])
                highest_.front().add(diagram_.vertices[v].height, cell.vertices[v.value].error);
    }

    void measure(const IdVector<EdgeId, double>&, Cell& cell) const {
        measure_over_region(problem_, diagram_, circular_.arcs(), mixed_, loops_, cell, threads_);
        Highest highest;
        for (const Highest& of_task : highest_) highest.add(of_task);
        if (!diagram_.is_below_floor) add_tops(highest);
        highest.set(cell.measures);
    }

private:
    // The place is rounded: a hollow sphere's height changes by its square, a hollow cylinder's around the
    // tip by as much times its slope there.
    void add_tops(Highest& highest) const {
        for (const FormId form : diagram_.forms.ids()) {
            const CircularForm& f = diagram_.forms[form];
            if (!(f.k < 0)) continue;
            const Eigen::Vector2d top(f.cx - 0.5 * f.a / f.k, f.cy - 0.5 * f.b / f.k);
            const double height = f(top.x(), top.y());
            add_top(form, top, height, std::abs(f.cx) + std::abs(f.cy), std::abs(f.e) / f.w + height,
                    highest);
        }
        for (std::uint32_t i = 0; i < diagram_.cylinders.size(); ++i) {
            if (!diagram_.cylinders[i].is_hollow() || problem_.axes[i] == AxisToBase::Parallel) continue;
            const CylinderHeight height(diagram_.cylinders[i], Eigen::Vector2d::Zero());
            const FormId form{static_cast<std::uint32_t>(diagram_.forms.size()) + i};
            add_top(form, height.focus(), height.depth(), height.reach() / height.steep(),
                    std::abs(height.depth()), highest);
        }
    }

    // Where a vessel's height is greatest it is the envelope's if no other form's is less there; where it
    // ties, the least of all is the envelope's in any case. `size`: with what the place and the height are
    // rounded, besides themselves.
    void add_top(FormId form, const Eigen::Vector2d& top, double height, double of_place, double of_height,
                 Highest& highest) const {
        const double x = top.x(), y = top.y(), size = top.norm() + origin_ + of_place,
                     error = 32 * u * (of_height + size);
        std::optional<bool> is_there = true, is_over_region = true;
        const auto meet = [](double room, double doubt, std::optional<bool>& holds) {
            if (room < -doubt) holds = false;
            if (!(room > doubt) && holds == true) holds = std::nullopt;
        };
        for (const RegionSide& side : problem_.region)
            meet(side.a * x + side.b * y + side.c,
                 32 * u * ((std::abs(side.a) + std::abs(side.b)) * size + std::abs(side.c)), is_over_region);
        is_there = is_over_region;
        const Heights heights(problem_.family);
        const Interval near_x = Interval::ball(x, 8 * u * size), near_y = Interval::ball(y, 8 * u * size);
        Interval least = Interval::ball(height, error);
        for (const FormId g : problem_.sites.ids()) {
            if (g == form) continue;
            const Interval other = heights.value(g, near_x, near_y),
                           apart = other - heights.value(form, near_x, near_y);
            const bool is_floor = diagram_.is_of_floor(g);
            const Interval room = is_floor ? -apart : apart;
            meet(room.mid(), room.radius(), is_there);
            if (is_floor) meet(room.mid(), room.radius(), is_over_region);
            if (!is_floor)
                least = {std::min(least.lower(), other.lower()), std::min(least.upper(), other.upper())};
        }
        highest.add_top(height, error, is_there);
        if (!is_there && is_over_region == true && std::isfinite(least.radius()))
            highest.add(least.mid(), least.radius());
    }

    // Does the cell have a face beside the edge?
    bool shows(EdgeId e) const {
        const auto shows_face = [&](unsigned side) {
            const FormId form = diagram_.face_forms[diagram_.face(e, side)];
            return form.valid() && problem_.shows(form, diagram_.is_below_floor);
        };
        return problem_.floor.empty() || shows_face(0) || shows_face(1);
    }

    // What the motion back to the world adds to an error at a distance from the origin: three products and
    // three sums a coordinate, of factors rounded once.
    double motion_back(double distance) const { return 8 * u * (distance + origin_); }

    const PlaneDiagram of_;
    const PlaneBaseProblem& problem_;
    const MinimizationDiagram& diagram_;
    const unsigned threads_;
    const CircularEdges circular_;
    const FaceLoops loops_;
    const MixedArcs mixed_;
    const double origin_;                 // how far the frame's is from the world's
    IdVector<FaceId, double> roundings_;  // of the patches
    std::vector<Highest> highest_;        // of the edges of each task
};

}  // namespace

LiftedCell lift_over_region(const PlaneBaseProblem& problem, const MinimizationDiagram& diagram,
                            double tolerance, bool with_measures, unsigned threads) {
    PlaneLift lift({problem, diagram}, tolerance, threads);
    return CellAssembly(lift, threads)(with_measures);
}

}  // namespace vcell
