// A program that the window starts gets its input through memory, and its lines are read while it runs.
#include <gtest/gtest.h>

#include "engine/app/operator/child.h"

namespace typodont {
namespace {

TEST(OperatorChild, AProgramReadsItsInputAndIsHeardLineByLine) {
  Progress progress;
  std::vector<std::string> lines;
  const std::string input = "one\ntwo " + std::string(100'000, 'x') + "\nlast without an end";
  const std::string output = run_program(
      {"cat"}, progress, {.input = input, .on_line = [&](std::string_view line) { lines.emplace_back(line); }});
  EXPECT_EQ(output, input);
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(lines[0], "one");
  EXPECT_EQ(lines[1].size(), 100'004u);
}

TEST(OperatorChild, AnAbsentProgramIsToldFromAFailedOne) {
  Progress progress;
  EXPECT_THROW(run_program({"typodont-is-no-such-program"}, progress, {}), NotStarted);
  try {
    run_program({"sh", "-c", "echo why >&2; exit 127"}, progress, {});
    FAIL() << "no failure";
  } catch (const NotStarted&) {
    FAIL() << "the program was there";
  } catch (const RunFailure& failure) {
    EXPECT_STREQ(failure.what(), "why");
  }
}

}  // namespace
}  // namespace typodont
