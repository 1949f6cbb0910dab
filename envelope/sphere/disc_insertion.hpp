/// Insertion of one more form into a diagram of discs: what it is compared with, and how its face is cut in.
///
/// A form is inserted as the paper compares two surfaces [HE, section 2.1], but against the faces of the
/// diagram so far that it may conflict with. What it takes away is known from signs at vertices and along
/// edges, as long as no face is cut in more than two: circles meet in two points at most.
///
/// The points of space where the new form c is the lowest are a convex polyhedron P, and it wins where P
/// meets the sphere. That tells how far to look:
/// - A part of P on the sphere that holds no vertex is the only one. It passes from face to face across edges
///   without running in circles, as faces are discs; so it has a last face f, next to g. There it is all of
///   c < f and c < g that lies in f, as three circles through two points leave nothing else, and what is left
///   without f has one face less. With one face it is a whole cap, and P lies in the half-space of that.
///   So, if c wins at any vertex, then in each part at one at least, and from those the faces that it
///   reaches are found across edges.
/// - A short arc lies in the triangle of its ends and the point where its tangents there meet, and c - f is
///   linear: signs in the three corners tell that c wins nowhere on it.
/// - A face f within a hemisphere lies above the convex hull of its boundary, seen along the axis to the
///   pole. So where c loses on the boundary and c - f does not fall towards the pole, c loses in the face,
///   too. The pole is where f is lowest, and a form that others have beaten is mostly flatter than f.
/// A small diagram is looked through for vertices, a large one has a tree of them.
///
/// A form that doubles cannot tell from a vertex is compared with it by the kernel of circles, exactly. The
/// edges that this leaves may be too short to have a direction in doubles: they lie in a ball about their
/// ends.
///
/// Where it ties with the vertex it counts as the higher one. That is the diagram of forms of which each is
/// raised by an infinitesimal that is beyond all multiples of those before: vertices have three edges still,
/// and those in which more forms tie are several, joined by edges without length. Of these it is known
/// exactly that both their ends are one point. In the end they are contracted, and the vertices have all
/// their forms. Where the form ties along an edge it is higher there, too: it belongs to the edge's label. If
/// it is lower on one side of the edge, the face there keeps a sliver of two edges on one circle. In the end
/// slivers are contracted to edges, whose labels they join. A face that meets itself in such a point, and an
/// edge that is closed there, are left to the general engine; so are forms that touch edges in a point, or
/// tie inside faces.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "disc_geometry.hpp"
#include "sphere_diagram.hpp"

namespace vcell::discs {

class DiscInsertion : protected DiscGeometry {
protected:
    using DiscGeometry::DiscGeometry;

    /// Merges in one more form. False where that is no common case: the diagram is broken then.
    bool insert(Index challenger) {
        ++stamp_;
        rivals_.clear();
        cuts_.clear();
        swallowed_.clear();
        new_edges_.clear();
        middles_.clear();
        bool is_beaten = false;
        const Linear& form = forms_[challenger];
        if (!(vertex_tree_ ? find_rivals_in_trees(form) : find_rivals(form, is_beaten))) return false;
        if (is_beaten) return true;
        for (std::size_t i = 0; i < rivals_.size(); ++i)  // may add some
            if (!challenge(form, rivals_[i])) return false;
        if (cuts_.empty()) {
            // All boundaries are kept or all lost, and this cannot be.
            for (const Index face : rivals_)
                if (!is_within(form, face)) return false;
            return swallowed_.empty();
        }
        for (const Index face : swallowed_)
            if (!is_within(form, face)) return false;
        for (const Cut& c : cuts_)
            if (!add_vertex(challenger, c)) return false;
        for (const Index face : swallowed_) {
            remove(faces_[face].start, faces_[face].start);
            faces_[face].start = none;
        }
        for (const Cut& c : cuts_) {
            if (half_edges_[c.leaving].next != c.returning) remove(half_edges_[c.leaving].next, c.returning);
            remove_vertex(half_edges_[c.returning].origin);
        }
        for (const Cut& c : cuts_) cut(challenger, c);
        for (const Index h : middles_) remove_middle(h);
        if (!vertex_tree_) {
            if (!swallowed_.empty()) erase_if(alive_faces_, [&](Index f) { return faces_[f].start == none; });
            alive_faces_.push_back(challenger);
            top_ = HUGE_VAL;
            is_top_known_ = is_flattest_known_ = false;
        }
        return close(challenger);
    }

    /// Forms are to come that are steeper than all others. False where that is no common case.
    bool set_steepest(double steepest) {
        if (vertex_tree_) return false;
        steepest_ = steepest;
        top_ = HUGE_VAL;
        is_top_known_ = false;
        const auto renew = [&](Mark& mark, MarkRows& rows, Index i) {
            if (mark.is_gone() || mark.doubt == HUGE_VAL) return;
            mark.set_level(steepest);
            rows.set(i, mark);
        };
        for (Index v = 0; v < vertices_.size(); ++v) renew(vertices_[v], vertex_rows_, v);
        for (Index e = 0; e < edges_.size(); ++e) renew(edges_[e].apex, apex_rows_, e);
        return true;
    }

    /// What all vertices, edges and faces tell, for whoever searches for more forms.
    SphereMarks marks() {
        SphereMarks marks;
        marks.steepest = steepest_;
        marks.places.reserve(vertices_.size() + edges_.size());
        for (const Vertex& v : vertices_)
            if (!v.is_gone()) marks.places.push_back({v.p, v.level});
        for (Index e = 0; e < edges_.size() && marks.are_all; ++e) {
            const Edge& edge = edges_[e];
            if (edge.apex.is_gone() || edge.is_point) continue;
            if (edge.apex.doubt < HUGE_VAL)
                marks.places.push_back({edge.apex.p, edge.apex.level});
            else
                add_parts(e, marks);
        }
        for (Index f = 0; f < faces_.size() && marks.are_all; ++f) {
            if (faces_[f].start == none) continue;
            const Linear& form = forms_[f];
            if (is_in_hemisphere(f))
                add_gradient(form, form.b.normalized(), marks);
            else
                marks.are_all = add_wide_face(f, marks);
        }
        return marks;
    }

    // An arc whose angle is known: neither next to nothing nor next to all of its circle, which would look
    // alike.
    struct LongArc {
        Vector3d center, from, across;  // from: seen from the centre; across: a quarter of a turn on
        double angle;
    };
    std::optional<LongArc> long_arc(Index e) const {
        constexpr double enough = 0x1p-40;  // for add_apex()
        constexpr double pi = std::numbers::pi, least_angle = 0x1p-10;
        const Edge& edge = edges_[e];
        const Vertex &p = vertices_[half_edges_[2 * e].origin], &q = vertices_[half_edges_[2 * e + 1].origin];
        const double radius2 = 1 - edge.offset * edge.offset / edge.square;
        LongArc arc;
        arc.center = edge.offset / edge.square * edge.normal;
        arc.from = p.p - arc.center;
        arc.across = edge.normal.cross(arc.from) / edge.length;
        const Vector3d to = q.p - arc.center;
        arc.angle = std::atan2(arc.across.dot(to), arc.from.dot(to));
        if (arc.angle < 0) arc.angle += 2 * pi;
        if (radius2 > least_square && p.error + q.error + edge.error / edge.length < enough &&
            arc.angle > least_angle && arc.angle < 2 * pi - least_angle)
            return arc;
        return std::nullopt;
    }
    bool is_long(Index e) const { return long_arc(e).has_value(); }

    SomeIndices alive_faces_;  // as long as there is no tree

private:
    static constexpr std::size_t largest_small = 96;  // faces of a diagram without a tree

    static void add_gradient(const Linear& form, const Vector3d& up, SphereMarks& marks) {
        marks.gradients.push_back({up, form.b.dot(up) - 2 * (form.error + slack * form.slope)});
    }
    // A face that is in no hemisphere about the point z where its form is lowest, but still far from the
    // opposite point. Where another form wins in the face and nowhere on its boundary it does so in a cap
    // within; if it wins nowhere either on spokes, from z to where the face ends, the cap is in a sector
    // between two of them, and each of those lies in a hemisphere.
    bool add_wide_face(Index face, SphereMarks& marks) {
        SphereMarks around;
        for_boundary(face, [&](Index h) {
            const Mark& apex = edges_[h >> 1].apex;
            around.places.push_back({vertices_[half_edges_[h].origin].p, 0});
            if (apex.doubt < HUGE_VAL)
                around.places.push_back({apex.p, 0});
            else
                add_parts(h >> 1, around);
        });
        const Linear& form = forms_[face];
        const Vector3d up = form.b.normalized();
        // The boundary is in this half-space, beyond the errors of marks, and so is the face.
        constexpr double margin = 0x1p-20, most_depth = 0.5;
        double depth = 0;
        for (const auto& mark : around.places) depth = std::max(depth, mark.p.dot(up) + margin);
        if (!(around.are_all && depth < most_depth && is_outside(face, up))) return false;
        constexpr int spokes = 4, parts = 3;
        const double reach = std::acos(-depth), half = 0.5 * reach / parts;
        const Vector3d x = up.unitOrthogonal(), y = up.cross(x);
        const auto direction = [&](double around_z, double from_z) {
            const Vector3d across = std::cos(around_z) * x + std::sin(around_z) * y;
            return Vector3d(std::sin(from_z) * across - std::cos(from_z) * up);
        };
        constexpr double sector = 2 * std::numbers::pi / spokes;
        // The corners of a sector are the farthest from its middle.
        if (!(direction(0, 0.5 * reach).dot(direction(0.5 * sector, reach)) > margin)) return false;
        for (int k = 0; k < spokes; ++k) {
            for (int i = 0; i < parts; ++i)
                add_apex(form, form, direction(k * sector, (2 * i + 1) * half) / std::cos(half), marks);
            add_gradient(form, -direction((k + 0.5) * sector, 0.5 * reach), marks);
        }
        return true;
    }
    // That tangents in the ends of an arc meet there is true but for `blur`, which is far more than errors
    // and rounding.
    void add_apex(const Linear& f, const Linear& g, const Vector3d& apex, SphereMarks& marks) const {
        constexpr double blur = 0x1p-24;
        marks.places.push_back(
            {apex, f(apex) + 2 * std::max(f.error, g.error) + (f.slope + steepest_) * blur});
    }

    // Adds the apexes of the parts of an arc of any length.
    void add_parts(Index e, SphereMarks& marks) const {
        constexpr double most_angle = std::numbers::pi / 3;
        const auto arc = long_arc(e);
        marks.are_all = arc.has_value();
        if (!marks.are_all) return;
        const Linear &f = forms_[left(2 * e)], &g = forms_[right(2 * e)];
        const int parts = static_cast<int>(arc->angle / most_angle) + 1;
        const double half = 0.5 * arc->angle / parts, reach = 1 / std::cos(half);
        for (int i = 0; i < parts; ++i) {
            const double turn = (2 * i + 1) * half;
            add_apex(f, g, arc->center + reach * (std::cos(turn) * arc->from + std::sin(turn) * arc->across),
                     marks);
        }
    }

    void add_rival(Index face) {
        if (std::exchange(faces_[face].stamp, stamp_) != stamp_) rivals_.push_back(face);
    }
    // The faces about vertices where the challenger wins; if there are none, all, unless it is beaten.
    bool find_rivals(const Linear& form, bool& is_beaten) {
        is_beaten = form.e - form.slope - form.error > top_;
        if (is_beaten) return true;
        const bool is_decided = vertex_rows_.search(form, [&](Index i) {
            Vertex& v = vertices_[i];
            if (v.is_below(form)) return true;
            if (!decide(v, form)) return false;
            for (const Index f : v.forms) add_rival(f);
            return true;
        });
        if (!is_decided) return false;
        if (!rivals_.empty()) return true;
        is_beaten = is_beaten_on_edges(form);
        for (const Index f : is_beaten&& is_flatter(form) ? wide_faces_ : alive_faces_)
            if (!(is_beaten && is_beaten_in(form, f))) add_rival(f);
        is_beaten = rivals_.empty();
        if (is_beaten && !is_top_known_) set_top();
        return true;
    }
    // Does the form grow towards the pole of each face that lies in its hemisphere, even with |b| |rival.b|
    // in place of grows_to_pole()'s product? Slopes are rounded up, squares down.
    bool is_flatter(const Linear& form) {
        if (!is_flattest_known_) {
            is_flattest_known_ = true;
            flattest_ = HUGE_VAL;
            wide_faces_.clear();
            for (const Index f : alive_faces_) {
                const Linear& rival = forms_[f];
                if (is_in_hemisphere(f))
                    flattest_ = std::min(flattest_, rival.square / rival.slope - rival.error);
                else
                    wide_faces_.push_back(f);
            }
        }
        return (form.slope + form.error) * (1 + slack) < flattest_;
    }
    bool is_beaten_on_edges(const Linear& form) {
        return apex_rows_.search(form, [&](Index e) {
            const Edge& edge = edges_[e];
            return edge.is_point || is_beside(edge, false, form) ||
                   look_between(e, false, form) == Middle::Same;
        });
    }
    // A bound on the diagram from above: forms are highest where faces end, or opposite to where they are
    // lowest.
    void set_top() {
        is_top_known_ = true;
        for (const Index f : alive_faces_)
            if (!is_in_hemisphere(f)) return;
        double top = -HUGE_VAL;
        for (const Vertex& v : vertices_) top = std::max(top, v.level);
        for (const Edge& edge : edges_) top = std::max(top, edge.apex.level);
        top_ = top;
    }
    bool find_rivals_in_trees(const Linear& form) {
        const bool is_decided = vertex_tree_->search(form, vertices_, [&](Index v) {
            if (!decide(vertices_[v], form)) return false;
            for (const Index f : vertices_[v].forms) add_rival(f);
            return true;
        });
        if (!is_decided) return false;
        if (!rivals_.empty()) return true;
        for (const Index f : new_faces_) {
            if (faces_[f].start == none) continue;
            set_ball(f);
            face_tree_->add(f, faces_[f].ball, faces_[f].top);
        }
        new_faces_.clear();
        face_tree_->search(
            form, [&](Index f) { return faces_[f].start == none ? nullptr : &faces_[f].ball; },
            [&](Index f) { return faces_[f].top; },
            [&](Index f) {
                if (faces_[f].start == none) return;
                if (!faces_[f].is_ball_known) set_ball(f);
                if (may_conflict(form, f)) add_rival(f);
            });
        return true;
    }
    // May the form be lower than the face's somewhere in the face?
    bool may_conflict(const Linear& form, Index face) const {
        const Face& f = faces_[face];
        const Linear& rival = forms_[face];
        const Vector3d gradient = form.b - rival.b;
        return f.cap.least(gradient, gradient.norm() * (1 + slack)) + form.e - rival.e <=
               form.error + rival.error;
    }

    struct Cut {
        Index face;
        Index leaving, returning;  // the half-edges of the face where the challenger starts and ceases to win
    };
    // Compares challenger and face along the face's boundary; false where that is no common case. Adds the
    // neighbours that the challenger reaches from here.
    bool challenge(const Linear& form, Index face) {
        Cut c{face, none, none};
        int crossings = 0;
        Index h = faces_[face].start;
        if (!is_decided(vertices_[half_edges_[h].origin], form)) return false;
        do {
            Vertex& to = vertices_[target(h)];
            if (!is_decided(to, form)) return false;
            const bool is_from_taken = is_taken(vertices_[half_edges_[h].origin]);
            bool is_crossed = is_from_taken != is_taken(to);
            Edge& edge = edges_[h >> 1];
            if (!is_crossed && !edge.is_point && !is_beside(edge, is_from_taken, form) &&
                edge.stamp != stamp_) {
                edge.stamp = stamp_;
                Middle middle = look_between(h >> 1, is_from_taken, form);
                if (middle == Middle::Unknown && !is_from_taken && ties_along(h >> 1, form))
                    middle = Middle::Same;
                if (middle == Middle::Unknown) return false;
                is_crossed = middle == Middle::Differs;
                if (is_crossed) put_middle(h);
            }
            if (is_crossed) {
                ++crossings;
                (is_from_taken ? c.returning : c.leaving) = h;
            }
            if (is_crossed || is_from_taken) add_rival(right(h));
            h = half_edges_[h].next;
        } while (h != faces_[face].start);
        if (crossings > 2) return false;
        if (crossings == 2)
            cuts_.push_back(c);
        else if (is_taken(vertices_[half_edges_[h].origin]))
            swallowed_.push_back(face);
        return true;
    }
    // Does the challenger win or lose all of a face whose boundary it does not cross? It does unless the
    // circle where both tie lies within the face.
    bool is_within(const Linear& form, Index face) {
        const Linear& rival = forms_[face];
        ++decisions_.by_double;
        const bool is_lost = is_taken(vertices_[half_edges_[faces_[face].start].origin]);
        const Vector3d gradient = form.b - rival.b;
        const double slope = gradient.norm(), offset = form.e - rival.e, side = is_lost ? 1 : -1;
        return side * offset + slope < -(form.error + rival.error) ||
               is_outside(face, side / slope * gradient);
    }
    // Of a form that is beaten on the face's boundary: in the face, too?
    bool is_beaten_in(const Linear& form, Index face) {
        return (grows_to_pole(form, forms_[face]) && is_in_hemisphere(face)) || is_within(form, face);
    }
    // Compares form and diagram at the vertex. False where a form that is not the family's is too near.
    bool decide(Vertex& v, const Linear& form) {
        v.stamp = stamp_;
        ++decisions_.by_double;
        if (v.is_below(form)) return true;
        v.taken = stamp_;
        return v.is_above(form) || decide_exactly(v, form);
    }
    [[gnu::noinline]] bool decide_exactly(Vertex& v, const Linear& form) {
        --decisions_.by_double;
        const auto challenger = static_cast<Index>(&form - forms_.data());
        const auto sign = exact_sign(v, challenger);
        if (sign != Sign::Negative) v.taken = 0;
        if (sign == Sign::Zero) {
            add_tie(v.ties, challenger);
            if (is_point_asked_) {
                ties_[v.ties].point = point_;
                ties_[v.ties].generation = generation_;
            }
        }
        return sign.has_value();
    }
    // Does the challenger tie along the edge, and so on its whole circle? Then that is kept with the edge.
    [[gnu::noinline]] bool ties_along(Index e, const Linear& form) {
        const auto challenger = static_cast<Index>(&form - forms_.data());
        if (are_on_one_circle(left(2 * e), right(2 * e), challenger) != true) return false;
        add_tie(edges_[e].ties, challenger);
        return true;
    }
    // Without a tree all vertices have been compared.
    bool is_decided(Vertex& v, const Linear& form) {
        return !vertex_tree_ || v.stamp == stamp_ || decide(v, form);
    }
    bool is_taken(const Vertex& v) const { return v.taken == stamp_; }
    // Of an edge in both ends of which challenger - rival has one sign: so in the whole triangle about the
    // arc?
    static bool is_beside(const Edge& edge, bool is_taken, const Linear& form) {
        return is_taken ? edge.apex.is_above(form) : edge.apex.is_below(form);
    }
    enum class Middle { Same, Differs, Unknown };
    // Challenger - rival has one sign in both ends of an edge: does it have the other one in between? Then
    // middle_ is where it has most of it.
    Middle look_between(Index e, bool is_taken, const Linear& form) {
        ++decisions_.by_double;
        const Edge& edge = edges_[e];
        const Vertex &p = vertices_[half_edges_[2 * e].origin], &q = vertices_[half_edges_[2 * e + 1].origin];
        const Linear& rival = forms_[left(2 * e)];
        const Vector3d gradient = form.b - rival.b;
        const double sign = is_taken ? -1 : 1, offset = form.e - rival.e, error = form.error + rival.error,
                     slope = gradient.norm(), end_error = std::max(p.error, q.error);
        // All around the circle it is a sinusoid plus a constant.
        const double length = edge.length, along = gradient.dot(edge.normal) / edge.square;
        const double at_center = along * edge.offset + offset;
        const Vector3d across = gradient - along * edge.normal;
        const double radius2 = 1 - edge.offset * edge.offset / edge.square;
        if (!(radius2 > least_square) || !is_well_known(edge)) return Middle::Unknown;
        const double steepness = across.norm(), radius = std::sqrt(radius2);
        // The centre's value moves by 2 e of the slope, the circle's highest by R's 32 e more.
        const double doubt = 4 * error + slope * (64 * edge.error / length + slack);
        const double extreme = sign * at_center - steepness * radius;
        if (extreme > doubt) return Middle::Same;
        // Less steep along the circle, a form has its extreme anywhere on it, for doubles.
        constexpr double least_steepness = 0x1p-20;
        if (!(extreme < -doubt) || !(steepness > least_steepness * slope)) return Middle::Unknown;
        const Vector3d center = edge.offset / edge.square * edge.normal;
        middle_ = center - sign * radius / steepness * across;
        // n.(a x b) for two points seen from the centre: each end is off by its error, the centre counts
        // across n only, e times |a - b| <= 2, and n itself by dn R^2.
        const double turn_doubt =
            length * (2 * end_error + slack) + 4 * edge.error + length * radius * doubt / steepness;
        const auto turn = [&](const Vector3d& a, const Vector3d& b) {
            const double value = edge.normal.dot(a.cross(b));
            return std::abs(value) > turn_doubt ? sign_of(value) : Sign::Zero;
        };
        // Of an arc of less than half a turn, or of the rest of the circle.
        const Sign size = turn(p.p - center, q.p - center);
        if (size == Sign::Zero) return Middle::Unknown;
        const Sign after_start = size * turn(p.p - center, middle_ - center),
                   before_end = size * turn(middle_ - center, q.p - center);
        if (after_start == Sign::Negative || before_end == Sign::Negative)
            return size == Sign::Positive ? Middle::Same : Middle::Differs;
        if (after_start == Sign::Zero || before_end == Sign::Zero) return Middle::Unknown;
        return size == Sign::Positive ? Middle::Differs : Middle::Same;
    }

    // --- Cuts

    // Puts a vertex at middle_ on the edge of h, until the challenger is inserted. h stays the first part.
    void put_middle(Index h) {
        const Index from = half_edges_[h].origin;
        Vertex middle;
        middle.p = middle_;
        middle.stamp = stamp_;
        middle.taken = is_taken(vertices_[from]) ? 0 : stamp_;
        const Index v = add(vertices_, free_vertices_, middle);
        const Index e = add_edge(edges_[h >> 1]);
        // Both parts lie on the old curve in the old direction.
        split(h, v, 2 * e + (h & 1u));
        if (!is_taken(vertices_[v])) middles_.push_back(h);
    }
    // Undoes that where the middle is left.
    void remove_middle(Index h) {
        const Index second = next(h);
        remove_vertex(half_edges_[second].origin);
        join(h);
        remove_edge(second >> 1);
    }
    // Where a half-edge of the face passes from the face to the challenger: there face, face on the right and
    // challenger follow each other counter-clockwise.
    bool add_vertex(Index challenger, const Cut& c) {
        const auto vertex = meet(c.face, right(c.leaving), challenger);
        if (!vertex) return false;
        ++decisions_.by_double;
        const Index v = add(vertices_, free_vertices_, *vertex);
        if (!vertex_tree_) vertex_rows_.set(v, *vertex);
        edges_[c.leaving >> 1].cut = v;
        return true;
    }
    // The challenger's half-edge along the cut waits at the point where the boundary returns to the face.
    void cut(Index challenger, const Cut& c) {
        const Index from = edges_[c.leaving >> 1].cut, to = edges_[c.returning >> 1].cut;
        const Index e = add_edge({});
        half_edges_[2 * e] = {c.returning, c.leaving, from, c.face};
        half_edges_[2 * e + 1] = {none, none, to, challenger};
        half_edges_[twin(c.leaving)].origin = from;
        half_edges_[c.returning].origin = to;
        half_edges_[c.leaving].next = half_edges_[c.returning].prev = 2 * e;
        vertices_[to].out = 2 * e + 1;
        faces_[c.face].start = 2 * e;
        set_curve(e);
        new_edges_.push_back(e);
    }
    // Is what the challenger has won one disc?
    bool close(Index challenger) {
        for (const Index e : new_edges_) link(2 * e + 1, vertices_[half_edges_[2 * e].origin].out);
        const Index start = 2 * new_edges_.front() + 1;
        std::size_t length = 0;
        Index h = start;
        do {
            ++length;
            h = half_edges_[h].next;
        } while (h != start);
        if (length != new_edges_.size()) return false;
        faces_[challenger].start = start;
        for (const Index e : new_edges_) set_arc(e);
        for (const Cut& c : cuts_) {
            // Of the parts of an edge that was crossed twice one is no more.
            if (!edges_[c.leaving >> 1].apex.is_gone()) set_arc(c.leaving >> 1);
            faces_[c.face].is_hemisphere_known = faces_[c.face].is_in_hemisphere;
            faces_[c.face].is_ball_known = false;
        }
        if (vertex_tree_) {
            for (const Index e : new_edges_) vertex_tree_->add(half_edges_[2 * e].origin, vertices_);
            new_faces_.push_back(challenger);
        } else if (alive_faces_.size() > largest_small) {
            plant_trees();
        }
        return true;
    }
    void plant_trees() {
        vertex_tree_.emplace();
        face_tree_.emplace();
        for (Index v = 0; v < vertices_.size(); ++v)
            if (!vertices_[v].is_gone()) vertex_tree_->add(v, vertices_);
        new_faces_ = alive_faces_;
    }

    double top_ = HUGE_VAL;  // the diagram is nowhere higher
    bool is_top_known_ = false;
    double flattest_ = 0;  // forms of less slope grow towards the poles of all faces but these
    SomeIndices wide_faces_;
    bool is_flattest_known_ = false;
    SomeIndices new_faces_;  // not in the tree yet
    Index stamp_ = 0;
    // Working space of insert().
    SomeIndices rivals_, swallowed_, new_edges_;
    SomeIndices middles_;  // half-edges that end at a vertex made by put_middle() that is not taken
    SmallVector<Cut, 32> cuts_;
    Vector3d middle_;
};

}  // namespace vcell::discs
