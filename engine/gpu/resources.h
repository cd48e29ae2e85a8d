// Buffers, images, shaders and pipelines. Structs have create() and destroy().
#pragma once

#include <vulkan/vulkan.h>

#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "engine/gpu/device.h"

namespace typodont::gpu {

struct Buffer {
  VkBuffer buffer = VK_NULL_HANDLE;
  VkDeviceSize size = 0;
  Allocation memory;

  /// Allocates memory that the host writes and the GPU reads.
  static Buffer create(Device& device, VkDeviceSize size, VkBufferUsageFlags usage);
  /// Allocates memory that the GPU writes and the host reads. `usage`: whether copies or shaders write it.
  static Buffer create_readback(Device& device, VkDeviceSize size,
                                VkBufferUsageFlags usage = VK_BUFFER_USAGE_TRANSFER_DST_BIT);
  /// Allocates GPU memory that the host does not access.
  static Buffer create_local(Device& device, VkDeviceSize size, VkBufferUsageFlags usage);
  void destroy(Device& device);
  template <class T>
  T* mapped(VkDeviceSize offset = 0) const {
    return reinterpret_cast<T*>(memory.mapped + offset);
  }
};

struct ImageOptions {
  VkExtent2D size{1, 1};
  std::uint32_t layers = 1;
  VkFormat format = VK_FORMAT_R8G8B8A8_SRGB;
  VkFormat alias = VK_FORMAT_UNDEFINED;  // second format in which shaders can read the image's bytes
  int samples = 1;
  VkImageUsageFlags usage = 0;
  VkImageAspectFlags aspect = VK_IMAGE_ASPECT_COLOR_BIT;
  // true: the image has linear rows in host memory, so that a software renderer's picture needs no copy
  bool mapped = false;
};

struct Image {
  VkImage image = VK_NULL_HANDLE;
  VkImageView view = VK_NULL_HANDLE;        // view of all layers, as an array
  VkImageView alias_view = VK_NULL_HANDLE;  // view of all layers, read in the second format
  std::vector<VkImageView> layer_views;     // 2D view of each layer
  ImageOptions options;
  Allocation memory;

  static Image create(Device& device, const ImageOptions& options);
  void destroy(Device& device);
  /// Pixel rows of a mapped image with one layer. Do not read them while a frame draws to the image.
  struct Rows {
    const std::byte* first = nullptr;
    std::size_t pitch = 0;  // bytes, distance from one row to the next
  };
  Rows rows(Device& device) const;
};

/// Adds one image barrier for all layers.
void transition(VkCommandBuffer commands, const Image& image, VkImageLayout from, VkImageLayout to,
                VkPipelineStageFlags2 source_stage, VkAccessFlags2 source_access, VkPipelineStageFlags2 stage,
                VkAccessFlags2 access);
void transition(VkCommandBuffer commands, VkImage image, VkImageAspectFlags aspect, VkImageLayout from,
                VkImageLayout to, VkPipelineStageFlags2 source_stage, VkAccessFlags2 source_access,
                VkPipelineStageFlags2 stage, VkAccessFlags2 access);

/// Makes the writes of stage `from` visible to stage `to`.
void memory_barrier(VkCommandBuffer commands, VkPipelineStageFlags2 from, VkAccessFlags2 written,
                    VkPipelineStageFlags2 to, VkAccessFlags2 access);
/// Makes the writes visible to the host once the commands have finished.
void make_visible_to_host(VkCommandBuffer commands, VkPipelineStageFlags2 stage, VkAccessFlags2 access);

/// Returns one layer of 4-byte pixels of an image in `layout`. Waits for the GPU.
std::vector<std::uint8_t> read_back(Device& device, const Image& image, std::uint32_t layer, VkImageLayout layout);
/// Writes one layer and changes the image's layout to the one that shaders read.
void upload(Device& device, const Image& image, std::span<const std::uint8_t> bytes);

/// Bindings, descriptor sets and pipeline layout of shaders.
struct ShaderInputs {
  struct Binding {
    VkDescriptorType type = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
    VkShaderStageFlags stages = VK_SHADER_STAGE_FRAGMENT_BIT;
  };
  VkDescriptorSetLayout set_layout = VK_NULL_HANDLE;
  VkPipelineLayout layout = VK_NULL_HANDLE;
  VkDescriptorPool pool = VK_NULL_HANDLE;
  std::vector<VkDescriptorSet> sets;
  std::vector<Binding> bindings;

  /// Creates bindings 0, 1, 2 …, `sets` descriptor sets, and push constants for the bindings' shader stages.
  static ShaderInputs create(Device& device, std::vector<Binding> bindings, std::size_t sets, std::uint32_t push_size);
  void destroy(Device& device);
  /// Writes a buffer into a set. Must not be called while a frame reads the set.
  void fill(Device& device, std::size_t set, std::uint32_t binding, const Buffer& buffer) const;
  void fill(Device& device, std::size_t set, std::uint32_t binding, VkSampler sampler, VkImageView view) const;
};

struct SamplerOptions {
  VkFilter filter = VK_FILTER_LINEAR;
  VkSamplerAddressMode beyond = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
  VkBorderColor border = VK_BORDER_COLOR_FLOAT_OPAQUE_BLACK;
  bool compare = false;  // true: compares by ≤, for shadow maps
};
VkSampler create_sampler(Device& device, const SamplerOptions& options = {});

struct VertexAttribute {
  std::uint32_t binding;
  VkFormat format;
  std::uint32_t offset;
};

struct PipelineOptions {
  // SPIR-V code; without a fragment shader, only depth is written
  std::span<const std::uint32_t> vertex_shader, fragment_shader;
  VkPipelineLayout layout = VK_NULL_HANDLE;
  std::vector<VkVertexInputBindingDescription> bindings;
  std::vector<VertexAttribute> attributes;  // attributes at locations 0, 1, 2 …
  VkPrimitiveTopology topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
  VkCullModeFlags cull = VK_CULL_MODE_BACK_BIT;  // faces that are not drawn; a command sets the winding of front faces
  VkFormat color = VK_FORMAT_UNDEFINED;
  VkFormat depth = VK_FORMAT_UNDEFINED;
  bool depth_write = true;
  VkCompareOp depth_compare = VK_COMPARE_OP_LESS_OR_EQUAL;
  bool blend = false;  // true: blends with premultiplied alpha
  bool color_write = true;
  float depth_bias = 0, depth_bias_slope = 0;
  int samples = 1;
  std::uint32_t view_mask = 0;
  std::vector<std::uint32_t> constants;  // specialisation constants 0, 1, 2 … of the shaders
};
/// Returns the device's pipeline with these options, which the first call creates; this can take half a second. If
/// prepare_pipelines() has begun to create it, waits for it. The pipeline exists as long as the device. The layouts of
/// calls with the same shaders must be compatible.
VkPipeline get_pipeline(Device& device, const PipelineOptions& options);
/// Lets another thread create those pipelines that do not exist, in this order; with lower priority if not `urgent`.
/// Returns true when get_pipeline() would wait for none of them. If one could not be created, get_pipeline() throws the
/// reason.
bool prepare_pipelines(Device& device, std::span<const PipelineOptions> wanted, bool urgent);
/// Ends the work of prepare_pipelines(), after the pipelines that are being created. Call before a layout in their
/// options is destroyed.
void stop_preparing(Device& device);
/// Destroys all pipelines of the device.
void destroy_pipelines(Device& device);
VkPipeline create_compute_pipeline(Device& device, std::span<const std::uint32_t> shader, VkPipelineLayout layout);

}  // namespace typodont::gpu
