#include "mixed_piece.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "../../core/errors.hpp"
#include "../../core/solver/newton/newton.hpp"
#include "../../primitives/bisectors/height_conics.hpp"
#include "crossing_tie.hpp"
#include "mixed_terms.hpp"
#include "space_tie.hpp"
#include "touching.hpp"

namespace vcell {

namespace {

using Eigen::Vector2d;

// Below this exponent a third form lowest by less between two others counts as touching their trisector.
constexpr int narrow_exponent = -40;

}  // namespace

MixedAnalysis::MixedAnalysis(const FormFamily& family, double extent) : heights_(family), extent_(extent) {
    if (!family.radial.empty() && family.chart == RadialChart::Stereographic) supports_.emplace(family);
}

bool MixedAnalysis::is_spent() const {
    // Measured: 80 evaluations and some hundred stretches to a form are usual; a few thousand evaluations in
    // all where a tie of some ten forms is settled, 150,000 stretches along a line that hardly leaves a
    // plane.
    constexpr std::size_t most_wide = 10000, wide_of_form = 500, most_stretches = 150000,
                          stretches_of_form = 5000;
    const std::size_t forms = heights_.family().size();
    return heights_.wide_evaluations() > most_wide + wide_of_form * forms ||
           stretches_ > most_stretches + stretches_of_form * forms;
}

// A point of the rim may be met from its side and from inside: it is listed once.
void MixedAnalysis::assume(const Vector2d& place, double width, std::vector<FormId> forms) {
    std::ranges::sort(forms);
    for (Assumption& known : assumptions_) {
        const double same = known.width + width + 4 * std::numeric_limits<double>::epsilon() * place.norm();
        if (known.forms != forms || (known.place - place).norm() > same) continue;
        known.width = std::max(known.width, width);
        return;
    }
    ++decisions_.assumed;
    assumptions_.push_back({place, width, std::move(forms)});
}

void MixedAnalysis::bend(const std::array<double, 4>& box, std::vector<Spread>& rivals) const {
    const Interval X(box[0], box[1]), Y(box[2], box[3]), mx(X.mid()), my(Y.mid());
    for (Spread& s : rivals)
        s.bend = {heights_.jet(s.form, mx, my), heights_.curvature(s.form, X, Y), X - mx, Y - my};
}

std::vector<MixedAnalysis::Spread> MixedAnalysis::lowest_spreads(const std::array<double, 4>& box,
                                                                 std::span<const FormId> candidates) const {
    const Interval X(box[0], box[1]), Y(box[2], box[3]), mx(X.mid()), my(Y.mid());
    const double rx = X.radius(), ry = Y.radius();
    std::vector<Spread> spreads;
    for (const FormId f : candidates) {
        const HeightJet<Interval> all = heights_.jet(f, X, Y);
        spreads.push_back({f, {}, heights_.value(f, mx, my), all.gx, all.gy, all.v, {}});
    }
    const auto certainly_above = [&](const Spread& a, const Spread& b) {
        return a.range.lower() > b.range.upper() || (a.v - b.v - (a.gx - b.gx).magnitude() * Interval(rx) -
                                                     (a.gy - b.gy).magnitude() * Interval(ry))
                                                            .lower() > 0;
    };
    const auto top = [&](const Spread& s) {
        return std::min(s.range.upper(), s.v.upper() + s.gx.magnitude() * rx + s.gy.magnitude() * ry);
    };
    drop_above_best(spreads, top, certainly_above);
    if (heights_.family().tips.any() && spreads.size() > 1) {
        // Beside a tip all that do not grow there are nearly zero.
        std::vector<Spread> plain;
        for (const Spread& s : spreads) {
            const HeightJet<Interval> all = heights_.plain_jet(s.form, X, Y);
            plain.push_back({s.form, {}, heights_.plain_jet(s.form, mx, my).v, all.gx, all.gy, all.v, {}});
        }
        drop_above_best(plain, top, certainly_above);
        auto kept = plain.begin();  // in the same order
        std::erase_if(spreads, [&](const Spread& s) {
            const bool is_kept = kept != plain.end() && kept->form == s.form;
            if (is_kept) ++kept;
            return !is_kept;
        });
    }
    return spreads;
}

SmallVector<MixedAnalysis::Rival, MixedAnalysis::usual_rivals> MixedAnalysis::lowest_supports(
    const NormalBox& box, std::span<const FormId> candidates) const {
    SmallVector<Rival, usual_rivals> rivals;
    Support best;
    double nearest = -infinity;
    for (const FormId f : candidates) {
        const Support s = supports_->over(f, box);
        if (const double q = box.middle(s); q > nearest) {
            nearest = q;
            best = s;
        }
        rivals.push_back({f, s});
    }
    rivals.erase(std::remove_if(rivals.begin(), rivals.end(),
                                [&](const Rival& r) { return box.is_above(r.support, best); }),
                 rivals.end());
    if (rivals.size() > 2 && rivals.size() <= most_compared_in_pairs)
        drop_dominated(rivals, [&](const Rival& a, const Rival& b) {
            return box.middle(a.support) < box.middle(b.support) && box.is_above(a.support, b.support);
        });
    return rivals;
}

std::vector<FormId> MixedAnalysis::cull(const std::array<double, 4>& box,
                                        std::span<const FormId> candidates) {
    normals_.reset();
    if (compare_by_supports(std::max(box[1] - box[0], box[3] - box[2]),
                            extent_at({box[0], box[1]}, {box[2], box[3]}))) {
        normals_.emplace(box[0], box[1], box[2], box[3]);
        spreads_.clear();
        for (const Rival& r : lowest_supports(*normals_, candidates)) {
            Spread& s = append_new(spreads_);
            s.form = r.form;
            s.support = r.support;
        }
    } else {
        spreads_ = lowest_spreads(box, candidates);
    }
    decisions_.by_interval += candidates.size() - 1;
    std::vector<FormId> kept;
    kept.reserve(spreads_.size());
    for (const Spread& s : spreads_) kept.push_back(s.form);
    return kept;
}

std::optional<double> MixedAnalysis::steepness_across(double along_x, double along_y) const {
    if (normals_) return std::nullopt;  // supports bound no gradients of forms alone
    double x = 0, y = 0;
    for (std::size_t i = 0; i < spreads_.size(); ++i)
        for (std::size_t j = 0; j < std::min(i, most_compared_in_pairs); ++j) {
            x += (spreads_[i].gx - spreads_[j].gx).magnitude() * along_x;
            y += (spreads_[i].gy - spreads_[j].gy).magnitude() * along_y;
        }
    return x + y > 0 && std::isfinite(x + y) ? std::optional(x / y) : std::nullopt;
}

// Pieces with more rivals are rarely plain, and their parts take longer than halves of them.
constexpr std::size_t most_divided = 4;

std::optional<bool> MixedAnalysis::asks_for_strips(const std::array<double, 4>& box) const {
    constexpr double strip_ratio = 8;
    if (spreads_.size() < 3 || spreads_.size() > most_divided) return std::nullopt;
    double x = 0, y = 0;
    for (std::size_t i = 0; i < spreads_.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) {
            const auto [gx, gy] = heights_.plain_gradient_difference(spreads_[i].form, spreads_[j].form,
                                                                     {box[0], box[1]}, {box[2], box[3]});
            x += gx.magnitude() * (box[1] - box[0]);
            y += gy.magnitude() * (box[3] - box[2]);
        }
    if (!std::isfinite(x + y)) return std::nullopt;
    return x > strip_ratio * y   ? std::optional(true)
           : y > strip_ratio * x ? std::optional(false)
                                 : std::nullopt;
}

// --- Roots of two equations
// ---------------------------------------------------------------------------------

namespace {

template <class T, class Linearise>
auto model(Linearise linearise) {
    return LinearisedModel<T, 2, Linearise>(std::move(linearise));
}

const IntervalBox<2> everywhere{Interval::whole(), Interval::whole()};

struct Root {
    Vector2d point;
    double error;
};

Root about(const IntervalBox<2>& box) { return {{box[0].mid(), box[1].mid()}, reach(box[0], box[1])}; }

template <class Model>
std::optional<Root> root_near(const Model& model, const Vector2d& start) {
    const auto box = prove_near<Interval, 2>(model, {Interval(start.x()), Interval(start.y())}, everywhere);
    return box ? std::optional(about(*box)) : std::nullopt;
}

// a = b = c.
template <class T>
LocalModel<T, 2> equal_heights(const Heights& heights, const std::array<FormId, 3>& forms,
                               const std::array<T, 2>& p) {
    const HeightJet<T> a = heights.jet(forms[0], p[0], p[1]), b = heights.jet(forms[1], p[0], p[1]),
                       c = heights.jet(forms[2], p[0], p[1]);
    return {{a.v - b.v, a.v - c.v}, {{{a.gx - b.gx, a.gy - b.gy}, {a.gx - c.gx, a.gy - c.gy}}}};
}

// The same in doubles; over a point derivatives are rounded only.
LocalModel<Interval, 2> equal_heights(const SphereSupports& supports, const std::array<FormId, 3>& forms,
                                      const IntervalBox<2>& p) {
    LocalModel<Interval, 2> s;
    if (is_point(p[0]) && is_point(p[1])) {
        const PointNormal n(p[0].mid(), p[1].mid());
        const auto a = supports.jet(forms[0], n);
        for (const int i : {0, 1}) {
            const auto b = supports.jet(forms[i + 1], n);
            s.value[i] = Interval::ball(a[0] - b[0],
                                        supports.value_error(forms[0]) + supports.value_error(forms[i + 1]));
            s.jacobian[i] = {Interval(a[1] - b[1]), Interval(a[2] - b[2])};
        }
        return s;
    }
    s.value.fill(Interval::whole());
    const NormalBox box(p[0].lower(), p[0].upper(), p[1].lower(), p[1].upper());
    const Support a = supports.over(forms[0], box);
    for (const int i : {0, 1}) s.jacobian[i] = box.gradient(a, supports.over(forms[i + 1], box));
    return s;
}

// grad f = grad g.
LocalModel<Interval, 2> equal_gradients(const Heights& heights, FormId f, FormId g, const IntervalBox<2>& p) {
    const HeightJet<Interval> a = heights.jet(f, p[0], p[1]), b = heights.jet(g, p[0], p[1]);
    const HeightCurvature<Interval> c = heights.curvature(f, p[0], p[1]),
                                    d = heights.curvature(g, p[0], p[1]);
    return {{a.gx - b.gx, a.gy - b.gy}, {{{c.xx - d.xx, c.xy - d.xy}, {c.xy - d.xy, c.yy - d.yy}}}};
}

// The same with many digits, and derivatives in doubles: to approach a root, not to prove it.
LocalModel<Wide, 2> equal_gradients(const Heights& heights, FormId f, FormId g, const WideBox<2>& p) {
    const HeightJet<Wide> a = heights.jet(f, p[0], p[1]), b = heights.jet(g, p[0], p[1]);
    const auto rough = equal_gradients(
        heights, f, g, IntervalBox<2>{Interval(p[0].approximation()), Interval(p[1].approximation())});
    LocalModel<Wide, 2> local{{a.gx - b.gx, a.gy - b.gy}, {}};
    for (const int r : {0, 1})
        for (const int c : {0, 1}) local.jacobian[r][c] = Wide(rough.jacobian[r][c].mid());
    return local;
}

auto equal_gradients(const Heights& heights, FormId f, FormId g) {
    return model<Interval>(
        [&heights, f, g](const IntervalBox<2>& p) { return equal_gradients(heights, f, g, p); });
}

}  // namespace

// --- Inside a piece ----------------------------------------------------------------------------------------

// A change of label, where a trisector leaves the rim: inward `before` lies on its left.
struct MixedAnalysis::Change {
    std::uint32_t vertex;
    FormId before, after;
};

// A vertex of the rim in which more forms meet than change there, and those that are lowest around it inside
// the piece, counter-clockwise from the label of the side that leaves to that of the one that arrives.
struct MixedAnalysis::Knot {
    std::uint32_t vertex;
    std::vector<FormId> ties, around;
};

struct MixedAnalysis::Work {
    const PieceBoundary& boundary;
    const NormalBox* normals;  // these two are null unless rivals compare by supports
    const SphereSupports* supports;
    const Heights& heights;
    Decisions& decisions;
    std::optional<DividedBox>& parts;  // an earlier piece's until this one is divided
    mutable bool is_divided;
    mutable std::vector<FormId> parted;  // their forms
    struct Direction {
        FormId a, b;
        std::optional<Vector2d> d;
    };
    mutable SmallVector<Direction, 6> directions;  // as found for the rivals as they are
    MixedPiece piece;
    std::vector<Spread>& rivals;  // as the last cull() left them, fewer as more is known
    SmallVector<Change, 8> changes;
    std::vector<std::array<FormId, 3>> triples;  // of the inner vertices
    std::vector<std::uint32_t> knots;  // vertices of the rim in which more forms meet than change there
    double width = 0, extent = 0;
    bool is_small = false;                             // in one direction at least
    mutable std::vector<std::array<FormId, 3>> apart;  // known to tie nowhere, in the order of the rivals

    Vector2d middle() const {
        return {Interval(piece.box[0], piece.box[1]).mid(), Interval(piece.box[2], piece.box[3]).mid()};
    }
    std::vector<FormId> forms() const {
        std::vector<FormId> all;
        all.reserve(rivals.size());
        for (const Spread& s : rivals) all.push_back(s.form);
        return all;
    }
    Inside where(const Interval& x, const Interval& y) const {
        bool inside = true;
        for (const PieceSide& side : boundary.sides) {
            const auto sign = (Interval(side.a) * x + Interval(side.b) * y + Interval(side.c)).sign();
            if (sign == Sign::Negative) return Inside::No;
            inside = inside && sign == Sign::Positive;
        }
        return inside ? Inside::Yes : Inside::Unknown;
    }
    // Of a disk.
    Inside where(const Vector2d& p, double radius) const {
        return where(Interval::ball(p.x(), radius), Interval::ball(p.y(), radius));
    }
    // The sides that arrive at and leave a vertex of the rim.
    std::array<const PieceSide*, 2> sides_at(std::uint32_t v) const {
        const auto side = [&](std::size_t edge) {
            return &*std::ranges::find(boundary.sides, piece.rim[edge].side, &PieceSide::id);
        };
        return {side((v + piece.rim.size() - 1) % piece.rim.size()), side(v)};
    }
    void clear_inside() {
        piece.arcs.clear();
        piece.vertices.resize(piece.rim.size());
        piece.leaving.assign(piece.rim.size(), {});
    }
    const Spread* find(FormId f) const {
        const auto it = std::ranges::find(rivals, f, &Spread::form);
        return it == rivals.end() ? nullptr : &*it;
    }
    // The gradient of a - b all over the piece. Where the two are nearly the same function its mean value
    // form is by far the sharper one.
    std::array<Interval, 2> gradient(const Spread& a, const Spread& b) const {
        const auto over =
            normals ? normals->gradient(a.support, b.support) : std::array{a.gx - b.gx, a.gy - b.gy};
        if (!a.bend || !b.bend) return over;
        const auto &p = *a.bend, &q = *b.bend;
        return refined_gradient(over, {p.middle.gx - q.middle.gx, p.middle.gy - q.middle.gy},
                                p.curvature - q.curvature, p.dx, p.dy);
    }
    // The same of heights that are not multiplied by the distances from tips: near one the product of those
    // that do not grow there is nearly zero, and changes little but with the distance.
    std::array<Interval, 2> plain_gradient(const Spread& a, const Spread& b) const {
        const auto& box = piece.box;
        return heights.plain_gradient_difference(a.form, b.form, {box[0], box[1]}, {box[2], box[3]});
    }
    // A unit vector in which a - b certainly grows all over the piece; over a sphere at least wherever a = b
    // are lowest.
    std::optional<Vector2d> direction(const Spread& a, const Spread& b) const {
        for (const Direction& known : directions) {
            if (known.a == a.form && known.b == b.form) return known.d;
            if (known.a == b.form && known.b == a.form)
                return known.d ? std::optional<Vector2d>(-*known.d) : known.d;
        }
        directions.push_back({a.form, b.form, find_direction(a, b)});
        return directions.back().d;
    }
    std::optional<Vector2d> find_direction(const Spread& a, const Spread& b) const {
        using Gradient = std::array<Interval, 2>;
        // Beside a tip pieces are as narrow along the axis as they are near to it: where they are squares, so
        // to speak.
        const auto& box = piece.box;
        const bool has_tips = heights.family().tips.any();
        const double aspect = has_tips ? (box[3] - box[2]) / (box[1] - box[0]) : 1;
        const auto along = [&](const Gradient& g) {
            return Vector2d(g[0].mid(), aspect * aspect * g[1].mid()).normalized();
        };
        const auto grows = [](const Gradient& g, const Vector2d& d) {
            return d.allFinite() && (Interval(d.x()) * g[0] + Interval(d.y()) * g[1]).lower() > 0;
        };
        const Gradient g = gradient(a, b);
        const Vector2d d = along(g);
        if (grows(g, d)) return d;
        if (has_tips) {
            const Gradient plain = plain_gradient(a, b);
            if (grows(plain, along(plain))) return along(plain);
        }
        if (!supports || rivals.size() > most_divided) return std::nullopt;
        const Vector2d across = across_ends(a.form, b.form).value_or(d);
        if (!across.allFinite() || falls_on_rim(a.form, b.form, across)) return std::nullopt;
        if (!divided().grows_along(place(a), place(b), across)) return std::nullopt;
        return across;
    }
    // Does every line in this direction of theirs meet a = b at most once?
    bool crosses_once(const Spread& a, const Spread& b, const Vector2d& direction) const {
        return !is_divided || rivals.size() == 2 || parts->grows_throughout(place(a), place(b), direction);
    }
    // Does a - b seem to fall where the two change on the rim? A cheap no to what would have to be proved.
    bool falls_on_rim(FormId a, FormId b, const Vector2d& direction) const {
        return std::ranges::any_of(changes, [&](const Change& c) {
            if (!(c.before == a && c.after == b) && !(c.before == b && c.after == a)) return false;
            const PointNormal n(piece.vertices[c.vertex].point.x(), piece.vertices[c.vertex].point.y());
            const auto f = supports->jet(a, n), g = supports->jet(b, n);
            return direction.x() * (f[1] - g[1]) + direction.y() * (f[2] - g[2]) < 0;
        });
    }
    std::size_t place(const Spread& s) const { return static_cast<std::size_t>(&s - rivals.data()); }
    const DividedBox& divided() const {
        if (!is_divided) {
            parted = forms();
            if (parts)
                parts->start(piece.box, parted);
            else
                parts.emplace(*supports, piece.box, parted);
            is_divided = true;
        }
        return *parts;
    }
    // Right-hand of the chord between the places where two forms, and no others, change on the rim.
    std::optional<Vector2d> across_ends(FormId left, FormId right) const {
        std::optional<Vector2d> start, end;
        for (const Change& c : changes) {
            const bool starts = c.before == left && c.after == right;
            if (!starts && !(c.before == right && c.after == left)) continue;
            std::optional<Vector2d>& p = starts ? start : end;
            if (p) return std::nullopt;
            p = piece.vertices[c.vertex].point;
        }
        if (!start || !end) return std::nullopt;
        const Vector2d chord = *end - *start;
        return Vector2d(chord.y(), -chord.x()).normalized();
    }
    // The turn from grad a over grad b to grad c, over a sphere at least in a box that holds all points where
    // a = b = c are lowest; Zero if there are no such points. The three in one order always, as another one
    // need not tell.
    std::optional<Sign> turn(const Spread& a, const Spread& b, const Spread& c) const {
        const auto reversed = [](std::optional<Sign> s) { return s ? std::optional(-*s) : s; };
        if (b.form < a.form) return reversed(turn(b, a, c));
        if (c.form < b.form) return reversed(turn(a, c, b));
        const auto orientation = [](const std::array<Interval, 2>& p, const std::array<Interval, 2>& q) {
            const auto sign = (p[0] * q[1] - p[1] * q[0]).sign();
            return sign == Sign::Zero ? std::nullopt : sign;
        };
        if (const auto sign = orientation(gradient(b, a), gradient(c, a))) return sign;
        if (are_apart(a, b, c)) return Sign::Zero;
        if (heights.family().tips.any()) return orientation(plain_gradient(b, a), plain_gradient(c, a));
        if (!supports || rivals.size() > most_divided) return std::nullopt;
        const auto sign = divided().turn(place(a), place(b), place(c));
        return sign == Sign::Zero ? std::nullopt : sign;
    }
    // Of forms in a point where all are equal: the one after `p` on the convex hull of their gradients,
    // counter-clockwise. None if p is not on it.
    template <class Spreads>
    const Spread* next_on_hull(const Spreads& tied, const Spread& p) const {
        const auto follows = [&](const Spread* q) {
            return q != &p && std::ranges::all_of(tied, [&](const Spread* o) {
                       return o == &p || o == q || turn(p, *q, *o) == Sign::Positive;
                   });
        };
        const auto next = std::ranges::find_if(tied, follows);
        return next == tied.end() ? nullptr : *next;
    }
    // Is a combination of b - a and c - a nowhere zero? Then the three are nowhere equal. Of all combinations
    // the one that changes least about the middle: nearly nothing to first order where trisectors run beside
    // each other.
    bool are_apart(const Spread& a, const Spread& b, const Spread& c) const {
        struct Difference {
            Interval v, gx, gy;
            HeightCurvature<Interval> curvature{};

            double dot(const Difference& o) const { return gx.mid() * o.gx.mid() + gy.mid() * o.gy.mid(); }
        };
        const bool bends = a.bend && b.bend && c.bend;
        if (normals && !bends) return false;
        const auto from_a = [&](const Spread& s) -> Difference {
            if (!bends) return {s.v - a.v, s.gx - a.gx, s.gy - a.gy};
            const auto &p = s.bend->middle, &q = a.bend->middle;
            return {p.v - q.v, p.gx - q.gx, p.gy - q.gy, s.bend->curvature - a.bend->curvature};
        };
        Difference p = from_a(b), q = from_a(c);
        if (p.dot(p) < q.dot(q)) std::swap(p, q);
        const Interval k(p.dot(q) / p.dot(p));
        const Vector2d m = middle();
        const Interval dx = Interval(piece.box[0], piece.box[1]) - Interval(m.x()),
                       dy = Interval(piece.box[2], piece.box[3]) - Interval(m.y());
        Interval rest = q.v - k * p.v + (q.gx - k * p.gx) * dx + (q.gy - k * p.gy) * dy;
        if (bends)
            rest = rest + 0.5 * ((q.curvature.xx - k * p.curvature.xx) * square(dx) +
                                 2.0 * ((q.curvature.xy - k * p.curvature.xy) * dx * dy) +
                                 (q.curvature.yy - k * p.curvature.yy) * square(dy));
        return rest.lower() > 0 || rest.upper() < 0;
    }
    // Do the three certainly tie nowhere in the piece? Where gradients are on one line all along a trisector,
    // as of tubes that are nearly parallel over a tube, their turn never tells. Asked of few and in a small
    // piece, when the other questions have failed.
    bool is_apart(const Spread& a, const Spread& b, const Spread& c) const {
        if (!a.bend || !is_small || rivals.size() > most_divided || heights.family().radial.empty() ||
            heights.family().chart != RadialChart::HalfAngle)
            return false;
        if (known_apart({a.form, b.form, c.form})) return true;
        const auto meet_nowhere_of = [&](const Spread& h, const Spread& f, const Spread& g) {
            return meet_nowhere(heights, h.form, f.form, g.form, piece.box, decisions);
        };
        if (!meet_nowhere_of(a, b, c) && !meet_nowhere_of(b, a, c) && !meet_nowhere_of(c, a, b)) return false;
        apart.push_back({a.form, b.form, c.form});
        return true;
    }
    bool known_apart(const std::array<FormId, 3>& forms) const {
        return std::ranges::find(apart, forms) != apart.end();
    }
    bool matched_pair() const {
        return changes.size() == 2 && changes[0].before == changes[1].after &&
               changes[0].after == changes[1].before;
    }
    // Returns the arc's half-edge at its start; its twin's number is one more.
    std::uint32_t add_arc(std::uint32_t from, std::uint32_t to, FormId left, FormId right) {
        const Vector2d chord = piece.vertices[to].point - piece.vertices[from].point;
        Vector2d across = Vector2d(chord.y(), -chord.x()).normalized();  // left - right grows to the right
        const Spread *a = find(left), *b = find(right);
        if (a && b)
            if (const auto d = direction(*a, *b)) across = *d;
        piece.arcs.push_back({from, to, left, right, across, {}});
        return static_cast<std::uint32_t>(2 * (piece.arcs.size() - 1));
    }
    // Puts a vertex on the arc of two forms, if they have one arc.
    bool divide(FormId f, FormId g, const MixedPiece::Vertex& vertex) {
        const auto is_theirs = [&](const MixedPiece::Arc& a) {
            return (a.left == f && a.right == g) || (a.left == g && a.right == f);
        };
        const auto first = std::ranges::find_if(piece.arcs, is_theirs);
        if (first == piece.arcs.end() ||
            std::find_if(first + 1, piece.arcs.end(), is_theirs) != piece.arcs.end())
            return false;
        const auto near = static_cast<std::uint32_t>(first - piece.arcs.begin()),
                   far = static_cast<std::uint32_t>(piece.arcs.size()),
                   v = static_cast<std::uint32_t>(piece.vertices.size());
        MixedPiece::Arc rest = *first;
        rest.from = v;
        first->to = v;
        std::ranges::replace(piece.leaving[rest.to], 2 * near + 1, 2 * far + 1);
        piece.arcs.push_back(std::move(rest));
        piece.vertices.push_back(vertex);
        piece.leaving.push_back({2 * near + 1, 2 * far});
        return true;
    }
    // Puts a face of h on the arc of two forms, if they have one arc, between two vertices: given in the
    // arc's order where f is on its left.
    bool insert_lens(FormId h, FormId f, FormId g, std::array<MixedPiece::Vertex, 2> ends,
                     const Vector2d& across) {
        if (!divide(f, g, ends[0])) return false;
        const auto far = static_cast<std::uint32_t>(piece.arcs.size() - 1),
                   near = static_cast<std::uint32_t>(
                       std::ranges::find(piece.arcs, piece.arcs[far].from, &MixedPiece::Arc::to) -
                       piece.arcs.begin());
        auto v = static_cast<std::uint32_t>(piece.vertices.size() - 1), w = v + 1;
        const bool is_reversed = piece.arcs[far].left != f;
        if (is_reversed) piece.vertices.back() = ends[1];
        piece.vertices.push_back(ends[is_reversed ? 0 : 1]);
        piece.arcs[far].from = w;
        const FormId left = piece.arcs[far].left, right = piece.arcs[far].right;
        const Vector2d along = is_reversed ? Vector2d(-across) : across;
        const std::uint32_t upper = far + 1, lower = far + 2;
        piece.arcs.push_back({v, w, left, h, along, {}});
        piece.arcs.push_back({v, w, h, right, along, {}});
        piece.leaving[v] = {2 * near + 1, 2 * lower, 2 * upper};
        piece.leaving.push_back({2 * far, 2 * upper + 1, 2 * lower + 1});
        return true;
    }
    // Between two places on the rim.
    void join(const Change& from, const Change& to) {
        const std::uint32_t h = add_arc(from.vertex, to.vertex, from.before, from.after);
        piece.leaving[from.vertex].push_back(h);
        piece.leaving[to.vertex].push_back(h + 1);
    }
    // The changes counter-clockwise from a vertex of the rim on, without its own.
    SmallVector<Change, 8> changes_after(std::uint32_t v) const {
        SmallVector<Change, 8> all;
        for (const Change& c : changes)
            if (c.vertex > v) all.push_back(c);
        for (const Change& c : changes)
            if (c.vertex < v) all.push_back(c);
        return all;
    }
    // Do all rivals meet in a vertex of the rim?
    bool all_tie_in(std::uint32_t v) const {
        const std::vector<FormId>& ties = piece.vertices[v].ties;
        return std::ranges::all_of(
            rivals, [&](const Spread& s) { return std::ranges::find(ties, s.form) != ties.end(); });
    }
    // From all other changes to a vertex of the rim.
    void join_all_on_rim(std::uint32_t v) {
        for (const Change& c : changes_after(v)) join(c, {v, c.after, c.before});
    }
    // From every change to one inner vertex.
    void join_all_to(const MixedPiece::Vertex& center) {
        const auto v = static_cast<std::uint32_t>(piece.vertices.size());
        piece.vertices.push_back(center);
        piece.leaving.emplace_back();
        for (const Change& c : changes) {
            const std::uint32_t h = add_arc(c.vertex, v, c.before, c.after);
            piece.leaving[c.vertex].push_back(h);
            piece.leaving[v].push_back(h + 1);
        }
    }
};

std::optional<MixedPiece> MixedAnalysis::resolve(const PieceBoundary& boundary) {
    Work work{boundary,
              normals_ ? &*normals_ : nullptr,
              normals_ ? &*supports_ : nullptr,
              heights_,
              decisions_,
              parts_,
              false,
              {},
              {},
              {},
              spreads_,
              {},
              {},
              {},
              0,
              0,
              false,
              {}};
    double x0 = infinity, x1 = -infinity, y0 = infinity, y1 = -infinity;
    for (const IntervalPoint& c : boundary.corners) {
        x0 = std::min(x0, c[0].lower());
        x1 = std::max(x1, c[0].upper());
        y0 = std::min(y0, c[1].lower());
        y1 = std::max(y1, c[1].upper());
    }
    work.piece.box = {x0, x1, y0, y1};
    work.width = std::max(x1 - x0, y1 - y0);
    work.extent = extent_at({x0, x1}, {y0, y1});
    work.is_small = std::min(x1 - x0, y1 - y0) <= tie_width * work.extent;

    MixedPiece& piece = work.piece;
    const std::size_t sides = boundary.sides.size();
    std::size_t rim = sides;
    for (const SideLabels& l : boundary.labels) rim += l.transitions.size();
    piece.vertices.reserve(rim + 1);
    piece.leaving.reserve(rim + 1);
    piece.rim.reserve(rim);
    work.changes.reserve(rim);
    const auto add_rim = [&](const Vector2d& p, double error, FormId before, FormId after,
                             std::span<const FormId> ties) {
        const auto v = static_cast<std::uint32_t>(piece.vertices.size());
        piece.vertices.push_back({p, error, after, {ties.begin(), ties.end()}});
        if (ties.size() > (before == after ? 1 : 2)) work.knots.push_back(v);
        if (before != after) work.changes.push_back({v, before, after});
    };
    for (std::size_t i = 0; i < sides; ++i) {
        const SideLabels& labels = boundary.labels[i];
        const IntervalPoint& c = boundary.corners[i];
        const FormId before = boundary.labels[(i + sides - 1) % sides].last();
        if (before != labels.first && boundary.corner_ties[i].size() < 2)
            throw InternalError("labels differ around a corner of a piece");
        add_rim({c[0].mid(), c[1].mid()}, reach(c[0], c[1]), before, labels.first, boundary.corner_ties[i]);
        piece.rim.push_back({boundary.sides[i].id, labels.first});
        for (const RimTransition& t : labels.transitions) {
            add_rim(t.point, t.error, t.before, t.after, t.ties);
            piece.rim.push_back({boundary.sides[i].id, t.after});
        }
    }
    piece.leaving.resize(piece.vertices.size());

    const bool at_floor = work.width <= floor_width * work.extent;
    bool plain = is_plain(work);
    if (!plain) {
        // The difference of a circular form and one other is in mean value form already.
        const auto is_curved = [&](const Spread& s) { return !heights_.family().is_circular(s.form); };
        const bool bends = !normals_ || std::ranges::count_if(work.rivals, is_curved) > 1;
        if (bends) {
            bend(work.piece.box, work.rivals);
            work.directions.clear();
            cull_by_curvature(work);
        }
        if (work.width < sharp_width * work.extent) cull_sharply(work);
        plain = bends && is_plain(work);
    }
    const bool near_tie =
        !plain && work.rivals.size() > 1 && work.width <= tie_width * tie_extent_at({x0, x1}, {y0, y1});
    if (!plain && !near_tie && !at_floor) return std::nullopt;
    ++decisions_.by_interval;

    const std::size_t assumed_before = assumptions_.size();
    const bool joined =
        (plain && join_changes(work)) || (near_tie && (join_at_tie(work) || join_at_saddle(work) ||
                                                       join_at_pinch(work) || join_without_touching(work)));
    if (!joined) {
        // What was assumed on the way will be asked again.
        decisions_.assumed -= assumptions_.size() - assumed_before;
        assumptions_.erase(assumptions_.begin() + static_cast<std::ptrdiff_t>(assumed_before),
                           assumptions_.end());
        if (!at_floor) return std::nullopt;
        join_at_center(work);
    }
    return std::move(work.piece);
}

// Without the forms that are lowest nowhere in the piece but for touching the trisector of two others in a
// vertex, or in a lens on it.
bool MixedAnalysis::join_without_touching(Work& work) {
    struct Touch {
        MixedPiece::Vertex vertex;
        FormId f, g;
        bool decided;
    };
    struct Lens {
        std::array<MixedPiece::Vertex, 2> ends;
        FormId h, f, g;
        Vector2d across;
        Interval x, y;  // around its face
    };
    std::vector<Lens> lenses;
    work.clear_inside();
    if (work.rivals.size() < 3 || !work.knots.empty()) return false;
    const auto is_on_rim = [&](FormId f) {
        return std::ranges::find(work.piece.rim, f, &MixedPiece::RimEdge::label) != work.piece.rim.end();
    };
    std::vector<Touch> touches;
    // An arc that is touched inside meets the rim, or it does in a smaller piece: of all pairs those are
    // enough that change there.
    std::vector<std::array<FormId, 2>> pairs;
    for (const Change& c : work.changes) {
        const std::array pair{std::min(c.before, c.after), std::max(c.before, c.after)};
        if (std::ranges::find(pairs, pair) == pairs.end()) pairs.push_back(pair);
    }
    const auto stays_above = [&](FormId h) {
        for (const auto& [f, g] : pairs) {
            const auto touching = find_touching(heights_, h, f, g, work.piece.box);
            if (!touching) continue;
            const int exponent = touching->gap.magnitude_exponent() - touching->height.magnitude_exponent();
            const bool is_tie = exponent < assumed_exponent,
                       is_above = touching->gap.sign() == Sign::Positive;
            const bool is_narrow =
                exponent < narrow_exponent && touching->width <= std::ldexp(extent_, narrow_exponent / 2);
            if (touching->lens) {
                const auto& [ends, thickness] = *touching->lens;
                const Vector2d& across = touching->across;
                Lens lens{{}, h, f, g, across, {}, {}};
                const auto settle = [&](int k) {
                    MixedPiece::Vertex& v = lens.ends[k];
                    v = {ends[k], 0, f, {}};
                    return settle_sharply(v, {f, g, h});
                };
                const double reach = Interval::up(touching->width + thickness);
                lens.x = Interval::ball(touching->place.x(), reach);
                lens.y = Interval::ball(touching->place.y(), reach);
                const Vector2d along(-across.y(), across.x());
                const auto is_beyond = [&](const Vector2d& p, const Vector2d& q, double error) {
                    return along.dot(q - p) >
                           64 * (error + std::numeric_limits<double>::epsilon() * p.norm());
                };
                // Doubles hold no face that is thinner than their spacing.
                const bool is_thin =
                    thickness < std::numeric_limits<double>::epsilon() * touching->place.norm();
                if (!is_thin && settle(0) && settle(1) &&
                    is_beyond(lens.ends[0].point, touching->place, lens.ends[0].error) &&
                    is_beyond(touching->place, lens.ends[1].point, lens.ends[1].error) &&
                    work.where(lens.x, lens.y) == Inside::Yes) {
                    ++decisions_.by_multiprecision;
                    lenses.push_back(std::move(lens));
                    return true;
                }
            }
            if (!is_above && !is_narrow) return false;
            ++decisions_.by_multiprecision;
            if (!is_tie && is_above) return true;
            const std::array forms{f, g, h};
            const auto exact = exact_touch(forms, is_tie, touching->at, work.piece.box);
            Touch t{{touching->place,
                     std::max(touching->width, std::ldexp(extent_, assumed_exponent / 2)),
                     f,
                     {f, g, h}},
                    f,
                    g,
                    exact.has_value()};
            if (exact) {
                const auto& [x, y] = *exact;
                t.vertex.point = {x.mid(), y.mid()};
                t.vertex.error = reach(x, y);
            }
            touches.push_back(std::move(t));
            return true;
        }
        return false;
    };
    const std::size_t before = work.rivals.size();
    for (std::size_t i = 0; i < work.rivals.size() && work.rivals.size() > 2;)
        if (const FormId h = work.rivals[i].form; !is_on_rim(h) && stays_above(h))
            work.rivals.erase(work.rivals.begin() + static_cast<std::ptrdiff_t>(i));
        else
            ++i;
    if (work.rivals.size() == before) return false;
    work.directions.clear();
    work.is_divided = false;
    if (!is_plain(work) || !join_changes(work)) return false;
    for (const Touch& t : touches) {
        const Vector2d& p = t.vertex.point;
        const double r = t.vertex.error;
        const Inside inside = work.where(p, r);
        if (inside == Inside::No) continue;
        if (inside == Inside::Unknown) return false;
        // Nor where another form is lower.
        const Interval x = Interval::ball(p.x(), r), y = Interval::ball(p.y(), r),
                       low = heights_.value(t.f, x, y);
        bool is_hidden = false;
        for (const Spread& other : work.rivals) {
            if (other.form == t.f || other.form == t.g) continue;
            const auto sign = (heights_.value(other.form, x, y) - low).sign();
            if (!sign) return false;
            is_hidden = is_hidden || *sign == Sign::Negative;
        }
        if (is_hidden) continue;
        if (!work.divide(t.f, t.g, t.vertex)) return false;
        if (!t.decided) assume(p, r, t.vertex.ties);
    }
    for (const Lens& l : lenses) {
        const Interval low = heights_.value(l.f, l.x, l.y);
        bool is_hidden = false;
        for (const Spread& other : work.rivals) {
            if (other.form == l.f || other.form == l.g) continue;
            const auto sign = (heights_.value(other.form, l.x, l.y) - low).sign();
            if (!sign) return false;
            is_hidden = is_hidden || *sign == Sign::Negative;
        }
        if (!is_hidden && !work.insert_lens(l.h, l.f, l.g, l.ends, l.across)) return false;
    }
    return true;
}

// As cull(), by Taylor's formula about the middle. Pre: bend() was called.
void MixedAnalysis::cull_by_curvature(Work& work) {
    const std::size_t before = work.rivals.size();
    drop_dominated(work.rivals, [](const Spread& a, const Spread& b) {
        const auto &p = *a.bend, &q = *b.bend;
        const Interval bend = (p.curvature.xx - q.curvature.xx) * square(p.dx) +
                              2.0 * ((p.curvature.xy - q.curvature.xy) * p.dx * p.dy) +
                              (p.curvature.yy - q.curvature.yy) * square(p.dy);
        return (p.middle.v - q.middle.v + (p.middle.gx - q.middle.gx) * p.dx +
                (p.middle.gy - q.middle.gy) * p.dy + 0.5 * bend)
                   .lower() > 0;
    });
    decisions_.by_interval += before - work.rivals.size();
    if (work.rivals.size() < before) work.is_divided = false;
}

// As cull(), with values that doubles do not tell apart.
void MixedAnalysis::cull_sharply(Work& work) {
    struct Item {
        const Spread* spread;
        Wide v;
    };
    const auto& box = work.piece.box;
    const Vector2d m = work.middle();
    const Interval rx(Interval::up(std::max(box[1] - m.x(), m.x() - box[0]))),
        ry(Interval::up(std::max(box[3] - m.y(), m.y() - box[2])));
    std::vector<Item> items;
    for (const Spread& s : work.rivals)
        items.push_back({&s, heights_.value(s.form, Wide(m.x()), Wide(m.y()))});
    drop_dominated(items, [&](const Item& a, const Item& b) {
        const auto [gx, gy] = work.gradient(*a.spread, *b.spread);
        return ((a.v - b.v).enclosure() - gx.magnitude() * rx - gy.magnitude() * ry).lower() > 0;
    });
    decisions_.by_multiprecision += work.rivals.size() - items.size();
    std::vector<Spread> kept;
    for (const Item& i : items) kept.push_back(*i.spread);
    work.rivals = std::move(kept);
}

bool MixedAnalysis::is_plain(const Work& work) const {
    const std::vector<Spread>& r = work.rivals;
    const std::size_t n = r.size();
    // Triples first: three forms are often equal in two points, which takes less to see than all directions.
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = i + 1; j < n; ++j)
            for (std::size_t k = j + 1; k < n; ++k)
                if (!work.turn(r[i], r[j], r[k]) && !work.is_apart(r[i], r[j], r[k])) return false;
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = i + 1; j < n; ++j)
            if (!work.direction(r[i], r[j])) return false;
    return true;
}

// Arcs of a plain piece. Without a change, two or three competitors leave no room for any: an arc's ends lie
// on the rim or in the one point where all three are equal, and that one needs three ends on the rim.
bool MixedAnalysis::join_changes(Work& work) {
    const auto& changes = work.changes;
    const std::size_t n = work.rivals.size();
    if (!work.knots.empty()) {
        std::vector<Knot> knots;
        for (const std::uint32_t v : work.knots) {
            auto knot = forms_around_knot(work, v);
            if (!knot) return false;
            knots.push_back(*std::move(knot));
        }
        return join_all(work, knots);
    }
    if (n <= 3) {
        if (changes.empty()) return true;
        if (work.matched_pair()) {
            work.join(changes[0], changes[1]);
            return true;
        }
        if (n == 3 && changes.size() == 3) {
            const std::array forms{changes[0].before, changes[1].before, changes[2].before};
            MixedPiece::Vertex v;
            if (!locate_vertex(work, forms, v)) return false;
            work.join_all_to(v);
            return true;
        }
    }
    return join_all(work, {});
}

// The point inside in which three forms are equal, which is known to exist.
bool MixedAnalysis::locate_vertex(const Work& work, const std::array<FormId, 3>& forms,
                                  MixedPiece::Vertex& v) {
    v = {work.middle(), 0, forms[0], {}};
    const auto root = root_near(model<Interval>([&](const IntervalBox<2>& p) {
                                    return work.supports ? equal_heights(*work.supports, forms, p)
                                                         : equal_heights(heights_, forms, p);
                                }),
                                work.middle());
    if (root) {
        v.point = root->point;
        v.error = root->error;
    }
    const auto& box = work.piece.box;
    const auto is_inside = [&] {
        return v.point.x() + v.error >= box[0] && v.point.x() - v.error <= box[1] &&
               v.point.y() + v.error >= box[2] && v.point.y() - v.error <= box[3];
    };
    // Where the three all but touch, doubles tell them badly apart. Along tubes that are all but parallel
    // pieces are narrow across only.
    constexpr double well_known = 0x1p-40;
    const MixedPiece::Vertex rough = v;
    const bool is_found = root && is_inside(),
               is_narrow = std::min(box[1] - box[0], box[3] - box[2]) <= node_width * work.extent;
    const bool is_sharp = (is_found ? v.error > well_known * work.extent : is_narrow) &&
                          settle_sharply(v, forms) && is_inside();
    if (!is_sharp) v = rough;
    if (is_sharp || is_found) ++(is_sharp ? decisions_.by_multiprecision : decisions_.by_interval);
    return is_sharp || is_found;
}

// Between the two sides the lowest forms follow each other as their gradients do on their convex hull, from
// the label of one side to that of the other: so they do, too, where an arc leaves along a side. If both are
// one form, it is lowest along two directions and all between them; only where these are opposite may one
// other form be equal along both: their trisector touches the side, and passes through the piece if the other
// form falls faster towards the inside.
std::optional<MixedAnalysis::Knot> MixedAnalysis::forms_around_knot(const Work& work, std::uint32_t v) {
    const auto [arriving, leaving] = work.sides_at(v);
    const std::size_t rim = work.piece.rim.size();
    const FormId first = work.piece.rim[v].label, last = work.piece.rim[(v + rim - 1) % rim].label;
    Knot knot{v, work.piece.vertices[v].ties, {first}};
    SmallVector<const Spread*, usual_rivals> ties;
    for (const FormId f : knot.ties) {
        const Spread* s = work.find(f);
        if (!s) return std::nullopt;
        ties.push_back(s);
    }
    const auto find = [&](FormId f) { return std::ranges::find(ties, f, &Spread::form); };
    if (find(first) == ties.end() || find(last) == ties.end()) return std::nullopt;
    if (first == last) {
        if (arriving != leaving) return knot;
        if (ties.size() != 2) return std::nullopt;
        const Spread *lowest = *find(first), *other = ties[0] == lowest ? ties[1] : ties[0];
        const auto [gx, gy] = work.gradient(*other, *lowest);
        const auto inward = (Interval(leaving->a) * gx + Interval(leaving->b) * gy).sign();
        if (!inward || *inward == Sign::Zero) return std::nullopt;
        if (*inward == Sign::Negative) knot.around = {first, other->form, first};
        return knot;
    }
    while (knot.around.back() != last) {
        const auto next = work.next_on_hull(ties, **find(knot.around.back()));
        if (!next || knot.around.size() >= ties.size()) return std::nullopt;
        knot.around.push_back(next->form);
    }
    return knot;
}

// Of three forms each stretch of a trisector ends on the rim or in the one point where all are equal, where
// one stretch of each ends. So that point is inside if every two change on the rim an odd number of times,
// and not if they do so an even number of times. Pre: there are no other forms.
bool MixedAnalysis::leave_one_end(const Work& work, const std::array<FormId, 3>& forms) {
    return std::ranges::count_if(work.changes,
                                 [&](const Change& c) {
                                     return (c.before == forms[0] && c.after == forms[1]) ||
                                            (c.before == forms[1] && c.after == forms[0]);
                                 }) %
               2 ==
           1;
}

// Every visible stretch of a trisector is a graph over the line across its direction. If it has two ends, at
// the rim's changes and at the vertices, it is one stretch; if it has more, all of the trisector is to be a
// graph, along which stretches begin and end in turn. Around a vertex the forms follow each other
// counter-clockwise as their gradients do on their convex hull, since the lowest one in a direction has the
// gradient farthest against it.
bool MixedAnalysis::join_all(Work& work, std::span<const Knot> knots) {
    const std::vector<Spread>& r = work.rivals;
    const std::size_t n = r.size(), rim = work.piece.vertices.size();
    struct Inner {
        MixedPiece::Vertex vertex;
        std::vector<const Spread*> hull;  // rivals, counter-clockwise
        std::vector<FormId> forms;
    };
    std::vector<Inner> inner;
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = i + 1; j < n; ++j)
            for (std::size_t k = j + 1; k < n; ++k) {
                const std::array forms{r[i].form, r[j].form, r[k].form};
                const auto meet = [&](const std::vector<FormId>& there) {
                    return std::ranges::all_of(
                        forms, [&](FormId f) { return std::ranges::find(there, f) != there.end(); });
                };
                if (std::ranges::any_of(inner, meet, &Inner::forms) ||
                    std::ranges::any_of(knots, meet, &Knot::ties))
                    continue;
                if (work.turn(r[i], r[j], r[k]) == Sign::Zero) continue;
                Inner v;
                Inside inside = Inside::No;
                if (n > 3 || !knots.empty())
                    inside = find_vertex(work, forms, v.vertex);
                else if (leave_one_end(work, forms))
                    inside = locate_vertex(work, forms, v.vertex) ? Inside::Yes : Inside::Unknown;
                if (inside == Inside::Unknown) return false;
                if (inside == Inside::No) continue;
                v.forms.assign(forms.begin(), forms.end());
                std::vector<const Spread*> present{&r[i], &r[j], &r[k]};
                bool visible = true;
                for (std::size_t l = 0; l < n && visible; ++l) {
                    if (l == i || l == j || l == k) continue;
                    const auto s = sign_at_vertex(v.vertex, forms, r[l].form);
                    if (!s) return false;
                    visible = *s != Sign::Negative;
                    if (*s != Sign::Zero) continue;
                    v.forms.push_back(r[l].form);
                    present.push_back(&r[l]);
                }
                if (!visible) continue;
                if (v.forms.size() > 3) {
                    v.vertex.ties = v.forms;
                    if (!settle_tie(v.vertex, forms))
                        assume(v.vertex.point, std::ldexp(extent_, assumed_exponent), v.forms);
                }
                const Spread* a = *std::ranges::find_if(
                    present, [&](const Spread* p) { return work.next_on_hull(present, *p) != nullptr; });
                do {
                    v.hull.push_back(a);
                    a = work.next_on_hull(present, *a);
                } while (a != v.hull.front());
                inner.push_back(std::move(v));
            }
    for (const Inner& v : inner) {
        work.piece.vertices.push_back(v.vertex);
        work.piece.leaving.emplace_back();
        work.triples.push_back({v.forms[0], v.forms[1], v.forms[2]});
    }

    std::vector<Change> ends;
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t j = i + 1; j < n; ++j) {
            ends.clear();
            const auto add = [&](const Change& c) {
                if ((c.before == r[i].form && c.after == r[j].form) ||
                    (c.before == r[j].form && c.after == r[i].form))
                    ends.push_back(c);
            };
            for (const Change& c : work.changes)
                if (std::ranges::find(knots, c.vertex, &Knot::vertex) == knots.end()) add(c);
            for (const Knot& knot : knots)
                for (std::size_t k = 0; k + 1 < knot.around.size(); ++k)
                    add({knot.vertex, knot.around[k + 1], knot.around[k]});
            for (std::size_t v = 0; v < inner.size(); ++v) {
                const std::vector<const Spread*>& hull = inner[v].hull;
                for (std::size_t k = 0; k < hull.size(); ++k)
                    add({static_cast<std::uint32_t>(rim + v), hull[(k + 1) % hull.size()]->form,
                         hull[k]->form});
            }
            if (ends.empty()) continue;
            const Vector2d direction = *work.direction(r[i], r[j]);
            if (ends.size() > 2 && !work.crosses_once(r[i], r[j], direction)) return false;
            if (!join_pair(work, direction, r[i].form, r[j].form, ends)) return false;
        }
    // Around a vertex each arc has another form on its right.
    const auto sort_around = [&](std::size_t v, const auto& around, auto form) {
        MixedPiece::HalfEdges& leaving = work.piece.leaving[v];
        MixedPiece::HalfEdges sorted;
        for (const auto& right : around)
            for (const std::uint32_t h : leaving) {
                const MixedPiece::Arc& a = work.piece.arcs[h >> 1];
                if ((h & 1u ? a.left : a.right) == form(right)) sorted.push_back(h);
            }
        leaving = std::move(sorted);
    };
    for (std::size_t v = 0; v < inner.size(); ++v)
        sort_around(rim + v, inner[v].hull, [](const Spread* s) { return s->form; });
    for (const Knot& knot : knots)
        sort_around(knot.vertex, std::span(knot.around).first(knot.around.size() - 1),
                    [](FormId f) { return f; });
    return true;
}

// Along e the direction in which f - g grows points to the left: there g is lower. Vertices that doubles do
// not separate are compared with many digits.
bool MixedAnalysis::join_pair(Work& work, const Vector2d& direction, FormId f, FormId g,
                              std::vector<Change>& ends) {
    if (ends.size() % 2 != 0) return false;
    const Vector2d e(direction.y(), -direction.x());
    const std::size_t rim = work.piece.rim.size();
    bool separated = true;
    const auto precedes = [&](const Change& a, const Change& b) {
        if (a.vertex == b.vertex)
            return a.before == f && b.before == g;  // touching the rim: one stretch ends, one begins
        const MixedPiece::Vertex &v = work.piece.vertices[a.vertex], &w = work.piece.vertices[b.vertex];
        const double gap = e.dot(w.point - v.point);
        if (std::abs(gap) >
            2 * (v.error + w.error) + 8 * std::numeric_limits<double>::epsilon() * v.point.norm())
            return gap > 0;
        if (a.vertex >= rim && b.vertex >= rim) {
            const auto p = sharp_vertex(v, work.triples[a.vertex - rim]),
                       q = sharp_vertex(w, work.triples[b.vertex - rim]);
            if (p && q) {
                const auto s = (Wide(e.x()) * ((*q)[0] - (*p)[0]) + Wide(e.y()) * ((*q)[1] - (*p)[1])).sign();
                ++decisions_.by_multiprecision;
                if (s) return *s == Sign::Positive;
            }
        }
        separated = false;
        return gap > 0;
    };
    // Few, and the order may turn out undecided: sorted by hand.
    for (std::size_t i = 1; i < ends.size(); ++i)
        for (std::size_t k = i; k > 0 && precedes(ends[k], ends[k - 1]); --k) std::swap(ends[k], ends[k - 1]);
    if (!separated) return false;
    for (std::size_t k = 0; k < ends.size(); ++k)
        if (ends[k].before != (k % 2 == 0 ? g : f)) return false;
    for (std::size_t k = 0; k < ends.size(); k += 2) work.join(ends[k], ends[k + 1]);
    return true;
}

// Contracts a box a little larger than the piece, or the part of it where all three meet, to the root, if
// there is one.
MixedAnalysis::Inside MixedAnalysis::find_vertex(const Work& work, std::array<FormId, 3> forms,
                                                 MixedPiece::Vertex& out) {
    if (work.known_apart(forms)) return Inside::No;
    std::array<double, 4> box = work.piece.box;
    const bool by_supports = work.supports && work.rivals.size() <= most_divided;
    if (by_supports) {
        const auto place = [&](FormId f) { return work.place(*work.find(f)); };
        const auto part = work.divided().meeting(place(forms[0]), place(forms[1]), place(forms[2]));
        if (!part) return Inside::No;
        box = *part;
    }
    const auto system = model<Interval>([&](const IntervalBox<2>& p) {
        return by_supports ? equal_heights(*work.supports, forms, p) : equal_heights(heights_, forms, p);
    });
    const double dx = 0.25 * (box[1] - box[0]), dy = 0.25 * (box[3] - box[2]);
    const auto found = contract<Interval, 2>(
        system, {Interval(box[0] - dx, box[1] + dx), Interval(box[2] - dy, box[3] + dy)});
    if (found.empty) return Inside::No;
    IntervalBox<2> root = found.box;
    // Exactly one: so it is what is proved more closely in a part of the box.
    if (found.unique)
        if (const auto closer = prove_near<Interval, 2>(
                system, {Interval(root[0].mid()), Interval(root[1].mid())}, everywhere);
            closer && is_subset(*closer, root))
            root = *closer;
    const auto [X, Y] = root;
    const Inside inside = work.where(X, Y);
    if (inside == Inside::No) return inside;
    if (inside == Inside::Unknown || !found.unique) return Inside::Unknown;
    ++decisions_.by_interval;
    out = {{X.mid(), Y.mid()}, reach(X, Y), forms[0], {}};
    return Inside::Yes;
}

// The point where three forms are equal, within 2^exponent of the chart's size. The Jacobian is that of
// differences with many digits: of forms that are nearly one function along a line doubles keep little of it.
std::optional<std::array<Wide, 2>> MixedAnalysis::sharp_vertex(const MixedPiece::Vertex& v,
                                                               const std::array<FormId, 3>& forms,
                                                               int exponent) {
    const auto linearise = [&](const WideBox<2>& p) { return equal_heights(heights_, forms, p); };
    const double radius = std::ldexp(extent_, exponent);
    constexpr int most_steps = 20;
    const auto near = approach<Wide, 2>(model<Wide>(linearise), {Wide(v.point.x()), Wide(v.point.y())},
                                        everywhere, 0.25 * radius, most_steps);
    if (!near) return std::nullopt;
    const Wide d(-radius, radius);
    const WideBox<2> box{near->point[0] + d, near->point[1] + d};
    LocalModel<Wide, 2> local = linearise(box);
    local.value = near->local.value;
    if (!krawczyk_step<Wide, 2>(local, Offsets<Wide, 2>(near->point, d), box, Preconditioning::Inverse)
             .unique())
        return std::nullopt;
    return box;
}

// Takes a vertex to where three forms are equal, as near as doubles go.
bool MixedAnalysis::settle_sharply(MixedPiece::Vertex& v, const std::array<FormId, 3>& forms) {
    // Twice the digits of a double: each step more costs as much as everything else about a vertex.
    constexpr int exponent = -100;
    const auto sharp = sharp_vertex(v, forms, exponent);
    if (!sharp) return false;
    v.point = {(*sharp)[0].approximation(), (*sharp)[1].approximation()};
    v.error = Interval::up(4 * std::numeric_limits<double>::epsilon() * v.point.norm() +
                           std::ldexp(extent_, exponent + 1) + std::numeric_limits<double>::min());
    return true;
}

// The point with rational coordinates that these stand for, if all of the forms tie there.
std::optional<RationalPoint> MixedAnalysis::exact_tie(std::span<const FormId> forms, const Wide& x,
                                                      const Wide& y) {
    auto p = rational_near(x, y, extent_);
    if (!p || (!heights_.family().radial.empty() && p->w != Exact(1.0))) return std::nullopt;
    decisions_.by_exact += forms.size() - 1;
    return all_tie(heights_.family(), forms, *p) ? std::move(p) : std::nullopt;
}

// Is a form's height certainly one that its equation has?
bool MixedAnalysis::is_met(FormId f, const Interval& x, const Interval& y) const {
    return heights_.value(f, x, y).sign() ==
           (heights_.family().radial.empty() ? Sign::Positive : Sign::Negative);
}

// The place about which three forms tie as far as digits tell, if they do so exactly and touch there. On the
// one trisector in the box and its surroundings the third one's height above it bends one way, so that there
// is one such place at most.
std::optional<IntervalPoint> MixedAnalysis::exact_touch(std::span<const FormId> forms, bool is_tie,
                                                        const std::array<Wide, 2>& at,
                                                        const std::array<double, 4>& box) {
    if (!is_tie) return std::nullopt;
    if (const auto p = exact_tie(forms, at[0], at[1]);
        p && have_gradients_in_line(heights_.family(), forms, *p))
        return enclosure(*p);
    const double near = 0.25 * std::min(box[1] - box[0], box[3] - box[2]);
    decisions_.by_exact += forms.size() - 1;
    for (const SpacePoint& p : SpaceTie(heights_.family(), forms).tangencies()) {
        const auto place = chart_point(heights_.family(), p);
        if (!place) continue;
        const auto& [x, y] = *place;
        const double off = std::max((x - at[0].enclosure()).magnitude(), (y - at[1].enclosure()).magnitude());
        if (off < near && is_met(forms[0], x, y)) return place;
    }
    return std::nullopt;
}

// Do all forms that tie in a vertex as far as digits tell do so exactly? In a rational point, and as there is
// only one point in which three of them do, it is the vertex then; or wherever three of them do; or in the
// point that all equations leave.
bool MixedAnalysis::settle_tie(MixedPiece::Vertex& v, const std::array<FormId, 3>& forms) {
    const auto box = sharp_vertex(v, forms);
    if (!box) return false;
    if (const auto p = exact_tie(v.ties, (*box)[0], (*box)[1])) {
        const auto [x, y] = enclosure(*p);
        v.point = {x.mid(), y.mid()};
        v.error = reach(x, y);
        return true;
    }
    const Interval x = (*box)[0].enclosure(), y = (*box)[1].enclosure();
    if (!is_met(forms[0], x, y)) return false;
    const FormFamily& family = heights_.family();
    const SpaceTie tie(family, forms);
    const auto is_theirs = [&](FormId f) {
        return std::ranges::find(forms, f) != forms.end() || tie.implies(f);
    };
    const auto is_vertex = [&](const SpacePoint& p) {
        const auto at = wide_chart_point(family, p);
        return at && (*box)[0].contains((*at)[0]) && (*box)[1].contains((*at)[1]);
    };
    if (!std::ranges::all_of(v.ties, is_theirs) &&
        !std::ranges::any_of(SpaceTie(family, v.ties).points(), is_vertex))
        return false;
    v.point = {x.mid(), y.mid()};
    v.error = reach(x, y);
    return true;
}

// other - forms at their common point; Zero where 200 bits do not tell them apart.
std::optional<Sign> MixedAnalysis::sign_at_vertex(const MixedPiece::Vertex& v, std::array<FormId, 3> forms,
                                                  FormId other) {
    const Interval X = Interval::ball(v.point.x(), v.error), Y = Interval::ball(v.point.y(), v.error);
    if (const auto s = (heights_.value(other, X, Y) - heights_.value(forms[0], X, Y)).sign()) {
        ++decisions_.by_interval;
        return s;
    }
    const auto box = sharp_vertex(v, forms);
    if (!box) return std::nullopt;
    const Wide height = heights_.value(forms[0], (*box)[0], (*box)[1]);
    const Wide difference = heights_.value(other, (*box)[0], (*box)[1]) - height;
    ++decisions_.by_multiprecision;
    if (const auto s = difference.sign()) return s;
    if (difference.magnitude_exponent() < height.magnitude_exponent() + assumed_exponent) return Sign::Zero;
    return std::nullopt;
}

// --- Around a point in which all competitors tie
// ---------------------------------------------------------------

struct MixedAnalysis::Apex {
    Vector2d point;
    double error;
    std::optional<std::uint32_t> rim;  // the vertex of the rim that it is
    std::vector<std::vector<TiedDifference>> differences;
    bool decided;  // that all tie: by exact arithmetic, or when the rim was labelled
};

// Where gradients of competitors may agree it is a zero of their difference; else where three of them are
// equal; in any case all of them must be equal there, and pairs whose gradients are not certainly different
// must have equal ones.
std::optional<MixedAnalysis::Apex> MixedAnalysis::find_apex(const Work& work) {
    const std::vector<Spread>& r = work.rivals;
    const std::size_t n = r.size();
    Apex apex{{}, 0, {}, {}, false};
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

    std::optional<Root> root;
    std::array<FormId, 3> triple;
    if (!touching.empty()) {
        const FormId f = r[touching[0][0]].form, g = r[touching[0][1]].form;
        root = root_near(equal_gradients(heights_, f, g), apex.rim ? apex.point : work.middle());
    } else {
        if (n < 4) return std::nullopt;  // then they tie in one point at most, and the piece will be plain
        triple = {r[0].form, r[1].form, r[2].form};
        root = root_near(
            model<Interval>([&](const IntervalBox<2>& p) { return equal_heights(heights_, triple, p); }),
            work.middle());
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
    const Interval lowest = heights_.value(r[0].form, X, Y);
    for (std::size_t i = 1; i < n; ++i)
        if ((heights_.value(r[i].form, X, Y) - lowest).sign()) return std::nullopt;

    if (touching.empty()) {
        MixedPiece::Vertex v{apex.point, apex.error, triple[0], work.forms()};
        for (std::size_t i = 3; i < n; ++i)
            if (sign_at_vertex(v, triple, r[i].form) != Sign::Zero) return std::nullopt;
        apex.decided = settle_tie(v, triple);
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
        apex.differences[i][j].curvature =
            heights_.curvature(r[i].form, bx, by) - heights_.curvature(r[j].form, bx, by);
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
        model<Wide>([&](const WideBox<2>& p) { return equal_gradients(heights_, f, g, p); });
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
    for (double step = 0.5 * work.width; step > 0x1p-10 * work.width; step *= 0.5) {
        const double s = apex.point[by_x ? 0 : 1];
        const auto before = above(s - step), after = above(s + step);
        if (before && after) return *before == -*after && *before != Sign::Zero;
    }
    return false;
}

// A convex piece shows the directions around the apex once each, in their order: when its rim has as many
// changes as the fan has arms, each arm ends in one of them.
bool MixedAnalysis::join_at_tie(Work& work) {
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
    const auto fan = find_fan(forms, apex->differences, corners);
    if (!fan) return false;
    const auto changes = apex->rim ? work.changes_after(*apex->rim) : work.changes;
    const std::vector<FanArm>& arms = fan->arms;
    const std::size_t n = arms.size();
    if (changes.size() != n) return false;
    const auto matches = [&](const Change& c, const FanArm& arm) {
        const MixedPiece::Vertex& v = work.piece.vertices[c.vertex];
        const Vector2d d = v.point - apex->point;
        const double doubt = 2 * (v.error + apex->error);
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
        assume(apex->point, std::ldexp(extent_, assumed_exponent / 2), forms);
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
                return heights_.value(arc.left, x, y) - heights_.value(arc.right, x, y);
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
    const FormId f = work.rivals[0].form, g = work.rivals[1].form;
    const Interval X(work.piece.box[0], work.piece.box[1]), Y(work.piece.box[2], work.piece.box[3]);
    const HeightCurvature<Interval> p = heights_.curvature(f, X, Y), q = heights_.curvature(g, X, Y);
    const Interval xx = p.xx - q.xx, xy = p.xy - q.xy, yy = p.yy - q.yy;
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
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(curvature);  // values ascend
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
    const auto exact = exact_touch(forms, is_tie, pinch->at, work.piece.box);
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
