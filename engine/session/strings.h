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

/// Returns the language of a tag: "en", "de", "zh", or a longer form as in the variable LANG ("de_AT.UTF-8"). No value
/// for other languages.
std::optional<Language> language_named(std::string_view tag) noexcept;
/// Returns the language that the user set in the environment (LC_ALL, LC_MESSAGES, LANG), or English.
Language system_language() noexcept;
/// Returns the BCP 47 tag of a language, for <html lang>.
std::string_view tag_of(Language language) noexcept;

/// Returns the text with a key such as "title.report" or "tissue.enamel". If the key is unknown, returns the key
/// itself.
std::string_view text(std::string_view key, Language language) noexcept;
bool has_text(std::string_view key) noexcept;

// Formats a number for people, with the decimal sign of the language, without exponent, and without a minus sign before
// zero. Without `decimals`, it shows three significant digits.
std::string number_text(double v, int decimals, Language language);
std::string number_text(double v, Language language);
/// Formats a number with its unit and a no-break space between them. If the unit is empty, the number is a count. NaN
/// (not measured) is shown as a dash.
std::string quantity_text(double v, std::string_view unit, Language language);
/// Returns the text for a tool's name: "round_012" becomes "Round bur", which is the kind of the tool without its
/// number. Unknown tools keep their names.
std::string tool_text(std::string_view name, Language language);
/// A right that the operating system can grant to the servo loop, and whether the operating system has granted this
/// right. The report and the operator's window show the rights.
struct Granted {
  std::string_view name;  // key of the right's name in the text catalogue
  bool yes = false;
};
std::array<Granted, 3> granted(bool fifo, bool pinned, bool memory_locked);
std::vector<std::string_view> catalogue_keys();

}  // namespace typodont::session
