// The file that lets an interrupted map go on. Internal to this module.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "kinetostat/vjm/workspace/map_point.h"

namespace kinetostat::vjm {

/// Where an interrupted map goes on from. The file is rewritten atomically and removed when the map
/// is complete.
struct MapCheckpoint {
  std::filesystem::path file;
  std::string request;    // identifies the map: a hash of everything that decides its values
  double interval = 5;    // [s] between savings
  std::size_t found = 0;  // out: poses that the file already held
};

/// The first poses of the map as they were saved; empty when there is no file. Throws
/// common::InputError when the file belongs to another map or is damaged.
std::vector<MapPoint> read_map_checkpoint(const MapCheckpoint& checkpoint, std::size_t poses,
                                          std::size_t indices);

/// `points` are the first of `poses`; written atomically.
void write_map_checkpoint(const MapCheckpoint& checkpoint, const std::vector<MapPoint>& points,
                          std::size_t poses);

}  // namespace kinetostat::vjm
