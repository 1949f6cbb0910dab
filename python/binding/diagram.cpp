// The cells of all objects, as arrays; what lies between them; the void network.
#include "../../envelope/voronoi_diagram.hpp"

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <array>
#include <map>
#include <vector>

#include "../../envelope/whole/void_network.hpp"
#include "../../io/pictures/diagram_output.hpp"
#include "arrays.hpp"
#include "binding.hpp"

namespace vcell::python {

namespace {

/// A diagram with the scene that it is of.
struct Diagram {
    DiagramScene scene;
    VoronoiDiagram diagram;
};

std::string number(double x) { return py::repr(py::float_(x)); }

const char* name_of(DiagramCell::State state) {
    switch (state) {
        case DiagramCell::State::Computed: return "computed";
        case DiagramCell::State::Empty: return "empty";
        case DiagramCell::State::Undecided: return "undecided";
        case DiagramCell::State::Refused: return "refused";
        case DiagramCell::State::Wall: return "wall";
    }
    return "";
}

/// What is called while a diagram is computed: signals, progress, and each cell as Python's own.
class Listener {
public:
    Listener(py::object progress, py::object visit) : watch_(std::move(progress)), visit_(std::move(visit)) {}

    DiagramOptions options(unsigned threads, bool bodies = false, bool complete = false) {
        DiagramOptions result;
        result.threads = threads;
        result.bodies = bodies;
        result.complete = complete;
        result.progress = [this](double fraction) { watch_(fraction); };
        if (!visit_.is_none())
            result.visit = [this](std::uint32_t object, const Cell& cell) {
                py::gil_scoped_acquire lock;
                visit_(object, cell);  // a copy: the engine keeps its own no longer than this call
            };
        return result;
    }

private:
    Watch watch_;
    py::object visit_;
};

template <class T, class Of>
auto cells(Of of) {
    return [of](const Diagram& d) { return column<T>(d.diagram.cells, of); };
}
template <class Of>
auto flags(Of of) {
    return [of](const Diagram& d) { return column<bool>(d.diagram.cells, of); };
}

void bind_contacts(py::module_& m) {
    py::class_<ContactTable>(m, "ContactTable", "Pairs of neighbours, each once, ascending.")
        .def_property_readonly(
            "first",
            [](const ContactTable& t) {
                return column<std::int64_t>(t.contacts, [](auto& c) { return c.first; });
            },
            "Numbers of objects: shape (n,).")
        .def_property_readonly(
            "second",
            [](const ContactTable& t) {
                return column<std::int64_t>(t.contacts, [](auto& c) { return number_of(c.second); });
            },
            "Site numbers: an object that is not lower, or -1 ... -6, a side of the box: shape (n,).")
        .def_property_readonly(
            "image",
            [](const ContactTable& t) {
                return table<std::int64_t>(
                    t.contacts, 3, [](auto& c) -> auto& { return c.image; });
            },
            "By how many edges of the box the second is moved: shape (n, 3).")
        .def_property_readonly(
            "faces",
            [](const ContactTable& t) {
                return column<std::int64_t>(t.contacts, [](auto& c) { return c.faces; });
            },
            "Connected ones: shape (n,).")
        .def_property_readonly(
            "area",
            [](const ContactTable& t) { return column<double>(t.contacts, [](auto& c) { return c.area; }); },
            "Shape (n,).")
        .def_property_readonly(
            "area_error",
            [](const ContactTable& t) {
                return column<double>(t.contacts, [](auto& c) { return c.area_error; });
            },
            "Shape (n,).")
        .def_readonly("faults", &ContactTable::faults,
                      "Pairs of cells that do not agree about what is between them: none, if all is right.")
        .def("__len__", [](const ContactTable& t) { return t.contacts.size(); });

    py::class_<FilledVolume>(m, "FilledVolume", "The sum of all volumes, beside the box's.")
        .def_readonly("volume", &FilledVolume::volume)
        .def_readonly("error", &FilledVolume::error)
        .def_readonly("box", &FilledVolume::box)
        .def_readonly("is_estimated", &FilledVolume::is_estimated)
        .def_property_readonly("fills", &FilledVolume::fills, "Do the cells fill the box within the error?");
}

void bind_table(py::module_& m) {
    py::class_<Diagram>(
        m, "Diagram",
        "The cells of all objects, as arrays with an entry for each; lengths in the scene's unit.")
        .def_readonly("scene", &Diagram::scene)
        .def("__len__", [](const Diagram& d) { return d.diagram.cells.size(); })
        .def_property_readonly(
            "states",
            [](const Diagram& d) {
                py::list result;
                for (const DiagramCell& c : d.diagram.cells) result.append(name_of(c.state));
                return result;
            },
            "\"computed\", \"empty\" (in another object, or equal to one), \"undecided\", \"refused\" or \"wall\" "
            "(ends others' cells and has none).")
        .def_property_readonly(
            "reasons",
            [](const Diagram& d) {
                py::list result;
                for (const DiagramCell& c : d.diagram.cells) result.append(c.reason);
                return result;
            },
            "Why a cell has its state: empty for computed ones.")
        .def_property_readonly("volume", cells<double>([](auto& c) { return c.volume; }), "Shape (n,).")
        .def_property_readonly("volume_error", cells<double>([](auto& c) { return c.volume_error; }),
                               "Shape (n,).")
        .def_property_readonly("area", cells<double>([](auto& c) { return c.area; }),
                               "Without sides of the box and caps: shape (n,).")
        .def_property_readonly("area_error", cells<double>([](auto& c) { return c.area_error; }),
                               "Shape (n,).")
        .def_property_readonly("exposed_area", cells<double>([](auto& c) { return c.exposed_area; }),
                               "Of the cap at the probe's distance, the accessible surface: shape (n,).")
        .def_property_readonly("exposed_error", cells<double>([](auto& c) { return c.exposed_error; }),
                               "Shape (n,).")
        .def_property_readonly(
            "body_volume", cells<double>([](auto& c) { return c.body_volume; }),
            "What the object itself takes of its cell; NaN where diagram() was not asked for "
            "bodies: shape (n,).")
        .def_property_readonly("body_error", cells<double>([](auto& c) { return c.body_error; }),
                               "Shape (n,).")
        .def_property_readonly("min_clearance", cells<double>([](auto& c) { return c.min_clearance; }),
                               "NaN for planes and cylinders: shape (n,).")
        .def_property_readonly("max_clearance", cells<double>([](auto& c) { return c.max_clearance; }),
                               "NaN for planes and cylinders: shape (n,).")
        .def_property_readonly("touches_box", flags([](auto& c) { return c.touches_box; }), "Shape (n,).")
        .def_property_readonly("is_estimated",
                               flags([](auto& c) { return c.is_estimated || c.body_estimated; }),
                               "Are errors estimates, no bounds? Shape (n,).")
        .def_property_readonly("assumed", cells<std::int64_t>([](auto& c) { return c.assumed; }),
                               "Coincidences that were taken for granted: shape (n,).")
        .def_property_readonly("neighbor_count", cells<std::int64_t>([](auto& c) {
                                   std::int64_t count = 0;
                                   for (const CellContact& contact : c.contacts)
                                       count += contact.site.is_object();
                                   return count;
                               }),
                               "Neighbouring objects, each image for itself: shape (n,).")
        .def_property_readonly(
            "moved", [](const Diagram& d) { return d.diagram.moved; },
            "A bound on how far coordinates were moved, to a grid on which the box repeats.")
        .def_property_readonly(
            "periods",
            [](const Diagram& d) {
                std::map<std::uint32_t, std::vector<std::array<std::int16_t, 3>>> result;
                for (const ObjectImage& period : d.diagram.periods)
                    result[period.number].push_back(period.image);
                return result;
            },
            "Moves by so many edges of the box that leave planes and cylinders as they are, for each object that has "
            "any: {number: [[i, j, k], ...]}. Images in contacts stand for all that differ by such a move.")
        .def(
            "contacts", [](const Diagram& d) { return contacts(d.diagram); },
            "A ContactTable of all pairs of neighbours.")
        .def(
            "filled_volume", [](const Diagram& d) { return filled_volume(d.scene, d.diagram); },
            "A FilledVolume: do the cells fill the box?")
        .def(
            "filled_by_bodies", [](const Diagram& d) { return body_volume(d.scene, d.diagram); },
            "A FilledVolume: what balls and tubes take of the box, which leaves it the porosity 1 - volume / box; "
            "NaN where diagram() was not asked for bodies.")
        .def(
            "update",
            [](py::object self, std::uint32_t number, const Object& object, unsigned threads, bool bodies) {
                auto& diagram = self.cast<Diagram&>();
                if (number >= diagram.scene.objects.size())
                    throw py::index_error("number: there is no such object");
                // The change is made on a copy, without the interpreter's lock: an interrupt leaves the
                // diagram as it was.
                Diagram changed = diagram;
                Listener listener{py::none(), py::none()};
                {
                    const py::gil_scoped_release unlocked;
                    update(changed.diagram, changed.scene, number, object, listener.options(threads, bodies));
                }
                diagram = std::move(changed);
            },
            py::arg("number"), py::arg("object"), py::kw_only(), py::arg("threads") = 0,
            py::arg("bodies") = false,
            "After objects[number] has become `object`: only cells that either may touch are computed again.")
        .def("__repr__", [](const Diagram& d) {
            return "<vcell.Diagram: " + std::to_string(d.diagram.cells.size()) + " cells>";
        });

    m.def(
        "diagram",
        [](const DiagramScene& scene, unsigned threads, py::object progress, py::object visit, bool bodies,
           const std::vector<std::filesystem::path>& outputs, double chord,
           const std::optional<std::pair<std::string, double>>& cut,
           std::optional<std::size_t> most_triangles, bool complete) {
            DiagramFileOptions how;
            how.chord = chord;
            how.most_triangles = most_triangles;
            if (cut) {
                if (cut->first != "x" && cut->first != "y" && cut->first != "z")
                    throw py::value_error("cut: must be like (\"z\", 0.5)");
                how.cut = {cut->first[0] - 'x', cut->second};
            }
            Listener listener(std::move(progress), std::move(visit));
            Diagram result{scene, {}};
            std::optional<DiagramFiles::MeshSize> size;
            {
                const py::gil_scoped_release unlocked;
                std::vector<std::string> paths;
                for (const std::filesystem::path& path : outputs) paths.push_back(path.string());
                DiagramFiles files(paths, how);
                result.diagram = files.compute(result.scene, listener.options(threads, bodies, complete));
                files.commit();
                size = files.mesh_size();
            }
            if (size && size->chord > chord) {
                const std::string text =
                    "a chord of " + number(chord) + " is too fine for " + std::to_string(*most_triangles) +
                    " triangles or 4096 pieces of an edge: the mesh has " + std::to_string(size->triangles) +
                    " triangles with one of " + number(size->chord);
                if (PyErr_WarnEx(PyExc_UserWarning, text.c_str(), 1) < 0) throw py::error_already_set();
            }
            return result;
        },
        py::arg("scene"), py::kw_only(), py::arg("threads") = 0, py::arg("progress") = py::none(),
        py::arg("visit") = py::none(), py::arg("bodies") = false,
        py::arg("outputs") = std::vector<std::filesystem::path>(),
        py::arg("chord") = DiagramFileOptions().chord, py::arg("cut") = py::none(),
        py::arg("most_triangles") = py::none(), py::arg("complete") = false,
        "The cells of all objects, each proved to be that among all others. What one cell runs into is in its "
        "state.\n\n"
        "threads: 0 is as many as there are cores; the result is the same for any number.\n"
        "progress: called with the fraction of cells that is done, up to twenty times a second; may raise.\n"
        "visit: called with the number and the Cell of each computed cell of a ball, ascending. The cell's scene "
        "has the objects that were looked at; its sites are their numbers in the diagram or, where the box repeats, "
        "places in that scene.\n"
        "bodies: Diagram.body_volume is told, too.\n"
        "outputs: paths of files to write all cells to, in the formats of their endings: .json, .obj, .stl, .ply, .vtu, "
        ".bezier.vtu, .glb, .3mf, .step, .itd, .html or .svg. Planes and cylinders have their complete cells then, and "
        "visit sees them.\n"
        "chord: of meshes, as a part of a cell's diagonal.\n"
        "cut: the plane of a .svg, like (\"z\", 0.5).\n"
        "most_triangles: of all meshes together. Where there would be more the chord grows, which a UserWarning tells. "
        "All cells are computed twice or three times.\n"
        "complete: visit sees the complete cells of planes (two, one on each side) and cylinders, too, files or not.\n\n"
        "Ctrl-C ends it. Raises InputError, WriteError; ValueError where edges alone ask for more than most_triangles.");
}

void bind_network(py::module_& m) {
    py::class_<NetworkSphere>(m, "NetworkSphere", "The largest sphere that fits in some way.")
        .def_readonly("diameter", &NetworkSphere::diameter, "Negative where nothing fits.")
        .def_readonly("error", &NetworkSphere::error, "A bound.")
        .def("__repr__", [](const NetworkSphere& s) {
            return "<vcell.NetworkSphere of diameter " + std::string(py::repr(py::float_(s.diameter))) + ">";
        });
    py::class_<VoidNetwork>(m, "VoidNetwork", "Vertices and edges of all cells, each once.")
        .def_property_readonly(
            "vertex_points",
            [](const VoidNetwork& n) {
                return table<double>(
                    n.vertices, 3, [](auto& v) -> auto& { return v.point; });
            },
            "Shape (vertices, 3).")
        .def_property_readonly(
            "vertex_clearances",
            [](const VoidNetwork& n) {
                return column<double>(n.vertices, [](auto& v) { return v.clearance; });
            },
            "Distances from the objects around: shape (vertices,).")
        .def_property_readonly(
            "vertex_errors",
            [](const VoidNetwork& n) { return column<double>(n.vertices, [](auto& v) { return v.error; }); },
            "Bounds for place and clearance: shape (vertices,).")
        .def_property_readonly(
            "edge_vertices",
            [](const VoidNetwork& n) {
                return table<std::int64_t>(n.edges, 2, [](auto& e) {
                    return e.vertices ? std::array<std::int64_t, 2>{(*e.vertices)[0], (*e.vertices)[1]}
                                      : std::array<std::int64_t, 2>{-1, -1};
                });
            },
            "Numbers of both ends, -1 for edges without vertices: shape (edges, 2).")
        .def_property_readonly(
            "edge_images",
            [](const VoidNetwork& n) {
                return table<std::int64_t>(
                    n.edges, 3, [](auto& e) -> auto& { return e.image; });
            },
            "By how many edges of the box the second end is moved, or any point of an edge without vertices where that "
            "comes again, 0 if it is closed: shape (edges, 3).")
        .def_property_readonly(
            "edge_bottlenecks",
            [](const VoidNetwork& n) {
                return column<double>(n.edges, [](auto& e) { return e.bottleneck; });
            },
            "Least clearances along edges: shape (edges,).")
        .def_property_readonly(
            "edge_bottleneck_errors",
            [](const VoidNetwork& n) {
                return column<double>(n.edges, [](auto& e) { return e.bottleneck_error; });
            },
            "Bounds: shape (edges,).")
        .def_property_readonly(
            "edge_lengths",
            [](const VoidNetwork& n) { return column<double>(n.edges, [](auto& e) { return e.length; }); },
            "Shape (edges,).")
        .def_property_readonly(
            "passage_edges",
            [](const VoidNetwork& n) {
                return table<std::int64_t>(
                    n.passages, 2, [](auto& p) -> auto& { return p.edges; });
            },
            "Edges on both sides of faces that wind between parallel cylinders or planes: shape (passages, 2).")
        .def_property_readonly(
            "passage_images",
            [](const VoidNetwork& n) {
                return table<std::int64_t>(
                    n.passages, 3, [](auto& p) -> auto& { return p.image; });
            },
            "By how many edges of the box the second edge is moved: shape (passages, 3).")
        .def_property_readonly(
            "passage_bottlenecks",
            [](const VoidNetwork& n) {
                return column<double>(n.passages, [](auto& p) { return p.bottleneck; });
            },
            "Least clearances on the widest ways across: shape (passages,).")
        .def_property_readonly(
            "passage_bottleneck_errors",
            [](const VoidNetwork& n) {
                return column<double>(n.passages, [](auto& p) { return p.bottleneck_error; });
            },
            "Bounds: shape (passages,).")
        .def_readonly("included", &VoidNetwork::included,
                      "Di: the largest sphere about a vertex, or on an edge that winds, or None.")
        .def_readonly("free", &VoidNetwork::free, "Df: the largest that gets through the box, or None.")
        .def_readonly("free_along", &VoidNetwork::free_along, "Df along x, y and z.")
        .def_readonly("included_along_free", &VoidNetwork::included_along_free,
                      "Dif: the largest on that way, or None.")
        .def_readonly("moved", &VoidNetwork::moved);
    m.def(
        "void_network",
        [](const DiagramScene& scene, unsigned threads, py::object progress) {
            Listener listener(std::move(progress), py::none());
            const DiagramOptions options = listener.options(threads);
            const py::gil_scoped_release unlocked;
            return void_network(scene, options);
        },
        py::arg("scene"), py::kw_only(), py::arg("threads") = 0, py::arg("progress") = py::none(),
        "The void network of a scene, which may repeat: what spheres fit in between, and which get through. Ctrl-C "
        "ends it. Raises InputError, UndecidedError.");
}

}  // namespace

void bind_diagram(py::module_& m) {
    bind_contacts(m);
    bind_table(m);
    bind_network(m);
}

}  // namespace vcell::python
