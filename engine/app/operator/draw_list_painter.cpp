#include "engine/app/operator/draw_list_painter.h"

#include <imgui.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <utility>

#include "engine/app/operator/drawn_tiles.h"
#include "shaders/interface_frag.h"
#include "shaders/interface_vert.h"

namespace typodont {

namespace {

// Push constants as in interface.vert: scale, shift and texture layer.
struct Place {
  float scale[2], shift[2];
  std::int32_t layer;
};

// Largest number of target images whose content is remembered; larger than the number of images in a swapchain.
constexpr std::size_t kRemembered = 8;

VkRect2D rectangle(const display::Part& p) {
  return {{p.x, p.y}, {static_cast<std::uint32_t>(p.width), static_cast<std::uint32_t>(p.height)}};
}

/// Makes the buffer large enough. A new buffer is 1.5 times as large as needed.
void at_least(gpu::Device& device, gpu::Buffer& buffer, VkDeviceSize bytes, VkBufferUsageFlags usage) {
  if (buffer.size >= bytes) return;
  if (buffer.buffer) buffer.destroy(device);
  buffer = gpu::Buffer::create(device, std::max<VkDeviceSize>(bytes + bytes / 2, 1 << 16), usage);
}

}  // namespace

DrawListPainter::DrawListPainter(gpu::Device& device) : device_(device) {
  sampler_ = gpu::create_sampler(device);
  inputs_ = gpu::ShaderInputs::create(device, {{.stages = VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT}},
                                      kSlots * kTextures, sizeof(Place));
  take_font_atlas();
}

DrawListPainter::~DrawListPainter() {
  vkDeviceWaitIdle(device_.device);
  for (auto* buffers : {&vertices_, &indices_})
    for (gpu::Buffer& buffer : *buffers)
      if (buffer.buffer) buffer.destroy(device_);
  font_.destroy(device_);
  inputs_.destroy(device_);
  vkDestroySampler(device_.device, sampler_, nullptr);
}

void DrawListPainter::take_font_atlas() {
  if (font_.image) font_.destroy(device_);
  unsigned char* pixels = nullptr;
  int width = 0, height = 0;
  ImGui::GetIO().Fonts->GetTexDataAsAlpha8(&pixels, &width, &height);
  font_ = gpu::Image::create(device_, {.size = {static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height)},
                                       .format = VK_FORMAT_R8_UNORM,
                                       .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT});
  gpu::upload(device_, font_, std::span(pixels, static_cast<std::size_t>(width) * static_cast<std::size_t>(height)));
  ImGui::GetIO().Fonts->SetTexID(nullptr);  // a null texture means the font
  textures_.assign(1, {font_.view, -1, 0});
  holds_.clear();
}

void DrawListPainter::new_frame() {
  textures_.resize(1);
}

void* DrawListPainter::texture(VkImageView array_view, std::uint64_t shows) {
  for (std::size_t i = 1; i < textures_.size(); ++i)
    if (textures_[i].view == array_view) return reinterpret_cast<void*>(i);
  if (textures_.size() == kTextures) return nullptr;
  textures_.push_back({array_view, 0, shows});
  return reinterpret_cast<void*>(textures_.size() - 1);
}

std::optional<std::vector<display::Part>> DrawListPainter::record(VkCommandBuffer commands, const ImDrawData& lists,
                                                                  const display::Target& target, int slot,
                                                                  const std::array<float, 4>& clear, bool all) {
  if (format_ != target.format) {
    gpu::PipelineOptions o;
    o.vertex_shader = kSpirv_interface_vert;
    o.fragment_shader = kSpirv_interface_frag;
    o.layout = inputs_.layout;
    o.bindings = {{0, sizeof(ImDrawVert), VK_VERTEX_INPUT_RATE_VERTEX}};
    o.attributes = {{0, VK_FORMAT_R32G32_SFLOAT, offsetof(ImDrawVert, pos)},
                    {0, VK_FORMAT_R32G32_SFLOAT, offsetof(ImDrawVert, uv)},
                    {0, VK_FORMAT_R8G8B8A8_UNORM, offsetof(ImDrawVert, col)}};
    o.cull = VK_CULL_MODE_NONE;
    o.color = target.format;
    o.depth_write = false;
    o.blend = true;
    pipeline_ = gpu::get_pipeline(device_, o);
    format_ = target.format;
  }

  std::vector<std::uint64_t> shown;
  for (const Texture& t : textures_)
    shown.push_back(
        mixed(mixed(reinterpret_cast<std::uint64_t>(t.view), t.shows), static_cast<std::uint64_t>(t.layer)));
  std::vector<std::uint64_t> tiles = drawn_tiles(lists, target.size, shown);
  if (!target.kept) holds_.erase(target.image);
  const auto held = holds_.find(target.image);
  // If the draw lists were laid out for another window size, they are scaled, and everything is drawn.
  const bool fits = lists.DisplaySize.x == static_cast<float>(target.size.x) &&
                    lists.DisplaySize.y == static_cast<float>(target.size.y);
  const bool whole = all || !fits || held == holds_.end() || held->second.size() != tiles.size();
  const std::vector<display::Part> parts = whole ? std::vector{display::Part{0, 0, target.size.x, target.size.y}}
                                                 : differing_parts(held->second, tiles, target.size);
  // Entries of destroyed images may remain, so all entries are removed if there are too many.
  if (whole && holds_.size() > kRemembered) holds_.clear();
  if (fits)
    holds_[target.image] = std::move(tiles);
  else
    holds_.erase(target.image);
  if (parts.empty()) return parts;

  gpu::transition(commands, target.image, VK_IMAGE_ASPECT_COLOR_BIT,
                  whole ? VK_IMAGE_LAYOUT_UNDEFINED : target.final_layout, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                  VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_ACCESS_2_NONE,
                  VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT,
                  VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT);
  VkClearValue background{};
  std::copy(clear.begin(), clear.end(), background.color.float32);
  const VkRenderingAttachmentInfo info{.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                       .imageView = target.layers[0],
                                       .imageLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                                       .loadOp = whole ? VK_ATTACHMENT_LOAD_OP_CLEAR : VK_ATTACHMENT_LOAD_OP_LOAD,
                                       .storeOp = VK_ATTACHMENT_STORE_OP_STORE,
                                       .clearValue = background};
  const VkRenderingInfo rendering{
      .sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
      .renderArea = {{0, 0}, {static_cast<std::uint32_t>(target.size.x), static_cast<std::uint32_t>(target.size.y)}},
      .layerCount = 1,
      .colorAttachmentCount = 1,
      .pColorAttachments = &info};
  vkCmdBeginRendering(commands, &rendering);
  if (!whole) {
    const VkClearAttachment empty{VK_IMAGE_ASPECT_COLOR_BIT, 0, background};
    std::vector<VkClearRect> places;
    for (const display::Part& p : parts) places.push_back({rectangle(p), 0, 1});
    vkCmdClearAttachments(commands, 1, &empty, static_cast<std::uint32_t>(places.size()), places.data());
  }
  draw(commands, lists, target, static_cast<std::size_t>(slot), parts);
  vkCmdEndRendering(commands);
  gpu::transition(commands, target.image, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                  target.final_layout, VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT,
                  VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                  VK_ACCESS_2_MEMORY_READ_BIT);
  return whole ? std::nullopt : std::optional(parts);
}

void DrawListPainter::draw(VkCommandBuffer commands, const ImDrawData& lists, const display::Target& target,
                           std::size_t s, const std::vector<display::Part>& parts) {
  if (lists.TotalIdxCount == 0) return;
  const auto vertex_bytes = sizeof(ImDrawVert) * static_cast<std::size_t>(lists.TotalVtxCount);
  const auto index_bytes = sizeof(ImDrawIdx) * static_cast<std::size_t>(lists.TotalIdxCount);
  at_least(device_, vertices_[s], vertex_bytes, VK_BUFFER_USAGE_VERTEX_BUFFER_BIT);
  at_least(device_, indices_[s], index_bytes, VK_BUFFER_USAGE_INDEX_BUFFER_BIT);
  auto* vertex = vertices_[s].mapped<ImDrawVert>();
  auto* index = indices_[s].mapped<ImDrawIdx>();
  for (int i = 0; i < lists.CmdListsCount; ++i) {
    const ImDrawList& list = *lists.CmdLists[i];
    std::memcpy(vertex, list.VtxBuffer.Data, sizeof(ImDrawVert) * static_cast<std::size_t>(list.VtxBuffer.Size));
    std::memcpy(index, list.IdxBuffer.Data, sizeof(ImDrawIdx) * static_cast<std::size_t>(list.IdxBuffer.Size));
    vertex += list.VtxBuffer.Size;
    index += list.IdxBuffer.Size;
  }
  for (std::size_t i = 0; i < textures_.size(); ++i)
    inputs_.fill(device_, s * kTextures + i, 0, sampler_, textures_[i].view);

  const VkViewport viewport{0, 0, static_cast<float>(target.size.x), static_cast<float>(target.size.y), 0, 1};
  vkCmdSetViewport(commands, 0, 1, &viewport);
  vkCmdSetFrontFace(commands, VK_FRONT_FACE_COUNTER_CLOCKWISE);
  vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, pipeline_);
  const VkDeviceSize zero = 0;
  vkCmdBindVertexBuffers(commands, 0, 1, &vertices_[s].buffer, &zero);
  vkCmdBindIndexBuffer(commands, indices_[s].buffer, 0,
                       sizeof(ImDrawIdx) == 2 ? VK_INDEX_TYPE_UINT16 : VK_INDEX_TYPE_UINT32);
  const ImVec2 display = lists.DisplaySize;
  int first_vertex = 0;
  std::uint32_t first_index = 0;
  for (int i = 0; i < lists.CmdListsCount; ++i) {
    const ImDrawList& list = *lists.CmdLists[i];
    for (const ImDrawCmd& c : list.CmdBuffer) {
      const auto number = std::min(reinterpret_cast<std::uintptr_t>(c.GetTexID()), textures_.size() - 1);
      const ImVec4 r = c.ClipRect;
      bool bound = false;
      for (const display::Part& p : parts) {
        const int x0 = std::max(static_cast<int>(r.x), p.x), y0 = std::max(static_cast<int>(r.y), p.y);
        const int x1 = std::min(static_cast<int>(r.z), p.x + p.width),
                  y1 = std::min(static_cast<int>(r.w), p.y + p.height);
        if (x1 <= x0 || y1 <= y0) continue;
        if (!std::exchange(bound, true)) {
          const Place place{{2 / display.x, 2 / display.y}, {-1, -1}, textures_[number].layer};
          vkCmdPushConstants(commands, inputs_.layout, VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT, 0,
                             sizeof place, &place);
          vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, inputs_.layout, 0, 1,
                                  &inputs_.sets[s * kTextures + number], 0, nullptr);
        }
        const VkRect2D scissor = rectangle({x0, y0, x1 - x0, y1 - y0});
        vkCmdSetScissor(commands, 0, 1, &scissor);
        vkCmdDrawIndexed(commands, c.ElemCount, 1, first_index + c.IdxOffset,
                         first_vertex + static_cast<int>(c.VtxOffset), 0);
      }
    }
    first_vertex += list.VtxBuffer.Size;
    first_index += static_cast<std::uint32_t>(list.IdxBuffer.Size);
  }
}

}  // namespace typodont
