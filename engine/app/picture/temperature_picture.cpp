#include "engine/app/picture/temperature_picture.h"

namespace typodont {

namespace {

constexpr float kBesideTissue = 1.0f / 16;  // weight of an air cell beside tissue

}  // namespace

std::vector<glm::vec2> temperature_samples(const session::HeatGrid& grid) {
  const glm::ivec3 size = grid.size();
  std::vector<glm::vec2> samples;
  samples.reserve(static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y) *
                  static_cast<std::size_t>(size.z));
  glm::ivec3 c;
  for (c.x = 0; c.x < size.x; ++c.x)
    for (c.y = 0; c.y < size.y; ++c.y)
      for (c.z = 0; c.z < size.z; ++c.z) {
        if (const std::size_t i = grid.at(c.x, c.y, c.z); grid.tissue(i) != Tissue::kAir) {
          samples.push_back({grid.temperature(i) - HeatMeter::kBody, 1});
          continue;
        }
        double sum = 0;
        int count = 0;
        const glm::ivec3 lo = glm::max(c - 1, glm::ivec3(0)), hi = glm::min(c + 1, size - 1);
        for (int x = lo.x; x <= hi.x; ++x)
          for (int y = lo.y; y <= hi.y; ++y)
            for (int z = lo.z; z <= hi.z; ++z)
              if (const std::size_t i = grid.at(x, y, z); grid.tissue(i) != Tissue::kAir)
                sum += grid.temperature(i) - HeatMeter::kBody, ++count;
        samples.push_back(count > 0 ? glm::vec2(kBesideTissue * sum / count, kBesideTissue) : glm::vec2(0));
      }
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
