// Included once in each namespace of lane_ops.h, after cut_kernel.h and depth_kernel.h. Cuts the blocks of a leaf.

/// Result for a block whose samples were raised. `emptied`: a sample became air.
struct RaisedBlock {
  bool changed, emptied;
};

/// Raises each sample of a block to its depth in the head, without computing removed volume and safe travel. Call it
/// only if no sample was deeper during the motion than at its end. `depth_of(rho, z)`: depth of samples in the head.
template <class Depth>
TYPODONT_INLINE RaisedBlock raise_leaf_block(const HeadPose& pose, const HeadBlock& block, const Depth& depth_of) {
  constexpr int n = Sweep::kLeaf, kTogether = kLanes / kRowLength, kGroups = kRows / kTogether;
  static_assert(n == kRowLength && kGroups * kTogether == kRows);
  // Rows along y are consecutive in memory, so a group may consist of two rows.
  struct Lanes {
    Floats x, y, z, bound;
  };
  alignas(64) float height[kLanes], bound_z[kLanes];
  for (int i = 0; i < kLanes; ++i) {
    height[i] = static_cast<float>(block.first.z) + static_cast<float>(i % kRowLength) - pose.p[2];
    bound_z[i] = block.bound + static_cast<float>(i % kRowLength) * block.bound_z;
  }
  const Floats vz = load(height);
  const Floats along_x = all(pose.R[6]) * vz, along_y = all(pose.R[7]) * vz, along_z = all(pose.R[8]) * vz;
  Lanes group[kGroups];
  for (int g = 0; g < kGroups; ++g) {
    alignas(64) float vy[kLanes], bound[kLanes];
    for (int i = 0; i < kLanes; ++i) {
      const int iy = g * kTogether + i / kRowLength;
      vy[i] = static_cast<float>(block.first.y + iy) - pose.p[1];
      bound[i] = bound_z[i] + static_cast<float>(iy) * block.bound_y;
    }
    group[g] = {all(pose.R[3]) * load(vy), all(pose.R[4]) * load(vy), all(pose.R[5]) * load(vy), load(bound)};
  }
  const Floats zero = all(0.0f), inner = all(Sweep::kInner), margin = all(-Sweep::kMargin);
  float turn[3];
  std::memcpy(turn, pose.R, sizeof turn);
  const int first_x = block.first.x;
  const float p_x = pose.p[0], bound_x = block.bound_x;
  float* const samples = block.distance + block.at;
  Mask raised = nowhere(), emptied = nowhere();
  for (int ix = 0; ix < kRows; ++ix) {
    const float vx = static_cast<float>(first_x + ix) - p_x;
    const Floats x0 = all(turn[0] * vx), y0 = all(turn[1] * vx), z0 = all(turn[2] * vx);
    const Floats more_bound = all(static_cast<float>(ix) * bound_x);
    for (int g = 0; g < kGroups; ++g) {
      float* const at = samples + ix * n * n + g * kLanes;
      const Lanes& lanes = group[g];
      const Floats old = load(at), least = greater(old, margin);
      if (!any(more(lesser(lanes.bound + more_bound, inner), least))) continue;
      const Floats x = (x0 + lanes.x) + along_x, y = (y0 + lanes.y) + along_y, z = (z0 + lanes.z) + along_z;
      const Floats depth = lesser(depth_of(root(x * x + y * y), z), inner);
      const Mask rises = more(depth, least);
      if (!any(rises)) continue;
      const Floats now = pick(rises, depth, old);
      store(at, now);
      raised |= rises;
      emptied |= more(zero, old) & no_less(now, zero);
    }
  }
  return {any(raised), any(emptied)};
}

/// Raises each sample of a block to its depth below the meridian pieces that `block.kind` selects.
TYPODONT_INLINE RaisedBlock raise_leaf_block(const HeadPose& pose, const HeadBlock& block) {
  if (block.kind >= kManyPieces) {
    const auto set = static_cast<unsigned>(block.kind - kManyPieces);
    return raise_leaf_block(
        pose, block, [&](const Floats& rho, const Floats& z) __attribute__((always_inline)) {
          return depth_below_pieces(block.pieces, set, rho, z);
        });
  }
  // a copy, so that the compiler knows that writing samples does not change it
  const MeridianPiece piece = block.pieces[block.kind];
  if (piece.radius == 0.0f) {
    return raise_leaf_block(
        pose, block, [&](const Floats& rho, const Floats& z) __attribute__((always_inline)) {
          return depth_below_line(piece, rho, z);
        });
  }
  return raise_leaf_block(
      pose, block, [&](const Floats& rho, const Floats& z) __attribute__((always_inline)) {
        return depth_below_arc(piece, rho, z);
      });
}
