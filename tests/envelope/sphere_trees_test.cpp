#include <doctest/doctest.h>

#include <random>
#include <set>

#include "../../envelope/sphere/sphere_trees.hpp"
#include "../test_support.hpp"

namespace vcell::sphere_trees_test {
using namespace vcell::discs;

namespace {

class Random {
public:
    explicit Random(std::uint64_t seed) : rng_(seed) {}
    double uniform(double a, double b) { return std::uniform_real_distribution<double>(a, b)(rng_); }
    Vector3d direction() {
        while (true) {
            const Vector3d p(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1));
            if (p.norm() > 0.1 && p.norm() < 1) return p.normalized();
        }
    }
    Linear form(double least_slope) {
        return Linear(uniform(least_slope, 1) * direction(), uniform(-0.1, 0.1), 1e-15);
    }

private:
    std::mt19937_64 rng_;
};

}  // namespace

TEST_CASE("vertex tree: finds the vertices that are not below a form, also after others were removed") {
    Random random(test_seed());
    VertexTree tree;
    std::vector<Mark> marks;
    std::set<Index> listed;
    for (int round = 0; round < 40; ++round) {
        for (int i = 0; i < 50; ++i) {
            Mark m;
            m.p = random.direction();
            if (round % 2 == 0) m.p = (m.p + Vector3d(0, 0, 5)).normalized();  // many in few leaves
            m.height = random.uniform(-1, 0.2);
            m.doubt = m.error = 1e-14;
            m.set_level(1);
            marks.push_back(m);
            tree.add(static_cast<Index>(marks.size() - 1), marks);
            listed.insert(static_cast<Index>(marks.size() - 1));
        }
        for (int i = 0; i < 20; ++i) {
            auto v = listed.lower_bound(static_cast<Index>(random.uniform(0, marks.size())));
            if (v == listed.end()) continue;
            tree.remove(*v);
            tree.remove(*v);  // what is not listed stays so
            listed.erase(v);
        }
        for (int i = 0; i < 20; ++i) {
            const Linear form = random.form(0);
            std::set<Index> expected, found;
            for (const Index v : listed)
                if (!marks[v].is_below(form)) expected.insert(v);
            CHECK(tree.search(form, marks, [&](Index v) { return found.insert(v).second; }));
            CHECK(found == expected);
            if (!expected.empty()) CHECK_FALSE(tree.search(form, marks, [](Index) { return false; }));
        }
    }
}

TEST_CASE("face tree: finds all faces in whose balls a form may be lower") {
    Random random(test_seed());
    FaceTree tree;
    struct Face {
        BoundingBall ball;
        double top;
        bool is_alive = true;
    };
    std::vector<Face> faces;
    for (int round = 0; round < long_rounds(30); ++round) {
        for (int i = 0; i < 30; ++i) {
            const double radius = random.uniform(0.01, 0.3);
            faces.push_back(
                {{std::sqrt(1 - radius * radius) * random.direction(), radius}, random.uniform(-1, 0)});
            tree.add(static_cast<Index>(faces.size() - 1), faces.back().ball, faces.back().top);
        }
        for (Face& f : faces) {
            if (random.uniform(0, 1) < 0.02) f.is_alive = false;
            if (random.uniform(0, 1) < 0.1) f.top -= 0.1;  // faces shrink
        }
        for (int i = 0; i < 20; ++i) {
            const Linear form = random.form(0.5);
            std::set<Index> found;
            tree.search(
                form, [&](Index f) { return faces[f].is_alive ? &faces[f].ball : nullptr; },
                [&](Index f) { return faces[f].top; }, [&](Index f) { found.insert(f); });
            for (Index f = 0; f < faces.size(); ++f) {
                if (!faces[f].is_alive) continue;
                Cap cap;
                cap.shrink_to(faces[f].ball);
                // Tried in places of the cap.
                for (int k = 0; k < 20; ++k) {
                    const Vector3d p = (cap.direction + cap.sine * random.direction()).normalized();
                    if (p.dot(cap.direction) > cap.cosine && form(p) < faces[f].top - 1e-9)
                        CHECK_MESSAGE(found.count(f) == 1, "face ", f);
                }
            }
        }
    }
}

TEST_CASE("mark rows: what is not below a form is found, and little else, at all scales and one ulp apart") {
    Random random(test_seed());
    for (const double scale : {1.0, 0x1p-100, 0x1p-140, 0x1p-300, 0x1p120, 0x1p300}) {
        CAPTURE(scale);
        MarkRows rows;
        std::vector<Mark> marks;
        const auto is_listed = [&](Index i) { return i % 7 != 3 || i == 3; };
        const Linear level = random.form(0.5);
        for (Index i = 0; i < 400; ++i) {
            Mark m;
            m.p = random.uniform(0.1, 2) * random.direction();
            m.height = scale * (i % 2 == 0 ? level(m.p) : random.uniform(-3, 3));
            m.doubt = i % 5 == 0 ? 0 : scale * 1e-14;
            m.set_level(scale);
            if (i % 50 == 49) m.doubt = m.level = HUGE_VAL;
            if (i % 4 == 2) m.level = std::nextafter(m.level, random.uniform(-1, 1) * HUGE_VAL);
            marks.push_back(m);
            rows.set(i, m);
        }
        for (Index i = 0; i < 400; ++i)
            if (!is_listed(i)) rows.remove(i);
        rows.remove(1000);  // what was never set stays so
        for (int i = 0; i < 50; ++i) {
            const Linear f = i % 2 == 0 ? level : random.form(0);
            const Linear form(scale * f.b, scale * (f.e + (i % 3 == 0 ? 1e-9 : 0)), scale * f.error);
            std::set<Index> found;
            CHECK(rows.search(form, [&](Index k) { return found.insert(k).second; }));
            for (Index k = 0; k < marks.size(); ++k) {
                CAPTURE(k);
                if (is_listed(k) && !(form(marks[k].p) - 2 * form.error > marks[k].level))
                    CHECK(found.count(k) == 1);
                if (scale == 1 && form(marks[k].p) > marks[k].level + 1e-4) CHECK(found.count(k) == 0);
                if (!is_listed(k)) CHECK(found.count(k) == 0);
            }
            if (!found.empty()) CHECK_FALSE(rows.search(form, [](Index) { return false; }));
        }
    }
}

}  // namespace vcell::sphere_trees_test
