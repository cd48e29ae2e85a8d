// The servo's latest cuts, which it repeats in snapshots that were taken before them.
#pragma once

#include <algorithm>
#include <climits>
#include <cstdint>
#include <utility>
#include <vector>

#include "engine/contract/contact.h"

namespace typodont::haptics {

/// The newest kLength cuts of the servo in a ring buffer. Cuts are numbered 1, 2, 3 … Allocates only at construction.
/// Servo thread only.
template <class Made>
class RecentCuts {
 public:
  // Largest number of cuts that a newly arrived snapshot may lack.
  static constexpr std::uint64_t kLength = 8192;

  RecentCuts() : made_(kLength) {}

  /// Adds the cut `index`, which must be last() + 1.
  void add(std::uint64_t index, const Made& made) noexcept {
    made_[index % kLength] = made;
    last_ = index;
  }
  const Made& operator[](std::uint64_t index) const noexcept { return made_[index % kLength]; }
  Made& operator[](std::uint64_t index) noexcept { return made_[index % kLength]; }
  /// Number of the newest cut; 0: there is none.
  std::uint64_t last() const noexcept { return last_; }
  /// Oldest stored cut after cut `index`; last() + 1: none.
  std::uint64_t first_after(std::uint64_t index) const noexcept {
    return std::max(index, last_ >= kLength ? last_ - kLength : 0) + 1;
  }

 private:
  std::vector<Made> made_;
  std::uint64_t last_ = 0;
};

/// A cut by the servo, with the data to repeat it in snapshots that lack it.
struct MadeCut {
  Pose X_WA, X_WB;
  std::uint32_t tool = 0;
  PerTissue removed{};  // m³, removed volume of each tissue
};

/// Counts removed volume so that the count never decreases: if a cut of a mesh adds a little volume, the next cuts
/// count less by this volume.
class RisingCount {
 public:
  /// Returns the volume (m³) by which the count increases after a cut that removed the volume `removed`.
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
  PerTissue ahead_{};  // m³, volume that was counted so far but not removed
};

/// The cuts of a model that uses a TissuePatch, with the box of samples that each cut may have changed.
class CutLog {
 public:
  /// Data to repeat a cut or filling in another tissue patch.
  struct Made {
    Pose X_WA, X_WB;
    std::uint32_t tool = 0;
    bool continues = false;
    // m; above 0: filling was added in a ball of this radius around X_WA, except inside the head at X_WB; 0: a cut
    double fill_radius = 0;
    PerTissue removed{};  // voxels³, removed volume of each tissue; negative: filling
  };

  /// Adds a cut that may have changed samples in the box from `lo` to `hi` (voxels, inclusive).
  void add(std::uint64_t index, const glm::ivec3& lo, const glm::ivec3& hi, const Made& cut) noexcept {
    boxes_.add(index, {lo, hi, cut.fill_radius > 0});
    made_.add(index, cut);
  }
  const Made& made(std::uint64_t index) const noexcept { return made_[index]; }
  Made& made(std::uint64_t index) noexcept { return made_[index]; }
  std::uint64_t last() const noexcept { return made_.last(); }
  std::uint64_t first_after(std::uint64_t index) const noexcept { return made_.first_after(index); }
  /// Returns true if the cut's box lies within lo..hi (inclusive).
  bool is_inside(std::uint64_t index, const glm::ivec3& lo, const glm::ivec3& hi) const noexcept {
    const Box& box = boxes_[index];
    return glm::all(glm::greaterThanEqual(box.lo, lo)) && glm::all(glm::lessThanEqual(box.hi, hi));
  }
  /// Computes the box around all samples changed after the cut `index`; returns false if there was no cut. The box is
  /// unlimited if some of these cuts are no longer stored. `filled`: true if one of them may be a filling.
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
