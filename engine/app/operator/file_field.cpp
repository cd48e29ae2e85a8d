#include "engine/app/operator/file_field.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>

#include "engine/app/operator/widgets.h"
#include "engine/base/lower_case.h"
#include "engine/display/keys.h"
#include "haptics/import/import.h"

namespace typodont {

namespace fs = std::filesystem;

void list_folder(FileChooser& chooser, const fs::path& folder, std::span<const std::string> endings) {
  chooser.folder = folder;
  chooser.folders.clear();
  chooser.files.clear();
  std::error_code code;
  for (auto entry = fs::directory_iterator(folder, fs::directory_options::skip_permission_denied, code);
       !code && entry != fs::directory_iterator(); entry.increment(code)) {
    const fs::path name = entry->path().filename();
    if (name.string().starts_with(".")) continue;
    const std::string lower = lower_case(name.string());
    std::error_code unknown;
    if (entry->is_directory(unknown))
      chooser.folders.push_back(name);
    else if (std::any_of(endings.begin(), endings.end(), [&](const std::string& e) { return lower.ends_with(e); }))
      chooser.files.push_back(name);
  }
  std::sort(chooser.folders.begin(), chooser.folders.end());
  std::sort(chooser.files.begin(), chooser.files.end());
}

const std::vector<std::string>& tooth_extensions() {
  static const std::vector<std::string> all = [] {
    std::vector<std::string> endings = haptics::mesh_endings();
    endings.insert(endings.end(), haptics::scan_endings().begin(), haptics::scan_endings().end());
    return endings;
  }();
  return all;
}

namespace widgets {

namespace {

/// Folder of the typed path, or else the home folder.
fs::path begin_at(const char* typed) {
  std::error_code code;
  const fs::path path = fs::absolute(typed, code);
  if (typed[0] && fs::is_directory(path, code)) return path;
  if (typed[0] && fs::is_directory(path.parent_path(), code)) return path.parent_path();
  const char* home = std::getenv("HOME");
  return home && *home ? home : "/";
}

/// Draws a line of the list. True if the user selects it by mouse, Space or Enter.
bool line(const std::string& name) {
  const bool clicked = ImGui::Selectable(name.c_str());
  return clicked || (ImGui::IsItemFocused() && ImGui::IsKeyPressed(display::keys::kEnter, false));
}

}  // namespace

void file_field(const char* id, const char* hint, std::span<char> text, FileChooser& chooser,
                std::span<const std::string> endings, OperatorState& s, InterfaceWindow& w) {
  const float u = w.style().unit;
  const std::string list = s.text("op.list_files");
  ImGui::PushID(id);
  ImGui::SetNextItemWidth(ImGui::GetContentRegionAvail().x - ImGui::CalcTextSize(list.c_str()).x -
                          2 * ImGui::GetStyle().FramePadding.x - ImGui::GetStyle().ItemSpacing.x);
  ImGui::InputTextWithHint("##path", hint, text.data(), text.size());
  ImGui::SameLine();
  if (ImGui::Button(list.c_str()) || key('O', true)) {
    list_folder(chooser, begin_at(text.data()), endings);
    chooser.asked = true;
  }
  // Each folder gets a new popup name, because ImGui selects the first line only in a new popup.
  if (std::exchange(chooser.asked, false)) ImGui::OpenPopup(fmt::format("list{}", ++chooser.opened).c_str());
  ImGui::SetNextWindowSize({34 * u, 24 * u});
  if (ImGui::BeginPopup(fmt::format("list{}", chooser.opened).c_str())) {
    fs::path into, picked;
    heading(chooser.folder.c_str(), w);
    if (chooser.folder.has_relative_path() && line("..")) into = chooser.folder.parent_path();
    ImGui::SetItemDefaultFocus();
    for (const fs::path& name : chooser.folders)
      if (line(name.string() + "/")) into = chooser.folder / name;
    for (const fs::path& name : chooser.files)
      if (line(name.string())) picked = chooser.folder / name;
    if (chooser.folders.empty() && chooser.files.empty()) dim_wrapped(s.text("op.no_files"));
    if (!into.empty()) {
      list_folder(chooser, into, endings);
      chooser.asked = true;
    }
    if (!picked.empty() && picked.string().size() < text.size()) {
      std::fill(text.begin(), text.end(), '\0');
      picked.string().copy(text.data(), text.size() - 1);
    }
    if (!into.empty() || !picked.empty()) ImGui::CloseCurrentPopup();
    ImGui::EndPopup();
  }
  ImGui::PopID();
}

void unit_field(float& unit_mm) {
  ImGui::InputFloat("##unit", &unit_mm, 0, 0, "1 = %.4g mm");
  unit_mm = std::clamp(unit_mm, 1e-6f, 1e6f);
}

}  // namespace widgets

}  // namespace typodont
