// Tests that work which a scene does not need is not done: `typodont run` counts its work for each kind. Work that the
// picture leaves out (invisible bodies, untouched bricks, frames equal to the previous one) is tested in
// unit/render_frame_test.cpp, and mono in unit/display_layout_test.cpp.
#include <gtest/gtest.h>
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <utility>
#include <vector>

#include "engine/base/error.h"
#include "engine/base/json.h"
#include "engine/session/session_file.h"
#include "tests/support/desktop.h"
#include "tests/support/program.h"

namespace typodont {
namespace {

/// Restricts this process, and the programs that it starts meanwhile, to one processor. The library TBB then starts no
/// threads. On several processors, the number of threads that it starts depends on the machine's load.
class OnOneProcessor {
 public:
  OnOneProcessor() {
    CPU_ZERO(&all_);
    EXPECT_EQ(::sched_getaffinity(0, sizeof all_, &all_), 0);
    int first = 0;
    while (first < CPU_SETSIZE - 1 && !CPU_ISSET(first, &all_)) ++first;
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(first, &one);
    EXPECT_EQ(::sched_setaffinity(0, sizeof one, &one), 0);
  }
  ~OnOneProcessor() { ::sched_setaffinity(0, sizeof all_, &all_); }
  OnOneProcessor(const OnOneProcessor&) = delete;
  OnOneProcessor& operator=(const OnOneProcessor&) = delete;

 private:
  cpu_set_t all_;
};

constexpr double kEnamelDensity = 2.95;  // mg/mm³, as assets/materials/hard_tissue.json has it

class Work : public testing::Test {
 protected:
  /// Writes a scene of a block whose top is at z = 200 mm. `parts`: the parts of the program that the scene switches
  /// on.
  std::string scene(const char* parts, bool cuts = true) {
    return folder.write("scene.json", fmt::format(R"({{"name": "block", "tissue": {{"voxel_mm": 0.25, "solids": [
      {{"tissue": "enamel", "solid": {{"box": {{"center_mm": [25, 0, 196], "size_mm": [10, 10, 8]}}}}}}]}},
      "tool": {{"shape": "sphere", "diameter_mm": 2, "cuts": {}}}, "spindle_krpm": 300, "parts": [{}]}})",
                                                  cuts, parts));
  }
  /// Writes a hand that moves to and fro by `reach_mm` at a constant height. The pedal is up (0) or down (1).
  std::string hand(double height_mm, double reach_mm, double pedal, double seconds = 8) {
    std::string csv = "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n";
    for (double t = 0; t <= seconds; t += 0.02) {
      csv += fmt::format("{},{},0,{},1,0,0,0,{}\n", t, 25 + reach_mm * std::sin(3 * t), height_mm, pedal);
    }
    return folder.write("hand.csv", csv);
  }
  Json run(const std::string& what, double seconds, const std::string& more = "") {
    return all_of(what, seconds, more)["work"];
  }
  /// All that it says of a session.
  Json all_of(const std::string& what, double seconds, const std::string& more = "") {
    const char* audio = more.find("--audio") == std::string::npos ? "--audio none:" : "";
    const test::Ran ran =
        expect_ok(folder.run(fmt::format("run {} --hand script:{} --pedal none {} --seconds {} --json {}", what,
                                         folder / "hand.csv", audio, seconds, more)));
    said = ran.err;
    return Json::parse(ran.out, "run");
  }

  test::ProgramFolder folder{TYPODONT_PROGRAM};
  std::string said;
};

TEST_F(Work, AnIdleHandCausesNoCutNoFrameAndNoAllocation) {
  hand(210, 0, 0);
  const Json brief = run(scene("\"haptics\""), 1.5), lasting = run(scene("\"haptics\""), 4.5);
  EXPECT_GT(lasting["ticks"].number(), 2 * brief["ticks"].number());
  for (const char* kind : {"voxels_cut", "bricks_meshed", "triangles_made", "frames", "passes", "triangles_drawn",
                           "pipelines", "samples", "particles_stepped"}) {
    EXPECT_EQ(lasting[kind].integer(), 0) << kind;
  }
  EXPECT_LE(lasting["patches"].integer(), 2);
  EXPECT_NEAR(lasting["allocations"].number(), brief["allocations"].number(), 20)
      << "three seconds more allocate nothing";
  EXPECT_LT(lasting["bytes_written"].number(), brief["bytes_written"].number() + 4096);
}

TEST_F(Work, AnIdleSceneUsesLessThanOnePercentOfACoreBeyondTheDeviceLoop) {
  hand(210, 0, 0);
  const auto beyond_the_loop = [&](double seconds) {
    const Json work = run(scene("\"haptics\""), seconds);
    return work["cpu_s"].number() - work["servo_cpu_s"].number();
  };
  // The work at the start is the same in both runs, so the difference does not contain it. The smallest of five values
  // is used, because other work on the machine can only make a run slower.
  double fraction = 1;
  for (int i = 0; i < 5 && fraction >= 0.01; ++i)
    fraction = std::min(fraction, (beyond_the_loop(5) - beyond_the_loop(1)) / 4);
  EXPECT_LT(fraction, 0.01);
}

TEST_F(Work, ANonCuttingToolIsFeltAndDoesNotChangeTheTissue) {
  hand(200.8, 2, 1);
  const Json probe = run(scene("\"haptics\"", false), 2);
  EXPECT_EQ(probe["voxels_cut"].integer(), 0);
  EXPECT_GT(probe["queries"].number(), probe["ticks"].number()) << "it is in touch";
  const Json drill = run(scene("\"haptics\"", true), 2);
  EXPECT_GT(drill["voxels_cut"].integer(), 0);
}

TEST_F(Work, OnlyTheSelectedContactModelIsCreatedAndComputed) {
  const OnOneProcessor makes_the_number_of_threads_constant;
  hand(200.8, 2, 0);
  const std::map<std::string, std::string> looks{
      {"packing", "sphere_looks"}, {"mesh_lod", "triangle_looks"}, {"vertex", "vertex_looks"}};
  const auto session = [&](const std::string& model) { return run(scene("\"haptics\"") + " --model " + model, 0.5); };
  const Json plain = session("offset");
  EXPECT_GT(plain["queries"].integer(), 100) << "queries of the field";
  for (const char* model : {"offset", "packing", "mesh_lod", "vertex"}) {
    const Json work = std::string(model) == "offset" ? plain : session(model);
    for (const std::string& other : work["models"].keys()) {
      EXPECT_EQ(work["models"][other]["models"].integer(), other == model) << other << " beside " << model;
      EXPECT_EQ(work["models"][other]["bodies"].integer(), other == model) << other << " beside " << model;
    }
    for (const auto& [other, counter] : looks) EXPECT_EQ(work[counter].integer() > 0, other == model) << model;
    // A model may start threads to make its tissue. A model that is not chosen must not start any.
    EXPECT_LE(plain["threads"].integer(), work["threads"].integer()) << model;
    // The model mesh_lod loads the library meshoptimizer if it is installed.
    const auto own_libraries = work["libraries"].integer() - plain["libraries"].integer();
    EXPECT_GE(own_libraries, 0) << model;
    EXPECT_LE(own_libraries, std::string(model) == "mesh_lod") << model;
  }
}

TEST_F(Work, SoundIsSynthesizedOnlyIfRequestedAndARecordingAddsOneThread) {
  const OnOneProcessor makes_the_number_of_threads_constant;
  hand(210, 0, 0);
  const std::string a_file = "--audio wav:" + (folder / "s.wav");
  const Json silent = run(scene("\"haptics\""), 1, a_file),
             recorded = run(scene("\"haptics\""), 1, a_file + " --record " + (folder / "s.h5"));
  EXPECT_EQ(silent["samples"].integer(), 0) << "there is an output, but the scene names no sound";
  EXPECT_EQ(recorded["threads"].integer(), silent["threads"].integer() + 1);
  EXPECT_GT(recorded["bytes_written"].number(), silent["bytes_written"].number() + 10'000);
  const Json heard = run(scene("\"haptics\", \"sound\""), 1, a_file);
  EXPECT_GT(heard["samples"].number(), 20'000);
}

TEST_F(Work, ActivePartsAreListedWithTheReasonForEveryInactiveOne) {
  hand(210, 0, 0);
  run(scene("\"haptics\""), 1, "--explain");
  for (const char* words : {"queries of the field", "voxels re-distanced", "bricks meshed", "libraries loaded",
                            "of a core beyond the device's loop", "recording: off",
                            "sound: off, the scene does not name it", "debris: off"}) {
    EXPECT_NE(said.find(words), std::string::npos) << words << "\n" << said;
  }
}

#ifdef TYPODONT_WINDOW
/// Returns the times at which the frames of a recorded session were drawn. The file may still be recorded. Returns an
/// empty list if there is no such file yet.
std::vector<Nanos> drawn_in(const std::string& file) {
  try {
    const session::SessionReader session(file);
    const auto& streams = session.header().streams;
    const auto picture =
        std::find_if(streams.begin(), streams.end(), [](const auto& stream) { return stream.name == "picture"; });
    if (picture != streams.end()) return session.streams()[static_cast<std::size_t>(picture - streams.begin())].t;
  } catch (const Error&) {  // not there yet
  }
  return {};
}

/// Returns the rig of a small window. The middle of its screen is at (x, 0, 200) mm, and the eyes look at it from
/// above.
std::string rig_at(double x_mm, double half_mm = 20, const char* layout = "mono") {
  return fmt::format(R"({{"display": "window", "screen": {{"corners_mm": {{"lower_left": [{}, {}, 200],
    "lower_right": [{}, {}, 200], "upper_left": [{}, {}, 200]}}, "pixels": [320, 240], "layout": "{}"}},
    "head": {{"eye_center_mm": [{}, 0, 500], "ipd_mm": 63}}}})",
                     x_mm - half_mm, -0.75 * half_mm, x_mm + half_mm, -0.75 * half_mm, x_mm - half_mm, 0.75 * half_mm,
                     layout, x_mm);
}

TEST_F(Work, AWindowWithoutMotionIsNotRedrawnAndSendsNoRequests) {
  hand(208, 0, 0, 60);
  const test::Desktop desktop;
  const auto session = [&](double seconds) {
    return run(
        fmt::format("{} --rig {}", scene("\"haptics\", \"render\", \"debris\""), folder.write("rig.json", rig_at(25))),
        seconds, "--record " + (folder / "s.h5"));
  };
  const Json brief = session(5);
  const std::vector<Nanos> first = drawn_in(folder / "s.h5");
  const Json lasting = session(11);
  const std::vector<Nanos> drawn = drawn_in(folder / "s.h5");
  ASSERT_FALSE(first.empty() || drawn.empty()) << said;
  ASSERT_GT(lasting["triangles_drawn"].integer(), 0) << "the block is seen";
  // In the first seconds the picture is drawn and then refined where possible. Afterwards nothing is drawn.
  EXPECT_LT(to_seconds(drawn.back()), 5) << drawn.size() << " frames";
  EXPECT_LT(drawn.size(), 40u);
  const auto more = [&](const char* kind) { return lasting[kind].integer() - brief[kind].integer(); };
  EXPECT_LT(more("desktop_requests"), 30) << "of some 240 looks at it";
  EXPECT_LT(more("turns"), 6 * 50) << "it is looked at forty times a second, at most";
  EXPECT_LT(more("allocations"), 40 * more("turns")) << "a line of writing is put together, nothing more";
}

TEST_F(Work, ExplainStatesTheGpuTimeOfEachPassAndTheLateFramesOfAWindow) {
  hand(200.8, 2, 1);
  const test::Desktop desktop;
  run(fmt::format("{} --rig {}", scene("\"haptics\", \"render\""), folder.write("rig.json", rig_at(25))), 3,
      "--explain");
  for (const char* words : {"GPU memory in use: ", "late frames: ", " of 1,000", "GPU time, whole frame: median ",
                            "GPU time, shadow: median ", "GPU time, tissue: median ", "GPU time, picture: median "})
    EXPECT_NE(said.find(words), std::string::npos) << words << "\n" << said;
}

TEST_F(Work, ParticlesAreSimulatedOnlyAfterACutInASceneWithDebrisAndHaveTheMassOfTheCut) {
  const test::Desktop desktop;
  const auto session = [&](const char* parts, double height_mm) {
    hand(height_mm, 2, 1);
    return all_of(fmt::format("{} --rig assets/rigs/window.json", scene(parts)), 3);
  };
  const Json without = session("\"haptics\", \"render\"", 200.8);
  EXPECT_EQ(without["work"]["particles_stepped"].integer(), 0);
  EXPECT_FALSE(without.has("debris"));
  EXPECT_EQ(session("\"haptics\", \"render\", \"debris\"", 210)["work"]["particles_stepped"].integer(), 0);
  const Json cut = session("\"haptics\", \"render\", \"debris\"", 200.8), mass = cut["debris"];
  EXPECT_GT(cut["work"]["particles_stepped"].integer(), 0);
  ASSERT_GT(cut["removed_mm3"].number(), 0);
  ASSERT_EQ(mass["events_lost"].integer(), 0);
  const double born = mass["born_mg"]["enamel"].number();
  EXPECT_NEAR(born, kEnamelDensity * cut["removed_mm3"].number(), 1e-6 * born);
  EXPECT_NEAR(mass["in_the_air_mg"].number() + mass["decayed_mg"].number() + mass["sucked_mg"].number() +
                  mass["no_room_mg"].number(),
              born, 1e-5 * born);
}

TEST_F(Work, WaterIsComputedOnlyInASceneWithSprayWhileThePedalIsPressedAndItsBalanceHolds) {
  const test::Desktop desktop;
  const auto session = [&](const std::string& keys, double pedal, const std::string& more = "") {
    hand(200.8, 2, pedal);
    std::string text = test::read_text(scene("\"haptics\", \"render\", \"debris\""));
    const std::string ideal = "\"spindle_krpm\": 300";
    text.replace(text.find(ideal), ideal.size(), "\"spindle\": \"air_turbine\"" + keys);
    return all_of(fmt::format("{} --rig assets/rigs/window.json", folder.write("wet.json", text)), 3, more);
  };
  const std::string spray = R"(, "spray": {"flow_ml_per_min": 20})";
  for (const Json& dry : {session("", 1), session(spray, 0)})
    for (const char* kind : {"droplets_stepped", "film_cells_stepped", "film_texels"})
      EXPECT_EQ(dry["work"][kind].integer(), 0) << kind;
  // A second hand holds its tip at (23, 0, 202) mm, and not at the place that the scene gives.
  const std::string left = folder.write("left.csv",
                                        "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,23,0,202,1,0,0,0,0\n"
                                        "9,23,0,202,1,0,0,0,0\n");
  const Json wet = session(spray + R"(, "suction": {"position_mm": [27, 0, 202], "tip": "surgical"})", 1,
                           fmt::format("--left-hand script:{} --record {} --explain", left, folder / "wet.h5"));
  EXPECT_NE(said.find("left hand, with the suction"), std::string::npos) << said;
  const session::SessionReader recorded(folder / "wet.h5");
  const auto column = [&](const char* stream, std::size_t index) {
    const auto& specs = recorded.header().streams;
    for (std::size_t i = 0; i < specs.size(); ++i)
      if (specs[i].name == stream) return recorded.streams()[i].columns[index];
    return std::vector<double>{};
  };
  EXPECT_EQ(column("water", 0), std::vector<double>{1});
  EXPECT_EQ(column("water", 1), std::vector<double>{1});
  ASSERT_FALSE(column("left_hand", 0).empty());
  EXPECT_DOUBLE_EQ(column("left_hand", 0).back(), 23e-3);
  for (const char* kind : {"droplets_stepped", "film_cells_stepped", "film_texels"})
    EXPECT_GT(wet["work"][kind].integer(), 0) << kind;
  const auto water = [&](const char* part, const char* entry) {
    return wet["debris"][part][entry]["water_mg"].number();
  };
  const double sprayed = water("spray", "sprayed");
  EXPECT_GT(sprayed, 0);
  EXPECT_NEAR(water("spray", "in_the_air") + water("spray", "sucked") + water("spray", "left") +
                  water("spray", "no_room") + water("film", "on_surface") + water("film", "sucked") +
                  water("film", "run_off") + wet["debris"]["film"]["dried_mg"].number(),
              sprayed, 1e-9 * sprayed);
  EXPECT_GT(water("film", "sucked"), 0);
}

TEST_F(Work, AnInvisibleToothIsCutButNotMeshedOrDrawn) {
  hand(200.8, 2, 1);
  const test::Desktop desktop;
  const auto session = [&](const std::string& scene_file, double screen_mm) {
    return run(fmt::format("{} --rig {} --save {}", scene_file, folder.write("rig.json", rig_at(screen_mm)),
                           folder / "cut.vdb"),
               3);
  };
  const std::string plain = scene("\"haptics\", \"render\"");
  const Json away = session(plain, 225);
  EXPECT_GT(away["voxels_cut"].integer(), 0);
  EXPECT_GT(away["frames"].integer(), 0) << "the writing";
  for (const char* kind : {"bricks_meshed", "triangles_made", "triangles_drawn", "bricks_skipped"})
    EXPECT_EQ(away[kind].integer(), 0) << kind;
  // The cuts that were made meanwhile, outside the picture, must be in the volume and in every mesh that is made of it.
  const std::string exported = folder / "cut.ply", sound = folder / "sound.ply";
  ASSERT_EQ(folder.run(fmt::format("mesh {} --out {}", folder / "cut.vdb", exported)).status, 0);
  ASSERT_EQ(folder.run(fmt::format("mesh {} --out {}", plain, sound)).status, 0);
  EXPECT_NE(test::read_text(exported), test::read_text(sound));
  const Json seen = session(plain, 25);
  for (const char* kind : {"bricks_meshed", "triangles_made", "passes", "pipelines", "triangles_drawn"})
    EXPECT_GT(seen[kind].integer(), 0) << kind;
  // A mouth mirror in the middle of the other screen is turned so that it shows the block, which is 200 mm beside it.
  std::string mirrored = test::read_text(plain);
  mirrored.insert(
      1, R"("mouth_mirror": {"translation_mm": [225, 0, 200], "normal": [-0.7071, 0, 0.7071], "diameter_mm": 22}, )");
  const Json reflected = session(folder.write("mirrored.json", mirrored), 225);
  EXPECT_GT(reflected["bricks_meshed"].integer(), 0);
  EXPECT_GT(reflected["triangles_drawn"].integer(), 0);
}

TEST_F(Work, NeighbourTeethAreMeshedOnlyOnce) {
  const test::Desktop desktop;
  // The eyes are so far away that everything is drawn at the coarsest level all the time. So no brick is meshed again
  // at a finer level.
  const std::string rig = folder.write("rig.json", rig_at(25, 200));
  const std::string row = folder.write("row.json", R"({"name": "row", "tissue": {"voxel_mm": 0.25, "solids": [
    {"tissue": "enamel", "solid": {"box": {"center_mm": [25, 0, 196], "size_mm": [10, 10, 8]}}},
    {"tissue": "enamel", "solid": {"sphere": {"center_mm": [-5, 0, 196], "radius_mm": 18}}},
    {"tissue": "enamel", "solid": {"sphere": {"center_mm": [55, 0, 196], "radius_mm": 18}}}]},
    "tool": {"shape": "sphere", "diameter_mm": 1}, "spindle_krpm": 300, "parts": ["haptics", "render"]})");
  const auto meshed = [&](double height_mm) {
    hand(height_mm, 0.2, 1);
    const Json work = run(fmt::format("{} --rig {}", row, rig), 2);
    EXPECT_EQ(work["voxels_cut"].integer() > 0, height_mm < 201);
    return work["bricks_meshed"].number();
  };
  const double untouched = meshed(210), cut = meshed(200.4);
  EXPECT_GT(untouched, 500);
  EXPECT_GT(cut, untouched);
  EXPECT_LT(cut, 1.9 * untouched);
}

TEST_F(Work, AMinimisedWindowDrawsNoFrameUntilItIsRestored) {
  hand(208, 8, 1, 120);  // to and fro before the eyes: every frame differs from the last
  folder.write("rig.json", rig_at(25));
  const test::Desktop desktop;
  const pid_t child = folder.start(
      fmt::format("run {} --rig {} --hand script:{} --pedal none --audio none: --record {}",
                  scene("\"haptics\", \"render\""), folder / "rig.json", folder / "hand.csv", folder / "s.h5"),
      fmt::format("DISPLAY={}", std::getenv("DISPLAY")));
  std::string window;
  for (int i = 0; i < 1800 && window.empty(); ++i, ::usleep(100'000))
    window = test::Desktop::xdotool("search --name Typodont");
  window = window.substr(0, window.find('\n'));
  ASSERT_FALSE(window.empty()) << folder.said();
  // Counts the frames in the recording. The file is half a second behind the session, whatever other work the machine
  // does.
  const auto drawn_so_far = [&] { return drawn_in(folder / "s.h5").size(); };
  const auto drawn_after = [&](std::size_t frames) {
    for (int i = 0; i < 1200 && drawn_so_far() <= frames; ++i) ::usleep(100'000);
    return drawn_so_far() > frames;
  };
  ASSERT_TRUE(drawn_after(3)) << folder.said();
  test::Desktop::xdotool("windowunmap " + window);
  std::size_t until_then = drawn_so_far();
  bool rests = false;
  for (int i = 0; i < 60 && !rests; ++i) {
    ::usleep(2'000'000);
    const std::size_t before = std::exchange(until_then, drawn_so_far());
    rests = before == until_then;
  }
  EXPECT_TRUE(rests) << "two seconds without a frame, of a hand that goes to and fro";
  test::Desktop::xdotool("windowmap " + window);
  EXPECT_TRUE(drawn_after(until_then + 3)) << "drawn again";
  EXPECT_EQ(folder.finish(child).status, 0) << folder.said();
}
#endif

}  // namespace
}  // namespace typodont
