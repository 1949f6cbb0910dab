// Pieces around a point in which all competitors tie, and around saddles and pinches.
#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "../../core/errors.hpp"
#include "../../primitives/bisectors/height_conics.hpp"
#include "crossing_tie.hpp"
#include "mixed_work.hpp"
#include "space_tie.hpp"

namespace vcell {

// Where gradients of competitors may agree it is a zero of their difference; else where three of them are
// equal; in any case all of them must be equal there, and pairs whose gradients are not certainly different
// must have equal ones.
std::optional<MixedAnalysis::Apex> MixedAnalysis::find_apex(const Work& work) {
    const std::vector<Spread>& r = work.rivals;
    const std::size_t n = r.size();
    Apex apex{{}, 0, {}, {}, {}, 0, false};
    apex.differences.resize(n, std::vector<TiedDifference>(n));
    std::vector<std::array<std::size_t, 2>> touching;
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = i + 1; j < n; ++j) {
            apex.differences[i][j].gradient = work.gradient(r[i], r[j]);
            if (!work.direction(r[i], r[j])) touching.push_back({i, j});
        }
    if (work.knots.size() > 1) return std::nullopt;
    if (!work.knots.empty()) {
        apex.rim = work.knots[0];
        const MixedPiece::Vertex& v = work.piece.vertices[*apex.rim];
        if (!work.all_tie_in(*apex.rim)) return std::nullopt;
        apex.point = v.point;
        apex.error = v.error;
        apex.decided = touching.empty();
        if (touching.empty()) return apex;
    }

    std::optional<ProvedRoot> root;
    std::array<FormId, 3> triple;
    if (!touching.empty()) {
        const FormId f = r[touching[0][0]].form, g = r[touching[0][1]].form;
        root =
            root_near(equal_gradients(heights_, f, g), apex.rim ? apex.point : work.middle(), work.around());
    } else {
        if (n < 4) return std::nullopt;  // then they tie in one point at most, and the piece will be plain
        const auto told = triple_in_one_point(work);
        if (!told) return find_apex_in_line(work, std::move(apex));
        triple = *told;
        root = root_near(
            model_of<Interval>([&](const IntervalBox<2>& p) { return equal_heights(heights_, triple, p); }),
            work.middle(), work.around());
    }
    if (!root) return std::nullopt;
    if (apex.rim) {
        if (!((root->point - apex.point).norm() <= 2 * (root->error + apex.error))) return std::nullopt;
    } else {
        apex.point = root->point;
        apex.error = root->error;
        if (work.where(apex.point, apex.error) != Inside::Yes) return std::nullopt;
    }
    const Interval X = Interval::ball(root->point.x(), root->error),
                   Y = Interval::ball(root->point.y(), root->error);
    for (std::size_t i = 1; i < n; ++i)
        if (heights_.value_difference(r[i].form, r[0].form, X, Y).sign()) return std::nullopt;

    if (touching.empty()) {
        MixedPiece::Vertex v{apex.point, apex.error, triple[0], work.forms()};
        bool is_exact = true;
        for (const Spread& s : r) {
            if (std::ranges::find(triple, s.form) != triple.end() ||
                sign_at_vertex(v, triple, s.form) == Sign::Zero)
                continue;
            is_exact = false;
            const auto off = ties_in_noise(v, triple, s.form);
            if (!off) return std::nullopt;
            // Where it is equal to others moves by so much.
            for (const Spread& o : r)
                if (&o != &s)
                    apex.noise = std::max(apex.noise, *off / Work::least(work.gradient(s, o)).norm());
        }
        apex.decided = is_exact && settle_tie(v, triple);
        find_between(work, apex, is_exact ? assumed_exponent : noise_exponent);
        if (!is_exact) {
            // What the forms do about the apex is seen from as far away as this only.
            constexpr double far = 256;
            if (apex.between.empty() || !(far * apex.noise <= work.width) ||
                work.where(apex.point, apex.error + apex.noise) != Inside::Yes)
                return std::nullopt;
            return apex;
        }
        apex.point = v.point;
        apex.error = v.error;
        return apex;
    }
    const auto c = sharp_critical_point(r[touching[0][0]].form, r[touching[0][1]].form, root->point);
    if (!c) return std::nullopt;
    std::vector<HeightJet<Wide>> jets;
    for (const Spread& s : r) jets.push_back(heights_.jet(s.form, (*c)[0], (*c)[1]));
    for (std::size_t i = 1; i < n; ++i)
        if (!agree(jets[0].v, jets[i].v, jets[0].v)) return std::nullopt;
    if (apex.rim)
        for (const PieceSide* side : work.sides_at(*apex.rim))
            if (!agree(Wide(side->a) * (*c)[0] + Wide(side->b) * (*c)[1], -Wide(side->c), Wide(extent_)))
                return std::nullopt;
    const Interval bx(work.piece.box[0], work.piece.box[1]), by(work.piece.box[2], work.piece.box[3]);
    const auto exact = exact_tie(work.forms(), (*c)[0], (*c)[1]);
    apex.decided = exact.has_value();
    for (const auto& [i, j] : touching) {
        if (!agree(jets[i].gx, jets[j].gx, Wide(1.0)) || !agree(jets[i].gy, jets[j].gy, Wide(1.0)))
            return std::nullopt;
        apex.decided = apex.decided && have_equal_gradients(heights_.family(), r[i].form, r[j].form, *exact);
        apex.differences[i][j].curvature = heights_.curvature_difference(r[i].form, r[j].form, bx, by);
    }
    if (apex.rim)
        for (const PieceSide* side : work.sides_at(*apex.rim))
            apex.decided = apex.decided && is_on_line(*exact, side->a, side->b, side->c);
    apex.decided = apex.decided || is_tie_in_space(work, apex, touching);
    if (apex.rim) return apex;
    const Vector2d rounded(nearest_double((*c)[0], extent_), nearest_double((*c)[1], extent_));
    apex.error = Interval::up(apex.error + Interval::up((rounded - apex.point).norm()));
    apex.point = rounded;
    apex.decided = apex.decided || (2 * touching.size() == n * (n - 1) && is_tie_of_planes(work, apex));
    return apex;
}

// Do the equations of all forms leave a point of the piece, or of the rim where the apex is there, in which
// those that touch have equal gradients? As the curvature of their difference lets the first two have these
// once in the piece, it is the apex.
bool MixedAnalysis::is_tie_in_space(const Work& work, const Apex& apex,
                                    std::span<const std::array<std::size_t, 2>> touching) const {
    const HeightCurvature<Interval>& bend = *apex.differences[touching[0][0]][touching[0][1]].curvature;
    if (!(bend.xx * bend.yy - square(bend.xy)).sign()) return false;
    const FormFamily& family = heights_.family();
    const std::vector<FormId> forms = work.forms();
    const SpaceTie tie(family, forms);
    std::vector<SpacePoint> candidates = tie.points();
    if (candidates.empty()) candidates = tie.tangencies();
    return std::ranges::any_of(candidates, [&](const SpacePoint& p) {
        const auto place = chart_point(family, p);
        if (!place || !is_met(forms[0], (*place)[0], (*place)[1])) return false;
        const auto is_on_rim = [&](const PieceSide& side) {
            const auto at = work.sides_at(*apex.rim);
            return std::ranges::any_of(at, [&](const PieceSide* s) { return s->id == side.id; }) &&
                   is_on_line(family, p, {side.a, side.b, side.c});
        };
        const auto is_inside = [&](const PieceSide& side) {
            const Interval off =
                Interval(side.a) * (*place)[0] + Interval(side.b) * (*place)[1] + Interval(side.c);
            return off.sign() == Sign::Positive || (apex.rim && is_on_rim(side));
        };
        return std::ranges::all_of(work.boundary.sides, is_inside) &&
               std::ranges::all_of(touching, [&](const std::array<std::size_t, 2>& pair) {
                   return have_equal_gradients(family, forms[pair[0]], forms[pair[1]], p);
               });
    });
}

// Where grad f = grad g, with many digits.
std::optional<std::array<Wide, 2>> MixedAnalysis::sharp_critical_point(FormId f, FormId g,
                                                                       const Vector2d& start) const {
    const auto gradients =
        model_of<Wide>([&](const WideBox<2>& p) { return equal_gradients(heights_, f, g, p); });
    constexpr int most_steps = 20;
    const auto near = approach<Wide, 2>(gradients, {Wide(start.x()), Wide(start.y())}, everywhere,
                                        std::ldexp(extent_, assumed_exponent - 40), most_steps);
    return near ? std::optional(near->point) : std::nullopt;
}

// Every trisector is the union of two plane sections, and all these planes have a line in common. If it is
// upright, all forms are equal and have equal gradients where it stands. Otherwise, if the height of a form
// minus that of the line changes sign along it, near the apex, then all forms are equal in a point of it, and
// sections cross there transversally: the gradients agree. The first trisector has one such point in the
// piece, the apex. Over curved bases likewise, for cylinders of one radius that cross.
bool MixedAnalysis::is_tie_of_planes(const Work& work, const Apex& apex) const {
    const std::vector<Spread>& r = work.rivals;
    const HeightCurvature<Interval>& bend = *apex.differences[0][1].curvature;
    if (!(bend.xx * bend.yy - square(bend.xy)).sign()) return false;
    const auto inside = [&](const Interval& x, const Interval& y) { return work.where(x, y) == Inside::Yes; };
    if (!heights_.family().radial.empty()) {
        const std::vector<FormId> forms = work.forms();
        return std::ranges::none_of(forms, [&](FormId f) { return heights_.family().is_circular(f); }) &&
               is_tie_over_crossing(heights_.family(), forms, inside, apex.point, work.width);
    }
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
    for (double step = 0.5 * work.width; step > least_step * work.width; step *= 0.5) {
        const double s = apex.point[by_x ? 0 : 1];
        const auto before = above(s - step), after = above(s + step);
        if (before && after) return *before == -*after && *before != Sign::Zero;
    }
    return false;
}

// A convex piece shows the directions around the apex once each, in their order: when its rim has as many
// changes as the fan has arms, each arm ends in one of them.
bool MixedAnalysis::join_at_tie(Work& work) {
    if (!rule_.spares(work.forms())) return false;
    const auto apex = find_apex(work);
    if (!apex) return false;
    // Between given ones in a position that input does not favour: an arm may not be one.
    std::vector<Vector2d> corners;
    constexpr double skew = 0.29;
    if (apex->rim) {
        const auto sides = work.sides_at(*apex->rim);
        const Vector2d along(sides[1]->b, -sides[1]->a), inward(sides[1]->a, sides[1]->b);
        corners.push_back(along);
        if (sides[0] == sides[1]) corners.emplace_back(inward + skew * along);
        corners.emplace_back(-sides[0]->b, sides[0]->a);
    } else {
        corners = {{1, skew}, {-skew, 1}, {-1, -skew}, {skew, -1}, {1, skew}};
    }
    const std::vector<FormId> forms = work.forms();
    const auto fan = find_fan(forms, apex->differences, apex->between, corners);
    if (!fan) return false;
    const auto changes = apex->rim ? work.changes_after(*apex->rim) : work.changes;
    const std::vector<FanArm>& arms = fan->arms;
    const std::size_t n = arms.size();
    if (changes.size() != n) return false;
    const auto matches = [&](const Change& c, const FanArm& arm) {
        const MixedPiece::Vertex& v = work.piece.vertices[c.vertex];
        const Vector2d d = v.point - apex->point;
        const double doubt = 2 * (v.error + apex->error + apex->noise);
        const auto turn = [](const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); };
        return c.before == arm.right && c.after == arm.left && turn(arm.from, d) > doubt * arm.from.norm() &&
               turn(d, arm.to) > doubt * arm.to.norm();
    };
    std::size_t shift = 0;
    while (shift < n && !matches(changes[0], arms[shift])) ++shift;
    if (shift == n && n > 0) return false;
    for (std::size_t k = 0; k < n; ++k)
        if (!matches(changes[k], arms[(k + shift) % n])) return false;

    if (apex->rim) {
        if (work.piece.rim[*apex->rim].label != fan->first) return false;
        work.join_all_on_rim(*apex->rim);
    } else {
        work.join_all_to({apex->point, apex->error, forms[0], forms});
    }
    for (std::size_t k = 0; k < n; ++k)
        if (!divide_arm(work, work.piece.arcs[k], *apex, arms[(k + shift) % n])) {
            work.clear_inside();
            return false;
        }
    if (apex->decided)
        ++decisions_.by_exact;
    else
        assume(apex->point, std::max(apex->noise, std::ldexp(extent_, assumed_exponent / 2)), forms);
    return true;
}

// Boxes this wide, relative to their coordinates, still hold a thousand doubles.
constexpr double rounding_width = 0x1p-40;

// No direction is across the arc all over a piece that contains a point in which the gradients agree. Closer
// and closer to the apex the arc is divided into stretches in whose boxes one is.
bool MixedAnalysis::divide_arm(const Work& work, MixedPiece::Arc& arc, const Apex& apex,
                               const FanArm& arm) const {
    const Spread *f = work.find(arc.left), *g = work.find(arc.right);
    if (work.direction(*f, *g)) return true;
    const Vector2d along = arm.to - arm.from;
    const auto turn = [](const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); };
    const auto corner = [&](double t, const Vector2d& d) { return Vector2d(apex.point + t * d); };
    // The part of the sector between two lines across it.
    const auto box_between = [&](double t0, double t1) {
        std::array<double, 4> box{infinity, -infinity, infinity, -infinity};
        for (const Vector2d& p :
             {corner(t0, arm.from), corner(t0, arm.to), corner(t1, arm.from), corner(t1, arm.to)}) {
            const double doubt = apex.error + 4 * std::numeric_limits<double>::epsilon() * p.norm();
            box = {std::min(box[0], p.x() - doubt), std::max(box[1], p.x() + doubt),
                   std::min(box[2], p.y() - doubt), std::max(box[3], p.y() + doubt)};
        }
        return box;
    };
    const MixedPiece::Vertex& start = work.piece.vertices[arc.from];
    double t = turn(start.point - apex.point, along) / turn(arm.from, along) * (1 + 0x1p-20) + start.error;
    const double scale = std::max(arm.from.norm(), arm.to.norm());
    const double last = std::max(chord_width * work.extent, rounding_width * apex.point.norm()) / scale;
    std::vector<MinimizationDiagram::ArcPiece> pieces;
    while (t > last) {
        std::optional<MinimizationDiagram::ArcPiece> piece;
        double next = 0;
        for (const double ratio : {0.25, 0.5, 0.75}) {
            next = ratio * t;
            const auto box = box_between(t, next);
            const auto [gx, gy] =
                heights_.gradient_difference(arc.left, arc.right, {box[0], box[1]}, {box[2], box[3]});
            const Vector2d d = Vector2d(gx.mid(), gy.mid()).normalized();
            const Interval across = Interval(along.x()) * gx + Interval(along.y()) * gy;
            if (!d.allFinite() || !((Interval(d.x()) * gx + Interval(d.y()) * gy).lower() > 0) ||
                !(across.lower() > 0))
                continue;
            // The arc's left form is lower where the line starts.
            const auto difference = [&](const Vector2d& p) {
                const Interval x(p.x()), y(p.y());
                return heights_.value_difference(arc.left, arc.right, x, y);
            };
            double lo = 0, hi = 1;
            for (int i = 0; i < 50; ++i) {
                const double s = 0.5 * (lo + hi);
                (difference(corner(next, arm.from + s * along)).mid() < 0 ? lo : hi) = s;
            }
            const Vector2d p = corner(next, arm.from + lo * along);
            const double error =
                (Interval(difference(p).magnitude() * along.norm()) / Interval(across.lower())).upper();
            piece = {p, Interval::up(error + 4 * std::numeric_limits<double>::epsilon() * p.norm()), d, box};
            break;
        }
        if (!piece && t * scale > node_width * work.extent) return false;
        if (!piece) break;
        pieces.push_back(*piece);
        t = next;
    }
    const auto box = box_between(t, 0);
    pieces.push_back(
        {work.piece.vertices[arc.to].point, work.piece.vertices[arc.to].error, arc.direction, box});
    arc.pieces = std::move(pieces);
    return true;
}

// Two forms whose difference has a saddle's curvature all over the piece: its level set has no closed
// component, so without a change there is no arc and two changes are the ends of one. With four, let c be the
// saddle. If the difference is not zero there, its sign persists along the line through c in which it curves
// away from zero; that line joins two stretches of the rim and cuts the other two off.
bool MixedAnalysis::join_at_saddle(Work& work) {
    if (work.rivals.size() != 2 || work.width > node_width * work.extent) return false;
    if (!rule_.spares(work.forms())) return false;
    const FormId f = work.rivals[0].form, g = work.rivals[1].form;
    const Interval X(work.piece.box[0], work.piece.box[1]), Y(work.piece.box[2], work.piece.box[3]);
    const auto [xx, xy, yy] = heights_.curvature_difference(f, g, X, Y);
    if ((xx * yy - square(xy)).sign() != Sign::Negative || !work.knots.empty()) return false;
    const auto& changes = work.changes;
    if (changes.empty()) return true;
    if (work.matched_pair()) {
        work.join(changes[0], changes[1]);
        return true;
    }
    if (changes.size() != 4) return false;
    const auto saddle = root_near(equal_gradients(heights_, f, g), work.middle());
    if (!saddle) return false;
    if (work.where(saddle->point, saddle->error) != Inside::Yes) return false;

    // Which form is higher there, with as many digits as it takes.
    const auto sign_about = [&](const WideBox<2>& c) -> std::optional<Sign> {
        const HeightJet<Wide> a = heights_.jet(f, c[0], c[1]), b = heights_.jet(g, c[0], c[1]);
        const Wide value = a.v - b.v;
        const double slope = (a.gx - b.gx).enclosure().magnitude() + (a.gy - b.gy).enclosure().magnitude();
        if (!(value.enclosure().magnitude() > 4 * slope * work.width)) return std::nullopt;
        return value.sign();
    };
    auto sign = sign_about({Wide(saddle->point.x()), Wide(saddle->point.y())});
    if (!sign)
        if (const auto c = sharp_critical_point(f, g, saddle->point)) sign = sign_about(*c);
    if (!sign) return false;
    ++decisions_.by_multiprecision;
    const bool f_above = *sign == Sign::Positive;
    Eigen::Matrix2d curvature;
    curvature << xx.mid(), xy.mid(), xy.mid(), yy.mid();
    Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen;
    eigen.computeDirect(curvature);  // values ascend
    const Vector2d u = eigen.eigenvectors().col(f_above ? 1 : 0);
    const Interval ux(u.x()), uy(u.y());
    const auto bend = (square(ux) * xx + Interval(2.0) * ux * uy * xy + square(uy) * yy).sign();
    if (bend != (f_above ? Sign::Positive : Sign::Negative)) return false;
    // The higher form's stretches are cut off, one on each side of the line.
    const FormId higher = f_above ? f : g;
    const std::size_t start = changes[0].after == higher ? 0 : 1;
    std::array<int, 4> beside{};
    for (std::size_t k = 0; k < 4; ++k) {
        const MixedPiece::Vertex& v = work.piece.vertices[changes[(start + k) % 4].vertex];
        const Vector2d d = v.point - saddle->point;
        const double turn = u.x() * d.y() - u.y() * d.x();
        if (!(std::abs(turn) > 2 * (v.error + saddle->error))) return false;
        beside[k] = turn > 0 ? 1 : -1;
    }
    if (beside[0] != beside[1] || beside[2] != beside[3] || beside[0] == beside[2]) return false;
    work.join(changes[start], changes[start + 1]);
    work.join(changes[(start + 2) % 4], changes[(start + 3) % 4]);
    return true;
}

// Between two forms a third one that all but leaves the piece in its middle: around the rim it is lowest
// twice, f and g once each, and these meet in the middle if the third one's height above their trisector is
// positive there.
bool MixedAnalysis::join_at_pinch(Work& work) {
    const auto& changes = work.changes;
    if (work.rivals.size() != 3 || !work.knots.empty() || changes.size() != 4) return false;
    if (!rule_.spares(work.forms())) return false;
    // f before the first change, h before the second and the fourth, g before the third.
    std::array<Change, 4> c{changes[0], changes[1], changes[2], changes[3]};
    if (c[0].before == c[2].before) std::ranges::rotate(c, c.begin() + 1);
    const FormId f = c[0].before, h = c[1].before, g = c[2].before;
    if (c[3].before != h || f == g) return false;
    const auto pinch = find_pinch(heights_, h, f, g, work.piece.box);
    if (!pinch || work.where(pinch->place, pinch->width) != Inside::Yes) return false;
    work.clear_inside();
    MixedPiece& piece = work.piece;
    const auto add_arc = [&](std::uint32_t from, std::uint32_t to, FormId left, FormId right) {
        const bool grows = left == f || right == g;
        piece.arcs.push_back({from, to, left, right, grows ? pinch->across : Vector2d(-pinch->across), {}});
        return static_cast<std::uint32_t>(2 * (piece.arcs.size() - 1));
    };
    const auto add_vertex = [&](const MixedPiece::Vertex& v) {
        piece.vertices.push_back(v);
        piece.leaving.emplace_back();
        return static_cast<std::uint32_t>(piece.vertices.size() - 1);
    };
    const auto lead_to = [&](std::uint32_t v, const Change& from) {
        const std::uint32_t arc = add_arc(from.vertex, v, from.before, from.after);
        piece.leaving[from.vertex].push_back(arc);
        piece.leaving[v].push_back(arc + 1);
    };
    const int exponent = pinch->gap.magnitude_exponent() - pinch->height.magnitude_exponent();
    const bool is_tie = exponent < assumed_exponent;
    if (!is_tie && pinch->gap.sign() == Sign::Negative) {
        for (const auto& [from, to] : {std::pair(c[0], c[3]), std::pair(c[1], c[2])}) {
            const std::uint32_t arc = add_arc(from.vertex, to.vertex, from.before, from.after);
            piece.leaving[from.vertex].push_back(arc);
            piece.leaving[to.vertex].push_back(arc + 1);
        }
        ++decisions_.by_multiprecision;
        return true;
    }
    if (!is_tie && pinch->lens) {
        std::array<MixedPiece::Vertex, 2> ends{
            {{pinch->lens->ends[0], 0, f, {}}, {pinch->lens->ends[1], 0, f, {}}}};
        const Vector2d along(-pinch->across.y(), pinch->across.x());
        if (!settle_sharply(ends[0], {f, g, h}) || !settle_sharply(ends[1], {f, g, h})) return false;
        const double error = ends[0].error + ends[1].error;
        if (along.dot(pinch->place - ends[0].point) > 64 * error &&
            along.dot(ends[1].point - pinch->place) > 64 * error) {
            const std::uint32_t v = add_vertex(ends[0]), w = add_vertex(ends[1]), arc = add_arc(v, w, f, g);
            piece.leaving[v].push_back(arc);
            for (const int k : {0, 1}) lead_to(v, c[k]);
            piece.leaving[w].push_back(arc + 1);
            for (const int k : {2, 3}) lead_to(w, c[k]);
            ++decisions_.by_multiprecision;
            return true;
        }
    }
    const bool is_narrow =
        exponent < narrow_exponent && pinch->width <= std::ldexp(extent_, narrow_exponent / 2);
    if (!is_tie && !is_narrow) return false;
    const std::array forms{f, g, h};
    MixedPiece::Vertex node{
        pinch->place, std::max(pinch->width, std::ldexp(extent_, assumed_exponent / 2)), f, {f, g, h}};
    const auto exact = is_tie ? exact_touch(forms, forms, pinch->at, work.piece.box) : std::nullopt;
    if (exact) {
        const auto& [x, y] = *exact;
        node.point = {x.mid(), y.mid()};
        node.error = reach(x, y);
    }
    const std::uint32_t v = add_vertex(node);
    for (const Change& from : c) lead_to(v, from);
    if (!exact) assume(node.point, node.error, node.ties);
    return true;
}

// What is left of a piece counts as a point: a vertex of the rim in which all rivals meet is that point.
// Where it reaches into a cylinder's trace on the base, heights have no bound, and nothing speaks for that.
void MixedAnalysis::join_at_center(Work& work) {
    const auto& [x0, x1, y0, y1] = work.piece.box;
    for (const Spread& s : work.rivals)
        if (!std::isfinite(heights_.value(s.form, Interval(x0, x1), Interval(y0, y1)).width()))
            throw TieError({work.middle(), work.width, work.forms()});
    work.clear_inside();
    assume(work.middle(), work.width, work.forms());
    if (work.changes.empty()) return;
    const auto knot = std::ranges::find_if(work.knots, [&](std::uint32_t v) { return work.all_tie_in(v); });
    if (knot != work.knots.end())
        work.join_all_on_rim(*knot);
    else if (work.matched_pair() && work.rivals.size() == 2)
        work.join(work.changes[0], work.changes[1]);
    else
        work.join_all_to({work.middle(), Interval::up(std::hypot(work.width, work.width)),
                          work.changes[0].before, work.forms()});
}

}  // namespace vcell
