/// Oriented spheres along a curve or over a patch: their centers p, times a weight w, and their radii t,
/// times w, are polynomials, given by Bernstein coefficients about an origin. Known of t / w is how far it
/// may be off.
///
/// Bounded are linear functions of (p, t), which are quotients of such polynomials, and
///     F(p, t) = |p - c|^2 - (t + rho)^2
/// of a ball, whose product by w^2 is a polynomial, too.
#pragma once

#include <optional>
#include <span>

#include "coefficients.hpp"
#include "lanes.hpp"
#include "nets.hpp"
#include "tangential.hpp"

namespace vcell::check {

class SphereNet {
public:
    struct Point {
        double x, y, z, w, t;  // homogeneous, about the origin
    };
    /// k w + g (x, y, z) + h t; k is off by no more than `error`, g and h by some 2^-50 of themselves.
    struct Linear {
        double k, error;
        Vec3 g;
        double h;
    };

    /// The centers; of the radii nothing is known yet. None: the net has too high a degree, or a weight that
    /// is not positive.
    static std::optional<SphereNet> of(const Net& net);

    const Vec3& origin() const { return origin_; }
    bool is_patch() const { return n_ > 0; }
    std::span<const Point> points() const { return points_; }
    /// How far the homogeneous coordinates and the weights are off, at most.
    double position_error() const { return position_error_; }
    double weight_error() const { return weight_error_; }
    double least_weight() const { return least_weight_; }
    double clearance_error() const { return clearance_error_; }
    double sag() const { return sag_; }
    /// The largest magnitudes of p's coordinates, and of t / w.
    const Vec3& most_place() const { return most_place_; }
    double most_clearance() const { return most_clearance_; }

    /// t at each point.
    template <class Radius>
    void set_radii(Radius radius) {
        for (Point& p : points_) p.t = radius(p);
    }
    /// Tells that t / w is off by no more than `error`, and may be less by `sag`. False: it is not finite.
    bool settle(double error, double sag = 0);

    /// Makes t what solves f = 0. Pre: f.h is not 0.
    void solve_for_radii(const Linear& f);

    /// F of the ball about a center, less that of the one about `other`.
    Linear difference(const Sphere& ball, const Vec3& other, double radius) const;
    /// Holds all values of f. Pre: settle(), unless f.h is 0.
    Interval range(const Linear& f) const;
    /// The largest magnitude of |p - c|^2 - (t + rho)^2; none if it is not finite.
    std::optional<double> largest_square(const Vec3& center, double radius) const;
    /// The largest magnitude of its product by the squared weight.
    double largest_numerator(const Vec3& center, double radius) const;
    struct Sums {
        double least, most;
    };
    /// Bounds of w (t / w + radius).
    Sums weighted_sums(double radius) const;
    struct LeastSum {
        double value;
        bool is_bent;  ///< do coefficients tell little of it?
    };
    /// A lower bound of t / w + radius, as t's coefficients have it.
    LeastSum least_sum(double radius) const;
    bool is_weight_least_at_loops() const;

private:
    /// Quotients by the weight, of several points at once. The last one repeats.
    struct Affine {
        Lanes x, y, z, t;
    };
    explicit SphereNet(const Net& net);
    template <class Coordinate>
    double divide_by_weights(Coordinate coordinate, Lanes Affine::*quotient);

    int m_, n_;
    Vec3 origin_;
    SmallVector<Point, 9> points_;
    SmallVector<Affine, 3> affine_;
    Vec3 most_place_ = Vec3::Zero();
    double most_clearance_ = 0;
    double position_error_ = 0, weight_error_ = 0;
    double clearance_error_ = 0, sag_ = 0;
    double least_weight_ = 0, most_weight_ = 0;
};

}  // namespace vcell::check
