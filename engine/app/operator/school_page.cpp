// The page of the school: account, assignments, own scores.
#include <fmt/format.h>

#include "engine/app/operator/widgets.h"

namespace typodont {

namespace {

using namespace widgets;

void draw_account(OperatorState& s, InterfaceWindow& w, ImVec2 size) {
  SchoolForm& form = s.school;
  const PagePanel panel("account", s.text("op.school_account"), size, w);
  if (form.student.empty()) {
    dim_wrapped(s.text("op.school_guest"));
    ImGui::Spacing();
    if (ImGui::IsWindowAppearing()) ImGui::SetKeyboardFocusHere();
    text_field("##name", s.text("op.school_name"), form.name);
    ImGui::SetNextItemWidth(-1);
    const bool entered =
        ImGui::InputTextWithHint("##password", s.text("op.school_password"), form.password.data(), form.password.size(),
                                 ImGuiInputTextFlags_Password | ImGuiInputTextFlags_EnterReturnsTrue);
    const bool can = form.name[0] != 0 && form.password[0] != 0 && !form.busy;
    if (key_button(s.text("op.school_sign_in"), {-1, 0}, can, entered, true)) s.ask(Ask::kSchoolSignIn);
  } else {
    row(s.text("op.school_signed_in"), form.student);
    ImGui::Checkbox(s.text("op.school_hand_in"), &form.hand_in);
    if (ImGui::Button(s.text("op.school_sign_out"), {-1, 0})) s.ask(Ask::kSchoolSignOut);
  }
  ImGui::Spacing();
  message(form.message);
}

void draw_assignments(OperatorState& s, InterfaceWindow& w, ImVec2 size) {
  SchoolForm& form = s.school;
  const float u = w.style().unit;
  const PagePanel panel("assignments", s.text("op.school_assignments"), size, w);
  if (form.assignments.empty() && !form.student.empty())
    dim_wrapped(form.busy ? "…" : s.text("op.school_no_assignment"));
  for (std::size_t i = 0; i < form.assignments.size(); ++i) {
    const SchoolForm::Assignment& one = form.assignments[i];
    ImGui::PushID(one.number);
    const ImVec2 at = ImGui::GetCursorPos();
    if (ImGui::Selectable("##assignment", static_cast<int>(i) == form.assignment, 0, {0, 3.4f * u}))
      form.assignment = static_cast<int>(i);
    const ImVec2 after = ImGui::GetCursorPos();
    const float room = ImGui::GetContentRegionAvail().x - 0.8f * u;
    ImGui::SetCursorPos({at.x + 0.6f * u, at.y + 0.45f * u});
    one_line(one.sealed ? fmt::format("{} ({})", one.title, s.text("op.school_exam")) : one.title, room);
    ImGui::SetCursorPos({at.x + 0.6f * u, at.y + 1.75f * u});
    ImGui::PushFont(w.style().small);
    dim(fitted(s.words("op.school_due", one.due, one.left), room));
    ImGui::PopFont();
    ImGui::SetCursorPos(after);
    ImGui::PopID();
  }
  const auto chosen = static_cast<std::size_t>(form.assignment);
  if (chosen < form.assignments.size() && form.assignments[chosen].sealed) {
    ImGui::Spacing();
    dim_wrapped(s.text("op.school_exam_note"));
  }
}

void draw_curves(OperatorState& s, InterfaceWindow& w, ImVec2 size) {
  const float u = w.style().unit;
  const PagePanel panel("curves", s.text("op.school_curve"), size, w);
  if (s.school.curves.empty() && !s.school.student.empty())
    dim_wrapped(s.school.busy ? "…" : s.text("op.school_no_curve"));
  for (const SchoolForm::Curve& curve : s.school.curves) {
    if (curve.points.empty()) continue;
    row(curve.title.c_str(), s.number(static_cast<double>(curve.points.back()), 1));
    ImGui::PushID(&curve);
    ImGui::PlotHistogram("##curve", curve.points.data(), static_cast<int>(curve.points.size()), 0, nullptr, 0, 100,
                         {ImGui::GetContentRegionAvail().x, 5 * u});
    ImGui::PopID();
    ImGui::Spacing();
  }
}

}  // namespace

void draw_school_page(OperatorState& s, InterfaceWindow& w) {
  const ImVec2 body = begin_titled_page(s.text("op.school"), w), gap = ImGui::GetStyle().ItemSpacing;
  const float column = (body.x - 2 * gap.x) / 3;
  draw_account(s, w, {column, body.y});
  ImGui::SameLine();
  draw_assignments(s, w, {column, body.y});
  ImGui::SameLine();
  draw_curves(s, w, {column, body.y});
  end_titled_page(s, w, true, [&](ImVec2 button) {
    const SchoolForm& form = s.school;
    const auto chosen = static_cast<std::size_t>(form.assignment);
    const bool any = chosen < form.assignments.size();
    ask_button(s, Ask::kSchoolTake,
               s.text(any && form.assignments[chosen].sealed ? "op.school_begin_exam" : "op.school_take"), button,
               any && form.assignments[chosen].left > 0 && !form.busy, true);
  });
}

}  // namespace typodont
