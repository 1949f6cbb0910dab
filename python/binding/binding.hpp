/// The Python module's parts, each in a file of its own. No geometry is here: each function converts, calls
/// the library's and converts back.
#pragma once

#include <pybind11/pybind11.h>

#include <chrono>

namespace vcell::python {

namespace py = pybind11;

void bind_errors(py::module_& m);
void bind_scene(py::module_& m);
void bind_curves(py::module_& m);
void bind_cell(py::module_& m);
void bind_diagram(py::module_& m);
void bind_tools(py::module_& m);

/// What a long computation calls, without the interpreter's lock, to let Ctrl-C and other signals end it and
/// to tell the caller's function how far it is; both at most twenty times a second.
class Watch {
public:
    /// `progress`: None, or a function.
    explicit Watch(py::object progress) : progress_(std::move(progress)) {}

    /// Throws what the signal's handler or the function raises.
    template <class... Told>
    void operator()(Told... told) {
        if (!is_time()) return;
        py::gil_scoped_acquire lock;
        if (PyErr_CheckSignals() != 0) throw py::error_already_set();
        if (!progress_.is_none()) progress_(told...);
    }

private:
    bool is_time() {
        const auto now = std::chrono::steady_clock::now();
        if (now < next_) return false;
        next_ = now + std::chrono::milliseconds(50);
        return true;
    }

    py::object progress_;
    std::chrono::steady_clock::time_point next_{};
};

}  // namespace vcell::python
