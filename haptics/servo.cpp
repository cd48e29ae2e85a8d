#include "haptics/servo.h"

#include <algorithm>
#include <array>
#include <climits>
#include <cmath>
#include <utility>

#include "engine/base/check.h"
#include "engine/base/units.h"
#include "haptics/contact/contact_planes.h"
#include "haptics/forces/friction.h"

namespace typodont::haptics {

namespace {

// All lengths in voxels unless said otherwise.
constexpr double kContactRange = 0.8;      // contacts farther away than this do not matter yet …
constexpr double kContactStep = 0.6;       // … because a step among several is no longer than this
constexpr double kStep = 1.5;              // longest step between two looks at the contacts: nothing thinner is skipped
constexpr double kConverged = 1e-7;        // the proxy has come to rest
constexpr double kSettled = 1e-3;          // the same against a surface that was cut, which is rough by more than that
constexpr int kSettlingLooks = 5;
constexpr double kSamePoints = 0.3;        // contacts found less than this ago, in voxels of way, still serve
constexpr double kToothGrip = 0.15;        // engaged teeth resist being led sideways up to this share of the push
constexpr int kMaxLooks = 48;              // per tick, free flight included
constexpr double kDeep = 0.6;              // more overlap than cutting or rounding leaves: led out slowly
constexpr double kRecoveryTime = 0.008;    // s, time constant of leading the tool out of tissue
constexpr double kBudgetTime = 0.05;       // s, cutting energy that may wait for a voxel to yield
constexpr double kStiffnessTime = 4e-3;    // s, the stiffness felt follows the tissue under the head
constexpr int kCutHistory = 8192;          // cuts a late patch may lack

/// Boxes of the last cuts, so that a fresh patch is brought up to date only where it may differ.
struct CutBoxes {
  struct Box {
    glm::ivec3 lo{0}, hi{0};
  };
  std::array<Box, kCutHistory> boxes;
  std::uint64_t last = 0;

  void add(std::uint64_t index, const glm::ivec3& lo, const glm::ivec3& hi) noexcept {
    boxes[index % kCutHistory] = {lo, hi};
    last = index;
  }
  /// Union of the boxes of cuts after `index`; everything when that reaches back too far. False when there is none.
  bool since(std::uint64_t index, glm::ivec3& lo, glm::ivec3& hi) const noexcept {
    if (index >= last) return false;
    lo = glm::ivec3(INT_MAX), hi = glm::ivec3(INT_MIN);
    if (last - index >= kCutHistory) {
      std::swap(lo, hi);
      return true;
    }
    for (std::uint64_t i = index + 1; i <= last; ++i) {
      lo = glm::min(lo, boxes[i % kCutHistory].lo);
      hi = glm::max(hi, boxes[i % kCutHistory].hi);
    }
    return true;
  }
};

/// A turning head that is pressed into tissue stays where it is until the hand leads it sideways by more than the teeth
/// grip (a friction cone on the god-object): roughness of the cut surface then does not shake the hand. Returns the
/// target as if that grip held back its tangential part.
dvec3 held_target(const dvec3& from, const dvec3& target, const dvec3& n) {
  const dvec3 pull = from - target;
  const double pushed = glm::dot(pull, n);
  if (!(pushed > 0)) return target;
  const dvec3 sideways = pull - pushed * n;
  const double length = glm::length(sideways);
  return target + sideways * (length > kToothGrip * pushed ? kToothGrip * pushed / length : 1.0);
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

int patch_edge_for(const Tool& tool, double voxel) {
  const double half = tool.reach() / voxel + Sweep::kMargin + 3 + travel_for(tool, voxel);
  return 2 * static_cast<int>(std::ceil(half)) + 1;
}

double patch_travel_for(const Tool& tool, double voxel) { return travel_for(tool, voxel); }

struct Servo::State {
  ServoSettings settings;
  ContactFinder finder;
  SurfacePatch patch;
  CutBoxes boxes;
  ContactSet contacts;  // of the last look

  // Where the tool is held outside the tissue.
  Pose X_WG;
  bool started = false;
  double overlap = 0;          // voxels of overlap still being led out

  // Force.
  double stiffness_share = 1;  // of the coupling, by the tissue under the head
  double normal_force = 0;     // N, last tick
  dvec3 normal{0};
  FrictionState friction;
  dvec3 last_force{0};         // N
  double last_depth = 0;       // m
  Pose last_hand;
  Nanos last_t = 0;

  // Cutting.
  double speed = 0;            // rad/s, free running
  double budget = 0;           // J that may still be spent on cutting
  PerTissue shares{};          // of the tissue under the head
  Pose cut_end;                // where the last cut ended
  ServoTick sums;              // carries index, removed, energy, cuts

  State(const ServoSettings& s, int edge) : settings(s), finder(s.tool, s.frame.voxel) {
    patch.resize(edge);
    speed = 0;
  }

  double mean(double Material::*member) const noexcept {
    double sum = 0, total = 0;
    for (std::size_t i = 1; i < shares.size(); ++i) {
      sum += shares[i] * settings.materials[i].*member;
      total += shares[i];
    }
    return total > 0 ? sum / total : 0;
  }

  /// A lower bound of the head's distance to tissue; only right as far as it is positive.
  double clearance(const dvec3& c) const noexcept { return sample_linear(patch, c) - finder.reach(); }
};

Servo::Servo(const ServoSettings& settings, int patch_edge) : state_(std::make_unique<State>(settings, patch_edge)) {}
Servo::~Servo() = default;
Servo::Servo(Servo&&) noexcept = default;
Servo& Servo::operator=(Servo&&) noexcept = default;

const SurfacePatch& Servo::patch() const noexcept { return state_->patch; }

void Servo::adopt(SurfacePatch& fresh) noexcept {
  State& s = *state_;
  if (fresh.n != s.patch.n) return;  // sized at set-up; never differs
  glm::ivec3 lo, hi;
  if (s.patch.number != 0 && s.boxes.since(fresh.cuts, lo, hi)) merge(fresh, s.patch, lo, hi);
  std::swap(fresh, s.patch);
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

  out = ServoTick{};
  out.index = sums.index++;
  out.t = hand.t;
  out.removed = sums.removed;
  out.cuts = sums.cuts;
  out.patch = s.patch.number;

  // Illegal input: zero force in this very tick, and the proxy starts anew afterwards.
  if (!is_sound(hand)) {
    out.X_WT = out.X_WG = s.X_WG;
    out.faults = bits(Fault::kBadInput);
    out.energy = sums.energy;
    s.started = false;
    s.last_force = dvec3(0);
    s.normal_force = 0;
    s.friction = {};
    return false;
  }
  const Pose X_WT{hand.X_WT.p, glm::normalize(hand.X_WT.R)};
  out.X_WT = X_WT;
  out.pedal = std::clamp(hand.pedal, 0.0, 1.0);
  if (!s.started) {
    s.X_WG = X_WT;
    s.last_hand = X_WT;
    s.last_depth = 0;
    s.overlap = 0;
    s.friction = {};
  }

  // What the device did to the hand since the last tick: exactly last force × way (numbers.md, "Stability").
  sums.energy -= glm::dot(s.last_force, X_WT.p - s.last_hand.p);

  // Spindle: the free speed follows the pedal.
  const double wanted_speed = out.pedal * settings.spindle.free_speed;
  s.speed = settings.spindle.run_up_time > 0
                ? wanted_speed + (s.speed - wanted_speed) * std::exp(-dt / settings.spindle.run_up_time)
                : wanted_speed;

  // Cutting power of this tick, from the push of the last: tangential force μ_c F_n at the rim, limited by the motor.
  const Tool& tool = settings.tool;
  const bool may_cut = settings.cutting && tool.cuts && s.speed > 0;
  SpindleLoad spindle{s.speed, 0};
  if (may_cut && s.normal_force > 0) {
    const double along = glm::dot(s.normal, X_WT.R * dvec3(0, 0, 1));
    const double efficiency = tool.side_efficiency + (tool.end_efficiency - tool.side_efficiency) * along * along;
    const double torque = tool.cutting_coefficient * efficiency * s.normal_force * tool.radius();
    spindle = load_spindle(settings.spindle, s.speed, out.pedal, torque);
    s.budget = std::min(s.budget + spindle.power * dt, spindle.power * kBudgetTime);
  } else if (s.normal_force <= 0) {
    s.budget = std::min(s.budget, 0.0);
  }

  // Move the proxy toward the hand: freely while nothing is near, along the contacts otherwise.
  const dvec3 c0 = settings.frame.to_voxels(s.X_WG.p), target = settings.frame.to_voxels(X_WT.p);
  dvec3 c = c0;
  double slack = 0;
  ContactSet& contacts = s.contacts;
  contacts.count = 0;
  contacts.engaged_area = 0;
  ActivePlanes active;
  bool touching = false, lost = false, deep = false;
  int settled_looks = 0;
  dvec3 found_at(0);
  s.overlap *= std::exp(-dt / kRecoveryTime);
  if (s.overlap < 0.01) s.overlap = 0;
  const double specific_energy = s.mean(&Material::specific_energy);

  for (int look = 0; look < kMaxLooks; ++look) {
    const dvec3 way = target - c;
    const double distance = glm::length(way);
    if (!s.patch.holds(c, s.finder.reach() + 1)) {
      lost = true;
      break;
    }
    const double clearance = s.clearance(c);
    if (clearance > 2) {  // sphere tracing: as far as nothing can be met
      touching = false;
      if (distance <= clearance - 1) {
        c = target;
        break;
      }
      const dvec3 next = c + way * ((clearance - 1) / distance);
      if (!s.patch.holds(next, s.finder.reach() + 1)) {
        lost = true;
        break;
      }
      c = next;
      continue;
    }

    // The surface points found once serve as long as the head has hardly moved; a single exact one is always new.
    if (contacts.count > 1 && glm::length(c - found_at) < kSamePoints) {
      s.finder.relinearize({c, X_WT.R}, contacts);
    } else {
      s.finder.find(s.patch, {c, X_WT.R}, kContactRange, contacts);
      found_at = c;
    }
    if (contacts.count == 0 && sample_linear(s.patch, c) < -kStep) {  // wholly inside: no surface in reach
      deep = true;
      c = target;
      touching = false;
      break;
    }
    if (look == 0 || !touching) {
      // How much the head may sink in this tick: the budget buys area × depth + the cap of a first touch.
      if (may_cut && s.budget > 0 && specific_energy > 0) {
        const double volume = s.budget / specific_energy / (h * h * h);
        const double area = glm::length(contacts.engaged_normal);
        const double cap = kPi * tool.radius() / h;
        slack = 2 * volume / (area + std::sqrt(area * area + 4 * cap * volume));
      }
    }
    if (look == 0) {
      double worst = 0;
      for (int i = 0; i < contacts.count; ++i) {
        worst = std::max(worst, -contacts.planes[static_cast<std::size_t>(i)].gap);
      }
      if (worst > s.overlap + slack + kDeep) s.overlap = worst;
    }
    const double room = slack + s.overlap;
    const dvec3 pulled_to = s.normal_force > 0 && may_cut ? held_target(c0, target, s.normal) : target;
    dvec3 next = nearest_allowed(contacts, c, room, pulled_to, active);
    if (contacts.count > 1 && active.count > 0) {  // rough planes chose which hold; exact ones say how far
      for (int i = 0; i < active.count; ++i) {
        s.finder.refine(s.patch, {c, X_WT.R}, contacts.planes[static_cast<std::size_t>(active.index[i])]);
      }
      next = nearest_allowed(contacts, c, room, pulled_to, active);
    }
    touching = contacts.count > 0;
    const dvec3 step = next - c;
    const double length = glm::length(step);
    const double longest = contacts.count > 1 ? kContactStep : kStep;
    if (length > longest) {
      c += step * (longest / length);
      continue;
    }
    c = next;
    if (length < (contacts.count > 1 ? kSettled : kConverged) || ++settled_looks >= kSettlingLooks) break;
    // On a smooth surface each look squares the error; when nothing pushes, the target was reached.
    if (active.count == 0) {
      touching = false;
      break;
    }
  }
  if (s.overlap > 0) faults |= bits(Fault::kDeepPenetration);
  if (deep) faults |= bits(Fault::kDeepPenetration);
  if (lost) faults |= bits(Fault::kPatchEdge);
  const dvec3 p_WG = c == target ? X_WT.p : settings.frame.to_world(c);

  // Cut: everything the head sweeps on its way.
  bool cut_made = false;
  if (may_cut && touching && !deep) {
    const Pose X_WB{p_WG, X_WT.R};
    const bool continues = sums.cuts > 0 && same(s.X_WG, s.cut_end);
    const Sweep sweep(tool, s.X_WG, X_WB, settings.frame, continues);
    bool changed;
    const PerTissue removed = carve(s.patch, sweep, &changed);
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
      s.boxes.add(sums.cuts, sweep.lo(), sweep.hi());
      cut = {sums.cuts, out.index, hand.t, s.X_WG, {p_WG, X_WT.R}, settings.tool_index, {}, {}, spindle.speed};
      for (std::size_t i = 0; i < removed.size(); ++i) cut.removed[i] = removed[i] * h * h * h;
      out.cutting_power = energy / dt;
      s.budget -= energy;
    }
  }

  // Contact seen from the hand.
  dvec3 force(0), normal(0);
  const dvec3 depth_vector = p_WG - X_WT.p;
  const double depth = glm::length(depth_vector);
  if (touching && !lost && depth > 0) {
    normal = depth_vector / depth;
    // Tissue under the head: at each contact a voxel deep, weighted by how much it pushes.
    PerTissue shares{};
    double total = 0;
    for (int i = 0; i < active.count; ++i) {
      const ContactPlane& plane = contacts.planes[static_cast<std::size_t>(active.index[i])];
      const double weight = active.push[i];
      const dvec3 below = plane.x - plane.n;
      if (!s.patch.holds(below, 0)) continue;
      const PerTissue here = sample_tissue(s.patch, below);
      for (std::size_t t = 1; t < here.size(); ++t) shares[t] += weight * here[t];
      total += weight;
    }
    if (total > 0) {
      for (double& share : shares) share /= total;
      s.shares = shares;
    }
    const double wanted = s.mean(&Material::stiffness) / 1000.0;  // relative to enamel's 1 N/mm
    const bool fresh = s.normal_force <= 0;
    s.stiffness_share = fresh ? wanted : wanted + (s.stiffness_share - wanted) * std::exp(-dt / kStiffnessTime);
    const double k = settings.stiffness * s.stiffness_share;

    double magnitude = k * depth;
    if (settings.damping > 0 && s.started && s.overlap == 0) {
      // Along the normal only, from the depth itself: sliding at constant depth is not damped.
      magnitude = std::max(0.0, magnitude + settings.damping * (depth - s.last_depth) / dt);
    }
    force = magnitude * normal;
    s.normal_force = k * depth;
    if (settings.friction && !(may_cut)) {  // a turning bur slips always; its tangential force is the cutting force
      const FrictionLaw law{s.mean(&Material::static_friction), s.mean(&Material::dynamic_friction), settings.stiffness};
      force += friction_force(law, p_WG, s.X_WG.p, normal, s.normal_force, s.friction);
    }
    const auto most = std::max_element(s.shares.begin() + 1, s.shares.end());
    out.tissue = *most > 0 ? static_cast<Tissue>(most - s.shares.begin()) : Tissue::kAir;
    out.depth = depth;
    out.n_C_W = normal;
  } else {
    s.normal_force = 0;
    s.friction = {};
  }
  // Area of the head on tissue: from the samples, or, where one query sufficed, of the cap under the tangent plane.
  if (touching) {
    out.contact_area = contacts.engaged_area > 0 ? contacts.engaged_area * h * h : kPi * tool.radius() * h;
  }

  const double magnitude = glm::length(force);
  if (magnitude > settings.force_limit) {
    force *= settings.force_limit / magnitude;
    faults |= bits(Fault::kForceLimit);
  }

  s.normal = normal;
  s.last_depth = out.depth;
  s.X_WG = {p_WG, X_WT.R};
  s.last_force = force;
  s.last_hand = X_WT;
  s.last_t = hand.t;
  s.started = true;
  cut.n_C_W = normal;

  out.X_WG = s.X_WG;
  out.f_T_W = force;
  out.removed = sums.removed;
  out.cuts = sums.cuts;
  out.spindle = spindle.speed;
  out.energy = sums.energy;
  out.faults = faults;
  return cut_made;
}

}  // namespace typodont::haptics
