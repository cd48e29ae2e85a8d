#include "engine/base/sync.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>

namespace typodont {

namespace {

bool sync(const char* path, int flags) noexcept {
  const int fd = ::open(path, flags | O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) return false;
  // Pipes, devices and some network folders cannot be synced; this is no error.
  const bool good = ::fsync(fd) == 0 || errno == EINVAL || errno == ENOTSUP || errno == EROFS;
  ::close(fd);
  return good;
}

}  // namespace

std::filesystem::path folder_of(const std::filesystem::path& file) {
  return file.has_parent_path() ? file.parent_path() : ".";
}

bool sync_file(const std::filesystem::path& file) noexcept {
  return sync(file.c_str(), 0);
}

bool sync_folder_of(const std::filesystem::path& file) noexcept {
  try {
    return sync(folder_of(file).c_str(), O_DIRECTORY);
  } catch (const std::exception&) {  // no memory for the folder's name
    return false;
  }
}

}  // namespace typodont
