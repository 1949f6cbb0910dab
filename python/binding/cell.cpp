// The cell of one base: its parts, each kept alive by what it is part of, and arrays over all of a kind.
#include "../../envelope/cell.hpp"

#include <pybind11/stl.h>

#include "../../envelope/cell_changes.hpp"
#include "../../envelope/complete_measures.hpp"
#include "../../envelope/voronoi_cell.hpp"
#include "../../io/files/cell_file.hpp"
#include "arrays.hpp"
#include "binding.hpp"

#include <sstream>

namespace vcell::python {

namespace {

std::string name_of(Site::Kind kind) {
    switch (kind) {
        case Site::Kind::Object: return "object";
        case Site::Kind::Base: return "base";
        case Site::Kind::BoxSide: return "box";
        case Site::Kind::End: return "end";
        case Site::Kind::Cap: return "cap";
    }
    return "";
}

template <class Sites>
py::list list_of(const Sites& sites) {
    py::list result;
    for (const Site& site : sites) result.append(site);
    return result;
}

/// Both ends of an edge, -1 where it is closed.
std::array<std::int64_t, 2> ends_of(const CellEdge& e) {
    if (e.vertices.empty()) return {-1, -1};
    return {e.vertices[0], e.vertices[1]};
}

template <class F>
CellOptions with_watch(CellOptions options, F& watch) {
    options.progress = [&watch](const char* stage, double fraction) { watch(stage, fraction); };
    return options;
}

void bind_parts(py::module_& m) {
    py::class_<Site>(m, "Site", "Who may own a piece of a cell's boundary.")
        .def_property_readonly(
            "kind", [](const Site& s) { return name_of(s.kind); },
            "\"object\", \"base\", \"box\", \"end\" or \"cap\".")
        .def_readonly("index", &Site::index,
                      "The object's number; of a side of the box 0 ... 5, -x +x -y +y -z +z.")
        .def_property_readonly(
            "number", &number_of,
            "The object's number; -1 ... -6 for sides of the box, -7 for base and ends, -8 for "
            "the cap.")
        .def("__eq__", [](const Site& a,
                          const py::object& b) { return py::isinstance<Site>(b) && a == b.cast<Site>(); })
        .def("__hash__",
             [](const Site& s) {
                 return 16 * static_cast<std::size_t>(s.index) + static_cast<std::size_t>(s.kind);
             })
        .def("__str__", [](const Site& s) { return to_string(s); })
        .def("__repr__", [](const Site& s) { return "<vcell.Site " + to_string(s) + ">"; });

    py::class_<CellVertex>(m, "CellVertex", "A point equally far from the base and all of its sites.")
        .def_property_readonly(
            "point", [](const CellVertex& v) { return array_of(v.point); }, "Shape (3,).")
        .def_readonly("clearance", &CellVertex::radius, "Its distance from the base and from every site.")
        .def_property_readonly(
            "sites", [](const CellVertex& v) { return list_of(v.sites); }, "Ascending.")
        .def_readonly("error", &CellVertex::error, "A bound on its distance from the true vertex.")
        .def_readonly("is_touching", &CellVertex::is_touching,
                      "Bisectors touch here: `error` bounds by how much distances differ, halved.");

    py::class_<CellEdge>(m, "CellEdge", "An arc between two faces.")
        .def_property_readonly(
            "sites", [](const CellEdge& e) { return list_of(e.sites); }, "Left and right of it.")
        .def_property_readonly("extra_sites", [](const CellEdge& e) { return list_of(e.extra_sites); })
        .def_property_readonly(
            "vertices",
            [](const CellEdge& e) {
                return std::vector<std::uint32_t>(e.vertices.begin(), e.vertices.end());
            },
            "Numbers of both ends; empty: it is closed.")
        .def_property_readonly(
            "kind", [](const CellEdge& e) { return to_string(e.kind); },
            "\"line\", \"circle\", \"ellipse\", \"parabola\", \"hyperbola\" or \"spline\".")
        .def_readonly("curve", &CellEdge::curve, "A Curve3.")
        .def_readonly("error", &CellEdge::error, "A bound on its distance from the true arc.")
        .def_readonly("length", &CellEdge::length)
        .def_readonly("length_error", &CellEdge::length_error)
        .def_readonly("is_estimated", &CellEdge::is_estimated, "Is length_error an estimate, no bound?");

    py::class_<TrimCurve>(m, "TrimCurve", "A piece of a patch's boundary in its parameters.")
        .def_readonly("curve", &TrimCurve::curve, "A Curve2.")
        .def_readonly("edge", &TrimCurve::edge, "The number of the edge it is; None on a seam and in a tip.")
        .def_readonly("seam", &TrimCurve::seam, "The number of the seam it is; None on an edge and in a tip.")
        .def_readonly("reversed", &TrimCurve::reversed, "Does the edge's curve run the other way?");

    py::class_<TrimmedPatch>(m, "TrimmedPatch", "A patch and the loops that cut a face out of it.")
        .def_readonly("surface", &TrimmedPatch::surface, "A Patch.")
        .def_property_readonly(
            "loops",
            [](py::object self) {
                py::list result;
                for (const auto& loop : self.cast<const TrimmedPatch&>().loops)
                    result.append(references(loop, self));
                return result;
            },
            "Lists of TrimCurve: the outer one first, counter-clockwise, then holes.");

    py::class_<CellFace>(m, "CellFace", "A connected part of the boundary with one nearest site.")
        .def_readonly("site", &CellFace::site)
        .def_property_readonly("extra_sites", [](const CellFace& f) { return list_of(f.extra_sites); })
        .def_readonly("bisector", &CellFace::bisector, "The kind of surface, in a word.")
        .def_readonly("area", &CellFace::area)
        .def_readonly("area_error", &CellFace::area_error)
        .def_readonly("is_estimated", &CellFace::is_estimated, "Is area_error an estimate, no bound?")
        .def_property_readonly(
            "patches", [](py::object self) { return references(self.cast<const CellFace&>().patches, self); },
            "A list of TrimmedPatch.");
}

void bind_numbers(py::module_& m) {
    py::class_<Measures>(
        m, "Measures",
        "Volumes, areas and clearances, each with its error; NaN where they were not asked for.")
#define MEASURE(name) \
    .def_readonly(#name, &Measures::name).def_readonly(#name "_error", &Measures::name##_error)
        MEASURE(volume) MEASURE(body_volume) MEASURE(area) MEASURE(box_area) MEASURE(base_area)
            MEASURE(min_clearance) MEASURE(max_clearance)
#undef MEASURE
                .def_readonly("touches_box", &Measures::touches_box)
                .def_readonly("is_estimated", &Measures::is_estimated,
                              "Are the errors of volume, area and box_area estimates, no bounds?");

    py::class_<Report>(m, "Report", "How the cell came about.")
        .def_readonly("warnings", &Report::warnings)
        .def_property_readonly(
            "assumed", [](const Report& r) { return r.decisions.assumed; },
            "Coincidences that were taken for granted; each is among the warnings.")
        .def_property_readonly(
            "decisions",
            [](const Report& r) {
                py::dict result;
                result["double"] = r.decisions.by_double;
                result["interval"] = r.decisions.by_interval;
                result["exact"] = r.decisions.by_exact;
                result["multiprecision"] = r.decisions.by_multiprecision;
                result["assumed"] = r.decisions.assumed;
                return result;
            },
            "How many signs were decided on which rung.")
        .def_readonly("moved", &Report::moved,
                      "A bound on how far anything moved before it was decided about.")
        .def_readonly("insertions", &Report::insertions)
        .def_readonly("merges", &Report::merges)
        .def_readonly("pieces", &Report::pieces);
}

void bind_whole(py::module_& m) {
    py::class_<Cell>(m, "Cell",
                     "The Voronoi cell of a scene's base, in world coordinates. It does not change.")
        .def_readonly("scene", &Cell::scene)
        .def_property_readonly(
            "vertices", [](py::object self) { return references(self.cast<const Cell&>().vertices, self); },
            "A list of CellVertex.")
        .def_property_readonly(
            "edges", [](py::object self) { return references(self.cast<const Cell&>().edges, self); },
            "A list of CellEdge.")
        .def_property_readonly(
            "faces", [](py::object self) { return references(self.cast<const Cell&>().faces, self); },
            "A list of CellFace.")
        .def_property_readonly(
            "neighbors",
            [](const Cell& c) {
                return column<std::int64_t>(c.neighbors, [](std::uint32_t n) { return n; });
            },
            "Numbers of the objects that own a face, by decreasing area: shape (n,).")
        .def_readonly("measures", &Cell::measures)
        .def_readonly("report", &Cell::report)
        .def_readonly(
            "is_complete", &Cell::is_complete,
            "Are the faces all of the boundary? Otherwise they stand over what the box holds of the base.")
        .def_property_readonly(
            "vertex_points",
            [](const Cell& c) {
                return table<double>(
                    c.vertices, 3, [](auto& v) -> auto& { return v.point; });
            },
            "Shape (vertices, 3).")
        .def_property_readonly(
            "vertex_clearances",
            [](const Cell& c) { return column<double>(c.vertices, [](auto& v) { return v.radius; }); },
            "Shape (vertices,).")
        .def_property_readonly(
            "vertex_errors",
            [](const Cell& c) { return column<double>(c.vertices, [](auto& v) { return v.error; }); },
            "Bounds on the distances from the true vertices: shape (vertices,).")
        .def_property_readonly(
            "edge_vertices", [](const Cell& c) { return table<std::int64_t>(c.edges, 2, ends_of); },
            "Numbers of both ends, -1 for closed edges: shape (edges, 2).")
        .def_property_readonly(
            "edge_sites",
            [](const Cell& c) {
                return table<std::int64_t>(c.edges, 2, [](auto& e) {
                    return std::array{number_of(e.sites[0]), number_of(e.sites[1])};
                });
            },
            "Site numbers left and right: shape (edges, 2).")
        .def_property_readonly(
            "edge_lengths",
            [](const Cell& c) { return column<double>(c.edges, [](auto& e) { return e.length; }); },
            "Shape (edges,).")
        .def_property_readonly(
            "edge_errors",
            [](const Cell& c) { return column<double>(c.edges, [](auto& e) { return e.error; }); },
            "Bounds on the distances from the true arcs: shape (edges,).")
        .def_property_readonly(
            "face_sites",
            [](const Cell& c) {
                return column<std::int64_t>(c.faces, [](auto& f) { return number_of(f.site); });
            },
            "Site numbers: shape (faces,).")
        .def_property_readonly(
            "face_areas",
            [](const Cell& c) { return column<double>(c.faces, [](auto& f) { return f.area; }); },
            "Shape (faces,).")
        .def_property_readonly(
            "face_area_errors",
            [](const Cell& c) { return column<double>(c.faces, [](auto& f) { return f.area_error; }); },
            "Shape (faces,).")
        .def(
            "to_json",
            [](const Cell& c) {
                std::ostringstream out;
                write_cell(out, c);
                return out.str();
            },
            "The cell file's text; parse_cell() gives the same cell.")
        .def(py::pickle(
            [](const Cell& c) {
                std::ostringstream out;
                write_cell(out, c);
                return py::str(out.str());
            },
            [](const py::str& text) { return parse_cell(std::string(text)); }))
        .def("__repr__", [](const Cell& c) {
            return "<vcell.Cell: " + std::to_string(c.faces.size()) + " faces, " +
                   std::to_string(c.edges.size()) + " edges, " + std::to_string(c.vertices.size()) +
                   " vertices>";
        });
}

void bind_making(py::module_& m) {
    m.def(
        "cell",
        [](const Scene& scene, bool measure, bool patches, bool complete, py::object progress) {
            CellOptions options;
            options.measure = measure;
            options.patches = patches;
            options.complete = complete;
            Watch watch(std::move(progress));
            const py::gil_scoped_release unlocked;
            return voronoi_cell(scene, with_watch(options, watch));
        },
        py::arg("scene"), py::kw_only(), py::arg("measure") = true, py::arg("patches") = true,
        py::arg("complete") = false, py::arg("progress") = py::none(),
        "The Voronoi cell of the scene's base among its objects, inside the box.\n\n"
        "measure: with lengths, areas and volumes.\n"
        "patches: with patches of faces around a ball among balls and planes; others have them anyway.\n"
        "complete: of a base plane or an oblique base tube all of the box that is nearest to it.\n"
        "progress: called with a stage and a fraction in [0, 1] up to twenty times a second; may raise.\n\n"
        "Ctrl-C ends it. Raises InputError, UndecidedError.");

    const auto change = [&m](const char* name, auto function, const char* other, const char* doc) {
        m.def(name, function, py::arg("cell"), py::arg(other), doc);
    };
    change(
        "insert",
        [](const Cell& cell, const Object& object) {
            Watch watch{py::none()};
            const py::gil_scoped_release unlocked;
            return insert(cell, object, with_watch({}, watch));
        },
        "object", "The cell among one more object, which gets the next number, from the cell without it.");
    change(
        "remove",
        [](const Cell& cell, std::uint32_t object) {
            Watch watch{py::none()};
            const py::gil_scoped_release unlocked;
            return remove(cell, object, with_watch({}, watch));
        },
        "object", "The cell without an object, by its number; those after it get numbers lower by one.");
    change(
        "merge",
        [](const Cell& cell, const Cell& other) {
            Watch watch{py::none()};
            const py::gil_scoped_release unlocked;
            return merge(cell, other, with_watch({}, watch));
        },
        "other",
        "The cell among the objects of both, those of the second numbered after those of the first.");

    py::class_<CompleteMeasures>(m, "CompleteMeasures",
                                 "Measures of all of the box that is nearest to the base.")
        .def_readonly("volume", &CompleteMeasures::volume)
        .def_readonly("volume_error", &CompleteMeasures::volume_error)
        .def_readonly("area", &CompleteMeasures::area)
        .def_readonly("area_error", &CompleteMeasures::area_error)
        .def_property_readonly(
            "neighbors",
            [](const CompleteMeasures& c) {
                return column<std::int64_t>(c.neighbors, [](auto& n) { return n.object; });
            },
            "Numbers of objects, by decreasing area: shape (n,).")
        .def_property_readonly(
            "neighbor_areas",
            [](const CompleteMeasures& c) {
                return column<double>(c.neighbors, [](auto& n) { return n.area; });
            },
            "Shape (n,).")
        .def_property_readonly(
            "neighbor_area_errors",
            [](const CompleteMeasures& c) {
                return column<double>(c.neighbors, [](auto& n) { return n.area_error; });
            },
            "Shape (n,).")
        .def_readonly("is_estimated", &CompleteMeasures::is_estimated, "Are the errors estimates, no bounds?")
        .def_readonly("assumed", &CompleteMeasures::assumed);
    m.def(
        "complete_measures",
        [](const Scene& scene) {
            const py::gil_scoped_release unlocked;
            return complete_measures(scene);
        },
        py::arg("scene"),
        "Volume, area and neighbours of all of the box that is nearest to the base, over base points outside "
        "the box, too. Ctrl-C waits for its end.");
}

}  // namespace

void bind_cell(py::module_& m) {
    bind_parts(m);
    bind_numbers(m);
    bind_whole(m);
    bind_making(m);
}

}  // namespace vcell::python
