// Every text the reports show, in three languages, in one catalogue (strings.cpp).
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace typodont::session {

enum class Language { kEnglish, kGerman, kChinese };
inline constexpr int kLanguageCount = 3;

/// "en", "de", "zh"; also longer forms as in LANG ("de_AT.UTF-8"). Nothing for others.
std::optional<Language> language_named(std::string_view tag) noexcept;
/// BCP 47, for <html lang>.
std::string_view tag_of(Language language) noexcept;

/// The text of a key, e.g. "title.report", "tissue.enamel". Unknown keys return the key itself.
std::string_view text(std::string_view key, Language language) noexcept;
bool has_text(std::string_view key) noexcept;

// Numbers as people read them, with the language's decimal sign: three digits that mean something, no power of ten, no
// minus before a zero.
std::string number_text(double v, int decimals, Language language);
std::string number_text(double v, Language language);
/// With its unit, not to be parted from it at the end of a line; without a unit it is a count. NaN, nothing to
/// measure: a dash.
std::string quantity_text(double v, std::string_view unit, Language language);
/// "round_012" → "Round bur": what kind of tool it is, without the number at its end. Tools that are not shipped are
/// called as they are.
std::string tool_text(std::string_view name, Language language);
/// What the loop that feels may be granted by the system, and whether it was; the report and the operator's window tell
/// the same.
struct Granted {
  std::string_view name;  // key of the catalogue
  bool yes = false;
};
std::array<Granted, 3> granted(bool fifo, bool pinned, bool memory_locked);
std::vector<std::string_view> catalogue_keys();

}  // namespace typodont::session
