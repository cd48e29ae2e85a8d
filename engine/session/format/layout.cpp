#include "engine/session/format/layout.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>

#include "engine/contract/safety_event.h"

namespace typodont::session {

namespace {
struct flock far_byte(short type) {
  struct flock lock {};
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

std::string safety_labels() {
  std::string text;
  for (const auto& [event, name] : kSafetyEventNames) {
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", bits(event), name);
  }
  return text;
}

LoopFields::LoopFields(const LoopReport& r)
    : times{static_cast<std::uint64_t>(r.timing.period),
            r.timing.ticks,
            r.timing.misses,
            r.timing.worst_index,
            static_cast<std::uint64_t>(r.timing.worst_tick),
            static_cast<std::uint64_t>(r.timing.worst_jitter)},
      jitter(r.timing.jitter.counts),
      work(r.timing.work.counts),
      granted{r.fifo, r.pinned, r.memory_locked},
      hand{r.heat, r.worst_heat, r.bearable_force, r.armed ? 1.0 : 0.0},
      safety{r.safety} {
  std::copy(r.note.begin(), r.note.end(), note.begin());
}

LoopReport LoopFields::report() const {
  LoopReport r;
  r.timing.period = static_cast<Nanos>(times[0]);
  r.timing.ticks = times[1];
  r.timing.misses = times[2];
  r.timing.worst_index = times[3];
  r.timing.worst_tick = static_cast<Nanos>(times[4]);
  r.timing.worst_jitter = static_cast<Nanos>(times[5]);
  r.timing.jitter.counts = jitter;
  r.timing.work.counts = work;
  r.fifo = granted[0] != 0, r.pinned = granted[1] != 0, r.memory_locked = granted[2] != 0;
  std::copy(note.begin(), note.end(), r.note.begin());
  r.note.back() = 0;
  r.heat = hand[0], r.worst_heat = hand[1], r.bearable_force = hand[2], r.armed = hand[3] > 0;
  r.safety = static_cast<std::uint32_t>(safety[0]);
  return r;
}

int lock_while_recording(const std::filesystem::path& file) {
  const int fd = open(file.c_str(), O_RDWR | O_CLOEXEC);
  if (fd < 0) return -1;
  struct flock lock = far_byte(F_WRLCK);
  // An OFD lock belongs to the open file, so it remains when HDF5 closes its own descriptor of the file. A POSIX lock
  // would be released then.
  if (fcntl(fd, F_OFD_SETLK, &lock) == 0) return fd;
  close(fd);
  return -1;
}

bool is_being_recorded(int fd) {
  struct flock lock = far_byte(F_RDLCK);
  return fcntl(fd, F_OFD_GETLK, &lock) == 0 && lock.l_type != F_UNLCK;
}

bool is_being_recorded(const std::filesystem::path& file) {
  const int fd = open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd < 0) return false;
  const bool locked = is_being_recorded(fd);
  close(fd);
  return locked;
}

}  // namespace typodont::session
