// Computes cuts along the path of a head that is not a ball. A head is convex, so the depth of a sample is a concave
// function of its position. During a short motion, a sample moves along a straight line in the head's frame. So its
// depth along the path is a concave curve with a single maximum, which a search finds. After a long motion, the search
// runs for all samples; after a short one, only for those that may have been deeper than at the end.
#include "haptics/cutting/way.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "engine/base/dispatch.h"
#include "haptics/cutting/block.h"
#include "haptics/cutting/lane_ops.h"
#include "haptics/inside_fraction.h"
#include "haptics/label.h"
#include "haptics/sweep.h"

namespace typodont::haptics {

namespace eight {
namespace {
#include "haptics/cutting/cut_kernel.h"
#include "haptics/cutting/depth_kernel.h"
#include "haptics/cutting/row_kernel.h"
#include "haptics/cutting/way_kernel.h"
}  // namespace
}  // namespace eight

namespace {

// Limit of the tangent of half the angle between the normals at a corner of the head's outline. At a sharper corner,
// the depth is not computed from one line alone.
constexpr float kRightAngle = 1.001f;
constexpr int kSteps = 24;  // largest number of steps of one search; almost every search needs fewer than ten
// voxels, upper bound of the error that results if the path of a block's centre is used for all samples of the block
constexpr float kBesideSlip = 0.5f;

/// Restricts the range `lowest` .. `highest` of z coordinates in a column of blocks of samples. It keeps the blocks
/// that are nearer than `far` (voxels) to the head's axis. `off`: x and y coordinates of the blocks' centres, relative
/// to a point of the axis. `height`: z coordinate of this point of the axis, minus the offset of a block's centre from
/// its first sample. Returns false if no block of samples remains.
bool column_beside_axis(const glm::vec2& off, const glm::vec3& axis, float far, float height, int& lowest,
                        int& highest) {
  // the condition |d|² - (d·a)² <= far² with d = (off, z) is quadratic in z; a: unit vector of the head's axis
  const float along = off.x * axis.x + off.y * axis.y;
  const float a = 1 - axis.z * axis.z, b = -along * axis.z, c = glm::dot(off, off) - along * along - far * far;
  if (a < 1e-3f) return true;
  const float root2 = b * b - a * c;
  if (root2 < 0) return false;
  const float root = std::sqrt(root2);
  const int from = static_cast<int>(std::floor(height + (-b - root) / a)) - 1,
            to = static_cast<int>(std::ceil(height + (-b + root) / a)) + 1;
  lowest = std::max(lowest, from - kDeep);
  highest = std::min(highest, to);
  return lowest <= highest;
}

/// Eight points in the head's frame.
struct Points {
  F8 x, y, z;
};

TYPODONT_INLINE Points in_head(const HeadPose& pose, const F8& x, const F8& y, const F8& z) {
  const float* const R = pose.R;
  const F8 vx = x - pose.p[0], vy = y - pose.p[1], vz = z - pose.p[2];
  return {(R[0] * vx + R[3] * vy) + R[6] * vz, (R[1] * vx + R[4] * vy) + R[7] * vz,
          (R[2] * vx + R[5] * vy) + R[8] * vz};
}

/// Returns for eight samples at the positions `from` the vectors from the start to the end of their paths.
TYPODONT_INLINE Points paths_from(const Straight& way, const Points& from) {
  const float* const T = way.turn;
  return {(T[0] * from.x + T[3] * from.y) + (T[6] * from.z + way.shift[0]),
          (T[1] * from.x + T[4] * from.y) + (T[7] * from.z + way.shift[1]),
          (T[2] * from.x + T[5] * from.y) + (T[8] * from.z + way.shift[2])};
}

/// Returns for eight samples at the positions `from` the second-order terms of their paths (Straight::bend_turn).
TYPODONT_INLINE Points bends_from(const Straight& way, const Points& from) {
  const float* const T = way.bend_turn;
  return {(T[0] * from.x + T[3] * from.y) + (T[6] * from.z + way.bend_shift[0]),
          (T[1] * from.x + T[4] * from.y) + (T[7] * from.z + way.bend_shift[1]),
          (T[2] * from.x + T[5] * from.y) + (T[8] * from.z + way.bend_shift[2])};
}

/// Depths in the head of eight samples at one point of their paths, and the derivatives of the depths along the paths.
struct Depth {
  F8 depth, slope;
};

/// Searches the largest depths of eight samples on their paths, with the tolerance kTop. The search for a sample ends
/// early if its largest depth is certainly at most `needed`, or certainly above `most`. The depth along the path is a
/// concave curve, so it lies below its tangents, and the intersection of the tangents on both sides of the maximum is
/// an upper bound. The search evaluates two kinds of points alternately: this intersection, which is exact if the curve
/// has a corner there, and the maximum of a parabola.
struct Search {
  unsigned set;  // one bit for each piece of the meridian that can be nearest to one of the samples on this path
  // in the head's frame: start positions of the samples, vectors of their paths, second-order terms of their paths
  Points from, way, bend;
  // fractions of the path, 0..1: the largest depth of the sample lies between a and b, and is now searched at s
  F8 a, b, s;
  Depth at_a, at_b;
  F8 best, top, needed;
  I8 open;

  TYPODONT_INLINE Points place(const Straight& head, const F8& fraction) const {
    Points p{from.x + fraction * way.x, from.y + fraction * way.y, from.z + fraction * way.z};
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
    Points along = way;
    if (head.bent > 0) {
      const F8 off = 2.0f * fraction - 1.0f;
      along = {way.x + off * bend.x, way.y + off * bend.y, way.z + off * bend.z};
    }
    return {found.nearest.depth(), found.slope(p.x, p.y, rho, along.x, along.y, along.z)};
  }
  /// Returns the outward normal at the fraction `fraction` of the path, in the head's frame.
  TYPODONT_INLINE Points normal(const Straight& head, const F8& fraction) const {
    const Points p = place(head, fraction);
    const F8 rho = eight::root(p.x * p.x + p.y * p.y), inverse = 1.0f / (rho + 1e-6f);
    F8 n_rho, n_z;
    nearest(head, rho, p.z).normal(n_rho, n_z);
    return {n_rho * p.x * inverse, n_rho * p.y * inverse, n_z};
  }
  /// Begins the search at the fraction `fraction` of the path. x, y, z: positions of the samples, in voxels relative to
  /// HeadPose::base of the path's first pose.
  TYPODONT_INLINE void begin(const Straight& head, unsigned pieces, const F8& x, const F8& y, const F8& z,
                             const F8& least, float fraction, float most) {
    set = pieces;
    from = in_head(head.from, x, y, z);
    way = paths_from(head, from);
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
    // Each lane is decided separately. `before`: the point s lies in front of the maximum, so it becomes the new limit
    // a. `after`: it lies behind the maximum, so it becomes b. If the depth still increases towards an end of the path
    // (s is 0 or 1), the maximum is at that end.
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

/// The point of its path at which each of eight samples is deepest: the fraction 0..1 of the path, and the samples'
/// positions and depths there.
struct Deepest {
  F8 fraction;
  Points at;
  F8 rho, below, depth;  // voxels; below: z relative to the flank's lower end for a sample below this end, otherwise 0
};

/// Returns where eight samples are deepest below one line of the meridian. If the line is the flank of a cylinder with
/// a round end, the round end is included: the depth is then the radius minus the distance from a half-line on the
/// axis. The squared distance from the axis, and that from the centre of the round end, are quadratic along the path,
/// so their minima have a closed form.
TYPODONT_INLINE Deepest deepest_below(const Straight& head, int line_index, const Points& from) {
  const MeridianPiece& line = head.pieces[line_index];
  const Points way = paths_from(head, from);
  const F8 none = {}, one = none + 1.0f, least = none + 1e-12f;
  const F8 across2 = way.x * way.x + way.y * way.y, A = eight::greater(across2, least),
           B = from.x * way.x + from.y * way.y;
  F8 s = -B / A;
  if (line.naz != 0.0f) {
    // The depth is -nax rho - naz z plus a constant, where (nax, naz) is the line's normal. rho² = A t² + C, where t is
    // the fraction of the path measured from the smallest rho.
    const F8 rises = -line.naz * way.z, steepest = line.nax * line.nax * A - rises * rises;
    const F8 C = eight::greater(from.x * from.x + from.y * from.y - B * B / A, none);
    const F8 t = rises * eight::root(C / eight::greater(A * steepest, least));
    s = steepest > least ? s + t : rises > 0.0f ? one : none;
  }
  s = eight::greater(eight::lesser(s, one), none);
  const bool round = has_round_end(head.pieces, line_index);
  if (round) {
    // The distance from a half-line is convex along the path. So if the path comes closest to the centre of the round
    // end at a point of the path that lies below this centre, this point is the result. Otherwise it is the point at
    // which the path comes closest to the axis.
    const F8 above = from.z - line.az;
    F8 at_end = -(B + above * way.z) / eight::greater(across2 + way.z * way.z, least);
    at_end = eight::greater(eight::lesser(at_end, one), none);
    s = above + at_end * way.z <= 0.0f ? at_end : s;
  }
  Deepest found{s, {from.x + s * way.x, from.y + s * way.y, from.z + s * way.z}, none, none, none};
  // The maximum was located on the straight line instead of the curved path, so its location has a small error. Near a
  // maximum the depth hardly changes, so this error has no first-order effect on the depth.
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

/// The centres of eight blocks, and the largest depth of each centre in the head during the motion. The depth is a
/// concave function of the position. So a linear function of the position (see n_x, n_y, n_z) is an upper bound of the
/// depths of all samples of a block.
struct Centres {
  unsigned set;  // input: pieces of the head's meridian that can be nearest to any of the centres on the path
  // Input: two limits of the depth. The samples of a block need not be computed one by one if none of them is deeper
  // than `outside`, or if all of them are deeper than `emptied`.
  float outside, emptied;
  F8 x, y, z;    // voxels, positions of the centres, relative to HeadPose::base of the path's first pose
  F8 best, top;  // lower and upper bound of the largest depth of each centre
  // Vector n out of the head. A sample at the offset d (voxels) from a block's centre is, up to rounding and the
  // head's rotation, at most `top` − n · d deep in the head.
  F8 n_x, n_y, n_z;
  F8 fraction;  // fraction of the path at which the centres are deepest
};

TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
void look_at(const Straight* way_at, Centres* centres) {
  const Straight& way = *way_at;
  Search search;
  search.begin(way, centres->set, centres->x, centres->y, centres->z, eight::all(centres->outside), 0.5f,
               centres->emptied);
  for (int step = 0; step < kSteps && any_of(search.open); ++step) search.step(way, step, centres->emptied);
  // The depth lies below both tangents, at a and at b, and therefore also below each weighted mean of the two. The
  // weights are chosen so that the mean is constant along the path.
  const F8 up = search.at_a.slope, down = search.at_b.slope;
  const I8 at_a = up <= 0.0f, at_b = ~at_a & (down >= 0.0f);
  const F8 part = at_a ? eight::all(1) : at_b ? F8{} : down / (down - up);
  const Points a = search.normal(way, search.a), b = search.normal(way, search.b);
  const F8 nx = b.x + part * (a.x - b.x), ny = b.y + part * (a.y - b.y), nz = b.z + part * (a.z - b.z);
  const float* const R = way.from.R;
  centres->n_x = R[0] * nx + R[1] * ny + R[2] * nz;
  centres->n_y = R[3] * nx + R[4] * ny + R[5] * nz;
  centres->n_z = R[6] * nx + R[7] * ny + R[8] * nz;
  centres->best = search.best, centres->top = search.top;
  centres->fraction = at_a ? search.a : at_b ? search.b : search.s;
}

/// Computes the same bounds of the depth as look_at(), but in closed form. Only for blocks in which a single segment of
/// the head's meridian, the one with the index `line`, determines the depth.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
void look_at_line(const Straight* way_at, Centres* centres, int line) {
  const Straight& way = *way_at;
  const Deepest found = deepest_below(way, line, in_head(way.from, centres->x, centres->y, centres->z));
  const MeridianPiece& piece = way.pieces[line];
  const F8 least = F8{} + 1e-6f;
  F8 nx, ny, nz;
  if (has_round_end(way.pieces, line)) {
    const F8 inverse = 1.0f / eight::greater(piece.ax - found.depth, least);
    nx = found.at.x * inverse, ny = found.at.y * inverse, nz = found.below * inverse;
  } else {
    const F8 inverse = piece.nax / eight::greater(found.rho, least);
    nx = found.at.x * inverse, ny = found.at.y * inverse, nz = F8{} + piece.naz;
  }
  const float* const R = way.from.R;
  centres->n_x = R[0] * nx + R[1] * ny + R[2] * nz;
  centres->n_y = R[3] * nx + R[4] * ny + R[5] * nz;
  centres->n_z = R[6] * nx + R[7] * ny + R[8] * nz;
  centres->best = centres->top = found.depth;
  centres->fraction = found.fraction;
}

/// Data of the centres at the beginning of the path: their depths in the head, and their distances from each piece of
/// the head's meridian.
struct AtStart {
  F8 depth, to_piece[HeadField::kMaxPieces];
  Points at;  // positions of the centres in the head's frame
  // Index of a line of the meridian; -1: no such line. On the whole path, this line alone determines the depths of all
  // samples of the block, if depths above Sweep::kInner count as Sweep::kInner.
  int line[8];
  F8 rho;  // voxels, distances of the centres from the head's axis
  // Mask of the blocks for which the head moves away from every sample. The depth is concave along the path, so each
  // sample of such a block is deepest at the start of the path.
  I8 recedes;

  /// Returns the pieces of the head's meridian (one bit each) that can be nearest to a sample within `reach` of the
  /// centre's initial position.
  unsigned nearest_within(float reach, int lane, int count) const {
    unsigned set = 0;
    for (int i = 0; i < count; ++i) {
      set |= static_cast<unsigned>(to_piece[i][lane] <= std::abs(depth[lane]) + 2 * reach) << i;
    }
    return set;
  }
};

TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
void look_at_start(const Straight* way_at, const Centres* centres, AtStart* found) {
  const Straight& way = *way_at;
  const Points p = in_head(way.from, centres->x, centres->y, centres->z);
  const F8 rho = eight::root(p.x * p.x + p.y * p.y);
  found->depth = eight::depth_below_pieces(way.pieces, (1u << way.count) - 1, rho, p.z);
  found->at = p, found->rho = rho;
}

/// Computes AtStart::recedes for eight centres at once. For this, the function computes a lower bound of n·w, where n
/// is the head's normal and w the motion. `rounding`: voxels, rounding error of a path's component along a normal.
TYPODONT_INLINE I8 receding(const Straight& way, const AtStart& at, float rounding) {
  const F8 x = at.at.x, y = at.at.y, none = {};
  const auto [wx, wy, wz] = paths_from(way, at.at);
  // Finds the first and the last of the neighbouring meridian pieces that can be nearest to a sample of the block, and
  // the normals of these two pieces.
  const F8 within = (at.depth > 0.0f ? at.depth : -at.depth) + 2 * kHalf;
  F8 first_x = none, first_z = none, last_x = none, last_z = none;
  I8 from_axis = {};
  for (int i = 0; i < way.count; ++i) {
    const MeridianPiece& piece = way.pieces[i];
    const I8 near = at.to_piece[i] <= within;
    last_x = near ? eight::all(piece.nbx) : last_x, last_z = near ? eight::all(piece.nbz) : last_z;
  }
  for (int i = way.count - 1; i >= 0; --i) {
    const MeridianPiece& piece = way.pieces[i];
    const I8 near = at.to_piece[i] <= within;
    first_x = near ? eight::all(piece.nax) : first_x, first_z = near ? eight::all(piece.naz) : first_z;
    from_axis = near ? I8{} - (piece.ax == 0.0f) : from_axis;
  }
  const I8 tip = from_axis & (at.rho < kHalf + Sweep::kMargin);
  first_x = tip ? none : first_x, first_z = tip ? eight::all(-1) : first_z;
  // Computes the smallest component of the motion w away from the head's axis, over all points within kHalf (half a
  // block's diagonal) of the centre.
  const F8 across = eight::root(wx * wx + wy * wy), inverse = 1.0f / eight::greater(at.rho, eight::all(kHalf));
  const F8 ux = x * inverse, uy = y * inverse, sine = kHalf * inverse, radial = wx * ux + wy * uy;
  const F8 cosine = eight::root(eight::greater(1.0f - sine * sine, none)), around = wx * uy - wy * ux;
  const F8 round = around < 0.0f ? -around : around;
  const I8 beside = (at.rho > kHalf) & (round * cosine > -radial * sine);
  const F8 away = beside ? round * sine - radial * cosine : across, along = -wz;
  const I8 between = (first_x * along >= first_z * away) & (away * last_z >= along * last_x);
  const F8 ends = eight::greater(first_x * away + first_z * along, last_x * away + last_z * along);
  // Largest n·(-w), where n is a normal of the head and w the motion. Its negative is the smallest n·w.
  const F8 approach = between ? eight::root(away * away + along * along) : ends;
  return -approach >= way.turned * kHalf + rounding;
}

/// Computes AtStart::line for eight centres: the line that alone determines the depths of a block, if there is one.
/// Within a block, a depth differs from the depth at the centre by at most kHalf. A depth below a line is concave along
/// the path, so it is smallest at an end of the path.
TYPODONT_INLINE void find_lines(const Straight& way, AtStart& at) {
  const F8 z = at.at.z;
  const auto [wx, wy, wz] = paths_from(way, at.at);
  const F8 end_x = at.at.x + wx, end_y = at.at.y + wy, end_rho = eight::root(end_x * end_x + end_y * end_y);
  const F8 across = eight::root(wx * wx + wy * wy), up = wz < 0.0f ? -wz : wz;
  const float beside = (1 + way.turned) * kHalf + kTop;
  I8 found = I8{} - 1;
  for (int i = 0; i < way.count; ++i) {
    const MeridianPiece& line = way.pieces[i];
    const bool round = has_round_end(way.pieces, i);
    if (line.radius != 0.0f || (!round && line.corner_a > kRightAngle) || line.corner_b > kRightAngle) continue;
    // positions along the line, measured from its two ends
    const F8 from_a = (z - line.az) * line.nax - (at.rho - line.ax) * line.naz, from_b = line.length - from_a;
    const F8 room = beside + std::abs(line.nax) * up + std::abs(line.naz) * across;
    I8 alone = from_b > room + Sweep::kInner * line.corner_b;
    if (!round) alone &= from_a > room + Sweep::kInner * line.corner_a;
    for (int k = 0; k < way.count; ++k) {
      const MeridianPiece& other = way.pieces[k];
      if (std::abs(k - i) < 2) continue;
      const F8 least =
          eight::lesser(eight::depth_below_line(other, at.rho, z), eight::depth_below_line(other, end_rho, z + wz));
      alone = other.radius == 0.0f ? alone & (least > Sweep::kInner + beside) : I8{};
    }
    found = alone ? I8{} + i : found;
  }
  for (int lane = 0; lane < 8; ++lane) at.line[lane] = found[lane];
}

/// Computes the distance of each centre from each piece of the meridian. The function is called only if at least one of
/// the eight centres is inside the head, because for most blocks none is inside.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
void look_at_pieces(const Straight* way_at, AtStart* found, float rounding) {
  const Straight& way = *way_at;
  for (int i = 0; i < way.count; ++i) {
    // For the kernel, an arc's second end belongs to the next piece of the head's meridian. Therefore the kernel does
    // not compute the distance from the second end of this piece, and it is computed here.
    const F8 depth = eight::depth_below_pieces(way.pieces, 1u << i, found->rho, found->at.z),
             off_rho = found->rho - way.pieces[i].bx, off_z = found->at.z - way.pieces[i].bz;
    found->to_piece[i] = eight::lesser(depth > 0.0f ? depth : -depth, eight::root(off_rho * off_rho + off_z * off_z));
  }
  found->recedes = receding(way, *found, rounding);
  find_lines(way, *found);
}

/// Returns the smallest depth in the head that a sample of the block has at the beginning of the path. `first`: first
/// sample of the block, relative to HeadPose::base of the path's first pose. Depth is concave, so it is smallest at a
/// corner of the block.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
float least_depth_at_start(const Straight* way_at, const glm::ivec3* first) {
  const Straight& way = *way_at;
  constexpr float kX = kRows - 1, kZ = kDeep - 1;
  const F8 x = static_cast<float>(first->x) + F8{0, 0, 0, 0, kX, kX, kX, kX},
           y = static_cast<float>(first->y) + F8{0, 0, kX, kX, 0, 0, kX, kX},
           z = static_cast<float>(first->z) + F8{0, kZ, 0, kZ, 0, kZ, 0, kZ};
  const Points p = in_head(way.from, x, y, z);
  const F8 depth =
      eight::depth_below_pieces(way.pieces, (1u << way.count) - 1, eight::root(p.x * p.x + p.y * p.y), p.z);
  float least = depth[0];
  for (int i = 1; i < 8; ++i) least = depth[i] < least ? depth[i] : least;
  return least;
}

/// A block, the part of it that is processed, and bounds of the depth, computed at the block's centre.
struct WayBlock {
  float* distance;
  const Tissue* tissue;
  std::ptrdiff_t stride_x, stride_y;
  int from[3], to[3];
  glm::ivec3 first;  // first sample of the block, relative to HeadPose::base of the path's first pose
  float top, n[3], fraction;
  // voxels, upper bound of the error that results if the path of the block's centre is used for all samples of the
  // block
  float bent;
  float* due;    // receives the path length at which the block is due again; null: the value is not stored
  unsigned set;  // the pieces of the meridian that can be nearest to any sample on the path, one bit for each piece
  // index of the line that alone determines the depth of the block's samples (AtStart::line); -1: no such line
  int line;
  bool emptied;

  /// A linear function (a plane) bounds the depths in each row of the block. Returns the bound of the row through the
  /// centre minus the bound of row (ix, iy).
  float off(int ix, int iy) const {
    return n[0] * (static_cast<float>(ix) - kMiddle.x) + n[1] * (static_cast<float>(iy) - kMiddle.y);
  }
  /// Returns the upper bound that the linear function (plane) gives for all depths in the row through the block's
  /// centre.
  float most() const { return top + bent + std::abs(n[2]) * kMiddle.z; }
  /// Returns, in voxels, -kMargin minus the upper bound of the depths in row (ix, iy). A cut ignores depths below
  /// -kMargin, so the row cannot change if the result is not negative. If `emptied` is set, the result is negative.
  float unread(int ix, int iy) const { return emptied ? -1.0f : -Sweep::kMargin - (most() - off(ix, iy)); }
  /// Returns the upper bound that the linear function (plane) gives for all depths in the block.
  float most_of_all() const { return most() + std::abs(n[0]) * kMiddle.x + std::abs(n[1]) * kMiddle.y; }
  bool may_change() const { return emptied || most_of_all() > -Sweep::kMargin; }
};

/// Prefetches the rows of a block that carve_way_block() will read.
void fetch(const WayBlock& block) {
  for (int ix = block.from[0]; ix < block.to[0]; ++ix) {
    for (int iy = block.from[1]; iy < block.to[1]; ++iy) {
      if (block.unread(ix, iy) < 0) {
        __builtin_prefetch(block.distance + ix * block.stride_x + iy * block.stride_y, 1);
      }
    }
  }
}

/// Sets each sample to max(sample, min(depth, kInner)); depths below -kMargin are ignored. kInner is 3 voxels, kMargin
/// 3.5 voxels. Returns true if any sample changed. `slack`: distance in voxels that the head may still move before any
/// sample of these rows can change.
TYPODONT_DISPATCH("arch=x86-64-v4", "avx2", "default")
bool carve_way_block(const Straight* way_at, const WayBlock* block_at, RemovedVolume* removed, float* slack) {
  const Straight& way = *way_at;
  const WayBlock& block = *block_at;
  const F8 steps = {0, 1, 2, 3, 4, 5, 6, 7}, bound = block.top + block.bent - block.n[2] * (steps - kMiddle.z);
  const F8 z = static_cast<float>(block.first.z) + steps;
  // All rows are processed step by step together, so that the processor need not wait for the result of each step.
  constexpr int kAll = kRows * kRows;
  const bool whole = block.from[2] == 0 && block.to[2] == kDeep;
  Search searches[kAll];
  std::ptrdiff_t at[kAll];
  int rows = 0, open = 0, still_open[kAll];
  // voxels, smallest slack (motion until a sample can change) of the rows that need not be read
  float unread = kNoEnd;
  F8 read = F8{} + kNoEnd;  // voxels, smallest slack of the rows that are read but cannot change in this motion
  for (int ix = block.from[0]; ix < block.to[0]; ++ix) {
    for (int iy = block.from[1]; iy < block.to[1]; ++iy) {
      if (const float room = block.unread(ix, iy); room >= 0) {
        unread = std::min(unread, room);
        continue;
      }
      at[rows] = ix * block.stride_x + iy * block.stride_y;
      const F8 old = eight::Row{block.distance + at[rows], block.from[2], block.to[2], whole}.read();
      const I8 full = old >= Sweep::kInner;  // samples that already have the largest value that a cut can write
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
        const Points from = in_head(way.from, eight::all(static_cast<float>(block.first.x + ix)),
                                    eight::all(static_cast<float>(block.first.y + iy)), z);
        search.best = deepest_below(way, block.line, from).depth;
      } else {
        search.begin(way, block.set, eight::all(static_cast<float>(block.first.x + ix)),
                     eight::all(static_cast<float>(block.first.y + iy)), z, least, block.fraction, Sweep::kInner);
        still_open[open] = rows;
        open += any_of(search.open);
      }
      ++rows;
    }
  }
  *slack = unread;
  for (int i = 0; i < 8; ++i) *slack = std::min(*slack, read[i]);
  if (rows > 0) *slack = block.emptied ? kNoEnd : 0;
  for (int step = 0; step < kSteps && open > 0; ++step) {
    int left = 0;
    for (int i = 0; i < open; ++i) {
      Search& search = searches[still_open[i]];
      search.step(way, step, Sweep::kInner);
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

/// Searches the largest depths of eight listed samples on their paths, and raises the samples to these depths.
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
  // The first step of the search evaluates the other end of the path. If the depth is largest there, the search
  // raises no sample, because the cut at that pose has already written this depth.
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

Straight straight_way(const Pose& X_VA, const Pose& X_VB, const MeridianPiece* pieces, int count, double reach) {
  const glm::dmat3 R_AV = glm::transpose(glm::dmat3(X_VA.R)), R_BV = glm::transpose(glm::dmat3(X_VB.R));
  const dvec3 moved = R_BV * (X_VA.p - X_VB.p);
  // Computes the rotation matrix minus the identity matrix, without loss of digits by cancellation.
  const glm::dmat3 turn = (R_BV - R_AV) * glm::transpose(R_AV);
  Straight way{.from = head_pose(X_VA),
               .shift = {},
               .turn = {},
               .pieces = pieces,
               .count = count,
               .turned = 0,
               .longest = 0,
               .slip = 0};
  double turned = 0;
  for (int i = 0; i < 3; ++i) {
    way.shift[i] = static_cast<float>(moved[i]);
    for (int j = 0; j < 3; ++j) way.turn[3 * i + j] = static_cast<float>(turn[i][j]), turned += turn[i][j] * turn[i][j];
  }
  // `turn` is a rotation matrix minus the identity matrix. Half of the sum of its squared elements is the squared chord
  // of the rotation angle. A sample that the cut may change is up to `beyond` (voxels) outside the head.
  const double beyond = static_cast<double>(Sweep::kMargin) + 1;
  way.turned = static_cast<float>(std::sqrt(turned / 2));
  way.longest = static_cast<float>(glm::length(moved) + std::sqrt(turned / 2) * (reach + beyond)) + 1e-5f;
  // Upper bound of the error of a tangent. Its parts are the rounding error of the depth, an error near corners of the
  // head's outline (2 kNear), and the rounding error of the path's direction.
  way.slip = 1e-3f + 4e-6f * static_cast<float>(reach) + 2 * kNear + 1e-3f * way.longest;
  return way;
}

void bend(Straight& way, const Pose& X_VA, const Pose& X_VM, double reach) {
  const Straight half = straight_way(X_VA, X_VM, way.pieces, way.count, reach);
  double turned = 0, shifted = 0;
  for (int i = 0; i < 3; ++i) {
    way.bend_shift[i] = 4 * (way.shift[i] / 2 - half.shift[i]);
    shifted += static_cast<double>(way.bend_shift[i]) * static_cast<double>(way.bend_shift[i]);
  }
  for (int i = 0; i < 9; ++i) {
    way.bend_turn[i] = 4 * (way.turn[i] / 2 - half.turn[i]);
    turned += static_cast<double>(way.bend_turn[i]) * static_cast<double>(way.bend_turn[i]);
  }
  const double beyond = reach + static_cast<double>(Sweep::kMargin) + 1;
  way.bent = static_cast<float>((std::sqrt(shifted) + std::sqrt(turned) * beyond) / 4) + 1e-6f;
}

bool has_round_end(const MeridianPiece* pieces, int i) {
  const MeridianPiece& flank = pieces[i];
  return i > 0 && flank.radius == 0.0f && flank.naz == 0.0f && pieces[i - 1].radius == flank.ax &&
         pieces[i - 1].cx == 0.0f && pieces[i - 1].cz == flank.az;
}

float* DueBlocks::row(const glm::ivec3& voxel, int last_z) const noexcept {
  const glm::ivec3 step(kRows, kRows, kDeep), i = voxel / step - first;
  if (i.x < 0 || i.y < 0 || i.z < 0 || i.x >= size.x || i.y >= size.y) return nullptr;
  if (i.z + (last_z - voxel.z) / kDeep >= size.z) return nullptr;
  return due + (i.x * size.y + i.y) * size.z + i.z;
}

namespace {

/// The blocks around a head that moves on one straight part of its path. They pass through three stages, eight at a
/// time: choose() omits blocks that cannot change, look() computes bounds of the depths in the other blocks, and cut()
/// raises the samples. While the samples of eight blocks are raised, the samples of the next eight are requested from
/// memory.
class PathPass {
 public:
  /// `part`: the straight part of the path. `cut_before`: true if the tissue inside the head was removed at the
  /// beginning of this part. `turned`: voxels, bound of the difference between the paths of a sample and of its block's
  /// centre. `rounding`: voxels, rounding error of the component of a path along a normal. `known` (may be null):
  /// receives the path length at which each block must be examined again; null if another part of the path follows.
  PathPass(const Straight& part, bool cut_before, float turned, float rounding, const HeadTarget& target,
           RemovedVolume* removed, const DueBlocks* known)
      : way_(part),
        cut_before_(cut_before),
        turned_(turned),
        rounding_(rounding),
        target_(target),
        removed_(removed),
        known_(known),
        outside_(-(Sweep::kMargin + kHalf + kTop + part.slip + part.bent)),
        emptied_(Sweep::kInner + kHalf + part.slip + part.bent) {}

  /// Adds the block that begins at the voxel `first`. `due` (may be null) receives the path length at which the block
  /// must be examined again.
  void add(const glm::ivec3& first, float* due) {
    begun_[started_] = first;
    due_[started_] = due;
    put(starts_, started_, glm::vec3(first - way_.from.base) + kMiddle);
    if (++started_ == 8) choose();
  }
  /// Processes the remaining blocks. Returns true if any sample changed.
  bool finish() {
    if (started_ > 0) choose();
    for (int group = 0; group <= HeadField::kMaxPieces; ++group) {
      if (groups_[group].count > 0) look(group);
    }
    for (int i = 0; i < waiting_; ++i) cut(fetched_[i]);
    return changed_;
  }

 private:
  /// Up to eight blocks whose depths are computed in the same way. There is one group for each line of the meridian
  /// (closed form), and a last group for the blocks that need a search along the path.
  struct Group {
    int count = 0;
    Centres centres;
    WayBlock blocks[8];
  };

  static void put(Centres& to, int lane, const glm::vec3& c) { to.x[lane] = c.x, to.y[lane] = c.y, to.z[lane] = c.z; }
  static void fill_up(Centres& to, int from) {
    for (int lane = from; lane < 8; ++lane) to.x[lane] = to.x[0], to.y[lane] = to.y[0], to.z[lane] = to.z[0];
  }
  void note(float* at, float slack) const {
    if (at && known_) *at = known_->way + (slack - known_->slip);
  }

  /// Omits blocks that are too far from the head on the whole path. If the tissue inside the head was removed at the
  /// beginning of the path, also omits empty blocks and blocks from which the head moves away.
  void choose() {
    fill_up(starts_, started_);
    AtStart at;
    look_at_start(&way_, &starts_, &at);
    bool pieces_seen = false;
    for (int lane = 0; lane < started_; ++lane) {
      if (const float top = at.depth[lane] + way_.longest + kBesideSlip; top < outside_) {
        note(due_[lane], outside_ - top);
        continue;
      }
      const float empty = Sweep::kInner + way_.slip + way_.bent;
      if (cut_before_ && at.depth[lane] > empty) {
        const glm::ivec3 in_base = begun_[lane] - way_.from.base;
        if (at.depth[lane] > emptied_ || least_depth_at_start(&way_, &in_base) > empty) {
          note(due_[lane], kNoEnd);
          continue;
        }
      }
      if (!pieces_seen) look_at_pieces(&way_, &at, rounding_);
      pieces_seen = true;
      if (cut_before_ && at.recedes[lane]) continue;
      const int line = at.line[lane];
      Group& group = groups_[line >= 0 ? line : HeadField::kMaxPieces];
      WayBlock& block = group.blocks[group.count];
      place(block, begun_[lane]);
      block.due = due_[lane];
      block.line = line;
      block.set = at.nearest_within(kHalf + way_.longest + kBesideSlip, lane, way_.count);
      put(group.centres, group.count, {starts_.x[lane], starts_.y[lane], starts_.z[lane]});
      if (++group.count == 8) look(line >= 0 ? line : HeadField::kMaxPieces);
    }
    started_ = 0;
  }
  void place(WayBlock& block, const glm::ivec3& first) const {
    const glm::ivec3 inside = first - target_.lo;
    const std::ptrdiff_t at = inside.x * target_.stride_x + inside.y * target_.stride_y + inside.z;
    block.distance = target_.distance + at, block.tissue = target_.tissue ? target_.tissue + at : nullptr;
    block.stride_x = target_.stride_x, block.stride_y = target_.stride_y;
    const int size[3] = {kRows, kRows, kDeep};
    for (int i = 0; i < 3; ++i) {
      block.from[i] = std::max(-inside[i], 0);
      block.to[i] = std::min(target_.size[i] - inside[i], size[i]);
    }
    block.first = first - way_.from.base;
  }
  /// Computes bounds of the depths in the blocks of a group, and requests from memory the rows of the blocks that may
  /// change. Meanwhile cuts the blocks whose rows were requested before.
  void look(int which) {
    Group& group = groups_[which];
    Centres& centres = group.centres;
    fill_up(centres, group.count);
    centres.set = 0;
    for (int lane = 0; lane < group.count; ++lane) centres.set |= group.blocks[lane].set;
    centres.outside = outside_, centres.emptied = emptied_;
    if (which < HeadField::kMaxPieces) {
      look_at_line(&way_, &centres, which);
    } else {
      look_at(&way_, &centres);
    }
    int kept[8], keep = 0;
    for (int lane = 0; lane < group.count; ++lane) {
      WayBlock& block = group.blocks[lane];
      if (centres.top[lane] <= outside_) {
        note(block.due, outside_ - centres.top[lane]);
        continue;
      }
      block.top = centres.top[lane], block.fraction = centres.fraction[lane],
      block.emptied = centres.best[lane] >= emptied_;
      block.bent = way_.slip + kTop + turned_ + way_.bent;
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
  void cut(const WayBlock& block) {
    float slack;
    changed_ |= carve_way_block(&way_, &block, removed_, &slack);
    note(block.due, slack);
  }

  const Straight way_;
  const bool cut_before_;
  const float turned_, rounding_;
  const HeadTarget& target_;
  RemovedVolume* const removed_;
  const DueBlocks* const known_;
  // voxels, two limits of the depth at a block's centre: if it is less than `outside_`, the block does not change; if
  // it is more than `emptied_`, the whole block becomes empty
  const float outside_, emptied_;
  bool changed_ = false;
  int started_ = 0;
  Centres starts_;
  glm::ivec3 begun_[8];
  float* due_[8];
  Group groups_[HeadField::kMaxPieces + 1];
  int waiting_ = 0;
  WayBlock fetched_[8];  // blocks whose rows have been requested from memory
};

}  // namespace

bool Sweep::carve_way(const HeadTarget& target, RemovedVolume* removed, const DueBlocks* known) const noexcept {
  const auto down = [](int v, int step) { return v - (v % step + step) % step; };
  const float turned = static_cast<float>(turn_ / straights_) * kHalf;
  const double radius = static_cast<double>(radius_);
  const float rounding = 4e-6f * (static_cast<float>(reach_) + 8);
  const auto axis_of = [](const Pose& X) { return X.R * dvec3(0, 0, 1); };
  // voxels, distance from the head up to which a cut can change samples, plus one voxel for the error of a straight
  // path
  const double beside = static_cast<double>(kMargin) + 1;
  const auto extent = [&](const Pose& X) {
    const dvec3 axis = axis_of(X), across = glm::sqrt(glm::max(dvec3(1) - axis * axis, dvec3(0)));
    return half_length_ * glm::abs(axis) + radius * across + beside;
  };
  const auto is_whole = [&](const glm::ivec3& first) {
    return glm::all(glm::lessThanEqual(target.lo, first)) &&
           glm::all(glm::lessThanEqual(first + glm::ivec3(kRows, kRows, kDeep), target.lo + target.size));
  };
  bool changed = false;
  Pose X_VB = X_VA_;
  for (int k = 1; k <= straights_; ++k) {
    const Pose X_VA = X_VB;
    X_VB = k == straights_ ? X_VB_ : interpolate(X_VA_, X_VB_, static_cast<double>(k) / straights_);
    Straight way = straight_way(X_VA, X_VB, pieces_, back_.count, reach_);
    if (bends_) bend(way, X_VA, interpolate(X_VA, X_VB, 0.5), reach_);
    const dvec3 extent_a = extent(X_VA), extent_b = extent(X_VB);
    const glm::ivec3 lo = glm::max(target.lo, glm::ivec3(glm::ceil(glm::min(X_VA.p - extent_a, X_VB.p - extent_b))));
    const glm::ivec3 last =
        glm::min(target.lo + target.size - 1, glm::ivec3(glm::floor(glm::max(X_VA.p + extent_a, X_VB.p + extent_b))));
    // Blocks with a distance of more than `far` from the head's axis at A (the start of the sweep) stay outside the
    // head on the whole path.
    const glm::vec3 axis(axis_of(X_VA)), center(X_VA.p - dvec3(way.from.base));
    const float far = static_cast<float>(radius + beside) + kHalf + way.longest;
    const glm::ivec3 first(down(lo.x, kRows), down(lo.y, kRows), down(lo.z, kDeep));
    // Only the last part of the path determines the path length at which a block must be examined again.
    PathPass pass(way, continues_ || k > 1, turned, rounding, target, removed, k == straights_ ? known : nullptr);
    for (int x0 = first.x; x0 <= last.x; x0 += kRows) {
      for (int y0 = first.y; y0 <= last.y; y0 += kRows) {
        int lowest = first.z, highest = last.z;
        if (!column_beside_axis(
                glm::vec2(x0 - way.from.base.x, y0 - way.from.base.y) + glm::vec2(kMiddle) - glm::vec2(center), axis,
                far, static_cast<float>(way.from.base.z) + center.z - kMiddle.z, lowest, highest))
          continue;
        const int lowest_first = first.z + down(lowest - first.z, kDeep);
        float* const row = known ? known->row({x0, y0, lowest_first}, highest) : nullptr;
        for (int z0 = lowest_first; z0 <= highest; z0 += kDeep) {
          const glm::ivec3 from(x0, y0, z0);
          float* const noted = row ? row + (z0 - lowest_first) / kDeep : nullptr;
          if (noted && *noted > known->way) continue;
          pass.add(from, noted && is_whole(from) ? noted : nullptr);
        }
      }
    }
    changed |= pass.finish();
  }
  return changed;
}

}  // namespace typodont::haptics
