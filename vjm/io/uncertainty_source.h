// What is known of a robot with an uncertainty only: numbers of its file, links identified by
// finite elements.
#pragma once

#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace kinetostat::vjm {

/// How the values that are possible lie about the estimate. Log-normal: the logarithm is normal, so
/// that none is negative.
enum class Spread { normal, log_normal, rectangular };
/// What a source is an uncertainty of.
enum class SourceKind {
  joint,
  material,
  section,
  length,
  mass,
  element,
  mesh,
  clamping,
  fitted,
  effect
};
/// "joint", "material", ...
std::string to_string(SourceKind kind);

/// One quantity of which all that is stated is an estimate and a standard uncertainty. The sources
/// of a robot are independent of each other but for Robot::correlation; one that is used in several
/// places has the same value in all of them.
struct UncertaintySource {
  std::string name;   // for people: "stiffness of q1", "E of steel", "clamping of foot"
  std::string place;  // file and key; distinguishes sources of one robot
  SourceKind kind = SourceKind::joint;
  Spread spread = Spread::normal;
  double value = 0;      // that the robot of the file has [SI]
  double estimate = 0;   // mean of the spread [SI]: another one where only bounds are known
  double deviation = 0;  // standard uncertainty [SI], above zero
  /// Of a normal spread: values beyond these count as these.
  double lower = -std::numeric_limits<double>::infinity();
  double upper = std::numeric_limits<double>::infinity();

  /// The value below which the share `p`, in (0, 1), of all possible ones lies.
  double quantile(double p) const;
};

/// Meets every uncertain number of a robot file and of what it names, in the order in which they
/// are read: lists them, or puts other values in their place.
class SourceList {
 public:
  SourceList() = default;
  /// `values`: one a source, in the order of `known`.
  SourceList(std::vector<UncertaintySource> known, Eigen::VectorXd values);

  /// The value to go on with in the place of the file's; none while the sources are being listed.
  std::optional<double> meet(const UncertaintySource& source);
  const std::vector<UncertaintySource>& sources() const { return sources_; }

 private:
  std::vector<UncertaintySource> sources_;
  std::map<std::string, std::size_t> numbers_;  // by place
  std::optional<Eigen::VectorXd> values_;
};

}  // namespace kinetostat::vjm
