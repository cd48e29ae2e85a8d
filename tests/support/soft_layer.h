// A flat soft layer and a servo above it, for tests of soft tissue.
#pragma once

#include <memory>

#include "haptics/soft_tissue.h"
#include "tests/support/haptic_bench.h"

namespace typodont::test {

/// Returns a layer with its surface at z = 0 and a symmetric lattice of points. `half`: m, half the side of its square.
inline std::shared_ptr<const haptics::SoftSurface> flat_layer(const haptics::SoftLaw& law = {}, double half = 3.15e-3) {
  return std::make_shared<const haptics::SoftSurface>(law, dvec3(-half, -half, -1.05e-3), dvec3(half, half, 1.05e-3),
                                                      [](const dvec3& p) { return p.z; });
}

/// Returns a ball of this diameter (m) that does not cut.
inline haptics::Tool ball_probe(double diameter = 1.2e-3) {
  haptics::Tool tool;
  tool.diameter = tool.length = diameter;
  tool.cuts = false;
  return tool;
}

/// Returns settings of a servo whose hard tissue is a small block far below the layer.
inline haptics::ServoSettings soft_settings(const haptics::Tool& tool,
                                            std::shared_ptr<const haptics::SoftSurface> layer = flat_layer()) {
  haptics::ServoSettings settings;
  settings.tool = tool;
  settings.spindle.free_speed = 300 * kKrpm;
  settings.soft = std::move(layer);
  return settings;
}
inline constexpr const char* kBlockFarBelow =
    R"({"voxel_mm": 0.2, "domain_mm": [[-3,-3,-22],[3,3,-17]], "solids": [{"tissue": "enamel", "solid": {"box": {"center_mm": [0,0,-20], "size_mm": [2,2,2]}}}]})";

}  // namespace typodont::test
