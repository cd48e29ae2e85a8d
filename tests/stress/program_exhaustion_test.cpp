// Tests the program with too few file handles, too little memory or a full disk: it ends with a message and leaves no
// partly written file. It never crashes.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <functional>

#include "tests/support/program.h"

namespace typodont::test {
namespace {

class Exhaustion : public testing::Test {
 protected:
  Exhaustion() {
    folder_.write(
        "scene.json",
        R"({"tissue": {"voxel_mm": 0.2, "solids": [{"tissue": "dentin", "solid": {"sphere": {"radius_mm": 3}}}]},
      "tool": "round_012", "spindle_krpm": 300})");
    folder_.write("hand.csv", "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n0,0,0,3.7,1,0,0,0,1\n0.2,0,0,3.3,1,0,0,0,1\n");
  }
  /// Returns the smallest limit with which the program starts at all. The system's loader needs that much for the
  /// libraries.
  int least(const std::function<std::string(int)>& limit, int from, int step) const {
    for (int n = from; n < from + 200 * step; n += step) {
      if (folder_.run("--version'", "bash -c 'ulimit -c 0; ulimit " + limit(n) + "; exec").status == 0) return n;
    }
    ADD_FAILURE() << "does not start";
    return 0;
  }
  /// Runs the program under a limit of the command ulimit, and checks that it ends properly. Returns true if the
  /// program did its work in spite of the limit.
  bool survives(const std::string& limit, const std::string& arguments, const std::string& out) const {
    std::filesystem::remove_all(folder_ / out);
    const Ran ran = folder_.run(arguments + "'", fmt::format("bash -c 'ulimit -c 0; ulimit {}; exec", limit));
    EXPECT_LE(ran.status, 2) << limit << ": " << arguments << "\n" << ran.err;  // 126 and up: killed by a signal
    const bool done = ran.status == 0;
    EXPECT_EQ(std::filesystem::exists(folder_ / out), done) << limit << ": " << arguments;
    EXPECT_EQ(ran.err.empty() && !done, false) << "no word about " << limit << ": " << arguments;
    EXPECT_EQ(ran.err.find("bad_alloc"), std::string::npos) << limit << ": " << arguments;
    last_message_ = ran.err;
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path()))
      EXPECT_EQ(entry.path().string().find(".partial"), std::string::npos) << entry.path();
    return done;
  }
  const ProgramFolder folder_{TYPODONT_PROGRAM};
  mutable std::string last_message_;
};

constexpr const char* kServo = "servo {}/scene.json --hand {}/hand.csv --out {}/out.csv";
constexpr const char* kSession = "servo {}/scene.json --hand {}/hand.csv --out {}/out.h5";
constexpr const char* kMesh = "mesh {}/scene.json --out {}/out.ply";

TEST_F(Exhaustion, WithFewFileHandlesItWorksOrReportsTheReason) {
  // Tests the number of file handles that the loader needs for the libraries, and a few more.
  const int floor = least([](int n) { return fmt::format("-n {}", n); }, 3, 1);
  int worked = 0;
  for (const int more : {0, 1, 2, 3, 5, 30}) {
    const std::string limit = fmt::format("-n {}", floor + more);
    worked = survives(limit, kServo, "out.csv");
    worked += survives(limit, kSession, "out.h5");
    worked += survives(limit, kMesh, "out.ply");
  }
  EXPECT_EQ(worked, 3) << "30 more are plenty";
}

TEST_F(Exhaustion, WithLittleMemoryItWorksOrReportsTheReason) {
  const auto megabytes = [](int n) { return fmt::format("-v {}", n * 1024); };
  const int floor = least(megabytes, 60, 10);
  int worked = 0;
  for (const int more : {0, 5, 10, 20, 40, 80, 2000}) {
    worked = survives(megabytes(floor + more), kServo, "out.csv");
    worked += survives(megabytes(floor + more), kMesh, "out.ply");
  }
  EXPECT_EQ(worked, 2) << "2 GB more are plenty";
}

TEST_F(Exhaustion, WithLittleMemoryALiveSessionEndsProperlyWhicheverThreadFails) {
  const auto megabytes = [](int n) { return fmt::format("-v {}", n * 1024); };
  const int floor = least(megabytes, 60, 10);
  int worked = 0, failed = 0;
  for (int more = 0; more < 150; more += 2) {
    const Ran ran = folder_.run("run {}/scene.json --hand script:{}/hand.csv --audio none:'",
                                fmt::format("bash -c 'ulimit -c 0; ulimit {}; exec env -u DISPLAY -u WAYLAND_DISPLAY",
                                            megabytes(floor + more)));
    EXPECT_LE(ran.status, 2) << floor + more << " MB\n" << ran.err;
    EXPECT_FALSE(ran.status != 0 && ran.err.empty()) << "no word about " << floor + more << " MB";
    ++(ran.status == 0 ? worked : failed);
  }
  EXPECT_GT(worked, 0);
  EXPECT_GT(failed, 0);
}

// A software renderer compiles while it draws, and crashes where memory ends in one of its calls.
TEST_F(Exhaustion, WithLittleMemoryAPictureIsDrawnOrReportsTheReason) {
  const auto megabytes = [](int n) { return fmt::format("-v {}", n * 1024); };
  const int floor = least(megabytes, 60, 10);
  int worked = 0;
  for (int more = 200; more < 1300; more += 60)
    worked += survives(megabytes(floor + more), "render {}/scene.json --eye left --out {}/pictures", "pictures");
  EXPECT_LT(worked, 10) << "hardly ever too little";
  EXPECT_TRUE(survives(megabytes(floor + 8000), "render {}/scene.json --eye left --out {}/pictures", "pictures"));
}

TEST_F(Exhaustion, WithAFullDiskNoPartialFileIsLeft) {
  // If the signal SIGXFSZ is ignored, writing beyond the limit fails in the same way as on a full disk.
  for (const int blocks : {1, 4, 40}) {
    const std::string limit = fmt::format("-f {}; trap \"\" XFSZ", blocks);
    // The limit concerns only files: the program fails because of its output, and not because of its patches.
    if (!survives(limit, kServo, "out.csv")) {
      EXPECT_NE(last_message_.find("out.csv"), std::string::npos) << limit;
    }
    if (!survives(limit, kMesh, "out.ply")) {
      EXPECT_NE(last_message_.find("out.ply"), std::string::npos) << limit;
    }
  }
}

}  // namespace
}  // namespace typodont::test
