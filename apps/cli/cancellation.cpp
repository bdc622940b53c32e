#include "kinetostat/apps/cli/cancellation.h"

#include <atomic>
#include <csignal>
#include <unistd.h>

namespace kinetostat::apps {
namespace {

// A signal handler can reach nothing but globals; every thread asks.
std::atomic<int> received = 0;
static_assert(std::atomic<int>::is_always_lock_free);

constexpr unsigned grace = 10;  // [s]

void end_at_once(int) { _exit(128 + received); }

// Whoever types Ctrl-C can type it again; who sends SIGTERM has gone.
void remember(int signal) {
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
  constexpr int once = static_cast<int>(SA_RESETHAND | SA_RESTART);
  handle(SIGINT, remember, once);
  handle(SIGTERM, remember, once);
  handle(SIGALRM, end_at_once, 0);
  handle(SIGXFSZ, SIG_IGN, 0);  // writing fails and says so, instead
}

int cancelling_signal() { return received; }

}  // namespace kinetostat::apps
