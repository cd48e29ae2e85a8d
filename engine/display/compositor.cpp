#include <algorithm>
#include <array>
#include <cstring>
#include <deque>
#include <map>
#include <memory>
#include <optional>

#include "engine/display/compose/by_processor.h"
#include "engine/display/compose/places.h"
#include "engine/display/output.h"
#include "engine/display/writing.h"
#include "shaders/compose_frag.h"
#include "shaders/compose_vert.h"
#include "shaders/writing_frag.h"

namespace typodont::display {

namespace {
constexpr int kSlots = gpu::FrameRing::kSlots;
// Number of frames whose changes are stored; larger than the number of a window's images.
constexpr std::size_t kHistoryFrames = 6;

bool same(const VkRect2D& a, const VkRect2D& b) {
  return a.offset.x == b.offset.x && a.offset.y == b.offset.y && a.extent.width == b.extent.width &&
         a.extent.height == b.extent.height;
}
Part part_of(const VkRect2D& r) {
  return {r.offset.x, r.offset.y, static_cast<int>(r.extent.width), static_cast<int>(r.extent.height)};
}
bool meet(const VkRect2D& a, const VkRect2D& b) {
  const Part p = part_of(a), q = part_of(b);
  return p.x < q.x + q.width && q.x < p.x + p.width && p.y < q.y + q.height && q.y < p.y + p.height;
}
/// Converts a box in an eye's region to target pixels.
VkRect2D in_target(const WritingBox& box, const Place& place) {
  return {{place.lo.x + box.lo.x, place.lo.y + box.lo.y},
          {static_cast<std::uint32_t>(box.size.x), static_cast<std::uint32_t>(box.size.y)}};
}
}  // namespace

struct Compositor::Impl {
  gpu::Device& device;
  gpu::ShaderInputs inputs;
  VkSampler sampler = VK_NULL_HANDLE;
  // First index: Mix; second index: 0 or 1: whether source and target have the same size; 2: a warped picture.
  std::array<std::array<VkPipeline, 3>, kMixes> pipelines{};
  VkPipeline writing_pipeline = VK_NULL_HANDLE;
  VkFormat format = VK_FORMAT_UNDEFINED;

  // Parts: parts of each eye's picture. Rects: rectangles in each region of the target. `holds`: frame per target.
  using Parts = std::array<std::vector<Part>, 2>;
  using Rects = std::array<std::vector<VkRect2D>, 2>;
  struct Change {
    Parts pictures;  // changed parts of the pictures of both eyes
    Rects written;   // rectangles of changed text, for each region of the target
  };
  std::deque<Change> history;  // changes, oldest first; the newest belongs to frame `frame`
  std::uint64_t frame = 0;
  std::map<VkImage, std::uint64_t> holds;
  VkExtent2D size{};  // size of the pictures that were composed last
  Layout layout = Layout::kMono;
  int first_row = 0;

  std::shared_ptr<const Warp> warp;  // null: panel and mirror are plane

  // Text of both eyes; frames in flight with the same text share it.
  using Writings = std::array<std::shared_ptr<const Writing>, 2>;
  Writings writing{std::make_shared<const Writing>(), std::make_shared<const Writing>()};
  std::array<ivec2, 2> region_sizes{};  // pixels, size of each eye's region of the target
  struct OnDevice {
    Writings holds;
    gpu::Buffer pixels;  // pixels of all text panels, one after the other
    std::shared_ptr<const Warp> warp_of;
    gpu::Buffer warp;
    std::array<std::vector<std::int32_t>, 2> first{};  // index in `pixels` of each text panel's first pixel
  };
  std::array<OnDevice, kSlots> on_device;

  // Job of the CPU, one per frame in flight: the GPU copies changed parts to `eyes`, then the CPU composes `parts`.
  struct CpuJob {
    gpu::Buffer eyes;
    VkExtent2D size{};
    std::uint32_t layers = 0;
    Layout layout = Layout::kMono;
    int first_row = 0;
    HostPixels to;
    ivec2 target{0};
    Rects parts;         // parts of the target to compose
    bool waits = false;  // true if this frame must still be composed
    Writings writing;
    std::shared_ptr<const Warp> warp;
    std::array<std::vector<std::size_t>, 2> panels;  // text panels to draw over the picture
  };
  std::array<CpuJob, kSlots> cpu_jobs;
  ProcessorComposer composer;

  explicit Impl(gpu::Device& d) : device(d) {
    inputs = gpu::ShaderInputs::create(
        d, {{}, {.type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER}, {.type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER}}, kSlots,
        sizeof(glm::ivec4));
    sampler = gpu::create_sampler(d);
  }
  ~Impl() {
    vkDeviceWaitIdle(device.device);
    for (CpuJob& b : cpu_jobs) b.eyes.destroy(device);
    for (OnDevice& o : on_device) o.pixels.destroy(device), o.warp.destroy(device);
    vkDestroySampler(device.device, sampler, nullptr);
    inputs.destroy(device);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  /// Region of the target for an eye's picture. A stereo surface has one layer per eye instead of regions.
  static Place place_on(std::size_t eye, Layout how, const Target& target) {
    return target.layers.size() > 1 ? Place{{0, 0}, target.size} : place_of(static_cast<int>(eye), how, target.size);
  }
  static const Hud& or_nothing(const Hud* hud) {
    static const Hud kNothing;
    return hud ? *hud : kNothing;
  }
  /// Returns the number of regions in a layout.
  static std::size_t places(Layout how) { return two_places(how) ? 2 : 1; }

  /// Draws the text into panels if it has changed. Returns the changed parts of each region.
  Rects write(const Huds& huds, Layout how, const Target& target) {
    Rects changed;
    for (std::size_t e = 0; e < places(how); ++e) {
      const Place place = place_on(e, how, target);
      const Hud& hud = or_nothing(huds[e]);
      region_sizes[e] = place.size;
      if (!writing[e]->differs(hud, place.size)) continue;
      auto anew = std::make_shared<Writing>(*writing[e]);
      for (const WritingBox& box : anew->write(hud, place.size)) changed[e].push_back(in_target(box, place));
      writing[e] = std::move(anew);
    }
    return changed;
  }

  /// Selects the text panels that overlap redrawn parts. Adds their boxes to `parts`, so that the background of the
  /// whole panel is composed first.
  std::array<std::vector<std::size_t>, 2> panels_over(std::optional<Rects>& parts, Layout how,
                                                      const Target& target) const {
    std::array<std::vector<std::size_t>, 2> chosen;
    for (std::size_t e = 0; e < places(how); ++e) {
      const Place place = place_on(e, how, target);
      const auto panels = writing[e]->panels();
      std::vector<bool> touched(panels.size(), !parts.has_value());
      for (bool more = parts.has_value(); more;) {  // repeats the search, because a panel may overlap another panel
        more = false;
        for (std::size_t i = 0; i < panels.size(); ++i) {
          const VkRect2D box = in_target(panels[i].box, place);
          auto& of_place = (*parts)[e];
          if (touched[i] ||
              std::none_of(of_place.begin(), of_place.end(), [&](const VkRect2D& r) { return meet(r, box); }))
            continue;
          of_place.push_back(box);
          touched[i] = more = true;
        }
      }
      for (std::size_t i = 0; i < panels.size(); ++i)
        if (touched[i]) chosen[e].push_back(i);
    }
    return chosen;
  }

  /// Copies the pixels of the text panels to this frame's buffer.
  void put_on_device(int slot) {
    OnDevice& there = on_device[static_cast<std::size_t>(slot)];
    if (there.pixels.buffer && there.holds == writing) return;
    there.holds = writing;
    std::size_t bytes = 4;
    for (const auto& of_place : writing)
      for (const Writing::Panel& panel : of_place->panels()) bytes += panel.rgba.size();
    if (there.pixels.size < bytes) {
      there.pixels.destroy(device);
      there.pixels = gpu::Buffer::create(device, bytes + bytes / 2, VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
    }
    std::size_t at = 0;
    for (std::size_t e = 0; e < 2; ++e) {
      there.first[e].clear();
      for (const Writing::Panel& panel : writing[e]->panels()) {
        there.first[e].push_back(static_cast<std::int32_t>(at / 4));
        std::memcpy(there.pixels.memory.mapped + at, panel.rgba.data(), panel.rgba.size());
        at += panel.rgba.size();
      }
    }
    inputs.fill(device, static_cast<std::size_t>(slot), 1, there.pixels);
  }

  /// Copies the warp to this frame's buffer; without a warp, the buffer is bound, but not read.
  void put_warp_on_device(int slot) {
    OnDevice& there = on_device[static_cast<std::size_t>(slot)];
    if (there.warp.buffer && there.warp_of == warp) return;
    if (!there.warp.buffer) {
      there.warp = gpu::Buffer::create(device, sizeof(glm::vec2) * 2 * kWarpSide * kWarpSide,
                                       VK_BUFFER_USAGE_STORAGE_BUFFER_BIT);
      inputs.fill(device, static_cast<std::size_t>(slot), 2, there.warp);
    }
    there.warp_of = warp;
    std::byte* to = reinterpret_cast<std::byte*>(there.warp.memory.mapped);
    for (std::size_t e = 0; warp && e < 2; ++e) {
      const std::size_t bytes = sizeof(glm::vec2) * (*warp)[e].size();
      std::memcpy(to, (*warp)[e].data(), bytes);
      to += bytes;
    }
  }

  /// Part of the target in which a part of the picture appears; two pixels larger if the picture is stretched.
  static VkRect2D seen(const Part& part, const Place& place, const ivec2& picture) {
    const dvec2 scale = dvec2(place.size) / dvec2(picture);
    const double more = picture == place.size ? 0 : 2;
    const dvec2 edge(place.size);
    const ivec2 from(glm::clamp(glm::floor(dvec2(part.x, part.y) * scale - more), dvec2(0), edge)),
        to(glm::clamp(glm::ceil(dvec2(part.x + part.width, part.y + part.height) * scale + more), dvec2(0), edge));
    return {{place.lo.x + from.x, place.lo.y + from.y},
            {static_cast<std::uint32_t>(to.x - from.x), static_cast<std::uint32_t>(to.y - from.y)}};
  }

  /// Returns the parts to redraw in each region; nullopt: all.
  std::optional<Rects> missing_parts(const gpu::Image& pictures, Layout how, const Target& target, int row,
                                     const Parts* changed, Rects written) {
    const VkExtent2D now = pictures.options.size;
    if (!changed || now.width != size.width || now.height != size.height || how != layout || row != first_row) {
      history.clear();
      holds.clear();
      size = now;
      layout = how;
      first_row = row;
    }
    ++frame;
    history.push_back({changed ? *changed : Parts{}, std::move(written)});
    if (history.size() > kHistoryFrames) history.pop_front();
    const auto held = holds.find(target.image);
    const std::uint64_t behind = held == holds.end() ? ~0ull : frame - held->second;
    holds[target.image] = frame;
    // Everything is redrawn for stereo surfaces, and if the target's frame is older than the history.
    if (!changed || !target.kept || behind > history.size() || target.layers.size() > 1) return std::nullopt;
    const ivec2 picture(static_cast<int>(now.width), static_cast<int>(now.height));
    Rects parts;
    for (std::size_t i = history.size() - behind; i < history.size(); ++i)
      for (std::size_t eye = 0; eye < 2; ++eye) {
        // If both eyes share a region of the target, parts[0] receives the changed parts of both eyes' pictures.
        auto& of_place = parts[mix_of(how) == Mix::kOneEye ? eye : 0];
        const auto add = [&](const VkRect2D& rect) {
          if (std::none_of(of_place.begin(), of_place.end(), [&](const VkRect2D& r) { return same(r, rect); }))
            of_place.push_back(rect);
        };
        for (const Part& part : history[i].pictures[eye])
          add(seen(part, place_of(static_cast<int>(eye), how, target.size), picture));
        for (const VkRect2D& rect : history[i].written[eye]) add(rect);
      }
    return parts;
  }

  gpu::PipelineOptions pipeline_options(VkFormat target_format, std::span<const std::uint32_t> fragment_shader) {
    if (format != target_format) {
      pipelines = {};
      writing_pipeline = VK_NULL_HANDLE;
      format = target_format;
    }
    gpu::PipelineOptions o;
    o.vertex_shader = kSpirv_compose_vert;
    o.fragment_shader = fragment_shader;
    o.layout = inputs.layout;
    o.cull = VK_CULL_MODE_NONE;
    o.color = target_format;
    return o;
  }
  VkPipeline pipeline(VkFormat target_format, Mix mix, bool fits) {
    gpu::PipelineOptions o = pipeline_options(target_format, kSpirv_compose_frag);
    VkPipeline& made = pipelines[static_cast<std::size_t>(mix)][warp ? 2 : fits];
    if (made) return made;
    o.constants = {static_cast<std::uint32_t>(mix), fits ? 1u : 0u, warp ? 1u : 0u};
    return made = gpu::get_pipeline(device, o);
  }

  /// Draws text panels, in the pass that composed their region.
  void write_over(VkCommandBuffer commands, VkFormat target_format, std::size_t eye, const Place& place, int slot,
                  const std::vector<std::size_t>& panels) {
    if (panels.empty()) return;
    if (!writing_pipeline) {
      gpu::PipelineOptions o = pipeline_options(target_format, kSpirv_writing_frag);
      o.blend = true;
      writing_pipeline = gpu::get_pipeline(device, o);
    }
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, writing_pipeline);
    for (const std::size_t i : panels) {
      const VkRect2D box = in_target(writing[eye]->panels()[i].box, place);
      const glm::ivec4 push(box.offset.x, box.offset.y, box.extent.width,
                            on_device[static_cast<std::size_t>(slot)].first[eye][i]);
      vkCmdPushConstants(commands, inputs.layout, VK_SHADER_STAGE_FRAGMENT_BIT, 0, sizeof push, &push);
      vkCmdSetScissor(commands, 0, 1, &box);
      vkCmdDraw(commands, 3, 1, 0, 0);
    }
  }

  /// Copies the changed parts of the pictures to memory that the CPU reads.
  void fetch(VkCommandBuffer commands, const gpu::Image& pictures, Layout how, const Target& target, int slot, int row,
             const std::optional<Rects>& parts, const std::array<std::vector<std::size_t>, 2>& panels) {
    CpuJob& job = cpu_jobs[static_cast<std::size_t>(slot)];
    const VkExtent2D now = pictures.options.size;
    const std::uint32_t layers = pictures.options.layers;
    const VkDeviceSize layer_bytes = VkDeviceSize{4} * now.width * now.height;
    // The buffer has room for one more pixel (4 bytes), which interpolation reads.
    if (job.size.width != now.width || job.size.height != now.height || job.layers != layers) {
      job.eyes.destroy(device);
      job.eyes = gpu::Buffer::create_readback(device, layers * layer_bytes + 4);
    }
    job.size = now;
    job.layers = layers;
    job.layout = how;
    job.first_row = row;
    job.to = target.memory;
    job.target = target.size;
    job.waits = true;
    job.writing = writing;
    job.warp = warp;
    job.panels = panels;
    for (std::size_t eye = 0; eye < 2; ++eye) {
      const Place place = place_of(static_cast<int>(eye), how, target.size);
      job.parts[eye] = parts ? (*parts)[eye]
                             : std::vector{VkRect2D{{place.lo.x, place.lo.y},
                                                    {static_cast<std::uint32_t>(place.size.x),
                                                     static_cast<std::uint32_t>(place.size.y)}}};
      if (eye == 1 && !two_places(how)) job.parts[eye].clear();
    }

    std::vector<VkBufferImageCopy> copies;
    for (std::uint32_t layer = 0; layer < layers; ++layer) {
      // If the eyes share a region, job.parts[0] lists the parts; they are copied from the pictures of both eyes.
      const std::size_t eye = two_places(how) ? layer : 0;
      const Place place = place_of(static_cast<int>(layer), how, target.size);
      const dvec2 scale = dvec2(now.width, now.height) / dvec2(place.size);
      for (const VkRect2D& r : job.parts[eye]) {
        const dvec2 lo(r.offset.x - place.lo.x, r.offset.y - place.lo.y);
        const ivec2 from(glm::max(glm::floor(lo * scale - 1.0), dvec2(0))),
            to(glm::min(glm::ceil((lo + dvec2(r.extent.width, r.extent.height)) * scale + 1.0),
                        dvec2(now.width, now.height)));
        if (to.x <= from.x || to.y <= from.y) continue;
        copies.push_back(
            {.bufferOffset = layer * layer_bytes + VkDeviceSize{4} * (static_cast<VkDeviceSize>(from.y) * now.width +
                                                                      static_cast<VkDeviceSize>(from.x)),
             .bufferRowLength = now.width,
             .imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, layer, 1},
             .imageOffset = {from.x, from.y, 0},
             .imageExtent = {static_cast<std::uint32_t>(to.x - from.x), static_cast<std::uint32_t>(to.y - from.y), 1}});
      }
    }
    if (copies.empty()) return;
    gpu::transition(commands, pictures, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                    VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_ACCESS_2_MEMORY_WRITE_BIT, VK_PIPELINE_STAGE_2_COPY_BIT,
                    VK_ACCESS_2_TRANSFER_READ_BIT);
    vkCmdCopyImageToBuffer(commands, pictures.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, job.eyes.buffer,
                           static_cast<std::uint32_t>(copies.size()), copies.data());
    gpu::transition(commands, pictures, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
                    VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_NONE, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                    VK_ACCESS_2_MEMORY_READ_BIT);
    gpu::make_visible_to_host(commands, VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT);
  }

  void compose(int slot) {
    CpuJob& job = cpu_jobs[static_cast<std::size_t>(slot)];
    job.waits = false;
    const std::size_t layer_bytes = std::size_t{4} * job.size.width * job.size.height;
    EyePixels eyes{.size = {static_cast<int>(job.size.width), static_cast<int>(job.size.height)}};
    for (std::size_t e = 0; e < 2; ++e)
      eyes.first[e] = job.eyes.mapped<std::uint8_t>(std::min<std::size_t>(e, job.layers - 1) * layer_bytes);
    for (std::size_t e = 0; e < 2; ++e) {
      const int eye = mix_of(job.layout) == Mix::kRows ? job.first_row : static_cast<int>(e);
      for (const VkRect2D& r : job.parts[e])
        composer.compose(eyes, mix_of(job.layout), place_of(static_cast<int>(e), job.layout, job.target), eye,
                         part_of(r), job.to.first, job.to.pitch, job.warp.get());
    }
    for (std::size_t e = 0; e < 2; ++e)
      for (const std::size_t i : job.panels[e])
        Writing::lay_over(job.writing[e]->panels()[i], job.to.first, job.to.pitch,
                          place_of(static_cast<int>(e), job.layout, job.target).lo, /*blue_first=*/true);
  }
};

Compositor::Compositor(gpu::Device& device) : impl_(std::make_unique<Impl>(device)) {}
Compositor::~Compositor() = default;

void Compositor::bend(std::optional<Warp> warp) {
  impl_->warp = warp ? std::make_shared<const Warp>(std::move(*warp)) : nullptr;
}

std::optional<std::vector<Part>> Compositor::record(VkCommandBuffer commands, const gpu::Image& pictures, Layout layout,
                                                    const Target& target, int slot, int first_row,
                                                    const std::array<std::vector<Part>, 2>* changed, const Huds& huds) {
  Impl& m = *impl_;
  if (m.warp) changed = nullptr;  // every part may have moved
  auto parts = m.missing_parts(pictures, layout, target, first_row, changed, m.write(huds, layout, target));
  const auto listed = [&]() -> std::optional<std::vector<Part>> {
    if (!parts) return std::nullopt;
    std::vector<Part> drawn;
    for (const auto& of_eye : *parts)
      for (const VkRect2D& r : of_eye)
        if (r.extent.width > 0 && r.extent.height > 0) drawn.push_back(part_of(r));
    return drawn;
  };
  if (target.memory.first) {
    // `slot` selects the buffers. If the CPU has not composed this slot's last frame, all parts are composed.
    if (m.cpu_jobs[static_cast<std::size_t>(slot)].waits) parts.reset();
    const auto panels = m.panels_over(parts, layout, target);
    m.fetch(commands, pictures, layout, target, slot, first_row, parts, panels);
    return listed();
  }
  const auto panels = m.panels_over(parts, layout, target);
  m.put_on_device(slot);
  m.put_warp_on_device(slot);
  m.inputs.fill(m.device, static_cast<std::size_t>(slot), 0, m.sampler, pictures.alias_view);
  const VkDescriptorSet set = m.inputs.sets[static_cast<std::size_t>(slot)];

  gpu::transition(commands, target.image, VK_IMAGE_ASPECT_COLOR_BIT,
                  parts ? target.final_layout : VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                  VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_ACCESS_2_NONE,
                  VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT,
                  VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT);
  const VkExtent2D extent{static_cast<std::uint32_t>(target.size.x), static_cast<std::uint32_t>(target.size.y)};
  // If the target's width or height is odd, the eyes' regions do not cover one column or row, which must be black.
  const bool covered_by_eyes = target.size.x % 2 == 0 && target.size.y % 2 == 0;
  for (std::size_t target_layer = 0; target_layer < target.layers.size(); ++target_layer) {
    const VkRenderingAttachmentInfo info{.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                         .imageView = target.layers[target_layer],
                                         .imageLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                                         .loadOp = parts             ? VK_ATTACHMENT_LOAD_OP_LOAD
                                                   : covered_by_eyes ? VK_ATTACHMENT_LOAD_OP_DONT_CARE
                                                                     : VK_ATTACHMENT_LOAD_OP_CLEAR,
                                         .storeOp = VK_ATTACHMENT_STORE_OP_STORE};
    const VkRenderingInfo rendering{.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                                    .renderArea = {{0, 0}, extent},
                                    .layerCount = 1,
                                    .colorAttachmentCount = 1,
                                    .pColorAttachments = &info};
    vkCmdBeginRendering(commands, &rendering);
    vkCmdSetFrontFace(commands, VK_FRONT_FACE_COUNTER_CLOCKWISE);
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, m.inputs.layout, 0, 1, &set, 0, nullptr);
    const bool stereo_surface = target.layers.size() > 1;
    const Mix mix = stereo_surface ? Mix::kOneEye : mix_of(layout);
    const int last = static_cast<int>(pictures.options.layers) - 1;
    for (int eye = 0; eye < (!stereo_surface && two_places(layout) ? 2 : 1); ++eye) {
      const Place place = stereo_surface ? Place{{0, 0}, target.size} : place_of(eye, layout, target.size);
      const bool fits = place.size == ivec2(static_cast<int>(pictures.options.size.width),
                                            static_cast<int>(pictures.options.size.height));
      vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, m.pipeline(target.format, mix, fits));
      const int layer = std::min(stereo_surface ? static_cast<int>(target_layer) : eye, last);
      const glm::ivec4 push(place.lo, mix == Mix::kRows ? first_row : layer, last);
      vkCmdPushConstants(commands, m.inputs.layout, VK_SHADER_STAGE_FRAGMENT_BIT, 0, sizeof push, &push);
      const VkViewport viewport{static_cast<float>(place.lo.x),
                                static_cast<float>(place.lo.y),
                                static_cast<float>(place.size.x),
                                static_cast<float>(place.size.y),
                                0,
                                1};
      vkCmdSetViewport(commands, 0, 1, &viewport);
      const VkRect2D everything{{place.lo.x, place.lo.y},
                                {static_cast<std::uint32_t>(place.size.x), static_cast<std::uint32_t>(place.size.y)}};
      for (const VkRect2D& part : parts ? (*parts)[static_cast<std::size_t>(eye)] : std::vector{everything}) {
        vkCmdSetScissor(commands, 0, 1, &part);
        vkCmdDraw(commands, 3, 1, 0, 0);
      }
      const std::size_t written = stereo_surface ? target_layer : static_cast<std::size_t>(eye);
      m.write_over(commands, target.format, written, place, slot, panels[written]);
    }
    vkCmdEndRendering(commands);
  }
  gpu::transition(commands, target.image, VK_IMAGE_ASPECT_COLOR_BIT, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                  target.final_layout, VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT,
                  VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                  VK_ACCESS_2_MEMORY_READ_BIT);
  return listed();
}

bool Compositor::text_changed(const Huds& huds, Layout layout) const {
  for (std::size_t e = 0; e < Impl::places(layout); ++e)
    if (impl_->writing[e]->differs(Impl::or_nothing(huds[e]), impl_->region_sizes[e])) return true;
  return false;
}

void Compositor::compose(int slot) {
  impl_->compose(slot);
}

}  // namespace typodont::display
