#include "table-inl.hpp"

namespace consimd::detail::neon {

const KernelTable& table() noexcept { return kTable<xsimd::neon64>; }

}  // namespace consimd::detail::neon
