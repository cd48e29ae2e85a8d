// Whether files, forces or fields have the same bits. No protection against deliberate change.
#pragma once

#include <filesystem>
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

/// Size and hash. Throws Error.
SourceFile describe_file(const std::filesystem::path& file);

}  // namespace typodont::session
