// Replaces operator new in the program typodont: counts allocations and keeps two reserves of memory. Not in the
// library, because the tests have their own operator new.
// Some destructors allocate memory. If that fails while an exception is handled,
// the C++ runtime aborts the program. With the reserves, the allocation succeeds. This file also ends the program if
// there is too little memory to start its libraries.
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <exception>
#include <new>
#include <string_view>

#include "engine/app/work_counts.h"
#include "engine/base/memory.h"

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

namespace {

// Libraries start threads while they are loaded, before main(). Without memory for these threads, the program aborts.
constexpr std::size_t kToStart = 64 << 20;  // bytes
void require_memory_to_start() {
  if (typodont::memory_left(kToStart)) return;
  constexpr std::string_view kWords = "error: The operating system granted this program no memory to start.\n";
  [[maybe_unused]] const ssize_t written = ::write(2, kWords.data(), kWords.size());
  ::_exit(1);
}
// The loader calls functions in the section .preinit_array before the initialisation functions of all libraries.
[[gnu::section(".preinit_array"), gnu::used]] void (*const g_before_libraries)() = require_memory_to_start;

// If this function were inlined, GCC would warn wrongly that memory from operator new is passed to free.
[[gnu::noinline]] void release(void* p) noexcept {
  std::free(p);
}

// Size of a reserve in bytes. The program never writes to a reserve, so a reserve uses address space but no memory.
constexpr std::size_t kReserve = 4 << 20;
/// First reserve of memory. It is freed when memory runs out for the first time.
std::atomic<void*> g_reserve{std::malloc(kReserve)};
/// Second reserve of memory. It is freed if memory runs out while destructors run because of an exception. By then,
/// other threads may have used the first reserve.
std::atomic<void*> g_reserve_for_destructors{std::malloc(kReserve)};

/// Handler for failed allocations (std::new_handler). Normally frees a reserve and throws OutOfMemory. While
/// destructors run because of an earlier exception, a second exception would end the program: the handler then frees a
/// reserve and returns, and its caller tries again. Without a reserve, it throws in both cases.
void make_room() {
  const bool destructors_run = std::uncaught_exceptions() > 0;
  void* reserve = g_reserve.exchange(nullptr);
  if (!reserve && destructors_run) reserve = g_reserve_for_destructors.exchange(nullptr);
  std::free(reserve);
  if (!reserve || !destructors_run) throw typodont::OutOfMemory();
}

// The module haptics calls this handler where it requests memory from the operating system itself (map_twice()).
[[maybe_unused]] const std::new_handler g_handler_before = std::set_new_handler(make_room);

/// Calls `get` until it returns memory. After each null, calls make_room(), which frees a reserve or throws
/// OutOfMemory.
template <class Get>
void* allocate(const Get& get) {
  for (;; make_room())
    if (void* p = get()) return p;
}

}  // namespace

void* operator new(std::size_t size) {
  typodont::count_allocation();
  return allocate([=] { return std::malloc(size ? size : 1); });
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  typodont::count_allocation();
  const auto align = static_cast<std::size_t>(alignment);
  return allocate([=] { return std::aligned_alloc(align, (size + align - 1) / align * align); });
}
void operator delete(void* p) noexcept {
  release(p);
}
void operator delete(void* p, std::size_t) noexcept {
  release(p);
}
void operator delete(void* p, std::align_val_t) noexcept {
  release(p);
}
void operator delete(void* p, std::size_t, std::align_val_t) noexcept {
  release(p);
}

#endif
