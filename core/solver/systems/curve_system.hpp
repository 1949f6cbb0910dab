/// N equations in N + 1 unknowns, as the curve solver evaluates them.
#pragma once

#include <array>
#include <memory>
#include <utility>

#include "../../numbers/jet.hpp"
#include "../newton/box.hpp"

namespace vcell {

/// f(x) = 0, a curve wherever the Jacobian has full rank: a map from R^D to R^N, D = N + 1, given by a
/// callable generic in the number type, `std::array<T, N> f(const std::array<T, D>&)`, behind one type, so
/// that the algorithms are compiled once. The callable must be smooth wherever its enclosures are bounded;
/// where it is not defined they must be unbounded (as division by zero and roots of negative intervals give).
template <int N>
class CurveSystem {
    static constexpr int D = N + 1;

public:
    template <class F>
    requires(!std::same_as<F, CurveSystem>) CurveSystem(F f)
        : model_(std::make_shared<Model<F>>(std::move(f))) {}  // NOLINT: a callable is a map

    std::array<Interval, N> operator()(const IntervalBox<D>& x) const { return model_->values(x); }
    std::array<Wide, N> operator()(const WideBox<D>& x) const { return model_->values(x); }
    std::array<Jet<double, D>, N> differentiate(const Point<D>& x) const { return model_->jets(x); }
    std::array<Jet<Interval, D>, N> differentiate(const IntervalBox<D>& x) const { return model_->jets(x); }
    std::array<Jet<Wide, D>, N> differentiate(const WideBox<D>& x) const { return model_->jets(x); }

private:
    struct Concept {
        virtual ~Concept() = default;
        virtual std::array<Interval, N> values(const IntervalBox<D>&) const = 0;
        virtual std::array<Wide, N> values(const WideBox<D>&) const = 0;
        virtual std::array<Jet<double, D>, N> jets(const Point<D>&) const = 0;
        virtual std::array<Jet<Interval, D>, N> jets(const IntervalBox<D>&) const = 0;
        virtual std::array<Jet<Wide, D>, N> jets(const WideBox<D>&) const = 0;
    };
    template <class F>
    struct Model final : Concept {
        explicit Model(F callable) : f(std::move(callable)) {}
        std::array<Interval, N> values(const IntervalBox<D>& x) const override { return f(x); }
        std::array<Wide, N> values(const WideBox<D>& x) const override { return f(x); }
        std::array<Jet<double, D>, N> jets(const Point<D>& x) const override { return f(variables(x)); }
        std::array<Jet<Interval, D>, N> jets(const IntervalBox<D>& x) const override {
            return f(variables(x));
        }
        std::array<Jet<Wide, D>, N> jets(const WideBox<D>& x) const override { return f(variables(x)); }
        F f;
    };
    std::shared_ptr<const Concept> model_;
};

}  // namespace vcell
