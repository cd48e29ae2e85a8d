#include "haptics/contact/proxy/nearest_allowed.h"

#include <algorithm>
#include <cstring>

#include "engine/base/dispatch.h"
#include "haptics/cutting/lanes.h"

namespace typodont::haptics {

namespace {

constexpr int kBatch = ApproximatePlanes::kBatch;

/// Index of the plane whose normal is most similar to `n`; if several are equal, the first one.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
int max_along(const ApproximatePlanes* planes, int count, const float* n) {
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

/// Index of the most violated plane (of equal ones, the first); -1 if n·d + room ≥ -slip for all planes. n: a plane's
/// normal; `d`: displacement of the head; room: how far the head may move against n; `slip`: tolerance.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
int max_violated(const ApproximatePlanes* planes, int count, const float* d, float overlap, float allowed_depth,
                 bool only_no_deeper, float slip) {
  F8 least = F8{} - slip;
  I8 index = I8{} - 1, at = {0, 1, 2, 3, 4, 5, 6, 7};
  for (int k = 0; k < count; k += kBatch, at += 8) {
    F8 nx, ny, nz, allowed_motion, yield;
    std::memcpy(&nx, planes->nx + k, sizeof nx);
    std::memcpy(&ny, planes->ny + k, sizeof ny);
    std::memcpy(&nz, planes->nz + k, sizeof nz);
    std::memcpy(&allowed_motion, planes->gap + k, sizeof allowed_motion);
    std::memcpy(&yield, planes->yields + k, sizeof yield);
    allowed_motion = allowed_motion + overlap + allowed_depth * yield;
    if (only_no_deeper) allowed_motion = allowed_motion > 0.0f ? allowed_motion : F8{};
    const F8 e = nx * d[0] + ny * d[1] + nz * d[2] + allowed_motion;
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

/// Presents the contacts of a head to the active-set solver as planes that limit the position p of the head's centre,
/// in voxels. `only_no_deeper`: the head need not leave planes that it overlaps already, but may not sink deeper.
class HeadPlanes {
 public:
  using Plane = ContactPlane;
  // Limits below which the normals of planes count as linearly dependent (see ActiveSetLimits). They correspond to the
  // accuracy of normals in single precision.
  static constexpr ActiveSetLimits kLimits = {.min_pivot = 1e-8, .min_rest = 1e-8};

  HeadPlanes(const ContactSet& set, const dvec3& c, double overlap, double allowed_depth, bool only_no_deeper)
      : set_(set), c_(c), overlap_(overlap), allowed_depth_(allowed_depth), only_no_deeper_(only_no_deeper) {}

  ContactPlane plane(int i) const noexcept { return set_.plane(i); }
  double excess(const ContactPlane& plane, const dvec3& p) const noexcept {
    return glm::dot(plane.n, p - c_) + allowed_motion(plane);
  }
  int worst(const dvec3& p, const int* active, int count) const noexcept {
    if (set_.count() == 1) return excess(set_.plane(0), p) < -1e-9 ? 0 : -1;
    const glm::vec3 d(p - c_);
    const int worst = max_violated(&set_.approximate(), set_.count(), &d.x, static_cast<float>(overlap_),
                                   static_cast<float>(allowed_depth_), only_no_deeper_, 1e-6f + 3e-7f * glm::length(d));
    return std::find(active, active + count, worst) == active + count ? worst : -1;
  }

 private:
  double allowed_motion(const ContactPlane& plane) const noexcept {
    const double allowed_motion = plane.gap + overlap_ + allowed_depth_ * plane.yields;
    return only_no_deeper_ ? std::max(allowed_motion, 0.0) : allowed_motion;
  }

  const ContactSet& set_;
  dvec3 c_;
  double overlap_, allowed_depth_;
  bool only_no_deeper_;
};

}  // namespace

ActivePlanes guess_active(const ContactSet& set, const HeldBy& before) noexcept {
  ActivePlanes guess;
  if (set.count() < 2) return guess;
  for (int i = 0; i < before.count; ++i) {
    const glm::vec3 n(before.n[i]);
    const int index = max_along(&set.approximate(), set.count(), &n.x);
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

dvec3 nearest_allowed(const ContactSet& set, const dvec3& c, double overlap, double allowed_depth, const dvec3& target,
                      ActivePlanes& active) noexcept {
  dvec3 p;
  if (ActiveSet(HeadPlanes(set, c, overlap, allowed_depth, false)).solve(target, p, active)) return p;
  active.count = 0;
  if (ActiveSet(HeadPlanes(set, c, overlap, allowed_depth, true)).solve(target, p, active)) return p;
  return c;
}

}  // namespace typodont::haptics
