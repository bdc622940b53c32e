#include "kinetostat/report/screen/uncertainty.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "kinetostat/report/screen/wording.h"
#include "kinetostat/report/text/text.h"

namespace kinetostat::report {
namespace {

constexpr std::size_t most_sources = 6;

struct SourceShare {
  const vjm::UncertaintySource* source;
  double share;
};

// The largest first; what is less than half a percent is left out.
std::vector<SourceShare> largest_shares(const vjm::Propagation& first,
                                        const Eigen::VectorXd& shares) {
  constexpr double worth_a_row = 0.005;
  std::vector<SourceShare> largest;
  for (Eigen::Index i = 0; i < shares.size(); ++i)
    if (std::abs(shares[i]) >= worth_a_row)
      largest.push_back({&first.sources[static_cast<std::size_t>(i)], shares[i]});
  std::stable_sort(largest.begin(), largest.end(),
                   [](const SourceShare& a, const SourceShare& b) { return a.share > b.share; });
  return largest;
}

double relative(const vjm::Propagation& first, Eigen::Index number) {
  return first.expanded(number) / std::abs(first.estimate[number]);
}

std::string in_words(const ShownNumber& shown, double value) {
  return figure((shown.one_over ? 1 / value : value) * shown.factor, 4);
}

std::string interval(const ShownNumber& shown, double a, double b) {
  if (shown.one_over) std::swap(a, b);
  return fmt::format("{} to {} {}", in_words(shown, a), in_words(shown, b), shown.unit);
}

// "stiffness of q3 (+- 5 %)": one standard uncertainty where that is a share of something.
std::string named(const vjm::UncertaintySource& source) {
  const bool is_relative = source.kind != vjm::SourceKind::mesh &&
                           source.kind != vjm::SourceKind::clamping && source.estimate != 0;
  return is_relative ? fmt::format("{}, known to {} (1 sd)", source.name,
                                   percent(source.deviation / std::abs(source.estimate)))
                     : source.name;
}

std::string draws_line(const vjm::Draws& draws, Eigen::Index number, const ShownNumber& shown) {
  std::string text =
      fmt::format("  95 % of {} draws (seed {})  {}\n", draws.count, draws.seed,
                  interval(shown, draws.quantile(number, 0.025), draws.quantile(number, 0.975)));
  if (draws.failed() > 0)
    text += fmt::format("  without an equilibrium, or impossible  {} draws\n", draws.failed());
  return text;
}

// "62 % is stiffness of q3 and 30 % E of steel". Shares of sources that make up for each other are
// no parts of a whole: then only the names.
std::string blamed(const vjm::Propagation& first, const Eigen::VectorXd& shares) {
  constexpr double worth_a_word = 0.1;
  constexpr std::size_t most_words = 3;
  const bool is_whole = shares.minCoeff() > -0.5 * worth_a_word;
  std::vector<std::string> words;
  for (const SourceShare& s : largest_shares(first, shares)) {
    if (words.size() == most_words || s.share < worth_a_word) break;
    words.push_back(!is_whole ? s.source->name
                              : fmt::format("{} {}{}", short_percent(std::min(s.share, 1.0)),
                                            words.empty() ? "is " : "", s.source->name));
  }
  if (words.empty() || is_whole) return listed(words, "and");
  return "most is " + listed(words, "and") + ", which partly make up for others";
}

}  // namespace

std::string spread_in_words(const vjm::Uncertainty& uncertainty, Eigen::Index number) {
  const double spread = relative(uncertainty.first_order, number);
  return uncertainty.first_order.is_uncertain(number) && std::isfinite(spread)
             ? " +- " + percent(spread)
             : "";
}

std::string blame_sentence(const vjm::Uncertainty& uncertainty, Eigen::Index number) {
  const vjm::Propagation& first = uncertainty.first_order;
  const std::string words = blamed(first, first.shares(number));
  return words.empty() ? "" : " Of its uncertainty, " + words + ".";
}

std::string range_sentence(const vjm::Uncertainty& uncertainty, Eigen::Index first,
                           Eigen::Index count) {
  const vjm::Propagation& p = uncertainty.first_order;
  double least = std::numeric_limits<double>::infinity(), largest = 0;
  for (Eigen::Index k = first; k < first + count; ++k) {
    const double spread = relative(p, k);
    if (!p.is_uncertain(k) || !std::isfinite(spread)) continue;
    least = std::min(least, spread);
    largest = std::max(largest, spread);
  }
  if (!(largest > 0)) return {};
  const bool alike = percent(least) == percent(largest);
  return fmt::format("Known to +- {}{}. Of its uncertainty on average, {}.",
                     alike ? "" : percent(least) + " to ", percent(largest),
                     blamed(p, p.mean_shares(first, count)));
}

bool is_off_estimate(const vjm::Uncertainty& uncertainty, Eigen::Index number) {
  constexpr double noticed = 0.1;
  const vjm::Propagation& first = uncertainty.first_order;
  return first.is_uncertain(number) &&
         std::abs(first.estimate[number] - first.value[number]) > noticed * first.expanded(number);
}

std::string budget_text(const vjm::Uncertainty& uncertainty, Eigen::Index number,
                        const ShownNumber& shown) {
  const vjm::Propagation& first = uncertainty.first_order;
  if (!first.is_uncertain(number)) return {};
  std::string text =
      fmt::format("\n  {}  {} {}{} (k = 2)\n", shown.what, in_words(shown, first.estimate[number]),
                  shown.unit, spread_in_words(uncertainty, number));
  if (uncertainty.draws) text += draws_line(*uncertainty.draws, number, shown);
  const std::vector<SourceShare> shares = largest_shares(first, first.shares(number));
  for (std::size_t i = 0; i < std::min(shares.size(), most_sources); ++i)
    text += fmt::format("  {:<12} {:>7}  {}\n", shares[i].share > 0 ? bar(shares[i].share, 12) : "",
                        short_percent(shares[i].share), named(*shares[i].source));
  if (shares.size() > most_sources)
    text +=
        fmt::format("  {:<12} {:>7}  and {} more: --json\n", "", "", shares.size() - most_sources);
  return text;
}

}  // namespace kinetostat::report
