// Tests which files may include which others: the diagram of ARCHITECTURE.md, private subfolders, and the order inside
// engine/app. Checks every file of the source tree.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

/// Module of a path, e.g. "engine/base", "haptics"; empty for anything else.
std::string module_of(const std::string& path) {
  static const std::regex engine("^(engine/[a-z]+)/.*"), import("^(haptics/import)/.*"),
      top("^(haptics|audio|calibration|shaders|tests)/.*");
  std::smatch match;
  for (const std::regex* module : {&engine, &import, &top}) {
    if (std::regex_match(path, match, *module)) return match[1];
  }
  return "";
}

/// Calls `each` with the path and the included path of every #include under these folders; returns the number of
/// files read.
std::size_t for_each_include(const std::vector<std::string>& folders,
                             const std::function<void(const std::string& path, const std::string& included)>& each) {
  static const std::regex include(R"re(^\s*#include\s+["<]([^">]+)[">].*)re");
  std::size_t files = 0;
  for (const std::string& folder : folders) {
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
      const std::string path = entry.path().generic_string(), extension = entry.path().extension().string();
      if (extension != ".h" && extension != ".cpp") continue;
      ++files;
      std::ifstream in(path);
      for (std::string line; std::getline(in, line);) {
        std::smatch match;
        if (std::regex_match(line, match, include)) each(path, match[1]);
      }
    }
  }
  return files;
}

const std::vector<std::string> kProgram = {"engine", "haptics", "audio", "calibration"};

const std::map<std::string, std::set<std::string>> kMayInclude = {
    {"engine/base", {}},
    {"engine/contract", {"engine/base"}},
    {"haptics", {"engine/base", "engine/contract"}},
    {"haptics/import", {"engine/base", "engine/contract", "haptics"}},
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
  const std::size_t files = for_each_include(kProgram, [](const std::string& path, const std::string& included) {
    const std::string from = module_of(path), to = module_of(included);
    if (from == "engine/app" || from == "engine/bindings" || to.empty() || to == from) return;
    ASSERT_TRUE(kMayInclude.contains(from)) << path << " belongs to no module of the table";
    EXPECT_TRUE(kMayInclude.at(from).contains(to)) << path << " includes " << included;
  });
  EXPECT_GT(files, 40u);
}

/// Returns the module to which this header is private, that is, in whose subfolder it is. Returns an empty text for a
/// header of a module's interface and for all other files.
std::string inside_of(const std::string& included) {
  const std::string module = module_of(included);
  return module.empty() || fs::path(included).parent_path() == module ? "" : module;
}

TEST(IncludeGraph, AHeaderInASubfolderIsIncludedByItsOwnModuleOnly) {
  for_each_include(kProgram, [](const std::string& path, const std::string& included) {
    const std::string module = inside_of(included);
    if (module.empty() || module == module_of(path)) return;
    ADD_FAILURE() << path << " includes " << included << ", which is private to " << module
                  << ": include a header at that module's root, or declare there what is needed";
  });
}

// A test may include private headers of the module that it tests, and of no other module.
TEST(IncludeGraph, ATestIncludesPrivateHeadersOfOneModuleOnly) {
  // These tests need several modules: one file calls the parsers of every module; faults arise in the session's threads
  // and in the safety layer; and the program's passes on a GPU are compared with those of the contact model.
  const std::set<std::string> several = {"tests/fuzz/targets.cpp", "tests/stress/faults_test.cpp",
                                         "tests/property/packing_gpu_test.cpp"};
  std::map<std::string, std::set<std::string>> looked_into;
  const std::size_t files = for_each_include({"tests"}, [&](const std::string& path, const std::string& included) {
    const std::string module = inside_of(included);
    if (module != "tests" && !module.empty()) looked_into[path].insert(module);
  });
  EXPECT_GT(files, 100u);
  for (const auto& [path, modules] : looked_into) {
    if (several.contains(path)) continue;
    std::string names;
    for (const std::string& module : modules) names += " " + module;
    EXPECT_EQ(modules.size(), 1u) << path << " includes private headers of" << names;
  }
}

/// Reads the order of the table in engine/app/README.md. Returns the row of each name. "hands/" is a folder; "scene"
/// stands for scene.h and scene.cpp.
std::map<std::string, int> app_order() {
  std::map<std::string, int> rows;
  std::ifstream in("engine/app/README.md");
  static const std::regex row(R"(^ *(\d+) {2,}(.*)$)");
  for (std::string line; std::getline(in, line);) {
    std::smatch match;
    if (!std::regex_match(line, match, row)) continue;
    std::istringstream names(match[2]);
    for (std::string name; names >> name;) {
      EXPECT_TRUE(rows.emplace(name, std::stoi(match[1])).second) << name << " stands twice in the order";
    }
  }
  return rows;
}

TEST(IncludeGraph, InsideTheProgramAFileIncludesOnlyFoldersAboveItInTheOrder) {
  const std::string app = "engine/app/";
  const auto name_of = [&](const std::string& path) {
    const std::string rest = path.substr(app.size());
    const std::size_t slash = rest.find('/');
    return slash == std::string::npos ? fs::path(rest).stem().string() : rest.substr(0, slash + 1);
  };
  const std::map<std::string, int> rows = app_order();
  for (const auto& [name, row] : rows) {
    EXPECT_TRUE(fs::exists(app + name) || fs::exists(app + name + ".h") || fs::exists(app + name + ".cpp"))
        << name << " stands in the order of engine/app/README.md and is not there";
  }
  for (const auto& entry : fs::recursive_directory_iterator(app)) {
    const std::string extension = entry.path().extension().string(), path = entry.path().generic_string();
    if (extension != ".h" && extension != ".cpp") continue;
    EXPECT_TRUE(rows.contains(name_of(path))) << path << " has no place in the order of engine/app/README.md";
  }
  for_each_include({app}, [&](const std::string& path, const std::string& included) {
    if (!included.starts_with(app)) return;
    const std::string from = name_of(path), to = name_of(included);
    if (from == to || !rows.contains(from) || !rows.contains(to)) return;
    EXPECT_LT(rows.at(to), rows.at(from))
        << path << " includes " << included << ", but " << to << " does not stand above " << from
        << " in the order of engine/app/README.md";
  });
}

TEST(IncludeGraph, OpenVdbStaysInsideHapticsVolume) {
  for_each_include(kProgram, [](const std::string& path, const std::string& included) {
    EXPECT_TRUE(!included.starts_with("openvdb") || path == "haptics/volume/vdb_process.cpp") << path;
  });
}

TEST(IncludeGraph, TheHapticCoreIncludesNeitherItsDevicesNorItsImporters) {
  for_each_include({"haptics"}, [](const std::string& path, const std::string& included) {
    for (const char* part : {"haptics/devices/", "haptics/import/"})
      EXPECT_TRUE(!included.starts_with(part) || path.starts_with(part)) << path << " includes " << included;
  });
}

}  // namespace
