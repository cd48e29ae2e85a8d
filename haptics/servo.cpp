#include "haptics/servo.h"

#include <algorithm>
#include <array>
#include <climits>
#include <cmath>
#include <utility>

#include "engine/base/check.h"
#include "engine/base/units.h"
#include "haptics/contact/contact_planes.h"
#include "haptics/contact/smooth_contacts.h"
#include "haptics/cut_front.h"
#include "haptics/forces/friction.h"
#include "haptics/forces/passivity.h"
#include "haptics/forces/tip.h"
#include "haptics/forces/velocity_estimator.h"

namespace typodont::haptics {

namespace {

// All lengths in voxels unless said otherwise.
constexpr double kContactRange = 0.8;      // contacts farther away than this do not matter yet …
constexpr double kContactStep = 0.6;       // … because a step among several is no longer than this
constexpr double kStep = 1.5;              // longest step between two looks at the contacts: nothing thinner is skipped
constexpr double kConverged = 1e-6;        // the proxy has come to rest,
constexpr double kForeseen = 1e-7;         // … or will have, within this
constexpr double kSettled = 2e-5;          // the same where several contacts were looked at,
constexpr double kSettledCutting = 3e-3;   // … and while they are cut, which leaves them rough by more
constexpr int kSettlingLooks = 8, kSettlingLooksCutting = 5;
constexpr int kRefiningRounds = 6;         // of a head that does not cut
constexpr double kStillConverges = 0.95;   // share that a step may be of the one before …
constexpr double kMostGain = 10;           // … and how many steps may be made at once
constexpr double kBlur = 0.2;              // what interpolation makes of a narrow cut: 0.09 where a ball is 3 voxels in radius
constexpr double kSamePoints = 0.3;        // contacts found less than this ago, in voxels of way, still serve
constexpr double kToothGrip = 0.15;        // engaged teeth resist being led sideways up to this share of the push
constexpr double kMostSlack = 1.0;         // deeper in one tick the surface that was found says nothing
constexpr int kMaxLooks = 48;              // per tick, free flight included
constexpr double kDeep = 0.6;              // more overlap than cutting or rounding leaves: led out slowly
constexpr double kRecoveryTime = 0.006;    // s, time constant of leading the tool out of tissue
constexpr double kBudgetTime = 0.05;       // s, cutting energy that may wait for a voxel to yield
constexpr double kStiffnessTime = 4e-3;    // s, the stiffness felt follows the tissue under the head
constexpr double kCutDampingTime = 4e-3;   // s, the depth's rate is smoothed over this for the damper while cutting
constexpr double kLeapTime = 0.05;         // s that the proxy may take to follow a leap
constexpr double kNoHand = 2.0;            // m/s: what moves faster is a leap of the input, not a hand
constexpr double kLostHand = 0.02;         // m: so far from where it was, a hand that comes back starts anew
constexpr double kCutSlew = 6;            // N/s, no faster does the proxy change the force of a cutting contact
constexpr double kGripSlew = 9;            // N/s, no faster does the force rise when the teeth catch
constexpr double kTissueSlew = 4;          // N/s, no faster does another tissue under the head change the force …
constexpr double kUnpaid = 0.15e-3;        // J, … nor does a harder one store more than the ledger holds, beyond this
constexpr double kDebt = 2e-9;             // J, more than rounding costs
constexpr double kTeethSlew = 4;           // N/s, of the tangential force of the teeth
constexpr double kDamperSlew = 4;          // N/s, of the damper while cutting
constexpr double kCutSlewInAll = 18;       // N/s: the teeth's force waits where with all that changes besides it would be more
constexpr double kTeethAhead = 50;         // ticks for which the spindle's work must suffice, or that force shrinks
constexpr double kFreeSlew = 14;           // N/s, of a force that ends because the bur broke through
constexpr double kStaleTime = 0.02;        // s a patch may be due before that is a fault
constexpr double kBridgeTime = 0.5;        // s for which the last contact's plane stands in for a patch
constexpr double kRejoinTime = 0.3;        // s for finding back from there to the surface without a step
constexpr double kFadeTime = 0.1;          // s, time constant of a force that lost its patch
constexpr double kFillWaits = 0.05;        // s that filling may wait for room
constexpr double kOneSurface = 0.5;        // slope of the field below which a place lies midway between surfaces
constexpr double kFillLook = 0.25;         // voxels between looks for something to fill on
constexpr double kFillStep = 0.25;         // voxels a tick that a dome may grow
constexpr int kCutHistory = 8192;          // cuts a late patch may lack
constexpr double kWideStep = 0.2;          // samples of the wide patch that a head moves between two cuts in it
constexpr double kPedalUp = 0.01;          // of the pedal's way, and of the free speed: the drill stands

/// Boxes of the last cuts, so that a fresh patch is brought up to date only where it may differ.
struct CutBoxes {
  struct Box {
    glm::ivec3 lo{0}, hi{0};
    bool filled = false;
  };
  /// The cut itself, to be made once more in a patch that was edited.
  struct Made {
    Pose X_WA, X_WB;
    std::uint32_t tool = 0;
    bool continues = false;
    double fill_radius = 0;  // m, of a filling around X_WA, pressed by a head at X_WB
    PerTissue removed{};     // voxels³; less than nothing by a filling
  };
  std::array<Box, kCutHistory> boxes;
  std::array<Made, kCutHistory> made;
  std::uint64_t last = 0;

  void add(std::uint64_t index, const glm::ivec3& lo, const glm::ivec3& hi, const Made& cut) noexcept {
    boxes[index % kCutHistory] = {lo, hi, cut.fill_radius > 0};
    made[index % kCutHistory] = cut;
    last = index;
  }
  /// The oldest cut after `index` that is still known.
  std::uint64_t first_after(std::uint64_t index) const noexcept {
    return std::max(index, last >= kCutHistory ? last - kCutHistory : 0) + 1;
  }
  /// Union of the boxes of cuts after `index`; everything when that reaches back too far. False when there is none.
  /// `filled`: whether there was a filling among them.
  bool since(std::uint64_t index, glm::ivec3& lo, glm::ivec3& hi, bool& filled) const noexcept {
    if (index >= last) return false;
    filled = last - index >= kCutHistory;
    lo = glm::ivec3(INT_MAX), hi = glm::ivec3(INT_MIN);
    if (last - index >= kCutHistory) {
      std::swap(lo, hi);
      return true;
    }
    for (std::uint64_t i = index + 1; i <= last; ++i) {
      lo = glm::min(lo, boxes[i % kCutHistory].lo);
      hi = glm::max(hi, boxes[i % kCutHistory].hi);
      filled |= boxes[i % kCutHistory].filled;
    }
    return true;
  }
};

/// A turning head that is pressed into tissue stays where it is until the hand leads it sideways by more than the teeth
/// grip (a friction cone on the god-object): roughness of the cut surface then does not shake the hand. Returns the
/// target as if that grip held back its tangential part. `moved`: the hand since the last tick. The lag sideways grows by
/// `most` at most, so that teeth which catch do not stop the head dead.
dvec3 held_target(const dvec3& from, const dvec3& target, const dvec3& n, const dvec3& moved, double most) {
  const dvec3 pull = from - target;
  const double pushed = glm::dot(pull, n);
  if (!(pushed > 0)) return target;
  const dvec3 sideways = pull - pushed * n;
  const double length = glm::length(sideways);
  const dvec3 lag = sideways * (length > kToothGrip * pushed ? kToothGrip * pushed / length : 1.0);
  const dvec3 change = lag - (sideways + moved - glm::dot(moved, n) * n);  // since the last tick
  const double size = glm::length(change);
  if (size > most && glm::dot(change, lag) > 0) return target + lag - change * (1 - most / size);
  return target + lag;
}

/// The largest share of a step, 0..1, with |rest + share step| <= most, or what comes nearest to that.
double largest_share(const dvec3& step, const dvec3& rest, double most) {
  const double a = glm::dot(step, step), b = -glm::dot(step, rest), d = b * b - a * (glm::dot(rest, rest) - most * most);
  return a > 0 ? std::clamp((b + std::sqrt(std::max(d, 0.0))) / a, 0.0, 1.0) : 1.0;
}

double travel_for(const Tool& tool, double voxel) {
  return std::max({8.0, 1e-3 / voxel, 0.25 * tool.reach() / voxel});
}

bool is_sound(const HandSample& hand) {
  const double norm2 = glm::dot(hand.X_WT.R, hand.X_WT.R);
  return is_finite(hand.X_WT.p) && std::abs(norm2 - 1) < 1e-3 && std::isfinite(hand.pedal) &&
         glm::length(hand.X_WT.p) < 100.0;
}

}  // namespace

int patch_edge_for(std::span<const Tool> tools, double voxel) {
  double half = 0;
  for (const Tool& tool : tools) {
    half = std::max(half, near_reach(tool) / voxel + Sweep::kMargin + 3 + travel_for(tool, voxel));
  }
  return 2 * static_cast<int>(std::ceil(half)) + 1;
}

double patch_travel_for(std::span<const Tool> tools, double voxel) {
  double travel = 1e300;
  for (const Tool& tool : tools) travel = std::min(travel, travel_for(tool, voxel));
  return travel;
}

dvec3 patch_center_for(const dvec3& p_WG, const dvec3& p_WT, double travel) noexcept {
  const dvec3 pull = p_WT - p_WG;
  const double length = glm::length(pull);
  return p_WG + (length > travel / 2 ? pull * (travel / 2 / length) : pull);
}

bool patch_due_for(const dvec3& wanted_W, const dvec3& center_W, double travel) noexcept {
  const dvec3 off = glm::abs(wanted_W - center_W);
  return std::max({off.x, off.y, off.z}) > travel / 2;
}

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
  CutBoxes boxes;
  ContactSet contacts;  // of the last look
  HeldBy held;          // … and what held the head in it
  bool carved = false;  // the last tick emptied the head's place

  // Where the tool is held outside the tissue.
  Pose X_WG;
  bool placed = false;         // X_WG says something
  bool started = false;
  double overlap = 0;          // voxels of overlap still being led out

  // Force.
  double stiffness_share = 1;  // of the coupling, by the tissue under the head
  double normal_force = 0;     // N, last tick
  double head_force = 0;       // N, what of it lies on the part that cuts
  dvec3 normal{0};
  FrictionState friction;
  TipState tip;
  PassivityState passivity;
  double rate = 0;             // m/s, smoothed, of the depth …
  VelocityEstimator depth_speed;  // … where the hand moves by counts, whose differences would be felt as a buzz
  double given = 0;            // J that leading the tool out of tissue put into the coupling
  double stored = 0;           // J in the coupling
  double leap = 0;             // s left to follow a leap of the input
  double ramp = 0;             // 0..1, of the force at start and end
  bool ending = false;
  double bridged = 0;          // s without a field under the tool
  double rejoining = 0;        // s left to find back from the bridge to the surface
  double due_for = 0;          // s that a new patch has been due
  dvec3 torque{0};             // N·m, of the contacts
  dvec3 last_torque{0};        // N·m, as sent and felt
  dvec3 last_force{0};         // N, what the tissue gave …
  dvec3 teeth_force{0};        // N, of the teeth before the limits
  dvec3 last_spindle_force{0}; // N, … and what the spindle fed through the teeth
  dvec3 last_sent{0};          // N, their sum as sent
  double spindle_work = 0;     // J, done by the spindle in cutting …
  double teeth_energy = 0;     // J, … and what its teeth gave the hand of that
  dvec3 last_teeth_force{0};   // N
  double phase = 0;            // rad, of the spindle
  double last_depth = 0;       // m
  bool idle = false;           // the last tick left nothing of a contact
  double room_around = 0;      // voxels that a tool which touches nothing may still move before it must look around
  Pose last_hand;
  Nanos last_t = 0;

  // Cutting.
  double hardest = 0;          // J/m³, the greatest specific energy of all tissues
  double speed = 0;            // rad/s, free running
  bool breaking_through = false;  // the bur is free, but the hand has not caught up
  double budget = 0;           // J that may still be spent on cutting
  PerTissue shares{};          // of the tissue under the head
  struct Filling {
    double owed = 0;     // m³
    double radius = -1;  // voxels, of the dome that grows; negative: none
    double area = 1;     // voxels², of its surface that is free
    dvec3 center{0}, end{0};  // voxels, of the dome, and where the instrument's end was when it was begun
  } filling;

  CutFront front;              // of the patch
  Pose cut_end;                // where the last cut ended …
  std::uint32_t cut_tool = 0;  // … and of which tool
  Pose wide_end;               // where the last cut in the wide patch ended
  std::uint64_t wide_cut = 0;  // … and which cut that was
  ServoTick sums;              // carries index, removed, energy, cuts

  State(const ServoSettings& s, int edge)
      : settings(s), travel(patch_travel_for(tray(s), s.frame.voxel) * s.frame.voxel), depth_speed(s.position_step, 1),
        front(tray(s), s.frame.voxel) {
    for (const Tool& tool : tray(s)) {
      const double h = s.frame.voxel;
      tools.push_back({tool, ContactFinder(tool, h), SmoothContacts(tool, h), near_reach(tool) / h});
    }
    for (const Material& material : settings.materials) hardest = std::max(hardest, material.specific_energy);
    patch.resize(edge);
  }

  const Tool& tool() const noexcept { return tools[in_hand].tool; }
  const ContactFinder& finder() const noexcept { return tools[in_hand].finder; }
  SmoothContacts& smooth() noexcept { return tools[in_hand].smooth; }
  double reach() const noexcept { return tools[in_hand].reach; }

  /// Whether that tool, held with its head at X_VT (voxels), would touch nothing. Uses `contacts`.
  bool would_be_free(std::uint32_t which, const Pose& X_VT) noexcept {
    const ContactFinder& other = tools[which].finder;
    SmoothContacts& parts = tools[which].smooth;
    const double far = tools[which].reach;
    if (!patch.holds(X_VT.p, far + 1)) return false;
    const double distance = sample_linear(patch, X_VT.p);
    parts.forget();
    if (distance > far + 2 && parts.room(patch, X_VT) > kContactRange) return true;
    if (distance <= 0) return false;
    other.find(patch, X_VT, kContactRange, contacts);
    if (parts.any()) parts.find(patch, X_VT, kContactRange, contacts);
    for (int i = 0; i < contacts.count(); ++i) {
      if (contacts.plane(i).gap <= 0) return false;
    }
    return true;
  }

  /// Puts down this tick's share of filling, when there is tissue in reach to put it on. True and a Cut when it did.
  bool fill(const ServoTick& tick, const Pose& X_WH, double dt, Cut& cut) noexcept {
    const Tool& instrument = tool();
    const double h = settings.frame.voxel, reach = instrument.fill_reach / h;
    const double half = instrument.shape == HeadShape::kSphere ? instrument.radius() : instrument.length / 2;
    if (!(tick.pedal > kPedalUp)) {
      filling = {};
      return false;
    }
    filling.owed += instrument.fill_rate * tick.pedal * dt;
    filling.owed = std::min(filling.owed, instrument.fill_rate * kFillWaits);
    if (!(filling.owed > 0)) return false;
    const dvec3 end = settings.frame.to_voxels(X_WH * dvec3(0, 0, -half));
    const double travelled = glm::length(end - filling.end);
    if (filling.radius < 0 || filling.radius >= reach || travelled > std::max(0.5 * filling.radius, 1.0)) {
      if (!patch.holds(end, reach + static_cast<double>(Sweep::kMargin))) return false;
      const FieldSample at = sample_linear_gradient(patch, end);
      const double slope = glm::length(at.gradient);
      if (at.value > reach) return false;  // nothing there to put it on
      filling.center = end;
      if (at.value > 0 && slope >= kOneSurface) {
        filling.center -= at.value / slope * at.gradient / slope;
      } else if (at.value > 0) {  // midway between walls: on what lies before the instrument
        const dvec3 ahead = X_WH.R * dvec3(0, 0, -1);
        double way = 0;
        while (way <= reach && sample_linear(patch, end + way * ahead) > 0) way += kFillLook;
        if (way > reach) return false;
        filling.center += way * ahead;
      }
      filling.end = end;
      filling.radius = 0;
      filling.area = 1;
    }
    // So much larger that the dome's surface makes up the volume that is owed; where the head or tissue hides that surface
    // it finds out, and grows faster.
    const dvec3 center_W = settings.frame.to_world(filling.center);
    double volume = 0;
    PerTissue added{};
    bool changed = false;
    glm::ivec3 lo(0), hi(0);
    for (int tries = 0; tries < 4 && !(volume > 0); ++tries) {
      const double step =
          std::max(std::min({filling.owed / (h * h * h) / filling.area, kFillStep, reach - filling.radius}), 1e-3);
      filling.radius += step;
      const Fill ball(instrument, center_W, filling.radius * h, X_WH, settings.frame);
      bool any;
      added = haptics::fill(patch, ball, &any);
      changed |= any;
      lo = ball.lo(), hi = ball.hi();
      for (const double v : added) volume += v;
      filling.area = std::max(volume / step, 1.0);
    }
    filling.owed -= volume * h * h * h;
    if (!changed) return false;
    front.forget();
    ++sums.cuts;
    cut_tool = in_hand;
    CutBoxes::Made made{{center_W, X_WH.R}, X_WH, in_hand, false, filling.radius * h, added};
    for (double& v : made.removed) v = -v;
    boxes.add(sums.cuts, lo, hi, made);
    cut = {sums.cuts, tick.index, tick.t, {center_W, X_WH.R}, X_WH, in_hand, {}, {}, 0, filling.radius * h};
    for (std::size_t i = 1; i < added.size(); ++i) {
      cut.removed[i] = -added[i] * h * h * h;
      sums.removed[i] += cut.removed[i];
    }
    return true;
  }

  void take_up(std::uint32_t which) noexcept {
    in_hand = which;
    smooth().forget();
    front.forget();
    shares = {};
    stiffness_share = 1;
    budget = 0;
    torque = dvec3(0);
    friction = {};
    tip = {};
    held = {};
  }

  double mean(double Material::*member) const noexcept {
    double sum = 0, total = 0;
    for (std::size_t i = 1; i < shares.size(); ++i) {
      sum += shares[i] * settings.materials[i].*member;
      total += shares[i];
    }
    return total > 0 ? sum / total : 0;
  }

  /// The rest of a tick of a tool that is far from everything, and was before: what the long way comes to when no contact,
  /// force or state of one is left. False, and nothing done, where there may be more to it.
  bool fly(const Pose& X_WT, const dvec3& moved, const dvec3& turned, double dt, Nanos t, ServoTick& out, Cut& cut) noexcept {
    const Tool& head = tool();
    if (!idle || ending || head.fill != Tissue::kAir || settings.filter != ForceFilter::kNone ||
        (settings.vibration.band > 0 && speed > 0)) {
      return false;
    }
    const dvec3 c = settings.frame.to_voxels(X_WG.p);
    if (!patch.holds(c, reach() + 1)) return false;
    const double way = glm::length(X_WT.p - X_WG.p) / settings.frame.voxel;
    // What was free around the last place is so around the next, less the way there: looked at only when that runs out.
    if (!(room_around > 1 && way <= room_around)) {
      room_around = clearance(c) - 1;
      if (smooth().any()) room_around = std::min(room_around, smooth().room(patch, {c, X_WT.R}) - 1);
      if (!(room_around > 1 && way <= room_around)) return false;
    }
    room_around = smooth().any() ? 0 : room_around - way;  // those keep account of their room themselves, turns included

    const bool due = patch_due_for(patch_center_for(X_WG.p, X_WT.p, travel), patch.center_W, travel);
    due_for = due ? due_for + dt : 0;
    out.faults = due_for > kStaleTime ? bits(Fault::kStalePatch) : 0;
    bridged = 0;
    breaking_through = carved = false;
    held.count = 0;
    ramp = 1;
    leap = std::max(0.0, (glm::dot(moved, moved) > kNoHand * kNoHand * dt * dt ? kLeapTime : leap) - dt);
    given = std::clamp(-sums.energy, 0.0, sums.energy < -kDebt ? -sums.energy : given);
    if (settings.position_step > 0) depth_speed.add(t, dvec3(0));
    if (settings.passivity) {
      passive_share({}, dvec3(0), moved, dvec3(0), turned, dt, settings.tick, sums.energy + given, passivity);
    }
    last_hand = X_WG = out.X_WG = X_WT;
    last_t = t;
    cut.n_C_W = dvec3(0);
    out.spindle = speed;
    out.energy = sums.energy;
    out.spindle_energy = sums.spindle_energy;
    return true;
  }

  /// A lower bound of the head's distance to tissue; only right as far as it is positive.
  double clearance(const dvec3& c) const noexcept { return sample_linear(patch, c) - reach(); }

  /// What was cut, in the wide patch too: in longer steps, which its coarser samples cannot tell.
  void carve_wide(const Pose& X_WA, const Pose& X_WB, bool continues) noexcept {
    if (patch.wide.empty()) return;
    const VoxelFrame frame{settings.frame.origin, settings.frame.voxel * patch.wide.front().every};
    const bool goes_on = continues && wide_cut + 1 >= sums.cuts;
    if (!goes_on) wide_end = X_WA;
    const double turned = 2.3 * std::sqrt(std::max(0.0, 2 - 2 * std::abs(glm::dot(X_WB.R, wide_end.R))));
    const double moved = glm::length(X_WB.p - wide_end.p) + turned * tool().reach();
    if (goes_on && moved < kWideStep * frame.voxel) {
      wide_cut = sums.cuts;
      return;
    }
    carve(patch.wide.front(), Sweep(tool(), wide_end, X_WB, frame, goes_on));
    wide_end = X_WB;
    wide_cut = sums.cuts;
  }

  /// Brings a fresh wide patch up to date with the cuts it lacks.
  void update_wide(SurfacePatch& fresh, bool repeat) noexcept {
    if (fresh.wide.empty()) return;
    SurfacePatch& wide = fresh.wide.front();
    const VoxelFrame frame{settings.frame.origin, settings.frame.voxel * wide.every};
    if (repeat) {
      for (std::uint64_t i = boxes.first_after(fresh.cuts); i <= boxes.last; ++i) {
        const CutBoxes::Made& made = boxes.made[i % kCutHistory];
        if (!(made.fill_radius > 0)) carve(wide, Sweep(tools[made.tool].tool, made.X_WA, made.X_WB, frame));
      }
      return;
    }
    glm::ivec3 lo, hi;
    bool filled = false;
    if (patch.wide.empty() || !boxes.since(fresh.cuts, lo, hi, filled) || filled) return;
    const int n = wide.every, margin = static_cast<int>(Sweep::kMargin) + 1;
    merge(wide, patch.wide.front(), glm::max(lo, glm::ivec3(-1'000'000)) / n - margin, glm::min(hi, glm::ivec3(1'000'000)) / n + margin);
  }
};

Servo::Servo(const ServoSettings& settings, int patch_edge) : state_(std::make_unique<State>(settings, patch_edge)) {}
Servo::~Servo() = default;
Servo::Servo(Servo&&) noexcept = default;
Servo& Servo::operator=(Servo&&) noexcept = default;

void Servo::set_stiffness(const PerTissue& stiffness) noexcept {
  for (std::size_t i = 0; i < stiffness.size(); ++i) state_->settings.materials[i].stiffness = stiffness[i];
}

void Servo::ramp_out() noexcept { state_->ending = true; }

const SurfacePatch& Servo::patch() const noexcept { return state_->patch; }

void Servo::adopt(SurfacePatch& fresh) noexcept {
  State& s = *state_;
  if (fresh.n != s.patch.n) return;  // sized at set-up; never differs
  glm::ivec3 lo, hi;
  bool filled = false;
  const bool loose = fresh.pieces != s.patch.pieces;
  for (std::size_t i = 0; i < fresh.loose.size(); ++i) s.sums.removed[i] += fresh.loose[i] - s.patch.loose[i];
  if (s.patch.number != 0 && (loose || fresh.edits != s.patch.edits)) {
    // A stroke was taken back or brought again, or a piece taken out: the old patch knows nothing of that, so the cuts made
    // since are repeated, as the carver repeats them. What they had taken from such a piece before it was gone counts once.
    for (std::uint64_t i = s.boxes.first_after(fresh.cuts); i <= s.boxes.last; ++i) {
      const CutBoxes::Made& made = s.boxes.made[i % kCutHistory];
      const Tool& tool = s.tools[made.tool].tool;
      PerTissue removed;  // in tissue that came back, more than it was where that was gone
      if (made.fill_radius > 0) {
        bool changed;
        removed = fill(fresh, Fill(tool, made.X_WA.p, made.fill_radius, made.X_WB, s.settings.frame), &changed);
        for (double& v : removed) v = -v;
      } else {
        const bool continues = made.continues && i != fresh.edited_at + 1;
        removed = carve(fresh, Sweep(tool, made.X_WA, made.X_WB, s.settings.frame, continues));
      }
      const double voxel = s.settings.frame.voxel;
      for (std::size_t t = 0; t < removed.size(); ++t) {
        s.sums.removed[t] += (removed[t] - made.removed[t]) * voxel * voxel * voxel;
      }
    }
    for (std::size_t i = 0; i < s.sums.removed.size(); ++i) {
      s.sums.removed[i] -= fresh.taken_back[i] - s.patch.taken_back[i];
    }
    s.update_wide(fresh, true);
  } else if (s.patch.number != 0 && s.boxes.since(fresh.cuts, lo, hi, filled)) {
    merge(fresh, s.patch, lo, hi, filled);
    s.update_wide(fresh, false);
  }
  if (loose || fresh.edits != s.patch.edits || s.patch.number == 0) s.front.forget();
  std::swap(fresh, s.patch);
  s.smooth().forget();
  s.room_around = 0;
}

bool Servo::tick(const HandSample& hand, ServoTick& out, Cut& cut) noexcept {
  State& s = *state_;
  const ServoSettings& settings = s.settings;
  const double h = settings.frame.voxel;
  ServoTick& sums = s.sums;
  std::uint32_t faults = 0;

  // Time since the last tick, as measured; a jump of the clock counts as one ordinary tick.
  double dt = s.started ? to_seconds(hand.t - s.last_t) : settings.tick;
  if (!(dt > 0 && dt < 0.1)) dt = settings.tick;

  out = sums;
  ++sums.index;
  out.t = hand.t;
  out.patch = s.patch.number;
  out.tool = s.in_hand;

  // Illegal input, or no hand: zero force in this very tick, and the proxy starts anew afterwards. What the hand did
  // meanwhile is not in the ledger: it felt nothing. A leap paid with the last force would leave a debt, and a ledger in
  // debt gives no force ever again.
  const bool sound = is_sound(hand);
  if (!sound || (hand.faults & kNoPose)) {
    out.X_WT = sound ? Pose{hand.X_WT.p, glm::normalize(hand.X_WT.R)} : s.X_WG;  // where the device left it
    out.X_WG = s.placed ? s.X_WG : out.X_WT;
    out.faults = hand.faults & kNoPose ? hand.faults & kNoPose : bits(Fault::kBadInput);
    if (settings.spindle.run_up_time > 0) s.speed *= std::exp(-settings.tick / settings.spindle.run_up_time);
    else s.speed = 0;
    out.spindle = s.speed;
    out.energy = sums.energy;
    out.spindle_energy = sums.spindle_energy;
    s.started = s.idle = false;
    s.last_force = s.last_torque = s.last_spindle_force = s.last_teeth_force = s.last_sent = dvec3(0);
    s.normal_force = s.head_force = 0;
    s.friction = {};
    return false;
  }
  const Pose X_WT{hand.X_WT.p, glm::normalize(hand.X_WT.R)};
  out.X_WT = X_WT;
  out.pedal = std::clamp(hand.pedal, 0.0, 1.0);
  if (!s.started) {
    // After illegal input the tool is where it was: outside.
    if (!s.placed || glm::length(X_WT.p - s.X_WG.p) > kLostHand) s.X_WG = X_WT;
    s.placed = true;
    s.last_hand = X_WT;
    s.last_depth = s.rate = 0;
    s.depth_speed.reset();
    s.overlap = 0;
    s.given = s.stored = 0;
    s.friction = {};
    s.tip = {};
    s.ramp = 0;
  }
  if (hand.faults & bits(Fault::kLetGo)) s.last_force = s.last_torque = s.last_spindle_force = s.last_teeth_force = s.last_sent = dvec3(0);
  const dvec3 moved = X_WT.p - s.last_hand.p;

  // What the device did to the hand since the last tick: exactly last force × way (numbers.md, "Stability"), and last
  // torque × turn.
  const dvec3 turned = rotation_vector(s.last_hand.R, X_WT.R);
  const double given_to_hand = glm::dot(s.last_force, moved) + glm::dot(s.last_torque, turned);
  sums.energy -= given_to_hand;
  sums.spindle_energy += glm::dot(s.last_spindle_force, moved);
  s.teeth_energy += glm::dot(s.last_teeth_force, moved);

  // Spindle: the free speed follows the pedal.
  const double wanted_speed = out.pedal * settings.spindle.free_speed;
  s.speed = settings.spindle.run_up_time > 0 && s.speed != wanted_speed
                ? wanted_speed + (s.speed - wanted_speed) * std::exp(-dt / settings.spindle.run_up_time)
                : wanted_speed;

  // Another tool, where neither it nor the one in the hand touches or turns.
  if (hand.tool != s.in_hand && hand.tool < s.tools.size() && out.pedal <= kPedalUp &&
      s.speed <= kPedalUp * settings.spindle.free_speed && s.normal_force <= 0 && s.tip.sunk <= 0 && s.overlap == 0 &&
      s.would_be_free(hand.tool, {settings.frame.to_voxels(s.X_WG.p), X_WT.R})) {
    s.take_up(hand.tool);
    out.tool = s.in_hand;
  }

  // Cutting power of this tick, from the push of the last: tangential force μ_c F_n at the rim, limited by the motor.
  const Tool& tool = s.tool();
  const ContactFinder& finder = s.finder();
  const bool scrapes = tool.cuts && tool.scrapes > 0;
  const bool may_cut = settings.cutting && tool.cuts && (scrapes || s.speed > 0);
  SpindleLoad spindle{s.speed, 0};
  double tangential = 0;  // force of the teeth over normal force
  if (scrapes && may_cut && s.head_force > 0) {
    // An edge drawn over the surface cuts with the hand's own work: push × way along the surface.
    const double way = glm::length(moved - glm::dot(moved, s.normal) * s.normal);
    const double power = tool.scrapes * s.head_force * way / dt;
    s.budget = s.breaking_through ? 0.0 : std::min(s.budget + power * dt, power * kBudgetTime);
  } else if (may_cut && s.head_force > 0) {
    const double along = glm::dot(s.normal, X_WT.R * dvec3(0, 0, 1));
    const double efficiency = tool.side_efficiency + (tool.end_efficiency - tool.side_efficiency) * along * along;
    const double torque = tool.cutting_coefficient * efficiency * s.head_force * tool.radius();
    tangential = tool.cutting_coefficient * efficiency;
    spindle = load_spindle(settings.spindle, s.speed, out.pedal, torque);
    s.budget = s.breaking_through ? 0.0 : std::min(s.budget + spindle.power * dt, spindle.power * kBudgetTime);
  } else if (s.head_force <= 0) {
    s.budget = std::min(s.budget, 0.0);
  }

  // An edge that the hand draws earns little: what hard tissue gave way without being paid for, it waits for.
  const bool in_debt = scrapes && s.budget <= 0;
  if (s.fly(X_WT, moved, turned, dt, hand.t, out, cut)) return false;
  s.room_around = 0;

  // Move the proxy toward the hand: freely while nothing is near, along the contacts otherwise.
  const dvec3 c0 = settings.frame.to_voxels(s.X_WG.p), target = settings.frame.to_voxels(X_WT.p);
  dvec3 c = c0;
  double slack = 0;
  ContactSet& contacts = s.contacts;
  contacts.clear();
  ActivePlanes active;
  SmoothContacts* const smooth_parts = s.smooth().any() ? &s.smooth() : nullptr;
  bool touching = false, lost = false, deep = false;
  int settled_looks = 0;
  dvec3 found_at(0), last_step(0);
  double last_gain = 1, last_length = 0;
  const double overlap_before = s.overlap;
  if (s.overlap > 0) s.overlap *= std::exp(-dt / kRecoveryTime);
  const double pace_per_slew = dt / (settings.stiffness * std::max(s.stiffness_share, 0.05)) / h;  // voxels per N/s
  if (s.rejoining > 0) s.overlap = std::max(s.overlap, overlap_before - kFreeSlew * pace_per_slew);
  s.rejoining = std::max(s.overlap > 0 && s.rejoining > 0 ? dt : 0.0, s.rejoining - dt);
  if (s.overlap < 0.01) s.overlap = 0;
  const double specific_energy = may_cut ? s.mean(&Material::specific_energy) : 0;

  for (int look = 0; look < kMaxLooks; ++look) {
    const dvec3 way = target - c;
    const double distance = glm::length(way);
    if (!s.patch.holds(c, s.reach() + 1)) {
      lost = true;
      break;
    }
    const double head_clearance = s.clearance(c);
    const double clearance = smooth_parts ? std::min(head_clearance, smooth_parts->room(s.patch, {c, X_WT.R})) : head_clearance;
    if (clearance > 2) {  // sphere tracing: as far as nothing can be met
      touching = false;
      if (distance <= clearance - 1) {
        c = target;
        break;
      }
      const dvec3 next = c + way * ((clearance - 1) / distance);
      if (!s.patch.holds(next, s.reach() + 1)) {
        lost = true;
        break;
      }
      c = next;
      last_length = 0;
      continue;
    }

    // The surface points found once serve as long as the head has hardly moved; a single exact one is always new, and so are
    // those around a rim, which are told from the rough ones by queries.
    if (contacts.count() > 1 && (may_cut || tool.shape == HeadShape::kSphere) && !contacts.sunk() && glm::length(c - found_at) < kSamePoints) {
      contacts.drop_added();
      finder.relinearize({c, X_WT.R}, contacts);
      if (smooth_parts) smooth_parts->relinearize({c, X_WT.R}, contacts);
    } else {
      finder.find(s.patch, {c, X_WT.R}, kContactRange, contacts);
      if (contacts.deepest() > ContactFinder::kSunk || head_clearance + s.reach() < 0) {
        finder.find_way_out(s.patch, {c, X_WT.R}, contacts);
      } else if (look == 0 && may_cut && s.carved && contacts.count() > 1 && !in_debt) {
        contacts.forgive(kBlur);
      }
      found_at = c;
      // One-sided wall (Wang 2009): tissue harder than what is being cut gives way by that much less; softer tissue never
      // holds anything back.
      if (may_cut && settings.boundary_walls && specific_energy > 0 && specific_energy < s.hardest) {
        for (int i = 0; i < contacts.count(); ++i) {
          const double hardness = settings.materials[static_cast<std::size_t>(tissue_at(s.patch, contacts.below(i)))].specific_energy;
          if (hardness > specific_energy) contacts.set_yields(i, specific_energy / hardness);
        }
      }
      if (smooth_parts) smooth_parts->find(s.patch, {c, X_WT.R}, kContactRange, contacts);
      active = guess_active(contacts, s.held);
    }
    if (contacts.count() == 0 && sample_linear(s.patch, c) < -kStep) {  // wholly inside: no surface in reach
      deep = true;
      c = target;
      touching = false;
      break;
    }
    if (look == 0 || !touching) {
      // How much the head may sink in this tick: the budget buys area × depth + the cap of a first touch.
      if (may_cut && s.budget > 0 && specific_energy > 0) {
        const double volume = s.budget / specific_energy / (h * h * h);
        const double area = glm::length(contacts.engaged_normal());
        const double cap = kPi * tool.radius() / h;
        slack = std::min(2 * volume / (area + std::sqrt(area * area + 4 * cap * volume)), kMostSlack);
      }
    }
    if (look == 0) {
      if (contacts.deepest() > overlap_before + slack + kDeep) s.overlap = contacts.deepest();
    }
    const dvec3 pulled_to = s.normal_force > 0 && may_cut && !scrapes
                                ? held_target(c0, target, s.normal, moved / h, kGripSlew * pace_per_slew)
                                : target;
    dvec3 next = nearest_allowed(contacts, c, s.overlap, slack, pulled_to, active);
    // Rough planes chose which hold; exact ones say how far, and others may hold then.
    for (int round = 0; round < (may_cut ? 1 : kRefiningRounds) && contacts.count() > 1 && active.count > 0; ++round) {
      bool refined = false;
      for (int i = 0; i < active.count; ++i) {
        refined |= finder.refine(s.patch, {c, X_WT.R}, contacts, active.index[i], !may_cut);
      }
      if (!refined) break;
      next = nearest_allowed(contacts, c, s.overlap, slack, pulled_to, active);
    }
    touching = contacts.count() > 0;
    dvec3 step = next - c;
    // Along a smooth curved surface each step is the same share of the one before, of less than nothing in a hollow: all that
    // are still to come at once (the secant method).
    if ((contacts.count() == 1 || !may_cut) && active.count == 1) {
      const double before2 = glm::dot(last_step, last_step);
      const double share = before2 > 0 ? glm::dot(step, last_step) / before2 : 0;
      last_step = step;
      last_gain = share != 0 && std::abs(share) < kStillConverges ? std::min(last_gain / (1 - share), contacts.count() > 1 ? 2.0 : kMostGain) : 1;
      // Toward the tissue each look goes the whole way as it is.
      const dvec3 n = contacts.plane(active.index[0]).n;
      step += (last_gain - 1) * (step - glm::dot(step, n) * n);
      next = c + step;
    }
    const double length = glm::length(step);
    const double longest = contacts.count() > 1 ? kContactStep : kStep;
    if (length > longest) {
      c += step * (longest / length);
      last_length = 0;
      continue;
    }
    c = next;
    const double settled = contacts.count() > 1 ? may_cut ? kSettledCutting : kSettled : kConverged;
    // What is still to come, where each step is at most the share of the one before that this one was.
    const bool foreseen = contacts.count() == 1 && length < last_length && length * length < kForeseen * (last_length - length);
    last_length = length;
    if (length < settled || foreseen || ++settled_looks >= (may_cut ? kSettlingLooksCutting : kSettlingLooks)) break;
    // On a smooth surface each look squares the error; when nothing pushes, the target was reached.
    if (active.count == 0) {
      touching = false;
      break;
    }
  }
  // A bur that comes free, over the rim of its own cut or through the last of the tissue, follows the hand at a pace: what
  // the hand feels changes by so much at most, where the proxy can see to that. The proxy only lags behind, so this takes
  // energy, never gives.
  const bool at_a_pace = (may_cut || s.rejoining > 0) && !deep && s.normal_force > 0;
  s.breaking_through = at_a_pace && !touching;
  if (at_a_pace) {
    const dvec3 step = c - c0, carried = (s.X_WG.p - s.last_hand.p) / h, shift = moved / h;
    const double pace = (s.breaking_through ? kFreeSlew : kCutSlew) * pace_per_slew;
    if (glm::length(c - target - carried) > pace) c = c0 + largest_share(step, -shift, pace) * step;
    lost = lost && !s.patch.holds(c, s.reach() + 1);
  }
  // Beyond the patch the last contact's plane goes on (the intermediate surface of Adachi 1995; Mark 1996) until the carver
  // delivers: without cutting, and not for ever.
  s.bridged = lost ? s.bridged + dt : 0;
  const bool bridging = lost && s.normal_force > 0 && s.bridged < kBridgeTime;
  if (bridging) {
    const double under = glm::dot(c0 - target, s.normal);
    c = under > 0 ? target + under * s.normal : target;
    touching = s.breaking_through = false;
    s.rejoining = kRejoinTime;
    contacts.clear();
    active.count = 0;
  }
  if (s.overlap > 0) faults |= bits(Fault::kDeepPenetration);
  if (deep) faults |= bits(Fault::kDeepPenetration);
  if (lost) faults |= bits(Fault::kPatchEdge);
  // A patch that has long been due: the carver is late. What the patch holds is still true, so the force stays.
  const bool due = s.patch.number == 0 ||
                   patch_due_for(patch_center_for(s.X_WG.p, X_WT.p, s.travel), s.patch.center_W, s.travel);
  s.due_for = due ? s.due_for + dt : 0;
  if (s.due_for > kStaleTime) faults |= bits(Fault::kStalePatch);
  s.held = touching ? held_by(contacts, active) : HeldBy{};
  const dvec3 p_WG = c == target ? X_WT.p : settings.frame.to_world(c);

  // Cut: everything the head sweeps on its way.
  bool cut_made = false;
  s.carved = may_cut && touching && contacts.own() > 0 && !deep && !in_debt;
  if (s.carved) {
    const Pose X_WB{p_WG, X_WT.R};
    const bool edited = s.patch.edits > 0 && sums.cuts == s.patch.edited_at;  // see Carver::apply
    const bool continues = sums.cuts > 0 && !edited && s.cut_tool == s.in_hand && same(s.X_WG, s.cut_end);
    const Sweep sweep(tool, s.X_WG, X_WB, settings.frame, continues);
    bool changed;
    const PerTissue removed = carve(s.patch, sweep, &changed, &s.front);
    double energy = 0;
    for (std::size_t i = 1; i < removed.size(); ++i) {
      const double v = removed[i] * h * h * h;
      sums.removed[i] += v;
      energy += v * settings.materials[i].specific_energy;
    }
    if (changed) {
      cut_made = true;
      ++sums.cuts;
      s.cut_end = X_WB;
      s.cut_tool = s.in_hand;
      s.boxes.add(sums.cuts, sweep.lo(), sweep.hi(), {s.X_WG, X_WB, s.in_hand, continues, 0, removed});
      cut = {sums.cuts, out.index, hand.t, s.X_WG, {p_WG, X_WT.R}, s.in_hand, {}, {}, spindle.speed};
      for (std::size_t i = 0; i < removed.size(); ++i) cut.removed[i] = removed[i] * h * h * h;
      s.carve_wide(s.X_WG, X_WB, continues);
      out.cutting_power = energy / dt;
      s.budget -= energy;
    }
  }

  // Fill: a dome grows on the tissue nearest to the instrument's free end, up to the head.
  if (tool.fill != Tissue::kAir && !lost && !deep) {
    cut_made = s.fill(out, {p_WG, X_WT.R}, dt, cut);
  }

  s.spindle_work += out.cutting_power * dt;

  // Contact seen from the hand.
  dvec3 force(0), torque(0), normal(0), spindle_force(0);
  dvec3 p_held = p_WG;
  const dvec3 depth_vector = p_WG - X_WT.p;
  const double depth = glm::length(depth_vector);
  VelocityEstimate sinking;
  if (settings.position_step > 0) sinking = s.depth_speed.add(hand.t, {depth, 0, 0});
  double stored = 0;
  if ((((touching || s.breaking_through) && !lost) || bridging) && depth > 0) {
    normal = depth_vector / depth;
    // Tissue under the head: at each contact a voxel deep, weighted by how much it pushes.
    PerTissue shares{};
    double total = 0;
    dvec3 lever(0), on_head(0), on_smooth(0);  // where the push attacks, from the head's centre; voxels
    for (int i = 0; i < active.count; ++i) {
      const ContactPlane plane = contacts.plane(active.index[i]);
      const double weight = active.push[i];
      lever += weight * (plane.x - c);
      torque += weight * glm::cross(plane.x - c, plane.n);
      total += weight;
      (active.index[i] < contacts.own() ? on_head : on_smooth) += weight * plane.n;
      dvec3 below = plane.x - plane.n;
      const SurfacePatch* felt_in = &s.patch;
      if (!s.patch.holds(below, 0)) {
        if (s.patch.wide.empty()) continue;
        felt_in = &s.patch.wide.front();
        below = plane.x / static_cast<double>(felt_in->every) - plane.n;
        if (!felt_in->holds(below, 0)) continue;
      }
      const PerTissue here = sample_tissue(*felt_in, below);
      for (std::size_t t = 1; t < here.size(); ++t) shares[t] += weight * here[t];
    }
    double labelled = 0;
    for (const double share : shares) labelled += share;
    if (labelled > 0) {
      for (double& share : shares) share /= labelled;
      s.shares = shares;
    }
    if (total > 0) lever /= total;
    const double wanted = s.mean(&Material::stiffness) / 1000.0;  // relative to enamel's 1 N/mm
    const bool fresh = s.normal_force <= 0;
    double stiffness_share = wanted;
    if (!fresh) {
      // Under a deep push a change of stiffness is a large change of force, and a rise is energy that no hand put in.
      const double most = kTissueSlew * dt / (settings.stiffness * depth);
      const double step = (wanted - s.stiffness_share) * (1 - std::exp(-dt / kStiffnessTime));
      const double paid = 2 * std::max(sums.energy + s.given, kUnpaid) / (settings.stiffness * depth * depth);
      stiffness_share = s.stiffness_share + std::clamp(step, -most, most);
      if (step > 0) stiffness_share = std::min(stiffness_share, std::max(s.stiffness_share, paid));
    }
    s.stiffness_share = stiffness_share;
    const double k = settings.stiffness * s.stiffness_share;
    stored = k * depth * depth / 2;

    // Along the normal only, from the depth itself: sliding at constant depth is not damped.
    double magnitude = k * depth;
    if (settings.damping > 0 && s.started) {
      const double smooth = may_cut ? std::exp(-dt / kCutDampingTime) : 0.0;
      const double measured = settings.position_step > 0 ? sinking.v.x : (depth - s.last_depth) / dt;
      const double rate = s.overlap > 0 ? 0 : measured;
      double change = (rate - s.rate) * (1 - smooth);
      if (may_cut && !fresh) {  // the proxy sinks by fits and starts, voxel by voxel
        const double most = kDamperSlew * dt / settings.damping;
        change = std::clamp(change, -most, most);
      }
      s.rate += change;
      magnitude = std::max(0.0, magnitude + settings.damping * s.rate);
    }
    force = magnitude * normal;
    // Each contact pushes along its own normal; together they are the force, and they turn the tool about its centre.
    if (tool.shape == HeadShape::kSphere && !smooth_parts) {
      torque = dvec3(0);
    } else {
      torque *= h * h * magnitude / depth;
    }
    s.normal_force = k * depth;
    s.head_force = s.normal_force;
    if (contacts.own() < contacts.count() && glm::dot(on_smooth, on_smooth) > 0) {
      const double head = glm::length(on_head);
      s.head_force *= head / (head + glm::length(on_smooth));
    }
    dvec3 sideways(0);
    if (settings.friction && (!may_cut || scrapes)) {  // a turning bur slips always; its tangential force is that of the teeth
      const FrictionLaw law{s.mean(&Material::static_friction), s.mean(&Material::dynamic_friction), settings.stiffness};
      sideways = friction_force(law, p_WG, s.X_WG.p, normal, s.normal_force, s.friction);
      force += sideways;
    }
    if (tangential > 0) {  // the tissue pushes the teeth back, against their way; none at the pole, where they stand still
      const dvec3 axis = X_WT.R * dvec3(0, 0, 1);
      spindle_force = tangential * s.head_force * glm::cross(axis, normal);
      const dvec3 change = spindle_force - s.teeth_force;
      const double size = glm::length(change), most = kTeethSlew * dt;
      const dvec3 step = change * (size > most ? most / size : 1.0);
      const dvec3 rest = force + s.teeth_force - s.last_force - s.last_teeth_force;
      spindle_force = s.teeth_force + largest_share(step, rest, kCutSlewInAll * dt) * step;
      // Never more to the hand than the spindle itself has done.
      const double left = std::max(0.0, s.spindle_work - s.teeth_energy);
      const double needed = std::max(0.0, glm::dot(spindle_force, moved));
      if (needed > 0) spindle_force *= std::min(1.0, left / (kTeethAhead * needed));
    }
    s.teeth_force = spindle_force;
    if (tool.shape != HeadShape::kSphere || smooth_parts) {
      torque += h * glm::cross(lever, sideways + spindle_force);
      // Which of many contacts carry how much may change from tick to tick; what the wrist feels follows smoothly.
      if (contacts.count() > 1 && !fresh) torque += (s.torque - torque) * std::exp(-dt / kStiffnessTime);
      s.torque = torque;
    }
    const auto most = std::max_element(s.shares.begin() + 1, s.shares.end());
    out.tissue = *most > 0 ? static_cast<Tissue>(most - s.shares.begin()) : Tissue::kAir;
    out.depth = depth;
    out.n_C_W = normal;
  } else {
    s.normal_force = s.head_force = 0;
    s.rate = 0;
    s.friction = {};
    s.teeth_force = dvec3(0);
    if (lost) force = s.last_force * std::exp(-dt / kFadeTime);  // no field to feel: the last force fades
  }

  // A sharp tip in softened tissue: sinks under a push, holds on withdrawal.
  if (tool.sink_yield > 0 && !tool.cuts && !lost) {
    const TipLaw law{tool.sink_yield};
    const double k = settings.stiffness * s.stiffness_share;
    if (s.tip.sunk <= 0 && s.shares[static_cast<std::size_t>(Tissue::kCaries)] > 0.5 && s.normal_force > law.yield) {
      s.tip = {1e-9, p_WG, normal};
    }
    if (s.tip.sunk > 0) {
      const dvec3 ahead = settings.frame.to_voxels(s.tip.p) - (finder.reach() + 1) * s.tip.n;
      const bool soft = s.patch.holds(ahead, 0) && tissue_at(s.patch, ahead) == Tissue::kCaries;
      force = tip_force(law, X_WT.p, k, soft, s.tip);
      if (s.tip.sunk > 0) {
        p_held = s.tip.p;
        out.depth = glm::length(p_held - X_WT.p);
        out.tissue = Tissue::kCaries;
        out.n_C_W = s.tip.n;
        stored = k * out.depth * out.depth / 2;
        torque = dvec3(0);
      }
    }
  }

  // Area of the head on tissue: from the samples, or, where one query sufficed, of the cap under the tangent plane.
  if (touching && contacts.own() > 0) {
    out.contact_area = contacts.engaged_area() > 0 ? contacts.engaged_area() * h * h : kPi * tool.radius() * h;
  }

  // What the spindle sends through the arm, from the same contact as the sound's. Its energy is the motor's: the ledger
  // has it with the spindle's. A period has five ticks or more.
  dvec3 teeth_force = spindle_force;
  if (settings.vibration.band > 0 && spindle.speed > 0) {
    s.phase = advance_phase(s.phase, spindle.speed, dt);
    const double band = std::min(settings.vibration.band, 0.2 / settings.tick);
    spindle_force += vibration_force(settings.vibration, band, s.phase, spindle.speed, X_WT.R * dvec3(0, 0, 1), normal,
                                     tangential * s.head_force);
  }

  // The literature's filters, for comparison.
  if (settings.filter != ForceFilter::kNone) force = filter_force(settings.filter, {}, force, s.last_force);

  // Limits: of the device, of its slew, and the ramps at start and end.
  if (!touching && !s.ending) s.ramp = 1;  // begun in the open: nothing to ramp
  s.ramp = std::clamp(s.ramp + (s.ending ? -1 : 1) * dt / std::max(settings.ramp_time, dt), 0.0, 1.0);
  const double magnitude = glm::length(force + spindle_force);
  double share = s.ramp;
  if (magnitude * share > settings.force_limit) {
    share = settings.force_limit / magnitude;
    faults |= bits(Fault::kForceLimit);
  }
  const double twist = glm::length(torque);
  if (twist * share > settings.torque_limit) {
    torque *= settings.torque_limit / (twist * share);
    faults |= bits(Fault::kForceLimit);
  }
  if (settings.slew_limit > 0) {
    const double risen = magnitude * share - glm::length(s.last_sent), most = settings.slew_limit * dt;
    if (risen > most) {
      share *= (magnitude * share - risen + most) / (magnitude * share);
      faults |= bits(Fault::kSlewLimit);
    }
  }
  force *= share;
  spindle_force *= share;
  teeth_force *= share;
  torque *= share;

  // Leading the tool out of tissue, or a leap of the input against it, raises what the coupling stores without a hand's
  // doing: that much is allowed for, as long as the contact lasts.
  if (glm::length(moved) > kNoHand * dt) s.leap = kLeapTime;
  s.leap = std::max(0.0, s.leap - dt);
  if (s.overlap > 0 || s.leap > 0) s.given += std::max(0.0, stored - s.stored - std::max(0.0, -given_to_hand));
  // What the hand was given stays forgiven: a ledger in debt would never again allow a force. So is a debt of a contact
  // that is over, whatever brought it: ticks that came late hold a force for longer than was foreseen.
  const double forgiven = sums.energy < -kDebt ? -sums.energy : s.given;
  if (!touching && s.tip.sunk <= 0) s.given = std::clamp(-sums.energy, 0.0, forgiven);
  s.stored = stored;
  // An arm that gives no torque resists no turn, and none may be counted as if the hand had paid for it.
  dvec3 felt_torque = settings.gives_torque ? torque : dvec3(0);
  if (settings.passivity) {
    const double passive = passive_share({}, force, moved, felt_torque, turned, dt, settings.tick, sums.energy + s.given, s.passivity);
    force *= passive;
    torque *= passive, felt_torque *= passive;
  }

  s.normal = normal;
  s.last_depth = out.depth;
  s.X_WG = {p_held, X_WT.R};
  s.last_force = force;
  s.last_torque = felt_torque;
  s.last_spindle_force = spindle_force;
  s.last_teeth_force = teeth_force;
  s.last_sent = force + spindle_force;
  s.last_hand = X_WT;
  s.last_t = hand.t;
  s.started = true;
  s.idle = s.normal_force <= 0 && s.overlap == 0 && s.rejoining == 0 && s.tip.sunk <= 0 && s.stored == 0 &&
           s.rate == 0 && force == dvec3(0) && spindle_force == dvec3(0) && teeth_force == dvec3(0);
  cut.n_C_W = normal;

  out.X_WG = s.X_WG;
  out.f_T_W = force + spindle_force;
  out.tau_T_W = torque;
  out.removed = sums.removed;
  out.cuts = sums.cuts;
  out.spindle = spindle.speed;
  out.energy = sums.energy;
  out.spindle_energy = sums.spindle_energy;
  out.faults = faults;
  return cut_made;
}

}  // namespace typodont::haptics
