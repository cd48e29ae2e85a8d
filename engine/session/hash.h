// Whether forces have the same bits, and which files a session used.
#pragma once

#include <filesystem>
#include <ostream>
#include <span>
#include <string>

#include "engine/base/fnv.h"
#include "engine/contract/contact.h"
#include "engine/session/session_data.h"

namespace typodont::session {

/// For example "fnv1a64:0123456789abcdef".
std::string to_text(const Fnv1a& hash);

/// Every bit of forces and torques. All ticks in order from a default Fnv1a, in any pieces.
void add_forces(Fnv1a& hash, std::span<const ServoTick> ticks) noexcept;

/// Name without folder, size, SHA-256. Writes the same bytes to `copy`, unless null. Throws Error.
SourceFile describe_file(const std::filesystem::path& file, std::ostream* copy = nullptr);

}  // namespace typodont::session
