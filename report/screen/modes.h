// First screens of `modes`, of a link and of a robot.
#pragma once

#include <optional>
#include <string>

#include "kinetostat/fea/link/modal_study.h"
#include "kinetostat/io/json.h"
#include "kinetostat/vjm/io/robot_file.h"
#include "kinetostat/vjm/uncertainty/draws.h"
#include "kinetostat/vjm/vibration/frequency_response.h"
#include "kinetostat/vjm/vibration/natural_modes.h"

namespace kinetostat::report {

/// "foot, clamped at base: first natural frequency 812 Hz; each of 6 is known within 0.8 %."
std::string headline(const fea::ModalResult& result);
/// Headline and a row per mode.
std::string first_screen(const fea::ModalResult& result);

/// Modes in a posture, and the largest change of a frequency with every beam in twice the segments,
/// beside it; none where there are no beams. The response of the platform where it was asked for.
struct RobotModes {
  vjm::NaturalModes found;
  bool is_loaded = false;  // about an equilibrium under load
  std::optional<double> lumping_error = {};
  std::optional<vjm::FrequencyResponse> response = {};
  vjm::Damping damping = {};
  std::optional<vjm::Uncertainty> uncertainty = {};  // of the frequencies, in their order
};
/// "First natural frequency 8.31 Hz +- 4 %: of what yields, 57 % is joint q2 and 21 % joint q3. Of
/// its uncertainty, 62 % is stiffness of q2."
std::string headline(const vjm::Robot& robot, const RobotModes& modes);
/// Headline and a row per mode: how the platform moves, and what gives way; along each axis where
/// its response is largest.
std::string first_screen(const vjm::Robot& robot, const RobotModes& modes);
/// docs/reference/modes.md
io::Json to_json(const vjm::Robot& robot, const RobotModes& modes);

}  // namespace kinetostat::report
