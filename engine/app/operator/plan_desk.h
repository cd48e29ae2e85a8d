// Runs the planning of an implant: loads the jaw, evaluates the plan, draws the sections. Main thread only.
#pragma once

#include <memory>
#include <optional>

#include "engine/app/operator/interface_window.h"
#include "engine/app/operator/long_work.h"
#include "engine/app/operator/state.h"
#include "engine/app/planning/implant_planner.h"

namespace typodont {

class PlanDesk {
 public:
  PlanDesk(OperatorState& s, InterfaceWindow& w) : s_(s), pictures_(w) {}

  /// Shows the page, and loads the jaw of the selected scene in the background. `bone_class`: index in kBoneClasses,
  /// from 1; 0: the bone of the scene.
  void open(BackgroundTask& work, int bone_class = 0);
  /// Evaluates and draws the plan after a change. Call before the page is drawn.
  void follow();
  /// Frees the GPU memory of the pictures; the next follow() creates them again.
  void destroy();
  /// Frees the memory of the jaw.
  void close();
  /// Jaw and scene for the planning; null until they are loaded.
  const std::shared_ptr<const ImplantPlanner>& planner() const { return planner_; }

 private:
  OperatorState& s_;
  std::shared_ptr<const ImplantPlanner> planner_;
  UploadedPictures pictures_;
};

}  // namespace typodont
