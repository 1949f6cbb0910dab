#include "ring_ties.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "../../core/platform.hpp"
#include "../objects/exact_space.hpp"

namespace vcell {

namespace {

// Parts of the region and of values within which places and forms are looked at together: with doubles they
// are found, and nothing is decided.
constexpr double rough_part = 1e-9;

// c0 + c1 y + c2 y^2.
using Quadratic = std::array<Exact, 3>;

Exact value_of(const Quadratic& q, const Exact& y) { return q[0] + y * (q[1] + y * q[2]); }
Interval slope_of(const Quadratic& q, const Interval& y) {
    return q[1].enclosure() + 2.0 * (q[2].enclosure() * y);
}

// A ring, and numbers p / q of it if it has such a place.
struct TieRing {
    Interval y;
    std::optional<std::array<Exact, 2>> place;
};

// C / k in doubles.
struct RowNearness {
    std::array<double, 3> c;

    double at(double y) const { return c[0] + y * (c[1] + y * c[2]); }
    double slope(double y) const { return c[1] + 2 * y * c[2]; }
    double size(double y) const {
        return std::abs(c[0]) + std::abs(y) * (std::abs(c[1]) + std::abs(y * c[2]));
    }
};

// The first place after `from` at which the two are equal, or nearly touch.
double next_meeting(const RowNearness& p, const RowNearness& q, double from) {
    const double c = q.c[0] - p.c[0], b = q.c[1] - p.c[1], a = q.c[2] - p.c[2];
    const double square = b * b, product = 4 * a * c, turn = square - product;
    if (turn < -rough_part * (square + std::abs(product))) return infinity;
    const double half = -0.5 * (b + std::copysign(std::sqrt(std::max(0.0, turn)), b));
    double first = infinity;
    for (const double y : {half / a, c / half})
        if (y > from && y < first) first = y;
    return first;
}

// Forms whose (b, b0) are multiples of one vector.
class Row {
public:
    Row(std::span<const RadialForm> forms, std::vector<std::uint32_t> items, double y0, double y1,
        std::vector<RingTie>& ties)
        : forms_(forms), items_(std::move(items)), y0_(y0), y1_(y1), ties_(ties) {
        const ExactVector first = direction(forms_[items_[0]]);
        for (const std::uint32_t i : items_) {
            const RadialForm& f = forms_[i];
            factors_.push_back(dot(direction(f), first));
            const double k = nearest(factors_.back());
            rough_.push_back({{nearest(f.c[0]) / k, nearest(f.c[1]) / k, nearest(f.c[2]) / k}});
        }
    }

    static ExactVector direction(const RadialForm& f) { return {f.b[0], f.b[2], f.b0}; }

    // From one end of the region to the other, from one nearest form to the next.
    void find() {
        const double room = rough_part * (y1_ - y0_);
        std::vector<std::size_t> here = nearest_at(y0_);
        look_at_end(AxialEnd::Low, y0_, here);
        std::size_t current = first_after(here, y0_);
        double y = y0_;
        for (std::size_t step = 0; step < 4 * items_.size(); ++step) {
            double next = infinity;
            for (std::size_t j = 0; j < items_.size(); ++j)
                if (j != current) next = std::min(next, next_meeting(rough_[current], rough_[j], y + room));
            if (!(next < y1_ - room)) break;
            here = nearest_at(next);
            look_at(next, here);
            current = first_after(here, next);
            y = next;
        }
        look_at_end(AxialEnd::High, y1_, nearest_at(y1_));
    }

private:
    std::vector<std::size_t> nearest_at(double y) const {
        double least = infinity;
        for (const RowNearness& n : rough_) least = std::min(least, n.at(y));
        std::vector<std::size_t> here;
        for (std::size_t i = 0; i < rough_.size(); ++i)
            if (rough_[i].at(y) - least <= rough_part * rough_[i].size(y)) here.push_back(i);
        return here;
    }
    std::size_t first_after(const std::vector<std::size_t>& here, double y) const {
        return *std::ranges::min_element(
            here, {}, [&](std::size_t i) { return std::pair(rough_[i].slope(y), rough_[i].c[2]); });
    }

    // C_i / k_i less C_j / k_j, times k_i k_j.
    Quadratic difference(std::size_t i, std::size_t j) const {
        const auto &c = forms_[items_[i]].c, &d = forms_[items_[j]].c;
        const Exact &k = factors_[i], &l = factors_[j];
        return {l * c[0] - k * d[0], l * c[1] - k * d[1], l * c[2] - k * d[2]};
    }

    void look_at_end(AxialEnd end, double place, const std::vector<std::size_t>& here) {
        const Exact y(place);
        std::vector<std::size_t> tied;
        for (const std::size_t i : here) {
            const Sign s = tied.empty() ? Sign::Zero : value_of(difference(i, tied[0]), y).sign();
            if (s == Sign::Negative) tied.clear();
            if (s != Sign::Positive) tied.push_back(i);
        }
        add({Interval(place), {{y, Exact(1.0)}}}, end, tied);
    }

    void look_at(double y, const std::vector<std::size_t>& here) {
        if (here.size() < 2) return;
        const auto [steepest, flattest] = std::ranges::minmax_element(
            here, {}, [&](std::size_t i) { return std::pair(rough_[i].slope(y), rough_[i].c[2]); });
        const std::size_t i = *steepest, j = *flattest;
        const Quadratic d = difference(i, j);
        const Exact turn = d[1] * d[1] - 4.0 * (d[0] * d[2]);
        std::optional<TieRing> ring;
        if (d[2].sign() == Sign::Zero) {
            ring = at_fraction(-d[0], d[1], y);
        } else if (turn.sign() == Sign::Zero) {
            ring = at_fraction(-d[1], 2.0 * d[2], y);
        } else if (turn.sign() == Sign::Positive) {
            for (const double side : {-1.0, 1.0}) {
                const Interval root =
                    (-d[1].enclosure() + side * sqrt(turn.enclosure())) / (2.0 * d[2].enclosure());
                if (is_near(root, y)) ring = TieRing{root, {}};
            }
        }
        if (!ring) return;
        std::vector<std::size_t> tied{i};
        if (j != i) tied.push_back(j);
        for (const std::size_t m : here)
            if (m != i && m != j && shares_ring(d, difference(m, i), y, *ring)) tied.push_back(m);
        add(*ring, {}, tied);
    }
    bool is_near(const Interval& root, double y) const {
        return std::abs(root.mid() - y) <= 1e3 * rough_part * (y1_ - y0_);
    }
    std::optional<TieRing> at_fraction(const Exact& p, const Exact& q, double y) const {
        if (q.sign() == Sign::Zero) return std::nullopt;
        const TieRing ring{p.enclosure() / q.enclosure(), {{p, q}}};
        return is_near(ring.y, y) ? std::optional(ring) : std::nullopt;
    }
    // Has e the root of d at the ring? What they have in common is a root of the combination without y^2, or
    // they are multiples of each other. Tells the ring's place where it is a fraction.
    bool shares_ring(const Quadratic& d, const Quadratic& e, double y, TieRing& ring) const {
        if (ring.place) return value_at(e, *ring.place).sign() == Sign::Zero;
        const Exact constant = e[2] * d[0] - d[2] * e[0], linear = e[2] * d[1] - d[2] * e[1];
        if (linear.sign() == Sign::Zero)
            return constant.sign() == Sign::Zero &&
                   (e[2].sign() != Sign::Zero || (e[1].sign() == Sign::Zero && e[0].sign() == Sign::Zero));
        const auto at = at_fraction(-constant, linear, y);
        if (!at || value_at(d, *at->place).sign() != Sign::Zero ||
            value_at(e, *at->place).sign() != Sign::Zero)
            return false;
        ring = *at;
        return true;
    }
    // Times q^2.
    static Exact value_at(const Quadratic& d, const std::array<Exact, 2>& place) {
        const auto& [p, q] = place;
        return q * q * d[0] + p * (q * d[1] + p * d[2]);
    }

    // The sign of i less j next to the ring, where they tie.
    std::optional<Sign> sign_beside(std::size_t i, std::size_t j, const TieRing& ring, bool is_after) const {
        const Quadratic d = difference(i, j);
        if (const auto s = slope_of(d, ring.y).sign(); s && *s != Sign::Zero) return is_after ? *s : -*s;
        if (!ring.place) return std::nullopt;
        const auto& [p, q] = *ring.place;
        const Sign s = (q * d[1] + 2.0 * (p * d[2])).sign() * q.sign();
        return s == Sign::Zero ? d[2].sign() : is_after ? s : -s;
    }
    std::optional<std::size_t> nearest_beside(const std::vector<std::size_t>& tied, const TieRing& ring,
                                              bool is_after) const {
        const auto is_nearest = [&](std::size_t i) {
            return std::ranges::all_of(tied, [&](std::size_t j) {
                return j == i || sign_beside(i, j, ring, is_after) == Sign::Negative;
            });
        };
        const auto found = std::ranges::find_if(tied, is_nearest);
        return found == tied.end() ? std::nullopt : std::optional(*found);
    }

    // Where i and j tie besides the ring. None if nowhere; the outer one if that is not told.
    std::optional<std::optional<Interval>> other_ring(std::size_t i, std::size_t j,
                                                      const TieRing& ring) const {
        const Quadratic d = difference(i, j);
        if (d[2].sign() == Sign::Zero || sign_beside(i, j, ring, true) == sign_beside(i, j, ring, false))
            return std::optional<Interval>();
        const Interval other = -d[1].enclosure() / d[2].enclosure() - ring.y;
        if (other.upper() < ring.y.lower() || other.lower() > ring.y.upper()) return std::optional(other);
        return std::nullopt;
    }

    void add(const TieRing& ring, std::optional<AxialEnd> end, const std::vector<std::size_t>& tied) {
        if (tied.size() < 2) return;
        const bool is_first = end == AxialEnd::Low, is_last = end == AxialEnd::High;
        const auto before = nearest_beside(tied, ring, is_first),
                   after = nearest_beside(tied, ring, !is_last);
        if (!before || !after) return;
        std::optional<Interval> elsewhere;
        if (*before != *after) {
            const auto other = other_ring(*before, *after, ring);
            if (!other) return;
            elsewhere = *other;
        }
        for (const std::size_t m : tied) {
            if (m == *before || m == *after) continue;
            double from = -infinity, to = infinity;
            bool is_told = true;
            const auto end_at = [&](std::size_t rival, bool is_after) {
                const auto other = other_ring(m, rival, ring);
                is_told = is_told && other;
                if (!other || !*other || ((*other)->lower() > ring.y.upper()) != is_after) return;
                if (is_after)
                    to = std::nextafter((*other)->lower(), -infinity);
                else
                    from = std::nextafter((*other)->upper(), infinity);
            };
            if (!is_first) end_at(*before, false);
            if (!is_last) end_at(*after, true);
            // One that touches may be come to twice, from both of its roots in doubles.
            const auto is_known = [&](const RingTie& tie) {
                return tie.form == items_[m] && tie.before == items_[*before] &&
                       tie.after == items_[*after] && tie.end == end && tie.y.contains(ring.y.mid());
            };
            if (is_told && std::ranges::none_of(ties_, is_known))
                ties_.push_back(
                    {items_[m], items_[*before], items_[*after], end, ring.y, elsewhere, from, to});
        }
    }

    std::span<const RadialForm> forms_;
    std::vector<std::uint32_t> items_;
    const double y0_, y1_;
    std::vector<RingTie>& ties_;
    std::vector<Exact> factors_;  // k, times one positive number
    std::vector<RowNearness> rough_;
};

}  // namespace

std::vector<RingTie> find_ring_ties(std::span<const RadialForm> forms, double y0, double y1) {
    struct Item {
        std::uint32_t form;
        std::array<double, 3> direction;
    };
    std::vector<Item> items;
    for (std::uint32_t i = 0; i < forms.size(); ++i) {
        const RadialForm& f = forms[i];
        if (f.has_root()) continue;
        const std::array b{nearest(f.b[0]), nearest(f.b[2]), nearest(f.b0)};
        const double size = std::hypot(b[0], b[1], b[2]);
        if (size > 0 && std::isfinite(size)) items.push_back({i, {b[0] / size, b[1] / size, b[2] / size}});
    }
    std::ranges::sort(items, {}, &Item::direction);
    const auto are_near = [](const Item& a, const Item& b) {
        return std::abs(a.direction[1] - b.direction[1]) <= rough_part &&
               std::abs(a.direction[2] - b.direction[2]) <= rough_part;
    };
    const auto are_parallel = [&](const Item& a, const Item& b) {
        const ExactVector p = Row::direction(forms[a.form]), q = Row::direction(forms[b.form]);
        return are_near(a, b) && cross(p, q).is_zero() && dot(p, q).sign() == Sign::Positive;
    };
    std::vector<RingTie> ties;
    std::vector<bool> is_taken(items.size(), false);
    for (std::size_t i = 0; i < items.size(); ++i) {
        if (is_taken[i]) continue;
        std::vector<std::uint32_t> row{items[i].form};
        for (std::size_t j = i + 1;
             j < items.size() && items[j].direction[0] - items[i].direction[0] <= rough_part; ++j)
            if (!is_taken[j] && are_parallel(items[i], items[j])) {
                is_taken[j] = true;
                row.push_back(items[j].form);
            }
        if (row.size() > 1) Row(forms, std::move(row), y0, y1, ties).find();
    }
    return ties;
}

}  // namespace vcell
