/// Numpy arrays in and out: checked shapes on the way in, contiguous arrays of their own on the way out.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "../../primitives/objects/objects.hpp"
#include "../../primitives/objects/site.hpp"

namespace vcell::python {

namespace py = pybind11;
using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// The numbers of anything that numpy takes for an array of doubles. Throws ValueError that begins with the
/// argument's name.
Doubles doubles(py::handle value, const char* name);

/// Three numbers as a point or a direction; throws as doubles().
Vec3 vec3(py::handle value, const char* name);
/// An array of shape (n, width); throws as doubles().
Doubles rows(py::handle value, py::ssize_t width, const char* name);
/// Pairs of three numbers, or a Box.
Box box(py::handle value);

/// An array of shape (3,), or of whatever length the vector has.
template <class V>
py::array_t<double> array_of(const V& v) {
    return py::array_t<double>(static_cast<py::ssize_t>(v.size()), v.data());
}

/// An array of shape (items.size(),) of T, of what `of` says of each item.
template <class T, class Items, class Of>
py::array_t<T> column(const Items& items, Of of) {
    py::array_t<T> result(static_cast<py::ssize_t>(items.size()));
    T* to = result.mutable_data();
    for (const auto& item : items) *to++ = static_cast<T>(of(item));
    return result;
}

/// An array of shape (items.size(), width) of T; `of` gives for each item what has [] below `width`.
template <class T, class Items, class Of>
py::array_t<T> table(const Items& items, std::size_t width, Of of) {
    py::array_t<T> result({items.size(), width});
    T* to = result.mutable_data();
    for (const auto& item : items) {
        const auto& row = of(item);
        for (std::size_t k = 0; k < width; ++k) *to++ = static_cast<T>(row[k]);
    }
    return result;
}

/// A read-only array of a vector's fixed-size rows without a copy; `owner`, which holds the vector and never
/// changes it, lives as long as the array.
template <class T, class Row>
py::array view(const std::vector<Row>& items, std::size_t width, py::handle owner) {
    static_assert(sizeof(Row) % sizeof(T) == 0);
    py::array result(py::dtype::of<T>(), {items.size(), width}, {sizeof(Row), sizeof(T)}, items.data(),
                     owner);
    py::detail::array_proxy(result.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
    return result;
}

/// Items of a vector as a list of references, each of which keeps `owner` alive, which holds the vector and
/// never changes it.
template <class Items>
py::list references(const Items& items, py::handle owner) {
    py::list result(items.size());
    std::size_t i = 0;
    for (const auto& item : items)
        result[i++] = py::cast(&item, py::return_value_policy::reference_internal, owner);
    return result;
}

/// Sites as whole numbers: objects are theirs, sides of the box -1 ... -6 (-x +x -y +y -z +z), the base and
/// the ends of its stretch -7, the cap where clearance ends -8.
std::int64_t number_of(const Site& site);
/// Where there is no site.
constexpr std::int64_t no_site = -9;

}  // namespace vcell::python
