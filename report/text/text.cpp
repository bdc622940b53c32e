#include "kinetostat/report/text/text.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

#include "kinetostat/common/printable.h"

namespace kinetostat::report {
namespace {

using spatial::Matrix3;
using spatial::Matrix6;
using spatial::UnitSystem;
using spatial::Vector3;

constexpr double negligible = 1e-10;
constexpr std::array motions{"tx", "ty", "tz", "rx", "ry", "rz"};
constexpr std::array loads{"Fx", "Fy", "Fz", "Mx", "My", "Mz"};

bool is_number_or_empty(const std::string& cell) {
  if (cell.empty() || cell == "-") return true;
  double value = 0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  return error == std::errc() && end == cell.data() + cell.size();
}

// Characters, not bytes: "µm" is two wide.
std::size_t width_of(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xC0) != 0x80;
  }));
}

double factor(const std::string& unit) { return spatial::parse_unit(unit).factor; }

std::string moment_unit(const UnitSystem& units) { return units.force + " " + units.length; }

// Components that are rounding beside the largest one are printed as 0.
std::string vector_text(const Vector3& v) {
  const double size = v.cwiseAbs().maxCoeff();
  const auto shown = [size](double x) { return number(std::abs(x) < 1e-12 * size ? 0 : x, 6); };
  return fmt::format("({}, {}, {})", shown(v.x()), shown(v.y()), shown(v.z()));
}

std::string frame_text(const spatial::Frame& frame, const UnitSystem& units) {
  const std::string point =
      fmt::format("at point {} {}", vector_text(frame.point / factor(units.length)), units.length);
  if (frame.axes == Matrix3::Identity()) return point + ", base axes";
  return fmt::format("{}, axes x {} y {} z {}", point, vector_text(frame.axes.col(0)),
                     vector_text(frame.axes.col(1)), vector_text(frame.axes.col(2)));
}

// Rows and columns scaled from SI; entries that are rounding set to zero. The size of a coupling
// block is judged by the two diagonal blocks, which share its units between them.
Matrix6 for_display(const Matrix6& si, const spatial::Vector6& rows,
                    const spatial::Vector6& columns) {
  const double translational = si.topLeftCorner<3, 3>().cwiseAbs().maxCoeff();
  const double rotational = si.bottomRightCorner<3, 3>().cwiseAbs().maxCoeff();
  Matrix6 shown;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) {
      const double size =
          std::sqrt((i < 3 ? translational : rotational) * (j < 3 ? translational : rotational));
      shown(i, j) = std::abs(si(i, j)) <= negligible * size ? 0 : si(i, j) * rows[i] * columns[j];
    }
  return shown;
}

template <class Labels>
std::string matrix_text(const Matrix6& matrix, const Labels& rows, const Labels& columns) {
  std::string text = "    ";
  for (const char* label : columns) text += fmt::format("{:>12}", label);
  text += '\n';
  for (int i = 0; i < 6; ++i) {
    text += fmt::format("  {}", rows[static_cast<std::size_t>(i)]);
    for (int j = 0; j < 6; ++j)
      text += matrix(i, j) == 0 ? fmt::format("{:>12}", 0) : fmt::format("{:>12.4e}", matrix(i, j));
    text += '\n';
  }
  return text;
}

// [a, a, a, b, b, b].
spatial::Vector6 halves(double a, double b) {
  spatial::Vector6 v;
  v << Vector3::Constant(a), Vector3::Constant(b);
  return v;
}

std::string pair_text(const std::string& heading, const char* first, const Vector3& a,
                      const std::string& unit_a, const char* second, const Vector3& b,
                      const std::string& unit_b) {
  return fmt::format("{}\n  {:<12} {} {}\n  {:<12} {} {}\n", heading, first,
                     vector_text(a / factor(unit_a)), unit_a, second,
                     vector_text(b / factor(unit_b)), unit_b);
}

}  // namespace

std::string number(double value, int digits) {
  return fmt::format("{:.{}g}", value == 0 ? 0.0 : value, digits);
}

std::string percent(double share) { return number(100 * share, 2) + " %"; }

std::string probability_in_words(double probability) {
  if (probability > 0.999) return "over 99.9 %";
  if (probability >= 0.01 || probability <= 0) return number(100 * probability, 3) + " %";
  return fmt::format("{} (odds 1 : {:.0f})", percent(probability), 1 / probability - 1);
}

Table::Table(std::vector<std::string> header) { rows_.push_back(std::move(header)); }

void Table::add_row(std::vector<std::string> cells) {
  if (cells.size() != rows_.front().size())
    throw std::invalid_argument(fmt::format("a row of {} cells in a table of {} columns",
                                            cells.size(), rows_.front().size()));
  for (std::string& cell : cells) cell = common::printable(cell);  // a row is one line
  rows_.push_back(std::move(cells));
}

namespace {

std::string line_of(const std::vector<std::string>& row, const std::vector<std::size_t>& width,
                    const std::vector<bool>& numeric) {
  std::string line;
  for (std::size_t c = 0; c < width.size(); ++c) {
    const std::string blanks(width[c] - width_of(row[c]), ' ');
    line += "  " + (numeric[c] ? blanks + row[c] : row[c] + blanks);
  }
  line.erase(line.find_last_not_of(' ') + 1);
  return line + '\n';
}

}  // namespace

std::string Table::text() const {
  const std::size_t columns = rows_.front().size();
  std::vector<std::size_t> width(columns, 0);
  std::vector<bool> numeric(columns, true);
  for (std::size_t r = 0; r < rows_.size(); ++r)
    for (std::size_t c = 0; c < columns; ++c) {
      width[c] = std::max(width[c], width_of(rows_[r][c]));
      if (r > 0 && !is_number_or_empty(rows_[r][c])) numeric[c] = false;
    }
  std::string text;
  for (const auto& row : rows_) text += line_of(row, width, numeric);
  return text;
}

std::string text(const spatial::Compliance6& compliance, const UnitSystem& units) {
  const double length = factor(units.length), force = factor(units.force);
  const Matrix6 shown =
      for_display(compliance.matrix(), halves(1 / length, 1), halves(force, force * length));
  return fmt::format("Compliance {}; [{}; rad] per [{}; {}]\n",
                     frame_text(compliance.frame(), units), units.length, units.force,
                     moment_unit(units)) +
         matrix_text(shown, motions, loads);
}

std::string text(const spatial::Stiffness6& stiffness, const UnitSystem& units) {
  const double length = factor(units.length), force = factor(units.force);
  const Matrix6 shown =
      for_display(stiffness.matrix(), halves(1 / force, 1 / (force * length)), halves(length, 1));
  return fmt::format("Stiffness {}; [{}; {}] per [{}; rad]\n", frame_text(stiffness.frame(), units),
                     units.force, moment_unit(units), units.length) +
         matrix_text(shown, loads, motions);
}

std::string text(const spatial::Wrench& wrench, const UnitSystem& units) {
  return pair_text("Wrench " + frame_text(wrench.frame, units), "force", wrench.force, units.force,
                   "moment", wrench.moment, moment_unit(units));
}

std::string text(const spatial::Twist& twist, const UnitSystem& units) {
  return pair_text("Displacement " + frame_text(twist.frame, units), "translation",
                   twist.translation, units.length, "rotation", twist.rotation, units.angle);
}

}  // namespace kinetostat::report
