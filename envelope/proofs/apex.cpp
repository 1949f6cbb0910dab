#include "apex.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "../../primitives/bisectors/height_conics.hpp"
#include "crossing_tie.hpp"
#include "space_tie.hpp"
#include "touching.hpp"

namespace vcell {

// Where gradients of competitors may agree it is a zero of their difference; else where three of them are
// equal; in any case all of them must be equal there, and pairs whose gradients are not certainly different
// must have equal ones.
std::optional<Apex> ApexFinder::find() {
    const std::vector<Spread>& r = work_.rivals;
    const std::size_t n = r.size();
    Apex apex{{}, 0, {}, {}, {}, 0, false};
    apex.differences.resize(n, std::vector<TiedDifference>(n));
    std::vector<std::array<std::size_t, 2>> touching;
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = i + 1; j < n; ++j) {
            apex.differences[i][j].gradient = work_.gradient(r[i], r[j]);
            if (!work_.direction(r[i], r[j])) touching.push_back({i, j});
        }
    if (work_.knots.size() > 1) return std::nullopt;
    if (!work_.knots.empty()) {
        apex.rim = work_.knots[0];
        const MixedPiece::Vertex& v = work_.piece.vertices[*apex.rim];
        if (!work_.all_tie_in(*apex.rim)) return std::nullopt;
        apex.point = v.point;
        apex.error = v.error;
        apex.decided = touching.empty();
        if (touching.empty()) {
            find_between(apex, assumed_exponent);
            return apex;
        }
    }

    std::optional<ProvedRoot> root;
    std::array<FormId, 3> triple;
    if (!touching.empty()) {
        const FormId f = r[touching[0][0]].form, g = r[touching[0][1]].form;
        root = root_near(equal_gradients(heights_, f, g), apex.rim ? apex.point : work_.middle(),
                         work_.around());
    } else {
        if (n < 4) return std::nullopt;  // then they tie in one point at most, and the piece will be plain
        const auto told = triple_in_one_point();
        if (!told) return find_in_line(std::move(apex));
        triple = *told;
        root = root_near(
            model_of<Interval>([&](const IntervalBox<2>& p) { return equal_heights(heights_, triple, p); }),
            work_.middle(), work_.around());
    }
    if (!root) return std::nullopt;
    if (apex.rim) {
        if (!((root->point - apex.point).norm() <= 2 * (root->error + apex.error))) return std::nullopt;
    } else {
        apex.point = root->point;
        apex.error = root->error;
        if (work_.where(apex.point, apex.error) != Inside::Yes) return std::nullopt;
    }
    const Interval X = Interval::ball(root->point.x(), root->error),
                   Y = Interval::ball(root->point.y(), root->error);
    for (std::size_t i = 1; i < n; ++i)
        if (heights_.value_difference(r[i].form, r[0].form, X, Y).sign()) return std::nullopt;

    if (touching.empty()) {
        MixedPiece::Vertex v{apex.point, apex.error, triple[0], work_.forms()};
        bool is_exact = true;
        for (const Spread& s : r) {
            if (std::ranges::find(triple, s.form) != triple.end() ||
                points_.sign_at_vertex(v, triple, s.form) == Sign::Zero)
                continue;
            is_exact = false;
            const auto off = points_.ties_in_noise(v, triple, s.form);
            if (!off) return std::nullopt;
            // Where it is equal to others moves by so much.
            for (const Spread& o : r)
                if (&o != &s)
                    apex.noise = std::max(apex.noise, *off / PieceWork::least(work_.gradient(s, o)).norm());
        }
        apex.decided = is_exact && points_.settle_tie(v, triple);
        find_between(apex, is_exact ? assumed_exponent : noise_exponent);
        if (!is_exact) {
            if (apex.between.empty() || !can_be_told(apex)) return std::nullopt;
            return apex;
        }
        apex.point = v.point;
        apex.error = v.error;
        return apex;
    }
    const auto c = points_.sharp_critical_point(r[touching[0][0]].form, r[touching[0][1]].form, root->point);
    if (!c) return std::nullopt;
    std::vector<HeightJet<Wide>> jets;
    for (const Spread& s : r) jets.push_back(heights_.jet(s.form, (*c)[0], (*c)[1]));
    const auto is_tied = [&](const auto& pair) {
        const auto &a = jets[pair[0]], &b = jets[pair[1]];
        return agree(a.gx, b.gx, Wide(1.0)) && agree(a.gy, b.gy, Wide(1.0));
    };
    const Vector2d rounded(nearest_double((*c)[0], extent_), nearest_double((*c)[1], extent_));
    if (!std::ranges::all_of(jets, [&](const auto& j) { return agree(jets[0].v, j.v, jets[0].v); }) ||
        !std::ranges::all_of(touching, is_tied)) {
        if (apex.rim) return std::nullopt;
        apex.error = Interval::up(apex.error + Interval::up((rounded - apex.point).norm()));
        apex.point = rounded;
        return find_touching_in_noise(std::move(apex), touching, jets);
    }
    if (apex.rim)
        for (const PieceSide* side : work_.sides_at(*apex.rim))
            if (!agree(Wide(side->a) * (*c)[0] + Wide(side->b) * (*c)[1], -Wide(side->c), Wide(extent_)))
                return std::nullopt;
    const Interval bx(work_.piece.box[0], work_.piece.box[1]), by(work_.piece.box[2], work_.piece.box[3]);
    const auto exact = points_.exact_tie(work_.forms(), (*c)[0], (*c)[1]);
    apex.decided = exact.has_value();
    for (const auto& [i, j] : touching) {
        apex.decided = apex.decided && have_equal_gradients(heights_.family(), r[i].form, r[j].form, *exact);
        apex.differences[i][j].curvature = heights_.curvature_difference(r[i].form, r[j].form, bx, by);
    }
    if (apex.rim)
        for (const PieceSide* side : work_.sides_at(*apex.rim))
            apex.decided = apex.decided && is_on_line(*exact, side->a, side->b, side->c);
    apex.decided = apex.decided || is_tie_in_space(apex, touching, *c);
    if (apex.rim) return apex;
    apex.error = Interval::up(apex.error + Interval::up((rounded - apex.point).norm()));
    apex.point = rounded;
    apex.decided = apex.decided || (2 * touching.size() == n * (n - 1) && is_tie_of_planes(apex));
    return apex;
}

// Four forms that tie in the apex but for noise, as the gradients of those that touch do. More may differ by
// more than that noise where they come together.
std::optional<Apex> ApexFinder::find_touching_in_noise(Apex apex,
                                                       std::span<const std::array<std::size_t, 2>> touching,
                                                       std::span<const HeightJet<Wide>> jets) const {
    const std::vector<Spread>& r = work_.rivals;
    if (r.size() != 4) return std::nullopt;
    const int noise = jets[0].v.magnitude_exponent() + noise_exponent;
    const Interval bx(work_.piece.box[0], work_.piece.box[1]), by(work_.piece.box[2], work_.piece.box[3]);
    for (std::size_t i = 0; i < r.size(); ++i)
        for (std::size_t j = i + 1; j < r.size(); ++j) {
            const Wide off = jets[i].v - jets[j].v;
            if (off.magnitude_exponent() >= noise) return std::nullopt;
            const Interval value = off.enclosure().magnitude();
            if (std::ranges::find(touching, std::array{i, j}) == touching.end()) {
                const double slope = PieceWork::least(work_.gradient(r[i], r[j])).norm();
                apex.noise = std::max(apex.noise, (value / Interval(slope)).upper());
                continue;
            }
            const Wide gx = jets[i].gx - jets[j].gx, gy = jets[i].gy - jets[j].gy;
            if (std::max(gx.magnitude_exponent(), gy.magnitude_exponent()) >= noise_exponent)
                return std::nullopt;
            // The difference is v + g.p + p.Hp / 2 at p from the apex. With l the least magnitude of an
            // eigenvalue of H, which is det H over the other one, the last term outweighs the others where
            // |p| > 2 |g| / l + sqrt(2 |v| / l).
            const HeightCurvature<Interval> bend =
                heights_.curvature_difference(r[i].form, r[j].form, bx, by);
            const Interval det = bend.xx * bend.yy - square(bend.xy);
            if (!det.sign()) return std::nullopt;
            const double most =
                (Interval(bend.xx.magnitude()) + bend.yy.magnitude() + 2 * bend.xy.magnitude()).upper();
            const Interval least = Interval(std::min(std::abs(det.lower()), std::abs(det.upper()))) / most;
            const Interval slope = Interval(gx.enclosure().magnitude()) + gy.enclosure().magnitude();
            apex.noise = std::max(apex.noise, (2.0 * slope / least + sqrt(2.0 * value / least)).upper());
            apex.differences[i][j].curvature = bend;
        }
    return can_be_told(apex) ? std::optional(std::move(apex)) : std::nullopt;
}

// What forms do about the apex is seen from as far away as this only.
bool ApexFinder::can_be_told(const Apex& apex) const {
    constexpr double far = 256;
    return far * apex.noise <= work_.width && work_.where(apex.point, apex.error + apex.noise) == Inside::Yes;
}

// Do the equations of all forms leave a point of the piece, or of the rim where the apex is there, in which
// those that touch have equal gradients? As the curvature of their difference lets the first two have these
// once in the piece, it is the apex.
bool ApexFinder::is_tie_in_space(const Apex& apex, std::span<const std::array<std::size_t, 2>> touching,
                                 const std::array<Wide, 2>& at) const {
    const HeightCurvature<Interval>& bend = *apex.differences[touching[0][0]][touching[0][1]].curvature;
    if (!(bend.xx * bend.yy - square(bend.xy)).sign()) return false;
    const FormFamily& family = heights_.family();
    const std::vector<FormId> forms = work_.forms();
    const SpaceTie tie(family, forms);
    std::vector<SpacePoint> candidates = tie.points();
    if (candidates.empty()) candidates = tie.tangencies();
    if (candidates.empty())
        if (auto p = points_.exact_tie_in_space(forms, at)) candidates.push_back(*std::move(p));
    return std::ranges::any_of(candidates, [&](const SpacePoint& p) {
        const auto place = chart_point(family, p);
        if (!place || !all_.is_met(forms[0], (*place)[0], (*place)[1])) return false;
        const auto is_on_rim = [&](const PieceSide& side) {
            const auto sides = work_.sides_at(*apex.rim);
            return std::ranges::any_of(sides, [&](const PieceSide* s) { return s->id == side.id; }) &&
                   is_on_line(family, p, {side.a, side.b, side.c});
        };
        const auto is_inside = [&](const PieceSide& side) {
            const Interval off =
                Interval(side.a) * (*place)[0] + Interval(side.b) * (*place)[1] + Interval(side.c);
            return off.sign() == Sign::Positive || (apex.rim && is_on_rim(side));
        };
        return std::ranges::all_of(work_.boundary.sides, is_inside) &&
               std::ranges::all_of(touching, [&](const std::array<std::size_t, 2>& pair) {
                   return have_equal_gradients(family, forms[pair[0]], forms[pair[1]], p);
               });
    });
}

// Every trisector is the union of two plane sections, and all these planes have a line in common. If it is
// upright, all forms are equal and have equal gradients where it stands. Otherwise, if the height of a form
// minus that of the line changes sign along it, near the apex, then all forms are equal in a point of it, and
// sections cross there transversally: the gradients agree. The first trisector has one such point in the
// piece, the apex. Over curved bases, and where those planes have irrational coefficients, that is told of
// cylinders of one radius that cross.
bool ApexFinder::is_tie_of_planes(const Apex& apex) const {
    const std::vector<Spread>& r = work_.rivals;
    const HeightCurvature<Interval>& bend = *apex.differences[0][1].curvature;
    if (!(bend.xx * bend.yy - square(bend.xy)).sign()) return false;
    const auto inside = [&](const Interval& x, const Interval& y) {
        return work_.where(x, y) == Inside::Yes;
    };
    const std::vector<FormId> forms = work_.forms();
    if (std::ranges::none_of(forms, [&](FormId f) { return heights_.family().is_circular(f); }) &&
        is_tie_over_crossing(heights_.family(), forms, inside, apex.point, work_.width))
        return true;
    if (!heights_.family().radial.empty()) return false;
    std::vector<std::array<Exact, 4>> planes;
    for (std::size_t i = 1; i < r.size(); ++i) {
        if (heights_.family().is_circular(r[0].form) && heights_.family().is_circular(r[i].form))
            return false;
        const auto two = height_planes(heights_.family(), r[0].form, r[i].form);
        if (two.size() != 2) return false;
        planes.insert(planes.end(), two.begin(), two.end());
    }
    const auto &p = planes[0], &q = planes[1], &raised = p[2].sign() != Sign::Zero ? p : q;
    for (std::size_t k = 2; k < planes.size(); ++k) {
        const auto dependent = [&](int i, int j, int l) {
            const auto& o = planes[k];
            return (o[i] * (p[j] * q[l] - p[l] * q[j]) - o[j] * (p[i] * q[l] - p[l] * q[i]) +
                    o[l] * (p[i] * q[j] - p[j] * q[i]))
                       .sign() == Sign::Zero;
        };
        if (!dependent(0, 1, 2) || !dependent(0, 1, 3) || !dependent(0, 2, 3) || !dependent(1, 2, 3))
            return false;
    }
    if (raised[2].sign() == Sign::Zero) {
        const Interval det = (p[0] * q[1] - p[1] * q[0]).enclosure();
        return inside((p[1] * q[3] - p[3] * q[1]).enclosure() / det,
                      (p[3] * q[0] - p[0] * q[3]).enclosure() / det);
    }
    const auto eliminate = [&](int k) { return (q[2] * p[k] - p[2] * q[k]).enclosure(); };
    const Interval a = eliminate(0), b = eliminate(1), c = eliminate(3);
    const bool by_x = a.magnitude() <= b.magnitude();
    const auto above = [&](double s) {  // the form less the line
        const Interval other = by_x ? -(a * Interval(s) + c) / b : -(b * Interval(s) + c) / a;
        const Interval x = by_x ? Interval(s) : other, y = by_x ? other : Interval(s);
        if (!inside(x, y)) return std::optional<Sign>();
        return (heights_.value(r[0].form, x, y) +
                (raised[0].enclosure() * x + raised[1].enclosure() * y + raised[3].enclosure()) /
                    raised[2].enclosure())
            .sign();
    };
    // Where to stop asking: nearer to the apex the two sides are told apart by fewer digits.
    constexpr double least_step = 0x1p-10;
    for (double step = 0.5 * work_.width; step > least_step * work_.width; step *= 0.5) {
        const double s = apex.point[by_x ? 0 : 1];
        const auto before = above(s - step), after = above(s + step);
        if (before && after) return *before == -*after && *before != Sign::Zero;
    }
    return false;
}

std::optional<std::array<FormId, 3>> ApexFinder::triple_in_one_point() const {
    const std::vector<Spread>& r = work_.rivals;
    for (std::size_t i = 0; i < r.size(); ++i)
        for (std::size_t j = i + 1; j < r.size(); ++j)
            for (std::size_t k = j + 1; k < r.size(); ++k)
                if (const auto turn = work_.turn(r[i], r[j], r[k]); turn && *turn != Sign::Zero)
                    return std::array{r[i].form, r[j].form, r[k].form};
    return std::nullopt;
}

// All gradients are on one line: the apex is where three of the forms touch.
std::optional<Apex> ApexFinder::find_in_line(Apex apex) {
    const std::vector<Spread>& r = work_.rivals;
    const auto touching = [&]() -> std::optional<Touching> {
        for (const std::size_t m : {0u, 1u, 2u})
            for (const auto find : {find_touching, find_pinch})
                if (auto t =
                        find(heights_, r[m].form, r[(m + 1) % 3].form, r[(m + 2) % 3].form, work_.piece.box))
                    return t;
        return std::nullopt;
    }();
    if (!touching) return std::nullopt;
    apex.point = touching->place;
    apex.error = touching->width;
    if (work_.where(apex.point, apex.error) != Inside::Yes) return std::nullopt;
    const auto& [x, y] = touching->at;
    for (const Spread& s : r)
        if (!agree(heights_.value(s.form, x, y), touching->height, touching->height)) return std::nullopt;
    apex.decided = true;
    find_between(apex, assumed_exponent);
    return apex;
}

// The triples of the apex whose gradients are on one line there: where two of them are equal, the third one's
// height above them is 0 at the apex, as its slope is, and bends one way. Or it is so up to noise, in some
// place nearby, which is the apex's noise.
void ApexFinder::find_between(Apex& apex, int exponent) {
    const std::vector<Spread>& r = work_.rivals;
    const auto add = [&](std::size_t m, std::size_t i, std::size_t j) {
        const FormId h = r[m].form, f = r[i].form, g = r[j].form;
        for (const bool shows : {false, true}) {
            const auto touching = (shows ? find_pinch : find_touching)(heights_, h, f, g, work_.piece.box);
            if (!touching ||
                touching->gap.magnitude_exponent() >= touching->height.magnitude_exponent() + exponent)
                continue;
            const double apart = (touching->place - apex.point).norm();
            if (exponent == assumed_exponent) {
                if (apart > touching->width + 2 * apex.error) continue;
                apex.decided = apex.decided && points_.exact_touch(std::array{f, g, h}, work_.forms(),
                                                                   touching->at, work_.piece.box);
            } else {
                apex.noise = std::max(apex.noise, Interval::up(apart + touching->width));
            }
            ++decisions_.by_multiprecision;
            apex.between.push_back({m, {i, j}, shows});
            return true;
        }
        return false;
    };
    for (std::size_t i = 0; i < r.size(); ++i)
        for (std::size_t j = i + 1; j < r.size(); ++j)
            for (std::size_t k = j + 1; k < r.size(); ++k)
                if (!work_.turn(r[i], r[j], r[k])) add(i, j, k) || add(j, i, k) || add(k, i, j);
}

}  // namespace vcell
