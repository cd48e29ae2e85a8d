#include "engine/app/tissue/tissue_edit.h"

#include <algorithm>

#include "engine/base/error.h"
#include "engine/base/voxels.h"
#include "haptics/solid.h"

namespace typodont {

namespace {

constexpr float kLabelled = 2;  // voxels; air nearer to a solid has the solid's label, for interpolation

}  // namespace

DenseCopy dense_copy(const haptics::TissueVolume& volume) {
  glm::ivec3 lo, hi;
  volume.bounds(lo, hi);
  return dense_copy(volume, lo - 2, hi - lo + 5);
}

DenseCopy dense_copy(const haptics::TissueVolume& volume, const glm::ivec3& lo, const glm::ivec3& size) {
  DenseCopy copy;
  copy.frame = {volume.frame().to_world(dvec3(lo)), volume.frame().voxel};
  copy.field.size = size;
  copy.place = volume.place();
  const std::size_t count = voxel_count(size);
  copy.field.distance.resize(count);
  copy.tissue.resize(count);
  if (volume.graded()) copy.hardness.resize(count);
  volume.copy(lo, size, copy.field.distance.data(), copy.tissue.data(),
              copy.hardness.empty() ? nullptr : copy.hardness.data());
  if (!volume.colored()) return copy;
  copy.color.resize(count);
  volume.copy_colors(lo, size, copy.color.data());
  return copy;
}

haptics::DenseTissue dense_tissue(const haptics::TissueVolume& volume, const std::string& file) {
  glm::ivec3 lo, hi;
  volume.bounds(lo, hi);
  if (lo.x > hi.x) throw Error(file, "", "no surface", "tissue");
  DenseCopy copy = dense_copy(volume, lo - 1, hi - lo + 3);
  haptics::DenseTissue dense;
  dense.size = copy.field.size;
  dense.frame = copy.frame;
  dense.band = volume.band();
  dense.exact_outside = volume.exact_outside();
  dense.place = copy.place;
  dense.distance = std::move(copy.field.distance);
  dense.tissue = std::move(copy.tissue);
  dense.hardness = std::move(copy.hardness);
  dense.color = std::move(copy.color);
  for (float& d : dense.distance) d *= static_cast<float>(dense.frame.voxel);
  return dense;
}

haptics::TissueVolume from_dense(const DenseCopy& copy, double band) {
  haptics::DenseTissue dense;
  dense.frame = copy.frame;
  dense.size = copy.field.size;
  dense.band = band;
  dense.exact_outside = false;
  dense.place = copy.place;
  dense.tissue = copy.tissue;
  dense.hardness = copy.hardness;
  dense.color = copy.color;
  dense.distance.reserve(copy.field.distance.size());
  for (const float d : copy.field.distance) {
    dense.distance.push_back(static_cast<float>(std::clamp(static_cast<double>(d) * copy.frame.voxel, -band, band)));
  }
  return haptics::TissueVolume(dense);
}

session::DenseField label_distance(const DenseCopy& copy, const std::vector<Tissue>& wanted) {
  const glm::ivec3 n = copy.field.size;
  std::vector<float> marked(copy.tissue.size());
  for (std::size_t i = 0; i < marked.size(); ++i) {
    marked[i] = std::find(wanted.begin(), wanted.end(), copy.tissue[i]) != wanted.end() ? 1.0f : 0.0f;
  }
  // Box filter of three voxels along each axis.
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<float> blurred(marked.size());
    for_each_voxel(n, [&](int x, int y, int z) {
      glm::ivec3 lo(x, y, z), hi(x, y, z);
      lo[axis] = std::max(0, lo[axis] - 1);
      hi[axis] = std::min(n[axis] - 1, hi[axis] + 1);
      blurred[copy.field.at(x, y, z)] = (marked[copy.field.at(lo.x, lo.y, lo.z)] + marked[copy.field.at(x, y, z)] +
                                         marked[copy.field.at(hi.x, hi.y, hi.z)]) /
                                        3;
    });
    marked = std::move(blurred);
  }
  session::DenseField field{n, std::move(marked)};
  // The fraction of wanted voxels changes by about 1/3 per voxel. The surface is moved out by 0.4 voxels, because the
  // filter cuts off corners. Where the fraction is 0 or 1, redistanced() replaces the value ±kFar.
  constexpr float kFar = 3;
  for (float& v : field.distance) v = v <= 0 ? kFar : v >= 1 ? -kFar : (0.5f - v) * 3 - 0.4f;
  return session::redistanced(field);
}

haptics::TissueVolume without_solid(const haptics::TissueVolume& volume, const haptics::Solid& solid) {
  DenseCopy copy = dense_copy(volume);
  const glm::ivec3 n = copy.field.size;
  for_each_voxel(n, [&](int x, int y, int z) {
    float& d = copy.field.distance[copy.field.at(x, y, z)];
    d = std::max(d, static_cast<float>(-solid.distance(copy.frame.to_world(dvec3(x, y, z))) / copy.frame.voxel));
  });
  return from_dense(copy, volume.band());
}

haptics::TissueVolume with_solid(const haptics::TissueVolume& volume, const haptics::Solid& solid, Tissue tissue) {
  glm::ivec3 lo, hi;
  volume.bounds(lo, hi);
  dvec3 from, to;
  solid.bounds(from, to);
  lo = glm::min(lo, glm::ivec3(glm::floor(volume.frame().to_voxels(from - volume.band())))) - 2;
  hi = glm::max(hi, glm::ivec3(glm::ceil(volume.frame().to_voxels(to + volume.band())))) + 2;
  DenseCopy copy = dense_copy(volume, lo, hi - lo + 1);
  const glm::ivec3 n = copy.field.size;
  for_each_voxel(n, [&](int x, int y, int z) {
    const std::size_t i = copy.field.at(x, y, z);
    float& d = copy.field.distance[i];
    const auto added = static_cast<float>(solid.distance(copy.frame.to_world(dvec3(x, y, z))) / copy.frame.voxel);
    if (added >= d) return;
    const bool was_air = d > 0;
    d = added;
    if (!was_air || added >= kLabelled) return;
    copy.tissue[i] = tissue;
    if (!copy.hardness.empty()) copy.hardness[i] = haptics::kOwnHardness;
    if (!copy.color.empty()) copy.color[i] = kTissueColor;
  });
  return from_dense(copy, volume.band());
}

}  // namespace typodont
