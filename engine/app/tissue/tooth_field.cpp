#include "engine/app/tissue/tooth_field.h"

#include <algorithm>
#include <cmath>

namespace typodont {

ToothField::ToothField(const haptics::TissueVolume& volume, double reach)
    : frame_(volume.frame()), band_(volume.band()), reach_(reach) {
  glm::ivec3 hi;
  volume.bounds(lo_, hi);
  low_ = frame_.to_world(dvec3(lo_));
  high_ = frame_.to_world(dvec3(hi));
  const int room = static_cast<int>(reach / frame_.voxel) + 1;
  lo_ -= room;
  size_ = glm::max(hi + room - lo_ + 1, glm::ivec3(2));
  distance_.resize(voxel_count(size_));
  tissue_.resize(distance_.size());
  volume.copy(lo_, size_, distance_.data(), tissue_.data());
  if (reach > 0) extend();
}

double ToothField::distance(const dvec3& p_W) const {
  const dvec3 v = frame_.to_voxels(p_W) - dvec3(lo_);
  for (int a = 0; a < 3; ++a)
    if (!(v[a] >= 0 && v[a] < size_[a] - 1)) return band_ + reach_;
  const glm::ivec3 i(v);
  const dvec3 f = v - dvec3(i);
  const auto at = [&](int x, int y, int z) { return static_cast<double>(distance_[index(i + glm::ivec3(x, y, z))]); };
  const auto along_z = [&](int x, int y) { return glm::mix(at(x, y, 0), at(x, y, 1), f.z); };
  const auto along_y = [&](int x) { return glm::mix(along_z(x, 0), along_z(x, 1), f.y); };
  return glm::mix(along_y(0), along_y(1), f.x) * frame_.voxel;
}

Tissue ToothField::tissue(const dvec3& p_W) const {
  const glm::ivec3 i(glm::floor(frame_.to_voxels(p_W) - dvec3(lo_) + 0.5));
  return in_grid(i, size_) ? tissue_[index(i)] : Tissue::kAir;
}

Tissue ToothField::tissue_at_surface(const dvec3& p_W) const {
  // The tissue is read at this depth below the surface, m; also the step for the gradient.
  constexpr double kStep = 0.1e-3;
  dvec3 p = p_W;
  for (int round = 0; round < 4; ++round) {
    const double away = distance(p) + kStep;
    if (std::abs(away) < 0.3 * kStep) break;
    dvec3 slope;
    for (int a = 0; a < 3; ++a) {
      dvec3 step(0);
      step[a] = kStep;
      slope[a] = (distance(p + step) - distance(p - step)) / (2 * kStep);
    }
    const double steep = glm::dot(slope, slope);
    if (steep < 0.05) break;
    p -= slope * (away / steep);
  }
  return tissue(p);
}

std::array<double, kTissueCount> ToothField::fractions(const dvec3& p_W) const {
  std::array<double, kTissueCount> out{};
  const dvec3 v = frame_.to_voxels(p_W) - dvec3(lo_);
  for (int a = 0; a < 3; ++a)
    if (!(v[a] >= 1 && v[a] < size_[a] - 2)) return out;
  // Weights of a cubic B-spline, which makes the borders between tissues smooth.
  const glm::ivec3 i(v);
  double weight[3][4];
  for (int a = 0; a < 3; ++a) {
    const double f = v[a] - i[a], g = 1 - f;
    weight[a][0] = g * g * g / 6;
    weight[a][1] = (4 - 6 * f * f + 3 * f * f * f) / 6;
    weight[a][2] = (4 - 6 * g * g + 3 * g * g * g) / 6;
    weight[a][3] = f * f * f / 6;
  }
  for_each_voxel(glm::ivec3(4), [&](int x, int y, int z) {
    out[static_cast<std::size_t>(tissue_[index(i + glm::ivec3(x - 1, y - 1, z - 1))])] +=
        weight[0][x] * weight[1][y] * weight[2][z];
  });
  return out;
}

/// Adds distances beyond the largest stored one by a chamfer distance transform: a forward and a backward pass.
void ToothField::extend() {
  const auto far = static_cast<float>((band_ + reach_) / frame_.voxel);
  const auto beyond = static_cast<float>(0.99 * band_ / frame_.voxel);
  for (float& d : distance_)
    if (d > beyond) d = far;
  const std::ptrdiff_t dz = 1, dy = size_.z, dx = static_cast<std::ptrdiff_t>(size_.y) * size_.z;
  // Steps to the neighbours, except the one along z. Its distance is read later, because it must be updated first.
  const std::array<std::pair<std::ptrdiff_t, float>, 9> steps{{{dx, 1.0f},
                                                               {dy, 1.0f},
                                                               {dx + dy, 1.414f},
                                                               {dx - dy, 1.414f},
                                                               {dx + dz, 1.414f},
                                                               {dx - dz, 1.414f},
                                                               {dy + dz, 1.414f},
                                                               {dy - dz, 1.414f},
                                                               {dx + dy + dz, 1.732f}}};
  const auto n = static_cast<std::ptrdiff_t>(distance_.size());
  float* const d = distance_.data();
  // Number of voxels processed together. Within this group, distances depend on each other only along z.
  const std::ptrdiff_t length = std::max<std::ptrdiff_t>(dy - dz, 1);
  std::vector<float> least(static_cast<std::size_t>(length));
  const auto pull = [&](std::ptrdiff_t first, std::ptrdiff_t count, std::ptrdiff_t sign) {
    if (std::all_of(d + first, d + first + count, [&](float known) { return known <= beyond; })) return;
    std::fill(least.begin(), least.end(), far);
    float* const best = least.data();
    for (const auto& [step, away] : steps) {
      const std::ptrdiff_t from = first + sign * step;
      const std::ptrdiff_t begin = std::max<std::ptrdiff_t>(0, -from), end = std::min(count, n - from);
      for (std::ptrdiff_t k = begin; k < end; ++k) best[k] = std::min(best[k], d[from + k] + away);
    }
    for (std::ptrdiff_t j = 0; j < count; ++j) {
      const std::ptrdiff_t k = sign < 0 ? j : count - 1 - j, i = first + k, along = i + sign * dz;
      if (d[i] <= beyond) continue;
      d[i] = std::min(d[i], best[k]);
      if (along >= 0 && along < n) d[i] = std::min(d[i], d[along] + 1.0f);
    }
  };
  for (std::ptrdiff_t i = 0; i < n; i += length) pull(i, std::min(length, n - i), -1);
  for (std::ptrdiff_t end = n; end > 0; end -= length)
    pull(std::max<std::ptrdiff_t>(0, end - length), std::min(length, end), 1);
}

}  // namespace typodont
