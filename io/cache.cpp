#include "kinetostat/io/cache.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <vector>

#include "kinetostat/common/error.h"
#include "kinetostat/io/text_file.h"

namespace kinetostat::io {
namespace {

const std::string magic = "kinetostat cache 2\n";
constexpr std::size_t digest_size = 64;
constexpr const char* extension = ".entry";

// Of content and key: the name of the file alone says little, it may have been copied.
std::string seal(const std::string& key, const std::string& content) {
  return sha256(sha256(key) + sha256(content));
}

std::string sealed(const std::string& key, const std::string& content) {
  return magic + seal(key, content) + content;
}

std::optional<std::string> opened(const std::string& key, const std::string& bytes) {
  const std::size_t head = magic.size() + digest_size;
  if (bytes.size() < head || !bytes.starts_with(magic)) return std::nullopt;
  std::string content = bytes.substr(head);
  if (seal(key, content) != bytes.substr(magic.size(), digest_size)) return std::nullopt;
  return content;
}

// Not flushed to disk, which takes longer than computing many an entry: one that a crash of the
// machine cuts short is not sound, and thrown away.
bool write(const std::filesystem::path& file, const std::string& bytes) {
  try {
    write_atomically(file, bytes, Flush::no);
    return true;
  } catch (const common::InputError&) {
    return false;
  }
}

// From 0 to 1, all as likely, but the same for the same key.
double by_chance(const std::string& key) {
  return static_cast<double>(std::stoul(sha256(key).substr(0, 8), nullptr, 16)) / 0x1p32;
}

}  // namespace

Cache::Cache(std::filesystem::path folder, std::uintmax_t limit)
    : folder_(std::move(folder)), limit_(limit) {}

Cache Cache::of_user() {
  const auto variable = [](const char* name) {
    const char* value = std::getenv(name);
    return std::filesystem::path(value == nullptr ? "" : value);
  };
  // A relative path is to be ignored (XDG Base Directory Specification).
  if (const auto base = variable("XDG_CACHE_HOME"); base.is_absolute())
    return Cache(base / "kinetostat");
  if (const auto home = variable("HOME"); home.is_absolute())
    return Cache(home / ".cache" / "kinetostat");
  return {};
}

std::filesystem::path Cache::entry(const std::string& key) const {
  return folder_ / (sha256(key) + extension);
}

std::optional<std::string> Cache::find(const std::string& key) const {
  if (folder_.empty()) return std::nullopt;
  const std::filesystem::path file = entry(key);
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error)) return std::nullopt;
  try {
    std::optional<std::string> content = opened(key, read_text(file));
    if (!content) {
      std::filesystem::remove(file, error);
      return std::nullopt;
    }
    std::filesystem::last_write_time(file, std::filesystem::file_time_type::clock::now(), error);
    ++hits_;
    return content;
  } catch (const common::InputError&) {  // another process may have removed it
    return std::nullopt;
  }
}

bool Cache::keep(const std::string& key, const std::string& content) const {
  if (folder_.empty() || content.size() > limit_ / 4) return false;
  if (!write(entry(key), sealed(key, content))) return false;
  // Looking through a large folder takes longer than keeping a small entry: all processes together
  // do so once for as much as is freed ahead, for each starts at a place of its own between.
  since_room_was_made_ =
      since_room_was_made_.value_or(by_chance(key) * static_cast<double>(slack())) +
      static_cast<double>(content.size());
  if (*since_room_was_made_ > static_cast<double>(slack())) {
    make_room();
    since_room_was_made_ = 0;
  }
  return true;
}

// Files that others remove at the same time are as good as removed. What a killed process left
// half-written goes with the rest: nothing but the cache writes to this folder.
void Cache::make_room() const {
  struct Kept {
    std::filesystem::file_time_type used;
    std::uintmax_t size;
    std::filesystem::path file;
  };
  std::vector<Kept> all;
  std::uintmax_t total = 0;
  std::error_code error;
  const auto an_hour_ago = std::filesystem::file_time_type::clock::now() - std::chrono::hours(1);
  for (std::filesystem::directory_iterator file(folder_, error), end; !error && file != end;
       file.increment(error)) {
    std::error_code gone;
    const auto used = file->last_write_time(gone);
    const auto size = file->file_size(gone);
    if (gone) continue;
    if (file->path().extension() == extension) {
      all.push_back({used, size, file->path()});
      total += size;
    } else if (used < an_hour_ago) {
      std::filesystem::remove(file->path(), gone);
    }
  }
  std::sort(all.begin(), all.end(), [](const Kept& a, const Kept& b) { return a.used < b.used; });
  for (const Kept& oldest : all) {
    if (total <= limit_ - slack()) break;
    std::filesystem::remove(oldest.file, error);
    total -= oldest.size;
  }
}

}  // namespace kinetostat::io
