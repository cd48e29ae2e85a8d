#include "haptics/contact/packing/sphere_proxy.h"

#include <algorithm>
#include <cmath>

#include "haptics/contact/packing/compute_passes.h"

namespace typodont::haptics::packing {

namespace {

constexpr int kSweeps = 24;            // a tick; what is left of the way then waits for the next
constexpr int kStuck = 8;              // sweeps on end without progress that end a tick: in a bed of many spheres
constexpr int kRounds = 60;            // of the projection
constexpr double kSettled = 1e-12;     // m, of the projection
constexpr double kArrived = 1e-10;     // m
constexpr double kLargestTurn = 0.02;  // rad at once: a chord then leaves its arc by 5e-5 of the reach
constexpr double kLook = 2e-3;         // m, how far a sphere of the tool looks around itself
constexpr double kNear = 20e-6;        // m of room below which it is not looked for again …
constexpr int kNotAgain = 8;           // … for so many sweeps
constexpr double kKept = 0.999;        // of the room found: more than rounding takes

}  // namespace

dvec3 SphereProxy::turn_between(const dquat& from, const dquat& to) noexcept {
  const dquat q = to * glm::conjugate(from);
  const dvec3 v(q.x, q.y, q.z);
  const double s = glm::length(v);
  if (s < 1e-15) return dvec3(0);
  return v * (2 * std::atan2(s, std::abs(q.w)) / s * (q.w < 0 ? -1 : 1));
}

dquat SphereProxy::turned_by(const dvec3& v) noexcept {
  const double angle = glm::length(v);
  if (angle < 1e-15) return {1, 0, 0, 0};
  const dvec3 s = v * (std::sin(0.5 * angle) / angle);
  return {std::cos(0.5 * angle), s.x, s.y, s.z};
}

SphereProxy::SphereProxy(const ToolSpheres& tool, const ProxyOptions& options)
    : tool_(tool),
      options_(options),
      lever_(std::max(tool.reach, 1e-6)),
      free_(tool.size(), 0.0),
      ask_next_(tool.size(), 0) {
  swept_.reserve(tool.size()), asked_.reserve(tool.size());
}

void SphereProxy::place(const Pose& X_W) noexcept {
  X_W_ = X_WH_ = X_W;
  count_ = 0, pushed_ = 0, n_W_ = dvec3(0), sticks_ = false;
  forget_free();
}

void SphereProxy::forget_free() noexcept {
  std::fill(free_.begin(), free_.end(), 0.0);
  std::fill(ask_next_.begin(), ask_next_.end(), 0);
}

void SphereProxy::move_to(const Pose& X_W) noexcept {
  for (std::size_t i = 0; i < tool_.size(); ++i) {
    if (free_[i] > 0) free_[i] -= glm::distance(X_W_ * tool_.center_T[i], X_W * tool_.center_T[i]);
  }
  X_W_ = X_W;
}

/// What a sphere of the tool first touches on its way; most spheres are known to be free for longer than that.
SphereTree::Hit SphereProxy::first_hit(const SphereTree& tree, std::size_t i, const dvec3& from,
                                       const dvec3& m) noexcept {
  const double way2 = glm::dot(m, m);
  if (free_[i] > 0 && way2 < free_[i] * free_[i]) return {};
  if (ask_next_[i]-- <= 0) {
    free_[i] = kKept * (tree.room(from, kLook + tool_.radius[i]) - tool_.radius[i]);
    ask_next_[i] = free_[i] < kNear ? kNotAgain : 0;
    if (free_[i] > 0 && way2 < free_[i] * free_[i]) return {};
  }
  return tree.first_hit(from, tool_.radius[i], m);
}

/// What the tool first touches on its way to `goal`.
FirstContact SphereProxy::first_contact(const SphereTree& tree, const Pose& goal, ComputePasses* gpu) noexcept {
  FirstContact first;
  if (gpu && gpu->ready()) {
    swept_.clear(), asked_.clear();
    for (std::size_t i = 0; i < tool_.size(); ++i) {
      const dvec3 from = X_W_ * tool_.center_T[i], m = goal * tool_.center_T[i] - from;
      if (free_[i] > 0 && glm::dot(m, m) < free_[i] * free_[i]) continue;
      swept_.push_back({from, m, tool_.radius[i]});
      asked_.push_back(i);
    }
    if (gpu->first_contact(swept_, first)) {
      if (first.ball >= 0) first.ball = static_cast<int>(asked_[static_cast<std::size_t>(first.ball)]);
      return first;
    }
  }
  for (std::size_t i = 0; i < tool_.size(); ++i) {
    const dvec3 from = X_W_ * tool_.center_T[i], m = goal * tool_.center_T[i] - from;
    const SphereTree::Hit hit = first_hit(tree, i, from, m);
    if (hit && hit.t < first.t) first = {hit.t, static_cast<int>(i), hit.sphere};
  }
  return first;
}

double SphereProxy::smooth_parts_allow(const SphereTree& tree, dvec3& move, dvec3& turn) noexcept {
  if (tool_.head == tool_.size()) return 1;
  dvec3 by, turned;
  project(move, turn, by, turned, tool_.head);
  move = by, turn = turned;
  const Pose goal{X_W_.p + by, glm::normalize(turned_by(turned) * X_W_.R)};
  double first = 1;
  for (std::size_t i = tool_.head; i < tool_.size(); ++i) {
    const dvec3 from = X_W_ * tool_.center_T[i], m = goal * tool_.center_T[i] - from;
    if (const SphereTree::Hit hit = first_hit(tree, i, from, m); hit && hit.t < first) {
      const dvec3 off = from + hit.t * m - tree.center(hit.sphere);
      const double nearing = -glm::dot(m, off) / std::max(glm::length(off), 1e-300);  // m per whole way
      first = nearing > 0 ? std::max(0.0, hit.t - kGap / nearing) : 0;
    }
  }
  return first;
}

/// The motion nearest to the wanted one that no constraint of the tool's spheres from `first_sphere` on forbids:
/// min |δ - move|² + |lever (φ - turn)|².
void SphereProxy::project(const dvec3& move, const dvec3& turn, dvec3& allowed_move, dvec3& allowed_turn,
                          std::size_t first_sphere) noexcept {
  allowed_move = move, allowed_turn = turn;
  for (std::size_t k = 0; k < count_; ++k) constraints_[k].multiplier = 0;
  for (int round = 0; round < kRounds; ++round) {
    double changed = 0;
    for (std::size_t k = 0; k < count_; ++k) {
      if (contacts_[k].tool_sphere < static_cast<int>(first_sphere)) continue;
      Constraint& c = constraints_[k];
      const dvec3 turned = c.turn / (lever_ * lever_);
      const double gap = c.gap + glm::dot(c.n, allowed_move) + glm::dot(c.turn, allowed_turn);
      const double before = c.multiplier;
      c.multiplier = std::max(0.0, before - gap / (1 + glm::dot(c.turn, turned)));
      const double by = c.multiplier - before;
      allowed_move += by * c.n;
      allowed_turn += by * turned;
      changed = std::max(changed, std::abs(by));
    }
    if (changed < kSettled) break;
  }
}

void SphereProxy::add_contact(const SphereTree& tree, int tool_sphere, int sphere) noexcept {
  std::size_t at = count_;
  for (std::size_t k = 0; k < count_; ++k) {
    if (contacts_[k].tool_sphere == tool_sphere && contacts_[k].sphere == sphere) at = k;
  }
  if (at == kMostContacts) {  // the one that holds least makes room
    at = 0;
    for (std::size_t k = 1; k < count_; ++k) {
      if (constraints_[k].multiplier < constraints_[at].multiplier) at = k;
    }
  } else if (at == count_) {
    ++count_;
  }
  const dvec3 center = X_W_ * tool_.center_T[static_cast<std::size_t>(tool_sphere)];
  const dvec3 off = center - tree.center(sphere);
  const double distance = glm::length(off);
  ProxyContact& contact = contacts_[at];
  contact.n_W = distance > 0 ? off / distance : dvec3(0, 0, 1);
  contact.p_W = center - tool_.radius[static_cast<std::size_t>(tool_sphere)] * contact.n_W;
  contact.sphere = sphere, contact.tool_sphere = tool_sphere, contact.push = 0;
  constraints_[at] = {contact.n_W, glm::cross(center - X_W_.p, contact.n_W), 0, 0};
}

void SphereProxy::follow(const SphereTree& tree, const Pose& X_WH, ComputePasses* gpu) noexcept {
  X_WH_ = X_WH;

  // What was touched in the last tick and still is.
  const std::size_t before = count_;
  count_ = 0;
  for (std::size_t k = 0; k < before; ++k) {
    const ProxyContact old = contacts_[k];
    const double r = tree.radius(old.sphere);
    const dvec3 center = X_W_ * tool_.center_T[static_cast<std::size_t>(old.tool_sphere)];
    const double gap =
        glm::distance(center, tree.center(old.sphere)) - r - tool_.radius[static_cast<std::size_t>(old.tool_sphere)];
    if (r > 0 && gap < 2 * kGap) add_contact(tree, old.tool_sphere, old.sphere);
  }

  bool slid = false;
  for (int sweep = 0, stuck = 0; sweep < kSweeps && stuck < kStuck; ++sweep) {
    const dvec3 move = X_WH.p - X_W_.p;
    const dvec3 turn = turn_between(X_W_.R, X_WH.R);
    dvec3 by, turned;
    project(move, turn, by, turned);

    // Coulomb friction (eq. 10–13): what holds the proxy back along the normal decides how far it may slide.
    dvec3 pushed(0);
    for (std::size_t k = 0; k < count_; ++k) pushed += constraints_[k].multiplier * constraints_[k].n;
    const double normal = glm::length(pushed);
    if (normal > 0) {
      const dvec3 n = pushed / normal, along = move - glm::dot(move, n) * n;
      const double held = std::max(0.0, -glm::dot(move, n)), tangential = glm::length(along);
      const double limit = (sticks_ && !slid ? options_.static_friction : options_.dynamic_friction) * held;
      if (tangential <= limit) {
        by = dvec3(0);
      } else {
        by *= 1 - options_.dynamic_friction * held / tangential;
      }
    }

    // One part of the way, swept.
    const double angle = glm::length(turned), share = std::min(1.0, kLargestTurn / std::max(angle, 1e-300));
    by *= share, turned *= share;
    if (glm::length(by) + lever_ * glm::length(turned) < kArrived) break;
    const Pose goal{X_W_.p + by, glm::normalize(turned_by(turned) * X_W_.R)};
    const FirstContact first = first_contact(tree, goal, gpu);
    const int tool_sphere = first.ball, sphere = first.sphere;
    double back = 0;
    if (tool_sphere >= 0) {
      const dvec3& center_T = tool_.center_T[static_cast<std::size_t>(tool_sphere)];
      const dvec3 from = X_W_ * center_T, m = goal * center_T - from, off = from + first.t * m - tree.center(sphere);
      const double nearing = -glm::dot(m, off) / std::max(glm::length(off), 1e-300);  // m per whole way
      back = nearing > 0 ? kGap / nearing : 1;
    }
    const double reached = tool_sphere < 0 ? 1 : std::max(0.0, first.t - back);
    stuck = reached > 0 ? 0 : stuck + 1;
    if (reached >= 1) {
      move_to(goal);
    } else if (reached > 0) {
      move_to({X_W_.p + reached * by, glm::normalize(turned_by(reached * turned) * X_W_.R)});
    }
    for (std::size_t k = 0; k < count_; ++k) {
      Constraint& c = constraints_[k];
      c.gap = std::max(0.0, c.gap + reached * (glm::dot(c.n, by) + glm::dot(c.turn, turned)));
    }
    slid = slid || (normal > 0 && reached * glm::length(by) > kArrived);
    if (tool_sphere >= 0) {
      add_contact(tree, tool_sphere, sphere);
    } else if (share >= 1) {
      break;
    }
  }

  // What holds the proxy where it is now.
  dvec3 by, turned;
  project(X_WH.p - X_W_.p, turn_between(X_W_.R, X_WH.R), by, turned);
  pushed_ = 0, n_W_ = dvec3(0);
  for (std::size_t k = 0; k < count_; ++k) {
    contacts_[k].push = constraints_[k].multiplier;
    pushed_ += contacts_[k].push;
    n_W_ += contacts_[k].push * contacts_[k].n_W;
  }
  if (const double length = glm::length(n_W_); length > 0) n_W_ /= length;
  sticks_ = pushed_ > 0 && !slid;
}

dvec3 SphereProxy::force(const dvec3& v_WH) const noexcept {
  if (!touches()) return dvec3(0);
  return options_.stiffness * (X_W_.p - X_WH_.p) - options_.damping * v_WH;
}

dvec3 SphereProxy::contact_point() const noexcept {
  dvec3 p(0);
  for (std::size_t k = 0; k < count_; ++k) p += contacts_[k].push / std::max(pushed_, 1e-300) * contacts_[k].p_W;
  return p;
}

dvec3 SphereProxy::torque(const dvec3& force) const noexcept {
  if (!touches()) return dvec3(0);
  return glm::cross(contact_point() - com(), force);
}

}  // namespace typodont::haptics::packing
