// The file that lets an interrupted map go on. Internal to this module.
#pragma once

#include <vector>

#include "kinetostat/vjm/workspace_map.h"

namespace kinetostat::vjm {

/// The first poses of the map as they were saved; empty when there is no file. Throws
/// files::InputError when the file belongs to another map or is damaged.
std::vector<MapPoint> read_map_checkpoint(const MapCheckpoint& checkpoint, std::size_t poses,
                                          std::size_t indices);

/// `points` are the first of `poses`; written atomically.
void write_map_checkpoint(const MapCheckpoint& checkpoint, const std::vector<MapPoint>& points,
                          std::size_t poses);

}  // namespace kinetostat::vjm
