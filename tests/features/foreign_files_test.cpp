// Points and matches as other programs write them: headings of text, shapes and types of arrays.
#include <consimd/features/cloud_files.hpp>
#include <consimd/features/correspondence_files.hpp>

#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "../temporary_folder.hpp"

namespace consimd::test {
namespace {

class ForeignFiles : public ::testing::Test {
 protected:
  std::filesystem::path write(const std::string& name, const std::string& bytes) {
    std::filesystem::path path = folder_ / name;
    std::filesystem::remove(path);
    std::ofstream(path, std::ios::binary) << bytes;
    return path;
  }
  /// The first point and how many there are.
  std::pair<std::array<double, 3>, std::size_t> read(const std::string& name, const std::string& bytes) {
    const Cloud cloud = features::read_cloud(write(name, bytes));
    return {cloud.empty() ? std::array<double, 3>{} : cloud.point(0), cloud.size()};
  }
  template <typename Read>
  std::string fault_of(const Read& read) {
    try {
      static_cast<void>(read());
    } catch (const std::runtime_error& error) {
      const std::string what = error.what();
      return what.substr(what.find_last_of('/') + 1);
    }
    return "nothing";
  }
  std::string fault(const std::string& name, const std::string& bytes) {
    return fault_of([&] { return features::read_cloud(write(name, bytes)); });
  }

  TemporaryFolder folder_;
};

/// An array as NumPy writes it: what the header says of type and shape, and the numbers.
std::string npy(const std::string& type, const std::string& shape, const std::vector<double>& numbers) {
  std::string header = "{'descr': " + type + ", 'fortran_order': False, 'shape': " + shape + ", }\n";
  std::string bytes = "\x93NUMPY";
  bytes += {'\1', '\0', static_cast<char>(header.size()), '\0'};
  bytes += header;
  const std::size_t begin = bytes.size();
  bytes.resize(begin + numbers.size() * sizeof(double));
  if (!numbers.empty()) std::memcpy(bytes.data() + begin, numbers.data(), numbers.size() * sizeof(double));
  return bytes;
}

const std::vector<double> kSixes{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};

TEST_F(ForeignFiles, HeadingsOfTextAreUnderstood) {
  const std::pair<std::array<double, 3>, std::size_t> two{{1.0, 2.0, 3.0}, 2};
  for (
      const char* text : {
          "//X Y Z\n1 2 3\n4 5 6\n",                    // CloudCompare
          "% of a script\n1 2 3\n4 5 6\n",              // MATLAB
          "2\n1 2 3 -1200 9 9 9\n4 5 6 -1300 9 9 9\n",  // a scanner's .pts
          "sep=;\nX;Y;Z\n1;2;3\n4;5;6\n",               // a spreadsheet
          "X (m),Y (m),Z (m)\n1,2,3\n4,5,6\n",          // of units
          "Point,\"Z [m]\",\"Y [m]\",\"X [m]\"\nP1,3,2,1\nP2,6,5,4\n",
          "# index x y z\n7 1 2 3\n8 4 5 6\n",  // names in a comment, one for each column
          "# i x y z\n# of the north wall\n9 1 2 3\n9 4 5 6\n",
          "# POINT3D_ID, X, Y, Z, R, TRACK[] as (IMAGE_ID, POINT2D_IDX)\n7 1 2 3 255 9 9 9\n8 4 5 6 255 9\n",  // COLMAP
          "# timestamp tx ty tz qx qy qz qw\n1.5 1 2 3 0 0 0 1\n2.5 4 5 6 0 0 0 1\n",                          // TUM
          "#Label,X/East,Y/North,Z/Altitude,Yaw\np1,1,2,3,\np2,4,5,6,\n",  // Metashape
          "Point ID,X,Y,Z,Intensity\n1,1,2,3,5\n2,4,5,6,5\n",
          "Name;X;Y;Z\nTarget 0;1;2;3\nTarget 1;4;5;6\n",
          "name\tx\ty\tz\n\t1\t2\t3\nb\t4\t5\t6\n",
          "x y z\n1 1 2 3\n2 4 5 6\n",  // R, pandas: rows have names, which have none
          "\"x\" \"y\" \"z\"\n\"a\" 1 2 3\n\"b\" 4 5 6\n",
          "\"1\",\"2\",\"3\"\n\"4\",\"5\",\"6\"\n",
          "x,y,z\n1,2,3,\n4,5,6,\n",                  // with separators behind
          "x y z\n1 2 3 0.5\n4 5 6 0.7\n",            // with numbers that no name counts
          "0,1,2\n1,2,3\n4,5,6.5\n",                  // pandas, of an array
          "# the x y z coordinates\n1 2 3\n4 5 6\n",  // prose
          "1 2 3\r4 5 6\r",                           // of an old Mac
          "# a\r\n1 2 3\r4 5 6\n",
          "  2\n1 2 3\n4 5 6\n",
      }) {
    EXPECT_EQ(read("t.txt", text), two) << text;
  }
}

// As surveyors write them, and tables with an index.
TEST_F(ForeignFiles, NumbersOfRowsAreNoCoordinates) {
  std::string counted, alone;
  for (int k = 0; k < 9; ++k) {
    counted += std::to_string(k + 1) + ",1,2,3,TREE\n";
    alone += std::to_string(k + 1) + ",1,2\n";
  }
  EXPECT_EQ(read("t.csv", counted), (std::pair<std::array<double, 3>, std::size_t>{{1.0, 2.0, 3.0}, 9}));
  EXPECT_EQ(read("t.csv", alone).second, 9u);
}

TEST_F(ForeignFiles, ColumnsCanBeChosen) {
  const auto chosen = [&](const std::string& name, const std::string& bytes, const features::TextColumns& columns) {
    const Cloud cloud = features::read_cloud(write(name, bytes), std::nullopt, columns);
    return std::pair(cloud.point(0), cloud.size());
  };
  const std::pair<std::array<double, 3>, std::size_t> expected{{1.0, 2.0, 3.0}, 2};
  EXPECT_EQ(chosen("t.xyz", "2\nwater\nO 1 2 3\nH 4 5 6\n", {2, 3, 4}), expected);
  EXPECT_EQ(chosen("t.txt", "# row col x y z\n7 8 1 2 3\n7 9 4 5 6\n", {3, 4, 5}), expected);
  EXPECT_EQ(chosen("t.csv", "Rechts,Hoch,Hoehe,x,y,z\n1,2,3,7,8,9\n4,5,6,7,8,9\n", {1, 2, 3}), expected);
  EXPECT_EQ(chosen("t.csv", "3;name;2;1\n6;other name;5;4\n", {4, 3, 1}), expected);
  EXPECT_EQ(chosen("t.tsv", "id\tEast\tNorth\tUp\n\t1\t2\t3\nb\t4\t5\t6\n", {2, 3, 4}), expected);
  EXPECT_EQ(chosen("t.tsv", "id\tE\tN\tU\tI\n\t1\t2\t3\t9 \n\t4\t5\t6\t9 \n", {2, 3, 4}), expected);
  EXPECT_EQ(chosen("t.tsv", "Scan X\tE\tN\tU\n# made up\n\n1 2\t1\t2\t3\n\t4\t5\t6\n", {2, 3, 4}), expected);
  EXPECT_EQ(chosen("t.txt", "0\t1 2  3\n0\t4 5 6\n", {2, 3, 4}), expected);
  EXPECT_EQ(chosen("t.tsv", "pt 0\t1\t2\t3\npt1\t4\t5\t6\n", {2, 3, 4}), expected);
  EXPECT_EQ(chosen("t.csv", "0,1,2\n1,2,3\n4.5,5,6\n", {1, 2, 3}), expected);
  EXPECT_EQ(chosen("t.csv", ",0,1,2\n0,1,2,3\n1,4.5,5,6\n", {2, 3, 4}), expected);
  EXPECT_EQ(chosen("t.csv", "id,2019,East,North,Up\n7,8,1,2,3\n7,8,4,5,6\n", {3, 4, 5}), expected);
  EXPECT_EQ(chosen("t.xyz", "2\nframe 5 energy -3.2\nO 1 2 3\nH 4 5 6\n", {2, 3, 4}), expected);
  EXPECT_EQ(chosen("t.txt", "\r1 2 3\r4 5 6\r", {1, 2, 3}), expected);
  const auto fault = [&](const std::string& name, const std::string& bytes, const features::TextColumns& columns) {
    return fault_of([&] { return features::read_cloud(write(name, bytes), std::nullopt, columns); });
  };
  EXPECT_EQ(fault("t.txt", "1 2 3\n", {2, 3, 4}), "t.txt:1: expected 4 numbers or more, got 3");
  EXPECT_EQ(fault("t.txt", "a b c\n1 2 c\n", {1, 2, 3}), "t.txt:2: 'c' is not a number");
  EXPECT_EQ(fault("t.csv", "-,-,-\n1,2,3\n", {1, 2, 3}), "t.csv:1: '-' is not a number");
  EXPECT_EQ(fault("t.csv", "NULL,NULL,NULL\n1,2,3\n", {1, 2, 3}), "t.csv:1: 'NULL' is not a number");
  EXPECT_EQ(fault("t.csv", "1,5;2,5;3,5\n1;2;3\n", {1, 2, 3}),
            "t.csv:1: decimal commas: write decimal points, as 'tr , . < FILE' does");
  EXPECT_EQ(fault("t.npy", npy("'<f8'", "(4, 3)", kSixes), {1, 2, 3}), "t.npy: columns are chosen of plain text alone");
  EXPECT_THROW(static_cast<void>(features::read_cloud(write("t.txt", "1 2 3\n"), std::nullopt, {{0, 1, 2}})),
               std::invalid_argument);
  const auto path = write("both.txt", "1 2 3 4 5 6\n");
  const features::MatchedPoints rows =
      features::read_matched_rows(path, path, features::PairColumns{{{1, 2, 3}, {6, 5, 4}}});
  EXPECT_EQ(rows.source.front(), (std::array{1.0, 2.0, 3.0}));
  EXPECT_EQ(rows.target.front(), (std::array{6.0, 5.0, 4.0}));
}

TEST_F(ForeignFiles, HeadingsThatAreWrongAreTold) {
  const std::string remedy = ": say which are x, y and z, counted from 1 ('register' and 'match' take --columns 2,3,4)";

  EXPECT_EQ(fault("t.pts", "3\n1 2 3\n4 5 6\n"), "t.pts: says that it has 3 points, but has 2");
  EXPECT_EQ(fault("t.xyz", "2\nwater\nO 0 0 0\nH 0 0 1\n"),
            "t.xyz:2: neither numbers nor a line of names with x, y and z: 'water'" + remedy);
  EXPECT_EQ(fault("t.xyz", "# made up\n\n1 2 3\n4 five 6\n"), "t.xyz:4: 'five' is not a number");
  EXPECT_EQ(fault("t.xyz", "-16,5740\t-10,5276\t12,0510\n"),
            "t.xyz:1: decimal commas: write decimal points, as 'tr , . < FILE' does");
  EXPECT_EQ(fault("t.csv", "1,2,3\n1 016.5,2,3\n"), "t.csv:2: '1 016.5' is not a number");
  EXPECT_EQ(fault("t.xyz", "1 2 3\n1 2 1.#INF\n"), "t.xyz:2: '1.#INF' is not a number");
  EXPECT_EQ(fault("t.xyz", "x y z\n1 2\n"), "t.xyz:2: 2 words, but 3 names before");
  EXPECT_EQ(fault("t.xyz", "2\n2\n1 2 3\n"), "t.xyz:2: expected 3 numbers or more, got 1");
}

TEST_F(ForeignFiles, ArraysOfOtherShapesAndTypesAreTold) {
  EXPECT_TRUE(features::read_cloud(write("a.npy", npy("'<f8'", "(0, 3)", {}))).empty());
  EXPECT_EQ(fault("a.npy", npy("'<f8'", "(3, 50)", std::vector<double>(150))),
            "a.npy: an array that is not N x 3 or, of matches, N x 6: its shape is (3, 50): save its transpose");
  EXPECT_EQ(fault("a.npy", npy("'<i8'", "(4, 3)", kSixes)),
            "a.npy: an array of '<i8', expected float32 or float64: save its astype(float)");
  EXPECT_EQ(fault("a.npy", npy("[('x', '<f8'), ('y', '<f8'), ('z', '<f8')]", "(4,)", kSixes)),
            "a.npy: an array of '[('x', '<f8'), ('y', '<f8'), ('z', '<f8'...', expected float32 or float64: save one "
            "without named fields");
  EXPECT_EQ(read("a.npy", npy("'<f8'", "(4, 3)", kSixes)),
            (std::pair<std::array<double, 3>, std::size_t>{{1.0, 2.0, 3.0}, 4}));
  // Few points are a cloud, if a small one.
  EXPECT_EQ(read("a.npy", npy("'<f8'", "(3, 4)", kSixes)).second, 3u);
}

TEST_F(ForeignFiles, ArraysOfSixColumnsAreMatches) {
  const features::MatchedPoints matches = features::read_array_matches(write("m.npy", npy("'<f8'", "(2, 6)", kSixes)));
  EXPECT_EQ(matches.source, (std::vector<std::array<double, 3>>{{1.0, 2.0, 3.0}, {7.0, 8.0, 9.0}}));
  EXPECT_EQ(matches.target, (std::vector<std::array<double, 3>>{{4.0, 5.0, 6.0}, {10.0, 11.0, 12.0}}));
  EXPECT_EQ(fault_of([&] { return features::read_array_matches(write("m.npy", npy("'<f8'", "(4, 3)", kSixes))); }),
            "m.npy: an array of 3 columns: a correspondence has 6, source x y z and target x y z, and a cloud needs "
            "the TARGET it is registered to");
}

TEST_F(ForeignFiles, PairsOfRowsAreWhatTheirHeadingSays) {
  const auto a = write("a.xyz", "0 0 0\n1 1 1\n2 2 2\n"), b = write("b.xyz", "5 5 5\n6 6 6\n");
  const auto read = [&](const std::string& text) {
    const features::MatchedPoints matches = features::read_indexed_matches(a, b, write("pairs.txt", text));
    return std::pair(matches.source.at(0)[0], matches.target.at(0)[0]);
  };
  const std::pair two_one(2.0, 6.0);
  for (const char* text : {"2 1\n0 0\n", "2,1,0.7\n", "# made up\n\n2.0 1.0\n", "2e0;1e0\n", "source,target\n2,1\n",
                           "target_row,source_row\n1,2\n", "# Target Source\n1 2\n", "2 1\r0 0\r",
                           "idx src tgt\n9 2 1\n", "\xEF\xBB\xBF% a comment\n// another\n2\t1\n"}) {
    EXPECT_EQ(read(text), two_one) << text;
  }
  const auto wrong = [&](const std::string& text) { return fault_of([&] { return read(text); }); };
  EXPECT_EQ(wrong("2 2\n"), "pairs.txt:1: row 2 of the target, which has 2, counted from 0");
  EXPECT_EQ(wrong("# none\n"), "pairs.txt: holds no pairs");
  EXPECT_EQ(wrong("1 0\n1.5 0\n"), "pairs.txt:2: '1.5' is no row of the source, a whole number from 0 on");
  EXPECT_EQ(wrong("1\n"), "pairs.txt:1: expected a row of the source and one of the target");
}

}  // namespace
}  // namespace consimd::test
