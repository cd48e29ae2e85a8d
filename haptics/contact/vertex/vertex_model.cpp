#include "haptics/contact/vertex/vertex_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "haptics/contact/looks.h"
#include "haptics/contact/tool_check.h"
#include "haptics/contact/vertex/face_points.h"

namespace typodont::haptics::vertex {

using mesh::EditableMesh;
using mesh::Index;
using P = FeelParameters;

namespace {

constexpr std::size_t kMaxFaces = 1 << 17;  // upper limit of the number of faces near the head
/// Measured computing costs of listing points, in units of Effort (10 ns).
struct ListCosts {
  Effort face = 2;      // cost per face found, if the search is completed in one call
  Effort visit = 1;     // cost per visited cell or face of the grid, if the search is divided into parts
  Effort vertex = 2;    // cost per face whose vertices are listed
  Effort distance = 3;  // cost per computed distance between the head and a point
  Effort area = 3;      // cost per face whose area is divided among its points
  Effort part = 2;      // cost per additional point on a large face
};
constexpr ListCosts kListCosts;
// Effort of computing the contact, per listed point; in units of 5 ns (half the unit of other efforts).
constexpr Effort kContactEffort = 3;
// Effort of a distance that is computed, not extrapolated, in units of 10 ns.
constexpr Effort kFreshEffort = 2;
// clearance() searches in rounds: search distance of a round divided by that of the round before
constexpr double kNextShell = 4;

/// Number of parts into which each edge of a face is divided, so that no part is longer than CutParameters::longest.
/// (A cut splits longer edges.)
int parts_of_face(const EditableMesh& mesh, Index f, double edge) noexcept {
  // Quick test: a small bounding ball contains no long edge.
  const double longest = CutParameters::longest * edge;
  if (static_cast<double>(mesh.ball_radius(f)) * 2 <= longest) return 1;
  double longest2 = 0;
  for (int i = 0; i < 3; ++i) {
    const dvec3 direction = mesh.point(f, (i + 1) % 3) - mesh.point(f, i);
    longest2 = std::max(longest2, glm::dot(direction, direction));
  }
  return parts_of(std::sqrt(longest2), longest);
}

}  // namespace

VertexModel::VertexModel(const ServoSettings& settings, const Parameters& parameters)
    : settings_(settings), parameters_(parameters), distances_(kMaxSamples, P::reuse) {
  refuse_tools_that_fill(tool_set(settings), kName);
  for (const Tool& tool : tool_set(settings)) {
    heads_.emplace_back(tool);
    edges_.push_back(parameters.edge_for(tool));
  }
  near_.reserve(kMaxFaces);
  list_.samples.reserve(kMaxSamples);
  next_list_.samples.reserve(kMaxSamples);
}

void VertexModel::forget() noexcept {
  found_ = touching_ = eases_ = ahead_ = false;
  eased_ = dvec3(0);
}

void VertexModel::adopt(Snapshot& snapshot, PerTissue& removed) noexcept {
  auto& fresh = static_cast<VertexSnapshot&>(snapshot);
  // Repeats the servo's cuts that the new mesh lacks. After undo, a repeated cut may remove another volume than before.
  const bool first = snapshot_.number == 0;
  for (std::uint64_t i = made_.first_after(fresh.cuts); !first && i <= made_.last(); ++i) {
    MadeCut& made = made_[i];
    const CutDone done = make_cut(fresh.mesh, fresh.cutter, heads_[made.tool], edges_[made.tool],
                                  parameters_.as_printed, made.X_WA, made.X_WB);
    for (std::size_t t = 0; t < removed.size(); ++t) removed[t] += done.removed[t] - made.removed[t];
    made.removed = done.removed;
  }
  if (!first) {
    for (std::size_t t = 0; t < removed.size(); ++t) removed[t] -= fresh.taken_back[t] - snapshot_.taken_back[t];
  }
  std::swap(fresh, snapshot_);
  found_ = touching_ = ahead_ = false;
  part_.open = false;  // discards an unfinished cut, which exists only in the old mesh
}

/// Lists all points within `margin` (m) of a head in one call: vertices, and additional points on large faces
/// (parts_of_face()).
void VertexModel::gather(const VertexHead& head, double edge, const Pose& X, double margin) noexcept {
  part_.lists = false;
  ahead_ = near_changed_ = false;
  begin_list(head, edge, X, margin);
  Effort left = kNoLimit;
  list_points(list_, left);
  last_list_ = kNoLimit - left;
  listed_ += last_list_;
  distances_.forget();
}

void VertexModel::begin_list(const VertexHead& head, double edge, const Pose& X, double margin) noexcept {
  ++t_search_counts.vertices;
  const glm::dmat3 R_WT(glm::mat3_cast(X.R));
  const dvec3 half = head.half_box(R_WT[2]) + margin;
  listing_ = {Listing::Stage::kFaces, &head, edge, X, R_WT, margin, {X.p - half, X.p + half}, false, 0, 0};
}

/// Continues the list until it is complete or `left` is used up; subtracts its effort from `left`. Returns true if
/// complete. The result does not depend on the number of calls.
bool VertexModel::list_points(PointList& list, Effort& left) noexcept {
  Listing& now = listing_;
  while (left > 0 && now.stage != Listing::Stage::kDone) {
    if (now.stage == Listing::Stage::kFaces) {
      const bool divides = left < kNoLimit;
      if (!std::exchange(now.searches, true)) {
        list.points.clear(now.X);
        list.samples.clear();
        list.within = now.margin;
        proposed_.clear();
        near_.clear();
      }
      Effort visits = divides ? left / kListCosts.visit + 1 : kNoLimit;
      const Effort before = visits;
      const bool complete = list_near_faces(visits);
      left -= divides ? kListCosts.visit * (before - visits) : kListCosts.face * static_cast<Effort>(near_.size());
      if (!complete) return false;
      now.stage = Listing::Stage::kVertices;
    }
    const bool areas = now.stage == Listing::Stage::kAreas;
    for (; now.at < near_.size() && left > 0; ++now.at) {
      const std::size_t before = proposed_.size();
      if (areas) {
        list_area(list, near_[now.at]);
      } else {
        list_vertices(list, near_[now.at]);
      }
      const std::size_t after = proposed_.size();
      left -= areas ? kListCosts.area : kListCosts.vertex;
      left -= (kListCosts.distance + (areas ? kListCosts.part : 0)) *
              static_cast<Effort>(after > before ? after - before : 0);
    }
    if (now.at < near_.size()) return false;
    add_proposed(list);
    now.at = 0;
    if (areas) {
      now.stage = Listing::Stage::kDone;
    } else {
      now.vertices = list.samples.size();
      for (std::size_t i = 0; i < now.vertices; ++i) {
        snapshot_.sample_of[list.samples[i].v] = static_cast<std::uint32_t>(i);
      }
      now.stage = Listing::Stage::kAreas;
    }
  }
  return now.stage == Listing::Stage::kDone;
}

/// Continues the search for faces near the head until it is complete or `left` is used up. Returns true if complete.
bool VertexModel::list_near_faces(Effort& left) noexcept {
  const Listing& now = listing_;
  const EditableMesh& mesh = snapshot_.mesh;
  const VertexHead& head = *now.head;
  const glm::vec3 axis(now.R_WT[2]), c(now.X.p);
  const auto most = static_cast<float>(now.margin);
  return mesh.near_in_part(listing_.search, left, [&](Index f) {
    const bool is_near = head.may_be_within(mesh.ball_center(f) - c, axis, most + mesh.ball_radius(f));
    if (is_near && near_.size() < kMaxFaces) near_.push_back(f);
  });
}

/// Proposes a point for the list; it is added if it is within the list's margin of the head.
void VertexModel::propose(PointList& list, const dvec3& p_W, const Sample& sample) noexcept {
  const Listing& now = listing_;
  const VertexHead& head = *now.head;
  const dvec3 off = p_W - now.X.p;
  const double reach = head.reach() + now.margin;
  if (glm::dot(off, off) > reach * reach) return;
  if (head.is_ball()) {
    if (list.points.add(p_W)) list.samples.push_back(sample);
    return;
  }
  if (!head.may_be_within(glm::vec3(off), glm::vec3(now.R_WT[2]), static_cast<float>(now.margin))) return;
  if (proposed_.full()) add_proposed(list);
  proposals_[proposed_.size()] = {p_W, sample};
  proposed_.add(static_cast<std::uint32_t>(proposed_.size()), off);
}

void VertexModel::add_proposed(PointList& list) noexcept {
  proposed_.evaluate(*listing_.head, listing_.R_WT, listing_.margin);
  for (std::size_t i = 0; i < proposed_.size(); ++i) {
    const auto& [p, sample] = proposals_[proposed_.point(i)];
    if (list.points.add(p, proposed_.distance(i))) list.samples.push_back(sample);
  }
  proposed_.clear();
}

void VertexModel::list_vertices(PointList& list, Index f) noexcept {
  const EditableMesh& mesh = snapshot_.mesh;
  for (const Index v : mesh.face(f).v) {
    if (mesh.vertex(v).face != f) continue;  // lists each vertex only once, with one of its faces
    propose(list, mesh.vertex(v).p, {0, v, mesh.face(f).tissue});
  }
}

/// Distributes the area of a face over its points. A face whose edges a cut would split is divided into smaller
/// triangles (parts_of_face()), whose corners become additional points.
void VertexModel::list_area(PointList& list, Index f) noexcept {
  const EditableMesh& mesh = snapshot_.mesh;
  std::vector<Sample>& samples = list.samples;
  const int n = parts_of_face(mesh, f, listing_.edge);
  std::array<Sample*, 3> corners{};
  bool any = n > 1;
  for (std::size_t i = 0; i < 3; ++i) {
    const Index v = mesh.face(f).v[i];
    const std::size_t at = snapshot_.sample_of[v];
    if (at < listing_.vertices && samples[at].v == v) corners[i] = &samples[at], any = true;
  }
  if (!any) return;
  const double area = glm::length(normal2(mesh, f)) / (6.0 * n * n);
  for (Sample* corner : corners) {
    if (corner) corner->area += area;
  }
  if (n == 1) return;
  each_face_point(mesh.point(f, 0), mesh.point(f, 1), mesh.point(f, 2), n, [&](const dvec3& p, double count) {
    propose(list, p, {area * count, mesh::kNone, mesh.face(f).tissue});
  });
}

bool VertexModel::is_free(std::uint32_t tool, const Pose& X) noexcept {
  const VertexHead& head = heads_[tool];
  const double edge = edges_[tool];
  const EditableMesh& mesh = snapshot_.mesh;
  const dvec3 axis = X.R * dvec3(0, 0, 1), half = head.half_box(axis);
  bool free = true;
  mesh.near(X.p - half, X.p + half, [&](Index f) {
    if (!free || !head.may_be_within(mesh.ball_center(f) - glm::vec3(X.p), glm::vec3(axis), mesh.ball_radius(f)))
      return;
    free = is_outside(head, X, mesh.point(f, 0), mesh.point(f, 1), mesh.point(f, 2), parts_of_face(mesh, f, edge));
  });
  return free;
}

/// Largest displacement of any point of the head since the points were listed, m.
double VertexModel::moved_since_listing(const Pose& X) const noexcept {
  return displacement_bound(list_.points.listed_at(), X, head().is_ball() ? 0 : head().reach());
}

double VertexModel::complete_list_length() const noexcept {
  return FollowParameters::margin * head().radius() + P::probe * head().radius();
}

double VertexModel::short_list_length() const noexcept {
  const double probe = P::probe * head().radius();
  const double soon = std::max(probe, CutParameters::longest * edge()) + P::short_list * head().radius();
  return std::min(soon, complete_list_length());
}

/// Lists the points near the head at X, unless the list is still valid. While the head cuts, a short list is enough,
/// because each cut needs a new list; if the short list is empty, a complete list is made.
void VertexModel::list_where_needed(const Pose& X, bool cuts) noexcept {
  const double radius = head().radius();
  if (found_ && moved_since_listing(X) <= FollowParameters::kept * radius) return;
  const double complete = complete_list_length();
  gather(head(), edge(), X, cuts ? short_list_length() : complete);
  if (list_.points.empty() && list_.within < complete) gather(head(), edge(), X, complete);
  found_ = true;
}

/// If the list of points is short and lacks points within `far` (m) of the head at X, makes a complete list. The new
/// list is for the same pose of the head as the short list, so that the computed contact does not change.
void VertexModel::complete_list(const Pose& X, double far) noexcept {
  const double complete = (FollowParameters::margin + P::probe) * head().radius();
  if (list_.within >= complete || moved_since_listing(X) + far <= list_.within) return;
  gather(head(), edge(), Pose(list_.points.listed_at()), complete);
}

/// Distance (m) by which the head may still move until the list is no longer valid. `within`: distance from the head in
/// which the list contains all points. P::probe × radius: length of the trial motions with which contacts are tested.
double VertexModel::clearance_in_list(const Pose& X) const noexcept {
  return list_.within - moved_since_listing(X) - P::probe * head().radius();
}

/// Makes the next list of a moving head in parts, before the current list becomes invalid. Called while no cut is in
/// progress.
void VertexModel::list_ahead(const ContactInput& in, const Pose& proxy) noexcept {
  if (!found_ || list_.points.empty()) return;
  if (!ahead_) {
    const double complete = complete_list_length();
    const double valid = list_.within < complete ? P::short_list : FollowParameters::kept;
    if (moved_since_listing(proxy) < P::begin_next * valid * head().radius()) return;
    begin_list(head(), edge(), proxy, in.removal.cuts ? short_list_length() : complete);
    ahead_ = near_changed_ = true;
  }
  Effort left = effort_for_cut() - listed_;
  if (left <= 0 || !list_points(next_list_, left)) return;
  std::swap(list_, next_list_);
  distances_.forget();
  ahead_ = near_changed_ = false;
  found_ = !list_.points.empty();
}

double VertexModel::clearance(const Pose& X_WG) noexcept {
  if (touching_ && X_WG.p == touching_at_) return 0;
  if (eases_ && eased_ != dvec3(0)) return 0;  // the force of the last contact is still fading
  list_where_needed(X_WG, false);
  complete_list(X_WG, (FollowParameters::margin - FollowParameters::kept + P::probe) * head().radius());
  const double reach = head().reach();
  if (!list_.points.empty()) {
    const double listed = (FollowParameters::margin + P::probe) * head().radius() - moved_since_listing(X_WG);
    const double touches = P::touches * head().radius();
    const glm::dmat3 R_TW = glm::transpose(glm::dmat3(glm::mat3_cast(X_WG.R)));
    double clearance = listed;
    // Examines the listed points nearest to the head first, then points within larger and larger distances.
    for (double within = touches;; within = std::min(kNextShell * within, listed)) {
      for (const std::uint32_t i : list_.points.within(X_WG.p, reach + within)) {
        clearance = std::min(clearance, head().distance(R_TW * (list_.points[i] - X_WG.p)));
      }
      if (clearance < touches) return 0;
      if (clearance <= within || within >= listed) return clearance;
    }
  }
  // No listed point is near. The clearance may be larger than the distance up to which points are listed, so it is
  // computed from the faces' bounding balls.
  const EditableMesh& mesh = snapshot_.mesh;
  double clearance = P::search_distance;
  const dvec3 far(reach + P::search_distance);
  mesh.near(X_WG.p - far, X_WG.p + far, [&](Index f) {
    const double off = glm::distance(dvec3(mesh.ball_center(f)), X_WG.p) - static_cast<double>(mesh.ball_radius(f));
    clearance = std::min(clearance, off - reach);
  });
  return std::max(clearance, 0.0);
}

void VertexModel::take_up(std::uint32_t tool) noexcept {
  tool_ = tool;
  forget();
}

/// Moves the head on trial from X by P::probe × radius along `pull`; sums the springs of the vertices that it pushes
/// (paper S4, section 4.2). Except for balls, depths are extrapolated from X: a thin head could jump over a vertex.
VertexModel::Springs VertexModel::springs_at(const Pose& X, const dvec3& pull) noexcept {
  const double probe = P::probe * head().radius(), stiffness = settings_.stiffness / 1000;
  const bool is_ball = head().is_ball();
  Springs sum;
  const Pose at{is_ball ? X.p + probe * pull : X.p, X.R};
  if (is_ball) {
    distances_.find(head(), list_.points, at, 0, true);
  } else {
    distances_.find_pushed(head(), list_.points, at, probe * pull);
  }
  for (std::size_t i = 0; i < distances_.size(); ++i) {
    const double distance = distances_.distance(i);
    const dvec3 n = distances_.normal_W(i);
    const double ahead = is_ball ? std::max(0.0, glm::dot(n, pull)) : glm::dot(n, pull);
    // m, signed distance of the point after the head has moved by `probe` along `pull` (trial motion); negative: inside
    const double d = is_ball ? distance : distance - probe * ahead;
    if (!(d < 0) || !(is_ball || ahead > 0)) continue;
    const Sample& sample = list_.samples[distances_.point(i)];
    const auto tissue = static_cast<std::size_t>(sample.tissue);
    // m³, area of the point × its signed distance; negative: inside the head
    const double depth = sample.area * d;
    const dvec3 push = stiffness * settings_.materials[tissue].stiffness * depth * n;
    sum.force += push;
    // The forces on a ball all pass through its centre, so they give no torque.
    if (!is_ball) sum.torque += glm::cross(list_.points[distances_.point(i)] - X.p, push);
    sum.sum -= stiffness * settings_.materials[tissue].stiffness * depth;
    sum.weight -= depth;
    sum.area += sample.area;
    sum.across += sample.area * ahead;
    sum.tissue[tissue] -= depth;
    ++sum.count;
  }
  return sum;
}

/// Limits the change of a bur's force; otherwise the force would jump when contact ends while the hand is far from the
/// head. Change allowed per tick: P::ease × dt; in contact, additionally stiffness × the hand's motion.
dvec3 VertexModel::eased(const ContactInput& in, const dvec3& force) noexcept {
  eases_ = in.removal.cuts || (eases_ && eased_ != dvec3(0));
  const double moved = displacement_bound({in.X_WT.p - in.moved, last_R_}, in.X_WT, head().reach());
  last_R_ = in.X_WT.R;
  const double most = (force != dvec3(0) ? settings_.stiffness * moved : 0) + P::ease * in.dt;
  const dvec3 change = force - eased_;
  const double size = glm::length(change);
  eased_ = eases_ && size > most ? eased_ + most / size * change : force;
  return eased_;
}

/// Writes the springs' force and torque to `out`, with a damper along the force that cannot reverse the force (paper
/// S4, eq. 4.1, 4.4 and 4.5).
void VertexModel::give(const ContactInput& in, const dvec3& force, const dvec3& torque, Contact& out) noexcept {
  out.spring.whole = true;
  out.area = springs_.area;
  out.spring.force = force;
  out.spring.torque = torque;
  const double size = glm::length(force);
  out.spring.stored = size * out.spring.depth / 2;
  if (size > 0) {
    const double damped = std::max(0.0, size - settings_.damping * glm::dot(in.moved, force / size) / in.dt);
    out.spring.force *= damped / size;
    out.spring.torque *= damped / size;
  }
  if (!parameters_.as_printed) out.spring.force = eased(in, out.spring.force);
}

void VertexModel::constrain(const ContactInput& in, Contact& out) noexcept {
  springs_ = {};
  out.places = part_.open;
  if (parameters_.as_printed) return constrain_as_printed(in, out);
  // Without an allowed overlap, a bur could not leave or re-enter its own hole. A ball that does not cut needs no
  // overlap. While the tool cuts (in.removal.cuts), vertices inside the head do not push it out, but prevent a deeper
  // overlap.
  const bool exact = head().is_ball() && !tool_set(settings_)[tool_].cuts;
  const double allowed_depth = exact ? 0 : P::allowed_depth * head().radius();
  // During a cut, or while the next list of points is made, a cutting head moves only as far as the current list is
  // valid, because making a complete list would take too long.
  const bool keeps_list = in.removal.cuts && found_ && !list_.points.empty() && (part_.open || ahead_);
  const auto list = [&](const dvec3& p) {
    if (!keeps_list) list_where_needed({p, in.X_WT.R}, in.removal.cuts);
  };
  const auto complete = [&](const dvec3& p, double far) {
    const Pose X{p, in.X_WT.R};
    if (!keeps_list) {
      complete_list(X, far);
    } else if (const double clearance = clearance_in_list(X); clearance >= P::min_clearance * head().radius()) {
      return std::clamp(clearance, 0.0, far);
    } else {  // a fast rotation has made the list invalid
      gather(head(), edge(), X, complete_list_length());
    }
    return far;
  };
  listed_ = 0;
  distances_.count_anew();
  const auto may_go_on = [&] { return listed_ + last_list_ <= P::max_listed; };
  out.p_WG = follower_.follow(head(), list_.points, in.X_WG.p, in.X_WT, allowed_depth, in.removal.cuts, list, complete,
                              may_go_on);
  out.leading_out = (std::exchange(began_, false) || !in.removal.cuts) && !list_.points.empty() && follower_.led_out();
  const dvec3 pull = in.X_WT.p - out.p_WG;
  const double depth = glm::length(pull);
  constexpr double kNothing = 1e-10;  // m, a shorter vector counts as zero
  out.touching = depth > kNothing && !list_.points.empty() && follower_.bounded();
  out.settled = !out.touching && !part_.open;
  touching_ = out.touching, touching_at_ = out.p_WG;
  if (!out.touching) return come_free(in, out);
  out.spring.depth = depth;
  const dvec3 direction = pull / depth;
  if (!keeps_list) complete_list({out.p_WG, in.X_WT.R}, P::probe * head().radius());
  springs_ = springs_at({out.p_WG, in.X_WT.R}, direction);
  // Only the direction of the force and the stiffness come from the springs. The sum of their forces is too small: on
  // the steep sides of a cone, springs push in opposite directions.
  const double along = -glm::dot(springs_.force, direction);
  if (!(along > 0)) return give(in, dvec3(0), dvec3(0), out);
  const double stiffness = springs_.sum / springs_.weight, fraction = along / springs_.sum;
  dvec3 aside = fraction / along * (springs_.force + along * direction);
  if (const double size = glm::length(aside); size > P::max_aside) aside *= P::max_aside / size;
  give(in, stiffness * depth * (aside - direction), fraction * stiffness * depth / along * springs_.torque, out);
}

/// Without contact: reduces the bur's last force gradually to zero.
void VertexModel::come_free(const ContactInput& in, Contact& out) noexcept {
  if (parameters_.as_printed || eased_ == dvec3(0)) return;
  const dvec3 rest = eased(in, dvec3(0));
  const double size = glm::length(rest);
  if (!(size > 0)) return;
  out.touching = out.spring.whole = true;
  out.settled = false;
  out.spring.force = rest;
  out.spring.stored = size * size / (2 * settings_.stiffness);
}

/// Contact as in paper S4 (docs/papers.md): the head is at the hand's pose, and each vertex inside it pushes it back.
void VertexModel::constrain_as_printed(const ContactInput& in, Contact& out) noexcept {
  gather(head(), edge(), in.X_WT, 0);
  const dquat R_TW = glm::conjugate(in.X_WT.R);
  Springs sum;
  for (std::size_t i = 0; i < list_.samples.size(); ++i) {
    const Sample& sample = list_.samples[i];
    const dvec3 off_T = R_TW * (list_.points[i] - in.X_WT.p);
    if (sample.v == mesh::kNone || !(head().distance(off_T) < 0)) continue;
    // m, vector to the vertex from its target position, to which the method of paper S4 would move it
    const dvec3 direction = in.X_WT.R * (off_T - head().as_printed(off_T));
    const auto tissue = static_cast<std::size_t>(sample.tissue);
    const dvec3 push = settings_.stiffness * settings_.materials[tissue].stiffness / 1000 * direction;
    sum.force += push;
    sum.torque += glm::cross(in.X_WT.R * off_T, push);
    sum.area += sample.area;
    sum.tissue[tissue] += glm::length(direction);
    out.spring.depth = std::max(out.spring.depth, glm::length(direction));
    ++sum.count;
  }
  out.touching = sum.count > 0;
  out.settled = !out.touching;
  if (out.touching) {
    springs_ = sum;
    give(in, sum.force, sum.torque, out);
  }
}

bool VertexModel::cut(const ContactInput& in, Contact& contact, Cut& cut, double& energy) noexcept {
  const bool began = !part_.open;
  ++(began ? part_.rest : part_.ticks);
  if (began && !begin_cut(in, contact)) {
    if (!parameters_.as_printed) list_ahead(in, {contact.p_WG, in.X_WT.R});
    return false;
  }
  if (!work_on_cut(in, {contact.p_WG, in.X_WT.R})) return false;
  part_.open = false;
  const CutDone& done = part_.done;
  if (part_.scrapes) {
    met_ = std::clamp(met_ * (1 + P::met_weight * (total(done.removed) / part_.estimated - 1)), P::min_met, 1.0);
  }
  // With a shorter advance, the vertex that could not move may become able to move.
  stride_ = done.held && !done.changed ? std::max(0.5 * stride_, 2 * P::sweep / P::stride) : 1;
  if (!done.changed) return false;
  made_.add(made_.last() + 1, {part_.from, part_.to, part_.tool, done.removed});
  cut.X_WA = part_.from, cut.X_WB = part_.to;
  cut.tool = part_.tool;
  cut.removed = count_.counted(done.removed);
  for (std::size_t t = 1; t < done.removed.size(); ++t) {
    energy += done.removed[t] * settings_.materials[t].specific_energy;
  }
  energy = std::max(energy, 0.0);
  if (part_.lists ? part_.advances : !done.held && (began || is_ahead(contact.p_WG, in))) contact.p_WG = part_.to.p;
  return true;
}

/// Returns true if the cut ends nearer to the hand than `proxy`, the head's position. This is false if the hand
/// has moved the head away during a long cut.
bool VertexModel::is_ahead(const dvec3& proxy, const ContactInput& in) const noexcept {
  return glm::distance(part_.to.p, in.X_WT.p) < glm::distance(proxy, in.X_WT.p);
}

/// Computes how far the head can advance with the available energy, and begins the cut. Returns false if no cut can
/// begin.
bool VertexModel::begin_cut(const ContactInput& in, const Contact& contact) noexcept {
  if (!(in.removal.cuts && !in.removal.must_earn && contact.touching && springs_.count > 0)) return false;
  Pose from{contact.p_WG, in.X_WT.R}, to = in.X_WT;
  if (!parameters_.as_printed) {
    if (!(in.removal.budget > 0 && in.removal.specific_energy > 0 && springs_.across > 0)) return false;
    const dvec3 pull = in.X_WT.p - from.p;
    const double depth = glm::length(pull),
                 bought = in.removal.budget / in.removal.specific_energy / (springs_.across * met_);
    const double stride = stride_ * P::stride * edge(), direction = std::min({bought, depth, stride});
    if (!(direction >= (in.removal.scrapes ? P::scrape : P::sweep) * edge())) return false;
    // m; the nearer the advance of the next cut is to this, the fewer ticks it must wait (FeelParameters::rest).
    const double hurry = P::hurry * springs_.across / (head().radius() * head().radius()) * edge();
    if (part_.rest < part_.ticks * std::max(P::rest * (1 - direction / hurry), P::min_rest)) return false;
    to.p = from.p + direction / depth * pull;
  }
  part_ = {.open = true,
           .scrapes = in.removal.scrapes,
           .tool = tool_,
           .from = from,
           .to = to,
           .estimated = springs_.across * met_ * glm::distance(from.p, to.p),
           .ticks = 1};
  ahead_ = false;
  snapshot_.cutter.begin(head(), from, to, edge());
  return true;
}

/// Effort that a cut may use in this tick; the effort of lists of points made in this tick must still be subtracted.
Effort VertexModel::effort_for_cut() const noexcept {
  const Effort fresh = kFreshEffort * static_cast<Effort>(distances_.computed());
  const Effort contact = kContactEffort * static_cast<Effort>(list_.points.size()) / 2;
  return std::max(P::max_effort - contact - fresh, P::min_effort);
}

/// Continues the cut, then the new list of points near the head. `proxy`: current pose of the head. Returns true if
/// both are complete.
bool VertexModel::work_on_cut(const ContactInput& in, const Pose& proxy) noexcept {
  MeshCutter& cutter = snapshot_.cutter;
  if (parameters_.as_printed) {
    part_.done = cutter.cut_as_printed(snapshot_.mesh, heads_[part_.tool], part_.to);
    found_ = false;
    return true;
  }
  Effort left = effort_for_cut() - listed_;
  if (left <= 0) return false;  // the lists made in this tick have used up the effort
  if (!part_.finished) {
    if (!cutter.work(snapshot_.mesh, known_faces(), left)) return false;
    part_.done = cutter.done();
    part_.finished = true;
  }
  if (part_.tool != tool_) {
    found_ = false;
    return true;
  }
  if (!part_.done.changed) return true;
  if (left <= 0) return false;
  if (!std::exchange(part_.lists, true)) {
    near_changed_ = true;
    part_.advances = !part_.done.held && is_ahead(proxy.p, in);
    begin_list(head(), edge(), part_.advances ? part_.to : proxy, short_list_length());
  }
  if (!list_points(next_list_, left)) return false;
  std::swap(list_, next_list_);
  distances_.forget();
  near_changed_ = false;
  found_ = !list_.points.empty();
  return true;
}

void VertexModel::feel(const ContactInput&, Contact&, Felt& out) noexcept {
  double total = 0;
  for (std::size_t t = 1; t < springs_.tissue.size(); ++t) total += springs_.tissue[t];
  out.tissue = springs_.tissue;
  if (total > 0) out.average(total, false);
}

/// Tissue of the nearest face within two edge lengths that has the point on its inner side; otherwise air.
Tissue VertexModel::tissue_at(const dvec3& p_W) const noexcept {
  const double reach = 2 * edge();
  const EditableMesh& mesh = snapshot_.mesh;
  Tissue tissue = Tissue::kAir;
  double nearest = reach;
  mesh.near(p_W - reach, p_W + reach, [&](Index f) {
    const dvec3 n = normal2(mesh, f), off = p_W - dvec3(mesh.ball_center(f));
    const double length = glm::length(off);
    if (length < nearest && glm::dot(off, n) <= 0) nearest = length, tissue = mesh.face(f).tissue;
  });
  return tissue;
}

}  // namespace typodont::haptics::vertex
