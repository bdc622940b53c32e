// Robots and a frame that are read by sensors elsewhere than at a tool point.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

namespace twin {

/// A three-joint arm on a foundation that turns, under weights on its flange in several postures.
/// Tilt sensors stand on the base plate and on the forearm, two dial gauges at the end of the upper
/// arm, a ballbar runs from the tool point to the floor.
struct FoundationCase {
  double foundation = 4e-6;  // [rad/(N m)], and what its owner believes
  double believed = 1e-6;
  double softer = 0.8;         // stiffness of q2 and q3 over what their owner believes
  double tilt_noise = 2e-6;    // [rad]
  double length_noise = 1e-6;  // [m]
  std::uint64_t seed = 1;
  /// Columns to write, of "base_level", "tool_level", "bent", "dial", "ballbar".
  std::string sensors = "base_level,tool_level";
  bool foundation_in_file = true;  // the robot file has its compliance, as uncertain
  /// Instead of weights: cylinders, "ground" from the floor to the elbow, "bodies" between the
  /// column's foot and the forearm.
  std::string cylinder = {};
  bool light = false;  // a tenth of the loads, so that everything is linear in them
};

/// Writes robot.yaml, campaign.yaml and readings.csv into a folder. Throws std::runtime_error.
void write_foundation(const FoundationCase& spec, const std::filesystem::path& folder);

/// A six-axis arm under its own weight and a payload in 30 postures, whose target a tracker sees:
/// nobody knows where the tracker stands, nor where on the flange the target sits.
struct TrackerCase {
  double softer = 0.75;  // stiffness of q2 and q3 over what their owner believes
  double noise = 10e-6;  // [m] of each coordinate
  double payload = 60;   // [kg]
  std::uint64_t seed = 1;
};

void write_tracker(const TrackerCase& spec, const std::filesystem::path& folder);

/// A plate on a tube that is bolted to a wall: weights on one side, then on the other, twist it.
/// Four dial gauges stand under its corners.
struct FrameCase {
  double softer = 0.9;  // stiffness of the bolted joint over what its owner believes
  double play = 0;      // of that joint [rad]
  double noise = 2e-6;  // of each gauge [m]
  std::uint64_t seed = 1;
};

void write_frame(const FrameCase& spec, const std::filesystem::path& folder);

}  // namespace twin
