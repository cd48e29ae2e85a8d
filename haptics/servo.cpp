#include "haptics/servo.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <type_traits>
#include <utility>

#include "haptics/contact/count_method.h"
#include "haptics/contact_method.h"
#include "haptics/servo/state.h"

namespace typodont::haptics {

namespace {

using P = MotionParameters;

bool is_unit(const dquat& R) {
  return std::abs(glm::dot(R, R) - 1) < 1e-3;
}
/// Normalises an orientation, but does not change a unit quaternion: recorded orientations (ServoTick::X_WT) must stay
/// bit-identical in a replay.
dquat made_unit(const dquat& R) {
  constexpr double kRounding = 1e-14;  // rounding error of |R|² after a normalisation
  return std::abs(glm::dot(R, R) - 1) < kRounding ? R : glm::normalize(R);
}

/// Copies in pieces of 16 bytes, because the string instruction that a large memcpy uses starts slowly.
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

}  // namespace

PassivityLaw law_for(const ServoSettings& settings) {
  PassivityLaw law;
  if (settings.position_step > 0) {
    law.in_counts = true;
    return law;
  }
  const double size = ScaleParameters::tooth_stiffness / settings.stiffness;
  law.credit = std::min(law.credit, size * ScaleParameters::credit);
  law.turning = size * ScaleParameters::turning;
  law.jump_distance *= std::max(size, 1.0);
  return law;
}

dvec3 snapshot_center_for(const dvec3& p_WG, const dvec3& p_WT, double travel, const dvec3& lead) noexcept {
  // Largest distance between the snapshot's centre and the proxy, as a fraction of `travel` (distance that the tool may
  // move). Below 1, because the centre of a tissue patch is rounded to eight voxels.
  constexpr double kFarthest = 0.8;
  const auto limited = [](const dvec3& v, double most) {
    const double length = glm::length(v);
    return length > most ? v * (most / length) : v;
  };
  const dvec3 pull = limited(p_WT - p_WG, travel / 2);
  return p_WG + (lead == dvec3(0) ? pull : limited(pull + lead, kFarthest * travel));
}

double max_fraction(const dvec3& step, const dvec3& rest, double most) {
  const double a = glm::dot(step, step), b = -glm::dot(step, rest),
               d = b * b - a * (glm::dot(rest, rest) - most * most);
  return a > 0 ? std::clamp((b + std::sqrt(std::max(d, 0.0))) / a, 0.0, 1.0) : 1.0;
}

Servo::State::State(const ServoSettings& s) : settings(s), tools(tool_set(settings)), coupling(s.position_step) {
  if (!settings.method) settings.method = default_contact_method();
  model = settings.method->make_model(settings);
  count_method(settings.method->name(), 1, 0);
  snapshot = &model->snapshot();
  travel = model->travel();
  turns_matter = model->turns_matter();
  limits.law = law_for(settings);
  if (settings.soft) soft = std::make_unique<SoftTissue>(settings.soft, tools, settings.stiffness);
  wear.resize(tools.size());
  turning.possible = feels_turns();
}

void Servo::State::rest(TickData& now, bool valid) noexcept {
  const HandSample& hand = now.hand;
  ServoTick& out = now.out;
  // without a valid hand pose: last pose of the proxy
  out.X_WT = valid ? Pose{hand.X_WT.p, made_unit(hand.X_WT.R)} : motion.X_WG;
  out.X_WG = motion.placed ? motion.X_WG : out.X_WT;
  out.faults = hand.faults & kNoPose ? hand.faults & kNoPose : bits(Fault::kBadInput);
  cutting.speed *= settings.spindle.lag(settings.tick);
  out.spindle = cutting.speed;
  out.energy = sums.energy;
  out.spindle_energy = sums.spindle_energy;
  motion.started = motion.idle = false;
  limits.last_force = limits.last_torque = limits.last_spindle_force = limits.last_teeth_force = limits.last_sent =
      limits.last_spindle_torque = dvec3(0);
  coupling.normal_force = coupling.head_force = coupling.pressing = 0;
  coupling.friction = {};
  if (soft) soft->release();
  soft_contact = {};
}

void Servo::State::begin_anew(const Pose& X_WT, Nanos t) noexcept {
  Motion& m = motion;
  m.began = t;
  // After invalid input or a pause, the proxy stays where it was outside the tissue; if the hand is far away, it
  // restarts at the hand.
  if (!m.placed || glm::length(X_WT.p - m.X_WG.p) > P::lost_distance) {
    m.X_WG = X_WT;
    m.began_at_hand = true;
  }
  m.placed = true;
  m.last_hand = X_WT;
  model->begin_anew();
  m.released = false;
  coupling.last_depth = coupling.rate = 0;
  coupling.depth_speed.reset();
  coupling.friction = {};
  coupling.tip = {};
  coupling.missing = {};
  coupling.bridged = coupling.returning = false;
  limits.given = limits.stored = 0;
  limits.ramp = 0;
}

inline void Servo::State::account(TickData& now, bool turns) noexcept {
  Limits& l = limits;
  if (now.hand.faults & bits(Fault::kLetGo)) {
    l.last_force = l.last_torque = l.last_spindle_force = l.last_teeth_force = l.last_sent = l.last_spindle_torque =
        dvec3(0);
  }
  now.moved = now.X_WT.p - motion.last_hand.p;
  now.turned = turns ? rotation_vector(motion.last_hand.R, now.X_WT.R) : dvec3(0);
  now.jumped = glm::dot(now.moved, now.moved) > P::hand_speed_limit * P::hand_speed_limit * now.dt * now.dt;
  motion.leap = std::max(0.0, (now.jumped ? P::leap_time : motion.leap) - now.dt);
  if (motion.idle) return;  // no force in the last tick, so no energy
  // Work of the last force and torque on the hand's motion; exact, because both were constant during the tick.
  now.given_to_hand = glm::dot(l.last_force, now.moved) + glm::dot(l.last_torque, now.turned);
  sums.energy -= now.given_to_hand;
  sums.spindle_energy += glm::dot(l.last_spindle_force, now.moved);
  if (turns && l.last_spindle_torque != dvec3(0)) sums.spindle_energy += glm::dot(l.last_spindle_torque, now.turned);
  l.teeth_energy += glm::dot(l.last_teeth_force, now.moved);
}

inline void Servo::State::run_spindle(const TickData& now) noexcept {
  const double wanted = now.out.pedal * free_speed();
  double& speed = cutting.speed;
  if (speed != wanted) speed = wanted + (speed - wanted) * settings.spindle.lag(now.dt);
}

void Servo::State::change_tool(TickData& now) noexcept {
  const std::uint32_t wanted = now.hand.tool;
  const Pose X_WG{motion.X_WG.p, now.X_WT.R};
  const bool stands =
      std::abs(now.out.pedal) <= kPedalUp && std::abs(cutting.speed) <= kPedalUp * std::abs(free_speed());
  if (!(wanted < tools.size() && stands && coupling.normal_force <= 0 && coupling.tip.penetration <= 0 &&
        !(soft && soft->touching()) && snapshot->number != 0 && model->is_free(in_hand, X_WG) &&
        model->is_free(wanted, X_WG))) {
    return;
  }
  in_hand = now.out.tool = wanted;
  now.out.wear = sums.wear = wear[wanted];
  model->take_up(wanted);
  turns_matter = model->turns_matter();
  turning.possible = feels_turns();
  turning.lags = false;
  motion.free_travel = 0;
  cutting.budget = cutting.wall_budget = cutting.wall = 0;
  coupling.tissue = {};
  coupling.hardness = own_hardness();
  coupling.relative_stiffness = 1;
  coupling.torque = dvec3(0);
  coupling.friction = {};
  coupling.tip = {};
}

inline bool Servo::State::move_free(TickData& now) noexcept {
  Motion& m = motion;
  ServoTick& out = now.out;
  if (!m.idle || limits.ending || tool().fill != Tissue::kAir || settings.filter != ForceFilter::kNone ||
      (settings.vibration.band > 0 && cutting.speed > 0)) {
    return false;
  }
  // m.free_travel: distance that the tool may move before it can touch tissue. Each tick subtracts the hand's motion;
  // when it is used up, the model computes a new clearance. While it lasts, the proxy is at the hand.
  const double moved = glm::length(now.moved), least = settings.frame.voxel;
  double motion_length = moved;
  if (!(m.free_travel > least && motion_length <= m.free_travel)) {
    motion_length = glm::length(now.X_WT.p - m.X_WG.p);
    m.free_travel = snapshot->number != 0 ? model->clearance({m.X_WG.p, now.X_WT.R}) : 0;
    if (!(m.free_travel > least && motion_length <= m.free_travel)) return false;
  }
  m.free_travel = turns_matter ? 0 : m.free_travel - motion_length;
  if (!m.released) {
    model->release();
    coupling.missing.forget();
    coupling.returning = false;
    m.released = true;
  }
  m.due_for = snapshot_due_for(now.X_WT.p, snapshot->center_W, travel) ? m.due_for + now.dt : 0;
  out.faults = m.due_for > P::stale_time ? bits(Fault::kStalePatch) : 0;
  m.began_at_hand = m.inside = false;
  cutting.budget = std::min(cutting.budget, 0.0);  // without contact, no energy is saved for a later cut
  cutting.wall_budget = 0;
  Limits& l = limits;
  l.ramp = now.hand.faults & bits(Fault::kHeld) ? 0 : 1;
  if (sums.energy < 0 || l.given > 0) l.given = std::clamp(-sums.energy, 0.0, cancelled_deficit());
  if (settings.position_step > 0) coupling.depth_speed.add(now.hand.t, dvec3(0));
  if (settings.passivity) {
    observe(l.law, now.moved, moved, now.turned, now.dt, settings.tick, false, l.passivity);
  }
  m.last_hand = m.X_WG = out.X_WG = now.X_WT;
  m.last_t = now.hand.t;
  now.cut.n_C_W = dvec3(0);
  out.spindle = cutting.speed;
  out.energy = sums.energy;
  out.spindle_energy = sums.spindle_energy;
  return true;
}

void Servo::State::fill_input(ContactTick& now) const noexcept {
  ContactInput& in = now.in;
  in.dt = now.dt;
  in.X_WT = now.X_WT;
  in.X_WG = motion.X_WG;
  in.moved = now.moved;
  in.jumped = now.jumped;
  in.removal.pedal = now.out.pedal;
  in.last.normal_force = coupling.normal_force;
  in.last.normal = coupling.normal;
  in.last.relative_stiffness = coupling.relative_stiffness;
}

void Servo::State::find_contact(ContactTick& now) noexcept {
  Contact& contact = now.contact;
  contact.p_WG = now.in.X_WT.p;
  if (snapshot->number == 0) {
    contact.p_WG = now.in.X_WG.p;
    contact.gap.lost = true;
  } else {
    model->constrain(now.in, contact);
    bridge_springs(now);
  }
  if (contact.gap.lost) now.faults |= bits(Fault::kPatchEdge);
}

/// Sets kStalePatch if a new snapshot is overdue because the carver is late. The old snapshot is still correct, so the
/// servo continues to compute forces with it.
void Servo::State::watch_snapshot(ContactTick& now) noexcept {
  const dvec3 wanted_W = snapshot_center_for(now.contact.p_WG, now.X_WT.p, travel);
  const bool due = snapshot->number == 0 || snapshot_due_for(wanted_W, snapshot->center_W, travel);
  motion.due_for = due ? motion.due_for + now.dt : 0;
  if (motion.due_for > P::stale_time) now.faults |= bits(Fault::kStalePatch);
}

/// Sets kDeepPenetration if the tool is inside tissue. A tool that started inside tissue is moved out before it cuts.
void Servo::State::watch_start(ContactTick& now) noexcept {
  Motion& m = motion;
  const Contact& contact = now.contact;
  const bool led = contact.leading_out || contact.deep;
  bool starts_inside = false;
  if (m.began_at_hand && !contact.gap.lost) {
    const double depth = std::max(contact.spring.depth, glm::distance(contact.p_WG, now.X_WT.p));
    starts_inside = led || (contact.touching && depth > settings.frame.voxel);
    m.began_at_hand = false;
  }
  m.inside = starts_inside || (m.inside && led);
  if (led || starts_inside) now.faults |= bits(Fault::kDeepPenetration);
}

bool Servo::State::remove(ContactTick& now) noexcept {
  double energy = 0;
  bool changed = false;
  const bool works = (now.in.removal.cuts && !motion.inside) || now.contact.places || tool().fill != Tissue::kAir;
  if (works && snapshot->number != 0) {
    Cut cut;
    cut.tool = in_hand;
    cut.spindle = cutting.speed;
    changed = model->cut(now.in, now.contact, cut, energy);
    if (changed) {
      cut.index = ++sums.cuts;
      cut.tick = now.out.index;
      cut.t = now.hand.t;
      now.cut = cut;
    }
  }
  now.faults |= now.contact.faults;
  if (!changed) return false;
  if (!model->estimates_volume()) {
    for (std::size_t i = 1; i < now.cut.removed.size(); ++i) sums.removed[i] += now.cut.removed[i];
  }
  if (energy > 0) spend(now, energy);
  if (tool().grit > 0) wear_grains(now);
  return true;
}

void Servo::State::remember(ContactTick& now, const dvec3& felt_torque) noexcept {
  ServoTick& out = now.out;
  Motion& m = motion;
  coupling.normal = now.normal;
  m.X_WG = {now.contact.p_WG, now.contact.orientation.held ? now.contact.orientation.R_WG : now.X_WT.R};
  limits.last_force = now.force;
  limits.last_torque = felt_torque;
  limits.last_spindle_force = now.spindle_force;
  limits.last_teeth_force = now.teeth_force;
  limits.last_sent = now.force + now.spindle_force;
  limits.last_spindle_torque = now.spindle_torque;
  m.last_hand = now.X_WT;
  m.last_t = now.hand.t;
  m.started = true;
  m.released = false;
  m.idle = coupling.normal_force <= 0 && now.contact.settled && coupling.tip.penetration <= 0 && limits.stored == 0 &&
           coupling.rate == 0 && now.force == dvec3(0) && now.spindle_force == dvec3(0) &&
           now.teeth_force == dvec3(0) && felt_torque == dvec3(0);
  now.cut.n_C_W = now.normal;

  out.X_WG = {now.p_held, m.X_WG.R};
  out.f_T_W = now.force + now.spindle_force;
  out.tau_T_W = now.torque;
  if (now.contact.orientation.held) out.tau_T_W += now.spindle_torque;
  out.removed = sums.removed;
  out.cuts = sums.cuts;
  out.spindle = cutting.speed;
  out.energy = sums.energy;
  out.spindle_energy = sums.spindle_energy;
  out.faults = now.faults;
}

void Servo::State::report_soft(ContactTick& now) noexcept {
  if (!now.soft.touching) return;
  ServoTick& out = now.out;
  out.X_WG.p += now.soft.yielded;
  out.depth = glm::length(out.X_WG.p - out.X_WT.p);
  // If the tool touches hard and soft tissue, the hard tissue is reported.
  if (out.tissue != Tissue::kAir) return;
  out.tissue = Tissue::kGingiva;
  const double push = glm::length(now.soft.force);
  if (push > 0) out.n_C_W = now.soft.force / push;
}

Servo::Servo(const ServoSettings& settings) : state_(std::make_unique<State>(settings)) {}
Servo::~Servo() = default;
Servo::Servo(Servo&&) noexcept = default;
Servo& Servo::operator=(Servo&&) noexcept = default;

void Servo::set_stiffness(const PerTissue& stiffness) noexcept {
  for (std::size_t i = 0; i < stiffness.size(); ++i) state_->settings.materials[i].stiffness = stiffness[i];
}

void Servo::ramp_out() noexcept {
  state_->limits.ending = true;
}

const Snapshot& Servo::snapshot() const noexcept {
  return *state_->snapshot;
}

SoftTissue* Servo::soft() noexcept {
  return state_->soft.get();
}

void Servo::adopt(Snapshot& fresh) noexcept {
  state_->model->adopt(fresh, state_->sums.removed);
  state_->travel = state_->model->travel();
  state_->motion.free_travel = 0;
}

bool Servo::tick(const HandSample& hand, ServoTick& out, Cut& cut) noexcept {
  State& s = *state_;
  const ServoSettings& settings = s.settings;
  TickData now{hand, out, cut};

  // Duration of the tick, s; the nominal duration if the clock jumps.
  now.dt = s.motion.started ? to_seconds(hand.t - s.motion.last_t) : settings.tick;
  if (!(now.dt > 0 && now.dt < P::longest_tick)) now.dt = settings.tick;

  copy_tick(s.sums, out);
  ++s.sums.index;
  out.t = hand.t;
  out.patch = s.snapshot->number;
  out.tool = s.in_hand;

  // Without a valid pose, the force is zero and the proxy restarts. The energy ledger ignores the motion: last force ×
  // jump could make the ledger negative, which would suppress the force. A new orientation is checked, an old one not.
  const bool comes_turned = hand.X_WT.R != s.motion.came_R;
  const bool valid = in_workspace(hand.X_WT.p) && (!comes_turned || is_unit(hand.X_WT.R)) && std::isfinite(hand.pedal);
  if (!valid || (hand.faults & kNoPose)) {
    s.rest(now, valid);
    return false;
  }
  bool turns = false;
  if (comes_turned) {
    s.motion.came_R = hand.X_WT.R;
    const dquat R_WT = made_unit(hand.X_WT.R);
    turns = R_WT != s.motion.R_WT;
    s.motion.R_WT = R_WT;
  }
  // Writes both positions from the input; copying one from the other would have to wait for the first write.
  out.X_WT.p = now.X_WT.p = hand.X_WT.p;
  out.X_WT.R = s.motion.R_WT;
  now.X_WT.R = s.motion.R_WT;
  out.pedal = std::clamp(hand.pedal, s.tool().reverses() ? -1.0 : 0.0, 1.0);
  if (!s.motion.started) s.begin_anew(now.X_WT, hand.t);

  s.account(now, turns);
  s.run_spindle(now);
  if (hand.tool != s.in_hand) s.change_tool(now);
  if ((!s.soft || s.soft->at_rest(now.X_WT, s.in_hand)) && s.move_free(now)) return false;
  s.motion.free_travel = 0;

  ContactTick touch(now);
  s.fill_input(touch);
  s.earn(touch);
  if (s.turning.possible) s.turn(touch);
  s.find_contact(touch);
  if (s.turning.lags) s.hold_turn(touch);
  s.cutting.wall = touch.contact.wall.share;
  out.level = touch.contact.level;
  s.watch_snapshot(touch);
  s.watch_start(touch);
  const bool removed = s.remove(touch);

  s.feel(touch);
  s.sink_tip(touch);
  if (s.soft) s.press_soft(touch);
  s.vibrate(touch);
  out.f_model_W = touch.force + touch.spindle_force;
  if (settings.filter != ForceFilter::kNone) {
    touch.force = filter_force(settings.filter, {}, touch.force, s.limits.last_force);
  }
  s.limit(touch);
  const dvec3 felt_torque = s.keep_passive(touch);
  s.remember(touch, felt_torque);
  if (s.soft) s.report_soft(touch);
  return removed;
}

}  // namespace typodont::haptics
