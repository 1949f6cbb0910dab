#include "faces.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "../trims.hpp"

namespace vcell::check {
namespace {

class Faces : public Room {
public:
    using Room::Room;

    void run() {
        check_faces();
    }

private:
    void check_faces() {
        for (std::size_t f = 0; f < cell_.faces.size(); ++f) {
            const CellFace& face = cell_.faces[f];
            const auto names = geometry_.bisector_names(face.site);
            if (std::ranges::find(names, face.bisector) == names.end())
                note(face_path(f) + ".bisector", fmt::format("is \"{}\", of the base and {} it is \"{}\"",
                                                             face.bisector, title(face.site), names[0]));
        }
        for (const Patch& patch : patches_) {
            check_patch_points(patch);
            for (std::size_t l = 0; l < patch.loops.size(); ++l)
                for (std::size_t t = 0; t < patch.loops[l].size(); ++t)
                    if (patch.loops[l][t].curve->edge)
                        check_trim(patch, patch.loops[l][t],
                                   fmt::format("{}[{}]", loop_path(patch.face, patch.index, l), t));
        }
    }

    void check_patch_points(const Patch& patch) {
        const std::string where = patch_path(patch.face, patch.index);
        constexpr int kTries = 64, kEnough = 12;
        int found = 0;
        for (int k = 1; k <= kTries && found < kEnough; ++k) {
            // Points of the additive recurrence with the golden ratio's plane analogue: even coverage.
            const Vec2 s(std::fmod(0.7548776662466927 * k, 1.0), std::fmod(0.5698402909980532 * k, 1.0));
            const Vec2 uv = patch.lo + s.cwiseProduct(patch.hi - patch.lo);
            if (!inside(patch, uv, rounding()).value_or(false)) continue;
            ++found;
            const SurfacePoint x = lift(patch, uv);
            if (geometry_.up(x.p).dot(x.pu.cross(x.pv)) <= 0)
                return note(where, "du x dv points towards the base");
            const Site& site = cell_.faces[patch.face].site;
            std::vector<Site> sites = cell_.faces[patch.face].extra_sites;
            sites.insert(sites.begin(), site);
            if (const auto what = contradiction(x.p, surface_rounding(patch, x, uv), sites))
                return note(where, *what);
        }
    }

    void check_trim(const Patch& patch, const Trim& trim, const std::string& where) {
        const std::size_t e = *trim.curve->edge;
        const auto& curve = edge_pieces_[e];
        constexpr int kSteps = 12;
        for (int k = 0; k <= kSteps; ++k) {
            const double s = static_cast<double>(k) / kSteps;
            const double t = trim.begin() + s * (trim.end() - trim.begin());
            const Vec2 uv = evaluate(trim.pieces, t);
            const SurfacePoint x = lift(patch, uv);
            const Vec3 p = evaluate(curve, edge_parameter(*trim.curve, cell_.edges[e].curve, t));
            if (const double gap = (x.p - p).norm(); gap > 2 * full_error(e) + surface_rounding(patch, x, uv))
                return note(
                    where,
                    fmt::format("lifts to a curve {:.3g} away from edge {} at the same parameter", gap, e));
        }
    }
};

}  // namespace

void certify_faces(const Subject& subject, const CheckOptions& options, Certificate& certificate) {
    Faces(subject, options, certificate).run();
}

}  // namespace vcell::check
