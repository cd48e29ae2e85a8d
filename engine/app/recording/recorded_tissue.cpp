#include "engine/app/recording/recorded_tissue.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "engine/app/recording.h"
#include "engine/app/recording/resume.h"

namespace typodont {

RecordedTissue::RecordedTissue(const session::SessionReader& session, const Scene& scene, haptics::TissueVolume start)
    : scene_(scene), carver_(std::in_place, std::move(start), scene.servo) {
  const std::vector<StrokeEdit> edits = edits_of(session);
  auto edit = edits.begin();
  const auto add_edits = [&](std::uint64_t before_cut) {
    for (; edit != edits.end() && edit->cuts < before_cut; ++edit) deeds_.push_back({edit->t, nullptr, edit->redo});
  };
  for (const Cut& cut : session.cuts()) {
    add_edits(cut.index);
    deeds_.push_back({cut.t, &cut, false});
  }
  add_edits(UINT64_MAX);
  // Two threads with different clocks recorded these changes, so a time may be smaller than the one before it. Such
  // times are increased; the recorded order does not change.
  for (std::size_t i = 1; i < deeds_.size(); ++i) deeds_[i].t = std::max(deeds_[i].t, deeds_[i - 1].t);
}

void RecordedTissue::restart() {
  carver_.emplace(load_tissue(scene_), scene_.servo);
  next_ = 0;
  done_.clear();
  ++restarts_;
}

void RecordedTissue::seek(Nanos t) {
  go_back(t);
  go_on(t);
}

void RecordedTissue::go_on(Nanos t) {
  haptics::Carver& carver = *carver_;
  for (; next_ < deeds_.size() && deeds_[next_].t <= t; ++next_) {
    const Deed& deed = deeds_[next_];
    if (deed.cut) {
      // In a recording with gaps, cuts are missing. The carver expects consecutive numbers, so cuts get new numbers.
      Cut cut = *deed.cut;
      cut.index = carver.cuts() + 1;
      if (carver.begins_stroke(cut)) {
        carver.end_stroke();
        const auto before = carver.strokes();
        done_.push_back({Done::Kind::kStroke, next_, before.done + 1, before.undone > 0});
      }
      carver.apply(cut);
    } else if (deed.redo ? carver.redo() : carver.undo()) {
      done_.push_back({deed.redo ? Done::Kind::kRedo : Done::Kind::kUndo, next_, carver.strokes().done, false});
    }
  }
}

void RecordedTissue::go_back(Nanos t) {
  haptics::Carver& carver = *carver_;
  while (next_ > 0 && deeds_[next_ - 1].t > t) {
    if (done_.empty() || done_.back().forgets) return restart();
    const Done last = done_.back();
    done_.pop_back();
    next_ = last.first;
    if (last.kind == Done::Kind::kStroke) {
      carver.end_stroke();
      // The carver discards a stroke that changed nothing; then there is nothing to undo.
      if (carver.strokes().done == last.strokes) carver.undo();
    } else if (last.kind == Done::Kind::kUndo) {
      carver.redo();
    } else {
      carver.undo();
    }
  }
}

std::vector<const Cut*> RecordedTissue::cuts() const {
  // Indices in done_: of strokes in the tissue; of undone ones. The carver does not count strokes without a change.
  std::vector<std::size_t> kept, undone;
  std::size_t earlier = 0;  // number of strokes made before this session
  for (std::size_t i = 0; i < done_.size(); ++i) {
    const Done& done = done_[i];
    // number of strokes before this change
    const std::size_t count = done.kind == Done::Kind::kUndo ? done.strokes + 1 : done.strokes - 1;
    if (kept.empty()) earlier = count;
    while (kept.size() + earlier > count && !kept.empty()) kept.pop_back();
    if (done.kind == Done::Kind::kStroke) {
      kept.push_back(i);
      undone.clear();
    } else if (done.kind == Done::Kind::kUndo) {
      if (kept.empty()) continue;
      undone.push_back(kept.back());
      kept.pop_back();
    } else if (!undone.empty()) {
      kept.push_back(undone.back());
      undone.pop_back();
    }
  }
  std::vector<const Cut*> cuts;
  for (const std::size_t i : kept) {
    const std::size_t end = i + 1 < done_.size() ? done_[i + 1].first : next_;
    for (std::size_t deed = done_[i].first; deed < end; ++deed)
      if (deeds_[deed].cut) cuts.push_back(deeds_[deed].cut);
  }
  return cuts;
}

haptics::TissueVolume tissue_at(const session::SessionReader& session, const Scene& scene, haptics::TissueVolume start,
                                Nanos t) {
  RecordedTissue tissue(session, scene, std::move(start));
  tissue.seek(t);
  tissue.carver().end_stroke();
  return tissue.carver().take_tissue();
}

haptics::TissueVolume tissue_at_end(const session::SessionReader& session, const Scene& scene,
                                    haptics::TissueVolume start) {
  return tissue_at(session, scene, std::move(start), std::numeric_limits<Nanos>::max());
}

}  // namespace typodont
