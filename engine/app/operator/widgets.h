// Common elements of all pages. Sizes are multiples of the text height.
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

/// Begins a window that fills the whole area.
void begin_page(InterfaceWindow& w);
void end_page();

/// Begins a page with a heading. Returns the size of its body, which is above the message line and the foot.
ImVec2 begin_titled_page(const char* title, InterfaceWindow& w);
/// Ends a titled page: draws the message line or the progress of a long task, and the button back to the selection.
/// Esc cancels the task. `can_leave`: the button is enabled. `more`: draws further buttons of this size beside it.
void end_titled_page(OperatorState& s, InterfaceWindow& w, bool can_leave = true,
                     const std::function<void(ImVec2 size)>& more = {});

/// Begins an area for panels, without its own background. End it with ImGui::EndChild().
void begin_column(const char* id, ImVec2 size);
/// Begins a panel with a heading; `size` as for BeginChild.
bool begin_panel(const char* id, const char* heading, ImVec2 size, InterfaceWindow& w);
void end_panel();

void heading(const char* text, InterfaceWindow& w);
void dim(const std::string& text);
void dim_wrapped(const std::string& text);
/// Shortens the text with an ellipsis if it is wider than `room`. The text is cut between words if possible and never
/// inside a character. `width`: measures a text.
std::string fitted(const std::string& text, float room, const std::function<float(std::string_view)>& width);
/// Same as fitted() above, measured with the present font.
std::string fitted(const std::string& text, float room);
/// Draws one line of text; a shortened line has its full text as a tooltip.
void one_line(const std::string& text, float room);
/// Shows the name at the left and the value at the panel's right edge.
void row(const char* name, const std::string& value, const ImVec4* color = nullptr);

/// Draws a square picture under its title, as a button that takes the mouse. `name`: text key of the title; null
/// `picture`: an empty square. `drawn`: number of times that the picture was drawn. `add(at)`: handles the mouse and
/// draws marks over the picture, whose upper left corner is `at`; it is called if there is a picture.
void titled_picture(OperatorState& s, InterfaceWindow& w, const char* name, const gpu::Image* picture,
                    std::uint64_t drawn, float size, const std::function<void(ImVec2 at)>& add);

/// The button for the main action of a page.
bool main_button(const char* text, ImVec2 size);
/// The button of the emergency stop.
bool stop_button(const char* text, ImVec2 size);
/// A button that looks pressed while `on`.
bool toggle_button(const char* text, bool on, ImVec2 size);

/// Colour for a fraction of the possible points; red if the pass mark is missed.
ImVec4 score_color(double fraction, const session::PassMark& pass);

/// A button that shows its shortcut. The button and the shortcut both issue the request. `main`: draws it as the main
/// action.
void ask_button(OperatorState& s, Ask ask, const Shortcut& shortcut, const char* text, ImVec2 size, bool enabled = true,
                bool main = false);
/// True if the shortcut was pressed in this frame.
bool pressed(const Shortcut& shortcut);
/// Handles the shortcuts of all pages except a running session's.
void page_shortcuts(OperatorState& s);

/// True if the key was pressed in this frame. While a text field has the focus, its typing and editing keys are
/// excluded.
bool key(int code, bool control = false);

/// A field for a path; Ctrl+O opens the list of files. `endings`: file extensions in lower case.
void file_field(const char* id, const char* hint, std::span<char> text, FileChooser& chooser,
                std::span<const std::string> endings, OperatorState& s, InterfaceWindow& w);
/// A field for the unit of a mesh in mm.
void unit_field(float& unit_mm);

/// A line about a right that the system granted or refused to the session's loop; same text as in the report. Before
/// the first tick, no lines exist.
struct GrantedLine {
  std::string name, value;
  bool granted = false;
};
std::vector<GrantedLine> granted_lines(const OperatorState& s);

/// The message line at the bottom of a page.
void message_line(const OperatorState& s);
/// Progress bar of a long task, with a cancel button.
void busy_bar(OperatorState& s, float width);

}  // namespace typodont::widgets
