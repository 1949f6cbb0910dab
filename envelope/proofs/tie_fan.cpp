#include "tie_fan.hpp"

#include <algorithm>

namespace vcell {

namespace {

using Eigen::Vector2d;

// Off the middle, where symmetric input has its arms.
constexpr double split_ratio = 0.48643;
// A fan of n arms takes some twenty sectors for each; many more follow functions that tie in a direction.
constexpr int most_sectors = 2000;
// Arms are enclosed in sectors of this part of the line between two corners, or as narrow as the set allows.
constexpr double narrow_sector = 0x1p-5;
// Narrower ones are none in doubles, but where the line starts.
constexpr double least_sector = 0x1p-53;

class FanSearch {
public:
    FanSearch(std::span<const FormId> forms, const std::vector<std::vector<TiedDifference>>& differences,
              std::span<const TiedBetween> between)
        : forms_(forms), differences_(differences), between_(between) {}

    std::optional<Fan> run(std::span<const Vector2d> corners) {
        std::vector<std::size_t> all(forms_.size());
        for (std::size_t i = 0; i < all.size(); ++i) all[i] = i;
        for (std::size_t k = 0; k + 1 < corners.size(); ++k) {
            origin_ = corners[k];
            along_ = corners[k + 1] - corners[k];
            if (!search(0, 1, all)) return std::nullopt;
        }
        return std::move(fan_);
    }

private:
    struct Direction {
        Interval x, y;
    };
    Direction direction(Interval s) const {
        return {Interval(origin_.x()) + s * Interval(along_.x()),
                Interval(origin_.y()) + s * Interval(along_.y())};
    }
    // The sign of form i less form j in the directions u.
    std::optional<Sign> sign(std::size_t i, std::size_t j, const Direction& u) const {
        if (i > j) {
            const auto s = sign(j, i, u);
            return s ? std::optional(-*s) : s;
        }
        const TiedDifference& d = differences_[i][j];
        if (!d.curvature) return (d.gradient[0] * u.x + d.gradient[1] * u.y).sign();
        return (d.curvature->xx * square(u.x) + 2.0 * (d.curvature->xy * u.x * u.y) +
                d.curvature->yy * square(u.y))
            .sign();
    }
    // Has its derivative along the line between the corners a sign?
    bool turns(std::size_t i, std::size_t j, const Direction& u) const {
        const TiedDifference& d = differences_[std::min(i, j)][std::max(i, j)];
        const Interval vx(along_.x()), vy(along_.y());
        if (!d.curvature) return (d.gradient[0] * vx + d.gradient[1] * vy).sign().has_value();
        return (d.curvature->xx * u.x * vx + d.curvature->xy * (u.x * vy + u.y * vx) +
                d.curvature->yy * u.y * vy)
            .sign()
            .has_value();
    }

    bool search(double lo, double hi, const std::vector<std::size_t>& candidates) {
        if (++sectors_ > most_sectors) return false;
        const Direction u = direction({lo, hi});
        std::vector<std::size_t> lowest;
        for (const std::size_t i : candidates)
            if (std::ranges::none_of(
                    candidates, [&](std::size_t j) { return j != i && sign(i, j, u) == Sign::Positive; }))
                lowest.push_back(i);
        if (lowest.size() == 1) return enter(lowest[0]);
        if (lowest.size() == 2 && turns(lowest[0], lowest[1], u)) {
            const auto before = sign(lowest[0], lowest[1], direction(lo)),
                       after = sign(lowest[0], lowest[1], direction(hi));
            if (before && after) {
                if (*before == Sign::Positive) std::swap(lowest[0], lowest[1]);
                if (!enter(lowest[0])) return false;
                if (before != after) cross(lo, hi, lowest[0], lowest[1]);
                return true;
            }
        }
        if (lowest.size() > 2)
            if (const auto is_entered = search_between(lo, hi, lowest)) return *is_entered;
        const double middle = lo + split_ratio * (hi - lo);
        return hi - lo > least_sector && search(lo, middle, lowest) && search(middle, hi, lowest);
    }
    // Along every line across the sector each two of the lowest change places once, so that those that are
    // lowest one after the other follow each other in one order. One between two others is among them if it
    // is lower wherever such two are equal.
    std::optional<bool> search_between(double lo, double hi, std::vector<std::size_t> lowest) {
        const Direction u = direction({lo, hi}), from = direction(lo), to = direction(hi);
        for (const std::size_t i : lowest)
            for (const std::size_t j : lowest) {
                if (i == j) continue;
                const auto before = sign(i, j, from), after = sign(i, j, to);
                if (!before || !after || *before != -*after || !turns(i, j, u)) return std::nullopt;
            }
        std::ranges::sort(lowest,
                          [&](std::size_t i, std::size_t j) { return sign(i, j, from) == Sign::Negative; });
        std::vector<bool> is_seen(lowest.size(), true);
        for (std::size_t i = 0; i < lowest.size(); ++i)
            for (std::size_t j = i + 1; j < lowest.size(); ++j)
                for (std::size_t k = j + 1; k < lowest.size(); ++k) {
                    const auto known = std::ranges::find_if(between_, [&](const TiedBetween& t) {
                        return t.middle == lowest[j] &&
                               std::minmax(t.outer[0], t.outer[1]) == std::minmax(lowest[i], lowest[k]);
                    });
                    if (known == between_.end()) return std::nullopt;
                    if (!known->shows) is_seen[j] = false;
                }
        if (!enter(lowest[0])) return false;
        std::size_t last = lowest[0];
        for (std::size_t j = 1; j < lowest.size(); ++j) {
            if (!is_seen[j]) continue;
            add_arm(lo, hi, last, lowest[j]);
            last = lowest[j];
        }
        return true;
    }
    // In two adjacent sectors one form is lowest.
    bool enter(std::size_t i) {
        if (!fan_.first.valid()) fan_.first = last_ = forms_[i];
        return last_ == forms_[i];
    }
    // The label changes from form i to form j.
    void cross(double lo, double hi, std::size_t i, std::size_t j) {
        while (hi - lo > narrow_sector) {
            const double middle = lo + split_ratio * (hi - lo);
            const auto s = sign(i, j, direction(middle));
            if (!s) break;
            (*s == Sign::Negative ? lo : hi) = middle;
        }
        add_arm(lo, hi, i, j);
    }
    void add_arm(double lo, double hi, std::size_t i, std::size_t j) {
        fan_.arms.push_back({origin_ + lo * along_, origin_ + hi * along_, forms_[i], forms_[j]});
        last_ = forms_[j];
    }

    std::span<const FormId> forms_;
    const std::vector<std::vector<TiedDifference>>& differences_;
    std::span<const TiedBetween> between_;
    Vector2d origin_, along_;
    Fan fan_;
    FormId last_;
    int sectors_ = 0;
};

}  // namespace

std::optional<Fan> find_fan(std::span<const FormId> forms,
                            const std::vector<std::vector<TiedDifference>>& differences,
                            std::span<const TiedBetween> between, std::span<const Vector2d> corners) {
    return FanSearch(forms, differences, between).run(corners);
}

}  // namespace vcell
