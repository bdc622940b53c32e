// Effects as people write them. The format is in docs/reference/robot-file.md.
#pragma once

#include "kinetostat/io/yaml.h"
#include "kinetostat/vjm/effects/effect.h"

namespace kinetostat::vjm {

/// Reads `effect_kinds: {NAME: {force: FORMULA, parameters: {...}}}` from the top of a robot file.
/// `given`: kinds that stand beside them, at the end of what is returned. Throws common::InputError
/// for what the catalogue or another kind is called and for formulas that do not do.
EffectKinds read_effect_kinds(const io::YamlNode& top, const EffectKinds& given = {});

/// Reads `{a: {unit: N, between: [0, 100], prior: 10, none: 0}}`, the parameters of one kind: the
/// first is its size, the others say how it acts.
std::vector<EffectParameter> read_effect_parameters(const io::YamlNode& node);
/// What such parameters usually are: `none` and a prior standard deviation more [SI].
Eigen::VectorXd usual_values(const std::vector<EffectParameter>& parameters);

/// Reads `effects: [{effect: hardening, at: x.rho, k3: {value: 1e12 N/m^3, sd: 1e11 N/m^3}}]` from
/// the top of a robot file. Every effect has been tried on the manipulator. Throws
/// common::InputError for unknown kinds, places and keys, and values outside their physical range.
std::vector<Effect> read_effects(const io::YamlNode& top, const EffectKinds& kinds,
                                 const Manipulator& manipulator, const spatial::UnitSystem& units);

/// Reads another value for one parameter of an effect, a quantity or `{value, sd}`. Throws
/// common::InputError for one outside its physical range.
void read_effect_value(const io::YamlNode& node, const spatial::UnitSystem& units,
                       const Manipulator& manipulator, Eigen::Index parameter, Effect& effect);

/// An effect as words of a command line have it: `size` is the value of the first parameter with
/// its unit, or "force=50 N,presliding=10 um". Throws common::InputError, or std::invalid_argument
/// for an unknown kind.
Effect effect_from_words(const std::string& kind, const std::string& at, const std::string& size,
                         const EffectKinds& kinds, const Manipulator& manipulator,
                         const spatial::UnitSystem& units);

}  // namespace kinetostat::vjm
