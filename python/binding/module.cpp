#include "binding.hpp"

PYBIND11_MODULE(_vcell, m) {
    m.attr("__version__") = VCELL_VERSION;
    vcell::python::bind_errors(m);
    vcell::python::bind_scene(m);
    vcell::python::bind_curves(m);
    vcell::python::bind_cell(m);
    vcell::python::bind_diagram(m);
    vcell::python::bind_tools(m);
}
