// Values that are set in the text of a YAML file.
#include "kinetostat/io/yaml_change.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include "kinetostat/common/error.h"

namespace kinetostat::io::yaml_change_test {
namespace {

using testing::HasSubstr;

const std::string file =
    "# a robot\n"
    "name: 'it''s: one'  # its name\n"
    "units: {length: mm, force: \"N\"}\n"
    "links:\n"
    "  leg: {beam: {length: 310, section: {tube: {outer: [1, 2], inner: 3}}}} # {\n"
    "  foot:\n"
    "    rigid: [1, 2, 3]\n"
    "chain_types:\n"
    "  arm:\n"
    "    - actuator: {name: q1, axis: Rz, stiffness: 1.0e5 N m/rad}\n"
    "    - link: leg\n"
    "    - {name: x, type: puu}\n"
    "text: |\n"
    "  several\n"
    "  lines\n";

std::string set(const std::string& key, const std::string& value) {
  return with_value(file, "robot.yaml", key, value);
}

// All but the value stays, byte by byte.
void expect_replaced(const std::string& key, const std::string& value, const std::string& before,
                     const std::string& after) {
  std::string expected = file;
  const std::size_t at = expected.find(before);
  ASSERT_NE(at, std::string::npos);
  expected.replace(at, before.size(), after);
  EXPECT_EQ(set(key, value), expected) << key;
}

TEST(WithValue, ReplacesTheValueAndNothingElse) {
  expect_replaced("links.leg.beam.length", "300 mm", "length: 310", "length: 300 mm");
  expect_replaced("name", "other", "'it''s: one'", "other");
  expect_replaced("units.force", "kN", "\"N\"", "kN");
  expect_replaced("links.leg.beam.section.tube.outer", "{a: 1}", "[1, 2], inner", "{a: 1}, inner");
  expect_replaced("links.leg.beam", "{length: 1}",
                  "{length: 310, section: {tube: {outer: [1, 2], inner: 3}}}", "{length: 1}");
  expect_replaced("links.foot.rigid", "[4, 5, 6]", "[1, 2, 3]", "[4, 5, 6]");
}

TEST(WithValue, FindsItemsByNumberAndByName) {
  const std::string before = "stiffness: 1.0e5 N m/rad", after = "stiffness: 2e5";
  expect_replaced("chain_types.arm.0.actuator.stiffness", "2e5", before, after);
  expect_replaced("chain_types.arm.q1.stiffness", "2e5", before, after);
  expect_replaced("chain_types.arm.x.type", "other", "type: puu", "type: other");
  expect_replaced("chain_types.arm.1.link", "foot", "link: leg", "link: foot");
}

TEST(WithValue, AddsAKeyToItsMap) {
  const auto read = [](const std::string& text) { return YAML::Load(text); };
  EXPECT_EQ(read(set("units.angle", "deg"))["units"]["angle"].as<std::string>(), "deg");
  EXPECT_EQ(read(set("links.foot.mass", "{mass: 3}"))["links"]["foot"]["mass"]["mass"].as<int>(),
            3);
  EXPECT_EQ(read(set("gravity", "{direction: [0, 0, -1]}"))["gravity"]["direction"].size(), 3u);
  EXPECT_EQ(read(set("gravity", "1"))["name"].as<std::string>(), "it's: one");
}

void expect_refused(const std::string& key, const std::string& value, const std::string& message) {
  try {
    ADD_FAILURE() << set(key, value);
  } catch (const common::InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("robot.yaml"));
    EXPECT_THAT(error.what(), HasSubstr(message));
  }
}

TEST(WithValue, NamesTheNearestKey) {
  expect_refused("links.lge.beam", "1", "Did you mean 'leg'?");
  expect_refused("chain_types.arm.q2.stiffness", "1", "Did you mean 'q1'?");
  expect_refused("chain_types.arm.7.link", "1", "there is no '7' under 'chain_types.arm'");
  expect_refused("name.first", "1", "there is no 'first' under 'name'");
  expect_refused("text", "1", "several lines");
  expect_refused("links", "1", "several lines");
  expect_refused("units.length", "mm, force: kN", "cannot stand there");
  expect_refused("units.length", "[1", "is not YAML");
  expect_refused("units.length", "", "one line");
}

}  // namespace
}  // namespace kinetostat::io::yaml_change_test
