// A manipulator in the place of a link: a parallelogram as one spring with a free motion.
#pragma once

#include "kinetostat/io/yaml.h"
#include "kinetostat/vjm/io/link_model.h"
#include "kinetostat/vjm/io/link_options.h"

namespace kinetostat::vjm {

/// A stiffness of any rank at the end of a link, in the axes of its end frame, as a regular spring
/// followed by passive motions: with V the free twists, U'V = 1 and any a > 0,
///
///     K = K' - K'V (V'K'V)^-1 V'K',   K' = K + a U U'
///
/// (IROS11 eq. 9 read backwards). `length` [m] makes rotations comparable with translations. Throws
/// std::invalid_argument when the matrix is not positive semi-definite.
LinkPart part_with_free_motions(const spatial::Pose& offset, const spatial::Matrix6& stiffness,
                                double length);

/// Reads `{manipulator: FILE, at: POSE}` or `{manipulator: FILE, joints: {...}}`: the unloaded
/// stiffness of another robot file's manipulator in that posture (as of the parallelogram in
/// JAMRIS09), its base at the start of the link and its platform at the end.
LinkModel read_sub_manipulator(const io::YamlNode& node, const spatial::UnitSystem& units,
                               const LinkOptions& options, const ReadManipulator& read);

}  // namespace kinetostat::vjm
