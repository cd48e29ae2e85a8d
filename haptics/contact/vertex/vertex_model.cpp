#include "haptics/contact/vertex/vertex_model.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "haptics/contact/tool_check.h"

namespace typodont::haptics::vertex {

using mesh::EditableMesh;
using mesh::Index;
using P = FeelParameters;

namespace {

constexpr std::size_t kMostFaces = 1 << 17;  // near the head
constexpr int kMostParts = 64;               // into which the edge of a face is divided

/// Twice the area times the normal.
dvec3 normal2(const EditableMesh& mesh, Index f) noexcept {
  return glm::cross(mesh.point(f, 1) - mesh.point(f, 0), mesh.point(f, 2) - mesh.point(f, 0));
}

/// Into how many parts the edges of a face are divided, so that none is longer than an edge that would be split.
int parts_of(const EditableMesh& mesh, Index f, double edge) noexcept {
  // The ball around a face tells a small one at once.
  const double longest = CutParameters::longest * edge;
  if (static_cast<double>(mesh.ball_radius(f)) * 2 <= longest) return 1;
  double longest2 = 0;
  for (int i = 0; i < 3; ++i) {
    const dvec3 way = mesh.point(f, (i + 1) % 3) - mesh.point(f, i);
    longest2 = std::max(longest2, glm::dot(way, way));
  }
  return std::clamp(static_cast<int>(std::ceil(std::sqrt(longest2) / longest * (1 - 1e-9))), 1, kMostParts);
}

}  // namespace

VertexModel::VertexModel(const ServoSettings& settings, const Parameters& parameters)
    : settings_(settings), parameters_(parameters) {
  refuse_tools_that_fill(tool_set(settings), kName);
  for (const Tool& tool : tool_set(settings)) {
    heads_.emplace_back(tool);
    edges_.push_back(parameters.edge_for(tool));
  }
  near_.reserve(kMostFaces);
  samples_.reserve(kMostSamples);
  bounds_.reserve(kMostSamples);
}

double VertexModel::travel() const noexcept {
  return std::numeric_limits<double>::infinity();
}

void VertexModel::forget() noexcept {
  found_ = false;
  filtered_ = dvec3(0);
}

void VertexModel::adopt(Snapshot& snapshot, PerTissue& removed) noexcept {
  auto& fresh = static_cast<VertexSnapshot&>(snapshot);
  // The fresh mesh lacks the cuts made since. After an undo these may take more or less than they did.
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
  found_ = false;
}

/// The vertices of the faces within reach of a place; of faces larger than the head asks for, those too that refining
/// would give them.
void VertexModel::gather(const dvec3& p, double reach, double edge) noexcept {
  const EditableMesh& mesh = snapshot_.mesh;
  near_.clear();
  samples_.clear();
  const glm::vec3 c(p);
  const auto most = static_cast<float>(reach);
  mesh.near(p - reach, p + reach, [&](Index f) {
    const glm::vec3 off = mesh.ball_center(f) - c;
    const float far = most + mesh.ball_radius(f);
    if (glm::dot(off, off) <= far * far && near_.size() < kMostFaces) near_.push_back(f);
  });
  for (const Index f : near_) {
    for (const Index v : mesh.face(f).v) {
      if (mesh.vertex(v).face != f) continue;  // each vertex once, with the face that it names
      snapshot_.sample_of[v] = static_cast<std::uint32_t>(samples_.size());
      add({mesh.vertex(v).p, 0, v, mesh.face(f).tissue});
    }
  }
  const std::size_t vertices = samples_.size();
  for (const Index f : near_) {
    const int n = parts_of(mesh, f, edge);
    const double area = glm::length(normal2(mesh, f)) / (6.0 * n * n);
    for (const Index v : mesh.face(f).v) {
      const std::size_t at = snapshot_.sample_of[v];
      if (at < vertices && samples_[at].v == v) samples_[at].area += area;
    }
    if (n == 1) continue;
    const dvec3 &a = mesh.point(f, 0), &b = mesh.point(f, 1), &d = mesh.point(f, 2);
    for (int i = 0; i <= n; ++i) {
      for (int j = 0; j <= n - i; ++j) {
        const int k = n - i - j;
        if (i == n || j == n || k == n) continue;  // a vertex
        const dvec3 at = (static_cast<double>(i) * a + static_cast<double>(j) * b + static_cast<double>(k) * d) /
                         static_cast<double>(n);
        if (glm::dot(at - p, at - p) > reach * reach) continue;
        add({at, area * (i == 0 || j == 0 || k == 0 ? 3 : 6), mesh::kNone, mesh.face(f).tissue});
      }
    }
  }
}

bool VertexModel::is_free(const VertexHead& head, double edge, const Pose& X) noexcept {
  found_ = false;
  gather(X.p, head.reach(), edge);
  const dquat R_TW = glm::conjugate(X.R);
  return std::all_of(samples_.begin(), samples_.end(),
                     [&](const Sample& s) { return head.distance(R_TW * (s.p - X.p)) > 0; });
}

double VertexModel::clearance(const Pose& X_WG) noexcept {
  if (snapshot_.number == 0) return 0;
  const double reach = head().reach();
  const EditableMesh& mesh = snapshot_.mesh;
  double room = P::look_ahead;
  const dvec3 far(reach + P::look_ahead);
  mesh.near(X_WG.p - far, X_WG.p + far, [&](Index f) {
    const double off = glm::distance(dvec3(mesh.ball_center(f)), X_WG.p) - static_cast<double>(mesh.ball_radius(f));
    room = std::min(room, off - reach);
  });
  return std::max(room, 0.0);
}

bool VertexModel::may_take_up(std::uint32_t tool, const Pose& X_WG) noexcept {
  return snapshot_.number > 0 && is_free(head(), edge(), X_WG) && is_free(heads_[tool], edges_[tool], X_WG);
}

void VertexModel::take_up(std::uint32_t tool) noexcept {
  tool_ = tool;
  forget();
}

/// The head's way from where it was held towards the hand. Distance is convex, so a step that keeps the bounds of all
/// vertices overlaps none.
dvec3 VertexModel::follow(const dvec3& from, const Pose& X_WT, bool& led_out) noexcept {
  const double radius = head().radius();
  const glm::dmat3 R_WT(glm::mat3_cast(X_WT.R)), R_TW = glm::transpose(R_WT);
  const bool is_ball = head().is_ball();
  dvec3 at = from;
  for (int look = 0; look < P::looks; ++look) {
    const dvec3 rest = X_WT.p - at;
    const double left = glm::length(rest);
    const double most = std::clamp(left, 0.01 * radius, P::step * radius), near = head().reach() + most;
    bounds_.clear();
    for (const Sample& sample : samples_) {
      const dvec3 off = sample.p - at;
      if (glm::dot(off, off) > near * near) continue;
      dvec3 n;
      const double d = head().distance(is_ball ? off : R_TW * off, n);
      if (d > most) continue;
      if (d < -P::led_out * radius) led_out = true;
      bounds_.push_back({-(is_ball ? n : R_WT * n), d});
    }
    dvec3 step = nearest_step(bounds_, left > most ? most / left * rest : rest);
    const double length = glm::length(step);
    if (length > most) step *= most / length;
    at += step;
    if (left <= most || length < P::settled * most) break;
  }
  return at;
}

/// The springs of the vertices inside a head at X (S4, 4.2): each as long as its way to the head's surface.
VertexModel::Springs VertexModel::springs_at(const Pose& X, const dvec3& pull) const noexcept {
  const glm::dmat3 R_WT(glm::mat3_cast(X.R)), R_TW = glm::transpose(R_WT);
  const bool is_ball = head().is_ball();
  const double reach2 = head().reach() * head().reach(), stiffness = P::spring * settings_.stiffness / 1000;
  Springs sum;
  for (const Sample& sample : samples_) {
    const dvec3 off = sample.p - X.p;
    if (glm::dot(off, off) >= reach2) continue;
    dvec3 n;
    const double d = head().distance(is_ball ? off : R_TW * off, n);
    if (!(d < 0)) continue;
    if (!is_ball) n = R_WT * n;
    const auto tissue = static_cast<std::size_t>(sample.tissue);
    const dvec3 push = stiffness * settings_.materials[tissue].stiffness * d * sample.area * n;
    sum.force += push;
    sum.torque += glm::cross(off, push);
    sum.area += sample.area;
    sum.across += sample.area * std::max(0.0, glm::dot(n, pull));
    sum.tissue[tissue] -= sample.area * d;
    ++sum.count;
  }
  return sum;
}

/// Spring and damper (S4, 4.1, 4.4, 4.5); the damper acts along the force, and never pulls.
void VertexModel::give(const ContactInput& in, const Springs& springs, double scale, Contact& out) noexcept {
  springs_ = springs;
  out.gives_force = true;
  out.area = springs.area;
  out.force = scale * springs.force;
  out.torque = scale * springs.torque;
  const double size = glm::length(out.force);
  if (!(size > 0)) return;
  out.stored = size * out.depth / 2;
  const dvec3 n = out.force / size;
  const double damped = std::max(0.0, size - settings_.damping * glm::dot(in.moved, n) / in.dt);
  out.force = damped * n;
  out.torque *= damped / size;
  if (!parameters_.filter) return;
  const dvec3 filtered = filter_force(ForceFilter::kStroke, *parameters_.filter, out.force, filtered_);
  const double before = glm::length(out.force);
  if (before > 0) out.torque *= glm::length(filtered) / before;
  out.force = filtered_ = filtered;
}

void VertexModel::constrain(const ContactInput& in, Contact& out) noexcept {
  springs_ = {};
  if (snapshot_.number == 0) {
    out.p_WG = in.X_WT.p;
    out.lost = true;
    out.faults |= bits(Fault::kPatchEdge);
    return;
  }
  if (parameters_.as_printed) return constrain_as_printed(in, out);
  const dvec3& from = in.X_WG.p;
  const double radius = head().radius(), probe = P::probe * radius;
  if (!found_ || glm::distance(from, found_at_) > P::kept * radius) {
    gather(from, head().reach() + (P::kept + P::looks * P::step) * radius + probe, edge());
    found_ = true, found_at_ = from;
  }
  out.p_WG = samples_.empty() ? in.X_WT.p : follow(from, in.X_WT, out.leading_out);
  const dvec3 pull = in.X_WT.p - out.p_WG;
  const double depth = glm::length(pull);
  constexpr double kNothing = 1e-10;  // m
  out.touching = depth > kNothing && !bounds_.empty() && !samples_.empty();
  out.settled = !out.touching;
  if (!out.touching) {
    filtered_ = dvec3(0);
    return;
  }
  out.depth = depth;
  const Springs springs = springs_at({out.p_WG + probe / depth * pull, in.X_WT.R}, pull / depth);
  give(in, springs, springs.area > 0 ? depth / probe / springs.area : 0, out);
}

/// The head is where the hand is; each vertex inside it pulls, all together.
void VertexModel::constrain_as_printed(const ContactInput& in, Contact& out) noexcept {
  out.p_WG = in.X_WT.p;
  gather(in.X_WT.p, head().reach(), edge());
  const dquat R_TW = glm::conjugate(in.X_WT.R);
  Springs sum;
  for (const Sample& sample : samples_) {
    const dvec3 off_T = R_TW * (sample.p - in.X_WT.p);
    if (sample.v == mesh::kNone || !(head().distance(off_T) < 0)) continue;
    const dvec3 way = in.X_WT.R * (off_T - head().as_printed(off_T));  // last position less the updated one
    const auto tissue = static_cast<std::size_t>(sample.tissue);
    const dvec3 push = settings_.stiffness * settings_.materials[tissue].stiffness / 1000 * way;
    sum.force += push;
    sum.torque += glm::cross(in.X_WT.R * off_T, push);
    sum.area += sample.area;
    sum.tissue[tissue] += glm::length(way);
    out.depth = std::max(out.depth, glm::length(way));
    ++sum.count;
  }
  out.touching = sum.count > 0;
  out.settled = !out.touching;
  if (out.touching) {
    give(in, sum, 1, out);
  } else {
    filtered_ = dvec3(0);
  }
}

bool VertexModel::cut(const ContactInput& in, Contact& contact, Cut& cut, double& energy) noexcept {
  if (!(in.cuts && !in.must_earn && contact.touching && springs_.count > 0)) return false;
  Pose from{contact.p_WG, in.X_WT.R}, to = in.X_WT;
  if (!parameters_.as_printed) {
    if (!(in.budget > 0 && in.specific_energy > 0 && springs_.across > 0)) return false;
    const dvec3 pull = in.X_WT.p - from.p;
    const double depth = glm::length(pull), bought = in.budget / in.specific_energy / springs_.across;
    const double way = std::min({bought, depth, P::stride * edge()});
    if (!(way >= P::sweep * edge())) return false;
    to.p = from.p + way / depth * pull;
  }
  const CutDone done = make_cut(snapshot_.mesh, snapshot_.cutter, head(), edge(), parameters_.as_printed, from, to);
  found_ = false;
  if (!done.changed) return false;
  made_.add(made_.last() + 1, {from, to, tool_, done.removed});
  cut = {made_.last(), in.tick, in.t, from, to, tool_, done.removed, {}, in.spindle};
  for (std::size_t t = 1; t < done.removed.size(); ++t) {
    energy += done.removed[t] * settings_.materials[t].specific_energy;
  }
  energy = std::max(energy, 0.0);
  if (!done.held) contact.p_WG = to.p;
  return true;
}

void VertexModel::feel(const ContactInput&, Contact& out) noexcept {
  double total = 0;
  for (std::size_t t = 1; t < springs_.tissue.size(); ++t) total += springs_.tissue[t];
  if (!(total > 0)) return;
  for (std::size_t t = 1; t < springs_.tissue.size(); ++t) out.tissue[t] = springs_.tissue[t] / total;
  out.known_tissue = true;
}

/// Of the nearest face, on its inner side.
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
