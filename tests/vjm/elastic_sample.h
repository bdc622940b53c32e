// Elastic bodies made up for tests, and robots with them.
#pragma once

#include <fstream>
#include <string>
#include <vector>

#include "kinetostat/io/json.h"
#include "kinetostat/vjm/io/robot_file.h"

#include "support/temporary_folder.h"
#include "vjm/random_chain.h"

namespace kinetostat::vjm::samples {

/// A body between points, as a link result has it: every two are joined by a spring of six
/// directions, so that all are coupled and nothing but rigid motions is free; its mass is of
/// particles that move with the mean of two points.
struct BodyBetweenPoints {
  std::vector<std::string> names;
  std::vector<spatial::Vector3> points;
  Eigen::MatrixXd stiffness, inertia;
  std::vector<std::pair<double, spatial::Vector3>> particles;

  BodyBetweenPoints(std::vector<std::string> n, std::vector<spatial::Vector3> p, unsigned seed)
      : names(std::move(n)), points(std::move(p)) {
    RandomChains random(seed);
    const auto size = static_cast<Eigen::Index>(6 * points.size());
    stiffness = inertia = Eigen::MatrixXd::Zero(size, size);
    for (std::size_t i = 0; i < points.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) {
        Eigen::MatrixXd apart = Eigen::MatrixXd::Zero(6, size);
        apart.middleCols<6>(at(j)) = -carried(points[i] - points[j]);
        apart.middleCols<6>(at(i)).setIdentity();
        stiffness += apart.transpose() * random.compliance().inverse().matrix() * apart;
        const spatial::Vector3 place = 0.5 * (points[i] + points[j]) + random.vector(0.05);
        Eigen::MatrixXd motion = Eigen::MatrixXd::Zero(3, size);
        motion.middleCols<6>(at(i)) = 0.5 * carried(place - points[i]).topRows<3>();
        motion.middleCols<6>(at(j)) = 0.5 * carried(place - points[j]).topRows<3>();
        particles.emplace_back(random.uniform(2, 5), place);
        inertia += particles.back().first * motion.transpose() * motion;
      }
  }

  io::Json json() const {
    io::Json freedoms = io::Json::array();
    for (std::size_t i = 0; i < points.size(); ++i)
      for (int k = 0; k < 6; ++k)
        freedoms.push_back({{"interface", names[i]},
                            {"motion", std::string(k < 3 ? "t" : "r") + "xyz"[k % 3]},
                            {"point", io::to_json(points[i])},
                            {"motion_unit", k < 3 ? "m" : "rad"},
                            {"load_unit", k < 3 ? "N" : "N m"}});
    return {{"reduced",
             {{"degrees_of_freedom", freedoms},
              {"stiffness", io::rows(stiffness)},
              {"mass", io::rows(inertia)}}}};
  }

 private:
  static Eigen::Index at(std::size_t i) { return static_cast<Eigen::Index>(6 * i); }
  static spatial::Matrix6 carried(const spatial::Vector3& arm) {
    spatial::Matrix6 motion = spatial::Matrix6::Identity();
    motion.topRightCorner<3, 3>() = -spatial::skew(arm);
    return motion;
  }
};

/// Robot of this text in whose folder body.json has the link result.
inline Robot robot_with_body(const std::string& text, const io::Json& body) {
  const test::TemporaryFolder folder;
  io::write_json(folder.path() / "body.json", body);
  std::ofstream(folder.path() / "robot.yaml") << text;
  Robot robot = read_robot(folder.path() / "robot.yaml");
  robot.text = {};
  return robot;
}

}  // namespace kinetostat::vjm::samples
