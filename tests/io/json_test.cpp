#include "kinetostat/io/json.h"

#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/common/error.h"
#include "kinetostat/io/text_file.h"

#include "support/matrix_near.h"
#include "support/random.h"
#include "support/temporary_folder.h"

namespace kinetostat::io::json_test {
namespace {

using spatial::Compliance6;
using test::matrix_near;
using testing::AllOf;
using testing::HasSubstr;

Json example() {
  test::Random random(1);
  return to_json(Compliance6(1e-6 * random.positive_definite(), random.frame()));
}

// What read_compliance complains about a file with this content.
std::string complaint(const std::string& content) {
  const test::TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "bad.link.json";
  std::ofstream(file) << content;
  try {
    read_compliance(file);
  } catch (const common::InputError& error) {
    return error.what();
  }
  return {};
}

TEST(Json, ControlCharactersAreEscaped) {
  const Json json{{"a\x1b\x7f\xc2\x9b", "\xc2\xb5m \xc2\x80"}};
  const std::string text = to_text(json);
  EXPECT_EQ(Json::parse(text), json);
  for (const char* control : {"\x1b", "\x7f", "\xc2\x9b", "\xc2\x80"})
    EXPECT_EQ(text.find(control), std::string::npos);
}

TEST(Json, ComplianceReadsBackToTheLastBit) {
  test::Random random(2);
  const test::TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "link.json";
  for (int i = 0; i < 20; ++i) {
    const Compliance6 compliance(1e-7 * random.positive_definite(), random.frame());
    write_json(file, to_json(compliance));
    const Compliance6 back = read_compliance(file);
    EXPECT_TRUE(matrix_near(back.matrix(), compliance.matrix(), 0));
    EXPECT_EQ(back.frame(), compliance.frame());
  }
}

TEST(Json, MatricesSayOrderPointAxesAndUnits) {
  const Json json = example();
  EXPECT_EQ(json["order"], Json({"tx", "ty", "tz", "rx", "ry", "rz"}));
  EXPECT_EQ(json["units"]["length"], "m");
  EXPECT_EQ(json["compliance"].size(), 6u);
  EXPECT_EQ(json["point"].size(), 3u);
  EXPECT_EQ(json["axes"].size(), 3u);
}

TEST(Json, AxesAreOneDirectionPerRow) {
  spatial::Frame frame;
  frame.axes.col(0) = spatial::Vector3(0, 1, 0);
  frame.axes.col(1) = spatial::Vector3(-1, 0, 0);
  const Json json = to_json(spatial::Wrench{{1, 2, 3}, {4, 5, 6}, frame});
  EXPECT_EQ(json["axes"][0], Json({0.0, 1.0, 0.0}));
  EXPECT_EQ(json["force"], Json({1.0, 2.0, 3.0}));
  EXPECT_EQ(json["moment"], Json({4.0, 5.0, 6.0}));
}

TEST(Json, TextIsValidAndKeepsOrderAndDigits) {
  const Json json = Json::parse(
      R"({"z": 0.1, "a": [1, 2.5e-300], "empty": {}, "none": [], "deep": [{"x": "a\"b\n"}, [[1]]]})");
  const std::string text = to_text(json);
  EXPECT_EQ(Json::parse(text), json);
  EXPECT_LT(text.find("\"z\""), text.find("\"a\""));
  EXPECT_THAT(text, HasSubstr("[1, 2.5e-300]"));  // numbers on one line
  EXPECT_EQ(text.back(), '\n');
}

TEST(Json, BrokenFilesNameTheLine) {
  EXPECT_THAT(complaint("{\n\"compliance\": [\n oops\n"), HasSubstr("bad.link.json:3"));
  EXPECT_NE(complaint(""), "");
  EXPECT_NE(complaint("[]"), "");
}

TEST(Json, NumbersThatNoDoubleHoldsAreRefused) {
  EXPECT_THAT(complaint(R"({"mass": 1e999})"), HasSubstr("bad.link.json: a number is too large"));
}

TEST(Json, WrongComplianceNamesTheKey) {
  const auto with = [](const char* key, const Json& value) {
    Json json = example();
    json[key] = value;
    return complaint(json.dump());
  };
  const auto without = [](const char* key) {
    Json json = example();
    json.erase(key);
    return complaint(json.dump());
  };
  EXPECT_EQ(complaint(example().dump()), "");
  EXPECT_THAT(without("compliance"), HasSubstr("compliance: this key is missing"));
  EXPECT_THAT(without("point"), HasSubstr("point: this key is missing"));
  EXPECT_THAT(with("point", {1, 2}), HasSubstr("three numbers"));
  EXPECT_THAT(with("point", {1, 2, "x"}), HasSubstr("'\"x\"' is not a number"));
  EXPECT_THAT(with("compliance", {1, 2}), HasSubstr("6 rows"));
  EXPECT_THAT(with("axes", {{1, 0, 0}, {0, 1, 0}, {0, 0, -1}}), HasSubstr("right-handed"));
}

TEST(Json, BytesThatAreNotUtf8AreReplacedAndLoseNothingElse) {
  const std::string text = to_text({{"n\xff",
                                     "sc\xff"
                                     "ara"},
                                    {"list", {"\xc3", "\xc3\xbc"}}});
  const Json read = Json::parse(text);
  EXPECT_EQ(read["n\xef\xbf\xbd"],
            "sc\xef\xbf\xbd"
            "ara");
  EXPECT_EQ(read["list"], Json({"\xef\xbf\xbd", "\xc3\xbc"}));
}

TEST(Json, OtherUnitsOrOrderAreRefusedNotMisread) {
  Json json = example();
  json["units"]["length"] = "mm";
  EXPECT_THAT(complaint(json.dump()), HasSubstr("units"));
  json = example();
  json["order"] = {"rx", "ry", "rz", "tx", "ty", "tz"};
  EXPECT_THAT(complaint(json.dump()), HasSubstr("order"));
}

TEST(Json, ALinkWithThreeInterfacesIsRefusedWithACure) {
  const std::string text =
      complaint(R"({"link": "rocker", "interfaces": {"base": {}, "left": {}, "right": {}}})");
  EXPECT_THAT(text, testing::HasSubstr("3 interfaces (base, left, right)"));
  EXPECT_THAT(text, testing::HasSubstr("Make it an elastic body of the manipulator"));
}

TEST(Json, ComplianceMustBeSymmetricAndPositiveDefinite) {
  Json json = example();
  json["compliance"][0][1] = 1.0;
  EXPECT_THAT(complaint(json.dump()), HasSubstr("not symmetric"));
  json = example();
  for (int i = 0; i < 6; ++i) json["compliance"][i][3] = json["compliance"][3][i] = 0.0;
  EXPECT_THAT(complaint(json.dump()), HasSubstr("not positive definite"));
  json = example();
  json["compliance"][2][2] = -1e-6;
  EXPECT_THAT(complaint(json.dump()), HasSubstr("not positive definite"));
}

}  // namespace
}  // namespace kinetostat::io::json_test
