/// Exact numbers: the last rung of the ladder, and the only place that names Boost.Multiprecision.
///
/// Every input is a double, hence a dyadic rational m 2^e, and every predicate of ours is a
/// polynomial in the inputs. So the ring of dyadic rationals is closed under all we do: no
/// denominators, no gcd. Vertices add one square root: they live in a + b sqrt(c).
#pragma once

#include <boost/multiprecision/cpp_int.hpp>
#include <span>
#include <utility>

#include "interval.hpp"
#include "sign.hpp"

namespace vcell {

/// m * 2^e, exact. Sums of numbers with very different exponents grow to the spread of the
/// exponents: a few thousand bits at the very worst for doubles of the allowed input range.
///
/// Nothing of it is inline: a compiler that sees integers of any length copied and multiplied in every file
/// spends a tenth of a build on them.
class Exact {
public:
    Exact();
    Exact(const Exact& other);
    Exact(Exact&& other) noexcept;
    Exact& operator=(const Exact& other);
    Exact& operator=(Exact&& other) noexcept;
    ~Exact();
    /// Exact. Pre: value is finite.
    Exact(double value);  // NOLINT: every double is exact

    Sign sign() const { return static_cast<Sign>(m_.sign()); }

    friend Exact operator-(const Exact& a);
    friend Exact operator+(const Exact& a, const Exact& b);
    friend Exact operator-(const Exact& a, const Exact& b);
    friend Exact operator*(const Exact& a, const Exact& b);
    Exact& operator+=(const Exact& o) { return *this = *this + o; }
    Exact& operator-=(const Exact& o) { return *this = *this - o; }
    Exact& operator*=(const Exact& o) { return *this = *this * o; }
    friend bool operator==(const Exact& a, const Exact& b) { return (a - b).sign() == Sign::Zero; }
    friend auto operator<=>(const Exact& a, const Exact& b) { return static_cast<int>((a - b).sign()) <=> 0; }

    /// floor(log2 |*this|). Pre: not zero.
    long exponent() const;
    /// *this * 2^power.
    Exact scaled(long power) const;
    /// The tightest pair of doubles around the value; a single double when it is one.
    Interval enclosure() const;
    /// Enclosure of the non-negative square root, relative width about 2^-bits before rounding.
    /// Pre: *this >= 0. Returns lower and upper bounds, equal for the square of a dyadic number.
    std::pair<Exact, Exact> sqrt_bounds(int bits) const;
    /// Multiplies all of them by one positive number that makes their digits few.
    friend void divide_by_common_factor(std::span<Exact> values);

private:
    // 512 bits in place cover almost every predicate without touching the heap.
    using Integer = boost::multiprecision::number<
        boost::multiprecision::cpp_int_backend<512, 0, boost::multiprecision::signed_magnitude,
                                               boost::multiprecision::unchecked,
                                               std::allocator<boost::multiprecision::limb_type>>,
        boost::multiprecision::et_off>;
    Exact(Integer m, long e);
    static Exact sum(const Exact& a, const Exact& b, bool subtract);

    Integer m_ = 0;
    long e_ = 0;
};

void divide_by_common_factor(std::span<Exact> values);

inline Exact square(const Exact& a) { return a * a; }

/// a + b sqrt(c), c >= 0: coordinates of the points where two circles (or lines) of rational
/// coefficients meet. Arithmetic stays within one field: operands must share c.
struct OneRoot {
    Exact a;
    Exact b;
    Exact c;

    friend OneRoot operator+(const OneRoot& p, const OneRoot& q) { return {p.a + q.a, p.b + q.b, p.c}; }
    friend OneRoot operator-(const OneRoot& p, const OneRoot& q) { return {p.a - q.a, p.b - q.b, p.c}; }
    friend OneRoot operator*(const OneRoot& p, const OneRoot& q) {
        return {p.a * q.a + p.b * q.b * p.c, p.a * q.b + p.b * q.a, p.c};
    }
    friend OneRoot operator*(const Exact& s, const OneRoot& p) { return {s * p.a, s * p.b, p.c}; }
    friend OneRoot operator+(const OneRoot& p, const Exact& s) { return {p.a + s, p.b, p.c}; }
};

inline bool is_zero(const Exact& v) { return v.sign() == Sign::Zero; }

/// Sign of a + b sqrt(c), by comparing squares.
Sign sign(const OneRoot& v);
inline bool is_zero(const OneRoot& v) { return sign(v) == Sign::Zero; }

/// Sign of (p / p_den) - (q / q_den) for numbers of two different fields.
/// Pre: both denominators are positive.
Sign compare(const OneRoot& p, const Exact& p_den, const OneRoot& q, const Exact& q_den);

/// Doubles around v / den, at most 16 ulp wide however much a and b sqrt(c) cancel (subnormal values
/// excepted); [0, 0] for zero. Pre: den != 0.
Interval enclosure(const OneRoot& v, const Exact& den);

}  // namespace vcell
