#include "engine/app/operator/widgets.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "engine/display/keys.h"

namespace typodont::widgets {

void begin_page(InterfaceWindow& w) {
  const display::ivec2 size = w.size();
  ImGui::SetNextWindowPos({0, 0});
  ImGui::SetNextWindowSize({static_cast<float>(size.x), static_cast<float>(size.y)});
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {w.style().unit, w.style().unit});
  ImGui::Begin("page", nullptr,
               ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings |
                   ImGuiWindowFlags_NoBringToFrontOnFocus);
  ImGui::PopStyleVar();
}
void end_page() {
  ImGui::End();
}

namespace {
// Heights of the message line and of the page's lowest row, which contains the buttons; in text heights.
constexpr float kMessageHeight = 2.2f, kFootHeight = 3.2f;
}  // namespace

ImVec2 begin_titled_page(const char* title, InterfaceWindow& w) {
  begin_page(w);
  widgets::title(title, w);
  const ImVec2 room = ImGui::GetContentRegionAvail();
  const float below = (kMessageHeight + kFootHeight) * w.style().unit + 2 * ImGui::GetStyle().ItemSpacing.y;
  return {room.x, room.y - below};
}

void end_titled_page(OperatorState& s, InterfaceWindow& w, bool can_leave, const std::function<void(ImVec2)>& more) {
  const float u = w.style().unit;
  begin_column("message", {0, kMessageHeight * u});
  state_line(s, 0.5f * ImGui::GetContentRegionAvail().x);
  ImGui::EndChild();
  const ImVec2 button{0, (kFootHeight - 0.4f) * u};
  ask_button(s, Ask::kToStart, s.text("op.to_start"), button, can_leave);
  if (more) {
    ImGui::SameLine();
    more(button);
  }
  if (s.busy && ImGui::IsKeyPressed(display::keys::kEscape, false)) s.ask(Ask::kCancel);
  page_shortcuts(s);
  end_page();
}

void end_empty_page(OperatorState& s, InterfaceWindow& w, ImVec2 body) {
  ImGui::Dummy(body);
  end_titled_page(s, w);
}

void begin_column(const char* id, ImVec2 size) {
  ImGui::PushStyleColor(ImGuiCol_ChildBg, ImVec4(0, 0, 0, 0));
  ImGui::BeginChild(id, size, false, ImGuiWindowFlags_NavFlattened);
  ImGui::PopStyleColor();
}
PagePanel::PagePanel(const char* id, const char* title, ImVec2 size, InterfaceWindow& w) {
  ImGui::BeginChild(id, size, true, ImGuiWindowFlags_NavFlattened | ImGuiWindowFlags_AlwaysUseWindowPadding);
  if (title) widgets::heading(title, w);
}

float width_in_font(std::string_view text) {
  return ImGui::CalcTextSize(text.data(), text.data() + text.size()).x;
}

void title(const std::string& text, InterfaceWindow& w) {
  ImGui::PushFont(w.style().large);
  ImGui::TextUnformatted(text.c_str());
  ImGui::PopFont();
}
void heading(const char* text, InterfaceWindow& w) {
  ImGui::PushFont(w.style().small);
  dim(text);
  ImGui::PopFont();
}
void note(const std::string& text, InterfaceWindow& w, const ImVec4& color) {
  ImGui::PushFont(w.style().small);
  colored_wrapped(text, color);
  ImGui::PopFont();
}
void colored(const std::string& text, const ImVec4& color) {
  ImGui::PushStyleColor(ImGuiCol_Text, color);
  ImGui::TextUnformatted(text.data(), text.data() + text.size());
  ImGui::PopStyleColor();
}
std::string broken(const std::string& text, float room, const std::function<float(std::string_view)>& width) {
  std::string lines = text;
  std::size_t line = 0, space = std::string::npos;  // begin of the current line, and its last space
  for (std::size_t end = 0; end <= lines.size(); ++end) {
    if (end < lines.size() && lines[end] != ' ' && lines[end] != '\n') continue;
    if (space != std::string::npos && width(std::string_view(lines).substr(line, end - line)) > room) {
      lines[space] = '\n';
      line = space + 1;
    }
    space = end;
    if (end < lines.size() && lines[end] == '\n') line = end + 1, space = std::string::npos;
  }
  return lines;
}
void wrapped(const std::string& text) {
  const std::string lines = broken(text, ImGui::GetContentRegionAvail().x, width_in_font);
  ImGui::PushTextWrapPos(0);
  ImGui::TextUnformatted(lines.data(), lines.data() + lines.size());
  ImGui::PopTextWrapPos();
}
void colored_wrapped(const std::string& text, const ImVec4& color) {
  ImGui::PushStyleColor(ImGuiCol_Text, color);
  wrapped(text);
  ImGui::PopStyleColor();
}

void titled_picture(OperatorState& s, InterfaceWindow& w, const char* name, std::span<const gpu::Image> pictures,
                    std::size_t i, float size, const std::function<void(ImVec2 at)>& add) {
  ImGui::BeginGroup();
  heading(s.text(name), w);
  const ImVec2 at = ImGui::GetCursorScreenPos();
  if (i < pictures.size()) {
    ImGui::Image(w.texture(pictures[i]), {size, size});
    ImGui::SetCursorScreenPos(at);
    ImGui::InvisibleButton(name, {size, size});
    add(at);
  } else {
    ImGui::Dummy({size, size});
  }
  ImGui::EndGroup();
}
bool begin_table(const char* id, std::initializer_list<std::pair<const char*, float>> columns, ImGuiTableFlags flags,
                 ImVec2 size) {
  flags |= ImGuiTableFlags_RowBg | ImGuiTableFlags_SizingStretchProp;
  if (!ImGui::BeginTable(id, static_cast<int>(columns.size()), flags, size)) return false;
  if (flags & ImGuiTableFlags_ScrollY) ImGui::TableSetupScrollFreeze(0, 1);
  for (const auto& [heading, width] : columns) ImGui::TableSetupColumn(heading, 0, width);
  ImGui::TableHeadersRow();
  return true;
}
void over_picture(const std::string& text) {
  if (text.empty()) return;
  const ImVec2 at = ImGui::GetCursorScreenPos(), size = ImGui::CalcTextSize(text.data(), text.data() + text.size());
  const float edge = 0.3f * ImGui::GetFontSize();
  ImGui::GetWindowDrawList()->AddRectFilled({at.x - edge, at.y - 0.5f * edge},
                                            {at.x + size.x + edge, at.y + size.y + 0.5f * edge}, IM_COL32(0, 0, 0, 190),
                                            edge);
  ImGui::TextUnformatted(text.data(), text.data() + text.size());
}

std::string fitted(const std::string& text, float room, const std::function<float(std::string_view)>& width) {
  if (width(text) <= room) return text;
  constexpr std::string_view kEllipsis = "…";
  const float left = room - width(kEllipsis);
  // Number of bytes that fit, and number of bytes that fit if the text is cut only between words.
  std::size_t fits = 0, words = 0;
  for (std::size_t end = 0; end < text.size();) {
    std::size_t next = end + 1;
    while (next < text.size() && (static_cast<unsigned char>(text[next]) & 0xc0) == 0x80) ++next;
    if (width(std::string_view(text).substr(0, next)) > left) break;
    if (text[end] == ' ') words = end;
    fits = end = next;
    if (end < text.size() && text[end] == ' ') words = end;
  }
  // A long word, or Chinese text without spaces, is cut between two characters.
  const std::size_t keep = words > fits / 2 ? words : fits;
  return text.substr(0, keep) + std::string(kEllipsis);
}
void one_line(const std::string& text, float room, const ImVec4& color) {
  const std::string shown = fitted(text, room);
  colored(shown, color);
  if (shown.size() != text.size() && ImGui::IsItemHovered()) ImGui::SetTooltip("%s", text.c_str());
}
void row(const char* name, const std::string& value, const ImVec4* color) {
  const float width = ImGui::CalcTextSize(value.c_str()).x, room = ImGui::GetContentRegionAvail().x;
  const float left = ImGui::GetCursorPosX();
  // If space is short, only the name is shortened.
  one_line(name, std::max(room - width - 0.5f * ImGui::GetFontSize(), 0.0f), kDim);
  ImGui::SameLine();
  ImGui::SetCursorPosX(left + std::max(room - width, 0.0f));
  colored(value, color ? *color : ImGui::GetStyleColorVec4(ImGuiCol_Text));
}

namespace {
bool colored_button(const char* text, ImVec2 size, ImVec4 plain, ImVec4 hovered, ImVec4 active) {
  ImGui::PushStyleColor(ImGuiCol_Button, plain);
  ImGui::PushStyleColor(ImGuiCol_ButtonHovered, hovered);
  ImGui::PushStyleColor(ImGuiCol_ButtonActive, active);
  const bool pressed = ImGui::Button(text, size);
  ImGui::PopStyleColor(3);
  return pressed;
}
}  // namespace

bool main_button(const char* text, ImVec2 size) {
  return colored_button(text, size, {0.16f, 0.45f, 0.53f, 1}, {0.20f, 0.53f, 0.62f, 1}, {0.24f, 0.60f, 0.70f, 1});
}
bool stop_button(const char* text, ImVec2 size) {
  return colored_button(text, size, {0.66f, 0.16f, 0.13f, 1}, {0.76f, 0.20f, 0.16f, 1}, {0.86f, 0.26f, 0.20f, 1});
}
bool toggle_button(const char* text, bool on, ImVec2 size) {
  if (!on) return ImGui::Button(text, size);
  return colored_button(text, size, {0.18f, 0.38f, 0.44f, 1}, {0.22f, 0.44f, 0.51f, 1}, {0.24f, 0.50f, 0.58f, 1});
}

ImVec4 score_color(double fraction, const session::PassMark& pass) {
  const double mark = pass.points / 100;
  return fraction < mark ? kBad : fraction < (1 + mark) / 2 ? kWarn : kGood;
}

ImVec4 severity_color(DoctorFinding::Severity severity) {
  using Severity = DoctorFinding::Severity;
  return severity == Severity::kGood ? kGood : severity == Severity::kWarning ? kWarn : kBad;
}

bool pressed(const Shortcut& shortcut) {
  return key(shortcut.code, shortcut.control);
}
bool key_button(const std::string& label, ImVec2 size, bool enabled, bool by_key, bool main) {
  ImGui::BeginDisabled(!enabled);
  const bool clicked = main ? main_button(label.c_str(), size) : ImGui::Button(label.c_str(), size);
  ImGui::EndDisabled();
  return enabled && (clicked || by_key);
}
void ask_button(OperatorState& s, KeyedAsk request, const char* text, ImVec2 size, bool enabled, bool main) {
  const std::string label = fmt::format("  {}   {}  ", text, s.keys(std::string(request.key.name)));
  if (key_button(label, size, enabled, pressed(request.key), main)) s.ask(request.ask);
}
void page_shortcuts(OperatorState& s) {
  if (s.page != Page::kArchive && pressed(shortcut(Ask::kArchive))) s.ask(Ask::kArchive);
  // The next three shortcuts do nothing while a task runs, because their pages would end the task.
  if (!s.busy && s.page != Page::kDoctor && pressed(shortcut(Ask::kDoctor))) s.ask(Ask::kDoctor);
  if (!s.busy && pressed(shortcut(Ask::kTutorial))) s.ask(Ask::kTutorial);
  if (!s.busy && s.page != Page::kExperiment && pressed(shortcut(Ask::kExperiment))) s.ask(Ask::kExperiment);
  if (s.school.set_up && s.page != Page::kSchool && pressed(shortcut(Ask::kSchool))) s.ask(Ask::kSchool);
  if (pressed(shortcut(Ask::kQuit))) s.ask(Ask::kQuit);
  if (key(display::keys::kF1)) s.help = true;
}

bool step_through(int& chosen, std::size_t count) {
  using display::keys::kDown, display::keys::kUp;
  const int entries = static_cast<int>(count);
  const int step = (ImGui::IsKeyPressed(kDown) ? 1 : 0) - (ImGui::IsKeyPressed(kUp) ? 1 : 0);
  if (!ImGui::GetIO().KeyCtrl || step == 0 || entries == 0) return false;
  chosen = (chosen + step + entries) % entries;
  return true;
}

bool key(int code, bool control) {
  const ImGuiIO& io = ImGui::GetIO();
  const bool function_key = code >= display::keys::kF1 && code <= display::keys::kF1 + 11;
  const bool edits = std::string_view("ACVXYZ").find(static_cast<char>(code)) != std::string_view::npos;
  const bool theirs = io.WantTextInput && !function_key && (!control || edits);
  return !theirs && io.KeyCtrl == control && ImGui::IsKeyPressed(code, false);
}

int typed(std::string_view characters) {
  const ImGuiIO& io = ImGui::GetIO();
  if (io.WantTextInput) return 0;
  return static_cast<int>(std::count_if(io.InputQueueCharacters.begin(), io.InputQueueCharacters.end(), [&](ImWchar c) {
    return c < 0x80 && characters.find(static_cast<char>(c)) != std::string_view::npos;
  }));
}

std::vector<GrantedLine> granted_lines(const OperatorState& s) {
  std::vector<GrantedLine> lines;
  if (s.status.timing.ticks == 0) return lines;
  const LoopGranted& loop = s.status.granted;
  for (const auto& [name, yes] : session::granted(loop.fifo, loop.pinned, loop.memory_locked))
    lines.push_back({s.text(name), s.text(yes ? "realtime.yes" : "op.not_granted"), yes});
  return lines;
}

void busy_bar(OperatorState& s, float width) {
  if (!s.busy) return;
  ImGui::ProgressBar(static_cast<float>(s.busy_fraction), {width, 0}, s.busy_what.c_str());
  ImGui::SameLine();
  if (ImGui::Button(s.text("op.cancel"))) s.ask(Ask::kCancel);
}

void message(const Message& shown) {
  if (!shown.text.empty()) colored_wrapped(shown.text, shown.is_error ? kBad : kGood);
}

void state_line(OperatorState& s, float width) {
  if (s.busy)
    busy_bar(s, width);
  else
    message(s.message);
}

bool text_field(const char* id, const char* hint, std::span<char> text) {
  ImGui::SetNextItemWidth(-1);
  return ImGui::InputTextWithHint(id, hint, text.data(), text.size());
}

bool slider(const OperatorState& s, const char* id, float& value, float lo, float hi, const std::string& label,
            int decimals, const char* unit, float width, ImGuiSliderFlags flags) {
  ImGui::SetNextItemWidth(width);
  // Only with a format for whole numbers, the keys step by whole numbers.
  const std::string number = decimals > 0 ? s.number(static_cast<double>(value), decimals) : "%.0f";
  const std::string text = fmt::format("{} {}{}", label, number, unit);
  if (!ImGui::SliderFloat(id, &value, lo, hi, text.c_str(), flags | ImGuiSliderFlags_AlwaysClamp)) return false;
  const auto steps = static_cast<float>(std::pow(10, decimals));
  value = std::round(value * steps) / steps;
  return true;
}

bool choice(const char* id, int& chosen, int first, int end, const std::function<std::string(int)>& name, float width,
            const std::function<std::string(int)>& about) {
  const int before = chosen;
  ImGui::SetNextItemWidth(width);
  if (!ImGui::BeginCombo(id, chosen >= first && chosen < end ? name(chosen).c_str() : "")) return false;
  for (int i = first; i < end; ++i) {
    if (ImGui::Selectable(name(i).c_str(), i == chosen)) chosen = i;
    if (about && ImGui::IsItemHovered()) ImGui::SetTooltip("%s", about(i).c_str());
  }
  ImGui::EndCombo();
  return chosen != before;
}

bool choice(const char* id, int& chosen, std::span<const char* const> names, float width) {
  ImGui::SetNextItemWidth(width);
  return ImGui::Combo(id, &chosen, names.data(), static_cast<int>(names.size()));
}

}  // namespace typodont::widgets
