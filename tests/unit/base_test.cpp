#include <fmt/format.h>
#include <gmock/gmock.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "engine/base/cache.h"
#include "engine/base/csv.h"
#include "engine/base/json.h"
#include "engine/base/keys.h"
#include "engine/base/log.h"
#include "engine/base/measure.h"
#include "engine/base/partial_file.h"
#include "engine/base/pose.h"
#include "engine/base/ticker.h"
#include "engine/base/units.h"
#include "engine/contract/tissue.h"
#include "tests/support/folder.h"
#include "tests/support/no_alloc.h"

namespace typodont {
namespace {

using test::read_text, test::refusal;
using testing::HasSubstr;

std::filesystem::path temporary(const std::string& name, const std::string& text) {
  const auto file = std::filesystem::temp_directory_path() / ("typodont_base_" + name);
  std::ofstream(file) << text;
  return file;
}

TEST(Ticker, ItsTimeBeginsWithTheFirstSampleHoweverLateThatIs) {
  Ticker ticker(1000);
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  const Nanos began = now();
  for (int i = 0; i <= 20; ++i) EXPECT_EQ(ticker.next(), i * Nanos(1'000'000));
  EXPECT_GE(now() - began, 20'000'000);
}

TEST(Pose, AngleAndPathBetweenTwoPosesUseTheShorterRotation) {
  using namespace literals;
  const dvec3 axis = glm::normalize(dvec3(1, -2, 3));
  const dquat a = glm::angleAxis(20.0_deg, dvec3(0, 1, 0));
  for (const double turn : {0.0, 1e-3, 0.4, 3.1}) {
    const dquat b = glm::angleAxis(turn, axis) * a;
    EXPECT_NEAR(rotation_angle(a, b), turn, 1e-7);
    EXPECT_NEAR(rotation_angle(a, -b), turn, 1e-7) << "the same rotation";
    EXPECT_NEAR(displacement_bound({{0, 0, 0}, a}, {{3, 4, 0}, b}, 2), 5 + 2 * turn, 1e-6);
  }
}

TEST(Pose, RotationBetweenAlsoTurnsOppositeVectors) {
  for (const dvec3 to : {dvec3(0, 0, 1), dvec3(0, 0, -1), dvec3(1, 0, 0), glm::normalize(dvec3(1, -2, 3))}) {
    EXPECT_LT(glm::length(rotation_between({0, 0, 1}, to) * dvec3(0, 0, 1) - to), 1e-12);
  }
}

TEST(Tissue, NamesAndNumbersConvertBothWays) {
  for (int i = 0; i < kTissueCount; ++i) {
    EXPECT_EQ(tissue_named(name_of(static_cast<Tissue>(i))), static_cast<Tissue>(i));
  }
  EXPECT_FALSE(tissue_named("chalk"));
}

enum class Edge { kBlade, kGrit };
struct Bur {
  double diameter = 1.2e-3;
  int blades = 0;
  Edge edge = Edge::kGrit;
  std::vector<dvec3> marks;
};
void describe_bur(Keys& keys, Bur& bur) {
  keys(must("diameter_mm"), bur.diameter, {0.05, 60, kMillimetre}, "[largest](#head) diameter");
  keys("blades", bur.blades, {1, 64}, "number of blades");
  keys("edge", bur.edge, {"blade", "grit"}, "kind of edge");
  keys(
      "marks", bur.marks, [](Keys& mark, dvec3& at) { mark(must("at_mm"), at, kMillimetre, "its place"); }, "marks");
}

TEST(Keys, OneDescriptionReadsAFileAndFillsATableAndASchema) {
  Bur bur;
  read_keys(Json::parse(R"({"diameter_mm": 2, "edge": "blade", "marks": [{"at_mm": [0, 0, 3]}]})", "f.json"),
            [&](Keys& keys) { describe_bur(keys, bur); });
  EXPECT_EQ(bur.diameter, 2e-3);
  EXPECT_EQ(bur.blades, 0);
  EXPECT_EQ(bur.edge, Edge::kBlade);
  EXPECT_EQ(bur.marks.at(0).z, 3e-3);
  const auto refused = [&](const char* text) {
    return test::refusal([&] { read_keys(Json::parse(text, "f.json"), [&](Keys& keys) { describe_bur(keys, bur); }); });
  };
  EXPECT_EQ(refused("{}"), R"(f.json: line 1, "diameter_mm": found nothing, expected this key)");
  EXPECT_EQ(refused(R"({"diameter_mm": 99})"), R"(f.json: line 1, "diameter_mm": found 99, expected 0.05 to 60)");
  EXPECT_THAT(refused(R"({"diameter_mm": 2, "edge": "saw"})"), HasSubstr("expected blade or grit"));
  EXPECT_THAT(
      refused(R"({"diameter_mm": 2, "blade": 6})"),
      HasSubstr("found an unknown key (is \"blades\" meant?), expected one of diameter_mm, blades, edge, marks"));
  EXPECT_THAT(refused(R"({"diameter_mm": 2, "egde": "grit"})"), HasSubstr("(is \"edge\" meant?)"));
  EXPECT_THAT(refused(R"({"diameter_mm": 2, "colour": "red"})"), HasSubstr("found an unknown key, expected one of"));
  EXPECT_THAT(refused(R"({"diameter_mm": 2, "marks": [{"at_mm": [0, 0]}]})"), HasSubstr("\"marks[0].at_mm\""));

  std::vector<KeyRow> rows;
  Keys keys(rows);
  describe_bur(keys, *std::make_unique<Bur>());
  EXPECT_EQ(key_tables("bur", rows), R"(bur:
|key|value|meaning|
|---|---|---|
|`diameter_mm`|0.05–60; required|[largest](#head) diameter|
|`blades`|1–64|number of blades|
|`edge`|`"blade"`, `"grit"`; default `"grit"`|kind of edge|
|`marks`|list of objects|marks|
|`marks.at_mm`|[x, y, z]; required|its place|
)");
  const Json schema = Json::parse(key_schema(rows), "schema");
  EXPECT_EQ(schema["required"].text(), R"(["diameter_mm"])");
  EXPECT_EQ(schema["properties"]["diameter_mm"]["description"].string(), "largest diameter");
  EXPECT_EQ(schema["properties"]["marks"]["items"]["properties"].keys().size(), 1u);
}

TEST(Keys, AnObjectHasTheKeysOfOneAlternativeAndMayContainItself) {
  double radius = 0, width = 0, height = 1e-3;
  const auto describe = [&](Keys& keys) {
    keys.alternative();
    keys(must("radius_mm"), radius, {0, 9, kMillimetre}, "radius");
    keys.alternative();
    keys(must("width_mm"), width, {0, 9, kMillimetre}, "width");
    keys("height_mm", height, {0, 9, kMillimetre}, "height");
    keys.alternative();
    keys(must("union"), kSolids, "parts");
  };
  read_keys(Json::parse(R"({"width_mm": 2})", "f.json"), describe);
  EXPECT_EQ(width, 2e-3);
  EXPECT_EQ(radius, 0);
  const auto refused = [&](const char* text) {
    return test::refusal([&] { read_keys(Json::parse(text, "f.json"), describe); });
  };
  EXPECT_THAT(refused("{}"), HasSubstr("found {}, expected an object with one of radius_mm, width_mm, union"));
  EXPECT_EQ(refused(R"({"radius_mm": 1, "height_mm": 1})"),
            R"(f.json: line 1, "height_mm": found height_mm beside radius_mm, expected one of them)");
  EXPECT_THAT(refused(R"({"widht_mm": 1})"), HasSubstr("(is \"width_mm\" meant?)"));
  EXPECT_THAT(refused(R"({"height_mm": 1})"), HasSubstr("\"width_mm\": found nothing, expected this key"));

  height = 1e-3;
  std::vector<KeyRow> rows;
  Keys keys(rows);
  keys.define("solid", describe);
  keys("shape", kSolid, "a shape");
  EXPECT_EQ(key_tables("bur", rows), R"(bur:
|key|value|meaning|
|---|---|---|
|`shape`|solid|a shape|

bur.solid:
|key|value|meaning|
|---|---|---|
|`radius_mm`|0–9|radius|
|`width_mm`|0–9|width|
|`height_mm`|0–9; default 1|height|
|`union`|list of solids|parts|
)");
  const Json schema = Json::parse(key_schema(rows), "schema");
  EXPECT_EQ(schema["properties"]["shape"]["$ref"].string(), "#/$defs/solid");
  EXPECT_EQ(schema["$defs"]["solid"]["anyOf"].items().size(), 3u);
}

TEST(Csv, TablesOfSpreadsheetsAreReadAsTheyAreWritten) {
  const std::vector<std::vector<double>> rows = {{-66.296, 1}, {13.146, 2.5}};
  for (const char* text : {"t_s,x_mm\n-66.296,1\n13.146,2.5\n", "t_s;x_mm\r\n-66,296;1\r\n13,146;2,5\r\n",
                           "t_s;x_mm\n-66.296;1\n13.146;2.5\n", "t_s\tx_mm\n-66,296\t1\n13,146\t2,5\n",
                           "\"t_s\",\"x_mm\"\n-66.296,1\n\"13.146\", 2.5\n,\n,\n"}) {
    EXPECT_EQ(read_csv(temporary("s.csv", text), {"t_s", "x_mm"}).rows, rows) << text;
  }
}

TEST(Csv, MixedDecimalMarksAndOtherTextFormatsAreNamed) {
  const auto reason = [](const std::string& text) {
    return refusal([&] { read_csv(temporary("m.csv", text), {"t_s", "x_mm"}); });
  };
  EXPECT_THAT(reason("t_s;x_mm\n0,5;1.5\n"),
              HasSubstr("column x_mm: found \"1.5\", expected a finite number with a dec"));
  EXPECT_THAT(reason("t_s;x_mm\n0.5;1,5\n"), HasSubstr("found \"1,5\", expected a finite number"));
  EXPECT_THAT(reason("t_s;x_mm\n1.234,5;1\n"), HasSubstr("found \"1.234,5\""));
  EXPECT_THAT(reason("t_s,x_mm\r0,1\r1,2\r"), HasSubstr("line 1: found lines that end with CR alone"));
  EXPECT_THAT(reason(std::string("\xFF\xFEt\0_\0s\0\n\0", 11)), HasSubstr("UTF-16"));
}

TEST(Csv, UnknownMissingAndRaggedColumnsAreErrors) {
  EXPECT_THAT(refusal([] { read_csv(temporary("a.csv", "t_s,y\n"), {"t_s"}); }), HasSubstr("column \"y\""));
  EXPECT_THAT(refusal([] { read_csv(temporary("b.csv", "t_s\n"), {"t_s", "x"}); }), HasSubstr("no column \"x\""));
  EXPECT_THAT(refusal([] { read_csv(temporary("c.csv", "t_s\n1,2\n"), {"t_s"}); }), HasSubstr("2 cells"));
  EXPECT_THAT(refusal([] { read_csv("/nowhere/d.csv", {"t_s"}); }), HasSubstr("No such file"));
}

TEST(PartialFile, ADiscardedFileLeavesNothingAndKeepsTheOldFile) {
  const auto file = temporary("kept.txt", "before");
  std::filesystem::path written;
  {
    PartialFile partial(file);
    written = partial.path();
    std::ofstream(written) << "half";
  }
  EXPECT_FALSE(std::filesystem::exists(written));
  EXPECT_EQ(read_text(file), "before");
  PartialFile partial(file);
  std::ofstream(partial.path()) << "after";
  partial.keep();
  EXPECT_FALSE(std::filesystem::exists(written));
  EXPECT_EQ(read_text(file), "after");
}

TEST(PartialFile, DeletesTheRemainsOfAKilledProcessAndKeepsTheFileOfARunningOne) {
  const pid_t dead = fork();
  if (dead == 0) _exit(0);
  waitpid(dead, nullptr, 0);
  const auto file = temporary("left.txt", "");
  const auto named = [&](pid_t process, const char* rest) {
    return temporary(fmt::format("left.txt.{}.0123456789abcdef{}", process, rest), "");
  };
  const auto left = named(dead, ".partial"), other_kind = named(dead, ".log.partial"),
             living = named(getppid(), ".partial");
  const auto no_process = temporary("left.txt.notes.partial", "");
  const PartialFile partial(file);
  EXPECT_FALSE(std::filesystem::exists(left));
  for (const auto& stays : {file, other_kind, living, no_process}) {
    EXPECT_TRUE(std::filesystem::exists(stays)) << stays;
    std::filesystem::remove(stays);
  }
}

TEST(Tests, WriteOnlyIntoTheirBuildFolder) {
  const auto program = std::filesystem::read_symlink("/proc/self/exe");  // BUILD/tests/unit_base
  EXPECT_EQ(cache::folder(), program.parent_path().parent_path() / "cache/typodont");
}

TEST(Cache, KeepsAndFindsNothingIfThereIsNoFolder) {
  EXPECT_EQ(cache::folder("light"), cache::folder() / "light");
  bool written = false;
  EXPECT_FALSE(cache::keep({}, 1, ".rays", 1000, [&](const auto&) { written = true; }));
  EXPECT_FALSE(written);
  EXPECT_TRUE(cache::find({}, 1, ".rays").empty());
}

TEST(NoAllocGuard, SeesAnAllocation) {
  test::NoAlloc guard;
  EXPECT_EQ(guard.count(), 0u);
  auto p = std::make_unique<int>(3);
  EXPECT_GE(guard.count(), 1u);
}

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST(FreedMemory, OfLargeArraysIsUsedAgainWithoutPageFaults) {
  constexpr std::size_t kBytes = 20 << 20;
  const auto use = [] {
    const std::vector<char> arrays[3] = {std::vector<char>(kBytes, 1), std::vector<char>(kBytes, 2),
                                         std::vector<char>(kBytes, 3)};
    int sum = 0;
    for (const auto& array : arrays) sum += array[kBytes / 2];
    return sum;
  };
  const auto faults = [] {
    rusage used{};
    getrusage(RUSAGE_SELF, &used);
    return used.ru_minflt;
  };
  for (int i = 0; i < 2; ++i) EXPECT_EQ(use(), 6);  // after that, the allocator has the memory
  const long before = faults();
  EXPECT_EQ(use(), 6);
  EXPECT_LT(faults() - before, 500) << "60 MiB have 15,360 pages";
}
#endif

TEST(EvenSample, IsExactWhileItFitsAndLaterEvenlySpreadOverTheWholeLength) {
  EvenSample few, many;
  for (int i = 0; i < 1001; ++i) few.add(1000 - i);
  EXPECT_EQ(few.quantile(0.5), 500);
  EXPECT_EQ(EvenSample().quantile(0.5), 0);
  const auto n = 5 * static_cast<int>(EvenSample::kMost);
  for (int i = 0; i < n; ++i) many.add(i);
  for (const double fraction : {0.1, 0.5, 0.999})
    EXPECT_NEAR(many.quantile(fraction), fraction * n, 1e-4 * n) << fraction;
}

TEST(Log, ControlCharactersOfANameDoNotReachTheTerminal) {
  testing::internal::CaptureStderr();
  log::warn("left out: {}", "a\x1b]0;title\a\rb.h5");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "warning: left out: a?]0;title??b.h5\n");
}

TEST(Log, AMessageForWhichThereIsNoRoomIsDroppedCountedAndStatedLater) {
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  const int standard_error = ::dup(STDERR_FILENO);
  ::dup2(ends[1], STDERR_FILENO);
  std::string said;
  const std::uint64_t dropped_before = log::dropped();
  const std::string text(1000, 'x');
  int written = 0;
  for (; log::dropped() == dropped_before && written < 1000; ++written) log::warn("{} {}", written, text);
  for (int i = 0; i < 9; ++i) log::warn("{} {}", i, text);
  std::vector<char> bytes(1 << 20);
  const auto read_all = [&] {
    const ssize_t n = ::read(ends[0], bytes.data(), bytes.size());
    return std::string(bytes.data(), static_cast<std::size_t>(std::max<ssize_t>(n, 0)));
  };
  read_all();
  log::info("again");
  said = read_all();
  ::close(ends[0]);
  log::info("nobody reads this");  // with SIGPIPE, this would end the program
  ::dup2(standard_error, STDERR_FILENO);
  ::close(ends[1]), ::close(standard_error);
  EXPECT_LT(written, 1000);
  EXPECT_EQ(said, "warning: 10 messages before this one could not be written\nagain\n");
  EXPECT_EQ(log::dropped() - dropped_before, 11u);
}

}  // namespace
}  // namespace typodont
