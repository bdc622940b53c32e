#include "kinetostat/apps/cancellation.h"

#include <atomic>
#include <csignal>

namespace kinetostat::apps {
namespace {

// A signal handler can reach nothing but globals; every thread asks.
std::atomic<int> received = 0;
static_assert(std::atomic<int>::is_always_lock_free);

void remember(int signal) { received = signal; }

}  // namespace

void catch_signals() {
  struct sigaction action = {};
  action.sa_handler = remember;
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_RESTART);
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
}

int cancelling_signal() { return received; }

}  // namespace kinetostat::apps
