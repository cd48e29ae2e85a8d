#include "haptics/contact/vertex/mesh_cutter.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <utility>

#include "engine/base/dispatch.h"
#include "engine/base/units.h"
#include "engine/base/voxels.h"
#include "haptics/cutting/lanes.h"
#include "haptics/volume/label.h"

namespace typodont::haptics::vertex {

using mesh::EditableMesh;
using mesh::Index;
using mesh::kNone;
using P = CutParameters;

namespace {

// m, rounding error of the faces' bounding balls (floats)
constexpr double kBallRounding = 1e-6;
// Largest number of rounds per step that move vertices back out of folds or intersections. If more are needed, all
// vertices return to their positions before the step.
constexpr int kMaxRounds = 8;
// A face faces the core (part of the axis) if the cosine between its outer normal and the vector from the core to each
// corner is below this.
constexpr double kFacesCore = -0.05;

// Rounding error of the dot product of a unit vector with a vector a, relative to |a.x| + |a.y| + |a.z|. If the
// computed product is below minus this error, the exact product is negative.
constexpr double kClearlyInward = 1e-12;
// A quick test compares squared lengths of normals. It decides only if one exceeds the other by the factor kLarger
// (rounding), and if both are above kTiny2 (m⁴, because a normal is twice an area; excludes denormal numbers).
constexpr double kLarger = 1 + 1e-12, kTiny2 = 1e-100;
// m; triangles with a smaller height have uncertain normals
constexpr double kFlat = 1e-7;
// Two approximate lengths count as different only if one is below kShorter × the other.
constexpr double kShorter = 1 - 1e-6;

double edge2(const EditableMesh& mesh, Index f, int i) noexcept {
  const dvec3 direction = mesh.point(f, (i + 1) % 3) - mesh.point(f, i);
  return glm::dot(direction, direction);
}
/// Smallest height of a triangle divided by its longest edge; 0: the triangle has no area.
double roundness(const dvec3& a, const dvec3& b, const dvec3& c) noexcept {
  const dvec3 ab = b - a, bc = c - b, ca = a - c;
  const double longest2 = std::max({glm::dot(ab, ab), glm::dot(bc, bc), glm::dot(ca, ca)});
  return longest2 > 0 ? glm::length(glm::cross(ab, bc)) / longest2 : 0;
}

constexpr std::size_t kFaceBatch = 8;
// If the bounding ball of a face overlaps more balls than this, a quick test (crowd_) excludes some. Usual: up to 60.
constexpr std::size_t kCrowd = 100;
// Largest number of faces in crowd_, the table for a quick test of intersections.
constexpr std::size_t kMaxInCrowd = 1 << 15;

// Flag of a face in list_overlapping(): its ball does not reach the tested face's plane, so the faces do not cross.
constexpr std::uint32_t kBeside = 0x80000000;

/// Lists the faces whose bounding balls (x, y, z, radius) overlap the ball (p, r) of the tested face, some with the
/// flag kBeside. `n`: normal of the tested face; zero: the normal is uncertain.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
std::size_t list_overlapping(const float* x, const float* y, const float* z, const float* radius, std::size_t count,
                             const float* p, float r, const float* n, std::uint32_t* at) {
  constexpr float kClear = 1e-7f;  // m, tolerance for rounding errors of a ball's distance from the tested face's plane
  std::size_t found = 0;
  for (std::size_t k = 0; k < count; k += kFaceBatch) {
    F8 px, py, pz, far;
    std::memcpy(&px, x + k, sizeof px);
    std::memcpy(&py, y + k, sizeof py);
    std::memcpy(&pz, z + k, sizeof pz);
    std::memcpy(&far, radius + k, sizeof far);
    px -= p[0], py -= p[1], pz -= p[2];
    const F8 height = px * n[0] + py * n[1] + pz * n[2], clear = far + kClear;
    far += r;
    const I8 overlaps = px * px + py * py + pz * pz <= far * far;
    const unsigned beside = bits_of(I8((height > clear) | (height < -clear)));
    for (unsigned bits = bits_of(overlaps); bits; bits &= bits - 1) {
      const auto lane = static_cast<std::uint32_t>(std::countr_zero(bits));
      at[found++] = (static_cast<std::uint32_t>(k) + lane) | (beside >> lane & 1 ? kBeside : 0);
    }
  }
  // Removes results for indices from `count` on, which the last batch of eight also tested.
  while (found > 0 && (at[found - 1] & ~kBeside) >= count) --found;
  return found;
}

/// Returns true if the angles of two faces at a common vertex overlap, seen along -n. `i`, `j`: index of the vertex in
/// a and b.
bool angles_overlap(const mesh::Corners& a, int i, const mesh::Corners& b, int j, const dvec3& n) noexcept {
  const dvec3& p = a.p[i];
  const dvec3 a1 = a.p[(i + 1) % 3] - p, a2 = a.p[(i + 2) % 3] - p, b1 = b.p[(j + 1) % 3] - p,
              b2 = b.p[(j + 2) % 3] - p, n_a1 = glm::cross(n, a1), n_a2 = glm::cross(n, a2);
  // Signs tell on which side of an edge of `a` an edge of `b` lies.
  const double s11 = glm::dot(n_a1, b1), s12 = glm::dot(n_a1, b2), s21 = glm::dot(n_a2, b1), s22 = glm::dot(n_a2, b2);
  return (s11 > 0 && s21 < 0) || (s12 > 0 && s22 < 0) || (s11 < 0 && s12 > 0) || (s21 < 0 && s22 > 0);
}

/// Largest number of faces near the head with which long edges are still split. `edge`: m, target edge length.
std::size_t max_faces(const VertexHead& head, double edge) noexcept {
  const dvec3 half = head.half_box({0, 0, 1});
  const double area = 4 * kPi * half.x * (head.is_ball() ? half.x : 0.5 * half.x + half.z);
  const double face = std::sqrt(3.0) / 4 * edge * edge;
  return static_cast<std::size_t>(P::max_faces * area / face);
}

}  // namespace

MeshCutter::MeshCutter(const EditableMesh& mesh, SharedLabels labels)
    : labels_(std::move(labels)),
      vertex_seen_(mesh.vertex_capacity()),
      face_seen_(mesh.face_capacity()),
      place_of_(mesh.vertex_capacity()),
      edge_seen_(mesh.vertex_capacity()) {
  near_.reserve(mesh.face_capacity());
  sorted_.reserve(mesh.face_capacity());
  moved_.reserve(mesh.vertex_capacity());
  affected_.reserve(mesh.face_capacity());
  suspects_.reserve(2 * mesh.face_capacity());
  for (std::vector<float>* list : {&ball_x_, &ball_y_, &ball_z_, &ball_r_})
    list->resize(mesh.face_capacity() + kFaceBatch);
  ball_at_.resize(mesh.face_capacity());
  overlapping_.resize(mesh.face_capacity() + kFaceBatch);
  crowd_ = mesh::TriangleTable(std::min(mesh.face_capacity(), kMaxInCrowd));
  slot_of_.resize(mesh.face_capacity());
  tested_in_.resize(mesh.face_capacity());
}

MeshCutter::Placed MeshCutter::place(const VertexHead& head, const Pose& X) const noexcept {
  const glm::dmat3 R(glm::mat3_cast(X.R));
  return {&head, X, R, glm::transpose(R)};
}

/// Begins the search for faces within `margin` (m) of `head`.
void MeshCutter::begin_search(const Placed& head, double margin) noexcept {
  head_ = head;
  margin_ = margin;
  const dvec3 half = head.head->half_box(head.R_WT[2]) + margin;
  search_ = {head.X_W.p - half, head.X_W.p + half};
  near_.clear();
}

/// Adds a face to near_ if its bounding ball may be within margin_ of the head.
void MeshCutter::add_if_near(const EditableMesh& mesh, Index f) noexcept {
  const float far = static_cast<float>(margin_) + mesh.ball_radius(f);
  if (head_.head->may_be_within(mesh.ball_center(f) - glm::vec3(head_.X_W.p), glm::vec3(head_.R_WT[2]), far)) {
    near_.push_back(f);
  }
}

/// Returns true if `known` contains all faces that are now within margin_ of the head.
bool MeshCutter::covers(const KnownFaces& known) const noexcept {
  // If no point of the head moves by more than d, a face comes nearer by at most kMotion × d. Above 1, because faces
  // outside the head have a longer path, relative to the head, when the head rotates.
  constexpr double kMotion = 1.5;
  const double reach = head_.head->is_ball() ? 0 : head_.head->reach();
  const double moved = displacement_bound(known.X_W, head_.X_W, reach);
  return margin_ + kMotion * moved + kBallRounding <= known.within;
}

/// Collects near faces from `known` or the mesh, until the effort of this tick is used up. Returns true if complete.
bool MeshCutter::gather_in_part(const EditableMesh& mesh, const KnownFaces& known) noexcept {
  if (takes_known_ && known.number != known_) {  // the list of known faces was replaced
    begin_search(head_, margin_);
    takes_known_ = covers(known), known_ = known.number;
    at_ = 0;
  }
  if (takes_known_) {
    const glm::vec3 lo(search_.lo_W), hi(search_.hi_W);
    return each(known.faces.size(), kCutCosts.visit, [&](std::size_t k) {
      if (mesh.may_meet(known.faces[k], lo, hi)) add_if_near(mesh, known.faces[k]);
    });
  }
  const Effort most = std::min(left_, kNoLimit - 1) / kCutCosts.visit + 1;
  Effort visits = most;
  const bool complete = mesh.near_in_part(search_, visits, [&](Index f) { add_if_near(mesh, f); });
  left_ -= kCutCosts.visit * (most - visits);
  return complete;
}

/// Sorts by index, because the order must not depend on the grid. A radix sort: sorting by comparison would take a
/// third of the time of a cut.
void MeshCutter::sort_near() noexcept {
  constexpr int kDigit = 9;  // bits per pass of the sort
  constexpr Index kMask = (1u << kDigit) - 1;
  sorted_.resize(near_.size());
  const Index last = near_.empty() ? 0 : *std::max_element(near_.begin(), near_.end());
  for (int shift = 0; shift < 32 && last >> shift > 0; shift += kDigit) {
    std::array<std::uint32_t, kMask + 1> place{};
    for (const Index f : near_) ++place[f >> shift & kMask];
    std::exclusive_scan(place.begin(), place.end(), place.begin(), 0u);
    for (const Index f : near_) sorted_[place[f >> shift & kMask]++] = f;
    near_.swap(sorted_);
  }
}

/// Splits long edges near the head, without changing the shape. Returns false if the tick's effort is used up.
bool MeshCutter::refine(EditableMesh& mesh) noexcept {
  const double longest2 = P::longest * P::longest * job_.edge * job_.edge;
  const std::size_t most = std::min(near_.capacity(), max_faces(*head_.head, job_.edge));
  while (at_ < near_.size()) {
    if (left_ <= 0) return false;
    left_ -= kCutCosts.refine;
    const Index f = near_[at_];
    // No edge is longer than the bounding ball's diameter.
    if (static_cast<double>(mesh.ball_radius(f)) < 0.5 * P::longest * job_.edge * kShorter) {
      ++at_;
      continue;
    }
    int longest = -1;
    double greatest2 = longest2;
    for (int i = 0; i < 3; ++i) {
      const double e2 = edge2(mesh, f, i);
      if (e2 > greatest2) greatest2 = e2, longest = i;
    }
    // Does not split an edge with an end on an open border of the mesh.
    if (longest >= 0 && (mesh.vertex(mesh.face(f).v[longest]).on_border() ||
                         mesh.vertex(mesh.face(f).v[(longest + 1) % 3]).on_border())) {
      longest = -1;
    }
    bool reached = false;
    if (longest >= 0) {
      left_ -= kCutCosts.distance;
      const dvec3 &a = mesh.point(f, 0), &b = mesh.point(f, 1), &c = mesh.point(f, 2);
      const dvec3 g = (a + b + c) / 3.0;
      const double size = std::sqrt(std::max({glm::dot(a - g, a - g), glm::dot(b - g, b - g), glm::dot(c - g, c - g)}));
      reached = head_.distance(g) < size;
    }
    if (!reached || near_.size() + 3 > most) {
      ++at_;
      continue;
    }
    left_ -= kCutCosts.split;
    const Index g = mesh.face(f).n[longest];
    const dvec3 middle = 0.5 * (mesh.point(f, longest) + mesh.point(f, (longest + 1) % 3));
    const Index m = mesh.split(f, longest, middle);
    if (m == kNone) return true;  // the buffers are full, so no more edges are split
    done_.changed = true;
    near_.push_back(g);
    mesh.around(m, [&](Index h, int) {
      if (h != f && h != g) near_.push_back(h);
    });
  }
  // Removes duplicates from near_: a face may also have been added as the neighbour of a split edge.
  ++search_number_;
  std::erase_if(near_, [&](Index f) { return !see_face(f); });
  return true;
}

/// Moves a vertex by `depth` along `n`, out of the head and into the solid, but not out of the solid through a
/// neighbouring face. Returns false if there is no such direction.
bool MeshCutter::push_direction(const EditableMesh& mesh, Index v, const dvec3& n, double depth,
                                dvec3& to) const noexcept {
  constexpr int kMaxFaces = 32;
  dvec3 areas[kMaxFaces], normals[kMaxFaces], sum(0);
  int count = 0;
  bool inward = true;  // true: `n` points certainly inwards at all faces
  mesh.around(v, [&](Index f, int) {
    const dvec3 area = normal2(mesh, f);
    if (!(glm::dot(area, area) > 0) || count == kMaxFaces) return;
    areas[count++] = area;
    inward = inward && glm::dot(n, area) < -kClearlyInward * (std::abs(area.x) + std::abs(area.y) + std::abs(area.z));
  });
  const dvec3& p = mesh.vertex(v).p;
  if (inward) {
    to = p + depth * n;
    return true;
  }
  double out = -1;
  for (int i = 0; i < count; ++i) {
    sum += areas[i];
    normals[i] = areas[i] / glm::length(areas[i]);
    out = std::max(out, glm::dot(n, normals[i]));
  }
  if (out <= 0) {
    to = p + depth * n;
    return true;
  }
  dvec3 direction = n;
  for (int round = 0; round < 8; ++round) {
    double worst = 1e-6;
    int at = -1;
    for (int i = 0; i < count; ++i) {
      if (const double d = glm::dot(direction, normals[i]); d > worst) worst = d, at = i;
    }
    if (at < 0) break;
    direction -= worst * normals[at];
  }
  double length = glm::length(direction);
  if (length < 0.3) {
    direction = -sum;
    length = glm::length(direction);
    if (!(length > 0)) return false;
  }
  direction /= length;
  const dvec3 direction_T = head_.head->is_ball() ? direction : head_.R_TW * direction;
  to = p + head_.head->distance_to_surface(head_.to_tool(p), direction_T) * direction;
  return true;
}

/// Computes target positions of the vertices that find_inside() collected.
void MeshCutter::find_targets(const EditableMesh& mesh) noexcept {
  const double most2 = P::farthest * P::farthest * job_.edge * job_.edge;
  left_ -= kCutCosts.distances * static_cast<Effort>(distances_.size());
  distances_.evaluate(*head_.head, head_.R_WT, -P::overlap);
  left_ -= kCutCosts.push * static_cast<Effort>(distances_.size());
  for (std::size_t i = 0; i < distances_.size(); ++i) {
    const Index v = distances_.point(i);
    const mesh::Vertex& vertex = mesh.vertex(v);
    dvec3 to;
    if (vertex.on_border() || !push_direction(mesh, v, distances_.normal_W(i), -distances_.distance(i), to) ||
        glm::dot(to - vertex.p, to - vertex.p) > most2) {
      done_.held = true;
      continue;
    }
    place_of_[v] = static_cast<std::uint32_t>(moved_.size());
    moved_.push_back({v, vertex, to, false});
  }
  distances_.clear();
}

/// Finds the vertices inside the head, and the positions to which they will be moved.
bool MeshCutter::find_inside(const EditableMesh& mesh) noexcept {
  if (at_ == 0) {
    moved_.clear();
    distances_.clear();
    ++search_number_;
  }
  const glm::vec3 axis(head_.R_WT[2]), center(head_.X_W.p);
  if (!each(near_.size(), kCutCosts.find, [&](std::size_t k) {
        // If the bounding ball of a face is outside the head, so are the face's corners.
        const Index f = near_[k];
        const float far = mesh.ball_radius(f) + static_cast<float>(kBallRounding);
        if (!head_.head->may_be_within(mesh.ball_center(f) - center, axis, far)) return;
        for (const Index v : mesh.face(f).v) {
          if (!see_vertex(v)) continue;
          place_of_[v] = kNone;
          const dvec3 from = mesh.vertex(v).p - head_.X_W.p;
          if (!head_.head->may_be_within(glm::vec3(from), axis, 0)) continue;
          if (distances_.full()) find_targets(mesh);
          distances_.add(v, from);
        }
      })) {
    return false;
  }
  find_targets(mesh);
  return true;
}

/// Stores, for the faces around the moving vertex v, their normals and their tetrahedra with the head's centre.
void MeshCutter::collect_affected(const EditableMesh& mesh, Index v) noexcept {
  mesh.around(v, [&](Index f, int) {
    if (!see_face(f)) return;
    const dvec3 &a = mesh.point(f, 0), &b = mesh.point(f, 1), &c = mesh.point(f, 2);
    affected_.push_back({f, volume6(a, b, c, head_.X_W.p), normal2(a, b, c)});
  });
}

/// Moves the vertices of a face back to their positions before the step. Returns false if no vertex had moved.
bool MeshCutter::hold_back(EditableMesh& mesh, Index f) noexcept {
  bool any = false;
  for (const Index v : mesh.face(f).v) {
    if (vertex_seen_[v] != search_number_ || place_of_[v] == kNone || moved_[place_of_[v]].stays) continue;
    Moved& m = moved_[place_of_[v]];
    mesh.move_back(v, m.before);
    mesh.settle(v);
    if (crowded_) update_crowd(mesh, v);
    m.stays = any = true;
  }
  return any;
}

/// Returns true if a face has turned too far (CutParameters::min_turn) and does not face the head (faces_head).
bool MeshCutter::folds(const EditableMesh& mesh, const Affected& a) const noexcept {
  const dvec3 now = normal2(mesh, a.f);
  const double along = glm::dot(now, a.normal), now2 = glm::dot(now, now), before2 = glm::dot(a.normal, a.normal);
  // Quick test for a small turn of the face, without square roots; otherwise the exact test follows.
  if (along > 0 && now2 > kTiny2 && before2 > kTiny2 &&
      along * along > kLarger * P::min_turn * P::min_turn * now2 * before2) {
    return false;
  }
  const double length = glm::length(now), size = length * glm::length(a.normal);
  if (size > 0 && along >= P::min_turn * size) return false;
  if (size == 0) return a.normal != dvec3(0);
  dvec3 n;
  head_.distance((mesh.point(a.f, 0) + mesh.point(a.f, 1) + mesh.point(a.f, 2)) / 3.0, n);
  return glm::dot(now, n) > -P::faces_head * length;
}

/// Moves the vertices of folded faces back. A face that turns far but faces the head is not folded: it becomes a wall
/// of the cut. Returns false if the computing effort of this tick is used up.
bool MeshCutter::keep_unfolded(EditableMesh& mesh) noexcept {
  for (;;) {
    if (!each(affected_.size(), kCutCosts.unfold, [&](std::size_t i) {
          if (folds(mesh, affected_[i])) unfold_held_ |= hold_back(mesh, affected_[i].f);
        })) {
      return false;
    }
    if (!std::exchange(unfold_held_, false)) break;
    if (++unfold_rounds_ < kMaxRounds) continue;
    for (const Affected& a : affected_) hold_back(mesh, a.f);
    break;
  }
  unfold_rounds_ = 0;
  return true;
}

/// Sorts the faces' bounding balls into slices along the longest side of their box, so that overlaps are searched in
/// few slices. Large faces come last.
void MeshCutter::list_balls(const EditableMesh& mesh) noexcept {
  glm::vec3 lo(1e30f), hi(-1e30f);
  for (const Index f : near_) lo = glm::min(lo, mesh.ball_center(f)), hi = glm::max(hi, mesh.ball_center(f));
  const glm::vec3 size = hi - lo;
  slice_axis_ = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  slice_lo_ = lo[slice_axis_];
  slices_per_m_ = kSlices / std::max(size[slice_axis_], 1e-9f);
  widest_ = static_cast<float>(job_.edge);
  const auto slice_of = [&](Index f) {
    return mesh.ball_radius(f) > widest_ ? kSlices : slice_at(mesh.ball_center(f)[slice_axis_]);
  };
  slice_start_.fill(0);
  for (const Index f : near_) ++slice_start_[static_cast<std::size_t>(slice_of(f)) + 1];
  std::partial_sum(slice_start_.begin(), slice_start_.end(), slice_start_.begin());
  std::array<std::uint32_t, kSlices + 2> next = slice_start_;
  for (std::size_t k = 0; k < near_.size(); ++k) {
    const std::size_t at = next[static_cast<std::size_t>(slice_of(near_[k]))]++;
    const glm::vec3& c = mesh.ball_center(near_[k]);
    ball_x_[at] = c.x, ball_y_[at] = c.y, ball_z_[at] = c.z, ball_r_[at] = mesh.ball_radius(near_[k]);
    ball_at_[at] = static_cast<std::uint32_t>(k);
  }
  crowded_ = false;
}

/// Fills the table crowd_ with the corners of the faces in near_, in the order of their bounding balls.
void MeshCutter::list_crowd(const EditableMesh& mesh) noexcept {
  for (std::size_t slot = 0; slot < near_.size(); ++slot) {
    const Index f = near_[ball_at_[slot]];
    slot_of_[f] = static_cast<std::uint32_t>(slot);
    crowd_.set(slot, mesh.point(f, 0), mesh.point(f, 1), mesh.point(f, 2));
  }
  crowded_ = true;
}

/// Updates the faces around a moved vertex in the table crowd_.
void MeshCutter::update_crowd(const EditableMesh& mesh, Index v) noexcept {
  mesh.around(v, [&](Index f, int) {
    const std::uint32_t slot = slot_of_[f];
    if (slot < near_.size() && near_[ball_at_[slot]] == f)
      crowd_.set(slot, mesh.point(f, 0), mesh.point(f, 1), mesh.point(f, 2));
  });
}

/// Returns true if a face with the corners `a` and the normal n intersects g. If they share a vertex, similar normals
/// usually decide quickly.
bool MeshCutter::intersect(const EditableMesh& mesh, const mesh::Corners& a, const dvec3& n, Index g) const noexcept {
  const mesh::Corners b = mesh::corners(mesh, g);
  const mesh::SharedCorners shared(a, b);
  if (shared.count > 0) {
    const dvec3 m = normal2(mesh, g);
    const double d = glm::dot(n, m), size2 = glm::dot(n, n) * glm::dot(m, m);
    if (shared.count > 1) return d < 0 && d * d > P::flat_fold * P::flat_fold * size2;
    const bool same_way = d > 0 && d * d > P::same_way * P::same_way * size2;
    if (same_way && !angles_overlap(a, shared.of_a, b, shared.of_b, n)) return false;
  }
  return mesh::cross_each_other(a, b);
}

/// First face in near_ that intersects face f, or kNone. At least one of the two must have changed.
Index MeshCutter::crossed_near(const EditableMesh& mesh, Index f) noexcept {
  const glm::vec3& c = mesh.ball_center(f);
  const float r = mesh.ball_radius(f);
  const bool changed = face_seen_[f] == search_number_;
  const mesh::Corners corners = mesh::corners(mesh, f);
  const dvec3 n = normal2(mesh, f);
  const double n2 = glm::dot(n, n), least = kFlat * 2 * static_cast<double>(r);
  const glm::vec3 unit = n2 > least * least ? glm::vec3(n / std::sqrt(n2)) : glm::vec3(0);
  std::uint32_t first = kNone;
  const auto test = [&](std::size_t from, std::size_t to) {
    const std::size_t found = list_overlapping(ball_x_.data() + from, ball_y_.data() + from, ball_z_.data() + from,
                                               ball_r_.data() + from, to - from, &c.x, r, &unit.x, overlapping_.data());
    std::size_t count = 0, tested = 0;
    for (std::size_t i = 0; i < found; ++i) {
      const std::size_t slot = from + (overlapping_[i] & ~kBeside);
      // This face was tested earlier in this round, also against f, without an intersection. Not valid if vertices were
      // moved back since (held_).
      if (!held_ && tested_in_[near_[ball_at_[slot]]] == edge_search_number_) continue;
      ++tested;
      if (!(overlapping_[i] & kBeside)) overlapping_[count++] = static_cast<std::uint32_t>(slot);
    }
    left_ -= kCutCosts.pair * static_cast<Effort>(tested);
    if (count > kCrowd && near_.size() <= crowd_.room()) {
      if (!crowded_) list_crowd(mesh);
      count = crowd_.keep_possible(corners, overlapping_.data(), count);
    }
    for (std::size_t i = 0; i < count; ++i) {
      const std::uint32_t k = ball_at_[overlapping_[i]];
      const Index g = near_[k];
      if (k > first || g == f || !(changed || face_seen_[g] == search_number_)) continue;
      if (intersect(mesh, corners, n, g)) first = k;
    }
  };
  const float at = c[slice_axis_], reach = r + widest_ + static_cast<float>(kBallRounding);
  test(slice_start_[static_cast<std::size_t>(slice_at(at - reach))],
       slice_start_[static_cast<std::size_t>(slice_at(at + reach)) + 1]);
  test(slice_start_[kSlices], slice_start_[kSlices + 1]);
  if (first != kNone) return near_[first];
  tested_in_[f] = edge_search_number_;
  return kNone;
}

/// Returns true if a face is directed towards the core (part of the head's axis, core_low()) at all its corners.
bool MeshCutter::faces_core(const EditableMesh& mesh, Index f) const noexcept {
  const dvec3 axis = head_.head->is_ball() ? dvec3(0) : head_.R_WT[2];
  // Vector from the nearest point of the core (part of the head's axis) to `off`.
  const auto from_core = [&](const dvec3& off) {
    return off - std::clamp(glm::dot(off, axis), head_.head->core_low(), head_.head->core_high()) * axis;
  };
  // Quick test with an approximate normal, and with the ball around the face: no corner is outside this ball.
  const dvec3 center = from_core(dvec3(mesh.ball_center(f)) - head_.X_W.p);
  const double far = glm::length(center), radius = static_cast<double>(mesh.ball_radius(f)) + kBallRounding;
  constexpr double kError = EditableMesh::kRoughNormalError;
  if (glm::dot(dvec3(mesh.rough_normal(f)), center) < kFacesCore * (far + radius) - kError * far - radius) return true;
  const dvec3 n = normal2(mesh, f);
  const double length = glm::length(n);
  for (int i = 0; i < 3; ++i) {
    const dvec3 direction = from_core(mesh.point(f, i) - head_.X_W.p);
    if (!(glm::dot(n, direction) < kFacesCore * length * glm::length(direction))) return false;
  }
  return true;
}

/// Adds a face to suspects_ if it does not face the core (part of the head's axis), as in thin walls, undercuts, holes.
/// If all near faces face the core, each ray from the core enters the solid only once, so no faces intersect.
void MeshCutter::select_suspect(const EditableMesh& mesh, Index f) noexcept {
  if (faces_core(mesh, f)) return;
  // Moved vertices lie on the head's surface, so unchanged faces can intersect another only very near the head.
  const double within = mesh.ball_radius(f) + (face_seen_[f] == search_number_ ? job_.edge : kBallRounding);
  const dvec3 direction = (mesh.point(f, 0) + mesh.point(f, 1) + mesh.point(f, 2)) / 3.0 - head_.X_W.p;
  if (!head_.head->may_be_within(glm::vec3(direction), glm::vec3(head_.R_WT[2]), static_cast<float>(within))) return;
  left_ -= kCutCosts.distance;
  if (head_.head->is_ball()) return add_suspect(mesh, f);
  candidates_[distances_.size()] = {f, within};
  distances_.add(static_cast<std::uint32_t>(distances_.size()), direction);
  if (distances_.full()) decide_candidates(mesh);
}

void MeshCutter::add_suspect(const EditableMesh& mesh, Index f) noexcept {
  thin_ = true;
  suspects_.push_back(f);
  for (const Index v : mesh.face(f).v) edge_seen_[v] = edge_search_number_;
}

/// Computes the distances of the faces in candidates_ from the head, eight at once, and selects those to be tested.
void MeshCutter::decide_candidates(const EditableMesh& mesh) noexcept {
  distances_.evaluate(*head_.head, head_.R_WT, std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < distances_.size(); ++i) {
    const Candidate& candidate = candidates_[distances_.point(i)];
    if (!(distances_.distance(i) > candidate.within)) add_suspect(mesh, candidate.f);
  }
  distances_.clear();
}

/// If the face intersects another face, moves the vertices of both faces back to their positions before the step.
void MeshCutter::test_suspect(EditableMesh& mesh, Index f) noexcept {
  if (!held_ && tested_in_[f] == edge_search_number_) return;  // The face is in suspects_ twice and was tested already.
  const Index g = crossed_near(mesh, f);
  if (g == kNone) return;
  held_ |= hold_back(mesh, f);
  held_ |= hold_back(mesh, g);
}

Tissue MeshCutter::tissue_under(const EditableMesh& mesh, Index f) const noexcept {
  const Tissue own = mesh.face(f).tissue;
  if (!labels_) return own;
  const dvec3 n = normal2(mesh, f);
  const double length = glm::length(n);
  if (!(length > 0)) return own;
  const dvec3 below =
      (mesh.point(f, 0) + mesh.point(f, 1) + mesh.point(f, 2)) / 3.0 - 0.5 * labels_->frame.voxel / length * n;
  const glm::ivec3 at(glm::round(labels_->frame.to_voxels(below)));
  if (!in_grid(at, labels_->size)) return own;
  const Tissue label = shown(labels_->tissue[labels_->at(at.x, at.y, at.z)]);
  return label == Tissue::kAir ? own : label;
}

void MeshCutter::account(EditableMesh& mesh, const Affected& a) noexcept {
  const double now = volume6(mesh.point(a.f, 0), mesh.point(a.f, 1), mesh.point(a.f, 2), head_.X_W.p);
  done_.removed[static_cast<std::size_t>(mesh.face(a.f).tissue)] += (a.volume6 - now) / 6;
  mesh.set_tissue(a.f, tissue_under(mesh, a.f));
}

/// Collapses an edge, unless a face would turn too far, become too small, flat or long, or intersect another face, or
/// the volume would change too much. Returns true if done.
bool MeshCutter::collapse_edge(EditableMesh& mesh, Index f, int i, bool keeps_first, double longest,
                               double max_volume) noexcept {
  const Index first = mesh.face(f).v[i], second = mesh.face(f).v[(i + 1) % 3];
  const Index kept = keeps_first ? first : second, gone = keeps_first ? second : first;
  if (mesh.vertex(kept).on_border() || !mesh.may_collapse(f, i, keeps_first)) return false;
  const dvec3 to = mesh.vertex(kept).p, from = mesh.vertex(gone).p;
  const double longest2 = longest * longest * job_.edge * job_.edge;
  // Limits for the faces after the collapse. At tiny edges, the limits are weaker for faces that exceed them already;
  // otherwise tiny edges could never be removed.
  const bool accepts_bad = glm::dot(to - from, to - from) < P::tiny * P::tiny * job_.edge * job_.edge;
  const auto min_area = [&](const dvec3& before) {
    const double least = P::min_area * job_.edge * job_.edge;
    return accepts_bad ? std::min(least, 0.5 * glm::length(before)) : least;
  };
  const auto max_length2 = [&](const dvec3& b) {
    return accepts_bad ? std::max(longest2, glm::dot(b - from, b - from)) : longest2;
  };
  const auto min_roundness = [&](const dvec3& b, const dvec3& d) {
    return 0.5 * (accepts_bad ? std::min(P::flattest, roundness(from, b, d)) : P::flattest);
  };
  bool allowed = true;
  // m³ × 6, change of the mesh's volume; positive: added
  double volume = 0;
  mesh.around(gone, [&](Index h, int c) {
    const dvec3 &b = mesh.point(h, (c + 1) % 3), &d = mesh.point(h, (c + 2) % 3);
    volume += volume6(to, b, d, to) - volume6(from, b, d, to);
    if (mesh.face(h).v[(c + 1) % 3] == kept || mesh.face(h).v[(c + 2) % 3] == kept) return;
    const dvec3 before = normal2(from, b, d), after = normal2(to, b, d);
    const double size = glm::length(before) * glm::length(after);
    if (!(glm::length(after) > min_area(before))) allowed = false;
    if (allowed && glm::dot(before, after) < P::min_turn_in_mending * size) {
      dvec3 n;
      head_.distance((to + b + d) / 3.0, n);
      if (glm::dot(after, n) > -P::faces_head * glm::length(after)) allowed = false;
    }
    if (glm::dot(b - to, b - to) > max_length2(b) || roundness(to, b, d) < min_roundness(b, d)) allowed = false;
  });
  if (!allowed || std::abs(volume) > 6 * max_volume * job_.edge * job_.edge * job_.edge) return false;
  if (thin_) {
    const auto stays = [&](Index h) {
      return mesh.face(h).v[0] != gone && mesh.face(h).v[1] != gone && mesh.face(h).v[2] != gone;
    };
    mesh::BoxedTriangles fresh;  // the faces after the collapse
    mesh.around(gone, [&](Index h, int c) {
      const Index b = mesh.face(h).v[(c + 1) % 3], d = mesh.face(h).v[(c + 2) % 3];
      if (b == kept || d == kept) return;
      fresh.add({{kept, b, d}, {to, mesh.vertex(b).p, mesh.vertex(d).p}});
    });
    if (mesh::crosses_any(mesh, fresh, stays)) return false;
  }
  done_.removed[static_cast<std::size_t>(mesh.face(f).tissue)] -= volume / 6;
  return mesh.collapse(f, i, keeps_first);
}

/// Flips an edge between nearly coplanar faces if this increases the smaller roundness() of both. Returns true if done.
bool MeshCutter::turn(EditableMesh& mesh, Index f, int i) noexcept {
  const Index g = mesh.face(f).n[i];
  if (g == kNone) return false;
  const dvec3 a = mesh.point(f, i), b = mesh.point(f, (i + 1) % 3), c = mesh.point(f, (i + 2) % 3);
  const dvec3 d = mesh.point(g, (mesh.edge_to(g, f, mesh.face(f).v[(i + 1) % 3]) + 2) % 3);
  const dvec3 before = normal2(a, b, c) + normal2(b, a, d), one = normal2(a, d, c), other = normal2(d, b, c);
  const auto agrees = [&](const dvec3& n) {
    return glm::dot(n, before) > P::same_plane * glm::length(n) * glm::length(before) && glm::length(n) > 0;
  };
  if (!agrees(one) || !agrees(other)) return false;
  if (std::min(roundness(a, d, c), roundness(d, b, c)) <= std::min(roundness(a, b, c), roundness(b, a, d))) {
    return false;
  }
  // m³ × 6, change of the mesh's volume; positive: added
  const double volume = volume6(a, d, c, b);
  if (std::abs(volume) > 6 * P::max_volume * job_.edge * job_.edge * job_.edge) return false;
  if (!mesh.flip(f, i)) return false;
  if (thin_) {
    for (const Index h : {f, g}) {
      mesh::BoxedTriangles turned;
      turned.add(mesh::corners(mesh, h));
      if (!mesh::crosses_any(mesh, turned, [&](Index k) { return k != h; })) continue;
      mesh.flip(f, 1);  // flips back: face f now has the corners a, d, c and the flipped edge 1
      return false;
    }
  }
  done_.removed[static_cast<std::size_t>(mesh.face(f).tissue)] -= volume / 6;
  mesh.set_tissue(f, tissue_under(mesh, f));
  mesh.set_tissue(g, tissue_under(mesh, g));
  return true;
}

/// Collapses a sliver's short edge, or flips its longest edge.
void MeshCutter::repair_sliver(EditableMesh& mesh, Index f) noexcept {
  const double shortest2 = P::shortest * P::shortest * job_.edge * job_.edge;
  if (!mesh.uses(f)) return;
  int shortest = 0, longest = 0;
  double length2[3];
  for (int i = 0; i < 3; ++i) {
    length2[i] = edge2(mesh, f, i);
    if (length2[i] < length2[shortest]) shortest = i;
    if (length2[i] > length2[longest]) longest = i;
  }
  if (length2[shortest] < shortest2) {
    left_ -= thin_ ? kCutCosts.thin_collapse : kCutCosts.collapse;
    // Keeps a vertex that no cut has moved, if possible.
    const bool first = !mesh.vertex(mesh.face(f).v[shortest]).was_moved();
    if (collapse_edge(mesh, f, shortest, first, P::longest, P::max_volume) ||
        collapse_edge(mesh, f, shortest, !first, P::longest, P::max_volume)) {
      return;
    }
  }
  if (roundness(mesh.point(f, 0), mesh.point(f, 1), mesh.point(f, 2)) < P::flattest) {
    left_ -= thin_ ? kCutCosts.thin_collapse : kCutCosts.collapse;
    turn(mesh, f, longest);
  }
}

/// Merges vertex v into a neighbouring vertex. Tries neighbours outside the head first, in order of distance. Returns
/// false if no merge is possible.
bool MeshCutter::merge_into_neighbour(EditableMesh& mesh, Index v) noexcept {
  struct Neighbour {
    bool inside;
    double far2;  // m², squared distance of the neighbour from v
    Index face;   // a face that has the edge from v to this neighbour
    int i;        // index of this edge in `face`
    bool operator<(const Neighbour& other) const noexcept {
      return inside != other.inside ? other.inside : far2 < other.far2;
    }
  };
  constexpr std::size_t kMost = 32;
  std::array<Neighbour, kMost> neighbours;
  std::size_t count = 0;
  mesh.around(v, [&](Index f, int c) {
    if (count == kMost || !mesh.may_collapse(f, c, false)) return;
    const bool inside = head_.distance(mesh.point(f, (c + 1) % 3)) < -P::overlap;
    const Neighbour next{inside, edge2(mesh, f, c), f, c};
    std::size_t at = count++;
    for (; at > 0 && next < neighbours[at - 1]; --at) neighbours[at] = neighbours[at - 1];
    neighbours[at] = next;
  });
  for (std::size_t k = 0; k < count; ++k) {
    left_ -= thin_ ? kCutCosts.thin_collapse : kCutCosts.collapse;
    const Neighbour& to = neighbours[k];
    if (collapse_edge(mesh, to.face, to.i, false, P::longest_merged, P::max_given)) return true;
  }
  return false;
}

CutDone MeshCutter::cut(EditableMesh& mesh, const VertexHead& head, const Pose& X_WA, const Pose& X_WB,
                        double edge) noexcept {
  begin(head, X_WA, X_WB, edge);
  Effort left = kNoLimit;
  work(mesh, {}, left);
  return done_;
}

void MeshCutter::begin(const VertexHead& head, const Pose& X_WA, const Pose& X_WB, double edge) noexcept {
  constexpr double kMaxSteps = 100'000;
  const double direction = displacement_bound(X_WA, X_WB, head.reach());
  // The factor makes the servo's longest cut (FeelParameters::stride) exactly one step, in spite of rounding.
  const double steps = direction / (P::step * edge) * (1 - 1e-6);
  job_ = {&head, X_WA, X_WB, edge, static_cast<int>(std::min(std::ceil(steps), kMaxSteps)), 0};
  done_ = {};
  go_to(Stage::kNextStep);
}

bool MeshCutter::work(EditableMesh& mesh, const KnownFaces& known, Effort& left) noexcept {
  left_ = left;
  while (stage_ != Stage::kDone && left_ > 0) run_stage(mesh, known);
  left = left_;
  return stage_ == Stage::kDone;
}

/// Continues the current stage of the step until it is complete, or the tick's computing effort `left_` is used up.
void MeshCutter::run_stage(EditableMesh& mesh, const KnownFaces& known) noexcept {
  switch (stage_) {
    case Stage::kNextStep: {
      if (job_.step == job_.steps || done_.held) return go_to(Stage::kDone);
      const int i = ++job_.step;
      const double part = static_cast<double>(i) / job_.steps;
      begin_search(place(*job_.head, i == job_.steps ? job_.X_WB : interpolate(job_.X_WA, job_.X_WB, part)),
                   P::longest * job_.edge);
      // The list `known` is valid in the first step only, because each step changes the mesh.
      takes_known_ = i == 1 && covers(known), known_ = known.number;
      return go_to(Stage::kSearch);
    }
    case Stage::kSearch:
      if (!gather_in_part(mesh, known)) return;
      sort_near();
      left_ -= kCutCosts.sort * static_cast<Effort>(near_.size());
      return go_to(Stage::kRefine);
    case Stage::kRefine:
      if (refine(mesh)) go_to(Stage::kFind);
      return;
    case Stage::kFind:
      if (!find_inside(mesh)) return;
      affected_.clear();
      return go_to(moved_.empty() ? Stage::kNextStep : Stage::kCollect);
    case Stage::kCollect:
      if (!each(moved_.size(), kCutCosts.collect, [&](std::size_t i) { collect_affected(mesh, moved_[i].v); })) {
        return;
      }
      for (const Moved& m : moved_) mesh.move(m.v, m.to);
      return go_to(Stage::kUnfold);
    case Stage::kUnfold:
      if (keep_unfolded(mesh)) go_to(Stage::kSettle);
      return;
    case Stage::kSettle:
      if (!each(affected_.size(), kCutCosts.settle, [&](std::size_t i) { mesh.settle_face(affected_[i].f); })) return;
      thin_ = false;
      rounds_ = 0;
      return go_to(Stage::kSelect);
    case Stage::kSelect:
      if (at_ == 0) {
        if (rounds_++ == kMaxRounds) {
          for (const Affected& a : affected_) hold_back(mesh, a.f);
          return go_to(Stage::kAccount);
        }
        ++edge_search_number_;
        suspects_.clear();
        distances_.clear();
        held_ = false;
      }
      if (!each(near_.size(), kCutCosts.select, [&](std::size_t k) { select_suspect(mesh, near_[k]); })) {
        return;
      }
      decide_candidates(mesh);
      looking_away_ = suspects_.size();
      if (suspects_.empty()) return go_to(Stage::kTest);
      left_ -= kCutCosts.ball * static_cast<Effort>(near_.size());
      list_balls(mesh);
      return go_to(Stage::kSelectChanged);
    case Stage::kSelectChanged:
      // Also tests changed faces that share a vertex with a suspect: at a fold, these may cross the suspect.
      if (!each(affected_.size(), kCutCosts.select_changed, [&](std::size_t i) {
            const Index* const v = mesh.face(affected_[i].f).v;
            if (edge_seen_[v[0]] == edge_search_number_ || edge_seen_[v[1]] == edge_search_number_ ||
                edge_seen_[v[2]] == edge_search_number_) {
              suspects_.push_back(affected_[i].f);
            }
          })) {
        return;
      }
      std::sort(suspects_.begin() + static_cast<std::ptrdiff_t>(looking_away_), suspects_.end());
      return go_to(Stage::kTest);
    case Stage::kTest:
      if (!each(suspects_.size(), kCutCosts.test, [&](std::size_t i) { test_suspect(mesh, suspects_[i]); })) return;
      return go_to(held_ ? Stage::kUnfoldAgain : Stage::kAccount);
    case Stage::kUnfoldAgain:
      if (keep_unfolded(mesh)) go_to(Stage::kSelect);
      return;
    case Stage::kAccount:
      if (each(affected_.size(), kCutCosts.account, [&](std::size_t i) { account(mesh, affected_[i]); })) {
        go_to(Stage::kMerge);
      }
      return;
    case Stage::kMerge:
      if (!each(moved_.size(), 1, [&](std::size_t i) {
            const Moved& m = moved_[i];
            if (!m.stays || merge_into_neighbour(mesh, m.v)) {
              done_.changed = true;
            } else {
              done_.held = true;
            }
          })) {
        return;
      }
      return go_to(Stage::kRepair);
    case Stage::kRepair:
      if (each(affected_.size(), kCutCosts.repair, [&](std::size_t i) { repair_sliver(mesh, affected_[i].f); })) {
        go_to(Stage::kNextStep);
      }
      return;
    case Stage::kDone:
      return;
  }
}

CutDone MeshCutter::cut_as_printed(EditableMesh& mesh, const VertexHead& head, const Pose& X_WB) noexcept {
  done_ = {};
  begin_search(place(head, X_WB), 0);
  mesh.near(search_.lo_W, search_.hi_W, [&](Index f) { add_if_near(mesh, f); });
  sort_near();
  moved_.clear();
  ++search_number_;
  for (const Index f : near_) {
    for (const Index v : mesh.face(f).v) {
      if (!see_vertex(v)) continue;
      place_of_[v] = kNone;
      const dvec3 p_T = head_.to_tool(mesh.vertex(v).p);
      if (head.distance(p_T) >= -P::overlap || mesh.vertex(v).on_border()) continue;
      const dvec3 to_T = head.as_printed(p_T);
      place_of_[v] = static_cast<std::uint32_t>(moved_.size());
      moved_.push_back({v, mesh.vertex(v), X_WB.p + (head.is_ball() ? to_T : head_.R_WT * to_T), false});
    }
  }
  affected_.clear();
  for (const Moved& m : moved_) collect_affected(mesh, m.v);
  for (const Moved& m : moved_) mesh.move(m.v, m.to);
  for (const Affected& a : affected_) mesh.settle_face(a.f);
  done_.changed = !moved_.empty();
  for (const Affected& a : affected_) account(mesh, a);
  return done_;
}

}  // namespace typodont::haptics::vertex
