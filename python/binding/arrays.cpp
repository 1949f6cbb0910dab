#include "arrays.hpp"

#include <stdexcept>

namespace vcell::python {

namespace {

std::string shape_of(const py::array& array) {
    std::string text = "(";
    for (py::ssize_t k = 0; k < array.ndim(); ++k) text += (k ? ", " : "") + std::to_string(array.shape(k));
    return text + (array.ndim() == 1 ? ",)" : ")");
}

[[noreturn]] void refuse(const char* name, const std::string& what) {
    throw py::value_error(std::string(name) + ": " + what);
}

}  // namespace

Doubles doubles(py::handle value, const char* name) {
    Doubles result = Doubles::ensure(value);
    if (!result) refuse(name, "must be numbers, is " + std::string(py::repr(value)));
    return result;
}

Vec3 vec3(py::handle value, const char* name) {
    const Doubles v = doubles(value, name);
    if (v.ndim() != 1 || v.shape(0) != 3) refuse(name, "must have shape (3,), has " + shape_of(v));
    return Vec3(v.at(0), v.at(1), v.at(2));
}

Doubles rows(py::handle value, py::ssize_t width, const char* name) {
    Doubles v = doubles(value, name);
    if (v.ndim() != 2 || v.shape(1) != width)
        refuse(name, "must have shape (n, " + std::to_string(width) + "), has " + shape_of(v));
    return v;
}

Box box(py::handle value) {
    if (py::isinstance<Box>(value)) return value.cast<Box>();
    const Doubles v = doubles(value, "box");
    if (v.ndim() != 2 || v.shape(0) != 2 || v.shape(1) != 3)
        refuse("box", "must be a Box or have shape (2, 3), has " + shape_of(v));
    return {Vec3(v.at(0, 0), v.at(0, 1), v.at(0, 2)), Vec3(v.at(1, 0), v.at(1, 1), v.at(1, 2))};
}

std::int64_t number_of(const Site& site) {
    switch (site.kind) {
        case Site::Kind::Object: return site.index;
        case Site::Kind::BoxSide: return -1 - static_cast<std::int64_t>(site.index);
        case Site::Kind::Base:
        case Site::Kind::End: return -7;
        case Site::Kind::Cap: return -8;
    }
    return no_site;
}

}  // namespace vcell::python
