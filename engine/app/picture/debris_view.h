// Chips for the picture: born from cuts, bouncing off a coarse copy of the tissue. Render thread.
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

/// The same law for the GPU.
render::CloudLaw cloud_law(const debris::DebrisOptions& options, const debris::CoarseField& field, double least_shown);
render::CloudParticle cloud_particle(const debris::Newborn& newborn, const dvec3& color);

/// Moved by the GPU, where there is one: their number then costs the processor nothing. Where a processor plays the GPU
/// it moves them itself, several times quicker than through compute.
class DebrisView {
 public:
  DebrisView(const MaterialTable& materials, const haptics::TissueVolume& tissue);
  /// What draws them from now on; null: nothing does, or it is about to go. Those in the air are gone.
  void use(gpu::Device* device);

  void add(const Cut& cut, const haptics::Tool& tool);
  /// A loose piece falls apart where it was.
  void add(const LoosePiece& piece);
  /// Chips of all that was cut in a live session since the last call. `tray`: the tools the cuts name.
  void follow(Wiring& wiring, std::span<const haptics::Tool> tray);
  /// A nozzle that draws chips in, from now on; nothing: switched off.
  void suck(const std::optional<debris::Suction>& suction);
  void step(double dt);
  /// For render::Frame; null: particles() has them all.
  render::ParticleCloud* cloud() { return cloud_ ? &*cloud_ : nullptr; }
  /// As the renderer draws them; valid until the next call.
  std::span<const render::Particle> particles();
  std::size_t alive() const { return cloud_ ? cloud_->alive() : debris_.alive(); }
  /// The end: cuts that waited for others throw their chips, too. Where all mass went; what only a GPU knows, which
  /// took it over, is not a number.
  debris::DebrisLedger settle();

 private:
  void throw_lump();
  void emit(const Cut& cut, double radius);

  MaterialTable materials_;
  debris::Debris debris_;
  debris::DebrisOptions options_;
  std::optional<debris::Suction> suction_;
  int lumps_ = 1, lumped_ = 0;  // cuts that throw their chips together; those that wait
  PerTissue lump_{};            // m³, of these
  Cut last_;                    // of these the last, and its tool's radius, m
  double last_radius_ = 0;
  PerTissue given_{};         // kg, to the GPU
  double given_dropped_ = 0;  // kg, of it
  std::optional<render::ParticleCloud> cloud_;
  std::vector<debris::Newborn> newborn_;
  std::vector<float> distance_;
  debris::CoarseField field_;
  std::vector<debris::DebrisPoint> points_;
  std::vector<render::Particle> particles_;
};

}  // namespace typodont
