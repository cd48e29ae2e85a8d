#include "haptics/contact/packing/sphere_proxy.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <utility>

#include "haptics/cutting/lanes.h"

namespace typodont::haptics::packing {

namespace {

// largest number of motions of the proxy that are tested per tick
constexpr int kSweeps = 24;
// If this many consecutive motions of the proxy bring no progress, as in a cavity with many contacts, follow() ends;
// the next tick continues.
constexpr int kStuck = 8;
// largest number of contacts of non-cutting parts that one cut adds as constraints
constexpr int kSlides = 6;
constexpr int kRounds = 60;         // largest number of iterations per projection
constexpr double kSettled = 1e-12;  // m; a smaller change of the result ends the iteration of a projection
// m; the proxy has arrived if its remaining motion is shorter
constexpr double kArrived = 1e-10;
// m, smallest margin (motion of a tool sphere for which its list of near spheres is valid), as mean of all lists
constexpr double kMargin = 60e-6;
// m, largest mean margin (motion for which a list is valid) of lists that are made only when they are needed
constexpr double kMaxMargin = 300e-6;
// margin of a near list (motion for which the list is valid) divided by the motion per tick
constexpr double kAhead = 3;
// m; an empty near list is valid for a motion up to the nearest tissue sphere, searched within this distance
constexpr double kMaxSearch = 2e-3;
// m, rounding error of a distance between spheres, added to limits
constexpr double kDistanceRounding = 1e-12;
// Fraction of the motion up to which contacts are searched: slightly past its end, to find contacts there.
constexpr double kPastTheEnd = 1.0000001;
constexpr std::size_t kListed = 64;        // smallest capacity of a near list, in spheres
constexpr std::size_t kAllListed = 16384;  // capacity of all near lists together, in spheres
// m; in a long list, listed_near() tests only stored gaps, no exact distances, if its argument `gap` is below this
constexpr double kFewOthers = 100e-6;
// number of tissue spheres from which a list of near spheres counts as long
constexpr std::size_t kLongList = 1024;
constexpr std::size_t kSphereLanes = 8;  // number of spheres that one vector instruction compares
// m, rounding error of a gap in single precision
constexpr float kFloatRounding = 1e-9f;
// m; if a list of near spheres would be valid only for a shorter motion, the tree is searched without a list
constexpr double kMinMargin = 1e-6;
constexpr double kReduced = 0.8;  // factor for the margin of a too long list
// m, largest mean margin (motion for which a list is valid) of lists made in advance
constexpr double kMaxPrepared = 0.5e-3;
constexpr double kTicksAhead = 10;  // for lists made in advance: margin divided by the motion per tick
// smallest number of tree leaves that are searched per tick for the lists made in advance
constexpr std::size_t kLeavesATick = 320;
// after a list of near spheres was too long: number of searches until a list is made again
constexpr int kNotAgain = 64;

/// Mean margin (motion for which a near list is valid) of lists made in advance, m. `travel`: m, motion in one tick.
double prepared_margin(double travel) {
  return std::clamp(kTicksAhead * travel, kMargin, kMaxPrepared);
}

}  // namespace

dvec3 SphereProxy::rotation_angle(const dquat& from, const dquat& to) noexcept {
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
      lists_(tool.size()),
      list_capacity_(
          std::max(kListed, kAllListed / std::max<std::size_t>(tool.size(), 1) / kSphereLanes * kSphereLanes)),
      listed_(list_capacity_ * tool.size()),
      gap_(list_capacity_ * tool.size()),
      moved_before_(tool.size()) {
  next_.places.resize(list_capacity_), next_.gaps.resize(list_capacity_);
  for (const dvec3& c : tool_.center_T) arm_.push_back(glm::length(c));
  unlisted_.reserve(tool.size());
}

SphereProxy::Motion SphereProxy::motion_to(const Pose& goal) const noexcept {
  const double half = std::abs(glm::dot(X_W_.R, goal.R));  // cosine of half the remaining angle
  return {goal, glm::distance(X_W_.p, goal.p) + kDistanceRounding,
          2 * std::sqrt(std::max(0.0, 1 - half * half) + 1e-15)};
}

void SphereProxy::place(const Pose& X_W) noexcept {
  move_to(X_W);
  count_ = 0, pushed_ = 0, sticks_ = false;
}

void SphereProxy::forget_near() noexcept {
  std::fill(lists_.begin(), lists_.end(), NearList{});
  next_.active = false;
}

void SphereProxy::move_to(const Pose& X_W) noexcept {
  const Motion motion = motion_to(X_W);
  for (std::size_t i = 0; i < tool_.size(); ++i) lists_[i].moved += motion.travel(arm_[i]);
  next_.moved += motion.travel(arm_[next_.tool_sphere]);
  X_W_ = X_W;
}

void SphereProxy::note_large(const SphereTree& tree, Place place, double protrudes) noexcept {
  const dvec3 center = tree.center(place);
  const double radius = tree.radius(place);
  if (!(radius > 0)) return;
  next_.moved += protrudes;
  for (std::size_t i = 0; i < tool_.size(); ++i) {
    NearList& list = lists_[i];
    if (glm::distance(X_W_ * tool_.center_T[i], center) < radius + tool_.radius[i] + list.margin - list.moved)
      list.protrudes = std::max(list.protrudes, protrudes);
  }
}

void SphereProxy::end_notes() noexcept {
  if (!std::exchange(noted_, false)) return;
  for (NearList& list : lists_) {
    list.moved += std::max(protrudes_, list.protrudes);
    list.protrudes = 0;
  }
  next_.moved += protrudes_;
  protrudes_ = 0;
}

/// Margin of the near list of tool sphere `i` (motion for which this list is valid), m. `margin`: mean margin of all
/// lists. The margins differ slightly, so that the lists do not all expire in the same tick.
double SphereProxy::spread_margin(std::size_t i, double margin) const noexcept {
  const double spread = 0.61803398875 * static_cast<double>(i);
  return margin * (0.75 + 0.5 * (spread - std::floor(spread))) + std::max(0.0, lists_[i].wider);
}

/// Begins a new near list of tool sphere `i` at `center`.
void SphereProxy::start_list(const SphereTree& tree, std::size_t i, const dvec3& center, double margin) noexcept {
  next_.tool_sphere = i, next_.active = true;
  next_.center = center, next_.margin = margin;
  next_.moved = 0, next_.count = next_.leaves = 0;
  next_.search = tree.start_search();
}

/// Continues the new list. Returns true if it is complete. Reduces its margin if the list is too long.
bool SphereProxy::continue_list(const SphereTree& tree, std::size_t leaves) noexcept {
  const double r = tool_.radius[next_.tool_sphere];
  for (std::size_t left = leaves; !next_.search.done() && left > 0;) {
    const std::size_t before = left;
    next_.count += tree.search_on(next_.search, next_.center, r + next_.margin, r + kDistanceRounding, left,
                                  std::span(next_.places).subspan(next_.count), &next_.gaps[next_.count]);
    next_.leaves += before - left;
    while (next_.count + SphereTree::kLeafSize > list_capacity_ && next_.margin > kMinMargin) {
      next_.margin *= kReduced;
      const auto most = static_cast<float>(next_.margin);
      std::size_t kept = 0;
      for (std::size_t k = 0; k < next_.count; ++k) {
        if (!(next_.gaps[k] < most)) continue;
        next_.places[kept] = next_.places[k];
        next_.gaps[kept++] = next_.gaps[k];
      }
      next_.count = kept;
    }
    if (!(next_.margin > kMinMargin)) return true;
  }
  if (next_.search.done()) next_.expected = next_.leaves;
  return next_.search.done();
}

/// Replaces the old list of near spheres by the new, complete one.
void SphereProxy::use_list() noexcept {
  const std::size_t i = next_.tool_sphere;
  NearList& list = lists_[i];
  const double wider = list.wider;
  list = {};
  list.wider = wider;
  next_.active = false;
  if (!(next_.margin > kMinMargin)) {
    list.refused = kNotAgain;
    return;
  }
  list.moved = next_.moved;
  list.margin = list.free = next_.margin - kDistanceRounding - static_cast<double>(kFloatRounding);
  list.count = next_.count;
  for (std::size_t k = 0; k < list.count; ++k) {
    list.free = std::min(list.free, static_cast<double>(next_.gaps[k] - kFloatRounding));
  }
  std::copy_n(next_.places.begin(), list.count, &listed_[i * list_capacity_]);
  std::copy_n(next_.gaps.begin(), list.count, &gap_[i * list_capacity_]);
  for (std::size_t k = list.count; k % kSphereLanes != 0; ++k) {
    listed_[i * list_capacity_ + k] = Place{};
    gap_[i * list_capacity_ + k] = std::numeric_limits<float>::infinity();
  }
}

/// Makes the list of tissue spheres near tool sphere `i` at `center` now. `travel`: motion for which it is valid, m.
void SphereProxy::list_near(const SphereTree& tree, std::size_t i, const dvec3& center, double travel) noexcept {
  const double needed = travel + std::max(0.0, lists_[i].wider) + kDistanceRounding;
  if (!next_.active || next_.tool_sphere != i || !(next_.moved + needed < next_.margin)) {
    const double margin =
        list_capacity_ < kLongList ? std::clamp(kAhead * travel, kMargin, kMaxMargin) : prepared_margin(travel);
    start_list(tree, i, center, spread_margin(i, margin));
  }
  continue_list(tree, std::numeric_limits<std::size_t>::max());
  use_list();
  NearList& list = lists_[i];
  if (list.count == 0 && list.refused == 0 && list_capacity_ < kLongList) {
    list.moved = 0;
    list.margin = list.free =
        tree.clearance(center, kMaxSearch + tool_.radius[i]) - tool_.radius[i] - kDistanceRounding;
  }
}

/// Makes the next lists of near spheres in advance, a part per tick. Begins a new list when the tool sphere has moved
/// by half the motion for which the old list is valid. For faster tools, lists are valid longer and parts are larger.
void SphereProxy::prepare_lists(const SphereTree& tree) noexcept {
  if (list_capacity_ < kLongList) return;
  if (!next_.active || !(next_.moved < next_.margin)) {
    next_.active = false;
    for (std::size_t i = 0; i < lists_.size() && !next_.active; ++i) {
      const NearList& list = lists_[i];
      const double lasts = list.margin - std::max(0.0, list.wider);
      const double margin = prepared_margin(list.moved - moved_before_[i]);
      if (!(list.moved < list.margin && list.moved > std::min(0.5 * lasts, margin))) continue;
      start_list(tree, i, X_W_ * tool_.center_T[i], spread_margin(i, margin));
    }
  }
  if (next_.active) {
    const NearList& list = lists_[next_.tool_sphere];
    const double travel = list.moved - moved_before_[next_.tool_sphere],
                 left = std::max(list.margin - std::max(0.0, list.wider) - list.moved, 1e-9);
    const std::size_t all = next_.expected > 0 ? next_.expected : tree.places() / SphereTree::kLeafSize;
    const double part = std::min(1.0, travel / left) * static_cast<double>(all);
    if (continue_list(tree, std::max(kLeavesATick, static_cast<std::size_t>(part)))) use_list();
  }
  for (std::size_t i = 0; i < lists_.size(); ++i) moved_before_[i] = lists_[i].moved;
}

template <class Limit, class Visit>
void SphereProxy::each_listed(std::size_t i, Limit&& limit, Visit&& visit) const noexcept {
  std::array<Place, SphereTree::kLeafSize> some;
  std::size_t count = 0;
  for (std::size_t k = i * list_capacity_; k < i * list_capacity_ + lists_[i].count; k += kSphereLanes) {
    const F8 most = F8{} + (static_cast<float>(limit()) + kFloatRounding);
    for (unsigned bits = bits_of(*reinterpret_cast<const F8*>(&gap_[k]) <= most); bits; bits &= bits - 1) {
      some[count++] = listed_[k + static_cast<std::size_t>(std::countr_zero(bits))];
      if (count == some.size()) visit(std::span<const Place>(some)), count = 0;
    }
  }
  if (count > 0) visit(std::span<const Place>(some).first(count));
}

/// First sphere of list `i` that tool sphere `i` touches before the fraction `until` of the motion. `certain`: receives
/// true if no sphere outside the list can be touched earlier.
SphereTree::Hit SphereProxy::first_listed(const SphereTree& tree, std::size_t i, const Motion& motion, double until,
                                          bool& certain) noexcept {
  NearList& list = lists_[i];
  const double bound = motion.travel(arm_[i]);
  certain = true;
  if (list.moved + until * bound < list.free) return {};
  const dvec3 from = X_W_ * tool_.center_T[i], m = motion.to * tool_.center_T[i] - from;
  if (list.moved >= list.margin && --list.refused < 0) list_near(tree, i, from, until * bound);
  SphereTree::Hit best;
  best.t = until;
  each_listed(
      i, [&] { return list.moved + best.t * bound; },
      [&](std::span<const Place> some) {
        const SphereTree::Hit hit = tree.first_of(some, from, tool_.radius[i], m);
        if (hit && (hit.t < best.t || (hit.t == best.t && best && hit.sphere < best.sphere))) best = hit;
      });
  certain = list.moved + best.t * bound < list.margin;
  return best ? best : SphereTree::Hit{};
}

/// First contact of the tool spheres from index `first_sphere` on, on the proxy's motion to the pose `goal`; of
/// simultaneous contacts, that with the lowest index. Tests the lists of near spheres first, which shortens the search
/// in the tree.
SphereProxy::FirstContact SphereProxy::first_contact(const SphereTree& tree, std::size_t first_sphere,
                                                     const Pose& goal) noexcept {
  const Motion motion = motion_to(goal);
  FirstContact first;
  double until = kPastTheEnd;
  unlisted_.clear();
  for (std::size_t i = first_sphere; i < tool_.size(); ++i) {
    bool certain;
    const SphereTree::Hit hit = first_listed(tree, i, motion, until, certain);
    if (hit) first = {hit.t, static_cast<int>(i), hit.sphere}, until = hit.t;
    if (!certain) unlisted_.push_back(i);
  }
  for (const std::size_t i : unlisted_) {
    if (lists_[i].moved + until * motion.travel(arm_[i]) < lists_[i].margin) continue;
    const dvec3 from = X_W_ * tool_.center_T[i];
    const SphereTree::Hit hit = tree.first_hit(from, tool_.radius[i], motion.to * tool_.center_T[i] - from);
    if (!(hit.t < until || (hit.t == until && static_cast<int>(i) <= first.ball))) continue;
    first = {hit.t, static_cast<int>(i), hit.sphere}, until = hit.t;
  }
  return first;
}

std::size_t SphereProxy::near_path(const SphereTree& tree, std::size_t i, const Pose& to,
                                   std::span<Place> found) const noexcept {
  const NearList& list = lists_[i];
  const Motion motion = motion_to(to);
  const double bound = motion.travel(arm_[i]), r = tool_.radius[i];
  const dvec3 a = X_W_ * tool_.center_T[i], b = to * tool_.center_T[i];
  if (!(list.moved + bound < list.margin)) return tree.near_segment(a, b, r, found);
  return listed_near(tree, i, list.moved + bound, a, b, r, found);
}

/// Lists the spheres of list `i` nearer than `reach` to the segment a–b, in the tree's order. Skips spheres whose
/// stored gap is above `gap`. In a long list, that is the only test, because nearly all remaining spheres are near.
std::size_t SphereProxy::listed_near(const SphereTree& tree, std::size_t i, double gap, const dvec3& a, const dvec3& b,
                                     double reach, std::span<Place> found) const noexcept {
  const bool all = lists_[i].count >= kLongList && gap < kFewOthers;
  std::size_t count = 0;
  const auto add = [&](Place place) {
    if (count < found.size()) found[count] = place;
    ++count;
  };
  each_listed(
      i, [&] { return gap; },
      [&](std::span<const Place> some) {
        if (all) {
          for (const Place place : some) add(place);
        } else {
          for (unsigned bits = tree.near_of(some, a, b, reach); bits; bits &= bits - 1) {
            add(some[static_cast<std::size_t>(std::countr_zero(bits))]);
          }
        }
      });
  return count;
}

std::size_t SphereProxy::near_here(const SphereTree& tree, std::size_t i, double epsilon,
                                   std::span<Place> found) noexcept {
  NearList& list = lists_[i];
  const dvec3 c = X_W_ * tool_.center_T[i];
  const double reach = tool_.radius[i] + epsilon;
  const auto too_short = [&] { return !(list.moved + epsilon + kDistanceRounding < list.margin); };
  if (too_short() && list.wider >= 0 && list.refused <= 0) {
    list.wider = epsilon;
    list_near(tree, i, c, 0);
    if (too_short()) list.wider = -1;
  }
  if (too_short()) return tree.near_segment(c, c, reach, found);
  return listed_near(tree, i, list.moved + epsilon + kDistanceRounding, c, c, reach, found);
}

/// Largest fraction 0..1 of the motion to `goal` that leaves the gap kGap to the sphere of the first contact.
double SphereProxy::reached(const SphereTree& tree, const Pose& goal, const FirstContact& first) const noexcept {
  if (first.ball < 0) return 1;
  const dvec3& center_T = tool_.center_T[static_cast<std::size_t>(first.ball)];
  const dvec3 from = X_W_ * center_T, m = goal * center_T - from, off = from + first.t * m - tree.center(first.sphere);
  // m, component of the motion to `goal` along the line from the tool sphere to the touched tissue sphere
  const double nearing = -glm::dot(m, off) / std::max(glm::length(off), 1e-300);
  return nearing > 0 ? std::max(0.0, first.t - kGap / nearing) : 0;
}

double SphereProxy::non_cutting_parts_allow(const SphereTree& tree, double longest_path, dvec3& move,
                                            dvec3& turn) noexcept {
  if (tool_.head == tool_.size()) return 1;
  for (int slide = 0;; ++slide) {
    dvec3 by, turned;
    project(move, turn, by, turned, tool_.head);
    const double angle = glm::length(turned), travel = glm::length(by) + tool_.head_reach * angle;
    const double fraction =
        std::min({1.0, longest_path / std::max(travel, 1e-300), kMaxTurn / std::max(angle, 1e-300)});
    const Pose goal{X_W_.p + fraction * by, glm::normalize(turned_by(fraction * turned) * X_W_.R)};
    const FirstContact first = first_contact(tree, tool_.head, goal);
    const double part = fraction * reached(tree, goal, first);
    if (first.ball < 0 || part * travel > kGap || slide == kSlides) {
      move = by, turn = turned;
      return first.ball < 0 ? 1 : part;
    }
    // Adds the contact as a constraint; the loop then computes the motion again. If it was one before, rotation has
    // curved the path so that it crosses the constraint's plane; then the constraint's gap is reduced.
    const auto ball = static_cast<std::size_t>(first.ball);
    const std::size_t listed = contact_of(first.ball, first.sphere);
    const dvec3 moved = goal * tool_.center_T[ball] - X_W_ * tool_.center_T[ball];
    const double gap = listed < count_
                           ? std::min(0.0, constraints_[listed].gap + glm::dot(contacts_[listed].n_W, moved) / fraction)
                           : 0;
    add_contact(tree, first.ball, first.sphere);
    constraints_[contact_of(first.ball, first.sphere)].gap = gap;
  }
}

/// Projects the motion (`move`, `turn`) onto the constraints of the tool spheres from index `first_sphere` on: finds
/// the allowed (δ, φ) with the least |δ - move|² + lever_² |φ - turn|², where lever_ converts rotations to lengths.
void SphereProxy::project(const dvec3& move, const dvec3& turn, dvec3& allowed_move, dvec3& allowed_turn,
                          std::size_t first_sphere) noexcept {
  allowed_move = move, allowed_turn = turn;
  struct Step {
    Constraint* constraint;
    dvec3 turned;   // rad/m, rotation of the proxy per metre of push (Lagrange multiplier)
    double yields;  // increase of the gap in m per metre of push
  };
  std::array<Step, kMaxContacts> steps;
  std::size_t count = 0;
  for (std::size_t k = 0; k < count_; ++k) {
    Constraint& c = constraints_[k];
    if (contacts_[k].tool_sphere < static_cast<int>(first_sphere)) {
      c.multiplier = 0;
      continue;
    }
    const dvec3 turned = c.turn / (lever_ * lever_);
    // The pushes (multipliers) of the last projection are the first guess.
    if (c.multiplier > 0) {
      allowed_move += c.multiplier * c.n;
      allowed_turn += c.multiplier * turned;
    }
    steps[count++] = {&c, turned, 1 + glm::dot(c.turn, turned)};
  }
  const bool turns = tool_.turns_matter();
  for (int round = 0; round < kRounds; ++round) {
    double changed = 0;
    for (std::size_t k = 0; k < count; ++k) {
      Constraint& c = *steps[k].constraint;
      double gap = c.gap + glm::dot(c.n, allowed_move);
      if (turns) gap += glm::dot(c.turn, allowed_turn);
      const double before = c.multiplier;
      // A constraint without push whose gap is open changes nothing; skipping it saves time.
      if (before == 0 && gap >= 0) continue;
      c.multiplier = std::max(0.0, before - (turns ? gap / steps[k].yields : gap));
      const double by = c.multiplier - before;
      allowed_move += by * c.n;
      if (turns) allowed_turn += by * steps[k].turned;
      changed = std::max(changed, std::abs(by));
    }
    if (changed < kSettled) break;
  }
}

/// Index in contacts_ of the contact between these two spheres; count_ if there is none.
std::size_t SphereProxy::contact_of(int tool_sphere, int sphere) const noexcept {
  std::size_t at = 0;
  while (at < count_ && !(contacts_[at].tool_sphere == tool_sphere && contacts_[at].sphere == sphere)) ++at;
  return at;
}

void SphereProxy::add_contact(const SphereTree& tree, int tool_sphere, int sphere) noexcept {
  std::size_t at = contact_of(tool_sphere, sphere);
  if (at == kMaxContacts) {  // if full, replaces the contact with the smallest push
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
  const bool known = contact.sphere == sphere && contact.tool_sphere == tool_sphere;
  contact.sphere = sphere, contact.tool_sphere = tool_sphere, contact.push = 0;
  constraints_[at] = {contact.n_W, glm::cross(center - X_W_.p, contact.n_W), 0,
                      known ? constraints_[at].multiplier : 0};
}

void SphereProxy::follow(const SphereTree& tree, const Pose& X_WH) noexcept {
  // Keeps the contacts whose spheres still touch.
  const std::size_t before = count_;
  count_ = 0;
  for (std::size_t k = 0; k < before; ++k) {
    const ProxyContact old = contacts_[k];
    const double r = tree.radius(old.sphere);
    const dvec3 center = X_W_ * tool_.center_T[static_cast<std::size_t>(old.tool_sphere)];
    const double gap =
        glm::distance(center, tree.center(old.sphere)) - r - tool_.radius[static_cast<std::size_t>(old.tool_sphere)];
    if (!(r > 0 && gap < 2 * kGap)) continue;
    const double multiplier = constraints_[k].multiplier;
    add_contact(tree, old.tool_sphere, old.sphere);
    constraints_[count_ - 1].multiplier = multiplier;
  }

  bool slid = false, arrived = false;
  double path_left = options_.longest_path;
  for (int sweep = 0, stuck = 0; sweep < kSweeps && stuck < kStuck; ++sweep) {
    const dvec3 move = X_WH.p - X_W_.p;
    const dvec3 turn = rotation_angle(X_W_.R, X_WH.R);
    dvec3 by, turned;
    project(move, turn, by, turned);

    // Coulomb friction (S2, eq. 10–13): the pushes of the contacts limit sliding.
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

    // Limits the proxy's motion: rotation at most kMaxTurn, path at most the rest of this tick's path.
    const double angle = glm::length(turned), travel = glm::length(by) + tool_.reach * angle;
    const double fraction = std::min({1.0, kMaxTurn / std::max(angle, 1e-300), path_left / std::max(travel, 1e-300)});
    by *= fraction, turned *= fraction;
    arrived = glm::length(by) + lever_ * glm::length(turned) < kArrived;
    if (arrived) break;
    const Pose goal{X_W_.p + by, glm::normalize(turned_by(turned) * X_W_.R)};
    const FirstContact first = first_contact(tree, 0, goal);
    const double part = reached(tree, goal, first);
    stuck = part > 0 ? 0 : stuck + 1;
    if (part >= 1) {
      move_to(goal);
    } else if (part > 0) {
      move_to({X_W_.p + part * by, glm::normalize(turned_by(part * turned) * X_W_.R)});
    }
    for (std::size_t k = 0; k < count_; ++k) {
      Constraint& c = constraints_[k];
      c.gap = std::max(0.0, c.gap + part * (glm::dot(c.n, by) + glm::dot(c.turn, turned)));
    }
    path_left -= part * fraction * travel;
    slid = slid || (normal > 0 && part * glm::length(by) > kArrived);
    if (first.ball >= 0) {
      add_contact(tree, first.ball, first.sphere);
    } else if (fraction >= 1) {
      break;
    }
  }

  // Computes the pushes of the contacts at the new position. If the proxy has not moved since the last projection, the
  // pushes of that projection are valid.
  if (!arrived) {
    dvec3 by, turned;
    project(X_WH.p - X_W_.p, rotation_angle(X_W_.R, X_WH.R), by, turned);
  }
  pushed_ = 0;
  for (std::size_t k = 0; k < count_; ++k) {
    contacts_[k].push = constraints_[k].multiplier;
    pushed_ += contacts_[k].push;
  }
  sticks_ = pushed_ > 0 && !slid;
  prepare_lists(tree);
}

dvec3 SphereProxy::contact_point() const noexcept {
  dvec3 p(0);
  for (std::size_t k = 0; k < count_; ++k) p += contacts_[k].push / std::max(pushed_, 1e-300) * contacts_[k].p_W;
  return p;
}

}  // namespace typodont::haptics::packing
