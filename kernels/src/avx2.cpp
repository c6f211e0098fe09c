#include "table-inl.hpp"

namespace consimd::avx2 {

const detail::KernelTable& table() noexcept { return detail::kTable<xsimd::avx2>; }

}  // namespace consimd::avx2
