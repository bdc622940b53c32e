#include "kinetostat/calibration/regression/instrument_lag.h"

#include <cmath>
#include <utility>

#include "kinetostat/calibration/campaign/load_history.h"

namespace kinetostat::calibration {
namespace {

using Eigen::Index;
using Eigen::RowVectorXd;

// A number with its derivatives by all parameters; no columns where these are not asked for.
struct Number {
  double value = 0;
  RowVectorXd by;
};

// One component along a history.
class Follower {
 public:
  // `column`: of the effect's value among the parameters.
  Follower(const vjm::EffectKind& kind, double value, std::optional<Index> column)
      : kind_(kind), value_(value), column_(column) {}

  // From a number as it is; no reading counts as moved from there.
  void start_at(const Number& there) { there_ = there; }

  // Changes a number from what there is to what is shown. Returns how much of a small motion is.
  double show(Number& number) {
    if (state_.by.size() != number.by.size()) state_.by.setZero(number.by.size());
    if (there_.by.size() != number.by.size()) there_.by.setZero(number.by.size());
    const vjm::Lag lag = kind_.lag(number.value - there_.value, state_.value, value_);
    const RowVectorXd moved = number.by - there_.by;
    there_ = number;
    number.value += lag.shown;
    number.by += lag.shown_by_moved * moved + lag.shown_by_state * state_.by;
    state_.by = lag.state_by_moved * moved + (lag.state_by_state * state_.by).eval();
    state_.value = lag.state;
    if (column_ && number.by.size() > 0) {
      number.by[*column_] += lag.shown_by_value;
      state_.by[*column_] += lag.state_by_value;
    }
    return 1 + lag.shown_by_moved;
  }

 private:
  const vjm::EffectKind& kind_;
  double value_;
  std::optional<Index> column_;
  Number there_, state_;
};

void follow(const Campaign& campaign, const Cycle& history, Index component, Follower follower,
            Predictions& predictions) {
  bool is_first = campaign.displacement == DisplacementKind::absolute;
  for (const std::size_t r : history) {
    double& predicted = predictions.displacement[r][component];
    if (std::isnan(predicted)) continue;
    const bool has_derivatives =
        !predictions.derivatives.empty() && predictions.derivatives[r].rows() > component;
    Number number{predicted, {}};
    if (has_derivatives) number.by = predictions.derivatives[r].row(component);
    if (std::exchange(is_first, false)) follower.start_at(number);
    const double slope = follower.show(number);
    predicted = number.value;
    if (has_derivatives) predictions.derivatives[r].row(component) = number.by;
    if (!predictions.by_wrench.empty()) predictions.by_wrench[r].row(component) *= slope;
  }
}

}  // namespace

std::optional<Index> column_of(const std::vector<vjm::ModelParameter>& parameters,
                               std::size_t effect, Index value) {
  for (std::size_t p = 0; p < parameters.size(); ++p)
    if (parameters[p].springs.empty() && parameters[p].effect == effect &&
        parameters[p].value == value)
      return static_cast<Index>(p);
  return std::nullopt;
}

bool may_lag(const Campaign& campaign, Index component) {
  const SensorKind kind = campaign.sensors[campaign.component(component).sensor].kind;
  const bool is_set = campaign.control && campaign.control->set == component;
  return !is_set && (kind == SensorKind::pose || kind == SensorKind::distance);
}

void add_lag(const Campaign& campaign, const std::vector<vjm::Effect>& effects,
             const std::vector<vjm::ModelParameter>& parameters, Predictions& predictions) {
  const std::vector<Cycle> histories = histories_of(campaign);
  for (std::size_t e = 0; e < effects.size(); ++e) {
    if (!effects[e].kind->lags_behind) continue;
    for (Index k = 0; k < campaign.size(); ++k) {
      const Index axis = campaign.component(k).axis;
      if (!may_lag(campaign, k)) continue;
      const Follower start(*effects[e].kind, effects[e].values[axis],
                           column_of(parameters, e, axis));
      for (const Cycle& history : histories) follow(campaign, history, k, start, predictions);
    }
  }
}

}  // namespace kinetostat::calibration
