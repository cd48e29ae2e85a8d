// Gets the error message for importing a broken file.
#pragma once

#include <filesystem>
#include <string>

#include "engine/base/error.h"
#include "haptics/import/import.h"

namespace typodont::test {

/// The error's message; empty if the file was imported.
inline std::string message_of(const std::filesystem::path& file, const haptics::ImportOptions& options = {}) {
  try {
    haptics::import_tissue(file, options);
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

}  // namespace typodont::test
