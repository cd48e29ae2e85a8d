#include <algorithm>

#include "engine/render/passes/passes.h"
#include "shaders/surface_depth_vert.h"
#include "shaders/surface_frag.h"
#include "shaders/surface_vert.h"

namespace typodont::render {

gpu::PipelineOptions SurfacePass::options(const PassContext& context, const SurfaceEffects& effects, BrickKind kind,
                                          bool glass) {
  gpu::PipelineOptions o = context.scene_pipeline(kSpirv_surface_vert, kSpirv_surface_frag);
  o.bindings = {{0, sizeof(GpuVertex), VK_VERTEX_INPUT_RATE_VERTEX}};
  o.attributes = {{0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(GpuVertex, p)},
                  {0, VK_FORMAT_R16G16B16A16_SNORM, offsetof(GpuVertex, n)},
                  {0, VK_FORMAT_R8G8B8A8_UINT, offsetof(GpuVertex, tissue)},
                  {0, VK_FORMAT_R8G8B8A8_UNORM, offsetof(GpuVertex, lesion)}};
  o.blend = glass;
  o.depth_write = !glass;
  // Back faces are drawn for sections, which show the inside, and for open surfaces.
  if (cuts_section(effects.view) || kind == BrickKind::kTwoSided) o.cull = VK_CULL_MODE_NONE;
  o.constants.push_back(static_cast<std::uint32_t>(effects.view));  // value of the constant kView
  o.constants.push_back(glass ? 1u : 0u);                           // value of the constant kGlass
  o.constants.push_back(holds(kind));                               // value of the constant kHolds
  o.constants.push_back(effects.cursor ? 1u : 0u);                  // value of the constant kCursor
  o.constants.push_back(effects.handpiece_shadow ? 1u : 0u);        // value of the constant kHandpieceShadow
  o.constants.push_back(effects.spot ? 1u : 0u);                    // value of the constant kSpot
  o.constants.push_back(effects.film ? 1u : 0u);                    // value of the constant kFilm
  o.constants.push_back(effects.light_grid ? 1u : 0u);              // value of the constant kLightGrid
  return o;
}

gpu::PipelineOptions SurfacePass::depth_options(const PassContext& context, bool both_sides) {
  gpu::PipelineOptions o = context.scene_pipeline(kSpirv_surface_depth_vert, {});
  o.bindings = {{0, sizeof(GpuVertex), VK_VERTEX_INPUT_RATE_VERTEX}};
  o.attributes = {{0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(GpuVertex, p)}};
  o.color_write = false;
  if (both_sides) o.cull = VK_CULL_MODE_NONE;
  return o;
}

bool SurfacePass::needs_depth(const PassContext& context, View view) {
  return view == View::kLook && !context.quality.light_per_vertex;
}

void SurfacePass::list_pipelines(const PassContext& context, const BrickStore& bricks, const SurfaceEffects& effects,
                                 std::vector<gpu::PipelineOptions>& out) {
  const DrawnKinds drawn = bricks.drawn_kinds(effects.view);
  for (std::size_t i = 0; i < kBrickKinds; ++i) {
    const auto kind = static_cast<BrickKind>(i);
    if (!drawn.solid[i]) continue;
    if (needs_depth(context, effects.view)) out.push_back(depth_options(context, kind == BrickKind::kTwoSided));
    out.push_back(options(context, effects, kind, false));
  }
  if (drawn.glass) out.push_back(options(context, effects, BrickKind::kAny, true));
}

void SurfacePass::record_depth(PassContext& context, VkCommandBuffer commands, BrickStore& bricks, int slot,
                               const SlotBuffers& indirect, std::span<const DrawGroup> wanted) {
  for (std::size_t i = 0; i < wanted.size();) {
    const bool both = wanted[i].kind == BrickKind::kTwoSided;
    VkPipeline& chosen = depth[both];
    if (!chosen) chosen = gpu::get_pipeline(context.device, depth_options(context, both));
    std::size_t end = i + 1;
    while (end < wanted.size() && (wanted[end].kind == BrickKind::kTwoSided) == both) ++end;
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, chosen);
    bricks.draw(commands, context.layout, indirect.buffers[static_cast<std::size_t>(slot)].buffer,
                wanted.subspan(i, end - i));
    i = end;
  }
}

void SurfacePass::record(PassContext& context, VkCommandBuffer commands, BrickStore& bricks, int slot,
                         const SlotBuffers& indirect, std::span<const DrawGroup> groups, const SurfaceEffects& effects,
                         bool glass, FrameStats& stats) {
  std::vector<DrawGroup> wanted;
  for (const DrawGroup& g : groups)
    if (glassy_in(effects.view, g.mesh) == glass) wanted.push_back(g);
  if (wanted.empty()) return;
  // Inner bodies have higher mesh numbers, and must be drawn before the glass around them.
  if (glass) {
    std::reverse(wanted.begin(), wanted.end());
  } else {
    std::stable_sort(wanted.begin(), wanted.end(),
                     [](const DrawGroup& a, const DrawGroup& b) { return a.kind < b.kind; });
  }
  if (effects != made_for) {
    forget_pipelines();
    made_for = effects;
  }
  // A depth pass comes first, because light per pixel costs more than drawing the triangles twice.
  if (!glass && needs_depth(context, effects.view)) record_depth(context, commands, bricks, slot, indirect, wanted);
  for (std::size_t i = 0; i < wanted.size();) {
    const BrickKind kind = wanted[i].kind;
    VkPipeline& chosen = glass ? glass_pipeline : solid[static_cast<std::size_t>(kind)];
    if (!chosen) chosen = gpu::get_pipeline(context.device, options(context, effects, kind, glass));
    std::size_t end = i + 1;
    while (end < wanted.size() && (glass || wanted[end].kind == kind)) ++end;
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, chosen);
    bricks.draw(commands, context.layout, indirect.buffers[static_cast<std::size_t>(slot)].buffer,
                std::span(wanted).subspan(i, end - i));
    i = end;
  }
  stats.commands += static_cast<int>(wanted.size());
}

}  // namespace typodont::render
