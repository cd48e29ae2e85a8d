// Chips in the picture: cuts create them, and they bounce off a coarse copy of the tissue. Render thread.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "engine/app/wiring.h"
#include "engine/debris/debris.h"
#include "engine/render/particle_cloud.h"
#include "engine/render/renderer.h"
#include "haptics/tissue_volume.h"

namespace typodont {

/// Parameters of the particles' motion for the GPU version.
render::CloudLaw cloud_law(const debris::DebrisOptions& options, const debris::CoarseField& field, double least_shown);
render::CloudParticle cloud_particle(const debris::NewParticle& new_particles, const dvec3& color);

/// A GPU moves the particles if there is one, so they cost no CPU time. With software rendering the CPU moves them
/// directly, which is several times faster than compute shaders on the CPU.
class DebrisView {
 public:
  DebrisView(const MaterialTable& materials, const haptics::TissueVolume& tissue);
  /// Sets the device that draws the particles; null: no device, for example before its destruction. Existing particles
  /// are lost.
  void use(gpu::Device* device);

  void add(const Cut& cut, const haptics::Tool& tool);
  /// Breaks a loose piece into chips at its position.
  void add(const LoosePiece& piece);
  /// Creates the chips of all cuts in a live session since the last call. `tray`: the tool set to which the cuts refer.
  void follow(Wiring& wiring, std::span<const haptics::Tool> tray);
  /// Sets the suction nozzle; empty: the suction is off.
  void suck(const std::optional<debris::Suction>& suction);
  void step(double dt);
  /// The particles on the GPU, for render::Frame; null: particles() contains all particles.
  render::ParticleCloud* cloud() { return cloud_ ? &*cloud_ : nullptr; }
  /// The particles in the renderer's format; valid until the next call.
  std::span<const render::Particle> particles();
  std::size_t alive() const { return cloud_ ? cloud_->alive() : debris_.alive(); }
  /// At the end: creates the chips of waiting cuts, and returns the balance of mass. Entries that are known only on the
  /// GPU are NaN.
  debris::DebrisLedger settle();

 private:
  void emit_batch();
  void emit(const Cut& cut, double radius);

  MaterialTable materials_;
  debris::Debris debris_;
  debris::DebrisOptions options_;
  std::optional<debris::Suction> suction_;
  int batch_size_ = 1, batched_ = 0;  // number of cuts whose chips are created together, and number of waiting cuts
  PerTissue batch_removed_{};         // m³, removed by the waiting cuts
  Cut last_;                          // the last waiting cut, and the radius of its tool in m
  double last_radius_ = 0;
  PerTissue given_{};         // kg, mass passed to the GPU
  double given_dropped_ = 0;  // kg, mass that the GPU dropped
  std::optional<render::ParticleCloud> cloud_;
  std::vector<debris::NewParticle> newborn_;
  std::vector<float> distance_;
  debris::CoarseField field_;
  std::vector<debris::DebrisPoint> points_;
  std::vector<render::Particle> particles_;
};

}  // namespace typodont
