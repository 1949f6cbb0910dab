/// What the benches ask of a diagram before they believe its time.
#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "sphere_scene.hpp"

namespace vcell::bench {

/// Sizes of a diagram as the tables state them.
struct DiagramCounts {
    std::size_t vertices = 0, edges = 0;
    std::size_t faces = 0;         ///< without the unbounded one
    std::size_t closed_edges = 0;  ///< among `edges`: circles without vertices
    std::size_t owners = 0;        ///< forms that own a face

    explicit DiagramCounts(const MinimizationDiagram& d)
        : vertices(d.dcel.vertex_count()), edges(d.dcel.edge_count()), faces(d.dcel.face_count() - 1) {
        for (const EdgeId e : d.edges.ids()) closed_edges += !d.dcel.origin(Dcel::half_edge(e)).valid();
        std::vector<bool> owns(d.forms.size());
        for (const FormId f : d.face_forms)
            if (f.valid()) owns[f.value] = true;
        for (const bool o : owns) owners += o;
    }
};

/// Finds out which form the diagram says is lowest at a point, from edges and vertices alone.
///
/// The faces of form f hold p when their boundary, run with f on the left, winds around p once.
class Regions {
public:
    explicit Regions(const MinimizationDiagram& d) : d_(d), first_(d.forms.size() + 1) {
        for_each_side([&](FormId f, HalfEdgeId) { ++first_[f.value + 1]; });
        for (std::size_t i = 1; i < first_.size(); ++i) first_[i] += first_[i - 1];
        sides_.resize(first_.back());
        std::vector<std::uint32_t> end(first_.begin(), first_.end() - 1);
        for_each_side([&](FormId f, HalfEdgeId h) { sides_[end[f.value]++] = h; });
    }

    /// Times 2 pi, the winding number of f's boundary around p.
    double turn(FormId f, const Eigen::Vector2d& p) const {
        double angle = 0;
        for (std::uint32_t i = first_[f.value]; i < first_[f.value + 1]; ++i) angle += turn(sides_[i], p);
        return angle;
    }

private:
    template <class F>
    void for_each_side(F visit) const {
        for (const EdgeId e : d_.edges.ids()) {
            visit(d_.edges[e].left, Dcel::half_edge(e, 0));
            if (!d_.edges[e].on_rim()) visit(d_.edges[e].right, Dcel::half_edge(e, 1));
        }
    }

    // The angle under which p sees the arc from A to B: that of the chord, and a full turn more or less when
    // p lies between chord and arc. The arc has f on its left. It runs counter-clockwise when f - g, whose
    // square term is 1 / w_f - 1 / w_g, is convex: the side where f is lower is then the disc's inside.
    double turn(HalfEdgeId h, const Eigen::Vector2d& p) const {
        const VertexId from = d_.dcel.origin(h), to = d_.dcel.target(h);
        double angle = 0, cross = 0;
        if (from != to) {
            const Eigen::Vector2d a = d_.vertices[from].point - p, b = d_.vertices[to].point - p;
            cross = a.x() * b.y() - a.y() * b.x();
            angle = std::atan2(cross, a.dot(b));
        }
        const MinimizationDiagram::Edge& edge = d_.edges[Dcel::edge(h)];
        if (edge.on_rim()) return angle;
        const bool reversed = h != Dcel::half_edge(Dcel::edge(h));
        const CircularForm& f = d_.forms[reversed ? edge.right : edge.left];
        const CircularForm& g = d_.forms[reversed ? edge.left : edge.right];
        const int turning = (f.w < g.w) - (g.w < f.w);
        const bool f_lower = f(p.x(), p.y()) < g(p.x(), p.y());
        const bool in_disc = f_lower == (turning > 0);
        const bool beyond_chord = from == to || turning * cross < 0;
        return in_disc && beyond_chord ? angle + turning * 2 * std::numbers::pi : angle;
    }

    const MinimizationDiagram& d_;
    std::vector<std::uint32_t> first_;
    std::vector<HalfEdgeId> sides_;
};

/// What is wrong with the diagram of a scene, or an empty string: the structure (Euler's relation among
/// others), the labels of edges and faces, and at random points of the region the owner that trying all
/// spheres finds. Plain doubles serve: the points are fixed, and none lies within rounding of an edge.
inline std::string find_fault(const SphereScene& scene, const MinimizationDiagram& d, int samples) {
    if (const auto defect = d.dcel.find_defect()) return defect->what;
    for (const EdgeId e : d.edges.ids()) {
        const MinimizationDiagram::Edge& edge = d.edges[e];
        if (d.face_forms[d.dcel.face(Dcel::half_edge(e, 0))] != edge.left ||
            d.face_forms[d.dcel.face(Dcel::half_edge(e, 1))] != edge.right)
            return to_string(e) + " and the faces beside it name different forms";
    }
    const Regions regions(d);
    std::mt19937_64 random(7);
    std::uniform_real_distribution<double> x(scene.x0, scene.x1), y(scene.y0, scene.y1);
    for (int i = 0; i < samples; ++i) {
        const double px = x(random), py = y(random);
        const Eigen::Vector2d p(px, py);
        FormId lowest;
        double height = std::numeric_limits<double>::infinity();
        for (std::uint32_t s = 0; s < scene.spheres.size(); ++s) {
            const Sphere& sphere = scene.spheres[s];
            const double z = sphere.center.z(), r = sphere.radius;
            const double h =
                ((sphere.center.head<2>() - p).squaredNorm() + (z - r) * (z + r)) / (2 * (z + r));
            if (h < height) {
                height = h;
                lowest = {s};
            }
        }
        const double winding = regions.turn(lowest, p) / (2 * std::numbers::pi);
        if (!(std::abs(winding - 1) < 0.01))  // an integer up to rounding
            return "(" + std::to_string(px) + ", " + std::to_string(py) + ") belongs to " +
                   to_string(lowest) + ", whose faces wind around it " + std::to_string(winding) + " times";
    }
    return {};
}

}  // namespace vcell::bench
