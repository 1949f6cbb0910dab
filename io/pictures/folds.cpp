#include "folds.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cstdint>
#include <numeric>
#include <optional>
#include <unordered_map>
#include <utility>
#include <vector>

#include "mesh_shape.hpp"

namespace vcell {

namespace {

// Some direction across both where they are all but parallel: a patch as wide as the spacing of doubles has
// places where one parameter moves nothing.
Vec3 unit_across(const Vec3& du, const Vec3& dv) {
    const Vec3 n = du.cross(dv).stableNormalized();
    if (n != Vec3::Zero()) return n;
    const Vec3 along = du.squaredNorm() > dv.squaredNorm() ? du : dv;
    return along != Vec3::Zero() ? Vec3(along.unitOrthogonal()) : Vec3(Vec3::UnitZ());
}

// In a tip, where u moves nothing, it is that beside the tip.
Vec3 unit_normal(const RationalPatch& s, const Vec2& p) {
    const auto [du, dv] = s.partials(p.x(), p.y());
    constexpr double next_to_nothing = 0x1p-40, aside = 0x1p-10;
    if (du.norm() > next_to_nothing * dv.norm()) return unit_across(du, dv);
    const double middle = 0.5 * (s.domain_v[0] + s.domain_v[1]), beside = p.y() + aside * (middle - p.y());
    const auto [du2, dv2] = s.partials(p.x(), beside);
    return unit_across(du2, dv2);
}

// Half way between two points of a patch in space, straight in parameters.
Vec2 half_way(const RationalPatch& s, const Vec2& a, const Vec2& b) {
    const auto between = [&](double part) -> Vec2 { return (1 - part) * a + part * b; };
    return between(middle_in_space(0, 1, [&](double part) {
        const Vec2 uv = between(part);
        return s.evaluate(uv.x(), uv.y());
    }));
}

// By point, in their order: along a sliver all of a triangulation may be turned over.
class TrianglesAround {
public:
    explicit TrianglesAround(const Triangulation& t) : begin_(t.points.size() + 1, 0) {
        for (const Triangle& v : t.triangles)
            for (const std::uint32_t i : v) ++begin_[i + 1];
        std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
        triangles_.resize(begin_.back());
        std::vector<std::uint32_t> next = begin_;
        for (std::uint32_t k = 0; k < t.triangles.size(); ++k)
            for (const std::uint32_t i : t.triangles[k]) triangles_[next[i]++] = k;
    }

    std::span<const std::uint32_t> operator[](std::uint32_t point) const {
        return {triangles_.data() + begin_[point], begin_[point + 1] - begin_[point]};
    }

private:
    std::vector<std::uint32_t> begin_, triangles_;
};

class Placement {
public:
    Placement(const RationalPatch& s, std::vector<Vec3> polygon, Triangulation& t)
        : surface_(s), inner_(polygon.size()), t_(t), places_(std::move(polygon)) {
        places_.reserve(t.points.size());
        normals_.reserve(t.points.size());
        for (std::size_t i = 0; i < t.points.size(); ++i) {
            if (i >= inner_) places_.push_back(s.evaluate(t.points[i].x(), t.points[i].y()));
            normals_.push_back(normal(t.points[i]));
        }
    }

    PlacedPoints without_folds(double doubt) && {
        move_inner_points();
        PlacedPoints placed;
        if (std::ranges::any_of(t_.triangles, [&](const Triangle& v) { return is_over(v); })) {
            flip_folds();
            if (clearly_over(doubt) > 0) halve_folds(doubt);
            placed.folded = clearly_over(doubt);
            placed.at_folds = polygon_at_folds(doubt);
        }
        placed.places = std::move(places_);
        placed.normals = std::move(normals_);
        return placed;
    }

private:
    Vec3 normal(const Vec2& p) const { return unit_normal(surface_, p); }
    bool is_over(const Triangle& v) const { return extent(v) < 0; }
    // Twice the triangle's area along its normals.
    double extent(const Triangle& v) const {
        const Vec3 &a = places_[v[0]], &b = places_[v[1]], &c = places_[v[2]];
        const Vec3 n = normals_[v[0]] + normals_[v[1]] + normals_[v[2]];
        return (b - a).cross(c - a).dot(n.stableNormalized());
    }
    // What of it is turned over.
    double folded(const Triangle& v) const { return std::max(0.0, -extent(v)); }
    void put(std::uint32_t i, const Vec2& p) {
        t_.points[i] = p;
        places_[i] = surface_.evaluate(p.x(), p.y());
        normals_[i] = normal(p);
    }
    // Along a sliver all triangles may be turned over, and one point be a corner of most: where it could not
    // be moved it is left alone until something around it has been, and where it has been tried many times.
    void move_inner_points() {
        std::optional<TrianglesAround> around;  // found where any is turned over
        std::vector<bool> is_stuck;
        constexpr std::uint8_t most_tries = 16;  // far more than where triangles end up the right way round
        std::vector<std::uint8_t> tries;
        for (const Triangle& v : t_.triangles)
            for (const std::uint32_t i : v) {
                if (i < inner_ || !is_over(v)) continue;
                if (!around) {
                    around.emplace(t_);
                    is_stuck.assign(t_.points.size(), false);
                    tries.assign(t_.points.size(), 0);
                }
                if (is_stuck[i] || tries[i] == most_tries) continue;
                ++tries[i];
                is_stuck[i] = !move(i, (*around)[i]);
                if (is_stuck[i]) continue;
                for (const std::uint32_t t : (*around)[i])
                    for (const std::uint32_t beside : t_.triangles[t]) is_stuck[beside] = false;
            }
    }
    // Or leaves the point where it is: false.
    bool move(std::uint32_t i, std::span<const std::uint32_t> around) {
        Vec2 sum = Vec2::Zero();
        for (const std::uint32_t t : around) {
            const Triangle& v = t_.triangles[t];
            sum += t_.points[v[v[0] == i ? 1 : v[1] == i ? 2 : 0]];
        }
        const Vec2 from = t_.points[i], middle = sum / static_cast<double>(around.size());
        for (const double part : {0.25, 0.5, 0.75, 1.0}) {
            put(i, (1 - part) * from + part * middle);
            if (std::ranges::none_of(around, [&](std::uint32_t t) { return is_over(t_.triangles[t]); }))
                return true;
        }
        put(i, from);
        return false;
    }

    // ---- Other diagonals

    // A triangle that is lower than the surface bends along it may be turned over though it is not in the
    // parameters. Pairs of triangles take the other diagonal, first where that makes them rounder in space
    // and leaves no more of them turned over, then where it leaves less.
    void flip_folds() {
        for (std::uint32_t t = 0; t < t_.triangles.size(); ++t) enter(t);
        std::vector<std::uint32_t> all(t_.triangles.size());
        std::iota(all.begin(), all.end(), 0u);
        flip(all);
    }
    // Returns these triangles and all that have changed.
    std::vector<std::uint32_t> flip(const std::vector<std::uint32_t>& some) {
        std::vector<std::uint32_t> seen =
            flip_while(some, [&](const Pair& pair) { return pair.gain >= 0 ? -cotangents(pair) : 0; });
        return flip_while(std::move(seen), [&](const Pair& pair) { return is_told(pair) ? pair.gain : 0; });
    }

    // Two triangles a, b, c and b, a, d, which become a, d, c and d, b, c.
    struct Pair {
        std::uint32_t first, second;
        std::array<std::uint32_t, 4> corners;
        double before, gain;  // what of them is turned over, and how much less of it there will be
    };

    static std::uint64_t key(std::uint32_t a, std::uint32_t b) { return std::uint64_t{a} << 32 | b; }
    void enter(std::uint32_t t) {
        const Triangle& v = t_.triangles[t];
        for (std::size_t k = 0; k < 3; ++k) sides_[key(v[k], v[(k + 1) % 3])] = t;
    }
    void leave(std::uint32_t t) {
        const Triangle& v = t_.triangles[t];
        for (std::size_t k = 0; k < 3; ++k) sides_.erase(key(v[k], v[(k + 1) % 3]));
    }
    // The triangle and the one beyond its side k. None where that is the polygon's, or where the other
    // diagonal is a side already.
    std::optional<Pair> pair_at(std::uint32_t t, std::size_t k) const {
        const Triangle& v = t_.triangles[t];
        const std::uint32_t a = v[k], b = v[(k + 1) % 3], c = v[(k + 2) % 3];
        const auto beyond = sides_.find(key(b, a));
        if (beyond == sides_.end() || beyond->second == t) return std::nullopt;
        const Triangle& w = t_.triangles[beyond->second];
        const std::uint32_t d = w[w[0] == a ? 1 : w[1] == a ? 2 : 0];
        if (c == d || sides_.contains(key(c, d)) || sides_.contains(key(d, c))) return std::nullopt;
        const Triangle p{a, d, c}, q{d, b, c};
        // In the parameters none becomes turned over or has nothing, as one of three points on a side that
        // was halved has.
        constexpr double next_to_nothing = 0x1p-20;
        const double least = std::min(turn(p), turn(q));
        if (!(least > next_to_nothing * (turn(v) + turn(w)) || least > std::min(turn(v), turn(w))))
            return std::nullopt;
        const double before = folded(v) + folded(w);
        return Pair{t, beyond->second, {a, b, c, d}, before, before - folded(p) - folded(q)};
    }
    // Twice the signed area in the parameters.
    double turn(const Triangle& v) const {
        const Vec2 p = t_.points[v[1]] - t_.points[v[0]], q = t_.points[v[2]] - t_.points[v[0]];
        return p.x() * q.y() - p.y() * q.x();
    }
    // More than rounding makes of areas.
    static bool is_told(const Pair& pair) {
        constexpr double least = 0x1p-20;
        return pair.gain > least * pair.before;
    }
    // The sum of the cotangents of the angles across the side: negative if these add up to more than a
    // straight one, where Delaunay takes the other diagonal.
    double cotangents(const Pair& pair) const {
        const auto& [a, b, c, d] = pair.corners;
        const auto cotangent = [&](std::uint32_t at) {
            const Vec3 p = places_[a] - places_[at], q = places_[b] - places_[at];
            return p.dot(q) / p.cross(q).norm();
        };
        const double sum = cotangent(c) + cotangent(d);
        constexpr double least = 0x1p-20;  // or pairs of four points on a circle would flip to and fro
        return sum < -least ? sum : 0;
    }
    // As long as a pair's gain is above 0: of each triangle that waits the pair that gains most. Returns
    // those that waited and all that have changed.
    template <class Gain>
    std::vector<std::uint32_t> flip_while(std::vector<std::uint32_t> waiting, const Gain& gain) {
        std::vector<std::uint32_t> seen = waiting;
        constexpr std::size_t most_times = 64;  // a triangle is looked at; far more than it is
        std::size_t left = most_times * waiting.size();
        while (!waiting.empty() && left-- > 0) {
            const std::uint32_t t = waiting.back();
            waiting.pop_back();
            std::optional<Pair> best;
            double most = 0;
            for (std::size_t k = 0; k < 3; ++k) {
                const std::optional<Pair> pair = pair_at(t, k);
                const double gained = pair ? gain(*pair) : 0;
                if (!(gained > most)) continue;
                most = gained;
                best = pair;
            }
            if (!best) continue;
            const auto& [a, b, c, d] = best->corners;
            leave(best->first);
            leave(best->second);
            t_.triangles[best->first] = {a, d, c};
            t_.triangles[best->second] = {d, b, c};
            for (const std::uint32_t changed : {best->first, best->second}) {
                enter(changed);
                waiting.push_back(changed);
                seen.push_back(changed);
            }
        }
        std::ranges::sort(seen);
        seen.erase(std::ranges::unique(seen).begin(), seen.end());
        return seen;
    }

    // ---- More points

    // Is it turned over by more than what its corners are off?
    bool is_clearly_over(const Triangle& v, double doubt) const {
        double longest = 0;
        for (std::size_t k = 0; k < 3; ++k)
            longest = std::max(longest, (places_[v[k]] - places_[v[(k + 1) % 3]]).norm());
        return extent(v) < -doubt * longest;
    }
    // The area of all such triangles.
    double clearly_over(double doubt) const {
        double area = 0;
        for (const Triangle& v : t_.triangles)
            if (is_clearly_over(v, doubt)) area += 0.5 * folded(v);
        return area;
    }
    // A triangle that stays turned over is longer than the surface is straight: its longest side is halved,
    // whose middle is where the surface is, beyond the third corner. Beside a side of the polygon that is too
    // long itself there is no end to that: then, and where it does not leave less of them, all is as before.
    void halve_folds(double doubt) {
        const Triangulation before = t_;
        const double area_before = clearly_over(doubt);
        std::vector<std::uint32_t> waiting;
        for (std::uint32_t t = 0; t < t_.triangles.size(); ++t)
            if (is_clearly_over(t_.triangles[t], doubt)) waiting.push_back(t);
        constexpr std::size_t most_points = 32;  // for each of them: far more than where there is an end
        std::size_t left = most_points * waiting.size();
        while (!waiting.empty() && left > 0) {
            const std::uint32_t t = waiting.back();
            waiting.pop_back();
            if (!is_clearly_over(t_.triangles[t], doubt)) continue;
            const auto halved = halve_longest(t);
            if (!halved) continue;
            --left;
            const std::vector<std::uint32_t> seen = flip({halved->begin(), halved->end()});
            waiting.insert(waiting.end(), seen.begin(), seen.end());
        }
        if (left > 0 && clearly_over(doubt) < area_before) return;
        t_ = before;
        places_.resize(t_.points.size());
        normals_.resize(t_.points.size());
    }
    // Four triangles in place of two, if the longest side is none of the polygon.
    std::optional<std::array<std::uint32_t, 4>> halve_longest(std::uint32_t t) {
        const Triangle v = t_.triangles[t];
        const auto length = [&](std::size_t k) { return (places_[v[k]] - places_[v[(k + 1) % 3]]).norm(); };
        std::size_t k = 0;
        for (const std::size_t other : {1, 2})
            if (length(other) > length(k)) k = other;
        const std::uint32_t a = v[k], b = v[(k + 1) % 3], c = v[(k + 2) % 3];
        const auto beyond = sides_.find(key(b, a));
        if (beyond == sides_.end()) return std::nullopt;
        const std::uint32_t s = beyond->second;
        const Triangle w = t_.triangles[s];
        const std::uint32_t d = w[w[0] == a ? 1 : w[1] == a ? 2 : 0];
        const auto m = static_cast<std::uint32_t>(t_.points.size());
        t_.points.push_back(half_way(surface_, t_.points[a], t_.points[b]));
        places_.push_back(surface_.evaluate(t_.points[m].x(), t_.points[m].y()));
        normals_.push_back(normal(t_.points[m]));
        leave(t);
        leave(s);
        const auto t2 = static_cast<std::uint32_t>(t_.triangles.size()), s2 = t2 + 1;
        t_.triangles[t] = {a, m, c};
        t_.triangles[s] = {m, a, d};
        t_.triangles.push_back({m, b, c});
        t_.triangles.push_back({b, m, d});
        for (const std::uint32_t changed : {t, s, t2, s2}) enter(changed);
        return std::array{t, s, t2, s2};
    }
    std::vector<std::uint32_t> polygon_at_folds(double doubt) const {
        std::vector<std::uint32_t> result;
        for (const Triangle& v : t_.triangles) {
            if (!is_clearly_over(v, doubt)) continue;
            for (const std::uint32_t i : v)
                if (i < inner_) result.push_back(i);
        }
        return result;
    }

    const RationalPatch& surface_;
    std::size_t inner_;
    Triangulation& t_;
    std::vector<Vec3> places_, normals_;
    std::unordered_map<std::uint64_t, std::uint32_t> sides_;  // whose triangle has a side in this direction
};

/// A corner of a triangle of the mesh.
struct MeshCorner {
    std::uint32_t point, normal;
};

class Separator {
public:
    Separator(CellMesh& mesh, std::vector<DrawnPatch>& drawn)
        : mesh_(mesh), drawn_(drawn), patch_of_(mesh.triangles.size(), none) {
        for (std::uint32_t p = 0; p < drawn.size(); ++p)
            std::fill(patch_of_.begin() + static_cast<std::ptrdiff_t>(drawn[p].begin),
                      patch_of_.begin() + static_cast<std::ptrdiff_t>(drawn[p].end), p);
        for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t)
            for (std::uint32_t k = 0; k < 3; ++k) sides_.push_back(side(t, k));
        std::ranges::sort(sides_);
    }

    void run() {
        std::vector<Side> doubled;
        for (std::size_t i = 1; i < sides_.size(); ++i)
            if (sides_[i] == sides_[i - 1]) doubled.push_back(sides_[i]);
        for (const Side& s : doubled)
            if (all(s).size() > 1) separate(s, none);  // not so after a flip for the side's other direction
        for (std::uint32_t p = 0; p < drawn_.size(); ++p)
            for (const Side& s : taken_sides(p)) separate(s, p);
    }

private:
    static constexpr std::uint32_t none = UINT32_MAX;
    using Side = std::pair<std::uint32_t, std::uint32_t>;
    struct Place {
        std::uint32_t triangle, k;
    };
    /// Two triangles of one patch on both sides of a side, and how they look with the other diagonal.
    struct Flip {
        Place first, second;
        std::array<MeshCorner, 4> corners;  // a, b, c and d: a to b is the side, c and d are across it
        double least;                       // of the two new triangles, along their normals; or none
    };

    Side side(std::uint32_t t, std::uint32_t k) const {
        return {mesh_.triangles[t][k], mesh_.triangles[t][(k + 1) % 3]};
    }
    MeshCorner corner(const Place& p, std::uint32_t further) const {
        const std::uint32_t k = (p.k + further) % 3;
        return {mesh_.triangles[p.triangle][k], mesh_.corner_normals[p.triangle][k]};
    }
    bool is_side(const Side& s) const { return std::ranges::binary_search(sides_, s); }
    bool is_taken(std::uint32_t patch, const Side& s) const {
        return std::ranges::binary_search(drawn_[patch].taken,
                                          MeshSide{std::min(s.first, s.second), std::max(s.first, s.second)});
    }
    std::vector<Place> all(const Side& s) const {
        std::vector<Place> places;
        for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t)
            for (std::uint32_t k = 0; k < 3; ++k)
                if (side(t, k) == s) places.push_back({t, k});
        return places;
    }
    // Those of a patch that are taken, in one direction each.
    std::vector<Side> taken_sides(std::uint32_t patch) const {
        std::vector<Side> result;
        if (drawn_[patch].taken.empty()) return result;
        for (auto t = static_cast<std::uint32_t>(drawn_[patch].begin); t < drawn_[patch].end; ++t)
            for (std::uint32_t k = 0; k < 3; ++k)
                if (const Side s = side(t, k); s.first < s.second && is_taken(patch, s)) result.push_back(s);
        return result;
    }
    // Twice the triangle's area along its normals.
    double extent(const MeshCorner& a, const MeshCorner& b, const MeshCorner& c) const {
        const Vec3 &p = mesh_.points[a.point], &q = mesh_.points[b.point], &r = mesh_.points[c.point];
        return (q - p).cross(r - p).dot(
            (mesh_.normals[a.normal] + mesh_.normals[b.normal] + mesh_.normals[c.normal]).normalized());
    }

    // Takes the side away from a patch: from one of those that may change, if it is `none`.
    void separate(const Side& s, std::uint32_t from) {
        std::optional<Flip> best;
        const std::vector<Place> uses = all(s);
        for (const Place& first : uses)
            for (const Place& second : all({s.second, s.first})) {
                const std::uint32_t patch = patch_of_[first.triangle];
                if (patch == none || patch != patch_of_[second.triangle]) continue;
                if (from != none && patch != from) continue;
                const MeshCorner a = corner(first, 0), b = corner(first, 1), c = corner(first, 2),
                                 d = corner(second, 2);
                if (a.normal != corner(second, 1).normal || b.normal != corner(second, 0).normal) continue;
                const bool is_free = c.point != d.point && !is_side({c.point, d.point}) &&
                                     !is_side({d.point, c.point}) && !is_taken(patch, {c.point, d.point});
                const double least = is_free ? std::min(extent(a, d, c), extent(d, b, c)) : 0;
                if (!best || least > best->least) best = Flip{first, second, {a, b, c, d}, least};
            }
        if (!best) return;
        if (best->least > 0)
            flip(*best);
        else
            divide(*best);
    }

    void put(std::size_t triangle, const std::array<MeshCorner, 3>& v) {
        for (std::uint32_t k = 0; k < 3; ++k) {
            mesh_.triangles[triangle][k] = v[k].point;
            mesh_.corner_normals[triangle][k] = v[k].normal;
        }
    }
    void add_side(const MeshCorner& a, const MeshCorner& b) {
        for (const Side& added : {Side{a.point, b.point}, Side{b.point, a.point}})
            sides_.insert(std::ranges::upper_bound(sides_, added), added);
    }
    void flip(const Flip& flip) {
        const auto& [a, b, c, d] = flip.corners;
        put(flip.first.triangle, {a, d, c});
        put(flip.second.triangle, {d, b, c});
        add_side(c, d);
    }
    // Four triangles in place of two.
    void divide(const Flip& pair) {
        const auto& [a, b, c, d] = pair.corners;
        const std::uint32_t patch = patch_of_[pair.first.triangle];
        const DrawnPatch& p = drawn_[patch];
        const std::size_t i = a.normal - p.first_normal, j = b.normal - p.first_normal, at = p.end;
        if (!(i < p.parameters.size() && j < p.parameters.size())) return;  // of a point that divides another
        const Vec2 uv = half_way(*p.surface, p.parameters[i], p.parameters[j]);
        const MeshCorner m{static_cast<std::uint32_t>(mesh_.points.size()),
                           static_cast<std::uint32_t>(mesh_.normals.size())};
        mesh_.points.push_back(p.surface->evaluate(uv.x(), uv.y()));
        mesh_.normals.push_back(unit_normal(*p.surface, uv));
        make_room(at, patch);
        put(pair.first.triangle, {a, m, c});
        put(pair.second.triangle, {m, a, d});
        put(at, {m, b, c});
        put(at + 1, {b, m, d});
        for (const MeshCorner& corner : pair.corners) add_side(m, corner);
    }
    // For two triangles at the end of a patch.
    void make_room(std::size_t at, std::uint32_t patch) {
        constexpr std::size_t count = 2;
        const auto place = static_cast<std::ptrdiff_t>(at);
        mesh_.triangles.insert(mesh_.triangles.begin() + place, count, Triangle());
        mesh_.corner_normals.insert(mesh_.corner_normals.begin() + place, count, Triangle());
        patch_of_.insert(patch_of_.begin() + place, count, patch);
        for (std::uint32_t q = 0; q < drawn_.size(); ++q) {
            if (q > patch) drawn_[q].begin += count;
            if (q >= patch) drawn_[q].end += count;
        }
        for (CellMesh::Group& group : mesh_.groups) {
            if (group.begin >= at) group.begin += count;
            if (group.end >= at) group.end += count;
        }
    }

    CellMesh& mesh_;
    std::vector<DrawnPatch>& drawn_;
    std::vector<std::uint32_t> patch_of_;
    std::vector<Side> sides_;  // of all triangles, ascending, and what has been added
};

}  // namespace

PlacedPoints place_without_folds(const RationalPatch& s, std::vector<Vec3> polygon, double doubt,
                                 Triangulation& t) {
    return Placement(s, std::move(polygon), t).without_folds(doubt);
}

void separate_sides(CellMesh& mesh, std::vector<DrawnPatch>& drawn) { Separator(mesh, drawn).run(); }

}  // namespace vcell
