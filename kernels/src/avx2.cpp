#include "table-inl.hpp"

namespace consimd::detail::avx2 {

const KernelTable& table() noexcept { return kTable<xsimd::avx2>; }

}  // namespace consimd::detail::avx2
