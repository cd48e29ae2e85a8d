#include "engine/base/own_file.h"

#include <dlfcn.h>
#include <link.h>

#include <system_error>

namespace typodont {

std::filesystem::path own_file() {
  std::error_code code;
  Dl_info info;
  link_map* object = nullptr;
  const bool known =
      dladdr1(reinterpret_cast<const void*>(&own_file), &info, reinterpret_cast<void**>(&object), RTLD_DL_LINKMAP) != 0;
  // For a shared library, the loader states the path; for the program, the name is empty.
  if (known && object && object->l_name && *object->l_name) return std::filesystem::canonical(object->l_name, code);
  return std::filesystem::read_symlink("/proc/self/exe", code);
}

}  // namespace typodont
