#include "engine/base/memory.h"

#include <sys/mman.h>

namespace typodont {

bool memory_left(std::size_t bytes) noexcept {
  // PROT_NONE: after mlockall(), the system would allocate all pages of any other mapping at once.
  void* const room = ::mmap(nullptr, bytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  return room != MAP_FAILED && ::munmap(room, bytes) == 0;
}

void require_memory(std::size_t bytes) {
  if (!memory_left(bytes)) throw OutOfMemory();
}

}  // namespace typodont
