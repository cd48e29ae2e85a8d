// Tests the sound of a live session. It follows the session's clock, however long the program's start took.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "audio/sound_file.h"
#include "engine/session/session_file.h"
#include "tests/support/program.h"

namespace typodont {
namespace {

using test::ProgramFolder;

TEST(LiveSound, TheSoundOfATapIsWithinTwoMillisecondsOfItsTick) {
  const ProgramFolder folder(TYPODONT_PROGRAM);
  const std::string scene = folder.write("scene.json", R"({
    "tissue": {"voxel_mm": 0.2, "solids": [{"tissue": "enamel", "solid": {"box": {"size_mm": [8, 8, 4]}}}]},
    "tool": "explorer", "parts": ["haptics", "sound"]})");
  const std::string hand =
      folder.write("hand.csv",
                   "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,0,0,2.8,1,0,0,0,0\n0.333,0,0,2.8,1,0,0,0,0\n"
                   "0.337,0,0,2,1,0,0,0,0\n0.5,0,0,2,1,0,0,0,0\n");
  // The first start fills caches, and the second start uses them. Neither may shift the sound.
  for (const std::string_view run : {"first", "second"}) {
    const std::string wav = folder / fmt::format("{}.wav", run), session = folder / fmt::format("{}.h5", run);
    expect_ok(folder.run(fmt::format("run {} --hand script:{} --audio wav:{} --record {}", scene, hand, wav, session),
                         "env -u DISPLAY -u WAYLAND_DISPLAY"));
    double felt = -1;
    for (const ServoTick& tick : session::SessionReader(session).ticks())
      if (felt < 0 && glm::length(tick.f_T_W) > 0.05) felt = to_seconds(tick.t);
    ASSERT_GT(felt, 0.3);
    const audio::Recording heard = audio::read_recording(wav);
    const std::vector<double> samples = heard.mono();
    const auto first = std::find_if(samples.begin(), samples.end(), [](double v) { return std::abs(v) > 1e-4; });
    ASSERT_NE(first, samples.end());
    EXPECT_NEAR(static_cast<double>(first - samples.begin()) / heard.rate, felt, 2e-3) << run;
    EXPECT_NEAR(static_cast<double>(samples.size()) / heard.rate, 0.5, 2e-3) << run;
  }
}

TEST(LiveSound, WithAFullDiskForTheSoundTheSessionEndsNormallyAndItsRecordingIsComplete) {
  const ProgramFolder folder(TYPODONT_PROGRAM);
  const std::string scene = folder.write("scene.json", R"({
    "tissue": {"voxel_mm": 0.2, "solids": [{"tissue": "enamel", "solid": {"box": {"size_mm": [8, 8, 4]}}}]},
    "tool": "explorer", "parts": ["haptics", "sound"]})");
  const std::string hand =
      folder.write("hand.csv", "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,0,0,2.8,1,0,0,0,0\n60,0,0,2.8,1,0,0,0,0\n");
  const std::string session = folder / "session.h5";
  // No file may become larger than 500 kB. The sound file reaches this size after 5 s, when the recording is smaller.
  const auto ran =
      folder.run(fmt::format("run {} --hand script:{} --audio wav:{} --record {} --seconds 30'", scene, hand,
                             folder / "sound.wav", session),
                 "bash -c 'ulimit -c 0; ulimit -f 500; trap \"\" XFSZ; exec env -u DISPLAY -u WAYLAND_DISPLAY");
  expect_exit(ran, 1, "sound.wav");
  EXPECT_FALSE(session::SessionReader(session).truncated());
  for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
    EXPECT_EQ(entry.path().string().find(".partial"), std::string::npos) << entry.path();
}

}  // namespace
}  // namespace typodont
