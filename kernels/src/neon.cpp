#include "table-inl.hpp"

namespace consimd::neon {

const detail::KernelTable& table() noexcept { return detail::kTable<xsimd::neon64>; }

}  // namespace consimd::neon
