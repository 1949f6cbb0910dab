/// N equations in N + 1 unknowns, as the curve solver evaluates them.
#pragma once

#include <array>
#include <memory>
#include <utility>

#include "../../numbers/jet.hpp"
#include "../../numbers/series.hpp"
#include "../newton/box.hpp"

namespace vcell {

/// A map from R^D to R^M given by a callable generic in the number type,
/// `std::array<T, M> f(const std::array<T, D>&)`, behind one type, so that the algorithms are compiled
/// once. The callable must be smooth wherever its enclosures are bounded; where it is not defined they
/// must be unbounded (as division by zero and roots of negative intervals give).
template <int D, int M>
class SmoothMap {
public:
    template <class F>
    requires(!std::same_as<F, SmoothMap>) SmoothMap(F f)
        : model_(std::make_shared<Model<F>>(std::move(f))) {}  // NOLINT: a callable is a map

    std::array<Interval, M> operator()(const IntervalBox<D>& x) const { return model_->values(x); }
    std::array<Wide, M> operator()(const WideBox<D>& x) const { return model_->values(x); }
    std::array<Jet<double, D>, M> differentiate(const Point<D>& x) const { return model_->jets(x); }
    std::array<Jet<Interval, D>, M> differentiate(const IntervalBox<D>& x) const { return model_->jets(x); }
    std::array<Jet<Wide, D>, M> differentiate(const WideBox<D>& x) const { return model_->jets(x); }
    /// The map along a curve, to the order of Series.
    std::array<Series, M> along(const std::array<Series, D>& curve) const { return model_->along(curve); }

private:
    struct Concept {
        virtual ~Concept() = default;
        virtual std::array<Interval, M> values(const IntervalBox<D>&) const = 0;
        virtual std::array<Wide, M> values(const WideBox<D>&) const = 0;
        virtual std::array<Jet<double, D>, M> jets(const Point<D>&) const = 0;
        virtual std::array<Jet<Interval, D>, M> jets(const IntervalBox<D>&) const = 0;
        virtual std::array<Jet<Wide, D>, M> jets(const WideBox<D>&) const = 0;
        virtual std::array<Series, M> along(const std::array<Series, D>&) const = 0;
    };
    template <class F>
    struct Model final : Concept {
        explicit Model(F callable) : f(std::move(callable)) {}
        std::array<Interval, M> values(const IntervalBox<D>& x) const override { return f(x); }
        std::array<Wide, M> values(const WideBox<D>& x) const override { return f(x); }
        std::array<Jet<double, D>, M> jets(const Point<D>& x) const override { return f(variables(x)); }
        std::array<Jet<Interval, D>, M> jets(const IntervalBox<D>& x) const override {
            return f(variables(x));
        }
        std::array<Jet<Wide, D>, M> jets(const WideBox<D>& x) const override { return f(variables(x)); }
        std::array<Series, M> along(const std::array<Series, D>& curve) const override { return f(curve); }
        F f;
    };
    std::shared_ptr<const Concept> model_;
};

/// f(x) = 0, a curve wherever the Jacobian has full rank.
template <int N>
using CurveSystem = SmoothMap<N + 1, N>;

}  // namespace vcell
