// Elements of all pages. Sizes in text heights.
#pragma once

#include <imgui.h>

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/app/operator/shortcuts.h"
#include "engine/app/operator/state.h"

namespace typodont::widgets {

inline const ImVec4 kGood{0.45f, 0.78f, 0.58f, 1}, kWarn{0.93f, 0.74f, 0.36f, 1}, kBad{0.93f, 0.42f, 0.36f, 1};
inline const ImVec4 kDim{0.60f, 0.62f, 0.64f, 1};

/// Covers the whole window.
void begin_page(InterfaceWindow& w);
void end_page();

/// With a heading. Returns the size of the body.
ImVec2 begin_titled_page(const char* title, InterfaceWindow& w);
/// Message line, or the progress of a long task (Esc cancels), and the button back to the start. `can_leave`: enabled.
/// `more`: further buttons of the given size.
void end_titled_page(OperatorState& s, InterfaceWindow& w, bool can_leave = true,
                     const std::function<void(ImVec2 size)>& more = {});

/// Without background; ends with ImGui::EndChild().
void begin_column(const char* id, ImVec2 size);
/// `size` as in ImGui::BeginChild.
bool begin_panel(const char* id, const char* heading, ImVec2 size, InterfaceWindow& w);
void end_panel();

void heading(const char* text, InterfaceWindow& w);
void dim(const std::string& text);
void dim_wrapped(const std::string& text);
/// Ellipsis if wider than `room` (pixels); cut between words if possible, never inside a character. `width` measures a
/// text.
std::string fitted(const std::string& text, float room, const std::function<float(std::string_view)>& width);
/// With the present font.
std::string fitted(const std::string& text, float room);
/// At most `room` pixels; a tooltip shows a shortened text.
void one_line(const std::string& text, float room);
/// Name at the left, value at the right edge.
void row(const char* name, const std::string& value, const ImVec4* color = nullptr);

/// A square picture as a button, for the mouse. `name`: key of its title; `picture`: null is empty; `drawn`: times
/// drawn; `add(at)`: mouse and marks over the picture with its corner at `at`.
void titled_picture(OperatorState& s, InterfaceWindow& w, const char* name, const gpu::Image* picture,
                    std::uint64_t drawn, float size, const std::function<void(ImVec2 at)>& add);

/// A page's main action. True: pressed.
bool main_button(const char* text, ImVec2 size);
/// Emergency stop. True: pressed.
bool stop_button(const char* text, ImVec2 size);
/// Looks pressed while `on`. True: pressed.
bool toggle_button(const char* text, bool on, ImVec2 size);

/// Red below the pass mark. `fraction`: of the full score.
ImVec4 score_color(double fraction, const session::PassMark& pass);

/// Button of a request, with its shortcut. `main`: the page's main action.
void ask_button(OperatorState& s, Ask ask, const Shortcut& shortcut, const char* text, ImVec2 size, bool enabled = true,
                bool main = false);
/// In this frame.
bool pressed(const Shortcut& shortcut);
/// Of all pages but a running session's.
void page_shortcuts(OperatorState& s);

/// In this frame. A focused text field keeps keys for typing and editing.
bool key(int code, bool control = false);
/// How often one of these characters was typed, on any layout; 0 while a field accepts text.
int typed(std::string_view characters);

/// Ctrl+O opens the list. `endings`: in lower case.
void file_field(const char* id, const char* hint, std::span<char> text, FileChooser& chooser,
                std::span<const std::string> endings, OperatorState& s, InterfaceWindow& w);
/// mm per unit of a mesh.
void unit_field(float& unit_mm);

/// A right of the servo loop, such as real-time scheduling, and whether it was granted; as in the report. None before
/// the first tick.
struct GrantedLine {
  std::string name, value;
  bool granted = false;
};
std::vector<GrantedLine> granted_lines(const OperatorState& s);

/// At the bottom of a page.
void message_line(const OperatorState& s);
/// With a cancel button.
void busy_bar(OperatorState& s, float width);

}  // namespace typodont::widgets
