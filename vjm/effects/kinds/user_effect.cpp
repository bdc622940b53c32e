#include "kinetostat/vjm/effects/kinds/user_effect.h"

#include <array>
#include <cmath>

#include <fmt/format.h>

#include "kinetostat/vjm/chain/chain_modifier.h"
#include "kinetostat/vjm/effects/kinds/kinds.h"

namespace kinetostat::vjm::effects {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

// Where the coordinates of a joint stand among the variables; -1: not there.
struct Coordinates {
  Index position = -1, deflection = -1, command = -1;

  explicit Coordinates(UserLaw law) {
    if (law == UserLaw::force) position = 0, deflection = 1, command = 2;
    if (law == UserLaw::offset) command = 0;
  }
  Index count() const { return position == 0 ? 3 : command == 0 ? 1 : 0; }
};

const std::array<const char*, 6> loads = {"fx", "fy", "fz", "mx", "my", "mz"};

// A force beside the drive of a joint.
class LawForce : public CoordinateLaw {
 public:
  LawForce(std::shared_ptr<const SmoothFunction> function, VectorXd variables)
      : function_(std::move(function)), variables_(std::move(variables)) {}

  Value at(const JointState& joint) const override {
    VectorXd v = variables_;
    set(joint, joint.deflection, v);
    const auto by_position = function_->derivative(v, 0);
    return {.force = by_position.value,
            .tangent = by_position.slope + function_->derivative(v, 1).slope};
  }
  // Work from rest, by Gauss' rule with four points.
  double energy(const JointState& joint) const override {
    constexpr double points[] = {0.0694318442029737, 0.3300094782075719};
    constexpr double weights[] = {0.1739274225687269, 0.3260725774312731};
    VectorXd v = variables_;
    double sum = 0;
    for (int i = 0; i < 2; ++i)
      for (const double s : {points[i], 1 - points[i]}) {
        set(joint, s * joint.deflection, v);
        sum += weights[i] * function_->value(v);
      }
    return sum * joint.deflection;
  }
  bool is_beside_drive() const override { return true; }

 private:
  static void set(const JointState& joint, double deflection, VectorXd& v) {
    v[0] = joint.position - joint.deflection + deflection;
    v[1] = deflection;
    v[2] = joint.position - joint.travel;
  }

  std::shared_ptr<const SmoothFunction> function_;
  VectorXd variables_;
};

// A drive that leads its joint elsewhere: k (d - e) in the place of k d.
class LawOffset : public CoordinateLaw {
 public:
  LawOffset(std::shared_ptr<const SmoothFunction> function, VectorXd variables)
      : function_(std::move(function)), variables_(std::move(variables)) {}

  Value at(const JointState& joint) const override {
    const double offset = this->offset(joint);
    return {.force = -joint.stiffness * offset, .tangent = 0, .force_by_stiffness = -offset};
  }
  double energy(const JointState& joint) const override {
    const double offset = this->offset(joint);
    return joint.stiffness * offset * (offset / 2 - joint.deflection);
  }

 private:
  double offset(const JointState& joint) const {
    VectorXd v = variables_;
    v[0] = joint.position - joint.travel;
    return function_->value(v);
  }

  std::shared_ptr<const SmoothFunction> function_;
  VectorXd variables_;
};

class UserEffect : public EffectKind {
 public:
  UserEffect(UserLaw law_of, std::shared_ptr<const SmoothFunction> function,
             std::vector<std::string> covariates, std::vector<EffectParameter> described)
      : law_(law_of), covariates_(std::move(covariates)), function_(std::move(function)) {
    parameters = std::move(described);
    place = EffectPlace::joint;
    by_stated_load = true;
    first_ = Coordinates(law_).count();
    for (Index i = first_; i < first_parameter(); ++i) varies = varies || function_->uses(i);
  }

  void act(ChainModifier& modifier, const std::string& joint,
           const EffectInput& input) const override {
    const VectorXd v = variables(input);
    if (law_ == UserLaw::force) {
      require_mobile(modifier.chain(), joint);
      modifier.add_law(joint, std::make_shared<LawForce>(function_, v));
      return;
    }
    const Spring& spring = spring_of_joint(modifier.chain(), joint);
    if (law_ == UserLaw::offset) {
      modifier.add_law(joint, std::make_shared<LawOffset>(function_, v));
      return;
    }
    const double compliance = function_->value(v);
    if (!(1 + spring.stiffness(0, 0) * compliance > 1e-6) || !std::isfinite(compliance))
      throw std::invalid_argument(
          fmt::format("the compliance of '{}' at joint '{}' is {:.4g}: no stiffness is left", name,
                      joint, compliance));
    modifier.add_series_compliance(joint, compliance);
  }

  void differentiate(ChainColumns& columns, const std::string& joint,
                     const EffectInput& input) const override {
    const ChainState& state = columns.state();
    const Index k = state.chain.index_of(joint);
    const Coordinates at(law_);
    VectorXd v = variables(input);
    if (at.position >= 0) v[at.position] = state.x[k];
    if (at.deflection >= 0) v[at.deflection] = state.deflection[k];
    if (at.command >= 0) v[at.command] = state.x[k] - state.travel[k];
    for (Index p = 0; p < input.values.size(); ++p) {
      const double slope = function_->derivative(v, first_parameter() + p).slope;
      if (law_ == UserLaw::force) columns.add_force(p, k, -slope);
      if (law_ == UserLaw::offset)
        columns.add_drive_force(p, k, slope * state.chain.stiffness()(k, k));
      if (law_ == UserLaw::compliance) add_series_compliance(columns, p, k, slope);
    }
  }

 private:
  Index first_parameter() const { return first_ + 8 + static_cast<Index>(covariates_.size()); }

  VectorXd variables(const EffectInput& input) const {
    VectorXd v = VectorXd::Zero(first_parameter() + input.values.size());
    v[first_] = input.conditions.time;
    v[first_ + 1] = input.conditions.temperature.value_or(20);
    const auto number = [&input](const std::string& column) {
      const auto found = input.conditions.covariates.find(column);
      return found == input.conditions.covariates.end() ? 0 : found->second;
    };
    for (std::size_t i = 0; i < loads.size(); ++i)
      v[first_ + 2 + static_cast<Index>(i)] = number(loads[i]);
    for (std::size_t i = 0; i < covariates_.size(); ++i)
      v[first_ + 8 + static_cast<Index>(i)] = number(covariates_[i]);
    v.tail(input.values.size()) = input.values;
    return v;
  }

  UserLaw law_;
  std::vector<std::string> covariates_;
  std::shared_ptr<const SmoothFunction> function_;
  Index first_ = 0;  // of time, behind the coordinates
};

}  // namespace

std::vector<std::string> user_variables(UserLaw law, const std::vector<std::string>& covariates,
                                        const std::vector<EffectParameter>& parameters) {
  std::vector<std::string> names;
  if (law == UserLaw::force) names = {"x", "d", "u"};
  if (law == UserLaw::offset) names = {"u"};
  names.insert(names.end(), {"t", "T"});
  names.insert(names.end(), loads.begin(), loads.end());
  names.insert(names.end(), covariates.begin(), covariates.end());
  for (const EffectParameter& parameter : parameters) names.push_back(parameter.name);
  return names;
}

namespace {

Index count_variables(UserLaw law, std::size_t covariates, std::size_t parameters) {
  return Coordinates(law).count() + 8 + static_cast<Index>(covariates + parameters);
}

// At 20 degrees, with the parameters given.
VectorXd at_rest(UserLaw law, Index count, const VectorXd& parameters) {
  VectorXd v = VectorXd::Zero(count);
  v[Coordinates(law).count() + 1] = 20;
  v.tail(parameters.size()) = parameters;
  return v;
}

bool depends_on_something(const SmoothFunction& function, Index count) {
  for (Index i = 0; i < count; ++i)
    if (function.uses(i)) return true;
  return false;
}

bool is_finite(const SmoothFunction& function, const VectorXd& v) {
  for (Index i = 0; i < v.size(); ++i) {
    if (!function.uses(i)) continue;
    const SmoothFunction::Dual at = function.derivative(v, i);
    if (!std::isfinite(at.value) || !std::isfinite(at.slope)) return false;
  }
  return true;
}

}  // namespace

std::shared_ptr<EffectKind> user_effect(UserLaw law, const std::string& formula,
                                        const std::vector<std::string>& covariates,
                                        std::vector<EffectParameter> parameters,
                                        const VectorXd& typical) {
  const auto expression =
      std::make_shared<const Expression>(formula, user_variables(law, covariates, parameters));
  const Index count = count_variables(law, covariates.size(), parameters.size());
  if (!depends_on_something(*expression, count))
    throw ExpressionError(
        "the formula depends on nothing: it is a mere number, without a parameter", 1);
  if (const int column = expression->first_not_finite(at_rest(law, count, typical)); column > 0)
    throw ExpressionError("the formula is not finite for a joint at rest, or its derivative is not",
                          column);
  auto kind = std::make_shared<UserEffect>(law, expression, covariates, std::move(parameters));
  kind->law = formula;
  kind->source = "the robot file";
  return kind;
}

std::shared_ptr<EffectKind> user_effect(UserLaw law, std::shared_ptr<const SmoothFunction> function,
                                        const std::vector<std::string>& covariates,
                                        std::vector<EffectParameter> parameters,
                                        const VectorXd& typical) {
  const Index count = count_variables(law, covariates.size(), parameters.size());
  if (!depends_on_something(*function, count))
    throw std::invalid_argument("the function depends on nothing: it is a mere number");
  if (!is_finite(*function, at_rest(law, count, typical)))
    throw std::invalid_argument(
        "the function is not finite for a joint at rest, or its derivative is not");
  return std::make_shared<UserEffect>(law, std::move(function), covariates, std::move(parameters));
}

}  // namespace kinetostat::vjm::effects
