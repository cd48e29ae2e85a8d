// Tests `typodont bench` through the command line: rows, CSV and page.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "engine/app/bench/models_page.h"
#include "engine/app/bench/page_text.h"
#include "engine/app/bench/performance_page.h"
#include "engine/app/bench/row_origin.h"
#include "engine/app/bench/stored_rows.h"
#include "engine/app/bench/stress_page.h"
#include "engine/base/json.h"
#include "tests/support/program.h"

namespace typodont {
namespace {

using namespace test;
using testing::HasSubstr;

TEST(BenchCommand, MeasuresANamedPartAlsoIfACommandHasTheSameName) {
  ProgramFolder folder(TYPODONT_PROGRAM);
  const Ran ran = folder.run(fmt::format("bench sound recording --quick --json --out {0}/rows.csv --page {0}/page.md",
                                         folder.path().string()));
  ASSERT_EQ(ran.status, 0) << ran.err;
  bool sound = false, recording = false;
  for (const Json& row : Json::parse(ran.out, "out").items()) {
    const std::string part = row["part"].string();
    EXPECT_TRUE(part == "sound" || part == "recording") << part;
    sound |= part == "sound";
    recording |= part == "recording";
  }
  EXPECT_TRUE(sound);
  EXPECT_TRUE(recording);
  const std::string csv = read_text(folder / "rows.csv");
  EXPECT_EQ(csv.substr(0, 11), "# typodont ");
  EXPECT_THAT(csv, HasSubstr("\npart,case,knob,error,error_unit,time_ns,per,baseline,ratio,size,size_unit\n"));
  const std::string page = read_text(folder / "page.md");
  EXPECT_THAT(page, HasSubstr("## Sound"));
  EXPECT_THAT(page, HasSubstr("(page/sound_1.svg)"));
  EXPECT_THAT(read_text(folder / "page/sound_1.svg"), HasSubstr("</svg>"));
  // Measures one part again. The rows of the other part must stay the same.
  const Ran again = folder.run(
      fmt::format("bench recording --quick --keep {0}/rows.csv --out {0}/again.csv", folder.path().string()));
  ASSERT_EQ(again.status, 0) << again.err;
  const auto of_sound = [](const std::string& text) {
    return text.substr(text.find("\nsound,"), text.rfind("\nsound,") - text.find("\nsound,"));
  };
  EXPECT_EQ(of_sound(read_text(folder / "again.csv")), of_sound(csv));
  EXPECT_THAT(read_text(folder / "again.csv"), HasSubstr("\nrecording,"));
}

TEST(BenchCommand, EveryPartThatNeedsNoPictureRunsToItsEnd) {
  ProgramFolder folder(TYPODONT_PROGRAM);
  const Ran ran = folder.run(
      fmt::format("bench contact stability devices debris calibration scaling --quick --out {}", folder / "rows.csv"));
  ASSERT_EQ(ran.status, 0) << ran.err;
  const std::string csv = read_text(folder / "rows.csv");
  for (const char* part : {"contact", "stability", "devices", "debris", "calibration", "scaling"}) {
    EXPECT_THAT(csv, HasSubstr(fmt::format("\n{},", part)));
  }
}

TEST(BenchCommand, ModelMeasuresThatContactModelAndIsRefusedForPartsThatHaveNone) {
  ProgramFolder folder(TYPODONT_PROGRAM);
  const Ran ran = folder.run("bench contact --model voxel_penalty --quick --json");
  ASSERT_EQ(ran.status, 0) << ran.err;
  bool removal = false;
  for (const Json& row : Json::parse(ran.out, "out").items()) {
    removal |= row["case"].string() == "removal, voxel_penalty";
    EXPECT_NE(row["case"].string(), "direction, cubic");  // a query of the default model
  }
  EXPECT_TRUE(removal);
  EXPECT_EQ(folder.run("bench sound --model voxel_penalty --quick").status, 2);
  EXPECT_EQ(folder.run("bench --model voxel_penalty --quick").status, 2);
  EXPECT_THAT(folder.run("bench contact --model nothing --quick").err, HasSubstr("voxel_penalty"));
}

TEST(StressPage, AModelThatLosesTheHandFallsAndOneWithOtherDefectsIsFlawed) {
  const auto row = [](const char* name, double error, double ratio) {
    return BenchRow{.name = name, .error = error, .error_unit = "N a tick", .baseline = "none passes", .ratio = ratio};
  };
  const std::vector<SurvivalCell> cells =
      survival_of({row("200 N, a: not finite", 0, 0), row("200 N, a: energy given", 0.5, 0.5),
                   row("200 N, b: energy given", 7, 7), row("200 N, b: step", 3, 12),
                   row("200 N, c: energy given", 900, 900), row("200 N, c: escaped", 2, 3), row("no campaign", 1, 1)});
  ASSERT_EQ(cells.size(), 3u);
  EXPECT_EQ(cells[0].survival, Survival::kSurvived);
  EXPECT_EQ(cells[0].worst, "");
  EXPECT_EQ(cells[1].survival, Survival::kFlawed);
  EXPECT_EQ(cells[1].worst, "step: 3 N");
  EXPECT_EQ(cells[2].survival, Survival::kFell);
  EXPECT_EQ(cells[2].worst, "escaped: 2 N");
}

TEST(PageText, TextIsBrokenAt120CharactersAndTablesHeadingsPicturesAndCodeStay) {
  std::string sentence = "µm words";
  for (int i = 0; i < 29; ++i) sentence.append(" µm words");
  const std::string kept = fmt::format("# {0}\n| {0} |\n![{0}](a.svg)\n```\n{0}\n```\nshort\n\nend", sentence);
  EXPECT_EQ(wrapped(kept), kept);
  const std::string item = fmt::format("- {}\n", sentence);
  const std::string broken = wrapped(item);
  // The item's first line must hold "- " and 13 times "µm words", 116 characters. "µ" has two bytes, but counts as one
  // character.
  EXPECT_EQ(broken.find('\n'), 2 + 13 * std::string("µm words ").size() - 1);
  EXPECT_EQ(broken.substr(broken.find('\n')).substr(0, 5), "\n  µ");
  std::string joined = broken;
  for (std::size_t at; (at = joined.find("\n  ")) != std::string::npos;) joined.erase(at, 2);
  EXPECT_EQ(joined, item);
}

TEST(PageText, APageOfThreeOrMoreSectionsBeginsWithLinksToThem) {
  const std::string two = "# Page\n\nText.\n\n## One\n\nA.\n\n## Two\n\nB.\n";
  EXPECT_EQ(with_contents(two), two);
  EXPECT_EQ(with_contents(two + "\n## How large (in mm)?\n\nC.\n"),
            "# Page\n\nText.\n\nContents: [One](#one), [Two](#two), [How large (in mm)?](#how-large-in-mm).\n"
            "\n## One\n\nA.\n\n## Two\n\nB.\n\n## How large (in mm)?\n\nC.\n");
  EXPECT_EQ(with_contents(""), "");
}

TEST(PerformancePage, FitsTheExponentOfAKnownPowerLaw) {
  std::vector<BenchRow> rows;
  for (const double n : {10.0, 100.0, 1000.0}) {
    rows.push_back({.name = "flat", .time_ns = 5, .size = n});
    rows.push_back({.name = "square", .time_ns = 3 * n * n, .size = n});
    rows.push_back({.name = "without size", .time_ns = n});
  }
  rows.push_back({.name = "once", .time_ns = 1, .size = 1});
  EXPECT_NEAR(growth_exponent(rows, "flat"), 0, 1e-12);
  EXPECT_NEAR(growth_exponent(rows, "square"), 2, 1e-12);
  EXPECT_TRUE(std::isnan(growth_exponent(rows, "without size")));
  EXPECT_TRUE(std::isnan(growth_exponent(rows, "once")));
}

TEST(PerformancePage, NamesTheMethodsOfOtherProgramsThatAreFasterAndNoOtherRows) {
  const MeasuredPart slow{nullptr,
                          {{.name = "whole", .time_ns = 200, .baseline = "volumeToMesh of the whole", .ratio = 2},
                           {.name = "frame", .time_ns = 50, .baseline = "volumeToMesh of the whole", .ratio = 0.5},
                           {.name = "point proxy", .time_ns = 300, .baseline = "the servo's slide", .ratio = 0.5},
                           {.name = "penalty", .time_ns = 900, .baseline = "the servo's slide", .ratio = 1.5},
                           {.name = "floor", .time_ns = 90, .baseline = "the scan", .ratio = 9}}};
  const std::string table = slower_table(std::vector{slow});
  EXPECT_THAT(table, HasSubstr("| whole |  | 200 ns | 100 ns | 2 | volumeToMesh of the whole |"));
  EXPECT_THAT(table, HasSubstr("| point proxy |  | 600 ns | 300 ns | 2 | the method in the first column |"));
  for (const char* other : {"frame", "penalty", "floor"}) EXPECT_THAT(table, testing::Not(HasSubstr(other)));
  EXPECT_THAT(slower_table({}), HasSubstr("No measured method"));
}

TEST(RowOrigin, ANameBelongsOnlyToTheNewestMeasurementAndEqualMachinesAreJoined) {
  std::vector<RowOrigin> origins = origins_of("B (motions, surface); all other parts: A");
  origins.insert(origins.begin(), {"B", {"contact"}});
  origins.insert(origins.begin(), {"C", {"surface"}});
  EXPECT_EQ(text_of(joined(origins)), "C (surface); B (contact, motions); all other parts: A");
}

TEST(RowOrigin, AMachineThatAlsoMeasuredAllOtherPartsIsNamedOnce) {
  EXPECT_EQ(text_of(joined({{"A", {"contact"}}, {"B", {"sound"}}, {"A", {}}})), "B (sound); all other parts: A");
  EXPECT_EQ(text_of(joined({{"A", {"contact"}}, {"A", {}}})), "A");
}

TEST(RowOrigin, ATextIsReadAsItWasWritten) {
  for (const char* text : {"A", "A (ball, box edges)", "A (ball); B (torus)", "A (ball); all other parts: B, 4 cores"})
    EXPECT_EQ(text_of(origins_of(text)), text);
}

TEST(BenchCommand, TissuesThatTwoRunsMeasuredAreMergedIntoOneTableInTheOrderOfAllTissues) {
  ProgramFolder folder(TYPODONT_PROGRAM);
  const std::string at = folder.path().string();
  for (const char* tissue : {"sheet of 0.5 mm", "sheet of 0.2 mm"}) {
    const Ran ran = folder.run(fmt::format(R"(bench models --quick --tissues "{1}" --out "{0}/{1}.csv")", at, tissue));
    ASSERT_EQ(ran.status, 0) << ran.err;
  }
  const Ran merged = folder.run(fmt::format(
      R"(bench models --merge --keep "{0}/sheet of 0.5 mm.csv,{0}/sheet of 0.2 mm.csv" --out {0}/all.csv)", at));
  ASSERT_EQ(merged.status, 0) << merged.err;
  const std::string all = read_text(folder / "all.csv");
  EXPECT_THAT(all.substr(0, all.find('\n')), HasSubstr("(sheet of 0.5 mm, sheet of 0.2 mm)"));
  EXPECT_LT(all.find("\"sheet of 0.2 mm, escape, offset"), all.find("\"sheet of 0.5 mm, escape, offset"));
  EXPECT_EQ(folder.run("bench models --tissues cube").status, 2);
  EXPECT_EQ(folder.run("bench sound --tissues ball").status, 2);
}

TEST(ModelsPage, TheRowsOfOtherLibrariesBesideItAreShown) {
  ProgramFolder folder(TYPODONT_PROGRAM);
  std::filesystem::create_directories(folder / "page");
  folder.write("page/peers.csv", std::string(kRowColumns) +
                                     "\nmodels,\"ball, drill, Peer: removal\",voxel 0.1 mm,58.7,"
                                     "% more than the swept volume,1,tick,,,,\n");
  write_models_page(folder / "page.md", {}, "made here");
  EXPECT_THAT(read_text(folder / "page.md"), HasSubstr("| model | ball |\n|---|---|\n| `Peer` | 58.7 |\n"));
}

TEST(ModelsPage, NamesAreReadAsTissueMotionModelAndMeasure) {
  const std::vector<BenchRow> rows{{.name = "box edges, slide, offset: step, asked"},
                                   {.name = "drilling tick, median"}};
  const std::vector<ModelFigure> figures = model_figures(rows);
  ASSERT_EQ(figures.size(), 1u);
  EXPECT_EQ(figures[0].tissue, "box edges");
  EXPECT_EQ(figures[0].motion, "slide");
  EXPECT_EQ(figures[0].model, "offset");
  EXPECT_EQ(figures[0].measure, "step, asked");
}

TEST(ModelsPage, RecommendsTheModelWithTheLeastErrorAmongThoseFastEnough) {
  std::vector<BenchRow> rows;
  const auto measured = [&](const std::string& model, double error, double slowest_us) {
    for (const char* tissue : {"ball", "torus"}) {
      const std::string name = std::string(tissue) + ", slide, " + model + ": ";
      rows.push_back({.name = name + "direction", .knob = "k", .error = error, .error_unit = "degree, rms"});
      rows.push_back({.name = name + "tick, 99.9 %", .knob = "k", .time_ns = 1e3 * slowest_us});
    }
  };
  measured("true but late", 0.001, 900);
  measured("true", 0.1, 100);
  measured("rough", 3, 1);
  EXPECT_EQ(tasks_won(model_figures(rows)), (std::map<std::string, int>{{"true", 1}}));
  EXPECT_TRUE(tasks_won({}).empty());
}

}  // namespace
}  // namespace typodont
