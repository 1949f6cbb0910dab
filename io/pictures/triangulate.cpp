#include "triangulate.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <deque>
#include <limits>
#include <numeric>
#include <unordered_map>

#include <Eigen/Geometry>

namespace vcell {

namespace {

using Point = Eigen::Vector2d;
constexpr std::uint32_t none = UINT32_MAX;

/// Twice the signed area of a, b, c.
double turn(const Point& a, const Point& b, const Point& c) {
    return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

/// Whether the open segments ab and cd cross in a point inside both.
bool cross(const Point& a, const Point& b, const Point& c, const Point& d) {
    const double c_side = turn(a, b, c), d_side = turn(a, b, d);
    if (!((c_side > 0 && d_side < 0) || (c_side < 0 && d_side > 0))) return false;
    const double a_side = turn(c, d, a), b_side = turn(c, d, b);
    return (a_side > 0 && b_side < 0) || (a_side < 0 && b_side > 0);
}

/// The polygon as one ring, holes joined to the outer loop by bridges that are run both ways.
class Ring {
public:
    Ring(const std::vector<Point>& points, const std::vector<std::vector<std::uint32_t>>& loops)
        : points_(points), ring_(loops[0]) {
        // Rightmost holes first: the way from a hole to the right meets the ring, not a hole still to come.
        std::vector<std::pair<double, std::size_t>> holes;
        for (std::size_t l = 1; l < loops.size(); ++l)
            holes.push_back({-points_[rightmost(loops[l])].x(), l});
        std::sort(holes.begin(), holes.end());
        for (const auto& [x, l] : holes) join(loops[l]);
    }

    const std::vector<std::uint32_t>& vertices() const { return ring_; }

private:
    std::uint32_t rightmost(const std::vector<std::uint32_t>& loop) const {
        return *std::max_element(loop.begin(), loop.end(),
                                 [&](auto a, auto b) { return points_[a].x() < points_[b].x(); });
    }

    void join(const std::vector<std::uint32_t>& hole) {
        const std::uint32_t h = rightmost(hole);
        const std::size_t r = bridge_end(points_[h]);
        // ... r, h, round the hole, h, r ...
        std::vector<std::uint32_t> detour;
        const auto at_h = std::find(hole.begin(), hole.end(), h);
        detour.insert(detour.end(), at_h, hole.end());
        detour.insert(detour.end(), hole.begin(), at_h);
        detour.push_back(h);
        detour.push_back(ring_[r]);
        ring_.insert(ring_.begin() + static_cast<std::ptrdiff_t>(r) + 1, detour.begin(), detour.end());
    }

    /// The nearest position in the ring, to the right of h, that h sees.
    std::size_t bridge_end(const Point& h) const {
        std::vector<std::pair<double, std::size_t>> candidates;
        for (std::size_t i = 0; i < ring_.size(); ++i)
            if (const Point& p = points_[ring_[i]]; p.x() >= h.x())
                candidates.push_back({(p - h).squaredNorm(), i});
        std::sort(candidates.begin(), candidates.end());
        for (const auto& [distance, i] : candidates)
            if (opens_towards(i, h) && sees(h, points_[ring_[i]])) return i;
        return candidates.empty() ? 0 : candidates.front().second;
    }

    /// Whether the polygon's inside at ring position i contains the direction to p: of several positions at
    /// one point, bridges go to the one between whose neighbours they run.
    bool opens_towards(std::size_t i, const Point& p) const {
        const Point& before = points_[ring_[(i + ring_.size() - 1) % ring_.size()]];
        const Point& at = points_[ring_[i]];
        const Point& after = points_[ring_[(i + 1) % ring_.size()]];
        const bool left_of_out = turn(at, after, p) >= 0, left_of_in = turn(before, at, p) >= 0;
        return turn(before, at, after) >= 0 ? left_of_out && left_of_in : left_of_out || left_of_in;
    }

    bool sees(const Point& a, const Point& b) const {
        for (std::size_t i = 0; i < ring_.size(); ++i)
            if (cross(a, b, points_[ring_[i]], points_[ring_[(i + 1) % ring_.size()]])) return false;
        return true;
    }

    const std::vector<Point>& points_;
    std::vector<std::uint32_t> ring_;
};

/// The positions of a ring that are left, by the coordinate along which it is longer.
class LeftOfRing {
public:
    LeftOfRing(const std::vector<Point>& points, const std::vector<std::uint32_t>& ring)
        : order_(ring.size()), place_(ring.size()), left_(ring.size() + 1) {
        Eigen::AlignedBox2d box;
        for (const std::uint32_t p : ring) box.extend(points[p]);
        axis_ = box.sizes().x() < box.sizes().y() ? 1 : 0;
        // Coordinates that are no numbers have an order, too.
        const auto along = [&](std::size_t i) {
            const double x = points[ring[i]][axis_];
            return std::isnan(x) ? -std::numeric_limits<double>::infinity() : x;
        };
        std::iota(order_.begin(), order_.end(), std::size_t(0));
        std::ranges::sort(order_, {}, along);
        std::iota(left_.begin(), left_.end(), std::size_t(0));
        for (std::size_t k = 0; k < order_.size(); ++k) {
            place_[order_[k]] = k;
            along_.push_back(along(order_[k]));
        }
    }

    void remove(std::size_t i) { left_[place_[i]] = place_[i] + 1; }

    /// Does it hold for a position that is left, of those beside the triangle?
    template <class Holds>
    bool any_beside(const Point& a, const Point& b, const Point& c, Holds&& holds) {
        const auto [low, high] = std::minmax({a[axis_], b[axis_], c[axis_]});
        const auto first = std::ranges::lower_bound(along_, low);
        for (std::size_t k = first_left(static_cast<std::size_t>(first - along_.begin()));
             k < along_.size() && along_[k] <= high; k = first_left(k + 1))
            if (holds(order_[k])) return true;
        return false;
    }

private:
    // At that place or later; what was passed on the way is skipped by halves the next time.
    std::size_t first_left(std::size_t k) {
        while (left_[k] != k) k = left_[k] = left_[left_[k]];
        return k;
    }

    Eigen::Index axis_ = 0;
    std::vector<double> along_;       // ascending
    std::vector<std::size_t> order_;  // positions by their coordinate
    std::vector<std::size_t> place_;  // of positions in this order
    std::vector<std::size_t> left_;   // the place itself, or a later one where its position was removed
};

/// Ear clipping: any ring of n vertices becomes n - 2 triangles, good ones if the ring is a polygon.
std::vector<Triangle> clip_ears(const std::vector<Point>& points, const std::vector<std::uint32_t>& ring) {
    std::vector<Triangle> triangles;
    const std::size_t n = ring.size();
    std::vector<std::size_t> next(n), prev(n);
    for (std::size_t i = 0; i < n; ++i) {
        next[i] = (i + 1) % n;
        prev[i] = (i + n - 1) % n;
    }
    LeftOfRing all_left(points, ring);
    const auto at = [&](std::size_t i) -> const Point& { return points[ring[i]]; };
    const auto is_ear = [&](std::size_t i) {
        const Point &a = at(prev[i]), &b = at(i), &c = at(next[i]);
        if (!(turn(a, b, c) > 0)) return false;
        return !all_left.any_beside(a, b, c, [&](std::size_t j) {
            const Point& p = at(j);
            return p != a && p != b && p != c && turn(a, b, p) >= 0 && turn(b, c, p) >= 0 &&
                   turn(c, a, p) >= 0;
        });
    };
    // A polygon has an ear after few vertices that are none; what rounding has crossed may ask for all each
    // time.
    constexpr std::size_t most_failures_of_each = 256;
    std::size_t i = 0, failures = 0, of_all = 0;
    for (std::size_t left = n; left > 2;) {
        // A whole round without an ear: the ring is no polygon as far as rounding can tell. Any vertex will
        // do.
        if (failures <= left && of_all <= most_failures_of_each * n && !is_ear(i)) {
            i = next[i];
            ++failures;
            ++of_all;
            continue;
        }
        triangles.push_back({ring[prev[i]], ring[i], ring[next[i]]});
        next[prev[i]] = next[i];
        prev[next[i]] = prev[i];
        all_left.remove(i);
        // Skipping the neighbour spreads the cuts, so that no vertex collects a fan of slivers.
        i = next[next[i]];
        failures = 0;
        --left;
    }
    return triangles;
}

/// Triangles with their neighbours; edge k of a triangle runs from vertex k to vertex k + 1.
class Mesh {
public:
    Mesh(std::vector<Point> points, std::vector<Triangle> triangles)
        : points_(std::move(points)), triangles_(std::move(triangles)) {
        across_.assign(triangles_.size(), {none, none, none});
        std::unordered_map<std::uint64_t, std::uint32_t> edges;  // directed edge -> triangle * 3 + side
        for (std::uint32_t t = 0; t < triangles_.size(); ++t)
            for (std::uint32_t k = 0; k < 3; ++k) {
                const std::uint64_t from = triangles_[t][k], to = triangles_[t][(k + 1) % 3];
                if (const auto twin = edges.find(to << 32 | from); twin != edges.end()) {
                    connect(t, k, twin->second / 3, twin->second % 3);
                    edges.erase(twin);
                } else {
                    edges[from << 32 | to] = 3 * t + k;
                }
            }
    }

    void make_delaunay() {
        for (std::uint32_t t = 0; t < triangles_.size(); ++t)
            for (std::uint32_t k = 0; k < 3; ++k) suspects_.push_back({t, k});
        legalize();
    }

    void refine(const std::function<bool(const Point&, const Point&)>& split, std::size_t bound) {
        // First come, first served: should the points run out, the mesh is equally fine everywhere. Round
        // triangles as long as the polygon's sides are n^2 / 16 or so.
        const std::size_t n = points_.size(), most_points = std::min(bound, n + n * n + 1000);
        std::deque<Side> todo;
        const auto add_all = [&](std::uint32_t t) {
            for (std::uint32_t k = 0; k < 3; ++k) todo.push_back({t, k});
        };
        for (std::uint32_t t = 0; t < triangles_.size(); ++t) add_all(t);
        is_short_.assign(triangles_.size(), {});
        while (!todo.empty() && points_.size() < most_points) {
            const auto [t, k] = todo.front();
            todo.pop_front();
            const std::uint32_t twin = across_[t][k];
            if (twin == none || is_short_[t][k]) continue;
            const Point &a = points_[triangles_[t][k]], &b = points_[triangles_[t][(k + 1) % 3]];
            if (a == b || !split(a, b)) {
                // Its other triangle asks about it, too.
                is_short_[t][k] = is_short_[twin / 3][twin % 3] = true;
                continue;
            }
            halve(t, k);
            changed_.clear();
            legalize();
            // Flips have moved edges about: look again at every triangle they or the cut have touched.
            for (const std::uint32_t c : changed_) add_all(c);
            for (const std::uint32_t c : cut_) add_all(c);
        }
    }

    Triangulation result() && { return {std::move(points_), std::move(triangles_)}; }

private:
    struct Side {
        std::uint32_t triangle, k;
    };

    void connect(std::uint32_t t, std::uint32_t k, std::uint32_t s, std::uint32_t l) {
        across_[t][k] = 3 * s + l;
        across_[s][l] = 3 * t + k;
    }
    void connect_outer(std::uint32_t t, std::uint32_t k, std::uint32_t outer) {
        across_[t][k] = outer;
        if (outer != none) across_[outer / 3][outer % 3] = 3 * t + k;
    }

    // The triangles at side k of t: (a, b, c) and, with this as its side l, s = (b, a, d); and what is across
    // their other sides.
    struct Both {
        std::uint32_t s, l, a, b, c, d, bc, ca, ad, db;
    };
    Both both_at(std::uint32_t t, std::uint32_t k) const {
        const std::uint32_t s = across_[t][k] / 3, l = across_[t][k] % 3;
        const Triangle &p = triangles_[t], &q = triangles_[s];
        return {s,
                l,
                p[k],
                p[(k + 1) % 3],
                p[(k + 2) % 3],
                q[(l + 2) % 3],
                across_[t][(k + 1) % 3],
                across_[t][(k + 2) % 3],
                across_[s][(l + 1) % 3],
                across_[s][(l + 2) % 3]};
    }

    // Cuts both triangles at side k of t through the side's midpoint.
    void halve(std::uint32_t t, std::uint32_t k) {
        const auto [s, l, a, b, c, d, bc, ca, ad, db] = both_at(t, k);
        const auto m = static_cast<std::uint32_t>(points_.size());
        points_.push_back(0.5 * (points_[a] + points_[b]));
        const auto t2 = static_cast<std::uint32_t>(triangles_.size()), s2 = t2 + 1;
        triangles_.resize(triangles_.size() + 2);
        across_.resize(across_.size() + 2);
        is_short_.resize(triangles_.size());
        const bool is_short_bc = is_short_[t][(k + 1) % 3], is_short_ca = is_short_[t][(k + 2) % 3],
                   is_short_ad = is_short_[s][(l + 1) % 3], is_short_db = is_short_[s][(l + 2) % 3];
        is_short_[t] = {false, false, is_short_ca};
        is_short_[t2] = {false, is_short_bc, false};
        is_short_[s] = {false, is_short_ad, false};
        is_short_[s2] = {false, false, is_short_db};
        triangles_[t] = {a, m, c};
        triangles_[t2] = {m, b, c};
        triangles_[s] = {m, a, d};
        triangles_[s2] = {b, m, d};
        connect(t, 0, s, 0);
        connect(t2, 0, s2, 0);
        connect(t, 1, t2, 2);
        connect(s, 2, s2, 1);
        connect_outer(t, 2, ca);
        connect_outer(t2, 1, bc);
        connect_outer(s, 1, ad);
        connect_outer(s2, 2, db);
        cut_ = {t, t2, s, s2};
        for (const Side side : {Side{t, 2}, Side{t2, 1}, Side{s, 1}, Side{s2, 2}}) suspects_.push_back(side);
    }

    // Flips until every inner edge is locally Delaunay. Each flip must gain noticeably, so the loop ends in
    // spite of rounding; the budget is for coordinates that are no numbers.
    void legalize() {
        std::size_t budget = 100 * triangles_.size() + 1000;
        while (!suspects_.empty()) {
            const auto [t, k] = suspects_.back();
            suspects_.pop_back();
            if (across_[t][k] == none || budget == 0 || !gains(t, k)) continue;
            --budget;
            flip(t, k);
        }
    }

    // Whether the other diagonal of the two triangles at side k of t is better.
    bool gains(std::uint32_t t, std::uint32_t k) const {
        constexpr double noticeable = 1e-9;  // of a sine
        const std::uint32_t s = across_[t][k] / 3, l = across_[t][k] % 3;
        const std::uint32_t ic = triangles_[t][(k + 2) % 3], id = triangles_[s][(l + 2) % 3];
        if (ic == id) return false;
        const Point &a = points_[triangles_[t][k]], &b = points_[triangles_[t][(k + 1) % 3]];
        const Point &c = points_[ic], &d = points_[id];
        const double new1 = turn(a, d, c), new2 = turn(d, b, c);
        if (!(new1 > 0 && new2 > 0)) return false;
        const double old1 = turn(a, b, c), old2 = turn(b, a, d);
        if (!(old1 > 0 && old2 > 0)) return std::min(new1, new2) > std::min(old1, old2);
        // Delaunay: the angles at c and d that see the edge add up to no more than a half turn.
        const double dot_c = (a - c).dot(b - c), dot_d = (a - d).dot(b - d);
        const double sine = old1 * dot_d + old2 * dot_c;  // sin(c + d) times the four lengths
        return sine < -noticeable * (a - c).norm() * (b - c).norm() * (a - d).norm() * (b - d).norm();
    }

    void flip(std::uint32_t t, std::uint32_t k) {
        const auto [s, l, a, b, c, d, bc, ca, ad, db] = both_at(t, k);
        triangles_[t] = {a, d, c};
        triangles_[s] = {d, b, c};
        if (!is_short_.empty()) {
            const std::array before{is_short_[t], is_short_[s]};
            is_short_[t] = {before[1][(l + 1) % 3], false, before[0][(k + 2) % 3]};
            is_short_[s] = {before[1][(l + 2) % 3], before[0][(k + 1) % 3], false};
        }
        connect(t, 1, s, 2);
        connect_outer(t, 0, ad);
        connect_outer(t, 2, ca);
        connect_outer(s, 0, db);
        connect_outer(s, 1, bc);
        for (const Side side : {Side{t, 0}, Side{t, 2}, Side{s, 0}, Side{s, 1}}) suspects_.push_back(side);
        changed_.push_back(t);
        changed_.push_back(s);
    }

    std::vector<Point> points_;
    std::vector<Triangle> triangles_;
    std::vector<std::array<std::uint32_t, 3>> across_;  // neighbour * 3 + its side; none on the polygon
    std::vector<std::array<bool, 3>> is_short_;         // sides that need not be halved, while refining
    std::vector<Side> suspects_;                        // sides that may not be Delaunay
    std::vector<std::uint32_t> changed_;                // triangles touched by flips
    std::array<std::uint32_t, 4> cut_{};                // triangles of the last halving
};

}  // namespace

Triangulation triangulate(const std::vector<std::vector<Point>>& loops,
                          const std::function<bool(const Point&, const Point&)>& split,
                          std::size_t most_points) {
    std::vector<Point> points;
    std::vector<std::vector<std::uint32_t>> indices;
    for (const auto& loop : loops) {
        indices.emplace_back(loop.size());
        std::iota(indices.back().begin(), indices.back().end(), static_cast<std::uint32_t>(points.size()));
        points.insert(points.end(), loop.begin(), loop.end());
    }
    if (loops.empty()) return {};
    const Ring ring(points, indices);
    std::vector<Triangle> triangles = clip_ears(points, ring.vertices());
    Mesh mesh(std::move(points), std::move(triangles));
    mesh.make_delaunay();
    mesh.refine(split, most_points);
    return std::move(mesh).result();
}

}  // namespace vcell
