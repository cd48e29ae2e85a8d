#include "haptics/contact/packing/packing_model.h"

#include <algorithm>
#include <limits>
#include <span>
#include <utility>

#include "haptics/contact/packing/packing_method.h"
#include "haptics/contact/tool_check.h"

namespace typodont::haptics::packing {

namespace {

constexpr double kLook = 10e-3;        // m, how far a free tool looks around itself
constexpr double kNearby = 0.2e-3;     // m, within which a point belongs to the nearest sphere
constexpr int kTrials = 8;             // of a step's length
constexpr double kWellSpent = 0.85;    // share of the budget that a step may leave unspent, at most
constexpr double kLargestTurn = 0.02;  // rad, of a cut: chords leave arcs by 5e-5 of the head's reach

/// Friction is the proxy's, by what lies under it (set_friction); coupling and damper are the servo's.
constexpr ProxyOptions kFrictionless{.stiffness = 0, .damping = 0, .static_friction = 0, .dynamic_friction = 0};

Pose part_of(const Pose& from, const dvec3& move, const dvec3& turn, double share) {
  if (turn == dvec3(0)) return {from.p + share * move, from.R};
  return {from.p + share * move, glm::normalize(SphereProxy::turned_by(share * turn) * from.R)};
}

}  // namespace

PackingModel::PackingModel(const ServoSettings& settings, const Parameters& parameters)
    : settings_(settings),
      parameters_(parameters),
      density_(densities(parameters, settings.materials)),
      buffers_(parameters.spheres),
      near_(2 * parameters.spheres) {
  const double dentin = settings.materials[static_cast<std::size_t>(Tissue::kDentin)].specific_energy;
  for (std::size_t t = 0; t < kTissueCount; ++t) energy_[t] = density_[t] * dentin;
  std::size_t head = 0;
  const std::span<const Tool> tools = tool_set(settings);
  refuse_tools_that_fill(tools, kName);
  for (std::size_t t = 0; t < tools.size(); ++t) {
    proxies_.emplace_back(spheres_of(tools, t, parameters), kFrictionless);
    head = std::max(head, proxies_.back().tool().head);
  }
  near_end_.resize(head);
}

double PackingModel::travel() const noexcept {
  return std::numeric_limits<double>::infinity();
}

void PackingModel::adopt(Snapshot& snapshot, PerTissue& removed) noexcept {
  auto& fresh = static_cast<PackingSnapshot&>(snapshot);
  const bool first = snapshot_.number == 0;
  // The fresh spheres lack the cuts made since. After an undo, or where a piece was removed, these may take more or
  // less than they did.
  for (std::uint64_t i = made_.first_after(fresh.cuts); !first && i <= made_.last(); ++i) {
    MadeCut& made = made_[i];
    const PerTissue now =
        carve(fresh.spheres, proxies_[made.tool].tool(), made.X_WA, made.X_WB, buffers_, [](int, const CutSphere&) {
        }).volume;
    for (std::size_t t = 0; t < now.size(); ++t) removed[t] += now[t] - made.removed[t];
    made.removed = now;
  }
  for (std::size_t t = 0; t < removed.size(); ++t) {
    removed[t] += fresh.loose[t] - snapshot_.loose[t];
    if (!first) removed[t] -= fresh.taken_back[t] - snapshot_.taken_back[t];
  }
  std::swap(fresh, snapshot_);
  for (SphereProxy& proxy : proxies_) proxy.forget_free();
}

double PackingModel::clearance(const Pose& X_WG) noexcept {
  if (snapshot_.number == 0) return 0;
  const double reach = proxy().tool().reach;
  return std::max(0.0, snapshot_.spheres.tree().room(X_WG.p, kLook + reach) - reach);
}

bool PackingModel::is_free(const ToolSpheres& tool, const Pose& X_W) const noexcept {
  const SphereTree& tree = snapshot_.spheres.tree();
  for (std::size_t t = 0; t < tool.radius.size(); ++t) {
    if (tree.room(X_W * tool.center_T[t], tool.radius[t] + 1) <= tool.radius[t]) return false;
  }
  return true;
}

bool PackingModel::may_take_up(std::uint32_t tool, const Pose& X_WG) noexcept {
  return snapshot_.number > 0 && is_free(proxy().tool(), X_WG) && is_free(proxies_[tool].tool(), X_WG);
}

void PackingModel::take_up(std::uint32_t tool) noexcept {
  tool_ = tool;
  placed_ = false;
}

void PackingModel::constrain(const ContactInput& in, Contact& out) noexcept {
  if (snapshot_.number == 0) {
    surface_ = {};
    out.p_WG = in.X_WT.p;
    out.lost = true;
    out.faults |= bits(Fault::kPatchEdge);
    return;
  }
  // The servo moves a free tool without asking.
  if (!placed_ || in.X_WG.p != held_) proxy().place(in.X_WG);
  placed_ = true;
  set_friction(in);
  proxy().follow(snapshot_.spheres.tree(), in.X_WT);
  out.p_WG = held_ = proxy().pose().p;
  out.touching = proxy().touches();
  out.settled = !out.touching;
  if (!out.touching) {
    surface_ = {};
    return;
  }
  out.own_friction = true;
  out.held_off_direction = out.p_WG - in.X_WT.p;
  surface_ = estimate_surface(snapshot_.spheres, proxy().tool(), proxy().pose(), proxy().contact_point(),
                              parameters_.epsilon, density_, buffers_.changed);
  if (!(surface_.volume > 0)) take_tissue_from_contacts();
  out.area = surface_.volume / parameters_.epsilon;
}

/// Where only parts that never cut touch anything, or the contact is a point.
void PackingModel::take_tissue_from_contacts() noexcept {
  double total = 0;
  for (const ProxyContact& c : proxy().contacts()) {
    const auto t = static_cast<std::size_t>(snapshot_.spheres.tissue(c.sphere));
    surface_.share[t] += c.push;
    surface_.hardness[t] += c.push * snapshot_.spheres.hardness(c.sphere);
    total += c.push;
  }
  for (std::size_t t = 0; t < surface_.share.size(); ++t) {
    if (!(surface_.share[t] > 0)) continue;
    surface_.hardness[t] /= surface_.share[t];
    surface_.share[t] /= total;
  }
}

/// Eq. 13, by the tissue that was under the head in the last tick. A turning bur slips always, and what its teeth pull
/// at is the servo's.
void PackingModel::set_friction(const ContactInput& in) noexcept {
  double fixed = 0, sliding = 0;
  if (settings_.friction && (!in.cuts || in.scrapes)) {
    for (std::size_t t = 1; t < surface_.share.size(); ++t) {
      fixed += surface_.share[t] * settings_.materials[t].static_friction;
      sliding += surface_.share[t] * settings_.materials[t].dynamic_friction;
    }
  }
  proxy().set_friction(fixed, std::min(fixed, sliding));
}

/// Lists the spheres near the head's way.
void PackingModel::find_near(const Pose& from, const Pose& to) noexcept {
  const ToolSpheres& tool = proxy().tool();
  std::size_t end = 0;
  for (std::size_t t = 0; t < tool.head; ++t) {
    const std::span<int> left = std::span(near_).subspan(end);
    end += std::min(left.size(), snapshot_.spheres.tree().near_segment(from * tool.center_T[t], to * tool.center_T[t],
                                                                       tool.radius[t], left));
    near_end_[t] = end;
  }
}

/// J that the way costs, at most: where several of the head's spheres cover the same tissue it counts for each.
double PackingModel::cost(const Pose& from, const Pose& to) const noexcept {
  const ToolSpheres& tool = proxy().tool();
  double sum = 0;
  for (std::size_t t = 0, begin = 0; t < tool.head; begin = near_end_[t++]) {
    sum += snapshot_.spheres.cost(std::span(near_).subspan(begin, near_end_[t] - begin), from * tool.center_T[t],
                                  to * tool.center_T[t], tool.radius[t], energy_);
  }
  return sum;
}

/// The part of the way, at most `most`, that costs what may be spent, or a little less: what is left over counts in the
/// next tick. The price of the last step is the first guess, then the secant rule on the safe side.
double PackingModel::affordable(const Pose& from, const dvec3& move, const dvec3& turn, double most,
                                double budget) noexcept {
  double safe = 0, safe_cost = 0, dear = most, dear_cost = -1;
  double part = price_ > 0 ? 0.97 * budget / price_ : most;
  for (int k = 0; k < kTrials; ++k) {
    part = std::min(part, most);
    const double spent = cost(from, part_of(from, move, turn, part));
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
    // The cost bends upward where a sphere is first cut; half the interval at every other trial catches that.
    const double by_secant = (budget - safe_cost) / (dear_cost - safe_cost);
    part = safe + (k % 2 == 0 ? 0.97 * by_secant : 0.5) * (dear - safe);
  }
  price_ = safe > 0 && safe_cost > 0 ? safe_cost / safe : 0;
  return safe;
}

bool PackingModel::cut(const ContactInput& in, Contact& contact, Cut& cut, double& energy) noexcept {
  const bool by_power = !(parameters_.base_speed > 0);
  if (!(in.cuts && !in.must_earn && contact.touching) || (by_power && !(in.budget > 0))) return false;
  const ToolSpheres& tool = proxy().tool();
  const Pose from = proxy().pose();
  dvec3 move = in.X_WT.p - from.p;
  dvec3 turn = turns_matter() ? SphereProxy::turn_between(from.R, in.X_WT.R) : dvec3(0);
  double most = proxy().smooth_parts_allow(snapshot_.spheres.tree(), move, turn);
  const double angle = glm::length(turn), way = glm::length(move) + tool.head_reach * angle;
  if (!(way > 0)) return false;
  price_ *= way / std::max(last_way_, 1e-12);
  last_way_ = way;
  if (angle > 0) most = std::min(most, kLargestTurn / angle);
  if (by_power) {
    most = std::min(most, parameters_.free_speed * in.dt / way);
    find_near(from, part_of(from, move, turn, most));
    most = affordable(from, move, turn, most, in.budget);
  } else {
    const double density = parameters_.by_contact ? surface_.density : surface_.normalised;
    const double speed = cutting_speed(parameters_.base_speed, density, parameters_.free_speed);
    most = std::min(most, cutting_step(speed, in.dt, way) / way);
  }
  const Pose to = part_of(from, move, turn, most);
  bool changed = false;
  const Removed removed =
      carve(snapshot_.spheres, tool, from, to, buffers_, [&](int, const CutSphere&) { changed = true; });
  // Where nothing was in the way but rounding, the proxy goes there by itself.
  if (!changed) return false;
  made_.add(made_.last() + 1, {from, to, tool_, removed.volume});
  cut = {made_.last(), in.tick, in.t, from, to, tool_, removed.volume, {}, in.spindle};
  for (std::size_t t = 1; t < energy_.size(); ++t) energy += removed.hardened[t] * energy_[t];
  proxy().move_to(to);
  contact.p_WG = held_ = to.p;
  return true;
}

void PackingModel::feel(const ContactInput&, Contact& out) noexcept {
  const auto contacts = proxy().contacts();
  const auto head = static_cast<int>(proxy().tool().head);
  out.turns_tool = turns_matter();
  double total = 0;
  for (const ProxyContact& c : contacts) {
    const bool own = c.tool_sphere < head;
    ++out.count;
    out.own += own;
    (own ? out.on_head : out.on_smooth) += c.push * c.n_W;
    total += c.push;
    if (!out.turns_tool) continue;
    out.lever += c.push * (c.p_W - out.p_WG);
    out.turn += c.push * glm::cross(c.p_W - out.p_WG, c.n_W);
  }
  if (total > 0) out.lever /= total;
  if (total > 0) {
    out.tissue = surface_.share;
    out.known_tissue = true;
    out.graded = snapshot_.spheres.graded();
    out.hardness = surface_.hardness;
  }
}

Tissue PackingModel::tissue_at(const dvec3& p_W) const noexcept {
  std::array<int, 64> near;
  const SphereTree& tree = snapshot_.spheres.tree();
  const std::size_t count = std::min(tree.near_segment(p_W, p_W, kNearby, near), near.size());
  Tissue tissue = Tissue::kAir;
  double nearest = kNearby;
  for (std::size_t k = 0; k < count; ++k) {
    const double off = glm::distance(p_W, tree.center(near[k])) - tree.radius(near[k]);
    if (off < nearest) nearest = off, tissue = snapshot_.spheres.tissue(near[k]);
  }
  return tissue;
}

}  // namespace typodont::haptics::packing
