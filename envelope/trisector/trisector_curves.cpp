#include "trisector_curves.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>

#include "../../core/curves/restricted_curve.hpp"
#include "../../core/errors.hpp"
#include "../../primitives/bases/feet.hpp"
#include "../../primitives/bisectors/vertex_roots.hpp"
#include "../../primitives/objects/message.hpp"
#include "../voronoi_cell.hpp"

namespace vcell {

namespace {

constexpr Site first = Site{Site::Kind::Object, 0}, second = Site{Site::Kind::Object, 1};

// A side of the region: p[axis] = bound.
struct Side {
    int number;  // as TrisectorCurve::ends counts
    int axis;
    double bound;

    double inwards(const Vec3& p) const { return number % 2 == 1 ? bound - p[axis] : p[axis] - bound; }
};

std::array<Side, 6> sides_of(const Box& region) {
    std::array<Side, 6> sides;
    for (int i = 0; i < 6; ++i) sides[i] = {i, i / 2, (i % 2 == 1 ? region.max : region.min)[i / 2]};
    return sides;
}

[[noreturn]] void fail(const std::string& what, const Vec3& p) {
    throw UndecidedError("the trisector " + what + " near " + to_text(p));
}

// Where the trisector crosses a side of the region.
struct Crossing {
    int side;
    Vec3 point;
    double error;
};

class Crossings {
public:
    Crossings(const Object& base, const Object& a, const Object& b, const Box& region) : region_(region) {
        // A plane counts by the base's side, a base plane by its own.
        const Vec3 middle = 0.5 * (region.min + region.max), foot = foot_of(base, middle);
        sites_ = {vertex_site(base, beside(base)), vertex_site(a, foot), vertex_site(b, foot)};
        farthest_ = (middle - foot).norm() + region.diagonal();
        for (const Object* o : {&base, &a, &b}) has_plane_ = has_plane_ || std::holds_alternative<Plane>(*o);
    }

    // All on this side; proved to be that many.
    void add(const Side& side, std::vector<Crossing>& out) const {
        const VertexSystem system{{sites_[0], sites_[1], sites_[2], BoxSideSite{side.axis, side.bound}}};
        double least = std::max(system.least_clearance(), -farthest_);
        if (has_plane_) least = std::max(least, 0.0);
        IntervalBox<4> box;
        for (int k = 0; k < 3; ++k) box[k] = Interval(region_.min[k], region_.max[k]);
        constexpr double part = 0x1p-10;
        const double room = part * (region_.max - region_.min)[side.axis];
        box[side.axis] = Interval(side.bound - room, side.bound + room);
        box[3] = Interval(least, std::max(farthest_, least + room));
        const Solutions<4> found = solve(system, box);
        const auto place = [](const IntervalBox<4>& at) {
            return Vec3(at[0].mid(), at[1].mid(), at[2].mid());
        };
        const std::string name = to_string(Site::box_side(static_cast<std::uint32_t>(side.number)));
        for (const Undecided<4>& cluster : found.undecided)
            fail("touches side " + name + " of its region, or runs along it,", place(cluster.hull));
        for (const Root<4>& root : found.unique) {
            if (root.on_boundary) fail("runs through an edge of its region on side " + name, place(root.box));
            double width = 0;
            for (int k = 0; k < 3; ++k) width += root.box[k].width();
            out.push_back({side.number, place(root.box), width});
        }
    }

private:
    Box region_;
    std::array<VertexSite, 3> sites_;
    double farthest_;  // no point of the region is farther from the base's foot
    bool has_plane_ = false;
};

// The parameter of a curve's point nearest to p: of the best of samples' neighbourhood. Where that is an end,
// a closed curve goes on at the other one.
double nearest_parameter(const RationalCurve3& curve, const Vec3& p) {
    constexpr int samples = 16, halvings = 60;  // of each span
    std::vector<double> at;
    for (std::size_t k = 0; k + 1 < curve.knots.size(); ++k)
        for (int i = 0; curve.knots[k] < curve.knots[k + 1] && i < samples; ++i)
            at.push_back(std::lerp(curve.knots[k], curve.knots[k + 1], i / double(samples)));
    at.push_back(curve.domain_end());
    const auto square_distance = [&](double t) { return (curve.evaluate(t) - p).squaredNorm(); };
    const auto refined = [&](std::size_t best) {
        double low = at[best == 0 ? 0 : best - 1], high = at[std::min(best + 1, at.size() - 1)];
        for (int i = 0; i < halvings; ++i) {
            const double middle = std::midpoint(low, high);
            const auto [at_middle, along] = curve.evaluate_with_derivative(middle);
            (along.dot(p - at_middle) > 0 ? low : high) = middle;
        }
        return std::midpoint(low, high);
    };
    const auto best =
        static_cast<std::size_t>(std::ranges::min_element(at, {}, square_distance) - at.begin());
    const double found = refined(best);
    if (best != 0 && best + 1 != at.size()) return found;
    const double other = refined(at.size() - 1 - best);
    return square_distance(other) < square_distance(found) ? other : found;
}

// The points of a curve between its ends, in order.
std::vector<Vec3> points_along(const RationalCurve3& curve, int of_each_span) {
    std::vector<Vec3> points{curve.evaluate(curve.domain_begin())};
    for (std::size_t k = 0; k + 1 < curve.knots.size(); ++k)
        for (int i = 1; curve.knots[k] < curve.knots[k + 1] && i <= of_each_span; ++i)
            points.push_back(
                curve.evaluate(std::lerp(curve.knots[k], curve.knots[k + 1], i / double(of_each_span))));
    return points;
}

// The components that a curve within `error` of the trisector may lie on, and conics through its points.
class Components {
public:
    explicit Components(Trisector all) : all_(std::move(all)) {}

    // That of a spline. Regular as it is between nodes, it lies on one of them: a conic that one of its
    // points is certainly off is another one.
    const TrisectorComponent& of_spline(const RationalCurve3& curve, double error) const {
        constexpr int of_each_span = 4;
        std::vector<const TrisectorComponent*> left;
        const std::vector<Vec3> points = points_along(curve, of_each_span);
        for (const TrisectorComponent& c : all_.components)
            if (c.kind == TrisectorKind::Spline ||
                std::ranges::all_of(points, [&](const Vec3& p) { return may_hold(c, p, error); }))
                left.push_back(&c);
        // All of the components that are no conics have one degree.
        const bool is_told = left.size() == 1 || std::ranges::all_of(left, [](const auto* c) {
                                 return c->kind == TrisectorKind::Spline;
                             });
        if (left.empty() || !is_told) fail("may be one of several curves", points[points.size() / 2]);
        return *left.front();
    }

    // Arcs of a conic or line along a curve beside it.
    static std::vector<RationalCurve3> along(const TrisectorComponent& conic, const RationalCurve3& curve,
                                             bool is_closed) {
        constexpr double least_cosine = 0.2;  // of the turn between two stations
        constexpr int of_each_span = 8;
        std::vector<Vec3> points = points_along(curve, of_each_span), stations;
        for (Vec3& p : points) p = projected(conic, p);
        if (is_closed) points.back() = points.front();
        stations.push_back(points.front());
        Vec3 from = direction(conic, points.front());
        for (std::size_t i = 1; i + 1 < points.size() && conic.kind != TrisectorKind::Line; ++i) {
            const Vec3 to = direction(conic, points[i + 1]);
            if (to.dot(from) * (points[i + 1] - points[i]).dot(to) * (points[i] - points[i - 1]).dot(from) >
                    0 &&
                std::abs(to.dot(from)) > least_cosine)
                continue;
            stations.push_back(points[i]);
            from = direction(conic, points[i]);
        }
        stations.push_back(points.back());
        std::vector<RationalCurve3> arcs;
        for (std::size_t i = 0; i + 1 < stations.size(); ++i) {
            auto arc = trisector_arc(conic, stations[i], stations[i + 1]);
            if (!arc) fail("is a conic of which doubles do not tell an arc", stations[i]);
            arcs.push_back(*std::move(arc));
        }
        return arcs;
    }

private:
    static Vec3 direction(const TrisectorComponent& c, const Vec3& p) {
        if (c.kind == TrisectorKind::Line) return c.direction;
        return c.plane.head<3>().cross((c.quadric * p.homogeneous()).head<3>()).normalized();
    }
    // May a point of the component be within `error` of p? Its numbers are rounded.
    static bool may_hold(const TrisectorComponent& c, const Vec3& p, double error) {
        constexpr double rounding = 0x1p-44;
        if (c.kind == TrisectorKind::Line) {
            const Vec3 m = p - c.point;
            return (m - m.dot(c.direction) * c.direction).norm() <=
                   error + rounding * (m.norm() + p.norm() + c.point.norm());
        }
        const Eigen::Vector4d X = p.homogeneous();
        if (std::abs(c.plane.dot(X)) > error + rounding * c.plane.cwiseAbs().dot(X.cwiseAbs())) return false;
        const Eigen::Vector4d gradient = c.quadric * X;
        const double slope = 2 * gradient.head<3>().norm() + c.quadric.norm() * error;
        return std::abs(X.dot(gradient)) <=
               slope * error + rounding * X.cwiseAbs().dot(c.quadric.cwiseAbs() * X.cwiseAbs());
    }
    // The component's point near p.
    static Vec3 projected(const TrisectorComponent& c, Vec3 p) {
        if (c.kind == TrisectorKind::Line) return c.point + c.direction.dot(p - c.point) * c.direction;
        constexpr int steps = 4;  // of Newton's method, across the curve
        for (int i = 0; i < steps; ++i) {
            const Eigen::Vector4d X = p.homogeneous(), gradient = c.quadric * X;
            Eigen::Matrix<double, 2, 3> J;
            J << c.plane.head<3>().transpose(), 2 * gradient.head<3>().transpose();
            const Eigen::Vector2d value(c.plane.dot(X), X.dot(gradient));
            p -= J.transpose() * (J * J.transpose()).fullPivLu().solve(value);
        }
        return p;
    }

    Trisector all_;
};

TrisectorKind kind_of(const CellEdge& edge) {
    switch (edge.kind) {
        case CurveKind::Line: return TrisectorKind::Line;
        case CurveKind::Circle: return TrisectorKind::Circle;
        case CurveKind::Ellipse: return TrisectorKind::Ellipse;
        case CurveKind::Parabola: return TrisectorKind::Parabola;
        case CurveKind::Hyperbola: return TrisectorKind::Hyperbola;
        case CurveKind::Spline: break;
    }
    return TrisectorKind::Spline;
}

// Between two parameters of an edge of the cell. Where it is cut, its point is `off` from the true one.
struct Part {
    double from, to;
    std::array<int, 2> ends;
    double off;
};

class Clipping {
public:
    Clipping(const Cell& cell, const Box& region) : cell_(cell), region_(region) {
        for (const Side& side : sides_of(region)) {
            const Box& box = cell.scene.box;
            const bool is_shared = side.bound == (side.number % 2 == 1 ? box.max : box.min)[side.axis];
            (is_shared ? shared_ : inner_).push_back(side);
        }
        edges_.resize(cell.edges.size());
    }

    bool cuts() const { return !inner_.empty(); }

    void cross(const Crossings& crossings) {
        std::vector<Crossing> all;
        for (const Side& side : inner_) crossings.add(side, all);
        for (const Crossing& c : all) assign(c);
    }

    // The parts of an edge within the region, in order.
    std::vector<Part> parts(std::size_t e) {
        const CellEdge& edge = cell_.edges[e];
        std::vector<Cut>& cuts = edges_[e];
        std::ranges::sort(cuts, {}, &Cut::at);
        const RationalCurve3& curve = edge.curve;
        std::vector<Cut> stops{{curve.domain_begin(), end_of(edge, 0), 0}};
        stops.insert(stops.end(), cuts.begin(), cuts.end());
        stops.push_back({curve.domain_end(), end_of(edge, 1), 0});
        std::vector<Part> inside;
        for (std::size_t i = 0; i + 1 < stops.size(); ++i) {
            const Cut &from = stops[i], &to = stops[i + 1];
            if (is_inside(edge, from.at, to.at))
                inside.push_back({from.at, to.at, {from.side, to.side}, std::max(from.off, to.off)});
        }
        return inside;
    }

private:
    struct Cut {
        double at;
        int side;
        double off;
    };

    static bool is_between_objects(const CellEdge& edge) {
        return std::ranges::find(edge.sites, first) != edge.sites.end() &&
               std::ranges::find(edge.sites, second) != edge.sites.end();
    }

    // The crossing lies on the edge that is as near as errors allow, if that is one.
    void assign(const Crossing& c) {
        std::optional<std::size_t> on;
        Cut cut{};
        for (std::size_t e = 0; e < cell_.edges.size(); ++e) {
            const CellEdge& edge = cell_.edges[e];
            if (!is_between_objects(edge)) continue;
            const double t = nearest_parameter(edge.curve, c.point);
            const double off = (edge.curve.evaluate(t) - c.point).norm() + c.error;
            if (!(off <= 2 * (edge.error + c.error) + 0x1p-44 * c.point.norm())) continue;
            if (on) fail("passes a side of its region where two of its curves are one to its error", c.point);
            on = e;
            cut = {t, c.side, off};
        }
        if (!on) throw InternalError("a crossing of the trisector with a side of its region is on no edge");
        const auto at = [&](const Cut& other) { return cell_.edges[*on].curve.evaluate(other.at); };
        for (const Cut& other : edges_[*on])
            if ((at(other) - at(cut)).norm() <= 4 * (other.off + cut.off))
                fail("crosses a side of its region in places that are one to its error", c.point);
        edges_[*on].push_back(cut);
    }

    // Between two cuts the curve crosses no side; its point farthest from all of them tells which side it is
    // on.
    bool is_inside(const CellEdge& edge, double from, double to) const {
        if (inner_.empty()) return true;
        constexpr int samples = 64;
        double most = 0;
        for (int i = 0; i <= samples; ++i) {
            const Vec3 p = edge.curve.evaluate(std::lerp(from, to, i / double(samples)));
            double least = HUGE_VAL;
            for (const Side& side : inner_) least = std::min(least, side.inwards(p));
            if (std::abs(least) > std::abs(most)) most = least;
        }
        if (!(std::abs(most) > edge.error))
            fail("runs along a side of its region", edge.curve.evaluate(std::midpoint(from, to)));
        return most > 0;
    }

    // A vertex lies on a side that region and box share, or in a node.
    int end_of(const CellEdge& edge, std::size_t end) const {
        if (edge.vertices.empty()) return -1;
        const CellVertex& v = cell_.vertices[edge.vertices[end]];
        if (std::ranges::all_of(v.sites, [](Site s) { return s.is_object(); })) return -1;
        const auto side = std::ranges::min_element(
            shared_, {}, [&](const Side& s) { return std::abs(s.inwards(v.point)); });
        return side == shared_.end() ? -1 : side->number;
    }

    const Cell& cell_;
    Box region_;
    std::vector<Side> shared_, inner_;  // with the cell's box; within it
    std::vector<std::vector<Cut>> edges_;
};

}  // namespace

std::vector<TrisectorCurve> trisector(const Object& base, const Object& a, const Object& b, const Box& region,
                                      double tolerance) {
    Scene scene;
    scene.base = base;
    scene.objects = {a, b};
    scene.box = box_with_feet(base, region);
    const bool is_cut = scene.box.min != region.min || scene.box.max != region.max;
    // What is proved of an edge is the sum of two errors. A cut adds as much again, and both may be there
    // twice.
    scene.tolerance = is_cut ? tolerance / 8 : tolerance / 2;
    CellOptions options;
    options.measure = false;
    const Cell cell = voronoi_cell(scene, options);
    for (const CellFace& face : cell.faces)
        if (face.site.is_object() && std::ranges::any_of(face.extra_sites, &Site::is_object))
            throw UndecidedError("objects 0 and 1 are equally far from the base all over a surface");
    Clipping clipping(cell, region);
    if (clipping.cuts()) clipping.cross(Crossings(base, a, b, region));
    const Components components(trisector(base, a, b));

    std::vector<TrisectorCurve> curves;
    for (std::size_t e = 0; e < cell.edges.size(); ++e) {
        const CellEdge& edge = cell.edges[e];
        if (!edge.sites[0].is_object() || !edge.sites[1].is_object()) continue;
        const std::size_t before = curves.size();
        const std::vector<Part> parts = clipping.parts(e);
        for (const Part& part : parts) {
            TrisectorCurve curve;
            curve.ends = part.ends;
            curve.error = part.off > 0 ? 2 * (edge.error + part.off) : edge.error;
            curve.kind = kind_of(edge);
            curve.degree = curve.kind == TrisectorKind::Line ? 1 : 2;
            const bool is_whole =
                part.from == edge.curve.domain_begin() && part.to == edge.curve.domain_end();
            curve.is_closed = is_whole && edge.vertices.empty();
            RationalCurve3 arc = is_whole ? edge.curve : restricted(edge.curve, part.from, part.to);
            if (curve.kind == TrisectorKind::Spline) {
                const TrisectorComponent& on = components.of_spline(edge.curve, edge.error);
                curve.kind = on.kind;
                curve.degree = on.degree;
                if (on.kind != TrisectorKind::Spline)
                    curve.arcs = Components::along(on, arc, curve.is_closed);
            }
            if (curve.arcs.empty()) curve.arcs = {std::move(arc)};
            curves.push_back(std::move(curve));
        }
        // A loop that is cut elsewhere than where it is described from goes on there.
        if (edge.vertices.empty() && parts.size() > 1 && parts.front().from == edge.curve.domain_begin() &&
            parts.back().to == edge.curve.domain_end()) {
            TrisectorCurve& head = curves[before];
            TrisectorCurve& tail = curves.back();
            tail.arcs.insert(tail.arcs.end(), head.arcs.begin(), head.arcs.end());
            tail.ends[1] = head.ends[1];
            tail.error = std::max(tail.error, head.error);
            curves.erase(curves.begin() + static_cast<std::ptrdiff_t>(before));
        }
    }
    return curves;
}

}  // namespace vcell
