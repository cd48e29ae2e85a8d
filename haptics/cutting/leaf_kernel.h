// This file is included once in each namespace of lane_ops.h, that is, once for each vector width, after cut_kernel.h.
// It raises the samples of one leaf (8³ samples) of the tissue to their depth in a ball.

/// The y and z terms in the distance of a leaf's samples from the ball. They are the same in all eight planes of
/// constant x, so they are computed once for the 64 samples of a plane. The index of a sample in the arrays is 8 y + z.
struct LeafPlane {
  alignas(64) float along_y[64], along_z[64], apart_y[64], apart_z[64];
};

/// Centres of the groups of a leaf, relative to the leaf's first sample. A group is the set of kLanes samples that one
/// vector contains: one or two neighbouring rows of a plane of constant x. The third coordinate is always 3.5.
struct LeafGroups {
  static constexpr int kCount = Sweep::kLeaf * Sweep::kLeaf * Sweep::kLeaf / kLanes;
  static constexpr int kRowsTogether = kLanes / Sweep::kLeaf;
  // voxels, distances from the centre of a group to its outermost samples along y, along z, and in any direction
  // (rounded up)
  static constexpr float kHalfY = 0.5f * (kRowsTogether - 1), kHalfZ = 3.5f, kHalf = 3.54f;
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

/// Returns a mask of the groups of a leaf that may contain samples which the sweep raises: those that come close enough
/// to the ball, and that are not completely behind A, the start of the sweep. The kernel omits the other groups.
TYPODONT_KERNEL std::uint64_t groups_near(const Capsule& c, const glm::ivec3& lo) {
  const float length2 = c.abx * c.abx + c.aby * c.aby + c.abz * c.abz, length = std::sqrt(length2);
  // The last term of each sum exceeds all rounding errors.
  const float reach = c.radius + Sweep::kMargin + length + (LeafGroups::kHalf + 1e-2f);
  const float ahead = std::abs(c.aby) * LeafGroups::kHalfY + std::abs(c.abz) * LeafGroups::kHalfZ + 1e-3f * length;
  const float px = static_cast<float>(lo.x) - c.ax, py = static_cast<float>(lo.y) - c.ay,
              pz = static_cast<float>(lo.z) + LeafGroups::kHalfZ - c.az;
  const float off_z = pz - c.abz, along_z = pz * c.abz;
  const Floats least_along = all((c.continues ? 0.0f : -1e30f) - ahead), most2 = all(reach * reach - off_z * off_z);
  std::uint64_t near = 0;
  for (int i = 0; i < LeafGroups::kCount; i += kLanes) {
    const Floats x = load(kLeafGroups.x + i) + all(px), y = load(kLeafGroups.y + i) + all(py);
    const Floats off_x = x - all(c.abx), off_y = y - all(c.aby);
    const Mask both = more(most2, off_x * off_x + off_y * off_y) &
                      more((x * all(c.abx) + y * all(c.aby)) + all(along_z), least_along);
    near |= static_cast<std::uint64_t>(bits(both)) << i;
  }
  return near;
}

/// Raises the samples of a leaf (8³ samples). `capsule`: false if the ball moves so little (Sweep::is_ball) that its
/// end position alone is accurate enough.
template <bool capsule>
TYPODONT_KERNEL Sweep::LeafCut carve_leaf(const Capsule& c, const glm::ivec3& lo, float* distance) {
  constexpr int n = Sweep::kLeaf;
  static_assert(n * n == 64 && n * n % kLanes == 0);
  LeafPlane plane;
  for (int y = 0; y < n; ++y) {
    const float py = static_cast<float>(lo.y + y) - c.ay, qy = py - c.aby;
    for (int z = 0; z < n; ++z) {
      const float height = static_cast<float>(lo.z + z) - c.az, off = height - c.abz;
      plane.along_y[n * y + z] = py * c.aby;
      plane.along_z[n * y + z] = height * c.abz;
      plane.apart_y[n * y + z] = capsule ? py : qy * qy;
      plane.apart_z[n * y + z] = capsule ? height : off * off;
    }
  }
  const Floats from = all(c.continues ? 0.0f : -1e30f), radius = all(c.radius), zero = all(0.0f);
  const Floats inner = all(Sweep::kInner), never = all(1e9f);
  float along_x[n], apart_x[n];
  for (int x = 0; x < n; ++x) {
    const float px = static_cast<float>(lo.x + x) - c.ax, qx = px - c.abx;
    along_x[x] = px * c.abx;
    apart_x[x] = capsule ? px : qx * qx;
  }
  // Calls visit(position of the first sample, depths, mask) for the samples of a group. The mask marks the samples
  // ahead of A, the start of the sweep.
  const auto visit_group = [&](int group, const auto& visit) __attribute__((always_inline)) {
    const int first = group * kLanes, x = first / (n * n), i = first % (n * n);
    const Floats dot = (all(along_x[x]) + load(plane.along_y + i)) + load(plane.along_z + i);
    Floats d2;
    if constexpr (capsule) {
      const Floats s = lesser(greater(dot * all(c.inverse_length2), zero), all(1.0f));
      const Floats dx = all(apart_x[x]) - s * all(c.abx), dy = load(plane.apart_y + i) - s * all(c.aby),
                   dz = load(plane.apart_z + i) - s * all(c.abz);
      d2 = dx * dx + dy * dy + dz * dz;
    } else {
      d2 = (all(apart_x[x]) + load(plane.apart_y + i)) + load(plane.apart_z + i);
    }
    visit(distance + first, lesser(radius - root(d2), inner), more(dot, from));
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
  // A raised sample lies at the head's surface, so any motion may raise it again. So its slack (the motion until it can
  // change) is 0.
  if (any(raised)) return {true, any(emptied), 0};
  Floats least_slack = never;
  const auto take_slack = [&](const float* at, const Floats& depth, const Mask&) __attribute__((always_inline)) {
    // slack: how far the head must still approach before the sample changes; a sample that has the largest value,
    // kInner (3 voxels), never changes
    const Floats now = load(at);
    least_slack = lesser(least_slack, pick(no_less(now, inner), never, greater(now, all(-Sweep::kMargin)) - depth));
  };
  for (int group = 0; group < LeafGroups::kCount; ++group) visit_group(group, take_slack);
  alignas(64) float slack[kLanes];
  store(slack, least_slack);
  return {false, false, *std::min_element(slack, slack + kLanes)};
}
