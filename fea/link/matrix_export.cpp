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

// "tip.Fx" and so on, of all loaded interfaces.
std::vector<std::string> names(const LinkResult& result, const char* const (&coordinates)[6]) {
  std::vector<std::string> list;
  for (std::size_t i = 1; i < result.interfaces.size(); ++i)
    for (const char* coordinate : coordinates)
      list.push_back(fmt::format("{}.{}", result.interfaces[i].name, coordinate));
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

}  // namespace

std::string flexibility_csv(const LinkResult& result) {
  const Eigen::MatrixXd f = symmetric(result);
  std::string text = "motion";
  for (const std::string& load : names(result, loads)) text += "," + io::csv_cell(load);
  Eigen::Index i = 0;
  for (const std::string& motion : names(result, motions))
    text += fmt::format("\n{},{}", io::csv_cell(motion), fmt::join(row(f, i++), ","));
  return text + "\n";
}

std::string flexibility_matlab(const LinkResult& result) {
  const Eigen::MatrixXd f = symmetric(result);
  std::string text = fmt::format(
      "% Flexibility of a link between its loaded interfaces, the fixed one at rest.\n"
      "% Columns: loads [N, N m]; rows: motions [m, rad]; mesh axes; points in m.\n"
      "name = {};\nmotions = {};\nloads = {};\n",
      quoted(result.name), quoted_list(names(result, motions)), quoted_list(names(result, loads)));
  text += "points = [";
  for (std::size_t i = 1; i < result.interfaces.size(); ++i) {
    const Vector3& p = result.interfaces[i].point;
    text += fmt::format("{}{} {} {}", i == 1 ? "" : "; ", p.x(), p.y(), p.z());
  }
  text += "];\nflexibility = [\n";
  for (Eigen::Index i = 0; i < f.rows(); ++i)
    text += fmt::format("  {}\n", fmt::join(row(f, i), " "));
  return text + "];\nstiffness = inv(flexibility);\n";
}

}  // namespace kinetostat::fea
