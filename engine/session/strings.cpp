#include "engine/session/strings.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "session_files.h"

namespace typodont::session {

namespace {

using Catalogue = std::map<std::string, std::array<std::string, kLanguageCount>, std::less<>>;

const Catalogue& catalogue() {
  static const Catalogue texts = [] {
    Catalogue all;
    for (const char* part : {kReportTexts, kOperatorTexts, kHudTexts})
      all.merge(nlohmann::json::parse(part).get<Catalogue>());
    return all;
  }();
  return texts;
}

}  // namespace

std::optional<Language> language_named(std::string_view tag) noexcept {
  const std::string_view code = tag.substr(0, tag.find_first_of("_-."));
  if (code == "en" || code == "C" || code == "POSIX") return Language::kEnglish;
  if (code == "de") return Language::kGerman;
  if (code == "zh") return Language::kChinese;
  return std::nullopt;
}

Language system_language() noexcept {
  for (const char* name : {"LC_ALL", "LC_MESSAGES", "LANG"}) {
    const char* value = std::getenv(name);
    if (value && *value) return language_named(value).value_or(Language::kEnglish);
  }
  return Language::kEnglish;
}

std::string_view tag_of(Language language) noexcept {
  constexpr std::array<std::string_view, kLanguageCount> kTags{"en", "de", "zh-Hans"};
  return kTags[static_cast<std::size_t>(language)];
}

std::string_view text(std::string_view key, Language language) noexcept {
  const auto entry = catalogue().find(key);
  return entry == catalogue().end() ? key : entry->second[static_cast<std::size_t>(language)];
}

bool has_text(std::string_view key) noexcept {
  return catalogue().contains(key);
}

std::string tool_text(std::string_view name, Language language) {
  const std::string_view kind = name.substr(0, name.find_last_not_of("_0123456789") + 1);
  const std::string key = fmt::format("tool.{}", kind);
  if (has_text(key)) return std::string(text(key, language));
  std::string plain(kind.empty() ? name : kind);
  std::replace(plain.begin(), plain.end(), '_', ' ');
  std::replace(plain.begin(), plain.end(), '-', ' ');
  if (!plain.empty()) plain[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(plain[0])));
  return plain;
}

std::array<Granted, 3> granted(bool fifo, bool pinned, bool memory_locked) {
  return {{{"realtime.fifo", fifo}, {"realtime.pinned", pinned}, {"realtime.locked", memory_locked}}};
}

std::vector<std::string_view> catalogue_keys() {
  std::vector<std::string_view> keys;
  for (const auto& [key, texts] : catalogue()) keys.push_back(key);
  return keys;
}

std::string number_text(double v, int decimals, Language language) {
  std::string s = fmt::format("{:.{}f}", v, decimals);
  if (s.starts_with("-") && s.find_first_not_of("-0.") == std::string::npos) s.erase(0, 1);
  if (language == Language::kGerman) std::replace(s.begin(), s.end(), '.', ',');
  return s;
}

std::string number_text(double v, Language language) {
  const double a = std::abs(v);
  return number_text(v, a < 5e-4 || a >= 100 ? 0 : a >= 10 ? 1 : a >= 1 ? 2 : 3, language);
}

std::string quantity_text(double v, std::string_view unit, Language language) {
  if (std::isnan(v)) return "–";
  return unit.empty() ? number_text(v, 0, language) : fmt::format("{}\u00a0{}", number_text(v, language), unit);
}

}  // namespace typodont::session
