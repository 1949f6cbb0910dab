#include "axial_ties.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "../bases/canonical.hpp"
#include "../objects/exact_space.hpp"

namespace vcell {

namespace {

// F in doubles: places are found with it, nothing is decided.
struct NearnessAtAngle {
    std::uint32_t form;
    double x, z, w;

    double at(double angle) const { return x * std::sin(angle) + z * std::cos(angle) + w; }
    double slope(double angle) const { return x * std::cos(angle) - z * std::sin(angle); }
};

// The first angle after `from` at which q comes up to p, within a turn.
double meeting(const NearnessAtAngle& p, const NearnessAtAngle& q, double from) {
    const double x = q.x - p.x, z = q.z - p.z, w = q.w - p.w, size = std::hypot(x, z);
    constexpr double whole = 2 * std::numbers::pi;
    if (!(std::abs(w) < size)) return from + whole;
    // x sin + z cos + w = size cos(angle - phase) + w rises through zero half-way before its maximum.
    const double angle = std::atan2(x, z) - std::acos(-w / size);
    double turn = std::fmod(angle - from, whole);
    if (turn < 0) turn += whole;
    return from + turn;
}

// F_g - F_f, times c0 of both: x, z and w as NearnessAtAngle has them.
ExactVector difference(const RadialForm& f, const RadialForm& g) {
    return {f.c[0] * g.b[0] - g.c[0] * f.b[0], f.c[0] * g.b[2] - g.c[0] * f.b[2],
            f.c[0] * g.b0 - g.c[0] * f.b0};
}

// Is F_j = l F_a + (1 - l) F_b, 0 < l < 1?
bool is_between(const RadialForm& j, const RadialForm& a, const RadialForm& b) {
    const ExactVector to_a = difference(j, a), to_b = difference(j, b);
    return cross(to_a, to_b).is_zero() && dot(to_a, to_b).sign() == Sign::Negative;
}

// Is F_j <= l F_a + (1 - l) F_b all around, and equal where all three are, over one generator? With A = F_a -
// F_j, B = F_b - F_j and <A, B> = A_w B_w - A_x B_x - A_z B_z a function is positive all around but for one
// zero where <D, D> = 0 and D_w > 0. Of D = s A + t B, where <A, A> and <B, B> are negative, <D, D> is
// greatest for s : t = sqrt(-<B, B>) : sqrt(-<A, A>), and zero there if <A, B> is the root of <A, A> <B, B>.
// Then <A, D> = 0, which is the value of A at the zero of D, times D_w.
bool touches_mean(const RadialForm& j, const RadialForm& a, const RadialForm& b) {
    for (const RadialForm* f : {&j, &a, &b})
        if (f->c[0].sign() != Sign::Positive) return false;
    const auto product = [](const ExactVector& p, const ExactVector& q) {
        return p.z * q.z - p.x * q.x - p.y * q.y;
    };
    const ExactVector to_a = difference(j, a), to_b = difference(j, b);
    const Exact aa = product(to_a, to_a), bb = product(to_b, to_b), ab = product(to_a, to_b);
    if (aa.sign() != Sign::Negative || bb.sign() != Sign::Negative || ab.sign() != Sign::Positive ||
        (ab * ab - aa * bb).sign() != Sign::Zero)
        return false;
    const Sign of_a = to_a.z.sign(), of_b = to_b.z.sign();
    if (of_a == of_b) return of_a == Sign::Positive;
    if (of_a == Sign::Zero || of_b == Sign::Zero) return of_a == Sign::Positive || of_b == Sign::Positive;
    const Sign longer = (aa * to_b.z * to_b.z - bb * to_a.z * to_a.z).sign();  // of a's part
    return longer == of_a;
}

// How far distances from the middle one change when its F gives way to one between those of a and b, by the
// header's map from F to m and delta. With J = (X, w) of the middle one, the mean P = J - E and M of both,
//
//     m' - m = 2 (P_X M_J - J_X M_P) / (M_P M_J) = 2 (J_X (M_J - M_P) - E_X M_J) / (M_P M_J)
//
// and likewise delta' - delta; M_J - M_P = 2 (J_X.E_X - J_w E_w) - |E_X|^2 + E_w^2. All terms have a factor
// E, so intervals cancel nothing. What counts is that P lies between A and B: any s of (0, 1) will do.
double move_between(const RadialForm& j, const RadialForm& a, const RadialForm& b, double s) {
    const auto scaled = [](const RadialForm& f) { return ExactVector(f.b[0], f.b[2], f.b0); };
    const Exact ab = a.c[0] * b.c[0];
    const ExactVector e = ab * scaled(j) - (j.c[0] * (1.0 - Exact(s)) * b.c[0]) * scaled(a) -
                          (j.c[0] * Exact(s) * a.c[0]) * scaled(b);
    const Interval two(2.0), cj = j.c[0].enclosure(), over = two / (cj * ab.enclosure());
    const std::array<Interval, 3> E{over * e.x.enclosure(), over * e.y.enclosure(), over * e.z.enclosure()},
        J{two * j.b[0].enclosure() / cj, two * j.b[2].enclosure() / cj, two * j.b0.enclosure() / cj};
    const Interval MJ = square(J[0]) + square(J[1]) - square(J[2]),
                   change = two * (J[0] * E[0] + J[1] * E[1] - J[2] * E[2]) - square(E[0]) - square(E[1]) +
                            square(E[2]),
                   scale = two / ((MJ - change) * MJ);
    std::array<Interval, 3> moves;
    for (int k = 0; k < 3; ++k) moves[k] = scale * (J[k] * change - E[k] * MJ);
    const double move = (sqrt(square(moves[0]) + square(moves[1])) + Interval(moves[2].magnitude())).upper();
    const bool is_told = s > 0 && s < 1 && (MJ - change).lower() > 0 && std::isfinite(move);
    return is_told ? move : std::numeric_limits<double>::infinity();
}

// Is it so up to narrow_tie of the nearest value over the generator at an angle, and the strip narrow in
// which j may be nearer? Twins of one another tie up to that next to it, and farther away are told apart.
bool is_nearly_between(const NearnessAtAngle& j, const NearnessAtAngle& a, const NearnessAtAngle& b,
                       double angle) {
    const Vec3 to_a(a.x - j.x, a.z - j.z, a.w - j.w), to_b(b.x - j.x, b.z - j.z, b.w - j.w);
    // The distance from the segment between a and b, as coefficients.
    const double off = std::numbers::sqrt2 * to_a.cross(to_b).norm() / (to_a - to_b).norm();
    const auto slope = [&](const Vec3& d) {
        return std::abs(d.x() * std::cos(angle) - d.y() * std::sin(angle));
    };
    return to_a.dot(to_b) < 0 && off <= narrow_tie * std::abs(b.at(angle)) &&
           off <= narrow_place * std::min(slope(to_a), slope(to_b));
}

// Once around the axis, from one nearest form to the next: visit(j, a, b, angle) for each form j that about
// the generator at an angle is as near as the nearest ones before and behind it, a and b. With doubles they
// are found, and nothing is decided.
template <class Visit>
void visit_changes(std::span<const RadialForm> forms, Visit&& visit) {
    constexpr double whole = 2 * std::numbers::pi, near = 1e-9;
    std::vector<NearnessAtAngle> all;
    for (std::uint32_t i = 0; i < forms.size(); ++i) {
        const RadialForm& f = forms[i];
        if (f.has_root() || f.c[1].sign() != Sign::Zero || f.c[2].sign() != Sign::Zero) continue;
        const double c = nearest(f.c[0]);
        all.push_back({i, nearest(f.b[0]) / c, nearest(f.b[2]) / c, nearest(f.b0) / c});
    }
    if (all.size() < 3) return;
    // All that are nearest over a generator, the one that is nearest beyond it first.
    const auto nearest_at = [&](double angle) {
        std::vector<const NearnessAtAngle*> here;
        double value = -std::numeric_limits<double>::infinity();
        for (const NearnessAtAngle& n : all) value = std::max(value, n.at(angle));
        for (const NearnessAtAngle& n : all)
            if (value - n.at(angle) <= near * (std::hypot(n.x, n.z) + std::abs(n.w))) here.push_back(&n);
        std::ranges::iter_swap(
            here.begin(),
            std::ranges::max_element(here, {}, [&](const NearnessAtAngle* n) { return n->slope(angle); }));
        return here;
    };
    // As many steps as there can be changes.
    double angle = 0;
    const NearnessAtAngle* current = nearest_at(angle).front();
    for (std::size_t step = 0; step < 2 * all.size() && angle < whole; ++step) {
        double next = angle + whole;
        for (const NearnessAtAngle& n : all)
            if (&n != current)
                if (const double a = meeting(*current, n, angle + near); a < next) next = a;
        const std::vector<const NearnessAtAngle*> here = nearest_at(next);
        const NearnessAtAngle* following = here.front();
        for (const NearnessAtAngle* n : here)
            if (n != current && n != following) visit(*n, *current, *following, next);
        current = following;
        angle = next;
    }
}

// The tangent of half the angle about (0, 0, 1) over the front, x, of the generator at p / p.z, and over the
// back that about (0, 0, -1), plus 2. Pre: p.x^2 + p.y^2 = p.z^2 > 0.
Interval chart_place(const ExactVector& p) {
    const Sign side = p.z.sign();
    const auto turned = [&](const Exact& e) { return side == Sign::Negative ? -e : e; };
    const Exact sine = turned(p.x), cosine = turned(p.y), size = turned(p.z);
    if (cosine.sign() != Sign::Negative) return sine.enclosure() / (size + cosine).enclosure();
    return Interval(2.0) + (-sine).enclosure() / (size - cosine).enclosure();
}

// Where D, which is zero at p / p.z, is zero as well: p mirrored in the direction in which D grows most.
ExactVector other_zero(const ExactVector& D, const ExactVector& p) {
    const Exact square = D.x * D.x + D.y * D.y, along = D.x * p.x + D.y * p.y;
    return {2.0 * along * D.x - square * p.x, 2.0 * along * D.y - square * p.y, square * p.z};
}

// How D changes there as the angle grows.
Sign slope_at(const ExactVector& D, const ExactVector& p) {
    return (D.x * p.y - D.y * p.x).sign() * p.z.sign();
}

// The ranges of PassingTie; none if it is no such tie, or its generator is not told from the others.
std::vector<std::array<double, 2>> passing_ranges(const RadialForm& j, const RadialForm& a,
                                                  const RadialForm& b) {
    for (const RadialForm* f : {&j, &a, &b})
        if (f->c[0].sign() != Sign::Positive) return {};
    const ExactVector to_a = difference(j, a), to_b = difference(j, b), p = cross(to_a, to_b);
    if (p.z.sign() == Sign::Zero || (p.x * p.x + p.y * p.y - p.z * p.z).sign() != Sign::Zero) return {};
    if (slope_at(to_a, p) != Sign::Negative || slope_at(to_b, p) != Sign::Positive) return {};
    constexpr double around = 4;  // of x
    const Interval at = chart_place(p);
    const auto ahead = [&](const Interval& from, const Interval& to) {
        const Interval way = to - from;
        return way.upper() < 0 ? way + Interval(around) : way;
    };
    const Interval back = ahead(chart_place(other_zero(to_a, p)), at),
                   forth = ahead(at, chart_place(other_zero(to_b, p)));
    if (!(back.lower() > 0 && forth.lower() > 0)) return {};
    if ((back + forth).lower() > around) return {{-infinity, infinity}};
    const double from = (at - Interval(back.lower())).upper(), to = (at + Interval(forth.lower())).lower();
    std::vector<std::array<double, 2>> ranges{{from, to}};
    if (from < -1) ranges = {{-infinity, to}, {(Interval(from) + Interval(around)).upper(), infinity}};
    if (to > 3) {
        ranges.back()[1] = infinity;
        ranges.push_back({-infinity, (Interval(to) - Interval(around)).lower()});
    }
    return ranges;
}

}  // namespace

std::vector<AxialTie> find_axial_ties(std::span<const RadialForm> forms) {
    std::vector<AxialTie> ties;
    visit_changes(forms, [&](const NearnessAtAngle& n, const NearnessAtAngle& before,
                             const NearnessAtAngle& after, double angle) {
        const RadialForm &j = forms[n.form], &a = forms[before.form], &b = forms[after.form];
        AxialTie tie{n.form, before.form, after.form, 0};
        if (!is_between(j, a, b) && !touches_mean(j, a, b)) {
            if (!is_nearly_between(n, before, after, angle)) return;
            const Vec3 to_j(n.x - before.x, n.z - before.z, n.w - before.w),
                to_b(after.x - before.x, after.z - before.z, after.w - before.w);
            tie.move = move_between(j, a, b, to_j.dot(to_b) / to_b.squaredNorm());
        }
        if (std::ranges::find(ties, tie) == ties.end()) ties.push_back(tie);
    });
    // Nobody's neighbour may be left out itself, as when the walk began in a narrow strip.
    const auto is_middle = [&](std::uint32_t form) {
        return std::ranges::find(ties, form, &AxialTie::middle) != ties.end();
    };
    const bool is_sound = std::ranges::none_of(
        ties, [&](const AxialTie& t) { return is_middle(t.before) || is_middle(t.after); });
    if (!is_sound) ties.clear();
    return ties;
}

std::vector<PassingTie> find_passing_ties(std::span<const RadialForm> forms) {
    std::vector<PassingTie> ties;
    visit_changes(forms, [&](const NearnessAtAngle& n, const NearnessAtAngle& before,
                             const NearnessAtAngle& after, double) {
        const auto is_known = [&](const PassingTie& t) {
            return t.form == n.form && t.before == before.form && t.after == after.form;
        };
        if (std::ranges::any_of(ties, is_known)) return;
        auto ranges = passing_ranges(forms[n.form], forms[before.form], forms[after.form]);
        if (!ranges.empty()) ties.push_back({n.form, before.form, after.form, std::move(ranges)});
    });
    return ties;
}

}  // namespace vcell
