// Planning an implant in the window: loads the jaw, evaluates the plan and draws its sections. Main thread.
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

  /// Shows the page and loads the jaw of the selected scene while the window continues. `bone_class`: index in
  /// kBoneClasses, from 1; 0: the scene's bone.
  void open(BackgroundTask& work, int bone_class = 0);
  /// Evaluates and draws the plan if it changed. Call before drawing the page.
  void follow();
  /// Destroys the pictures' GPU memory, e.g. of a lost device. The next follow() draws them again.
  void destroy();
  /// Frees the memory of the jaw.
  void close();
  /// The jaw with its scene; null while it loads.
  const std::shared_ptr<const ImplantPlanner>& planner() const { return planner_; }

 private:
  OperatorState& s_;
  InterfaceWindow& window_;
  std::shared_ptr<const ImplantPlanner> planner_;
  std::vector<gpu::Image> images_;
};

}  // namespace typodont
