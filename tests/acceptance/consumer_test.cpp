// Tests the core as a library: the installed files, and a program outside the source tree that is built with them.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <sstream>
#include <string>

#include "tests/support/program.h"

namespace typodont {
namespace {

namespace fs = std::filesystem;

/// The libraries of this build, installed once for all tests.
class Installed : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new test::ProgramFolder(TYPODONT_CMAKE);
    expect_ok(folder_->run(fmt::format("--install {} --prefix {} --component development", TYPODONT_BUILD, prefix())));
  }
  static void TearDownTestSuite() { delete folder_; }

  static std::string prefix() { return *folder_ / "prefix"; }
  static std::string build(const std::string& name) { return *folder_ / name; }
  /// Configures the consumer with these components in a build folder of this name.
  static test::Ran configure(const std::string& name, const std::string& components, const std::string& more = "") {
    return folder_->run(
        fmt::format("-G Ninja -S tests/acceptance/consumer -B {} -DCMAKE_BUILD_TYPE=Release "
                    "-DCMAKE_CXX_COMPILER={} -DCMAKE_PREFIX_PATH={} '-DCOMPONENTS={}' {}",
                    build(name), TYPODONT_COMPILER, prefix(), components, more));
  }
  static test::Ran make(const std::string& name, const std::string& target) {
    return folder_->run(fmt::format("--build {} --target {}", build(name), target));
  }

  static test::ProgramFolder* folder_;
};
test::ProgramFolder* Installed::folder_ = nullptr;

/// The library haptics must build without these packages, which only the program and the other libraries use. (CMake
/// looks for OpenSSL, of the cache, by PkgConfig.)
const char* const kNoOthers =
    "-DCMAKE_DISABLE_FIND_PACKAGE_Vulkan=ON -DCMAKE_DISABLE_FIND_PACKAGE_HDF5=ON -DCMAKE_DISABLE_FIND_PACKAGE_Ceres=ON "
    "-DCMAKE_DISABLE_FIND_PACKAGE_Eigen3=ON -DCMAKE_DISABLE_FIND_PACKAGE_PNG=ON -DCMAKE_DISABLE_FIND_PACKAGE_assimp=ON "
    "-DCMAKE_DISABLE_FIND_PACKAGE_CLI11=ON "
    "-DCMAKE_DISABLE_FIND_PACKAGE_glfw3=ON -DCMAKE_DISABLE_FIND_PACKAGE_OpenXR=ON "
    "-DCMAKE_DISABLE_FIND_PACKAGE_GTest=ON";
/// A program that uses the library does not need nlohmann_json either; only the library's own build does.
const std::string kNothingElse = fmt::format("{} -DCMAKE_DISABLE_FIND_PACKAGE_nlohmann_json=ON", kNoOthers);

TEST_F(Installed, AProgramThatLinksOnlyHapticsComputesForceAndRemovalOnABallCorrectly) {
  expect_ok(configure("consumer", "haptics", kNothingElse));
  expect_ok(make("consumer", "consumer"));
  const test::Ran ran = expect_ok(test::ProgramFolder(build("consumer/consumer")).run(""));
  struct Value {
    double found = NAN, expected = NAN;
  };
  std::map<std::string, Value> values;
  std::istringstream lines(ran.out);
  for (std::string line, name; std::getline(lines, line);) {
    std::istringstream words(line);
    if (Value value; words >> name >> value.found >> value.expected) values[name] = value;
  }
  for (const char* what : {"pressed_N", "drilled_N", "removed_mm3"}) {
    EXPECT_NEAR(values[what].found, values[what].expected, 0.01 * values[what].expected) << what << ":\n" << ran.out;
  }
  EXPECT_NEAR(values["pressed_N"].found, 0.2, 0.002);
  EXPECT_GT(values["drilled_N"].found, 0);
  EXPECT_LT(values["drilled_N"].found, 0.5 * values["pressed_N"].found) << "the bur sinks in";
}

TEST_F(Installed, EveryHeaderCompilesWithoutWarningsAndTheLibrariesLinkIntoASharedLibrary) {
  const std::string strict = "-DCMAKE_CXX_FLAGS='-Wall -Wextra -Werror' -DCMAKE_SHARED_LINKER_FLAGS=-Wl,-z,text";
  expect_ok(configure("everything", "haptics;devices;import;audio;calibration", strict));
  expect_ok(make("everything", "everything"));
}

TEST_F(Installed, NoCompilerFlagOfThisTreeIsExported) {
  const std::string targets = test::read_text(fs::path(prefix()) / TYPODONT_PACKAGE / "TypodontTargets.cmake");
  ASSERT_NE(targets.find("Typodont::haptics"), std::string::npos);
  for (const char* ours : {"-W", "-f", "-D", "INTERFACE_COMPILE_OPTIONS", TYPODONT_SOURCE}) {
    EXPECT_EQ(targets.find(ours), std::string::npos) << ours;
  }
}

TEST_F(Installed, AMissingComponentIsReportedByName) {
  const test::Ran configured = configure("unknown", "haptics;bindings");
  EXPECT_NE(configured.status, 0);
  EXPECT_NE(configured.err.find("bindings"), std::string::npos) << configured.err;
}

TEST(HapticsAlone, ConfiguresWithoutThePackagesOfTheOtherModules) {
  const test::ProgramFolder folder(TYPODONT_CMAKE);
  expect_ok(
      folder.run(fmt::format("-G Ninja -S . -B {} -DTYPODONT_LIBRARIES=haptics {}", folder / "build", kNoOthers)));
}

}  // namespace
}  // namespace typodont
