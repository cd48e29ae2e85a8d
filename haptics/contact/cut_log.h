// A log of the servo's last cuts. If a new snapshot of the tissue lacks some of these cuts, the servo reads them from
// the log and repeats them in the snapshot.
#pragma once

#include <algorithm>
#include <climits>
#include <cstdint>
#include <utility>
#include <vector>

#include "engine/contract/contact.h"

namespace typodont::haptics {

/// Ring buffer with the data that a contact model stores for each cut. Cuts are numbered 1, 2, 3 … A new entry
/// overwrites the oldest one. Allocates memory at construction only. Servo thread only.
template <class Made>
class RecentCuts {
 public:
  // number of stored cuts; a late snapshot may lack at most this number of cuts
  static constexpr std::uint64_t kLength = 8192;

  RecentCuts() : made_(kLength) {}

  /// Adds an entry. `index` must be the index of the last cut plus one.
  void add(std::uint64_t index, const Made& made) noexcept {
    made_[index % kLength] = made;
    last_ = index;
  }
  const Made& operator[](std::uint64_t index) const noexcept { return made_[index % kLength]; }
  Made& operator[](std::uint64_t index) noexcept { return made_[index % kLength]; }
  /// Returns the index of the last cut; 0: no cut yet.
  std::uint64_t last() const noexcept { return last_; }
  /// Returns the index of the oldest stored cut after `index`; last() + 1 if no such cut is stored.
  std::uint64_t first_after(std::uint64_t index) const noexcept {
    return std::max(index, last_ >= kLength ? last_ - kLength : 0) + 1;
  }

 private:
  std::vector<Made> made_;
  std::uint64_t last_ = 0;
};

/// A cut that must be repeated in a snapshot that lacks it.
struct MadeCut {
  Pose X_WA, X_WB;
  std::uint32_t tool = 0;
  PerTissue removed{};  // m³, removed volume of each tissue
};

/// Log of the cuts and fillings of a model that works in a SurfacePatch (copy of the field around the tool). Each entry
/// includes the box of voxels that the cut may have changed.
class CutLog {
 public:
  /// The data needed to repeat a cut in another patch (copy of the field around the tool).
  struct Made {
    Pose X_WA, X_WB;
    std::uint32_t tool = 0;
    bool continues = false;
    // Only for a filling: radius in m of the added ball of filling material, whose centre is the position of the pose
    // X_WA. No material is added inside the instrument's head at the pose X_WB. For a cut the radius is 0.
    double fill_radius = 0;
    PerTissue removed{};  // voxels³, removed volume of each tissue; negative for a filling
  };

  /// Adds an entry. `lo` and `hi` are the corners of the box of voxels that the cut may have changed.
  void add(std::uint64_t index, const glm::ivec3& lo, const glm::ivec3& hi, const Made& cut) noexcept {
    boxes_.add(index, {lo, hi, cut.fill_radius > 0});
    made_.add(index, cut);
  }
  const Made& made(std::uint64_t index) const noexcept { return made_[index]; }
  std::uint64_t last() const noexcept { return made_.last(); }
  std::uint64_t first_after(std::uint64_t index) const noexcept { return made_.first_after(index); }
  /// Returns true if the cut `index` can only have changed voxels of the box lo..hi (inclusive).
  bool is_inside(std::uint64_t index, const glm::ivec3& lo, const glm::ivec3& hi) const noexcept {
    const Box& box = boxes_[index];
    return glm::all(glm::greaterThanEqual(box.lo, lo)) && glm::all(glm::lessThanEqual(box.hi, hi));
  }
  /// Computes the box in which the cuts after `index` may have changed the field, with the corners `lo` and `hi`. If
  /// some of these cuts are no longer stored, the box is the whole patch (copy of the field). Returns false if there is
  /// no cut after `index`. `filled`: true if one of these cuts may be a filling.
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
