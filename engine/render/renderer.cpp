#include "engine/render/renderer.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <utility>

#include "engine/base/check.h"
#include "engine/base/units.h"
#include "engine/render/look.h"
#include "engine/render/mirror.h"
#include "engine/render/passes/passes.h"

namespace typodont::render {

namespace {

constexpr int kSlots = gpu::FrameRing::kSlots;
constexpr double kWorthWhile = 0.8;           // of the picture: drawn anew beyond it, all is
constexpr std::size_t kMostTracked = 20'000;  // particles whose places on the picture are looked at

/// IEC 61966-2-1
dvec3 linear_light(const dvec3& srgb) {
  dvec3 out;
  for (int i = 0; i < 3; ++i) out[i] = srgb[i] <= 0.04045 ? srgb[i] / 12.92 : std::pow((srgb[i] + 0.055) / 1.055, 2.4);
  return out;
}

template <class T>
std::vector<std::byte> bytes_of(const T* data, std::size_t count) {
  const auto* p = reinterpret_cast<const std::byte*>(data);
  return {p, p + count * sizeof(T)};
}

}  // namespace

struct Renderer::Impl {
  gpu::Device& device;
  glm::ivec2 size;
  std::array<Look, kTissueCount> looks;
  PassContext context;

  gpu::ShaderInputs inputs;  // sets: a slot's scene, and its scene in the mirror
  std::array<gpu::Buffer, 2 * kSlots> frame_data;
  VkSampler compare = VK_NULL_HANDLE, nearest = VK_NULL_HANDLE, linear = VK_NULL_HANDLE;
  VkQueryPool queries = VK_NULL_HANDLE;
  std::array<bool, kSlots> timed{};

  gpu::Image pictures, color, depth;
  gpu::Image scene, scene_depth;  // where layered(): the pictures without what lies over the scene, and how far it is
  ShadowPass shadow;
  SurfacePass surface;
  ToolPass tool;
  ToolBody tool_body;
  MirrorPass mirror;
  BackgroundPass background;
  ParticlePass particles;
  HudPass hud;
  HiddenPass hidden;
  MaskPass mask;
  BrickStore bricks;
  std::optional<SceneBounds> bounds;  // of this frame
  std::uint64_t bounds_version = 0;   // of the bricks they are of
  bool keeps_depth = false;
  std::vector<gpu::Image> kept_depth;  // one of two layers where one pass draws both eyes, else one an eye

  // What the last frame was made of: equal means nothing moved.
  int last_views = 0;
  shared::FrameData last_data{};
  Pose last_tool;
  double last_opacity = 1;
  bool last_tool_visible = false;
  MouthMirror last_mirror;
  std::vector<std::byte> last_particles;
  std::string last_hud;
  std::uint64_t last_version = 0, last_order = 0, settings_version = 1, last_settings = 0;
  std::uint64_t eyes_version = 0;  // rises when the eyes' pictures show the scene from elsewhere
  std::uint64_t shadow_version = 0, shadow_order = 0;
  // What the last frame drew anew, and what particles and writing cover of it.
  std::array<Tiles, 2> tiles, over_tiles, particle_tiles, hud_tiles;
  std::array<std::vector<PixelBox>, 2> redrawn;
  glm::mat4 shadow_light{0};
  glm::vec4 shadow_section{0};
  View shadow_view = View::kLook, last_view = View::kLook;
  std::uint64_t frames = 0, last_submitted = 0;
  double gpu_ms = 0;

  Impl(gpu::Device& d, glm::ivec2 s, const Quality& quality, const MaterialTable& m)
      : device(d), size(s), looks(looks_of(m)), context{.device = d} {
    context.quality = quality;
    create_layout();
    create_pictures(2);
    shadow.create_map(context);
  }

  ~Impl() {
    vkDeviceWaitIdle(device.device);
    destroy_pictures();
    destroy_passes();
    shadow.destroy(device);
    tool_body.destroy(device);
    mirror.destroy(device);
    hud.destroy(device);
    hidden.destroy(device);
    mask.destroy(device);
    bricks.destroy(device);
    for (gpu::Buffer& b : frame_data) b.destroy(device);
    for (VkSampler s : {compare, nearest, linear}) vkDestroySampler(device.device, s, nullptr);
    if (queries) vkDestroyQueryPool(device.device, queries, nullptr);
    inputs.destroy(device);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  void create_layout() {
    constexpr VkShaderStageFlags kBoth = VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT;
    std::vector<gpu::ShaderInputs::Binding> bindings(5, {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, kBoth});
    bindings[0].type = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
    inputs = gpu::ShaderInputs::create(device, std::move(bindings), 2 * kSlots, sizeof(shared::ObjectData));
    context.layout = inputs.layout;
    for (gpu::Buffer& b : frame_data)
      b = gpu::Buffer::create(device, sizeof(shared::FrameData), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT);
    // Beyond the shadow map nothing stands before the lamp; beyond the atlas there is no letter.
    constexpr VkSamplerAddressMode kBorder = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_BORDER;
    constexpr VkBorderColor kWhite = VK_BORDER_COLOR_FLOAT_OPAQUE_WHITE;
    compare = gpu::create_sampler(device, {.beyond = kBorder, .border = kWhite, .compare = true});
    nearest = gpu::create_sampler(device, {.filter = VK_FILTER_NEAREST, .beyond = kBorder, .border = kWhite});
    linear = gpu::create_sampler(device, {.beyond = kBorder});
    if (device.properties.limits.timestampComputeAndGraphics) {
      const VkQueryPoolCreateInfo info{.sType = VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO,
                                       .queryType = VK_QUERY_TYPE_TIMESTAMP,
                                       .queryCount = 2 * kSlots};
      gpu::check(vkCreateQueryPool(device.device, &info, nullptr, &queries), "vkCreateQueryPool");
    }
  }

  void create_pictures(int views) {
    const double scale = std::clamp(context.quality.scale, 0.1, 1.0);
    const VkExtent2D extent{static_cast<std::uint32_t>(std::max(1.0, std::round(size.x * scale))),
                            static_cast<std::uint32_t>(std::max(1.0, std::round(size.y * scale)))};
    const auto layers = static_cast<std::uint32_t>(views);
    context.samples = std::clamp(context.quality.samples, 1, std::min(device.max_samples, 4));
    if (context.samples == 2) context.samples = 1;  // 1 and 4 are what every device has
    context.view_mask = views == 2 && device.multiview ? 3 : 0;
    pictures = gpu::Image::create(device, {.size = extent,
                                           .layers = layers,
                                           .format = kColorFormat,
                                           .alias = kColorBytes,
                                           .usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_SAMPLED_BIT |
                                                    VK_IMAGE_USAGE_TRANSFER_SRC_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT});
    const std::uint32_t together = context.view_mask ? layers : 1;  // passes of their own share these
    if (context.samples > 1)
      color =
          gpu::Image::create(device, {.size = extent,
                                      .layers = together,
                                      .format = kColorFormat,
                                      .samples = context.samples,
                                      .usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT});
    depth = gpu::Image::create(device, {.size = extent,
                                        .layers = layered() ? layers : together,
                                        .format = kDepthFormat,
                                        .samples = context.samples,
                                        .usage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT |
                                                 (layered() ? VkImageUsageFlags{VK_IMAGE_USAGE_TRANSFER_SRC_BIT} : 0u),
                                        .aspect = VK_IMAGE_ASPECT_DEPTH_BIT});
    if (layered()) {
      scene = gpu::Image::create(device, {.size = extent,
                                          .layers = layers,
                                          .format = kColorFormat,
                                          .usage = VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT});
      scene_depth = gpu::Image::create(
          device, {.size = extent,
                   .layers = layers,
                   .format = kDepthFormat,
                   .usage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT,
                   .aspect = VK_IMAGE_ASPECT_DEPTH_BIT});
    }
    for (int i = 0; keeps_depth && i < (context.view_mask ? 1 : views); ++i)
      kept_depth.push_back(gpu::Image::create(
          device, {.size = extent,
                   .layers = together,
                   .format = kDepthFormat,
                   .usage = VK_IMAGE_USAGE_DEPTH_STENCIL_ATTACHMENT_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT,
                   .aspect = VK_IMAGE_ASPECT_DEPTH_BIT}));
    last_views = views;
    ++settings_version;
  }
  void destroy_pictures() {
    pictures.destroy(device);
    color.destroy(device);
    depth.destroy(device);
    scene.destroy(device);
    scene_depth.destroy(device);
    for (gpu::Image& image : kept_depth) image.destroy(device);
    kept_depth.clear();
    mirror.destroy_pictures(device);
  }
  /// The scene is kept apart from the chips that fly before it and the writing over it: they change nearly all of the
  /// picture in every frame, and restoring a pixel costs a copy, drawing it anew triangles and light. Where samples are
  /// averaged, or one pass draws both eyes, all goes into one picture.
  bool layered() const { return context.samples == 1 && !context.view_mask && !keeps_depth; }

  /// Their pipelines depend on samples, views and quality.
  void destroy_passes() {
    surface.destroy(device);
    tool.destroy(device);
    background.destroy(device);
    particles.destroy(device);
    destroy_pipeline(device, hud.pipeline);
    destroy_pipeline(device, hidden.pipeline);
    destroy_pipeline(device, mask.pipeline);
  }
  void rebuild(int views) {
    vkDeviceWaitIdle(device.device);
    destroy_pictures();
    destroy_passes();
    create_pictures(views);
  }

  void fill(shared::FrameData& data, const Frame& frame) const {
    for (int e = 0; e < 2; ++e) {
      const Eye& eye = frame.eyes[static_cast<std::size_t>(e < frame.views ? e : 0)];
      data.clip_from_world[e] = glm::mat4(eye.projection * eye.view);
      data.eye[e] = glm::vec4(glm::dvec4(eye.position, 1));
    }
    const dvec3 key = glm::normalize(frame.lights.key), up = glm::normalize(frame.lights.up);
    data.background = glm::vec4(frame.background == Background::kGradient ? 1.0f : 0.0f);
    data.background.w = frame.background == Background::kClear ? 0.0f : 1.0f;
    const VkExtent2D drawn = pictures.options.size;
    data.picture = glm::vec4(2.0f / static_cast<float>(drawn.width), 2.0f / static_cast<float>(drawn.height), 0, 0);
    data.clip = data.section = glm::vec4(0, 0, 0, 1);
    if (frame.view == View::kSection) data.section = glm::vec4(frame.section);
    data.key = glm::vec4(glm::dvec4(key, frame.lights.key_strength));
    const bool given = frame.lights.window != dvec3(0);
    const dvec3 window = glm::normalize(given ? frame.lights.window : glm::cross(up, key) + 0.55 * up);
    data.window = glm::vec4(glm::dvec4(window, 0));
    data.up = glm::vec4(glm::dvec4(up, frame.lights.ambient));
    for (std::size_t t = 0; t < looks.size(); ++t) {
      const Look& look = looks[t];
      data.tissue_color[t] = glm::vec4(glm::dvec4(linear_light(look.color), look.translucency));
      data.tissue_look[t] = glm::vec4(glm::dvec4(look.roughness, look.metal, look.wetness, 0));
    }

    // The lamp's parallel view: as wide as the working tooth's crown and what stands near it, as deep as everything.
    if (context.quality.shadow_map > 0 && bounds) {
      auto [lo, hi, all_lo, all_hi] = *bounds;
      // In steps, so that the map stays where it is while a tooth is cut down.
      constexpr double kStep = 2e-3;  // m
      for (glm::dvec3* low : {&lo, &all_lo}) *low = kStep * glm::floor(*low / kStep);
      for (glm::dvec3* high : {&hi, &all_hi}) *high = kStep * glm::ceil(*high / kStep);
      const glm::dvec3 middle = 0.5 * (lo + hi);
      const bool more = all_lo != lo || all_hi != hi;
      const double radius = 0.5 * glm::length(hi - lo) * (more ? 1.15 : 1.02) + 1e-6;
      double reach = radius;
      for (int corner = 0; corner < 8; ++corner)
        reach = std::max(reach, std::abs(glm::dot(key, dvec3(corner & 1 ? all_hi.x : all_lo.x, corner & 2 ? all_hi.y : all_lo.y,
                                                             corner & 4 ? all_hi.z : all_lo.z) - middle)));
      const glm::dvec3 side = std::abs(key.x) < 0.8 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
      const glm::dvec3 x = glm::normalize(glm::cross(side, key)), y = glm::cross(key, x);
      glm::dmat4 m(0.0);
      for (int i = 0; i < 3; ++i) {
        m[i][0] = x[i] / (2 * radius);
        m[i][1] = y[i] / (2 * radius);
        m[i][2] = -key[i] / (2 * reach);
      }
      m[3] = glm::dvec4(0.5 - glm::dot(x, middle) / (2 * radius), 0.5 - glm::dot(y, middle) / (2 * radius),
                        0.5 + glm::dot(key, middle) / (2 * reach), 1);
      data.light_from_world = glm::mat4(m);
      data.light_size = glm::vec4(glm::dvec4(2 * radius, 2 * reach, 2 * radius / context.quality.shadow_map, 1));
    }

    data.mirror = glm::vec4(glm::dvec4(0.5 * frame.mirror.diameter, frame.mirror.fog, 0, 0));
    if (frame.tool.visible && tool_body.index_count) {
      data.tool_head = glm::vec4(glm::dvec4(frame.tool.X_WG.p, tool_body.head_radius));
      data.tool_end = glm::vec4(glm::dvec4(frame.tool.X_WG * dvec3(0, 0, tool_body.shank_end), tool_body.shank_radius));
      // The eye gathers about 15 ms: from a turn of a tenth of a blade's pitch in that time to a whole one.
      constexpr double kExposure = 15e-3, kPitch = 2 * kPi / 8;
      const double pitches = std::abs(frame.tool.spindle) * kExposure / kPitch;
      const double blur = std::clamp((pitches - 0.1) / 0.9, 0.0, 1.0);
      data.tool_motion = glm::vec4(blur < 1 ? std::remainder(frame.tool.angle, 2 * kPi) : 0.0, blur, 0, 0);
    }
  }

  bool same_as_last(const shared::FrameData& data, const Frame& frame, const std::string& hud_key) const {
    const bool tool_same = frame.tool.visible == last_tool_visible &&
                           (!frame.tool.visible || (!std::memcmp(&frame.tool.X_WG, &last_tool, sizeof(Pose)) &&
                                                    frame.tool.opacity == last_opacity));
    const bool particles_same = last_particles.size() == frame.particles.size_bytes() &&
                                (frame.particles.empty() || !std::memcmp(last_particles.data(), frame.particles.data(),
                                                                         frame.particles.size_bytes()));
    if (frame.cloud && frame.cloud->changes()) return false;
    return last_settings == settings_version && last_view == frame.view && last_version == bricks.version && tool_same && particles_same &&
           same(frame.mirror.X_WM, last_mirror.X_WM) &&
           hud_key == last_hud && !std::memcmp(&data, &last_data, sizeof data);
  }

  /// `i`: a slot, or kSlots + a slot for its scene in the mirror.
  void write_set(std::size_t i) {
    // Without writing there is no atlas: the shadow map stands in, and no shader reads it there.
    const VkImageView map = shadow.map.layer_views[0];
    inputs.fill(device, i, 0, frame_data[i]);
    inputs.fill(device, i, 1, compare, map);
    inputs.fill(device, i, 2, nearest, map);
    inputs.fill(device, i, 3, linear, hud.atlas.image ? hud.atlas.layer_views[0] : map);
    inputs.fill(device, i, 4, linear, mirror.picture.image && i < kSlots ? mirror.picture.view : shadow.map.view);
  }

  void read_time(int slot) {
    const auto i = static_cast<std::size_t>(slot);
    if (!queries || !timed[i]) return;
    std::uint64_t t[2] = {};
    const VkResult result = vkGetQueryPoolResults(device.device, queries, static_cast<std::uint32_t>(2 * slot), 2,
                                                  sizeof t, t, sizeof t[0], VK_QUERY_RESULT_64_BIT);
    if (result == VK_SUCCESS)
      gpu_ms = static_cast<double>(t[1] - t[0]) * static_cast<double>(device.properties.limits.timestampPeriod) * 1e-6;
    timed[i] = false;
  }

  /// m: what a pixel covers of the working tooth, or of all there is, where that is nearest to an eye.
  double pixel_on_tooth(const Frame& frame) const {
    if (!bounds) return 0;
    constexpr double kNearest = 1e-3;  // m: an eye within the box looks at least that far
    double least = 1e9;
    for (int e = 0; e < frame.views; ++e) {
      const Eye& eye = frame.eyes[static_cast<std::size_t>(e)];
      const glm::dmat4 clip = eye.projection * eye.view;
      double closest = 1e9;
      for (int corner = 0; corner < 8; ++corner)
        closest = std::min(closest, (clip * glm::dvec4(corner & 1 ? bounds->hi.x : bounds->lo.x,
                                                   corner & 2 ? bounds->hi.y : bounds->lo.y,
                                                   corner & 4 ? bounds->hi.z : bounds->lo.z, 1)).w);
      const double wide = 2 * std::max(closest, kNearest) / std::abs(eye.projection[0][0]);  // m, of the picture there
      least = std::min(least, wide / pictures.options.size.width);
    }
    return least;
  }

  FrameStats record(VkCommandBuffer commands, const Frame& frame, int slot, std::uint64_t submitted,
                    std::uint64_t finished) {
    TYPODONT_CHECK(frame.views == 1 || frame.views == 2);
    bricks.collect(finished);
    read_time(slot);
    if (frame.views != last_views) rebuild(frame.views);

    FrameStats stats;
    if (std::exchange(bounds_version, bricks.version) != bricks.version) bounds = bricks.bounds();
    stats.pixel = pixel_on_tooth(frame);
    shared::FrameData data{};
    fill(data, frame);
    const std::string hud_key = HudPass::shown(frame.hud, size);
    stats.views = frame.views;
    stats.bricks_uploaded = bricks.uploaded;
    stats.bytes_uploaded = bricks.uploaded_bytes;
    bricks.uploaded = 0;
    bricks.uploaded_bytes = 0;
    stats.drawn = !same_as_last(data, frame, hud_key);
    if (stats.drawn) {
      draw(commands, frame, data, slot, stats);
      last_data = data;
      last_tool = frame.tool.X_WG;
      last_opacity = frame.tool.opacity;
      last_tool_visible = frame.tool.visible;
      last_mirror = frame.mirror;
      last_view = frame.view;
      last_particles = bytes_of(frame.particles.data(), frame.particles.size());
      last_hud = hud_key;
      last_version = bricks.version;
      last_order = bricks.order;
      last_settings = settings_version;
      bricks.changed.clear();
    }
    if (stats.drawn) {
      last_submitted = submitted;
      ++frames;
    }
    stats.frames = frames;
    stats.gpu_ms = gpu_ms;
    for (VkPipeline p :
         {shadow.pipeline, tool.pipeline, background.pipeline, particles.pipeline, particles.cloud_pipeline, hud.pipeline,
          mirror.pipeline, hidden.pipeline, mask.pipeline})
      if (p) ++stats.pipelines;
    stats.pipelines += surface.pipelines() + (frame.cloud ? frame.cloud->pipelines() : 0);
    return stats;
  }

  /// The scene as the mouth mirror shows it: other eyes, only what stands before the glass, no writing.
  Frame in_mirror(const Frame& frame) const {
    Frame out = frame;
    for (Eye& eye : out.eyes) eye = reflected(eye, frame.mirror.X_WM);
    out.hud.visible = false;
    out.mirror.diameter = 0;
    return out;
  }

  /// Marks in `tiles` what this frame changes of the last, in `over_tiles` what particles and writing do; false where
  /// that may be everything.
  bool mark_changed(const shared::FrameData& data, const Frame& frame, int slot, const glm::ivec2& drawn) {
    std::array<Tiles, 2> particles_now, hud_now;
    const auto views = static_cast<std::size_t>(frame.views);
    for (std::size_t e = 0; e < views; ++e) {
      for (Tiles* t : {&tiles[e], &over_tiles[e], &particles_now[e], &hud_now[e]}) t->clear(drawn);
      hud.mark(slot, drawn, hud_now[e]);
      const glm::dmat4 clip_from_world = frame.eyes[e].projection * frame.eyes[e].view;
      // So many that all is full of them.
      if (frame.particles.size() > kMostTracked)
        particles_now[e].mark_all();
      else
        ParticlePass::mark(frame.particles, clip_from_world, drawn, particles_now[e]);
    }
    std::swap(particles_now, particle_tiles);
    std::swap(hud_now, hud_tiles);

    shared::FrameData now = data, before = last_data;
    for (shared::FrameData* d : {&now, &before}) d->tool_head = d->tool_end = d->tool_motion = glm::vec4(0);
    const bool eyes_stay = !std::memcmp(now.clip_from_world, before.clip_from_world, sizeof now.clip_from_world);
    if (!eyes_stay || last_settings != settings_version) ++eyes_version;
    // A pass that draws both eyes resolves all it draws; a headset's eyes never rest; glass is drawn in an order.
    // Where particles of the GPU are, nobody here knows.
    if (context.view_mask || keeps_depth || (frame.cloud && frame.cloud->changes()) || frame.view == View::kXray || last_view != frame.view ||
        last_settings != settings_version || last_order != bricks.order || std::memcmp(&now, &before, sizeof now) ||
        !same(frame.mirror.X_WM, last_mirror.X_WM))
      return false;

    bricks.mark_changed(frame, data, last_data, drawn, eyes_version, tiles);
    const bool hud_changed = HudPass::shown(frame.hud, this->size) != last_hud;
    const bool particles_changed = last_particles != bytes_of(frame.particles.data(), frame.particles.size());
    for (std::size_t e = 0; e < views; ++e) {
      const glm::dmat4 clip_from_world = frame.eyes[e].projection * frame.eyes[e].view;
      const auto tool_at = [&](const Pose& X_WG) {
        glm::dmat4 world_from_tool(glm::mat3_cast(X_WG.R));
        world_from_tool[3] = glm::dvec4(X_WG.p, 1);
        for (const ToolBody::Slice& s : tool_body.slices)
          tiles[e].mark(seen_in(clip_from_world * world_from_tool, {-s.radius, -s.radius, s.low},
                                {s.radius, s.radius, s.high}, drawn));
      };
      if (frame.tool.visible) tool_at(frame.tool.X_WG);
      if (last_tool_visible) tool_at(last_tool);
      if (particles_changed) {
        over_tiles[e].mark(particles_now[e]);
        over_tiles[e].mark(particle_tiles[e]);
      }
      if (hud_changed) {
        over_tiles[e].mark(hud_now[e]);
        over_tiles[e].mark(hud_tiles[e]);
      }
      if (!layered()) tiles[e].mark(over_tiles[e]);
      // What the glass shows may be anywhere.
      if (const auto glass = glass_in(frame.eyes[e], frame.mirror, drawn)) tiles[e].mark(*glass);
    }
    double share = 0;
    for (std::size_t e = 0; e < views; ++e) share += tiles[e].share() / static_cast<double>(views);
    return share < kWorthWhile;
  }

  void draw(VkCommandBuffer commands, const Frame& frame, const shared::FrameData& data, int slot, FrameStats& stats) {
    hud.prepare(context, slot, frame.hud, size);
    particles.prepare(context, slot, frame.particles);
    const auto views = static_cast<std::size_t>(frame.views);

    // Which eyes see the glass, and where.
    const VkExtent2D extent = pictures.options.size;
    const glm::ivec2 drawn_size(extent.width, extent.height);
    const bool partly = mark_changed(data, frame, slot, drawn_size);
    std::array<std::vector<PixelBox>, 2> scene_boxes;
    if (partly) {
      stats.redrawn = 0;
      std::array<std::vector<PixelBox>, 2> kept;
      for (std::size_t e = 0; e < views; ++e) {
        scene_boxes[e] = tiles[e].boxes(true, tiles[e].picture());
        kept[e] = tiles[e].boxes(false, tiles[e].bounds());
        // What lies over the scene is blended: chips or writing go over a restored scene, all of them or none.
        Tiles shown = tiles[e];
        shown.mark(over_tiles[e]);
        for (const Tiles* over : {&particle_tiles[e], &hud_tiles[e], &particle_tiles[e]})
          if (layered() && shown.touch(*over)) shown.mark(*over);
        redrawn[e] = shown.boxes(true, shown.picture());
        stats.redrawn += shown.share() / frame.views;
      }
      // What moved is seen by neither eye.
      if (stats.redrawn <= 0 && last_version == bricks.version) {
        stats.drawn = false;
        return;
      }
      mask.prepare(context, slot, drawn_size, kept);
    } else {
      scene_boxes.fill({{0, 0, drawn_size.x, drawn_size.y}});
      redrawn = scene_boxes;
    }
    std::array<std::optional<PixelBox>, 2> glass;
    for (int e = 0; e < frame.views; ++e) glass[e] = glass_in(frame.eyes[e], frame.mirror, drawn_size);
    const bool reflects = glass[0] || glass[1];
    if (frame.mirror.diameter > 0) mirror.prepare(device, frame.mirror.diameter);
    const Frame mirrored = reflects ? in_mirror(frame) : Frame{};
    const auto own = static_cast<std::size_t>(slot), other = static_cast<std::size_t>(kSlots + slot);
    if (reflects) {
      mirror.create_picture(context, extent, pictures.options.layers);
      shared::FrameData reflected_data{};
      fill(reflected_data, mirrored);
      reflected_data.clip = glm::vec4(before_glass(frame.mirror.X_WM));
      std::memcpy(frame_data[other].memory.mapped, &reflected_data, sizeof reflected_data);
      write_set(other);
    }
    std::memcpy(frame_data[own].memory.mapped, &data, sizeof data);
    write_set(own);
    const auto first_query = static_cast<std::uint32_t>(2 * slot);
    if (queries) {
      vkCmdResetQueryPool(commands, queries, first_query, 2);
      vkCmdWriteTimestamp2(commands, VK_PIPELINE_STAGE_2_TOP_OF_PIPE_BIT, queries, first_query);
    }

    // Shadow map: only when what casts shadows or the lamp changed, and only where.
    const bool other_light = shadow_light != data.light_from_world || shadow_view != frame.view ||
                             shadow_section != data.section || shadow_order != bricks.order;
    if (data.light_size.w > 0 && (other_light || shadow_version != bricks.version)) {
      LampBox part;
      for (const BoxInWorld& box : bricks.changed)
        part.take(in_lamp(glm::dmat4(data.light_from_world), glm::vec3(box.lo), glm::vec3(box.hi)));
      if (other_light) part = {glm::vec2(0), glm::vec2(1)};
      shadow.record(context, commands, inputs.sets[own], bricks, slot, frame.view, data.light_from_world, part, stats);
      shadow_view = frame.view;
      shadow_section = data.section;
      shadow_version = bricks.version;
      shadow_order = bricks.order;
      shadow_light = data.light_from_world;
    }

    if (frame.cloud) frame.cloud->record(commands, slot);

    if (reflects) {
      FrameStats seen;  // in the mirror
      const std::vector<DrawGroup> groups = bricks.visible(device, slot, mirrored, bricks.mirror_indirect, seen);
      begin_pictures(commands, mirror.picture, false);
      for (int view = 0; view < (context.view_mask ? 1 : frame.views); ++view) {
        const PixelBox all{0, 0, drawn_size.x, drawn_size.y};
        const PixelBox box = context.view_mask ? all : glass[static_cast<std::size_t>(view)].value_or(PixelBox{});
        if (box.width == 0) continue;
        begin_scene(commands, mirror.picture, mirrored, view, box, false, {0.030f, 0.033f, 0.038f});
        vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, context.layout, 0, 1, &inputs.sets[other], 0,
                                nullptr);
        push_view(commands, context.layout, view);
        surface.record(context, commands, bricks, slot, bricks.mirror_indirect, groups, frame.view, false, seen);
        if (frame.tool.visible) tool.record(context, commands, tool_body, frame.tool.X_WG, seen);
        surface.record(context, commands, bricks, slot, bricks.mirror_indirect, groups, frame.view, true, seen);
        particles.record(context, commands, slot, frame.cloud, seen);
        end_scene(commands, mirror.picture, view, {&all, 1});
        ++stats.mirror_passes;
      }
      end_pictures(commands, mirror.picture);
      stats.passes += stats.mirror_passes;
      stats.commands += seen.commands;
      stats.mirror_bricks = seen.bricks_drawn;
      stats.mirror_triangles = seen.triangles;
    }

    const std::vector<DrawGroup> groups =
        bricks.visible(device, slot, frame, bricks.indirect, stats, partly ? &tiles : nullptr);
    gpu::Image& target = layered() ? scene : pictures;
    begin_pictures(commands, target, partly);
    if (layered()) begin_depth(commands, partly);
    const int scene_passes = context.view_mask ? 1 : frame.views;
    for (int view = 0; view < scene_passes; ++view) {
      const auto e = static_cast<std::size_t>(view);
      const PixelBox all{0, 0, drawn_size.x, drawn_size.y}, box = partly ? tiles[e].bounds() : all;
      if (box.width == 0) continue;
      begin_scene(commands, target, frame, view, box, partly, {0, 0, 0});
      vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, context.layout, 0, 1, &inputs.sets[own], 0, nullptr);
      push_view(commands, context.layout, view);
      if (partly) mask.record(context, commands, slot, view, stats);
      hidden.record(context, commands, stats);
      surface.record(context, commands, bricks, slot, bricks.indirect, groups, frame.view, false, stats);
      if (frame.tool.visible) {
        push_view(commands, context.layout, view, 1 - frame.tool.opacity);
        tool.record(context, commands, tool_body, frame.tool.X_WG, stats);
        push_view(commands, context.layout, view);
      }
      if (frame.mirror.diameter > 0) {
        tool.record(context, commands, mirror.body, frame.mirror.X_WM, stats);
        if (reflects) mirror.record_glass(context, commands, frame.mirror, stats);
      }
      // Over what was there, black is drawn like any other background.
      if (frame.background == Background::kGradient || partly) background.record(context, commands, stats);
      surface.record(context, commands, bricks, slot, bricks.indirect, groups, frame.view, true, stats);
      if (!layered()) {
        particles.record(context, commands, slot, frame.cloud, stats);
        hud.record(context, commands, slot, stats);
      }
      end_scene(commands, target, view, redrawn[e]);
      ++stats.passes;
    }
    if (layered())
      lay_over(commands, frame, slot, partly, scene_boxes, stats);
    else
      end_pictures(commands, pictures);
    if (queries) {
      vkCmdWriteTimestamp2(commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, queries, first_query + 1);
      timed[own] = true;
    }
  }

  static constexpr VkPipelineStageFlags2 kOutput = VK_PIPELINE_STAGE_2_COLOR_ATTACHMENT_OUTPUT_BIT;
  static constexpr VkPipelineStageFlags2 kResolve = VK_PIPELINE_STAGE_2_RESOLVE_BIT;
  static constexpr VkPipelineStageFlags2 kTests =
      VK_PIPELINE_STAGE_2_EARLY_FRAGMENT_TESTS_BIT | VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT;
  static constexpr VkAccessFlags2 kDepthUse =
      VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT | VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT;

  /// Samples are averaged at the end of the pass where one pass draws both eyes, by a command of its own where each eye
  /// has its pass: lavapipe 22.3 averages into the first layer whatever layer the pass names, and says nothing.
  bool resolves_in_pass() const { return context.samples > 1 && context.view_mask != 0; }
  bool resolves_by_command() const { return context.samples > 1 && context.view_mask == 0; }

  void begin_pictures(VkCommandBuffer commands, const gpu::Image& target, bool partly) {
    const bool by_command = resolves_by_command();
    const VkImageLayout between =
        &target == &scene ? VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL : VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
    gpu::transition(commands, target, partly ? between : VK_IMAGE_LAYOUT_UNDEFINED,
                    by_command ? VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL : VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                    VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_ACCESS_2_NONE, by_command ? kResolve : kOutput,
                    by_command ? VkAccessFlags2{VK_ACCESS_2_TRANSFER_WRITE_BIT}
                               : VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT);
  }

  /// Opens the pass of one eye, or of both where the device draws them in one. `partly`: over what the picture holds.
  void begin_scene(VkCommandBuffer commands, const gpu::Image& target, const Frame& frame, int view,
                   const PixelBox& box, bool partly, const glm::vec3& clear) {
    if (context.samples > 1)
      gpu::transition(commands, color, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                      kOutput | kResolve, VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_2_TRANSFER_READ_BIT,
                      kOutput, VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT);
    const bool layer = &target == &scene;
    if (!layer)
      gpu::transition(commands, depth, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL, kTests,
                      VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT, kTests,
                      VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT | VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT);
    const gpu::Image* kept = keeps_depth && &target == &pictures ? &kept_depth[context.view_mask ? 0 : static_cast<std::size_t>(view)] : nullptr;
    if (kept)
      gpu::transition(commands, *kept, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL,
                      VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_ACCESS_2_NONE, kTests | kOutput,
                      VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT |
                          VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_READ_BIT);
    const bool kept_direct = kept && context.samples == 1, kept_resolved = kept && context.samples > 1;
    const VkExtent2D extent = target.options.size;
    const VkImageView eye_view =
        context.view_mask ? target.view : target.layer_views[static_cast<std::size_t>(view)];
    const bool in_pass = resolves_in_pass();
    const VkRenderingAttachmentInfo color_info{
        .sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
        .imageView = context.samples > 1 ? color.view : eye_view,
        .imageLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
        .resolveMode = in_pass ? VK_RESOLVE_MODE_AVERAGE_BIT : VK_RESOLVE_MODE_NONE,
        .resolveImageView = in_pass ? eye_view : VK_NULL_HANDLE,
        .resolveImageLayout = in_pass ? VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL : VK_IMAGE_LAYOUT_UNDEFINED,
        .loadOp = !partly               ? VK_ATTACHMENT_LOAD_OP_CLEAR
                  : context.samples > 1 ? VK_ATTACHMENT_LOAD_OP_DONT_CARE
                                        : VK_ATTACHMENT_LOAD_OP_LOAD,
        .storeOp = in_pass ? VK_ATTACHMENT_STORE_OP_DONT_CARE : VK_ATTACHMENT_STORE_OP_STORE,
        .clearValue = {.color = {{clear.r, clear.g, clear.b, frame.background == Background::kClear ? 0.0f : 1.0f}}}};
    const VkRenderingAttachmentInfo depth_info{
        .sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
        .imageView = kept_direct ? kept->view : layered() ? (layer && !partly ? scene_depth : depth).layer_views[static_cast<std::size_t>(view)] : depth.view,
        .imageLayout = VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL,
        .resolveMode = kept_resolved ? VK_RESOLVE_MODE_SAMPLE_ZERO_BIT : VK_RESOLVE_MODE_NONE,
        .resolveImageView = kept_resolved ? kept->view : VK_NULL_HANDLE,
        .resolveImageLayout = kept_resolved ? VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL : VK_IMAGE_LAYOUT_UNDEFINED,
        .loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR,
        .storeOp = kept_direct || layer ? VK_ATTACHMENT_STORE_OP_STORE : VK_ATTACHMENT_STORE_OP_DONT_CARE,
        .clearValue = {.depthStencil = {1.0f, 0}}};
    begin_pass(commands, frame, color_info, depth_info, context.view_mask, extent,
               {{box.x, box.y}, {static_cast<std::uint32_t>(box.width), static_cast<std::uint32_t>(box.height)}});
  }

  /// `drawn`: what of the picture was, where its samples are yet to be averaged.
  void end_scene(VkCommandBuffer commands, const gpu::Image& target, int view, std::span<const PixelBox> drawn) {
    vkCmdEndRendering(commands);
    if (!resolves_by_command()) return;
    gpu::transition(commands, color, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                    kOutput, VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT, kResolve, VK_ACCESS_2_TRANSFER_READ_BIT);
    std::vector<VkImageResolve> parts;
    for (const PixelBox& b : drawn)
      parts.push_back({.srcSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
                       .srcOffset = {b.x, b.y, 0},
                       .dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, static_cast<std::uint32_t>(view), 1},
                       .dstOffset = {b.x, b.y, 0},
                       .extent = {static_cast<std::uint32_t>(b.width), static_cast<std::uint32_t>(b.height), 1}});
    vkCmdResolveImage(commands, color.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, target.image,
                      VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, static_cast<std::uint32_t>(parts.size()), parts.data());
  }

  /// Where layered: all anew is drawn into the depth that stays, parts into another one, whose rest is masked.
  void begin_depth(VkCommandBuffer commands, bool partly) {
    gpu::transition(commands, partly ? depth : scene_depth, VK_IMAGE_LAYOUT_UNDEFINED,
                    VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_ACCESS_2_NONE,
                    kTests, kDepthUse);
  }

  /// The scene's new parts into the pictures, and over them what flies before it and the writing.
  void lay_over(VkCommandBuffer commands, const Frame& frame, int slot, bool partly,
                const std::array<std::vector<PixelBox>, 2>& scene_boxes, FrameStats& stats) {
    constexpr VkPipelineStageFlags2 kCopy = VK_PIPELINE_STAGE_2_COPY_BIT;
    const auto copy = [&](const gpu::Image& from, const gpu::Image& to, const std::array<std::vector<PixelBox>, 2>& boxes) {
      std::vector<VkImageCopy> parts;
      for (std::uint32_t e = 0; e < static_cast<std::uint32_t>(frame.views); ++e)
        for (const PixelBox& b : boxes[e])
          parts.push_back({.srcSubresource = {from.options.aspect, 0, e, 1},
                           .srcOffset = {b.x, b.y, 0},
                           .dstSubresource = {to.options.aspect, 0, e, 1},
                           .dstOffset = {b.x, b.y, 0},
                           .extent = {static_cast<std::uint32_t>(b.width), static_cast<std::uint32_t>(b.height), 1}});
      if (parts.empty()) return;
      vkCmdCopyImage(commands, from.image, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, to.image,
                     VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, static_cast<std::uint32_t>(parts.size()), parts.data());
    };
    if (partly) {
      gpu::transition(commands, depth, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                      kTests, kDepthUse, kCopy, VK_ACCESS_2_TRANSFER_READ_BIT);
      gpu::transition(commands, scene_depth, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                      kTests, kDepthUse, kCopy, VK_ACCESS_2_TRANSFER_WRITE_BIT);
      copy(depth, scene_depth, scene_boxes);
      gpu::transition(commands, scene_depth, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL,
                      kCopy, VK_ACCESS_2_TRANSFER_WRITE_BIT, kTests, kDepthUse);
    }
    gpu::transition(commands, scene, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                    kOutput, VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT, kCopy, VK_ACCESS_2_TRANSFER_READ_BIT);
    gpu::transition(commands, pictures, partly ? VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL : VK_IMAGE_LAYOUT_UNDEFINED,
                    VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, VK_ACCESS_2_NONE, kCopy,
                    VK_ACCESS_2_TRANSFER_WRITE_BIT);
    copy(scene, pictures, redrawn);
    gpu::transition(commands, pictures, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                    kCopy, VK_ACCESS_2_TRANSFER_WRITE_BIT, kOutput,
                    VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_READ_BIT);
    const VkExtent2D extent = pictures.options.size;
    for (int view = 0; view < frame.views; ++view) {
      const auto e = static_cast<std::size_t>(view);
      Tiles over;
      over.clear({extent.width, extent.height});
      for (const PixelBox& b : redrawn[e]) over.mark(b);
      const bool chips = frame.cloud || over.touch(particle_tiles[e]), writing = over.touch(hud_tiles[e]);
      if (!chips && !writing) continue;
      begin_over(commands, frame, view, extent);
      vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, context.layout, 0, 1,
                              &inputs.sets[static_cast<std::size_t>(slot)], 0, nullptr);
      push_view(commands, context.layout, view);
      if (chips) particles.record(context, commands, slot, frame.cloud, stats);
      if (writing) hud.record(context, commands, slot, stats);
      vkCmdEndRendering(commands);
      ++stats.passes;
    }
    gpu::transition(commands, pictures, VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
                    kOutput, VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                    VK_ACCESS_2_SHADER_SAMPLED_READ_BIT | VK_ACCESS_2_TRANSFER_READ_BIT);
  }

  /// Opens the pass of what lies over an eye's scene.
  void begin_over(VkCommandBuffer commands, const Frame& frame, int view, const VkExtent2D& extent) {
    const auto e = static_cast<std::size_t>(view);
    const VkRenderingAttachmentInfo color_info{.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                               .imageView = pictures.layer_views[e],
                                               .imageLayout = VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                                               .loadOp = VK_ATTACHMENT_LOAD_OP_LOAD,
                                               .storeOp = VK_ATTACHMENT_STORE_OP_STORE};
    const VkRenderingAttachmentInfo depth_info{.sType = VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO,
                                               .imageView = scene_depth.layer_views[e],
                                               .imageLayout = VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL,
                                               .loadOp = VK_ATTACHMENT_LOAD_OP_LOAD,
                                               .storeOp = VK_ATTACHMENT_STORE_OP_STORE};
    begin_pass(commands, frame, color_info, depth_info, 0, extent, {{0, 0}, extent});
  }

  /// With all that is dynamic set, for a picture of that extent, of which `area` is drawn.
  static void begin_pass(VkCommandBuffer commands, const Frame& frame, const VkRenderingAttachmentInfo& color_info,
                         const VkRenderingAttachmentInfo& depth_info, std::uint32_t view_mask, const VkExtent2D& extent,
                         const VkRect2D& area) {
    const VkRenderingInfo rendering{.sType = VK_STRUCTURE_TYPE_RENDERING_INFO,
                                    .renderArea = area,
                                    .layerCount = 1,
                                    .viewMask = view_mask,
                                    .colorAttachmentCount = 1,
                                    .pColorAttachments = &color_info,
                                    .pDepthAttachment = &depth_info};
    vkCmdBeginRendering(commands, &rendering);
    const VkViewport viewport{0, 0, static_cast<float>(extent.width), static_cast<float>(extent.height), 0, 1};
    vkCmdSetViewport(commands, 0, 1, &viewport);
    vkCmdSetScissor(commands, 0, 1, &area);
    // A mirrored view turns every triangle's winding round, once.
    vkCmdSetFrontFace(commands, frame.eyes[0].flip ? VK_FRONT_FACE_CLOCKWISE : VK_FRONT_FACE_COUNTER_CLOCKWISE);
  }

  void end_pictures(VkCommandBuffer commands, const gpu::Image& target) {
    const bool by_command = resolves_by_command();
    gpu::transition(commands, target,
                    by_command ? VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL : VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL,
                    VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL, by_command ? kResolve : kOutput,
                    by_command ? VK_ACCESS_2_TRANSFER_WRITE_BIT : VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT,
                    VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT,
                    VK_ACCESS_2_SHADER_SAMPLED_READ_BIT | VK_ACCESS_2_TRANSFER_READ_BIT);
    if (&target != &pictures) return;
    for (const gpu::Image& image : kept_depth)
      gpu::transition(commands, image, VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL, VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL,
                      kOutput | VK_PIPELINE_STAGE_2_LATE_FRAGMENT_TESTS_BIT,
                      VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT | VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT,
                      VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_READ_BIT);
  }
};

Renderer::Renderer(gpu::Device& device, glm::ivec2 size, const Quality& quality, const MaterialTable& materials)
    : impl_(std::make_unique<Impl>(device, size, quality, materials)) {}
Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;

void Renderer::update(MeshId mesh, std::span<const MeshUpdate> bricks) {
  impl_->bricks.update(impl_->device, mesh, bricks, impl_->last_submitted);
}

void Renderer::place(MeshId mesh, const Pose& X_WM) {
  Pose& now = impl_->bricks.meshes[mesh].X_WM;
  if (now.p == X_WM.p && now.R == X_WM.R) return;
  now = X_WM;
  ++impl_->bricks.version;
  ++impl_->bricks.order;
}

void Renderer::remove(MeshId mesh) {
  impl_->bricks.remove(mesh, impl_->last_submitted);
}

void Renderer::cover(MeshId mesh, const glm::dvec4& beyond) {
  impl_->bricks.covers[mesh] = beyond;
  ++impl_->bricks.version;
  ++impl_->bricks.order;
}

void Renderer::set_tool(const ToolMesh& tool) {
  vkDeviceWaitIdle(impl_->device.device);
  impl_->tool_body.set(impl_->device, tool);
  ++impl_->settings_version;
}

void Renderer::resize(glm::ivec2 size) {
  if (size == impl_->size) return;
  impl_->size = size;
  impl_->rebuild(impl_->last_views);
}

void Renderer::set_quality(const Quality& quality) {
  vkDeviceWaitIdle(impl_->device.device);
  impl_->context.quality = quality;
  impl_->shadow.destroy(impl_->device);
  impl_->shadow.create_map(impl_->context);
  impl_->shadow_version = 0;
  impl_->rebuild(impl_->last_views);
}

void Renderer::set_hidden(std::span<const glm::vec3> corners) {
  vkDeviceWaitIdle(impl_->device.device);
  impl_->hidden.set(impl_->device, corners);
  ++impl_->settings_version;
}

void Renderer::keep_depth(bool keep) {
  if (keep == impl_->keeps_depth) return;
  vkDeviceWaitIdle(impl_->device.device);
  impl_->destroy_pictures();
  impl_->keeps_depth = keep;
  impl_->create_pictures(impl_->last_views);
}

Renderer::DepthPicture Renderer::depth(int view) const {
  if (impl_->kept_depth.empty()) return {};
  const bool together = impl_->kept_depth.size() == 1;
  return {&impl_->kept_depth[together ? 0 : static_cast<std::size_t>(view)],
          together ? static_cast<std::uint32_t>(view) : 0};
}

FrameStats Renderer::record(VkCommandBuffer commands, const Frame& frame, int slot, std::uint64_t submitted,
                            std::uint64_t finished) {
  return impl_->record(commands, frame, slot, submitted, finished);
}

std::span<const PixelBox> Renderer::redrawn(int view) const {
  return impl_->redrawn[static_cast<std::size_t>(view)];
}

const gpu::Image& Renderer::pictures() const {
  return impl_->pictures;
}

}  // namespace typodont::render
