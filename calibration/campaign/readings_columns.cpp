#include "kinetostat/calibration/campaign/readings_columns.h"

#include <algorithm>
#include <array>
#include <cctype>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "kinetostat/calibration/campaign/joint_column.h"
#include "kinetostat/common/error.h"
#include "kinetostat/common/spelling.h"

namespace kinetostat::calibration {
namespace {

using spatial::Dimension;
namespace dimension = spatial::dimension;

const std::vector<std::string>& reserved_names() {
  static const std::vector<std::string> names = {
      "id",        "session",  "cycle",     "step",        "time",     "temperature", "setting",
      "replicate", "x",        "y",         "z",           "roll",     "pitch",       "yaw",
      "fx",        "fy",       "fz",        "mx",          "my",       "mz",          "px",
      "py",        "pz",       "direction", "dx",          "dy",       "dz",          "rx",
      "ry",        "rz",       "sigma",     "sigma_dx",    "sigma_dy", "sigma_dz",    "sigma_rx",
      "sigma_ry",  "sigma_rz", "mask",      "mask_reason", "role",     "instrument"};
  static const std::vector<std::string> all = [] {
    std::vector<std::string> result = names;
    for (Eigen::Index i = 0; i < 6; ++i)
      for (Eigen::Index j = i + 1; j < 6; ++j) result.push_back("corr_" + correlation_name(i, j));
    return result;
  }();
  return all;
}

bool is_reserved(const std::string& name) {
  const auto& reserved = reserved_names();
  return std::find(reserved.begin(), reserved.end(), name) != reserved.end();
}

constexpr std::array pose_names = {"x", "y", "z", "roll", "pitch", "yaw"};

bool is_of_pose(const std::string& name) {
  return std::find(pose_names.begin(), pose_names.end(), name) != pose_names.end();
}

// "Fx [N]" -> "fx": what a column name comes down to when case, unit and blanks are taken off.
std::string bare_name(const std::string& column) {
  std::string bare;
  for (const char c : column.substr(0, column.find_first_of("[(")))
    if (c != ' ') bare += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return bare;
}

// A joint whose coordinate a reading may give.
struct Joint {
  std::string name;   // "chain.joint"
  std::string alone;  // "joint" where no other chain has one of that name, else the same
  bool actuated = false;
  Dimension dimension;

  // Its column unless the campaign says otherwise.
  const std::string& column() const { return is_reserved(alone) ? name : alone; }
};

std::vector<Joint> joints_of(const vjm::Manipulator& manipulator) {
  std::vector<Joint> joints;
  std::map<std::string, int> uses;
  for (const vjm::Chain& chain : manipulator.chains())
    for (const Eigen::Index k : chain.posture_coordinates()) {
      const vjm::Coordinate& joint = chain.coordinates()[static_cast<std::size_t>(k)];
      ++uses[joint.name];
      joints.push_back({chain.name() + "." + joint.name, joint.name,
                        joint.role == vjm::Role::actuated,
                        vjm::is_rotation(joint.motion) ? dimension::angle : dimension::length});
    }
  for (Joint& joint : joints)
    if (uses[joint.alone] > 1) joint.alone = joint.name;
  return joints;
}

class ColumnFinder {
 public:
  ColumnFinder(const io::CsvTable& table, const ReadingsContext& context,
               const vjm::Manipulator& manipulator, Campaign& campaign)
      : table_(table), context_(context), campaign_(campaign), joints_(joints_of(manipulator)) {}

  ReadingsColumns find() {
    for (const char* name : {"id", "session", "cycle", "step", "time", "temperature", "setting",
                             "replicate", "direction", "mask", "mask_reason", "role", "instrument"})
      found_.texts[name] = column(name);
    for (std::size_t i = 0; i < 6; ++i) {
      found_.displacement[i] = column(component_names[i]);
      found_.sigma[i] = column(std::string("sigma_") + component_names[i]);
      found_.wrench[i] = column(std::array{"fx", "fy", "fz", "mx", "my", "mz"}[i]);
    }
    found_.any_sigma = column("sigma");
    for (Eigen::Index i = 0; i < 6; ++i)
      for (Eigen::Index j = i + 1; j < 6; ++j)
        if (const Column c = column("corr_" + correlation_name(i, j)))
          found_.correlations.push_back({{i, j}, *c});
    found_.point = together("px", "py", "pz");
    if (context_.posture == PostureColumns::joints) {
      refuse_poses_without_joint();
    } else {
      found_.position = together("x", "y", "z");
      found_.orientation = together("roll", "pitch", "yaw");
    }
    find_joint_columns();
    if (context_.posture == PostureColumns::unstated) warn_of_drives_named_like_columns();
    check_unit_errors();
    check_columns();
    check_units();
    return std::move(found_);
  }

 private:
  Column column(const std::string& name) {
    const Column found = table_.find(name);
    if (found) found_.known.insert(*found);
    return found;
  }

  [[noreturn]] void fail_header(const std::string& column, const std::string& what,
                                const std::string& cure) const {
    if (const Column found = table_.find(column)) table_.fail_column(*found, what, cure);
    throw common::InputError({.file = table_.file(),
                              .line = table_.header_line(),
                              .key = column,
                              .what = what,
                              .cure = cure});
  }

  // Three columns that only have a meaning together.
  Columns3 together(const char* a, const char* b, const char* c) {
    const Columns3 columns = {column(a), column(b), column(c)};
    const std::string names[] = {a, b, c};
    const std::size_t missing = static_cast<std::size_t>(
        std::find(columns.begin(), columns.end(), std::nullopt) - columns.begin());
    if (missing < 3 && (columns[0] || columns[1] || columns[2]))
      fail_header(names[missing],
                  fmt::format("the column '{}' is missing: {}, {} and {} go together",
                              names[missing], a, b, c),
                  "Add it, with 0 in every row if need be" + hint_of_drives());
    return columns;
  }

  // The drives, without a column, that are named like a given one that `wanted` chooses.
  std::vector<const Joint*> drives_named_like(bool (*wanted)(const std::string&)) const {
    std::vector<const Joint*> result;
    for (const Joint& joint : joints_) {
      const std::string name = bare_name(joint.alone);
      if (joint.actuated && is_reserved(name) && wanted(name) && table_.find(name) &&
          !table_.find(joint.name))
        result.push_back(&joint);
    }
    return result;
  }

  // For columns of a pose that may be coordinates of drives.
  std::string hint_of_drives() const {
    const std::vector<const Joint*> drives = drives_named_like(is_of_pose);
    if (drives.empty()) return {};
    return fmt::format(
        "; where columns are coordinates of the drives of these names, say 'posture: joints' in "
        "the campaign file, or name them like {}",
        drives[0]->name);
  }

  void refuse_poses_without_joint() const {
    for (const char* name : pose_names)
      if (table_.find(name) &&
          std::none_of(joints_.begin(), joints_.end(),
                       [&](const Joint& joint) { return joint.alone == name; }))
        fail_header(
            name,
            fmt::format("the campaign says 'posture: joints', and no joint is named '{}'", name),
            "Write 'posture: platform', or name the column otherwise to keep it as a "
            "covariate");
  }

  void warn_of_drives_named_like_columns() {
    const auto warn = [this](std::string sentence) {
      campaign_.notes.push_back(sentence);
      campaign_.warnings.push_back(std::move(sentence));
    };
    std::vector<std::string> columns, whole;
    for (const Joint* joint : drives_named_like(is_of_pose)) {
      columns.push_back(bare_name(joint->alone));
      whole.push_back(joint->name);
    }
    if (!columns.empty())
      warn(fmt::format(
          "Read as the platform's pose: {}; but drives have these names. If the pose is meant, say "
          "'posture: platform' in the campaign file; if coordinates of the drives are, say "
          "'posture: joints', or name the columns {}.",
          fmt::join(columns, ", "), fmt::join(whole, ", ")));
    if (found_.position[0] || !found_.joints.empty()) return;
    for (const Joint* joint :
         drives_named_like([](const std::string& name) { return !is_of_pose(name); }))
      warn(
          fmt::format("The column '{}' is not taken as the coordinate of the drive of this name, "
                      "which would stand in a column '{}'.",
                      bare_name(joint->alone), joint->name));
  }

  void find_joint_columns() {
    std::vector<std::string> missing;
    for (const Joint& joint : joints_) {
      Column found = column(joint.name);
      const bool said = context_.posture == PostureColumns::joints && is_of_pose(joint.alone);
      if (!found && (said || !is_reserved(joint.alone))) found = column(joint.alone);
      if (found) {
        found_.joints.push_back({*found, joint.name, joint.dimension});
        campaign_.joint_columns[joint.name] = {table_.columns()[*found],
                                               joint.dimension == dimension::angle};
      }
      if (!found && joint.actuated) missing.push_back(said ? joint.alone : joint.column());
    }
    if (!found_.joints.empty() && !missing.empty()) {
      const std::string near = unknown_column_like(missing[0]);
      fail_header(missing[0],
                  fmt::format("the actuated joint '{}' has no column, but others have", missing[0]),
                  near.empty()
                      ? "Add its column, with the coordinate at which it stood in every row"
                      : fmt::format("Rename the column '{}' if that is it", near));
    }
    if (!found_.joints.empty() && found_.position[0])
      fail_header("x", "the posture is given twice: by x, y, z and by joint coordinates",
                  "Keep one; rename the other columns to keep them as covariates");
    if (found_.orientation[0] && !found_.position[0])
      fail_header("x", "roll, pitch, yaw need a position as well", "Add the columns x, y, z");
  }

  // The first column without a meaning whose name may be this one mistyped; empty for none.
  std::string unknown_column_like(const std::string& name) const {
    for (std::size_t i = 0; i < table_.columns().size(); ++i)
      if (found_.known.count(i) == 0 &&
          !common::nearest_spelling(table_.columns()[i], {name}).empty())
        return table_.columns()[i];
    return {};
  }

  // "Fx" or "fx [N]" beside "fx" is surely mistyped; a near spelling may be.
  void check_unit_errors() {
    std::vector<std::string> names = reserved_names();
    for (const Joint& joint : joints_) names.insert(names.end(), {joint.name, joint.alone});
    for (std::size_t i = 0; i < table_.columns().size(); ++i) {
      const std::string& name = table_.columns()[i];
      if (found_.known.count(i) > 0) continue;
      const auto same = std::find_if(names.begin(), names.end(), [&](const std::string& known) {
        return bare_name(name) == bare_name(known);
      });
      if (same != names.end())
        fail_header(name, fmt::format("the column '{}' is not known", name),
                    fmt::format("Write '{}'; units belong in the campaign file", *same));
      const std::string near = common::nearest_spelling(name, names);
      if (!near.empty())
        campaign_.notes.push_back(fmt::format(
            "The column '{}' is kept as a covariate; if '{}' was meant, rename it.", name, near));
    }
  }

  void check_columns() {
    const auto any = [](const auto& columns) {
      return std::any_of(columns.begin(), columns.end(), [](const Column& c) { return c; });
    };
    if (!any(found_.displacement))
      fail_header("", "there is no column of displacement",
                  "Name at least one of dx, dy, dz, rx, ry, rz");
    if (!any(found_.wrench) && campaign_.displacement == DisplacementKind::difference)
      fail_header("", "there is no column of load, so no difference to the unloaded state",
                  "Name at least one of fx, fy, fz, mx, my, mz");
    const bool moments = found_.wrench[3] || found_.wrench[4] || found_.wrench[5];
    const bool point_given = found_.point[0] || context_.wrench.point || context_.wrench.origin;
    if (moments && !point_given)
      fail_header(found_.wrench[3]   ? "mx"
                  : found_.wrench[4] ? "my"
                                     : "mz",
                  "moments are given without the point that they are taken about",
                  "Add the columns px, py, pz, or 'wrench_point: reference' or 'wrench_point: "
                  "[x, y, z]' to the campaign file, or name a 'wrench_frame' with its origin");
    if (!moments && !point_given && any(found_.wrench))
      campaign_.notes.push_back(
          "No point of application is given: forces act at the platform's reference point.");
    if (found_.any_sigma && !found_.displacement[0] && !found_.displacement[1] &&
        !found_.displacement[2])
      fail_header("sigma", "'sigma' is the deviation of translations, and none is measured",
                  "Write sigma_rx, sigma_ry, sigma_rz");
    if (!found_.position[0] && found_.joints.empty())
      campaign_.notes.push_back(
          "No column states the posture: the robot stands at its home coordinates.");
  }

  void check_units() {
    Column angle;
    for (const Column& c : {found_.displacement[3], found_.displacement[4], found_.displacement[5],
                            found_.orientation[0]})
      if (c && !angle) angle = c;
    for (const JointColumn& c : found_.joints)
      if (c.dimension == dimension::angle && !angle) angle = c.column;
    const auto require = [this](const Column& column, bool stated, const char* key,
                                const char* example) {
      if (!column || stated) return;
      throw common::InputError(
          {.file = campaign_.file,
           .line = context_.units_line,
           .key = fmt::format("units.{}", key),
           .what = fmt::format("no unit of {} is stated, but the readings have the column '{}'",
                               key, table_.columns()[*column]),
           .cure = fmt::format("Write '{}: {}' under 'units'", key, example)});
    };
    require(angle, context_.angle_stated, "angle", "deg");
    require(found_.texts["time"], context_.time_stated, "time", "s");
  }

  const io::CsvTable& table_;
  const ReadingsContext& context_;
  Campaign& campaign_;
  std::vector<Joint> joints_;
  ReadingsColumns found_;
};

}  // namespace

std::string joint_column(const vjm::Manipulator& manipulator, const std::string& name) {
  for (const Joint& joint : joints_of(manipulator))
    if (joint.name == name) return joint.column();
  return name;
}

ReadingsColumns find_columns(const io::CsvTable& table, const ReadingsContext& context,
                             const vjm::Manipulator& manipulator, Campaign& campaign) {
  return ColumnFinder(table, context, manipulator, campaign).find();
}

}  // namespace kinetostat::calibration
