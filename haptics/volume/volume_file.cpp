#include "haptics/volume/volume_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <utility>

#include "engine/base/error.h"
#include "engine/base/input_file.h"
#include "engine/base/partial_file.h"
#include "engine/base/pose.h"
#include "engine/base/units.h"
#include "engine/contract/tissue.h"
#include "haptics/dense_tissue.h"
#include "haptics/volume/vdb_guard.h"

namespace typodont::haptics {
namespace {

constexpr const char* kBeforeFilling = "tissue_before_filling";
constexpr const char* kHardnessGrid = "hardness";
constexpr const char* kColorGrid = "color";
constexpr double kFarthestOrigin = 100;  // m, largest coordinate of the origin of a volume
// Largest number of voxels in the box around the tissue; memory and time depend on it. kSmallBox is always allowed,
// otherwise kBoxPerVoxel per stored distance, at most kMaxBox. Teeth and jaws have 5 to 50 voxels per stored distance.
constexpr double kSmallBox = 1e8, kBoxPerVoxel = 2000, kMaxBox = kMaxTileVoxels;

/// Limits all distances to ± band and multiplies them by `factor`, which converts between voxels and mm.
void rescale(DistanceGrid& grid, float factor) {
  const float band = grid.background();
  grid.transform([=](float d) { return std::clamp(d, -band, band) * factor; });
}

/// Moves the grids of a volume file, with values as stored, out of `flat`. Throws Error with `name`.
StoredVolume take_grids(FlatGrids& flat, const std::string& name) {
  StoredVolume grids;
  const auto take = [&]<class Grid>(const char* grid_name, Grid& grid) {
    const auto found = flat.grids.find(grid_name);
    if (found == flat.grids.end()) return false;
    Grid* const typed = std::get_if<Grid>(&found->second);
    if (!typed) {
      constexpr std::array<const char*, 2> kTypes = {"float", "int32"};
      const std::size_t is = found->second.index();
      throw Error(name, grid_name, kTypes[is], kTypes[1 - is]);
    }
    grid = std::move(*typed);
    return true;
  };
  const auto need = [&](const char* grid_name, auto& grid) {
    if (!take(grid_name, grid)) throw Error(name, "", fmt::format("no grid \"{}\"", grid_name), "a tissue volume");
  };
  const auto find = [&](const char* grid_name, std::optional<LabelGrid>& grid) {
    if (!take(grid_name, grid.emplace())) grid.reset();
  };
  need("distance", grids.distance);
  need("tissue", grids.tissue);
  find(kBeforeFilling, grids.before);
  find(kHardnessGrid, grids.hardness);
  find(kColorGrid, grids.color);
  return grids;
}

/// Calls check(value) for all values except those of the surroundings.
template <class Grid, class Check>
void for_each_value(const Grid& grid, const Check& check) {
  grid.for_each_block([&](const glm::ivec3&, const typename Grid::Block& block) {
    if (block.leaf) {
      std::ranges::for_each(block.leaf->values, check);
    } else {
      check(block.tile);
    }
  });
}

/// Checks all values, because another program may have written the file. Throws Error with `name`.
void check_values(const StoredVolume& volume, const std::string& name) {
  for_each_value(volume.distance, [&](float value) {
    if (!std::isfinite(value)) throw Error(name, "distance", "a value that is not finite", "distances in mm");
  });
  const auto check_tissue = [&](std::int32_t value) {
    if (value < 0 || value >= kTissueCount)
      throw Error(name, "tissue", fmt::format("label {}", value), fmt::format("0 to {}", kTissueCount - 1));
  };
  check_tissue(volume.tissue.background());
  for_each_value(volume.tissue, check_tissue);
  const auto check_range = [&](const std::optional<LabelGrid>& grid, const char* grid_name, int min, int max,
                               int elsewhere) {
    if (!grid) return;
    for_each_value(*grid, [&](std::int32_t value) {
      if (value < min || value > max)
        throw Error(name, grid_name, fmt::format("{}", value), fmt::format("{} to {}", min, max));
    });
    if (grid->background() != elsewhere)
      throw Error(name, grid_name, fmt::format("background {}", grid->background()), fmt::format("{}", elsewhere));
  };
  check_range(volume.hardness, kHardnessGrid, kMinHardness, kOwnHardness, kOwnHardness);
  check_range(volume.color, kColorGrid, kNoFileColor, 0xffffff, kNoFileColor);
  if (!volume.before) return;
  volume.before->for_each_block([&](const glm::ivec3&, const LabelGrid::Block& block) {
    for (int i = 0; i < LabelGrid::kSize; ++i) {
      const std::int32_t value = block.value(i);
      if (block.is_on(i) && (!block.leaf || value < 1 || value > kTissueCount))
        throw Error(name, kBeforeFilling, fmt::format("{}", value), fmt::format("voxels of 1 to {}", kTissueCount));
    }
  });
}

/// Reads where the tissue lies in the file from which it was imported. Throws Error with `name`.
FilePlace place_in(const FlatGrids& flat, const std::string& name) {
  glm::dmat3 rotation;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      rotation[column][row] = flat.rotation[static_cast<std::size_t>(row)][column];
  }
  const glm::dmat3 product = rotation * glm::transpose(rotation);
  double error = std::abs(glm::determinant(rotation) - 1);
  for (int column = 0; column < 3; ++column) error += glm::length(product[column] - glm::dmat3(1)[column]);
  constexpr double kMaxError = 1e-6;
  if (!(error < kMaxError)) throw Error(name, kFileRotation[0], "a matrix that is no rotation", "a rotation");
  const dvec3 p = flat.file_origin * kMillimetre;
  if (!is_finite(p) || glm::length(p) > kFarthestOrigin)
    throw Error(name, kFileOrigin, "a position far away", "one within 100 m");
  return {{p, glm::normalize(glm::quat_cast(rotation))}, patient_axes(flat.axes)};
}

/// Checks that no voxel is far away from the others. Throws Error with `name`.
void check_extent(const StoredVolume& volume, const std::string& name) {
  VoxelBox box = volume.distance.box_on();
  for (const VoxelBox& other : {volume.tissue.box_on(), volume.before ? volume.before->box_on() : VoxelBox{}})
    if (!other.empty()) extend(box, other);
  if (box.empty()) return;
  const dvec3 size(box.hi - box.lo + 1);
  const double voxels = size.x * size.y * size.z;
  double stored = 0;
  volume.distance.for_each_block([&](const glm::ivec3&, const DistanceGrid::Block& block) {
    if (block.leaf)
      for (const std::uint64_t on : block.leaf->on) stored += std::popcount(on);
  });
  const double most = std::clamp(kBoxPerVoxel * stored, kSmallBox, kMaxBox);
  if (voxels <= most) return;
  throw Error(name, "", fmt::format("tissue that is spread over {:.3g} voxels", voxels),
              fmt::format("at most {:.3g} voxels for {:.3g} stored distances", most, stored));
}

}  // namespace

StoredVolume read_volume(const std::filesystem::path& file) {
  const std::string name = file.string();
  require_input(file, InputKind::kVolume);
  static const std::array<std::string, 5> kGrids = {"distance", "tissue", kBeforeFilling, kHardnessGrid, kColorGrid};
  FlatGrids flat = read_guarded(file, kGrids);
  StoredVolume volume = take_grids(flat, name);
  if (!(flat.voxel >= 1e-3 && flat.voxel <= 10)) {
    throw Error(name, "distance", "a voxel that is not a cube of 0.001 to 10 mm", "a tissue volume");
  }
  volume.frame.voxel = flat.voxel * kMillimetre;
  volume.frame.origin = flat.origin * kMillimetre;
  if (!is_finite(volume.frame.origin) || glm::length(volume.frame.origin) > kFarthestOrigin)
    throw Error(name, "distance", "an origin far away", "one within 100 m");
  const float band = volume.distance.background();
  if (!(band > 0) || !std::isfinite(band)) throw Error(name, "distance", fmt::format("band {}", band), "above 0");
  volume.band = static_cast<double>(band) * kMillimetre;
  volume.exact_outside = flat.exact_outside;
  volume.place = place_in(flat, name);
  check_values(volume, name);
  check_extent(volume, name);
  rescale(volume.distance, static_cast<float>(1 / flat.voxel));
  return volume;
}

void write_volume(const std::filesystem::path& file, StoredVolume volume) {
  FlatGrids flat;
  flat.voxel = volume.frame.voxel / kMillimetre;
  flat.origin = volume.frame.origin / kMillimetre;
  flat.exact_outside = volume.exact_outside;
  const glm::dmat3 rotation = glm::mat3_cast(volume.place.X_FW.R);
  for (int row = 0; row < 3; ++row)
    flat.rotation[static_cast<std::size_t>(row)] = {rotation[0][row], rotation[1][row], rotation[2][row]};
  flat.file_origin = volume.place.X_FW.p / kMillimetre;
  if (volume.place.axes != PatientAxes::kUnknown) flat.axes = name_of(volume.place.axes);
  rescale(volume.distance, static_cast<float>(flat.voxel));
  flat.grids.emplace("distance", std::move(volume.distance));
  flat.grids.emplace("tissue", std::move(volume.tissue));
  if (volume.before) flat.grids.emplace(kBeforeFilling, std::move(*volume.before));
  if (volume.hardness) flat.grids.emplace(kHardnessGrid, std::move(*volume.hardness));
  if (volume.color) flat.grids.emplace(kColorGrid, std::move(*volume.color));
  PartialFile partial(file, FileKind::kVolume);
  write_vdb(partial.path(), flat, file);
  partial.keep();
}

}  // namespace typodont::haptics
