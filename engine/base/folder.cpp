#include "engine/base/folder.h"

#include <algorithm>

#include "engine/base/error.h"

namespace typodont {

namespace fs = std::filesystem;

void make_folder(const fs::path& folder) {
  std::error_code code;
  fs::create_directories(folder, code);
  if (code || !fs::is_directory(folder))
    throw Error(folder.string(), "", code ? code.message() : "not a folder", "a folder that can be made");
}

std::vector<fs::path> files_in(const fs::path& folder, std::string_view extension) {
  std::vector<fs::path> files;
  std::error_code code;
  for (fs::directory_iterator it(folder, code), end; !code && it != end; it.increment(code))
    if (it->path().extension() == extension) files.push_back(it->path());
  std::ranges::sort(files);
  return files;
}

std::vector<fs::path> files_below(const fs::path& folder, std::string_view extension) {
  std::vector<fs::path> files;
  std::error_code code;
  for (fs::recursive_directory_iterator it(folder, code), end; it != end; ++it) {
    std::error_code unknown;
    const fs::path& path = it->path();
    if (it->is_directory(unknown)) {
      if (path.filename().string().starts_with('.')) it.disable_recursion_pending();
    } else if (path.extension() == extension) {
      files.push_back(path);
    }
  }
  std::ranges::sort(files);
  return files;
}

}  // namespace typodont
