/// A brute-force judge of minimization diagrams over sphere and cylinder bases. It shares no code with the
/// engine but the types, the frame and the chart: whoever is nearest at a base point is found from the
/// distance functions along its normal, and which face holds the point by winding numbers of traced edges.
///
/// A chart of the base in the complex plane serves for winding: over a sphere the stereographic chart itself,
/// over a cylinder exp(i theta - y), with y scaled. Moving along a closed curve, arg((z - p) / (z - q)) turns
/// by 2 pi for each time that the curve has p rather than q on its left.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include "../../envelope/diagram/minimization_diagram.hpp"
#include "../../primitives/bases/radial_base.hpp"

namespace vcell::radial {

using Fast = long double;
using Vector = Eigen::Matrix<Fast, 3, 1>;
using Complex = std::complex<Fast>;

struct Options {
    int samples = 150;  ///< pairs of base points whose faces are compared
};

/// A scene in canonical position, as distance functions.
class Surroundings {
public:
    Surroundings(const Scene& scene, const RadialBaseProblem& problem) : problem_(problem) {
        turn_ = problem.frame.rotation.cast<Fast>();
        origin_ = problem.frame.origin.cast<Fast>();
        for (std::size_t i = 0; i < scene.objects.size(); ++i)
            add(Site::object(static_cast<std::uint32_t>(i)), scene.objects[i]);
        for (std::uint32_t side = 0; side < 6; ++side) {
            Vec3 normal = Vec3::Zero();
            normal[side / 2] = side % 2 == 0 ? -1 : 1;
            add(Site::box_side(side), Plane{side % 2 == 0 ? scene.box.min : scene.box.max, normal});
        }
        size_ = scene.box.diagonal();
        const Fast far = std::max(scene.box.min.cwiseAbs().maxCoeff(), scene.box.max.cwiseAbs().maxCoeff());
        // Over a cylinder coordinates are rounded when they are turned into the frame.
        tolerance_ = 64 * std::numeric_limits<double>::epsilon() * (size_ + (problem.is_sphere ? 0 : far));
        form_.assign(items_.size(), FormId{});
        for (const FormId f : problem.sites.ids())
            for (const Site site : problem.sites[f]) form_[number(site)] = f;
    }

    std::size_t size() const { return items_.size(); }
    Fast scene_size() const { return size_; }
    Fast tolerance() const { return tolerance_; }
    FormId form(std::size_t item) const { return form_[item]; }
    /// Some item of a form.
    std::size_t item(FormId f) const { return number(problem_.sites[f].front()); }
    std::string name(std::size_t item) const { return to_string(items_[item].site); }

    Vector normal(Fast x, Fast y) const {
        Vector n;
        if (problem_.is_sphere) {
            const Fast s = x * x + y * y;
            n = Vector(2 * x, 2 * y, 1 - s) / (1 + s);
        } else {
            const Fast a = x > 1 ? x - 2 : x, sign = x > 1 ? -1 : 1;
            n = sign * Vector(2 * a, 0, 1 - a * a) / (1 + a * a);
        }
        return (problem_.chart.cast<Fast>() * n).normalized();
    }

    /// d - r at the distance t from the centre or axis (of a side of the box what has its sign), and the
    /// derivative. Convex, and falls along the ray.
    std::pair<Fast, Fast> excess(std::size_t item, const Vector& foot, const Vector& u, Fast t) const {
        const Item& o = items_[item];
        const Vector p = foot + t * u - o.point;
        if (o.site.kind == Site::Kind::BoxSide) return {-o.axis.dot(p), -o.axis.dot(u)};
        const Fast r = t - static_cast<Fast>(problem_.radius);
        if (o.kind == Item::Wall) {
            const Fast d = o.axis.dot(p);
            return {std::abs(d) - r, (d < 0 ? -1 : 1) * o.axis.dot(u) - 1};
        }
        const Vector away = o.kind == Item::Ball ? p : Vector(p - o.axis.dot(p) * o.axis);
        const Fast d = away.norm();
        return {d - o.rho - r, away.dot(u) / d - 1};
    }

    /// The distance at which the item is met along the ray, infinite beyond `most`: Newton's method ascends
    /// to the zero of a convex function from its left.
    Fast distance(std::size_t item, const Vector& foot, const Vector& u, Fast most) const {
        Fast t = 0;
        for (int i = 0; i < 200; ++i) {
            const auto [value, slope] = excess(item, foot, u, t);
            if (!(slope < 0)) return std::numeric_limits<Fast>::infinity();
            const Fast step = -value / slope;
            t += step;
            if (t > most) return std::numeric_limits<Fast>::infinity();
            if (i > 0 && step <= 2 * std::numeric_limits<Fast>::epsilon() * t) break;
        }
        return t;
    }
    Fast distance(std::size_t item, Fast x, Fast y) const {
        return distance(item, foot(y), normal(x, y), 4 * size_);
    }
    Vector foot(Fast y) const { return {0, problem_.is_sphere ? 0 : y, 0}; }

    /// The nearest item, and by how much it is nearer than the nearest that has another form.
    struct Nearest {
        std::size_t item;
        Fast distance, lead;
    };
    Nearest nearest(Fast x, Fast y) const {
        const Vector f = foot(y), u = normal(x, y);
        Nearest best{0, std::numeric_limits<Fast>::infinity(), 0};
        const auto search = [&](Nearest& at, auto admitted) {
            for (std::size_t i = 0; i < size(); ++i) {
                const Fast most = std::min(at.distance, 4 * size_);
                if (!admitted(i) || excess(i, f, u, most).first > 0) continue;
                const Fast t = distance(i, f, u, 4 * size_);
                if (t < at.distance) at = {i, t, 0};
            }
        };
        search(best, [](std::size_t) { return true; });
        Nearest second{0, std::numeric_limits<Fast>::infinity(), 0};
        search(second, [&](std::size_t i) {
            return i != best.item && !(form_[i].valid() && form_[i] == form_[best.item]);
        });
        best.lead = second.distance - best.distance;
        // A solid that hides another one may tie with it: the one with a form stands for both.
        if (!form_[best.item].valid() && best.lead <= tolerance_) best.item = second.item;
        return best;
    }

    /// {h, h0} with 1 / t of `f` less 1 / t of `g` a positive multiple of h . u + h0, over a sphere; without
    /// cylinders.
    std::pair<Vector, Fast> plane_of(std::size_t f, std::size_t g) const {
        const auto [a, a0, ac] = reciprocal(f);
        const auto [b, b0, bc] = reciprocal(g);
        return {a * bc - b * ac, a0 * bc - b0 * ac};
    }

private:
    struct Item {
        enum { Ball, Wall, Rod } kind;
        Site site;
        Vector point, axis = Vector::Zero();  // unit; of a side of the box outward
        Fast rho = 0;
    };

    // 1 / t = (b . u + b0) / c over a sphere base, c > 0: |t u - p|^2 = (t - R0 + rho)^2 solved for 1 / t,
    // and so on.
    std::tuple<Vector, Fast, Fast> reciprocal(std::size_t i) const {
        const Item& o = items_[i];
        const Fast R0 = problem_.radius;
        if (o.site.kind == Site::Kind::BoxSide) return {o.axis, 0, o.axis.dot(o.point)};
        if (o.kind == Item::Ball) {
            const Fast d = o.rho - R0;
            return {2 * o.point, 2 * d, o.point.squaredNorm() - d * d};
        }
        const Fast D = -o.axis.dot(o.point), s = D < 0 ? -1 : 1;
        return {-s * o.axis, 1, s * D + R0};
    }

    void add(Site site, const Object& object) {
        Item item{Item::Ball, site, {}};
        const auto place = [&](const Vec3& p) -> Vector { return turn_ * (p.cast<Fast>() - origin_); };
        if (const auto* s = std::get_if<Sphere>(&object)) {
            item.point = place(s->center);
            item.rho = s->radius;
        } else if (const auto* p = std::get_if<Plane>(&object)) {
            item.kind = Item::Wall;
            item.point = place(p->point);
            item.axis = (turn_ * p->normal.cast<Fast>()).normalized();
        } else {
            const auto& c = std::get<Cylinder>(object);
            item.kind = Item::Rod;
            item.point = place(c.point);
            item.axis = (turn_ * c.axis.cast<Fast>()).normalized();
            item.rho = c.radius;
        }
        items_.push_back(item);
    }
    std::size_t number(Site site) const {
        return site.is_object() ? site.index : items_.size() - 6 + site.index;
    }

    const RadialBaseProblem& problem_;
    Eigen::Matrix<Fast, 3, 3> turn_;
    Vector origin_;
    std::vector<Item> items_;
    std::vector<FormId> form_;
    Fast size_ = 0, tolerance_ = 0;
};

class Judge {
public:
    Judge(const Scene& scene, const RadialBaseProblem& problem, const MinimizationDiagram& diagram)
        : problem_(problem), around_(scene, problem), d_(diagram), dcel_(diagram.dcel) {}

    /// What is wrong; empty if nothing was found.
    std::vector<std::string> check(std::mt19937_64& rng, const Options& options = {}) {
        check_structure();
        if (!complaints_.empty()) return complaints_;  // what follows walks the structure
        for (const VertexId v : d_.vertices.ids()) check_vertex(v);
        for (const EdgeId e : d_.edges.ids()) trace(e);
        if (!complaints_.empty()) return complaints_;  // what follows builds on the traces
        for (int i = 0; i < options.samples; ++i) check_faces(sample(rng), sample(rng));
        return complaints_;
    }

    const Surroundings& surroundings() const { return around_; }

private:
    static constexpr std::size_t enough = 10;  // complaints

    // A point of an edge: chart coordinates, and the arc's parameter (circles: the angle; pieces: their
    // number).
    struct Node {
        Fast x, y, s;
        Complex z;
    };
    struct Circle {  // on the sphere: u = offset + cos(s) e1 + sin(s) e2
        Vector offset, e1, e2;
    };
    struct Trace {
        std::vector<Node> nodes;
        std::optional<Circle> circle;
    };

    void complain(const std::string& what) {
        if (complaints_.size() < enough) complaints_.push_back(what);
    }
    template <class Ids>
    static std::string name(const Ids& ids) {
        std::string s = "{";
        for (const auto& id : ids) s += (s.size() > 1 ? " " : "") + to_string(id);
        return s + "}";
    }
    static std::string text(Fast v) { return std::to_string(static_cast<double>(v)); }
    static std::string place(Fast x, Fast y) { return "(" + text(x) + ", " + text(y) + ")"; }
    bool is_over_sphere() const { return problem_.is_sphere; }
    bool has_face(FormId f) const { return f.valid() && f.value < problem_.sites.size(); }
    FaceId outer_face(std::uint32_t rim) const { return {rim == 0 ? 0u : 1u}; }

    // --- Charts -----------------------------------------------------------------------------------

    Complex chart(Fast x, Fast y) const {
        if (is_over_sphere()) return {x, y};
        const Fast theta = x > 1 ? std::numbers::pi_v<Fast> + 2 * std::atan(x - 2) : 2 * std::atan(x);
        const auto [y0, y1] = problem_.stretch;
        const Fast scaled = 4 * (y - (static_cast<Fast>(y0) + y1) / 2) / (static_cast<Fast>(y1) - y0);
        return std::polar(std::exp(-scaled), theta);
    }
    Node node(Fast x, Fast y, Fast s) const { return {x, y, s, chart(x, y)}; }
    Node on_circle(const Circle& c, Fast s) const {
        const Vector u = c.offset + std::cos(s) * c.e1 + std::sin(s) * c.e2;
        const Vector n = problem_.chart.transpose().cast<Fast>() * u;
        return node(n.x() / (1 + n.z()), n.y() / (1 + n.z()), s);
    }
    std::array<Fast, 2> sample(std::mt19937_64& rng) const {
        const auto uniform = [&](double a, double b) { return std::uniform_real_distribution(a, b)(rng); };
        if (!is_over_sphere()) return {uniform(-1, 3), uniform(problem_.stretch[0], problem_.stretch[1])};
        const Fast z = uniform(-1, 1), angle = uniform(0, 2 * std::numbers::pi),
                   rho = std::sqrt((1 - z) / (1 + z));
        return {rho * std::cos(angle), rho * std::sin(angle)};
    }

    // --- Structure and labels -------------------------------------------------------------------------

    void check_structure() {
        if (const auto defect = dcel_.find_defect()) return complain("dcel: " + defect->what);
        const std::size_t forms = d_.forms.size() + d_.radial.size();
        if (d_.vertices.size() != dcel_.vertex_count() || d_.edges.size() != dcel_.edge_count() ||
            d_.face_forms.size() != dcel_.face_count() || forms != problem_.sites.size() ||
            d_.vertex_offsets_.size() != d_.vertices.size() + 1 ||
            d_.edge_offsets_.size() != d_.edges.size() + 1)
            return complain("sizes: the diagram's arrays do not match");
        for (const FaceId f : d_.face_forms.ids()) {
            const bool outside = !is_over_sphere() && f.value < 2;
            if (has_face(d_.face_forms[f]) == outside)
                complain(to_string(f) + ": label " + to_string(d_.face_forms[f]));
        }
        if (!complaints_.empty()) return;
        for (const VertexId v : d_.vertices.ids()) check_label(to_string(v), d_.label(v));
        for (const EdgeId e : d_.edges.ids()) check_edge_structure(e);
    }

    void check_label(const std::string& where, std::span<const FormId> label) {
        for (std::size_t i = 0; i < label.size(); ++i)
            if (!has_face(label[i]) || (i > 0 && !(label[i - 1] < label[i])))
                complain(where + ": label " + name(label));
    }

    static bool includes(std::span<const FormId> label, FormId f) {
        return !f.valid() || std::ranges::find(label, f) != label.end();
    }

    void check_edge_structure(EdgeId e) {
        const auto& edge = d_.edges[e];
        const HalfEdgeId h = Dcel::half_edge(e);
        const std::string where = to_string(e);
        check_label(where, d_.label(e));
        const FormId left = d_.face_forms[dcel_.face(h)], right = d_.face_forms[dcel_.face(Dcel::twin(h))];
        if (edge.left != left || edge.right != right || !left.valid())
            complain(where + ": sides are not its faces'");
        if (edge.on_rim() == right.valid() || (edge.on_rim() && is_over_sphere()))
            complain(where + ": wrong about being on the rim");
        if (edge.on_rim() && dcel_.face(Dcel::twin(h)) != outer_face(edge.side))
            complain(where + ": on the wrong rim");
        if (!edge.on_rim() && left == right) complain(where + ": the same form on both sides");
        if (!includes(d_.label(e), left) || !includes(d_.label(e), right))
            complain(where + ": label " + name(d_.label(e)) + " lacks a face's");
        for (const VertexId v : {dcel_.origin(h), dcel_.target(h)})
            if (v.valid())
                for (const FormId f : d_.label(e))
                    if (!includes(d_.label(v), f)) complain(to_string(v) + ": label lacks that of " + where);
    }

    // --- Ties ----------------------------------------------------------------------------------------------

    // How much a distance may change where a point moves by `error` in the chart: by differences.
    Fast slack(std::size_t item, Fast x, Fast y, Fast error) const {
        const Fast at = around_.distance(item, x, y);
        Fast most = 0;
        for (const auto& [dx, dy] : {std::pair<Fast, Fast>{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
            const Fast moved = around_.distance(item, x + dx * error, y + dy * error);
            if (std::isfinite(moved)) most = std::max(most, std::abs(moved - at));
        }
        return 2 * most;
    }

    /// Exactly the label's forms are nearest at a point that is `error` from where they tie.
    void check_ties(const std::string& where, std::span<const FormId> label, Fast x, Fast y, Fast error) {
        const Surroundings::Nearest best = around_.nearest(x, y);
        const Fast rounding = around_.tolerance() * (1 + best.distance / around_.scene_size());
        for (const FormId f : label) {
            const std::size_t item = around_.item(f);
            const Fast t = around_.distance(item, x, y);
            if (!(t - best.distance <= rounding + slack(item, x, y, error) + slack(best.item, x, y, error)))
                complain(where + " " + place(x, y) + ": " + to_string(f) + " is not nearest, by " +
                         std::to_string(static_cast<double>((t - best.distance) / around_.scene_size())) +
                         " of the box");
        }
        for (std::size_t i = 0; i < around_.size(); ++i) {
            const FormId f = around_.form(i);
            if (!f.valid() || includes(label, f)) continue;
            const Fast t = around_.distance(i, x, y);
            if (std::isinf(t)) continue;
            if (!(t - best.distance > rounding + slack(i, x, y, error) + slack(best.item, x, y, error)))
                complain(where + " " + place(x, y) + ": label " + name(label) + " lacks " + to_string(f));
        }
    }

    void check_vertex(VertexId v) {
        const auto& vertex = d_.vertices[v];
        const Fast x = vertex.point.x(), y = vertex.point.y();
        if (!(vertex.error < 1e-6 * (1 + std::hypot(x, y)))) return complain(to_string(v) + ": no place");
        check_ties(to_string(v), d_.label(v), x, y, vertex.error);
        if (!d_.sides(v).empty())
            for (const std::uint32_t side : d_.sides(v))
                if (std::abs(y - problem_.stretch[side == 0 ? 0 : 1]) >
                    2 * vertex.error + around_.tolerance())
                    complain(to_string(v) + ": is not on the rim");
        const HalfEdgeId h = dcel_.outgoing(v);
        if (!h.valid()) return;
        const HalfEdgeId g = dcel_.next_around_origin(h);
        if (g != h && dcel_.next_around_origin(g) == h && Dcel::edge(g) != Dcel::edge(h) &&
            std::ranges::equal(d_.label(v), d_.label(Dcel::edge(h))) && d_.sides(v).empty())
            complain(to_string(v) + ": divides an arc");
    }

    // --- Edges
    // -------------------------------------------------------------------------------------------------

    void trace(EdgeId e) {
        traces_.emplace_back();
        const auto& edge = d_.edges[e];
        if (edge.on_rim())
            trace_rim(e);
        else if (d_.is_circular(edge.left) && d_.is_circular(edge.right))
            trace_circle(e);
        else
            trace_pieces(e);
        const auto& nodes = traces_.back().nodes;
        if (!complaints_.empty()) return;
        // Who is nearest changes along an edge only at vertices; it is asked half-way between nodes.
        const std::size_t step = std::max<std::size_t>(1, nodes.size() / 8);
        for (std::size_t i = 0; i + 1 < nodes.size() && !edge.on_rim(); i += step) {
            const std::optional<Node> m = between(e, nodes[i], nodes[i + 1]);
            if (m) check_edge_point(e, *m);
        }
    }

    void check_edge_point(EdgeId e, const Node& m) {
        const Surroundings::Nearest best = around_.nearest(m.x, m.y);
        for (const FormId f : d_.label(e)) {
            const Fast t = around_.distance(around_.item(f), m.x, m.y);
            const Fast rounding = 16 * around_.tolerance() * (1 + best.distance / around_.scene_size());
            if (!(t - best.distance <= rounding))
                complain(to_string(e) + " " + place(m.x, m.y) + ": " + to_string(f) + " is not nearest, " +
                         around_.name(best.item) + " is");
        }
    }

    void trace_rim(EdgeId e) {
        const auto& edge = d_.edges[e];
        const VertexId from = dcel_.origin(Dcel::half_edge(e)), to = dcel_.target(Dcel::half_edge(e));
        const Fast y = problem_.stretch[edge.side == 0 ? 0 : 1];
        const Fast a = from.valid() ? d_.vertices[from].point.x() : -1;
        Fast b = to.valid() && to != from ? d_.vertices[to].point.x() : a;
        // The region lies on the left: above the lower rim, which runs towards larger x.
        if (edge.side == 0 && b <= a) b += 4;
        if (edge.side != 0 && b >= a) b -= 4;
        constexpr int steps = 64;
        for (int i = 0; i <= steps; ++i) {
            Fast x = a + (b - a) * i / steps;
            if (x >= 3) x -= 4;
            if (x < -1) x += 4;
            traces_.back().nodes.push_back(node(x, y, 0));
        }
    }

    void trace_circle(EdgeId e) {
        const auto& edge = d_.edges[e];
        const auto [h, h0] = around_.plane_of(around_.item(edge.left), around_.item(edge.right));
        const Vector axis = h.normalized(), offset = -h0 / h.norm() * axis;
        const Fast square = 1 - offset.squaredNorm();
        if (!(square > 0)) return complain(to_string(e) + ": its forms tie nowhere");
        const VertexId from = dcel_.origin(Dcel::half_edge(e)), to = dcel_.target(Dcel::half_edge(e));
        const auto unit = [&](VertexId v) {
            return around_.normal(d_.vertices[v].point.x(), d_.vertices[v].point.y());
        };
        Vector e1 = from.valid() ? Vector(unit(from) - offset) : axis.unitOrthogonal();
        e1 = (e1 - e1.dot(axis) * axis).normalized();
        const Vector e2 = axis.cross(e1);  // the left form is nearer on the axis' side: its left
        Fast end = 2 * std::numbers::pi_v<Fast>;
        if (to != from) {
            end = std::atan2(unit(to).dot(e2), unit(to).dot(e1));
            if (end < 0) end += 2 * std::numbers::pi_v<Fast>;
        }
        Trace& t = traces_.back();
        t.circle = Circle{offset, std::sqrt(square) * e1, std::sqrt(square) * e2};
        constexpr int steps = 16;
        for (int i = 0; i <= steps; ++i) t.nodes.push_back(on_circle(*t.circle, end * i / steps));
    }

    void trace_pieces(EdgeId e) {
        const auto pieces = d_.pieces(e);
        if (pieces.empty()) return complain(to_string(e) + ": an arc without pieces");
        const VertexId from = dcel_.origin(Dcel::half_edge(e)), to = dcel_.target(Dcel::half_edge(e));
        Eigen::Vector2d start = from.valid() ? d_.vertices[from].point : pieces.back().end;
        if (to.valid() && (pieces.back().end - d_.vertices[to].point).norm() >
                              2 * (pieces.back().error + d_.vertices[to].error) + 1e-12)
            complain(to_string(e) + ": does not end at its vertex");
        for (std::size_t i = 0; i < pieces.size(); ++i) {
            const auto& piece = pieces[i];
            Eigen::Vector2d a = start, b = piece.end;
            if (!is_over_sphere()) {  // both ends beside the box of the piece
                const double middle = (piece.box[0] + piece.box[1]) / 2;
                for (Eigen::Vector2d* p : {&a, &b}) {
                    while (p->x() - middle > 2) p->x() -= 4;
                    while (p->x() - middle < -2) p->x() += 4;
                }
            }
            for (const Eigen::Vector2d& p : {a, b})
                if (p.x() < piece.box[0] - 1e-9 || p.x() > piece.box[1] + 1e-9 ||
                    p.y() < piece.box[2] - 1e-9 || p.y() > piece.box[3] + 1e-9)
                    complain(to_string(e) + ": a piece leaves its box");
            const Node first = node(a.x(), a.y(), static_cast<Fast>(i)),
                       last = node(b.x(), b.y(), static_cast<Fast>(i));
            traces_.back().nodes.push_back(first);
            if (complaints_.empty()) refine(e, first, last, 5);
            traces_.back().nodes.push_back(last);
            start = piece.end;
        }
    }

    /// Nodes between a and b until the arc is flat.
    void refine(EdgeId e, const Node& a, const Node& b, int depth) {
        if (depth == 0) return;
        const std::optional<Node> m = between(e, a, b);
        if (!m) return;
        const Fast chord = std::hypot(b.x - a.x, b.y - a.y);
        if (std::hypot(m->x - (a.x + b.x) / 2, m->y - (a.y + b.y) / 2) < Fast(0.02) * chord) return;
        refine(e, a, *m, depth - 1);
        traces_.back().nodes.push_back(*m);
        refine(e, *m, b, depth - 1);
    }

    /// A point of edge e between two neighbouring nodes; none where they are as close as rounding.
    std::optional<Node> between(EdgeId e, const Node& a, const Node& b) {
        const Trace& t = traces_[e.value];
        if (t.circle) return on_circle(*t.circle, (a.s + b.s) / 2);
        if (d_.edges[e].on_rim()) {
            Fast x = (a.x + b.x) / 2;
            if (std::abs(a.x - b.x) > 2) x += x < 1 ? 2 : -2;
            return node(x, a.y, 0);
        }
        if (a.s != b.s) return std::nullopt;  // the end of a piece and the start of the next
        const auto& piece = d_.pieces(e)[static_cast<std::size_t>(a.s)];
        const Fast chord = std::hypot(b.x - a.x, b.y - a.y);
        if (chord < 1e-11L * (1 + std::hypot(a.x, a.y))) return std::nullopt;
        const std::size_t left = around_.item(d_.edges[e].left), right = around_.item(d_.edges[e].right);
        const Fast mx = (a.x + b.x) / 2, my = (a.y + b.y) / 2, dx = piece.direction.x(),
                   dy = piece.direction.y();
        // Positive where the left form is the nearer one; q, as many are never met.
        const auto lead = [&](Fast k) {
            return 1 / around_.distance(left, wrapped(mx + k * dx), my + k * dy) -
                   1 / around_.distance(right, wrapped(mx + k * dx), my + k * dy);
        };
        // How far the box of the piece reaches: its sides are measured in different units.
        const Fast sign = lead(0) > 0 ? 1 : -1;
        Fast reach = HUGE_VALL;
        for (const auto& [from, d, lower, upper] : {std::tuple{mx, sign * dx, piece.box[0], piece.box[1]},
                                                    std::tuple{my, sign * dy, piece.box[2], piece.box[3]}})
            if (d != 0) reach = std::min(reach, ((d > 0 ? upper : lower) - from) / d);
        reach *= 1 + 1e-9L;  // ends may lie on the box
        // The height of left less that of right grows along the direction.
        Fast low = 0, high = 0, &end = sign > 0 ? high : low;
        for (end = sign * reach / 1024; std::abs(end) < reach && sign * lead(end) > 0;) end *= 2;
        if (sign * lead(end) > 0) {
            complain(to_string(e) + " " + place(mx, my) + ": its forms do not tie beside it");
            return std::nullopt;
        }
        while (true) {
            const Fast middle = (low + high) / 2;
            if (!(low < middle && middle < high) || high - low < 1e-17L * reach)
                return node(mx + middle * dx, my + middle * dy, a.s);
            (lead(middle) > 0 ? low : high) = middle;
        }
    }
    Fast wrapped(Fast x) const { return is_over_sphere() ? x : x >= 3 ? x - 4 : x < -1 ? x + 4 : x; }

    // --- Faces
    // ------------------------------------------------------------------------------------------------------

    void check_faces(const std::array<Fast, 2>& p, const std::array<Fast, 2>& q) {
        const Surroundings::Nearest at_p = around_.nearest(p[0], p[1]), at_q = around_.nearest(q[0], q[1]);
        for (const auto& [point, at] : {std::pair{p, at_p}, {q, at_q}})
            if (!around_.form(at.item).valid() && at.lead > around_.tolerance())
                return complain(place(point[0], point[1]) + ": " + around_.name(at.item) +
                                " is nearest, but has no form");
        const Complex zp = chart(p[0], p[1]), zq = chart(q[0], q[1]);
        IdVector<FaceId, Fast> turns;
        for (std::size_t i = 0; i < dcel_.face_count(); ++i) turns.push_back(0);
        for (const EdgeId e : d_.edges.ids()) {
            const std::optional<Fast> angle = turn(e, zp, zq);
            if (!angle) return;  // a point next to an edge
            turns[dcel_.face(Dcel::half_edge(e))] += *angle;
            turns[dcel_.face(Dcel::half_edge(e, 1))] -= *angle;
        }
        std::vector<FaceId> of_p, of_q;
        for (const FaceId f : turns.ids()) {
            const Fast times = turns[f] / (2 * std::numbers::pi_v<Fast>);
            if (std::abs(times) < 0.01L) continue;
            if (std::abs(times - 1) < 0.01L)
                of_p.push_back(f);
            else if (std::abs(times + 1) < 0.01L)
                of_q.push_back(f);
            else
                return complain(to_string(f) + ": winds " + text(times) + " times around " +
                                place(p[0], p[1]) + " and not " + place(q[0], q[1]));
        }
        const FormId nearest_p = around_.form(at_p.item), nearest_q = around_.form(at_q.item);
        if (of_p.empty() && of_q.empty()) {
            if (nearest_p != nearest_q)
                complain("nothing parts " + place(p[0], p[1]) + " of " + to_string(nearest_p) + " from " +
                         place(q[0], q[1]) + " of " + to_string(nearest_q));
        } else if (of_p.size() != 1 || of_q.size() != 1) {
            complain("faces " + name(of_p) + " and not " + name(of_q) + " hold " + place(p[0], p[1]));
        } else {
            if (d_.face_forms[of_p[0]] != nearest_p)
                complain(place(p[0], p[1]) + " of " + to_string(nearest_p) + " lies in " +
                         to_string(of_p[0]));
            if (d_.face_forms[of_q[0]] != nearest_q)
                complain(place(q[0], q[1]) + " of " + to_string(nearest_q) + " lies in " +
                         to_string(of_q[0]));
        }
    }

    /// How far (z - p) / (z - q) turns along an edge; none where p or q is too close to it.
    std::optional<Fast> turn(EdgeId e, const Complex& p, const Complex& q) {
        const auto& nodes = traces_[e.value].nodes;
        const auto image = [&](const Node& n) { return (n.z - p) / (n.z - q); };
        Fast sum = 0;
        for (std::size_t i = 0; i + 1 < nodes.size(); ++i) {
            const std::optional<Fast> part = turn(e, nodes[i], nodes[i + 1], image, 20);
            if (!part) return std::nullopt;
            sum += *part;
        }
        return sum;
    }
    // Nodes as far apart as this from p and q have their arc beside them: arcs bend by little between nodes.
    template <class Image>
    std::optional<Fast> turn(EdgeId e, const Node& a, const Node& b, const Image& image, int depth) {
        const Complex za = image(a), zb = image(b);
        if (std::abs(zb - za) < Fast(0.3) * std::min(std::abs(za), std::abs(zb))) return std::arg(zb / za);
        const std::optional<Node> m = between(e, a, b);
        if (!m || depth == 0) return std::nullopt;
        const std::optional<Fast> first = turn(e, a, *m, image, depth - 1),
                                  second = turn(e, *m, b, image, depth - 1);
        if (!first || !second) return std::nullopt;
        return *first + *second;
    }

    const RadialBaseProblem& problem_;
    Surroundings around_;
    const MinimizationDiagram& d_;
    const Dcel& dcel_;
    std::vector<Trace> traces_;
    std::vector<std::string> complaints_;
};

}  // namespace vcell::radial
