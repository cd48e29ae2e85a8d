// Hashes that say "the same bits": of files, forces and fields. Not for security.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <span>
#include <string>

#include "engine/contract/contact.h"
#include "engine/session/session_data.h"

namespace typodont::session {

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

/// "fnv1a64:0123456789abcdef".
std::string to_text(const Fnv1a& hash);

/// Every bit of force and torque of every tick, in order: equal runs, equal hashes. Start from a default Fnv1a and feed
/// the ticks in pieces of any size.
void add_forces(Fnv1a& hash, std::span<const ServoTick> ticks) noexcept;

/// Reads the whole file. Throws Error when it cannot.
SourceFile describe_file(const std::filesystem::path& file);

}  // namespace typodont::session
