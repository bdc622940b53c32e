#include "kinetostat/common/child_process.h"

#include <new>
#include <stdexcept>

#include <gtest/gtest.h>

namespace kinetostat::common::child_process_test {
namespace {

ChildResult shell(const std::string& script, double time_limit = 20) {
  Progress silent;
  return run_child(
      {.program = "/bin/sh", .arguments = {"-c", script}, .input = {}, .time_limit = time_limit},
      "test", silent);
}

TEST(RunChild, KnowsWhatRanOutOfMemory) {
  EXPECT_TRUE(shell("exit 65").ran_out_of_memory());
  EXPECT_TRUE(shell("kill -KILL $$").ran_out_of_memory());  // as the system does
  EXPECT_TRUE(shell("exit 137").ran_out_of_memory());       // as mpirun says that
  EXPECT_TRUE(
      shell("echo \"terminate called: 'std::bad_alloc'\"; kill -ABRT $$").ran_out_of_memory());
  EXPECT_TRUE(shell("echo 'error while loading shared libraries: libc.so: failed to map segment'; "
                    "exit 127")
                  .ran_out_of_memory());
}

TEST(RunChild, KnowsWhatDidNot) {
  EXPECT_FALSE(shell("exit 0").ran_out_of_memory());
  EXPECT_FALSE(shell("exit 1").ran_out_of_memory());
  EXPECT_FALSE(shell("kill -SEGV $$").ran_out_of_memory());
  EXPECT_FALSE(shell("echo 'error while loading shared libraries: libx.so: No such file'; exit 127")
                   .ran_out_of_memory());
  EXPECT_FALSE(shell("exec sleep 600", 0.2).ran_out_of_memory());  // killed by us
}

TEST(RunIsolated, KnowsWhatRanOutOfMemory) {
  EXPECT_TRUE(
      run_isolated([]() -> std::string { throw std::bad_alloc(); }, 20).ran_out_of_memory());
  EXPECT_FALSE(run_isolated([]() -> std::string { throw std::runtime_error("why"); }, 20)
                   .ran_out_of_memory());
}

}  // namespace
}  // namespace kinetostat::common::child_process_test
