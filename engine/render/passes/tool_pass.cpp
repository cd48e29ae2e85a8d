#include <algorithm>
#include <cstring>
#include <utility>

#include "engine/render/passes/passes.h"
#include "shaders/handpiece_frag.h"
#include "shaders/handpiece_vert.h"
#include "shaders/tool_frag.h"
#include "shaders/tool_vert.h"

namespace typodont::render {

void IndexedMesh::set(gpu::Device& device, std::span<const std::byte> vertex_bytes,
                      std::span<const std::uint32_t> new_indices) {
  destroy(device);
  index_count = static_cast<std::uint32_t>(new_indices.size());
  if (!index_count) return;
  vertices = gpu::Buffer::create(device, vertex_bytes.size(), VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
  indices = gpu::Buffer::create(device, new_indices.size_bytes(), VK_BUFFER_USAGE_INDEX_BUFFER_BIT);
  std::memcpy(vertices.memory.mapped, vertex_bytes.data(), vertex_bytes.size());
  std::memcpy(indices.memory.mapped, new_indices.data(), new_indices.size_bytes());
}

void IndexedMesh::draw(VkCommandBuffer commands, FrameStats& stats) const {
  const VkDeviceSize zero = 0;
  vkCmdBindVertexBuffers(commands, 0, 1, &vertices.buffer, &zero);
  vkCmdBindIndexBuffer(commands, indices.buffer, 0, VK_INDEX_TYPE_UINT32);
  vkCmdDrawIndexed(commands, index_count, 1, 0, 0, 0);
  ++stats.commands;
}

void IndexedMesh::destroy(gpu::Device& device) {
  vertices.destroy(device);
  indices.destroy(device);
}

void ToolBody::set(gpu::Device& device, const ToolMesh& shape) {
  mesh.set(device, std::as_bytes(std::span(shape.vertices)), shape.indices);
  blades = shape.blades;
  // Shape that casts the tool's shadow: a ball with the head's radius, and the shank.
  head_radius = shank_radius = shank_end = 0;
  for (const ToolVertex& v : shape.vertices) shank_end = std::max(shank_end, static_cast<double>(v.hull_p.z));
  float low = 0, high = 0;
  for (const ToolVertex& v : shape.vertices) {
    low = std::min({low, v.p.z, v.hull_p.z});
    high = std::max({high, v.p.z, v.hull_p.z});
  }
  const float step = (high - low) / static_cast<float>(slices.size());
  for (std::size_t i = 0; i < slices.size(); ++i)
    slices[i] = {low + step * static_cast<float>(i), low + step * static_cast<float>(i + 1), 0};
  // Radius of a slice: largest distance of a vertex from the axis, over all triangles that overlap the slice.
  for (std::size_t i = 0; i + 2 < shape.indices.size(); i += 3) {
    float from = 1e9f, to = -1e9f, radius = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const ToolVertex& v = shape.vertices[shape.indices[i + k]];
      from = std::min({from, v.p.z, v.hull_p.z});
      to = std::max({to, v.p.z, v.hull_p.z});
      radius = std::max({radius, glm::length(glm::vec2(v.p)), glm::length(glm::vec2(v.hull_p))});
    }
    for (Slice& s : slices)
      if (from <= s.high && to >= s.low) s.radius = std::max(s.radius, radius);
  }
  for (const ToolVertex& v : shape.vertices) {
    const double r = glm::length(glm::dvec2(v.hull_p));
    if (v.hull_p.z < 0.1 * shank_end) head_radius = std::max(head_radius, r);
    if (v.hull_p.z > 0.5 * shank_end) shank_radius = std::max(shank_radius, r);
  }
}

gpu::PipelineOptions ToolPass::options(const PassContext& context, bool light_grid) {
  gpu::PipelineOptions o = context.scene_pipeline(kSpirv_tool_vert, kSpirv_tool_frag);
  o.bindings = {{0, sizeof(ToolVertex), VK_VERTEX_INPUT_RATE_VERTEX}};
  o.attributes = {{0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(ToolVertex, p)},
                  {0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(ToolVertex, n)},
                  {0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(ToolVertex, hull_p)},
                  {0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(ToolVertex, hull_n)},
                  {0, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(ToolVertex, spins)}};
  // Constants of frame.glsl: the first seven are unused here, the last is kLightGrid.
  o.constants.insert(o.constants.end(), {0u, 0u, 0u, 0u, 0u, 0u, 0u, light_grid ? 1u : 0u});
  return o;
}

void ToolPass::record(PassContext& context, VkCommandBuffer commands, const ToolBody& body, const Pose& X_WB,
                      bool light_grid, FrameStats& stats) {
  if (!body.mesh.index_count) return;
  if (std::exchange(with_light_grid, light_grid) != light_grid) pipeline = VK_NULL_HANDLE;
  if (!pipeline) pipeline = gpu::get_pipeline(context.device, options(context, light_grid));
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline);
  push(commands, context.layout, X_WB);
  body.mesh.draw(commands, stats);
}

void HandpieceBody::set(gpu::Device& device, const HandpieceMesh& shape) {
  mesh.set(device, std::as_bytes(std::span(shape.vertices)), shape.indices);
  head = shape.head;
  body = shape.body;
  boxes.clear();
  if (!mesh.index_count) return;
  // Makes a box for each slice of the handpiece along z or x, because a single box would cover the whole picture.
  constexpr int kSlices = 48;
  glm::vec3 lo(1e9f), hi(-1e9f);
  for (const HandpieceVertex& v : shape.vertices) lo = glm::min(lo, v.p), hi = glm::max(hi, v.p);
  const int axis = hi.x - lo.x > hi.z - lo.z ? 0 : 2;
  std::array<BoxInWorld, kSlices> slices;
  slices.fill({dvec3(1e9), dvec3(-1e9)});
  const float step = std::max((hi[axis] - lo[axis]) / kSlices, 1e-9f);
  for (std::size_t i = 0; i + 2 < shape.indices.size(); i += 3) {
    glm::vec3 least(1e9f), most(-1e9f);
    for (std::size_t k = 0; k < 3; ++k) {
      const glm::vec3& p = shape.vertices[shape.indices[i + k]].p;
      least = glm::min(least, p), most = glm::max(most, p);
    }
    const int first = std::clamp(static_cast<int>((least[axis] - lo[axis]) / step), 0, kSlices - 1);
    const int last = std::clamp(static_cast<int>((most[axis] - lo[axis]) / step), 0, kSlices - 1);
    for (int s = first; s <= last; ++s) {
      BoxInWorld& box = slices[static_cast<std::size_t>(s)];
      // The triangle is clipped to the slice, so that a long triangle does not enlarge the slice's box.
      glm::dvec3 a(least), b(most);
      a[axis] = std::max(a[axis], static_cast<double>(lo[axis] + step * static_cast<float>(s)));
      b[axis] = std::min(b[axis], static_cast<double>(lo[axis] + step * static_cast<float>(s + 1)));
      box.lo = glm::min(box.lo, a), box.hi = glm::max(box.hi, b);
    }
  }
  for (const BoxInWorld& box : slices)
    if (box.lo.x <= box.hi.x) boxes.push_back(box);
}

gpu::PipelineOptions ToolPass::handpiece_options(const PassContext& context) {
  gpu::PipelineOptions o = context.scene_pipeline(kSpirv_handpiece_vert, kSpirv_handpiece_frag);
  o.bindings = {{0, sizeof(HandpieceVertex), VK_VERTEX_INPUT_RATE_VERTEX}};
  o.attributes = {{0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(HandpieceVertex, p)},
                  {0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(HandpieceVertex, n)},
                  {0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(HandpieceVertex, middle)},
                  {0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(HandpieceVertex, around)},
                  {0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(HandpieceVertex, color)},
                  {0, VK_FORMAT_R32G32B32A32_SFLOAT, offsetof(HandpieceVertex, look)},
                  {0, VK_FORMAT_R32G32B32_SFLOAT, offsetof(HandpieceVertex, grip)}};
  // Constants of frame.glsl, unused here: 0; the last is kPerPixel of handpiece.glsl.
  o.constants.insert(o.constants.end(), {0u, 0u, 0u, context.quality.samples > 1 ? 1u : 0u});
  return o;
}

void ToolPass::record_handpiece(PassContext& context, VkCommandBuffer commands, const HandpieceBody& body,
                                const Pose& X_WH, FrameStats& stats) {
  if (!body.mesh.index_count) return;
  if (!handpiece_pipeline) handpiece_pipeline = gpu::get_pipeline(context.device, handpiece_options(context));
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, handpiece_pipeline);
  push(commands, context.layout, X_WH);
  body.mesh.draw(commands, stats);
}

}  // namespace typodont::render
