/// The loops of edges around a diagram's faces.
#pragma once

#include "../../core/small_vector.hpp"
#include "../diagram/minimization_diagram.hpp"

namespace vcell {

class FaceLoops {
public:
    /// Of faces with a form. Over curved bases no loop is known to be the outer one.
    explicit FaceLoops(const MinimizationDiagram& diagram)
        : diagram_(diagram), loops_(diagram.dcel.face_count()) {
        for (const FaceId face : diagram.face_forms.ids()) {
            if (!diagram.face_forms[face].valid()) continue;
            const std::vector<CcbId>& inner = diagram.dcel.inner_ccbs(face);
            loops_[face].assign(inner.begin(), inner.end());
            if (const CcbId outer = diagram.dcel.outer_ccb(face); outer.valid())
                loops_[face].push_back(outer);
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
