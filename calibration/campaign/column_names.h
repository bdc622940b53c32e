// What the names in the header of a table of readings mean. Internal to this module.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "kinetostat/calibration/campaign/campaign.h"
#include "kinetostat/spatial/units.h"
#include "kinetostat/vjm/manipulator/manipulator.h"

namespace kinetostat::calibration {

/// A joint whose coordinate a reading may give.
struct Joint {
  std::string name;   // "chain.joint"
  std::string alone;  // "joint" where no other chain has one of that name, else the same
  bool actuated = false;
  spatial::Dimension dimension;

  /// Its column unless the campaign says otherwise.
  const std::string& column() const;
};
std::vector<Joint> joints_of(const vjm::Manipulator& manipulator);

/// "dx_dz": the correlation of two components, in the order of component_names.
std::string correlation_name(Eigen::Index i, Eigen::Index j);

/// Names that have a meaning for every robot: "id", "fx", "sigma_dx", "corr_dx_dy", ...
const std::vector<std::string>& reserved_names();
bool is_reserved(const std::string& name);
/// What a column of this name is given in; none for texts, counts and correlations.
spatial::Dimension dimension_of(const std::string& reserved_name);

/// "Fx [N]" -> "fx": a name without case, unit and blanks.
std::string bare_name(const std::string& column);

/// A cell of the header taken apart.
struct HeaderParts {
  std::string name;
  std::optional<std::string> unit;  // "[N]", "(N)", and after "/", "in" or a comma, where it is one
};
HeaderParts split_header(const std::string& header);

/// What `columns:` of a campaign file says of one column: "fx", "-dz [um]", "covariate".
struct StatedColumn {
  std::string meaning;  // empty: a covariate
  std::optional<std::string> unit;
  bool negative = false;
  int line = 0;  // of the campaign file
};
StatedColumn read_stated_column(std::string_view text);

/// How a column was understood.
struct NamedColumn {
  std::string meaning;  // a reserved name, or the whole name of a joint; empty: a covariate
  std::optional<std::string> unit;  // its own
  bool negative = false;            // counted the other way round
  bool as_written = true;           // the name itself, as the format has it
};

/// What a name means that is spelled in another way: "Fx [N]", "Kraft X [N]", "A1 [deg]"; a
/// covariate where it may mean anything else. Words other than the names of the format themselves
/// need a unit that goes with them.
NamedColumn understood(const std::string& header, const std::vector<Joint>& joints);

/// The actuated joint that a column without unit is called after by its number, "Achse 1"; null for
/// others.
const Joint* joint_like(const std::string& header, const std::vector<Joint>& joints);

/// Whether its unit is one of mass, or of force.
bool is_mass(const std::string& header);
bool is_force(const std::string& header);
/// What a campaign file may call a sensor or load of this column: "Payload_mass" of "Payload mass
/// [kg]".
std::string name_for_column(const std::string& header);

/// What a covariate may have been meant as, "fx" for "Kraft X", "rz [deg]" for "rz_deg", "rx" for
/// "tilt_x"; empty for nothing.
std::string looks_like(const std::string& header, const std::vector<Joint>& joints);

}  // namespace kinetostat::calibration
