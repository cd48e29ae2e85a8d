// The catalogue of all texts of the reports in three languages (strings.cpp).
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace typodont::session {

enum class Language { kEnglish, kGerman, kChinese };
inline constexpr int kLanguageCount = 3;

/// Language for a tag: "en", "de", "zh", or a longer form as in LANG ("de_AT.UTF-8"). No value for other languages.
std::optional<Language> language_named(std::string_view tag) noexcept;
/// The language of the desktop (LC_ALL, LC_MESSAGES, LANG), or English.
Language system_language() noexcept;
/// BCP 47 tag, for <html lang>.
std::string_view tag_of(Language language) noexcept;

/// Text for a key, e.g. "title.report", "tissue.enamel". Returns the key itself if the key is unknown.
std::string_view text(std::string_view key, Language language) noexcept;
bool has_text(std::string_view key) noexcept;

// Formats numbers for people, with the language's decimal sign: three significant digits, no exponent, no minus sign
// before zero.
std::string number_text(double v, int decimals, Language language);
std::string number_text(double v, Language language);
/// Formats a number with its unit and a no-break space. An empty unit means that the number is a count. NaN (not
/// measured) is shown as a dash.
std::string quantity_text(double v, std::string_view unit, Language language);
/// Formats a tool's name: "round_012" becomes "Round bur", the kind of tool without its number. Other tools keep
/// their names.
std::string tool_text(std::string_view name, Language language);
/// A right that the operating system may grant to the servo loop, and the system's answer. Used by the report and the
/// operator's window.
struct Granted {
  std::string_view name;  // key in the catalogue
  bool yes = false;
};
std::array<Granted, 3> granted(bool fifo, bool pinned, bool memory_locked);
std::vector<std::string_view> catalogue_keys();

}  // namespace typodont::session
