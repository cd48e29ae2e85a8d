// Entries of the text catalogue. An entry is a key with its text in every language.
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "engine/session/strings.h"

namespace typodont::session {

struct Entry {
  std::string_view key;
  std::array<std::string_view, kLanguageCount> text;  // text in English, German and Simplified Chinese; zero-terminated
};

/// Returns the texts that only the operator's window uses.
std::span<const Entry> operator_catalogue() noexcept;
/// Returns the texts that are drawn over the picture of a session. The build converts their characters to glyphs
/// (engine/gpu/font).
std::span<const Entry> hud_catalogue() noexcept;

}  // namespace typodont::session
