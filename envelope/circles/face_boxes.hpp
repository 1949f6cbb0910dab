/// The boxes of a diagram's faces, with their sites' forms about the middles, in arrays of their own: a
/// challenger is compared with all of them before any other part of a face is looked at.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "../../arrangement/circles/circle_forms.hpp"

namespace vcell {

class FaceBoxes {
public:
    using Index = std::uint32_t;
    using Form = KernelForm;

    void clear() { size_ = 0; }
    /// One more, which has no box.
    void add() {
        if (size_ == v_.size()) grow();
        remove(static_cast<Index>(size_++));
    }
    std::size_t size() const { return size_; }

    /// Face f, which `site` owns, lies within rx and ry of (x, y).
    void set(Index f, const Form& site, double x, double y, double rx, double ry) {
        const BoxForm b = site.over_box(x, y, rx, ry);
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
            excess[f] = BoxForm::excess(form.over_box(x_[f], y_[f], rx_[f], ry_[f]), at(f), rx_[f], ry_[f]);
        for (std::size_t f = 0; f < count; ++f)
            if (!(excess[f] > 0)) visit(static_cast<Index>(f));
    }

    /// Upper bound of the sum of the absolute values of the components of grad(form - site) in the box of
    /// face f, where the one at its middle changes by 2 K per unit. Rounding is relative to the terms of
    /// both.
    double slope_bound(Index f, const Form& form, const Form& site) const {
        return slope_bound(form, site, at(f), x_[f], y_[f], rx_[f], ry_[f]);
    }
    /// That bound in any box; `a` is the site's BoxForm.
    static double slope_bound(const Form& form, const Form& site, const BoxForm& a, double x, double y,
                              double rx, double ry) {
        constexpr double rounding_margin = 1e-12;
        const BoxForm b = form.over_box(x, y, rx, ry);
        const double extent = rx + ry, K = std::abs(b.K - a.K), size = std::abs(b.K) + std::abs(a.K);
        const double slack = std::abs(b.gx) + std::abs(b.gy) + std::abs(a.gx) + std::abs(a.gy) +
                             std::abs(b.K) * (std::abs(x - form.cx) + std::abs(y - form.cy)) +
                             std::abs(a.K) * (std::abs(x - site.cx) + std::abs(y - site.cy)) + size * extent;
        return std::abs(b.gx - a.gx) + std::abs(b.gy - a.gy) + 2 * K * extent + rounding_margin * slack;
    }

private:
    void grow() {
        const std::size_t faces = 2 * size_ + 32;
        for (std::vector<double>* column : {&x_, &y_, &rx_, &ry_, &v_, &gx_, &gy_, &K_, &scale_, &excess_})
            column->resize(faces);
    }
    BoxForm at(std::size_t f) const { return {v_[f], gx_[f], gy_[f], K_[f], 0, scale_[f]}; }

    std::vector<double> x_, y_, rx_, ry_;          // middle and half sides
    std::vector<double> v_, gx_, gy_, K_, scale_;  // of the site's BoxForm
    std::vector<double> excess_;                   // working space
    std::size_t size_ = 0;                         // so many of the rows are in use
};

}  // namespace vcell
