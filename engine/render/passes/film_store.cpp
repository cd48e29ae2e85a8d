#include "engine/render/passes/film_store.h"

#include <algorithm>
#include <cstring>

namespace typodont::render {

namespace {

constexpr VkFormat kFilmFormat = VK_FORMAT_R8G8B8A8_UNORM;
constexpr VkPipelineStageFlags2 kReaders =
    VK_PIPELINE_STAGE_2_VERTEX_SHADER_BIT | VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT;

/// Size of the image: the x axis of the image is the z axis of the grid, which is stored first.
VkExtent3D extent_of(const glm::ivec3& size) {
  return {static_cast<std::uint32_t>(size.z), static_cast<std::uint32_t>(size.y), static_cast<std::uint32_t>(size.x)};
}

}  // namespace

void FilmStore::set(gpu::Device& device, const FilmGrid& wanted) {
  destroy(device);
  grid = wanted;
  const glm::ivec3 size = on() ? grid.size : glm::ivec3(1);
  const VkImageCreateInfo info{.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                               .imageType = VK_IMAGE_TYPE_3D,
                               .format = kFilmFormat,
                               .extent = extent_of(size),
                               .mipLevels = 1,
                               .arrayLayers = 1,
                               .samples = VK_SAMPLE_COUNT_1_BIT,
                               .tiling = VK_IMAGE_TILING_OPTIMAL,
                               .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT,
                               .initialLayout = VK_IMAGE_LAYOUT_UNDEFINED};
  gpu::check(vkCreateImage(device.device, &info, nullptr, &image), "vkCreateImage");
  VkMemoryRequirements requirements;
  vkGetImageMemoryRequirements(device.device, image, &requirements);
  memory = device.allocate(requirements, 0, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, true);
  gpu::check(vkBindImageMemory(device.device, image, memory.memory, memory.offset), "vkBindImageMemory");
  const VkImageViewCreateInfo seen{.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                   .image = image,
                                   .viewType = VK_IMAGE_VIEW_TYPE_3D,
                                   .format = kFilmFormat,
                                   .subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1}};
  gpu::check(vkCreateImageView(device.device, &seen, nullptr, &view), "vkCreateImageView");
  gpu::run_once(device, [&](VkCommandBuffer commands) {
    gpu::transition(commands, image, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_UNDEFINED,
                    VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_PIPELINE_STAGE_2_NONE, VK_ACCESS_2_NONE,
                    VK_PIPELINE_STAGE_2_CLEAR_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT);
    const VkClearColorValue nothing{};
    const VkImageSubresourceRange whole{VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    vkCmdClearColorImage(commands, image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, &nothing, 1, &whole);
    gpu::transition(commands, image, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                    VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, VK_PIPELINE_STAGE_2_CLEAR_BIT,
                    VK_ACCESS_2_TRANSFER_WRITE_BIT, kReaders, VK_ACCESS_2_SHADER_SAMPLED_READ_BIT);
  });
}

void FilmStore::update(std::span<const FilmTexel> all, std::span<const FilmBox> boxes) {
  // If no frame was drawn for a long time, one copy of the whole grid replaces the waiting parts.
  const FilmBox whole{glm::ivec3(0), grid.size - 1};
  if (texels.size() > all.size()) {
    parts.clear();
    texels.clear();
    boxes = {&whole, 1};
  }
  for (const FilmBox& box : boxes) {
    const glm::ivec3 size = box.hi - box.lo + 1;
    parts.push_back({box.lo, size, texels.size()});
    for (int x = box.lo.x; x <= box.hi.x; ++x)
      for (int y = box.lo.y; y <= box.hi.y; ++y) {
        const FilmTexel* row = all.data() + (static_cast<std::size_t>(x) * grid.size.y + y) * grid.size.z + box.lo.z;
        texels.insert(texels.end(), row, row + size.z);
      }
  }
}

void FilmStore::mark(const glm::dmat4& clip_from_world, const glm::ivec2& picture, Tiles& tiles) const {
  for (const Part& part : parts) {
    // Because of the interpolation, a texel affects the picture up to the neighbouring samples.
    const dvec3 lo = grid.origin + grid.spacing * (dvec3(part.lo) - 1.0),
                hi = grid.origin + grid.spacing * dvec3(part.lo + part.size);
    tiles.mark(seen_in(clip_from_world, glm::vec3(lo), glm::vec3(hi), picture));
  }
}

std::uint64_t FilmStore::record(gpu::Device& device, VkCommandBuffer commands, int slot) {
  if (parts.empty()) return 0;
  const std::size_t bytes = texels.size() * sizeof(FilmTexel);
  gpu::Buffer& buffer = staging.at_least(device, slot, bytes, VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
  std::memcpy(buffer.memory.mapped, texels.data(), bytes);
  std::vector<VkBufferImageCopy> copies;
  for (const Part& part : parts)
    copies.push_back({.bufferOffset = part.first * sizeof(FilmTexel),
                      .bufferRowLength = 0,
                      .bufferImageHeight = 0,
                      .imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
                      .imageOffset = {part.lo.z, part.lo.y, part.lo.x},
                      .imageExtent = extent_of(part.size)});
  gpu::transition(commands, image, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
                  VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, kReaders, VK_ACCESS_2_SHADER_SAMPLED_READ_BIT,
                  VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT);
  vkCmdCopyBufferToImage(commands, buffer.buffer, image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                         static_cast<std::uint32_t>(copies.size()), copies.data());
  gpu::transition(commands, image, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                  VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, VK_PIPELINE_STAGE_2_COPY_BIT,
                  VK_ACCESS_2_TRANSFER_WRITE_BIT, kReaders, VK_ACCESS_2_SHADER_SAMPLED_READ_BIT);
  parts.clear();
  texels.clear();
  return bytes;
}

void FilmStore::destroy(gpu::Device& device) {
  if (view) vkDestroyImageView(device.device, view, nullptr);
  if (image) vkDestroyImage(device.device, image, nullptr);
  device.release(memory);
  staging.destroy(device);
  *this = {};
}

}  // namespace typodont::render
