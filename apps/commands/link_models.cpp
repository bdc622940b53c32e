#include "kinetostat/apps/commands/link_models.h"

#include <algorithm>
#include <cstdlib>

#include <fmt/format.h>

#include "kinetostat/apps/cli/version.h"
#include "kinetostat/common/error.h"
#include "kinetostat/fea/link/identify.h"
#include "kinetostat/fea/section/beam_study.h"
#include "kinetostat/io/cache.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/io/yaml.h"
#include "kinetostat/vjm/statics/stiffness.h"

namespace kinetostat::apps {
namespace {

constexpr char fea_name[] = "FEA";

// A link result (without what only people read) by each model of a link.
io::Json models_of(const fea::LinkSpec& spec, Run& run, const io::Cache& cache) {
  const fea::LinkGeometry geometry = fea::read_geometry(spec, run.progress());
  fea::IdentifyOptions settings;
  settings.meshing.cache = &cache;
  settings.solver.threads = run.threads();
  const fea::LinkResult found = fea::identify(spec, geometry, settings, run.progress());
  const auto result = [&](const spatial::Compliance6& compliance) {
    io::Json json{{"kinetostat", 1}, {"link", spec.name}};
    json.update(io::to_json(compliance));
    if (found.mass) {
      json["mass"] = *found.mass;
      json["center_of_mass"] = io::to_json(found.center_of_mass);
    }
    return json;
  };
  const fea::LinkBody body{.surface = geometry.imported.mesh,
                           .mesh = found.mesh,
                           .fixed = found.interfaces.front().geometry,
                           .loaded = found.interfaces[1].geometry};
  io::Json models;
  try {
    const fea::BeamStudy beams =
        fea::study_beams(body, spec.material, found.compliance.frame().point, {}, run.progress());
    for (const fea::BeamModel& model : beams.models) models[model.name] = result(model.compliance);
  } catch (const fea::SectionError& error) {
    throw common::InputError(spec.file, error.what(), "Leave --links out");
  }
  models[fea_name] = result(found.compliance);
  return models;
}

io::Json kept_models(const std::filesystem::path& link_file, Run& run) {
  const fea::LinkSpec spec = fea::read_link(link_file);
  const io::Cache cache = io::Cache::of_user();
  const std::string key =
      fmt::format("link models {} {} {}", this_program(), run.threads(), spec.meaning);
  if (const auto text = cache.find(key)) {
    io::Json kept = io::Json::parse(*text, nullptr, false);
    if (kept.is_object() && kept.contains(fea_name)) return kept;
  }
  io::Json models = models_of(spec, run, cache);
  cache.keep(key, io::to_text(models));
  return models;
}

std::vector<std::string> models_named(const std::vector<std::string>& words) {
  const auto has = [&](const char* word) {
    return std::find(words.begin(), words.end(), word) != words.end();
  };
  for (const std::string& word : words)
    if (word != "beam" && word != "fea")
      throw UsageError("--links", fmt::format("there is no model '{}' of links", word),
                       "Write --links beam,fea");
  std::vector<std::string> names;
  if (has("beam")) names = {"1 beam", fmt::format("{} beams", fea::BeamOptions{}.beams)};
  if (has("fea")) names.emplace_back(fea_name);
  if (names.size() < 2)
    throw UsageError("--links", "'fea' alone has nothing beside it", "Write --links beam,fea");
  return names;
}

}  // namespace

void add_links_option(OptionList& app, std::vector<std::string>& links) {
  app.add_option("--links", links,
                 "The robot with its links as beams and by finite elements, side by side: beam,fea")
      .type_name("MODELS")
      .delimiter(',');
}

LinkModels::LinkModels(const std::filesystem::path& robot, const std::vector<std::string>& words,
                       std::filesystem::path folder, Run& run)
    : robot_(robot),
      folder_(std::move(folder)),
      links_(links_of(robot)),
      names_(models_named(words)) {
  if (links_.empty())
    throw common::InputError(robot_, "no link names the link file that it was identified from",
                             "Write 'compliance: foot.link.json, link_file: foot.yaml'");
  for (const Link& link : links_) {
    const io::Json models = kept_models(link.link_file, run);
    for (std::size_t m = 0; m < names_.size(); ++m)
      io::write_json(file_of(link, m), models.at(names_[m]));
  }
}

bool LinkModels::are_in(const std::filesystem::path& robot) { return !links_of(robot).empty(); }

std::vector<LinkModels::Link> LinkModels::links_of(const std::filesystem::path& robot) {
  std::vector<Link> links;
  const io::YamlNode top = io::read_yaml(robot);
  const auto all = top.find("links");
  if (!all) return links;
  for (const auto& [name, node] : all->members()) {
    const auto file = node.is_map() ? node.find("link_file") : std::nullopt;
    if (!file) continue;
    const io::YamlNode compliance = node.at("compliance");
    links.push_back({name, compliance.text(), compliance.line(), file->existing_file()});
  }
  return links;
}

std::filesystem::path LinkModels::file_of(const Link& link, std::size_t model) const {
  std::string name = fmt::format("{} {}.link.json", link.name, names_[model]);
  std::replace(name.begin(), name.end(), ' ', '_');
  return std::filesystem::absolute(folder_ / name);
}

// The robot file as somebody would write it who has these link results.
vjm::Robot LinkModels::with(const std::vector<std::size_t>& model_of_link) const {
  std::string text = io::read_text(robot_);
  for (std::size_t i = links_.size(); i-- > 0;) {
    std::size_t at = 0;
    for (int line = 1; line < links_[i].line; ++line) at = text.find('\n', at) + 1;
    at = text.find(links_[i].compliance, at);
    text.replace(at, links_[i].compliance.size(), file_of(links_[i], model_of_link[i]).string());
  }
  return vjm::parse_robot(text, robot_);
}

vjm::Robot LinkModels::robot(std::size_t model) const {
  return with(std::vector<std::size_t>(links_.size(), model));
}

std::vector<report::LinkModelRow> LinkModels::compare(
    const std::function<double(const vjm::Robot&)>& value) const {
  const std::size_t last = names_.size() - 1;
  std::vector<report::LinkModelRow> rows;
  for (std::size_t m = 0; m <= last; ++m) {
    report::LinkModelRow row{.model = names_[m], .value = value(robot(m)), .by_link = {}};
    for (std::size_t i = 0; m < last && i < links_.size(); ++i) {
      std::vector<std::size_t> models(links_.size(), last);
      models[i] = m;
      row.by_link.emplace_back(links_[i].name, value(with(models)));
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

double stiffness_along(const vjm::Robot& robot, const vjm::Posture& posture,
                       const spatial::Vector3& direction) {
  const vjm::UnloadedStiffness unloaded = unloaded_stiffness(robot.manipulator, posture);
  if (!unloaded.compliance)
    throw common::NoConvergence("some motion of the platform meets no resistance");
  const spatial::Matrix3 compliance = unloaded.compliance->matrix().topLeftCorner<3, 3>();
  return 1 / direction.dot(compliance * direction);
}

ScratchFolder::ScratchFolder() {
  std::string name = (std::filesystem::temp_directory_path() / "kinetostat-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr)
    throw common::InputError(name, "no temporary folder can be made", "Set TMPDIR to one");
  path_ = name;
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  std::filesystem::remove_all(path_, ignored);
}

}  // namespace kinetostat::apps
