// A key with its text in every language.
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

/// Only for the operator's window.
std::span<const Entry> operator_catalogue() noexcept;
/// Drawn over a session's picture; the build makes glyphs of them (engine/gpu/font).
std::span<const Entry> hud_catalogue() noexcept;

}  // namespace typodont::session
