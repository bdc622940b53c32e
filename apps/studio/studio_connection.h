// One connection to the studio, which may not hold its thread for longer than a request needs.
#pragma once

#include <array>
#include <chrono>
#include <functional>
#include <httplib.h>

namespace kinetostat::apps {

struct ConnectionLimits {
  std::chrono::milliseconds request;   // until all of it has come
  std::chrono::milliseconds response;  // until all of it has gone, from its first byte
  std::size_t bytes;                   // of a request, head included
};

/// The bytes of a socket, until a limit is reached; from then on reading and writing fail. `over`
/// is asked ten times a second, with the time that reading (or answering) has taken so far, whether
/// to give up earlier. Does not own the socket.
class StudioConnection : public httplib::Stream {
 public:
  using GiveUp = std::function<bool(std::chrono::milliseconds)>;

  StudioConnection(socket_t socket, const ConnectionLimits& limits, GiveUp over);

  bool is_readable() const override;
  bool is_writable() const override;
  ssize_t read(char* to, std::size_t size) override;
  ssize_t write(const char* from, std::size_t size) override;
  using Stream::write;
  void get_remote_ip_and_port(std::string& ip, int& port) const override;
  void get_local_ip_and_port(std::string& ip, int& port) const override;
  socket_t socket() const override { return socket_; }

  /// Says that nothing more will come, and waits for the other side to have read it all: an answer
  /// to a request of which a part was not read would be lost otherwise.
  void finish();

 private:
  using Clock = std::chrono::steady_clock;

  void begin(std::chrono::milliseconds limit);
  bool wait_for(short event) const;
  bool fill();

  socket_t socket_;
  ConnectionLimits limits_;
  GiveUp over_;
  Clock::time_point begin_ = Clock::now();  // of what it does now: read the request, or answer
  std::chrono::milliseconds limit_;
  bool answers_ = false;
  std::array<char, 4096> buffer_{};
  std::size_t at_ = 0, filled_ = 0, read_ = 0;
};

}  // namespace kinetostat::apps
