#include "settled_vertices.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "../../core/numbers/exact.hpp"
#include "../../core/numbers/interval.hpp"
#include "../../core/solver/newton/kantorovich.hpp"
#include "../../core/threads.hpp"
#include "chart_arc.hpp"

namespace vcell {

namespace {

using Eigen::Vector2d;

// Is such an error next to nothing against the numbers themselves, also where it is lifted, which takes it
// times the steepest slope: of the place and the height? Any larger one is worth exact residuals.
constexpr double enough_digits = 0x1p-33;
bool is_point_settled(const MinimizationDiagram::Vertex& v, double error, double slope) {
    const double size = std::abs(v.point.x()) + std::abs(v.point.y());
    return error <= enough_digits * size &&
           error * slope <= enough_digits * std::max(size, std::abs(v.height));
}
bool is_height_settled(const MinimizationDiagram::Vertex& v) {
    return v.height_error <= enough_digits * std::abs(v.height);
}

// K |p|^2 + A x + B y + C, a positive multiple of f - g or of a side of the region.
struct Curve {
    Exact K, A, B, C;
};

// The curve about a point, times a power of two.
struct CurveJet {
    Interval v, gx, gy, K;
};

CurveJet jet(const Curve& c, const Vector2d& p) {
    const Exact x(p.x()), y(p.y()), two(2.0);
    const Exact v = c.K * (x * x + y * y) + c.A * x + c.B * y + c.C, gx = two * c.K * x + c.A,
                gy = two * c.K * y + c.B;
    long size = std::numeric_limits<long>::min();
    for (const Exact* g : {&gx, &gy})
        if (g->sign() != Sign::Zero) size = std::max(size, g->exponent());
    if (size == std::numeric_limits<long>::min()) return {Interval::whole(), 0.0, 0.0, 0.0};
    const auto scaled = [size](const Exact& a) { return a.scaled(-size).enclosure(); };
    return {scaled(v), scaled(gx), scaled(gy), scaled(c.K)};
}

// The point in which two curves meet, by Newton's method; and Newton-Kantorovich as of circles
// (arrangement/circles/circle_kernel.cpp), with residuals and gradients that carry no rounding: eta >= |J^-1
// F(p)|, omega >= 2 |J^-1 (K1, K2)^T|. The point is the true one, which lies within `error` of where p was:
// no other lies within 1 / omega.
struct Meeting {
    Vector2d point;
    double error;
};
std::optional<Meeting> meeting(const Curve& c, const Curve& d, const Vector2d& start, double error) {
    constexpr int most_steps = 8;
    std::optional<Meeting> best;
    Vector2d p = start;
    for (int i = 0; i < most_steps; ++i) {
        const CurveJet a = jet(c, p), b = jet(d, p);
        const Interval det = a.gx * b.gy - a.gy * b.gx;
        if (det.contains(0)) return best;
        const Interval dx = (b.gy * a.v - a.gy * b.v) / det, dy = (a.gx * b.v - b.gx * a.v) / det;
        const Interval kx = (b.gy * a.K - a.gy * b.K) / det, ky = (a.gx * b.K - b.gx * a.K) / det;
        const double eta = sqrt(square(dx) + square(dy)).upper(),
                     omega = (2 * sqrt(square(kx) + square(ky))).upper();
        const double reach = Interval::up((p - start).norm() * (1 + 0x1p-50) + error);
        const auto radius = kantorovich_radius(eta, omega);
        if (radius && omega * reach < 1 - 0x1p-50 && *radius < (best ? best->error : error))
            best = {p, *radius};
        else if (best)
            break;
        p -= Vector2d(dx.mid(), dy.mid());
        if (!p.allFinite()) break;
    }
    return best;
}

Curve difference(const ExactForm& f, const ExactForm& g) {
    return {f.K * g.W - g.K * f.W, f.A * g.W - g.A * f.W, f.B * g.W - g.B * f.W, f.C * g.W - g.C * f.W};
}

class Settler {
public:
    Settler(const FormFamily& family, MinimizationDiagram& diagram) : family_(family), diagram_(diagram) {}

    bool is_settled(VertexId v) const {
        const MinimizationDiagram::Vertex& vertex = diagram_.vertices[v];
        return is_point_settled(vertex, vertex.error, steepest(v));
    }

    void settle(VertexId v) {
        MinimizationDiagram::Vertex& vertex = diagram_.vertices[v];
        const double slope = steepest(v);
        const auto forms = diagram_.label(v);
        if (forms.empty() || !std::ranges::all_of(forms, [&](FormId f) { return diagram_.is_circular(f); }))
            return;
        // Curves of a third form with two twins all but coincide; the one between the twins crosses them.
        std::vector<ExactForm> exact;
        for (const FormId f : forms) exact.push_back(family_.exact(f));
        std::vector<Curve> curves;
        for (std::size_t j = 1; j < exact.size(); ++j)
            for (std::size_t i = 0; i < j; ++i) curves.push_back(difference(exact[i], exact[j]));
        for (const std::uint32_t s : diagram_.sides(v)) {
            const ConvexRegion::Side& side = diagram_.region.sides[s];
            curves.push_back({Exact(), Exact(side.a), Exact(side.b), Exact(side.c)});
        }
        std::optional<Meeting> best;
        for (std::size_t i = 0; i < curves.size(); ++i)
            for (std::size_t j = 0; j < i && !(best && is_point_settled(vertex, best->error, slope)); ++j) {
                const auto found = meeting(curves[i], curves[j], vertex.point, vertex.error);
                if (found && (!best || found->error < best->error)) best = found;
            }
        if (!best) return;
        vertex.point = best->point;
        vertex.error = best->error;
        vertex.height_error = std::numeric_limits<double>::infinity();  // that height was another point's
    }

    // Where all meet, the form that is flattest tells the height best.
    void settle_height(VertexId v) {
        MinimizationDiagram::Vertex& vertex = diagram_.vertices[v];
        for (const FormId f : diagram_.label(v))
            if (diagram_.is_circular(f)) set_height(vertex, family_.exact(f));
    }

private:
    // The slope of the steepest circular height that meets others there, as doubles tell.
    double steepest(VertexId v) const {
        double slope = 0;
        for (const FormId f : diagram_.label(v))
            if (diagram_.is_circular(f))
                slope = std::max(slope, gradient(diagram_.forms[f], diagram_.vertices[v].point).norm());
        return slope;
    }

    // By how much the height changes on the way to the true vertex: (2 K p + (A, B)) / W and K / W tell.
    static void set_height(MinimizationDiagram::Vertex& vertex, const ExactForm& f) {
        const Exact x(vertex.point.x()), y(vertex.point.y()), two(2.0);
        const long size = f.W.exponent();
        const auto over_W = [&](const Exact& a) {
            return a.scaled(-size).enclosure() / f.W.scaled(-size).enclosure();
        };
        const Interval height = over_W(f.K * (x * x + y * y) + f.A * x + f.B * y + f.C),
                       slope =
                           sqrt(square(over_W(two * f.K * x + f.A)) + square(over_W(two * f.K * y + f.B)));
        const Interval e(vertex.error);
        const double error = (height.radius() + e * (slope + e * over_W(f.K).magnitude())).upper();
        if (!(error < vertex.height_error)) return;
        vertex.height = height.mid();
        vertex.height_error = error;
    }

    const FormFamily& family_;
    MinimizationDiagram& diagram_;
};

}  // namespace

void settle_vertices(const FormFamily& family, MinimizationDiagram& diagram, unsigned threads) {
    for_ranges(diagram.vertices.size(), threads, [&](std::size_t begin, std::size_t end) {
        Settler settler(family, diagram);
        for (auto i = static_cast<std::uint32_t>(begin); i < end; ++i) {
            if (!settler.is_settled(VertexId{i})) settler.settle(VertexId{i});
            if (!is_height_settled(diagram.vertices[VertexId{i}])) settler.settle_height(VertexId{i});
        }
    });
}

Vector2d settled_gradient(const FormFamily& family, FormId f, FormId g, const Vector2d& p) {
    const CurveJet at = jet(difference(family.exact(f), family.exact(g)), p);
    return {at.gx.mid(), at.gy.mid()};
}

}  // namespace vcell
