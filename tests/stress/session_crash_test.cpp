// Tests the state of a recording after the program died, the disk failed, or the file was damaged.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <iterator>

#include "engine/base/clock.h"
#include "engine/base/error.h"
#include "engine/session/recorder.h"
#include "engine/session/session_file.h"
#include "tests/support/session_fixture.h"

namespace typodont::session {
namespace {

using namespace test;

struct Child {
  pid_t pid;
  int pipe;  // its messages
};

/// Runs `body` in a child process. The argument of `body` is the end of a pipe for writing.
template <class Body>
Child spawn(Body body) {
  int ends[2];
  EXPECT_EQ(pipe(ends), 0);
  const pid_t pid = fork();
  if (pid == 0) {
    close(ends[0]);
    body(ends[1]);
    _exit(0);
  }
  close(ends[1]);
  return {pid, ends[0]};
}

/// Records a session at 1 kHz in real time without an end. After each millisecond it writes to `out` which tick it has
/// given to the recorder.
void record_for_ever(const std::filesystem::path& file, int out) {
  SessionWriter writer(file, some_header());
  Random random(11);
  const Nanos begin = now();
  for (std::uint64_t i = 0;; ++i) {
    ServoTick tick = random_tick(i, random);
    tick.cuts = i / 2;
    if (i % 2 == 0 && i > 0) {
      Cut cut;
      cut.index = i / 2;
      cut.tick = i;
      writer.append(std::span(&cut, 1));
    }
    if (i % 100 == 0) {
      PatchUse patch;
      patch.patch = static_cast<std::uint32_t>(i / 100 + 1);
      patch.first_tick = i;
      writer.append(std::span(&patch, 1));
      writer.event(tick.t, EventKind::kNote, "tick " + std::to_string(i));
    }
    writer.append(std::span(&tick, 1));
    writer.heartbeat();
    if (write(out, &i, sizeof i) != sizeof i) _exit(1);
    while (now() < begin + static_cast<Nanos>(i + 1) * 1'000'000) usleep(200);
  }
}

TEST(KilledRecording, LosesAtMostTheLastSecondAndOpens) {
  TemporaryFolder folder;
  // Kills the recording at moments before, at and between the times at which the recorder writes to the disk.
  for (const int kill_after_ms : {40, 530, 777, 1031, 1444, 2063}) {
    const auto file = folder / ("killed_" + std::to_string(kill_after_ms) + ".h5");
    const Child child = spawn([&](int out) { record_for_ever(file, out); });
    const Nanos begin = now();
    std::uint64_t handed_over = 0, value;
    bool started = false;
    Nanos deadline = begin + 30 * kNanosPerSecond;
    while (now() < deadline && read(child.pipe, &value, sizeof value) == sizeof value) {
      handed_over = value;
      if (!started) {
        started = true;
        deadline = now() + kill_after_ms * 1'000'000LL;
      }
    }
    kill(child.pid, SIGKILL);
    while (read(child.pipe, &value, sizeof value) == sizeof value) handed_over = value;
    waitpid(child.pid, nullptr, 0);
    close(child.pipe);

    const auto check = [&](const SessionReader& reader) {
      EXPECT_TRUE(reader.truncated());
      EXPECT_FALSE(reader.being_recorded());
      EXPECT_FALSE(reader.result());
      EXPECT_GE(reader.tick_count() + 1000, handed_over) << "killed after " << kill_after_ms << " ms";
      EXPECT_EQ(reader.header().scene_json, some_header().scene_json);
      // The recorded ticks must be correct, and every tick must have its cuts and its patch.
      Random random(11);
      const auto ticks = reader.ticks();
      for (std::size_t i = 0; i < ticks.size(); ++i) {
        ServoTick expected = random_tick(i, random);
        expected.cuts = i / 2;
        ASSERT_TRUE(same_for_replay(expected, ticks[i])) << i;
      }
      if (!ticks.empty()) {
        EXPECT_GE(reader.cuts().size(), ticks.back().cuts);
        EXPECT_GE(reader.patches().size(), ticks.back().index / 100 + 1);
      }
    };
    check(SessionReader(file));
    EXPECT_TRUE(repair_session(file));
    check(SessionReader(file));
    EXPECT_FALSE(repair_session(file)) << "the second time there is nothing to do";
  }
}

TEST(LiveRecording, AnotherProcessCanReadItAndSeesThatItIsStillBeingRecorded) {
  TemporaryFolder folder;
  int go[2];
  ASSERT_EQ(pipe(go), 0);
  // The reader's process starts before the writer opens the file, because HDF5 shares an open file within one process.
  const Child child = spawn([&](int out) {
    char byte;
    if (read(go[0], &byte, 1) != 1) _exit(1);
    std::uint64_t answer[3] = {};
    try {
      const SessionReader reader(folder / "live.h5");
      answer[0] = reader.tick_count();
      answer[1] = reader.being_recorded();
      answer[2] = repair_session(folder / "live.h5");
    } catch (const std::exception&) {
      answer[0] = ~0u;
    }
    if (write(out, answer, sizeof answer) != sizeof answer) _exit(1);
  });
  SessionWriter writer(folder / "live.h5", some_header());
  writer.append(random_ticks(700, 12));
  writer.flush();
  ASSERT_EQ(write(go[1], "g", 1), 1);
  std::uint64_t answer[3] = {};
  EXPECT_EQ(read(child.pipe, answer, sizeof answer), static_cast<ssize_t>(sizeof answer));
  waitpid(child.pid, nullptr, 0);
  for (const int fd : {child.pipe, go[0], go[1]}) close(fd);
  EXPECT_EQ(answer[0], 700u);
  EXPECT_EQ(answer[1], 1u);
  EXPECT_EQ(answer[2], 0u);
  EXPECT_TRUE(writer.finish({}));
}

TEST(FailingDisk, IsCountedAndReportedAndEarlierDataStayReadable) {
  TemporaryFolder folder;
  const auto file = folder / "s.h5";
  const Child child = spawn([&](int out) {
    // The system refuses to let the file grow over 1 MB, as a full disk or a quota would.
    signal(SIGXFSZ, SIG_IGN);
    SessionWriter writer(file, some_header());
    rlimit limit{1 << 20, 1 << 20};
    setrlimit(RLIMIT_FSIZE, &limit);
    for (std::uint64_t i = 0; i < 20; ++i) writer.append(random_ticks(512, 100 + i, 512 * i));
    const std::uint64_t finished = writer.finish({});
    const std::uint64_t answer[4] = {writer.status().ticks, writer.status().lost.ticks_disk,
                                     writer.status().state == WriterStatus::State::kFailed &&
                                         writer.status().message.find("File too large") != std::string::npos,
                                     finished};
    if (write(out, answer, sizeof answer) != sizeof answer) _exit(1);
  });
  std::uint64_t answer[4] = {};
  EXPECT_EQ(read(child.pipe, answer, sizeof answer), static_cast<ssize_t>(sizeof answer));
  int status = 0;
  waitpid(child.pid, &status, 0);
  close(child.pipe);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(answer[0] + answer[1], 20u * 512) << "every tick is either written or counted";
  EXPECT_GT(answer[1], 0u);
  EXPECT_EQ(answer[2], 1u);
  EXPECT_EQ(answer[3], 0u);
  const SessionReader reader(file);
  EXPECT_TRUE(reader.truncated());
  ASSERT_GE(reader.tick_count(), 512u);
  const auto first = random_ticks(512, 100);
  const auto back = reader.ticks(0, 512);
  for (std::size_t i = 0; i < 512; ++i) ASSERT_TRUE(same_for_replay(first[i], back[i]));
}

std::string whole_session(const TemporaryFolder& folder) {
  SessionWriter writer(folder / "whole.h5", some_header());
  for (std::uint64_t i = 0; i < 4; ++i) {
    writer.append(random_cuts(100, i, 1 + 100 * i));
    writer.append(random_ticks(512, 200 + i, 512 * i));
  }
  writer.event(1, EventKind::kNote, "a note");
  SessionResult result;
  result.pictures = {{"after", "", {1, 2, 3}}};
  EXPECT_TRUE(writer.finish(result));
  return read_text(folder / "whole.h5");
}

TEST(ShortenedFile, IsReadUpToItsEndOrRefused) {
  TemporaryFolder folder;
  const std::string whole = whole_session(folder);
  std::uint64_t most = 0;
  int opened = 0;
  for (int i = 1; i < 60; ++i) {
    std::ofstream(folder / "short.h5", std::ios::binary) << whole.substr(0, whole.size() * i / 60);
    try {
      const SessionReader reader(folder / "short.h5");
      ++opened;
      EXPECT_TRUE(reader.truncated());
      const auto ticks = reader.ticks();
      for (std::size_t k = 0; k < ticks.size(); k += 512) {
        const auto expected = random_ticks(512, 200 + k / 512, k);
        for (std::size_t j = 0; j < 512 && k + j < ticks.size(); ++j)
          ASSERT_TRUE(same_for_replay(expected[j], ticks[k + j]));
      }
      most = std::max(most, reader.tick_count());
    } catch (const Error& e) {
      EXPECT_THAT(e.what(), testing::HasSubstr("short.h5"));
    }
  }
  EXPECT_GT(opened, 20);
  EXPECT_GE(most, 1024u) << "a file that lacks its last sixtieth still holds most of its ticks";
}

TEST(DamagedFile, IsNeverReadWithWrongContent) {
  TemporaryFolder folder;
  const std::string whole = whole_session(folder);
  std::mt19937_64 random(31);
  int detected = 0;
  for (int i = 0; i < 400; ++i) {
    std::string bytes = whole;
    // The first bytes contain the superblock and the header of the file. In half of the runs, only these bytes are
    // damaged.
    const std::size_t range = i % 2 ? bytes.size() : std::min<std::size_t>(bytes.size(), 20'000);
    for (std::uint64_t k = 0; k < 1 + random() % 4; ++k) {
      bytes[random() % range] = static_cast<char>(random());
    }
    std::ofstream(folder / "damaged.h5", std::ios::binary) << bytes;
    try {
      const SessionReader reader(folder / "damaged.h5");
      const auto ticks = reader.ticks();
      if (reader.truncated()) continue;
      ASSERT_EQ(ticks.size(), 2048u);
      const auto expected = random_ticks(512, 200);
      for (std::size_t j = 0; j < 512; ++j) ASSERT_TRUE(same_for_replay(expected[j], ticks[j]));
    } catch (const Error&) {
      ++detected;
    }
  }
  EXPECT_GT(detected, 50);
}

}  // namespace
}  // namespace typodont::session
