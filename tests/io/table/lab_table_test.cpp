// Tables as laboratories write them: title blocks, units, decimal commas, encodings, spreadsheets.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "kinetostat/common/error.h"
#include "kinetostat/io/csv.h"
#include "kinetostat/io/table/open_xml.h"
#include "kinetostat/io/table/text_encoding.h"
#include "kinetostat/io/table/workbook.h"

#include "support/zip_writer.h"

namespace kinetostat::io::lab_table_test {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::vector<std::string> header_of(const std::string& text) {
  return CsvTable(text, "t.csv").columns();
}

TEST(LabTable, TheHeaderIsBelowATitleBlock) {
  EXPECT_THAT(header_of("Stiffness of arm 3\nOperator;Ann\n\nid;Fx [N];dx [um]\n1;2;3\n"),
              ElementsAre("id", "Fx [N]", "dx [um]"));
  // A spreadsheet fills every line up with separators.
  EXPECT_THAT(header_of("Arm 3;;\nDate;2026-05-03;\n;;\nid;fx;dx\n1;2;3\n2;2;3\n"),
              ElementsAre("id", "fx", "dx"));
  // A comma in the title is no separator of the table.
  EXPECT_THAT(header_of("Arm 3, measured by Ann, Bob\nfx;dx\n1;2\n"), ElementsAre("fx", "dx"));
  const CsvTable table("Arm 3\n\nfx,dx\n1,2\n", "t.csv");
  EXPECT_EQ(table.header_line(), 3);
  EXPECT_EQ(table.line(0), 4);
  EXPECT_TRUE(table.has_title());
}

TEST(LabTable, KeyAndValueAboveAreNoTable) {
  EXPECT_THAT(header_of("Temperature;21.5\nLoad cell;K3\nid;fx;dx;dy\n1;2;3;4\n2;2;3;4\n3;2;3;4\n"),
              ElementsAre("id", "fx", "dx", "dy"));
}

TEST(LabTable, ALineOfUnitsGoesIntoTheNames) {
  const CsvTable table("id;Fx;dx;note\n-;[N];um;\n1;2;3;a\n", "t.csv");
  EXPECT_THAT(table.columns(), ElementsAre("id", "Fx [N]", "dx [um]", "note"));
  EXPECT_EQ(table.rows(), 1u);
}

TEST(LabTable, ColumnsWithoutNameAndContentAreNone) {
  const CsvTable table("fx;;dx;\n1;;2;\n3;;4;\n", "t.csv");
  EXPECT_THAT(table.columns(), ElementsAre("fx", "dx"));
  EXPECT_EQ(table.number(1, 1), 4);
}

TEST(LabTable, CellsThatSayNotMeasuredAreMissing) {
  const CsvTable table("fx,dx\n1,-\n2,n/a\n3,NaN\n4,\n5,-1\n6,x\n", "t.csv", {.missing = {"x"}});
  for (const std::size_t row : {0u, 1u, 2u, 3u, 5u}) EXPECT_TRUE(table.missing(row, 1)) << row;
  EXPECT_FALSE(table.missing(4, 1));
}

struct Number {
  const char* text;
  DecimalSign sign;  // that it shows
  const char* with_point;
  const char* with_comma;  // as C++ reads it; empty for no number
};

class Numbers : public testing::TestWithParam<Number> {};

TEST_P(Numbers, AreReadInEitherConvention) {
  const Number& n = GetParam();
  EXPECT_EQ(decimal_sign_of(n.text), n.sign);
  EXPECT_EQ(plain_number(n.text, DecimalSign::point).value_or(""), n.with_point);
  EXPECT_EQ(plain_number(n.text, DecimalSign::comma).value_or(""), n.with_comma);
}

INSTANTIATE_TEST_SUITE_P(All, Numbers,
                         testing::Values(Number{"12", DecimalSign::unknown, "12", "12"},
                                         Number{"0.5", DecimalSign::point, "0.5", ""},
                                         Number{"0,5", DecimalSign::comma, "", "0.5"},
                                         Number{"-0,125", DecimalSign::comma, "", "-0.125"},
                                         Number{"1,234", DecimalSign::unknown, "1234", "1.234"},
                                         Number{"1.234", DecimalSign::unknown, "1.234", "1234"},
                                         Number{"1234,567", DecimalSign::comma, "", "1234.567"},
                                         Number{"1.234,5", DecimalSign::comma, "", "1234.5"},
                                         Number{"1,234.5", DecimalSign::point, "1234.5", ""},
                                         Number{"1,234,567", DecimalSign::point, "1234567", ""},
                                         Number{"1.234.567", DecimalSign::comma, "", "1234567"},
                                         Number{"12,34,567", DecimalSign::unknown, "", ""},
                                         Number{"1 234,5", DecimalSign::comma, "", "1234.5"},
                                         Number{"1'234.5", DecimalSign::point, "1234.5", ""},
                                         Number{"\xe2\x88\x92"
                                                "2,5",
                                                DecimalSign::comma, "", "-2.5"},
                                         Number{"1,5e-3", DecimalSign::comma, "", "1.5e-3"},
                                         Number{"1,234E2", DecimalSign::comma, "1234e2", "1.234e2"},
                                         Number{"12 mm", DecimalSign::unknown, "", ""},
                                         Number{"3.5.2026", DecimalSign::unknown, "", ""}),
                         [](const auto& test) { return "Number" + std::to_string(test.index); });

TEST(LabTable, DecimalCommasAreKnownByTheNumbers) {
  const CsvTable table("id;fx;dx\n1;1.000;0,5\n2;2.000,5;-0,25\n", "t.csv");
  EXPECT_EQ(table.number(0, 1), 1000);
  EXPECT_EQ(table.number(1, 1), 2000.5);
  EXPECT_EQ(table.number(1, 2), -0.25);
  // American: quotes hold the separators of thousands.
  EXPECT_EQ(CsvTable("fx,dx\n\"1,000\",0.5\n", "t.csv").number(0, 0), 1000);
}

TEST(LabTable, WhatMayBeEitherIsRefused) {
  const auto message = [](const std::string& text) {
    try {
      CsvTable(text, "t.csv").number(0, 0);
    } catch (const common::InputError& error) {
      return std::string(error.what());
    }
    return std::string("no error");
  };
  EXPECT_THAT(message("fx;dx\n1,234;2\n"),
              HasSubstr("'1,234' is not a number. Say 'decimal: comma'"));
  EXPECT_THAT(message("fx;dx;dy\n1,234;0.5;0,5\n"), HasSubstr("Say 'decimal: comma'"));
  const CsvTable stated("fx;dx\n1,234;2\n", "t.csv", {.decimal = DecimalSign::comma});
  EXPECT_EQ(stated.number(0, 0), 1.234);
}

TEST(LabTable, EncodingsOfWindowsAreRead) {
  const std::string utf8 = "dx [\xc2\xb5m],M\xc3\xbcller,\xf0\x9d\x9c\x91\n1,2,3\n";
  EXPECT_EQ(as_utf8("\xef\xbb\xbf" + utf8, "t"), utf8);
  EXPECT_EQ(as_utf8("\xb5m \x80", "t"), "\xc2\xb5m \xe2\x82\xac");  // Latin-1, Windows-1252
  for (const bool big : {false, true}) {
    std::string bytes = big ? "\xfe\xff" : "\xff\xfe";
    for (const unsigned unit : {0xB5U, 0x41U, 0xD835U, 0xDF11U}) {
      const char high = static_cast<char>(unit >> 8), low = static_cast<char>(unit & 0xFF);
      bytes += big ? std::string{high, low} : std::string{low, high};
    }
    EXPECT_EQ(as_utf8(bytes, "t"),
              "\xc2\xb5"
              "A\xf0\x9d\x9c\x91");
  }
  EXPECT_THROW(as_utf8("\xff\xfe\x41", "t"), common::InputError);
}

const std::string rows =
    "<row r=\"1\"><c r=\"A1\" t=\"inlineStr\"><is><t>Arm &amp; tool</t></is></c></row>"
    "<row r=\"3\"><c r=\"A3\" t=\"s\"><v>0</v></c><c r=\"B3\" t=\"s\"><v>1</v></c>"
    "<c r=\"C3\" t=\"str\"><v>note</v></c></row>"
    "<row r=\"4\"><c r=\"A4\" s=\"1\"><v>46145.59866898148</v></c><c r=\"B4\"><f>A1*2</f>"
    "<v>1.5</v></c><c r=\"C4\" s=\"2\"><v>0.5</v></c></row>";

TEST(Workbook, ReadsCellsOfExcel) {
  const std::string bytes = test::xlsx_of({{"empty", ""}, {"M &lt; 1", rows}}, {"time", "dz [mm]"},
                                          {"yyyy\\-mm\\-dd hh:mm:ss", "0.00 &quot;mm&quot;"});
  ASSERT_TRUE(is_workbook(bytes));
  const std::vector<Sheet> sheets = read_workbook(bytes, "t.xlsx");
  ASSERT_EQ(sheets.size(), 2u);
  EXPECT_EQ(sheets[1].name, "M < 1");
  EXPECT_EQ(sheets[1].text,
            "Arm & tool\t\t\n\ntime\tdz [mm]\tnote\n2026-05-03T14:22:05.000\t1.5\t0.5\n");
  EXPECT_EQ(find_sheet(sheets, "", "t.xlsx"), 1u);
  EXPECT_THROW(find_sheet(sheets, "M", "t.xlsx"), common::InputError);
}

TEST(Workbook, ReadsCellsOfLibreOffice) {
  const std::string bytes = test::ods_of(
      "<table:table table:name=\"Data\"><table:table-row><table:table-cell "
      "office:value-type=\"string\"><text:p>fx <text:span>[N]</text:span></text:p>"
      "</table:table-cell><table:table-cell/><table:table-cell office:value-type=\"string\">"
      "<office:annotation><text:p>not this</text:p></office:annotation><text:p>time</text:p>"
      "</table:table-cell></table:table-row><table:table-row table:number-rows-repeated=\"2\">"
      "<table:table-cell table:number-columns-repeated=\"2\" office:value-type=\"float\" "
      "office:value=\"0.1\"><text:p>0,10</text:p></table:table-cell><table:table-cell "
      "office:value-type=\"time\" office:time-value=\"PT12H30M05.5S\"/></table:table-row>"
      "<table:table-row table:number-rows-repeated=\"1048000\"><table:table-cell/>"
      "</table:table-row></table:table>");
  ASSERT_TRUE(is_workbook(bytes));
  const std::vector<Sheet> sheets = read_workbook(bytes, "t.ods");
  ASSERT_EQ(sheets.size(), 1u);
  EXPECT_EQ(sheets[0].text, "fx [N]\t\ttime\n0.1\t0.1\t12:30:05.500\n0.1\t0.1\t12:30:05.500\n");
}

TEST(Workbook, DatesCountFromTheOriginOfTheBook) {
  EXPECT_EQ(date_text(1.0, false), "1899-12-31T00:00:00.000");
  EXPECT_EQ(date_text(25569.25, false), "1970-01-01T06:00:00.000");
  EXPECT_EQ(date_text(24107.0, true), "1970-01-01T00:00:00.000");
  EXPECT_EQ(date_text(0.5 + 0.1 / 86400, false), "12:00:00.100");
  EXPECT_TRUE(shows_time("[h]:mm"));
  EXPECT_TRUE(shows_time("[$-409]m/d/yy h:mm AM/PM"));
  EXPECT_FALSE(shows_time("0.00 \"mm\""));
  EXPECT_FALSE(shows_time("[Red]0.00"));
  EXPECT_FALSE(shows_time("General"));
}

// What a logger exported as texts, beside numbers.
TEST(Workbook, TextsMayHaveDecimalCommas) {
  const CsvTable table("fx [N]\tdx [mm]\tn\n1,5\t0.5\t3\n-2,25\t1e-3\t4\n", "t.xlsx",
                       {.is_sheet = true});
  EXPECT_DOUBLE_EQ(table.number(0, 0), 1.5);
  EXPECT_DOUBLE_EQ(table.number(1, 0), -2.25);
  EXPECT_DOUBLE_EQ(table.number(0, 1), 0.5);
  EXPECT_DOUBLE_EQ(table.number(1, 2), 4);
}

TEST(Workbook, DamageIsNamed) {
  const std::string bytes = test::xlsx_of({{"a", rows}});
  for (const std::size_t size : {bytes.size() / 4, bytes.size() / 2, bytes.size() - 10})
    EXPECT_THROW(read_workbook(bytes.substr(0, size), "t.xlsx"), common::InputError) << size;
  std::string changed = bytes;
  changed[changed.find("dz", 0) == std::string::npos ? changed.find("note") : 0] ^= 1;
  EXPECT_THROW(read_workbook(changed, "t.xlsx"), common::InputError);
}

}  // namespace
}  // namespace kinetostat::io::lab_table_test
