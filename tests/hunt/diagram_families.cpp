#include "diagram_families.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <variant>
#include <vector>

#include "../../io/files/scene_file.hpp"
#include "dice.hpp"
#include "families.hpp"

namespace vcell::hunt {

std::string to_string(Room room) {
    switch (room) {
        case Room::Box: return "box";
        case Room::Pipe: return "pipe";
        case Room::Slit: return "slit";
        case Room::Repeating: return "repeating";
        case Room::Leaning: return "leaning";
    }
    return {};
}

namespace whole_scenes {

namespace {

/// A diagram's scene in the making, in a box from the origin. What is refused beside what is there already is
/// left out.
class DiagramBuilder : public Dice {
public:
    DiagramBuilder(std::mt19937_64& rng, Room room, double size) : Dice(rng), size_(size) {
        scene_.box = {Vec3::Zero(), Vec3::Constant(size)};
        scene_.periodic = {room != Room::Box, room != Room::Box && room != Room::Pipe,
                           room == Room::Repeating || room == Room::Leaning};
        if (room == Room::Leaning)
            for (double& t : scene_.tilt) t = 0.25 * size * count(-2, 2);
    }

    bool repeats() const { return scene_.is_periodic(); }
    Vec3 place_inside() { return {uniform(0, size_), uniform(0, size_), uniform(0, size_)}; }
    /// Multiples of a part of the box's size; not on its sides, but where it repeats: what is there has
    /// measures only. Pre: the parts are two or more.
    Vec3 node(int parts) {
        Vec3 p;
        for (std::size_t k = 0; k < 3; ++k)
            p[static_cast<int>(k)] = scene_.periodic[k] ? count(0, parts - 1) : count(1, parts - 1);
        return size_ / parts * p;
    }
    /// That a tube may have: of small integers, or of any numbers where the box does not repeat.
    Vec3 axis(bool of_integers) {
        if (!repeats()) return of_integers ? integer_direction(2) : direction();
        return scene_.edges() / size_ * integer_direction(1);
    }

    bool is_inside(const Vec3& p) const {
        return (scene_.box.min.array() < p.array()).all() && (p.array() < scene_.box.max.array()).all();
    }
    bool add(const Object& object) {
        for (const Object& other : scene_.objects)
            if (!is_clear(object, other)) return false;
        scene_.objects.push_back(object);
        return true;
    }
    template <class Make>
    void add_some(int n, const Make& make) {
        constexpr int tries = 50;
        for (int i = 0, added = 0; i < tries && added < n; ++i) added += add(make()) ? 1 : 0;
    }
    void add_random(int balls, int tubes) {
        add_some(balls, [&] { return Sphere{place_inside(), chance(0.2) ? 0 : size_ * uniform(0, 0.15)}; });
        add_some(tubes, [&] {
            return Cylinder{place_inside(), axis(false), chance(0.2) ? 0 : size_ * uniform(0, 0.1)};
        });
    }

    DiagramScene& scene() { return scene_; }
    DiagramScene done() { return std::move(scene_); }

private:
    // Does each have a cell beside the other one and its images?
    bool is_clear(const Object& a, const Object& b) const {
        const Eigen::Matrix3d edges = scene_.edges();
        const auto most = [&](int k) { return scene_.periodic[static_cast<std::size_t>(k)] ? 1 : 0; };
        for (int x = -most(0); x <= most(0); ++x)
            for (int y = -most(1); y <= most(1); ++y)
                for (int z = -most(2); z <= most(2); ++z) {
                    Object image = b;
                    transform(image, 1, edges * Vec3(x, y, z));
                    if (!has_cell(a, image) || !has_cell(image, a)) return false;
                }
        return true;
    }
    bool has_cell(const Object& object, const Object& other) const {
        if (is_vessel(object)) return true;
        Scene scene;
        scene.base = object;
        scene.objects = {other};
        const Vec3 room = Vec3::Constant(4 * size_);  // for images
        scene.box = {scene_.box.min - room, scene_.box.max + room};
        return is_legal(scene);
    }

    const double size_;
    DiagramScene scene_;
};

DiagramScene random(std::mt19937_64& rng, Room room) {
    DiagramBuilder b(rng, room, 4);
    if (!b.repeats()) b.add_some(b.count(0, 1), [&] { return Plane{b.place_inside(), b.direction()}; });
    b.add_random(b.count(1, 6), b.count(0, 3));
    return b.done();
}

DiagramScene balls(std::mt19937_64& rng, Room room) {
    DiagramBuilder b(rng, room, 4);
    b.add_random(b.count(8, 40), 0);
    return b.done();
}

// Coordinates of few bits.
DiagramScene integers(std::mt19937_64& rng, Room room) {
    const int size = 2 * std::uniform_int_distribution(1, 3)(rng);
    DiagramBuilder b(rng, room, size);
    const auto radius = [&] { return 0.25 * b.count(0, 2); };
    b.add_some(b.count(2, 6), [&]() -> Object {
        switch (b.count(0, b.repeats() ? 2 : 4)) {
            case 0: return Cylinder{b.node(size), b.axis(true), radius()};
            case 1:
            case 2:
            case 3: return Sphere{b.node(size), radius()};
            default: return Plane{b.node(size), b.integer_direction(1)};
        }
    });
    return b.done();
}

// One radius: bisectors are planes and hyperbolic paraboloids.
DiagramScene equals(std::mt19937_64& rng, Room room) {
    DiagramBuilder b(rng, room, 2);
    const double radius = 0.125 * b.count(0, 2);
    b.add_some(b.count(0, 6), [&] { return Sphere{b.node(4), radius}; });
    b.add_some(b.count(1, 3), [&] { return Cylinder{b.node(4), b.axis(true), radius}; });
    return b.done();
}

// Tubes of one radius along edges or diagonals, and balls between them.
DiagramScene rods(std::mt19937_64& rng, Room room) {
    DiagramBuilder b(rng, room, 2);
    const double radius = 0.0625 * b.count(1, 4);
    const int kind = b.count(0, 2);
    b.add_some(b.count(2, 5), [&] {
        Vec3 axis = Vec3::Zero();
        while (axis.isZero() || axis.cwiseAbs().sum() != kind + 1) axis = b.integer_direction(1);
        return Cylinder{b.node(b.chance(0.5) ? 2 : 4), b.scene().edges() * axis, radius};
    });
    b.add_some(b.count(0, 2), [&] { return Sphere{b.node(4), 0.125 * b.count(0, 2)}; });
    return b.done();
}

// Balls of a cubic, body- or face-centred lattice, some missing, some points; exact, or each coordinate one
// unit in the last place off.
DiagramScene lattice(std::mt19937_64& rng, Room room) {
    const int cells = std::uniform_int_distribution(1, 2)(rng);
    DiagramBuilder b(rng, room, 2 * cells);
    const int type = b.count(0, 2);
    const bool is_exact = b.chance(0.6);
    const double missing = b.chance(0.5) ? 0 : 0.2, off = 0.5 * b.count(0, 1);
    for (int x = 0; x < 4 * cells; ++x)
        for (int y = 0; y < 4 * cells; ++y)
            for (int z = 0; z < 4 * cells; ++z) {
                const int odd = (x & 1) + (y & 1) + (z & 1);
                const bool is_even = ((x | y | z) & 1) == 0, is_site = type == 0   ? is_even
                                                                       : type == 1 ? odd % 3 == 0
                                                                                   : odd % 2 == 0;
                if (!is_site || b.chance(missing)) continue;
                const Vec3 p = 0.5 * Vec3(x, y, z) + Vec3::Constant(0.5 * off);
                if (!b.is_inside(p)) continue;
                b.add(Sphere{is_exact ? p : b.ulps(p), b.chance(missing) ? 0 : 0.25});
            }
    return b.done();
}

// Balls and tubes that touch each other, exactly or but for 1e-16 to 1e-3.
DiagramScene tangent(std::mt19937_64& rng, Room room) {
    DiagramBuilder b(rng, room, 4);
    const double error = b.chance(0.5) ? 0 : b.small(3, 16);
    for (int i = b.count(2, 4); i > 0; --i) {
        const Vec3 axes[] = {Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()};
        const int k = b.count(0, 2);
        const Vec3 out = axes[k], along = b.scene().edges() / 4 * axes[(k + 1) % 3], p = b.node(8);
        const double r = 0.25 * b.count(0, 2), q = 0.25 * b.count(0, 2);
        const Vec3 next = p + (r + q + error) * out;
        b.add(b.chance(0.6) ? Object(Sphere{p, r}) : Object(Cylinder{p, along, r}));
        if (!b.is_inside(next)) continue;
        b.add(b.chance(0.6) ? Object(Sphere{next, q}) : Object(Cylinder{next, along, q}));
    }
    return b.done();
}

// Some objects twice, 1e-16 to 1e-3 apart.
DiagramScene twins(std::mt19937_64& rng, Room room) {
    DiagramBuilder b(rng, room, 4);
    const double error = b.small(3, 16);
    b.add_random(b.count(2, 5), b.count(0, 1));
    const std::vector<Object> first = b.scene().objects;
    for (Object o : first) {
        transform(o, 1, error * b.direction());
        b.add(o);
    }
    return b.done();
}

// The atoms of crambin in a cube.
DiagramScene molecule(std::mt19937_64& rng, Room room) {
    static const std::vector<Object> atoms = [] {
        TextSceneOptions options;
        options.base_plane = Plane{{-1e3, 0, 0}, Vec3::UnitX()};
        return read_scene(VCELL_TEST_DATA "/1CRN.xyzr", options).objects;
    }();
    const double size = std::uniform_real_distribution<double>(4, 10)(rng);
    DiagramBuilder b(rng, room, size);
    const auto k = static_cast<std::size_t>(b.count(0, static_cast<int>(atoms.size()) - 1));
    const Vec3 shift = Vec3::Constant(0.5 * size) - std::get<Sphere>(atoms[k]).center;
    for (Object atom : atoms) {
        transform(atom, 1, shift);
        const Vec3& c = std::get<Sphere>(atom).center;
        if ((c.array() > 0).all() && (c.array() < size).all()) b.add(atom);
    }
    return b.done();
}

// A box that is smaller than what is in it reaches: few objects among many images of theirs.
DiagramScene tight(std::mt19937_64& rng, Room room) {
    DiagramBuilder b(rng, room, 1);
    if (b.repeats()) b.scene().box.max.x() = b.uniform(0.1, 1);
    for (double& t : b.scene().tilt) t = std::min(t, 0.5 * b.scene().box.max.x());
    b.add_some(b.count(1, 3), [&] { return Sphere{b.place_inside(), b.uniform(0, 0.4)}; });
    return b.done();
}

// Cells that end at a probe.
DiagramScene probes(std::mt19937_64& rng, Room room) {
    DiagramScene scene = random(rng, room);
    scene.probe = std::uniform_real_distribution<double>(0.1, 2)(rng);
    return scene;
}

// Balls, tubes and planes in a vessel, or two.
DiagramScene vessels(std::mt19937_64& rng, Room room) {
    DiagramBuilder b(rng, room, 4);
    const Vec3 middle = Vec3::Constant(2);
    const bool is_exact = b.chance(0.3);
    const double wide = is_exact ? 0.5 * b.count(2, 4) : b.uniform(1, 2.5);
    if (!b.repeats()) {
        switch (b.count(0, 2)) {
            case 0: b.add(HollowSphere{middle, wide}); break;
            case 1:
                b.add(HollowCylinder{middle, is_exact ? Vec3::UnitZ().eval() : b.direction(), wide});
                break;
            default: {
                const Vec3 axis = is_exact ? Vec3::UnitZ().eval() : b.direction();
                b.add(HollowCone{middle - 2 * axis, axis, 3, 5});
            }
        }
    } else if (room == Room::Pipe) {
        b.add(HollowCylinder{middle, Vec3::UnitX(), wide});
    } else if (room == Room::Slit) {
        b.add(Plane{{0, 0, 0.5}, Vec3::UnitZ()});
        b.add(Plane{{0, 0, 3.5}, Vec3::UnitZ()});
    }
    b.add_some(b.count(2, 6), [&] {
        const Vec3 p = is_exact ? b.node(8) : b.place_inside();
        return Sphere{p, is_exact ? 0.25 * b.count(0, 2) : b.uniform(0, 0.5)};
    });
    if (room == Room::Pipe)
        b.add_some(b.count(0, 1), [&] { return Cylinder{b.node(8), Vec3::UnitX(), 0.25}; });
    return b.done();
}

DiagramScene scaled(std::mt19937_64& rng, Room room) {
    DiagramScene s = random(rng, room);
    const double exponents[] = {-100, -20, 20, 100};
    const double factor = std::exp2(exponents[std::uniform_int_distribution(0, 3)(rng)]);
    for (Object& o : s.objects) transform(o, factor, Vec3::Zero());
    s.box = {factor * s.box.min, factor * s.box.max};
    for (double& t : s.tilt) t *= factor;
    return s;
}

DiagramScene far(std::mt19937_64& rng, Room room) {
    DiagramScene s = random(rng, room);
    const Vec3 shift(1e6, -2e6, 5e5);
    for (Object& o : s.objects) transform(o, 1, shift);
    s.box = {s.box.min + shift, s.box.max + shift};
    return s;
}

constexpr DiagramFamily all_diagrams[] = {
    {"random", "random balls and tubes, and a plane where the box does not repeat", random},
    {"balls", "8 to 40 random balls and points", balls},
    {"integers", "points, lines, balls, tubes and planes of small integers", integers},
    {"equals", "balls and tubes of one radius on nodes of a grid", equals},
    {"rods", "tubes of one radius along edges or diagonals, and balls between them", rods},
    {"lattice", "cubic, body- and face-centred lattices, some balls missing, exact or one unit off", lattice},
    {"tangent", "objects that touch each other, or miss by 1e-16 to 1e-3", tangent},
    {"twins", "some objects twice, 1e-16 to 1e-3 apart", twins},
    {"molecule", "the atoms of crambin in a cube", molecule},
    {"tight", "balls in a box that is smaller than their cells are among their images", tight},
    {"probes", "random, cells ending at a probe", probes},
    {"vessels", "balls in hollow spheres, tubes and cones, or between planes", vessels},
    {"scaled", "random times a power of two up to 2^100", scaled},
    {"far", "random, a million away", far},
};

}  // namespace

}  // namespace whole_scenes

std::span<const DiagramFamily> diagram_families() { return whole_scenes::all_diagrams; }

}  // namespace vcell::hunt
