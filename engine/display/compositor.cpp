#include <array>

#include "engine/display/output.h"
#include "shaders/compose_frag.h"
#include "shaders/compose_vert.h"

namespace typodont::display {

namespace {
constexpr int kSlots = gpu::FrameRing::kSlots;
constexpr int kOneLayer = 8;  // compose.frag: the whole target from one eye
}  // namespace

struct Compositor::Impl {
  gpu::Device& device;
  VkDescriptorSetLayout set_layout = VK_NULL_HANDLE;
  VkPipelineLayout layout = VK_NULL_HANDLE;
  VkDescriptorPool pool = VK_NULL_HANDLE;
  std::array<VkDescriptorSet, kSlots> sets{};
  VkSampler sampler = VK_NULL_HANDLE;
  VkPipeline pipeline = VK_NULL_HANDLE;
  VkFormat format = VK_FORMAT_UNDEFINED;

  explicit Impl(gpu::Device& d) : device(d) {
    const VkDescriptorSetLayoutBinding binding{0, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 1,
                                               VK_SHADER_STAGE_FRAGMENT_BIT, nullptr};
    const VkDescriptorSetLayoutCreateInfo set_info{
        .sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO, .bindingCount = 1, .pBindings = &binding};
    gpu::check(vkCreateDescriptorSetLayout(device.device, &set_info, nullptr, &set_layout),
               "vkCreateDescriptorSetLayout");
    const VkPushConstantRange range{VK_SHADER_STAGE_FRAGMENT_BIT, 0, sizeof(glm::ivec4)};
    const VkPipelineLayoutCreateInfo layout_info{.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                                 .setLayoutCount = 1,
                                                 .pSetLayouts = &set_layout,
                                                 .pushConstantRangeCount = 1,
                                                 .pPushConstantRanges = &range};
    gpu::check(vkCreatePipelineLayout(device.device, &layout_info, nullptr, &layout), "vkCreatePipelineLayout");
    const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, kSlots};
    const VkDescriptorPoolCreateInfo pool_info{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                               .maxSets = kSlots,
                                               .poolSizeCount = 1,
                                               .pPoolSizes = &size};
    gpu::check(vkCreateDescriptorPool(device.device, &pool_info, nullptr, &pool), "vkCreateDescriptorPool");
    const std::array<VkDescriptorSetLayout, kSlots> layouts{set_layout, set_layout};
    const VkDescriptorSetAllocateInfo allocate{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                               .descriptorPool = pool,
                                               .descriptorSetCount = kSlots,
                                               .pSetLayouts = layouts.data()};
    gpu::check(vkAllocateDescriptorSets(device.device, &allocate, sets.data()), "vkAllocateDescriptorSets");
    const VkSamplerCreateInfo sampler_info{.sType = VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO,
                                           .magFilter = VK_FILTER_LINEAR,
                                           .minFilter = VK_FILTER_LINEAR,
                                           .addressModeU = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                           .addressModeV = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                           .addressModeW = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE};
    gpu::check(vkCreateSampler(device.device, &sampler_info, nullptr, &sampler), "vkCreateSampler");
  }
  ~Impl() {
    vkDeviceWaitIdle(device.device);
    if (pipeline) vkDestroyPipeline(device.device, pipeline, nullptr);
    vkDestroySampler(device.device, sampler, nullptr);
    vkDestroyDescriptorPool(device.device, pool, nullptr);
    vkDestroyPipelineLayout(device.device, layout, nullptr);
    vkDestroyDescriptorSetLayout(device.device, set_layout, nullptr);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  void prepare(VkFormat target_format) {
    if (format == target_format) return;
    if (pipeline) {
      vkDeviceWaitIdle(device.device);
      vkDestroyPipeline(device.device, pipeline, nullptr);
    }
    gpu::PipelineOptions o;
    o.vertex_shader = kSpirv_compose_vert;
    o.fragment_shader = kSpirv_compose_frag;
    o.layout = layout;
    o.cull = VK_CULL_MODE_NONE;
    o.color = target_format;
    pipeline = gpu::create_pipeline(device, o);
    format = target_format;
  }
};

Compositor::Compositor(gpu::Device& device) : impl_(std::make_unique<Impl>(device)) {}
Compositor::~Compositor() = default;

void Compositor::record(VkCommandBuffer commands, const gpu::Image& pictures, Layout layout, const Target& target,
                        int slot, int first_row) {
  Impl& m = *impl_;
  m.prepare(target.format);
  const VkDescriptorSet set = m.sets[static_cast<std::size_t>(slot)];
  const VkDescriptorImageInfo image{m.sampler, pictures.alias_view, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL};
  const VkWriteDescriptorSet write{.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                                   .dstSet = set,
                                   .descriptorCount = 1,
                                   .descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
                                   .pImageInfo = &image};
  vkUpdateDescriptorSets(m.device.device, 1, &write, 0, nullptr);

  gpu::transition(commands, target.image, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_UNDEFINED,
                  VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_ACCESS_2_NONE,
                  VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT, VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT);
  const VkExtent2D extent{static_cast<std::uint32_t>(target.size.x), static_cast<std::uint32_t>(target.size.y)};
  for (std::size_t layer = 0; layer < target.layers.size(); ++layer) {
    const VkRenderingAttachmentInfo info{.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                         .imageView = target.layers[layer],
                                         .imageLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                                         .loadOp = VK_ATTACHMENT_LOAD_OP_DONT_CARE,
                                         .storeOp = VK_ATTACHMENT_STORE_OP_STORE};
    const VkRenderingInfo rendering{.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                                    .renderArea = {{0, 0}, extent},
                                    .layerCount = 1,
                                    .colorAttachmentCount = 1,
                                    .pColorAttachments = &info};
    vkCmdBeginRendering(commands, &rendering);
    const VkViewport viewport{0, 0, static_cast<float>(extent.width), static_cast<float>(extent.height), 0, 1};
    const VkRect2D scissor{{0, 0}, extent};
    vkCmdSetViewport(commands, 0, 1, &viewport);
    vkCmdSetScissor(commands, 0, 1, &scissor);
    vkCmdSetFrontFace(commands, VK_FRONT_FACE_COUNTER_CLOCKWISE);
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, m.pipeline);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, m.layout, 0, 1, &set, 0, nullptr);
    const bool stereo_surface = target.layers.size() > 1;
    const glm::ivec4 place(target.size, stereo_surface ? kOneLayer : static_cast<int>(layout),
                           stereo_surface ? static_cast<int>(layer) : first_row);
    vkCmdPushConstants(commands, m.layout, VK_SHADER_STAGE_FRAGMENT_BIT, 0, sizeof place, &place);
    vkCmdDraw(commands, 3, 1, 0, 0);
    vkCmdEndRendering(commands);
  }
  gpu::transition(commands, target.image, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                  target.final_layout, VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT,
                  VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                  VK_ACCESS_2_MEMORY_READ_BIT);
}

}  // namespace typodont::display
