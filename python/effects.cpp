// Effects whose law is a function of Python.
#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include <fmt/format.h>

#include "kinetostat/io/yaml.h"
#include "kinetostat/python/bindings.h"
#include "kinetostat/vjm/effects/kinds/user_effect.h"
#include "kinetostat/vjm/io/effect_file.h"

namespace kinetostat::python {
namespace {

namespace py = pybind11;
using vjm::EffectKind;
using vjm::effects::UserLaw;

// Threads of a search hold it, too, and let go of it without Python's lock.
std::shared_ptr<const py::function> shared(const py::function& function) {
  return {new py::function(function), [](const py::function* held) {
            const py::gil_scoped_acquire locked;
            delete held;
          }};
}

class PythonFunction : public vjm::SmoothFunction {
 public:
  /// `call` takes the variables and the number of one of them, and returns the value and the
  /// derivative by that one.
  PythonFunction(const py::function& call, std::vector<bool> used)
      : call_(shared(call)), used_(std::move(used)) {}

  bool uses(Eigen::Index variable) const override {
    return used_[static_cast<std::size_t>(variable)];
  }
  double value(const Eigen::VectorXd& variables) const override { return at(variables, -1).value; }
  Dual derivative(const Eigen::VectorXd& variables, Eigen::Index variable) const override {
    return at(variables, uses(variable) ? variable : -1);
  }

 private:
  Dual at(const Eigen::VectorXd& variables, Eigen::Index variable) const {
    const py::gil_scoped_acquire locked;
    const std::vector<double> numbers(variables.begin(), variables.end());
    const auto [value, slope] = (*call_)(numbers, variable).cast<std::pair<double, double>>();
    return {value, slope};
  }

  std::shared_ptr<const py::function> call_;
  std::vector<bool> used_;
};

UserLaw law_named(const std::string& law) {
  if (law == "force") return UserLaw::force;
  if (law == "offset") return UserLaw::offset;
  if (law == "compliance") return UserLaw::compliance;
  throw py::value_error(
      fmt::format("law: '{}' is none of 'force', 'offset' and 'compliance'", law));
}

std::vector<vjm::EffectParameter> parameters_of(const std::string& json) {
  return vjm::read_effect_parameters(io::parse_yaml(json, "the parameters"));
}

void require_new(const std::string& name) {
  for (const auto& known : vjm::effect_kinds())
    if (known->name == name)
      throw py::value_error(fmt::format("the catalogue has a '{}' already", name));
}

std::shared_ptr<EffectKind> function_kind(const std::string& name, const std::string& law,
                                          const py::function& call, const std::vector<bool>& used,
                                          const std::string& parameters,
                                          const std::vector<std::string>& covariates,
                                          const std::string& summary) {
  require_new(name);
  const std::vector<vjm::EffectParameter> described = parameters_of(parameters);
  const auto kind =
      vjm::effects::user_effect(law_named(law), std::make_shared<PythonFunction>(call, used),
                                covariates, described, vjm::usual_values(described));
  kind->name = name;
  kind->summary = summary;
  kind->law = "a function of Python";
  kind->source = "a program";
  kind->signature = kind->confuser = "not stated";
  return kind;
}

std::vector<std::string> law_variables(const std::string& law,
                                       const std::vector<std::string>& covariates,
                                       const std::string& parameters) {
  return vjm::effects::user_variables(law_named(law), covariates, parameters_of(parameters));
}

}  // namespace

void add_effects(py::module_& module) {
  py::class_<EffectKind, std::shared_ptr<EffectKind>>(module, "FunctionKind",
                                                      "A law that Python computes.")
      .def(py::init(&function_kind), py::arg("name"), py::arg("law"), py::arg("call"),
           py::arg("used"), py::arg("parameters"), py::arg("covariates"), py::arg("summary"))
      .def_readonly("name", &EffectKind::name)
      .def("__repr__", [](const EffectKind& kind) {
        return fmt::format("FunctionKind '{}': {}", kind.name, kind.summary);
      });
  module.def("law_variables", &law_variables, py::arg("law"), py::arg("covariates"),
             py::arg("parameters"));
  module.def(
      "usual_values",
      [](const std::string& parameters) { return vjm::usual_values(parameters_of(parameters)); },
      py::arg("parameters"));
}

}  // namespace kinetostat::python
