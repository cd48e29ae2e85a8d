// Work of the operator's window on another thread, and what follows at its end.
#include <gtest/gtest.h>

#include <stdexcept>
#include <thread>

#include "engine/app/operator/job.h"

namespace typodont {
namespace {

void wait_for_end(const Job& job) {
  while (!job.done()) std::this_thread::yield();
}

TEST(OperatorJob, TheResultIsTakenByTheThreadThatLooks) {
  Job job;
  std::thread::id worked, taken;
  int result = 0;
  job.make(
      [&](Progress&) {
        worked = std::this_thread::get_id();
        return 7;
      },
      [&](int made) {
        taken = std::this_thread::get_id();
        result = made;
      });
  wait_for_end(job);
  EXPECT_EQ(result, 0);
  EXPECT_TRUE(job.look());
  EXPECT_EQ(result, 7);
  EXPECT_EQ(taken, std::this_thread::get_id());
  EXPECT_NE(worked, taken);
  EXPECT_FALSE(job.under_way());
  EXPECT_FALSE(job.look());
}

TEST(OperatorJob, OfDroppedOrReplacedWorkNothingFollows) {
  Job job;
  int old = 0, fresh = 0;
  const auto until_cancelled = [](Progress& progress) {
    for (;;) progress.at(0);
  };
  job.begin(
      until_cancelled, [&] { ++old; }, [&](const std::exception&) { ++old; });
  job.begin([](Progress&) {}, [&] { ++fresh; });
  wait_for_end(job);
  EXPECT_TRUE(job.look());
  EXPECT_EQ(fresh, 1);
  job.begin(
      until_cancelled, [&] { ++old; }, [&](const std::exception&) { ++old; });
  job.drop();
  EXPECT_FALSE(job.look());
  EXPECT_EQ(old, 0);
}

TEST(OperatorJob, AFailureIsHandledOrThrownByTheThreadThatLooks) {
  Job job;
  const auto fails = [](Progress&) { throw std::runtime_error("why"); };
  std::string reason;
  job.begin(
      fails, [] { FAIL(); }, [&](const std::exception& e) { reason = e.what(); });
  wait_for_end(job);
  EXPECT_TRUE(job.look());
  EXPECT_EQ(reason, "why");
  job.begin(fails, [] { FAIL(); });
  wait_for_end(job);
  EXPECT_THROW(job.look(), std::runtime_error);
  EXPECT_FALSE(job.under_way());
}

}  // namespace
}  // namespace typodont
