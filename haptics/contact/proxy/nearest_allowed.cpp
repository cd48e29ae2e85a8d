#include "haptics/contact/proxy/nearest_allowed.h"

#include <algorithm>
#include <cstring>

#include "engine/base/dispatch.h"
#include "haptics/lanes.h"

namespace typodont::haptics {

namespace {

constexpr int kBatch = RoughPlanes::kBatch;

/// The plane whose normal is closest to `n`, the first of equal ones.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
int most_along(const RoughPlanes* planes, int count, const float* n) {
  F8 most = F8{} - 2.0f;
  I8 index = {}, at = {0, 1, 2, 3, 4, 5, 6, 7};
  for (int k = 0; k < count; k += kBatch, at += 8) {
    F8 nx, ny, nz;
    std::memcpy(&nx, planes->nx + k, sizeof nx);
    std::memcpy(&ny, planes->ny + k, sizeof ny);
    std::memcpy(&nz, planes->nz + k, sizeof nz);
    const F8 along = nx * n[0] + ny * n[1] + nz * n[2];
    const I8 more = (along > most) & (at < count);
    most = more ? along : most;
    index = more ? at : index;
  }
  int best = 0;
  for (int lane = 1; lane < 8; ++lane) {
    if (most[lane] > most[best] || (most[lane] == most[best] && index[lane] < index[best])) best = lane;
  }
  return index[best];
}

/// The plane of least n·d + room if that is below -slip, the first of equal ones; else -1.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
int most_violated(const RoughPlanes* planes, int count, const float* d, float overlap, float slack, bool only_no_deeper,
                  float slip) {
  F8 least = F8{} - slip;
  I8 index = I8{} - 1, at = {0, 1, 2, 3, 4, 5, 6, 7};
  for (int k = 0; k < count; k += kBatch, at += 8) {
    F8 nx, ny, nz, room, yield;
    std::memcpy(&nx, planes->nx + k, sizeof nx);
    std::memcpy(&ny, planes->ny + k, sizeof ny);
    std::memcpy(&nz, planes->nz + k, sizeof nz);
    std::memcpy(&room, planes->gap + k, sizeof room);
    std::memcpy(&yield, planes->yields + k, sizeof yield);
    room = room + overlap + slack * yield;
    if (only_no_deeper) room = room > 0.0f ? room : F8{};
    const F8 e = nx * d[0] + ny * d[1] + nz * d[2] + room;
    const I8 less = (e < least) & (at < count);
    least = less ? e : least;
    index = less ? at : index;
  }
  int worst = 0;
  for (int lane = 1; lane < 8; ++lane) {
    if (least[lane] < least[worst] || (least[lane] == least[worst] && index[lane] < index[worst])) worst = lane;
  }
  return index[worst];
}

/// Projection onto a polyhedron in three dimensions by the dual active-set method (Goldfarb & Idnani 1983): starts at
/// the unconstrained answer, or at the one held by the guessed planes where all of them push, and adds the most
/// violated plane until none is; at most three are active at once.
class Projection {
 public:
  Projection(const ContactSet& set, const dvec3& c, double overlap, double slack, bool only_no_deeper)
      : set_(set), c_(c), overlap_(overlap), slack_(slack), only_no_deeper_(only_no_deeper) {}

  bool solve(const dvec3& target, dvec3& p, ActivePlanes& active) noexcept {
    k_ = 0;
    p = target;
    if (active.count > 0) start_with(active, p);
    const bool solved = add_planes(p);
    active.count = k_;
    for (int i = 0; i < k_; ++i) active.index[i] = index_[i], active.push[i] = push_[i];
    return solved;
  }

 private:
  double room(const ContactPlane& plane) const noexcept {
    const double room = plane.gap + overlap_ + slack_ * plane.yields;
    return only_no_deeper_ ? std::max(room, 0.0) : room;
  }
  double excess(const ContactPlane& plane, const dvec3& p) const noexcept {
    return glm::dot(plane.n, p - c_) + room(plane);
  }

  /// Index of the most violated plane, or -1.
  int worst(const dvec3& p) const noexcept {
    if (set_.count() == 1) return excess(set_.plane(0), p) < -1e-9 ? 0 : -1;
    const glm::vec3 d(p - c_);
    const int worst = most_violated(&set_.rough(), set_.count(), &d.x, static_cast<float>(overlap_),
                                    static_cast<float>(slack_), only_no_deeper_, 1e-6f + 3e-7f * glm::length(d));
    for (int i = 0; i < k_; ++i) {
      if (index_[i] == worst) return -1;  // holds already, but for rounding
    }
    return worst;
  }

  /// r: coordinates of v in the normals of the active planes, least squares. False where these depend on each other.
  bool coordinates(const dvec3& v, double (&r)[3]) const noexcept {
    double gram[3][4];
    for (int i = 0; i < k_; ++i) {
      for (int j = 0; j < k_; ++j) gram[i][j] = glm::dot(plane_[i].n, plane_[j].n);
      gram[i][k_] = glm::dot(plane_[i].n, v);
    }
    return solve_gram(gram, r);
  }
  /// False where the normals depend on each other.
  bool solve_gram(double (&gram)[3][4], double (&r)[3]) const noexcept {
    for (int i = 0; i < k_; ++i) {  // Gauss without pivoting: the Gram matrix of independent normals
      if (gram[i][i] < 1e-8) return false;
      for (int row = i + 1; row < k_; ++row) {
        const double f = gram[row][i] / gram[i][i];
        for (int col = i; col <= k_; ++col) gram[row][col] -= f * gram[i][col];
      }
    }
    for (int i = k_ - 1; i >= 0; --i) {
      r[i] = gram[i][k_];
      for (int j = i + 1; j < k_; ++j) r[i] -= gram[i][j] * r[j];
      r[i] /= gram[i][i];
    }
    return true;
  }

  /// The answer with just the guessed planes, if each of them pushes there.
  void start_with(const ActivePlanes& guess, dvec3& p) noexcept {
    k_ = guess.count;
    double gram[3][4], u[3] = {};
    for (int i = 0; i < k_; ++i) index_[i] = guess.index[i], plane_[i] = set_.plane(guess.index[i]);
    for (int i = 0; i < k_; ++i) {
      for (int j = 0; j < k_; ++j) gram[i][j] = glm::dot(plane_[i].n, plane_[j].n);
      gram[i][k_] = -excess(plane_[i], p);
    }
    bool pushes = solve_gram(gram, u);
    for (int i = 0; i < k_; ++i) pushes = pushes && u[i] > 0;
    if (!pushes) {
      k_ = 0;
      return;
    }
    for (int i = 0; i < k_; ++i) p += u[i] * plane_[i].n, push_[i] = u[i];
  }

  bool add_planes(dvec3& p) noexcept {
    for (int round = 0; round < 64; ++round) {
      const int next = worst(p);
      if (next < 0) return true;
      const ContactPlane added = set_.plane(next);
      double pushed = 0;
      for (int guard = 0; guard < 8; ++guard) {
        // z: what is left of the new normal beside the active ones; r: its coordinates in them.
        double r[3] = {};
        dvec3 z = added.n;
        if (k_ > 0) {
          if (!coordinates(z, r)) return false;
          for (int i = 0; i < k_; ++i) z -= r[i] * plane_[i].n;
        }
        const double z2 = glm::dot(z, z);
        double partial = 1e300;
        int leaving = -1;
        for (int i = 0; i < k_; ++i) {
          if (r[i] > 1e-12 && push_[i] / r[i] < partial) partial = push_[i] / r[i], leaving = i;
        }
        const double full = (k_ < 3 && z2 > 1e-8) ? -excess(added, p) / z2 : 1e300;
        const double t = std::min(partial, full);
        if (t >= 1e299) return false;
        if (full < 1e299) p += t * z;
        for (int i = 0; i < k_; ++i) push_[i] -= t * r[i];
        pushed += t;
        if (full <= partial) {
          index_[k_] = next, plane_[k_] = added, push_[k_] = pushed;
          ++k_;
          break;
        }
        for (int i = leaving; i + 1 < k_; ++i)
          index_[i] = index_[i + 1], plane_[i] = plane_[i + 1], push_[i] = push_[i + 1];
        --k_;
      }
    }
    return false;
  }

  const ContactSet& set_;
  dvec3 c_;
  double overlap_, slack_;
  bool only_no_deeper_;
  int k_ = 0;  // active planes
  int index_[3];
  ContactPlane plane_[3];
  double push_[3];
};

}  // namespace

ActivePlanes guess_active(const ContactSet& set, const HeldBy& before) noexcept {
  ActivePlanes guess;
  if (set.count() < 2) return guess;
  for (int i = 0; i < before.count; ++i) {
    const glm::vec3 n(before.n[i]);
    const int index = most_along(&set.rough(), set.count(), &n.x);
    if (std::find(guess.index, guess.index + guess.count, index) == guess.index + guess.count) {
      guess.index[guess.count++] = index;
    }
  }
  return guess;
}

void held_by(const ContactSet& set, const ActivePlanes& active, HeldBy& held) noexcept {
  for (held.count = 0; held.count < active.count; ++held.count)
    held.n[held.count] = set.plane(active.index[held.count]).n;
}

dvec3 nearest_allowed(const ContactSet& set, const dvec3& c, double overlap, double slack, const dvec3& target,
                      ActivePlanes& active) noexcept {
  dvec3 p;
  if (Projection(set, c, overlap, slack, false).solve(target, p, active)) return p;
  active.count = 0;
  if (Projection(set, c, overlap, slack, true).solve(target, p, active)) return p;
  return c;
}

}  // namespace typodont::haptics
