// Robot files: YAML that people write, to a manipulator. The format is in
// docs/reference/robot-file.md.
#pragma once

#include <filesystem>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "kinetostat/spatial/units.h"
#include "kinetostat/vjm/effects/effect.h"
#include "kinetostat/vjm/effects/sensitivity.h"
#include "kinetostat/vjm/io/link_options.h"
#include "kinetostat/vjm/io/uncertainty_source.h"
#include "kinetostat/vjm/manipulator/manipulator.h"

namespace kinetostat::vjm {

/// A stiffness that its owner declares uncertain: the springs of one name, scaled together.
struct UncertainStiffness {
  std::string name;  // as written: "leg", or "x.rho"
  std::vector<SpringParameter> springs;
  /// Bounds of the factor on the stiffness (that `fitted:` has scaled already) that are physically
  /// possible, when stated.
  std::optional<std::pair<double, double>> between = {};
};

/// A factor on stiffnesses that measurements have shown: `fitted:` in the robot file. The springs
/// of the manipulator have it.
struct FittedStiffness {
  std::string name;  // as UncertainStiffness::name
  std::vector<SpringParameter> springs;
  double factor = 1;
  double deviation = std::numeric_limits<double>::quiet_NaN();  // NaN where not stated
};

/// The name that such a factor has as a source of uncertainty: "fitted stiffness of q1".
std::string fitted_source(const std::string& stiffness);

/// A value of an effect that its owner declares uncertain.
struct UncertainValue {
  std::size_t effect = 0;  // in Robot::effects
  Eigen::Index value = 0;
};

struct RobotText;

struct Robot {
  std::filesystem::path file;
  std::string name;
  spatial::UnitSystem units;
  Manipulator manipulator;  // with the effects
  std::vector<UncertainStiffness> uncertain;
  std::vector<std::filesystem::path> link_files;  // read for this robot, in order of first use
  bool has_beams = false;                         // links that LinkOptions can split further
  std::vector<Effect> effects = {};               // as in the file
  std::optional<Manipulator> bare = {};           // without the effects, if there are any
  std::vector<UncertainValue> uncertain_values = {};
  std::vector<FittedStiffness> fitted = {};     // as in the file
  EffectKinds own_kinds = {};                   // of the file, then those given to read it with
  std::vector<UncertaintySource> sources = {};  // of uncertainty, in the order of reading
  Eigen::MatrixXd correlation = {};             // of the sources, square
  std::shared_ptr<const RobotText> text = {};   // what it was read from
  std::string sha256 = {};                      // of that, where it may be in no file

  /// The catalogue, then its own.
  EffectKinds kinds() const;

  const Manipulator& without_effects() const { return bare ? *bare : manipulator; }
};

/// Throws common::InputError naming file, line, key, what was expected and the nearest thing that
/// would work.
Robot read_robot(const std::filesystem::path& file, const LinkOptions& options = {});
/// The same from the text that the file has, or will have.
Robot parse_robot(const std::string& text, const std::filesystem::path& file,
                  const LinkOptions& options = {});

/// The robot for other values of its sources, one each: of the same file, read again. Springs that
/// readings have determined (`fitted` with a standard deviation) stay but for these factors,
/// whatever the numbers that they were computed from; of several factors on one stiffness for the
/// last. Throws common::InputError where the values do
/// not go together, such as a tube of less outer than inner diameter.
Robot with_values(const Robot& robot, const Eigen::VectorXd& values);

/// The same manipulator with the springs of a parameter multiplied by `factor`.
Manipulator with_scaled(const Manipulator& manipulator, const UncertainStiffness& parameter,
                        double factor);

}  // namespace kinetostat::vjm
