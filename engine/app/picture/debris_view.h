// Chips, water and slurry in the picture: cuts create chips, which bounce off a coarse copy of the tissue; a handpiece
// with spray wets it. Render thread.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "engine/app/picture/film_picture.h"
#include "engine/app/scene.h"
#include "engine/app/surroundings/surroundings.h"
#include "engine/app/wiring.h"
#include "engine/app/work_counts.h"
#include "engine/contract/nozzles.h"
#include "engine/debris/debris.h"
#include "engine/debris/film.h"
#include "engine/debris/spray.h"
#include "engine/render/particle_cloud.h"
#include "engine/render/renderer.h"
#include "haptics/tissue_volume.h"
#include "haptics/tool.h"

namespace typodont {

/// Parameters of the particles' motion for the GPU version.
render::CloudLaw cloud_law(const debris::DebrisOptions& options, const debris::CoarseField& field, double least_shown);
render::CloudParticle cloud_particle(const debris::NewParticle& new_particles, const dvec3& color);

/// The water of a session. Without nozzles, water and film do not exist and take no time.
struct WaterPlan {
  std::optional<Nozzles> nozzles;
  bool on = false;  // initial state of the spray
  glm::dvec4 drain{
      // the tooth is inside the gum at points p_W with dot(drain, (p_W, 1)) < 0, where the film ends; zero: at no
      // point
      0};
};

/// The water of a scene. `around`: the scene's surroundings.
WaterPlan water_of(const Scene& scene, const Surroundings& around);

/// Balance of chips, droplets and film in kg. Entries that are known only on the GPU are NaN.
struct DebrisBalance {
  debris::DebrisLedger chips;
  std::optional<debris::SprayLedger> spray;  // a value only if there are nozzles
  std::optional<debris::FilmLedger> film;
};

/// If there is a GPU, it moves the chips, so that they take no CPU time. With software rendering the CPU moves them
/// directly, which is several times faster than compute shaders on the CPU. With nozzles the CPU always moves them,
/// because they become part of the film.
class DebrisView {
 public:
  DebrisView(const MaterialTable& materials, const haptics::TissueVolume& tissue, const WaterPlan& water = {});
  DebrisView(const DebrisView&) = delete;
  DebrisView& operator=(const DebrisView&) = delete;
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
  /// Sets the bur of the next step, which sprays while the pedal is pressed and throws off the film that it touches.
  void hold(const ServoTick& tick, const haptics::Tool& tool);
  /// Switches the water on or off; does nothing without nozzles.
  void spray(bool on) { spraying_ = on && water_; }
  bool spraying() const { return spraying_; }
  bool has_spray() const { return water_.has_value(); }
  void step(double dt);
  /// The film for PictureStage::show_film; null without nozzles.
  const FilmPicture* film() const { return water_ ? &water_->picture : nullptr; }
  /// Adds to `work` the work since the last call.
  void count(WorkCounts& work);
  /// The particles on the GPU, for render::Frame; null: particles() contains all particles.
  render::ParticleCloud* cloud() { return cloud_ ? &*cloud_ : nullptr; }
  /// The particles in the renderer's format; valid until the next call.
  std::span<const render::Particle> particles();
  std::size_t alive() const { return cloud_ ? cloud_->alive() : debris_.alive(); }
  /// Call at the end. Creates the chips of the waiting cuts, and returns the balance of mass. Entries that only the
  /// GPU has computed are NaN.
  DebrisBalance settle();

 private:
  struct Water {
    Water(const debris::CoarseField& field, const MaterialTable& materials, const WaterPlan& plan);
    debris::Film film;
    debris::Spray spray;
    FilmPicture picture;
    debris::SpraySource source;
    bool bur = false;        // true if `source` is set
    double since_shown = 0;  // s, time since the picture was updated
    // Pose of the head at the last cut that the field does not contain yet, and pose at which the field was cut last.
    std::optional<Pose> uncut, cut_at;
    std::optional<std::uint32_t> tool;  // index of the tool to which `head` and `reach` belong
    haptics::HeadField head;
    double reach = 0;                                   // m, distance from the head's centre to its farthest point
    std::uint64_t droplets = 0, cells = 0, texels = 0;  // work that was already counted
  };
  void carve(const Cut& cut, const haptics::Tool& tool);
  void carve_pending();
  void add_droplets();
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
  std::optional<Water> water_;
  bool spraying_ = false;
  std::vector<debris::DebrisPoint> points_, droplets_;
  std::vector<render::Particle> particles_;
};

}  // namespace typodont
