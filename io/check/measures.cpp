#include "measures.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

namespace vcell::check {
namespace {

/// Relative; what a quadrature of the cell's author may have left in a length, which states no error.
constexpr double kLengthError = 1e-10;

class MeasuresRoom : public Room {
public:
    using Room::Room;

    void run() {
        for (std::size_t e = 0; e < cell_.edges.size(); ++e) check_length(e);
        check_integrals();
        check_clearances();
        check_neighbors();
        check_report();
    }

private:
    void check_amount(const std::string& where, double v) {
        if (!(v >= 0) || std::isinf(v)) note(where, fmt::format("is {}, must be finite and not negative", v));
    }

    /// The integral of SceneGeometry::densities() over a trimmed patch. Green's theorem: the integral over
    /// the region is that of I(u, v) dv along the loops, I the integral of the density from a fixed u; or
    /// that of -I du, from a fixed v.
    Integral<Triple> integrate_patch(const Patch& patch) const {
        const auto density = [&](const Vec2& uv) { return geometry_.densities(lift(patch, uv)); };
        const auto [across, start] = start_line(patch);
        const int along = 1 - across;
        const double sign = across == 0 ? 1 : -1;
        // Parameters are rounded at their size, which for a thin patch far out is more than rounding of the
        // integral; control points at that of their coordinates, which turns the partial derivatives.
        const Vec2 extent = patch.hi - patch.lo, size = patch.lo.cwiseAbs().cwiseMax(patch.hi.cwiseAbs());
        const SurfacePoint middle = lift(patch, 0.5 * (patch.lo + patch.hi));
        const double turn = kRounding * patch.control_size *
                            (1 / (middle.pu.norm() * extent.x()) + 1 / (middle.pv.norm() * extent.y()));
        Triple most = Triple::Zero();
        for (const auto& loop : patch.loops)
            for (const Trim& trim : loop)
                for (const auto& piece : trim.pieces)
                    most = most.max(density(piece.evaluate(std::midpoint(piece.begin, piece.end))[0]).abs());
        const Triple inner_floor = (kRounding * size[across] + turn * extent[across]) * most;
        const Triple floor =
            (kRounding * (size.x() * extent.y() + size.y() * extent.x()) + turn * extent.prod()) * most;
        Integral<Triple> total{Triple::Zero(), Triple::Zero()};
        for (const auto& loop : patch.loops)
            for (const Trim& trim : loop)
                for (const auto& piece : trim.pieces) {
                    Triple inner_error = Triple::Zero();
                    const auto part = integrate(
                        [&](double t) -> Triple {
                            const auto [q, d] = piece.evaluate(t);
                            if (d[along] == 0) return Triple::Zero();
                            const auto inner = integrate(
                                [&](double x) {
                                    Vec2 uv = q;
                                    uv[across] = x;
                                    return density(uv);
                                },
                                start, q[across], inner_floor);
                            inner_error = inner_error.max(inner.error * std::abs(d[along]));
                            return sign * inner.value * d[along];
                        },
                        piece.begin, piece.end, floor);
                    total.value += part.value;
                    total.error += part.error + floor + inner_error * (piece.end - piece.begin);
                }
        return total;
    }

    /// Where integrals across u (0) or v (1) start: on the line of the rectangle that has the least volume
    /// above it. A corner of it may be all but at infinity.
    struct StartLine {
        int across;
        double start;
    };
    StartLine start_line(const Patch& patch) const {
        StartLine best{};
        double least = HUGE_VAL;
        for (const int across : {0, 1})
            for (const double s : {0.5, 0.0, 1.0}) {
                const double start = std::lerp(patch.lo[across], patch.hi[across], s);
                double volume = 0;
                for (const double t : {0.0, 0.25, 0.5, 0.75, 1.0}) {
                    Vec2 uv = patch.lo + t * (patch.hi - patch.lo);
                    uv[across] = start;
                    volume = std::max(volume, std::abs(geometry_.densities(lift(patch, uv))[0]));
                }
                if (volume < least) {
                    least = volume;
                    best = {across, start};
                }
            }
        return best;
    }

    void compare(const std::string& where, double stated, double found, double tolerance) {
        if (!(std::abs(stated - found) <= tolerance))
            note(where,
                 fmt::format("is {}, integration gives {} (tolerance {:.3g})", stated, found, tolerance));
    }

    /// The cell's side along a piece of a rim edge.
    double side_area(const Bezier<3>& piece) const {
        const auto density = [&](double t) {
            const auto [p, d] = piece.evaluate(t);
            return Scalar(geometry_.side_area_density(p, d));
        };
        const Scalar floor(rounding() * scene_.box.diagonal());
        return integrate(density, piece.begin, piece.end, floor).value[0];
    }

    void check_integrals() {
        const Measures& m = cell_.measures;
        check_amount("measures.volume_error", m.volume_error);
        check_amount("measures.area_error", m.area_error);
        double volume = 0, area = 0, box_area = -geometry_.body_end_area(), shadow = 0;
        double edge_errors = 0;  // area between the stated and the true edges
        for (std::size_t e = 0; e < cell_.edges.size(); ++e)
            edge_errors += cell_.edges[e].length * full_error(e);
        Triple error = Triple::Zero();
        std::vector<double> face_areas(cell_.faces.size()), face_errors(cell_.faces.size());
        for (const Patch& patch : patches_) {
            const auto part = integrate_patch(patch);
            volume += part.value[0];
            shadow += part.value[2];
            face_areas[patch.face] += part.value[1];
            face_errors[patch.face] += part.error[1];
            (cell_.faces[patch.face].site.is_object() ? area : box_area) += part.value[1];
            error += part.error;
        }
        const double length_rounding = rounding(), area_rounding = length_rounding * scene_.box.diagonal();
        const double slack = m.area_error + area_rounding + 2 * edge_errors;
        for (std::size_t f = 0; f < cell_.faces.size(); ++f)
            compare(face_path(f) + ".area", cell_.faces[f].area, face_areas[f], slack + face_errors[f]);
        compare("measures.area", m.area, area, slack + error[1]);
        // Over the rim of a plane the cell has walls; at those of a cylinder it ends in rings around the
        // body.
        bool touches =
            std::ranges::any_of(cell_.faces, [](const CellFace& f) { return !f.site.is_object(); });
        for (std::size_t e = 0; e < edge_pieces_.size(); ++e) {
            if (!rim_[e]) continue;
            touches = true;
            for (const auto& piece : edge_pieces_[e]) box_area += side_area(piece);
        }
        compare("measures.box_area", m.box_area, box_area, slack + error[1] + kLengthError * box_area);
        if (m.touches_box != touches)
            note("measures.touches_box", fmt::format("is {}, must be {}", m.touches_box, touches));
        compare("measures.volume", m.volume, volume,
                m.volume_error + error[0] + (area_rounding + 2 * edge_errors) * scene_.box.diagonal());

        const double base_area = geometry_.base_area();
        compare("measures.base_area", m.base_area, base_area, area_rounding);
        double lowest = HUGE_VAL;
        for (const Patch& patch : patches_)
            for (const auto& point : patch.grid) lowest = std::min(lowest, height(point.surface.p));
        const double whole = geometry_.shadow();
        if (std::abs(shadow - whole) > geometry_.shadow(area_rounding + 2 * edge_errors, lowest) + error[2])
            note("faces", fmt::format("stand over an area of {}, the base has {}{}", shadow, whole,
                                      geometry_.is_plane() ? "" : " where its radius is 1"));
        compare("measures.body_volume", m.body_volume, geometry_.body_volume(),
                area_rounding * scene_.box.diagonal());
    }

    /// Least and greatest height on the vertices, along the edges, and at a stationary point within a face.
    /// No bisector's height has a greatest value inside.
    void check_clearances() {
        double least = HUGE_VAL, greatest = -HUGE_VAL, error = rounding();
        const auto meet = [&](double h) {
            least = std::min(least, h);
            greatest = std::max(greatest, h);
        };
        for (const CellVertex& v : cell_.vertices) {
            meet(height(v.point));
            error = std::max(error, rounding() + v.error);
        }
        for (std::size_t e = 0; e < edge_pieces_.size(); ++e) {
            error = std::max(error, rounding() + full_error(e));
            for (const auto& piece : edge_pieces_[e]) {
                const auto height_at = [&](double t) { return height(piece.evaluate(t)[0]); };
                for (const double sign : {-1.0, 1.0})
                    meet(sign *
                         lowest(piece.begin, piece.end, [&](double t) { return sign * height_at(t); }));
            }
        }
        for (const Patch& patch : patches_) {
            if (const auto h = stationary_height(patch)) meet(*h);
            for (const auto& loop : patch.loops)
                for (const Trim& trim : loop)
                    if (trim.curve->seam)
                        meet(lowest(trim.begin(), trim.end(), [&](double t) {
                            return height(lift(patch, evaluate(trim.pieces, t)).p);
                        }));
        }
        const Measures& m = cell_.measures;
        if (!(std::abs(m.min_clearance - least) <= error))
            note("measures.min_clearance",
                 fmt::format("is {}, the least found is {}", m.min_clearance, least));
        if (!(std::abs(m.max_clearance - greatest) <= error))
            note("measures.max_clearance",
                 fmt::format("is {}, the greatest found is {}", m.max_clearance, greatest));
    }

    /// Minimum of a function over an interval: the best of a few samples, refined by golden section.
    template <class F>
    static double lowest(double begin, double end, F function) {
        constexpr int kSteps = 16;
        const auto value = [&](double s) { return function(std::lerp(begin, end, s)); };
        int best = 0;
        for (int k = 1; k <= kSteps; ++k)
            if (value(k / double(kSteps)) < value(best / double(kSteps))) best = k;
        double lo = std::max(0, best - 1) / double(kSteps), hi = std::min(kSteps, best + 1) / double(kSteps);
        double lowest = value(best / double(kSteps));
        constexpr double kGolden = 1 / std::numbers::phi;
        // Mostly half the digits of the place give all of the value. But a distance from what is passed closely
        // has a corner.
        while (hi - lo > 1e-14) {
            const double a = hi - kGolden * (hi - lo), b = lo + kGolden * (hi - lo);
            const double fa = value(a), fb = value(b);
            lowest = std::min({lowest, fa, fb});
            (fa < fb ? hi : lo) = fa < fb ? b : a;
        }
        return lowest;
    }

    /// The height where it is stationary, if inside the loops. A bisector has one such place, a minimum (or
    /// several of one height, which reach the boundary): descent from the lowest point of the grid that is
    /// inside, by Newton's method with the Hessian's eigenvalues made positive, within the rectangle.
    std::optional<double> stationary_height(const Patch& patch) const {
        const Vec2 extent = patch.hi - patch.lo;
        const auto height_at = [&](const Vec2& uv) { return height(lift(patch, uv).p); };
        const auto gradient = [&](const Vec2& uv) {  // per extent
            const SurfacePoint s = lift(patch, uv);
            const Vec3 up = geometry_.up(s.p);
            return Vec2(up.dot(s.pu) * extent.x(), up.dot(s.pv) * extent.y());
        };
        Vec2 uv = 0.5 * (patch.lo + patch.hi);
        double lowest = HUGE_VAL;
        for (const auto& point : patch.grid)
            if (const double h = height(point.surface.p);
                h < lowest && inside(patch, point.uv, rounding()).value_or(false)) {
                lowest = h;
                uv = point.uv;
            }
        lowest = height_at(uv);
        constexpr int kSteps = 100, kHalvings = 40;
        for (int k = 0; k < kSteps; ++k) {
            constexpr double kStep = 1e-4;  // of the extent: errors of its square against rounding
            Eigen::Matrix2d hessian;
            for (int i = 0; i < 2; ++i) {
                const Vec2 h = Vec2::Unit(i) * (kStep * extent[i]);
                hessian.col(i) = (gradient(uv + h) - gradient(uv - h)) / (2 * kStep);
            }
            const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(0.5 *
                                                                        (hessian + hessian.transpose()));
            const Eigen::Array2d sizes = solver.eigenvalues().array().abs();
            const Eigen::Array2d curvatures = sizes.max(kRounding * sizes.maxCoeff());
            const Eigen::Matrix2d axes = solver.eigenvectors();
            const Vec2 step = axes * ((axes.transpose() * gradient(uv)).array() / curvatures).matrix();
            bool has_moved = false;
            double part = 1;
            for (int halving = 0; halving < kHalvings && !has_moved; ++halving, part *= 0.5) {
                const Vec2 next =
                    (uv - part * extent.cwiseProduct(step)).cwiseMax(patch.lo).cwiseMin(patch.hi);
                if (const double h = height_at(next); h < lowest) {
                    lowest = h;
                    uv = next;
                    has_moved = true;
                }
            }
            if (!has_moved) break;
        }
        // On the boundary itself edges and seams tell.
        if (!inside(patch, uv, rounding()).value_or(false)) return std::nullopt;
        return lowest;
    }

    void check_neighbors() {
        std::map<std::uint32_t, double> owned;
        for (const CellFace& f : cell_.faces) {
            if (f.site.is_object()) owned[f.site.index] += f.area;
            for (const Site s : f.extra_sites)
                if (s.is_object()) owned[s.index] += f.area;
        }
        std::map<std::uint32_t, int> listed;
        for (std::size_t i = 0; i < cell_.neighbors.size(); ++i) {
            const std::uint32_t object = cell_.neighbors[i];
            const std::string where = fmt::format("neighbors[{}]", i);
            if (!owned.contains(object))
                note(where, fmt::format("object {} owns no face", object));
            else if (listed[object]++)
                note(where, fmt::format("object {} is listed twice", object));
            else if (i > 0 && owned.contains(cell_.neighbors[i - 1]) &&
                     owned[cell_.neighbors[i - 1]] <
                         owned[object] - 2 * cell_.measures.area_error - kRounding * owned[object])
                note(where, fmt::format("object {} owns more area than the one before it", object));
        }
        for (const auto& [object, area] : owned)
            if (!listed.contains(object))
                note("neighbors", fmt::format("lack object {}, which owns a face", object));
    }

    void check_report() {
        check_amount("report.seconds.bisectors", cell_.report.seconds_bisectors);
        check_amount("report.seconds.envelope", cell_.report.seconds_envelope);
        check_amount("report.seconds.patches", cell_.report.seconds_patches);
    }


    void check_length(std::size_t i) {
        double length = 0, error = 0;
        for (const auto& piece : edge_pieces_[i]) {
            const auto part = integrate([&](double t) { return Scalar(piece.evaluate(t)[1].norm()); },
                                        piece.begin, piece.end, Scalar(rounding()));
            length += part.value[0];
            error += part.error[0];
        }
        const double stated = cell_.edges[i].length;
        if (std::abs(stated - length) > error + kLengthError * length + 2 * full_error(i) + rounding())
            note(edge_path(i) + ".length", fmt::format("is {}, the curve is {} long", stated, length));
    }
};

}  // namespace

void certify_measures(const Subject& subject, const CheckOptions& options, Certificate& certificate) {
    MeasuresRoom(subject, options, certificate).run();
}

}  // namespace vcell::check
