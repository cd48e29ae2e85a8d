// A temporary folder, the text of a file, and the message of a refusal.
#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "engine/base/error.h"
#include "engine/base/temporary_folder.h"

namespace typodont::test {

struct Folder : TemporaryFolder {
  std::filesystem::path operator/(const std::filesystem::path& name) const { return path() / name; }
};

inline std::string read_text(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// Returns the message of the Error that `work` throws, or an empty text.
template <class Work>
std::string refusal(Work&& work) {
  try {
    work();
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

}  // namespace typodont::test
