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
    /// The box bounds the cell. Pre: it contains the base's centre. With it all bounds are finite.
    void add(const Box& box);

    /// Makes the balls. Sectors are subdivided until their balls are by no more than `width` larger than
    /// without the angle, where that is not too often.
    void settle(double width);

    /// No object that is this far from the base's surface, or farther, touches the cell. Pre: settled.
    double reach() const { return reach_; }

    /// May a ball touch the cell? Pre: settled.
    bool may_touch(const Sphere& ball) const;
    /// May a ball of no more than this radius with its centre in the box? Pre: settled.
    bool may_touch(const Box& centers, double radius) const;
    /// May an object? least(p) is a lower bound of its distance from a point. Pre: settled.
    template <class Least>
    bool may_be_touched_by(Least&& least) const {
        for (int k = 0; k < sector_count; ++k)
            if (least(Vec3(sectors_.x[k], sectors_.y[k], sectors_.z[k])) < sectors_.radius[k]) return true;
        return false;
    }

private:
    static constexpr int along = 4, levels = 4;  // sectors along a side of a cube's face, halved so often
    static constexpr int of_face = along * along, sector_count = 6 * of_face;
    // The sectors of one size.
    struct Level {
        std::vector<double> x, y, z;  // axes; the four parts of a sector follow each other on the next level
        double cosine, sine;          // of the largest angle between a sector's axis and a direction in it
        double chord;                 // 2 sin(angle / 2)
        explicit Level(int along);
    };
    static const std::array<Level, levels>& table();

    struct Competitor {
        Vec3 c;
        double square, size, delta, C;  // delta less than what rounding may take, C more
    };
    // A ball that what touches the cell within a part of a sector meets.
    struct Part {
        Vec3 center;
        double radius;
    };

    template <int count>
    Eigen::Array<double, count, 1> farthest(const Level& level, std::size_t first) const;
    Part part(const Level& level, std::size_t sector, double t) const;
    void divide(int level, std::size_t sector, double width);
    /// Calls visit(face, its sectors' values) for the faces of the cube in whose ball a ball's centre may be:
    /// apart(x, y, z, radius) is below 0 where it is in those of these coordinates and radii. Until visit
    /// says yes.
    template <class Apart, class Visit>
    bool any_face(Apart&& apart, Visit&& visit) const;
    void set_faces();
    bool touches_part(int sector, const Vec3& center, double radius) const;

    Sphere base_;
    double size_;  // of the coordinates in it, for rounding
    std::vector<Competitor> competitors_;
    // The sectors' balls; and those of their parts, from begin_[k] to begin_[k + 1], where a sector was
    // divided.
    template <int count>
    struct Balls {
        Eigen::Array<double, count, 1> x, y, z, radius;
    };
    Balls<sector_count> sectors_;
    Balls<6> faces_;  // of the cube: each holds the balls of its sectors
    std::array<std::uint32_t, sector_count + 1> begin_;
    std::vector<Part> parts_;
    double reach_ = 0;
};

}  // namespace vcell::whole
