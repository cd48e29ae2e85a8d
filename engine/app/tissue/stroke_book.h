// Records what each stroke removed or painted, so that TissueState has the right sums after an undo. Used only by
// the thread that owns the tissue.
#pragma once

#include <vector>

#include "engine/app/tissue/paint_file.h"
#include "engine/contract/contact.h"
#include "haptics/tissue_volume.h"

namespace typodont {

/// State of the tissue as a session shows it.
struct TissueState {
  haptics::TissueVolume::Strokes strokes;
  std::uint32_t undone = 0, redone = 0;  // numbers of undos and redos since the session's start
  PerTissue removed{};                   // m³, removed volume, without undone strokes
  std::size_t painted = 0;               // number of brush strokes that are not undone
  std::uint64_t version = 0;             // number that increases whenever the tissue changes
};

class StrokeHistory {
 public:
  using Strokes = haptics::TissueVolume::Strokes;

  // Adds a cut. `strokes`: state after the cut.
  void cut(const Cut& cut, const Strokes& strokes) {
    PerTissue& sum = entry(strokes).removed;
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += cut.removed[i];
    for (std::size_t i = 0; i < sum.size(); ++i) state_.removed[i] += cut.removed[i];
    ++state_.version;
  }
  void painted(const PaintStroke& stroke, const Strokes& strokes) {
    entry(strokes).paint.push_back(stroke);
    ++state_.painted;
    ++state_.version;
  }
  /// Computes the sums of removed volume and brush strokes again after an undo or redo.
  void edited(bool redo, const Strokes& strokes) {
    ++(redo ? state_.redone : state_.undone);
    ++state_.version;
    const std::size_t done = strokes.done;
    if (entries_.size() < done) entries_.resize(done);
    state_.removed = {};
    state_.painted = 0;
    for (std::size_t k = 0; k < done; ++k) {
      for (std::size_t i = 0; i < state_.removed.size(); ++i) state_.removed[i] += entries_[k].removed[i];
      state_.painted += entries_[k].paint.size();
    }
  }
  TissueState state(const Strokes& strokes) const {
    TissueState state = state_;
    state.strokes = strokes;
    return state;
  }
  /// The brush strokes in order, without undone ones.
  std::vector<PaintStroke> paint(const Strokes& strokes) const {
    std::vector<PaintStroke> all;
    for (std::size_t k = 0; k < std::min(strokes.done, entries_.size()); ++k)
      all.insert(all.end(), entries_[k].paint.begin(), entries_[k].paint.end());
    return all;
  }

 private:
  struct Entry {
    PerTissue removed{};
    std::vector<PaintStroke> paint;
  };
  /// A new stroke makes redo impossible, so the entries of undone strokes are removed.
  Entry& entry(const Strokes& strokes) {
    entries_.resize(std::max<std::size_t>(strokes.done, 1));
    return entries_.back();
  }

  std::vector<Entry> entries_;
  TissueState state_;
};

}  // namespace typodont
