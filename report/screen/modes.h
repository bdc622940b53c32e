// First screen of `modes`.
#pragma once

#include <string>

#include "kinetostat/fea/link/modal_study.h"

namespace kinetostat::report {

/// "foot, clamped at base: first natural frequency 812 Hz; each of 6 is known within 0.8 %."
std::string headline(const fea::ModalResult& result);
/// Headline and a row per mode.
std::string first_screen(const fea::ModalResult& result);

}  // namespace kinetostat::report
