// Errors of kinetostat as exceptions of Python.
#include <exception>
#include <stdexcept>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/common/error.h"
#include "kinetostat/common/out_of_memory.h"
#include "kinetostat/python/bindings.h"

namespace kinetostat::python {
namespace {

namespace py = pybind11;

// The classes, for the translator, which is a plain function. They live as long as the interpreter.
struct ErrorClasses {
  py::handle input, convergence, identifiable, argument, argument_type;
};
ErrorClasses& classes() {
  static ErrorClasses all;
  return all;
}

py::handle new_class(py::module_& module, const char* name, const py::tuple& bases,
                     const char* doc) {
  const std::string whole = std::string("kinetostat.") + name;
  PyObject* made = PyErr_NewExceptionWithDoc(whole.c_str(), doc, bases.ptr(), nullptr);
  if (made == nullptr) throw py::error_already_set();
  module.attr(name) = py::reinterpret_borrow<py::object>(made);
  return made;
}

void raise_input_error(const common::InputError& error) {
  const common::InputError::Details& details = error.details();
  const py::object raised = py::reinterpret_borrow<py::object>(classes().input)(error.what());
  const auto number = [](int n) {
    return n > 0 ? py::object(py::int_(n)) : py::object(py::none());
  };
  raised.attr("file") = details.file.string();
  raised.attr("line") = number(details.line);
  raised.attr("column") = number(details.column);
  raised.attr("key") = details.key;
  raised.attr("what") = details.what;
  raised.attr("cure") = details.cure;
  PyErr_SetObject(classes().input.ptr(), raised.ptr());
}

void translate(std::exception_ptr thrown) {
  try {
    if (thrown) std::rethrow_exception(thrown);
  } catch (const common::InputError& error) {
    raise_input_error(error);
  } catch (const common::NoConvergence& error) {
    PyErr_SetString(classes().convergence.ptr(), error.what());
  } catch (const common::NotIdentifiable& error) {
    PyErr_SetString(classes().identifiable.ptr(), error.what());
  } catch (const apps::UsageError& error) {
    PyErr_SetString(classes().argument.ptr(), error.what());
  } catch (const py::value_error& error) {
    PyErr_SetString(classes().argument.ptr(), error.what());
  } catch (const std::invalid_argument& error) {
    PyErr_SetString(classes().argument.ptr(), error.what());
  } catch (const py::type_error& error) {
    PyErr_SetString(classes().argument_type.ptr(), error.what());
  } catch (const common::OutOfMemory& error) {
    PyErr_SetString(PyExc_MemoryError, error.what());
  }
}

}  // namespace

void add_errors(py::module_& module) {
  const py::handle base = new_class(module, "Error", py::make_tuple(py::handle(PyExc_Exception)),
                                    "What a user can repair.");
  const auto with = [&base](PyObject* builtin) {
    return py::make_tuple(base, py::handle(builtin));
  };
  classes().input = new_class(module, "InputError", with(PyExc_ValueError),
                              "A mistake in a file: file, line, column, key, what, cure.");
  classes().convergence = new_class(module, "NoConvergence", with(PyExc_ArithmeticError),
                                    "A computation on sound input that did not reach its goal.");
  classes().identifiable = new_class(module, "NotIdentifiable", with(PyExc_ValueError),
                                     "The data do not determine what was asked for.");
  classes().argument = new_class(module, "ArgumentError", with(PyExc_ValueError),
                                 "A value that an argument cannot have.");
  classes().argument_type = new_class(module, "ArgumentTypeError", with(PyExc_TypeError),
                                      "A value of a sort that an argument cannot be.");
  py::register_exception_translator(translate);
}

py::object values_of(const std::string& json) {
  return py::module_::import("json").attr("loads")(json);
}

}  // namespace kinetostat::python
