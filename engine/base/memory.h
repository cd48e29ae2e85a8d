// Memory that the system refuses.
#pragma once

#include <cstddef>
#include <new>

namespace typodont {

/// std::bad_alloc in words.
struct OutOfMemory final : std::bad_alloc {
  const char* what() const noexcept override { return "The operating system granted this program no more memory."; }
};

/// Whether the system would map `bytes` more. Any thread.
bool memory_left(std::size_t bytes) noexcept;
/// Throws OutOfMemory if it would not: before calls into libraries that crash without memory.
void require_memory(std::size_t bytes);

}  // namespace typodont
