// A form is inserted as the paper compares two surfaces [HE, section 2.1], but against the faces of the
// diagram so far that it may conflict with. What it takes away is known from signs at vertices and along
// edges, as long as no face is cut in more than two: circles meet in two points at most.
//
// The points of space where the new form c is the lowest are a convex polyhedron P, and it wins where P meets
// the sphere. That tells how far to look:
// - A part of P on the sphere that holds no vertex is the only one. It passes from face to face across edges
//   without running in circles, as faces are discs; so it has a last face f, next to g. There it is all of
//   c < f and c < g that lies in f, as three circles through two points leave nothing else, and what is left
//   without f has one face less. With one face it is a whole cap, and P lies in the half-space of that.
//   So, if c wins at any vertex, then in each part at one at least, and from those the faces that it
//   reaches are found across edges.
// - A short arc lies in the triangle of its ends and the point where its tangents there meet, and c - f is
//   linear: signs in the three corners tell that c wins nowhere on it.
// - A face f within a hemisphere lies above the convex hull of its boundary, seen along the axis to the pole.
//   So where c loses on the boundary and c - f does not fall towards the pole, c loses in the face, too. The
//   pole is where f is lowest, and a form that others have beaten is mostly flatter than f.
// A small diagram is looked through for vertices, a large one has a tree of them.
//
// A form that doubles cannot tell from a vertex is compared with it by the kernel of circles, exactly. The
// edges that this leaves may be too short to have a direction in doubles: they lie in a ball about their
// ends.
//
// Where it ties with the vertex it counts as the higher one. That is the diagram of forms of which each is
// raised by an infinitesimal that is beyond all multiples of those before: vertices have three edges still,
// and those in which more forms tie are several, joined by edges without length. Of these it is known exactly
// that both their ends are one point. In the end they are contracted, and the vertices have all their forms.
// Where the form ties along an edge it is higher there, too: it belongs to the edge's label. If it is lower
// on one side of the edge, the face there keeps a sliver of two edges on one circle. In the end slivers are
// contracted to edges, whose labels they join.
// A face that meets itself in such a point, and an edge that is closed there, are left to the general engine;
// so are forms that touch edges in a point, or tie inside faces.
//
// Bounds on rounding. Where k operations of relative error u = 2^-53 follow each other, k < 128, their
// product is within k u (1 + 2^-45) of 1 [Higham02, Lemma 3.1]: a constant that is a tenth above its count of
// roundings covers all orders. Of a circle n.p = o with radius R the coefficients are off by dn and do, |dn|
// + |do| <= error (the largest value of dn.p - do on the sphere), and it is used only where error < 2^-20 |n|
// and R^2 > 2^-10. With e = error / |n| the offset o / |n| is then off by e, the centre by 2 e, of that at
// most e across n, and R^2 by 2 e, R by 32 e; what is left of second order is less than a hundredth of that.
#include "sphere_diagram.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

#include "../../arrangement/circles/circle_kernel.hpp"
#include "../../core/small_vector.hpp"
#include "../../core/solver/newton/kantorovich.hpp"
#include "sphere_trees.hpp"

namespace vcell {

namespace {

using Eigen::Vector3d;
using namespace discs;
constexpr double u = std::numeric_limits<double>::epsilon() / 2;
// Radii of circles are roots of differences: of smaller ones rounding leaves too little.
constexpr double least_square = 0x1p-10;

// Coefficients within 4 u, products and quotients make 10 u of each of their terms and 12 u of both terms of
// a sum; e and k are in two coefficients; the rest is for evaluation.
Linear linear(const CircularForm& f) {
    const double scale = 0.5 / f.w, across = std::abs(f.a) + std::abs(f.b),
                 along = std::abs(f.e) + std::abs(f.k);
    return Linear(scale * Vector3d(f.a, f.b, f.e - f.k), scale * (f.e + f.k),
                  u * scale * (16 * across + 32 * along));
}

class DiscDiagram {
public:
    DiscDiagram(const FormFamily& family, const EnvelopeOptions& options)
        : family_(family), options_(options) {}

    std::optional<MinimizationDiagram> run(std::size_t attempt) {
        double least_slope = HUGE_VAL;
        forms_.reserve(family_.size() + 16);
        for (const CircularForm& f : family_.forms) {
            forms_.push_back(linear(f));
            least_slope = std::min(least_slope, forms_.back().slope);
            steepest_ = std::max(steepest_, forms_.back().slope);
        }
        const std::optional<Index> owner = owner_of_pole();
        if (!owner || !(least_slope > 0) || !std::isfinite(least_slope)) return std::nullopt;
        // In each direction a side of the box is nearer than sqrt(3) times the farthest side.
        if (!start(least_slope / 4, attempt < 2 ? 4 : attempt == 2 ? 8 : 16)) return std::nullopt;
        for (const auto& [place, form] : insertion_order(attempt)) {
            if (!insert(form)) return std::nullopt;
            ++inserted_;
            if (options_.progress && inserted_ % 1024 == 0)
                options_.progress(static_cast<double>(inserted_) / static_cast<double>(family_.size()));
        }
        for (Index f = static_cast<Index>(family_.size()); f < forms_.size(); ++f)
            if (faces_[f].start != none) return std::nullopt;
        return diagram(*owner);
    }

    std::size_t inserted() const { return inserted_; }

private:
    struct Vertex : Mark {
        std::array<Index, 3> forms{};
        Index out = none;   // while a form is inserted: the edge of its face that leaves here
        Index stamp = 0;    // current: compared with the challenger
        Index taken = 0;    // current: the challenger is lower
        Index ties = none;  // the list of forms that tie here and came later
    };
    struct HalfEdge {
        Index next, prev, origin, face;
    };
    // normal.p = offset on the circle; half-edge 2e runs counter-clockwise about the normal.
    struct Edge {
        Vector3d normal = Vector3d::Zero();
        double offset = 0, square = 0, length = 0;  // square and length: of the normal
        double error = 0;                           // as Linear's, of normal and offset
        double apex_blur = 0;                       // what that changes about the apex
        // Where the tangents in the ends of a short arc meet: with those ends a triangle about the arc. Of a
        // long arc there is infinite doubt.
        Mark apex;
        Index stamp = 0;
        Index cut = none;       // while a form is inserted that crosses the edge: its vertex there
        Index ties = none;      // the list of forms that tie along the circle and came later
        bool is_point = false;  // certainly: both ends are the same point, and all of the edge
    };
    struct Face {            // of the form of the same number
        Index start = none;  // none: the form has no face
        Index stamp = 0;     // current: may conflict with the challenger
        bool is_in_hemisphere = false, is_hemisphere_known = false;
        // For the tree:
        bool is_ball_known = false;  // since the face was cut
        Ball ball;                   // both hold the face
        Cap cap;
        double top = HUGE_VAL;  // upper bound of the form over the face
    };

    // What ties in a vertex or along an edge and came later.
    struct Ties {
        std::vector<Index> forms;
        // Of a vertex in the kernel, as long as the kernel keeps it:
        PointId point;
        Index generation = 0;
    };

    using SomeIndices = SmallVector<Index, 32>;

    static constexpr std::size_t most_spread = 8;     // forms that are to surround the base first
    static constexpr std::size_t largest_small = 96;  // faces of a diagram without a tree
    static constexpr std::size_t most_points = 4096;  // kept by the kernel, each of some kilobytes

    static Index twin(Index h) { return h ^ 1u; }
    Index target(Index h) const { return half_edges_[twin(h)].origin; }
    Index left(Index h) const { return half_edges_[h].face; }
    Index right(Index h) const { return half_edges_[twin(h)].face; }
    void link(Index first, Index second) {
        half_edges_[first].next = second;
        half_edges_[second].prev = first;
    }
    template <class Visit>
    void for_cycle(Index face, Visit&& visit) const {
        Index h = faces_[face].start;
        do {
            visit(h);
            h = half_edges_[h].next;
        } while (h != faces_[face].start);
    }

    // The chart's pole is (0, 0, -1).
    std::optional<Index> owner_of_pole() const {
        const Vector3d pole(0, 0, -1);
        Index best = 0;
        for (Index f = 1; f < forms_.size(); ++f)
            if (forms_[f](pole) < forms_[best](pole)) best = f;
        for (Index f = 0; f < forms_.size(); ++f)
            if (f != best && !(forms_[f](pole) - forms_[best](pole) > forms_[f].error + forms_[best].error))
                return std::nullopt;
        return best;
    }

    // Lowest first, so that others are soon seen to lose; but before them some of the lowest that lie in all
    // directions, as faces that reach around the sphere are easily cut in two. Which of those is the first is
    // the choice that each attempt makes anew.
    using Order = std::vector<std::pair<double, Index>>;
    Order insertion_order(std::size_t attempt) const {
        Order order;
        order.reserve(family_.size());
        for (Index f = 0; f < family_.size(); ++f) order.emplace_back(forms_[f].e - forms_[f].slope, f);
        std::ranges::sort(order);
        const std::size_t spread = attempt == 0 ? 4 : most_spread;
        const std::size_t low = std::min<std::size_t>(order.size(), 4 * spread);
        std::swap(order[0], order[attempt % low]);
        std::array<Vector3d, 4 * most_spread> direction;
        std::array<double, 4 * most_spread>
            nearness;  // greatest cosine of the angle to a direction that was taken
        for (std::size_t i = 0; i < low; ++i) {
            const Linear& form = forms_[order[i].second];
            direction[i] = form.b / form.slope;
            nearness[i] = -1;
        }
        for (std::size_t taken = 0; taken + 1 < std::min(spread, low); ++taken) {
            std::size_t farthest = taken + 1;
            for (std::size_t i = taken + 1; i < low; ++i) {
                nearness[i] = std::max(nearness[i], direction[i].dot(direction[taken]));
                if (nearness[i] < nearness[farthest]) farthest = i;
            }
            std::swap(order[taken + 1], order[farthest]);
            std::swap(direction[taken + 1], direction[farthest]);
            std::swap(nearness[taken + 1], nearness[farthest]);
        }
        // In rounds that double the diagram, each on a path from neighbour to neighbour, whose faces and
        // vertices then are at hand.
        for (std::size_t begin = 64; begin < order.size(); begin *= 2) {
            const std::size_t end = std::min(2 * begin, order.size());
            for (std::size_t i = begin; i < end; ++i) order[i].first = place_on_path(forms_[order[i].second]);
            std::sort(order.begin() + begin, order.begin() + end);
        }
        return order;
    }

    // Of the direction in which the form is lowest, on a path through an octree (Morton's).
    static double place_on_path(const Linear& form) {
        // Ten bits of a coordinate, each followed by two zeros.
        const auto spread = [&](int k) {
            auto x = static_cast<std::uint32_t>(512 * (1 - form.b[k] / form.slope)) & 0x3ffu;
            x = (x | x << 16) & 0x30000ffu;
            x = (x | x << 8) & 0x300f00fu;
            x = (x | x << 4) & 0x30c30c3u;
            return (x | x << 2) & 0x9249249u;
        };
        return 4 * spread(0) + 2 * spread(1) + spread(2);
    }

    // Forms that lose in the end, so high are they: -slope t.p for points t of the sphere that no input
    // favours. The first four are the corners of a tetrahedron.
    bool start(double slope, Index count) {
        static const Eigen::Matrix3d turn =
            (Eigen::AngleAxisd(0.7131, Vector3d::UnitX()) * Eigen::AngleAxisd(1.9277, Vector3d::UnitZ()))
                .toRotationMatrix();
        const std::array<Vector3d, 4> corners{{{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}}};
        const auto first = static_cast<Index>(forms_.size());
        for (const Vector3d& t : corners) {
            const Vector3d direction = turn * t.normalized();
            forms_.push_back(Linear(-slope * direction, 0, 16 * u * slope));
            Vertex vertex;
            vertex.p = -direction;
            vertex.error = 16 * u;
            vertices_.push_back(vertex);
        }
        for (Index i = 0; i < 4; ++i) {
            set_forms(vertices_[i], {first + (i + 1) % 4, first + (i + 2) % 4, first + (i + 3) % 4});
            vertex_rows_.set(i, vertices_[i]);
        }
        // The others on a spiral.
        for (Index i = 4; i < count; ++i) {
            const double z = 1 - (2 * i - 7.0) / (count - 4), angle = 2.4 * i, r = std::sqrt(1 - z * z);
            const Vector3d direction = turn * Vector3d(r * std::cos(angle), r * std::sin(angle), z);
            forms_.push_back(Linear(-slope * direction, 0, 16 * u * slope));
        }
        faces_.assign(forms_.size(), Face());
        // Euler: V = 2 F - 4 and E = 3 F - 6, and some that are gone.
        const std::size_t room = forms_.size() + 64;
        vertices_.reserve(2 * room);
        edges_.reserve(3 * room);
        half_edges_.reserve(6 * room);
        // Around the face about corner i, counter-clockwise, the vertices opposite to the others.
        constexpr Index around[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
        std::array<std::array<Index, 4>, 4> from_to{};  // the half-edge between two vertices, plus 1
        for (Index i = 0; i < 4; ++i)
            for (int k = 0; k < 3; ++k) {
                const Index a = around[i][k], b = around[i][(k + 1) % 3];
                Index h = from_to[a][b];
                if (h == 0) {
                    h = 2 * static_cast<Index>(edges_.size()) + 1;
                    edges_.push_back({});
                    half_edges_.resize(half_edges_.size() + 2);
                    from_to[b][a] = h + 1;
                }
                from_to[a][b] = h;
                half_edges_[h - 1].origin = a;
                half_edges_[h - 1].face = first + i;
                faces_[first + i].start = h - 1;
            }
        for (Index i = 0; i < 4; ++i)
            for (int k = 0; k < 3; ++k)
                link(from_to[around[i][k]][around[i][(k + 1) % 3]] - 1,
                     from_to[around[i][(k + 1) % 3]][around[i][(k + 2) % 3]] - 1);
        for (Index e = 0; e < edges_.size(); ++e) {
            set_curve(e);
            set_arc(e);
        }
        alive_faces_ = {first, first + 1, first + 2, first + 3};
        for (Index i = 4; i < count; ++i)
            if (!insert(first + i)) return false;
        return true;
    }

    // --- Geometry ------------------------------------------------------------------------------------------

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
        if (!(radius2 < 4 * depth2) || !(p.error + q.error < 0x1p-7)) return;
        edge.apex.p = center + radius2 / depth2 * middle;
        edge.apex.error = edge.apex_blur + 32 * (p.error + q.error);
        edge.apex.height = f(edge.apex.p);
        edge.apex.doubt = 2 * std::max(f.error, g.error) + f.slope * edge.apex.error;
        edge.apex.set_level(steepest_);
    }

    // Of an arc whose ends are too near to each other to tell how it runs, unless it seems to be the rest of
    // the circle: the point opposite to its ends would be on it. Otherwise it lies in a ball about its ends.
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
        for_cycle(face, [&](Index h) {
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
        for_cycle(face, [&](Index h) {
            const Vertex& v = vertices_[half_edges_[h].origin];
            const Mark& apex = edges_[h >> 1].apex;
            square = std::max({square, (v.p - center).squaredNorm(), (apex.p - center).squaredNorm()});
            error = std::max({error, v.error, apex.error});
        });
        const double radius = std::sqrt(square) + error + slack;
        if (!(radius < f.ball.radius)) return;
        const double length = center.norm();
        if (!(length > 0x1p-10 && radius < 1 + length && is_outside(face, center / -length))) return;
        f.ball = {center, radius};
        f.cap.shrink_to(f.ball);
    }

    void plant_trees() {
        vertex_tree_.emplace();
        face_tree_.emplace();
        for (Index v = 0; v < vertices_.size(); ++v)
            if (!vertices_[v].is_gone()) vertex_tree_->add(v, vertices_);
        new_faces_ = alive_faces_;
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

    // --- Insertion -----------------------------------------------------------------------------------------

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
        for (const Index h : middles_) join(h);
        if (!vertex_tree_) {
            if (!swallowed_.empty()) erase_if(alive_faces_, [&](Index f) { return faces_[f].start == none; });
            alive_faces_.push_back(challenger);
            top_ = HUGE_VAL;
            is_top_known_ = is_flattest_known_ = false;
        }
        return close(challenger);
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
                if (is_crossed) split(h);
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

    // Of a face whose boundary the challenger does not cross: does the circle where both tie not lie within?
    bool is_within(const Linear& form, Index face) {
        const Linear& rival = forms_[face];
        ++decisions_.by_double;
        const bool is_lost = is_taken(vertices_[half_edges_[faces_[face].start].origin]);
        const Vector3d gradient = form.b - rival.b;
        const double slope = gradient.norm(), offset = form.e - rival.e, side = is_lost ? 1 : -1;
        return side * offset + slope < -(form.error + rival.error) ||
               is_outside(face, side / slope * gradient);
    }

    // Does form - rival certainly grow towards where the rival is lowest?
    static bool grows_to_pole(const Linear& form, const Linear& rival) {
        return form.b[0] * rival.b[0] + form.b[1] * rival.b[1] + form.b[2] * rival.b[2] <
               rival.square - (form.error + rival.error) * rival.slope;
    }

    // Of a form that is beaten on the face's boundary: in the face, too?
    bool is_beaten_in(const Linear& form, Index face) {
        return (grows_to_pole(form, forms_[face]) && is_in_hemisphere(face)) || is_within(form, face);
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
            ties_[v.ties].point = point_;
            ties_[v.ties].generation = generation_;
        }
        return sign.has_value();
    }
    void add_tie(Index& list, Index challenger) {
        if (list == none) {
            list = static_cast<Index>(ties_.size());
            ties_.emplace_back();
        }
        ties_[list].forms.push_back(challenger);
    }
    // Does the challenger tie along the edge, and so on its whole circle? Then that is kept with the edge.
    [[gnu::noinline]] bool ties_along(Index e, const Linear& form) {
        const auto challenger = static_cast<Index>(&form - forms_.data());
        if (are_on_one_circle(left(2 * e), right(2 * e), challenger) != true) return false;
        add_tie(edges_[e].ties, challenger);
        return true;
    }
    // Do f and g tie where f and h do? None where there are no exact numbers.
    std::optional<bool> are_on_one_circle(Index f, Index g, Index h) {
        if (std::max({f, g, h}) >= family_.size()) return std::nullopt;
        const FormId a = in_kernel(f), b = in_kernel(g), c = in_kernel(h);
        return kernel_.same_curve({a, b}, {a, c});
    }
    // Of the challenger less the forms that tie in the vertex.
    std::optional<Sign> exact_sign(const Vertex& v, Index challenger) {
        if (std::max(challenger, std::ranges::max(v.forms)) >= family_.size()) return std::nullopt;
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
        FormId& number = in_kernel_[form];
        if (!number.valid()) number = kernel_.add_form(FormId{form});
        return number;
    }
    void forget_points() {
        in_kernel_.clear();
        kernel_.reset(&family_);
        ++generation_;
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
        if (!(extreme < -doubt) || !(steepness > 0x1p-20 * slope)) return Middle::Unknown;
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

    // Puts a vertex at middle_ on the edge of h, until the challenger is inserted. h stays the first part.
    void split(Index h) {
        const Index from = half_edges_[h].origin;
        Vertex middle;
        middle.p = middle_;
        middle.stamp = stamp_;
        middle.taken = is_taken(vertices_[from]) ? 0 : stamp_;
        const Index v = add(vertices_, free_vertices_, middle);
        const Index e = add_edge(edges_[h >> 1]);
        // Both parts lie on the old curve in the old direction.
        const Index second = 2 * e + (h & 1u);
        half_edges_[second] = {half_edges_[h].next, h, v, left(h)};
        half_edges_[twin(second)] = {twin(h), half_edges_[twin(h)].prev, half_edges_[twin(h)].origin,
                                     right(h)};
        link(second, half_edges_[h].next);
        link(h, second);
        link(half_edges_[twin(h)].prev, twin(second));
        link(twin(second), twin(h));
        half_edges_[twin(h)].origin = v;
        if (!is_taken(vertices_[v])) middles_.push_back(h);
    }

    // Undoes split() where the middle is left.
    void join(Index h) {
        const Index second = half_edges_[h].next;
        remove_vertex(half_edges_[second].origin);
        link(h, half_edges_[second].next);
        link(half_edges_[twin(second)].prev, twin(h));
        half_edges_[twin(h)].origin = half_edges_[twin(second)].origin;
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

    template <class T>
    static Index add(std::vector<T>& all, SomeIndices& free, const T& element) {
        if (free.empty()) {
            all.push_back(element);
            return static_cast<Index>(all.size() - 1);
        }
        const Index i = free.back();
        free.pop_back();
        all[i] = element;
        return i;
    }

    Index add_edge(const Edge& edge) {
        const Index e = add(edges_, free_edges_, edge);
        if (half_edges_.size() < 2 * edges_.size()) half_edges_.resize(2 * edges_.size());
        return e;
    }

    // Half-edges from `first` up to `last`, which stays, and the vertices they leave.
    void remove(Index first, Index last) {
        Index h = first;
        do {
            remove_edge(h >> 1);
            remove_vertex(half_edges_[h].origin);
            h = half_edges_[h].next;
        } while (h != last);
    }
    void remove_vertex(Index v) {
        if (vertices_[v].is_gone()) return;
        vertices_[v].remove();
        if (vertex_tree_)
            vertex_tree_->remove(v);
        else
            vertex_rows_.remove(v);
        free_vertices_.push_back(v);
    }
    void remove_edge(Index e) {
        if (edges_[e].apex.is_gone()) return;
        edges_[e].apex.remove();
        if (!vertex_tree_) apex_rows_.remove(e);
        free_edges_.push_back(e);
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

    // --- The result ----------------------------------------------------------------------------------------

    // Chart point and height of a vertex. Towards the pole 1 + z is found without cancellation; moving by d
    // on the sphere moves the chart point by d W / 2.
    std::optional<MinimizationDiagram::Vertex> chart_vertex(const Vertex& v) const {
        const Vector3d& p = v.p;
        const double across = p.x() * p.x() + p.y() * p.y();
        const double scale = p.z() < 0 ? (1 - p.z()) / across : 1 / (1 + p.z());
        MinimizationDiagram::Vertex out;
        out.point = scale * p.head<2>();
        const double reach2 = out.point.squaredNorm(), reach = std::sqrt(reach2), W = 1 + reach2;
        if (!(W * v.error < 0x1p-10)) return std::nullopt;
        out.error = W * v.error + 8 * u * reach;
        out.height = W * v.height;
        out.height_error =
            1.01 * W * (v.doubt + 2 * reach * std::abs(v.height) * v.error) + 16 * u * W * std::abs(v.height);
        return out;
    }

    // Faces after the pole's on the path, edges and vertices as they are met around faces: what comes after
    // then finds neighbours near each other in memory.
    std::optional<MinimizationDiagram> diagram(Index pole_face) {
        if (!unite_vertices() || !unite_edges()) return std::nullopt;
        std::vector<std::pair<double, Index>> faces;
        faces.reserve(vertices_.size() / 2 + 2);  // Euler: V - E + F = 2, 2 E = 3 V
        for (Index f = 0; f < family_.size(); ++f)
            if (faces_[f].start != none && !is_point(f) && !is_sliver(f))
                faces.emplace_back(f == pole_face ? -1 : place_on_path(forms_[f]), f);
        std::ranges::sort(faces);

        MinimizationDiagram out;
        out.forms = family_.forms;
        const std::size_t edge_count = edges_.size() - free_edges_.size(),
                          vertex_count = vertices_.size() - free_vertices_.size();
        out.dcel.reserve(vertex_count, edge_count, faces.size());
        out.vertices.reserve(vertex_count);
        out.edges.reserve(edge_count);
        out.edge_labels_.reserve(2 * edge_count);
        out.edge_offsets_.reserve(edge_count + 1);
        out.vertex_labels_.reserve(3 * vertex_count);
        out.vertex_offsets_.reserve(vertex_count + 1);
        out.face_forms.reserve(faces.size());
        std::vector<Index> vertex_map(vertices_.size(), none), edge_map(edges_.size(), none);
        for (const auto& [place, f] : faces) {
            Index h = faces_[f].start;
            do {
                if (edge_map[h >> 1] == none && !is_within_point(h) &&
                    !add_edge(out, h, vertex_map, edge_map))
                    return std::nullopt;
                h = half_edges_[h].next;
            } while (h != faces_[f].start);
        }
        out.edge_offsets_.push_back(static_cast<std::uint32_t>(out.edge_labels_.size()));
        out.vertex_offsets_.push_back(static_cast<std::uint32_t>(out.vertex_labels_.size()));
        out.side_offsets_.assign(out.vertices.size() + 1, 0);

        const auto half_edge = [&](Index h) { return HalfEdgeId{edge_map[h >> 1] ^ (h & 1u)}; };
        for (const auto& [place, f] : faces) {
            for_cycle(f, [&](Index h) {
                if (is_within_point(h)) return;
                Index next = half_edges_[h].next;
                while (is_within_point(next)) next = half_edges_[next].next;
                out.dcel.link(half_edge(h), half_edge(next));
            });
            Index start = faces_[f].start;
            while (is_within_point(start)) start = half_edges_[start].next;
            if (f == pole_face)
                out.dcel.add_inner_ccb(Dcel::unbounded_face(), half_edge(start));
            else
                out.dcel.add_outer_ccb(out.dcel.add_face(), half_edge(start));
            out.face_forms.push_back(FormId{f});
        }
        if (!slivers_.empty() && has_bends(out)) return std::nullopt;
        out.decisions = decisions_;
        out.decisions += kernel_.decisions();
        return out;
    }

    // Are there vertices in which fewer than three edges end?
    static bool has_bends(const MinimizationDiagram& diagram) {
        IdVector<VertexId, int> degree(diagram.vertices.size(), 0);
        for (const EdgeId e : diagram.edges.ids())
            for (const HalfEdgeId h : {HalfEdgeId{2 * e.value}, HalfEdgeId{2 * e.value + 1}})
                ++degree[diagram.dcel.origin(h)];
        return std::ranges::any_of(degree, [](int edges) { return edges < 3; });
    }

    // Edges are looked at only where any of them is a point.
    bool is_within_point(Index h) const { return has_points_ && edges_[h >> 1].is_point; }
    bool is_point(Index face) const {
        bool is = has_points_;
        if (is) for_cycle(face, [&](Index h) { is = is && is_within_point(h); });
        return is;
    }

    // The one of the vertices in a vertex's place that stands for all of them.
    Index place(Index v) {
        if (places_.empty()) return v;
        while (places_[v] != v) v = places_[v] = places_[places_[v]];
        return v;
    }
    // Finds the vertices that are one point, and all forms that tie there. False where an edge is closed in
    // one, or a face meets itself, and where that is not known.
    bool unite_vertices() {
        const auto is_alive = [&](Index e) { return !edges_[e].apex.is_gone(); };
        if (ties_.empty()) return true;
        for (Index e = 0; e < edges_.size(); ++e) {
            if (!is_alive(e) || edges_[e].is_point) continue;
            if (are_one_point(vertices_[half_edges_[2 * e].origin],
                              vertices_[half_edges_[2 * e + 1].origin]) != false)
                return false;
        }
        places_.resize(vertices_.size());
        std::iota(places_.begin(), places_.end(), Index{0});
        const auto ends = [&](Index e) {
            return std::array{place(half_edges_[2 * e].origin), place(half_edges_[2 * e + 1].origin)};
        };
        for (Index e = 0; e < edges_.size(); ++e) {
            if (!is_alive(e) || !edges_[e].is_point) continue;
            const auto [p, q] = ends(e);
            places_[p] = q;
        }
        for (Index e = 0; e < edges_.size(); ++e) {
            if (!is_alive(e) || edges_[e].is_point) continue;
            const auto [p, q] = ends(e);
            if (p == q) return false;
        }
        for (const Face& f : faces_) {
            if (f.start == none) continue;
            met_.clear();
            for_cycle(static_cast<Index>(&f - faces_.data()), [&](Index h) {
                if (!edges_[h >> 1].is_point) met_.push_back(place(half_edges_[h].origin));
            });
            std::ranges::sort(met_);
            if (std::ranges::adjacent_find(met_) != met_.end()) return false;
        }
        for (Index v = 0; v < vertices_.size(); ++v)
            if (!vertices_[v].is_gone() && (place(v) != v || vertices_[v].ties != none)) tied_[place(v)];
        for (Index v = 0; v < vertices_.size() && !tied_.empty(); ++v) {
            if (vertices_[v].is_gone()) continue;
            const auto here = tied_.find(place(v));
            if (here == tied_.end()) continue;
            std::vector<Index>& forms = here->second;
            forms.insert(forms.end(), vertices_[v].forms.begin(), vertices_[v].forms.end());
            if (const Index ties = vertices_[v].ties; ties != none)
                forms.insert(forms.end(), ties_[ties].forms.begin(), ties_[ties].forms.end());
        }
        for (auto& [v, forms] : tied_) sort_once(forms);
        return true;
    }
    static void sort_once(std::vector<Index>& forms) {
        std::ranges::sort(forms);
        forms.erase(std::ranges::unique(forms).begin(), forms.end());
    }

    // Finds the faces without width, and all forms that tie along edges, which tie in their ends, too. False
    // where that is not known.
    bool unite_edges() {
        if (ties_.empty()) return true;
        for (Index f = 0; f < family_.size(); ++f) {
            if (faces_[f].start == none) continue;
            std::array<Index, 2> sides{none, none};
            std::size_t count = 0;
            for_cycle(f, [&](Index h) {
                if (edges_[h >> 1].is_point) return;
                if (count < 2) sides[count] = h;
                ++count;
            });
            if (count != 2) continue;
            const Edge &first = edges_[sides[0] >> 1], &second = edges_[sides[1] >> 1];
            // Of the two ways from end to end both sides take one.
            const bool is_same_way =
                (first.normal.dot(second.normal) < 0) == ((sides[0] & 1u) == (sides[1] & 1u));
            const auto is_one_circle = are_on_one_circle(f, right(sides[0]), right(sides[1]));
            if (!is_one_circle) return false;
            if (!*is_one_circle) continue;
            if (!is_same_way) return false;
            slivers_[f] = sides;
        }
        for (Index e = 0; e < edges_.size(); ++e) {
            if (edges_[e].apex.is_gone() || edges_[e].is_point || edges_[e].ties == none) continue;
            for (const Index h : {2 * e, 2 * e + 1}) {
                const Index v = place(half_edges_[h].origin);
                std::vector<Index>& forms = tied_[v];
                const auto& here = vertices_[v].forms;
                forms.insert(forms.end(), here.begin(), here.end());
                const std::vector<Index>& ties = ties_[edges_[e].ties].forms;
                forms.insert(forms.end(), ties.begin(), ties.end());
                sort_once(forms);
            }
        }
        return true;
    }
    bool is_sliver(Index face) const { return !slivers_.empty() && slivers_.contains(face); }
    // The half-edge of a sliver on the other side of it. Pre: a sliver is on the right.
    Index beyond(Index h) const {
        const auto& sides = slivers_.find(right(h))->second;
        return sides[0] == twin(h) ? sides[1] : sides[0];
    }
    // The half-edge on the other side of this one and of all slivers beside it.
    Index across(Index h) const {
        while (is_sliver(right(h))) h = beyond(h);
        return twin(h);
    }

    // Adds the edge of which h is the half-edge of a face that is no sliver.
    bool add_edge(MinimizationDiagram& out, Index h, std::vector<Index>& vertex_map,
                  std::vector<Index>& edge_map) {
        const Index opposite = across(h);
        const bool is_even = (h & 1u) == 0;
        const Index first = is_even ? h : opposite, second = is_even ? opposite : h;
        std::array<VertexId, 2> ends;
        for (const Index side : {0u, 1u}) {
            const Index v = place(half_edges_[side == 0 ? first : second].origin);
            if (vertex_map[v] == none) {
                if (!add_vertex(out, v)) return false;
                vertex_map[v] = out.dcel.add_vertex().value;
            }
            ends[side] = {vertex_map[v]};
        }
        const Index e = out.dcel.add_edge(ends[0], ends[1]).value;
        edge_map[first >> 1] = 2 * e ^ (first & 1u);
        edge_map[second >> 1] = (2 * e + 1) ^ (second & 1u);
        out.edges.push_back({FormId{left(first)}, FormId{left(second)}});
        out.edge_offsets_.push_back(static_cast<std::uint32_t>(out.edge_labels_.size()));
        if (opposite == twin(h) && edges_[h >> 1].ties == none) {
            out.edge_labels_.push_back(std::min(FormId{left(first)}, FormId{left(second)}));
            out.edge_labels_.push_back(std::max(FormId{left(first)}, FormId{left(second)}));
        } else {
            for (const Index f : forms_along(h)) out.edge_labels_.push_back(FormId{f});
        }
        return true;
    }
    // All forms that tie along the edges of the slivers beside h, and along that of h.
    std::vector<Index> forms_along(Index h) const {
        std::vector<Index> forms{left(h)};
        while (true) {
            forms.push_back(right(h));
            if (const Index ties = edges_[h >> 1].ties; ties != none)
                forms.insert(forms.end(), ties_[ties].forms.begin(), ties_[ties].forms.end());
            if (!is_sliver(right(h))) break;
            h = beyond(h);
        }
        sort_once(forms);
        return forms;
    }

    bool add_vertex(MinimizationDiagram& out, Index v) const {
        const auto vertex = chart_vertex(vertices_[v]);
        if (!vertex) return false;
        out.vertices.push_back(*vertex);
        out.vertex_offsets_.push_back(static_cast<std::uint32_t>(out.vertex_labels_.size()));
        const auto add_labels = [&](auto forms) {
            std::ranges::sort(forms);
            for (const Index f : forms) out.vertex_labels_.push_back(FormId{f});
        };
        if (const auto tied = tied_.find(v); tied != tied_.end())
            add_labels(tied->second);
        else
            add_labels(vertices_[v].forms);
        return true;
    }

    const FormFamily& family_;
    const EnvelopeOptions& options_;
    double steepest_ = 0;        // slope of forms
    std::vector<Linear> forms_;  // the family's, and four that are higher in the end
    std::vector<Vertex> vertices_;
    std::vector<HalfEdge> half_edges_;
    std::vector<Edge> edges_;
    std::vector<Face> faces_;
    SomeIndices free_vertices_, free_edges_;
    bool has_points_ = false;  // among the edges
    SomeIndices alive_faces_;  // as long as there is no tree
    double top_ = HUGE_VAL;    // the diagram is nowhere higher
    bool is_top_known_ = false;
    double flattest_ = 0;  // forms of less slope grow towards the poles of all faces but these
    SomeIndices wide_faces_;
    bool is_flattest_known_ = false;
    // Of small diagrams: what of the vertices and of the edges' apexes most forms are compared with.
    MarkRows vertex_rows_, apex_rows_;
    // Of large diagrams. The vertices tell where most forms win; faces are looked at when they do not.
    std::optional<VertexTree> vertex_tree_;
    std::optional<FaceTree> face_tree_;
    SomeIndices new_faces_;  // not in the tree yet
    Decisions decisions_;
    CircleKernel kernel_;            // decides what doubles cannot
    std::vector<FormId> in_kernel_;  // none: not there yet
    Index generation_ = 1;           // of the kernel's points
    PointId point_;                  // where exact_sign() was asked last
    Index stamp_ = 0;
    std::size_t inserted_ = 0;
    // Working space of insert().
    SomeIndices rivals_, swallowed_, new_edges_;
    SomeIndices middles_;  // half-edges that end at a vertex made by split() that is not taken
    SmallVector<Cut, 32> cuts_;
    Vector3d middle_;
    std::vector<Ties> ties_;
    // The result has for each vertex one in the same place (none if all are apart), and the forms where they
    // are more than three.
    std::vector<Index> places_, met_;
    std::map<Index, std::vector<Index>> tied_;
    std::map<Index, std::array<Index, 2>> slivers_;  // faces without width, and their sides
};

}  // namespace

std::optional<MinimizationDiagram> disc_diagram_on_sphere(const FormFamily& family,
                                                          const EnvelopeOptions& options) {
    // What fails in the beginning, when faces are large, may succeed in another order. The more forms there
    // are, the less it costs to try again, compared with the other engine.
    constexpr std::size_t beginning = 64, many = 1024;
    const std::size_t attempts = family.size() > many ? 16 : 4;
    for (std::size_t attempt = 0; attempt < attempts; ++attempt) {
        DiscDiagram diagram(family, options);
        if (auto result = diagram.run(attempt)) return result;
        if (diagram.inserted() > beginning) break;
    }
    return std::nullopt;
}

}  // namespace vcell
