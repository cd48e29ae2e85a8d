#include "engine/app/picture/debris_view.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "engine/base/voxels.h"

namespace typodont {

namespace {

// Grid spacing of the distance field from which chips bounce off, m. It may be coarse, because details of a cavity do
// not matter for bouncing.
constexpr double kCoarse = 4e-4;
// Grid spacing of the distance field on which the film of water flows, m. Finer cells need more substeps: with 0.3 mm
// and as many substeps, a ball under a spray of 50 ml/min holds twice as much water.
constexpr double kFilm = 5e-4;
constexpr double kFilmShown = 0.05;  // s, interval of updates of the water film's picture
// The head's cut is applied to the water's distance field each time that the head has moved this far, m.
constexpr double kCutSteps = 0.1e-3;
constexpr double kPressed = 0.05;  // the handpiece sprays if the pedal's position (0 to 1) is larger than this
constexpr float kMinShown =
    3e-5f;  // m, smallest drawn diameter; a smaller particle is drawn with this one, but fainter
// The finest chips are drawn as mist, large and transparent. The values must equal those in shaders/debris.comp.
constexpr float kMistChip = 12e-6f;  // m, radius; a smaller chip is drawn as mist
// Number of cuts whose chips the CPU creates together, because many chips
// would take too long to move. Each chip then represents more mass.
constexpr int kLumps = 8;
constexpr float kMistWidth = 2.5f, kMistOpacity = 0.16f;

}  // namespace

WaterPlan water_of(const Scene& scene, const Surroundings& around) {
  return {scene.spray, scene.spray_on, around.covered};
}

DebrisView::Water::Water(const debris::CoarseField& field, const MaterialTable& materials, const WaterPlan& plan,
                         std::uint64_t version)
    : film(field, materials, {.drain = plan.drain}), spray(*plan.nozzles), picture(field, version) {}

DebrisView::DebrisView(const MaterialTable& materials, const haptics::TissueVolume& tissue, const WaterPlan& water)
    : materials_(materials), plan_(water) {
  // Copies every n-th sample of the volume to the coarse distance field. The samples of both fields are at the same
  // points, so no interpolation is needed.
  glm::ivec3 lo, hi;
  tissue.bounds(lo, hi);
  if (lo.x > hi.x) return;
  const VoxelFrame& frame = tissue.frame();
  const int every = std::max(
      1, static_cast<int>(water.nozzles ? std::round(kFilm / frame.voxel) : std::floor(kCoarse / frame.voxel)));
  const glm::ivec3 size = hi - lo + 1;
  std::vector<float> fine(voxel_count(size));
  tissue.copy(lo, size, fine.data(), nullptr);
  field_.size = (size + every - 1) / every;
  field_.origin = frame.to_world(dvec3(lo));
  field_.spacing = every * frame.voxel;
  distance_.reserve(voxel_count(field_.size));
  for (int x = 0; x < size.x; x += every) {
    for (int y = 0; y < size.y; y += every) {
      for (int z = 0; z < size.z; z += every)
        distance_.push_back(fine[voxel_index({x, y, z}, size)] * static_cast<float>(frame.voxel));
    }
  }
  field_.distance = distance_.data();
  uncut_ = distance_;
  restart();
}

void DebrisView::restart() {
  std::copy(uncut_.begin(), uncut_.end(), distance_.begin());
  debris_ = debris::Debris(options_);
  batched_ = 0;
  batch_removed_ = {};
  if (!plan_.nozzles || uncut_.empty()) return;
  const std::uint64_t version = water_ ? water_->picture.version() + 1 : 0;
  water_.emplace(field_, materials_, plan_, version);
  spraying_ = plan_.on;
}

void DebrisView::use(gpu::Device* device) {
  cloud_.reset();
  if (!device || device->processor || water_) return;
  newborn_.resize(static_cast<std::size_t>(kTissueCount) * static_cast<std::size_t>(options_.max_per_cut));
  cloud_.emplace(*device, cloud_law(options_, field_, kMinShown), distance_);
  suck(suction_);
}

void DebrisView::suck(const std::optional<debris::Suction>& suction) {
  suction_ = suction;
  if (!cloud_) return;
  const debris::Suction off{.p_W = {}, .flow = 0, .radius = 0};
  const debris::Suction& s = suction_ ? *suction_ : off;
  cloud_->suck(s.p_W, s.flow, s.radius);
}

render::CloudLaw cloud_law(const debris::DebrisOptions& options, const debris::CoarseField& field, double min_shown) {
  return {.capacity = options.capacity,
          .gravity = options.gravity_W,
          .air_density = options.air_density,
          .air_viscosity = options.air_viscosity,
          .restitution = options.restitution,
          .slide = options.slide,
          .decay_time = options.decay_time,
          .lifetime = options.lifetime,
          .min_shown = min_shown,
          .origin = field.origin,
          .spacing = field.spacing,
          .size = field.size};
}

render::CloudParticle cloud_particle(const debris::NewParticle& n, const dvec3& color) {
  render::CloudParticle out{.p = glm::vec3(n.p_W),
                            .v = glm::vec3(n.v_W),
                            .mass = n.mass,
                            .chip = static_cast<float>(n.chip),
                            .density = static_cast<float>(n.density)};
  for (int i = 0; i < 3; ++i) out.color[i] = static_cast<std::uint8_t>(std::clamp(color[i], 0.0, 1.0) * 255 + 0.5);
  return out;
}

void DebrisView::add(const Cut& cut, const haptics::Tool& tool, double area, double duration) {
  if (cut.fill_radius != 0) return;
  if (water_) carve(cut, tool);
  if (rests_) return;
  for (std::size_t t = 0; t < kTissueCount; ++t) batch_removed_[t] += cut.removed[t];
  last_ = cut;
  batch_.head_radius = tool.radius();
  batch_.area += (area - batch_.area) / (batched_ + 1);
  batch_.duration += duration;
  if (++batched_ >= (cloud_ ? 1 : kLumps)) emit_batch();
}

void DebrisView::emit_batch() {
  if (std::exchange(batched_, 0) == 0) return;
  last_.removed = std::exchange(batch_removed_, {});
  emit(last_, std::exchange(batch_, {}));
}

void DebrisView::rest(bool rests) {
  if (rests) emit_batch();
  rests_ = rests;
}

void DebrisView::add(const LoosePiece& piece) {
  if (rests_) return;
  Cut cut;
  cut.index = piece.cut;
  cut.X_WA.p = cut.X_WB.p = piece.center_W;
  cut.removed = piece.removed;
  emit(cut, {.head_radius = piece.radius});
}

/// Applies a cut to the coarse distance field, so that water flows into the cavity.
void DebrisView::carve(const Cut& cut, const haptics::Tool& tool) {
  Water& water = *water_;
  if (water.tool != cut.tool) {
    water.tool = cut.tool;
    water.head = haptics::HeadField(tool, 1);
    water.reach = tool.reach();
  }
  water.uncut = cut.X_WB;
  if (!water.cut_at || glm::length(cut.X_WB.p - water.cut_at->p) > kCutSteps) carve_pending();
}

void DebrisView::carve_pending() {
  Water& water = *water_;
  if (!water.uncut) return;
  const Pose X_WB = *std::exchange(water.uncut, std::nullopt), X_BW = inverse(X_WB);
  water.cut_at = X_WB;
  const double reach = water.reach + 2 * field_.spacing;
  const auto sample = [&](const dvec3& p) { return glm::ivec3(glm::floor((p - field_.origin) / field_.spacing)); };
  const glm::ivec3 lo = glm::max(sample(X_WB.p - reach), glm::ivec3(0)),
                   hi = glm::min(sample(X_WB.p + reach) + 1, field_.size - 1);
  bool changed = false;
  for_each_voxel_between(lo, hi, [&](int x, int y, int z) {
    float& d = distance_[voxel_index({x, y, z}, field_.size)];
    const auto outside =
        static_cast<float>(-water.head.distance(X_BW * (field_.origin + field_.spacing * dvec3(x, y, z))));
    if (outside <= d) return;
    d = outside;
    changed = true;
  });
  if (changed) water.film.update(lo, hi);
}

void DebrisView::hold(const ServoTick& tick, const haptics::Tool& tool) {
  if (!water_) return;
  water_->bur = tool.turns();
  water_->source = {.X_WT = tick.X_WG,
                    .head_radius = tool.radius(),
                    .head_half = tool.half(),
                    .spindle = tick.spindle,
                    .water = spraying_ && std::abs(tick.pedal) > kPressed && tick.spindle != 0 ? 1.0 : 0.0};
}

void DebrisView::count(WorkCounts& work) {
  work.particles_stepped += alive();
  if (!water_) return;
  work.droplets_stepped +=
      water_->spray.droplets_stepped() - std::exchange(water_->droplets, water_->spray.droplets_stepped());
  work.film_cells_stepped += water_->film.cells_stepped() - std::exchange(water_->cells, water_->film.cells_stepped());
  work.film_texels +=
      water_->picture.texels_written() - std::exchange(water_->texels, water_->picture.texels_written());
}

DebrisBalance DebrisView::settle() {
  emit_batch();
  debris::DebrisLedger ledger = debris_.ledger();
  double given = 0;
  for (std::size_t t = 0; t < kTissueCount; ++t) ledger.born[t] += given_[t], given += given_[t];
  ledger.dropped += given_dropped_;
  if (given > 0) ledger.alive = ledger.decayed = ledger.sucked = std::numeric_limits<double>::quiet_NaN();
  if (!water_) return {ledger, std::nullopt, std::nullopt, 0};
  return {ledger, water_->spray.ledger(), water_->film.ledger(), 0};
}

void DebrisView::emit(const Cut& cut, const debris::CutContact& contact) {
  if (!cloud_) return debris_.emit(cut, contact, materials_);
  const std::size_t count =
      debris::create_particles(cut, contact, materials_, options_, cloud_->room(), newborn_, given_, given_dropped_);
  for (const debris::NewParticle& n : std::span(newborn_).first(count)) {
    const render::CloudParticle particle = cloud_particle(n, materials_[static_cast<std::size_t>(n.tissue)].color);
    cloud_->add({&particle, 1});
  }
}

void DebrisView::step(double dt) {
  if (rests_) return;
  if (cloud_) return cloud_->advance(dt);
  const debris::Suction* suction = suction_ ? &*suction_ : nullptr;
  if (!water_) return debris_.step(dt, field_, suction);
  Water& water = *water_;
  carve_pending();
  water.spray.step(dt, water.bur ? &water.source : nullptr, field_, water.film, suction);
  debris_.step(dt, field_, suction, &water.film);
  water.film.step(dt, suction);
  water.since_shown += dt;
  if (water.since_shown < kFilmShown) return;
  water.since_shown = 0;
  water.picture.update(water.film);
}

std::span<const render::Particle> DebrisView::particles() {
  points_.resize(debris_.alive());
  const std::size_t count = debris_.write_points(points_);
  particles_.clear();
  if (water_) add_droplets();
  for (std::size_t i = 0; i < count; ++i) {
    const debris::DebrisPoint& point = points_[i];
    const bool mist = point.chip < kMistChip;
    const float fraction = std::min(1.0f, point.diameter / kMinShown) * (mist ? kMistOpacity : 1.0f);
    particles_.push_back({point.p_W, std::max(point.diameter, kMinShown) / 2 * (mist ? kMistWidth : 1.0f),
                          glm::vec3(materials_[static_cast<std::size_t>(point.tissue)].color), fraction});
  }
  return particles_;
}

void DebrisView::add_droplets() {
  constexpr glm::vec3 kWater(0.86f, 0.91f, 0.95f);  // sRGB, colour of water in the light of the lamp
  constexpr float kOpacity = 0.4f, kSlurryOpacity = 0.6f;
  constexpr float kThin = 0.5f;  // width of a moving droplet's streak, as a fraction of its diameter
  droplets_.resize(water_->spray.alive());
  const std::size_t count = water_->spray.write_points(droplets_);
  for (const debris::DebrisPoint& drop : std::span(droplets_).first(count)) {
    const bool water = drop.tissue == Tissue::kAir;
    const glm::vec3 solid(materials_[static_cast<std::size_t>(drop.tissue)].color);
    particles_.push_back({.p = drop.p_W,
                          .radius = kThin * drop.diameter / 2,
                          .color = water ? kWater : glm::mix(kWater, solid, 0.7f),
                          .opacity = water ? kOpacity : kSlurryOpacity,
                          .streak = drop.streak_W});
  }
}

}  // namespace typodont
