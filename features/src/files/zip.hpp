// Files within a ZIP archive, as NumPy's .npz is one.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace consimd::features::detail {

/// A file of an archive: what the directory says of it.
struct ZipEntry {
  std::string_view name;
  std::string_view packed;  ///< as stored
  bool deflated = false;    ///< else as it is
  std::size_t size = 0;     ///< unpacked
  std::uint32_t checksum = 0;
};

/// The entries of an archive, which `bytes` must outlive. Throws FileFault where it is damaged, encrypted, packed
/// otherwise than stored or deflated, or larger than 4 GiB (ZIP64).
[[nodiscard]] std::vector<ZipEntry> zip_entries(std::string_view bytes);

/// The contents of an entry. Throws FileFault where they are damaged.
[[nodiscard]] std::string unpacked(const ZipEntry& entry);

}  // namespace consimd::features::detail
