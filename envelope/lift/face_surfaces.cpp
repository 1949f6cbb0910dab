#include "face_surfaces.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <string>
#include <utility>

#include "../../core/threads.hpp"
#include "../../primitives/objects/message.hpp"
#include "conic_trim.hpp"
#include "face_chords.hpp"
#include "face_cut.hpp"
#include "joined_spans.hpp"

namespace vcell::radial {

FaceSurfaces::FaceSurfaces(const RadialDiagram& of, FaceLoops& loops, FacePatches& patches,
                           RadialCurves& curves, EdgeFits& fits, unsigned threads)
    : problem_(of.problem),
      diagram_(of.diagram),
      loops_(loops),
      patches_(patches),
      curves_(curves),
      fits_(fits),
      threads_(threads),
      trims_(loops, patches, curves),
      surfaces_(diagram_.dcel.face_count()),
      roundings_(diagram_.edges.size(), std::array{0.0, 0.0}) {}

void FaceSurfaces::make() {
    std::vector<FaceId> all;
    all.reserve(surfaces_.size());
    for (const FaceId face : diagram_.face_forms.ids())
        if (diagram_.face_forms[face].valid()) all.push_back(face);
    const auto asked_for = [&] {
        std::vector<EdgeId> edges;
        for (const EdgeId e : diagram_.edges.ids())
            if (fits_.is_asked_for(e)) edges.push_back(e);
        return edges;
    };
    std::vector<EdgeId> to_fit = asked_for();
    if (problem_.chart.is_sphere() && !to_fit.empty()) {
        for (const FaceId face : all)
            if (!patches_.is_cut(face) && !holds_vertices(face)) change_patch(face);
        to_fit = asked_for();
    }
    if (!problem_.chart.is_sphere())
        for (const FaceId face : all) suit_patches(face);
    fits_.grant(to_fit.size());
    fits_.fit(to_fit);
    if (fits_.refine()) fits_.fit(to_fit);
    for (std::vector<FaceId> changed = made(all); !changed.empty();) {
        to_fit.clear();
        if (!problem_.chart.is_sphere())
            for (const FaceId face : changed) suit_patches(face);
        for (const FaceId face : changed)
            loops_.around(face, [&](EdgeId e, bool) {
                if (fits_.is_asked_for(e)) to_fit.push_back(e);
            });
        sort_unique(to_fit);
        fits_.fit(to_fit);
        if (!problem_.chart.is_sphere() || patches_.has_cuts()) {
            changed = made(all);  // seams are numbered through
            continue;
        }
        for (const EdgeId e : to_fit)
            for (const unsigned side : {0u, 1u}) changed.push_back(diagram_.face(e, side));
        sort_unique(changed);
        changed = made(changed);
    }
    for (const EdgeId e : diagram_.edges.ids()) fits_.require_proof(e);
    halve_for_trims();
}

// Makes the surfaces of some faces, which are ascending. Those that have got another patch instead are left,
// ascending. Faces with one patch know nothing of each other; seams of others are numbered through.
std::vector<FaceId> FaceSurfaces::made(const std::vector<FaceId>& faces) {
    struct Left {
        std::vector<FaceId> faces;
        std::vector<EdgeId> bent;
    };
    std::vector<Left> left(range_count(faces.size()));
    for_ranges(faces.size(), threads_, [&](std::size_t begin, std::size_t end, std::size_t task) {
        for (std::size_t i = begin; i < end; ++i)
            if (patches_.is_cut(faces[i]) || !make_whole(faces[i], left[task].bent))
                left[task].faces.push_back(faces[i]);
    });
    std::vector<FaceId> changed;
    seams_ = 0;
    for (const Left& of_task : left) {
        bent_.insert(bent_.end(), of_task.bent.begin(), of_task.bent.end());
        for (const FaceId face : of_task.faces) {
            if (patches_.is_cut(face) && !lacks_digits(face) && make_cut(face)) continue;
            change_patch(face);
            changed.push_back(face);
        }
    }
    return changed;
}

// Trims for patches that do not even hold what is known of the face's boundary are not worth fitting.
void FaceSurfaces::suit_patches(FaceId face) {
    const FaceChords chords({problem_, diagram_}, loops_, patches_, curves_, face);
    patches_.suit_graph(face, chords.points());
    while (true) {
        const std::vector<bool> is_too_wide = chords.too_wide();
        if (std::ranges::find(is_too_wide, true) == is_too_wide.end()) return;
        if (!patches_.change(face, is_too_wide)) return;
    }
}

// A patch with a weight that is not positive does not hold its face.
void FaceSurfaces::change_patch(FaceId face) {
    if (patches_.change(face, cuts_[face].is_too_wide)) return;
    throw_undecided(face);
}

void FaceSurfaces::throw_undecided(FaceId face) const {
    loops_.around(face, [&](EdgeId e, bool) { fits_.require_proof(e); });
    const Site site = problem_.sites[diagram_.face_forms[face]].front();
    throw UndecidedError("object " + to_string(site) + ": no patches hold its face in the direction " +
                         to_text(Vec3(problem_.frame.rotation.transpose() * patches_.middle(face))));
}

TrimmedPatch& FaceSurfaces::whole(FaceId face) {
    std::vector<TrimmedPatch>& patches = surfaces_[face];
    if (patches.empty()) append_new(patches);
    return patches.front();
}

// ---- Faces with one patch ---------------------------------------------------------------------------

// Appends conics with a trim that turns so far that a weight is too small.
bool FaceSurfaces::make_whole(FaceId face, std::vector<EdgeId>& bent) {
    if (lacks_digits(face)) return false;
    const RadialPatch& patch = patches_[face];
    TrimmedPatch& result = whole(face);
    result.loops = trims_.loops(face);
    const Rectangle box = bounds(face, bent);
    double rounding = 0;
    std::optional<RationalPatch> surface = patch.patch(box[0], box[1], problem_.frame, rounding);
    if (!is_good(face, surface)) return false;
    forget_roundings(face);
    note_roundings(face, patch, box, result.loops, rounding);
    result.surface = std::move(*surface);
    return true;
}

// The rectangle of a face's trims. Of the loops' the largest is the outer one's, which contains the others
// and comes first from here on.
Rectangle FaceSurfaces::bounds(FaceId face, std::vector<EdgeId>& bent) {
    std::vector<std::vector<TrimCurve>>& loops = whole(face).loops;
    Rectangle outer = no_rectangle;
    const auto extent = [](const Rectangle& r) { return r[0][1] - r[0][0] + (r[1][1] - r[1][0]); };
    for (std::size_t i = 0; i < loops.size(); ++i) {
        Rectangle box = no_rectangle;
        for (const TrimCurve& trim : loops[i]) extend_by_trim(box, patches_[face], trim, bent);
        if (i > 0 && !(extent(box) > extent(outer))) continue;
        outer = box;
        std::swap(loops[0], loops[i]);
        loops_.put_first(face, i);
    }
    widen(outer);
    return outer;
}

void FaceSurfaces::extend_by_trim(Rectangle& box, const RadialPatch& patch, const TrimCurve& trim,
                                  std::vector<EdgeId>& bent) const {
    if (trim.curve.degree != 2) return extend_by_rectangle(box, curve_bounds(trim.curve));
    const auto& p = trim.curve.points;
    for (std::size_t i = 0; i + 2 < p.size(); i += 2) {
        const double weight = p[i + 1].z() / std::sqrt(p[i].z() * p[i + 2].z());
        if (!(weight >= least_weight)) {
            const EdgeId e{*trim.edge};
            bent.push_back(e);
            for (const ConicSpan& span : curves_.conics(e)) extend_by_span(box, patch, span);
            return;
        }
        for (int k = 0; k < 2; ++k) extend(box[k], p[i][k], p[i + 1][k], p[i + 2][k], weight);
    }
}

// Trims for a patch that does not even hold the vertices are not worth fitting.
bool FaceSurfaces::holds_vertices(FaceId face) const {
    const RadialPatch& patch = patches_[face];
    Rectangle box = no_rectangle;
    loops_.around(face, [&](EdgeId e, bool) {
        if (!curves_.has_ends(e)) return;
        const Vec2 p = patch.parameters(Vec3(curves_.from(e).head<3>()));
        extend_by_rectangle(box, {{{p.x(), p.x()}, {p.y(), p.y()}}});
    });
    double rounding;
    return box[0][0] > box[0][1] || is_good(face, patch.patch(box[0], box[1], problem_.frame, rounding));
}

// Halves need lower degrees than a patch that reaches far around, and lose fewer digits.
bool FaceSurfaces::is_good(FaceId face, const std::optional<RationalPatch>& surface) const {
    constexpr int highest_degree = 6;
    return surface && (surface->degree_u <= highest_degree || !patches_.can_be_halved(face));
}

// Seen from the base's centre points of a needle have nearly one direction: what its patch makes of trims in
// doubles may be anything. So may be what a steep graph makes of them.
bool FaceSurfaces::lacks_digits(FaceId face) const {
    const RadialPatch::Kind kind = patches_[face].kind();
    if (kind != RadialPatch::Kind::Stereographic && kind != RadialPatch::Kind::Graph) return false;
    const double most = kind == RadialPatch::Kind::Graph ? fits_.most_error() : 2 * fits_.tolerance();
    bool lacks = false;
    loops_.around(
        face, [&](EdgeId e, bool) { lacks = lacks || (curves_.is_spline(e) && !(fits_.error(e) <= most)); });
    return lacks;
}

void FaceSurfaces::forget_roundings(FaceId face) {
    loops_.around(face, [&](EdgeId e, bool) { roundings_[e][diagram_.face(e, 0) == face ? 0 : 1] = 0; });
}

// A patch may lose its digits far from an edge, so each is told what is rounded beside it; the most of all of
// them comes back. Patches that are rounded by less than enough_digits() need no such close look.
double FaceSurfaces::note_roundings(FaceId face, const RadialPatch& patch, const Rectangle& box,
                                    const std::vector<std::vector<TrimCurve>>& loops, double of_patch) {
    const bool is_enough = of_patch <= enough_digits();
    double most = is_enough ? of_patch : 0;
    for (const std::vector<TrimCurve>& loop : loops)
        for (const TrimCurve& trim : loop) {
            if (!trim.edge) continue;
            const EdgeId e{*trim.edge};
            const double beside =
                is_enough ? of_patch
                          : patch.rounding_along(trim.curve, box[0], box[1], problem_.frame, enough_digits());
            double& known = roundings_[e][diagram_.face(e, 0) == face ? 0 : 1];
            known = std::max(known, beside);
            most = std::max(most, beside);
        }
    return most;
}

// Trims that turn too far have their conics halved, and all trims of these are made again. Those beside
// halves were divided for their trims before.
void FaceSurfaces::halve_for_trims() {
    sort_unique(bent_);
    std::erase_if(bent_, [&](EdgeId e) { return fits_.is_beside_halves(e); });
    for (const EdgeId e : bent_) {
        // Where one face is none of the cell's the other one tells.
        const auto patch = [&](unsigned side) {
            const bool is_there = diagram_.face_forms[diagram_.face(e, side)].valid();
            return &patches_[diagram_.face(e, is_there ? side : 1 - side)];
        };
        const std::array patches{patch(0), patch(1)};
        std::vector<ConicSpan> halved;
        for (const ConicSpan& span : curves_.conics(e)) add_halves(span, patches, halved);
        curves_.set_conics(e, [&](std::vector<ConicSpan>& spans) {
            spans.insert(spans.end(), halved.begin(), halved.end());
        });
        for (const unsigned side : {0u, 1u}) {
            const FaceId face = diagram_.face(e, side);
            if (!diagram_.face_forms[face].valid()) continue;
            for (std::vector<TrimCurve>& loop : whole(face).loops)
                for (TrimCurve& trim : loop)
                    if (trim.edge == e.value) trims_.set(patches_[face], e, trim.reversed, trim.curve);
        }
    }
}

// ---- Faces in parts ---------------------------------------------------------------------------------

bool FaceSurfaces::make_cut(FaceId face) {
    constexpr int most_failures = 3;
    // Half a turn about the axis of a surface of revolution has a middle weight of zero but for rounding.
    constexpr double wide = 2.5;
    const std::span<const Sector> sectors = patches_.sectors(face);
    Cut& cut = cuts_[face];
    surfaces_[face].clear();
    forget_roundings(face);
    cut.is_too_wide.assign(patches_.part_count(face), false);
    const std::uint32_t first_seam = seams_;
    std::optional<std::vector<CutPart>> parts = cut_parts(face);
    if (!parts) {  // elsewhere the seams may be clear of its edges
        loops_.around(face, [&](EdgeId e, bool) { fits_.require_proof(e); });
        if (++cut.failures > most_failures) throw_undecided(face);
        cut.is_too_wide.assign(cut.is_too_wide.size(), true);
        return false;
    }
    if (!sectors.empty()) match_seams(face, *parts, first_seam);
    for (CutPart& part : *parts) {
        const Rectangle box = loop_domain(part.loops.front());
        const RadialPatch& patch = patches_.part(face, part.within);
        double rounding = 0;
        auto surface = patch.patch(box[0], box[1], problem_.frame, rounding);
        if (surface) rounding = note_roundings(face, patch, box, part.loops, rounding);
        const bool is_blurred =
            rounding > fits_.tolerance() && !sectors.empty() && sectors[part.within].width() > wide;
        if (!surface || is_blurred) {
            cut.is_too_wide[part.within] = true;
            continue;
        }
        surfaces_[face].push_back({std::move(*surface), std::move(part.loops)});
    }
    return std::ranges::find(cut.is_too_wide, true) == cut.is_too_wide.end();
}

std::optional<std::vector<CutPart>> FaceSurfaces::cut_parts(FaceId face) {
    if (const SurfaceHalves* two = patches_.halves(face))
        return halve_face(
            trims_.runs(face), [&](double angle, std::uint32_t half) { return two->at(angle, half); },
            seams_);
    return cut_face(trims_.all_runs(face), patches_.cut_sectors(face), seams_);
}

// A generator's conic has v as a rational parameter for either sign of d, so where the signs differ on the
// two sides of a seam one v is a quotient of linear functions of the other: a straight piece with a weight.
void FaceSurfaces::match_seams(FaceId face, std::vector<CutPart>& parts, std::uint32_t first_seam) const {
    struct Side {
        RationalCurve2* curve = nullptr;
        const RadialPatch* patch = nullptr;
    };
    std::vector<std::array<Side, 2>> sides(seams_ - first_seam);  // u > 0, u < 0
    for (CutPart& part : parts)
        for (std::vector<TrimCurve>& loop : part.loops)
            for (TrimCurve& trim : loop)
                if (trim.seam)
                    sides[*trim.seam - first_seam][trim.curve.points[0].x() < 0] = {
                        &trim.curve, &patches_.sectors(face)[part.within].patch};
    for (const auto& [left, right] : sides) {
        if (left.patch->along() == right.patch->along()) continue;
        const Vec2 half_way = 0.5 * (left.curve->points[0] + left.curve->points[1]).head<2>();
        const double v = right.patch->parameters((*left.patch)(half_way)).y();
        auto& points = right.curve->points;
        points[1].z() = (v - points[0].y()) / (points[1].y() - v);
    }
}

}  // namespace vcell::radial
