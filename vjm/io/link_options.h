// How links of robot files are read.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <vector>

#include "kinetostat/vjm/io/uncertainty_source.h"
#include "kinetostat/vjm/manipulator/manipulator.h"

namespace kinetostat::vjm {

class EffectKind;

/// What a user of robot files may want otherwise than it is written.
struct LinkOptions {
  int segment_multiple = 1;  // every beam in so many times the segments that the file gives it
  std::vector<std::filesystem::path> within = {};  // robot files of which this one is a part
  SourceList* sources = nullptr;  // meets all uncertain numbers; none: one of the file's own
  /// Kinds of effects that a program has and the file may name.
  std::vector<std::shared_ptr<const EffectKind>> kinds = {};
};

/// Reads the manipulator of a robot file. Throws common::InputError.
using ReadManipulator =
    std::function<Manipulator(const std::filesystem::path& file, const LinkOptions& options)>;

}  // namespace kinetostat::vjm
