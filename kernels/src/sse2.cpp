#include "table-inl.hpp"

namespace consimd::detail::sse2 {

const KernelTable& table() noexcept { return kTable<xsimd::sse2>; }

}  // namespace consimd::detail::sse2
