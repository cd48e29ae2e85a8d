// Planning an implant in the window: loads the jaw, evaluates the plan and draws its sections. Main thread only.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "engine/app/operator/interface_window.h"
#include "engine/app/operator/long_work.h"
#include "engine/app/operator/state.h"
#include "engine/app/planning/implant_planner.h"

namespace typodont {

class PlanDesk {
 public:
  PlanDesk(OperatorState& s, InterfaceWindow& w) : s_(s), window_(w) {}
  ~PlanDesk() { destroy(); }
  PlanDesk(const PlanDesk&) = delete;
  PlanDesk& operator=(const PlanDesk&) = delete;

  /// Shows the page and loads the jaw of the selected scene in the background. `bone_class`: number of a class in
  /// kBoneClasses, from 1; 0: the scene's own bone.
  void open(BackgroundTask& work, int bone_class = 0);
  /// Evaluates and draws the plan again if it has changed. Call it before the page is drawn.
  void follow();
  /// Frees the GPU memory of the pictures, for example after the GPU was lost. The next follow() creates them again.
  void destroy();
  /// Frees the memory of the jaw.
  void close();
  /// Returns the jaw with its scene; null until it is loaded.
  const std::shared_ptr<const ImplantPlanner>& planner() const { return planner_; }

 private:
  OperatorState& s_;
  InterfaceWindow& window_;
  std::shared_ptr<const ImplantPlanner> planner_;
  std::vector<gpu::Image> images_;
};

}  // namespace typodont
