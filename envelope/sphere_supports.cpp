#include "sphere_supports.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vcell {

namespace {

// More roundings, in units of the largest term, than any value here takes: coefficients come with some 8 of
// them, their combinations and products with 20. What is itself a bound is made larger by `outwards` at the
// end.
constexpr double rounding = 128 * std::numeric_limits<double>::epsilon();
constexpr double outwards = 1 + rounding;

double magnitude(const NormalFunction& f) {
    return std::abs(f.p[0]) + std::abs(f.p[1]) + std::abs(f.p[2]) + std::abs(f.s);
}

// s f + t g
NormalFunction combination(double s, const NormalFunction& f, double t, const NormalFunction& g) {
    return {{s * f.p[0] + t * g.p[0], s * f.p[1] + t * g.p[1], s * f.p[2] + t * g.p[2]}, s * f.s + t * g.s};
}

// The least value of k x^2 + a x between lo and hi.
double least(double k, double a, double lo, double hi) {
    const double ends = std::min(lo * (k * lo + a), hi * (k * hi + a));
    if (!(k > 0)) return ends;
    const double x = -a / (2 * k);
    return lo < x && x < hi ? std::min(ends, x * (k * x + a)) : ends;
}

}  // namespace

// With X = x m, Y = y m as in radial_height.hpp, u_xx = (X (2 X^2 - 3 m), Y (2 X^2 - m), m (2 X^2 - m)),
// u_xy = (Y (2 X^2 - m), X (2 Y^2 - m), 2 X Y m), and u_yy as u_xx.
NormalBox::Normal::Normal(double x, double y) {
    const double m = 2 / (1 + x * x + y * y), X = x * m, Y = y * m;
    u = {X, Y, m - 1};
    ux = {m - X * X, -X * Y, -X * m};
    uy = {-X * Y, m - Y * Y, -Y * m};
}

NormalBox::NormalBox(double x0, double x1, double y0, double y1) : x0_(x0), x1_(x1), y0_(y0), y1_(y1) {
    const double x = std::midpoint(x0, x1), y = std::midpoint(y0, y1);
    rx_ = outwards * std::max(x1 - x, x - x0);
    ry_ = outwards * std::max(y1 - y, y - y0);
    middle_ = Normal(x, y);
    struct Range {
        double lo, hi;  // of an absolute value
    };
    const auto absolute = [](double lo, double hi) {
        return Range{lo > 0 ? lo : hi < 0 ? -hi : 0.0, std::max(-lo, hi)};
    };
    const Range ax = absolute(x0, x1), ay = absolute(y0, y1);
    const Range m{2 / (1 + ax.hi * ax.hi + ay.hi * ay.hi), 2 / (1 + ax.lo * ax.lo + ay.lo * ay.lo)};
    const double X = std::min(1.0, ax.hi * m.hi), Y = std::min(1.0, ay.hi * m.hi);  // |u| = 1
    const Range XX{ax.lo * ax.lo * m.lo * m.lo, X * X}, YY{ay.lo * ay.lo * m.lo * m.lo, Y * Y};
    const auto away = [&](const Range& square, double multiple) {  // |2 square - multiple m|
        return std::max(2 * square.hi - multiple * m.lo, multiple * m.hi - 2 * square.lo);
    };
    const double p = away(XX, 1), q = away(YY, 1), p3 = away(XX, 3), q3 = away(YY, 3);
    const std::array xx{X * p3, Y * p, m.hi * p}, xy{Y * p, X * q, 2 * X * Y * m.hi},
        yy{X * q, Y * q3, m.hi * q};
    for (int i = 0; i < 3; ++i) {
        ux_range_[i] = outwards * (xx[i] * rx_ + xy[i] * ry_);
        uy_range_[i] = outwards * (xy[i] * rx_ + yy[i] * ry_);
    }
    m_ = outwards * m.hi;
}

// How much f differs from its value at the middle; the gradient's own variation counts half on the way.
double NormalBox::variation(const NormalFunction& f) const {
    return (std::abs(dot(f, middle_.ux)) + 0.5 * bound(f, ux_range_)) * rx_ +
           (std::abs(dot(f, middle_.uy)) + 0.5 * bound(f, uy_range_)) * ry_;
}

std::array<double, 2> NormalBox::steepest(const NormalFunction& f) const {
    return {std::abs(dot(f, middle_.ux)) + bound(f, ux_range_),
            std::abs(dot(f, middle_.uy)) + bound(f, uy_range_)};
}

// W (p.u + s) = (s - p_z) (x^2 + y^2) + 2 p_x x + 2 p_y y + s + p_z.
bool NormalBox::is_above(const Support& a, const Support& b) const {
    NormalFunction d = combination(1, b.plane, -1, a.plane);
    d.s -= a.excess + a.rounding + b.rounding;
    const double k = d.s - d.p[2];
    return least(k, 2 * d.p[0], x0_, x1_) + least(k, 2 * d.p[1], y0_, y1_) + (d.s + d.p[2]) > 0;
}

std::array<Interval, 2> NormalBox::gradient(const Support& a, const Support& b) const {
    const NormalFunction d = combination(1, b.plane, -1, a.plane);
    const double unsure = m_ * (a.rounding + b.rounding);
    return {
        Interval::ball(dot(d, middle_.ux), outwards * (bound(d, ux_range_) + a.bend[0] + b.bend[0] + unsure)),
        Interval::ball(dot(d, middle_.uy),
                       outwards * (bound(d, uy_range_) + a.bend[1] + b.bend[1] + unsure))};
}

SphereSupports::SphereSupports(const FormFamily& family) {
    for (const CircularForm& f : family.forms) {
        const double h = -0.5 / f.w;
        circular_.push_back({{{h * f.a, h * f.b, h * (f.e - f.k)}, h * (f.e + f.k)}, 0, {0, 0}, 0});
        circular_.back().rounding =
            -2 * rounding * h * (std::abs(f.a) + std::abs(f.b) + std::abs(f.e) + std::abs(f.k));
    }
    for (const RadialForm& f : family.radial) {
        const double C = f.c[0].enclosure().mid(), root = std::sqrt(C);
        Cylinder c{{{}, f.b0.enclosure().mid() / C}, {{}, 0}, 0};
        for (int i = 0; i < 3; ++i) {
            c.b.p[i] = f.b[i].enclosure().mid() / C;
            c.a.p[i] = f.a[i].enclosure().mid() / root;
        }
        c.rounding = rounding * (3 * magnitude(c.b) + 2 * magnitude(c.a));
        cylinders_.push_back(c);
    }
}

// With e = (cos, sin) along w at the middle let w_e = e.w, and w_n the component across. |w| - e.w = w_n^2 /
// (|w| + w_e), or at most |w_n| + |w_e| - w_e. As w turns by an angle t from e the gradient of |w| turns from
// that of w_e into cos(t) grad w_e + sin(t) grad w_n, where |sin t| <= |w_n| / w_e if w_e is positive and 1 -
// cos t <= sin^2 t.
Support SphereSupports::over(FormId f, const NormalBox& box) const {
    if (f.value < circular_.size()) return circular_[f.value];
    const Cylinder& c = cylinders_[f.value - circular_.size()];
    const double B = box.value(c.b), A = box.value(c.a), w = std::hypot(B, A);
    const double cosine = w > 0 ? B / w : 1, sine = w > 0 ? A / w : 0;
    const NormalFunction along = combination(cosine, c.b, sine, c.a),
                         across = combination(-sine, c.b, cosine, c.a);
    const double least_along = box.value(along) - box.variation(along) - c.rounding,
                 most_across = std::abs(box.value(across)) + box.variation(across) + c.rounding;
    Support out{combination(1, c.b, 1, along), most_across + 2 * std::max(0.0, -least_along), {}, c.rounding};
    double turned = 1, shortened = 2;
    if (least_along > most_across) {
        turned = most_across / least_along;
        shortened = turned * turned;
        out.excess = 0.5 * most_across * turned;
    }
    const auto growth = box.steepest(along), turn = box.steepest(across);
    for (const int i : {0, 1}) out.bend[i] = outwards * (shortened * growth[i] + turned * turn[i]);
    out.excess *= outwards;
    return out;
}

std::array<double, 3> SphereSupports::jet(FormId f, double x, double y) const {
    const NormalBox::Normal n(x, y);
    const auto gradient = [&](const NormalFunction& l) {
        return std::array{NormalBox::dot(l, n.u) + l.s, NormalBox::dot(l, n.ux), NormalBox::dot(l, n.uy)};
    };
    std::array<double, 3> q;
    if (f.value < circular_.size()) {
        q = gradient(circular_[f.value].plane);
    } else {
        const Cylinder& c = cylinders_[f.value - circular_.size()];
        const auto b = gradient(c.b), a = gradient(c.a);
        const double w = std::hypot(b[0], a[0]), cosine = b[0] / w, sine = a[0] / w;
        q = {b[0] + w, b[1] + cosine * b[1] + sine * a[1], b[2] + cosine * b[2] + sine * a[2]};
    }
    return {-q[0], -q[1], -q[2]};
}

DividedBox::DividedBox(const SphereSupports& supports, const std::array<double, 4>& box,
                       std::span<const FormId> forms)
    : size_(forms.size()), meeting_(forms.size() * forms.size()) {
    const auto at = [](int i, double lo, double hi) { return i == cuts ? hi : lo + i * ((hi - lo) / cuts); };
    for (int i = 0; i < cuts; ++i)
        for (int j = 0; j < cuts; ++j)
            parts_[i * cuts + j] = NormalBox(at(i, box[0], box[1]), at(i + 1, box[0], box[1]),
                                             at(j, box[2], box[3]), at(j + 1, box[2], box[3]));
    for (const FormId f : forms)
        for (const NormalBox& part : parts_) supports_.push_back(supports.over(f, part));
}

const DividedBox::Parts& DividedBox::meeting(std::size_t f, std::size_t g) const {
    std::optional<Parts>& parts = meeting_[std::min(f, g) * size_ + std::max(f, g)];
    if (parts) return *parts;
    parts.emplace();
    for (int i = 0; i < cuts * cuts; ++i) {
        const Support &a = support(f, i), &b = support(g, i);
        (*parts)[i] = !parts_[i].is_above(a, b) && !parts_[i].is_above(b, a);
    }
    return *parts;
}

bool DividedBox::grows_along(std::size_t f, std::size_t g, const Eigen::Vector2d& direction) const {
    const Parts& parts = meeting(f, g);
    for (int i = 0; i < cuts * cuts; ++i) {
        if (!parts[i]) continue;
        const auto [x, y] = parts_[i].gradient(support(f, i), support(g, i));
        if (!((Interval(direction.x()) * x + Interval(direction.y()) * y).lower() > 0)) return false;
    }
    return true;
}

std::optional<Sign> DividedBox::turn(std::size_t f, std::size_t g, std::size_t h) const {
    const Parts parts = meeting(f, g) & meeting(f, h) & meeting(g, h);
    int x0 = cuts, x1 = -1, y0 = cuts, y1 = -1;
    for (int i = 0; i < cuts * cuts; ++i) {
        if (!parts[i]) continue;
        x0 = std::min(x0, i / cuts);
        x1 = std::max(x1, i / cuts);
        y0 = std::min(y0, i % cuts);
        y1 = std::max(y1, i % cuts);
    }
    if (parts.none()) return Sign::Positive;
    std::array<Interval, 2> to_g, to_h;
    bool first = true;
    for (int i = x0; i <= x1; ++i)
        for (int j = y0; j <= y1; ++j) {
            const int part = i * cuts + j;
            const auto g_here = parts_[part].gradient(support(g, part), support(f, part)),
                       h_here = parts_[part].gradient(support(h, part), support(f, part));
            for (const int k : {0, 1}) {
                to_g[k] = first ? g_here[k] : hull(to_g[k], g_here[k]);
                to_h[k] = first ? h_here[k] : hull(to_h[k], h_here[k]);
            }
            first = false;
        }
    return (to_g[0] * to_h[1] - to_g[1] * to_h[0]).sign();
}

}  // namespace vcell
