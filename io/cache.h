// Results that were expensive to compute, kept in a folder and found again by a key.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace kinetostat::io {

/// Entries are files named after the SHA-256 of their key, each with a SHA-256 of key and content:
/// one that was damaged, cut short or renamed is never taken for good. Any number of processes may
/// use the folder at once, each thread with an object of its own. A cache never fails: what it
/// cannot keep is computed again.
class Cache {
 public:
  /// Finds nothing and keeps nothing.
  Cache() = default;
  /// About `limit` bytes in `folder`, which is made when something is kept: it is looked through
  /// whenever an eighth of that has been kept, in the mean.
  explicit Cache(std::filesystem::path folder, std::uintmax_t limit = std::uintmax_t{1} << 30);
  /// In $XDG_CACHE_HOME/kinetostat, or ~/.cache/kinetostat. Keeps nothing when neither is known.
  static Cache of_user();

  /// It may find and keep something.
  bool enabled() const { return !folder_.empty(); }
  const std::filesystem::path& folder() const { return folder_; }  // empty: there is none

  /// The bytes kept under this key; an entry that is not sound is thrown away.
  std::optional<std::string> find(const std::string& key) const;
  /// Keeps `content`, then, now and again, removes the entries that were not used for longest until
  /// the limit is held. False when nothing was kept: too large, no space, no permission.
  bool keep(const std::string& key, const std::string& content) const;

  /// How often this object found something.
  int hits() const { return hits_; }

 private:
  std::filesystem::path entry(const std::string& key) const;
  void make_room() const;
  std::uintmax_t slack() const { return limit_ / 8; }  // space that is freed ahead

  std::filesystem::path folder_;
  std::uintmax_t limit_ = 0;
  mutable int hits_ = 0;
  mutable std::optional<double> since_room_was_made_;  // [bytes]; empty: nothing kept yet
};

}  // namespace kinetostat::io
