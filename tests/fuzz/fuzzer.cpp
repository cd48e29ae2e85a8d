// libFuzzer's side: TYPODONT_FUZZ_TARGET names which of the targets eats.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "engine/base/log.h"
#include "tests/fuzz/targets.h"

namespace {

const typodont::test::FuzzTarget* g_target = nullptr;

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
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
