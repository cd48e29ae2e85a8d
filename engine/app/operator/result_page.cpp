// The page after a session: score with explanations, report, restart.
#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "engine/app/operator/widgets.h"
#include "engine/base/units.h"
#include "engine/display/keys.h"
#include "engine/session/score.h"
#include "haptics/import/import.h"

namespace typodont {

namespace {

using namespace widgets;
namespace keys = display::keys;

std::string target_text(const OperatorState& s, const session::ScoreItem& item) {
  const char* side = item.best == session::Best::kAtMost    ? "at_most"
                     : item.best == session::Best::kAtLeast ? "at_least"
                                                            : "near";
  return fmt::format(fmt::runtime(s.text(side)), session::quantity_text(item.target, item.unit, s.language));
}

void draw_items(OperatorState& s, InterfaceWindow& w, ImVec2 size) {
  const PagePanel panel("items", s.text("items"), size, w);
  const session::Score* score = s.outcome.result ? &s.outcome.result->score : nullptr;
  if (!score || score->items.empty()) {
    dim_wrapped(!score && s.busy ? "…" : s.text("op.no_score"));
  } else if (begin_table(
                 "items",
                 {{s.text("item"), 3}, {s.text("value"), 1.3f}, {s.text("target"), 1.3f}, {s.text("points"), 1}},
                 ImGuiTableFlags_BordersInnerH)) {
    for (const session::ScoreItem& item : score->items) {
      ImGui::TableNextRow();
      ImGui::TableNextColumn();
      ImGui::TextUnformatted(s.text(fmt::format("score.{}", item.name)));
      if (ImGui::IsItemHovered() && !item.source.empty()) ImGui::SetTooltip("%s", s.text(item.source));
      ImGui::TableNextColumn();
      ImGui::TextUnformatted(session::quantity_text(item.value, item.unit, s.language).c_str());
      ImGui::TableNextColumn();
      dim(item.full > 0 ? target_text(s, item) : s.text("not_counted"));
      ImGui::TableNextColumn();
      if (item.full > 0) {
        // Marks a missed item of the score with ✗, because colour-blind users may not see the colour.
        colored(
            fmt::format("{}{} / {}", score->missed(item) ? "✗ " : "", s.number(session::printed_points(item.points), 1),
                        s.number(session::printed_points(item.full), 1)),
            score_color(item.points / item.full, score->pass));
      } else {
        dim("–");
      }
    }
    ImGui::EndTable();
  }
}

/// Draws the fields of a rule: whether it counts, target, tolerance, weight.
void draw_rule(OperatorState& s, RuleChoice& rule) {
  ImGui::TableNextRow();
  ImGui::PushID(rule.name.c_str());
  ImGui::TableNextColumn();
  ImGui::Checkbox(s.text(fmt::format("score.{}", rule.name)), &rule.counts);
  const auto number = [](const char* id, float& value) {
    ImGui::SetNextItemWidth(-1);
    ImGui::InputFloat(id, &value, 0, 0, "%.4g");
  };
  ImGui::TableNextColumn();
  if (rule.counts) {
    const bool aims = s.exercise.aims();
    if (aims) {
      ImGui::Checkbox("##ideal", &rule.from_ideal);
      ImGui::SameLine();
    }
    if (rule.from_ideal && aims)
      dim(s.text("op.as_ideal"));
    else
      number("##target", rule.target);
  }
  ImGui::TableNextColumn();
  if (rule.counts) number("##tolerance", rule.tolerance);
  ImGui::TableNextColumn();
  if (rule.counts) number("##weight", rule.weight);
  ImGui::TableNextColumn();
  dim(std::string(session::unit_of(rule.name)));
  ImGui::PopID();
}

void draw_exercise_form(OperatorState& s, InterfaceWindow& w, ImVec2 size) {
  const float u = w.style().unit;
  ExerciseForm& f = s.exercise;
  const PagePanel panel("exercise", s.text("op.new_exercise"), size, w);
  dim_wrapped(s.text("op.new_exercise_help"));
  if (std::exchange(f.fresh, false)) ImGui::SetKeyboardFocusHere();
  text_field("##name", s.text("op.exercise_name"), f.name);
  heading(s.text("op.goal"), w);
  ImGui::InputTextMultiline("##goal", f.goal.data(), f.goal.size(), {-1, 3.2f * u});
  heading(s.text("op.steps_each_line"), w);
  ImGui::InputTextMultiline("##steps", f.steps.data(), f.steps.size(), {-1, 4.5f * u});
  heading(s.text("op.ideal"), w);
  const auto from = [&](const char* text, IdealFrom which) {
    if (ImGui::RadioButton(s.text(text), f.ideal == which)) f.ideal = which;
  };
  from("op.drilled_is_ideal", IdealFrom::kDrilled);
  ImGui::SameLine();
  from("op.ideal_of_base", IdealFrom::kBase);
  ImGui::SameLine();
  from("op.ideal_mesh", IdealFrom::kMesh);
  if (f.ideal == IdealFrom::kMesh) {
    file_field("mesh", s.text("op.ideal_mesh_file"), f.mesh, f.chooser, haptics::mesh_endings(), s, w);
    ImGui::SetNextItemWidth(12 * u);
    unit_field(f.mesh_unit_mm);
  }
  const ImVec2 room = ImGui::GetContentRegionAvail();
  const float button = ImGui::GetFrameHeightWithSpacing();
  if (begin_table("rules",
                  {{s.text("op.counts"), 3},
                   {s.text("target"), 1.5f},
                   {s.text("op.tolerance"), 0.9f},
                   {s.text("op.weight"), 0.9f},
                   {"", 0.5f}},
                  ImGuiTableFlags_ScrollY, {0, std::max(room.y - button - 0.5f * u, 6 * u)})) {
    ImGui::PushFont(w.style().small);
    for (RuleChoice& rule : f.rules) draw_rule(s, rule);
    ImGui::PopFont();
    ImGui::EndTable();
  }
  const bool can = !s.busy && f.name[0] != 0 && (f.ideal != IdealFrom::kMesh || f.mesh[0] != 0);
  ask_button(s, Ask::kSaveExercise, s.text("op.save_exercise"), {0, 0}, can, true);
}

void draw_result_picture(OperatorState& s, InterfaceWindow& w) {
  if (!s.outcome.result || s.result_pictures.empty()) return;
  const gpu::Image& picture = s.result_pictures.front();
  const ImVec2 room = ImGui::GetContentRegionAvail();
  const float caption = 1.4f * w.style().unit;
  const auto pixels = picture.options.size;
  const float aspect = static_cast<float>(pixels.width) / static_cast<float>(pixels.height);
  const float width = std::min(room.x, (room.y - caption) * aspect);
  if (width < 6 * w.style().unit) return;
  ImGui::Image(w.texture(picture), {width, width / aspect});
  ImGui::PushFont(w.style().small);
  const std::string what = s.outcome.result->compared
                               ? fmt::format("{}: {}", s.text("difference"), s.text("op.red_and_blue"))
                               : std::string(s.text("form"));
  one_line(what, room.x, kDim);
  ImGui::PopFont();
}

void draw_summary(OperatorState& s, InterfaceWindow& w, ImVec2 size) {
  const WorkbenchSummary& r = s.outcome.summary;
  const PagePanel panel("summary", s.text("result"), size, w);
  ImGui::PushFont(w.style().large);
  const session::Score none, &score = s.outcome.result ? s.outcome.result->score : none;
  if (!s.outcome.result && s.busy && !s.author) ImGui::TextUnformatted("…");
  if (score.full > 0)
    colored(s.words("points_of", s.number(session::printed_points(score.points), 1), s.number(score.full, 0)),
            score.passed() ? kGood : kBad);
  ImGui::PopFont();
  if (score.full > 0) {
    colored(s.text(score.passed() ? "passed" : "not_passed"), score.passed() ? kGood : kBad);
    for (const session::ScoreItem& item : score.items)
      if (item.critical) colored_wrapped(s.words("critical_error", s.text("score." + item.name)), kBad);
    note(s.words("pass_mark", s.number(score.pass.points, 0), s.text(score.pass.source)), w);
    const double percent = 100 * score.completion;
    row(s.text("completion"), fmt::format("{} %", s.number(session::printed_points(percent), percent < 100 ? 1 : 0)));
  }
  ImGui::Separator();
  row(s.text("duration"), fmt::format("{} s", s.number(r.seconds, 1)));
  double removed = 0;
  // Volume removed up to now, without undone strokes.
  for (const double v : s.status.tissue.removed) removed += v;
  row(s.text("volumes"), fmt::format("{} mm³", s.number(removed / kCubicMillimetre, 2)));
  row(s.text("op.servo_p999"), fmt::format("{} µs", s.number(r.tick_us_p999, 1)));
  row(s.text("op.missed"), fmt::format("{}", r.deadline_misses), r.deadline_misses ? &kWarn : nullptr);
  ImGui::Separator();
  if (!s.outcome.failure.empty()) colored_wrapped(s.outcome.failure, kBad);
  message(s.school.message);
  if (!s.outcome.recording.empty()) {
    note(s.outcome.recording.string(), w);
    if (!s.outcome.report.empty()) note(s.outcome.report.string(), w);
  }
  draw_result_picture(s, w);
}

void draw_checks(OperatorState& s, InterfaceWindow& w, ImVec2 size) {
  const PagePanel panel("findings", nullptr, size, w);
  busy_bar(s, 0.5f * ImGui::GetWindowWidth());
  if (!s.findings.empty() &&
      ImGui::BeginTable("findings", 3, ImGuiTableFlags_BordersInnerH | ImGuiTableFlags_SizingStretchProp)) {
    ImGui::TableSetupColumn("state", ImGuiTableColumnFlags_WidthFixed, 6 * w.style().unit);
    ImGui::TableSetupColumn("name", 0, 1);
    ImGui::TableSetupColumn("found", 0, 3);
    for (const DoctorFinding& f : s.findings) {
      ImGui::TableNextRow();
      ImGui::TableNextColumn();
      colored(s.text(fmt::format("op.state_{}", name_of(f.state))), severity_color(f.severity()));
      ImGui::TableNextColumn();
      wrapped(f.name);
      ImGui::TableNextColumn();
      wrapped(f.found);
      if (!f.without.empty()) dim_wrapped(f.without);
      if (!f.mend.empty()) dim_wrapped(fmt::format("{}: {}", s.text("op.mend"), f.mend));
    }
    ImGui::EndTable();
  }
}

}  // namespace

void draw_result_page(OperatorState& s, InterfaceWindow& w) {
  const float u = w.style().unit;
  begin_page(w);
  title(s.scene_title, w);
  const float foot = 3.2f * u;
  const ImVec2 room = ImGui::GetContentRegionAvail(), gap = ImGui::GetStyle().ItemSpacing;
  const float height = room.y - foot - 1.8f * u - 2 * gap.y, left = 0.32f * room.x;
  draw_summary(s, w, {left, height});
  ImGui::SameLine();
  if (s.author)
    draw_exercise_form(s, w, {0, height});
  else
    draw_items(s, w, {0, height});
  begin_column("message", {0, 1.8f * u});
  state_line(s, 0.5f * room.x);
  ImGui::EndChild();

  const ImVec2 button{0, foot - 0.4f * u};
  ask_button(s, Ask::kOpenReport, s.text("op.open_report"), button, !s.outcome.report.empty(), true);
  ImGui::SameLine();
  ask_button(s, Ask::kAgain, s.text("op.again"), button);
  ImGui::SameLine();
  if (!s.outcome.recording.empty()) {
    ask_button(s, Ask::kGoOnFrom, s.text("op.go_on_from"), button);
    ImGui::SameLine();
  }
  ask_button(s, Ask::kToStart, s.text("op.to_start"), button);
  if (!s.outcome.recording.empty()) {
    const char* text = s.text("op.delete_recording");
    ImGui::SameLine(ImGui::GetWindowWidth() - ImGui::CalcTextSize(text).x - 3 * u);
    if (ImGui::Button(text, button)) s.ask(Ask::kDeleteRecording);
  }
  page_shortcuts(s);
  end_page();
}

void draw_doctor_page(OperatorState& s, InterfaceWindow& w) {
  const float u = w.style().unit;
  begin_page(w);
  title(s.text("op.check_computer"), w);
  const float foot = 3.2f * u;
  const ImVec2 room = ImGui::GetContentRegionAvail();
  draw_checks(s, w, {0, room.y - foot - ImGui::GetStyle().ItemSpacing.y});
  ask_button(s, Ask::kToStart, s.text("op.to_start"), {0, foot - 0.4f * u});
  if (key(keys::kEscape)) s.ask(Ask::kToStart);
  page_shortcuts(s);
  end_page();
}

void draw_help(OperatorState& s, InterfaceWindow& w) {
  if (!s.help) return;
  const float u = w.style().unit;
  const char* title = s.text("op.keys");
  ImGui::OpenPopup(title);
  const display::ivec2 size = w.size();
  ImGui::SetNextWindowPos({static_cast<float>(size.x) / 2, static_cast<float>(size.y) / 2}, 0, {0.5f, 0.5f});
  if (ImGui::BeginPopupModal(title, &s.help, ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoSavedSettings)) {
    constexpr std::array kChoosing = {
        std::pair{"Ctrl ↑ ↓", "op.key_exercise"}, std::pair{"Ctrl D  H", "op.key_hand"},
        std::pair{"Ctrl P  M", "op.key_rig"},     std::pair{"Ctrl T  R", "op.key_trainee"},
        std::pair{"Ctrl E", "op.key_author"},     std::pair{"Ctrl L", "op.key_language"},
        std::pair{"Ctrl G", "op.key_model"},      std::pair{"Ctrl U", "op.key_question"},
        std::pair{"Tab  ← → ↑ ↓", "op.key_move"}, std::pair{"F1", "op.key_help"}};
    constexpr std::array kWorking = {std::pair{"Space  Esc", "op.key_stop"},   std::pair{"H  R", "op.key_hold"},
                                     std::pair{"1 … 9", "op.key_tools"},       std::pair{"+  −", "op.key_speed"},
                                     std::pair{"[  ]", "op.key_force"},        std::pair{"Ctrl Z  Y", "op.key_undo"},
                                     std::pair{"Ctrl R", "op.key_keep"},       std::pair{"N  B", "op.key_steps"},
                                     std::pair{"F C X D", "op.key_views"},     std::pair{",  .", "op.key_plane"},
                                     std::pair{"Ctrl 1 … 9", "op.key_shown"},  std::pair{"V", "op.key_own_view"},
                                     std::pair{"I J K L  U O", "op.key_turn"}, std::pair{"P", "op.key_paint"}};
    std::vector<std::pair<std::string, const char*>> left, right;
    for (const Shortcut& one : kShortcuts)
      if (one.does[0] != Ask::kSchool || s.school.set_up) left.emplace_back(one.name, one.help.data());
    for (const auto& [name, help] : kWorking) right.emplace_back(name, help);
    for (const auto& [name, help] : kChoosing) (left.size() <= right.size() ? left : right).emplace_back(name, help);
    for (std::size_t i = 0; i < std::max(left.size(), right.size()); ++i) {
      const auto put = [&](const std::pair<std::string, const char*>& one, float at) {
        ImGui::SetCursorPosX(at);
        ImGui::TextUnformatted(s.keys(one.first).c_str());
        ImGui::SameLine(at + 8 * u);
        dim(s.text(one.second));
      };
      if (i < left.size()) put(left[i], u);
      if (i < left.size() && i < right.size()) ImGui::SameLine();
      if (i < right.size()) put(right[i], 31 * u);
      ImGui::SameLine();
      ImGui::Dummy({u, 0});
    }
    ImGui::Spacing();
    dim_wrapped(s.text("op.mouse_help"));
    ImGui::Spacing();
    if (ImGui::Button(s.text("op.close"), {9 * u, 0}) || ImGui::IsKeyPressed(keys::kEscape, false)) s.help = false;
    ImGui::SetItemDefaultFocus();
    if (!s.help) ImGui::CloseCurrentPopup();
    ImGui::EndPopup();
  }
}

void draw_leaving(OperatorState& s, InterfaceWindow& w) {
  if (!s.leaving) return;
  const float u = w.style().unit;
  const char* title = s.text("op.unsaved_title");
  ImGui::OpenPopup(title);
  const display::ivec2 size = w.size();
  ImGui::SetNextWindowPos({static_cast<float>(size.x) / 2, static_cast<float>(size.y) / 2}, 0, {0.5f, 0.5f});
  ImGui::SetNextWindowSize({34 * u, 0});
  if (!ImGui::BeginPopupModal(title, nullptr, ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoSavedSettings)) return;
  wrapped(s.text("op.unsaved"));
  ImGui::Spacing();
  const auto answer = [&](Ask ask) {
    s.ask(ask);
    ImGui::CloseCurrentPopup();
  };
  const auto button = [&](const char* text, Ask ask, bool main) {
    const std::string label = fmt::format("  {}  ", s.text(text));
    const bool clicked = main ? main_button(label.c_str(), {0, 0}) : ImGui::Button(label.c_str());
    if (main) ImGui::SetItemDefaultFocus();
    const bool entered = ImGui::IsKeyPressed(keys::kEnter, false) || ImGui::IsKeyPressed(keys::kKeypadEnter, false);
    if (clicked || (ImGui::IsItemFocused() && entered)) answer(ask);
  };
  button("op.unsaved_keep", Ask::kLeaveKept, true);
  ImGui::SameLine();
  button("op.unsaved_drop", Ask::kLeaveDropped, false);
  ImGui::SameLine();
  button("op.unsaved_stay", Ask::kStay, false);
  if (ImGui::IsKeyPressed(keys::kEscape, false)) answer(Ask::kStay);
  ImGui::EndPopup();
}

}  // namespace typodont
