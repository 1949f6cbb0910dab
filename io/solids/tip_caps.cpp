#include "tip_caps.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "../../core/curves/bernstein.hpp"
#include "../../core/curves/restricted_curve.hpp"
#include "../pictures/trims.hpp"
#include "lowered_net.hpp"

namespace vcell {

namespace {

/// A form of degree n in x and y: coefficient i is that of x^(n - i) y^i. With x + y = 1 it is a polynomial
/// over [0, 1] whose Bernstein coefficients are these, divided by the binomials C(n, i).
using BinaryForm = std::vector<double>;

BinaryForm product_of(const BinaryForm& a, const BinaryForm& b) {
    BinaryForm result(a.size() + b.size() - 1, 0);
    for (std::size_t i = 0; i < a.size(); ++i)
        for (std::size_t k = 0; k < b.size(); ++k) result[i + k] += a[i] * b[k];
    return result;
}

double ways(std::size_t n, std::size_t k) {
    double result = 1;
    for (std::size_t i = 0; i < k; ++i) result *= static_cast<double>(n - i) / static_cast<double>(i + 1);
    return result;
}

using CapPoints = SmallVector<Eigen::Vector4d, 9>;

/// A patch seen from a side that is a tip, at height 0, the opposite side being at height 1. The other
/// parameter is called the angle.
class TipSide {
public:
    // The trim is that along the tip.
    TipSide(const RationalPatch& patch, const TrimCurve& trim)
        : patch_(patch), angle_(is_at_one(trim.curve, 1) ? 0 : 1) {
        const double at = trim.curve.points.front()[1 - angle_];
        const auto& domain = angle_ == 0 ? patch.domain_v : patch.domain_u;
        is_first_ = std::abs(at - domain[0]) < std::abs(at - domain[1]);
        at_ = domain[is_first_ ? 0 : 1];
        across_ = domain[is_first_ ? 1 : 0] - at_;
        before_ = trim.curve.points.front()[angle_];
        after_ = trim.curve.points.back()[angle_];
        for (const Eigen::Vector4d& p : patch.points)
            net_.push_back(p[3] * Eigen::Vector4d(p[0], p[1], p[2], 1));
        degrees_ = {static_cast<std::size_t>(patch.degree_u), static_cast<std::size_t>(patch.degree_v)};
        if (std::max(patch.degree_u, patch.degree_v) > 2) lower();
    }

    // Is the degree no more than it need be? Heights on both sides of a seam are alike only then.
    bool is_low() const { return std::max(degrees_[0], degrees_[1]) <= 2; }

    bool is_first() const { return is_first_; }
    Vec3 tip() const { return homogeneous(0, 0).head<3>() / homogeneous(0, 0)[3]; }

    Vec3 point(const Vec2& parameters) const { return patch_.evaluate(parameters.x(), parameters.y()); }

    double height(const Eigen::Vector3d& control) const { return (control[1 - angle_] - at_) / across_; }

    // A straight line from the tip, or to it, all at one angle, with heights proportional to the parameter
    // but for the rounding of weights.
    bool is_straight(const RationalCurve2& c) const {
        constexpr double rounding = 0x1p-44;
        return c.degree == 1 && c.points.size() == 2 && is_at_one(c, angle_) &&
               std::abs(c.points[0].z() - c.points[1].z()) <= rounding * c.points[0].z();
    }

    // No more than the height of any point of the curve.
    double least_height(const RationalCurve2& c) const {
        constexpr int parts = 32;
        double least = std::numeric_limits<double>::infinity();
        const double from = c.domain_begin(), length = c.domain_end() - from;
        for (int k = 0; k < parts; ++k) {
            const RationalCurve2 part =
                restricted(c, k == 0 ? from : from + length * k / parts,
                           k + 1 == parts ? c.domain_end() : from + length * (k + 1) / parts);
            for (const auto& p : part.points) least = std::min(least, height(p));
        }
        return least;
    }

    /// What is between the tip, the line up to a height at the angle where the tip's trim begins, and the
    /// line up to another height where it ends. A point at (x, y) has an angle that divides the two as
    /// `scale[1]` y and `scale[0]` x do, so that lines through the corner x = y = 0 are at one angle; and a
    /// height which is a form W of the angle's degree m in x and y, that of the weights along the tip: they
    /// cancel there, and the surface, sum_k W^k c_k(x, y) / W with the powers k of the height, is a
    /// polynomial one. Along the axes heights are those of the ends times x^m and y^m.
    struct Cap {
        RationalPatch surface;
        RationalCurve2 rim;  ///< from y = 1 to x = 1, in the patch's parameters
    };

    Cap cap(double height_before, double height_after) const {
        const std::size_t m = degree(angle_), n = degree(1 - angle_), size = m * n;
        std::vector<std::array<BinaryForm, 4>> powers = powers_of_height();
        const std::array<double, 2> ends{height_after, height_before};
        std::array<double, 2> scale{};
        for (const std::size_t i : {0u, 1u})
            scale[i] = std::pow(ends[i] / (i == 0 ? powers[0][3].front() : powers[0][3].back()),
                                1 / static_cast<double>(m));
        for (auto& power : powers)
            for (BinaryForm& form : power)
                for (std::size_t i = 0; i <= m; ++i)
                    form[i] *= std::pow(scale[0], static_cast<double>(m - i)) *
                               std::pow(scale[1], static_cast<double>(i));
        const BinaryForm& w = powers[0][3];

        // Coefficient (i, j) is that of x^i y^j; the tip is the origin, and what is of degree 0 is its
        // weight.
        std::vector<Eigen::Vector4d> monomials((size + 1) * (size + 1), Eigen::Vector4d::Zero());
        monomials[0][3] = 1;
        BinaryForm factor{1};
        for (std::size_t k = 1; k <= n; ++k) {
            for (const int d : {0, 1, 2, 3}) {
                const BinaryForm term = product_of(factor, powers[k][static_cast<std::size_t>(d)]);
                for (std::size_t i = 0; i < term.size(); ++i)
                    monomials[(term.size() - 1 - i) * (size + 1) + i][d] += term[i];
            }
            factor = product_of(factor, w);
        }
        return {{static_cast<int>(size), static_cast<int>(size), {0, 1}, {0, 1}, net(monomials, size)},
                rim(w, scale)};
    }

private:
    // Where degrees were raised until weights were positive.
    void lower() {
        constexpr double rounding = 0x1p-36;
        LoweredNet lowered = lowered_net(net_, degrees_[0], degrees_[1]);
        const auto size = [](const Eigen::Vector4d& h) { return h.cwiseAbs().maxCoeff(); };
        if (!(lowered.lost <= rounding * size(*std::ranges::max_element(net_, {}, size)))) return;
        net_ = std::move(lowered.net);
        degrees_ = {2, 2};
    }

    std::size_t degree(int coordinate) const { return degrees_[static_cast<std::size_t>(coordinate)]; }

    // (w x, w y, w z, w), by the number along the side and that from it.
    const Eigen::Vector4d& homogeneous(std::size_t along, std::size_t from) const {
        const std::size_t k = is_first_ ? from : degree(1 - angle_) - from;
        return net_[angle_ == 0 ? along * (degrees_[1] + 1) + k : k * (degrees_[1] + 1) + along];
    }

    // By the power of the height: forms in what the angle is divided by, of differences from the tip, and of
    // weights. (Those of power 0 but the weights are 0 but for rounding.)
    std::vector<std::array<BinaryForm, 4>> powers_of_height() const {
        const std::size_t m = degree(angle_), n = degree(1 - angle_);
        const auto& domain = angle_ == 0 ? patch_.domain_u : patch_.domain_v;
        const auto part = [&](double s) { return (s - domain[0]) / (domain[1] - domain[0]); };
        const Vec3 origin = tip();
        std::vector<std::array<BinaryForm, 4>> rows(n + 1);
        for (std::size_t j = 0; j <= n; ++j)
            for (const int d : {0, 1, 2, 3}) {
                std::vector<double> values;
                for (std::size_t i = 0; i <= m; ++i) {
                    const Eigen::Vector4d h = homogeneous(i, j);
                    values.push_back(d == 3 ? h[3] : h[d] - h[3] * origin[d]);
                }
                BinaryForm& form = rows[j][static_cast<std::size_t>(d)];
                for (std::size_t i = 0; i <= m; ++i)
                    form.push_back(ways(m, i) *
                                   bernstein_blossom<double>(values, part(after_), part(before_), i));
            }
        std::vector<std::array<BinaryForm, 4>> result(n + 1);
        for (std::size_t k = 0; k <= n; ++k)
            for (const std::size_t d : {0u, 1u, 2u, 3u}) {
                result[k][d].assign(m + 1, 0);
                for (std::size_t j = 0; j <= k; ++j)
                    for (std::size_t i = 0; i <= m; ++i)
                        result[k][d][i] +=
                            ((k - j) % 2 == 0 ? 1 : -1) * ways(n, k) * ways(k, j) * rows[j][d][i];
            }
        return result;
    }

    // Control points, of the degree `size` in both parameters, moved from the origin to the tip.
    CapPoints net(const std::vector<Eigen::Vector4d>& monomials, std::size_t size) const {
        CapPoints points;
        for (std::size_t i = 0; i <= size; ++i)
            for (std::size_t j = 0; j <= size; ++j) {
                Eigen::Vector4d h = Eigen::Vector4d::Zero();
                for (std::size_t k = 0; k <= i; ++k)
                    for (std::size_t l = 0; l <= j; ++l)
                        h += ways(i, k) / ways(size, k) * ways(j, l) / ways(size, l) *
                             monomials[k * (size + 1) + l];
                Eigen::Vector4d p;
                p << tip() + h.head<3>() / h[3], h[3];
                points.push_back(p);
            }
        return points;
    }

    // The line x = t, y = 1 - t.
    RationalCurve2 rim(const BinaryForm& w, const std::array<double, 2>& scale) const {
        BinaryForm raise{1};
        for (std::size_t i = 0; i < degree(angle_); ++i) raise = product_of(raise, {1, 1});
        const BinaryForm weights{scale[0], scale[1]},
            angles = product_of({scale[0] * after_, scale[1] * before_}, raise),
            all_weights = product_of(weights, raise), heights = product_of(weights, w);
        RationalCurve2 curve;
        const std::size_t size = all_weights.size() - 1;
        curve.degree = static_cast<int>(size);
        curve.knots.assign(size + 1, 0);
        curve.knots.insert(curve.knots.end(), size + 1, 1);
        for (std::size_t k = 0; k <= size; ++k) {
            const std::size_t i = size - k;
            Eigen::Vector3d p;
            p[angle_] = angles[i] / all_weights[i];
            p[1 - angle_] = at_ + across_ * heights[i] / all_weights[i];
            p[2] = all_weights[i] / ways(size, k);
            curve.points.push_back(p);
        }
        return curve;
    }

    const RationalPatch& patch_;
    std::vector<Eigen::Vector4d> net_;  // homogeneous
    std::array<std::size_t, 2> degrees_{};
    int angle_;  // which parameter it is
    bool is_first_ = false;
    double at_ = 0, across_ = 1;     // the tip's other parameter, and how far the opposite side is from it
    double before_ = 0, after_ = 0;  // angles where the tip's trim begins and ends
};

RationalCurve2 straight_trim(const Vec2& from, const Vec2& to) {
    RationalCurve2 line;
    line.knots = {0, 0, 1, 1};
    line.points = {{from.x(), from.y(), 1}, {to.x(), to.y(), 1}};
    return line;
}

using TrimLoop = std::vector<TrimCurve>;

const TrimCurve& trim_before(const TrimLoop& loop, std::size_t i) {
    return loop[(i + loop.size() - 1) % loop.size()];
}
const TrimCurve& trim_after(const TrimLoop& loop, std::size_t i) { return loop[(i + 1) % loop.size()]; }

class Capping {
public:
    explicit Capping(const std::vector<CellFace>& faces) {
        for (const CellFace& face : faces)
            for (const TrimCurve& c : face.trims())
                if (c.seam) seams_ = std::max(seams_, *c.seam + 1);
        for (const CellFace& face : faces) add(face);
    }

    CappedFaces take() { return std::move(result_); }

private:
    /// A seam's end at a tip, by the side of it on which the patches are: a face has a tip on either one.
    using SeamEnd = std::pair<std::uint32_t, bool>;

    /// Where a seam is cut.
    struct Corner {
        double part = 1;  ///< of the seam, from the tip
        std::optional<std::uint32_t> place = {};
        std::uint32_t beyond = 0;  ///< the number of the seam from there to the tip
    };

    void add(const CellFace& face) {
        corners_.clear();
        tips_.clear();
        if (!find_corners(face)) {
            result_.faces.push_back(face);
            return;
        }
        CellFace capped = face;
        capped.patches.clear();
        for (const TrimmedPatch& patch : face.patches) add(patch, capped.patches);
        result_.faces.push_back(std::move(capped));
    }

    // False if there is no tip, or one that cannot have a cap.
    bool find_corners(const CellFace& face) {
        for (const TrimmedPatch& patch : face.patches)
            for (const TrimLoop& loop : patch.loops)
                for (std::size_t i = 0; i < loop.size(); ++i) {
                    if (!loop[i].is_tip()) continue;
                    const TipSide side(patch.surface, loop[i]);
                    const TrimCurve &to = trim_before(loop, i), &from = trim_after(loop, i);
                    if (!side.is_low() || !to.seam || !from.seam || !side.is_straight(to.curve) ||
                        !side.is_straight(from.curve))
                        return false;
                    const double height = height_of_cap(patch, side, loop[i]);
                    if (!(height > 0)) return false;
                    for (const auto& [seam, end] : {std::pair(to.seam, to.curve.points.front()),
                                                    std::pair(from.seam, from.curve.points.back())}) {
                        double& part = corners_[{*seam, side.is_first()}].part;
                        part = std::min(part, height / side.height(end));
                    }
                }
        return !corners_.empty();
    }

    // A quarter of what is free of other trims, so that caps on both ends of a seam leave some of it; and so
    // little of it that weights stay above half that of the tip, which they come to near it.
    static double height_of_cap(const TrimmedPatch& patch, const TipSide& side, const TrimCurve& tip) {
        constexpr double free_part = 0.25, least_weight = 0.5, least_height = 1e-9;
        double height = 1;
        for (const TrimLoop& loop : patch.loops)
            for (std::size_t i = 0; i < loop.size(); ++i)
                if (&loop[i] != &tip && &trim_after(loop, i) != &tip && &trim_before(loop, i) != &tip)
                    height = std::min(height, side.least_height(loop[i].curve));
        for (height *= free_part; height > least_height; height /= 2)
            if (std::ranges::all_of(side.cap(height, height).surface.points,
                                    [&](const Eigen::Vector4d& p) { return p[3] > least_weight; }))
                return height;
        return 0;
    }

    void add(const TrimmedPatch& patch, std::vector<TrimmedPatch>& patches) {
        TrimmedPatch rest{patch.surface, {}};
        for (const TrimLoop& loop : patch.loops) {
            rest.loops.emplace_back();
            for (std::size_t i = 0; i < loop.size(); ++i)
                if (loop[i].is_tip())
                    rest.loops.back().push_back(add_cap(patch.surface, loop, i, patches));
                else
                    rest.loops.back().push_back(loop[i].seam ? cut(patch.surface, loop, i) : loop[i]);
        }
        patches.push_back(std::move(rest));
    }

    // What caps leave of a seam.
    TrimCurve cut(const RationalPatch& surface, const TrimLoop& loop, std::size_t i) {
        TrimCurve rest = loop[i];
        const double begin = rest.curve.domain_begin(), end = rest.curve.domain_end(), length = end - begin;
        double from = begin, to = end;
        std::array<std::optional<std::uint32_t>, 2> ends;
        if (trim_before(loop, i).is_tip()) {
            const TipSide side(surface, trim_before(loop, i));
            const Corner& c = corner(side, rest, end);
            from = begin + c.part * length;
            ends[0] = c.place;
        }
        if (trim_after(loop, i).is_tip()) {
            const TipSide side(surface, trim_after(loop, i));
            const Corner& c = corner(side, rest, begin);
            to = end - c.part * length;
            ends[1] = c.place;
        }
        if (!ends[0] && !ends[1]) return rest;
        rest.curve = restricted(rest.curve, from, to);
        result_.ends.try_emplace(*rest.seam, ends);
        return rest;
    }

    // Adds the cap, and returns the rest's trim along it.
    TrimCurve add_cap(const RationalPatch& surface, const TrimLoop& loop, std::size_t i,
                      std::vector<TrimmedPatch>& patches) {
        const TipSide side(surface, loop[i]);
        const TrimCurve &to = trim_before(loop, i), &from = trim_after(loop, i);
        const Corner &first = corner(side, to, to.curve.domain_begin()),
                     &last = corner(side, from, from.curve.domain_end());
        const std::uint32_t top = tip(side), rim = seams_++;
        TipSide::Cap cap = side.cap(first.part * side.height(to.curve.points.front()),
                                    last.part * side.height(from.curve.points.back()));
        TrimmedPatch patch{std::move(cap.surface), {{}}};
        const Vec2 origin = Vec2::Zero(), x = Vec2::UnitX(), y = Vec2::UnitY();
        patch.loops[0] = {{{}, first.beyond, false, straight_trim(y, origin)},
                          {{}, last.beyond, false, straight_trim(origin, x)},
                          {{}, rim, false, straight_trim(x, y)}};
        result_.ends.try_emplace(first.beyond, std::array{first.place, std::optional(top)});
        result_.ends.try_emplace(last.beyond, std::array{std::optional(top), last.place});
        result_.ends.try_emplace(rim, std::array{last.place, first.place});
        patches.push_back(std::move(patch));
        return {{}, rim, false, std::move(cap.rim)};
    }

    // The corner at the end of a seam's trim, whose other end is at a parameter.
    const Corner& corner(const TipSide& side, const TrimCurve& trim, double other_end) {
        Corner& c = corners_.at({*trim.seam, side.is_first()});
        if (!c.place) {
            c.beyond = seams_++;
            const double begin = trim.curve.domain_begin(), end = trim.curve.domain_end(),
                         tip_end = begin + end - other_end;
            c.place = add_place(side.point(trim.curve.evaluate(tip_end + c.part * (other_end - tip_end))));
        }
        return c;
    }

    std::uint32_t tip(const TipSide& side) {
        const auto [at, is_new] = tips_.try_emplace(side.is_first(), 0);
        if (is_new) at->second = add_place(side.tip());
        return at->second;
    }

    std::uint32_t add_place(const Vec3& p) {
        result_.places.push_back(p);
        return static_cast<std::uint32_t>(result_.places.size() - 1);
    }

    CappedFaces result_;
    std::uint32_t seams_ = 0;             // their numbers are less
    std::map<SeamEnd, Corner> corners_;   // of the face
    std::map<bool, std::uint32_t> tips_;  // of the face, by the side: their places
};

}  // namespace

CappedFaces with_tip_caps(const std::vector<CellFace>& faces) { return Capping(faces).take(); }

}  // namespace vcell
