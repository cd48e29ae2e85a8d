// Texts over the picture of a session, in the user's language (catalogue: engine/session/page/strings_hud.cpp).
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>

#include "engine/display/writing.h"
#include "engine/session/strings.h"
#include "haptics/tool.h"

namespace typodont {

/// Separates parts of the text that may stand on different lines.
inline constexpr std::string_view kHudGap = "   ";

/// The text of the catalogue for "hud.KEY", with its placeholders filled in.
template <class... Args>
std::string hud_text(session::Language language, std::string_view key, const Args&... args) {
  const std::string name = fmt::format("hud.{}", key);
  return fmt::format(fmt::runtime(session::text(name, language)), args...);
}

/// Units and decimal sign for the numbers of the text.
display::HudWords hud_words(session::Language language);

/// A number with at most `digits` significant digits, without trailing zeros, and with the language's decimal sign.
std::string short_number(double value, int digits, session::Language language);

/// Name and size of a tool: "Round bur 1.2 mm". A tool without a name is named by its shape.
std::string tool_title(const haptics::Tool& tool, session::Language language);

/// Returns `language`, or English with a warning if the program was built without a font for `language`.
session::Language hud_language(session::Language language);

}  // namespace typodont
