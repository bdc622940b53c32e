#include "kinetostat/report/manipulators/imported_robot.h"

#include "kinetostat/io/text_file.h"
#include "kinetostat/report/text/text.h"

namespace kinetostat::report {

std::string text(const vjm::ImportedRobot& robot) {
  Table table({"where", "what"});
  for (const vjm::MissingStiffness& item : robot.missing) table.add_row({item.key, item.what});
  return "URDF knows no stiffness. Missing in the robot file:\n" + table.text();
}

io::Json to_json(const vjm::UrdfModel& model, const vjm::UrdfChain& chain,
                 const vjm::ImportedRobot& robot) {
  io::Json missing = io::Json::array();
  for (const vjm::MissingStiffness& item : robot.missing)
    missing.push_back({{"where", item.key}, {"what", item.what}});
  return {{"inputs",
           {{"urdf", model.file.string()}, {"sha256", io::sha256(io::read_text(model.file))}}},
          {"base", chain.base},
          {"tip", chain.tip},
          {"robot_file", robot.text},
          {"missing", missing}};
}

}  // namespace kinetostat::report
