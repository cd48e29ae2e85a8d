// Tests the bindings for other languages as their users have them: from an installation, with a separate compiler or
// interpreter.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <utility>

#include "tests/support/program.h"

namespace typodont {
namespace {

namespace fs = std::filesystem;

constexpr const char* kBall = R"({"tissue": {"voxel_mm": 0.1, "solids": [
  {"tissue": "enamel", "solid": {"sphere": {"radius_mm": 3}}}, {"tissue": "dentin", "solid": {"sphere": {"radius_mm": 2.5}}}]},
  "tool": "round_012", "spindle": "air_turbine", "parts": ["haptics"]})";
/// The hand moves down into the ball, aside with a tilt, and out.
constexpr const char* kPath =
    "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,0,0,4,1,0,0,0,1\n0.5,0,0,3.2,1,0,0,0,1\n1.2,0.6,0.1,3.1,0.995,0.0998,0,0,"
    "1\n"
    "1.5,0.6,0,4,1,0,0,0,1\n";

/// The library of this build, after installation.
class Doors : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new test::ProgramFolder(TYPODONT_PROGRAM);
    expect_ok(
        sh(fmt::format("{} --install {} --prefix {} --component library", TYPODONT_CMAKE, TYPODONT_BUILD, prefix())));
  }
  static void TearDownTestSuite() { delete folder_; }

  static std::string prefix() { return *folder_ / "prefix"; }
  static test::Ran sh(const std::string& command) { return test::ProgramFolder("").run("", command); }
  /// `typodont` itself.
  static test::Ran program(const std::string& arguments) { return folder_->run(arguments); }

  /// Compiles a source with the flags of the installed package file. Returns the command that runs the result.
  static std::string compile(const std::string& source) {
    const std::string name = fs::path(source).stem();
    const std::string flags = fmt::format("$(PKG_CONFIG_PATH={}/{}/pkgconfig pkg-config --cflags --libs typodont)",
                                          prefix(), TYPODONT_LIBDIR);
    expect_ok(sh(fmt::format("{} -std=gnu11 -Wall -Wextra -Wpedantic -Werror -O1 -o {} {} {} -pthread", TYPODONT_CC,
                             *folder_ / name, source, flags)));
    return fmt::format("env LD_LIBRARY_PATH={}/{} {}", prefix(), TYPODONT_LIBDIR, *folder_ / name);
  }

  static test::ProgramFolder* folder_;
};
test::ProgramFolder* Doors::folder_ = nullptr;

/// Returns the first program in this language that a page shows.
std::string program_of(const std::string& page, const std::string& language) {
  const std::string text = test::read_text("docs/doors/" + page), begin = "\n```" + language + "\n";
  const std::size_t at = text.find(begin);
  EXPECT_NE(at, std::string::npos) << page << ": no program in " << language;
  return text.substr(at + begin.size(), text.find("\n```\n", at + begin.size()) - at - begin.size() + 1);
}

/// Checks four lines such as "0.5 s: 0.115 N, 0.0019 mm3". The removed volume must grow from line to line, and the hand
/// must feel a force.
void expect_drilled(const std::string& said) {
  std::istringstream lines(said);
  double t, force, removed = 0, before = 0;
  int rows = 0;
  for (std::string line; std::getline(lines, line) && rows < 4; ++rows) {
    ASSERT_EQ(std::sscanf(line.c_str(), "%lf s: %lf N, %lf mm3", &t, &force, &removed), 3) << line;
    EXPECT_GT(force, 0);
    EXPECT_GT(removed, before);
    before = removed;
  }
  EXPECT_EQ(rows, 4) << said;
}

TEST_F(Doors, TheProgramOnThePageAboutCDrillsABall) {
  const test::Ran ran = expect_ok(sh(compile(folder_->write("drill.c", program_of("c.md", "c")))));
  expect_drilled(ran.out);
}

TEST_F(Doors, TicksThroughTheCInterfaceEqualThoseOfTheProgramBitForBit) {
  std::string packed = kBall;
  packed.insert(1, R"("model": {"packing": {"spheres": 2000}}, )");
  const std::string ball = folder_->write("ball.json", kBall), spheres = folder_->write("packed.json", packed),
                    path = folder_->write("hand.csv", kPath),
                    hand = folder_->write("hand.json", R"({"path": "hand.csv", "mass_kg": 0.15, "damping_Ns_per_m": 5,
                      "stiffness_N_per_m": [2000, 2000, 400], "push_N": [0, 0, -0.5]})");
  for (const auto& [scene, moves] : {std::pair(ball, path), std::pair(ball, hand), std::pair(spheres, hand)}) {
    const std::string session = *folder_ / "program.h5", recorded = *folder_ / "c.h5";
    const test::Ran ran =
        expect_ok(program(fmt::format("servo {} --hand {} --rate 2000 --out {} --json", scene, moves, session)));
    const auto summary = nlohmann::json::parse(ran.out);
    const test::Ran same = expect_ok(sh(fmt::format(
        "{} {} {} 2000 {} {}", compile("tests/acceptance/doors/same_bits.c"), scene, moves, session, recorded)));
    EXPECT_NE(same.out.find("field " + summary["field_hash"].get<std::string>()), std::string::npos) << same.out;
    EXPECT_GT(summary["cuts"].get<int>(), 100);
    const test::Ran replayed = expect_ok(program(fmt::format("replay {} --check --json", recorded)));
    EXPECT_TRUE(nlohmann::json::parse(replayed.out)["identical"].get<bool>());
  }
}

TEST_F(Doors, WhateverAHostDoesWrongIsAnErrorAndNoCrash) {
  expect_ok(sh(compile("tests/acceptance/doors/hostile.c")));
}

TEST_F(Doors, RandomCallsOnThreeThreadsGiveDocumentedResultsAndNoCrash) {
  const std::string host = compile("tests/acceptance/doors/random_host.c");
  expect_ok(sh(fmt::format("cd {} && {} 1 2000", folder_->path().string(), host)));
}

TEST_F(Doors, AServoOnAThreadOfItsOwnIsReplayedBitForBitWithItsUndoneStrokes) {
  const std::string scene = folder_->write("ball.json", kBall), session = *folder_ / "two_threads.h5";
  const test::Ran ran =
      expect_ok(sh(fmt::format("{} {} {}", compile("tests/acceptance/doors/two_threads.c"), scene, session)));
  double by_ticks = 0, by_volumes = 0;
  int ticks = 0, edits = 0, parts = 0;
  ASSERT_EQ(std::sscanf(ran.out.c_str(), "%d ticks, %d edits, %d parts, removed %lf mm3 by ticks, %lf", &ticks, &edits,
                        &parts, &by_ticks, &by_volumes),
            5)
      << ran.out;
  EXPECT_EQ(ticks, 4000);
  EXPECT_EQ(edits, 2) << "undone and brought again";
  EXPECT_GT(parts, 10);
  EXPECT_GT(by_ticks, 0.05);
  EXPECT_NEAR(by_ticks, by_volumes, 1e-6 + 1e-4 * by_volumes);
  expect_ok(program(fmt::format("replay {} --check --json", session)));
}

TEST_F(Doors, AReaderOfTheStreamReceivesALiveSessionUntilItsEnd) {
  const std::string scene = folder_->write("ball.json", kBall),
                    reader = folder_->write("reader.py", program_of("stream.md", "python")),
                    hand = folder_->write(
                        "long.csv",
                        "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,0,0,3.5,1,0,0,0,1\n3600,0,0,3.4,1,0,0,0,1\n");
  // A port that nobody has now.
  const test::Ran free =
      sh(fmt::format("{} -c 'import socket; s = socket.socket(); s.bind((\"127.0.0.1\", 0)); "
                     "print(s.getsockname()[1])'",
                     TYPODONT_PYTHON));
  const int port = std::stoi(free.out);
  const pid_t session = folder_->start(
      fmt::format("run {} --hand script:{} --audio none: --stream ws:{} --stream-rate 50", scene, hand, port));
  // Starts the reader again and again until the session accepts its connection.
  const test::ProgramFolder readers("sh");
  const pid_t reading =
      readers.start(fmt::format("-c 'until {} -u {} {}; do sleep 0.05; done'", TYPODONT_PYTHON, reader, port));
  const auto told = [&](const char* what) {
    return test::read_text(readers / ".started_out").find(what) != std::string::npos;
  };
  for (int i = 0; i < 6000 && !told(" N, "); ++i) ::usleep(10'000);
  const test::Ran live = folder_->finish(session);
  for (int i = 0; i < 6000 && !told(" s: end"); ++i) ::usleep(10'000);
  EXPECT_EQ(live.status, 0) << live.err;
  EXPECT_TRUE(told(" N, ")) << live.err;
  EXPECT_TRUE(told(" s: end")) << test::read_text(readers / ".started_out");
  readers.finish(reading, SIGKILL);
}

TEST_F(Doors, RescoredSessionsHaveTheScoresOfTheirReportsAndOfOtherRulesWhereTheseCount) {
  const std::string rules =
      R"(, "score": {"defaults": false, "rules": [{"name": "healthy_removed_mm3", "target": 0, "tolerance": 1, "weight": 1}]}})";
  const std::string
      ball = kBall,
      strict =
          ball.substr(0, ball.size() - 1) +
          R"(, "score": {"defaults": false, "rules": [{"name": "healthy_removed_mm3", "target": 0, "tolerance": 0.001, "weight": 1}]}})";
  const std::string scene = folder_->write("scored.json", ball.substr(0, ball.size() - 1) + rules),
                    other = folder_->write("strict.json", strict), hand = folder_->write("hand.csv", kPath);
  fs::create_directories(folder_->path() / "school/ada");
  for (const char* name : {"school/first.h5", "school/ada/second.h5"}) {
    expect_ok(program(fmt::format("servo {} --hand {} --out {}", scene, hand, *folder_ / name)));
  }
  folder_->write("school/broken.h5", "no session");
  const test::Ran report =
      expect_ok(program(fmt::format("report {} --out {} --json", *folder_ / "school/first.h5", *folder_ / "r.html")));
  const double points = nlohmann::json::parse(report.out)["points"];
  const test::Ran ran = expect_ok(
      program(fmt::format("rescore {} --jobs 2 --out {} --json", *folder_ / "school", *folder_ / "scores.csv")));
  const auto rows = nlohmann::json::parse(ran.out);
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(rows[0]["points"], points);
  EXPECT_TRUE(rows[1].contains("error")) << rows[1];
  EXPECT_EQ(rows[2]["points"], points);
  EXPECT_GT(points, 0);
  EXPECT_EQ(test::read_text(*folder_ / "scores.csv").find("session,date,"), 0u);
  const test::Ran anew =
      expect_ok(program(fmt::format("rescore {} --rules {} --json", *folder_ / "school/first.h5", other)));
  EXPECT_LT(nlohmann::json::parse(anew.out)["points"].get<double>(), points);
}

TEST_F(Doors, TheHeadersPassACppCompilersWarnings) {
  const std::string source =
      folder_->write("all.cpp",
                     "#include <typodont.h>\n#include <typodont_calibration.h>\n#include "
                     "<typodont_sound.h>\nint main() { return typodont_version() == nullptr; }\n");
  expect_ok(sh(fmt::format("{} -std=c++11 -Wall -Wextra -Wpedantic -Werror -fsyntax-only -I{}/include {}",
                           TYPODONT_COMPILER, prefix(), source)));
}

/// Lines of a list.
std::set<std::string> lines_of(const std::string& text) {
  std::set<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.insert(line);
  return lines;
}

TEST_F(Doors, NothingOfTheLastReleasesBinaryInterfaceChanged) {
  const test::Ran ran = expect_ok(sh(fmt::format("{} tests/acceptance/doors/abi.py {}", TYPODONT_PYTHON, prefix())));
  const std::set<std::string> now = lines_of(ran.out);
  std::size_t lists = 0;
  for (const auto& entry : fs::directory_iterator("engine/bindings/c/abi")) {
    ++lists;
    for (const std::string& line : lines_of(test::read_text(entry.path()))) {
      EXPECT_TRUE(now.contains(line)) << entry.path() << ": \"" << line << "\" does not hold any more";
    }
  }
  EXPECT_GT(lists, 0u);
  for (const std::string& line : now) EXPECT_FALSE(line.starts_with("unversioned")) << line;
}

TEST_F(Doors, CSharpDrillsTheSameBallAndIsToldOfABadPose) {
  if (!*TYPODONT_MCS) GTEST_SKIP() << "no C# compiler: apt install mono-mcs mono-runtime";
  const std::string exe = *folder_ / "drill.exe";
  expect_ok(
      sh(fmt::format("{} -warnaserror -out:{} engine/bindings/csharp/Typodont.cs "
                     "tests/acceptance/doors/Drill.cs",
                     TYPODONT_MCS, exe)));
  const test::Ran ran = expect_ok(sh(fmt::format("env LD_LIBRARY_PATH={}/{} mono {}", prefix(), TYPODONT_LIBDIR, exe)));
  expect_drilled(ran.out);
  EXPECT_NE(ran.out.find("undone True"), std::string::npos) << ran.out;
  EXPECT_NE(ran.out.find("refused: a pose"), std::string::npos) << ran.out;

  const std::string page = folder_->write("Page.cs", program_of("engines.md", "csharp"));
  expect_ok(
      sh(fmt::format("{} -out:{} engine/bindings/csharp/Typodont.cs {}", TYPODONT_MCS, *folder_ / "page.exe", page)));
  const test::Ran page_ran =
      expect_ok(sh(fmt::format("env LD_LIBRARY_PATH={}/{} mono {}", prefix(), TYPODONT_LIBDIR, *folder_ / "page.exe")));
  EXPECT_NE(page_ran.out.find("bricks of surface"), std::string::npos) << page_ran.out;
}

/// The Unity engine is not available here; UnityDeclarations.cs declares the classes of Unity that the sample uses.
TEST_F(Doors, TheUnitySampleDrillsABallAndChangesItsBricksOverDeclarationsOfUnity) {
  if (!*TYPODONT_MCS) GTEST_SKIP() << "no C# compiler: apt install mono-mcs mono-runtime";
  const std::string exe = *folder_ / "unity.exe",
                    scene = folder_->write("motor_ball.json", R"({"tissue": {"voxel_mm": 0.1,
      "solids": [{"tissue": "enamel", "solid": {"sphere": {"radius_mm": 3}}}]}, "tool": "round_012", "spindle_krpm": 300})");
  expect_ok(
      sh(fmt::format("{} -warnaserror -define:UNITY_5_3_OR_NEWER -out:{} engine/bindings/csharp/Typodont.cs "
                     "engine/bindings/csharp/TypodontTooth.cs tests/acceptance/doors/UnityDeclarations.cs "
                     "tests/acceptance/doors/UnityHost.cs",
                     TYPODONT_MCS, exe)));
  expect_ok(sh(fmt::format("env LD_LIBRARY_PATH={}/{} mono {} {}", prefix(), TYPODONT_LIBDIR, exe, scene)));
}

TEST_F(Doors, GodotDrillsABallAndChangesItsSurfaceInPlace) {
  if (!*TYPODONT_GODOT) GTEST_SKIP() << "no Godot: apt install godot3-server";
  const std::string project = *folder_ / "godot";
  const auto shown = [&](const std::string& library, const std::string& scene) {
    return sh(fmt::format("env LD_LIBRARY_PATH={} HOME={} timeout 100 {} --path {} {}", library,
                          folder_->path().string(), TYPODONT_GODOT, project, scene));
  };
  const std::string library = fmt::format("{}/{}", prefix(), TYPODONT_LIBDIR);
  fs::copy("engine/bindings/godot/project", project, fs::copy_options::recursive);
  expect_ok(sh(fmt::format(
      "{0} -std=gnu11 -Wall -Wextra -Werror -Wno-missing-field-initializers -O1 -shared -fPIC -fvisibility=hidden "
      "-o {1}/libtypodont_godot.so engine/bindings/godot/typodont_godot.c "
      "$(PKG_CONFIG_PATH={2}/{3}/pkgconfig pkg-config --cflags --libs typodont) -pthread",
      TYPODONT_CC, project, prefix(), TYPODONT_LIBDIR)));
  const test::Ran ran = expect_ok(shown(library, ""));
  const std::size_t first = ran.out.find("0.496 s: ");
  ASSERT_NE(first, std::string::npos) << ran.out << ran.err;
  expect_drilled(ran.out.substr(first));
  EXPECT_NE(ran.out.find("67 bricks"), std::string::npos) << ran.out;
  EXPECT_NE(ran.out.find(" 8 bricks changed"), std::string::npos) << "in place, not all of them:\n" << ran.out;
  EXPECT_NE(ran.out.find("refused: a pose"), std::string::npos) << ran.out;
  EXPECT_NE(ran.out.find("undone: True"), std::string::npos) << ran.out;

  folder_->write("godot/page.gd", program_of("engines.md", "gdscript"));
  folder_->write("godot/page.tscn",
                 "[gd_scene load_steps=2 format=2]\n[ext_resource path=\"res://page.gd\" type=\"Script\" id=1]\n"
                 "[node name=\"Page\" type=\"Spatial\"]\nscript = ExtResource( 1 )\n");
  const test::Ran page = expect_ok(shown(library, "page.tscn"));
  EXPECT_TRUE(std::regex_search(page.out, std::regex("[1-9]\\d* bricks changed"))) << page.out << page.err;

  expect_exit(shown("/nowhere", ""), 1, "libtypodont.so that it needs, was not loaded");
}

/// Thread-local variables that a real-time thread uses must exist before the thread begins. So they lie in the static
/// block of each thread, in which the C library reserves 512 bytes for libraries that are loaded late (setting
/// rtld.optional_static_tls of glibc). Godot and Python load this library in this way.
TEST_F(Doors, TheThreadLocalVariablesOfTheLibraryFitInTheReserveForLibrariesLoadedLate) {
  const test::Ran ran = expect_ok(sh(fmt::format("readelf -lW {}/{}/libtypodont.so", prefix(), TYPODONT_LIBDIR)));
  std::smatch found;  // the columns of a segment: type, offset, two addresses, size in the file, size in memory
  ASSERT_TRUE(std::regex_search(ran.out, found, std::regex("TLS +0x\\w+ 0x\\w+ 0x\\w+ 0x\\w+ 0x(\\w+)"))) << ran.out;
  EXPECT_LT(std::stoul(found[1], nullptr, 16), 512u) << ran.out;
}

/// Tests the package as `pip install` leaves it, with the library inside.
TEST_F(Doors, ThePythonPackageFromItsWheelKeepsItsPromises) {
  const test::Ran has = sh(fmt::format(
      "{} -c 'import setuptools, wheel, pip, cffi, numpy, pandas, distributed, h5py, matplotlib'", TYPODONT_PYTHON));
  if (has.status != 0)
    GTEST_SKIP() << has.err
                 << "apt install python3-setuptools python3-wheel python3-pip python3-cffi python3-numpy "
                    "python3-pandas python3-distributed python3-h5py python3-matplotlib";
  const std::string wheels = *folder_ / "wheels", env = *folder_ / "env", source = *folder_ / "source";
  expect_ok(sh(fmt::format(
      "cp -r engine/bindings/python {2} && env TYPODONT_PREFIX={0} {1} -m pip wheel --no-build-isolation --no-deps "
      "--no-index -q -w {3} {2} && {1} -m pip install --no-deps "
      "--no-index -q --target {4} {3}/*.whl",
      prefix(), TYPODONT_PYTHON, source, wheels, env)));
  expect_ok(sh(fmt::format("env -u TYPODONT_PREFIX PYTHONPATH={} {} tests/acceptance/doors/python_test.py {}", env,
                           TYPODONT_PYTHON, TYPODONT_PROGRAM)));

  for (const char* page : {"python.md", "sweep.md"}) {
    const std::string program = folder_->write("page.py", program_of(page, "python"));
    const test::Ran page_ran =
        sh(fmt::format("cd {} && env PYTHONPATH={} {} {}", folder_->path().string(), env, TYPODONT_PYTHON, program));
    EXPECT_EQ(page_ran.status, 0) << page << ": " << page_ran.err;
    EXPECT_FALSE(page_ran.out.empty()) << page;
  }
}

}  // namespace
}  // namespace typodont
