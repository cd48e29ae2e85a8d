#include "engine/app/live/live_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

#include "engine/app/picture/hud.h"
#include "engine/app/picture/tissue_view.h"
#include "engine/base/log.h"

namespace typodont {

namespace {

using namespace std::chrono_literals;

// Time between two searches for changed mesh bricks (blocks of the surface) while the CPU draws the pictures, ns.
constexpr Nanos kProcessorMeshInterval = 33'000'000;
// Time between checks for motion while nothing is drawn, ns.
constexpr Nanos kBriefWait = 4'000'000;
constexpr Nanos kOwnInterval = 30'000'000;  // ns, time between two pictures from the free viewpoint
// Shortest time between two of the trainee's pictures if the CPU draws them for the operator's window, ns. The pictures
// then share the processors with the servo thread and the window.
constexpr Nanos kProcessorInterval = 30'000'000;
// Period that counts as that of the display, s: with software rendering, and if the operator's window shows the
// picture.
constexpr double kProcessorPeriod = 1.0 / 30, kEmbeddedPeriod = 1.0 / 60;
constexpr int kImplantSections = 2;  // sections through an implant: along and across the arch
// The section follows the drill only after a rotation or motion larger than these limits.
constexpr double kSectionTurns = 0.02;    // rad, smallest rotation of the drill that the section follows
constexpr double kSectionMoves = 0.1e-3;  // m, smallest motion of the drill that the section follows

}  // namespace

LivePicture::LivePicture(const Scene& scene, const Options& options, LiveSession& session, const ServoTick& start)
    : scene_(scene),
      options_(options),
      session_(session),
      world_(scene, session.gum),
      left_(session.wiring.event_logs.left),
      shown_(scene.servo),
      reach_(tissue_reach(scene, session.carver.volume())),
      views_(std::make_unique<LiveViews>(scene, session.carver.volume(), world_.surroundings(), session.wiring,
                                         session.operated)),
      revived_(-gpu::kReviveInterval) {
  world_.place(start);
  if (!options.quality.empty()) ladder_ = QualityLadder::fixed_at(options.quality);
}

void LivePicture::open(const display::DisplayRig& rig, std::vector<std::string>& explanations) {
  rig_ = &rig;
  make(options_.device);
  const double voxel = session_.carver.volume().frame().voxel;
  detail_.emplace(surface_tolerance(rig, voxel, ladder_.step()), voxel);
  session_.wiring.tolerance = detail_->tolerance();
  if (stage_->device().processor) session_.mesh_interval = kProcessorMeshInterval;
  explanations.push_back("drawn by " + stage_->device_name());
  explanations.push_back(ladder_.fixed() ? fmt::format("picture quality: fixed at \"{}\"", ladder_.step().name)
                                         : fmt::format("picture quality: starts at \"{}\"; lower while a frame takes "
                                                       "over {:.0f} ms, higher when there is time",
                                                       ladder_.step().name, 1e3 * ladder_.slow()));
  explanations.push_back(rig.head.tracker.empty() ? "head: fixed, the rig names no tracker"
                                                  : "head: " + rig.head.tracker);
  update_tissue_visibility();
  if (!session_.debris) return;
  world_.add_debris(session_.carver.volume());
  DebrisView& debris = *world_.debris();
  debris.use(&stage_->device());
  explanations.push_back(debris.cloud()       ? "debris: moved by the GPU"
                         : debris.has_spray() ? "debris: moved by the processor, with spray and film"
                                              : "debris: moved by the processor, which also draws");
}

void LivePicture::make(gpu::Device* device) {
  if (!rig_) return;
  PictureStage::Options look;
  look.window = !options_.embedded;
  look.embedded = options_.embedded;
  look.urgent = options_.urgent;
  look.hud = !options_.operated;  // the picture shows texts only if the operator's window does not
  look.warnings = true;
  look.force_in_hud = !options_.steered;
  look.device = device;
  look.cursor = options_.cursor;
  look.light = MouthLight::When::kInBackground;
  look.monitor = options_.monitor;
  look.language = options_.language;
  look.quality = ladder_.step();
  look.handpieces = scene_.handpieces;
  stage_.emplace(*rig_, shown_, look);
  if (stage_->device().processor && ladder_.changes() == 0 && !ladder_.fixed()) {
    ladder_ = QualityLadder::for_processor();
    stage_->set_quality(ladder_.step());
  }
  stage_->surround(world_.surroundings());
  views_->attach(Eyes::kTrainee, &*stage_);
  if (world_.debris()) world_.debris()->use(&stage_->device());
}

void LivePicture::drop() {
  if (world_.debris()) world_.debris()->use(nullptr);
  if (views_) views_->attach(Eyes::kTrainee, nullptr), views_->attach(Eyes::kOwn, nullptr);
  own_stage_.reset();
  stage_.reset();
}

std::optional<DebrisBalance> LivePicture::settle_debris() {
  return world_.debris() ? std::optional(world_.debris()->settle()) : std::nullopt;
}

void LivePicture::close() {
  views_.reset();
  own_stage_.reset();
}

bool LivePicture::recreate_lost_device() {
  if (now() - revived_ < gpu::kReviveInterval) return false;
  revived_ = now();
  drop();
  make(nullptr);
  return true;
}

void LivePicture::switch_spray() {
  WaterSwitch water = world_.water();
  water.spray = !water.spray;
  world_.apply(water);
}

void LivePicture::switch_suction() {
  WaterSwitch water = world_.water();
  water.suction = !water.suction;
  world_.apply(water);
}

void LivePicture::look_from(const Viewpoint& from, glm::ivec2 pixels) {
  own_from_ = clamped(from);
  own_size_ = pixels.x > 0 ? glm::max(pixels, glm::ivec2(16)) : glm::ivec2(0);
}

void LivePicture::show_next_view() {
  using render::View;
  Look next = views_->look(Eyes::kTrainee);
  if (scene_.implant && next.view == View::kSection && ++implant_section_ < kImplantSections) {
    next.plane = section_through_implant();
    views_->look(Eyes::kTrainee, next);
    return;
  }
  implant_section_ = 0;
  next.view = next_view(scene_, next.view);
  if (render::cuts_section(next.view) && scene_.implant) {
    next.plane = section_through_implant();
  } else if (render::cuts_section(next.view)) {
    next.plane = section_facing(world_.tick().X_WG.p, stage_->rig().head.eye_center);
  }
  views_->look(Eyes::kTrainee, next);
}

/// A section plane, along the arch or across it, through the axis of the drill if the drill is in the implant's hole,
/// otherwise through the planned implant's axis. x points along the arch, y to the tongue (docs/scene_format.md,
/// "bone").
glm::dvec4 LivePicture::section_through_implant() const {
  const ServoTick& tick = world_.tick();
  const bool in_bed = tick.level != session::implant_level::kFree && tick.level != session::implant_level::kPlaced;
  const dvec3 axis = in_bed ? tick.X_WG.R * dvec3(0, 0, -1) : scene_.implant->plan.axis_W;
  const dvec3 through = in_bed ? tick.X_WG.p : scene_.implant->plan.entry_W;
  const dvec3 n = glm::normalize(glm::cross(axis, implant_section_ == 0 ? dvec3(1, 0, 0) : dvec3(0, 1, 0)));
  const double side = glm::dot(through - stage_->rig().head.eye_center, n) < 0 ? -1 : 1;
  return {side * n, -side * glm::dot(n, through)};
}

/// Updates the section plane when a drill enters, leaves or moves in its hole in the bone.
void LivePicture::follow_implant() {
  if (!scene_.implant || !stage_ || options_.operated) return;
  Look look = views_->look(Eyes::kTrainee);
  if (!render::cuts_section(look.view)) return;
  const glm::dvec4 plane = section_through_implant();
  const double turned = glm::length(dvec3(plane) - dvec3(look.plane)), moved = std::abs(plane.w - look.plane.w);
  if (turned < kSectionTurns && moved < kSectionMoves) return;
  look.plane = plane;
  views_->look(Eyes::kTrainee, look);
}

void LivePicture::collect() {
  MeshBatch* batch = nullptr;
  while ((session_.watched ? session_.wiring.bricks_to_watch : session_.wiring.bricks).pop(batch)) {
    const std::unique_ptr<MeshBatch> owned(batch);
    views_->take(std::move(*owned));
    has_surface_ = true;
  }
  views_->advance();
}

/// Records each change of the water's and the suction's state.
void LivePicture::record_water() {
  const Nanos zero = session_.wiring.session_zero;
  if (zero == 0) return;
  WaterSwitch current = world_.water();
  if (water_ && water_->spray == current.spray && water_->suction == current.suction) return;
  current.t = now() - zero;
  session_.wiring.event_logs.view.write(current);
  water_ = current;
}

/// Tells the carver thread which pictures show the tissue. If none does, that thread does not mesh the surface.
void LivePicture::update_tissue_visibility() {
  const auto sees = [&](Eyes eyes, const PictureStage* stage) {
    session_.wiring.tissue_in_sight[static_cast<std::size_t>(eyes)] = stage && stage->in_sight(reach_);
  };
  if (rig_) sees(Eyes::kTrainee, stage_ && !in_one_window() ? &*stage_ : nullptr);
  sees(Eyes::kOwn, own_stage_ ? &*own_stage_ : nullptr);
}

void LivePicture::draw_own(WorkCounts& work) {
  update_tissue_visibility();
  if (own_size_.x <= 0 || !options_.device) {
    if (own_stage_) {
      views_->attach(Eyes::kOwn, nullptr);
      own_stage_.reset();
    }
    return;
  }
  if (now() - own_drawn_ < kOwnInterval) return;
  own_drawn_ = now();
  if (!own_stage_) {
    PictureStage::Options look;
    look.embedded = true;
    look.hud = false;
    look.chips_on_gpu = false;
    look.cursor = options_.cursor;
    look.light = MouthLight::When::kInBackground;
    look.device = options_.device;
    look.quality = ladder_.step();
    look.handpieces = scene_.handpieces;
    own_stage_.emplace(rig_of(own_from_, views_->middle(), own_size_), shown_, look);
    own_stage_->surround(world_.surroundings());
    views_->attach(Eyes::kOwn, &*own_stage_);
    views_->advance();
  }
  own_stage_->resize(own_size_);
  own_stage_->look_from(rig_of(own_from_, views_->middle(), own_size_));
  const auto stats = own_stage_->draw(world_, views_->look(Eyes::kOwn));
  if (!stats.drawn) return;
  ++own_frames_;
  count_frame(stats, work);
  if (in_one_window() || !stage_) frame_shown();
}

void LivePicture::draw(const std::string& hint, WorkCounts& work) {
  if (frames_ > 0 && ++turns_since_first_ == 2)
    // Stores a time at which the first picture is certainly on the screen. The window shows a frame at the latest at
    // the second poll() after drawing, so this time may be a little too late, but not too early.
    first_shown_ = now();
  if (options_.embedded && !in_one_window() && stage_->device().processor && !stage_->blank() &&
      now() - drawn_turn_ < kProcessorInterval)
    return;
  collect();
  const double dt = to_seconds(now() - last_turn_);
  last_turn_ = now();
  if (haptics::HandSample sample; left_.newest(sample)) world_.apply(sample);
  if (world_.debris()) {
    world_.debris()->count(work);
    record_water();
  }
  follow_implant();
  draw_own(work);
  if (in_one_window()) {
    frame_seconds_ += 0.1 * (to_seconds(now() - last_turn_) - frame_seconds_);
    return std::this_thread::sleep_for(4ms);
  }
  world_.say(hint);
  // The quality changes only here, because the operator's window shows the last frame until this one.
  if (std::exchange(new_quality_, false)) stage_->set_quality(ladder_.step());
  const auto stats = stage_->draw(world_, views_->look(Eyes::kTrainee));
  frames_ += stats.drawn;
  record_view();
  if (stats.drawn) {
    drawn_turn_ = last_turn_;
    count_frame(stats, work);
    follow(stats, dt);
    return;
  }
  drew_last_ = false;
  if (options_.embedded) return;  // the operator's window itself waits between two frames
  // After half a second without motion, checks for motion only forty times per second, to save computing time. A mouse
  // event ends the wait early. Other hands do not, because some send a thousand events per second.
  if (last_turn_ - last_drawn_ > kNanosPerSecond / 2) stage_->output().wait(25'000'000);
  if (now() - last_turn_ < kBriefWait) std::this_thread::sleep_for(std::chrono::nanoseconds(kBriefWait));
}

/// Chooses level of detail and quality of the trainee's next picture, from measurements of its current frame. The time
/// for other pictures does not count.
void LivePicture::follow(const render::FrameStats& stats, double dt) {
  const ServoTick& tick = world_.tick();
  Wiring& wiring = session_.wiring;
  if (detail_->follow(stats.pixel, ladder_.step())) wiring.tolerance = detail_->tolerance();
  frame_shown();
  const PictureStage::Timing& took = stage_->timing();
  frame_seconds_ += 0.1 * (took.cost() - frame_seconds_);
  // Age of the hand's sample at the time when the frame begins, s.
  const Nanos zero = wiring.session_zero.load(std::memory_order_relaxed);
  const double age = zero ? std::max(to_seconds(last_turn_ - zero - tick.t), 0.0) : 0.0;
  photon_seconds_ += 0.1 * (age + took.shown - photon_seconds_);
  const bool continuous = std::exchange(drew_last_, true);
  if (zero != 0) {
    wiring.event_logs.view.write(
        PictureTiming{last_turn_ - zero, dt, took.record, took.gpu, age + took.shown, stats.redrawn, ladder_.place()});
    report_.add(stage_->gpu_times());
    if (continuous) report_.add_interval(dt, refresh_period());
  }
  // With software rendering, the CPU also composes and presents the picture. To include this work, the cost of a frame
  // is the time between two consecutive frames.
  const bool on_end = continuous && stage_->device().processor && !options_.embedded;
  // While nothing moves, a frame redraws only a few mesh bricks in a short time. This must not raise the quality,
  // because the quality would fall again as soon as something moves.
  const bool refined = stats.redrawn < 1 && stage_->tool_at_rest() && tick.cuts == ladder_cuts_;
  ladder_cuts_ = tick.cuts;
  if (!refined && ladder_.frame_took(on_end && dt > ladder_.slow() ? std::max(dt, took.cost()) : took.cost())) {
    new_quality_ = true;
    log::info("picture quality: {}, because a frame took {:.0f} ms", ladder_.step().name, 1e3 * frame_seconds_);
  }
}

RefreshPeriod LivePicture::refresh_period() {
  if (stage_->device().processor) return {kProcessorPeriod, "the CPU draws"};
  if (options_.embedded) return {kEmbeddedPeriod, "assumed for the operator's window"};
  return {stage_->output().refresh_period(), "refresh period of the monitor"};
}

std::string LivePicture::quality_notice() const {
  if (!stage_) return "";
  const VkExtent2D drawn = stage_->pictures().options.size;
  const double scale = stage_->quality().scale, pixels = drawn.width * drawn.height / (scale * scale);
  const Remedy remedy = ladder_.remedy(stage_->processor(), /*window=*/options_.monitor < 0, pixels);
  if (remedy == Remedy::kNone && ladder_.changes() == 0) return "";
  return quality_text(ladder_.step().name, remedy, options_.language);
}

/// Updates the mean frame interval after a frame was shown.
void LivePicture::frame_shown() {
  const Nanos t = now();
  if (last_drawn_) frame_period_ += 0.1 * (std::min(to_seconds(t - last_drawn_), 1.0) - frame_period_);
  last_drawn_ = t;
}

/// Writes each change of viewpoint and view to the event log.
void LivePicture::record_view() {
  const Nanos zero = session_.wiring.session_zero;
  if (zero == 0) return;
  const display::Head& head = stage_->rig().head;
  const SeenFrom now_seen{now() - zero, head.eye_center, head.right, head.ipd, stage_->view()};
  if (seen_ && seen_->eye_W == now_seen.eye_W && seen_->right_W == now_seen.right_W && seen_->view == now_seen.view)
    return;
  session_.wiring.event_logs.view.write(now_seen);
  seen_ = now_seen;
}

}  // namespace typodont
