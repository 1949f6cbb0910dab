// Objects, boxes, scenes of one cell and of whole diagrams, and the files they come from.
#include "../../primitives/objects/scene.hpp"

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <filesystem>
#include <sstream>

#include "../../envelope/voronoi_diagram.hpp"
#include "../../io/files/diagram_file.hpp"
#include "../../io/files/scene_file.hpp"
#include "arrays.hpp"
#include "binding.hpp"

namespace vcell::python {

namespace {

std::string text_of(const Vec3& v) { return py::repr(array_of(v).attr("tolist")()); }
std::string text_of(double x) { return py::repr(py::float_(x)); }

template <class T>
auto equal() {
    return [](const T& a, const py::object& b) { return py::isinstance<T>(b) && a == b.cast<T>(); };
}

/// A sequence of objects, or balls as rows x, y, z, r.
std::vector<Object> objects_of(const py::object& given) {
    std::vector<Object> objects;
    if (py::isinstance<py::array>(given)) {
        const Doubles balls = rows(given, 4, "objects");
        const auto at = balls.unchecked<2>();
        objects.reserve(at.shape(0));
        for (py::ssize_t i = 0; i < at.shape(0); ++i)
            objects.push_back(Sphere{Vec3(at(i, 0), at(i, 1), at(i, 2)), at(i, 3)});
        return objects;
    }
    for (const py::handle item : given) {
        if (!py::isinstance<Plane>(item) && !py::isinstance<Sphere>(item) &&
            !py::isinstance<Cylinder>(item) && !py::isinstance<HollowSphere>(item) &&
            !py::isinstance<HollowCylinder>(item) && !py::isinstance<HollowCone>(item))
            throw py::type_error("objects[" + std::to_string(objects.size()) +
                                 "]: must be a Plane, a Sphere, a Cylinder or a vessel, is " +
                                 std::string(py::repr(item)));
        objects.push_back(item.cast<Object>());
    }
    return objects;
}

std::optional<Box> maybe_box(const py::object& given) {
    if (given.is_none()) return std::nullopt;
    return box(given);
}

BallFileOptions file_options(std::optional<std::size_t> frame, std::map<std::string, double> radii,
                             bool hydrogens, bool water, bool hetero,
                             const std::optional<std::string>& group) {
    BallFileOptions options;
    options.frame = frame;
    options.radii = std::move(radii);
    options.has_hydrogens = hydrogens;
    options.leaves_water = !water;
    options.leaves_hetero = !hetero;
    if (group && *group != "residue" && *group != "chain")
        throw py::value_error("group: must be \"residue\" or \"chain\", is \"" + *group + "\"");
    if (group)
        options.group = *group == "chain" ? BallFileOptions::Group::Chain : BallFileOptions::Group::Residue;
    return options;
}

template <class Ball, class Radius>
void bind_round(py::module_& m, const char* name, const char* doc, const Radius& radius) {
    py::class_<Ball>(m, name, doc)
        .def(py::init([](py::handle center, double r) {
                 return Ball{vec3(center, "center"), r};
             }),
             py::arg("center"), radius)
        .def_property_readonly(
            "center", [](const Ball& s) { return array_of(s.center); }, "Shape (3,).")
        .def_readonly("radius", &Ball::radius)
        .def("__eq__", equal<Ball>())
        .def("__repr__", [name](const Ball& s) {
            return std::string(name) + "(center=" + text_of(s.center) + ", radius=" + text_of(s.radius) + ")";
        });
}

template <class Tube, class Radius>
void bind_tube(py::module_& m, const char* name, const char* doc, const Radius& radius) {
    py::class_<Tube>(m, name, doc)
        .def(py::init([](py::handle point, py::handle axis, double r) {
                 return Tube{vec3(point, "point"), vec3(axis, "axis"), r};
             }),
             py::arg("point"), py::arg("axis"), radius)
        .def_property_readonly(
            "point", [](const Tube& c) { return array_of(c.point); }, "Shape (3,).")
        .def_property_readonly(
            "axis", [](const Tube& c) { return array_of(c.axis); }, "Shape (3,).")
        .def_readonly("radius", &Tube::radius)
        .def("__eq__", equal<Tube>())
        .def("__repr__", [name](const Tube& c) {
            return std::string(name) + "(point=" + text_of(c.point) + ", axis=" + text_of(c.axis) +
                   ", radius=" + text_of(c.radius) + ")";
        });
}

void bind_objects(py::module_& m) {
    py::class_<Plane>(
        m, "Plane",
        "The plane through `point` across `normal`, which need not be unit. As a base its cell is on "
        "the side that the normal points to; an object has both sides.")
        .def(py::init([](py::handle point, py::handle normal) {
                 return Plane{vec3(point, "point"), vec3(normal, "normal")};
             }),
             py::arg("point"), py::arg("normal"))
        .def_property_readonly(
            "point", [](const Plane& p) { return array_of(p.point); }, "Shape (3,).")
        .def_property_readonly(
            "normal", [](const Plane& p) { return array_of(p.normal); }, "Shape (3,).")
        .def("__eq__", equal<Plane>())
        .def("__repr__", [](const Plane& p) {
            return "Plane(point=" + text_of(p.point) + ", normal=" + text_of(p.normal) + ")";
        });
    bind_round<Sphere>(m, "Sphere", "The ball's surface; radius 0 is a point.", py::arg("radius") = 0.0);
    bind_round<HollowSphere>(m, "HollowSphere", "A vessel: everything lies in the sphere.",
                             py::arg("radius"));
    bind_tube<Cylinder>(
        m, "Cylinder",
        "The infinite cylinder about the line through `point` along `axis`, which need not be "
        "unit; radius 0 is a line.",
        py::arg("radius") = 0.0);
    bind_tube<HollowCylinder>(m, "HollowCylinder", "A vessel: everything lies in the infinite tube.",
                              py::arg("radius"));
    py::class_<HollowCone>(
        m, "HollowCone",
        "A vessel: everything lies in the infinite cone that opens from `apex` along `axis`, "
        "whose rim of radius `radius` is `slant` away from the apex: radius / slant is the "
        "sine of half its angle.")
        .def(py::init([](py::handle apex, py::handle axis, double radius, double slant) {
                 return HollowCone{vec3(apex, "apex"), vec3(axis, "axis"), radius, slant};
             }),
             py::arg("apex"), py::arg("axis"), py::arg("radius"), py::arg("slant"))
        .def_property_readonly(
            "apex", [](const HollowCone& c) { return array_of(c.apex); }, "Shape (3,).")
        .def_property_readonly(
            "axis", [](const HollowCone& c) { return array_of(c.axis); }, "Shape (3,).")
        .def_readonly("radius", &HollowCone::radius)
        .def_readonly("slant", &HollowCone::slant)
        .def("__eq__", equal<HollowCone>())
        .def("__repr__", [](const HollowCone& c) {
            return "HollowCone(apex=" + text_of(c.apex) + ", axis=" + text_of(c.axis) +
                   ", radius=" + text_of(c.radius) + ", slant=" + text_of(c.slant) + ")";
        });
    py::class_<Box>(m, "Box", "Axis-parallel; min < max in every coordinate.")
        .def(py::init([](py::handle min, py::handle max) {
                 return Box{vec3(min, "min"), vec3(max, "max")};
             }),
             py::arg("min"), py::arg("max"))
        .def_property_readonly(
            "min", [](const Box& b) { return array_of(b.min); }, "Shape (3,).")
        .def_property_readonly(
            "max", [](const Box& b) { return array_of(b.max); }, "Shape (3,).")
        .def_property_readonly("diagonal", &Box::diagonal, "Length.")
        .def("__repr__",
             [](const Box& b) { return "Box(min=" + text_of(b.min) + ", max=" + text_of(b.max) + ")"; });
}

void bind_one_cell(py::module_& m) {
    py::class_<Scene>(
        m, "Scene",
        "One base, the objects around it and the box that clips its cell; lengths in a unit of yours. "
        "A scene does not change.")
        .def(
            py::init([](const Object& base, const py::object& objects, py::handle box_given,
                        std::vector<std::string> names, std::string base_name,
                        std::optional<std::uint32_t> base_object, std::string units,
                        std::optional<double> tolerance, std::optional<double> probe) {
                Scene scene;
                scene.base = base;
                scene.objects = objects_of(objects);
                scene.box = box(box_given);
                scene.names = std::move(names);
                scene.base_name = std::move(base_name);
                scene.base_object = base_object;
                scene.units = std::move(units);
                scene.tolerance = tolerance;
                scene.probe = probe;
                if (!scene.names.empty() && scene.names.size() != scene.objects.size())
                    throw py::value_error("names: must be one for each object");
                validate(scene);
                return scene;
            }),
            py::arg("base"), py::arg("objects"), py::arg("box"), py::kw_only(),
            py::arg("names") = std::vector<std::string>(), py::arg("base_name") = "",
            py::arg("base_object") = py::none(), py::arg("units") = "mm", py::arg("tolerance") = py::none(),
            py::arg("probe") = py::none(),
            "objects: a sequence of Plane, Sphere and Cylinder, or balls as an array of shape (n, 4), rows "
            "x, y, z, r.\n"
            "box: a Box, or a pair of points.\n"
            "base_object: the number of the object that is the base itself and no competitor.\n"
            "tolerance: the largest distance of a fitted curve from the true one; default: 1e-7 of the box's "
            "diagonal.\n"
            "probe: the cell ends at this clearance, in a cap.\n\n"
            "Raises InputError, a ValueError, that names the place of what is wrong.")
        .def_property_readonly("base", [](const Scene& s) { return s.base; })
        .def_property_readonly(
            "objects", [](const Scene& s) { return s.objects; }, "A list of its own.")
        .def_property_readonly("box", [](const Scene& s) { return s.box; })
        .def_readonly("names", &Scene::names, "Empty, or one for each object.")
        .def_readonly("base_name", &Scene::base_name)
        .def_readonly("base_object", &Scene::base_object)
        .def_readonly("units", &Scene::units)
        .def_readonly("tolerance", &Scene::tolerance)
        .def_readonly("probe", &Scene::probe)
        .def(
            "to_json",
            [](const Scene& s) {
                std::ostringstream out;
                write_scene(out, s);
                return out.str();
            },
            "The scene file's text; parse_scene() gives the same scene.")
        .def(py::pickle(
            [](const Scene& s) {
                std::ostringstream out;
                write_scene(out, s);
                return py::str(out.str());
            },
            [](const py::str& text) { return parse_scene(std::string(text)); }))
        .def("__repr__", [](const Scene& s) {
            return "<vcell.Scene: " + std::to_string(s.objects.size()) + " objects>";
        });

    const auto options = [](std::optional<std::size_t> base_ball, const std::optional<Plane>& base_plane,
                            const py::object& box_given) {
        TextSceneOptions result;
        result.base_ball = base_ball;
        result.base_plane = base_plane;
        result.box = maybe_box(box_given);
        return result;
    };
    const char* doc =
        "A scene from JSON, from lines x y z r, or from PDB, mmCIF, XYZ or a LAMMPS dump (docs/files.md). Files of "
        "balls take `base_ball`, the ball that is the base, or `base_plane`, and `box`, a default that leaves half "
        "the balls' diagonal of room. Raises InputError.";
    m.def(
        "parse_scene",
        [options](const std::string& text, std::optional<std::size_t> base_ball,
                  const std::optional<Plane>& base_plane, const py::object& box_given) {
            return parse_scene(text, options(base_ball, base_plane, box_given));
        },
        py::arg("text"), py::kw_only(), py::arg("base_ball") = py::none(), py::arg("base_plane") = py::none(),
        py::arg("box") = py::none(), doc);
    m.def(
        "read_scene",
        [options](const std::filesystem::path& path, std::optional<std::size_t> base_ball,
                  const std::optional<Plane>& base_plane, const py::object& box_given) {
            return read_scene(path.string(), options(base_ball, base_plane, box_given));
        },
        py::arg("path"), py::kw_only(), py::arg("base_ball") = py::none(), py::arg("base_plane") = py::none(),
        py::arg("box") = py::none(), "As parse_scene(), of a file. Raises ReadError, an OSError, too.");
}

void bind_many_cells(py::module_& m) {
    py::class_<DiagramScene>(
        m, "DiagramScene",
        "Objects that share a box, none of them the base of the others. A scene does not "
        "change, but for Diagram.update().")
        .def(py::init([](const py::object& objects, py::handle box_given, std::array<bool, 3> periodic,
                         std::array<double, 3> tilt, std::optional<double> probe,
                         std::vector<std::string> names, std::vector<std::string> groups, std::string units,
                         std::optional<double> tolerance) {
                 DiagramScene scene;
                 scene.objects = objects_of(objects);
                 scene.box = box(box_given);
                 scene.periodic = periodic;
                 scene.tilt = tilt;
                 scene.probe = probe;
                 scene.names = std::move(names);
                 scene.groups = std::move(groups);
                 scene.units = std::move(units);
                 scene.tolerance = tolerance;
                 if (!scene.names.empty() && scene.names.size() != scene.objects.size())
                     throw py::value_error("names: must be one for each object");
                 if (!scene.groups.empty() && scene.groups.size() != scene.objects.size())
                     throw py::value_error("groups: must be one for each object");
                 return scene;
             }),
             py::arg("objects"), py::arg("box"), py::kw_only(), py::arg("periodic") = std::array<bool, 3>{},
             py::arg("tilt") = std::array<double, 3>{}, py::arg("probe") = py::none(),
             py::arg("names") = std::vector<std::string>(), py::arg("groups") = std::vector<std::string>(),
             py::arg("units") = "mm", py::arg("tolerance") = py::none(),
             "objects: a sequence of Plane, Sphere and Cylinder, or balls as an array of shape (n, 4), rows "
             "x, y, z, r.\n"
             "box: a Box, or a pair of points.\n"
             "periodic: along which axes the box repeats; tubes then close on themselves (docs/files.md).\n"
             "tilt: xy, xz, yz of a box that leans: its edges are (x, 0, 0), (xy, y, 0), (xz, yz, z).\n"
             "probe: cells end at this clearance, which makes `exposed_area` the accessible surface.\n"
             "groups: objects of one label belong together.\n\n"
             "What is wrong with it is told by diagram().")
        .def_property_readonly(
            "objects", [](const DiagramScene& s) { return s.objects; }, "A list of its own.")
        .def_property_readonly("box", [](const DiagramScene& s) { return s.box; })
        .def_readonly("periodic", &DiagramScene::periodic)
        .def_readonly("tilt", &DiagramScene::tilt)
        .def_readonly("probe", &DiagramScene::probe)
        .def_readonly("names", &DiagramScene::names)
        .def_readonly("groups", &DiagramScene::groups)
        .def_readonly("units", &DiagramScene::units)
        .def_readonly("tolerance", &DiagramScene::tolerance)
        .def("__repr__", [](const DiagramScene& s) {
            return "<vcell.DiagramScene: " + std::to_string(s.objects.size()) + " objects>";
        });

    m.def(
        "read_diagram_scene",
        [](const std::filesystem::path& path, const py::object& box_given,
           std::optional<std::array<bool, 3>> periodic, std::optional<std::array<double, 3>> tilt,
           std::optional<double> probe, std::optional<std::size_t> frame, std::map<std::string, double> radii,
           bool hydrogens, bool water, bool hetero, const std::optional<std::string>& group) {
            DiagramSceneOptions options;
            options.box = maybe_box(box_given);
            options.periodic = periodic;
            options.tilt = tilt;
            options.probe = probe;
            options.files = file_options(frame, std::move(radii), hydrogens, water, hetero, group);
            return read_diagram_scene(path.string(), options);
        },
        py::arg("path"), py::kw_only(), py::arg("box") = py::none(), py::arg("periodic") = py::none(),
        py::arg("tilt") = py::none(), py::arg("probe") = py::none(), py::arg("frame") = py::none(),
        py::arg("radii") = std::map<std::string, double>(), py::arg("hydrogens") = false,
        py::arg("water") = true, py::arg("hetero") = true, py::arg("group") = py::none(),
        "The scene of a JSON file, of lines `x y z r [name [group]]`, or of PDB, mmCIF, XYZ or a LAMMPS dump "
        "(docs/files.md); the keywords are for files of balls, and what is given goes before what they say.\n\n"
        "radii: by element, species or type, in place of the table's.\n"
        "hydrogens, water, hetero: are they read, from PDB and mmCIF?\n"
        "group: \"residue\" or \"chain\".\n\n"
        "Raises InputError with path or line, and ReadError, an OSError.");
}

}  // namespace

void bind_scene(py::module_& m) {
    bind_objects(m);
    bind_one_cell(m);
    bind_many_cells(m);
}

}  // namespace vcell::python
