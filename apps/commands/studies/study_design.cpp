#include <cmath>

#include <fmt/format.h>

#include "kinetostat/apps/cli/robot_request.h"
#include "kinetostat/apps/commands/link_models.h"
#include "kinetostat/apps/commands/studies/study.h"
#include "kinetostat/common/error.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/report/manipulators/manipulator.h"
#include "kinetostat/report/manipulators/map.h"
#include "kinetostat/report/manipulators/skeleton.h"
#include "kinetostat/report/manipulators/uncertainty.h"
#include "kinetostat/report/page.h"
#include "kinetostat/report/screen/manipulator.h"
#include "kinetostat/report/screen/study.h"
#include "kinetostat/report/screen/wording.h"
#include "kinetostat/vjm/manipulator/posture.h"
#include "kinetostat/vjm/statics/assembly.h"
#include "kinetostat/vjm/uncertainty/stiffness_numbers.h"
#include "kinetostat/vjm/workspace/neighbourhood.h"

namespace kinetostat::apps {
namespace {

using report::Light;
using report::Station;

constexpr double cube = 0.1;              // how far poses about home go, over the reach
constexpr double most_deflection = 0.01;  // to which the critical force is sought, over the reach

class DesignStudy {
 public:
  DesignStudy(const std::filesystem::path& file, const std::filesystem::path& folder, Run& run)
      : run_(run),
        folder_(folder),
        robot_(vjm::read_robot(file)),
        posture_(at_home(robot_)),
        unloaded_(unloaded_stiffness(robot_.manipulator, posture_)) {
    if (!unloaded_.compliance) return;
    softest_ = report::softest_direction(*unloaded_.compliance);
    shares_ = vjm::spring_shares(robot_.manipulator, posture_, softest_.direction);
    const auto numbers = [this](const vjm::Robot& other) {
      return stiffness_numbers(other, have_other_postures(robot_) ? at_home(other) : posture_,
                               softest_.direction);
    };
    uncertainty_ = UncertaintyRequest().of(robot_, numbers, run_);
  }

  io::Json all();

 private:
  static vjm::Posture at_home(const vjm::Robot& robot) {
    const vjm::PostureResult home = vjm::posture_from_joints(robot.manipulator, {});
    if (!home.reached)
      throw common::NoConvergence(
          fmt::format("{}: its joints cannot stand at their home values: {}", robot.file.string(),
                      home.reason));
    return home.posture;
  }

  double stiffness_factor() const {
    return spatial::parse_unit(robot_.units.force).factor /
           spatial::parse_unit(robot_.units.length).factor;
  }
  std::string stiffness_unit() const { return robot_.units.force + "/" + robot_.units.length; }

  Station stiffness_station() const;
  Station yields_station() const;
  Station workspace_station();
  Station critical_station();
  Station critical_station(double critical, const vjm::MapIndex& index) const;
  Station assembly_station() const;
  Station links_station();
  std::vector<vjm::Manipulator> finer() const;
  void write_page(const std::string& headline, const io::Json& study) const;

  Run& run_;
  std::filesystem::path folder_;
  vjm::Robot robot_;
  vjm::Posture posture_;
  vjm::UnloadedStiffness unloaded_;
  report::SoftestDirection softest_{.direction = spatial::Vector3::UnitZ()};
  std::vector<vjm::SpringShare> shares_;
  std::optional<vjm::Uncertainty> uncertainty_;
  io::Json map_, map_picture_, link_models_;
  std::string links_text_;
};

std::vector<vjm::Manipulator> DesignStudy::finer() const {
  std::vector<vjm::Manipulator> models;
  if (!robot_.has_beams) return models;
  for (const int multiple : {2, 4})
    models.push_back(vjm::read_robot(robot_.file, {.segment_multiple = multiple}).manipulator);
  return models;
}

Station DesignStudy::stiffness_station() const {
  return {"stiffness", report::headline(robot_, unloaded_, {}, uncertainty_),
          unloaded_.compliance ? Light::good : Light::bad};
}

Station DesignStudy::yields_station() const {
  std::vector<std::string> words;
  for (const vjm::SpringShare& s : shares_)
    if (words.size() < 4 && s.share >= 0.05)
      words.push_back(
          report::short_percent(s.share) + " " +
          report::place_in_words(robot_.manipulator, vjm::name_of(robot_.manipulator, s)));
  if (words.empty()) return {"yields", "nothing yields to a force there", Light::open};
  const std::string along = report::direction_in_words(softest_.direction);
  return {"yields", fmt::format("along {}: {}", along, report::listed(words, "and")), Light::good};
}

Station DesignStudy::workspace_station() {
  const double edge = cube * unloaded_.length;
  const vjm::Neighbourhood about = vjm::neighbourhood(robot_.manipulator, posture_, edge);
  const vjm::PoseList& list = about.list;
  const std::vector<report::NamedIndex> indices = {
      {"weakest-translation",
       {.kind = vjm::MapIndex::Kind::weakest_translation},
       stiffness_unit(),
       stiffness_factor()}};
  const auto points = vjm::workspace_map(robot_.manipulator, list.poses, {indices[0].index},
                                         run_.threads(), run_.progress(), nullptr, finer());
  const report::Map map{robot_, list, indices, points};
  io::write_atomically(folder_ / "map.csv", report::csv(map));
  map_ = report::to_json(map);
  map_picture_ = report::picture(map);
  const vjm::MapRange range = vjm::range_of(points, 0);
  const double length = spatial::parse_unit(robot_.units.length).factor;
  if (range.count == 0) return {"workspace", "no pose about home can be reached", Light::open};
  const std::string where =
      fmt::format("{} {}", report::figure(edge / length, 3), robot_.units.length);
  std::vector<std::string> joints;
  for (const std::string& joint : about.joints)
    joints.push_back(report::short_name(robot_.manipulator, joint));
  return {
      "workspace",
      fmt::format("softest {} to {} {} at {} of {} {}",
                  report::figure(range.smallest / stiffness_factor(), 3),
                  report::figure(range.largest / stiffness_factor(), 3), stiffness_unit(),
                  range.count, list.poses.size(),
                  joints.empty() ? fmt::format("poses within {} of home", where)
                                 : fmt::format("postures about home, {} moved by up to {} at the "
                                               "platform",
                                               report::listed(joints), where)),
      range.count == list.poses.size() ? Light::good : Light::open};
}

Station DesignStudy::critical_station() {
  if (!(softest_.compliance > 0)) return {"stability", "not sought: nothing yields", Light::open};
  vjm::MapIndex index{.kind = vjm::MapIndex::Kind::critical_force,
                      .direction = -softest_.direction};
  index.up_to = most_deflection * unloaded_.length / softest_.compliance;
  const vjm::MapPoint point =
      vjm::map_point(robot_.manipulator, {.platform = posture_.platform}, {index}, finer());
  const double critical = point.values.empty() ? std::nan("") : point.values.front();
  if (std::isnan(critical)) return {"stability", "the path of equilibria was lost", Light::open};
  return critical_station(critical, index);
}

Station DesignStudy::critical_station(double critical, const vjm::MapIndex& index) const {
  const double force = spatial::parse_unit(robot_.units.force).factor;
  const std::string along = report::direction_in_words(index.direction);
  if (std::isinf(critical))
    return {"stability",
            fmt::format("stands {} {} along {}, which would move it by 1 % of its reach",
                        report::figure(index.up_to / force, 3), robot_.units.force, along),
            Light::good};
  return {"stability",
          fmt::format("gives way at {} {} along {}", report::figure(critical / force, 3),
                      robot_.units.force, along),
          Light::open};
}

Station DesignStudy::assembly_station() const {
  if (!robot_.manipulator.has_errors())
    return {"assembly", "its chains close: the file has no geometric errors", Light::good};
  return {"assembly", report::headline(robot_, vjm::assemble(robot_.manipulator, posture_)),
          Light::open};
}

// The links from their meshes, as beams and by finite elements.
Station DesignStudy::links_station() {
  const LinkModels models(robot_.file, {"beam", "fea"}, folder_ / "links", run_);
  const auto rows = models.compare([&](const vjm::Robot& robot) {
    return stiffness_along(robot, at_home(robot), softest_.direction);
  });
  const report::LinkModelFigure figure = report::stiffness_figure(robot_.units);
  link_models_ = report::to_json(figure, rows);
  links_text_ = "\n" + report::text(figure, rows);
  return {"links", report::in_short(rows), Light::good};
}

void DesignStudy::write_page(const std::string& headline, const io::Json& study) const {
  if (!report::has_pages()) return;
  io::Json stiffness = report::inputs_and_posture(robot_, posture_);
  stiffness["command"] = "stiffness";
  stiffness["unloaded"] = report::to_json(robot_, unloaded_);
  io::Json picture;
  vjm::Load load;
  load.force =
      softest_.compliance > 0
          ? spatial::Vector3(-1e-3 * unloaded_.length / softest_.compliance * softest_.direction)
          : spatial::Vector3(spatial::Vector3::Zero());
  const vjm::Equilibrium bent = equilibrium_under_load(robot_.manipulator, posture_, load);
  if (bent.status == vjm::EquilibriumStatus::converged) {
    picture["robot"] = report::picture(robot_.manipulator, posture_, bent);
    picture["robot"]["load"] = {{"at", io::to_json(bent.platform.position())},
                                {"force", io::to_json(load.force)}};
  }
  run_.draw(picture);
  std::vector<report::PageResult> results{
      {.result = study, .picture = std::move(picture), .text = {}},
      {.result = std::move(stiffness),
       .picture = report::picture(robot_.manipulator, posture_),
       .text = {}}};
  if (map_.is_object()) {
    io::Json map = map_;
    map["command"] = "map";
    results.push_back({.result = std::move(map), .picture = map_picture_, .text = {}});
  }
  io::write_atomically(folder_ / "index.html", report::page(headline, results));
}

io::Json DesignStudy::all() {
  std::vector<Station> stations{stiffness_station()};
  if (unloaded_.compliance) {
    stations.push_back(yields_station());
    stations.push_back(workspace_station());
    stations.push_back(critical_station());
  }
  stations.push_back(assembly_station());
  if (unloaded_.compliance && LinkModels::are_in(robot_.file)) stations.push_back(links_station());
  const std::string headline = report::headline(robot_, unloaded_, shares_, uncertainty_);
  io::Json list = io::Json::array();
  for (const Station& station : stations) list.push_back(report::to_json(station));
  io::Json json{{"headline", headline},
                {"inputs", report::provenance(robot_)},
                {"design", robot_.name},
                {"stations", list},
                {"yields", report::to_json(robot_, shares_)}};
  if (uncertainty_) json["uncertainty"] = report::stiffness_json(*uncertainty_, softest_.direction);
  if (!link_models_.is_null()) json["link_models"] = link_models_;
  if (map_.is_object()) io::write_json(folder_ / "map.json", map_);
  io::write_json(folder_ / "study.json", json);
  io::Json study{{"command", "study"}};
  study.update(json);
  write_page(headline, study);
  run_.print(report::wrapped(headline) + "\n" + report::text(stations));
  if (report::has_pages()) run_.print(fmt::format("page: {}\n", (folder_ / "index.html").string()));
  run_.print_more("\n" + report::first_screen(robot_, posture_, unloaded_, shares_) + links_text_);
  return json;
}

}  // namespace

io::Json study_design(const std::filesystem::path& file, const std::filesystem::path& folder,
                      Run& run) {
  return DesignStudy(file, folder, run).all();
}

}  // namespace kinetostat::apps
