/// A diagram with cylinders beside its solids: who is lowest by brute force, and what must hold whatever the
/// geometry.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "complaints.hpp"
#include "mixed_heights.hpp"

namespace vcell::mixed {

class StructureOracle : protected Complaints {
public:
    StructureOracle(const Scene& scene, const MinimizationDiagram& diagram)
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

    /// The form that is lowest at (x, y).
    FormId owner(Fast x, Fast y) const { return minimal(Point<Fast>{x, y}).front(); }

protected:
    // Heights closer than this, relative to their size, are equal: more than the 200 bits after which
    // the engine assumes it, and far less than distinct values ever are by accident.
    static inline const Real kTie{"1e-58"};

    static std::string text(Fast v) { return std::to_string(static_cast<double>(v)); }
    static std::string place(const Point<Fast>& p) { return "(" + text(p.x) + ", " + text(p.y) + ")"; }
    static Point<Fast> fast(const Point<Real>& p) { return {p.x.convert_to<Fast>(), p.y.convert_to<Fast>()}; }
    static Fast apart(const Point<Fast>& p, const Point<Fast>& q) { return std::hypot(p.x - q.x, p.y - q.y); }
    bool in_region(const Point<Fast>& p, Fast margin) const {
        return std::ranges::all_of(region_.sides, [&](const auto& s) {
            return s.a * p.x + s.b * p.y + s.c >= margin * std::hypot(Fast(s.a), Fast(s.b));
        });
    }

    // --- Brute force

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

    // --- Structure and labels

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

    const MinimizationDiagram& d_;
    const Dcel& dcel_;
    const ConvexRegion& region_;
    std::vector<Solid> solids_;
    std::vector<Point<Fast>> corners_;
    Point<Fast> low_{HUGE_VALL, HUGE_VALL}, high_{-HUGE_VALL, -HUGE_VALL};
    Fast size_ = 0;
};

}  // namespace vcell::mixed
