#include <algorithm>
#include <array>
#include <deque>
#include <map>

#include "engine/display/output.h"
#include "shaders/compose_frag.h"
#include "shaders/compose_vert.h"

namespace typodont::display {

namespace {
constexpr int kSlots = gpu::FrameRing::kSlots;
constexpr std::size_t kRemembered = 6;  // frames: as many as a window's images, and more
constexpr int kOneLayer = 8;  // compose.frag: the whole target from one eye
}  // namespace

struct Compositor::Impl {
  gpu::Device& device;
  gpu::ShaderInputs inputs;
  VkSampler sampler = VK_NULL_HANDLE;
  VkPipeline pipeline = VK_NULL_HANDLE;
  VkFormat format = VK_FORMAT_UNDEFINED;

  // What the last frames changed, by their number, and which of them each target holds.
  using Parts = std::array<std::vector<Part>, 2>;
  std::deque<Parts> history;  // the newest last, of frame `frame`
  std::uint64_t frame = 0;
  std::map<VkImage, std::uint64_t> holds;
  VkExtent2D size{};  // of the pictures they were composed from
  Layout layout = Layout::kMono;
  int first_row = 0;

  explicit Impl(gpu::Device& d) : device(d) {
    inputs = gpu::ShaderInputs::create(d, {{}}, kSlots, sizeof(glm::ivec4));
    sampler = gpu::create_sampler(d);
  }
  ~Impl() {
    vkDeviceWaitIdle(device.device);
    if (pipeline) vkDestroyPipeline(device.device, pipeline, nullptr);
    vkDestroySampler(device.device, sampler, nullptr);
    inputs.destroy(device);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  /// Where in the target an eye's part is seen; a pixel more all round, for pictures are stretched.
  VkRect2D place(const Part& part, int eye, Layout how, const ivec2& picture, const ivec2& target) const {
    ivec2 lo(0), extent = target;
    if (how == Layout::kSideBySide || how == Layout::kTwoOutputs) {
      extent.x = target.x / 2;
      lo.x = eye * extent.x;
    } else if (how == Layout::kTopBottom || how == Layout::kFrameSequential) {
      extent.y = target.y / 2;
      lo.y = eye * extent.y;
    }
    const dvec2 scale = dvec2(extent) / dvec2(picture);
    const double more = picture == extent ? 0 : 2;
    const dvec2 edge(extent);
    const ivec2 from(glm::clamp(glm::floor(dvec2(part.x, part.y) * scale - more), dvec2(0), edge)),
        to(glm::clamp(glm::ceil(dvec2(part.x + part.width, part.y + part.height) * scale + more), dvec2(0), edge));
    return {{lo.x + from.x, lo.y + from.y},
            {static_cast<std::uint32_t>(to.x - from.x), static_cast<std::uint32_t>(to.y - from.y)}};
  }

  /// What of the target is to be drawn; nothing: all of it.
  std::vector<VkRect2D> lacking(const gpu::Image& pictures, Layout how, const Target& target, int row,
                                const Parts* changed) {
    const VkExtent2D now = pictures.options.size;
    if (!changed || now.width != size.width || now.height != size.height || how != layout || row != first_row) {
      history.clear();
      holds.clear();
      size = now;
      layout = how;
      first_row = row;
    }
    ++frame;
    history.push_back(changed ? *changed : Parts{});
    if (history.size() > kRemembered) history.pop_front();
    const auto held = holds.find(target.image);
    const std::uint64_t behind = held == holds.end() ? ~0ull : frame - held->second;
    holds[target.image] = frame;
    std::vector<VkRect2D> parts;
    // A stereo surface has a layer an eye; where it lacks more than is remembered, it gets everything.
    if (!changed || !target.kept || behind > history.size() || target.layers.size() > 1) return parts;
    const ivec2 picture(static_cast<int>(now.width), static_cast<int>(now.height));
    for (std::size_t i = history.size() - behind; i < history.size(); ++i)
      for (int eye = 0; eye < 2; ++eye)
        for (const Part& part : history[i][static_cast<std::size_t>(eye)]) {
          const VkRect2D rect = place(part, eye, how, picture, target.size);
          const auto same = [&](const VkRect2D& r) {
            return r.offset.x == rect.offset.x && r.offset.y == rect.offset.y && r.extent.width == rect.extent.width &&
                   r.extent.height == rect.extent.height;
          };
          if (std::none_of(parts.begin(), parts.end(), same)) parts.push_back(rect);
        }
    return parts;
  }

  void prepare(VkFormat target_format) {
    if (format == target_format) return;
    if (pipeline) {
      vkDeviceWaitIdle(device.device);
      vkDestroyPipeline(device.device, pipeline, nullptr);
    }
    gpu::PipelineOptions o;
    o.vertex_shader = kSpirv_compose_vert;
    o.fragment_shader = kSpirv_compose_frag;
    o.layout = inputs.layout;
    o.cull = VK_CULL_MODE_NONE;
    o.color = target_format;
    pipeline = gpu::create_pipeline(device, o);
    format = target_format;
  }
};

Compositor::Compositor(gpu::Device& device) : impl_(std::make_unique<Impl>(device)) {}
Compositor::~Compositor() = default;

void Compositor::record(VkCommandBuffer commands, const gpu::Image& pictures, Layout layout, const Target& target,
                        int slot, int first_row, const std::array<std::vector<Part>, 2>* changed) {
  Impl& m = *impl_;
  m.prepare(target.format);
  m.inputs.fill(m.device, static_cast<std::size_t>(slot), 0, m.sampler, pictures.alias_view);
  const VkDescriptorSet set = m.inputs.sets[static_cast<std::size_t>(slot)];
  const std::vector<VkRect2D> parts = m.lacking(pictures, layout, target, first_row, changed);

  gpu::transition(commands, target.image, VK_IMAGE_ASPECT_COLOR_BIT,
                  parts.empty() ? VK_IMAGE_LAYOUT_UNDEFINED : target.final_layout,
                  VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_ACCESS_2_NONE,
                  VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT,
                  VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT);
  const VkExtent2D extent{static_cast<std::uint32_t>(target.size.x), static_cast<std::uint32_t>(target.size.y)};
  for (std::size_t layer = 0; layer < target.layers.size(); ++layer) {
    const VkRenderingAttachmentInfo info{.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                         .imageView = target.layers[layer],
                                         .imageLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                                         .loadOp = parts.empty() ? VK_ATTACHMENT_LOAD_OP_DONT_CARE
                                                                 : VK_ATTACHMENT_LOAD_OP_LOAD,
                                         .storeOp = VK_ATTACHMENT_STORE_OP_STORE};
    const VkRenderingInfo rendering{.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                                    .renderArea = {{0, 0}, extent},
                                    .layerCount = 1,
                                    .colorAttachmentCount = 1,
                                    .pColorAttachments = &info};
    vkCmdBeginRendering(commands, &rendering);
    const VkViewport viewport{0, 0, static_cast<float>(extent.width), static_cast<float>(extent.height), 0, 1};
    vkCmdSetViewport(commands, 0, 1, &viewport);
    vkCmdSetFrontFace(commands, VK_FRONT_FACE_COUNTER_CLOCKWISE);
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, m.pipeline);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, m.inputs.layout, 0, 1, &set, 0, nullptr);
    const bool stereo_surface = target.layers.size() > 1;
    const glm::ivec4 place(target.size, stereo_surface ? kOneLayer : static_cast<int>(layout),
                           stereo_surface ? static_cast<int>(layer) : first_row);
    vkCmdPushConstants(commands, m.inputs.layout, VK_SHADER_STAGE_FRAGMENT_BIT, 0, sizeof place, &place);
    const VkRect2D everything{{0, 0}, extent};
    for (const VkRect2D& part : parts.empty() ? std::vector{everything} : parts) {
      vkCmdSetScissor(commands, 0, 1, &part);
      vkCmdDraw(commands, 3, 1, 0, 0);
    }
    vkCmdEndRendering(commands);
  }
  gpu::transition(commands, target.image, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                  target.final_layout, VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT,
                  VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                  VK_ACCESS_2_MEMORY_READ_BIT);
}

}  // namespace typodont::display
