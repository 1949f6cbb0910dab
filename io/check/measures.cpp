#include "measures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "clearances.hpp"
#include "integrals.hpp"

namespace vcell::check {
namespace {

/// A bound that many times larger than what the enclosure needs excludes nothing.
constexpr double kLargestExcess = 0x1p20;
/// Relative: how wide enclosures may grow over the operations of an integral, where each takes the worst of
/// all roundings, before they are no better than nothing.
constexpr double kBlur = 8 * kRounding;
/// Effort from which on integrals in two variables are proved too.
constexpr int kEffortOfProofs = 14;

class MeasuresRoom : public Room {
public:
    MeasuresRoom(const Subject& subject, std::span<const EdgeBound> edges, const CheckOptions& options,
                 Certificate& certificate)
        : Room(subject, options, certificate),
          edges_(edges),
          frame_(cell_.scene),
          size_(geometry_.scale() / frame_.unit()) {}

    /// False: integrals of shadows are estimates.
    bool run() {
        integrate_all();
        judge_edges();
        judge_faces();
        judge_measures();
        judge_clearances();
        judge_neighbors();
        judge_report();
        return integrals_.are_shadows_proved;
    }

private:
    static double power(double x, int dimension) { return dimension == 1 ? x : x * power(x, dimension - 1); }
    double unit(int dimension) const { return power(frame_.unit(), dimension); }
    static Interval pi() { return {std::numbers::pi, std::nextafter(std::numbers::pi, 4)}; }

    /// How far an edge may be from the true one, in the frame's unit: what was proved of it. Where nothing
    /// was, the edge is refuted or open itself; measures are judged as if it kept to the scene's tolerance.
    double edge_error(std::size_t e) const {
        const double rounding = kRounding * size_;
        const double known = std::isfinite(edges_[e].distance) ? edges_[e].distance : full_error(e);
        return rounding + std::min(known, 2 * scene_tolerance()) / frame_.unit();
    }

    void integrate_all() {
        std::vector<std::vector<EdgeUse>> uses(uses_.size());
        std::vector<EdgeBand> bands;
        for (std::size_t e = 0; e < uses_.size(); ++e) {
            // Half the squared gradient of an excess is 1 - u n', of which the steepness is sqrt(2 / (1 - u
            // n')).
            const double growth = edges_[e].growth;
            bands.push_back({edge_error(e), growth > 0 ? std::sqrt(2 / growth) : HUGE_VAL});
            uses[e].reserve(uses_[e].size());
            for (const auto& use : uses_[e]) uses[e].push_back({use.face, use.reversed});
        }
        // As exact as coordinates are.
        const std::array<double, 3> enough{0x1p-44 * power(size_, 3), 0x1p-44 * power(size_, 2),
                                           0x1p-44 * size_};
        integrals_ =
            integrate_faces(cell_, frame_, uses, bands, enough, 1 << std::clamp(options_.effort - 4, 0, 20),
                            options_.effort >= kEffortOfProofs);
    }

    /// As many times what rules estimate of their own errors those may be wrong by before they refute
    /// anything.
    static constexpr double kDoubt = 16;

    /// Judges a number with its bound, both as stated. `slack`: what the edges' errors may change;
    /// `dimension` of the length in its unit.
    void judge(std::string where, double stated, double bound, Interval enclosure, double slack,
               int dimension, bool is_proved = true) {
        const double u = unit(dimension);
        if (!std::isfinite(stated)) return note(where, "was not measured");
        if (!(bound >= 0) || !std::isfinite(bound))
            return note(where + "_error", fmt::format("is {}, must be finite and not negative", bound));
        const double value = stated / u, b = bound / u;
        const double own = enclosure.radius() + slack;
        if (!std::isfinite(own))
            return certificate_.leave_open(where, "its integrals could not be enclosed with this effort",
                                           own);
        const Interval off = Interval(value) - enclosure;
        const double least = std::max({0.0, off.lower(), -off.upper()}) - slack,
                     most = off.magnitude() + slack;
        if (least > b) {
            const std::string what = fmt::format("is {} -+ {:.3g}, integration gives {} -+ {:.3g}", stated,
                                                 bound, enclosure.mid() * u, own * u);
            if (is_proved || least > b + kDoubt * enclosure.radius())
                return certificate_.refute(where, what, least * u);
            return certificate_.leave_open(where, what + " by rules that estimate", most * u);
        }
        const double rounding = kRounding * power(size_, dimension) + slack;
        // What a length may be off by where curves keep to the scene's tolerance, however close they are in
        // fact: four times that, as in judge_edges().
        const double tolerated = 4 * scene_tolerance() / frame_.unit() * power(size_, dimension) / size_;
        if (b > std::max(kLargestExcess * (own + rounding), tolerated))
            return certificate_.refute(
                where,
                fmt::format("a bound of {:.3g} on its error excludes nothing, {:.3g} would do", bound,
                            most * u),
                bound);
        const bool is_exact = enclosure.width() <= 0x1p-1000 && enclosure.contains(value);
        if (b < 0x1p-54 * std::abs(value) && !is_exact)
            return certificate_.refute(
                where, fmt::format("a bound of {:.3g} on its error is less than its own last place", bound),
                most * u);
        if (most > b && enclosure.radius() > b + slack + kBlur * power(size_, dimension))
            return certificate_.leave_open(
                where,
                fmt::format("is {} -+ {:.3g}, enclosed no better than within {:.3g} of {}", stated, bound,
                            own * u, enclosure.mid() * u),
                most * u);
        certificate_.prove(std::move(where), most * u,
                           is_proved ? "" : "what quadrature leaves out is estimated");
    }

    void judge_edges() {
        for (std::size_t e = 0; e < cell_.edges.size(); ++e) {
            const CellEdge& edge = cell_.edges[e];
            // The true arc ends within the error of its vertices; between them its length differs by the
            // error of the direction, of which the written curve's turning tells: at most the error times the
            // angle, twice the error at the ends and the error's own turning, which nobody bounds.
            judge(edge_path(e) + ".length", edge.length, edge.length_error, integrals_.lengths[e],
                  4 * edge_error(e), 1);
        }
    }

    void judge_faces() {
        for (std::size_t f = 0; f < cell_.faces.size(); ++f) {
            const FaceIntegrals& face = integrals_.faces[f];
            if (!face.is_known) {
                certificate_.leave_open(face_path(f) + ".area",
                                        "on which side of its site the base is could not be told", HUGE_VAL);
                continue;
            }
            judge(face_path(f) + ".area", cell_.faces[f].area, cell_.faces[f].area_error, face.area,
                  integrals_.slack[f].area, 2, integrals_.is_proved);
        }
    }

    void judge_measures() {
        const Measures& m = cell_.measures;
        Interval volume = 0.0, area = 0.0, box_area = integrals_.sides, shadow = 0.0;
        bool is_known = true, touches = false;
        double object_slack = 0, box_slack = 0;
        for (std::size_t f = 0; f < cell_.faces.size(); ++f) {
            const FaceIntegrals& face = integrals_.faces[f];
            is_known &= face.is_known;
            volume += face.volume;
            shadow += face.shadow;
            (cell_.faces[f].site.is_object() ? area : box_area) += face.area;
            (cell_.faces[f].site.is_object() ? object_slack : box_slack) += integrals_.slack[f].area;
            touches |= !cell_.faces[f].site.is_object();
        }
        if (!is_known) return;  // left open with the face
        double side_slack = 0;  // rims end where their neighbours' errors let them
        for (std::size_t e = 0; e < rim_.size(); ++e) {
            if (!rim_[e]) continue;
            touches = true;
            side_slack += edge_error(e) * (integrals_.lengths[e].upper() + 2 * size_);
        }
        Interval body = 0.0;
        Interval region =
            Interval::ball(geometry_.base_area() / unit(2), 0.25 * kRounding * size_ * size_);  // a plane's
        const Interval r = frame_.radius();
        if (geometry_.is_sphere()) {
            body = pi() * (4.0 / Interval(3.0)) * r * square(r);
            region = 4.0 * (pi() * square(r));
        } else if (geometry_.is_cylinder()) {
            const auto& stretch = subject_.space.stretch();
            const Interval length = hull(frame_.length((stretch[1] - stretch[0]).lower()),
                                         frame_.length((stretch[1] - stretch[0]).upper()));
            body = pi() * square(r) * length;
            region = 2.0 * (pi() * r * length);
            box_area -= 2.0 * (pi() * square(r));
        }
        judge("measures.volume", m.volume, m.volume_error, volume, integrals_.total.volume, 3,
              integrals_.is_proved);
        judge("measures.area", m.area, m.area_error, area, object_slack, 2, integrals_.is_proved);
        judge("measures.box_area", m.box_area, m.box_area_error, box_area, box_slack + side_slack, 2,
              integrals_.is_proved);
        judge("measures.body_volume", m.body_volume, m.body_volume_error, body, 0, 3);
        judge("measures.base_area", m.base_area, m.base_area_error, region, 0, 2);
        if (m.touches_box != touches)
            note("measures.touches_box", fmt::format("is {}, must be {}", m.touches_box, touches));
        else
            certificate_.prove("measures.touches_box");
        judge_shadow(shadow);
    }

    /// Edges are used once from either side, so that every base point that is on none lies under the same
    /// number of faces, counted with their orientation; the area of all shadows tells how many.
    void judge_shadow(Interval shadow) {
        const double u = geometry_.is_plane() ? unit(2) : geometry_.is_cylinder() ? unit(1) : 1;
        const double whole = geometry_.shadow() / u;
        const Interval times = shadow / Interval(whole);
        if (times.lower() > 0.5 && times.upper() < 1.5)
            certificate_.prove("faces");
        else if (times.upper() < 0.75 || times.lower() > 1.25)
            note("faces", fmt::format("stand over {:.6g} of the base region", times.mid()));
        else
            certificate_.leave_open(
                "faces", "the area that they stand over could not be enclosed with this effort", HUGE_VAL);
        for (std::size_t f = 0; f < cell_.faces.size(); ++f) {
            if (integrals_.faces[f].shadow.upper() >= -integrals_.slack[f].shadow) continue;
            constexpr const char* what = "its loops run the wrong way around its shadow on the base";
            if (integrals_.is_proved)
                note(face_path(f), what);
            else
                certificate_.leave_open(face_path(f), fmt::format("{}, by rules that estimate", what),
                                        HUGE_VAL);
        }
    }

    void judge_clearances() {
        if (cell_.faces.empty()) return;
        const Measures& m = cell_.measures;
        double slack = 0;
        for (std::size_t e = 0; e < cell_.edges.size(); ++e) slack = std::max(slack, edge_error(e));
        const Clearances found = clearances(subject_, frame_);
        judge("measures.min_clearance", m.min_clearance, m.min_clearance_error, found.least, slack, 1);
        judge("measures.max_clearance", m.max_clearance, m.max_clearance_error, found.greatest, slack, 1);
    }

    void judge_neighbors() {
        struct Owned {
            Interval area = 0.0;
            double slack = 0;
        };
        std::map<std::uint32_t, Owned> owned;
        for (std::size_t f = 0; f < cell_.faces.size(); ++f) {
            const auto own = [&](const Site& site) {
                if (!site.is_object()) return;
                Owned& o = owned[site.index];
                o.area += integrals_.faces[f].area;
                o.slack += integrals_.slack[f].area + kRounding * size_ * size_;
            };
            own(cell_.faces[f].site);
            for (const Site& site : cell_.faces[f].extra_sites) own(site);
        }
        std::size_t before = certificate_.count(Verdict::refuted);
        std::map<std::uint32_t, int> listed;
        for (std::size_t i = 0; i < cell_.neighbors.size(); ++i) {
            const std::uint32_t object = cell_.neighbors[i];
            const std::string where = fmt::format("neighbors[{}]", i);
            if (!owned.contains(object)) {
                note(where, fmt::format("object {} owns no face", object));
            } else if (listed[object]++) {
                note(where, fmt::format("object {} is listed twice", object));
            } else if (i > 0 && owned.contains(cell_.neighbors[i - 1])) {
                const Owned &more = owned[cell_.neighbors[i - 1]], &less = owned[object];
                if (more.area.upper() + more.slack < less.area.lower() - less.slack)
                    note(where, fmt::format("object {} owns more area than the one before it", object));
            }
        }
        for (const auto& [object, o] : owned)
            if (!listed.contains(object))
                note("neighbors", fmt::format("lack object {}, which owns a face", object));
        if (certificate_.count(Verdict::refuted) == before) certificate_.prove("neighbors");
    }

    void judge_report() {
        const Report& report = cell_.report;
        for (const auto& [name, seconds] :
             {std::pair("bisectors", report.seconds_bisectors),
              std::pair("envelope", report.seconds_envelope), std::pair("patches", report.seconds_patches)})
            if (!(seconds >= 0) || std::isinf(seconds))
                note(fmt::format("report.seconds.{}", name),
                     fmt::format("is {}, must be finite and not negative", seconds));
        // Each coincidence that was taken for granted is named among the warnings.
        const auto named = static_cast<std::uint64_t>(std::ranges::count_if(
            report.warnings, [](const std::string& w) { return w.find("taken") != std::string::npos; }));
        if (report.decisions.assumed != named)
            note("report.decisions.assumed", fmt::format("is {}, {} warnings say what was taken for granted",
                                                         report.decisions.assumed, named));
        else
            certificate_.prove("report.decisions.assumed");
    }

    std::span<const EdgeBound> edges_;
    Frame frame_;
    double size_;  // of the scene, in the frame's unit
    Integrals integrals_;
};

}  // namespace

bool certify_measures(const Subject& subject, std::span<const EdgeBound> edges, const CheckOptions& options,
                      Certificate& certificate) {
    return MeasuresRoom(subject, edges, options, certificate).run();
}

}  // namespace vcell::check
