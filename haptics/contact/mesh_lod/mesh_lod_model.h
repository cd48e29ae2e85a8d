// The servo's part of the contact model "mesh_lod". It computes the surface contact point, selects the level of detail
// by the hand's speed, and handles walls between tissues. README.md of this folder defines the terms.
#pragma once

#include <memory>
#include <vector>

#include "haptics/contact/contact_model.h"
#include "haptics/contact/cut_log.h"
#include "haptics/contact/mesh_lod/head_contact.h"
#include "haptics/contact/mesh_lod/mesh_lod_parts.h"
#include "haptics/contact/mesh_lod/surface_point.h"
#include "haptics/contact/retreat_path.h"
#include "haptics/servo.h"

namespace typodont::haptics::mesh_lod {

/// Chooses the level of detail from the hand's speed.
class LevelBySpeed {
 public:
  LevelBySpeed(std::vector<double> speeds, double hysteresis) : speeds_(std::move(speeds)), hysteresis_(hysteresis) {}
  /// Level for this tick, from 0 (finest) to `count` - 1. `displacement`: m, displacement of the hand in this tick;
  /// `dt`: s, duration of the tick.
  std::size_t step(double displacement, double dt, std::size_t count) noexcept;
  void reset() noexcept { fresh_ = true; }

 private:
  std::vector<double> speeds_;  // m/s, hand speeds at which the level of detail changes
  double hysteresis_;
  double speed_ = 0;  // m/s, low-pass filtered speed of the hand
  bool fresh_ = true;
  std::size_t level_ = 0;
};

/// The servo's part of the contact model "mesh_lod".
class MeshLodModel final : public ContactModel {
 public:
  /// Throws Error if the tool set contains a filling instrument.
  MeshLodModel(const ServoSettings& settings, const Parameters& parameters);

  void adopt(Snapshot& fresh, PerTissue& removed) noexcept override;
  const Snapshot& snapshot() const noexcept override { return snapshot_; }
  double travel() const noexcept override { return LocalParameters::travel_for(tool_set(settings_)); }
  double clearance(const Pose& X_WG) noexcept override;
  bool turns_matter() const noexcept override { return whole_head(tool_set(settings_)[tool_]); }
  void begin_anew() noexcept override { placed_ = moved_freely_ = false; }
  void release() noexcept override;
  bool is_free(std::uint32_t tool, const Pose& X_WG) noexcept override;
  void take_up(std::uint32_t tool) noexcept override;
  void constrain(const ContactInput& in, Contact& out) noexcept override;
  int near_planes(std::span<NearPlane, kMaxNearPlanes> planes) const noexcept override;
  bool cut(const ContactInput& in, Contact& contact, Cut& cut, double& energy) noexcept override;
  bool estimates_volume() const noexcept override { return true; }
  void feel(const ContactInput& in, Contact& contact, Felt& out) noexcept override;
  Tissue tissue_at(const dvec3& p_W) const noexcept override;

 private:
  /// Meshes of the current tissue, finest level first.
  const std::vector<TriangleGrid>& grids() const noexcept {
    return snapshot_.cut ? snapshot_.local : snapshot_.levels->grids;
  }
  const TriangleGrid& grid() const noexcept { return grids()[level_]; }
  const TriangleGrid& finest() const noexcept { return grids()[0]; }
  /// Number of levels that a tool can use. A bur that is not a ball uses only the finest level.
  std::size_t level_count(std::uint32_t tool) const noexcept {
    return whole_head(tool_set(settings_)[tool]) ? 1 : grids().size();
  }
  /// Returns true if the snapshot contains all faces within the distance `reach` (m) of the point p.
  bool holds(const dvec3& p, double reach) const noexcept;
  /// Returns true if the head may move to `to`: the head's overlap with the snapshot's faces is then so small that the
  /// faces can still stop the head. (The snapshot may lack the last cuts.)
  bool may_penetrate_to(const dvec3& to) noexcept;
  /// Returns true if the snapshot lacks some of the servo's cuts. In this state, faces that overlap the head count as
  /// removed.
  bool behind() const noexcept { return snapshot_.cuts < made_.last(); }
  SurfaceContact& point() noexcept { return *points_[tool_]; }
  const SurfaceContact& point() const noexcept { return *points_[tool_]; }
  /// Chooses the level of detail for this tick. Returns true if the level changed.
  bool choose_level(const ContactInput& in) noexcept;
  void take_over(bool anew) noexcept;
  void withdraw(const ContactInput& in, const dvec3& goal) noexcept;
  void fade_offset(const ContactInput& in) noexcept;
  void ease(const ContactInput& in, bool give) noexcept;

  const ServoSettings& settings_;
  Parameters parameters_;
  MeshSnapshot snapshot_;
  std::vector<std::unique_ptr<SurfaceContact>> points_;  // for each tool: its contact with the mesh
  // m, for each tool: centre of its contact shape (ball or other head) in the frame T
  std::vector<dvec3> ends_;
  std::uint32_t tool_ = 0;
  LevelBySpeed by_speed_;
  std::size_t level_ = 0;
  // true: the contact shape (ball or other head) is at the tool's current position
  bool placed_ = false;
  // true: since the last tick, the servo moved the tool without contact and without this model; placed_ is then false
  bool moved_freely_ = false;
  dvec3 hip_{0};  // m, position of the hand in the last tick (HIP)
  // m, vector that is added to the contact point after a change of the level, or of the wall between tissues that stops
  // the tool, so that the force does not jump. It shrinks to zero.
  dvec3 offset_{0};
  // true: the bur has cut since it last lost contact; ease() limits the change of its force
  bool eases_ = false;
  // m, vector from the hand to the position of the tool that the last tick returned
  dvec3 last_lag_{0};
  dquat last_R_{1, 0, 0, 0};  // orientation of the hand in the last tick
  // Normal of the wall that stops the tool; stored until offset_ has shrunk to zero after the tool left the wall.
  dvec3 wall_normal_{0};
  double wall_stiffness_ = 0;

  // Data that the servo stores for each of its cuts.
  struct Made {
    PerTissue removed{};  // m³, estimated removed volume of each tissue
    dvec3 from{0};        // m, centre of the contact shape before the cut
  };
  RecentCuts<Made> made_;
  dvec3 first_missing_cut_{0};  // m, start of the first cut that the snapshot lacks
  bool cutting_ = false;        // true: the bur has cut since it was placed; the next cut begins at end_
  bool in_own_cut_ = false;     // true from a cut until the head is clear of the mesh
  RetreatPath path_;            // voxels, recorded path of the head while in_own_cut_ is true
  Pose end_;                    // pose of the tool after the last cut
  bool adopted_ = false;        // true: a new snapshot was adopted in this tick
  // filtered ratio of measured to estimated removed volume, for the cuts in the last snapshot
  double measured_ = 1;
};

}  // namespace typodont::haptics::mesh_lod
