// Passes the temperatures of the working body to the renderer, for render::View::kTemperature. Render thread only.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "engine/app/task/heat.h"
#include "engine/render/renderer.h"

namespace typodont {

/// The renderer's samples of the cells. An air cell beside tissue gets the mean temperature of this tissue
/// and a small weight, so that tissue thinner than a cell has a temperature, too.
std::vector<glm::vec2> temperature_samples(const session::HeatGrid& grid);

class ShownTemperatures {
 public:
  /// Passes the temperatures if they have changed since the last call.
  void show(const HeatMeter& heat, render::Renderer& renderer);

 private:
  std::optional<std::uint64_t> steps_;  // HeatMeter::steps() that the renderer has received
};

}  // namespace typodont
