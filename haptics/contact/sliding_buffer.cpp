#include "haptics/contact/sliding_buffer.h"

namespace typodont::haptics {

namespace {

/// Maps the same memory at `both` and at `both` + `size` without a file: mremap() with an old length of 0. Returns
/// false under Valgrind, which does not support this.
bool map_without_file(char* both, std::size_t size) {
  void* const once = mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (once == MAP_FAILED) return false;
  constexpr int kHow = MREMAP_MAYMOVE | MREMAP_FIXED;
  if (mremap(once, 0, size, kHow, both + size) != MAP_FAILED && mremap(once, size, size, kHow, both) != MAP_FAILED)
    return true;
  munmap(once, size);
  return false;
}

/// Maps a file in memory twice. The limit RLIMIT_FSIZE also applies to this file.
bool map_file(char* both, std::size_t size) {
  const int file = memfd_create("typodont patch", MFD_CLOEXEC);
  if (file < 0) return false;
  bool mapped = ftruncate(file, static_cast<off_t>(size)) == 0;
  for (std::size_t half = 0; mapped && half < 2; ++half)
    mapped = mmap(both + half * size, size, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_FIXED, file, 0) != MAP_FAILED;
  close(file);
  return mapped;
}

/// Behaves as operator new: calls the new-handler, which may free memory for destructors, then throws std::bad_alloc.
[[noreturn]] void throw_no_memory() {
  if (const std::new_handler handler = std::get_new_handler()) handler();
  throw std::bad_alloc();
}

}  // namespace

void* map_twice(std::size_t size) {
  void* const both = mmap(nullptr, 2 * size, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (both == MAP_FAILED) throw_no_memory();
  if (auto* const start = static_cast<char*>(both); !map_without_file(start, size) && !map_file(start, size)) {
    munmap(both, 2 * size);
    throw_no_memory();
  }
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  for (std::size_t at = 0; at < 2 * size; at += page) static_cast<volatile char*>(both)[at] = 0;
  return both;
}

}  // namespace typodont::haptics
