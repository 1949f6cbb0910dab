/// A scene: one base, its objects, and the box that clips the cell.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "objects.hpp"
#include "site.hpp"

namespace vcell {

/// An object of a whole diagram, moved by so many edges of a box that repeats.
struct ObjectImage {
    std::uint32_t number = 0;
    std::array<std::int16_t, 3> image{0, 0, 0};

    friend auto operator<=>(const ObjectImage&, const ObjectImage&) = default;
};
/// "3(0,-1,0)", or "3" where it is not moved: as files write it.
std::string to_string(const ObjectImage& object);

struct Scene {
    Object base;
    std::vector<Object> objects;
    /// The object that is the base itself, in scenes that number the base among the others: equal to it, and
    /// no competitor.
    std::optional<std::uint32_t> base_object;
    std::vector<std::string> names;  ///< empty, or one (possibly empty) name for each object
    /// Empty: sites and messages name the objects by their places in `objects`. Otherwise by these numbers,
    /// ascending: `objects` are then some of a larger scene's (cell_changes.hpp), and files are written of
    /// that.
    std::vector<std::uint32_t> numbers;
    /// Empty, or what `objects` are in a box that repeats, ascending (DiagramOptions::visit). Sites are
    /// places then, as images have no numbers of their own, and messages name the images.
    std::vector<ObjectImage> images;
    std::string base_name;
    Box box;
    std::string units = "mm";
    /// Length; none: as of fit_tolerance(). Curves around a ball or tube are no farther from the true ones
    /// than 1e-4 of what the cell reaches from its centre or axis either.
    std::optional<double> tolerance;
    /// The cell ends where its clearance is this (> 0, length; the field's probe radius), in a cap that has
    /// the site Site::cap(): about a ball or tube a sphere or tube of radius base + probe, over a plane one
    /// that is so far before it. Areas of its faces are the accessible surface.
    std::optional<double> probe;

    /// How far fitted curves may be from the true ones, in length: the tolerance, by default 1e-7 of the
    /// box's diagonal.
    double fit_tolerance() const { return tolerance.value_or(1e-7 * box.diagonal()); }
    bool competes(std::size_t object) const { return !base_object || *base_object != object; }
    std::uint32_t number(std::size_t object) const {
        return numbers.empty() ? static_cast<std::uint32_t>(object) : numbers[object];
    }
    /// The place of the object of that number. Pre: there is one.
    std::size_t place(std::uint32_t number) const;
};

/// The base in its box.
Scene base_alone(const Scene& scene);

/// Validates a scene on its own: finite numbers, non-zero directions, radii >= 0, a proper box, and
/// magnitudes whose products stay in the double range: coordinates, radii and components up to 1e60, a
/// direction's largest component and the box's extents at least 1e-60; a base_object that is the base; a
/// tolerance and a probe > 0.
/// Throws InputError with the scene file's path of the first offender. Whether objects stay clear of
/// the base is decided with the cell, by exact signs.
void validate(const Scene& scene);

/// The side of the box at an end (Site::end()) of a base that is a tube along one of the box's axes; other
/// sites as they are.
Site side_at_end(const Scene& scene, Site site);

/// The path of an object as the scene file names it: "objects[3].sphere". `field` is appended after
/// a dot when given.
std::string object_path(const Scene& scene, std::size_t object, const std::string& field = {});

/// "object 3 (O1)" or "object 3", for messages.
std::string object_title(const Scene& scene, std::size_t object);
/// How messages name a competitor: an object by its title, a side of the box as "side box:-x".
std::string competitor_title(const Scene& scene, Site site);

}  // namespace vcell
