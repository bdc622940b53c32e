// Every reader of the product behind one interface: bytes in, nothing or a documented refusal out.
#pragma once

#include <filesystem>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

namespace kinetostat::fuzz {

/// The reader did what it never may: an answer that cannot be, or a refusal of its own kind.
struct Wrong : std::logic_error {
  using std::logic_error::logic_error;
};

struct Reader {
  std::string name;
  std::vector<std::string> sound;        // files that it reads without a complaint
  std::vector<std::string> others = {};  // more to take parts from
  /// Throws common::InputError, NoConvergence or NotIdentifiable for what it refuses; anything else
  /// is a fault.
  std::function<void(const std::string& bytes)> read;
  /// Makes a file of what a sound file has under its checksum, or in compressed form; empty: there
  /// is no such thing.
  std::function<std::string(const std::string& content)> sealed = {};
  std::vector<std::string> contents = {};  // sound ones for sealed()
};

/// `folder` is for files, and gets the shipped data beside them.
std::vector<Reader> all_readers(const std::filesystem::path& folder);

}  // namespace kinetostat::fuzz
