// Tests `typodont report` and `typodont doctor` through the command line, and a film that the real encoder writes.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cstdio>
#include <fstream>
#include <iterator>

#include "engine/base/json.h"
#include "engine/session/film.h"
#include "engine/session/recorder.h"
#include "engine/session/score.h"
#include "tests/support/program.h"
#include "tests/support/session_fixture.h"

namespace typodont::session {
namespace {

using namespace test;
using testing::HasSubstr;
using typodont::test::ProgramFolder;
using typodont::test::Ran;

void record(const std::filesystem::path& file) {
  SessionHeader header = some_header();
  header.volumes_before[3] = 10e-9;
  SessionWriter writer(file, header);
  writer.append(random_ticks(2500, 71));
  ASSERT_TRUE(writer.finish({}));
}

TEST(ReportCommand, MakesAPageAndPrintsTheScore) {
  ProgramFolder folder(TYPODONT_PROGRAM);
  record(folder / "s.h5");
  const Ran ran = expect_ok(folder.run("report {}/s.h5 --out {}/r.html --language de --json"));
  const Json json = Json::parse(ran.out, "out");
  EXPECT_EQ(json["ticks"].integer(), 2500);
  EXPECT_FALSE(json["truncated"].boolean());
  double sum = 0, full = 0;
  for (const Json& item : json["items"].items()) sum += item["points"].number(), full += item["full"].number();
  EXPECT_NEAR(sum * json["completion"].number(), json["points"].number(), 1e-9);
  EXPECT_NEAR(full, 100, 1e-9);
  EXPECT_EQ(json["full"].number(), 100);
  EXPECT_EQ(json["passed"].boolean(), json["points"].number() >= json["pass_mark"].number());
  EXPECT_THAT(read_text(folder / "r.html"), HasSubstr("<html lang=\"de\">"));
}

TEST(ReportCommand, BadInputExitsWithTwoAndFoundAndExpectedAndWritesNoPage) {
  ProgramFolder folder(TYPODONT_PROGRAM);
  std::ofstream(folder / "garbage.h5") << "not a session";
  record(folder / "s.h5");
  const auto expect_refused = [&](const std::string& arguments, const std::string& message) {
    const Ran ran = expect_exit(folder.run("report " + arguments), 2, message);
    EXPECT_EQ(ran.out, "");
  };
  expect_refused("{}/none.h5 --out {}/r.html", "none.h5: found No such file or directory, expected a session (.h5)");
  expect_refused("{}/garbage.h5 --out {}/r.html", "garbage.h5: found no intact HDF5 file");
  expect_refused("{}/s.h5 --out /nowhere/r.html", "/nowhere/r.html: found No such file or directory");
  expect_refused("{}/s.h5 --out {}/r.html --language tlh", "--language: found tlh, expected en, de or zh");
  expect_refused("{}/s.h5 --out {}/r.html --picture before={}/s.h5", "s.h5: found something else, expected a PNG");
  expect_refused("{}/s.h5", "--out is required");
  EXPECT_FALSE(std::filesystem::exists(folder / "r.html"));
}

TEST(ReportCommand, AFolderGivesTheLearningCurveOfItsSessions) {
  ProgramFolder folder(TYPODONT_PROGRAM);
  std::filesystem::create_directories(folder / "sessions");
  std::filesystem::create_directories(folder / "empty");
  record(folder / "sessions/a.h5");
  record(folder / "sessions/b.h5");
  std::ofstream(folder / "sessions/c.h5") << "not a session";
  const Ran ran = expect_ok(folder.run("report {}/sessions --out {}/r.html --json"));
  EXPECT_EQ(Json::parse(ran.out, "out")["sessions"].items().size(), 2u);
  EXPECT_THAT(ran.err, HasSubstr("left out: "));
  EXPECT_THAT(ran.err, HasSubstr("c.h5: found no intact HDF5 file"));
  EXPECT_THAT(read_text(folder / "r.html"), HasSubstr("b.h5"));
  expect_exit(folder.run("report {}/empty --out {}/none.html"), 2,
              "found a folder without sessions, expected sessions (.h5)");
}

TEST(ReportCommand, AFoldersSubfoldersCountAndEqualFileNamesInThemDiffer) {
  ProgramFolder folder(TYPODONT_PROGRAM);
  for (const char* trainee : {"class/bo", "class/ada", "class/.unkept"}) {
    std::filesystem::create_directories(folder.path() / trainee);
    record(folder.path() / trainee / "s.h5");
  }
  std::filesystem::create_directory_symlink(folder / "class", folder / "class/ada/loop");
  const Ran ran = expect_ok(folder.run("report {}/class/ --out {}/r.html --json"));
  std::vector<std::string> files;
  const Json result = Json::parse(ran.out, "out");
  for (const Json& session : result["sessions"].items()) files.push_back(session["file"].string());
  EXPECT_THAT(files, testing::ElementsAre("ada/s.h5", "bo/s.h5"));
  EXPECT_THAT(read_text(folder / "r.html"), testing::AllOf(HasSubstr(">ada/s.h5<"), HasSubstr(">bo/s.h5<")));
  EXPECT_THAT(read_text(folder / "r.html"), testing::Not(HasSubstr(folder.path().string())));
}

TEST(ReportCommand, TheTerminalThePageAndTheCommandRescoreRoundPointsDownAlike) {
  ProgramFolder folder(TYPODONT_PROGRAM);
  record(folder / "s.h5");
  const auto report = [&](const std::string& more) {
    return expect_ok(folder.run("report {}/s.h5 --out {}/r.html --language en " + more)).out;
  };
  const double points = Json::parse(report("--json"), "out")["points"].number();
  const std::string shown = fmt::format("{:.1f}", printed_points(points));
  EXPECT_THAT(report(""), HasSubstr(fmt::format(": {} of 100 points", shown)));
  EXPECT_THAT(read_text(folder / "r.html"), HasSubstr(fmt::format("{}<small> / 100</small>", shown)));
  EXPECT_THAT(expect_ok(folder.run("rescore {}/s.h5")).out, HasSubstr(fmt::format(": {} of 100 points", shown)));
}

TEST(DoctorCommand, ReportsTheStateOfEachPartAndARemedy) {
  ProgramFolder folder(TYPODONT_PROGRAM);
  const Ran ran = folder.run("doctor --json");
  EXPECT_EQ(ran.err, "");
  const Json json = Json::parse(ran.out, "out");
  EXPECT_EQ(ran.status, json["runs_offscreen"].boolean() ? 0 : 1);
  std::vector<std::string> ids;
  for (const Json& check : json["checks"].items()) {
    ids.push_back(check["id"].string());
    const std::string state = check["state"].string();
    EXPECT_THAT(state, testing::AnyOf("ok", "degraded", "missing"));
    EXPECT_NE(check["found"].string(), "") << ids.back();
    EXPECT_EQ(check["mend"].string() == "", state == "ok") << ids.back();
    EXPECT_EQ(check["without"].string() == "", state == "ok") << ids.back();
  }
  EXPECT_THAT(ids, testing::IsSupersetOf({"vulkan", "drawing", "realtime", "locked_memory", "cpu", "hid", "audio",
                                          "openxr", "display", "ffmpeg", "libraries", "disk"}));
}

/// Without a Vulkan driver, `doctor` does not measure how fast it draws.
const std::string kNoDriver = "VK_ICD_FILENAMES=/nowhere.json VK_DRIVER_FILES=/nowhere.json";

TEST(DoctorCommand, FindsEveryLibraryThatIsLoadedOnUseWithAllItsFunctions) {
  ProgramFolder folder(TYPODONT_PROGRAM);
  const Ran ran = folder.run("doctor --json", kNoDriver);
  for (const Json& check : Json::parse(ran.out, "out")["checks"].items()) {
    if (check["id"].string() != "libraries") continue;
    EXPECT_EQ(check["state"].string(), "ok") << check["found"].string();
    std::vector<const char*> files{"libsndfile.so", "libcairo.so",         "libteem.so",
                                   "libnifti2.so",  "libznz.so",           "libminizip.so",
                                   "libassimp.so",  "libmeshoptimizer.so", "typodont-calibration.so"};
#ifdef TYPODONT_WINDOW
    files.insert(files.end(), {"libglfw.so", "libX11.so", "libXext.so", "libxcb.so"});
#endif
    for (const char* file : files) EXPECT_THAT(check["found"].string(), HasSubstr(file));
  }
}

TEST(DoctorCommand, NamesThePackageOfALibraryThatIsNotInstalled) {
  ProgramFolder folder(TYPODONT_PROGRAM);
  std::ofstream(folder / "libteem.so.2") << "";  // takes the place of the library
  const Ran ran = folder.run("doctor", kNoDriver + " LD_LIBRARY_PATH=" + folder.path().string());
  EXPECT_THAT(ran.out, HasSubstr("missing   Libraries loaded on use"));
  EXPECT_THAT(ran.out, HasSubstr("sudo apt install libteem2"));
}

TEST(DoctorCommand, WithoutAVulkanDriverTheProgramCannotRunAndTheDriverPackageIsNamed) {
  ProgramFolder folder(TYPODONT_PROGRAM);
  const Ran ran = folder.run("doctor", kNoDriver);
  EXPECT_EQ(ran.status, 1);
  EXPECT_THAT(ran.out, HasSubstr("missing   Vulkan device"));
  EXPECT_THAT(ran.out, HasSubstr("sudo apt install libvulkan1 mesa-vulkan-drivers"));
  EXPECT_THAT(ran.err, HasSubstr("error: Typodont cannot run on this machine"));
}

TEST(DoctorCommand, PrintsNoControlCharactersIntoATerminal) {
  ProgramFolder folder("script");
  // In a terminal, each control character would become a question mark.
  const Ran ran = folder.run("-qec '" TYPODONT_PROGRAM " doctor' /dev/null", kNoDriver);
  EXPECT_THAT(ran.out, HasSubstr("missing   Vulkan device"));
  EXPECT_THAT(ran.out, testing::Not(HasSubstr("?")));
}

TEST(DoctorCommand, ReadsTheActiveOpenXrRuntimeAndReportsItsDefects) {
  ProgramFolder folder(TYPODONT_PROGRAM);
  std::ofstream(folder / "good.json")
      << R"({"file_format_version": "1.0.0", "runtime": {"library_path": "./runtime.so"}})";
  std::ofstream(folder / "runtime.so") << "";
  std::ofstream(folder / "dangling.json") << R"({"runtime": {"library_path": "./gone.so"}})";
  std::ofstream(folder / "garbage.json") << "{{{";
  const auto openxr = [&](const std::string& file) {
    const Ran ran = folder.run("doctor --json", "XR_RUNTIME_JSON=" + folder / file);
    for (const Json& check : Json::parse(ran.out, "out")["checks"].items()) {
      if (check["id"].string() == "openxr") return check["state"].string() + ": " + check["found"].string();
    }
    return std::string();
  };
  EXPECT_THAT(openxr("good.json"), testing::StartsWith("ok: "));
  EXPECT_THAT(openxr("dangling.json"),
              testing::AllOf(testing::StartsWith("degraded: "), HasSubstr("gone.so, which is not there")));
  EXPECT_THAT(openxr("garbage.json"),
              testing::AllOf(testing::StartsWith("degraded: "), HasSubstr("not a runtime's description")));
  EXPECT_THAT(openxr("none.json"), testing::StartsWith("missing: "));
}

/// A mono WAV of 16 bits.
void write_tone(const std::filesystem::path& file, std::uint32_t samples) {
  const auto bytes = [](auto number) { return std::string(reinterpret_cast<const char*>(&number), sizeof number); };
  const std::uint16_t one = 1, two = 2, bits = 16;
  std::string wav = "RIFF" + bytes(36 + 2 * samples) + "WAVEfmt " + bytes(16u) + bytes(one) + bytes(one) +
                    bytes(48000u) + bytes(96000u) + bytes(two) + bytes(bits) + "data" + bytes(2 * samples);
  for (std::uint32_t i = 0; i < samples; ++i) wav += bytes(static_cast<std::int16_t>(8000 * std::sin(0.1 * i)));
  std::ofstream(file, std::ios::binary) << wav;
}

TEST(Film, ContainsTheFramesAndTheSoundThatWereGiven) {
  TemporaryFolder folder;
  write_tone(folder / "s.wav", 48000);
  {
    FilmWriter film(folder / "f.mp4", {161, 121, 25});
    std::vector<std::uint8_t> frame(161 * 121 * 4);
    for (int i = 0; i < 25; ++i) {
      for (std::size_t k = 0; k < frame.size(); k += 4) {
        frame[k] = static_cast<std::uint8_t>(10 * i);
        frame[k + 1] = 128;
        frame[k + 2] = 0;
      }
      ASSERT_TRUE(film.add(frame)) << film.message();
    }
    ASSERT_TRUE(film.finish(FilmSound{folder / "s.wav"})) << film.message();
    EXPECT_EQ(film.message(), "");
  }
  const std::string film = (folder / "f.mp4").string();
  const Ran probe = ProgramFolder("ffprobe").run(
      "-v error -count_frames -show_entries stream=codec_name,width,height,nb_read_frames,r_frame_rate -of csv=p=0 " +
      film);
  EXPECT_THAT(probe.out, HasSubstr("h264,162,122,25/1,25"));
  EXPECT_THAT(probe.out, HasSubstr("aac"));
  // The colour of the 20th frame must be the colour that was written.
  const Ran pixel = ProgramFolder("ffmpeg").run(
      "-v error -i " + film + " -vf \"select=eq(n\\,19),crop=2:2:80:60\" -frames:v 1 -f rawvideo -pix_fmt rgb24 -");
  ASSERT_EQ(pixel.out.size(), 12u) << pixel.err;
  EXPECT_NEAR(static_cast<unsigned char>(pixel.out[0]), 190, 6);
  EXPECT_NEAR(static_cast<unsigned char>(pixel.out[1]), 128, 6);
  EXPECT_NEAR(static_cast<unsigned char>(pixel.out[2]), 0, 6);
  // Nothing else is left beside it.
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 2);
}

TEST(Film, AnUnreadableSoundGivesASilentFilmAndAMessage) {
  TemporaryFolder folder;
  std::ofstream(folder / "s.wav") << "not a sound";
  FilmWriter film(folder / "f.mp4", {64, 48, 25});
  const std::vector<std::uint8_t> frame(64 * 48 * 4, 99);
  for (int i = 0; i < 5; ++i) ASSERT_TRUE(film.add(frame));
  EXPECT_TRUE(film.finish(FilmSound{folder / "s.wav"}));
  EXPECT_THAT(film.message(), HasSubstr("the film is silent"));
  EXPECT_TRUE(std::filesystem::exists(folder / "f.mp4"));
}

}  // namespace
}  // namespace typodont::session
