// Detects that the system has no more memory.
#pragma once

#include <cstddef>
#include <new>

namespace typodont {

/// std::bad_alloc with a message for users.
struct OutOfMemory final : std::bad_alloc {
  const char* what() const noexcept override { return "The operating system granted this program no more memory."; }
};

/// True if the system would grant `bytes` more memory. Any thread.
bool memory_left(std::size_t bytes) noexcept;
/// Throws OutOfMemory unless `bytes` more memory is available. Call before functions of libraries that crash without
/// memory.
void require_memory(std::size_t bytes);

}  // namespace typodont
