#include "kinetostat/calibration/statistics/identifiability.h"

#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/common/error.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;

// An unknown takes part in a combination when this share of its column does.
constexpr double takes_part = 0.3;

const UnknownName& at(const std::vector<UnknownName>& names, Index k) {
  return names[static_cast<std::size_t>(k)];
}

void require_sensitivity(const std::vector<UnknownName>& names, const Eigen::MatrixXd& jacobian,
                         const std::vector<Index>& free, double scale) {
  std::vector<std::string> idle;
  for (const Index k : free)
    if (!(jacobian.col(k).norm() * at(names, k).typical > sensitivity_rounding * scale))
      idle.push_back(at(names, k).phrase);
  if (!idle.empty())
    throw common::NotIdentifiable(
        fmt::format("no reading depends on {}: these data cannot determine it. Load it in a "
                    "measured direction, or take it out of 'uncertain' in the robot file.",
                    fmt::join(idle, " and ")));
}

std::vector<Index> members_of(const WeakCombination& weak) {
  std::vector<Index> members;
  for (Index k = 0; k < weak.participation.size(); ++k)
    if (weak.participation[k] > takes_part) members.push_back(k);
  return members;
}

std::vector<std::string> phrases(const std::vector<UnknownName>& names,
                                 const std::vector<Index>& members) {
  std::vector<std::string> result;
  result.reserve(members.size());
  for (const Index k : members) result.push_back(at(names, k).phrase);
  return result;
}

// "+35 %", "times 4.2", "-1.3e-05 m".
std::string change_text(const UnknownName& name, double change) {
  if (!name.is_logarithm) return fmt::format("{:+.2g} {}", change, name.unit);
  if (std::abs(change) < 0.7) return fmt::format("{:+.2g} %", 100 * std::expm1(change));
  return fmt::format("times {:.2g}", std::exp(std::clamp(change, -700.0, 700.0)));
}

// What of two unknowns the data do know.
std::string known_of(const UnknownName& a, const UnknownName& b, double change_a, double change_b) {
  const double ratio = std::abs(change_a / change_b);
  if (!a.is_logarithm || !b.is_logarithm || ratio > 1.5 || ratio < 1 / 1.5)
    return "one combination";
  return change_a * change_b < 0 ? "their product" : "their ratio";
}

std::string sentence(const std::vector<UnknownName>& names, const WeakCombination& weak,
                     double deviation) {
  const std::vector<Index> members = members_of(weak);
  // Either way along the combination is as good: the first grows.
  const double along = weak.direction[members[0]] < 0 ? -deviation : deviation;
  std::vector<std::string> changes;
  changes.reserve(members.size());
  for (const Index k : members)
    changes.push_back(fmt::format("{} {}", at(names, k).phrase,
                                  change_text(at(names, k), along * weak.direction[k])));
  const std::string known = members.size() == 2
                                ? known_of(at(names, members[0]), at(names, members[1]),
                                           weak.direction[members[0]], weak.direction[members[1]])
                                : "fewer combinations than there are";
  return fmt::format(
      "Of {} these data know well only {}: {} together is within one standard deviation "
      "(condition index {:.3g}).",
      fmt::join(phrases(names, members), " and "), known, fmt::join(changes, " with "),
      weak.condition_index);
}

}  // namespace

std::vector<Index> made_up_by_those_before(const Eigen::MatrixXd& columns,
                                           const Eigen::VectorXd& least) {
  std::vector<Index> made_up;
  Eigen::MatrixXd known(columns.rows(), 0);
  for (Index k = 0; k < columns.cols(); ++k) {
    Eigen::VectorXd left = columns.col(k);
    for (int twice = 0; twice < 2; ++twice) left -= known * (known.transpose() * left);
    if (left.norm() > least[k]) {
      known.conservativeResize(Eigen::NoChange, known.cols() + 1);
      known.rightCols<1>() = left.normalized();
    } else {
      made_up.push_back(k);
    }
  }
  return made_up;
}

void require_identifiable(const std::vector<UnknownName>& names, const Eigen::MatrixXd& jacobian,
                          const std::vector<Index>& free, double scale) {
  if (free.empty()) return;
  require_sensitivity(names, jacobian, free, scale);
  const std::vector<WeakCombination> weak =
      weak_combinations(jacobian, free, 1 / sensitivity_rounding);
  if (weak.empty()) return;
  throw common::NotIdentifiable(
      fmt::format("these data do not distinguish {}: they change all readings in the same "
                  "proportion. Measure other poses, loads or components, or declare fewer of them "
                  "uncertain.",
                  fmt::join(phrases(names, members_of(weak.front())), " and ")));
}

std::vector<std::string> weak_sentences(const std::vector<UnknownName>& names,
                                        const std::vector<WeakCombination>& weak,
                                        double deviation) {
  std::vector<std::string> result;
  for (const WeakCombination& combination : weak)
    if (members_of(combination).size() > 1)
      result.push_back(sentence(names, combination, deviation));
  return result;
}

}  // namespace kinetostat::calibration
