// Readings as columns by name, SI: what pandas.DataFrame() takes, and campaign_of() takes back.
#include <algorithm>
#include <array>
#include <cmath>
#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include "kinetostat/calibration/campaign/column_names.h"
#include "kinetostat/calibration/campaign/joint_column.h"
#include "kinetostat/python/bindings.h"
#include "kinetostat/vjm/exchange/body_tree.h"

namespace kinetostat::python {
namespace {

namespace py = pybind11;
using calibration::Campaign;
using calibration::Reading;
using Texts = std::vector<std::string>;

class ColumnWriter {
 public:
  explicit ColumnWriter(const CampaignValue& value)
      : manipulator_(value.robot.robot.manipulator), campaign_(value.campaign) {}

  py::dict write() {
    add_conditions();
    if (!campaign_.readings.empty()) add_postures();
    add_loads();
    add_displacements();
    if (!campaign_.correlations.empty()) add_correlations();
    for (const calibration::Covariate& covariate : campaign_.covariates)
      if (!table_.contains(covariate.name)) set(covariate.name, numbers_or(covariate.values));
    return std::move(table_);
  }

 private:
  void set(const std::string& name, const py::object& values) { table_[py::str(name)] = values; }

  template <class Value>
  void number(const std::string& name, const Value& value) {
    Eigen::VectorXd values(std::ssize(campaign_.readings));
    for (Eigen::Index i = 0; i < values.size(); ++i)
      values[i] = value(campaign_.readings[static_cast<std::size_t>(i)]);
    set(name, py::cast(values));
  }

  // No column where no reading has such a number.
  template <class Value>
  void number_if_any(const std::string& name, const Value& value) {
    const auto has = [&](const Reading& reading) { return !std::isnan(value(reading)); };
    if (std::any_of(campaign_.readings.begin(), campaign_.readings.end(), has)) number(name, value);
  }

  template <class Value>
  Texts texts(const Value& value) const {
    Texts all;
    for (const Reading& reading : campaign_.readings) all.push_back(value(reading));
    return all;
  }

  template <class Value>
  void text_if_any(const char* name, const Value& value) {
    const Texts all = texts(value);
    if (std::any_of(all.begin(), all.end(), [](const std::string& text) { return !text.empty(); }))
      set(name, py::cast(all));
  }

  void add_conditions() {
    const auto or_none = [](const std::optional<double>& number) {
      return number.value_or(calibration::not_a_number);
    };
    set("id", py::cast(texts([](const Reading& r) { return r.id; })));
    set("session",
        py::cast(texts([this](const Reading& r) { return campaign_.sessions[r.session]; })));
    text_if_any("cycle", [](const Reading& r) { return r.cycle; });
    number_if_any("step", [&](const Reading& r) { return or_none(r.step); });
    number_if_any("time", [&](const Reading& r) { return or_none(r.time); });
    number_if_any("temperature", [&](const Reading& r) { return or_none(r.temperature); });
    add_kinds();
  }

  void add_kinds() {
    text_if_any("setting", [](const Reading& r) { return r.setting; });
    text_if_any("replicate", [](const Reading& r) { return r.replicate; });
    text_if_any("direction", [](const Reading& r) -> std::string {
      if (r.direction == calibration::LoadDirection::unstated) return {};
      return r.direction == calibration::LoadDirection::loading ? "loading" : "unloading";
    });
    text_if_any("role", [](const Reading& r) -> std::string {
      if (r.role == calibration::Role::fit) return {};
      return calibration::role_names[static_cast<std::size_t>(r.role)];
    });
    text_if_any("instrument", [](const Reading& r) { return r.instrument; });
    std::vector<bool> used;
    for (const Reading& reading : campaign_.readings) used.push_back(!reading.masked);
    set("used", py::cast(used));
    text_if_any("mask_reason", [](const Reading& r) { return r.mask_reason; });
  }

  const calibration::Configuration& configuration(const Reading& reading) const {
    return campaign_.configurations[reading.configuration];
  }

  void add_postures() {
    const calibration::Configuration& first = configuration(campaign_.readings.front());
    const std::array names = {"x", "y", "z", "roll", "pitch", "yaw"};
    for (std::size_t k = 0; first.target && k < names.size(); ++k)
      number(names[k], [&](const Reading& r) {
        const spatial::Pose& target = *configuration(r).target;
        const auto axis = static_cast<Eigen::Index>(k % 3);
        return k < 3 ? target.position()[axis] : vjm::roll_pitch_yaw(target.rotation())[axis];
      });
    for (const auto& [name, coordinate] : first.joints)
      number(calibration::joint_column(manipulator_, name),
             [&, &joint = name](const Reading& r) { return configuration(r).joints.at(joint); });
  }

  void add_loads() {
    const std::array names = {"fx", "fy", "fz", "mx", "my", "mz", "px", "py", "pz"};
    for (std::size_t k = 0; k < names.size(); ++k)
      number(names[k], [k](const Reading& r) {
        const std::array parts = {&r.load.force, &r.load.moment, &r.load.point_on_platform};
        return (*parts[k / 3])[static_cast<Eigen::Index>(k % 3)];
      });
  }

  void add_displacements() {
    for (Eigen::Index k = 0; k < campaign_.size(); ++k)
      number(campaign_.component(k).name, [k](const Reading& r) { return r.displacement[k]; });
    if (const auto& control = campaign_.control)
      set(campaign_.component(control->set).name, py::cast(control->to));
    for (Eigen::Index k = 0; k < campaign_.size(); ++k)
      number_if_any("sigma_" + campaign_.component(k).name,
                    [k](const Reading& r) { return r.sigma[k]; });
  }

  // Of the noise of the platform's components.
  void add_correlations() {
    for (Eigen::Index i = 0; i < 6; ++i)
      for (Eigen::Index j = i + 1; j < 6; ++j) {
        const auto correlation = [&](const Reading& r) {
          return r.correlation ? campaign_.correlations[*r.correlation](i, j) : 0;
        };
        if (std::any_of(campaign_.readings.begin(), campaign_.readings.end(),
                        [&](const Reading& r) { return correlation(r) != 0; }))
          number("corr_" + calibration::correlation_name(i, j), correlation);
      }
  }

  // Numbers where all of them are, or nothing.
  static py::object numbers_or(const Texts& texts) {
    std::vector<double> numbers;
    try {
      for (const std::string& text : texts)
        numbers.push_back(text.empty() ? calibration::not_a_number
                                       : static_cast<double>(py::float_(py::str(text))));
    } catch (const py::error_already_set&) {  // "Anna"
      return py::cast(texts);
    }
    return py::cast(numbers);
  }

  const vjm::Manipulator& manipulator_;
  const Campaign& campaign_;
  py::dict table_;
};

}  // namespace

py::dict columns_of(const CampaignValue& value) { return ColumnWriter(value).write(); }

}  // namespace kinetostat::python
