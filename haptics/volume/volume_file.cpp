#include "haptics/volume/volume_file.h"

#include <fmt/format.h>
#include <openvdb/io/File.h>
#include <openvdb/tools/ChangeBackground.h>

#include <algorithm>
#include <cmath>
#include <new>

#include "engine/base/error.h"
#include "engine/base/input_file.h"
#include "engine/base/partial_file.h"
#include "engine/base/units.h"
#include "engine/contract/tissue.h"
#include "haptics/hardness.h"
#include "haptics/volume/vdb_guard.h"

namespace typodont::haptics {
namespace {

constexpr const char* kBeforeFilling = "tissue_before_filling";
constexpr const char* kHardness = "hardness";

/// Multiplies all distances, clamped to the band: from voxels to mm and back.
void rescale(openvdb::FloatGrid& grid, float factor) {
  const float band = grid.background();
  for (auto it = grid.beginValueAll(); it; ++it) it.setValue(std::clamp(*it, -band, band) * factor);
  openvdb::tools::changeBackground(grid.tree(), band * factor, /*threaded=*/false);
}

/// The grids as they are in the file. Throws Error naming `name`.
StoredVolume read_grids(const std::filesystem::path& file, const std::string& name) {
  StoredVolume grids;
  try {
    openvdb::io::File vdb(file.string());
    vdb.setCopyMaxBytes(0);  // read now, all of it: a truncated file must fail here and not in the middle of a session
    vdb.open(false);
    const auto typed = [&]<class Grid>(const char* grid_name, typename Grid::Ptr& grid) {
      if (!vdb.hasGrid(grid_name)) throw Error(name, "", fmt::format("no grid \"{}\"", grid_name), "a tissue volume");
      const auto base = vdb.readGrid(grid_name);
      grid = openvdb::gridPtrCast<Grid>(base);
      if (!grid) throw Error(name, grid_name, base->valueType(), Grid().valueType());
    };
    typed.operator()<openvdb::FloatGrid>("distance", grids.distance);
    typed.operator()<openvdb::Int32Grid>("tissue", grids.tissue);
    if (vdb.hasGrid(kBeforeFilling)) typed.operator()<openvdb::Int32Grid>(kBeforeFilling, grids.before);
    if (vdb.hasGrid(kHardness)) typed.operator()<openvdb::Int32Grid>(kHardness, grids.hardness);
  } catch (const openvdb::Exception& e) {
    throw Error(name, "", e.what(), "a tissue volume (.vdb)");
  } catch (const std::bad_alloc&) {
    throw Error(name, "", "sizes beyond this machine's memory", "a tissue volume (.vdb)");
  }
  return grids;
}

/// Throws what OpenVDB throws.
void write_grids(const std::filesystem::path& file, const StoredVolume& volume) {
  openvdb::GridCPtrVec grids{volume.distance, volume.tissue};
  if (volume.before) grids.push_back(volume.before);
  if (volume.hardness) grids.push_back(volume.hardness);
  openvdb::io::File vdb(file.string());
  vdb.setCompression(openvdb::io::COMPRESS_ACTIVE_MASK | openvdb::io::COMPRESS_BLOSC);
  vdb.write(grids);
  vdb.close();
  seal_vdb(file);
}

/// A file made elsewhere may hold anything, so every value is checked once. Throws Error naming `name`.
void check_values(const StoredVolume& volume, const std::string& name) {
  for (auto it = volume.distance->cbeginValueAll(); it; ++it) {
    if (!std::isfinite(*it)) throw Error(name, "distance", "a value that is not finite", "distances in mm");
  }
  for (auto it = volume.tissue->cbeginValueAll(); it; ++it) {
    if (*it < 0 || *it >= kTissueCount) {
      throw Error(name, "tissue", fmt::format("label {}", *it), fmt::format("0 to {}", kTissueCount - 1));
    }
  }
  if (volume.hardness) {
    for (auto it = volume.hardness->cbeginValueAll(); it; ++it) {
      if (*it < kLeastHardness || *it > kOwnHardness) {
        throw Error(name, kHardness, fmt::format("{}", *it), fmt::format("{} to {}", kLeastHardness, kOwnHardness));
      }
    }
    const std::int32_t elsewhere = volume.hardness->background();
    if (elsewhere != kOwnHardness)
      throw Error(name, kHardness, fmt::format("background {}", elsewhere), fmt::format("{}", kOwnHardness));
  }
  if (!volume.before) return;
  for (auto it = volume.before->cbeginValueOn(); it; ++it) {
    if (!it.isVoxelValue() || *it < 1 || *it > kTissueCount) {
      throw Error(name, kBeforeFilling, fmt::format("{}", *it), fmt::format("voxels of 1 to {}", kTissueCount));
    }
  }
}

}  // namespace

StoredVolume read_volume(const std::filesystem::path& file) {
  const std::string name = file.string();
  require_input(file, InputKind::kVolume);
  openvdb::initialize();
  StoredVolume volume;
  {
    const TrustedVdb trusted(file, [&](const std::filesystem::path& from, const std::filesystem::path& to) {
      write_grids(to, read_grids(from, name));
    });
    volume = read_grids(trusted.path(), name);
  }

  const auto& transform = volume.distance->transform();
  const openvdb::Vec3d size = transform.voxelSize();
  if (!transform.isLinear() || !transform.hasUniformScale() || size.x() < 1e-3 || size.x() > 10) {
    throw Error(name, "distance", "a voxel that is not a cube of 0.001 to 10 mm", "a tissue volume");
  }
  const openvdb::Vec3d origin = transform.indexToWorld(openvdb::Vec3d(0, 0, 0));
  volume.frame.voxel = size.x() * kMillimetre;
  volume.frame.origin = dvec3(origin.x(), origin.y(), origin.z()) * kMillimetre;
  const float band = volume.distance->background();
  if (!(band > 0) || !std::isfinite(band)) throw Error(name, "distance", fmt::format("band {}", band), "above 0");
  volume.band = static_cast<double>(band) * kMillimetre;
  if (const auto flag = volume.distance->getMetadata<openvdb::BoolMetadata>("typodont_exact_outside")) {
    volume.exact_outside = flag->value();
  }
  check_values(volume, name);
  rescale(*volume.distance, static_cast<float>(1 / size.x()));
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
  volume.tissue->setName("tissue");
  volume.tissue->setTransform(transform());
  if (volume.before) volume.before->setName(kBeforeFilling), volume.before->setTransform(transform());
  if (volume.hardness) volume.hardness->setName(kHardness), volume.hardness->setTransform(transform());

  PartialFile partial(file, FileKind::kVolume);
  try {
    write_grids(partial.path(), volume);
  } catch (const std::exception& e) {
    throw Error(file.string(), "", e.what(), "a writable place");
  }
  partial.keep();
}

}  // namespace typodont::haptics
