#include "sphere_supports.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace vcell {

namespace {

// More roundings, in units of the largest term, than any value here takes: coefficients come with some 8 of
// them, their combinations and products with 20. What is itself a bound is made larger by `outwards` at the
// end.
constexpr double support_rounding = 128 * std::numeric_limits<double>::epsilon();
constexpr double outwards = 1 + support_rounding;

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
    const double x = 0.5 * x0 + 0.5 * x1, y = 0.5 * y0 + 0.5 * y1;
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

NormalBox::Slopes NormalBox::slopes(const NormalFunction& f) const {
    return {{std::abs(dot(f, middle_.ux)), std::abs(dot(f, middle_.uy))},
            {bound(f, ux_range_), bound(f, uy_range_)}};
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

NormalBox::Growth NormalBox::growth(const Support& a, const Support& b,
                                    const Eigen::Vector2d& direction) const {
    const NormalFunction d = combination(1, b.plane, -1, a.plane);
    const double unsure = m_ * (a.rounding + b.rounding);
    const double x = bound(d, ux_range_) + a.bend[0] + b.bend[0] + unsure,
                 y = bound(d, uy_range_) + a.bend[1] + b.bend[1] + unsure;
    return {direction.x() * dot(d, middle_.ux) + direction.y() * dot(d, middle_.uy),
            outwards * (std::abs(direction.x()) * x + std::abs(direction.y()) * y)};
}

SphereSupports::SphereSupports(const FormFamily& family) {
    for (const CircularForm& f : family.forms) {
        const double h = -0.5 / f.w;
        circular_.push_back({{{h * f.a, h * f.b, h * (f.e - f.k)}, h * (f.e + f.k)}, 0, {0, 0}, 0});
        circular_.back().rounding =
            -2 * support_rounding * h * (std::abs(f.a) + std::abs(f.b) + std::abs(f.e) + std::abs(f.k));
    }
    for (const RadialForm& f : family.radial) {
        const double C = f.c[0].enclosure().mid(), root = std::sqrt(std::abs(C));
        Cylinder c{{{}, f.b0.enclosure().mid() / C}, {{}, f.a0.enclosure().mid() / root}, 0};
        for (int i = 0; i < 3; ++i) {
            c.b.p[i] = f.b[i].enclosure().mid() / C;
            c.a.p[i] = f.a[i].enclosure().mid() / root;
        }
        c.rounding = support_rounding * (3 * magnitude(c.b) + 2 * magnitude(c.a));
        c.tip_side = f.is_hollow ? 1 : C < 0 ? -1 : 0;
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
    if (c.tip_side != 0) return over(c, box);
    const double B = box.value(c.b), A = box.value(c.a), w = std::sqrt(B * B + A * A);
    const double cosine = w > 0 ? B / w : 1, sine = w > 0 ? A / w : 0;
    const NormalFunction along = combination(cosine, c.b, sine, c.a),
                         across = combination(-sine, c.b, cosine, c.a);
    const NormalBox::Slopes growth = box.slopes(along), turn = box.slopes(across);
    const double least_along = box.value(along) - box.variation(growth) - c.rounding,
                 most_across = std::abs(box.value(across)) + box.variation(turn) + c.rounding;
    Support out{combination(1, c.b, 1, along), most_across + 2 * std::max(0.0, -least_along), {}, c.rounding};
    double turned = 1, shortened = 2;
    if (least_along > most_across) {
        turned = most_across / least_along;
        shortened = turned * turned;
        out.excess = 0.5 * most_across * turned;
    }
    for (const int i : {0, 1})
        out.bend[i] = outwards * (shortened * growth.steepest(i) + turned * turn.steepest(i));
    out.excess *= outwards;
    return out;
}

// With (e_1, e_2) along (B', A') at the middle, e_1^2 - e_2^2 = 1, let w_e = e_1 B' - e_2 A' and w_n = e_1 A'
// - e_2 B', which vanishes there. The root is D = sqrt(w_e^2 - w_n^2), w_e - D = w_n^2 / (w_e + D), and D's
// gradient (w_e grad w_e - w_n grad w_n) / D. Next to a tip, where D vanishes, e is turned less far.
Support SphereSupports::over(const Cylinder& c, const NormalBox& box) {
    constexpr double least_part = 0x1p-16;  // of D^2 in B'^2
    const double B = box.value(c.b), A = box.value(c.a),
                 D = std::sqrt(std::max((B - A) * (B + A), least_part * B * B)), e1 = B / D,
                 e2 = std::copysign(std::sqrt(std::max(0.0, (e1 - 1) * (e1 + 1))), A);
    const NormalFunction along = combination(e1, c.b, -e2, c.a), across = combination(-e2, c.b, e1, c.a);
    const double unsure = 4 * e1 * e1 * c.rounding;
    const NormalBox::Slopes growth = box.slopes(along), turn = box.slopes(across);
    const double variation = box.variation(growth), middle = box.value(along),
                 least_along = middle - variation - unsure,
                 most_across = std::abs(box.value(across)) + box.variation(turn) + unsure;
    Support out{
        combination(1, c.b, c.tip_side, along), middle + variation + unsure, {infinity, infinity}, unsure};
    if (least_along > most_across) {
        const double part = most_across / least_along, cosine = std::sqrt((1 - part) * (1 + part));
        out.excess = most_across * part / (1 + cosine);
        for (const int i : {0, 1})
            out.bend[i] =
                outwards * part / cosine * (part / (1 + cosine) * growth.steepest(i) + turn.steepest(i));
    }
    out.excess *= outwards;
    if (c.tip_side > 0) out.plane.s -= out.excess;
    return out;
}

double SphereSupports::value(FormId f, const PointNormal& n) const {
    const auto at = [&](const NormalFunction& l) { return NormalBox::dot(l, n.u) + l.s; };
    if (is_circular(f)) return -at(circular_[f.value].plane);
    const double b = at(cylinder(f).b), a = at(cylinder(f).a);
    if (const int side = cylinder(f).tip_side; side != 0)
        return -(b + side * std::sqrt(std::max(0.0, (b - a) * (b + a))));
    return -(b + std::sqrt(b * b + a * a));
}

// D^2 = (B' - A') (B' + A') errs by the rounding of both factors, and D by no more than the root of that.
double SphereSupports::error_by_tips(const Cylinder& c, const PointNormal& n) {
    const double b = NormalBox::dot(c.b, n.u) + c.b.s, a = NormalBox::dot(c.a, n.u) + c.a.s,
                 D = std::sqrt(std::max(0.0, (b - a) * (b + a))),
                 of_square = 4 * c.rounding * (std::abs(b) + std::abs(a) + c.rounding);
    return outwards * (c.rounding + std::min(of_square / D, std::sqrt(of_square)));
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
        const double w = c.tip_side != 0
                             ? c.tip_side * std::sqrt(std::max(0.0, (b[0] - a[0]) * (b[0] + a[0])))
                             : std::hypot(b[0], a[0]),
                     cosine = b[0] / w, sine = (c.tip_side != 0 ? -a[0] : a[0]) / w;
        q = {b[0] + w, b[1] + cosine * b[1] + sine * a[1], b[2] + cosine * b[2] + sine * a[2]};
    }
    return {-q[0], -q[1], -q[2]};
}

DividedBox::DividedBox(const SphereSupports& supports, const std::array<double, 4>& box,
                       std::span<const FormId> forms)
    : all_(supports) {
    start(box, forms);
}

void DividedBox::start(const std::array<double, 4>& box, std::span<const FormId> forms) {
    assert(forms.size() <= most_forms);
    forms_ = forms;
    constexpr std::size_t usual = 45;
    parts_.clear();
    parts_.reserve(usual);
    normals_.clear();
    normals_.reserve(usual);
    supports_.clear();
    supports_.reserve(usual * forms.size());
    meetings_.clear();
    parts_.push_back({box, ~Pairs{0}});
    normals_.emplace_back(box[0], box[1], box[2], box[3]);
    supports_.resize(forms.size());
}

// Of the pairs that may be lowest in the part around this one, those that are not certainly different here,
// and neither of which is certainly above another form.
DividedBox::Pairs DividedBox::lowest(Part part) const {
    if (parts_[part].is_compared) return parts_[part].lowest;
    const Pairs before = parts_[part].lowest;
    const NormalBox& box = normals_[part];
    struct Rival {
        std::size_t form;
        double middle;
        const Support* support;
    };
    std::array<Rival, most_forms> here;  // of these pairs, the one met first in the middle leading
    std::size_t n = 0;
    for (std::size_t f = 0; f < forms_.size(); ++f) {
        if ((before & pairs_of(f)) == 0) continue;
        const Support& s = support(f, part);
        const double middle = box.middle(s);
        std::size_t k = n++;
        for (; k > 0 && here[k - 1].middle < middle; --k) here[k] = here[k - 1];
        here[k] = {f, middle, &s};
    }
    Pairs after = 0;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < n; ++i) {
        const Rival r = here[i];
        Pairs meeting = 0;
        bool is_lowest = true;
        for (std::size_t j = 0; j < kept && is_lowest; ++j) {
            is_lowest = !box.is_above(*r.support, *here[j].support);
            meeting |= pair(r.form, here[j].form);
        }
        if (!is_lowest) continue;
        here[kept++] = r;
        after |= meeting;
    }
    parts_[part].is_compared = true;
    return parts_[part].lowest = before & after;
}

// The first of a part's quarters.
DividedBox::Part DividedBox::quarter(Part part) const {
    if (parts_[part].first != 0) return parts_[part].first;
    const auto first = static_cast<Part>(parts_.size());
    parts_[part].first = first;
    const Pairs pairs = parts_[part].lowest;
    const auto [x0, x1, y0, y1] = parts_[part].box;
    const double x = 0.5 * x0 + 0.5 * x1, y = 0.5 * y0 + 0.5 * y1;
    for (const Box& b : {Box{x0, x, y0, y}, Box{x, x1, y0, y}, Box{x0, x, y, y1}, Box{x, x1, y, y1}}) {
        parts_.push_back({b, pairs});
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

bool DividedBox::grows_along(std::size_t f, std::size_t g, const Eigen::Vector2d& direction) const {
    return grows_along(f, g, direction, Where::Lowest, 0, 0);
}

bool DividedBox::grows_throughout(std::size_t f, std::size_t g, const Eigen::Vector2d& direction) const {
    return grows_along(f, g, direction, Where::Equal, 0, 0);
}

// By what is known of the part around it, by what the two forms do, and last by what takes all of them.
bool DividedBox::grows_along(std::size_t f, std::size_t g, const Eigen::Vector2d& direction, Where where,
                             Part part, int level) const {
    if (where == Where::Lowest && (parts_[part].lowest & pair(f, g)) == 0) return true;
    const Support &a = support(f, part), &b = support(g, part);
    const auto [middle, change] = normals_[part].growth(a, b, direction);
    if (middle > change) return true;
    if (where == Where::Lowest ? (lowest(part) & pair(f, g)) == 0 : !normals_[part].meet(a, b)) return true;
    if (level == levels) return false;
    const Part first = quarter(part);
    for (Part q = first; q < first + 4; ++q)
        if (!grows_along(f, g, direction, where, q, level + 1)) return false;
    return true;
}

// Extends `hull` by the smallest parts in which all of the pairs may be equal and lowest.
void DividedBox::enclose_meeting(Pairs pairs, Part part, int levels_left, Box& hull) const {
    if ((lowest(part) & pairs) != pairs) return;
    if (levels_left == 0) {
        const Box& b = parts_[part].box;
        hull = {std::min(hull[0], b[0]), std::max(hull[1], b[1]), std::min(hull[2], b[2]),
                std::max(hull[3], b[3])};
        return;
    }
    const Part first = quarter(part);
    for (Part q = first; q < first + 4; ++q) enclose_meeting(pairs, q, levels_left - 1, hull);
}

void DividedBox::refine(Meeting& m) const {
    const auto& [f, g, h] = m.forms;
    Box hull{infinity, -infinity, infinity, -infinity};
    m.levels = std::max(m.levels + 1, coarse_levels);
    enclose_meeting(pair(f, g) | pair(f, h) | pair(g, h), 0, m.levels, hull);
    m.box = hull[0] < hull[1] ? std::optional(hull) : std::nullopt;
}

DividedBox::Meeting& DividedBox::find_meeting(std::size_t f, std::size_t g, std::size_t h) const {
    std::array forms{f, g, h};
    std::ranges::sort(forms);
    const auto known = std::ranges::find(meetings_, forms, &Meeting::forms);
    if (known != meetings_.end()) return *known;
    meetings_.push_back({forms});
    refine(meetings_.back());
    return meetings_.back();
}

const std::optional<DividedBox::Box>& DividedBox::meeting(std::size_t f, std::size_t g, std::size_t h) const {
    return find_meeting(f, g, h).box;
}

// In a box as small as it takes.
std::optional<Sign> DividedBox::turn(std::size_t f, std::size_t g, std::size_t h) const {
    for (Meeting& m = find_meeting(f, g, h);; refine(m)) {
        if (!m.box) return Sign::Positive;
        const auto [x0, x1, y0, y1] = *m.box;
        const NormalBox box(x0, x1, y0, y1);
        const Support a = all_.over(forms_[f], box);
        const auto to_g = box.gradient(all_.over(forms_[g], box), a),
                   to_h = box.gradient(all_.over(forms_[h], box), a);
        const auto sign = (to_g[0] * to_h[1] - to_g[1] * to_h[0]).sign();
        if (sign || m.levels == levels) return sign;
    }
}

}  // namespace vcell
