#include "engine/render/passes/frame_data.h"

#include <algorithm>
#include <cmath>

#include "engine/base/units.h"

namespace typodont::render {

namespace {

/// Converts sRGB to linear light, IEC 61966-2-1.
dvec3 linear_light(const dvec3& srgb) {
  dvec3 out;
  for (int i = 0; i < 3; ++i) out[i] = srgb[i] <= 0.04045 ? srgb[i] / 12.92 : std::pow((srgb[i] + 0.055) / 1.055, 2.4);
  return out;
}

}  // namespace

shared::FrameData frame_data_of(const Frame& frame, const Quality& quality, const std::array<Look, kTissueCount>& looks,
                                const ToolBody& tool, const VkExtent2D& drawn,
                                const std::optional<SceneBounds>& bounds) {
  shared::FrameData data{};
  for (int e = 0; e < 2; ++e) {
    const Eye& eye = frame.eyes[static_cast<std::size_t>(e < frame.views ? e : 0)];
    data.clip_from_world[e] = glm::mat4(eye.projection * eye.view);
    data.eye[e] = glm::vec4(glm::dvec4(eye.position, 1));
  }
  const dvec3 key = glm::normalize(frame.lights.key), up = glm::normalize(frame.lights.up);
  data.background = glm::vec4(frame.background == Background::kGradient ? 1.0f : 0.0f);
  data.background.w = frame.background == Background::kClear ? 0.0f : 1.0f;
  data.picture = glm::vec4(2.0f / static_cast<float>(drawn.width), 2.0f / static_cast<float>(drawn.height), 0, 0);
  data.clip = data.section = glm::vec4(0, 0, 0, 1);
  if (frame.view == View::kSection) data.section = glm::vec4(frame.section);
  data.key = glm::vec4(glm::dvec4(key, frame.lights.key_strength));
  const bool given = frame.lights.window != dvec3(0);
  const dvec3 window = glm::normalize(given ? frame.lights.window : glm::cross(up, key) + 0.55 * up);
  data.window = glm::vec4(glm::dvec4(window, 0));
  data.up = glm::vec4(glm::dvec4(up, frame.lights.ambient));
  for (std::size_t t = 0; t < looks.size(); ++t) {
    const Look& look = looks[t];
    data.tissue_color[t] = glm::vec4(glm::dvec4(linear_light(look.color), look.translucency));
    data.tissue_look[t] = glm::vec4(glm::dvec4(look.roughness, look.metal, look.wetness, 0));
  }

  // The lamp's parallel projection is as wide as the crown of the working tooth and its neighbourhood, and as deep as
  // the whole scene.
  if (quality.shadow_map > 0 && bounds) {
    auto [lo, hi, all_lo, all_hi] = *bounds;
    // The bounds are rounded to steps, so that the map does not move while a tooth is cut.
    constexpr double kStep = 2e-3;  // m
    for (glm::dvec3* low : {&lo, &all_lo}) *low = kStep * glm::floor(*low / kStep);
    for (glm::dvec3* high : {&hi, &all_hi}) *high = kStep * glm::ceil(*high / kStep);
    const glm::dvec3 middle = 0.5 * (lo + hi);
    const bool more = all_lo != lo || all_hi != hi;
    const double radius = 0.5 * glm::length(hi - lo) * (more ? 1.15 : 1.02) + 1e-6;
    double reach = radius;
    for (int corner = 0; corner < 8; ++corner)
      reach = std::max(reach,
                       std::abs(glm::dot(key, dvec3(corner & 1 ? all_hi.x : all_lo.x, corner & 2 ? all_hi.y : all_lo.y,
                                                    corner & 4 ? all_hi.z : all_lo.z) -
                                                  middle)));
    const glm::dvec3 side = std::abs(key.x) < 0.8 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
    const glm::dvec3 x = glm::normalize(glm::cross(side, key)), y = glm::cross(key, x);
    glm::dmat4 m(0.0);
    for (int i = 0; i < 3; ++i) {
      m[i][0] = x[i] / (2 * radius);
      m[i][1] = y[i] / (2 * radius);
      m[i][2] = -key[i] / (2 * reach);
    }
    m[3] = glm::dvec4(0.5 - glm::dot(x, middle) / (2 * radius), 0.5 - glm::dot(y, middle) / (2 * radius),
                      0.5 + glm::dot(key, middle) / (2 * reach), 1);
    data.light_from_world = glm::mat4(m);
    data.light_size = glm::vec4(glm::dvec4(2 * radius, 2 * reach, 2 * radius / quality.shadow_map, 1));
  }

  data.mirror = glm::vec4(glm::dvec4(0.5 * frame.mirror.diameter, frame.mirror.fog, 0, 0));
  if (frame.cursor.visible) {
    data.cursor = glm::vec4(glm::dvec4(frame.cursor.p, frame.cursor.radius));
    data.cursor_down = glm::vec4(glm::dvec4(frame.cursor.down, 0));
  }
  if (frame.tool.visible && tool.index_count) {
    data.tool_head = glm::vec4(glm::dvec4(frame.tool.X_WG.p, tool.head_radius));
    data.tool_end = glm::vec4(glm::dvec4(frame.tool.X_WG * dvec3(0, 0, tool.shank_end), tool.shank_radius));
    // Motion blur: the eye integrates over about 15 ms. Blur begins when the tool turns by a tenth of a blade's pitch
    // in that time, and is complete at one pitch.
    constexpr double kExposure = 15e-3, kPitch = 2 * kPi / 8;
    const double pitches = std::abs(frame.tool.spindle) * kExposure / kPitch;
    const double blur = std::clamp((pitches - 0.1) / 0.9, 0.0, 1.0);
    data.tool_motion = glm::vec4(blur < 1 ? std::remainder(frame.tool.angle, 2 * kPi) : 0.0, blur, 0, 0);
  }
  return data;
}

}  // namespace typodont::render
