// Tests how the commands treat recordings that are damaged, come from other persons, have gaps, or could not be
// written.
#include <gmock/gmock.h>

#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "engine/base/json.h"
#include "engine/session/recorder.h"
#include "engine/session/session_file.h"
#include "tests/support/hdf5_edit.h"
#include "tests/support/program.h"

namespace typodont {
namespace {

using namespace test;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kScene = R"({"name": "ball", "tissue": {"voxel_mm": 0.2, "solids": [
  {"tissue": "enamel", "solid": {"sphere": {"radius_mm": 3}}}]},
  "tool": {"shape": "sphere", "diameter_mm": 1.0}, "spindle_krpm": 200})";
constexpr const char* kHand =
    "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,0,0,5,1,0,0,0,1\n0.3,0,0,3,1,0,0,0,1\n1.5,1,0,2.8,1,0,0,0,1\n"
    "2,1,0,6,1,0,0,0,1\n";

/// A recording of one and a half seconds of drilling, made by the program itself.
class Recordings : public testing::Test {
 protected:
  Recordings() {
    folder.write("scene.json", kScene);
    folder.write("hand.csv", kHand);
    expect_ok(folder.run("servo {}/scene.json --hand {}/hand.csv --out {}/s.h5"));
    std::filesystem::copy_file(file, folder / "good.h5");
  }
  Ran check() { return folder.run("replay {}/s.h5 --check"); }

  /// Changes a copy of the good recording.
  template <class Work>
  void change(Work&& work) {
    std::filesystem::copy_file(folder / "good.h5", file, std::filesystem::copy_options::overwrite_existing);
    change_hdf5(file, work);
  }
  void set_text(const char* path, const std::string& text) {
    change([&](hid_t h5) {
      H5Ldelete(h5, path, H5P_DEFAULT);
      const hid_t type = H5Tcopy(H5T_C_S1), space = H5Screate(H5S_SCALAR);
      H5Tset_size(type, text.size());
      H5Tset_cset(type, H5T_CSET_UTF8);
      const hid_t dataset = H5Dcreate2(h5, path, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
      H5Dwrite(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, text.data());
      H5Dclose(dataset), H5Sclose(space), H5Tclose(type);
    });
  }
  template <class T>
  void set(const char* path, hsize_t row, T value) {
    change([](hid_t) {});
    set_hdf5(file, path, row, value);
  }
  /// Writes the same session without these ticks and cuts, as after a full disk.
  void leave_out(std::uint64_t first_tick, std::uint64_t ticks) {
    const session::SessionReader whole(folder / "good.h5");
    session::SessionWriter writer(file, whole.header());
    const auto kept = [&](std::uint64_t tick) { return tick < first_tick || tick >= first_tick + ticks; };
    for (const PatchUse& patch : whole.patches())
      if (kept(patch.first_tick)) writer.append({&patch, 1});
    for (const Cut& cut : whole.cuts())
      if (kept(cut.tick)) writer.append({&cut, 1});
    for (const ServoTick& tick : whole.ticks())
      if (kept(tick.index)) writer.append({&tick, 1});
    ASSERT_TRUE(writer.finish(*whole.result()));
  }

  ProgramFolder folder{TYPODONT_PROGRAM};
  const std::filesystem::path file = folder / "s.h5";
};

TEST_F(Recordings, AReplayWithChangedSettingsStatesWhatWasComparedWithWhat) {
  const std::string command = fmt::format("replay {} --with '{{\"friction\": false}}' --check", file.string());
  const Ran ran = expect_ok(folder.run(command));
  EXPECT_THAT(ran.out, HasSubstr("the same hand with the changed settings of --with, compared with the recording:\n"));
  EXPECT_THAT(ran.out, HasSubstr("replayed with its own settings, without those of --with: "));
  EXPECT_THAT(ran.out, HasSubstr("\nwithout --with: identical to the recording\n"));
  const Ran json = expect_ok(folder.run(command + " --json"));
  const Json both = Json::parse(json.out, "both");
  EXPECT_TRUE(both["replay_without_with"]["identical"].boolean());
  EXPECT_TRUE(both.find("force_N"));
}

TEST_F(Recordings, ThatStateAnotherForceLawOrNoneAreNotReplayedButTheirHandIsRunAgainWithTodaysLaw) {
  const auto state_law = [&](const char* name, std::uint64_t law) {
    change([&](hid_t h5) {
      EXPECT_GE(H5Adelete(h5, "force_law"), 0);
      const hid_t space = H5Screate(H5S_SCALAR),
                  made = H5Acreate2(h5, name, H5T_NATIVE_UINT64, space, H5P_DEFAULT, H5P_DEFAULT);
      H5Awrite(made, H5T_NATIVE_UINT64, &law);
      H5Aclose(made), H5Sclose(space);
    });
  };
  const std::string sentence = "made with another force law";
  // "servo_laws" is the attribute of recordings from before version 1.0.
  for (const auto& [name, law] : {std::pair{"force_law", kForceLaw + 1ull},
                                  std::pair{"force_law", (1ull << 32) + kForceLaw}, std::pair{"servo_laws", 1ull}}) {
    state_law(name, law);
    expect_exit(check(), 1, sentence);
  }
  const Ran ran = expect_ok(folder.run("replay {}/s.h5 --json"));
  const Json said = Json::parse(ran.out, "replay");
  EXPECT_FALSE(said["identical"].boolean());
  EXPECT_FALSE(said["same_force_law"].boolean());
  // The recording was in truth made with today's law, so the hand feels the same force and removes the same volume.
  EXPECT_EQ(said["with_todays_law"]["force_N"]["off_max"].number(), 0);
  EXPECT_GT(said["with_todays_law"]["removed_mm3"]["now"].number(), 0.05);
  EXPECT_THAT(said["difference"].string(), HasSubstr("0.000 N at most"));
  EXPECT_EQ(folder.run("report {}/s.h5 --out {}/r.html --language en").status, 0);
  EXPECT_THAT(read_text(folder / "r.html"), HasSubstr(sentence));
}

TEST_F(Recordings, AForgedValueIsDetectedInEveryStreamUsedForTheScore) {
  const session::SessionReader whole(folder / "good.h5");
  ASSERT_GT(whole.cuts().size(), 100u);
  const hsize_t cut = 50, tick = 900;
  const auto expect = [&](const char* path, hsize_t row, double value, const std::string& words) {
    set(path, row, value);
    expect_exit(check(), 1, words);
  };
  expect("cuts/b_x_m", cut, whole.cuts()[cut].X_WB.p.x + 1e-9, "b_x_m of cut 51");
  expect("cuts/removed_enamel_m3", cut, 0, "removed_enamel_m3 of cut 51");
  expect("ticks/removed_enamel_mm3", tick, 0.001, "removed_enamel_mm3 at tick 900");
  expect("ticks/force_z_N", tick, 0.5, "force at tick 900");
  expect("ticks/depth_mm", tick, 0.5, "depth_mm at tick 900");
  expect("ticks/contact_area_mm2", tick, 0.5, "contact_area_mm2 at tick 900");
  expect("ticks/tool_x_mm", tick, 0.5, "tool_x_mm at tick 900");
  expect("ticks/spindle_krpm", tick, 1, "spindle_krpm at tick 900");
  expect("header/volumes_before_mm3", 1, 200, "the volume of enamel at the start");
  expect("result/volumes_after_mm3", 1, 50, "the volume of enamel at the end");
}

TEST_F(Recordings, TimesThatAreCompressedInTheAirDoNotChangeTheScore) {
  std::vector<std::int64_t> times;
  for (const ServoTick& tick : session::SessionReader(folder / "good.h5").ticks()) times.push_back(tick.t);
  const std::size_t lifted = times.size() - 200;  // the tool has left the tissue
  for (std::size_t i = lifted; i < times.size(); ++i) times[i] = times[lifted] + (times[i] - times[lifted]) / 10;
  change([&](hid_t h5) {
    const hid_t dataset = H5Dopen2(h5, "ticks/t_ns", H5P_DEFAULT);
    EXPECT_GE(H5Dwrite(dataset, H5T_NATIVE_INT64, H5S_ALL, H5S_ALL, H5P_DEFAULT, times.data()), 0);
    H5Dclose(dataset);
  });
  const auto items = [&](const char* session) {
    const Ran ran =
        expect_ok(folder.run(fmt::format("report {{}}/{} --verify --json --out {{}}/r.html --language en", session)));
    std::map<std::string, double> values;
    for (const Json& item : Json::parse(ran.out, "report")["items"].items())
      if (item["value"].is_number()) values[item["name"].string()] = item["value"].number();
    return values;
  };
  const auto forged = items("s.h5"), honest = items("good.h5");
  EXPECT_NEAR(honest.at("time_s"), 2, 0.002);
  EXPECT_EQ(forged, honest);
  const std::string page = read_text(folder / "r.html");
  EXPECT_THAT(page, HasSubstr(">replay, number of ticks and servo rate</td>"));
  EXPECT_THAT(page, HasSubstr(">replay of tissue and forces</td>"));
  EXPECT_THAT(page, HasSubstr(">nothing but a signature: the recorded hand</td>"));
}

TEST_F(Recordings, AForgedServoRateIsDetected) {
  for (const double rate : {500.0, 1040.0}) {
    change([&](hid_t h5) {
      const hid_t attribute = H5Aopen(h5, "servo_rate_Hz", H5P_DEFAULT);
      EXPECT_GE(H5Awrite(attribute, H5T_NATIVE_DOUBLE, &rate), 0);
      H5Aclose(attribute);
    });
    expect_exit(check(), 1, "differs");
  }
}

TEST_F(Recordings, AReportSaysWhetherTheFileWasChecked) {
  const auto report = [&](const std::string& more) {
    return folder.run("report {}/s.h5 --out {}/r.html --language en " + more);
  };
  EXPECT_EQ(report("").status, 0);
  EXPECT_THAT(read_text(folder / "r.html"), HasSubstr("no: the score trusts this file"));
  EXPECT_EQ(report("--verify").status, 0);
  EXPECT_THAT(read_text(folder / "r.html"), HasSubstr("yes, identical in every column"));
  set("cuts/removed_enamel_m3", 50, 0.0);
  expect_exit(report("--verify"), 1, "the replay differs: removed_enamel_m3 of cut 51");
  EXPECT_THAT(read_text(folder / "r.html"), HasSubstr("differs from this recording: removed_enamel_m3 of cut 51"));
}

TEST_F(Recordings, ATextOfARecordingIsNoFormulaOfASpreadsheetAndNoFolderOfAUserStandsInAReport) {
  std::filesystem::create_directories(folder / "school");
  folder.write("school/=1+1.json", std::string(kScene).replace(9, 6, R"("=1+1")"));
  expect_ok(folder.run("servo {}/school/=1+1.json --hand {}/hand.csv --out {}/school/s.h5"));
  ASSERT_EQ(folder.run("rescore {}/school --out {}/t.csv").status, 0);
  EXPECT_THAT(read_text(folder / "t.csv"), AllOf(HasSubstr(",'=1+1,"), Not(HasSubstr(",=1+1"))));
  ASSERT_EQ(folder.run("report {}/school/s.h5 --out {}/r.html").status, 0);
  EXPECT_THAT(read_text(folder / "r.html"), AllOf(HasSubstr("hand.csv"), Not(HasSubstr(folder.path().string()))));
}

TEST_F(Recordings, CutsInsertedFromAnotherSessionAreDetected) {
  folder.write("hand.csv",
               "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,0,0,5,1,0,0,0,1\n0.3,0,0,3,1,0,0,0,1\n2,-1,0,2.5,1,0,0,0,1\n");
  ASSERT_EQ(folder.run("servo {}/scene.json --hand {}/hand.csv --out {}/other.h5").status, 0);
  const session::SessionReader own(folder / "good.h5"), other(folder / "other.h5");
  {
    session::SessionWriter writer(file, own.header());
    writer.append(own.patches());
    std::size_t cuts = 0;
    while (cuts < other.cuts().size() && other.cuts()[cuts].index <= own.cuts().back().index) ++cuts;
    writer.append(std::span(other.cuts()).first(cuts));
    writer.append(own.ticks());
    ASSERT_TRUE(writer.finish(*own.result()));
  }
  expect_exit(check(), 1, "of cut");
}

TEST_F(Recordings, EveryCommandExitsWithTwoOnDamagedNumbers) {
  const std::vector<std::function<void()>> damages = {
      [&] { set("cuts/index", 20, std::uint64_t{3}); },
      [&] { set("cuts/fill_radius_m", 20, 0.4); },
  };
  for (const auto& damage : damages) {
    damage();
    for (const std::string command : {"report {}/s.h5 --out {}/r.html", "replay {}/s.h5 --check",
                                      "render {}/s.h5 --rig closeup --at 1 --out {}/pictures",
                                      "run {}/scene.json --resume {}/s.h5 --hand script:{}/hand.csv --seconds 0.2"}) {
      expect_exit(folder.run(command, "timeout 20 env -u DISPLAY"), 2, "cuts, row 20");
    }
  }
}

TEST_F(Recordings, AGapIsReportedAndTheDataBeforeAndAfterItAreShown) {
  leave_out(600, 400);
  expect_ok(folder.run("report {}/s.h5 --out {}/r.html --language en"));
  EXPECT_THAT(read_text(folder / "r.html"), HasSubstr("The recording has gaps: 0.599 s to 1.000 s (400 ticks, "));
  expect_exit(check(), 1, "what follows tick 599 is not checked");
  expect_ok(folder.run("run {}/scene.json --resume {}/s.h5 --hand script:{}/hand.csv --seconds 0.2",
                       "env -u DISPLAY -u WAYLAND_DISPLAY"));
}

TEST_F(Recordings, AForeignRecordingOpensNoFileOutsideItsFolder) {
  const ProgramFolder elsewhere(TYPODONT_PROGRAM);
  const std::string secret = elsewhere.write("secret.json", "{\"secret\": \"the patient's name\"}");
  std::filesystem::create_symlink(secret, folder / "linked.json");
  const std::string scene = kScene;
  const std::string up = std::filesystem::relative(secret, folder.path()).string();
  for (const std::string& path : {secret, std::string("/etc/passwd"), up, std::string("linked.json")}) {
    set_text("header/scene", scene.substr(0, scene.size() - 1) + ", \"paint_file\": \"" + path + "\"}");
    expect_exit(check(), 2, "a recording that names a file outside its folder");
    const Ran report = folder.run("report {}/s.h5 --out {}/r.html");
    EXPECT_THAT(report.err + read_text(folder / "r.html"), Not(HasSubstr("patient"))) << path;
  }
  // The option lets a user who knows where the files are replay such a recording.
  const Ran allowed = folder.run("replay {}/s.h5 --check", "env TYPODONT_FILES=" + elsewhere.path().string());
  EXPECT_THAT(allowed.err, Not(HasSubstr("outside its folder")));
}

TEST_F(Recordings, ARecordingThatResumesFromItselfIsRefused) {
  const std::string scene = kScene;
  set_text("header/scene", scene.substr(0, scene.size() - 1) + ", \"resume\": \"s.h5\"}");
  expect_exit(folder.run("replay {}/s.h5 --check", "timeout 60"), 2, "recordings that name each other");
}

TEST_F(Recordings, AFileSizeLimitEndsTheRecordingButNotTheSession) {
  const Ran ran =
      folder.run("run {}/scene.json --hand script:{}/hand.csv --seconds 3 --audio none: --record {}/live.h5 --json",
                 "ulimit -f 160; env -u DISPLAY -u WAYLAND_DISPLAY");
  expect_exit(ran, 1, "File too large");
  EXPECT_THAT(ran.err, HasSubstr("the session goes on, unrecorded"));
  EXPECT_FALSE(session::SessionReader(folder / "live.h5").result());
}

}  // namespace
}  // namespace typodont
