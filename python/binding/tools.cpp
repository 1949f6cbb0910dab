// Questions about points, checks, more digits, meshes and files.
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <array>
#include <filesystem>
#include <limits>
#include <mutex>

#include "../../envelope/measures/clearance_places.hpp"
#include "../../envelope/point_query.hpp"
#include "../../envelope/vertex_refinement.hpp"
#include "../../io/io.hpp"
#include "arrays.hpp"
#include "binding.hpp"

namespace vcell::python {

namespace {

/// PointQuery as threads may share it: it remembers what was asked, so one asks at a time.
class SharedQuery {
public:
    explicit SharedQuery(const Scene& scene) : query_(scene) {}

    const std::vector<std::string>& warnings() const { return query_.warnings(); }

    /// owner, clearance, inside: see the module's text.
    py::tuple answer(py::handle given) {
        const Doubles points = rows(given, 3, "points");
        const py::ssize_t n = points.shape(0);
        py::array_t<std::int64_t> owner(n);
        py::array_t<double> clearance(n);
        py::array_t<bool> inside(n);
        const double* from = points.data();
        std::int64_t* const owner_to = owner.mutable_data();
        double* const clearance_to = clearance.mutable_data();
        bool* const inside_to = inside.mutable_data();
        {
            Watch watch{py::none()};
            const py::gil_scoped_release unlocked;
            for (py::ssize_t i = 0; i < n; ++i) {
                if (i % 256 == 0) watch();
                const std::lock_guard one(mutex_);
                const auto a = query_(Vec3(from[3 * i], from[3 * i + 1], from[3 * i + 2]));
                const bool has_owner = a && a->site;
                owner_to[i] = has_owner ? number_of(*a->site) : no_site;
                clearance_to[i] = has_owner ? a->clearance : not_measured;
                inside_to[i] = a && a->inside;
            }
        }
        return py::make_tuple(owner, clearance, inside);
    }

private:
    PointQuery query_;
    std::mutex mutex_;
};

void bind_query(py::module_& m) {
    py::class_<SharedQuery>(
        m, "PointQuery",
        "Answers about points, without computing the cell: O(n) to begin with, O(log n) each.")
        .def(py::init([](const Scene& scene) {
                 const py::gil_scoped_release unlocked;
                 return std::make_unique<SharedQuery>(scene);
             }),
             py::arg("scene"))
        .def(
            "__call__", &SharedQuery::answer, py::arg("points"),
            "points: shape (n, 3). Returns arrays of shape (n,): the site number of the owner of each point's ray, "
            "which runs through it along the base's normal (NO_SITE: the ray starts outside the base region, or the "
            "point is in a base sphere's centre or on a base cylinder's axis), the clearance of the cell's boundary "
            "on that ray (NaN without an owner), and whether the point lies in the closed cell. Ctrl-C ends it.")
        .def_property_readonly("warnings", &SharedQuery::warnings);
    m.def(
        "query",
        [](const Scene& scene, py::handle points) {
            std::unique_ptr<SharedQuery> query;
            {
                const py::gil_scoped_release unlocked;
                query = std::make_unique<SharedQuery>(scene);
            }
            return query->answer(points);
        },
        py::arg("scene"), py::arg("points"), "PointQuery(scene)(points).");
    m.attr("NO_SITE") = no_site;
}

void bind_check(py::module_& m) {
    py::class_<Element>(m, "Element", "One statement about one place of a cell.")
        .def_readonly("where", &Element::where, "As the cell file names it: \"vertices[3]\".")
        .def_property_readonly(
            "verdict", [](const Element& e) { return std::string(to_string(e.verdict)); },
            "\"proved\", \"refuted\" or \"open\".")
        .def_readonly("what", &Element::what, "What is wrong, or why nothing could be proved.")
        .def_readonly(
            "amount", &Element::amount,
            "Proved: how far it is from the true one at most. Refuted: by how much it is wrong at least.")
        .def("__repr__", [](const Element& e) {
            return "<vcell.Element " + e.where + ": " + std::string(to_string(e.verdict)) + ">";
        });
    py::class_<Certificate>(m, "Certificate", "What a check has established. True if it holds.")
        .def_property_readonly(
            "elements",
            [](py::object self) { return references(self.cast<const Certificate&>().elements, self); },
            "A list of Element.")
        .def_readonly(
            "distance", &Certificate::distance,
            "The boundary as written is everywhere within this length of the true one, if it holds.")
        .def_property_readonly("holds", &Certificate::holds, "Nothing is refuted and nothing is open.")
        .def_property_readonly("proved", [](const Certificate& c) { return c.count(Verdict::proved); })
        .def_property_readonly("refuted", [](const Certificate& c) { return c.count(Verdict::refuted); })
        .def_property_readonly("open", [](const Certificate& c) { return c.count(Verdict::open); })
        .def("__bool__", &Certificate::holds);
    m.def(
        "check",
        [](const Cell& cell, std::uint32_t samples, std::uint64_t seed, int effort) {
            const py::gil_scoped_release unlocked;
            return certify(cell, {samples, seed, effort});
        },
        py::arg("cell"), py::kw_only(), py::arg("samples") = 500, py::arg("seed") = 1, py::arg("effort") = 10,
        "A Certificate: is the cell what it says? From the scene in it alone, with code that computed none of it.\n\n"
        "samples, seed: points that are compared where something is not proved.\n"
        "effort: each step allows twice as many parts before something is left open.\n\n"
        "Ctrl-C waits for its end.");
}

/// A number of many bits as Python's Fraction, exactly.
py::object fraction(const Wide::Float& x) {
    const py::object fractions = py::module_::import("fractions").attr("Fraction");
    constexpr int bits = std::numeric_limits<Wide::Float>::digits;
    int exponent = 0;
    const Wide::Float part = frexp(x, &exponent);
    const py::object whole =
        py::module_::import("builtins").attr("int")(boost::multiprecision::cpp_int(ldexp(part, bits)).str());
    return fractions(whole) * fractions(2).attr("__pow__")(exponent - bits);
}

void bind_refinement(py::module_& m) {
    py::class_<RefinedVertex>(m, "RefinedVertex", "A vertex enclosed in more digits than doubles have.")
        .def_property_readonly(
            "sites",
            [](const RefinedVertex& v) {
                py::list result;
                for (const Site& site : v.sites) result.append(site);
                return result;
            },
            "The three that it was found from.")
        .def_property_readonly(
            "bounds",
            [](const RefinedVertex& v) {
                py::list result;
                for (const Wide& side : v.box)
                    result.append(py::make_tuple(fraction(side.lower()), fraction(side.upper())));
                return result;
            },
            "Of x, y, z and the clearance: (lower, upper), as fractions.Fraction.")
        .def_readonly("tie_width", &RefinedVertex::tie_width,
                      "A bound on how far the point is from being as far from the vertex's other sites.");
    m.def(
        "refine",
        [](const Cell& cell, std::size_t vertex, int bits) {
            if (vertex >= cell.vertices.size())
                throw py::index_error("vertex: there are " + std::to_string(cell.vertices.size()));
            if (bits < 1 || bits > most_refined_bits)
                throw py::value_error("bits: must be 1 ... " + std::to_string(most_refined_bits));
            const py::gil_scoped_release unlocked;
            return refine(cell, vertex, bits);
        },
        py::arg("cell"), py::arg("vertex"), py::kw_only(), py::arg("bits") = 128,
        "A RefinedVertex: that vertex of the cell within 2^-bits of the box's diagonal, proved. None where bisectors "
        "touch in it, or digits do not suffice.");
}

void bind_clearance_places(py::module_& m) {
    py::class_<ClearancePlace>(m, "ClearancePlace",
                               "A place where a cell's clearance is least, or greatest. There may be others.")
        .def_property_readonly(
            "point", [](const ClearancePlace& p) { return array_of(p.point); }, "Shape (3,).")
        .def_readonly("error", &ClearancePlace::error,
                      "A bound on the distance of `point` from the true boundary.")
        .def_readonly("clearance", &ClearancePlace::clearance)
        .def_readonly("clearance_error", &ClearancePlace::clearance_error,
                      "A bound on how far `clearance` is from the true cell's least, or greatest.")
        .def_property_readonly(
            "sites",
            [](const ClearancePlace& p) {
                py::list result;
                for (const Site& site : p.sites) result.append(site);
                return result;
            },
            "All that attain it: those of the element that holds the place.")
        .def_readonly("vertex", &ClearancePlace::vertex, "The number of the vertex that it is, or None.")
        .def_readonly("edge", &ClearancePlace::edge, "The number of the edge that holds it, or None.")
        .def_readonly(
            "face", &ClearancePlace::face,
            "The number of the face inside of which it is, or None: a face that shares its site with "
            "others is not told from them.");
    py::class_<ClearancePlaces>(m, "ClearancePlaces", "Where a cell's clearance is least and greatest.")
        .def_readonly("least", &ClearancePlaces::least, "A ClearancePlace; None where none is proved.")
        .def_readonly("greatest", &ClearancePlaces::greatest, "Likewise.");
    m.def(
        "clearance_places",
        [](const Cell& cell) {
            const py::gil_scoped_release unlocked;
            return clearance_places(cell);
        },
        py::arg("cell"), "ClearancePlaces of a cell with measures.");
}

/// Which face a triangle belongs to: -1 for walls and -2 for the base.
py::array_t<std::int64_t> triangle_faces(const CellMesh& mesh) {
    py::array_t<std::int64_t> result(static_cast<py::ssize_t>(mesh.triangles.size()));
    for (const CellMesh::Group& group : mesh.groups) {
        std::int64_t face = group.face;
        if (group.kind == CellMesh::Group::Kind::Walls) face = -1;
        if (group.kind == CellMesh::Group::Kind::Base) face = -2;
        std::fill(result.mutable_data() + group.begin, result.mutable_data() + group.end, face);
    }
    return result;
}

/// Whose face a triangle belongs to; walls, floor and ends count as the base's.
py::array_t<std::int64_t> triangle_sites(const CellMesh& mesh) {
    py::array_t<std::int64_t> result(static_cast<py::ssize_t>(mesh.triangles.size()));
    for (const CellMesh::Group& group : mesh.groups) {
        const bool is_face = group.kind == CellMesh::Group::Kind::Face;
        std::fill(result.mutable_data() + group.begin, result.mutable_data() + group.end,
                  number_of(is_face ? group.site : Site::base()));
    }
    return result;
}

/// Meshes of a diagram's cells as Python gives them: in order, or not at all.
class DiagramMeshes {
public:
    DiagramMeshes(const DiagramScene& scene, double chord)
        : count_(scene.objects.size()), meshes_(scene, chord) {}

    CellMesh add(std::uint32_t number, const Cell& cell) {
        if (number >= count_ || number < least_)
            throw py::value_error(
                "number: cells come in the order of their numbers, each one of the scene's");
        least_ = number;
        const py::gil_scoped_release unlocked;
        return meshes_.add(number, cell);
    }
    std::size_t drawn_again() const { return meshes_.drawn_again(); }

private:
    std::size_t count_;
    std::uint32_t least_ = 0;
    ConformingMeshes meshes_;
};

void bind_mesh(py::module_& m) {
    py::class_<CellMesh>(m, "CellMesh",
                         "Triangles of a cell's boundary without cracks. Its arrays are read-only.")
        .def_readonly("chord", &CellMesh::chord,
                      "The largest distance of a side's middle from the surface that the triangles keep.")
        .def_property_readonly(
            "points",
            [](py::object self) { return view<double>(self.cast<const CellMesh&>().points, 3, self); },
            "Shape (points, 3).")
        .def_property_readonly(
            "normals",
            [](py::object self) { return view<double>(self.cast<const CellMesh&>().normals, 3, self); },
            "Unit, out of the cell: shape (normals, 3).")
        .def_property_readonly(
            "triangles",
            [](py::object self) {
                return view<std::uint32_t>(self.cast<const CellMesh&>().triangles, 3, self);
            },
            "Numbers of points, counter-clockwise seen from outside: shape (triangles, 3).")
        .def_property_readonly(
            "corner_normals",
            [](py::object self) {
                return view<std::uint32_t>(self.cast<const CellMesh&>().corner_normals, 3, self);
            },
            "Numbers of normals, corner by corner: shape (triangles, 3).")
        .def_property_readonly("triangle_faces", &triangle_faces,
                               "Numbers of faces, -1 for walls, -2 for the base: shape (triangles,).")
        .def_property_readonly(
            "triangle_sites", &triangle_sites,
            "Numbers of the sites beyond the triangles (Site.number), -7 for walls and the base; of "
            "DiagramMeshes those of the diagram: shape (triangles,).")
        .def_property_readonly(
            "edge_lines",
            [](const CellMesh& mesh) {
                py::list result;
                for (const auto& line : mesh.edge_lines)
                    result.append(column<std::uint32_t>(line, [](std::uint32_t p) { return p; }));
                return result;
            },
            "For each edge of the cell numbers of points along it.")
        .def("__repr__", [](const CellMesh& mesh) {
            return "<vcell.CellMesh: " + std::to_string(mesh.triangles.size()) + " triangles>";
        });
    m.def(
        "mesh",
        [](const Cell& cell, std::optional<double> chord, bool closed,
           std::optional<std::size_t> most_triangles) {
            if (chord && !(*chord > 0)) throw py::value_error("chord: must be above 0");
            const py::gil_scoped_release unlocked;
            return tessellate(cell, {chord, closed, most_triangles});
        },
        py::arg("cell"), py::kw_only(), py::arg("chord") = py::none(), py::arg("closed") = false,
        py::arg("most_triangles") = py::none(),
        "A CellMesh.\n\n"
        "chord: the largest distance of a side's middle from the surface; default: a thousandth of the cell's "
        "diagonal. It grows where it would take more than `most_triangles`, or more than a million if that is None.\n"
        "closed: with walls and the base's region, the mesh of the whole solid.\n\n"
        "Raises ValueError where the coarsest mesh has more than `most_triangles`.");
}

void bind_diagram_meshes(py::module_& m) {
    py::class_<DiagramMeshes>(
        m, "DiagramMeshes",
        "Meshes of a diagram's cells that fit together: the face between two cells is the same triangles in both, to the "
        "last digit. Cells of oblique tubes fit in parts.\n\n"
        "    meshes, found = vcell.DiagramMeshes(scene), {}\n"
        "    vcell.diagram(scene, visit=lambda n, cell: found.update({n: meshes.add(n, cell)}))")
        .def(
            py::init([](const DiagramScene& scene, double chord) {
                if (!(chord > 0)) throw py::value_error("chord: must be above 0");
                return std::make_unique<DiagramMeshes>(scene, chord);
            }),
            py::arg("scene"), py::kw_only(), py::arg("chord") = 0.002,
            "chord: the largest distance of a side's middle from the surface, as a part of the cell's diagonal.")
        .def("add", &DiagramMeshes::add, py::arg("number"), py::arg("cell"),
             "The closed CellMesh of a cell that diagram() gave to `visit`. Numbers may not descend.")
        .def_property_readonly("drawn_again", &DiagramMeshes::drawn_again,
                               "How many faces were drawn although the cell beyond had come before.");
}

void bind_moments(py::module_& m) {
    py::class_<Moments>(m, "Moments",
                        "The centroid and second moments of a cell's volume, with proven errors.")
        .def_property_readonly(
            "centroid", [](const Moments& of) { return array_of(of.centroid); }, "Shape (3,).")
        .def_readonly("centroid_error", &Moments::centroid_error)
        .def_property_readonly(
            "second",
            [](const Moments& of) {
                return table<double>(std::array{0, 1, 2}, 3, [&](int i) { return Vec3(of.second.row(i)); });
            },
            "The integral of (p - centroid) (p - centroid)^T over the volume: shape (3, 3).")
        .def_readonly("second_error", &Moments::second_error, "Of each of its entries.");
    m.def(
        "moments",
        [](const Cell& cell) {
            const py::gil_scoped_release unlocked;
            return moments_of(cell);
        },
        py::arg("cell"), "Moments of all that the cell encloses, the base's body included.");
}

void bind_files(py::module_& m) {
    m.def(
        "parse_cell", [](const std::string& text) { return parse_cell(text); }, py::arg("text"),
        "The Cell of a cell file's text. Raises InputError with the place of what is wrong.");
    m.def(
        "read_cell", [](const std::filesystem::path& path) { return read_cell(path.string()); },
        py::arg("path"), "As parse_cell(), of a file. Raises ReadError, an OSError, too.");
    m.def(
        "write",
        [](const Cell& cell, const std::filesystem::path& path, const CellMesh* mesh) {
            const py::gil_scoped_release unlocked;
            if (mesh != nullptr)
                write_file(path.string(), cell, *mesh);
            else
                write_file(path.string(), cell);
        },
        py::arg("cell"), py::arg("path"), py::arg("mesh") = py::none(),
        "Writes the cell in the format of the path's ending: .json, .svg, .html (a page to look at), .obj, .stl, .ply, "
        ".vtu, .bezier.vtu, .glb, .3mf, .step or .itd. The file is complete or untouched.\n\n"
        "mesh: the cell's mesh, for formats of triangles; default: mesh(cell).\n\n"
        "Raises WriteError, an OSError.");
}

}  // namespace

void bind_tools(py::module_& m) {
    bind_query(m);
    bind_check(m);
    bind_refinement(m);
    bind_mesh(m);
    bind_diagram_meshes(m);
    bind_clearance_places(m);
    bind_moments(m);
    bind_files(m);
}

}  // namespace vcell::python
