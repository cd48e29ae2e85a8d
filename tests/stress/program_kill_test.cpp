// Tests the whole program when it is killed in the middle of a live session, at unpredictable moments.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <random>
#include <thread>

#include "engine/base/json.h"
#include "tests/support/program.h"

namespace typodont::test {
namespace {

TEST(KilledProgram, LeavesARecordingThatReplaysExactlyAndLosesAtMostTheLastSecond) {
  const ProgramFolder folder(TYPODONT_PROGRAM);
  folder.write(
      "scene.json",
      R"({"tissue": {"voxel_mm": 0.15, "solids": [{"tissue": "dentin", "solid": {"box": {"size_mm": [6, 6, 4]}}}]},
      "tool": "round_012", "spindle_krpm": 300, "parts": ["haptics", "record"]})");
  std::string hand = "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n";
  for (int i = 0; i < 240; ++i)
    hand += fmt::format("{},{},{},{},1,0,0,0,1\n", 0.25 * i, 0.4 * (i % 8 - 4), 0.3 * (i / 8 % 8 - 4),
                        2.4 - 0.01 * (i % 100));
  folder.write("hand.csv", hand);
  std::mt19937 random(20);
  for (int i = 0; i < 6; ++i) {
    const std::string file = folder / fmt::format("killed_{}.h5", i);
    const pid_t child = folder.start(fmt::format("run {} --hand script:{} --record {} --seconds 60",
                                                 folder / "scene.json", folder / "hand.csv", file));
    ASSERT_GT(child, 0);
    for (int k = 0; k < 6000 && !std::filesystem::exists(file); ++k)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    // The first session is killed immediately: as soon as its file exists, the file must be readable.
    std::this_thread::sleep_for(std::chrono::milliseconds(i == 0 ? 0 : 100 + random() % 2400));
    ::kill(child, SIGKILL);
    const auto killed = std::chrono::system_clock::now();
    ::waitpid(child, nullptr, 0);
    struct stat written {};
    ASSERT_EQ(::stat(file.c_str(), &written), 0) << folder.said();
    const double age = std::chrono::duration<double>(killed.time_since_epoch()).count() -
                       static_cast<double>(written.st_mtim.tv_sec) -
                       1e-9 * static_cast<double>(written.st_mtim.tv_nsec);
    EXPECT_LT(age, 1.0) << "what came since the last write is lost";
    const Ran replay = expect_ok(folder.run("replay " + file + " --check --json"));
    const Json json = Json::parse(replay.out, "replay");
    EXPECT_TRUE(json["truncated"].boolean());
    EXPECT_TRUE(json["identical"].boolean());
  }
}

}  // namespace
}  // namespace typodont::test
