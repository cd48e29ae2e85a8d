// Tests which recordings a journal can change: only an unsigned one to which it belongs, and only on request.
#include <gmock/gmock.h>
#include <sys/resource.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "engine/base/error.h"
#include "engine/base/fnv.h"
#include "engine/session/format/journal.h"
#include "engine/session/recorder.h"
#include "engine/session/session_file.h"
#include "engine/session/signature.h"
#include "tests/support/session_fixture.h"

namespace typodont::session {
namespace {

using namespace test;
namespace fs = std::filesystem;

constexpr std::size_t kTicks = 900;

void write(const fs::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary) << bytes;
}

// The layout of a journal, as docs/session_format.md states it.
constexpr std::size_t kRecording = 8, kOldLength = 40, kLength = 48, kBytes = 56, kChecksum = 64, kChanges = 72;
std::uint64_t number_at(const std::string& journal, std::size_t place) {
  std::uint64_t n = 0;
  std::memcpy(&n, journal.data() + place, sizeof n);
  return n;
}
void set_number(std::string& journal, std::size_t place, std::uint64_t n) {
  std::memcpy(journal.data() + place, &n, sizeof n);
}
void seal(std::string& journal) {
  Fnv1a hash;
  hash.bytes(journal.data(), kChecksum);
  hash.bytes(journal.data() + kChanges, journal.size() - kChanges);
  set_number(journal, kChecksum, hash.value);
}

class JournalOfARecording : public testing::Test {
 protected:
  /// Leaves NAME and NAME.journal as a program does that is killed after its second flush.
  void record_and_kill(const std::string& name, std::uint64_t seed) const {
    {
      SessionWriter writer(folder_ / "live.h5", some_header());
      const auto ticks = random_ticks(kTicks, seed);
      writer.append(std::span(ticks).first(kTicks / 2));
      writer.flush();
      writer.append(std::span(ticks).subspan(kTicks / 2));
      writer.flush();
      fs::copy_file(folder_ / "live.h5", folder_ / name);
      const std::string journal = read_text(folder_ / "live.h5.journal");  // an earlier flush may have been longer
      write(folder_ / (name + ".journal"), journal.substr(0, kChanges + number_at(journal, kBytes)));
    }
    fs::remove(folder_ / "live.h5");
  }
  /// Undoes a part of the last flush, as a power failure between two sectors does.
  void tear(const std::string& name) const {
    const std::string journal = read_text(folder_ / (name + ".journal"));
    std::string file = read_text(folder_ / name);
    for (std::size_t at = kChanges; at < journal.size(); at += 16 + number_at(journal, at + 8)) {
      const std::uint64_t place = number_at(journal, at), size = number_at(journal, at + 8);
      if (place > 4096) std::memset(file.data() + place, 0, size);
    }
    write(folder_ / name, file);
  }
  std::size_t ticks_of(const std::string& name) const { return SessionReader(folder_ / name).ticks().size(); }

  TemporaryFolder folder_;
};

TEST_F(JournalOfARecording, IsAppliedByARepairAndByNoReader) {
  record_and_kill("s.h5", 5);
  tear("s.h5");
  const std::string torn = read_text(folder_ / "s.h5");
  std::size_t readable = 0;
  try {
    readable = ticks_of("s.h5");
  } catch (const Error& e) {
    EXPECT_THAT(e.what(), testing::HasSubstr("typodont repair"));
  }
  EXPECT_LT(readable, kTicks);
  EXPECT_EQ(read_text(folder_ / "s.h5"), torn);
  EXPECT_TRUE(repair_session(folder_ / "s.h5"));
  EXPECT_EQ(ticks_of("s.h5"), kTicks);
  EXPECT_FALSE(fs::exists(folder_ / "s.h5.journal"));
  EXPECT_FALSE(repair_session(folder_ / "s.h5"));
}

TEST_F(JournalOfARecording, DoesNotChangeAGoodSessionThatWasCopiedOverItsName) {
  record_and_kill("s.h5", 5);
  for (const bool live : {true, false}) {
    WriterOptions options;
    options.whole_or_nothing = !live;
    {
      SessionWriter writer(folder_ / "good.h5", some_header(), options);
      writer.append(random_ticks(300, 6));
      ASSERT_TRUE(writer.finish({}));
    }
    fs::copy_file(folder_ / "good.h5", folder_ / "s.h5", fs::copy_options::overwrite_existing);
    EXPECT_FALSE(repair_session(folder_ / "s.h5")) << live;
    EXPECT_EQ(read_text(folder_ / "s.h5"), read_text(folder_ / "good.h5")) << live;
    EXPECT_EQ(ticks_of("s.h5"), 300u);
  }
}

TEST_F(JournalOfARecording, OfAnotherRecordingIsNotApplied) {
  record_and_kill("s.h5", 5);
  record_and_kill("other.h5", 6);
  fs::copy_file(folder_ / "other.h5.journal", folder_ / "s.h5.journal", fs::copy_options::overwrite_existing);
  EXPECT_TRUE(repair_session(folder_ / "s.h5"));
  EXPECT_TRUE(same_for_replay(SessionReader(folder_ / "s.h5").ticks().back(), random_ticks(kTicks, 5).back()));
}

TEST_F(JournalOfARecording, WithForgedSizesIsNotAppliedAndNeedsNoMemoryOrDisk) {
  record_and_kill("s.h5", 5);
  const std::string good = read_text(folder_ / "s.h5.journal"), file = read_text(folder_ / "s.h5");
  EXPECT_FALSE(journal_changes(FileBytes(folder_ / "s.h5")).empty());
  const auto refused = [&](const char* what, const std::string& journal) {
    write(folder_ / "s.h5.journal", journal);
    EXPECT_TRUE(journal_changes(FileBytes(folder_ / "s.h5")).empty()) << what;
  };
  const auto with = [&](std::size_t place, std::uint64_t n) {
    std::string journal = good;
    set_number(journal, place, n);
    seal(journal);
    return journal;
  };
  refused("an offset of 4 TiB", with(kChanges, std::uint64_t{1} << 42));
  refused("an offset that overflows", with(kChanges, UINT64_MAX - 3));
  refused("a change of 4 TiB", with(kChanges + 8, std::uint64_t{1} << 42));
  refused("a length of 4 TiB", with(kLength, std::uint64_t{1} << 42));
  refused("a file that was longer", with(kOldLength, file.size() + 1));
  refused("a file that was to become shorter", with(kLength, file.size() - 1));
  std::string other = good;
  other[kRecording] = other[kRecording] == 'a' ? 'b' : 'a';
  seal(other);
  refused("another identity", other);
  for (std::size_t at = 0; at < good.size(); at += 997) {
    std::string damaged = good;
    damaged[at] = static_cast<char>(damaged[at] ^ 1);
    refused("a damaged byte", damaged);
  }
  // A sparse journal of a few kilobytes that claims 4 GB.
  write(folder_ / "s.h5.journal", with(kBytes, std::uint64_t{4} << 30));
  fs::resize_file(folder_ / "s.h5.journal", kChanges + (std::uint64_t{4} << 30));
  rusage before{}, after{};
  getrusage(RUSAGE_SELF, &before);
  EXPECT_TRUE(journal_changes(FileBytes(folder_ / "s.h5")).empty());
  getrusage(RUSAGE_SELF, &after);
  EXPECT_LT(after.ru_maxrss - before.ru_maxrss, 100 * 1024);  // KiB
}

TEST_F(JournalOfARecording, NeverChangesASignedSession) {
  make_key(folder_ / "key");
  record_and_kill("s.h5", 5);
  std::string journal = read_text(folder_ / "s.h5.journal");
  const std::string file = read_text(folder_ / "s.h5");
  sign_session(folder_ / "s.h5", load_key(folder_ / "key"));
  record_and_kill("forged.h5", 6);
  // A forger knows the identity, the length and the checksum.
  const std::string forged = read_text(folder_ / "forged.h5");
  journal.resize(kChanges + 16);
  set_number(journal, kOldLength, file.size());
  set_number(journal, kLength, std::max(file.size(), forged.size()));
  set_number(journal, kBytes, 16 + forged.size());
  set_number(journal, kChanges, 0);
  set_number(journal, kChanges + 8, forged.size());
  journal += forged;
  seal(journal);
  write(folder_ / "s.h5.journal", journal);
  ASSERT_FALSE(journal_changes(FileBytes(folder_ / "s.h5")).empty()) << "this journal is well made";
  EXPECT_THROW(repair_session(folder_ / "s.h5"), Error);
  const OpenedSession session(folder_ / "s.h5");
  require_signature(session, folder_ / "key");
  EXPECT_TRUE(same_for_replay(SessionReader(session).ticks().front(), random_ticks(kTicks, 5).front()));
  EXPECT_EQ(read_text(folder_ / "s.h5"), file);
}

}  // namespace
}  // namespace typodont::session
