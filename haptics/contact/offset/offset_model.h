// The part of the contact model "offset" (README.md) that runs on the servo thread: planes from a distance field keep a
// god-object outside the tissue.
#pragma once

#include <array>
#include <vector>

#include "haptics/contact/offset/parameters.h"
#include "haptics/contact/offset/retreat_path.h"
#include "haptics/contact/patch_model.h"
#include "haptics/contact/proxy/nearest_allowed.h"
#include "haptics/contact/proxy/smooth_contacts.h"
#include "haptics/cut_front.h"
#include "haptics/fill.h"

namespace typodont::haptics::offset {

/// Servo thread. Lengths are in voxels unless a unit is given; V is the voxel frame.
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
  /// A tool with the data that set-up prepares for it.
  struct Head {
    Tool tool;
    ContactFinder finder;
    NonCuttingContacts smooth;  // contacts of the shank and the safe end
    double reach;               // voxels, distance from the head's centre to the farthest point of head and safe end
  };

  /// State of the tick that is being computed.
  struct Step {
    dvec3 start{0}, c{0};       // the head's centre at the start of the tick, and now
    dvec3 target{0};            // position of the head's centre that corresponds to the hand's pose
    dvec3 shift{0};             // the hand's motion since the last tick
    double slack = 0;           // voxels, depth that the head may sink in this tick, limited by the energy budget
    double slack_at_walls = 0;  // fraction of slack that remains at a wall
    double overlap_before = 0;
    double pace_per_slew = 0;  // voxels, displacement of the proxy in a tick that changes the force at 1 N/s
    bool paced = false;        // true if the proxy's speed relative to the hand is limited in this tick
    dvec3 fall_normal{0};      // unit vector against the hand's fall; zero if the hand does not fall
    double fall_limit = 0;     // voxels, largest distance that the falling head may go down in this tick
    // vector from the hand to the position at which contacts and energy debt alone hold the head; zero if nothing
    // holds it
    dvec3 held_off{0};
    ActivePlanes active{};  // indices of the contacts that hold the head
    // the members of Contact with the same names
    bool touching = false, lost = false, deep = false, bridging = false, late = false;
  };

  /// State of one search, carried from iteration to iteration.
  struct Search {
    dvec3 found_at{0};  // the head's centre when the contacts were last searched
    dvec3 last_step{0};
    double last_gain = 1, last_length = 0;
    int settled = 0;       // number of iterations that ended among contacts
    dvec3 long_step{0};    // the last step that was too long to be made in one iteration
    int reversals = 0;     // number of long steps in the direction opposite to the previous long step
    bool at_pace = false;  // true if the speed limit, not a contact, limited the last step
    dvec3 held_at{0};      // position of the head's centre that the contacts alone determine
    dvec3 led_to{0};       // target of the hand, moved by the grip of the teeth if they hold the head
  };
  enum class Advance { kOn, kArrived, kNear };
  enum class Ending { kDone, kPlacementRefused };

  const Tool& tool() const noexcept { return heads_[tool_].tool; }
  const ContactFinder& finder() const noexcept { return heads_[tool_].finder; }
  NonCuttingContacts& smooth() noexcept { return heads_[tool_].smooth; }
  double reach() const noexcept { return heads_[tool_].reach; }
  /// Lower bound of the head's distance to tissue. Valid only if it is positive.
  double free_distance(const dvec3& c) const noexcept { return sample_linear(patch_, c) - reach(); }
  /// Lower bound of the whole tool's distance to tissue, computed from the lower bound of the head's distance.
  double free_distance(const Pose& X_VT, double head_free) noexcept;

  // Functions for the pose of the proxy (proxy.cpp).
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

  // Functions for cuts, and for bringing a fresh patch up to date (removal.cpp).
  bool carve_head(const ContactInput& in, const Contact& contact, Cut& cut, double& energy) noexcept;
  /// Removes the sweep of the head from in.X_WG to X_WB in all patches. Returns true and a Cut if any sample changed.
  bool remove_sweep(const ContactInput& in, const Pose& X_WB, Cut& cut, double& energy) noexcept;
  void carve_coarse(const Pose& X_WA, const Pose& X_WB, bool continues) noexcept;
  PerTissue repeat(const CutLog::Made& made, std::uint64_t index, SurfacePatch& fresh) noexcept override;
  void update_coarse(SurfacePatch& fresh, bool edited) noexcept override;
  void adopted(bool strokes_edited, bool known) noexcept override;

  // Functions for filling instruments (filling.cpp).
  bool fill(const ContactInput& in, Contact& contact, Cut& cut) noexcept;
  bool place_filling(const ContactInput& in, const Contact& contact, Cut& cut) noexcept;
  bool begin_dome(const Pose& X_WH, double reach) noexcept;
  bool search_open_place(const Fill& instrument, double reach) noexcept;

  double hardest_ = 0;  // J/m³, the greatest specific energy of all tissues
  std::vector<Head> heads_;
  std::uint32_t tool_ = 0;
  Step step_;
  ContactSet contacts_;  // contacts of the last iteration

  // State of the proxy, kept from tick to tick.
  HeldBy held_;           // normals of the contacts that held the head in the last tick
  bool emptied_ = false;  // true if the last tick removed all tissue inside the head
  double overlap_ = 0;    // voxels, overlap with tissue that remains to be resolved by moving the head out
  double wall_ = 0;       // Contact::wall of the last tick
  bool breaking_through_ = false;
  double lost_for_ = 0;     // s, time since the patch last contained the tool
  double bridge_push_ = 0;  // N, force of the last contact, whose plane replaces a late patch; 0: no plane replaces it
  dvec3 bridge_from_{0};    // the head's centre where the snapshot ended
  double rejoining_ = 0;    // s, remaining time of the smooth return from a bridging plane to the surface
  struct Retreat {
    RetreatPath path;
    dvec3 held_at{0};      // voxels, place at which the proxy has rested
    double held_for = 0;   // s, time for which the proxy has rested at held_at while the hand was far away
    bool leading = false;  // true while the proxy is led back along the path
    std::size_t to = 0;    // index of the point of the path to which the proxy is led
    bool wedged = false;   // true if the hand has moved away and no path back was found
  } retreat_;
  struct Fall {
    dvec3 push_mean{0};                 // N, mean push of the tissue on the head
    dvec3 hand_speed{0}, hand_mean{0};  // m/s, short-term and long-term mean of the hand's velocity
  } fall_;

  // State of the removal.
  CutFront front_, coarse_front_;  // fronts of the patch and of its coarse patch
  Pose cut_end_;                   // pose at the end of the last cut
  std::uint32_t cut_tool_ = 0;     // tool of the last cut
  Pose coarse_end_;                // pose at the end of the last cut in the coarse patch
  std::uint64_t coarse_cut_ = 0;   // index of the last cut in the coarse patch

  struct Filling {
    double owed = 0;           // m³, filling that is due but not yet placed
    double radius = -1;        // voxels, radius of the growing dome; negative: no dome exists
    double free_fraction = 1;  // fraction of the dome's surface that is free, estimated in the last tick
    dvec3 center{0}, end{0};   // the dome's centre; the instrument's end when the dome was begun
    dvec3 root{0};  // place where the first dome was begun; filling that does not fit there flows on from this place
    bool idle = false;  // true if the dome could hardly grow in the last tick
  } filling_;
  // Search for open places along straight rays from the root. All rays are searched to the same distance, so the
  // nearest open place is found first.
  struct OpenPlaceSearch {
    struct Ray {
      int next = 0;       // number of the sample at which this ray is examined next
      int in_tissue = 0;  // number of consecutive samples inside tissue
    };
    static constexpr int kNever = 1 << 30;
    int looks = 0;        // number of samples that all rays have completed
    std::size_t way = 0;  // index of the next ray; rays with a smaller index have one more sample
    std::array<Ray, FillingParameters::directions> rays{};
  } open_place_search_;
  std::vector<glm::vec3> flow_directions_;  // unit vectors; empty if no tool fills
};

}  // namespace typodont::haptics::offset
