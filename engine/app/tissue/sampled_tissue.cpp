#include "engine/app/tissue/sampled_tissue.h"

#include <zlib.h>

#include <algorithm>
#include <memory>
#include <optional>

#include "engine/app/tissue/bone_tissue.h"
#include "engine/base/cache.h"
#include "engine/base/clock.h"
#include "engine/base/error.h"
#include "haptics/import/mesh_tissue.h"

namespace typodont {

namespace {

namespace fs = std::filesystem;

// ns; if no mesh was read and the sampling took less than this, the result is not stored in a file.
constexpr Nanos kWorthKeeping = kNanosPerSecond / 2;
constexpr std::uintmax_t kMaxKept = 1u << 30;  // bytes, largest total size of the cached files
constexpr const char* kSuffix = ".tissue.gz";

struct Close {
  void operator()(gzFile file) const { gzclose(file); }
};
using File = std::unique_ptr<gzFile_s, Close>;

/// Header of a cached file: everything except the voxels.
struct Head {
  VoxelFrame frame;
  glm::ivec3 size{0};
  double band = 0;
  bool exact_outside = false;
  // true: after the labels, the file stores a hardness per voxel (graded), then a colour per voxel (colored)
  bool graded = false, colored = false;
};

/// Processes the data in pieces, because zlib states sizes as int. False: a step failed.
template <class Bytes, class Step>
bool in_pieces(Bytes* data, std::size_t size, Step&& step) {
  constexpr std::size_t kPiece = 1u << 28;
  for (std::size_t at = 0; at < size;) {
    const int done = step(data + at, static_cast<unsigned>(std::min(kPiece, size - at)));
    if (done <= 0) return false;
    at += static_cast<std::size_t>(done);
  }
  return true;
}

template <class T>
bool put(gzFile file, const T* data, std::size_t count) {
  return in_pieces(reinterpret_cast<const char*>(data), count * sizeof(T),
                   [&](const char* p, unsigned n) { return gzwrite(file, p, n); });
}
template <class T>
bool get(gzFile file, T* data, std::size_t count) {
  return in_pieces(reinterpret_cast<char*>(data), count * sizeof(T),
                   [&](char* p, unsigned n) { return gzread(file, p, n); });
}

/// Writes the tissue. Throws Error.
void write(const fs::path& path, const haptics::DenseTissue& dense) {
  // Compression level 1: most values are equal, so higher levels take longer and save little.
  const File file(gzopen(path.c_str(), "wb1"));
  const Head head{dense.frame,         dense.size, dense.band, dense.exact_outside, !dense.hardness.empty(),
                  !dense.color.empty()};
  const bool written = file && put(file.get(), &head.frame, 1) && put(file.get(), &head.size, 1) &&
                       put(file.get(), &head.band, 1) && put(file.get(), &head.exact_outside, 1) &&
                       put(file.get(), &head.graded, 1) && put(file.get(), &head.colored, 1) &&
                       put(file.get(), dense.distance.data(), dense.distance.size()) &&
                       put(file.get(), dense.tissue.data(), dense.tissue.size()) &&
                       put(file.get(), dense.hardness.data(), dense.hardness.size()) &&
                       put(file.get(), dense.color.data(), dense.color.size()) && gzflush(file.get(), Z_FINISH) == Z_OK;
  if (!written) throw Error(path.string(), "", "not written", "a writable place");
}

/// Reads the tissue. Returns false if the file is not complete.
bool read(const fs::path& path, haptics::DenseTissue& dense) {
  const File file(gzopen(path.c_str(), "rb"));
  Head head;
  if (!file || !get(file.get(), &head.frame, 1) || !get(file.get(), &head.size, 1) || !get(file.get(), &head.band, 1) ||
      !get(file.get(), &head.exact_outside, 1) || !get(file.get(), &head.graded, 1) ||
      !get(file.get(), &head.colored, 1))
    return false;
  const auto count = static_cast<std::size_t>(head.size.x) * static_cast<std::size_t>(head.size.y) *
                     static_cast<std::size_t>(head.size.z);
  dense = {.frame = head.frame,
           .size = head.size,
           .distance = std::vector<float>(count),
           .tissue = std::vector<Tissue>(count),
           .hardness = std::vector<std::uint8_t>(head.graded ? count : 0),
           .color = std::vector<VoxelColor>(head.colored ? count : 0),
           .band = head.band,
           .exact_outside = head.exact_outside,
           .place = {}};
  return get(file.get(), dense.distance.data(), count) && get(file.get(), dense.tissue.data(), count) &&
         get(file.get(), dense.hardness.data(), dense.hardness.size()) &&
         get(file.get(), dense.color.data(), dense.color.size());
}

std::vector<Json> mesh_files_of(const Json& tissue) {
  const auto bone = tissue.find("bone");
  return haptics::mesh_files(bone ? *bone : tissue);
}

/// Key of the file in the cache `in`. Empty without a cache, or if a file cannot be read; the sampling then reports the
/// error.
std::optional<std::uint64_t> key_of(const fs::path& in, const Json& tissue, const haptics::SolidFiles& files) {
  if (in.empty()) return std::nullopt;
  Sha256 key;
  cache::add_build(key);
  const std::string text = tissue.text();
  key.bytes(text.data(), text.size());
  for (const Json& name : mesh_files_of(tissue)) {
    const auto content = cache::hash_of(files.find(name));
    if (!content) return std::nullopt;
    key.add(*content);
  }
  if (tissue.has("bone")) {
    const auto classes = cache::hash_of(bone_classes_file());
    if (!classes) return std::nullopt;
    key.add(*classes);
  }
  return key.key();
}

haptics::DenseTissue sample(const Json& tissue, const haptics::SolidFiles& files) {
  if (const auto bone = tissue.find("bone")) return sample_bone(*bone, files);
  const auto mesh = tissue.find("mesh");
  if (!mesh) return haptics::read_solids(tissue, files);
  const haptics::MeshTissueOptions options = haptics::read_mesh_tissue_options(*mesh);
  return haptics::rasterize(haptics::read_tissue_mesh(files.find((*mesh)["file"]), options).mesh, options);
}

}  // namespace

haptics::DenseTissue sampled_tissue(const Json& tissue, const haptics::SolidFiles& files) {
  const fs::path in = cache::folder("tissue");
  const auto key = key_of(in, tissue, files);
  if (key) {
    haptics::DenseTissue kept;
    if (const fs::path file = cache::find(in, *key, kSuffix); !file.empty() && read(file, kept)) return kept;
  }
  const Nanos began = now();
  haptics::DenseTissue dense = sample(tissue, files);
  if (key && (!mesh_files_of(tissue).empty() || now() - began > kWorthKeeping))
    cache::keep(in, *key, kSuffix, kMaxKept, [&](const fs::path& file) { write(file, dense); });
  return dense;
}

}  // namespace typodont
