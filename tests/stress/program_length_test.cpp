// Tests sessions of any length: memory, open files and threads do not increase, and the size of the file is
// proportional to the length. The session has nine minutes in normal test runs and more than eight hours in ./run
// stress 80.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <string>
#include <system_error>
#include <vector>

#include "tests/support/campaign.h"
#include "tests/support/program.h"

namespace typodont::test {
namespace {

/// Returns a hand that moves down every ten seconds, drills along a furrow and leaves again.
std::string hand_of(int minutes) {
  std::string hand = "t_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,pedal\n";
  for (int i = 0; i < 6 * minutes; ++i) {
    hand += fmt::format("{0},-1,0,6,1,0,0,0,0\n{1},-1,0,4.4,1,0,0,0,1\n{2},1,0,4.3,1,0,0,0,1\n", 10 * i, 10 * i + 3,
                        10 * i + 6);
  }
  return hand + fmt::format("{},-1,0,6,1,0,0,0,0\n", 60 * minutes);
}

struct Used {
  double memory_kib = 0;
  std::ptrdiff_t open_files = 0, threads = 0;
  double file_bytes = 0;
};

std::ptrdiff_t entries(const std::string& folder) {
  std::error_code gone;
  const std::filesystem::directory_iterator it(folder, gone);
  return gone ? 0 : std::distance(begin(it), end(it));
}

TEST(LongSession, TwiceTheTimeNeedsNoMoreMemoryHandlesOrThreadsAndTwiceTheFileSize) {
  const ProgramFolder folder(TYPODONT_PROGRAM);
  folder.write("scene.json",
               R"({"tissue": {"voxel_mm": 0.2, "solids": [{"tissue": "dentin", "solid": {"sphere": {"radius_mm": 4}}}]},
    "tool": "round_012", "spindle_krpm": 300})");
  // Returns the median of the counts in the second half of the run. In the first half, the scene's file is open for a
  // moment, which one look counts and another does not.
  const auto mostly = [](std::vector<std::ptrdiff_t> counts) {
    if (counts.empty()) return std::ptrdiff_t{0};
    const auto middle = counts.begin() + static_cast<std::ptrdiff_t>(3 * counts.size() / 4);
    std::nth_element(counts.begin() + static_cast<std::ptrdiff_t>(counts.size() / 2), middle, counts.end());
    return *middle;
  };
  const auto session_of = [&](int minutes) {
    folder.write("hand.csv", hand_of(minutes));
    const pid_t child = folder.start("servo {}/scene.json --hand {}/hand.csv --out {}/out.h5");
    Used all;
    std::vector<std::ptrdiff_t> open_files, threads;
    int status = -1;
    rusage used{};
    while (::wait4(child, &status, WNOHANG, &used) == 0) {
      open_files.push_back(entries(fmt::format("/proc/{}/fd", child)));
      threads.push_back(entries(fmt::format("/proc/{}/task", child)));
      ::usleep(20'000);
    }
    EXPECT_EQ(status, 0) << folder.said();
    all.open_files = mostly(open_files);
    all.threads = mostly(threads);
    all.memory_kib = static_cast<double>(used.ru_maxrss);
    all.file_bytes = static_cast<double>(std::filesystem::file_size(folder / "out.h5"));
    return all;
  };
  // In the first minutes, the memory grows because HDF5 fills its own caches.
  const Used once = session_of(campaign(3)), twice = session_of(campaign(6));
  EXPECT_LT(twice.memory_kib, 1.05 * once.memory_kib);
  EXPECT_LE(twice.open_files, once.open_files);
  EXPECT_LE(twice.threads, once.threads);
  EXPECT_LT(twice.file_bytes, 2.1 * once.file_bytes);
}

}  // namespace
}  // namespace typodont::test
