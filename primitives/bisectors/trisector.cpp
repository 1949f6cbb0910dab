#include "trisector.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "../../core/errors.hpp"
#include "../forms/round_surface.hpp"
#include "quadratic_form.hpp"

namespace vcell {

namespace {

bool all_zero(const std::vector<Exact>& values) {
    return std::ranges::all_of(values, [](const Exact& v) { return is_zero(v); });
}

using Basis = std::vector<LinearFunction>;  // homogeneous vectors: x, y, z, then r if it takes part, then 1

// Doubles in the ratio of exact numbers, the largest about one.
std::vector<double> rounded(const std::vector<Exact>& values) {
    std::optional<long> largest;
    for (const Exact& v : values)
        if (!is_zero(v)) largest = std::max(largest.value_or(v.exponent()), v.exponent());
    std::vector<double> result;
    for (const Exact& v : values) result.push_back(largest ? v.scaled(-*largest).enclosure().mid() : 0.0);
    return result;
}

double quotient(const Exact& numerator, const Exact& denominator) {
    const long shift = -denominator.exponent();
    return (numerator.scaled(shift).enclosure() / denominator.scaled(shift).enclosure()).mid();
}

Exact determinant(const std::array<std::array<Exact, 3>, 3>& m) {
    return m[0][0] * (m[1][1] * m[2][2] - m[1][2] * m[2][1]) -
           m[0][1] * (m[1][0] * m[2][2] - m[1][2] * m[2][0]) +
           m[0][2] * (m[1][0] * m[2][1] - m[1][1] * m[2][0]);
}

// The vectors whose coordinates in `basis` are those of `inner`.
Basis combined(const Basis& basis, const Basis& inner) {
    Basis result;
    for (const LinearFunction& c : inner) {
        LinearFunction v(basis[0].size());
        for (std::size_t i = 0; i < basis.size(); ++i)
            for (std::size_t k = 0; k < v.size(); ++k) v[k] += c[i] * basis[i][k];
        result.push_back(v);
    }
    return result;
}

// Distances that all objects allow: sqrt(A) = rho + side r >= 0 for each, and r >= 0 for planes.
struct Range {
    std::optional<Exact> lower, upper;

    void at_least(const Exact& r) {
        if (!lower || r > *lower) lower = r;
    }
    void at_most(const Exact& r) {
        if (!upper || r < *upper) upper = r;
    }
    // r = numerator / w
    bool contains(Exact numerator, Exact w) const {
        if (w.sign() == Sign::Negative) {
            numerator = -numerator;
            w = -w;
        }
        return (!lower || numerator >= *lower * w) && (!upper || numerator <= *upper * w);
    }
    // Is a c^2 + 2 b c + d > 0 somewhere within?
    bool allows(const Exact& a, const Exact& b, const Exact& d) const {
        const auto positive_at = [&](const Exact& c) {
            return (a * c * c + 2.0 * b * c + d).sign() == Sign::Positive;
        };
        if (lower && positive_at(*lower)) return true;
        if (upper && positive_at(*upper)) return true;
        const auto grows = [&](const Exact& slope) {
            return a.sign() == Sign::Positive ||
                   (is_zero(a) &&
                    (slope.sign() == Sign::Positive || (is_zero(slope) && d.sign() == Sign::Positive)));
        };
        if (!upper && grows(b)) return true;
        if (!lower && grows(-b)) return true;
        // The top, at c = -b / a, a < 0.
        if (a.sign() != Sign::Negative || (b * b - a * d).sign() != Sign::Positive) return false;
        return contains(b, -a);
    }
};

Basis unit_basis(std::size_t n) {
    Basis basis(n, LinearFunction(n));
    for (std::size_t i = 0; i < n; ++i) basis[i][i] = 1.0;
    return basis;
}

std::vector<QuadraticForm> restricted(const std::vector<QuadraticForm>& forms, const Basis& basis) {
    std::vector<QuadraticForm> result;
    for (const QuadraticForm& form : forms) result.push_back(form.restricted(basis));
    return result;
}

class Components {
public:
    // with_r: r takes part, as the fourth coordinate.
    Components(Range range, bool with_r) : with_r_(with_r), range_(std::move(range)) {}

    // The curves in the span of `basis` where all forms, given on that span, vanish.
    void add(const Basis& basis, const std::vector<QuadraticForm>& forms) {
        if (std::ranges::all_of(basis, [](const auto& v) { return is_zero(v.back()); })) return;
        if (forms.empty()) return add_line(basis);
        if (forms.size() == 1) return add_conic(basis, forms[0]);
        bool irrational = false;
        for (std::size_t i = 0; i < forms.size(); ++i)
            for (std::size_t j = i + 1; j < forms.size(); ++j) {
                const PencilSplit split = split_pencil(forms[i], forms[j]);
                // Real common points lie where both factors vanish: no curve.
                if (split.factors.kind == Factors::Kind::Complex) return;
                irrational = irrational || split.factors.kind == Factors::Kind::Irrational;
                if (split.factors.kind != Factors::Kind::Rational) continue;
                std::vector<QuadraticForm> rest = forms;
                rest.erase(rest.begin() + static_cast<std::ptrdiff_t>(split.is_first ? i : j));
                for (const LinearFunction& f : split.factors.linear) add_where(f, basis, rest);
                return;
            }
        result_.splits_irrationally = result_.splits_irrationally || irrational;
        TrisectorComponent spline;
        spline.degree = 1 << forms.size();
        result_.components.push_back(spline);
    }

    void add_where(const LinearFunction& f, const Basis& basis, const std::vector<QuadraticForm>& forms) {
        const Basis inner = kernel(f);
        add(combined(basis, inner), restricted(forms, inner));
    }

    Trisector take() { return std::move(result_); }

private:
    // (x, y, z, 1) of a homogeneous vector.
    static std::array<Exact, 4> projected(const LinearFunction& v) { return {v[0], v[1], v[2], v.back()}; }

    // The plane through three homogeneous points, zero where they are collinear: 3 x 3 minors, one coordinate
    // left out at a time.
    static std::vector<Exact> joined(const LinearFunction& p, const LinearFunction& q,
                                     const LinearFunction& r) {
        std::vector<Exact> plane;
        for (std::size_t skip = 0; skip < 4; ++skip) {
            std::array<std::array<Exact, 3>, 3> m;
            for (std::size_t i = 0, row = 0; i < 4; ++i)
                if (i != skip) m[row++] = {projected(p)[i], projected(q)[i], projected(r)[i]};
            plane.push_back((skip % 2 == 0 ? 1.0 : -1.0) * determinant(m));
        }
        return plane;
    }

    void add_line(const Basis& basis) {
        const bool first = !is_zero(basis[0].back());
        const LinearFunction &a = basis[first ? 0 : 1], &b = basis[first ? 1 : 0];
        std::vector<Exact> along;
        for (int i = 0; i < 3; ++i) along.push_back(a.back() * b[i] - b.back() * a[i]);
        if (all_zero(along)) return;
        // A line in which two of the planes meet turns up in both.
        for (const Basis& other : lines_)
            if (all_zero(joined(other[0], other[1], a)) && all_zero(joined(other[0], other[1], b))) return;
        TrisectorComponent line;
        line.kind = TrisectorKind::Line;
        for (int i = 0; i < 3; ++i) line.point[i] = quotient(a[i], a.back());
        const std::vector<double> direction = rounded(along);
        line.direction = Vec3(direction[0], direction[1], direction[2]).normalized();
        if (with_r_) {
            const Exact slope = a.back() * b[3] - b.back() * a[3];
            if (is_zero(slope) && !range_.contains(a[3], a.back())) return;
            // r changes by slope over `along`, along its largest component best.
            int k = 0;
            line.direction.cwiseAbs().maxCoeff(&k);
            const Vec3 c = line.direction * (quotient(slope, along[k]) * line.direction[k]);
            line.clearance =
                Eigen::Vector4d(c.x(), c.y(), c.z(), quotient(a[3], a.back()) - c.dot(line.point));
        }
        lines_.push_back(basis);
        result_.components.push_back(line);
    }

    void add_conic(const Basis& basis, const QuadraticForm& form) {
        const Factors split = factors(form);
        if (split.kind == Factors::Kind::Complex) return;
        if (split.kind != Factors::Kind::None) {
            for (const LinearFunction& f : split.linear) add_where(f, basis, {});
            return;
        }
        if (!is_real_within_range(basis, form)) return;

        TrisectorComponent conic;
        conic.kind = classify(basis, form);
        conic.degree = 2;
        const std::vector<double> p = rounded(joined(basis[0], basis[1], basis[2]));
        conic.plane = Eigen::Vector4d(p[0], p[1], p[2], p[3]) / Vec3(p[0], p[1], p[2]).norm();

        // Coordinates of a point X = B c of the plane: c = adj(B^T B) B^T X / det(B^T B).
        QuadraticForm gram(3);
        for (std::size_t i = 0; i < 3; ++i)
            for (std::size_t j = i; j < 3; ++j) {
                LinearFunction ei(3), ej(3);
                ei[i] = ej[j] = 1.0;
                const auto x = projected(basis[i]), y = projected(basis[j]);
                gram.add_twice_product(
                    (i == j ? 0.5 : 1.0) * (x[0] * y[0] + x[1] * y[1] + x[2] * y[2] + x[3] * y[3]), ei, ej);
            }
        const QuadraticForm inverse = adjugate(gram);
        Exact det;
        for (std::size_t k = 0; k < 3; ++k) det += gram(0, k) * inverse(k, 0);
        std::array<LinearFunction, 4> coordinates;  // of the unit vectors, times det
        for (std::size_t k = 0; k < 4; ++k)
            for (std::size_t i = 0; i < 3; ++i) {
                Exact sum;
                for (std::size_t j = 0; j < 3; ++j) sum += inverse(i, j) * projected(basis[j])[k];
                coordinates[k].push_back(sum);
            }
        std::vector<Exact> entries;
        for (const LinearFunction& x : coordinates)
            for (const LinearFunction& y : coordinates) entries.push_back(form.polar(x, y));
        const std::vector<double> m = rounded(entries);
        conic.quadric = Eigen::Map<const Eigen::Matrix4d>(m.data());
        if (with_r_) {
            conic.clearance.emplace();
            for (int k = 0; k < 4; ++k) {
                Exact sum;
                for (std::size_t i = 0; i < 3; ++i) sum += coordinates[k][i] * basis[i][3];
                (*conic.clearance)(k) = quotient(sum, det);
            }
        }
        result_.components.push_back(conic);
    }

    // How the conic meets the line at infinity; a circle has the metric's form there.
    static TrisectorKind classify(const Basis& basis, const QuadraticForm& form) {
        const Basis at_infinity = kernel({basis[0].back(), basis[1].back(), basis[2].back()});
        const Basis directions = combined(basis, at_infinity);
        const QuadraticForm h = form.restricted(at_infinity);
        const Sign disc = (h(0, 0) * h(1, 1) - h(0, 1) * h(0, 1)).sign();
        if (disc == Sign::Negative) return TrisectorKind::Hyperbola;
        if (disc == Sign::Zero) return TrisectorKind::Parabola;
        const auto metric = [&](int i, int j) {
            Exact sum;
            for (int k = 0; k < 3; ++k) sum += directions[i][k] * directions[j][k];
            return sum;
        };
        const bool circle = is_zero(h(0, 0) * metric(1, 1) - h(1, 1) * metric(0, 0)) &&
                            is_zero(h(0, 0) * metric(0, 1) - h(0, 1) * metric(0, 0));
        return circle ? TrisectorKind::Circle : TrisectorKind::Ellipse;
    }

    // A line with coordinates l meets the conic F in real points when l^T adj(F) l <= 0. The lines r = c of
    // the conic's plane make that a quadratic in c.
    bool is_real_within_range(const Basis& basis, const QuadraticForm& form) const {
        const QuadraticForm dual = adjugate(form);
        const LinearFunction w{basis[0].back(), basis[1].back(), basis[2].back()};
        if (with_r_) {
            const LinearFunction r{basis[0][3], basis[1][3], basis[2][3]};
            const bool constant = is_zero(r[0] * w[1] - r[1] * w[0]) && is_zero(r[1] * w[2] - r[2] * w[1]) &&
                                  is_zero(r[2] * w[0] - r[0] * w[2]);
            if (!constant) return range_.allows(-dual.polar(w, w), dual.polar(r, w), -dual.polar(r, r));
            const std::size_t k = !is_zero(w[0]) ? 0 : !is_zero(w[1]) ? 1 : 2;
            if (!range_.contains(r[k], w[k])) return false;
        }
        // Imaginary conics are the definite forms of full rank.
        const Exact first = form(0, 0), second = form(0, 0) * form(1, 1) - form(0, 1) * form(0, 1);
        Exact third;
        for (std::size_t k = 0; k < 3; ++k) third += form(0, k) * dual(k, 0);
        return second.sign() != Sign::Positive || first.sign() != third.sign();
    }

    const bool with_r_;
    const Range range_;
    std::vector<Basis> lines_;
    Trisector result_;
};

// 1 / the distance (in the scene's unit) beyond which a control point is as good as infinitely far.
constexpr double parallel_tangents = 0x1p-40;

// A sphere or cylinder as a condition on (p, r): squared distance of p from its centre = (r + side rho)^2.
struct RoundCondition {
    RoundSurface surface;
    int side = 1;  // -1: seen from within
};

// norm |m|^2 - (m.a)^2 - norm (r + side rho)^2, or without the last term.
QuadraticForm quadric(const RoundCondition& c, bool with_r, const Exact& scale) {
    const std::size_t n = with_r ? 5 : 4;
    const auto& p = c.surface.point;
    QuadraticForm form(n);
    const auto linear = [&](const ExactVector& v, const Exact& constant) {
        LinearFunction f(n);
        f[0] = v.x;
        f[1] = v.y;
        f[2] = v.z;
        f.back() = constant;
        return f;
    };
    for (const LinearFunction& m :
         {linear({1.0, 0.0, 0.0}, -p.x), linear({0.0, 1.0, 0.0}, -p.y), linear({0.0, 0.0, 1.0}, -p.z)})
        form.add_twice_product(scale * c.surface.norm, m, m);
    const LinearFunction along = linear(c.surface.axis, -dot(c.surface.axis, p));
    form.add_twice_product(-scale, along, along);
    if (with_r) {
        LinearFunction reach = linear({}, Exact(static_cast<double>(c.side)) * c.surface.rho);
        reach[3] = 1.0;
        form.add_twice_product(-(scale * c.surface.norm), reach, reach);
    }
    return form;
}

}  // namespace

std::string_view to_string(TrisectorKind kind) {
    switch (kind) {
        case TrisectorKind::Line: return "line";
        case TrisectorKind::Circle: return "circle";
        case TrisectorKind::Ellipse: return "ellipse";
        case TrisectorKind::Parabola: return "parabola";
        case TrisectorKind::Hyperbola: return "hyperbola";
        case TrisectorKind::Spline: break;
    }
    return "spline";
}

namespace {

Trisector trisector(const std::array<const Object*, 3>& objects, bool are_solids) {
    const Object& base = *objects[0];
    if (std::ranges::any_of(objects, [](const Object* o) { return is_vessel(*o); }))
        throw InputError(InputError::Kind::Unsupported, InputError::no_object, "",
                         "there is a vessel, of which no trisector is told");
    std::vector<RoundCondition> rounds;
    for (const Object* object : objects) {
        if (const auto* s = std::get_if<Sphere>(object)) rounds.push_back({RoundSurface(*s)});
        if (const auto* c = std::get_if<Cylinder>(object)) rounds.push_back({RoundSurface(*c)});
    }
    const bool round_base = !std::holds_alternative<Plane>(base);
    // What contains the base is seen from within; a line through a point has no inside.
    for (std::size_t i = 1; !are_solids && round_base && i < rounds.size(); ++i) {
        RoundCondition &first = rounds[0], &other = rounds[i];
        if (other.surface.contains(first.surface) && !is_zero(other.surface.rho))
            other.side = -1;
        else if (first.surface.contains(other.surface) && !is_zero(first.surface.rho))
            first.side = -1;
    }
    Range range;
    Exact norms = 1.0;
    for (const RoundCondition& c : rounds) {
        norms *= c.surface.norm;
        if (c.side > 0)
            range.at_least(-c.surface.rho);
        else
            range.at_most(c.surface.rho);
    }
    if (are_solids || rounds.size() < 3) range.at_least(Exact());

    // Equal radii, all seen from without: r + rho is the distance from centres and axes, and drops out of
    // two differences.
    const bool equal = rounds.size() == 3 && std::ranges::all_of(rounds, [&](const RoundCondition& c) {
                           return c.side > 0 && c.surface.rho == rounds[0].surface.rho;
                       });
    // Scaled to a common norm: differences of spheres and of parallel cylinders become linear.
    const auto scale = [&](std::size_t i) {
        Exact product = 1.0;
        for (std::size_t k = 0; k < rounds.size(); ++k)
            if (k != i) product *= rounds[k].surface.norm;
        return product;
    };
    std::vector<QuadraticForm> forms;
    for (std::size_t i = 0; i < rounds.size(); ++i) forms.push_back(quadric(rounds[i], !equal, scale(i)));
    if (equal) {
        Components components(range, false);
        components.add(unit_basis(4), {forms[0] + Exact(-1.0) * forms[1], forms[0] + Exact(-1.0) * forms[2]});
        return components.take();
    }

    // Each plane by each side it may be seen from: the base's is known, as is a round base's.
    std::vector<std::vector<LinearFunction>> planes;
    for (std::size_t k = 0; k < objects.size(); ++k) {
        const auto* plane = std::get_if<Plane>(objects[k]);
        if (plane == nullptr) continue;
        const ExactVector n(plane->normal);
        const Exact d = -dot(n, ExactVector(plane->point)), length = rounded_sqrt(dot(n, n));
        int seen = k == 0 || are_solids ? 1 : 0;
        if (round_base && !are_solids)
            seen = (dot(n, rounds[0].surface.point) + d).sign() == Sign::Negative ? -1 : 1;
        planes.emplace_back();
        for (const double side : {1.0, -1.0})
            if (seen != -side)
                planes.back().push_back({side * n.x, side * n.y, side * n.z, -length, side * d});
    }
    Components components(range, true);
    const auto choose = [&](const auto& self, std::size_t k, const Basis& basis) -> void {
        if (k == planes.size()) {
            components.add(basis, restricted(forms, basis));
            return;
        }
        for (const LinearFunction& plane : planes[k]) {
            LinearFunction f;  // the plane on the span of the basis
            for (const LinearFunction& v : basis) {
                Exact sum;
                for (std::size_t i = 0; i < v.size(); ++i) sum += plane[i] * v[i];
                f.push_back(sum);
            }
            if (all_zero(f)) continue;  // the same plane, from the same side
            self(self, k + 1, combined(basis, kernel(f)));
        }
    };
    choose(choose, 0, unit_basis(5));
    return components.take();
}

}  // namespace

Trisector trisector(const Object& base, const Object& a, const Object& b) {
    return trisector(std::array{&base, &a, &b}, false);
}

Trisector trisector_of_solids(const Object& a, const Object& b, const Object& c) {
    return trisector(std::array{&a, &b, &c}, true);
}

// At right angles to three others in four dimensions: their minors in turn.
static Eigen::Vector4d across(const Eigen::Vector4d& a, const Eigen::Vector4d& b, const Eigen::Vector4d& c) {
    Eigen::Vector4d result;
    for (int i = 0; i < 4; ++i) {
        const int j = (i + 1) % 4, k = (i + 2) % 4, l = (i + 3) % 4;
        const double minor = a[j] * (b[k] * c[l] - b[l] * c[k]) - a[k] * (b[j] * c[l] - b[l] * c[j]) +
                             a[l] * (b[j] * c[k] - b[k] * c[j]);
        result[i] = i % 2 == 0 ? minor : -minor;
    }
    return result;
}

std::optional<RationalCurve3> trisector_arc(const TrisectorComponent& component, const Vec3& from,
                                            const Vec3& to) {
    if (component.kind == TrisectorKind::Spline) return std::nullopt;
    const Eigen::Vector4d p = from.homogeneous(), q = to.homogeneous();
    if (component.kind == TrisectorKind::Line) return RationalCurve3{1, {0, 0, 1, 1}, {p, q}};
    // The control point in the middle is the pole m of the chord: m^T M p = m^T M q = 0 in the plane. With
    // weight w the curve lies on the conic when p^T M q + 2 w^2 m^T M m = 0.
    const Eigen::Vector4d pole = across(component.plane, component.quadric * p, component.quadric * q);
    if (std::abs(pole(3)) <= parallel_tangents * pole.head<3>().norm()) return std::nullopt;
    const Eigen::Vector4d m = pole / pole(3);
    const double square = -p.dot(component.quadric * q) / (2 * m.dot(component.quadric * m));
    if (!(square > 0) || !std::isfinite(square)) return std::nullopt;
    Eigen::Vector4d middle = m;
    middle(3) = std::sqrt(square);
    return RationalCurve3{2, {0, 0, 0, 1, 1, 1}, {p, middle, q}};
}

}  // namespace vcell
