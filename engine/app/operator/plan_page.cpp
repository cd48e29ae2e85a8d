// The page on which the user moves and tilts an implant in three sections, reads the findings and saves the plan.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "engine/app/operator/widgets.h"
#include "engine/base/units.h"

namespace typodont {

using namespace widgets;

namespace {

constexpr double kWheel = 0.25e-3;       // m, motion of the implant along its axis per wheel step
constexpr double kMaxTilt = 60;          // degrees, largest tilt of the implant that the user can set
constexpr double kToothMargin = 1.5e-3;  // m, usual safety distance between implant and root
// Index of the section that is perpendicular to the implant's axis, near its upper end.
constexpr std::size_t kLevel = 2;
constexpr std::array kPlanTitles{"op.plan_across", "op.plan_along", "op.plan_level"};

/// Dragging the apex tilts the implant, dragging elsewhere moves it; the wheel moves the implant along its axis.
void follow_mouse_of_plan(PlanForm& form, const SectionView& view, bool level, float near) {
  const ImGuiIO& io = ImGui::GetIO();
  session::ImplantPlan& plan = form.plan;
  const ImVec2 apex = view.screen(plan.apex_W()), platform = view.screen(plan.entry_W);
  ImDrawList* draw = ImGui::GetWindowDrawList();
  draw->AddCircle(platform, 0.35f * near, ImGui::GetColorU32(kGood), 0, 2);
  if (!level) draw->AddCircle(apex, 0.35f * near, ImGui::GetColorU32(kWarn), 0, 2);
  if (ImGui::IsItemActivated())
    form.tilting = !level && std::hypot(io.MousePos.x - apex.x, io.MousePos.y - apex.y) < near;
  if (ImGui::IsItemActive() && (io.MouseDelta.x != 0 || io.MouseDelta.y != 0)) {
    const dvec3 move =
        view.length(io.MouseDelta.x) * view.plane.right_W - view.length(io.MouseDelta.y) * view.plane.up_W;
    if (form.tilting) {
      const dvec3 axis = plan.apex_W() + move - plan.entry_W;
      if (glm::length(axis) > 0.2 * plan.length) plan.axis_W = glm::normalize(axis);
    } else {
      plan.entry_W += move;
    }
    if (!std::exchange(form.dragging, true)) ++form.drags;
    form.changed = true;
  }
  if (ImGui::IsItemDeactivated() && form.dragging) {
    form.dragging = form.tilting = false;
    form.changed = true;
  }
  if (ImGui::IsItemHovered() && io.MouseWheel != 0) {
    plan.entry_W -= static_cast<double>(io.MouseWheel) * kWheel * plan.axis_W;
    form.changed = true;
  }
}

void draw_section_of_plan(OperatorState& s, InterfaceWindow& w, std::size_t i, float size) {
  PlanForm& form = s.plan;
  titled_picture(s, w, kPlanTitles[i], form.pictures, i, size, [&](ImVec2 at) {
    follow_mouse_of_plan(form, {form.planes[i], at, size}, i == kLevel, w.style().unit);
  });
}

/// Draws number fields for three coordinates, mm.
bool edit_point(const char* id, dvec3& p_W) {
  std::array<double, 3> mm{p_W.x / kMillimetre, p_W.y / kMillimetre, p_W.z / kMillimetre};
  ImGui::SetNextItemWidth(-1);
  if (!ImGui::InputScalarN(id, ImGuiDataType_Double, mm.data(), 3, nullptr, nullptr, "%.2f",
                           ImGuiInputTextFlags_EnterReturnsTrue))
    return false;
  p_W = dvec3(mm[0], mm[1], mm[2]) * kMillimetre;
  return true;
}

/// Draws number fields for the implant's tilt towards x and towards y, degrees; 0: straight down.
bool edit_axis(dvec3& axis_W) {
  std::array<double, 2> tilt{std::atan2(axis_W.x, -axis_W.z) / kDegree, std::atan2(axis_W.y, -axis_W.z) / kDegree};
  ImGui::SetNextItemWidth(-1);
  if (!ImGui::InputScalarN("##tilt", ImGuiDataType_Double, tilt.data(), 2, nullptr, nullptr, "%.1f°",
                           ImGuiInputTextFlags_EnterReturnsTrue))
    return false;
  for (double& t : tilt) t = std::clamp(t, -kMaxTilt, kMaxTilt) * kDegree;
  axis_W = glm::normalize(dvec3(std::tan(tilt[0]), std::tan(tilt[1]), -1));
  return true;
}

void draw_findings(OperatorState& s) {
  const PlanFindings& found = s.plan.findings;
  const auto mm = [&](double metres) { return fmt::format("{} mm", s.number(metres / kMillimetre, 1)); };
  const double margin = s.plan.procedures[static_cast<std::size_t>(s.plan.procedure)].canal_margin;
  row(s.text("op.plan_in_bone"), fmt::format("{} %", s.number(100 * found.in_bone, 0)), found.fits() ? &kGood : &kBad);
  if (!found.fits()) row(s.text("op.plan_leaves"), mm(found.leaves_depth), &kBad);
  const auto distance = [&](const char* name, double metres, double least) {
    if (std::isfinite(metres)) row(s.text(name), mm(metres), metres < 0 ? &kBad : metres < least ? &kWarn : &kGood);
  };
  distance("op.plan_canal", found.canal_distance, margin);
  distance("op.plan_tooth", found.tooth_distance, kToothMargin);
  row(s.text("op.plan_grey"), fmt::format("{} HU", s.number(found.mean_grey, 0)));
}

void draw_side_of_plan(OperatorState& s, InterfaceWindow& w, ImVec2 size) {
  PlanForm& form = s.plan;
  const PagePanel panel("plan", s.text("op.plan"), size, w);
  if (choice("##procedure", form.procedure, 0, static_cast<int>(form.procedures.size()),
             [&](int i) { return form.procedures[static_cast<std::size_t>(i)].name; }))
    form.changed = true;
  // If another bone is selected, the jaw is loaded again, with the plan of the scene.
  if (form.bone_class > 0) {
    const auto title = [&](int i) {
      return fmt::format("{} {}", s.text("op.plan_class"), kBoneClasses[static_cast<std::size_t>(i - 1)]);
    };
    int wanted = form.bone_class;
    if (choice("##class", wanted, 1, static_cast<int>(kBoneClasses.size()) + 1, title) && !s.busy)
      s.ask(Ask::kPlan, wanted);
  }
  dim(s.text("op.plan_platform"));
  if (edit_point("##platform", form.plan.entry_W)) form.changed = true;
  dim(s.text("op.plan_tilt"));
  if (edit_axis(form.plan.axis_W)) form.changed = true;
  if (slider(s, "##width", form.width_mm, 15, 120, s.text("op.plan_width"), 0, " mm")) form.changed = true;
  ImGui::Spacing();
  draw_findings(s);
  ImGui::Spacing();
  note(s.text("op.plan_help"), w);
  ImGui::Spacing();
  text_field("##name", s.text("op.exercise_name"), form.name);
  ask_button(s, Ask::kSavePlan, s.text("op.plan_save"), {-1, 0}, !s.busy && form.findings.fits() && form.name[0] != 0,
             true);
}

}  // namespace

void draw_plan_page(OperatorState& s, InterfaceWindow& w) {
  const float u = w.style().unit;
  const ImVec2 body = begin_titled_page(s.text("op.plan"), w), gap = ImGui::GetStyle().ItemSpacing;
  if (!s.plan.planner) return end_empty_page(s, w, body);
  // Arranges three squares: two large ones above a smaller one.
  const float height = body.y, side = std::max(0.3f * body.x, 20 * u), captions = 2 * (1.4f * u + gap.y) + gap.y;
  const float large = std::min((body.x - side - 2 * gap.x) / 2, 0.62f * (height - captions));
  begin_column("sections", {body.x - side - gap.x, height});
  draw_section_of_plan(s, w, 0, large);
  ImGui::SameLine();
  draw_section_of_plan(s, w, 1, large);
  draw_section_of_plan(s, w, 2, height - captions - large);
  ImGui::EndChild();
  ImGui::SameLine();
  draw_side_of_plan(s, w, {side, height});
  end_titled_page(s, w);
}

}  // namespace typodont
