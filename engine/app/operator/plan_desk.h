// Planning an implant: jaw, evaluation, sections. Main thread only.
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

  /// Shows the page, loads the selected scene's jaw in the background. `bone_class`: of kBoneClasses, from 1; 0: the
  /// scene's bone.
  void open(BackgroundTask& work, int bone_class = 0);
  /// Evaluates and draws after a change, before the page is drawn.
  void follow();
  /// GPU memory of the pictures; the next follow() creates them again.
  void destroy();
  /// The jaw's memory.
  void close();
  /// Jaw and scene; null until loaded.
  const std::shared_ptr<const ImplantPlanner>& planner() const { return planner_; }

 private:
  OperatorState& s_;
  InterfaceWindow& window_;
  std::shared_ptr<const ImplantPlanner> planner_;
  std::vector<gpu::Image> images_;
};

}  // namespace typodont
