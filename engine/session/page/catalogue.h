// How a text of the catalogue is kept: a key, and the text in every language.
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "engine/session/strings.h"

namespace typodont::session {

struct Entry {
  std::string_view key;
  std::array<std::string_view, kLanguageCount> text;  // English, German, Simplified Chinese; zero-terminated
};

/// What the operator's window says, beside what it shares with the reports.
std::span<const Entry> operator_catalogue() noexcept;

}  // namespace typodont::session
