#include "bernstein.hpp"

#include <cassert>
#include <numeric>

namespace vcell {

namespace {

// C(n, k) for n <= 32: below 2^30.
std::int64_t binomial(std::size_t n, std::size_t k) {
    std::int64_t b = 1;
    for (std::size_t i = 1; i <= k; ++i)
        b = b * static_cast<std::int64_t>(n - k + i) / static_cast<std::int64_t>(i);
    return b;
}

// lcm of C(n, k) = lcm(1, ..., n + 1) / (n + 1), below 2^47 for n <= 32.
std::int64_t scale(std::size_t n) {
    assert(n <= 32);
    std::int64_t l = 1;
    for (std::size_t i = 2; i <= n + 1; ++i) l = std::lcm(l, static_cast<std::int64_t>(i));
    return l / static_cast<std::int64_t>(n + 1);
}

Exact whole(std::int64_t i) { return Exact(static_cast<double>(i)); }

class SignChanges {
public:
    explicit SignChanges(int depth) : depth_(depth) {}

    void find(const std::vector<Exact>& c, const Exact& lower, const Exact& upper, int level) {
        int variations = 0;
        Sign last = Sign::Zero;
        for (const Exact& b : c) {
            const Sign s = b.sign();
            if (s == Sign::Zero) continue;
            if (last == -s) ++variations;
            last = s;
        }
        if (variations == 0) return;
        if (variations == 1 || level == depth_) {
            // As many roots as variations up to an even number: an odd number changes the sign.
            if (variations % 2 == 1) changes.push_back({lower, upper, last, variations == 1});
            return;
        }
        std::vector<Exact> left, right(c);
        for (std::size_t n = c.size(); n > 0; --n) {
            left.push_back(right.front());
            for (std::size_t i = 0; i + 1 < n; ++i) right[i] = (right[i] + right[i + 1]).scaled(-1);
        }
        const Exact middle = (lower + upper).scaled(-1);
        find(left, lower, middle, level + 1);
        // left.back() == right.front() is the value in the middle; beside a root there, the signs are those
        // of the next coefficients that are not zero.
        if (right.front().sign() == Sign::Zero) {
            const auto first_sign = [](auto begin, auto end) {
                for (; begin != end; ++begin) {
                    if (begin->sign() != Sign::Zero) return begin->sign();
                }
                return Sign::Zero;
            };
            const Sign after = first_sign(right.begin(), right.end());
            if (first_sign(left.rbegin(), left.rend()) == -after)
                changes.push_back({middle, middle, after, true});
        }
        find(right, middle, upper, level + 1);
    }

    std::vector<SignChange> changes;

private:
    int depth_;
};

}  // namespace

// Coefficient k of the product is sum C(m, i) C(n, k - i) p_i q_(k - i) / C(m + n, k) [Farin02, 6].
std::vector<Exact> bernstein_scaled_product(std::span<const Exact> p, std::span<const Exact> q) {
    const std::size_t m = p.size() - 1, n = q.size() - 1;
    std::vector<Exact> r(m + n + 1);
    for (std::size_t i = 0; i <= m; ++i) {
        for (std::size_t j = 0; j <= n; ++j)
            r[i + j] += whole(binomial(m, i)) * whole(binomial(n, j)) * p[i] * q[j];
    }
    for (std::size_t k = 0; k <= m + n; ++k) r[k] *= whole(scale(m + n) / binomial(m + n, k));
    return r;
}

std::vector<Exact> bernstein_derivative(std::span<const Exact> c) {
    assert(c.size() >= 2);
    const Exact n(static_cast<double>(c.size() - 1));
    std::vector<Exact> d;
    for (std::size_t i = 0; i + 1 < c.size(); ++i) d.push_back(n * (c[i + 1] - c[i]));
    return d;
}

std::vector<SignChange> bernstein_sign_changes(std::span<const Exact> c, int depth) {
    SignChanges search(depth);
    search.find(std::vector<Exact>(c.begin(), c.end()), Exact(0.0), Exact(1.0), 0);
    return search.changes;
}

}  // namespace vcell
