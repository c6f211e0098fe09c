// From an instruction set to the functions compiled for it.
#pragma once

#include <consimd/kernels/isa.hpp>

#include "kernel_table.hpp"

namespace consimd::detail {

/// `isa` must be supported.
const KernelTable& table_of(Isa isa) noexcept;

/// Table of `active_isa()`; throws as that does.
const KernelTable& active_table();

}  // namespace consimd::detail
