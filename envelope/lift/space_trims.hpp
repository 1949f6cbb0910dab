/// A span's trims: on which parts of the patches they lie, where the span crosses a seam between them, and
/// how far the patches' points at them are from the span.
///
/// This is step 5 of the certificate of spline_fit.hpp. F = (G_base, G_site, n_u - u(s) d_u, n_v - v(s) d_v)
/// for coordinates n / d: step 2 bounds the distance of the patch's point at (u, v)(s) from P(s). Where these
/// rows all but depend on each other (a needle seen from the base's centre) that point is computed instead:
/// (P, w)((u, v)(s))
/// - P(s) w is a polynomial of degree 25, whose coefficients bound it.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "../../primitives/fit/tube_proof.hpp"
#include "space_arc.hpp"

namespace vcell::space_fit {

// The parts of the patches that a span's trims are for; null: none on this side.
using Patches = std::array<const SpacePart*, 2>;

struct Trims {
    std::array<std::uint32_t, 2> part{};
    Patches patches{};           // of those parts
    std::optional<Linear> seam;  // crossed: then there are no trims

    bool crosses_seam() const { return seam.has_value(); }
};

// Chooses the parts and puts the trims below the curve, whose rows of `points` are given.
Trims place_trims(const SpaceArc& arc, double tolerance, Points& points);

// Where a linear function vanishes on a span, if it is seen to change its sign.
std::optional<Vector4d> sign_change(const Points& points, const Linear& f, double tolerance);

// Bounds the distance of the patches' points at a span's trims, and at parts of them, from the curve.
class TrimProof {
public:
    TrimProof(const TubeProof& proof, const Patches& patches, const Points& points,
              const SpanPolynomials& span, const Residuals& residuals);

    // In one D, where that is `local`. Adds to q and blur of the tube.
    double operator()(const Points& points, const LocalEquations& local, Tube& tube) const;

private:
    // Bounds |n - u d| along the span, and the divisors from below.
    struct Trim {
        std::array<double, 2> residual, divisor;
    };
    // q: of step 2.
    double trim_error(int side, const Points& points, const LocalEquations& local, double& q) const;

    const TubeProof& proof_;
    const Patches& patches_;
    const Residuals& residuals_;
    std::array<Trim, 2> trims_{};
};

}  // namespace vcell::space_fit
