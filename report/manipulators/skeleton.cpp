#include "kinetostat/report/manipulators/skeleton.h"

#include <algorithm>
#include <cmath>

#include "kinetostat/vjm/chain/kinematics.h"

namespace kinetostat::report {
namespace {

using io::Json;
using spatial::Pose;
using spatial::Vector3;
using vjm::Chain;

const char* word(vjm::Role role) {
  switch (role) {
    case vjm::Role::actuated:
      return "actuated";
    case vjm::Role::passive:
      return "passive";
    case vjm::Role::elastic:
      break;
  }
  return "elastic";
}

// A coupled joint may move otherwise than the coordinate that drives it.
Json joint_json(const vjm::Coordinate& coordinate, vjm::Motion motion, const Pose& frame) {
  return {{"name", coordinate.name},
          {"role", word(coordinate.role)},
          {"turns", is_rotation(motion)},
          {"at", io::to_json(frame.position())},
          {"axis", io::to_json(Vector3(frame.rotation().col(axis_index(motion))))}};
}

// Whether the springs of a link or a compliance end behind joint k: the next joint is none of
// theirs.
bool ends_elastic_run(const Chain& chain, std::size_t k) {
  const auto is_elastic = [&](std::size_t joint) {
    const auto coordinate = static_cast<std::size_t>(chain.joints()[joint].coordinate);
    return chain.coordinates()[coordinate].role == vjm::Role::elastic;
  };
  if (!is_elastic(k)) return false;
  return k + 1 == chain.joints().size() || !is_elastic(k + 1) ||
         !chain.joints()[k + 1].nominal_before.position().isZero(0);
}

// Positions along the chain. Which there are follows from its structure alone, so that those of two
// states correspond: the start, where a joint sits, where a slide has led to, the end of each
// link's springs (so that a link is one straight line to where its end has gone), the end.
Json points_json(const Chain& chain, const Eigen::VectorXd& x, const Pose& origin) {
  Json points = Json::array();
  points.push_back(io::to_json((origin * chain.base()).position()));
  for (std::size_t k = 0; k < chain.joints().size(); ++k) {
    const auto before = static_cast<Eigen::Index>(k);
    const vjm::Joint& joint = chain.joints()[k];
    const auto coordinate = static_cast<std::size_t>(joint.coordinate);
    if (chain.coordinates()[coordinate].role == vjm::Role::elastic) {
      if (ends_elastic_run(chain, k))
        points.push_back(io::to_json(frame_behind(chain, x, before + 1, origin).position()));
      continue;
    }
    // In front of the first joint is the base, where the line has started.
    const Vector3 start = k == 0 ? Vector3(chain.base().position()) : Vector3::Zero();
    if ((joint.nominal_before.position() - start).norm() > 0)
      points.push_back(
          io::to_json((frame_behind(chain, x, before, origin) * joint.before).position()));
    if (!is_rotation(joint.motion))
      points.push_back(io::to_json(frame_behind(chain, x, before + 1, origin).position()));
  }
  vjm::ChainKinematics kinematics;
  evaluate(chain, x, kinematics, origin);
  points.push_back(io::to_json(kinematics.end.position()));
  return points;
}

Json chain_json(const Chain& chain, const Eigen::VectorXd& x, const Pose& origin) {
  Json joints = Json::array();
  for (std::size_t k = 0; k < chain.joints().size(); ++k) {
    const vjm::Joint& joint = chain.joints()[k];
    const vjm::Coordinate& coordinate =
        chain.coordinates()[static_cast<std::size_t>(joint.coordinate)];
    if (coordinate.role != vjm::Role::elastic)
      joints.push_back(
          joint_json(coordinate, joint.motion,
                     frame_behind(chain, x, static_cast<Eigen::Index>(k) + 1, origin)));
  }
  return {{"name", chain.name()}, {"points", points_json(chain, x, origin)}, {"joints", joints}};
}

Json body_json(const std::string& name, const Pose& pose) {
  return {{"name", name},
          {"position", io::to_json(pose.position())},
          {"axes", io::rows(pose.rotation().transpose())}};
}

// `bodies`: platform first.
Json skeleton(const vjm::Manipulator& manipulator, const std::vector<Pose>& bodies,
              const std::vector<Eigen::VectorXd>& coordinates) {
  Json json{{"chains", Json::array()}, {"bodies", Json::array()}};
  for (std::size_t c = 0; c < manipulator.size(); ++c) {
    const int from = manipulator.span(c).from;
    const Pose origin = from < 0 ? Pose() : bodies[static_cast<std::size_t>(from)];
    json["chains"].push_back(chain_json(manipulator.chains()[c], coordinates[c], origin));
  }
  for (std::size_t b = 0; b < bodies.size(); ++b)
    json["bodies"].push_back(body_json(manipulator.body_names()[b], bodies[b]));
  return json;
}

// Where the chains lead their bodies, one after the other, from those on the base on.
std::vector<Pose> bodies_at_ends(const vjm::Manipulator& manipulator, std::vector<Pose> bodies,
                                 const std::vector<Eigen::VectorXd>& coordinates) {
  std::vector<bool> is_known(bodies.size(), false);
  for (std::size_t round = 0; round < bodies.size(); ++round)
    for (std::size_t c = 0; c < manipulator.size(); ++c) {
      const auto [from, to] = manipulator.span(c);
      const auto end = static_cast<std::size_t>(to), start = static_cast<std::size_t>(from);
      if (is_known[end] || (from >= 0 && !is_known[start])) continue;
      vjm::ChainKinematics kinematics;
      evaluate(manipulator.chains()[c], coordinates[c], kinematics,
               from < 0 ? Pose() : bodies[start]);
      bodies[end] = kinematics.end;
      is_known[end] = true;
    }
  return bodies;
}

std::vector<Pose> all_bodies(const Pose& platform, const std::vector<Pose>& inner) {
  std::vector<Pose> bodies{platform};
  bodies.insert(bodies.end(), inner.begin(), inner.end());
  return bodies;
}

}  // namespace

Json skeleton(const vjm::Manipulator& manipulator, const vjm::Posture& posture) {
  std::vector<Eigen::VectorXd> coordinates;
  for (std::size_t c = 0; c < manipulator.size(); ++c)
    coordinates.push_back(posture.coordinates_of(manipulator.chains()[c], c));
  return skeleton(manipulator, all_bodies(posture.platform, posture.inner_bodies), coordinates);
}

Json skeleton(const vjm::Manipulator& manipulator, const vjm::Equilibrium& equilibrium) {
  std::vector<Eigen::VectorXd> coordinates;
  for (const vjm::ChainEquilibrium& chain : equilibrium.chains)
    coordinates.push_back(chain.coordinates);
  return skeleton(manipulator, all_bodies(equilibrium.platform, equilibrium.inner_bodies),
                  coordinates);
}

Json picture(const vjm::Manipulator& manipulator, const vjm::Posture& posture,
             const std::vector<vjm::ManipulatorMode>& modes) {
  constexpr double small = 1e-4;  // [m or rad], of the coordinate that moves most
  Json shapes = Json::array();
  for (const vjm::ManipulatorMode& mode : modes) {
    double most = 0;
    for (const Eigen::VectorXd& moved : mode.coordinates)
      if (moved.size() > 0) most = std::max(most, moved.cwiseAbs().maxCoeff());
    std::vector<Eigen::VectorXd> coordinates;
    for (std::size_t c = 0; c < manipulator.size(); ++c)
      coordinates.emplace_back(posture.coordinates_of(manipulator.chains()[c], c) +
                               small / most * mode.coordinates[c]);
    const std::vector<Pose> bodies = bodies_at_ends(
        manipulator, all_bodies(posture.platform, posture.inner_bodies), coordinates);
    shapes.push_back(skeleton(manipulator, bodies, coordinates));
  }
  return {{"at_rest", skeleton(manipulator, posture)}, {"shapes", shapes}};
}

Json named_skeleton(const std::string& name, const Json& skeleton) {
  Json json{{"name", name}};
  json.update(skeleton);
  return json;
}

Json picture(const vjm::Manipulator& manipulator, const vjm::Posture& posture) {
  return {{"skeletons", Json::array({named_skeleton(
                            "unloaded", skeleton(manipulator.without_errors(), posture))})}};
}

Json picture(const vjm::Manipulator& manipulator, const vjm::Posture& posture,
             const vjm::Equilibrium& state, const std::string& relaxed, const std::string& loaded) {
  return {{"skeletons",
           Json::array({named_skeleton(relaxed, skeleton(manipulator.without_errors(), posture)),
                        named_skeleton(loaded, skeleton(manipulator, state))})}};
}

Json chain_lines(const vjm::Manipulator& manipulator, const vjm::Equilibrium& equilibrium) {
  // Micrometres are more than a screen shows.
  const auto rounded = [](double x) { return std::round(x * 1e6) / 1e6; };
  Json lines = Json::array();
  const Json all = skeleton(manipulator, equilibrium);
  for (const Json& chain : all["chains"]) {
    Json points = Json::array();
    for (const Json& point : chain["points"])
      points.push_back({rounded(point[0]), rounded(point[1]), rounded(point[2])});
    lines.push_back(std::move(points));
  }
  return lines;
}

}  // namespace kinetostat::report
