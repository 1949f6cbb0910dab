/// The second step of solve_curves(): the curve of a regular part is proved slice by slice, each an interval
/// of the parameter with one solution for every value in it. Slices that adjoin are a run.
#pragma once

#include <algorithm>
#include <array>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "../newton/curve_newton.hpp"
#include "curve_faces.hpp"
#include "curve_parts.hpp"
#include "curve_work.hpp"

namespace vcell::curve {

template <int N>
class Slicer {
    using Work = CurveWork<N>;
    using Box = typename Work::Box;
    using Leaf = typename Work::Leaf;
    using Slice = typename Work::Slice;
    using Stop = typename Work::Stop;
    using Run = typename Work::Run;
    static constexpr int D = Work::D;

public:
    explicit Slicer(Work& work)
        : f_(work.f),
          domain_(work.domain),
          options_(work.options),
          unit_(work.unit),
          leaves_(work.leaves),
          slices_(work.slices),
          runs_(work.runs),
          undecided_(work.undecided),
          faces_(work) {}

    /// Finds the slices and runs of a leaf.
    void slice(std::size_t index) {
        Leaf& leaf = leaves_[index];
        const int k = leaf.axis;
        // Beyond the part by half the margin, but not beyond the domain.
        const double reach = 0.5 * margin * length(leaf.part[k]);
        const Interval t(
            std::max({leaf.part[k].lower() - reach, domain_[k].lower(), leaf.neighbourhood[k].lower()}),
            std::min({leaf.part[k].upper() + reach, domain_[k].upper(), leaf.neighbourhood[k].upper()}));
        const std::size_t first = slices_.size();
        const Point<D> start = mid(leaf.part);
        prove(leaf, t, approximate(leaf, start, t.lower()), approximate(leaf, start, t.upper()));
        faces_.clip(leaf, first);
        leaf.first_run = runs_.size();
        for (std::size_t s = first; s < slices_.size(); ++s) append(index, s);
        leaf.last_run = runs_.size();
    }

private:
    // The double approximation of the curve at a parameter, and whether it is near enough to the leaf's part
    // to be of interest and far enough from the neighbourhood's sides to be provable. Only a guide.
    struct Trial {
        Point<D> x;
        bool near;
    };
    Trial approximate(const Leaf& leaf, const Point<D>& start, double t) const {
        Trial trial{start, false};
        trial.x[leaf.axis] = t;
        // Newton that would leave the neighbourhood, perhaps for another branch, goes on from its boundary.
        for (int step = 0; step < 8 && !trial.near; ++step) {
            clamp_into(trial.x, leaf.neighbourhood);
            const Point<D> before = trial.x;
            trial.near = settle<N>(f_, trial.x, leaf.axis, tolerance(leaf), 1);
            Point<D> inside = trial.x;
            clamp_into(inside, leaf.neighbourhood);
            if (inside == before) break;
        }
        for (int i = 0; i < D; ++i)
            if (i != leaf.axis) {
                const Interval near = halfway(leaf, i);
                trial.near = trial.near && trial.x[i] > near.lower() && trial.x[i] < near.upper();
            }
        return trial;
    }
    static Interval halfway(const Leaf& leaf, int i) {
        const Interval &part = leaf.part[i], &u = leaf.neighbourhood[i];
        return {0.5 * (part.lower() + u.lower()), 0.5 * (part.upper() + u.upper())};
    }
    static double tolerance(const Leaf& leaf) { return 1e-2 * margin * width(leaf.part); }

    // A point between the two where the curve is still near and soon no more.
    Trial last_near(const Leaf& leaf, Trial in, Trial out) const {
        for (int i = 0; i < D; ++i) {
            const Interval near = halfway(leaf, i);
            if (i == leaf.axis || near.contains(out.x[i])) continue;
            Trial exit = in;
            exit.x[i] = out.x[i] < near.lower() ? near.lower() : near.upper();
            const auto [lo, hi] = std::minmax(in.x[leaf.axis], out.x[leaf.axis]);
            if (settle<N>(f_, exit.x, i, tolerance(leaf), 5) && lo < exit.x[leaf.axis] &&
                exit.x[leaf.axis] < hi)
                return exit;
        }
        for (int step = 0; step < 5; ++step) {
            const Trial middle = approximate(leaf, in.x, std::midpoint(in.x[leaf.axis], out.x[leaf.axis]));
            (middle.near ? in : out) = middle;
        }
        return in;
    }

    // Finds the slices of the leaf's curve with parameters in t, from `low` to `high`. What is left out is
    // proved not to meet the leaf's part.
    void prove(const Leaf& leaf, const Interval& t, const Trial& low, const Trial& high) {
        if (low.near != high.near) {
            // The curve comes or goes through a side: cut there, so that one piece is provable as a whole and
            // the other is as a whole away from the part.
            const Trial in = low.near ? last_near(leaf, low, high) : last_near(leaf, high, low);
            const double at = in.x[leaf.axis];
            if (t.lower() < at && at < t.upper()) {
                const Trial gone{in.x, false};
                divide(leaf, Interval(t.lower(), at), low, low.near ? in : gone);
                divide(leaf, Interval(at, t.upper()), low.near ? gone : in, high);
                return;
            }
        }
        divide(leaf, t, low, high);
    }

    void divide(const Leaf& leaf, const Interval& t, const Trial& low, const Trial& high) {
        if (!low.near && !high.near && away(leaf, t)) return;
        Point<D> guess;
        for (int i = 0; i < D; ++i) guess[i] = std::midpoint(low.x[i], high.x[i]);
        guess[leaf.axis] = t.lower() + cut * length(t);
        const Trial middle = approximate(leaf, guess, guess[leaf.axis]);
        const int near = low.near + middle.near + high.near;
        if (near > 0 && has_tube(leaf, t, {low.x, middle.x, high.x})) return;
        if (low.near != high.near && away(leaf, t)) return;
        if (length(t) <= options_.min_width * unit_[leaf.axis] || ++divided_slices_ > options_.max_parts) {
            Box rest = leaf.part;
            if (const auto common = intersection(rest[leaf.axis], t)) {
                rest[leaf.axis] = *common;
                undecided_.push_back(rest);
            }
            return;
        }
        prove(leaf, Interval(t.lower(), middle.x[leaf.axis]), low, middle);
        prove(leaf, Interval(middle.x[leaf.axis], t.upper()), middle, high);
    }

    // Proves that a curve passes near the three points, for all parameters in t; within the neighbourhood it
    // is the only one.
    bool has_tube(const Leaf& leaf, const Interval& t, const std::array<Point<D>, 3>& points) {
        // Room for the image to fit in: it is as wide as the slope varies, a few times the deviation from the
        // chord.
        constexpr double room = 0.125, deviations = 6, least_room = 0x1p-24;
        const auto& [low, middle, high] = points;
        const double where = (middle[leaf.axis] - low[leaf.axis]) / (high[leaf.axis] - low[leaf.axis]);
        Box y;
        for (int i = 0; i < D; ++i) {
            const double lo = std::min({low[i], middle[i], high[i]}),
                         hi = std::max({low[i], middle[i], high[i]});
            const double deviation = std::abs(middle[i] - std::lerp(low[i], high[i], where));
            const double r =
                room * (hi - lo) + deviations * deviation + least_room * length(leaf.neighbourhood[i]);
            const auto inside = intersection(Interval(lo - r, hi + r), leaf.neighbourhood[i]);
            if (!inside) return false;
            y[i] = *inside;
        }
        y[leaf.axis] = t;
        Point<D> m = middle;
        clamp_into(m, y);
        const Box at = converted<Interval>(m);
        const auto value = f_(at);
        for (int attempt = 0; attempt < 2; ++attempt) {
            const Preconditioned<N, Interval> p(f_.differentiate(y), leaf.axis);
            const Box image = p.newton(y, at, p.apply(value));
            if (strictly_inside(image, y, leaf.axis)) {
                keep(leaf, image);
                return true;
            }
            // The image says how much room it needs.
            for (int i = 0; i < D; ++i) {
                if (i == leaf.axis) continue;
                const double r = room * length(image[i]);
                const auto wider =
                    intersection(Interval(image[i].lower() - r, image[i].upper() + r), leaf.neighbourhood[i]);
                if (!wider || !wider->contains(m[i])) return false;
                y[i] = *wider;
            }
        }
        return false;
    }

    // Proves that the leaf's part holds no solution with a parameter in t.
    bool away(const Leaf& leaf, const Interval& t) const {
        Box rest = leaf.part;
        const auto common = intersection(rest[leaf.axis], t);
        if (!common) return true;
        rest[leaf.axis] = *common;
        for (;;) {
            const auto j = f_.differentiate(rest);
            const Box before = rest, c = centre(rest);
            const auto value = f_(c);
            if (!contract<N>(rest, c, value, j)) return true;
            if constexpr (N > 1) {
                const Preconditioned<N, Interval> p(j, leaf.axis);
                if (!contract<N>(rest, c, p.apply(value), p)) return true;
            }
            constexpr double worth_another_look = 0.8;
            bool narrower = false;
            for (int i = 0; i < D; ++i)
                narrower = narrower || length(rest[i]) < worth_another_look * length(before[i]);
            if (!narrower) return false;
        }
    }

    void keep(const Leaf& leaf, const Box& enclosure) {
        if (overlap(enclosure, domain_))
            slices_.push_back({enclosure[leaf.axis].lower(), enclosure[leaf.axis].upper(), enclosure});
    }

    // Adds the slice to the last run of the leaf, or begins one with it.
    void append(std::size_t leaf, std::size_t s) {
        const auto& stops = faces_.stops();
        const int k = leaves_[leaf].axis;
        const Slice& slice = slices_[s];
        const auto low = stops.find({slice.begin, true});
        const bool joins = runs_.size() > leaves_[leaf].first_run && runs_.back().end == slice.begin &&
                           runs_.back().high.kind == Stop::Open && low == stops.end();
        if (!joins) {
            runs_.push_back({leaf, s, s, slice.begin, slice.end, {}, {}});
            if (low != stops.end())
                runs_.back().low = low->second;
            else if (slice.begin == domain_[k].lower())
                runs_.back().low = {Stop::Face, static_cast<std::size_t>(2 * k),
                                    point_of(f_, leaves_[leaf], slice, slice.begin)};
        }
        Run& run = runs_.back();
        run.last = s + 1;
        run.end = slice.end;
        if (const auto high = stops.find({slice.end, false}); high != stops.end())
            run.high = high->second;
        else if (slice.end == domain_[k].upper())
            run.high = {Stop::Face, static_cast<std::size_t>(2 * k + 1),
                        point_of(f_, leaves_[leaf], slice, slice.end)};
    }

    const CurveSystem<N>& f_;
    const Box& domain_;
    const CurveOptions& options_;
    const std::array<double, D>& unit_;
    std::vector<Leaf>& leaves_;
    std::vector<Slice>& slices_;
    std::vector<Run>& runs_;
    std::vector<Box>& undecided_;
    FaceCutter<N> faces_;
    std::size_t divided_slices_ = 0;
};

}  // namespace vcell::curve
