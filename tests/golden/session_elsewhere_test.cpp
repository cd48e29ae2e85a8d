// Tests the session file in other programs: h5py in the system's Python, R with the documented example, and the tool of
// the HDF5 library. Like h5read of MATLAB, this tool has only the filters that the library contains.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>

#include "engine/session/recorder.h"
#include "engine/session/session_file.h"
#include "engine/session/ticks_csv.h"
#include "tests/support/session_fixture.h"

namespace typodont::session {
namespace {

using namespace test;
using testing::HasSubstr;

std::string output_of(const std::string& command) {
  std::string out;
  std::FILE* pipe = popen((command + " 2>&1").c_str(), "r");
  char buffer[4096];
  while (pipe && std::fgets(buffer, sizeof buffer, pipe)) out += buffer;
  const int status = pipe ? pclose(pipe) : -1;
  return out + fmt::format("exit {}", status);
}

std::vector<ServoTick> recorded(const std::filesystem::path& file) {
  const auto ticks = random_ticks(1300, 71);
  SessionWriter writer(file, some_header());
  writer.append(ticks);
  EXPECT_TRUE(writer.finish({}));
  return ticks;
}

std::uint64_t bits_of(double v) {
  std::uint64_t b;
  std::memcpy(&b, &v, sizeof b);
  return b;
}

std::uint64_t hand_bits(std::span<const ServoTick> ticks) {
  std::uint64_t sum = 0;
  for (const ServoTick& t : ticks) {
    const double v[] = {t.X_WT.p.x, t.X_WT.p.y, t.X_WT.p.z, t.X_WT.R.w, t.X_WT.R.x, t.X_WT.R.y, t.X_WT.R.z};
    for (std::uint64_t i = 0; i < 7; ++i) sum += bits_of(v[i]) * (2 * i + 1);
  }
  return sum;
}

std::uint64_t force_bits(std::span<const ServoTick> ticks) {
  std::uint64_t sum = 0;
  for (const ServoTick& t : ticks) {
    for (std::uint64_t i = 0; i < 3; ++i) sum += bits_of(t.f_T_W[static_cast<int>(i)]) * (2 * i + 1);
  }
  return sum;
}

TEST(SessionFromPython, HasTheSameNumbersAsTheCsvAndEveryBitOfTheHand) {
  TemporaryFolder folder;
  const auto ticks = random_ticks(1300, 61);
  {
    SessionWriter writer(folder / "s.h5", some_header());
    writer.append(ticks);
    writer.append(random_cuts(9, 62));
    writer.append(random_patches(4, 63));
    ASSERT_TRUE(writer.finish({}));
    TicksCsvWriter csv(folder / "t.csv");
    csv.append(ticks);
    csv.finish();
  }
  double greatest = 0;
  for (const ServoTick& t : ticks) greatest = std::max(greatest, glm::length(t.f_T_W));
  const std::string out =
      output_of(fmt::format("{} tests/golden/session_read.py {} {} docs/session_format.md", TYPODONT_PYTHON,
                            (folder / "s.h5").string(), (folder / "t.csv").string()));
  EXPECT_THAT(out, HasSubstr("format typodont-session 1 complete 1\n"));
  EXPECT_THAT(out, HasSubstr("ticks 1300 cuts 9 patches 4\n"));
  EXPECT_THAT(out, HasSubstr(fmt::format("hand {}\n", hand_bits(ticks))));
  EXPECT_THAT(out, HasSubstr(fmt::format("force {}\n", force_bits(ticks))));
  EXPECT_THAT(out, HasSubstr(fmt::format("columns {}\n", ticks_csv_columns().size())));
  const std::string example = "example Zähne, 牙齿 1300 ticks, greatest force ";
  ASSERT_THAT(out, HasSubstr(example));
  EXPECT_NEAR(std::strtod(out.c_str() + out.find(example) + example.size(), nullptr), greatest, 1e-12);
  EXPECT_THAT(out, testing::EndsWith("exit 0"));
}

TEST(SessionFromPython, OpensAfterACrashAndAfterARepair) {
  TemporaryFolder folder;
  const auto ticks = random_ticks(1024, 64);
  const pid_t pid = fork();
  if (pid == 0) {
    SessionWriter writer(folder / "s.h5", some_header());
    writer.append(ticks);
    writer.flush();
    _exit(0);  // without a word to HDF5: what a kill leaves behind
  }
  waitpid(pid, nullptr, 0);
  const std::string read =
      fmt::format("{} tests/golden/session_read.py {}", TYPODONT_PYTHON, (folder / "s.h5").string());
  const std::string expected = fmt::format("complete 0\nticks 1024 cuts 0 patches 0\nhand {}\n", hand_bits(ticks));
  EXPECT_THAT(output_of(read + " swmr"), HasSubstr(expected));
  EXPECT_THAT(output_of(read), HasSubstr("already open for write"));
  EXPECT_TRUE(repair_session(folder / "s.h5"));
  EXPECT_THAT(output_of(read), HasSubstr(expected));
}

TEST(SessionFromPython, ReadsTheFiveLossCountersOfAFileOfTheFirstRelease) {
  TemporaryFolder folder;
  { ASSERT_TRUE(SessionWriter(folder / "s.h5", some_header()).finish({})); }
  const std::string older =
      "import h5py, numpy, sys; f = h5py.File(sys.argv[1], 'r+'); del f['lost']; f['lost'] = numpy.arange(1, 6, "
      "dtype='u8')";
  EXPECT_EQ(output_of(fmt::format("{} -c \"{}\" {}", TYPODONT_PYTHON, older, (folder / "s.h5").string())), "exit 0");
  EXPECT_EQ(SessionReader(folder / "s.h5").lost(), (Lost{1, 2, 3, 4, 5}));
}

TEST(SessionFromTheLibrarysOwnTool, HasEveryTickAndNeedsOnlyStandardHdf5Filters) {
  TemporaryFolder folder;
  const auto ticks = recorded(folder / "s.h5");
  const std::string file = (folder / "s.h5").string();
  std::istringstream numbers(
      output_of(fmt::format("{} -d /ticks/depth_mm -y -w 1 -m %.17g {}", TYPODONT_H5DUMP, file)));
  std::vector<double> depths;
  for (std::string line; std::getline(numbers, line);) {
    char* end = nullptr;
    const double value = std::strtod(line.c_str(), &end);
    if (end != line.c_str() && (*end == ',' || *end == 0)) depths.push_back(value);
  }
  ASSERT_EQ(depths.size(), ticks.size());
  for (std::size_t i = 0; i < ticks.size(); ++i)
    ASSERT_NEAR(depths[i], ticks[i].depth * 1e3, 1e-12 * std::abs(depths[i]) + 1e-300);
  const std::string properties = output_of(fmt::format("{} -p -H {}", TYPODONT_H5DUMP, file));
  EXPECT_THAT(properties, HasSubstr("COMPRESSION DEFLATE"));
  for (const char* other : {"USER_DEFINED", "SZIP", "NBIT", "SCALEOFFSET", "EXTERNAL"})
    EXPECT_EQ(properties.find(other), std::string::npos) << other;
}

#ifdef TYPODONT_RSCRIPT
TEST(SessionFromR, RunsTheDocumentedExampleAndHasEveryTick) {
  TemporaryFolder folder;
  const auto ticks = recorded(folder / "session.h5");
  std::ifstream page("docs/session_format.md");
  const std::string document{std::istreambuf_iterator<char>(page), {}}, fence = "```r\n";
  const auto at = document.find(fence);
  ASSERT_NE(at, std::string::npos);
  const auto begin = at + fence.size();
  std::ofstream(folder / "example.R") << "pdf(NULL)\n"
                                      << document.substr(begin, document.find("```", begin) - begin)
                                      << "cat(nrow(t), format(sum(t[, \"depth_mm\"]), digits = 15), \"\\n\")\n";
  const std::string out = output_of(fmt::format("cd {} && {} example.R", folder.path().string(), TYPODONT_RSCRIPT));
  double sum = 0;
  for (const ServoTick& tick : ticks) sum += tick.depth * 1e3;
  ASSERT_THAT(out, HasSubstr("1300 "));
  EXPECT_NEAR(std::strtod(out.c_str() + out.rfind("1300 ") + 5, nullptr), sum, 1e-9 * std::abs(sum)) << out;
}
#endif

}  // namespace
}  // namespace typodont::session
