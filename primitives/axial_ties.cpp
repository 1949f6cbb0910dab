#include "axial_ties.hpp"

#include <algorithm>
#include <cmath>
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
    // Once around, from one nearest form to the next, with as many steps as there can be changes.
    double angle = 0;
    const Nearness* current =
        &*std::ranges::max_element(all, {}, [&](const Nearness& n) { return n.at(angle); });
    for (std::size_t step = 0; step < 2 * all.size() && angle < whole; ++step) {
        double next = angle + whole;
        for (const Nearness& n : all)
            if (&n != current)
                if (const double a = meeting(*current, n, angle + near); a < next) next = a;
        std::vector<const Nearness*> here;
        const double value = current->at(next),
                     size = std::hypot(current->x, current->z) + std::abs(current->w);
        for (const Nearness& n : all)
            if (&n != current && std::abs(n.at(next) - value) <= near * size) here.push_back(&n);
        if (here.empty()) break;
        const Nearness* following =
            *std::ranges::max_element(here, {}, [&](const Nearness* n) { return n->slope(next); });
        for (const Nearness* n : here)
            if (n != following && is_between(forms[n->form], forms[current->form], forms[following->form]))
                ties.push_back({n->form, current->form, following->form});
        current = following;
        angle = next;
    }
    return ties;
}

}  // namespace vcell
