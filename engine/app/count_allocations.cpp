// Replaces operator new in the program typodont. The replacement counts allocations, and keeps reserves of memory. They
// are needed because some destructors allocate memory, for example those of OpenVDB's trees. If that fails, the program
// is terminated. This file is not in the library, because the tests have their own operator new.
#include <atomic>
#include <cstdlib>
#include <exception>
#include <new>

#include "engine/app/work_counts.h"

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

namespace {

// If this function were inlined, GCC would warn wrongly that memory from operator new is passed to free.
[[gnu::noinline]] void release(void* p) noexcept {
  std::free(p);
}

// Size of a reserve in bytes. A reserve is never written, so it uses only address space and no memory.
constexpr std::size_t kReserve = 4 << 20;
/// Freed when memory runs out for the first time.
std::atomic<void*> g_reserve{std::malloc(kReserve)};
/// Freed when memory runs out while destructors run because of an exception. Another thread may have used up g_reserve
/// by then.
std::atomic<void*> g_reserve_for_destructors{std::malloc(kReserve)};

/// Called when there is no memory (new_handler of the C++ standard). Frees a reserve, and throws std::bad_alloc.
/// Returns only while destructors run because of another exception, because a second one would end the program: the
/// caller then tries again.
void make_room() {
  const bool destructors_run = std::uncaught_exceptions() > 0;
  void* reserve = g_reserve.exchange(nullptr);
  if (!reserve && destructors_run) reserve = g_reserve_for_destructors.exchange(nullptr);
  std::free(reserve);
  if (!reserve || !destructors_run) throw std::bad_alloc();
}

const std::new_handler g_handler_before = std::set_new_handler(make_room);

/// Returns the memory that `get` returns. Throws std::bad_alloc.
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
