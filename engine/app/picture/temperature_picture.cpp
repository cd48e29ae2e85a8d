#include "engine/app/picture/temperature_picture.h"

#include "engine/base/voxels.h"

namespace typodont {

namespace {

constexpr float kBesideTissue = 1.0f / 16;  // weight of an air cell beside tissue

}  // namespace

std::vector<glm::vec2> temperature_samples(const session::HeatGrid& grid) {
  const glm::ivec3 size = grid.size();
  std::vector<glm::vec2> samples;
  samples.reserve(voxel_count(size));
  for_each_voxel(size, [&](const glm::ivec3& c) {
    if (const std::size_t i = grid.at(c.x, c.y, c.z); grid.tissue(i) != Tissue::kAir) {
      samples.push_back({grid.temperature(i) - HeatMeter::kBody, 1});
      return;
    }
    double sum = 0;
    int count = 0;
    for_each_voxel_between(glm::max(c - 1, glm::ivec3(0)), glm::min(c + 1, size - 1), [&](int x, int y, int z) {
      if (const std::size_t i = grid.at(x, y, z); grid.tissue(i) != Tissue::kAir)
        sum += grid.temperature(i) - HeatMeter::kBody, ++count;
    });
    samples.push_back(count > 0 ? glm::vec2(kBesideTissue * sum / count, kBesideTissue) : glm::vec2(0));
  });
  return samples;
}

void ShownTemperatures::show(const HeatMeter& heat, render::Renderer& renderer) {
  const session::HeatGrid& grid = heat.grid();
  if (steps_ == heat.steps()) return;
  if (!steps_) renderer.set_temperatures({grid.frame().origin, grid.frame().voxel, grid.size()});
  steps_ = heat.steps();
  renderer.update_temperatures(temperature_samples(grid));
}

}  // namespace typodont
