// Rational curves and patches, to evaluate at many parameters at once.
#include "../../core/curves/bspline.hpp"

#include <pybind11/stl.h>

#include "../../envelope/trisector/trisector_curves.hpp"
#include "arrays.hpp"
#include "binding.hpp"

namespace vcell::python {

namespace {

/// An array of the shape of `like` with one more axis, of `width`.
py::array_t<double> array_like(const Doubles& like, py::ssize_t width) {
    std::vector<py::ssize_t> shape(like.shape(), like.shape() + like.ndim());
    shape.push_back(width);
    return py::array_t<double>(shape);
}

template <int Dim>
void bind_curve(py::module_& m, const char* name, const char* doc) {
    using Curve = RationalCurve<Dim>;
    py::class_<Curve>(m, name, doc)
        .def_readonly("degree", &Curve::degree)
        .def_property_readonly(
            "knots", [](const Curve& c) { return array_of(c.knots); },
            "Full and clamped: shape (points + degree + 1,).")
        .def_property_readonly(
            "control_points",
            [](const Curve& c) {
                return table<double>(
                    c.points, Dim, [](auto& p) -> auto& { return p; });
            },
            "Weights divided out: shape (n, dimension).")
        .def_property_readonly(
            "weights",
            [](const Curve& c) { return column<double>(c.points, [](auto& p) { return p[Dim]; }); },
            "Positive: shape (n,).")
        .def_property_readonly(
            "domain", [](const Curve& c) { return py::make_tuple(c.domain_begin(), c.domain_end()); },
            "The first and the last parameter.")
        .def(
            "evaluate",
            [](const Curve& c, py::handle parameters) {
                const Doubles t = doubles(parameters, "t");
                py::array_t<double> result = array_like(t, Dim);
                double* to = result.mutable_data();
                for (py::ssize_t i = 0; i < t.size(); ++i, to += Dim) {
                    const auto point = c.evaluate(t.data()[i]);
                    std::copy(point.data(), point.data() + Dim, to);
                }
                return result;
            },
            py::arg("t"), "Points: shape (*t.shape, dimension). Parameters are clamped to the domain.")
        .def(
            "derivative",
            [](const Curve& c, py::handle parameters) {
                const Doubles t = doubles(parameters, "t");
                py::array_t<double> result = array_like(t, Dim);
                double* to = result.mutable_data();
                for (py::ssize_t i = 0; i < t.size(); ++i, to += Dim) {
                    const auto derivative = c.evaluate_with_derivative(t.data()[i])[1];
                    std::copy(derivative.data(), derivative.data() + Dim, to);
                }
                return result;
            },
            py::arg("t"), "First derivatives by the parameter: shape (*t.shape, dimension).");
}

/// Both parameters, of one shape.
std::array<Doubles, 2> parameters_of(py::handle u, py::handle v) {
    std::array<Doubles, 2> result{doubles(u, "u"), doubles(v, "v")};
    const bool agree = result[0].ndim() == result[1].ndim() &&
                       std::equal(result[0].shape(), result[0].shape() + result[0].ndim(), result[1].shape());
    if (!agree) throw py::value_error("v: must have the shape of u");
    return result;
}

void bind_trisectors(py::module_& m) {
    py::class_<TrisectorCurve>(m, "TrisectorCurve",
                               "A connected part of a trisector within a box, cut at nodes.")
        .def_property_readonly(
            "kind", [](const TrisectorCurve& c) { return std::string(to_string(c.kind)); },
            "\"line\", \"circle\", \"ellipse\", \"parabola\", \"hyperbola\" or \"spline\".")
        .def_readonly("degree", &TrisectorCurve::degree, "Algebraic, of the curve it is on.")
        .def_property_readonly(
            "arcs", [](py::object self) { return references(self.cast<const TrisectorCurve&>().arcs, self); },
            "A list of Curve3, each of which begins where the one before ends.")
        .def_readonly("error", &TrisectorCurve::error,
                      "A bound on the arcs' distance from this part of the trisector, and on its from them.")
        .def_readonly("is_closed", &TrisectorCurve::is_closed);
    m.def(
        "trisector",
        [](const Object& base, const Object& a, const Object& b, py::handle given, double tolerance) {
            const Box within = box(given);
            if (!((within.max - within.min).minCoeff() > 0))
                throw py::value_error("box: must have a positive extent along each axis");
            if (!(tolerance > 0)) throw py::value_error("tolerance: must be above 0");
            if (base == a || base == b || a == b) throw py::value_error("b: two of the objects are the same");
            const py::gil_scoped_release unlocked;
            return trisector(base, a, b, within, tolerance);
        },
        py::arg("base"), py::arg("a"), py::arg("b"), py::kw_only(), py::arg("box"), py::arg("tolerance"),
        "All points of a box that are equally far from three objects, as a list of TrisectorCurve: lines and conics "
        "exact, splines within `tolerance`, a length. Points in a ball or tube are none; planes count from both sides.");
}

}  // namespace

void bind_curves(py::module_& m) {
    bind_curve<2>(m, "Curve2", "A rational B-spline curve in a patch's parameters.");
    bind_curve<3>(m, "Curve3", "A rational B-spline curve in space.");

    bind_trisectors(m);

    py::class_<RationalPatch>(m, "Patch", "A rational tensor-product Bezier patch.")
        .def_property_readonly("degrees",
                               [](const RationalPatch& p) { return py::make_tuple(p.degree_u, p.degree_v); })
        .def_property_readonly(
            "domain", [](const RationalPatch& p) { return py::make_tuple(p.domain_u, p.domain_v); },
            "((u0, u1), (v0, v1)).")
        .def_property_readonly(
            "control_points",
            [](const RationalPatch& p) {
                return table<double>(
                           p.points, 3, [](auto& q) -> auto& { return q; })
                    .reshape({p.degree_u + 1, p.degree_v + 1, 3});
            },
            "Weights divided out: shape (degree_u + 1, degree_v + 1, 3).")
        .def_property_readonly(
            "weights",
            [](const RationalPatch& p) {
                return column<double>(p.points, [](auto& q) { return q[3]; })
                    .reshape({p.degree_u + 1, p.degree_v + 1});
            },
            "Positive: shape (degree_u + 1, degree_v + 1).")
        .def(
            "evaluate",
            [](const RationalPatch& p, py::handle u_given, py::handle v_given) {
                const auto [u, v] = parameters_of(u_given, v_given);
                py::array_t<double> result = array_like(u, 3);
                double* to = result.mutable_data();
                for (py::ssize_t i = 0; i < u.size(); ++i, to += 3) {
                    const Vec3 point = p.evaluate(u.data()[i], v.data()[i]);
                    std::copy(point.data(), point.data() + 3, to);
                }
                return result;
            },
            py::arg("u"), py::arg("v"),
            "Points: shape (*u.shape, 3). Valid outside the domain, too, as the surface goes on there.")
        .def(
            "partials",
            [](const RationalPatch& p, py::handle u_given, py::handle v_given) {
                const auto [u, v] = parameters_of(u_given, v_given);
                std::array<py::array_t<double>, 2> result{array_like(u, 3), array_like(u, 3)};
                for (py::ssize_t i = 0; i < u.size(); ++i) {
                    const auto partial = p.partials(u.data()[i], v.data()[i]);
                    for (int k = 0; k < 2; ++k)
                        std::copy(partial[k].data(), partial[k].data() + 3, result[k].mutable_data() + 3 * i);
                }
                return py::make_tuple(result[0], result[1]);
            },
            py::arg("u"), py::arg("v"),
            "Derivatives by u and by v, each of shape (*u.shape, 3). Their cross product points out of the cell.");
}

}  // namespace vcell::python
