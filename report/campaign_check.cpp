#include "kinetostat/report/campaign_check.h"

#include <fmt/format.h>

namespace kinetostat::report {
namespace {

using calibration::Observability;

std::string listed(const std::vector<Observability>& checks, bool observable) {
  std::string text;
  for (const Observability& item : checks)
    if (item.observable == observable) text += "  - " + item.sentence + "\n";
  return text;
}

}  // namespace

io::Json occasion_json(const calibration::Campaign& campaign) {
  io::Json json{{"name", campaign.name}};
  for (const auto& [key, text] : campaign.occasion.stated()) json[key] = text;
  return json;
}

std::string text(const calibration::Campaign& campaign, const std::vector<Observability>& checks) {
  std::string out =
      fmt::format("Campaign '{}': {} readings\n", campaign.name, campaign.readings.size());
  for (const std::string& note : campaign.notes) out += "  " + note + "\n";
  return out + "\nObservable\n" + listed(checks, true) + "\nNot observable\n" +
         listed(checks, false);
}

io::Json to_json(const calibration::Campaign& campaign, const std::vector<Observability>& checks,
                 const std::vector<calibration::JointLoad>& joints) {
  io::Json json{{"campaign", occasion_json(campaign)},
                {"readings", campaign.readings.size()},
                {"notes", campaign.notes},
                {"checks", io::Json::array()},
                {"joints", io::Json::array()}};
  for (const Observability& item : checks)
    json["checks"].push_back({{"topic", item.topic},
                              {"effect", item.effect},
                              {"observable", item.observable},
                              {"sentence", item.sentence},
                              {"cure", item.observable ? "" : item.cure}});
  for (const calibration::JointLoad& joint : joints)
    json["joints"].push_back({{"joint", joint.name},
                              {"least", joint.least},
                              {"largest", joint.largest},
                              {"unit", joint.turns ? "N m" : "N"},
                              {"postures", joint.postures},
                              {"loaded", joint.is_loaded()},
                              {"observable", joint.is_observable()}});
  return json;
}

}  // namespace kinetostat::report
