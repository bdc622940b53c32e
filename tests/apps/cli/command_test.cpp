#include "kinetostat/apps/cli/command.h"

#include <cerrno>
#include <csignal>
#include <fstream>
#include <new>
#include <sstream>
#include <system_error>
#include <unistd.h>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/apps/cli/cancellation.h"
#include "kinetostat/common/error.h"
#include "kinetostat/io/text_file.h"

#include "support/temporary_folder.h"

namespace kinetostat::apps::command_test {
namespace {

using testing::HasSubstr;
using testing::Not;

// A stream that collects what is printed to it.
class Memory {
 public:
  Memory() : stream_(open_memstream(&text_, &size_)) {}
  Memory(const Memory&) = delete;
  Memory& operator=(const Memory&) = delete;
  ~Memory() {
    std::fclose(stream_);
    std::free(text_);
  }
  std::FILE* stream() { return stream_; }
  std::string text() {
    std::fflush(stream_);
    return {text_, size_};
  }

 private:
  char* text_ = nullptr;
  std::size_t size_ = 0;
  std::FILE* stream_;
};

struct Outcome {
  int code;
  std::string out, err;
};

// Runs a program with two commands: "weigh", which does what `action` does, and "mesh check".
Outcome run(std::vector<const char*> arguments, const Action& action, const std::string& out = {}) {
  Memory standard_output, standard_error;
  Program program({standard_output.stream(), standard_error.stream()});
  double load = 3;
  OptionList weigh =
      program.add({"weigh", "Weigh a thing", "kinetostat weigh thing.yaml", out}, action);
  std::string file;
  weigh.add_option("THING", file, "What to weigh").required();
  weigh.add_option("--load", load, "The load");
  program.add({"mesh check", "Check a mesh", "kinetostat mesh check a.stl"}, [](apps::Run&) {
    return io::Json{{"checked", true}};
  });
  arguments.insert(arguments.begin(), "kinetostat");
  const int code = program.run(static_cast<int>(arguments.size()), arguments.data());
  return {code, standard_output.text(), standard_error.text()};
}

io::Json weigh(Run& run) {
  run.print("7 kg\n");
  return {{"mass", 7}};
}

Outcome run_throwing(const std::function<void()>& fail) {
  return run({"weigh", "thing.yaml"}, [&](apps::Run&) -> io::Json {
    fail();
    return {};
  });
}

TEST(Program, WithoutArgumentsShowsEveryCommandInItsGroup) {
  const Outcome outcome = run({}, weigh);
  EXPECT_EQ(outcome.code, 0);
  const std::size_t links = outcome.out.find("\nLinks\n  mesh check ");
  ASSERT_NE(links, std::string::npos) << outcome.out;
  EXPECT_GT(outcome.out.find("\nOthers\n  weigh           Weigh a thing\n"), links);
}

// 80 columns, whatever a command says of itself.
TEST(Program, HelpIsNoWiderThanATerminal) {
  Memory standard_output, standard_error;
  Program program({standard_output.stream(), standard_error.stream()});
  std::string words;
  for (int i = 0; i < 40; ++i) words += (i > 0 ? " a" : "a") + std::string("word");
  std::string file;
  program
      .add({.name = "weigh", .summary = words, .example = "kinetostat weigh " + words},
           [](apps::Run&) { return io::Json{}; })
      .add_option("--with-a-long-name", file, words);
  const char* arguments[] = {"kinetostat", "weigh", "--help"};
  EXPECT_EQ(program.run(3, arguments), 0);
  std::istringstream lines(standard_output.text());
  std::size_t count = 0;
  for (std::string line; std::getline(lines, line);) count += line.find("aword") != line.npos;
  EXPECT_GE(count, 9u);
  for (std::istringstream again(standard_output.text()); std::getline(again, words);)
    EXPECT_LE(words.size(), 80u) << words;
}

TEST(Program, EchoesOptionsInEffectBeforeTheReportWhenVerbose) {
  EXPECT_EQ(run({"weigh", "thing.yaml"}, weigh).out, "7 kg\n");
  const Outcome outcome = run({"weigh", "thing.yaml", "--verbose"}, weigh);
  EXPECT_EQ(outcome.code, 0);
  EXPECT_EQ(outcome.out, "kinetostat weigh\n  THING  thing.yaml\n  load   3\n\n7 kg\n");
}

// The file has it all, standard output what was asked for.
TEST(Program, MoreIsPrintedWhenVerbose) {
  const test::TemporaryFolder folder;
  const std::string file = folder.path() / "report.txt";
  const auto more = [](apps::Run& run) {
    run.print_more("in detail\n");
    return weigh(run);
  };
  EXPECT_EQ(run({"weigh", "t", "-o", file.c_str()}, more).out, "7 kg\n");
  EXPECT_EQ(io::read_text(file), "in detail\n7 kg\n");
  EXPECT_THAT(run({"weigh", "t", "-v"}, more).out, testing::EndsWith("in detail\n7 kg\n"));
}

TEST(Program, QuietPrintsTheReportOnly) {
  EXPECT_EQ(run({"weigh", "thing.yaml", "--quiet"}, weigh).out, "7 kg\n");
}

TEST(Program, ThreadsDoNotChangeTheOutput) {
  EXPECT_EQ(run({"weigh", "t", "--threads", "1"}, weigh).out,
            run({"weigh", "t", "--threads", "2"}, weigh).out);
}

TEST(Program, JsonOnStandardOutputIsAllThatIsThere) {
  const Outcome outcome = run({"weigh", "thing.yaml", "--load", "4", "--json", "-"}, weigh);
  const io::Json json = io::Json::parse(outcome.out);
  EXPECT_EQ(json["mass"], 7);
  EXPECT_EQ(json["command"], "weigh");
  EXPECT_EQ(json["options"]["load"], "4");
}

TEST(Program, OutHoldsTheReportUnlessTheCommandWritesItItself) {
  const test::TemporaryFolder folder;
  const std::string file = folder.path() / "report.txt";
  EXPECT_EQ(run({"weigh", "t", "-o", file.c_str()}, weigh).code, 0);
  EXPECT_EQ(io::read_text(file), "7 kg\n");

  std::filesystem::remove(file);
  const auto own = [](apps::Run& run) {
    io::write_atomically(run.out().value(), "own product");
    return weigh(run);
  };
  EXPECT_EQ(run({"weigh", "t", "-o", file.c_str()}, own, "The product").code, 0);
  EXPECT_EQ(io::read_text(file), "own product");
}

TEST(Program, ExitCodesSayWhatWentWrong) {
  const auto code = [](const std::function<void()>& fail) { return run_throwing(fail).code; };
  EXPECT_EQ(code([] {}), 0);
  EXPECT_EQ(code([] { throw std::logic_error("broken"); }), 1);
  EXPECT_EQ(code([] { throw UsageError("--at", "'1,2' has 2 values"); }), 2);
  EXPECT_EQ(code([] { throw common::InputError("a.yaml", "is odd"); }), 3);
  EXPECT_EQ(code([] { throw common::NoConvergence("stopped at 1e-3"); }), 4);
  EXPECT_EQ(code([] { throw common::NotIdentifiable("no load along z"); }), 5);
}

TEST(Program, MessagesOfFailuresReachStandardError) {
  EXPECT_EQ(run_throwing([] { throw common::InputError("a.yaml", "is odd", "Make it even"); }).err,
            "kinetostat: a.yaml: is odd. Make it even.\n");
  EXPECT_THAT(run_throwing([] { throw std::logic_error("broken"); }).err,
              HasSubstr("please report it"));
}

TEST(Program, MistakesInAFileNameThePageThatDescribesIt) {
  const test::TemporaryFolder folder;
  const std::tuple<const char*, const char*, const char*> files[] = {
      {"arm.yaml", "kinetostat: 1\nmanipulator: {}\n",
       "a robot file, described in docs/reference/robot"},
      {"b.yaml", "kinetostat: 1\nname: b\nlinkz: {}\n",
       "a robot file, described in docs/reference/robot"},
      {"c.yaml", "kinetostat: 1\ncampaign: c\n",
       "a campaign file, described in docs/reference/campaign"},
      {"d.yml", "link: d\n", "a link file, described in docs/reference/link"},
      {"r.csv", "# notes\nid,fz,dz\n", "columns are described in docs/reference/campaign"}};
  for (const auto& [name, text, page] : files) {
    const std::filesystem::path file = folder.path() / name;
    io::write_atomically(file, text);
    EXPECT_THAT(run_throwing([&] { throw common::InputError(file, "is odd"); }).err,
                HasSubstr(page));
  }
  const std::filesystem::path poses = folder.path() / "path.csv";
  io::write_atomically(poses, "x,y,z\n");
  EXPECT_THAT(run_throwing([&] { throw common::InputError(poses, "is odd"); }).err,
              testing::Not(HasSubstr("docs/")));
}

TEST(Program, PageHoldsResultAndReport) {
  if (!report::has_pages()) GTEST_SKIP() << "built without pages";
  const test::TemporaryFolder folder;
  const std::string file = folder.path() / "page.html";
  const auto draw = [](apps::Run& run) {
    EXPECT_TRUE(run.wants_page());
    run.draw({{"scale", 2}});
    return weigh(run);
  };
  EXPECT_EQ(run({"weigh", "t", "--html", file.c_str()}, draw).code, 0);
  const auto results = report::read_page_results(file);
  ASSERT_EQ(results.size(), 1u);
  EXPECT_EQ(results[0].result["mass"], 7);
  EXPECT_EQ(results[0].result["command"], "weigh");
  EXPECT_EQ(results[0].picture["scale"], 2);
  EXPECT_EQ(results[0].text, "7 kg\n");
}

TEST(Program, PartOfAResultIsDeliveredAndExitsAsNotConverged) {
  const Outcome outcome = run({"weigh", "t", "-q"}, [](apps::Run& run) {
    run.print("so far\n");
    run.stop_short("the scale still swings");
    return io::Json{};
  });
  EXPECT_EQ(outcome.code, 4);
  EXPECT_EQ(outcome.out, "so far\n");
  EXPECT_THAT(outcome.err, HasSubstr("still swings"));
}

TEST(Program, HelpOfACommandStartsWithItsOwnOptions) {
  const std::string help = run({"weigh", "--help"}, weigh).out;
  EXPECT_LT(help.find("--load"), help.find("--json"));
  EXPECT_THAT(help, HasSubstr("kinetostat weigh thing.yaml"));
}

TEST(Program, OneFileIsNotWrittenTwice) {
  EXPECT_EQ(run({"weigh", "t", "--json", "same", "--out", "same"}, weigh).code, 2);
  EXPECT_EQ(run({"weigh", "t", "--html", "same", "--json", "same"}, weigh).code, 2);
}

TEST(Program, BadUsageIsRefusedWithAHint) {
  const Outcome command = run({"wiegh", "thing.yaml"}, weigh);
  EXPECT_EQ(command.code, 2);
  EXPECT_THAT(command.err, HasSubstr("Did you mean 'weigh'?"));
  const Outcome option = run({"weigh", "thing.yaml", "--laod=3"}, weigh);
  EXPECT_EQ(option.code, 2);
  EXPECT_THAT(option.err, HasSubstr("Did you mean '--load'?"));
  EXPECT_EQ(run({"weigh"}, weigh).code, 2);
  EXPECT_EQ(run({"mesh"}, weigh).code, 2);
  EXPECT_EQ(run({"weigh", "thing.yaml", "--threads", "0"}, weigh).code, 2);
}

TEST(Program, CommandsInGroupsAreFound) {
  const Outcome outcome = run({"mesh", "check", "--json", "-"}, weigh);
  EXPECT_EQ(outcome.code, 0);
  EXPECT_EQ(io::Json::parse(outcome.out)["checked"], true);
}

TEST(Program, FullDiskBehindStandardOutputIsAnError) {
  std::FILE* full = std::fopen("/dev/full", "w");
  ASSERT_NE(full, nullptr);
  Memory standard_error;
  Program program({full, standard_error.stream()});
  const char* arguments[] = {"kinetostat", "--version"};
  EXPECT_EQ(program.run(2, arguments), 3);
  EXPECT_THAT(standard_error.text(), HasSubstr("standard output"));
  std::fclose(full);
}

TEST(Program, RunningOutOfMemoryHasAnExitCodeOfItsOwn) {
  for (const Outcome& outcome : {run_throwing([] { throw std::bad_alloc(); }), run_throwing([] {
                                   throw std::system_error(
                                       EAGAIN,
                                       std::generic_category());  // no memory for a thread's stack
                                 })}) {
    EXPECT_EQ(outcome.code, out_of_memory);
    EXPECT_THAT(outcome.err, HasSubstr("not enough memory"));
  }
  EXPECT_EQ(run_throwing([] { throw std::system_error(EBADF, std::generic_category()); }).code,
            failure);
}

TEST(Program, WhatOthersWroteCommandsNoTerminal) {
  const Outcome outcome = run({"weigh", "thing\x1b[2J", "-v"}, [](apps::Run& run) {
    run.print("\x1b]0;title\x07 7 kg\n");
    run.warn("\x9b and \xc2\x9b");
    return io::Json{};
  });
  EXPECT_THAT(outcome.out, HasSubstr("?]0;title? 7 kg\n"));
  EXPECT_THAT(outcome.out, HasSubstr("thing?[2J"));
  EXPECT_THAT(outcome.err, HasSubstr("? and ?\n"));
}

TEST(Program, FullDiskBehindStandardErrorChangesNoExitCode) {
  std::FILE* full = std::fopen("/dev/full", "w");
  ASSERT_NE(full, nullptr);
  Memory standard_output;
  const char* unknown[] = {"kinetostat", "--unknown"};
  EXPECT_EQ(Program({standard_output.stream(), full}).run(2, unknown), bad_usage);
  Program program({standard_output.stream(), full});
  program.add({"weigh", "Weigh a thing", "kinetostat weigh"}, [](apps::Run& run) -> io::Json {
    run.warn("heavy");
    run.progress().report("weighing", 0.5);
    throw common::InputError("thing", "is odd");
  });
  const char* arguments[] = {"kinetostat", "weigh"};
  EXPECT_EQ(program.run(2, arguments), bad_input);
  std::fclose(full);
}

// As in a loop of a library that asks nobody. Ten seconds later it has ended all the same: here one
// second later, to save time.
TEST(ProgramDeathTest, TerminationEndsWhatDoesNotListen) {
  const auto deaf = [] {
    catch_signals();
    std::raise(SIGTERM);
    if (alarm(1) != 10) std::exit(1);
    while (true) pause();
  };
  EXPECT_EXIT(deaf(), testing::ExitedWithCode(128 + SIGTERM), "");
}

// The signal stays received for the rest of the process, so this runs in a child.
TEST(ProgramDeathTest, TerminationStopsAtTheNextReportAndWritesNothing) {
  const test::TemporaryFolder folder;
  const std::string file = folder.path() / "never.json";
  const auto stopped = [&] {
    catch_signals();
    const Outcome outcome = run({"weigh", "t", "--json", file.c_str()}, [](apps::Run& run) {
      std::raise(SIGTERM);
      run.progress().report("weighing", 0.5);
      return io::Json{};
    });
    std::exit(outcome.code);
  };
  EXPECT_EXIT(stopped(), testing::ExitedWithCode(128 + SIGTERM), "");
  EXPECT_FALSE(std::filesystem::exists(file));
}

}  // namespace
}  // namespace kinetostat::apps::command_test
