// Who may include whom: the diagram of ARCHITECTURE.md as a table, held against every file of the tree.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <string>

namespace {

namespace fs = std::filesystem;

/// Module of a path, e.g. "engine/base", "haptics"; empty for anything else.
std::string module_of(const std::string& path) {
  static const std::regex engine("^(engine/[a-z]+)/.*"), top("^(haptics|audio|calibration|shaders|tests)/.*");
  std::smatch match;
  if (std::regex_match(path, match, engine) || std::regex_match(path, match, top)) return match[1];
  return "";
}

const std::map<std::string, std::set<std::string>> kMayInclude = {
    {"engine/base", {}},
    {"engine/contract", {"engine/base"}},
    {"haptics", {"engine/base", "engine/contract"}},
    {"audio", {"engine/base", "engine/contract"}},
    {"calibration", {"engine/base", "engine/contract"}},
    {"engine/surface", {"engine/base", "engine/contract"}},
    {"engine/debris", {"engine/base", "engine/contract"}},
    {"engine/session", {"engine/base", "engine/contract"}},
    {"engine/gpu", {"engine/base"}},
    {"engine/display", {"engine/base", "engine/contract", "engine/gpu", "shaders"}},
    {"engine/render", {"engine/base", "engine/contract", "engine/gpu", "shaders"}},
};

TEST(IncludeGraph, EveryModuleIncludesOnlyWhatTheArchitectureAllows) {
  std::size_t files = 0;
  for (const char* top : {"engine", "haptics", "audio", "calibration"}) {
    for (const auto& entry : fs::recursive_directory_iterator(top)) {
      const std::string path = entry.path().generic_string(), extension = entry.path().extension().string();
      if (extension != ".h" && extension != ".cpp") continue;
      ++files;
      const std::string from = module_of(path);
      if (from == "engine/app") continue;
      ASSERT_TRUE(kMayInclude.contains(from)) << path << " belongs to no module of the table";
      std::ifstream in(path);
      static const std::regex include(R"re(^\s*#include\s+"([^"]+)".*)re");
      for (std::string line; std::getline(in, line);) {
        std::smatch match;
        if (!std::regex_match(line, match, include)) continue;
        const std::string to = module_of(match[1]);
        if (to.empty() || to == from) continue;
        EXPECT_TRUE(kMayInclude.at(from).contains(to)) << path << " includes " << match[1];
      }
    }
  }
  EXPECT_GT(files, 40u);
}

TEST(IncludeGraph, OpenVdbStaysInsideHapticsVolume) {
  for (const char* top : {"engine", "haptics", "audio", "calibration"}) {
    for (const auto& entry : fs::recursive_directory_iterator(top)) {
      const std::string path = entry.path().generic_string();
      if (!entry.is_regular_file() || path.starts_with("haptics/volume/")) continue;
      std::ifstream in(path);
      for (std::string line; std::getline(in, line);) {
        EXPECT_FALSE(line.starts_with("#include <openvdb")) << path;
      }
    }
  }
}

TEST(IncludeGraph, TheHapticCoreIncludesNeitherItsDevicesNorItsImporters) {
  static const std::regex include(R"re(^\s*#include\s+"haptics/(devices|import)/.*)re");
  for (const auto& entry : fs::recursive_directory_iterator("haptics")) {
    const std::string path = entry.path().generic_string();
    if (!entry.is_regular_file()) continue;
    std::ifstream in(path);
    for (std::string line; std::getline(in, line);) {
      std::smatch match;
      if (!std::regex_match(line, match, include)) continue;
      EXPECT_TRUE(path.starts_with("haptics/" + match[1].str() + "/")) << path << ": " << line;
    }
  }
}

}  // namespace
