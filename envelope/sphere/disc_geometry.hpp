/// Where linear forms on the sphere tie, in doubles with bounds on their errors: circles, arcs, vertices, and
/// what is certainly true of a face; and in exact numbers what these cannot tell.
///
/// Bounds on rounding. Where k operations of relative error u = 2^-53 follow each other, k < 128, their
/// product is within k u (1 + 2^-45) of 1 [Higham02, Lemma 3.1]: a constant that is a tenth above its count
/// of roundings covers all orders. Of a circle n.p = o with radius R the coefficients are off by dn and do,
/// |dn|
/// + |do| <= error (the largest value of dn.p - do on the sphere), and it is used only where error < 2^-20
/// |n| and R^2 > 2^-10. With e = error / |n| the offset o / |n| is then off by e, the centre by 2 e, of that
/// at most e across n, and R^2 by 2 e, R by 32 e; what is left of second order is less than a hundredth of
/// that.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "../../arrangement/circles/circle_kernel.hpp"
#include "../../core/solver/newton/kantorovich.hpp"
#include "../../primitives/forms/form_family.hpp"
#include "disc_mesh.hpp"
#include "sphere_diagram.hpp"

namespace vcell::discs {

using roundoff::u;
// Radii of circles are roots of differences: of smaller ones rounding leaves too little.
inline constexpr double least_square = 0x1p-10;

// Coefficients within 4 u, products and quotients make 10 u of each of their terms and 12 u of both terms of
// a sum; e and k are in two coefficients; the rest is for evaluation.
inline Linear linear(const CircularForm& f) {
    const double scale = 0.5 / f.w, across = std::abs(f.a) + std::abs(f.b),
                 along = std::abs(f.e) + std::abs(f.k);
    return Linear(scale * Vector3d(f.a, f.b, f.e - f.k), scale * (f.e + f.k),
                  u * scale * (16 * across + 32 * along));
}

class DiscGeometry : protected DiscMesh {
protected:
    explicit DiscGeometry(const FormFamily& family, const TiePredicates& ties = {})
        : family_(family), predicates_(ties) {}

    void set_curve(Index e) {
        const Linear &f = forms_[left(2 * e)], &g = forms_[right(2 * e)];
        Edge& edge = edges_[e];
        edge.normal = g.b - f.b;
        edge.offset = f.e - g.e;
        edge.square = edge.normal.squaredNorm();
        edge.length = std::sqrt(edge.square);
        edge.error = f.error + g.error;
        edge.apex_blur = 1024 * edge.error / edge.length + 4 * slack;
    }
    static bool is_well_known(const Edge& edge) { return 0x1p20 * edge.error < edge.length; }
    void set_arc(Index e) {
        find_arc(e);
        if (!vertex_tree_) apex_rows_.set(e, edges_[e].apex);
    }
    void find_arc(Index e) {
        Edge& edge = edges_[e];
        const Vertex &p = vertices_[half_edges_[2 * e].origin], &q = vertices_[half_edges_[2 * e + 1].origin];
        const Linear &f = forms_[left(2 * e)], &g = forms_[right(2 * e)];
        edge.apex = Mark();
        edge.apex.doubt = edge.apex.level = HUGE_VAL;
        edge.is_point = false;
        const double radius2 = 1 - edge.offset * edge.offset / edge.square;
        if (!(radius2 > least_square) || !is_well_known(edge)) return;
        // Certainly less than half a turn?
        if (!(edge.normal.dot(p.p.cross(q.p)) >
              edge.length * (2 * (p.error + q.error) + slack) + 4 * edge.error))
            return set_short_arc(e);
        const Vector3d center = edge.offset / edge.square * edge.normal,
                       middle = 0.5 * (p.p + q.p) - center;  // of the chord
        const double depth2 = middle.squaredNorm();
        // Up to a third of a turn the apex is at most twice the radius away: R^2 < 4 |m|^2, m = middle, so
        // |m| > 2^-6. m -> R^2 m / |m|^2 is an inversion: it takes a change d of m to one of R^2 |d| / (|m|
        // |m + d|) < 8 |d| for |d| < |m| / 2. From the ends |d| is half the sum of their errors, from the
        // centre 2 e; and R^2 itself changes the apex by 2 e / |m| < 128 e, the centre by 2 e. Together 4
        // times the ends' errors and less than 150 e.
        constexpr double most_change = 0x1p-7;  // |m| / 2
        if (!(radius2 < 4 * depth2) || !(p.error + q.error < most_change)) return;
        edge.apex.p = center + radius2 / depth2 * middle;
        edge.apex.error = edge.apex_blur + 32 * (p.error + q.error);
        edge.apex.height = f(edge.apex.p);
        edge.apex.doubt = 2 * std::max(f.error, g.error) + f.slope * edge.apex.error;
        edge.apex.set_level(steepest_);
    }
    // Marks an arc whose ends are too near to each other to tell how it runs, unless it seems to be the rest
    // of the circle: the point opposite to its ends would be on it. Otherwise it lies in a ball about its
    // ends.
    void set_short_arc(Index e) {
        constexpr double near = 0x1p-20;
        Edge& edge = edges_[e];
        const Vertex &p = vertices_[half_edges_[2 * e].origin], &q = vertices_[half_edges_[2 * e + 1].origin];
        const double chord = (p.p - q.p).norm() + p.error + q.error;
        if (!(chord < near * std::sqrt(1 - edge.offset * edge.offset / edge.square))) return;
        const Index face = left(2 * e);
        const double blur = p.error + 64 * edge.error / edge.length + slack;
        if (!is_beaten_at(face, 2 * edge.offset / edge.square * edge.normal - p.p, blur)) return;
        const Linear &f = forms_[face], &g = forms_[right(2 * e)];
        edge.apex.p = 0.5 * (p.p + q.p);
        edge.apex.error = 2 * chord + slack;
        edge.apex.height = f(edge.apex.p);
        edge.apex.doubt = 2 * std::max(f.error, g.error) + f.slope * edge.apex.error;
        edge.apex.set_level(steepest_);
        edge.is_point = are_one_point(p, q).value_or(false);
        has_points_ = has_points_ || edge.is_point;
    }
    // Where three forms tie; of the two points the one where f, g, h follow each other counter-clockwise.
    // None where doubles cannot tell.
    //
    // Newton-Kantorovich: the residuals of (g - f, h - f, (|p|^2 - 1) / 2) and the inverse Jacobian bound the
    // step; the only second derivative is that of |p|^2 / 2, the identity.
    std::optional<Vertex> meet(Index f, Index g, Index h) const {
        const Linear &F = forms_[f], &G = forms_[g], &H = forms_[h];
        const Vector3d m = G.b - F.b, n = H.b - F.b, along = m.cross(n);
        const double c = F.e - G.e, d = F.e - H.e, square = along.squaredNorm();
        const Vector3d nearest = (c * n.cross(along) + d * along.cross(m)) / square;
        const double rest = 1 - nearest.squaredNorm();
        if (!(rest > 0)) return std::nullopt;
        Vector3d p = nearest + std::sqrt(rest / square) * along;
        const double m_error = F.error + G.error, n_error = F.error + H.error;
        const double m_length = m.norm() * (1 + slack), n_length = n.norm() * (1 + slack),
                     length = std::sqrt(square);
        for (const bool last : {false, true}) {
            const double r = m.dot(p) - c, s = n.dot(p) - d, t = 0.5 * (p.squaredNorm() - 1),
                         det = along.dot(p);
            // A step gains nothing where the coefficients' errors matter more.
            const bool is_near = std::abs(r) <= m_error && std::abs(s) <= n_error && std::abs(t) <= 8 * u;
            if (!last && !is_near) {
                p -= (r * n.cross(p) + s * p.cross(m) + t * along) / det;
                continue;
            }
            // The Jacobian's own error changes its inverse by a hundredth at most.
            if (!(det > 128 * (m_error * n_length + n_error * m_length))) return std::nullopt;
            const double step = 1.02 *
                                ((std::abs(r) + m_error) * n_length + (std::abs(s) + n_error) * m_length +
                                 (std::abs(t) + 8 * u) * length) /
                                det;
            const auto radius = kantorovich_radius(step, 1.02 * length / det);
            if (!radius) return std::nullopt;
            Vertex vertex;
            vertex.p = p;
            vertex.error = *radius;
            set_forms(vertex, {f, g, h});
            return vertex;
        }
        return std::nullopt;
    }
    void set_forms(Vertex& v, const std::array<Index, 3>& forms) const {
        v.forms = forms;
        const Linear* best = &forms_[forms[0]];
        for (const Index f : forms)
            if (forms_[f].error < best->error) best = &forms_[f];
        v.height = (*best)(v.p);
        v.doubt = best->error + best->slope * v.error;
        v.set_level(steepest_);
    }
    // An enclosing ball, if there is a smaller one than now. Around vertices and apexes, so that it holds the
    // boundary. The face is the part within unless it contains the opposite point of the sphere.
    void set_ball(Index face) {
        Face& f = faces_[face];
        const Linear& form = forms_[face];
        Vector3d center = Vector3d::Zero();
        double count = 0, top = -HUGE_VAL;
        for_boundary(face, [&](Index h) {
            const Vertex& v = vertices_[half_edges_[h].origin];
            const Mark& apex = edges_[h >> 1].apex;
            center += v.p;
            ++count;
            top = std::max({top, v.level, apex.level});
        });
        // The form is highest on the boundary, unless the face holds the point where it is highest anywhere.
        f.is_ball_known = true;
        f.top =
            top < f.top && is_in_hemisphere(face) ? top : std::min(f.top, form.e + form.slope + form.error);
        if (top == HUGE_VAL) return;
        center /= count;
        double square = 0, error = 0;
        for_boundary(face, [&](Index h) {
            const Vertex& v = vertices_[half_edges_[h].origin];
            const Mark& apex = edges_[h >> 1].apex;
            square = std::max({square, (v.p - center).squaredNorm(), (apex.p - center).squaredNorm()});
            error = std::max({error, v.error, apex.error});
        });
        const double radius = std::sqrt(square) + error + slack;
        if (!(radius < f.ball.radius)) return;
        const double length = center.norm();
        constexpr double least_length =
            0x1p-10;  // whose direction is known well; nearer ones keep their ball
        if (!(length > least_length && radius < 1 + length && is_outside(face, center / -length))) return;
        f.ball = {center, radius};
        f.cap.shrink_to(f.ball);
    }
    // Is the point of the sphere certainly not in the face: too far away, or another form is lower there? The
    // neighbours come first; but where three of them win may be more than one region, and the face is just
    // one of those.
    bool is_outside(Index face, const Vector3d& p) const {
        const Face& f = faces_[face];
        if ((p - f.ball.center).squaredNorm() > f.ball.radius * f.ball.radius * (1 + slack)) return true;
        return is_beaten_at(face, p, 0);
    }
    // Is another form certainly lower than the face's all over a ball about the point of the sphere?
    bool is_beaten_at(Index face, const Vector3d& p, double radius) const {
        const Face& f = faces_[face];
        const Linear& form = forms_[face];
        const double value = form(p);
        const auto is_lower = [&](const Linear& other) {
            return value - other(p) > form.error + other.error + radius * (form.slope + other.slope);
        };
        Index h = f.start;
        do {
            if (is_lower(forms_[right(h)])) return true;
            h = half_edges_[h].next;
        } while (h != f.start);
        for (Index g = 0; g < faces_.size(); ++g)
            if (faces_[g].start != none && is_lower(forms_[g])) return true;
        return false;
    }
    // Does form - rival certainly grow towards where the rival is lowest?
    static bool grows_to_pole(const Linear& form, const Linear& rival) {
        return form.b[0] * rival.b[0] + form.b[1] * rival.b[1] + form.b[2] * rival.b[2] <
               rival.square - (form.error + rival.error) * rival.slope;
    }
    // Does the face lie in the hemisphere about the point where its form is lowest? Then it does so for ever.
    bool is_in_hemisphere(Index face) {
        Face& f = faces_[face];
        if (!f.is_hemisphere_known) {
            f.is_hemisphere_known = true;
            f.is_in_hemisphere = find_in_hemisphere(face);
        }
        return f.is_in_hemisphere;
    }
    [[gnu::noinline]] bool find_in_hemisphere(Index face) const {
        const Linear& form = forms_[face];
        const auto is_before = [&](const Mark& x) {
            return form.b.dot(x.p) < -(x.error + 2 * slack) * form.slope;
        };
        Index h = faces_[face].start;
        do {
            const Mark& apex = edges_[h >> 1].apex;
            if (apex.doubt == HUGE_VAL || !is_before(apex) || !is_before(vertices_[half_edges_[h].origin]))
                return false;
            h = half_edges_[h].next;
        } while (h != faces_[face].start);
        return is_outside(face, form.b.normalized());
    }

    // --- Exact numbers

    static constexpr std::size_t most_points = 4096;  // kept by the kernel, each of some kilobytes

    // What ties in a vertex or along an edge and came later.
    struct Ties {
        std::vector<Index> forms;
        // What the kernel calls the vertex, as long as it keeps it:
        PointId point;
        Index generation = 0;  // 0: it has not been asked
    };

    // Are both ends exactly one point? None where there are no exact numbers, of forms that are not the
    // family's. The three forms of the end P with the larger error tie in two points, 2 det / length apart,
    // which meet() has seen to be more than 12 times that error; and if all three tie in the other end, too,
    // that is one of them, within 4 errors of P.
    // So they are, then, if the forms of one end are all known to tie in the other, which is known no worse
    // than 4 times as well: its point is within 10 errors of P.
    std::optional<bool> are_one_point(const Vertex& p, const Vertex& q) {
        if ((p.p - q.p).norm() > p.error + q.error + slack) return false;
        if (all_tie(q.forms, p, q.error) || all_tie(p.forms, q, p.error)) return true;
        const bool is_p = p.error >= q.error;
        const Vertex &blurred = is_p ? p : q, &sharp = is_p ? q : p;
        for (const Index f : blurred.forms) {
            if (std::ranges::find(sharp.forms, f) != sharp.forms.end()) continue;
            const auto sign = exact_sign(sharp, f);
            return sign ? std::optional(*sign == Sign::Zero) : std::nullopt;
        }
        return std::nullopt;
    }
    // Do all the forms tie in the vertex, as far as has been asked, and is it known to 4 times the error?
    bool all_tie(const std::array<Index, 3>& forms, const Vertex& v, double error) const {
        if (v.ties == none || !(v.error <= 4 * error)) return false;
        const std::vector<Index>& ties = ties_[v.ties].forms;
        return std::ranges::all_of(forms, [&](Index f) {
            return std::ranges::find(v.forms, f) != v.forms.end() || std::ranges::find(ties, f) != ties.end();
        });
    }
    // The sign of the challenger less the forms that tie in the vertex; none if no exact point is at hand.
    std::optional<Sign> exact_sign(const Vertex& v, Index challenger) {
        if (std::max(challenger, std::ranges::max(v.forms)) >= family_.size()) return std::nullopt;
        is_point_asked_ = false;
        if (predicates_.sign && std::abs(v.height) > v.doubt) {
            const auto sign = predicates_.sign(FormId{challenger},
                                               {FormId{v.forms[0]}, FormId{v.forms[1]}, FormId{v.forms[2]}},
                                               sign_of(v.height));
            if (sign) {
                ++decisions_.by_exact;
                return sign;
            }
        }
        is_point_asked_ = true;
        const auto point = exact_point(v);
        if (!point) return std::nullopt;
        point_ = *point;
        return kernel_.sign_at(point_, in_kernel(challenger), in_kernel(v.forms[0]));
    }
    // The kernel's point in the vertex: one of two where the forms tie, told apart by the turn of their
    // gradients. The chart shows the sphere as it is seen from outside. Kept where others have tied before.
    std::optional<PointId> exact_point(const Vertex& v) {
        if (kernel_.point_count() > most_points) forget_points();
        if (v.ties != none && ties_[v.ties].generation == generation_) return ties_[v.ties].point;
        const FormId f = in_kernel(v.forms[0]), g = in_kernel(v.forms[1]), h = in_kernel(v.forms[2]);
        const double above = std::max(1 + v.p.z(), 0x1p-20);  // the pole
        const auto point = kernel_.intersection({f, g}, {f, h}, Sign::Positive, v.p.head<2>() / above);
        if (!point) return std::nullopt;
        const KernelPoint& at = kernel_.point(*point);
        const double W = 1 + at.x * at.x + at.y * at.y;
        const Vector3d place(2 * at.x / W, 2 * at.y / W, 2 / W - 1);
        if (!((place - v.p).norm() <= 2 * v.error + 4 * at.error + slack)) return std::nullopt;
        return point;
    }
    // The form's number in the kernel, which keeps its exact coefficients.
    FormId in_kernel(Index form) {
        if (in_kernel_.empty()) {
            kernel_.reset(&family_);
            in_kernel_.resize(family_.size());
        }
        if (in_kernel_.size() < family_.size()) in_kernel_.resize(family_.size());
        FormId& number = in_kernel_[form];
        if (!number.valid()) number = kernel_.add_form(FormId{form});
        return number;
    }
    void forget_points() {
        in_kernel_.clear();
        kernel_.reset(&family_);
        ++generation_;
    }
    // Do f and g tie where f and h do? None where there are no exact numbers.
    std::optional<bool> are_on_one_circle(Index f, Index g, Index h) {
        if (std::max({f, g, h}) >= family_.size()) return std::nullopt;
        if (predicates_.along)
            if (const auto along = predicates_.along({FormId{f}, FormId{g}, FormId{h}})) {
                ++decisions_.by_exact;
                return along;
            }
        const FormId a = in_kernel(f), b = in_kernel(g), c = in_kernel(h);
        return kernel_.same_curve({a, b}, {a, c});
    }
    void add_tie(Index& list, Index challenger) {
        if (list == none) {
            list = static_cast<Index>(ties_.size());
            ties_.emplace_back();
        }
        ties_[list].forms.push_back(challenger);
        has_new_ties_ = true;
    }

    const FormFamily& family_;
    const TiePredicates predicates_;  // none: exact coefficients are asked for
    double steepest_ = 0;             // slope of forms
    std::vector<Linear> forms_;       // the family's, and some that are higher in the end
    bool has_points_ = false;         // among the edges
    std::vector<Ties> ties_;          // the lists of vertices and edges
    bool has_new_ties_ = false;       // since the challenger came
    Decisions decisions_;
    CircleKernel kernel_;            // decides what doubles cannot
    std::vector<FormId> in_kernel_;  // none: not there yet
    Index generation_ = 1;           // of the kernel's points
    PointId point_;                  // where exact_sign() was asked last
    bool is_point_asked_ = false;    // of the kernel: point_ is that point
};

}  // namespace vcell::discs
