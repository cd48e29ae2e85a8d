#include "engine/app/operator/plan_desk.h"

#include <algorithm>
#include <exception>
#include <string>
#include <utility>

#include "engine/base/log.h"
#include "engine/base/units.h"

namespace typodont {

namespace {
constexpr int kPlanSectionPixels = 384;  // pixels, side of a section's picture
}

void PlanDesk::open(BackgroundTask& work, int bone_class) {
  close();
  const SceneChoice& choice = s_.scenes.at(static_cast<std::size_t>(s_.scene));
  s_.plan = {};
  const std::string name = choice.title + " 2";
  name.copy(s_.plan.name.data(), std::min(name.size(), s_.plan.name.size() - 1));
  s_.page = Page::kPlan;
  s_.say("");
  struct Loaded {
    std::shared_ptr<const ImplantPlanner> planner;
    std::vector<ImplantProcedure> procedures;
    session::ImplantPlan plan;
    int procedure = 0, bone_class = 0;
  };
  work.make(
      [file = choice.file, bone_class](Progress& progress) {
        Loaded loaded;
        progress.stage("op.loading", 0, 1);
        Scene scene = read_scene(file);
        if (bone_class > 0)
          scene = with_bone_class(scene, std::string(kBoneClasses[static_cast<std::size_t>(bone_class - 1)]));
        const auto found = std::ranges::find(kBoneClasses, bone_class_of(scene));
        if (found != kBoneClasses.end()) loaded.bone_class = static_cast<int>(found - kBoneClasses.begin()) + 1;
        loaded.procedures = implant_procedures();
        if (const auto own = procedure_of(scene)) {
          const auto same = std::ranges::find(loaded.procedures, own->path, &ImplantProcedure::path);
          loaded.procedure = static_cast<int>(same - loaded.procedures.begin());
          if (same == loaded.procedures.end()) loaded.procedures.push_back(*own);
        }
        loaded.planner = std::make_shared<const ImplantPlanner>(scene);
        progress.at(0.8);
        loaded.plan = loaded.planner->proposal(loaded.procedures[static_cast<std::size_t>(loaded.procedure)]);
        progress.at(1);
        return loaded;
      },
      [this](const Loaded& loaded) {
        planner_ = loaded.planner;
        s_.plan.procedures = loaded.procedures;
        s_.plan.procedure = loaded.procedure;
        s_.plan.bone_class = loaded.bone_class;
        s_.plan.plan = loaded.plan;
        s_.plan.ready = s_.plan.changed = true;
        log::info("jaw loaded: {}", planner_->scene().name);
      });
}

bool PlanDesk::look() {
  if (s_.page != Page::kPlan || !planner_) return false;
  PlanForm& form = s_.plan;
  const bool finished = job_ && job_->done();
  if (finished) {
    if (const auto failure = std::exchange(job_, nullptr)->failure()) {
      failed_ = true;
      try {
        std::rethrow_exception(failure);
      } catch (const std::exception& e) {
        s_.fail(e.what());
      }
      return true;
    }
    destroy();
    form.findings = computed_->findings;
    form.planes = computed_->planes;
    for (const render::Picture& picture : computed_->pictures) pictures_.add(picture);
    pictures_.list(form.pictures);
    ++form.drawn;
  }
  const ImplantProcedure& procedure = form.procedures[static_cast<std::size_t>(form.procedure)];
  form.plan.length = procedure.length;
  form.plan.diameter = procedure.diameter;
  form.plan.bed_diameter = procedure.bed_diameter;
  if (job_ || !(form.changed || (pictures_.empty() && !failed_))) return finished;
  form.changed = failed_ = false;
  computed_ = std::make_shared<Computed>();
  // While the implant is dragged, the section planes do not move: only the implant moves in the picture.
  computed_->planes = form.planes;
  job_ = std::make_unique<Job>([computed = computed_, planner = planner_, plan = form.plan, dragging = form.dragging,
                                width = static_cast<double>(form.width_mm) * kMillimetre](Progress&) {
    computed->findings = planner->findings(plan);
    if (!dragging) computed->planes = planner->planes(plan, width);
    for (std::size_t i = 0; i < computed->planes.size(); ++i)
      computed->pictures[i] = planner->picture(computed->planes[i], plan, kPlanSectionPixels);
  });
  return finished;
}

void PlanDesk::destroy() {
  s_.plan.pictures = {};
  pictures_.clear();
}

void PlanDesk::close() {
  destroy();
  job_.reset();
  planner_.reset();
  failed_ = false;
  s_.plan = {};
}

}  // namespace typodont
