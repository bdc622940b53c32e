#include "kinetostat/io/yaml.h"

#include <fstream>
#include <functional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/common/error.h"
#include "kinetostat/io/text_file.h"
#include "kinetostat/spatial/rotation.h"

#include "support/matrix_near.h"
#include "support/temporary_folder.h"

namespace kinetostat::io::yaml_test {
namespace {

using spatial::Vector3;
using test::matrix_near;
using testing::AllOf;
using testing::HasSubstr;

const spatial::UnitSystem mm_newton_deg{.length = "mm", .force = "N", .angle = "deg"};

// What reading complains, or "" when it does not.
std::string complaint(const std::string& text, const std::function<void(const YamlNode&)>& read) {
  try {
    read(parse_yaml(text, "robot.yaml"));
  } catch (const common::InputError& error) {
    return error.what();
  }
  return {};
}

TEST(Yaml, ReadsWhatIsThere) {
  const YamlNode top = parse_yaml(
      "name: foot\n"
      "count: 3\n"
      "stiff: true\n"
      "length: 310\n"
      "modulus: 70 GPa\n"
      "point: [1, 2 cm, 3]\n"
      "axis: [0, 0, 2]\n",
      "robot.yaml");
  EXPECT_EQ(top.at("name").text(), "foot");
  EXPECT_EQ(top.at("count").integer(1, 5), 3);
  EXPECT_TRUE(top.at("stiff").boolean());
  EXPECT_DOUBLE_EQ(top.at("length").positive(spatial::dimension::length, mm_newton_deg), 0.31);
  EXPECT_DOUBLE_EQ(top.at("modulus").quantity_with_unit(spatial::dimension::pressure), 70e9);
  EXPECT_TRUE(matrix_near(top.at("point").vector3(spatial::dimension::length, mm_newton_deg),
                          Vector3(0.001, 0.02, 0.003), 1e-18));
  EXPECT_TRUE(matrix_near(top.at("axis").direction(), Vector3(0, 0, 1), 0));
  EXPECT_FALSE(top.has("colour"));
  EXPECT_FALSE(top.find("colour"));
}

TEST(Yaml, MisspeltKeyNamesFileLineAndTheNearestKey) {
  const auto read = [](const YamlNode& top) { top.at("beam").allow_only({"length", "material"}); };
  EXPECT_THAT(complaint("beam:\n  material: steel\n  lenght: 3\n", read),
              AllOf(HasSubstr("robot.yaml:3: beam.lenght"), HasSubstr("Did you mean 'length'?")));
  EXPECT_THAT(complaint("beam:\n  colour: red\n", read), HasSubstr("Known here: length, material"));
  EXPECT_EQ(complaint("beam: {length: 3, material: steel}\n", read), "");
}

TEST(Yaml, KeyGivenTwiceIsRefused) {
  EXPECT_THAT(complaint("a: 1\nb: 2\na: 3\n",
                        [](const YamlNode& top) {
                          top.allow_only({"a", "b"});
                        }),
              AllOf(HasSubstr("robot.yaml:3"), HasSubstr("'a' is given twice")));
}

TEST(Yaml, MissingKeyIsNamed) {
  EXPECT_THAT(
      complaint("beam:\n  length: 3\n", [](const YamlNode& top) { top.at("beam").at("material"); }),
      AllOf(HasSubstr("robot.yaml:2: beam"), HasSubstr("'material' is missing")));
}

TEST(Yaml, EmptyValueAndEmptyKeyAreRefusedNotCrashedOn) {
  EXPECT_THAT(complaint("length:\n", [](const YamlNode& top) { (void)top.at("length").text(); }),
              HasSubstr("not nothing"));
  EXPECT_THAT(complaint("\"\": 3\n", [](const YamlNode& top) { top.allow_only({"a"}); }),
              HasSubstr("is not known here"));
  EXPECT_THAT(complaint("[a, b]: 3\n", [](const YamlNode& top) { top.allow_only({"a"}); }),
              HasSubstr("is not known here"));
}

TEST(Yaml, WrongKindsAreNamed) {
  const auto wrong = [](const char* value, const std::function<void(const YamlNode&)>& read) {
    return complaint(std::string("x: ") + value + "\n",
                     [&](const YamlNode& top) { read(top.at("x")); });
  };
  EXPECT_THAT(wrong("[1, 2]", [](auto& x) { (void)x.text(); }), HasSubstr("a list of 2"));
  EXPECT_THAT(wrong("{a: 1}", [](auto& x) { (void)x.number(); }), HasSubstr("a map of keys"));
  EXPECT_THAT(wrong("3", [](auto& x) { (void)x.items(); }), HasSubstr("a list is expected"));
  EXPECT_THAT(wrong("3", [](auto& x) { (void)x.members(); }),
              HasSubstr("a map of keys is expected"));
  EXPECT_THAT(wrong("3", [](auto& x) { x.allow_only({"a"}); }),
              HasSubstr("a map of keys is expected"));
  EXPECT_THAT(wrong("3", [](auto& x) { (void)x.at("a"); }), HasSubstr("a map with the key 'a'"));
  EXPECT_THAT(wrong("abc", [](auto& x) { (void)x.number(); }),
              HasSubstr("'abc' does not start with a number"));
  EXPECT_THAT(wrong("3 mm", [](auto& x) { (void)x.number(); }), HasSubstr("a plain number"));
  EXPECT_THAT(wrong(".nan", [](auto& x) { (void)x.number(); }), HasSubstr("number"));
  EXPECT_THAT(wrong("inf", [](auto& x) { (void)x.number(); }), HasSubstr("not a finite number"));
  EXPECT_THAT(wrong("2.5", [](auto& x) { (void)x.integer(1, 9); }),
              HasSubstr("whole number from 1 to 9"));
  EXPECT_THAT(wrong("10", [](auto& x) { (void)x.integer(1, 9); }),
              HasSubstr("whole number from 1 to 9"));
  EXPECT_THAT(wrong("maybe", [](auto& x) { (void)x.boolean(); }),
              HasSubstr("not one of true, false"));
  EXPECT_THAT(wrong("rigit",
                    [](auto& x) {
                      (void)x.choice({"rigid", "body"});
                    }),
              HasSubstr("Did you mean 'rigid'?"));
}

TEST(Yaml, WrongLengthsAreNamed) {
  const auto vector = [](const YamlNode& top) {
    (void)top.at("p").vector3(spatial::dimension::length, mm_newton_deg);
  };
  EXPECT_THAT(complaint("p: [1, 2]\n", vector),
              HasSubstr("a list of 3 is expected here, not of 2"));
  EXPECT_THAT(complaint("p: [1, 2, 3 kg]\n", vector),
              AllOf(HasSubstr("robot.yaml:1: p[2]"), HasSubstr("a length such as")));
  EXPECT_THAT(complaint("m: [[1, 2, 3, 4, 5, 6]]\n",
                        [](const YamlNode& top) { (void)top.at("m").matrix6(); }),
              HasSubstr("a list of 6 is expected here, not of 1"));
}

TEST(Yaml, PositiveRefusesZeroAndNegative) {
  const auto read = [](const YamlNode& top) {
    (void)top.at("E").positive(spatial::dimension::pressure, mm_newton_deg);
  };
  EXPECT_THAT(complaint("E: -70 GPa\n", read), HasSubstr("'-70 GPa' is not positive"));
  EXPECT_THAT(complaint("E: 0\n", read), HasSubstr("not positive"));
  EXPECT_THAT(complaint("E: 70 mm\n", read), HasSubstr("a modulus or pressure such as"));
}

TEST(Yaml, AliasesWithoutEndAreRefused) {
  const auto nothing = [](const YamlNode&) {};
  EXPECT_EQ(complaint("a: &x [1, 2]\nb: [*x, *x]\n", nothing), "");
  EXPECT_THAT(complaint("a: &x [1, *x]\n", nothing), HasSubstr("a value holds itself"));
  EXPECT_THAT(complaint("&x\na: {b: *x}\n", nothing), HasSubstr("a value holds itself"));
  std::string laughs = "x0: &x0 [1, 1, 1, 1, 1, 1, 1, 1, 1, 1]\n";
  for (int i = 0; i < 12; ++i) {
    laughs += "x" + std::to_string(i + 1) + ": &x" + std::to_string(i + 1) + " [";
    for (int k = 0; k < 10; ++k) laughs += (k > 0 ? ", *x" : "*x") + std::to_string(i);
    laughs += "]\n";
  }
  EXPECT_THAT(complaint(laughs, nothing), HasSubstr("more than can be read"));
}

TEST(Yaml, ASecondDocumentIsNotPassedOver) {
  const auto nothing = [](const YamlNode&) {};
  EXPECT_THAT(complaint("a: 1\n---\nb: 2\n", nothing), HasSubstr("the file holds 2 documents"));
  EXPECT_EQ(complaint("---\na: 1\n...\n", nothing), "");
  EXPECT_EQ(complaint("---\na: 1\n---\n", nothing), "");
}

// The parser itself makes empty documents of these without end.
TEST(Yaml, TextThatBelongsToNoValueEnds) {
  const auto nothing = [](const YamlNode&) {};
  EXPECT_THAT(complaint(",id,fx\n0,a,1\n", nothing), HasSubstr("looks like a table (CSV)"));
  for (const char* text : {",", "]", "}", ",,", "a: 1\n, b: 2\n", "]]]: {", "a: 1\n...\n,"})
    EXPECT_NE(complaint(text, nothing), "") << text;
}

TEST(Yaml, WhatAFileHoldsIsBounded) {
  const auto nothing = [](const YamlNode&) {};
  const auto repeated = [](const char* text, int count) {
    std::string all;
    for (int i = 0; i < count; ++i) all += text;
    return all;
  };
  EXPECT_THAT(complaint("a: [" + repeated(",1", 1'100'000) + "]\n", nothing),
              HasSubstr("more than 1000000 values"));
  EXPECT_THAT(complaint("a: " + repeated("[", 200) + repeated("]", 200) + "\n", nothing),
              HasSubstr("nested too deeply"));
  EXPECT_THAT(complaint("a: " + repeated("- ", 100'000) + "\n", nothing), HasSubstr("robot.yaml"));
  EXPECT_THAT(complaint("a: 1\n#" + std::string(std::size_t{17} << 20, ' '), nothing),
              HasSubstr("larger than 16 MiB"));
}

TEST(Yaml, OtherKindsOfFilesAreNamed) {
  const auto of = [](const std::string& bytes) { return complaint(bytes, [](const YamlNode&) {}); };
  std::string stl(84 + 50, '\0');
  stl[80] = 1;
  EXPECT_THAT(of(stl), HasSubstr("a mesh (binary STL), not a YAML file"));
  EXPECT_THAT(of("solid foot\n facet normal 0 0 1\n"), HasSubstr("a mesh (ASCII STL)"));
  EXPECT_THAT(of("\x89PNG\r\n\x1a\n...."), HasSubstr("a PNG picture"));
  EXPECT_THAT(of("PK\x03\x04...."), HasSubstr("a zip archive"));
  EXPECT_THAT(of("\x7f"
                 "ELF...."),
              HasSubstr("a program (ELF)"));
  EXPECT_THAT(of("\x1f\x8b...."), HasSubstr("gzip-compressed data"));
  EXPECT_THAT(of("ISO-10303-21;\nHEADER;"), HasSubstr("a CAD model (STEP)"));
  EXPECT_THAT(of("<?xml version=\"1.0\"?>\n<robot/>"), HasSubstr("XML"));
  EXPECT_THAT(of("id,fx,fy\n1,2,3\n"), HasSubstr("looks like a table (CSV)"));
  EXPECT_THAT(of("x;y\n1;2\n"), HasSubstr("looks like a table (CSV)"));
  EXPECT_EQ(of("{\"kinetostat\": 1}"), "");  // JSON is YAML
}

// Names go into decks, scripts, tables and terminals.
TEST(Yaml, NamesAreTextsOnOneLine) {
  const auto name = [](const YamlNode& top) { (void)top.at("name").text(); };
  for (const char* text : {"\"a\\n*INCLUDE, INPUT=x\"", "\"a\\e[2J\"", "|\n  a\n  b", "\"a\\x7f\"",
                           "\"a\\u2028b\"", "\"a\\x9bb\""})
    EXPECT_THAT(complaint(std::string("name: ") + text + "\n", name),
                HasSubstr("control character"))
        << text;
  EXPECT_EQ(complaint("name: \"\\u00b5m 'x' = -5\"\n", name), "");
  EXPECT_THAT(complaint("\"a\\nb\": 1\n", [](const YamlNode& top) { (void)top.members(); }),
              HasSubstr("control character"));
  EXPECT_EQ(parse_yaml("law: |\n  a +\n  b\n", "x.yaml").at("law").prose(), "a +\nb\n");
}

TEST(Yaml, ScalarsReadBack) {
  for (const std::string text : {"x.rho", "a: b", "a #b", "{", "\"", "a\\", "true", "'", "-5", "",
                                 " x ", "it's", "a, b: c}", "caf\xc3\xa9"}) {
    const YamlNode top = parse_yaml("a: [" + yaml_scalar(text) + ", 1]\n", "x.yaml");
    if (text.empty()) continue;
    EXPECT_EQ(top.at("a").items(2)[0].text(), text);
  }
  EXPECT_EQ(yaml_scalar("x.rho"), "x.rho");
  EXPECT_EQ(yaml_scalar("a\nb"), "\"a?b\"");
}

TEST(Yaml, FilesThatCannotBeLookedAtAreNamed) {
  const std::string name(5000, 'x');
  EXPECT_THAT(complaint("file: " + name + "\n",
                        [](const YamlNode& top) { (void)top.at("file").existing_file(); }),
              AllOf(HasSubstr("robot.yaml:1: file"), HasSubstr("cannot be read")));
}

TEST(Yaml, NumbersThatWouldOverflowAreRefused) {
  EXPECT_THAT(complaint("x: 1e300\n", [](const YamlNode& top) { (void)top.at("x").number(); }),
              HasSubstr("too large to compute with"));
  EXPECT_THAT(complaint("x: inf\n", [](const YamlNode& top) { (void)top.at("x").number(); }),
              HasSubstr("not a finite number"));
}

TEST(Yaml, ZeroDirectionIsRefused) {
  EXPECT_THAT(
      complaint("n: [0, 0, 0]\n", [](const YamlNode& top) { (void)top.at("n").direction(); }),
      HasSubstr("points nowhere"));
}

TEST(Yaml, OneOfWantsExactlyOne) {
  const auto read = [](const YamlNode& top) { (void)top.one_of({"plane", "cylinder"}); };
  EXPECT_EQ(complaint("plane: 1\n", read), "");
  EXPECT_THAT(complaint("plane: 1\ncylinder: 2\n", read), HasSubstr("exclude each other"));
  EXPECT_THAT(complaint("cilinder: 2\n", read), HasSubstr("Did you mean 'cylinder'?"));
  EXPECT_THAT(complaint("ball: 2\n", read), HasSubstr("one of the keys plane, cylinder"));
}

TEST(Yaml, SyntaxErrorsNameThePlace) {
  EXPECT_THAT(complaint("a: 1\nb: [1, 2\nc: 3\n", [](const YamlNode&) {}),
              HasSubstr("robot.yaml:3"));
  EXPECT_THAT(complaint("a: 1\n\tb: 2\n", [](const YamlNode&) {}), HasSubstr("not valid YAML"));
  EXPECT_THAT(complaint("", [](const YamlNode&) {}), HasSubstr("starts with 'kinetostat: 1'"));
  EXPECT_THAT(complaint("just words\n", [](const YamlNode&) {}), HasSubstr("not a map of keys"));
}

TEST(Yaml, FormatVersionIsChecked) {
  const auto check = [](const YamlNode& top) { check_format_version(top); };
  EXPECT_EQ(complaint("kinetostat: 1\n", check), "");
  EXPECT_THAT(complaint("kinetostat: 7\n", check), HasSubstr("version '7' is not known"));
  EXPECT_THAT(complaint("name: x\n", check), HasSubstr("Write 'kinetostat: 1'"));
}

TEST(Yaml, UnitsAreChecked) {
  const auto read = [](const YamlNode& top) { (void)read_units(top.at("units")); };
  EXPECT_EQ(complaint("units: {length: mm, force: N, angle: deg, time: s}\n", read), "");
  EXPECT_THAT(complaint("units: {length: mm}\n", read), HasSubstr("'force' is missing"));
  EXPECT_THAT(complaint("units: {length: mmm, force: N}\n", read), HasSubstr("did you mean 'mm'?"));
  EXPECT_THAT(complaint("units: {length: kg, force: N}\n", read),
              HasSubstr("not a unit of length"));
}

TEST(Yaml, PosesInEveryWayOfWritingThem) {
  const auto pose = [](const std::string& text) {
    return read_pose(parse_yaml("pose: " + text + "\n", "robot.yaml").at("pose"), mm_newton_deg);
  };
  EXPECT_TRUE(matrix_near(pose("[10, 0, 5]").position(), Vector3(0.01, 0, 0.005), 1e-18));
  const spatial::Matrix3 expected = spatial::exp_rotation({0, 0, std::acos(0.0)});
  EXPECT_TRUE(matrix_near(pose("{rpy: [0, 0, 90]}").rotation(), expected, 1e-15));
  EXPECT_TRUE(matrix_near(pose("{rotation_vector: [0, 0, 90]}").rotation(), expected, 1e-15));
  EXPECT_TRUE(matrix_near(pose("{x: [0, 1, 0], y: [-1, 0, 0]}").rotation(), expected, 1e-15));
  EXPECT_TRUE(matrix_near(pose("{x: [0, 1, 0], z: [0, 0, 1]}").rotation(), expected, 1e-15));
  EXPECT_TRUE(matrix_near(pose("{y: [-1, 0, 0], z: [0, 0, 1]}").rotation(), expected, 1e-15));
}

TEST(Yaml, PosesThatContradictThemselvesAreRefused) {
  const auto read = [](const YamlNode& top) { (void)read_pose(top.at("pose"), mm_newton_deg); };
  EXPECT_THAT(complaint("pose: {rpy: [0, 0, 0], x: [1, 0, 0], y: [0, 1, 0]}\n", read),
              HasSubstr("more than one way"));
  EXPECT_THAT(complaint("pose: {x: [1, 0, 0]}\n", read), HasSubstr("two of the axis directions"));
  EXPECT_THAT(complaint("pose: {x: [1, 0, 0], y: [2, 0, 0]}\n", read), HasSubstr("parallel"));
  EXPECT_THAT(complaint("pose: {x: [1, 0, 0], z: [2, 0, 0]}\n", read), HasSubstr("parallel"));
}

TEST(Yaml, FilesAreTakenFromTheFolderOfTheFile) {
  const test::TemporaryFolder temporary;
  const std::filesystem::path folder = temporary.path();
  std::ofstream(folder / "foot.stl") << "solid";
  const auto read = [&](const char* name) {
    return parse_yaml(std::string("file: ") + name + "\n", folder / "foot.yaml")
        .at("file")
        .existing_file();
  };
  EXPECT_EQ(read("foot.stl"), folder / "foot.stl");
  try {
    read("fot.stl");
    FAIL() << "a missing file was accepted";
  } catch (const common::InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("Did you mean 'foot.stl'?"));
  }
}

TEST(Yaml, MissingFileIsAnInputError) {
  EXPECT_THROW(read_yaml("/nowhere/robot.yaml"), common::InputError);
  EXPECT_THROW(read_yaml(testing::TempDir()), common::InputError);
}

TEST(Yaml, MeaningIsThatOfTheContent) {
  const test::TemporaryFolder folder;
  const auto meaning_of = [&folder](const std::string& text) {
    return meaning(parse_yaml(text, folder.path() / "file.yaml"));
  };
  const std::string plain = meaning_of("a: 1\nb: {c: [2, x], d: y}\n");
  EXPECT_EQ(meaning_of("# comment\nb:\n  d: \"y\"\n  c:\n  - 2\n  - x\na: 1"), plain);
  EXPECT_NE(meaning_of("a: 1\nb: {c: [x, 2], d: y}\n"), plain);
  EXPECT_NE(meaning_of("a: 1\nb: {c: [2, x], d: y, e: }\n"), plain);
  EXPECT_NE(meaning_of("a: [b, c]"), meaning_of("a: ['b, c']"));
  // A file that is named counts with its bytes.
  const std::string before = meaning_of("a: other.txt");
  write_atomically(folder.path() / "other.txt", "one");
  const std::string with_file = meaning_of("a: other.txt");
  write_atomically(folder.path() / "other.txt", "two");
  EXPECT_NE(with_file, before);
  EXPECT_NE(meaning_of("a: other.txt"), with_file);
}

}  // namespace
}  // namespace kinetostat::io::yaml_test
