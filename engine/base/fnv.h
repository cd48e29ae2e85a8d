// A hash that shows whether files, forces or fields are bit-identical. It does not protect against deliberate changes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <type_traits>

namespace typodont {

/// FNV-1a, 64 bits (Fowler, Noll, Vo; draft-eastlake-fnv).
struct Fnv1a {
  std::uint64_t value = 0xcbf29ce484222325u;
  void bytes(const void* data, std::size_t size) noexcept {
    const auto* p = static_cast<const unsigned char*>(data);
    for (std::size_t i = 0; i < size; ++i) value = (value ^ p[i]) * 0x100000001b3u;
  }
  template <class T>
  void add(const T& number) noexcept {
    static_assert(std::is_arithmetic_v<T>);
    bytes(&number, sizeof number);
  }
};

}  // namespace typodont
