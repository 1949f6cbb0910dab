/// Diagrams over sphere and cylinder bases as the tests ask for them: computed, judged by brute force, and
/// reduced to what can be compared.
#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <cstdio>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "../test_support.hpp"
#include "complaints.hpp"
#include "radial_oracle.hpp"
#include "radial_scenes.hpp"

namespace vcell::radial {

struct Answer {
    RadialBaseProblem problem;
    MinimizationDiagram diagram;
};

inline Answer answer(const Scene& scene, const EnvelopeOptions& options = {}) {
    validate(scene);
    Answer a{radial_base_problem(scene), {}};
    const auto [low, high] = a.problem.stretch;
    a.diagram = a.problem.chart.is_sphere()
                    ? lower_envelope_on_sphere(a.problem.family, options)
                    : lower_envelope_on_cylinder(a.problem.family, low, high, options);
    return a;
}

inline std::string in_words(const Scene& s) {
    std::string text;
    const auto vector = [](const Vec3& p) {
        char line[100];
        std::snprintf(line, sizeof line, "%.17g, %.17g, %.17g", p.x(), p.y(), p.z());
        return "[" + std::string(line) + "]";
    };
    const auto number = [](double r) {
        char line[40];
        std::snprintf(line, sizeof line, "%.17g", r);
        return std::string(line);
    };
    const auto object = [&](const Object& o) {
        if (const auto* b = std::get_if<Sphere>(&o))
            return R"({"sphere": {"center": )" + vector(b->center) + R"(, "radius": )" + number(b->radius) +
                   "}}";
        if (const auto* p = std::get_if<Plane>(&o))
            return R"({"plane": {"point": )" + vector(p->point) + R"(, "normal": )" + vector(p->normal) +
                   "}}";
        const auto& c = std::get<Cylinder>(o);
        return R"({"cylinder": {"point": )" + vector(c.point) + R"(, "axis": )" + vector(c.axis) +
               R"(, "radius": )" + number(c.radius) + "}}";
    };
    text = R"({"vcell": 1, "base": )" + object(s.base) + R"(, "objects": [)";
    for (const Object& o : s.objects) text += (&o == s.objects.data() ? "" : ", ") + object(o);
    return text + R"(], "box": {"min": )" + vector(s.box.min) + R"(, "max": )" + vector(s.box.max) + "}}";
}

/// The scene's diagram, after it was judged.
inline Answer judge(const Scene& scene, std::mt19937_64& rng, const Options& options = {},
                    const EnvelopeOptions& how = {}) {
    CAPTURE(in_words(scene));
    Answer a;
    std::vector<std::string> complaints{"no diagram"};
    CHECK_NOTHROW(
        (a = answer(scene, how), complaints = Judge(scene, a.problem, a.diagram).check(rng, options)));
    CHECK_MESSAGE(complaints.empty(), join(complaints));
    CHECK(a.diagram.assumptions.size() == a.diagram.decisions.assumed);
    return a;
}

/// Labels of vertices, in the order of their forms around them, of edges and of faces.
inline std::multiset<std::vector<FormId>> labels_of(const MinimizationDiagram& d) {
    std::multiset<std::vector<FormId>> out;
    for (const VertexId v : d.vertices.ids()) {
        std::vector<FormId> around;
        const HalfEdgeId start = d.dcel.outgoing(v);
        HalfEdgeId h = start;
        do {
            around.push_back(d.face_forms[d.dcel.face(h)]);
            h = d.dcel.next_around_origin(h);
        } while (h != start);
        std::ranges::rotate(around, std::ranges::min_element(around));
        around.push_back({});
        out.insert(around);
    }
    for (const EdgeId e : d.edges.ids()) out.insert({d.label(e).begin(), d.label(e).end()});
    for (const FormId f : d.face_forms) out.insert({f});
    return out;
}

}  // namespace vcell::radial
