// Dense volumes of samples on a regular grid, and filters for them. Not for real time.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <vector>

#include "engine/base/voxels.h"

namespace typodont::haptics::importing {

/// Dense volume of values; z runs fastest, as in DenseTissue.
template <class T>
struct Grid {
  glm::ivec3 size{0};
  std::vector<T> v;

  Grid() = default;
  explicit Grid(const glm::ivec3& n, T fill = T{}) : size(n), v(voxel_count(n), fill) {}

  std::size_t index(int x, int y, int z) const { return voxel_index({x, y, z}, size); }
  std::size_t index(const glm::ivec3& p) const { return voxel_index(p, size); }
  glm::ivec3 place(std::size_t i) const { return voxel_at(i, size); }
  bool holds(const glm::ivec3& p) const { return in_grid(p, size); }
  T& operator()(int x, int y, int z) { return v[index(x, y, z)]; }
  const T& operator()(int x, int y, int z) const { return v[index(x, y, z)]; }
  T& operator[](const glm::ivec3& p) { return v[index(p)]; }
  const T& operator[](const glm::ivec3& p) const { return v[index(p)]; }
};

using Mask = Grid<std::uint8_t>;

/// Calls work(i) for i = 0 … n − 1 on all cores. Each call must write only its own data. Not a template, because each
/// copy of TBB's loop takes a second to compile.
void for_each_in_parallel(std::size_t n, const std::function<void(std::size_t)>& work);
/// Calls visit(x, y, z) for all voxels of a grid of `size`, the slabs of equal x on all cores.
template <class Visit>
void for_each_voxel_in_parallel(const glm::ivec3& size, const Visit& visit) {
  for_each_in_parallel(size.x, [&](int x) {
    for (int y = 0; y < size.y; ++y)
      for (int z = 0; z < size.z; ++z) visit(x, y, z);
  });
}

/// Trilinear interpolation at p (voxels); outside the volume, the value at its nearest point.
float sample(const Grid<float>& g, const glm::dvec3& p);

/// Catmull-Rom weights of the samples at −1, 0, 1 and 2 for the interpolation at `t` (0 to 1), and their derivatives.
inline std::array<double, 4> cubic_weights(double t) {
  const double t2 = t * t, t3 = t2 * t;
  return {0.5 * (-t3 + 2 * t2 - t), 0.5 * (3 * t3 - 5 * t2 + 2), 0.5 * (-3 * t3 + 4 * t2 + t), 0.5 * (t3 - t2)};
}
inline std::array<double, 4> cubic_slopes(double t) {
  const double t2 = t * t;
  return {0.5 * (-3 * t2 + 4 * t - 1), 0.5 * (9 * t2 - 10 * t), 0.5 * (-9 * t2 + 8 * t + 1), 0.5 * (3 * t2 - 2 * t)};
}

struct Jet {
  double value;
  glm::dvec3 gradient;  // gradient of the value, per voxel
};

/// Squared distance to the mask in voxels² (Felzenszwalb & Huttenlocher 2012); very large for an empty mask.
Grid<float> distance_squared_to(const Mask& mask);

}  // namespace typodont::haptics::importing
