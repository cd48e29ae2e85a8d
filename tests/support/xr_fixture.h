// A folder with a script for the test runtime, and the environment that lets the real loader find it.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/program.h"

namespace typodont::test {

class XrFixture {
 public:
  XrFixture() : folder_("") {
    setenv("XR_RUNTIME_JSON", TYPODONT_XR_RUNTIME, 1);
    setenv("TYPODONT_XR_SCRIPT", (folder_ / "script.json").c_str(), 1);
  }

  /// Writes the script. `members`: JSON members, e.g. R"("view_size": [160, 128])".
  void script(const std::string& members) {
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path()))
      if (entry.path().filename() == "log.txt" || entry.path().filename().string().starts_with("frame"))
        std::filesystem::remove(entry.path());
    folder_.write("script.json", fmt::format("{{\"log\": \"{}\", \"out\": \"{}\"{}{}}}", folder_ / "log.txt",
                                             folder_.path().string(), members.empty() ? "" : ", ", members));
  }
  std::string path(const std::string& name) const { return folder_ / name; }
  std::string write(const std::string& name, const std::string& text) const { return folder_.write(name, text); }
  const std::filesystem::path& folder() const { return folder_.path(); }

  std::string log() const { return read_text(folder_ / "log.txt"); }
  std::vector<std::string> lines(const std::string& with) const {
    std::istringstream in(log());
    std::vector<std::string> found;
    for (std::string line; std::getline(in, line);)
      if (line.find(with) != std::string::npos) found.push_back(line);
    return found;
  }
  /// Returns a text with all violated rules. Tests require an empty text.
  std::string violations() const {
    std::string all;
    for (const std::string& line : lines("violation"))
      if (all.find(line) == std::string::npos) all += line + '\n';
    return all;
  }
  int count(const std::string& with) const { return static_cast<int>(lines(with).size()); }

 private:
  ProgramFolder folder_;
};

}  // namespace typodont::test
