#include "engine/app/recording/resume.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "engine/app/assets.h"
#include "engine/app/recording/recorded_tissue.h"
#include "engine/app/recording/replay.h"
#include "engine/base/error.h"

namespace typodont {

namespace {

/// Loads the unfinished preparation that the scene continues. Throws Error if its voxel grid differs from that of
/// `untouched`, the scene's own tissue.
haptics::TissueVolume resumed_tissue(const Scene& scene, const haptics::TissueVolume& untouched) {
  const std::filesystem::path file = find_file(scene.resume, scene.place);
  haptics::TissueVolume tissue = [&] {
    if (file.extension() == ".vdb") return haptics::TissueVolume::load(file);
    const session::SessionReader session(file);
    const Scene its = scene_of(session, scene.place);
    return tissue_at_end(session, its, load_tissue(its));
  }();
  const VoxelFrame &is = tissue.frame(), &expected = untouched.frame();
  if (std::abs(is.voxel - expected.voxel) > 1e-9 || glm::length(is.origin - expected.origin) > 1e-6) {
    const auto words = [](const VoxelFrame& f) {
      return fmt::format("voxels of {:.4f} mm from ({:.3f}, {:.3f}, {:.3f}) mm", f.voxel * 1e3, f.origin.x * 1e3,
                         f.origin.y * 1e3, f.origin.z * 1e3);
    };
    throw Error(file.string(), "", words(is), words(expected) + ", as the scene's tissue has them");
  }
  tissue.set_natural_surface(untouched.natural_surface());
  tissue.set_place(untouched.place());
  return tissue;
}

}  // namespace

Scene with_resume(const Scene& scene, const std::filesystem::path& file) {
  if (file.extension() != ".vdb" && file.extension() != ".h5")
    throw Error("--resume", "", file.string(), "a volume (.vdb) or a session (.h5)");
  auto json = nlohmann::ordered_json::parse(scene.text);
  json["resume"] = std::filesystem::absolute(file).string();
  return parse_scene(Json::parse(json.dump(2), scene.file.string(), Json::Lines::kUnknown), scene.file, scene.place);
}

haptics::TissueVolume load_tissue(const Scene& scene) {
  haptics::TissueVolume untouched = load_untouched(scene);
  return scene.resume.empty() ? std::move(untouched) : resumed_tissue(scene, untouched);
}

StoredTissue stored_tissue(const std::filesystem::path& file, const std::function<void(double)>& progress) {
  if (file.extension() == ".vdb") return {haptics::TissueVolume::load(file), load_materials()};
  if (file.extension() != ".h5") {
    const Scene scene = read_scene(file);
    return {load_tissue(scene), scene.servo.materials};
  }
  const session::SessionReader reader(file);
  const Scene scene = scene_of(reader);
  if (progress) progress(0.1);
  haptics::TissueVolume start = load_tissue(scene);
  const haptics::FilePlace place = start.place();
  StoredTissue stored{tissue_at_end(reader, scene, std::move(start)), scene.servo.materials, draws_own_surface(scene)};
  stored.volume.set_place(place);
  return stored;
}

}  // namespace typodont
