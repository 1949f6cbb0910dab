/// Slices of curves cut at the domain's faces: where a curve crosses a face is enclosed between points that
/// are proved to lie on either side of it.
#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "../newton/curve_newton.hpp"
#include "curve_work.hpp"

namespace vcell::curve {

template <int N>
class FaceCutter {
    using Work = CurveWork<N>;
    using Box = typename Work::Box;
    using Leaf = typename Work::Leaf;
    using Slice = typename Work::Slice;
    using Stop = typename Work::Stop;
    static constexpr int D = Work::D;

public:
    /// By parameter, and whether a run begins there or ends.
    using Stops = std::map<std::pair<double, bool>, Stop>;

    explicit FaceCutter(Work& work)
        : f_(work.f),
          domain_(work.domain),
          options_(work.options),
          unit_(work.unit),
          slices_(work.slices),
          undecided_(work.undecided) {}

    // Cuts the slices from `first` on at the domain's faces.
    void clip(const Leaf& leaf, std::size_t first) {
        std::vector<Slice> uncut(slices_.begin() + first, slices_.end());
        slices_.resize(first);
        stops_.clear();
        for (const Slice& s : uncut) clip(leaf, s);
    }
    /// Where runs of the leaf that was cut last stop at a face.
    const Stops& stops() const { return stops_; }

private:
    struct Crossing {
        Interval t;
        int face;
        Box point;
    };

    void clip(const Leaf& leaf, const Slice& s) {
        const int k = leaf.axis;
        if (!overlap(s.enclosure, domain_)) return;
        if (is_subset(s.enclosure, domain_)) {
            slices_.push_back(s);
            return;
        }
        if (s.end - s.begin <= options_.min_width * unit_[k]) {
            undecided_.push_back(*intersection(s.enclosure, domain_));
            stops_[{s.begin, false}] = stops_[{s.end, true}] = {Stop::Undecided, undecided_.size() - 1, {}};
            return;
        }
        // With all slopes across the faces of one sign, each face is crossed once at most, and the signs at
        // the ends tell whether it is.
        Box y = s.enclosure;
        const Preconditioned<N, Interval> p(f_.differentiate(y), k);
        std::optional<Crossing> low, high;
        bool clear = p.regular(unit_);
        if (clear) {
            const Box slope = p.slopes(unit_);
            const std::array ends{narrowed(f_, y, k, Interval(s.begin)), narrowed(f_, y, k, Interval(s.end))};
            for (int i = 0; clear && i < D; ++i) {
                if (i == k || is_subset(s.enclosure[i], domain_[i])) continue;
                const auto direction = slope[i].sign().value_or(Sign::Zero);
                if (direction == Sign::Zero) {
                    clear = false;
                    break;
                }
                for (int upper = 0; clear && upper < 2; ++upper) {
                    const double c = upper ? domain_[i].upper() : domain_[i].lower();
                    if (upper ? s.enclosure[i].upper() <= c : s.enclosure[i].lower() >= c) continue;
                    // Outwards distances at both ends.
                    const Interval a = upper ? ends[0][i] - Interval(c) : Interval(c) - ends[0][i];
                    const Interval b = upper ? ends[1][i] - Interval(c) : Interval(c) - ends[1][i];
                    const Sign sa = a.sign().value_or(Sign::Zero), sb = b.sign().value_or(Sign::Zero);
                    if (sa == Sign::Zero || sb == Sign::Zero) {
                        clear = false;
                    } else if (sa == Sign::Positive && sb == Sign::Positive) {
                        return;
                    } else if (sa != sb) {
                        const auto found = crossing(s, k, i, 2 * i + upper, c);
                        std::optional<Crossing>& side = sb == Sign::Positive ? high : low;
                        if (!found || (side && overlap(std::array{side->t}, std::array{found->t})))
                            clear = false;
                        else if (!side || (sb == Sign::Positive ? found->t.lower() < side->t.lower()
                                                                : found->t.upper() > side->t.upper()))
                            side = found;
                    }
                }
            }
            if (clear && low && high) {
                if (high->t.upper() < low->t.lower()) return;  // passes the domain's corner outside
                clear = low->t.upper() < high->t.lower();
            }
        }
        if (!clear) {
            const double split = s.begin + cut * (s.end - s.begin);
            for (const Interval& t : {Interval(s.begin, split), Interval(split, s.end)}) {
                Box half = y;
                half[k] = t;
                half = narrowed_once(half, k);
                clip(leaf, {t.lower(), t.upper(), half});
            }
            return;
        }
        Slice inside = s;
        if (low) {
            inside.begin = low->t.lower();
            stops_[{inside.begin, true}] = {Stop::Face, static_cast<std::size_t>(low->face), low->point};
        }
        if (high) {
            inside.end = high->t.upper();
            stops_[{inside.end, false}] = {Stop::Face, static_cast<std::size_t>(high->face), high->point};
        }
        inside.enclosure[k] = Interval(inside.begin, inside.end);
        slices_.push_back(inside);
    }

    Box narrowed_once(const Box& y, int k) const {
        Point<D> m = middle_at(y, k, y[k].mid());
        settle<N>(f_, m, k, 0.0, 2);
        clamp_into(m, y);
        const Box at = converted<Interval>(m);
        const Preconditioned<N, Interval> p(f_.differentiate(y), k);
        return intersection(p.newton(y, at, p.apply(f_(at))), y).value_or(y);
    }

    // The parameter at which the slice's curve meets x[i] = c, between points proved to lie on either side.
    // Pre: the signs of x[i] - c at the slice's ends differ, and x[i] is monotone.
    std::optional<Crossing> crossing(const Slice& s, int k, int i, int face, double c) const {
        double lo = s.begin, hi = s.end;
        const double sign_lo = narrowed(f_, s.enclosure, k, Interval(lo))[i].lower() > c ? 1 : -1;
        // Newton for x[i] = c along the other coordinates finds the place, certified points beside it prove
        // it.
        Point<D> guess = mid(s.enclosure);
        guess[i] = c;
        settle<N>(f_, guess, i, 0.0, 6);
        double step = 8 * std::numeric_limits<double>::epsilon() * std::max(std::abs(guess[k]), hi - lo);
        if (guess[k] > lo && guess[k] < hi) {
            for (int attempt = 0; attempt < 12; ++attempt, step *= 4) {
                bool found = true;
                for (const double t : {guess[k] - step, guess[k] + step}) {
                    if (!(t > lo && t < hi)) continue;
                    const Interval x = narrowed(f_, s.enclosure, k, Interval(t))[i];
                    const bool before = sign_lo > 0 ? x.lower() > c : x.upper() < c;
                    const bool after = sign_lo > 0 ? x.upper() < c : x.lower() > c;
                    if (before) lo = t;
                    if (after) hi = t;
                    found = found && (before || after);
                }
                if (found && hi - lo <= 4 * step) break;
            }
        }
        if (!(hi - lo <= options_.min_width * unit_[k])) return std::nullopt;
        Crossing result{Interval(lo, hi), face, narrowed(f_, s.enclosure, k, Interval(lo, hi))};
        result.point[i] = Interval(c);
        return result;
    }

    const CurveSystem<N>& f_;
    const Box& domain_;
    const CurveOptions& options_;
    const std::array<double, D>& unit_;
    std::vector<Slice>& slices_;
    std::vector<Box>& undecided_;
    Stops stops_;
};

}  // namespace vcell::curve
