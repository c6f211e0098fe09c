#include "number_table.hpp"

#include <limits>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "temporary_folder.hpp"

namespace consimd::synth {
namespace {

using test::TemporaryFolder;
using test::write_text;
using testing::ElementsAre;
using testing::EndsWith;
using testing::ThrowsMessage;

class NumberTableTest : public testing::Test {
 protected:
  std::vector<double> read(const std::string& text, std::size_t columns = 3) {
    write_text(path_, text);
    const NumberTable table = read_number_table(path_);
    require_columns(table, columns, path_);
    return table.values;
  }
  void expect_error(const std::string& text, const std::string& message) {
    EXPECT_THAT([&] { (void)read(text); }, ThrowsMessage<std::runtime_error>(EndsWith("table.txt:" + message))) << text;
  }

  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "table.txt";
};

TEST_F(NumberTableTest, ReadsBlanksCommasAndSemicolons) {
  EXPECT_THAT(read("1 2 3\n4,5,6\n 7 ,\t8 , 9 \n"), ElementsAre(1, 2, 3, 4, 5, 6, 7, 8, 9));
  EXPECT_THAT(read("1;2;3\n 4 ;5 ; 6\n"), ElementsAre(1, 2, 3, 4, 5, 6));
}

TEST_F(NumberTableTest, TakesALineOfNames) {
  for (const char* text : {"x,y,z\n1,2,3\n", "# made up\n\"x\"; _y; Z1\n1;2;3\n"}) {
    write_text(path_, text);
    const NumberTable table = read_number_table(path_);
    EXPECT_EQ(table.names.size(), 3u) << text;
    EXPECT_THAT(table.values, ElementsAre(1, 2, 3));
    EXPECT_EQ(table.lines.front(), text[0] == '#' ? 3u : 2u);
  }
}

TEST_F(NumberTableTest, SkipsCommentsEmptyLinesCarriageReturnsAndByteOrderMark) {
  EXPECT_THAT(read("\xEF\xBB\xBF# x y z\r\n\r\n1 2 3\r\n  \t\n4 5 6 # last\r\n#7 8 9"), ElementsAre(1, 2, 3, 4, 5, 6));
  EXPECT_THAT(read("1 2 3"), ElementsAre(1, 2, 3));
  EXPECT_THAT(read("\n"), ElementsAre());
}

TEST_F(NumberTableTest, SkipsCommentsOfOtherProgramsAndASpreadsheetsSeparator) {
  EXPECT_THAT(read("% of a script\n1 2 3\n // of another\n4 5 6\n"), ElementsAre(1, 2, 3, 4, 5, 6));
  EXPECT_THAT(read("sep=;\nx;y;z\n1;2;3\n"), ElementsAre(1, 2, 3));
  expect_error("1 2 3\nsep=;\n", "2: a semicolon at the end of the line: remove it");
}

TEST_F(NumberTableTest, KeepsTheNamesOfTheLastCommentThatTellsBothClouds) {
  write_text(path_, "# tx ty tz sx sy sz\n# made by me\n1 2 3\n# a b c\n4 5 6\n");
  const NumberTable table = read_number_table(path_);
  EXPECT_THAT(table.comment_names, ElementsAre("tx", "ty", "tz", "sx", "sy", "sz"));
  EXPECT_THAT(table.names, ElementsAre());
}

TEST_F(NumberTableTest, ReadsEveryDouble) {
  EXPECT_THAT(read("0.1 +2.5e+3 -1E-5\n.5 5. 5e-324\n1.7976931348623157e308 -0 0.30000000000000004"),
              ElementsAre(0.1, 2500.0, -1e-5, 0.5, 5.0, 5e-324, std::numeric_limits<double>::max(), -0.0, 0.1 + 0.2));
}

TEST_F(NumberTableTest, CountsRows) {
  write_text(path_, "1 2 3\n4 5 6\n");
  const NumberTable table = read_number_table(path_);
  EXPECT_EQ(table.rows(), 2u);
  EXPECT_THAT(table.row(1), ElementsAre(4, 5, 6));
}

TEST_F(NumberTableTest, NamesTheLineOfAFault) {
  expect_error("1 2 3\n# comment\n4 5\n", "3: expected 3 numbers, got 2");
  expect_error("1 2 3 4\n", "1: expected 3 numbers, got 4");
  expect_error("1 2 3\n1 x 3\n", "2: 'x' is not a number");
  expect_error("1 2 3m\n", "1: '3m' is not a number");
  expect_error("1 2 0x10\n", "1: '0x10' is not a number");
  expect_error("1 2 +-3\n", "1: '+-3' is not a number");
  expect_error("1 2 nan\n", "1: 'nan' is not finite");
  expect_error("1 -inf 3\n", "1: '-inf' is not finite");
  expect_error("1 2 1e999\n", "1: '1e999' is out of a double's range");
  expect_error("1,,3\n",
               "1: column 2 is empty, between two commas: fill it in or remove the line; where two commas "
               "stand for one, write one");
  expect_error("1,2,3,\n", "1: a comma at the end of the line: remove it");
  expect_error(",1,2,3\n", "1: column 1 is empty, before the first comma: fill it in or remove the line");
  expect_error("1;2;3;\n", "1: a semicolon at the end of the line: remove it");
  expect_error("1;;3\n",
               "1: column 2 is empty, between two semicolons: fill it in or remove the line; where two "
               "semicolons stand for one, write one");
  expect_error("1;2;3\n1,5;2,5;3\n", "2: '1,5' is not a number: write decimal points, as 'tr , . < FILE' does");
  expect_error("1;2;1.000,5\n", "1: '1.000,5' is not a number: write a decimal point, and nothing between thousands");
  expect_error("x y z\nx y z\n1 2 3\n", "2: 'x' is not a number");
  expect_error("x 2 3\n", "1: 'x' is not a number");
  expect_error("nan nan nan\n", "1: 'nan' is not finite");
}

TEST_F(NumberTableTest, ReadsNumbersInQuotes) {
  EXPECT_THAT(read("\"1.5\",\"-2\",\"3e1\"\n\"4\", 5 ,\"6\"\n"), ElementsAre(1.5, -2, 30, 4, 5, 6));
  EXPECT_THAT(read("\"1\" \"2\" \"3\"\n\"4\";5;\"6\"\n"), ElementsAre(1, 2, 3, 4, 5, 6));
  expect_error("\"1,5\",\"2\",\"3\"\n", "1: '1,5' is not a number: write a decimal point, not a comma");
  expect_error("\"1,2,3\"\n", "1: '1,2,3' is not a number: remove the quotes");
  expect_error("\"1,2,3\n", "1: '\"1' is not a number: remove the quotes");
  expect_error("1,'2',3\n", "1: ''2'' is not a number: remove the quotes");
  expect_error("1,\"\",3\n", "1: column 2 is empty, between quotes: fill it in or remove the line");
}

TEST_F(NumberTableTest, TellsNamesInQuotesFromNumbers) {
  for (const char* text : {"\"1st x\",\"source, y\",nano\n1,2,3\n", ",x,y\n1,2,3\n", "\"\",x,\"y\"\n\"1\",2,3\n"}) {
    write_text(path_, text);
    const NumberTable table = read_number_table(path_);
    EXPECT_EQ(table.names.size(), 3u) << text;
    EXPECT_THAT(table.values, ElementsAre(1, 2, 3)) << text;
  }
}

TEST_F(NumberTableTest, SplitsNamesWhereTheirLineIsSeparated) {
  for (const char* text : {"Source X,Source Y,Source Z\n1,2,3\n", "Source X;Source Y;Source Z\n1;2;3\n",
                           "Source X\tSource Y\tSource Z\n1\t2\t3\n"}) {
    write_text(path_, text);
    EXPECT_THAT(read_number_table(path_).names, ElementsAre("Source X", "Source Y", "Source Z")) << text;
  }
  expect_error("1 2 1.#INF\n", "1: '1.#INF' is not a number");
}

TEST_F(NumberTableTest, EndsLinesAsAllSystemsDo) {
  for (const char* text :
       {"x y z\r1 2 3\r4 5 6\r", "x y z\r1 2 3\r4 5 6", "x y z\r\n1 2 3\r4 5 6\n", "x y z\r\r\n1 2 3\r\r\n4 5 6"}) {
    write_text(path_, text);
    const NumberTable table = read_number_table(path_);
    EXPECT_THAT(table.values, ElementsAre(1, 2, 3, 4, 5, 6)) << text;
    EXPECT_THAT(table.lines, ElementsAre(2, 3)) << text;
  }
  EXPECT_THAT(read("# 7 8 9\r1 2 3\r\r4 5 6 # last\r"), ElementsAre(1, 2, 3, 4, 5, 6));
  expect_error("1 2 3\r\r1 x 3\r", "3: 'x' is not a number");
}

TEST_F(NumberTableTest, SaysWhatAnEmptyFileLacks) {
  write_text(path_, "");
  EXPECT_THAT([&] { (void)read_number_table(path_); },
              ThrowsMessage<std::runtime_error>(EndsWith("table.txt: is empty, expected lines of numbers")));
}

TEST_F(NumberTableTest, KnowsWhereCommasMustBeDecimalOnes) {
  const auto refused = [this](const std::string& text, const std::string& message) {
    write_text(path_, text);
    const NumberTable table = read_number_table(path_);
    EXPECT_THAT([&] { require_no_decimal_commas(table, 3, path_); },
                ThrowsMessage<std::runtime_error>(EndsWith(
                    "table.txt:" + message + " has a decimal comma: write decimal points, as 'tr , . < FILE' does")))
        << text;
  };
  refused("1,5 2 3\n4 5 6\n", "1: '1,5'");
  refused("1 2 3\n4\t-5,25e1\t6\n", "2: '-5,25e1'");
  refused("1,5 2,5 3,5\n4,5 5,5 6,5\n", "1: '1,5'");
  refused("1,5 2,5 3,5 4\n4,5 5,5 6 4\n", "1: '1,5'");
  for (const char* text : {"1 2 3\n4 5\n", "1,2,3\n4,5\n", "1, 2, 3\n4, 5\n", "1,2 3\n4,5\n"}) {
    write_text(path_, text);
    const NumberTable table = read_number_table(path_);
    EXPECT_NO_THROW(require_no_decimal_commas(table, 3, path_)) << text;
  }
}

TEST_F(NumberTableTest, SaysWhatToDoWithUtf16) {
  for (const std::string& text : {std::string("\xFF\xFE\x31\0\x20\0", 6), std::string("1\0 \0002\0", 6)}) {
    write_text(path_, text);
    EXPECT_THAT([&] { (void)read_number_table(path_); },
                ThrowsMessage<std::runtime_error>(testing::HasSubstr("UTF-16 text, expected UTF-8 or ASCII")));
  }
}

TEST_F(NumberTableTest, ShowsBinaryDataInPrintableCharacters) {
  expect_error("\x01\x80\x02z 2 3", "1: '???z' is not a number");
  expect_error("1 " + std::string(100, 'a'), "1: '" + std::string(40, 'a') + "...' is not a number");
}

TEST_F(NumberTableTest, NamesAMissingFileAndAFolder) {
  EXPECT_THAT([&] { (void)read_number_table(folder_ / "none"); },
              ThrowsMessage<std::runtime_error>(EndsWith("none: cannot read: No such file or directory")));
  EXPECT_THAT([&] { (void)read_number_table(folder_ / ""); },
              ThrowsMessage<std::runtime_error>(EndsWith(": is a folder, expected a file")));
}

}  // namespace
}  // namespace consimd::synth
