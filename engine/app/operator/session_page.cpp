// The page that the instructor sees during a session: the trainee's picture, tool and force, and the stop button.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "engine/app/operator/session_controls.h"
#include "engine/app/picture/hud.h"
#include "engine/base/units.h"
#include "engine/display/keys.h"
#include "engine/display/writing.h"
#include "engine/session/session_data.h"

namespace typodont {

namespace {

using namespace widgets;
namespace keys = display::keys;

constexpr double kShareStep = 0.05;

/// Shows the current phase of an implant exercise: the phase's problems, tool depth, and bone temperature.
void draw_phase(const OperatorState& s, const ImplantStatus& implant) {
  ImGui::Spacing();
  row(s.text("implant.depth"),
      fmt::format("{:.1f} / {:.1f} mm", implant.depth / kMillimetre, implant.phase_depth / kMillimetre));
  row(s.text("implant.temperature"), fmt::format("{:.0f} °C", implant.temperature));
  const bool wrong = implant.note != session::ImplantNote::kNone;
  colored_wrapped(wrong ? s.text(fmt::format("implant.note.{}", session::name_of(implant.note))) : "–",
                  wrong ? kBad : kDim);
}

/// True if the page must explain the mouse. The steps of an exercise explain it, but a scan has no steps.
bool explains_mouse(const OperatorState& s) {
  return s.steps.count() == 0 && s.device.address == "mouse:";
}

void draw_exercise(OperatorState& s, InterfaceWindow& w, ImVec2 size) {
  const PagePanel panel("exercise", s.text("op.exercise"), size, w);
  wrapped(s.scene_title);
  dim_wrapped(s.scene_goal);
  if (s.status.implant) draw_phase(s, *s.status.implant);
  if (explains_mouse(s)) {
    ImGui::Spacing();
    dim_wrapped(s.text("op.mouse_help"));
  }
  const int count = s.steps.count(), current = s.steps.current();
  if (count > 0) {
    ImGui::Spacing();
    heading(fmt::format("{} {} / {}", s.text("op.steps"), std::min(current + 1, count), count).c_str(), w);
    for (int i = 0; i < count; ++i) {
      const ImVec4 color = i < current ? kGood : i == current ? ImGui::GetStyleColorVec4(ImGuiCol_Text) : kDim;
      ImGui::PushStyleColor(ImGuiCol_Text, color);
      ImGui::TextUnformatted(i < current ? "✓" : i == current ? "▸" : "·");
      ImGui::SameLine(1.2f * w.style().unit + ImGui::GetStyle().WindowPadding.x);
      wrapped(s.steps.text(i).in(s.language));
      ImGui::PopStyleColor();
      if (i == current && s.step_shown != i) {
        ImGui::SetScrollHereY(0.6f);
        s.step_shown = i;
      }
    }
    const char* const done = s.text(s.steps.waits() ? "op.step_skip" : "op.step_done");
    if (key_button(fmt::format("{}   N", done), {0, 0}, current < count, key('N'))) s.ask(Ask::kStep, 1);
    ImGui::SameLine();
    if (key_button(fmt::format("{}   B", s.text("op.step_back")), {0, 0}, current > 0, key('B'))) s.ask(Ask::kStep, -1);
  }
}

/// Draws each item of the score as a bar, so that the user sees at once which item is low.
void draw_score(OperatorState& s, InterfaceWindow& w, ImVec2 size) {
  const float u = w.style().unit;
  const PagePanel panel("score", s.text("op.score_so_far"), size, w);
  if (!s.score_known) return dim("…");
  if (s.score.full > 0) {
    title(s.number(s.score.points, 0), w);
    ImGui::SameLine();
    ImGui::AlignTextToFramePadding();
    // "…" after the score: the latest cuts are not yet included in the score.
    dim(fmt::format("/ {:.0f}{}", s.score.full, s.score_current ? "" : "  …"));
  }
  for (const session::ScoreItem& item : s.score.items) {
    // Below this completed fraction of the task, the items of the score have no colours for good and bad.
    constexpr double kBegun = 0.05;
    const float fraction =
        item.full > 0 && s.score.completion > kBegun ? static_cast<float>(item.points / item.full) : -1;
    ImGui::PushFont(w.style().small);
    const ImVec4 color = fraction < 0 ? ImGui::GetStyleColorVec4(ImGuiCol_Text)
                                      : score_color(static_cast<double>(fraction), s.score.pass);
    row(s.text(fmt::format("score.{}", item.name)), session::quantity_text(item.value, item.unit, s.language), &color);
    ImGui::PopFont();
    if (fraction < 0) continue;
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const float width = ImGui::GetContentRegionAvail().x, height = 0.18f * u;
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    draw.AddRectFilled(at, {at.x + width, at.y + height}, ImGui::GetColorU32(ImGuiCol_FrameBg), height);
    draw.AddRectFilled(at, {at.x + width * std::clamp(fraction, 0.0f, 1.0f), at.y + height}, ImGui::GetColorU32(color),
                       height);
    ImGui::Dummy({width, height});
  }
}

void draw_removed(OperatorState& s, InterfaceWindow& w, ImVec2 size) {
  const PagePanel panel("removed", s.text("removed"), size, w);
  bool any = false;
  for (std::size_t i = 1; i < s.status.tissue.removed.size(); ++i) {
    const double mm3 = s.status.tissue.removed[i] / kCubicMillimetre;
    if (std::abs(mm3) < 5e-4) continue;
    any = true;
    const bool alarm = static_cast<Tissue>(i) == Tissue::kPulp;
    row(s.text(fmt::format("tissue.{}", name_of(static_cast<Tissue>(i)))), fmt::format("{} mm³", s.number(mm3, 3)),
        alarm ? &kBad : nullptr);
  }
  if (!any) dim("–");
}

/// Rotates, moves or zooms the free viewpoint with the mouse.
void turn(OperatorState& s, bool hovered, bool active) {
  const ImGuiIO& io = ImGui::GetIO();
  Viewpoint v = s.viewpoint;
  if (active && io.MouseDown[0]) {
    v.azimuth -= 0.008 * static_cast<double>(io.MouseDelta.x);
    v.elevation += 0.008 * static_cast<double>(io.MouseDelta.y);
  } else if (active && io.MouseDown[1]) {
    v.shift += glm::dvec2(-io.MouseDelta.x, io.MouseDelta.y) * (0.15 * v.distance / std::max(s.live_size.y, 1));
  }
  if (hovered) v.distance *= std::pow(0.9, static_cast<double>(io.MouseWheel));
  s.viewpoint = clamped(v);
}

/// Rotates, moves or zooms the free viewpoint with keys.
void turn_by_keys(OperatorState& s) {
  const ImGuiIO& io = ImGui::GetIO();
  if (!s.own_view || io.WantTextInput || io.KeyCtrl) return;
  Viewpoint v = s.viewpoint;
  const auto pressed = [](int code) { return ImGui::IsKeyPressed(code) ? 1.0 : 0.0; };
  v.azimuth += 0.1 * (pressed('J') - pressed('L'));
  v.elevation += 0.1 * (pressed('I') - pressed('K'));
  v.distance *= 1 + 0.1 * (pressed('U') - pressed('O'));
  s.viewpoint = clamped(v);
}

void draw_live(OperatorState& s, InterfaceWindow& w, ImVec2 size) {
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {0, 0});
  ImGui::PushStyleColor(ImGuiCol_ChildBg, ImVec4(0.03f, 0.032f, 0.035f, 1));
  ImGui::BeginChild("live", size, false, ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoNav);
  s.live_hovered = false;
  // Mouse buttons and Shift count as released, unless the code below finds that the user uses them over the picture.
  s.live_input.left = s.live_input.right = s.live_input.middle = s.live_input.shift = false;
  s.live_input.wheel = 0;
  // A picture that this window draws fills the available area. One that another window draws keeps its aspect ratio.
  const float aspect = s.live_is_own || s.own_view ? size.x / size.y : static_cast<float>(s.live_aspect);
  const ImVec2 fit = size.x / size.y > aspect ? ImVec2(size.y * aspect, size.y) : ImVec2(size.x, size.x / aspect);
  const ImVec2 at{std::floor((size.x - fit.x) / 2), std::floor((size.y - fit.y) / 2)};
  s.live_size = {static_cast<int>(fit.x), static_cast<int>(fit.y)};
  if (s.live) {
    ImGui::SetCursorPos(at);
    // If the user sees the screen in a mirror, the picture on the screen is a mirror image. This matrix mirrors it
    // again, so that the instructor sees it upright.
    const glm::dmat2 upright = s.own_view ? glm::dmat2(1) : s.live_upright;
    const glm::dvec2 across = upright[0], up = upright[1];
    // Converts a corner of the upright picture to texture coordinates.
    const auto corner = [&](double x, double y) {
      const glm::dvec2 p = x * across + y * up;
      return ImVec2(static_cast<float>((p.x + 1) / 2), static_cast<float>((1 - p.y) / 2));
    };
    const ImVec2 screen = ImGui::GetCursorScreenPos();
    ImGui::GetWindowDrawList()->AddImageQuad(w.texture(*s.live, s.status.frames + s.status.own_frames), screen,
                                             {screen.x + fit.x, screen.y}, {screen.x + fit.x, screen.y + fit.y},
                                             {screen.x, screen.y + fit.y}, corner(-1, 1), corner(1, 1), corner(1, -1),
                                             corner(-1, -1));
    ImGui::SetCursorPos(at);
    ImGui::InvisibleButton("over", fit, ImGuiButtonFlags_MouseButtonLeft | ImGuiButtonFlags_MouseButtonRight);
    // After a navigation key such as Page up, ImGui ignores the mouse until it moves. The wheel must still move the
    // tool, so this test uses only the rectangle of the picture.
    const bool over = ImGui::IsMouseHoveringRect(ImGui::GetItemRectMin(), ImGui::GetItemRectMax()) &&
                      !ImGui::IsPopupOpen("", ImGuiPopupFlags_AnyPopup);
    s.live_hovered = over || ImGui::IsItemActive();
    const ImGuiIO& io = ImGui::GetIO();
    if (s.own_view) {
      turn(s, ImGui::IsItemHovered(), ImGui::IsItemActive());
    } else {
      s.live_input.pointer = {2 * (io.MousePos.x - screen.x) / fit.x - 1, 1 - 2 * (io.MousePos.y - screen.y) / fit.y};
      s.live_input.pointer = upright * glm::clamp(s.live_input.pointer, glm::dvec2(-1.2), glm::dvec2(1.2));
      s.live_input.left = ImGui::IsItemActive() && io.MouseDown[0];
      s.live_input.right = s.live_hovered && io.MouseDown[1];
      s.live_input.middle = s.live_hovered && io.MouseDown[2];
      s.live_input.shift = s.live_hovered && io.KeyShift;
      for (const int key : {keys::kPageUp, keys::kPageDown})
        if (ImGui::IsKeyPressed(key)) s.live_input.pressed.push_back(key);
      s.live_input.wheel = s.live_hovered ? static_cast<double>(io.MouseWheel) : 0.0;
    }
  } else {
    const char* text = s.text(s.own_view ? "op.loading" : "op.no_picture");
    const ImVec2 wide = ImGui::CalcTextSize(text);
    ImGui::SetCursorPos({(size.x - wide.x) / 2, (size.y - wide.y) / 2});
    dim(text);
  }
  const float u = w.style().unit;
  ImGui::PushFont(w.style().small);
  ImGui::SetCursorPos({0.7f * u, 0.6f * u});
  over_picture(s.own_view ? s.text("op.own_view_help") : s.trainee_seen ? s.text("op.trainee_picture") : "");
  if (s.look_in_work) {
    ImGui::SetCursorPosX(0.7f * u);
    over_picture(fmt::format("{} …", s.text("op.look_in_work")));
  }
  ImGui::PopFont();
  // The picture in this window has no texts; in another window, it has the warning.
  if (const std::string warning = warning_text(s.status.warning, s.language); !warning.empty()) {
    const float width = ImGui::CalcTextSize(warning.c_str()).x;
    ImGui::SetCursorPos({std::max(0.7f * u, 0.5f * (size.x - width)), 2.4f * u});
    ImGui::PushStyleColor(ImGuiCol_Text, kWarn);
    over_picture(warning);
    ImGui::PopStyleColor();
  }
  ImGui::EndChild();
  ImGui::PopStyleColor();
  ImGui::PopStyleVar();
}

void draw_tool(OperatorState& s, InterfaceWindow& w, ImVec2 size) {
  const PagePanel panel("tool", s.text("op.tool"), size, w);
  for (std::size_t i = 0; i < s.tools.size(); ++i) {
    const bool held = s.status.tick.tool == i;
    const std::string label = i < 9 ? fmt::format("{}   {}", i + 1, s.tools[i]) : s.tools[i];
    const float room = ImGui::GetContentRegionAvail().x - 2 * ImGui::GetStyle().FramePadding.x;
    ImGui::PushID(static_cast<int>(i));
    if (toggle_button(fitted(label, room).c_str(), held, {-1, 0})) s.ask(Ask::kTool, static_cast<int>(i));
    if (ImGui::IsItemHovered() && fitted(label, room) != label) ImGui::SetTooltip("%s", s.tools[i].c_str());
    ImGui::PopID();
  }
  if (s.status.implant) {
    if (key_button(fmt::format("{}   T", s.text("op.phase_tool")), {-1, 0}, true, key('T'))) s.ask(Ask::kPhaseTool);
    if (toggle_button(s.text("op.backwards"), s.settings.backwards, {-1, 0})) {
      s.settings.backwards = !s.settings.backwards;
      s.ask(Ask::kSettings);
    }
  }
  row(s.text("op.speed_now"), display::spindle_text(s.status.tick.spindle / kKrpm, hud_words(s.language)));
  // A slider for a fraction of the maximum, with keys for more and less.
  const auto share = [&](const char* id, double& fraction, const char* label, const char* more, const char* less) {
    const int steps = typed(more) - typed(less);
    if (steps != 0) fraction = std::clamp(fraction + steps * kShareStep, 0.0, 1.0);
    auto percent = static_cast<float>(100 * fraction);
    const bool slid = slider(s, id, percent, 0, 100, s.text(label), 0, " %%");
    if (slid) fraction = static_cast<double>(percent / 100);
    if (steps != 0 || slid) s.ask(Ask::kSettings);
  };
  share("##speed", s.settings.speed_fraction, "op.speed_limit", "+=", "-");
  if (s.device.force_limit > 0) share("##force", s.settings.force_fraction, "op.force_share", "]", "[");
}

/// Draws the controls of the instructor's brush, which paints at the tool's head while its button or P is pressed. The
/// hardness and the colour apply to the next strokes only; the stiffness applies to all tissue of the painted kind.
void draw_brush(OperatorState& s, InterfaceWindow& w, ImVec2 size) {
  const PagePanel panel("brush", s.text("op.paint"), size, w);
  constexpr std::array kPaintable = {Tissue::kCaries, Tissue::kEnamel, Tissue::kDentin, Tissue::kPulp,
                                     Tissue::kGingiva};
  const auto name = [&](Tissue t) { return s.text(fmt::format("tissue.{}", name_of(t))); };
  auto chosen = static_cast<int>(std::ranges::find(kPaintable, s.paint_tissue) - kPaintable.begin());
  choice("##tissue", chosen, 0, static_cast<int>(kPaintable.size()),
         [&](int i) { return name(kPaintable.at(static_cast<std::size_t>(i))); });
  s.paint_tissue = kPaintable.at(static_cast<std::size_t>(chosen));
  slider(s, "##radius", s.paint_radius_mm, 0.1f, 3, s.text("op.radius"), 2, " mm", -1, ImGuiSliderFlags_Logarithmic);
  slider(s, "##hardness", s.paint_hardness, 0.05f, 1, fmt::format("{} ×", s.text("op.hardness")), 2);
  const auto tissue = static_cast<std::size_t>(s.paint_tissue);
  if (slider(s, "##stiffness", s.stiffness[tissue], 0.05f, 3, fmt::format("{} ×", s.text("op.stiffness")), 2, "", -1,
             ImGuiSliderFlags_Logarithmic)) {
    s.settings.stiffness[tissue] = static_cast<double>(s.stiffness[tissue]);
    s.ask(Ask::kSettings);
  }
  ImGui::SetNextItemWidth(-1);
  ImGui::ColorEdit3("##color", &s.brush_colors[tissue].x, ImGuiColorEditFlags_NoOptions);
  toggle_button(fmt::format("{}   P", s.text("op.paint_hold")).c_str(), s.painting, {-1, 0});
  s.painting = ImGui::IsItemActive() || (!ImGui::GetIO().WantTextInput && ImGui::IsKeyDown('P'));
  row(s.text("op.strokes"), fmt::format("{}", s.status.tissue.painted));
}

void draw_device(OperatorState& s, InterfaceWindow& w, ImVec2 size) {
  const float u = w.style().unit;
  const PagePanel panel("device", s.text("op.device"), size, w);
  wrapped(s.device.model);
  const double force = glm::length(s.status.tick.f_T_W);
  const double limit = s.device.force_limit > 0 ? s.device.force_limit : 3;
  row(s.text("force"), fmt::format("{} N", s.number(force, 2)));
  const ImVec4 color = force > 0.9 * limit ? kBad : force > 0.6 * limit ? kWarn : kGood;
  ImGui::PushStyleColor(ImGuiCol_PlotHistogram, color);
  ImGui::ProgressBar(static_cast<float>(std::min(force / limit, 1.0)), {-1, 0.4f * u}, "");
  ImGui::PopStyleColor();
  ImGui::PlotLines("##forces", s.forces.data(), static_cast<int>(s.forces.size()), s.curve_at, nullptr, 0,
                   static_cast<float>(limit), {ImGui::GetContentRegionAvail().x, 2.6f * u});
  if (s.status.bearable_force > 0)
    row(s.text("op.motors"),
        fmt::format("{:.0f} %, {} N", 100 * s.status.motor_heat, s.number(s.status.bearable_force, 1)),
        s.status.motor_heat > 0.8 ? &kWarn : nullptr);
  bool any = false;
  const auto say = [&](const char* text) {
    any = true;
    colored_wrapped(text, kWarn);
  };
  if (s.held) say(s.text("op.is_held"));
  if (s.status.caught > 0)
    say(fmt::format(fmt::runtime(s.text("op.caught")), fmt::format("{:.0f}", 1e3 * s.status.caught)).c_str());
  if (s.status.bearable_force > 0 && !s.status.armed) say(s.text("op.not_armed"));
  for (const auto& [fault, name] : session::fault_names()) {
    if (fault != Fault::kHeld && (s.status.faults & bits(fault))) say(s.text(fmt::format("fault.{}", name)));
  }
  if (!any) colored(s.text("op.all_well"), kGood);
}

void draw_timing(OperatorState& s, InterfaceWindow& w, ImVec2 size) {
  const PagePanel panel("timing", s.text("op.timing"), size, w);
  const LoopTiming& t = s.status.timing;
  ImGui::PushFont(w.style().small);
  row(s.text("op.servo_tick"), fmt::format("{} µs", s.number(t.work.quantile(0.5) * 1e-3, 1)));
  row(s.text("op.servo_p999"), fmt::format("{} µs", s.number(t.work.quantile(0.999) * 1e-3, 1)));
  row(s.text("op.servo_jitter"), fmt::format("{:.0f} µs", t.jitter.quantile(0.99) * 1e-3));
  row(s.text("op.missed"), fmt::format("{}", t.misses), t.misses ? &kWarn : nullptr);
  row(s.text("op.frame"), fmt::format("{} ms", s.number(s.status.frame_ms, 1)));
  row(s.text("op.frames"), fmt::format("{:.0f} /s", s.status.frames_per_second));
  if (const std::string step = fmt::format("op.quality.{}", s.status.quality); session::has_text(step))
    row(s.text("op.quality"), s.text(step));
  if (!s.status.quality_notice.empty() && ImGui::IsItemHovered())
    ImGui::SetTooltip("%s", s.status.quality_notice.c_str());
  for (const GrantedLine& line : granted_lines(s)) {
    row(line.name.c_str(), line.value, line.granted ? nullptr : &kWarn);
    if (!s.status.real_time.empty() && ImGui::IsItemHovered())
      ImGui::SetTooltip("%.*s", static_cast<int>(s.status.real_time.size()), s.status.real_time.data());
  }
  ImGui::PopFont();
}

}  // namespace

void draw_session_page(OperatorState& s, InterfaceWindow& w) {
  const float u = w.style().unit;
  begin_page(w);
  const ImVec2 room = ImGui::GetContentRegionAvail(), gap = ImGui::GetStyle().ItemSpacing;
  const float side = std::clamp(0.21f * room.x, 14 * u, 20 * u);

  begin_column("left", {side, room.y});
  const float removed = 7.5f * u;
  const float exercise = s.steps.count() > 0 ? 0.45f * room.y : explains_mouse(s) ? 17 * u : 9 * u;
  draw_exercise(s, w, {0, exercise});
  draw_score(s, w, {0, room.y - exercise - removed - 2 * gap.y});
  draw_removed(s, w, {0, removed});
  ImGui::EndChild();

  ImGui::SameLine();
  begin_column("middle", {room.x - 2 * side - 2 * gap.x, room.y});
  SessionControls controls(s, w, ImGui::GetContentRegionAvail().x);
  draw_live(s, w, {ImGui::GetContentRegionAvail().x, room.y - controls.height() - gap.y});
  controls.draw();
  if (controls.possible()) turn_by_keys(s);
  ImGui::EndChild();

  ImGui::SameLine();
  begin_column("right", {side, room.y});
  const float stop = 4 * u, timing = 16.2f * u, device = (s.author ? 15.5f : 13.5f) * u;
  if (stop_button(fmt::format("{}   {}", s.text("op.emergency_stop"), s.keys("Space  Esc")).c_str(), {-1, stop})) {
    s.ask(Ask::kEmergencyStop);
  }
  const float tool = room.y - stop - timing - device - 3 * gap.y;
  draw_tool(s, w, {0, tool});
  if (s.author)
    draw_brush(s, w, {0, device});
  else
    draw_device(s, w, {0, device});
  draw_timing(s, w, {0, timing});
  ImGui::EndChild();

  if (ImGui::IsKeyPressed(keys::kEscape, false) || ImGui::IsKeyPressed(' ', false)) s.ask(Ask::kEmergencyStop);
  if (key(keys::kF1 + 11, true) && std::getenv("TYPODONT_TEST")) s.ask(Ask::kLoseDevice);
  if (key(keys::kF1)) s.help = true;
  for (std::size_t i = 0; i < std::min<std::size_t>(s.tools.size(), 9); ++i)
    if (key('1' + static_cast<int>(i))) s.ask(Ask::kTool, static_cast<int>(i));
  end_page();
}

}  // namespace typodont
