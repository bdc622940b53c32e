#include "kinetostat/io/csv.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/common/error.h"

namespace kinetostat::io::csv_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::string message(const std::string& content) {
  try {
    const CsvTable table(content, "readings.csv");
    for (std::size_t row = 0; row < table.rows(); ++row)
      for (std::size_t column = 0; column < table.columns().size(); ++column)
        table.number(row, column);
  } catch (const common::InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(Csv, ReadsHeaderAndCells) {
  const CsvTable table("id, fx ,dz\n a,1.5,-2e-3\n", "t.csv");
  EXPECT_THAT(table.columns(), ElementsAre("id", "fx", "dz"));
  ASSERT_EQ(table.rows(), 1u);
  EXPECT_EQ(table.cell(0, 0), "a");
  EXPECT_EQ(table.number(0, 1), 1.5);
  EXPECT_EQ(table.number(0, 2), -2e-3);
  EXPECT_EQ(table.find("dz"), 2u);
  EXPECT_FALSE(table.find("dy"));
}

TEST(Csv, SkipsCommentsAndEmptyLinesAndCountsThem) {
  const CsvTable table("# origin\n\nfx\n# more\n1\n\n2\n", "t.csv");
  ASSERT_EQ(table.rows(), 2u);
  EXPECT_EQ(table.line(0), 5);
  EXPECT_EQ(table.line(1), 7);
}

TEST(Csv, AcceptsByteOrderMarkCarriageReturnsAndMissingLastLineEnd) {
  const CsvTable table(
      "\xef\xbb\xbf"
      "fx,fy\r\n1,2\r\n3,4",
      "t.csv");
  EXPECT_THAT(table.columns(), ElementsAre("fx", "fy"));
  ASSERT_EQ(table.rows(), 2u);
  EXPECT_EQ(table.number(0, 1), 2);
  EXPECT_EQ(table.number(1, 1), 4);
}

TEST(Csv, ReadsQuotedCellsWithSeparatorsQuotesAndLineEnds) {
  const CsvTable table("a,\"b, c\",n\n\"one, \"\"two\"\"\",\"x\ny\" ,1\n1,2,3\n", "t.csv");
  EXPECT_THAT(table.columns(), ElementsAre("a", "b, c", "n"));
  ASSERT_EQ(table.rows(), 2u);
  EXPECT_EQ(table.cell(0, 0), "one, \"two\"");
  EXPECT_EQ(table.cell(0, 1), "x\ny");
  EXPECT_EQ(table.line(1), 4);
}

TEST(Csv, TakesSemicolonOrTabWhereTheHeaderHasNoComma) {
  EXPECT_EQ(CsvTable("a;b\n1;2\n", "t.csv").number(0, 1), 2);
  const CsvTable tabs("a\tb\tc\n1\t\t3\n", "t.csv");
  EXPECT_TRUE(tabs.empty(0, 1));
  EXPECT_EQ(tabs.number(0, 2), 3);
}

TEST(Csv, IgnoresRowsOfNothingButSeparators) {
  EXPECT_EQ(CsvTable("a,b\n1,2\n,\n,\n", "t.csv").rows(), 1u);
}

TEST(Csv, WhatIsWrittenReadsBack) {
  const std::string text = "a \"b\",\nc#";
  EXPECT_EQ(CsvTable("x,y\n" + csv_cell(text) + ",1\n", "t.csv").cell(0, 0), text);
}

TEST(Csv, SpreadsheetsFindNoFormulas) {
  for (const std::string text : {"=cmd|' /C calc'!A0", "+1+2", "-x", "@SUM(A1)", "'=1+1", "''-a"}) {
    const std::string cell = csv_cell(text);
    EXPECT_TRUE(cell.starts_with("'") || cell.starts_with("\"'")) << cell;
    EXPECT_EQ(CsvTable("x,y\n" + cell + ",1\n", "t.csv").cell(0, 0), text);
  }
  for (const std::string text : {"-5", "+1e3", "-", "x=1", "'a", "-0.25"})
    EXPECT_EQ(csv_cell(text), text);
}

TEST(Csv, CellsAndCommentsStayOnTheirLine) {
  EXPECT_EQ(csv_cell("a\n=cmd\r\x1b[2J"), "\"a\n=cmd??[2J\"");
  EXPECT_EQ(csv_comment("a\nb, =cmd;@x, -5 N, +1+2"), "# a?b, '=cmd;'@x, -5 N, '+1+2\n");
}

TEST(Csv, OtherKindsOfFilesAreNamed) {
  EXPECT_THAT(message("PK\x03\x04 and so on"), HasSubstr("a zip archive (as Excel"));
  EXPECT_THAT(message(std::string("a,b\0c\n1,2\n", 10)), HasSubstr("binary data"));
  EXPECT_THAT(message("\"a\x01b\",c\n1,2\n"), HasSubstr("control character"));
  EXPECT_THAT(CsvTable("\"Fx\n[N]\",c\n1,2\n", "t.csv").columns(), ElementsAre("Fx [N]", "c"));
}

TEST(Csv, OneLineOfAMillionColumnsIsRefusedAtOnce) {
  std::string header;
  for (int i = 0; i < 1'000'000; ++i) header += "c" + std::to_string(i) + ",";
  EXPECT_THAT(message(header + "x\n"), HasSubstr("1000001 columns"));
}

struct Broken {
  const char* content;
  const char* message;
};

class BrokenCsv : public testing::TestWithParam<Broken> {};

TEST_P(BrokenCsv, IsRefusedWithPlaceValueAndCure) {
  EXPECT_THAT(message(GetParam().content), HasSubstr(GetParam().message));
}

INSTANTIATE_TEST_SUITE_P(
    All, BrokenCsv,
    testing::Values(
        Broken{"", "readings.csv: holds no table. Give a header"},
        Broken{"# only a comment\n", "readings.csv: holds no table"},
        Broken{"fx,dz\n", "the table has a header but no row. Give one row"},
        Broken{"fx,dz,fx\n1,2,3\n", "readings.csv:1:7: two columns are named 'fx'. Give each"},
        Broken{"fx,,dz\n1,2,3\n", "readings.csv:1:4: column 2 has no name. Name every"},
        Broken{"fx,dz\n1,2\n1,2,3\n",
               "readings.csv:3: this row has 3 cells, the header has 2: '1,2,3'"},
        Broken{"fx,dz\n1\n", "readings.csv:2: dz: this row has 1 cell, the header has 2: '1'"},
        Broken{"fx,dz\n1,\n", "readings.csv:2:3: dz: the cell is empty. Write a number"},
        Broken{"# c\nfx,dz\n1, 12mm\n",
               "readings.csv:3:4: dz: '12mm' is not a number. Write the number alone"},
        Broken{"fx;dz\n1;0,5\n2;0.25\n3;0.5\n",
               "readings.csv:2:3: dz: '0,5' is not a number. Write the decimals with a point"},
        Broken{"fx,dz\n1,n/a\n",
               "readings.csv:2:3: dz: 'n/a' is not a number. Write a number such as"},
        Broken{"fx,dz\n1,inf\n", "dz: 'inf' is not a finite number. Leave the cell empty"},
        Broken{"fx,dz\n1,nan\n", "dz: 'nan' is not a finite number"},
        Broken{"fx,dz\n1,1e999\n", "dz: '1e999' is too large or too small to compute with"},
        Broken{"fx,dz\n1,-1e101\n", "dz: '-1e101' is too large or too small to compute with"},
        Broken{"fx,dz\n1,1e-400\n", "dz: '1e-400' is too large or too small to compute with"},
        Broken{"fx,dz\n\"1,2\n", "readings.csv:2:1: the quote that starts here is not closed"},
        Broken{"fx,dz\n\"1\"2,3\n", "readings.csv:2:4: text follows the quote"},
        Broken{"\xff\xfe"
               "f",
               "readings.csv: is UTF-16 text that ends within a character. Save it again"}));

TEST(Csv, ReadsAHundredThousandRows) {
  std::string content = "id,x,y,z,fx,fy,fz,dx,dy,dz\n";
  for (int i = 0; i < 100000; ++i) {
    content += std::to_string(i);
    for (int k = 0; k < 9; ++k) content += "," + std::to_string(0.001 * i + k);
    content += '\n';
  }
  const CsvTable table(std::move(content), "t.csv");
  double sum = 0;
  for (std::size_t row = 0; row < table.rows(); ++row)
    for (std::size_t column = 1; column < 10; ++column) sum += table.number(row, column);
  EXPECT_EQ(table.rows(), 100000u);
  EXPECT_NEAR(sum, 9 * 0.001 * 99999 * 50000 + 36 * 1e5, 1e-3);
}

}  // namespace
}  // namespace kinetostat::io::csv_test
