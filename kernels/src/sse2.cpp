#include "table-inl.hpp"

namespace consimd::sse2 {

const detail::KernelTable& table() noexcept { return detail::kTable<xsimd::sse2>; }

}  // namespace consimd::sse2
