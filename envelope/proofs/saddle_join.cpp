#include "saddle_join.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "given_tie.hpp"

namespace vcell {

// Two forms whose difference has a saddle's curvature all over the piece: its level set has no closed
// component, so without a change there is no arc and two changes are the ends of one. With four, let c be the
// saddle. If the difference is not zero there, its sign persists along the line through c in which it curves
// away from zero; that line joins two stretches of the rim and cuts the other two off.
bool SaddleJoin::join_at_saddle() {
    if (work_.rivals.size() != 2 || work_.width > node_width * work_.extent) return false;
    if (!rule_.spares(work_.forms())) return false;
    const FormId f = work_.rivals[0].form, g = work_.rivals[1].form;
    const Interval X(work_.piece.box[0], work_.piece.box[1]), Y(work_.piece.box[2], work_.piece.box[3]);
    const auto [xx, xy, yy] = heights_.curvature_difference(f, g, X, Y);
    if ((xx * yy - square(xy)).sign() != Sign::Negative || !work_.knots.empty()) return false;
    const auto& changes = work_.changes;
    if (changes.empty()) return true;
    if (work_.matched_pair()) {
        work_.join(changes[0], changes[1]);
        return true;
    }
    if (changes.size() != 4) return false;
    const auto saddle = root_near(equal_gradients(heights_, f, g), work_.middle());
    if (!saddle) return false;
    if (work_.where(saddle->point, saddle->error) != Inside::Yes) return false;

    // Which form is higher there, with as many digits as it takes.
    const auto sign_about = [&](const WideBox<2>& c) -> std::optional<Sign> {
        const HeightJet<Wide> a = heights_.jet(f, c[0], c[1]), b = heights_.jet(g, c[0], c[1]);
        const Wide value = a.v - b.v;
        const double slope = (a.gx - b.gx).enclosure().magnitude() + (a.gy - b.gy).enclosure().magnitude();
        if (!(value.enclosure().magnitude() > 4 * slope * work_.width)) return std::nullopt;
        return value.sign();
    };
    auto sign = sign_about({Wide(saddle->point.x()), Wide(saddle->point.y())});
    if (!sign)
        if (const auto c = points_.sharp_critical_point(f, g, saddle->point)) sign = sign_about(*c);
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
        const MixedPiece::Vertex& v = work_.piece.vertices[changes[(start + k) % 4].vertex];
        const Vector2d d = v.point - saddle->point;
        const double turn = u.x() * d.y() - u.y() * d.x();
        if (!(std::abs(turn) > 2 * (v.error + saddle->error))) return false;
        beside[k] = turn > 0 ? 1 : -1;
    }
    if (beside[0] != beside[1] || beside[2] != beside[3] || beside[0] == beside[2]) return false;
    work_.join(changes[start], changes[start + 1]);
    work_.join(changes[(start + 2) % 4], changes[(start + 3) % 4]);
    return true;
}

// Between two forms a third one that all but leaves the piece in its middle: around the rim it is lowest
// twice, f and g once each, and these meet in the middle if the third one's height above their trisector is
// positive there.
bool SaddleJoin::join_at_pinch() {
    const auto& changes = work_.changes;
    if (work_.rivals.size() != 3 || !work_.knots.empty() || changes.size() != 4) return false;
    if (!rule_.spares(work_.forms())) return false;
    // f before the first change, h before the second and the fourth, g before the third.
    std::array<RimChange, 4> c{changes[0], changes[1], changes[2], changes[3]};
    if (c[0].before == c[2].before) std::ranges::rotate(c, c.begin() + 1);
    const FormId f = c[0].before, h = c[1].before, g = c[2].before;
    if (c[3].before != h || f == g) return false;
    const auto pinch = find_pinch(heights_, h, f, g, work_.piece.box);
    if (!pinch || work_.where(pinch->place, pinch->width) != Inside::Yes) return false;
    work_.clear_inside();
    MixedPiece& piece = work_.piece;
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
    const auto lead_to = [&](std::uint32_t v, const RimChange& from) {
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
        if (!points_.settle_sharply(ends[0], {f, g, h}) || !points_.settle_sharply(ends[1], {f, g, h}))
            return false;
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
    const auto exact = is_tie ? points_.exact_touch(forms, forms, pinch->at, work_.piece.box) : std::nullopt;
    if (exact) {
        const auto& [x, y] = *exact;
        node.point = {x.mid(), y.mid()};
        node.error = reach(x, y);
    }
    const std::uint32_t v = add_vertex(node);
    for (const RimChange& from : c) lead_to(v, from);
    if (!exact && !GivenTie(all_, work_, {node.point, node.error, node.ties, {}, {forms}}).is_exact())
        all_.assume(node.point, node.error, node.ties);
    return true;
}

}  // namespace vcell
