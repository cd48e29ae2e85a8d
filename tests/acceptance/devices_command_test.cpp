// Tests `typodont devices`, and a session with a device that the user may not open. If the tests run as root, the
// program is run as another user.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <pty.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <map>
#include <string>

#include "engine/base/json.h"
#include "tests/support/program.h"

namespace typodont::test {
namespace {

/// The replacement libraries are installed as a vendor's libraries are: the loader's path names them, and the vendor's
/// setup names the device.
TEST(Devices, DevicesOfVendorLibrariesAreListedWithModelSerialForceLimitAndPermission) {
  const ProgramFolder folder(TYPODONT_PROGRAM);
  std::filesystem::create_directories(folder.path() / "vendor/config");
  folder.write("vendor/config/Default Device.config", "");
  const std::string libraries = std::filesystem::path(TYPODONT_STANDIN_HD).parent_path().string() + ":" +
                                std::filesystem::path(TYPODONT_STANDIN_DHD).parent_path().string();
  const Ran ran = expect_ok(
      folder.run("devices --json", fmt::format("env GTDD_HOME={} LD_LIBRARY_PATH={}", folder / "vendor", libraries)));
  std::map<std::string, std::pair<std::string, double>> found;
  const Json all = Json::parse(ran.out, "devices");
  for (const Json& device : all["devices"].items()) {
    EXPECT_TRUE(device["permitted"].boolean());
    found[device["address"].string()] = {device["model"].string() + " " + device["serial"].string(),
                                         device["force_limit_N"].number()};
  }
  ASSERT_EQ(found.count("forcedimension:0") + found.count("openhaptics:Default Device"), 2u) << ran.out;
  EXPECT_EQ(found["forcedimension:0"].first, "sigma.7 (stand-in) 4711");
  EXPECT_EQ(found["forcedimension:0"].second, 12);
  EXPECT_EQ(found["openhaptics:Default Device"].first, "Touch (stand-in) S-0001");
  EXPECT_EQ(found["openhaptics:Default Device"].second, 3.3);
}

TEST(Devices, AMissingPermissionIsReportedWithTheCommandThatGrantsIt) {
  int board, line;
  char node[128];
  ASSERT_EQ(::openpty(&board, &line, node, nullptr, nullptr), 0);
  ASSERT_EQ(::chmod(node, 0), 0);
  const ProgramFolder folder(TYPODONT_PROGRAM);
  ASSERT_EQ(::chmod(folder.path().c_str(), 0777), 0);  // for the other user
  const std::string scene = folder.write("scene.json", R"({"tissue": {"voxel_mm": 0.5, "solids": [
    {"tissue": "enamel", "solid": {"sphere": {"radius_mm": 3}}}]}, "tool": "round_012", "parts": ["haptics"]})");
  const std::string user = ::geteuid() == 0 ? "setpriv --reuid=65534 --regid=65534 --clear-groups" : "";
  const Ran ran =
      folder.run(fmt::format("run {} --hand woodenhaptics:{} --pedal none --audio none:", scene, node), user);
  EXPECT_EQ(ran.status, 2) << ran.err;
  for (const std::string& words : {std::string(node), std::string("no permission to open it"),
                                   std::string("sudo typodont devices --install-udev")}) {
    EXPECT_NE(ran.err.find(words), std::string::npos) << ran.err;
  }
  ::chmod(node, 0600);
  ::close(line);
  ::close(board);
}

}  // namespace
}  // namespace typodont::test
