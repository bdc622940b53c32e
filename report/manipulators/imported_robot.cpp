#include "kinetostat/report/manipulators/imported_robot.h"

#include "kinetostat/io/text_file.h"
#include "kinetostat/report/text/text.h"

namespace kinetostat::report {

std::string text(const vjm::RobotDescription& model, const vjm::ImportedRobot& robot) {
  Table table({"where", "what"});
  for (const vjm::MissingStiffness& item : robot.missing) table.add_row({item.key, item.what});
  std::string remarks;
  for (const std::string& remark : model.remarks) remarks += remark + "\n";
  if (!robot.left_out.empty()) remarks += vjm::in_words(robot.left_out) + "\n";
  if (robot.missing.empty()) return remarks + "Nothing is missing in the robot file.\n";
  return remarks + "Missing in the robot file, for " + model.format + " does not say it:\n" +
         table.text();
}

io::Json to_json(const vjm::RobotDescription& model, const vjm::DescribedChain& chain,
                 const vjm::ImportedRobot& robot) {
  io::Json missing = io::Json::array();
  for (const vjm::MissingStiffness& item : robot.missing)
    missing.push_back({{"where", item.key}, {"what", item.what}});
  io::Json left_out = io::Json::array();
  for (const vjm::LeftOutLink& link : robot.left_out)
    left_out.push_back({{"link", link.name}, {"mass", link.mass}});
  return {{"inputs",
           {{"file", model.file.string()},
            {"format", model.format},
            {"sha256", io::sha256(io::read_text(model.file))}}},
          {"base", chain.base},
          {"tip", chain.tip},
          {"robot_file", robot.text},
          {"left_out", left_out},
          {"missing", missing}};
}

}  // namespace kinetostat::report
