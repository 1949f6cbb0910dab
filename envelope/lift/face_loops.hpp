/// The loops of edges around a diagram's faces.
#pragma once

#include <vector>

#include "../../core/small_vector.hpp"
#include "../cell.hpp"
#include "../diagram/minimization_diagram.hpp"

namespace vcell {

class FaceLoops {
public:
    /// Lists the loops of faces with a form, the outer one first; or last, as over curved bases, where none
    /// is known to be the outer one.
    explicit FaceLoops(const MinimizationDiagram& diagram, bool is_outer_first = false)
        : diagram_(diagram), loops_(diagram.dcel.face_count()) {
        for (const FaceId face : diagram.face_forms.ids()) {
            if (!diagram.face_forms[face].valid()) continue;
            const CcbId outer = diagram.dcel.outer_ccb(face);
            if (outer.valid() && is_outer_first) loops_[face].push_back(outer);
            for (const CcbId inner : diagram.dcel.inner_ccbs(face)) loops_[face].push_back(inner);
            if (outer.valid() && !is_outer_first) loops_[face].push_back(outer);
        }
    }

    const SmallVector<CcbId, 2>& operator[](FaceId face) const { return loops_[face]; }
    /// From here on loop i is the first one.
    void put_first(FaceId face, std::size_t i) { std::swap(loops_[face][0], loops_[face][i]); }

    /// Calls use(edge, reversed) around a loop.
    template <class Use>
    void around(CcbId ccb, Use&& use) const {
        const HalfEdgeId start = diagram_.dcel.start(ccb);
        HalfEdgeId h = start;
        do {
            use(Dcel::edge(h), h != Dcel::half_edge(Dcel::edge(h)));
            h = diagram_.dcel.next(h);
        } while (h != start);
    }
    /// Around all loops of a face.
    template <class Use>
    void around(FaceId face, Use&& use) const {
        for (const CcbId ccb : loops_[face]) around(ccb, use);
    }
    /// Calls use(place, is where an edge begins, is a vertex) for the ends of all pieces around a loop.
    template <class Use>
    void follow(CcbId ccb, Use&& use) const {
        around(ccb, [&](EdgeId e, bool reversed) {
            const auto pieces = diagram_.pieces(e);
            const std::size_t count = pieces.size();
            const auto end = [&](VertexId v, bool is_begin) {
                use(v.valid() ? diagram_.vertices[v].point : pieces.back().end, is_begin, v.valid());
            };
            end(reversed ? diagram_.end(e) : diagram_.start(e), true);
            for (std::size_t i = 0; i + 1 < count; ++i)
                use(pieces[reversed ? count - 2 - i : i].end, false, false);
            end(reversed ? diagram_.start(e) : diagram_.end(e), false);
        });
    }
    /// The trims of a face, in the order of its loops: set(edge, reversed, curve) makes each.
    template <class Set>
    std::vector<std::vector<TrimCurve>> trims(FaceId face, Set&& set) const {
        std::vector<std::vector<TrimCurve>> all;
        all.reserve(loops_[face].size());
        for (const CcbId ccb : loops_[face]) {
            std::vector<TrimCurve>& loop = all.emplace_back();
            loop.reserve(length(ccb));
            around(ccb, [&](EdgeId e, bool reversed) {
                TrimCurve& trim = append_new(loop);
                trim.edge = e.value;
                trim.reversed = reversed;
                set(e, reversed, trim.curve);
            });
        }
        return all;
    }
    std::size_t length(CcbId ccb) const {
        std::size_t n = 0;
        around(ccb, [&](EdgeId, bool) { ++n; });
        return n;
    }

private:
    const MinimizationDiagram& diagram_;
    IdVector<FaceId, SmallVector<CcbId, 2>> loops_;
};

}  // namespace vcell
