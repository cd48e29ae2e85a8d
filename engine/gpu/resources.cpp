#include "engine/gpu/resources.h"

#include <array>
#include <bit>
#include <chrono>
#include <cstring>
#include <future>
#include <system_error>
#include <utility>

#include "engine/base/check.h"
#include "engine/base/memory.h"
#include "engine/base/realtime.h"

namespace typodont::gpu {

namespace {

constexpr std::size_t kRoomToCompile = 128 << 20;  // bytes that must be free; with less memory, drivers crash

Buffer create_buffer(Device& device, VkDeviceSize size, VkBufferUsageFlags usage, VkMemoryPropertyFlags required,
                     VkMemoryPropertyFlags preferred) {
  Buffer b;
  b.size = size;
  const VkBufferCreateInfo info{.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = size, .usage = usage};
  check(vkCreateBuffer(device.device, &info, nullptr, &b.buffer), "vkCreateBuffer");
  VkMemoryRequirements requirements;
  vkGetBufferMemoryRequirements(device.device, b.buffer, &requirements);
  b.memory = device.allocate(requirements, required, preferred, false);
  check(vkBindBufferMemory(device.device, b.buffer, b.memory.memory, b.memory.offset), "vkBindBufferMemory");
  return b;
}

VkImageView create_view(Device& device, const Image& image, VkFormat format, std::uint32_t first, std::uint32_t count,
                        VkImageViewType type) {
  const VkImageViewCreateInfo info{.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                   .image = image.image,
                                   .viewType = type,
                                   .format = format,
                                   .subresourceRange = {image.options.aspect, 0, 1, first, count}};
  VkImageView view = VK_NULL_HANDLE;
  check(vkCreateImageView(device.device, &info, nullptr, &view), "vkCreateImageView");
  return view;
}

VkShaderModule create_module(VkDevice device, std::span<const std::uint32_t> code) {
  const VkShaderModuleCreateInfo info{
      .sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO, .codeSize = code.size_bytes(), .pCode = code.data()};
  VkShaderModule module = VK_NULL_HANDLE;
  check(vkCreateShaderModule(device, &info, nullptr, &module), "vkCreateShaderModule");
  return module;
}

}  // namespace

Buffer Buffer::create(Device& device, VkDeviceSize size, VkBufferUsageFlags usage) {
  return create_buffer(device, size, usage, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT,
                       VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
}

Buffer Buffer::create_local(Device& device, VkDeviceSize size, VkBufferUsageFlags usage) {
  return create_buffer(device, size, usage, 0, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
}

Buffer Buffer::create_readback(Device& device, VkDeviceSize size, VkBufferUsageFlags usage) {
  return create_buffer(device, size, usage, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT,
                       VK_MEMORY_PROPERTY_HOST_CACHED_BIT);
}

void Buffer::destroy(Device& device) {
  if (buffer) vkDestroyBuffer(device.device, buffer, nullptr);
  device.release(memory);
  *this = {};
}

Image Image::create(Device& device, const ImageOptions& options) {
  Image image;
  image.options = options;
  const VkImageCreateInfo info{.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                               .flags = options.alias != VK_FORMAT_UNDEFINED
                                            ? VkImageCreateFlags{VK_IMAGE_CREATE_MUTABLE_FORMAT_BIT}
                                            : VkImageCreateFlags{0},
                               .imageType = VK_IMAGE_TYPE_2D,
                               .format = options.format,
                               .extent = {options.size.width, options.size.height, 1},
                               .mipLevels = 1,
                               .arrayLayers = options.layers,
                               .samples = static_cast<VkSampleCountFlagBits>(options.samples),
                               .tiling = options.mapped ? VK_IMAGE_TILING_LINEAR : VK_IMAGE_TILING_OPTIMAL,
                               .usage = options.usage,
                               .initialLayout = VK_IMAGE_LAYOUT_UNDEFINED};
  check(vkCreateImage(device.device, &info, nullptr, &image.image), "vkCreateImage");
  VkMemoryRequirements requirements;
  vkGetImageMemoryRequirements(device.device, image.image, &requirements);
  constexpr VkMemoryPropertyFlags kMapped = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
  image.memory = options.mapped ? device.allocate(requirements, kMapped, VK_MEMORY_PROPERTY_HOST_CACHED_BIT, true)
                                : device.allocate(requirements, 0, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, true);
  check(vkBindImageMemory(device.device, image.image, image.memory.memory, image.memory.offset), "vkBindImageMemory");
  constexpr VkImageUsageFlags kViewed =
      VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT;
  if (!(options.usage & kViewed)) return image;
  image.view = create_view(device, image, options.format, 0, options.layers, VK_IMAGE_VIEW_TYPE_2D_ARRAY);
  if (options.alias != VK_FORMAT_UNDEFINED)
    image.alias_view = create_view(device, image, options.alias, 0, options.layers, VK_IMAGE_VIEW_TYPE_2D_ARRAY);
  for (std::uint32_t layer = 0; layer < options.layers; ++layer)
    image.layer_views.push_back(create_view(device, image, options.format, layer, 1, VK_IMAGE_VIEW_TYPE_2D));
  return image;
}

Image::Rows Image::rows(Device& device) const {
  const VkImageSubresource all{options.aspect, 0, 0};
  VkSubresourceLayout lies{};
  vkGetImageSubresourceLayout(device.device, image, &all, &lies);
  return {memory.mapped + lies.offset, static_cast<std::size_t>(lies.rowPitch)};
}

void Image::destroy(Device& device) {
  for (VkImageView v : layer_views) vkDestroyImageView(device.device, v, nullptr);
  if (view) vkDestroyImageView(device.device, view, nullptr);
  if (alias_view) vkDestroyImageView(device.device, alias_view, nullptr);
  if (image) vkDestroyImage(device.device, image, nullptr);
  device.release(memory);
  *this = {};
}

void transition(VkCommandBuffer commands, VkImage image, VkImageAspectFlags aspect, VkImageLayout from,
                VkImageLayout to, VkPipelineStageFlags2 source_stage, VkAccessFlags2 source_access,
                VkPipelineStageFlags2 stage, VkAccessFlags2 access) {
  const VkImageMemoryBarrier2 barrier{.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
                                      .srcStageMask = source_stage,
                                      .srcAccessMask = source_access,
                                      .dstStageMask = stage,
                                      .dstAccessMask = access,
                                      .oldLayout = from,
                                      .newLayout = to,
                                      .srcQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                      .dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED,
                                      .image = image,
                                      .subresourceRange = {aspect, 0, 1, 0, VK_REMAINING_ARRAY_LAYERS}};
  const VkDependencyInfo dependency{
      .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .imageMemoryBarrierCount = 1, .pImageMemoryBarriers = &barrier};
  vkCmdPipelineBarrier2(commands, &dependency);
}

void transition(VkCommandBuffer commands, const Image& image, VkImageLayout from, VkImageLayout to,
                VkPipelineStageFlags2 source_stage, VkAccessFlags2 source_access, VkPipelineStageFlags2 stage,
                VkAccessFlags2 access) {
  transition(commands, image.image, image.options.aspect, from, to, source_stage, source_access, stage, access);
}

void memory_barrier(VkCommandBuffer commands, VkPipelineStageFlags2 from, VkAccessFlags2 written,
                    VkPipelineStageFlags2 to, VkAccessFlags2 access) {
  const VkMemoryBarrier2 memory{.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2,
                                .srcStageMask = from,
                                .srcAccessMask = written,
                                .dstStageMask = to,
                                .dstAccessMask = access};
  const VkDependencyInfo dependency{
      .sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO, .memoryBarrierCount = 1, .pMemoryBarriers = &memory};
  vkCmdPipelineBarrier2(commands, &dependency);
}

void make_visible_to_host(VkCommandBuffer commands, VkPipelineStageFlags2 stage, VkAccessFlags2 access) {
  memory_barrier(commands, stage, access, VK_PIPELINE_STAGE_2_HOST_BIT, VK_ACCESS_2_HOST_READ_BIT);
}

std::vector<std::uint8_t> read_back(Device& device, const Image& image, std::uint32_t layer, VkImageLayout layout) {
  const VkExtent2D size = image.options.size;
  const std::size_t bytes = std::size_t{4} * size.width * size.height;
  Buffer buffer = Buffer::create_readback(device, bytes);
  run_once(device, [&](VkCommandBuffer commands) {
    transition(commands, image, layout, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
               VK_ACCESS_2_MEMORY_WRITE_BIT, VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_READ_BIT);
    const VkBufferImageCopy copy{.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, layer, 1},
                                 .imageExtent = {size.width, size.height, 1}};
    vkCmdCopyImageToBuffer(commands, image.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, buffer.buffer, 1, &copy);
    transition(commands, image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, layout, VK_PIPELINE_STAGE_2_COPY_BIT,
               VK_ACCESS_2_NONE, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_ACCESS_2_MEMORY_READ_BIT);
    make_visible_to_host(commands, VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT);
  });
  std::vector<std::uint8_t> pixels(bytes);
  std::memcpy(pixels.data(), buffer.memory.mapped, bytes);
  buffer.destroy(device);
  return pixels;
}

void upload(Device& device, const Image& image, std::span<const std::uint8_t> bytes) {
  Buffer buffer = Buffer::create(device, bytes.size(), VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
  std::memcpy(buffer.memory.mapped, bytes.data(), bytes.size());
  run_once(device, [&](VkCommandBuffer commands) {
    transition(commands, image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
               VK_PIPELINE_STAGE_2_NONE, VK_ACCESS_2_NONE, VK_PIPELINE_STAGE_2_COPY_BIT,
               VK_ACCESS_2_TRANSFER_WRITE_BIT);
    const VkBufferImageCopy copy{.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
                                 .imageExtent = {image.options.size.width, image.options.size.height, 1}};
    vkCmdCopyBufferToImage(commands, buffer.buffer, image.image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &copy);
    transition(commands, image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
               VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT, VK_PIPELINE_STAGE_2_FRAGMENT_SHADER_BIT,
               VK_ACCESS_2_SHADER_SAMPLED_READ_BIT);
  });
  buffer.destroy(device);
}

ShaderInputs ShaderInputs::create(Device& device, std::vector<Binding> wanted, std::size_t count,
                                  std::uint32_t push_size) {
  ShaderInputs inputs;
  inputs.bindings = std::move(wanted);
  std::vector<VkDescriptorSetLayoutBinding> bindings;
  std::vector<VkDescriptorPoolSize> sizes;
  VkShaderStageFlags stages = 0;
  for (const Binding& b : inputs.bindings) {
    bindings.push_back({static_cast<std::uint32_t>(bindings.size()), b.type, 1, b.stages, nullptr});
    sizes.push_back({b.type, static_cast<std::uint32_t>(count)});
    stages |= b.stages;
  }
  const VkDescriptorSetLayoutCreateInfo set_info{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
                                                 .bindingCount = static_cast<std::uint32_t>(bindings.size()),
                                                 .pBindings = bindings.data()};
  check(vkCreateDescriptorSetLayout(device.device, &set_info, nullptr, &inputs.set_layout),
        "vkCreateDescriptorSetLayout");
  const VkPushConstantRange range{stages, 0, push_size};
  const VkPipelineLayoutCreateInfo layout{.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                          .setLayoutCount = 1,
                                          .pSetLayouts = &inputs.set_layout,
                                          .pushConstantRangeCount = push_size ? 1u : 0u,
                                          .pPushConstantRanges = &range};
  check(vkCreatePipelineLayout(device.device, &layout, nullptr, &inputs.layout), "vkCreatePipelineLayout");
  const VkDescriptorPoolCreateInfo pool{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                        .maxSets = static_cast<std::uint32_t>(count),
                                        .poolSizeCount = static_cast<std::uint32_t>(sizes.size()),
                                        .pPoolSizes = sizes.data()};
  check(vkCreateDescriptorPool(device.device, &pool, nullptr, &inputs.pool), "vkCreateDescriptorPool");
  const std::vector<VkDescriptorSetLayout> layouts(count, inputs.set_layout);
  inputs.sets.resize(count);
  const VkDescriptorSetAllocateInfo allocate{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                             .descriptorPool = inputs.pool,
                                             .descriptorSetCount = static_cast<std::uint32_t>(count),
                                             .pSetLayouts = layouts.data()};
  check(vkAllocateDescriptorSets(device.device, &allocate, inputs.sets.data()), "vkAllocateDescriptorSets");
  return inputs;
}

void ShaderInputs::destroy(Device& device) {
  vkDestroyPipelineLayout(device.device, layout, nullptr);
  vkDestroyDescriptorPool(device.device, pool, nullptr);
  vkDestroyDescriptorSetLayout(device.device, set_layout, nullptr);
  *this = {};
}

void ShaderInputs::fill(Device& device, std::size_t set, std::uint32_t binding, const Buffer& buffer) const {
  const VkDescriptorBufferInfo info{buffer.buffer, 0, VK_WHOLE_SIZE};
  const VkWriteDescriptorSet write{.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                   .dstSet = sets[set],
                                   .dstBinding = binding,
                                   .descriptorCount = 1,
                                   .descriptorType = bindings[binding].type,
                                   .pBufferInfo = &info};
  vkUpdateDescriptorSets(device.device, 1, &write, 0, nullptr);
}

void ShaderInputs::fill(Device& device, std::size_t set, std::uint32_t binding, VkSampler sampler,
                        VkImageView view) const {
  const VkDescriptorImageInfo info{sampler, view, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
  const VkWriteDescriptorSet write{.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                   .dstSet = sets[set],
                                   .dstBinding = binding,
                                   .descriptorCount = 1,
                                   .descriptorType = bindings[binding].type,
                                   .pImageInfo = &info};
  vkUpdateDescriptorSets(device.device, 1, &write, 0, nullptr);
}

VkSampler create_sampler(Device& device, const SamplerOptions& options) {
  const VkSamplerCreateInfo info{.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO,
                                 .magFilter = options.filter,
                                 .minFilter = options.filter,
                                 .addressModeU = options.beyond,
                                 .addressModeV = options.beyond,
                                 .addressModeW = options.beyond,
                                 .compareEnable = options.compare,
                                 .compareOp = VK_COMPARE_OP_LESS_OR_EQUAL,
                                 .borderColor = options.border};
  VkSampler sampler = VK_NULL_HANDLE;
  check(vkCreateSampler(device.device, &info, nullptr, &sampler), "vkCreateSampler");
  return sampler;
}

VkPipeline create_compute_pipeline(Device& device, std::span<const std::uint32_t> shader, VkPipelineLayout layout) {
  require_memory(kRoomToCompile);
  const VkShaderModule module = create_module(device.device, shader);
  const VkComputePipelineCreateInfo info{.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
                                         .stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                                                   .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                                                   .module = module,
                                                   .pName = "main"},
                                         .layout = layout};
  VkPipeline pipeline = VK_NULL_HANDLE;
  const VkResult result = vkCreateComputePipelines(device.device, device.pipelines, 1, &info, nullptr, &pipeline);
  vkDestroyShaderModule(device.device, module, nullptr);
  check(result, "vkCreateComputePipelines");
  return pipeline;
}

namespace {

/// All options except the layout.
std::vector<std::uint64_t> key_of(const PipelineOptions& o) {
  const auto number = [](const auto& value) { return static_cast<std::uint64_t>(value); };
  std::vector<std::uint64_t> key{std::bit_cast<std::uintptr_t>(o.vertex_shader.data()),
                                 std::bit_cast<std::uintptr_t>(o.fragment_shader.data()),
                                 number(o.topology),
                                 o.cull,
                                 number(o.color),
                                 number(o.depth),
                                 o.depth_write,
                                 number(o.depth_compare),
                                 o.blend,
                                 o.color_write,
                                 std::bit_cast<std::uint32_t>(o.depth_bias),
                                 std::bit_cast<std::uint32_t>(o.depth_bias_slope),
                                 number(o.samples),
                                 o.view_mask,
                                 o.bindings.size(),
                                 o.attributes.size()};
  for (const auto& b : o.bindings) key.insert(key.end(), {b.binding, b.stride, number(b.inputRate)});
  for (const VertexAttribute& a : o.attributes) key.insert(key.end(), {a.binding, number(a.format), a.offset});
  key.insert(key.end(), o.constants.begin(), o.constants.end());
  return key;
}

/// Any thread.
VkPipeline create_pipeline(VkDevice device, VkPipelineCache cache, const PipelineOptions& o) {
  require_memory(kRoomToCompile);
  std::vector<VkSpecializationMapEntry> entries;
  for (std::uint32_t i = 0; i < o.constants.size(); ++i) entries.push_back({i, 4 * i, 4});
  const VkSpecializationInfo constants{static_cast<std::uint32_t>(entries.size()), entries.data(),
                                       4 * o.constants.size(), o.constants.data()};
  std::array<VkPipelineShaderStageCreateInfo, 2> stages{};
  std::uint32_t stage_count = 0;
  for (const auto& [code, stage] : {std::pair{o.vertex_shader, VK_SHADER_STAGE_VERTEX_BIT},
                                    std::pair{o.fragment_shader, VK_SHADER_STAGE_FRAGMENT_BIT}})
    if (!code.empty())
      stages[stage_count++] = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                               .stage = stage,
                               .module = create_module(device, code),
                               .pName = "main",
                               .pSpecializationInfo = &constants};
  TYPODONT_CHECK(stage_count >= 1);

  std::vector<VkVertexInputAttributeDescription> attributes;
  for (std::uint32_t i = 0; i < o.attributes.size(); ++i)
    attributes.push_back({i, o.attributes[i].binding, o.attributes[i].format, o.attributes[i].offset});
  const VkPipelineVertexInputStateCreateInfo input{
      .sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO,
      .vertexBindingDescriptionCount = static_cast<std::uint32_t>(o.bindings.size()),
      .pVertexBindingDescriptions = o.bindings.data(),
      .vertexAttributeDescriptionCount = static_cast<std::uint32_t>(attributes.size()),
      .pVertexAttributeDescriptions = attributes.data()};
  const VkPipelineInputAssemblyStateCreateInfo assembly{
      .sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO, .topology = o.topology};
  const VkPipelineViewportStateCreateInfo viewport{
      .sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO, .viewportCount = 1, .scissorCount = 1};
  const VkPipelineRasterizationStateCreateInfo raster{
      .sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO,
      .polygonMode = VK_POLYGON_MODE_FILL,
      .cullMode = o.cull,
      .depthBiasEnable = o.depth_bias != 0 || o.depth_bias_slope != 0,
      .depthBiasConstantFactor = o.depth_bias,
      .depthBiasSlopeFactor = o.depth_bias_slope,
      .lineWidth = 1};
  const VkPipelineMultisampleStateCreateInfo multisample{
      .sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO,
      .rasterizationSamples = static_cast<VkSampleCountFlagBits>(o.samples)};
  const VkPipelineDepthStencilStateCreateInfo depth{.sType = VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO,
                                                    .depthTestEnable = o.depth != VK_FORMAT_UNDEFINED,
                                                    .depthWriteEnable = o.depth != VK_FORMAT_UNDEFINED && o.depth_write,
                                                    .depthCompareOp = o.depth_compare};
  const VkPipelineColorBlendAttachmentState attachment{
      .blendEnable = o.blend,
      .srcColorBlendFactor = VK_BLEND_FACTOR_ONE,
      .dstColorBlendFactor = VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA,
      .colorBlendOp = VK_BLEND_OP_ADD,
      .srcAlphaBlendFactor = VK_BLEND_FACTOR_ONE,
      .dstAlphaBlendFactor = VK_BLEND_FACTOR_ONE_MINUS_SRC_ALPHA,
      .alphaBlendOp = VK_BLEND_OP_ADD,
      .colorWriteMask = o.color_write ? VkColorComponentFlags{VK_COLOR_COMPONENT_R_BIT | VK_COLOR_COMPONENT_G_BIT |
                                                              VK_COLOR_COMPONENT_B_BIT | VK_COLOR_COMPONENT_A_BIT}
                                      : VkColorComponentFlags{0}};
  const bool color = o.color != VK_FORMAT_UNDEFINED;
  const VkPipelineColorBlendStateCreateInfo blend{.sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO,
                                                  .attachmentCount = color ? 1u : 0u,
                                                  .pAttachments = &attachment};
  const std::array<VkDynamicState, 3> dynamics{VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR,
                                               VK_DYNAMIC_STATE_FRONT_FACE};
  const VkPipelineDynamicStateCreateInfo dynamic{.sType = VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO,
                                                 .dynamicStateCount = static_cast<std::uint32_t>(dynamics.size()),
                                                 .pDynamicStates = dynamics.data()};
  const VkPipelineRenderingCreateInfo rendering{.sType = VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO,
                                                .viewMask = o.view_mask,
                                                .colorAttachmentCount = color ? 1u : 0u,
                                                .pColorAttachmentFormats = &o.color,
                                                .depthAttachmentFormat = o.depth};
  const VkGraphicsPipelineCreateInfo info{.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
                                          .pNext = &rendering,
                                          .stageCount = stage_count,
                                          .pStages = stages.data(),
                                          .pVertexInputState = &input,
                                          .pInputAssemblyState = &assembly,
                                          .pViewportState = &viewport,
                                          .pRasterizationState = &raster,
                                          .pMultisampleState = &multisample,
                                          .pDepthStencilState = &depth,
                                          .pColorBlendState = &blend,
                                          .pDynamicState = &dynamic,
                                          .layout = o.layout};
  VkPipeline pipeline = VK_NULL_HANDLE;
  const VkResult result = vkCreateGraphicsPipelines(device, cache, 1, &info, nullptr, &pipeline);
  for (std::uint32_t i = 0; i < stage_count; ++i) vkDestroyShaderModule(device, stages[i].module, nullptr);
  check(result, "vkCreateGraphicsPipelines");
  return pipeline;
}

using Pipeline = std::shared_future<VkPipeline>;

/// The device's entry for these options, and whether it is new. Deferred: the first thread that waits creates it.
auto entry_of(Device& device, const PipelineOptions& options) {
  const auto found = device.created_pipelines.try_emplace(key_of(options));
  if (found.second)
    found.first->second = std::async(std::launch::deferred, create_pipeline, device.device, device.pipelines, options);
  return found;
}

/// True if the pipeline exists or could not be created.
bool is_finished(const Pipeline& pipeline) {
  return pipeline.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
}

}  // namespace

VkPipeline get_pipeline(Device& device, const PipelineOptions& options) {
  const auto [entry, is_new] = entry_of(device, options);
  device.unprepared_pipelines += is_new;
  try {
    return entry->second.get();
  } catch (...) {
    device.created_pipelines.erase(entry);  // the next call tries again
    throw;
  }
}

bool prepare_pipelines(Device& device, std::span<const PipelineOptions> wanted, bool urgent) {
  bool finished = true;
  std::vector<Pipeline> missing;
  for (const PipelineOptions& options : wanted) {
    const auto [entry, is_new] = entry_of(device, options);
    if (is_new) missing.push_back(entry->second);
    finished = finished && is_finished(entry->second);
  }
  if (missing.empty()) return finished;
  const auto create = [missing](const std::stop_token& stop) {
    for (const Pipeline& pipeline : missing)
      if (!stop.stop_requested()) pipeline.wait();
  };
  try {
    device.pipeline_threads.emplace_back([create, urgent](const std::stop_token& stop) {
      if (!urgent) lower_priority();
      create(stop);
    });
  } catch (const std::system_error&) {  // the system grants no thread
    create({});
  }
  return false;
}

void stop_preparing(Device& device) {
  for (std::jthread& thread : device.pipeline_threads) thread.request_stop();
  device.pipeline_threads.clear();  // waits for their ends
  std::erase_if(device.created_pipelines, [](const auto& entry) { return !is_finished(entry.second); });
}

void destroy_pipelines(Device& device) {
  stop_preparing(device);
  for (const auto& [options, pipeline] : std::exchange(device.created_pipelines, {})) {
    try {
      vkDestroyPipeline(device.device, pipeline.get(), nullptr);
    } catch (const std::exception&) {  // it could not be created
    }
  }
}

}  // namespace typodont::gpu
