// Hashes that show whether files, forces or fields have the same bits. They do not protect against deliberate changes.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "engine/base/fnv.h"
#include "engine/contract/contact.h"
#include "engine/session/session_data.h"

namespace typodont::session {

/// Returns the hash as text, for example "fnv1a64:0123456789abcdef".
std::string to_text(const Fnv1a& hash);

/// Adds every bit of the forces and torques of the ticks to the hash. Equal runs have equal hashes. Start with a
/// default Fnv1a, and add all ticks in order, in pieces of any size.
void add_forces(Fnv1a& hash, std::span<const ServoTick> ticks) noexcept;

/// Reads the whole file and returns its size and hash. Throws Error on failure.
SourceFile describe_file(const std::filesystem::path& file);

}  // namespace typodont::session
