// "offset" (README.md) on the servo thread: planes from the field keep a god-object outside.
#pragma once

#include <array>
#include <vector>

#include "haptics/contact/offset/parameters.h"
#include "haptics/contact/offset/retreat_path.h"
#include "haptics/contact/patch_model.h"
#include "haptics/contact/proxy/nearest_allowed.h"
#include "haptics/contact/proxy/non_cutting_contacts.h"
#include "haptics/cutting/cut_front.h"
#include "haptics/fill.h"

namespace typodont::haptics::offset {

/// Voxels unless stated; V: voxel grid.
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
  /// Prepared at set-up.
  struct Head {
    Tool tool;
    ContactFinder finder;
    NonCuttingContacts smooth;  // of shank and safe end
    // voxels, centre to the farthest point of head and safe end
    double reach;
  };

  /// Intermediate results of the present tick.
  struct Step {
    dvec3 start{0}, c{0};  // voxels: centre at the tick's start, and now
    dvec3 target{0};       // voxels, at the hand's pose
    dvec3 shift{0};        // voxels, since the last tick
    // voxels that a cutting head may sink, within the budget
    double slack = 0;
    double slack_at_walls = 0;  // of `slack`, at a harder wall
    double overlap_before = 0;
    // voxels per tick against the hand: 1 N/s
    double pace_per_slew = 0;
    bool paced = false;  // limited in this tick
    // against the hand's acceleration in a fall, when tissue under the bur went; zero: none
    dvec3 fall_normal{0};
    // voxels against fall_normal in this tick
    double fall_limit = 0;
    // Voxels, hand to the proxy without speed limit; zero without contact. By contacts and energy debt.
    dvec3 contact_push{0};
    ActivePlanes active{};  // active set
    // As in Contact.
    bool touching = false, lost = false, deep = false, bridging = false, late = false;
  };

  /// Over the iterations.
  struct Search {
    dvec3 found_at{0};  // voxels, at the last contact search
    dvec3 last_step{0};
    double last_gain = 1, last_length = 0;
    int settled = 0;     // iterations with contact and no long step
    dvec3 long_step{0};  // voxels, last step too long for one iteration
    int reversals = 0;   // long steps against the last long one
    // by the speed limit; otherwise by a contact
    bool at_pace = false;
    dvec3 held_at{0};  // voxels, by contacts alone
    // voxels, hand's target, corrected for the edges' grip
    dvec3 led_to{0};
  };
  enum class Advance { kOn, kArrived, kNear };
  enum class Ending { kDone, kPlacementRefused };

  const Tool& tool() const noexcept { return heads_[tool_].tool; }
  const ContactFinder& finder() const noexcept { return heads_[tool_].finder; }
  NonCuttingContacts& smooth() noexcept { return heads_[tool_].smooth; }
  double reach() const noexcept { return heads_[tool_].reach; }
  /// Voxels, lower bound; valid if positive.
  double free_distance(const dvec3& c) const noexcept { return sample_linear(patch_, c) - reach(); }
  /// The whole tool. `X_VT`; `head_free`: for the head alone.
  double free_distance(const Pose& X_VT, double head_free) noexcept;

  // proxy.cpp.
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
  /// Returns true if the head neither cuts nor fills.
  bool only_touches(const ContactInput& in) const noexcept { return !in.cuts && tool().fill == Tissue::kAir; }
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

  // removal.cpp.
  bool carve_head(const ContactInput& in, const Contact& contact, Cut& cut, double& energy) noexcept;
  /// in.X_WG to X_WB, fine and coarse patch. True, with `cut`: changed.
  bool remove_sweep(const ContactInput& in, const Pose& X_WB, Cut& cut, double& energy) noexcept;
  void carve_coarse(const Pose& X_WA, const Pose& X_WB, bool continues, bool may_wait) noexcept;
  void finish_coarse() noexcept;
  VoxelFrame coarse_frame() const noexcept {
    return {settings_.frame.origin, voxel() * patch_.coarse_levels.front().every};
  }
  PerTissue repeat(const CutLog::Made& made, std::uint64_t index, SurfacePatch& fresh) noexcept override;
  void update_coarse(SurfacePatch& fresh, bool edited) noexcept override;
  void adopted(bool strokes_edited, bool known) noexcept override;

  // filling.cpp.
  bool fill(const ContactInput& in, Contact& contact, Cut& cut) noexcept;
  bool place_filling(const ContactInput& in, const Contact& contact, Cut& cut) noexcept;
  bool begin_dome(const Pose& X_WH, double reach) noexcept;
  bool search_open_place(const Fill& instrument, double reach) noexcept;

  double hardest_ = 0;  // J/m³, largest specific energy of all tissues
  std::vector<Head> heads_;
  std::uint32_t tool_ = 0;
  Step step_;
  ContactSet contacts_;  // contacts found in the last iteration

  // Proxy, between ticks.
  HeldBy held_;           // last tick's contacts
  bool emptied_ = false;  // the last cut emptied the head
  // voxels; decays while it is led out
  double overlap_ = 0;
  bool sunk_ = false;  // while it is led out of deep tissue
  // 0..1 of power at a harder wall, last tick; 0: no wall
  double wall_ = 0;
  bool breaking_through_ = false;
  double lost_for_ = 0;  // s outside the patch
  // N when the patch became late: a plane stands for the tissue, yielding to clearly more; 0: not late
  double bridge_push_ = 0;
  dvec3 bridge_from_{0};  // voxels, head's centre then
  // s left of the smooth return
  double rejoining_ = 0;
  struct Retreat {
    RetreatPath path;
    dvec3 held_at{0};      // voxels, where contacts hold the proxy
    double held_for = 0;   // s near held_at with the hand far away
    bool leading = false;  // led back along its path
    std::size_t to = 0;    // path point of the way back
    bool wedged = false;   // hand away, no way back
  } retreat_;
  struct Fall {
    dvec3 push_mean{0};  // N, low-pass push on the head
    // m/s, hand's velocity, short and long time constant
    dvec3 hand_speed{0}, hand_mean{0};
  } fall_;

  // Removal, between ticks: what the head can still change.
  CutFront front_, coarse_front_;  // fronts of both patches
  Pose cut_end_;                   // at the last cut's end
  std::uint32_t cut_tool_ = 0;     // of the last cut
  // For the shank; joins fine cuts, and may wait.
  struct CoarseCut {
    Pose X_WA, X_WB;         // start and end
    std::uint64_t cut = 0;   // last fine cut in it
    std::uint32_t tool = 0;  // tool of the cut
    bool goes_on = false;    // the last coarse cut ended at X_WA
    int waits = 0;           // ticks; 0: none waits
  } coarse_;

  struct Filling {
    double owed = 0;     // m³ delivered, not placed
    double radius = -1;  // voxels; negative: none
    // of its surface, free in the last tick
    double free_fraction = 1;
    // voxels: dome's centre; free end when it began
    dvec3 center{0}, end{0};
    // voxels, of the first dome; the search starts here
    dvec3 root{0};
    bool idle = false;  // could hardly grow in the last tick
  } filling_;
  // Along rays from the first dome, all together, so nearest first.
  struct OpenPlaceSearch {
    struct Ray {
      int next = 0;       // next sample
      int in_tissue = 0;  // samples inside, in a row
    };
    static constexpr int kNever = 1 << 30;
    int looks = 0;        // samples so far
    std::size_t way = 0;  // index of the ray that is examined next
    std::array<Ray, FillingParameters::directions> rays{};
  } open_place_search_;
  // empty: no tool fills
  std::vector<glm::vec3> flow_directions_;
};

}  // namespace typodont::haptics::offset
