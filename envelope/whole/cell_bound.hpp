/// Where an object must come to touch a ball's cell.
///
/// The boundary of the cell lies, in the direction u from the ball's centre, no farther than the bisector
/// with any competitor: with c its centre relative to the ball's and delta the difference of the radii,
///
///     t(u) <= C / (2 (c.u + delta)),   C = |c|^2 - delta^2
///
/// where that is positive (radial_base.hpp). Over directions within an angle of an axis c.u is least at the
/// one that is farthest from c. So a few competitors bound t by some T in each of a number of sectors, which
/// are subdivided where that is far. An object that is as near as the base to the point at t along u meets
/// the ball about that point which touches the base from outside; for all t up to T these lie in each other,
/// and for all u of a sector about an axis a in the ball
///
///     about T a of radius T - R0 + 2 T sin(angle / 2)
///
/// where R0 is the base's radius. It is proved not to touch the cell where it meets none of these.
///
/// Four floats fit in a register where two doubles do, and a bound is none the worse for a part in 2^18, by
/// which all that is computed in floats gives way: relative to the base, in a unit of the cell's size.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "../../primitives/objects/objects.hpp"

namespace vcell::whole {

class CellBound {
public:
    /// Nothing is known: the cell may reach everywhere.
    explicit CellBound(const Sphere& base);

    /// A ball competes. Pre: neither ball contains the other.
    void add(const Sphere& ball);
    /// The box bounds the cell, and the base's centre may lie beyond its sides. With it all bounds are
    /// finite.
    void add(const Box& box);
    /// The cell ends where it is this far (> 0) from the base's surface.
    void add_cap(double clearance);

    /// Makes the balls. Sectors are subdivided until their balls are by no more than `width` larger than
    /// without the angle, where that is not too often.
    void settle(double width);

    const Sphere& base() const { return base_; }

    /// No object that is this far from the base's surface, or farther, touches the cell. Pre: settled.
    double reach() const { return reach_; }
    /// may_touch() says no to all balls of no more than this radius whose surfaces are so far from the base's
    /// centre, or farther. Pre: settled.
    double extent(double radius) const;

    /// May a ball touch the cell? Pre: settled.
    bool may_touch(const Sphere& ball) const;
    /// May a ball of no more than this radius with its centre in the box? Of every ball that may touch, the
    /// box may, too: what a search finds is no matter of the tree's boxes. Pre: settled.
    bool may_touch(const Box& centers, double radius) const;
    /// May an object? least(p) is a lower bound of its distance from a point. Pre: settled.
    template <class Least>
    bool may_be_touched_by(Least&& least) const {
        for (int k = 0; k < sector_count; ++k)
            if (least(Vec3(base_.center + unit_ * Vec3(sectors_.x[k], sectors_.y[k], sectors_.z[k]))) <
                unit_ * sectors_.radius[k])
                return true;
        return false;
    }

private:
    static constexpr int along = 4, levels = 4;  // sectors along a side of a cube's face, halved so often
    static constexpr int of_face = along * along, sector_count = 6 * of_face;
    template <int count>
    using Row = Eigen::Array<float, count, 1>;
    // The sectors of one size.
    struct Level {
        std::vector<float> x, y, z;  // axes; the four parts of a sector follow each other on the next level
        float cosine, sine;          // of the largest angle between a sector's axis and a direction in it
        double chord;                // 2 sin(angle / 2)
        explicit Level(int along);
    };
    static const std::array<Level, levels>& table();

    struct Competitor {
        Vec3 c;
        double size, delta, C;  // delta less than what rounding may take, C more
    };
    // Ready for the sectors: t <= 1 / (factor (c.u + delta)).
    struct Bound {
        float x, y, z, square, size, delta, factor;
    };
    // Balls that what touches the cell within a part of the base's directions meets.
    template <int count>
    struct Balls {
        Row<count> x, y, z, radius;

        void set(int k, const Eigen::Vector4f& ball) {
            x[k] = ball[0];
            y[k] = ball[1];
            z[k] = ball[2];
            radius[k] = ball[3];
        }
    };
    // A ball or a box of centres as they are compared with those.
    struct Place {
        Eigen::Array3f center;
        float radius;

        // Squares of its lengths are numbers. A box is so wide about its centre.
        bool is_near(float wide = 0) const { return center.abs().sum() + wide + radius < 0x1p50F; }
    };

    double rounded_up(double length, double terms) const;
    void set_bounds();
    template <int count>
    Row<count> farthest(const Level& level, std::size_t first) const;
    Eigen::Vector4f ball(const Level& level, std::size_t sector, double t) const;
    void divide(int level, std::size_t sector, double width);
    Place place(const Vec3& center, double radius, double extent) const;
    /// Is apart(x, y, z, radius), of balls of these coordinates and radii, not above 0 for a ball of the
    /// cube's faces, one of a sector of that face, and if it was divided one of its parts?
    template <class Apart>
    bool any(Apart&& apart) const;
    template <class Apart>
    bool any_part(int sector, Apart&& apart) const;
    void set_faces();

    Sphere base_;
    double size_;  // of the coordinates in it, for rounding
    std::vector<Competitor> competitors_;
    double least_reciprocal_ = 0;  // of t, which the cap bounds

    double unit_ = 1;  // of all floats
    std::vector<Bound> bounds_;
    // The sectors' balls; and those of their parts, in fours from begin_[k] to begin_[k + 1], where a sector
    // was divided.
    Balls<sector_count> sectors_;
    Balls<6> faces_;  // of the cube: each holds the balls of its sectors
    std::array<std::uint32_t, sector_count + 1> begin_;
    std::vector<Balls<4>> parts_;
    int last_four_ = 0;  // parts in the last four
    double reach_ = 0;
};

}  // namespace vcell::whole
