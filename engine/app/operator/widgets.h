// Elements that all pages use. Sizes are in text heights.
#pragma once

#include <imgui.h>

#include <functional>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "engine/app/operator/shortcuts.h"
#include "engine/app/operator/state.h"

namespace typodont::widgets {

inline const ImVec4 kGood{0.45f, 0.78f, 0.58f, 1}, kWarn{0.93f, 0.74f, 0.36f, 1}, kBad{0.93f, 0.42f, 0.36f, 1};
inline const ImVec4 kDim{0.60f, 0.62f, 0.64f, 1};

/// Begins a page that covers the whole window.
void begin_page(InterfaceWindow& w);
void end_page();

/// Begins a page with a heading. Returns its body's size.
ImVec2 begin_titled_page(const char* title, InterfaceWindow& w);
/// Ends the page with the message line, or the progress of a long task (Esc cancels), and the button to the start page.
/// `can_leave`: this button is enabled. `more`: draws further buttons of the given size.
void end_titled_page(OperatorState& s, InterfaceWindow& w, bool can_leave = true,
                     const std::function<void(ImVec2 size)>& more = {});

/// Ends a page that has nothing to show yet. `body`: size of the body, which stays empty.
void end_empty_page(OperatorState& s, InterfaceWindow& w, ImVec2 body);

/// Begins a column without background. End it with ImGui::EndChild().
void begin_column(const char* id, ImVec2 size);
/// A panel with a heading, around the elements that are drawn during its life. `size` as for ImGui::BeginChild.
struct PagePanel {
  PagePanel(const char* id, const char* heading, ImVec2 size, InterfaceWindow& w);
  ~PagePanel() { ImGui::EndChild(); }
  PagePanel(const PagePanel&) = delete;
  PagePanel& operator=(const PagePanel&) = delete;
};

/// Texts in the large and in the small font.
void title(const std::string& text, InterfaceWindow& w);
void heading(const char* text, InterfaceWindow& w);
void note(const std::string& text, InterfaceWindow& w, const ImVec4& color = kDim);
void colored(const std::string& text, const ImVec4& color);
/// Width of a text in the current font, pixels.
float width_in_font(std::string_view text);
/// Breaks a text into lines of at most `room` (pixels), only at spaces. A word wider than `room` stays whole. `width`
/// measures a text.
std::string broken(const std::string& text, float room, const std::function<float(std::string_view)>& width);
/// Draws a text in lines as wide as the column. ImGui alone would also break a number at its decimal point.
void wrapped(const std::string& text);
void colored_wrapped(const std::string& text, const ImVec4& color);
inline void dim(const std::string& text) {
  colored(text, kDim);
}
inline void dim_wrapped(const std::string& text) {
  colored_wrapped(text, kDim);
}
/// Writes a text over a picture, on a dark plate: readable on every picture, with a contrast of 4.5 or more.
void over_picture(const std::string& text);
/// Shortens a text with an ellipsis if it is wider than `room` (pixels). Cuts between words if possible, and never
/// inside a character. `width` measures a text.
std::string fitted(const std::string& text, float room,
                   const std::function<float(std::string_view)>& width = width_in_font);
/// Draws a text in at most `room` pixels; if it is shortened, a tooltip shows all of it.
void one_line(const std::string& text, float room, const ImVec4& color = ImGui::GetStyleColorVec4(ImGuiCol_Text));
/// Draws a name at the left edge and a value at the right edge.
void row(const char* name, const std::string& value, const ImVec4* color = nullptr);

/// Draws the square picture `i` as a button for the mouse; an empty square if it is missing. `name`: key of its title.
/// `add(at)` handles mouse and marks; `at`: upper left corner.
void titled_picture(OperatorState& s, InterfaceWindow& w, const char* name, std::span<const gpu::Image> pictures,
                    std::size_t i, float size, const std::function<void(ImVec2 at)>& add);

/// Position, size and plane of one section on the screen.
struct SectionView {
  const SectionPlane& plane;
  ImVec2 at;
  float size;

  dvec3 point(ImVec2 screen) const { return plane.at(dvec2((screen.x - at.x) / size, (screen.y - at.y) / size)); }
  ImVec2 screen(const dvec3& p) const {
    const dvec3 from = p - plane.center_W;
    return {at.x + static_cast<float>(0.5 + glm::dot(from, plane.right_W) / plane.width) * size,
            at.y + static_cast<float>(0.5 - glm::dot(from, plane.up_W) / plane.height) * size};
  }
  // Length of this many pixels in the section, m.
  double length(float pixels) const { return static_cast<double>(pixels / size) * plane.width; }
  float pixels(double length) const { return static_cast<float>(length / plane.width) * size; }
};

/// Begins a table with one row of headings. `columns`: heading and relative width. False: it is not visible.
bool begin_table(const char* id, std::initializer_list<std::pair<const char*, float>> columns,
                 ImGuiTableFlags flags = 0, ImVec2 size = {0, 0});

/// Button for the main action of a page. Returns true if the user presses it.
bool main_button(const char* text, ImVec2 size);
/// Button for the emergency stop. Returns true if the user presses it.
bool stop_button(const char* text, ImVec2 size);
/// Button that looks pressed while `on` is true. Returns true if the user presses it.
bool toggle_button(const char* text, bool on, ImVec2 size);

/// Colour of a score: red below the pass mark. `fraction`: fraction of the full score.
ImVec4 score_color(double fraction, const session::PassMark& pass);
/// Colour of a finding of `typodont doctor`.
ImVec4 severity_color(DoctorFinding::Severity severity);

/// Button with a key. `by_key`: the key was pressed in this frame. Returns true if the enabled button or key is
/// pressed.
bool key_button(const std::string& label, ImVec2 size, bool enabled, bool by_key, bool main = false);
/// Button for a request, with its shortcut. `main`: the main action of the page.
void ask_button(OperatorState& s, KeyedAsk request, const char* text, ImVec2 size, bool enabled = true,
                bool main = false);
/// True if the shortcut was pressed in this frame.
bool pressed(const Shortcut& shortcut);
/// Handles the shortcuts that work on all pages, except during a session.
void page_shortcuts(OperatorState& s);

/// Ctrl with an arrow key chooses the previous or next entry of a list. True: another entry is chosen.
bool step_through(int& chosen, std::size_t count);

/// True if the key was pressed in this frame. A focused text field keeps keys for typing and editing.
bool key(int code, bool control = false);
/// Number of times that these characters were typed in this frame, on any keyboard layout; 0 while a field accepts
/// text.
int typed(std::string_view characters);

/// Field for a file name; Ctrl+O opens the list of files. `endings`: file extensions in lower case.
void file_field(const char* id, const char* hint, std::span<char> text, FileChooser& chooser,
                std::span<const std::string> endings, OperatorState& s, InterfaceWindow& w);
/// Field for the unit of a mesh, mm.
void unit_field(float& unit_mm);

// Fields as wide as the column, or `width`. They return true if the user changed the value.
bool text_field(const char* id, const char* hint, std::span<char> text);
/// Shows `label`, the value and `unit` (of printf: "%%" for a percent sign). Rounds the value to `decimals`.
bool slider(const OperatorState& s, const char* id, float& value, float lo, float hi, const std::string& label,
            int decimals, const char* unit = "", float width = -1, ImGuiSliderFlags flags = 0);
/// Choice from a list. `name(i)`: text of the choice i, for `first` <= i < `end`; `about(i)`: its tooltip.
bool choice(const char* id, int& chosen, int first, int end, const std::function<std::string(int)>& name,
            float width = -1, const std::function<std::string(int)>& about = {});
bool choice(const char* id, int& chosen, std::span<const char* const> names, float width = -1);

/// A permission of the servo loop, such as real-time scheduling, and whether the system granted it. The report
/// uses the same names. granted_lines() returns an empty list before the first tick.
struct GrantedLine {
  std::string name, value;
  bool granted = false;
};
std::vector<GrantedLine> granted_lines(const OperatorState& s);

/// Draws a long task's progress, with a button to cancel it.
void busy_bar(OperatorState& s, float width);
void message(const Message& shown);
/// Draws the progress of a long task, or else the message line.
void state_line(OperatorState& s, float width);

}  // namespace typodont::widgets
