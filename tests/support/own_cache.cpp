// Sets the cache folder of tests (sampled meshes, compiled shaders) to the build folder, where all tests of a build
// share it; the user's cache is never used. Linked into every test program; runs before main(), and child processes
// inherit it.
#include <cstdlib>

namespace {
[[maybe_unused]] const int g_set = [] {
  unsetenv("TYPODONT_CACHE");
  return setenv("XDG_CACHE_HOME", TYPODONT_TEST_CACHE, 1);
}();
}  // namespace
