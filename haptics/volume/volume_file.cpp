#include "haptics/volume/volume_file.h"

#include <fmt/format.h>
#include <openvdb/io/File.h>
#include <openvdb/tools/ChangeBackground.h>

#include <algorithm>
#include <array>
#include <cmath>

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
constexpr double kSmallBox = 1e8, kBoxPerVoxel = 2000, kMaxBox = 1e9;

/// Limits all distances to ± band and multiplies them by `factor`, which converts between voxels and mm.
void rescale(openvdb::FloatGrid& grid, float factor) {
  const float band = grid.background();
  for (auto it = grid.beginValueAll(); it; ++it) it.setValue(std::clamp(*it, -band, band) * factor);
  openvdb::tools::changeBackground(grid.tree(), band * factor, /*threaded=*/false);
}

/// Finds the grids of a volume file, with values as stored. Throws Error with `name`.
StoredVolume read_grids(const FlatGrids& flat, const std::string& name) {
  StoredVolume grids;
  const auto typed = [&]<class Grid>(const char* grid_name, typename Grid::Ptr& grid, bool needed) {
    const auto found = flat.grids.find(grid_name);
    if (found == flat.grids.end()) {
      if (needed) throw Error(name, "", fmt::format("no grid \"{}\"", grid_name), "a tissue volume");
      return;
    }
    grid = openvdb::gridPtrCast<Grid>(found->second);
    if (!grid) throw Error(name, grid_name, found->second->valueType(), Grid().valueType());
  };
  typed.operator()<openvdb::FloatGrid>("distance", grids.distance, true);
  typed.operator()<openvdb::Int32Grid>("tissue", grids.tissue, true);
  typed.operator()<openvdb::Int32Grid>(kBeforeFilling, grids.before, false);
  typed.operator()<openvdb::Int32Grid>(kHardnessGrid, grids.hardness, false);
  typed.operator()<openvdb::Int32Grid>(kColorGrid, grids.color, false);
  return grids;
}

/// Writes the grids. Throws the exceptions of OpenVDB.
void write_grids(const std::filesystem::path& file, const StoredVolume& volume) {
  openvdb::GridCPtrVec grids{volume.distance, volume.tissue};
  if (volume.before) grids.push_back(volume.before);
  if (volume.hardness) grids.push_back(volume.hardness);
  if (volume.color) grids.push_back(volume.color);
  openvdb::io::File vdb(file.string());
  vdb.setCompression(openvdb::io::COMPRESS_ACTIVE_MASK | openvdb::io::COMPRESS_BLOSC);
  vdb.write(grids);
  vdb.close();
  seal_vdb(file);
}

/// Checks all values, because another program may have written the file. Throws Error with `name`.
void check_values(const StoredVolume& volume, const std::string& name) {
  for (auto it = volume.distance->cbeginValueAll(); it; ++it) {
    if (!std::isfinite(*it)) throw Error(name, "distance", "a value that is not finite", "distances in mm");
  }
  for (auto it = volume.tissue->cbeginValueAll(); it; ++it) {
    if (*it < 0 || *it >= kTissueCount) {
      throw Error(name, "tissue", fmt::format("label {}", *it), fmt::format("0 to {}", kTissueCount - 1));
    }
  }
  const auto check_range = [&](const openvdb::Int32Grid::Ptr& grid, const char* grid_name, int min, int max,
                               int elsewhere) {
    if (!grid) return;
    for (auto it = grid->cbeginValueAll(); it; ++it) {
      if (*it < min || *it > max)
        throw Error(name, grid_name, fmt::format("{}", *it), fmt::format("{} to {}", min, max));
    }
    if (grid->background() != elsewhere)
      throw Error(name, grid_name, fmt::format("background {}", grid->background()), fmt::format("{}", elsewhere));
  };
  check_range(volume.hardness, kHardnessGrid, kMinHardness, kOwnHardness, kOwnHardness);
  check_range(volume.color, kColorGrid, kNoFileColor, 0xffffff, kNoFileColor);
  if (!volume.before) return;
  for (auto it = volume.before->cbeginValueOn(); it; ++it) {
    if (!it.isVoxelValue() || *it < 1 || *it > kTissueCount) {
      throw Error(name, kBeforeFilling, fmt::format("{}", *it), fmt::format("voxels of 1 to {}", kTissueCount));
    }
  }
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
  const dvec3 p = dvec3(flat.file_origin.x(), flat.file_origin.y(), flat.file_origin.z()) * kMillimetre;
  if (!is_finite(p) || glm::length(p) > kFarthestOrigin)
    throw Error(name, kFileOrigin, "a position far away", "one within 100 m");
  return {{p, glm::normalize(glm::quat_cast(rotation))}, patient_axes(flat.axes)};
}

/// Checks that no voxel is far away from the others. Throws Error with `name`.
void check_extent(const StoredVolume& volume, const std::string& name) {
  openvdb::CoordBBox box = volume.distance->evalActiveVoxelBoundingBox();
  box.expand(volume.tissue->evalActiveVoxelBoundingBox());
  if (volume.before) box.expand(volume.before->evalActiveVoxelBoundingBox());
  if (box.empty()) return;
  double voxels = 1;
  for (int axis = 0; axis < 3; ++axis) voxels *= static_cast<double>(box.max()[axis]) - box.min()[axis] + 1;
  const auto stored = static_cast<double>(volume.distance->tree().activeLeafVoxelCount());
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
  const FlatGrids flat = read_guarded(file, kGrids);
  StoredVolume volume = read_grids(flat, name);
  if (!(flat.voxel >= 1e-3 && flat.voxel <= 10)) {
    throw Error(name, "distance", "a voxel that is not a cube of 0.001 to 10 mm", "a tissue volume");
  }
  volume.frame.voxel = flat.voxel * kMillimetre;
  volume.frame.origin = dvec3(flat.origin.x(), flat.origin.y(), flat.origin.z()) * kMillimetre;
  if (!is_finite(volume.frame.origin) || glm::length(volume.frame.origin) > kFarthestOrigin)
    throw Error(name, "distance", "an origin far away", "one within 100 m");
  const float band = volume.distance->background();
  if (!(band > 0) || !std::isfinite(band)) throw Error(name, "distance", fmt::format("band {}", band), "above 0");
  volume.band = static_cast<double>(band) * kMillimetre;
  volume.exact_outside = flat.exact_outside;
  volume.place = place_in(flat, name);
  check_values(volume, name);
  check_extent(volume, name);
  rescale(*volume.distance, static_cast<float>(1 / flat.voxel));
  return volume;
}

void write_volume(const std::filesystem::path& file, const StoredVolume& volume) {
  const double mm = volume.frame.voxel / kMillimetre;
  const auto transform = [&] {
    auto t = openvdb::math::Transform::createLinearTransform(mm);
    const dvec3 o = volume.frame.origin / kMillimetre;
    t->postTranslate({o.x, o.y, o.z});
    return t;
  };
  rescale(*volume.distance, static_cast<float>(mm));
  volume.distance->setName("distance");
  volume.distance->setGridClass(openvdb::GRID_LEVEL_SET);
  volume.distance->setTransform(transform());
  volume.distance->insertMeta("typodont_version", openvdb::StringMetadata(TYPODONT_VERSION));
  volume.distance->insertMeta("typodont_units", openvdb::StringMetadata("mm"));
  volume.distance->insertMeta("typodont_exact_outside", openvdb::BoolMetadata(volume.exact_outside));
  const glm::dmat3 rotation = glm::mat3_cast(volume.place.X_FW.R);
  for (int row = 0; row < 3; ++row) {
    volume.distance->insertMeta(
        kFileRotation[static_cast<std::size_t>(row)],
        openvdb::Vec3DMetadata(openvdb::Vec3d(rotation[0][row], rotation[1][row], rotation[2][row])));
  }
  const dvec3 p = volume.place.X_FW.p / kMillimetre;
  volume.distance->insertMeta(kFileOrigin, openvdb::Vec3DMetadata(openvdb::Vec3d(p.x, p.y, p.z)));
  if (volume.place.axes != PatientAxes::kUnknown)
    volume.distance->insertMeta(kFileAxes, openvdb::StringMetadata(std::string(name_of(volume.place.axes))));
  volume.tissue->setName("tissue");
  volume.tissue->setTransform(transform());
  if (volume.before) volume.before->setName(kBeforeFilling), volume.before->setTransform(transform());
  if (volume.hardness) volume.hardness->setName(kHardnessGrid), volume.hardness->setTransform(transform());
  if (volume.color) volume.color->setName(kColorGrid), volume.color->setTransform(transform());

  PartialFile partial(file, FileKind::kVolume);
  try {
    write_grids(partial.path(), volume);
    partial.keep();
  } catch (const Error&) {
    throw;
  } catch (const std::exception& e) {
    throw Error(file.string(), "", e.what(), "a writable place");
  }
}

}  // namespace typodont::haptics
