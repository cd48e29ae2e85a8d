// The picture of the selected exercise. Only this picture is shown, so no other is loaded or drawn. Also prepares the
// exercise's first session. Main thread only.
#pragma once

#include <filesystem>
#include <set>

#include "engine/app/operator/interface_window.h"
#include "engine/app/operator/job.h"
#include "engine/app/operator/state.h"
#include "engine/base/clock.h"

namespace typodont {

class ScenePictures {
 public:
  ScenePictures(OperatorState& s, InterfaceWindow& w) : s_(s), window_(w) {}

  /// Works for the selected exercise in the background: loads its picture (NAME.png beside the scene, or from the
  /// cache) or draws it; then, if the exercise stays selected, fills the caches, so that a session starts faster. True:
  /// work has ended, and the picture may be new.
  bool look();
  /// Cancels the work. The next look() begins it again.
  void drop();

 private:
  void load();
  void prepare();

  OperatorState& s_;
  InterfaceWindow& window_;
  std::filesystem::path selected_;          // the exercise for which job_ works
  Nanos selected_at_ = 0;                   // ns
  bool prepared_ = false;                   // true: the caches for `selected_` are filled, or job_ fills them
  std::set<std::filesystem::path> failed_;  // scenes without a picture that can be loaded or drawn
  Job job_;
};

}  // namespace typodont
