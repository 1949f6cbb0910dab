/// A brute-force judge of minimization diagrams with cylinders. It shares no code with lower_envelope() but
/// the types. Heights come from their definition: the clearance r at which the point (x, y, r) is r away from
/// the object, solved for in long double, and in 100 digits where that does not tell.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <random>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "oracle.hpp"

namespace vcell::mixed {

using oracle::Point;
using oracle::Real;
using Fast = long double;

/// Solids in canonical coordinates. A plane is given by its height (a x + b y + e) / w.
struct Ball {
    double x, y, z, rho;
};
struct Wall {
    double a, b, e, w;
};
using Solid = std::variant<Ball, Wall, CylinderForm>;

/// Solids over a region. Forms are numbered as in a FormFamily: cylinders after all others.
struct Scene {
    std::string name;
    std::vector<Solid> circular;
    std::vector<CylinderForm> cylinders;
    ConvexRegion region = ConvexRegion::rectangle(-2, -2, 2, 2);

    Scene& ball(double x, double y, double z, double rho) {
        circular.push_back(Ball{x, y, z, rho});
        return *this;
    }
    Scene& wall(double a, double b, double e, double w = 1) {
        circular.push_back(Wall{a, b, e, w});
        return *this;
    }
    Scene& cylinder(double px, double py, double pz, double ax, double ay, double az, double rho) {
        cylinders.push_back({px, py, pz, ax, ay, az, rho});
        return *this;
    }
    std::size_t size() const { return circular.size() + cylinders.size(); }
    Solid solid(std::size_t i) const {
        return i < circular.size() ? circular[i] : Solid(cylinders[i - circular.size()]);
    }

    FormFamily family() const {
        FormFamily f;
        for (const Solid& s : circular)
            if (const Ball* b = std::get_if<Ball>(&s))
                f.forms.push_back(
                    {1, b->x, b->y, 0, 0, (b->z - b->rho) * (b->z + b->rho), 2 * (b->z + b->rho)});
            else
                f.forms.push_back({0, 0, 0, std::get<Wall>(s).a, std::get<Wall>(s).b, std::get<Wall>(s).e,
                                   std::get<Wall>(s).w});
        f.exact = [all = circular](FormId id) {
            if (const Wall* p = std::get_if<Wall>(&all[id.value]))
                return ExactForm{{}, p->a, p->b, p->e, p->w};
            const Ball& b = std::get<Ball>(all[id.value]);
            const Exact x(b.x), y(b.y), z(b.z), rho(b.rho), two(2.0);
            return ExactForm{Exact(1.0), -two * x, -two * y, x * x + y * y + (z - rho) * (z + rho),
                             two * (z + rho)};
        };
        f.cylinders = cylinders;
        return f;
    }
};

// --- Heights ----------------------------------------------------------------------------------------

/// The distance of a point from a solid's surface, and the unit vector away from it.
template <class T>
struct Distance {
    T value;
    std::array<T, 3> away;
};

template <class T>
Distance<T> distance(const Ball& s, const T& x, const T& y, const T& z) {
    using std::sqrt;
    const T dx = x - T(s.x), dy = y - T(s.y), dz = z - T(s.z);
    const T n = sqrt(dx * dx + dy * dy + dz * dz);
    return {n - T(s.rho), {dx / n, dy / n, dz / n}};
}

// The plane a x + b y + c z + e = 0 whose normal is c + w long.
template <class T>
Distance<T> distance(const Wall& s, const T& x, const T& y, const T& z) {
    const T a(s.a), b(s.b), w(s.w), c = (a * a + b * b - w * w) / (2 * w), n = c + w;
    return {(a * x + b * y + c * z + T(s.e)) / n, {a / n, b / n, c / n}};
}

template <class T>
Distance<T> distance(const CylinderForm& s, const T& x, const T& y, const T& z) {
    using std::sqrt;
    const T mx = x - T(s.px), my = y - T(s.py), mz = z - T(s.pz), ax(s.ax), ay(s.ay), az(s.az);
    const T cx = my * az - mz * ay, cy = mz * ax - mx * az, cz = mx * ay - my * ax;  // m x a
    const T cc = cx * cx + cy * cy + cz * cz, aa = ax * ax + ay * ay + az * az, scale = sqrt(cc * aa);
    return {sqrt(cc / aa) - T(s.rho),
            {(ay * cz - az * cy) / scale, (az * cx - ax * cz) / scale, (ax * cy - ay * cx) / scale}};
}

template <class T>
struct Height {
    T v, gx, gy;
    T sensitivity;  ///< of v to the rounding of distances
};

/// The clearance above (x, y). distance - r is convex and falls: from the left Newton's method ascends to the
/// root.
template <class T>
Height<T> height(const Solid& solid, const T& x, const T& y, T r = T(0)) {
    using std::abs;
    const T enough = std::numeric_limits<T>::epsilon() * T(2);
    Distance<T> d;
    for (int i = 0; i < 200; ++i) {
        d = std::visit([&](const auto& s) { return distance<T>(s, x, y, r); }, solid);
        const T step = (d.value - r) / (1 - d.away[2]);
        r += step;
        if (i > 0 && step <= enough * abs(r)) break;
    }
    const T slope = 1 - d.away[2];
    return {r, d.away[0] / slope, d.away[1] / slope, 1 / slope};
}

inline Fast size_of(const Solid& solid, Fast x, Fast y) {
    struct {
        Fast x, y;
        Fast operator()(const Ball& s) const { return std::hypot(x - s.x, y - s.y) + std::abs(s.z) + s.rho; }
        Fast operator()(const Wall& s) const {
            return (std::abs(s.a * x) + std::abs(s.b * y) + std::abs(s.e)) * 2 * s.w /
                   (s.a * s.a + s.b * s.b + s.w * s.w);
        }
        Fast operator()(const CylinderForm& s) const {
            return std::hypot(x - s.px, y - s.py) + std::abs(s.pz) + s.rho;
        }
    } const visitor{x, y};
    return std::visit(visitor, solid);
}

struct Options {
    int samples = 400;                  ///< points of the region whose owner is compared
    std::size_t brute_force_forms = 8;  ///< up to this many forms all triples are tried for missing vertices
};

class Judge {
public:
    Judge(const Scene& scene, const MinimizationDiagram& diagram)
        : d_(diagram), dcel_(diagram.dcel), region_(scene.region) {
        for (std::size_t i = 0; i < scene.size(); ++i) solids_.push_back(scene.solid(i));
        const auto& sides = region_.sides;
        for (std::size_t i = 0; i < sides.size(); ++i) {
            const auto &s = sides[(i + sides.size() - 1) % sides.size()], &t = sides[i];
            const Fast det = Fast(s.a) * t.b - Fast(s.b) * t.a;
            corners_.push_back(
                {(Fast(s.b) * t.c - Fast(t.b) * s.c) / det, (Fast(t.a) * s.c - Fast(s.a) * t.c) / det});
            low_ = {std::min(low_.x, corners_.back().x), std::min(low_.y, corners_.back().y)};
            high_ = {std::max(high_.x, corners_.back().x), std::max(high_.y, corners_.back().y)};
        }
        size_ = std::max(high_.x - low_.x, high_.y - low_.y);
    }

    std::vector<std::string> check(std::mt19937_64& rng, const Options& options) {
        check_structure();
        if (!complaints_.empty()) return complaints_;  // what follows walks the structure
        for (const VertexId v : d_.vertices.ids()) check_vertex(v);
        check_corners();
        if (!complaints_.empty()) return complaints_;  // what follows builds on the refined vertices
        for (const EdgeId e : d_.edges.ids()) trace_edge(e, rng);
        if (!complaints_.empty()) return complaints_;
        check_samples(rng, options.samples);
        check_rim();
        if (solids_.size() <= options.brute_force_forms) check_missing_vertices();
        return complaints_;
    }

    /// The form that is lowest at (x, y).
    FormId owner(Fast x, Fast y) const { return minimal(Point<Fast>{x, y}).front(); }

private:
    // Heights closer than this, relative to their size, are equal: more than the 200 bits after which
    // the engine assumes it, and far less than distinct values ever are by accident.
    static inline const Real kTie{"1e-58"};
    // Chords are halved until they keep apart from the sampled point, but no shorter than this part of the
    // region.
    static constexpr Fast kFinest = 1e-11L;
    static constexpr std::size_t kEnough = 20;  // complaints

    // A stretch of an arc, and how far it is from its chord.
    struct Segment {
        Point<Fast> from, to;
        Fast band = 0;
        std::uint32_t edge = 0;
        std::int32_t piece = -1;  // -1: of a circle or the rim
    };

    void complain(const std::string& what) {
        if (complaints_.size() < kEnough) complaints_.push_back(what);
    }
    template <class Ids>
    static std::string name(const Ids& ids) {
        std::string s = "{";
        for (const auto& id : ids) s += (s.size() > 1 ? " " : "") + to_string(id);
        return s + "}";
    }
    static std::string text(Fast v) { return std::to_string(static_cast<double>(v)); }
    static std::string place(const Point<Fast>& p) { return "(" + text(p.x) + ", " + text(p.y) + ")"; }
    static Point<Fast> fast(const Point<Real>& p) { return {p.x.convert_to<Fast>(), p.y.convert_to<Fast>()}; }
    static Fast apart(const Point<Fast>& p, const Point<Fast>& q) { return std::hypot(p.x - q.x, p.y - q.y); }
    bool in_region(const Point<Fast>& p, Fast margin) const {
        return std::ranges::all_of(region_.sides, [&](const auto& s) {
            return s.a * p.x + s.b * p.y + s.c >= margin * std::hypot(Fast(s.a), Fast(s.b));
        });
    }

    // --- Brute force ----------------------------------------------------------------------------

    Fast rounding(std::size_t form, const Point<Fast>& p, const Height<Fast>& h) const {
        const Fast eps = std::numeric_limits<Fast>::epsilon();
        return 64 * eps *
               (h.sensitivity * (size_of(solids_[form], p.x, p.y) + h.v) +
                (std::abs(h.gx) + std::abs(h.gy)) * (std::abs(p.x) + std::abs(p.y)));
    }
    /// All forms that attain the minimum at p, ascending, as far as T tells.
    template <class T>
    std::vector<FormId> minimal(const Point<T>& p) const {
        Point<Fast> q;
        if constexpr (std::is_same_v<T, Real>)
            q = fast(p);
        else
            q = p;
        std::vector<Fast> value(solids_.size()), error(solids_.size());
        Fast top = HUGE_VALL;
        for (std::size_t i = 0; i < solids_.size(); ++i) {
            const Height<Fast> h = height<Fast>(solids_[i], q.x, q.y);
            value[i] = h.v;
            error[i] = rounding(i, q, h);
            top = std::min(top, h.v + error[i]);
        }
        std::vector<FormId> result;
        std::optional<T> best;
        for (std::size_t i = 0; i < solids_.size(); ++i) {
            if (value[i] - error[i] > top) continue;
            const FormId f{static_cast<std::uint32_t>(i)};
            if constexpr (std::is_same_v<T, Real>) {
                const Real v = height<Real>(solids_[i], p.x, p.y, Real(value[i])).v, slack = kTie * abs(v);
                if (best && v > *best + slack) continue;
                if (best && v < *best - slack) result.clear();
                if (!best || v < *best) best = v;
            }
            result.push_back(f);
        }
        return result;
    }

    // --- Structure and labels -------------------------------------------------------------------

    void check_structure() {
        if (const auto defect = dcel_.find_defect()) return complain("dcel: " + defect->what);
        if (d_.vertices.size() != dcel_.vertex_count() || d_.edges.size() != dcel_.edge_count() ||
            d_.face_forms.size() != dcel_.face_count() ||
            d_.forms.size() + d_.cylinders.size() != solids_.size() ||
            d_.vertex_offsets_.size() != d_.vertices.size() + 1 ||
            d_.side_offsets_.size() != d_.vertices.size() + 1 ||
            d_.edge_offsets_.size() != d_.edges.size() + 1 ||
            (!d_.cylinders.empty() && d_.piece_offsets_.size() != d_.edges.size() + 1))
            return complain("sizes: the diagram's arrays do not match");
        for (const FaceId f : d_.face_forms.ids())
            if (d_.face_forms[f].valid() != (f != Dcel::unbounded_face()) ||
                (d_.face_forms[f].valid() && d_.face_forms[f].value >= solids_.size()))
                complain(to_string(f) + ": label " + to_string(d_.face_forms[f]));
        for (const VertexId v : d_.vertices.ids()) check_label(to_string(v), d_.label(v));
        for (const EdgeId e : d_.edges.ids()) check_edge_structure(e);
        if (complaints_.empty())
            for (const VertexId v : d_.vertices.ids()) check_maximal(v);
    }

    void check_label(const std::string& where, std::span<const FormId> label) {
        for (std::size_t i = 0; i < label.size(); ++i)
            if (label[i].value >= solids_.size() || (i > 0 && !(label[i - 1] < label[i])))
                complain(where + ": label " + name(label));
    }

    void check_edge_structure(EdgeId e) {
        const auto& edge = d_.edges[e];
        const HalfEdgeId h = Dcel::half_edge(e);
        const std::string where = to_string(e);
        check_label(where, d_.label(e));
        const FormId left = d_.face_forms[dcel_.face(h)], right = d_.face_forms[dcel_.face(Dcel::twin(h))];
        if (edge.left != left || edge.right != right || !left.valid())
            complain(where + ": sides are not its faces'");
        if (edge.on_rim() == right.valid()) complain(where + ": wrong about being on the rim");
        if (!edge.on_rim() && left == right) complain(where + ": the same form on both sides");
        if (edge.on_rim() && edge.side >= region_.sides.size()) complain(where + ": side out of range");
        const bool has_pieces = !edge.on_rim() && !(d_.is_circular(left) && d_.is_circular(right));
        if (d_.pieces(e).empty() == has_pieces)
            complain(where + ": pieces of an arc missing or uncalled for");
        const auto includes = [&](std::span<const FormId> label, FormId f) {
            return !f.valid() || std::ranges::find(label, f) != label.end();
        };
        if (!includes(d_.label(e), left) || !includes(d_.label(e), right))
            complain(where + ": label " + name(d_.label(e)) + " lacks a face's");
        for (const VertexId v : {dcel_.origin(h), dcel_.target(h)}) {
            if (!v.valid()) continue;
            for (const FormId f : d_.label(e))
                if (!includes(d_.label(v), f)) complain(to_string(v) + ": label lacks that of " + where);
            if (edge.on_rim() && std::ranges::find(d_.sides(v), edge.side) == d_.sides(v).end())
                complain(to_string(v) + ": ends a rim edge without lying on its side");
        }
    }

    /// A vertex of degree two between like edges has no business there.
    void check_maximal(VertexId v) {
        const HalfEdgeId h = dcel_.outgoing(v);
        if (!h.valid()) {
            if (d_.label(v).size() < 2) complain(to_string(v) + ": isolated without a tie");
            return;
        }
        const HalfEdgeId g = dcel_.next_around_origin(h);
        if (g == h || dcel_.next_around_origin(g) != h || Dcel::edge(g) == Dcel::edge(h)) return;
        const auto &a = d_.edges[Dcel::edge(h)], &b = d_.edges[Dcel::edge(g)];
        if (a.side == b.side && std::minmax(a.left, a.right) == std::minmax(b.left, b.right) &&
            std::ranges::equal(d_.label(Dcel::edge(h)), d_.label(v)) &&
            std::ranges::equal(d_.label(Dcel::edge(g)), d_.label(v)))
            complain(to_string(v) + ": joins two edges that are one");
    }

    // --- Vertices -------------------------------------------------------------------------------

    /// A function that vanishes at a vertex: the difference of two forms, or a side.
    struct Curve {
        std::size_t f, g;  // forms; of a side: the side and SIZE_MAX
    };
    std::array<Real, 3> value(const Curve& c, const Point<Real>& p) const {
        if (c.g == SIZE_MAX) {
            const auto& s = region_.sides[c.f];
            return {Real(s.a) * p.x + Real(s.b) * p.y + Real(s.c), Real(s.a), Real(s.b)};
        }
        const Point<Fast> q = fast(p);
        const auto jet = [&](std::size_t i) {
            return height<Real>(solids_[i], p.x, p.y, Real(height<Fast>(solids_[i], q.x, q.y).v));
        };
        const Height<Real> a = jet(c.f), b = jet(c.g);
        return {a.v - b.v, a.gx - b.gx, a.gy - b.gy};
    }
    static Real sine(const std::array<Real, 3>& u, const std::array<Real, 3>& v) {
        const Real norm = sqrt((u[1] * u[1] + u[2] * u[2]) * (v[1] * v[1] + v[2] * v[2]));
        return norm > 0 ? Real(abs(u[1] * v[2] - u[2] * v[1]) / norm) : Real(0);
    }
    template <class System>
    std::optional<Point<Real>> newton(Point<Real> p, System&& system) const {
        const Real enough = Real(size_) * Real("1e-85");
        for (int i = 0; i < 40; ++i) {
            const auto [u, v] = system(p);
            const Real det = u[1] * v[2] - u[2] * v[1];
            if (det == 0) return std::nullopt;
            const Real dx = (u[2] * v[0] - v[2] * u[0]) / det, dy = (v[1] * u[0] - u[1] * v[0]) / det;
            if (abs(dx) + abs(dy) > Real(size_)) return std::nullopt;
            p = {p.x + dx, p.y + dy};
            if (abs(dx) + abs(dy) <= enough) return p;
        }
        return std::nullopt;
    }

    /// The vertex in 100 digits, from its label and sides alone: where the two of its curves meet that cross
    /// at the widest angle; if all touch, where two have one direction, or the gradient of a difference (its
    /// slope along a side) vanishes.
    std::optional<Point<Real>> refine(VertexId v) const {
        const Point<Real> start{Real(d_.vertices[v].point.x()), Real(d_.vertices[v].point.y())};
        std::vector<Curve> curves;
        for (const std::uint32_t s : d_.sides(v)) curves.push_back({s, SIZE_MAX});
        const auto label = d_.label(v);
        for (std::size_t i = 0; i < label.size(); ++i)
            for (std::size_t j = 0; j < i; ++j) curves.push_back({label[i].value, label[j].value});
        Real widest = 0;
        std::optional<std::pair<Curve, Curve>> best;
        std::vector<std::array<Real, 3>> values;
        for (const Curve& c : curves) values.push_back(value(c, start));
        for (std::size_t i = 0; i < curves.size(); ++i)
            for (std::size_t j = 0; j < i; ++j)
                if (const Real s = sine(values[i], values[j]); s > widest) {
                    widest = s;
                    best = {curves[i], curves[j]};
                }
        if (best)  // fails, by far too slow, if these touch but for the error of the start
            if (const auto p = newton(start, [&](const Point<Real>& q) {
                    return std::pair(value(best->first, q), value(best->second, q));
                }))
                return p;
        std::optional<Curve> difference;  // of the smallest gradient
        Real least = 0;
        for (std::size_t i = 0; i < curves.size(); ++i) {
            const Real norm = values[i][1] * values[i][1] + values[i][2] * values[i][2];
            if (curves[i].g == SIZE_MAX || (difference && norm >= least)) continue;
            difference = curves[i];
            least = norm;
        }
        if (!difference) return std::nullopt;
        const Real h = Real(size_) * Real("1e-30");
        if (d_.sides(v).empty() && label.size() > 2 && least > Real("1e-20"))
            return newton(start, [&](const Point<Real>& p) {
                const auto turn = [&](const Point<Real>& q) {
                    const auto a = value(curves[0], q), b = value(curves[1], q);
                    return Real(a[1] * b[2] - a[2] * b[1]);
                };
                const Real at = turn(p);
                return std::pair(value(curves[0], p), std::array{at, Real((turn({p.x + h, p.y}) - at) / h),
                                                                 Real((turn({p.x, p.y + h}) - at) / h)});
            });
        if (d_.sides(v).empty())
            return newton(start, [&](const Point<Real>& p) {
                const auto at = value(*difference, p), x = value(*difference, {p.x + h, p.y}),
                           y = value(*difference, {p.x, p.y + h});
                return std::pair(std::array{at[1], Real((x[1] - at[1]) / h), Real((y[1] - at[1]) / h)},
                                 std::array{at[2], Real((x[2] - at[2]) / h), Real((y[2] - at[2]) / h)});
            });
        const auto& s = region_.sides[d_.sides(v)[0]];
        return newton(start, [&](const Point<Real>& p) {
            const auto slope = [&](const Point<Real>& q) {
                const auto at = value(*difference, q);
                return Real(at[1] * Real(s.b) - at[2] * Real(s.a));
            };
            const Real at = slope(p);
            return std::pair(value(Curve{d_.sides(v)[0], SIZE_MAX}, p),
                             std::array{at, Real((slope({p.x + h, p.y}) - at) / h),
                                        Real((slope({p.x, p.y + h}) - at) / h)});
        });
    }

    /// How coarsely a point near p may have been taken for a vertex.
    Fast assumed_width(const Point<Fast>& p, Fast error) const {
        Fast width = 0;
        for (const Assumption& a : d_.assumptions)
            if (apart(p, {a.place.x(), a.place.y()}) <= error + 2 * a.width)
                width = std::max<Fast>(width, a.width);
        return width;
    }

    void check_vertex(VertexId v) {
        const std::string where =
            to_string(v) + " at " + place({d_.vertices[v].point.x(), d_.vertices[v].point.y()});
        const auto& stated = d_.vertices[v];
        const Point<Fast> near{stated.point.x(), stated.point.y()};
        at_.push_back(near);
        if (!(stated.error <= 1e-3 * size_)) return complain(where + ": useless error bound");
        const Fast width = assumed_width(near, stated.error);
        if (width > 1e-30L * size_) return check_assumed_vertex(v, where, width);
        const auto p = refine(v);
        if (!p) return complain(where + ": its label " + name(d_.label(v)) + " determines no point");
        at_.back() = fast(*p);
        const Real dx = p->x - Real(stated.point.x()), dy = p->y - Real(stated.point.y());
        if (!(sqrt(dx * dx + dy * dy) <= Real(stated.error)))
            complain(where + ": stated " + text(apart(fast(*p), near) / stated.error) +
                     " times its bound away from the true vertex");
        for (std::uint32_t i = 0; i < region_.sides.size(); ++i) {
            const Real s = value(Curve{i, SIZE_MAX}, *p)[0],
                       tie = kTie * Real(size_) *
                             (abs(Real(region_.sides[i].a)) + abs(Real(region_.sides[i].b)));
            if (s < -tie) complain(where + ": outside the region");
            const auto listed = d_.sides(v);
            if ((abs(s) <= tie) != (std::ranges::find(listed, i) != listed.end()))
                complain(where + ": wrong about side " + std::to_string(i));
        }
        const auto truth = minimal(*p);
        if (!std::ranges::equal(truth, d_.label(v)))
            return complain(where + ": label " + name(d_.label(v)) + ", the minimum is attained by " +
                            name(truth));
        const Real h = height<Real>(solids_[truth[0].value], p->x, p->y).v;
        if (!(abs(h - Real(stated.height)) <= Real(stated.height_error)))
            complain(where + ": height off by " +
                     text((abs(h - Real(stated.height)) / Real(stated.height_error)).convert_to<Fast>()) +
                     " times its bound");
    }

    // Its forms are as low as any other, to the width of what was assumed.
    void check_assumed_vertex(VertexId v, const std::string& where, Fast width) {
        const Point<Fast>& p = at_.back();
        const Fast reach = width + d_.vertices[v].error;
        const auto jet = [&](std::size_t i) { return height<Fast>(solids_[i], p.x, p.y); };
        Fast top = HUGE_VALL;
        for (std::size_t i = 0; i < solids_.size(); ++i) {
            const Height<Fast> h = jet(i);
            top = std::min(top, h.v + 2 * reach * (std::abs(h.gx) + std::abs(h.gy)) + rounding(i, p, h));
        }
        for (const FormId f : d_.label(v)) {
            const Height<Fast> h = jet(f.value);
            if (h.v - 2 * reach * (std::abs(h.gx) + std::abs(h.gy)) - rounding(f.value, p, h) > top)
                complain(where + ": " + to_string(f) + " is higher than others");
        }
    }

    void check_corners() {
        const std::size_t n = region_.sides.size();
        for (std::size_t i = 0; i < n; ++i) {
            const auto at_corner = [&](VertexId v) {
                const auto s = d_.sides(v);
                return std::ranges::find(s, i) != s.end() && std::ranges::find(s, (i + 1) % n) != s.end();
            };
            int count = 0;
            for (const VertexId v : d_.vertices.ids()) count += at_corner(v);
            if (count != 1)
                complain("corner " + std::to_string(i) + ": is " + std::to_string(count) + " vertices");
        }
    }

    // --- Arcs -----------------------------------------------------------------------------------

    std::array<Fast, 3> difference(const MinimizationDiagram::Edge& e, const Point<Fast>& p) const {
        const Height<Fast> a = height<Fast>(solids_[e.left.value], p.x, p.y),
                           b = height<Fast>(solids_[e.right.value], p.x, p.y);
        return {a.v - b.v, a.gx - b.gx, a.gy - b.gy};
    }
    Fast difference_error(const MinimizationDiagram::Edge& e, const Point<Fast>& p) const {
        Fast sum = 0;
        for (const FormId f : {e.left, e.right})
            sum += rounding(f.value, p, height<Fast>(solids_[f.value], p.x, p.y));
        return sum;
    }

    /// The arc's point on the line through p along the piece's direction: a sign change within `reach`,
    /// closed in on.
    std::optional<Point<Fast>> onto_arc(EdgeId e, std::size_t piece, const Point<Fast>& p, Fast reach) const {
        const auto& edge = d_.edges[e];
        const auto& d = d_.pieces(e)[piece].direction;
        const auto at = [&](Fast w) { return Point<Fast>{p.x + w * d.x(), p.y + w * d.y()}; };
        Fast lo = 0, hi = 0;
        const auto start = difference(edge, p);
        const Fast slope = start[1] * d.x() + start[2] * d.y();
        Fast grow = slope > 0 ? std::abs(start[0] / slope) * 2 + 1e-17L * size_ : 1e-6L * reach;
        for (; grow <= 64 * reach; grow *= 4) {
            (start[0] > 0 ? lo : hi) = start[0] > 0 ? -grow : grow;
            if (difference(edge, at(lo))[0] <= 0 && difference(edge, at(hi))[0] >= 0) break;
        }
        if (grow > 64 * reach) return std::nullopt;
        for (int i = 0; i < 80; ++i) {
            Fast m = (lo + hi) / 2;
            const auto v = difference(edge, at(i % 2 ? m : lo));
            const Fast s = v[1] * d.x() + v[2] * d.y();
            if (i % 2 == 0 && s > 0) m = std::clamp(lo - v[0] / s, lo, hi);  // Newton's step, then bisection
            const Fast value = difference(edge, at(m))[0];
            if (value == 0 || hi - lo <= 1e-19L * size_) return at(m);
            (value < 0 ? lo : hi) = m;
        }
        const Fast m = (lo + hi) / 2;
        const auto v = difference(edge, at(m));
        const Fast s = v[1] * d.x() + v[2] * d.y();
        return at(s > 0 ? std::clamp(m - v[0] / s, lo, hi) : m);
    }

    /// The point of the arc above the middle of a segment's chord.
    std::optional<Point<Fast>> middle(const Segment& s) const {
        const Point<Fast> m{(s.from.x + s.to.x) / 2, (s.from.y + s.to.y) / 2};
        const MinimizationDiagram::Edge& edge = d_.edges[{s.edge}];
        if (edge.on_rim()) return m;
        const Fast chord = apart(s.from, s.to);
        if (s.piece >= 0) return chord > 1e-16L * size_ ? onto_arc({s.edge}, s.piece, m, chord) : m;
        // A circle of curvature k leaves its chord by h^2 k / (1 + sqrt(1 - h^2 k^2)), to the right when
        // counter-clockwise.
        const Fast k = curvature(edge), h = chord / 2;
        const Fast bulge = h * h * k / (1 + std::sqrt(std::max<Fast>(0, 1 - h * h * k * k))) /
                           std::max(chord, std::numeric_limits<Fast>::min());
        return Point<Fast>{m.x + bulge * (s.to.y - s.from.y), m.y - bulge * (s.to.x - s.from.x)};
    }

    struct Circle {
        Real K, A, B, C;  // K (x^2 + y^2) + A x + B y + C, negative on the left
    };
    Circle circle(const MinimizationDiagram::Edge& e) const {
        const auto terms = [&](FormId f) {
            if (const Wall* w = std::get_if<Wall>(&solids_[f.value]))
                return std::array<Real, 5>{0, w->a, w->b, w->e, w->w};
            const Ball& b = std::get<Ball>(solids_[f.value]);
            const Real x(b.x), y(b.y), z(b.z), rho(b.rho);
            return std::array<Real, 5>{1, -2 * x, -2 * y, x * x + y * y + z * z - rho * rho, 2 * (z + rho)};
        };
        const auto f = terms(e.left), g = terms(e.right);
        const auto minus = [&](int i) { return Real(f[i] / f[4] - g[i] / g[4]); };
        return {minus(0), minus(1), minus(2), minus(3)};
    }
    Fast curvature(const MinimizationDiagram::Edge& e) const {
        const auto [K, A, B, C] = circle(e);
        return Real(2 * K / sqrt(A * A + B * B - 4 * K * C)).convert_to<Fast>();
    }

    void add_segment(Segment s, int halvings) {
        const auto m = middle(s);
        if (!m && near_point(s)) {
            s.band = 2 * apart(s.from, s.to);
            segments_.push_back(s);
            return;
        }
        if (!m)
            return complain(to_string(EdgeId{s.edge}) + ": no point of its curve beside the chord from " +
                            place(s.from) + " to " + place(s.to));
        Segment a = s, b = s;
        a.to = b.from = *m;
        if (halvings > 0) {
            add_segment(a, halvings - 1);
            add_segment(b, halvings - 1);
            return;
        }
        s.band = band(s, *m);
        segments_.push_back(s);
    }
    // Of a piece that was taken for a point nothing but its ends is known.
    bool near_point(const Segment& s) const {
        return s.piece >= 0 && assumed_width(s.from, apart(s.from, s.to)) > 0;
    }
    Fast band(const Segment& s, const Point<Fast>& m) const {
        Fast most = apart(m, {(s.from.x + s.to.x) / 2, (s.from.y + s.to.y) / 2});
        if (s.piece >= 0)
            for (const auto& [p, q] : {std::pair(s.from, m), std::pair(m, s.to)}) {
                Segment half = s;
                half.from = p;
                half.to = q;
                if (const auto n = middle(half))
                    most = std::max(most, apart(*n, {(p.x + q.x) / 2, (p.y + q.y) / 2}));
            }
        return 2 * most + 1e-15L * size_;
    }

    void trace_edge(EdgeId e, std::mt19937_64& rng) {
        const auto& edge = d_.edges[e];
        const std::string where =
            to_string(e) + " between " + to_string(edge.left) + " and " + to_string(edge.right);
        const VertexId from = dcel_.origin(Dcel::half_edge(e)), to = dcel_.target(Dcel::half_edge(e));
        const std::size_t first = segments_.size();
        if (edge.on_rim()) {
            if (!from.valid()) return complain(where + ": closed, on the rim");
            const auto& s = region_.sides[edge.side];
            const Point<Fast>&p = at_[from.value], &q = at_[to.value];
            if ((q.x - p.x) * s.b - (q.y - p.y) * s.a <= 0) complain(where + ": runs against its side");
            segments_.push_back({p, q, 1e-15L * size_, e.value, -1});
        } else if (d_.pieces(e).empty()) {
            trace_circle(e, where, from, to);
        } else {
            trace_pieces(e, where, from, to, rng);
        }
        for (std::size_t i = first; i < segments_.size(); ++i) check_on_edge(e, where, segments_[i].to);
        const Segment middle_one =
            segments_.size() > first ? segments_[first + (segments_.size() - first) / 2] : Segment{};
        if (segments_.size() > first && middle(middle_one)) check_on_edge(e, where, *middle(middle_one));
    }

    void trace_circle(EdgeId e, const std::string& where, VertexId from, VertexId to) {
        const auto [K, A, B, C] = circle(d_.edges[e]);
        Segment s{{}, {}, 0, e.value, -1};
        const Real r2 = K == 0 ? Real(-1) : Real((A * A + B * B) / (4 * K * K) - C / K);
        if (!from.valid()) {
            if (r2 <= 0) return complain(where + ": closed, but its curve is no circle");
            const Real x = -A / (2 * K), y = -B / (2 * K), r = sqrt(r2);
            const int turn = K > 0 ? 1 : -1;
            const std::array<Point<Real>, 4> at{
                Point<Real>{x + r, y}, {x, y + turn * r}, {x - r, y}, {x, y - turn * r}};
            for (int i = 0; i < 4; ++i) {
                s.from = fast(at[i]);
                s.to = fast(at[(i + 1) % 4]);
                add_segment(s, 2);
            }
            return;
        }
        s.from = at_[from.value];
        s.to = at_[to.value];
        if (K != 0 && r2 > 0) {
            // More than half a turn: cut opposite the chord's middle.
            const Fast cx = Real(-A / (2 * K)).convert_to<Fast>(), cy = Real(-B / (2 * K)).convert_to<Fast>(),
                       r = Real(sqrt(r2)).convert_to<Fast>();
            const Fast side =
                ((s.to.x - s.from.x) * (cy - s.from.y) - (s.to.y - s.from.y) * (cx - s.from.x)) *
                (K > 0 ? 1 : -1);
            if (side < 0 || from == to) {
                const Fast chord = apart(s.from, s.to), turn = K > 0 ? 1 : -1;
                const Point<Fast> out = chord > 0 ? Point<Fast>{turn * (s.to.y - s.from.y) / chord,
                                                                -turn * (s.to.x - s.from.x) / chord}
                                                  : Point<Fast>{(cx - s.from.x) / r, (cy - s.from.y) / r};
                Segment half = s;
                half.to = {cx + r * out.x, cy + r * out.y};
                s.from = half.to;
                add_segment(half, 4);
                add_segment(s, 4);
                return;
            }
        }
        add_segment(s, 3);
    }

    void trace_pieces(EdgeId e, const std::string& where, VertexId from, VertexId to, std::mt19937_64& rng) {
        const auto& edge = d_.edges[e];
        const auto pieces = d_.pieces(e);
        Eigen::Vector2d start = from.valid() ? d_.vertices[from].point : pieces.back().end;
        double start_error = from.valid() ? d_.vertices[from].error : pieces.back().error;
        if (to.valid() && !((pieces.back().end - d_.vertices[to].point).norm() <=
                            pieces.back().error + d_.vertices[to].error))
            complain(where + ": its last piece does not end at its target");
        Point<Fast> p = from.valid() ? at_[from.value] : Point<Fast>{start.x(), start.y()};
        std::optional<Point<Fast>> closing;
        std::uniform_real_distribution<double> unit(0, 1);
        for (std::size_t i = 0; i < pieces.size(); ++i) {
            const auto& piece = pieces[i];
            const auto& [x0, x1, y0, y1] = piece.box;
            if (!(std::abs(piece.direction.norm() - 1) < 1e-14))
                complain(where + ": a direction is not of unit length");
            for (const auto& [q, error] : {std::pair(start, start_error), std::pair(piece.end, piece.error)})
                if (q.x() < x0 - error || q.x() > x1 + error || q.y() < y0 - error || q.y() > y1 + error)
                    complain(where + ": a piece ends outside of its box");
            // Around a node, and where a point was assumed, the direction is only that across the chord.
            const Fast width = std::max(x1 - x0, y1 - y0);
            if (width > 0x1p-22L * size_)
                for (int k = 0; k < 4; ++k) {
                    const Point<Fast> q{x0 + (x1 - x0) * unit(rng), y0 + (y1 - y0) * unit(rng)};
                    if (!in_region(q, 0)) continue;
                    const auto v = difference(edge, q);
                    if (!(v[1] * piece.direction.x() + v[2] * piece.direction.y() > 0))
                        complain(where + ": the difference does not grow along a piece's direction at " +
                                 place(q));
                }
            // The end, moved onto the curve.
            Point<Fast> q{piece.end.x(), piece.end.y()};
            const auto v = difference(edge, q);
            const Fast slope = std::hypot(v[1], v[2]);
            const bool last = i + 1 == pieces.size();
            if (slope > 1e-6L && width > 0x1p-22L * size_ &&
                std::abs(v[0]) > slope * piece.error * 1.01L + difference_error(edge, q))
                complain(where + ": a piece ends " + text(std::abs(v[0]) / slope / piece.error) +
                         " times its bound away from the curve");
            if (last && to.valid())
                q = at_[to.value];
            else if (last && closing)
                q = *closing;
            else if (const auto on = onto_arc(e, i, q, std::max<Fast>(piece.error, 1e-15L * size_)))
                q = *on;
            if (i == 0 && !from.valid()) {
                if (const auto on = onto_arc(e, 0, p, std::max<Fast>(start_error, 1e-15L * size_))) p = *on;
                closing = p;
                if (last) q = p;
            }
            add_segment({p, q, 0, e.value, static_cast<std::int32_t>(i)}, 0);
            p = q;
            start = piece.end;
            start_error = piece.error;
        }
    }

    // Both sides' forms agree, and none is lower, as far as long double tells.
    void check_on_edge(EdgeId e, const std::string& where, const Point<Fast>& p) {
        const Fast width = assumed_width(p, 1e-12L * size_);
        const auto& edge = d_.edges[e];
        if (!in_region(p, -1e-14L * size_ - width)) complain(where + ": leaves the region at " + place(p));
        Fast top = HUGE_VALL;
        std::vector<Fast> low(solids_.size());
        for (std::size_t i = 0; i < solids_.size(); ++i) {
            const Height<Fast> h = height<Fast>(solids_[i], p.x, p.y);
            const Fast slack =
                4 * rounding(i, p, h) + (2 * width + 1e-18L * size_) * (std::abs(h.gx) + std::abs(h.gy));
            low[i] = h.v - slack;
            top = std::min(top, h.v + slack);
        }
        for (const FormId f : d_.label(e))
            if (f.valid() && low[f.value] > top)
                complain(where + ": another form is lower than " + to_string(f) + " at " + place(p));
        if (edge.on_rim()) return;
        const auto v = difference(edge, p);
        if (width == 0 &&
            std::abs(v[0]) > 8 * difference_error(edge, p) + 1e-17L * size_ * std::hypot(v[1], v[2]))
            complain(where + ": its forms differ at " + place(p));
    }

    // --- Faces ----------------------------------------------------------------------------------

    /// Signed crossings of the ray from q to the right; none when q is too near to say.
    std::optional<int> crossings(const Segment& s, const Point<Fast>& q) const {
        const auto [y0, y1] = std::minmax(s.from.y, s.to.y);
        if (q.y < y0 - s.band || q.y > y1 + s.band || q.x > std::max(s.from.x, s.to.x) + s.band) return 0;
        const Fast dx = s.to.x - s.from.x, dy = s.to.y - s.from.y, length = std::hypot(dx, dy);
        const Fast t =
            length > 0
                ? std::clamp<Fast>(((q.x - s.from.x) * dx + (q.y - s.from.y) * dy) / (length * length), 0, 1)
                : 0;
        if (apart(q, {s.from.x + t * dx, s.from.y + t * dy}) <= s.band) {
            const auto m = length > kFinest * size_ ? middle(s) : std::nullopt;
            if (!m) return std::nullopt;
            Segment a = s, b = s;
            a.to = b.from = *m;
            for (Segment* half : {&a, &b}) {
                if (d_.edges[{s.edge}].on_rim()) return std::nullopt;
                const auto n = middle(*half);
                if (!n) return std::nullopt;
                half->band = band(*half, *n);
            }
            const auto first = crossings(a, q), second = crossings(b, q);
            if (!first || !second) return std::nullopt;
            return *first + *second;
        }
        const bool from_below = s.from.y <= q.y, to_below = s.to.y <= q.y;
        if (from_below == to_below) return 0;
        const bool left_of =
            (dx * (q.y - s.from.y) - dy * (q.x - s.from.x) > 0) == (dy > 0);  // q is left of the chord
        return left_of ? (dy > 0 ? 1 : -1) : 0;
    }

    /// The faces whose boundary winds around q once.
    std::optional<std::vector<FaceId>> faces_around(const Point<Fast>& q) const {
        std::vector<int> winding(dcel_.face_count());
        for (const Segment& s : segments_) {
            const auto c = crossings(s, q);
            if (!c) return std::nullopt;
            if (*c == 0) continue;
            const HalfEdgeId h = Dcel::half_edge({s.edge});
            winding[dcel_.face(h).value] += *c;
            winding[dcel_.face(Dcel::twin(h)).value] -= *c;
        }
        std::vector<FaceId> found;
        for (std::uint32_t f = 1; f < winding.size(); ++f)
            if (winding[f] != 0) found.push_back({f});
        for (const FaceId f : found)
            if (winding[f.value] != 1) return std::vector<FaceId>{};
        return found;
    }

    bool check_sample(const Point<Fast>& q) {
        if (!in_region(q, 1e-12L * size_)) return false;
        const auto found = faces_around(q);
        if (!found) return false;
        const std::string where = "point " + place(q);
        if (found->size() != 1) {
            complain(where + ": lies in the faces " + name(*found));
            return true;
        }
        const FormId owner = d_.face_forms[found->front()];
        auto truth = minimal(q);
        if (truth.size() > 1) truth = minimal(Point<Real>{Real(q.x), Real(q.y)});
        if (std::ranges::find(truth, owner) == truth.end() && assumed_width(q, 0) == 0)
            complain(where + ": in " + to_string(found->front()) + " of " + to_string(owner) +
                     ", lowest is " + name(truth));
        return true;
    }

    /// Points all over the region, as many close to vertices, where small faces meet, and where each form
    /// does best.
    void check_samples(std::mt19937_64& rng, int samples) {
        std::uniform_real_distribution<double> unit(-1, 1);
        int asked = 0;
        for (int i = 0; i < samples; ++i) {
            Point<Fast> q{low_.x + (high_.x - low_.x) * (unit(rng) + 1) / 2,
                          low_.y + (high_.y - low_.y) * (unit(rng) + 1) / 2};
            if (i % 2 && d_.vertices.size()) {
                const Point<Fast>& v = at_[rng() % at_.size()];
                const Fast reach = size_ * std::pow(10.0, -4 + 3 * unit(rng));
                q = {v.x + unit(rng) * reach, v.y + unit(rng) * reach};
            }
            asked += check_sample(q);
        }
        if (samples >= 100 && asked < samples / 10) complain("samples: nearly all lie on edges");
        const std::size_t n = std::min<std::size_t>(solids_.size(), 40);
        for (std::size_t f = 0; f < n; ++f) check_sample(best_place(f, rng));
    }

    /// Where form f is farthest below the others, or least above them: a search by shrinking steps.
    Point<Fast> best_place(std::size_t f, std::mt19937_64& rng) const {
        std::uniform_real_distribution<double> unit(-1, 1);
        const auto excess = [&](const Point<Fast>& p) {
            Fast others = HUGE_VALL;
            for (std::size_t i = 0; i < solids_.size(); ++i)
                if (i != f) others = std::min(others, height<Fast>(solids_[i], p.x, p.y).v);
            return height<Fast>(solids_[f], p.x, p.y).v - others;
        };
        Point<Fast> best{(low_.x + high_.x) / 2, (low_.y + high_.y) / 2};
        Fast least = excess(best), step = size_ / 2;
        for (int i = 0; i < 80; ++i, step *= 0.9L) {
            const Point<Fast> p{best.x + step * unit(rng), best.y + step * unit(rng)};
            if (!in_region(p, 0)) continue;
            if (const Fast e = excess(p); e < least) {
                least = e;
                best = p;
            }
        }
        return best;
    }

    // --- Completeness ---------------------------------------------------------------------------

    /// Along each side the owner at sampled points is the rim edge's.
    void check_rim() {
        const std::size_t n = corners_.size();
        for (std::size_t side = 0; side < n; ++side) {
            const Point<Fast>&p = corners_[side], &q = corners_[(side + 1) % n];
            for (int k = 0; k < 64; ++k) {
                const Fast t = (k + 0.4142L) / 64;
                const Point<Fast> at{p.x + t * (q.x - p.x), p.y + t * (q.y - p.y)};
                const auto truth = minimal(at);
                bool known = truth.size() > 1;  // too close to a change
                for (const Segment& s : segments_) {
                    if (known || d_.edges[{s.edge}].side != side) continue;
                    const Fast along =
                        (at.x - s.from.x) * (s.to.x - s.from.x) + (at.y - s.from.y) * (s.to.y - s.from.y);
                    if (along < 0 || along > apart(s.from, s.to) * apart(s.from, s.to)) continue;
                    known = true;
                    if (d_.edges[{s.edge}].left != truth[0])
                        complain("side " + std::to_string(side) + " at " + place(at) + ": labelled " +
                                 to_string(d_.edges[{s.edge}].left) + ", lowest is " + name(truth));
                }
                if (!known) complain("side " + std::to_string(side) + " at " + place(at) + ": no rim edge");
            }
        }
    }

    /// Wherever three forms are found to meet and are lowest, there is a vertex.
    void check_missing_vertices() {
        const std::size_t n = solids_.size();
        const auto jet = [&](std::size_t i, const Point<Fast>& p) {
            return height<Fast>(solids_[i], p.x, p.y);
        };
        for (std::size_t i = 0; i < n; ++i)
            for (std::size_t j = i + 1; j < n; ++j)
                for (std::size_t k = j + 1; k < n; ++k)
                    for (int start = 0; start < 16; ++start) {
                        Point<Fast> p{low_.x + (high_.x - low_.x) * (start % 4 + 0.5L) / 4,
                                      low_.y + (high_.y - low_.y) * (start / 4 + 0.5L) / 4};
                        Fast step = HUGE_VALL;
                        for (int it = 0; it < 30 && step > 1e-16L * size_ && in_region(p, -size_); ++it) {
                            const Height<Fast> a = jet(i, p), b = jet(j, p), c = jet(k, p);
                            const Fast ux = a.gx - b.gx, uy = a.gy - b.gy, vx = a.gx - c.gx, vy = a.gy - c.gy,
                                       det = ux * vy - uy * vx;
                            const Fast dx = (uy * (a.v - c.v) - vy * (a.v - b.v)) / det,
                                       dy = (vx * (a.v - b.v) - ux * (a.v - c.v)) / det;
                            p = {p.x + dx, p.y + dy};
                            step = std::isfinite(dx + dy) ? std::abs(dx) + std::abs(dy) : HUGE_VALL;
                            if (step == HUGE_VALL) break;
                        }
                        if (!(step <= 1e-15L * size_) || !in_region(p, 1e-10L * size_)) continue;
                        const auto truth = minimal(p);
                        const auto lowest = [&](std::size_t f) {
                            return std::ranges::find(truth, FormId{static_cast<std::uint32_t>(f)}) !=
                                   truth.end();
                        };
                        if (!lowest(i) || !lowest(j) || !lowest(k)) continue;
                        if (std::ranges::none_of(
                                at_, [&](const Point<Fast>& v) { return apart(v, p) <= 1e-7L * size_; }))
                            complain("no vertex at " + place(p) + ", where the minimum is attained by " +
                                     name(truth));
                    }
    }

    const MinimizationDiagram& d_;
    const Dcel& dcel_;
    const ConvexRegion& region_;
    std::vector<Solid> solids_;
    std::vector<Point<Fast>> corners_;
    Point<Fast> low_{HUGE_VALL, HUGE_VALL}, high_{-HUGE_VALL, -HUGE_VALL};
    Fast size_ = 0;
    std::vector<Point<Fast>> at_;    // by vertex, refined
    std::vector<Segment> segments_;  // of all edges, along half-edge 2e
    std::vector<std::string> complaints_;
};

/// Everything that brute force has to say against a diagram; empty: nothing. Checks in order: the dcel's
/// invariants and the labels' inclusions; each vertex (refined from its label; all and only the labelled
/// forms are lowest; place and height within their bounds); the pieces of each edge, and the forms along it;
/// the face of sampled points, the rim's labels; for few forms, that no vertex is missing. A failed stage
/// ends the judgement.
inline std::vector<std::string> check_diagram(const Scene& scene, const MinimizationDiagram& diagram,
                                              std::mt19937_64& rng, const Options& options = {}) {
    return Judge(scene, diagram).check(rng, options);
}

}  // namespace vcell::mixed
