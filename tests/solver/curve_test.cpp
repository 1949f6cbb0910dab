#include <doctest/doctest.h>

#include <random>

#include "../../primitives/forms/cylinder_form.hpp"
#include "curve_check.hpp"
#include "system_file.hpp"

using namespace vcell;
using namespace vcell::testing;

namespace {

IntervalBox<2> rectangle(double x0, double x1, double y0, double y1) {
    return {Interval(x0, x1), Interval(y0, y1)};
}

struct Count {
    std::size_t closed = 0, open = 0;
    friend bool operator==(const Count&, const Count&) = default;
};
template <int D>
Count count(const CurveSet<D>& set) {
    Count c;
    for (const auto& component : set.components) ++(component.closed ? c.closed : c.open);
    return c;
}

// Solves, checks the promises, and returns the result.
template <int N>
CurveSet<N + 1> checked(const CurveSystem<N>& f, const IntervalBox<N + 1>& box,
                        const CurveOptions& options = {}) {
    CurveSet<N + 1> set = solve_curves<N>(f, box, options);
    const auto defect = find_defect<N>(f, box, set);
    CHECK_MESSAGE(!defect, defect.value_or(""));
    return set;
}

template <class T>
T chebyshev(int n, const T& x) {
    T before(1.0), at = x;
    for (int k = 1; k < n; ++k) {
        const T next = T(2.0) * x * at - before;
        before = at;
        at = next;
    }
    return at;
}

const CurveSystem<1> unit_circle([](const auto& p) { return std::array{square(p[0]) + square(p[1]) - 1.0}; });

// The length of the curves in their first coordinates (x, y, z): of chords, whose error is of the second
// order, extrapolated.
template <int N>
double arc_length(const CurveSystem<N>& f, const CurveSet<N + 1>& set) {
    double length = 0;
    for (const auto& component : set.components)
        for (const Tube<N + 1>& tube : component.tubes) {
            const auto chords = [&](int parts) {
                double sum = 0;
                auto from = mid(point_at<N>(f, tube, tube.begin));
                for (int k = 1; k <= parts; ++k) {
                    const auto to =
                        mid(point_at<N>(f, tube, std::lerp(tube.begin, tube.end, k / double(parts))));
                    double squares = 0;
                    for (int i = 0; i < std::min(N + 1, 3); ++i)
                        squares += (to[i] - from[i]) * (to[i] - from[i]);
                    sum += std::sqrt(squares);
                    from = to;
                }
                return sum;
            };
            length += (4 * chords(16) - chords(8)) / 3;
        }
    return length;
}

// An entry of kind "curve" of the system file, against all that it says.
template <int N>
void check_entry(const nlohmann::json& entry) {
    constexpr int D = N + 1;
    const CurveSystem<N> f(polynomials_of<N, D>(entry));
    const IntervalBox<D> box = box_of<D>(entry);
    const CurveSet<D> set = checked<N>(f, box);
    const bool singular = entry.contains("singular_points");
    CHECK(set.complete() == !singular);

    if (!singular) {
        Count expected;
        for (const auto& info : entry.at("component_info"))
            ++(info.at("closed") ? expected.closed : expected.open);
        CHECK(count(set) == expected);
    }
    std::size_t faces = 0;
    for (const auto& component : set.components)
        if (!component.closed)
            for (const CurveEnd& end : component.ends) faces += end.kind == CurveEnd::Kind::Face;
    CHECK(faces == entry.at("boundary_points").size());

    if (const char* key = N == 1 ? "arc_length" : "arc_length_xyz"; entry.contains(key))
        CHECK(arc_length<N>(f, set) ==
              doctest::Approx(std::stod(entry.at(key).get<std::string>())).epsilon(1e-6));

    const auto approximation = [](const nlohmann::json& digits) {
        Point<D> x;
        for (int i = 0; i < D; ++i) x[i] = dyadic(digits.at(i));
        return x;
    };
    for (const auto& p : entry.at("boundary_points")) {
        const Point<D> x = approximation(p.at("point"));
        bool is_end = false;
        for (const auto& c : set.components)
            is_end = is_end || (!c.closed && (distance(mid(c.joints.front()), x) < 1e-9 ||
                                              distance(mid(c.joints.back()), x) < 1e-9));
        CHECK(is_end);
    }
    if (entry.contains("x_extreme_points"))
        for (const auto& p : entry.at("x_extreme_points")) {
            // dx = 0 there: a point of the curve with the x of rounded digits is off by the root of the
            // rounding.
            if constexpr (N == 1)
                CHECK(covers<N>(f, set, {dyadic(p.at(0)), dyadic(p.at(1))}, 1e-6));
            else
                CHECK(covers<N>(f, set, approximation(p), 1e-6));
        }
    if (entry.contains("fibers"))
        for (const auto& entry_fibre : entry.at("fibers")) {
            const auto points = fibre<N>(f, set, 0, dyadic(entry_fibre.at("x")));
            CHECK(points.size() == entry_fibre.at("points").size());
            for (const auto& digits : entry_fibre.at("points")) {
                const Point<D> x = approximation(digits);
                CHECK(std::any_of(points.begin(), points.end(),
                                  [&](const auto& p) { return distance(p, x) < 1e-9; }));
            }
        }
}

}  // namespace

TEST_CASE("curves: every component, end, extreme point and fibre of the system file") {
    for (const auto& entry : solver_systems("curve")) {
        const std::string id = entry.at("id");
        CAPTURE(id);
        if (entry.at("variables").size() == 2)
            check_entry<1>(entry);
        else
            check_entry<3>(entry);
    }
}

TEST_CASE("curves: a singular trisector is four arcs that lead into one cluster around its node") {
    for (const auto& entry : solver_systems("curve")) {
        if (!entry.contains("singular_points")) continue;
        const CurveSet<4> set = checked<3>(CurveSystem<3>(polynomials_of<3, 4>(entry)), box_of<4>(entry));
        REQUIRE(set.undecided.size() == 1);
        CHECK(overlap(converted<Interval>(point_of<4>({"0", "0", "1.5", "1.5"})), set.undecided[0].box));
        CHECK(width(set.undecided[0].box) < 1e-5);
        CHECK(set.undecided[0].branches.size() == 4);
        CHECK(count(set) == Count{0, 4});
        for (const auto& component : set.components)
            CHECK(component.ends[0].kind != component.ends[1].kind);  // from a face to the node
    }
}

TEST_CASE("curves: smooth plane curves of known topology") {
    const auto cassini = [](double b) {
        return CurveSystem<1>([b](const auto& p) {
            return std::array{square(square(p[0]) + square(p[1])) - 2.0 * (square(p[0]) - square(p[1])) -
                              (b * b * b * b - 1.0)};
        });
    };
    const IntervalBox<2> box = rectangle(-3, 3.5, -3, 3.25);
    CHECK(count(checked<1>(cassini(0.9), box)) == Count{2, 0});
    CHECK(count(checked<1>(cassini(0.99999), box)) == Count{2, 0});
    CHECK(count(checked<1>(cassini(1.00001), box)) == Count{1, 0});
    CHECK(count(checked<1>(cassini(1.5), box)) == Count{1, 0});

    const CurveSystem<1> fermat(
        [](const auto& p) { return std::array{square(square(p[0])) + square(square(p[1])) - 1.0}; });
    CHECK(count(checked<1>(fermat, box)) == Count{1, 0});

    // Ovals one in another, 0.02 apart.
    const CurveSystem<1> nested([](const auto& p) {
        const auto r = square(p[0]) + square(p[1]);
        return std::array{(r - 1.0) * (r - 1.0404) * (r - 4.0)};
    });
    CHECK(count(checked<1>(nested, box)) == Count{3, 0});

    // An oval of radius 1e-4 in a corner that nothing points to.
    const CurveSystem<1> tiny(
        [](const auto& p) { return std::array{square(p[0] - 2.71) + square(p[1] - 2.93) - 1e-8}; });
    CHECK(count(checked<1>(tiny, box)) == Count{1, 0});

    // Cut by the box into four arcs.
    CHECK(count(checked<1>(
              CurveSystem<1>([](const auto& p) { return std::array{square(p[0]) + square(p[1]) - 1.5}; }),
              rectangle(-1, 1, -1.1, 1.05))) == Count{0, 4});
    // A hyperbola close to its asymptotes.
    CHECK(count(checked<1>(CurveSystem<1>([](const auto& p) { return std::array{p[0] * p[1] - 1e-6}; }),
                           rectangle(-1, 1, -1, 1))) == Count{0, 2});
}

TEST_CASE("curves: lines along the coordinates") {
    for (const int i : {0, 1}) {
        const CurveSystem<1> line([i](const auto& p) { return std::array{p[i] - 0.3125}; });
        const CurveSet<2> set = checked<1>(line, rectangle(-1, 1, -2, 2));
        CHECK(set.complete());
        REQUIRE(count(set) == Count{0, 1});
        const auto& ends = set.components[0].ends;
        CHECK(ends[0].index + ends[1].index == (i == 0 ? 5u : 1u));  // faces 2 and 3, or 0 and 1
    }
    // Half of a circle in the plane x = 1/4 of space, with a tangent in every direction but x.
    const CurveSystem<2> arc([](const auto& p) {
        return std::array{p[0] - 0.25, square(p[1]) + square(p[2]) - 1.0};
    });
    const CurveSet<3> set = checked<2>(arc, {Interval(-1, 1), Interval(-2, 2), Interval(0, 2)});
    CHECK(set.complete());
    CHECK(count(set) == Count{0, 1});
}

TEST_CASE("curves: empty systems have none") {
    const IntervalBox<2> box = rectangle(-3, 3, -3, 3);
    for (const double c : {1.0, 1e-6}) {
        const CurveSystem<1> f([c](const auto& p) { return std::array{square(p[0]) + square(p[1]) + c}; });
        const CurveSet<2> set = checked<1>(f, box);
        CHECK(set.components.empty());
        CHECK(set.complete());
    }
    CHECK(checked<1>(unit_circle, rectangle(1.5, 3, -1, 1)).components.empty());
    CHECK(checked<1>(unit_circle, rectangle(-0.5, 0.5, -0.5, 0.5)).components.empty());
}

TEST_CASE("curves: a node, a cusp and an isolated point are clusters with the branches that enter") {
    const IntervalBox<2> box = rectangle(-3, 3.5, -3, 3.25);
    const auto node_at_origin = [&](const CurveSet<2>& set, std::size_t branches) {
        REQUIRE(set.undecided.size() == 1);
        CHECK(contains(set.undecided[0].box, Point<2>{0, 0}));
        CHECK(width(set.undecided[0].box) < 1e-4);
        CHECK(set.undecided[0].branches.size() == branches);
    };
    const CurveSystem<1> lemniscate([](const auto& p) {
        return std::array{square(square(p[0]) + square(p[1])) - 2.0 * (square(p[0]) - square(p[1]))};
    });
    CurveSet<2> set = checked<1>(lemniscate, box);
    node_at_origin(set, 4);
    CHECK(count(set) == Count{0, 2});

    const CurveSystem<1> folium([](const auto& p) {
        return std::array{p[0] * square(p[0]) + p[1] * square(p[1]) - 3.0 * p[0] * p[1]};
    });
    set = checked<1>(folium, box);
    node_at_origin(set, 4);
    CHECK(count(set) == Count{0, 3});

    set = checked<1>(
        CurveSystem<1>([](const auto& p) { return std::array{square(p[1]) - p[0] * square(p[0])}; }), box);
    node_at_origin(set, 2);
    CHECK(count(set) == Count{0, 2});

    set = checked<1>(CurveSystem<1>([](const auto& p) { return std::array{square(p[0]) + square(p[1])}; }),
                     box);
    node_at_origin(set, 0);
    CHECK(set.components.empty());
}

TEST_CASE("curves: touching a face, or leaving through a corner, is undecided there and nowhere else") {
    const CurveSet<2> touching = checked<1>(unit_circle, rectangle(-1, 1, -2, 2));
    REQUIRE(touching.undecided.size() == 2);
    for (const auto& cluster : touching.undecided) {
        CHECK((contains(cluster.box, Point<2>{-1, 0}) || contains(cluster.box, Point<2>{1, 0})));
        CHECK(cluster.branches.size() == 2);
    }
    CHECK(count(touching) == Count{0, 2});

    const CurveSystem<1> diagonal([](const auto& p) { return std::array{p[0] - p[1]}; });
    const CurveSet<2> corners = checked<1>(diagonal, rectangle(0, 1, 0, 1));
    CHECK(corners.undecided.size() == 2);
    CHECK(count(corners) == Count{0, 1});
}

TEST_CASE("curves: a double curve exhausts the budget and is returned undecided") {
    const CurveSystem<1> f(
        [](const auto& p) { return std::array{square(square(p[0]) + square(p[1]) - 1.0)}; });
    CurveOptions options;
    options.max_parts = 2000;
    const CurveSet<2> set = checked<1>(f, rectangle(-2, 2, -2, 2), options);
    CHECK(!set.complete());
    for (int i = 0; i < 50; ++i) CHECK(covers<1>(f, set, {std::cos(i), std::sin(i)}, 1e-12));
}

TEST_CASE("curves: many components, each found") {
    // T_8(x) + T_8(y) = c: the ovals around the extrema of one kind, those at the rim cut open.
    for (const double c : {0.3, -0.7, 1.4}) {
        const auto g = [c](const auto& x, const auto& y) { return chebyshev(8, x) + chebyshev(8, y) - c; };
        const CurveSystem<1> f([&](const auto& p) { return std::array{g(p[0], p[1])}; });
        const IntervalBox<2> box = rectangle(-1, 1, -1, 1);
        const CurveSet<2> set = checked<1>(f, box);
        const SignGrid grid(g, box, 800);
        CHECK(set.complete());
        CHECK(grid.regions() == int(1 + set.components.size()));
        CHECK(grid.boundary_changes() == int(2 * count(set).open));
    }
}

namespace {

// Heights over the base z = 0, generic in the number type.
struct Cylinder {
    CylinderForm form;
    template <class T>
    T operator()(const T& x, const T& y) const {
        const auto [C, beta] = cylinder_terms(form, x, y);
        return C / (beta + sqrt(square(beta) + T(form.az * form.az) * C));
    }
};
struct Sphere {
    double x, y, z, rho;
    template <class T>
    T operator()(const T& px, const T& py) const {
        return (square(px - x) + square(py - y) + T(z) * T(z) - T(rho) * T(rho)) / (T(2.0) * (T(z) + T(rho)));
    }
};

// Lengths of coordinates in [-10, 10]^2; axes tilted so little that they meet the base outside.
class Scenes {
public:
    explicit Scenes(std::uint64_t seed) : rng_(seed) {}
    double number(double lo, double hi) { return std::uniform_real_distribution(lo, hi)(rng_); }
    Cylinder cylinder() {
        // In 1/64, so that az * az is exact.
        const double az = std::round(number(-12, 12)) / 64;
        return {
            {number(-8, 8), number(-8, 8), number(6, 12), number(-1, 1), number(0.5, 1), az, number(0.3, 2)}};
    }
    Sphere sphere() { return {number(-8, 8), number(-8, 8), number(2.5, 12), number(0.3, 2)}; }
    static IntervalBox<2> region() { return {Interval(-10, 10), Interval(-10, 10)}; }

private:
    std::mt19937_64 rng_;
};

// Is the cylinder away from the base all over the region?
bool clear_of_base(const Cylinder& c) {
    for (int i = 0; i <= 40; ++i)
        for (int j = 0; j <= 40; ++j)
            if (cylinder_terms(c.form, -10 + 0.5 * i, -10 + 0.5 * j)[0] < 0.1) return false;
    return true;
}

// Compares a trisector's topology with the signs on grids, where grids of two sizes agree.
template <class G>
bool agrees_with_grid(const G& g, const CurveSet<2>& set) {
    const SignGrid coarse(g, Scenes::region(), 250), fine(g, Scenes::region(), 601);
    if (coarse.regions() != fine.regions() || coarse.boundary_changes() != fine.boundary_changes())
        return false;
    CHECK(fine.regions() == int(1 + set.components.size()));
    CHECK(fine.boundary_changes() == int(2 * count(set).open));
    return true;
}

}  // namespace

TEST_CASE("curves: trisectors in the chart have the topology of the signs on a dense grid") {
    Scenes scenes(test_seed());
    int compared = 0, drawn = 0;
    while (drawn < 60) {
        const Cylinder a = scenes.cylinder(), b = scenes.cylinder();
        const Sphere s = scenes.sphere();
        if (!clear_of_base(a) || !clear_of_base(b)) continue;
        CAPTURE(drawn);
        const auto examine = [&](const auto& g) {
            const CurveSystem<1> f([&](const auto& p) { return std::array{g(p[0], p[1])}; });
            const CurveSet<2> set = checked<1>(f, Scenes::region());
            CHECK(set.complete());
            compared += agrees_with_grid(g, set);
            ++drawn;
        };
        examine([&](const auto& x, const auto& y) { return a(x, y) - s(x, y); });
        examine([&](const auto& x, const auto& y) { return a(x, y) - b(x, y); });
    }
    CHECK(compared > 0.9 * drawn);
}

TEST_CASE("curves: trisectors in x, y, z, r are those of the chart") {
    Scenes scenes(test_seed());
    for (int drawn = 0; drawn < 6;) {
        const Cylinder a = scenes.cylinder();
        const Sphere s = scenes.sphere();
        if (!clear_of_base(a)) continue;
        ++drawn;
        const CurveSystem<1> chart([&](const auto& p) { return std::array{a(p[0], p[1]) - s(p[0], p[1])}; });
        const CurveSystem<3> space([&](const auto& p) {
            const auto& [x, y, z, r] = p;
            using T = std::decay_t<decltype(x)>;
            const T mx = x - a.form.px, my = y - a.form.py, mz = z - a.form.pz;
            const T ax(a.form.ax), ay(a.form.ay), az(a.form.az);
            const T norm = ax * ax + ay * ay + az * az;
            return std::array{z - r, square(x - s.x) + square(y - s.y) + square(z - s.z) - square(r + s.rho),
                              norm * (square(mx) + square(my) + square(mz) - square(r + a.form.rho)) -
                                  square(ax * mx + ay * my + az * mz)};
        });
        const CurveSet<2> plane_curves = checked<1>(chart, Scenes::region());
        // Heights over the region stay below 100.
        const CurveSet<4> space_curves =
            checked<3>(space, {Interval(-10, 10), Interval(-10, 10), Interval(0, 128), Interval(0, 128)});
        CHECK(plane_curves.complete());
        CHECK(space_curves.complete());
        CHECK(count(plane_curves) == count(space_curves));
        for (const auto& c : space_curves.components)
            for (const auto& joint : c.joints) {
                const Point<4> x = mid(joint);
                CHECK(covers<1>(chart, plane_curves, {x[0], x[1]}, 1e-7));
            }
    }
}

TEST_CASE("curves: points to any number of bits") {
    const CurveSet<2> set = checked<1>(unit_circle, rectangle(-2, 2, -2, 2));
    for (const Tube<2>& tube : set.components.at(0).tubes) {
        const double t = std::midpoint(tube.begin, tube.end);
        const WideBox<2> p = point_at<1>(unit_circle, tube, Wide(t), 250);
        const Wide expected = sqrt(Wide(1.0) - square(Wide(t)));
        const Wide found = p[1 - tube.axis].lower() > 0 ? p[1 - tube.axis] : -p[1 - tube.axis];
        CHECK(overlap(std::array{found}, std::array{expected}));
        CHECK(found.radius_exponent() < -240);
    }
}

TEST_CASE("curves: the checker notices corrupted results") {
    const CurveSystem<1> f([](const auto& p) { return std::array{square(p[0]) + 2.0 * square(p[1]) - 1.5}; });
    const IntervalBox<2> box = rectangle(-1, 2, -1, 1);
    const CurveSet<2> good = checked<1>(f, box);
    REQUIRE(good.components.size() == 1);
    REQUIRE(!good.components[0].closed);
    const auto corrupted = [&](const auto& change) {
        CurveSet<2> bad = good;
        change(bad, bad.components[0]);
        return find_defect<1>(f, box, bad).has_value();
    };
    CHECK(corrupted([](auto&, auto& c) { c.closed = true; }));
    CHECK(corrupted([](auto&, auto& c) { c.ends[0].index ^= 1; }));
    CHECK(corrupted([](auto&, auto& c) { c.ends[1] = {CurveEnd::Kind::Cluster, 0}; }));
    CHECK(corrupted([](auto&, auto& c) { c.tubes.erase(c.tubes.begin() + 2); }));
    CHECK(corrupted(
        [](auto&, auto& c) { c.tubes.erase(c.tubes.begin() + 2), c.joints.erase(c.joints.begin() + 2); }));
    CHECK(corrupted([](auto&, auto& c) { std::swap(c.tubes[1], c.tubes[3]); }));
    CHECK(corrupted([](auto&, auto& c) { std::swap(c.tubes[2].begin, c.tubes[2].end); }));
    CHECK(corrupted([](auto&, auto& c) {
        for (Interval& side : c.tubes[2].enclosure) side += Interval(0.5);
    }));
    CHECK(corrupted([](auto&, auto& c) {
        for (Interval& side : c.joints[2]) side += Interval(1e-9);
    }));
    // One arc given out twice.
    CHECK(
        corrupted([](auto& set, auto&) { set.components.push_back(CurveComponent<2>(set.components[0])); }));
    // What is lacking shows against points of the curve.
    CurveSet<2> bad = good;
    bad.components.clear();
    CHECK(covers<1>(f, good, {std::sqrt(1.5), 0}, 1e-7));
    CHECK(!covers<1>(f, bad, {std::sqrt(1.5), 0}, 1e-7));
}
