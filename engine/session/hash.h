// Hashes that show whether forces are bit-identical, and which files a session used.
#pragma once

#include <filesystem>
#include <ostream>
#include <span>
#include <string>

#include "engine/base/fnv.h"
#include "engine/contract/contact.h"
#include "engine/session/session_data.h"

namespace typodont::session {

/// The hash as text, for example "fnv1a64:0123456789abcdef".
std::string to_text(const Fnv1a& hash);

/// Adds all bits of the forces and torques to a hash. Start with a default Fnv1a and pass all ticks in order, in any
/// number of calls.
void add_forces(Fnv1a& hash, std::span<const ServoTick> ticks) noexcept;

/// Describes a file by its name without folder, size and SHA-256. If `copy` is given, also writes the file's bytes to
/// it. Throws Error.
SourceFile describe_file(const std::filesystem::path& file, std::ostream* copy = nullptr);

}  // namespace typodont::session
