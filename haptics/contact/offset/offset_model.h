// The servo's part of the contact model "offset" (README.md): planes from the distance field hold the proxy outside.
#pragma once

#include <array>
#include <vector>

#include "haptics/contact/missing_snapshot.h"
#include "haptics/contact/offset/parameters.h"
#include "haptics/contact/patch_model.h"
#include "haptics/contact/proxy/nearest_allowed.h"
#include "haptics/contact/proxy/non_cutting_contacts.h"
#include "haptics/contact/retreat_path.h"
#include "haptics/cutting/cut_front.h"
#include "haptics/fill.h"

namespace typodont::haptics::offset {

/// Lengths are in voxels unless another unit is given. Frame V: voxel grid.
class OffsetModel : public PatchModel {
 public:
  /// `mean_stiffness`: the head feels the mean of the tissue inside it at the hand's pose (Kim & Park 2006, sec. 4.2),
  /// not the tissue below each contact.
  explicit OffsetModel(const ServoSettings& settings, bool mean_stiffness = false);

  double clearance(const Pose& X_WG) noexcept override;
  bool turns_matter() const noexcept override { return heads_[tool_].smooth.any(); }
  void begin_anew() noexcept override;
  void release() noexcept override;
  bool is_free(std::uint32_t tool, const Pose& X_WG) noexcept override;
  void take_up(std::uint32_t tool) noexcept override;
  void constrain(const ContactInput& in, Contact& out) noexcept override;
  int near_planes(std::span<NearPlane, kMaxNearPlanes> planes) const noexcept override;
  bool refine_near_plane(int i) noexcept override;
  bool cut(const ContactInput& in, Contact& contact, Cut& cut, double& energy) noexcept override;
  void feel(const ContactInput& in, Contact& contact, Felt& out) noexcept override;

 protected:
  /// Data of one tool's head, prepared at set-up.
  struct Head {
    Tool tool;
    ContactFinder finder;
    NonCuttingContacts smooth;  // contacts of shank and safe end
    // voxels, distance from the head's centre to the farthest point of head and safe end
    double reach;
    std::vector<dvec3> inside;  // voxels, frame T, lattice of points in the head; empty unless mean_stiffness
  };

  /// Intermediate results of the current tick.
  struct Step {
    dvec3 start{0}, c{0};  // voxels, head's centre: at the start of the tick; current
    dvec3 target{0};       // voxels, the head's centre at the hand's pose
    Pose searched;         // voxels, pose of the head for which the gaps of contacts_ are valid
    dvec3 shift{0};        // voxels, displacement of the hand since the last tick
    // voxels, depth by which the head may sink into tissue with the energy budget of this tick
    double allowed_depth = 0;
    double allowed_depth_at_walls = 0;  // 0..1, fraction of `allowed_depth` that is allowed at walls (WallParameters)
    double overlap_before = 0;
    // Voxels by which the proxy's lag behind the hand changes in this tick if the force changes at a rate of 1 N/s.
    double step_per_slew = 0;
    // voxels, longest steps of the proxy relative to the hand: while contacts hold it, and while nothing holds it
    double cut_step = 0, free_step = 0;
    bool limits_step = false;  // true: the proxy's speed is limited in this tick
    // Unit vector against the hand's acceleration if the bur has just lost its support by tissue; otherwise zero.
    dvec3 fall_normal{0};
    // voxels, largest motion in this tick in the direction opposite to fall_normal
    double fall_limit = 0;
    // Voxels, vector from the hand to where contacts would hold the proxy if its speed were not limited. Includes the
    // delay of a bur that has used too much energy (deficit_fraction). Zero without contact.
    dvec3 contact_push{0};
    ActivePlanes active{};      // contact planes that hold the head
    bool slip_limited = false;  // true: limit_slip() shortened the head's motion in this tick
    // The following members have the same meaning as in Contact.
    bool touching = false, deep = false;
    SnapshotGap gap;
  };

  /// State of one search for the proxy's position, kept from iteration to iteration.
  struct Search {
    dvec3 found_at{0};  // voxels, the head's centre at the last contact search
    dvec3 last_step{0};
    double last_gain = 1, last_length = 0;
    int settled = 0;     // number of iterations whose step was not too long (see long_step)
    dvec3 long_step{0};  // voxels, last step of the search that was too long for one iteration
    int reversals = 0;   // how often a too long step was opposite to the too long step before it
    dvec3 best{0};       // voxels, best position of the head's centre so far (keep_best)
    double best_merit = 1e300;
    // true: the proxy's speed limit ends the search
    bool at_max_step = false;
    // voxels, head's centre as the contacts alone would hold it, without a speed limit
    dvec3 held_at{0};
    // voxels, point to which the head's centre is pulled: `target`, or a nearer point if the force would change too
    // fast
    dvec3 led_to{0};
  };
  enum class Advance { kOn, kArrived, kNear };
  enum class Ending { kDone, kPlacementRefused };

  const Tool& tool() const noexcept { return heads_[tool_].tool; }
  const ContactFinder& finder() const noexcept { return heads_[tool_].finder; }
  NonCuttingContacts& smooth() noexcept { return heads_[tool_].smooth; }
  double reach() const noexcept { return heads_[tool_].reach; }
  /// Lower bound of the distance between tissue and the head with its centre at c, voxels. Valid only if positive.
  double free_distance(const dvec3& c) const noexcept { return min_distance(patch_, c) - reach(); }
  /// Lower bound of the whole tool's distance from tissue at the pose X_VT, voxels. `head_free`: the same bound for the
  /// head alone.
  double free_distance(const Pose& X_VT, double head_free) noexcept;

  // The following functions are defined in proxy.cpp.
  void begin_step(const ContactInput& in) noexcept;
  void follow_fall(const ContactInput& in) noexcept;
  void move_proxy(const ContactInput& in) noexcept;
  bool take_place(const ContactInput& in) noexcept;
  bool place_ball_on_wall(const ContactInput& in, bool& alone) noexcept;
  Ending search(const ContactInput& in, Search& s, bool seated) noexcept;
  Advance advance_free(const ContactInput& in, Search& s, double& head_free) noexcept;
  void keep_best(Search& s) const noexcept;
  void take_best(const Search& s) noexcept;
  double max_slip() const noexcept;
  bool slips(const ContactInput& in) const noexcept;
  bool limit_slip(const ContactInput& in, const dvec3& from) noexcept;
  void find_contacts(const ContactInput& in, Search& s, double head_free) noexcept;
  void search_around(const ContactInput& in, const dvec3& c, bool center_inside) noexcept;
  dvec3 project(const ContactInput& in, Search& s, bool& comes_free) noexcept;
  bool refine_nearest(const ContactInput& in, const dvec3& next) noexcept;
  dvec3 refine_and_project(const ContactInput& in, Search& s, dvec3 next) noexcept;
  dvec3 extrapolate(Search& s, const dvec3& step) noexcept;
  void find_sink_depth(const ContactInput& in) noexcept;
  bool within_overlap_tolerance(const ContactInput& in) const noexcept;
  /// Returns true if the head neither cuts nor fills.
  bool only_touches(const ContactInput& in) const noexcept { return !in.removal.cuts && tool().fill == Tissue::kAir; }
  /// Returns true if the head neither cuts nor fills; false for implant instruments, which the drilled hole guides.
  bool probes(const ContactInput& in) const noexcept { return only_touches(in) && !tool().implant; }
  dvec3 ease(const dvec3& carried, double most, const dvec3& pulled_to, dvec3& next) noexcept;
  double deficit_fraction(const ContactInput& in) const noexcept;
  double wall_at(const ContactPlane& plane) const noexcept;
  double strongest_wall(const ActivePlanes& active) const noexcept;
  bool hold_at_walls(const ActivePlanes& active, double yields) noexcept;
  void follow_hand() noexcept;
  bool lead_back() noexcept;
  void withdraw(const ContactInput& in) noexcept;
  void watch_retreat(const ContactInput& in) noexcept;
  bool hand_has_left() const noexcept;
  void bridge_missing_patch(const ContactInput& in) noexcept;
  void report(const ContactInput& in, Contact& out) noexcept;
  bool feel_mean(const ContactInput& in, Felt& out) const noexcept;

  // The following functions are defined in removal.cpp.
  bool carve_head(const ContactInput& in, const Contact& contact, Cut& cut, double& energy) noexcept;
  /// Cuts the volume that the head sweeps from in.X_WG to X_WB out of the fine and the coarse tissue patch. If tissue
  /// changed, returns true and sets `cut`.
  bool remove_sweep(const ContactInput& in, const Pose& X_WB, Cut& cut, double& energy) noexcept;
  void carve_coarse(const Pose& X_WA, const Pose& X_WB, bool continues, bool may_wait) noexcept;
  void finish_coarse() noexcept;
  VoxelFrame coarse_frame() const noexcept {
    return {settings_.frame.origin, voxel() * patch_.coarse_levels.front().every};
  }
  PerTissue repeat(const CutLog::Made& made, std::uint64_t index, TissuePatch& fresh) noexcept override;
  void update_coarse(TissuePatch& fresh, bool edited) noexcept override;
  void adopted(bool strokes_edited, bool known) noexcept override;

  // The following functions are defined in filling.cpp.
  bool fill(const ContactInput& in, Contact& contact, Cut& cut) noexcept;
  bool place_filling(const ContactInput& in, const Contact& contact, Cut& cut) noexcept;
  bool begin_ball(const Pose& X_WH, double reach) noexcept;
  bool search_open_place(const Fill& instrument, double reach) noexcept;

  // m/s, largest speed of a moving surface (intermediate_surface.h). 0: only cuts and fillings change the surface.
  double surface_speed_ = 0;
  double hardest_ = 0;  // J/m³, largest specific energy of all tissues
  std::vector<Head> heads_;
  std::uint32_t tool_ = 0;
  Step step_;
  ContactSet contacts_;  // contacts found in the last iteration

  // State of the proxy, kept between ticks.
  HeldBy held_;           // normals of the planes that held the head in the last tick
  bool emptied_ = false;  // true: the last cut removed all tissue inside the head
  // voxels, tolerated overlap of head and tissue; decreases over time
  double overlap_ = 0;
  bool deep_penetration_ = false;  // true: the head is deep in tissue and is being moved out
  // 0..1, fraction of the motor's power that the head used at harder tissue in the last tick; 0: no harder tissue
  double wall_ = 0;
  bool breaking_through_ = false;
  MissingSnapshot missing_;
  // s, remaining time of the proxy's smooth return to the surface
  double rejoining_ = 0;
  Retreat retreat_;       // path in voxels
  bool has_cut_ = false;  // true: the tool has cut since the recorded path began
  struct Fall {
    dvec3 push_mean{0};  // N, low-pass filtered contact force on the head
    // m/s, the hand's velocity, low-pass filtered with a short and with a long time constant
    dvec3 hand_speed{0}, hand_mean{0};
  } fall_;

  // State of the removal between ticks. A cut front stores which samples the next cuts can change.
  CutFront front_, coarse_front_;  // cut fronts of the fine and the coarse tissue patch
  Pose cut_end_;                   // pose of the head after the last cut
  std::uint32_t cut_tool_ = 0;     // index of the tool of the last cut
  // A cut of the coarse tissue patch. It joins several fine cuts, and may wait for a later tick.
  struct CoarseCut {
    Pose X_WA, X_WB;         // poses of the head at start and end
    std::uint64_t cut = 0;   // index of the last fine cut that this coarse cut includes
    std::uint32_t tool = 0;  // tool of the cut
    bool goes_on = false;    // true: the previous coarse cut ended where this cut starts (X_WA)
    int waits = 0;           // number of ticks that the cut has waited; 0: no cut waits
  } coarse_;

  struct Filling {
    double owed = 0;     // m³, filling delivered but not placed yet
    double radius = -1;  // voxels, radius of the ball of filling; negative: there is no ball
    // fraction of the surface of the ball of filling that could grow in the last tick
    double free_fraction = 1;
    // voxels: centre of the ball of filling; position of the instrument's free end when the ball began
    dvec3 center{0}, end{0};
    // voxels, centre of the first ball of filling; the search for an open place starts there
    dvec3 root{0};
    bool idle = false;  // true: hardly any filling could be added in the last tick
  } filling_;
  // Search for a place with room for filling, along rays from the first ball of filling. All rays advance together, so
  // the place nearest to this ball is found first.
  struct OpenPlaceSearch {
    struct Ray {
      int next = 0;       // index along the ray of the next sample to examine
      int in_tissue = 0;  // number of consecutive samples inside tissue
    };
    static constexpr int kNever = 1 << 30;
    int sample = 0;           // index, along each ray, of the sample that is examined now
    std::size_t current = 0;  // index of the ray to examine next
    std::array<Ray, FillingParameters::directions> rays{};
  } open_place_search_;
  // Directions of the search rays; empty if no tool fills.
  std::vector<glm::vec3> flow_directions_;
};

}  // namespace typodont::haptics::offset
