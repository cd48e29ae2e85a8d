#include "engine/app/picture/debris_view.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace typodont {

namespace {

constexpr double kCoarse = 4e-4;      // m, spacing of the field for chips, which ignore the fine detail of a cavity
constexpr float kLeastShown = 3e-5f;  // m; smaller particles are drawn in this size but fainter
// The finest chips are drawn as mist: large and transparent. The values must equal those in shaders/debris.comp.
constexpr float kMistChip = 12e-6f;  // m, radius below which a chip is drawn as mist
constexpr int kLumps = 8;            // number of cuts whose chips are created together with software rendering
constexpr float kMistWidth = 2.5f, kMistOpacity = 0.16f;

}  // namespace

DebrisView::DebrisView(const MaterialTable& materials, const haptics::TissueVolume& tissue) : materials_(materials) {
  // Take every n-th sample of the volume, so that no interpolation is needed.
  glm::ivec3 lo, hi;
  tissue.bounds(lo, hi);
  if (lo.x > hi.x) return;
  const VoxelFrame& frame = tissue.frame();
  const int every = std::max(1, static_cast<int>(kCoarse / frame.voxel));
  const glm::ivec3 size = hi - lo + 1;
  std::vector<float> fine(static_cast<std::size_t>(size.x) * size.y * size.z);
  tissue.copy(lo, size, fine.data(), nullptr);
  field_.size = (size + every - 1) / every;
  field_.origin = frame.to_world(dvec3(lo));
  field_.spacing = every * frame.voxel;
  distance_.reserve(static_cast<std::size_t>(field_.size.x) * field_.size.y * field_.size.z);
  for (int x = 0; x < size.x; x += every) {
    for (int y = 0; y < size.y; y += every) {
      for (int z = 0; z < size.z; z += every) {
        const std::size_t i =
            (static_cast<std::size_t>(x) * size.y + static_cast<std::size_t>(y)) * size.z + static_cast<std::size_t>(z);
        distance_.push_back(fine[i] * static_cast<float>(frame.voxel));
      }
    }
  }
  field_.distance = distance_.data();
}

void DebrisView::use(gpu::Device* device) {
  cloud_.reset();
  // With software rendering, a chip takes as much time to draw as some triangles of the tooth. Therefore fewer chips
  // are created, each with more mass.
  batch_size_ = device && device->processor ? kLumps : 1;
  if (!device || device->processor) return;
  newborn_.resize(static_cast<std::size_t>(kTissueCount) * static_cast<std::size_t>(options_.most_per_cut));
  cloud_.emplace(*device, cloud_law(options_, field_, kLeastShown), distance_);
  suck(suction_);
}

void DebrisView::suck(const std::optional<debris::Suction>& suction) {
  suction_ = suction;
  if (!cloud_) return;
  const debris::Suction off{.p_W = {}, .flow = 0, .radius = 0};
  const debris::Suction& s = suction_ ? *suction_ : off;
  cloud_->suck(s.p_W, s.flow, s.radius);
}

render::CloudLaw cloud_law(const debris::DebrisOptions& options, const debris::CoarseField& field, double least_shown) {
  return {.capacity = options.capacity,
          .gravity = options.gravity_W,
          .air_density = options.air_density,
          .air_viscosity = options.air_viscosity,
          .restitution = options.restitution,
          .slide = options.slide,
          .decay_time = options.decay_time,
          .lifetime = options.lifetime,
          .least_shown = least_shown,
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

void DebrisView::add(const Cut& cut, const haptics::Tool& tool) {
  if (cut.fill_radius != 0) return;
  for (std::size_t t = 0; t < kTissueCount; ++t) batch_removed_[t] += cut.removed[t];
  last_ = cut;
  last_radius_ = tool.radius();
  if (++batched_ >= batch_size_) emit_batch();
}

void DebrisView::emit_batch() {
  if (std::exchange(batched_, 0) == 0) return;
  last_.removed = std::exchange(batch_removed_, {});
  emit(last_, last_radius_);
}

void DebrisView::add(const LoosePiece& piece) {
  Cut cut;
  cut.index = piece.cut;
  cut.X_WA.p = cut.X_WB.p = piece.center_W;
  cut.removed = piece.removed;
  emit(cut, piece.radius);
}

void DebrisView::follow(Wiring& wiring, std::span<const haptics::Tool> tray) {
  Cut cut;
  while (wiring.cuts_to_debris.pop(cut)) add(cut, tray[cut.tool]);
  LoosePiece piece;
  while (wiring.pieces_to_debris.pop(piece)) add(piece);
}

debris::DebrisLedger DebrisView::settle() {
  emit_batch();
  debris::DebrisLedger ledger = debris_.ledger();
  double given = 0;
  for (std::size_t t = 0; t < kTissueCount; ++t) ledger.born[t] += given_[t], given += given_[t];
  ledger.dropped += given_dropped_;
  if (given > 0) ledger.alive = ledger.decayed = ledger.sucked = std::numeric_limits<double>::quiet_NaN();
  return ledger;
}

void DebrisView::emit(const Cut& cut, double radius) {
  if (!cloud_) return debris_.emit(cut, radius, materials_);
  const std::size_t count =
      debris::create_particles(cut, radius, materials_, options_, cloud_->room(), newborn_, given_, given_dropped_);
  for (const debris::NewParticle& n : std::span(newborn_).first(count)) {
    const render::CloudParticle particle = cloud_particle(n, materials_[static_cast<std::size_t>(n.tissue)].color);
    cloud_->add({&particle, 1});
  }
}

void DebrisView::step(double dt) {
  if (cloud_) return cloud_->advance(dt);
  debris_.step(dt, field_, suction_ ? &*suction_ : nullptr);
}

std::span<const render::Particle> DebrisView::particles() {
  points_.resize(debris_.alive());
  const std::size_t count = debris_.write_points(points_);
  particles_.clear();
  for (std::size_t i = 0; i < count; ++i) {
    const debris::DebrisPoint& point = points_[i];
    const bool mist = point.chip < kMistChip;
    const float fraction = std::min(1.0f, point.diameter / kLeastShown) * (mist ? kMistOpacity : 1.0f);
    particles_.push_back({point.p_W, std::max(point.diameter, kLeastShown) / 2 * (mist ? kMistWidth : 1.0f),
                          glm::vec3(materials_[static_cast<std::size_t>(point.tissue)].color), fraction});
  }
  return particles_;
}

}  // namespace typodont
