// The few shapes all pages are made of. Sizes are multiples of the writing's height.
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

/// A window that fills everything.
void begin_page(InterfaceWindow& w);
void end_page();

/// A part of the page that holds panels, without a ground of its own; ImGui::EndChild() ends it.
void begin_column(const char* id, ImVec2 size);
/// A panel with a heading; `size` as BeginChild takes it.
bool begin_panel(const char* id, const char* heading, ImVec2 size, InterfaceWindow& w);
void end_panel();

void heading(const char* text, InterfaceWindow& w);
void dim(const std::string& text);
void dim_wrapped(const std::string& text);
/// The beginning of a text that is no wider than `room`, between words where it can and never inside a letter, with an
/// ellipsis; the whole where that fits. `width`: of a text.
std::string fitted(const std::string& text, float room, const std::function<float(std::string_view)>& width);
/// The same of the writing as it is now.
std::string fitted(const std::string& text, float room);
/// One line; where it does not fit, its beginning, and all of it for the pointer that rests on it.
void one_line(const std::string& text, float room);
/// Name at the left, value at the panel's right edge.
void row(const char* name, const std::string& value, const ImVec4* color = nullptr);

/// The one thing to do on a page.
bool main_button(const char* text, ImVec2 size);
/// Stops everything.
bool stop_button(const char* text, ImVec2 size);
/// A button that is held down while `on`.
bool toggle_button(const char* text, bool on, ImVec2 size);

/// The colour of what earned this share of its points; red where the pass mark is missed.
ImVec4 share_color(double share, const session::PassMark& pass);

/// A button that names its shortcut, and the shortcut itself: either asks for it. `main`: the one thing to do.
void ask_button(OperatorState& s, Ask ask, const Shortcut& shortcut, const char* text, ImVec2 size, bool enabled = true,
                bool main = false);
/// The shortcut alone, pressed in this frame.
bool pressed(const Shortcut& shortcut);
/// The shortcuts that every page has but a running session's.
void page_shortcuts(OperatorState& s);

/// Pressed in this frame. While somebody is typing, keys that write are theirs, and with Ctrl those that edit.
bool key(int code, bool control = false);

/// A path, and with Ctrl+O the list of what lies there. `endings`: of files, in small letters.
void file_field(const char* id, const char* hint, std::span<char> text, FileChooser& chooser,
                std::span<const std::string> endings, OperatorState& s, InterfaceWindow& w);
/// Millimetres a mesh's unit has.
void unit_field(float& unit_mm);

/// What the system granted the session's loop and what not, line by line, as the report will tell it; nothing before
/// its first tick.
struct GrantedLine {
  std::string name, value;
  bool granted = false;
};
std::vector<GrantedLine> granted_lines(const OperatorState& s);

/// The line at the page's foot.
void message_line(const OperatorState& s);
/// The bar of long work, with its way out.
void busy_bar(OperatorState& s, float width);

}  // namespace typodont::widgets
