#include "haptics/volume/vdb_guard.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <vector>

#include "engine/base/error.h"
#include "engine/base/fnv.h"

namespace typodont::haptics {

namespace {

constexpr std::uint64_t kMagic = 0x56444220;  // "VDB "
constexpr std::uint32_t kOldest = 218;        // the first with a UUID, see openvdb/version.h
constexpr std::uint32_t kUuidBytes = 36;

constexpr std::string_view kSeal = "TYPODONT";
constexpr std::size_t kSealBytes = kSeal.size() + sizeof(std::uint64_t);
constexpr std::size_t kLongestMessage = 1000;  // bytes; longer ones are grids cut off, not words
constexpr rlim_t kTrialSeconds = 60;           // for reading a file on trial

/// FNV-1a of the file's first `bytes` bytes.
std::uint64_t hash_of(std::ifstream& in, std::uint64_t bytes) {
  Fnv1a hash;
  std::vector<char> piece(1 << 16);
  in.seekg(0);
  while (bytes > 0 && in) {
    in.read(piece.data(), static_cast<std::streamsize>(std::min<std::uint64_t>(bytes, piece.size())));
    hash.bytes(piece.data(), static_cast<std::size_t>(in.gcount()));
    bytes -= static_cast<std::uint64_t>(in.gcount());
  }
  return hash.value;
}

enum class Seal { kNone, kBroken, kUnbroken };

Seal seal_of(const std::filesystem::path& file) {
  const std::uint64_t size = std::filesystem::file_size(file);
  std::ifstream in(file, std::ios::binary);
  if (size < kSealBytes) return Seal::kNone;
  std::array<char, kSealBytes> end{};
  in.seekg(static_cast<std::streamoff>(size - kSealBytes));
  in.read(end.data(), end.size());
  if (!in || std::string_view(end.data(), kSeal.size()) != kSeal) return Seal::kNone;
  std::uint64_t hash = 0;
  std::memcpy(&hash, end.data() + kSeal.size(), sizeof hash);
  return hash_of(in, size - kSealBytes) == hash ? Seal::kUnbroken : Seal::kBroken;
}

/// Runs `work` in a child process; true when that ended well. What it throws is left as text in `message`.
bool succeeds_elsewhere(const std::filesystem::path& message, const std::function<void()>& work) {
  const pid_t child = fork();
  if (child == 0) {
    for (int s = 1; s < NSIG; ++s) std::signal(s, SIG_DFL);  // what the program does about them is not the child's
    const rlimit none{0, 0}, seconds{kTrialSeconds, kTrialSeconds};
    setrlimit(RLIMIT_CORE, &none);
    setrlimit(RLIMIT_CPU, &seconds);
    alarm(kTrialSeconds);  // and where it sleeps for ever
    int status = 0;
    try {
      work();
    } catch (const std::exception& e) {
      std::ofstream(message) << e.what();
      status = 1;
    }
    _exit(status);
  }
  int status = 0;
  while (child > 0 && waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return child > 0 && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

/// Walks the header, the metadata and the grid descriptors (format 218 to 224, as OpenVDB 4 and later write it).
class Walker {
 public:
  explicit Walker(const std::filesystem::path& file)
      : name_(file.string()), size_(std::filesystem::file_size(file)), in_(file, std::ios::binary) {}

  void walk() {
    if (number<std::uint64_t>("magic") != kMagic) fail("no VDB file");
    const auto version = number<std::uint32_t>("file version");
    if (version < kOldest) fail(fmt::format("file version {}", version));
    skip(2 * sizeof(std::uint32_t) + 1, "library version");
    if (version >= 220 && version < 222) skip(1, "compression");
    skip(kUuidBytes, "identifier");
    metadata();
    const auto grids = number<std::uint32_t>("number of grids");
    for (std::uint32_t i = 0; i < grids; ++i) {
      for (const char* what : {"name of a grid", "type of a grid", "parent of a grid"}) skip(length(what), what);
      const auto grid = number<std::int64_t>("position of a grid");
      skip(sizeof(std::int64_t), "position of a grid's blocks");
      const auto end = number<std::int64_t>("end of a grid");
      go_to(grid, "position of a grid");
      if (version >= 222) skip(sizeof(std::uint32_t), "compression of a grid");
      metadata();
      skip(length("type of a transform"), "type of a transform");
      go_to(end, "end of a grid");
    }
  }

 private:
  [[noreturn]] void fail(const std::string& found) const { throw Error(name_, "", found, "a tissue volume (.vdb)"); }
  std::uint64_t at() { return static_cast<std::uint64_t>(in_.tellg()); }

  template <class Number>
  Number number(const char* what) {
    Number n{};
    in_.read(reinterpret_cast<char*>(&n), sizeof n);
    if (!in_) fail(fmt::format("the file ends in the {}", what));
    return n;
  }
  std::uint32_t length(const char* what) {
    const auto n = number<std::uint32_t>(what);
    if (n > size_ - at()) fail(fmt::format("a {} of {} bytes, {} before the end", what, n, size_ - at()));
    return n;
  }
  void go_to(std::int64_t position, const char* what) {
    if (position < 0 || static_cast<std::uint64_t>(position) > size_)
      fail(fmt::format("{} {}, outside the file", what, position));
    in_.seekg(position);
  }
  void skip(std::uint64_t bytes, const char* what) {
    if (bytes > size_ - at()) fail(fmt::format("the file ends in the {}", what));
    in_.seekg(static_cast<std::streamoff>(bytes), std::ios::cur);
  }
  void metadata() {
    const auto count = number<std::uint32_t>("number of metadata");
    for (std::uint32_t i = 0; i < count; ++i) {
      for (const char* what : {"name of a metadatum", "type of a metadatum", "metadatum"}) skip(length(what), what);
    }
  }

  std::string name_;
  std::uint64_t size_;
  std::ifstream in_;
};

}  // namespace

void seal_vdb(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  const std::uint64_t hash = hash_of(in, std::filesystem::file_size(file));
  std::ofstream out(file, std::ios::binary | std::ios::app);
  out.write(kSeal.data(), kSeal.size());
  out.write(reinterpret_cast<const char*>(&hash), sizeof hash);
  out.close();
  if (!in || !out) throw Error(file.string(), "", std::strerror(errno), "a writable place");
}

TrustedVdb::TrustedVdb(const std::filesystem::path& file, const Rewrite& rewrite) : path_(file) {
  const Seal seal = seal_of(file);
  if (seal == Seal::kUnbroken) return;
  if (seal == Seal::kBroken)
    throw Error(file.string(), "", "bytes that changed since it was written", "an undamaged file");
  Walker(file).walk();
  std::string pattern = (std::filesystem::temp_directory_path() / "typodont_vdb_XXXXXX").string();
  const int made = mkstemp(pattern.data());
  if (made < 0) throw Error(pattern, "", std::strerror(errno), "a folder for temporary files");
  close(made);
  path_ = pattern;
  copy_ = true;
  if (succeeds_elsewhere(path_, [&] { rewrite(file, path_); }) && seal_of(path_) == Seal::kUnbroken) return;
  std::ifstream in(path_, std::ios::binary);
  std::string message{std::istreambuf_iterator<char>(in), {}};
  std::filesystem::remove(path_);
  if (message.empty() || message.size() > kLongestMessage || message.find('\0') != std::string::npos)
    throw Error(file.string(), "", "a damaged VDB file, which OpenVDB cannot read", "an undamaged file");
  throw Error(message);
}

TrustedVdb::~TrustedVdb() {
  std::error_code code;
  if (copy_) std::filesystem::remove(path_, code);
}

}  // namespace typodont::haptics
