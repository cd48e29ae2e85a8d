// Replaces operator new in the program typodont. The replacement counts allocations. If memory runs out, the
// replacement frees a reserve and throws. The reserve is needed because the destructors of OpenVDB's trees allocate
// memory, and end the program if this fails. This file is not in the library, because the tests have their own operator
// new.
#include <atomic>
#include <cstdlib>
#include <new>

#include "engine/app/work_counts.h"

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

namespace {

// If this function were inlined, GCC would warn wrongly that memory from operator new is passed to free.
[[gnu::noinline]] void release(void* p) noexcept {
  std::free(p);
}

// Size of the reserve in bytes. The reserve is never written, so it uses only address space and no memory.
constexpr std::size_t kReserve = 4 << 20;
std::atomic<void*> g_reserve{std::malloc(kReserve)};

[[noreturn]] void give_up() {
  std::free(g_reserve.exchange(nullptr));
  throw std::bad_alloc();
}

}  // namespace

void* operator new(std::size_t size) {
  typodont::count_allocation();
  if (void* p = std::malloc(size ? size : 1)) return p;
  give_up();
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  typodont::count_allocation();
  const auto align = static_cast<std::size_t>(alignment);
  if (void* p = std::aligned_alloc(align, (size + align - 1) / align * align)) return p;
  give_up();
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
