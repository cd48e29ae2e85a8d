#include "engine/app/operator/plan_desk.h"

#include <algorithm>
#include <string>

#include "engine/base/log.h"
#include "engine/base/units.h"

namespace typodont {

namespace {
constexpr int kPlanSectionPixels = 384;  // pixels, side of a section's picture

struct Planned {
  PlanFindings findings;
  PlanPlanes planes;
  std::vector<render::Picture> pictures;
};
}  // namespace

void PlanDesk::open(BackgroundTask& work, int bone_class) {
  close();
  const SceneChoice& choice = s_.scenes.at(static_cast<std::size_t>(s_.scene));
  const std::string name = choice.title + " 2";
  name.copy(s_.plan.name.data(), std::min(name.size(), s_.plan.name.size() - 1));
  s_.open(Page::kPlan);
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
        s_.plan.planner = loaded.planner;
        s_.plan.procedures = loaded.procedures;
        s_.plan.procedure = loaded.procedure;
        s_.plan.bone_class = loaded.bone_class;
        s_.plan.plan = loaded.plan;
        s_.plan.changed = true;
        log::info("jaw loaded: {}", loaded.planner->scene().name);
      });
}

bool PlanDesk::look() {
  PlanForm& form = s_.plan;
  if (s_.page != Page::kPlan || !form.planner) return false;
  const bool finished = preview_.look();
  const ImplantProcedure& procedure = form.procedures[static_cast<std::size_t>(form.procedure)];
  form.plan.length = procedure.length;
  form.plan.diameter = procedure.diameter;
  form.plan.bed_diameter = procedure.bed_diameter;
  if (!preview_.due(form.changed)) return finished;
  form.changed = false;
  // While the implant is dragged, the section planes do not move: only the implant moves in the picture.
  preview_.begin(
      [planner = form.planner, plan = form.plan, dragging = form.dragging, planes = form.planes,
       width = static_cast<double>(form.width_mm) * kMillimetre](Progress& progress) {
        Planned planned{planner->findings(plan), dragging ? planes : planner->planes(plan, width), {}};
        for (const SectionPlane& plane : planned.planes) {
          progress.at(0);
          planned.pictures.push_back(planner->picture(plane, plan, kPlanSectionPixels));
        }
        return planned;
      },
      [&form, drags = form.drags](const Planned& planned) {
        if (form.drags != drags) return false;  // a drag has begun since, and the planes must not move under it
        form.findings = planned.findings;
        form.planes = planned.planes;
        return true;
      });
  return finished;
}

void PlanDesk::close() {
  preview_.close();
  s_.plan = {};
}

}  // namespace typodont
