// The bodies between base and platform as robot files describe them, elastic ones among them.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "kinetostat/io/link_result_file.h"
#include "kinetostat/io/yaml.h"
#include "kinetostat/vjm/io/uncertainty_source.h"
#include "kinetostat/vjm/manipulator/manipulator.h"

namespace kinetostat::vjm {

/// Where a chain may start or end: a body of the manipulator, and the axes in which the file gives
/// poses there, in that body's frame.
struct BodyPlace {
  int body = Span::base;
  spatial::Pose axes = {};
};

/// `{name: frame, elastic: FILE, interfaces: {feet: base}, pose: POSE}`.
struct ElasticBodyEntry {
  io::YamlNode node;
  std::string name;
  std::filesystem::path file;
  io::ReducedLink link;
  Eigen::MatrixXd stiffness;         // between all interfaces, mesh axes
  std::vector<BodyPlace> at;         // of every interface: what moves with it, mesh axes in that
  std::vector<std::string> fastens;  // the name of that; empty where only chains hold it
};

/// The bodies of a file by the names that its chains call them.
struct FileBodies {
  std::vector<std::string> inner;  // bodies 1, 2, ... of the manipulator
  std::vector<std::pair<std::string, BodyPlace>> places;
  std::vector<ElasticBodyEntry> elastic;
};

/// Reads the list under `bodies`, if there is one. An interface that is fastened to nothing becomes
/// an inner body "frame.left", its frame at the interface's point. Throws common::InputError.
FileBodies read_bodies(const std::optional<io::YamlNode>& list, const spatial::UnitSystem& units,
                       SourceList& sources);

/// The place that a chain names under `key`. Throws common::InputError.
BodyPlace place_of(const io::YamlNode& chain, const char* key, const BodyPlace& otherwise,
                   const FileBodies& bodies);

/// The elastic bodies, and the chains within them behind all others. The origin of one is an
/// interface that is fastened to the base; else the first on which a chain ends, or another elastic
/// body. Throws common::InputError when there is none.
std::vector<ElasticBody> add_elastic_bodies(const FileBodies& bodies, std::vector<Chain>& chains,
                                            std::vector<Span>& spans);

}  // namespace kinetostat::vjm
