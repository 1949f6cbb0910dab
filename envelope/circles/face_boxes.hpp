/// The boxes of a diagram's faces, with their sites' forms about the middles, in arrays of their own: a
/// challenger is compared with all of them before any other part of a face is looked at.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "../../arrangement/circles/circle_kernel.hpp"

namespace vcell {

class FaceBoxes {
public:
    using Index = std::uint32_t;
    using Form = CircleKernel::Form;
    using BoxForm = CircleKernel::BoxForm;

    void clear() { resize(0); }
    /// What is new has no box.
    void resize(std::size_t faces) {
        for (std::vector<double>* column : {&x_, &y_, &rx_, &ry_, &gx_, &gy_, &K_, &scale_, &excess_})
            column->resize(faces);
        v_.resize(faces, -HUGE_VAL);
    }
    std::size_t size() const { return v_.size(); }

    /// Face f, which `site` owns, lies within rx and ry of (x, y).
    void set(Index f, const Form& site, double x, double y, double rx, double ry) {
        const BoxForm b = CircleKernel::box_form(site, x, y, rx, ry);
        x_[f] = x;
        y_[f] = y;
        rx_[f] = rx;
        ry_[f] = ry;
        v_[f] = b.v;
        gx_[f] = b.gx;
        gy_[f] = b.gy;
        K_[f] = b.K;
        scale_[f] = b.scale;
    }
    /// Nobody wins a part of what has no box. (Of one that is not bounded nothing may stay that turns the
    /// comparison into NaN.)
    void remove(Index f) {
        for (std::vector<double>* column : {&x_, &y_, &rx_, &ry_, &gx_, &gy_, &K_, &scale_}) (*column)[f] = 0;
        v_[f] = -HUGE_VAL;
    }

    /// Calls visit(f) for the faces over whose boxes the form is not certainly above the site's.
    template <class Visit>
    void challenge(const Form& form, Visit&& visit) {
        // One loop for all of them is made of vector instructions.
        const std::size_t count = size();
        double* const excess = excess_.data();
        for (std::size_t f = 0; f < count; ++f)
            excess[f] = CircleKernel::excess(CircleKernel::box_form(form, x_[f], y_[f], rx_[f], ry_[f]),
                                             at(f), rx_[f], ry_[f]);
        for (std::size_t f = 0; f < count; ++f)
            if (!(excess[f] > 0)) visit(static_cast<Index>(f));
    }

    /// Upper bound of the sum of the absolute values of the components of grad(form - site) in the box of
    /// face f, where the one at its middle changes by 2 K per unit. Rounding is relative to the terms of
    /// both.
    double slope_bound(Index f, const Form& form, const Form& site) const {
        constexpr double rounding_margin = 1e-12;
        const BoxForm b = CircleKernel::box_form(form, x_[f], y_[f], rx_[f], ry_[f]);
        const double extent = rx_[f] + ry_[f], K = std::abs(b.K - K_[f]),
                     size = std::abs(b.K) + std::abs(K_[f]);
        const double slack = std::abs(b.gx) + std::abs(b.gy) + std::abs(gx_[f]) + std::abs(gy_[f]) +
                             std::abs(b.K) * (std::abs(x_[f] - form.cx) + std::abs(y_[f] - form.cy)) +
                             std::abs(K_[f]) * (std::abs(x_[f] - site.cx) + std::abs(y_[f] - site.cy)) +
                             size * extent;
        return std::abs(b.gx - gx_[f]) + std::abs(b.gy - gy_[f]) + 2 * K * extent + rounding_margin * slack;
    }

private:
    BoxForm at(std::size_t f) const { return {v_[f], gx_[f], gy_[f], K_[f], 0, scale_[f]}; }

    std::vector<double> x_, y_, rx_, ry_;          // middle and half sides
    std::vector<double> v_, gx_, gy_, K_, scale_;  // of the site's BoxForm
    std::vector<double> excess_;                   // working space
};

}  // namespace vcell
