#include <algorithm>

#include "engine/render/passes/passes.h"
#include "shaders/particle_frag.h"
#include "shaders/particle_vert.h"

namespace typodont::render {

namespace {

struct Instance {
  float place[4];         // xyz, radius: m
  std::uint8_t color[4];  // sRGB, opacity
};

}  // namespace

void ParticlePass::prepare(PassContext& context, int slot, std::span<const Particle> particles) {
  count = static_cast<std::uint32_t>(particles.size());
  if (!count) return;
  gpu::Buffer& buffer =
      instances.at_least(context.device, slot, particles.size() * sizeof(Instance), VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
  auto* out = buffer.mapped<Instance>();
  const auto unorm = [](float v) { return static_cast<std::uint8_t>(std::clamp(v, 0.0f, 1.0f) * 255.0f + 0.5f); };
  for (std::size_t i = 0; i < particles.size(); ++i) {
    const Particle& p = particles[i];
    out[i] = {{p.p.x, p.p.y, p.p.z, p.radius},
              {unorm(p.color.r), unorm(p.color.g), unorm(p.color.b), unorm(p.opacity)}};
  }
}

void ParticlePass::record(PassContext& context, VkCommandBuffer commands, int slot, FrameStats& stats) {
  if (!count) return;
  if (!pipeline) {
    gpu::PipelineOptions o = context.scene_pipeline(kSpirv_particle_vert, kSpirv_particle_frag);
    o.bindings = {{0, sizeof(Instance), VK_VERTEX_INPUT_RATE_INSTANCE}};
    o.attributes = {{0, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(Instance, place)},
                    {0, VK_FORMAT_R8G8B8A8_UNORM, offsetof(Instance, color)}};
    o.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_STRIP;
    o.cull = VK_CULL_MODE_NONE;
    o.depth_write = false;
    o.blend = true;
    pipeline = gpu::create_pipeline(context.device, o);
  }
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline);
  const VkDeviceSize zero = 0;
  vkCmdBindVertexBuffers(commands, 0, 1, &instances.buffers[static_cast<std::size_t>(slot)].buffer, &zero);
  vkCmdDraw(commands, 4, count, 0, 0);
  ++stats.commands;
}

void ParticlePass::destroy(gpu::Device& device) {
  destroy_pipeline(device, pipeline);
  instances.destroy(device);
}

}  // namespace typodont::render
