#include "sphere_supports.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

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
PointNormal::PointNormal(double x, double y) {
    const double m = 2 / (1 + x * x + y * y), X = x * m, Y = y * m;
    u = {X, Y, m - 1};
    ux = {m - X * X, -X * Y, -X * m};
    uy = {-X * Y, m - Y * Y, -Y * m};
}

NormalBox::NormalBox(double x0, double x1, double y0, double y1) : x0_(x0), x1_(x1), y0_(y0), y1_(y1) {
    const double x = std::midpoint(x0, x1), y = std::midpoint(y0, y1);
    rx_ = outwards * std::max(x1 - x, x - x0);
    ry_ = outwards * std::max(y1 - y, y - y0);
    middle_ = PointNormal(x, y);
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
    if (is_circular(f)) return circular_[f.value];
    const Cylinder& c = cylinder(f);
    const double B = box.value(c.b), A = box.value(c.a), w = std::sqrt(B * B + A * A);
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

double SphereSupports::value(FormId f, const PointNormal& n) const {
    const auto at = [&](const NormalFunction& l) { return NormalBox::dot(l, n.u) + l.s; };
    if (is_circular(f)) return -at(circular_[f.value].plane);
    const double b = at(cylinder(f).b), a = at(cylinder(f).a);
    return -(b + std::sqrt(b * b + a * a));
}

std::array<double, 3> SphereSupports::jet(FormId f, const PointNormal& n) const {
    const auto gradient = [&](const NormalFunction& l) {
        return std::array{NormalBox::dot(l, n.u) + l.s, NormalBox::dot(l, n.ux), NormalBox::dot(l, n.uy)};
    };
    std::array<double, 3> q;
    if (is_circular(f)) {
        q = gradient(circular_[f.value].plane);
    } else {
        const Cylinder& c = cylinder(f);
        const auto b = gradient(c.b), a = gradient(c.a);
        const double w = std::hypot(b[0], a[0]), cosine = b[0] / w, sine = a[0] / w;
        q = {b[0] + w, b[1] + cosine * b[1] + sine * a[1], b[2] + cosine * b[2] + sine * a[2]};
    }
    return {-q[0], -q[1], -q[2]};
}

DividedBox::DividedBox(const SphereSupports& supports, const std::array<double, 4>& box,
                       std::span<const FormId> forms)
    : all_(supports), forms_(forms) {
    constexpr std::size_t usual = 25;
    parts_.reserve(usual);
    normals_.reserve(usual);
    supports_.reserve(usual * forms.size());
    parts_.push_back({box});
    normals_.emplace_back(box[0], box[1], box[2], box[3]);
    supports_.resize(forms.size());
}

// The first of a part's quarters.
DividedBox::Part DividedBox::quarter(Part part) const {
    if (parts_[part].first != 0) return parts_[part].first;
    const auto first = static_cast<Part>(parts_.size());
    parts_[part].first = first;
    const auto [x0, x1, y0, y1] = parts_[part].box;
    const double x = std::midpoint(x0, x1), y = std::midpoint(y0, y1);
    for (const Box& b : {Box{x0, x, y0, y}, Box{x, x1, y0, y}, Box{x0, x, y, y1}, Box{x, x1, y, y1}}) {
        parts_.push_back({b});
        normals_.emplace_back(b[0], b[1], b[2], b[3]);
    }
    supports_.resize(parts_.size() * forms_.size());
    return first;
}

const Support& DividedBox::support(std::size_t f, Part part) const {
    if (const Support* everywhere = all_.everywhere(forms_[f])) return *everywhere;
    std::optional<Support>& s = supports_[part * forms_.size() + f];
    if (!s) s = all_.over(forms_[f], normals_[part]);
    return *s;
}

bool DividedBox::meet(std::size_t f, std::size_t g, Part part) const {
    return normals_[part].meet(support(f, part), support(g, part));
}

bool DividedBox::grows_along(std::size_t f, std::size_t g, const Eigen::Vector2d& direction) const {
    return grows_along(f, g, direction, 0, 0);
}

bool DividedBox::grows_along(std::size_t f, std::size_t g, const Eigen::Vector2d& direction, Part part,
                             int level) const {
    const auto [x, y] = normals_[part].gradient(support(f, part), support(g, part));
    const Interval growth = Interval(direction.x()) * x + Interval(direction.y()) * y;
    if (growth.lower() > 0 || !meet(f, g, part)) return true;
    // Where it falls in the middle of a small part it most likely does so on the trisector, too.
    constexpr int small = 2;
    if (level == levels || (level >= small && growth.mid() < 0)) return false;
    const Part first = quarter(part);
    for (Part q = first; q < first + 4; ++q)
        if (!grows_along(f, g, direction, q, level + 1)) return false;
    return true;
}

// Extends `hull` by the smallest parts in which every two of the forms may be equal.
void DividedBox::enclose_meeting(const std::array<std::size_t, 3>& forms, Part part, int level,
                                 Box& hull) const {
    const auto& [f, g, h] = forms;
    if (!meet(f, g, part) || !meet(f, h, part) || !meet(g, h, part)) return;
    if (level == levels) {
        const Box& b = parts_[part].box;
        hull = {std::min(hull[0], b[0]), std::max(hull[1], b[1]), std::min(hull[2], b[2]),
                std::max(hull[3], b[3])};
        return;
    }
    const Part first = quarter(part);
    for (Part q = first; q < first + 4; ++q) enclose_meeting(forms, q, level + 1, hull);
}

const std::optional<DividedBox::Box>& DividedBox::meeting(std::size_t f, std::size_t g, std::size_t h) const {
    std::array forms{f, g, h};
    std::ranges::sort(forms);
    const auto known = std::ranges::find(meetings_, forms, &Meeting::forms);
    if (known != meetings_.end()) return known->box;
    constexpr double infinity = std::numeric_limits<double>::infinity();
    Box hull{infinity, -infinity, infinity, -infinity};
    enclose_meeting(forms, 0, 0, hull);
    meetings_.push_back({forms, hull[0] < hull[1] ? std::optional(hull) : std::nullopt});
    return meetings_.back().box;
}

std::optional<Sign> DividedBox::turn(std::size_t f, std::size_t g, std::size_t h) const {
    const std::optional<Box>& hull = meeting(f, g, h);
    if (!hull) return Sign::Positive;
    const NormalBox box((*hull)[0], (*hull)[1], (*hull)[2], (*hull)[3]);
    const Support a = all_.over(forms_[f], box);
    const auto to_g = box.gradient(all_.over(forms_[g], box), a),
               to_h = box.gradient(all_.over(forms_[h], box), a);
    return (to_g[0] * to_h[1] - to_g[1] * to_h[0]).sign();
}

}  // namespace vcell
