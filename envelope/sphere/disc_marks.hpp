/// What a finished diagram of discs tells whoever searches for more forms: places at which a form that is
/// lower somewhere would be lower, too, or gradients that it would have (SphereMarks).
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "disc_insertion.hpp"
#include "sphere_diagram.hpp"

namespace vcell::discs {

class DiscMarks : protected DiscInsertion {
protected:
    using DiscInsertion::DiscInsertion;

    /// What all vertices, edges and faces tell, for whoever searches for more forms.
    SphereMarks marks() {
        SphereMarks marks;
        marks.steepest = steepest_;
        marks.places.reserve(vertices_.size() + edges_.size() + faces_.size());
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
            if (faces_[f].start == none || add_top(f, marks)) continue;
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

private:
    static void add_gradient(const Linear& form, const Vector3d& up, SphereMarks& marks) {
        marks.gradients.push_back({up, form.b.dot(up) - 2 * (form.error + slack * form.slope)});
    }
    // The top of the cone that touches the sphere along the rim of a cap about z, of at most a sixth of a
    // turn from there, that holds the face. Seen from the top, the cap lies before whatever its points span,
    // and no point of it behind another one: so the line from there through a point of the face meets what
    // the boundary spans in that point or beyond.
    bool add_top(Index face, SphereMarks& marks) const {
        Vector3d middle = Vector3d::Zero();
        for_boundary(face, [&](Index h) { middle += vertices_[half_edges_[h].origin].p; });
        const Vector3d z = middle.normalized();
        constexpr double least_cosine = 0.5 + 0x1p-10;
        const double cosine = least_on_boundary(face, z);
        // NaN where the middle has no direction.
        if (!(cosine > least_cosine && is_outside(face, -z))) return false;
        const Linear& form = forms_[face];
        add_apex(form, form, z / cosine, marks);
        return true;
    }
    // Lower bound of z.p over the face's boundary; minus infinity where an arc is not known. Pre: |z| = 1,
    // but for rounding.
    double least_on_boundary(Index face, const Vector3d& z) const {
        constexpr double margin = 0x1p-20;  // more than the parts' errors
        double least = HUGE_VAL;
        SphereMarks parts;
        for_boundary(face, [&](Index h) {
            const Vertex& v = vertices_[half_edges_[h].origin];
            const Mark& apex = edges_[h >> 1].apex;
            least = std::min(least, z.dot(v.p) - v.error);
            if (apex.doubt < HUGE_VAL)
                least = std::min(least, z.dot(apex.p) - apex.error);
            else
                add_parts(h >> 1, parts);
        });
        for (const auto& part : parts.places) least = std::min(least, z.dot(part.p));
        return parts.are_all ? least - margin : -HUGE_VAL;
    }
    // Where a form c wins in the face f, but nowhere on its boundary, c - f is negative in a cap within the
    // face, and least in the direction of f.b - c.b. That is no farther from f.b than the angle whose sine is
    // |c.b| / |f.b|; and nothing is there of a face that does not hold the direction of f.b, and ends farther
    // away.
    bool add_wide_face(Index face, SphereMarks& marks) const {
        const Linear& form = forms_[face];
        const Vector3d up = form.b.normalized();
        const double depth = std::max(0.0, -least_on_boundary(face, -up));
        if (!(depth < 1 && is_outside(face, up))) return false;
        marks.steepest =
            std::min(marks.steepest, std::sqrt((1 - depth * depth) * form.square) * (1 - slack) - form.error);
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
        marks.are_all = marks.are_all && arc;
        if (!arc) return;
        const Linear &f = forms_[left(2 * e)], &g = forms_[right(2 * e)];
        const int parts = static_cast<int>(arc->angle / most_angle) + 1;
        const double half = 0.5 * arc->angle / parts, reach = 1 / std::cos(half);
        for (int i = 0; i < parts; ++i) {
            const double turn = (2 * i + 1) * half;
            add_apex(f, g, arc->center + reach * (std::cos(turn) * arc->from + std::sin(turn) * arc->across),
                     marks);
        }
    }
};

}  // namespace vcell::discs
