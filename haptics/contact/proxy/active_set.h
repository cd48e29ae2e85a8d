// Finds the point nearest to a goal on the allowed side of all planes of a set. Dual active-set method (Goldfarb &
// Idnani 1983): starts at the goal and adds the most violated plane until none is violated.
#pragma once

#include <algorithm>

#include "engine/base/pose.h"

namespace typodont::haptics {

/// The active planes, on which the point found lies: at most one per dimension. `push`: for each plane, its Lagrange
/// multiplier, which is the displacement that the plane causes, divided by its normal.
template <int kMost>
struct ActivePlanesOf {
  int count = 0;
  int index[kMost] = {};
  double push[kMost] = {};
};
using ActivePlanes = ActivePlanesOf<3>;

/// Limits that detect linearly dependent normals. Both have no unit: they are squared sines of the angle between
/// normals.
struct ActiveSetLimits {
  // Smallest pivot of the Gram matrix of the active normals. With a smaller pivot, the projection fails.
  double min_pivot = 0;
  // Smallest squared length of the component of a new normal perpendicular to the active normals. With a smaller
  // component, the plane cannot become active.
  double min_rest = 0;
};

/// Computes one projection, of a point in space, or of a `Vector` with `kMost` dimensions. The class `Planes` describes
/// the planes; a plane allows the points x with excess(plane, x) >= 0:
///
///   struct Planes {
///     using Plane = …;                                      // has the normal `n`: in space, a unit vector
///     static constexpr ActiveSetLimits kLimits = {…};
///     Plane plane(int i) const noexcept;                    // may also return a reference
///     double excess(const Plane& plane, const Vector& x) const noexcept;
///     // Returns the index of the most violated plane, or -1 if none is violated. Ignores the `count` planes in
///     // `active`, which are satisfied except for rounding errors.
///     int worst(const Vector& x, const int* active, int count) const noexcept;
///   };
///
/// Each file that uses this template gets its own instance, compiled with the floating-point options of that file.
/// Never allocates.
template <class Planes, class Vector = dvec3, int kMost = 3>
class ActiveSet {
 public:
  explicit ActiveSet(const Planes& planes) : planes_(planes) {}

  /// Computes the point nearest to `goal` that all planes allow. `active`: on entry, a guess of the active planes; on
  /// return, the active planes. Returns false if no point is allowed; `x` is then undefined.
  bool solve(const Vector& goal, Vector& x, ActivePlanesOf<kMost>& active) noexcept {
    count_ = 0;
    x = goal;
    if (active.count > 0) start_with(active, x);
    const bool solved = add_planes(x);
    active.count = count_;
    for (int i = 0; i < count_; ++i) active.index[i] = index_[i], active.push[i] = push_[i];
    return solved;
  }

 private:
  // largest number of rounds, each of which adds a plane; if more are needed, the projection fails
  static constexpr int kMaxRounds = 64;
  // largest number of active planes that may be removed when one plane is added
  static constexpr int kMaxLeaving = 8;
  static constexpr double kNever = 1e300;  // a number larger than any step length

  /// Solves gram · r = b, where the last column of `gram` contains b. Returns false if the active normals are linearly
  /// dependent.
  bool solve_gram(double (&gram)[kMost][kMost + 1], double (&r)[kMost]) const noexcept {
    for (int i = 0; i < count_; ++i) {  // Gaussian elimination without pivoting
      if (gram[i][i] < Planes::kLimits.min_pivot) return false;
      for (int row = i + 1; row < count_; ++row) {
        const double f = gram[row][i] / gram[i][i];
        for (int col = i; col <= count_; ++col) gram[row][col] -= f * gram[i][col];
      }
    }
    for (int i = count_ - 1; i >= 0; --i) {
      r[i] = gram[i][count_];
      for (int j = i + 1; j < count_; ++j) r[i] -= gram[i][j] * r[j];
      r[i] /= gram[i][i];
    }
    return true;
  }

  /// Computes the coordinates r of v with respect to the active normals (least squares). Returns false if the normals
  /// are linearly dependent.
  bool coordinates(const Vector& v, double (&r)[kMost]) const noexcept {
    double gram[kMost][kMost + 1];
    for (int i = 0; i < count_; ++i) {
      for (int j = 0; j < count_; ++j) gram[i][j] = dot(n_[i], n_[j]);
      gram[i][count_] = dot(n_[i], v);
    }
    return solve_gram(gram, r);
  }

  /// Starts the search with the guessed planes as active planes, if all their multipliers are then positive. Otherwise
  /// starts without active planes.
  void start_with(const ActivePlanesOf<kMost>& guess, Vector& x) noexcept {
    count_ = guess.count;
    double gram[kMost][kMost + 1], u[kMost] = {};
    for (int i = 0; i < count_; ++i) {
      const typename Planes::Plane& plane = planes_.plane(guess.index[i]);
      index_[i] = guess.index[i], n_[i] = plane.n;
      gram[i][count_] = -planes_.excess(plane, x);
    }
    for (int i = 0; i < count_; ++i) {
      for (int j = 0; j < count_; ++j) gram[i][j] = dot(n_[i], n_[j]);
    }
    bool pushes = solve_gram(gram, u);
    for (int i = 0; i < count_; ++i) pushes = pushes && u[i] > 0;
    if (!pushes) {
      count_ = 0;
      return;
    }
    for (int i = 0; i < count_; ++i) x += u[i] * n_[i], push_[i] = u[i];
  }

  bool add_planes(Vector& x) noexcept {
    for (int round = 0; round < kMaxRounds; ++round) {
      const int next = planes_.worst(x, index_, count_);
      if (next < 0) return true;
      if (!add(next, x)) return false;
    }
    return false;
  }

  /// Adds the plane `next` to the active planes and moves x onto it. Removes active planes whose push would be
  /// negative. Returns false if no point satisfies all planes.
  bool add(int next, Vector& x) noexcept {
    const typename Planes::Plane& added = planes_.plane(next);
    double pushed = 0;
    for (int turn = 0; turn < kMaxLeaving; ++turn) {
      // The normal of the plane `next` is split into two components. rest: component perpendicular to all active
      // normals. r: weights of the active normals whose weighted sum is the other component.
      double r[kMost] = {};
      Vector rest = added.n;
      if (count_ > 0) {
        if (!coordinates(rest, r)) return false;
        for (int i = 0; i < count_; ++i) rest -= r[i] * n_[i];
      }
      const double rest2 = dot(rest, rest);
      double partial = kNever;
      int leaving = -1;
      for (int i = 0; i < count_; ++i) {
        if (r[i] > 1e-12 && push_[i] / r[i] < partial) partial = push_[i] / r[i], leaving = i;
      }
      const bool may_join = count_ < kMost && rest2 > Planes::kLimits.min_rest;
      const double full = may_join ? -planes_.excess(added, x) / rest2 : kNever;
      if (!may_join && leaving < 0) return false;
      const double step = std::min(partial, full);
      if (may_join) x += step * rest;
      for (int i = 0; i < count_; ++i) push_[i] -= step * r[i];
      pushed += step;
      if (full <= partial) {
        index_[count_] = next, n_[count_] = added.n, push_[count_] = pushed;
        ++count_;
        return true;
      }
      for (int i = leaving; i + 1 < count_; ++i) index_[i] = index_[i + 1], n_[i] = n_[i + 1], push_[i] = push_[i + 1];
      --count_;
    }
    return true;
  }

  const Planes& planes_;
  int count_ = 0;  // number of active planes
  int index_[kMost];
  Vector n_[kMost];
  double push_[kMost];  // push of each active plane: the displacement that it causes, in the unit of x
};

}  // namespace typodont::haptics
