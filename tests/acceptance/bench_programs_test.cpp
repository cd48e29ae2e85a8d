// Tests the benchmark programs with a tiny workload, and that the product contains nothing of them.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <set>
#include <sstream>
#include <string>

#include "tests/support/program.h"

namespace typodont::test {
namespace {

std::vector<std::string> benches() {
  std::istringstream names(TYPODONT_BENCHES);
  return {std::istream_iterator<std::string>(names), {}};
}

class BenchProgram : public testing::TestWithParam<std::string> {};

TEST_P(BenchProgram, EndsWellWithFiniteResultsForATinyWorkload) {
  const ProgramFolder folder(fmt::format("{}/{}", TYPODONT_BENCH_FOLDER, GetParam()));
  const Ran ran = expect_ok(folder.run("--smoke"));
  EXPECT_NE(ran.out.find("iterations:1"), std::string::npos) << "no case ran";
}

INSTANTIATE_TEST_SUITE_P(Programs, BenchProgram, testing::ValuesIn(benches()),
                         [](const auto& param) { return param.param; });

TEST(Card, TheBundleMeasuresFramesAndPassesWithItsOwnProgramAndAssets) {
  const ProgramFolder python("/usr/bin/python3");
  const std::string scene = python.write("scene.json", R"({"name": "block", "tissue": {"voxel_mm": 0.25, "solids": [
    {"tissue": "enamel", "solid": {"box": {"center_mm": [6.8, 5.5, 15], "size_mm": [10, 10, 8]}}}]},
    "tool": "round_012", "parts": ["haptics", "render"]})");
  expect_ok(python.run(fmt::format("tests/bench/card.py bundle {} {}", TYPODONT_PROGRAM, python / "card.tar")));
  expect_ok(ProgramFolder("tar").run(fmt::format("xf {} -C {}", python / "card.tar", python.path().string())));
  const Ran ran = expect_ok(python.run(
      fmt::format("{} measure --scenes {} --levels bare --sizes 64x64,96x64", python / "card/card.py", scene)));
  const std::string row = fmt::format("| {} | bare |", scene);
  std::size_t rows = 0;
  for (std::size_t at = 0; (at = ran.out.find(row, at)) != std::string::npos; ++at) ++rows;
  EXPECT_EQ(rows, 3u) << "frames, and the passes of both sizes\n" << ran.out;
  for (const char* head : {"| 64x64 | 96x64 | cold command, s | core-seconds |", "| shadow | ", "| tissue | "})
    EXPECT_NE(ran.out.find(head), std::string::npos) << head << "\n" << ran.out;
}

/// Returns the functions and variables that a program or library defines. `kinds`: letters of nm; the linker makes the
/// symbols of a program local.
std::set<std::string> defined_in(const std::string& file, const std::string& kinds = "TDBR") {
  const ProgramFolder nm("/usr/bin/nm");
  std::istringstream lines(nm.run(fmt::format("-C --defined-only {}", file)).out);
  std::set<std::string> names;
  for (std::string line; std::getline(lines, line);) {
    const std::size_t kind = line.find(' ');
    if (kind == std::string::npos || kinds.find(line[kind + 1]) == std::string::npos) continue;
    names.insert(line.substr(kind + 3));
  }
  return names;
}

TEST(Product, ContainsNothingOfABenchmark) {
  std::set<std::string> product = defined_in(TYPODONT_PROGRAM, "TDBRtdb");
  EXPECT_GT(product.size(), 1000u) << "symbols of the program";
  for (const std::string& name : product) {
    EXPECT_FALSE(name.starts_with("typodont::bench::") || name.starts_with("typodont::test::") ||
                 name.starts_with("benchmark::"))
        << name;
  }
  // What all programs define for themselves, such as main(), does not count.
  const std::set<std::string> common{"main",       "_start",       "_init",         "_fini",
                                     "data_start", "__data_start", "_IO_stdin_used"};
  std::set<std::string> laboratory = defined_in(fmt::format("{}/libtypodont_bench_main.a", TYPODONT_BENCH_FOLDER));
  laboratory.merge(defined_in(fmt::format("{}/libtypodont_bench_level_set.a", TYPODONT_BENCH_FOLDER)));
  laboratory.merge(defined_in(fmt::format("{}/libtypodont_test_tissues.a", TYPODONT_BENCH_FOLDER)));
  EXPECT_GT(laboratory.size(), 20u);
  for (const std::string& name : laboratory) EXPECT_TRUE(common.contains(name) || !product.contains(name)) << name;
}

}  // namespace
}  // namespace typodont::test
