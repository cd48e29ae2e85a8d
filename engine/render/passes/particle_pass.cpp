#include <algorithm>

#include "engine/render/passes/passes.h"
#include "shaders/particle_frag.h"
#include "shaders/particle_vert.h"
#include "shaders/streak_vert.h"

namespace typodont::render {

namespace {

struct Instance {
  float place[4];         // xyz: position, m, frame W; w: radius, m
  std::uint8_t color[4];  // colour of the particle; rgb: sRGB; a: opacity
};
struct Streak {
  Instance head;
  float way[3];  // m, vector along the streak
};

}  // namespace

void ParticlePass::prepare(PassContext& context, int slot, std::span<const Particle> particles) {
  streaks = static_cast<std::uint32_t>(
      std::count_if(particles.begin(), particles.end(), [](const Particle& p) { return p.streak != glm::vec3(0); }));
  count = static_cast<std::uint32_t>(particles.size()) - streaks;
  if (particles.empty()) return;
  // Uses six vertices per particle instead of instances, because software rendering draws small instances much more
  // slowly.
  const auto of = [&](SlotBuffers& buffers, std::size_t bytes) -> gpu::Buffer& {
    return buffers.at_least(context.device, slot, bytes, VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
  };
  auto* out = count ? of(corners, 6 * count * sizeof(Instance)).mapped<Instance>() : nullptr;
  auto* streak = streaks ? of(streak_corners, 6 * streaks * sizeof(Streak)).mapped<Streak>() : nullptr;
  const auto unorm = [](float v) { return static_cast<std::uint8_t>(std::clamp(v, 0.0f, 1.0f) * 255.0f + 0.5f); };
  for (const Particle& p : particles) {
    const Instance own{{p.p.x, p.p.y, p.p.z, p.radius},
                       {unorm(p.color.r), unorm(p.color.g), unorm(p.color.b), unorm(p.opacity)}};
    if (p.streak == glm::vec3(0))
      out = std::fill_n(out, 6, own);
    else
      streak = std::fill_n(streak, 6, Streak{own, {p.streak.x, p.streak.y, p.streak.z}});
  }
}

void ParticlePass::mark(std::span<const Particle> particles, const glm::dmat4& clip_from_world, const glm::ivec2& size,
                        Tiles& tiles) {
  const glm::mat4 clip(clip_from_world);
  const float scale = glm::length(glm::vec3(clip[0][0], clip[1][0], clip[2][0])) * 0.5f * static_cast<float>(size.x);
  for (const Particle& p : particles) {
    const glm::vec4 c = clip * glm::vec4(p.p, 1);
    if (c.w < 1e-6f) continue;
    // From centre to corner of a particle's square, pixels: √2 radii; with perspective, 1.6 at the picture's corners.
    const float reach = 1.6f * std::max((p.radius + glm::length(p.streak)) * scale / c.w, 0.7f) + 2;
    const glm::vec2 middle = (0.5f + 0.5f * glm::vec2(c) / c.w) * glm::vec2(size);
    if (middle.x + reach < 0 || middle.y + reach < 0 || middle.x - reach > static_cast<float>(size.x) ||
        middle.y - reach > static_cast<float>(size.y))
      continue;
    const glm::ivec2 lo(glm::max(glm::floor(middle - reach), glm::vec2(0))), hi(glm::ceil(middle + reach));
    tiles.mark({lo.x, lo.y, hi.x - lo.x, hi.y - lo.y});
  }
}

gpu::PipelineOptions ParticlePass::options(const PassContext& context, bool corners_given) {
  gpu::PipelineOptions o = context.scene_pipeline(kSpirv_particle_vert, kSpirv_particle_frag);
  o.bindings = {{0, sizeof(Instance), corners_given ? VK_VERTEX_INPUT_RATE_VERTEX : VK_VERTEX_INPUT_RATE_INSTANCE}};
  o.attributes = {{0, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(Instance, place)},
                  {0, VK_FORMAT_R8G8B8A8_UNORM, offsetof(Instance, color)}};
  o.topology = corners_given ? VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST : VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP;
  o.cull = VK_CULL_MODE_NONE;
  o.depth_write = false;
  o.blend = true;
  // Values of the constants kView, kGlass, kHolds, kCorners.
  o.constants.insert(o.constants.end(), {0u, 0u, 0u, corners_given ? 1u : 0u});
  return o;
}

gpu::PipelineOptions ParticlePass::streak_options(const PassContext& context) {
  gpu::PipelineOptions o = context.scene_pipeline(kSpirv_streak_vert, kSpirv_particle_frag);
  o.bindings = {{0, sizeof(Streak), VK_VERTEX_INPUT_RATE_VERTEX}};
  o.attributes = {{0, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(Streak, head.place)},
                  {0, VK_FORMAT_R8G8B8A8_UNORM, offsetof(Streak, head.color)},
                  {0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(Streak, way)}};
  o.cull = VK_CULL_MODE_NONE;
  o.depth_write = false;
  o.blend = true;
  return o;
}

void ParticlePass::record(PassContext& context, VkCommandBuffer commands, int slot, const ParticleCloud* cloud,
                          FrameStats& stats) {
  const std::vector<ParticleCloud::Run> runs = cloud ? cloud->runs() : std::vector<ParticleCloud::Run>{};
  if (!count && !streaks && runs.empty()) return;
  const auto chosen = [&](VkPipeline& own, bool corners_given) {
    if (!own) own = gpu::get_pipeline(context.device, options(context, corners_given));
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, own);
  };
  if (count) {
    chosen(pipeline, true);
    draw_vertices(commands, corners.buffers[static_cast<std::size_t>(slot)].buffer, 6 * count, stats);
  }
  if (streaks) {
    if (!streak_pipeline) streak_pipeline = gpu::get_pipeline(context.device, streak_options(context));
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, streak_pipeline);
    draw_vertices(commands, streak_corners.buffers[static_cast<std::size_t>(slot)].buffer, 6 * streaks, stats);
  }
  for (const ParticleCloud::Run& run : runs) {
    chosen(cloud_pipeline, false);
    const VkBuffer buffer = cloud->instances();
    const VkDeviceSize zero = 0;
    vkCmdBindVertexBuffers(commands, 0, 1, &buffer, &zero);
    vkCmdDraw(commands, 4, run.count, 0, run.first);
    ++stats.commands;
  }
}

void ParticlePass::destroy(gpu::Device& device) {
  corners.destroy(device);
  streak_corners.destroy(device);
}

}  // namespace typodont::render
