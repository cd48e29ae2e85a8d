// The operator's window as a user meets it: on a desktop in memory, by keyboard alone, through to the report.
#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <set>
#include <thread>

#include "tests/support/desktop.h"
#include "tests/support/program.h"

namespace typodont::test {
namespace {

using namespace std::chrono_literals;

constexpr const char* kScene = R"({"name": "block", "description": "A block of enamel to drill into.",
 "tissue": {"voxel_mm": 0.1, "solids": [{"tissue": "enamel", "solid": {"box": {"center_mm": [6.8, 5.8, 15], "size_mm": [8, 8, 4]}}}]},
 "tool": "round_012", "spindle_krpm": 300, "parts": ["haptics", "render", "debris", "record", "score"],
 "task": {"goal": {"en": "Drill a hole."}, "steps": [{"en": "Touch it.", "done": "touch"}, {"en": "Drill.", "done": "drill"}]}})";

/// `typodont` on this desktop, its messages in a file.
class Program {
 public:
  Program(const ProgramFolder& folder, const std::string& arguments = "") : err_(folder / "err.txt") {
    process_ = fork();
    if (process_ == 0) {
      setenv("TYPODONT_HOME", (folder / "home").c_str(), 1);
      setenv("LC_ALL", "C", 1);
      execl("/bin/sh", "sh", "-c", fmt::format("exec {} {} >/dev/null 2>{}", TYPODONT_PROGRAM, arguments, err_).c_str(),
            static_cast<char*>(nullptr));
      _exit(127);
    }
  }
  ~Program() {
    if (process_ > 0 && waitpid(process_, nullptr, WNOHANG) == 0) {
      kill(process_, SIGKILL);
      waitpid(process_, nullptr, 0);
    }
  }
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  std::string said() const { return read_text(err_); }
  /// What follows `words` on the line where they were said; waits for it.
  std::string wait_for(const std::string& words) const {
    for (int i = 0; i < 1800; ++i) {
      const std::string all = said();
      const auto at = all.find(words);
      if (at != std::string::npos && all.find('\n', at) != std::string::npos)
        return all.substr(at + words.size(), all.find('\n', at) - at - words.size());
      std::this_thread::sleep_for(50ms);
    }
    ADD_FAILURE() << "not said: " << words << "\n" << said();
    return "";
  }
  void terminate() const { kill(process_, SIGTERM); }
  /// Exit status; −1 where it does not end.
  int wait_for_end() {
    for (int i = 0; i < 600; ++i) {
      int status = 0;
      if (waitpid(process_, &status, WNOHANG) == process_) {
        process_ = -1;
        return WIFEXITED(status) ? WEXITSTATUS(status) : 128;
      }
      std::this_thread::sleep_for(50ms);
    }
    return -1;
  }

 private:
  std::string err_;
  pid_t process_ = -1;
};

struct OperatorWindow : testing::Test {
  Desktop desktop{{1280, 800}};
  ProgramFolder folder{TYPODONT_PROGRAM};

  void SetUp() override {
    ASSERT_GT(desktop.process, 0) << "Xvfb is needed (apt install xvfb)";
    ASSERT_FALSE(Desktop::xdotool("version").empty()) << "xdotool is needed (apt install xdotool)";
    std::filesystem::create_directories(folder / "home/scenes");
    folder.write("home/scenes/zz_block.json", kScene);
    // Down on the block, into it and on for two seconds, and up again.
    std::string hand = "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n";
    for (const auto& [t, z, pedal] : {std::tuple{0.0, 18.5, 0},
                                      {0.5, 17.6, 0},
                                      {1.5, 17.5, 0},
                                      {2.0, 17.5, 1},
                                      {4.0, 16.8, 1},
                                      {4.5, 19.0, 0},
                                      {6.0, 19.0, 0}})
      hand += fmt::format("{},6.8,5.8,{},1,0,0,0,{}\n", t, z, pedal);
    folder.write("hand.csv", hand);
  }

  /// True as soon as the condition holds; a slow machine may take its time.
  static bool eventually(const std::function<bool()>& condition) {
    for (int i = 0; i < 600; ++i) {
      if (condition()) return true;
      std::this_thread::sleep_for(50ms);
    }
    return false;
  }
  /// Colours in a part of the screen: an empty panel has a few, a shaded picture many.
  int colours(glm::ivec2 lo, glm::ivec2 hi) const {
    const render::Picture p = desktop.screen({1280, 800});
    std::set<std::uint32_t> seen;
    for (int y = lo.y; y < hi.y; ++y)
      for (int x = lo.x; x < hi.x; ++x) seen.insert(p.at(x, y)[0] << 16 | p.at(x, y)[1] << 8 | p.at(x, y)[2]);
    return static_cast<int>(seen.size());
  }
  void open(const Program&) {
    EXPECT_TRUE(eventually([] { return !Desktop::xdotool("search --name Typodont").empty(); })) << "no window";
    EXPECT_TRUE(eventually([&] { return colours({0, 0}, {600, 400}) > 20; })) << "nothing drawn";
    Desktop::xdotool("search --name Typodont windowfocus");
    std::this_thread::sleep_for(300ms);
  }
  /// A key, and time for the window to see it go down and up.
  static void press(const std::string& key) {
    Desktop::xdotool("key --delay 60 " + key);
    std::this_thread::sleep_for(150ms);
  }
  void choose_block_and_script() {
    press("ctrl+Up");  // the user's own scenes come last
    press("ctrl+h");
    Desktop::xdotool(fmt::format("type --delay 20 'script:{}'", folder / "hand.csv"));
    std::this_thread::sleep_for(300ms);
  }
};

TEST_F(OperatorWindow, ByKeysAloneASessionIsChosenDrilledSteeredAndReported) {
  Program program(folder);
  open(program);
  choose_block_and_script();
  press("F5");
  ASSERT_EQ(program.wait_for("session started: "), "block");
  EXPECT_TRUE(eventually([&] { return colours({400, 200}, {900, 600}) > 200; })) << "the tissue is not to be seen";
  press("minus");
  press("minus");  // the drill may turn at 90 % of its speed
  program.wait_for("session ended");
  const std::string report = program.wait_for("report written: ");
  EXPECT_TRUE(eventually([&] { return std::filesystem::exists(report); })) << report;
  EXPECT_NE(read_text(report).find("<html"), std::string::npos);
  press("F10");
  press("ctrl+q");
  EXPECT_EQ(program.wait_for_end(), 0) << program.said();
  EXPECT_TRUE(std::filesystem::exists(folder / "home/settings.json"));

  // What was steered is in the recording: a replay is exact.
  const std::string session = std::filesystem::path(report).replace_extension(".h5").string();
  const Ran replay = folder.run("replay " + session + " --check");
  EXPECT_EQ(replay.status, 0) << replay.out << replay.err;
}

TEST_F(OperatorWindow, EscapeStopsAtOnceAndKeepsTheRecording) {
  Program program(folder);
  open(program);
  choose_block_and_script();
  press("F5");
  ASSERT_FALSE(program.wait_for("session started: ").empty());
  EXPECT_TRUE(eventually([&] { return colours({400, 200}, {900, 600}) > 200; }));
  press("Escape");
  program.wait_for("session ended");
  const std::string session =
      std::filesystem::path(program.wait_for("report written: ")).replace_extension(".h5").string();
  const Ran replay = folder.run("replay " + session + " --check");
  EXPECT_EQ(replay.status, 0) << replay.out << replay.err;
}

TEST_F(OperatorWindow, TerminatedInTheMiddleOfASessionItEndsItInOrder) {
  Program program(folder);
  open(program);
  choose_block_and_script();
  press("F5");
  ASSERT_FALSE(program.wait_for("session started: ").empty());
  program.terminate();
  EXPECT_EQ(program.wait_for_end(), 0) << program.said();
  program.wait_for("session ended");
}

TEST(OperatorWindowWithoutADesktop, SaysSoInOneLineAndHelps) {
  const ProgramFolder folder(TYPODONT_PROGRAM);
  const Ran ran = folder.run("", "env -u DISPLAY -u WAYLAND_DISPLAY");
  EXPECT_EQ(ran.status, 2);
  EXPECT_EQ(ran.out, "");
  EXPECT_NE(ran.err.find("error: The operator's window cannot be opened"), std::string::npos) << ran.err;
  EXPECT_NE(ran.err.find("typodont"), std::string::npos);
  EXPECT_NE(ran.err.find("run"), std::string::npos) << "the commands are listed: " << ran.err;
}

}  // namespace
}  // namespace typodont::test
