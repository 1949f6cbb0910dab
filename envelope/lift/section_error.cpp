#include "section_error.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <queue>
#include <vector>

#include "../../core/curves/scaled_bernstein.hpp"
#include "../diagram/chart_arc.hpp"
#include "longest_first.hpp"

namespace vcell {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

using roundoff::u;

// Rounding of a residual or gradient, in units of u times the magnitudes that enter it: some twenty
// operations, and coefficients within 4u.
constexpr double section_rounding = 32 * u;

// A height with its derivatives; the Hessian is bend bend^T + round I.
struct HeightJet2 {
    double value;
    Vector2d gradient, bend;
    double round;
    double gradient_error;  // rounding
};

template <int N>
struct Homogeneous {
    Bernstein<N> X, Y, Z, W;
};

class Side {
public:
    explicit Side(const ArcSide& side) : side_(side) {}

    HeightJet2 operator()(const Vector2d& p) const {
        if (side_.circular) {
            const CircularForm& f = *side_.circular;
            const Vector2d g = gradient(f, p);
            const double size =
                (2 * f.k * (p - Vector2d(f.cx, f.cy)).norm() + std::abs(f.a) + std::abs(f.b)) / f.w;
            return {f(p.x(), p.y()), g, Vector2d::Zero(), 2 * f.k / f.w, section_rounding * size};
        }
        const CylinderHeight& f = side_.cylinder->height();
        const CylinderHeight::Jet jet = f(p);
        const Vector2d across(-jet.v.y(), jet.v.x());
        const double size =
            (p - f.point().head<2>()).norm() + std::abs(f.point().z()) + jet.value + f.reach();
        return {jet.value, jet.gradient, across / (jet.s * std::sqrt(jet.s)), 0,
                section_rounding * size / jet.s};
    }

    // How far the gradient may be from that of `at`, the jet at p, within `room` of the hull of the points. A
    // cylinder's is (V / s - d) / d_z: it turns with V = V(p) + d_z (q - p) alone, by no more than d_z a / (s
    // + d_z l) from p to q, a and l being the parts of q - p across and along V(p). So it is no farther away
    // than a / (s + d_z l): next to nothing along the axis, however sharply the height bends across.
    template <std::size_t N>
    double variation(const HeightJet2& at, const Vector2d& p, const std::array<Vector2d, N>& points,
                     double room) const {
        double reach = 0, across = 0, behind = 0;
        const Vector2d bend = side_.circular ? at.bend : Vector2d(at.bend.normalized()),
                       along(bend.y(), -bend.x());
        for (const Vector2d& q : points) {
            reach = std::max(reach, (q - p).norm());
            across = std::max(across, std::abs(bend.dot(q - p)));
            behind = std::max(behind, -along.dot(q - p));
        }
        reach += room;
        if (side_.circular) return at.gradient_error + at.round * reach;
        const double s = 1 / at.bend.squaredNorm(), doubt = at.gradient_error;
        const double least =
            s * (1 - doubt) - side_.cylinder->height().axis().z() * (behind + doubt * reach + room);
        return least > 0 ? doubt + (across + doubt * reach + room) / least
                         : std::numeric_limits<double>::infinity();
    }

    // Step 1: |z - f(p)| along a rational curve (X, Y, Z) / W, everything times W^2; infinite if it cannot
    // tell.
    template <int N>
    double height_error(const Homogeneous<N>& P) const {
        const double least = P.W.smallest_coefficient(), most = P.W.largest();
        if (!(least > 0)) return std::numeric_limits<double>::infinity();
        if (side_.circular) {
            const CircularForm& f = *side_.circular;
            const Bernstein<N> dx = P.X - f.cx * P.W, dy = P.Y - f.cy * P.W;
            const Bernstein<N> linear = f.a * P.X + f.b * P.Y + (-f.w) * P.Z + f.e * P.W;
            const double size = f.k * (square(dx.largest()) + square(dy.largest())) +
                                most * (std::abs(f.a) * P.X.largest() + std::abs(f.b) * P.Y.largest() +
                                        f.w * P.Z.largest() + std::abs(f.e) * most);
            return ((f.k * (dx * dx + dy * dy) + linear * P.W).largest() + section_rounding * size) /
                   (f.w * square(least));
        }
        // About the axis's point c, with t the axial coordinate and k = rho + c_z,
        //     C - 2 beta z - d_z^2 z^2 = m_x^2 + m_y^2 - t^2 - k (2 z + rho - c_z),
        // and (beta + d_z^2 z) = k + d_z t =: b is s on the bisector. The residual Q is (f - z)(s + b), and
        // s^2 = b^2 + d_z^2 Q.
        const CylinderHeight& f = side_.cylinder->height();
        const Eigen::Vector3d &c = f.point(), &d = f.axis();
        const double k = f.rho() + c.z();
        const Bernstein<N> mx = P.X - c.x() * P.W, my = P.Y - c.y() * P.W, mz = P.Z - c.z() * P.W;
        const Bernstein<N> t = d.x() * mx + d.y() * my + d.z() * mz;
        const Bernstein<N> linear = k * (2 * P.Z + (f.rho() - c.z()) * P.W);
        const double distance =
            mx.largest() + my.largest() + (std::abs(c.z()) + f.rho()) * most + P.Z.largest();
        const double size = square(mx.largest()) + square(my.largest()) + square(t.largest()) +
                            linear.largest() * most + distance * f.reach() * most;
        const double Q =
            ((mx * mx + my * my - t * t - linear * P.W).largest() + section_rounding * size) / square(least);
        const Bernstein<N> lower = d.z() * t + k * P.W;
        double b = std::numeric_limits<double>::infinity();
        for (int i = 0; i <= N; ++i) b = std::min(b, lower.coefficient(i) / P.W.coefficient(i));
        const double below = b * b - d.z() * d.z() * Q;
        return b > 0 && below > 0 ? Q / (b + std::sqrt(below)) : std::numeric_limits<double>::infinity();
    }

private:
    static double square(double a) { return a * a; }

    ArcSide side_;
};

// The certificate of conic_error().
class ConicError {
public:
    using Points = std::array<Eigen::Vector4d, 3>;  // homogeneous
    using Trim = std::array<Vector3d, 4>;

    ConicError(const std::array<ArcSide, 2>& sides, const SectionSurface& plane)
        : sides_(sides), plane_(plane) {}

    void add(const Points& points, const std::array<Trim, 2>& trims) {
        Part part{points, trims};
        part.balance();
        parts_.push_back(part);
    }

    // Slopes and weights vary along a part, and what is proved of all of it at once may be far too much:
    // parts are halved until there is a proof, and on while that gains a factor of four.
    FitError error() const {
        std::priority_queue<Proved> proved;
        const double rest = unproved_length(parts_, deepest, most_halvings, [&](const Part& part) {
            const auto whole = whole_error(part.points, part.trims);
            if (whole) proved.push({part, *whole});
            return whole.has_value();
        });
        FitError most;
        for (int halvings = most_halvings; !proved.empty();) {
            const Proved whole = proved.top();
            proved.pop();
            if (halvings > 0 && whole.error.space > std::max(sharp * whole.part.length(), rest)) {
                --halvings;
                const auto half = whole.part.halves();
                const auto gains = [&](const std::optional<FitError>& e) {
                    return e && e->space <= 0.25 * whole.error.space;
                };
                const std::array of_half{whole_error(half[0].points, half[0].trims),
                                         whole_error(half[1].points, half[1].trims)};
                if (std::ranges::all_of(of_half, gains)) {
                    for (const int i : {0, 1}) proved.push({half[i], *of_half[i]});
                    continue;
                }
            }
            most = {std::max(most.chart, whole.error.chart), std::max(most.space, whole.error.space)};
        }
        return {most.chart + 4 * rest, most.space + 4 * rest};
    }

private:
    struct Part {
        Points points;
        std::array<Trim, 2> trims;

        // The curves keep their places but get parameters that make the weights at the ends alike: halves are
        // then as long.
        void balance() {
            const double factor = std::sqrt(points[0].w() / points[2].w());
            if (!(factor > 4) && !(factor < 0.25)) return;
            const auto scale = [factor](auto& controls) {
                double power = 1;
                for (std::size_t k = 1; k < controls.size(); ++k) controls[k] *= power *= factor;
            };
            scale(points);
            for (Trim& trim : trims) scale(trim);
        }
        double length() const {
            double sum = 0;
            for (int i = 1; i < 3; ++i)
                sum += (points[i].head<3>() / points[i].w() - points[i - 1].head<3>() / points[i - 1].w())
                           .norm();
            return sum;
        }
        std::array<Part, 2> halves() const {
            std::array<Part, 2> half;
            divide(points, half[0].points, half[1].points);
            for (int side = 0; side < 2; ++side)
                divide(trims[side], half[0].trims[side], half[1].trims[side]);
            for (Part& h : half) h.balance();
            return half;
        }
    };
    // The least exact one is sharpened first.
    struct Proved {
        Part part;
        FitError error;

        bool operator<(const Proved& o) const { return error.space < o.error.space; }
    };
    static constexpr int deepest = 40, most_halvings = 400;
    static constexpr double sharp = 0x1p-36;  // of a part's length: no reader asks for more

    template <class Control>
    static void divide(const Control& points, Control& first, Control& second) {
        Control work = points;
        const std::size_t n = points.size() - 1;
        for (std::size_t k = 0; k <= n; ++k) {
            first[k] = work[0];
            second[n - k] = work[n - k];
            for (std::size_t i = 0; i < n - k; ++i) work[i] = 0.5 * (work[i] + work[i + 1]);
        }
    }

    bool has_height(int side) const { return sides_[side].circular || sides_[side].cylinder; }

    std::optional<FitError> whole_error(const Points& points, const std::array<Trim, 2>& trims) const {
        std::array<Vector2d, 3> chart;
        Eigen::Array2d low = points[0].head<2>() / points[0].w(), high = low;
        for (int k = 0; k < 3; ++k) {
            chart[k] = points[k].head<2>() / points[k].w();
            low = low.min(chart[k].array());
            high = high.max(chart[k].array());
        }
        const Vector2d middle = 0.5 * (low + high).matrix();
        const auto row = [&](int i) { return Bernstein<2>::from([&](int k) { return points[k][i]; }); };
        const Homogeneous<2> P{row(0), row(1), row(2), row(3)};
        // The first cylinder's height, less that of the plane.
        const int first = sides_[0].cylinder ? 0 : 1;
        std::array<double, 2> error{}, trim{};
        std::array<std::optional<HeightJet2>, 2> jets;
        for (const int i : {0, 1}) {
            if (!has_height(i)) continue;
            const Side side(sides_[i]);
            jets[i] = side(middle);
            error[i] = side.height_error(P);
            if (sides_[i].cylinder) trim[i] = trim_deviation(*sides_[i].cylinder, P, trims[i]);
        }
        FitError result;
        const auto* wall = std::get_if<WallLine>(&plane_);
        double residual = 0, least = 0;
        if (wall != nullptr) {
            const double norm = std::hypot(wall->a, wall->b), most = P.W.largest();
            const double size = std::abs(wall->a) * P.X.largest() + std::abs(wall->b) * P.Y.largest() +
                                std::abs(wall->c) * most;
            result.chart =
                ((wall->a * P.X + wall->b * P.Y + wall->c * P.W).largest() + section_rounding * size) /
                (norm * P.W.smallest_coefficient());
        } else {
            const Side graph(ArcSide{&std::get<CircularForm>(plane_), nullptr});
            const HeightJet2 jet = graph(middle);
            residual = error[first] + graph.height_error(P);
            least = (jets[first]->gradient - jet.gradient).norm() - jet.gradient_error;
            result.chart = 2 * residual / least;
        }
        // What is compared is to be within this of the part, if gradients change by half of what they are.
        const double room = std::max({result.chart, trim[0], trim[1]}) + 64 * u * middle.norm();
        const double half = 0.5 * (high - low).matrix().norm();
        if (!(room <= 0.25 * half + 64 * u * middle.norm())) return std::nullopt;
        std::array<double, 2> change{};
        for (const int i : {0, 1})
            if (has_height(i)) change[i] = Side(sides_[i]).variation(*jets[i], middle, chart, room);
        if (wall == nullptr) {
            if (!(least > 2 * change[first])) return std::nullopt;
            result.chart = residual / (least - change[first]);
        }
        double arc_height = std::numeric_limits<double>::infinity(), worst = 0;
        for (const int i : {0, 1}) {
            if (!has_height(i)) continue;
            const double slope = jets[i]->gradient.norm() + change[i];
            arc_height = std::min(arc_height, error[i] + slope * result.chart);
            worst = std::max(worst, std::hypot(trim[i], error[i] + slope * trim[i]));
        }
        result.space = std::max(worst, std::hypot(result.chart, arc_height));
        if (!std::isfinite(result.space)) return std::nullopt;
        return result;
    }

    // Step 3, everything times powers of the weights.
    static double trim_deviation(const CylinderFrame& frame, const Homogeneous<2>& P, const Trim& points) {
        const auto row = [&](int i) { return Bernstein<3>::from([&](int k) { return points[k][i]; }); };
        const Bernstein<3> U = row(0), V = row(1), D = row(2);
        const double eps = frame.eps(), least = D.smallest_coefficient(),
                     least_w = P.W.smallest_coefficient();
        if (!(least > 0 && least_w > 0)) return std::numeric_limits<double>::infinity();
        const Vector2d ex = frame.turned({1, 0}), ey = frame.turned({0, 1}), o = frame.turned(frame.origin());
        const Bernstein<2> along = ex.x() * P.X + ey.x() * P.Y - o.x() * P.W,
                           across = ex.y() * P.X + ey.y() * P.Y - o.y() * P.W;
        const Bernstein<6> turned = (eps * U + D) * V, D2 = square(D);
        const double uneven = D.largest() / least * (P.W.largest() / least_w);
        const double u_size = U.largest() / least, v_size = V.largest() / least,
                     turned_size = (1 + eps * u_size) * v_size;
        const double size = u_size + turned_size * (1 + eps * v_size) +
                            (P.X.largest() + P.Y.largest()) / least_w + frame.origin().norm();
        const double scale = least_w * least * least;
        const double first =
            ((U * D2 * P.W - along * (D2 * D)) - (0.25 * eps) * (turned * V * P.W)).largest() /
            (scale * least);
        const double second = (turned * P.W - across * D2).largest() / scale;
        return std::hypot(first, second) + section_rounding * uneven * uneven * uneven * size;
    }

    const std::array<ArcSide, 2> sides_;
    const SectionSurface& plane_;
    std::vector<Part> parts_;
};

}  // namespace

FitError conic_error(const std::array<ArcSide, 2>& sides, const SectionSurface& plane,
                     std::span<const MixedSpan> spans) {
    ConicError error(sides, plane);
    for (const MixedSpan& span : spans) {
        const auto homogeneous = [&](int k) {
            const Eigen::Vector4d& p = span.points[k];
            return Eigen::Vector4d(p.w() * p.x(), p.w() * p.y(), p.w() * p.z(), p.w());
        };
        ConicError::Points points{homogeneous(0), homogeneous(1), homogeneous(span.degree)};
        if (span.degree == 1) points[1] = 0.5 * (points[0] + points[2]);
        std::array<ConicError::Trim, 2> trims;
        for (const int side : {0, 1}) {
            const MixedSpan::Trim& trim = span.trims[side];
            const auto at = [&](int k) {
                const Vector3d& q = trim.points[k];
                return Vector3d(q.z() * q.x(), q.z() * q.y(), q.z());
            };
            ConicError::Trim& t = trims[side];
            t = {at(0), at(1), at(2), at(3)};
            if (trim.degree == 1) t = {at(0), (2 * at(0) + at(1)) / 3, (at(0) + 2 * at(1)) / 3, at(1)};
            if (trim.degree == 2) t = {at(0), (at(0) + 2 * at(1)) / 3, (2 * at(1) + at(2)) / 3, at(2)};
        }
        error.add(points, trims);
    }
    return error.error();
}

}  // namespace vcell
