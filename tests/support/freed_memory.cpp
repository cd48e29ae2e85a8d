// Lets the allocator of a test program keep freed memory, as in the program typodont. Linked into every test program;
// runs before main().
#include "engine/base/realtime.h"

namespace {
[[maybe_unused]] const int g_kept = (typodont::keep_freed_memory(), 0);
}  // namespace
