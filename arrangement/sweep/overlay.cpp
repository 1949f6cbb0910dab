#include "overlay.hpp"

namespace vcell::detail {

IdVector<FaceId, FaceId> faces_in_input(const Dcel& overlay, const Dcel& input,
                                        const IdVector<EdgeId, EdgeId>& edge_in_input) {
    // The plane without vertices is connected: every face is reached from the unbounded one across
    // edges. Across an edge of the input one is beside that edge, on the same side as in the input since
    // both half-edges 2e run left to right; across any other edge one stays in the same input face.
    IdVector<FaceId, FaceId> in_input(overlay.face_count());
    in_input[Dcel::unbounded_face()] = Dcel::unbounded_face();
    std::vector<FaceId> reached{Dcel::unbounded_face()};
    const auto cross_component = [&](CcbId c, FaceId f) {
        HalfEdgeId h = overlay.start(c);
        do {
            const HalfEdgeId t = Dcel::twin(h);
            const FaceId beyond = overlay.face(t);
            if (!in_input[beyond].valid()) {
                const EdgeId e = edge_in_input[Dcel::edge(t)];
                in_input[beyond] = e.valid() ? input.face(Dcel::half_edge(e, t.value & 1u)) : in_input[f];
                reached.push_back(beyond);
            }
            h = overlay.next(h);
        } while (h != overlay.start(c));
    };
    while (!reached.empty()) {
        const FaceId f = reached.back();
        reached.pop_back();
        if (overlay.outer_ccb(f).valid()) cross_component(overlay.outer_ccb(f), f);
        for (const CcbId c : overlay.inner_ccbs(f)) cross_component(c, f);
    }
    return in_input;
}

}  // namespace vcell::detail
