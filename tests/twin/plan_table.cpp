#include "plan_table.h"

#include <algorithm>
#include <fstream>
#include <numbers>
#include <sstream>
#include <stdexcept>

#include <fmt/format.h>

#include "day.h"

namespace twin {
namespace {

using Cells = std::vector<std::string>;

Cells cells_of(const std::string& line) {
  Cells cells;
  std::istringstream text(line);
  for (std::string cell; std::getline(text, cell, ',');) cells.push_back(cell);
  return cells;
}

class Table {
 public:
  explicit Table(const std::filesystem::path& file) : file_(file) {
    std::ifstream text(file);
    for (std::string line; std::getline(text, line);) {
      if (line.empty() || line[0] == '#') continue;
      (head_.empty() ? head_ : rows_.emplace_back()) = cells_of(line);
    }
    if (rows_.empty()) throw std::runtime_error(fmt::format("no readings in {}", file.string()));
    for (const char* other : {"mx", "px", "roll"})
      if (std::find(head_.begin(), head_.end(), other) != head_.end())
        throw std::runtime_error(fmt::format("{}: the twin has no {}", file.string(), other));
  }

  std::size_t size() const { return rows_.size(); }
  const std::string& text(std::size_t row, const std::string& name) const {
    const auto found = std::find(head_.begin(), head_.end(), name);
    if (found == head_.end())
      throw std::runtime_error(fmt::format("{} has no column {}", file_.string(), name));
    return rows_[row].at(static_cast<std::size_t>(found - head_.begin()));
  }
  double number(std::size_t row, const std::string& name) const {
    return std::stod(text(row, name));
  }
  Vector3 vector(std::size_t row, const char* x, const char* y, const char* z) const {
    return {number(row, x), number(row, y), number(row, z)};
  }

 private:
  std::filesystem::path file_;
  Cells head_;
  std::vector<Cells> rows_;
};

Posture posture_in(const Table& table, std::size_t row, const RobotSpec& robot) {
  if (!robot.serial) return posture_at(robot, 1e-3 * table.vector(row, "x", "y", "z"));
  std::vector<double> q;
  for (const Item& item : robot.chains[0].items)
    if (item.kind == Item::actuator)
      q.push_back(table.number(row, item.name) * (item.axes[0] < 3 ? 1e-3 : degree));
  return posture_of(robot,
                    Eigen::Map<Eigen::VectorXd>(q.data(), static_cast<Eigen::Index>(q.size())));
}

}  // namespace

Plan plan_of_table(const std::filesystem::path& file, const RobotSpec& robot,
                   const std::string& session, Random& random) {
  const Table table(file);
  Day day(random);
  Plan plan;
  std::string cycle;
  for (std::size_t i = 0; i < table.size(); ++i) {
    Row row;
    row.session = session;
    row.starts = table.text(i, "cycle") != cycle;
    if (row.starts) plan.postures.push_back(posture_in(table, i, robot));
    cycle = table.text(i, "cycle");
    row.posture = row.cycle = static_cast<int>(plan.postures.size()) - 1;
    row.step = static_cast<int>(table.number(i, "step"));
    row.time = table.number(i, "time");
    row.force = table.vector(i, "fx", "fy", "fz");
    row.unloading = !row.starts && row.force.norm() < plan.rows.back().force.norm();
    day.tell(row);
    plan.rows.push_back(row);
  }
  return plan;
}

}  // namespace twin
