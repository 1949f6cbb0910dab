#include "families.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "../../core/errors.hpp"
#include "../../io/files/scene_file.hpp"
#include "../../primitives/bases/plane_base.hpp"
#include "../../primitives/bases/radial_base.hpp"
#include "../../primitives/objects/decided_scene.hpp"
#include "../rotations.hpp"
#include "builder.hpp"

namespace vcell::hunt {

std::string to_string(BaseKind kind) {
    switch (kind) {
        case BaseKind::Plane: return "plane";
        case BaseKind::TiltedPlane: return "tilted-plane";
        case BaseKind::Ball: return "ball";
        case BaseKind::Tube: return "tube";
        case BaseKind::TiltedTube: return "tilted-tube";
    }
    return {};
}

// Of the scene as decided, as voronoi_cell() asks it: a ball that misses the base's axis by a subnormal
// number lies on it there.
bool is_legal(const Scene& scene) try {
    validate(scene);
    const DecidedScene decided = decide(scene);
    if (std::holds_alternative<Plane>(scene.base))
        plane_base_problem(decided.scene, decided.unit);
    else
        radial_base_problem(decided.scene, decided.unit);
    return true;
} catch (const InputError&) {
    return false;
} catch (const UndecidedError&) {
    return true;
}

void transform(Object& object, double factor, const Vec3& shift) {
    const auto place = [&](Vec3& p) { p = factor * p + shift; };
    if (auto* s = std::get_if<Sphere>(&object)) place(s->center), s->radius *= factor;
    if (auto* p = std::get_if<Plane>(&object)) place(p->point);
    if (auto* c = std::get_if<Cylinder>(&object)) place(c->point), c->radius *= factor;
    if (auto* s = std::get_if<HollowSphere>(&object)) place(s->center), s->radius *= factor;
    if (auto* c = std::get_if<HollowCylinder>(&object)) place(c->point), c->radius *= factor;
    if (auto* c = std::get_if<HollowCone>(&object)) place(c->apex), c->radius *= factor, c->slant *= factor;
}

namespace {

Scene balls(std::mt19937_64& rng, BaseKind kind) {
    Builder b(rng, kind);
    b.put_base(0.3);
    b.add_mix(b.count(2, 10), 0, 0);
    return b.done();
}

Scene mix(std::mt19937_64& rng, BaseKind kind) {
    Builder b(rng, kind);
    b.put_base(b.chance(0.2) ? 0 : 0.3);
    b.add_mix(b.count(0, 4), b.count(0, 2), b.count(1, 3));
    return b.done();
}

Scene tubes(std::mt19937_64& rng, BaseKind kind) {
    Builder b(rng, kind);
    b.put_base(b.chance(0.2) ? 0 : 0.3);
    b.add_mix(0, 0, b.count(2, 5));
    return b.done();
}

// Each one passes the axis of another one, or a base tube's.
Scene fibres(std::mt19937_64& rng, BaseKind kind) {
    Builder b(rng, kind);
    const double radius = b.chance(0.2) ? 0 : 0.3;
    b.put_base(radius);
    b.add_some(kind == BaseKind::Tube || kind == BaseKind::TiltedTube ? 0 : 1, [&] {
        return Cylinder{b.place(), b.direction(), radius};
    });
    const auto any = [&]() -> Cylinder {
        const std::vector<Object>& all = b.scene().objects;
        const int k = b.count(all.empty() ? -1 : 0, static_cast<int>(all.size()) - 1);
        if (const auto* base = std::get_if<Cylinder>(&b.scene().base); base && (k < 0 || b.chance(0.5)))
            return *base;
        return k < 0 ? Cylinder{b.place(), b.direction(), radius} : std::get<Cylinder>(all[k]);
    };
    b.add_some(b.count(1, 4), [&] {
        const Cylinder other = any();
        const Vec3 along = other.axis.normalized(), d = b.direction(), away = along.cross(d).normalized();
        return Cylinder{other.point + b.uniform(-1.5, 1.5) * along + b.small(0, 6) * away, d, radius};
    });
    b.add_mix(b.count(0, 2), 0, 0);
    return b.done();
}

// Balls and tubes that hold cross sections of a base tube, on its axis, beside it or across it, of any
// numbers or of quarters; of another base, of a tube beside it.
Scene beads(std::mt19937_64& rng, BaseKind kind) {
    Builder b(rng, kind);
    const bool are_quarters = b.chance(0.5);
    const double radius = 0.125 * b.count(0, 2);
    b.put_base(radius, are_quarters);
    const auto rounded = [&](const Vec3& p) {
        return are_quarters ? Vec3(0.25 * (4 * p.array()).round()) : p;
    };
    b.add_some(1, [&] { return Cylinder{rounded(b.place()), b.integer_direction(1), radius}; });
    const auto* base = std::get_if<Cylinder>(&b.scene().base);
    if (!base && b.scene().objects.empty()) return b.done();
    const Cylinder wire = base ? *base : std::get<Cylinder>(b.scene().objects[0]);
    const Vec3 along = wire.axis.normalized();
    constexpr int tries = 20;
    for (int i = 0, held = b.count(1, 3); i < tries && held > 0; ++i) {
        const double deep = 0.125 * b.count(1, 6);
        const Vec3 middle =
            rounded(wire.point + b.uniform(-2, 2) * along + b.uniform(0, deep) * b.direction());
        const bool is_ball = b.chance(0.5);
        const Vec3 axis = are_quarters ? b.integer_direction(1) : b.direction(), normal = along.cross(axis);
        const double apart = is_ball ? along.cross(middle - wire.point).norm()
                                     : std::abs(normal.normalized().dot(middle - wire.point));
        if (!(apart < 0.9 * deep) || normal.norm() < 0.2) continue;
        const Object holder =
            is_ball ? Object(Sphere{middle, radius + deep}) : Object(Cylinder{middle, axis, radius + deep});
        if (base)
            b.scene().objects.push_back(holder);
        else if (!b.add(holder))
            continue;
        --held;
    }
    // Where a base is held it is legal only alone: what touches it is told from it.
    Scene scene = b.done();
    Builder others(rng, kind);
    others.scene().base = scene.base;
    others.add_mix(others.count(0, 3), 0, others.count(0, 1));
    for (const Object& o : others.scene().objects) scene.objects.push_back(o);
    return scene;
}

// Tubes of one radius whose axes cross in a point: of the base's axis or of one beside the base, of any
// numbers or of quarters.
Scene crossings(std::mt19937_64& rng, BaseKind kind) {
    Builder b(rng, kind);
    const bool are_quarters = b.chance(0.5);
    const double radius = 0.125 * b.count(0, 2);
    b.put_base(radius, are_quarters);
    const auto direction = [&] { return are_quarters ? b.integer_direction(2) : b.direction(); };
    const auto* base = std::get_if<Cylinder>(&b.scene().base);
    Vec3 crossing = Vec3::Zero();
    if (base && are_quarters)
        crossing = 0.25 * b.count(-4, 4) * base->axis;
    else if (!base)
        crossing = are_quarters ? Vec3(0.25 * b.integers(6)) : b.place(1.5);
    // What crosses a base is legal only alone: what touches that is told from it.
    std::vector<Object> tubes;
    for (int i = b.count(1, 3); i > 0; --i) tubes.push_back(Cylinder{crossing, direction(), radius});
    if (!base) b.add_some(b.count(2, 3), [&] { return Cylinder{crossing, direction(), radius}; });
    b.add_mix(b.count(0, 3), 0, b.count(0, 1));
    Scene scene = b.done();
    if (std::holds_alternative<Cylinder>(scene.base))
        scene.objects.insert(scene.objects.begin(), tubes.begin(), tubes.end());
    return scene;
}

// Thin tubes through a ball or tube next to its centre or axis, the base or one beside it, of any numbers or
// of quarters.
Scene pierced(std::mt19937_64& rng, BaseKind kind) {
    Builder b(rng, kind);
    const bool are_quarters = b.chance(0.5);
    const double radius = 0.5 * b.count(1, 2);
    b.put_base(radius, are_quarters);
    const auto rounded = [&](const Vec3& p) {
        return are_quarters ? Vec3(0.25 * (4 * p.array()).round()) : p;
    };
    Vec3 middle = Vec3::Zero();
    if (b.is_plane()) {
        middle = rounded(b.place(1) + 1.5 * b.base_direction());
        b.add(b.chance(0.5) ? Object(Sphere{middle, radius})
                            : Object(Cylinder{middle, b.direction(), radius}));
    }
    b.add_some(b.count(1, 4), [&] {
        const double thin = 0.25 * radius * b.count(0, 3);
        return Cylinder{rounded(middle + b.uniform(0, radius) * b.direction()),
                        are_quarters ? b.integer_direction(1) : b.direction(), thin};
    });
    b.add_mix(b.count(0, 3), 0, b.count(0, 1));
    return b.done();
}

// Coordinates of few bits: full of exact ties.
Scene integers(std::mt19937_64& rng, BaseKind kind) {
    Builder b(rng, kind, 4);
    b.put_base(0.5 * b.count(0, 2), true);
    const auto radius = [&] { return 0.5 * b.count(0, 2); };
    b.add_some(b.count(2, 6), [&]() -> Object {
        switch (b.count(0, 2)) {
            case 0: return Plane{b.integers(3), b.integer_direction(2)};
            case 1: return Sphere{b.integers(3), radius()};
            default: return Cylinder{b.integers(3), b.integer_direction(2), radius()};
        }
    });
    return b.done();
}

// Bisectors of balls of the base's radius are planes of small integers: some run through edges of the box,
// and where four centres are a rectangle three tie along a curve. A tube makes the other heights no planes.
Scene equals(std::mt19937_64& rng, BaseKind kind) {
    Builder b(rng, kind, 2);
    const double radius = 0.25 * b.count(0, 1);
    b.put_base(radius, true);
    b.add_some(b.count(2, 6), [&] { return Sphere{b.integers(2), radius}; });
    b.add_some(b.count(1, 2), [&] { return Cylinder{b.integers(2), b.integer_direction(1), radius}; });
    return b.done();
}

// Cubic, body- or face-centred, each coordinate exact or one unit in the last place off.
Scene lattice(std::mt19937_64& rng, BaseKind kind) {
    Builder b(rng, kind, 2.5);
    b.put_base(0.25, true);
    const int type = b.count(0, 2);
    const bool is_exact = b.chance(0.5);
    const double spacing = b.chance(0.5) ? 1 : 1.1;
    for (int x = -4; x <= 4; ++x)
        for (int y = -4; y <= 4; ++y)
            for (int z = -4; z <= 4; ++z) {
                const int odd = (x & 1) + (y & 1) + (z & 1);
                const bool is_site = type == 0 ? odd == 0 : type == 1 ? odd % 3 == 0 : odd % 2 == 0;
                const Vec3 p = 0.5 * spacing * Vec3(x, y, z);
                if (is_site && p.norm() < 1.8) b.add(Sphere{is_exact ? p : b.ulps(p), 0.25});
            }
    return b.done();
}

// Equal tubes, square, hexagonal or woven; turned, and perturbed or not. A ball or a tube has the place in
// the middle.
Scene bundle(std::mt19937_64& rng, BaseKind kind) {
    Builder b(rng, kind);
    const double radius = b.chance(0.2) ? 0 : 0.2;
    b.put_base(radius);
    const int type = b.count(0, 2);
    const double error = b.chance(0.3) ? 0 : b.small(3, 15);
    const bool along_base = !b.is_plane() && b.chance(0.5);
    Eigen::Matrix3d frame = Eigen::Matrix3d::Identity();
    if (along_base) {
        const Vec3 axis = b.base_direction();
        frame = rotation_from_z(axis.z() < 0 ? Vec3(-axis) : axis).toRotationMatrix();
    } else if (b.chance(0.5))
        frame = Eigen::AngleAxisd(b.uniform(0, 3), b.direction()).toRotationMatrix();
    const double shift = b.is_plane() ? 0.5 : 0;  // a plane runs between the tubes
    for (int i = -1; i <= 1; ++i)
        for (int j = -1; j <= 1; ++j) {
            if (!b.is_plane() && i == 0 && j == 0) continue;
            const double x = type == 1 ? i + 0.5 * j : i, y = type == 1 ? std::sqrt(0.75) * j : j;
            Vec3 p(x + shift, y + shift, 0), axis = Vec3::UnitZ();
            if (type == 2 && (i & 1)) {  // layers across each other
                p = Vec3(x + shift, 0, y + shift);
                axis = Vec3::UnitY();
            }
            p = frame * p + error * b.direction();
            axis = frame * axis + error * b.direction();
            b.add(Cylinder{p, axis, radius});
        }
    return b.done();
}

// Each object twice, apart by next to nothing; often the base, too.
Scene twins(std::mt19937_64& rng, BaseKind kind) {
    Builder b(rng, kind);
    b.put_base(b.chance(0.2) ? 0 : 0.3);
    const double error = b.small(3, 16);
    b.add_mix(b.count(0, 2), b.count(0, 1), b.count(0, 2));
    std::vector<Object> first = b.scene().objects;
    if (b.chance(0.3)) first.push_back(b.scene().base);
    for (Object& o : first) {
        transform(o, 1, error * b.direction());
        if (auto* c = std::get_if<Cylinder>(&o)) c->axis += error * b.direction();
        if (auto* p = std::get_if<Plane>(&o)) p->normal += error * b.direction();
        b.add(o);
    }
    return b.done();
}

// Objects that all but touch the base.
Scene contact(std::mt19937_64& rng, BaseKind kind) {
    Builder b(rng, kind);
    const double radius = b.chance(0.3) ? 0 : 0.5;
    b.put_base(radius);
    const Vec3 d = b.base_direction();
    b.add_some(b.count(1, 3), [&]() -> Object {
        const double gap = b.small(1, 12);
        Vec3 out = b.direction();
        if (b.is_plane()) out = d;
        if (std::holds_alternative<Cylinder>(b.scene().base)) out = (out - out.dot(d) * d).normalized();
        const Vec3 across = out.cross(b.direction()).normalized();
        const Vec3 foot = b.is_plane() ? b.uniform(-1, 1) * across
                                       : b.uniform(-1, 1) * (kind == BaseKind::Ball ? 0 : 1) * d;
        const double rho = b.chance(0.3) ? 0 : b.uniform(0.1, 0.5), start = b.is_plane() ? 0 : radius;
        switch (b.count(0, b.is_plane() || kind == BaseKind::Ball ? 2 : 1)) {
            case 0: return Sphere{foot + (start + gap + rho) * out, rho};
            case 1: return Cylinder{foot + (start + gap + rho) * out, across, rho};
            default: return Plane{foot + (start + gap) * out, out};
        }
    });
    b.add_mix(b.count(0, 2), 0, b.count(0, 1));
    return b.done();
}

// Pairs of objects tangent to each other, or almost.
Scene tangent(std::mt19937_64& rng, BaseKind kind) {
    Builder b(rng, kind);
    b.put_base(0.25, true);
    const double error = b.chance(0.4) ? 0 : b.small(3, 16);
    b.add_some(b.count(1, 2), [&]() -> Object {
        const Vec3 axes[] = {Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()};
        const int k = b.count(0, 2);
        const Vec3 out = axes[k], along = axes[(k + 1) % 3];
        const Vec3 p = 0.25 * b.integers(6);
        const double r = 0.25 * b.count(0, 2), q = 0.25 * b.count(0, 2);
        const Vec3 next = p + (r + q + error) * out;
        switch (b.count(0, 3)) {
            case 0: b.add(Sphere{next, q}); break;
            case 1: b.add(Cylinder{next, along, q}); break;
            case 2: b.add(Cylinder{next, (along + out.cross(along)).eval(), q}); break;
            default: b.add(Plane{p + (r + error) * out, out}); break;
        }
        if (b.chance(0.5)) return Sphere{p, r};
        return Cylinder{p, along, r};
    });
    b.add_mix(b.count(0, 2), 0, 0);
    return b.done();
}

// Rods and points in all symmetric places around the base.
Scene symmetric(std::mt19937_64& rng, BaseKind kind) {
    Builder b(rng, kind, 3);
    b.put_base(0.25, true);
    const int x = b.count(0, 2), y = b.count(0, 2), z = b.count(1, 2);
    const double radius = 0.25 * b.count(0, 2), error = b.chance(0.5) ? 0 : b.small(3, 16);
    const bool are_tubes = b.chance(0.5);
    for (const int sx : {-1, 1})
        for (const int sy : {-1, 1})
            for (const int sz : {-1, 1}) {
                const Vec3 p = Vec3(sx * x, sy * y, sz * z) + error * b.direction();
                if (are_tubes)
                    b.add(Cylinder{
                        p, Vec3(sx * y, -sy * x, 0).isZero() ? Vec3(1, 0, 0) : Vec3(sx * y, -sy * x, 0),
                        radius});
                else
                    b.add(Sphere{p, radius});
            }
    return b.done();
}

Scene transformed(Scene s, double factor, const Vec3& shift) {
    transform(s.base, factor, shift);
    for (Object& o : s.objects) transform(o, factor, shift);
    s.box = {factor * s.box.min + shift, factor * s.box.max + shift};
    return s;
}

Scene scaled(std::mt19937_64& rng, BaseKind kind) {
    const double exponents[] = {-100, -30, 30, 100};
    const double factor = std::exp2(exponents[std::uniform_int_distribution(0, 3)(rng)]);
    return transformed(mix(rng, kind), factor, Vec3::Zero());
}

// Rounding moves what was clear of the base: only legal scenes count.
Scene far(std::mt19937_64& rng, BaseKind kind) {
    for (;;)
        if (const Scene s = transformed(mix(rng, kind), 1, Vec3(1e6, -2e6, 5e5)); is_legal(s)) return s;
}

// The base among the atoms of crambin.
Scene molecule(std::mt19937_64& rng, BaseKind kind) {
    static const std::vector<Object> atoms = [] {
        TextSceneOptions options;
        options.base_plane = Plane{{-1e3, 0, 0}, Vec3::UnitX()};
        return read_scene(VCELL_TEST_DATA "/1CRN.xyzr", options).objects;
    }();
    Builder b(rng, kind, 12);
    const auto center = [](const Object& o) { return std::get<Sphere>(o).center; };
    const std::size_t k = std::uniform_int_distribution<std::size_t>(0, atoms.size() - 1)(rng);
    const Vec3 shift = -center(atoms[k]);
    b.put_base(std::get<Sphere>(atoms[k]).radius);
    std::vector<Object> near = atoms;
    std::ranges::sort(near, {}, [&](const Object& o) { return (center(o) + shift).norm(); });
    for (std::size_t i = 1; i < near.size() && i <= 40; ++i) {
        transform(near[i], 1, shift);
        b.add(near[i]);
    }
    return b.done();
}

// Walls that the box cuts or leaves out, the base anywhere within, and what lies on both sides of them.
Scene vessels(std::mt19937_64& rng, BaseKind kind) {
    Builder b(rng, kind);
    b.put_base(b.chance(0.2) ? 0 : 0.3);
    b.add_some(b.count(1, 3), [&] { return b.random_vessel(); });
    b.add_mix(b.count(0, 3), b.count(0, 1), b.count(0, 2));
    return b.done();
}

// Vessels of small integers and what is in them: on their axes, in their tips, touching their walls.
Scene silos(std::mt19937_64& rng, BaseKind kind) {
    Builder b(rng, kind, 4);
    b.put_base(0.5 * b.count(0, 2), true);
    const auto radius = [&] { return 0.5 * b.count(0, 2); };
    const auto axis = [&] {
        const auto* c = std::get_if<Cylinder>(&b.scene().base);
        return c && b.chance(0.7) ? c->axis : b.chance(0.5) ? Vec3::UnitZ().eval() : b.integer_direction(2);
    };
    b.add_some(b.count(1, 2), [&]() -> Object {
        const Vec3 middle = b.chance(0.4) ? Vec3::Zero().eval() : b.integers(2);
        switch (b.count(0, 2)) {
            case 0: return HollowSphere{middle, 0.5 * b.count(1, 12)};
            case 1: return HollowCylinder{middle, axis(), 0.5 * b.count(1, 8)};
            default: {
                const double rims[][2] = {{1, 2}, {3, 5}, {4, 5}, {5, 13}, {1, 8}};
                const auto& [rim, slant] = rims[b.count(0, 4)];
                const Vec3 along = axis();
                return HollowCone{middle - b.count(0, 4) * along, along, rim, slant};
            }
        }
    });
    b.add_some(b.count(0, 4), [&]() -> Object {
        switch (b.count(0, 4)) {
            case 0: return Plane{b.integers(3), b.integer_direction(2)};
            case 1: return Plane{Vec3(0, 0, b.count(-3, 3)), Vec3::UnitZ()};
            case 2: return Sphere{b.integers(3), radius()};
            case 3: return Sphere{Vec3(0, 0, b.count(-3, 3)), radius()};
            default: return Cylinder{b.integers(3), axis(), radius()};
        }
    });
    return b.done();
}

// A vessel in another one: equal, about one centre or axis, touching from within, or all but so; balls that
// touch its wall.
Scene nested(std::mt19937_64& rng, BaseKind kind) {
    Builder b(rng, kind);
    b.put_base(b.chance(0.2) ? 0 : 0.25, true);
    const double error = b.chance(0.4) ? 0 : (b.chance(0.5) ? 1 : -1) * b.small(3, 16);
    b.add_some(1, [&] { return b.random_vessel(); });
    if (b.scene().objects.empty()) return b.done();
    const Object first = b.scene().objects[0];
    b.add_some(b.count(1, 2), [&]() -> Object {
        const Vec3 out = b.direction();
        const double part = b.uniform(0.3, 1);
        if (const auto* s = std::get_if<HollowSphere>(&first)) {
            const double inner = part * s->radius, shift = s->radius - inner + error;
            switch (b.count(0, 4)) {
                case 0: return HollowSphere{s->center + error * out, s->radius};
                case 1: return HollowSphere{s->center, s->radius + error};
                case 2: return HollowSphere{s->center + shift * out, inner};
                case 3: return HollowCylinder{s->center + error * out, b.vessel_axis(), s->radius};
                default: return Sphere{s->center + (shift - 0.2 * inner) * out, 0.2 * inner};
            }
        }
        if (const auto* c = std::get_if<HollowCylinder>(&first)) {
            const Vec3 across = out.cross(c->axis).normalized();
            const double inner = part * c->radius, shift = c->radius - inner + error;
            switch (b.count(0, 4)) {
                case 0: return HollowCylinder{c->point + error * out, c->axis, c->radius};
                case 1: return HollowCylinder{c->point, c->axis, c->radius + error};
                case 2: return HollowCylinder{c->point + shift * across, c->axis, inner};
                case 3: return HollowSphere{c->point, c->radius + error};
                default: return Sphere{c->point + (shift + 0.8 * inner) * across, 0.2 * inner};
            }
        }
        const auto& c = std::get<HollowCone>(first);
        const Vec3 along = c.axis.normalized();
        const double high = b.uniform(1, 4);
        switch (b.count(0, 4)) {
            case 0: return HollowCone{c.apex + error * out, c.axis, c.radius, c.slant};
            case 1: return HollowCone{c.apex + error * along, c.axis, c.radius, c.slant};
            case 2: return HollowCone{c.apex, c.axis, part * c.radius, c.slant};
            case 3: return HollowSphere{c.apex + high * along, c.sine() * high + error};
            default: return Sphere{c.apex + high * along, b.uniform(0, 0.3)};  // on the axis, in tips' way
        }
    });
    b.add_mix(b.count(0, 2), 0, b.count(0, 1));
    return b.done();
}

// Rounding moves walls and axes: only legal scenes count.
Scene displaced(std::mt19937_64& rng, BaseKind kind) {
    for (;;) {
        const double factor = std::exp2(std::uniform_int_distribution(-90, 90)(rng));
        const bool is_far = std::uniform_int_distribution(0, 1)(rng) == 1;
        const Scene s = is_far ? transformed(vessels(rng, kind), 1, Vec3(1e5, -2e5, 5e4))
                               : transformed(vessels(rng, kind), factor, Vec3::Zero());
        if (is_legal(s)) return s;
    }
}

constexpr Family all[] = {
    {"balls", "random balls and points", balls},
    {"mix", "random balls, planes and tubes", mix},
    {"tubes", "random skew tubes and lines", tubes},
    {"fibres", "tubes of one radius, axes 1e-6 to 1 from each other: they cut each other", fibres},
    {"integers", "planes, points, lines, balls and tubes of small integers", integers},
    {"beads", "balls and tubes that hold cross sections of the base tube, or of one beside the base", beads},
    {"crossings", "tubes of one radius whose axes cross in a point, of the base's axis or beside it",
     crossings},
    {"pierced", "thin tubes through a ball or tube next to its centre or axis", pierced},
    {"equals", "balls and tubes of the base's radius, of small integers: planes through edges of the box",
     equals},
    {"lattice", "balls of a lattice, exact or one unit in the last place off", lattice},
    {"bundle", "equal tubes, square, hexagonal or woven, turned and perturbed by 1e-15 to 1e-3", bundle},
    {"twins", "each object twice, and the base, too, 1e-16 to 1e-3 apart", twins},
    {"contact", "objects 1e-12 to 0.1 from the base", contact},
    {"tangent", "objects that touch each other, or miss by 1e-16 to 1e-3", tangent},
    {"symmetric", "points, balls, lines or tubes in symmetric places", symmetric},
    {"scaled", "mix times a power of two up to 2^100", scaled},
    {"far", "mix a million away", far},
    {"molecule", "atoms of crambin around the base", molecule},
    {"vessels", "random balls, planes and tubes in hollow spheres, tubes and cones", vessels},
    {"silos", "vessels of small integers, and what touches their walls or stands on their axes", silos},
    {"nested", "vessels equal, in each other and touching, exactly or but for 1e-16 to 1e-3", nested},
    {"displaced", "vessels times a power of two up to 2^90, or 1e5 away", displaced},
};

}  // namespace

std::span<const Family> families() { return all; }

}  // namespace vcell::hunt
