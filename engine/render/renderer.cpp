#include "engine/render/renderer.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/gtc/packing.hpp>
#include <optional>
#include <span>
#include <utility>

#include "engine/base/check.h"
#include "engine/base/units.h"
#include "engine/render/look.h"
#include "engine/render/mirror.h"
#include "engine/render/passes/frame_data.h"
#include "engine/render/passes/frame_timer.h"
#include "engine/render/passes/passes.h"
#include "engine/render/passes/targets.h"
#include "engine/render/passes/texel_store.h"
#include "engine/render/sight.h"

namespace typodont::render {

namespace {

constexpr int kSlots = gpu::FrameRing::kSlots;
constexpr VkFormat kFilmFormat = VK_FORMAT_R8G8B8A8_UNORM, kLightFormat = VK_FORMAT_R16G16B16A16_SFLOAT,
                   kTemperatureFormat = VK_FORMAT_R16G16_SFLOAT;
constexpr std::size_t kMaxTracked = 20'000;  // largest number of particles that are tracked one by one

}  // namespace

struct Renderer::Impl {
  gpu::Device& device;
  glm::ivec2 size;
  std::array<Look, kMatterCount> looks;
  PassContext context;

  gpu::ShaderInputs inputs;  // for each frame in flight: inputs of the scene and of its mirror image
  std::array<gpu::Buffer, 2 * kSlots> frame_data;
  VkSampler compare = VK_NULL_HANDLE, nearest = VK_NULL_HANDLE, linear = VK_NULL_HANDLE, beyond_grid = VK_NULL_HANDLE;
  FrameTimer timer;

  Targets targets;
  ShadowPass shadow;
  SurfacePass surface;
  ToolPass tool;
  ToolBody tool_body, tip_body;
  Handpiece handpiece;
  HandpieceBody handpiece_body;
  SuctionTip tip_made;  // the suction tip for which `tip_body` was created
  MirrorPass mirror;
  BackgroundPass background;
  ParticlePass particles;
  HiddenPass hidden;
  MaskPass mask;
  BrickStore bricks;
  TexelStore<FilmTexel> film;
  VolumeImage light;                       // LightGrid::faces; without a grid one empty texel
  LightGrid light_grid;                    // its member `faces` is empty: only `light` stores these data
  VolumeImage images;                      // LightGrid::images; without a grid one empty texel
  TexelStore<std::uint64_t> tissue_light;  // TissueLightGrid::values, each packed into four half floats
  TexelStore<std::uint32_t> temperatures;  // two half floats in a texel
  std::optional<SceneBounds> bounds;       // bounds of this frame's scene
  std::uint64_t bounds_version = 0;        // version of the bricks from which `bounds` was computed

  // State of the last frame. If the new frame's state is equal, nothing has moved.
  int last_views = 0;
  shared::FrameData last_data{};
  glm::vec4 frame_lamp{0};  // FrameData::lamp of the current frame
  ToolState last_tool;
  MouthMirror last_mirror;
  SuctionTip last_tip;
  std::vector<std::byte> last_particles;
  std::uint64_t last_version = 0, last_order = 0, settings_version = 1, last_settings = 0;
  std::uint64_t eyes_version = 0;  // increases when the eyes move
  std::uint64_t shadow_version = 0, shadow_order = 0;
  ShadowMapBox undrawn_shadow;  // part of the shadow map that has changed, but is not yet drawn again
  // Tiles to redraw; tiles that only particles changed; tiles that particles cover.
  std::array<Tiles, 2> tiles, over_tiles, particle_tiles;
  EyeBoxes redrawn;
  glm::mat4 shadow_light{0};
  glm::vec4 shadow_section{0};
  View shadow_view = View::kLook, last_view = View::kLook;
  std::uint64_t frames = 0, last_submitted = 0;

  Impl(gpu::Device& d, glm::ivec2 s, const Quality& quality, const MaterialTable& m)
      : device(d), size(s), looks(appearances_of(m)), context{.device = d}, targets(context) {
    context.quality = quality;
    create_layout();
    create_pictures(2);
    shadow.create_map(context);
    film.set(device, FilmGrid{}, kFilmFormat);
    temperatures.set(device, TemperatureGrid{}, kTemperatureFormat);
    set_light({}, {});
  }

  ~Impl() {
    gpu::stop_preparing(device);
    vkDeviceWaitIdle(device.device);
    destroy_pictures();
    particles.destroy(device);
    shadow.destroy(device);
    tool_body.mesh.destroy(device);
    handpiece_body.mesh.destroy(device);
    tip_body.mesh.destroy(device);
    mirror.destroy(device);
    hidden.destroy(device);
    mask.destroy(device);
    bricks.destroy(device);
    film.destroy(device);
    light.destroy(device);
    images.destroy(device);
    tissue_light.destroy(device);
    temperatures.destroy(device);
    for (gpu::Buffer& b : frame_data) b.destroy(device);
    for (VkSampler s : {compare, nearest, linear, beyond_grid}) vkDestroySampler(device.device, s, nullptr);
    timer.destroy(device);
    inputs.destroy(device);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  void create_layout() {
    constexpr VkShaderStageFlags kBoth = VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT;
    std::vector<gpu::ShaderInputs::Binding> bindings(9, {VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, kBoth});
    bindings[0].type = VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
    inputs = gpu::ShaderInputs::create(device, std::move(bindings), 2 * kSlots, sizeof(shared::ObjectData));
    context.layout = inputs.layout;
    for (gpu::Buffer& b : frame_data)
      b = gpu::Buffer::create(device, sizeof(shared::FrameData), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT);
    // Points outside the shadow map are in no shadow.
    constexpr VkSamplerAddressMode kBorder = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_BORDER;
    constexpr VkBorderColor kWhite = VK_BORDER_COLOR_FLOAT_OPAQUE_WHITE;
    compare = gpu::create_sampler(device, {.beyond = kBorder, .border = kWhite, .compare = true});
    nearest = gpu::create_sampler(device, {.filter = VK_FILTER_NEAREST, .beyond = kBorder, .border = kWhite});
    linear = gpu::create_sampler(device, {.beyond = kBorder});
    beyond_grid = gpu::create_sampler(device, {.beyond = kBorder, .border = VK_BORDER_COLOR_FLOAT_TRANSPARENT_BLACK});
    timer = FrameTimer::create(device);
  }

  /// Call after a change of samples, views or quality, on which the pipelines depend.
  void forget_pipelines() {
    surface.forget_pipelines();
    for (VkPipeline* pipeline :
         {&tool.pipeline, &tool.handpiece_pipeline, &background.pipeline, &particles.pipeline,
          &particles.cloud_pipeline, &particles.streak_pipeline, &hidden.pipeline, &mask.pipeline})
      *pipeline = VK_NULL_HANDLE;
  }
  void create_pictures(int views) {
    targets.create(size, views);
    last_views = views;
    ++settings_version;
  }
  void destroy_pictures() {
    targets.destroy();
    mirror.destroy_pictures(device);
  }
  void rebuild(int views) {
    vkDeviceWaitIdle(device.device);
    destroy_pictures();
    forget_pipelines();
    create_pictures(views);
  }

  shared::FrameData data_of(const Frame& frame) const {
    shared::FrameData data =
        frame_data_of(frame, context.quality, looks, tool_body, handpiece_body, targets.pictures.options.size, bounds);
    if (film.on()) {
      data.film_origin = glm::vec4(glm::dvec4(film.origin, 1 / film.spacing));
      data.film_size = glm::vec4(glm::dvec4(film.size, 0));
    }
    if (frame.view == View::kTemperature && temperatures.on()) {
      data.temperature_origin = glm::vec4(glm::dvec4(temperatures.origin, 1 / temperatures.spacing));
      data.temperature_size = glm::vec4(temperatures.size, 0);
    }
    if (light_grid.size.x > 0) {
      data.light_origin = glm::vec4(glm::dvec4(light_grid.origin, 1 / light_grid.spacing));
      data.light_samples = glm::vec4(light_grid.size, 0);
      data.tissue_light_origin = glm::vec4(glm::dvec4(tissue_light.origin, 1 / tissue_light.spacing));
      data.tissue_light_cells = glm::vec4(tissue_light.size, 0);
    }
    return data;
  }

  /// Effects that this frame needs; shaders omit all others. `lit`: as if there were a light grid.
  SurfaceEffects effects(const Frame& frame, bool lit = false) const {
    // The light grid contains no light inside bodies, so views of the inside do not use it.
    const bool shows_inside = cuts_section(frame.view) || frame.view == View::kXray;
    return {.view = frame.view,
            .cursor = frame.cursor.visible,
            .handpiece_shadow = handpiece_body.mesh.index_count > 0,
            .spot = frame_lamp.y > 0,
            .film = film.on(),
            .light_grid = (lit || light_grid.size.x > 0) && !shows_inside};
  }

  bool same_particles(const Frame& frame) const {
    const auto bytes = std::as_bytes(frame.particles);
    return bytes.size() == last_particles.size() &&
           (bytes.empty() || !std::memcmp(bytes.data(), last_particles.data(), bytes.size()));
  }

  bool same_as_last(const shared::FrameData& data, const Frame& frame) const {
    const bool tool_same =
        frame.tool.visible == last_tool.visible &&
        (!frame.tool.visible || (same(frame.tool.X_WG, last_tool.X_WG) && same(frame.tool.X_GH, last_tool.X_GH) &&
                                 frame.tool.opacity == last_tool.opacity && frame.tool.open == last_tool.open));
    if ((frame.cloud && frame.cloud->changes()) || film.changed() || tissue_light.changed() || temperatures.changed())
      return false;
    return last_settings == settings_version && last_view == frame.view && last_version == bricks.version &&
           tool_same && same_tip(frame.suction, last_tip) && same_particles(frame) &&
           same(frame.mirror.X_WM, last_mirror.X_WM) && !std::memcmp(&data, &last_data, sizeof data);
  }

  /// Fills descriptor set i. Index k: scene of frame in flight k; kSlots + k: its reflected scene.
  void write_set(std::size_t i) {
    const VkImageView map = shadow.map.layer_views[0];
    inputs.fill(device, i, 0, frame_data[i]);
    inputs.fill(device, i, 1, compare, map);
    inputs.fill(device, i, 2, nearest, map);
    // Without a mirror, binds the shadow map, which no shader reads here.
    inputs.fill(device, i, 3, linear, mirror.picture.image && i < kSlots ? mirror.picture.view : shadow.map.view);
    inputs.fill(device, i, 4, beyond_grid, film.image.view);
    inputs.fill(device, i, 5, linear, light.view);
    inputs.fill(device, i, 6, linear, tissue_light.image.view);
    inputs.fill(device, i, 7, linear, images.view);
    inputs.fill(device, i, 8, beyond_grid, temperatures.image.view);
  }

  /// Uploads a grid of `texels` per axis; 0: one empty texel. `texel(i)`: packed value of texel i, 0 ≤ i < `count`.
  template <class Texel>
  void upload(VolumeImage& image, const glm::ivec3& texels, std::size_t count, const Texel& texel) {
    image.create(device, count > 0 ? texels : glm::ivec3(1), kLightFormat);
    if (count == 0) return;
    gpu::Buffer bytes = gpu::Buffer::create(device, count * sizeof(std::uint64_t), VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
    auto* const packed = bytes.mapped<std::uint64_t>();
    for (std::size_t i = 0; i < count; ++i) packed[i] = texel(i);
    gpu::run_once(device, [&](VkCommandBuffer commands) {
      const VkBufferImageCopy whole{.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1},
                                    .imageExtent = VolumeImage::extent_of(texels)};
      image.copy(commands, bytes.buffer, {&whole, 1});
    });
    bytes.destroy(device);
  }

  void set_light(const LightGrid& grid, const TissueLightGrid& inside) {
    light_grid = grid;
    light_grid.faces.clear();
    light_grid.images.clear();
    upload(light, grid.size * glm::ivec3(LightGrid::kFaces, 1, 1), grid.faces.size(),
           [&](std::size_t i) { return glm::packHalf4x16(grid.faces[i]); });
    upload(images, grid.size * glm::ivec3(1, LightGrid::kImageSide, LightGrid::kImageSide), grid.images.size(),
           [&](std::size_t i) { return glm::packHalf4x16(glm::vec4(grid.images[i], 0)); });
    tissue_light.set(device, inside, kLightFormat);
    if (grid.size.x == 0) return;
    const CellBox all{glm::ivec3(0), inside.size - 1};
    tissue_light.update([&](std::size_t i) { return glm::packHalf4x16(inside.values[i]); }, {&all, 1});
  }

  /// Adapts pictures and bounds to the frame. Returns its data.
  shared::FrameData follow(const Frame& frame) {
    TYPODONT_CHECK(frame.views == 1 || frame.views == 2);
    if (frame.views != last_views) rebuild(frame.views);
    if (std::exchange(bounds_version, bricks.version) != bricks.version) bounds = bricks.bounds();
    const shared::FrameData data = data_of(frame);
    frame_lamp = data.lamp;
    return data;
  }

  bool draws_handpiece(const ToolState& state) const { return state.visible && handpiece_body.mesh.index_count > 0; }

  bool prepare(const Frame& frame, bool lit) {
    const shared::FrameData data = follow(frame);
    const bool mirror_held = frame.mirror.diameter > 0, grid = light_grid.size.x > 0;
    const bool tools = frame.tool.visible || frame.suction.opening > 0 || mirror_held;
    const bool streaks =
        std::ranges::any_of(frame.particles, [](const Particle& p) { return p.streak != glm::vec3(0); });
    // The size of the working tooth decides about the effects on all surfaces.
    const auto working_tooth = bricks.meshes.find(kWorkingTooth);
    const bool tooth = working_tooth != bricks.meshes.end() && !working_tooth->second.bricks.empty();
    // `later`: those of a partial redraw, of the light grid, and of debris.
    std::vector<gpu::PipelineOptions> needed, later{MaskPass::options(context)};
    if (data.light_size.w > 0) needed.push_back(ShadowPass::options(context));
    if (hidden.count > 0) needed.push_back(HiddenPass::options(context));
    if (draws_handpiece(frame.tool)) needed.push_back(ToolPass::handpiece_options(context));
    if (tooth) SurfacePass::list_pipelines(context, bricks, effects(frame), needed);
    if (tools) needed.push_back(ToolPass::options(context, grid));
    if (mirror_held) needed.push_back(MirrorPass::options(context));
    (frame.background == Background::kGradient ? needed : later).push_back(BackgroundPass::options(context));
    if (!frame.particles.empty()) needed.push_back(ParticlePass::options(context, /*corners_given=*/true));
    if (streaks || film.on()) (streaks ? needed : later).push_back(ParticlePass::streak_options(context));
    if (frame.cloud)
      (frame.cloud->alive() > 0 ? needed : later).push_back(ParticlePass::options(context, /*corners_given=*/false));
    if (tooth && lit && !grid) {
      SurfacePass::list_pipelines(context, bricks, effects(frame, lit), later);
      if (tools) later.push_back(ToolPass::options(context, lit));
    }
    if (!gpu::prepare_pipelines(device, needed, /*urgent=*/true)) return false;
    gpu::prepare_pipelines(device, later, /*urgent=*/false);
    return true;
  }

  FrameStats record(VkCommandBuffer commands, const Frame& frame, int slot, std::uint64_t submitted,
                    std::uint64_t finished) {
    bricks.collect(finished);
    timer.read(device, slot);
    const shared::FrameData data = follow(frame);

    FrameStats stats;
    if (bounds) stats.pixel = pixel_nearest(frame, {bounds->lo, bounds->hi}, targets.pictures.options.size.width);
    stats.views = frame.views;
    stats.bricks_uploaded = bricks.uploaded;
    stats.bytes_uploaded = bricks.uploaded_bytes;
    bricks.uploaded = 0;
    bricks.uploaded_bytes = 0;
    stats.drawn = !same_as_last(data, frame);
    if (stats.drawn) {
      draw(commands, frame, data, slot, stats);
      last_data = data;
      last_tool = frame.tool;
      last_mirror = frame.mirror;
      last_tip = frame.suction;
      last_view = frame.view;
      const auto particle_bytes = std::as_bytes(frame.particles);
      last_particles.assign(particle_bytes.begin(), particle_bytes.end());
      last_version = bricks.version;
      last_order = bricks.order;
      last_settings = settings_version;
      undrawn_shadow = {};
      bricks.changed.clear();
    }
    if (stats.drawn) {
      last_submitted = submitted;
      ++frames;
    }
    stats.frames = frames;
    for (VkPipeline p :
         {shadow.pipeline, tool.pipeline, tool.handpiece_pipeline, background.pipeline, particles.pipeline,
          particles.cloud_pipeline, particles.streak_pipeline, mirror.pipeline, hidden.pipeline, mask.pipeline})
      if (p) ++stats.pipelines;
    stats.pipelines += surface.pipelines() + (frame.cloud ? frame.cloud->pipelines() : 0);
    return stats;
  }

  static bool same_tip(const SuctionTip& a, const SuctionTip& b) {
    return a.opening == b.opening && a.wall == b.wall && a.slant == b.slant && a.length == b.length &&
           (a.opening == 0 || same(a.X_WS, b.X_WS));
  }

  void prepare_tip(const SuctionTip& tip) {
    if (tip.opening <= 0) return;
    SuctionTip wanted = tip;
    wanted.X_WS = tip_made.X_WS;
    if (tip_body.mesh.index_count && same_tip(wanted, tip_made)) return;
    vkDeviceWaitIdle(device.device);
    tip_made = wanted;
    tip_body.set(device, make_suction_mesh(tip.opening, tip.wall, tip.slant, tip.length));
  }

  /// The frame as seen in the mirror: reflected eyes, and only objects in front of the glass.
  Frame in_mirror(const Frame& frame) const {
    Frame out = frame;
    for (Eye& eye : out.eyes) eye = reflected(eye, frame.mirror.X_WM);
    out.mirror.diameter = 0;
    return out;
  }

  enum class Changed { kNothing, kParts, kAll };

  /// Marks changed parts in `tiles` and, for particles, in `over_tiles`, unless all has changed.
  Changed mark_changed(const shared::FrameData& data, const Frame& frame, const glm::ivec2& drawn) {
    std::array<Tiles, 2> particles_now;
    const auto views = static_cast<std::size_t>(frame.views);
    for (std::size_t e = 0; e < views; ++e) {
      for (Tiles* t : {&tiles[e], &over_tiles[e], &particles_now[e]}) t->clear(drawn);
      const glm::dmat4 clip_from_world = frame.eyes[e].projection * frame.eyes[e].view;
      // If there are too many particles to track, the whole picture counts as changed.
      if (frame.particles.size() > kMaxTracked)
        particles_now[e].mark_all();
      else
        ParticlePass::mark(frame.particles, clip_from_world, drawn, particles_now[e]);
    }
    std::swap(particles_now, particle_tiles);

    shared::FrameData now = data, before = last_data;
    for (shared::FrameData* d : {&now, &before})
      d->tool_head = d->tool_end = d->tool_motion = d->cursor = d->cursor_down = d->handpiece[0] = d->handpiece[1] =
          d->handpiece[2] = d->handpiece[3] = glm::vec4(0);
    // The mirror's fog is visible only in its glass, whose tiles are redrawn in every frame anyway.
    now.mirror.y = before.mirror.y;
    const bool eyes_stay = !std::memcmp(now.clip_from_world, before.clip_from_world, sizeof now.clip_from_world);
    if (!eyes_stay || last_settings != settings_version) ++eyes_version;
    // Redraws all for headsets, whose eyes always move; for bodies of glass, which must be drawn in order; and for
    // particles on the GPU, whose positions the CPU does not know.
    if (targets.keeps_depth || (frame.cloud && frame.cloud->changes()) || frame.view == View::kXray ||
        last_view != frame.view || last_settings != settings_version || last_order != bricks.order ||
        std::memcmp(&now, &before, sizeof now) || !same(frame.mirror.X_WM, last_mirror.X_WM))
      return Changed::kAll;

    const bool particles_changed = !same_particles(frame);
    for (std::size_t e = 0; e < views; ++e) {
      const glm::dmat4 clip_from_world = frame.eyes[e].projection * frame.eyes[e].view;
      const auto matrix_of = [](const Pose& X) {
        glm::dmat4 m(glm::mat3_cast(X.R));
        m[3] = glm::dvec4(X.p, 1);
        return m;
      };
      const auto body_at = [&](const ToolBody& body, const Pose& X_W) {
        for (const ToolBody::Slice& s : body.slices)
          tiles[e].mark(seen_in(clip_from_world * matrix_of(X_W), {-s.radius, -s.radius, s.low},
                                {s.radius, s.radius, s.high}, drawn));
      };
      const auto tool_at = [&](const ToolState& state) {
        body_at(tool_body, state.X_WG);
        const glm::dmat4 clip_from_handpiece = clip_from_world * matrix_of(state.X_WG * state.X_GH);
        for (const BoxInWorld& box : handpiece_body.boxes)
          tiles[e].mark(seen_in(clip_from_handpiece, glm::vec3(box.lo), glm::vec3(box.hi), drawn));
      };
      if (frame.tool.visible) tool_at(frame.tool);
      if (last_tool.visible) tool_at(last_tool);
      if (!same_tip(frame.suction, last_tip)) {
        if (frame.suction.opening > 0) body_at(tip_body, frame.suction.X_WS);
        if (last_tip.opening > 0) body_at(tip_body, last_tip.X_WS);
      }
      if (particles_changed) {
        over_tiles[e].mark(particles_now[e]);
        over_tiles[e].mark(particle_tiles[e]);
      }
      if (!targets.layered()) tiles[e].mark(over_tiles[e]);
      film.mark(clip_from_world, drawn, tiles[e]);
      tissue_light.mark(clip_from_world, drawn, tiles[e]);
      temperatures.mark(clip_from_world, drawn, tiles[e]);
      // The glass may show any change, so its tiles are always marked.
      if (const auto glass = glass_in(frame.eyes[e], frame.mirror, drawn)) tiles[e].mark(*glass);
    }
    // A common pass for both eyes averages the samples of the whole picture, so the whole picture is redrawn.
    if (context.view_mask && marked_fraction(tiles, frame.views) > 0) return Changed::kAll;
    bricks.mark_changed(frame, data, last_data, drawn, eyes_version, tiles);
    const double fraction = marked_fraction(tiles, frame.views);
    if (fraction <= 0 && marked_fraction(over_tiles, frame.views) <= 0) return Changed::kNothing;
    return fraction < kFullRedrawFraction && !context.view_mask ? Changed::kParts : Changed::kAll;
  }

  ShadowMapBox changed_shadow_box(const shared::FrameData& data) const {
    ShadowMapBox part;
    for (const BoxInWorld& box : bricks.changed)
      part.take(shadow_map_box(glm::dmat4(data.light_from_world), glm::vec3(box.lo), glm::vec3(box.hi)));
    return part;
  }

  /// Draws the reflected scene for each eye, in the area of the glass.
  void draw_reflection(VkCommandBuffer commands, const Frame& mirrored,
                       const std::array<std::optional<PixelBox>, 2>& glass, int slot, FrameStats& stats) {
    const VkExtent2D extent = targets.pictures.options.size;
    const PixelBox all{0, 0, static_cast<int>(extent.width), static_cast<int>(extent.height)};
    FrameStats seen;  // counts of what the dental mirror's picture draws
    const std::vector<DrawGroup> groups = bricks.visible(device, slot, mirrored, bricks.mirror_indirect, seen);
    targets.begin(commands, mirror.picture, false);
    for (int view = 0; view < (context.view_mask ? 1 : mirrored.views); ++view) {
      const PixelBox box = context.view_mask ? all : glass[static_cast<std::size_t>(view)].value_or(PixelBox{});
      if (box.width == 0) continue;
      targets.begin_scene(commands, mirror.picture, mirrored, view, box, false, {0.030f, 0.033f, 0.038f});
      vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, context.layout, 0, 1,
                              &inputs.sets[static_cast<std::size_t>(kSlots + slot)], 0, nullptr);
      push_view(commands, context.layout, view);
      draw_handpiece(commands, mirrored.tool, view, seen);
      surface.record(context, commands, bricks, slot, bricks.mirror_indirect, groups, effects(mirrored), false, seen);
      if (mirrored.tool.visible) draw_tool(commands, mirrored.tool, view, seen);
      if (mirrored.suction.opening > 0)
        tool.record(context, commands, tip_body, mirrored.suction.X_WS, light_grid.size.x > 0, seen);
      surface.record(context, commands, bricks, slot, bricks.mirror_indirect, groups, effects(mirrored), true, seen);
      particles.record(context, commands, slot, mirrored.cloud, seen);
      targets.end_scene(commands, mirror.picture, view, {&all, 1});
      ++stats.mirror_passes;
    }
    targets.end(commands, mirror.picture);
    stats.passes += stats.mirror_passes;
    stats.commands += seen.commands;
    stats.mirror_bricks = seen.bricks_drawn;
    stats.mirror_triangles = seen.triangles;
  }

  /// Makes the handpiece's mesh; the lowest quality level draws none.
  void make_handpiece() {
    const bool shown = context.quality.shadow_map > 0;
    handpiece_body.set(device, make_handpiece_mesh(shown ? handpiece : Handpiece{}, context.quality.handpiece_side));
  }

  void draw_tool(VkCommandBuffer commands, const ToolState& state, int view, FrameStats& stats) {
    push_view(commands, context.layout, view, 1 - state.opacity);
    tool.record(context, commands, tool_body, state.X_WG, light_grid.size.x > 0, stats);
    push_view(commands, context.layout, view);
  }

  /// Draws the handpiece before the tissue, so that hidden tissue is not shaded.
  void draw_handpiece(VkCommandBuffer commands, const ToolState& state, int view, FrameStats& stats) {
    // The handpiece would hide the working point. So it is not drawn inside a cone from the eye to this point. The
    // cone's radius at this point is that of the head plus kSeenBeside (m).
    constexpr double kSeenBeside = 2.2e-3;
    if (!draws_handpiece(state)) return;
    push_view(commands, context.layout, view, 1 - state.opacity, state.open ? tool_body.head_radius + kSeenBeside : 0);
    tool.record_handpiece(context, commands, handpiece_body, state.X_WG * state.X_GH, stats);
    push_view(commands, context.layout, view);
  }

  void draw(VkCommandBuffer commands, const Frame& frame, const shared::FrameData& data, int slot, FrameStats& stats) {
    particles.prepare(context, slot, frame.particles);
    const auto views = static_cast<std::size_t>(frame.views);

    prepare_tip(frame.suction);
    // Finds what has changed since the last frame.
    const VkExtent2D extent = targets.pictures.options.size;
    const glm::ivec2 drawn_size(extent.width, extent.height);
    const Changed changed = mark_changed(data, frame, drawn_size);
    if (changed == Changed::kNothing) {  // no change is visible
      undrawn_shadow.take(changed_shadow_box(data));
      bricks.changed.clear();
      last_version = bricks.version;
      stats.drawn = false;
      stats.redrawn = 0;
      return;
    }
    const bool partly = changed == Changed::kParts;
    EyeBoxes scene_boxes;
    if (partly) {
      stats.redrawn = 0;
      EyeBoxes kept;
      for (std::size_t e = 0; e < views; ++e) {
        scene_boxes[e] = tiles[e].boxes(true, tiles[e].picture());
        kept[e] = tiles[e].boxes(false, tiles[e].bounds());
        // Particles are blended over the stored scene. So if one tile with particles is redrawn, all tiles with
        // particles must be redrawn.
        Tiles shown = tiles[e];
        shown.mark(over_tiles[e]);
        if (targets.layered() && shown.touch(particle_tiles[e])) shown.mark(particle_tiles[e]);
        redrawn[e] = shown.boxes(true, shown.picture());
        stats.redrawn += shown.fraction() / frame.views;
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
      mirror.create_picture(context, extent, targets.pictures.options.layers);
      shared::FrameData reflected_data = data_of(mirrored);
      reflected_data.clip = glm::vec4(before_glass(frame.mirror.X_WM));
      std::memcpy(frame_data[other].memory.mapped, &reflected_data, sizeof reflected_data);
      write_set(other);
    }
    std::memcpy(frame_data[own].memory.mapped, &data, sizeof data);
    write_set(own);
    timer.begin(commands, slot);

    // Redraws the affected part of the shadow map after a change of bodies or lamp.
    const bool other_light = shadow_light != data.light_from_world || shadow_view != frame.view ||
                             shadow_section != data.section || shadow_order != bricks.order;
    if (data.light_size.w > 0 && (other_light || shadow_version != bricks.version)) {
      ShadowMapBox part = undrawn_shadow;
      part.take(changed_shadow_box(data));
      if (other_light) part = {glm::vec2(0), glm::vec2(1)};
      shadow.record(context, commands, inputs.sets[own], bricks, slot, frame.view, data.light_from_world, part, stats);
      shadow_view = frame.view;
      shadow_section = data.section;
      shadow_version = bricks.version;
      shadow_order = bricks.order;
      shadow_light = data.light_from_world;
    }

    timer.mark(commands, FramePart::kShadow);
    if (frame.cloud) frame.cloud->record(commands, slot);
    stats.film_bytes = film.record(device, commands, slot);
    tissue_light.record(device, commands, slot);
    stats.temperature_bytes = temperatures.record(device, commands, slot);
    timer.mark(commands, FramePart::kUploads);

    if (reflects) draw_reflection(commands, mirrored, glass, slot, stats);
    timer.mark(commands, FramePart::kMirror);

    const std::vector<DrawGroup> groups =
        bricks.visible(device, slot, frame, bricks.indirect, stats, partly ? &tiles : nullptr);
    const gpu::Image& target = targets.scene();
    targets.begin(commands, target, partly);
    const int scene_passes = context.view_mask ? 1 : frame.views, pass_views = frame.views / scene_passes;
    const auto mark = [&](FramePart part) { timer.mark(commands, part, pass_views); };
    for (int view = 0; view < scene_passes; ++view) {
      const auto e = static_cast<std::size_t>(view);
      const PixelBox all{0, 0, drawn_size.x, drawn_size.y}, box = partly ? tiles[e].bounds() : all;
      if (box.width == 0) continue;
      targets.begin_scene(commands, target, frame, view, box, partly, {0, 0, 0});
      vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, context.layout, 0, 1, &inputs.sets[own], 0,
                              nullptr);
      push_view(commands, context.layout, view);
      if (partly) mask.record(context, commands, slot, view, stats);
      hidden.record(context, commands, stats);
      draw_handpiece(commands, frame.tool, view, stats);
      mark(FramePart::kHandpiece);
      surface.record(context, commands, bricks, slot, bricks.indirect, groups, effects(frame), false, stats);
      mark(FramePart::kTissue);
      if (frame.tool.visible) draw_tool(commands, frame.tool, view, stats);
      if (frame.suction.opening > 0)
        tool.record(context, commands, tip_body, frame.suction.X_WS, light_grid.size.x > 0, stats);
      if (frame.mirror.diameter > 0) {
        tool.record(context, commands, mirror.body, frame.mirror.X_WM, light_grid.size.x > 0, stats);
        if (reflects) mirror.record_glass(context, commands, frame.mirror, stats);
      }
      mark(FramePart::kTools);
      // A partial redraw needs the background even if it is black, to replace old pixels.
      if (frame.background == Background::kGradient || partly) background.record(context, commands, stats);
      mark(FramePart::kBackground);
      surface.record(context, commands, bricks, slot, bricks.indirect, groups, effects(frame), true, stats);
      mark(FramePart::kTissue);
      if (!targets.layered()) particles.record(context, commands, slot, frame.cloud, stats);
      mark(FramePart::kParticles);
      targets.end_scene(commands, target, view, redrawn[e]);
      timer.mark(commands, FramePart::kPicture);
      ++stats.passes;
    }
    if (targets.layered())
      lay_over(commands, frame, slot, partly, scene_boxes, stats);
    else
      targets.end(commands, targets.pictures);
    timer.mark(commands, targets.layered() ? FramePart::kParticles : FramePart::kPicture);
    timer.end();
  }

  /// Copies the stored scene into the pictures, and draws the particles over it.
  void lay_over(VkCommandBuffer commands, const Frame& frame, int slot, bool partly, const EyeBoxes& scene_boxes,
                FrameStats& stats) {
    targets.restore_scene(commands, frame.views, partly, scene_boxes, redrawn);
    const VkExtent2D extent = targets.pictures.options.size;
    for (int view = 0; view < frame.views; ++view) {
      const auto e = static_cast<std::size_t>(view);
      Tiles over;
      over.clear({extent.width, extent.height});
      for (const PixelBox& b : redrawn[e]) over.mark(b);
      if (!frame.cloud && !over.touch(particle_tiles[e])) continue;
      targets.begin_over(commands, frame, view);
      vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, context.layout, 0, 1,
                              &inputs.sets[static_cast<std::size_t>(slot)], 0, nullptr);
      push_view(commands, context.layout, view);
      particles.record(context, commands, slot, frame.cloud, stats);
      vkCmdEndRendering(commands);
      ++stats.passes;
    }
    targets.end_over(commands);
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

void Renderer::set_tool(const ToolMesh& tool, const Handpiece& handpiece) {
  vkDeviceWaitIdle(impl_->device.device);
  impl_->tool_body.set(impl_->device, tool);
  impl_->handpiece = handpiece;
  impl_->make_handpiece();
  ++impl_->settings_version;
}

void Renderer::set_film(const FilmGrid& grid) {
  vkDeviceWaitIdle(impl_->device.device);
  impl_->film.set(impl_->device, grid, kFilmFormat);
  ++impl_->settings_version;
}

void Renderer::update_film(std::span<const FilmTexel> texels, std::span<const CellBox> changed) {
  TYPODONT_CHECK(impl_->film.on());
  impl_->film.update([&](std::size_t i) { return texels[i]; }, changed);
}

void Renderer::set_temperatures(const TemperatureGrid& grid) {
  vkDeviceWaitIdle(impl_->device.device);
  impl_->temperatures.set(impl_->device, grid, kTemperatureFormat);
  ++impl_->settings_version;
}

void Renderer::update_temperatures(std::span<const glm::vec2> values) {
  TYPODONT_CHECK(impl_->temperatures.on());
  const CellBox all{glm::ivec3(0), impl_->temperatures.size - 1};
  impl_->temperatures.update([&](std::size_t i) { return glm::packHalf2x16(values[i]); }, {&all, 1});
}

void Renderer::set_light(const LightGrid& grid, const TissueLightGrid& inside) {
  TYPODONT_CHECK(grid.size.x == 0 || inside.size.x > 0);
  vkDeviceWaitIdle(impl_->device.device);
  impl_->set_light(grid, inside);
  ++impl_->settings_version;
}

void Renderer::update_tissue_light(std::span<const glm::vec4> values, const CellBox& changed) {
  TYPODONT_CHECK(impl_->tissue_light.on());
  impl_->tissue_light.update([&](std::size_t i) { return glm::packHalf4x16(values[i]); }, {&changed, 1});
}

void Renderer::resize(glm::ivec2 size) {
  if (size == impl_->size) return;
  impl_->size = size;
  impl_->rebuild(impl_->last_views);
}

void Renderer::set_quality(const Quality& quality) {
  vkDeviceWaitIdle(impl_->device.device);
  impl_->context.quality = quality;
  impl_->make_handpiece();
  impl_->shadow.destroy(impl_->device);
  impl_->shadow.create_map(impl_->context);
  impl_->shadow_light = glm::mat4(0);  // the next frame draws the whole map
  impl_->rebuild(impl_->last_views);
}

void Renderer::set_hidden(std::span<const glm::vec3> corners) {
  vkDeviceWaitIdle(impl_->device.device);
  impl_->hidden.set(impl_->device, corners);
  ++impl_->settings_version;
}

void Renderer::keep_depth(bool keep) {
  if (keep == impl_->targets.keeps_depth) return;
  vkDeviceWaitIdle(impl_->device.device);
  impl_->destroy_pictures();
  impl_->targets.keeps_depth = keep;
  impl_->create_pictures(impl_->last_views);
}

Renderer::DepthPicture Renderer::depth(int view) const {
  if (impl_->targets.kept_depth.empty()) return {};
  const bool together = impl_->targets.kept_depth.size() == 1;
  return {&impl_->targets.kept_depth[together ? 0 : static_cast<std::size_t>(view)],
          together ? static_cast<std::uint32_t>(view) : 0};
}

bool Renderer::prepare(const Frame& frame, bool lit) {
  return impl_->prepare(frame, lit);
}

FrameStats Renderer::record(VkCommandBuffer commands, const Frame& frame, int slot, std::uint64_t submitted,
                            std::uint64_t finished) {
  return impl_->record(commands, frame, slot, submitted, finished);
}

GpuTimes Renderer::gpu_times(std::optional<int> finished_slot) {
  if (finished_slot) impl_->timer.read(impl_->device, *finished_slot);
  return impl_->timer.times;
}

std::span<const PixelBox> Renderer::redrawn(int view) const {
  return impl_->redrawn[static_cast<std::size_t>(view)];
}

const gpu::Image& Renderer::pictures() const {
  return impl_->targets.pictures;
}

}  // namespace typodont::render
