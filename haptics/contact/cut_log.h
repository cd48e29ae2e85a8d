// The servo's last cuts, for snapshots that lack them.
#pragma once

#include <algorithm>
#include <climits>
#include <cstdint>
#include <utility>
#include <vector>

#include "engine/contract/contact.h"

namespace typodont::haptics {

/// A ring; cuts are 1, 2, 3 … Allocates at construction. Servo thread.
template <class Made>
class RecentCuts {
 public:
  // that a late snapshot may lack
  static constexpr std::uint64_t kLength = 8192;

  RecentCuts() : made_(kLength) {}

  /// `index`: last plus one.
  void add(std::uint64_t index, const Made& made) noexcept {
    made_[index % kLength] = made;
    last_ = index;
  }
  const Made& operator[](std::uint64_t index) const noexcept { return made_[index % kLength]; }
  Made& operator[](std::uint64_t index) noexcept { return made_[index % kLength]; }
  /// 0: none.
  std::uint64_t last() const noexcept { return last_; }
  /// Oldest after `index`; last() + 1: none.
  std::uint64_t first_after(std::uint64_t index) const noexcept {
    return std::max(index, last_ >= kLength ? last_ - kLength : 0) + 1;
  }

 private:
  std::vector<Made> made_;
  std::uint64_t last_ = 0;
};

/// Lacking in a snapshot.
struct MadeCut {
  Pose X_WA, X_WB;
  std::uint32_t tool = 0;
  PerTissue removed{};  // m³, removed volume of each tissue
};

/// Removed volume that never falls, although a cut of a mesh may add a little: later cuts make up for it.
class RisingCount {
 public:
  /// m³ to count now, of what a cut removed.
  PerTissue counted(const PerTissue& removed) noexcept {
    PerTissue now{};
    for (std::size_t t = 0; t < now.size(); ++t) {
      const double more = removed[t] - ahead_[t];
      now[t] = std::max(more, 0.0);
      ahead_[t] = std::max(-more, 0.0);
    }
    return now;
  }

 private:
  PerTissue ahead_{};  // m³ counted too much
};

/// For SurfacePatch models, with the box of each cut.
class CutLog {
 public:
  /// To repeat it in another patch.
  struct Made {
    Pose X_WA, X_WB;
    std::uint32_t tool = 0;
    bool continues = false;
    // Filling: ball's radius, m, at X_WA, without the head at X_WB; cut: 0.
    double fill_radius = 0;
    PerTissue removed{};  // voxels³ per tissue; negative: filling
  };

  /// Box `lo`, `hi` of possible changes.
  void add(std::uint64_t index, const glm::ivec3& lo, const glm::ivec3& hi, const Made& cut) noexcept {
    boxes_.add(index, {lo, hi, cut.fill_radius > 0});
    made_.add(index, cut);
  }
  const Made& made(std::uint64_t index) const noexcept { return made_[index]; }
  Made& made(std::uint64_t index) noexcept { return made_[index]; }
  std::uint64_t last() const noexcept { return made_.last(); }
  std::uint64_t first_after(std::uint64_t index) const noexcept { return made_.first_after(index); }
  /// Only within lo..hi (inclusive).
  bool is_inside(std::uint64_t index, const glm::ivec3& lo, const glm::ivec3& hi) const noexcept {
    const Box& box = boxes_[index];
    return glm::all(glm::greaterThanEqual(box.lo, lo)) && glm::all(glm::lessThanEqual(box.hi, hi));
  }
  /// Box of cuts after `index`, all of the patch if some are forgotten. False: none. `filled`: perhaps a filling.
  bool since(std::uint64_t index, glm::ivec3& lo, glm::ivec3& hi, bool& filled) const noexcept {
    if (index >= last()) return false;
    const bool all_known = last() - index < RecentCuts<Made>::kLength;
    filled = !all_known;
    lo = glm::ivec3(INT_MAX), hi = glm::ivec3(INT_MIN);
    if (!all_known) {
      std::swap(lo, hi);
      return true;
    }
    for (std::uint64_t i = index + 1; i <= last(); ++i) {
      const Box& box = boxes_[i];
      lo = glm::min(lo, box.lo);
      hi = glm::max(hi, box.hi);
      filled |= box.filled;
    }
    return true;
  }

 private:
  struct Box {
    glm::ivec3 lo{0}, hi{0};
    bool filled = false;
  };
  RecentCuts<Box> boxes_;
  RecentCuts<Made> made_;
};

}  // namespace typodont::haptics
