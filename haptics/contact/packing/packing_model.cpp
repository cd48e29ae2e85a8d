#include "haptics/contact/packing/packing_model.h"

#include <algorithm>
#include <span>
#include <utility>

#include "haptics/contact/packing/packing_method.h"
#include "haptics/contact/tool_check.h"

namespace typodont::haptics::packing {

namespace {

constexpr double kMaxClearance = 10e-3;  // m, largest distance that clearance() can return
// m; tissue_at() finds spheres whose surfaces are up to this far from the point
constexpr double kNearSphere = 0.2e-3;
// largest number of cut lengths per tick that are tried to find the longest one within the energy budget
constexpr int kTrials = 8;
// The search for the length of a cut ends when the cut uses at least this fraction of the energy budget.
constexpr double kWellSpent = 0.85;
// N, force limit of a dental scene. When the proxy moves back along its path, the rate of force equals that of "offset"
// if the scene's limit is at most this; with a larger limit, the rate is larger in proportion.
constexpr double kDentalForces = 20;
// m/s, largest speed of the tool's farthest point. Faster than any hand, so the proxy catches up soon after a jump.
constexpr double kFastest = 5;

// With a large contact, the head advances only about 10 nm per tick but cuts thousands of spheres: cuts are postponed.
constexpr double kLargeArea = 10e-6;      // m², contact area above which cuts are postponed
constexpr double kMinCutStep = 1e-6;      // m; cuts with shorter steps are postponed
constexpr double kLongestDelay = 4.5e-3;  // s, largest time for which a cut is postponed
constexpr double kAtRest = 0.1e-6;        // m; after a smaller motion, the tissue estimate is reused

/// Options of a proxy without friction; set_friction() sets the friction.
ProxyOptions frictionless(double tick) {
  return {.static_friction = 0, .dynamic_friction = 0, .longest_path = kFastest * tick};
}

Pose part_of(const Pose& from, const dvec3& move, const dvec3& turn, double fraction) {
  if (turn == dvec3(0)) return {from.p + fraction * move, from.R};
  return {from.p + fraction * move, glm::normalize(SphereProxy::turned_by(fraction * turn) * from.R)};
}

}  // namespace

PackingModel::PackingModel(const ServoSettings& settings, const Parameters& parameters)
    : settings_(settings),
      parameters_(parameters),
      density_(densities(parameters, settings.materials)),
      buffers_(parameters.spheres),
      tried_(parameters.spheres),
      near_(2 * parameters.spheres) {
  const double dentin = settings.materials[static_cast<std::size_t>(Tissue::kDentin)].specific_energy;
  for (std::size_t t = 0; t < kTissueCount; ++t) energy_[t] = density_[t] * dentin;
  std::size_t head = 0;
  const std::span<const Tool> tools = tool_set(settings);
  refuse_tools_that_fill(tools, kName);
  for (std::size_t t = 0; t < tools.size(); ++t) {
    proxies_.emplace_back(spheres_of(tools, t, parameters), frictionless(settings.tick));
    head = std::max(head, proxies_.back().tool().head);
  }
  near_end_.resize(head);
}

void PackingModel::adopt(Snapshot& snapshot, PerTissue& removed) noexcept {
  auto& fresh = static_cast<PackingSnapshot&>(snapshot);
  const bool first = snapshot_.number == 0;
  // Repeats the servo's cuts that `fresh` lacks. After undo or a loose piece, these cuts may remove a different volume.
  for (std::uint64_t i = made_.first_after(fresh.cuts); !first && i <= made_.last(); ++i) {
    MadeCut& made = made_[i];
    const PerTissue now =
        carve(fresh.spheres, proxies_[made.tool].tool(), made.X_WA, made.X_WB, buffers_, [](Place, const CutSphere&) {
        }).volume;
    for (std::size_t t = 0; t < now.size(); ++t) removed[t] += now[t] - made.removed[t];
    made.removed = now;
  }
  for (std::size_t t = 0; t < removed.size(); ++t) {
    removed[t] += fresh.loose[t] - snapshot_.loose[t];
    if (!first) removed[t] -= fresh.taken_back[t] - snapshot_.taken_back[t];
  }
  postponed_for_ = 0;
  const bool came_back = first || fresh.edits != snapshot_.edits;
  std::swap(fresh, snapshot_);
  // Without undo or redo, the proxies' lists of near spheres remain valid, because spheres can only have been removed
  // (loose pieces).
  if (came_back) {
    for (SphereProxy& proxy : proxies_) proxy.forget_near();
  }
}

double PackingModel::clearance(const Pose& X_WG) noexcept {
  const double reach = proxy().tool().reach;
  // The servo uses only clearances larger than one voxel, so smaller values need not be exact.
  const double least = settings_.frame.voxel;
  return std::max(0.0, snapshot_.spheres.tree().clearance(X_WG.p, kMaxClearance + reach, least + reach) - reach);
}

bool PackingModel::is_free(std::uint32_t which, const Pose& X_W) noexcept {
  const ToolSpheres& tool = proxies_[which].tool();
  const SphereTree& tree = snapshot_.spheres.tree();
  for (std::size_t t = 0; t < tool.radius.size(); ++t) {
    if (tree.touches(X_W * tool.center_T[t], tool.radius[t])) return false;
  }
  return true;
}

void PackingModel::take_up(std::uint32_t tool) noexcept {
  tool_ = tool;
  forget_contact();
}

void PackingModel::forget_contact() noexcept {
  placed_ = false;
  postponed_for_ = 0;
  retreat_.path.begin(proxy().pose().p / retreat_.path_unit);
  retreat_.forget();
}

/// Records the proxy's path. The proxy is blocked if contacts hold it although the tool would be free at the hand.
void PackingModel::watch_retreat(const ContactInput& in) noexcept {
  const dvec3& p = proxy().pose().p;
  const bool outside =
      !proxy().touches() && !snapshot_.spheres.tree().touches(p, proxy().tool().reach + RetreatParameters::outside);
  if (retreat_.is_held(p, in.X_WT.p, outside, in.dt) && is_free(tool_, in.X_WT)) retreat_.begin(p, in.X_WT.p);
}

/// Moves the proxy back along its path, slowly and without cutting. No tissue was added meanwhile, so the path is free.
/// Returns true while the proxy moves back.
bool PackingModel::lead_back(const ContactInput& in) noexcept {
  Pose X = proxy().pose();
  const double slew = std::max(1.0, settings_.force_limit / kDentalForces) * RetreatParameters::slew;
  const double stiffness = settings_.stiffness * std::max(in.last.relative_stiffness, 0.05);
  if (!retreat_.lead(in.X_WT.p, slew * in.dt / stiffness, X.p)) return false;
  proxy().place(X);
  return true;
}

void PackingModel::constrain(const ContactInput& in, Contact& out) noexcept {
  if (!placed_ && !is_free(tool_, in.X_WG)) out.faults |= bits(Fault::kDeepPenetration);
  // Without contact, the servo moves the tool without this model.
  if (!placed_ || in.X_WG.p != held_) proxy().place(in.X_WG);
  placed_ = true;
  if (lead_back(in)) {
    surface_ = {};
    out.p_WG = held_ = proxy().pose().p;
    out.breaking_through = true;
    out.settled = false;
    out.faults |= bits(Fault::kWedged);
    return;
  }
  set_friction(in);
  proxy().follow(snapshot_.spheres.tree(), in.X_WT);
  out.p_WG = held_ = proxy().pose().p;
  out.touching = proxy().touches();
  out.settled = !out.touching;
  watch_retreat(in);
  if (retreat_.wedged) out.faults |= bits(Fault::kWedged);
  if (!out.touching) {
    surface_ = {};
    return;
  }
  out.own_friction = true;
  out.contact_direction = out.p_WG - in.X_WT.p;
  estimate_tissue();
  out.area = surface_.volume / parameters_.epsilon;
}

/// Pass 2: estimates the tissue in contact. While a cut is postponed and the head rests, the last estimate is reused.
void PackingModel::estimate_tissue() noexcept {
  const Pose& X = proxy().pose();
  if (postponed_for_ > 0 && surface_.volume > 0) {
    const double turned = turns_matter() ? glm::length(SphereProxy::rotation_angle(X_estimated_.R, X.R)) : 0.0;
    if (glm::distance(X_estimated_.p, X.p) + proxy().tool().reach * turned < kAtRest) return;
  }
  X_estimated_ = X;
  surface_ = estimate_surface(snapshot_.spheres, proxy(), proxy().contact_point(), parameters_.epsilon, density_,
                              buffers_.changed);
  if (!(surface_.volume > 0)) take_tissue_from_contacts();
}

/// If the head overlaps no tissue (the shank touches, or one point of the head), uses the tissue of touched spheres.
void PackingModel::take_tissue_from_contacts() noexcept {
  double total = 0;
  for (const ProxyContact& c : proxy().contacts()) {
    const auto t = static_cast<std::size_t>(snapshot_.spheres.tissue(c.sphere));
    surface_.fraction[t] += c.push;
    surface_.hardness[t] += c.push * snapshot_.spheres.hardness(c.sphere);
    total += c.push;
  }
  for (std::size_t t = 0; t < surface_.fraction.size(); ++t) {
    if (!(surface_.fraction[t] > 0)) continue;
    surface_.hardness[t] /= surface_.fraction[t];
    surface_.fraction[t] /= total;
  }
}

/// Sets the friction (paper S2, eq. 13) for the tissue of the last tick. Zero for a rotating bur, because the servo
/// computes the force of its cutting edges.
void PackingModel::set_friction(const ContactInput& in) noexcept {
  double fixed = 0, sliding = 0;
  if (settings_.friction && (!in.removal.cuts || in.removal.scrapes)) {
    for (std::size_t t = 1; t < surface_.fraction.size(); ++t) {
      fixed += surface_.fraction[t] * settings_.materials[t].static_friction;
      sliding += surface_.fraction[t] * settings_.materials[t].dynamic_friction;
    }
  }
  proxy().set_friction(fixed, std::min(fixed, sliding));
}

/// For each sphere of the head, lists the tissue spheres that it can touch from the proxy to `to`.
void PackingModel::find_near(const Pose& to) noexcept {
  const ToolSpheres& tool = proxy().tool();
  std::size_t end = 0;
  for (std::size_t t = 0; t < tool.head; ++t) {
    const std::span<Place> left = std::span(near_).subspan(end);
    end += std::min(left.size(), proxy().near_path(snapshot_.spheres.tree(), t, to, left));
    near_end_[t] = end;
  }
}

/// Energy to cut along the motion, J. The motion must not exceed that of the last find_near().
double PackingModel::cost(const Pose& from, const Pose& to) noexcept {
  const ToolSpheres& tool = proxy().tool();
  double sum = 0;
  tried_.begin(tool.head);
  for (std::size_t t = 0, begin = 0; t < tool.head; begin = near_end_[t++]) {
    const std::span<const Place> near = std::span(near_).subspan(begin, near_end_[t] - begin);
    const dvec3 a = from * tool.center_T[t], b = to * tool.center_T[t];
    sum += tried_.add(snapshot_.spheres, near, a, b, tool.radius[t], tool.curve[t], energy_);
  }
  return sum;
}

/// Returns the largest fraction of the motion, at most `most`, whose cut the energy budget pays; up to 15 % of it may
/// remain. Increases the fraction until the cut costs too much, then alternates secant method and bisection.
double PackingModel::affordable(const Pose& from, const dvec3& move, const dvec3& turn, double most,
                                double budget) noexcept {
  double safe = 0, safe_cost = 0, dear = most, dear_cost = -1;
  double part = price_ > 0 ? 0.97 * budget / price_ : most;
  double listed = -1;  // fraction of the motion that the lists of near spheres cover
  for (int k = 0; k < kTrials; ++k) {
    part = std::min(part, most);
    if (part > listed) {
      listed = listed < 0 ? std::min(most, 2 * part) : most;
      find_near(part_of(from, move, turn, listed));
    }
    const double spent = cost(from, part_of(from, move, turn, part));
    tried_share_ = part;
    if (spent <= budget) {
      safe = part, safe_cost = spent;
      if (part == most || spent >= kWellSpent * budget) break;
    } else {
      dear = part, dear_cost = spent;
    }
    if (dear_cost < 0) {
      part = spent > 0 ? 0.97 * budget / spent * part : most;
      if (part < 1.5 * safe) part = 1.5 * safe;
      continue;
    }
    // Every second step is a bisection: each newly touched sphere raises the cost, so the secant converges slowly.
    const double by_secant = (budget - safe_cost) / (dear_cost - safe_cost);
    part = safe + (k % 2 == 0 ? 0.97 * by_secant : 0.5) * (dear - safe);
  }
  price_ = safe > 0 && safe_cost > 0 ? safe_cost / safe : 0;
  return safe;
}

/// Returns true if the cut is postponed, because its step would be shorter than kMinCutStep; the energy is saved for
/// later. `step`: m, step that the current energy allows.
bool PackingModel::postpones(double dt, double step) noexcept {
  const bool waits =
      step < kMinCutStep && surface_.volume > kLargeArea * parameters_.epsilon && postponed_for_ + dt < kLongestDelay;
  postponed_for_ = waits ? postponed_for_ + dt : 0;
  return waits;
}

bool PackingModel::cut(const ContactInput& in, Contact& contact, Cut& cut, double& energy) noexcept {
  const bool by_power = !(parameters_.base_speed > 0);
  if (!(in.removal.cuts && !in.removal.must_earn && contact.touching) || (by_power && !(in.removal.budget > 0)))
    return false;
  const ToolSpheres& tool = proxy().tool();
  const Pose from = proxy().pose();
  dvec3 move = in.X_WT.p - from.p;
  dvec3 turn = turns_matter() ? SphereProxy::rotation_angle(from.R, in.X_WT.R) : dvec3(0);
  tried_share_ = -1;
  double most =
      proxy().non_cutting_parts_allow(snapshot_.spheres.tree(), 2 * parameters_.free_speed * in.dt, move, turn);
  const double angle = glm::length(turn), motion = glm::length(move) + tool.head_reach * angle;
  if (!(motion > 0)) return false;
  price_ *= motion / std::max(last_path_length_, 1e-12);
  last_path_length_ = motion;
  if (angle > 0) most = std::min(most, kMaxTurn / angle);
  if (by_power && price_ > 0 && postpones(in.dt, in.removal.budget / price_ * motion)) return false;
  if (by_power) {
    most = std::min(most, parameters_.free_speed * in.dt / motion);
    most = affordable(from, move, turn, most, in.removal.budget);
  } else {
    const double density = parameters_.by_contact ? surface_.density : surface_.normalised;
    const double speed = cutting_speed(parameters_.base_speed, density, parameters_.free_speed);
    most = std::min(most, cutting_step(speed, in.dt, motion) / motion);
  }
  const Pose to = part_of(from, move, turn, most);
  bool changed = false;
  Removed removed;
  const SphereTree& tree = snapshot_.spheres.tree();
  const auto note = [&](Place place, double protrudes) {
    changed = true;
    proxy().note_cut(tree, place, protrudes);
  };
  // On a straight path, the cost computation (TriedCut) has already listed all changes of the cut.
  const bool straight = turn == dvec3(0) || (tool.head == 1 && tool.center_T[0] == dvec3(0));
  if (tried_share_ == most && straight && tried_.complete() && near_end_[tool.head - 1] < near_.size()) {
    snapshot_.spheres.make(tried_, removed, note, [&] { proxy().end_notes(); });
  } else {
    const auto near = [&](std::size_t t, std::span<Place> found) {
      proxy().end_notes();
      return proxy().near_path(tree, t, to, found);
    };
    removed = carve(snapshot_.spheres, tool, from, to, buffers_, near, [&](Place place, const CutSphere& before) {
      note(place, glm::distance(tree.center(place), before.center()) + tree.radius(place) - before.radius());
    });
    proxy().end_notes();
  }
  // Only rounding errors blocked the motion; follow() moves the proxy in the next tick.
  if (!changed) return false;
  made_.add(made_.last() + 1, {from, to, tool_, removed.volume});
  cut.X_WA = from, cut.X_WB = to;
  cut.removed = removed.volume;
  for (std::size_t t = 1; t < energy_.size(); ++t) energy += removed.hardened[t] * energy_[t];
  proxy().move_to(to);
  contact.p_WG = held_ = to.p;
  return true;
}

void PackingModel::feel(const ContactInput& in, Contact& contact, Felt& out) noexcept {
  const auto contacts = proxy().contacts();
  const auto head = static_cast<int>(proxy().tool().head);
  out.turns_tool = turns_matter();
  double total = 0;
  for (const ProxyContact& c : contacts) {
    const bool own = c.tool_sphere < head;
    ++out.count;
    out.own += own;
    total += c.push;
    out.add(c.push, c.p_W - contact.p_WG, c.n_W, own);
  }
  if (total > 0) out.lever /= total;
  // Friction, and a proxy that has not yet followed the hand, also displace the tool: this force acts at the mean
  // contact (paper S2, eq. 8).
  if (out.turns_tool) out.turn += glm::cross(out.lever, contact.p_WG - in.X_WT.p - out.on_head - out.on_shank);
  if (total > 0) {
    out.tissue = surface_.fraction;
    out.known_tissue = true;
    out.graded = snapshot_.spheres.graded();
    out.hardness = surface_.hardness;
  }
}

Tissue PackingModel::tissue_at(const dvec3& p_W) const noexcept {
  std::array<Place, 64> near;
  const SphereTree& tree = snapshot_.spheres.tree();
  const std::size_t count = std::min(tree.near_segment(p_W, p_W, kNearSphere, near), near.size());
  Tissue tissue = Tissue::kAir;
  double nearest = kNearSphere;
  for (std::size_t k = 0; k < count; ++k) {
    const double off = glm::distance(p_W, tree.center(near[k])) - tree.radius(near[k]);
    if (off < nearest) nearest = off, tissue = snapshot_.spheres.tissue(near[k]);
  }
  return tissue;
}

}  // namespace typodont::haptics::packing
