// Who works on what, where several processes share a folder.
#pragma once

#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <map>
#include <mutex>
#include <string>
#include <thread>

namespace kinetostat::io {

/// A claim is a file that its owner touches again and again. One that was not touched for so long
/// has no owner any more: the process was killed, or its machine is off. Ages are by the clock of
/// the file system, which machines share. Claims save work and guarantee nothing: two processes
/// may hold the same one when both find it expired at once, or when its owner was stopped for that
/// long. Any thread may call.
class Claims {
 public:
  static constexpr std::chrono::milliseconds usual_expiry = std::chrono::seconds(30);

  /// Makes the folder. Throws common::InputError where no file can be written in it.
  explicit Claims(std::filesystem::path folder, std::chrono::milliseconds expiry = usual_expiry);
  Claims(const Claims&) = delete;
  Claims& operator=(const Claims&) = delete;
  /// Gives up all.
  ~Claims();

  /// False while somebody holds the claim of that name, by this object or another one. True as well
  /// where the folder takes no file any more.
  bool claim(const std::string& name);
  void give_up(const std::string& name);

 private:
  std::filesystem::path file_of(const std::string& name) const;
  bool is_expired(const std::filesystem::path& file) const;
  void remove(const std::filesystem::path& file, int descriptor) const;
  void renew(const std::stop_token& over);

  std::filesystem::path folder_;
  std::chrono::milliseconds expiry_;
  int clock_;  // a file without a name: touched, it has the time of the folder
  std::map<std::string, int> held_;  // descriptors of the files; -1: it could not be made
  std::mutex mutex_;
  std::condition_variable_any ends_;
  std::jthread renewer_;  // last, so that it ends before what it uses
};

}  // namespace kinetostat::io
