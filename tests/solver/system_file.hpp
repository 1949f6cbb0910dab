/// tests/data/solver_systems.json: systems with answers computed independently. The file's "about"
/// describes its format.
#pragma once

#include <doctest/doctest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "../../core/solver/systems/polynomial.hpp"
#include "../../primitives/bisectors/vertex_roots.hpp"
#include "../test_support.hpp"

namespace vcell::testing {

/// The entries of one kind: "isolated", "positive_dimensional" or "curve".
inline std::vector<nlohmann::json> solver_systems(const std::string& kind) {
    std::ifstream in(test_data("solver_systems.json"));
    std::vector<nlohmann::json> entries;
    nlohmann::json file = nlohmann::json::parse(in);
    for (auto& entry : file.at("systems"))
        if (entry.at("kind") == kind) entries.push_back(std::move(entry));
    if (entries.empty()) throw std::runtime_error("no system of kind " + kind);
    return entries;
}

/// "p" or "p/q", q a power of two.
inline double dyadic(const std::string& text) {
    const auto slash = text.find('/');
    const double p = std::stod(text.substr(0, slash));
    return slash == std::string::npos ? p : p / std::stod(text.substr(slash + 1));
}

template <int N>
IntervalBox<N> box_of(const nlohmann::json& entry) {
    IntervalBox<N> box;
    for (int i = 0; i < N; ++i)
        box[i] = {dyadic(entry.at("box").at(i).at(0)), dyadic(entry.at("box").at(i).at(1))};
    return box;
}

template <int M, int N>
PolynomialSystem<M, N> polynomials_of(const nlohmann::json& entry) {
    PolynomialSystem<M, N> system;
    for (int k = 0; k < M; ++k)
        for (const auto& monomial : entry.at("equations").at(k)) {
            typename Polynomial<N>::Term term{std::stod(monomial.at(0).get<std::string>()), {}};
            for (int i = 0; i < N; ++i) term.exponents[i] = monomial.at(1).at(i).get<std::uint8_t>();
            system.equations[k].terms.push_back(term);
        }
    return system;
}

inline std::array<double, 3> vector_of(const nlohmann::json& v) {
    return {dyadic(v.at(0)), dyadic(v.at(1)), dyadic(v.at(2))};
}

/// The object form of an entry. Pre: it has four objects.
inline VertexSystem vertex_system_of(const nlohmann::json& entry) {
    VertexSystem system;
    for (int k = 0; k < 4; ++k) {
        const auto& o = entry.at("objects").at(k);
        const std::string type = o.at("type");
        if (type == "plane")
            system.sites[k] = PlaneSite{vector_of(o.at("normal")), dyadic(o.at("offset"))};
        else if (type == "sphere")
            system.sites[k] = SphereSite{vector_of(o.at("center")), dyadic(o.at("radius"))};
        else
            system.sites[k] =
                CylinderSite{vector_of(o.at("point")), vector_of(o.at("dir")), dyadic(o.at("radius"))};
    }
    return system;
}

/// Digits to the last one given, 40 of them, as an enclosure.
template <int N>
WideBox<N> point_of(const nlohmann::json& digits) {
    WideBox<N> point;
    for (int i = 0; i < N; ++i) {
        const Wide::Float value(digits.at(i).get<std::string>());
        point[i] = Wide(value, value) + Wide(value, value) * Wide(-1e-39, 1e-39);
    }
    return point;
}

}  // namespace vcell::testing
