#include "engine/base/input_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <map>
#include <mutex>
#include <tuple>
#include <utility>

#include "engine/base/error.h"

namespace typodont {

namespace {

constexpr std::uintmax_t kMiB = std::uintmax_t{1} << 20, kGiB = std::uintmax_t{1} << 30;

struct KindOfInput {
  std::string_view name;
  std::uintmax_t largest;  // bytes, largest size that the file may have
};
// Each limit is several times the largest useful file: a session of a day at 1 kHz has 20 GiB, 1024³ voxels of two
// bytes have 2 GiB, half an hour of sound at 192 kHz has 1.3 GiB per channel.
constexpr std::array<KindOfInput, 9> kInputKinds{{{"a JSON file", 64 * kMiB},
                                                  {"a table (CSV)", kGiB},
                                                  {"a session (.h5)", 32 * kGiB},
                                                  {"a tissue volume (.vdb)", 4 * kGiB},
                                                  {"a scan or a mesh", 8 * kGiB},
                                                  {"a mesh", 2 * kGiB},
                                                  {"a sound file", 4 * kGiB},
                                                  {"a picture", 256 * kMiB},
                                                  {"a file", 32 * kGiB}}};

const KindOfInput& entry(InputKind kind) noexcept {
  return kInputKinds[static_cast<std::size_t>(kind)];
}

/// Device, inode and time of creation of a file. The time is needed because inode numbers are reused.
using Identity = std::tuple<std::uint32_t, std::uint32_t, std::uint64_t, std::int64_t, std::uint32_t>;

std::optional<Identity> identity_of(const std::filesystem::path& file) {
  struct statx s {};
  if (::statx(AT_FDCWD, file.c_str(), AT_STATX_SYNC_AS_STAT, STATX_INO | STATX_BTIME, &s) != 0) return std::nullopt;
  const bool born = (s.stx_mask & STATX_BTIME) != 0;
  return Identity{s.stx_dev_major, s.stx_dev_minor, s.stx_ino, born ? s.stx_btime.tv_sec : 0,
                  born ? s.stx_btime.tv_nsec : 0};
}

std::atomic<bool> g_remembers{false};
std::mutex g_mutex;
std::map<Identity, std::filesystem::path> g_inputs;

std::string in_words(std::uintmax_t bytes) {
  if (bytes >= kGiB) return fmt::format("{:.4g} GiB", static_cast<double>(bytes) / static_cast<double>(kGiB));
  return fmt::format("{:.4g} MiB", static_cast<double>(bytes) / static_cast<double>(kMiB));
}

}  // namespace

std::string_view name_of(InputKind kind) noexcept {
  return entry(kind).name;
}

std::uintmax_t max_input(InputKind kind) noexcept {
  return entry(kind).largest;
}

void remember_inputs() noexcept {
  g_remembers = true;
}

std::uintmax_t require_input(const std::filesystem::path& file, InputKind kind) {
  const auto refuse = [&](std::string_view found) {
    throw Error(file.string(), "", found, std::string(name_of(kind)));
  };
  struct stat s {};
  if (::stat(file.c_str(), &s) != 0) refuse(std::strerror(errno));
  if (S_ISDIR(s.st_mode)) refuse("a directory");
  if (S_ISFIFO(s.st_mode)) refuse("a FIFO");
  if (S_ISCHR(s.st_mode) || S_ISBLK(s.st_mode)) refuse("a device");
  if (!S_ISREG(s.st_mode)) refuse("no regular file");
  const auto size = static_cast<std::uintmax_t>(s.st_size);
  if (size > max_input(kind)) {
    throw Error(file.string(), "", in_words(size),
                fmt::format("{} of at most {}", name_of(kind), in_words(max_input(kind))));
  }
  if (!g_remembers) return size;
  if (const auto identity = identity_of(file)) {
    const std::lock_guard lock(g_mutex);
    g_inputs.try_emplace(*identity, file);
  }
  return size;
}

std::ifstream open_input(const std::filesystem::path& file, InputKind kind) {
  require_input(file, kind);
  errno = 0;
  std::ifstream in(file, std::ios::binary);
  if (!in) throw Error(file.string(), "", std::strerror(errno ? errno : EIO), "a readable file");
  return in;
}

std::string read_input(const std::filesystem::path& file, InputKind kind) {
  const std::uintmax_t most = max_input(kind);
  std::ifstream in = open_input(file, kind);
  std::string bytes;
  std::array<char, 1 << 16> piece;
  while (in.read(piece.data(), piece.size()), in.gcount() > 0) {
    bytes.append(piece.data(), static_cast<std::size_t>(in.gcount()));
    if (bytes.size() > most) throw Error(file.string(), "", "a file that grows", std::string(name_of(kind)));
  }
  if (in.bad()) throw Error(file.string(), "", std::strerror(errno ? errno : EIO), "a readable file");
  return bytes;
}

std::optional<std::filesystem::path> input_that_is(const std::filesystem::path& file) {
  const auto identity = identity_of(file);
  if (!identity) return std::nullopt;
  const std::lock_guard lock(g_mutex);
  const auto found = g_inputs.find(*identity);
  if (found == g_inputs.end()) return std::nullopt;
  return found->second;
}

bool LineReader::next(std::string& line) {
  in_.getline(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
  if (in_.gcount() == 0) return false;
  ++number_;
  if (in_.fail() && !in_.eof()) {
    throw Error(file_.string(), fmt::format("line {}", number_),
                in_.bad() ? std::strerror(errno ? errno : EIO) : fmt::format("over {} characters", kLongest),
                "a line of a table");
  }
  // The file's last line may have no line end.
  line.assign(buffer_.data(), static_cast<std::size_t>(in_.gcount()) - (in_.eof() ? 0 : 1));
  return true;
}

}  // namespace typodont
