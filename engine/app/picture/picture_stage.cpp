#include "engine/app/picture/picture_stage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "engine/app/picture/hud.h"
#include "engine/app/scene/handpiece_file.h"
#include "engine/base/error.h"
#include "engine/base/units.h"
#include "engine/session/implant.h"
#include "haptics/tool.h"

namespace typodont {

namespace {

constexpr std::string_view kDiamond =
    "80";                            // first digits of the ISO 6360 codes 801 to 807: galvanically bonded diamond
constexpr double kPrecision = 1e-6;  // m, largest distance of a tool's drawn outline from its exact outline

/// Returns points (radius, z) of a part's outline from the free end to the shank end, m. The contact model uses the
/// same outline. Straight lines between the points are at most `error` (m) from it.
std::vector<glm::dvec2> outline(const haptics::Tool& part, double error) {
  const haptics::HeadField meridian(part, 1);
  std::vector<glm::dvec2> points{{meridian.pieces[0].ax, meridian.pieces[0].az}};
  for (const haptics::HeadField::Piece& piece :
       std::span(meridian.pieces).first(static_cast<std::size_t>(meridian.count))) {
    if (piece.radius > error) {
      const glm::dvec2 center(piece.cx, piece.cz);
      const double from = std::atan2(piece.az - piece.cz, piece.ax - piece.cx);
      double turn = std::atan2(piece.bz - piece.cz, piece.bx - piece.cx) - from;
      if (turn < 0) turn += 2 * kPi;
      // The sagitta of an arc of angle α is r (1 - cos(α/2)).
      const int steps = static_cast<int>(std::ceil(turn / (2 * std::acos(1 - error / piece.radius))));
      for (int k = 1; k < steps; ++k) {
        const double angle = from + turn * k / steps;
        points.push_back(center + piece.radius * glm::dvec2(std::cos(angle), std::sin(angle)));
      }
    }
    points.push_back({piece.bx, piece.bz});
  }
  return points;
}

/// Cuts an outline off where it becomes narrower than the neck that follows it.
void end_at_neck(std::vector<glm::dvec2>& outline, double neck) {
  while (outline.size() > 2 && outline[outline.size() - 2].x < neck) outline.pop_back();
  const glm::dvec2 a = outline[outline.size() - 2], b = outline.back();
  if (b.x < neck) outline.back() = glm::mix(a, b, (a.x - neck) / (a.x - b.x));
}

/// The outline of neck and shank from `begin` (m, end of the head) to the height `end` (m).
/// A shank that can touch tissue is drawn with the outline that the contact model uses.
std::vector<glm::dvec2> shaft_outline(const haptics::Tool& tool, glm::dvec2 begin, double end) {
  constexpr double kTaper = 4e-3, kRounded = 0.2e-3;  // m, largest length of the neck; length of the rounded end
  constexpr double kFrictionGrip = 0.8e-3, kLatch = 2.35e-3 / 2;  // m, radii of shanks (ISO 1797 types 3, 1)
  std::vector<glm::dvec2> shaft;
  if (const auto shank = haptics::shank_of(tool)) {
    shaft = outline(shank->shape, kPrecision);
    shaft.erase(shaft.begin());
    shaft.pop_back();
    for (glm::dvec2& p : shaft) p.y += shank->z;
  } else {
    const double radius = tool.implant ? kLatch : kFrictionGrip, taper = std::min(kTaper, end - begin.y);
    shaft.push_back(begin);
    for (int i = 1; i <= 10; ++i) {
      const double s = i / 10.0, blend = s * s * (3 - 2 * s);
      shaft.push_back({begin.x + (radius - begin.x) * blend * blend, begin.y + taper * s});
    }
  }
  const double radius = shaft.back().x;
  shaft.insert(shaft.end(), {{radius, end - kRounded}, {0.8 * radius, end}, {0, end}});
  return shaft;
}

/// Adds details to the drawn shape of an implant tool: the flutes of a twist drill, depth marks, and threads.
void add_implant_look(const haptics::ImplantTool& implant, const haptics::Tool& tool, render::ToolShape& shape) {
  constexpr double kFluteRise = 12e-3;  // m, length along the drill's axis per turn of a flute
  for (const double mark : implant.marks) shape.marks.push_back(mark - tool.half());
  if (implant.kind == haptics::ImplantToolKind::kDrill) {
    shape.flutes = 2;
    shape.flute_depth = 0.35;
    shape.helix = tool.length / kFluteRise;
  }
  if (implant.threaded()) {
    shape.flutes = 0;
    shape.thread_pitch = implant.pitch;
    shape.thread_core = implant.core_diameter / 2;
  }
}

/// The radius (m) of the neck behind the head.
double neck_radius(const haptics::Tool& tool) {
  constexpr double kWidestDriver = 2.35e-3 / 2;  // m, largest radius of an implant tool's neck
  const double r = tool.radius();
  if (tool.shank_length > 0) return tool.neck_diameter / 2;
  if (tool.implant && tool.implant->kind != haptics::ImplantToolKind::kRound) return std::min(kWidestDriver, r);
  return std::max(std::min(0.45 * r, 5e-4), std::min(0.8 * r, 2e-4));
}

}  // namespace

bool looks_same(const Pose& a, const Pose& b) {
  const dquat turn = a.R * (glm::dot(a.R, b.R) < 0 ? -1.0 : 1.0) - b.R;
  // Two poses count as equal if the positions differ by at most 1e-7 m and the rotations by at most 5e-6 rad. A
  // difference of 2.5e-6 between two quaternions is a rotation of 5e-6 rad.
  return glm::length(a.p - b.p) <= 1e-7 && glm::length(turn) <= 2.5e-6;
}

gpu::Device make_picture_device(const PictureStage::Options& options) {
  gpu::DeviceOptions device;
  device.validation = options.validation;
  if (options.window) {
#ifdef TYPODONT_WINDOW
    device.instance_extensions = display::window_extensions();
    device.present = true;
#else
    throw Error("this build", "", "no window support", "a build with TYPODONT_WINDOW=ON, or an offscreen rig");
#endif
  }
  return gpu::Device::create(device);
}

std::optional<render::BoxInWorld> tissue_reach(const Scene& scene, const haptics::TissueVolume& tissue) {
  const auto tools = haptics::tool_set(scene.servo);
  const bool grows =
      std::any_of(tools.begin(), tools.end(), [](const haptics::Tool& tool) { return tool.fill != Tissue::kAir; });
  if (grows || !scene.resume.empty()) return std::nullopt;
  // Bounds of all samples that store a distance, voxels.
  glm::ivec3 lo, hi;
  tissue.bounds(lo, hi);
  return render::BoxInWorld{tissue.frame().to_world(dvec3(lo)), tissue.frame().to_world(dvec3(hi))};
}

void count_frame(const render::FrameStats& stats, WorkCounts& work) {
  work.passes += static_cast<std::uint64_t>(stats.passes);
  work.triangles_drawn += stats.triangles + stats.mirror_triangles;
  work.bricks_skipped +=
      static_cast<std::uint64_t>(stats.bricks_culled + stats.bricks_facing_away + stats.bricks_covered);
  work.pipelines = std::max(work.pipelines, static_cast<std::uint64_t>(stats.pipelines));
}

DrawnTool drawn_tool(const haptics::Tool& tool, const haptics::Spindle& spindle, const HandpieceView& view,
                     bool placed) {
  // Drawn length of the shank between head and handpiece, m: for tools that turn, and for tools that do not. Used if
  // the tool's file does not state it.
  constexpr double kTurningShank = 8e-3, kStillShank = 5e-3;
  constexpr double kHeld = 0.6e-3;      // m, length of the shank that is inside the handpiece
  constexpr double kBareShank = 20e-3;  // m, shank length of a tool without a handpiece
  render::ToolShape shape;
  if (!tool.turns()) shape.flutes = 0;
  if (tool.iso_code.starts_with(kDiamond) && shape.flutes > 0) {
    shape.diamond = true;
    shape.flutes = 0;
  }
  if (tool.implant) add_implant_look(*tool.implant, tool, shape);
  shape.head = outline(tool, kPrecision * std::max(1.0, 5e2 * tool.radius()));
  if (const auto pin = haptics::safe_end_of(tool)) {
    shape.safe_end = outline(pin->shape, kPrecision);
    for (glm::dvec2& p : shape.safe_end) p.y += pin->z;
  }
  DrawnTool drawn;
  const std::string name = view.shown ? handpiece_name(tool, spindle) : "";
  double end = tool.half() + kBareShank;  // m, end of the shank
  if (!name.empty()) {
    drawn.handpiece = load_handpiece(name);
    drawn.open = view.open && !drawn.handpiece.from_head;
    const double z = drawn.handpiece.from_head ? 0
                                               : tool.half() + (tool.shank_length > 0 ? tool.shank_length
                                                                : tool.turns()        ? kTurningShank
                                                                                      : kStillShank);
    drawn.X_GH = {{0, 0, z}, glm::angleAxis(view.roll, dvec3(0, 0, 1))};
    end = z + kHeld;
  }
  if (!drawn.handpiece.from_head) {
    end_at_neck(shape.head, neck_radius(tool));
    shape.shaft = shaft_outline(tool, shape.head.back(), end);
  }
  if (placed) {
    shape.head.clear();
    shape.flutes = 0, shape.thread_pitch = 0;
    if (!shape.shaft.empty()) shape.shaft.insert(shape.shaft.begin(), {0, shape.shaft.front().y});
  }
  drawn.tool = render::make_tool_mesh(shape);
  return drawn;
}

bool is_placed(const haptics::Tool& tool, const ServoTick& tick) {
  return tool.implant && tool.implant->stays() && tick.level == session::implant_level::kPlaced;
}

PictureStage::PictureStage(const display::DisplayRig& rig, const haptics::ServoSettings& servo, const Options& options)
    : rig_(rig),
      rest_(rig.head),
      servo_(servo),
      options_(options),
      device_(options.device ? *options.device : own_device_.emplace(make_picture_device(options))),
      shown_(options.handpieces) {
  if (options.window && !rig.head.tracker.empty()) tracker_.emplace(rig);
  ring_ = gpu::FrameRing::create(device_);
  first_panel_ = {rig.screen.lower_right - rig.screen.lower_left, rig.screen.upper_left - rig.screen.lower_left};
#ifdef TYPODONT_WINDOW
  if (options.window) {
    display::WindowOptions window;
    window.size = rig.screen.pixels;
    window.output = options.monitor;
    window.stereo_surface = rig.screen.layout == display::Layout::kFrameSequential;
    window.composed = true;
    window.urgent = options.urgent;
    output_ = display::make_window(device_, window);
  }
#endif
  const glm::ivec2 eye = display::eye_pixels(rig.screen.layout, rig.screen.pixels);
  if (!output_ && !options.embedded)
    output_ = display::make_offscreen(device_, display::screen_pixels(rig.screen.layout, eye));
  screen_size_ = output_ ? output_->size() : eye;
  renderer_.emplace(device_, eye, options.quality, servo.materials);
  compositor_.emplace(device_);
}

PictureStage::~PictureStage() {
  vkDeviceWaitIdle(device_.device);  // also returns if the device is lost
  output_.reset();
  compositor_.reset();
  renderer_.reset();
  ring_.destroy(device_);
  if (own_device_) own_device_->destroy();
}

void PictureStage::show(std::span<const render::MeshUpdate> bricks, const dvec3& origin) {
  if (light_) light_->put(bricks, origin);
  renderer_->update(render::kWorkingTooth, bricks);
  renderer_->place(render::kWorkingTooth, {origin, {1, 0, 0, 0}});
}

bool PictureStage::resize(glm::ivec2 eye_size) {
  eye_size = glm::max(eye_size, glm::ivec2(16));
  if (eye_size == screen_size_) return false;
  vkDeviceWaitIdle(device_.device);  // the GPU may still draw the old pictures
  screen_size_ = eye_size;
  blank_ = true;
  renderer_->resize(eye_size);
  // Enlarges the panel about its middle until it has the aspect ratio of the picture, so that everything that was
  // visible remains visible.
  display::Screen& screen = rig_.screen;
  const dvec3 right = screen.lower_right - screen.lower_left, up = screen.upper_left - screen.lower_left;
  const dvec3 middle = (screen.lower_right + screen.upper_left) / 2.0;
  const double wanted = static_cast<double>(eye_size.x) / eye_size.y;
  const double width = std::max(glm::length(first_panel_[0]), wanted * glm::length(first_panel_[1]));
  const dvec3 half_right = width / 2 * glm::normalize(right), half_up = width / wanted / 2 * glm::normalize(up);
  screen.lower_left = middle - half_right - half_up;
  screen.lower_right = middle + half_right - half_up;
  screen.upper_left = middle - half_right + half_up;
  return true;
}

void surround(render::Renderer& renderer, const Surroundings& around, bool coarse) {
  for (const SurroundingMesh& mesh : around.meshes) {
    renderer.remove(mesh.id);
    renderer.update(mesh.id, coarse ? mesh.coarse : mesh.bricks);
    renderer.place(mesh.id, {mesh.origin, {1, 0, 0, 0}});
  }
  renderer.cover(render::kWorkingTooth, around.covered);
}

void PictureStage::surround(const Surroundings& around) {
  light_.reset();
  around_ = around;
  coarse_around_ = screen_pixel(rig_) / options_.quality.scale * options_.quality.surface_error > around_.coarse_from;
  typodont::surround(*renderer_, around_, coarse_around_);
  shown_.gum_at_rest();
  if (around_.lit)
    light_.emplace(around_, options_.quality, render::appearances_of(servo_.materials), options_.light,
                   device_.processor ? std::string() : device_.name());
  renderer_->set_light({}, {});
}

void add_held(const World& world, const Look& look, render::Frame& frame) {
  const ServoTick& tick = world.tick();
  frame.tool.visible = look.tool;
  frame.tool.X_WG = tick.X_WG;
  frame.tool.angle = world.angle();
  frame.tool.spindle = tick.spindle;
  frame.mirror = look.mirror ? world.mirror() : MouthMirror{};
  frame.suction = look.debris ? world.suction_tip() : SuctionTip{};
}

void ShownWorld::add(World& world, const Look& look, std::optional<bool> coarse, render::Renderer& renderer,
                     render::Frame& frame) {
  const bool placed = is_placed(world.tool(), world.tick());
  if (tool_ != world.tick().tool || placed != placed_) {
    tool_ = world.tick().tool;
    placed_ = placed;
    const DrawnTool drawn = drawn_tool(world.tool(), world.scene().servo.spindle, handpieces_, placed);
    X_GH_ = drawn.X_GH;
    open_ = drawn.open;
    renderer.set_tool(drawn.tool, drawn.handpiece);
  }
  add_held(world, look, frame);
  frame.tool.X_GH = X_GH_;
  frame.tool.open = open_;
  if (const SoftGumView* const gum = world.gum(); gum && coarse && gum->version() != gum_version_) {
    for (const SoftGumView::Brick& brick : gum->bricks())
      if (brick.coarse == *coarse && brick.version > gum_version_) renderer.update(brick.mesh, {&brick.now, 1});
    gum_version_ = gum->version();
  }
  DebrisView* const debris = look.debris ? world.debris() : nullptr;
  if (debris) frame.particles = debris->particles();
  if (debris) frame.cloud = debris->cloud();
  FilmPicture::show(debris ? debris->film() : nullptr, renderer, film_);
  if (frame.view == render::View::kTemperature && world.heat()) temperatures_.show(*world.heat(), renderer);
}

/// Chooses between the fine and the coarse mesh of the surroundings, by the size of a pixel at the tooth.
void PictureStage::follow_pixels(double pixel) {
  if (pixel <= 0 || around_.meshes.empty()) return;
  const double error = pixel * options_.quality.surface_error;
  // While the coarse mesh is drawn, the limit for its error is lower (hysteresis),
  // so that small motions of the user's head do not change the mesh again and again.
  const bool coarse = error > around_.coarse_from * (coarse_around_ ? 0.85 : 1.0);
  if (coarse == coarse_around_) return;
  coarse_around_ = coarse;
  typodont::surround(*renderer_, around_, coarse_around_);
  shown_.gum_at_rest();
}

void PictureStage::add_cursor(const haptics::Tool& held, const Pose& X_WG, render::Frame& frame) {
  // m. kRoom: distance between the tool and the ring around it; kStep: distance between two dots; kReach: length of the
  // row of dots; kDot: radius of a dot.
  constexpr double kRoom = 0.2e-3, kStep = 0.5e-3, kReach = 10e-3, kDot = 0.05e-3;
  const dvec3 down = X_WG.R * dvec3(0, 0, -1);
  frame.cursor = {true, X_WG.p, down, 1.3 * held.radius() + kRoom};
  with_dots_.assign(frame.particles.begin(), frame.particles.end());
  const auto radius = static_cast<float>(std::max(kDot, pixel_));
  for (double distance = kStep; distance <= kReach; distance += kStep)
    with_dots_.push_back({glm::vec3(X_WG.p + (held.half() + distance) * down),
                          radius,
                          {0.42f, 0.85f, 0.92f},
                          static_cast<float>(1 - 0.7 * distance / kReach)});
  frame.particles = with_dots_;
}

void PictureStage::show_inside(render::MeshId body, std::span<const render::MeshUpdate> bricks, const dvec3& origin) {
  renderer_->remove(body);
  renderer_->update(body, bricks);
  if (!bricks.empty()) renderer_->place(body, {origin, {1, 0, 0, 0}});
}

void PictureStage::look_from(const display::DisplayRig& rig) {
  const glm::ivec2 pixels = rig_.screen.pixels;
  const display::Layout layout = rig_.screen.layout;
  rig_.screen = rig.screen;
  rig_.screen.pixels = pixels;
  rig_.screen.layout = layout;
  rig_.head = rest_ = rig.head;
  bent_for_.reset();
  first_panel_ = {rig.screen.lower_right - rig.screen.lower_left, rig.screen.upper_left - rig.screen.lower_left};
}

void PictureStage::follow_size() {
  if (!output_) return;
  const glm::ivec2 size = output_->size();
  if (size == screen_size_ || size.x <= 0 || size.y <= 0) return;
  ring_.wait_idle(device_);
  screen_size_ = size;
  // With frame-sequential stereo, the window's image has one layer for each eye, as large as the window.
  const bool layers = options_.window && rig_.screen.layout == display::Layout::kFrameSequential;
  renderer_->resize(layers ? size : display::eye_pixels_in(rig_.screen.layout, size));
}

void PictureStage::follow_head() {
  if (!tracker_) return;
  tracker_->poll();
  const display::Head head = tracker_->at(now() + from_seconds(latency_));
  // Uses the new pose of the user's head only if the eyes can see the picture from there; otherwise keeps the last
  // pose.
  if (display::sees(rig_, head)) rig_.head = head;
}

std::optional<display::HeadTracker::Stats> PictureStage::tracker_stats() const {
  if (!tracker_) return std::nullopt;
  return tracker_->stats();
}

/// Makes the next frame, with the positions of its eyes, the lamp and the mouth mirror.
render::Frame PictureStage::look() const {
  render::Frame frame;
  const auto eyes = display::eye_views(rig_);
  for (std::size_t e = 0; e < 2; ++e) {
    frame.eyes[e] = {eyes[e].view, eyes[e].projection, eyes[e].position, eyes[e].flip};
  }
  frame.views = one_eye_ || rig_.screen.layout == display::Layout::kMono ? 1 : 2;

  // For every display rig, the lamp is over the user's left shoulder, 20° from the line of sight, so that it reaches
  // the floor of a cavity. It is fixed relative to the screen and does not follow the head.
  const display::Screen seen = rig_.mirror ? display::reflect(*rig_.mirror, rig_.screen) : rig_.screen;
  const dvec3 middle = (seen.lower_right + seen.upper_left) / 2.0;
  const dvec3 toward = glm::normalize(rest_.eye_center - middle), up = glm::cross(toward, rest_.right);
  frame.lights.key = glm::normalize(0.9 * toward + 0.2 * up - 0.25 * rest_.right);
  frame.lights.key_strength = 3.4;
  frame.lights.up = up;
  if (rig_.mirror) frame.background = render::Background::kBlack;
  frame.mirror = mirror_;
  frame.suction = tip_;
  return frame;
}

bool PictureStage::in_sight(const std::optional<render::BoxInWorld>& box) const {
  return (!output_ || output_->visible()) && (!box || render::in_sight(look(), *box));
}

void PictureStage::follow_bend() {
  if (!compositor_) return;
  const std::array eyes = display::eye_positions(rig_.head, rig_.screen.layout);
  if (bent_for_ == eyes) return;
  bent_for_ = eyes;
  compositor_->bend(display::warp(rig_));
}

render::Frame PictureStage::next_frame(World& world, const Look& shown) {
  follow_size();
  follow_head();
  follow_bend();
  render::Frame frame = look();
  frame.view = view_;
  frame.section = section_;
  frame.particles = spheres_;
  shown_.add(world, shown, around_.meshes.empty() ? std::nullopt : std::optional(coarse_around_), *renderer_, frame);
  if (!options_.chips_on_gpu) frame.cloud = nullptr;
  mirror_ = frame.mirror;
  tip_ = frame.suction;
  at_rest_ = looks_same(frame.tool.X_WG, shown_at_);
  if (!at_rest_) shown_at_ = frame.tool.X_WG;
  frame.tool.X_WG = shown_at_;
  if (options_.cursor && shown.tool) add_cursor(world.tool(), shown_at_, frame);
  return frame;
}

render::FrameStats PictureStage::draw(World& world, const Look& shown, const std::function<void()>& take_last) {
  const Nanos began = now();
  if (output_ && !output_->visible()) {
    missed_ = true;  // the content of a minimised window may be lost, so the next frame must be drawn
    return {};
  }
  const render::Frame frame = next_frame(world, shown);
  if (light_) light_->follow(frame.lights, *renderer_);
  waits_ = ahead_ && !prepare(frame);
  if (waits_) return {};
  const display::Screen& screen = rig_.screen;
  if (take_last) take_last();
  if (options_.hud)
    hud_ = typodont::hud(world, options_.language, view_);
  else if (options_.warnings)
    hud_.warning = warning_text(world.warning(), options_.language);
  hud_.visible = options_.hud || !hud_.warning.empty();
  hud_.force_shown = options_.force_in_hud;
  hud_.force_limit = options_.force_limit;
  hud_.min_letters = display::readable_letters(rig_);
  hud_.upright = display::upright(rig_);
  hud_.aspect =
      glm::length(screen.lower_right - screen.lower_left) / glm::length(screen.upper_left - screen.lower_left);

  const VkCommandBuffer commands = ring_.begin(device_);
  render::FrameStats stats = renderer_->record(commands, frame, ring_.slot(), ring_.submitted, ring_.finished);
  const display::Compositor::Huds huds{&hud_, &hud_};
  if (!stats.drawn &&
      !(output_ && (missed_ || output_->needs_frame() || compositor_->text_changed(huds, screen.layout)))) {
    ring_.abandon(device_);
    return stats;
  }
  blank_ = blank_ && !stats.drawn;
  follow_pixels(stats.pixel);
  pixel_ = stats.pixel;
  gpu_times_ = renderer_->gpu_times();
  timing_.gpu = 1e-3 * gpu_times_.frame;
  timing_.record = to_seconds(now() - began);
  timing_.shown = timing_.record + timing_.gpu;
  if (!output_ || one_eye_) {
    ring_.submit(device_);
    if (!output_ && !ahead_) ring_.wait_idle(device_);  // the caller uses pictures() immediately: they must be finished
    timing_.shown = to_seconds(now() - began);
    return stats;
  }
  const bool uncovered = std::exchange(missed_, false) || output_->needs_frame();
  const auto target = output_->acquire();
  const Nanos acquired = now();
  if (target) {
    // Only the changed parts are composed, because the screen already shows the unchanged parts. With software
    // rendering, this saves most of the time.
    std::array<std::vector<display::Part>, 2> changed;
    if (stats.drawn)
      for (int e = 0; e < frame.views; ++e)
        for (const render::PixelBox& b : renderer_->redrawn(e))
          changed[static_cast<std::size_t>(e)].push_back({b.x, b.y, b.width, b.height});
    const auto drawn =
        compositor_->record(commands, renderer_->pictures(), screen.layout, *target, ring_.slot(), output_->first_row(),
                            device_.processor && !uncovered ? &changed : nullptr, huds);
    if (!target->memory.first)
      // Counts the render passes that compose the screen: one for each layer. A picture in memory needs none.
      stats.passes += static_cast<int>(target->layers.size());
    ring_.submit(device_, target->ready, target->done);
    // Time until the frame is visible: CPU time for recording and submission, plus GPU time for drawing, plus half a
    // refresh period of the screen.
    const auto seen_at = [this, began](double more) {
      timing_.shown = to_seconds(now() - began) + more + 0.5 * output_->refresh_period();
      latency_ += 0.1 * (std::min(timing_.shown, 0.1) - latency_);
    };
    timing_.record += to_seconds(now() - acquired);
    if (target->memory.first) {
      output_->present(drawn, [this, slot = ring_.slot(), seen_at] {
        ring_.wait(device_, slot);
        compositor_->compose(slot);
        seen_at(0);
      });
    } else {
      const Nanos handed = now();
      output_->present(drawn, {});
      timing_.record += to_seconds(now() - handed);
      seen_at(timing_.gpu);
    }
  } else {
    missed_ = true;
    ring_.submit(device_);
  }
  if (!options_.window) {
    ring_.wait_idle(device_);
    gpu_times_ = renderer_->gpu_times(ring_.slot());
    timing_.gpu = 1e-3 * gpu_times_.frame;
  }
  return stats;
}

void PictureStage::set_quality(const render::Quality& quality) {
  vkDeviceWaitIdle(device_.device);
  options_.quality = quality;
  blank_ = true;
  renderer_->set_quality(quality);
}

render::Picture PictureStage::eye(int index) {
  ring_.wait_idle(device_);
  const gpu::Image& image = renderer_->pictures();
  const int layer = std::min(index, static_cast<int>(image.options.layers) - 1);
  return {{static_cast<int>(image.options.size.width), static_cast<int>(image.options.size.height)},
          gpu::read_back(device_, image, static_cast<std::uint32_t>(layer), VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL)};
}

void PictureStage::write_over(render::Picture& picture) const {
  display::Writing writing;
  writing.write(hud_, picture.size);
  for (const display::Writing::Panel& panel : writing.panels())
    display::Writing::lay_over(panel, picture.rgba.data(), 4 * static_cast<std::size_t>(picture.size.x), {0, 0},
                               /*blue_first=*/false);
}

render::Picture PictureStage::screen() {
  ring_.wait_idle(device_);
  return {output_->size(), output_->read()};
}

}  // namespace typodont
