// What tests make and keep for later (sampled meshes, compiled shaders) lies in the build folder and is shared by all
// tests of a build, warm after the first: never in the cache of whoever runs them. In every test program, before its
// main(); programs it starts inherit it.
#include <cstdlib>

namespace {
[[maybe_unused]] const int g_set = [] {
  unsetenv("TYPODONT_CACHE");
  return setenv("XDG_CACHE_HOME", TYPODONT_TEST_CACHE, 1);
}();
}  // namespace
