// Text of a kernel, included once within each namespace of lanes (lane_ops.h): raises the groups that are listed before a
// head.

constexpr int kChunk = 128;  // groups
constexpr int kAhead = 24;   // groups, fetched in time

TYPODONT_KERNEL void fetch(const float* group) {
  __builtin_prefetch(group);
  if constexpr (kLanes * sizeof(float) >= 64) __builtin_prefetch(group + kLanes - 1);  // mostly in two lines
}

/// Whether as many groups as there are lanes, from this one on, may all change in all of their samples.
TYPODONT_KERNEL bool all_whole(const std::uint8_t* length) {
  constexpr std::uint64_t kWhole = kLanes * 0x0101010101010101u;
  std::uint64_t parts[kLanes / 8], differ = 0;
  std::memcpy(parts, length, sizeof parts);
  for (const std::uint64_t part : parts) differ |= part ^ kWhole;
  return differ == 0;
}

/// What the samples of some groups' rows have in common.
struct BallRows {
  alignas(64) float u[kChunk], v[kChunk];
};

/// One group after the other. `ahead`: all of their samples lie ahead of A; `whole`: all of them may change. What is known of
/// all is not asked of each.
template <bool capsule, bool ahead, bool whole>
TYPODONT_KERNEL void raise_groups(const BallFront& f, const Capsule& c, const BallRows& rows, int g0, int from_g, int to_g, Mask& raised,
                                  Taken& taken) {
  const Floats from = all(c.continues ? 0.0f : -1e30f), radius = all(c.radius);
  for (int g = from_g; g < to_g; ++g) {
    const std::int32_t z = f.groups.z[g0 + g];
    float* const at = f.distance + f.groups.at[g0 + g];
    fetch(f.distance + f.groups.at[g0 + g + kAhead]);
    Floats d2, dot;
    if constexpr (capsule) {
      const Floats height = load(f.heights.apart + z);
      dot = (all(rows.u[g]) * all(c.abx) + all(rows.v[g]) * all(c.aby)) + load(f.heights.ahead + z);
      const Floats s = lesser(greater(dot * all(c.inverse_length2), all(0.0f)), all(1.0f));
      const Floats dx = all(rows.u[g]) - s * all(c.abx), dy = all(rows.v[g]) - s * all(c.aby), dz = height - s * all(c.abz);
      d2 = dx * dx + dy * dy + dz * dz;
    } else {
      d2 = all(rows.u[g]) + load(f.heights.apart + z);
      if constexpr (!ahead) dot = all(rows.v[g]) + load(f.heights.ahead + z);
    }
    Mask may = everywhere();
    if constexpr (!ahead) may = more(dot, from);
    if constexpr (!whole) may &= first(f.groups.length[g0 + g]);
    Mask rises;
    const Floats old = load(at), depth = lesser(radius - root(d2), all(Sweep::kInner));
    Floats least;
    const Floats now = raised_to(old, depth, may, least, rises);
    store(at, now);
    raised |= rises;
    taken.add(share_taken(old, now), f.groups.label[g0 + g]);
  }
}

template <bool capsule>
TYPODONT_KERNEL void raise_range(const BallFront& f, const Capsule& c, int from, int to, Mask& raised, Taken& taken) {
  constexpr float kSlip = 1e-3f;  // voxels; more than rounding does to where the plane through A lies
  const float slip = kSlip * (std::abs(c.abx) + std::abs(c.aby) + std::abs(c.abz)), last = (kLanes - 1) * c.abz;
  const float low = std::min(last, 0.0f) - slip, high = std::max(last, 0.0f) + slip;
  BallRows rows;
  for (int g0 = from; g0 < to; g0 += kChunk) {
    const int end = std::min(to - g0, kChunk);
    enum : std::uint8_t { kAllBehind, kBeside, kAllAhead } where[kChunk / kLanes];
    for (int g = 0; g < end; g += kLanes) {
      const Floats px = load(f.groups.x + g0 + g) + all(static_cast<float>(f.origin.x)) - all(c.ax);
      const Floats py = load(f.groups.y + g0 + g) + all(static_cast<float>(f.origin.y)) - all(c.ay);
      const Floats pz = as_floats(f.groups.z + g0 + g) + all(static_cast<float>(f.origin.z) - c.az);
      const Floats along = px * all(c.abx) + py * all(c.aby), first = along + pz * all(c.abz);
      if constexpr (capsule) {
        store(rows.u + g, px), store(rows.v + g, py);
      } else {
        const Floats qx = px - all(c.abx), qy = py - all(c.aby);
        store(rows.u + g, qx * qx + qy * qy), store(rows.v + g, along);
      }
      const bool ahead = !c.continues || every(more(first, all(-low)));
      where[g / kLanes] = ahead ? kAllAhead : every(more(all(-high), first)) ? kAllBehind : kBeside;
    }
    for (int g = 0; g < end; g += kLanes) {
      if (where[g / kLanes] == kAllBehind) continue;  // never rises
      const int until = std::min(g + kLanes, end);
      if (!all_whole(f.groups.length + g0 + g)) {
        raise_groups<capsule, false, false>(f, c, rows, g0, g, until, raised, taken);
      } else if (where[g / kLanes] == kAllAhead) {
        raise_groups<capsule, true, true>(f, c, rows, g0, g, until, raised, taken);
      } else {
        raise_groups<capsule, false, true>(f, c, rows, g0, g, until, raised, taken);
      }
    }
  }
}

template <bool capsule>
TYPODONT_KERNEL bool raise_ball(const BallFront& front, PerTissue* removed) {
  const BallFront f = front;
  const Capsule c = f.c;
  Mask raised = nowhere();
  Taken taken{removed};
  for (int r = 0; r < f.range_count; ++r) raise_range<capsule>(f, c, f.ranges[r].from, f.ranges[r].to, raised, taken);
  taken.close();
  return any(raised);
}

/// What makes the depth of samples of a head, the same for all groups of a run.
struct BelowLine {
  MeridianPiece piece;
  TYPODONT_KERNEL Floats depth(Floats rho, Floats z) const { return depth_below_line(piece, rho, z); }
};
/// A line across the axis, as heads end in: how far from the axis is all the same.
struct BelowEnd {
  MeridianPiece piece;
  TYPODONT_KERNEL Floats depth(Floats z) const { return (all(piece.az) - z) * all(piece.naz); }
};
struct BelowArc {
  MeridianPiece piece;
  TYPODONT_KERNEL Floats depth(Floats rho, Floats z) const { return depth_below_arc(piece, rho, z); }
};
/// One piece with its ends, or two.
template <bool first_bent, bool second, bool second_bent>
struct BelowEnds {
  MeridianPiece pieces[2];
  TYPODONT_KERNEL Floats depth(Floats rho, Floats z) const {
    NearestPiece nearest = no_piece_yet();
    first_bent ? nearest.meet_arc(pieces[0], rho, z) : nearest.meet_line(pieces[0], rho, z);
    if constexpr (second) second_bent ? nearest.meet_arc(pieces[1], rho, z) : nearest.meet_line(pieces[1], rho, z);
    return nearest.depth();
  }
};
struct BelowAny {
  const MeridianPiece* pieces;
  unsigned set;
  TYPODONT_KERNEL Floats depth(Floats rho, Floats z) const { return depth_below_pieces(pieces, set, rho, z); }
};

/// Groups that have the same closest pieces.
template <class Below>
TYPODONT_KERNEL void raise_run(const HeadFront& f, const CutFront::Run& run, const Below below, Mask& raised, Taken& taken) {
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
      const Floats z = all(common[2][g]) + load(along_z + height);
      Floats depth;
      if constexpr (std::is_same_v<Below, BelowEnd>) {
        depth = below.depth(z);
      } else {
        const Floats x = all(common[0][g]) + load(along_x + height), y = all(common[1][g]) + load(along_y + height);
        depth = below.depth(root(x * x + y * y), z);
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

/// All groups that are `narrow`, or all others.
TYPODONT_KERNEL bool raise_head(const HeadFront& f, bool narrow, PerTissue* removed) {
  Mask raised = nowhere();
  Taken taken{removed};
  const MeridianPiece* const pieces = f.pieces;
  for (int r = 0; r < f.run_count; ++r) {
    const CutFront::Run& run = f.runs[r];
    if ((run.stage == CutFront::kNarrow) != narrow) continue;
    const unsigned set = run.kind < kManyPieces ? 1u << run.kind : static_cast<unsigned>(run.kind - kManyPieces);
    const MeridianPiece& one = pieces[std::countr_zero(set)];
    const MeridianPiece& other = pieces[std::bit_width(set) - 1];
    const bool bent = one.radius != 0.0f, other_bent = other.radius != 0.0f;
    if (run.kind < kManyPieces) {
      bent                 ? raise_run(f, run, BelowArc{one}, raised, taken)
      : one.nax == 0.0f ? raise_run(f, run, BelowEnd{one}, raised, taken)
                           : raise_run(f, run, BelowLine{one}, raised, taken);
    } else if (std::popcount(set) == 1) {
      bent ? raise_run(f, run, BelowEnds<true, false, false>{{one, one}}, raised, taken)
           : raise_run(f, run, BelowEnds<false, false, false>{{one, one}}, raised, taken);
    } else if (std::popcount(set) > 2) {
      raise_run(f, run, BelowAny{pieces, set}, raised, taken);
    } else if (bent) {
      other_bent ? raise_run(f, run, BelowEnds<true, true, true>{{one, other}}, raised, taken)
                 : raise_run(f, run, BelowEnds<true, true, false>{{one, other}}, raised, taken);
    } else {
      other_bent ? raise_run(f, run, BelowEnds<false, true, true>{{one, other}}, raised, taken)
                 : raise_run(f, run, BelowEnds<false, true, false>{{one, other}}, raised, taken);
    }
  }
  taken.close();
  return any(raised);
}
