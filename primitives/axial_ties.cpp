#include "axial_ties.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base_problem.hpp"
#include "exact_space.hpp"

namespace vcell {

namespace {

// F in doubles: places are found with it, nothing is decided.
struct Nearness {
    std::uint32_t form;
    double x, z, w;

    double at(double angle) const { return x * std::sin(angle) + z * std::cos(angle) + w; }
    double slope(double angle) const { return x * std::cos(angle) - z * std::sin(angle); }
};

// The first angle after `from` at which q comes up to p, within a turn.
double meeting(const Nearness& p, const Nearness& q, double from) {
    const double x = q.x - p.x, z = q.z - p.z, w = q.w - p.w, size = std::hypot(x, z);
    constexpr double whole = 2 * std::numbers::pi;
    if (!(std::abs(w) < size)) return from + whole;
    // x sin + z cos + w = size cos(angle - phase) + w rises through zero half-way before its maximum.
    const double angle = std::atan2(x, z) - std::acos(-w / size);
    double turn = std::fmod(angle - from, whole);
    if (turn < 0) turn += whole;
    return from + turn;
}

// Is F_j = l F_a + (1 - l) F_b, 0 < l < 1?
bool is_between(const RadialForm& j, const RadialForm& a, const RadialForm& b) {
    const auto direction = [](const RadialForm& f, const RadialForm& g) {  // F_g - F_f, times c0 of both
        return ExactVector(f.c[0] * g.b[0] - g.c[0] * f.b[0], f.c[0] * g.b[2] - g.c[0] * f.b[2],
                           f.c[0] * g.b0 - g.c[0] * f.b0);
    };
    const ExactVector to_a = direction(j, a), to_b = direction(j, b);
    return cross(to_a, to_b).is_zero() && dot(to_a, to_b).sign() == Sign::Negative;
}

// Is it so up to narrow_tie of `value`?
bool is_nearly_between(const Nearness& j, const Nearness& a, const Nearness& b, double value) {
    const Vec3 to_a(a.x - j.x, a.z - j.z, a.w - j.w), to_b(b.x - j.x, b.z - j.z, b.w - j.w);
    // The distance from the segment between a and b, as coefficients.
    return to_a.dot(to_b) < 0 && std::numbers::sqrt2 * to_a.cross(to_b).norm() <=
                                     narrow_tie * std::abs(value) * (to_a - to_b).norm();
}

}  // namespace

std::vector<AxialTie> find_axial_ties(std::span<const RadialForm> forms) {
    constexpr double whole = 2 * std::numbers::pi, near = 1e-9;
    std::vector<Nearness> all;
    for (std::uint32_t i = 0; i < forms.size(); ++i) {
        const RadialForm& f = forms[i];
        if (f.has_root() || f.c[1].sign() != Sign::Zero || f.c[2].sign() != Sign::Zero) continue;
        const double c = nearest(f.c[0]);
        all.push_back({i, nearest(f.b[0]) / c, nearest(f.b[2]) / c, nearest(f.b0) / c});
    }
    std::vector<AxialTie> ties;
    if (all.size() < 3) return ties;
    // All that are nearest over a generator, the one that is nearest beyond it first.
    const auto nearest_at = [&](double angle) {
        std::vector<const Nearness*> here;
        double value = -std::numeric_limits<double>::infinity();
        for (const Nearness& n : all) value = std::max(value, n.at(angle));
        for (const Nearness& n : all)
            if (value - n.at(angle) <= near * (std::hypot(n.x, n.z) + std::abs(n.w))) here.push_back(&n);
        std::ranges::iter_swap(here.begin(), std::ranges::max_element(here, {}, [&](const Nearness* n) {
                                   return n->slope(angle);
                               }));
        return here;
    };
    // Once around, from one nearest form to the next, with as many steps as there can be changes.
    double angle = 0;
    const Nearness* current = nearest_at(angle).front();
    for (std::size_t step = 0; step < 2 * all.size() && angle < whole; ++step) {
        double next = angle + whole;
        for (const Nearness& n : all)
            if (&n != current)
                if (const double a = meeting(*current, n, angle + near); a < next) next = a;
        const std::vector<const Nearness*> here = nearest_at(next);
        const Nearness* following = here.front();
        for (const Nearness* n : here) {
            if (n == current || n == following) continue;
            const bool is_exact = is_between(forms[n->form], forms[current->form], forms[following->form]);
            const AxialTie tie{n->form, current->form, following->form, is_exact};
            if ((is_exact || is_nearly_between(*n, *current, *following, following->at(next))) &&
                std::ranges::find(ties, tie) == ties.end())
                ties.push_back(tie);
        }
        current = following;
        angle = next;
    }
    // Nobody's neighbour may be left out itself, as when the walk began in a narrow strip.
    const auto is_middle = [&](std::uint32_t form) {
        return std::ranges::find(ties, form, &AxialTie::middle) != ties.end();
    };
    const bool is_sound = std::ranges::none_of(
        ties, [&](const AxialTie& t) { return is_middle(t.before) || is_middle(t.after); });
    if (!is_sound) ties.clear();
    return ties;
}

}  // namespace vcell
