/// One step of the interval-Newton method on a box, in any interval arithmetic.
///
/// With the box's middle m, the unknown offset h and any matrix B of doubles, every root m + h in the
/// box satisfies
///
///     h = -B f(m) + (I - B J) h - (B Q)(h, h)
///
/// where J = f'(m) and Q are the quadratic parts; for a system that is not quadratic J encloses the
/// derivative over the whole box and Q = 0 [Krawczyk69]. Combining the quadratic parts before they are
/// bounded keeps what cancels in them. The right side over all h of the box is the box's image:
/// - roots lie in box and image, so an image that misses the box proves that there is none;
/// - an image inside the box proves a root there (Brouwer's fixed-point theorem);
/// - |I - B f'| < 1 over the box in a weighted maximum norm makes f injective there: one root at most
///   [Neumaier90, ch. 5].
///
/// B approximates J^-1 where J is regular. Where the linear part of some combination of equations is
/// lost in its quadratic part, that combination is kept aside as a constraint: it is what separates, or
/// shows that nothing separates, nearly double roots.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "../../numbers/jet.hpp"
#include "../systems/quadratic_system.hpp"
#include "box.hpp"

namespace vcell {

template <class T, int N>
struct Step {
    bool empty = false;        ///< no root in the box
    bool injective = false;    ///< one root at most in the box
    bool exists = false;       ///< a root in the image, which lies in the box
    bool stalled = false;      ///< rounding hides what smaller boxes would show
    std::array<T, N> image{};  ///< contains all roots of the box
    int split = 0;             ///< the unknown that most of the image's width comes from

    bool unique() const { return exists && injective; }
};

/// f near a box: f(m + h) is enclosed by value + jacobian h + quadratic(h, h) for all h of the box.
template <class T, int N>
struct LocalModel {
    std::array<T, N> value;
    std::array<std::array<T, N>, N> jacobian;  ///< [equation][unknown]
    const QuadraticForms<N, T>* forms = nullptr;
    bool excluded = false;  ///< the plain evaluation over the box misses zero
};

/// The offsets h of a box about its middle m, and their largest magnitudes in double.
template <class T, int N>
struct Offsets {
    std::array<T, N> m;
    std::array<T, N> h;
    std::array<double, N> u;

    explicit Offsets(const std::array<T, N>& box) {
        for (int i = 0; i < N; ++i) set(i, T(box[i].mid()), box[i] - T(box[i].mid()));
    }
    /// The offsets of the box that is middle + d in every unknown, for callers who chose the middle.
    Offsets(const std::array<T, N>& middle, const T& d) {
        for (int i = 0; i < N; ++i) set(i, middle[i], d);
    }
    static double magnitude(const Interval& x) { return x.magnitude(); }
    static double magnitude(const Wide& x) { return x.enclosure().magnitude(); }

private:
    void set(int i, const T& middle, const T& offset) {
        m[i] = middle;
        h[i] = offset;
        u[i] = magnitude(offset);
    }
};

inline double approximate(const Interval& x) { return x.mid(); }
inline double approximate(const Wide& x) { return x.approximation(); }

/// A quadratic system in the arithmetic of T.
template <class T, int N>
class QuadraticModel {
public:
    explicit QuadraticModel(QuadraticForms<N, T> forms) : forms_(std::move(forms)) {}

    LocalModel<T, N> at(const std::array<T, N>&, const Offsets<T, N>& offsets) const {
        LocalModel<T, N> local;
        local.forms = &forms_;
        const auto& m = offsets.m;
        for (int k = 0; k < N; ++k) {
            local.value[k] = forms_.constant[k];
            for (int i = 0; i < N; ++i) {
                T half = forms_.linear[i][k];
                for (int j = i; j < N; ++j) half += forms_.quadratic[forms_.pair(i, j)][k] * m[j];
                local.value[k] += half * m[i];
                for (int j = 0; j <= i; ++j) half += forms_.quadratic[forms_.pair(j, i)][k] * m[j];
                local.jacobian[k][i] = half;
            }
        }
        return local;
    }

private:
    QuadraticForms<N, T> forms_;
};

/// A system given by its values with their derivatives: a callable that takes a box or a point and returns a
/// LocalModel, value and jacobian enclosed over it. Where values over boxes are not worth computing they are
/// left whole.
template <class T, int N, class Linearise>
class LinearisedModel {
public:
    explicit LinearisedModel(Linearise linearise) : linearise_(std::move(linearise)) {}

    LocalModel<T, N> at(const std::array<T, N>& box, const Offsets<T, N>& offsets) const {
        LocalModel<T, N> local = linearise_(box);
        for (const T& v : local.value) local.excluded = local.excluded || v.lower() > 0 || v.upper() < 0;
        const auto is_point = [](const T& side) { return side.lower() == side.upper(); };
        if (!local.excluded && !std::all_of(box.begin(), box.end(), is_point))
            local.value = linearise_(offsets.m).value;
        return local;
    }

private:
    Linearise linearise_;
};

/// Any callable generic in the number type.
template <class T, int N, class System>
class CallableModel {
public:
    explicit CallableModel(const System& system) : system_(system) {}

    LocalModel<T, N> at(const std::array<T, N>& box, const Offsets<T, N>& offsets) const {
        LocalModel<T, N> local;
        const auto over_box = differentiate(system_, box);
        for (int k = 0; k < N; ++k) {
            local.jacobian[k] = over_box[k].gradient;
            const auto& v = over_box[k].value;
            if (v.lower() > 0 || v.upper() < 0) local.excluded = true;
            local.value[k] = v;
        }
        if (!local.excluded) local.value = system_(offsets.m);
        return local;
    }

private:
    const System& system_;
};

namespace detail {

/// Rows of doubles that combine the equations: `row[i]` isolates unknown i where solved[i]; the other
/// rows are combinations whose linear part is smaller than their quadratic part or rounding.
template <int N>
struct Preconditioner {
    std::array<std::array<double, N>, N> row{};
    std::array<bool, N> solved{};
};

/// Gauss-Jordan elimination with complete pivoting, unknowns scaled by u and rows by `noise`, the size of
/// what is not linear in them, as far as pivots are larger than `least_pivot` times their row's noise.
/// Doubles throughout: any result is valid, a good one is useful.
template <int N>
Preconditioner<N> precondition(std::array<std::array<double, N>, N> a, const std::array<double, N>& u,
                               const std::array<double, N>& noise, double least_pivot) {
    Preconditioner<N> p;
    std::array<std::array<double, N>, N> b{};
    std::array<int, N> unknown_of;
    std::array<bool, N> used{};
    unknown_of.fill(-1);
    for (int k = 0; k < N; ++k) b[k][k] = 1;
    for (int step = 0; step < N; ++step) {
        int row = -1, column = -1;
        double best = least_pivot;
        for (int k = 0; k < N; ++k) {
            if (unknown_of[k] >= 0) continue;
            double rest = std::numeric_limits<double>::min();
            for (int l = 0; l < N; ++l) rest += std::abs(b[k][l]) * noise[l];
            for (int i = 0; i < N; ++i) {
                if (used[i]) continue;
                const double size = std::abs(a[k][i]) * u[i] / rest;
                if (size > best) best = size, row = k, column = i;
            }
        }
        if (row < 0) break;
        unknown_of[row] = column;
        used[column] = true;
        const double scale = 1 / a[row][column];
        for (int i = 0; i < N; ++i) a[row][i] *= scale, b[row][i] *= scale;
        for (int k = 0; k < N; ++k) {
            if (k == row) continue;
            const double factor = a[k][column];
            for (int i = 0; i < N; ++i) {
                a[k][i] -= factor * a[row][i];
                b[k][i] -= factor * b[row][i];
            }
        }
    }
    int spare = 0;
    for (int k = 0; k < N; ++k) {
        int i = unknown_of[k];
        if (i < 0) {
            while (used[spare]) ++spare;
            i = spare++;
        }
        p.row[i] = b[k];
        p.solved[i] = unknown_of[k] >= 0;
    }
    return p;
}

/// One combination of the equations over the box: value + sum linear_i h_i + sum quadratic_ij h_i h_j.
template <class T, int N>
struct Combination {
    T value{0.0};
    std::array<T, N> linear{};
    std::array<T, QuadraticForms<N, T>::pairs> quadratic{};

    Combination(const LocalModel<T, N>& model, const std::array<double, N>& row) {
        for (int k = 0; k < N; ++k) {
            if (row[k] == 0) continue;
            const T b(row[k]);
            value += b * model.value[k];
            for (int i = 0; i < N; ++i) linear[i] += b * model.jacobian[k][i];
            if (model.forms != nullptr)
                for (std::size_t ij = 0; ij < quadratic.size(); ++ij)
                    quadratic[ij] += b * model.forms->quadratic[ij][k];
        }
    }
};

}  // namespace detail

/// Inverse: B = J^-1 even if J is nearly singular, best for large boxes. RankRevealing: a linear part
/// below half of what hides it isolates nothing, for small boxes that do not shrink otherwise.
enum class Preconditioning { Inverse, RankRevealing };

/// The step described above, of f as `local` gives it about the middle of `box`; at = Offsets(box). `box` may
/// be unbounded or wide: then nothing is claimed.
template <class T, int N>
Step<T, N> krawczyk_step(const LocalModel<T, N>& local, const Offsets<T, N>& at, const std::array<T, N>& box,
                         Preconditioning preconditioning) {
    using Forms = QuadraticForms<N, T>;
    const auto magnitude = [](const T& x) { return Offsets<T, N>::magnitude(x); };
    Step<T, N> result;
    result.image = box;
    if (local.excluded) {
        result.empty = true;
        return result;
    }

    // What hides the linear part of each equation: its curvature over the box, and rounding.
    std::array<std::array<double, N>, N> jacobian;
    std::array<double, N> noise{}, rounding{};
    for (int k = 0; k < N; ++k) {
        rounding[k] = magnitude(local.value[k] - local.value[k].mid());
        for (int i = 0; i < N; ++i) {
            jacobian[k][i] = approximate(local.jacobian[k][i]);
            noise[k] += magnitude(local.jacobian[k][i] - T(jacobian[k][i])) * at.u[i];
        }
        if (local.forms != nullptr)
            for (int i = 0; i < N; ++i)
                for (int j = i; j < N; ++j)
                    noise[k] += magnitude(local.forms->quadratic[Forms::pair(i, j)][k]) * at.u[i] * at.u[j];
        noise[k] += rounding[k];
    }
    const detail::Preconditioner<N> b = detail::precondition<N>(
        jacobian, at.u, noise, preconditioning == Preconditioning::Inverse ? 0.0 : 0.5);

    std::array<T, Forms::pairs> products;
    if (local.forms != nullptr)
        for (int i = 0; i < N; ++i) {
            products[Forms::pair(i, i)] = square(at.h[i]);
            for (int j = i + 1; j < N; ++j) products[Forms::pair(i, j)] = at.h[i] * at.h[j];
        }

    bool inside = true, contracts = true;
    int solved = 0, solved_hidden = 0, spare = 0, spare_hidden = 0;
    std::array<double, N> score{};
    for (int r = 0; r < N; ++r) {
        const detail::Combination<T, N> g(local, b.row[r]);
        double hidden_by = 0;  // the part of the row's value that is rounding
        for (int k = 0; k < N; ++k) hidden_by += std::abs(b.row[r][k]) * rounding[k];

        std::array<double, N> share{};  // of each unknown in the row's width
        T rest = g.value;               // all but what isolates h_r
        for (int i = 0; i < N; ++i) {
            const T e = b.solved[r] && i == r ? g.linear[i] - T(1.0) : g.linear[i];
            share[i] = magnitude(e) * at.u[i];
            rest += e * at.h[i];
        }
        Interval variation(0.0);  // of the row's derivatives over the box, times u
        for (int i = 0; i < N; ++i) variation += Interval(share[i]);
        if (local.forms != nullptr)
            for (int i = 0; i < N; ++i)
                for (int j = i; j < N; ++j) {
                    const T& q = g.quadratic[Forms::pair(i, j)];
                    const Interval size = Interval(magnitude(q)) * Interval(at.u[i]) * Interval(at.u[j]);
                    variation += size + size;
                    share[i] += size.upper();
                    share[j] += size.upper();
                    if (b.solved[r] || i != r || j != r) rest += q * products[Forms::pair(i, j)];
                }

        if (b.solved[r]) {
            const T image = at.m[r] - rest;
            inside = inside && is_subset(image, box[r]);
            contracts = contracts && variation.upper() < at.u[r];
            const bool hidden = hidden_by > 0.25 * at.u[r];
            ++solved;
            solved_hidden += hidden;
            if (const auto kept = intersection(image, box[r]))
                result.image[r] = image;
            else
                result.empty = true;
            for (int i = 0; i < N && !hidden; ++i) score[i] += share[i] / at.u[r];
        } else {
            inside = contracts = false;
            // 0 = rest + q h_r^2: there must be a solution, and it bounds h_r.
            const T& q = g.quadratic[Forms::pair(r, r)];
            const T whole = local.forms != nullptr ? rest + q * products[Forms::pair(r, r)] : rest;
            double range = 0;
            for (const double s : share) range += s;
            if (whole.lower() > 0 || whole.upper() < 0) result.empty = true;
            // A matter of where to stop: what rounding hides more of smaller boxes would not show.
            constexpr double hidden_part = 0x1p-6;
            const bool hidden = hidden_by > hidden_part * range;
            ++spare;
            spare_hidden += hidden;
            if (local.forms != nullptr && q.sign().has_value() && q.sign() != Sign::Zero) {
                const T h2 = -rest / q;
                if (h2.upper() < 0) {
                    result.empty = true;
                } else {
                    const T root = sqrt(h2);
                    const T most(root.upper(), root.upper());
                    if (const auto kept = intersection(box[r], at.m[r] + hull(-most, most)))
                        result.image[r] = *kept;
                }
            }
            for (int i = 0; i < N && !hidden; ++i)
                score[i] += share[i] / (range + std::numeric_limits<double>::min());
        }
        if (result.empty) return result;
    }
    result.exists = inside;
    result.injective = contracts;
    result.stalled = spare > 0 ? spare_hidden == spare : solved_hidden == solved;
    result.split = static_cast<int>(std::max_element(score.begin(), score.end()) - score.begin());
    return result;
}

// Those of the engine, compiled once.
extern template Step<Interval, 2> krawczyk_step<Interval, 2>(const LocalModel<Interval, 2>&,
                                                             const Offsets<Interval, 2>&,
                                                             const IntervalBox<2>&, Preconditioning);
extern template Step<Wide, 2> krawczyk_step<Wide, 2>(const LocalModel<Wide, 2>&, const Offsets<Wide, 2>&,
                                                     const WideBox<2>&, Preconditioning);

/// The step for a model, which is asked for what it is about the box: local = model.at(box, offsets).
template <class T, int N, class Model>
Step<T, N> krawczyk_step(const Model& model, const std::array<T, N>& box, Preconditioning preconditioning) {
    const Offsets<T, N> at(box);
    return krawczyk_step<T, N>(model.at(box, at), at, box, preconditioning);
}

}  // namespace vcell
