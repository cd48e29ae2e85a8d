// Text of a kernel, included once within each namespace of lanes (lane_ops.h): raises the groups that are listed before a
// head.

constexpr int kChunk = 128;  // groups
constexpr int kAhead = 24;   // groups, fetched in time

TYPODONT_KERNEL void fetch(const float* group) {
  __builtin_prefetch(group);
  if constexpr (kLanes * sizeof(float) >= 64) __builtin_prefetch(group + kLanes - 1);  // mostly in two lines
}

template <bool capsule>
TYPODONT_KERNEL bool raise_ball(const BallFront& f, PerTissue* removed) {
  const Capsule c = f.c;
  const Floats from = all(c.continues ? 0.0f : -1e30f), radius = all(c.radius);
  float* const distance = f.distance;
  const float* const apart = f.heights.apart;
  const float* const ahead = f.heights.ahead;
  const std::int32_t* const group_z = f.groups.z;
  const std::int32_t* const group_at = f.groups.at;
  const std::uint8_t* const group_label = f.groups.label;
  const std::uint8_t* const group_length = f.groups.length;
  const int count = f.count;
  alignas(64) float u[kChunk], v[kChunk];
  Mask raised = nowhere();
  Taken taken{removed};
  for (int g0 = 0; g0 < count; g0 += kChunk) {
    const int end = std::min(count - g0, kChunk);
    for (int g = 0; g < end; g += kLanes) {
      const Floats px = load(f.groups.x + g0 + g) + all(static_cast<float>(f.origin.x)) - all(c.ax);
      const Floats py = load(f.groups.y + g0 + g) + all(static_cast<float>(f.origin.y)) - all(c.ay);
      if constexpr (capsule) {
        store(u + g, px), store(v + g, py);
      } else {
        const Floats qx = px - all(c.abx), qy = py - all(c.aby);
        store(u + g, qx * qx + qy * qy), store(v + g, px * all(c.abx) + py * all(c.aby));
      }
    }
    for (int g = 0; g < end; ++g) {
      const std::int32_t z = group_z[g0 + g];
      float* const at = distance + group_at[g0 + g];
      fetch(distance + group_at[g0 + g + kAhead]);
      Floats d2, dot;
      if constexpr (capsule) {
        const Floats height = load(apart + z);
        dot = (all(u[g]) * all(c.abx) + all(v[g]) * all(c.aby)) + load(ahead + z);
        const Floats s = lesser(greater(dot * all(c.inverse_length2), all(0.0f)), all(1.0f));
        const Floats dx = all(u[g]) - s * all(c.abx), dy = all(v[g]) - s * all(c.aby), dz = height - s * all(c.abz);
        d2 = dx * dx + dy * dy + dz * dz;
      } else {
        d2 = all(u[g]) + load(apart + z);
        dot = all(v[g]) + load(ahead + z);
      }
      Mask rises;
      const Floats old = load(at), depth = lesser(radius - root(d2), all(Sweep::kInner));
      Floats least;
      const Floats now = raised_to(old, depth, more(dot, from) & first(group_length[g0 + g]), least, rises);
      store(at, now);
      raised |= rises;
      taken.add(share_taken(old, now), group_label[g0 + g]);
    }
  }
  taken.close();
  return any(raised);
}

/// Groups that have the same closest pieces.
template <Nearest nearest>
TYPODONT_KERNEL void raise_run(const HeadFront& f, const CutFront::Run& run, Mask& raised, Taken& taken) {
  const MeridianPiece* const pieces = f.pieces;
  const MeridianPiece only = pieces[run.kind < kManyPieces ? run.kind : 0];
  const unsigned set = static_cast<unsigned>(run.kind - kManyPieces);
  const float* const R = f.pose.R;
  float* const distance = f.distance;
  const float* const along_x = f.along[0];
  const float* const along_y = f.along[1];
  const float* const along_z = f.along[2];
  const std::int32_t* const group_z = f.groups.z;
  const std::int32_t* const group_at = f.groups.at;
  const std::uint8_t* const group_label = f.groups.label;
  const std::uint8_t* const group_length = f.groups.length;
  alignas(64) float common[3][kChunk];
  for (int g0 = run.from; g0 < run.to; g0 += kChunk) {
    const int end = std::min(run.to - g0, kChunk);
    for (int g = 0; g < end; g += kLanes) {
      const Floats vx = load(f.groups.x + g0 + g) + all(static_cast<float>(f.origin.x)) - all(f.pose.p[0]);
      const Floats vy = load(f.groups.y + g0 + g) + all(static_cast<float>(f.origin.y)) - all(f.pose.p[1]);
      for (int i = 0; i < 3; ++i) store(common[i] + g, all(R[i]) * vx + all(R[3 + i]) * vy);
    }
    for (int g = 0; g < end; ++g) {
      const std::int32_t height = group_z[g0 + g];
      float* const at = distance + group_at[g0 + g];
      fetch(distance + group_at[g0 + g + kAhead]);
      const Floats x = all(common[0][g]) + load(along_x + height), y = all(common[1][g]) + load(along_y + height);
      const Floats z = all(common[2][g]) + load(along_z + height), rho = root(x * x + y * y);
      Floats depth;
      if constexpr (nearest == Nearest::kLine) {
        depth = depth_below_line(only, rho, z);
      } else if constexpr (nearest == Nearest::kArc) {
        depth = depth_below_arc(only, rho, z);
      } else {
        depth = depth_below_pieces(pieces, set, rho, z);
      }
      Mask rises;
      Floats least;
      const Floats old = load(at), now = raised_to(old, lesser(depth, all(Sweep::kInner)), first(group_length[g0 + g]), least, rises);
      store(at, now);
      raised |= rises;
      taken.add(share_taken(old, now), group_label[g0 + g]);
    }
  }
}

TYPODONT_KERNEL bool raise_head(const HeadFront& f, PerTissue* removed) {
  Mask raised = nowhere();
  Taken taken{removed};
  for (int r = 0; r < f.run_count; ++r) {
    const CutFront::Run& run = f.runs[r];
    if (run.kind >= kManyPieces) {
      raise_run<Nearest::kSeveral>(f, run, raised, taken);
    } else if (f.pieces[run.kind].radius == 0.0f) {
      raise_run<Nearest::kLine>(f, run, raised, taken);
    } else {
      raise_run<Nearest::kArc>(f, run, raised, taken);
    }
  }
  taken.close();
  return any(raised);
}
