// Tests the session file in other programs: R with the documented example, and the tool of the HDF5 library. Like
// h5read of MATLAB, this tool has only the filters that the library contains.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>

#include "engine/session/recorder.h"
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
  if (pipe) pclose(pipe);
  return out;
}

std::vector<ServoTick> recorded(const std::filesystem::path& file) {
  const auto ticks = random_ticks(1300, 71);
  SessionWriter writer(file, some_header());
  writer.append(ticks);
  EXPECT_TRUE(writer.finish({}));
  return ticks;
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
