#include "unfold.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <utility>

#include "../../primitives/bases/radial_base.hpp"
#include "trims.hpp"

namespace vcell {

namespace {

using Polyline = Unfolding::Polyline;
using Directions = std::vector<Vec3>;  // canonical points; over a sphere only their directions count

/// A side of the cube or box, seen from outside, and its place in the picture.
struct Side {
    Vec3 right, up, out;
    int column, row;

    Vec3 local(const Vec3& p) const { return {right.dot(p), up.dot(p), out.dot(p)}; }
    Vec3 global(const Vec3& p) const { return p.x() * right + p.y() * up + p.z() * out; }
};

const std::array<Side, 6> all_sides{{{{0, 0, 1}, {0, 1, 0}, {-1, 0, 0}, -1, 0},
                                     {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, 0, 0},
                                     {{0, 0, -1}, {0, 1, 0}, {1, 0, 0}, 1, 0},
                                     {{-1, 0, 0}, {0, 1, 0}, {0, 0, -1}, 2, 0},
                                     {{1, 0, 0}, {0, 0, -1}, {0, 1, 0}, 0, 1},
                                     {{1, 0, 0}, {0, 0, 1}, {0, -1, 0}, 0, -1}}};

void add_cut(std::vector<double>& cuts, double from, double to) {
    if (from * to < 0) cuts.push_back(from / (from - to));
}

/// The cube around a sphere, projected from the centre. All but one point has an image on a side.
class Cube {
public:
    static constexpr std::size_t side_count = 6;
    static constexpr int borders = 2;  // coordinates that end where a side does
    static constexpr bool has_hole = true;

    explicit Cube(const RadialBaseProblem&) {}

    Vec2 half() const { return {1, 1}; }
    Vec2 middle(const Side& side) const { return {2.0 * side.column, 2.0 * side.row}; }
    Vec2 placed(const Vec2& middle, const Vec2& p) const { return middle + p; }
    double deviation(const Vec3& from, const Vec3& middle, const Vec3& to) const {
        return ((from + to).normalized() - middle.normalized()).norm();
    }
    double reach(const Vec3& p) const { return std::max(std::abs(p.x()), std::abs(p.y())); }
    Vec2 retracted(const Vec3& p, const Vec3&) const { return p.head<2>() / std::max(reach(p), p.z()); }
    void add_cuts(const Vec3& p, const Vec3& q, std::vector<double>& at) const {
        for (const double sign : {-1.0, 1.0}) {
            add_cut(at, p.x() - sign * p.z(), q.x() - sign * q.z());
            add_cut(at, p.y() - sign * p.z(), q.y() - sign * q.z());
            add_cut(at, p.x() - sign * p.y(), q.x() - sign * q.y());
        }
    }
    /// The polygon's corners on the way between images that do not join.
    std::vector<Vec2> way_around(const Vec2&, const Vec2&) const { return {}; }
};

/// Four sides of a box around a cylinder, projected from the axis. All but one line has an image on a side.
class Strips {
public:
    static constexpr std::size_t side_count = 4;  // the first ones
    static constexpr int borders = 1;
    static constexpr bool has_hole = false;

    explicit Strips(const RadialBaseProblem& problem) : low_(problem.stretch[0]), high_(problem.stretch[1]) {}

    Vec2 half() const { return Vec2(0.25, 0.5) * (high_ - low_); }
    Vec2 middle(const Side& side) const {
        return {2 * side.column * half().x(), 2 * side.row * half().y() + 0.5 * (low_ + high_)};
    }
    Vec2 placed(const Vec2& middle, const Vec2& p) const { return {middle.x() + half().x() * p.x(), p.y()}; }
    /// From the image of the chord, which is drawn straight, though that of a line is not.
    double deviation(const Vec3& from, const Vec3& middle, const Vec3& to) const {
        const bool is_ahead = std::abs(middle.z()) >= std::abs(middle.x());
        const auto out = [&](const Vec3& p) { return is_ahead ? p.z() : p.x(); };
        if (out(from) * out(middle) <= 0 || out(to) * out(middle) <= 0)
            return std::numeric_limits<double>::infinity();
        const auto image = [&](const Vec3& p) {
            return Vec2((is_ahead ? p.x() : p.z()) / out(p), p.y() / half().y());
        };
        const Vec2 chord = image(to) - image(from), way = image(middle) - image(from);
        const double share = chord.isZero(0) ? 0 : std::clamp(way.dot(chord) / chord.squaredNorm(), 0.0, 1.0);
        return (way - share * chord).norm();
    }
    double reach(const Vec3& p) const { return std::abs(p.x()); }
    Vec2 retracted(const Vec3& p, const Vec3& middle) const {
        const bool inside = reach(middle) < middle.z();
        return {inside ? std::clamp(p.x() / p.z(), -1.0, 1.0) : middle.x() < 0 ? -1.0 : 1.0, p.y()};
    }
    void add_cuts(const Vec3& p, const Vec3& q, std::vector<double>& at) const {
        for (const double sign : {-1.0, 1.0}) add_cut(at, p.x() - sign * p.z(), q.x() - sign * q.z());
        add_cut(at, p.x(), q.x());
    }
    /// Over the line without image: by way of the lower end, below all faces.
    std::vector<Vec2> way_around(const Vec2& from, const Vec2& to) const {
        if (from.x() * to.x() > -0.5) return {};
        return {{from.x(), low_}, {to.x(), low_}};
    }

private:
    double low_, high_;
};

/// The base but for one point (sphere) or one line (cylinder) mapped onto one side, which stays as it is: the
/// rest goes to the side's boundary. So a closed polyline has a closed polygon as its image, and the polygon
/// encloses what the polyline separates from that point.
template <class Sides>
class Retraction {
public:
    struct Piece {
        Vec2 from, to;
        double beyond;  // of its middle
        bool inside() const { return beyond < 1; }
    };

    Retraction(const Side& side, const Sides& sides) : side_(side), sides_(sides) {}

    /// The point without image, of a sphere.
    Vec3 hole() const { return side_.global({lean_x, lean_y, -1}); }

    /// Where a point has its own image, as the side's coordinates.
    Vec2 operator()(const Vec3& p) const {
        const Vec3 x = leaned(side_.local(p));
        return sides_.retracted(x, x);
    }
    /// More than 1: the point is on another side.
    double beyond(const Vec3& p) const { return local_beyond(side_.local(p)); }

    /// Appends the image of a chord in pieces that join.
    void append_image(const Vec3& from, const Vec3& to, std::vector<Piece>& pieces) const {
        const Vec3 a = side_.local(from), b = side_.local(to);
        std::vector<double> halves{0};
        add_cut(halves, a.z(), b.z());
        halves.push_back(1);
        bool is_first = true;
        for (std::size_t i = 0; i + 1 < halves.size(); ++i) {
            const Vec3 p = leaned(a + halves[i] * (b - a)), q = leaned(a + halves[i + 1] * (b - a));
            // Places between which the chord's image is straight, or drawn so.
            std::vector<double> at{0, 1};
            sides_.add_cuts(p, q, at);
            std::sort(at.begin(), at.end());
            for (std::size_t k = 0; k + 1 < at.size(); ++k) {
                const Vec3 s = p + at[k] * (q - p), e = p + at[k + 1] * (q - p), middle = 0.5 * (s + e);
                const Piece piece{sides_.retracted(s, middle), sides_.retracted(e, middle),
                                  local_beyond(middle)};
                if (!is_first) go_around(pieces, piece.from);
                is_first = false;
                pieces.push_back(piece);
            }
        }
    }

private:
    // Symmetric scenes have vertices opposite to the middle of a side, so the hole is a little aside.
    static constexpr double lean_x = 0.01371, lean_y = 0.00729;

    static Vec3 leaned(const Vec3& p) {
        const double behind = std::min(p.z(), 0.0);
        return {p.x() + lean_x * behind, p.y() + lean_y * behind, p.z()};
    }
    double local_beyond(const Vec3& p) const {
        return p.z() > 0 ? sides_.reach(p) / p.z() : std::numeric_limits<double>::infinity();
    }
    void go_around(std::vector<Piece>& pieces, const Vec2& to) const {
        std::vector<Vec2> way = sides_.way_around(pieces.back().to, to);
        if (way.empty()) return;
        way.push_back(to);
        for (const Vec2& next : way)
            pieces.push_back({pieces.back().to, next, std::numeric_limits<double>::infinity()});
    }

    const Side& side_;
    Sides sides_;
};

/// p, q, r counter-clockwise, seen from outside the sphere.
bool turns_left(const Vec3& p, const Vec3& q, const Vec3& r) { return p.cross(q).dot(r) > 0; }

template <class Sides>
class Unfolder {
public:
    Unfolder(const Cell& cell, const RadialBaseProblem& problem)
        : cell_(cell), frame_(problem.frame), sides_(problem) {}

    Unfolding unfold(std::span<const std::vector<Vec3>> lines) {
        add_panels();
        for (const CellFace& face : cell_.faces) add_face(face);
        for (const CellEdge& edge : cell_.edges) add_line(sampled(edge), result_.edges.emplace_back());
        for (const std::vector<Vec3>& line : lines) {
            Directions points;
            for (const Vec3& p : line) points.push_back(canonical(p));
            add_line(points, result_.lines.emplace_back());
        }
        for (const CellVertex& vertex : cell_.vertices) add_vertex(vertex);
        return std::move(result_);
    }

private:
    void add_panels() {
        for (const Side& side : std::span(all_sides).first(Sides::side_count)) {
            panels_.push_back({side, {side, sides_}, sides_.middle(side)});
            result_.panels.push_back({world_name(side.out), panels_.back().middle - sides_.half(),
                                      panels_.back().middle + sides_.half()});
        }
    }
    /// Where it points in the world: "+x", or of a tube along no axis of it "(0.89, 0, -0.45)".
    std::string world_name(const Vec3& direction) const {
        const Vec3 world = frame_.rotation.transpose() * direction;
        std::array<std::string, 3> parts;
        for (std::size_t k = 0; k < 3; ++k) {
            const double x = std::round(100 * world[static_cast<Eigen::Index>(k)]) / 100;
            if (std::abs(x) == 1) return (x > 0 ? "+" : "-") + std::string(1, "xyz"[k]);
            parts[k] = fmt::format("{:g}", x == 0 ? 0.0 : x);
        }
        return fmt::format("({}, {}, {})", parts[0], parts[1], parts[2]);
    }

    struct Panel {
        const Side& side;
        Retraction<Sides> retraction;
        Vec2 middle;
    };
    using Piece = typename Retraction<Sides>::Piece;
    Vec2 placed(const Panel& panel, const Vec2& p) const { return sides_.placed(panel.middle, p); }

    // ---- Curves as polylines ----

    template <class Curve>
    void refine(const Curve& curve, double from, double to, int depth, Directions& points) const {
        constexpr double tolerance = 2e-5;  // of a panel's half
        constexpr int deepest = 12;
        const double half_way = 0.5 * (from + to);
        const Vec3 end = curve(to);
        // How far the curve is from a chord, as the picture's panels show it.
        if (depth < deepest && sides_.deviation(points.back(), curve(half_way), end) > tolerance) {
            refine(curve, from, half_way, depth + 1, points);
            refine(curve, half_way, to, depth + 1, points);
        } else {
            points.push_back(end);
        }
    }

    /// A curve over [knots.front(), knots.back()]. Four pieces for each span: none turns by a quarter.
    template <class Curve>
    Directions sampled(const Knots& knots, const Curve& curve) const {
        Directions points{curve(knots.front())};
        for (std::size_t i = 0; i + 1 < knots.size(); ++i) {
            const double step = 0.25 * (knots[i + 1] - knots[i]);
            if (step == 0) continue;
            for (int k = 0; k < 4; ++k)
                refine(curve, knots[i] + k * step, knots[i] + (k + 1) * step, 0, points);
        }
        return points;
    }

    Vec3 canonical(const Vec3& world) const { return frame_.to_canonical(world); }

    Directions sampled(const CellEdge& edge) const {
        return sampled(edge.curve.knots, [&](double t) { return canonical(edge.curve.evaluate(t)); });
    }

    Directions sampled(const TrimCurve& trim, const RationalPatch& surface) const {
        return sampled(trim.curve.knots, [&](double t) {
            if (trim.edge) {
                const RationalCurve3& curve = cell_.edges[*trim.edge].curve;
                return canonical(curve.evaluate(edge_parameter(trim, curve, t)));
            }
            const Vec2 uv = trim.curve.evaluate(t);
            return canonical(surface.evaluate(uv.x(), uv.y()));
        });
    }

    // ---- Faces ----

    void add_face(const CellFace& face) {
        std::vector<Directions> loops;
        std::array<Vec3, 2> on_edge{Vec3::Zero(), Vec3::Zero()};  // a piece of an edge, the face on its left
        for (const TrimmedPatch& patch : face.patches)
            for (const auto& loop : patch.loops) {
                Directions& points = loops.emplace_back();
                for (const TrimCurve& trim : loop) {
                    const Directions curve = sampled(trim, patch.surface);
                    // Not the last piece: where the loop goes on, ends differ by their rounding.
                    for (std::size_t i = 0; trim.edge && i + 2 < curve.size(); ++i) {
                        const Vec3 from = curve[i].normalized(), to = curve[i + 1].normalized();
                        if ((to - from).norm() > (on_edge[1] - on_edge[0]).norm()) on_edge = {from, to};
                    }
                    points.insert(points.end(), curve.begin(), curve.end() - 1);
                }
            }
        std::vector<Polyline>& polygons = result_.faces.emplace_back();
        for (const Panel& panel : panels_) {
            for (const Directions& loop : loops) add_polygon(panel, loop, polygons);
            if (Sides::has_hole && holds(loops, on_edge, panel.retraction.hole())) {
                const Vec2 a = panel.middle - sides_.half(), b = panel.middle + sides_.half();
                polygons.push_back({a, {b.x(), a.y()}, b, {a.x(), b.y()}});
            }
        }
    }

    /// Whether loops, the face on their left, enclose q: by the sides that q and the great circle's arc to a
    /// point of the boundary are on.
    static bool holds(const std::vector<Directions>& loops, const std::array<Vec3, 2>& on_edge,
                      const Vec3& q) {
        const Vec3 m = 0.5 * (on_edge[0] + on_edge[1]);
        bool result = turns_left(on_edge[0], on_edge[1], q);
        for (const Directions& loop : loops)
            for (std::size_t i = 0; i < loop.size(); ++i) {
                const Vec3 a = loop[i].normalized(), b = loop[(i + 1) % loop.size()].normalized();
                if (a == on_edge[0] && b == on_edge[1]) continue;
                const bool side = turns_left(q, a, m);
                if (turns_left(a, m, b) == side && turns_left(m, b, q) == side && turns_left(b, q, a) == side)
                    result = !result;
            }
        return result;
    }

    void add_polygon(const Panel& panel, const Directions& loop, std::vector<Polyline>& polygons) const {
        std::vector<Piece> pieces;
        for (std::size_t i = 0; i < loop.size(); ++i)
            panel.retraction.append_image(loop[i], loop[(i + 1) % loop.size()], pieces);
        // On the boundary only corners count.
        Polyline polygon;
        for (const Piece& piece : pieces) {
            if (!piece.inside() && polygon.size() >= 2 &&
                along_one_side(polygon.end()[-2], polygon.back(), piece.from))
                polygon.pop_back();
            polygon.push_back(piece.from);
        }
        if (polygon.size() < 3) return;
        for (Vec2& p : polygon) p = placed(panel, p);
        polygons.push_back(std::move(polygon));
    }
    static bool along_one_side(const Vec2& a, const Vec2& b, const Vec2& c) {
        for (int k = 0; k < Sides::borders; ++k)
            if (std::abs(b[k]) == 1 && a[k] == b[k] && c[k] == b[k]) return true;
        return false;
    }

    // ---- Edges and vertices ----

    // Lines that run along the border of two panels are drawn in both.
    void add_line(const Directions& points, std::vector<Polyline>& lines) const {
        constexpr double border = 1 + 1e-6;
        for (const Panel& panel : panels_) {
            bool goes_on = false;
            for (std::size_t i = 0; i + 1 < points.size(); ++i) {
                std::vector<Piece> pieces;
                panel.retraction.append_image(points[i], points[i + 1], pieces);
                for (const Piece& piece : pieces) {
                    const bool is_seen = piece.beyond <= border;
                    if (is_seen) {
                        if (!goes_on) lines.push_back({placed(panel, piece.from)});
                        lines.back().push_back(placed(panel, piece.to));
                    }
                    goes_on = is_seen;
                }
            }
        }
    }

    void add_vertex(const CellVertex& vertex) {
        const Vec3 p = canonical(vertex.point);
        const Panel& panel = *std::ranges::min_element(
            panels_, {}, [&](const Panel& candidate) { return candidate.retraction.beyond(p); });
        result_.vertices.push_back(placed(panel, panel.retraction(p)));
    }

    const Cell& cell_;
    const BaseFrame frame_;
    const Sides sides_;
    std::vector<Panel> panels_;
    Unfolding result_;
};

}  // namespace

Unfolding unfold(const Cell& cell, std::span<const std::vector<Vec3>> lines) {
    const RadialBaseProblem problem = radial_base_problem(base_alone(cell.scene));
    return problem.chart.is_sphere() ? Unfolder<Cube>(cell, problem).unfold(lines)
                                     : Unfolder<Strips>(cell, problem).unfold(lines);
}

}  // namespace vcell
