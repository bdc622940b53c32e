// Whether a posture is one that the drives can go to.
#pragma once

#include <string>

#include "kinetostat/vjm/manipulator/manipulator.h"
#include "kinetostat/vjm/manipulator/posture.h"

namespace kinetostat::vjm {

/// The first joint that stands beyond its Coordinate::range, in a sentence; empty where none does.
/// A turning joint may be whole turns away from it.
std::string beyond_range(const Manipulator& manipulator, const Posture& posture);

}  // namespace kinetostat::vjm
