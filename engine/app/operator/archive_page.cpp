// The page of recorded sessions with their scores, and of the import of teeth.
#include <fmt/format.h>

#include <algorithm>

#include "engine/app/assets.h"
#include "engine/app/operator/widgets.h"
#include "engine/session/score.h"
#include "haptics/import/import.h"

namespace typodont {

namespace {

using namespace widgets;

/// Draws the points, 0 to 100; red if they are below the pass mark.
void draw_known_score(const OperatorState& s, const SessionEntry& one) {
  if (!one.score) return dim(one.recorded ? "…" : "–");
  if (!one.score->counts) return dim("–");
  const float room = ImGui::GetContentRegionAvail().x;
  const std::string points = s.number(session::printed_points(one.score->points), 1);
  ImGui::SetCursorPosX(ImGui::GetCursorPosX() + std::max(room - ImGui::CalcTextSize(points.c_str()).x, 0.0f));
  colored(points, one.score->passed ? kGood : kBad);
  if (!one.score->passed && ImGui::IsItemHovered()) ImGui::SetTooltip("%s", s.text("not_passed"));
}

void draw_sessions(OperatorState& s, InterfaceWindow& w, ImVec2 size) {
  const PagePanel panel("sessions", s.text("op.sessions"), size, w);
  const int count = static_cast<int>(s.sessions.size());
  const bool moved = step_through(s.session, s.sessions.size());
  if (s.sessions.empty()) dim_wrapped(s.text("op.no_sessions"));
  if (count > 0 && begin_table("sessions", {{s.text("date"), 1.3f},
                                            {s.text("op.exercise"), 1.6f},
                                            {s.text("trainee"), 1},
                                            {s.text("score"), 0.6f},
                                            {s.text("op.size"), 0.7f}})) {
    for (int i = 0; i < count; ++i) {
      const SessionEntry& one = s.sessions[static_cast<std::size_t>(i)];
      ImGui::TableNextRow();
      ImGui::TableNextColumn();
      ImGui::PushID(i);
      if (ImGui::Selectable(one.date.empty() ? "–" : one.date.c_str(), i == s.session,
                            ImGuiSelectableFlags_SpanAllColumns))
        s.session = i;
      if (moved && i == s.session) ImGui::SetScrollHereY(0.5f);
      ImGui::PopID();
      ImGui::TableNextColumn();
      one_line(one.title.empty() ? one.scene : one.title, ImGui::GetContentRegionAvail().x);
      ImGui::TableNextColumn();
      one_line(one.trainee, ImGui::GetContentRegionAvail().x);
      ImGui::TableNextColumn();
      draw_known_score(s, one);
      ImGui::TableNextColumn();
      dim(one.recorded ? fmt::format("{} MB", s.number(one.megabytes, 1)) : s.text("op.saved_state"));
    }
    ImGui::EndTable();
  }
}

void draw_actions(OperatorState& s, InterfaceWindow& w, ImVec2 size) {
  const PagePanel panel("actions", s.text("op.of_session"), size, w);
  const bool any = s.session >= 0 && s.session < static_cast<int>(s.sessions.size());
  const bool course = any && s.sessions[static_cast<std::size_t>(s.session)].recorded;
  const bool can_course = course && !s.busy, can_any = any && !s.busy;
  const ImVec2 across{-1, 0};
  const ImVec2 half{0.5f * (ImGui::GetContentRegionAvail().x - ImGui::GetStyle().ItemSpacing.x), 0};
  ask_button(s, Ask::kSessionReport, s.text("op.open_report"), half, can_course);
  ImGui::SameLine();
  ask_button(s, Ask::kLearningCurve, s.text("op.learning_curve"), half, can_course);
  ask_button(s, Ask::kFilm, s.text("op.make_film"), across, can_course);
  ask_button(s, Ask::kWatch, s.text("op.watch"), across, can_course);
  ask_button(s, Ask::kExpert, s.text("op.make_expert"), across, can_course);
  constexpr std::array kFormats = {"STL", "PLY", "OBJ", "glTF"};
  const float format = 6 * w.style().unit;
  ask_button(s, Ask::kExportMesh, s.text("op.export_mesh"),
             {ImGui::GetContentRegionAvail().x - format - ImGui::GetStyle().ItemSpacing.x, 0}, can_any);
  ImGui::SameLine();
  choice("##format", s.mesh_format, kFormats, format);
  ask_button(s, Ask::kGoOnFrom, s.text("op.go_on_from"), half, can_any);
  ImGui::SameLine();
  if (ImGui::Button(s.text("op.open_folder"), half)) s.to_open.push_back(user_folder().string());
}

void draw_import_of_archive(OperatorState& s, InterfaceWindow& w, ImVec2 size) {
  const PagePanel panel("import", s.text("op.import"), size, w);
  note(s.text("op.import_help"), w);
  ImportForm& f = s.import;
  if (key('I', true)) ImGui::SetKeyboardFocusHere();
  const bool as_scanned = f.preset == kScannedSurface;
  file_field("file", s.text("op.import_file"), f.file, f.chooser,
             as_scanned ? haptics::mesh_endings() : tooth_extensions(), s, w);
  text_field("##name", s.text("op.import_name"), f.name);
  const float half = 0.5f * (ImGui::GetContentRegionAvail().x - ImGui::GetStyle().ItemSpacing.x);
  const std::array presets = {s.text("op.preset_tooth"), s.text("op.preset_arch"), s.text("op.preset_bone"),
                              s.text("op.preset_jaw"), s.text("op.preset_surface")};
  choice("##preset", f.preset, presets, half);
  ImGui::SameLine();
  const std::array crowns = {s.text("op.crown_up"),   s.text("op.crown_down"), s.text("op.crown_right"),
                             s.text("op.crown_left"), s.text("op.crown_back"), s.text("op.crown_front")};
  choice("##crown", f.crown, crowns, half);
  const auto length = [&](const char* id, float& mm, const char* name, const char* without) {
    ImGui::SetNextItemWidth(half);
    ImGui::InputFloat(id, &mm, 0, 0, mm > 0 ? fmt::format("{} %.4g mm", s.text(name)).c_str() : s.text(without),
                      ImGuiInputTextFlags_AutoSelectAll);
  };
  ImGui::BeginDisabled(as_scanned);  // these options apply only to a conversion to a volume
  length("##voxel", f.voxel_mm, "op.voxel", "op.voxel_of_file");
  ImGui::SameLine();
  length("##shell", f.shell_mm, "op.shell", "op.shell_usual");
  ImGui::EndDisabled();
  ImGui::SetNextItemWidth(half);
  unit_field(f.unit_mm);
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", s.text("op.unit_help"));
  ImGui::SameLine();
  ImGui::BeginDisabled(as_scanned);
  length("##spacing", f.spacing_mm, "op.spacing", "op.spacing_of_file");
  ImGui::SetNextItemWidth(half);
  const std::string series = f.series > 0 ? fmt::format("{} %d", s.text("op.series")) : s.text("op.series_only");
  ImGui::InputScalar("##series", ImGuiDataType_S32, &f.series, nullptr, nullptr, series.c_str(),
                     ImGuiInputTextFlags_AutoSelectAll);
  f.series = std::max(f.series, 0);
  ImGui::EndDisabled();
  ImGui::SameLine();
  ask_button(s, Ask::kLookAtScan, s.text("op.look_at_scan"), {-1, 0}, !s.busy && f.file[0] != 0 && !as_scanned);
  ask_button(s, Ask::kImport, s.text("op.import_do"), {-1, 0}, !s.busy && f.file[0] != 0 && f.name[0] != 0, true);
}

}  // namespace

void draw_archive_page(OperatorState& s, InterfaceWindow& w) {
  const float u = w.style().unit;
  const ImVec2 body = begin_titled_page(s.text("op.archive"), w), gap = ImGui::GetStyle().ItemSpacing;
  const float height = body.y, side = std::max(0.34f * body.x, 22 * u);
  draw_sessions(s, w, {body.x - side - gap.x, height});
  ImGui::SameLine();
  begin_column("side", {side, height});
  // Height of the panel with the session's buttons; leaves enough for the import form below without scrolling.
  const float actions = 15.1f * u;
  draw_actions(s, w, {0, actions});
  draw_import_of_archive(s, w, {0, height - actions - gap.y});
  ImGui::EndChild();
  end_titled_page(s, w);
}

}  // namespace typodont
