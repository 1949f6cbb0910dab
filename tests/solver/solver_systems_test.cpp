#include <doctest/doctest.h>

#include "../../core/solver/roots/solver.hpp"
#include "system_file.hpp"

namespace vcell::solver_systems_test {
using namespace vcell::testing;

namespace {

/// The same equations, without what tells the solver that they are polynomials.
struct Opaque {
    PolynomialSystem<4> polynomials;
    template <class T>
    std::array<T, 4> operator()(const std::array<T, 4>& x) const {
        return polynomials(x);
    }
};

template <class System>
void check_isolated(const System& system, const nlohmann::json& entry, const SolverOptions& options = {}) {
    const IntervalBox<4> box = box_of<4>(entry);
    const auto found = solve(system, box, options);
    const auto& listed = entry.at("solutions");
    if (entry.contains("degenerate")) {
        // A root of higher multiplicity has no proof, but a place.
        CHECK(found.unique.empty());
        REQUIRE(found.undecided.size() == 1);
        CHECK(found.undecided[0].reason == Undecided<4>::Reason::Resolution);
        CHECK(width(found.undecided[0].hull) < 1e-6);
        for (const auto& solution : listed)
            CHECK(overlap(converted<Wide>(found.undecided[0].hull), point_of<4>(solution.at("point"))));
        return;
    }
    CHECK(found.undecided.empty());
    REQUIRE(found.unique.size() == entry.at("count_in_box").get<std::size_t>());
    for (std::size_t i = 0; i < found.unique.size(); ++i) {
        const Root<4>& root = found.unique[i];
        CHECK(width(root.box) <= 1e-8);
        CHECK(is_subset(root.box, root.region));
        CHECK(is_subset(root.box, box));
        CHECK_FALSE(root.on_boundary);
        for (std::size_t j = 0; j < i; ++j) CHECK_FALSE(overlap(root.box, found.unique[j].box));
        // One listed point lies in it, and agrees with the refined root to all its digits.
        const WideBox<4> refined = refine(system, root, 160);
        int inside = 0;
        for (const auto& solution : listed) {
            const WideBox<4> point = point_of<4>(solution.at("point"));
            if (!overlap(converted<Wide>(root.box), point)) continue;
            ++inside;
            CHECK(overlap(refined, point));
        }
        CHECK(inside == 1);
        for (const Wide& side : refined) CHECK(side.radius_exponent() < -155);
    }
}

}  // namespace

TEST_CASE("solver: listed systems, as polynomials, have exactly the listed roots") {
    for (const auto& entry : solver_systems("isolated")) {
        CAPTURE(entry.at("id").get<std::string>());
        check_isolated(polynomials_of<4, 4>(entry), entry);
    }
}

TEST_CASE("solver: listed systems, as callables, have exactly the listed roots") {
    SolverOptions options;
    options.max_boxes = 1'000'000;  // S04: without its quadratic parts, four cylinders take many
    for (const auto& entry : solver_systems("isolated")) {
        CAPTURE(entry.at("id").get<std::string>());
        check_isolated(Opaque{polynomials_of<4, 4>(entry)}, entry, options);
    }
}

TEST_CASE("solver: listed vertices, from their objects, have exactly the listed roots") {
    int vertices = 0;
    for (const auto& entry : solver_systems("isolated")) {
        if (entry.contains("extra_equation")) continue;
        CAPTURE(entry.at("id").get<std::string>());
        check_isolated(vertex_system_of(entry), entry);
        ++vertices;
    }
    CHECK(vertices == 8);
}

TEST_CASE("solver: a curve of roots is covered by undecided boxes within the budget") {
    for (const auto& entry : solver_systems("positive_dimensional")) {
        CAPTURE(entry.at("id").get<std::string>());
        SolverOptions options;
        options.max_boxes = 5'000;
        const auto found = solve(polynomials_of<4, 4>(entry), box_of<4>(entry), options);
        CHECK(found.unique.empty());
        CHECK(found.boxes <= options.max_boxes + 1);
        REQUIRE_FALSE(found.undecided.empty());
        for (const auto& digits : entry.at("sample_points")) {
            const WideBox<4> point = point_of<4>(digits);
            bool covered = false;
            for (const auto& cluster : found.undecided) {
                CHECK(cluster.reason == Undecided<4>::Reason::Budget);
                for (const auto& box : cluster.boxes)
                    covered = covered || overlap(converted<Wide>(box), point);
            }
            CHECK(covered);
        }
    }
}

}  // namespace vcell::solver_systems_test
