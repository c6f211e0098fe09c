#include <consimd/features/cloud_files.hpp>

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "../temporary_folder.hpp"

namespace consimd::test {
namespace {

using Rows = std::vector<std::array<double, 3>>;

const Rows kRows{{1.0, 2.0, 3.0}, {-4.5, 0.25, 1e3}, {0.0, 0.0, 0.0}, {7.0, -8.0, 9.5}};

template <typename T>
std::string bytes_of(T value, bool swapped = false) {
  std::string bytes(sizeof(T), '\0');
  std::memcpy(bytes.data(), &value, sizeof(T));
  return swapped ? std::string(bytes.rbegin(), bytes.rend()) : bytes;
}

std::string text_rows(const char* separator, const char* behind) {
  std::string text;
  for (const auto& row : kRows) {
    text += std::to_string(row[0]) + separator + std::to_string(row[1]) + separator + std::to_string(row[2]) + behind +
            "\n";
  }
  return text;
}

/// Records of a colour, y, x, z and another number.
std::string binary_rows(bool swapped) {
  std::string bytes;
  for (const auto& row : kRows) {
    bytes += bytes_of(std::uint8_t{200});
    bytes += bytes_of(static_cast<float>(row[1]), swapped) + bytes_of(row[0], swapped) +
             bytes_of(static_cast<float>(row[2]), swapped);
    bytes += bytes_of(std::int16_t{-3}, swapped);
  }
  return bytes;
}

std::string ply(const std::string& format, const std::string& rows) {
  return "ply\nformat " + format +
         " 1.0\ncomment made up\nelement vertex 4\nproperty uchar red\nproperty float y\n"
         "property double x\nproperty float z\nproperty short other\nelement face 0\n"
         "property list uchar int vertex_indices\nend_header\n" +
         rows;
}

std::string pcd(const std::string& data, const std::string& rows) {
  return "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS rgb y x z other\nSIZE 1 4 8 4 2\n"
         "TYPE U F F F I\nCOUNT 1 1 1 1 1\nWIDTH 2\nHEIGHT 2\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 4\nDATA " +
         data + "\n" + rows;
}

/// Field after field, in literal runs, and a run that repeats for the equal colours.
std::string compressed_rows() {
  std::string fields[5];
  for (const auto& row : kRows) {
    fields[1] += bytes_of(static_cast<float>(row[1]));
    fields[2] += bytes_of(row[0]);
    fields[3] += bytes_of(static_cast<float>(row[2]));
    fields[4] += bytes_of(std::int16_t{-3});
  }
  std::string lzf;
  lzf += '\0';  // one literal byte, then three times the one before
  lzf += static_cast<char>(200);
  lzf += static_cast<char>(1 << 5);
  lzf += '\0';
  std::size_t size = 4;
  for (int f = 1; f < 5; ++f) {
    size += fields[f].size();
    lzf += static_cast<char>(fields[f].size() - 1) + fields[f];
  }
  return bytes_of(static_cast<std::uint32_t>(lzf.size())) + bytes_of(static_cast<std::uint32_t>(size)) + lzf;
}

std::string npy(const std::string& descr, bool fortran, const std::string& values) {
  std::string header =
      "{'descr': '" + descr + "', 'fortran_order': " + (fortran ? "True" : "False") + ", 'shape': (4, 3), }";
  header.resize(117, ' ');
  header += '\n';
  return std::string("\x93NUMPY\x01\0", 8) + bytes_of(static_cast<std::uint16_t>(header.size())) + header + values;
}

template <typename T>
std::string array(bool fortran, bool swapped) {
  std::string bytes;
  for (std::size_t k = 0; k < 12; ++k) {
    const double value = fortran ? kRows[k % 4][k / 4] : kRows[k / 3][k % 3];
    bytes += bytes_of(static_cast<T>(value), swapped);
  }
  return bytes;
}

std::string kitti() {
  std::string bytes;
  for (const auto& row : kRows) {
    for (const double x : row) bytes += bytes_of(static_cast<float>(x));
    bytes += bytes_of(0.5f);
  }
  return bytes;
}

struct File {
  std::string name;
  std::string bytes;
};

std::vector<File> files() {
  std::string ascii_rows;
  for (const auto& row : kRows) {
    ascii_rows +=
        "200 " + std::to_string(row[1]) + " " + std::to_string(row[0]) + " " + std::to_string(row[2]) + " -3\n";
  }
  return {{"a.ply", ply("ascii", ascii_rows)},
          {"l.ply", ply("binary_little_endian", binary_rows(false))},
          {"b.ply", ply("binary_big_endian", binary_rows(true))},
          {"a.pcd", pcd("ascii", ascii_rows)},
          {"b.pcd", pcd("binary", binary_rows(false))},
          {"c.pcd", pcd("binary_compressed", compressed_rows())},
          {"f.npy", npy("<f4", false, array<float>(false, false))},
          {"d.npy", npy(">f8", true, array<double>(true, true))},
          {"k.bin", kitti()},
          {"blanks.xyz", "# x y z\n" + text_rows(" ", " 0.3 17")},
          {"commas.csv", text_rows(", ", ",5")},
          {"semicolons.txt", text_rows(";", "")},
          {"named.csv", "id,\"X\",Y,Z\n" + [] {
             std::string text;
             for (const auto& row : kRows)
               text +=
                   "9," + std::to_string(row[0]) + "," + std::to_string(row[1]) + "," + std::to_string(row[2]) + "\n";
             return text;
           }()}};
}

class CloudFiles : public ::testing::Test {
 protected:
  std::filesystem::path write(const std::string& name, std::string_view bytes) {
    std::filesystem::path path = folder_ / name;
    std::ofstream(path, std::ios::binary) << bytes;
    return path;
  }
  std::string fault(const std::string& name, std::string_view bytes) {
    try {
      static_cast<void>(features::read_cloud(write(name, bytes)));
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "nothing";
  }

  TemporaryFolder folder_;
};

TEST_F(CloudFiles, OfEachFormAreRead) {
  for (const File& file : files()) {
    const Cloud cloud = features::read_cloud(write(file.name, file.bytes));
    ASSERT_EQ(cloud.size(), kRows.size()) << file.name;
    for (std::size_t i = 0; i < kRows.size(); ++i) {
      for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(cloud.point(i)[c], kRows[i][c], 1e-4) << file.name;
    }
    EXPECT_EQ(features::read_cloud(folder_ / file.name, 0.0).left_out(), 1u) << file.name;
  }
}

TEST_F(CloudFiles, ThatEndEarlyAreFaults) {
  for (const File& file : files()) {
    const std::string form = file.name.substr(file.name.find('.'));
    if (form == ".xyz" || form == ".csv" || form == ".txt") continue;  // which may end anywhere
    for (std::size_t length = 1; length < file.bytes.size(); ++length) {
      if (file.name == "k.bin" && length % 16 == 0) continue;
      // Of an ascii file the last number may be cut short.
      if (file.name.starts_with("a.") && length + 14 > file.bytes.size()) continue;
      const std::string what = fault(file.name, std::string_view(file.bytes).substr(0, length));
      ASSERT_TRUE(what.starts_with((folder_ / file.name).string() + ":")) << file.name << " " << length << " " << what;
    }
  }
}

TEST_F(CloudFiles, ThatPromiseTooMuchReserveNothing) {
  const auto lying = [](std::string bytes, const std::string& truth, const std::string& lie) {
    return bytes.replace(bytes.find(truth), truth.size(), lie);
  };
  const std::string rows = binary_rows(false);
  for (const char* count : {"5", "4000000000", "18446744073709551615", "99999999999999999999", "-1", "many"}) {
    const std::string number(count);
    EXPECT_NE(fault("l.ply", lying(ply("binary_little_endian", rows), "vertex 4", "vertex " + number)), "nothing");
    EXPECT_NE(fault("a.ply", lying(ply("ascii", text_rows(" ", " 1 1")), "vertex 4", "vertex " + number)), "nothing");
    EXPECT_NE(fault("b.pcd", lying(pcd("binary", rows), "POINTS 4", "POINTS " + number)), "nothing");
    EXPECT_NE(fault("c.pcd", lying(pcd("binary_compressed", compressed_rows()), "POINTS 4", "POINTS " + number)),
              "nothing");
    EXPECT_NE(fault("f.npy", lying(npy("<f4", false, array<float>(false, false)), "(4, 3)", "(" + number + ", 3)")),
              "nothing");
  }
  std::string compressed = compressed_rows();
  compressed.replace(4, 4, bytes_of(std::uint32_t{0xfffffff0}));
  EXPECT_NE(fault("c.pcd", pcd("binary_compressed", compressed)).find("cannot give"), std::string::npos);
}

TEST_F(CloudFiles, ThatAreDamagedAreReadOrFaults) {
  std::mt19937 random(1);
  for (const File& file : files()) {
    for (int trial = 0; trial < 100; ++trial) {
      std::string bytes = file.bytes;
      for (std::size_t change = 0; change < 1 + random() % 4; ++change) {
        bytes[random() % bytes.size()] = static_cast<char>(random());
      }
      const std::filesystem::path path = write(file.name, bytes);
      try {
        // More points than bytes cannot be.
        EXPECT_LE(features::read_cloud(path).size(), bytes.size());
      } catch (const std::runtime_error& error) {
        EXPECT_TRUE(std::string_view(error.what()).starts_with(path.string())) << error.what();
      } catch (const std::invalid_argument& error) {
        EXPECT_NE(std::string_view(error.what()).find("extent"), std::string_view::npos) << error.what();
      }
    }
  }
}

TEST_F(CloudFiles, SayWhatIsWrong) {
  EXPECT_NE(fault("p.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float a\nend_header\n1\n")
                .find("without x, y and z"),
            std::string::npos);
  EXPECT_NE(fault("p.ply", ply("binary", "")).find("expected ascii"), std::string::npos);
  EXPECT_NE(fault("t.xyz", "1 2 3\n4 five 6\n").find("t.xyz:2: 'five' is not a number"), std::string::npos);
  EXPECT_NE(fault("t.xyz", "1 2 3\n4 5\n").find("t.xyz:2: expected 3 numbers or more, got 2"), std::string::npos);
  EXPECT_NE(fault("t.csv", "easting,northing\n1,2\n").find("t.csv:1: neither numbers"), std::string::npos);
  EXPECT_NE(fault("t.las", std::string("LASF\0\0\0", 7)).find("not a cloud"), std::string::npos);
  EXPECT_NE(fault("n.npy", npy("<i8", false, "")).find("expected float32"), std::string::npos);
  EXPECT_THROW(static_cast<void>(features::read_cloud(folder_ / "absent.ply")), std::runtime_error);
  EXPECT_THROW(static_cast<void>(features::read_cloud(folder_ / ".")), std::runtime_error);
  EXPECT_EQ(features::read_cloud(write("nan.xyz", "1 2 3\nnan nan nan\n")).left_out(), 1u);
  EXPECT_TRUE(features::read_cloud(write("empty.xyz", "")).empty());
}

TEST(MovedPly, HasEveryRowMoved) {
  Rows rows = kRows;
  rows.insert(rows.begin() + 1, {std::nan(""), 0.0, 0.0});
  for (auto& row : rows) row[0] += 5e6;
  const Cloud cloud(PointSpan<double>::interleaved(rows.front().data(), rows.size()));
  RigidTransform motion = RigidTransform::Identity();
  motion.linear() << 0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0;
  motion.translation() << 1.0, 2.0, 3.0;
  const TemporaryFolder folder;
  const auto path = folder / "moved.ply";
  std::ofstream(path, std::ios::binary) << features::moved_ply(cloud, motion);
  const Cloud read = features::read_cloud(path);
  ASSERT_EQ(read.size(), kRows.size());
  EXPECT_EQ(read.left_out(), 1u);
  EXPECT_EQ(read.input_row(1), 2u);
  for (std::size_t i = 0; i < kRows.size(); ++i) {
    const auto p = read.point(i);
    EXPECT_NEAR(p[0], 1.0 - kRows[i][1], 1e-3);
    EXPECT_NEAR(p[1], 2.0 + 5e6 + kRows[i][0], 1e-3);
    EXPECT_NEAR(p[2], 3.0 + kRows[i][2], 1e-3);
  }
}

}  // namespace
}  // namespace consimd::test
