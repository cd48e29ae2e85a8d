// What a servo carries from tick to tick, and the parts a tick consists of, one file each: proxy, cutting, filling,
// force, limits. Servo::tick in servo.cpp calls them in turn.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "haptics/contact/nearest_allowed.h"
#include "haptics/contact/smooth_contacts.h"
#include "haptics/cut_front.h"
#include "haptics/forces/friction.h"
#include "haptics/forces/passivity.h"
#include "haptics/forces/tip.h"
#include "haptics/forces/velocity_estimator.h"
#include "haptics/servo.h"
#include "haptics/servo/cut_log.h"

namespace typodont::haptics {

constexpr double kPedalUp = 0.01;    // of the pedal's way, and of the free speed: the drill stands
constexpr double kFreeSlew = 14;     // N/s, of a force that ends because the bur broke through
constexpr double kDebt = 2e-9;       // J, more than rounding costs
constexpr double kNoHand = 2.0;      // m/s: what moves faster is a leap of the input, not a hand
constexpr double kLeapTime = 0.05;   // s that the proxy may take to follow a leap
constexpr double kStaleTime = 0.02;  // s a patch may be due before that is a fault

/// The largest share of a step, 0..1, with |rest + share step| <= most, or what comes nearest to that.
double largest_share(const dvec3& step, const dvec3& rest, double most);

/// The tick that is being computed: each part reads what those before it found. SI; what is in voxels says so. First
/// what every tick has …
struct Now {
  const HandSample& hand;  // as it came in
  ServoTick& out;
  Cut& cut;
  Pose X_WT{};               // of the hand, sound
  double dt = 0;             // s since the last tick, as measured
  dvec3 moved{0};            // m, the hand since the last tick …
  dvec3 turned{0};           // rad, … and its turn
  double given_to_hand = 0;  // J, since the last tick
  std::uint32_t faults = 0;

  // Drilling.
  bool scrapes = false;  // an edge that the hand draws
  bool may_cut = false;
  bool in_debt = false;        // that edge has not paid yet for what gave way
  double specific_energy = 0;  // J/m³, of the tissue under a head that cuts
  SpindleLoad spindle{};
  double tangential = 0;  // force of the teeth over normal force
};

/// … then what only one has that may touch something.
struct Touch : Now {
  explicit Touch(const Now& now) noexcept : Now(now) {}

  // The proxy.
  dvec3 c0{0}, c{0};          // voxels, before and after
  dvec3 target{0};            // voxels, the hand
  double slack = 0;           // voxels that the head may sink …
  double slack_at_walls = 0;  // … and what share of it a wall lets through
  double overlap_before = 0;  // voxels
  double pace_per_slew = 0;   // voxels that the proxy may move for each N/s
  bool paced = false;         // … where the hand must feel no step: what it is led by changes by that at most
  dvec3 carried{0};           // voxels by which it led in the last tick
  dvec3 falls_n{
      0};  // unit, against the way that a hand falls which the bur holds up no more; zero where it does not: …
  double falls = 0;  // … voxels that the head may go that way at most
  dvec3 held_off{
      0};  // voxels from the hand to where contacts and debt alone hold the head, without pace; zero where they do not
  ActivePlanes active{};
  bool touching = false;
  bool lost = false;      // no field there
  bool deep = false;      // no surface in reach
  bool bridging = false;  // the last contact's plane stands in for the field
  dvec3 p_WG{0};

  // The force.
  dvec3 force{0}, torque{0}, normal{0};
  dvec3 spindle_force{0};  // what the spindle feeds to the hand, …
  dvec3 teeth_force{0};    // … and what of it the teeth do
  dvec3 p_held{0};         // where the tool is held
  double stored = 0;       // J in the coupling
};

struct Servo::State {
  struct Held {  // a tool of the tray, made ready at set-up
    Tool tool;
    ContactFinder finder;
    SmoothContacts smooth;
    double reach;  // voxels, of head and safe end
  };
  ServoSettings settings;
  std::vector<Held> tools;
  std::uint32_t in_hand = 0;
  double travel;  // m
  SurfacePatch patch;
  CutLog log;
  ContactSet contacts;  // of the last look
  HeldBy held;          // … and what held the head in it
  bool carved = false;  // the last tick emptied the head's place

  // Where the tool is held outside the tissue.
  Pose X_WG;
  bool placed = false;  // X_WG says something
  bool started = false;
  double overlap = 0;      // voxels of overlap still being led out
  double leap = 0;         // s left to follow a leap of the input
  Nanos began = 0;         // when the hand came, or came back
  double lost_for = 0;     // s without a field under the tool
  double bridge_push = 0;  // N of the contact whose plane stands in for the field; 0: none does
  dvec3 bridge_from{0};    // voxels, the head where the field ended
  bool unpaid = false;     // the ledger holds far less energy than the coupling: the force is that of the ledger's
  double rejoining = 0;    // s left to find back from the bridge to the surface
  double due_for = 0;      // s that a new patch has been due
  bool idle = false;       // the last tick left nothing of a contact
  double room_around = 0;  // voxels that a tool which touches nothing may still move before it must look around
  Pose last_hand;
  dquat came_R{0, 0, 0, 0}, R_WT{1, 0, 0, 0};  // how the hand last came in turned, and that as a unit
  Nanos last_t = 0;

  // Force.
  double stiffness_share = 1;  // of the coupling, by the tissue under the head
  double normal_force = 0;     // N, last tick
  double head_force = 0;       // N, what of it lies on the part that cuts
  dvec3 normal{0};
  dvec3 pressed{0};     // unit, the way contacts and debt push the head, …
  double pressing = 0;  // N, … and what of head_force lies along it: the rest leads a proxy that follows at a pace
  dvec3 push_mean{0};   // N, of late, of a bur that must keep a pace …
  dvec3 hand_speed{0};  // m/s, … and the hand's then, without its roughness, …
  dvec3 hand_mean{0};   // m/s, … and of late
  FrictionState friction;
  TipState tip;
  PassivityLaw passivity_law;
  PassivityState passivity;
  double rate = 0;                // m/s, smoothed, of the depth …
  VelocityEstimator depth_speed;  // … where the hand moves by counts, whose differences would be felt as a buzz
  double last_depth = 0;          // m
  double given = 0;               // J that leading the tool out of tissue put into the coupling
  double stored = 0;              // J in the coupling
  double ramp = 0;                // 0..1, of the force at start and end
  bool ending = false;
  dvec3 torque{0};              // N·m, of the contacts
  dvec3 last_torque{0};         // N·m, as sent and felt
  dvec3 last_force{0};          // N, what the tissue gave …
  dvec3 teeth_force{0};         // N, of the teeth before the limits
  dvec3 last_spindle_force{0};  // N, … and what the spindle fed through the teeth
  dvec3 last_sent{0};           // N, their sum as sent
  double spindle_work = 0;      // J, done by the spindle in cutting …
  double teeth_energy = 0;      // J, … and what its teeth gave the hand of that
  dvec3 last_teeth_force{0};    // N
  double phase = 0;             // rad, of the spindle

  // Cutting.
  double hardest = 0;             // J/m³, the greatest specific energy of all tissues
  double speed = 0;               // rad/s, free running
  bool breaking_through = false;  // the bur is free, but the hand has not caught up
  double budget = 0;              // J that may still be spent on cutting …
  double wall = 0;  // … and where a wall held the head in the last tick: the share of the power, 0..1, that is left,
  double wall_budget = 0;      // … and J of it
  PerTissue shares{};          // of the tissue under the head
  CutFront front;              // of the patch
  Pose cut_end;                // where the last cut ended …
  std::uint32_t cut_tool = 0;  // … and of which tool
  Pose wide_end;               // where the last cut in the wide patch ended
  std::uint64_t wide_cut = 0;  // … and which cut that was
  struct Filling {
    double owed = 0;          // m³
    double radius = -1;       // voxels, of the dome that grows; negative: none
    double share = 1;         // of its surface that is free, as far as is known
    dvec3 center{0}, end{0};  // voxels, of the dome, and where the instrument's end was when it was begun …
    dvec3 root{0};            // … there: what finds no room in its dome flows on from here
    bool idle = false;        // the last tick found hardly any room in the dome
  } filling;
  static constexpr std::size_t kFlowWays = 2048;
  struct Outlook {  // from that root along straight ways, all of them equally far: nothing nearer is open
    struct Way {
      int next = 0;       // look
      int in_tissue = 0;  // looks since the last outside tissue
    };
    static constexpr int kNever = 1 << 30;
    int looks = 0;        // along each, …
    std::size_t way = 0;  // … and one more along those before this one
    std::array<Way, kFlowWays> ways{};
  } outlook;
  std::vector<glm::vec3> flow_ways;  // unit; of a scene in which nothing fills, none

  ServoTick sums;  // carries index, removed, energy, cuts

  State(const ServoSettings& s, int edge);

  const Tool& tool() const noexcept { return tools[in_hand].tool; }
  const ContactFinder& finder() const noexcept { return tools[in_hand].finder; }
  SmoothContacts& smooth() noexcept { return tools[in_hand].smooth; }
  double reach() const noexcept { return tools[in_hand].reach; }

  /// A lower bound of the head's distance to tissue, voxels; only right as far as it is positive.
  double clearance(const dvec3& c) const noexcept { return sample_linear(patch, c) - reach(); }
  /// Mean of a material's property over the tissue under the head.
  double mean(double Material::*member) const noexcept {
    double sum = 0, total = 0;
    for (std::size_t i = 1; i < shares.size(); ++i) {
      sum += shares[i] * settings.materials[i].*member;
      total += shares[i];
    }
    return total > 0 ? sum / total : 0;
  }

  // servo.cpp
  /// A tick without a sound pose or without a hand: no force, and what follows begins anew.
  void rest(Now& now, bool sound) noexcept;
  void begin_anew(const Pose& X_WT, Nanos t) noexcept;
  /// The ledger: what the device did to the hand since the last tick. Inlined: through memory, a pose is read in other
  /// pieces than it was just written in, and waits until those have arrived.
  [[gnu::always_inline]] inline void account(Now& now, bool turns) noexcept;
  /// The spindle's free speed follows the pedal.
  void run_spindle(const Now& now) noexcept;
  /// Takes what the hand wants, where neither that tool nor the one in the hand touches or turns.
  void change_tool(Now& now) noexcept;
  void remember(Touch& now, const dvec3& felt_torque) noexcept;

  // servo/proxy.cpp
  /// Whether that tool, held with its head at X_VT (voxels), would touch nothing. Uses `contacts`.
  bool would_be_free(std::uint32_t which, const Pose& X_VT) noexcept;
  /// The rest of a tick of a tool that is far from everything, and was before: what the long way comes to when no
  /// contact, force or state of one is left. False, and nothing done, where there may be more to it.
  bool fly(Now& now) noexcept;
  /// Moves the proxy toward the hand: freely while nothing is near, along the contacts otherwise.
  void move_proxy(Touch& now) noexcept;
  /// A bur that comes free follows the hand at a pace; beyond the patch the last contact's plane goes on.
  void follow(Touch& now) noexcept;

  // servo/cutting.cpp
  /// The energy that may be spent on cutting in this tick, from the push of the last.
  void earn(Now& now) noexcept;
  /// Cuts everything the head sweeps on its way. True and a Cut when that changed something.
  bool take_away(Touch& now) noexcept;
  /// Brings a fresh patch up to date with the cuts made since it was cut out.
  void catch_up(SurfacePatch& fresh) noexcept;

  // servo/filling.cpp
  /// Puts down this tick's share of filling, when there is tissue in reach to put it on. True and a Cut when it did.
  bool fill(Touch& now) noexcept;

  // servo/force.cpp
  /// What the contact gives the hand: coupling, damper, friction, teeth.
  void feel(Touch& now) noexcept;
  /// A sharp tip in softened tissue: sinks under a push, holds on withdrawal.
  void sink_tip(Touch& now) noexcept;
  /// What the spindle sends through the arm.
  void vibrate(Touch& now) noexcept;

  // servo/limits.cpp
  /// Limits of the device, of its slew, and the ramps at start and end.
  void limit(Touch& now) noexcept;
  /// Never gives the hand energy that it did not put in: the controller, and the ledger's allowances. Returns what of
  /// the torque the hand's arm can give.
  dvec3 keep_passive(Touch& now) noexcept;

 private:
  /// Where the contacts' push attacks, from the head's centre, how it turns it, and what of it lies where; voxels.
  struct Push {
    dvec3 lever{0}, torque{0}, on_head{0}, on_smooth{0};
  };
  void lead_out(Touch& now) noexcept;
  void follow_fall(Touch& now) noexcept;
  double wall_at(const ContactPlane& plane) const noexcept;
  double wall_of(const ActivePlanes& active) const noexcept;
  bool hold_at_walls(const ActivePlanes& active, double yields) noexcept;
  void look_around(Touch& now, const dvec3& c, bool center_inside) noexcept;
  void find_room_to_sink(Touch& now) const noexcept;
  bool nothing_in_the_way(const Touch& now) const noexcept;
  dvec3 ease(Touch& now, const dvec3& c, const dvec3& carried, double most, const dvec3& pulled_to,
             dvec3& next) const noexcept;
  double share_in_debt(const Touch& now) const noexcept;
  Push feel_tissue(const Touch& now, bool many_contacts) noexcept;
  double spare_change(const Touch& now, double depth) const noexcept;
  double follow_stiffness(const Touch& now, double depth) noexcept;
  double damped(const Touch& now, double push, double depth, double sinking) noexcept;
  void feel_teeth(Touch& now) noexcept;
  void take_up(std::uint32_t which) noexcept;
  bool put_down(Touch& now) noexcept;
  bool begin_dome(const Pose& X_WH, double reach) noexcept;
  bool flow_on(const Fill& instrument, double reach) noexcept;
  void repeat_cuts(SurfacePatch& fresh) noexcept;
  void carve_wide(const Pose& X_WA, const Pose& X_WB, bool continues) noexcept;
  void update_wide(SurfacePatch& fresh, bool repeat) noexcept;
};

}  // namespace typodont::haptics
