// Included once in each namespace with eight lanes, after cut_kernel.h, depth_kernel.h, row_kernel.h and path_kernel.h.

/// Raises each sample to max(old, min(depth, kInner)), ignoring depths below -kMargin (kInner 3, kMargin 3.5 voxels).
/// Returns true if a sample changed. `may_raise` false: changes no sample. `found`: receives the distance that the head
/// can move before a sample changes. `tops`: receives samples that may have been deeper earlier in the motion.
TYPODONT_INLINE bool carve_head_block(const HeadPose& pose, const HeadBlock& block, bool may_raise, PathMaxima& tops,
                                      RemovedVolume* removed, BlockSafeTravel& found) {
  static_assert(kLanes == kRowLength);
  alignas(32) constexpr float kSteps[] = {0, 1, 2, 3, 4, 5, 6, 7};
  const int* const from = block.from;
  const int* const to = block.to;
  const bool whole = from[2] == 0 && to[2] == kRowLength;
  const float* const R = pose.R;
  const Floats steps = load(kSteps), zero = all(0.0f), inner = all(Sweep::kInner), no_end = all(kNoEnd);
  const Floats vz = all(static_cast<float>(block.first.z)) + steps - all(pose.p[2]);
  const Floats along_x = all(R[6]) * vz, along_y = all(R[7]) * vz, along_z = all(R[8]) * vz;
  const Floats bound = all(block.bound) + steps * all(block.bound_z);
  const MeridianPiece* const pieces = block.pieces;
  const MeridianPiece& only = pieces[block.kind < kManyPieces ? block.kind : 0];
  bool changed = false;
  Taken taken{removed};
  Floats min_safe_travel = no_end;
  Mask emptied = nowhere();
  const bool beside = block.beside && may_raise;
  if (beside) tops.make_room(kRows * kRows * kRowLength);
  const float near = found.ahead, looked_at = beside ? std::max(near, kTop - block.slowest) : near;
  for (int ix = from[0]; ix < to[0]; ++ix) {
    for (int iy = from[1]; iy < to[1]; ++iy) {
      float* const row = block.distance + (block.at + ix * block.stride_x + iy * block.stride_y);
      const Row samples{row, from[2], to[2], whole};
      const Floats old = samples.read();
      const float bound_here = static_cast<float>(ix) * block.bound_x + static_cast<float>(iy) * block.bound_y;
      const Floats most = lesser(bound + all(bound_here), inner);
      const Floats least = greater(old, all(-Sweep::kMargin));
      const Mask full = no_less(old, inner);  // the sample already has the largest value
      Floats travel = pick(full, no_end, least - most);
      if (any(more(all(looked_at), travel))) {
        const float vx = static_cast<float>(block.first.x + ix) - pose.p[0];
        const float vy = static_cast<float>(block.first.y + iy) - pose.p[1];
        const Floats x = all(R[0] * vx + R[3] * vy) + along_x, y = all(R[1] * vx + R[4] * vy) + along_y;
        const Floats z = all(R[2] * vx + R[5] * vy) + along_z;
        const Floats rho = root(x * x + y * y);
        Floats depth;
        if (block.kind >= kManyPieces) {
          depth = depth_below_pieces(pieces, static_cast<unsigned>(block.kind - kManyPieces), rho, z);
        } else if (only.radius == 0.0f) {
          depth = depth_below_line(only, rho, z);
        } else {
          depth = depth_below_arc(only, rho, z);
        }
        if (beside) {
          const Mask close =
              more_where(more(inner, depth), depth, least + all(block.slowest - kTop)) & more(inner, old);
          if (any(close)) {
            const float* const T = tops.back.turn;
            const float* const shift = tops.back.shift;
            const Floats motion_x = all(T[0]) * x + all(T[3]) * y + (all(T[6]) * z + all(shift[0])),
                         motion_y = all(T[1]) * x + all(T[4]) * y + (all(T[7]) * z + all(shift[1]));
            const Floats motion_z = all(T[2]) * x + all(T[5]) * y + (all(T[8]) * z + all(shift[2]));
            const unsigned set =
                block.kind < kManyPieces ? 1u << block.kind : static_cast<unsigned>(block.kind - kManyPieces);
            const Mask deeper = nearest_on_path(pieces, set, rho, z, x * motion_x + y * motion_y, rho * motion_z)
                                    .deeper(rho, depth, least);
            for (unsigned left = bits(close & deeper); left != 0; left &= left - 1) {
              const int i = std::countr_zero(left);
              const std::uint8_t label =
                  removed ? static_cast<std::uint8_t>(shown(block.tissue[row - block.distance + i])) : std::uint8_t{0};
              tops.add(static_cast<float>(block.first.x + ix), static_cast<float>(block.first.y + iy),
                       static_cast<float>(block.first.z + i), row + i, label);
            }
          }
        }
        depth = lesser(depth, inner);
        // moving: the depth, but −kNoEnd (far outside) where this motion along the axis changes nothing. The bits
        // found.live describe only this motion, so they use `moving`. Safe travel describes all motions: `depth`.
        const Floats moving = unless_still(depth, rho, z, tops.back.still_above, tops.back.still_beyond);
        const Mask raised = more(moving, least);
        travel = pick(raised, zero, least - depth);
        travel = pick(full | no_less(depth, inner), no_end, travel);
        if (found.live) {
          // prefetches the tissue labels of the samples, which are needed soon
          __builtin_prefetch(block.tissue + (row - block.distance));
          const Mask changes = more_where(more(all(near), travel), moving, all(-kNoEnd));
          found.live[ix * kRows + iy] |= static_cast<std::uint64_t>(bits(changes)) << found.shift;
        }
        if (may_raise && any(raised)) {
          changed = true;
          const Floats now = pick(raised, depth, old);
          emptied |= more(zero, old) & no_less(now, zero);
          samples.write(old, now, removed ? block.tissue + (row - block.distance) : nullptr, taken);
        }
      }
      min_safe_travel = lesser(travel, min_safe_travel);
    }
  }
  if (removed) taken.close();
  alignas(32) float safe_travel[kLanes];
  store(safe_travel, min_safe_travel);
  found.safe_travel = *std::min_element(safe_travel, safe_travel + kLanes);
  found.emptied = any(emptied);
  return changed;
}
