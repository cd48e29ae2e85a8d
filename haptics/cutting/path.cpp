// Cuts by heads that are not balls, along their path. Heads are convex, so the depth of a sample along its line in
// frame T is concave. Its maximum is searched after a long motion, otherwise only where needed.
#include "haptics/cutting/path.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "engine/base/dispatch.h"
#include "haptics/cutting/block.h"
#include "haptics/cutting/inside_fraction.h"
#include "haptics/cutting/lane_ops.h"
#include "haptics/sweep.h"
#include "haptics/volume/label.h"

namespace typodont::haptics {

namespace eight {
namespace {
#include "haptics/cutting/cut_kernel.h"
#include "haptics/cutting/depth_kernel.h"
#include "haptics/cutting/path_kernel.h"
#include "haptics/cutting/row_kernel.h"
}  // namespace
}  // namespace eight

namespace {

// largest tan(turning angle / 2) of the outline at the corners of a line that alone can determine the depth
constexpr float kRightAngle = 1.001f;
constexpr int kSteps = 24;  // largest number of search steps; almost always less than ten
// voxels, largest difference between the paths of a block's samples and that of its centre
constexpr float kBesideSlip = 0.5f;

/// Finds the z range of a column of blocks within `far` (voxels) of the axis. `off`: column centres relative to a point
/// of the axis; `height`: z of this point relative to a block's centre. Returns false if no block is that near.
bool column_beside_axis(const glm::vec2& off, const glm::vec3& axis, float far, float height, int& lowest,
                        int& highest) {
  // |d|² - (d·a)² <= far², solved for z (quadratic); d = (off, z), a: unit vector of the axis
  const float along = off.x * axis.x + off.y * axis.y;
  const float a = 1 - axis.z * axis.z, b = -along * axis.z, c = glm::dot(off, off) - along * along - far * far;
  if (a < 1e-3f) return true;
  const float root2 = b * b - a * c;
  if (root2 < 0) return false;
  const float root = std::sqrt(root2);
  const int from = static_cast<int>(std::floor(height + (-b - root) / a)) - 1,
            to = static_cast<int>(std::ceil(height + (-b + root) / a)) + 1;
  lowest = std::max(lowest, from - kRowLength);
  highest = std::min(highest, to);
  return lowest <= highest;
}

/// Eight points in frame T.
struct Points {
  F8 x, y, z;
};

TYPODONT_INLINE Points in_head(const HeadPose& pose, const F8& x, const F8& y, const F8& z) {
  const float* const R = pose.R;
  const F8 vx = x - pose.p[0], vy = y - pose.p[1], vz = z - pose.p[2];
  return {(R[0] * vx + R[3] * vy) + R[6] * vz, (R[1] * vx + R[4] * vy) + R[7] * vz,
          (R[2] * vx + R[5] * vy) + R[8] * vz};
}

/// Motions of eight samples that start at the positions `from`.
TYPODONT_INLINE Points paths_from(const Straight& path, const Points& from) {
  const float* const T = path.turn;
  return {(T[0] * from.x + T[3] * from.y) + (T[6] * from.z + path.shift[0]),
          (T[1] * from.x + T[4] * from.y) + (T[7] * from.z + path.shift[1]),
          (T[2] * from.x + T[5] * from.y) + (T[8] * from.z + path.shift[2])};
}

/// Second-order terms of the motions of eight samples, due to the head's rotation (Straight::bend_turn).
TYPODONT_INLINE Points bends_from(const Straight& path, const Points& from) {
  const float* const T = path.bend_turn;
  return {(T[0] * from.x + T[3] * from.y) + (T[6] * from.z + path.bend_shift[0]),
          (T[1] * from.x + T[4] * from.y) + (T[7] * from.z + path.bend_shift[1]),
          (T[2] * from.x + T[5] * from.y) + (T[8] * from.z + path.bend_shift[2])};
}

/// Depths of eight samples, and the derivatives of the depths along the paths.
struct Depth {
  F8 depth, slope;
};

/// Searches each of eight samples' largest depth on the path (error: kTop); stops if this depth is below `needed` or
/// above `most`. Steps alternate: intersection of two tangents of the depth (upper bound), maximum of a parabola.
struct Search {
  unsigned set;  // bit mask of pieces that can be nearest
  // of the eight samples, frame T: start points, motions, second-order terms of the motions
  Points from, path, bend;
  // fractions 0..1 of the path: the maximum lies between a and b; s: current position of the search
  F8 a, b, s;
  Depth at_a, at_b;
  F8 best, top, needed;
  I8 open;

  TYPODONT_INLINE Points place(const Straight& head, const F8& fraction) const {
    Points p{from.x + fraction * path.x, from.y + fraction * path.y, from.z + fraction * path.z};
    if (head.bent > 0) {
      const F8 off = fraction * (fraction - 1.0f);
      p.x += off * bend.x, p.y += off * bend.y, p.z += off * bend.z;
    }
    return p;
  }
  TYPODONT_INLINE eight::NearestWithNormal nearest(const Straight& head, const F8& rho, const F8& z) const {
    return eight::nearest_with_normal(head.pieces, set, rho, z);
  }
  TYPODONT_INLINE Depth at(const Straight& head, const F8& fraction) const {
    const Points p = place(head, fraction);
    const F8 rho = eight::root(p.x * p.x + p.y * p.y);
    const eight::NearestWithNormal found = nearest(head, rho, p.z);
    Points along = path;
    if (head.bent > 0) {
      const F8 off = 2.0f * fraction - 1.0f;
      along = {path.x + off * bend.x, path.y + off * bend.y, path.z + off * bend.z};
    }
    return {found.nearest.depth(), found.slope(p.x, p.y, rho, along.x, along.y, along.z)};
  }
  /// Head's outward normal nearest to each sample after the fraction `fraction` of its path, frame T.
  TYPODONT_INLINE Points normal(const Straight& head, const F8& fraction) const {
    const Points p = place(head, fraction);
    const F8 rho = eight::root(p.x * p.x + p.y * p.y), inverse = 1.0f / (rho + 1e-6f);
    F8 n_rho, n_z;
    nearest(head, rho, p.z).normal(n_rho, n_z);
    return {n_rho * p.x * inverse, n_rho * p.y * inverse, n_z};
  }
  /// Begins the search at `fraction` of the path. x, y, z: voxels relative to HeadPose::base of the first pose.
  TYPODONT_INLINE void begin(const Straight& head, unsigned pieces, const F8& x, const F8& y, const F8& z,
                             const F8& least, float fraction, float most) {
    set = pieces;
    from = in_head(head.from, x, y, z);
    path = paths_from(head, from);
    bend = head.bent > 0 ? bends_from(head, from) : Points{};
    needed = least - head.slip - head.bent;
    a = b = F8{} + fraction;
    at_a = at_b = at(head, a);
    best = at_a.depth;
    const I8 rises = at_a.slope > 0.0f;
    s = rises ? F8{} + 1.0f : F8{};
    top = best + at_a.slope * (s - a);
    open = (best < most) & (top > best + kTop) & (top > needed);
  }
  TYPODONT_INLINE void step(const Straight& head, int number, float most) {
    const Depth now = at(head, s);
    best = open ? eight::greater(best, now.depth) : best;
    // The depth's maximum lies between a and b. The position s replaces a if s is before the maximum, otherwise b. If
    // the depth still increases at an end of the path, the maximum is at this end.
    const I8 rises = (now.slope > 0.0f) & (s < 1.0f), before = open & (rises | (s <= 0.0f)), after = open & ~before;
    a = before ? s : a, at_a.depth = before ? now.depth : at_a.depth, at_a.slope = before ? now.slope : at_a.slope;
    b = after ? s : b, at_b.depth = after ? now.depth : at_b.depth, at_b.slope = after ? now.slope : at_b.slope;
    const I8 between = (at_a.slope > 0.0f) & (at_b.slope < 0.0f);
    const F8 rest = b - a, turn = at_a.slope - at_b.slope;
    const F8 inverse = 1.0f / eight::greater(turn, eight::all(1e-9f));
    const F8 by = eight::greater(eight::lesser((at_b.depth - at_a.depth - at_b.slope * rest) * inverse, rest), F8{});
    top = open ? between ? at_a.depth + at_a.slope * by : best : top;
    s = open & between ? a + (number % 2 == 0 ? by : at_a.slope * rest * inverse) : s;
    open &= (best < most) & (top > best + kTop) & (top > needed);
  }
};

/// Largest depths of eight samples on their paths, and the fractions of the paths and the places at which they occur.
struct Deepest {
  F8 fraction;
  Points at;
  F8 rho, below, depth;  // voxels: distance from the axis; height below the flank's lower end, or 0; depth
};

/// Returns the largest depths below a line, in closed form. If the line is a flank with a round end, the depth is the
/// radius minus the distance from a half-line on the axis; the squared distance is quadratic along the path.
TYPODONT_INLINE Deepest deepest_below(const Straight& head, int line_index, const Points& from) {
  const MeridianPiece& line = head.pieces[line_index];
  const Points path = paths_from(head, from);
  const F8 none = {}, one = none + 1.0f, least = none + 1e-12f;
  const F8 across2 = path.x * path.x + path.y * path.y, A = eight::greater(across2, least),
           B = from.x * path.x + from.y * path.y;
  F8 s = -B / A;
  if (line.naz != 0.0f) {
    // Depth: -nax rho - naz z + constant, with the normal (nax, naz) and the distance rho from the axis; rho² = A t² +
    // C, where t is measured from the smallest rho.
    const F8 rises = -line.naz * path.z, steepest = line.nax * line.nax * A - rises * rises;
    const F8 C = eight::greater(from.x * from.x + from.y * from.y - B * B / A, none);
    const F8 t = rises * eight::root(C / eight::greater(A * steepest, least));
    s = steepest > least ? s + t : rises > 0.0f ? one : none;
  }
  s = eight::greater(eight::lesser(s, one), none);
  const bool round = has_round_end(head.pieces, line_index);
  if (round) {
    // The head is convex. If the point nearest to the round end's centre is below this centre, it is the deepest point;
    // otherwise the point nearest to the axis is the deepest.
    const F8 above = from.z - line.az;
    F8 at_end = -(B + above * path.z) / eight::greater(across2 + path.z * path.z, least);
    at_end = eight::greater(eight::lesser(at_end, one), none);
    s = above + at_end * path.z <= 0.0f ? at_end : s;
  }
  Deepest found{s, {from.x + s * path.x, from.y + s * path.y, from.z + s * path.z}, none, none, none};
  // Uses the position of the maximum on the straight path. Its small error changes the depth only to second order.
  if (head.bent > 0) {
    const Points bend = bends_from(head, from);
    const F8 off = s * (s - 1.0f);
    found.at = {found.at.x + off * bend.x, found.at.y + off * bend.y, found.at.z + off * bend.z};
  }
  found.rho = eight::root(found.at.x * found.at.x + found.at.y * found.at.y);
  if (round) {
    found.below = eight::lesser(found.at.z - line.az, none);
    found.depth = line.ax - eight::root(found.rho * found.rho + found.below * found.below);
  } else {
    found.depth = eight::depth_below_line(line, found.rho, found.at.z);
  }
  return found;
}

/// Largest depths of eight block centres on their paths. Depth is concave, so a linear bound (n_x, n_y, n_z) is valid
/// for the whole blocks.
struct Centres {
  unsigned set;  // input: bit mask of the pieces of the head's outline that can be nearest to the centres
  // Input, voxels: the search ends early if the largest depth is certainly below `outside` or above `emptied`.
  float outside, emptied;
  F8 x, y, z;    // voxels relative to HeadPose::base of the first pose
  F8 best, top;  // lower and upper bound of the largest depth
  // Outward normal n: at the offset d (voxels), the depth is at most `top` − n · d, except for rounding and rotation.
  F8 n_x, n_y, n_z;
  F8 fraction;  // fraction of the path at which the centre is deepest
};

TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
void examine_centres(const Straight* path_at, Centres* centres) {
  const Straight& path = *path_at;
  Search search;
  search.begin(path, centres->set, centres->x, centres->y, centres->z, eight::all(centres->outside), 0.5f,
               centres->emptied);
  for (int step = 0; step < kSteps && any_of(search.open); ++step) search.step(path, step, centres->emptied);
  // The depth is below its tangents at the positions a and b, so also below their weighted mean. The weights make this
  // mean constant along the path.
  const F8 up = search.at_a.slope, down = search.at_b.slope;
  const I8 at_a = up <= 0.0f, at_b = ~at_a & (down >= 0.0f);
  const F8 part = at_a ? eight::all(1) : at_b ? F8{} : down / (down - up);
  const Points a = search.normal(path, search.a), b = search.normal(path, search.b);
  const F8 nx = b.x + part * (a.x - b.x), ny = b.y + part * (a.y - b.y), nz = b.z + part * (a.z - b.z);
  const float* const R = path.from.R;
  centres->n_x = R[0] * nx + R[1] * ny + R[2] * nz;
  centres->n_y = R[3] * nx + R[4] * ny + R[5] * nz;
  centres->n_z = R[6] * nx + R[7] * ny + R[8] * nz;
  centres->best = search.best, centres->top = search.top;
  centres->fraction = at_a ? search.a : at_b ? search.b : search.s;
}

/// Like examine_centres(), but in closed form, for blocks in which the line `line` alone determines the depth.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
void examine_line(const Straight* path_at, Centres* centres, int line) {
  const Straight& path = *path_at;
  const Deepest found = deepest_below(path, line, in_head(path.from, centres->x, centres->y, centres->z));
  const MeridianPiece& piece = path.pieces[line];
  const F8 least = F8{} + 1e-6f;
  F8 nx, ny, nz;
  if (has_round_end(path.pieces, line)) {
    const F8 inverse = 1.0f / eight::greater(piece.ax - found.depth, least);
    nx = found.at.x * inverse, ny = found.at.y * inverse, nz = found.below * inverse;
  } else {
    const F8 inverse = piece.nax / eight::greater(found.rho, least);
    nx = found.at.x * inverse, ny = found.at.y * inverse, nz = F8{} + piece.naz;
  }
  const float* const R = path.from.R;
  centres->n_x = R[0] * nx + R[1] * ny + R[2] * nz;
  centres->n_y = R[3] * nx + R[4] * ny + R[5] * nz;
  centres->n_z = R[6] * nx + R[7] * ny + R[8] * nz;
  centres->best = centres->top = found.depth;
  centres->fraction = found.fraction;
}

/// Eight block centres at the start of the path: their depths, and distances from each piece of the meridian.
struct AtStart {
  F8 depth, to_piece[HeadField::kMaxPieces];
  Points at;  // positions of the block centres in the head's frame
  // For each block: index of the line of the meridian that alone determines all depths below Sweep::kInner; -1: none.
  int line[8];
  F8 rho;  // voxels, distance from the axis
  // true: the head recedes from all samples of the block, so their depths are largest at the path's start
  I8 recedes;

  /// Bit mask of the pieces that can be nearest to a point within `reach` of the block's centre at the path's start.
  unsigned nearest_within(float reach, int lane, int count) const {
    unsigned set = 0;
    for (int i = 0; i < count; ++i) {
      set |= static_cast<unsigned>(to_piece[i][lane] <= std::abs(depth[lane]) + 2 * reach) << i;
    }
    return set;
  }
};

TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
void examine_start(const Straight* path_at, const Centres* centres, AtStart* found) {
  const Straight& path = *path_at;
  const Points p = in_head(path.from, centres->x, centres->y, centres->z);
  const F8 rho = eight::root(p.x * p.x + p.y * p.y);
  found->depth = eight::depth_below_pieces(path.pieces, (1u << path.count) - 1, rho, p.z);
  found->at = p, found->rho = rho;
}

/// Blocks from which the head recedes: n·w > 0 (n: head's normal, w: motion of samples). `rounding`: error of n·w.
TYPODONT_INLINE I8 receding(const Straight& path, const AtStart& at, float rounding) {
  const F8 x = at.at.x, y = at.at.y, none = {};
  const auto [wx, wy, wz] = paths_from(path, at.at);
  // First and last piece of the meridian that can be nearest to a sample, with normals.
  const F8 within = (at.depth > 0.0f ? at.depth : -at.depth) + 2 * kHalf;
  F8 first_x = none, first_z = none, last_x = none, last_z = none;
  I8 from_axis = {};
  for (int i = 0; i < path.count; ++i) {
    const MeridianPiece& piece = path.pieces[i];
    const I8 near = at.to_piece[i] <= within;
    last_x = near ? eight::all(piece.nbx) : last_x, last_z = near ? eight::all(piece.nbz) : last_z;
  }
  for (int i = path.count - 1; i >= 0; --i) {
    const MeridianPiece& piece = path.pieces[i];
    const I8 near = at.to_piece[i] <= within;
    first_x = near ? eight::all(piece.nax) : first_x, first_z = near ? eight::all(piece.naz) : first_z;
    from_axis = near ? I8{} - (piece.ax == 0.0f) : from_axis;
  }
  const I8 tip = from_axis & (at.rho < kHalf + Sweep::kMargin);
  first_x = tip ? none : first_x, first_z = tip ? eight::all(-1) : first_z;
  // Smallest radial component (away from the head's axis) of the motion w of the samples within kHalf of the centre.
  const F8 across = eight::root(wx * wx + wy * wy), inverse = 1.0f / eight::greater(at.rho, eight::all(kHalf));
  const F8 ux = x * inverse, uy = y * inverse, sine = kHalf * inverse, radial = wx * ux + wy * uy;
  const F8 cosine = eight::root(eight::greater(1.0f - sine * sine, none)), around = wx * uy - wy * ux;
  const F8 round = around < 0.0f ? -around : around;
  const I8 beside = (at.rho > kHalf) & (round * cosine > -radial * sine);
  const F8 away = beside ? round * sine - radial * cosine : across, along = -wz;
  const I8 between = (first_x * along >= first_z * away) & (away * last_z >= along * last_x);
  const F8 ends = eight::greater(first_x * away + first_z * along, last_x * away + last_z * along);
  // Largest n·(-w) (n: normal, w: motion of a sample), which is the negative of the smallest n·w.
  const F8 approach = between ? eight::root(away * away + along * along) : ends;
  return -approach >= path.turned * kHalf + rounding;
}

/// Finds the line of the meridian that alone determines a block's depths (AtStart::line). Depths in a block differ from
/// the centre's by at most kHalf. The depth below a line is concave along the path, so it is smallest at a path end.
TYPODONT_INLINE void find_lines(const Straight& path, AtStart& at) {
  const F8 z = at.at.z;
  const auto [wx, wy, wz] = paths_from(path, at.at);
  const F8 end_x = at.at.x + wx, end_y = at.at.y + wy, end_rho = eight::root(end_x * end_x + end_y * end_y);
  const F8 across = eight::root(wx * wx + wy * wy), up = wz < 0.0f ? -wz : wz;
  const float beside = (1 + path.turned) * kHalf + kTop;
  I8 found = I8{} - 1;
  for (int i = 0; i < path.count; ++i) {
    const MeridianPiece& line = path.pieces[i];
    const bool round = has_round_end(path.pieces, i);
    if (line.radius != 0.0f || (!round && line.corner_a > kRightAngle) || line.corner_b > kRightAngle) continue;
    // distances of the block centres from both ends of the meridian's line, measured along this line
    const F8 from_a = (z - line.az) * line.nax - (at.rho - line.ax) * line.naz, from_b = line.length - from_a;
    const F8 reach_beside = beside + std::abs(line.nax) * up + std::abs(line.naz) * across;
    I8 alone = from_b > reach_beside + Sweep::kInner * line.corner_b;
    if (!round) alone &= from_a > reach_beside + Sweep::kInner * line.corner_a;
    for (int k = 0; k < path.count; ++k) {
      const MeridianPiece& other = path.pieces[k];
      if (std::abs(k - i) < 2) continue;
      const F8 least =
          eight::lesser(eight::depth_below_line(other, at.rho, z), eight::depth_below_line(other, end_rho, z + wz));
      alone = other.radius == 0.0f ? alone & (least > Sweep::kInner + beside) : I8{};
    }
    found = alone ? I8{} + i : found;
  }
  for (int lane = 0; lane < 8; ++lane) at.line[lane] = found[lane];
}

/// Computes the members to_piece, recedes and line of an AtStart. Not needed if none of its eight blocks can change.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
void examine_pieces(const Straight* path_at, AtStart* found, float rounding) {
  const Straight& path = *path_at;
  for (int i = 0; i < path.count; ++i) {
    // depth_below_pieces() ignores the end b of an arc, which belongs to the next piece; to_piece includes the end b.
    const F8 depth = eight::depth_below_pieces(path.pieces, 1u << i, found->rho, found->at.z),
             off_rho = found->rho - path.pieces[i].bx, off_z = found->at.z - path.pieces[i].bz;
    found->to_piece[i] = eight::lesser(depth > 0.0f ? depth : -depth, eight::root(off_rho * off_rho + off_z * off_z));
  }
  found->recedes = receding(path, *found, rounding);
  find_lines(path, *found);
}

/// Smallest depth of a block at the start of the path. Depth is concave, so this is the depth of a corner. `first`:
/// relative to HeadPose::base of the first pose.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
float min_depth_at_start(const Straight* path_at, const glm::ivec3* first) {
  const Straight& path = *path_at;
  constexpr float kX = kRows - 1, kZ = kRowLength - 1;
  const F8 x = static_cast<float>(first->x) + F8{0, 0, 0, 0, kX, kX, kX, kX},
           y = static_cast<float>(first->y) + F8{0, 0, kX, kX, 0, 0, kX, kX},
           z = static_cast<float>(first->z) + F8{0, kZ, 0, kZ, 0, kZ, 0, kZ};
  const Points p = in_head(path.from, x, y, z);
  const F8 depth =
      eight::depth_below_pieces(path.pieces, (1u << path.count) - 1, eight::root(p.x * p.x + p.y * p.y), p.z);
  float least = depth[0];
  for (int i = 1; i < 8; ++i) least = depth[i] < least ? depth[i] : least;
  return least;
}

/// The processed part of a block, and bounds of the depth at the block's centre.
struct PathBlock {
  float* distance;
  const Tissue* tissue;
  std::ptrdiff_t stride_x, stride_y;
  int from[3], to[3];
  glm::ivec3 first;  // first sample, relative to HeadPose::base of the first pose
  float top, n[3], fraction;
  // voxels, error of using the centre's path for all samples
  float bent;
  float* due;    // path length at which the block must be examined next; null: not stored
  unsigned set;  // bit mask of pieces that can be nearest
  // index of the line that alone determines all depths of this block (AtStart::line); -1: none
  int line;
  bool emptied;

  /// Upper bound of the depth in the row through the block's centre, minus the bound in row (ix, iy), voxels.
  float off(int ix, int iy) const {
    return n[0] * (static_cast<float>(ix) - kMiddle.x) + n[1] * (static_cast<float>(iy) - kMiddle.y);
  }
  /// Upper bound of the depth in the row through the block's centre, voxels.
  float most() const { return top + bent + std::abs(n[2]) * kMiddle.z; }
  /// Voxels by which all samples of row (ix, iy) are, at least, too far from the head to change. Negative: a sample may
  /// change; always negative if `emptied`.
  float unread(int ix, int iy) const { return emptied ? -1.0f : -Sweep::kMargin - (most() - off(ix, iy)); }
  /// Upper bound of the depths of all samples in the block, voxels.
  float most_of_all() const { return most() + std::abs(n[0]) * kMiddle.x + std::abs(n[1]) * kMiddle.y; }
  bool may_change() const { return emptied || most_of_all() > -Sweep::kMargin; }
};

/// Prefetches the rows that carve_path_block() will read.
void fetch(const PathBlock& block) {
  for (int ix = block.from[0]; ix < block.to[0]; ++ix) {
    for (int iy = block.from[1]; iy < block.to[1]; ++iy) {
      if (block.unread(ix, iy) < 0) {
        __builtin_prefetch(block.distance + ix * block.stride_x + iy * block.stride_y, 1);
      }
    }
  }
}

/// Raises each sample to max(old, min(depth, kInner)), ignoring depths below -kMargin (kInner 3, kMargin 3.5 voxels).
/// Returns true if a sample changed. `safe_travel`: voxels of motion until a sample can change.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
bool carve_path_block(const Straight* path_at, const PathBlock* block_at, RemovedVolume* removed, float* safe_travel) {
  const Straight& path = *path_at;
  const PathBlock& block = *block_at;
  const F8 steps = {0, 1, 2, 3, 4, 5, 6, 7}, bound = block.top + block.bent - block.n[2] * (steps - kMiddle.z);
  const F8 z = static_cast<float>(block.first.z) + steps;
  // All rows make one step of the search before the next step, so that no row waits for its own results.
  constexpr int kAll = kRows * kRows;
  const bool whole = block.from[2] == 0 && block.to[2] == kRowLength;
  Search searches[kAll];
  std::ptrdiff_t at[kAll];
  int rows = 0, open = 0, still_open[kAll];
  // voxels, motion of the head after which a sample can change in a row whose samples are not loaded
  float unread = kNoEnd;
  F8 read = F8{} + kNoEnd;  // voxels, motion after which a sample in a loaded row can change
  for (int ix = block.from[0]; ix < block.to[0]; ++ix) {
    for (int iy = block.from[1]; iy < block.to[1]; ++iy) {
      if (const float reach_beside = block.unread(ix, iy); reach_beside >= 0) {
        unread = std::min(unread, reach_beside);
        continue;
      }
      at[rows] = ix * block.stride_x + iy * block.stride_y;
      const F8 old = eight::Row{block.distance + at[rows], block.from[2], block.to[2], whole}.read();
      const I8 full = old >= Sweep::kInner;  // the sample already has the largest value
      const float off = block.off(ix, iy);
      const F8 least = full ? F8{} + kNoEnd : eight::greater(old, F8{} - Sweep::kMargin);
      if (!any_of(block.emptied ? ~full : bound - off > least)) {
        read = eight::lesser(read, least - (bound - off));
        continue;
      }
      Search& search = searches[rows];
      if (block.emptied) {
        search.best = F8{} + Sweep::kInner;
      } else if (block.line >= 0) {
        const Points from = in_head(path.from, eight::all(static_cast<float>(block.first.x + ix)),
                                    eight::all(static_cast<float>(block.first.y + iy)), z);
        search.best = deepest_below(path, block.line, from).depth;
      } else {
        search.begin(path, block.set, eight::all(static_cast<float>(block.first.x + ix)),
                     eight::all(static_cast<float>(block.first.y + iy)), z, least, block.fraction, Sweep::kInner);
        still_open[open] = rows;
        open += any_of(search.open);
      }
      ++rows;
    }
  }
  *safe_travel = unread;
  for (int i = 0; i < 8; ++i) *safe_travel = std::min(*safe_travel, read[i]);
  if (rows > 0) *safe_travel = block.emptied ? kNoEnd : 0;
  for (int step = 0; step < kSteps && open > 0; ++step) {
    int left = 0;
    for (int i = 0; i < open; ++i) {
      Search& search = searches[still_open[i]];
      search.step(path, step, Sweep::kInner);
      still_open[left] = still_open[i];
      left += any_of(search.open);
    }
    open = left;
  }
  bool changed = false;
  eight::Taken taken{removed};
  for (int row = 0; row < rows; ++row) {
    const eight::Row samples{block.distance + at[row], block.from[2], block.to[2], whole};
    const F8 old = samples.read(), depth = eight::lesser(searches[row].best, F8{} + Sweep::kInner);
    const I8 raised = depth > eight::greater(old, F8{} - Sweep::kMargin);
    if (!any_of(raised)) continue;
    changed = true;
    samples.write(old, raised ? depth : old, removed ? block.tissue + at[row] : nullptr, taken);
  }
  if (removed) taken.close();
  return changed;
}

/// Raises the values of eight samples of the list PathMaxima to the largest depth that each sample has on the path.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
bool carve_tops(PathMaxima* tops_at, int first) {
  PathMaxima& tops = *tops_at;
  const int count = std::min(tops.count - first, 8);
  F8 x, y, z, old;
  for (int i = 0; i < 8; ++i) {
    const int lane = first + std::min(i, count - 1);
    x[i] = tops.x[lane], y[i] = tops.y[lane], z[i] = tops.z[lane], old[i] = *tops.at[lane];
  }
  Search search;
  const F8 least = eight::greater(old, F8{} - Sweep::kMargin);
  search.begin(tops.back, (1u << tops.back.count) - 1, x, y, z, least, 0, Sweep::kInner);
  // First evaluates the sweep's start pose, where the head has cut already.
  search.step(tops.back, 0, Sweep::kInner);
  const F8 at_ends = search.best;
  for (int step = 1; step < kSteps && any_of(search.open); ++step) search.step(tops.back, step, Sweep::kInner);
  const F8 depth = eight::lesser(search.best, F8{} + Sweep::kInner);
  const unsigned raised = bits_of((depth > least) & (search.best > at_ends + kTop));
  for (int i = 0; i < count; ++i) {
    if (!(raised >> i & 1)) continue;
    *tops.at[first + i] = depth[i];
    if (tops.removed)
      tops.removed->add(inside_units(old[i]) - inside_units(depth[i]), static_cast<Tissue>(tops.label[first + i]),
                        tops.at[first + i]);
  }
  return raised & ((1u << count) - 1);
}

}  // namespace

void PathMaxima::carve() noexcept {
  for (int first = 0; first < count; first += 8) changed |= carve_tops(this, first);
  count = 0;
}

Straight straight_path(const Pose& X_VA, const Pose& X_VB, const MeridianPiece* pieces, int count, double reach) {
  const glm::dmat3 R_AV = glm::transpose(glm::dmat3(X_VA.R)), R_BV = glm::transpose(glm::dmat3(X_VB.R));
  const dvec3 moved = R_BV * (X_VA.p - X_VB.p);
  // R − 1 for the rotation R from pose A to pose B, computed without cancellation.
  const glm::dmat3 turn = (R_BV - R_AV) * glm::transpose(R_AV);
  Straight path{.from = head_pose(X_VA),
                .shift = {},
                .turn = {},
                .pieces = pieces,
                .count = count,
                .turned = 0,
                .longest = 0,
                .slip = 0};
  double turned = 0;
  for (int i = 0; i < 3; ++i) {
    path.shift[i] = static_cast<float>(moved[i]);
    for (int j = 0; j < 3; ++j)
      path.turn[3 * i + j] = static_cast<float>(turn[i][j]), turned += turn[i][j] * turn[i][j];
  }
  // The rotation R moves a sample by at most its distance × √(half the sum of the squared elements of R − 1). A sample
  // may be up to `beyond` (voxels) outside the head.
  const double beyond = static_cast<double>(Sweep::kMargin) + 1;
  path.turned = static_cast<float>(std::sqrt(turned / 2));
  path.longest = static_cast<float>(glm::length(moved) + std::sqrt(turned / 2) * (reach + beyond)) + 1e-5f;
  // Error of a tangent to the depth, voxels: depth's rounding + effect of corners (2 kNear) + slope's rounding.
  path.slip = 1e-3f + 4e-6f * static_cast<float>(reach) + 2 * kNear + 1e-3f * path.longest;
  return path;
}

void bend(Straight& path, const Pose& X_VA, const Pose& X_VM, double reach) {
  const Straight half = straight_path(X_VA, X_VM, path.pieces, path.count, reach);
  double turned = 0, shifted = 0;
  for (int i = 0; i < 3; ++i) {
    path.bend_shift[i] = 4 * (path.shift[i] / 2 - half.shift[i]);
    shifted += static_cast<double>(path.bend_shift[i]) * static_cast<double>(path.bend_shift[i]);
  }
  for (int i = 0; i < 9; ++i) {
    path.bend_turn[i] = 4 * (path.turn[i] / 2 - half.turn[i]);
    turned += static_cast<double>(path.bend_turn[i]) * static_cast<double>(path.bend_turn[i]);
  }
  const double beyond = reach + static_cast<double>(Sweep::kMargin) + 1;
  path.bent = static_cast<float>((std::sqrt(shifted) + std::sqrt(turned) * beyond) / 4) + 1e-6f;
}

bool has_round_end(const MeridianPiece* pieces, int i) {
  const MeridianPiece& flank = pieces[i];
  return i > 0 && flank.radius == 0.0f && flank.naz == 0.0f && pieces[i - 1].radius == flank.ax &&
         pieces[i - 1].cx == 0.0f && pieces[i - 1].cz == flank.az;
}

float* DueBlocks::row(const glm::ivec3& voxel, int last_z) const noexcept {
  const glm::ivec3 step(kRows, kRows, kRowLength), i = voxel / step - first;
  if (i.x < 0 || i.y < 0 || i.z < 0 || i.x >= size.x || i.y >= size.y) return nullptr;
  if (i.z + (last_z - voxel.z) / kRowLength >= size.z) return nullptr;
  return due + (i.x * size.y + i.y) * size.z + i.z;
}

namespace {

/// Cuts along one straight part of the path. choose(), examine() and cut() process eight blocks at a time, while the
/// next eight are loaded.
class PathPass {
 public:
  /// `part` of the path; `cut_before`: its start has been cut; `turned`: voxels, difference between the paths of a
  /// sample and the centre; `rounding`: voxels, rounding error along a normal; `known`: receives the path lengths at
  /// which blocks must be examined next; null if another part follows.
  PathPass(const Straight& part, bool cut_before, float turned, float rounding, const HeadTarget& target,
           RemovedVolume* removed, const DueBlocks* known)
      : path_(part),
        cut_before_(cut_before),
        turned_(turned),
        rounding_(rounding),
        target_(target),
        removed_(removed),
        known_(known),
        outside_(-(Sweep::kMargin + kHalf + kTop + part.slip + part.bent)),
        emptied_(Sweep::kInner + kHalf + part.slip + part.bent) {}

  /// Adds the block whose first voxel is `first`. `due`: receives the path length of its next examination; may be null.
  void add(const glm::ivec3& first, float* due) {
    begun_[started_] = first;
    due_[started_] = due;
    put(starts_, started_, glm::vec3(first - path_.from.base) + kMiddle);
    if (++started_ == 8) choose();
  }
  /// Completes the cut. Returns true if a sample changed.
  bool finish() {
    if (started_ > 0) choose();
    for (int group = 0; group <= HeadField::kMaxPieces; ++group) {
      if (groups_[group].count > 0) examine(group);
    }
    for (int i = 0; i < waiting_; ++i) cut(fetched_[i]);
    return changed_;
  }

 private:
  /// Blocks whose largest depth is computed in the same way: one group for each line (closed form), and one group for
  /// search.
  struct Group {
    int count = 0;
    Centres centres;
    PathBlock blocks[8];
  };

  static void put(Centres& to, int lane, const glm::vec3& c) { to.x[lane] = c.x, to.y[lane] = c.y, to.z[lane] = c.z; }
  static void fill_up(Centres& to, int from) {
    for (int lane = from; lane < 8; ++lane) to.x[lane] = to.x[0], to.y[lane] = to.y[0], to.z[lane] = to.z[0];
  }
  void note(float* at, float safe_travel) const {
    if (at && known_) *at = known_->path_length + (safe_travel - known_->slip);
  }

  /// Drops blocks that are too far away on the whole path, and, if the start has been cut, blocks that are empty or
  /// from which the head recedes.
  void choose() {
    fill_up(starts_, started_);
    AtStart at;
    examine_start(&path_, &starts_, &at);
    bool pieces_seen = false;
    for (int lane = 0; lane < started_; ++lane) {
      if (const float top = at.depth[lane] + path_.longest + kBesideSlip; top < outside_) {
        note(due_[lane], outside_ - top);
        continue;
      }
      const float empty = Sweep::kInner + path_.slip + path_.bent;
      if (cut_before_ && at.depth[lane] > empty) {
        const glm::ivec3 in_base = begun_[lane] - path_.from.base;
        if (at.depth[lane] > emptied_ || min_depth_at_start(&path_, &in_base) > empty) {
          note(due_[lane], kNoEnd);
          continue;
        }
      }
      if (!pieces_seen) examine_pieces(&path_, &at, rounding_);
      pieces_seen = true;
      if (cut_before_ && at.recedes[lane]) continue;
      const int line = at.line[lane];
      Group& group = groups_[line >= 0 ? line : HeadField::kMaxPieces];
      PathBlock& block = group.blocks[group.count];
      place(block, begun_[lane]);
      block.due = due_[lane];
      block.line = line;
      block.set = at.nearest_within(kHalf + path_.longest + kBesideSlip, lane, path_.count);
      put(group.centres, group.count, {starts_.x[lane], starts_.y[lane], starts_.z[lane]});
      if (++group.count == 8) examine(line >= 0 ? line : HeadField::kMaxPieces);
    }
    started_ = 0;
  }
  void place(PathBlock& block, const glm::ivec3& first) const {
    const glm::ivec3 inside = first - target_.lo;
    const std::ptrdiff_t at = inside.x * target_.stride_x + inside.y * target_.stride_y + inside.z;
    block.distance = target_.distance + at, block.tissue = target_.tissue ? target_.tissue + at : nullptr;
    block.stride_x = target_.stride_x, block.stride_y = target_.stride_y;
    const int size[3] = {kRows, kRows, kRowLength};
    for (int i = 0; i < 3; ++i) {
      block.from[i] = std::max(-inside[i], 0);
      block.to[i] = std::min(target_.size[i] - inside[i], size[i]);
    }
    block.first = first - path_.from.base;
  }
  /// Computes the bounds of the depths in a group of blocks and prefetches its rows; meanwhile, earlier blocks are cut.
  void examine(int which) {
    Group& group = groups_[which];
    Centres& centres = group.centres;
    fill_up(centres, group.count);
    centres.set = 0;
    for (int lane = 0; lane < group.count; ++lane) centres.set |= group.blocks[lane].set;
    centres.outside = outside_, centres.emptied = emptied_;
    if (which < HeadField::kMaxPieces) {
      examine_line(&path_, &centres, which);
    } else {
      examine_centres(&path_, &centres);
    }
    int kept[8], keep = 0;
    for (int lane = 0; lane < group.count; ++lane) {
      PathBlock& block = group.blocks[lane];
      if (centres.top[lane] <= outside_) {
        note(block.due, outside_ - centres.top[lane]);
        continue;
      }
      block.top = centres.top[lane], block.fraction = centres.fraction[lane],
      block.emptied = centres.best[lane] >= emptied_;
      block.bent = path_.slip + kTop + turned_ + path_.bent;
      block.n[0] = centres.n_x[lane], block.n[1] = centres.n_y[lane], block.n[2] = centres.n_z[lane];
      if (!block.may_change()) {
        note(block.due, -Sweep::kMargin - block.most_of_all());
        continue;
      }
      kept[keep++] = lane;
    }
    for (int i = 0; i < std::max(keep, waiting_); ++i) {
      if (i < keep) fetch(group.blocks[kept[i]]);
      if (i < waiting_) cut(fetched_[i]);
    }
    for (int i = 0; i < keep; ++i) fetched_[i] = group.blocks[kept[i]];
    waiting_ = keep;
    group.count = 0;
  }
  void cut(const PathBlock& block) {
    float safe_travel;
    changed_ |= carve_path_block(&path_, &block, removed_, &safe_travel);
    note(block.due, safe_travel);
  }

  const Straight path_;
  const bool cut_before_;
  const float turned_, rounding_;
  const HeadTarget& target_;
  RemovedVolume* const removed_;
  const DueBlocks* const known_;
  // voxels, depths of a block's centre: below outside_ it is unchanged, above emptied_ it becomes empty
  const float outside_, emptied_;
  bool changed_ = false;
  int started_ = 0;
  Centres starts_;
  glm::ivec3 begun_[8];
  float* due_[8];
  Group groups_[HeadField::kMaxPieces + 1];
  int waiting_ = 0;
  PathBlock fetched_[8];  // blocks whose rows have been prefetched
};

}  // namespace

bool Sweep::carve_path(const HeadTarget& target, RemovedVolume* removed, const DueBlocks* known) const noexcept {
  const auto down = [](int v, int step) { return v - (v % step + step) % step; };
  const float turned = static_cast<float>(turn_ / straights_) * kHalf;
  const double radius = static_cast<double>(radius_);
  const float rounding = 4e-6f * (static_cast<float>(reach_) + 8);
  const auto axis_of = [](const Pose& X) { return X.R * dvec3(0, 0, 1); };
  // voxels; distance from the head within which a cut changes samples, plus one for the curvature of the path
  const double beside = static_cast<double>(kMargin) + 1;
  const auto extent = [&](const Pose& X) {
    const dvec3 axis = axis_of(X), across = glm::sqrt(glm::max(dvec3(1) - axis * axis, dvec3(0)));
    return half_length_ * glm::abs(axis) + radius * across + beside;
  };
  const auto is_whole = [&](const glm::ivec3& first) {
    return glm::all(glm::lessThanEqual(target.lo, first)) &&
           glm::all(glm::lessThanEqual(first + glm::ivec3(kRows, kRows, kRowLength), target.lo + target.size));
  };
  bool changed = false;
  Pose X_VB = X_VA_;
  for (int k = 1; k <= straights_; ++k) {
    const Pose X_VA = X_VB;
    X_VB = k == straights_ ? X_VB_ : interpolate(X_VA_, X_VB_, static_cast<double>(k) / straights_);
    Straight path = straight_path(X_VA, X_VB, pieces_, back_.count, reach_);
    if (bends_) bend(path, X_VA, interpolate(X_VA, X_VB, 0.5), reach_);
    const dvec3 extent_a = extent(X_VA), extent_b = extent(X_VB);
    const glm::ivec3 lo = glm::max(target.lo, glm::ivec3(glm::ceil(glm::min(X_VA.p - extent_a, X_VB.p - extent_b))));
    const glm::ivec3 last =
        glm::min(target.lo + target.size - 1, glm::ivec3(glm::floor(glm::max(X_VA.p + extent_a, X_VB.p + extent_b))));
    // A block farther than `far` from the head's axis at the start A is outside the head on the whole path.
    const glm::vec3 axis(axis_of(X_VA)), center(X_VA.p - dvec3(path.from.base));
    const float far = static_cast<float>(radius + beside) + kHalf + path.longest;
    const glm::ivec3 first(down(lo.x, kRows), down(lo.y, kRows), down(lo.z, kRowLength));
    // Only the last part stores the path lengths at which blocks must be examined next.
    PathPass pass(path, continues_ || k > 1, turned, rounding, target, removed, k == straights_ ? known : nullptr);
    for (int x0 = first.x; x0 <= last.x; x0 += kRows) {
      for (int y0 = first.y; y0 <= last.y; y0 += kRows) {
        int lowest = first.z, highest = last.z;
        if (!column_beside_axis(
                glm::vec2(x0 - path.from.base.x, y0 - path.from.base.y) + glm::vec2(kMiddle) - glm::vec2(center), axis,
                far, static_cast<float>(path.from.base.z) + center.z - kMiddle.z, lowest, highest))
          continue;
        const int lowest_first = first.z + down(lowest - first.z, kRowLength);
        float* const row = known ? known->row({x0, y0, lowest_first}, highest) : nullptr;
        for (int z0 = lowest_first; z0 <= highest; z0 += kRowLength) {
          const glm::ivec3 from(x0, y0, z0);
          float* const noted = row ? row + (z0 - lowest_first) / kRowLength : nullptr;
          if (noted && *noted > known->path_length) continue;
          pass.add(from, noted && is_whole(from) ? noted : nullptr);
        }
      }
    }
    changed |= pass.finish();
  }
  return changed;
}

}  // namespace typodont::haptics
