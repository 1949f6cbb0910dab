#include "own_periods.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "../../core/errors.hpp"

namespace vcell::whole {

namespace {

constexpr double nothing = 0x1p-40;  // of a direction's largest component

// The shortest whole combination of edges along an axis, which is in the box's coordinates; none: its images
// crowd. Zero: it leaves through a side that does not repeat.
std::optional<Image> period_along(const Lattice& lattice, const Vec3& axis) {
    const Vec3 unit = axis / axis.cwiseAbs().maxCoeff();
    for (int k = 0; k < 3; ++k)
        if (!lattice.repeats(k) && std::abs(unit[k]) > nothing) return Image{0, 0, 0};
    for (int most = 1; most <= most_edges_of_period; ++most) {
        const Vec3 edges = most * unit;
        const Vec3 whole = edges.array().round();
        if ((edges - whole).cwiseAbs().maxCoeff() > most * nothing) continue;
        return Image{static_cast<std::int16_t>(whole[0]), static_cast<std::int16_t>(whole[1]),
                     static_cast<std::int16_t>(whole[2])};
    }
    return std::nullopt;
}

std::vector<Image> all_edges(const Lattice& lattice) {
    std::vector<Image> edges;
    for (int k = 0; k < 3; ++k)
        if (lattice.repeats(k)) edges.emplace_back(Image{0, 0, 0})[static_cast<std::size_t>(k)] = 1;
    return edges;
}

using Row = std::array<std::int64_t, 3>;

// row - factor * by
void subtract(Row& row, std::int64_t factor, const Row& by) {
    for (std::size_t k = 0; k < 3; ++k) row[k] -= factor * by[k];
}

std::int64_t floor_of_quotient(std::int64_t a, std::int64_t b) {
    const std::int64_t quotient = a / b;
    return a % b != 0 && (a < 0) != (b < 0) ? quotient - 1 : quotient;
}

}  // namespace

std::optional<std::vector<Image>> own_periods(const Lattice& lattice, const Object& object) {
    if (!lattice.repeats()) return std::vector<Image>{};
    if (const auto* tube = std::get_if<Cylinder>(&object)) {
        const auto period = period_along(lattice, lattice.in_edges(tube->axis));
        if (!period) return std::nullopt;
        return *period == Image{0, 0, 0} ? std::vector<Image>{} : std::vector{*period};
    }
    std::vector<Image> edges = all_edges(lattice);
    if (const auto* plane = std::get_if<Plane>(&object)) {
        const Vec3 n = plane->normal / plane->normal.cwiseAbs().maxCoeff();
        for (int k = 0; k < 3; ++k)
            if (lattice.repeats(k) && std::abs(n[k]) > nothing) return std::nullopt;
        return edges;
    }
    const auto* vessel = std::get_if<HollowCylinder>(&object);
    if (vessel == nullptr || edges.size() > 1) return std::nullopt;
    const auto period = period_along(lattice, lattice.in_edges(vessel->axis));
    return period && *period != Image{0, 0, 0} ? std::optional(edges) : std::nullopt;
}

double align(const Lattice& lattice, std::span<const Image> periods, Object& object) {
    if (periods.empty()) return 0;
    if (auto* plane = std::get_if<Plane>(&object)) {
        const Vec3 before = plane->normal;
        for (int k = 0; k < 3; ++k)
            if (lattice.repeats(k)) plane->normal[k] = 0;
        return (plane->normal - before).norm() / before.norm() * lattice.edges().norm();
    }
    const auto turn = [&](auto& tube) {
        const Vec3 along = lattice.shift(periods.front());
        const double off = along.cross(tube.axis.stableNormalized()).norm();
        tube.axis = along;
        return off;
    };
    if (auto* tube = std::get_if<Cylinder>(&object)) return turn(*tube);
    return turn(std::get<HollowCylinder>(object));
}

Image representative(const Image& image, std::span<const Image> periods) {
    if (periods.empty()) return image;
    std::vector<Row> rows;
    for (const Image& p : periods) rows.push_back({p[0], p[1], p[2]});
    Row rest{image[0], image[1], image[2]};
    // The periods' lattice in echelon form, a column at a time: of what is left of the rows one keeps the
    // greatest common divisor, which the image's number is reduced by.
    std::size_t done = 0;
    for (std::size_t k = 0; k < 3 && done < rows.size(); ++k) {
        Row& first = rows[done];
        for (std::size_t i = done + 1; i < rows.size(); ++i)
            while (rows[i][k] != 0) {
                subtract(first, floor_of_quotient(first[k], rows[i][k]), rows[i]);
                std::swap(first, rows[i]);
            }
        if (first[k] == 0) continue;
        const std::int64_t divisor = std::abs(first[k]), sign = first[k] < 0 ? -1 : 1;
        subtract(rest, sign * floor_of_quotient(2 * rest[k] + divisor, 2 * divisor), first);
        ++done;
    }
    Image result{};
    for (std::size_t k = 0; k < 3; ++k) {
        if (std::abs(rest[k]) > std::numeric_limits<std::int16_t>::max())
            throw InputError(InputError::Kind::OutOfRange, InputError::no_object, "box",
                             "repeats so that objects are too many of its edges apart");
        result[k] = static_cast<std::int16_t>(rest[k]);
    }
    return result;
}

}  // namespace vcell::whole
