#include "clearance_places.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>
#include <variant>
#include <vector>

#include "../../primitives/bases/axial_terms.hpp"
#include "../object_distance.hpp"
#include "face_at.hpp"

namespace vcell {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
// Relative: beyond the rounding of distances, handfuls of products of coordinates and unit vectors.
constexpr double distance_rounding = 0x1p-46;

// What an object's distance is counted from: a point, a line or a plane, of which a solid has all that is
// within `radius`. A vessel's wall is so far from it, and of a cone S times as far as along the axis.
struct Core {
    Vec3 point;
    std::array<Vec3, 2> along{};  // orthonormal
    int dimension = 0;
    double radius = 0;
    bool is_hollow = false;
    const HollowCone* cone = nullptr;

    Vec3 across(const Vec3& v) const {
        Vec3 rest = v;
        for (int k = 0; k < dimension; ++k) rest -= v.dot(along[k]) * along[k];
        return rest;
    }
    Vec3 foot(const Vec3& p) const { return p - across(p - point); }
};

Vec3 perpendicular_to(const Vec3& unit) {
    Eigen::Index least = 0;
    unit.cwiseAbs().minCoeff(&least);
    return unit.cross(Vec3::Unit(least)).normalized();
}

Core core_of(const Object& object) {
    const auto about_axis = [](const Vec3& point, const Vec3& axis, double radius, bool is_hollow) {
        return Core{point, {axis.stableNormalized()}, 1, radius, is_hollow};
    };
    if (const auto* plane = std::get_if<Plane>(&object)) {
        // Their product is the normal.
        const Vec3 n = plane->normal.stableNormalized(), x = perpendicular_to(n);
        return {plane->point, {x, n.cross(x)}, 2};
    }
    if (const auto* ball = std::get_if<Sphere>(&object)) return {ball->center, {}, 0, ball->radius};
    if (const auto* tube = std::get_if<Cylinder>(&object))
        return about_axis(tube->point, tube->axis, tube->radius, false);
    if (const auto* vessel = std::get_if<HollowSphere>(&object))
        return {vessel->center, {}, 0, vessel->radius, true};
    if (const auto* vessel = std::get_if<HollowCylinder>(&object))
        return about_axis(vessel->point, vessel->axis, vessel->radius, true);
    const auto& cone = std::get<HollowCone>(object);
    Core core = about_axis(cone.apex, cone.axis, 0, true);
    core.cone = &cone;
    return core;
}

// The points of two cores that are nearest to each other. Where that leaves them free to slide what is true
// of one place is true of others, as far as the edges of a face: then those near `middle`.
std::array<Vec3, 2> nearest_points(const Core& a, const Core& b, const Vec3& middle) {
    const int n = a.dimension + b.dimension;
    const Vec3 aside = a.foot(b.foot(middle));
    const std::array<Vec3, 2> sliding{aside, b.foot(aside)};
    if (n > 3) return sliding;
    constexpr double all_but_parallel = 0x1p-40;  // farther off they would be known to no digits
    Eigen::Matrix3d ways = Eigen::Matrix3d::Zero(), gram = Eigen::Matrix3d::Identity();
    for (int k = 0; k < a.dimension; ++k) ways.col(k) = a.along[k];
    for (int k = 0; k < b.dimension; ++k) ways.col(a.dimension + k) = -b.along[k];
    gram.topLeftCorner(n, n) = (ways.transpose() * ways).topLeftCorner(n, n);
    if (!(std::abs(gram.determinant()) > all_but_parallel)) return sliding;
    const Vec3 s = gram.inverse() * (ways.transpose() * (b.point - a.point));
    std::array<Vec3, 2> points{a.point, b.point};
    points[0] += ways.leftCols(a.dimension) * s.head(a.dimension);
    points[1] -= ways.middleCols(a.dimension, b.dimension) * s.segment(a.dimension, b.dimension);
    return points;
}

// Places on the bisector of two cores where the ray from the first one meets the second one's surface at a
// right angle.
void add_places_head_on(const Core& base, const Core& object, const Vec3& middle, std::vector<Vec3>& places) {
    const auto [from, to] = nearest_points(base, object, middle);
    const Vec3 way = to - from;
    const double far = way.norm();
    // Where the cores meet, a common perpendicular has two senses.
    std::vector<Vec3> directions;
    if (far > 0)
        directions = {way / far};
    else if (base.dimension + object.dimension == 0)
        directions = {Vec3::UnitX()};
    else if (base.dimension == 1 && object.dimension == 1) {
        const Vec3 across = base.along[0].cross(object.along[0]);
        directions = {across.norm() > 0 ? across.normalized() : perpendicular_to(base.along[0])};
    }
    for (const Vec3& d : directions)
        for (const double sense : {-1.0, 1.0}) {
            const double L = sense * far,
                         t = 0.5 * (base.radius + (object.is_hollow ? object.radius + L : L - object.radius));
            places.push_back(from + sense * t * d);
        }
}

// Those of a cone's wall: its generators beside the places lie along w and e from the axis, in planes that
// touch the wall, and which are along the base where that is a tube.
void add_places_at_wall(const Core& base, const HollowCone& cone, std::vector<Vec3>& places) {
    const Vec3 w = cone.axis.stableNormalized();
    const double S = cone.sine(), K = cone.cosine();
    const auto add = [&](const Vec3& e) {
        const Vec3 out = K * e - S * w, beside = w.cross(e);
        Vec3 from = base.point;
        if (base.dimension == 1)
            from -= (base.point - cone.apex).dot(beside) / base.along[0].dot(beside) * base.along[0];
        const Vec3 p = from + 0.5 * (base.radius - out.dot(from - cone.apex)) * out;
        if (p.allFinite() && (p - cone.apex).dot(e) > 0) places.push_back(p);
    };
    if (base.dimension == 0) {
        const Vec3 off = base.point - cone.apex, across = off - off.dot(w) * w;
        const Vec3 e = across.norm() > 0 ? across.normalized() : perpendicular_to(w);
        for (const double sense : {-1.0, 1.0}) add(sense * e);
        return;
    }
    const Vec3 a = base.along[0], lean = a - a.dot(w) * w;
    const double across = lean.norm(), cosine = S * a.dot(w) / (K * across);
    if (!(std::abs(cosine) < 1)) return;
    const Vec3 toward = lean / across, aside = w.cross(toward);
    for (const double sense : {-1.0, 1.0})
        add(cosine * toward + sense * std::sqrt(1 - cosine * cosine) * aside);
}

// Tips: places of a tube's or cone's axis that are as far from the object, or the vessel's wall, as from the
// base.
void add_tips(const Core& base, const Core& object, std::vector<Vec3>& places) {
    const Vec3 w = object.along[0], m = base.across(object.point - base.point), v = base.across(w);
    const double sine = object.cone != nullptr ? object.cone->sine() : 0,
                 reach = object.is_hollow ? base.radius + object.radius : base.radius - object.radius;
    if (!(reach > 0)) return;
    const auto both = tips_along(m, v, sine, reach);
    if (!both) return;
    for (const double h : *both) {
        const Vec3 p = object.point + h * w;
        if (p.allFinite()) places.push_back(p);
    }
}

class PlaceSearch {
public:
    explicit PlaceSearch(const Cell& cell)
        : cell_(cell), scene_(cell.scene), measures_(cell.measures), base_(core_of(cell.scene.base)) {
        if (base_.dimension == 2) normal_ = base_.along[0].cross(base_.along[1]);
        for (const auto& corner : {scene_.box.min, scene_.box.max}) size_ += corner.cwiseAbs().sum();
        size_ += size_of(base_);
        for (const Object& o : scene_.objects) cores_.push_back(core_of(o));
    }

    ClearancePlaces run() {
        if (cell_.faces.empty() || !std::isfinite(measures_.min_clearance + measures_.max_clearance))
            return {};
        look_at_vertices();
        look_at_edges();
        look_at_faces();
        return {settled(best_[0], measures_.min_clearance, measures_.min_clearance_error),
                settled(best_[1], measures_.max_clearance, measures_.max_clearance_error)};
    }

private:
    // The greatest counts with its sign turned: the less, the better.
    static constexpr std::array<double, 2> signs{1, -1};

    static double size_of(const Core& core) { return core.point.cwiseAbs().sum() + core.radius; }
    double clearance(const Vec3& p) const { return signed_distance_from(scene_.base, p); }
    // What distances from an object and from the base are off by in the box.
    double rounding(const Core& core) const { return distance_rounding * (size_of(core) + size_); }

    // An element replaces another one only if their errors do not explain the difference: vertices are looked
    // at before edges, and these before faces, so that the one of lowest dimension keeps a value they share.
    bool is_better(std::size_t which, double value, double error) const {
        const auto& best = best_[which];
        return !best || signs[which] * (value - best->clearance) < -(error + best->error);
    }

    void look_at_vertices() {
        for (std::uint32_t i = 0; i < cell_.vertices.size(); ++i) {
            const CellVertex& v = cell_.vertices[i];
            // The place of one where bisectors touch is not bounded: edges have it.
            if (v.is_touching) continue;
            for (const std::size_t which : {0u, 1u}) {
                if (best_[which] && !(signs[which] * (v.radius - best_[which]->clearance) < 0)) continue;
                best_[which] = {v.point, v.error, v.radius, 0, {v.sites.begin(), v.sites.end()}, i, {}, {}};
            }
        }
    }

    void look_at_edges() {
        constexpr int samples = 8;
        for (std::uint32_t e = 0; e < cell_.edges.size(); ++e) {
            const RationalCurve3& curve = cell_.edges[e].curve;
            const std::size_t last = curve.points.size();
            for (std::size_t k = static_cast<std::size_t>(curve.degree); k < last; ++k) {
                const double begin = curve.knots[k], end = curve.knots[k + 1];
                if (!(begin < end)) continue;
                std::array<double, samples + 1> values;
                for (int i = 0; i <= samples; ++i)
                    values[static_cast<std::size_t>(i)] =
                        clearance(curve.evaluate(begin + (end - begin) * i / samples));
                for (const std::size_t which : {0u, 1u}) {
                    const auto at =
                        std::ranges::min_element(values, {}, [&](double v) { return signs[which] * v; });
                    const double i = static_cast<double>(at - values.begin()), step = (end - begin) / samples;
                    look_between(e, which, std::max(begin, begin + (i - 1) * step),
                                 std::min(end, begin + (i + 1) * step));
                }
            }
        }
    }

    // By the golden section, in which clearance along a curve has one extreme; where it has more, one of
    // them.
    void look_between(std::uint32_t e, std::size_t which, double low, double high) {
        const CellEdge& edge = cell_.edges[e];
        const auto value = [&](double t) { return signs[which] * clearance(edge.curve.evaluate(t)); };
        constexpr double part = 0.6180339887498949;
        constexpr int steps = 40;  // to half the digits, as extremes are flat
        std::array<double, 2> t{high - part * (high - low), low + part * (high - low)},
            f{value(t[0]), value(t[1])};
        for (int i = 0; i < steps; ++i) {
            if (f[0] < f[1]) {
                high = std::exchange(t[1], t[0]);
                f[1] = f[0];
                t[0] = high - part * (high - low);
                f[0] = value(t[0]);
            } else {
                low = std::exchange(t[0], t[1]);
                f[0] = f[1];
                t[1] = low + part * (high - low);
                f[1] = value(t[1]);
            }
        }
        const double error = edge.error + distance_rounding * size_;
        for (const double at : {low, t[0], t[1], high}) {
            const Vec3 p = edge.curve.evaluate(at);
            const double c = clearance(p);
            if (!is_better(which, c, error)) continue;
            std::vector<Site> sites(edge.sites.begin(), edge.sites.end());
            sites.insert(sites.end(), edge.extra_sites.begin(), edge.extra_sites.end());
            std::ranges::sort(sites);
            // A site that is the rim, too, is on both sides.
            sites.erase(std::ranges::unique(sites).begin(), sites.end());
            best_[which] = {p, error, c, 0, std::move(sites), {}, e, {}};
        }
    }

    void look_at_faces() {
        for (std::uint32_t f = 0; f < cell_.faces.size(); ++f)
            for (const Vec3& p : places_of(cell_.faces[f].site)) look_at(f, p);
    }

    std::vector<Vec3> places_of(Site site) const {
        std::vector<Vec3> places;
        if (site == Site::cap() || site.kind == Site::Kind::BoxSide) {
            // Rays end on sides of the box; caps are alike everywhere, and edges have them if there are any.
            if (site == Site::cap() && base_.dimension == 0)
                places.push_back(base_.point + (base_.radius + *scene_.probe) * Vec3::UnitX());
            if (site.kind == Site::Kind::BoxSide && base_.dimension == 0) {
                const unsigned k = site.index / 2;
                Vec3 p = base_.point;
                p[k] = (site.index % 2 == 1 ? scene_.box.max : scene_.box.min)[k];
                places.push_back(p);
            }
            return places;
        }
        if (!site.is_object()) return places;
        const Core& object = cores_[scene_.place(site.index)];
        if (object.cone != nullptr)
            add_places_at_wall(base_, *object.cone, places);
        else
            add_places_head_on(base_, object, 0.5 * (scene_.box.min + scene_.box.max), places);
        if (object.dimension == 1) add_tips(base_, object, places);
        return places;
    }

    void look_at(std::uint32_t f, const Vec3& p) {
        const double c = clearance(p), rough = rounding(base_);
        for (const std::size_t which : {0u, 1u}) {
            const double value = which == 0 ? measures_.min_clearance : measures_.max_clearance,
                         error = which == 0 ? measures_.min_clearance_error : measures_.max_clearance_error;
            // A candidate beyond the extreme is not on the boundary.
            if (!(signs[which] * (c - value) >= -(error + 64 * rough)) || !is_better(which, c, rough))
                continue;
            const CellFace& face = cell_.faces[f];
            const auto bound = proved_error(face.site, p);
            if (!bound || !is_better(which, c, *bound)) continue;
            std::vector<Site> sites{face.site};
            sites.insert(sites.end(), face.extra_sites.begin(), face.extra_sites.end());
            std::ranges::sort(sites);
            best_[which] = {p, *bound, c, 0, std::move(sites), {}, {}, face_at(cell_, face.site, p)};
        }
    }

    // By how much an object is farther from a point than the base is, and a bound on its error. Of two balls
    // from the difference of squares, which their centres may all but share.
    struct Excess {
        double value, error;
    };
    Excess excess(std::size_t place, const Vec3& p) const {
        const Core& core = cores_[place];
        if (base_.dimension == 0 && core.dimension == 0 && !core.is_hollow) {
            const Vec3 from_base = p - base_.point, from_ball = p - core.point,
                       apart = base_.point - core.point;
            const double sum = from_base.norm() + from_ball.norm(), radii = base_.radius - core.radius;
            if (sum > 0) {
                // The vectors' own rounding is a part of coordinates.
                const double part = (from_base + from_ball).dot(apart) / sum;
                return {part + radii, distance_rounding *
                                          (apart.norm() * (1 + p.cwiseAbs().sum() / sum) + std::abs(radii))};
            }
        }
        return {distance_from(scene_.objects[place], p) - clearance(p), rounding(core)};
    }

    // A length within which the boundary is met before and behind p on its ray.
    std::optional<double> proved_error(Site site, const Vec3& p) const {
        if (!stands_over_region(p)) return std::nullopt;
        const Vec3 out = p - base_.foot(p);
        if (!normal_ && !(out.norm() > 0)) return std::nullopt;
        const Vec3 u = normal_ ? *normal_ : out.normalized().eval();
        double off = rounding(base_);
        if (site.is_object()) {
            const std::size_t place = scene_.place(site.index);
            const double own = rounding(cores_[place]), apart = std::abs(excess(place, p).value);
            // Where an object is behind the base, or within it, rays meet it in other places.
            if (!(apart <= 16 * own)) return std::nullopt;
            off = own + apart;
        }
        const double reach = 4 * off;
        // Rays around a base begin inside, on its axis or in its centre.
        const bool is_at_begin = !normal_ && out.norm() <= reach;
        if (!(is_at_begin || is_inside(p - reach * u)) || !is_outside(site, p + reach * u))
            return std::nullopt;
        return reach;
    }

    bool is_inside(const Vec3& p) const {
        const double r = clearance(p), own = rounding(base_);
        for (int k = 0; k < 3; ++k)
            if (!(p[k] - scene_.box.min[k] > own && scene_.box.max[k] - p[k] > own)) return false;
        if (scene_.probe && !(r < *scene_.probe - own)) return false;
        for (std::size_t i = 0; i < cores_.size(); ++i) {
            if (!scene_.competes(i)) continue;
            const auto [value, error] = excess(i, p);
            if (!(value > error)) return false;
        }
        return true;
    }
    bool is_outside(Site site, const Vec3& p) const {
        const double r = clearance(p), own = rounding(base_);
        if (site == Site::cap()) return r > *scene_.probe + own;
        if (site.is_object()) {
            const auto [value, error] = excess(scene_.place(site.index), p);
            return value < -error;
        }
        const unsigned k = site.index / 2;
        return site.index % 2 == 1 ? p[k] > scene_.box.max[k] + own : p[k] < scene_.box.min[k] - own;
    }
    // A plane or a tube sends rays only from where it is in the box, unless the cell is complete.
    bool stands_over_region(const Vec3& p) const {
        if (base_.dimension == 0 || cell_.is_complete) return true;
        const Vec3 foot = base_.foot(p);
        for (int k = 0; k < 3; ++k) {
            const double axis = base_.along[0][k],
                         reach = base_.dimension == 1 && axis != 0
                                     ? base_.radius * std::sqrt(std::max(0.0, 1 - axis * axis))
                                     : 0;
            // Sides may be the base itself.
            if (foot[k] - reach < scene_.box.min[k] - rounding(base_) ||
                foot[k] + reach > scene_.box.max[k] + rounding(base_))
                return false;
        }
        return true;
    }

    std::optional<ClearancePlace> settled(std::optional<ClearancePlace> place, double value,
                                          double error) const {
        if (!place) return std::nullopt;
        const double off = std::abs(place->clearance - value);
        if (!(off <= error + 2 * place->error + 4 * rounding(base_))) return std::nullopt;
        constexpr double sums = 1 + 0x1p-50;  // of the sum below
        place->clearance_error = (off + error) * sums + 0x1p-52 * std::abs(value);
        return place;
    }

    const Cell& cell_;
    const Scene& scene_;
    const Measures& measures_;
    const Core base_;
    std::optional<Vec3> normal_;  // of a base plane
    std::vector<Core> cores_;
    double size_ = 0;
    std::array<std::optional<ClearancePlace>, 2> best_;
};

}  // namespace

ClearancePlaces clearance_places(const Cell& cell) { return PlaceSearch(cell).run(); }

}  // namespace vcell
