#include "engine/base/temporary_folder.h"

#include <stdlib.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <system_error>

#include "engine/base/error.h"

namespace typodont {

std::filesystem::path temporary_place() {
  std::error_code code;
  const std::filesystem::path named = std::filesystem::temp_directory_path(code);
  if (!code) return named;
  for (const char* place : {"/tmp", "/var/tmp"}) {
    if (std::filesystem::is_directory(place, code) && access(place, W_OK) == 0) return place;
  }
  return std::filesystem::current_path();
}

TemporaryFolder::TemporaryFolder() {
  std::string pattern = (temporary_place() / "typodont_XXXXXX").string();
  if (!mkdtemp(pattern.data())) throw Error(pattern, "", std::strerror(errno), "a folder for temporary files");
  path_ = pattern;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code code;
  std::filesystem::remove_all(path_, code);
}

}  // namespace typodont
