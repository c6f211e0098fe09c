// Run-time choice of the instruction set that the kernels use.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include <consimd/kernels/export.hpp>

namespace CONSIMD_EXPORT consimd {

/// Instruction sets a kernel can run on. All of them return the same bits.
enum class Isa : std::uint8_t { scalar, sse2, avx2, avx512, neon };

/// Every instruction set that the library has kernels for, on any processor, in the order of the enumeration.
[[nodiscard]] std::span<const Isa> known_isas() noexcept;

/// The enumerator's name, as accepted by `CONSIMD_ISA`.
[[nodiscard]] std::string_view to_string(Isa isa) noexcept;

/// Inverse of `to_string`. Throws std::invalid_argument that names the bad value and the accepted ones.
[[nodiscard]] Isa parse_isa(std::string_view name);

/// Instruction sets compiled into this library that this processor and operating system support,
/// narrowest first; always starts with `Isa::scalar`.
[[nodiscard]] std::span<const Isa> supported_isas() noexcept;

/// The instruction set that kernels run on now: the last one given to `set_active_isa`, else the environment variable
/// `CONSIMD_ISA`, else the widest supported. Throws std::invalid_argument when `CONSIMD_ISA` holds an unknown or
/// unsupported name: there is no silent fallback.
[[nodiscard]] Isa active_isa();

/// Makes all later kernel calls of the process run on `isa`. Throws std::invalid_argument if it is not supported.
void set_active_isa(Isa isa);

}  // namespace consimd
