// The offset method, servo's half: a god-object kept outside the tissue by planes from a distance field (README.md).
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

/// Servo thread. Lengths in voxels where nothing else is said; V is the voxel frame.
class OffsetModel : public PatchModel {
 public:
  explicit OffsetModel(const ServoSettings& settings);

  double clearance(const Pose& X_WG) noexcept override;
  bool turns_matter() const noexcept override { return heads_[tool_].smooth.any(); }
  void begin_anew() noexcept override;
  void release() noexcept override;
  bool may_take_up(std::uint32_t tool, const Pose& X_WG) noexcept override;
  void take_up(std::uint32_t tool) noexcept override;
  void constrain(const ContactInput& in, Contact& out) noexcept override;
  bool cut(const ContactInput& in, Contact& contact, Cut& cut, double& energy) noexcept override;
  void feel(const ContactInput& in, Contact& out) noexcept override;

 protected:
  /// A tool, made ready at set-up.
  struct Head {
    Tool tool;
    ContactFinder finder;
    SmoothContacts smooth;  // shank and safe end
    double reach;           // of head and safe end
  };

  /// The tick that is being computed.
  struct Step {
    dvec3 start{0}, c{0};       // the head's centre, before and after
    dvec3 target{0};            // the hand
    dvec3 shift{0};             // the hand's motion since the last tick
    double slack = 0;           // depth that the head may sink to …
    double slack_at_walls = 0;  // … and the fraction of it that a wall leaves
    double overlap_before = 0;
    double pace_per_slew = 0;  // motion of the proxy that changes the force by 1 N/s
    bool paced = false;        // the proxy must keep a pace relative to the hand
    dvec3 fall_normal{0};      // unit, against the hand's fall; zero where it does not fall
    double fall_limit = 0;     // by which the head may go down
    dvec3 held_off{0};         // from the hand to where contacts and debt alone hold the head; zero where they do not
    ActivePlanes active{};     // which contacts hold the head
    bool touching = false, lost = false, deep = false, bridging = false, late = false;  // see Contact
  };

  /// What one search carries from iteration to iteration.
  struct Search {
    dvec3 found_at{0};  // the head's centre when the contacts were found
    dvec3 last_step{0};
    double last_gain = 1, last_length = 0;
    int settled = 0;       // iterations that ended among contacts
    dvec3 long_step{0};    // the last step that was too long to be made at once
    int reversals = 0;     // such steps against the one before
    bool at_pace = false;  // the pace, not a contact, limits the last step
    dvec3 held_at{0};      // where contacts alone hold the head
    dvec3 led_to{0};       // the target, or where the teeth's grip leads the head
  };
  enum class Advance { kOn, kArrived, kNear };
  enum class Ending { kDone, kSeatRefused };

  const Tool& tool() const noexcept { return heads_[tool_].tool; }
  const ContactFinder& finder() const noexcept { return heads_[tool_].finder; }
  SmoothContacts& smooth() noexcept { return heads_[tool_].smooth; }
  double reach() const noexcept { return heads_[tool_].reach; }
  /// A lower bound of the head's distance to tissue; right only as far as it is positive.
  double free_distance(const dvec3& c) const noexcept { return sample_linear(patch_, c) - reach(); }
  /// The same of the whole tool.
  double free_distance(const Pose& X_VT, double head_free) noexcept;

  // proxy.cpp: where the tool may be.
  void begin_step(const ContactInput& in) noexcept;
  void follow_fall(const ContactInput& in) noexcept;
  void move_proxy(const ContactInput& in) noexcept;
  bool seat_ball(const ContactInput& in, bool& alone) noexcept;
  Ending search(const ContactInput& in, Search& s, bool seated) noexcept;
  Advance advance_free(const ContactInput& in, Search& s, double& head_free) noexcept;
  void find_contacts(const ContactInput& in, Search& s, double head_free) noexcept;
  void look_around(const ContactInput& in, const dvec3& c, bool center_inside) noexcept;
  dvec3 project(const ContactInput& in, Search& s, bool& comes_free) noexcept;
  dvec3 refine_and_project(const ContactInput& in, Search& s, dvec3 next) noexcept;
  dvec3 extrapolate(Search& s, const dvec3& step) noexcept;
  void find_room_to_sink(const ContactInput& in) noexcept;
  bool nothing_in_the_way(const ContactInput& in) const noexcept;
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

  // removal.cpp: what a cut takes, and how a fresh patch is brought up to date.
  bool carve_head(const ContactInput& in, const Contact& contact, Cut& cut, double& energy) noexcept;
  /// Removes what the head sweeps from in.X_WG to X_WB, in all patches. True and a Cut when that changed something.
  bool take_away(const ContactInput& in, const Pose& X_WB, Cut& cut, double& energy) noexcept;
  void carve_coarse(const Pose& X_WA, const Pose& X_WB, bool continues) noexcept;
  PerTissue repeat(const CutLog::Made& made, std::uint64_t index, SurfacePatch& fresh) noexcept override;
  void update_coarse(SurfacePatch& fresh, bool edited) noexcept override;
  void adopted(bool strokes_edited, bool known) noexcept override;

  // filling.cpp: what an instrument puts down.
  bool fill(const ContactInput& in, Contact& contact, Cut& cut) noexcept;
  bool put_down(const ContactInput& in, const Contact& contact, Cut& cut) noexcept;
  bool begin_dome(const Pose& X_WH, double reach) noexcept;
  bool flow_on(const Fill& instrument, double reach) noexcept;

  double hardest_ = 0;  // J/m³, the greatest specific energy of all tissues
  std::vector<Head> heads_;
  std::uint32_t tool_ = 0;
  Step step_;
  ContactSet contacts_;  // of the last iteration

  // The proxy, from tick to tick.
  HeldBy held_;           // the normals that held it last
  bool emptied_ = false;  // the last tick removed all that lay in the head
  double overlap_ = 0;    // still being led out
  double wall_ = 0;       // Contact::wall of the last tick
  bool breaking_through_ = false;
  double lost_for_ = 0;     // s without a snapshot under the tool
  double bridge_push_ = 0;  // N of the contact whose plane stands in for it; 0: none does
  dvec3 bridge_from_{0};    // the head where the snapshot ended
  double rejoining_ = 0;    // s left to find back from the bridge to the surface
  struct Retreat {
    RetreatPath path;
    dvec3 held_at{0};      // voxels, where the proxy has been …
    double held_for = 0;   // … for so many s, with the hand far away
    bool leading = false;  // the proxy is being led back, …
    std::size_t to = 0;    // … to this point of the path
    bool wedged = false;   // the hand has left, and no way back is known
  } retreat_;
  struct Fall {
    dvec3 push_mean{0};                 // N
    dvec3 hand_speed{0}, hand_mean{0};  // m/s, now and of late
  } fall_;

  // Removal.
  CutFront front_, coarse_front_;  // of the patch and of its coarse patch
  Pose cut_end_;                   // where the last cut ended …
  std::uint32_t cut_tool_ = 0;     // … and of which tool
  Pose coarse_end_;                // where the last cut in the coarse patch ended …
  std::uint64_t coarse_cut_ = 0;   // … and which cut that was

  struct Filling {
    double owed = 0;           // m³
    double radius = -1;        // of the dome that grows; negative: none
    double free_fraction = 1;  // of its surface, as far as is known
    dvec3 center{0}, end{0};   // of the dome; the instrument's end when the dome was begun
    dvec3 root{0};             // where it was begun: what finds no room flows on from here
    bool idle = false;         // the last tick found hardly any room in the dome
  } filling_;
  struct Outlook {  // from the root along straight ways, all looked at equally far: nothing nearer is open
    struct Way {
      int next = 0;       // the look at which it is looked at again
      int in_tissue = 0;  // looks since the last one outside tissue
    };
    static constexpr int kNever = 1 << 30;
    int looks = 0;        // along each way, …
    std::size_t way = 0;  // … and one more along those before this one
    std::array<Way, FillingParameters::directions> ways{};
  } outlook_;
  std::vector<glm::vec3> flow_directions_;  // unit; empty where nothing fills
};

}  // namespace typodont::haptics::offset
