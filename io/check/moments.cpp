#include "moments.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace vcell::check {
namespace {

/// Volume; x, y, z; xx, yy, zz, yz, zx, xy: fluxes of q times these, to be divided by 3, 4, 5.
using Terms = Eigen::Array<double, 10, 1>;
constexpr std::array<std::array<Eigen::Index, 2>, 6> kPairs{{{0, 0}, {1, 1}, {2, 2}, {1, 2}, {2, 0}, {0, 1}}};

class MomentsRoom : public Room {
public:
    using Room::Room;

    void run() {
        const Moments& m = *cell_.moments;
        if (!is_sound(m) || !is_closed()) return;
        add_bounds();
        for (const CellFace& f : cell_.faces) add(f);
        if (cell_.closing)
            for (const CellFace& f : cell_.closing->faces) add(f);
        for (std::size_t e = 0; e < cell_.edges.size(); ++e) add_slack(cell_.edges[e], full_error(e));
        if (cell_.closing)
            for (const CellEdge& e : cell_.closing->edges) add_slack(e, 2 * e.error);
        judge(m);
    }

private:
    bool is_sound(const Moments& m) {
        const auto is_bound = [](double x) { return x >= 0 && std::isfinite(x); };
        const bool is_finite = m.centroid.allFinite() && m.second.allFinite();
        if (is_finite && is_bound(m.centroid_error) && is_bound(m.second_error) &&
            m.second == m.second.transpose())
            return true;
        note("measures.moments", "are not finite, not symmetric, or have errors that are none");
        return false;
    }
    bool is_closed() const {
        return cell_.closing || std::ranges::all_of(uses_, [](const auto& uses) { return uses.size() == 2; });
    }

    void add_bounds() {
        Eigen::AlignedBox3d box;
        for (const CellEdge& e : cell_.edges)
            for (const auto& p : e.curve.points) box.extend(p.head<3>());
        if (box.isEmpty()) box = {scene_.box.min, scene_.box.max};
        if (cell_.closing)
            for (const CellVertex& v : cell_.closing->vertices) box.extend(v.point);
        origin_ = box.center();
        unit_ = box.diagonal().norm();
    }

    static Terms divided(Terms t) {
        t[0] /= 3;
        t.segment<3>(1) /= 4;
        t.tail<6>() /= 5;
        return t;
    }
    static Terms powers(const Vec3& q) {
        Terms t;
        t[0] = 1;
        for (Eigen::Index i = 0; i < 3; ++i) t[1 + i] = q[i];
        for (std::size_t k = 0; k < kPairs.size(); ++k)
            t[4 + static_cast<Eigen::Index>(k)] = q[kPairs[k][0]] * q[kPairs[k][1]];
        return t;
    }

    void add(const CellFace& face) {
        constexpr double enough = 1e-12;
        constexpr int inner_halvings = 5, outer_halvings = 6;
        for (const TrimmedPatch& patch : face.patches) {
            const RationalPatch& surface = patch.surface;
            const double start = 0.5 * surface.domain_u[0] + 0.5 * surface.domain_u[1];
            const auto along = [&](double u, double v) {
                return integrate(
                           [&](double x) -> Terms {
                               const SurfacePoint s = evaluate(surface, x, v);
                               const Vec3 q = (s.p - origin_) / unit_;
                               const double flux = q.dot(s.pu.cross(s.pv)) / (unit_ * unit_);
                               return flux * divided(powers(q));
                           },
                           start, u, Terms(Terms::Constant(enough)), inner_halvings)
                    .value;
            };
            for (const auto& loop : patch.loops)
                for (const TrimCurve& trim : loop)
                    for (const auto& piece : pieces(trim.curve)) {
                        const auto part = integrate(
                            [&](double t) -> Terms {
                                const auto [uv, slope] = piece.evaluate(t);
                                return along(uv.x(), uv.y()) * slope.y();
                            },
                            piece.begin, piece.end, Terms(Terms::Constant(enough)), outer_halvings);
                        sum_ += part.value;
                        error_ += part.error;
                    }
        }
    }

    /// Strips on both sides of an edge, as wide as its trims may be from the true one.
    void add_slack(const CellEdge& e, double error) {
        double length = 0, far = 0;
        const double off = 2 * std::min(error, most_stated(0)) / unit_;
        for (std::size_t k = 0; k < e.curve.points.size(); ++k) {
            const Vec3 p = e.curve.points[k].head<3>();
            if (k > 0) length += (p - e.curve.points[k - 1].head<3>()).norm() / unit_;
            far = std::max(far, (p - origin_).norm() / unit_);
        }
        slack_ += 4 * (length + 2 * off) * off * far * (1 + far * far);
    }

    void judge(const Moments& m) {
        // Estimates overestimate by far where rules converge; with a margin all the same.
        constexpr double margin = 16, rounding = 1e-9;
        const double volume = sum_[0];
        if (!(volume > 0)) return;
        const double rest = margin * error_.maxCoeff() + slack_ + rounding * volume;
        const Vec3 centre = sum_.segment<3>(1).matrix() / volume;
        const double off = (m.centroid - (origin_ + unit_ * centre)).norm(),
                     room = m.centroid_error + 2 * unit_ * rest / volume;
        if (!(off <= room))
            certificate_.leave_open(
                "measures.moments.centroid",
                fmt::format("is {:.3g} away from where quadrature has it, within {:.3g}", off, room), off);
        const double scale = std::pow(unit_, 5);
        double most = 0;
        for (std::size_t k = 0; k < kPairs.size(); ++k) {
            const auto [i, j] = kPairs[k];
            const double own = sum_[4 + static_cast<Eigen::Index>(k)] - volume * centre[i] * centre[j];
            most = std::max(most, std::abs(m.second(i, j) / scale - own));
        }
        const double allowed = m.second_error / scale + 8 * rest;
        if (!(most <= allowed))
            certificate_.leave_open("measures.moments.second",
                                    fmt::format("are {:.3g} off what quadrature has, within {:.3g}",
                                                most * scale, allowed * scale),
                                    HUGE_VAL);
        if (m.centroid_error > scene_.box.diagonal())
            certificate_.refute("measures.moments.centroid_error",
                                fmt::format("is {:.3g}, more than the box's diagonal", m.centroid_error));
    }

    Vec3 origin_ = Vec3::Zero();
    double unit_ = 1, slack_ = 0;
    Terms sum_ = Terms::Zero(), error_ = Terms::Zero();
};

}  // namespace

void certify_moments(const Subject& subject, const CheckOptions& options, Certificate& certificate) {
    if (subject.cell.moments) MomentsRoom(subject, options, certificate).run();
}

}  // namespace vcell::check
