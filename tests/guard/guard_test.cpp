// Tests that the hot paths do not become slower. It compares the instructions per unit of work, counted by callgrind,
// with tests/guard/instructions.csv. Unlike times, these counts hardly depend on other work of the machine. After a
// change that deliberately needs more (or fewer) instructions, run this test with TYPODONT_GUARD_UPDATE=1, and commit
// the table with the change that explains it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>

#include "tests/support/program.h"

namespace typodont::test {
namespace {

constexpr const char* kTable = "tests/guard/instructions.csv";
constexpr double kTolerance = 0.03;
// Another compiler or processor makes other instructions. There the test only finds an increase of more than 50 %,
// because a different compiler does not explain such an increase.
constexpr double kElsewhere = 0.5;

std::string compiler_and_processor() {
  const char* lanes = __builtin_cpu_supports("avx2") ? "avx2" : "sse2";  // valgrind knows no wider ones
  return fmt::format("GCC {}.{} {}", __GNUC__, __GNUC_MINOR__, lanes);
}

/// Instructions per unit of work, by path.
std::map<std::string, double> count(const ProgramFolder& folder) {
  expect_ok(folder.run(
      "", fmt::format("valgrind --tool=callgrind --instr-atstart=no --collect-atstart=no --callgrind-out-file={}/out",
                      folder.path().string())));
  std::map<std::string, double> counts;
  for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
    std::istringstream in(read_text(entry.path()));
    std::string path;
    double units = 0;
    for (std::string line; std::getline(in, line);) {
      constexpr std::string_view kTrigger = "desc: Trigger: Client Request: ", kTotals = "totals: ";
      if (line.starts_with(kTrigger)) {
        const std::size_t slash = line.rfind('/');
        path = line.substr(kTrigger.size(), slash - kTrigger.size());
        units = std::stod(line.substr(slash + 1));
      }
      if (line.starts_with(kTotals) && !path.empty()) counts[path] = std::stod(line.substr(kTotals.size())) / units;
    }
  }
  return counts;
}

TEST(HotPaths, TakeNoMoreInstructionsThanTheTableAllows) {
  const ProgramFolder folder(TYPODONT_HOT_PATHS);
  const auto counts = count(folder);
  ASSERT_GE(counts.size(), 10u);
  if (std::getenv("TYPODONT_GUARD_UPDATE")) {
    std::ofstream out(kTable);
    out << "# " << compiler_and_processor() << "\npath,instructions\n";
    for (const auto& [path, n] : counts) out << fmt::format("\"{}\",{:.0f}\n", path, n);
    return;
  }
  std::ifstream in(kTable);
  std::string made_by, line;
  std::getline(in, made_by);
  const double tolerance = made_by == "# " + compiler_and_processor() ? kTolerance : kElsewhere;
  std::getline(in, line);
  std::size_t guarded = 0;
  while (std::getline(in, line)) {
    const std::size_t quote = line.find('"', 1);
    const std::string path = line.substr(1, quote - 1);
    const double allowed = std::stod(line.substr(quote + 2));
    const auto found = counts.find(path);
    ASSERT_NE(found, counts.end()) << path;
    fmt::print("{:<34} {:>12.0f} instructions, {:+.2f} %\n", path, found->second, 100 * (found->second / allowed - 1));
    EXPECT_LE(found->second, allowed * (1 + tolerance)) << path;
    ++guarded;
  }
  EXPECT_EQ(guarded, counts.size()) << "a path without a line in " << kTable;
}

}  // namespace
}  // namespace typodont::test
