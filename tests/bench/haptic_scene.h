// Solids, heads and hands that several benchmarks of the haptics use.
#pragma once

#include <cmath>
#include <string_view>
#include <vector>

#include "engine/base/json.h"
#include "engine/base/units.h"
#include "haptics/solid.h"
#include "tests/bench/bench.h"
#include "tests/support/haptic_bench.h"

namespace typodont::bench {

inline constexpr std::string_view kBall = R"([{"tissue": "enamel", "solid": {"sphere": {"radius_mm": 4}}}])";
inline constexpr std::string_view kBore = R"([{"tissue": "enamel", "solid": {"difference": [
  {"sphere": {"radius_mm": 4}}, {"cylinder": {"center_mm": [0, 0, 4], "radius_mm": 1, "height_mm": 6}}]}}])";
inline constexpr std::string_view kBlock = R"([{"tissue": "dentin", "solid": {"box": {"size_mm": [6, 6, 4]}}}])";
inline constexpr double kBallRadius = 4e-3, kBlockTop = 2e-3;  // m
inline constexpr double kSpecificEnergy = 8e9;                 // J/m³

inline haptics::DenseTissue tissue(std::string_view solids, double voxel_mm) {
  return haptics::read_solids(
      Json::parse(fmt::format(R"({{"voxel_mm": {:g}, "solids": {}}})", voxel_mm, solids), "bench"));
}

inline haptics::Tool head(haptics::HeadShape shape, double diameter, double length) {
  haptics::Tool tool;
  tool.shape = shape, tool.diameter = diameter, tool.length = length;
  return tool;
}
inline haptics::Tool round_head(double diameter) {
  return head(haptics::HeadShape::kSphere, diameter, diameter);
}

inline MaterialTable even_materials() {
  MaterialTable table;
  table.fill({1000, kSpecificEnergy, 0.2, 0.15, 2150, dvec3(0.8)});
  return table;
}

/// Servo and carver in lock-step; all tissues have the same material.
inline test::HapticBench scene_of(haptics::TissueVolume tissue, const haptics::ServoSettings& settings) {
  return {std::move(tissue), settings, even_materials()};
}

inline double degrees_between(const dvec3& a, const dvec3& b) {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b)) / kDegree;
}

/// CPU time of a tick of the servo without the readings of the clock, ns.
inline double servo_ns(const ServoTick& tick) {
  return static_cast<double>(tick.cpu_time) - clock_ns();
}

/// Returns the servo's CPU times of `count` ticks, ns. `hand(i, last tick)` returns the pose of the tool.
template <class Hand>
std::vector<double> servo_times(test::HapticBench& scene, double pedal, int count, Hand&& hand) {
  std::vector<double> times;
  for (int i = 0; i < count; ++i) {
    scene.tick(hand(i, scene.last), pedal);
    times.push_back(servo_ns(scene.last));
  }
  return times;
}

}  // namespace typodont::bench
