// Chips, water and slurry in the picture. Cuts create chips, which bounce off a coarse copy of the tissue. The spray of
// a handpiece wets the tissue. Render thread only.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "engine/app/event_logs.h"
#include "engine/app/picture/film_picture.h"
#include "engine/app/scene.h"
#include "engine/app/surroundings/surroundings.h"
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

/// Parameters of the particles' motion, in the layout that the shaders read.
render::CloudLaw cloud_law(const debris::DebrisOptions& options, const debris::CoarseField& field, double min_shown);
render::CloudParticle cloud_particle(const debris::NewParticle& new_particles, const dvec3& color);

/// The water of a session. If there are no nozzles, neither water nor its film on surfaces is computed.
struct WaterPlan {
  std::optional<Nozzles> nozzles;
  bool on = false;  // true: the spray is on at the start
  glm::dvec4 drain{
      // Plane at which the film of water ends, because the tooth is inside the gum below it. xyz: normal n; w: offset
      // d. The film exists only where n · p_W + d >= 0. Zero: no plane.
      0};
};

/// Water of a scene: nozzles, initial state of the spray, and plane at which the film ends. `around`: surroundings.
WaterPlan water_of(const Scene& scene, const Surroundings& around);

/// Mass balance (kg) of chips, droplets and film of water. Masses that only the GPU knows are NaN.
struct DebrisBalance {
  debris::DebrisLedger chips;
  std::optional<debris::SprayLedger> spray;  // water balance; empty if there are no nozzles
  std::optional<debris::FilmLedger> film;
  std::uint64_t events_lost = 0;  // number of lost servo events; each may be a cut, whose chips are then missing
};

/// Creates, moves and draws chips and water. With nozzles, the CPU moves the chips, because they become part of the
/// film of water, which the CPU computes. Without nozzles, the GPU moves them, or the CPU if rendering is done by
/// software.
class DebrisView {
 public:
  DebrisView(const MaterialTable& materials, const haptics::TissueVolume& tissue, const WaterPlan& water = {});
  DebrisView(const DebrisView&) = delete;
  DebrisView& operator=(const DebrisView&) = delete;
  /// Sets the GPU device that draws the particles. Existing particles are lost. Null: no device, for example because it
  /// is about to be destroyed.
  void use(gpu::Device* device);

  /// Adds a cut, which makes chips. `area`: m², contact area; `duration`: s, time in which the cut was made.
  void add(const Cut& cut, const haptics::Tool& tool, double area, double duration);
  /// Makes chips in place of a piece of tissue that a cut has separated.
  void add(const LoosePiece& piece);
  /// Removes all chips and water, and resets the coarse distance field to the uncut tissue.
  void restart();
  /// Sets the suction nozzle. Empty: the suction is off.
  void suck(const std::optional<debris::Suction>& suction);
  /// Sets the pose of the bur for the next step. While the pedal is pressed, the nozzles spray water on the bur. A bur
  /// that rotates throws off the water that it touches.
  void hold(const ServoTick& tick, const haptics::Tool& tool);
  /// Switches the water on or off. No effect without nozzles.
  void spray(bool on) { spraying_ = on && water_; }
  bool spraying() const { return spraying_; }
  bool has_spray() const { return water_.has_value(); }
  void step(double dt);
  /// Stops (true) or continues the motion of chips and water. While they rest, a cut makes no chips, but changes the
  /// surface on which the water flows.
  void rest(bool rests);
  /// The picture of the film of water; null without nozzles.
  const FilmPicture* film() const { return water_ ? &water_->picture : nullptr; }
  /// Adds to `work` the counts of computed droplets, cells of the film of water, and texels since the last call.
  void count(WorkCounts& work);
  /// The particles on the GPU, for render::Frame. Null if the CPU moves the particles; see particles().
  render::ParticleCloud* cloud() { return cloud_ ? &*cloud_ : nullptr; }
  /// The particles in the renderer's format. The span is valid until the next call.
  std::span<const render::Particle> particles();
  std::size_t alive() const { return cloud_ ? cloud_->alive() : debris_.alive(); }
  /// Creates the chips of the cuts that are still waiting, and returns the mass balance. Call at the session's end.
  /// Masses that only the GPU knows are NaN.
  DebrisBalance settle();

 private:
  struct Water {
    Water(const debris::CoarseField& field, const MaterialTable& materials, const WaterPlan& plan,
          std::uint64_t version);
    debris::Film film;
    debris::Spray spray;
    FilmPicture picture;
    debris::SpraySource source;
    bool bur = false;        // true: the bur is the spray's source, and `source` is valid
    double since_shown = 0;  // s, time since the last update of the water film's picture
    // uncut: pose of the head at the latest cut, while the water's distance field still lacks this cut; else empty.
    // cut_at: pose of the head at the last cut that the field contains.
    std::optional<Pose> uncut, cut_at;
    std::optional<std::uint32_t> tool;  // index of the tool that `head` and `reach` describe
    haptics::HeadField head;
    double reach = 0;                                   // m, distance from the head's centre to its farthest point
    std::uint64_t droplets = 0, cells = 0, texels = 0;  // counts of spray, film and picture at the last call of count()
  };
  void carve(const Cut& cut, const haptics::Tool& tool);
  void carve_pending();
  void add_droplets();
  void emit_batch();
  void emit(const Cut& cut, const debris::CutContact& contact);

  MaterialTable materials_;
  debris::Debris debris_;
  debris::DebrisOptions options_;
  std::optional<debris::Suction> suction_;
  int batched_ = 0;  // number of cuts in the current batch of chips
  bool rests_ = false;
  PerTissue batch_removed_{};  // m³, volume that the cuts of the current batch removed
  Cut last_;                   // the last cut of the current batch
  debris::CutContact batch_;   // contact of the current batch: last tool, mean area, sum of the durations
  PerTissue given_{};          // kg, mass of chips that were passed to the GPU
  double given_dropped_ = 0;   // kg, chips that did not fit into the GPU's buffer
  std::optional<render::ParticleCloud> cloud_;
  std::vector<debris::NewParticle> newborn_;
  std::vector<float> uncut_, distance_;  // m, samples of the distance field: at the start; now
  debris::CoarseField field_;
  WaterPlan plan_;
  std::optional<Water> water_;
  bool spraying_ = false;
  std::vector<debris::DebrisPoint> points_, droplets_;
  std::vector<render::Particle> particles_;
};

}  // namespace typodont
