#include "kinetostat/apps/cli/cancellation.h"

#include <atomic>
#include <csignal>
#include <cstdint>
#include <ctime>
#include <unistd.h>

namespace kinetostat::apps {
namespace {

// A signal handler can reach nothing but globals; every thread asks.
std::atomic<int> received = 0;
std::atomic<std::int64_t> received_at = 0;  // [ns]
static_assert(std::atomic<int>::is_always_lock_free);
static_assert(std::atomic<std::int64_t>::is_always_lock_free);

constexpr std::int64_t same_press = 300'000'000;  // [ns]

constexpr unsigned grace = 10;  // [s]

void end_at_once(int) { _exit(128 + received); }

std::int64_t now() {
  timespec time = {};
  clock_gettime(CLOCK_MONOTONIC, &time);
  return std::int64_t{1'000'000'000} * time.tv_sec + time.tv_nsec;
}

// Whoever types Ctrl-C can type it again, to end the process at once; who sends SIGTERM has gone.
// Those who start processes (timeout, shells) send a process and its group the same signal.
void remember(int signal) {
  if (received != 0) {
    if (now() - received_at < same_press) return;
    std::signal(signal, SIG_DFL);
    raise(signal);
    return;
  }
  received_at = now();
  received = signal;
  if (signal == SIGTERM) alarm(grace);
}

void handle(int signal, void (*handler)(int), int flags) {
  struct sigaction action = {};
  action.sa_handler = handler;
  action.sa_flags = flags;
  sigaction(signal, &action, nullptr);
}

}  // namespace

void catch_signals() {
  handle(SIGINT, remember, SA_RESTART);
  handle(SIGTERM, remember, SA_RESTART);
  handle(SIGALRM, end_at_once, 0);
  handle(SIGXFSZ, SIG_IGN, 0);  // writing fails and says so, instead
}

int cancelling_signal() { return received; }

}  // namespace kinetostat::apps
