// Included once in each namespace of lane_ops.h. Depth in the head at rho (distance from its axis) and z (along it).
// To omit pieces that cannot be nearest does not change the depth: the result is bit-identical.

TYPODONT_INLINE Floats depth_below_line(const MeridianPiece& piece, Floats rho, Floats z) {
  return (all(piece.ax) - rho) * all(piece.nax) + (all(piece.az) - z) * all(piece.naz);
}

TYPODONT_INLINE Floats depth_below_arc(const MeridianPiece& piece, Floats rho, Floats z) {
  const Floats vx = rho - all(piece.cx), vz = z - all(piece.cz);
  return all(piece.radius) - root(vx * vx + vz * vz);
}

/// Squared distance of a point from the nearest tested piece of the meridian; whether it is outside any tested piece.
struct NearestPiece {
  Floats square;
  Mask outside;

  TYPODONT_INLINE void meet_line(const MeridianPiece& piece, Floats rho, Floats z) {
    const Floats in = all(piece.ax) - rho, down = all(piece.az) - z;
    const Floats below = in * all(piece.nax) + down * all(piece.naz);
    // `along`: distance along the line from its first end; `over`: distance beyond the nearer end, 0 between the ends.
    const Floats along = in * all(piece.naz) - down * all(piece.nax);
    const Floats over = along - greater(lesser(along, all(piece.length)), all(0.0f));
    square = lesser(square, below * below + over * over);
    outside |= more(all(0.0f), below);
  }
  TYPODONT_INLINE void meet_arc(const MeridianPiece& piece, Floats rho, Floats z) {
    const Floats none = all(0.0f);
    // Of the piece's two ends, tests only end a: end b is also end a of the next piece. End a may be the head's tip.
    const Floats ex = rho - all(piece.ax), ez = z - all(piece.az), vx = rho - all(piece.cx), vz = z - all(piece.cz);
    const Mask beyond = more(none, all(piece.dx) * ez - all(piece.dz) * ex);
    const Floats off = all(piece.radius) - root(vx * vx + vz * vz);
    const Mask between =
        no_less(all(piece.ux) * vz - all(piece.uz) * vx, none) & no_less(vx * all(piece.wz) - vz * all(piece.wx), none);
    square = lesser(square, pick(between, off * off, ex * ex + ez * ez));
    outside |= beyond & more(none, off);
  }
  TYPODONT_INLINE Floats depth() const {
    const Floats depth = root(square);
    return pick(outside, all(0.0f) - depth, depth);
  }
};

TYPODONT_INLINE NearestPiece no_piece_yet() {
  return {all(1e30f), nowhere()};
}

/// Depth of a point below the nearest of the meridian's pieces in the bit mask `set`.
TYPODONT_INLINE Floats depth_below_pieces(const MeridianPiece* pieces, unsigned set, Floats rho, Floats z) {
  NearestPiece nearest = no_piece_yet();
  for (; set != 0; set &= set - 1) {
    const MeridianPiece& piece = pieces[std::countr_zero(set)];
    if (piece.radius == 0.0f) {
      nearest.meet_line(piece, rho, z);
    } else {
      nearest.meet_arc(piece, rho, z);
    }
  }
  return nearest.depth();
}
