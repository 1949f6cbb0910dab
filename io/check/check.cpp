#include "check.hpp"

#include <cmath>
#include <variant>

#include "closing.hpp"
#include "edges.hpp"
#include "entries.hpp"
#include "faces.hpp"
#include "kinds.hpp"
#include "measures.hpp"
#include "moments.hpp"
#include "structure.hpp"
#include "tiling.hpp"
#include "vertices.hpp"

namespace vcell {

Certificate certify(const Cell& cell, const CheckOptions& options) {
    using namespace check;
    Certificate certificate;
    const SceneGeometry geometry(cell.scene);
    certify_structure(cell, geometry, certificate);
    if (!certificate.holds()) return certificate;  // what follows evaluates all of it
    if (cell.is_complete && std::holds_alternative<Cylinder>(cell.scene.base)) {
        // In its parts rays come in on both sides of a side's plane.
        certificate.leave_open("cell", "complete cells around tubes are not judged", HUGE_VAL);
        return certificate;
    }
    // Two of each edge and about three of each face.
    certificate.elements.reserve(cell.vertices.size() + 2 * cell.edges.size() + 3 * cell.faces.size() +
                                 cell.neighbors.size() + 32);
    const Subject subject(cell, geometry, certificate);
    certify_tiling(subject, options, certificate);
    certify_vertices(subject, options, certificate);
    const auto edges = certify_edges(subject, options, certificate);
    certify_kinds(subject, options, certificate);
    certify_faces(subject, edges, options, certificate);
    certify_entries(subject, options, certificate);
    certify_closing(subject, edges, options, certificate);
    certify_moments(subject, options, certificate);
    const bool is_covered = certify_measures(subject, edges, options, certificate);
    if (!is_covered || !certificate.holds()) sample(subject, options, certificate);
    return certificate;
}

std::vector<Finding> check_cell(const Cell& cell, const CheckOptions& options) {
    std::vector<Finding> findings;
    for (Element& e : certify(cell, options).elements)
        if (e.verdict != Verdict::proved) findings.push_back({std::move(e.where), std::move(e.what)});
    return findings;
}

}  // namespace vcell
