// Texts over the picture of a session, in the user's language, from engine/session/texts/hud.json.
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>

#include "engine/app/picture/quality_ladder.h"
#include "engine/app/picture/world.h"
#include "engine/display/writing.h"
#include "engine/session/strings.h"
#include "haptics/tool.h"

namespace typodont {

/// Texts over a world's picture in a view. No side effects.
display::Hud hud(const World& world, session::Language language, render::View view = render::View::kLook);

/// Separator between parts of a text. Lines may break at it.
inline constexpr std::string_view kHudGap = "   ";

/// The catalogue's text for the key "hud.KEY", with its placeholders replaced by the arguments.
template <class... Args>
std::string hud_text(session::Language language, std::string_view key, const Args&... args) {
  const std::string name = fmt::format("hud.{}", key);
  return fmt::format(fmt::runtime(session::text(name, language)), args...);
}

/// The warning as a sentence; empty: none.
std::string warning_text(Warning warning, session::Language language);

/// The picture's quality level, by its name in render::kQualityLadder, and what would improve the picture.
std::string quality_text(std::string_view level, Remedy remedy, session::Language language);

/// The units and the decimal sign of the language.
display::HudWords hud_words(session::Language language);

/// Formats a number with at most `digits` significant digits, without trailing zeros, and with the decimal sign of the
/// language.
std::string short_number(double value, int digits, session::Language language);

/// Returns name and size of a tool, for example "Round bur 1.2 mm". If the tool has no name, the name of its shape is
/// used.
std::string tool_title(const haptics::Tool& tool, session::Language language);

/// Returns the title of the tool in the hand, and by how many percent its wear slows the removal at equal power.
std::string tool_line(const World& world, session::Language language);

/// Returns `language`. If the program was built without a font for it, logs a warning and returns English.
session::Language hud_language(session::Language language);

}  // namespace typodont
