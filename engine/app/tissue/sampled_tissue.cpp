#include "engine/app/tissue/sampled_tissue.h"

#include <optional>

#include "engine/app/tissue/bone_tissue.h"
#include "engine/base/cached_result.h"
#include "haptics/import/mesh_tissue.h"

namespace typodont {

namespace {

// Samples of meshes are always stored.
constexpr cache::Shelf kMeshSamples{"tissue", ".tissue.gz", 1u << 30, 0, /*compressed=*/true};
constexpr cache::Shelf kSamples{"tissue", ".tissue.gz", 1u << 30, kNanosPerSecond / 2, /*compressed=*/true};

bool parts_of(cache::Parts& file, haptics::DenseTissue& dense) {
  return file.value(dense.frame) && file.value(dense.size) && file.value(dense.band) &&
         file.value(dense.exact_outside) && file.values(dense.distance) && file.values(dense.tissue) &&
         file.values(dense.hardness) && file.values(dense.color);
}

std::vector<Json> mesh_files_of(const Json& tissue) {
  const auto bone = tissue.find("bone");
  return haptics::mesh_files(bone ? *bone : tissue);
}

/// Key in the cache. Empty if a file cannot be read; the sampling then reports the error.
std::optional<std::uint64_t> key_of(const Json& tissue, const haptics::SolidFiles& files) {
  Sha256 key;
  cache::add_build(key);
  const std::string text = tissue.text();
  key.bytes(text.data(), text.size());
  for (const Json& name : mesh_files_of(tissue)) {
    const auto content = cache::hash_of(files.find(name));
    if (!content) return std::nullopt;
    key.add(*content);
  }
  if (const auto bone = tissue.find("bone"))
    for (const std::filesystem::path& file : bone_files(*bone)) {
      const auto content = cache::hash_of(file);
      if (!content) return std::nullopt;
      key.add(*content);
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
  haptics::DenseTissue dense;
  cache::read_or_make(
      mesh_files_of(tissue).empty() ? kSamples : kMeshSamples, key_of(tissue, files),
      [&](cache::Parts& file) { return parts_of(file, dense); }, [&] { dense = sample(tissue, files); });
  return dense;
}

}  // namespace typodont
