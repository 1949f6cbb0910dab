// What deciding one piece works on: the piece as it is drawn, and its rivals.
#pragma once

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "box_rivals.hpp"
#include "height_difference.hpp"
#include "mixed_drawing.hpp"
#include "touching.hpp"

namespace vcell {

// Below this exponent a third form lowest by less between two others counts as touching their trisector.
inline constexpr int narrow_exponent = -40;
// Below this one more than three forms, of which some touch, count as meeting in one point.
inline constexpr int noise_exponent = -46;

// How rivals compare all over the piece: what is known of them lasts until some are left out.
struct PieceWork : PieceDrawing {
    const NormalBox* normals;  // these two are null unless rivals compare by supports
    const SphereSupports* supports;
    const Heights& heights;
    const FloorRule& rule;
    Decisions& decisions;
    std::optional<DividedBox>& parts;  // an earlier piece's until this one is divided
    std::vector<Spread>& rivals;       // as the last cull() left them, fewer as more is known

    double width = 0, extent = 0;
    bool is_small = false;                         // in one direction at least
    std::vector<std::array<FormId, 3>> triples{};  // of the inner vertices
    mutable bool is_divided = false;
    mutable std::vector<FormId> parted{};  // their forms
    struct Direction {
        FormId a, b;
        std::optional<Vector2d> d;
    };
    mutable SmallVector<Direction, 6> directions{};      // as found for the rivals as they are
    mutable std::vector<std::array<FormId, 3>> apart{};  // known to tie nowhere, in the order of the rivals
    // The difference of twins among the rivals, at the middle of the box and all over it.
    struct Twins {
        FormId f, g;
        FunctionJet<Interval> middle, over;
    };
    mutable std::vector<Twins> twins{};

    std::vector<FormId> forms() const;
    const Spread* find(FormId f) const {
        const auto it = std::ranges::find(rivals, f, &Spread::form);
        return it == rivals.end() ? nullptr : &*it;
    }
    // The gradient of a - b all over the piece. Where the two are nearly the same function its mean value
    // form is by far the sharper one.
    std::array<Interval, 2> gradient(const Spread& a, const Spread& b) const;
    // Null unless the two are twins.
    const Twins* find_twins(FormId f, FormId g) const;
    // The gradient of heights that are not multiplied by the distances from tips: near one the product of
    // those that do not grow there is nearly zero, and changes little but with the distance.
    std::array<Interval, 2> plain_gradient(const Spread& a, const Spread& b) const {
        const auto& box = piece.box;
        return heights.plain_gradient_difference(a.form, b.form, {box[0], box[1]}, {box[2], box[3]});
    }
    using Gradient = std::array<Interval, 2>;
    // The least of all gradients: in its direction all of them grow. Zero if one may vanish.
    static Vector2d least(const Gradient& g);
    static bool grows(const Gradient& g, const Vector2d& d) {
        return d.allFinite() && (Interval(d.x()) * g[0] + Interval(d.y()) * g[1]).lower() > 0;
    }
    // Do all of these grow in one direction, as far as directions near their middles or ends tell?
    static bool grow_together(std::span<const Gradient> gradients);
    // Pre: both are bent.
    HeightDifference difference(const Spread& a, const Spread& b) const;
    // A unit vector in which a - b certainly grows all over the piece, or falls if the greater one of the two
    // shows; over a sphere at least wherever a = b are lowest.
    std::optional<Vector2d> direction(const Spread& a, const Spread& b) const;
    std::optional<Vector2d> find_direction(const Spread& a, const Spread& b) const;
    // Does every line in this direction of theirs meet a = b at most once?
    bool crosses_once(const Spread& a, const Spread& b, const Vector2d& direction) const {
        return !is_divided || rivals.size() == 2 || parts->grows_throughout(place(a), place(b), direction);
    }
    // Does a - b seem to fall where the two change on the rim? A cheap no to what would have to be proved.
    bool falls_on_rim(FormId a, FormId b, const Vector2d& direction) const;
    std::size_t place(const Spread& s) const { return static_cast<std::size_t>(&s - rivals.data()); }
    const DividedBox& divided() const;
    // Three in this succession or one step on, so that the first one's differences with both others tell
    // where all are equal: of what is by far the steepest, as a twin of the base is, only one of the two; of
    // twins, their own.
    std::array<const Spread*, 3> told_apart(const Spread& a, const Spread& b, const Spread& c) const;
    // The turn from grad a over grad b to grad c, over a sphere at least in a box that holds all points where
    // a = b = c are lowest; Zero if there are no such points. The three in one order always, as another one
    // need not tell.
    std::optional<Sign> turn(const Spread& a, const Spread& b, const Spread& c) const;
    std::optional<Sign> turn_from(const Spread& a, const Spread& b, const Spread& c) const;
    // Wherever the three are equal, is another rival certainly lower? Not asked beside a floor.
    bool is_hidden(const Spread& a, const Spread& b, const Spread& c) const;
    // In a point where all of `tied` are equal, the one after `p` on the convex hull of their gradients,
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
    // Is a combination of b - a and c - a nowhere zero? Then the three are nowhere equal. The
    // combination asked changes least about the middle: nearly nothing to first order where trisectors run
    // beside each other.
    bool are_apart(const Spread& a, const Spread& b, const Spread& c) const;
    // Do the three certainly tie nowhere in the piece? Where gradients are on one line all along a trisector,
    // as of tubes that are nearly parallel over a tube, their turn never tells. Asked of few and in a small
    // piece, when the other questions have failed.
    bool is_apart(const Spread& a, const Spread& b, const Spread& c) const;
    bool known_apart(const std::array<FormId, 3>& forms) const {
        return std::ranges::find(apart, forms) != apart.end();
    }
    // Returns the arc's half-edge at its start; its twin's number is one more.
    std::uint32_t add_arc(std::uint32_t from, std::uint32_t to, FormId left, FormId right);
    // Between two places on the rim.
    void join(const RimChange& from, const RimChange& to) {
        const std::uint32_t h = add_arc(from.vertex, to.vertex, from.before, from.after);
        piece.leaving[from.vertex].push_back(h);
        piece.leaving[to.vertex].push_back(h + 1);
    }
    // Do all rivals meet in a vertex of the rim?
    bool all_tie_in(std::uint32_t v) const {
        const std::vector<FormId>& ties = piece.vertices[v].ties;
        return std::ranges::all_of(
            rivals, [&](const Spread& s) { return std::ranges::find(ties, s.form) != ties.end(); });
    }
    // From all other changes to a vertex of the rim.
    void join_all_on_rim(std::uint32_t v) {
        for (const RimChange& c : changes_after(v)) join(c, {v, c.after, c.before});
    }
    // From every change to one inner vertex.
    void join_all_to(const MixedPiece::Vertex& center);
};

}  // namespace vcell
