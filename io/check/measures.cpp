#include "measures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "clearances.hpp"
#include "integrals.hpp"
#include "region_area.hpp"

namespace vcell::check {
namespace {

/// A bound that many times larger than what the enclosure needs excludes nothing.
constexpr double kLargestExcess = 0x1p20;
/// Relative: how wide enclosures may grow over the operations of an integral, where each takes the worst of
/// all roundings, before they are no better than nothing.
constexpr double kBlur = 8 * kRounding;
/// Effort from which on integrals in two variables are proved too.
constexpr int kEffortOfProofs = 14;
/// Into which spans and the way to them are cut at most, where proofs are asked for.
constexpr int kPartsOfProofs = 1 << 12;

/// How long the stretch of a base cylinder is all of whose circles the box holds: 0 where there is none.
Interval stretch_of_base(const Subject& subject) {
    const auto length = [](const Space<Interval>& space) { return space.stretch()[1] - space.stretch()[0]; };
    if (!subject.part) return length(subject.space);
    const Scene& scene = subject.cell.scene;
    const Space<Interval> whole(scene);
    const Cylinder& base = std::get<Cylinder>(scene.base);
    for (std::uint32_t s = 0; s < 6; ++s) {
        const auto axis = static_cast<Eigen::Index>(s / 2);
        if (base.axis[axis] == 0 &&
            (s % 2 == 0 ? base.point[axis] <= scene.box.min[axis] : base.point[axis] >= scene.box.max[axis]))
            return 0.0;
    }
    const Interval all = length(whole);
    return {std::max(0.0, all.lower()), std::max(0.0, all.upper())};
}

Clearances clearances_of_parts(std::span<const Subject> subjects, const Frame& frame) {
    Clearances all{HUGE_VAL, -HUGE_VAL};
    for (const Subject& subject : subjects) {
        if (subject.faces.empty()) continue;
        const Clearances of_part = clearances(subject, frame);
        const auto least = [](double a, double b) { return std::min(a, b); };
        all.least = {least(all.least.lower(), of_part.least.lower()),
                     least(all.least.upper(), of_part.least.upper())};
        all.greatest = {-least(-all.greatest.lower(), -of_part.greatest.lower()),
                        -least(-all.greatest.upper(), -of_part.greatest.upper())};
    }
    return all;
}

/// What an object owns of the boundary.
struct Owned {
    Interval area = 0.0;
    double slack = 0;
    std::vector<std::size_t> faces;

    /// As far as areas are known. asks_for_proofs() has those proved that are not in their order.
    bool is_less(const Owned& other) const { return area.upper() + slack < other.area.lower() - other.slack; }
};

class MeasuresRoom : public Room {
public:
    MeasuresRoom(std::span<const Subject> subjects, std::span<const EdgeBound> edges, const TubeParts* slabs,
                 const CheckOptions& options, Certificate& certificate)
        : Room(subjects.front(), options, certificate),
          subjects_(subjects),
          edges_(edges),
          slabs_(slabs),
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
        std::vector<std::vector<EdgeUse>> uses(cell_.edges.size());
        std::vector<EdgeBand> bands;
        for (std::size_t e = 0; e < uses.size(); ++e) {
            // Half the squared gradient of an excess is 1 - u n', of which the steepness is sqrt(2 / (1 - u
            // n')).
            const double growth = edges_[e].growth;
            bands.push_back({edge_error(e), growth > 0 ? std::sqrt(2 / growth) : HUGE_VAL});
        }
        for (const Subject& subject : subjects_)
            for (const std::uint32_t e : subject.edges) {
                uses[e].reserve(subject.uses[e].size());
                for (const auto& use : subject.uses[e])
                    uses[e].push_back({use.face, use.reversed, subject.is_entered(use.face)});
            }
        // As exact as coordinates are.
        const std::array<double, 3> enough{0x1p-44 * power(size_, 3), 0x1p-44 * power(size_, 2),
                                           0x1p-44 * size_};
        const Precision exact{enough[0], enough[1]};
        std::vector<std::optional<Precision>> proofs(cell_.faces.size());
        if (options_.effort >= kEffortOfProofs) std::ranges::fill(proofs, exact);
        int parts = 1 << std::clamp(options_.effort - 4, 0, 20);
        const auto integrate = [&] {
            integrals_ = integrate_faces(cell_, frame_, uses, bands, enough, parts, proofs);
        };
        integrate();
        if (is_any_coarse()) {
            // The rules let rounding be many times what they may leave out.
            constexpr double finer = 0x1p-8;
            const Integrals fine =
                integrate_faces(cell_, frame_, uses, bands,
                                {finer * enough[0], finer * enough[1], finer * enough[2]}, parts, proofs);
            for (std::size_t f = 0; f < cell_.faces.size(); ++f)
                if (fine.faces[f].area.radius() < integrals_.faces[f].area.radius())
                    integrals_.faces[f] = fine.faces[f];
        }
        while (asks_for_proofs(proofs, exact)) {
            parts = std::max(parts, kPartsOfProofs);
            integrate();
        }
        if (geometry_.has_curved_rim()) region_ = region_area(cell_, frame_, uses, bands, exact.area);
    }

    /// Is an enclosure too wide to prove what is stated with this bound?
    bool is_coarse(double bound, Interval enclosure, double slack, int dimension) const {
        return enclosure.radius() > bound / unit(dimension) + slack + kBlur * power(size_, dimension);
    }
    /// Is the enclosure of an area too wide that is known without estimates?
    bool is_any_coarse() const {
        for (std::size_t f = 0; f < cell_.faces.size(); ++f)
            if (const FaceIntegrals& face = integrals_.faces[f];
                face.is_known && face.is_proved && std::isfinite(face.area.radius()) &&
                is_coarse(cell_.faces[f].area_error, face.area, integrals_.slack[f].area, 2))
                return true;
        return false;
    }

    /// Estimates do not refute: where one contradicts what is stated, proofs are asked for. For the whole
    /// cell's measures they need not be more exact than the contradiction.
    bool asks_for_proofs(std::vector<std::optional<Precision>>& proofs, const Precision& exact) const {
        bool asks = false;
        const auto ask = [&](std::size_t f, const Precision& precision) {
            if (integrals_.faces[f].is_proved) return;
            proofs[f] = precision;
            asks = true;
        };
        for (std::size_t f = 0; f < cell_.faces.size(); ++f) {
            const CellFace& face = cell_.faces[f];
            if (beyond(face.area, face.area_error, integrals_.faces[f].area, integrals_.slack[f].area, 2) > 0)
                ask(f, exact);
        }
        const auto owned = owned_areas();
        for (std::size_t i = 1; i < cell_.neighbors.size(); ++i) {
            const auto more = owned.find(cell_.neighbors[i - 1]), less = owned.find(cell_.neighbors[i]);
            if (more == owned.end() || less == owned.end() || !more->second.is_less(less->second)) continue;
            for (const std::size_t f : more->second.faces) ask(f, exact);
            for (const std::size_t f : less->second.faces) ask(f, exact);
        }
        const Totals t = totals();
        if (asks || !t.is_known) return asks;
        const Measures& m = cell_.measures;
        const double volume = beyond(m.volume, m.volume_error, t.volume, integrals_.total.volume, 3),
                     area = std::max(beyond(m.area, m.area_error, t.area, t.object_slack, 2),
                                     beyond(m.box_area, m.box_area_error, t.box_area, t.box_slack, 2));
        if (!(volume > 0 || area > 0)) return false;
        const auto enough = [&](double off, double least, int dimension) {
            constexpr double coarsest = 0x1p-24;
            const double most = coarsest * power(size_, dimension);
            return off > 0 ? std::clamp(off, least, most) : most;
        };
        for (std::size_t f = 0; f < cell_.faces.size(); ++f)
            ask(f, {enough(volume, exact.volume, 3), enough(area, exact.area, 2)});
        return asks;
    }

    /// In the frame's unit, how far a number as stated with its bound is at least from what the enclosure and
    /// the slack allow; 0 or less: it agrees, or is no number to ask about.
    double beyond(double stated, double bound, Interval enclosure, double slack, int dimension) const {
        if (!std::isfinite(stated) || !(bound >= 0)) return 0;
        const double u = unit(dimension);
        const Interval off = Interval(stated / u) - enclosure;
        return std::max({0.0, off.lower(), -off.upper()}) - slack - bound / u;
    }

    /// Judges a number with its bound, both as stated. `slack`: what the edges' errors may change;
    /// `dimension` of the length in its unit.
    /// `untold`: what a bound may be for all that is known of it here, in the frame's unit.
    void judge(std::string where, double stated, double bound, Interval enclosure, double slack,
               int dimension, bool is_proved = true, double untold = 0) {
        const double u = unit(dimension);
        if (!std::isfinite(stated)) return note(where, "was not measured");
        if (!(bound >= 0) || !std::isfinite(bound))
            return note(where + "_error", fmt::format("is {}, must be finite and not negative", bound));
        const double value = stated / u, b = bound / u;
        const double own = enclosure.radius() + slack;
        if (!std::isfinite(own))
            return certificate_.leave_open(where, "its integrals could not be enclosed with this effort",
                                           own);
        const double most = (Interval(value) - enclosure).magnitude() + slack;
        if (const double off = beyond(stated, bound, enclosure, slack, dimension); off > 0) {
            const std::string what = fmt::format("is {} -+ {:.3g}, integration gives {} -+ {:.3g}", stated,
                                                 bound, enclosure.mid() * u, own * u);
            if (is_proved) return certificate_.refute(where, what, (off + b) * u);
            return certificate_.leave_open(where, what + " by rules that estimate", most * u);
        }
        const double rounding = kRounding * power(size_, dimension) + slack;
        // What a length may be off by where curves keep to the scene's tolerance, however close they are in
        // fact: four times that, as in judge_edges().
        const double tolerated = 4 * scene_tolerance() / frame_.unit() * power(size_, dimension) / size_;
        if (b > std::max({kLargestExcess * (own + rounding), tolerated, untold}))
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
        if (most > b && is_coarse(bound, enclosure, slack, dimension))
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
            double ends = 0;
            for (const std::uint32_t v : edge.vertices) ends += cell_.vertices[v].error;
            judge(edge_path(e) + ".length", edge.length, edge.length_error, integrals_.lengths[e],
                  4 * edge_error(e) + ends / frame_.unit(), 1);
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
                  integrals_.slack[f].area, 2, face.is_proved);
        }
    }

    /// All faces together have these. Of a cell in parts nothing counts that their ends have.
    struct Totals {
        Interval volume = 0.0, area = 0.0, box_area = 0.0;
        double object_slack = 0, box_slack = 0;
        bool is_known = true, is_proved = true, touches_box = false;
    };

    Totals totals() const {
        Totals t;
        if (!slabs_) t.box_area = integrals_.sides;
        for (std::size_t f = 0; f < cell_.faces.size(); ++f) {
            const FaceIntegrals& face = integrals_.faces[f];
            const bool is_object = cell_.faces[f].site.is_object();
            t.is_known &= face.is_known;
            t.is_proved &= face.is_proved;
            t.touches_box |= !is_object;
            t.volume += face.volume;
            (is_object ? t.area : t.box_area) += face.area;
            (is_object ? t.object_slack : t.box_slack) += integrals_.slack[f].area;
        }
        if (slabs_) {
            t.touches_box = true;  // where the axis comes in
            t.volume += Interval(0.0, slabs_->left_out / unit(3) * (1 + 0x1p-50));
            return t;
        }
        for (std::size_t e = 0; e < rim_.size(); ++e) {
            if (!rim_[e] || rim_[e]->is_object()) continue;
            t.touches_box = true;
            // Rims end where their neighbours' errors let them.
            t.box_slack += edge_error(e) * (integrals_.lengths[e].upper() + 2 * size_);
        }
        if (geometry_.is_cylinder()) t.box_area -= 2.0 * (pi() * square(frame_.radius()));
        return t;
    }

    void judge_measures() {
        const Measures& m = cell_.measures;
        const Totals t = totals();
        if (!t.is_known) return;  // left open with the face
        Interval body = 0.0;
        Interval region =
            Interval::ball(geometry_.base_area() / unit(2), 0.25 * kRounding * size_ * size_);  // a plane's
        double region_slack = 0;
        const Interval r = frame_.radius();
        if (geometry_.is_sphere()) {
            body = pi() * (4.0 / Interval(3.0)) * r * square(r);
            region = 4.0 * (pi() * square(r));
        } else if (geometry_.is_cylinder()) {
            const Interval stretch = stretch_of_base(subject_),
                           length = hull(frame_.length(stretch.lower()), frame_.length(stretch.upper()));
            body = pi() * square(r) * length;
            region = 2.0 * (pi() * r * length);
        } else if (geometry_.has_curved_rim()) {
            region = region_.area;
            region_slack = region_.slack;
        }
        judge("measures.volume", m.volume, m.volume_error, t.volume, integrals_.total.volume, 3, t.is_proved);
        const double untold = slabs_ ? slabs_->area / unit(2) : 0;
        judge("measures.area", m.area, m.area_error, t.area, t.object_slack, 2, t.is_proved, untold);
        judge("measures.box_area", m.box_area, m.box_area_error, t.box_area, t.box_slack, 2, t.is_proved,
              untold);
        judge("measures.body_volume", m.body_volume, m.body_volume_error, body, 0, 3);
        judge("measures.base_area", m.base_area, m.base_area_error, region, region_slack, 2);
        if (m.touches_box != t.touches_box)
            note("measures.touches_box", fmt::format("is {}, must be {}", m.touches_box, t.touches_box));
        else
            certificate_.prove("measures.touches_box");
        for (const Subject& subject : subjects_) judge_shadow(subject);
    }

    /// Edges are used once from either side, so that every base point that is on none lies under the same
    /// number of faces, counted with their orientation; the area of all shadows tells how many. Where all
    /// rays come in through sides of the box there are as many such faces as others: none in all.
    void judge_shadow(const Subject& subject) {
        const double u = geometry_.is_plane() ? unit(2) : geometry_.is_cylinder() ? unit(1) : 1;
        const Interval whole = subject.geometry.shadow() / Interval(u);
        const double own = subject.part && subject.part->has_floor() ? 0 : 1;
        Interval shadow = 0.0;
        for (const std::uint32_t f : subject.faces) shadow += integrals_.faces[f].shadow;
        const Interval times = shadow / whole, off = times - own;
        if (off.lower() > -0.5 && off.upper() < 0.5)
            certificate_.prove(subject.path("faces"));
        else if (off.upper() < -0.25 || off.lower() > 0.25)
            note(subject.path("faces"), fmt::format("stand over {:.6g} of the base region", times.mid()));
        else
            certificate_.leave_open(subject.path("faces"),
                                    "the area that they stand over could not be enclosed with this effort",
                                    HUGE_VAL);
        for (const std::uint32_t f : subject.faces) {
            const Interval& each = integrals_.faces[f].shadow;
            if ((subject.is_entered(f) ? -each : each).upper() >= -integrals_.slack[f].shadow) continue;
            constexpr const char* what = "its loops run the wrong way around its shadow on the base";
            if (integrals_.are_shadows_proved)
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
        const Clearances found = clearances_of_parts(subjects_, frame_);
        judge("measures.min_clearance", m.min_clearance, m.min_clearance_error, found.least, slack, 1);
        judge("measures.max_clearance", m.max_clearance, m.max_clearance_error, found.greatest, slack, 1);
        const auto [at_least, at_most] = cell_.clearance_places.value_or(ClearancePlaces());
        constexpr const char *min = "measures.min_clearance_place", *max = "measures.max_clearance_place";
        if (at_least) judge(min, at_least->clearance, at_least->clearance_error, found.least, slack, 1);
        if (at_most) judge(max, at_most->clearance, at_most->clearance_error, found.greatest, slack, 1);
    }

    std::map<std::uint32_t, Owned> owned_areas() const {
        std::map<std::uint32_t, Owned> owned;
        for (std::size_t f = 0; f < cell_.faces.size(); ++f) {
            const auto own = [&](const Site& site) {
                if (!site.is_object()) return;
                Owned& o = owned[site.index];
                o.area += integrals_.faces[f].is_known ? integrals_.faces[f].area : Interval(0, HUGE_VAL);
                o.slack += integrals_.slack[f].area + kRounding * size_ * size_;
                o.faces.push_back(f);
            };
            own(cell_.faces[f].site);
            for (const Site& site : cell_.faces[f].extra_sites) own(site);
        }
        return owned;
    }

    void judge_neighbors() {
        const auto owned = owned_areas();
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
                const Owned &more = owned.at(cell_.neighbors[i - 1]), &less = owned.at(object);
                if (more.is_less(less))
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

    std::span<const Subject> subjects_;
    std::span<const EdgeBound> edges_;
    const TubeParts* slabs_;  // of a cell in parts
    Frame frame_;
    double size_;  // of the scene, in the frame's unit
    Integrals integrals_;
    RegionArea region_;
};

}  // namespace

bool certify_measures(std::span<const Subject> subjects, std::span<const EdgeBound> edges,
                      const TubeParts* slabs, const CheckOptions& options, Certificate& certificate) {
    return MeasuresRoom(subjects, edges, slabs, options, certificate).run();
}

}  // namespace vcell::check
