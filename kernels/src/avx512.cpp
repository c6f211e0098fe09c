#include "table-inl.hpp"

namespace consimd::avx512 {

const detail::KernelTable& table() noexcept { return detail::kTable<xsimd::avx512bw>; }

}  // namespace consimd::avx512
