// Included once in each namespace of lane_ops.h. Cuts the groups in the lists of cut_front.h.

constexpr int kChunk = 128;  // number of groups that are processed together
// number of groups by which prefetching is ahead of cutting
constexpr int kAhead = 24;
alignas(64) constexpr float kSteps[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};

TYPODONT_INLINE void fetch(const float* group) {
  __builtin_prefetch(group);
  // prefetches the group's last sample too, because the group usually lies in two cache lines
  if constexpr (kLanes * sizeof(float) >= 64) __builtin_prefetch(group + kLanes - 1);
}

/// Returns true if all samples of kLanes groups may change. `length`: number of samples that may change, per group.
TYPODONT_INLINE bool all_whole(const std::uint8_t* length) {
  constexpr std::uint64_t kWhole = kLanes * 0x0101010101010101u;
  std::uint64_t parts[kLanes / 8], differ = 0;
  std::memcpy(parts, length, sizeof parts);
  for (const std::uint64_t part : parts) differ |= part ^ kWhole;
  return differ == 0;
}

/// Terms of the distance from a ball that are equal for all samples of a group.
struct BallRows {
  alignas(64) float u[kChunk], v[kChunk];
};

/// Cuts groups with a ball that moves from A to B; `capsule` false: only with the ball at B. `ahead`: all samples are
/// ahead of A. `whole`: all samples may change. If one of these is true, it is not tested for each sample.
template <bool capsule, bool ahead, bool whole>
TYPODONT_INLINE void carve_groups(const BallFront& f, const Capsule& c, const BallRows& rows, int g0, int from_g,
                                  int to_g, Mask& raised, Taken& taken) {
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
      const Floats dx = all(rows.u[g]) - s * all(c.abx), dy = all(rows.v[g]) - s * all(c.aby),
                   dz = height - s * all(c.abz);
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
    taken.add(share_taken(old, now), f.groups.label[g0 + g], at);
  }
}

template <bool capsule>
TYPODONT_INLINE void carve_range(const BallFront& f, const Capsule& c, int from, int to, Mask& raised, Taken& taken) {
  // voxels, rounding error of the test on which side of the motion's start A a sample lies, along the motion
  constexpr float kSlip = 1e-3f;
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
      // samples behind the start of the motion cannot increase
      if (where[g / kLanes] == kAllBehind) continue;
      const int until = std::min(g + kLanes, end);
      if (!all_whole(f.groups.length + g0 + g)) {
        carve_groups<capsule, false, false>(f, c, rows, g0, g, until, raised, taken);
      } else if (where[g / kLanes] == kAllAhead) {
        carve_groups<capsule, true, true>(f, c, rows, g0, g, until, raised, taken);
      } else {
        carve_groups<capsule, false, true>(f, c, rows, g0, g, until, raised, taken);
      }
    }
  }
}

/// Cuts only the narrow groups (at most eight samples can change), or only the wide ones. True: a sample changed.
template <bool capsule>
TYPODONT_INLINE bool carve_ball(const BallFront& front, bool narrow, RemovedVolume* removed) {
  const BallFront f = front;
  const Capsule c = f.c;
  Mask raised = nowhere();
  Taken taken{removed};
  const BallFront::Ranges& ranges = narrow ? f.narrow : f.wide;
  for (int r = 0; r < ranges.count; ++r) carve_range<capsule>(f, c, ranges.at[r].from, ranges.at[r].to, raised, taken);
  taken.close();
  return any(raised);
}

/// Input of may_be_deeper(). motion_rho, motion_z: a sample's motion away from the head's axis and along the axis, both
/// multiplied by the sample's distance from the axis. least: smallest depth that changes the sample's value.
struct Passed {
  Floats motion_rho, motion_z, least;
};
struct BelowLine {
  MeridianPiece piece;
  TYPODONT_INLINE Floats depth(Floats rho, Floats z) const { return depth_below_line(piece, rho, z); }
  TYPODONT_INLINE Floats depth(Floats rho, Floats z, const Passed& on, Mask& deeper) const {
    const Floats below = depth(rho, z);
    deeper = may_be_deeper(below, on.least, all(0.0f) - (on.motion_rho * all(piece.nax) + on.motion_z * all(piece.naz)),
                           rho);
    return below;
  }
};
/// Depth below a line perpendicular to the axis, the flat end of many heads; independent of rho (distance from axis).
struct BelowEnd : BelowLine {
  TYPODONT_INLINE Floats depth_at(Floats z) const { return (all(piece.az) - z) * all(piece.naz); }
};
struct BelowArc {
  MeridianPiece piece;
  TYPODONT_INLINE Floats depth(Floats rho, Floats z) const { return depth_below_arc(piece, rho, z); }
  TYPODONT_INLINE Floats depth(Floats rho, Floats z, const Passed& on, Mask& deeper) const {
    const Floats below = depth(rho, z);
    deeper = may_be_deeper(below, on.least,
                           all(0.0f) - ((rho - all(piece.cx)) * on.motion_rho + (z - all(piece.cz)) * on.motion_z),
                           (all(piece.radius) - below) * rho);
    return below;
  }
};
/// Depth of samples below one or two pieces of the meridian. The nearest point may be an end point of a piece.
template <bool first_bent, bool second, bool second_bent>
struct BelowEnds {
  MeridianPiece pieces[2];
  TYPODONT_INLINE Floats depth(Floats rho, Floats z) const {
    NearestPiece nearest = no_piece_yet();
    first_bent ? nearest.meet_arc(pieces[0], rho, z) : nearest.meet_line(pieces[0], rho, z);
    if constexpr (second) second_bent ? nearest.meet_arc(pieces[1], rho, z) : nearest.meet_line(pieces[1], rho, z);
    return nearest.depth();
  }
  TYPODONT_INLINE Floats depth(Floats rho, Floats z, const Passed& on, Mask& deeper) const {
    NearestOnPath found{no_piece_yet(), all(0.0f)};
    first_bent ? found.meet_arc(pieces[0], rho, z, on.motion_rho, on.motion_z)
               : found.meet_line(pieces[0], rho, z, on.motion_rho, on.motion_z);
    if constexpr (second) {
      second_bent ? found.meet_arc(pieces[1], rho, z, on.motion_rho, on.motion_z)
                  : found.meet_line(pieces[1], rho, z, on.motion_rho, on.motion_z);
    }
    const Floats below = found.nearest.depth();
    deeper = found.deeper(rho, below, on.least);
    return below;
  }
};
/// Depth of samples below a flat end, its rim and a cylindrical flank, if the head moves along its axis. For samples
/// that this motion can cut, it is bit-identical to the depth that BelowAny computes.
struct BelowRim {
  MeridianPiece end, flank;
  float above, beyond;
  TYPODONT_INLINE Floats depth(Floats rho, Floats z) const {
    const Floats none = all(0.0f), below_end = z - all(end.bz), below_flank = all(flank.ax) - rho;
    const Floats out_z = lesser(below_end, none), out_rho = lesser(below_flank, none);
    const Floats away = root(out_z * out_z + out_rho * out_rho);
    const Floats depth = pick(more(away, none), none - away, lesser(below_end, below_flank));
    return unless_still(depth, rho, z, above, beyond);
  }
};
struct BelowAny {
  const MeridianPiece* pieces;
  unsigned set;
  TYPODONT_INLINE Floats depth(Floats rho, Floats z) const { return depth_below_pieces(pieces, set, rho, z); }
  TYPODONT_INLINE Floats depth(Floats rho, Floats z, const Passed& on, Mask& deeper) const {
    const NearestOnPath found = nearest_on_path(pieces, set, rho, z, on.motion_rho, on.motion_z);
    const Floats below = found.nearest.depth();
    deeper = found.deeper(rho, below, on.least);
    return below;
  }
};

/// Data of kChunk groups in frame T, voxels. x, y, z: part of a sample's position that does not depend on z of frame
/// V. motion_x, motion_y, motion_z: vector from a group's first sample to its previous position in frame T.
struct HeadRows {
  alignas(64) float x[kChunk], y[kChunk], z[kChunk];
  alignas(64) float motion_x[kChunk], motion_y[kChunk], motion_z[kChunk];
};

/// Bounds of the samples' motions relative to the head, for a group of which only the middle's motion is computed.
struct HeadSides {
  // Voxels. half: half a group's length. off: component of `half` perpendicular to the head's axis + longest motion.
  float half, off;
  float across;  // voxels, largest motion of a sample perpendicular to the head's axis
  // Voxels. bend: difference between the motions of two samples that are neighbours along z. turned: largest difference
  // between the motion of a sample and that of the group's middle.
  float bend[3], turned;

  TYPODONT_INLINE HeadSides(const HeadFront& f) : half((kLanes - 1) / 2.0f) {
    const Straight& back = f.tops->back;
    const float* const R = f.pose.R;
    const float* const T = back.turn;
    off = half * std::sqrt(R[6] * R[6] + R[7] * R[7]) + back.longest;
    turned = 1e-5f;
    bool turns = false;
    for (int i = 0; i < 3; ++i) {
      bend[i] = T[i] * R[6] + T[3 + i] * R[7] + T[6 + i] * R[8];
      turned += half * std::abs(bend[i]);
      turns |= T[i] != 0.0f || T[3 + i] != 0.0f || T[6 + i] != 0.0f;
    }
    across = turns ? back.longest : std::sqrt(back.shift[0] * back.shift[0] + back.shift[1] * back.shift[1]);
  }
  /// Bit mask of the groups whose samples may be deeper during the motion than at its end.
  TYPODONT_INLINE unsigned beside(const Straight& back, const MeridianPiece& first, const MeridianPiece& last,
                                  float smooth, Floats x, Floats y, Floats z, HeadRows& rows, int g) const {
    const Floats rho = root(x * x + y * y);
    const Mask sharp = more(all(smooth), rho);
    if (!any(sharp)) return 0;
    const float* const T = back.turn;
    const Floats motion_x = all(T[0]) * x + all(T[3]) * y + (all(T[6]) * z + all(back.shift[0]));
    const Floats motion_y = all(T[1]) * x + all(T[4]) * y + (all(T[7]) * z + all(back.shift[1]));
    const Floats motion_z = all(T[2]) * x + all(T[5]) * y + (all(T[8]) * z + all(back.shift[2]));
    store(rows.motion_x + g, motion_x - all(half * bend[0])), store(rows.motion_y + g, motion_y - all(half * bend[1]));
    store(rows.motion_z + g, motion_z - all(half * bend[2]));
    // Each sample has its own direction away from the axis. So the motion in this direction gets a bound that is valid
    // for the whole group.
    const Floats inverse = all(1.0f) / greater(rho, all(1e-3f)), seen = all(off) * inverse;
    const Floats err = all(across) * pick(more(all(0.75f), seen), all(1.14f) * seen, all(2.0f));
    const Mask tip = more(all(first.ax == 0.0f ? off + Sweep::kMargin : 0.0f), rho);
    const Floats slowest =
        all(-turned) -
        fastest_advance(first, last, tip, err - (x * motion_x + y * motion_y) * inverse, all(0.0f) - motion_z);
    return bits(more_where(sharp, all(-0.5f * kTop), slowest));
  }
};

/// `beside`: true if samples may have been deeper during the motion than at its end.
template <bool beside, class Below>
TYPODONT_INLINE void carve_groups(const HeadFront& f, const Below& below, const HeadRows& rows, const float* bend,
                                  int g0, int from, int to, Mask& raised, Taken& taken) {
  for (int g = from; g < to; ++g) {
    const std::int32_t height = f.groups.z[g0 + g];
    float* const at = f.distance + f.groups.at[g0 + g];
    fetch(f.distance + f.groups.at[g0 + g + kAhead]);
    const Floats old = load(at), z = all(rows.z[g]) + load(f.along[2] + height);
    const Mask may = first(f.groups.length[g0 + g]);
    Floats depth;
    if constexpr (!beside && std::is_same_v<Below, BelowEnd>) {
      depth = below.depth_at(z);
    } else {
      const Floats x = all(rows.x[g]) + load(f.along[0] + height), y = all(rows.y[g]) + load(f.along[1] + height),
                   rho = root(x * x + y * y);
      if constexpr (beside) {
        const Floats steps = load(kSteps), motion_x = all(rows.motion_x[g]) + steps * all(bend[0]),
                     motion_y = all(rows.motion_y[g]) + steps * all(bend[1]);
        const Floats motion_z = all(rows.motion_z[g]) + steps * all(bend[2]);
        Mask deeper;
        depth = below.depth(rho, z, {x * motion_x + y * motion_y, rho * motion_z, greater(old, all(-Sweep::kMargin))},
                            deeper);
        for (unsigned left = bits(more_where(deeper & may, all(Sweep::kInner), depth)); left != 0; left &= left - 1) {
          const int i = std::countr_zero(left);
          f.tops->add(f.groups.x[g0 + g] + static_cast<float>(f.origin.x),
                      f.groups.y[g0 + g] + static_cast<float>(f.origin.y), static_cast<float>(f.origin.z + height + i),
                      at + i, f.groups.label[g0 + g]);
        }
      } else {
        depth = below.depth(rho, z);
      }
    }
    Mask rises;
    Floats least;
    const Floats now = raised_to(old, lesser(depth, all(Sweep::kInner)), may, least, rises);
    store(at, now);
    raised |= rises;
    taken.add(share_taken(old, now), f.groups.label[g0 + g], at);
  }
}

/// Cuts a run (CutFront::Run): groups with the same nearest pieces of the meridian.
template <class Below>
TYPODONT_INLINE void carve_run(const HeadFront& f, const HeadSides& sides, const CutFront::Run& run, unsigned set,
                               const Below below, Mask& raised, Taken& taken) {
  const float* const R = f.pose.R;
  const MeridianPiece& first = f.pieces[std::countr_zero(set)];
  const MeridianPiece& last = f.pieces[std::bit_width(set) - 1];
  const float smooth = run.kind < kManyPieces ? smooth_from(f.tops->back, first) + sides.off : kNoEnd;
  // still_above < kNoEnd: the head moves along its axis, so no sample is deeper during the motion than at its end.
  const bool slow = f.tops->back.longest <= kSlow || f.tops->back.still_above < kNoEnd;
  HeadRows rows;
  for (int g0 = run.from; g0 < run.to; g0 += kChunk) {
    const int end = std::min(run.to - g0, kChunk);
    unsigned beside[kChunk / kLanes] = {};
    for (int g = 0; g < end; g += kLanes) {
      const Floats vx = load(f.groups.x + g0 + g) + all(static_cast<float>(f.origin.x)) - all(f.pose.p[0]);
      const Floats vy = load(f.groups.y + g0 + g) + all(static_cast<float>(f.origin.y)) - all(f.pose.p[1]);
      const Floats x = all(R[0]) * vx + all(R[3]) * vy, y = all(R[1]) * vx + all(R[4]) * vy,
                   z = all(R[2]) * vx + all(R[5]) * vy;
      store(rows.x + g, x), store(rows.y + g, y), store(rows.z + g, z);
      if (slow) continue;
      const Floats height =
          as_floats(f.groups.z + g0 + g) + all(static_cast<float>(f.origin.z) + sides.half - f.pose.p[2]);
      beside[g / kLanes] = sides.beside(f.tops->back, first, last, smooth, x + all(R[6]) * height,
                                        y + all(R[7]) * height, z + all(R[8]) * height, rows, g);
    }
    for (int g = 0; g < end; g += kLanes) {
      const int count = std::min(kLanes, end - g);
      for (int i = 0, next; i < count; i = next) {
        const unsigned left = beside[g / kLanes] >> i;
        const bool is_beside = left & 1;
        next = std::min(i + std::countr_zero((is_beside ? ~left : left) | 1u << 31), count);
        if (!is_beside) {
          carve_groups<false>(f, below, rows, sides.bend, g0, g + i, g + next, raised, taken);
        } else if constexpr (!std::is_same_v<Below, BelowRim>) {
          f.tops->make_room(kLanes * kLanes);
          carve_groups<true>(f, below, rows, sides.bend, g0, g + i, g + next, raised, taken);
        }
      }
    }
  }
}

/// Cuts only the narrow groups (at most eight samples can change), or only the wide ones. True: a sample changed.
TYPODONT_INLINE bool carve_head(const HeadFront& f, bool narrow, RemovedVolume* removed) {
  Mask raised = nowhere();
  Taken taken{removed};
  const MeridianPiece* const pieces = f.pieces;
  const HeadSides sides(f);
  const float above = f.tops->back.still_above, beyond = f.tops->back.still_beyond;
  const bool along_axis = above < kNoEnd;
  for (int r = 0; r < f.run_count; ++r) {
    const CutFront::Run& run = f.runs[r];
    if (run.narrow != narrow) continue;
    const unsigned set = run.kind < kManyPieces ? 1u << run.kind : static_cast<unsigned>(run.kind - kManyPieces);
    // In a motion along the axis, only the end of the head cuts.
    if (along_axis && (set & 1) == 0) continue;
    const MeridianPiece& one = pieces[std::countr_zero(set)];
    const MeridianPiece& other = pieces[std::bit_width(set) - 1];
    const bool bent = one.radius != 0.0f, other_bent = other.radius != 0.0f;
    if (along_axis && run.kind >= kManyPieces) {
      carve_run(f, sides, run, set, BelowRim{pieces[0], pieces[1], above, beyond}, raised, taken);
    } else if (run.kind < kManyPieces) {
      bent              ? carve_run(f, sides, run, set, BelowArc{one}, raised, taken)
      : one.nax == 0.0f ? carve_run(f, sides, run, set, BelowEnd{{one}}, raised, taken)
                        : carve_run(f, sides, run, set, BelowLine{one}, raised, taken);
    } else if (std::popcount(set) == 1) {
      bent ? carve_run(f, sides, run, set, BelowEnds<true, false, false>{{one, one}}, raised, taken)
           : carve_run(f, sides, run, set, BelowEnds<false, false, false>{{one, one}}, raised, taken);
    } else if (std::popcount(set) > 2) {
      carve_run(f, sides, run, set, BelowAny{pieces, set}, raised, taken);
    } else if (bent) {
      other_bent ? carve_run(f, sides, run, set, BelowEnds<true, true, true>{{one, other}}, raised, taken)
                 : carve_run(f, sides, run, set, BelowEnds<true, true, false>{{one, other}}, raised, taken);
    } else {
      other_bent ? carve_run(f, sides, run, set, BelowEnds<false, true, true>{{one, other}}, raised, taken)
                 : carve_run(f, sides, run, set, BelowEnds<false, true, false>{{one, other}}, raised, taken);
    }
  }
  taken.close();
  return any(raised);
}
