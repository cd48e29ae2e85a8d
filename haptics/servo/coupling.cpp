// Contact force: coupling, damper, friction, cutting edges, sinking tip, vibration. Servo thread only.
#include <algorithm>
#include <cmath>

#include "haptics/servo/chips.h"
#include "haptics/servo/state.h"

namespace typodont::haptics {

using P = CouplingParameters;

/// Means over the tissues under the head, and the most frequent tissue (if several are equally frequent, the first).
/// Tissues with fraction 0 are skipped.
Servo::State::TissueMeans Servo::State::tissue_means() const noexcept {
  TissueMeans mean;
  double total = 0, most = 0;
  for (std::size_t i = 1; i < coupling.tissue.size(); ++i) {
    const double fraction = coupling.tissue[i];
    if (fraction == 0) continue;
    const Material& material = settings.materials[i];
    mean.stiffness += fraction * material.stiffness * coupling.hardness[i];
    mean.static_friction += fraction * material.static_friction;
    mean.dynamic_friction += fraction * material.dynamic_friction;
    total += fraction;
    if (fraction > most) most = fraction, mean.most = static_cast<Tissue>(i);
  }
  if (!(total > 0)) return {};
  mean.stiffness /= total;
  mean.static_friction /= total;
  mean.dynamic_friction /= total;
  return mean;
}

Servo::State::EdgeMeans Servo::State::edge_means() const noexcept {
  EdgeMeans mean{0, 1, tool().cutting_coefficient};
  const bool grinds = tool().grit > 0, known = tool().edges_known();
  // A worn diamond bur cuts like a new one with `times` the feed, and needs `times` the energy per volume.
  const double times = 1 + sums.wear, feed = cutting.feed * times;
  const double chip = known ? chip_thickness(tool(), feed) : 0.0;
  double sum = 0, by_chips = 0, force_ratio = 0, total = 0;
  for (std::size_t i = 1; i < coupling.tissue.size(); ++i) {
    const double fraction = coupling.tissue[i];
    if (fraction == 0) continue;
    const Material& material = settings.materials[i];
    const double energy = fraction * material.specific_energy * coupling.hardness[i];
    sum += energy;
    total += fraction;
    if (!known) continue;
    const EdgeLaw& law = grinds ? material.grit : material.blade;
    by_chips += energy * energy_ratio(law, chip);
    force_ratio += fraction * (law.force_ratio > 0 ? law.force_ratio : tool().cutting_coefficient);
  }
  if (!(total > 0)) return mean;
  mean.specific_energy = sum / total;
  if (known) mean.force_ratio = force_ratio / total;
  if (known && sum > 0) mean.energy_ratio = by_chips / sum * rubbing(tool(), feed) * times;
  return mean;
}

void Servo::State::bridge_springs(ContactTick& now) noexcept {
  Coupling& c = coupling;
  Contact& contact = now.contact;
  if (!contact.spring.whole) return;
  const double k = settings.stiffness * std::max(c.relative_stiffness, 0.05);
  // A penalty method has no proxy. Its plane begins where the coupling would have the force of the springs.
  const dvec3 start = now.in.X_WG.p + (c.bridged ? 0.0 : c.normal_force / k) * c.normal;
  const MissingSnapshot::Motion moving{1,     settings.frame.voxel, glm::length(now.moved),
                                       start, now.in.X_WT.p,        now.dt / k};
  c.returning |= c.missing.bridge(now.in, moving, contact.p_WG, contact.gap);
  if (contact.gap.bridging && !c.bridged) {
    c.last_depth = c.normal_force / k;
    c.rate = 0;
    c.depth_speed.reset();
  }
  c.bridged = contact.gap.bridging;
  contact.gap.rejoining = c.returning;
  // The force of the plane ends gradually, also if the new snapshot has no tissue at the tool.
  contact.touching |= c.returning && !contact.gap.lost && c.normal_force > 0;
}

void Servo::State::return_springs(ContactTick& now) noexcept {
  Coupling& c = coupling;
  ContactSprings& spring = now.contact.spring;
  const dvec3 felt = c.normal_force * c.normal, change = spring.force - felt;
  const double size = glm::length(change),
               most = settings.stiffness * glm::length(now.moved) + MissingSnapshotParameters::return_slew * now.dt;
  c.returning = size > most;
  now.contact.gap.rejoining = c.returning;
  if (!c.returning) return;
  const double whole = glm::length(spring.force);
  spring.force = felt + most / size * change;
  const double strength = glm::length(spring.force);
  spring.torque *= whole > 0 ? std::min(1.0, strength / whole) : 0.0;
  spring.stored = strength * strength / (2 * settings.stiffness * std::max(c.relative_stiffness, 0.05));
}

void Servo::State::feel(ContactTick& now) noexcept {
  const Contact& contact = now.contact;
  now.p_held = contact.p_WG;
  now.out.contact_area = contact.area;
  const dvec3 depth_vector = contact.p_WG - now.X_WT.p;
  const double depth = glm::length(depth_vector);
  const bool held_back = ((contact.touching || contact.breaking_through) && !contact.gap.lost) || contact.gap.bridging;
  if (contact.spring.whole && contact.touching) {
    take_force(now);
  } else if (held_back && (depth > 0 || (turning.lags && turning.twist != dvec3(0)))) {
    // opposed walls may hold the orientation alone
    now.normal = depth > 0 ? depth_vector / depth : turning.normal;
    couple(now, depth);
  } else {
    feel_nothing(now);
  }
  coupling.last_depth = now.out.depth;
}

void Servo::State::feel_nothing(ContactTick& now) noexcept {
  Coupling& c = coupling;
  if (settings.position_step > 0) c.depth_speed.add(now.hand.t, {glm::length(now.contact.p_WG - now.X_WT.p), 0, 0});
  c.normal_force = c.head_force = c.pressing = 0;
  c.rate = 0;
  c.friction = {};
  fade_teeth(now);
}

/// Computes spring and damper between proxy and hand.
void Servo::State::couple(ContactTick& now, double depth) noexcept {
  Coupling& c = coupling;
  model->feel(now.in, now.contact, now.felt);
  const Contact& contact = now.contact;
  const Felt& felt = now.felt;
  const bool turned = turning.lags;
  double lever2 = 0, strain = depth;  // m², m; the springs of position and orientation store k strain² / 2
  if (turned) {
    lever2 = TurnParameters::stiffness / settings.stiffness;
    strain = std::sqrt(depth * depth + lever2 * glm::dot(turning.twist, turning.twist));
    if (!felt.known_tissue) feel_held_tissue(now);
  }
  if (felt.known_tissue) c.tissue = felt.tissue;
  if (felt.graded) c.hardness = felt.hardness;
  const bool fresh = c.normal_force <= 0;
  const TissueMeans mean = tissue_means();
  const double wanted = turned && !(mean.stiffness > 0) ? c.relative_stiffness : mean.stiffness / 1000.0;
  const double k = settings.stiffness * follow_stiffness(now, depth, strain, wanted);
  now.stored = k * strain * strain / 2;
  const double magnitude = damped(now, k * depth, depth);
  now.force = magnitude * now.normal;
  if (const double along = depth * glm::dot(now.normal, contact.wall.normal); along > 0) {
    const double more = std::max(0.0, settings.stiffness * contact.wall.stiffness - k) * along;
    now.force += more * contact.wall.normal;
    now.stored += more * along / 2;
  }
  // Each contact pushes the tool along its normal; the moments of these forces rotate the tool. If the tissue holds the
  // proxy's orientation, the spring between the orientations balances them.
  const double h = felt.unit;
  if (!turned) now.torque = h * h * magnitude / depth * felt.turn;
  c.normal_force = k * depth;
  c.head_force = c.normal_force;
  if (felt.own < felt.count && glm::dot(felt.on_shank, felt.on_shank) > 0) {
    const double on_head = glm::length(felt.on_head);
    c.head_force *= on_head / (on_head + glm::length(felt.on_shank));
  }
  if (contact.contact_direction != dvec3(0)) {
    c.pressed = glm::normalize(contact.contact_direction);
  } else if (!contact.gap.bridging) {
    c.pressed = dvec3(0);  // the head is not pressed against tissue
  }
  c.pressing = c.teeth_fraction * c.head_force * std::max(0.0, glm::dot(c.pressed, now.normal));
  if (const double speed = std::abs(cutting.speed); tool().edges_known() && speed > 0 && c.pressed != dvec3(0)) {
    const double advance = -glm::dot(contact.p_WG - motion.X_WG.p, c.pressed) / now.dt;
    cutting.feed += (2 * kPi * advance / speed - cutting.feed) * (1 - std::exp(-now.dt / ChipParameters::time));
  }
  dvec3 sideways(0);
  // No friction for a rotating bur: it always slips, and its edges give the tangential force.
  if (settings.friction && !contact.own_friction && (!now.in.removal.cuts || now.in.removal.scrapes)) {
    const FrictionLaw law{mean.static_friction, mean.dynamic_friction, settings.stiffness};
    // Opposed walls press more on the tool than the coupling's force, and friction acts across their normal.
    const bool opposed = turned && turning.count > 0 && turning.opposed;
    sideways = friction_force(law, contact.p_WG, motion.X_WG.p, opposed ? turning.normal : now.normal,
                              opposed ? k * turning.push : c.normal_force, c.friction);
    now.force += sideways;
  }
  feel_teeth(now);
  if (felt.turns_tool) {
    now.torque += turned && turning.count > 0 ? glm::cross(turning.lever, sideways + now.spindle_force)
                                              : h * glm::cross(felt.lever, sideways + now.spindle_force);
    // Between ticks, the force may jump from one contact to another, so the torque is filtered.
    if (felt.count > 1 && !fresh) now.torque += (c.torque - now.torque) * std::exp(-now.dt / P::stiffness_time);
    c.torque = now.torque;
  }
  if (turned) {
    now.torque += k * lever2 * turning.twist;
  } else if (contact.orientation.held) {
    now.torque += contact.spring.torque;
    now.stored += contact.spring.stored;
    now.spindle_torque = contact.orientation.spindle_torque;
  }
  now.out.tissue = mean.most;
  now.out.depth = depth;
  now.out.n_C_W = now.normal;
}

/// Uses the force of the contact method's own springs and dampers instead of the coupling.
void Servo::State::take_force(ContactTick& now) noexcept {
  Coupling& c = coupling;
  model->feel(now.in, now.contact, now.felt);
  if (c.returning) return_springs(now);
  const Contact& contact = now.contact;
  const Felt& felt = now.felt;
  if (felt.known_tissue) c.tissue = felt.tissue;
  if (felt.graded) c.hardness = felt.hardness;
  const double size = glm::length(contact.spring.force);
  now.stored = contact.spring.stored;
  now.force = contact.spring.force;
  now.torque = contact.spring.torque;
  if (size > 0) now.normal = contact.spring.force / size;
  c.normal_force = c.head_force = c.pressing = size;
  c.pressed = now.normal;
  const TissueMeans mean = tissue_means();
  if (mean.stiffness > 0) c.relative_stiffness = mean.stiffness / 1000.0;
  if (settings.friction && size > 0 && (!now.in.removal.cuts || now.in.removal.scrapes)) {
    const FrictionLaw law{mean.static_friction, mean.dynamic_friction, settings.stiffness};
    now.force += friction_force(law, contact.p_WG, motion.X_WG.p, now.normal, size, c.friction);
  }
  feel_teeth(now);
  c.torque = now.torque;
  now.out.tissue = mean.most;
  now.out.depth = contact.spring.depth;
  now.out.n_C_W = now.normal;
}

/// Returns by how much stiffness and damper may still change the normal force in this tick, N: the limit
/// P::waiting_slew · dt minus the change due to the penetration depth `depth` (m).
double Servo::State::spare_change(const ContactTick& now, double depth) const noexcept {
  const double k = settings.stiffness * coupling.relative_stiffness;
  const dvec3 change = k * depth * now.normal - coupling.normal_force * coupling.normal;
  return std::max(P::waiting_slew * now.dt - glm::length(change), 0.0);
}

/// Returns the factor on the coupling's stiffness; it follows `wanted` (the tissue's stiffness / 1 N/mm) smoothly.
/// `strain`: m; the coupling stores stiffness × strain² / 2.
double Servo::State::follow_stiffness(const ContactTick& now, double depth, double strain, double wanted) noexcept {
  double& stiffness = coupling.relative_stiffness;
  if (coupling.normal_force <= 0 || wanted == stiffness) return stiffness = wanted;
  // At large depth, a small change of stiffness changes the force much, and an increase stores energy that the hand did
  // not supply. So the change per tick is at most `most`.
  const double most = std::min(spare_change(now, depth), P::tissue_slew * now.dt) / (settings.stiffness * strain);
  const double step = (wanted - stiffness) * (1 - std::exp(-now.dt / P::stiffness_time));
  const double paid = 2 * std::max(sums.energy + limits.given, P::unpaid) / (settings.stiffness * strain * strain);
  double next = stiffness + std::clamp(step, -most, most);
  if (step > 0) next = std::min(next, std::max(stiffness, paid));
  return stiffness = next;
}

/// Force of coupling and damper, N. `push`: N, force of the coupling alone. The damper acts along the normal only, so
/// sliding is not damped.
double Servo::State::damped(const ContactTick& now, double push, double depth) noexcept {
  Coupling& c = coupling;
  VelocityEstimate sinking;  // estimated rate of the depth; used if the device's position has steps (position_step)
  if (settings.position_step > 0) sinking = c.depth_speed.add(now.hand.t, {depth, 0, 0});
  if (!(settings.damping > 0 && motion.started)) return push;
  // Surfaces of cuts and fillings are rough: the proxy moves in steps of voxels.
  const bool rough = now.in.removal.cuts || tool().fill != Tissue::kAir;
  const double smooth = rough ? std::exp(-now.dt / P::cut_damping_time) : 0.0;
  const double measured = settings.position_step > 0 ? sinking.v.x : (depth - c.last_depth) / now.dt;
  const bool led = now.contact.leading_out || motion.leap > 0;  // true: the hand does not cause the proxy's motion
  double change = ((led ? 0 : measured) - c.rate) * (1 - smooth);
  if (rough && c.normal_force > 0) {
    const double most = std::min(spare_change(now, depth), P::damper_slew * now.dt) / settings.damping;
    change = std::clamp(change, -most, most);
  }
  c.rate += change;
  return std::max(0.0, push + settings.damping * c.rate);
}

/// Force of the tissue on the cutting edges, against their motion; zero at the head's pole, where they do not move.
void Servo::State::feel_teeth(ContactTick& now) noexcept {
  Coupling& c = coupling;
  now.spindle_force = now.tangential * c.pressing * glm::cross(now.X_WT.R * dvec3(0, 0, 1), c.pressed);
  if (const dvec3 change = now.spindle_force - c.teeth_force; change != dvec3(0)) {
    const double size = glm::length(change), most = P::teeth_slew * now.dt;
    const dvec3 step = change * (size > most ? most / size : 1.0);
    const dvec3 rest = now.force + c.teeth_force - limits.last_force - limits.last_teeth_force;
    now.spindle_force = c.teeth_force + max_fraction(step, rest, P::total_slew * now.dt) * step;
  }
  limit_teeth_energy(now);
}

/// After contact, reduces a remaining force of the cutting edges gradually. Without a tissue snapshot, sets it to zero.
void Servo::State::fade_teeth(ContactTick& now) noexcept {
  Coupling& c = coupling;
  if (c.teeth_force == dvec3(0)) return;
  // N, force that remains after this tick
  const double left = glm::length(c.teeth_force) - P::total_slew * now.dt;
  if (left > 0 && !now.contact.gap.lost) {
    now.spindle_force = left * glm::normalize(c.teeth_force);
    limit_teeth_energy(now);
  } else {
    c.teeth_force = dvec3(0);
  }
}

/// Limits the force on the cutting edges, so that it never does more work than the spindle supplied, even if the hand's
/// velocity changes as abruptly as it did recently.
void Servo::State::limit_teeth_energy(ContactTick& now) noexcept {
  const double abruptly = limits.passivity.change.most * now.dt;
  if (const double needed = glm::dot(now.spindle_force, now.moved) + abruptly * glm::length(now.spindle_force);
      needed > 0) {
    now.spindle_force *=
        std::min(1.0, std::max(0.0, cutting.spindle_work - limits.teeth_energy) / (P::teeth_ahead * needed));
  }
  coupling.teeth_force = now.spindle_force;
}

void Servo::State::sink_tip(ContactTick& now) noexcept {
  const Tool& head = tool();
  TipState& tip = coupling.tip;
  if (!(head.sink_yield > 0 && !head.cuts)) return;
  const TipLaw law{.yield = head.sink_yield, .reach = head.reach(), .ahead = settings.frame.voxel};
  const double k = settings.stiffness * coupling.relative_stiffness;
  const bool stuck = tip.penetration > 0;
  if (now.contact.gap.lost) {
    tip.penetration = 0;
  } else if (!stuck && coupling.tissue[static_cast<std::size_t>(Tissue::kCaries)] > 0.5 &&
             coupling.normal_force > law.yield) {
    tip.penetration = 1e-9, tip.p = now.contact.p_WG, tip.n = now.normal;
  }
  if (tip.penetration > 0) {
    const auto soft_at = [&](const dvec3& p) { return model->tissue_at(p) == Tissue::kCaries; };
    const dvec3 force = tip_force(law, now.X_WT.p, k, soft_at, tip);
    if (tip.penetration > 0) now.force = force;
  }
  const bool sticks = tip.penetration > 0;
  if (sticks != stuck) tip.rest = tip.force - now.force;
  const double rest = glm::length(tip.rest);
  tip.rest *= rest > 0 ? std::max(0.0, 1 - law.slew * now.dt / rest) : 0.0;
  now.force += tip.rest;
  tip.force = now.force;
  if (!sticks) return;
  now.p_held = tip.p;
  now.out.depth = glm::length(now.p_held - now.X_WT.p);
  now.out.tissue = Tissue::kCaries;
  now.out.n_C_W = tip.n;
  now.stored = k * now.out.depth * now.out.depth / 2;
  now.torque = dvec3(0);
}

void Servo::State::press_soft(ContactTick& now) noexcept {
  const Pose X_WG{now.p_held, now.contact.orientation.held ? now.contact.orientation.R_WG : now.X_WT.R};
  if (soft->at_rest(X_WG, in_hand)) {
    soft_contact = {};
    return;
  }
  const bool turns = now.in.removal.cuts && !now.in.removal.scrapes;
  const double cutting_speed = turns ? tool().cutting_coefficient * std::abs(cutting.speed) * tool().radius() : 0.0;
  now.soft = soft->tick({now.hand.t, now.dt, X_WG, in_hand, cutting_speed});
  now.force += now.soft.force;
  now.stored += now.soft.stored;
  const double push = glm::length(now.soft.force);
  const dvec3 p = X_WG.p + now.soft.yielded;
  if (settings.friction && !turns && push > 0) {
    const double coefficient = soft->surface().law().friction;
    now.force += friction_force({coefficient, 0.75 * coefficient, settings.stiffness}, p, soft_contact.p,
                                now.soft.force / push, push, soft_contact.friction);
  } else {
    soft_contact.friction = {};
  }
  soft_contact.p = p;
}

/// Vibration, caused by the same contact as the sound. In the energy ledger, its energy counts as work of the spindle.
/// A period of the vibration lasts at least five ticks.
void Servo::State::vibrate(ContactTick& now) noexcept {
  now.teeth_force = now.spindle_force;
  if (!(settings.vibration.band > 0 && cutting.speed > 0)) return;
  cutting.phase = advance_phase(cutting.phase, cutting.speed, now.dt);
  const double band = std::min(settings.vibration.band, 0.2 / settings.tick);
  now.spindle_force += vibration_force(settings.vibration, band, cutting.phase, cutting.speed,
                                       now.X_WT.R * dvec3(0, 0, 1), now.normal, now.tangential * coupling.pressing);
}

}  // namespace typodont::haptics
