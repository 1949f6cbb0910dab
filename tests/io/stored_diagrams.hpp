/// Diagrams as files have them, for the tests that judge and damage them.
#pragma once

#include <doctest/doctest.h>

#include <sstream>
#include <string>

#include "../../io/files/stored_diagram.hpp"

namespace vcell {

/// `complete`: with the cells of planes and tubes.
inline std::string text_of(const DiagramScene& scene, bool complete = false) {
    std::ostringstream out;
    DiagramWriter writer(out, scene);
    DiagramOptions options;
    options.complete = complete;
    options.visit = [&](std::uint32_t object, const Cell& cell) { writer.add(object, cell); };
    writer.finish(voronoi_diagram(scene, options));
    return out.str();
}

/// As it is read from its file.
inline StoredDiagram stored(const DiagramScene& scene, bool complete = false) {
    auto diagram = parse_diagram(text_of(scene, complete));
    REQUIRE(diagram);
    return *std::move(diagram);
}

inline void check_proved(const Certificate& certificate) {
    for (const Element& e : certificate.elements) {
        if (e.verdict == Verdict::proved) continue;
        CAPTURE(e.where);
        CAPTURE(e.what);
        CHECK(e.verdict == Verdict::proved);
    }
    REQUIRE(!certificate.elements.empty());
    CHECK(certificate.elements.back().where == "volume");
}

/// Nothing is refuted, and little is open: in scenes that nobody chose one integral in a few hundred takes
/// more parts than the check allows.
inline void check_none_refuted(const Certificate& certificate) {
    constexpr double few = 0.005;
    for (const Element& e : certificate.elements) {
        if (e.verdict == Verdict::proved) continue;
        CAPTURE(e.where);
        CAPTURE(e.what);
        CHECK(e.verdict == Verdict::open);
        CHECK((e.where.ends_with(".area") || e.where.ends_with(".length")));
    }
    CHECK(static_cast<double>(certificate.count(Verdict::open)) <=
          1 + few * static_cast<double>(certificate.elements.size()));
    REQUIRE(!certificate.elements.empty());
    CHECK(certificate.elements.back().where == "volume");
}

/// Is there an element of that name, or one below it, of that verdict?
inline bool has_verdict(const Certificate& certificate, const std::string& where, Verdict verdict) {
    for (const Element& e : certificate.elements)
        if (e.verdict == verdict && e.where.starts_with(where)) return true;
    return false;
}
/// One that is not proved.
inline bool objects_to(const Certificate& certificate, const std::string& where) {
    return has_verdict(certificate, where, Verdict::refuted) ||
           has_verdict(certificate, where, Verdict::open);
}

}  // namespace vcell
