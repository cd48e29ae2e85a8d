#include "engine/session/format/layout.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

namespace typodont::session {

namespace {
struct flock far_byte(short type) {
  struct flock lock{};
  lock.l_type = type;
  lock.l_whence = SEEK_SET;
  lock.l_start = off_t{1} << 62;
  lock.l_len = 1;
  return lock;
}
}  // namespace

std::string event_labels() {
  std::string text;
  for (int i = 0; i < kEventKindCount; ++i) {
    text += fmt::format("{}{} {}", i ? ", " : "", i, name_of(static_cast<EventKind>(i)));
  }
  return text;
}

int lock_while_recording(const std::filesystem::path& file) {
  const int fd = open(file.c_str(), O_RDWR | O_CLOEXEC);
  if (fd < 0) return -1;
  struct flock lock = far_byte(F_WRLCK);
  // Of the open file description: HDF5 closing its own descriptor does not drop it, as it would a POSIX lock.
  if (fcntl(fd, F_OFD_SETLK, &lock) == 0) return fd;
  close(fd);
  return -1;
}

bool is_being_recorded(const std::filesystem::path& file) {
  const int fd = open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd < 0) return false;
  struct flock lock = far_byte(F_RDLCK);
  const bool locked = fcntl(fd, F_OFD_GETLK, &lock) == 0 && lock.l_type != F_UNLCK;
  close(fd);
  return locked;
}

}  // namespace typodont::session
