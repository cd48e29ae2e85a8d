#include "engine/app/operator/session_controls.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "engine/base/units.h"
#include "engine/display/keys.h"

namespace typodont {

using namespace widgets;
namespace keys = display::keys;

namespace {

std::string clock_text(double seconds) {
  const int whole = static_cast<int>(std::max(seconds, 0.0));
  return fmt::format("{}:{:02}", whole / 60, whole % 60);
}

}  // namespace

int Flow::lines(float width) const {
  int lines = 1;
  float x = 0;
  for (const Item& item : items_) place(item, width, x, lines);
  return lines;
}

int Flow::draw(float width) const {
  int pressed = -1, line = 1;
  float x = 0;
  for (std::size_t i = 0; i < items_.size(); ++i) {
    const int before = line;
    place(items_[i], width, x, line);
    if (i > 0 && line == before) ImGui::SameLine();
    ImGui::PushID(static_cast<int>(i));
    if (items_[i].lead) {
      ImGui::AlignTextToFramePadding();
      dim(items_[i].label);
    } else {
      ImGui::BeginDisabled(!items_[i].enabled);
      if (toggle_button(items_[i].label.c_str(), items_[i].on, {0, 0})) pressed = static_cast<int>(i);
      ImGui::EndDisabled();
    }
    ImGui::PopID();
  }
  return pressed;
}

void Flow::place(const Item& item, float width, float& x, int& line) {
  const ImGuiStyle& style = ImGui::GetStyle();
  const float wide = ImGui::CalcTextSize(item.label.c_str()).x + (item.lead ? 0 : 2 * style.FramePadding.x);
  if (x > 0 && x + style.ItemSpacing.x + wide > width) {
    x = 0;
    ++line;
  }
  x += (x > 0 ? style.ItemSpacing.x : 0) + wide;
}

SessionControls::SessionControls(OperatorState& s, InterfaceWindow& w, float width)
    : s_(s),
      w_(w),
      width_(width - 2 * ImGui::GetStyle().WindowPadding.x),
      session_(session_items()),
      views_(view_items()),
      shown_(shown_items()) {}

float SessionControls::height() const {
  ImGui::PushFont(w_.style().small);
  // Reserves all lines, so that the picture keeps its size. With temperatures, section plane and legend need two lines.
  const int lines = views_.lines(width_) + std::max(shown_.lines(width_), s_.has_heat ? 2 : 1);
  const float small = ImGui::GetFrameHeightWithSpacing();
  ImGui::PopFont();
  return 2 * ImGui::GetStyle().WindowPadding.y + first_line() +
         static_cast<float>(session_.lines(width_) - 1) * ImGui::GetFrameHeightWithSpacing() +
         (possible() ? static_cast<float>(lines) * small : 0);
}

void SessionControls::draw() {
  begin_panel("deck", nullptr, {0, height()}, w_);
  draw_clock();
  act(session_.draw(width_));
  if (possible()) {
    ImGui::PushFont(w_.style().small);
    look(views_.draw(width_));
    if (render::cuts_section(s_.look.view)) draw_plane();
    if (s_.look.view == render::View::kTemperature) dim(s_.text("hud.temperature"));
    if (s_.look.view == render::View::kLook) show(shown_.draw(width_));
    ImGui::PopFont();
  }
  keys();
  end_panel();
}

bool SessionControls::possible() const {
  return s_.trainee_seen || s_.own_view || s_.own_possible;
}

float SessionControls::first_line() const {
  return 2 * ImGui::GetFrameHeightWithSpacing() - ImGui::GetStyle().ItemSpacing.y;
}

void SessionControls::draw_clock() {
  const float u = w_.style().unit;
  title(clock_text(s_.status.seconds), w_);
  ImGui::SameLine(0, 1.5f * u);
  ImGui::AlignTextToFramePadding();
  if (s_.recording && s_.keep) {
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const RecordState& record = s_.status.record;
    const bool good = record.complete && !record.disk_low && !record.failed;
    ImGui::GetWindowDrawList()->AddCircleFilled({at.x + 0.4f * u, at.y + 0.85f * u}, 0.32f * u,
                                                ImGui::GetColorU32(good ? kBad : kWarn));
    ImGui::Dummy({0.9f * u, u});
    ImGui::SameLine();
    ImGui::AlignTextToFramePadding();
    const bool gaps = !record.complete || record.failed;
    ImGui::TextUnformatted(s_.text(gaps ? "op.recording_incomplete" : good ? "op.recording" : "op.disk_low"));
  } else {
    dim(s_.text(s_.recording ? "op.not_kept" : "op.not_recording"));
  }
  if (!s_.message.empty()) {
    ImGui::SameLine(0, 1.5f * u);
    ImGui::PushStyleColor(ImGuiCol_Text, s_.message_is_error ? kBad : kGood);
    const std::string end = end_label();
    one_line(s_.message, width_ - ImGui::GetCursorPosX() - ImGui::CalcTextSize(end.c_str()).x - 2 * u);
    ImGui::PopStyleColor();
  }
  const std::string end = end_label();
  const float wide = ImGui::CalcTextSize(end.c_str()).x + 2 * ImGui::GetStyle().FramePadding.x;
  ImGui::SameLine(ImGui::GetWindowWidth() - wide - ImGui::GetStyle().WindowPadding.x);
  if (ImGui::Button(end.c_str()) || pressed(shortcut(Ask::kEndSession))) s_.ask(Ask::kEndSession);
}

std::string SessionControls::end_label() const {
  return fmt::format("{}   {}", s_.text("op.end_session"), shortcut(Ask::kEndSession).name);
}

std::vector<Flow::Item> SessionControls::session_items() const {
  const auto& strokes = s_.status.tissue.strokes;
  return {
      {fmt::format("{} ({})   {}", s_.text("op.undo"), strokes.done, s_.keys("Ctrl+Z")), false, strokes.done > 0},
      {fmt::format("{} ({})   {}", s_.text("op.redo"), strokes.undone, s_.keys("Ctrl+Y")), false, strokes.undone > 0},
      {fmt::format("{}   {}", s_.text(s_.held ? "op.go_on" : "op.hold"), s_.held ? "R" : "H"), s_.held},
      {fmt::format("{}   {}", s_.text("op.record"), s_.keys("Ctrl+R")), s_.recording && s_.keep, s_.recording},
      {fmt::format("{}   {}", s_.text("op.save_tissue"), s_.keys(std::string(shortcut(Ask::kSaveTissue).name)))}};
}

void SessionControls::act(int pressed) {
  if (pressed == 0) s_.ask(Ask::kUndo);
  if (pressed == 1) s_.ask(Ask::kRedo);
  if (pressed == 2) s_.ask(Ask::kHold, s_.held ? 0 : 1);
  if (pressed == 3) s_.ask(Ask::kKeep, s_.keep ? 0 : 1);
  if (pressed == 4) s_.ask(Ask::kSaveTissue);
}

std::vector<Flow::Item> SessionControls::view_items() const {
  const auto label = [&](const char* name, const char* letter) { return fmt::format("{}  {}", s_.text(name), letter); };
  return {
      {label("op.own_view", "V"), s_.own_view, s_.own_possible && (s_.trainee_seen || !s_.own_view)},
      {label("op.view_look", "F"), s_.look.view == render::View::kLook},
      {label("op.view_section", "C"), s_.look.view == render::View::kSection},
      {label("op.view_xray", "X"), s_.look.view == render::View::kXray},
      {label("op.view_difference", "D"), s_.look.view == render::View::kDifference, can_see(render::View::kDifference)},
      {label("op.view_temperature", "G"), s_.look.view == render::View::kTemperature,
       can_see(render::View::kTemperature)}};
}

void SessionControls::look(int pressed) {
  if (pressed == 0) s_.ask(Ask::kOwnView, s_.own_view ? 0 : 1);
  if (pressed > 0) see(kViews[static_cast<std::size_t>(pressed - 1)]);
}

bool SessionControls::can_see(render::View view) const {
  return view == render::View::kDifference ? s_.has_ideal : view != render::View::kTemperature || s_.has_heat;
}

void SessionControls::see(render::View view) {
  if (s_.look.view == view || !can_see(view)) return;
  s_.look.view = view;
  s_.ask(Ask::kLook);
}

void SessionControls::draw_plane() {
  constexpr std::array kAxes = {"x", "y", "z"};
  ImGui::AlignTextToFramePadding();
  dim(s_.text("op.section_across"));
  bool changed = false;
  for (int axis = 0; axis < 3; ++axis) {
    ImGui::SameLine();
    if (toggle_button(kAxes[static_cast<std::size_t>(axis)], s_.look.section_axis == axis, {0, 0})) {
      s_.look.section_axis = axis;
      changed = true;
    }
  }
  ImGui::SameLine();
  auto at = static_cast<float>(s_.look.section / kMillimetre);
  if (slider(s_, "##section", at, -12, 12, "", 1, " mm   ,  .")) {
    s_.look.section = static_cast<double>(at) * kMillimetre;
    changed = true;
  }
  if (changed) s_.ask(Ask::kLook);
}

std::vector<SessionControls::Shown> SessionControls::shown() const {
  std::vector<Shown> list;
  for (std::size_t i = 1; i < kTissueCount; ++i)
    if (s_.tissues >> i & 1u)
      list.push_back({s_.text(fmt::format("tissue.{}", name_of(static_cast<Tissue>(i)))), static_cast<Tissue>(i)});
  if (s_.has_surroundings) list.push_back({s_.text("op.surroundings"), Tissue::kAir, &Look::surroundings});
  list.push_back({s_.text("op.tool"), Tissue::kAir, &Look::tool});
  if (s_.has_debris) list.push_back({s_.text("op.debris"), Tissue::kAir, &Look::debris});
  if (s_.has_mirror) list.push_back({s_.text("op.mouth_mirror"), Tissue::kAir, &Look::mirror});
  return list;
}

std::vector<Flow::Item> SessionControls::shown_items() const {
  std::vector<Flow::Item> items{{s_.text("op.shown"), false, true, true}};
  for (const Shown& one : shown())
    items.push_back({one.name, one.flag ? s_.look.*one.flag : !s_.look.hides(one.tissue)});
  return items;
}

void SessionControls::show(int pressed) {
  if (pressed < 1) return;
  const Shown one = shown()[static_cast<std::size_t>(pressed - 1)];
  if (one.flag)
    s_.look.*one.flag = !(s_.look.*one.flag);
  else
    s_.look.hidden ^= 1u << static_cast<unsigned>(one.tissue);
  s_.ask(Ask::kLook);
}

void SessionControls::keys() {
  if (key('Z', true) || key('Z')) s_.ask(Ask::kUndo);
  if (key('Y', true) || key('Y')) s_.ask(Ask::kRedo);
  if (pressed(shortcut(Ask::kSaveTissue))) s_.ask(Ask::kSaveTissue);
  if (key('R', true) && s_.recording) s_.ask(Ask::kKeep, s_.keep ? 0 : 1);
  if (!s_.held && key('H')) s_.ask(Ask::kHold, 1);
  if (s_.held && key('R')) s_.ask(Ask::kHold, 0);
  if (!possible()) return;
  if (key('V') && s_.own_possible && s_.trainee_seen) s_.ask(Ask::kOwnView, s_.own_view ? 0 : 1);
  if (key('F')) see(render::View::kLook);
  if (key('C')) see(render::View::kSection);
  if (key('X')) see(render::View::kXray);
  if (key('D')) see(render::View::kDifference);
  if (key('G')) see(render::View::kTemperature);
  if (s_.look.view == render::View::kLook) {
    const int count = static_cast<int>(shown().size());
    for (int i = 0; i < std::min(count, 9); ++i)
      if (key('1' + i, true)) show(i + 1);
  }
  const int step = typed(".") - typed(",");
  if (step != 0 && render::cuts_section(s_.look.view)) {
    s_.look.section = std::clamp(s_.look.section + step * 0.25e-3, -12e-3, 12e-3);
    s_.ask(Ask::kLook);
  }
}

}  // namespace typodont
