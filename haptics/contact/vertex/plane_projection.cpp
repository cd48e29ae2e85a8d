#include "haptics/contact/vertex/plane_projection.h"

#include <algorithm>

namespace typodont::haptics::vertex {

namespace {

class Projection {
 public:
  Projection(std::span<const StepBound> bounds, bool only_no_deeper) : bounds_(bounds), shallow_(only_no_deeper) {}

  bool solve(const dvec3& wanted, dvec3& step) noexcept {
    step = wanted;
    for (int round = 0; round < 64; ++round) {
      const std::size_t next = worst(step);
      if (next == bounds_.size()) return true;
      if (!add(next, step)) return false;
    }
    return false;
  }

 private:
  double excess(const StepBound& bound, const dvec3& step) const noexcept {
    return glm::dot(bound.n, step) + (shallow_ ? std::max(bound.gap, 0.0) : bound.gap);
  }

  std::size_t worst(const dvec3& step) const noexcept {
    double least = -1e-12;  // m
    std::size_t at = bounds_.size();
    for (std::size_t i = 0; i < bounds_.size(); ++i) {
      if (const double e = excess(bounds_[i], step); e < least) least = e, at = i;
    }
    for (int i = 0; i < count_; ++i) {
      if (index_[i] == at) return bounds_.size();  // holds already, but for rounding
    }
    return at;
  }

  /// r: coordinates of v in the normals of the active bounds, least squares. False where these depend on each other.
  bool coordinates(const dvec3& v, double (&r)[3]) const noexcept {
    double gram[3][4];
    for (int i = 0; i < count_; ++i) {
      for (int j = 0; j < count_; ++j) gram[i][j] = glm::dot(n_[i], n_[j]);
      gram[i][count_] = glm::dot(n_[i], v);
    }
    for (int i = 0; i < count_; ++i) {
      if (gram[i][i] < 1e-9) return false;
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

  bool add(std::size_t next, dvec3& step) noexcept {
    const StepBound& added = bounds_[next];
    double pushed = 0;
    for (int guard = 0; guard < 8; ++guard) {
      double r[3] = {};
      dvec3 rest = added.n;  // of the new normal, beside the active ones
      if (!coordinates(added.n, r)) return false;
      for (int i = 0; i < count_; ++i) rest -= r[i] * n_[i];
      const double rest2 = glm::dot(rest, rest);
      double partial = 1e300;
      int leaving = -1;
      for (int i = 0; i < count_; ++i) {
        if (r[i] > 1e-12 && push_[i] / r[i] < partial) partial = push_[i] / r[i], leaving = i;
      }
      const double full = count_ < 3 && rest2 > 1e-8 ? -excess(added, step) / rest2 : 1e300;
      const double t = std::min(partial, full);
      if (t >= 1e299) return false;
      if (full < 1e299) step += t * rest;
      for (int i = 0; i < count_; ++i) push_[i] -= t * r[i];
      pushed += t;
      if (full <= partial) {
        index_[count_] = next, n_[count_] = added.n, push_[count_] = pushed;
        ++count_;
        return true;
      }
      for (int i = leaving; i + 1 < count_; ++i) {
        index_[i] = index_[i + 1], n_[i] = n_[i + 1], push_[i] = push_[i + 1];
      }
      --count_;
    }
    return true;
  }

  std::span<const StepBound> bounds_;
  bool shallow_;
  int count_ = 0;  // active
  std::size_t index_[3];
  dvec3 n_[3];
  double push_[3];
};

}  // namespace

dvec3 nearest_step(std::span<const StepBound> bounds, const dvec3& wanted) noexcept {
  dvec3 step;
  if (Projection(bounds, false).solve(wanted, step)) return step;
  if (Projection(bounds, true).solve(wanted, step)) return step;
  return dvec3(0);
}

}  // namespace typodont::haptics::vertex
