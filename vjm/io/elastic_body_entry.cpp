#include "kinetostat/vjm/io/elastic_body_entry.h"

#include <algorithm>
#include <set>

#include <fmt/format.h>

#include "kinetostat/vjm/chain/chain_builder.h"
#include "kinetostat/vjm/io/link_uncertainty.h"

namespace kinetostat::vjm::elastic_body_entry {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using io::YamlNode;
using spatial::Pose;

std::vector<std::string> names_of(const FileBodies& bodies) {
  std::vector<std::string> names;
  for (const auto& [name, place] : bodies.places) names.push_back(name);
  return names;
}

// Of a place that is known to be there.
const BodyPlace& found(const FileBodies& bodies, const std::string& name) {
  return std::find_if(bodies.places.begin(), bodies.places.end(),
                      [&](const auto& place) { return place.first == name; })
      ->second;
}

void add_inner(const YamlNode& node, const std::string& name, const Pose& axes,
               FileBodies& bodies) {
  for (const auto& [other, place] : bodies.places)
    if (other == name)
      node.fail(fmt::format("two bodies are named '{}'", name), "Give each its own name");
  bodies.inner.push_back(name);
  bodies.places.emplace_back(name, BodyPlace{static_cast<int>(bodies.inner.size()), axes});
}

// `base`, or `{to: base, pose: POSE}`: what an interface is fastened to.
void fasten(const YamlNode& node, std::size_t interface, const Pose& usual,
            const spatial::UnitSystem& units, const FileBodies& bodies, ElasticBodyEntry& entry) {
  if (node.is_map()) node.allow_only({"to", "pose"});
  const std::string to = (node.is_map() ? node.at("to") : node).choice(names_of(bodies));
  const auto pose = node.is_map() ? node.find("pose") : std::nullopt;
  const BodyPlace& place = found(bodies, to);
  entry.fastens[interface] = to;
  entry.at[interface] = {place.body, place.axes * (pose ? io::read_pose(*pose, units) : usual)};
}

ElasticBodyEntry read_elastic_body(const YamlNode& node, const spatial::UnitSystem& units,
                                   SourceList& sources, FileBodies& bodies) {
  node.allow_only({"name", "elastic", "interfaces", "pose"});
  const std::filesystem::path file = node.at("elastic").existing_file();
  ElasticBodyEntry entry{.node = node,
                         .name = node.at("name").text(),
                         .file = file,
                         .link = io::read_reduced_link(file),
                         .stiffness = {},
                         .at = {},
                         .fastens = {}};
  entry.stiffness = uncertain_stiffness(entry.link, file, sources);
  const std::size_t count = entry.link.interfaces.size();
  entry.at.resize(count);
  entry.fastens.resize(count);
  const auto given = node.find("interfaces");
  if (given) given->allow_only(entry.link.interfaces);
  const auto pose = node.find("pose");
  const Pose usual = pose ? io::read_pose(*pose, units) : Pose();
  const FileBodies known = bodies;
  for (std::size_t i = 0; i < count; ++i) {
    const std::string& name = entry.link.interfaces[i];
    if (const auto to = given ? given->find(name) : std::nullopt) {
      fasten(*to, i, usual, units, known, entry);
      continue;
    }
    add_inner(node, entry.name + "." + name, Pose::translation(-entry.link.points[i]), bodies);
    entry.at[i] = bodies.places.back().second;
  }
  return entry;
}

// Interfaces of a body that move together keep it undeformed between them only where the body
// stands in one pose there.
void refuse_two_poses(const ElasticBodyEntry& entry) {
  for (std::size_t i = 0; i < entry.at.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (entry.at[i].body == entry.at[j].body &&
          spatial::pose_difference(entry.at[i].axes, entry.at[j].axes).norm() > 1e-9)
        entry.node.fail(
            fmt::format("the interfaces '{}' and '{}' are fastened to '{}' in two poses of '{}'",
                        entry.link.interfaces[j], entry.link.interfaces[i], entry.fastens[i],
                        entry.name),
            "Give both the same 'pose'");
}

// Its number; that of no interface when nothing carries the body yet.
std::size_t origin_of(const ElasticBodyEntry& entry, const std::set<int>& carried) {
  for (std::size_t i = 0; i < entry.at.size(); ++i)
    if (entry.at[i].body == Span::base) return i;
  for (std::size_t i = 0; i < entry.at.size(); ++i)
    if (carried.contains(entry.at[i].body)) return i;
  return entry.at.size();
}

// Coordinates of some interfaces.
std::vector<Index> places_of(const std::vector<std::size_t>& interfaces) {
  std::vector<Index> places;
  for (const std::size_t i : interfaces)
    for (Index k = 0; k < 6; ++k) places.push_back(static_cast<Index>(6 * i) + k);
  return places;
}

void add_mass(const ElasticBodyEntry& entry, const std::vector<Index>& deflections,
              ElasticBody& body) {
  const MatrixXd& inertia = entry.link.inertia;
  if (inertia.size() == 0) return;
  MatrixXd rigid(inertia.rows(), 6);
  for (std::size_t i = 0; i < entry.at.size(); ++i) {
    auto six = rigid.middleRows<6>(static_cast<Index>(6 * i));
    six.setIdentity();
    six.topRightCorner<3, 3>() = -spatial::skew(entry.link.points[i]);
  }
  const Eigen::Matrix3Xd momentum = rigid.leftCols<3>().transpose() * inertia;
  body.inertia = inertia;
  body.mass = (momentum * rigid.leftCols<3>()).trace() / 3;
  // Of a turn about the origin of the axes: -m [c]x.
  const spatial::Matrix3 turn = momentum * rigid.rightCols<3>();
  body.center =
      spatial::Vector3(turn(1, 2) - turn(2, 1), turn(2, 0) - turn(0, 2), turn(0, 1) - turn(1, 0)) /
      (2 * body.mass);
  body.moment = momentum(Eigen::all, deflections);
}

// The interfaces that deflect against the origin; those that move with it do not.
ElasticBody add_elastic_body(const ElasticBodyEntry& entry, std::size_t origin,
                             std::vector<Chain>& chains, std::vector<Span>& spans) {
  ElasticBody body{.name = entry.name,
                   .interfaces = {},
                   .origin = entry.at[origin].body,
                   .frame = entry.at[origin].axes,
                   .chains = {},
                   .stiffness = {}};
  std::vector<std::size_t> moving;
  for (std::size_t i = 0; i < entry.at.size(); ++i) {
    const spatial::Vector3& point = entry.link.points[i];
    body.interfaces.push_back({entry.link.interfaces[i], point, entry.at[i].body});
    if (entry.at[i].body == body.origin) continue;
    moving.push_back(i);
    body.chains.push_back(chains.size());
    const spatial::Vector3& start = entry.link.points[origin];
    ChainBuilder chain(entry.name + "." + entry.link.interfaces[i],
                       body.frame * Pose::translation(start));
    chain.elastic(entry.name, Pose::translation(point - start));
    chain.attach((entry.at[i].axes * Pose::translation(point)).inverse());
    chains.push_back(chain.build());
    spans.push_back({body.origin, entry.at[i].body});
  }
  if (moving.empty())
    entry.node.fail("all of its interfaces are fastened to one body: it cannot yield",
                    "Leave out of 'interfaces' those where chains start or end");
  const std::vector<Index> deflections = places_of(moving);
  body.stiffness = entry.stiffness(deflections, deflections);
  add_mass(entry, deflections, body);
  return body;
}

}  // namespace
}  // namespace kinetostat::vjm::elastic_body_entry

namespace kinetostat::vjm {

FileBodies read_bodies(const std::optional<io::YamlNode>& list, const spatial::UnitSystem& units,
                       SourceList& sources) {
  using namespace elastic_body_entry;
  FileBodies bodies;
  bodies.places = {{"base", {Span::base}}, {"platform", {Span::platform}}};
  if (!list) return bodies;
  for (const io::YamlNode& item : list->items())
    if (!item.is_map()) add_inner(item, item.text(), {}, bodies);
  for (const io::YamlNode& item : list->items())
    if (item.is_map()) bodies.elastic.push_back(read_elastic_body(item, units, sources, bodies));
  return bodies;
}

BodyPlace place_of(const io::YamlNode& chain, const char* key, const BodyPlace& otherwise,
                   const FileBodies& bodies) {
  using namespace elastic_body_entry;
  const auto given = chain.find(key);
  if (!given) return otherwise;
  const std::string name = given->text();
  for (const ElasticBodyEntry& entry : bodies.elastic)
    for (std::size_t i = 0; i < entry.at.size(); ++i)
      if (!entry.fastens[i].empty() && name == entry.name + "." + entry.link.interfaces[i])
        given->fail(
            fmt::format("the interface '{}' of '{}' is fastened to '{}' already",
                        entry.link.interfaces[i], entry.name, entry.fastens[i]),
            fmt::format("Write '{}: {}', or take it out of 'interfaces'", key, entry.fastens[i]));
  return found(bodies, given->choice(names_of(bodies)));
}

std::vector<ElasticBody> add_elastic_bodies(const FileBodies& bodies, std::vector<Chain>& chains,
                                            std::vector<Span>& spans) {
  using namespace elastic_body_entry;
  std::set<int> carried;
  for (const Span& span : spans)
    if (span.to != Span::platform) carried.insert(span.to);
  std::vector<ElasticBody> elastic;
  std::vector<const ElasticBodyEntry*> left;
  for (const ElasticBodyEntry& entry : bodies.elastic) left.push_back(&entry);
  while (!left.empty()) {
    const auto next = std::find_if(left.begin(), left.end(), [&](const ElasticBodyEntry* entry) {
      return origin_of(*entry, carried) < entry->at.size();
    });
    if (next == left.end()) {
      // The platform carries what nothing else does.
      if (carried.insert(Span::platform).second) continue;
      left[0]->node.fail(
          fmt::format("'{}' is free to move: none of its interfaces is fastened to the base, and "
                      "no chain ends on one",
                      left[0]->name),
          "Write 'interfaces: {NAME: base}', or let a chain end there with 'to:'");
    }
    refuse_two_poses(**next);
    elastic.push_back(add_elastic_body(**next, origin_of(**next, carried), chains, spans));
    for (const BodyPlace& place : (*next)->at)
      if (place.body != Span::platform) carried.insert(place.body);
    left.erase(next);
  }
  return elastic;
}

}  // namespace kinetostat::vjm
