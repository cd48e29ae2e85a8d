#include "engine/base/stream_file.h"

#include <fmt/format.h>
#include <unistd.h>

#include <charconv>
#include <string>
#include <system_error>

#include "engine/base/sync.h"

namespace typodont {

namespace fs = std::filesystem;

std::optional<int> own_descriptor(fs::path file) {
  std::error_code code;
  for (int links = 0; links < 40; ++links) {
    const fs::path folder = fs::canonical(folder_of(file), code);
    if (folder == fmt::format("/proc/{}/fd", getpid())) {
      const std::string name = file.filename().string();
      int number = -1;
      const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), number);
      if (error == std::errc{} && end == name.data() + name.size()) return number;
    }
    const fs::path to = fs::read_symlink(file, code);
    if (code) return std::nullopt;
    file = to.is_absolute() ? to : folder_of(file) / to;
  }
  return std::nullopt;
}

bool is_stream(const fs::path& file) {
  std::error_code code;
  const fs::file_status status = fs::status(file, code);
  return fs::is_character_file(status) || fs::is_fifo(status) || (fs::exists(status) && own_descriptor(file));
}

}  // namespace typodont
