// Every text the reports show, in three languages, in one catalogue (strings.cpp).
#pragma once

#include <optional>
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
std::vector<std::string_view> catalogue_keys();

}  // namespace typodont::session
