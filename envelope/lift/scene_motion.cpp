#include "scene_motion.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <variant>
#include <vector>

#include "../../core/small_vector.hpp"
#include "../../primitives/bases/canonical.hpp"
#include "../../primitives/bases/cylinder_base.hpp"
#include "../../primitives/objects/exact_space.hpp"

namespace vcell {

namespace {

using Eigen::Matrix3d;
using Eigen::Vector4d;

using roundoff::u;

// A unit vector from a foot, or from a vessel's wall, and the way from the centre or axis about which it
// turns; from a plane none.
struct Direction {
    Vec3 g = Vec3::Zero();
    double distance = infinity;
    Vec3 from_center = Vec3::Zero();
    Vec3 axis = Vec3::Zero();         // a unit vector
    Vec3 along = Vec3::Zero();        // of its axis, from its point to next to the foot
    double rounding = 4 * u;          // of g
    bool has_axis = false;            // a tube's, or a cone's
    double sine = 0, cosine = 1;      // of half a cone's angle
    bool turns = false;               // with the base, or gives way to a tie
    const Vec3* center = nullptr;     // of a ball or a hollow sphere
    const Vec3* point = nullptr;      // of any axis
    const Vec3* direction = nullptr;  // of any axis, as the scene has it
    double sense = 1;                 // -1 of a vessel's
    Vec3 normal = Vec3::Zero();       // a plane's, of a length in [1/2, 2)

    // Per length, but for the factor in Row::variation(): nothing of a plane.
    double turn() const { return 1 / distance; }
    // The derivative of g.
    Matrix3d derivative() const {
        if (!(distance < infinity)) return Matrix3d::Zero();
        const Vec3 out = from_center / distance;
        return (sense * cosine / distance) *
               (Matrix3d::Identity() - out * out.transpose() - axis * axis.transpose());
    }
};

// A part of an edge: what its points have about the middle, and how far that is at most.
struct Part {
    std::array<Vec3, 6> ways;
    int count = 0;
    double radius = 0;
};

// The unit vector of a plane's normal or a cylinder's axis, which may have any length.
Vec3 unit_direction(const Object& object) {
    if (const auto* plane = std::get_if<Plane>(&object)) return plane->normal.stableNormalized();
    if (const auto* cylinder = std::get_if<Cylinder>(&object)) return cylinder->axis.stableNormalized();
    if (const auto* vessel = std::get_if<HollowCylinder>(&object)) return vessel->axis.stableNormalized();
    if (const auto* vessel = std::get_if<HollowCone>(&object)) return vessel->axis.stableNormalized();
    return Vec3::Zero();
}

Direction from_foot(const Object& object, const Vec3& unit, const Vec3& p) {
    Direction d;
    if (const auto* plane = std::get_if<Plane>(&object)) {
        const double side = unit.dot(p - plane->point) < 0 ? -1 : 1;
        d.g = side * unit;
        d.normal = side * scaled_axis(plane->normal);
        return d;
    }
    const auto from_axis = [&](const Vec3& point) {
        d.from_center = p - point;
        d.along = unit.dot(d.from_center) * unit;
        d.from_center -= d.along;
        d.rounding += 4 * u * (p - point).norm() / d.from_center.norm();
    };
    const auto about_center = [&](const Vec3& center) {
        d.center = &center;
        d.from_center = p - center;
    };
    const auto about_axis = [&](const Vec3& point, const Vec3& direction) {
        d.has_axis = true;
        d.axis = unit;
        d.point = &point;
        d.direction = &direction;
        from_axis(point);
    };
    if (const auto* sphere = std::get_if<Sphere>(&object)) {
        about_center(sphere->center);
    } else if (const auto* cylinder = std::get_if<Cylinder>(&object)) {
        about_axis(cylinder->point, cylinder->axis);
    } else if (const auto* vessel = std::get_if<HollowSphere>(&object)) {
        about_center(vessel->center);
    } else if (const auto* cone = std::get_if<HollowCone>(&object)) {
        about_axis(cone->apex, cone->axis);
        d.sine = cone->sine();
        d.cosine = cone->cosine();
    } else {
        const auto& tube = std::get<HollowCylinder>(object);
        about_axis(tube.point, tube.axis);
    }
    d.distance = d.from_center.norm();
    d.g = d.distance > 0 ? Vec3(d.from_center / d.distance) : Vec3::UnitZ().eval();
    // Towards a vessel's wall its distance falls.
    if (is_vessel(object)) d.sense = -1;
    d.g *= d.sense;
    if (d.sine > 0) d.g = d.sine * unit + d.cosine * d.g;
    return d;
}

// A row of M, and by how much it may change over a length.
struct Row {
    Vec3 value;
    double nearest = infinity;  // of the distances of its feet's centres and axes
    double turn = 0;            // of its unit vectors in all, per length
    Direction object{};         // of an object that has one
    double shift = 0;           // of its equation, a length
    bool has_object = false;
    double rounding = 0;    // of its value
    std::size_t place = 0;  // of the object
    Matrix3d derivative = Matrix3d::Zero();

    // A vector of length d that moves by r < d turns by an angle whose sine is r / d at most: its unit vector
    // moves by sqrt(2) r / d at most, which 3/2 is above.
    double variation(double radius) const {
        return radius < nearest ? 1.5 * turn * radius + rounding : infinity;
    }
    // The points may also be so far away from a part. Along a needle both of its unit vectors turn alike: to
    // first order the part's hull tells that, and the second derivative of a unit vector m / |m| is 2 /
    // sqrt(3) over |m|^2 at most.
    double variation(const Part& part, double away) const {
        const double radius = part.radius + away, plain = variation(radius);
        if (!(radius < nearest)) return plain;
        double along = 0;
        for (int k = 0; k < part.count; ++k) along = std::max(along, (derivative * part.ways[k]).norm());
        const double bend = radius / (nearest - radius), doubt = rounding + 32 * u * radius / nearest;
        return std::min(plain, along + derivative.norm() * away + 1.2 * bend * bend + doubt);
    }
};

// b / |b| less a / |a| or -a / |a|, whichever is nearer: nothing cancels but in b - mu a, which is rounded
// once.
Vec3 tilt_between(const Vec3& a, const Vec3& b) {
    const double of_a = a.stableNorm(), of_b = b.stableNorm(), mu = std::copysign(of_b / of_a, a.dot(b));
    Vec3 way;
    for (int i = 0; i < 3; ++i) way[i] = std::fma(-mu, a[i], b[i]);
    return (way - way.dot(b + mu * a) / (of_b + std::abs(mu) * of_a) * (mu / std::abs(mu * of_a) * a)) / of_b;
}

// The difference of two unit vectors. They turn nearly alike where centres or axes are next to each other. A
// derivative is the projection across g, or on t = axis x g of a tube, over the distance |m|. Let centres or
// axes be `apart` at the point, seen along m, and axes differ by `tilt`; within half the lesser distance h is
// what is left of either, the ways m differ by b = apart + tilt h at most, g by b / h, t by tilt + b / h, the
// projections by as much, and 1 / |m| by b / h^2.
Row difference(const Direction& b, const Direction& a) {
    Row row{b.g - a.g, std::min(a.distance, b.distance), a.turn() + b.turn()};
    row.derivative = b.derivative() - a.derivative();
    row.rounding = a.rounding + b.rounding;
    if (const Vec3 way = b.normal - a.normal; !a.normal.isZero() && way.norm() < 0.125 * a.normal.norm()) {
        // n_b / |n_b| - n_a / |n_a|, of which nothing cancels but in n_b - n_a.
        const double length = a.normal.norm(), other = b.normal.norm();
        row.value = (way - way.dot(a.normal + b.normal) / (length + other) / length * a.normal) / other;
        row.rounding = 32 * u * way.norm() / other;
    }
    if (a.sense != b.sense || (!(a.center && b.center) && !(a.has_axis && b.has_axis))) return row;
    // The unit vectors of cones have a part along the axes, too: these turn alike where the angles are one
    // and the cones open the same way.
    if (a.sine != b.sine || a.cosine != b.cosine || (a.sine > 0 && a.axis.dot(b.axis) < 0)) return row;
    if (!(row.nearest > 0)) return row;
    const Vec3 out = a.from_center / a.distance;
    if (a.center) {
        // m_b / |m_b| - m_a / |m_a|, of which nothing cancels but in m_b - m_a, the centres' difference.
        const Vec3 way = *a.center - *b.center;
        row.value = a.sense *
                    (way - way.dot(a.from_center + b.from_center) / (a.distance + b.distance) * out) /
                    b.distance;
        row.rounding = 32 * u * way.norm() / row.nearest;
    }
    Vec3 way = b.from_center - a.from_center;
    double tilt = 0;
    if (a.has_axis) {
        // So, too, where what cancels in the ways from the axes is the difference of points and of
        // directions.
        const Vec3 turned = tilt_between(*a.direction, *b.direction), points = *b.point - *a.point,
                   from_b = b.along + b.from_center;
        const double sense = b.axis.dot(a.axis) < 0 ? -1 : 1, along = sense * a.axis.dot(a.along),
                     farther = turned.dot(from_b) - sense * a.axis.dot(points);
        way = -points - along * turned - farther * b.axis;
        tilt = turned.norm();
        row.value = a.sine * turned +
                    a.sense * a.cosine *
                        (way - way.dot(a.from_center + b.from_center) / (a.distance + b.distance) * out) /
                        b.distance;
        row.rounding = 64 * u * (points.norm() + tilt * (a.along.norm() + from_b.norm())) / row.nearest;
    }
    const double half = 0.5 * row.nearest, apart = way.norm() + tilt * half + row.rounding * row.nearest,
                 turn = (tilt + 2 * apart / half) / half;
    if (turn < row.turn) {
        row.nearest = half;
        row.turn = turn;
    }
    return row;
}

// Tubes of one radius whose axes cross are equally near in two planes. On that next to a point the difference
// of their distances grows as the distance from the plane does.
std::optional<Row> row_of_crossing(const Object& first, const Object& second, const Vec3& p) {
    const auto *a = std::get_if<Cylinder>(&first), *b = std::get_if<Cylinder>(&second);
    if (a == nullptr || b == nullptr || !cross_equally(*a, *b)) return std::nullopt;
    const Vec3 d = a->axis.stableNormalized(), e = b->axis.stableNormalized(), across = d.cross(e);
    const double along = (b->point - a->point).cross(e).dot(across) / across.squaredNorm();
    const Vec3 way = p - a->point - along * d;
    Row row;
    double nearest = infinity;
    for (const Vec3& n : {Vec3(e - d), Vec3(e + d)}) {
        const double length = n.norm(), off = std::abs(n.dot(way)) / length;
        if (!(off < nearest)) continue;
        nearest = off;
        row.value = n / length;
        row.rounding = 8 * u / length;
    }
    return row;
}

class Motion {
public:
    Motion(LiftedCell& lifted, const SceneMoves& moves)
        : cell_(lifted.cell),
          positions_(lifted.positions),
          moves_(moves),
          most_(cell_.scene.box.diagonal()),
          room_(std::sqrt((moves.all + moves.ties) * most_)),
          equations_(cell_.vertices.size()),
          ties_(cell_.vertices.size()) {
        base_unit_ = unit_direction(cell_.scene.base);
        units_.reserve(cell_.scene.objects.size());
        for (const Object& object : cell_.scene.objects) units_.push_back(unit_direction(object));
        find_equations();
    }

    void run() {
        for (std::size_t i = 0; i < cell_.vertices.size(); ++i) {
            CellVertex& v = cell_.vertices[i];
            const auto motion = of_vertex(v, equations_[i], ties_[i]);
            v.is_touching = !motion;
            v.error = std::min(most_, v.error + motion.value_or(2 * moves_.all + ties_[i]));
        }
        for (std::size_t i = 0; i < cell_.edges.size(); ++i) {
            CellEdge& e = cell_.edges[i];
            const double position = positions_[EdgeId{static_cast<std::uint32_t>(i)}];
            e.error = std::min(most_, std::max(e.error, position + of_edge(e, position, is_rim_[i])));
        }
    }

private:
    // A site, or over a base plane's rim the wall that stands on it there; the base itself where the wall is
    // a vessel's.
    struct Term {
        Site site;
        bool is_wall = false;

        friend bool operator==(const Term&, const Term&) = default;
    };
    using Terms = SmallVector<Term, 8>;

    // An edge over the rim has a face on one side alone, in one patch or several, and its side of the box
    // comes second.
    void find_equations() {
        is_rim_.assign(cell_.edges.size(), false);
        if (std::holds_alternative<Plane>(cell_.scene.base)) {
            std::vector<std::array<bool, 2>> has_face(cell_.edges.size(), {false, false});
            for (const CellFace& face : cell_.faces)
                for (const TrimCurve& trim : face.trims())
                    if (trim.edge) has_face[*trim.edge][trim.reversed ? 1 : 0] = true;
            for (std::size_t i = 0; i < has_face.size(); ++i) is_rim_[i] = has_face[i][0] != has_face[i][1];
        }
        constexpr std::size_t usual = 3;
        for (std::size_t i = 0; i < cell_.vertices.size(); ++i)
            if (cell_.vertices[i].sites.size() > usual) ties_[i] = moves_.ties;
        for (std::size_t i = 0; i < cell_.edges.size(); ++i) {
            const CellEdge& e = cell_.edges[i];
            for (const std::uint32_t v : e.vertices)
                for (const Term term : {Term{e.sites[0]}, Term{e.sites[1], is_rim_[i]}})
                    if (std::ranges::find(equations_[v], term) == equations_[v].end())
                        equations_[v].push_back(term);
        }
    }

    double shift_by_ties(const CellEdge& e) const { return e.extra_sites.empty() ? 0 : moves_.ties; }

    // A base ball has no direction that a motion would turn: other balls and tubes around it, and the box
    // around all of that, stay where they are.
    bool stays(const Term& term) const {
        return base_unit_.isZero(0) &&
               !(term.site.is_object() &&
                 std::holds_alternative<Plane>(cell_.scene.objects[cell_.scene.place(term.site.index)]));
    }

    Direction base(const Vec3& p) const { return from_foot(cell_.scene.base, base_unit_, p); }
    // `base`: the base's direction at p.
    Row row(const Term& term, const Vec3& p, const Direction& base) const {
        Row row = row_of(term, p, base);
        if (!stays(term)) row.shift = 2 * moves_.all;
        return row;
    }
    Row row_of(const Term& term, const Vec3& p, const Direction& base) const {
        const Site site = term.site;
        if (site.kind == Site::Kind::BoxSide) {
            const Vec3 side = Vec3::Unit(site.index / 2);
            if (!term.is_wall) return {side};
            // It and the base's direction, which are rounded, depend on the side's own.
            const Vec3 upright = side - base_unit_.dot(side) * base_unit_;
            const double length = upright.norm();
            return rounded(upright / length, 8 * u / length);
        }
        if (site.kind == Site::Kind::End || term.is_wall) return rounded(base_unit_, 4 * u);
        const std::size_t place = cell_.scene.place(site.index);
        const Direction object = from_foot(cell_.scene.objects[place], units_[place], p);
        const std::optional<Row> crossing = row_of_crossing(cell_.scene.base, cell_.scene.objects[place], p);
        Row row = crossing ? *crossing : vcell::difference(object, base);
        row.place = place;
        row.object = object;
        row.object.turns = object.direction && base.has_axis &&
                           cross(ExactVector(*object.direction), ExactVector(*base.direction)).is_zero();
        row.has_object = true;
        return row;
    }

    // The row of two objects' difference at p, in which the base takes no part. ties: of what shifts both.
    Row difference(const Row& b, const Row& a, double ties, const Vec3& p) const {
        if (!a.has_object || !b.has_object)
            return {b.value - a.value,
                    std::min(a.nearest, b.nearest),
                    a.turn + b.turn,
                    {},
                    a.shift + b.shift,
                    false,
                    a.rounding + b.rounding,
                    {},
                    b.derivative - a.derivative};
        const auto& objects = cell_.scene.objects;
        const auto crossing = row_of_crossing(objects[a.place], objects[b.place], p);
        Row row = crossing ? *crossing : vcell::difference(b.object, a.object);
        row.shift = std::max(a.shift, b.shift);
        if (!(a.object.turns || b.object.turns)) row.shift = std::min(2 * moves_.apart + ties, row.shift);
        return row;
    }

    static Row rounded(const Vec3& value, double rounding) {
        Row row{value};
        row.rounding = rounding;
        return row;
    }

    // The motion by the three equations that tell the point best; none where no bisectors cross.
    std::optional<double> of_vertex(const CellVertex& v, const Terms& terms, double ties) const {
        if (std::ranges::all_of(terms, [&](const Term& t) { return stays(t); })) return 0;
        const Direction base = this->base(v.point);
        SmallVector<Row, 4> rows;
        for (const Term& t : terms) {
            rows.push_back(row(t, v.point, base));
            rows.back().shift += ties;
        }
        double best = infinity;
        for (std::size_t i = 0; i < rows.size(); ++i)
            for (std::size_t j = i + 1; j < rows.size(); ++j)
                for (std::size_t k = j + 1; k < rows.size(); ++k) {
                    const std::array<const Row*, 3> r{&rows[i], &rows[j], &rows[k]};
                    best = std::min(best, of_rows(r, v.error));
                    for (int m = 0; m < 3; ++m) {
                        const Row &a = *r[m], b = difference(*r[(m + 1) % 3], a, ties, v.point),
                                  c = difference(*r[(m + 2) % 3], a, ties, v.point);
                        best = std::min(best, of_rows({&a, &b, &c}, v.error));
                    }
                }
        if (best == infinity) return std::nullopt;
        return best;
    }

    // Twice the Newton step, if rows do not turn by more than a quarter on twice that.
    double of_rows(const std::array<const Row*, 3>& rows, double error) const {
        Matrix3d M;
        for (int i = 0; i < 3; ++i) M.row(i) = rows[i]->value.transpose();
        const Matrix3d inverse = M.inverse();
        std::array<double, 3> length;
        for (int i = 0; i < 3; ++i) length[i] = inverse.col(i).norm();
        double step = 0, turn = 0;
        for (int i = 0; i < 3; ++i) step += rows[i]->shift * length[i];
        for (int i = 0; i < 3; ++i) turn += length[i] * rows[i]->variation(2 * error + 2 * step);
        return turn <= 0.25 ? 2 * step : infinity;
    }

    // Control points (p w, w) of one piece.
    struct Piece {
        int degree;
        std::array<Vector4d, 6> points;

        Vec3 point(int k) const { return points[k].head<3>() / points[k].w(); }
        // De Casteljau.
        std::array<Piece, 2> halves() const {
            std::array<Piece, 2> half;
            half[0].degree = half[1].degree = degree;
            std::array<Vector4d, 6>& work = half[1].points;
            std::copy_n(points.begin(), degree + 1, work.begin());
            for (int k = 0; k <= degree; ++k) {
                half[0].points[k] = work[0];
                for (int i = 0; i < degree - k; ++i) work[i] = 0.5 * (work[i] + work[i + 1]);
            }
            return half;
        }
    };

    double of_edge(const CellEdge& e, double position, bool is_rim) {
        const RationalCurve3& c = e.curve;
        const std::array terms{Term{e.sites[0]}, Term{e.sites[1], is_rim}};
        if (stays(terms[0]) && stays(terms[1])) return 0;
        const double ties = shift_by_ties(e);
        double most = 0;
        int halvings = most_halvings + spare_halvings_;
        Piece piece;
        piece.degree = c.degree;
        for (std::size_t i = 0; i + c.degree < c.points.size(); i += c.degree) {
            for (int k = 0; k <= c.degree; ++k) {
                const Vector4d& p = c.points[i + k];
                piece.points[k] << p.w() * p.head<3>(), p.w();
            }
            most = std::max(most, of_piece(terms, ties, position, piece, halvings));
        }
        spare_halvings_ = std::min(spare_halvings_, halvings);
        return most;
    }

    // Next to a point where the rows depend on each other (objects that touch, axes that cross) the arc goes
    // on from the part before to its end: it is no farther away than that part's size and motion.
    double of_piece(const std::array<Term, 2>& terms, double ties, double error, const Piece& piece,
                    int& halvings) const {
        const Vec3 middle = 0.5 * (piece.point(0) + piece.point(piece.degree));
        Part part;
        part.count = piece.degree + 1;
        for (int k = 0; k < part.count; ++k) {
            part.ways[k] = piece.point(k) - middle;
            part.radius = std::max(part.radius, part.ways[k].norm());
        }
        const double radius = part.radius + error;
        // Halves of what has numbers that are none have some, too, without end.
        if (!std::isfinite(radius)) return infinity;
        const Direction base = this->base(middle);
        Row a = row(terms[0], middle, base), b = row(terms[1], middle, base);
        a.shift += ties;
        b.shift += ties;
        // The motion itself must stay within reach, too: more than the first guess, where objects are all but
        // alike.
        double change = across(a, b, part, error + room_);
        if (change <= room_) return change;
        const Row apart = difference(b, a, ties, middle);
        for (double reach = room_; reach < most_; reach = 2 * change) {
            change = std::min(across(a, b, part, error + reach), across(a, apart, part, error + reach));
            if (change <= reach) return change;
        }
        // Halves of parts that are no longer than their place is known would not show more.
        const bool is_end = radius <= 2 * error + room_;
        if (is_end) return 4 * (radius + room_);
        if (halvings == 0) return infinity;
        --halvings;
        double most = 0;
        for (const Piece& half : piece.halves()) {
            most = std::max(most, of_piece(terms, ties, error, half, halvings));
            if (most == infinity) break;
        }
        return most;
    }

    // The motion across two rows, which may be anything they are so far from a part.
    double across(const Row& a, const Row& b, const Part& part, double away) const {
        const double va = a.variation(part, away), vb = b.variation(part, away);
        const double of_a = a.value.norm(), of_b = b.value.norm(), product = a.value.cross(b.value).norm(),
                     least = product - (of_a * vb + of_b * va + va * vb);
        // The vectors across that change one of the equations alone have the other row's length over the
        // product.
        return least > 0.125 * product ? (a.shift * (of_b + vb) + b.shift * (of_a + va)) / least : infinity;
    }

    static constexpr int most_halvings = 1000;  // of an edge
    // All edges that need more share these: along a tube that all but touches the base rows turn by as much
    // as their own length in each of thousands of parts.
    int spare_halvings_ = 20000;

    Cell& cell_;
    const IdVector<EdgeId, double>& positions_;
    const SceneMoves moves_;
    const double most_;
    const double room_;  // for the motion of a piece, as a first guess
    Vec3 base_unit_;
    std::vector<Vec3> units_;       // of the objects' directions
    std::vector<bool> is_rim_;      // of the edges
    std::vector<Terms> equations_;  // of the vertices
    std::vector<double> ties_;      // what ties in the vertices add to the shift of equations
};

}  // namespace

void add_scene_motion(LiftedCell& lifted, const SceneMoves& moves) {
    if (moves.all + moves.ties > 0) Motion(lifted, moves).run();
}

}  // namespace vcell
