/// The first step of solve_curves(): the domain is divided until every part holds no curve, or is regular:
/// one axis is a parameter of all curves in its neighbourhood.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "../newton/curve_newton.hpp"
#include "curve_work.hpp"

namespace vcell::curve {

template <int N>
const IntervalBox<N + 1>& gradient(const Jets<Interval, N>& j, int e) {
    return j[e].gradient;
}
template <int N>
const IntervalBox<N + 1>& gradient(const Preconditioned<N, Interval>& p, int e) {
    return p.row(e);
}

// Solves each row of value + jacobian (x - c) = 0 for each coordinate; false: no solution in the part.
template <int N>
bool contract(IntervalBox<N + 1>& part, const IntervalBox<N + 1>& c, const std::array<Interval, N>& value,
              const auto& rows) {
    constexpr int D = N + 1;
    for (int e = 0; e < N; ++e) {
        const auto& row = gradient<N>(rows, e);
        std::array<Interval, D> terms;
        for (int l = 0; l < D; ++l) terms[l] = row[l] * (part[l] - c[l]);
        Interval sum = value[e];
        for (const Interval& t : terms) sum += t;
        if (sum.lower() > 0 || sum.upper() < 0) return false;
        for (int l = 0; l < D; ++l) {
            if (row[l].lower() <= 0 && row[l].upper() >= 0) continue;
            Interval rest = value[e];
            for (int o = 0; o < D; ++o)
                if (o != l) rest += terms[o];
            const auto kept = intersection(part[l], c[l] - rest / row[l]);
            if (!kept) return false;
            part[l] = *kept;
            terms[l] = row[l] * (part[l] - c[l]);
        }
    }
    return true;
}

template <int N>
class Subdivision {
    using Work = CurveWork<N>;
    using Box = typename Work::Box;
    using Part = typename Work::Part;
    static constexpr int D = Work::D;
    static constexpr std::size_t none = Work::none;

public:
    explicit Subdivision(Work& work)
        : f_(work.f),
          options_(work.options),
          unit_(work.unit),
          domain_(work.domain),
          parts_(work.parts),
          leaves_(work.leaves),
          undecided_(work.undecided) {}

    /// Fills parts and leaves.
    void run() {
        parts_.push_back({domain_, domain_});
        for (std::size_t i = 0; i < parts_.size(); ++i) examine(i);
        for (std::size_t i = parts_.size(); i-- > 0;) {
            Part& p = parts_[i];
            if (p.leaf != none) {
                p.neighbourhoods = leaves_[p.leaf].neighbourhood;
                p.occupied = true;
            }
            for (std::size_t c = p.first_child; c < p.first_child + p.children; ++c) {
                if (!parts_[c].occupied) continue;
                p.neighbourhoods =
                    p.occupied ? hull(p.neighbourhoods, parts_[c].neighbourhoods) : parts_[c].neighbourhoods;
                p.occupied = true;
            }
        }
    }

private:
    Box neighbourhood(const Box& part) const {
        double widest = 0;
        for (int i = 0; i < D; ++i) widest = std::max(widest, length(part[i]) / unit_[i]);
        Box u;
        for (int i = 0; i < D; ++i) {
            const double m = margin * widest * unit_[i];
            u[i] = Interval(Interval::down(part[i].lower() - m), Interval::up(part[i].upper() + m));
        }
        return u;
    }

    void examine(std::size_t index) {
        const Box whole = parts_[index].box;
        const Box u = neighbourhood(whole);
        const auto j = f_.differentiate(u);
        for (int e = 0; e < N; ++e)
            if (j[e].value.sign().value_or(Sign::Zero) != Sign::Zero) return;

        Box part = whole;
        const Box c = centre(whole);
        const auto value = f_(c);
        if (!contract<N>(part, c, value, j)) return;

        // The axis along which the curve runs, measured in units of the domain.
        const auto t = tangent<N>(j);
        int axis = 0;
        for (int k = 1; k < D; ++k)
            if (std::abs(t[k]) * unit_[axis] > std::abs(t[axis]) * unit_[k]) axis = k;
        if (t[axis] != 0 && std::isfinite(t[axis])) {
            const Preconditioned<N, Interval> p(j, axis);
            if (N > 1 && !contract<N>(part, c, p.apply(value), p)) return;
            if (p.regular(unit_) && moderate(p)) {
                parts_[index].leaf = leaves_.size();
                leaves_.push_back({part, *intersection(u, neighbourhood(part)), axis, t[axis] > 0 ? 1 : -1});
                return;
            }
        }

        double widest = 0;
        int split = 0;
        double kept = 1;
        for (int i = 0; i < D; ++i) {
            const double w = length(part[i]) / unit_[i];
            if (w > widest) widest = w, split = i;
            if (length(whole[i]) > 0) kept *= length(part[i]) / length(whole[i]);
        }
        if (widest <= options_.min_width || parts_.size() >= options_.max_parts) {
            undecided_.push_back(part);
            return;
        }
        constexpr double worth_another_look = 0.3;
        parts_[index].first_child = parts_.size();
        if (kept < worth_another_look) {
            parts_[index].children = 1;
            parts_.push_back({part, part});
            return;
        }
        parts_[index].children = 2;
        const double at = part[split].lower() + cut * length(part[split]);
        Box low = part, high = part;
        low[split] = Interval(part[split].lower(), at);
        high[split] = Interval(at, part[split].upper());
        parts_.push_back({low, low});
        parts_.push_back({high, high});
    }

    // A part is left to its slices when the curve is nowhere steeper than this against the axis, measured in
    // units of the domain: smaller parts have a better axis.
    bool moderate(const Preconditioned<N, Interval>& p) const {
        constexpr double steepest = 10;
        const Box slope = p.slopes(unit_);
        for (int i = 0; i < D; ++i)
            if (!(slope[i].magnitude() * unit_[p.axis()] <= steepest * unit_[i])) return false;
        return true;
    }

    const CurveSystem<N>& f_;
    const CurveOptions& options_;
    const std::array<double, D>& unit_;
    const Box& domain_;
    std::vector<Part>& parts_;
    std::vector<typename Work::Leaf>& leaves_;
    std::vector<Box>& undecided_;
};

}  // namespace vcell::curve
