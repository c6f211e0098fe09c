// From an instruction set to the functions compiled for it.
#pragma once

#include <consimd/kernels/isa.hpp>

#include "kernel_table.hpp"

namespace consimd::detail {

/// The instruction set called `name`, or the widest supported where that is null or empty. Throws std::invalid_argument
/// on a name that is unknown or not supported.
Isa isa_or_widest(const char* name);

/// `isa` must be supported.
const KernelTable& table_of(Isa isa) noexcept;

/// Table of `active_isa()`; throws as that does.
const KernelTable& active_table();

}  // namespace consimd::detail
