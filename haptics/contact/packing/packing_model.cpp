#include "haptics/contact/packing/packing_model.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "engine/base/error.h"

namespace typodont::haptics::packing {

namespace {

constexpr double kLook = 10e-3;     // m, how far a free tool looks around itself
constexpr double kNearby = 0.2e-3;  // m, within which a point belongs to the nearest sphere

/// The servo's own coupling, damper and friction follow.
constexpr ProxyOptions kFrictionless{.stiffness = 0, .damping = 0, .static_friction = 0, .dynamic_friction = 0};

}  // namespace

PackingModel::PackingModel(const ServoSettings& settings, const Parameters& parameters)
    : settings_(settings), parameters_(parameters), buffers_(parameters.spheres), made_(kRemembered) {
  for (const Tool& tool : tool_set(settings)) {
    if (tool.fill != Tissue::kAir) {
      throw Error(tool.name, "model", "packing with a tool that fills", "the model offset, or another tool");
    }
    proxies_.emplace_back(tool_spheres(tool, parameters.tool_spheres, parameters.seed), kFrictionless);
  }
}

double PackingModel::travel() const noexcept {
  return std::numeric_limits<double>::infinity();
}

void PackingModel::adopt(Snapshot& snapshot, PerTissue& removed) noexcept {
  auto& fresh = static_cast<PackingSnapshot&>(snapshot);
  // The fresh spheres lack the cuts made since. After an undo these may take more or less than they did.
  const std::uint64_t oldest = cuts_ > kRemembered ? cuts_ - kRemembered : 0;
  const bool first = snapshot_.number == 0;
  for (std::uint64_t i = std::max(fresh.cuts, oldest) + 1; !first && i <= cuts_; ++i) {
    Made& made = made_[i % kRemembered];
    const PerTissue now =
        carve(fresh.spheres, proxies_[made.tool].tool(), made.X_WA, made.X_WB, buffers_, [](int, const CutSphere&) {});
    for (std::size_t t = 0; t < now.size(); ++t) removed[t] += now[t] - made.removed[t];
    made.removed = now;
  }
  if (!first) {
    for (std::size_t t = 0; t < removed.size(); ++t) removed[t] -= fresh.taken_back[t] - snapshot_.taken_back[t];
  }
  std::swap(fresh, snapshot_);
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
  surface_ = {};
  if (snapshot_.number == 0) {
    out.p_WG = in.X_WT.p;
    out.lost = true;
    out.faults |= bits(Fault::kPatchEdge);
    return;
  }
  // The servo moves a free tool without asking.
  if (!placed_ || in.X_WG.p != held_) proxy().place(in.X_WG);
  placed_ = true;
  proxy().follow(snapshot_.spheres.tree(), in.X_WT);
  out.p_WG = held_ = proxy().pose().p;
  out.touching = proxy().touches();
  out.settled = !out.touching;
  if (!out.touching) return;
  out.held_off_direction = out.p_WG - in.X_WT.p;
  surface_ = estimate_surface(snapshot_.spheres, proxy().tool(), proxy().pose(), proxy().contact_point(),
                              parameters_.epsilon, parameters_.density, buffers_.changed);
  out.area = surface_.volume / parameters_.epsilon;
}

bool PackingModel::cut(const ContactInput& in, Contact& contact, Cut& cut, double& energy) noexcept {
  if (!(in.cuts && !in.must_earn && contact.touching)) return false;
  const Pose from = proxy().pose();
  const dvec3 way = in.X_WT.p - from.p;
  const double left = glm::length(way);
  if (!(left > 0)) return false;
  const double density = parameters_.by_contact ? surface_.density : surface_.normalised;
  const double step = cutting_step(cutting_speed(parameters_.base_speed, density, parameters_.free_speed), in.dt, left);
  const Pose to{from.p + step / left * way, from.R};
  bool changed = false;
  const PerTissue removed =
      carve(snapshot_.spheres, proxy().tool(), from, to, buffers_, [&](int, const CutSphere&) { changed = true; });
  if (!changed) return false;
  cut = {++cuts_, in.tick, in.t, from, to, tool_, removed, {}, in.spindle};
  made_[cuts_ % kRemembered] = {from, to, tool_, removed};
  for (std::size_t t = 1; t < removed.size(); ++t) energy += removed[t] * settings_.materials[t].specific_energy;
  proxy().move_to(to);
  contact.p_WG = held_ = to.p;
  return true;
}

void PackingModel::feel(const ContactInput&, Contact& out) noexcept {
  const auto contacts = proxy().contacts();
  out.turns_tool = turns_matter();
  out.count = out.own = static_cast<int>(contacts.size());
  double total = 0;
  for (const ProxyContact& c : contacts) {
    total += c.push;
    out.on_head += c.push * c.n_W;
    if (!out.turns_tool) continue;
    out.lever += c.push * (c.p_W - out.p_WG);
    out.turn += c.push * glm::cross(c.p_W - out.p_WG, c.n_W);
  }
  if (total > 0) out.lever /= total;
  if (surface_.volume > 0) {
    out.tissue = surface_.share;
    out.known_tissue = true;
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
