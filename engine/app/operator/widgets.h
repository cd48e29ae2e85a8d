// Elements that all pages of the window use. Sizes are multiples of the text height.
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

/// Begins an ImGui window that covers the whole area of the operator's window.
void begin_page(InterfaceWindow& w);
void end_page();

/// Begins a page with a heading. Returns the size of its body, which lies above the message line and the buttons.
ImVec2 begin_titled_page(const char* title, InterfaceWindow& w);
/// Ends a page. Draws the message line (or the progress of a long task, which Esc cancels), and the button that leads
/// back to the start page. `can_leave`: true if this button is enabled. `more`: draws further buttons of the given size
/// beside it.
void end_titled_page(OperatorState& s, InterfaceWindow& w, bool can_leave = true,
                     const std::function<void(ImVec2 size)>& more = {});

/// Begins an area for panels, without a background. End it with ImGui::EndChild().
void begin_column(const char* id, ImVec2 size);
/// Begins a panel with a heading. `size` has the same meaning as in ImGui::BeginChild.
bool begin_panel(const char* id, const char* heading, ImVec2 size, InterfaceWindow& w);
void end_panel();

void heading(const char* text, InterfaceWindow& w);
void dim(const std::string& text);
void dim_wrapped(const std::string& text);
/// Shortens the text with an ellipsis if it is wider than `room` (pixels). The text is cut between words if possible,
/// and never inside a character. `width`: function that measures the width of a text.
std::string fitted(const std::string& text, float room, const std::function<float(std::string_view)>& width);
/// Shortens the text with an ellipsis if it is wider than `room` (pixels). The width is measured with the present font.
std::string fitted(const std::string& text, float room);
/// Draws one line of text, at most `room` pixels wide. If the line is shortened, its tooltip shows the full text.
void one_line(const std::string& text, float room);
/// Draws a name at the left edge and its value at the right edge of the panel.
void row(const char* name, const std::string& value, const ImVec4* color = nullptr);

/// Draws a square picture with a title. The picture is a button, so it receives the mouse. `name`: key of the title's
/// text. `picture`: null draws an empty square. `drawn`: number of times that the picture was drawn. `add(at)`: handles
/// the mouse and draws marks over the picture, whose upper left corner is at `at`; it is called only if there is a
/// picture.
void titled_picture(OperatorState& s, InterfaceWindow& w, const char* name, const gpu::Image* picture,
                    std::uint64_t drawn, float size, const std::function<void(ImVec2 at)>& add);

/// Draws the button for the main action of a page. Returns true if it was pressed.
bool main_button(const char* text, ImVec2 size);
/// Draws the button of the emergency stop. Returns true if it was pressed.
bool stop_button(const char* text, ImVec2 size);
/// Draws a button that looks pressed while `on` is true. Returns true if it was pressed.
bool toggle_button(const char* text, bool on, ImVec2 size);

/// Returns the colour for a score. `fraction`: fraction of the full score. The colour is red below the pass mark.
ImVec4 score_color(double fraction, const session::PassMark& pass);

/// Draws a button for a request. The request is also made by the button's shortcut, which the button shows. `main`:
/// true draws the button as the main action of the page.
void ask_button(OperatorState& s, Ask ask, const Shortcut& shortcut, const char* text, ImVec2 size, bool enabled = true,
                bool main = false);
/// Returns true if the shortcut was pressed in this frame.
bool pressed(const Shortcut& shortcut);
/// Handles the shortcuts that are valid on all pages except the page of a running session.
void page_shortcuts(OperatorState& s);

/// Returns true if the key was pressed in this frame. While a text field has the focus, keys for typing and editing are
/// ignored.
bool key(int code, bool control = false);

/// Draws a field for a path. Ctrl+O opens the list of files. `endings`: file extensions in lower case.
void file_field(const char* id, const char* hint, std::span<char> text, FileChooser& chooser,
                std::span<const std::string> endings, OperatorState& s, InterfaceWindow& w);
/// Draws a field for the length unit of a mesh, in mm.
void unit_field(float& unit_mm);

/// A line of text for the user: the name of a right of the servo loop, such as real-time scheduling, and whether the
/// system has granted it. The report contains the same text. Before the first tick, there are no such lines.
struct GrantedLine {
  std::string name, value;
  bool granted = false;
};
std::vector<GrantedLine> granted_lines(const OperatorState& s);

/// Draws the message line at the bottom of a page.
void message_line(const OperatorState& s);
/// Draws the progress bar of a long task, with a cancel button.
void busy_bar(OperatorState& s, float width);

}  // namespace typodont::widgets
