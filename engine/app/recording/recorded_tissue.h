// The tissue of a recorded session at any time. The recorded cuts are applied in order, including strokes that were
// undone later. For one thread.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "engine/app/scene.h"
#include "engine/session/session_file.h"
#include "haptics/carver.h"

namespace typodont {

class RecordedTissue {
 public:
  /// `start`: tissue before the first tick. Session and scene must outlive this object. Throws Error.
  RecordedTissue(const session::SessionReader& session, const Scene& scene, haptics::TissueVolume start);

  /// Forward: applies the cuts and edits up to the time t. Backward: undoes all strokes that end after t; if the first
  /// of them began before t, applies its cuts before t again.
  void seek(Nanos t);
  haptics::Carver& carver() { return *carver_; }
  const haptics::Carver& carver() const { return *carver_; }
  /// The cuts that the current tissue contains, in order, without undone strokes.
  std::vector<const Cut*> cuts() const;
  /// Number of times that seek() started again from the initial tissue.
  int restarts() const { return restarts_; }

 private:
  /// A change of tissue: a cut, an undo or a redo.
  struct Deed {
    Nanos t = 0;
    const Cut* cut = nullptr;  // the cut; null for an undo or redo
    bool redo = false;
  };
  /// An applied change of the tissue, with what is needed to revert it.
  struct Done {
    enum class Kind { kStroke, kUndo, kRedo } kind;
    std::size_t first;    // index in deeds_ of the first cut or edit that belongs to this change
    std::size_t strokes;  // number of strokes (cuts without a pause) after the change
    bool forgets;         // true: undone strokes were discarded, so the carver cannot revert this change
  };
  void restart();
  void go_back(Nanos t);
  void go_on(Nanos t);

  const Scene& scene_;
  std::vector<Deed> deeds_;
  std::optional<haptics::Carver> carver_;
  std::size_t next_ = 0;  // index of the next change in deeds_
  std::vector<Done> done_;
  int restarts_ = 0;
};

/// The tissue at time t of a session (or at its end). `start`: its initial tissue.
haptics::TissueVolume tissue_at(const session::SessionReader& session, const Scene& scene, haptics::TissueVolume start,
                                Nanos t);
haptics::TissueVolume tissue_at_end(const session::SessionReader& session, const Scene& scene,
                                    haptics::TissueVolume start);

}  // namespace typodont
