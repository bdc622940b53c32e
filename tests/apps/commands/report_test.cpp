// `kinetostat report` and `kinetostat new` as their users meet them.
#include <filesystem>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/io/json.h"
#include "kinetostat/io/text_file.h"

#include "apps/run_program.h"

namespace kinetostat::report_test {
namespace {

using test::kinetostat;
using test::Outcome;
using test::working_folder;
using testing::HasSubstr;

bool has_pages() { return kinetostat("report data/links/foot.link.json -o probe.html").code == 0; }

TEST(ReportCommand, TakesPagesAndResults) {
  if (!has_pages()) GTEST_SKIP() << "built without pages";
  ASSERT_EQ(
      kinetostat("stiffness data/robots/orthoglide.yaml --at 0,0,0 --html report_a.html").code, 0);
  const Outcome outcome =
      kinetostat("report report_a.html data/links/foot.link.json -o report_b.html");
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("report_a.html: stiffness: Orthoglide 3-PUU"));
  EXPECT_THAT(outcome.out, HasSubstr("foot.link.json: foot"));
  // A merged page can be merged again.
  EXPECT_THAT(kinetostat("report report_b.html -o report_c.html").out,
              HasSubstr("report_b.html: foot"));
}

TEST(ReportCommand, RefusesWhatItCannotShow) {
  EXPECT_EQ(kinetostat("report data/links/foot.link.json").code, 2);
  EXPECT_EQ(kinetostat("report nowhere.json -o report_d.html").code, 3);
  const Outcome outcome = kinetostat("report data/robots/bench.yaml -o report_d.html");
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("neither a result nor a page"));
  EXPECT_FALSE(std::filesystem::exists(working_folder() / "report_d.html"));
  io::write_atomically(working_folder() / "empty.json", "{\"rows\": []}");
  EXPECT_THAT(kinetostat("report empty.json -o report_d.html").err,
              HasSubstr("neither a result nor a page"));
  // Writing it out again would take more stack than there is.
  const std::string deep(100'000, '[');
  io::write_atomically(working_folder() / "deep.json",
                       "{\"a\": " + deep + std::string(100'000, ']') + "}");
  EXPECT_EQ(kinetostat("report deep.json -o report_d.html").code, 3);
}

TEST(NewCommand, WritesFilesThatRunAsPrinted) {
  for (const std::string word : {"link", "robot", "campaign"}) {
    ASSERT_EQ(kinetostat("new " + word + " new_" + word + " --json new.json").code, 0);
    const io::Json json = io::Json::parse(io::read_text(working_folder() / "new.json"));
    ASSERT_GE(json["next"].size(), 2u);
    for (const io::Json& line : json["next"]) {
      const auto command = line.get<std::string>().substr(std::string("kinetostat ").size());
      if (command.find("--html") != std::string::npos && !has_pages()) continue;
      if (command.starts_with("diagnose")) continue;  // the tutorial runs it
      EXPECT_EQ(kinetostat(command).code, 0) << command;
    }
  }
}

TEST(NewCommand, WritesOverNothing) {
  ASSERT_EQ(kinetostat("new robot new_twice").code, 0);
  const Outcome outcome = kinetostat("new robot new_twice");
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("is there already"));
  for (const std::string& folder : {std::string("/proc/x"), std::string(300, 'x')}) {
    const Outcome impossible = kinetostat("new robot " + folder);
    EXPECT_EQ(impossible.code, 3);
    EXPECT_THAT(impossible.err, HasSubstr("Check the path"));
  }
  // Measurements of a robot that is there already.
  EXPECT_EQ(kinetostat("new campaign new_twice").code, 0);
}

}  // namespace
}  // namespace kinetostat::report_test
