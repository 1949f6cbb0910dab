// The judge of diagrams with cylinders: heights by their definition, and objections to every corruption.
#include <doctest/doctest.h>

#include <stdexcept>

#include "../../primitives/forms/cylinder_form.hpp"
#include "../test_support.hpp"
#include "mixed_oracle.hpp"
#include "mixed_scenes.hpp"

namespace vcell::mixed::mixed_oracle_test {

TEST_CASE("mixed oracle: its heights satisfy the definition and the closed form") {
    std::mt19937_64 rng(test_seed());
    RandomScenes random(rng);
    const Scene s = random.mix("", 3, 2, 4, 4);
    const FormFamily family = s.family();
    for (int k = 0; k < 50; ++k) {
        const double x = random.uniform(-2, 2), y = random.uniform(-2, 2);
        for (std::uint32_t i = 0; i < s.size(); ++i) {
            CAPTURE(i);
            const Real r = height<Real>(s.solid(i), x, y).v;
            const Distance<Real> d =
                std::visit([&](const auto& o) { return distance<Real>(o, x, y, r); }, s.solid(i));
            CHECK(abs(d.value - r) <= Real("1e-90"));
            const Real closed = family.is_circular(FormId{i})
                                    ? Real(0)
                                    : cylinder_height<Real>(family.cylinder(FormId{i}), x, y);
            if (!family.is_circular(FormId{i})) CHECK(abs(closed - r) <= Real("1e-85"));
            const double fast = static_cast<double>(height<Fast>(s.solid(i), x, y).v);
            CHECK(fast == doctest::Approx(r.convert_to<double>()).epsilon(1e-15));
            if (family.is_circular(FormId{i}))
                CHECK(family.forms[FormId{i}](x, y) == doctest::Approx(fast).epsilon(1e-13));
        }
    }
}

TEST_CASE("mixed oracle: objects to corrupted diagrams") {
    std::mt19937_64 rng(test_seed());
    Scene s{.name = "to corrupt", .circular = {}, .cylinders = {}};
    s.ball(-1, -0.75, 0.75, 0.25)
        .ball(1, 1, 0.75, 0.125)
        .cylinder(0, 1, 1, 1, 0.25, 0.125, 0.25)
        .cylinder(1, 0, 1, 0.25, 1, 0, 0.375);
    const MinimizationDiagram good = lower_envelope(s.family(), s.region);
    CHECK(check_diagram(s, good, rng).empty());
    const auto objects = [&](const std::string& damage, const auto& corrupt) {
        MinimizationDiagram bad = good;
        corrupt(bad);
        CHECK_MESSAGE(!check_diagram(s, bad, rng).empty(), damage);
    };
    const auto first = [](const auto& ids, const auto& wanted) {
        for (const auto id : ids)
            if (wanted(id)) return id;
        throw std::logic_error("nothing to corrupt");
    };
    const VertexId inner = first(good.vertices.ids(), [&](VertexId v) { return good.sides(v).empty(); });
    const EdgeId curved = first(good.edges.ids(), [&](EdgeId e) { return good.pieces(e).size() > 1; });
    const auto pieces = [&](MinimizationDiagram& d) {
        return d.pieces_.begin() + d.piece_offsets_[curved.value];
    };

    objects("two faces exchange their forms",
            [](auto& d) { std::swap(d.face_forms[{1}], d.face_forms[{2}]); });
    objects("two forms are exchanged everywhere", [&](auto& d) {
        const auto exchange = [&](FormId& f) {
            if (f == good.edges[curved].left)
                f = good.edges[curved].right;
            else if (f == good.edges[curved].right)
                f = good.edges[curved].left;
        };
        for (FormId& f : d.face_forms) exchange(f);
        for (auto& e : d.edges) exchange(e.left), exchange(e.right);
        for (auto* labels : {&d.vertex_labels_, &d.edge_labels_})
            for (FormId& f : *labels) exchange(f);
        const auto sort = [](std::vector<FormId>& labels, const std::vector<std::uint32_t>& offsets) {
            for (std::size_t i = 0; i + 1 < offsets.size(); ++i)
                std::sort(labels.begin() + offsets[i], labels.begin() + offsets[i + 1]);
        };
        sort(d.vertex_labels_, d.vertex_offsets_);
        sort(d.edge_labels_, d.edge_offsets_);
    });
    objects("a vertex without one of its forms", [&](auto& d) {
        d.vertex_labels_.erase(d.vertex_labels_.begin() + d.vertex_offsets_[inner.value]);
        for (std::size_t i = inner.value + 1; i < d.vertex_offsets_.size(); ++i) --d.vertex_offsets_[i];
    });
    objects("a vertex moved", [&](auto& d) { d.vertices[inner].point.x() += 1e-9; });
    objects("a vertex's bound too small",
            [&](auto& d) { d.vertices[inner].point.x() += 4 * d.vertices[inner].error; });
    objects("a height changed", [&](auto& d) { d.vertices[inner].height += 1e-9; });
    objects("an edge turned round", [&](auto& d) { std::swap(d.edges[curved].left, d.edges[curved].right); });
    objects("a rim edge on another side", [](auto& d) {
        for (auto& e : d.edges)
            if (e.on_rim()) {
                e.side = (e.side + 1) % 4;
                return;
            }
    });
    objects("a piece's end off the curve", [&](auto& d) { pieces(d)->end += 1e-6 * pieces(d)->direction; });
    objects("a piece's direction turned round", [&](auto& d) { pieces(d)->direction *= -1; });
    objects("a piece's direction along the curve", [&](auto& d) {
        pieces(d)->direction = pieces(d)->end - good.vertices[good.start(curved)].point;
    });
    objects("a piece's box too small", [&](auto& d) {
        pieces(d)->box[1] = pieces(d)->box[0];
        pieces(d)->box[3] = pieces(d)->box[2];
    });
    objects("an edge without its last piece", [&](auto& d) {
        d.pieces_.erase(d.pieces_.begin() + d.piece_offsets_[curved.value + 1] - 1);
        for (std::size_t i = curved.value + 1; i < d.piece_offsets_.size(); ++i) --d.piece_offsets_[i];
    });
}

}  // namespace vcell::mixed::mixed_oracle_test
