// operator new of the program typodont: counts, then allocates as ever. Where there is no memory left it gives up a
// reserve and throws: what is taken down on the way out may need some itself (OpenVDB's trees do, and end the program
// where they get none). Not in the library: tests bring their own.
#include <atomic>
#include <cstdlib>
#include <new>

#include "engine/app/work_counts.h"

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)

namespace {

// Not inlined, or GCC takes it for memory of new given to free by mistake.
[[gnu::noinline]] void release(void* p) noexcept {
  std::free(p);
}

constexpr std::size_t kReserve = 4 << 20;  // bytes of address space, none of memory as long as nobody writes there
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
