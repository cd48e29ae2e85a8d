#include "engine/app/operator/session_controls.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

#include "engine/base/units.h"

namespace typodont {

using namespace widgets;

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

void Flow::draw(float width) const {
  int line = 1;
  float x = 0;
  for (std::size_t i = 0; i < items_.size(); ++i) {
    const Item& item = items_[i];
    const int before = line;
    place(item, width, x, line);
    if (i > 0 && line == before) ImGui::SameLine();
    ImGui::PushID(static_cast<int>(i));
    if (!item.act) {
      ImGui::AlignTextToFramePadding();
      dim(item.label);
    } else {
      ImGui::BeginDisabled(!item.enabled);
      if (toggle_button(item.label.c_str(), item.on, {0, 0}) || item.key) item.act();
      ImGui::EndDisabled();
    }
    ImGui::PopID();
  }
}

void Flow::place(const Item& item, float width, float& x, int& line) {
  const ImGuiStyle& style = ImGui::GetStyle();
  const float wide = ImGui::CalcTextSize(item.label.c_str()).x + (item.act ? 2 * style.FramePadding.x : 0);
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
  return 2 * ImGui::GetStyle().WindowPadding.y - ImGui::GetStyle().ItemSpacing.y +
         static_cast<float>(session_.lines(width_) + 1) * ImGui::GetFrameHeightWithSpacing() +
         (possible() ? static_cast<float>(lines) * small : 0);
}

void SessionControls::draw() {
  const PagePanel panel("deck", nullptr, {0, height()}, w_);
  draw_clock();
  session_.draw(width_);
  if (possible()) {
    ImGui::PushFont(w_.style().small);
    views_.draw(width_);
    if (render::cuts_section(s_.look.view)) draw_plane();
    if (s_.look.view == render::View::kTemperature) dim(s_.text("hud.temperature"));
    if (s_.look.view == render::View::kLook) shown_.draw(width_);
    ImGui::PopFont();
  }
}

bool SessionControls::possible() const {
  return s_.trainee_seen || s_.own_view || s_.own_possible;
}

void SessionControls::draw_clock() {
  const float u = w_.style().unit;
  const std::string end = fmt::format("{}   {}", s_.text("op.end_session"), shortcut(Ask::kEndSession).name);
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
  if (!s_.message.text.empty()) {
    ImGui::SameLine(0, 1.5f * u);
    one_line(s_.message.text, width_ - ImGui::GetCursorPosX() - ImGui::CalcTextSize(end.c_str()).x - 2 * u,
             s_.message.is_error ? kBad : kGood);
  }
  const float wide = ImGui::CalcTextSize(end.c_str()).x + 2 * ImGui::GetStyle().FramePadding.x;
  ImGui::SameLine(ImGui::GetWindowWidth() - wide - ImGui::GetStyle().WindowPadding.x);
  if (ImGui::Button(end.c_str()) || pressed(shortcut(Ask::kEndSession))) s_.ask(Ask::kEndSession);
}

std::vector<Flow::Item> SessionControls::session_items() {
  const auto& strokes = s_.status.tissue.strokes;
  const auto ask = [this](Ask what, int number = 0) { return [this, what, number] { s_.ask(what, number); }; };
  const auto label = [&](const char* name, const std::string& keys) {
    return fmt::format("{}   {}", s_.text(name), s_.keys(keys));
  };
  const auto counted = [&](const char* name, auto count, const char* keys) {
    return fmt::format("{} ({})   {}", s_.text(name), count, s_.keys(keys));
  };
  // The keys for undo and redo work even if the counts are not up to date yet.
  return {{counted("op.undo", strokes.done, "Ctrl+Z"), false, strokes.done > 0, key('Z', true) || key('Z'),
           ask(Ask::kUndo)},
          {counted("op.redo", strokes.undone, "Ctrl+Y"), false, strokes.undone > 0, key('Y', true) || key('Y'),
           ask(Ask::kRedo)},
          {label(s_.held ? "op.go_on" : "op.hold", s_.held ? "R" : "H"), s_.held, true, key(s_.held ? 'R' : 'H'),
           ask(Ask::kHold, s_.held ? 0 : 1)},
          {label("op.record", "Ctrl+R"), s_.recording && s_.keep, s_.recording, s_.recording && key('R', true),
           [this] { s_.keep = !s_.keep; }},
          {label("op.save_tissue", std::string(shortcut(Ask::kSaveTissue).name)), false, true,
           pressed(shortcut(Ask::kSaveTissue)), ask(Ask::kSaveTissue)}};
}

std::vector<Flow::Item> SessionControls::view_items() {
  const auto label = [&](const char* name, char letter) { return fmt::format("{}  {}", s_.text(name), letter); };
  const auto view = [&](const char* name, char letter, render::View kind, bool possible = true) {
    return Flow::Item{label(name, letter), s_.look.view == kind, possible, possible && key(letter), [this, kind] {
                        if (std::exchange(s_.look.view, kind) != kind) s_.ask(Ask::kLook);
                      }};
  };
  return {{label("op.own_view", 'V'), s_.own_view, s_.own_possible && (s_.trainee_seen || !s_.own_view),
           key('V') && s_.own_possible && s_.trainee_seen, [this] { s_.ask(Ask::kOwnView, s_.own_view ? 0 : 1); }},
          view("op.view_look", 'F', render::View::kLook),
          view("op.view_section", 'C', render::View::kSection),
          view("op.view_xray", 'X', render::View::kXray),
          view("op.view_difference", 'D', render::View::kDifference, s_.has_ideal),
          view("op.view_temperature", 'G', render::View::kTemperature, s_.has_heat)};
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
  if (const int step = typed(".") - typed(","); step != 0) {
    s_.look.section = std::clamp(s_.look.section + step * 0.25e-3, -12e-3, 12e-3);
    changed = true;
  }
  if (changed) s_.ask(Ask::kLook);
}

std::vector<Flow::Item> SessionControls::shown_items() {
  std::vector<Flow::Item> items{Flow::Item{s_.text("op.shown")}};
  const auto add = [&](const char* name, bool shown, const std::function<void(Look&)>& toggle) {
    const int number = static_cast<int>(items.size());
    items.push_back({s_.text(name), shown, true, number <= 9 && key('0' + number, true), [this, toggle] {
                       toggle(s_.look);
                       s_.ask(Ask::kLook);
                     }});
  };
  const auto add_part = [&](const char* name, bool Look::*part) {
    add(name, s_.look.*part, [part](Look& look) { look.*part = !(look.*part); });
  };
  for (unsigned i = 1; i < kTissueCount; ++i)
    if (s_.tissues >> i & 1u)
      add(fmt::format("tissue.{}", name_of(static_cast<Tissue>(i))).c_str(), !s_.look.hides(static_cast<Tissue>(i)),
          [i](Look& look) { look.hidden ^= 1u << i; });
  if (s_.has_surroundings) add_part("op.surroundings", &Look::surroundings);
  add_part("op.tool", &Look::tool);
  if (s_.has_debris) add_part("op.debris", &Look::debris);
  if (s_.has_mirror) add_part("op.mouth_mirror", &Look::mirror);
  return items;
}

}  // namespace typodont
