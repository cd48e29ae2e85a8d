// All texts of the reports, in three languages (texts/*.json).
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace typodont::session {

enum class Language { kEnglish, kGerman, kChinese };
inline constexpr int kLanguageCount = 3;

/// Language of a tag: "en", "de", "zh", or a value of LANG such as "de_AT.UTF-8". Empty: no known language.
std::optional<Language> language_named(std::string_view tag) noexcept;
/// Language by the variables LC_ALL, LC_MESSAGES, LANG; else English.
Language system_language() noexcept;
/// Language tag (BCP 47) for <html lang>.
std::string_view tag_of(Language language) noexcept;

/// Text for a key such as "title.report" or "tissue.enamel". An unknown key is returned unchanged.
std::string_view text(std::string_view key, Language language) noexcept;
bool has_text(std::string_view key) noexcept;

// The number with the language's decimal sign, without exponent and without minus before zero. Without `decimals`:
// three significant digits.
std::string number_text(double v, int decimals, Language language);
std::string number_text(double v, Language language);
/// Number and unit with a no-break space between them. Empty unit: a count; NaN: a dash.
std::string quantity_text(double v, std::string_view unit, Language language);
/// Name of a tool: "round_012" becomes "Round bur". Unknown tools keep their names.
std::string tool_text(std::string_view name, Language language);
/// A permission that the servo loop asks for (such as real-time priority), and whether the system has granted it.
struct Granted {
  std::string_view name;  // key of the permission's name in the text catalogue
  bool yes = false;
};
std::array<Granted, 3> granted(bool fifo, bool pinned, bool memory_locked);
std::vector<std::string_view> catalogue_keys();

}  // namespace typodont::session
