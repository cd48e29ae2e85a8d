// Returns the error message that the import of a broken file gives.
#pragma once

#include <filesystem>
#include <string>

#include "engine/base/error.h"
#include "haptics/import/import.h"
#include "tests/support/folder.h"

namespace typodont::test {

/// Returns the error's message, or an empty text if the file was imported.
inline std::string message_of(const std::filesystem::path& file, const haptics::ImportOptions& options = {}) {
  return refusal([&] { haptics::import_tissue(file, options); });
}

}  // namespace typodont::test
