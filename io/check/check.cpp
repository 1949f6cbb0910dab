#include "check.hpp"

#include <optional>
#include <vector>

#include "clearance_places.hpp"
#include "closing.hpp"
#include "edges.hpp"
#include "entries.hpp"
#include "faces.hpp"
#include "kinds.hpp"
#include "measures.hpp"
#include "moments.hpp"
#include "parts.hpp"
#include "structure.hpp"
#include "tiling.hpp"
#include "vertices.hpp"

namespace vcell {

Certificate certify(const Cell& cell, const CheckOptions& options) {
    using namespace check;
    if (!cell.scene.numbers.empty()) {
        Cell by_places = cell;
        number_by_places(by_places);
        return certify(by_places, options);
    }
    if (cell.scene.probe) return certify(with_cap_as_object(cell), options);
    Certificate certificate;
    const SceneGeometry geometry(cell.scene);
    certify_structure(cell, geometry, certificate);
    if (!certificate.holds()) return certificate;  // what follows evaluates all of it
    std::optional<TubeParts> known;
    if (cell.is_complete && geometry.is_cylinder()) {
        known = certify_parts(cell, geometry, certificate);
        if (!known) return certificate;
    } else if (!cell.parts.empty()) {
        certificate.refute("parts", "have only complete cells around tubes");
    }
    // Two of each edge and about three of each face.
    certificate.elements.reserve(cell.vertices.size() + 2 * cell.edges.size() + 3 * cell.faces.size() +
                                 cell.neighbors.size() + 32);
    std::vector<SceneGeometry> geometries;
    std::vector<Subject> subjects;
    if (known) {
        for (const TubePart& part : known->parts) geometries.emplace_back(cell.scene, &part);
        for (std::size_t k = 0; k < geometries.size(); ++k)
            subjects.emplace_back(cell, geometries[k], certificate, &known->parts[k]);
    } else {
        subjects.emplace_back(cell, geometry, certificate);
    }
    std::vector<EdgeBound> edges(cell.edges.size());
    for (const Subject& subject : subjects) {
        certify_tiling(subject, options, certificate);
        certify_vertices(subject, options, certificate);
        certify_edges(subject, options, certificate, edges);
        certify_kinds(subject, options, certificate);
        certify_faces(subject, edges, options, certificate);
        certify_entries(subject, edges, options, certificate);
    }
    certify_closing(subjects, edges, options, certificate);
    certify_moments(subjects.front(), options, certificate);
    certify_clearance_places(subjects, options, certificate);
    const bool is_covered =
        certify_measures(subjects, edges, known ? &*known : nullptr, options, certificate);
    if (is_covered && certificate.holds()) return certificate;
    for (const Subject& subject : subjects) sample(subject, options, certificate);
    return certificate;
}

std::vector<Finding> check_cell(const Cell& cell, const CheckOptions& options) {
    std::vector<Finding> findings;
    for (Element& e : certify(cell, options).elements)
        if (e.verdict != Verdict::proved) findings.push_back({std::move(e.where), std::move(e.what)});
    return findings;
}

}  // namespace vcell
