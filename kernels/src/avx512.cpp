#include "table-inl.hpp"

namespace consimd::detail::avx512 {

const KernelTable& table() noexcept { return kTable<xsimd::avx512bw>; }

}  // namespace consimd::detail::avx512
