#include "haptics/servo.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <type_traits>
#include <utility>

#include "engine/base/check.h"
#include "haptics/servo/state.h"

namespace typodont::haptics {

namespace {

constexpr double kOfSize = 1000;        // N/m, of the coupling in a scene as large as a tooth …
constexpr double kLeastCredit = 1e-10;  // J, … what the ledger may be overdrawn by there, …
constexpr double kLeastTurning = 1.2;   // m/s², … and what a hand may do that has not shown how abruptly it moves
constexpr double kLostHand = 0.02;      // m: so far from where it was, a hand that comes back starts anew
constexpr double kFarHand = 100;        // m: no hand is as far away

bool is_unit(const dquat& R) {
  return std::abs(glm::dot(R, R) - 1) < 1e-3;
}
/// Made of unit length, unless it is that already but for rounding: what a tick gave out (ServoTick::X_WT) comes back
/// as the same bits, so that a replay feels what the hand felt.
dquat made_unit(const dquat& R) {
  constexpr double kRounding = 1e-14;  // of |R|², more than a normalisation leaves
  return std::abs(glm::dot(R, R) - 1) < kRounding ? R : glm::normalize(R);
}
bool is_near(const dvec3& p) {
  return glm::dot(p, p) < kFarHand * kFarHand;
}  // a number, too

/// Piece by piece: the compiler would make a string instruction of the whole, which is slow to start.
void copy_tick(const ServoTick& from, ServoTick& to) noexcept {
  static_assert(std::is_trivially_copyable_v<ServoTick> && sizeof(ServoTick) % 8 == 0);
  constexpr std::size_t kPiece = 16, kPieces = sizeof(ServoTick) / kPiece, kRest = sizeof(ServoTick) % kPiece;
  const auto* const source = reinterpret_cast<const std::byte*>(&from);
  auto* const target = reinterpret_cast<std::byte*>(&to);
  const auto copy = [&]<std::size_t... I>(std::index_sequence<I...>) {
    (std::memcpy(target + kPiece * I, source + kPiece * I, kPiece), ...);
  };
  copy(std::make_index_sequence<kPieces>());
  if constexpr (kRest > 0) std::memcpy(target + kPiece * kPieces, source + kPiece * kPieces, kRest);
}

double travel_for(const Tool& tool, double voxel) {
  return std::max({8.0, 1e-3 / voxel, 0.25 * tool.reach() / voxel});
}

/// Unit vectors, a Fibonacci sphere.
std::vector<glm::vec3> evenly_around(std::size_t count) {
  std::vector<glm::vec3> all;
  for (std::size_t i = 0; i < count; ++i) {
    const double turn = kPi * (3 - std::sqrt(5.0)) * static_cast<double>(i),
                 z = 1 - (2.0 * static_cast<double>(i) + 1) / static_cast<double>(count);
    const double rho = std::sqrt(1 - z * z);
    all.emplace_back(rho * std::cos(turn), rho * std::sin(turn), z);
  }
  return all;
}

/// A scene that is larger, with a coupling softer by as much, has the same forces: what the law foresees of a hand and
/// gives it is larger alike, but for the limit of a nanojoule. A device's hand is a hand, whatever the scene, and its
/// jumps are counts.
PassivityLaw law_for(const ServoSettings& settings) {
  PassivityLaw law;
  if (settings.position_step > 0) {
    law.in_counts = true;
    return law;
  }
  const double size = kOfSize / settings.stiffness;
  law.credit = std::min(law.credit, size * kLeastCredit);
  law.turning = size * kLeastTurning;
  law.long_way *= std::max(size, 1.0);
  return law;
}

}  // namespace

int patch_edge_for(std::span<const Tool> tools, double voxel) {
  double half = 0;
  for (const Tool& tool : tools) {
    // A portion of filling lies beyond the head's end, and is put down only where the patch holds all of it.
    const double reach = std::max(near_reach(tool), tool.fill == Tissue::kAir ? 0.0 : tool.half() + tool.fill_reach);
    half = std::max(half, reach / voxel + Sweep::kMargin + 3 + travel_for(tool, voxel));
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

Servo::State::State(const ServoSettings& s, int edge)
    : settings(s),
      travel(patch_travel_for(tray(s), s.frame.voxel) * s.frame.voxel),
      depth_speed(s.position_step, 1),
      front(tray(s), s.frame.voxel) {
  for (const Tool& tool : tray(s)) {
    const double h = s.frame.voxel;
    tools.push_back({tool, ContactFinder(tool, h), SmoothContacts(tool, h), near_reach(tool) / h});
  }
  for (const Material& material : settings.materials) hardest = std::max(hardest, material.specific_energy);
  if (std::ranges::any_of(tray(s), [](const Tool& each) { return each.fill != Tissue::kAir; }))
    flow_ways = evenly_around(kFlowWays);
  passivity_law = law_for(settings);
  patch.resize(edge);
}

void Servo::State::rest(Now& now, bool sound) noexcept {
  const HandSample& hand = now.hand;
  ServoTick& out = now.out;
  out.X_WT = sound ? Pose{hand.X_WT.p, made_unit(hand.X_WT.R)} : X_WG;  // where the device left it
  out.X_WG = placed ? X_WG : out.X_WT;
  out.faults = hand.faults & kNoPose ? hand.faults & kNoPose : bits(Fault::kBadInput);
  if (settings.spindle.run_up_time > 0)
    speed *= std::exp(-settings.tick / settings.spindle.run_up_time);
  else
    speed = 0;
  out.spindle = speed;
  out.energy = sums.energy;
  out.spindle_energy = sums.spindle_energy;
  started = idle = false;
  last_force = last_torque = last_spindle_force = last_teeth_force = last_sent = dvec3(0);
  normal_force = head_force = pressing = 0;
  friction = {};
}

void Servo::State::begin_anew(const Pose& X_WT, Nanos t) noexcept {
  began = t;
  // After illegal input the tool is where it was: outside.
  if (!placed || glm::length(X_WT.p - X_WG.p) > kLostHand) X_WG = X_WT;
  placed = true;
  carved = false;
  last_hand = X_WT;
  last_depth = rate = 0;
  depth_speed.reset();
  overlap = 0;
  given = stored = 0;
  friction = {};
  tip = {};
  ramp = 0;
}

inline void Servo::State::account(Now& now, bool turns) noexcept {
  if (now.hand.faults & bits(Fault::kLetGo)) {
    last_force = last_torque = last_spindle_force = last_teeth_force = last_sent = dvec3(0);
  }
  now.moved = now.X_WT.p - last_hand.p;
  now.turned = turns ? rotation_vector(last_hand.R, now.X_WT.R) : dvec3(0);
  const bool leaps = glm::dot(now.moved, now.moved) > kNoHand * kNoHand * now.dt * now.dt;
  leap = std::max(0.0, (leaps ? kLeapTime : leap) - now.dt);
  if (idle) return;  // nothing was felt
  // Exactly last force × way (numbers.md, "Stability"), and last torque × turn.
  now.given_to_hand = glm::dot(last_force, now.moved) + glm::dot(last_torque, now.turned);
  sums.energy -= now.given_to_hand;
  sums.spindle_energy += glm::dot(last_spindle_force, now.moved);
  teeth_energy += glm::dot(last_teeth_force, now.moved);
}

void Servo::State::run_spindle(const Now& now) noexcept {
  const double wanted = now.out.pedal * settings.spindle.free_speed;
  speed = settings.spindle.run_up_time > 0 && speed != wanted
              ? wanted + (speed - wanted) * std::exp(-now.dt / settings.spindle.run_up_time)
              : wanted;
}

void Servo::State::change_tool(Now& now) noexcept {
  const std::uint32_t wanted = now.hand.tool;
  if (wanted < tools.size() && now.out.pedal <= kPedalUp && speed <= kPedalUp * settings.spindle.free_speed &&
      normal_force <= 0 && tip.sunk <= 0 && overlap == 0 &&
      would_be_free(wanted, {settings.frame.to_voxels(X_WG.p), now.X_WT.R})) {
    take_up(wanted);
    now.out.tool = in_hand;
  }
}

void Servo::State::take_up(std::uint32_t which) noexcept {
  in_hand = which;
  smooth().forget();
  front.forget();
  shares = {};
  stiffness_share = 1;
  budget = wall_budget = wall = 0;
  torque = dvec3(0);
  friction = {};
  tip = {};
  held = {};
}

void Servo::State::remember(Touch& now, const dvec3& felt_torque) noexcept {
  ServoTick& out = now.out;
  normal = now.normal;
  last_depth = out.depth;
  X_WG = {now.p_held, now.X_WT.R};
  last_force = now.force;
  last_torque = felt_torque;
  last_spindle_force = now.spindle_force;
  last_teeth_force = now.teeth_force;
  last_sent = now.force + now.spindle_force;
  last_hand = now.X_WT;
  last_t = now.hand.t;
  started = true;
  idle = normal_force <= 0 && overlap == 0 && rejoining == 0 && tip.sunk <= 0 && stored == 0 && rate == 0 &&
         now.force == dvec3(0) && now.spindle_force == dvec3(0) && now.teeth_force == dvec3(0) &&
         felt_torque == dvec3(0);
  now.cut.n_C_W = now.normal;

  out.X_WG = X_WG;
  out.f_T_W = now.force + now.spindle_force;
  out.tau_T_W = now.torque;
  out.removed = sums.removed;
  out.cuts = sums.cuts;
  out.spindle = now.spindle.speed;
  out.energy = sums.energy;
  out.spindle_energy = sums.spindle_energy;
  out.faults = now.faults;
}

Servo::Servo(const ServoSettings& settings, int patch_edge) : state_(std::make_unique<State>(settings, patch_edge)) {}
Servo::~Servo() = default;
Servo::Servo(Servo&&) noexcept = default;
Servo& Servo::operator=(Servo&&) noexcept = default;

void Servo::set_stiffness(const PerTissue& stiffness) noexcept {
  for (std::size_t i = 0; i < stiffness.size(); ++i) state_->settings.materials[i].stiffness = stiffness[i];
}

void Servo::ramp_out() noexcept {
  state_->ending = true;
}

const SurfacePatch& Servo::patch() const noexcept {
  return state_->patch;
}

void Servo::adopt(SurfacePatch& fresh) noexcept {
  State& s = *state_;
  // Another core has just written it: its lines are fetched side by side.
  constexpr std::size_t kLine = 64;
  for (std::size_t at = 0; at < sizeof fresh; at += kLine)
    __builtin_prefetch(reinterpret_cast<const char*>(&fresh) + at, 1);
  if (fresh.n != s.patch.n) return;  // sized at set-up; never differs
  s.catch_up(fresh);
  std::swap(fresh, s.patch);
  s.smooth().forget();
  s.room_around = 0;
}

bool Servo::tick(const HandSample& hand, ServoTick& out, Cut& cut) noexcept {
  State& s = *state_;
  const ServoSettings& settings = s.settings;
  Now now{hand, out, cut};

  // Time since the last tick, as measured; a jump of the clock counts as one ordinary tick.
  now.dt = s.started ? to_seconds(hand.t - s.last_t) : settings.tick;
  if (!(now.dt > 0 && now.dt < 0.1)) now.dt = settings.tick;

  copy_tick(s.sums, out);
  ++s.sums.index;
  out.t = hand.t;
  out.patch = s.patch.number;
  out.tool = s.in_hand;

  // Illegal input, or no hand: zero force in this very tick, and the proxy starts anew afterwards. What the hand did
  // meanwhile is not in the ledger: it felt nothing. A leap paid with the last force would leave a debt, and a ledger
  // in debt gives no force ever again.
  const bool comes_turned = hand.X_WT.R != s.came_R;  // most hands only move
  const bool sound = is_near(hand.X_WT.p) && (!comes_turned || is_unit(hand.X_WT.R)) && std::isfinite(hand.pedal);
  if (!sound || (hand.faults & kNoPose)) {
    s.rest(now, sound);
    return false;
  }
  bool turns = false;
  if (comes_turned) {
    s.came_R = hand.X_WT.R;
    const dquat R_WT = made_unit(hand.X_WT.R);
    turns = R_WT != s.R_WT;
    s.R_WT = R_WT;
  }
  now.X_WT = out.X_WT = {hand.X_WT.p, s.R_WT};
  out.pedal = std::clamp(hand.pedal, 0.0, 1.0);
  if (!s.started) s.begin_anew(now.X_WT, hand.t);

  s.account(now, turns);
  s.run_spindle(now);
  if (hand.tool != s.in_hand) s.change_tool(now);
  if (s.fly(now)) return false;

  s.earn(now);
  Touch touch(now);
  s.move_proxy(touch);
  s.follow(touch);
  bool cut_made = s.take_away(touch);
  if (s.tool().fill != Tissue::kAir) cut_made = s.fill(touch);

  s.feel(touch);
  s.sink_tip(touch);
  s.vibrate(touch);
  if (settings.filter != ForceFilter::kNone) touch.force = filter_force(settings.filter, {}, touch.force, s.last_force);
  s.limit(touch);
  const dvec3 felt_torque = s.keep_passive(touch);
  s.remember(touch, felt_torque);
  return cut_made;
}

}  // namespace typodont::haptics
