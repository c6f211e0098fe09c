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

std::string lying(std::string bytes, const std::string& truth, const std::string& lie) {
  return bytes.replace(bytes.find(truth), truth.size(), lie);
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

std::string npy(const std::string& descr, bool fortran, const std::string& values, std::size_t rows = 4) {
  std::string header = "{'descr': '" + descr + "', 'fortran_order': " + (fortran ? "True" : "False") + ", 'shape': (" +
                       std::to_string(rows) + ", 3), }";
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

// That array of float32, by a program that has nothing to do with this one: with the fixed codes, and with codes of its
// own.
constexpr std::uint8_t kFixed[] = {
    0x9b, 0xec, 0x17, 0xea, 0x1b, 0x10, 0xc9, 0xc8, 0x50, 0xc6, 0x50, 0xad, 0x9e, 0x92, 0x5a, 0x9c, 0x5c,
    0xa4, 0x6e, 0xa5, 0xa0, 0x6e, 0x93, 0x66, 0xa2, 0xae, 0xa3, 0xa0, 0x9e, 0x96, 0x5f, 0x54, 0x52, 0x94,
    0x98, 0x17, 0x9f, 0x5f, 0x94, 0x92, 0x0a, 0x12, 0x77, 0x4b, 0xcc, 0x29, 0x4e, 0x05, 0x8a, 0x17, 0x67,
    0x24, 0x16, 0xa4, 0x02, 0xf9, 0x1a, 0x26, 0x3a, 0x0a, 0xc6, 0x9a, 0x3a, 0x0a, 0xb5, 0x0a, 0x64, 0x03,
    0x2e, 0x06, 0x86, 0x06, 0x7b, 0x06, 0x06, 0x06, 0x07, 0x20, 0x02, 0xe2, 0x09, 0x07, 0x80, 0x7c, 0x3b,
    0x06, 0x86, 0x2a, 0x17, 0x06, 0x14, 0xf0, 0x00, 0x28, 0xc7, 0x70, 0x90, 0x81, 0x41, 0xc2, 0x11, 0x00};
constexpr std::uint8_t kDynamic[] = {
    0x05, 0xc1, 0x31, 0x0e, 0xc1, 0x50, 0x00, 0x80, 0xe1, 0xdf, 0xea, 0x04, 0xc6, 0x7f, 0x7b, 0x24, 0xdd, 0x74, 0x6a,
    0x84, 0x4a, 0xc4, 0x46, 0x2c, 0x06, 0x93, 0x34, 0xda, 0xc6, 0x20, 0x2a, 0xaf, 0x62, 0x20, 0x92, 0x1e, 0x41, 0xe2,
    0x42, 0xdc, 0xc4, 0x51, 0x7c, 0xdf, 0x7b, 0xbd, 0x5d, 0x6d, 0x76, 0x3d, 0x6e, 0x3c, 0x42, 0x59, 0xb5, 0x87, 0x18,
    0x32, 0xc3, 0xa4, 0x4e, 0x43, 0x62, 0xa8, 0x9b, 0x78, 0x8d, 0xc5, 0x79, 0xdf, 0xc4, 0xb2, 0x8a, 0x21, 0x73, 0x59,
    0x9c, 0xda, 0x2a, 0x31, 0xb4, 0xc7, 0xe2, 0x52, 0x85, 0xcc, 0x61, 0x9a, 0x38, 0x1e, 0x25, 0x3e, 0x55, 0x55, 0x55,
    0x55, 0x55, 0x55, 0x55, 0x55, 0x55, 0x55, 0x55, 0x55, 0x55, 0x55, 0xb5, 0x0f, 0xdd, 0x0c, 0xc8, 0x21, 0xcf, 0xe1,
    0xf5, 0x81, 0x6e, 0x0a, 0xf7, 0x05, 0x00, 0x00, 0x00, 0xfc, 0x72, 0xe0, 0x0b, 0x83, 0xf9, 0x1f};

std::uint32_t crc_32(std::string_view bytes) {
  std::uint32_t rest = 0xffffffffu;
  for (const char c : bytes) {
    rest ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) rest = rest >> 1 ^ ((rest & 1) != 0 ? 0xedb88320u : 0u);
  }
  return ~rest;
}

/// An archive with one file. packed: as stored, with that method of compression.
std::string zip(const std::string& name, std::uint16_t method, const std::string& packed, const std::string& contents) {
  const std::string about = bytes_of(std::uint16_t{20}) + bytes_of(std::uint16_t{0}) + bytes_of(method) +
                            bytes_of(std::uint32_t{0}) + bytes_of(crc_32(contents)) +
                            bytes_of(static_cast<std::uint32_t>(packed.size())) +
                            bytes_of(static_cast<std::uint32_t>(contents.size())) +
                            bytes_of(static_cast<std::uint16_t>(name.size())) + bytes_of(std::uint16_t{0});
  const std::string local = "PK\3\4" + about + name + packed;
  const std::string entry = "PK\1\2" + bytes_of(std::uint16_t{20}) + about + std::string(14, '\0') + name;
  return local + entry + "PK\5\6" + std::string(4, '\0') + bytes_of(std::uint16_t{1}) + bytes_of(std::uint16_t{1}) +
         bytes_of(static_cast<std::uint32_t>(entry.size())) + bytes_of(static_cast<std::uint32_t>(local.size())) +
         bytes_of(std::uint16_t{0});
}

/// Blocks of DEFLATE without compression.
std::string stored_blocks(std::string_view contents) {
  constexpr std::size_t kMost = 0xffff;
  std::string blocks;
  do {
    const std::string_view block = contents.substr(0, kMost);
    contents.remove_prefix(block.size());
    const auto size = static_cast<std::uint16_t>(block.size());
    blocks += contents.empty() ? '\1' : '\0';
    blocks += bytes_of(size) + bytes_of(static_cast<std::uint16_t>(~size));
    blocks += block;
  } while (!contents.empty());
  return blocks;
}

template <std::size_t N>
std::string text_of(const std::uint8_t (&bytes)[N]) {
  return {bytes, bytes + N};
}

std::string las(char minor) {
  const std::uint32_t begin = minor < 4 ? 227 : 375;
  std::string bytes(begin, '\0');
  const auto put = [&](std::size_t at, const std::string& value) { bytes.replace(at, value.size(), value); };
  put(0, "LASF");
  put(24, std::string{1, minor});
  put(96, bytes_of(begin));
  put(105, bytes_of(std::uint16_t{20}));
  // Version 1.4 has a number of points of 64 bits; the older field may be zero.
  put(minor < 4 ? 107 : 247, minor < 4 ? bytes_of(std::uint32_t{4}) : bytes_of(std::uint64_t{4}));
  for (std::size_t c = 0; c < 3; ++c) {
    put(131 + 8 * c, bytes_of(0.25));
    put(155 + 8 * c, bytes_of(0.0));
  }
  for (const auto& row : kRows) {
    for (const double x : row) bytes += bytes_of(static_cast<std::int32_t>(4.0 * x));
    bytes += std::string(8, '\7');
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
          {"s.npz", zip("points.npy", 0, npy("<f4", false, array<float>(false, false)),
                        npy("<f4", false, array<float>(false, false)))},
          {"r.npz", zip("other.npy", 8, stored_blocks(npy(">f8", true, array<double>(true, true))),
                        npy(">f8", true, array<double>(true, true)))},
          {"x.npz", zip("xyz.npy", 8, text_of(kFixed), npy("<f4", false, array<float>(false, false)))},
          {"y.npz", zip("xyz.npy", 8, text_of(kDynamic), npy("<f4", false, array<float>(false, false)))},
          {"l.las", las(2)},
          {"n.las", las(4)},
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
    std::filesystem::remove(path);  // ext4 waits for the disk where a file is written over
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

TEST_F(CloudFiles, OfManyDeflatedBlocksAreRead) {
  constexpr std::size_t kPoints = 40000;  // 480 kB, of which no block has more than 64
  std::string values;
  for (std::size_t i = 0; i < 3 * kPoints; ++i) values += bytes_of(static_cast<float>(i));
  const std::string contents = npy("<f4", false, values, kPoints);
  const std::string packed = stored_blocks(contents);
  const Cloud cloud = features::read_cloud(write("many.npz", zip("points.npy", 8, packed, contents)));
  ASSERT_EQ(cloud.size(), kPoints);
  EXPECT_NEAR(cloud.point(kPoints - 1)[2], 3.0 * kPoints - 1.0, 1e-2);
  for (std::size_t length : {std::size_t{0}, std::size_t{1}, packed.size() / 2, packed.size() - 1}) {
    const std::string what = fault("many.npz", zip("points.npy", 8, packed.substr(0, length), contents));
    EXPECT_TRUE(what.ends_with("ends within its compressed data") || what.find("cannot give") != std::string::npos)
        << length << " " << what;
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
  const std::string whole = npy("<f4", false, array<float>(false, false));
  // An archive that says more of its contents than there is, by little and by far.
  EXPECT_NE(fault("y.npz", zip("xyz.npy", 8, text_of(kDynamic), whole + "more")).find("bytes, expected"),
            std::string::npos);
  const std::string size = bytes_of(static_cast<std::uint32_t>(whole.size()));
  std::string lie = zip("xyz.npy", 8, text_of(kDynamic), whole);
  lie.replace(lie.rfind(size), 4, bytes_of(std::uint32_t{0xfffffff0}));
  EXPECT_NE(fault("y.npz", lie).find("cannot give 4294967280"), std::string::npos) << fault("y.npz", lie);
  EXPECT_NE(fault("y.npz", zip("xyz.npy", 8, text_of(kDynamic), whole.substr(1))).find("give more than"),
            std::string::npos);
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
  EXPECT_NE(fault("t.xyz", std::string("\0\1\2", 3)).find("not a cloud"), std::string::npos);
  EXPECT_NE(fault("t.csv", "1,5;2,5;3,5\n").find("t.csv:1: decimal commas"), std::string::npos);
  EXPECT_NE(fault("t.las", std::string("LASF\0\0\0", 7)).find("ends within its header"), std::string::npos);
  std::string laz = las(2);
  laz[104] = static_cast<char>(0x83);
  EXPECT_NE(fault("t.laz", laz).find("laspy decompress"), std::string::npos);
  EXPECT_NE(fault("t.e57", std::string("ASTM-E57\0\1", 10)).find("pdal translate"), std::string::npos);
  EXPECT_NE(fault("t.csv.gz", std::string("\x1F\x8B\x08\0\1", 5)).find("gunzip"), std::string::npos);
  const std::string capitals = lying(ply("ascii", text_rows(" ", " 1 1")), "property float y", "property float Y");
  EXPECT_EQ(fault("c.ply", capitals), "nothing");
  const std::string four_points = pcd("ascii", "");
  EXPECT_NE(fault("h.pcd", lying(four_points, "HEIGHT 2", "HEIGHT 3")).find("POINTS 4 is not WIDTH 2 times HEIGHT 3"),
            std::string::npos);
  EXPECT_NE(fault("h.pcd", lying(four_points, "COUNT 1 1", "COUNT 1 0")).find("COUNT 0"), std::string::npos);
  const std::string array_of_rows = npy("<f4", false, array<float>(false, false));
  EXPECT_NE(fault("n.npz", zip("a.txt", 0, "1 2 3", "1 2 3")).find("a.txt: not an array"), std::string::npos);
  EXPECT_NE(fault("n.npz", zip("xyz.npy", 0, array_of_rows, array_of_rows.substr(1) + "x")).find("checksum"),
            std::string::npos);
  EXPECT_NE(fault("n.npz", zip("xyz.npy", 12, array_of_rows, array_of_rows)).find("method 12"), std::string::npos);
  EXPECT_NE(fault("n.npz", zip("xyz.npy", 8, "\7", array_of_rows.substr(0, 1))).find("damaged: invalid block type"),
            std::string::npos);
  EXPECT_NE(fault("n.npz", "PK\3\4 and no more").find("without a directory"), std::string::npos);
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
