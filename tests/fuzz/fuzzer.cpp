// The program for libFuzzer. TYPODONT_FUZZ_TARGET is the name of the target that gets the bytes.
#include <oneapi/tbb/global_control.h>
#include <pthread.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "engine/base/log.h"
#include "tests/fuzz/targets.h"

namespace {

const typodont::test::FuzzTarget* g_target = nullptr;

/// Only one thread is allowed. AddressSanitizer's allocator is in an undefined state in a child process that is forked
/// while another thread allocates. The test of a volume, which runs in a child, would then wait for ever.
const oneapi::tbb::global_control g_alone(oneapi::tbb::global_control::max_allowed_parallelism, 1);

bool g_child = false;

}  // namespace

/// An error in a child process is the result of the test of a volume. It is not an error of the parser and needs no
/// report.
extern "C" void __asan_on_error() {
  if (g_child) _exit(1);
}

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  pthread_atfork(nullptr, nullptr, [] { g_child = true; });
  const char* wanted = std::getenv("TYPODONT_FUZZ_TARGET");
  const auto targets = typodont::test::fuzz_targets();
  const auto found =
      std::find_if(targets.begin(), targets.end(), [&](const auto& t) { return wanted && t.name == wanted; });
  if (found == targets.end()) {
    std::fprintf(stderr, "TYPODONT_FUZZ_TARGET must be one of:");
    for (const auto& t : targets) std::fprintf(stderr, " %.*s", static_cast<int>(t.name.size()), t.name.data());
    std::fprintf(stderr, "\n");
    std::exit(2);
  }
  g_target = &*found;
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  g_target->eat({reinterpret_cast<const std::byte*>(data), size});
  return 0;
}
