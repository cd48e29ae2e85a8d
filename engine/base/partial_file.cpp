#include "engine/base/partial_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <system_error>
#include <tuple>
#include <utility>

#include "engine/base/error.h"
#include "engine/base/input_file.h"
#include "engine/base/stream_file.h"
#include "engine/base/sync.h"
#include "engine/base/temporary_folder.h"

namespace typodont {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kHead = 4096;  // number of first bytes that show a file's kind
constexpr std::size_t kRandomDigits = 16;

/// Temporary files that a signal handler must remove. If no entry is free, only the destructor removes the file.
std::array<std::atomic<const char*>, 64> g_half_written{};
static_assert(std::atomic<const char*>::is_always_lock_free, "read inside signal handlers");

/// Stores the name and never frees it, because a signal handler may still read it.
const char* keep_name(const fs::path& path) {
  static std::mutex mutex;
  static std::deque<std::string> names;
  const std::lock_guard lock(mutex);
  return names.emplace_back(path.string()).c_str();
}

std::atomic<const char*>* list(const fs::path& path) {
  const char* const name = keep_name(path);
  for (auto& slot : g_half_written) {
    const char* empty = nullptr;
    if (slot.compare_exchange_strong(empty, name)) return &slot;
  }
  return nullptr;
}

class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return fd_; }

 private:
  int fd_;
};

bool is_gone(pid_t process) {
  return kill(process, 0) != 0 && errno == ESRCH;
}

/// Process id in a temporary name such as "PREFIX123.0123456789abcdefSUFFIX"; 0: the name has another form.
pid_t process_in(std::string_view name, std::string_view prefix, std::string_view suffix) {
  const std::size_t around = prefix.size() + 1 + kRandomDigits + suffix.size();
  if (!name.starts_with(prefix) || !name.ends_with(suffix) || name.size() <= around) return 0;
  name.remove_prefix(prefix.size());
  name.remove_suffix(suffix.size());
  const std::string_view random = name.substr(name.size() - kRandomDigits);
  name.remove_suffix(kRandomDigits);
  if (name.back() != '.' || random.find_first_not_of("0123456789abcdef") != std::string_view::npos) return 0;
  name.remove_suffix(1);
  pid_t process = 0;
  const auto [end, code] = std::from_chars(name.data(), name.data() + name.size(), process);
  return code == std::errc{} && end == name.data() + name.size() && process > 0 ? process : 0;
}

void remove_what_the_dead_left(const fs::path& file, std::string_view suffix) {
  const std::string prefix = file.filename().string() + ".";
  std::error_code code;
  fs::directory_iterator entry(folder_of(file), code);
  for (; !code && entry != fs::directory_iterator(); entry.increment(code)) {
    const pid_t process = process_in(entry->path().filename().string(), prefix, suffix);
    std::error_code ignored;
    if (process != 0 && is_gone(process)) fs::remove(entry->path(), ignored);
  }
}

std::string random_digits() {
  std::uint64_t number = 0;
  while (::getrandom(&number, sizeof number, 0) != sizeof number) {
  }
  return fmt::format("{:016x}", number);
}

/// Creates FILE.PROCESS.RANDOMSUFFIX in `folder`. Enters its name in g_half_written before the file exists, so that a
/// signal at any time removes the file.
std::pair<fs::path, std::atomic<const char*>*> make_temporary(const fs::path& folder, const fs::path& name,
                                                              std::string_view suffix, mode_t mode,
                                                              const fs::path& file) {
  for (int attempt = 0; attempt < 100; ++attempt) {
    const fs::path path = folder / fmt::format("{}.{}.{}{}", name.string(), getpid(), random_digits(), suffix);
    std::atomic<const char*>* const listed = list(path);
    const Descriptor made(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, mode));
    if (made.get() >= 0) return {path, listed};
    if (listed) listed->store(nullptr);
    if (errno != EEXIST) throw Error(file.string(), "", std::strerror(errno), "a writable place");
  }
  throw Error(file.string(), "", "no free name for a temporary file", "a writable place");
}

}  // namespace

PartialFile::PartialFile(fs::path file, FileKind kind, Over over, std::string_view part)
    : file_(std::move(file)), target_(file_), kind_(kind), over_(over) {
  check_target();
  const std::string suffix = part.empty() ? ".partial" : fmt::format(".{}.partial", part);
  std::error_code code;
  const fs::path folder = makes_file() ? target_.parent_path() : temporary_place();
  remove_what_the_dead_left(folder / target_.filename(), suffix);
  const bool replaces = makes_file() && fs::exists(target_, code);
  try {
    std::tie(path_, listed_) =
        make_temporary(folder, target_.filename(), suffix, replaces || !makes_file() ? 0600 : 0666, file_);
  } catch (const Error&) {
    if (stream_ >= 0) ::close(stream_);
    throw;
  }
}

PartialFile::~PartialFile() {
  std::error_code code;
  if (!path_.empty()) fs::remove(path_, code);
  if (stream_ >= 0) ::close(stream_);
  forget();
}

void PartialFile::forget() noexcept {
  if (listed_) listed_->store(nullptr);
  listed_ = nullptr;
}

/// Throws Error if the target file must not be replaced.
void PartialFile::check_target() {
  const auto refuse = [&](std::string_view found, std::string_view expected) {
    throw Error(file_.string(), "", found, expected);
  };
  struct stat link {
  }, is{};
  if (::lstat(file_.c_str(), &link) != 0) {
    if (errno == ENOENT && !file_.empty()) return;  // no file exists yet
    refuse(std::strerror(errno), "a file to write");
  }
  if (::stat(file_.c_str(), &is) != 0) {
    if (S_ISLNK(link.st_mode)) refuse("a link that leads to no file", "a file to write, or a link to one");
    refuse(std::strerror(errno), "a file to write");
  }
  if (S_ISDIR(is.st_mode)) refuse("a directory", "a file to write");
  if (const auto descriptor = own_descriptor(file_)) {
    stream_ = ::fcntl(*descriptor, F_DUPFD_CLOEXEC, 0);
    if (stream_ < 0 || (::fcntl(stream_, F_GETFL) & O_ACCMODE) == O_RDONLY)
      refuse("a descriptor that is not open for writing", "one that is");
    return;
  }
  if (S_ISCHR(is.st_mode) || S_ISFIFO(is.st_mode)) {
    // O_NONBLOCK: opening a FIFO without a reader fails with ENXIO instead of waiting.
    stream_ = ::open(file_.c_str(), O_WRONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
    if (stream_ < 0)
      refuse(errno == ENXIO && S_ISFIFO(is.st_mode) ? "a FIFO that nobody reads" : std::strerror(errno),
             "a device or FIFO that can be written to");
    ::fcntl(stream_, F_SETFL, ::fcntl(stream_, F_GETFL) & ~O_NONBLOCK);
    return;
  }
  if (!S_ISREG(is.st_mode)) refuse("no regular file", "a file to write");

  if (S_ISLNK(link.st_mode)) {
    std::error_code code;
    target_ = fs::canonical(file_, code);
    if (code) refuse(code.message(), "a link to a file");
    // Any text could be a table, so the target's name must have the extension of the file's kind.
    if (!endings_of(kind_).empty() && kind_of_name(target_, std::array{kind_}) != kind_)
      refuse(fmt::format("a link to {}", target_.string()), fmt::format("a link to {}", name_of(kind_)));
  }
  if (over_ == Over::kNoInput) {
    if (const auto input = input_that_is(target_)) {
      refuse(*input == file_ ? "a file that is read here, too"
                             : fmt::format("the file {}, which is read here, too", input->string()),
             "another one to write");
    }
  }
  if (::access(target_.c_str(), W_OK) != 0) refuse(std::strerror(errno), "a file that may be written");
  std::array<char, kHead> head{};
  const Descriptor old(::open(target_.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
  const ssize_t got = old.get() < 0 ? -1 : ::read(old.get(), head.data(), head.size());
  if (got < 0) refuse(std::strerror(errno), fmt::format("{} to replace, or a new name", name_of(kind_)));
  if (!may_replace(kind_, {head.data(), static_cast<std::size_t>(got)}, static_cast<std::uintmax_t>(is.st_size)))
    refuse("a file of another kind", fmt::format("{} to replace, or a new name", name_of(kind_)));
}

/// Copies mode, owner and group of the old file. If the owner cannot be changed, nobody gets more rights than before.
void PartialFile::take_over_owner(int fd) const {
  struct stat old {};
  if (::lstat(target_.c_str(), &old) != 0) return;
  mode_t mode = old.st_mode & 07777;
  if (::fchown(fd, old.st_uid, old.st_gid) != 0 && ::fchown(fd, static_cast<uid_t>(-1), old.st_gid) != 0)
    mode &= ~static_cast<mode_t>(07070);
  if (::fchmod(fd, mode) != 0) throw Error(file_.string(), "", std::strerror(errno), "a file whose mode can be kept");
}

void PartialFile::copy_into_stream() {
  // Writing to a FIFO without a reader raises SIGPIPE, which would end the program. With SIGPIPE blocked, write()
  // fails.
  sigset_t pipe, before;
  sigemptyset(&pipe);
  sigaddset(&pipe, SIGPIPE);
  ::pthread_sigmask(SIG_BLOCK, &pipe, &before);
  const Descriptor from(::open(path_.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW));
  std::array<char, 1 << 16> piece;
  int error = from.get() < 0 ? errno : 0;
  while (error == 0) {
    const ssize_t got = ::read(from.get(), piece.data(), piece.size());
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) error = errno;
    if (got <= 0) break;
    for (ssize_t done = 0; done < got && error == 0;) {
      const ssize_t wrote = ::write(stream_, piece.data() + done, static_cast<std::size_t>(got - done));
      if (wrote >= 0) done += wrote;
      if (wrote < 0 && errno != EINTR) error = errno;
    }
  }
  if (error == EPIPE) {
    const timespec none{};
    ::sigtimedwait(&pipe, nullptr, &none);
  }
  ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
  if (::close(std::exchange(stream_, -1)) != 0 && error == 0) error = errno;
  if (error != 0) throw Error(file_.string(), "", std::strerror(error), "a device or FIFO that can be written to");
}

void PartialFile::keep() {
  if (!makes_file()) {
    copy_into_stream();
    std::error_code code;
    fs::remove(path_, code);
    path_.clear();
    return forget();
  }
  check_target();  // the target may have changed since the first check
  if (!makes_file()) throw Error(file_.string(), "", "a device or FIFO, which was none before", "a file to write");
  {
    const Descriptor made(::open(path_.c_str(), O_WRONLY | O_CLOEXEC | O_NOFOLLOW));
    if (made.get() < 0) throw Error(file_.string(), "", std::strerror(errno), "a writable place");
    take_over_owner(made.get());
  }
  // Writes the content to disk before the rename: after a power cut, either the old or the new file is complete.
  if (!sync_file(path_)) throw Error(file_.string(), "", std::strerror(errno), "a place that keeps what is written");
  std::error_code code;
  fs::rename(path_, target_, code);
  if (code) throw Error(file_.string(), "", code.message(), "a writable place");
  path_.clear();
  sync_folder_of(target_);
  forget();
}

void require_output(const fs::path& file, FileKind kind, Over over) {
  const PartialFile trial(file, kind, over);
}

void remove_partial_files() noexcept {
  for (auto& slot : g_half_written) {
    if (const char* const path = slot.load()) ::unlink(path);
  }
}

}  // namespace typodont
