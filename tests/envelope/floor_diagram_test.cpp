// Diagrams above and below a floor over a cylinder base: any forms make one, and at sampled points what the
// diagram shows is what heights say.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "../../envelope/diagram/minimization_diagram.hpp"
#include "../../primitives/bases/radial_base.hpp"
#include "../../primitives/forms/heights.hpp"
#include "../test_support.hpp"
#include "radial_scenes.hpp"

namespace vcell::radial::floor_diagram_test {
namespace {

using Eigen::Vector2d;

/// What shows at a point, by heights in doubles; none where these are nearly equal.
std::optional<FormId> showing(const Heights& heights, const EnvelopeOptions& options, const Vector2d& p) {
    struct Best {
        FormId form;
        double value = 0, next = 0;  // the best one's value, and the second best one's
    };
    std::optional<Best> least, greatest;
    for (std::uint32_t i = 0; i < heights.family().size(); ++i) {
        const FormId f{i};
        const bool is_of_floor = std::ranges::find(options.floor, f) != options.floor.end();
        const double sign = is_of_floor ? -1 : 1,
                     v = sign * heights.value(f, Interval(p.x()), Interval(p.y())).mid();
        std::optional<Best>& best = is_of_floor ? greatest : least;
        if (!best)
            best = {f, v, HUGE_VAL};
        else if (v < best->value)
            best = {f, v, best->value};
        else
            best->next = std::min(best->next, v);
    }
    constexpr double near = 1e-9;
    const double h = least->value, e = -greatest->value;
    if (std::abs(h - e) < near) return std::nullopt;
    const Best& shown = (h > e) == options.is_below_floor ? *greatest : *least;
    if (shown.next - shown.value < near) return std::nullopt;
    return shown.form;
}

/// The face at a point; none where it is as near to an edge as the boxes of the edge's pieces.
std::optional<FaceId> face_at(const MinimizationDiagram& d, const Vector2d& p) {
    std::vector<int> crossings(d.dcel.face_count(), 0);
    const auto cross = [&](EdgeId e, const Vector2d& from, Vector2d to) {
        while (to.x() - from.x() > 2) to.x() -= 4;
        while (to.x() - from.x() < -2) to.x() += 4;
        for (const double shift : {-4.0, 0.0, 4.0}) {
            const double x = p.x() + shift;
            if ((from.x() <= x) == (to.x() <= x)) continue;
            const double y = from.y() + (x - from.x()) / (to.x() - from.x()) * (to.y() - from.y());
            if (y <= p.y()) continue;
            for (const unsigned side : {0u, 1u}) ++crossings[d.face(e, side).value];
        }
    };
    for (const EdgeId e : d.edges.ids()) {
        const VertexId start = d.start(e);
        if (d.edges[e].on_rim()) {
            if (d.edges[e].side == 0) continue;
            if (!start.valid() || start == d.end(e)) {
                for (const unsigned side : {0u, 1u}) ++crossings[d.face(e, side).value];
                continue;
            }
            double a = d.vertices[start].point.x(), b = d.vertices[d.end(e)].point.x();
            while (b >= a) b -= 4;
            for (const double shift : {-4.0, 0.0, 4.0})
                if (p.x() + shift <= a && p.x() + shift > b)
                    for (const unsigned side : {0u, 1u}) ++crossings[d.face(e, side).value];
            continue;
        }
        const auto pieces = d.pieces(e);
        Vector2d from = start.valid() ? d.vertices[start].point : pieces.back().end;
        for (const auto& piece : pieces) {
            for (const double shift : {-4.0, 0.0, 4.0})
                if (p.x() + shift >= piece.box[0] && p.x() + shift <= piece.box[1] && p.y() >= piece.box[2] &&
                    p.y() <= piece.box[3])
                    return std::nullopt;
            cross(e, from, piece.end);
            from = piece.end;
        }
    }
    std::optional<FaceId> found;
    for (const FaceId f : d.face_forms.ids()) {
        if (!d.face_forms[f].valid() || crossings[f.value] % 2 == 0) continue;
        CHECK_FALSE(found);
        found = f;
    }
    CHECK(found);
    return found;
}

}  // namespace

TEST_CASE("diagram with a floor over a cylinder: shows what heights say, above it and below") {
    std::mt19937_64 rng(test_seed());
    RandomScenes random(rng);
    int asked = 0, of_floor = 0;
    for (int i = 0; i < 8 * rounds(); ++i) {
        Scene s = random.over_cylinder(i % 4 == 0 ? 0 : random.uniform(0.05, 0.4));
        random.add(s, random.count(0, 4), random.count(0, 2), random.count(1, 4));
        const RadialBaseProblem problem = radial_base_problem(s);
        const auto [y0, y1] = problem.stretch;
        EnvelopeOptions options;
        for (std::uint32_t f = 0; f < problem.family.size(); ++f)
            if (random.count(0, 2) == 0) options.floor.push_back(FormId{f});
        if (options.floor.empty() || options.floor.size() == problem.family.size()) continue;
        const Heights heights(problem.family);
        for (const bool is_below : {false, true}) {
            CAPTURE(i);
            CAPTURE(is_below);
            options.is_below_floor = is_below;
            const MinimizationDiagram d = lower_envelope_on_cylinder(problem.family, y0, y1, options);
            CHECK(d.decisions.assumed == 0);
            for (int k = 0; k < 300; ++k) {
                const Vector2d p(random.uniform(-1, 3), random.uniform(y0, y1));
                const auto truth = showing(heights, options, p);
                if (!truth) continue;
                const auto face = face_at(d, p);
                if (!face) continue;
                ++asked;
                of_floor += d.is_of_floor(*truth);
                CAPTURE(p.transpose());
                CHECK(d.face_forms[*face] == *truth);
            }
            // Left is the lower one on the left side, and the faces are as the rule has it.
            for (const EdgeId e : d.edges.ids()) {
                if (d.edges[e].on_rim()) continue;
                for (const unsigned side : {0u, 1u})
                    CHECK(d.face_forms[d.face(e, side)] == d.form_beside(e, side));
                const auto& piece = d.pieces(e).front();
                const double x = piece.end.x(), y = piece.end.y(), step = 1e-6;
                const auto difference = [&](double sign) {
                    const Interval px(x + sign * step * piece.direction.x()),
                        py(y + sign * step * piece.direction.y());
                    return heights.value(d.edges[e].left, px, py).mid() -
                           heights.value(d.edges[e].right, px, py).mid();
                };
                CHECK(difference(1) > difference(-1));
            }
        }
    }
    CHECK(asked > 1000 * rounds());
    CHECK(of_floor > 100 * rounds());
}

}  // namespace vcell::radial::floor_diagram_test
