// A robot with its links as beams and by finite elements: as people who make the robots by hand.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/io/json.h"
#include "kinetostat/io/text_file.h"

#include "apps/run_program.h"

namespace kinetostat::link_models_test {
namespace {

using test::kinetostat;
using test::Outcome;
using test::working_folder;
using testing::HasSubstr;

io::Json json_of(const std::string& name) { return io::read_json(working_folder() / name); }

// What `beam` and `identify` have of a link, each model in a file of its own.
void write_models(const std::string& link) {
  ASSERT_EQ(kinetostat(fmt::format("beam meshes/{0}.yaml --json {0}.json", link)).code, 0);
  const io::Json beams = json_of(link + ".json");
  for (int m = 0; m < 2; ++m)
    io::write_json(working_folder() / fmt::format("{}_{}.json", link, m), beams["models"][m]);
  io::write_json(working_folder() / (link + "_2.json"),
                 json_of("data/links/" + link + ".link.json"));
}

// The shipped Orthoglide with links from these files.
std::string by_hand(const std::string& foot, const std::string& bar) {
  std::string text = io::read_text(working_folder() / "data/robots/orthoglide_fea.yaml");
  const auto take = [&](const std::string& old, const std::string& file) {
    text.replace(text.find(old), old.size(), file);
  };
  take("../links/foot.link.json, link_file: ../../meshes/foot.yaml", foot);
  take("../links/bar.link.json, link_file: ../../meshes/bar.yaml", bar);
  io::write_atomically(working_folder() / "by_hand.yaml", text);
  return "by_hand.yaml";
}

double stiffness_along(const std::string& robot, const io::Json& direction) {
  EXPECT_EQ(kinetostat("stiffness " + robot + " --json s.json").code, 0);
  const io::Json compliance = json_of("s.json")["unloaded"]["compliance"]["matrix"];
  double yields = 0;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k)
      yields +=
          direction[i].get<double>() * compliance[i][k].get<double>() * direction[k].get<double>();
  return 1 / yields;
}

void expect_robots_made_by_hand(const io::Json& models) {
  for (const char* link : {"foot", "bar"}) write_models(link);
  // It is alike in all directions.
  const io::Json direction = {1, 0, 0};
  const double reference = stiffness_along(by_hand("foot_2.json", "bar_2.json"), direction);
  for (int m = 0; m < 3; ++m) {
    const io::Json& row = models[m];
    const std::string own = fmt::format("foot_{}.json", m), leg = fmt::format("bar_{}.json", m);
    EXPECT_NEAR(row["value"].get<double>(), stiffness_along(by_hand(own, leg), direction),
                1e-4 * reference);
    if (m == 2) continue;
    EXPECT_NEAR(row["by_link"]["foot"].get<double>(),
                stiffness_along(by_hand(own, "bar_2.json"), direction) / reference - 1, 1e-4);
    EXPECT_NEAR(row["by_link"]["leg"].get<double>(),
                stiffness_along(by_hand("foot_2.json", leg), direction) / reference - 1, 1e-4);
  }
  // One beam is far off, and by its foot (JAMRIS09 section 4.3).
  EXPECT_GT(std::abs(models[0]["difference"].get<double>()), 0.1);
}

const std::string side_by_side = "data/robots/orthoglide_fea.yaml --links beam,fea ";

void expect_models_in_deflect() {
  const Outcome bent = kinetostat("deflect " + side_by_side + "--wrench 0,0,-200 --json d.json");
  ASSERT_EQ(bent.code, 0) << bent.err;
  EXPECT_THAT(bent.out, HasSubstr("4 beams"));
  const io::Json deflect = json_of("d.json");
  const double linear = 200 / stiffness_along("data/robots/orthoglide_fea.yaml", io::Json{0, 0, 1});
  EXPECT_NEAR(deflect["link_models"]["rows"][2]["value"].get<double>(), linear, 0.01 * linear);
}

void expect_models_in_map() {
  const Outcome map = kinetostat("map " + side_by_side +
                                 "--grid x=-50:50:3,y=0,z=0 --index weakest-translation "
                                 "--json m.json -o m.csv");
  ASSERT_EQ(map.code, 0) << map.err;
  EXPECT_THAT(io::read_text(working_folder() / "m.csv"), HasSubstr("weakest-translation (1 beam)"));
  const io::Json indices = json_of("m.json")["indices"];
  ASSERT_EQ(indices.size(), 4u);
  EXPECT_NEAR(indices[3]["mean"].get<double>(), indices[0]["mean"].get<double>(),
              1e-5 * indices[0]["mean"].get<double>());
}

// The links are identified once, then kept: all in one test.
TEST(LinkModels, OfTheOrthoglideDifferAsThreeRobotsMadeByHand) {
  const Outcome outcome = kinetostat("study data/robots/orthoglide_fea.yaml -o study_fea");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("6 links"));
  const io::Json models = json_of("study_fea/study.json")["link_models"]["rows"];
  ASSERT_EQ(models.size(), 3u);
  expect_robots_made_by_hand(models);
  expect_models_in_deflect();
  expect_models_in_map();
}

TEST(LinkModels, NeedLinksThatNameTheirMesh) {
  const Outcome none = kinetostat("stiffness data/robots/orthoglide.yaml --links beam,fea");
  EXPECT_EQ(none.code, 3);
  EXPECT_THAT(none.err, HasSubstr("link_file: foot.yaml"));
  const Outcome word = kinetostat("stiffness data/robots/orthoglide_fea.yaml --links rod");
  EXPECT_EQ(word.code, 2);
  EXPECT_THAT(word.err, HasSubstr("--links beam,fea"));
}

}  // namespace
}  // namespace kinetostat::link_models_test
