#include "chart_reach.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "../../core/errors.hpp"
#include "../../core/numbers/interval.hpp"
#include "../../primitives/forms/radial_height.hpp"
#include "../../primitives/forms/twins.hpp"

namespace vcell {

namespace {

class ChartReach {
public:
    explicit ChartReach(const FormFamily& family) : family_(family), chart_(family.chart) {
        for (const FormId f : family.forms.ids()) {
            const CircularForm& c = family.forms[f];
            const auto ball = [](double v) {
                return Interval::ball(v, 4 * std::numeric_limits<double>::epsilon() * std::abs(v));
            };
            const Interval w = Interval(1.0) / ball(c.w);
            circular_.push_back({Interval(c.k) * w, ball(c.a) * w, ball(c.b) * w, ball(c.e) * w});
        }
        inverted_.chart = family.chart;
        for (const RadialForm& f : family.radial) {
            RadialForm inverted = f;  // seen from the other pole: u_z changes its sign
            inverted.b[2] = -f.b[2];
            inverted.a[2] = -f.a[2];
            tubes_.emplace_back(inverted, [](const Exact& v) { return v.enclosure(); });
            inverted_.radial.push_back(std::move(inverted));
        }
    }

    double find() {
        const std::size_t owner = lowest_at_pole();
        double h = 1;
        for (std::size_t i = 0; i < circular_.size() && owner < circular_.size(); ++i) {
            above_.push_back(difference(i, owner));
            if (i == owner) continue;
            // v - s h - 2 e h^2 > 0: its root, and a bit less.
            const std::array<Interval, 4>& d = above_.back();
            const double v = d[0].lower(), s = (d[1].magnitude() + d[2].magnitude()),
                         e = std::max(0.0, -d[3].lower());
            if (!(v > 0)) throw undecided();
            h = std::min(h, 0.999 * 2 * v / (s + std::sqrt(s * s + 8 * e * v)));
        }
        while (!is_lowest_within(owner, h)) {
            h *= 0.5;
            if (!(h > least)) throw undecided();
        }
        return 1 / h;
    }

private:
    static constexpr double least = 0x1p-40;

    static UndecidedError undecided() {
        return UndecidedError("which object is nearest around the pole of the chart");
    }

    // The coefficients of i less those of j: exact, and rounded once, where doubles do not tell at the pole.
    std::array<Interval, 4> difference(std::size_t i, std::size_t j) const {
        const auto &f = circular_[i], &g = circular_[j];
        std::array<Interval, 4> d{f[0] - g[0], f[1] - g[1], f[2] - g[2], f[3] - g[3]};
        if (i == j || d[0].lower() > 0 || d[0].upper() < 0) return d;
        const ExactForm p = family_.exact(form(i)), q = family_.exact(form(j));
        const Interval w = (p.W * q.W).enclosure();
        const auto less = [&](const Exact& of_p, const Exact& of_q) {
            return (of_p * q.W - of_q * p.W).enclosure() / w;
        };
        return {less(p.K, q.K), less(p.A, q.A), less(p.B, q.B), less(p.C, q.C)};
    }
    static FormId form(std::size_t i) { return FormId{static_cast<std::uint32_t>(i)}; }

    std::size_t lowest_at_pole() const {
        std::size_t best = 0;
        double lowest = HUGE_VAL;
        const auto consider = [&](std::size_t i, double v) {
            if (v >= lowest) return;
            lowest = v;
            best = i;
        };
        for (std::size_t i = 0; i < circular_.size(); ++i) consider(i, circular_[i][0].mid());
        const RadialNormals<Interval> pole(chart_, 0.0, 0.0);
        for (std::size_t i = 0; i < tubes_.size(); ++i)
            consider(circular_.size() + i, tubes_[i].jet<0>(pole).v.mid());
        // Doubles may have taken the twin of the lowest for it.
        if (best < circular_.size()) {
            for (std::size_t i = 0; i < circular_.size(); ++i)
                if (difference(i, best)[0].upper() < 0) best = i;
        } else {
            for (std::size_t i = 0; i < tubes_.size(); ++i)
                if (is_above_twin(best - circular_.size(), i, pole)) best = circular_.size() + i;
        }
        return best;
    }

    bool is_lowest_within(std::size_t owner, double h) const {
        const Interval x(-h, h), r2(0.0, Interval::up(2 * h * h));
        if (tubes_.empty()) {
            for (std::size_t i = 0; i < circular_.size(); ++i) {
                if (i == owner) continue;
                const auto& d = above_[i];
                if (!((d[0] + d[1] * x + d[2] * x + d[3] * r2).lower() > 0)) return false;
            }
            return true;
        }
        const RadialNormals<Interval> normals(chart_, x, x);
        const Interval w(1.0, Interval::up(1 + r2.upper()));
        const auto range = [&](std::size_t i) {
            if (i >= circular_.size()) return tubes_[i - circular_.size()].jet<0>(normals).v;
            const auto& c = circular_[i];
            return (c[0] + c[1] * x + c[2] * x + c[3] * r2) / w;
        };
        // Those of one kind that differ by little are told by what their coefficients differ by.
        const auto is_above_its_like = [&](std::size_t i) {
            if (i < circular_.size() && owner < circular_.size()) {
                const auto& d = above_[i];
                return (d[0] + d[1] * x + d[2] * x + d[3] * r2).lower() > 0;
            }
            return i >= circular_.size() && owner >= circular_.size() &&
                   is_above_twin(i - circular_.size(), owner - circular_.size(), normals);
        };
        const double top = range(owner).upper();
        for (std::size_t i = 0; i < circular_.size() + tubes_.size(); ++i)
            if (i != owner && !(range(i).lower() > top) && !is_above_its_like(i)) return false;
        return true;
    }

    bool is_above_twin(std::size_t tube, std::size_t lowest, const RadialNormals<Interval>& normals) const {
        const FormId f{static_cast<std::uint32_t>(tube)}, g{static_cast<std::uint32_t>(lowest)};
        const auto factor = FormSignature(inverted_, f).factor(FormSignature(inverted_, g));
        if (!factor || f == g) return false;
        const TwinDifference twins(inverted_, f, g, *factor);
        return twins.over(tubes_[tube].plain_jet<2>(normals), normals).v.lower() > 0;
    }

    const FormFamily& family_;
    Chart chart_;
    std::vector<std::array<Interval, 4>> circular_;  // of k, a, b, e over w
    std::vector<std::array<Interval, 4>> above_;     // likewise, less those of the lowest one
    std::vector<RadialHeight<Interval>> tubes_;
    FormFamily inverted_;  // of tubes alone
};

}  // namespace

double chart_reach(const FormFamily& family) { return ChartReach(family).find(); }

}  // namespace vcell
