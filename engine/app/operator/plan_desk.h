// Runs the planning of an implant: loads the jaw, evaluates the plan, draws the sections. Main thread only.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <tuple>

#include "engine/app/operator/interface_window.h"
#include "engine/app/operator/job.h"
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
  /// Takes over findings and sections of the plan, and starts their computation after a change. Changes during a
  /// computation are computed together afterwards. True: something visible has changed.
  bool look();
  /// Frees the GPU memory of the pictures; look() creates them again.
  void destroy();
  /// Frees the memory of the jaw.
  void close();
  /// Jaw and scene for the planning; null until they are loaded.
  const std::shared_ptr<const ImplantPlanner>& planner() const { return planner_; }

 private:
  OperatorState& s_;
  std::shared_ptr<const ImplantPlanner> planner_;
  UploadedPictures pictures_;
  struct Computed {
    PlanFindings findings;
    PlanPlanes planes;
    std::array<render::Picture, std::tuple_size_v<PlanPlanes>> pictures;
  };
  std::shared_ptr<Computed> computed_;  // result of job_
  std::unique_ptr<Job> job_;            // evaluates and draws the plan
  bool failed_ = false;                 // true: the last job failed; only a change of the plan starts another
};

}  // namespace typodont
