#include "kinetostat/common/child_process.h"

#include <csignal>
#include <cstdio>
#include <new>
#include <stdexcept>
#include <unistd.h>

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

TEST(RunChild, PassesTheInputAndThenWhatLiesElsewhere) {
  Progress silent;
  const std::string first = "some ", second(100000, 'x'), third = " end";
  const ChildResult result = run_child({.program = "/bin/sh",
                                        .arguments = {"-c", "cat >&3"},
                                        .input = first,
                                        .time_limit = 20,
                                        .more_input = {second, third}},
                                       "test", silent);
  EXPECT_EQ(result.answer, first + second + third);
}

TEST(RunIsolated, KnowsWhatRanOutOfMemory) {
  EXPECT_TRUE(
      run_isolated([]() -> std::string { throw std::bad_alloc(); }, 20).ran_out_of_memory());
  EXPECT_FALSE(run_isolated([]() -> std::string { throw std::runtime_error("why"); }, 20)
                   .ran_out_of_memory());
}

// Waits until it has ended.
ChildResult result_of(ProcessCopy& copy) {
  for (;;)
    if (const auto result = copy.result()) return *result;
}

TEST(ProcessCopy, SaysWhatItsWorkSaysAndReturns) {
  int here = 1;
  ProcessCopy copy([&here] {
    here = 2;
    std::fputs("to one\n", stdout);
    std::fflush(stdout);
    std::fputs("to the other\n", stderr);
    return 7;
  });
  const ChildResult result = result_of(copy);
  EXPECT_EQ(result.end, ChildResult::End::exited);
  EXPECT_EQ(result.code, 7);
  EXPECT_EQ(result.words, "to one\nto the other\n");
  EXPECT_EQ(here, 1);  // what it changed was its own
}

TEST(ProcessCopy, ThatCrashesOrThrowsDoesNotTakeThisProcessAlong) {
  ProcessCopy crashed([]() -> int {
    raise(SIGKILL);
    return 0;
  });
  const ChildResult killed = result_of(crashed);
  EXPECT_EQ(killed.end, ChildResult::End::killed_by_signal);
  EXPECT_EQ(killed.code, SIGKILL);
  ProcessCopy thrown([]() -> int { throw std::runtime_error("no"); });
  EXPECT_EQ(result_of(thrown).code, 1);
}

TEST(ProcessCopy, IsKilledWithItsOwner) {
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  {
    const ProcessCopy copy([&ends] {
      close(ends[0]);
      pause();
      return 0;
    });
  }
  close(ends[1]);
  char byte = 0;
  EXPECT_EQ(read(ends[0], &byte, 1), 0);  // the end of the file: nobody else has it open
  close(ends[0]);
}

}  // namespace
}  // namespace kinetostat::common::child_process_test
