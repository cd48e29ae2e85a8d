// What the contact gives the hand: coupling, damper, friction, teeth, a tip that sinks, the spindle's vibration.
#include <algorithm>
#include <cmath>

#include "haptics/servo/state.h"

namespace typodont::haptics {

namespace {

constexpr double kFeltBelow = 0.5;        // voxels under the surface, where the tissue is that the head feels
constexpr double kStiffnessTime = 4e-3;   // s, the stiffness felt follows the tissue under the head
constexpr double kCutDampingTime = 4e-3;  // s, the depth's rate is smoothed over this for the damper while cutting
constexpr double kTissueSlew = 4;         // N/s, no faster does another tissue under the head change the force …
constexpr double kUnpaid = 0.15e-3;       // J, … nor does a harder one store more than the ledger holds, beyond this
constexpr double kTeethSlew = 4;          // N/s, of the tangential force of the teeth
constexpr double kDamperSlew = 4;         // N/s, of the damper while cutting
constexpr double kRestWaits =
    16;  // N/s: another tissue and the damper wait where with the depth's change it would be more
constexpr double kCutSlewInAll = 18;  // N/s: the teeth's force waits where all that changes would come to more
constexpr double kTeethAhead = 50;    // ticks for which the spindle's work must suffice, or that force shrinks

}  // namespace

void Servo::State::feel(Touch& now) noexcept {
  const Tool& head = tool();
  const double h = settings.frame.voxel;
  const bool many_contacts = head.shape != HeadShape::kSphere || smooth().any();
  now.p_held = now.p_WG;
  const dvec3 depth_vector = now.p_WG - now.X_WT.p;
  const double depth = glm::length(depth_vector);
  VelocityEstimate sinking;
  if (settings.position_step > 0) sinking = depth_speed.add(now.hand.t, {depth, 0, 0});
  // Area of the head on tissue: from the samples, or, where one query sufficed, of the cap under the tangent plane.
  if (now.touching && contacts.own() > 0) {
    now.out.contact_area = contacts.engaged_area() > 0 ? contacts.engaged_area() * h * h : kPi * head.radius() * h;
  }
  const bool held_back = ((now.touching || breaking_through) && !now.lost) || now.bridging;
  if (!(held_back && depth > 0)) {
    normal_force = head_force = pressing = 0;
    rate = 0;
    friction = {};
    teeth_force = dvec3(0);
    return;
  }

  now.normal = depth_vector / depth;
  const Push push = feel_tissue(now, many_contacts);
  const bool fresh = normal_force <= 0;
  const double k = settings.stiffness * follow_stiffness(now, depth);
  now.stored = k * depth * depth / 2;
  const double magnitude = damped(now, k * depth, depth, sinking.v.x);
  now.force = magnitude * now.normal;
  // Each contact pushes along its own normal; together they are the force, and they turn the tool about its centre.
  now.torque = h * h * magnitude / depth * push.torque;
  normal_force = k * depth;
  head_force = normal_force;
  if (contacts.own() < contacts.count() && glm::dot(push.on_smooth, push.on_smooth) > 0) {
    const double on_head = glm::length(push.on_head);
    head_force *= on_head / (on_head + glm::length(push.on_smooth));
  }
  if (now.held_off != dvec3(0)) {
    pressed = glm::normalize(now.held_off);
  } else if (!now.bridging) {
    pressed = dvec3(0);  // free, and led at a pace: the motor has nothing to work on
  }
  pressing = head_force * std::max(0.0, glm::dot(pressed, now.normal));
  dvec3 sideways(0);
  // A turning bur slips always; its tangential force is that of the teeth.
  if (settings.friction && (!now.may_cut || now.scrapes)) {
    const FrictionLaw law{mean(&Material::static_friction), mean(&Material::dynamic_friction), settings.stiffness};
    sideways = friction_force(law, now.p_WG, X_WG.p, now.normal, normal_force, friction);
    now.force += sideways;
  }
  feel_teeth(now);
  if (many_contacts) {
    now.torque += h * glm::cross(push.lever, sideways + now.spindle_force);
    // Which of many contacts carry how much may change from tick to tick; what the wrist feels follows smoothly.
    if (contacts.count() > 1 && !fresh) now.torque += (torque - now.torque) * std::exp(-now.dt / kStiffnessTime);
    torque = now.torque;
  }
  const auto most = std::max_element(shares.begin() + 1, shares.end());
  now.out.tissue = *most > 0 ? static_cast<Tissue>(most - shares.begin()) : Tissue::kAir;
  now.out.depth = depth;
  now.out.n_C_W = now.normal;
}

/// Tissue under the head: below each contact, weighted by how much it pushes. `many_contacts`: they turn the
/// tool, so where they attack is summed up too.
Servo::State::Push Servo::State::feel_tissue(const Touch& now, bool many_contacts) noexcept {
  PerTissue under{};
  double total = 0;
  Push push;
  for (int i = 0; i < now.active.count; ++i) {
    const int which = now.active.index[i];
    const ContactPlane plane = contacts.plane(which);
    const double weight = now.active.push[i];
    total += weight;
    if (many_contacts) {
      push.lever += weight * (plane.x - now.c);
      push.torque += weight * glm::cross(plane.x - now.c, plane.n);
    }
    (which < contacts.own() ? push.on_head : push.on_smooth) += weight * plane.n;
    dvec3 below = plane.x - kFeltBelow * plane.n;
    const SurfacePatch* felt_in = &patch;
    if (!patch.holds(below, 0)) {
      if (patch.wide.empty()) continue;
      felt_in = &patch.wide.front();
      below = plane.x / static_cast<double>(felt_in->every) - kFeltBelow * plane.n;
      if (!felt_in->holds(below, 0)) continue;
    }
    const PerTissue here = sample_tissue(*felt_in, below);
    for (std::size_t t = 1; t < here.size(); ++t) under[t] += weight * here[t];
  }
  double labelled = 0;
  for (const double share : under) labelled += share;
  if (labelled > 0) {
    for (double& share : under) share /= labelled;
    shares = under;
  }
  if (total > 0) push.lever /= total;
  return push;
}

/// What the depth's change leaves for others to change the force by in this tick, N.
double Servo::State::spare_change(const Touch& now, double depth) const noexcept {
  const double k = settings.stiffness * stiffness_share;
  return std::max(kRestWaits * now.dt - glm::length(k * depth * now.normal - normal_force * normal), 0.0);
}

/// The coupling's stiffness relative to enamel's 1 N/mm: that of the tissue under the head, followed smoothly.
double Servo::State::follow_stiffness(const Touch& now, double depth) noexcept {
  const double wanted = mean(&Material::stiffness) / 1000.0;
  if (normal_force <= 0) return stiffness_share = wanted;
  // Under a deep push a change of stiffness is a large change of force, and a rise is energy that no hand put in.
  const double most = std::min(spare_change(now, depth), kTissueSlew * now.dt) / (settings.stiffness * depth);
  const double step = (wanted - stiffness_share) * (1 - std::exp(-now.dt / kStiffnessTime));
  const double paid = 2 * std::max(sums.energy + given, kUnpaid) / (settings.stiffness * depth * depth);
  double share = stiffness_share + std::clamp(step, -most, most);
  if (step > 0) share = std::min(share, std::max(stiffness_share, paid));
  return stiffness_share = share;
}

/// The coupling's push and the damper's, N. Along the normal only, from the depth itself: sliding at constant depth is
/// not damped. `sinking`: m/s, the estimate of the depth's rate where the hand moves by counts.
double Servo::State::damped(const Touch& now, double push, double depth, double sinking) noexcept {
  if (!(settings.damping > 0 && started)) return push;
  // What a tool cuts or puts down itself is rough: the proxy moves on it by fits and starts, voxel by voxel.
  const bool rough = now.may_cut || tool().fill != Tissue::kAir;
  const double smooth = rough ? std::exp(-now.dt / kCutDampingTime) : 0.0;
  const double measured = settings.position_step > 0 ? sinking : (depth - last_depth) / now.dt;
  double change = ((overlap > 0 ? 0 : measured) - rate) * (1 - smooth);
  if (rough && normal_force > 0) {
    const double most = std::min(spare_change(now, depth), kDamperSlew * now.dt) / settings.damping;
    change = std::clamp(change, -most, most);
  }
  rate += change;
  return std::max(0.0, push + settings.damping * rate);
}

/// The tissue pushes the teeth back, against their way; not at the pole, where they stand still.
void Servo::State::feel_teeth(Touch& now) noexcept {
  now.spindle_force = now.tangential * pressing * glm::cross(now.X_WT.R * dvec3(0, 0, 1), pressed);
  if (const dvec3 change = now.spindle_force - teeth_force; change != dvec3(0)) {
    const double size = glm::length(change), most = kTeethSlew * now.dt;
    const dvec3 step = change * (size > most ? most / size : 1.0);
    const dvec3 rest = now.force + teeth_force - last_force - last_teeth_force;
    now.spindle_force = teeth_force + largest_share(step, rest, kCutSlewInAll * now.dt) * step;
  }
  // Never more to the hand than the spindle itself has done, should the hand go with it as abruptly as it lately did.
  const double abruptly = passivity.change.most * now.dt;
  if (const double needed = glm::dot(now.spindle_force, now.moved) + abruptly * glm::length(now.spindle_force);
      needed > 0) {
    now.spindle_force *= std::min(1.0, std::max(0.0, spindle_work - teeth_energy) / (kTeethAhead * needed));
  }
  teeth_force = now.spindle_force;
}

void Servo::State::sink_tip(Touch& now) noexcept {
  const Tool& head = tool();
  if (!(head.sink_yield > 0 && !head.cuts && !now.lost)) return;
  const TipLaw law{head.sink_yield};
  const double k = settings.stiffness * stiffness_share;
  if (tip.sunk <= 0 && shares[static_cast<std::size_t>(Tissue::kCaries)] > 0.5 && normal_force > law.yield) {
    tip = {1e-9, now.p_WG, now.normal};
  }
  if (!(tip.sunk > 0)) return;
  const dvec3 ahead = settings.frame.to_voxels(tip.p) - (finder().reach() + 1) * tip.n;
  const bool soft = patch.holds(ahead, 0) && tissue_at(patch, ahead) == Tissue::kCaries;
  now.force = tip_force(law, now.X_WT.p, k, soft, tip);
  if (!(tip.sunk > 0)) return;
  now.p_held = tip.p;
  now.out.depth = glm::length(now.p_held - now.X_WT.p);
  now.out.tissue = Tissue::kCaries;
  now.out.n_C_W = tip.n;
  now.stored = k * now.out.depth * now.out.depth / 2;
  now.torque = dvec3(0);
}

/// From the same contact as the sound's. Its energy is the motor's: the ledger has it with the spindle's. A period has
/// five ticks or more.
void Servo::State::vibrate(Touch& now) noexcept {
  now.teeth_force = now.spindle_force;
  if (!(settings.vibration.band > 0 && now.spindle.speed > 0)) return;
  phase = advance_phase(phase, now.spindle.speed, now.dt);
  const double band = std::min(settings.vibration.band, 0.2 / settings.tick);
  now.spindle_force += vibration_force(settings.vibration, band, phase, now.spindle.speed, now.X_WT.R * dvec3(0, 0, 1),
                                       now.normal, now.tangential * pressing);
}

}  // namespace typodont::haptics
