#include "integrals.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "conics.hpp"
#include "face_terms.hpp"
#include "triads.hpp"

namespace vcell::check {

namespace {

std::vector<Outline> outlines(const Cell& cell, const Frame& frame,
                              const std::vector<std::vector<EdgeUse>>& uses) {
    std::vector<Outline> outlines(cell.faces.size());
    for (std::size_t e = 0; e < uses.size(); ++e) {
        const RationalCurve3& curve = cell.edges[e].curve;
        for (std::size_t k = 0; k < curve.points.size() && !uses[e].empty(); ++k) {
            const Triad<double> p = frame.about(curve.points[k].head<3>());
            const bool is_joint = k % static_cast<std::size_t>(curve.degree) == 0;  // of Bezier pieces
            for (const EdgeUse& use : uses[e]) {
                outlines[use.face].controls.push_back(p);
                if (is_joint) outlines[use.face].points.push_back(p);
            }
        }
    }
    return outlines;
}

template <class T>
T speed(const Place<T>& p) {
    T sum(0.0);
    for (std::size_t i = 0; i < 3; ++i) sum = sum + square(p.dn[i] * p.w - p.n[i] * p.dw);
    return sqrt(sum) / square(p.w);
}

/// Over a rectangle, in `effort` parts at most.
template <std::size_t N, class F>
std::array<Interval, N> estimated(const std::array<double, N>& enough, int effort, const F& section) {
    std::array<Interval, N> sum{};
    Effort left{effort};
    const bool is_complete = estimate<N>(section, {-1, 0}, {1, 1}, enough, sum, left);
    // Where the rules never came near each other their difference tells little: beside a pole both
    // miss most of it.
    constexpr double poor = 0x1p-16, wider = 16;
    if (!is_complete)
        for (Interval& x : sum) x = Interval::ball(x.mid(), wider * x.radius());
    const bool is_poor =
        std::ranges::any_of(sum, [&](const Interval& x) { return !(x.radius() <= poor * x.magnitude()); });
    if (!is_complete && is_poor) sum.fill(Interval(-HUGE_VAL, HUGE_VAL));
    return sum;
}

/// A face without edges is all of a spheroid about a ball's centre, in a hollow sphere: with D the sum of
/// the radii and c the way between the centres t = (D^2 - |c|^2) / (2 b), b = D + |c| z, where z is the
/// cosine of the angle to -c, and sqrt(|c|^2 - D^2 + 2 D b) / b the area for that about the ball.
std::optional<FaceIntegrals> spheroid(const Scene& scene, const Frame& frame, const Site& site,
                                      const std::array<double, 2>& enough, int effort) {
    const auto* vessel = site.is_object() ? std::get_if<HollowSphere>(&scene.objects[site.index]) : nullptr;
    if (!vessel || !std::holds_alternative<Sphere>(scene.base)) return std::nullopt;
    const MidRad c = sqrt(squared_norm(near(frame.point(vessel->center)))),
                 D = MidRad(frame.length(vessel->radius)) + frame.radius(), K = 0.5 * ((D - c) * (D + c));
    if (!(K.lower() > 0)) return std::nullopt;
    std::array<Interval, 2> sum{};
    Effort left{16 * effort};
    const bool is_told = integrate<2>(
        [&]<class T>(const T& z) {
            const T b = T(D) + c * z, t = T(K) / b, t2 = square(t);
            const T steepness = sqrt(T(square(c) + square(D)) + 2.0 * (D * c) * z) / b;
            return std::array<T, 2>{t * t2 * T(third), t2 * steepness};
        },
        -1, 1, enough, sum, left);
    const Interval turn = 2.0 * Interval(std::numbers::pi, std::nextafter(std::numbers::pi, 4));
    return FaceIntegrals{turn * sum[0], turn * sum[1], 2.0 * turn, is_told, true};
}

/// Volume and area of what lies between a start along the wall and a tip, all around the vessel's axis:
/// proved to the precision if there is one, otherwise estimated to `enough`.
std::array<Interval, 2> until_tip(const Equation& equation, const MidRad& start, std::size_t tip,
                                  const std::optional<Precision>& precision,
                                  const std::array<double, 2>& enough, int effort) {
    // Half around at once: whatever the effort, as without it nothing of the face is known.
    constexpr int least_parts = 1024;
    const int parts = std::max(effort, least_parts);
    const MidRad end = equation.cosine * dot(equation.d, VesselTips(equation).points[tip]);
    std::array<Interval, 2> all{};
    for (const bool is_opposite : {false, true}) {
        const auto density = [&]<class T>(const T& s) {
            return [section = VesselSection<T>(equation, start, end, is_opposite, s)](const T& sigma) {
                const auto [volume, area, steepness] = section.at(sigma);
                return std::array<T, 2>{volume, area};
            };
        };
        std::array<Interval, 2> sum{};
        Effort left{parts};
        if (precision)
            integrate<2>(density, {-1, 0}, {1, 1}, {precision->volume, precision->area}, sum, left);
        else
            sum = estimated<2>(enough, parts, density);
        // A face beside an edge lies beyond it, or between the start and the first tip.
        for (const std::size_t k : {0, 1}) all[k] = tip == 0 ? all[k] + sum[k] : all[k] - sum[k];
    }
    return all;
}

/// Which tips a face holds whose edges turn around the axis as often, and of which so much area lies between
/// the edges and the start: they turn once around one of the two; around both they leave less than nothing,
/// as all of the bisector is more than the face. None: it cannot be told.
std::optional<std::array<bool, 2>> held_tips(const Interval& turn, const Interval& area) {
    constexpr double whole = 2 * std::numbers::pi, less_than_half = 3;
    if ((turn - whole).magnitude() < less_than_half) return std::array{false, true};
    if ((turn + whole).magnitude() < less_than_half) return std::array{true, false};
    if (!(turn.magnitude() < less_than_half)) return std::nullopt;
    if (area.lower() > 0) return std::array{false, false};
    if (area.upper() < 0) return std::array{true, true};
    return std::nullopt;
}

/// The shadow's area for each area beside a span, at most.
double shadow_of_area(const Object& base, const Span& span) {
    if (std::holds_alternative<Plane>(base)) return 1;
    const bool is_sphere = std::holds_alternative<Sphere>(base);
    const Place<MidRad> place = span.at(MidRad::ball(0, 1));
    const Triad<MidRad> p = place.whole();
    const MidRad off = square(p[0]) + square(p[1]) + (is_sphere ? square(p[2]) : MidRad(0.0));
    const double squared = std::max(0.0, (off / square(place.w)).lower());
    return 1 / (is_sphere ? squared : std::sqrt(squared));
}

/// Under a plane's rim a wall as high as the edge, which begins at that height where rays come in there;
/// at a cylinder's end the disc sector below it.
Interval side_beside(const Cell& cell, std::size_t e, const EdgeUse& use, const Span& span, double enough,
                     int parts) {
    std::array<Interval, 1> sum{};
    Effort effort{parts};
    if (std::holds_alternative<Plane>(cell.scene.base)) {
        // The shadow is straight: its length is the way along its chord.
        const Place<MidRad> a = span.at(MidRad(-1.0)), b = span.at(MidRad(1.0));
        const MidRad x = b.n[0] / b.w - a.n[0] / a.w, y = b.n[1] / b.w - a.n[1] / a.w, z = span.origin[2];
        const MidRad chord = sqrt(square(x) + square(y));
        if (!(chord.lower() > 0)) {
            const Interval height =
                z.enclosure() + hull((a.n[2] / a.w).enclosure(), (b.n[2] / b.w).enclosure());
            const Interval wall = chord.enclosure() * height;
            return use.is_entered ? -wall : wall;
        }
        const MidRad share = MidRad(1.0) / chord;
        integrate<1>(
            [&]<class T>(const T& s) {
                const Place<T> p = span.at(s);
                const T dx = (p.dn[0] * p.w - p.n[0] * p.dw), dy = (p.dn[1] * p.w - p.n[1] * p.dw);
                return std::array<T, 1>{(T(z) + p.n[2] / p.w) * (x * dx + y * dy) * T(share) / square(p.w)};
            },
            -1, 1, {enough}, sum, effort);
        return use.is_entered ? -sum[0] : sum[0];
    }
    integrate<1>(
        [&]<class T>(const T& s) {
            const Place<T> p = span.at(s);
            const Triad<T> n = p.whole(), dn = p.whole_derivative();
            return std::array<T, 1>{0.5 * (n[0] * dn[1] - n[1] * dn[0]) / square(p.w)};
        },
        -1, 1, {enough}, sum, effort);
    // The face is on the left: around the lower end it runs with the angle, around the upper against it.
    const bool is_upper = std::ranges::find(cell.edges[e].sites, Site::end(1)) != cell.edges[e].sites.end();
    const bool with_angle = is_upper == use.reversed;
    return with_angle ? sum[0] : -sum[0];
}

/// What both faces beside a conic take, and its length.
struct AlongConic {
    const Conic& conic;
    const std::array<std::optional<Conic::Integrand>, 2>& integrands;

    template <class T>
    std::array<T, 7> operator()(const T& s) const {
        const auto p = conic.at(s);
        std::array<T, 7> values{};
        for (std::size_t k = 0; k < 2; ++k)
            if (integrands[k]) std::ranges::copy(densities(*integrands[k], s, p), values.begin() + 3 * k);
        values[6] = p.speed;
        return values;
    }
    bool is_singular(const Disc& s) const { return conic.is_speed_singular(s); }
};

class Summation {
public:
    Summation(const Cell& cell, const Frame& frame, const std::vector<std::vector<EdgeUse>>& uses,
              const std::vector<EdgeBand>& bands, const std::array<double, 3>& enough, int effort,
              std::span<const std::optional<Precision>> proofs)
        : cell_(cell), frame_(frame), uses_(uses), bands_(bands), effort_(effort), proofs_(proofs) {
        sums_.faces.resize(cell.faces.size());
        sums_.slack.resize(cell.faces.size());
        sums_.lengths.resize(cell.edges.size());
        turns_.resize(cell.faces.size(), 0.0);
        outlined_ = outlines(cell, frame, uses);
        for (std::size_t f = 0; f < cell.faces.size(); ++f) {
            shadows_.push_back(shadow(cell.scene, frame, cell.faces[f].site, outlined_[f]));
            sums_.faces[f].is_known = shadows_.back().has_value();
        }
        // Shares of what may be missed: of each piece on either side, two units wide; of all together a
        // sixteenth.
        std::size_t pieces = 1;
        for (const CellEdge& edge : cell.edges)
            pieces += edge.curve.points.size() / static_cast<std::size_t>(edge.curve.degree);
        share_ = 1 / (64.0 * static_cast<double>(pieces));
        for (std::size_t i = 0; i < 3; ++i) enough_[i] = share_ * enough[i];
        // Shadows of the whole base are about as large as the unit.
        enough_of_shadows_ = 0x1p-24 * share_;
    }

    Integrals run() {
        for (std::size_t f = 0; f < cell_.faces.size(); ++f)
            if (outlined_[f].points.empty()) add_closed(f);
        for (std::size_t e = 0; e < cell_.edges.size(); ++e) add_edge(e);
        for (std::size_t f = 0; f < turns_.size(); ++f) {
            add_held_tips(f);
            add_held_pole(f);
            add_by_fan(f);
        }
        return std::move(sums_);
    }

private:
    /// The face's form where it is part of a spheroid.
    const Revolved* closed(std::size_t f) const {
        const auto* r = shadows_[f] ? std::get_if<Revolved>(&*shadows_[f]) : nullptr;
        return r && r->start ? r : nullptr;
    }
    /// A face without edges: all of a spheroid, or of the bisector in a hollow tube or cone.
    void add_closed(std::size_t f) {
        const Scene& scene = cell_.scene;
        const Site& site = cell_.faces[f].site;
        if (const auto whole = spheroid(scene, frame_, site, {enough_[0], enough_[1]}, effort_))
            sums_.faces[f] = *whole;
        const auto equation = equation_of(scene, frame_, site, {});
        if (!std::holds_alternative<Sphere>(scene.base) || !equation || !equation->is_hollow ||
            equation->kind == Equation::Kind::ball)
            return;
        const VesselTips tips(*equation);
        const MidRad start =
            0.5 * (along_wall(*equation, tips.points[0]) + along_wall(*equation, tips.points[1])).mid();
        const Interval pi(std::numbers::pi, std::nextafter(std::numbers::pi, 4));
        sums_.faces[f] = {0.0, 0.0, 4.0 * pi, true, true};
        for (const std::size_t tip : {0, 1}) add_tip(f, *equation, start, tip);
    }

    /// A face that holds tips has what lies around them besides what lies between its edges.
    void add_held_tips(std::size_t f) {
        const auto* fan = shadows_[f] ? std::get_if<Fan>(&*shadows_[f]) : nullptr;
        if (!fan || !fan->along_wall) return;
        const auto holds = held_tips(turns_[f], sums_.faces[f].area);
        if (!holds) sums_.faces[f].is_known = false;
        for (const std::size_t tip : {0, 1})
            if (holds && (*holds)[tip]) add_tip(f, fan->equation, *fan->along_wall, tip);
    }
    /// A face in a hollow sphere that has the end of the axis where integrals are singular lacks all of the
    /// spheroid: its solid angle from there is less by all of it than that from where nothing is lacking.
    void add_held_pole(std::size_t f) {
        if (!closed(f)) return;
        constexpr double whole = 4 * std::numbers::pi, less_than_half = 6;
        FaceIntegrals& face = sums_.faces[f];
        const Interval lacking = face.shadow - turns_[f];
        if (lacking.magnitude() < less_than_half) return;
        std::optional<FaceIntegrals> all;
        if ((lacking - whole).magnitude() < less_than_half)
            all = spheroid(cell_.scene, frame_, cell_.faces[f].site, {enough_[0], enough_[1]}, effort_);
        const Interval unknown(-HUGE_VAL, HUGE_VAL);
        face.volume = all ? face.volume + all->volume : unknown;
        face.area = all ? face.area + all->area : unknown;
    }
    /// What edges next to where integrals are singular left unknown is integrated from the start instead.
    void add_by_fan(std::size_t f) {
        constexpr double poor = 0x1p-16;
        FaceIntegrals& face = sums_.faces[f];
        const Revolved* r = closed(f);
        const auto is_told = [](const Interval& x) {
            return x.radius() < HUGE_VAL && x.radius() <= poor * x.magnitude();
        };
        if (!r || (is_told(face.area) && is_told(face.volume))) return;
        const auto equation = equation_of(cell_.scene, frame_, cell_.faces[f].site, {});
        const Fan fan{Fan::Base::sphere, *equation, *r->start};
        face = {};
        for (std::size_t e = 0; e < uses_.size(); ++e)
            for (const EdgeUse& use : uses_[e])
                if (use.face == f)
                    for (const Span& span : spans(cell_.edges[e].curve, frame_)) {
                        add_fan(e, use, fan, span);
                        add_shadow(e, use, fan, span);
                    }
    }
    void add_tip(std::size_t f, const Equation& equation, const MidRad& start, std::size_t tip) {
        FaceIntegrals& face = sums_.faces[f];
        face.is_proved = face.is_proved && proofs_[f].has_value();
        std::optional<Precision> precision = proofs_[f];
        if (precision) precision = Precision{share_ * precision->volume, share_ * precision->area};
        const auto [volume, area] =
            until_tip(equation, start, tip, precision, {enough_[0], enough_[1]}, effort_);
        face.volume += volume;
        face.area += area;
    }

    void add_edge(std::size_t e) {
        for (const Span& span : spans(cell_.edges[e].curve, frame_)) {
            std::array<const Shadow*, 2> direct{};
            for (std::size_t k = 0; k < uses_[e].size(); ++k) {
                const auto& shadow = shadows_[uses_[e][k].face];
                if (!shadow) continue;
                const auto* fan = std::get_if<Fan>(&*shadow);
                if (fan) add_fan(e, uses_[e][k], *fan, span);
                if (const auto* r = closed(uses_[e][k].face)) {
                    add_around(uses_[e][k], *shadow, *r, span);
                    continue;
                }
                // A fan gives its shadow here, in one go with the other face beside a spline: evaluating that
                // is what takes time.
                if (k < 2 && (!fan || span.degree() > 2))
                    direct[k] = &*shadow;
                else if (fan)
                    add_shadow(e, uses_[e][k], *fan, span);
            }
            const bool is_direct = direct[0] || direct[1];
            const Interval length = !is_direct           ? length_of(span)
                                    : span.degree() <= 2 ? add_conic(e, direct, span)
                                                         : add_direct(e, direct, span);
            sums_.lengths[e] += length;
            add_slack(e, span, length);
            if (uses_[e].size() == 1)
                sums_.sides += side_beside(cell_, e, uses_[e][0], span, enough_[1], effort_);
        }
    }

    /// The errors that volume, area and shadow beside a span may have where they are estimated: a part of
    /// what the edge's error may change, and for the volume as much as the blur that it is judged with.
    std::array<double, 3> enough_for_estimates(std::size_t e, const Span& span) const {
        constexpr double of_slack = 0x1p-5, of_blur = 32;
        const auto& c = span.coefficients;
        const double w = c[0][3].mid();
        double half_chord = 0;  // about
        for (std::size_t i = 0; i < 3; ++i)
            half_chord += std::abs(c[1][i].mid() - c[0][i].mid() * (c[1][3].mid() / w));
        const double left = of_slack * bands_[e].error * (half_chord / w);
        return {of_blur * enough_[0], std::max(enough_[1], left),
                std::max(enough_[1], std::min(enough_of_shadows_, left))};
    }

    Interval length_of(const Span& span) {
        std::array<Interval, 1> sum{};
        Effort effort{effort_};
        integrate<1>([&]<class T>(const T& s) { return std::array<T, 1>{speed(span.at(s))}; }, -1, 1,
                     {enough_[2]}, sum, effort);
        return sum[0];
    }

    /// Faces on both sides whose integrands need no start, and the length, at one go. Returns the length.
    template <class F>
    Interval add_both(std::size_t e, const std::array<const Shadow*, 2>& shadows, const Span& span,
                      const F& f, std::size_t& ellipse) {
        std::array<Interval, 7> sum{};
        const auto of_shadow = [&](std::size_t k) {
            return shadows[k] && std::holds_alternative<Fan>(*shadows[k]) ? enough_of_shadows_ : enough_[1];
        };
        const std::array<double, 7> enough{enough_[0], enough_[1],   of_shadow(0), enough_[0],
                                           enough_[1], of_shadow(1), enough_[2]};
        // In one variable parts cost little; an edge that comes close to an apex or an axis needs many.
        Effort effort{16 * effort_, 0, ellipse};
        const bool is_complete = integrate<7>(f, -1, 1, enough, sum, effort);
        ellipse = effort.ellipse;
        for (std::size_t k = 0; k < 2; ++k) {
            if (!shadows[k]) continue;
            if (const auto* fan = std::get_if<Fan>(shadows[k]); fan && !is_complete)
                add_shadow(e, uses_[e][k], *fan, span);
            else
                add(uses_[e][k], sum[3 * k], sum[3 * k + 1], sum[3 * k + 2]);
        }
        // The length may be within reach where faces are not.
        return is_complete ? sum[6] : length_of(span);
    }

    Interval add_direct(std::size_t e, const std::array<const Shadow*, 2>& shadows, const Span& span) {
        std::array<const Revolved*, 2> revolved{};
        std::array<SmallVector<MidRad, 6>, 2> along_axis;
        for (std::size_t k = 0; k < 2; ++k) {
            if (shadows[k]) revolved[k] = std::get_if<Revolved>(shadows[k]);
            if (revolved[k]) along_axis[k] = span.along(revolved[k]->axis);
        }
        const auto along = [&]<class T>(const T& s) {
            const Place<T> p = span.at(s);
            std::array<T, 7> values{};
            for (std::size_t k = 0; k < 2; ++k) {
                if (!shadows[k]) continue;
                const Densities<T> d = revolved[k] ? densities(*revolved[k], p, polynomial(along_axis[k], s))
                                                   : densities(*shadows[k], p);
                values[3 * k] = d.volume;
                values[3 * k + 1] = d.area;
                values[3 * k + 2] = d.shadow;
            }
            values[6] = speed(p);
            return values;
        };
        return add_both(e, shadows, span, along, ellipse_);
    }

    Interval add_conic(std::size_t e, const std::array<const Shadow*, 2>& shadows, const Span& span) {
        if (const auto length = add_segment(e, shadows, span)) return *length;
        const Conic conic(span, std::holds_alternative<Sphere>(cell_.scene.base));
        std::array<std::optional<Conic::Integrand>, 2> integrands;
        for (std::size_t k = 0; k < 2; ++k) {
            if (!shadows[k]) continue;
            integrands[k] = conic.integrand(*shadows[k]);
            if (!integrands[k]) return add_direct(e, shadows, span);
        }
        std::size_t ellipse = first_ellipse;
        return add_both(e, shadows, span, AlongConic{conic, integrands}, ellipse);
    }

    /// None: it takes rules.
    std::optional<Interval> add_segment(std::size_t e, const std::array<const Shadow*, 2>& shadows,
                                        const Span& span) {
        if (span.degree() != 1 || !std::holds_alternative<Sphere>(cell_.scene.base)) return std::nullopt;
        const Segment segment(span);
        std::array<std::optional<std::array<MidRad, 3>>, 2> beside;
        for (std::size_t k = 0; k < 2; ++k) {
            if (!shadows[k]) continue;
            beside[k] = segment.beside(*shadows[k]);
            if (!beside[k]) return std::nullopt;
        }
        for (std::size_t k = 0; k < 2; ++k)
            if (beside[k]) {
                const auto& [volume, area, shadow] = *beside[k];
                add(uses_[e][k], volume.enclosure(), area.enclosure(), shadow.enclosure());
            }
        return segment.length().enclosure();
    }

    /// What of a turn is known to less than a whole one in all tells it: whatever the effort, as without it
    /// nothing is known.
    template <class F>
    void add_turn(const EdgeUse& use, const Span& span, const F& density) {
        constexpr int parts = 1024;
        std::array<Interval, 1> turn{};
        Effort effort{parts};
        integrate<1>([&]<class T>(const T& s) { return std::array<T, 1>{density(span.at(s))}; }, -1, 1,
                     {32 * share_}, turn, effort);
        Interval& sum = turns_[use.face];
        sum = use.reversed ? sum - turn[0] : sum + turn[0];
    }

    /// Around a ball in a hollow sphere.
    void add_around(const EdgeUse& use, const Shadow& shadow, const Revolved& r, const Span& span) {
        add_turn(use, span, [&](const auto& p) { return solid_angle(r.axis, p); });
        const std::array<double, 3> enough{enough_[0], enough_[1], enough_of_shadows_};
        std::array<Interval, 3> sum{};
        Effort effort{16 * effort_};
        std::optional<Conic> conic;
        std::optional<Conic::Integrand> integrand;
        if (span.degree() <= 2) integrand = conic.emplace(span, true).integrand(shadow);
        if (integrand)
            integrate<3>([&]<class T>(const T& s) { return densities(*integrand, s, conic->at(s)); }, -1, 1,
                         enough, sum, effort);
        else
            integrate<3>(
                [&]<class T>(const T& s) {
                    const Densities<T> d = densities(shadow, span.at(s));
                    return std::array<T, 3>{d.volume, d.area, d.shadow};
                },
                -1, 1, enough, sum, effort);
        add(use, sum[0], sum[1], sum[2]);
    }

    /// What takes two variables.
    void add_fan(std::size_t e, const EdgeUse& use, const Fan& fan, const Span& span) {
        if (fan.along_wall)
            add_turn(use, span,
                     [tips = VesselTips(fan.equation)](const auto& p) { return turn_between(tips, p); });
        std::array<Interval, 2> sum{};
        const auto density = [&]<class T>(const T& s) {
            return [section = FanSection<T>(fan, span.at(s))](const T& sigma) {
                const Densities<T> d = section.at(sigma);
                return std::array<T, 2>{d.volume, d.area};
            };
        };
        if (const auto& precision = proofs_[use.face]) {
            Effort effort{effort_};
            integrate<2>(density, {-1, 0}, {1, 1}, {share_ * precision->volume, share_ * precision->area},
                         sum, effort);
        } else {
            sums_.faces[use.face].is_proved = false;
            const auto [volume, area, of_shadow] = enough_for_estimates(e, span);
            sum = estimated<2>({volume, area}, 16 * effort_, density);
        }
        add(use, sum[0], sum[1], 0.0);
    }

    /// Shadows take one variable. They tell how often faces stand over the base.
    void add_shadow(std::size_t e, const EdgeUse& use, const Fan& fan, const Span& span) {
        std::array<Interval, 1> shadow{};
        Effort effort{16 * effort_};
        const bool is_told = integrate<1>(
            [&]<class T>(const T& s) { return std::array<T, 1>{FanSection<T>(fan, span.at(s)).shadow()}; },
            -1, 1, {enough_of_shadows_}, shadow, effort);
        if (!is_told && !proofs_[use.face]) {
            sums_.are_shadows_proved = false;
            shadow = estimated<1>({enough_for_estimates(e, span)[2]}, effort_, [&](const Approximate& s) {
                return [all = FanSection<Approximate>(fan, span.at(s)).shadow()](const Approximate&) {
                    return std::array<Approximate, 1>{all};
                };
            });
        }
        add(use, 0.0, 0.0, shadow[0]);
    }

    void add(const EdgeUse& use, Interval volume, Interval area, Interval shadow) {
        FaceIntegrals& face = sums_.faces[use.face];
        face.volume = use.reversed ? face.volume - volume : face.volume + volume;
        // Around a cylinder sides are measured in their planes, as seen from outside: flat().
        const bool is_turned = use.is_entered && std::holds_alternative<Plane>(cell_.scene.base);
        face.area = use.reversed != is_turned ? face.area - area : face.area + area;
        face.shadow = use.reversed ? face.shadow - shadow : face.shadow + shadow;
    }

    double steepness(const EdgeUse& use, const Span& span, const MidRad& s) const {
        const auto& shadow = shadows_[use.face];
        if (!shadow) return HUGE_VAL;
        return check::steepness(*shadow, span.at(s)).magnitude();
    }

    /// The greatest all along a span. Over wide intervals bounds may be far too large: parts tell then.
    double steepest(const EdgeUse& use, const Span& span) const {
        constexpr int most_parts = 8;
        const double enough = 4 * steepness(use, span, 0.0);
        double most = HUGE_VAL;
        for (int parts = 1; parts <= most_parts && !(most <= enough); parts *= 2) {
            most = 0;
            for (int k = 0; k < parts && most < HUGE_VAL; ++k) {
                const double part =
                    steepness(use, span, MidRad::ball((2 * k + 1 - parts) / double(parts), 1.0 / parts));
                if (!(part <= most)) most = part;
            }
        }
        return most;
    }

    // In the band beside an edge that is off by e the other face may be the true one: that changes areas by
    // the band's times the steepness of both, and volumes by the band's times how far the faces part in it,
    // at most e times their slopes.
    void add_slack(std::size_t e, const Span& span, Interval length) {
        double steep = 0;
        for (const EdgeUse& use : uses_[e]) {
            const auto& shadow = shadows_[use.face];
            const bool has_plane = shadow && is_over_plane(*shadow);
            double s = cell_.faces[use.face].site.is_object() && !has_plane ? bands_[e].steepness : HUGE_VAL;
            if (!std::isfinite(s)) s = steepest(use, span);
            if (!std::isfinite(s))
                s = 2 * std::max({steepness(use, span, -1.0), steepness(use, span, 0.0),
                                  steepness(use, span, 1.0)});
            steep += s;
        }
        const double band = bands_[e].error * length.upper();
        const double area = band * steep, volume = bands_[e].error * area,
                     shadow = band * shadow_of_area(cell_.scene.base, span);
        for (const EdgeUse& use : uses_[e]) {
            sums_.slack[use.face].area += area;
            sums_.slack[use.face].volume += volume;
            sums_.slack[use.face].shadow += shadow;
        }
        sums_.total.area += area;
        sums_.total.volume += volume;
    }

    const Cell& cell_;
    const Frame& frame_;
    const std::vector<std::vector<EdgeUse>>& uses_;
    const std::vector<EdgeBand>& bands_;
    int effort_;
    std::span<const std::optional<Precision>> proofs_;
    double share_;
    std::array<double, 3> enough_;
    double enough_of_shadows_;
    std::size_t ellipse_ = first_ellipse;  // that was enough last
    std::vector<std::optional<Shadow>> shadows_;
    std::vector<Outline> outlined_;  // by face
    std::vector<Interval> turns_;    // about vessels' axes, or solid angles, by face
    Integrals sums_;
};

}  // namespace

Integrals integrate_faces(const Cell& cell, const Frame& frame, const std::vector<std::vector<EdgeUse>>& uses,
                          const std::vector<EdgeBand>& bands, const std::array<double, 3>& enough, int effort,
                          std::span<const std::optional<Precision>> proofs) {
    return Summation(cell, frame, uses, bands, enough, effort, proofs).run();
}

}  // namespace vcell::check
