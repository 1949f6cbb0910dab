/// The vertices and faces of a diagram on the unit sphere by place (sphere_diagram.cpp): which of them may a
/// linear form conflict with?
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <vector>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

#include "../../core/small_vector.hpp"

namespace vcell::discs {

using Eigen::Vector3d;
using Index = std::uint32_t;
constexpr Index none = UINT32_MAX;

/// More than the rounding of a handful of lengths, as a part of them.
constexpr double slack = 0x1p-44;

/// b.p + e. error: bounds what the coefficients' errors and rounding change about the value, or about a
/// difference of two values, anywhere on the sphere, and the length of the error of b. slope >= |b|, also of
/// the true b.
struct Linear {
    Vector3d b;
    double e;
    double error;
    double slope;
    double square;  // of b, rounded down

    Linear(const Vector3d& b, double e, double error)
        : b(b),
          e(e),
          error(error),
          slope(b.norm() * (1 + slack) + error),
          square(b.squaredNorm() * (1 - slack)) {}

    double operator()(const Vector3d& p) const { return b[0] * p[0] + b[1] * p[1] + b[2] * p[2] + e; }
};

/// A bound on a part of the sphere.
struct BoundingBall {
    Vector3d center = Vector3d::Zero();
    double radius = 1;
};

/// The points of the sphere that are at most an angle away from a direction; all, unless a ball is known
/// around them.
struct Cap {
    Vector3d direction = Vector3d::UnitX();
    double cosine = -1, sine = 0;  // of the angle

    void shrink_to(const BoundingBall& ball) {
        const double length = ball.center.norm();
        if (!(length > 0)) return;
        direction = ball.center / length;
        cosine = (1 + length * length - ball.radius * ball.radius) / (2 * length) - slack / length;
        cosine = std::clamp(cosine, -1.0, 1.0);
        sine = std::sqrt(1 - cosine * cosine);
    }
    // Lower bound of b.p over the cap. Pre: slope >= |b|.
    double least(const Vector3d& b, double slope) const {
        const double towards = -b.dot(direction);
        if (towards >= cosine * slope) return -slope;
        const double across2 = slope * slope - towards * towards;
        return -cosine * towards - sine * std::sqrt(std::max(0.0, across2)) - slack * slope;
    }
};

/// A place in a plane where two forms tie, at most 2 from the centre. Another form is compared with those
/// there.
struct Mark {
    Vector3d p = Vector3d::Zero();
    double height = 0;  // of the forms that tie, in p
    double doubt = 0;   // bound on what error and rounding change about height
    double error = 0;   // bound on the distance of p from the true place
    // A form of which also value - 2 error is more in p is certainly higher in the true place; minus
    // infinity: a mark that is no more.
    double level = 0;

    // No form that is compared has a greater slope than the steepest.
    void set_level(double steepest) { level = height + doubt + steepest * error; }
    void remove() { level = -HUGE_VAL; }
    bool is_gone() const { return level == -HUGE_VAL; }

    // Is the form certainly higher in the true place?
    bool is_below(const Linear& form) const {
        return form(p) - 2 * form.error > level ||
               form(p) - height > 2 * form.error + doubt + form.slope * error;
    }
    bool is_above(const Linear& form) const {
        return height - form(p) > 2 * form.error + doubt + form.slope * error;
    }
};

/// The places and levels of numbered marks, side by side in short numbers: most forms are higher at most
/// marks, which is seen of four marks at a time.
class MarkRows {
public:
    void reserve(std::size_t marks) { rows_.reserve((marks + 3) / 4); }
    void set(Index i, const Mark& mark) {
        while (i / 4 >= rows_.size()) add_row();
        Row& row = rows_[i / 4];
        for (int k = 0; k < 3; ++k) row.p[k][i % 4] = static_cast<float>(mark.p[k]);
        const auto level = static_cast<float>(std::max(mark.level, -0x1p127));
        row.level[i % 4] = level + 0x1p-22f * std::abs(level) + least;
    }
    void remove(Index i) {
        if (i / 4 < rows_.size()) rows_[i / 4].level[i % 4] = -HUGE_VALF;
    }

    /// Calls visit(i) for the marks that their level does not show to be below the form, and some more; ends
    /// where that returns false.
    template <class Visit>
    bool search(const Linear& form, const Visit& visit) const {
        const Short b(form);
        for (const Row& row : rows_) {
            unsigned rest = ~b.higher(row) & 15u;
            for (auto i = 4 * static_cast<Index>(&row - rows_.data()); rest != 0; ++i, rest >>= 1)
                if ((rest & 1u) != 0 && row.level[i % 4] != -HUGE_VALF && !visit(i)) return false;
        }
        return true;
    }

private:
    static constexpr float least = std::numeric_limits<float>::min();
    using Four = std::array<float, 4>;
    struct alignas(16) Row {
        std::array<Four, 3> p{};
        Four level{-HUGE_VALF, -HUGE_VALF, -HUGE_VALF, -HUGE_VALF};  // of numbers that no mark has
    };

    // A form, lower than the true one by 3 errors and by more than rounding adds where |p| <= 2. With v =
    // 2^-24 that is 5 v |b| |p| for b and p, the products and two sums of them, 3 v (|b| |p| + |e|) for e and
    // the last sum, and less than 2^-140 for underflow. A number that is none is not above any level.
    struct Short {
        Four b;

        explicit Short(const Linear& form) {
            for (int k = 0; k < 3; ++k) b[k] = static_cast<float>(form.b[k]);
            const double e = form.e - 3 * form.error;
            b[3] = static_cast<float>(e - 0x1p-19 * (form.slope + std::abs(e))) - least;
        }
        // Of which marks is it: a bit for each.
#if defined(__SSE2__)
        unsigned higher(const Row& row) const {
            const auto term = [&](int k) {
                return _mm_mul_ps(_mm_set1_ps(b[k]), _mm_load_ps(row.p[k].data()));
            };
            const __m128 value =
                _mm_add_ps(_mm_add_ps(_mm_add_ps(term(0), term(1)), term(2)), _mm_set1_ps(b[3]));
            return static_cast<unsigned>(_mm_movemask_ps(_mm_cmpgt_ps(value, _mm_load_ps(row.level.data()))));
        }
#else
        unsigned higher(const Row& row) const {
            unsigned bits = 0;
            for (unsigned i = 0; i < 4; ++i) {
                const float value = b[0] * row.p[0][i] + b[1] * row.p[1][i] + b[2] * row.p[2][i] + b[3];
                if (value > row.level[i]) bits |= 1u << i;
            }
            return bits;
        }
#endif
    };

    [[gnu::noinline]] void add_row() { rows_.emplace_back(); }

    std::vector<Row> rows_;
};

/// The octant of a cube about `center` in which p lies, and the centres of the octants' own cubes, of half
/// the size.
inline Index octant(const Vector3d& center, const Vector3d& p) {
    return (p.x() > center.x()) + 2 * (p.y() > center.y()) + 4 * (p.z() > center.z());
}
inline Vector3d octant_center(const Vector3d& center, double half, Index octant) {
    return center + half * Vector3d(octant & 1 ? 1 : -1, octant & 2 ? 1 : -1, octant & 4 ? 1 : -1);
}

/// Vertices by place: an octree. A node knows how high the diagram gets at its vertices.
class VertexTree {
public:
    VertexTree() { add_node(Vector3d::Zero(), 1); }

    template <class Vertices>
    void add(Index v, const Vertices& vertices) {
        Index n = 0;
        const Vector3d& p = vertices[v].p;
        const double top = vertices[v].level;
        while (true) {
            nodes_[n].top = std::max(nodes_[n].top, top);
            if (nodes_[n].first == none) break;
            n = child(n, p);
        }
        put(v, n);
        if (nodes_[n].vertices.size() > largest_leaf && nodes_[n].half > least_half) divide(n, vertices);
    }
    void remove(Index v) {
        if (v >= entries_.size() || entries_[v].leaf == none) return;
        auto& leaf = nodes_[entries_[v].leaf].vertices;
        leaf[entries_[v].slot] = leaf.back();
        entries_[leaf.back()].slot = entries_[v].slot;
        leaf.pop_back();
        entries_[v].leaf = none;
    }
    // Calls visit(v) for all vertices that are not certainly below the form; ends where that returns false.
    template <class Vertices, class Visit>
    bool search(const Linear& form, const Vertices& vertices, const Visit& visit) {
        const double e = form.e - 3 * form.error, least = e - form.slope;
        open_.assign(1, 0);
        while (!open_.empty()) {
            Node& node = nodes_[open_.back()];
            open_.pop_back();
            double top = -HUGE_VAL;
            if (node.first == none) {
                for (const Index v : node.vertices) {
                    top = std::max(top, vertices[v].level);
                    if (!vertices[v].is_below(form) && !visit(v)) return false;
                }
            } else {
                for (Index c = node.first; c < node.first + 8; ++c) {
                    const Node& child = nodes_[c];
                    top = std::max(top, child.top);
                    if (least <= child.top && child.cap.least(form.b, form.slope) + e <= child.top)
                        open_.push_back(c);
                }
            }
            node.top = top;
        }
        return true;
    }

private:
    static constexpr std::size_t largest_leaf = 16;
    static constexpr double least_half = 0x1p-20;

    struct Node {
        Cap cap;  // holds the sphere within a cube
        double top =
            -HUGE_VAL;       // the vertices are certainly below forms that are higher than this in the cap
        Index first = none;  // of its children
        SmallVector<Index, largest_leaf + 2> vertices;
        Vector3d center;  // of the cube
        double half;      // of its side
    };
    struct Entry {
        Index leaf = none, slot = 0;
    };

    void add_node(const Vector3d& center, double half) {
        Node n{.cap = {}, .vertices = {}, .center = center, .half = half};
        n.cap.shrink_to({center, half * std::numbers::sqrt3 + slack});
        nodes_.push_back(std::move(n));
    }
    Index child(Index n, const Vector3d& p) const { return nodes_[n].first + octant(nodes_[n].center, p); }
    void put(Index v, Index leaf) {
        if (entries_.size() <= v) entries_.resize(2 * static_cast<std::size_t>(v) + 64);
        entries_[v] = {leaf, static_cast<Index>(nodes_[leaf].vertices.size())};
        nodes_[leaf].vertices.push_back(v);
    }

    template <class Vertices>
    void divide(Index n, const Vertices& vertices) {
        const auto all = std::move(nodes_[n].vertices);
        const double half = 0.5 * nodes_[n].half;
        const Vector3d center = nodes_[n].center;
        nodes_[n].first = static_cast<Index>(nodes_.size());
        for (Index i = 0; i < 8; ++i) add_node(octant_center(center, half, i), half);
        for (const Index v : all) {
            const Index leaf = child(n, vertices[v].p);
            put(v, leaf);
            nodes_[leaf].top = std::max(nodes_[leaf].top, vertices[v].level);
        }
    }

    std::vector<Node> nodes_;
    std::vector<Entry> entries_;  // of vertices, listed or not
    std::vector<Index> open_;     // working space of search()
};

/// The faces of the diagram by place: an octree over the centres that their balls had when they were added. A
/// node knows how far its faces reach, and how high their forms get on them.
class FaceTree {
public:
    FaceTree() { add_node(Vector3d::Zero(), 1); }

    void add(Index face, const BoundingBall& ball, double top) { add(0, face, ball, top); }

    // Calls visit(face) for the faces in whose neighbourhood the form may be lower than a face's, and for
    // some that are no more. ball(face) encloses a face, null: one that is no more; top(face) bounds its form
    // over it from above. Faces may shrink between searches.
    template <class BallOf, class Top, class Visit>
    void search(const Linear& form, const BallOf& ball, const Top& top, const Visit& visit) {
        search(0, form, ball, top, visit);
    }

private:
    static constexpr double diagonal = std::numbers::sqrt3 * (1 + slack);  // of the cube about a unit ball
    static constexpr std::size_t largest_leaf = 12;
    static constexpr Index visits_between = 4;  // of a leaf, until it is tidied again
    static constexpr double least_half = 0x1p-20;

    struct Node {
        Vector3d center;
        double half;               // of the cube's side
        double reach = -HUGE_VAL;  // the faces are no farther from the centre
        Cap cap;                   // so they lie in this
        double top = -HUGE_VAL;    // their forms are no higher on them
        Index first = none;        // of its children
        Index visits = 0;
        SmallVector<Index, largest_leaf + 2> faces;

        void set_reach(double to) {
            if (to == reach) return;
            reach = to;
            cap.shrink_to({center, reach});
        }
    };

    void add_node(const Vector3d& center, double half) {
        Node n{.center = center, .half = half, .cap = {}, .faces = {}};
        nodes_.push_back(std::move(n));
    }

    void add(Index n, Index face, const BoundingBall& ball, double top) {
        while (true) {
            Node& node = nodes_[n];
            node.set_reach(std::max(node.reach, (node.center - ball.center).norm() + ball.radius + slack));
            node.top = std::max(node.top, top);
            if (node.first == none) break;
            n = node.first + octant(node.center, ball.center);
        }
        nodes_[n].faces.push_back(face);
    }

    template <class BallOf, class Top, class Visit>
    void search(Index n, const Linear& form, const BallOf& ball, const Top& top, const Visit& visit) {
        if (nodes_[n].reach < 0 ||
            nodes_[n].cap.least(form.b, form.slope) + form.e - form.error > nodes_[n].top)
            return;
        if (nodes_[n].first == none) {
            const bool is_due = nodes_[n].visits++ % visits_between == 0;
            if (is_due) tidy(n, ball, top);
            for (const Index face : nodes_[n].faces) visit(face);
            if (is_due && nodes_[n].faces.size() > largest_leaf && nodes_[n].half > least_half)
                divide(n, ball, top);
            return;
        }
        double reach = -HUGE_VAL, highest = -HUGE_VAL;
        for (Index child = nodes_[n].first; child < nodes_[n].first + 8; ++child) {
            if (nodes_[child].reach < 0) continue;
            search(child, form, ball, top, visit);
            reach = std::max(reach, nodes_[child].half * diagonal + nodes_[child].reach);
            highest = std::max(highest, nodes_[child].top);
        }
        nodes_[n].set_reach(std::min(nodes_[n].reach, reach));
        nodes_[n].top = highest;
    }

    // Forgets faces that are no more, and learns what the others are like now.
    template <class BallOf, class Top>
    void tidy(Index n, const BallOf& ball, const Top& top) {
        Node& node = nodes_[n];
        erase_if(node.faces, [&](Index f) { return ball(f) == nullptr; });
        double reach = -HUGE_VAL;
        node.top = -HUGE_VAL;
        for (const Index f : node.faces) {
            reach = std::max(reach, (node.center - ball(f)->center).norm() + ball(f)->radius + slack);
            node.top = std::max(node.top, top(f));
        }
        node.set_reach(std::min(node.reach, reach));
    }

    template <class BallOf, class Top>
    void divide(Index n, const BallOf& ball, const Top& top) {
        const auto faces = std::move(nodes_[n].faces);
        const double half = 0.5 * nodes_[n].half;
        const Vector3d center = nodes_[n].center;
        nodes_[n].first = static_cast<Index>(nodes_.size());
        for (Index i = 0; i < 8; ++i) add_node(octant_center(center, half, i), half);
        for (const Index f : faces) add(n, f, *ball(f), top(f));
    }

    std::vector<Node> nodes_;
};

}  // namespace vcell::discs
