#include "engine/render/passes/frame_data.h"

#include <algorithm>
#include <cmath>

#include "engine/base/units.h"
#include "engine/render/srgb.h"

namespace typodont::render {

dvec3 toward_window(const Lights& lights) {
  const dvec3 key = glm::normalize(lights.key), up = glm::normalize(lights.up);
  return glm::normalize(lights.window != dvec3(0) ? lights.window : glm::cross(up, key) + 0.55 * up);
}

shared::FrameData frame_data_of(const Frame& frame, const Quality& quality, const std::array<Look, kMatterCount>& looks,
                                const ToolBody& tool, const HandpieceBody& handpiece, const VkExtent2D& drawn,
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
  if (cuts_section(frame.view)) data.section = glm::vec4(frame.section);
  data.key = glm::vec4(glm::dvec4(key, frame.lights.key_strength));
  data.window = glm::vec4(glm::dvec4(toward_window(frame.lights), 0));
  data.up = glm::vec4(glm::dvec4(up, frame.lights.ambient));
  for (std::size_t t = 0; t < looks.size(); ++t) {
    const Look& look = looks[t];
    data.tissue_color[t] = glm::vec4(glm::dvec4(linear_light(look.color), look.translucency));
    // A rubber dam is thinner than the cells of the TissueLightGrid, so it has no scattered light.
    const double inside = look.metal > 0.5 || static_cast<Tissue>(t) == kRubber ? 0 : 1;
    data.tissue_look[t] = glm::vec4(glm::dvec4(look.roughness, dry_reflectance(look), look.wetness, inside));
  }

  data.lamp.x = static_cast<float>(0.5 * frame.lights.lamp_width / frame.lights.lamp_distance);
  if (bounds) {
    // The middle of the lamp's spot is rounded to kStep, so that the spot does not move while a tooth is cut.
    constexpr double kStep = 2e-3;  // m, rounding step
    const dvec3 middle = kStep * glm::round(0.5 * (bounds->lo + bounds->hi) / kStep);
    const dvec3 right = glm::normalize(glm::cross(up, key)), down = glm::cross(key, right);
    // Half width and half height of the region, around the middle of the spot, that covers a box as seen from the lamp.
    const auto seen = [&](const dvec3& lo, const dvec3& hi) {
      glm::dvec2 most(0);
      for (int corner = 0; corner < 8; ++corner) {
        const dvec3 q = dvec3(corner & 1 ? hi.x : lo.x, corner & 2 ? hi.y : lo.y, corner & 4 ? hi.z : lo.z) - middle;
        most = glm::max(most, glm::abs(glm::dvec2(glm::dot(q, right), glm::dot(q, down))));
      }
      return most;
    };
    // The spot covers the whole working body, even one larger than a tooth, such as a hip socket.
    const glm::dvec2 border(0.5 * frame.lights.spot_border);
    const glm::dvec2 half =
        glm::max(0.5 * frame.lights.spot, kStep * glm::ceil(seen(bounds->lo, bounds->hi) / kStep) + border);
    // The lamp's light is limited to a spot only if a body reaches the spot's soft border; otherwise all is lit fully.
    if (glm::any(glm::greaterThan(seen(bounds->all_lo, bounds->all_hi), half - border))) {
      data.lamp = glm::vec4(glm::dvec4(data.lamp.x, frame.lights.spot_border, half));
      data.lamp_middle = glm::vec4(glm::dvec4(middle, 0));
      data.lamp_right = glm::vec4(glm::dvec4(right, 0));
    }
  }

  // The shadow map is as wide as the crown and its surroundings, and as deep as the scene.
  if (quality.shadow_map > 0 && bounds) {
    auto [lo, hi, all_lo, all_hi] = *bounds;
    // The map's bounds are rounded outward to kStep, so that the map does not move while a tooth is cut.
    constexpr double kStep = 2e-3;  // m, rounding step
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

  data.mirror =
      glm::vec4(glm::dvec4(0.5 * frame.mirror.diameter, frame.mirror.fog, 1 / magnification(frame.mirror), 0));
  if (frame.cursor.visible) {
    data.cursor = glm::vec4(glm::dvec4(frame.cursor.p, frame.cursor.radius));
    data.cursor_down = glm::vec4(glm::dvec4(frame.cursor.down, 0));
  }
  if (frame.tool.visible && tool.mesh.index_count) {
    data.tool_head = glm::vec4(glm::dvec4(frame.tool.X_WG.p, tool.head_radius));
    data.tool_end = glm::vec4(glm::dvec4(frame.tool.X_WG * dvec3(0, 0, tool.shank_end), tool.shank_radius));
    if (handpiece.mesh.index_count) {
      const Pose X_WH = frame.tool.X_WG * frame.tool.X_GH;
      int i = 0;
      for (const RoundCone& cone : {handpiece.head, handpiece.body}) {
        data.handpiece[i++] = glm::vec4(glm::dvec4(X_WH * cone.a, cone.ra));
        data.handpiece[i++] = glm::vec4(glm::dvec4(X_WH * cone.b, cone.rb));
      }
    }
    // Motion blur: the shutter is open for the time T. n blades at ω have the contrast |sin x / x|, x = n ω T / 2. The
    // contrast is zero if one blade passes per exposure; if more blades pass, it is set to zero.
    constexpr double kExposure = 1.0 / 60;  // s, exposure time T of the motion blur
    const double x = 0.5 * tool.blades * std::abs(frame.tool.spindle) * kExposure;
    const double blur = x < 1e-6 ? 0 : x < kPi ? 1 - std::sin(x) / x : 1;
    data.tool_motion = glm::vec4(blur < 1 ? std::remainder(frame.tool.angle, 2 * kPi) : 0.0, blur, 0, 0);
  }
  return data;
}

}  // namespace typodont::render
