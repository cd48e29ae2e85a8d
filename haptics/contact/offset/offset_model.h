// The part of the contact model "offset" (README.md) that runs on the servo thread. The distance field gives contact
// planes, which keep a god-object outside the tissue.
#pragma once

#include <array>
#include <vector>

#include "haptics/contact/offset/parameters.h"
#include "haptics/contact/offset/retreat_path.h"
#include "haptics/contact/patch_model.h"
#include "haptics/contact/proxy/nearest_allowed.h"
#include "haptics/contact/proxy/non_cutting_contacts.h"
#include "haptics/cut_front.h"
#include "haptics/fill.h"

namespace typodont::haptics::offset {

/// The contact model "offset" on the servo thread. Lengths are in voxels unless a unit is given; V is the frame of the
/// voxel grid.
class OffsetModel : public PatchModel {
 public:
  explicit OffsetModel(const ServoSettings& settings);

  double clearance(const Pose& X_WG) noexcept override;
  bool turns_matter() const noexcept override { return heads_[tool_].smooth.any(); }
  void begin_anew() noexcept override;
  void release() noexcept override;
  bool may_change_tool(std::uint32_t tool, const Pose& X_WG) noexcept override;
  void take_up(std::uint32_t tool) noexcept override;
  void constrain(const ContactInput& in, Contact& out) noexcept override;
  bool cut(const ContactInput& in, Contact& contact, Cut& cut, double& energy) noexcept override;
  void feel(const ContactInput& in, Contact& out) noexcept override;

 protected:
  /// A tool and the data that were prepared for it at set-up.
  struct Head {
    Tool tool;
    ContactFinder finder;
    NonCuttingContacts smooth;  // contacts of the parts that do not cut: the shank and the safe end (a pin at the tip)
    // voxels, distance from the head's centre to the farthest point of the head and of the safe end (non-cutting pin)
    double reach;
  };

  /// Intermediate results of the present tick.
  struct Step {
    dvec3 start{0}, c{0};  // voxels; start: the head's centre at the start of the tick; c: the head's present centre
    dvec3 target{0};       // voxels, position of the head's centre at the hand's pose
    dvec3 shift{0};        // voxels, displacement of the hand since the last tick
    // voxels, largest depth by which a cutting head may sink into the tissue in this tick; the energy budget suffices
    // to remove the tissue down to this depth
    double slack = 0;
    double slack_at_walls = 0;  // at a wall of harder tissue, the head may sink only by this fraction of `slack`
    double overlap_before = 0;
    // voxels; if the proxy moves by this relative to the hand in one tick, the force changes at a rate of 1 N/s
    double pace_per_slew = 0;
    bool paced = false;  // true if the proxy's speed relative to the hand is limited in this tick
    // unit vector opposite to the hand's acceleration during a fall (the hand accelerates because the tissue under the
    // bur was removed); zero: no fall
    dvec3 fall_normal{0};
    // voxels, largest distance that the head may move against fall_normal in this tick, during a fall
    double fall_limit = 0;
    // Voxels, vector from the hand to the position that the proxy would have if its speed were not limited; zero
    // without contact. This position depends on the contacts, and on the energy debt (energy of past cuts that the
    // motor has not yet delivered).
    dvec3 contact_push{0};
    ActivePlanes active{};  // indices of the contacts that block the head (the active set)
    // These members have the same meaning as the members of Contact with the same names.
    bool touching = false, lost = false, deep = false, bridging = false, late = false;
  };

  /// State of one search for the proxy's position, kept over its iterations.
  struct Search {
    dvec3 found_at{0};  // voxels, the head's centre at the last search for contacts
    dvec3 last_step{0};
    double last_gain = 1, last_length = 0;
    int settled = 0;     // number of iterations so far that had contact and made no long step
    dvec3 long_step{0};  // voxels, the last step that was too long for one iteration
    int reversals = 0;   // number of long steps that were opposite to the previous long step
    // true if the limit of the proxy's speed ended the last step; false if a contact ended it
    bool at_pace = false;
    dvec3 held_at{0};  // voxels, position of the head's centre that the contacts alone determine
    // voxels, position to which the head is pulled: the hand's target, corrected for the grip of the cutting edges
    dvec3 led_to{0};
  };
  enum class Advance { kOn, kArrived, kNear };
  enum class Ending { kDone, kPlacementRefused };

  const Tool& tool() const noexcept { return heads_[tool_].tool; }
  const ContactFinder& finder() const noexcept { return heads_[tool_].finder; }
  NonCuttingContacts& smooth() noexcept { return heads_[tool_].smooth; }
  double reach() const noexcept { return heads_[tool_].reach; }
  /// Returns a lower bound of the head's distance to tissue, in voxels. Valid only if it is positive.
  double free_distance(const dvec3& c) const noexcept { return sample_linear(patch_, c) - reach(); }
  /// Returns a lower bound of the whole tool's distance to tissue, in voxels. `X_VT`: pose of the tool in the voxel
  /// frame V; `head_free`: the lower bound for the head alone.
  double free_distance(const Pose& X_VT, double head_free) noexcept;

  // Functions that compute the pose of the proxy (proxy.cpp).
  void begin_step(const ContactInput& in) noexcept;
  void follow_fall(const ContactInput& in) noexcept;
  void move_proxy(const ContactInput& in) noexcept;
  bool place_ball_on_wall(const ContactInput& in, bool& alone) noexcept;
  Ending search(const ContactInput& in, Search& s, bool seated) noexcept;
  Advance advance_free(const ContactInput& in, Search& s, double& head_free) noexcept;
  void find_contacts(const ContactInput& in, Search& s, double head_free) noexcept;
  void look_around(const ContactInput& in, const dvec3& c, bool center_inside) noexcept;
  dvec3 project(const ContactInput& in, Search& s, bool& comes_free) noexcept;
  dvec3 refine_and_project(const ContactInput& in, Search& s, dvec3 next) noexcept;
  dvec3 extrapolate(Search& s, const dvec3& step) noexcept;
  void find_sink_depth(const ContactInput& in) noexcept;
  bool within_overlap_tolerance(const ContactInput& in) const noexcept;
  dvec3 ease(const dvec3& carried, double most, const dvec3& pulled_to, dvec3& next) noexcept;
  double debt_fraction(const ContactInput& in) const noexcept;
  double wall_at(const ContactPlane& plane) const noexcept;
  double strongest_wall(const ActivePlanes& active) const noexcept;
  bool hold_at_walls(const ActivePlanes& active, double yields) noexcept;
  void follow_hand() noexcept;
  bool lead_back() noexcept;
  void watch_retreat(const ContactInput& in) noexcept;
  bool hand_has_left() const noexcept;
  void bridge_missing_patch(const ContactInput& in) noexcept;
  void report(const ContactInput& in, Contact& out) noexcept;

  // Functions that cut, and that repeat cuts in a new patch (copy of the field around the tool); see removal.cpp.
  bool carve_head(const ContactInput& in, const Contact& contact, Cut& cut, double& energy) noexcept;
  /// Removes the sweep of the head from its present pose (in.X_WG) to the pose X_WB. Removes it in the fine patch
  /// (field around the head) and in the coarse patch (field around the shank). Returns true and sets `cut` if any
  /// sample changed.
  bool remove_sweep(const ContactInput& in, const Pose& X_WB, Cut& cut, double& energy) noexcept;
  void carve_coarse(const Pose& X_WA, const Pose& X_WB, bool continues, bool may_wait) noexcept;
  void finish_coarse() noexcept;
  VoxelFrame coarse_frame() const noexcept {
    return {settings_.frame.origin, voxel() * patch_.coarse_levels.front().every};
  }
  PerTissue repeat(const CutLog::Made& made, std::uint64_t index, SurfacePatch& fresh) noexcept override;
  void update_coarse(SurfacePatch& fresh, bool edited) noexcept override;
  void adopted(bool strokes_edited, bool known) noexcept override;

  // Functions for instruments that add filling to a cavity; they are defined in filling.cpp.
  bool fill(const ContactInput& in, Contact& contact, Cut& cut) noexcept;
  bool place_filling(const ContactInput& in, const Contact& contact, Cut& cut) noexcept;
  bool begin_dome(const Pose& X_WH, double reach) noexcept;
  bool search_open_place(const Fill& instrument, double reach) noexcept;

  double hardest_ = 0;  // J/m³, largest specific energy of all tissues
  std::vector<Head> heads_;
  std::uint32_t tool_ = 0;
  Step step_;
  ContactSet contacts_;  // contacts found in the last iteration

  // The next members are the state of the proxy between two ticks.
  HeldBy held_;           // normals of the contacts that held the head in the last tick
  bool emptied_ = false;  // true if the last cut removed all tissue inside the head
  // voxels, overlap of head and tissue; it decays to zero while the head is moved out of the tissue
  double overlap_ = 0;
  // fraction 0..1 of its power that the head kept at a wall of harder tissue in the last tick; 0: no wall
  double wall_ = 0;
  bool breaking_through_ = false;
  double lost_for_ = 0;  // s, time since the tool was last inside the patch (copy of the field around it)
  // N. If the carver thread delivers a patch (copy of the field) too late, a plane replaces the missing tissue. This is
  // the contact force at the time when the patch became late. The plane yields to a force that is clearly larger. 0: no
  // patch is late.
  double bridge_push_ = 0;
  dvec3 bridge_from_{0};  // voxels, the head's centre when the new patch (copy of the field) became late
  // s, remaining time in which the proxy returns smoothly to the surface, after a plane had replaced late tissue data
  double rejoining_ = 0;
  struct Retreat {
    RetreatPath path;
    dvec3 held_at{0};      // voxels, position near which contacts have held the proxy
    double held_for = 0;   // s, time that the proxy has stayed near held_at while the hand was far away
    bool leading = false;  // true while the proxy is led back along its path
    std::size_t to = 0;    // index of the path point to which the proxy is led back
    bool wedged = false;   // true if the proxy is stuck: the hand has moved away, and no path back was found
  } retreat_;
  struct Fall {
    dvec3 push_mean{0};  // N, low-pass filtered push of the tissue on the head
    // m/s, the hand's velocity after a low-pass filter with a short (hand_speed) and a long (hand_mean) time constant
    dvec3 hand_speed{0}, hand_mean{0};
  } fall_;

  // The next members are the state of the removal between two ticks. The active fronts contain, for the fine and for
  // the coarse patch, the samples that the head can still change.
  CutFront front_, coarse_front_;  // samples (of both patches) that the head can still change: active fronts
  Pose cut_end_;                   // pose of the head at the end of the last cut
  std::uint32_t cut_tool_ = 0;     // index of the tool that made the last cut
  // A cut in the coarse patch (for the shank). It joins several cuts of the fine patch, and may wait for a later tick.
  struct CoarseCut {
    Pose X_WA, X_WB;         // poses of the head at the start and at the end of the cut
    std::uint64_t cut = 0;   // index of the last cut of the fine patch (around the head) that this cut includes
    std::uint32_t tool = 0;  // tool of the cut
    bool goes_on = false;    // true if the previous cut in the coarse patch (around the shank) ended at X_WA
    int waits = 0;           // number of ticks for which the cut has waited; 0: no cut waits
  } coarse_;

  struct Filling {
    double owed = 0;     // m³, filling material that was delivered but is not placed yet
    double radius = -1;  // voxels, radius of the growing dome of filling; negative: no dome exists
    // fraction of the surface of the dome (the growing deposit of filling) that can still grow, as estimated in the
    // last tick
    double free_fraction = 1;
    // voxels; center: centre of the dome (the growing deposit of filling); end: position of the instrument's free end
    // when the dome began
    dvec3 center{0}, end{0};
    // voxels, place where the first dome of filling began; the search for places open for filling starts here
    dvec3 root{0};
    bool idle = false;  // true if the dome of filling could hardly grow in the last tick
  } filling_;
  // Search for places that are open for filling, along straight rays that start where the first dome of filling began.
  // All rays advance together, so the nearest open place is found first.
  struct OpenPlaceSearch {
    struct Ray {
      int next = 0;       // number of the next sample to examine on this ray
      int in_tissue = 0;  // number of consecutive samples of this ray inside tissue
    };
    static constexpr int kNever = 1 << 30;
    int looks = 0;        // number of samples that have been examined on each ray so far
    std::size_t way = 0;  // index of the ray that is examined next
    std::array<Ray, FillingParameters::directions> rays{};
  } open_place_search_;
  // unit vectors of the rays along which places open for filling are searched; empty if no tool fills
  std::vector<glm::vec3> flow_directions_;
};

}  // namespace typodont::haptics::offset
