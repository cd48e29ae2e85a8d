#include "engine/app/live/live_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <thread>
#include <utility>

#include "engine/app/picture/tissue_view.h"
#include "engine/base/log.h"

namespace typodont {

namespace {

using namespace std::chrono_literals;

// ns; if the GPU device is lost and was created again less than this time ago, it is assumed to be broken and is not
// created again
constexpr Nanos kReviveInterval = 10 * kNanosPerSecond;
// ns, time between two searches for changed bricks (mesh blocks) while the pictures are drawn by the CPU
constexpr Nanos kProcessorMeshInterval = 33'000'000;
// ns; while nothing is drawn, the program checks in this interval whether something has moved
constexpr Nanos kBriefWait = 4'000'000;
constexpr Nanos kOwnInterval = 30'000'000;  // ns, time between two pictures from the free viewpoint
// ns, shortest time between two of the trainee's pictures if the CPU draws them for the operator's window. Then the
// pictures, the servo thread and the drawing of the window share the processors.
constexpr Nanos kProcessorInterval = 30'000'000;
constexpr int kImplantSections = 2;  // number of sections through an implant: along the arch, and across it
// The section follows the drill only if the drill has rotated or moved farther than this.
constexpr double kSectionTurns = 0.02;    // rad, smallest rotation of the drill that the section follows
constexpr double kSectionMoves = 0.1e-3;  // m, smallest motion of the drill that the section follows

}  // namespace

LivePicture::LivePicture(const Scene& scene, const Options& options, LiveSession& session, const dvec3& above,
                         bool left_hand)
    : scene_(scene),
      options_(options),
      session_(session),
      above_(above),
      left_hand_(left_hand),
      left_(session.wiring.tapes.left),
      shown_(scene.servo),
      around_(make_surroundings(scene.surroundings)),
      reach_(tissue_reach(scene, session.carver.volume())),
      views_(std::make_unique<LiveViews>(scene, session.carver.volume(), around_, session.wiring, session.operated)),
      revived_(-kReviveInterval) {
  if (!options.quality.empty()) ladder_ = QualityLadder::fixed_at(options.quality);
  if (left_hand || scene.mouth_mirror.diameter > 0) fog_ = mirror_fog_of(scene);
  if (!session.gum) return;
  gum_.emplace(session.gum, around_);
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
  debris_.emplace(scene_.servo.materials, session_.carver.volume(), water_of(scene_, around_));
  debris_->use(&stage_->device());
  suck(scene_.suction_on);
  explanations.push_back(debris_->cloud()       ? "debris: moved by the GPU"
                         : debris_->has_spray() ? "debris: moved by the processor, with spray and film"
                                                : "debris: moved by the processor, which also draws");
}

void LivePicture::make(gpu::Device* device) {
  if (!rig_) return;
  PictureStage::Options look;
  look.window = !options_.embedded;
  look.embedded = options_.embedded;
  look.hud = !options_.operated;  // if the operator's window shows the texts, they are not drawn over the picture
  look.force_in_hud = !options_.steered;
  look.device = device;
  look.cursor = options_.cursor;
  look.monitor = options_.monitor;
  look.language = options_.language;
  look.quality = ladder_.step();
  look.handpieces = scene_.handpieces;
  stage_.emplace(*rig_, shown_, look);
  if (stage_->device().processor && ladder_.changes() == 0 && !ladder_.fixed()) {
    ladder_ = QualityLadder::for_processor();
    stage_->set_quality(ladder_.step());
  }
  stage_->surround(around_);
  stage_->hold_mirror(scene_.mouth_mirror);
  stage_->hold_suction(scene_.suction_tip);
  views_->attach(Eyes::kTrainee, &*stage_);
  if (debris_) debris_->use(&stage_->device());
}

void LivePicture::drop() {
  if (debris_) debris_->use(nullptr);
  if (views_) views_->attach(Eyes::kTrainee, nullptr), views_->attach(Eyes::kOwn, nullptr);
  own_stage_.reset();
  stage_.reset();
}

std::optional<DebrisBalance> LivePicture::settle_debris() {
  return debris_ ? std::optional(debris_->settle()) : std::nullopt;
}

void LivePicture::close() {
  views_.reset();
  own_stage_.reset();
}

bool LivePicture::recreate_lost_device() {
  if (now() - revived_ < kReviveInterval) return false;
  revived_ = now();
  drop();
  make(nullptr);
  return true;
}

void LivePicture::color(Tissue tissue, const dvec3& color) {
  shown_.materials[static_cast<std::size_t>(tissue)].color = color;
  views_->attach(Eyes::kOwn, nullptr);
  own_stage_.reset();
  if (!stage_) return;
  views_->attach(Eyes::kTrainee, nullptr);
  stage_.reset();
  make(options_.device);
}

/// Switches the suction on or off. The suction nozzle lies beside the tooth.
void LivePicture::suck(bool on) {
  sucking_ = on;
  // m, distance of the nozzle from the tooth; the nozzle lies behind the tooth as the trainee sees it
  constexpr double kBeside = 9e-3;
  debris::Suction nozzle = scene_.suction.value_or(debris::Suction{.p_W = above_ + dvec3(0, kBeside, 0)});
  if (X_WL_ && hand_holds_suction(scene_)) nozzle.p_W = X_WL_->p;
  debris_->suck(on ? std::optional(nozzle) : std::nullopt);
}

double LivePicture::suction_flow() const {
  return sucking_ ? scene_.suction.value_or(debris::Suction{}).flow : 0;
}

void LivePicture::switch_spray() {
  if (debris_) debris_->spray(!debris_->spraying());
}

void LivePicture::switch_suction() {
  if (debris_) suck(!sucking_);
}

void LivePicture::look_from(const Viewpoint& from, glm::ivec2 pixels) {
  own_from_ = clamped(from);
  own_size_ = pixels.x > 0 ? glm::max(pixels, glm::ivec2(16)) : glm::ivec2(0);
}

void LivePicture::show_next_view(const ServoTick& tick) {
  using render::View;
  constexpr std::array kOrder{View::kLook, View::kSection, View::kXray, View::kDifference};
  Look next = views_->look(Eyes::kTrainee);
  if (scene_.implant && next.view == View::kSection && ++implant_section_ < kImplantSections) {
    next.plane = section_through_implant(tick);
    views_->look(Eyes::kTrainee, next);
    return;
  }
  implant_section_ = 0;
  const auto now_at = std::find(kOrder.begin(), kOrder.end(), next.view);
  const bool last = now_at + 1 == kOrder.end() || (now_at[1] == View::kDifference && !views_->has_ideal());
  next.view = last ? View::kLook : now_at[1];
  if (next.view == View::kSection && scene_.implant) {
    next.plane = section_through_implant(tick);
  } else if (next.view == View::kSection) {
    // The section plane is vertical, passes through the bur and faces the viewer. The tissue behind the plane is kept.
    const dvec3 away = stage_->rig().head.eye_center - tick.X_WG.p, level(away.x, away.y, 0);
    const dvec3 n = glm::length(level) > 0.2 * glm::length(away) ? -glm::normalize(level) : dvec3(0, 1, 0);
    next.plane = {n, -glm::dot(n, tick.X_WG.p)};
  }
  views_->look(Eyes::kTrainee, next);
}

/// Returns a section plane, along the arch or across it. The plane contains the drill's axis if the drill is in its bed
/// (drilled hole), otherwise the axis of the planned implant. (x points along the arch and y to the tongue;
/// docs/scene_format.md, "bone".)
glm::dvec4 LivePicture::section_through_implant(const ServoTick& tick) const {
  const bool in_bed = tick.level != session::implant_level::kFree && tick.level != session::implant_level::kPlaced;
  const dvec3 axis = in_bed ? tick.X_WG.R * dvec3(0, 0, -1) : scene_.implant->plan.axis_W;
  const dvec3 through = in_bed ? tick.X_WG.p : scene_.implant->plan.entry_W;
  const dvec3 n = glm::normalize(glm::cross(axis, implant_section_ == 0 ? dvec3(1, 0, 0) : dvec3(0, 1, 0)));
  const double side = glm::dot(through - stage_->rig().head.eye_center, n) < 0 ? -1 : 1;
  return {side * n, -side * glm::dot(n, through)};
}

/// Updates the section plane when a drill enters or leaves its bed (the drilled hole), or moves in it.
void LivePicture::follow_implant(const ServoTick& tick) {
  if (!scene_.implant || !stage_ || options_.operated) return;
  Look look = views_->look(Eyes::kTrainee);
  if (look.view != render::View::kSection) return;
  const glm::dvec4 plane = section_through_implant(tick);
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
  }
  views_->advance();
}

MouthMirror LivePicture::mirror_for(const Look& look) {
  if (!look.mirror) return {};
  MouthMirror mirror = scene_.mouth_mirror;
  if (left_hand_ && !hand_holds_suction(scene_)) mirror = X_WL_ ? held(scene_.mouth_mirror, *X_WL_) : MouthMirror();
  if (fog_ && mirror.diameter > 0) mirror.fog = fog_->fog();
  return mirror;
}

SuctionTip LivePicture::tip_for(const Look& look) {
  if (!look.debris) return {};
  SuctionTip tip = scene_.suction_tip;
  if (!left_hand_ || !hand_holds_suction(scene_)) return tip;
  if (!X_WL_) return {};
  tip.X_WS = *X_WL_;
  return tip;
}

/// Records the state of the water and of the suction whenever it changes.
void LivePicture::record_water() {
  const Nanos zero = session_.wiring.session_zero;
  if (zero == 0) return;
  const WaterSwitch present{now() - zero, spraying(), sucking_};
  if (water_ && water_->spray == present.spray && water_->suction == present.suction) return;
  session_.wiring.tapes.view.write(present);
  water_ = present;
}

/// Stores which pictures show the tissue. The carver thread meshes tissue only if a picture shows it.
void LivePicture::update_tissue_visibility() {
  const auto sees = [&](Eyes eyes, const PictureStage* stage) {
    session_.wiring.tissue_in_sight[static_cast<std::size_t>(eyes)] = stage && stage->in_sight(reach_);
  };
  if (rig_) sees(Eyes::kTrainee, stage_ && !in_one_window() ? &*stage_ : nullptr);
  sees(Eyes::kOwn, own_stage_ ? &*own_stage_ : nullptr);
}

void LivePicture::draw_own(const ServoTick& tick, double dt, WorkCounts& work) {
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
    look.cursor = options_.cursor;
    look.device = options_.device;
    look.quality = ladder_.step();
    look.handpieces = scene_.handpieces;
    own_stage_.emplace(rig_of(own_from_, views_->middle(), own_size_), shown_, look);
    own_stage_->surround(around_);
    views_->attach(Eyes::kOwn, &*own_stage_);
    views_->advance();
  }
  own_stage_->resize(own_size_);
  own_stage_->look_from(rig_of(own_from_, views_->middle(), own_size_));
  const Look& look = views_->look(Eyes::kOwn);
  own_stage_->hold_mirror(mirror_for(look));
  own_stage_->hold_suction(tip_for(look));
  const bool chips = debris_ && look.debris;
  const auto particles = chips ? debris_->particles() : std::span<const render::Particle>{};
  own_stage_->show_film(chips ? debris_->film() : nullptr);
  const auto stats = own_stage_->draw(tick, particles, dt);
  if (!stats.drawn) return;
  ++own_frames_;
  count_frame(stats, work);
  if (in_one_window() || !stage_) frame_shown();
}

void LivePicture::move_debris(const ServoTick& tick, double dt, WorkCounts& work) {
  const std::span tools = haptics::tool_set(scene_.servo);
  debris_->hold(tick, tools[tick.tool]);
  debris_->step(std::min(dt, 0.1));
  debris_->count(work);
  record_water();
}

/// Updates the picture of the soft gum, which the tool deforms.
void LivePicture::follow_gum(const ServoTick& tick) {
  gum_->follow(tick.t);
  if (stage_) stage_->show_gum(*gum_);
  if (own_stage_) own_stage_->show_gum(*gum_);
}

void LivePicture::apply(const ServoEvent& event) {
  if (const auto* const cut = std::get_if<Cut>(&event); cut && debris_) {
    debris_->add(*cut, haptics::tool_set(scene_.servo)[cut->tool]);
  } else if (gum_) {
    gum_->apply(event);
  }
}

void LivePicture::apply(const CarverEvent& event) {
  if (const auto* const piece = std::get_if<LoosePiece>(&event); piece && debris_) debris_->add(*piece);
}

void LivePicture::draw(const ServoTick& tick, const std::string& hint, WorkCounts& work) {
  if (frames_ > 0 && ++turns_since_first_ == 2)
    // Stores the time at which the first picture is certainly on the screen. The window shows a frame at the latest at
    // the second poll() after drawing it. So this time may be a little too late, but not too early.
    first_shown_ = now();
  if (options_.embedded && !in_one_window() && stage_->device().processor && !stage_->blank() &&
      now() - drawn_turn_ < kProcessorInterval)
    return;
  collect();
  const double dt = to_seconds(now() - last_turn_);
  last_turn_ = now();
  if (debris_) move_debris(tick, dt, work);
  if (haptics::HandSample sample; left_.newest(sample)) {
    X_WL_ = sample.X_WT;
    if (hand_holds_suction(scene_) && debris_) suck(sucking_);
  }
  if (fog_) {
    const MouthMirror mirror = mirror_for({});
    fog_->advance(std::min(dt, 0.1), mirror, fog_->air(mirror, tick, debris_ && debris_->spraying()));
  }
  follow_implant(tick);
  if (gum_) follow_gum(tick);
  draw_own(tick, dt, work);
  if (in_one_window()) {
    frame_seconds_ += 0.1 * (to_seconds(now() - last_turn_) - frame_seconds_);
    return std::this_thread::sleep_for(4ms);
  }
  const Look& look = views_->look(Eyes::kTrainee);
  stage_->hold_mirror(mirror_for(look));
  stage_->hold_suction(tip_for(look));
  const bool chips = debris_ && look.debris;
  stage_->show_cloud(chips ? debris_->cloud() : nullptr);
  stage_->show_film(chips ? debris_->film() : nullptr);
  const auto stats = stage_->draw(tick, chips ? debris_->particles() : std::span<const render::Particle>{}, dt, hint);
  frames_ += stats.drawn;
  record_view();
  if (stats.drawn) {
    drawn_turn_ = last_turn_;
    count_frame(stats, work);
    follow(stats, dt, tick);
    return;
  }
  drew_last_ = false;
  if (options_.embedded) return;  // the operator's window itself waits between two frames
  // After half a second without motion, the loop checks only forty times per second whether the hand moves; this saves
  // computing time. A mouse event ends the wait between two checks early. Other hands do not end this wait, because
  // some of them send a thousand events per second.
  if (last_turn_ - last_drawn_ > kNanosPerSecond / 2) stage_->output().wait(25'000'000);
  if (now() - last_turn_ < kBriefWait) std::this_thread::sleep_for(std::chrono::nanoseconds(kBriefWait));
}

/// Chooses the level of detail and the quality of the next frame of the trainee's picture, from measurements of its
/// present frame. The time of other pictures does not count, so they do not reduce the quality of the trainee's
/// picture.
void LivePicture::follow(const render::FrameStats& stats, double dt, const ServoTick& tick) {
  Wiring& wiring = session_.wiring;
  if (detail_->follow(stats.pixel, ladder_.step())) wiring.tolerance = detail_->tolerance();
  frame_shown();
  const PictureStage::Timing& took = stage_->timing();
  frame_seconds_ += 0.1 * (took.cost() - frame_seconds_);
  // Computes the age of the hand's sample at the beginning of the frame.
  const Nanos zero = wiring.session_zero.load(std::memory_order_relaxed);
  const double age = zero ? std::max(to_seconds(last_turn_ - zero - tick.t), 0.0) : 0.0;
  photon_seconds_ += 0.1 * (age + took.shown - photon_seconds_);
  if (zero != 0)
    wiring.tapes.view.write(
        PictureTiming{last_turn_ - zero, dt, took.record, took.gpu, age + took.shown, stats.redrawn, ladder_.place()});
  // With software rendering, the CPU also composes and presents the picture. The cost of a frame must include this
  // work, so it is measured as the time between two consecutive frames.
  const bool on_end = std::exchange(drew_last_, true) && stage_->device().processor && !options_.embedded;
  // While nothing moves in the picture, a frame redraws only a few bricks (mesh blocks) and takes a short time. This
  // short time must not raise the quality. Otherwise the quality would fall again as soon as something moves.
  const bool refined = stats.redrawn < 1 && stage_->tool_at_rest() && tick.cuts == ladder_cuts_;
  ladder_cuts_ = tick.cuts;
  if (!refined && ladder_.frame_took(on_end && dt > ladder_.slow() ? std::max(dt, took.cost()) : took.cost())) {
    stage_->set_quality(ladder_.step());
    log::info("picture quality: {}, because a frame took {:.0f} ms", ladder_.step().name, 1e3 * frame_seconds_);
  }
}

/// Updates the mean interval between frames after a frame was shown.
void LivePicture::frame_shown() {
  const Nanos t = now();
  if (last_drawn_) frame_period_ += 0.1 * (std::min(to_seconds(t - last_drawn_), 1.0) - frame_period_);
  last_drawn_ = t;
}

/// Writes the viewpoint and the view to the tape whenever they change.
void LivePicture::record_view() {
  const Nanos zero = session_.wiring.session_zero;
  if (zero == 0) return;
  const display::Head& head = stage_->rig().head;
  const SeenFrom now_seen{now() - zero, head.eye_center, head.right, head.ipd, stage_->view()};
  if (seen_ && seen_->eye_W == now_seen.eye_W && seen_->right_W == now_seen.right_W && seen_->view == now_seen.view)
    return;
  session_.wiring.tapes.view.write(now_seen);
  seen_ = now_seen;
}

}  // namespace typodont
