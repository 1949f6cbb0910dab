// Where a plane base and its box are brought to: canonical position (plane_base.hpp).
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cmath>

#include "../objects/exact_motion.hpp"
#include "../objects/exact_space.hpp"
#include "canonical.hpp"
#include "plane_base.hpp"

namespace vcell {

// A box is far from the scene's origin if it is this many times its size away.
inline constexpr double far_in_steps = 16;

// canonical = (rotation (world - origin) - (0, 0, lift)) / norm. What objects are to each other is exact; the
// base turns by a few 2^-53 to become z = 0, or not at all where its normal's length is a double. The sides
// of the box are rounded to doubles.
class PlaneFrame {
public:
    PlaneFrame(const Plane& base, const Box& box) : rotation_(scaled_axis(base.normal), 2) {
        const Vec3& n = base.normal;
        Eigen::Index k = 0;
        n.cwiseAbs().maxCoeff(&k);
        is_axis_parallel_ = (n.array() != 0).count() == 1;
        turn_ = rotation_.turn(scaled_axis(n), 2);
        motion_.rotation = rotation_.rounded();
        // Other coordinates than the k-th keep their digits: a box far from the origin is brought near by a
        // multiple of a power of two above its size.
        if (is_axis_parallel_) {
            const double step = std::exp2(std::ceil(std::log2(box.diagonal())));
            const Vec3 steps = (0.5 / step * box.min + 0.5 / step * box.max).array().round();
            for (Eigen::Index i = 0; i < 3; ++i)
                if (std::abs(steps[i]) >= far_in_steps) origin_[i] = step * steps[i];
            origin_[k] = base.point[k];
            motion_.origin = origin_;
        } else {
            place_origin(base, box);
        }
        make_box(box);
    }

    const BaseFrame& motion() const { return motion_; }  // rounded
    const std::array<BoxSide, 6>& box() const { return box_; }
    const Exact& norm() const { return rotation_.norm; }
    bool is_exact() const { return turn_ == 0; }  // the base has not turned
    double moved() const { return moved_; }

    // Do doubles hold the canonical point exactly? Then they are to_canonical(p).
    bool keeps(const Vec3& p) const {
        if (!is_axis_parallel_) return false;
        for (int i = 0; i < 3; ++i)
            if (origin_[i] != 0 && Difference(p[i], origin_[i]).low != 0) return false;
        return true;
    }
    Vec3 to_canonical(const Vec3& p) const { return motion_.to_canonical(p); }

    // norm times the canonical point.
    ExactVector place(const Vec3& p) const {
        ExactVector q = rotation_(ExactVector(p) - ExactVector(origin_));
        q.z -= lift_;
        return q;
    }
    // norm times the turned direction.
    ExactVector turned(const Vec3& direction) const { return rotation_(ExactVector(direction)); }

private:
    void place_origin(const Plane& base, const Box& box) {
        const Vec3 n = scaled_axis(base.normal), unit = n.normalized();
        const Vec3 center = 0.5 * box.min + 0.5 * box.max, away = center - base.point;
        origin_ = base.point;
        if (away.norm() > box.diagonal()) {
            origin_ = center - unit * unit.dot(away);
            // No rounding of the origin leaves the base: what it is above it counts as height. Near the
            // origin the base has not moved then.
            const Exact above = dot(ExactVector(n), ExactVector(base.point) - ExactVector(origin_));
            if (is_exact())
                lift_ = dot(rotation_.rows[2], ExactVector(base.point) - ExactVector(origin_));
            else
                lift_ = rotation_.norm * Exact(nearest(above) / n.norm());
        }
        const double height = nearest(lift_) / nearest(norm());
        motion_.origin = origin_ + height * motion_.rotation.row(2).transpose();
        double reach = 0;
        for (const Vec3& corner : {box.min, box.max})
            reach = std::max(reach, (corner - origin_).cwiseAbs().maxCoeff());
        // 2 > sqrt(3). What nearest() / norm() loses is a part of 2^-50 of a height that is itself a
        // rounding.
        if (!is_exact()) moved_ = 2 * reach * turn_ + 0x1p-50 * std::abs(height);
    }

    void make_box(const Box& box) {
        for (std::uint32_t s = 0; s < 6; ++s) {
            const Eigen::Index axis = s / 2;
            const double sign = s % 2 == 0 ? -1 : 1, bound = s % 2 == 0 ? box.min[axis] : box.max[axis];
            Vec3 m = sign * motion_.rotation.col(axis);
            // A wall that leans by less than its rounding stands upright: its foot would hide all of it.
            for (double& component : m)
                if (std::abs(component) < frame_rounding) component = 0;
            // The rotation is one of the axes then: only the difference is rounded.
            if (is_axis_parallel_) {
                const Difference distance(bound, origin_[axis]);
                box_[s] = {m, sign * distance.high.value, s};
                moved_ = std::max(moved_, std::abs(distance.low));
                continue;
            }
            // The side as it is: exact.m <= distance / norm.
            const auto& r = rotation_.rows;
            const std::array<const Exact*, 3> entries = axis == 0   ? std::array{&r[0].x, &r[1].x, &r[2].x}
                                                        : axis == 1 ? std::array{&r[0].y, &r[1].y, &r[2].y}
                                                                    : std::array{&r[0].z, &r[1].z, &r[2].z};
            const Exact distance =
                norm() * norm() * (sign * (Exact(bound) - origin_[axis])) - sign * *entries[2] * lift_;
            const double square = nearest(norm() * norm());
            const double k = nearest(distance) / square;
            box_[s] = {m, k, s};
            double turn = 0;
            for (int i = 0; i < 3; ++i)
                turn += std::abs(nearest(norm() * Exact(m[i]) - sign * *entries[i])) / nearest(norm());
            const double shift = std::abs(nearest(norm() * norm() * Exact(k) - distance)) / square;
            const double reach = turn > 0 ? 2 * box.diagonal() + (box.min - motion_.origin).norm() : 0;
            moved_ = std::max(moved_, turn * reach + shift);
        }
    }

    const ExactRotation rotation_;
    bool is_axis_parallel_;
    double turn_;
    Vec3 origin_ = Vec3::Zero();
    Exact lift_;
    BaseFrame motion_;
    std::array<BoxSide, 6> box_;
    double moved_ = 0;
};

}  // namespace vcell
