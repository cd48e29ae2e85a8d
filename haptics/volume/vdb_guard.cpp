#include "haptics/volume/vdb_guard.h"

#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/base/cache.h"
#include "engine/base/error.h"
#include "engine/base/fnv.h"
#include "engine/base/guarded_process.h"
#include "engine/base/temporary_folder.h"

namespace typodont::haptics {

namespace {

constexpr std::uint64_t kMagic = 0x56444220;  // "VDB ": first bytes of an OpenVDB file
constexpr std::uint32_t kOldest = 218;        // oldest supported format, the first with a UUID (openvdb/version.h)
constexpr std::uint32_t kUuidBytes = 36;

constexpr std::string_view kSeal = "TYPODONT";
constexpr std::size_t kSealBytes = kSeal.size() + sizeof(std::uint64_t);
constexpr std::size_t kLongestMessage = 1000;    // bytes, longest message of the process that is shown
constexpr std::uintmax_t kMaxKept = 2ull << 30;  // bytes, largest size of the cache

/// FNV-1a hash of the first `bytes` bytes.
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

/// A file that the destructor deletes. It has a name, unlike those of dicom_process.cpp: if the program has
/// capabilities (setcap), the other process cannot open /proc/PID/fd.
class TemporaryFile {
 public:
  TemporaryFile() : descriptor_(mkstemp(file_.data())) {
    if (descriptor_ < 0) throw Error(file_, "", std::strerror(errno), "a folder for temporary files");
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile() {
    close(descriptor_);
    unlink(file_.c_str());
  }
  const std::string& file() const { return file_; }
  int descriptor() const { return descriptor_; }

 private:
  std::string file_ = (temporary_place() / "typodont_volume_XXXXXX").string();
  int descriptor_;
};

[[noreturn]] void throw_no_room(const std::filesystem::path& file) {
  throw Error(temporary_place().string(), "", fmt::format("no room for a copy of {}", file.string()),
              "free space in the folder for temporary files; TMPDIR names another one");
}

struct Ended {
  int status;           // exit status; -1: by a signal
  std::string message;  // what the process wrote to standard output
};
/// Runs the process that has OpenVDB.
Ended run_vdb(std::vector<std::string> words) {
  words.insert(words.begin(),
               companion_program("TYPODONT_OPENVDB", "typodont-openvdb", TYPODONT_OPENVDB, "the one that has OpenVDB"));
  const int said = memfd_create("message", MFD_CLOEXEC);
  Ended ended{run_guarded(words, said), std::string(kLongestMessage + 1, '\0')};
  const ssize_t length = pread(said, ended.message.data(), ended.message.size(), 0);
  ended.message.resize(static_cast<std::size_t>(std::max<ssize_t>(length, 0)));
  close(said);
  if (ended.message.size() > kLongestMessage || ended.message.find('\0') != std::string::npos) ended.message.clear();
  return ended;
}

/// Writes FlatGrids or a DistanceGrid to a temporary file.
template <class Content>
void write_copy(const TemporaryFile& copy, const Content& content, const std::filesystem::path& name) {
  try {
    write_flat(copy.descriptor(), copy.file(), content);
  } catch (const WriteFailure&) {
    throw_no_room(name);
  }
}

/// Walks over header, metadata and descriptors of formats 218 to 224 (OpenVDB 4 and later).
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

FlatGrids read_guarded(const std::filesystem::path& file, std::span<const std::string> grids) {
  const std::string name = file.string();
  const Seal seal = seal_of(file);
  if (seal == Seal::kBroken) throw Error(name, "", "bytes that changed since it was written", "an undamaged file");
  if (seal == Seal::kNone) Walker(file).walk();

  // The grids are cached by the hash of the file's content, because every start reads the volume of a scene.
  Sha256 key;
  key.add(cache::hash_of(file).value_or(0));
  key.add(std::filesystem::file_size(file));
  for (const std::string& grid : grids) key.bytes(grid.data(), grid.size());
  cache::add_build(key);
  const std::filesystem::path folder = cache::folder("volumes");
  if (const auto flat = cache::find(folder, key.key(), ".flat"); !flat.empty()) return read_flat_grids(flat, name);

  const TemporaryFile copy;
  std::vector<std::string> words = {"read", name, copy.file()};
  words.insert(words.end(), grids.begin(), grids.end());
  const Ended ended = run_vdb(std::move(words));
  if (ended.status == 0) {
    FlatGrids result = read_flat_grids(copy.file(), name);
    cache::keep(folder, key.key(), ".flat", kMaxKept, [&](const std::filesystem::path& to) {
      std::filesystem::copy_file(copy.file(), to, std::filesystem::copy_options::overwrite_existing);
    });
    return result;
  }
  if (ended.status == kCannotWrite) throw_no_room(file);
  if (ended.message.empty())
    throw Error(name, "", "a damaged VDB file, which OpenVDB cannot read", "an undamaged file");
  throw Error(ended.message);
}

void write_vdb(const std::filesystem::path& file, const FlatGrids& grids, const std::filesystem::path& name) {
  const TemporaryFile copy;
  write_copy(copy, grids, name);
  const Ended ended = run_vdb({"write", copy.file(), file.string()});
  if (ended.status != 0)
    throw Error(name.string(), "", ended.message.empty() ? "a process that failed" : ended.message, "a writable place");
  seal_vdb(file);
}

FlatMesh surface_of(const DistanceGrid& distances) {
  const std::string name = "surface of the tissue";
  const TemporaryFile copy, mesh;
  write_copy(copy, distances, name);
  const Ended ended = run_vdb({"mesh", copy.file(), mesh.file()});
  if (ended.status == kCannotWrite) throw_no_room(name);
  if (ended.status != 0) throw Error(name, "", ended.message.empty() ? "a process that failed" : ended.message, "");
  return read_flat_mesh(mesh.file(), name);
}

}  // namespace typodont::haptics
