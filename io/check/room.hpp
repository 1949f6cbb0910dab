/// What all rooms of the check share: the subject, the certificate that they add to, and what contradicts a
/// point of the boundary.
#pragma once

#include <optional>
#include <span>
#include <vector>
#include <string>
#include <utility>

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
    void note(std::string where, std::string what) {
        certificate_.refute(std::move(where), std::move(what));
    }

    double rounding() const { return geometry_.rounding(); }
    double height(const Vec3& p) const { return geometry_.height(p); }
    double scene_tolerance() const { return subject_.tolerance(); }
    double full_error(std::size_t e) const { return subject_.full_error(e); }
    std::vector<Site> label(std::size_t e) const { return subject_.label(e); }

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
};

}  // namespace vcell::check
