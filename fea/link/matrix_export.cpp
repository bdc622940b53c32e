#include "kinetostat/fea/link/matrix_export.h"

#include <algorithm>
#include <iterator>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/common/printable.h"
#include "kinetostat/io/csv.h"

namespace kinetostat::fea {
namespace {

constexpr const char* motions[] = {"tx", "ty", "tz", "rx", "ry", "rz"};
constexpr const char* loads[] = {"Fx", "Fy", "Fz", "Mx", "My", "Mz"};

// "tip.Fx" and so on, of the interfaces from number `first` on.
std::vector<std::string> names(const std::vector<CoupledInterface>& interfaces, std::size_t first,
                               const char* const (&coordinates)[6]) {
  std::vector<std::string> list;
  for (std::size_t i = first; i < interfaces.size(); ++i)
    for (const char* coordinate : coordinates)
      list.push_back(fmt::format("{}.{}", interfaces[i].name, coordinate));
  return list;
}

Eigen::MatrixXd symmetric(const LinkResult& result) {
  const Eigen::MatrixXd& f = result.response.flexibility;
  return 0.5 * (f + f.transpose());
}

std::vector<double> row(const Eigen::MatrixXd& matrix, Eigen::Index i) {
  const Eigen::VectorXd values = matrix.row(i);
  return {values.begin(), values.end()};
}

// A text in MATLAB's single quotes, which end with the line.
std::string quoted(std::string text) {
  text = common::printable(text);
  for (std::size_t at = 0; (at = text.find('\'', at)) != std::string::npos; at += 2)
    text.insert(at, 1, '\'');
  return "'" + text + "'";
}

std::string quoted_list(std::vector<std::string> list) {
  std::transform(list.begin(), list.end(), list.begin(), quoted);
  return fmt::format("{{{}}}", fmt::join(list, ", "));
}

std::string points(const std::vector<CoupledInterface>& interfaces, std::size_t first) {
  std::string text = "[";
  for (std::size_t i = first; i < interfaces.size(); ++i) {
    const Vector3& p = interfaces[i].point;
    text += fmt::format("{}{} {} {}", i == first ? "" : "; ", p.x(), p.y(), p.z());
  }
  return text + "];\n";
}

std::string matrix(const char* name, const Eigen::MatrixXd& values) {
  std::string text = fmt::format("{} = [\n", name);
  for (Eigen::Index i = 0; i < values.rows(); ++i)
    text += fmt::format("  {}\n", fmt::join(row(values, i), " "));
  return text + "];\n";
}

}  // namespace

std::string flexibility_csv(const LinkResult& result) {
  const Eigen::MatrixXd f = symmetric(result);
  std::string text = "motion";
  for (const std::string& load : names(result.interfaces, 1, loads))
    text += "," + io::csv_cell(load);
  Eigen::Index i = 0;
  for (const std::string& motion : names(result.interfaces, 1, motions))
    text += fmt::format("\n{},{}", io::csv_cell(motion), fmt::join(row(f, i++), ","));
  return text + "\n";
}

std::string flexibility_matlab(const LinkResult& result) {
  const Eigen::MatrixXd f = symmetric(result);
  const std::string text = fmt::format(
      "% Flexibility of a link between its loaded interfaces, the fixed one at rest.\n"
      "% Columns: loads [N, N m]; rows: motions [m, rad]; mesh axes; points in m.\n"
      "name = {};\nmotions = {};\nloads = {};\n",
      quoted(result.name), quoted_list(names(result.interfaces, 1, motions)),
      quoted_list(names(result.interfaces, 1, loads)));
  return text + "points = " + points(result.interfaces, 1) + matrix("flexibility", f) +
         "stiffness = inv(flexibility);\n";
}

std::string reduced_matlab(const ModalResult& result, const ReducedModel& model) {
  std::vector<std::string> freedoms = names(result.interfaces, 0, motions);
  for (Eigen::Index k = model.interface_motions; k < model.mass.rows(); ++k)
    freedoms.push_back(fmt::format("mode {}", k - model.interface_motions + 1));
  return fmt::format(
             "% Stiffness and mass of a free link, by Craig and Bampton's method: motions of its\n"
             "% interfaces at their origins, then modes with these held. SI units, mesh axes.\n"
             "name = {};\nfreedoms = {};\norigins = ",
             quoted(result.name), quoted_list(freedoms)) +
         points(result.interfaces, 0) + matrix("K", model.stiffness) + matrix("M", model.mass);
}

}  // namespace kinetostat::fea
