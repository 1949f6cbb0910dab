// The curves of a trisector within a box: the solver proves which there are, of each component by its
// equations in space and distance.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "../../core/errors.hpp"
#include "../../core/numbers/enclosure.hpp"
#include "../../core/solver/curves/curve.hpp"
#include "../../core/solver/systems/scaled.hpp"
#include "trisector.hpp"
#include "trisector_equations.hpp"
#include "trisector_fit.hpp"

namespace vcell {

namespace {

constexpr int unknowns = 4;  // x, y, z, r

// A polynomial of degree two in x, y, z, r, its exact coefficients to a common scale of about one.
class Quadratic {
public:
    explicit Quadratic(const QuadraticForm& form) {
        for (int i = 0; i <= unknowns; ++i)
            for (int j = i; j <= unknowns; ++j) add(i, j, Exact(i == j ? 1.0 : 2.0) * form(i, j));
        scale();
    }
    explicit Quadratic(const LinearFunction& f) {
        for (int i = 0; i <= unknowns; ++i) add(i, unknowns, f[i]);
        scale();
    }

    template <class T>
    T operator()(const std::array<T, unknowns>& x) const {
        T sum = constant<T>(constant_);
        for (const Term& t : terms_)
            sum += scaled(t.coefficient, t.j == unknowns ? x[t.i]
                                         : t.i == t.j    ? square(x[t.i])
                                                         : x[t.i] * x[t.j]);
        return sum;
    }

private:
    struct Term {
        int i, j;  // x[i] x[j]; where j is `unknowns`, x[i]
        Exact exact;
        Coefficient coefficient = 0.0;
    };

    // Where i is `unknowns`, too, it is the constant.
    void add(int i, int j, Exact value) {
        if (value.sign() != Sign::Zero) terms_.push_back({i, j, std::move(value)});
    }
    void scale() {
        long size = terms_.front().exact.exponent();
        for (const Term& t : terms_) size = std::max(size, t.exact.exponent());
        for (Term& t : terms_) t.coefficient = enclosure_of<Wide>(t.exact.scaled(-size));
        if (terms_.back().i == unknowns) {
            constant_ = terms_.back().coefficient;
            terms_.pop_back();
        }
    }

    std::vector<Term> terms_;
    Coefficient constant_ = 0.0;
};

CurveSystem<3> system_of(const TrisectorEquations& e) {
    std::vector<Quadratic> f;
    for (const LinearFunction& linear : e.linear) f.emplace_back(linear);
    for (const QuadraticForm& form : e.quadratic) f.emplace_back(form);
    return CurveSystem<3>([f](const auto& x) { return std::array{f[0](x), f[1](x), f[2](x)}; });
}

// No point of the box is farther from the object's surface.
double farthest(const Object& base, const Box& box) {
    const Vec3 middle = 0.5 * (box.min + box.max);
    const double reach = box.diagonal();
    if (const auto* p = std::get_if<Plane>(&base)) return (middle - p->point).norm() + reach;
    if (const auto* s = std::get_if<Sphere>(&base)) return (middle - s->center).norm() + s->radius + reach;
    const auto& c = std::get<Cylinder>(base);
    return (middle - c.point).norm() + c.radius + reach;
}

Vec3 place(const IntervalBox<unknowns>& box) { return {box[0].mid(), box[1].mid(), box[2].mid()}; }

// A conic's direction at one of its points.
Vec3 direction_at(const TrisectorComponent& conic, const Vec3& p) {
    return conic.plane.head<3>().cross((conic.quadric * p.homogeneous()).head<3>()).normalized();
}

// Points of a part of the conic, in order, between which its direction turns by less than a right angle.
std::vector<Vec3> stations(const TrisectorComponent& conic, const CurveSystem<3>& f,
                           const CurveComponent<unknowns>& part) {
    constexpr double least_cosine = 0.2;
    std::vector<Vec3> all{place(part.joints.front())};
    for (std::size_t i = 0; i < part.tubes.size(); ++i) {
        const Tube<unknowns>& tube = part.tubes[i];
        constexpr int most_between = 8;  // a tube is a graph: its direction turns by less than half a circle
        for (int k = 1; k < most_between; ++k)
            all.push_back(
                place(point_at<3>(f, tube, std::lerp(tube.begin, tube.end, k / double(most_between)))));
        all.push_back(place(part.joints[i + 1]));
    }
    std::vector<Vec3> kept{all.front()};
    Vec3 from = direction_at(conic, all.front());
    for (std::size_t i = 1; i + 1 < all.size(); ++i) {
        if (direction_at(conic, all[i + 1]).dot(from) > least_cosine) continue;
        kept.push_back(all[i]);
        from = direction_at(conic, all[i]);
    }
    kept.push_back(part.closed ? all.front() : all.back());
    return kept;
}

}  // namespace

TrisectorCurves trisector(const Object& base, const Object& a, const Object& b, const Box& box,
                          double tolerance) {
    TrisectorCurves result;
    const double most = farthest(base, box);
    for (const TrisectorComponent& component : trisector(base, a, b).components) {
        const TrisectorEquations& equations = *component.equations;
        const double least = equations.least ? equations.least->enclosure().lower() : -most;
        const double greatest = std::min(most, equations.most ? equations.most->enclosure().upper() : most);
        if (!(least < greatest)) continue;
        const IntervalBox<unknowns> region{Interval(box.min.x(), box.max.x()),
                                           Interval(box.min.y(), box.max.y()),
                                           Interval(box.min.z(), box.max.z()), Interval(least, greatest)};
        const CurveSystem<3> f = system_of(equations);
        const CurveSet<unknowns> found = solve_curves<3>(f, region);
        for (const auto& cluster : found.undecided) {
            const auto& at = cluster.box;
            result.undecided.push_back({{at[0].lower(), at[1].lower(), at[2].lower()},
                                        {at[0].upper(), at[1].upper(), at[2].upper()}});
        }
        for (const CurveComponent<unknowns>& part : found.components) {
            TrisectorCurve curve;
            curve.kind = component.kind;
            curve.degree = component.degree;
            curve.is_closed = part.closed;
            for (const int end : {0, 1})
                curve.ends[end] =
                    part.ends[end].kind == CurveEnd::Kind::Face ? static_cast<int>(part.ends[end].index) : -1;
            if (component.kind == TrisectorKind::Spline) {
                TrisectorSpline spline = fit_trisector({&base, &a, &b}, equations.sides, f, part, tolerance);
                curve.arcs.push_back(std::move(spline.curve));
                curve.error = spline.error;
            } else if (component.kind == TrisectorKind::Line) {
                curve.arcs.push_back(
                    *trisector_arc(component, place(part.joints.front()), place(part.joints.back())));
            } else {
                const std::vector<Vec3> points = stations(component, f, part);
                for (std::size_t i = 0; i + 1 < points.size(); ++i) {
                    auto arc = trisector_arc(component, points[i], points[i + 1]);
                    if (!arc) throw UndecidedError("trisector(): doubles do not tell a conic's arc");
                    curve.arcs.push_back(std::move(*arc));
                }
            }
            result.curves.push_back(std::move(curve));
        }
    }
    return result;
}

}  // namespace vcell
