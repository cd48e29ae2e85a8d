// Included after depth_kernel.h. Depths of samples while the head moves.

/// Returns `depth`, but −kNoEnd for samples that this motion does not change (Straight::still_above).
TYPODONT_INLINE Floats unless_still(Floats depth, Floats rho, Floats z, float above, float beyond) {
  return pick(more_where(more(z, all(above)), rho + z, all(beyond)), all(-kNoEnd), depth);
}

/// Distance of a sample from the nearest piece of the meridian, the vector from this piece, and the piece's normal.
struct NearestWithNormal {
  NearestPiece nearest;
  Floats out_rho, out_z, n_rho, n_z;

  TYPODONT_INLINE void take(Floats before, Floats f_rho, Floats f_z, Floats m_rho, Floats m_z) {
    const Mask nearer = more(before, nearest.square);
    out_rho = pick(nearer, f_rho, out_rho), out_z = pick(nearer, f_z, out_z);
    n_rho = pick(nearer, m_rho, n_rho), n_z = pick(nearer, m_z, n_z);
  }
  TYPODONT_INLINE void meet_line(const MeridianPiece& piece, Floats rho, Floats z) {
    const Floats before = nearest.square, nax = all(piece.nax), naz = all(piece.naz);
    nearest.meet_line(piece, rho, z);
    const Floats in = all(piece.ax) - rho, down = all(piece.az) - z, below = in * nax + down * naz,
                 along = in * naz - down * nax;
    const Floats over = along - greater(lesser(along, all(piece.length)), all(0.0f));
    take(before, all(0.0f) - (below * nax + over * naz), over * nax - below * naz, nax, naz);
  }
  TYPODONT_INLINE void meet_arc(const MeridianPiece& piece, Floats rho, Floats z) {
    const Floats before = nearest.square, none = all(0.0f);
    nearest.meet_arc(piece, rho, z);
    const Floats vx = rho - all(piece.cx), vz = z - all(piece.cz),
                 inverse = all(1.0f) / (root(vx * vx + vz * vz) + all(1e-6f));
    const Mask between =
        no_less(all(piece.ux) * vz - all(piece.uz) * vx, none) & no_less(vx * all(piece.wz) - vz * all(piece.wx), none);
    const Floats off = all(1.0f) - all(piece.radius) * inverse;
    take(before, pick(between, vx * off, rho - all(piece.ax)), pick(between, vz * off, z - all(piece.az)),
         pick(between, vx * inverse, all(piece.nax)), pick(between, vz * inverse, all(piece.naz)));
  }
  /// Outward direction; at a corner, any direction between its two normals.
  TYPODONT_INLINE void normal(Floats& rho, Floats& z) const {
    const Floats away = root(nearest.square), inverse = all(1.0f) / greater(away, all(kNear));
    const Mask beside = nearest.outside & more(away, all(kNear));
    rho = pick(beside, out_rho * inverse, n_rho), z = pick(beside, out_z * inverse, n_z);
  }
  /// Returns the derivative of the depth along the motion (motion_x, motion_y, motion_z), frame T.
  TYPODONT_INLINE Floats slope(Floats x, Floats y, Floats rho, Floats motion_x, Floats motion_y,
                               Floats motion_z) const {
    Floats m_rho, m_z;
    normal(m_rho, m_z);
    return all(0.0f) - (m_rho * ((x * motion_x + y * motion_y) / (rho + all(1e-6f))) + m_z * motion_z);
  }
};

/// `set`: bit mask of the examined pieces of the meridian.
TYPODONT_INLINE NearestWithNormal nearest_with_normal(const MeridianPiece* pieces, unsigned set, Floats rho, Floats z) {
  const Floats none = all(0.0f);
  NearestWithNormal found{no_piece_yet(), none, none, none, none};
  for (; set != 0; set &= set - 1) {
    const MeridianPiece& piece = pieces[std::countr_zero(set)];
    piece.radius == 0.0f ? found.meet_line(piece, rho, z) : found.meet_arc(piece, rho, z);
  }
  return found;
}

/// Returns true for samples that, earlier in the motion, may have been deeper than `least` and than their final depth
/// `depth`. Depth is concave along the path, so `growth` / `scale` is an upper bound of (earlier depth − `depth`).
TYPODONT_INLINE Mask may_be_deeper(Floats depth, Floats least, Floats growth, Floats scale) {
  return more_where(more(growth, all(0.5f * kTop) * scale), growth + (depth - least + all(0.5f * kTop)) * scale,
                    all(0.0f));
}

/// A sample's distance from the nearest piece of the meridian, and its motion away from this piece, scaled.
struct NearestOnPath {
  NearestPiece nearest;
  /// scaled motion: its component away from the piece × distance from the piece × rho (distance from the axis)
  Floats away;

  TYPODONT_INLINE void take(Floats before, Floats dot) { away = pick(more(before, nearest.square), dot, away); }
  TYPODONT_INLINE void meet_line(const MeridianPiece& piece, Floats rho, Floats z, Floats motion_rho, Floats motion_z) {
    const Floats before = nearest.square, nax = all(piece.nax), naz = all(piece.naz);
    nearest.meet_line(piece, rho, z);
    const Floats in = all(piece.ax) - rho, down = all(piece.az) - z, below = in * nax + down * naz,
                 along = in * naz - down * nax;
    const Floats over = along - greater(lesser(along, all(piece.length)), all(0.0f));
    take(before,
         all(0.0f) - (over * (motion_rho * naz - motion_z * nax) + below * (motion_rho * nax + motion_z * naz)));
  }
  TYPODONT_INLINE void meet_arc(const MeridianPiece& piece, Floats rho, Floats z, Floats motion_rho, Floats motion_z) {
    const Floats before = nearest.square, none = all(0.0f);
    nearest.meet_arc(piece, rho, z);
    const Floats ex = rho - all(piece.ax), ez = z - all(piece.az), vx = rho - all(piece.cx), vz = z - all(piece.cz);
    const Mask between =
        no_less(all(piece.ux) * vz - all(piece.uz) * vx, none) & no_less(vx * all(piece.wz) - vz * all(piece.wx), none);
    const Floats off = all(1.0f) - all(piece.radius) / greater(root(vx * vx + vz * vz), all(1e-6f));
    take(before, pick(between, off * (vx * motion_rho + vz * motion_z), ex * motion_rho + ez * motion_z));
  }
  TYPODONT_INLINE Mask deeper(Floats rho, Floats depth, Floats least) const {
    return may_be_deeper(depth, least, pick(nearest.outside, all(0.0f) - away, away),
                         rho * greater(depth, all(0.0f) - depth));
  }
};

/// `set`: bit mask of the examined pieces of the meridian.
TYPODONT_INLINE NearestOnPath nearest_on_path(const MeridianPiece* pieces, unsigned set, Floats rho, Floats z,
                                              Floats motion_rho, Floats motion_z) {
  NearestOnPath found{no_piece_yet(), all(0.0f)};
  for (; set != 0; set &= set - 1) {
    const MeridianPiece& piece = pieces[std::countr_zero(set)];
    piece.radius == 0.0f ? found.meet_line(piece, rho, z, motion_rho, motion_z)
                         : found.meet_arc(piece, rho, z, motion_rho, motion_z);
  }
  return found;
}

/// Upper bound of n·w over the outward normals n of the pieces `first` to `last`. `away`, `along`: components of the
/// motion w perpendicular to the axis and along it; `tip`: the sample may be nearest to a pointed end.
TYPODONT_INLINE Floats fastest_advance(const MeridianPiece& first, const MeridianPiece& last, Mask tip, Floats away,
                                       Floats along) {
  // The normal n rotates from that of the first piece (straight down at a tip) to that of the last piece. If it passes
  // the direction of w, |away| + |along| is the bound; otherwise the first or the last normal gives the largest n·w.
  const Floats none = all(0.0f), first_x = pick(tip, none, all(first.nax)),
               first_z = pick(tip, all(-1.0f), all(first.naz));
  const Mask between = no_less(first_x * along, first_z * away) & no_less(away * all(last.nbz), along * all(last.nbx));
  return pick(between, greater(away, none - away) + greater(along, none - along),
              greater(first_x * away + first_z * along, all(last.nbx) * away + all(last.nbz) * along));
}
