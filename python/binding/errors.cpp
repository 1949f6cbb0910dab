// The library's errors as Python's: bad input is a ValueError that names its place.
#include "../../core/errors.hpp"

#include <pybind11/pybind11.h>

#include "../../core/platform.hpp"
#include "../../io/files/files.hpp"
#include "binding.hpp"

namespace vcell::python {

namespace {

const char* name_of(InputError::Kind kind) {
    switch (kind) {
        case InputError::Kind::Syntax: return "syntax";
        case InputError::Kind::UnknownKey: return "unknown key";
        case InputError::Kind::MissingKey: return "missing key";
        case InputError::Kind::WrongType: return "wrong type";
        case InputError::Kind::NotFinite: return "not finite";
        case InputError::Kind::NegativeRadius: return "negative radius";
        case InputError::Kind::ZeroAxis: return "zero axis";
        case InputError::Kind::EmptyBox: return "empty box";
        case InputError::Kind::Unsupported: return "unsupported";
        case InputError::Kind::TouchesBase: return "touches base";
        case InputError::Kind::OutOfRange: return "out of range";
    }
    return "";
}

// They live as long as the interpreter: a translator has no state of its own.
PyObject* input_error = nullptr;

void raise_input_error(const InputError& e) {
    const py::object raised = py::reinterpret_borrow<py::object>(input_error)(e.what());
    raised.attr("path") = e.path;
    raised.attr("object") = e.object == InputError::no_object ? py::object(py::none()) : py::int_(e.object);
    raised.attr("kind") = name_of(e.kind);
    PyErr_SetObject(input_error, raised.ptr());
}

}  // namespace

void bind_errors(py::module_& m) {
    input_error = PyErr_NewExceptionWithDoc(
        "vcell.InputError",
        "Input that cannot be used.\n\n"
        "path: the place, as a scene file names it (\"objects[3].sphere.radius\").\n"
        "object: the number of the offending object, or None.\n"
        "kind: what is wrong with it, in two words.",
        PyExc_ValueError, nullptr);
    m.add_object("InputError", py::reinterpret_borrow<py::object>(input_error));
    py::register_exception_translator([](std::exception_ptr error) {
        try {
            if (error) std::rethrow_exception(error);
        } catch (const InputError& e) {
            raise_input_error(e);
        }
    });
    const auto add = [&m](auto& type, const char* doc) { type.attr("__doc__") = doc, static_cast<void>(m); };
    add(py::register_exception<UndecidedError>(m, "UndecidedError", PyExc_RuntimeError),
        "A question about legal input that the digits at hand cannot decide; the message names the place.");
    add(py::register_exception<InternalError>(m, "InternalError", PyExc_RuntimeError),
        "A broken invariant: a bug in vcell.");
    add(py::register_exception<EnvironmentError>(m, "ArithmeticModeError", PyExc_RuntimeError),
        "The thread's floating-point unit does not round to nearest, or flushes subnormal numbers.");
    add(py::register_exception<ReadError>(m, "ReadError", PyExc_OSError), "A file that cannot be read.");
    add(py::register_exception<WriteError>(m, "WriteError", PyExc_OSError), "A file that cannot be written.");
}

}  // namespace vcell::python
