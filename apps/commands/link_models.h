// The links of a robot as one beam, as a chain of beams and by finite elements, side by side.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "kinetostat/apps/cli/command.h"
#include "kinetostat/apps/cli/option_list.h"
#include "kinetostat/report/screen/link_models.h"
#include "kinetostat/vjm/io/robot_file.h"
#include "kinetostat/vjm/manipulator/posture.h"

namespace kinetostat::apps {

/// --links beam,fea
void add_links_option(OptionList& app, std::vector<std::string>& links);

/// Links of the robot file that name the link file they come from (`link_file`). "beam": as one
/// beam and as a chain of four; "fea": by finite elements, to which the others are compared; all of
/// them from the mesh, and kept in the user's cache.
class LinkModels {
 public:
  /// Writes one link result for each link and model into `folder`. Throws UsageError for other
  /// words than these, common::InputError where no link names its link file, and what
  /// identification and sections throw.
  LinkModels(const std::filesystem::path& robot, const std::vector<std::string>& words,
             std::filesystem::path folder, Run& run);

  static bool are_in(const std::filesystem::path& robot);

  const std::vector<std::string>& names() const { return names_; }  // "1 beam", "4 beams", "FEA"
  /// The robot with all its links by a model.
  vjm::Robot robot(std::size_t model) const;
  /// What `value` is of the robot with each model, and with a model in one link only while the
  /// others have the last.
  std::vector<report::LinkModelRow> compare(
      const std::function<double(const vjm::Robot&)>& value) const;

 private:
  struct Link {
    std::string name, compliance;     // as written
    int line = 0;                     // of `compliance`
    std::filesystem::path link_file;  // that it was identified from
  };
  static std::vector<Link> links_of(const std::filesystem::path& robot);
  vjm::Robot with(const std::vector<std::size_t>& model_of_link) const;
  std::filesystem::path file_of(const Link& link, std::size_t model) const;

  std::filesystem::path robot_, folder_;
  std::vector<Link> links_;
  std::vector<std::string> names_;
};

/// Of the unloaded platform, force over displacement along a unit vector [N/m]. Throws
/// common::NoConvergence where something yields freely.
double stiffness_along(const vjm::Robot& robot, const vjm::Posture& posture,
                       const spatial::Vector3& direction);

/// A folder that goes with its owner.
class ScratchFolder {
 public:
  /// Throws common::InputError where none can be made.
  ScratchFolder();
  ~ScratchFolder();
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace kinetostat::apps
