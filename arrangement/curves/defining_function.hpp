/// Functions g(x, y) whose zeros are a curve, behind one interface for both interval rungs of the ladder.
#pragma once

#include <memory>
#include <utility>

#include "../../core/numbers/enclosure.hpp"
#include "../../core/numbers/interval.hpp"
#include "../../core/numbers/jet.hpp"
#include "../../core/numbers/wide_interval.hpp"
#include "../../core/solver/newton/one_unknown.hpp"

namespace vcell {

/// Below this share of the scale of the coordinates a coincidence is assumed.
inline constexpr double assumed_width = 0x1p-200;

/// A value with first, and with first and second derivatives in x and y.
template <class T>
using Jet1 = Jet<T, 2>;
template <class T>
using Jet2 = Jet<Jet<T, 2>, 2>;

/// g over a box: enclosures of its values, of its gradient, of its second derivatives. Where g is not defined
/// or not smooth all over the box, the enclosures are unbounded.
class DefiningFunction {
public:
    virtual ~DefiningFunction() = default;
    virtual Interval value(const Interval& x, const Interval& y) const = 0;
    virtual Wide value(const Wide& x, const Wide& y) const = 0;
    virtual Jet1<Interval> jet(const Interval& x, const Interval& y) const = 0;
    virtual Jet1<Wide> jet(const Wide& x, const Wide& y) const = 0;
    virtual Jet2<Interval> second_jet(const Interval& x, const Interval& y) const = 0;
    virtual Jet2<Wide> second_jet(const Wide& x, const Wide& y) const = 0;
};

namespace detail {

template <class G>
class CallableFunction final : public DefiningFunction {
public:
    explicit CallableFunction(G g) : g_(std::move(g)) {}
    Interval value(const Interval& x, const Interval& y) const override { return g_(x, y); }
    Wide value(const Wide& x, const Wide& y) const override { return g_(x, y); }
    Jet1<Interval> jet(const Interval& x, const Interval& y) const override { return first(x, y); }
    Jet1<Wide> jet(const Wide& x, const Wide& y) const override { return first(x, y); }
    Jet2<Interval> second_jet(const Interval& x, const Interval& y) const override { return second(x, y); }
    Jet2<Wide> second_jet(const Wide& x, const Wide& y) const override { return second(x, y); }

private:
    template <class T>
    Jet1<T> first(const T& x, const T& y) const {
        return g_(Jet1<T>::variable(x, 0), Jet1<T>::variable(y, 1));
    }
    template <class T>
    Jet2<T> second(const T& x, const T& y) const {
        return g_(Jet2<T>::variable(Jet1<T>::variable(x, 0), 0),
                  Jet2<T>::variable(Jet1<T>::variable(y, 1), 1));
    }
    G g_;
};

}  // namespace detail

/// The defining function of a callable `T g(const T& x, const T& y)` generic in the number type.
template <class G>
std::shared_ptr<const DefiningFunction> defining_function(G g) {
    return std::make_shared<detail::CallableFunction<G>>(std::move(g));
}

}  // namespace vcell
