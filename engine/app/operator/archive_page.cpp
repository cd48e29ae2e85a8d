// Recorded sessions and what can be made of them; teeth from scans and meshes.
#include <fmt/format.h>

#include "engine/app/operator/widgets.h"
#include "engine/display/keys.h"

namespace typodont {

namespace {

using namespace widgets;
namespace keys = display::keys;

void draw_sessions(OperatorState& s, InterfaceWindow& w, ImVec2 size) {
  begin_panel("sessions", s.text("op.sessions"), size, w);
  const int count = static_cast<int>(s.sessions.size());
  const int step = (ImGui::IsKeyPressed(keys::kDown) ? 1 : 0) - (ImGui::IsKeyPressed(keys::kUp) ? 1 : 0);
  bool moved = false;
  if (ImGui::GetIO().KeyCtrl && step != 0 && count > 0) {
    s.session = (s.session + step + count) % count;
    moved = true;
  }
  if (s.sessions.empty()) dim_wrapped(s.text("op.no_sessions"));
  if (count > 0 && ImGui::BeginTable("sessions", 4, ImGuiTableFlags_RowBg | ImGuiTableFlags_SizingStretchProp)) {
    ImGui::TableSetupColumn("date", 0, 1.3f);
    ImGui::TableSetupColumn("scene", 0, 1.6f);
    ImGui::TableSetupColumn("trainee", 0, 1);
    ImGui::TableSetupColumn("size", 0, 0.7f);
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
      ImGui::TextUnformatted(one.scene.c_str());
      ImGui::TableNextColumn();
      ImGui::TextUnformatted(one.trainee.c_str());
      ImGui::TableNextColumn();
      dim(one.recorded ? fmt::format("{:.1f} MB", one.megabytes) : s.text("op.saved_state"));
    }
    ImGui::EndTable();
  }
  end_panel();
}

/// A button across the panel, and its key.
bool action(const char* text, const char* name, int code) {
  return ImGui::Button(fmt::format("{}   {}", text, name).c_str(), {-1, 0}) || key(code);
}

void draw_actions(OperatorState& s, InterfaceWindow& w, ImVec2 size) {
  begin_panel("actions", s.text("op.of_session"), size, w);
  const bool any = s.session >= 0 && s.session < static_cast<int>(s.sessions.size());
  const bool course = any && s.sessions[static_cast<std::size_t>(s.session)].recorded;
  ImGui::BeginDisabled(!course || s.busy);
  const bool report = action(s.text("op.open_report"), "F2", keys::kF1 + 1);
  const bool curve = action(s.text("op.learning_curve"), "F3", keys::kF1 + 2);
  const bool film = action(s.text("op.make_film"), "F4", keys::kF1 + 3);
  const bool watch = action(s.text("op.watch"), "F6", keys::kF1 + 5);
  const bool expert = action(s.text("op.make_expert"), "F8", keys::kF1 + 7);
  ImGui::EndDisabled();
  ImGui::BeginDisabled(!any || s.busy);
  constexpr std::array kFormats = {"STL", "PLY", "OBJ"};
  const float format = 6 * w.style().unit;
  const bool mesh = ImGui::Button(fmt::format("{}   F7", s.text("op.export_mesh")).c_str(),
                                  {ImGui::GetContentRegionAvail().x - format - ImGui::GetStyle().ItemSpacing.x, 0}) ||
                    key(keys::kF1 + 6);
  ImGui::SameLine();
  ImGui::SetNextItemWidth(format);
  ImGui::Combo("##format", &s.mesh_format, kFormats.data(), static_cast<int>(kFormats.size()));
  const bool go_on = action(s.text("op.go_on_from"), "F5", keys::kF1 + 4);
  ImGui::EndDisabled();
  if (course && !s.busy) {
    if (report) s.ask(Ask::kSessionReport);
    if (curve) s.ask(Ask::kLearningCurve);
    if (film) s.ask(Ask::kFilm);
    if (watch) s.ask(Ask::kWatch);
    if (expert) s.ask(Ask::kExpert);
  }
  if (any && !s.busy) {
    if (mesh) s.ask(Ask::kExportMesh);
    if (go_on) s.ask(Ask::kGoOnFrom);
  }
  if (ImGui::Button(s.text("op.open_folder"), {-1, 0})) s.ask(Ask::kOpenFolder);
  end_panel();
}

void draw_import(OperatorState& s, InterfaceWindow& w, ImVec2 size) {
  begin_panel("import", s.text("op.import"), size, w);
  ImGui::PushFont(w.style().small);
  dim_wrapped(s.text("op.import_help"));
  ImGui::PopFont();
  ImportForm& f = s.import;
  if (key('I', true)) ImGui::SetKeyboardFocusHere();
  file_field("file", s.text("op.import_file"), f.file, f.chooser, tooth_endings(), s, w);
  ImGui::SetNextItemWidth(-1);
  ImGui::InputTextWithHint("##name", s.text("op.import_name"), f.name.data(), f.name.size());
  const float half = 0.5f * (ImGui::GetContentRegionAvail().x - ImGui::GetStyle().ItemSpacing.x);
  const std::array presets = {s.text("op.preset_tooth"), s.text("op.preset_bone")};
  ImGui::SetNextItemWidth(half);
  ImGui::Combo("##preset", &f.preset, presets.data(), static_cast<int>(presets.size()));
  ImGui::SameLine();
  const std::array crowns = {s.text("op.crown_up"),   s.text("op.crown_down"), s.text("op.crown_right"),
                             s.text("op.crown_left"), s.text("op.crown_back"), s.text("op.crown_front")};
  ImGui::SetNextItemWidth(half);
  ImGui::Combo("##crown", &f.crown, crowns.data(), static_cast<int>(crowns.size()));
  const auto length = [&](const char* id, float& mm, const char* name, const char* without) {
    ImGui::SetNextItemWidth(half);
    ImGui::InputFloat(id, &mm, 0, 0, mm > 0 ? fmt::format("{} %.4g mm", s.text(name)).c_str() : s.text(without),
                      ImGuiInputTextFlags_AutoSelectAll);
  };
  length("##voxel", f.voxel_mm, "op.voxel", "op.voxel_of_file");
  ImGui::SameLine();
  length("##shell", f.shell_mm, "op.shell", "op.shell_usual");
  ImGui::SetNextItemWidth(half);
  unit_field(f.unit_mm);
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", s.text("op.unit_help"));
  ImGui::SameLine();
  length("##spacing", f.spacing_mm, "op.spacing", "op.spacing_of_file");
  ImGui::BeginDisabled(s.busy || f.file[0] == 0 || f.name[0] == 0);
  const bool pressed = main_button(fmt::format("{}   F9", s.text("op.import_do")).c_str(), {-1, 0});
  ImGui::EndDisabled();
  if ((pressed || ImGui::IsKeyPressed(keys::kF1 + 8, false)) && !s.busy && f.file[0] != 0 && f.name[0] != 0)
    s.ask(Ask::kImport);
  end_panel();
}

}  // namespace

void draw_archive_page(OperatorState& s, InterfaceWindow& w) {
  const float u = w.style().unit;
  begin_page(w);
  ImGui::PushFont(w.style().large);
  ImGui::TextUnformatted(s.text("op.archive"));
  ImGui::PopFont();
  const float foot = 3.2f * u;
  const ImVec2 room = ImGui::GetContentRegionAvail(), gap = ImGui::GetStyle().ItemSpacing;
  const float height = room.y - foot - 2.2f * u - 2 * gap.y, side = std::max(0.34f * room.x, 22 * u);
  draw_sessions(s, w, {room.x - side - gap.x, height});
  ImGui::SameLine();
  begin_column("side", {side, height});
  const float actions = 21.5f * u;
  draw_actions(s, w, {0, actions});
  draw_import(s, w, {0, height - actions - gap.y});
  ImGui::EndChild();
  begin_column("message", {0, 2.2f * u});
  if (s.busy)
    busy_bar(s, 0.5f * room.x);
  else
    message_line(s);
  ImGui::EndChild();
  if (ImGui::Button(fmt::format("  {}   F10  ", s.text("op.to_start")).c_str(), {0, foot - 0.4f * u}) ||
      key(keys::kF1 + 9))
    s.ask(Ask::kToStart);
  if (s.busy && ImGui::IsKeyPressed(keys::kEscape, false)) s.ask(Ask::kCancel);
  if (key(keys::kF1)) s.help = true;
  if (key('Q', true)) s.ask(Ask::kQuit);
  end_page();
}

}  // namespace typodont
