#include "heights.hpp"

#include <cfloat>
#include <cmath>

namespace vcell {

template class NormalsOfSphere<Interval>;
template class NormalsOfSphere<Wide>;
template class RadialNormals<Interval>;
template class RadialNormals<Wide>;

namespace {

// The numbers are doubles where these are exact, of tubes then.
double steep(const CylinderForm& f) { return f.az; }
template <class T>
const T& steep(const CylinderNumbers<T>& f) {
    return f.steep;
}

bool is_level(const CylinderForm& f) { return f.az == 0; }
template <class T>
bool is_level(const CylinderNumbers<T>& f) {
    return f.steep.sign() == Sign::Zero;
}

bool is_cone(const CylinderForm&) { return false; }
template <class T>
bool is_cone(const CylinderNumbers<T>& f) {
    return f.sine.sign() == Sign::Positive;
}

bool is_hollow(const CylinderForm& f) { return f.is_hollow(); }
template <class T>
bool is_hollow(const CylinderNumbers<T>& f) {
    return is_cone(f) || f.rho.sign() == Sign::Negative;
}

// The height 1 / q, where C q^2 - 2 beta q - A = 0. Pre: C > 0; beta > 0 where A = 0.
Wide height_of(const Wide& C, const Wide& beta, const Wide& A, const Wide& root) {
    return beta.sign() == Sign::Positive ? C / (root + beta) : (root - beta) / A;
}
Interval height_of(const Interval& C, const Interval& beta, const Interval& A, const Interval&) {
    return Interval(1.0) / root_range(beta, A, C);
}

// That of a hollow cylinder, whose root has the sign of beta + A r: not positive. Pre: beta < 0 where A = 0.
Wide hollow_height_of(const Wide& C, const Wide& beta, const Wide& A, const Wide& root) {
    return beta.sign() == Sign::Negative ? C / (root + beta) : (root - beta) / A;
}
Interval hollow_height_of(const Interval& C, const Interval& beta, const Interval& A, const Interval& root) {
    const bool is_beside = beta.sign() == Sign::Negative;
    if (!is_beside || A.sign() != Sign::Positive) return is_beside ? C / (root + beta) : (root - beta) / A;
    return narrowed(C / (root + beta), (root - beta) / A);
}

// A cylinder's height, and what its derivatives need. C = |m x a|^2 - S^2 |m|^2 - |a|^2 rho^2: with the cross
// product instead of M |m|^2 - (m . a)^2 nothing cancels far out along the axis.
template <class T>
struct CylinderHeight {
    T mx, my;                // m
    T cx, cy, cz;            // m x a
    T root, v;               // root = beta + A v
    bool is_known;           // certainly outside the trace on the base, or in a hollow cylinder
    bool is_differentiable;  // certainly

    template <class Cylinder>
    CylinderHeight(const Cylinder& f, const CylinderConstants<T>& constants, const T& x, const T& y) {
        mx = x - T(f.px);
        my = y - T(f.py);
        cx = f.az * my + constants.ay_pz;
        cy = -(f.az * mx) - constants.ax_pz;
        cz = f.ay * mx - f.ax * my;
        T C = square(cx) + square(cy) + square(cz) - constants.far;
        const T beta = constants.lift + steep(f) * (f.ax * mx + f.ay * my);
        if (is_hollow(f)) {
            if (is_cone(f)) C -= constants.sine2 * (square(mx) + square(my) + square(T(f.pz)));
            const T D = constants.M * (square(steep(f) * mx + constants.tip * f.ax) +
                                       square(steep(f) * my + constants.tip * f.ay));
            is_known = !is_level(f) || beta.sign() == Sign::Negative;
            is_differentiable = is_known && (is_level(f) || D.sign() == Sign::Positive);
            root = is_level(f) ? beta : -sqrt(D);
            v = is_known ? hollow_height_of(C, beta, constants.A, root) : T::whole();
            return;
        }
        is_known = C.sign() == Sign::Positive && (!is_level(f) || beta.sign() == Sign::Positive);
        const T D = square(beta) + constants.A * C;
        is_known = is_known && D.sign() == Sign::Positive;
        is_differentiable = is_known;
        if (!is_known) {
            root = v = T::whole();
            return;
        }
        root = is_level(f) ? beta : sqrt(D);
        v = height_of(C, beta, constants.A, root);
    }
};

template <class T, class Cylinder>
HeightJet<T> cylinder_jet(const Cylinder& f, const CylinderConstants<T>& constants, const T& x, const T& y) {
    const CylinderHeight<T> h(f, constants, x, y);
    if (!h.is_differentiable) return {h.v, T::whole(), T::whole()};
    // F = C - 2 beta r - A r^2 = 0: r' = (C' - 2 beta' r) / (2 (beta + A r)), and beta + A r is the root.
    if (is_cone(f))
        return {h.v, (f.ay * h.cz - f.az * h.cy - constants.sine2 * h.mx - steep(f) * f.ax * h.v) / h.root,
                (f.az * h.cx - f.ax * h.cz - constants.sine2 * h.my - steep(f) * f.ay * h.v) / h.root};
    return {h.v, (f.ay * h.cz - f.az * (h.cy + f.ax * h.v)) / h.root,
            (f.az * (h.cx - f.ay * h.v) - f.ax * h.cz) / h.root};
}

// The height by doubles, with its gradient.
std::array<double, 3> near_cylinder(const CylinderForm& c, double x, double y) {
    const double mx = x - c.px, my = y - c.py, cx = c.az * my + c.ay * c.pz, cy = -(c.az * mx) - c.ax * c.pz,
                 cz = c.ay * mx - c.ax * my, level = c.ax * c.ax + c.ay * c.ay, norm = level + c.az * c.az,
                 sine2 = c.sine * c.sine, steep = c.steep(), A = steep * steep,
                 C = cx * cx + cy * cy + cz * cz - norm * c.rho * c.rho -
                     sine2 * (mx * mx + my * my + c.pz * c.pz),
                 beta = norm * c.rho + (level + c.sine * steep) * c.pz + steep * (c.ax * mx + c.ay * my),
                 side = c.is_hollow() ? -1 : 1, root = side * std::sqrt(std::max(0.0, beta * beta + A * C)),
                 v = side * beta < 0 ? (root - beta) / A : C / (root + beta);
    return {v, (c.ay * cz - c.az * cy - sine2 * mx - steep * c.ax * v) / root,
            (c.az * cx - c.ax * cz - sine2 * my - steep * c.ay * v) / root};
}

std::optional<double> unit_along_axis(const FormFamily& family) {
    return family.chart.is_cylinder() ? std::optional(family.axial_unit) : std::nullopt;
}

}  // namespace

Heights::Heights(const FormFamily& family) : family_(family) {
    prepared_.reserve(family.size());
    wide_.resize(family.size());
    const auto ball = [](double v) { return Interval::ball(v, 2 * DBL_EPSILON * std::abs(v)); };  // 4 u
    for (const CircularForm& f : family.forms) {
        Prepared p;
        p.a = ball(f.a);
        p.b = ball(f.b);
        p.e = ball(f.e);
        p.inverse_w = Interval(1.0) / ball(f.w);
        prepared_.push_back(p);
    }
    for (const CylinderForm& f : family.cylinders) {
        const auto prepare = [&](const CylinderNumbers<Interval>& cylinder) {
            Prepared p;
            p.cylinder = CylinderConstants<Interval>(cylinder);
            prepared_.push_back(p);
        };
        if (f.exact) {
            turned_.resize(family.size());
            auto& t = turned_[prepared_.size()];
            t = std::make_unique<CylinderNumbers<Interval>>(
                converted<Interval>(*f.exact, [](const Exact& v) { return v.enclosure(); }));
            prepare(*t);
        } else {
            prepare(numbers_of<Interval>(f));
        }
    }
    if (family.radial.empty()) return;
    for (BoxNormals& p : box_normals_)
        p.normals = RadialNormals<Interval>(family.chart, p.x, p.y, family.tips);
    radial_.reserve(family.size());
    wide_radial_.resize(family.size());
    for (const CircularForm& f : family.forms)
        radial_.emplace_back(Interval(f.k), ball(f.a), ball(f.b), ball(f.e), ball(f.w));
    for (const RadialForm& f : family.radial)
        radial_.emplace_back(
            f, [](const Exact& v) { return v.enclosure(); }, family.tips, unit_along_axis(family));
}

const RadialNormals<Interval>& Heights::normals(Interval x, Interval y) const {
    const auto same = [](Interval a, Interval b) { return a.lower() == b.lower() && a.upper() == b.upper(); };
    for (const std::size_t i : {newer_, 1 - newer_})
        if (same(x, box_normals_[i].x) && same(y, box_normals_[i].y)) {
            newer_ = i;
            return box_normals_[i].normals;
        }
    newer_ = 1 - newer_;
    box_normals_[newer_] = {x, y, RadialNormals<Interval>(family_.chart, x, y, family_.tips)};
    return box_normals_[newer_].normals;
}

template <int order>
FunctionJet<Interval> Heights::radial_jet(FormId f, Interval x, Interval y) const {
    return radial_[f.value].jet<order>(normals(x, y));
}

template <int order>
FunctionJet<Wide> Heights::radial_jet(FormId f, const Wide& x, const Wide& y) const {
    ++wide_evaluations_;
    std::unique_ptr<RadialHeight<Wide>>& p = wide_radial_[f.value];
    if (!p && family_.is_circular(f)) {
        const ExactForm e = family_.exact(f);
        p = std::make_unique<RadialHeight<Wide>>(enclosure_of<Wide>(e.K), enclosure_of<Wide>(e.A),
                                                 enclosure_of<Wide>(e.B), enclosure_of<Wide>(e.C),
                                                 enclosure_of<Wide>(e.W));
    } else if (!p) {
        p = std::make_unique<RadialHeight<Wide>>(family_.radial_form(f), enclosure_of<Wide>, family_.tips,
                                                 unit_along_axis(family_));
    }
    return p->jet<order>(RadialNormals<Wide>(family_.chart, x, y, family_.tips));
}

Interval Heights::scale(Interval x, Interval y) const {
    Interval w = family_.compared_over().weight(x, y, family_.chart.is_back(x.mid()));
    if (const auto& tip = family_.tips[AxialEnd::Low]) w = w / (y - Interval(*tip));
    if (const auto& tip = family_.tips[AxialEnd::High]) w = w / (Interval(*tip) - y);
    return w;
}

HeightJet<Interval> Heights::jet(FormId f, Interval x, Interval y) const {
    if (is_radial()) {
        const FunctionJet<Interval> j = radial_jet<1>(f, x, y);
        return {j.v, j.x, j.y};
    }
    const Prepared& p = prepared_[f.value];
    if (const auto* c = turned(f)) return cylinder_jet(*c, p.cylinder, x, y);
    if (!family_.is_circular(f)) return cylinder_jet(family_.cylinder(f), p.cylinder, x, y);
    const CircularForm& form = family_.forms[f];
    const Interval dx = x - Interval(form.cx), dy = y - Interval(form.cy);
    return {value(f, x, y), (2 * form.k * dx + p.a) * p.inverse_w, (2 * form.k * dy + p.b) * p.inverse_w};
}

// Most forms have a = b = 0 or k = 0.
Interval Heights::value(FormId f, Interval x, Interval y) const {
    if (is_radial()) return radial_jet<0>(f, x, y).v;
    const Prepared& p = prepared_[f.value];
    if (const auto* c = turned(f)) return CylinderHeight<Interval>(*c, p.cylinder, x, y).v;
    if (!family_.is_circular(f)) return CylinderHeight<Interval>(family_.cylinder(f), p.cylinder, x, y).v;
    const CircularForm& form = family_.forms[f];
    Interval sum = p.e;
    if (form.k != 0) sum += form.k * (square(x - Interval(form.cx)) + square(y - Interval(form.cy)));
    if (form.a != 0) sum += p.a * x;
    if (form.b != 0) sum += p.b * y;
    return sum * p.inverse_w;
}

const Heights::WidePrepared& Heights::wide(FormId f) const {
    ++wide_evaluations_;
    std::unique_ptr<WidePrepared>& p = wide_[f.value];
    if (p) return *p;
    p = std::make_unique<WidePrepared>();
    if (family_.is_circular(f)) {
        const ExactForm e = family_.exact(f);
        const Wide W = enclosure_of<Wide>(e.W);
        p->coefficients = {enclosure_of<Wide>(e.K) / W, enclosure_of<Wide>(e.A) / W,
                           enclosure_of<Wide>(e.B) / W, enclosure_of<Wide>(e.C) / W};
    } else {
        const CylinderForm& c = family_.cylinder(f);
        if (c.exact)
            p->constants =
                CylinderConstants<Wide>(p->cylinder.emplace(converted<Wide>(*c.exact, enclosure_of<Wide>)));
        else
            p->constants = CylinderConstants<Wide>(numbers_of<Wide>(c));
    }
    return *p;
}

HeightJet<Wide> Heights::jet(FormId f, const Wide& x, const Wide& y) const {
    if (is_radial()) {
        const FunctionJet<Wide> j = radial_jet<1>(f, x, y);
        return {j.v, j.x, j.y};
    }
    const auto& [p, constants, cylinder] = wide(f);
    if (cylinder) return cylinder_jet(*cylinder, constants, x, y);
    if (!family_.is_circular(f)) return cylinder_jet(family_.cylinder(f), constants, x, y);
    const auto& [K, A, B, C] = p;
    const Wide two_K = Wide(2.0) * K;
    return {K * (square(x) + square(y)) + A * x + B * y + C, two_K * x + A, two_K * y + B};
}

Wide Heights::value(FormId f, const Wide& x, const Wide& y) const {
    if (is_radial()) return radial_jet<0>(f, x, y).v;
    const auto& [p, constants, cylinder] = wide(f);
    if (cylinder) return CylinderHeight<Wide>(*cylinder, constants, x, y).v;
    if (!family_.is_circular(f)) return CylinderHeight<Wide>(family_.cylinder(f), constants, x, y).v;
    return p[0] * (square(x) + square(y)) + p[1] * x + p[2] * y + p[3];
}

// The same in doubles.
std::array<double, 3> Heights::near(FormId f, double x, double y) const {
    if (is_radial()) {
        const bool is_back = family_.chart.is_back(x);
        const double t = is_back ? x - 2 : x, m = 2 / (1 + t * t), X = t * m, Z = m - 1;
        auto j = radial_[f.value].near(is_back ? -X : X, is_back ? -Z : Z, m, y);
        // Where heights agree, so do they times the distances from tips, and these grow by the distances'
        // product as much.
        double distances = 1;
        if (const auto& tip = family_.tips[AxialEnd::Low]) distances *= y - *tip;
        if (const auto& tip = family_.tips[AxialEnd::High]) distances *= *tip - y;
        for (double& part : j) part *= distances;
        return j;
    }
    if (family_.is_circular(f)) {
        const CircularForm& c = family_.forms[f];
        const double dx = x - c.cx, dy = y - c.cy;
        return {(c.k * (dx * dx + dy * dy) + c.a * x + c.b * y + c.e) / c.w, (2 * c.k * dx + c.a) / c.w,
                (2 * c.k * dy + c.b) / c.w};
    }
    return near_cylinder(family_.cylinder(f), x, y);
}

Interval Heights::root_at(FormId f, Interval x, Interval y, Interval t) const {
    const CylinderNumbers<Interval> c = cylinder(f);
    const CylinderConstants<Interval>& constants = prepared_[f.value].cylinder;
    return constants.lift + ((x - c.px) * c.ax + (y - c.py) * c.ay) * c.steep + constants.A * t;
}

// Differentiating F = 0 once more: 2 root r_xy = C_xy - 2 beta_x r_y - 2 beta_y r_x - 2 A r_x r_y.
HeightCurvature<Interval> Heights::curvature(FormId f, Interval x, Interval y) const {
    if (is_radial()) {
        const FunctionJet<Interval> j = radial_jet<2>(f, x, y);
        return {j.xx, j.xy, j.yy};
    }
    const Prepared& p = prepared_[f.value];
    const Interval two(2.0);
    if (family_.is_circular(f)) {
        const Interval k = two * Interval(family_.forms[f].k) * p.inverse_w;
        return {k, 0.0, k};
    }
    const CylinderNumbers<Interval> c = cylinder(f);
    const HeightJet<Interval> j = jet(f, x, y);
    const Interval &ax = c.ax, &ay = c.ay, bx = c.steep * ax, by = c.steep * ay;
    const Interval &across = p.cylinder.across, root = root_at(f, x, y, j.v);
    if (root.sign() != (is_hollow(c) ? Sign::Negative : Sign::Positive))
        return {Interval::whole(), Interval::whole(), Interval::whole()};
    const auto second = [&](Interval C, Interval bu, Interval bv, Interval ru, Interval rv) {
        return (C - two * (bu * rv + bv * ru) - two * p.cylinder.A * ru * rv) / (two * root);
    };
    return {second(two * (square(ay) + across), bx, bx, j.gx, j.gx),
            second(-two * ax * ay, bx, by, j.gx, j.gy),
            second(two * (square(ax) + across), by, by, j.gy, j.gy)};
}

void Heights::find_twins() const {
    signatures_.reserve(family_.size());
    for (std::uint32_t f = 0; f < family_.size(); ++f) signatures_.emplace_back(family_, FormId{f});
    have_twins_ = which_have_twins(signatures_);
    are_any_twins_ = std::ranges::find(have_twins_, true) != have_twins_.end();
}

std::optional<FunctionJet<Interval>> Heights::twin_difference(FormId f, FormId g, Interval x,
                                                              Interval y) const {
    if (g < f) {
        const auto reversed = twin_difference(g, f, x, y);
        return reversed ? std::optional(-*reversed) : std::nullopt;
    }
    const std::optional<double> mu = twin_factor(f, g);
    if (!mu) return std::nullopt;
    const auto [it, is_new] = twins_.try_emplace({f, g}, family_, f, g, *mu);
    if (is_radial()) {
        const RadialHeight<Interval>& height = radial_[f.value];
        const RadialNormals<Interval>& n = normals(x, y);
        return height.with_tips(it->second.over(height.plain_jet<2>(n), n), n);
    }
    const auto [v, gx, gy] = jet(f, x, y);
    const auto [xx, xy, yy] = curvature(f, x, y);
    return it->second.over({v, gx, gy, xx, xy, yy}, x, y);
}

Interval Heights::value_difference(FormId f, FormId g, Interval x, Interval y) const {
    const Interval d = value(f, x, y) - value(g, x, y);
    if (d.sign()) return d;
    const auto twins = twin_difference(f, g, x, y);
    return twins ? narrowed(d, twins->v) : d;
}

HeightJet<Interval> Heights::difference(FormId f, FormId g, Interval x, Interval y) const {
    const HeightJet<Interval> a = jet(f, x, y), b = jet(g, x, y), d{a.v - b.v, a.gx - b.gx, a.gy - b.gy};
    const auto twins = twin_difference(f, g, x, y);
    if (!twins) return d;
    return {narrowed(d.v, twins->v), narrowed(d.gx, twins->x), narrowed(d.gy, twins->y)};
}

HeightJet<Wide> Heights::difference(FormId f, FormId g, const Wide& x, const Wide& y) const {
    const HeightJet<Wide> a = jet(f, x, y), b = jet(g, x, y);
    return {a.v - b.v, a.gx - b.gx, a.gy - b.gy};
}

HeightCurvature<Interval> Heights::curvature_difference(FormId f, FormId g, Interval x, Interval y) const {
    const HeightCurvature<Interval> d = curvature(f, x, y) - curvature(g, x, y);
    const auto twins = twin_difference(f, g, x, y);
    if (!twins) return d;
    return {narrowed(d.xx, twins->xx), narrowed(d.xy, twins->xy), narrowed(d.yy, twins->yy)};
}

std::array<Interval, 2> Heights::gradient_difference(FormId f, FormId g, Interval x, Interval y) const {
    const Interval mx(x.mid()), my(y.mid());
    const HeightJet<Interval> d = difference(f, g, x, y), middle = difference(f, g, mx, my);
    return refined_gradient({d.gx, d.gy}, {middle.gx, middle.gy}, curvature_difference(f, g, x, y), x - mx,
                            y - my);
}

Wide Heights::plain_value(FormId f, const Wide& x, const Wide& y) const {
    radial_jet<0>(f, x, y);  // makes the wide form
    return wide_radial_[f.value]->plain_jet<0>(RadialNormals<Wide>(family_.chart, x, y)).v;
}

HeightJet<Interval> Heights::plain_jet(FormId f, Interval x, Interval y) const {
    const FunctionJet<Interval> j = radial_[f.value].plain_jet<1>(normals(x, y));
    return {j.v, j.x, j.y};
}

Heights::PlainGradient Heights::plain_gradient(FormId f, Interval x, Interval y) const {
    const HeightJet<Interval> middle = plain_jet(f, x.mid(), y.mid());
    const FunctionJet<Interval> over = radial_[f.value].plain_jet<2>(normals(x, y));
    return {{over.x, over.y}, {middle.gx, middle.gy}, {over.xx, over.xy, over.yy}};
}

std::array<Interval, 2> Heights::difference(const PlainGradient& f, const PlainGradient& g, Interval x,
                                            Interval y) {
    return refined_gradient({f.over[0] - g.over[0], f.over[1] - g.over[1]},
                            {f.middle[0] - g.middle[0], f.middle[1] - g.middle[1]}, f.curvature - g.curvature,
                            x - Interval(x.mid()), y - Interval(y.mid()));
}

Sign Heights::compare(FormId f, FormId g, double x, double y, Decisions& decisions) const {
    if (const auto s = value_difference(f, g, Interval(x), Interval(y)).sign()) {
        ++decisions.by_interval;
        return *s;
    }
    return compare(f, g, RationalPoint{x, y}, decisions);
}

Sign Heights::compare(FormId f, FormId g, const RationalPoint& p, Decisions& decisions) const {
    ++decisions.by_exact;
    return compare_exactly(family_, f, g, p);
}

}  // namespace vcell
