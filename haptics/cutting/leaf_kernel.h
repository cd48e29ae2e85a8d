// Included once in each namespace of lane_ops.h. Cuts by a ball in a leaf.
#include "haptics/cutting/cut_kernel.h"

/// Centres of a leaf's groups of samples, relative to its first sample, voxels. A group is one row of eight samples
/// along z, or two rows that are neighbours along y. So z is 3.5 for all centres.
struct LeafGroups {
  static constexpr int kCount = Sweep::kLeaf * Sweep::kLeaf * Sweep::kLeaf / kLanes;
  static constexpr int kRowsTogether = kLanes / Sweep::kLeaf;
  // voxels: half the size of a group along y and along z, and the sum of both squares, rounded up
  static constexpr float kHalfY = 0.5f * (kRowsTogether - 1), kHalfZ = 3.5f, kHalf2 = 12.51f;
  alignas(64) float x[kCount], y[kCount];
  constexpr LeafGroups() : x(), y() {
    constexpr int in_plane = Sweep::kLeaf / kRowsTogether;
    for (int i = 0; i < kCount; ++i) {
      x[i] = static_cast<float>(i / in_plane);
      y[i] = static_cast<float>(i % in_plane * kRowsTogether) + kHalfY;
    }
  }
};
constexpr LeafGroups kLeafGroups;

/// Bit mask of the groups that the cut may change: not too far away, not behind the motion's start A, and not inside
/// the ball at A, where all samples already have the value kInner.
TYPODONT_INLINE std::uint64_t groups_near(const Capsule& c, const glm::ivec3& lo) {
  constexpr float kHalfY = LeafGroups::kHalfY, kHalfZ = LeafGroups::kHalfZ;
  const float length2 = c.abx * c.abx + c.aby * c.aby + c.abz * c.abz, length = std::sqrt(length2);
  // The terms 1e-2 are larger than all rounding errors.
  const float reach = c.radius + Sweep::kMargin + length + 1e-2f, inner = c.radius - Sweep::kInner - 1e-2f;
  const float ahead = std::abs(c.aby) * kHalfY + std::abs(c.abz) * kHalfZ + 1e-3f * length;
  const float px = static_cast<float>(lo.x) - c.ax, py = static_cast<float>(lo.y) - c.ay,
              pz = static_cast<float>(lo.z) + kHalfZ - c.az;
  const float off_z = pz - c.abz, along_z = pz * c.abz;
  // Bounds of a sample's squared distance from A or B, if d is the vector from there to the centre of its group:
  // d² - s to d² + s + kHalf2, where s = 2 (kHalfY |d.y| + kHalfZ |d.z|).
  const Floats min_along = all((c.continues ? 0.0f : -1e30f) - ahead);
  const Floats most2 = all(reach * reach - off_z * off_z + 2 * kHalfZ * std::abs(off_z));
  const Floats hole2 =
      all(c.continues && inner > 0 ? inner * inner - pz * pz - 2 * kHalfZ * std::abs(pz) - LeafGroups::kHalf2 : -1e30f);
  std::uint64_t near = 0;
  for (int i = 0; i < LeafGroups::kCount; i += kLanes) {
    const Floats x = load(kLeafGroups.x + i) + all(px), y = load(kLeafGroups.y + i) + all(py);
    const Floats off_x = x - all(c.abx), off_y = y - all(c.aby), zero = all(0.0f), edge = all(2 * kHalfY);
    const Floats least2 = (off_x * off_x + off_y * off_y) - edge * greater(off_y, zero - off_y);
    const Floats greatest2 = (x * x + y * y) + edge * greater(y, zero - y);
    const Mask both = more(most2, least2) & more((x * all(c.abx) + y * all(c.aby)) + all(along_z), min_along) &
                      no_less(greatest2, hole2);
    near |= static_cast<std::uint64_t>(bits(both)) << i;
  }
  return near;
}

/// `capsule` false: only the ball at the motion's end B is cut (Sweep::is_ball).
template <bool capsule>
TYPODONT_INLINE Sweep::LeafCut carve_leaf(const Capsule& c, const glm::ivec3& lo, float* distance) {
  constexpr int n = Sweep::kLeaf, kTogether = LeafGroups::kRowsTogether, kInPlane = n / kTogether;
  // Parts of the distances that depend only on y, or only on z. The parts for z are the same for all rows.
  float y_along[n], y_apart[n];
  alignas(64) float z_along[kLanes], z_apart[kLanes];
  for (int y = 0; y < n; ++y) {
    const float py = static_cast<float>(lo.y + y) - c.ay, qy = py - c.aby;
    y_along[y] = py * c.aby;
    y_apart[y] = capsule ? py : qy * qy;
  }
  for (int i = 0; i < kLanes; ++i) {
    const float height = static_cast<float>(lo.z + i % n) - c.az, off = height - c.abz;
    z_along[i] = height * c.abz;
    z_apart[i] = capsule ? height : off * off;
  }
  const Floats along_z = load(z_along), apart_z = load(z_apart);
  Floats along_y[kInPlane], apart_y[kInPlane];
  for (int i = 0; i < kInPlane; ++i) {
    const int first_row = i * kTogether, last_row = first_row + kTogether - 1;
    along_y[i] = pick(first(n), all(y_along[first_row]), all(y_along[last_row]));
    apart_y[i] = pick(first(n), all(y_apart[first_row]), all(y_apart[last_row]));
  }
  const Floats from = all(c.continues ? 0.0f : -1e30f), radius = all(c.radius), zero = all(0.0f);
  const Floats inner = all(Sweep::kInner), never = all(1e9f);
  float along_x[n], apart_x[n];
  for (int x = 0; x < n; ++x) {
    const float px = static_cast<float>(lo.x + x) - c.ax, qx = px - c.abx;
    along_x[x] = px * c.abx;
    apart_x[x] = capsule ? px : qx * qx;
  }
  // Calls visit() with a pointer to the group's samples, their depths in the ball, and a mask: ahead of the start A.
  const auto visit_group = [&](int group, const auto& visit) __attribute__((always_inline)) {
    const int x = group / kInPlane, i = group % kInPlane;
    const Floats dot = (all(along_x[x]) + along_y[i]) + along_z;
    Floats d2;
    if constexpr (capsule) {
      const Floats s = lesser(greater(dot * all(c.inverse_length2), zero), all(1.0f));
      const Floats dx = all(apart_x[x]) - s * all(c.abx), dy = apart_y[i] - s * all(c.aby),
                   dz = apart_z - s * all(c.abz);
      d2 = dx * dx + dy * dy + dz * dz;
    } else {
      d2 = (all(apart_x[x]) + apart_y[i]) + apart_z;
    }
    visit(distance + group * kLanes, lesser(radius - root(d2), inner), more(dot, from));
  };
  Mask raised = nowhere(), emptied = nowhere();
  const auto raise = [&](float* at, const Floats& depth, const Mask& ahead) __attribute__((always_inline)) {
    const Floats old = load(at);
    Floats least;
    Mask rises;
    const Floats now = raised_to(old, depth, ahead, least, rises);
    store(at, now);
    raised |= rises;
    emptied |= more(zero, old) & no_less(now, zero);
  };
  for (std::uint64_t left = groups_near(c, lo); left != 0; left &= left - 1) visit_group(std::countr_zero(left), raise);
  // The changed samples are at the ball's surface. Any further motion can change them, so the safe travel is 0.
  if (any(raised)) return {true, any(emptied), 0};
  Floats min_safe_travel = never;
  const auto take_safe_travel = [&](const float* at, const Floats& depth, const Mask&) __attribute__((always_inline)) {
    // Voxels by which the ball must approach before a sample changes. A sample with the value kInner never changes.
    const Floats now = load(at);
    min_safe_travel =
        lesser(min_safe_travel, pick(no_less(now, inner), never, greater(now, all(-Sweep::kMargin)) - depth));
  };
  for (int group = 0; group < LeafGroups::kCount; ++group) visit_group(group, take_safe_travel);
  alignas(64) float safe_travel[kLanes];
  store(safe_travel, min_safe_travel);
  return {false, false, *std::min_element(safe_travel, safe_travel + kLanes)};
}
