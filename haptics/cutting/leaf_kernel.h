// This file is included once in each namespace of lane_ops.h, that is, once for each vector width, after cut_kernel.h.
// It raises the samples of one leaf (8³ samples) of the tissue to their depth in a ball.

/// The y and z terms in the distance of a leaf's samples from the ball. They are the same in all eight planes of
/// constant x, so they are computed once for the 64 samples of a plane. The index of a sample in the arrays is 8 y + z.
struct LeafPlane {
  alignas(64) float along_y[64], along_z[64], apart_y[64], apart_z[64];
};

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
  // Calls visit(position of the first sample, depths, mask) for all samples, kLanes at a time. The mask marks the
  // samples ahead of A, the start of the sweep.
  const auto for_each = [&](const auto& visit) __attribute__((always_inline)) {
    for (int x = 0; x < n; ++x) {
      const float px = static_cast<float>(lo.x + x) - c.ax, qx = px - c.abx;
      const Floats along_x = all(px * c.abx), apart_x = all(capsule ? px : qx * qx);
      for (int i = 0; i < n * n; i += kLanes) {
        const Floats dot = (along_x + load(plane.along_y + i)) + load(plane.along_z + i);
        Floats d2;
        if constexpr (capsule) {
          const Floats s = lesser(greater(dot * all(c.inverse_length2), zero), all(1.0f));
          const Floats dx = apart_x - s * all(c.abx), dy = load(plane.apart_y + i) - s * all(c.aby),
                       dz = load(plane.apart_z + i) - s * all(c.abz);
          d2 = dx * dx + dy * dy + dz * dz;
        } else {
          d2 = (apart_x + load(plane.apart_y + i)) + load(plane.apart_z + i);
        }
        visit(distance + x * n * n + i, lesser(radius - root(d2), inner), more(dot, from));
      }
    }
  };
  Mask raised = nowhere(), emptied = nowhere();
  for_each([&](float* at, const Floats& depth, const Mask& ahead) __attribute__((always_inline)) {
    const Floats old = load(at);
    Floats least;
    Mask rises;
    const Floats now = raised_to(old, depth, ahead, least, rises);
    store(at, now);
    raised |= rises;
    emptied |= more(zero, old) & no_less(now, zero);
  });
  // A raised sample lies at the head's surface, so any motion may raise it again. So its slack (the motion until it can
  // change) is 0.
  if (any(raised)) return {true, any(emptied), 0};
  Floats least_slack = never;
  for_each([&](const float* at, const Floats& depth, const Mask&) __attribute__((always_inline)) {
    // slack: how far the head must still approach before the sample changes; a sample that has the largest value,
    // kInner (3 voxels), never changes
    const Floats now = load(at);
    least_slack = lesser(least_slack, pick(no_less(now, inner), never, greater(now, all(-Sweep::kMargin)) - depth));
  });
  alignas(64) float slack[kLanes];
  store(slack, least_slack);
  return {false, false, *std::min_element(slack, slack + kLanes)};
}
