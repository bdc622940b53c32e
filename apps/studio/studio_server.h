// The door of a studio: loopback only, a token in every address.
#pragma once

#include <functional>
#include <map>
#include <string>

#include "kinetostat/apps/studio/studio_job.h"
#include "kinetostat/io/json.h"

namespace kinetostat::apps {

/// Answers of the server.
struct StudioRooms {
  std::string page;  // HTML
  /// Name -> what a POST of a JSON object to it does. One call at a time, and none while a job
  /// runs. Exceptions that derive from std::exception become an answer that says what was wrong.
  std::map<std::string, std::function<io::Json(const io::Json&)>> actions;
  /// The same for what takes long: a POST starts it; one to "progress" answers
  /// StudioJob::status(), one to "stop" stops it.
  std::map<std::string, std::function<io::Json(const io::Json&, StudioJob&)>> jobs;
};

struct StudioOptions {
  int port = 0;  // 0: any that is free
  /// Called once, before the first request, with the address to open.
  std::function<void(const std::string&)> opened;
  /// Looked at ten times a second; the server ends when it is true.
  std::function<bool()> stopped;
};

inline constexpr std::size_t studio_largest_request = 65536;  // [bytes]
inline constexpr std::size_t studio_largest_file = std::size_t{16}
                                                   << 20;  // that "drop" may bring [bytes]
inline constexpr int studio_read_seconds = 5;              // that a request may pause for
inline constexpr int studio_keep_alive_seconds = 1;        // until a connection says something

/// Serves until stopped. Requests are refused that come under another host name or from another
/// origin, that do not know the token, are too large, or ask for anything else than the page and
/// the actions; nothing of the disk is served. Throws common::InputError when the port is
/// taken.
void serve_studio(const StudioRooms& rooms, const StudioOptions& options);

}  // namespace kinetostat::apps
