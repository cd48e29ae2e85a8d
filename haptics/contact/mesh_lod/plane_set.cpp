#include "haptics/contact/mesh_lod/plane_set.h"

#include <algorithm>

namespace typodont::haptics::mesh_lod {

namespace {

constexpr double kSlip = 1e-13;         // m that a plane may be overstepped by
constexpr double kIndependent = 1e-10;  // squared sine below which a normal depends on the others
constexpr int kMostRounds = 64;

/// Coordinates r of v in the normals n[0..k), least squares. False where these depend on each other.
bool coordinates(const dvec3* n, int k, const dvec3& v, double* r) noexcept {
  double gram[3][4];
  for (int i = 0; i < k; ++i) {
    for (int j = 0; j < k; ++j) gram[i][j] = glm::dot(n[i], n[j]);
    gram[i][k] = glm::dot(n[i], v);
  }
  for (int i = 0; i < k; ++i) {
    if (gram[i][i] < kIndependent) return false;
    for (int row = i + 1; row < k; ++row) {
      const double f = gram[row][i] / gram[i][i];
      for (int col = i; col <= k; ++col) gram[row][col] -= f * gram[i][col];
    }
  }
  for (int i = k - 1; i >= 0; --i) {
    r[i] = gram[i][k];
    for (int j = i + 1; j < k; ++j) r[i] -= gram[i][j] * r[j];
    r[i] /= gram[i][i];
  }
  return true;
}

}  // namespace

// Projection onto a polyhedron by the dual active-set method (Goldfarb & Idnani 1983): starts at the goal, adds the
// most violated plane until none is; at most three hold at once.
dvec3 PlaneSet::nearest_allowed(const dvec3& goal, Active& active) const noexcept {
  active.count = 0;
  dvec3 x = goal, n[3];
  for (int round = 0; round < kMostRounds; ++round) {
    int next = -1;
    double least = -kSlip;
    for (int i = 0; i < count_; ++i) {
      const double excess = glm::dot((*this)[i].n, x) + (*this)[i].room;
      if (excess >= least) continue;
      const auto held = std::find(active.index.begin(), active.index.begin() + active.count, i);
      if (held == active.index.begin() + active.count) next = i, least = excess;
    }
    if (next < 0) return x;
    const Plane& added = (*this)[next];
    double pushed = 0;
    for (;;) {
      // z: what is left of the new normal beside those that hold; r: its coordinates in them.
      double r[3] = {};
      dvec3 z = added.n;
      if (!coordinates(n, active.count, z, r)) return active.count = 0, dvec3(0);
      for (int i = 0; i < active.count; ++i) z -= r[i] * n[i];
      const double z2 = glm::dot(z, z);
      double partial = 1e300;
      int leaving = -1;
      for (int i = 0; i < active.count; ++i) {
        const double push = active.push[static_cast<std::size_t>(i)];
        if (r[i] > 1e-12 && push / r[i] < partial) partial = push / r[i], leaving = i;
      }
      const bool room_for_one = active.count < 3 && z2 > kIndependent;
      const double full = room_for_one ? -(glm::dot(added.n, x) + added.room) / z2 : 1e300;
      if (!room_for_one && leaving < 0) return active.count = 0, dvec3(0);  // nothing is allowed
      const double step = std::min(partial, full);
      if (room_for_one) x += step * z;
      for (int i = 0; i < active.count; ++i) active.push[static_cast<std::size_t>(i)] -= step * r[i];
      pushed += step;
      if (full <= partial) {
        const auto k = static_cast<std::size_t>(active.count++);
        active.index[k] = next, active.push[k] = pushed, n[k] = added.n;
        break;
      }
      for (int i = leaving; i + 1 < active.count; ++i) {
        const auto k = static_cast<std::size_t>(i);
        active.index[k] = active.index[k + 1], active.push[k] = active.push[k + 1], n[k] = n[k + 1];
      }
      --active.count;
    }
  }
  return active.count = 0, dvec3(0);
}

}  // namespace typodont::haptics::mesh_lod
