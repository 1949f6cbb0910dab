#include "trisector_curves.hpp"

#include <algorithm>
#include <optional>
#include <utility>

#include "../../core/curves/restricted_curve.hpp"
#include "../../core/errors.hpp"
#include "../../core/platform.hpp"
#include "../../primitives/bases/solid_bases.hpp"
#include "../../primitives/objects/scene.hpp"
#include "curve_components.hpp"
#include "plane_lines.hpp"
#include "region_clipping.hpp"
#include "uncut_curves.hpp"

namespace vcell {

namespace {

TrisectorCurve cut_out(const UncutCurve& whole, const CurvePart& part, const CurveComponents& components) {
    TrisectorCurve curve;
    curve.ends = part.ends;
    curve.error = part.off > 0 ? 2 * (whole.error + part.off) : whole.error;
    curve.kind = whole.kind;
    curve.degree = curve.kind == TrisectorKind::Line ? 1 : 2;
    const bool is_all = part.from == whole.curve.domain_begin() && part.to == whole.curve.domain_end();
    curve.is_closed = is_all && whole.is_closed;
    RationalCurve3 arc = is_all ? whole.curve : restricted(whole.curve, part.from, part.to);
    if (whole.kind == TrisectorKind::Spline || !whole.is_as_given) {
        const TrisectorComponent& on = components.of(whole.curve, whole.error);
        curve.kind = on.kind;
        curve.degree = on.degree;
        if (whole.kind == TrisectorKind::Spline && on.kind != TrisectorKind::Spline)
            curve.arcs = CurveComponents::along(on, arc, curve.is_closed);
    }
    if (curve.arcs.empty()) curve.arcs = {std::move(arc)};
    return curve;
}

void add_parts(const SolidCurves& all, const Box& region, std::vector<TrisectorCurve>& curves) {
    if (touch_along_line(all.solids))
        throw UndecidedError("a tube touches from within, along a line: a half plane is as far from both");
    const std::vector<std::vector<CurvePart>> parts = parts_within(all, region);
    const auto& [a, b, c] = all.solids;
    const CurveComponents components(trisector_of_solids(a, b, c));
    for (std::size_t i = 0; i < parts.size(); ++i) {
        const UncutCurve& whole = all.curves[i];
        const std::size_t before = curves.size();
        for (const CurvePart& part : parts[i]) curves.push_back(cut_out(whole, part, components));
        // A loop that is cut elsewhere than where it is described from goes on there.
        if (whole.is_closed && parts[i].size() > 1 && parts[i].front().from == whole.curve.domain_begin() &&
            parts[i].back().to == whole.curve.domain_end()) {
            TrisectorCurve& head = curves[before];
            TrisectorCurve& tail = curves.back();
            tail.arcs.insert(tail.arcs.end(), head.arcs.begin(), head.arcs.end());
            tail.ends[1] = head.ends[1];
            tail.error = std::max(tail.error, head.error);
            curves.erase(curves.begin() + static_cast<std::ptrdiff_t>(before));
        }
    }
}

std::vector<TrisectorCurve> within(const std::vector<SolidCurves>& found, const Box& region) {
    std::vector<TrisectorCurve> curves;
    for (const SolidCurves& all : found) add_parts(all, region, curves);
    return curves;
}

void require_different(const Solids& objects) {
    for (const auto& [i, j] : {std::pair(0, 1), std::pair(0, 2), std::pair(1, 2)})
        if (is_same_surface(objects[i], objects[j]))
            throw UndecidedError("two of the objects are one, so that all of a surface is as far from them");
}

std::vector<TrisectorCurve> all_curves(const Solids& objects, const Box& region, double tolerance) {
    Scene scene;
    scene.base = objects[0];
    scene.objects = {objects[1], objects[2]};
    scene.box = region;
    scene.tolerance = tolerance;
    validate(scene);
    if (std::ranges::any_of(objects, is_vessel))
        throw InputError(InputError::Kind::Unsupported, InputError::no_object, "",
                         "there is a vessel, of which no trisector is told");
    require_different(objects);
    if (!thinnest(objects)) {
        std::vector<TrisectorCurve> lines;
        for (const Solids& planes : seen_from_all_sides(objects)) {
            const auto found = lines_between_planes(planes, region, tolerance);
            lines.insert(lines.end(), found.begin(), found.end());
        }
        return lines;
    }
    // The first of the three that may be a scene's base, and else the one that may be one wherever the others
    // are. What digits do not tell from one of them they may from another.
    std::optional<UndecidedError> undecided;
    for (std::size_t first = 0; first <= objects.size(); ++first) {
        try {
            if (first == objects.size())
                return within(curves_around_thinnest(objects, region, tolerance), region);
            return within(curves_beside(objects[first], objects[(first + 1) % 3], objects[(first + 2) % 3],
                                        region, tolerance),
                          region);
        } catch (const InputError& e) {
            if (e.kind != InputError::Kind::TouchesBase && e.kind != InputError::Kind::OutOfRange) throw;
            if (first == objects.size()) throw;
        } catch (const UndecidedError& e) {
            if (!undecided) undecided = e;
        }
    }
    throw UndecidedError(*undecided);
}

}  // namespace

std::vector<TrisectorCurve> trisector(const Object& base, const Object& a, const Object& b, const Box& region,
                                      double tolerance) {
    return in_ieee_arithmetic("trisector()", [&] { return all_curves({base, a, b}, region, tolerance); });
}

}  // namespace vcell
