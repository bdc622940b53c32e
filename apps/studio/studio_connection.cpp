#include "kinetostat/apps/studio/studio_connection.h"

#include <algorithm>
#include <cstring>
#include <poll.h>
#include <sys/socket.h>

namespace kinetostat::apps {
namespace {

using std::chrono::milliseconds;

constexpr milliseconds look_up{100};  // for reasons to give up
constexpr milliseconds farewell{300};

}  // namespace

StudioConnection::StudioConnection(socket_t socket, const ConnectionLimits& limits, GiveUp over)
    : socket_(socket), limits_(limits), over_(std::move(over)), limit_(limits.request) {}

void StudioConnection::begin(milliseconds limit) {
  begin_ = Clock::now();
  limit_ = limit;
}

bool StudioConnection::wait_for(short event) const {
  while (true) {
    const auto taken = std::chrono::duration_cast<milliseconds>(Clock::now() - begin_);
    if (taken >= limit_ || over_(taken)) return false;
    const milliseconds left = limit_ - taken;
    pollfd one{socket_, event, 0};
    const int found = poll(&one, 1, static_cast<int>(std::min(left, look_up).count()));
    if (found < 0 && errno != EINTR) return false;
    if (found > 0) return true;
  }
}

bool StudioConnection::fill() {
  if (read_ >= limits_.bytes || !wait_for(POLLIN)) return false;
  const ssize_t got = recv(socket_, buffer_.data(), buffer_.size(), MSG_DONTWAIT);
  at_ = 0;
  filled_ = got > 0 ? static_cast<std::size_t>(got) : 0;
  read_ += filled_;
  return filled_ > 0;
}

bool StudioConnection::is_readable() const { return at_ < filled_ || wait_for(POLLIN); }

bool StudioConnection::is_writable() const { return wait_for(POLLOUT); }

ssize_t StudioConnection::read(char* to, std::size_t size) {
  if (at_ == filled_ && !fill()) return -1;
  const std::size_t count = std::min(size, filled_ - at_);
  std::memcpy(to, buffer_.data() + at_, count);
  at_ += count;
  return static_cast<ssize_t>(count);
}

ssize_t StudioConnection::write(const char* from, std::size_t size) {
  if (!answers_) begin(limits_.response);
  answers_ = true;
  if (!is_writable()) return -1;
  return send(socket_, from, size, MSG_DONTWAIT | MSG_NOSIGNAL);
}

// Whoever asks is on this machine, and nobody asks who it is.
void StudioConnection::get_remote_ip_and_port(std::string& ip, int& port) const {
  ip.clear();
  port = 0;
}
void StudioConnection::get_local_ip_and_port(std::string& ip, int& port) const {
  get_remote_ip_and_port(ip, port);
}

void StudioConnection::finish() {
  shutdown(socket_, SHUT_WR);
  begin(farewell);
  while (wait_for(POLLIN))
    if (recv(socket_, buffer_.data(), buffer_.size(), MSG_DONTWAIT) <= 0) return;
}

}  // namespace kinetostat::apps
