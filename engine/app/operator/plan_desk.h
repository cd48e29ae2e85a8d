// Runs the planning of an implant: loads the jaw, evaluates the plan, draws the sections. Main thread only.
#pragma once

#include "engine/app/operator/long_work.h"
#include "engine/app/operator/preview.h"
#include "engine/app/operator/state.h"

namespace typodont {

class PlanDesk {
 public:
  PlanDesk(OperatorState& s, InterfaceWindow& w) : s_(s), preview_(s, w, s.plan.pictures) {}

  /// Shows the page, and loads the jaw of the selected scene in the background. `bone_class`: index in kBoneClasses,
  /// from 1; 0: the bone of the scene.
  void open(BackgroundTask& work, int bone_class = 0);
  /// Takes over findings and sections of the plan, and starts their computation after a change. True: something visible
  /// has changed.
  bool look();
  /// Frees the memory of the jaw.
  void close();

 private:
  OperatorState& s_;
  Preview preview_;
};

}  // namespace typodont
