/// What all rooms of the check share: the subject, the certificate that they add to, and what contradicts a
/// point of the boundary.
#pragma once

#include <algorithm>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "check.hpp"
#include "paths.hpp"
#include "subject.hpp"

namespace vcell::check {

class Room {
public:
    Room(const Subject& subject, const CheckOptions& options, Certificate& certificate)
        : subject_(subject),
          cell_(subject.cell),
          scene_(subject.cell.scene),
          geometry_(subject.geometry),
          edge_pieces_(subject.edge_pieces),
          uses_(subject.uses),
          rim_(subject.rim),
          patches_(subject.patches),
          options_(options),
          certificate_(certificate) {}

protected:
    void note(std::string where, std::string what) { certificate_.refute(std::move(where), std::move(what)); }

    /// Adds a proof that bounds how far the boundary as written is from the true one.
    void prove(std::string where, double distance, std::string what = {}) {
        certificate_.distance = std::max(certificate_.distance, distance);
        certificate_.prove(std::move(where), distance, std::move(what));
    }

    const Space<Interval>& space() const { return subject_.space; }
    /// Below this an excess is no difference: what rounding of numbers of the scene's size makes of zero.
    double tie_width(const Site& s) const { return geometry_.site_rounding(s); }
    /// The largest error that may be stated where this much is proved, and excesses of no more than
    /// tie_width() may be this far from where they vanish: about what the scene tolerates, what rounding does
    /// to numbers of its size, from which no bound that counts roundings is free however near the numbers
    /// happen to be, or a multiple as large as bounds found in other ways may differ by.
    double most_stated(double proved, double rounded) const {
        return std::max(16 * std::max(scene_tolerance(), rounded), 1024 * proved);
    }
    double most_stated(double proved) const { return most_stated(proved, 0); }

    double rounding() const { return geometry_.rounding(); }
    double height(const Vec3& p) const { return geometry_.height(p); }
    double scene_tolerance() const { return subject_.tolerance(); }
    double full_error(std::size_t e) const { return subject_.full_error(e); }
    std::vector<Site> label(std::size_t e) const { return subject_.label(e); }

    /// Finds the sites but the given ones that may be nearer than the base within `reach` of p. Sides of the
    /// box that are ends of the base cylinder's stretch are no sites beside them.
    void rivals(const Vec3& p, double reach, std::span<const Condition> own,
                std::vector<Condition>& found) const;
    /// Is a site nowhere nearer than the base and the given ones, by what contains it?
    bool is_held(const Site& site, std::span<const Condition> own) const;
    /// Half the squared gradient of an excess: what it grows by at least per length on the way towards an
    /// object's base, where the other sites' excesses grow, too.
    double growth(const Condition& c, const Vector<Interval>& box) const {
        return c.is_of_object() ? growth_of(c, space().gradient(c, box)) : 0.5;
    }
    static double growth_of(const Condition& c, const Vector<Interval>& gradient) {
        return c.is_of_object() ? 0.5 * square(gradient).lower() : 0.5;
    }
    /// How far a curve or a patch with an excess of that size is from its true place: the first
    /// find(margin).distance that is no more than the margin for which it was found. Gradients of excesses
    /// are seldom so short that it is farther than the first one. None: find() has none.
    template <class Find>
    static auto within_margin(const Find& find, double size) -> decltype(find(size)) {
        constexpr double first_margin = 8;
        double margin = first_margin * size;
        for (int tries = 0; tries < 4; ++tries) {
            const auto found = find(margin);
            if (!found || found->distance <= margin) return found;
            margin = 1.25 * found->distance;
        }
        return std::nullopt;
    }

    /// What contradicts that p, stated with an error, bounds the cell by the given sites; nothing if fine.
    std::optional<std::string> contradiction(const Vec3& p, double error, std::span<const Site> sites) const;

    const Subject& subject_;
    const Cell& cell_;
    const Scene& scene_;
    const SceneGeometry& geometry_;
    const std::vector<std::vector<Bezier<3>>>& edge_pieces_;
    const std::vector<std::vector<Subject::Use>>& uses_;
    const std::vector<std::optional<Site>>& rim_;
    const std::vector<Patch>& patches_;
    const CheckOptions& options_;
    Certificate& certificate_;

private:
    mutable std::vector<std::uint32_t> near_;  // as found last, for its room
};

}  // namespace vcell::check
